/* The stand-in for trees that are not solved yet: a sound tree with the same hits, built only where
 * the real one finds nothing. */
#include "test_scene.h"
#include "test_soup.h"

#include "accel/stand_in_tree.h"
#include "accel/trace.h"

static const char *const names[] = {"triangle", "cornell", "statue:967", "moving", "spheres"};
enum { name_count = sizeof names / sizeof *names };

static rk_mesh part_of(const rk_scene *scene, uint32_t first, uint32_t count)
{
    rk_mesh part = scene->mesh;
    part.triangles += first;
    part.triangle_materials += first;
    part.triangle_count = count;
    return part;
}

static void stand_in_trees_are_sound(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_accel accel;
        rk_error error;
        rk_check_ok(rk_accel_build_stand_in(&accel, &scene, &error), error);
        for (uint32_t k = 0; k <= scene.moving_count; k++) {
            rk_bvh *bvh = k ? &accel.moving[k - 1] : &accel.bvh;
            uint32_t first = k ? scene.moving[k - 1].first : 0;
            rk_mesh part = part_of(&scene, first, bvh->triangle_count);
            for (uint32_t t = 0; t < bvh->triangle_count; t++)
                bvh->triangles[t].index -= first;
            rk_check(rk_bvh_validate(bvh, &part, &error), "%s, part %u: %s", names[i], k,
                     error.text);
        }
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static void stand_in_trees_of_every_small_size_are_sound(void **state)
{
    (void)state;
    for (uint32_t count = 0; count < 70; count++) {
        rk_scene scene = test_scene_make(count);
        for (uint32_t i = 0; i < count; i++)
            test_scene_triangle(&scene, i, noise3(1, i), noise3(2, i), noise3(3, i));
        rk_accel accel;
        rk_error error;
        rk_check_ok(rk_accel_build_stand_in(&accel, &scene, &error), error);
        rk_check(rk_bvh_validate(&accel.bvh, &scene.mesh, &error), "%u triangles: %s", count,
                 error.text);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static rk_ray_batch make_rays(uint32_t key)
{
    rk_ray_batch rays = {.count = 0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rk_vec3 from = rk_scale(noise3(key, 2 * i), 3), to = noise3(key, 2 * i + 1);
        rk_ray ray = {from, rk_sub(to, from), i % 3 == 0 ? 0.9f : INFINITY};
        rk_batch_push(&rays, &ray);
    }
    return rays;
}

static void rays_find_the_same_hits_as_through_a_real_tree(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_accel real, stand_in;
        rk_error error;
        rk_counters counters = {0};
        rk_check_ok(rk_accel_build(&real, RK_ACCEL_SAH, &scene, &error) &&
                        rk_accel_build_stand_in(&stand_in, &scene, &error),
                    error);
        rk_ray_batch rays = make_rays(40 + (uint32_t)i);
        rk_hit_batch want, got;
        rk_occlusion_batch occluded, occluded_really;
        rk_accel_closest(&real, &rays, &want, &counters);
        rk_accel_closest(&stand_in, &rays, &got, &counters);
        rk_accel_occluded(&real, &rays, &occluded_really, &counters);
        rk_accel_occluded(&stand_in, &rays, &occluded, &counters);
        for (uint32_t k = 0; k < rays.count; k++)
            rk_check(got.t[k] == want.t[k] && got.triangle[k] == want.triangle[k] &&
                         occluded.occluded[k] == occluded_really.occluded[k],
                     "%s, ray %u: hit %d at %g, occluded %d; want %d at %g, %d", names[i], k,
                     (int)got.triangle[k], (double)got.t[k], occluded.occluded[k],
                     (int)want.triangle[k], (double)want.t[k], occluded_really.occluded[k]);
        rk_accel_free(&real);
        rk_accel_free(&stand_in);
        rk_scene_free(&scene);
    }
}

static void real_trees_find_triangles(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        for (int kind = RK_ACCEL_MEDIAN; kind <= RK_ACCEL_SAH_3; kind++) {
            rk_accel accel;
            rk_error error;
            rk_check_ok(rk_accel_build(&accel, (rk_accel_kind)kind, &scene, &error), error);
            rk_check(rk_accel_finds_triangles(&accel), "%s, kind %d: no triangle is found",
                     names[i], kind);
            rk_accel_free(&accel);
        }
        rk_scene_free(&scene);
    }
}

/* What the starters build. */
static void a_tree_with_an_empty_root_or_a_huge_leaf_finds_none(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("statue:967");
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    rk_bvh_node root = accel.bvh.nodes[0];
    accel.bvh.nodes[0] = (rk_bvh_node){rk_box_empty(), 0, 4};
    rk_check(!rk_accel_finds_triangles(&accel), "triangles are found through an empty box");
    accel.bvh.nodes[0] = (rk_bvh_node){root.box, 0, accel.bvh.triangle_count};
    rk_check(!rk_accel_finds_triangles(&accel), "a leaf of all triangles passes for a tree");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(stand_in_trees_are_sound),
    cmocka_unit_test(stand_in_trees_of_every_small_size_are_sound),
    cmocka_unit_test(rays_find_the_same_hits_as_through_a_real_tree),
    cmocka_unit_test(real_trees_find_triangles),
    cmocka_unit_test(a_tree_with_an_empty_root_or_a_huge_leaf_finds_none),
};

RK_SUITE("stand_in_tree", tests)
