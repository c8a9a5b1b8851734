/* Hashes of all that a picture follows from: where they are the same, so are the pictures;
 * not installed. */
#ifndef RK_DRIVER_LIKENESS_H
#define RK_DRIVER_LIKENESS_H

#include "driver/driver.h"

typedef struct rk_likeness {
    uint64_t version;    /* of raykit, and of the units that it is built with */
    uint64_t arithmetic; /* results of the mathematics library, which differ between versions */
    uint64_t command;    /* the command line after the program's name, but for --out */
    uint64_t scene;      /* mesh, textures, environment */
} rk_likeness;

/* After the scene is made. */
rk_likeness rk_likeness_of(const rk_driver *driver);

/* Returns the first thing in which they differ, such as "another version of raykit"; NULL if they
 * are alike. */
const char *rk_likeness_difference(const rk_likeness *a, const rk_likeness *b);

#endif
