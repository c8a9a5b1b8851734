/* The debug views: the map as a cross, and close up at a corner. */
#include "driver.h"

#include <stdio.h>
#include <string.h>

/* The faces of the cross by row and column; -1 is a blank cell. */
static const int cross[3][4] = {{-1, RK_FACE_Y, -1, -1},
                                {RK_FACE_MINUS_X, RK_FACE_MINUS_Z, RK_FACE_X, RK_FACE_Z},
                                {-1, RK_FACE_MINUS_Y, -1, -1}};

static rk_vec3 colour_at(const rk_driver *driver, rk_vec3 direction)
{
    return rk_cubemap_at(&driver->scene.environment, direction, driver->render.environment_filter);
}

/* Replaces the scene by the map, in names and captions as well. */
static void show_map_alone(rk_driver *driver)
{
    const choices *c = driver->choices;
    const char *slash = strrchr(driver->environment, '/');
    const char *own = slash ? slash + 1 : driver->environment;
    bool seam = rk_driver_debug(driver, "seam");
    rk_cubemap map = driver->scene.environment;
    driver->scene.environment = (rk_cubemap){0};
    rk_scene_free(&driver->scene);
    driver->scene.environment = map;
    snprintf(driver->scene.name, sizeof driver->scene.name, "%s",
             seam        ? "random-colours"
             : c->marked ? "marked"
                         : own);
}

/* The cross as large as it fits, in the picture's middle. */
bool draw_cross(rk_driver *driver, rk_error *error)
{
    (void)error;
    show_map_alone(driver);
    float width = (float)driver->image.width, height = (float)driver->image.height;
    float cell = rk_min(width / 4, height / 3);
    for (size_t y = 0; y < driver->image.height; y++)
        for (size_t x = 0; x < driver->image.width; x++) {
            float across = ((float)x + 0.5f - width / 2) / cell + 2;
            float down = ((float)y + 0.5f - height / 2) / cell + 1.5f;
            bool outside = across < 0 || across >= 4 || down < 0 || down >= 3;
            int face = outside ? -1 : cross[(int)down][(int)across];
            *rk_image_at(&driver->image, x, y) =
                face < 0 ? rk_vec(0.02f, 0.02f, 0.02f)
                         : colour_at(driver,
                                     rk_cube_direction((rk_cube_face)face, across - floorf(across),
                                                       1 - (down - floorf(down))));
        }
    return true;
}

/* From the cube's centre to the corner of +x, +y and -z, half a face to each side. */
bool draw_seam(rk_driver *driver, rk_error *error)
{
    (void)error;
    show_map_alone(driver);
    const rk_camera camera = {.distance = 1, .rotation = rk_vec(-35.264f, 135, 0), .fov = 40};
    rk_view view = rk_view_of(&camera, driver->image.width, driver->image.height);
    for (size_t y = 0; y < driver->image.height; y++)
        for (size_t x = 0; x < driver->image.width; x++)
            *rk_image_at(&driver->image, x, y) =
                colour_at(driver, rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f).direction);
    return true;
}
