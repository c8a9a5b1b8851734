/* Ear clipping: a corner whose triangle has the polygon's orientation and contains no other corner
 * is cut off, until three are left. Convex polygons, nearly all, are detected first and become a
 * fan. Source: Meisters, "Polygons have ears", American Mathematical Monthly 82 (1975). */
#include "io/mesh_helper/polygon.h"

#include <string.h>

typedef struct flat {
    double x, y;
} flat;

/* Newell's normal: twice the polygon's vector area. */
static void newell_normal(const rk_vec3 *points, uint32_t corners, double normal[3])
{
    normal[0] = normal[1] = normal[2] = 0;
    for (uint32_t i = 0; i < corners; i++) {
        rk_vec3 a = points[i], b = points[(i + 1) % corners];
        normal[0] += ((double)a.y - (double)b.y) * ((double)a.z + (double)b.z);
        normal[1] += ((double)a.z - (double)b.z) * ((double)a.x + (double)b.x);
        normal[2] += ((double)a.x - (double)b.x) * ((double)a.y + (double)b.y);
    }
}

/* The two axes of the projection along the axis that the polygon faces most, ordered so that it is
 * counterclockwise. */
typedef struct view {
    const rk_vec3 *points;
    int u, v;
} view;

static view look_at(const rk_vec3 *points, uint32_t corners)
{
    double normal[3];
    newell_normal(points, corners, normal);
    int facing = fabs(normal[1]) > fabs(normal[0]) ? 1 : 0;
    facing = fabs(normal[2]) >= fabs(normal[facing]) ? 2 : facing;
    int u = (facing + 1) % 3, v = (facing + 2) % 3;
    return normal[facing] < 0 ? (view){points, v, u} : (view){points, u, v};
}

static flat seen(const view *w, uint32_t corner)
{
    return (flat){(double)rk_axis(w->points[corner], w->u),
                  (double)rk_axis(w->points[corner], w->v)};
}

/* Positive if a, b, c are counterclockwise. */
static double turn(flat a, flat b, flat c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool is_same(flat a, flat b)
{
    return a.x == b.x && a.y == b.y;
}

static bool is_ear(const view *w, const uint32_t *left, uint32_t count, uint32_t ear)
{
    uint32_t before = (ear + count - 1) % count, after = (ear + 1) % count;
    flat a = seen(w, left[before]), b = seen(w, left[ear]), c = seen(w, left[after]);
    if (!(turn(a, b, c) > 0))
        return false;
    for (uint32_t k = 0; k < count; k++) {
        if (k == before || k == ear || k == after)
            continue;
        flat p = seen(w, left[k]);
        bool inside = turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
        /* A copy of one of these three corners (a bridge to a hole) does not count. */
        if (inside && !is_same(p, a) && !is_same(p, b) && !is_same(p, c))
            return false;
    }
    return true;
}

/* Convex up to the rounding of its coordinates to float, which moves each by at most half an ulp,
 * and a cross product of edges by that times the edges' lengths: otherwise a circle of many corners
 * would never be convex. */
static bool is_convex(const view *w, uint32_t corners)
{
    double half_ulp = 0;
    for (uint32_t i = 0; i < corners; i++) {
        flat p = seen(w, i);
        half_ulp = fmax(half_ulp, fmax(fabs(p.x), fabs(p.y)) * 0x1p-24);
    }
    flat a = seen(w, corners - 2), b = seen(w, corners - 1);
    for (uint32_t i = 0; i < corners; i++) {
        flat c = seen(w, i);
        double edges = fabs(b.x - a.x) + fabs(b.y - a.y) + fabs(c.x - b.x) + fabs(c.y - b.y);
        if (turn(a, b, c) < -2 * half_ulp * edges)
            return false;
        a = b;
        b = c;
    }
    return true;
}

bool rk_polygon_triangulate(const rk_vec3 *points, uint32_t corners, uint32_t (*triangles)[3],
                            uint32_t *left)
{
    view w = look_at(points, corners);
    bool convex = is_convex(&w, corners);
    if (!convex && corners > RK_POLYGON_CORNERS_MAX)
        return false;
    for (uint32_t i = 0; i < corners; i++)
        left[i] = i;
    uint32_t ear = 0;
    for (uint32_t count = corners; count >= 3; count--) {
        uint32_t *row = triangles[corners - count];
        if (convex) {
            row[0] = 0, row[1] = corners - count + 1, row[2] = row[1] + 1;
            continue;
        }
        /* Continue from the last ear: corners that were not ears before seldom are now. */
        uint32_t tried = 0;
        for (ear %= count; tried < count && !is_ear(&w, left, count, ear); tried++)
            ear = (ear + 1) % count;
        /* No ear: the polygon intersects itself or has no area, and any corner will do. */
        row[0] = left[(ear + count - 1) % count], row[1] = left[ear],
        row[2] = left[(ear + 1) % count];
        memmove(&left[ear], &left[ear + 1], (count - 1 - ear) * sizeof *left);
    }
    return true;
}
