/* The pyramid between a point and a light: where it is empty, no shadow ray is occluded; where no
 * ray is, it is nearly always empty; from every tree alike. */
#include "test.h"
#include "test_scene.h"

#include "accel/query/pyramid.h"
#include "accel/query/trace.h"
#include "base/random.h"

static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_hash(a, b, c, 9));
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(2 * noise(a, b, 0) - 1, 2 * noise(a, b, 1) - 1, 2 * noise(a, b, 2) - 1);
}

static rk_accel build(const rk_scene *scene, rk_accel_kind kind)
{
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, kind, scene, &error), error);
    return accel;
}

static bool are_clear(const rk_accel *accel, const rk_vec3 *apexes, uint32_t count,
                      const rk_light *light)
{
    rk_pyramid_obstacle obstacle = {.known = false};
    rk_counters counters = {0};
    const rk_pyramid pyramid = rk_pyramid_around(apexes, count, light);
    return rk_pyramid_is_empty(&pyramid, accel, &obstacle, &counters);
}

static bool is_empty(const rk_accel *accel, rk_vec3 apex, const rk_light *light)
{
    return are_clear(accel, &apex, 1, light);
}

/* Of a grid of rays to the light, its corners and edges included, those that are occluded. */
enum { GRID = 17 };
static uint32_t occluded_rays(const rk_accel *accel, rk_vec3 apex, const rk_light *light)
{
    rk_counters counters = {0};
    uint32_t count = 0;
    for (uint32_t j = 0; j < GRID; j++) {
        rk_ray_batch rays = {.count = 0};
        rk_occlusion_batch answers;
        for (uint32_t i = 0; i < GRID; i++) {
            rk_vec3 to = rk_madd(light->position, light->edge01, (float)i / (GRID - 1));
            if (light->kind == RK_LIGHT_PARALLELOGRAM)
                to = rk_madd(to, light->edge02, (float)j / (GRID - 1));
            const rk_ray ray = {apex, rk_sub(to, apex), 1};
            rk_batch_push(&rays, &ray);
        }
        rk_accel_occluded(accel, &rays, &answers, &counters);
        for (uint32_t i = 0; i < rays.count; i++)
            count += answers.occluded[i];
    }
    return count;
}

/* A point on a surface that a random ray hits, from where shadow rays start; false on a miss. */
static bool apex_on_surface(const rk_accel *accel, rk_vec3 centre, float size, uint32_t key,
                            const rk_light *light, rk_vec3 *apex)
{
    const rk_scene *scene = accel->scene;
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    const rk_ray ray = {rk_madd(centre, noise3(key, 1), size), noise3(key, 2), INFINITY};
    rk_batch_push(&rays, &ray);
    rk_accel_closest(accel, &rays, &hits, &counters);
    const rk_hit hit = rk_batch_hit(&hits, 0);
    const uint32_t triangles = scene->mesh.triangle_count;
    rk_surface surface;
    if (hit.triangle == RK_MISS)
        return false;
    if (hit.triangle < triangles)
        rk_surface_at(&surface, &scene->mesh, &ray, &hit);
    else
        rk_surface_at_sphere(&surface, &scene->spheres[hit.triangle - triangles],
                             &scene->sphere_materials[hit.triangle - triangles], &ray, &hit);
    *apex = rk_surface_spawn(&surface, rk_sub(light->position, surface.point));
    return true;
}

static rk_light random_light(rk_vec3 centre, float size, uint32_t key)
{
    const float extent = size * exp2f(-6 * noise(key, 9, 9));
    return (rk_light){.kind = key % 5 ? RK_LIGHT_PARALLELOGRAM : RK_LIGHT_SEGMENT,
                      .position = rk_madd(centre, noise3(key, 3), size),
                      .edge01 = rk_scale(noise3(key, 4), extent),
                      .edge02 = rk_scale(noise3(key, 5), extent),
                      .colours = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
}

/* --- Against rays ----------------------------------------------------------------------------- */

typedef struct place {
    const char *scene;
    rk_vec3 centre;
    float size;
} place;

static const place places[] = {{"cornell-light", {0, 0, 0}, 1},
                               {"teapot", {0, 0, 0}, 1},
                               {"statue:4000", {0, 0, 0}, 1},
                               {"spheres", {0, 0, 0}, 1},
                               {"moving", {0, 0, 0}, 1}};
enum { PLACES = sizeof places / sizeof *places, TRIED = 6000 };
/* Each has a tree of its own, for whose memory sanitizers take several hundred times as long. */
#ifdef RK_SANITIZED
enum { GRAZED = 2000 };
#else
enum { GRAZED = 60000 };
#endif

static void an_empty_pyramid_has_no_occluded_ray_and_nearly_conversely(void **state)
{
    (void)state;
    for (uint32_t p = 0; p < PLACES; p++) {
        rk_scene scene = test_scene_builtin(places[p].scene);
        rk_accel accel = build(&scene, RK_ACCEL_WIDE);
        uint32_t tried = 0, empty = 0, free = 0;
        for (uint32_t key = 0; key < TRIED; key++) {
            const rk_light light = random_light(places[p].centre, places[p].size, key);
            rk_vec3 apex;
            if (!apex_on_surface(&accel, places[p].centre, places[p].size, key, &light, &apex))
                continue;
            const uint32_t occluded = occluded_rays(&accel, apex, &light);
            const bool is_clear = is_empty(&accel, apex, &light);
            rk_check(!is_clear || occluded == 0, "%s, %u: found empty, but %u rays are occluded",
                     places[p].scene, key, occluded);
            tried++;
            empty += is_clear;
            free += occluded == 0;
        }
        rk_check(tried >= 400 && free >= 100, "%s: %u tried, %u without occluded rays",
                 places[p].scene, tried, free);
        /* What reaches in between the rays of the grid, and what only other planes would separate:
         * beside an edge of the pyramid, spheres. */
        rk_check(empty >= 3 * (free / 4), "%s: of %u pyramids without occluded rays only %u empty",
                 places[p].scene, free, empty);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

/* Of up to eight apexes close to each other. */
static void several_apexes_are_cleared_only_if_no_ray_is_occluded(void **state)
{
    enum { apexes_max = 8 };
    (void)state;
    for (uint32_t p = 0; p < PLACES; p++) {
        rk_scene scene = test_scene_builtin(places[p].scene);
        rk_accel accel = build(&scene, RK_ACCEL_WIDE);
        uint32_t tried = 0, clear = 0, each_clear = 0;
        for (uint32_t key = 0; key < TRIED; key++) {
            const rk_light light = random_light(places[p].centre, places[p].size, key);
            rk_vec3 apexes[apexes_max], first;
            uint32_t count = 0, occluded = 0;
            bool is_each_clear = true;
            if (!apex_on_surface(&accel, places[p].centre, places[p].size, key, &light, &first))
                continue;
            for (uint32_t k = 0; k < 2 + key % (apexes_max - 1); k++) {
                const rk_vec3 beside = rk_madd(first, noise3(key, 20 + k), 0.004f * places[p].size);
                apexes[count] = k == 0 ? first : beside;
                if (k > 0 && !apex_on_surface(&accel, beside, 0, key, &light, &apexes[count]))
                    continue;
                occluded += occluded_rays(&accel, apexes[count], &light);
                is_each_clear = is_each_clear && is_empty(&accel, apexes[count], &light);
                count++;
            }
            const bool is_clear = are_clear(&accel, apexes, count, &light);
            rk_check(!is_clear || occluded == 0, "%s, %u: found empty, but %u rays are occluded",
                     places[p].scene, key, occluded);
            tried += count > 1;
            clear += count > 1 && is_clear;
            each_clear += count > 1 && is_each_clear;
        }
        /* Fewer together: single apexes are also separated by the planes of spheres and of edges,
         * and the statue's folds are as small as a group. */
        rk_check(each_clear >= 30 && clear >= each_clear / 8,
                 "%s: of %u groups %u are clear one by one, %u together", places[p].scene, tried,
                 each_clear, clear);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

/* Points of the convex hull are within the planes and the box, whatever the apexes. */
static void the_pyramid_of_several_apexes_is_their_hull(void **state)
{
    enum { count = 6, tried = 4000, points = 20 };
    (void)state;
    for (uint32_t key = 0; key < tried; key++) {
        const rk_light light = {.kind = RK_LIGHT_PARALLELOGRAM,
                                .position = noise3(key, 1),
                                .edge01 = noise3(key, 2),
                                .edge02 = noise3(key, 3)};
        rk_vec3 apexes[count];
        const float spread = exp2f(-10 * noise(key, 4, 0));
        for (uint32_t k = 0; k < count; k++)
            apexes[k] = rk_madd(rk_scale(noise3(key, 5), 3), noise3(key, 10 + k), spread);
        if (key % 3 == 0) /* the rays from there are less accurate */
            apexes[count - 1] = rk_scale(apexes[count - 1], 1000);
        const rk_pyramid pyramid = rk_pyramid_around(apexes, count, &light);
        for (uint32_t i = 0; i < points; i++) {
            const rk_vec3 to =
                rk_madd(rk_madd(light.position, light.edge01, fminf(1.3f * noise(key, i, 31), 1)),
                        light.edge02, fminf(1.3f * noise(key, i, 32), 1));
            const rk_vec3 from = rk_mix(apexes[i % count], apexes[i / count], noise(key, i, 33));
            const rk_vec3 x = rk_madd(from, rk_sub(to, from), fminf(1.3f * noise(key, i, 34), 1));
            const rk_dvec3 d = rk_dmadd(rk_widen(x), rk_widen(pyramid.apex), -1);
            for (int plane = 0; plane < RK_PYRAMID_PLANES; plane++)
                rk_check(rk_ddot(pyramid.normals[plane], d) <= pyramid.limits[plane],
                         "%u: a point is beyond plane %d", key, plane);
            for (int axis = 0; axis < 3; axis++)
                rk_check(rk_axis(x, axis) >= rk_axis(pyramid.box.corner[0], axis) &&
                             rk_axis(x, axis) <= rk_axis(pyramid.box.corner[1], axis),
                         "%u: a point is outside the box", key);
        }
    }
}

static void every_tree_gives_the_same_answer(void **state)
{
    (void)state;
    for (uint32_t p = 0; p < PLACES; p++) {
        rk_scene scene = test_scene_builtin(places[p].scene);
        rk_accel accel[RK_ACCEL_WIDE + 1];
        for (int kind = 0; kind <= RK_ACCEL_WIDE; kind++)
            accel[kind] = build(&scene, (rk_accel_kind)kind);
        for (uint32_t key = 0; key < TRIED; key++) {
            const rk_light light = random_light(places[p].centre, places[p].size, key);
            rk_vec3 apex;
            if (!apex_on_surface(&accel[0], places[p].centre, places[p].size, key, &light, &apex))
                continue;
            const bool want = is_empty(&accel[0], apex, &light);
            for (int kind = 1; kind <= RK_ACCEL_WIDE; kind++)
                rk_check(is_empty(&accel[kind], apex, &light) == want,
                         "%s, %u: the tree of kind %d says otherwise", places[p].scene, key, kind);
        }
        for (int kind = 0; kind <= RK_ACCEL_WIDE; kind++)
            rk_accel_free(&accel[kind]);
        rk_scene_free(&scene);
    }
}

/* --- One triangle ----------------------------------------------------------------------------- */

/* Scaled; turned by a rotation without an axis of space in it, where no box separates. */
static rk_vec3 turn(rk_vec3 v, float scale, bool turned)
{
    const rk_vec3 w = {2 * v.x - v.y + 2 * v.z, 2 * v.x + 2 * v.y - v.z, 2 * v.y + 2 * v.z - v.x};
    return rk_scale(turned ? rk_scale(w, 1 / 3.f) : v, scale);
}

/* A light of 2 x 2 at z = 0, seen from (0, 0, -4): at z = -2 the pyramid reaches to 0.5. A turned
 * one has its corners in the opposite order, too. */
static rk_light square(float scale, bool turned)
{
    const rk_vec3 x = turn(rk_vec(2, 0, 0), scale, turned),
                  y = turn(rk_vec(0, 2, 0), scale, turned);
    return (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                      .position = turn(rk_vec(-1, -1, 0), scale, turned),
                      .edge01 = turned ? y : x,
                      .edge02 = turned ? x : y};
}

typedef struct triangle_case {
    rk_vec3 a, b, c;
    bool is_inside;
    const char *what;
} triangle_case;

static const float just = 1e-4f;

static void a_triangle_counts_if_it_reaches_into_the_pyramid(void **state)
{
    (void)state;
    const triangle_case cases[] = {
        {{0.1f, 0, -2}, {0.2f, 0, -2}, {0.1f, 0.1f, -2}, true, "a small one within"},
        {{-9, -9, -2}, {9, -9, -2}, {0, 20, -2}, true, "a large one around"},
        {{0.5f - just, 0, -2}, {9, 0, -2}, {9, 1, -2}, true, "a corner within, at +x"},
        {{0.5f + just, 0, -2}, {9, 0, -2}, {9, 1, -2}, false, "a corner beside, at +x"},
        {{-0.5f + just, 0, -2}, {-9, 0, -2}, {-9, 1, -2}, true, "a corner within, at -x"},
        {{-0.5f - just, 0, -2}, {-9, 0, -2}, {-9, 1, -2}, false, "a corner beside, at -x"},
        {{0, 0.5f - just, -2}, {0, 9, -2}, {1, 9, -2}, true, "a corner within, at +y"},
        {{0, 0.5f + just, -2}, {0, 9, -2}, {1, 9, -2}, false, "a corner beside, at +y"},
        {{0, -0.5f + just, -2}, {0, -9, -2}, {1, -9, -2}, true, "a corner within, at -y"},
        {{0, -0.5f - just, -2}, {0, -9, -2}, {1, -9, -2}, false, "a corner beside, at -y"},
        {{0, 0, -just}, {1, 0, 5}, {0, 1, 5}, true, "a corner just before the light"},
        {{0, 0, just}, {1, 0, 5}, {0, 1, 5}, false, "a corner just behind the light"},
        {{-9, -9, 1}, {9, -9, 1}, {0, 20, 1}, false, "a wall behind the light"},
        {{-9, -9, -4 - just}, {9, -9, -4 - just}, {0, 20, -4 - just}, false, "the apex's floor"},
        {{-9, -9, -4 + just}, {9, -9, -4 + just}, {0, 20, -4 + just}, true, "one over the apex"},
        {{-9, -9, -5}, {9, -9, -5}, {0, 20, -1}, true, "one that leans over the apex"},
        {{-9, -9, -5}, {9, -9, -5}, {0, 5, -4.5f}, false, "one that leans, but not so far"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int scale = -30; scale <= 30; scale += 15)
            for (int turned = 0; turned < 2; turned++) {
                const float s = ldexpf(1, scale);
                rk_scene scene = test_scene_make(1);
                test_scene_triangle(&scene, 0, turn(cases[i].a, s, turned),
                                    turn(cases[i].b, s, turned), turn(cases[i].c, s, turned));
                const rk_light light = square(s, turned);
                const rk_vec3 apex = turn(rk_vec(0, 0, -4), s, turned);
                for (int kind = RK_ACCEL_MEDIAN; kind <= RK_ACCEL_WIDE; kind += RK_ACCEL_WIDE) {
                    rk_accel accel = build(&scene, (rk_accel_kind)kind);
                    rk_check(is_empty(&accel, apex, &light) != cases[i].is_inside,
                             "%s, times 2^%d%s, tree of kind %d", cases[i].what, scale,
                             turned ? ", turned" : "", kind);
                    rk_accel_free(&accel);
                }
                rk_scene_free(&scene);
            }
}

/* A ball around the origin. The slack is 2^-20 of apex, position and edges, so more than 2^-20. */
static void a_sphere_counts_if_it_reaches_into_the_pyramid(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(1); /* far away */
    test_scene_triangle(&scene, 0, rk_vec(99, 0, 0), rk_vec(99, 1, 0), rk_vec(99, 0, 1));
    scene.spheres[scene.sphere_count++] = (rk_sphere){{0, 0, 0}, 1};
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    rk_light light = square(1, false);
    light.position.z = 4;
    const rk_vec3 above = {0, 0, 1 + just};
    rk_check(!is_empty(&accel, rk_vec(0, 0, 0.5f), &light), "the apex within");
    rk_check(!is_empty(&accel, rk_vec(0, 0, -4), &light), "between apex and light");
    rk_check(is_empty(&accel, above, &light), "the apex above");
    rk_check(is_empty(&accel, rk_vec(9, 0, -4), &light), "beside");
    /* A corner is lowest, so that no side separates: only the tangent plane at z = 1 does. */
    light = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                       .position = rk_vec(2, 0, 1 + just),
                       .edge01 = rk_vec(0, 1, 2),
                       .edge02 = rk_vec(0, -1, 2)};
    rk_check(is_empty(&accel, rk_vec(0, 0, 1.5f), &light), "the light just above a tangent plane");
    light.position.z = 1 + 0x1p-20f;
    rk_check(!is_empty(&accel, rk_vec(0, 0, 1.5f), &light), "so little that a ray may touch");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

/* --- Rounding --------------------------------------------------------------------------------- */

/* One triangle and a light that do not touch, but may for a ray that is rounded. */
static void what_is_nearer_than_rays_are_accurate_counts(void **state)
{
    (void)state;
    const float beside = 1 + 0x1p-22f, vast = 0x1p28f, over = -4 + 0x1p-21f;
    const rk_light light = square(1, false);
    const rk_vec3 cases[][3] = {
        {{beside, -9, -9}, {beside, 9, -9}, {beside, 0, 20}}, /* beside the pyramid's box */
        {{-9, beside, -9}, {9, beside, -9}, {0, beside, 20}},
        /* Over the apex, by so little of its own size that double cannot tell the side. */
        {{-vast, -vast, over}, {vast, -vast, over}, {0, vast, over}},
        {{vast, -vast, over}, {-vast, -vast, over}, {0, vast, over}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_scene scene = test_scene_make(1);
        test_scene_triangle(&scene, 0, cases[i][0], cases[i][1], cases[i][2]);
        rk_accel accel = build(&scene, RK_ACCEL_WIDE);
        rk_check(!is_empty(&accel, rk_vec(0, 0, -4), &light), "case %zu", i);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

/* Often on a plane of the axes. */
static rk_vec3 rough3(uint32_t a, uint32_t b)
{
    const rk_vec3 v = noise3(a, b);
    return rk_vec(noise(a, b, 3) < 0.3f ? 0 : v.x, noise(a, b, 4) < 0.3f ? 0 : v.y,
                  noise(a, b, 5) < 0.3f ? 0 : v.z);
}

/* 0 or 1, or in between: corners, edges, middle. */
static float rough(uint32_t a, uint32_t b)
{
    const float x = 3 * noise(a, b, 0);
    return x < 1 ? 0 : x < 2 ? 1 : x - 2;
}

/* Triangles that a ray along the side of a pyramid just touches, or misses by a few roundings: of
 * two corners on both sides of the ray, or one beside it. Whatever was rounded how, the pyramid
 * must not be empty if the ray is occluded. */
static void a_ray_that_grazes_a_triangle_is_not_cleared(void **state)
{
    (void)state;
    uint32_t occluded = 0, empty = 0, all_empty = 0;
    for (uint32_t key = 0; key < GRAZED; key++) {
        const rk_light light = {.kind = RK_LIGHT_PARALLELOGRAM,
                                .position = rough3(key, 1),
                                .edge01 = rough3(key, 2),
                                .edge02 = rough3(key, 3)};
        const rk_vec3 apex = rk_scale(rough3(key, 4), key % 4 ? 1 : 1000);
        const rk_vec3 to = rk_madd(rk_madd(light.position, light.edge01, rough(key, 5)),
                                   light.edge02, rough(key, 6));
        const rk_ray ray = {apex, rk_sub(to, apex), 1};
        const float t = key % 3 ? 1 - noise(key, 7, 0) * 1e-3f : noise(key, 7, 0);
        const rk_vec3 on = rk_madd(apex, ray.direction, t);
        const float error = 0x1p-24f * exp2f(6 * noise(key, 7, 2)) * (rk_length(apex) + 1);
        const rk_vec3 along = rk_scale(rough3(key, 8), exp2f(9 * noise(key, 7, 1)));
        const rk_vec3 c = rk_add(on, rough3(key, 12));
        rk_vec3 a = rk_madd(on, noise3(key, 9), error), b = rk_add(on, rough3(key, 10));
        if (key % 2) {
            a = rk_madd(rk_add(on, along), noise3(key, 9), error);
            b = rk_madd(rk_sub(on, along), noise3(key, 11), error);
        }
        rk_scene scene = test_scene_make(1);
        test_scene_triangle(&scene, 0, a, b, c);
        rk_accel accel = build(&scene, RK_ACCEL_WIDE);
        rk_ray_batch rays = {.count = 0};
        rk_occlusion_batch answers;
        rk_counters counters = {0};
        rk_batch_push(&rays, &ray);
        rk_accel_occluded(&accel, &rays, &answers, &counters);
        const bool is_clear = is_empty(&accel, apex, &light);
        rk_check(!is_clear || !answers.occluded[0], "%u: found empty, but a ray is occluded", key);
        /* A remembered triangle is tested in double, one of the tree in float before. */
        rk_pyramid_obstacle obstacle = {true, {a, b, c, 0}};
        const rk_pyramid pyramid = rk_pyramid_around(&apex, 1, &light);
        rk_check(rk_pyramid_is_empty(&pyramid, &accel, &obstacle, &counters) == is_clear,
                 "%u: %s by the tree alone", key, is_clear ? "empty" : "not empty");
        const rk_vec3 apexes[] = {rk_madd(apex, rough3(key, 14), 0.1f), apex,
                                  rk_madd(apex, rough3(key, 15), 0.01f)};
        const bool are_all_clear = are_clear(&accel, apexes, 3, &light);
        rk_check(!are_all_clear || !answers.occluded[0],
                 "%u: found empty around three apexes, but a ray is occluded", key);
        all_empty += are_all_clear;
        occluded += answers.occluded[0];
        empty += is_clear;
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
    rk_check(occluded > GRAZED / 5 && empty > GRAZED / 500 && all_empty > GRAZED / 2000,
             "%u occluded, %u empty, %u around three apexes", occluded, empty, all_empty);
}

/* A light close to the floor, and tilted: only the floor's own plane separates. */
static void a_floor_below_the_light_is_outside(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(1);
    test_scene_triangle(&scene, 0, turn(rk_vec(-9, -9, -1), 1, true),
                        turn(rk_vec(9, -9, -1), 1, true), turn(rk_vec(0, 20, -1), 1, true));
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    const rk_light light = {.kind = RK_LIGHT_PARALLELOGRAM,
                            .position = turn(rk_vec(-1, -1, -0.9f), 1, true),
                            .edge01 = turn(rk_vec(2, 0, 0.8f), 1, true),
                            .edge02 = turn(rk_vec(0, 2, 0), 1, true)};
    rk_check(is_empty(&accel, rk_vec(0, 0, 0), &light), "the floor is outside");
    const rk_vec3 apexes[] = {{0, 0, 0},
                              turn(rk_vec(0.5f, 0, -0.5f), 1, true),
                              turn(rk_vec(0, 0.5f, -0.9f), 1, true),
                              turn(rk_vec(0.5f, 0.5f, -1.1f), 1, true)};
    rk_check(are_clear(&accel, apexes, 3, &light), "of several apexes, too");
    rk_check(!are_clear(&accel, apexes, 4, &light), "but not if one is below it");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

/* Of apexes in a row, the first and the last are the outermost; those between move no plane. */
static void sides_pass_through_the_outermost_apexes(void **state)
{
    (void)state;
    const rk_light light = square(1, false);
    const rk_vec3 apexes[] = {{-1, 0, -4}, {0.2f, 0, -4}, {1, 0, -4}, {-0.3f, 0, -4}};
    const rk_pyramid pyramid = rk_pyramid_around(apexes, 4, &light);
    uint32_t touched = 0;
    for (int plane = 0; plane < 4; plane++) {
        double farthest = -INFINITY;
        for (int k = 0; k < 4; k++)
            farthest =
                fmax(farthest, rk_ddot(pyramid.normals[plane],
                                       rk_dmadd(rk_widen(apexes[k]), pyramid.corners[plane], -1)));
        rk_check(fabs(farthest) < 1e-6, "plane %d is %g away from the nearest apex", plane,
                 -farthest);
        touched += rk_dvec3_size(pyramid.normals[plane]) > 0.5;
    }
    rk_check_equal(touched, 4, "all four sides have planes");
}

static void a_light_seen_edge_on_or_without_area_is_not_cleared_wrongly(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-0.1f, -0.1f, -2), rk_vec(0.2f, 0, 0), rk_vec(0, 0.2f, 0));
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    const rk_vec3 apex = {0, 0, -4}, x = {1, 0, 0}, z = {0, 0, 1}, none = {0, 0, 0};
    const rk_light lights[] = {
        {.kind = RK_LIGHT_PARALLELOGRAM, .position = {0, 0, 0}, .edge01 = x, .edge02 = z},
        {.kind = RK_LIGHT_PARALLELOGRAM, .position = {0, 0, 0}, .edge01 = x, .edge02 = x},
        {.kind = RK_LIGHT_PARALLELOGRAM, .position = {0, 0, 0}, .edge01 = none, .edge02 = none},
        {.kind = RK_LIGHT_SEGMENT, .position = {0, 0, 0}, .edge01 = x, .edge02 = {9, 9, 9}},
        {.kind = RK_LIGHT_SEGMENT, .position = {0, 0, 0}, .edge01 = z, .edge02 = {9, 9, 9}},
    };
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
        rk_check(occluded_rays(&accel, apex, &lights[i]) > 0, "light %zu is occluded in part", i);
        rk_check(!is_empty(&accel, apex, &lights[i]), "light %zu: the pyramid is not empty", i);
    }
    const rk_light beside = {
        .kind = RK_LIGHT_SEGMENT, .position = {-4, -4, 0}, .edge01 = x, .edge02 = {16, 16, 0}};
    rk_check(is_empty(&accel, rk_vec(-4, -4, -4), &beside), "a segment has no second edge");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static void numbers_that_are_none_clear_nothing(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-9, -9, -2), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    const rk_light light = square(1, false);
    const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        rk_light wrong = light;
        wrong.position.x = odd[i];
        rk_check(!is_empty(&accel, rk_vec(odd[i], 0, -4), &light), "apex at %g", (double)odd[i]);
        rk_check(!is_empty(&accel, rk_vec(0, 0, -4), &wrong), "light at %g", (double)odd[i]);
    }
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static void without_triangles_all_is_empty(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(1);
    const rk_light light = square(1, false);
    scene.mesh.triangle_count = 0;
    for (int kind = 0; kind <= RK_ACCEL_WIDE; kind++) {
        rk_accel accel = build(&scene, (rk_accel_kind)kind);
        rk_check(is_empty(&accel, rk_vec(0, 0, -4), &light), "tree of kind %d", kind);
        rk_accel_free(&accel);
    }
    rk_scene_free(&scene);
}

/* Below 2^-104 the light's slack is below 2^-120, and products of it are no normal floats. */
static void where_float_loses_digits_nothing_is_cleared(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(1);
    test_scene_triangle(&scene, 0, rk_vec(99, 0, 0), rk_vec(99, 1, 0), rk_vec(99, 0, 1));
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    for (int scale = -140; scale <= 0; scale += 35) {
        const float s = ldexpf(1, scale);
        const rk_light light = square(s, false);
        rk_check(is_empty(&accel, rk_vec(0, 0, -4 * s), &light) == (scale > -104), "2^%d", scale);
    }
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static void an_obstacle_is_remembered(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-0.1f, -0.1f, -2), rk_vec(0.2f, 0, 0), rk_vec(0, 0.2f, 0));
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    rk_pyramid_obstacle obstacle = {.known = false};
    rk_counters counters = {0};
    const rk_light light = square(1, false);
    const rk_pyramid first = rk_pyramid_around(&(rk_vec3){0, 0, -4}, 1, &light);
    const rk_pyramid beside = rk_pyramid_around(&(rk_vec3){9, 0, -4}, 1, &light);
    rk_check(!rk_pyramid_is_empty(&first, &accel, &obstacle, &counters), "the quad is inside");
    counters = (rk_counters){0};
    rk_check(!rk_pyramid_is_empty(&first, &accel, &obstacle, &counters), "it still is");
    rk_check_equal(counters.box_tests, 0, "the second time without the tree");
    rk_check_equal(counters.triangle_tests, 1, "by the same triangle");
    rk_check(rk_pyramid_is_empty(&beside, &accel, &obstacle, &counters),
             "an obstacle of another pyramid says nothing about this one");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static bool is_occluded(const rk_accel *accel, rk_vec3 from, rk_vec3 to)
{
    rk_ray_batch rays = {.count = 0};
    rk_occlusion_batch answers;
    rk_counters counters = {0};
    const rk_ray ray = {from, rk_sub(to, from), 1};
    rk_batch_push(&rays, &ray);
    rk_accel_occluded(accel, &rays, &answers, &counters);
    return answers.occluded[0];
}

/* Both were found by a random search. The first apex is a hair off the line of an edge, so that the
 * plane through both could have any direction; in the second case the float arithmetic of the ray's
 * test loses more of a large sphere than a triangle's would. */
static void what_rounding_hides_is_not_cleared(void **state)
{
    (void)state;
    const float x = 0x1.b5b4c2p-1f, z = -0x1.1b33bap-28f;
    rk_scene scene = test_scene_make(1);
    test_scene_triangle(&scene, 0, rk_vec(0x1.49bf56p+0f, -0x1.1c103ap-1f, 0x1.145104p-3f),
                        rk_vec(0x1.8044bap+0f, -0x1.57fe28p-2f, 0x1.9c2b8ap-3f),
                        rk_vec(0x1.aa3dd6p+0f, -0x1.5761bap-3f, 0x1.026068p-2f));
    const rk_light needle = {.kind = RK_LIGHT_PARALLELOGRAM,
                             .position = {x, -1, z},
                             .edge01 = {-0x1.0d7926p-40f, 0, 0x1.284e54p-51f},
                             .edge02 = {0x1.f230b4p-1f, 1, 0x1.365622p-2f}};
    const rk_vec3 apex = {x, -1, -0x1.1b33b2p-28f};
    rk_accel accel = build(&scene, RK_ACCEL_WIDE);
    rk_check(is_occluded(&accel, apex,
                         rk_madd(rk_madd(needle.position, needle.edge01, 0x1.fffffep-1f),
                                 needle.edge02, 0x1.6d6aecp-1f)),
             "a ray to the needle is occluded");
    rk_check(!is_empty(&accel, apex, &needle), "so its pyramid is not empty");
    rk_accel_free(&accel);
    test_scene_triangle(&scene, 0, rk_vec(0, 0, 99), rk_vec(1, 0, 99), rk_vec(0, 1, 99));
    scene.spheres[scene.sphere_count++] =
        (rk_sphere){{0x1.b35528p-2f, 0x1.6d897ep+13f, -0x1.f5a1c6p+11f}, 0x1.826cbep+13f};
    const rk_light light = {.kind = RK_LIGHT_PARALLELOGRAM,
                            .position = {-0x1.1a867cp-1f, -0x1.0e8ce6p-3f, -0x1.ec9666p-1f},
                            .edge01 = {-0x1.82b00ap-20f, -0x1.1c1a54p-23f, 0x1.e4c2b4p-22f},
                            .edge02 = {0x1.f43ec6p-1f, 0x1.64034ap-1f, -0x1.ddeec8p-23f}};
    const rk_vec3 below = {0, 0, 0x1.b845c4p-5f};
    accel = build(&scene, RK_ACCEL_WIDE);
    rk_check(is_occluded(
                 &accel, below,
                 rk_madd(rk_madd(light.position, light.edge01, 0x1.0b215ep-1f), light.edge02, 1)),
             "a ray past the large sphere is occluded");
    rk_check(!is_empty(&accel, below, &light), "so its pyramid is not empty");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(an_empty_pyramid_has_no_occluded_ray_and_nearly_conversely),
    cmocka_unit_test(several_apexes_are_cleared_only_if_no_ray_is_occluded),
    cmocka_unit_test(the_pyramid_of_several_apexes_is_their_hull),
    cmocka_unit_test(sides_pass_through_the_outermost_apexes),
    cmocka_unit_test(every_tree_gives_the_same_answer),
    cmocka_unit_test(a_triangle_counts_if_it_reaches_into_the_pyramid),
    cmocka_unit_test(a_floor_below_the_light_is_outside),
    cmocka_unit_test(a_sphere_counts_if_it_reaches_into_the_pyramid),
    cmocka_unit_test(what_is_nearer_than_rays_are_accurate_counts),
    cmocka_unit_test(a_ray_that_grazes_a_triangle_is_not_cleared),
    cmocka_unit_test(a_light_seen_edge_on_or_without_area_is_not_cleared_wrongly),
    cmocka_unit_test(numbers_that_are_none_clear_nothing),
    cmocka_unit_test(without_triangles_all_is_empty),
    cmocka_unit_test(where_float_loses_digits_nothing_is_cleared),
    cmocka_unit_test(an_obstacle_is_remembered),
    cmocka_unit_test(what_rounding_hides_is_not_cleared),
};

RK_SUITE("pyramid", tests)
