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

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_point_light_has_one_colour),
    cmocka_unit_test(each_corner_that_a_light_has_can_change_its_colour),
    cmocka_unit_test(a_segment_gives_the_value_of_its_integral),
    cmocka_unit_test(a_segment_below_the_horizon_gives_nothing),
    cmocka_unit_test(a_segment_in_line_or_without_length_gives_nothing),
};

RK_SUITE("light", tests)
