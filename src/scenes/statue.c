/* A statue as if from a laser scanner: a seahorse among corals, with exactly as many triangles as
 * requested, of similar size, in the order of a scanner's rows.
 *
 * Each part is a tube: a spine through a few keys (a uniform cubic B-spline), an oval cross-section
 * that closes at both ends, and relief. A tube of rings with n_1, n_2, ... vertices and two poles
 * has 2 (n_1 + n_2 + ...) triangles, so N / 2 vertices are distributed over the rings in proportion
 * to their girth. For an odd N the last triangle is missing: scans have holes.
 *
 * Computed with + - * / sqrt in double alone, so that every machine gives the same bits.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"
#include "scenes/ring.h"
#include "scenes/statue_parts.h"

#include <stdlib.h>

/* --- distributing rings and vertices --------------------------------------------------------- */

/* A ring of the plan: its place on a part, and its number of vertices. */
typedef struct plan_ring {
    uint32_t part, count;
    double key, girth;
} plan_ring;

typedef struct plan {
    rk_statue_part parts[RK_STATUE_PARTS];
    uint32_t part_count;
    uint32_t rings_of[RK_STATUE_PARTS];
    plan_ring *rings;
    uint32_t ring_count;
} plan;

/* Parts that are too small for two dozen triangles are left out; the body always stays. */
static double choose_parts(plan *p, double triangles)
{
    const double fewest = 24;
    double area = 0, chosen_area = 0;
    for (uint32_t i = 0; i < RK_STATUE_PARTS; i++) {
        rk_statue_measure(&p->parts[i], i);
        area += p->parts[i].area;
    }
    for (uint32_t i = 0; i < RK_STATUE_PARTS; i++)
        if (i == 0 || p->parts[i].area * triangles >= fewest * area) {
            chosen_area += p->parts[i].area;
            p->parts[p->part_count++] = p->parts[i];
        }
    return chosen_area;
}

/* Counts the rings of each part if rings are `spacing` apart; returns their sum. */
static uint32_t count_rings(plan *p, double spacing)
{
    p->ring_count = 0;
    for (uint32_t i = 0; i < p->part_count; i++) {
        double fitting = p->parts[i].length / spacing - 0.5;
        p->rings_of[i] = fitting < 1 ? 1 : (uint32_t)fitting;
        p->ring_count += p->rings_of[i];
    }
    return p->ring_count;
}

/* Each ring gets 3 vertices, and a fraction of the others proportional to the excess of its girth
 * over 3 edges. Running sums are rounded, so that the fractions add up exactly. */
static void distribute_vertices(plan *p, uint32_t vertices, double edge)
{
    double total = 0, running = 0;
    for (uint32_t i = 0; i < p->ring_count; i++)
        total += fmax(p->rings[i].girth - 3 * edge, 0.01 * edge);
    uint32_t spare = vertices - 3 * p->ring_count, dealt = 0;
    for (uint32_t i = 0; i < p->ring_count; i++) {
        running += fmax(p->rings[i].girth - 3 * edge, 0.01 * edge);
        uint32_t due = i + 1 == p->ring_count ? spare : (uint32_t)(spare * (running / total));
        p->rings[i].count = 3 + due - dealt;
        dealt = due;
    }
}

static bool make_plan(plan *p, uint32_t vertices, rk_error *error)
{
    double area = choose_parts(p, 2.0 * vertices);
    /* Equilateral triangles: edges e, rings sqrt(3) / 2 e apart, areas sqrt(3) / 4 e^2. */
    double edge = sqrt(area / (2 * vertices) * 4 / sqrt(3));
    while (3 * (uint64_t)count_rings(p, 0.5 * sqrt(3) * edge) > vertices)
        edge *= 1.05;
    p->rings = rk_allocate(p->ring_count, sizeof *p->rings, "statue: rings", error);
    if (!p->rings)
        return false;
    plan_ring *ring = p->rings;
    for (uint32_t i = 0; i < p->part_count; i++)
        for (uint32_t k = 0; k < p->rings_of[i]; k++, ring++) {
            ring->part = i;
            rk_statue_locate(&p->parts[i], (k + 1.0) / (p->rings_of[i] + 1.0), &ring->key,
                             &ring->girth);
        }
    distribute_vertices(p, vertices, edge);
    return true;
}

/* --- filling the mesh ------------------------------------------------------------------------ */

/* Adds a part's rings between two poles; returns the vertex after its last. */
static uint32_t put_part(rk_mesh *mesh, const plan *p, const plan_ring *rings, uint32_t count,
                         uint32_t first, uint32_t (**row)[3])
{
    const rk_statue_part *part = &p->parts[rings->part];
    rk_ring below = {first, 1};
    mesh->positions[first] = rk_statue_pole(part, 0);
    for (uint32_t i = 0; i < count; i++) {
        rk_ring ring = {below.first + below.count, rings[i].count};
        rk_statue_ring(part, rings[i].key, &mesh->positions[ring.first], ring.count);
        *row = rk_ring_stitch(*row, below, ring);
        below = ring;
    }
    rk_ring pole = {below.first + below.count, 1};
    mesh->positions[pole.first] = rk_statue_pole(part, 1);
    *row = rk_ring_stitch(*row, below, pole);
    return pole.first + 1;
}

static void put_parts(rk_mesh *mesh, const plan *p)
{
    uint32_t(*row)[3] = mesh->triangles;
    const plan_ring *rings = p->rings;
    uint32_t vertex = 0, triangle = 0;
    for (uint32_t i = 0; i < p->part_count; i++) {
        vertex = put_part(mesh, p, rings, p->rings_of[i], vertex, &row);
        rings += p->rings_of[i];
        uint32_t end = (uint32_t)(row - mesh->triangles);
        for (; triangle < end; triangle++)
            mesh->triangle_materials[triangle] = (uint16_t)p->parts[i].material;
    }
}

/* Removes the last triangles, and vertices that then belong to none. */
static void truncate_to(rk_mesh *mesh, uint32_t triangles)
{
    mesh->triangle_count = triangles;
    if (triangles >= 4)
        return;
    uint32_t highest = 0;
    for (uint32_t i = 0; i < 3 * triangles; i++)
        highest = mesh->triangles[i / 3][i % 3] > highest ? mesh->triangles[i / 3][i % 3] : highest;
    mesh->vertex_count = highest + 1;
}

bool rk_builtin_make_statue(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    uint32_t vertices = number < 6 ? 3 : number / 2 + number % 2;
    plan p = {0};
    bool ok =
        make_plan(&p, vertices, error) && rk_mesh_init(mesh, vertices + 2 * p.part_count,
                                                       2 * vertices, RK_STATUE_MATERIALS, 0, error);
    if (ok) {
        put_parts(mesh, &p);
        truncate_to(mesh, number);
        for (int i = 0; i < RK_STATUE_MATERIALS; i++)
            mesh->materials[i].kd = rk_statue_colours[i];
        ok = rk_mesh_smooth(mesh, error);
        if (!ok)
            rk_mesh_free(mesh);
    }
    free(p.rings);
    return ok;
}
