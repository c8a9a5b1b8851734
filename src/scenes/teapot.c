/* The Utah teapot: 32 bicubic Bezier patches.
 * Source: M. Newell's data of 1975, in F. Crow, "The origins of the teapot", IEEE Computer Graphics
 * and Applications 7(1), 1987, with the bottom that was added later. Heights have their usual
 * scale: J. Blinn divided them by 1.3 for a display with tall pixels, and so they have stayed.
 *
 * Symmetry leaves little to store: body, lid and bottom are profiles rotated about the axis, one
 * patch per quarter; handle and spout are rows of loops, one patch per half loop.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"

/* A control point of a profile, and `bend`, which makes a quarter circle of it: the control points
 * (radius, 0), (radius, bend), (bend, radius), (0, radius). */
typedef struct turned {
    double radius, height, bend;
} turned;

enum { profile_count = 6, loop_count = 4, patch_count = 4 * profile_count + 2 * loop_count };

/* From the top down, on the outside. */
static const turned profiles[profile_count][4] = {
    /* rim */
    {{1.4, 2.4, 0.784}, {1.3375, 2.53125, 0.749}, {1.4375, 2.53125, 0.805}, {1.5, 2.4, 0.84}},
    /* body */
    {{1.5, 2.4, 0.84}, {1.75, 1.875, 0.98}, {2, 1.35, 1.12}, {2, 0.9, 1.12}},
    {{2, 0.9, 1.12}, {2, 0.45, 1.12}, {1.5, 0.225, 0.84}, {1.5, 0.15, 0.84}},
    /* knob */
    {{0, 3.15, 0}, {0.8, 3.15, 0.45}, {0, 2.85, 0}, {0.2, 2.7, 0.112}},
    /* lid */
    {{0.2, 2.7, 0.112}, {0.4, 2.55, 0.224}, {1.3, 2.55, 0.728}, {1.3, 2.4, 0.728}},
    /* bottom */
    {{1.5, 0.15, 0.84}, {1.5, 0.075, 0.84}, {1.425, 0, 0.798}, {0, 0, 0}},
};

/* Half a loop: from (x0, y0) in the plane of symmetry out to the width, and back to (x1, y1). */
typedef struct loop {
    double x0, y0, x1, y1, width;
} loop;

static const loop loops[loop_count][4] = {
    /* handle */
    {{-1.6, 2.025, -1.5, 2.25, 0.3},
     {-2.3, 2.025, -2.5, 2.25, 0.3},
     {-2.7, 2.025, -3, 2.25, 0.3},
     {-2.7, 1.8, -3, 1.8, 0.3}},
    {{-2.7, 1.8, -3, 1.8, 0.3},
     {-2.7, 1.575, -3, 1.35, 0.3},
     {-2.5, 1.125, -2.65, 0.9375, 0.3},
     {-2, 0.9, -1.9, 0.6, 0.3}},
    /* spout */
    {{1.7, 1.425, 1.7, 0.6, 0.66},
     {2.6, 1.425, 3.1, 0.825, 0.66},
     {2.3, 2.1, 2.4, 2.025, 0.25},
     {2.7, 2.4, 3.3, 2.4, 0.25}},
    {{2.7, 2.4, 3.3, 2.4, 0.25},
     {2.8, 2.475, 3.525, 2.49375, 0.25},
     {2.9, 2.475, 3.45, 2.5125, 0.15},
     {2.8, 2.4, 3.2, 2.4, 0.15}},
};

typedef struct point {
    double x, y, z;
} point;

/* Rows run along v, columns along u; du x dv points outwards. y is up. */
typedef struct patch {
    point rows[4][4];
} patch;

static patch turned_patch(const turned profile[4], int quarter)
{
    patch p;
    for (int v = 0; v < 4; v++) {
        const turned *t = &profile[v];
        const double along[4] = {t->radius, t->radius, t->bend, 0};
        const double across[4] = {0, t->bend, t->radius, t->radius};
        for (int u = 0; u < 4; u++) {
            point from_x = {along[u], t->height, across[u]},
                  from_z = {-across[u], t->height, along[u]};
            p.rows[v][u] = quarter % 2 == 0 ? from_x : from_z;
            if (quarter >= 2)
                p.rows[v][u].x *= -1, p.rows[v][u].z *= -1;
        }
    }
    return p;
}

/* The published data has the spout at +x; half a turn makes it point right in the default view,
 * where x points left. */
static patch loop_patch(const loop rows[4], int half)
{
    patch p;
    for (int v = 0; v < 4; v++) {
        const loop *l = &rows[v];
        double side = half ? l->width : -l->width;
        const point out[4] = {
            {-l->x0, l->y0, 0}, {-l->x0, l->y0, side}, {-l->x1, l->y1, side}, {-l->x1, l->y1, 0}};
        for (int u = 0; u < 4; u++)
            p.rows[v][u] = out[half ? 3 - u : u];
    }
    return p;
}

static patch patch_of(int index)
{
    if (index < 4 * profile_count)
        return turned_patch(profiles[index / 4], index % 4);
    index -= 4 * profile_count;
    return loop_patch(loops[index / 2], index % 2);
}

/* Bernstein polynomials at i / n, and a third of their derivatives. Swapping i and n - i swaps the
 * values to the bit. */
typedef struct weights {
    double value[4], slope[4];
} weights;

static weights weights_at(uint32_t i, uint32_t n)
{
    double t = (double)i / n, s = (double)(n - i) / n;
    return (weights){{s * s * s, 3 * s * s * t, 3 * t * t * s, t * t * t},
                     {-s * s, s * s - 2 * s * t, 2 * s * t - t * t, t * t}};
}

/* Sums from both ends, so that mirrored control points give mirrored points to the bit. */
static double blend4(const double w[4], double a, double b, double c, double d)
{
    return (w[0] * a + w[3] * d) + (w[1] * b + w[2] * c);
}

/* `w`, `p`: 4 each. */
static point blend(const double *w, const point *p)
{
    return (point){blend4(w, p[0].x, p[1].x, p[2].x, p[3].x),
                   blend4(w, p[0].y, p[1].y, p[2].y, p[3].y),
                   blend4(w, p[0].z, p[1].z, p[2].z, p[3].z)};
}

static point on_patch(const patch *p, const double along_u[4], const double along_v[4])
{
    point column[4];
    for (int v = 0; v < 4; v++)
        column[v] = blend(along_u, p->rows[v]);
    return blend(along_v, column);
}

static bool is_pole(const patch *p, int v)
{
    const point *row = p->rows[v];
    return row[0].x == row[3].x && row[0].y == row[3].y && row[0].z == row[3].z;
}

/* At a pole the tangent along u vanishes; its limit has the direction of the next row's tangent. */
static point tangent_u(const patch *p, const weights *u, const weights *v)
{
    if (v->value[0] == 1 && is_pole(p, 0))
        return blend(u->slope, p->rows[1]);
    if (v->value[3] == 1 && is_pole(p, 3))
        return blend(u->slope, p->rows[2]);
    return on_patch(p, u->slope, v->value);
}

static rk_vec3 normal_at(const patch *p, const weights *u, const weights *v)
{
    point a = tangent_u(p, u, v), b = on_patch(p, u->value, v->slope);
    point n = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    double length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return rk_vec((float)(n.x / length), (float)(n.y / length), (float)(n.z / length));
}

static void put_vertices(rk_mesh *mesh, uint32_t first, const patch *p, uint32_t n)
{
    uint32_t vertex = first;
    for (uint32_t v = 0; v <= n; v++)
        for (uint32_t u = 0; u <= n; u++) {
            weights at_u = weights_at(u, n), at_v = weights_at(v, n);
            point at = on_patch(p, at_u.value, at_v.value);
            mesh->positions[vertex] = rk_vec((float)at.x, (float)at.y, (float)at.z);
            mesh->normals[vertex] = normal_at(p, &at_u, &at_v);
            vertex++;
        }
}

/* Two triangles per square, but one where an edge of the square is a pole. */
static uint32_t (*put_triangles(uint32_t (*row)[3], uint32_t first, const patch *p, uint32_t n))[3]
{
    for (uint32_t v = 0; v < n; v++)
        for (uint32_t u = 0; u < n; u++) {
            uint32_t a = first + v * (n + 1) + u, b = a + 1, c = a + n + 1, d = c + 1;
            if (!(v == 0 && is_pole(p, 0)))
                (*row)[0] = a, (*row)[1] = b, (*row)[2] = c, row++;
            if (!(v == n - 1 && is_pole(p, 3)))
                (*row)[0] = b, (*row)[1] = d, (*row)[2] = c, row++;
        }
    return row;
}

bool rk_builtin_make_teapot(rk_mesh *mesh, uint32_t n, rk_error *error)
{
    const uint32_t poles = 8; /* patches of the knob and the bottom */
    const uint32_t vertices = (n + 1) * (n + 1);
    if (!rk_mesh_init(mesh, patch_count * vertices, (2 * patch_count * n - poles) * n, 1,
                      RK_MESH_NORMALS, error))
        return false;
    uint32_t(*row)[3] = mesh->triangles;
    for (int i = 0; i < patch_count; i++) {
        patch p = patch_of(i);
        uint32_t first = (uint32_t)i * vertices;
        put_vertices(mesh, first, &p, n);
        row = put_triangles(row, first, &p, n);
    }
    mesh->materials[0] = (rk_material){.kd = rk_vec(0.72f, 0.7f, 0.66f),
                                       .ks = rk_vec(0.2f, 0.2f, 0.2f),
                                       .shininess = 60,
                                       .alpha = 1};
    return true;
}
