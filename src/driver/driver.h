/* What all drivers share: the scene, rendering with a progress bar, pictures with their parameters,
 * timing rows. driver_main.h has their main. */
#ifndef RK_DRIVER_DRIVER_H
#define RK_DRIVER_DRIVER_H

#include "base/options.h"
#include "base/table.h"
#include "driver/overlay.h"
#include "render/render.h"

typedef struct rk_driver {
    const char *feature; /* "bvh_median": begins the names of pictures and tables */
    const char *summary; /* the first lines of --help */
    void *choices;       /* the driver's own options */

    /* common options */
    rk_render_options render;
    uint32_t threads; /* 0: all processors */
    uint32_t runs;    /* timings are medians of this many */
    rk_accel_kind split;
    uint32_t bins; /* on an axis, of the kinds that have some */
    const char *scene_name;
    const char *mesh_path;   /* NULL: the built-in scene */
    const char *environment; /* NULL: none; "sky", or files as in io/environment_file.h */
    const char *out;
    const char *debug; /* NULL, or the name of a view */
    rk_pixel pixel;
    uint32_t drawn_x, drawn_y; /* per cent of the picture: where --debug rays looks by default */
    bool quiet;
    bool timing;            /* put rows into the table, draw no picture */
    rk_camera camera_given; /* what the user set; NaN elsewhere: the scene's own */
    bool move;              /* the whole mesh moves, if nothing in the scene moves by itself */
    rk_motion motion;       /* and this is its path */

    char **argv;                    /* the command line, ended by NULL */
    char parameters[1024];          /* the same for captions */
    rk_render_options render_usual; /* the renderer's options without it */

    /* from rk_driver_start on */
    rk_scene scene;
    rk_accel accel;
    rk_pool *pool;
    rk_image image;
    rk_counters counters;
    rk_timing build_ms, render_ms;
} rk_driver;

/* The common defaults. */
rk_driver rk_driver_default(const char *feature, const char *summary);

/* Loads the scene and starts the threads, as the options say. */
bool rk_driver_start(rk_driver *driver, rk_error *error);

/* Who cannot save need not render: tries to begin a file where one will be wanted. */
bool rk_driver_try_folder(const rk_driver *driver, rk_error *error);

/* Builds the acceleration structure, `runs` times. */
bool rk_driver_build(rk_driver *driver, rk_error *error);

/* Narrates --pixel, and renders into driver->image, `runs` times. */
bool rk_driver_render(rk_driver *driver, rk_error *error);

/* Is this the debug view that was asked for? */
bool rk_driver_debug(const rk_driver *driver, const char *view);

/* The pixel whose rays a debug view draws becomes driver->pixel: --pixel, or the one at drawn_x and
 * drawn_y. It is drawn then, and not told. */
void rk_driver_draw_pixel(rk_driver *driver);

/* Writes the picture to OUT/figures/FEATURE_SCENE[_LABEL].png, label being the debug view and its
 * number, or NULL, and prints a line for its caption. */
bool rk_driver_save(rk_driver *driver, const char *label, rk_error *error);

/* Makes OUT/tables if it is missing, and fills in the path of NAME.csv there. */
bool rk_driver_table(const rk_driver *driver, const char *name, char path[4096], rk_error *error);

/* Puts a figure into OUT/tables/FEATURE.csv. */
bool rk_driver_row(rk_driver *driver, const char *metric, const char *unit, rk_timing timing,
                   rk_error *error);

/* A figure that was measured once, or counted. */
rk_timing rk_timing_once(double figure);

/* Frees everything; prints `error` if `ok` is false. Returns the exit status. */
int rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);

#endif
