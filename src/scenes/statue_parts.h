/* The parts of the statue, as shapes without triangles: declared here for three files, internal to
 * statue.c; not installed. */
#ifndef RK_SCENES_STATUE_PARTS_H
#define RK_SCENES_STATUE_PARTS_H

#include "base/vec3.h"

#include <stdint.h>

/* In picture coordinates: x to the right, y up, z towards the viewer. */
typedef struct rk_statue_vec {
    double x, y, z;
} rk_statue_vec;

/* --- statue_shapes.c: the table of parts ----------------------------------------------------- */

enum { RK_STATUE_PARTS = 24, RK_STATUE_MATERIALS = 3, RK_STATUE_KEYS_MAX = 20 };

typedef enum rk_statue_relief {
    RK_STATUE_BONY,
    RK_STATUE_SOFT,
    RK_STATUE_FIN,
    RK_STATUE_BRANCH,
    RK_STATUE_ROCK
} rk_statue_relief;

/* A key of a spine: a position, and the oval's two radii there. `wide` is measured across the
 * part's least axis (along which the spine extends least), `thin` along it. */
typedef struct rk_statue_key {
    float x, y, z, wide, thin;
} rk_statue_key;

typedef struct rk_statue_shape {
    rk_statue_relief relief;
    uint32_t material, key_count;
    rk_statue_key keys[RK_STATUE_KEYS_MAX];
} rk_statue_shape;

extern const rk_statue_shape rk_statue_shapes[RK_STATUE_PARTS];
extern const rk_vec3 rk_statue_colours[RK_STATUE_MATERIALS];

/* --- statue_relief.c ------------------------------------------------------------------------- */

/* The height of the relief at a point of the smooth oval; `key` and `turns` are its coordinates
 * along the spine and around it. */
double rk_statue_relief_at(rk_statue_relief kind, rk_statue_vec p, double key, double turns,
                           double radius);

/* --- statue_parts.c -------------------------------------------------------------------------- */

enum { RK_STATUE_STEPS = 400 }; /* in which a spine is measured */

/* A part and its measures. Positions on its spine are counted in keys: 0 is the first, 1 the
 * second. */
typedef struct rk_statue_part {
    uint32_t index, key_count, material;
    int least_axis;                         /* 0, 1 or 2 */
    double length, area;                    /* the length from pole to pole along the surface */
    double arc_length[RK_STATUE_STEPS + 1]; /* up to each step along the spine */
} rk_statue_part;

void rk_statue_measure(rk_statue_part *part, uint32_t index);

/* The position at a fraction of the length, and the girth there. */
void rk_statue_locate(const rk_statue_part *part, double fraction, double *key, double *girth);

/* `count` equidistant points around the spine, in world coordinates. */
void rk_statue_ring(const rk_statue_part *part, double key, rk_vec3 *points, uint32_t count);

/* The first point of the spine, or (end = 1) the last. */
rk_vec3 rk_statue_pole(const rk_statue_part *part, int end);

#endif
