/* The common options, and the combinations that are refused. */
#include "driver/driver_options.h"

#include "driver/driver_team.h"
#include "driver/implementation_note.h"
#include "features/sah_binning.h"
#include "render/options.h"
#include "scenes/builtin.h"

#include <stdio.h>
#include <string.h>

/* --- Rows ------------------------------------------------------------------------------------ */

RK_NAMES(split_names, rk_accel_kind, RK_ACCEL_WIDE, "median", "sah", "sah3", "collapsed", "morton",
         "wide");

RK_NAMES(up_names, rk_up, RK_UP_OF_FILE, "x", "y", "z", "file");
RK_NAMES(front_names, rk_front, RK_FRONT_MINUS_Z, "usual", "x", "y", "z", "-x", "-y", "-z");

/* The help of --scene, --debug, --pixel and --split depends on the driver, and --move on its scene:
 * see make_common. */
static const rk_option common_rows[] = {
    {"scene", RK_FIELD(rk_driver, scene_name), "NAME", NULL, .initial_text = "cornell",
     .of_scene = true},
    {"mesh", RK_FIELD(rk_driver, mesh_path), "FILE",
     "a mesh file in place of --scene (OBJ, PLY, OFF, glTF ...), seen from the front, which is +z; "
     "it fills two thirds of "
     "the picture at the default --distance and --fov, and its light turns with the camera",
     .of_scene = true},
    {"up", RK_CHOICE(rk_driver, up, up_names),
     "the axis of the mesh file that points up: file is the one that it names, else y; z in most "
     "scans and CAD files; its front is then -y",
     .initial = RK_UP_OF_FILE, .of_scene = true},
    {"front", RK_CHOICE(rk_driver, front, front_names),
     "the axis of the mesh file that points to the viewer: usually z, or -y where z is up; -z in "
     "older OBJ files",
     .initial = RK_FRONT_USUAL, .of_scene = true},
    {"environment", RK_FIELD(rk_driver, environment), "sky|FILE",
     "radiance of rays that hit nothing: the built-in sky, or a picture (JPG, PNG, EXR, HDR ...) "
     "that is a cross (4:3, 3:4), a strip (6:1, 1:6) or longitude and latitude (2:1), or six "
     "pictures: a folder of px.*, nx.* ..., or a name with %s in place of px, nx ...",
     .of_scene = true},
    {"background", RK_FIELD(rk_driver, background), "GREY",
     "the same without --environment: one grey, linear; 0: black", 0, 1, 0, .of_scene = true},
    {"distance", RK_FIELD(rk_driver, camera_given.distance), "D",
     "distance of the camera from its target, world units; by default the scene's own", 1e-3, 1e6,
     NAN},
    {"fov", RK_FIELD(rk_driver, camera_given.fov), "DEG",
     "vertical field of view, degrees; by default the scene's own", 1, 179, NAN},
    {"pitch", RK_FIELD(rk_driver, camera_given.rotation.x), "DEG",
     "rotation of the camera about x, degrees: how far it looks down; by default the scene's own",
     -360, 360, NAN},
    {"yaw", RK_FIELD(rk_driver, camera_given.rotation.y), "DEG",
     "rotation of the camera about y, degrees: how far it goes round; by default the scene's own",
     -360, 360, NAN},
    {"threads", RK_FIELD(rk_driver, threads), "N", "number of threads; 0: one per processor", 0,
     RK_THREADS_MAX, 0, .of_scene = true},
    {"mpi", RK_FIELD(rk_driver, mpi), NULL,
     "render the picture together with the other processes that mpirun has started, each with "
     "--threads",
     .of_scene = true},
    {"runs", RK_FIELD(rk_driver, runs), "N", "number of builds and renderings; timings are medians",
     1, RK_RUNS_MAX, 1, .of_scene = true},
    {"split", RK_CHOICE(rk_driver, split, split_names),
     "the tree: binary, split at the median, or by the surface area heuristic on the longest axis "
     "(sah) or on all three (sah3), whose nodes may get eight children (collapsed); or built with "
     "eight, fast (morton) or fast to trace (wide)", /* see binary_help */
     .initial = RK_ACCEL_WIDE, .of_scene = true},
    {"bins", RK_FIELD(rk_driver, bins), "N", "bins per axis of sah, sah3 and collapsed", 2,
     RK_SAH_BINS_MAX, .of_scene = true},
    {"timing", RK_FIELD(rk_driver, timing), NULL,
     "put timings into DIR/tables instead of drawing a picture", .of_scene = true},
    {"debug", RK_FIELD(rk_driver, debug), "VIEW", NULL, .of_scene = true},
    {"pixel", RK_FIELD(rk_driver, pixel), "X,Y", NULL},
    {"pixel-code", RK_FIELD(rk_driver, pixel_code), NULL,
     "name the lines of C that do what --pixel explains"},
    {"pixel-rays", RK_FIELD(rk_driver, pixel_rays), NULL,
     "say where the rays that --pixel explains begin and end in the picture, in pixels"},
    {"out", RK_FIELD(rk_driver, out), "DIR", "pictures go to DIR/figures, tables to DIR/tables",
     .initial_text = rk_pictures_folder},
    {"compare", RK_FIELD(rk_driver, compared), "FILE",
     "say in how many pixels the picture differs from this one, and draw where"},
    {"quiet", RK_FIELD(rk_driver, quiet), NULL, "no progress bar, no summary"},
    {"move", RK_FIELD(rk_driver, move), NULL,
     "move the whole mesh (with --time-samples), if the scene has no moving object",
     .of_scene = true},
    {0},
};

enum { common_count = sizeof common_rows / sizeof *common_rows };

/* A text of --help with the names of the driver's views. */
typedef struct view_text {
    char text[300];
} view_text;

static view_text list_views(const rk_driver_view *views)
{
    view_text list = {""};
    for (; views && views->name; views++) {
        strncat(list.text, *list.text ? ", " : "", sizeof list.text - strlen(list.text) - 1);
        strncat(list.text, views->name, sizeof list.text - strlen(list.text) - 1);
    }
    return list;
}

static view_text debug_help(const rk_driver_view *views)
{
    view_text help;
    snprintf(help.text, sizeof help.text, "draw a debug view: %.256s", list_views(views).text);
    return help;
}

/* Some drivers draw a pixel's rays. */
static view_text pixel_help(const rk_driver *driver, const rk_driver_view *views)
{
    view_text help = {"explain how this pixel gets its colour; 0,0 is at the top left"};
    size_t length = strlen(help.text);
    for (; views && views->name; views++)
        if (strcmp(views->name, "rays") == 0)
            snprintf(help.text + length, sizeof help.text - length,
                     "; --debug rays draws its rays instead, by default those of the pixel at "
                     "%u %% of the width and %u %% of the height",
                     driver->drawn_x, driver->drawn_y);
    return help;
}

static const char binary_help[] =
    "the tree: split at the median, or by the surface area heuristic on the longest axis (sah) or "
    "on all three (sah3), whose nodes may get eight children (collapsed)";

typedef struct help_texts {
    view_text debug, pixel;
    char scene[2000];
    rk_names split; /* of the trees that the driver shows */
} help_texts;

static help_texts help_for(const rk_driver *driver, const rk_driver_spec *spec)
{
    help_texts texts = {debug_help(spec->views), pixel_help(driver, spec->views), "", split_names};
    if (spec->is_of_binary_trees)
        texts.split.count = RK_ACCEL_COLLAPSED + 1;
    rk_builtin_help(texts.scene, sizeof texts.scene);
    return texts;
}

/* Fills in the help that depends on the driver. --move comes last, and is left out for drivers that
 * move everything anyway. */
static void make_common(rk_option rows[common_count], const rk_driver *driver,
                        const help_texts *texts)
{
    memcpy(rows, common_rows, sizeof common_rows);
    for (rk_option *row = rows; row->name; row++) {
        if (strcmp(row->name, "scene") == 0)
            row->help = texts->scene;
        else if (strcmp(row->name, "debug") == 0)
            row->help = texts->debug.text;
        else if (strcmp(row->name, "pixel") == 0)
            row->help = texts->pixel.text;
        else if (strcmp(row->name, "split") == 0 && texts->split.count < split_names.count)
            row->names = &texts->split, row->help = binary_help;
        else if (strcmp(row->name, "move") == 0 && driver->move)
            row->name = NULL;
    }
}

/* --- Defaults -------------------------------------------------------------------------------- */

rk_driver rk_driver_default(const char *feature, const char *summary)
{
    rk_driver driver = {
        .feature = feature,
        .summary = summary,
        .render = rk_render_options_default(),
        .drawn_x = 50,
        .drawn_y = 50,
        .motion = rk_motion_default(),
    };
    rk_options_set_defaults(common_rows, &driver);
    driver.bins = rk_sah_options_default().bins;
    return driver;
}

void rk_driver_set_defaults(rk_driver *driver, const rk_driver_spec *spec)
{
    driver->choices = spec->choices;
    if (spec->options)
        rk_options_set_defaults(spec->options, spec->choices);
    if (spec->set_defaults)
        spec->set_defaults(driver);
}

/* --- Combinations ---------------------------------------------------------------------------- */

static bool check_debug_view(const rk_driver *driver, const rk_driver_view *views, rk_error *error)
{
    if (!driver->debug)
        return true;
    for (const rk_driver_view *view = views; view && view->name; view++)
        if (rk_driver_debug(driver, view->name))
            return true;
    return rk_fail(error, "--debug %.80s: there is no such view: choose one of %.256s",
                   driver->debug, list_views(views).text);
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

static bool goes_with(const char *views, const char *debug)
{
    if (!views)
        return true;
    for (const char *view = debug ? strstr(views, debug) : NULL; view;
         view = strstr(view + 1, debug)) {
        const char after = view[strlen(debug)];
        if ((view == views || view[-1] == ' ') && (after == ' ' || after == '\0'))
            return true;
    }
    return false;
}

/* Options of a view are refused in others, where they would change nothing. */
static bool check_options_of_views(const rk_driver *driver, const rk_option *rows, rk_error *error)
{
    const rk_option_table table = {rows, NULL};
    for (char **argument = driver->argv; rows && *argument; argument++) {
        const rk_option *row = rk_options_find(&table, 1, *argument);
        if (row && !goes_with(row->views, driver->debug))
            return rk_fail(error, "--%s goes with --debug %s", row->name, row->views);
    }
    return true;
}

static bool check(const rk_driver *driver, const rk_driver_view *views, const char *usual_scene,
                  rk_error *error)
{
    if (driver->mesh_path && driver->scene_name != usual_scene)
        return rk_fail(error, "--scene and --mesh: choose one of them");
    if (driver->up != RK_UP_OF_FILE && !driver->mesh_path)
        return rk_fail(error, "--up: turns a mesh file; name one by --mesh");
    if (driver->front != RK_FRONT_USUAL && !driver->mesh_path)
        return rk_fail(error, "--front: turns a mesh file; name one by --mesh");
    if (rk_front_is_up((rk_front)driver->front, (rk_up)driver->up))
        return rk_fail(error, "--front %s: that axis points up; choose another one, or --up",
                       front_names.items[driver->front]);
    if (driver->environment && driver->background > 0)
        return rk_fail(error, "--environment and --background: choose one of them");
    if (driver->timing && driver->debug)
        return rk_fail(error,
                       "--timing and --debug: choose one of them; --timing draws no picture");
    return check_debug_view(driver, views, error) && check_pixel(driver, error) &&
           rk_render_options_check_command(&driver->render, error);
}

/* --- Reading --------------------------------------------------------------------------------- */

static void add(rk_driver_tables *all, const rk_option *rows, void *values)
{
    if (rows)
        all->tables[all->count++] = (rk_option_table){rows, values};
}

/* `common` is the table that make_common made. */
static rk_driver_tables all_tables(rk_driver *driver, const rk_driver_spec *spec,
                                   const rk_option *common)
{
    rk_driver_tables all = {.count = 0};
    add(&all, spec->driver_options, driver);
    add(&all, spec->options, spec->choices);
    add(&all, common, driver);
    const rk_render_option_tables render = rk_render_options_tables(&driver->render);
    for (size_t i = 0; i < render.count; i++)
        add(&all, render.tables[i].rows, &driver->render);
    return all;
}

rk_options_result rk_driver_read_options(rk_driver *driver, const rk_driver_spec *spec, int argc,
                                         char **argv, rk_error *error)
{
    const char *usual_scene = driver->scene_name;
    const help_texts texts = help_for(driver, spec);
    rk_option common[common_count];
    make_common(common, driver, &texts);
    const rk_driver_tables all = all_tables(driver, spec, common);
    driver->argv = argv;
    driver->render_usual = driver->render;
    rk_options_result result =
        rk_options_parse(argc, argv, driver->summary, all.tables, all.count, error);
    rk_driver_note_command(driver, &all);
    if (result == RK_OPTIONS_OK && (!check(driver, spec->views, usual_scene, error) ||
                                    !check_options_of_views(driver, spec->options, error) ||
                                    !rk_driver_check_team(driver, spec, error)))
        return RK_OPTIONS_BAD;
    return result;
}
