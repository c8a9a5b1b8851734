/* Ear clipping: a corner whose triangle turns the polygon's way and holds no other corner is cut
 * off, until three are left. Convex polygons, nearly all, are seen at once and cut like a fan.
 * Source: Meisters, "Polygons have ears", American Mathematical Monthly 82 (1975). */
#include "io/polygon.h"

#include <stdbool.h>
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

/* Drops the coordinate along which the polygon faces most, keeping its turn counterclockwise. */
static flat flatten(rk_vec3 p, const double normal[3])
{
    double ax = fabs(normal[0]), ay = fabs(normal[1]), az = fabs(normal[2]);
    flat f = az >= ax && az >= ay ? (flat){(double)p.x, (double)p.y}
             : ax >= ay           ? (flat){(double)p.y, (double)p.z}
                                  : (flat){(double)p.z, (double)p.x};
    double facing = az >= ax && az >= ay ? normal[2] : ax >= ay ? normal[0] : normal[1];
    return facing < 0 ? (flat){f.y, f.x} : f;
}

/* Positive where a, b, c turn counterclockwise. */
static double turn(flat a, flat b, flat c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool is_ear(const rk_vec3 *points, const double normal[3], const uint32_t *left,
                   uint32_t count, uint32_t i)
{
    uint32_t before = (i + count - 1) % count, after = (i + 1) % count;
    flat a = flatten(points[left[before]], normal), b = flatten(points[left[i]], normal),
         c = flatten(points[left[after]], normal);
    if (!(turn(a, b, c) > 0))
        return false;
    for (uint32_t k = 0; k < count; k++) {
        if (k == before || k == i || k == after)
            continue;
        flat p = flatten(points[left[k]], normal);
        bool inside = turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
        /* A corner that repeats one of these three (a bridge to a hole) blocks nothing. */
        bool repeated =
            (p.x == a.x && p.y == a.y) || (p.x == b.x && p.y == b.y) || (p.x == c.x && p.y == c.y);
        if (inside && !repeated)
            return false;
    }
    return true;
}

static bool is_convex(const rk_vec3 *points, const double normal[3], uint32_t corners)
{
    flat a = flatten(points[corners - 2], normal), b = flatten(points[corners - 1], normal);
    for (uint32_t i = 0; i < corners; i++) {
        flat c = flatten(points[i], normal);
        if (turn(a, b, c) < 0)
            return false;
        a = b;
        b = c;
    }
    return true;
}

void rk_polygon_cut(const rk_vec3 *points, uint32_t corners, uint32_t (*triangles)[3],
                    uint32_t *left)
{
    double normal[3];
    newell_normal(points, corners, normal);
    bool convex = is_convex(points, normal, corners);
    for (uint32_t i = 0; i < corners; i++)
        left[i] = i;
    for (uint32_t count = corners; count >= 3; count--) {
        uint32_t *row = triangles[corners - count];
        if (convex) {
            row[0] = 0, row[1] = corners - count + 1, row[2] = row[1] + 1;
            continue;
        }
        uint32_t ear = 0;
        while (ear < count && !is_ear(points, normal, left, count, ear))
            ear++;
        if (ear == count) /* it crosses itself or has no area: any cut is as good */
            ear = 0;
        row[0] = left[(ear + count - 1) % count], row[1] = left[ear],
        row[2] = left[(ear + 1) % count];
        memmove(&left[ear], &left[ear + 1], (count - 1 - ear) * sizeof *left);
    }
}
