/* The common parts of all drivers: the scene, rendering with a progress bar, pictures with their
 * parameters, timing rows. Their main is in driver_main.h. */
#ifndef RK_DRIVER_DRIVER_H
#define RK_DRIVER_DRIVER_H

#include "base/options.h"
#include "base/table.h"
#include "driver/overlay.h"
#include "render/ray_record.h"
#include "render/render.h"
#include "scene/framing.h"

/* What a picture's false colours mean. The book shows it as a bar below the picture. */
enum { RK_DRIVER_SCALE_COLOURS = 9 };

typedef struct rk_driver_scale {
    const char *unit; /* such as "samples per pixel"; NULL: the colours are no numbers */
    double least, most;
    bool logarithmic;
    bool clipped;                             /* some values are beyond `most` */
    rk_vec3 colours[RK_DRIVER_SCALE_COLOURS]; /* linear, from `least` to `most` at equal steps */
} rk_driver_scale;

typedef struct rk_driver {
    const char *feature; /* "bvh_median": begins the names of pictures and tables */
    const char *summary; /* the first lines of --help */
    void *choices;       /* the driver's own options */

    /* common options */
    rk_render_options render;
    uint32_t threads; /* 0: all processors */
    bool mpi;         /* render together with the processes that mpirun has started */
    uint32_t runs;    /* builds and renderings; timings are medians */
    rk_accel_kind split;
    uint32_t bins; /* per axis; of the kinds with bins */
    const char *scene_name;
    const char *mesh_path;   /* NULL: the built-in scene */
    uint32_t up;             /* an rk_up: of the mesh file */
    uint32_t front;          /* an rk_front: of the mesh file */
    const char *environment; /* NULL: none; "sky", or files as in io/environment_file.h */
    float background;        /* grey of rays that hit nothing, if there is no environment */
    const char *out;
    const char *debug;    /* NULL, or the name of a view */
    const char *compared; /* NULL, or a picture to compare with */
    rk_pixel pixel;
    bool pixel_code;           /* name the C of each step that --pixel explains */
    bool pixel_rays;           /* say where the rays that it explains are in the picture */
    uint32_t drawn_x, drawn_y; /* per cent of the picture: the default pixel of --debug rays */
    bool quiet;
    bool timing;            /* put rows into the table, draw no picture */
    rk_camera camera_given; /* by the user; NaN: the scene's own */
    bool move;              /* the whole mesh, if the scene has no moving object */
    rk_motion motion;       /* the path of the mesh */

    char **argv;                    /* the command line; NULL ends it */
    char parameters[1024];          /* the command line for captions */
    rk_render_options render_usual; /* the renderer's options without the command line */

    /* from rk_driver_start on */
    rk_scene scene;
    rk_camera camera_own; /* the scene's, without the command line */
    rk_framed framed;     /* of the mesh file */
    rk_accel accel;
    rk_accel unfinished; /* its trees find nothing: `accel` has others, see rk_driver_build */
    rk_pool *pool;
    rk_team team;          /* see driver/driver_team.h; zeroed without --mpi */
    uint32_t team_threads; /* of all its processes */
    rk_image image;
    rk_driver_scale scale;
    rk_counters counters;
    rk_ray_record record; /* of rk_driver_record_pixel */
    rk_timing build_ms, render_ms;
} rk_driver;

/* The common defaults. */
rk_driver rk_driver_default(const char *feature, const char *summary);

/* Loads the scene and starts the threads by the options. */
bool rk_driver_start(rk_driver *driver, rk_error *error);

/* Points the scene's camera as the options say, and for the rest as the scene has it. */
void rk_driver_aim(rk_driver *driver);

/* Tries to begin a file in the output folder, so that an error comes before the rendering. */
bool rk_driver_try_folder(const rk_driver *driver, rk_error *error);

/* Builds the acceleration structure, `runs` times. If it finds no triangles, because a student has
 * not solved it yet, that of RK_ACCEL_WIDE is traced, and a note says so. */
bool rk_driver_build(rk_driver *driver, rk_error *error);

/* The tree over static triangles for debug views: the one that was built, whether it finds
 * triangles or not. */
const rk_bvh *rk_driver_tree(const rk_driver *driver);

/* Are rays traced through another tree than the one that was built, see rk_driver_build? */
bool rk_driver_has_stand_in(const rk_driver *driver);

/* Explains --pixel, and renders into driver->image, `runs` times. */
bool rk_driver_render(rk_driver *driver, rk_error *error);

/* The same, and begins an overlay on the picture, which the caller frees. */
bool rk_driver_render_overlay(rk_driver *driver, rk_overlay *overlay, rk_error *error);

/* Is this the view of --debug? */
bool rk_driver_debug(const rk_driver *driver, const char *view);

/* Sets driver->pixel to the pixel whose rays a debug view draws: --pixel, or the one at drawn_x and
 * drawn_y. Its rays are drawn, not explained. */
void rk_driver_draw_pixel(rk_driver *driver);

/* Records the rays of that pixel in driver->record, of the driver's scene and options or of some
 * with less light. */
bool rk_driver_record_pixel(rk_driver *driver, const rk_scene *scene,
                            const rk_render_options *options, rk_error *error);

/* The same, but a pixel whose first ray hits nothing is an error. */
bool rk_driver_record_surface(rk_driver *driver, const rk_scene *scene,
                              const rk_render_options *options, rk_error *error);

/* A scale by a function from [0, 1] to linear colours. */
rk_driver_scale rk_driver_scale_of(const char *unit, double least, double most,
                                   rk_vec3 (*colour)(float fraction));

/* Writes the picture to OUT/figures/FEATURE_SCENE[_LABEL].png, with the debug view and its number
 * as label, or NULL, and prints its caption. Compares it with the picture of --compare. */
bool rk_driver_save(rk_driver *driver, const char *label, rk_error *error);

/* Makes OUT/tables if it is missing, and fills in the path of NAME.csv there. */
bool rk_driver_table(const rk_driver *driver, const char *name, char path[4096], rk_error *error);

/* Puts a row with this metric into OUT/tables/FEATURE.csv. */
bool rk_driver_row(rk_driver *driver, const char *metric, const char *unit, rk_timing timing,
                   rk_error *error);

/* Puts rows with what the last picture counted: rays, and tests of boxes and of triangles, all per
 * pixel. Other than times, they are the same in every run. */
bool rk_driver_count_rows(rk_driver *driver, rk_error *error);

/* A number that was measured once, or counted. */
rk_timing rk_timing_once(double figure);

/* Frees everything; prints `error` if `ok` is false. Returns the exit status. */
int rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);

#endif
