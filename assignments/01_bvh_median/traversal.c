/* The view of --debug traversal: the boxes that the ray of a pixel tests, in the order of
 * rk_bvh_closest, by the same box and triangle tests; the unit's own counts are printed below. */
#include "driver.h"

#include "driver/pixel_code.h"
#include "features/bvh_median.h"
#include "features/watertight.h"

#include <stdio.h>
#include <stdlib.h>

/* A box that is tested, or a leaf whose triangles are. */
typedef struct step {
    const rk_bvh_node *node;
    rk_pixel_code code;
    float enter; /* of a box: INFINITY if it is missed */
    rk_hit hit;  /* the closest one so far */
} step;

typedef struct traversal {
    const rk_bvh *bvh;
    rk_slabs slabs;
    rk_hit hit;
    step *steps; /* each node's box is tested at most once, and each leaf visited */
    uint32_t count, boxes, triangles;
} traversal;

static float test_box(traversal *t, const rk_bvh_node *node, rk_pixel_code code)
{
    float enter = rk_box_enter(&node->box, &t->slabs, t->hit.t);
    t->steps[t->count++] = (step){node, code, enter, t->hit};
    t->boxes++;
    return enter;
}

static void visit_leaf(traversal *t, const rk_bvh_node *leaf, const rk_ray *ray)
{
    rk_triangles_closest(&t->bvh->triangles[leaf->first], leaf->count, ray, &t->hit);
    t->steps[t->count++] = (step){leaf, RK_CODE_LEAF, 0, t->hit};
    t->triangles += leaf->count;
}

/* The nearer child comes first; the farther one waits, and is dropped if a hit is nearer. */
static void visit(traversal *t, const rk_bvh_node *node, const rk_ray *ray)
{
    if (node->count > 0) {
        visit_leaf(t, node, ray);
        return;
    }
    const rk_bvh_node *children = &t->bvh->nodes[node->first];
    const float enter[2] = {test_box(t, &children[0], RK_CODE_FIRST_CHILD),
                            test_box(t, &children[1], RK_CODE_SECOND_CHILD)};
    const int near = enter[1] < enter[0];
    if (enter[near] < INFINITY)
        visit(t, &children[near], ray);
    if (enter[1 - near] < INFINITY && enter[1 - near] <= t->hit.t)
        visit(t, &children[1 - near], ray);
}

/* --- Drawing ---------------------------------------------------------------------------------- */

static void draw_leaf(rk_overlay *overlay, const traversal *t, const rk_bvh_node *leaf)
{
    const rk_vec3 orange = rk_vec(1, 0.35f, 0);
    for (uint32_t i = 0; i < leaf->count; i++) {
        const rk_triangle *triangle = &t->bvh->triangles[leaf->first + i];
        rk_overlay_triangle(overlay, triangle->a, triangle->b, triangle->c, orange, 0.7f);
    }
}

static void draw_step(rk_overlay *overlay, const traversal *t, const step *s, bool is_last)
{
    const rk_vec3 blue = rk_vec(0.1f, 0.4f, 1), grey = rk_vec(0.25f, 0.25f, 0.25f);
    const rk_vec3 orange = rk_vec(1, 0.35f, 0), white = rk_vec(0.8f, 0.8f, 0.8f);
    const bool is_missed = !(s->enter < INFINITY);
    if (s->code == RK_CODE_LEAF)
        draw_leaf(overlay, t, s->node);
    else if (is_last)
        rk_overlay_wireframe(overlay, &s->node->box, is_missed ? white : orange, 3);
    else
        rk_overlay_wireframe(overlay, &s->node->box, is_missed ? grey : blue, 1);
}

static bool draw(rk_driver *driver, const traversal *t, const rk_ray *ray, rk_error *error)
{
    const choices *c = driver->choices;
    rk_overlay overlay;
    if (!rk_driver_render_overlay(driver, &overlay, error))
        return false;
    rk_tree_view_dim(&driver->image);
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++)
        overlay.depth[i] = INFINITY; /* no surface hides a box */
    const uint32_t shown = c->steps < t->count ? c->steps : t->count;
    for (uint32_t k = 0; k < shown; k++)
        draw_step(&overlay, t, &t->steps[k], k + 1 == shown);
    rk_overlay_point(&overlay, rk_madd(ray->origin, ray->direction, 1), rk_vec(1, 1, 1), 3);
    rk_overlay_free(&overlay);
    return true;
}

/* --- Printing --------------------------------------------------------------------------------- */

static void print_step(const traversal *t, const step *s, uint32_t number)
{
    const uint32_t node = (uint32_t)(s->node - t->bvh->nodes);
    if (s->code != RK_CODE_LEAF && s->enter < INFINITY)
        printf("step %u: box of node %u, entered at t = %.6f\n", number, node, (double)s->enter);
    else if (s->code != RK_CODE_LEAF && s->hit.triangle != RK_MISS)
        printf("step %u: box of node %u, missed before t = %.6f\n", number, node, (double)s->hit.t);
    else if (s->code != RK_CODE_LEAF)
        printf("step %u: box of node %u, missed\n", number, node);
    else if (s->hit.triangle == RK_MISS)
        printf("step %u: leaf of %u triangles, no hit so far\n", number, s->node->count);
    else
        printf("step %u: leaf of %u triangles, closest so far: triangle %u at t = %.6f\n", number,
               s->node->count, s->hit.triangle, (double)s->hit.t);
}

static void print(const rk_driver *driver, const traversal *t, const rk_ray *ray)
{
    for (uint32_t k = 0; k < t->count; k++) {
        if (driver->pixel_code)
            rk_print_pixel_code(stdout, t->steps[k].code);
        print_step(t, &t->steps[k], k + 1);
    }
    rk_counters counters = {0};
    rk_bvh_closest(t->bvh, ray, &counters);
    const bool same = counters.box_tests == t->boxes && counters.triangle_tests == t->triangles;
    printf("rk_bvh_closest tests %llu box%s and %llu triangle%s%s\n",
           (unsigned long long)counters.box_tests, counters.box_tests == 1 ? "" : "es",
           (unsigned long long)counters.triangle_tests, counters.triangle_tests == 1 ? "" : "s",
           same ? "" : ", not those above");
}

bool draw_traversal(rk_driver *driver, rk_error *error)
{
    const rk_view view =
        rk_view_of(&driver->scene.camera, driver->render.width, driver->render.height);
    rk_driver_draw_pixel(driver);
    const rk_ray ray =
        rk_view_ray(&view, (float)driver->pixel.x + 0.5f, (float)driver->pixel.y + 0.5f);
    traversal t = {.bvh = rk_driver_tree(driver),
                   .slabs = rk_slabs_of(&ray),
                   .hit = {ray.t_max, 0, 0, RK_MISS}};
    t.steps = rk_allocate(2 * (size_t)t.bvh->node_count + 1, sizeof *t.steps, "steps", error);
    if (!t.steps)
        return false;
    if (t.bvh->node_count > 0 && test_box(&t, &t.bvh->nodes[0], RK_CODE_ROOT) < INFINITY)
        visit(&t, &t.bvh->nodes[0], &ray);
    bool ok = draw(driver, &t, &ray, error);
    if (ok && !driver->quiet)
        print(driver, &t, &ray);
    free(t.steps);
    return ok;
}

bool save_traversal(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    char label[64] = "traversal";
    if (c->steps != RK_TREE_VIEW_NOT_GIVEN)
        snprintf(label, sizeof label, "traversal%u", c->steps);
    return rk_driver_save(driver, label, error);
}
