/* The parts of the scan's statue, as shapes without triangles: internal to scan.c. */
#ifndef RK_SCENES_STATUE_PARTS_H
#define RK_SCENES_STATUE_PARTS_H

#include "base/vec3.h"

#include <stdint.h>

/* In picture coordinates: x to the right, y up, z towards the viewer. */
typedef struct rk_scan_vec {
    double x, y, z;
} rk_scan_vec;

/* --- scan_shapes.c: the table of parts ------------------------------------------------------- */

enum { RK_SCAN_PARTS = 24, RK_SCAN_MATERIALS = 3, RK_SCAN_KEYS_MAX = 20 };

typedef enum rk_scan_relief {
    RK_SCAN_BONY,
    RK_SCAN_SOFT,
    RK_SCAN_FIN,
    RK_SCAN_BRANCH,
    RK_SCAN_ROCK
} rk_scan_relief;

/* A key of a spine: a place, and the oval's two radii there. `wide` lies across the part's least
 * axis (along which the spine runs least), `thin` along it. */
typedef struct rk_scan_key {
    float x, y, z, wide, thin;
} rk_scan_key;

typedef struct rk_scan_shape {
    rk_scan_relief relief;
    uint32_t material, key_count;
    rk_scan_key keys[RK_SCAN_KEYS_MAX];
} rk_scan_shape;

extern const rk_scan_shape rk_scan_shapes[RK_SCAN_PARTS];
extern const rk_vec3 rk_scan_colours[RK_SCAN_MATERIALS];

/* --- scan_relief.c --------------------------------------------------------------------------- */

/* How far the surface stands out at a point of the smooth oval: `key` and `turns` say where on the
 * part it is, along the spine and around it. */
double rk_scan_relief_at(rk_scan_relief kind, rk_scan_vec p, double key, double turns,
                         double radius);

/* --- scan_parts.c ---------------------------------------------------------------------------- */

enum { RK_SCAN_STEPS = 400 }; /* of a part's measure */

/* A part and its measures. Places on its spine are counted in keys: 0 is the first, 1 the second.
 */
typedef struct rk_scan_part {
    uint32_t index, key_count, material;
    int least_axis;                   /* 0, 1 or 2 */
    double length, area;              /* from pole to pole along the surface, and of the surface */
    double walked[RK_SCAN_STEPS + 1]; /* the length up to each step along the spine */
} rk_scan_part;

void rk_scan_measure(rk_scan_part *part, uint32_t index);

/* The place at a fraction of the length, and the girth there. */
void rk_scan_locate(const rk_scan_part *part, double fraction, double *key, double *girth);

/* `count` points around the spine, evenly apart, in the world's coordinates. */
void rk_scan_ring(const rk_scan_part *part, double key, rk_vec3 *points, uint32_t count);

/* The first point of the spine, or (end = 1) the last. */
rk_vec3 rk_scan_pole(const rk_scan_part *part, int end);

#endif
