/* The exact sphere: against the textbook's quadratic in long double, from inside, from far away,
 * and as a surface that spawns rays. */
#include "test.h"

#include "base/random.h"
#include "base/sphere.h"
#include "scene/surface.h"

static float noise(uint32_t a, uint32_t b)
{
    return 2 * rk_unit_float(rk_hash(a, b, 7, 1)) - 1;
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(noise(a, 3 * b), noise(a, 3 * b + 1), noise(a, 3 * b + 2));
}

/* The smaller positive root, or NAN. `margin` gets the line's distance from the rim: the
 * discriminant over its two parts. */
static long double quadratic(const rk_sphere *sphere, const rk_ray *ray, long double *margin)
{
    long double o[3] = {(long double)ray->origin.x - (long double)sphere->centre.x,
                        (long double)ray->origin.y - (long double)sphere->centre.y,
                        (long double)ray->origin.z - (long double)sphere->centre.z};
    long double d[3] = {(long double)ray->direction.x, (long double)ray->direction.y,
                        (long double)ray->direction.z};
    long double a = 0, b = 0, c = -(long double)sphere->radius * (long double)sphere->radius;
    for (int i = 0; i < 3; i++)
        a += d[i] * d[i], b += o[i] * d[i], c += o[i] * o[i];
    long double discriminant = b * b - a * c;
    *margin = fabsl(discriminant) / (b * b + fabsl(a * c));
    if (discriminant < 0)
        return (long double)NAN;
    long double root = sqrtl(discriminant);
    long double near = (-b - root) / a, far = (-b + root) / a;
    return near > 0 ? near : far > 0 ? far : (long double)NAN;
}

static void a_ray_at_the_centre_stops_at_the_radius(void **state)
{
    (void)state;
    rk_sphere sphere = {rk_vec(0, 0, 5), 2};
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_check_close(rk_sphere_intersect(&sphere, &ray, INFINITY), 3, 0, "5 - 2, exact in floats");
    ray.direction = rk_vec(0, 0, 2);
    rk_check_close(rk_sphere_intersect(&sphere, &ray, INFINITY), 1.5, 0, "t counts in directions");
}

static void from_inside_the_far_side_is_hit(void **state)
{
    (void)state;
    rk_sphere sphere = {rk_vec(1, 1, 1), 2};
    rk_ray ray = {rk_vec(1, 1, 1), rk_vec(0, 1, 0), INFINITY};
    rk_check_close(rk_sphere_intersect(&sphere, &ray, INFINITY), 2, 0,
                   "the radius, exact in floats");
}

static void a_sphere_behind_or_beyond_t_max_is_missed(void **state)
{
    (void)state;
    rk_sphere sphere = {rk_vec(0, 0, 5), 2};
    rk_ray away = {rk_vec(0, 0, 0), rk_vec(0, 0, -1), INFINITY};
    rk_check(rk_sphere_intersect(&sphere, &away, INFINITY) == INFINITY, "the sphere is behind");
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_check(rk_sphere_intersect(&sphere, &ray, 2.99f) == INFINITY, "3 is beyond 2.99");
    rk_check(rk_sphere_intersect(&sphere, &ray, 3) == 3, "t_max itself counts");
    rk_ray beside = {rk_vec(3, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_check(rk_sphere_intersect(&sphere, &beside, INFINITY) == INFINITY,
             "it passes at distance 3");
}

static void random_rays_hit_it_where_the_quadratic_says(void **state)
{
    (void)state;
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 300000; i++) {
        rk_sphere sphere = {noise3(1, i), 0.01f + rk_unit_float(rk_hash(2, i, 0, 0))};
        rk_ray ray = {rk_scale(noise3(3, i), 4), rk_vec(0, 0, 0), INFINITY};
        ray.direction = rk_sub(rk_madd(sphere.centre, noise3(4, i), sphere.radius), ray.origin);
        long double margin, want = quadratic(&sphere, &ray, &margin);
        float got = rk_sphere_intersect(&sphere, &ray, INFINITY);
        /* Within 2^-18 of the rim, 64 roundings, either result is right. */
        if (margin < 0x1p-18L)
            continue;
        hits += isnan(want) ? 0 : 1;
        if (isnan(want))
            rk_check(got == INFINITY, "ray %u: got %g for a miss", i, (double)got);
        else {
            /* Eight roundings of lengths like |o - c| and r; under the root, a relative error e of
             * the whole becomes e / sqrt(margin) near the rim. */
            rk_vec3 f = rk_sub(ray.origin, sphere.centre);
            float scale = (rk_length(f) + sphere.radius) / rk_length(ray.direction);
            rk_check_close(got, want, 8 * 0x1p-24L * scale / sqrtl(margin), "t");
        }
    }
    rk_check(hits > 100000, "only %u of 300,000 rays hit: the test tests little", hits);
}

static void a_small_sphere_far_away_keeps_its_size(void **state)
{
    (void)state;
    /* Radius 1 at distance 4,000: in floats, b^2 - 4ac would have an error of about 1 in the square
     * of the radius, and the rim would be anywhere. */
    rk_sphere sphere = {rk_vec(0, 0, 4000), 1};
    for (int i = 0; i < 2000; i++) {
        float x = (float)i / 1000;
        rk_ray ray = {rk_vec(x, 0, 0), rk_vec(0, 0, 1), INFINITY};
        bool is_hit = rk_sphere_intersect(&sphere, &ray, INFINITY) < INFINITY;
        rk_check(is_hit == (x <= 1), "a ray at distance %g from the centre: %d", (double)x, is_hit);
    }
}

static void rays_of_nan_and_none_miss(void **state)
{
    (void)state;
    rk_sphere sphere = {rk_vec(0, 0, 0), 1};
    rk_ray nan = {rk_vec(NAN, 0, 0), rk_vec(0, NAN, 1), INFINITY};
    rk_check(rk_sphere_intersect(&sphere, &nan, INFINITY) == INFINITY, "NaN");
    rk_ray none = {rk_vec(0, 0, -3), rk_vec(0, 0, 0), INFINITY};
    rk_check(rk_sphere_intersect(&sphere, &none, INFINITY) == INFINITY, "a direction of length 0");
}

static void the_closest_hit_keeps_a_nearer_one(void **state)
{
    (void)state;
    rk_sphere sphere = {rk_vec(0, 0, 5), 2};
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_hit hit = {2.5f, 0.25f, 0.25f, 3};
    rk_check(!rk_sphere_closest(&sphere, 9, &ray, &hit), "2.5 is nearer than 3");
    rk_check_equal(hit.triangle, 3, "the nearer hit stays");
    hit.t = 4;
    rk_check(rk_sphere_closest(&sphere, 9, &ray, &hit), "3 is nearer than 4");
    rk_check_equal(hit.triangle, 9, "the sphere's index");
    hit = (rk_hit){ray.t_max, 0, 0, RK_MISS};
    ray.direction = rk_vec(0, 1, 0);
    rk_check(!rk_sphere_closest(&sphere, 9, &ray, &hit), "a miss");
    rk_check_equal(hit.triangle, RK_MISS, "stays a miss");
}

/* Hits spheres of sizes 2^-10 .. 2^10 at distances up to a thousand radii from the origin. */
static void rays_spawned_outwards_never_hit_the_sphere_again(void **state)
{
    (void)state;
    rk_material material = {.alpha = 1};
    uint32_t tried = 0;
    for (uint32_t i = 0; i < 300000; i++) {
        float radius = ldexpf(1, (int)(i % 21) - 10);
        rk_sphere sphere = {rk_scale(noise3(10, i), radius * (i % 4 == 0 ? 1000.0f : 1)), radius};
        rk_ray ray = {rk_madd(sphere.centre, noise3(11, i), 4 * radius), rk_vec(0, 0, 0), INFINITY};
        ray.direction = rk_sub(rk_madd(sphere.centre, noise3(12, i), 0.5f * radius), ray.origin);
        rk_hit hit = {ray.t_max, 0, 0, RK_MISS};
        if (!rk_sphere_closest(&sphere, 0, &ray, &hit))
            continue;
        rk_surface surface;
        rk_surface_at_sphere(&surface, &sphere, &material, &ray, &hit);
        rk_vec3 outward = surface.normal; /* faces the ray, which may come from inside */
        if (rk_dot(outward, rk_sub(surface.point, sphere.centre)) < 0)
            outward = rk_negate(outward);
        rk_check_close(rk_length(surface.normal), 1, 4 * 0x1p-24, "unit to a few roundings");
        rk_check(rk_dot(surface.normal, ray.direction) <= 0, "ray %u: the normal faces away", i);
        /* Every fourth direction is nearly tangential. */
        rk_vec3 way = rk_normalize(noise3(13, i));
        way =
            rk_madd(way, outward,
                    -(i % 4 == 1 ? 0.9999f : 0) * rk_dot(way, outward) / rk_dot(outward, outward));
        if (rk_dot(way, outward) < 0)
            way = rk_negate(way);
        rk_ray leaving = {rk_surface_spawn(&surface, way), way, INFINITY};
        tried++;
        rk_check(rk_sphere_intersect(&sphere, &leaving, INFINITY) == INFINITY,
                 "ray %u comes back at t = %g to a sphere of radius %g", i,
                 (double)rk_sphere_intersect(&sphere, &leaving, INFINITY), (double)radius);
        rk_vec3 step = rk_sub(leaving.origin, surface.point);
        rk_check(rk_length(step) <= 8 * rk_length(surface.point_error), "ray %u: a step of %g", i,
                 (double)rk_length(step));
    }
    rk_check(tried > 100000, "only %u rays: the test tests little", tried);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_ray_at_the_centre_stops_at_the_radius),
    cmocka_unit_test(from_inside_the_far_side_is_hit),
    cmocka_unit_test(a_sphere_behind_or_beyond_t_max_is_missed),
    cmocka_unit_test(random_rays_hit_it_where_the_quadratic_says),
    cmocka_unit_test(a_small_sphere_far_away_keeps_its_size),
    cmocka_unit_test(rays_of_nan_and_none_miss),
    cmocka_unit_test(the_closest_hit_keeps_a_nearer_one),
    cmocka_unit_test(rays_spawned_outwards_never_hit_the_sphere_again),
};

RK_SUITE("sphere", tests)
