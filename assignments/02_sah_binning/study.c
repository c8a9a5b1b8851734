/* The tables of --splits: the candidate splits of a node with the planes between its bins, and the
 * triangles that they divide. */
#include "driver.h"

#include "driver/number_row.h"

#include <stdlib.h>

/* Where a boundary is, from the extent of the centroids. */
static double plane_of(const rk_box *centroids, uint32_t bins, const rk_sah_split *split)
{
    double low = (double)rk_axis(centroids->corner[0], split->axis);
    double high = (double)rk_axis(centroids->corner[1], split->axis);
    return low + (high - low) * split->boundary / bins;
}

static bool put_splits(const splits *c, const rk_driver *driver, rk_error *error)
{
    rk_box node = rk_box_empty(), centroids = rk_box_empty();
    for (uint32_t i = 0; i < c->triangles; i++) {
        node = rk_box_merge(node, c->references[i].box);
        centroids = rk_box_add(centroids, c->references[i].centroid);
    }
    uint32_t bins = driver->bins < c->triangles ? driver->bins : c->triangles;
    const rk_sah_split *best = rk_sah_cheapest(c->list, c->count);
    for (uint32_t k = 0; k < c->count; k++) {
        const rk_sah_split *s = &c->list[k];
        const double numbers[] = {c->node,
                                  k,
                                  s->axis,
                                  plane_of(&centroids, bins, s),
                                  s->count[0],
                                  s->count[1],
                                  s->cost,
                                  rk_box_area(s->box[0]) / rk_box_area(node),
                                  rk_box_area(s->box[1]) / rk_box_area(node),
                                  s == best};
        if (!rk_driver_number_row(
                driver, "sah_binning_splits",
                "node candidate axis plane left right cost left_area right_area cheapest", 2,
                numbers, error))
            return false;
    }
    return true;
}

static bool put_triangles(const splits *c, const rk_driver *driver, rk_error *error)
{
    for (uint32_t i = 0; i < c->triangles; i++) {
        const rk_bvh_reference *r = &c->references[i];
        const rk_vec3 low = r->box.corner[0], high = r->box.corner[1], middle = r->centroid;
        const double numbers[] = {c->node,          r->triangle,     (double)low.x,
                                  (double)low.y,    (double)low.z,   (double)high.x,
                                  (double)high.y,   (double)high.z,  (double)middle.x,
                                  (double)middle.y, (double)middle.z};
        if (!rk_driver_number_row(
                driver, "sah_binning_triangles",
                "node triangle low0 low1 low2 high0 high1 high2 centroid0 centroid1 centroid2", 2,
                numbers, error))
            return false;
    }
    return true;
}

bool put_study(rk_driver *driver, rk_error *error)
{
    splits c;
    bool ok = list_splits(&c, driver, error) && put_splits(&c, driver, error) &&
              put_triangles(&c, driver, error);
    free(c.references);
    return ok;
}
