/* Packets: rays that traverse a tree together have the same hits as each of them alone. */
#include "test_scene.h"
#include "test_soup.h"

#include "accel/packet.h"
#include "features/bvh_median.h"

/* Four rays from around one point to around another; every fourth packet has rays along an axis,
 * every third one bounded ones. Packets that are wide differ in the signs of their directions. */
static void make_packet(rk_ray *rays, uint32_t key, float width)
{
    rk_vec3 from = rk_scale(noise3(key, 0), 2), to = rk_scale(noise3(key, 1), 0.7f);
    for (uint32_t i = 0; i < RK_PACKET_MAX; i++) {
        rk_vec3 origin = rk_madd(from, noise3(key, 2 + i), width);
        rk_vec3 end = rk_madd(to, noise3(key, 10 + i), width);
        rays[i] = (rk_ray){origin, rk_sub(end, origin), INFINITY};
        if (key % 4 == 0)
            rays[i].direction = rk_vec(0, 0, origin.z < 0 ? 1 : -1);
        if (key % 3 == 0)
            rays[i].t_max = 0.6f + 0.5f * noise(key, 20, i);
    }
}

static void check_hit(const rk_hit *got, const rk_hit *want, uint32_t key, uint32_t i)
{
    rk_check(got->t == want->t && got->triangle == want->triangle && got->u == want->u &&
                 got->v == want->v,
             "packet %u, ray %u: hit triangle %d at %.9g, want %d at %.9g", key, i,
             (int)got->triangle, (double)got->t, (int)want->triangle, (double)want->t);
}

/* Returns the number of rays with a hit. */
static uint32_t check_packet(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, uint32_t key)
{
    rk_counters counters = {0};
    rk_hit hits[RK_PACKET_MAX];
    bool occluded[RK_PACKET_MAX];
    uint32_t hit_count = 0;
    rk_packet_closest(bvh, rays, count, hits, &counters);
    rk_packet_occluded(bvh, rays, count, occluded, &counters);
    for (uint32_t i = 0; i < count; i++) {
        rk_hit want = rk_bvh_closest(bvh, &rays[i], &counters);
        check_hit(&hits[i], &want, key, i);
        rk_check(occluded[i] == (want.triangle != RK_MISS), "packet %u, ray %u: is it occluded?",
                 key, i);
        hit_count += occluded[i];
    }
    return hit_count;
}

static const float widths[] = {0, 0x1p-20f, 0.01f, 0.5f};

static void check_tree(const rk_mesh *mesh, uint32_t packets, const char *name)
{
    rk_bvh bvh;
    rk_error error;
    uint32_t hit_count = 0;
    rk_check_ok(rk_bvh_build_median(&bvh, mesh, &error), error);
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++)
        for (uint32_t key = 0; key < packets; key++) {
            rk_ray rays[RK_PACKET_MAX];
            make_packet(rays, key, widths[w]);
            hit_count += check_packet(&bvh, rays, 1 + key % RK_PACKET_MAX, key);
        }
    rk_check(hit_count > packets, "%s: only %u rays have a hit", name, hit_count);
    rk_bvh_free(&bvh);
}

static void packets_find_the_hits_of_single_rays(void **state)
{
    (void)state;
    for (uint32_t triangles = 1; triangles <= 4096; triangles *= 8) {
        rk_mesh mesh = make_soup(triangles, 1.5f / cbrtf((float)triangles), triangles);
        check_tree(&mesh, 2000, "soup");
        rk_mesh_free(&mesh);
    }
}

/* Through edges and corners, where several triangles are hit at the same t. */
static void neighbours_that_share_an_edge_agree(void **state)
{
    (void)state;
    const char *const names[] = {"cube", "cornell", "statue:20000"};
    for (int i = 0; i < 3; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        check_tree(&scene.mesh, 2000, names[i]);
        rk_scene_free(&scene);
    }
    rk_scene scene = test_scene_builtin("cube");
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_median(&bvh, &scene.mesh, &error), error);
    for (uint32_t corner = 0; corner < scene.mesh.vertex_count; corner++)
        for (uint32_t key = 0; key < 50; key++) {
            rk_ray rays[RK_PACKET_MAX];
            rk_vec3 from = rk_scale(noise3(key, 0), 3);
            for (uint32_t i = 0; i < RK_PACKET_MAX; i++) {
                uint32_t end = (corner + i) % scene.mesh.vertex_count;
                rays[i] = (rk_ray){from, rk_sub(scene.mesh.positions[end], from), INFINITY};
            }
            check_packet(&bvh, rays, RK_PACKET_MAX, key);
        }
    rk_bvh_free(&bvh);
    rk_scene_free(&scene);
}

static void an_empty_tree_has_no_hits(void **state)
{
    (void)state;
    const rk_bvh nothing = {0};
    rk_ray rays[RK_PACKET_MAX];
    make_packet(rays, 1, 0);
    rk_check_equal(check_packet(&nothing, rays, RK_PACKET_MAX, 1), 0, "there is nothing");
}

static void packets_of_near_rays_need_fewer_tests(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("statue:20000");
    rk_bvh bvh;
    rk_error error;
    rk_counters together = {0}, single = {0};
    rk_check_ok(rk_bvh_build_median(&bvh, &scene.mesh, &error), error);
    for (uint32_t key = 0; key < 1000; key++) {
        rk_ray rays[RK_PACKET_MAX];
        rk_hit hits[RK_PACKET_MAX];
        make_packet(rays, key, 0x1p-10f);
        rk_packet_closest(&bvh, rays, RK_PACKET_MAX, hits, &together);
        for (uint32_t i = 0; i < RK_PACKET_MAX; i++)
            rk_bvh_closest(&bvh, &rays[i], &single);
    }
    rk_check(together.box_tests * 2 < single.box_tests &&
                 together.triangle_tests * 2 < single.triangle_tests,
             "%llu boxes and %llu triangles are tested together, %llu and %llu alone",
             (unsigned long long)together.box_tests, (unsigned long long)together.triangle_tests,
             (unsigned long long)single.box_tests, (unsigned long long)single.triangle_tests);
    rk_bvh_free(&bvh);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(packets_find_the_hits_of_single_rays),
    cmocka_unit_test(neighbours_that_share_an_edge_agree),
    cmocka_unit_test(an_empty_tree_has_no_hits),
    cmocka_unit_test(packets_of_near_rays_need_fewer_tests),
};

RK_SUITE("packet", tests)
