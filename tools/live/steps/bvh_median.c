/* What the figures of chapter 1 that go step by step follow: the tree over 24 triangles, seen along
 * z as short lines, and a ray through it. */
#include "features/bvh_median.h"

#include <stdio.h>

enum { COUNT = 24 };

/* Where a triangle's line begins, and by how much it goes on to its end. */
static const float lines[COUNT][4] = {
    {9.3f, 2.4f, .7f, .5f},  {1.2f, 7.1f, .6f, -.4f},  {13.1f, 4.2f, .3f, .8f},
    {4.6f, 1.3f, .8f, .2f},  {11.2f, 8.3f, .5f, -.5f}, {6.4f, 6.2f, .2f, .8f},
    {14.6f, 1.6f, .7f, .3f}, {2.5f, 3.4f, .4f, .7f},   {8.2f, 8.6f, .8f, -.2f},
    {12.3f, 6.6f, .7f, .4f}, {3.7f, 8.4f, .5f, .5f},   {10.4f, 5.1f, .4f, -.8f},
    {.6f, 1.2f, .6f, .5f},   {5.3f, 4.1f, .3f, .7f},   {15.2f, 7.4f, -.3f, .8f},
    {7.5f, 2.1f, .6f, -.6f}, {1.8f, 5.2f, .7f, -.1f},  {13.8f, 8.9f, .6f, -.4f},
    {6.9f, 4.4f, .6f, .5f},  {11.7f, 1.1f, .4f, .7f},  {4.1f, 5.9f, .7f, .3f},
    {3.2f, 1.8f, .3f, -.8f}, {12.9f, 2.7f, .8f, -.2f}, {9.8f, 7.2f, .2f, .7f},
};

static bool make(rk_mesh *mesh, rk_error *error)
{
    const float half_height = .1f; /* so small that no box is longest along z */
    if (!rk_mesh_init(mesh, 3 * COUNT, COUNT, 1, 0, error))
        return false;
    for (uint32_t i = 0; i < COUNT; i++) {
        const float *line = lines[i];
        for (uint32_t k = 0; k < 3; k++) {
            const float along = (float)k / 2;
            mesh->positions[3 * i + k] =
                rk_vec(line[0] + along * line[2], line[1] + along * line[3],
                       k == 1 ? half_height : -half_height);
            mesh->triangles[i][k] = 3 * i + k;
        }
    }
    return true;
}

/* What the unit returns: the root's left half, and the hit. */
static void tell(const rk_bvh *bvh, const rk_hit *hit, const rk_counters *counters)
{
    const rk_bvh_range left = rk_bvh_range_of(bvh, bvh->nodes[0].first);
    printf("{\"left\": [");
    for (uint32_t i = 0; i < left.count; i++)
        printf("%s%u", i ? ", " : "", bvh->triangles[left.begin + i].index);
    printf("], \"triangle\": %u, \"t\": %.9g, \"box_tests\": %llu, \"triangle_tests\": %llu}\n",
           hit->triangle, (double)hit->t, (unsigned long long)counters->box_tests,
           (unsigned long long)counters->triangle_tests);
}

int main(void)
{
    rk_mesh mesh = {0};
    rk_bvh bvh = {0};
    rk_error error;
    bool ok = make(&mesh, &error) && rk_bvh_build_median(&bvh, &mesh, &error);
    if (ok) {
        const rk_vec3 origin = rk_vec(-.5f, 5, 0), target = rk_vec(16, 1, 0);
        const rk_ray ray = {origin, rk_normalize(rk_sub(target, origin)), INFINITY};
        rk_counters counters = {0};
        const rk_hit hit = rk_bvh_closest(&bvh, &ray, &counters);
        tell(&bvh, &hit, &counters);
    } else {
        fprintf(stderr, "%s\n", error.text);
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    return !ok;
}
