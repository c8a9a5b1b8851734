/* What make bench-peers compares with Embree, without Embree: the rays, raykit's answers to them,
 * the causes of differences by cases that are known, and the tables. */
#include "test.h"

#include "peers/measure.h"
#include "peers/rays.h"
#include "peers/scenes.h"
#include "peers/tables.h"

#include "features/watertight.h"
#include "render/render.h"
#include "test_folder.h"

#include <time.h>

enum { side = 2 * RK_TILE_SIDE };

/* --- Rays ------------------------------------------------------------------------------------- */

typedef struct traced {
    rk_scene scene;
    peers_engine *engine;
    rk_pool *pool;
    peers_lanes lanes;
} traced;

static traced open_scene(const char *name)
{
    traced t = {0};
    rk_error error;
    rk_check_ok(peers_scene(&t.scene, name, &error), error);
    return t;
}

/* After the scene has its final address. */
static void open_engine(traced *t)
{
    rk_error error = {""};
    double seconds, bytes;
    t->engine = peers_raykit_open(&t->scene, &error);
    rk_check(t->engine, "%s", error.text);
    for (uint32_t tree = 0; tree < t->engine->tree_count; tree++)
        rk_check_ok(t->engine->build(t->engine, tree, 1, &seconds, &bytes, &error), error);
    t->pool = rk_pool_start(2, &error);
    rk_check(t->pool, "%s", error.text);
    rk_check_ok(peers_lanes_init(&t->lanes, 2, &t->engine, 1, &error), error);
}

static void close_all(traced *t)
{
    peers_lanes_free(&t->lanes);
    rk_pool_stop(t->pool);
    t->engine->close(t->engine);
    rk_scene_free(&t->scene);
}

static peers_rays make_rays(const traced *t, peers_workload workload, uint32_t pixels)
{
    peers_rays rays;
    rk_error error;
    rk_check_ok(peers_rays_make(&rays, workload, peers_raykit_accel(t->engine), pixels, &error),
                error);
    return rays;
}

static void camera_rays_are_those_of_the_picture(void **state)
{
    (void)state;
    traced t = open_scene("statue:1000");
    open_engine(&t);
    peers_rays rays = make_rays(&t, PEERS_PRIMARY, side);
    const rk_view view = rk_view_of(&t.scene.camera, side, side);
    rk_check_equal(peers_ray_count(&rays), side * side, "one ray per pixel");
    uint32_t seen[side * side] = {0};
    for (uint32_t i = 0; i < side * side; i++) {
        const rk_ray ray = rk_batch_ray(&rays.batches[i / RK_BATCH_MAX], i % RK_BATCH_MAX);
        rk_vec2 pixel;
        float depth;
        rk_check(rk_view_project(&view, rk_add(ray.origin, ray.direction), &pixel, &depth),
                 "ray %u points away from the picture", i);
        seen[(uint32_t)pixel.y * side + (uint32_t)pixel.x]++;
        /* Four consecutive rays pass through a square of 2 x 2 pixels. */
        const rk_ray first = rk_batch_ray(&rays.batches[i / RK_BATCH_MAX], i % RK_BATCH_MAX & ~3u);
        rk_vec2 corner;
        rk_view_project(&view, rk_add(first.origin, first.direction), &corner, &depth);
        const int right_of = (int)pixel.x - (int)corner.x, below = (int)pixel.y - (int)corner.y;
        rk_check((right_of | below) >> 1 == 0,
                 "ray %u is %d to the right of its square's, %d below", i, right_of, below);
    }
    for (uint32_t i = 0; i < side * side; i++)
        rk_check(seen[i] == 1, "pixel %u has %u rays", i, seen[i]);
    peers_rays_free(&rays);
    close_all(&t);
}

static void rays_are_the_same_on_every_call(void **state)
{
    (void)state;
    traced t = open_scene("room:1000");
    open_engine(&t);
    for (uint32_t w = 0; w < PEERS_WORKLOADS; w++) {
        peers_rays a = make_rays(&t, (peers_workload)w, side);
        peers_rays b = make_rays(&t, (peers_workload)w, side);
        rk_check(peers_ray_count(&a) > 0 && a.batch_count == b.batch_count &&
                     memcmp(a.batches, b.batches, a.batch_count * sizeof *a.batches) == 0,
                 "%s: other rays on the second call", peers_workload_names.items[w]);
        peers_rays_free(&a);
        peers_rays_free(&b);
    }
    close_all(&t);
}

static void batches_are_full_but_the_last(void **state)
{
    (void)state;
    traced t = open_scene("statue:1000");
    open_engine(&t);
    for (uint32_t w = 0; w < PEERS_WORKLOADS; w++) {
        peers_rays rays = make_rays(&t, (peers_workload)w, 4 * RK_TILE_SIDE);
        for (size_t b = 0; b < rays.batch_count; b++)
            rk_check(rays.batches[b].count == RK_BATCH_MAX ||
                         (b + 1 == rays.batch_count && rays.batches[b].count > 0),
                     "%s: batch %zu of %zu has %u rays", peers_workload_names.items[w], b,
                     rays.batch_count, rays.batches[b].count);
        peers_rays_free(&rays);
    }
    close_all(&t);
}

static void shadow_rays_end_at_the_light(void **state)
{
    (void)state;
    traced t = open_scene("statue:1000");
    open_engine(&t);
    const rk_vec3 light = t.scene.lights[0].position;
    for (uint32_t w = PEERS_POINT_SHADOW; w <= PEERS_AREA_SHADOW; w++) {
        peers_rays rays = make_rays(&t, (peers_workload)w, side);
        float farthest = 0;
        for (size_t i = 0; i < peers_ray_count(&rays); i++) {
            const rk_ray ray = rk_batch_ray(&rays.batches[i / RK_BATCH_MAX], i % RK_BATCH_MAX);
            if (w == PEERS_POINT_SHADOW) {
                const rk_vec3 to_light = rk_sub(light, ray.origin);
                rk_check(memcmp(&to_light, &ray.direction, sizeof to_light) == 0,
                         "ray %zu does not go from its origin to the light", i);
            }
            const rk_vec3 away = rk_sub(rk_madd(ray.origin, ray.direction, ray.t_max), light);
            farthest = rk_max(farthest, rk_max(fabsf(away.x), fabsf(away.z)));
            /* The light is 4 units away, and the sum has three roundings. */
            rk_check_near(away.y, 0, 0x1p-20, "height of ray %zu's end above the light", i);
        }
        if (w == PEERS_POINT_SHADOW)
            rk_check_close(farthest, 0, 0x1p-20, "a point light has no extent");
        else /* among hundreds of points, one is in the outer tenth */
            rk_check(farthest > 0.45f && farthest <= 0.5f + 0x1p-20f,
                     "ends are up to %g from the light's centre, not 0.5", (double)farthest);
        peers_rays_free(&rays);
    }
    close_all(&t);
}

static void there_are_as_many_shadow_rays_as_the_renderer_sends(void **state)
{
    (void)state;
    traced t = open_scene("statue:1000");
    open_engine(&t);
    rk_image image;
    rk_error error;
    rk_counters counters;
    rk_render_options options = rk_render_options_default();
    options.width = options.height = 4 * side;
    options.shadows = true;
    rk_check_ok(rk_image_init(&image, 4 * side, 4 * side, &error), error);
    rk_check_ok(rk_render(&image, &t.scene, peers_raykit_accel(t.engine), &options, t.pool,
                          &counters, NULL, &error),
                error);
    peers_rays rays = make_rays(&t, PEERS_POINT_SHADOW, 4 * side);
    rk_check_equal(peers_ray_count(&rays), counters.shadow_rays, "points that face the light");
    peers_rays_free(&rays);
    rk_image_free(&image);
    close_all(&t);
}

static void the_room_is_closed_and_faces_inwards(void **state)
{
    (void)state;
    traced t = open_scene("room:1000");
    const rk_mesh *room = &t.scene.mesh;
    rk_error error;
    double volume = 0;
    rk_check_ok(rk_mesh_validate(room, "room", &error), error);
    for (uint32_t i = 1000; i < room->triangle_count; i++) {
        const uint32_t *k = room->triangles[i];
        const rk_vec3 a = room->positions[k[0]];
        const rk_vec3 normal =
            rk_cross(rk_sub(room->positions[k[1]], a), rk_sub(room->positions[k[2]], a));
        rk_check(rk_dot(normal, a) < 0, "triangle %u faces outwards", i);
        volume -= (double)rk_dot(normal, a) / 6;
    }
    /* Whole numbers, which float holds exactly, over 6. */
    rk_check_close(volume, 8 * 8 * 8, 1e-9, "tetrahedra from the centre fill the room");
    rk_scene_free(&t.scene);
}

static void in_the_room_every_camera_ray_hits(void **state)
{
    (void)state;
    traced t = open_scene("room:1000");
    open_engine(&t);
    peers_rays rays = make_rays(&t, PEERS_PRIMARY, side);
    static peers_hit hits[side * side];
    rk_check_equal(t.scene.mesh.triangle_count, 1012,
                   "a statue of 1000 triangles and 12 of the box");
    peers_answers(t.engine, t.engine->modes[t.engine->usual], &rays, &t.lanes, hits);
    uint32_t walls = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        rk_check(hits[i].triangle != RK_MISS, "ray %u leaves the room", i);
        walls += hits[i].triangle >= 1000;
    }
    rk_check(walls > 0 && walls < side * side, "%u of %d rays hit walls", walls, side * side);
    peers_rays_free(&rays);
    close_all(&t);
}

static void scenes_that_embree_would_not_see_whole_are_refused(void **state)
{
    (void)state;
    rk_scene scene;
    rk_error error;
    rk_check(!peers_scene(&scene, "shininess", &error), "shininess consists of spheres");
    rk_check_error_names(error, "spheres");
    rk_check(!peers_scene(&scene, "room:0", &error), "a statue has triangles");
    rk_check_error_names(error, "statue:0");
}

/* --- raykit's answers ------------------------------------------------------------------------- */

static void all_trees_give_the_same_answers(void **state)
{
    (void)state;
    traced t = open_scene("room:1000");
    open_engine(&t);
    static peers_hit hits[16 * side * side];
    for (uint32_t w = 0; w < PEERS_WORKLOADS; w++) {
        peers_rays rays = make_rays(&t, (peers_workload)w, 4 * side);
        peers_answers(t.engine, t.engine->modes[t.engine->usual], &rays, &t.lanes, hits);
        for (uint32_t m = 0; m < t.engine->mode_count; m++) {
            const peers_differences found =
                peers_compare(t.engine, t.engine->modes[m], &rays, t.pool, &t.lanes, hits);
            rk_check_equal(peers_mismatches(&found), 0, "all trees decide exactly");
            rk_check_equal(found.rays[PEERS_SAME], peers_ray_count(&rays), "every ray is compared");
        }
        peers_rays_free(&rays);
    }
    close_all(&t);
}

static void answers_have_the_normal_of_the_triangle(void **state)
{
    (void)state;
    traced t = open_scene("cube");
    open_engine(&t);
    peers_rays rays = make_rays(&t, PEERS_PRIMARY, side);
    static peers_hit hits[side * side];
    peers_answers(t.engine, t.engine->modes[t.engine->usual], &rays, &t.lanes, hits);
    uint32_t found = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        if (hits[i].triangle == RK_MISS)
            continue;
        const rk_vec3 size = rk_abs3(hits[i].normal);
        const float most = rk_max(size.x, rk_max(size.y, size.z));
        rk_check(size.x + size.y + size.z == most && most > 0,
                 "a cube's normals are along an axis");
        const rk_ray ray = rk_batch_ray(&rays.batches[i / RK_BATCH_MAX], i % RK_BATCH_MAX);
        rk_check(rk_dot(hits[i].normal, ray.direction) < 0, "ray %u sees a side from behind", i);
        found++;
    }
    rk_check(found > side, "%u rays hit the cube", found);
    peers_rays_free(&rays);
    close_all(&t);
}

static void every_ray_counts_in_the_rate(void **state)
{
    (void)state;
    traced t = open_scene("statue:1000");
    open_engine(&t);
    rk_error error;
    rk_pool *one = rk_pool_start(1, &error);
    rk_check(one, "%s", error.text);
    peers_rays rays = make_rays(&t, PEERS_PRIMARY, 8 * RK_TILE_SIDE);
    const peers_speed speed = peers_speed_of(t.engine, t.engine->modes[0], &rays, one, &t.lanes);
    /* On one thread the rate is rays over processor time, to the roundings of some sums. */
    rk_check_close(speed.rate * speed.processor * 1e6 / (double)peers_ray_count(&rays), 1, 1e-9,
                   "rays over seconds");
    rk_check(speed.wall > 0 && speed.processor > 0, "time passes");
    peers_rays_free(&rays);
    rk_pool_stop(one);
    close_all(&t);
}

/* An engine that takes a millisecond for each group. */
static void load_nothing(const peers_engine *engine, peers_mode mode, void *at,
                         const rk_ray_batch *rays, uint32_t batches, bool closest)
{
    (void)engine, (void)mode, (void)at, (void)rays, (void)batches, (void)closest;
}

static void sleep_a_while(const peers_engine *engine, peers_mode mode, void *at)
{
    (void)engine, (void)mode, (void)at;
    nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static void rates_of_two_threads_are_added(void **state)
{
    (void)state;
    traced t = open_scene("triangle");
    open_engine(&t);
    peers_rays rays = make_rays(&t, PEERS_PRIMARY, 32 * RK_TILE_SIDE);
    const peers_engine sleeper = {.name = "sleeper", .load = load_nothing, .trace = sleep_a_while};
    const peers_speed speed = peers_speed_of(&sleeper, (peers_mode){0}, &rays, t.pool, &t.lanes);
    /* One thread's rate is the rays over all seconds; two sleep side by side, and jitter does not
     * make one of them twice as slow. */
    const double one = 1e-6 * (double)peers_ray_count(&rays) / speed.wall;
    rk_check(speed.rate > 1.5 * one, "%g is not the sum of two times %g", speed.rate, one);
    rk_check(speed.processor < 0.5 * speed.wall, "waiting takes no processor time");
    peers_rays_free(&rays);
    close_all(&t);
}

/* --- Differences ------------------------------------------------------------------------------ */

/* Two triangles with a common edge, x = 0, in the plane z = 0; one above the first, at z = -1; and
 * one that touches neither, but intersects the second in x = 0.5. */
static rk_vec3 corners[] = {{-1, 0, 0},  {0, -1, 0}, {0, 1, 0},      {1, 0, 0},     {-1, 0, -1},
                            {0, -1, -1}, {0, 1, -1}, {0.5f, -2, -1}, {0.5f, 2, -1}, {0.5f, 0, 1}};
static uint32_t triangles[][3] = {{0, 1, 2}, {3, 2, 1}, {4, 5, 6}, {7, 8, 9}};
static const rk_mesh mesh = {.vertex_count = sizeof corners / sizeof *corners,
                             .triangle_count = sizeof triangles / sizeof *triangles,
                             .positions = corners,
                             .triangles = triangles};

enum { left, right, above, upright };

/* Along +z through (x, y). */
static rk_ray ray_at(float x, float y, float from)
{
    return (rk_ray){{x, y, from}, {0, 0, 1}, INFINITY};
}

/* The hit as raykit would give it, also of a triangle that the ray misses by little. */
static peers_hit hit_of(uint32_t index, const rk_ray *ray)
{
    const uint32_t *k = triangles[index];
    const rk_triangle triangle = {corners[k[0]], corners[k[1]], corners[k[2]], index};
    const rk_hit hit = rk_watertight_intersect(&triangle, ray);
    const rk_vec3 normal = rk_cross(rk_sub(triangle.b, triangle.a), rk_sub(triangle.c, triangle.a));
    return hit.triangle == RK_MISS
               ? (peers_hit){index, (index == above ? -1.0f : 0.0f) - ray->origin.z, 0, 0, normal}
               : (peers_hit){index, hit.t, hit.u, hit.v, normal};
}

static const peers_hit miss = {.triangle = RK_MISS};

static void check_cause(peers_cause want, const rk_ray *ray, peers_hit ours, peers_hit theirs)
{
    peers_largest largest = {{0}};
    const peers_cause got = peers_difference(&mesh, ray, &ours, &theirs, &largest);
    rk_check(got == want, "got \"%s\", want \"%s\"", peers_cause_names.items[got],
             peers_cause_names.items[want]);
}

static void equal_answers_are_no_difference(void **state)
{
    (void)state;
    const rk_ray ray = ray_at(-0.25f, 0.125f, -3);
    check_cause(PEERS_SAME, &ray, hit_of(left, &ray), hit_of(left, &ray));
    check_cause(PEERS_SAME, &ray, miss, miss);
}

/* Rounding explains a difference of an ulp, and not one of a thousandth. */
static void values_may_differ_by_rounding_alone(void **state)
{
    (void)state;
    const rk_ray ray = ray_at(-0.25f, 0.125f, -3);
    const peers_hit ours = hit_of(left, &ray);
    for (int value = 0; value < 4; value++)
        for (int little = 0; little < 2; little++) {
            peers_hit theirs = ours;
            float *const of[] = {&theirs.t, &theirs.u, &theirs.v, &theirs.normal.z};
            *of[value] *= little ? 1 + 0x1p-23f : 1 + 0x1p-10f;
            check_cause(little ? PEERS_SAME : PEERS_VALUES, &ray, ours, theirs);
        }
    peers_hit theirs = ours;
    theirs.t = NAN;
    check_cause(PEERS_VALUES, &ray, ours, theirs);
}

static void the_largest_difference_is_a_fraction_of_the_bound(void **state)
{
    (void)state;
    const rk_ray ray = ray_at(-0.25f, 0.125f, -3);
    const peers_hit ours = hit_of(left, &ray);
    peers_hit theirs = ours;
    theirs.t += 0x1p-20f;
    peers_largest one = {{0}}, two = {{0}};
    peers_difference(&mesh, &ray, &ours, &theirs, &one);
    theirs.t += 0x1p-20f;
    peers_difference(&mesh, &ray, &ours, &theirs, &two);
    rk_check(one.of_bound[PEERS_T] > 0, "t differs");
    rk_check_close(two.of_bound[PEERS_T] / one.of_bound[PEERS_T], 2, 1e-12, "by twice as much");
    rk_check_close(two.of_bound[PEERS_WEIGHTS] + two.of_bound[PEERS_NORMAL], 0, 0, "others do not");
}

static void ties_are_at_common_corners_or_where_triangles_intersect(void **state)
{
    (void)state;
    const rk_ray edge = ray_at(0, 0.125f, -3), line = ray_at(0.5f, 0.125f, -3);
    check_cause(PEERS_SHARED, &edge, hit_of(left, &edge), hit_of(right, &edge));
    /* A ray in the upright triangle's plane misses it, so this one leans. */
    rk_ray leaning = line;
    leaning.origin.x -= 0.75f;
    leaning.direction.x = 0.25f;
    check_cause(PEERS_COINCIDENT, &leaning, hit_of(right, &leaning), hit_of(upright, &leaning));
}

static void a_neighbour_is_hit_beyond_its_edge(void **state)
{
    (void)state;
    const rk_ray ray = ray_at(-0x1p-26f, 0.125f, -3);
    check_cause(PEERS_NEIGHBOUR, &ray, hit_of(left, &ray), hit_of(right, &ray));
}

static void a_leak_is_at_an_edge(void **state)
{
    (void)state;
    const rk_ray edge = ray_at(-0x1p-26f, 0.125f, -3), middle = ray_at(-0.25f, 0.125f, -3);
    check_cause(PEERS_LEAK, &edge, hit_of(above, &edge), miss);
    check_cause(PEERS_LEAK, &edge, hit_of(above, &edge), hit_of(left, &edge));
    check_cause(PEERS_BOX, &middle, hit_of(above, &middle), miss);
    check_cause(PEERS_BOX, &middle, hit_of(above, &middle), hit_of(left, &middle));
}

static void a_hit_beyond_the_edge_is_near_it(void **state)
{
    (void)state;
    const rk_ray near = ray_at(0x1p-26f, 0.125f, -3), far = ray_at(0.25f, 0.125f, -3);
    check_cause(PEERS_BEYOND, &near, hit_of(right, &near), hit_of(above, &near));
    check_cause(PEERS_UNKNOWN, &far, hit_of(right, &far), hit_of(above, &far));
    check_cause(PEERS_UNKNOWN, &far, miss, hit_of(above, &far));
    check_cause(PEERS_UNKNOWN, &far, hit_of(right, &far), (peers_hit){.triangle = 99, .t = 3});
}

static void hits_at_the_ends_of_a_ray_are_told(void **state)
{
    (void)state;
    rk_ray ray = ray_at(-0.25f, 0.125f, -3);
    const peers_hit hit = hit_of(left, &ray);
    ray.t_max = 3;
    check_cause(PEERS_ENDS, &ray, hit, miss);
    ray.t_max = 2.75f;
    check_cause(PEERS_UNKNOWN, &ray, miss, hit);
    const rk_ray start = ray_at(-0.25f, 0.125f, 0);
    check_cause(PEERS_ENDS, &start, miss, hit_of(left, &start));
}

static void check_occlusion(peers_cause want, const rk_ray *ray, bool ours, bool theirs)
{
    const peers_cause got = peers_occlusion_difference(&mesh, ray, ours, theirs);
    rk_check(got == want, "got \"%s\", want \"%s\"", peers_cause_names.items[got],
             peers_cause_names.items[want]);
}

static void occlusion_differs_for_the_same_causes(void **state)
{
    (void)state;
    const rk_ray through = ray_at(-0.25f, 0.125f, -0.5f), edge = ray_at(-0.875f, 0.125f, -0.5f);
    const rk_ray outside = ray_at(-0.875f - 0x1p-24f, 0.125f, -0.5f), far = ray_at(-2, 0, -0.5f);
    check_occlusion(PEERS_SAME, &through, true, true);
    check_occlusion(PEERS_SAME, &far, false, false);
    check_occlusion(PEERS_BOX, &through, true, false);
    check_occlusion(PEERS_LEAK, &edge, true, false);
    check_occlusion(PEERS_BEYOND, &outside, false, true);
    check_occlusion(PEERS_UNKNOWN, &far, false, true);
    rk_ray short_one = through;
    short_one.t_max = 0.5f - 0x1p-25f;
    check_occlusion(PEERS_ENDS, &short_one, false, true);
    /* It crosses two triangles, the first one of the mesh at its edge: the other's miss is the
     * larger fault. */
    const rk_ray both = {{-0.125f, 0.125f, -3}, {-0.25f, 0, 1}, INFINITY};
    check_occlusion(PEERS_BOX, &both, true, false);
    /* It crosses the second one at its edge and passes the first one by: that explains no miss. */
    const rk_ray past = {{-0.875f + 0x1p-24f, 0.125f, -2}, {-0x1p-24f, 0, 1}, INFINITY};
    check_occlusion(PEERS_LEAK, &past, true, false);
}

static void every_cause_has_a_meaning(void **state)
{
    (void)state;
    for (uint32_t cause = 0; cause < PEERS_CAUSES; cause++)
        rk_check(peers_cause_meaning((peers_cause)cause) &&
                     !strchr(peers_cause_meaning((peers_cause)cause), '"'),
                 "cause %u", cause);
}

/* --- Tables ----------------------------------------------------------------------------------- */

static void put(peers_rows *rows, const char *workload, const char *engine, const char *mode,
                double median, bool usual)
{
    rk_error error;
    peers_row row = {.workload = workload,
                     .scene = "a, \"b\"",
                     .triangles = 100,
                     .engine = engine,
                     .threads = 1,
                     .unit = strcmp(workload, "build") ? "Mrays/s" : "ms",
                     .timing = {median, median / 2, median * 2, 5},
                     .bytes = 6400,
                     .usual = usual};
    snprintf(row.mode.text, sizeof row.mode.text, "%s", mode);
    row.differences.rays[PEERS_LEAK] = usual ? 0 : 3;
    rk_check_ok(peers_rows_put(rows, &row, &error), error);
}

static peers_rows some_rows(void)
{
    peers_rows rows = {0};
    put(&rows, "build", "raykit", "sah", 10, true);
    put(&rows, "build", "embree", "low", 1, false);
    put(&rows, "build", "embree", "medium", 5, false);
    put(&rows, "build", "embree", "medium-robust", 4, false);
    put(&rows, "primary", "raykit", "median", 3, false);
    put(&rows, "primary", "raykit", "sah", 4, true);
    put(&rows, "primary", "embree", "single", 8, false);
    put(&rows, "primary", "embree", "packet16", 16, false);
    put(&rows, "primary", "embree", "single-robust", 2, false);
    put(&rows, "primary", "raykit", "sah", 50, true);
    put(&rows, "primary", "embree", "single-robust", 100, false);
    rows.items[rows.count - 1].threads = rows.items[rows.count - 2].threads = 2;
    return rows;
}

static void the_best_mode_is_the_fastest_and_builds_are_of_medium_quality(void **state)
{
    (void)state;
    peers_rows rows = some_rows();
    const peers_row *build = &rows.items[0], *primary = &rows.items[5];
    rk_check(peers_usual(&rows, &rows.items[7]) == primary, "the usual mode of the same workload");
    rk_check(peers_best(&rows, primary, false) == &rows.items[7], "16 Mrays/s is the fastest");
    rk_check(peers_best(&rows, primary, true) == &rows.items[8], "the only robust mode");
    rk_check(peers_best(&rows, build, false) == &rows.items[2], "medium, though low is faster");
    rk_check(peers_best(&rows, build, true) == &rows.items[3], "medium and robust");
    rk_check_close(peers_speed_ratio(primary, &rows.items[7]), 0.25, 0, "a quarter of the rays");
    rk_check_close(peers_speed_ratio(build, &rows.items[2]), 0.5, 0, "twice the time");
    peers_rows_free(&rows);
}

static void answers_that_differ_are_counted_by_engine_and_cause(void **state)
{
    (void)state;
    peers_rows rows = some_rows();
    rk_check_equal(peers_differing(&rows, "raykit", PEERS_SHARED), 3, "the median tree's");
    rk_check_equal(peers_differing(&rows, "embree", PEERS_SHARED), 6 * 3,
                   "six modes, robust or not");
    rk_check_equal(peers_differing(&rows, "embree", PEERS_BOX), 0, "leaks are explained");
    rows.items[8].differences.rays[PEERS_UNKNOWN] = 2;
    rk_check_equal(peers_differing(&rows, "embree", PEERS_BOX), 2, "unknown causes are not");
    rows.items[8].threads = 2;
    rk_check_equal(peers_differing(&rows, "embree", PEERS_BOX), 0, "they are counted once");
    peers_rows_free(&rows);
}

static void tables_have_the_promised_columns(void **state)
{
    const test_folder *folder = *state;
    peers_rows rows = some_rows();
    rk_error error;
    const char *const about[] = {"key", "a, b", NULL};
    rk_check_ok(peers_tables_write(&rows, folder->path, about, &error), error);
    size_t size;
    char *text = (char *)test_folder_read(test_folder_path(folder, "tables/peers.csv"), &size);
    static const char wanted[] =
        "workload,scene,engine,mode,threads,value,unit,ratio_to_raykit,mismatches\n"
        "build,\"a, \"\"b\"\"\",raykit,sah,1,10,ms,1,0\n"
        "build,\"a, \"\"b\"\"\",embree,low,1,1,ms,0.1,3\n";
    rk_check(size > strlen(wanted) && strncmp(text, wanted, strlen(wanted)) == 0,
             "peers.csv should begin with\n%s", wanted);
    free(text);
    test_file_check(test_folder_path(folder, "tables/peers_machine.csv").text,
                    "item,value\nkey,\"a, b\"\n");
    peers_rows_free(&rows);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(camera_rays_are_those_of_the_picture),
    cmocka_unit_test(rays_are_the_same_on_every_call),
    cmocka_unit_test(batches_are_full_but_the_last),
    cmocka_unit_test(shadow_rays_end_at_the_light),
    cmocka_unit_test(there_are_as_many_shadow_rays_as_the_renderer_sends),
    cmocka_unit_test(the_room_is_closed_and_faces_inwards),
    cmocka_unit_test(in_the_room_every_camera_ray_hits),
    cmocka_unit_test(scenes_that_embree_would_not_see_whole_are_refused),
    cmocka_unit_test(all_trees_give_the_same_answers),
    cmocka_unit_test(answers_have_the_normal_of_the_triangle),
    cmocka_unit_test(every_ray_counts_in_the_rate),
    cmocka_unit_test(rates_of_two_threads_are_added),
    cmocka_unit_test(equal_answers_are_no_difference),
    cmocka_unit_test(values_may_differ_by_rounding_alone),
    cmocka_unit_test(the_largest_difference_is_a_fraction_of_the_bound),
    cmocka_unit_test(ties_are_at_common_corners_or_where_triangles_intersect),
    cmocka_unit_test(a_neighbour_is_hit_beyond_its_edge),
    cmocka_unit_test(a_leak_is_at_an_edge),
    cmocka_unit_test(a_hit_beyond_the_edge_is_near_it),
    cmocka_unit_test(hits_at_the_ends_of_a_ray_are_told),
    cmocka_unit_test(occlusion_differs_for_the_same_causes),
    cmocka_unit_test(every_cause_has_a_meaning),
    cmocka_unit_test(the_best_mode_is_the_fastest_and_builds_are_of_medium_quality),
    cmocka_unit_test(answers_that_differ_are_counted_by_engine_and_cause),
    test_in_folder(tables_have_the_promised_columns),
};

RK_SUITE("peers", tests)
