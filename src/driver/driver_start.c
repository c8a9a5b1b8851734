/* From the command line to a scene: what all drivers take, and what does not go together. */
#include "driver/driver.h"
#include "features/sah_binning.h"
#include "io/environment_file.h"
#include "io/mesh_file.h"
#include "render/options.h"
#include "scenes/builtin.h"
#include "scenes/sky.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Adds to the caption's command line, as far as it fits. */
static void note(rk_driver *driver, const char *text, size_t length)
{
    size_t used = strlen(driver->parameters), room = sizeof driver->parameters - 1 - used;
    length = length < room ? length : room;
    memcpy(driver->parameters + used, text, length);
    driver->parameters[used + length] = '\0';
}

/* The command line from the program's bare name on, files without their folders: it stands in
 * captions, where nobody needs to know the machine's folders. */
static void note_parameters(rk_driver *driver, int argc, char **argv)
{
    for (int i = 0; i < argc; i++) {
        const char *equals = strncmp(argv[i], "--", 2) == 0 ? strchr(argv[i], '=') : NULL;
        const char *value = equals ? equals + 1 : argv[i];
        bool is_out =
            strncmp(argv[i], "--out=", 6) == 0 || (i && strcmp(argv[i - 1], "--out") == 0);
        const char *slash = strrchr(value, '/');
        const char *shown = is_out ? "DIR" : slash ? slash + 1 : value;
        note(driver, " ", i > 0);
        note(driver, argv[i], (size_t)(value - argv[i]));
        note(driver, shown, strlen(shown));
    }
}

/* What --help and complaints say of the views. */
typedef struct view_list {
    char text[256];
} view_list;

static view_list list_views(const char *const *views)
{
    view_list list = {""};
    for (int i = 0; views[i]; i++) {
        strncat(list.text, i ? ", " : "", sizeof list.text - strlen(list.text) - 1);
        strncat(list.text, views[i], sizeof list.text - strlen(list.text) - 1);
    }
    return list;
}

/* What --pixel does, in a driver that draws a pixel's rays and in one that does not. */
static view_list pixel_help(const rk_driver *driver, const char *const *views)
{
    view_list help = {"tell how this pixel gets its colour; 0,0 is at the top left"};
    for (int i = 0; views[i]; i++)
        if (strcmp(views[i], "rays") == 0) {
            size_t length = strlen(help.text);
            snprintf(help.text + length, sizeof help.text - length,
                     "; --debug rays draws its rays instead, and without --pixel those of the "
                     "pixel at %u %% of the width and %u %% of the height",
                     driver->drawn_x, driver->drawn_y);
        }
    return help;
}

static bool check_debug_view(const rk_driver *driver, const char *const *views, rk_error *error)
{
    if (!driver->debug)
        return true;
    for (int i = 0; views[i]; i++)
        if (rk_driver_debug(driver, views[i]))
            return true;
    return rk_fail(error, "--debug %.80s: there is no such view: choose one of %s", driver->debug,
                   list_views(views).text);
}

static bool check_pixel(const rk_driver *driver, rk_error *error)
{
    if (driver->pixel.given &&
        (driver->pixel.x >= driver->render.width || driver->pixel.y >= driver->render.height))
        return rk_fail(
            error,
            "--pixel %u,%u: the picture has %u x %u pixels, counted from 0,0 at the top left",
            driver->pixel.x, driver->pixel.y, driver->render.width, driver->render.height);
    return true;
}

/* Returns given, or the scene's own value where nothing was given. */
static float or_own(float given, float own)
{
    return isnan(given) ? own : given;
}

/* Fine enough for the sun's edge to be round. */
enum { SKY_SIDE = 256 };

static bool load_environment(rk_driver *driver, rk_error *error)
{
    const char *name = driver->environment;
    if (!name)
        return true;
    if (*name == '\0')
        return rk_fail(error, "--environment: names no picture; give it a file's name, or sky");
    return strcmp(name, "sky") == 0
               ? rk_sky_make(&driver->scene.environment, SKY_SIDE, error)
               : rk_environment_file_read(&driver->scene.environment, name, error);
}

static bool load_scene(rk_driver *driver, rk_error *error)
{
    if (driver->mesh_path) {
        rk_mesh mesh;
        const char *slash = strrchr(driver->mesh_path, '/');
        if (!rk_mesh_file_read(&mesh, driver->mesh_path, error))
            return false;
        if (*error->text && !driver->quiet) /* a note */
            fprintf(stderr, "%s: %s\n", driver->feature, error->text);
        if (!rk_scene_around(&driver->scene, slash ? slash + 1 : driver->mesh_path, &mesh, error))
            return false;
    } else {
        rk_error why = {""};
        if (!rk_builtin_scene(&driver->scene, driver->scene_name, &why))
            return rk_fail(error, "--scene %.1000s", why.text);
    }
    if (driver->move && driver->scene.moving_count == 0)
        rk_scene_move_mesh(&driver->scene, driver->motion);
    rk_camera *own = &driver->scene.camera;
    const rk_camera *given = &driver->camera_given;
    own->distance = or_own(given->distance, own->distance);
    own->fov = or_own(given->fov, own->fov);
    own->rotation = rk_vec(or_own(given->rotation.x, own->rotation.x),
                           or_own(given->rotation.y, own->rotation.y), own->rotation.z);
    return true;
}

bool rk_driver_start(rk_driver *driver, int argc, char **argv, const rk_option *own_options,
                     const char *const *debug_views, int *status)
{
    const char *shown_scene = driver->scene_name;
    char scene_help[2000], debug_help[300];
    rk_builtin_help(scene_help, sizeof scene_help);
    snprintf(debug_help, sizeof debug_help, "draw a debug view: %s", list_views(debug_views).text);
    const view_list of_pixel = pixel_help(driver, debug_views);
    const rk_option common[] = {
        {"scene", RK_OPTION_TEXT, &driver->scene_name, "NAME", scene_help, 0, 0},
        {"mesh", RK_OPTION_TEXT, &driver->mesh_path, "FILE",
         "a mesh file instead (OBJ, PLY, OFF, glTF ...), moved into the unit ball", 0, 0},
        {"environment", RK_OPTION_TEXT, &driver->environment, "sky|FILE",
         "what is seen where nothing is met: the built-in sky, or a picture (JPG, PNG, EXR, HDR "
         "...) that is a cross (4:3, 3:4), a strip (6:1, 1:6) or longitude and latitude (2:1), or "
         "six: a folder of px.*, nx.* ..., or a name with %s in their place",
         0, 0},
        {"distance", RK_OPTION_FLOAT, &driver->camera_given.distance, "D",
         "of the camera from the point it looks at, world units; by default the scene's own", 1e-3,
         1e6},
        {"fov", RK_OPTION_FLOAT, &driver->camera_given.fov, "DEG",
         "vertical field of view, degrees; by default the scene's own", 1, 179},
        {"pitch", RK_OPTION_FLOAT, &driver->camera_given.rotation.x, "DEG",
         "the camera's turn about x, degrees: how far it looks down; by default the scene's own",
         -360, 360},
        {"yaw", RK_OPTION_FLOAT, &driver->camera_given.rotation.y, "DEG",
         "the camera's turn about y, degrees: how far it goes round; by default the scene's own",
         -360, 360},
        {"threads", RK_OPTION_UINT, &driver->threads, "N",
         "that share the work; 0: as many as there are processors", 0, RK_THREADS_MAX},
        {"runs", RK_OPTION_UINT, &driver->runs, "N",
         "build and render so many times; timings are medians", 1, RK_RUNS_MAX},
        {"split", RK_OPTION_CHOICE, &driver->split, "median|sah|sah3",
         "nodes of the tree: sah by the surface area heuristic on the longest axis, sah3 on all "
         "three",
         0, 0},
        {"bins", RK_OPTION_UINT, &driver->bins, "N", "that sah and sah3 count triangles into", 2,
         RK_SAH_BINS_MAX},
        {"timing", RK_OPTION_FLAG, &driver->timing, NULL,
         "put timings into DIR/tables instead of drawing a picture", 0, 0},
        {"debug", RK_OPTION_TEXT, &driver->debug, "VIEW", debug_help, 0, 0},
        {"pixel", RK_OPTION_PIXEL, &driver->pixel, "X,Y", of_pixel.text, 0, 0},
        {"out", RK_OPTION_TEXT, &driver->out, "DIR",
         "pictures go to DIR/figures, tables to DIR/tables", 0, 0},
        {"quiet", RK_OPTION_FLAG, &driver->quiet, NULL, "no progress bar, no summary", 0, 0},
        /* Last: where everything moves anyway there is no such option, and the table ends here. */
        {driver->move ? NULL : "move", RK_OPTION_FLAG, &driver->move, NULL,
         "the whole mesh moves (with --time-samples), if nothing in the scene moves by itself", 0,
         0},
        {NULL, RK_OPTION_FLAG, NULL, NULL, NULL, 0, 0},
    };
    const rk_option_table render = rk_render_option_table(&driver->render);
    const rk_option *const tables[] = {own_options, common, render.options};
    rk_error error = {""};
    rk_options_result result = rk_options_parse(argc, argv, driver->summary, tables, 3, &error);
    bool ok = result == RK_OPTIONS_OK;
    if (ok && driver->mesh_path && driver->scene_name != shown_scene)
        ok = rk_fail(&error, "--scene and --mesh: choose one of them");
    if (ok && driver->timing && driver->debug)
        ok = rk_fail(&error, "--timing and --debug: choose one of them; --timing draws no picture");
    ok = ok && check_debug_view(driver, debug_views, &error) && check_pixel(driver, &error) &&
         rk_render_options_check(&driver->render, &error);
    note_parameters(driver, argc, argv);
    rk_progress progress;
    rk_progress_say(&progress, "making the scene", driver->quiet || !ok);
    ok = ok && rk_driver_try_folder(driver, &error) && load_scene(driver, &error) &&
         load_environment(driver, &error) &&
         rk_image_init(&driver->image, driver->render.width, driver->render.height, &error) &&
         (driver->pool = rk_pool_start(driver->threads, &error)) != NULL;
    rk_progress_end(&progress);
    if (ok)
        return true;
    *status = rk_driver_finish(driver, result == RK_OPTIONS_DONE, &error);
    return false;
}
