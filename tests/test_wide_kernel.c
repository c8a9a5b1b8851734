/* Batches through the wide tree by each instruction set that this machine has: the same hits as of
 * single rays through the binary tree, to the bit. */
#include "test_scene.h"
#include "test_soup.h"

#include "accel/build/wide_build.h"
#include "accel/kernel/wide_kernel.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"

static const char *const names[] = {"scalar", "sse2", "avx2", "avx512"};
enum { name_count = sizeof names / sizeof *names };

typedef struct trees {
    rk_bvh bvh;
    rk_wide_bvh wide;
} trees;

static trees build(const rk_mesh *mesh)
{
    const rk_sah_options options = {16, true};
    trees t;
    rk_error error;
    rk_check_ok(rk_bvh_build_sah(&t.bvh, mesh, &options, &error), error);
    rk_check_ok(
        rk_wide_bvh_build_parts(&t.wide, mesh, 0, mesh->triangle_count, RK_BUILD_SAH, NULL, &error),
        error);
    return t;
}

static void free_trees(trees *t)
{
    rk_wide_bvh_free(&t->wide);
    rk_bvh_free(&t->bvh);
}

/* Both queries by all instruction sets; returns the number of hits. */
static uint32_t check_batch(const trees *t, const rk_ray_batch *rays, const char *what,
                            uint32_t key)
{
    rk_counters counters = {0};
    rk_hit_batch want;
    uint32_t hit_count = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(&t->bvh, &ray, &counters);
        rk_batch_put_hit(&want, i, &hit);
        hit_count += hit.triangle != RK_MISS;
    }
    for (int k = 0; k < name_count; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
        rk_hit_batch got;
        rk_occlusion_batch answers;
        if (!kernel)
            continue;
        kernel->closest(&t->wide, rays, &got, &counters);
        kernel->occluded(&t->wide, rays, &answers, &counters);
        for (uint32_t i = 0; i < rays->count; i++) {
            bool same = memcmp(&got.t[i], &want.t[i], sizeof got.t[i]) == 0 || got.t[i] != got.t[i];
            rk_check(same && got.triangle[i] == want.triangle[i],
                     "%s, %s %u, ray %u: got triangle %d at t = %.9g, want %d at %.9g", names[k],
                     what, key, i, (int)got.triangle[i], (double)got.t[i], (int)want.triangle[i],
                     (double)want.t[i]);
            rk_check(
                want.triangle[i] == RK_MISS || (got.u[i] == want.u[i] && got.v[i] == want.v[i]),
                "%s, %s %u, ray %u: got u, v = %.9g, %.9g, want %.9g, %.9g", names[k], what, key, i,
                (double)got.u[i], (double)got.v[i], (double)want.u[i], (double)want.v[i]);
            rk_check(answers.occluded[i] == (want.triangle[i] != RK_MISS),
                     "%s, %s %u, ray %u: is it occluded?", names[k], what, key, i);
        }
    }
    return hit_count;
}

/* --- Rays ------------------------------------------------------------------------------------- */

/* From around one point to around another; narrow batches are traced as packets. */
static void fill(rk_ray_batch *rays, uint32_t key, float width)
{
    rk_vec3 from = rk_scale(noise3(key, 0), 2), to = rk_scale(noise3(key, 1), 0.7f);
    rays->count = 0;
    uint32_t count = 1 + rk_hash(key, 1, 2, 3) % RK_BATCH_MAX;
    for (uint32_t i = 0; i < count; i++) {
        rk_vec3 origin = rk_madd(from, noise3(key, 1000 + i), key % 2 ? width : 0);
        rk_vec3 end = rk_madd(to, noise3(key, 2000 + i), width);
        rk_ray ray = {origin, rk_sub(end, origin), INFINITY};
        if (key % 5 == 0 && i % 3 == 0)
            ray.direction = rk_vec(0, key % 2 ? -0.0f : 0, origin.z < 0 ? 1 : -1);
        if (key % 3 == 0)
            ray.t_max = 0.6f + 0.5f * noise(key, 20, i);
        if (key % 7 == 0) { /* lengths that nearly overflow or vanish */
            int exponent = key % 2 ? -110 : 100;
            ray.direction = rk_scale(ray.direction, ldexpf(1, exponent));
            ray.t_max = ldexpf(ray.t_max, -exponent);
        }
        rk_batch_push(rays, &ray);
    }
}

static const float widths[] = {0, 0x1p-20f, 0.01f, 0.1f, 1};

static void check_mesh(const rk_mesh *mesh, uint32_t batches, const char *what)
{
    trees t = build(mesh);
    uint32_t hit_count = 0;
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++)
        for (uint32_t key = 0; key < batches; key++) {
            rk_ray_batch rays;
            fill(&rays, key, widths[w]);
            hit_count += check_batch(&t, &rays, what, key);
        }
    rk_check(hit_count > batches, "%s: only %u rays have a hit", what, hit_count);
    free_trees(&t);
}

static void every_instruction_set_finds_the_hits_of_single_rays(void **state)
{
    (void)state;
    for (uint32_t triangles = 1; triangles <= 4096; triangles *= 8) {
        rk_mesh mesh = make_soup(triangles, 1.5f / cbrtf((float)triangles), triangles);
        check_mesh(&mesh, 24, "soup");
        rk_mesh_free(&mesh);
    }
}

/* Through edges and corners, where several triangles are hit at the same t, and float cannot tell
 * the sides. */
static void neighbours_that_share_an_edge_agree(void **state)
{
    (void)state;
    enum { side = 16 };
    rk_mesh mesh = make_mesh(2 * side * side);
    for (uint32_t i = 0; i < side * side; i++)
        for (uint32_t k = 0; k < 6; k++) {
            uint32_t corner = k < 3 ? k : 6 - k;
            mesh.positions[6 * i + k] =
                rk_vec((float)(i % side + (corner & 1)), (float)(i / side + (corner >> 1)), 0);
        }
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 64; key++) {
        rk_ray_batch rays = {.count = 0};
        rk_vec3 eye = rk_vec((float)(key % 8) * 2, (float)(key / 8) * 2, key % 2 ? 1 : 20);
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            rk_vec3 to = rk_vec((float)(i % 16) * 0.5f + 4, (float)(i / 16) * 0.5f + 4, 0);
            rk_ray ray = {eye, rk_sub(to, eye), key % 3 ? INFINITY : 1};
            rk_batch_push(&rays, &ray);
        }
        rk_check(check_batch(&t, &rays, "grid", key) == RK_BATCH_MAX,
                 "rays slip between triangles");
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

static void special_values_are_decided_alike(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(60, 0.5f, 3);
    trees t = build(&mesh);
    const float odd[] = {NAN, INFINITY, -INFINITY, -0.0f, 0, FLT_MIN / 4, -1};
    for (uint32_t k = 0; k < sizeof odd / sizeof *odd; k++)
        for (uint32_t i = 0; i < 7; i++) {
            rk_ray_batch rays = {.count = 0};
            for (uint32_t lane = 0; lane < 32; lane++) {
                float values[7] = {0, 0, -2, 0.1f, 0.1f, 1, INFINITY};
                if (lane % 4 == 0)
                    values[i] = odd[k];
                rk_ray ray = {rk_vec(values[0], values[1], values[2]),
                              rk_vec(values[3], values[4], values[5]), values[6]};
                rk_batch_push(&rays, &ray);
            }
            check_batch(&t, &rays, "special value", 10 * k + i);
        }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* Float cannot tell on which side of its own triangle such a ray starts. */
static void rays_that_start_on_triangles_agree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(400, 0.4f, 5);
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 60; key++) {
        rk_ray_batch rays = {.count = 0};
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            const uint32_t triangle = key % 2 ? i % 400 : key % 400;
            const rk_vec3 *corner = &mesh.positions[3 * triangle];
            float u = rk_unit_float(rk_hash(key, i, 1, 0)) * 0.5f;
            float v = rk_unit_float(rk_hash(key, i, 2, 0)) * 0.5f;
            rk_vec3 on = rk_madd(rk_madd(corner[0], rk_sub(corner[1], corner[0]), u),
                                 rk_sub(corner[2], corner[0]), v);
            rk_vec3 to =
                rk_madd(rk_scale(noise3(key, 7), 3), noise3(key, 100 + i), key % 3 ? 0.05f : 2);
            for (uint32_t step = key % 4; step > 0; step--)
                on.x = nextafterf(on.x, to.x);
            rk_ray ray = {on, rk_sub(to, on), key % 5 ? INFINITY : 1};
            rk_batch_push(&rays, &ray);
        }
        check_batch(&t, &rays, "from a triangle", key);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* There float cannot tell on which side of the edge a ray passes. */
static void rays_at_edges_agree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(64, 0.6f, 11);
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 90; key++) {
        rk_ray_batch rays = {.count = 0};
        const rk_vec3 eye = rk_scale(noise3(key, 1), 4);
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            const rk_vec3 *corner = &mesh.positions[3 * (key % 3 ? key % 64 : i % 64)];
            rk_vec3 to =
                rk_mix(corner[i % 3], corner[(i + 1) % 3], rk_unit_float(rk_hash(key, i, 3, 0)));
            rk_vec3 from = key % 2 ? eye : rk_madd(eye, noise3(key, 20 + i), 0.1f);
            rk_ray ray = {from, rk_sub(to, from), INFINITY};
            rk_batch_push(&rays, &ray);
        }
        check_batch(&t, &rays, "at an edge", key);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* Layers that are so close that bounds of t in float overlap, and some twice. */
static void the_closest_of_close_layers_is_found(void **state)
{
    (void)state;
    enum { layers = 24 };
    rk_mesh mesh = make_mesh(layers);
    for (uint32_t i = 0; i < layers; i++) {
        float z = 1 + (float)(rk_hash(i, 1, 0, 0) % 16) * 0x1p-23f;
        mesh.positions[3 * i] = rk_vec(-2, -2, z);
        mesh.positions[3 * i + 1] = rk_vec(4, -2, z + (float)(i % 3) * 0x1p-22f);
        mesh.positions[3 * i + 2] = rk_vec(-2, 4, z);
    }
    trees t = build(&mesh);
    uint32_t hit_count = 0;
    for (uint32_t key = 0; key < 40; key++) {
        rk_ray_batch rays = {.count = 0};
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            rk_vec3 from = rk_scale(noise3(key, key % 2 ? 3 : i), 0.5f);
            rk_vec3 to = rk_add(rk_scale(noise3(key, 500 + i), 0.3f), rk_vec(0, 0, 2));
            rk_ray ray = {from, rk_sub(to, from), INFINITY};
            rk_batch_push(&rays, &ray);
        }
        hit_count += check_batch(&t, &rays, "layers", key);
    }
    rk_check(hit_count > 1000, "only %u rays have a hit", hit_count);
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* The sides of a shaft along an axis stand still, and so do those in a plane. */
static void rays_along_axes_agree(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        rk_mesh mesh = make_soup(300, 0.5f, 8);
        for (uint32_t i = 0; axis == 2 && i < mesh.vertex_count; i++)
            mesh.positions[i].x = 0; /* flat, and so are boxes */
        trees t = build(&mesh);
        uint32_t hit_count = 0;
        for (uint32_t key = 0; key < 32; key++) {
            rk_ray_batch rays = {.count = 0};
            for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
                float zero = i % 2 ? -0.0f : 0.0f, x = (float)(i % 16) / 8 - 1;
                float y = (float)(i / 16) / 8 - 1;
                float slope = key % 4 < 2 ? zero : 0.01f * x;
                rk_vec3 from = axis == 0 ? rk_vec(x, y, -3) : rk_vec(-3, x, y);
                rk_vec3 way = axis == 0 ? rk_vec(slope, zero, 1) : rk_vec(1, zero, slope);
                if (key % 2 && axis < 2) {
                    from = rk_scale(from, -1);
                    way = rk_scale(way, -1);
                }
                rk_ray ray = {from, way, key % 8 ? INFINITY : 3.1f};
                rk_batch_push(&rays, &ray);
            }
            hit_count += check_batch(&t, &rays, "along an axis", key);
        }
        rk_check(hit_count > 500, "only %u rays have a hit", hit_count);
        free_trees(&t);
        rk_mesh_free(&mesh);
    }
}

static void triangles_without_area_are_missed(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(200, 0.2f, 3);
    for (uint32_t i = 0; i < 100; i++)
        mesh.positions[6 * i + 2] = mesh.positions[6 * i + (i % 2)];
    check_mesh(&mesh, 10, "flat triangles");
    rk_mesh_free(&mesh);
}

static void tiny_and_huge_scenes_agree(void **state)
{
    (void)state;
    const int exponents[] = {-90, -40, 40, 90};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        rk_mesh mesh = make_soup(200, 0.3f, 9);
        float scale = ldexpf(1, exponents[k]);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_scale(mesh.positions[i], scale);
        trees t = build(&mesh);
        for (uint32_t key = 0; key < 20; key++) {
            rk_ray_batch rays;
            fill(&rays, 7 * key + 1, widths[key % 5]);
            for (uint32_t i = 0; i < rays.count; i++) {
                rays.origin_x[i] *= scale;
                rays.origin_y[i] *= scale;
                rays.origin_z[i] *= scale;
                rays.t_max[i] *= scale;
            }
            check_batch(&t, &rays, "scaled", key);
        }
        free_trees(&t);
        rk_mesh_free(&mesh);
    }
}

static void a_tree_without_triangles_is_missed(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(0);
    trees t = build(&mesh);
    rk_ray_batch rays;
    fill(&rays, 1, 0.1f);
    rk_check_equal(check_batch(&t, &rays, "nothing", 0), 0, "there is nothing to hit");
    free_trees(&t);
    rk_mesh_free(&mesh);
}

static void packets_share_the_work(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(4096, 0.1f, 2);
    trees t = build(&mesh);
    rk_counters single = {0};
    rk_ray_batch rays = {.count = 0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rk_vec3 to = rk_vec((float)(i % 16) * 0.002f + 0.3f, (float)(i / 16) * 0.002f + 0.2f, 0);
        rk_ray ray = {rk_vec(0.1f, 0.1f, -3), rk_sub(to, rk_vec(0.1f, 0.1f, -3)), INFINITY};
        rk_batch_push(&rays, &ray);
        rk_ray_batch alone = {.count = 0};
        rk_hit_batch hit;
        rk_batch_push(&alone, &ray);
        rk_wide_kernel_best()->closest(&t.wide, &alone, &hit, &single);
    }
    for (int k = 0; k < name_count; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
        rk_hit_batch hits;
        rk_counters together = {0};
        if (!kernel)
            continue;
        kernel->closest(&t.wide, &rays, &hits, &together);
        /* Packets alone would need a sixteenth at least. */
        rk_check(together.box_tests < single.box_tests / 32,
                 "%s: %llu box tests for 256 nearly equal rays, %llu for each alone", names[k],
                 (unsigned long long)together.box_tests, (unsigned long long)single.box_tests);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* From neighbouring points to random points of a light above them. The signs of neighbours differ.
 */
static void fill_with_shadow_rays(rk_ray_batch *rays, uint32_t key, float width)
{
    rays->count = 0;
    for (uint32_t i = 0; i < RK_BATCH_MAX - key % 16; i++) {
        const rk_vec3 floor = {1, 0, 1}, center = rk_mul(noise3(key, 0), floor);
        const rk_vec3 at = rk_mul(noise3(key, 3000 + i), floor);
        const rk_vec3 to = rk_mul(noise3(key, 4000 + i), floor);
        const rk_vec3 origin = rk_add(rk_madd(center, at, width), rk_vec(0, -1.2f, 0));
        const rk_vec3 end = rk_add(rk_madd(center, to, 0.5f), rk_vec(0, 1.2f, 0));
        rk_ray ray = {origin, rk_sub(end, origin), 1};
        rk_batch_push(rays, &ray);
    }
}

static void shadow_rays_to_a_light_with_an_extent_agree(void **state)
{
    (void)state;
    for (uint32_t triangles = 8; triangles <= 4096; triangles *= 8) {
        rk_mesh mesh = make_soup(triangles, 1.5f / cbrtf((float)triangles), triangles);
        trees t = build(&mesh);
        uint32_t hit_count = 0;
        for (uint32_t key = 0; key < 40; key++) {
            rk_ray_batch rays;
            fill_with_shadow_rays(&rays, key, key % 2 ? 0.01f : 0.3f);
            hit_count += check_batch(&t, &rays, "light", key);
        }
        rk_check(hit_count > 1000 && hit_count < 40 * RK_BATCH_MAX - 1000,
                 "%u of the rays are occluded", hit_count);
        free_trees(&t);
        rk_mesh_free(&mesh);
    }
}

/* Registers of sixteen numbers trace such rays sorted, in packets; others need not. */
static void shadow_rays_of_different_signs_share_the_work(void **state)
{
    (void)state;
    const rk_wide_kernel *kernel = rk_wide_kernel_named("avx512", NULL);
    rk_mesh mesh = make_soup(4096, 0.02f, 2);
    trees t = build(&mesh);
    rk_counters single = {0}, together = {0};
    rk_ray_batch rays;
    rk_occlusion_batch answers;
    fill_with_shadow_rays(&rays, 16, 0.01f);
    for (uint32_t i = 0; kernel && i < rays.count; i++) {
        const rk_ray ray = rk_batch_ray(&rays, i);
        rk_ray_batch alone = {.count = 0};
        rk_batch_push(&alone, &ray);
        kernel->occluded(&t.wide, &alone, &answers, &single);
    }
    if (kernel)
        kernel->occluded(&t.wide, &rays, &answers, &together);
    rk_check(together.box_tests <= single.box_tests / 3,
             "%llu box tests for 256 shadow rays, %llu for each alone",
             (unsigned long long)together.box_tests, (unsigned long long)single.box_tests);
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* Of sixteen rays that are traced together one is NaN somewhere. */
static void a_nan_leaves_its_neighbours_alone(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(4096, 0.1f, 2);
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 7 * 16; key++) {
        rk_ray_batch rays = {.count = 0};
        for (uint32_t i = 0; i < 16; i++) {
            rk_vec3 from = rk_vec(0.1f, 0.1f, -3);
            rk_vec3 to = rk_vec((float)(i % 4) * 0.01f + 0.3f, (float)(i / 4) * 0.01f + 0.2f, 0);
            rk_ray ray = {from, rk_sub(to, from), INFINITY};
            rk_batch_push(&rays, &ray);
        }
        float *const numbers[7] = {rays.origin_x,    rays.origin_y,    rays.origin_z,   rays.t_max,
                                   rays.direction_x, rays.direction_y, rays.direction_z};
        numbers[key / 16][key % 16] = NAN;
        check_batch(&t, &rays, "NaN", key);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* In all directions, from everywhere, some with numbers that no packet takes. */
static void fill_with_scattered_rays(rk_ray_batch *rays, uint32_t count)
{
    const float odd[] = {NAN, INFINITY, -1, 0, FLT_MIN / 4};
    rays->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        rk_ray ray = {noise3(count, i), noise3(count, 5000 + i), INFINITY};
        const uint32_t any = rk_hash(count, i, 3, 1);
        float *const numbers[4] = {&ray.direction.x, &ray.direction.y, &ray.origin.z, &ray.t_max};
        if (any % 4 == 1)
            ray.t_max = 0.3f + 0.3f * noise(count, 40, i);
        if (any % 16 == 2)
            ray.direction = rk_vec(0, 0, 0);
        if (count % 3 == 0 && any % 16 == 3)
            *numbers[any / 16 % 4] = odd[any / 64 % 5];
        if (count % 7 == 0) /* at the same distance from several triangles */
            ray.origin = rk_vec(roundf(ray.origin.x * 8), roundf(ray.origin.y * 8), 1);
        rk_batch_push(rays, &ray);
    }
}

/* Packets that are not full, or begin near the end of a batch. */
static void scattered_rays_agree_in_batches_of_all_sizes(void **state)
{
    (void)state;
    rk_mesh soup = make_soup(2000, 0.2f, 4);
    for (uint32_t i = 0; i < 400; i++) /* twice */
        for (uint32_t k = 0; k < 3; k++)
            soup.positions[3 * (1000 + i) + k] = soup.positions[3 * i + k];
    trees t = build(&soup);
    uint32_t hit_count = 0;
    for (uint32_t count = 1; count <= RK_BATCH_MAX; count += count < 100 ? 1 : 13) {
        rk_ray_batch rays;
        fill_with_scattered_rays(&rays, count);
        hit_count += check_batch(&t, &rays, "scattered, rays", count);
    }
    rk_check(hit_count > 2000, "only %u rays have a hit", hit_count);
    free_trees(&t);
    rk_mesh_free(&soup);
}

static void scattered_rays_share_the_work(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(4096, 0.05f, 2);
    trees t = build(&mesh);
    for (int k = 0; k < name_count; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
        rk_counters single = {0}, together = {0};
        rk_ray_batch rays;
        rk_hit_batch hits;
        if (!kernel)
            continue;
        fill_with_scattered_rays(&rays, RK_BATCH_MAX);
        kernel->closest(&t.wide, &rays, &hits, &together);
        for (uint32_t i = 0; i < rays.count; i++) {
            const rk_ray ray = rk_batch_ray(&rays, i);
            rk_ray_batch alone = {.count = 0};
            rk_batch_push(&alone, &ray);
            kernel->closest(&t.wide, &alone, &hits, &single);
        }
        rk_check(3 * together.box_tests < 2 * single.box_tests,
                 "%s: %llu box tests for 256 scattered rays, %llu for each alone", names[k],
                 (unsigned long long)together.box_tests, (unsigned long long)single.box_tests);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

static rk_counters count_closest(const rk_wide_kernel *kernel, const trees *t,
                                 const rk_ray_batch *rays)
{
    rk_counters counters = {0};
    rk_hit_batch hits;
    kernel->closest(&t->wide, rays, &hits, &counters);
    return counters;
}

/* A soup that is moved by so much, behind a triangle that hides it, at z = 1. */
static rk_mesh make_soup_behind_wall(rk_vec3 by)
{
    rk_mesh mesh = make_soup(4096, 0.1f, 2);
    for (uint32_t k = 0; k < mesh.vertex_count; k++)
        mesh.positions[k] = rk_add(mesh.positions[k], by);
    for (uint32_t k = 0; k < 3; k++)
        mesh.positions[k] = rk_vec((float)k * 20 - 20, k == 1 ? 20 : -20, 1);
    return mesh;
}

/* In all directions upwards, so that all have the same signs. */
static rk_ray upward(uint32_t key, uint32_t i)
{
    const rk_vec3 n = noise3(key, 7000 + i);
    return (rk_ray){rk_scale(noise3(key, i), 0.5f), rk_vec(fabsf(n.x), fabsf(n.y), 1), INFINITY};
}

/* Rays that do not travel as a tile look behind a wall that all of them hit at most where they had
 * been about to go: a packet with masks visits the root's other children. */
static void a_wall_ends_scattered_rays(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup_behind_wall(rk_vec(2, 2, 3));
    trees t = build(&mesh);
    rk_ray_batch rays = {.count = 0}, short_rays;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        const rk_ray ray = upward(1, i);
        rk_batch_push(&rays, &ray);
    }
    const uint64_t limit[] = {4, 2}; /* without an end: 27 times and more */
    short_rays = rays;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++)
        short_rays.t_max[i] = (1 - rays.origin_z[i]) * 1.001f;
    rk_check_equal(check_batch(&t, &rays, "wall", 0), RK_BATCH_MAX, "all rays hit the wall");
    for (int k = 0; k < name_count; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
        rk_occlusion_batch answers;
        if (!kernel)
            continue;
        rk_counters got[2] = {count_closest(kernel, &t, &rays)};
        rk_counters want[2] = {count_closest(kernel, &t, &short_rays)};
        kernel->occluded(&t.wide, &rays, &answers, &got[1]);
        kernel->occluded(&t.wide, &short_rays, &answers, &want[1]);
        for (int q = 0; q < 2; q++)
            rk_check(got[q].box_tests <= limit[q] * want[q].box_tests,
                     "%s, %s: %llu boxes are tested, %llu by rays that end at the wall", names[k],
                     q ? "occlusion" : "closest hits", (unsigned long long)got[q].box_tests,
                     (unsigned long long)want[q].box_tests);
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* Rays that touch a box at its corner alone, where the triangle has a vertex: they enter and leave
 * it at t = 1, whose two roundings must not lose the triangle. Whole numbers are exact. */
static void rays_at_the_corner_of_a_box_agree(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(1);
    mesh.positions[0] = rk_vec(0, 0, 0);
    mesh.positions[1] = rk_vec(1, 0, 1);
    mesh.positions[2] = rk_vec(0, 1, 1);
    trees t = build(&mesh);
    uint32_t hit_count = 0;
    for (uint32_t key = 0; key < 200; key++) {
        const uint32_t apart = key % 2 ? 4000 : 4; /* in all directions, or nearly one */
        rk_ray_batch rays = {.count = 0};
        for (uint32_t i = 0; i < 1 + key; i++) {
            float to[3];
            for (uint32_t k = 0; k < 3; k++)
                to[k] = (float)((key % 4 < 2 ? 1u : 3000u) + rk_hash(key, i, k, 8) % apart);
            const rk_vec3 direction = rk_vec(to[0], -to[1], to[2]);
            const rk_ray ray = {rk_scale(direction, -1), direction, INFINITY};
            rk_batch_push(&rays, &ray);
        }
        hit_count += check_batch(&t, &rays, "corner", key);
    }
    rk_check(hit_count > 1000, "only %u rays have a hit", hit_count);
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* The last t_max that leaves a hit, and the one before it. */
static void rays_that_end_at_their_hits_agree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(500, 0.3f, 9);
    trees t = build(&mesh);
    uint32_t hit_count = 0;
    for (uint32_t key = 0; key < 40; key++) {
        rk_ray_batch rays = {.count = 0};
        rk_counters counters = {0};
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            rk_ray ray = {noise3(key, key % 2 ? i : 0), noise3(key, 900 + i), INFINITY};
            const rk_hit hit = rk_bvh_closest(&t.bvh, &ray, &counters);
            ray.t_max = i % 2 ? hit.t : nextafterf(hit.t, 0);
            rk_batch_push(&rays, &ray);
        }
        hit_count += check_batch(&t, &rays, "to its hit", key);
    }
    rk_check(hit_count > 1000, "only %u rays have a hit", hit_count);
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* --- Tiles ------------------------------------------------------------------------------------ */

/* A camera's tile: 256 rays from one point, away from the origin, through a square near it. No
 * component of a direction is 0 or changes its sign. */
static void fill_tile(rk_ray_batch *rays, uint32_t octant, rk_vec3 to, float width)
{
    const rk_vec3 eye = rk_vec(octant & 1 ? 3 : -3, octant & 2 ? 2.5f : -2.5f, octant & 4 ? 2 : -2);
    rays->count = 0;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        const float x = (float)(i % 16) / 16 - 0.5f, y = (float)(i / 16) / 16 - 0.5f;
        const rk_vec3 at = rk_madd(to, rk_vec(x, y, -x), width);
        rk_ray ray = {eye, rk_sub(at, eye), INFINITY};
        rk_batch_push(rays, &ray);
    }
}

static void tiles_find_the_hits_of_single_rays(void **state)
{
    (void)state;
    for (uint32_t triangles = 1; triangles <= 4096; triangles *= 8) {
        rk_mesh mesh = make_soup(triangles, 1.5f / cbrtf((float)triangles), triangles);
        trees t = build(&mesh);
        uint32_t hit_count = 0;
        for (uint32_t key = 0; key < 80; key++) {
            rk_ray_batch rays;
            fill_tile(&rays, key % 8, rk_scale(noise3(key, 0), 0.7f), widths[key % 5]);
            for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
                if (key % 3 == 0) /* in units of the way to the square */
                    rays.t_max[i] = 1 + 0.4f * noise(key, 20, i);
                if (key % 4 == 1 && i % 5 == 0)
                    rays.t_max[i] = i % 2 ? 0 : -0.0f;
            }
            hit_count += check_batch(&t, &rays, "tile", key);
        }
        rk_check(hit_count > 500, "only %u rays have a hit", hit_count);
        free_trees(&t);
        rk_mesh_free(&mesh);
    }
}

/* A tile goes as far as the longest of its rays. */
static void rays_of_a_tile_end_where_each_does(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(512, 0.3f, 5);
    trees t = build(&mesh);
    uint32_t hit_count = 0;
    for (uint32_t lane = 0; lane < 16; lane++)
        for (uint32_t octant = 0; octant < 8; octant++) {
            rk_ray_batch rays;
            fill_tile(&rays, octant, rk_vec(0, 0.1f, 0), 0.7f);
            for (uint32_t i = 0; i < RK_BATCH_MAX; i++)
                if ((octant % 2 ? i % 16 : i / 16) == lane)
                    rays.t_max[i] = 0.1f;
            hit_count += check_batch(&t, &rays, "tile, lane", lane);
        }
    rk_check(hit_count > 10000, "only %u rays have a hit", hit_count);
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* Behind a wall, which all rays hit, nothing is looked at: the counts are those of rays that end
 * there. */
static void a_wall_hides_what_is_behind(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup_behind_wall(rk_vec(0, 0, 3));
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 4; key++) {
        rk_ray_batch rays, short_rays;
        fill_tile(&rays, key, rk_vec(0, 0, 3), 1);
        short_rays = rays;
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++)
            short_rays.t_max[i] = 3 / rays.direction_z[i] * 1.001f;
        rk_check_equal(check_batch(&t, &rays, "wall", key), RK_BATCH_MAX, "all rays hit the wall");
        check_batch(&t, &short_rays, "wall", key);
        for (int k = 0; k < name_count; k++) {
            const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
            if (!kernel)
                continue;
            const rk_counters got = count_closest(kernel, &t, &rays);
            const rk_counters want = count_closest(kernel, &t, &short_rays);
            rk_check(got.box_tests <= want.box_tests + 16 &&
                         got.triangle_tests <= want.triangle_tests + 128,
                     "%s: %llu boxes and %llu triangles are tested, %llu and %llu by rays that end "
                     "at the wall",
                     names[k], (unsigned long long)got.box_tests,
                     (unsigned long long)got.triangle_tests, (unsigned long long)want.box_tests,
                     (unsigned long long)want.triangle_tests);
        }
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* The others' hits are written, too. */
static void one_packet_of_a_tile_hits(void **state)
{
    (void)state;
    for (uint32_t packet = 0; packet < RK_BATCH_MAX / 16; packet++) {
        rk_ray_batch rays;
        fill_tile(&rays, packet % 8, rk_vec(0.1f, 0.2f, 0), 1);
        const rk_ray middle = rk_batch_ray(&rays, 16 * packet + 8);
        rk_mesh mesh = make_soup(200, 0.5f, 4);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] =
                rk_madd(rk_add(middle.origin, middle.direction), mesh.positions[i], 0.02f);
        trees t = build(&mesh);
        const uint32_t hit_count = check_batch(&t, &rays, "one packet", packet);
        rk_check(hit_count > 0 && hit_count < 16, "%u rays have a hit", hit_count);
        free_trees(&t);
        rk_mesh_free(&mesh);
    }
}

enum { x, y, z, t_max, to_x, to_y, to_z, one_fewer };

static void change(rk_ray_batch *rays, uint32_t number, uint32_t ray, float value)
{
    float *const numbers[one_fewer] = {rays->origin_x,   rays->origin_y,    rays->origin_z,
                                       rays->t_max,      rays->direction_x, rays->direction_y,
                                       rays->direction_z};
    if (number == one_fewer)
        rays->count--;
    else
        numbers[number][ray] = value;
}

/* One number of one ray decides whether a batch is a tile: if it is, and misses all, it tests the
 * boxes of one node, else at least one per packet. */
static void a_tile_that_misses_tests_one_node(void **state)
{
    (void)state;
    static const struct {
        uint32_t number, ray;
        float value;
        bool is_tile;
    } cases[] = {
        {t_max, 17, 0, true},        {t_max, 17, -0.0f, true},   {t_max, 17, 1, true},
        {t_max, 17, NAN, false},     {t_max, 3, NAN, false},     {t_max, 255, NAN, false},
        {t_max, 17, -1, false},      {x, 17, -3.001f, false},    {y, 17, -2.5001f, false},
        {z, 200, -2.001f, false},    {x, 0, NAN, false},         {y, 17, NAN, false},
        {to_x, 17, -1, false},       {to_y, 0, -1, false},       {to_z, 255, -1, false},
        {to_x, 17, 0, false},        {to_y, 17, -0.0f, false},   {to_z, 17, 0x1p-61f, false},
        {to_x, 17, NAN, false},      {to_y, 3, NAN, false},      {to_z, 255, NAN, false},
        {to_x, 17, INFINITY, false}, {to_y, 17, 0x1p41f, false}, {to_y, 17, 2, true},
        {one_fewer, 255, 0, false},
    };
    rk_mesh mesh = make_soup(400, 0.2f, 6);
    trees t = build(&mesh);
    for (uint32_t key = 0; key < 2 * sizeof cases / sizeof *cases; key++) {
        const uint32_t i = key / 2, octant = key % 2 ? 7 : 0; /* all directions backward */
        const float sign = octant && cases[i].number >= to_x ? -1 : 1;
        const float value = sign * cases[i].value;
        rk_ray_batch rays;
        fill_tile(&rays, octant, rk_vec(0, 0, 0), 1);
        change(&rays, cases[i].number, cases[i].ray, value);
        check_batch(&t, &rays, "case", i);
        fill_tile(&rays, octant, rk_vec(octant ? -50 : 50, 0, octant ? -50 : 50), 1);
        change(&rays, cases[i].number, cases[i].ray, value);
        check_batch(&t, &rays, "case that misses", i);
        for (int k = 0; k < name_count; k++) {
            const rk_wide_kernel *kernel = rk_wide_kernel_named(names[k], NULL);
            const uint64_t boxes = kernel ? count_closest(kernel, &t, &rays).box_tests : 0;
            rk_check(!kernel || (cases[i].is_tile ? boxes == RK_WIDE_CHILDREN
                                                  : boxes >= 15 * RK_WIDE_CHILDREN),
                     "%s, case %u: %llu boxes are tested", names[k], i, (unsigned long long)boxes);
        }
    }
    free_trees(&t);
    rk_mesh_free(&mesh);
}

/* --- The choice ------------------------------------------------------------------------------- */

static void unknown_instruction_sets_are_refused(void **state)
{
    (void)state;
    rk_error error;
    rk_check(!rk_wide_kernel_named("avx1024", &error), "there is no AVX-1024");
    rk_check_error_names(error, "RAYKIT_ISA=avx1024");
    rk_check_error_names(error, "scalar, sse2, avx2 or avx512");
    rk_check(rk_wide_kernel_named("scalar", &error) != NULL, "every machine has scalar");
    rk_check(rk_wide_kernel_named(NULL, &error) != NULL, "every machine has one");
}

static void pictures_are_the_same_to_the_bit(void **state)
{
    (void)state;
    rk_error error;
    rk_image want = {0};
    const char *chosen = getenv("RAYKIT_ISA");
    char kept[16] = "";
    if (chosen)
        snprintf(kept, sizeof kept, "%s", chosen);
    rk_scene scene = test_scene_builtin("moving");
    for (int k = -1; k < name_count; k++) {
        if (k >= 0 && !rk_wide_kernel_named(names[k], NULL))
            continue;
        if (k >= 0)
            setenv("RAYKIT_ISA", names[k], 1);
        rk_accel accel;
        rk_image image;
        rk_counters counters;
        rk_render_options options = rk_render_options_default();
        options.width = options.height = 48;
        options.shadows = true;
        options.motion.samples = 4;
        rk_pool *pool = rk_pool_start(2, &error);
        rk_check_ok(pool != NULL, error);
        rk_check_ok(rk_accel_build(&accel, k < 0 ? RK_ACCEL_SAH_3 : RK_ACCEL_WIDE, &scene, &error),
                    error);
        rk_check(k < 0 || strcmp(rk_accel_isa(accel.kind), names[k]) == 0,
                 "it traces by %s, not %s", rk_accel_isa(accel.kind), k < 0 ? "" : names[k]);
        rk_check_ok(rk_image_init(&image, options.width, options.height, &error), error);
        rk_check_ok(rk_render(&image, &scene, &accel, &options, pool, &counters, NULL, &error),
                    error);
        rk_check(k < 0 || test_same_pixels(&image, &want), "%s draws another picture than sah3",
                 k < 0 ? "" : names[k]);
        if (k < 0)
            want = image;
        else
            rk_image_free(&image);
        rk_accel_free(&accel);
        rk_pool_stop(pool);
    }
    setenv("RAYKIT_ISA", "mmx", 1);
    rk_accel accel;
    rk_check(!rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, &error), "RAYKIT_ISA=mmx is accepted");
    rk_check_error_names(error, "RAYKIT_ISA=mmx");
    if (kept[0])
        setenv("RAYKIT_ISA", kept, 1);
    else
        unsetenv("RAYKIT_ISA");
    rk_image_free(&want);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(unknown_instruction_sets_are_refused),
    cmocka_unit_test(a_tree_without_triangles_is_missed),
    cmocka_unit_test(every_instruction_set_finds_the_hits_of_single_rays),
    cmocka_unit_test(neighbours_that_share_an_edge_agree),
    cmocka_unit_test(special_values_are_decided_alike),
    cmocka_unit_test(rays_that_start_on_triangles_agree),
    cmocka_unit_test(rays_at_edges_agree),
    cmocka_unit_test(the_closest_of_close_layers_is_found),
    cmocka_unit_test(rays_along_axes_agree),
    cmocka_unit_test(triangles_without_area_are_missed),
    cmocka_unit_test(tiny_and_huge_scenes_agree),
    cmocka_unit_test(shadow_rays_to_a_light_with_an_extent_agree),
    cmocka_unit_test(packets_share_the_work),
    cmocka_unit_test(scattered_rays_agree_in_batches_of_all_sizes),
    cmocka_unit_test(scattered_rays_share_the_work),
    cmocka_unit_test(a_wall_ends_scattered_rays),
    cmocka_unit_test(rays_at_the_corner_of_a_box_agree),
    cmocka_unit_test(rays_that_end_at_their_hits_agree),
    cmocka_unit_test(shadow_rays_of_different_signs_share_the_work),
    cmocka_unit_test(a_nan_leaves_its_neighbours_alone),
    cmocka_unit_test(tiles_find_the_hits_of_single_rays),
    cmocka_unit_test(rays_of_a_tile_end_where_each_does),
    cmocka_unit_test(a_wall_hides_what_is_behind),
    cmocka_unit_test(one_packet_of_a_tile_hits),
    cmocka_unit_test(a_tile_that_misses_tests_one_node),
    cmocka_unit_test(pictures_are_the_same_to_the_bit),
};

RK_SUITE("wide_kernel", tests)
