/* Closed meshes and rays whose coordinates are whole numbers, times a power of two that changes no
 * digit; so integers of 128 bits know exactly which triangles a ray hits. */
#ifndef RK_TESTS_CLOSED_MESH_H
#define RK_TESTS_CLOSED_MESH_H

#include "base/random.h"
#include "features/watertight.h"
#include "test.h"

__extension__ typedef __int128 whole;

typedef struct whole3 {
    int64_t x, y, z;
} whole3;

static inline whole3 whole_of(int64_t x, int64_t y, int64_t z)
{
    return (whole3){x, y, z};
}

/* a + s b */
static inline whole3 whole_madd(whole3 a, whole3 b, int64_t s)
{
    return whole_of(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}

/* a . (b x c); below 2^127 for coordinates below 2^41. */
static inline whole whole_triple(whole3 a, whole3 b, whole3 c)
{
    return (whole)a.x * ((whole)b.y * c.z - (whole)b.z * c.y) +
           (whole)a.y * ((whole)b.z * c.x - (whole)b.x * c.z) +
           (whole)a.z * ((whole)b.x * c.y - (whole)b.y * c.x);
}

typedef struct whole_determinants {
    whole u, v, w, t, det;
} whole_determinants;

static inline whole_determinants whole_determinants_of(const whole3 corner[3], whole3 origin,
                                                       whole3 direction)
{
    whole3 s = whole_madd(origin, corner[0], -1), ab = whole_madd(corner[1], corner[0], -1);
    whole3 ac = whole_madd(corner[2], corner[0], -1);
    whole_determinants m = {.u = whole_triple(s, direction, ac),
                            .v = whole_triple(direction, s, ab),
                            .t = whole_triple(ac, s, ab),
                            .det = whole_triple(ab, direction, ac)};
    whole sign = m.det < 0 ? -1 : 1;
    m.u *= sign, m.v *= sign, m.t *= sign, m.det *= sign;
    m.w = m.det - m.u - m.v;
    return m;
}

static inline bool whole_hits(const whole_determinants *m)
{
    return m->det > 0 && m->u >= 0 && m->v >= 0 && m->w >= 0 && m->t > 0;
}

/* Exact as long as the coordinates have 24 bits. */
static inline rk_vec3 float_of(whole3 a, int exponent)
{
    return rk_vec(ldexpf((float)a.x, exponent), ldexpf((float)a.y, exponent),
                  ldexpf((float)a.z, exponent));
}

static inline rk_triangle float_triangle(const whole3 corner[3], int exponent, uint32_t index)
{
    return (rk_triangle){float_of(corner[0], exponent), float_of(corner[1], exponent),
                         float_of(corner[2], exponent), index};
}

/* From -below to below. */
static inline int64_t random_whole(uint32_t key, uint32_t dimension, int64_t below)
{
    uint64_t bits = (uint64_t)rk_case(key, dimension, 1, 7) << 20 ^ rk_case(key, dimension, 2, 7);
    return (int64_t)(bits % (uint64_t)(2 * below + 1)) - below;
}

static inline whole3 random_point(uint32_t key, uint32_t dimension, int64_t below)
{
    return whole_of(random_whole(key, dimension, below), random_whole(key, dimension + 1, below),
                    random_whole(key, dimension + 2, below));
}

/* --- A ball ----------------------------------------------------------------------------------- */

/* An octahedron whose faces are split into `rows` rows of triangles, pushed out to a ball. Corners
 * are placed by their whole coordinates, so neighbours have the same. Returns the number of
 * triangles, 8 rows^2. */
static inline whole3 on_ball(int64_t x, int64_t y, int64_t z, double radius, whole3 centre)
{
    double scale = radius / sqrt((double)(x * x + y * y + z * z));
    return whole_of(centre.x + (int64_t)rint((double)x * scale),
                    centre.y + (int64_t)rint((double)y * scale),
                    centre.z + (int64_t)rint((double)z * scale));
}

static inline uint32_t make_ball(whole3 (*triangles)[3], int rows, double radius, whole3 centre)
{
    uint32_t count = 0;
    for (int octant = 0; octant < 8; octant++) {
        int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
        bool flip = sx * sy * sz < 0;
        for (int i = 0; i < rows; i++)
            for (int j = 0; i + j < rows; j++)
                for (int upper = 0; upper < (i + j + 1 < rows ? 2 : 1); upper++) {
                    int at[3][2] = {{i + upper, j + upper}, {i + 1, j}, {i, j + 1}};
                    if (flip != (upper == 1)) {
                        int other[2] = {at[1][0], at[1][1]};
                        at[1][0] = at[2][0], at[1][1] = at[2][1];
                        at[2][0] = other[0], at[2][1] = other[1];
                    }
                    for (int k = 0; k < 3; k++)
                        triangles[count][k] =
                            on_ball(sx * at[k][0], sy * at[k][1], sz * (rows - at[k][0] - at[k][1]),
                                    radius, centre);
                    count++;
                }
    }
    return count;
}

/* A direction from the origin exactly through an edge or a corner of a triangle, or just beside. */
static inline whole3 aimed(uint32_t key, const whole3 corner[3], whole3 origin)
{
    uint32_t kind = rk_case(key, 1, 1, 9) % 4, k = rk_case(key, 2, 1, 9) % 3;
    whole3 a = whole_madd(corner[k], origin, -1), b = whole_madd(corner[(k + 1) % 3], origin, -1);
    whole3 direction = kind == 0 ? a : whole_madd(a, b, 1); /* to the corner, the edge's middle */
    if (kind == 3)
        direction = whole_madd(direction, random_point(key, 20, 1), 1);
    return direction;
}

#endif
