/* rk_driver_start of driver/driver.h: from the options to a scene, a picture and threads. */
#include "driver/driver.h"
#include "driver/driver_team.h"
#include "io/environment_file.h"
#include "io/mesh_file.h"
#include "scenes/builtin.h"
#include "scenes/sky.h"

#include <stdio.h>
#include <string.h>

/* Returns `given`, or the scene's own value if it is NaN. */
static float or_own(float given, float own)
{
    return isnan(given) ? own : given;
}

/* Texels; so fine that the sun looks round. */
enum { SKY_SIDE = 256 };

/* Texels per side of a face that are half as wide as the picture's pixels in the middle of the
 * view: a face's middle has side / 2 of them per unit of tangent. All of them if they are to be
 * seen. */
static uint32_t needed_side(const rk_driver *driver)
{
    const double tangent = tan((double)driver->scene.camera.fov * (double)RK_PI / 360);
    const double side = 2 * (double)driver->render.height / tangent;
    return driver->render.environment_filter == RK_CUBEMAP_NEAREST || side > 1e6
               ? 0
               : (uint32_t)ceil(side);
}

/* The middle of a panorama is in direction -z, its seam at +z, where scenes' cameras look. Half a
 * turn takes the seam behind the camera. */
static bool load_environment(rk_driver *driver, rk_error *error)
{
    const char *name = driver->environment;
    rk_cubemap *environment = &driver->scene.environment;
    if (!name)
        return true;
    if (*name == '\0')
        return rk_fail(error, "--environment: names no picture; give it a file's name, or sky");
    if (strcmp(name, "sky") == 0)
        return rk_sky_make(environment, SKY_SIDE, error);
    if (!rk_environment_file_read_for(environment, name, needed_side(driver), error))
        return false;
    rk_cubemap_turn(environment);
    return true;
}

/* Strays are told, and how large they make the mesh. */
static void note_strays(const rk_driver *driver)
{
    const uint32_t all = driver->scene.mesh.triangle_count, framed = driver->framed.triangles;
    if (framed < all && rk_driver_speaks(driver))
        fprintf(
            stderr,
            "%s: %s: %u of its %u triangles lie in %.2g %% of its extent; the picture is framed by "
            "these, so that others may reach beyond its border\n",
            driver->feature, driver->scene.name, framed, all, 100 * driver->framed.extent);
}

static bool load_mesh(rk_driver *driver, rk_error *error)
{
    rk_mesh mesh;
    const char *slash = strrchr(driver->mesh_path, '/');
    const rk_camera *given = &driver->camera_given;
    rk_framing framing = rk_framing_default();
    framing.up = driver->up;
    framing.front = driver->front;
    framing.rotation = rk_vec(or_own(given->rotation.x, framing.rotation.x),
                              or_own(given->rotation.y, framing.rotation.y), framing.rotation.z);
    framing.width = driver->render.width, framing.height = driver->render.height;
    if (!rk_mesh_file_read(&mesh, driver->mesh_path, error))
        return false;
    if (*error->text &&
        rk_driver_speaks(driver)) /* a note, also with --quiet: the picture lacks something */
        fprintf(stderr, "%s: %s\n", driver->feature, error->text);
    if (!rk_scene_framed(&driver->scene, slash ? slash + 1 : driver->mesh_path, &mesh, &framing,
                         &driver->framed, error))
        return false;
    note_strays(driver);
    return true;
}

void rk_driver_aim(rk_driver *driver)
{
    const rk_camera *own = &driver->camera_own, *given = &driver->camera_given;
    driver->scene.camera.distance = or_own(given->distance, own->distance);
    driver->scene.camera.fov = or_own(given->fov, own->fov);
    driver->scene.camera.rotation =
        rk_vec(or_own(given->rotation.x, own->rotation.x),
               or_own(given->rotation.y, own->rotation.y), own->rotation.z);
}

static bool load_scene(rk_driver *driver, rk_error *error)
{
    rk_error why = {""};
    if (driver->mesh_path && !load_mesh(driver, error))
        return false;
    if (!driver->mesh_path && !rk_builtin_scene(&driver->scene, driver->scene_name, &why))
        return rk_fail(error, "--scene %.1000s", why.text);
    if (driver->move && driver->scene.moving_count == 0)
        rk_scene_move_mesh(&driver->scene, driver->motion);
    driver->scene.background = driver->background;
    driver->camera_own = driver->scene.camera;
    rk_driver_aim(driver);
    return true;
}

bool rk_driver_start(rk_driver *driver, rk_error *error)
{
    rk_progress progress;
    rk_progress_say(&progress, "making the scene", driver->quiet);
    bool ok = (!rk_driver_speaks(driver) || rk_driver_try_folder(driver, error)) &&
              load_scene(driver, error) && load_environment(driver, error) &&
              rk_image_init(&driver->image, driver->render.width, driver->render.height, error) &&
              (driver->pool = rk_pool_start(driver->threads, error)) != NULL;
    rk_progress_end(&progress);
    return ok;
}
