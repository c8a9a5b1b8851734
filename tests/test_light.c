/* Lights: those of one colour, and a segment's irradiance. */
#include "test.h"

#include "scene/light.h"

static void a_point_light_has_one_colour(void **state)
{
    (void)state;
    rk_light light = rk_light_point(rk_vec(1, 2, 3), rk_vec(0.5f, 1, 0));
    rk_check(rk_light_has_one_colour(&light), "colours 1 to 3 of a point light are not read");
}

static void each_corner_that_a_light_has_can_change_its_colour(void **state)
{
    (void)state;
    for (int kind = 1; kind < 3; kind++)
        for (int corner = 0; corner < 4; corner++) {
            rk_light light = {.kind = (rk_light_kind)kind};
            rk_check(rk_light_has_one_colour(&light), "all corners are black");
            light.colours[corner].z = 1;
            bool has = kind == RK_LIGHT_PARALLELOGRAM || corner < 2;
            rk_check_equal(rk_light_has_one_colour(&light), !has,
                           "a segment has corners 0 and 1, a parallelogram all four");
        }
}

static void a_segment_gives_the_value_of_its_integral(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846;
    const rk_dvec3 up = {0, 0, 1}, aside = {1, 0, 0}, along = {2e6, 0, 0};
    /* At height 2 from phi = 0 to nearly pi / 2: the integral of cos^2 phi is pi / 4, and of sin
     * phi cos phi 1 / 2. */
    rk_check_close(rk_light_segment_irradiance((rk_dvec3){0, 0, 2}, along, up), pi / 8, 1e-6,
                   "half of a long segment above the surface");
    rk_check_close(rk_light_segment_irradiance((rk_dvec3){0, 0, 2}, along, aside), 0.25, 1e-6,
                   "half of a long segment beside the surface");
    rk_check_close(rk_light_segment_irradiance((rk_dvec3){-1e6, 0, 2}, along, aside), 0.25, 1e-6,
                   "the half behind the surface does not count");
}

static void a_segment_below_the_horizon_gives_nothing(void **state)
{
    (void)state;
    double got =
        rk_light_segment_irradiance((rk_dvec3){0, 1, -1}, (rk_dvec3){1, 0, 0}, (rk_dvec3){0, 0, 1});
    rk_check_close(got, 0, 0, "it is behind the surface");
}

static void a_segment_in_line_or_without_length_gives_nothing(void **state)
{
    (void)state;
    double got = rk_light_segment_irradiance((rk_dvec3){0.1, 0.2, 0.3}, (rk_dvec3){0.1, 0.2, 0.3},
                                             (rk_dvec3){0, 0, 1});
    rk_check_close(got, 0, 0, "in line with the point it is seen as a dot");
    got =
        rk_light_segment_irradiance((rk_dvec3){0, 0, 1}, (rk_dvec3){0, 0, 0}, (rk_dvec3){0, 0, 1});
    rk_check_close(got, 0, 0, "it has no length");
}

static const rk_light slanted = {.kind = RK_LIGHT_PARALLELOGRAM,
                                 .position = {1, 2, 3},
                                 .edge01 = {2, 0.5f, -1},
                                 .edge02 = {-1, 3, 0.25f}};

static rk_vec3 point_of(const rk_light *light, float x, float y)
{
    return rk_madd(rk_madd(light->position, light->edge01, x), light->edge02, y);
}

static void a_ray_hits_the_place_of_the_light_to_which_it_points(void **state)
{
    (void)state;
    const rk_vec3 from = {-3, 1, 7};
    rk_vec2 at;
    for (float x = -0.45f; x < 1.5f; x += 0.1f)
        for (float y = -0.45f; y < 1.5f; y += 0.1f) {
            bool inside = x > 0 && x < 1 && y > 0 && y < 1;
            rk_vec3 to = rk_sub(point_of(&slanted, x, y), from);
            for (int k = 0; k < 3; k++) {
                rk_vec3 direction = rk_scale(to, k == 0 ? 1 : k == 1 ? 1e-3f : -1);
                rk_check_equal(rk_light_hit(&slanted, from, direction, &at), inside && k < 2,
                               "only within both edges, for any length, and not backwards");
                if (k == 2)
                    continue;
                /* Coordinates below 8 are rounded by 2^-22, and seen at a slope of up to 3. */
                rk_check_close(at.x, (double)x, 2e-6, "x along the first edge");
                rk_check_close(at.y, (double)y, 2e-6, "y along the second edge");
            }
        }
}

static void rays_in_the_plane_of_a_light_do_not_hit_it(void **state)
{
    (void)state;
    const rk_light flat = {
        .kind = RK_LIGHT_PARALLELOGRAM, .edge01 = {1, 0, 0}, .edge02 = {0, 1, 0}};
    const rk_light no_area = {
        .kind = RK_LIGHT_PARALLELOGRAM, .edge01 = {1, 0, 0}, .edge02 = {1, 0, 0}};
    const rk_vec3 beside = {-1, 0.5f, 0}, above = {0.5f, 0.5f, 1}, down = {0, 0, -1};
    rk_vec2 at;
    rk_check(!rk_light_hit(&flat, beside, rk_vec(1, 0, 0), &at), "edge-on");
    rk_check(!rk_light_hit(&flat, above, rk_vec(1, 0, 0), &at), "parallel");
    rk_check(!rk_light_hit(&no_area, above, down, &at), "no area");
    rk_check(rk_light_hit(&flat, above, down, &at), "straight down");
    rk_check(isinf(rk_light_area_density(&flat, beside, rk_vec(0.5f, 0.5f, 0))),
             "its samples are all in one direction");
}

/* With samples uniform over the area the mean of 1 / density is the solid angle: over a rectangle's
 * corner, at the height h, atan(a b / (h sqrt(a^2 + b^2 + h^2))). */
static void the_density_of_area_samples_is_per_solid_angle(void **state)
{
    (void)state;
    const rk_light flat = {
        .kind = RK_LIGHT_PARALLELOGRAM, .edge01 = {2, 0, 0}, .edge02 = {0, 3, 0}};
    enum { side = 256 };
    for (float h = 0.5f; h < 100; h *= 4) {
        double sum = 0;
        for (int j = 0; j < side; j++)
            for (int i = 0; i < side; i++) {
                rk_vec3 place = point_of(&flat, ((float)i + 0.5f) / side, ((float)j + 0.5f) / side);
                sum += 1 / rk_light_area_density(&flat, rk_vec(0, 0, -h), place);
            }
        double height = (double)h, want = atan(6 / (height * sqrt(13 + height * height)));
        /* The midpoint rule errs by less than the square of a step, 3 / 256, over the height. */
        rk_check_close(sum / side / side, want, pow(3.0 / 256 / height, 2) * want + 1e-6 * want,
                       "the light's solid angle");
    }
}

/* From afar a segment is a point: its length, times both cosines, over the squared distance. It
 * subtends 1e-10, and less seen nearly from its end; a difference of two angles knows 1e-16. */
static void a_small_distant_segment_is_as_bright_as_a_point(void **state)
{
    (void)state;
    const rk_dvec3 up = {0, 0, 1}, edge = {1e-4, 0, 0};
    double got = rk_light_segment_irradiance((rk_dvec3){0, 0, 1e6}, edge, up);
    rk_check_close(got / (1e-4 / 1e12), 1, 1e-9, "facing the surface");
    got = rk_light_segment_irradiance((rk_dvec3){1e6, 0, 1e3}, edge, up);
    double square = 1e12 + 1e6, cosine = 1e3 / sqrt(square);
    rk_check_close(got / (1e-4 * cosine * cosine / square), 1, 1e-6,
                   "nearly in line: both cosines are 1e-3, of which 1e-6 is left of 1e-16");
}

/* Just above the horizon, or past the point, the two terms of the closed form nearly cancel. */
static void no_rounding_makes_a_segment_darker_than_dark(void **state)
{
    (void)state;
    const rk_dvec3 up = {0, 0, 1}, tilted = {1e-15, 1, 3e-16};
    const struct {
        rk_dvec3 from, edge, normal;
    } cases[] = {
        {{1e6, -0.2, 0}, {-0.4, 1e-6, 1e-6}, up},
        {{1e-6, 1e-15, 1e-15}, {1e15, 0.5, -0.7}, up},
        {{0, 1e-15, 1}, {0, 1e-15, -0.3}, tilted},
        {{1e-15, 0, -1}, {-0.96, 0.015, 1e15}, {-0.653, -0.312, 0.69}},
    };
    for (int i = 0; i < 4; i++) {
        double got = rk_light_segment_irradiance(cases[i].from, cases[i].edge, cases[i].normal);
        rk_check(got >= 0, "case %d: got %g", i, got);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_point_light_has_one_colour),
    cmocka_unit_test(each_corner_that_a_light_has_can_change_its_colour),
    cmocka_unit_test(a_segment_gives_the_value_of_its_integral),
    cmocka_unit_test(a_segment_below_the_horizon_gives_nothing),
    cmocka_unit_test(a_segment_in_line_or_without_length_gives_nothing),
    cmocka_unit_test(a_ray_hits_the_place_of_the_light_to_which_it_points),
    cmocka_unit_test(rays_in_the_plane_of_a_light_do_not_hit_it),
    cmocka_unit_test(the_density_of_area_samples_is_per_solid_angle),
    cmocka_unit_test(a_small_distant_segment_is_as_bright_as_a_point),
    cmocka_unit_test(no_rounding_makes_a_segment_darker_than_dark),
};

RK_SUITE("light", tests)
