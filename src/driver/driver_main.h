/* The main of all drivers. A spec holds a driver's own parts: options, debug views, studies, timing
 * rows, names of pictures. */
#ifndef RK_DRIVER_DRIVER_MAIN_H
#define RK_DRIVER_DRIVER_MAIN_H

#include "base/options.h"
#include "driver/driver.h"

/* A driver's own step; its options are in driver->choices. */
typedef bool rk_driver_step(rk_driver *driver, rk_error *error);

/* A picture of --debug: renders into driver->image, and draws over it. */
typedef struct rk_driver_view {
    const char *name; /* NULL ends a table */
    rk_driver_step *draw;
    bool without_tree; /* no tree is built for it */
} rk_driver_view;

/* A table in place of a picture. */
typedef struct rk_driver_study {
    const bool *wanted; /* the flag of its option; NULL ends a table */
    rk_driver_step *put;
    bool without_tree;
} rk_driver_study;

typedef struct rk_driver_spec {
    const char *feature, *summary;

    /* Options: rows over `choices`, which is set to the rows' defaults; and rows over rk_driver,
     * whose values are the defaults. Either may be NULL. */
    const rk_option *options;
    void *choices;
    const rk_option *driver_options;
    void (*set_defaults)(rk_driver *driver); /* of common options that differ here */

    bool is_of_binary_trees; /* --split names no other trees */
    const rk_driver_view *views;
    const rk_driver_study *studies;

    /* Each of these may be NULL. */
    rk_driver_step *choose;     /* checks options, and completes those of the picture */
    rk_driver_step *prepare;    /* changes the scene, by options that are of_scene */
    rk_driver_step *check_tree; /* after it is built */
    rk_driver_step *put_rows;   /* of --timing, after the picture is rendered */
    rk_driver_step *save; /* a picture, driver->debug's or the plain one; NULL: without label */
} rk_driver_spec;

/* Defaults, options, scene and tree. RK_OPTIONS_BAD, with an error, if any of these fails. */
rk_options_result rk_driver_begin(const rk_driver_spec *spec, rk_driver *driver, int argc,
                                  char **argv, rk_error *error);

/* The same for a driver that has read other options, and has scene and tree of another one already;
 * their options that are of_scene are equal. */
bool rk_driver_begin_again(const rk_driver_spec *spec, rk_driver *driver, rk_error *error);

/* A study, a debug view, timing rows, or the picture. */
bool rk_driver_draw(const rk_driver_spec *spec, rk_driver *driver, rk_error *error);

/* Both, and rk_driver_finish. Returns the exit status. */
int rk_driver_main(const rk_driver_spec *spec, int argc, char **argv);

#endif
