/* All drivers as one WebAssembly module: argv[0] is the driver's name, such as bloom. What a page
 * needs beside the printed text goes to functions of the page, imported from the module raykit. */
#include "driver/driver_main.h"
#include "driver/driver_options.h"
#include "driver/unsolved.h"
#include "mean.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wasi/api.h>

#define IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* How the run ended: the camera, in the units of its options, and the time. */
IMPORT("finish")
void raykit_finish(double yaw, double pitch, double distance, double build_ms, double render_ms);

/* Scene and tree are kept: draw_kept draws further pictures of them. */
IMPORT("keep") void raykit_keep(void);

#define RK_FEATURE(stem) int rk_live_##stem(int argc, char **argv);
#include "features/list.h"
#undef RK_FEATURE

int main(int argc, char **argv)
{
#define RK_FEATURE(stem)                                                                           \
    if (strcmp(argv[0], #stem) == 0)                                                               \
        return rk_live_##stem(argc, argv);
#include "features/list.h"
    fprintf(stderr, "%s: there is no such driver\n", argv[0]);
    return 2;
}

/* --- pictures of a scene that is kept ----------------------------------------------------------
 */

static struct {
    const rk_driver_spec *spec;
    rk_driver driver, begun; /* the one that draws, and as it was when scene and tree were made */
} kept;

/* Is the camera where the options and the scene say, or has the driver a view of its own? */
static bool follows_options(rk_driver *driver)
{
    const rk_camera now = driver->scene.camera;
    rk_driver_aim(driver);
    const bool follows = memcmp(&now, &driver->scene.camera, sizeof now) == 0;
    driver->scene.camera = now;
    return follows;
}

/* A study may change the scene. */
static bool wants_study(const rk_driver_spec *spec)
{
    for (const rk_driver_study *study = spec->studies; study && study->wanted; study++)
        if (*study->wanted)
            return true;
    return false;
}

static void tell_camera(const rk_driver *driver)
{
    const rk_camera *camera = &driver->scene.camera;
    raykit_finish(camera->rotation.y, camera->rotation.x, camera->distance, driver->build_ms.median,
                  driver->render_ms.median);
}

/* As rk_driver_finish, but nothing is freed: the page may ask for a further picture. */
static int finish_kept(void)
{
    const rk_image image = kept.driver.image;
    tell_camera(&kept.driver);
    rk_driver_note_unsolved(&kept.driver);
    fflush(stdout);
    kept.driver = kept.begun;
    kept.driver.image = image;
    raykit_keep();
    return 0;
}

int __wrap_rk_driver_main(const rk_driver_spec *spec, int argc, char **argv);

/* As rk_driver_main, but the driver outlives it. */
int __wrap_rk_driver_main(const rk_driver_spec *spec, int argc, char **argv)
{
    rk_error error = {""};
    rk_driver *driver = &kept.driver;
    const rk_options_result result = rk_driver_begin(spec, driver, argc, argv, &error);
    kept.spec = spec;
    kept.begun = *driver;
    const bool keeps = result == RK_OPTIONS_OK && !wants_study(spec) && follows_options(driver);
    const bool ok = result == RK_OPTIONS_DONE ||
                    (result == RK_OPTIONS_OK && rk_driver_draw(spec, driver, &error));
    return ok && keeps ? finish_kept() : rk_driver_finish(driver, ok, &error);
}

/* The words of the page's command line, NULL without memory. */
static char **read_arguments(int *count)
{
    size_t words, size;
    if (__wasi_args_sizes_get(&words, &size) != 0)
        return NULL;
    char **argv = malloc((words + 1) * sizeof *argv + size);
    if (!argv || __wasi_args_get((uint8_t **)argv, (uint8_t *)(argv + words + 1)) != 0) {
        free(argv);
        return NULL;
    }
    argv[words] = NULL;
    *count = (int)words;
    return argv;
}

/* Options by the command line; the scene and what is made of it are kept. */
static bool begin_again(rk_driver *driver, int argc, char **argv, rk_error *error)
{
    const rk_driver made = *driver;
    rk_image_free(&driver->image);
    *driver = rk_driver_default(kept.spec->feature, kept.spec->summary);
    rk_driver_set_defaults(driver, kept.spec);
    const bool ok =
        argv && rk_driver_read_options(driver, kept.spec, argc, argv, error) == RK_OPTIONS_OK;
    driver->scene = made.scene, driver->camera_own = made.camera_own;
    driver->accel = made.accel, driver->unfinished = made.unfinished;
    driver->framed = made.framed, driver->build_ms = made.build_ms;
    driver->pool = made.pool;
    if (!ok || !rk_driver_begin_again(kept.spec, driver, error))
        return false;
    kept.begun = *driver;
    return true;
}

/* `above` is not used: the driver's main has returned, and its variables, which the spec names, are
 * still where it had them on the stack. */
__attribute__((noinline)) static int draw_below(char *above)
{
    above[0] = 0; /* or nothing would be reserved */
    rk_error error = {""};
    int argc = 0;
    char **argv = read_arguments(&argc);
    const bool begun = begin_again(&kept.driver, argc, argv, &error);
    const bool keeps = begun && !wants_study(kept.spec) && follows_options(&kept.driver);
    const bool ok = begun && rk_driver_draw(kept.spec, &kept.driver, &error);
    const int status = ok && keeps ? finish_kept() : rk_driver_finish(&kept.driver, ok, &error);
    free(argv);
    return status;
}

__attribute__((export_name("draw_kept"))) int draw_kept(rk_mean_part part);

/* Draws the scene that is kept, by a command line with the same options of_scene. Anything but 0:
 * it is freed. */
int draw_kept(rk_mean_part part)
{
    char above[1 << 18];
    rk_mean_set_part(part);
    return draw_below(above);
}

/* --- around functions of the kit (wasm-ld --wrap) --------------------------------------------- */

int __real_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);
int __wrap_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);

int __wrap_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error)
{
    tell_camera(driver);
    return __real_rk_driver_finish(driver, ok, error);
}
