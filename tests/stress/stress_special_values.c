/* Inputs at the edge of what floats are: 0 and -0, the smallest and the largest numbers, infinity
 * and NaN, in any input of any function. Every function returns, with the answer that its header
 * promises. RAYKIT_STRESS=N tries N times as many (make stress). */
#include "../test_scene.h"

#include "base/image.h"
#include "base/random.h"
#include "base/reflect.h"
#include "features/all.h"
#include "io/srgb8.h"
#include "scene/bvh_build.h"

#include <float.h>

static uint32_t trials(void)
{
    const char *factor = getenv("RAYKIT_STRESS");
    return 50000 * (uint32_t)(factor ? strtoul(factor, NULL, 10) : 1);
}

/* --- Special numbers -------------------------------------------------------------------------- */

typedef struct source {
    uint32_t trial, draws;
    bool finite_only;
} source;

static uint32_t bits(source *s)
{
    return rk_hash(0x6f6464, s->trial, s->draws++, 0);
}

static float number(source *s)
{
    static const float special[] = {
        0,  -0.0f,      0x1p-149f, -0x1p-149f, FLT_MIN, -FLT_MIN, FLT_MAX, -FLT_MAX, 1,
        -1, 0x1.8p-64f, 0x1p64f,   0x1p-75f,   1e-30f,  1e30f,    NAN,     INFINITY, -INFINITY};
    enum { count = sizeof special / sizeof *special };
    uint32_t choice = bits(s) % (2 * count);
    if (choice < (s->finite_only ? count - 3 : count))
        return special[choice];
    return 2 * rk_unit_float(bits(s)) - 1;
}

static float positive(source *s)
{
    return fabsf(number(s));
}

/* In [0, 1), as samplers give them. */
static rk_vec2 sample(source *s)
{
    return (rk_vec2){bits(s) % 4 ? rk_unit_float(bits(s)) : 0,
                     bits(s) % 4 ? rk_unit_float(bits(s)) : 1 - 0x1p-24f};
}

static rk_vec3 vector(source *s)
{
    float x = number(s), y = number(s);
    return rk_vec(x, y, number(s));
}

/* Unit, along an axis or anywhere. */
static rk_vec3 direction(source *s)
{
    if (bits(s) % 2) {
        float sign = bits(s) % 2 ? 1 : -1, zero = bits(s) % 2 ? 0 : -0.0f;
        uint32_t axis = bits(s) % 3;
        return rk_vec(axis == 0 ? sign : zero, axis == 1 ? sign : zero, axis == 2 ? sign : zero);
    }
    rk_vec3 v = rk_vec(rk_unit_float(bits(s)) - 0.5f, rk_unit_float(bits(s)) - 0.5f,
                       rk_unit_float(bits(s)) - 0.6f);
    return rk_normalize(v);
}

static rk_ray any_ray(source *s)
{
    rk_vec3 origin = vector(s), along = vector(s);
    return (rk_ray){origin, along, number(s)};
}

static bool is_number(rk_vec3 v)
{
    return v.x == v.x && v.y == v.y && v.z == v.z;
}

static bool is_finite(rk_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* --- Rays ------------------------------------------------------------------------------------- */

static void boxes_are_entered_at_a_number(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        rk_ray ray = any_ray(&s);
        rk_slabs slabs = rk_slabs_of(&ray);
        rk_box box = rk_box_add(rk_box_add(rk_box_empty(), vector(&s)), vector(&s));
        float t = rk_box_enter(&box, &slabs, ray.t_max);
        rk_check(t >= 0, "trial %u: the box is entered at %g", i, (double)t);
        bool is_endless = !is_finite(box.corner[0]) || !is_finite(box.corner[1]);
        rk_check(is_endless || rk_box_area(box) >= 0, "trial %u: an area of %g", i,
                 rk_box_area(box));
    }
}

static void hits_are_on_the_ray_and_in_the_triangle(void **state)
{
    (void)state;
    uint32_t hits = 0;
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        rk_vec3 corners[3] = {vector(&s), vector(&s), vector(&s)};
        uint32_t indices[1][3] = {{0, 1, 2}};
        rk_mesh mesh = {.positions = corners, .triangles = indices};
        rk_triangle triangle = rk_bvh_triangle_of(&mesh, 0);
        rk_ray ray = any_ray(&s);
        rk_hit hit = {ray.t_max, 0, 0, RK_MISS};
        bool found = rk_triangle_closest(&triangle, &ray, &hit);
        rk_check(!found || (hit.t > 0 && hit.t < INFINITY && hit.u >= 0 && hit.v >= 0 &&
                            hit.u <= 1 && hit.v <= 1),
                 "trial %u: t %g, u %g, v %g", i, (double)hit.t, (double)hit.u, (double)hit.v);
        hits += found;
        rk_sphere sphere = {vector(&s), positive(&s)};
        float t = rk_sphere_intersect(&sphere, &ray, ray.t_max);
        rk_check(t > 0 && (t == INFINITY || t <= ray.t_max), "trial %u: the sphere at %g", i,
                 (double)t);
    }
    rk_check(hits > 0, "no ray hits: the test tests nothing");
}

/* A mesh is valid only with finite numbers; rays may be anything. Fewer than elsewhere, because
 * nearly all of them need exact sums, triangle by triangle. */
static void trees_end_every_ray(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(200);
    for (uint32_t i = 0; i < scene.mesh.vertex_count; i++) {
        source s = {.trial = i, .draws = 1000, .finite_only = true};
        scene.mesh.positions[i] = vector(&s);
    }
    for (int sah = 0; sah < 2; sah++) {
        rk_accel accel;
        rk_error error;
        rk_check_ok(rk_accel_build(&accel, sah ? RK_ACCEL_SAH_3 : RK_ACCEL_MEDIAN, &scene, &error),
                    error);
        rk_check_ok(rk_bvh_validate(&accel.bvh, &scene.mesh, &error), error);
        for (uint32_t i = 0; i < trials() / 50; i++) {
            source s = {.trial = i};
            rk_ray ray = any_ray(&s);
            rk_counters counters = {0};
            rk_hit hit = rk_bvh_closest(&accel.bvh, &ray, &counters);
            bool occluded = rk_bvh_occluded(&accel.bvh, &ray, &counters);
            rk_check(occluded == (hit.triangle != RK_MISS), "trial %u: one hits, one does not", i);
            rk_check(hit.triangle == RK_MISS || (hit.t > 0 && hit.t <= ray.t_max), "trial %u: t %g",
                     i, (double)hit.t);
        }
        rk_accel_free(&accel);
    }
    rk_scene_free(&scene);
}

static void surfaces_have_a_normal_and_spawn_rays(void **state)
{
    (void)state;
    uint32_t indices[1][3] = {{0, 1, 2}};
    uint16_t material_of[1] = {0};
    rk_material material = {.alpha = 1};
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i, .finite_only = true};
        rk_vec3 corners[3];
        for (int k = 0; k < 3; k++) /* differences of larger ones are infinite */
            corners[k] = rk_scale(vector(&s), 0x1p-66f);
        rk_mesh mesh = {.positions = corners,
                        .triangles = indices,
                        .triangle_materials = material_of,
                        .materials = &material};
        rk_vec2 at = sample(&s);
        rk_hit hit = {1, at.x, at.y * (1 - at.x), 0};
        rk_ray ray = {rk_vec(0, 0, 0), direction(&s), INFINITY};
        rk_surface surface;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        rk_check(is_finite(surface.point) && is_finite(surface.point_error), "trial %u: the point",
                 i);
        rk_check_near(rk_length(surface.face_normal), 1, 4 * 0x1p-24, "trial %u: normal", i);
        rk_check(is_finite(rk_surface_spawn(&surface, direction(&s))), "trial %u: the start", i);
        rk_surface_move(&surface, rk_vec(1, 2, 3));
        rk_check(is_finite(rk_surface_spawn(&surface, direction(&s))), "trial %u: moved", i);
    }
}

/* --- Light and colour ------------------------------------------------------------------------- */

static void shades_are_numbers_at_any_shininess(void **state)
{
    (void)state;
    static const float shininess[] = {0, 0x1p-149f, 1e-6f, 0.5f, 1, 100, 1e5f, 1e6f, FLT_MAX};
    const rk_vec3 colour = {0.5f, 0.5f, 0.5f};
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i, .finite_only = true};
        rk_shading shading = {(rk_shading_model)(i % 5), i / 5 % 2, rk_gradient_cool_to_warm()};
        rk_vec3 n = direction(&s), l = direction(&s), v = direction(&s), light = vector(&s);
        float exponent = shininess[bits(&s) % (sizeof shininess / sizeof *shininess)];
        rk_vec3 got = rk_shade(&shading, colour, colour, exponent, n, l, v, light);
        rk_check(is_number(got), "trial %u: model %u at shininess %g", i, shading.model,
                 (double)exponent);
    }
}

static void gradients_have_a_colour_everywhere(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i, .finite_only = true};
        rk_gradient gradient = {.count = bits(&s) % (RK_GRADIENT_STOPS_MAX + 1)};
        for (uint32_t k = 0; k < gradient.count; k++)
            gradient.stops[k] = (rk_gradient_stop){number(&s), {1, 0.5f, 0}};
        s.finite_only = false;
        rk_vec3 got = rk_gradient_at(&gradient, number(&s));
        rk_check(got.x >= 0 && got.x <= 1.0001f, "trial %u: %g", i, (double)got.x);
    }
}

/* Points in the light's plane, on its edges, at its corners; needles and lights without area. */
static void lights_of_any_shape_give_a_number(void **state)
{
    (void)state;
    static const float sizes[] = {0, 1, -1, 1e-15f, 1e-6f, 0.5f, 1e6f, 1e15f};
    enum { count = sizeof sizes / sizeof *sizes, short_count = count - 2 }; /* edges up to 1 */
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        float at[12];
        for (int k = 0; k < 12; k++)
            at[k] = sizes[bits(&s) % (k / 3 == 1 || k / 3 == 2 ? short_count : count)];
        rk_light light = {(rk_light_kind)(i % 3),
                          {at[0], at[1], at[2]},
                          {at[3], at[4], at[5]},
                          {at[6], at[7], at[8]},
                          {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
        rk_vec3 point = rk_vec(at[9], at[10], at[11]);
        /* Where sizes are 1e30 apart, all that is known of a half is that it is at most 2 pi. */
        double angle = rk_light_solid_angle(&light, point);
        rk_check(angle >= 0 && angle <= 4 * RK_PI_DOUBLE, "trial %u: %g sr", i, angle);
        float irradiance = rk_light_irradiance(&light, point, direction(&s));
        rk_check(irradiance >= 0 && isfinite(irradiance), "trial %u: irradiance %g", i,
                 (double)irradiance);
        for (int way = 0; way < 4; way++) {
            rk_light_sample got = rk_light_sample_at(&light, (rk_light_falloff)(way % 2),
                                                     (rk_light_domain)(way / 2), point, sample(&s));
            rk_check(is_finite(got.position) && is_finite(got.colour) && got.colour.x >= 0,
                     "trial %u: a sample of weight %g", i, (double)got.colour.x);
        }
    }
}

static void lookups_and_encodings_take_anything(void **state)
{
    (void)state;
    rk_vec3 pixels[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    rk_srgb8 table;
    rk_error error;
    rk_srgb8_init(&table);
    for (uint32_t side = 1; side < 4; side++) {
        rk_cubemap map;
        rk_check_ok(rk_cubemap_init(&map, side, &error), error);
        for (uint32_t i = 0; i < trials() / 4; i++) {
            source s = {.trial = i};
            rk_vec3 along = vector(&s);
            rk_cube_place place = rk_cubemap_place(along);
            rk_check(place.face < RK_FACES && place.u >= 0 && place.u <= 1 && place.v >= 0 &&
                         place.v <= 1,
                     "trial %u: face %u at %g, %g", i, place.face, (double)place.u,
                     (double)place.v);
            for (int filter = 0; filter < 3; filter++)
                rk_check(is_finite(rk_cubemap_at(&map, along, (rk_cubemap_filter)filter)),
                         "trial %u: filter %d", i, filter);
            const rk_texture texture = {
                {2, 2, pixels}, (rk_texture_wrap)(i % 2), (rk_texture_filter)(i / 2 % 2)};
            rk_vec2 uv = {number(&s), number(&s)};
            rk_check(is_finite(rk_texture_at(&texture, uv)), "trial %u: the texture", i);
            float value = number(&s), encoded = rk_srgb_encode(value);
            rk_check(encoded >= 0 && encoded <= 1.0001f && rk_srgb_decode(value) >= 0 &&
                         rk_srgb_decode(value) <= 1.0001f,
                     "%g is stored as %g", (double)value, (double)encoded);
            int stored = rk_srgb8_encode(&table, value);
            rk_check(value > 0 ? stored > 0 || value < 0.001f : stored == 0, "%g is stored as %d",
                     (double)value, stored);
        }
        rk_cubemap_free(&map);
    }
}

/* --- Lens, mirrors, glass, bloom -------------------------------------------------------------- */

static void circles_of_any_size_are_counted(void **state)
{
    (void)state;
    enum { width = 5, height = 3 };
    for (uint32_t i = 0; i < trials() / 10; i++) {
        source s = {.trial = i};
        float diameters[width * height];
        int32_t count[(width + 1) * (height + 1)];
        for (int k = 0; k < width * height; k++)
            diameters[k] = number(&s);
        rk_lens_coc(diameters, width, height, count);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                int32_t reached = count[y * (width + 1) + x];
                rk_check(reached >= 0 && reached <= width * height, "trial %u: %d circles", i,
                         reached);
            }
    }
}

static void lenses_of_any_size_give_unit_rays(void **state)
{
    (void)state;
    static const float sizes[] = {0x1p-60f, 1e-6f, 0.5f, 1, 1000, 1e6f, 0x1p60f};
    enum { count = sizeof sizes / sizeof *sizes };
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        rk_camera camera = {.fov = bits(&s) % 2 ? 0.01f : 179, .distance = sizes[bits(&s) % count]};
        rk_view view = rk_view_of(&camera, 1 + bits(&s) % 3, 1 + bits(&s) % 32768);
        float focal = bits(&s) % 4 ? sizes[bits(&s) % count] : INFINITY;
        float widest = focal < INFINITY ? 1e6f * focal : 1e6f;
        rk_lens lens = {focal, fminf(1000 * sizes[bits(&s) % count], widest),
                        (rk_focal_surface)(bits(&s) % 2)};
        rk_vec2 place = sample(&s);
        rk_ray ray =
            rk_lens_ray(&lens, &view, place.x * view.width, place.y * view.height, sample(&s));
        rk_check(is_finite(ray.origin), "trial %u: the origin", i);
        rk_check_near(rk_length(ray.direction), 1, 8 * 0x1p-24, "trial %u: the direction", i);
        rk_ray middle = rk_view_ray(&view, place.x * view.width, place.y * view.height);
        float t = bits(&s) % 4 ? sizes[bits(&s) % count] : INFINITY;
        float circle = rk_lens_coc_diameter(&lens, &view, &middle, t);
        rk_check(circle >= 0, "trial %u: a circle of %g pixels", i, (double)circle);
    }
}

static void rough_mirrors_and_hemispheres_have_directions(void **state)
{
    (void)state;
    static const float radii[] = {0, 0x1p-149f, 1e-20f, 1e-6f, 0.5f, 1, 1000};
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        rk_vec3 w = direction(&s), n = direction(&s), along;
        if (rk_dot(w, n) < 0)
            n = rk_negate(n);
        rk_glossy_disk disk =
            rk_glossy_disk_of(w, radii[bits(&s) % (sizeof radii / sizeof *radii)], n);
        float above = rk_glossy_fraction_above(&disk);
        rk_check(above >= 0.4999f && above <= 1, "trial %u: a fraction of %g", i, (double)above);
        for (int map = 0; map < 2; map++) {
            rk_vec2 at =
                rk_glossy_point_above(&disk, above, rk_disk_at((rk_disk_map)map, sample(&s)));
            rk_glossy_direction(&disk, at, &along);
            rk_check_near(rk_length(along), 1, 16 * 0x1p-24, "trial %u: the reflected ray", i);
            rk_ambient_frame frame = rk_ambient_frame_of(w, n);
            rk_ambient_direction(&frame, rk_ambient_hemisphere((rk_ambient_map)map, sample(&s)),
                                 &along);
            rk_check_near(rk_length(along), 1, 16 * 0x1p-24, "trial %u: the direction", i);
        }
        rk_check(rk_glossy_radius(positive(&s)) <= 1, "trial %u: the radius", i);
    }
}

static void crossings_of_any_kind_leave_a_list_in_order(void **state)
{
    (void)state;
    static rk_crossing_list list;
    for (uint32_t i = 0; i < trials() / 10; i++) {
        source s = {.trial = i, .finite_only = true};
        rk_transparency_start(&list, 1 + bits(&s) % 6);
        for (uint32_t k = 0; k < 10; k++) {
            rk_crossing crossing = {.t = positive(&s),
                                    .primitive = bits(&s) % 4,
                                    .medium = bits(&s) % 2,
                                    .entering = bits(&s) % 2,
                                    .alpha = fminf(positive(&s), 1),
                                    .kd = {1, 0.5f, 0},
                                    .absorption = {positive(&s), 0, 1}};
            rk_transparency_insert(&list, &crossing);
        }
        rk_check(list.count > 0 && list.count <= list.limit, "trial %u: %u crossings", i,
                 list.count);
        for (uint32_t k = 1; k < list.count; k++)
            rk_check(list.crossings[k - 1].t <= list.crossings[k].t, "trial %u: out of order", i);
        for (uint32_t k = 0; k < list.count; k++) /* shadow rays end at the light */
            list.crossings[k].t = fminf(list.crossings[k].t, 0x1.fffffep-1f);
        for (int model = 0; model < 3; model++) {
            rk_vec3 got = rk_transparency_transmit((rk_glass_model)model, list.crossings,
                                                   list.count, positive(&s) * 1e-20f);
            rk_check(got.x >= 0 && got.x <= 1.00001f && got.y >= 0 && got.z >= 0,
                     "trial %u: model %d lets %g through", i, model, (double)got.x);
        }
    }
}

static void bright_is_never_what_cannot_be_blurred(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i};
        rk_vec3 colour = vector(&s);
        bool can = fabsf(colour.x) <= RK_BLOOM_BRIGHTEST && fabsf(colour.y) <= RK_BLOOM_BRIGHTEST &&
                   fabsf(colour.z) <= RK_BLOOM_BRIGHTEST;
        rk_check(can || !rk_bloom_is_bright(colour, -FLT_MAX), "trial %u: %g %g %g", i,
                 (double)colour.x, (double)colour.y, (double)colour.z);
    }
}

/* --- Motion ----------------------------------------------------------------------------------- */

static void times_stay_within_shutters_of_any_length(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < trials(); i++) {
        source s = {.trial = i, .finite_only = true};
        float one = number(&s), other = number(&s);
        const rk_shutter shutter = {fminf(one, other), fmaxf(one, other)};
        uint32_t samples = 1 + bits(&s) % 20;
        for (int kind = 0; kind < 3; kind++) {
            float x = rk_shutter_time(&shutter, (rk_time_sampling)kind, 1, i, bits(&s) % samples,
                                      samples);
            rk_check(x >= shutter.open && x <= shutter.close, "trial %u: %g is not in %g .. %g", i,
                     (double)x, (double)shutter.open, (double)shutter.close);
        }
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(boxes_are_entered_at_a_number),
    cmocka_unit_test(hits_are_on_the_ray_and_in_the_triangle),
    cmocka_unit_test(trees_end_every_ray),
    cmocka_unit_test(surfaces_have_a_normal_and_spawn_rays),
    cmocka_unit_test(shades_are_numbers_at_any_shininess),
    cmocka_unit_test(gradients_have_a_colour_everywhere),
    cmocka_unit_test(lights_of_any_shape_give_a_number),
    cmocka_unit_test(lookups_and_encodings_take_anything),
    cmocka_unit_test(circles_of_any_size_are_counted),
    cmocka_unit_test(lenses_of_any_size_give_unit_rays),
    cmocka_unit_test(rough_mirrors_and_hemispheres_have_directions),
    cmocka_unit_test(crossings_of_any_kind_leave_a_list_in_order),
    cmocka_unit_test(bright_is_never_what_cannot_be_blurred),
    cmocka_unit_test(times_stay_within_shutters_of_any_length),
};

RK_SUITE("stress special_values", tests)
