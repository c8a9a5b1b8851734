/* What the figure of chapter 2 follows: the splits of a node over twelve triangles along x, in six
 * bins, of which one is empty. */
#include "features/sah_binning.h"

#include <stdio.h>

enum { COUNT = 12, BINS = 6 };

/* The boxes of the triangles: low x and y, extents along x and y. */
static const float boxes[COUNT][4] = {
    {6.6f, 2.6f, 1.6f, .9f}, {.3f, .4f, 1.2f, 1.1f},  {3.4f, 3.2f, 1.3f, .8f},
    {9.5f, .6f, 1, 1.3f},    {1.6f, 2.1f, .9f, 1.5f}, {10.6f, 3.1f, .8f, .9f},
    {2.6f, .8f, 1.1f, .7f},  {.9f, 3.4f, .8f, .8f},   {7.3f, .7f, .9f, .8f},
    {4.2f, 1.6f, .7f, 1.2f}, {11.3f, 1.4f, .9f, 1},   {2.2f, 4.1f, 1, .6f},
};

/* Variables that the unit does not initialize at once are 0 until then, in every run. */
static __attribute__((noinline)) void clear_stack(void)
{
    volatile char below[1 << 16];
    for (size_t i = 0; i < sizeof below; i++)
        below[i] = 0;
}

int main(void)
{
    rk_bvh_reference references[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        const float *box = boxes[i];
        const rk_vec3 low = rk_vec(box[0], box[1], 0);
        const rk_vec3 high = rk_vec(low.x + box[2], low.y + box[3], .1f);
        references[i].box = (rk_box){{low, high}};
        references[i].centroid = rk_scale(rk_add(low, high), .5f);
        references[i].triangle = i;
    }
    const rk_sah_options options = {.bins = BINS, .all_axes = false};
    static rk_sah_split splits[RK_SAH_CANDIDATES_MAX];
    clear_stack();
    const uint32_t found = rk_sah_candidates(references, COUNT, &options, splits);
    printf("{\"cheapest\": %u, \"splits\": [",
           found ? rk_sah_cheapest(splits, found)->boundary : 0);
    for (uint32_t k = 0; k < found; k++)
        printf("%s[%u, %u, %u, %.9g]", k ? ", " : "", splits[k].boundary, splits[k].count[0],
               splits[k].count[1], splits[k].cost);
    printf("]}\n");
    return 0;
}
