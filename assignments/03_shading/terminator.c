/* The table of --terminator: the error along the edge of a ball's shadow, where shadow rays that
 * start on its faces find none of the light. The truth is a ball of so many faces that it is round.
 */
#include "driver.h"

#include "scenes/builtin.h"

#include <stdio.h>

typedef enum start { FACES, SURFACE, TRUTH, starts } start;

/* The driver's options, camera and lights. */
static bool render(rk_image *image, const rk_driver *driver, const char *name, bool face_shadows,
                   rk_error *error)
{
    rk_render_options options = driver->render;
    rk_counters counters;
    rk_scene scene;
    rk_accel accel;
    options.shadows = true;
    options.face_shadows = face_shadows;
    if (!rk_builtin_scene(&scene, name, error))
        return false;
    scene.camera = driver->scene.camera;
    bool ok = rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, error);
    if (ok) {
        ok = rk_render(image, &scene, &accel, &options, driver->pool, &counters, NULL, error);
        rk_accel_free(&accel);
    }
    rk_scene_free(&scene);
    return ok;
}

/* The mean difference of the pixels that are black only if shadow rays start on the faces. */
static double error_of(const rk_image images[starts], start which, size_t *pixels)
{
    double sum = 0;
    *pixels = 0;
    for (size_t i = 0; i < images[TRUTH].width * images[TRUTH].height; i++) {
        const float black = images[FACES].pixels[i].x, lit = images[SURFACE].pixels[i].x;
        if (black > 0 || !(lit > 0))
            continue;
        sum += fabs((double)images[which].pixels[i].x - (double)images[TRUTH].pixels[i].x);
        ++*pixels;
    }
    return *pixels ? sum / (double)*pixels : 0;
}

static bool put_row(const char *path, const rk_image images[starts], start which, rk_error *error)
{
    static const char *const header[] = {"start", "pixels", "error", NULL};
    char cells[2][32];
    size_t pixels;
    snprintf(cells[1], sizeof cells[1], "%.4g", error_of(images, which, &pixels));
    snprintf(cells[0], sizeof cells[0], "%zu", pixels);
    const char *row[] = {which == FACES ? "faces" : "surface", cells[0], cells[1]};
    return rk_table_put(path, header, row, 3, 1, error);
}

bool put_terminator(rk_driver *driver, rk_error *error)
{
    const char *const scenes[starts] = {driver->scene_name, driver->scene_name, "sphere:81920"};
    const rk_render_options *options = &driver->render;
    rk_image images[starts] = {{0}};
    char path[4096];
    bool ok = rk_driver_table(driver, "shading_terminator", path, error);
    for (int i = 0; ok && i < starts; i++)
        ok = rk_image_init(&images[i], options->width, options->height, error) &&
             render(&images[i], driver, scenes[i], i == FACES, error);
    ok = ok && put_row(path, images, FACES, error) && put_row(path, images, SURFACE, error);
    for (int i = 0; i < starts; i++)
        rk_image_free(&images[i]);
    return ok;
}
