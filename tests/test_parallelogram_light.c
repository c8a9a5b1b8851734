/* Lights with an extent: positions and weights of samples, that their mean is the light's
 * irradiance, and that the closed form, which the mean is compared with, is itself right. */
#include "test.h"

#include "base/sampler.h"
#include "features/parallelogram_light.h"

static const double pi = 3.14159265358979323846;

/* --- Lights and points to try ---------------------------------------------------------------- */

/* A number in [0, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_case(a, b, c, 4));
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(2 * noise(a, b, 0) - 1, 2 * noise(a, b, 1) - 1, 2 * noise(a, b, 2) - 1);
}

static rk_vec2 noise2(uint32_t a, uint32_t b)
{
    return (rk_vec2){noise(a, b, 3), noise(a, b, 4)};
}

static rk_light make_light(rk_light_kind kind, rk_vec3 position, rk_vec3 edge01, rk_vec3 edge02)
{
    return (rk_light){kind, position, edge01, edge02, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
}

static rk_light make_parallelogram(rk_vec3 position, rk_vec3 edge01, rk_vec3 edge02)
{
    return make_light(RK_LIGHT_PARALLELOGRAM, position, edge01, edge02);
}

/* Corners in black, red, green and blue, so that x and y cannot be confused. */
static rk_light make_coloured(rk_light_kind kind)
{
    return (rk_light){
        kind, {1, 2, 3}, {2, 0, 0}, {0, 4, 0}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

/* A light, and a surface that it lights. */
typedef struct configuration {
    const char *name;
    rk_light_kind kind;
    rk_vec3 position, edge01, edge02; /* of the light */
    rk_vec3 point, normal;
} configuration;

#define P RK_LIGHT_PARALLELOGRAM
#define S RK_LIGHT_SEGMENT
/* clang-format off */
static const configuration configurations[] = {
    {"ordinary", P, {-0.5f, -0.5f, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 1}},
    {"aside", P, {1, 0.5f, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 1}},
    {"turned", P, {1, 0, 1}, {0.5f, 1, 0.25f}, {-0.5f, 0.25f, 1}, {0, 0, 0}, {0, 0.6f, 0.8f}},
    {"oblique, a sharp angle", P, {0, 0, 1}, {1, 0, 0}, {2, 0.125f, 0}, {1, 1, 0}, {0, 0, 1}},
    {"oblique, a wide angle", P, {1, 0, 1}, {1, 0, 0}, {-2, 0.5f, 0.5f}, {0, 1, 0}, {0, 0, 1}},
    {"its other side", P, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"half below the horizon", P, {1, -1, -1}, {0, 2, 0}, {0, 0, 2}, {0, 0, 0}, {0, 0, 1}},
    {"a corner below the horizon", P, {1, 0, -0.5f}, {0, 1, 1}, {1, 0, 1}, {0, 0, 0}, {0, 0, 1}},
    {"a corner above the horizon", P, {1, 0, 0.5f}, {0, 1, -1}, {1, 0, -1}, {0, 0, 0}, {0, 0, 1}},
    {"three corners above it", P, {1, 0, -0.25f}, {0, 1, 0.5f}, {1, 0, 0.5f}, {0, 0, 0}, {0, 0, 1}},
    {"behind", P, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 1}},
    {"edge-on", P, {1, 0, 0.5f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.5f}, {1, 0, 0}},
    {"nearly edge-on", P, {1, 0, 0.5f}, {1, 0, 0}, {0, 1, 0},
     {0, 0, 0.4990234375f}, {0.6f, 0, 0.8f}},
    {"an edge on the horizon", P, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {0, 0, 1}},
    {"a corner on the surface", P, {0, 0, 0}, {0, 1, 1}, {1, 0, 1}, {0, 0.0625f, 0}, {0, 0, 1}},
    {"touching the point", P, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 0}, {0, 0, 1}},
    {"very near", P, {-0.31f, -0.23f, 1e-4f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 1}},
    {"very near, surface turned", P, {-0.31f, -0.23f, 1e-4f}, {1, 0, 0}, {0, 1, 0},
     {0, 0, 0}, {0.8f, 0, 0.6f}},
    {"very near its edge", P, {0, -0.45f, 1e-4f}, {1, 0, 0}, {0, 1, 0},
     {0, 0, 0}, {0.6f, 0, 0.8f}},
    {"very far", P, {0, 0, 1e4f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 1}},
    {"very far, turned", P, {6e3f, 0, 8e3f}, {1, 0, 1}, {0, 1, 0}, {0, 0, 0}, {0.6f, 0, 0.8f}},
    {"tiny", P, {1, 1, 1}, {1e-6f, 0, 0}, {0, 1e-6f, 0}, {0, 0, 0}, {0, 0, 1}},
    {"huge", P, {-9e3f, -1.1e4f, 1}, {2e4f, 0, 0}, {0, 2e4f, 0}, {0, 0, 0}, {0, 0, 1}},
    {"thin", P, {-1, 0, 1}, {2, 0, 0}, {0, 1e-5f, 0}, {0, 0, 0}, {0, 0, 1}},
    {"far from the origin", P, {1e4f, 1e4f, 1e4f}, {1, 0, 0}, {0, 1, 0},
     {1e4f, 1e4f, 9999}, {0, 0, 1}},
    {"slanted, far and nearly edge-on", P, {64.9f, 88.2f, 42.71f}, {1, 0.7f, 0.3f},
     {-0.2f, 0.9f, 0.5f}, {0.1f, 0.2f, 0.3f}, {0.6f, 0.8f, 0}},
    {"slanted, ten times as far", P, {648.1f, 880.2f, 424.4f}, {1, 0.7f, 0.3f},
     {-0.2f, 0.9f, 0.5f}, {0.1f, 0.2f, 0.3f}, {0.6f, 0.8f, 0}},
    {"slanted, a hundred times as far", P, {6480.1f, 8800.2f, 4241.3f}, {1, 0.7f, 0.3f},
     {-0.2f, 0.9f, 0.5f}, {0.1f, 0.2f, 0.3f}, {0.6f, 0.8f, 0}},
    {"without area: parallel edges", P, {-1, 0, 1}, {2, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"without area: one edge", P, {-1, 0, 1}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"without area: no edges", P, {-1, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a segment", S, {-1, 0, 1}, {2, 1, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a segment through the horizon", S, {1, 0, -0.5f}, {1, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a segment from below", S, {2, 1, 1}, {-1, 0, -3}, {0, 0, 0}, {0, 0, 0}, {0.6f, 0, 0.8f}},
    {"a segment in line with the point", S, {1, 0, 1}, {1, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a segment, very far", S, {0, 0, 1e4f}, {1, 1, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a segment, very near", S, {-1, 0, 1e-4f}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
    {"a point", RK_LIGHT_POINT, {1, 2, 2}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
};
/* clang-format on */
#undef P
#undef S
enum { CONFIGURATIONS = sizeof configurations / sizeof *configurations };

static rk_light light_of(const configuration *c)
{
    return make_light(c->kind, c->position, c->edge01, c->edge02);
}

static void check_vec3_or(rk_vec3 got, rk_vec3 want, float tolerance,
                          const rk_vector_mistake *known, const char *hint)
{
    char within[40] = "";
    if (tolerance != 0)
        snprintf(within, sizeof within, " within %.3g", (double)tolerance);
    rk_check(fabsf(got.x - want.x) <= tolerance && fabsf(got.y - want.y) <= tolerance &&
                 fabsf(got.z - want.z) <= tolerance,
             "got (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g)%s: %s%s", (double)got.x,
             (double)got.y, (double)got.z, (double)want.x, (double)want.y, (double)want.z, within,
             hint, rk_mistake_in_vector(RK_XYZ(got), RK_XYZ(want), (double)tolerance, known));
}

static void check_vec3(rk_vec3 got, rk_vec3 want, float tolerance, const char *hint)
{
    check_vec3_or(got, want, tolerance, NULL, hint);
}

static rk_light_sample plain_sample(const rk_light *light, float x, float y)
{
    return rk_light_sample_at(light, RK_FALLOFF_NONE, RK_LIGHT_DOMAIN_AREA, rk_vec(9, 9, 9),
                              (rk_vec2){x, y});
}

/* --- Positions of samples -------------------------------------------------------------------- */

/* Lights are read by several threads at once. */
static void check_constant_light(void)
{
    const rk_light own = make_coloured(RK_LIGHT_PARALLELOGRAM);
    const rk_light *light = rk_read_only(&own, sizeof own, "light");
    const rk_vec3 point = {1, 2, 9}, normal = {0, 0, -1};
    for (int domain = RK_LIGHT_DOMAIN_AREA; domain <= RK_LIGHT_DOMAIN_SOLID_ANGLE; domain++)
        rk_light_sample_at(light, RK_FALLOFF_PHYSICAL, (rk_light_domain)domain, point,
                           (rk_vec2){0.5f, 0.5f});
    rk_light_solid_angle(light, point);
    rk_light_irradiance(light, point, normal);
    rk_read_only_free();
}

static void a_point_light_has_one_position_and_one_colour(void **state)
{
    (void)state;
    check_constant_light();
    rk_light light = rk_light_point(rk_vec(1, 2, 3), rk_vec(0.5f, 0.25f, 1));
    light.edge01 = light.edge02 = light.colours[1] = rk_vec(NAN, NAN, NAN);
    rk_light_sample sample = plain_sample(&light, 0.75f, 0.5f);
    check_vec3(sample.position, rk_vec(1, 2, 3), 0, "a point light has no edges; don't read them");
    check_vec3(sample.colour, rk_vec(0.5f, 0.25f, 1), 0, "its colour is corner 0's");
}

static void a_segment_runs_from_corner_0_to_corner_1(void **state)
{
    (void)state;
    rk_light light = make_coloured(RK_LIGHT_SEGMENT);
    light.edge02 = light.colours[2] = light.colours[3] = rk_vec(NAN, NAN, NAN);
    rk_light_sample sample = plain_sample(&light, 0.75f, 0.5f);
    rk_check(!isnan(rk_dot(sample.position, rk_vec(1, 1, 1))),
             "got a position of NaN: a segment's edge02 is not read");
    check_vec3_or(sample.position, rk_vec(2.5f, 2, 3), 0,
                  RK_VECTOR_MISTAKES({{2.5 - 9, 2 - 9, 3 - 9},
                                      "the position is relative to the point, as a direction is"}),
                  "position + x edge01; a segment has no y");
    rk_check(!isnan(rk_dot(sample.colour, rk_vec(1, 1, 1))),
             "got a colour of NaN: a segment's colours 2 and 3 are not read");
    check_vec3(sample.colour, rk_vec(0.75f, 0, 0), 0, "linear from corner 0's to corner 1's");
}

static void corners_have_their_own_colours(void **state)
{
    (void)state;
    rk_light light = make_coloured(RK_LIGHT_PARALLELOGRAM);
    for (int i = 0; i < 4; i++) {
        float x = (float)(i % 2), y = (float)(i / 2);
        rk_light_sample sample = plain_sample(&light, x, y);
        check_vec3(sample.position, rk_vec(1 + 2 * x, 2 + 4 * y, 3), 0,
                   "position + x edge01 + y edge02");
        const rk_vec3 other = light.colours[i == 1 ? 2 : i == 2 ? 1 : i];
        check_vec3_or(sample.colour, light.colours[i], 0,
                      RK_VECTOR_MISTAKES({{(double)other.x, (double)other.y, (double)other.z},
                                          "the colours of corners 1 and 2 are exchanged"}),
                      "colour 1 is at the end of edge01, 2 at the end of edge02, 3 opposite to 0");
    }
    for (int e = -60; e <= 60; e += 20)
        for (int kind = 0; kind < 3; kind++) {
            light = make_coloured((rk_light_kind)kind);
            float whole = ldexpf(1, e);
            for (int i = 0; i < 4; i++)
                light.colours[i] = rk_vec(whole, 3 * whole, 0.5f * whole);
            check_vec3(plain_sample(&light, 0.5f, 0.25f).colour, light.colours[0], 0,
                       "a colour is any positive number, far above 1, too, and far below");
        }
}

static void colours_are_bilinear_between_the_corners(void **state)
{
    (void)state;
    rk_light light = make_coloured(RK_LIGHT_PARALLELOGRAM);
    /* The weights of corners 1 to 3: x (1 - y), (1 - x) y, x y; exact in floats. */
    check_vec3(plain_sample(&light, 0.5f, 0.5f).colour, rk_vec(0.25f, 0.25f, 0.25f), 0,
               "in the middle all corners have the same weight");
    check_vec3(plain_sample(&light, 0.75f, 0.5f).colour, rk_vec(0.375f, 0.125f, 0.375f), 0,
               "x runs from corner 0 to 1, and from 2 to 3");
    check_vec3(plain_sample(&light, 0.25f, 0.75f).colour, rk_vec(0.0625f, 0.5625f, 0.1875f), 0,
               "y runs from corner 0 to 2, and from 1 to 3");
}

static void a_sample_is_a_position_and_not_a_direction(void **state)
{
    (void)state;
    const rk_vec3 by = {16, -32, 8};
    for (int falloff = 0; falloff < 2; falloff++)
        for (int domain = 0; domain < 2; domain++) {
            rk_light light = make_coloured(RK_LIGHT_PARALLELOGRAM), moved = light;
            check_vec3(plain_sample(&light, 0.25f, 0.75f).position, rk_vec(1.5f, 5, 3), 0,
                       "position + x edge01 + y edge02");
            moved.position = rk_add(light.position, by);
            rk_light_sample a =
                rk_light_sample_at(&light, (rk_light_falloff)falloff, (rk_light_domain)domain,
                                   rk_vec(0, 1, 0), (rk_vec2){0.25f, 0.75f});
            rk_light_sample b =
                rk_light_sample_at(&moved, (rk_light_falloff)falloff, (rk_light_domain)domain,
                                   rk_add(rk_vec(0, 1, 0), by), (rk_vec2){0.25f, 0.75f});
            /* Sums of small whole numbers and fractions round once, to 2^-24 of 32. */
            check_vec3(b.position, rk_add(a.position, by), 0x1p-18f,
                       "moving light and point together moves the sample with them");
            check_vec3(
                b.colour, a.colour, 1e-6f * rk_length(a.colour),
                "a sample's weight depends only on the light's position relative to the point");
            rk_light_sample far =
                rk_light_sample_at(&light, (rk_light_falloff)falloff, (rk_light_domain)domain,
                                   rk_vec(1e8f, -3e8f, 2e8f), (rk_vec2){0.25f, 0.75f});
            /* The light is a dot from there, so xi is the place on it. */
            check_vec3(far.position, rk_vec(1.5f, 5, 3), 0x1p-20f,
                       domain == RK_LIGHT_DOMAIN_SOLID_ANGLE
                           ? "from a far point, too, samples lie on the light: is a light below "
                             "smallest_solid_angle sampled over its area? Or is a position "
                             "point + difference, which rounds to the point's digits?"
                           : "from a far point, too, samples lie on the light: point + difference "
                             "rounds to the point's digits");
        }
}

static void without_falloff_neither_distance_nor_domain_matters(void **state)
{
    (void)state;
    rk_light light = make_coloured(RK_LIGHT_PARALLELOGRAM);
    for (uint32_t i = 0; i < 100; i++) {
        rk_vec2 xi = noise2(1, i);
        rk_light_sample got = rk_light_sample_at(&light, RK_FALLOFF_NONE, (rk_light_domain)(i % 2),
                                                 rk_scale(noise3(1, i), 100), xi);
        rk_light_sample want = plain_sample(&light, xi.x, xi.y);
        check_vec3(got.position, want.position, 0, "uniformly over the area, from every point");
        check_vec3(got.colour, want.colour, 0, "the light's own colour, at every distance");
        rk_check(got.colour.x > 0, "got a light without red");
        got = rk_light_sample_at(&light, RK_FALLOFF_NONE, (rk_light_domain)(i % 2), want.position,
                                 xi);
        check_vec3(got.position, want.position, 0, "from the light itself, too");
        check_vec3(got.colour, want.colour, 0,
                   "without falloff the light itself is lit as all else is");
    }
}

/* --- Weights of samples ---------------------------------------------------------------------- */

static float weight_at(const rk_light *light, rk_light_domain domain, rk_vec3 point, float x,
                       float y)
{
    return rk_light_sample_at(light, RK_FALLOFF_PHYSICAL, domain, point, (rk_vec2){x, y}).colour.x;
}

/* Members that a light's kind does not have: not a number, or a number that must not count. */
static const float unread[] = {NAN, 5, 0};
enum { UNREAD = sizeof unread / sizeof *unread };

static void a_point_light_falls_off_with_the_square_of_the_distance(void **state)
{
    (void)state;
    rk_light light = rk_light_point(rk_vec(1, 2, 2), rk_vec(4.5f, 0, 0));
    for (int i = 0; i < 2 * UNREAD; i++) {
        rk_light_domain domain = (rk_light_domain)(i % 2);
        light.edge01 = rk_vec(unread[i / 2], 0, 0);
        light.edge02 = light.colours[1] = light.colours[2] = light.colours[3] =
            rk_vec(0, unread[i / 2], 0);
        float weight = weight_at(&light, domain, rk_vec(0, 0, 0), 0.5f, 0.5f);
        rk_check_close(weight, 0.5, 1e-7,
                       domain == RK_LIGHT_DOMAIN_AREA
                           ? "intensity over r^2, 4.5 / 9; don't read a point light's edges"
                           : "over the solid angle as over the area, 4.5 / 9: a point light has no "
                             "edges, don't read them");
        rk_check_close(weight_at(&light, domain, rk_vec(-1, -2, -2), 0.5f, 0.5f), 0.125, 1e-7,
                       "twice as far, a quarter");
        rk_light_sample sample = rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, domain,
                                                    rk_vec(0, 0, 0), (rk_vec2){0.75f, 0.25f});
        check_vec3(sample.position, light.position, 0, "a point light has one position");
    }
    for (int e = -50; e <= 50; e++) { /* 1e-15 to 1e15 */
        light.position = rk_scale(rk_vec(1, 2, 2), ldexpf(1, e));
        double got = (double)weight_at(&light, RK_LIGHT_DOMAIN_AREA, rk_vec(0, 0, 0), 0.5f, 0.5f);
        rk_check_near(ldexp(got, 2 * e), 0.5, 1e-7,
                      "at the distance 3 x 2^%d: the weight times 2^%d; no distance is too small",
                      e, 2 * e);
    }
}

static void a_segment_is_foreshortened(void **state)
{
    (void)state;
    for (int i = 0; i < 2 * UNREAD; i++) {
        rk_light_domain domain = (rk_light_domain)(i % 2);
        rk_light light = make_light(RK_LIGHT_SEGMENT, rk_vec(0, 0, 0), rk_vec(2, 0, 0),
                                    rk_vec(0, unread[i / 2], 1));
        light.colours[2] = light.colours[3] = rk_vec(unread[i / 2], 0, 0);
        rk_check_near(weight_at(&light, domain, rk_vec(1, 0, 2), 0.5f, 0), 0.5, 1e-7,
                      "the domain is %s, perpendicular: length / r^2 = 2 / 4, in either",
                      domain == RK_LIGHT_DOMAIN_AREA ? "the area" : "the solid angle");
        /* 3 before the end and 4 aside: r = 5, sin' = 4 / 5. */
        rk_check_near_or(
            weight_at(&light, domain, rk_vec(-3, 4, 0), 0, 0.5f), 2 * 0.8 / 25, 1e-8,
            RK_MISTAKES({2 / 25., "the sine is missing: the whole length counts at any angle"},
                        {2 * 0.6 / 25, "the cosine stands in place of the sine"},
                        {0.8 / 25, "the length, 2, is missing"},
                        {2 * 0.8 / 5, "it is divided by r, not by r^2"}),
            "length 2 x sin' 0.8 / r^2 25, sin' of the angle between segment and direction; a "
            "segment has no edge02");
        rk_check_close(weight_at(&light, domain, rk_vec(-3, 0, 0), 0.5f, 0), 0, 0,
                       "in line with the point it looks like a dot, and gives nothing");
        rk_light_sample sample = rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, domain,
                                                    rk_vec(1, 0, 2), (rk_vec2){0.75f, 0.25f});
        check_vec3(sample.position, rk_vec(1.5f, 0, 0), 0,
                   "samples of a segment are uniform over its length, in either domain");
    }
}

static void a_parallelogram_is_foreshortened_and_two_sided(void **state)
{
    (void)state;
    rk_light light = make_parallelogram(rk_vec(0, 0, 0), rk_vec(2, 0, 0), rk_vec(1, 3, 0));
    for (float side = -1; side <= 1; side += 2) {
        rk_check_near_or(
            weight_at(&light, RK_LIGHT_DOMAIN_AREA, rk_vec(0, 0, 2 * side), 0, 0), 6.0 / 4, 1e-6,
            RK_MISTAKES({1.0 / 4, "the area, 6, is missing"},
                        {6.0 / 2, "it is divided by r, not by r^2"},
                        {-6.0 / 4, "the cosine keeps its sign: a light has two sides"}),
            "facing it from %s: area / r^2 = 6 / 4, on both sides", side > 0 ? "above" : "below");
        rk_check_near_or(
            weight_at(&light, RK_LIGHT_DOMAIN_AREA, rk_vec(4, 0, 3 * side), 0, 0), 6 * 0.6 / 25,
            1e-7,
            RK_MISTAKES({6 / 25., "the cosine at the light is missing"},
                        {0.6 / 25, "the area, 6, is missing"},
                        {6 * 0.8 / 25, "the sine stands in place of the cosine"},
                        {6 * 0.6 / 5, "it is divided by r, not by r^2"},
                        {-6 * 0.6 / 25, "the cosine keeps its sign: a light has two sides"}),
            "%s its plane: area 6 x |cos'| 0.6 / r^2 25", side > 0 ? "above" : "below");
        for (int e = 1; e <= 100; e++) { /* from beside the corner, nearer and nearer its plane */
            double h = ldexp(1, -e), r2 = 16 + h * h;
            rk_check_near(
                weight_at(&light, RK_LIGHT_DOMAIN_AREA, rk_vec(4, 0, (float)h * side), 0, 0) /
                    (6 * h / (r2 * sqrt(r2))),
                1, 0x1p-22,
                "4 beside a corner and 2^-%d above the light's plane: your weight over area cos' / "
                "r^2; a small cosine is not 0",
                -e);
        }
    }
}

static void points_on_the_light_get_nothing_and_no_nan(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++)
        for (int domain = 0; domain < 2; domain++) {
            rk_light light = make_coloured((rk_light_kind)kind);
            for (int i = 0; i < 4; i++)
                light.colours[i] = rk_vec(1, 1, 1);
            float got = weight_at(&light, (rk_light_domain)domain, light.position, 0, 0);
            rk_check_close(got, 0, 0, "at r = 0 there is no direction: weight 0");
            rk_vec3 middle = plain_sample(&light, 0.5f, 0.5f).position;
            got = weight_at(&light, (rk_light_domain)domain, middle, 0.5f, 0.5f);
            rk_check_close(got, 0, 0, "at r = 0, in the light's middle, too");
            if (kind == RK_LIGHT_PARALLELOGRAM) {
                for (uint32_t i = 0; i < 125; i++) { /* in its plane, on the light or beside it */
                    rk_vec2 at = {4 * noise(23, i, 0) - 1, 0.5f};
                    if (i % 2) /* on the diagonal, where both halves meet */
                        at.y = 1 - at.x;
                    if (i >= 100) /* corners, edges, and beyond them */
                        at = (rk_vec2){(float)(i % 5) / 2 - 0.5f, (float)(i / 5 % 5) / 2 - 0.5f};
                    rk_vec3 on = rk_vec(1 + 2 * at.x, 2 + 4 * at.y, 3);
                    rk_vec2 xi = noise2(24, i);
                    got = weight_at(&light, (rk_light_domain)domain, on, xi.x, xi.y);
                    rk_check(got == 0,
                             "a point in the light's plane at x = %g, y = %g of the light: got the "
                             "weight %g, want 0: cos' = 0",
                             (double)at.x, (double)at.y, (double)got);
                    rk_check_close(rk_light_solid_angle(&light, on), 0, 0,
                                   "seen edge-on, or from the light itself, it subtends no angle");
                }
            }
            /* The control: beside the light it is lit. */
            got = weight_at(&light, (rk_light_domain)domain, rk_vec(0, 2, 2.5f), 0.5f, 0.5f);
            rk_check(got > 0 && isfinite(got),
                     "got the weight %g from a point beside the light, want a positive one%s",
                     (double)got,
                     domain ? ": samples over the solid angle need a place on the light, too" : "");
        }
}

/* Lambert's cosine between the surface and the sample. */
static double cos_to(const configuration *c, rk_vec3 position)
{
    rk_dvec3 l = rk_dmadd(rk_widen(position), rk_widen(c->point), -1);
    double along = rk_ddot(rk_widen(c->normal), l);
    return along > 0 ? along / rk_dlength(l) : 0;
}

/* --- The closed form ------------------------------------------------------------------------- */

static void a_square_above_the_point_has_the_textbook_form_factor(void **state)
{
    (void)state;
    /* A rectangle a by b, parallel to the surface at distance c, with one corner above the point
     * (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3). */
    const double a = 2, b = 0.75, c = 0.5;
    double x = a / c, y = b / c, along_x = sqrt(1 + x * x), along_y = sqrt(1 + y * y);
    double want = x / along_x * atan(y / along_x) + y / along_y * atan(x / along_y);
    rk_light light =
        make_parallelogram(rk_vec(1, 1, (float)c), rk_vec((float)a, 0, 0), rk_vec(0, (float)b, 0));
    double got = (double)rk_light_irradiance(&light, rk_vec(1, 1, 0), rk_vec(0, 0, 1));
    rk_check_close(got, want / 2, 1e-7, "pi times the form factor; all of it is above the horizon");
}

/* A wall from the horizon up is what is seen of a wall through the horizon. */
static void check_wall_on_the_horizon(void)
{
    const rk_vec3 o = {0, 0, 0}, up = {0, 0, 1};
    rk_light standing = make_parallelogram(rk_vec(1, -1, 0), rk_vec(0, 2, 0), rk_vec(0, 0, 1));
    rk_light through = make_parallelogram(rk_vec(1, -1, -1), rk_vec(0, 2, 0), rk_vec(0, 0, 2));
    rk_check_near(rk_light_irradiance(&standing, o, up), rk_light_irradiance(&through, o, up), 1e-6,
                  "a light that stands on the horizon, against one that goes on below it: two "
                  "corners are exactly on the horizon, n . p = 0, and clipping keeps them");
}

static void a_light_all_around_gives_pi_and_half_of_it_half(void **state)
{
    (void)state;
    rk_light sky =
        make_parallelogram(rk_vec(-1e6f, -1e6f, 1), rk_vec(2e6f, 0, 0), rk_vec(0, 2e6f, 0));
    /* The missing part near the horizon is less than 1e-6 of the whole. */
    rk_check_close(rk_light_irradiance(&sky, rk_vec(0, 0, 0), rk_vec(0, 0, 1)), pi, 1e-5,
                   "a whole hemisphere of radiance 1 gives pi");
    rk_check_close(rk_light_irradiance(&sky, rk_vec(0, 0, 0), rk_vec(1, 0, 0)), pi / 2, 1e-5,
                   "for a wall, the half below its horizon is cut off");
    rk_check_close(rk_light_irradiance(&sky, rk_vec(0, 0, 0), rk_vec(0, 0, -1)), 0, 0,
                   "behind the surface there is no light");
    check_wall_on_the_horizon();
    for (int i = 0; i < 25; i++) { /* on corners, edges, inside and outside */
        rk_vec3 on = rk_vec(1e6f * (float)(i % 5 - 2), 1e6f * (float)(i / 5 - 2), 1);
        for (int k = 0; k < 3; k++)
            rk_check_close(
                rk_light_irradiance(&sky, on,
                                    rk_vec(k == 1, k == 2 ? 0.6f : 0, k == 2 ? 0.8f : !k)),
                0, 0, "on the light itself, and in its plane, there is none: r = 0, or cos' = 0");
    }
}

/* The cosine over the squared distance, of a light that has a single point. */
static void the_closed_form_of_a_point_is_the_cosine_over_the_squared_distance(void **state)
{
    (void)state;
    for (int i = 0; i < UNREAD; i++) {
        rk_light light = rk_light_point(rk_vec(1, 2, 2), rk_vec(unread[i], unread[i], 0));
        light.edge01 = rk_vec(unread[i], 0, 0);
        light.edge02 = rk_vec(0, unread[i], 0);
        rk_check_close(rk_light_irradiance(&light, rk_vec(0, 0, 0), rk_vec(0, 0, 1)), 2 / 27.0,
                       1e-8, "cos / r^2 = (2 / 3) / 9, for a colour of 1 and without edges");
        rk_check_close(rk_light_irradiance(&light, rk_vec(0, 0, 0), rk_vec(0, 0.6f, -0.8f)), 0, 0,
                       "below the horizon it gives nothing");
        rk_check_close(rk_light_irradiance(&light, rk_vec(0, 2, 2), rk_vec(0, 0, 1)), 0, 0,
                       "on the horizon it gives nothing");
        rk_check_close(rk_light_irradiance(&light, rk_vec(1, 2, 2), rk_vec(0, 0, 1)), 0, 0,
                       "on the light itself, r = 0, it is 0");
        for (int e = -50; e <= 50; e++) { /* 1e-15 to 1e15 */
            light.position = rk_scale(rk_vec(1, 2, 2), ldexpf(1, e));
            double got = (double)rk_light_irradiance(&light, rk_vec(0, 0, 0), rk_vec(0, 0, 1));
            rk_check_near(ldexp(got, 2 * e), 2 / 27.0, 1e-8,
                          "a point light at the distance 3 x 2^%d: your rk_light_irradiance times "
                          "2^%d; r^3 leaves the range of a float",
                          e, 2 * e);
        }
        light.position = rk_vec(1, 2, 2);
    }
}

/* The integrand at x and y of the light. */
static double irradiance_from(const configuration *c, double x, double y)
{
    rk_dvec3 edge01 = rk_widen(c->edge01), edge02 = rk_widen(c->edge02);
    rk_dvec3 d = rk_dmadd(rk_dmadd(rk_widen(c->position), rk_widen(c->point), -1), edge01, x);
    d = c->kind == RK_LIGHT_PARALLELOGRAM ? rk_dmadd(d, edge02, y) : d;
    double square = rk_ddot(d, d), cos_r = rk_ddot(rk_widen(c->normal), d);
    if (!(cos_r > 0))
        return 0;
    double seen = c->kind == RK_LIGHT_PARALLELOGRAM ? fabs(rk_ddot(d, rk_dcross(edge01, edge02)))
                                                    : rk_dlength(rk_dcross(d, edge01));
    return seen * cos_r / (square * square);
}

/* The light, with all lengths times 2^e. */
static rk_light scaled_light(const configuration *c, int e)
{
    float unit = ldexpf(1, e);
    return make_light(c->kind, rk_scale(c->position, unit), rk_scale(c->edge01, unit),
                      rk_scale(c->edge02, unit));
}

/* A sample for the point, with all lengths times 2^e. */
static rk_light_sample sample_of_scaled(const configuration *c, rk_light_domain domain, int e,
                                        rk_vec2 xi)
{
    rk_light light = scaled_light(c, e);
    return rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, domain, rk_scale(c->point, ldexpf(1, e)),
                              xi);
}

static void each_sample_is_the_integrand_at_its_place(void **state)
{
    (void)state;
    int lit = 0;
    for (size_t k = 0; k < CONFIGURATIONS; k++)
        for (uint32_t i = 0; i < 100; i++) {
            const configuration *c = &configurations[k];
            if (c->kind == RK_LIGHT_POINT)
                continue;
            rk_light light = light_of(c);
            rk_vec2 xi = noise2(40 + (uint32_t)k, i);
            rk_light_sample sample =
                rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_AREA, c->point, xi);
            double got = (double)sample.colour.x * cos_to(c, sample.position);
            double want = irradiance_from(c, (double)xi.x, (double)xi.y);
            lit += want > 0;
            /* The weight is rounded to float, and the position to 2^-24 of its coordinates, which
             * turns the direction from the point by so much over the distance. */
            double r = rk_dlength(rk_dmadd(rk_widen(sample.position), rk_widen(c->point), -1));
            double turned = 0x1p-22 * (double)rk_length(sample.position) / r;
            /* A tolerance is positive, whatever the sign of a wrong weight. */
            float weight = fabsf(sample.colour.x);
            rk_check(isfinite(weight), "%s, x = %g, y = %g: got the weight %g, want a finite one",
                     c->name, (double)xi.x, (double)xi.y, (double)sample.colour.x);
            rk_check_near(
                got, want, (double)weight * (0x1p-22 + turned),
                "%s, x = %g, y = %g: the sample's weight times the cosine at the surface, against "
                "area cos cos' / r^2 (of a segment: length cos sin' / r^2)",
                c->name, (double)xi.x, (double)xi.y);
            int e = i % 2 ? -50 : 50; /* 1e-15 and 1e15; a length, and an area, have a unit */
            rk_light_sample scaled = sample_of_scaled(c, RK_LIGHT_DOMAIN_AREA, e, xi);
            int power = c->kind == RK_LIGHT_PARALLELOGRAM ? 0 : e;
            rk_check_near(ldexp((double)scaled.colour.x, power), weight, 0x1p-22f * weight,
                          "%s, x = %g, y = %g, with all lengths times 2^%d: the sample's weight, "
                          "times 2^%d; no constant has the unit of a length",
                          c->name, (double)xi.x, (double)xi.y, e, power);
            rk_light coloured = light;
            memcpy(coloured.colours, make_coloured(c->kind).colours, sizeof coloured.colours);
            rk_vec3 own = plain_sample(&coloured, xi.x, xi.y).colour;
            check_vec3(
                rk_light_sample_at(&coloured, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_AREA, c->point,
                                   xi)
                    .colour,
                rk_scale(own, sample.colour.x), 0x1p-22f * weight,
                "the light's colour at the sample's place, each channel times the same weight");
        }
    rk_check(lit > 2000, "only %d samples are lit, want more than 2000", lit);
}

static void near_and_far_lights_have_the_textbook_form_factor_too(void **state)
{
    (void)state;
    /* A rectangle with the point below its interior is four with a common corner. */
    const double x[] = {0.25, 0.75}, y[] = {0.5, 0.125};
    for (float c = 1e-30f; c < 1e7f; c *= 10) {
        double want = 0;
        for (int i = 0; i < 4; i++) {
            double a = x[i % 2] / (double)c, b = y[i / 2] / (double)c;
            double along_a = sqrt(1 + a * a), along_b = sqrt(1 + b * b);
            want += (a / along_a * atan(b / along_a) + b / along_b * atan(a / along_b)) / 2;
        }
        rk_light light =
            make_parallelogram(rk_vec(-0.25f, -0.5f, c), rk_vec(1, 0, 0), rk_vec(0, 0.625f, 0));
        double got = (double)rk_light_irradiance(&light, rk_vec(0, 0, 0), rk_vec(0, 0, 1));
        /* A few roundings to float, and 2^-50 over the angle. */
        rk_check_close(
            got / want, 1, 3e-7 + 0x1p-50 * (double)c,
            "at every distance: angles by atan2, and no constant with the unit of a length");
    }
    /* From aside, where the cross product of two corners cancels and that of a corner and an edge
     * doesn't. So far away it is the middle's A cos cos' / r^2, but for a part of 1 / r^2. */
    for (float r = 1e4f; r < 1e8f; r *= 10) {
        configuration c = {"",
                           RK_LIGHT_PARALLELOGRAM,
                           {0.48f * r, 0.6f * r, 0.64f * r},
                           {1, 0.5f, 0.25f},
                           {-0.5f, 1, 0.75f},
                           {0.1f, 0.2f, 0.3f},
                           {0.6f, 0, 0.8f}};
        rk_light light = light_of(&c);
        double want = irradiance_from(&c, 0.5, 0.5);
        double got = (double)rk_light_irradiance(&light, c.point, c.normal);
        rk_check_near(
            got / want, 1, 3e-7 + 16 * 0x1p-50 * (double)r,
            "a light from aside at distance %g: your irradiance over area cos cos' / r^2; a x b "
            "loses digits where a and b are close together",
            (double)r);
    }
}

/* Integrals by subdivision: Simpson's rule on a cell, in both directions, compared with the sum
 * over its four quarters, until they agree. */
typedef struct cell {
    double x, y, side;
    double f[3][3]; /* the integrand at its corners and between them; rows have the same y */
} cell;

/* The whole light. */
static cell whole_cell(const configuration *c)
{
    cell whole = {0, 0, 1, {{0}}};
    for (int i = 0; i < 9; i++)
        whole.f[i / 3][i % 3] = irradiance_from(c, i % 3 / 2.0, i / 3 / 2.0);
    return whole;
}

/* Divides a cell into quarters, at 16 new points. */
static void divide(const configuration *c, const cell *whole, cell quarters[4])
{
    double f[5][5], half = whole->side / 2;
    for (int i = 0; i < 25; i++) {
        int x = i % 5, y = i / 5;
        if (x % 2 == 0 && y % 2 == 0)
            f[y][x] = whole->f[y / 2][x / 2];
        else if (c->kind == RK_LIGHT_SEGMENT && y > 0) /* does not depend on y */
            f[y][x] = f[0][x];
        else
            f[y][x] = irradiance_from(c, whole->x + half * x / 2, whole->y + half * y / 2);
    }
    for (int i = 0; i < 4; i++) {
        quarters[i] = (cell){whole->x + half * (i % 2), whole->y + half * (i / 2), half, {{0}}};
        for (int k = 0; k < 9; k++)
            quarters[i].f[k / 3][k % 3] = f[i / 2 * 2 + k / 3][i % 2 * 2 + k % 3];
    }
}

static double simpson(const cell *at)
{
    const double(*f)[3] = at->f;
    double corners = f[0][0] + f[0][2] + f[2][0] + f[2][2],
           between = f[0][1] + f[1][0] + f[1][2] + f[2][1];
    return (corners + 4 * between + 16 * f[1][1]) * at->side * at->side / 36;
}

/* A segment does not depend on y, so of its quarters two are like the other two. The first levels
 * are always divided, because nine points may miss a peak between them. */
static double integral(const configuration *c, const cell *at, double tolerance, int depth)
{
    int different = c->kind == RK_LIGHT_SEGMENT ? 2 : 4;
    double sum = 0;
    cell quarters[4];
    divide(c, at, quarters);
    for (int i = 0; i < different; i++)
        sum += simpson(&quarters[i]) * (4 / different);
    /* Where the integrand is smooth, the error of the quarters' sum is a fifteenth of the change.
     */
    double change = sum - simpson(at);
    if (depth > 24 || (depth > 2 && fabs(change) <= 8 * tolerance))
        return sum + change / 15;
    sum = 0;
    for (int i = 0; i < different; i++)
        sum += integral(c, &quarters[i], tolerance / 2, depth + 1) * (4 / different);
    return sum;
}

static double whole_integral(const configuration *c, double tolerance)
{
    cell whole = whole_cell(c);
    return integral(c, &whole, tolerance, 0);
}

static configuration random_configuration(uint32_t i, rk_light_kind kind)
{
    return (configuration){"random",
                           kind,
                           rk_scale(noise3(10, i), 1.5f),
                           noise3(11, i),
                           noise3(12, i),
                           rk_scale(noise3(13, i), 0.5f),
                           rk_normalize(noise3(14, i))};
}

static void the_closed_form_equals_quadrature(void **state)
{
    (void)state;
    int clipped = 0;
    for (uint32_t i = 0; i < 300; i++) {
        configuration c =
            random_configuration(i, i % 3 ? RK_LIGHT_PARALLELOGRAM : RK_LIGHT_SEGMENT);
        rk_light light = light_of(&c);
        for (int k = 0; k < 4; k++) /* for colours of 1, whatever the light's are */
            light.colours[k] = rk_vec(NAN, NAN, NAN);
        if (c.kind == RK_LIGHT_SEGMENT)
            light.edge02 = rk_vec(NAN, NAN, NAN);
        rk_dvec3 n = rk_widen(c.normal);
        rk_dvec3 corner = rk_dmadd(rk_widen(c.position), rk_widen(c.point), -1);
        double above = rk_ddot(n, corner),
               far = rk_ddot(n, rk_dmadd(corner, rk_widen(c.edge01), 1));
        clipped += (above > 0) != (far > 0);
        double got = (double)rk_light_irradiance(&light, c.point, c.normal);
        double want = whole_integral(&c, 1e-7);
        char hint[160];
        snprintf(hint, sizeof hint,
                 "random light %u, a %s%s: integrate over the edges of the part above the horizon",
                 i, i % 3 ? "parallelogram" : "segment",
                 (above > 0) != (far > 0) ? " that crosses the horizon" : "");
        /* Tolerances of the cells add up; measured, the integral is right to 2e-6. */
        rk_check_close(got, want, 1e-5 * (1 + want), hint);
    }
    rk_check(clipped > 20, "only %d of the lights cross the horizon", clipped);
}

static void the_closed_form_equals_quadrature_at_the_limits(void **state)
{
    (void)state;
    int lit = 0;
    for (size_t k = 0; k < CONFIGURATIONS; k++) {
        const configuration *c = &configurations[k];
        rk_light light = light_of(c);
        double got = (double)rk_light_irradiance(&light, c->point, c->normal);
        if (c->kind == RK_LIGHT_POINT || !(got > 0))
            continue;
        lit++;
        /* The closed form is rounded to float, to 6e-8 of itself; measured, the integral is right
         * to 2e-8 of itself. */
        double want = whole_integral(c, 1e-7 * got);
        rk_check_near(
            got, want, 3e-7 * want,
            "%s: your rk_light_irradiance against its integral: positions relative to the "
            "point in double",
            c->name);
        for (int e = -50; e <= 50; e += 100) {
            rk_light scaled = scaled_light(c, e);
            float there = rk_light_irradiance(&scaled, rk_scale(c->point, ldexpf(1, e)), c->normal);
            int power = c->kind == RK_LIGHT_PARALLELOGRAM ? 0 : e;
            rk_check_near(ldexp((double)there, power), got, 0x1p-22 * got,
                          "%s, with all lengths times 2^%d: your rk_light_irradiance times 2^%d; "
                          "no constant has the unit of a length",
                          c->name, e, power);
        }
    }
    rk_check(lit > 20, "only %d configurations are lit, want more than 20", lit);
}

static void two_parts_of_a_light_add_up_to_the_whole(void **state)
{
    (void)state;
    int lit = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        configuration c = random_configuration(i, RK_LIGHT_PARALLELOGRAM);
        rk_light whole = light_of(&c), left = whole, right = whole;
        left.edge01 = right.edge01 = rk_scale(whole.edge01, 0.5f);
        right.position = rk_add(whole.position, left.edge01);
        double want = (double)rk_light_irradiance(&whole, c.point, c.normal);
        double got = (double)rk_light_irradiance(&left, c.point, c.normal) +
                     (double)rk_light_irradiance(&right, c.point, c.normal);
        /* The right half's corner is rounded to 2^-24 of its coordinates, at distances of 0.05 and
         * more: measured, 1e-6. */
        rk_check_close(got, want, 1e-5 * (1 + want),
                       "edges inside the light cancel if each has the right sign");
        lit += want > 0;
    }
    rk_check(lit > 500, "got irradiance from %d of 1000 lights, want more than half", lit);
}

/* --- Uniform over directions ----------------------------------------------------------------- */

static void the_side_of_a_cube_fills_a_sixth_of_the_sphere(void **state)
{
    (void)state;
    rk_light side = make_parallelogram(rk_vec(-1, -1, 1), rk_vec(2, 0, 0), rk_vec(0, 2, 0));
    rk_check_close(rk_light_solid_angle(&side, rk_vec(0, 0, 0)), 4 * pi / 6, 1e-12,
                   "six sides around the middle of a cube fill the sphere, 4 pi");
    side.position.z = 1e-6f;
    /* At distance 1, an edge is 1e-6 above the horizon, all around. */
    rk_check_close(rk_light_solid_angle(&side, rk_vec(0, 0, 0)), 2 * pi, 1e-5,
                   "a light that nearly touches the point fills half of the sphere");
    rk_check_close(rk_light_solid_angle(&side, rk_vec(-0.5f, -0.25f, 0)), 2 * pi, 1e-5,
                   "wherever they touch: a triangle of more than pi needs atan2");
    rk_check_close(rk_light_solid_angle(&side, rk_vec(5, 0, 1e-6f)), 0, 1e-12,
                   "edge-on it fills nothing");
    for (int e = 0; e <= 44; e++)
        for (int facing = -1; facing <= 1; facing += 2) {
            side.position.z = (float)facing * ldexpf(1, -e);
            /* Four rectangles with a common corner opposite to the point. */
            double h = ldexp(1, -e), want = 0;
            for (int i = 0; i < 4; i++) {
                double a = i % 2 ? 0.5 : 1.5, b = i / 2 ? 0.75 : 1.25;
                want += atan2(a * b, h * sqrt(a * a + b * b + h * h));
            }
            rk_check_near(rk_light_solid_angle(&side, rk_vec(0.5f, -0.25f, 0)), want,
                          1e-12 + 0x1p-50 * 2 / h * want,
                          "a square of side 2, aside of its middle at the distance 2^-%d, %s it", e,
                          facing < 0 ? "above" : "below");
        }
}

static void small_solid_angles_are_accurate_too(void **state)
{
    (void)state;
    for (float r = 1e7f; r < 1e14f; r *= 10)
        for (uint32_t i = 0; i < 20; i++) {
            rk_vec3 edge01 = noise3(15, i), edge02 = noise3(16, i);
            rk_vec3 towards = rk_normalize(rk_cross(edge01, edge02)); /* not edge-on */
            towards = rk_normalize(rk_madd(towards, noise3(17, i), 0.5f));
            rk_light light = make_parallelogram(rk_scale(towards, r), edge01, edge02);
            configuration c = {
                "", RK_LIGHT_PARALLELOGRAM, light.position, edge01, edge02, {0, 0, 0}, {0, 0, 0}};
            rk_dvec3 middle = rk_dmadd(rk_dmadd(rk_widen(c.position), rk_widen(edge01), 0.5),
                                       rk_widen(edge02), 0.5);
            double distance = rk_dlength(middle);
            double seen = fabs(rk_ddot(middle, rk_dcross(rk_widen(edge01), rk_widen(edge02))));
            double want = seen / (distance * distance * distance);
            /* So far away it is the middle's A cos' / r^2, but for a part of 1 / r^2 <= 1e-14; and
             * some ten roundings, each 2^-53, of products that do not cancel. */
            rk_check_near(rk_light_solid_angle(&light, c.point) / want, 1, 1e-12,
                          "light %u, at distance %g: your solid angle over area cos' / r^2; the "
                          "product of three corners cancels, that of a corner and two edges does "
                          "not",
                          i, (double)r);
        }
    for (size_t k = 0; k < CONFIGURATIONS; k++) {
        const configuration *c = &configurations[k];
        rk_light light = light_of(c);
        if (c->kind != RK_LIGHT_PARALLELOGRAM)
            continue;
        double want = rk_light_solid_angle(&light, c->point);
        for (int e = -100; e <= 100; e += 10) {
            rk_light scaled = scaled_light(c, e);
            rk_check_near(rk_light_solid_angle(&scaled, rk_scale(c->point, ldexpf(1, e))), want,
                          1e-12 * want,
                          "%s, with all lengths times 2^%d: the solid angle has no unit, so "
                          "nothing is small by itself",
                          c->name, e);
        }
    }
}

static void solid_angle_samples_all_weigh_the_same(void **state)
{
    (void)state;
    rk_light light = make_parallelogram(rk_vec(-1, -1, 1), rk_vec(2, 0, 0), rk_vec(0, 2, 0));
    for (uint32_t i = 0; i < 100; i++) {
        rk_vec2 xi = noise2(20, i);
        rk_check_close(weight_at(&light, RK_LIGHT_DOMAIN_SOLID_ANGLE, rk_vec(0, 0, 0), xi.x, xi.y),
                       4 * pi / 6, 1e-6,
                       "cos' / r^2 is in their density, so the weight is the solid angle");
    }
    int tried = 0;
    for (size_t k = 0; k < CONFIGURATIONS; k++) {
        const configuration *c = &configurations[k];
        rk_light whole = light_of(c);
        double want = rk_light_solid_angle(&whole, c->point);
        if (c->kind != RK_LIGHT_PARALLELOGRAM || want < 1e-7)
            continue; /* so small a light is sampled over its area, which is the same */
        tried++;
        for (uint32_t i = 0; i < 64; i++) {
            int e = (int)(i % 3) * 50 - 50;
            rk_light_sample sample =
                sample_of_scaled(c, RK_LIGHT_DOMAIN_SOLID_ANGLE, e, noise2(25, i));
            rk_check_near(sample.colour.x, want, 0x1p-22 * want,
                          "%s, with all lengths times 2^%d: the weight of a sample over the solid "
                          "angle, which is that angle",
                          c->name, e);
        }
    }
    rk_check(tried >= 15, "only %d lights were tried, want 15: is the solid angle right?", tried);
    for (int r = 1; r <= 4096; r *= 2) { /* down to 3e-7 */
        light.position = rk_vec((float)r / 2, 0, (float)r / 2);
        for (uint32_t i = 0; i < 16; i++) {
            rk_vec2 xi = noise2(26, i);
            double want = rk_light_solid_angle(&light, rk_vec(0, 0, 0));
            rk_check_near(
                weight_at(&light, RK_LIGHT_DOMAIN_SOLID_ANGLE, rk_vec(0, 0, 0), xi.x, xi.y), want,
                0x1p-22 * want,
                "a square of side 2 at the distance %d: the weight of a sample over the solid "
                "angle, which is that angle",
                r);
        }
    }
}

/* The position's x and y on the light, by least squares. */
static rk_vec2 find_on(const rk_light *light, rk_vec3 position)
{
    rk_dvec3 a = rk_widen(light->edge01), b = rk_widen(light->edge02);
    rk_dvec3 d = rk_dmadd(rk_widen(position), rk_widen(light->position), -1);
    double aa = rk_ddot(a, a), ab = rk_ddot(a, b), bb = rk_ddot(b, b);
    double da = rk_ddot(d, a), db = rk_ddot(d, b), determinant = aa * bb - ab * ab;
    return (rk_vec2){(float)((da * bb - db * ab) / determinant),
                     (float)((db * aa - da * ab) / determinant)};
}

static void solid_angle_samples_lie_on_the_light_and_have_its_colour(void **state)
{
    (void)state;
    uint32_t beyond_the_middle = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        configuration c = random_configuration(i % 100, RK_LIGHT_PARALLELOGRAM);
        rk_light light = light_of(&c);
        if (i / 100 % 2) /* far away: around the smallest solid angle, at 1e4 and beyond */
            c.point = rk_scale(c.normal, 1e4f * (1 + 9 * noise(22, i, 0)));
        light.colours[0] = light.colours[3] = rk_vec(1, 0, 0);
        light.colours[1] = rk_vec(1, 1, 0), light.colours[2] = rk_vec(1, 0, 1);
        rk_vec2 xi = noise2(21, i);
        if (i % 100 < 50) { /* to the ends of the unit square */
            xi.x = i % 3 == 0 ? 0 : i % 3 == 1 ? 0x0.ffffffp0f : xi.x;
            xi.y = i % 7 == 0 ? 0 : i % 7 == 1 ? 0x0.ffffffp0f : xi.y;
        }
        rk_light_sample sample = rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL,
                                                    RK_LIGHT_DOMAIN_SOLID_ANGLE, c.point, xi);
        rk_vec2 at = find_on(&light, sample.position);
        /* Random edges may be nearly parallel, which magnifies the rounding of positions. */
        rk_check(at.x > -1e-4f && at.x < 1.0001f && at.y > -1e-4f && at.y < 1.0001f,
                 "sample %u: got x = %g, y = %g, want both in [0, 1]: samples lie on the light", i,
                 (double)at.x, (double)at.y);
        rk_vec3 got = rk_scale(sample.colour, 1 / sample.colour.x);
        check_vec3(got, rk_vec(1, at.x * (1 - at.y), (1 - at.x) * at.y), 1e-3f,
                   "the colour is that at the position, not at xi");
        beyond_the_middle += at.x > 0.5f && at.y > 0.5f;
    }
    rk_check(beyond_the_middle > 1000, "only %u of 20000 samples lie in the quarter at corner 3",
             beyond_the_middle);
}

/* Chi-squared: samples in each of 8 x 8 cells of the light, against the cells' solid angles. */
static void check_uniform_over_directions(const rk_light *light, rk_vec3 point, uint32_t seed)
{
    enum { SIDE = 8, SAMPLES = 32000 };
    uint32_t counts[SIDE][SIDE] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        rk_light_sample sample = rk_light_sample_at(
            light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_SOLID_ANGLE, point, noise2(seed, i));
        rk_vec2 at = find_on(light, sample.position);
        int x = (int)(fminf(fmaxf(at.x, 0), 0.999f) * SIDE);
        counts[(int)(fminf(fmaxf(at.y, 0), 0.999f) * SIDE)][x]++;
    }
    double chi2 = 0, whole = rk_light_solid_angle(light, point), sum = 0;
    double got_half[2] = {0},
           want_half[2] = {0}; /* of the cells off the diagonal between the halves */
    for (int i = 0; i < SIDE * SIDE; i++) {
        rk_light part = *light;
        part.edge01 = rk_scale(light->edge01, 1.0f / SIDE);
        part.edge02 = rk_scale(light->edge02, 1.0f / SIDE);
        part.position = rk_madd(rk_madd(light->position, part.edge01, (float)(i % SIDE)),
                                part.edge02, (float)(i / SIDE));
        double angle = rk_light_solid_angle(&part, point), want = SAMPLES * angle / whole;
        double got = counts[i / SIDE][i % SIDE];
        sum += angle;
        chi2 += (got - want) * (got - want) / want;
        int half = i % SIDE + i / SIDE >= SIDE;
        if (i % SIDE + i / SIDE != SIDE - 1)
            got_half[half] += got, want_half[half] += want;
    }
    rk_check_close(sum / whole, 1, 1e-5, "the cells' solid angles add up to the light's");
    /* 63 degrees of freedom: mean 63, standard deviation sqrt(126) = 11.2; five of them above. */
    rk_check(
        chi2 <= 63 + 5 * 11.2,
        "chi squared: got %.1f, want 119 at most for 64 cells: directions are not uniform. In the "
        "triangle at corner 0 are %.0f samples, want about %.0f; in that at corner 3 %.0f, want "
        "%.0f",
        chi2, got_half[0], want_half[0], got_half[1], want_half[1]);
}

static void solid_angle_samples_are_uniform_over_directions(void **state)
{
    (void)state;
    rk_light light =
        make_parallelogram(rk_vec(-1, -1, 0), rk_vec(2, 0.5f, 0), rk_vec(0.5f, 2, 0.5f));
    check_uniform_over_directions(&light, rk_vec(0, 0, 1), 30);
    check_uniform_over_directions(&light, rk_vec(0.25f, -0.5f, -0.5f), 31);
    check_uniform_over_directions(&light, rk_vec(4, 1, -1), 32);
    check_uniform_over_directions(&light, rk_vec(50, 20, 80), 33);
}

/* --- The mean of the samples is the irradiance ----------------------------------------------- */

/* Sets of samples, each of which is drawn on its own: the means of the sets tell the standard error
 * of all, whatever the sampler. In a low-discrepancy set it is a tenth of a stratified set's, and a
 * hundredth of that of independent samples, so these sets find what the others find, and more. */
enum { SET = 1024, SETS = 32, SETS_UNIFORM = 96 };

/* Drawn once for all configurations: this does not test the sampler. */
static rk_vec2 drawn[SETS_UNIFORM * SET];

static void draw(rk_sampler_kind kind, uint32_t sets, uint32_t samples)
{
    const rk_sampler sampler = {kind, 4, samples, 0};
    for (uint32_t set = 0; set < sets; set++)
        rk_sample_2d_run(&sampler, set, 0, samples, 2, &drawn[set * samples]);
}

/* At a small distance h right above the light, nearly all irradiance E comes from about pi h^2 of
 * its area A. If hardly any sample falls there, their variance cannot be estimated from them; but
 * f <= A / h^2 bounds it by E A / h^2. Otherwise 0. */
static double variance_bound(const configuration *c, double irradiance, uint32_t samples)
{
    rk_light light = light_of(c);
    rk_dvec3 normal = rk_dcross(rk_widen(c->edge01), rk_widen(c->edge02));
    double area = rk_dlength(normal);
    rk_vec2 below = find_on(&light, c->point);
    if (!(area > 0) || below.x < 0 || below.x > 1 || below.y < 0 || below.y > 1)
        return 0;
    rk_dvec3 corner = rk_dmadd(rk_widen(c->position), rk_widen(c->point), -1);
    double height = rk_ddot(normal, corner) / area,
           expected = samples * pi * height * height / area;
    return expected > 0 && expected < 1000 ? irradiance * area / (height * height) : 0;
}

typedef struct estimate {
    double mean, error; /* the mean's standard error */
} estimate;

/* Over one set. The cosines are cos_to's, in a loop of their own so that compilers vectorize it. */
static double sum_of_weights_times_cosines(const configuration *c, const rk_light *light,
                                           rk_light_domain domain, const rk_vec2 *xi)
{
    double weights[SET], along[SET], squares[SET], sum = 0;
    const rk_dvec3 point = rk_widen(c->point), normal = rk_widen(c->normal);
    for (int i = 0; i < SET; i++) {
        rk_light_sample sample =
            rk_light_sample_at(light, RK_FALLOFF_PHYSICAL, domain, c->point, xi[i]);
        rk_dvec3 l = rk_dmadd(rk_widen(sample.position), point, -1);
        weights[i] = (double)sample.colour.x;
        along[i] = rk_ddot(normal, l), squares[i] = rk_ddot(l, l);
    }
    for (int i = 0; i < SET; i++) {
        double cosine = along[i] / sqrt(squares[i]);
        weights[i] *= along[i] > 0 ? cosine : 0;
    }
    for (int i = 0; i < SET; i++)
        sum += weights[i];
    return sum;
}

static estimate estimate_irradiance(const configuration *c, rk_light_domain domain, uint32_t sets)
{
    rk_light light = light_of(c);
    double sum = 0, squares = 0;
    for (uint32_t set = 0; set < sets; set++) {
        double part = sum_of_weights_times_cosines(c, &light, domain, &drawn[(size_t)set * SET]);
        sum += part / SET;
        squares += (part / SET) * (part / SET);
    }
    double mean = sum / sets;
    return (estimate){mean, sqrt(fmax(squares / sets - mean * mean, 0) / (sets - 1))};
}

/* For each configuration from `first` to before `end` the mean of many samples; where the closed
 * form is 0, a set, which must all be 0. */
static void check_unbiased(rk_light_domain domain, rk_sampler_kind kind, uint32_t sets,
                           size_t first, size_t end)
{
    size_t lit = 0;
    draw(kind, sets, SET);
    for (size_t k = first; k < end; k++) {
        const configuration *c = &configurations[k];
        rk_light light = light_of(c);
        double want = (double)rk_light_irradiance(&light, c->point, c->normal);
        lit += want > 0;
        estimate got = estimate_irradiance(c, domain, want > 0 ? sets : 2);
        double bound = 0;
        if (domain == RK_LIGHT_DOMAIN_AREA)
            bound = variance_bound(c, want, sets * SET);
        /* 32 sets tell the error to 13 %: the mean is off by five of them once in 45,000 times.
         * Weight and closed form are rounded to float, 2^-24 each; so is the position. */
        double error = fmax(got.error, sqrt(bound / (sets * SET))),
               tolerance = 5 * error + 1e-6 * want;
        rk_check(fabs(got.mean - want) <= tolerance,
                 "%s: the mean of your samples' weights times cosines is %.9g, but your "
                 "rk_light_irradiance says %.9g; want the same within %.3g%s",
                 c->name, got.mean, want, tolerance,
                 want > 0 ? "" : ": a light that cannot be seen has samples of weight 0");
        rk_check(5 * error <= 0.2 * want || c->kind == RK_LIGHT_SEGMENT || bound > 0,
                 "%s: a standard error of %g tests nothing; want at most 4 %% of %g", c->name,
                 error, want);
    }
    rk_check(2 * lit > end - first, "got irradiance in %zu of %zu configurations, want most", lit,
             end - first);
}

static void uniform_samples_are_unbiased(void **state)
{
    (void)state;
    check_unbiased(RK_LIGHT_DOMAIN_AREA, RK_SAMPLER_UNIFORM, SETS_UNIFORM, 0, CONFIGURATIONS);
}

/* The root of the mean squared error of 256 samples of a square overhead. */
static double error_of_256(rk_light_domain domain, rk_sampler_kind kind)
{
    enum { n = 256, sets = 64 };
    const configuration *c = &configurations[0];
    const rk_light light = light_of(c);
    const double want = (double)rk_light_irradiance(&light, c->point, c->normal);
    double squares = 0;
    for (uint32_t set = 0; set < sets; set++) {
        const rk_sampler sampler = {kind, set, n, 1};
        double sum = 0;
        for (uint32_t i = 0; i < n; i++) {
            rk_vec2 xi = rk_sample_2d(&sampler, 0, i, RK_DIMENSION_LIGHT);
            rk_light_sample sample =
                rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, domain, c->point, xi);
            rk_vec3 l = rk_normalize(rk_sub(sample.position, c->point));
            sum += (double)(sample.colour.x * rk_dot(l, c->normal)) / n;
        }
        squares += (sum - want) * (sum - want) / sets;
    }
    return sqrt(squares);
}

/* The reference: a tenth; strata whose order is lost, two thirds. 64 sets tell each error to 9 %.
 */
static void check_strata(rk_light_domain domain)
{
    double independent = error_of_256(domain, RK_SAMPLER_UNIFORM);
    double stratified = error_of_256(domain, RK_SAMPLER_STRATIFIED);
    rk_check(
        stratified <= independent / 3,
        "256 stratified samples of a square overhead, over its %s, are off by %.3g, independent "
        "ones by %.3g, want at most a third: neighbouring xi are neighbouring points of the light",
        domain == RK_LIGHT_DOMAIN_AREA ? "area" : "solid angle", stratified, independent);
}

static void stratified_samples_are_unbiased(void **state)
{
    (void)state;
    check_strata(RK_LIGHT_DOMAIN_AREA);
    check_unbiased(RK_LIGHT_DOMAIN_AREA, RK_SAMPLER_STRATIFIED, SETS, 0, CONFIGURATIONS);
}

static void low_discrepancy_samples_are_unbiased(void **state)
{
    (void)state;
    check_unbiased(RK_LIGHT_DOMAIN_AREA, RK_SAMPLER_LOW_DISCREPANCY, SETS, 0, CONFIGURATIONS);
}

static void solid_angle_samples_are_unbiased(void **state)
{
    (void)state;
    check_strata(RK_LIGHT_DOMAIN_SOLID_ANGLE);
    check_unbiased(RK_LIGHT_DOMAIN_SOLID_ANGLE, RK_SAMPLER_LOW_DISCREPANCY, SETS, 0,
                   CONFIGURATIONS / 3);
}

static void solid_angle_samples_are_unbiased_at_the_limits(void **state)
{
    (void)state;
    check_unbiased(RK_LIGHT_DOMAIN_SOLID_ANGLE, RK_SAMPLER_LOW_DISCREPANCY, SETS,
                   CONFIGURATIONS / 3, CONFIGURATIONS);
}

/* Of lights with the same four colours, with area and without. */
static void check_flat_colours(void)
{
    enum { count = 40, shapes = 4 };
    const rk_light whole = make_coloured(RK_LIGHT_PARALLELOGRAM);
    const rk_vec3 zero = {0, 0, 0}, edge = {0, 4, 0};
    const rk_vec3 edges[shapes][2] = {{edge, zero}, {zero, edge}, {edge, edge}, {zero, zero}};
    rk_vec3 want[count], got[shapes][count];
    for (uint32_t i = 0; i < count; i++) {
        rk_vec2 xi = noise2(51, i);
        want[i] = plain_sample(&whole, xi.x, xi.y).colour;
        for (int k = 0; k < shapes; k++) {
            rk_light flat = whole;
            flat.edge01 = edges[k][0], flat.edge02 = edges[k][1];
            got[k][i] = plain_sample(&flat, xi.x, xi.y).colour;
        }
    }
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < shapes; k++)
            check_vec3(got[k][i], want[i], 0x1p-22f,
                       "a parallelogram without area still mixes its four colours");
}

static void without_falloff_a_light_without_area_is_a_segment(void **state)
{
    (void)state;
    check_flat_colours();
    rk_light flat = make_coloured(RK_LIGHT_PARALLELOGRAM),
             segment = make_coloured(RK_LIGHT_SEGMENT);
    flat.edge02 = rk_vec(0, 0, 0);
    flat.colours[2] = flat.colours[0], flat.colours[3] = flat.colours[1];
    for (uint32_t i = 0; i < 100; i++) {
        rk_vec2 xi = noise2(50, i);
        rk_light_sample got = plain_sample(&flat, xi.x, xi.y),
                        want = plain_sample(&segment, xi.x, xi.y);
        check_vec3(got.position, want.position, 0, "with edge02 = 0, y does not move the sample");
        check_vec3(got.colour, want.colour, 0x1p-23f, "nor does y change equal colours");
        check_vec3(got.position, rk_madd(flat.position, flat.edge01, xi.x), 0x1p-20f,
                   "along edge01");
        rk_light other = flat; /* the first edge is 0, both are parallel, both are 0 */
        other.edge01 = rk_vec(0, 0, 0), other.edge02 = rk_vec(0, 4, 0);
        check_vec3(plain_sample(&other, xi.x, xi.y).position,
                   rk_madd(other.position, other.edge02, xi.y), 0x1p-20f, "along edge02");
        other.edge01 = rk_vec(0, -1, 0);
        check_vec3(plain_sample(&other, xi.x, xi.y).position,
                   rk_madd(other.position, other.edge02, xi.y - xi.x / 4), 0x1p-20f,
                   "along both of two parallel edges");
        other.edge01 = other.edge02 = rk_vec(0, 0, 0);
        check_vec3(plain_sample(&other, xi.x, xi.y).position, other.position, 0,
                   "without edges it is a point");
        for (int domain = 0; domain < 2; domain++)
            check_vec3(rk_light_sample_at(&other, RK_FALLOFF_NONE, (rk_light_domain)domain,
                                          other.position, xi)
                           .colour,
                       plain_sample(&other, xi.x, xi.y).colour, 0,
                       "a light without area has its colour, from everywhere");
    }
}

static void no_light_and_no_point_give_nan(void **state)
{
    (void)state;
    /* Whole coordinates make points on the light, in its plane, and edges that are parallel or 0;
     * scales from 1e-15 to 1e15. */
    double lit = 0;
    for (uint32_t i = 0; i < 50000; i++) {
        float scale = powf(10, (float)(i % 31) - 15);
        rk_vec3 v[4];
        for (uint32_t k = 0; k < 4; k++) {
            rk_vec3 at = rk_scale(noise3(60 + k, i), 2.5f);
            v[k] = rk_scale(rk_vec(rintf(at.x), rintf(at.y), rintf(at.z)), scale);
        }
        rk_light light = make_light((rk_light_kind)(i % 3), v[0], v[1], v[2]);
        rk_vec2 xi = i % 5 ? noise2(64, i)
                           : (rk_vec2){i % 2 ? 0 : 0x0.ffffffp0f, i % 4 < 2 ? 0 : 0x0.ffffffp0f};
        rk_light_sample sample =
            rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, (rk_light_domain)(i / 3 % 2), v[3], xi);
        float irradiance = rk_light_irradiance(&light, v[3], rk_vec(0, 0.6f, 0.8f));
        lit += light.kind == RK_LIGHT_PARALLELOGRAM && sample.colour.x > 0 && irradiance > 0;
        rk_check(!(sample.colour.x < 0),
                 "light %u, coordinates of about %g: got a sample of weight %g: weights are finite "
                 "and not negative",
                 i, (double)scale, (double)sample.colour.x);
        rk_check(
            isfinite(sample.position.x + sample.position.y + sample.position.z) &&
                isfinite(sample.colour.x),
            "light %u, coordinates of about %g: got a sample at (%g, %g, %g) of weight %g, want "
            "finite numbers: no direction may be divided by a length of 0, and r^3 leaves the "
            "range of a float, but not that of a double",
            i, (double)scale, (double)sample.position.x, (double)sample.position.y,
            (double)sample.position.z, (double)sample.colour.x);
        rk_check(!(irradiance < 0), "light %u: got an irradiance of %g: it is never negative", i,
                 (double)irradiance);
        rk_check(
            isfinite(irradiance),
            "light %u: got an irradiance of %g, want a finite one: skip edges without an angle", i,
            (double)irradiance);
    }
    rk_check(lit > 2500,
             "only %g of 16666 points were lit by parallelograms: too few for this test", lit);
}

/* --- The ratio estimator --------------------------------------------------------------------- */

static const char *const channels[] = {"red", "green", "blue"};

static void the_ratio_is_exact_where_nothing_or_everything_is_occluded(void **state)
{
    (void)state;
    const rk_vec3 unshadowed = {0.3f, 0.2f, 0.7f}, all = {7.3f, 1.9f, 3.1f};
    check_vec3(rk_light_ratio(unshadowed, all, all), unshadowed, 0, "all samples are unoccluded");
    check_vec3(rk_light_ratio(unshadowed, rk_vec(0, 0, 0), all), rk_vec(0, 0, 0), 0,
               "none is unoccluded");
    check_vec3(rk_light_ratio(unshadowed, rk_scale(all, 0.25f), all), rk_scale(unshadowed, 0.25f),
               0, "a quarter");
    for (int k = 0; k < 3; k++) {
        rk_vec3 one = rk_vec(k == 0, k == 1, k == 2);
        char hint[120];
        snprintf(hint, sizeof hint,
                 "all samples are unoccluded in %s, and none in the others: each channel has its "
                 "own fraction",
                 channels[k]);
        check_vec3(rk_light_ratio(unshadowed, rk_mul(all, one), all), rk_mul(unshadowed, one), 0,
                   hint);
    }
    for (uint32_t i = 0; i < 1000; i++) {
        /* From 1e-37 to 1e37, where a product of two leaves the range of a float. */
        float e = powf(10, 37 * (2 * noise(75, i, 0) - 1)),
              sum = powf(10, 37 * (2 * noise(75, i, 1) - 1));
        float got = rk_light_ratio(rk_vec(0, e, 0), rk_vec(0, sum, 0), rk_vec(0, sum, 0)).y;
        rk_check(got == e,
                 "unshadowed %.9g, visible and all %.9g: got %.9g, want exactly what is "
                 "unshadowed: divide "
                 "visible by all first",
                 (double)e, (double)sum, (double)got);
    }
}

static void a_channel_without_light_has_the_ratio_0(void **state)
{
    (void)state;
    check_vec3(rk_light_ratio(rk_vec(1, 0, 1), rk_vec(2, 0, 0), rk_vec(4, 0, 0)),
               rk_vec(0.5f, 0, 0), 0, "each channel is divided separately, and 0 / 0 is 0");
    for (int i = 0; i < 8; i++) { /* red, green and blue are there or not */
        rk_vec3 some = rk_vec((float)(i & 1), (float)(i / 2 & 1), (float)(i / 4));
        char hint[120];
        snprintf(hint, sizeof hint,
                 "there is%s red,%s green and%s blue light: a channel has its own ratio, and a "
                 "black one leaves the others alone",
                 i & 1 ? "" : " no", i & 2 ? "" : " no", i & 4 ? "" : " no");
        check_vec3(rk_light_ratio(rk_vec(3, 5, 7), rk_mul(some, rk_vec(1, 1, 6)),
                                  rk_mul(some, rk_vec(2, 4, 8))),
                   rk_mul(some, rk_vec(1.5f, 1.25f, 5.25f)), 0, hint);
    }
}

/* The part of the light with x < 0.375 is visible; it has a closed form, too. */
static void the_ratio_converges_to_the_visible_fraction(void **state)
{
    (void)state;
    enum { RATIO_SET = 256 };
    draw(RK_SAMPLER_STRATIFIED, SETS, RATIO_SET);
    int tried = 0;
    for (size_t k = 0; k < CONFIGURATIONS; k++) {
        const configuration *c = &configurations[k];
        rk_light light = light_of(c), part = light;
        part.edge01 = rk_scale(light.edge01, 0.375f);
        if (c->kind != RK_LIGHT_PARALLELOGRAM || rk_light_solid_angle(&light, c->point) < 1e-11)
            continue;
        tried++;
        double all[SETS] = {0}, visible[SETS] = {0}, sum = 0, visible_sum = 0, squares = 0;
        for (uint32_t set = 0; set < SETS; set++) {
            for (uint32_t i = 0; i < RATIO_SET; i++) {
                rk_light_sample sample =
                    rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_SOLID_ANGLE,
                                       c->point, drawn[set * RATIO_SET + i]);
                double f = (double)sample.colour.x * cos_to(c, sample.position);
                all[set] += f;
                visible[set] += find_on(&light, sample.position).x < 0.375f ? f : 0;
            }
            sum += all[set], visible_sum += visible[set];
        }
        double whole = (double)rk_light_irradiance(&light, c->point, c->normal);
        double want = (double)rk_light_irradiance(&part, c->point, c->normal);
        rk_vec3 got = rk_light_ratio(rk_vec((float)whole, 0, 0), rk_vec((float)visible_sum, 0, 0),
                                     rk_vec((float)sum, 0, 0));
        /* A ratio's standard error is that of `visible - fraction all`. */
        double fraction = sum > 0 ? visible_sum / sum : 0;
        for (uint32_t set = 0; set < SETS; set++)
            squares += pow(visible[set] - fraction * all[set], 2);
        /* A position is rounded to 2^-24 of its coordinates, which moves it on the light. */
        double moved = 0x1p-22 * (double)(rk_length(light.position) / rk_length(light.edge01));
        double error = sqrt(squares) / (SETS * RATIO_SET) * 5 + (1e-5 + moved) * whole;
        /* Of samples so rare that there may be none, the sums don't tell the error. */
        double hidden = (1 - want / whole) * SETS * RATIO_SET,
               few = fmax(fmin(hidden, SETS * RATIO_SET - hidden), 0);
        if (few < 20)
            error += (5 * sqrt(few) + 2) * whole / (SETS * RATIO_SET);
        rk_check_close(got.x, want, error, c->name);
    }
    rk_check(tried >= 20, "%d configurations were tried, want 20: is the solid angle right?",
             tried);
}

/* --- When to stop ---------------------------------------------------------------------------- */

static void shadow_rays_that_agree_stop_early(void **state)
{
    (void)state;
    rk_check(rk_light_early_out(16, 0), "0 of 16 unoccluded: umbra, stop");
    rk_check(rk_light_early_out(16, 16), "16 of 16 unoccluded: lit, stop");
    rk_check(rk_light_early_out(1, 1) && rk_light_early_out(1, 0), "a single ray always agrees");
    for (uint64_t round = 1; round < 1ull << 32; round += 1 + round / 3)
        rk_check(rk_light_early_out((uint32_t)round, 0) &&
                     rk_light_early_out((uint32_t)round, (uint32_t)round),
                 "all of %u occluded, or unoccluded: stop, however long the round",
                 (unsigned)round);
    rk_check(rk_light_early_out(UINT32_MAX, UINT32_MAX), "all of 2^32 - 1 unoccluded: stop");
}

static void shadow_rays_that_disagree_continue(void **state)
{
    (void)state;
    for (uint32_t round = 2; round <= 65537; round = round < 20 ? round + 1 : 2 * round - 1)
        for (uint32_t visible = 1; visible < round; visible += 1 + visible % 300)
            rk_check(!rk_light_early_out(round, visible), "%u of %u unoccluded: penumbra, continue",
                     visible, round);
    rk_check(!rk_light_early_out(512, 256), "256 of 512 unoccluded: penumbra, continue");
    for (uint32_t visible = 1; visible < 16; visible++)
        rk_check(!rk_light_early_out(16, visible), "%u of 16 unoccluded: penumbra, continue",
                 visible);
    for (int e = 8; e < 32; e++) { /* where smaller integers, and floats, have no room */
        uint32_t all = 1u << e, rounds[] = {all + 1, UINT32_MAX, all + 1, UINT32_MAX, all};
        uint32_t seen[] = {all, all, 1, UINT32_MAX - 1, all - 1};
        for (int i = 0; i < 5; i++)
            rk_check(!rk_light_early_out(rounds[i], seen[i]),
                     "%u of %u unoccluded: penumbra, continue", seen[i], rounds[i]);
    }
    rk_check(!rk_light_early_out(0, 0), "a round of no rays: nothing is known");
    rk_check(rk_light_early_out(16, 0),
             "got no early out at all, so that none at the wrong place says nothing");
}

static void the_bias_of_early_out_stays_below_its_bound(void **state)
{
    (void)state;
    const uint32_t round = RK_LIGHT_EARLY_OUT;
    double bound = pow(round / (round + 1.0), round) / (round + 1), largest = 0;
    for (int percent = 0; percent <= 100; percent++) {
        /* Each number of unoccluded rays with its binomial probability. Many more rays would find
         * v; an early out takes the first rays' mean. */
        double v = percent / 100.0, expected = 0, ways = 1;
        for (uint32_t visible = 0; visible <= round; visible++) {
            double probability = ways * pow(v, visible) * pow(1 - v, round - visible);
            expected +=
                probability * (rk_light_early_out(round, visible) ? visible / (double)round : v);
            ways = ways * (round - visible) / (visible + 1);
        }
        double bias = fabs(expected - v);
        largest = fmax(largest, bias);
        /* All numbers are at most 1, and some hundred operations are rounded. */
        rk_check(bias <= bound + 0x1p-40, "%d %% visible: got a bias of %g, want at most %g",
                 percent, bias, bound);
    }
    /* At its worst, where 1 / 17 is visible, less than 1 % of a round sees all of the light. */
    rk_check(largest >= 0.9 * bound, "got no bias above %g, want %g: is there any early out?",
             largest, bound);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_point_light_has_one_position_and_one_colour),
    cmocka_unit_test(a_segment_runs_from_corner_0_to_corner_1),
    cmocka_unit_test(corners_have_their_own_colours),
    cmocka_unit_test(colours_are_bilinear_between_the_corners),
    cmocka_unit_test(a_sample_is_a_position_and_not_a_direction),
    cmocka_unit_test(without_falloff_neither_distance_nor_domain_matters),
    cmocka_unit_test(a_point_light_falls_off_with_the_square_of_the_distance),
    cmocka_unit_test(a_segment_is_foreshortened),
    cmocka_unit_test(a_parallelogram_is_foreshortened_and_two_sided),
    cmocka_unit_test(points_on_the_light_get_nothing_and_no_nan),
    cmocka_unit_test(a_square_above_the_point_has_the_textbook_form_factor),
    cmocka_unit_test(a_light_all_around_gives_pi_and_half_of_it_half),
    cmocka_unit_test(the_closed_form_of_a_point_is_the_cosine_over_the_squared_distance),
    cmocka_unit_test(near_and_far_lights_have_the_textbook_form_factor_too),
    cmocka_unit_test(the_closed_form_equals_quadrature),
    cmocka_unit_test(two_parts_of_a_light_add_up_to_the_whole),
    cmocka_unit_test(the_closed_form_equals_quadrature_at_the_limits),
    cmocka_unit_test(each_sample_is_the_integrand_at_its_place),
    cmocka_unit_test(the_side_of_a_cube_fills_a_sixth_of_the_sphere),
    cmocka_unit_test(small_solid_angles_are_accurate_too),
    cmocka_unit_test(solid_angle_samples_all_weigh_the_same),
    cmocka_unit_test(solid_angle_samples_lie_on_the_light_and_have_its_colour),
    cmocka_unit_test(solid_angle_samples_are_uniform_over_directions),
    cmocka_unit_test(uniform_samples_are_unbiased),
    cmocka_unit_test(stratified_samples_are_unbiased),
    cmocka_unit_test(low_discrepancy_samples_are_unbiased),
    cmocka_unit_test(solid_angle_samples_are_unbiased),
    cmocka_unit_test(solid_angle_samples_are_unbiased_at_the_limits),
    cmocka_unit_test(without_falloff_a_light_without_area_is_a_segment),
    cmocka_unit_test(no_light_and_no_point_give_nan),
    cmocka_unit_test(the_ratio_is_exact_where_nothing_or_everything_is_occluded),
    cmocka_unit_test(a_channel_without_light_has_the_ratio_0),
    cmocka_unit_test(the_ratio_converges_to_the_visible_fraction),
    cmocka_unit_test(shadow_rays_that_agree_stop_early),
    cmocka_unit_test(shadow_rays_that_disagree_continue),
    cmocka_unit_test(the_bias_of_early_out_stays_below_its_bound),
};

RK_SUITE("parallelogram_light", tests)
