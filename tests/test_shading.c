/* Shading: every model against values computed by hand and in double, the light that normalized
 * models reflect, and that no result is NaN. */
#include "test.h"

#include "base/dvec3.h"
#include "base/random.h"
#include "features/shading.h"

/* --- Surfaces and lights to try ------------------------------------------------------------- */

static const double pi = 3.14159265358979323846;

/* Roundings of a few operations on numbers of order one, each 2^-24. */
static const double few_roundings = 8 * 0x1p-24;

static const rk_vec3 up = {0, 0, 1}, white = {1, 1, 1}, black = {0, 0, 0};

static const char *const model_names[] = {"off", "lambert", "phong", "blinn-phong", "gradient"};

/* The unit vector at this angle from `up`, in the plane of x and z, turned about `up`. */
static rk_vec3 direction(double degrees_from_up, double degrees_around)
{
    double theta = degrees_from_up * pi / 180, phi = degrees_around * pi / 180;
    return rk_vec((float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                  (float)cos(theta));
}

static rk_vec3 random_direction(uint32_t a, uint32_t b)
{
    double z = 2 * (double)rk_unit_float(rk_case(a, b, 0, 1)) - 1;
    return direction(acos(z) * 180 / pi, 360 * (double)rk_unit_float(rk_case(a, b, 1, 1)));
}

static rk_vec3 random_colour(uint32_t a, uint32_t b)
{
    return rk_vec(rk_unit_float(rk_case(a, b, 0, 2)), rk_unit_float(rk_case(a, b, 1, 2)),
                  rk_unit_float(rk_case(a, b, 2, 2)));
}

/* The shading of a model, with a gradient of one stop, which is grey everywhere. */
static rk_shading shading_of(rk_shading_model model, bool normalized)
{
    return (rk_shading){model, normalized, {1, {{0, {0.5f, 0.5f, 0.5f}}}}};
}

/* The same vector in other axes, to the bit: turned from x to y to z to x, or mirrored. */
static rk_vec3 turned(rk_vec3 a, uint32_t turns)
{
    for (uint32_t k = turns % 3; k > 0; k--)
        a = rk_vec(a.z, a.x, a.y);
    return turns % 6 < 3 ? a : rk_negate(a);
}

/* The lobe alone: kd black, ks white, white light, `up` the normal. */
static float highlight(rk_shading_model model, float shininess, rk_vec3 l, rk_vec3 v)
{
    rk_shading shading = shading_of(model, false);
    return rk_shade(&shading, black, white, shininess, up, l, v, white).x;
}

static void check_colour(rk_vec3 got, rk_vec3 want, double tolerance, const char *hint)
{
    rk_check_close(got.x, want.x, tolerance, hint);
    rk_check_close(got.y, want.y, tolerance, hint);
    rk_check_close(got.z, want.z, tolerance, hint);
}

/* Roundings of products alone, which are relative. */
static void check_relative(rk_vec3 got, rk_vec3 want, const char *hint)
{
    for (int k = 0; k < 3; k++)
        rk_check_close(rk_axis(got, k), rk_axis(want, k),
                       few_roundings * (double)rk_axis(want, k) + 0x1p-149, hint);
}

/* Cosines of light that grazes the surface: a float along an axis has them to the last digit. */
static const float grazing[] = {0.01f, 1e-3f, 1e-6f, 1e-10f, 1e-17f};
enum { grazing_count = sizeof grazing / sizeof *grazing };

/* The unit vector with the cosine z to `up`, in the plane of x and z; side is 1 or -1. */
static rk_vec3 at_cosine(float z, float side)
{
    return rk_vec(side * (float)sqrt(1 - (double)z * (double)z), 0, z);
}

static bool equal_bits(rk_vec3 a, rk_vec3 b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* --- The models in double precision --------------------------------------------------------- */

/* The direction of a float vector, whose length is off by a rounding. */
static rk_dvec3 exact(rk_vec3 a)
{
    rk_dvec3 v = rk_widen(a);
    return rk_dscale(v, 1 / rk_dlength(v));
}

/* A model's result for kd = 0, ks = 1 and white light. */
static double exact_highlight(rk_shading_model model, bool normalized, double s, rk_vec3 n_,
                              rk_vec3 l_, rk_vec3 v_)
{
    rk_dvec3 n = exact(n_), l = exact(l_), v = exact(v_);
    double cos_i = rk_ddot(n, l), cosine, normalizer;
    if (cos_i <= 0)
        return 0;
    if (model == RK_SHADING_PHONG) {
        cosine = rk_ddot(rk_dmadd(rk_dscale(n, 2 * cos_i), l, -1), v);
        normalizer = (s + 2) / (2 * pi);
    } else {
        rk_dvec3 sum = rk_dmadd(l, v, 1);
        cosine = rk_ddot(n, sum) / rk_dlength(sum);
        normalizer = (s + 2) * (s + 4) / (8 * pi * (pow(2, -s / 2) + s));
    }
    return cosine > 0 ? pow(cosine, s) * (normalized ? normalizer * cos_i : 1) : 0;
}

/* --- Off and Lambert ------------------------------------------------------------------------ */

static void off_is_the_light_times_the_diffuse_colour(void **state)
{
    (void)state;
    for (int normalized = 0; normalized < 2; normalized++) {
        rk_shading shading = shading_of(RK_SHADING_OFF, normalized);
        rk_vec3 got = rk_shade(&shading, rk_vec(0.5f, 0.25f, 0), white, 10, up, rk_vec(0, 0, -1),
                               up, rk_vec(2, 1, 4));
        check_colour(got, rk_vec(1, 0.25f, 0), 0, "I kd, wherever the light is");
        for (int k = 0; k < 4; k++) /* light along the surface, too, and a mirror or none */
            check_colour(rk_shade(&shading, rk_vec(0.5f, 2, 1), k & 1 ? black : white, 10, up,
                                  k & 2 ? rk_vec(1, 0, 0) : up, black, rk_vec(8, 1e20f, 1e-20f)),
                         rk_vec(4, 2e20f, 1e-20f), 0, "I kd, whatever ks is, however bright");
    }
}

static void lambert_falls_with_the_cosine(void **state)
{
    (void)state;
    rk_shading shading = shading_of(RK_SHADING_LAMBERT, false);
    rk_vec3 kd = rk_vec(0.5f, 0.25f, 1), light = rk_vec(2, 4, 1);
    for (int degrees = 0; degrees < 90; degrees += 10) {
        float cosine = (float)cos(degrees * pi / 180);
        rk_vec3 got =
            rk_shade(&shading, kd, white, 10, up, direction(degrees, 40), direction(30, 0), light);
        check_colour(got, rk_scale(white, cosine), few_roundings,
                     "I kd n.l, without ks: all three products of I and kd are one here");
    }
    for (uint32_t i = 0; i < 6 * grazing_count; i++) {
        float cosine = grazing[i / 6];
        check_relative(rk_shade(&shading, kd, white, 10, turned(up, i),
                                turned(at_cosine(cosine, 1), i), black, light),
                       rk_scale(white, cosine), "I kd n.l, however small n.l is");
    }
    check_relative(rk_shade(&shading, rk_vec(1e-30f, 0, 1e-10f), white, 10, up, at_cosine(0.5f, 1),
                            black, rk_vec(1e20f, 1, 1e-5f)),
                   rk_vec(0.5e-10f, 0, 0.5e-15f), "I kd n.l, however small kd is");
    /* Strong light at a grazing angle is as bright as faint light from above. */
    check_relative(rk_shade(&shading, white, white, 10, up, at_cosine(1e-17f, -1), black,
                            rk_vec(1e17f, 1e30f, 1e-10f)),
                   rk_vec(1, 1e13f, 1e-27f), "I kd n.l, however strong the light is");
}

static void light_from_behind_or_along_the_surface_gives_nothing(void **state)
{
    (void)state;
    const rk_vec3 lights[] = {{1, 0, 0}, {0, -1, 0}, {0.6f, 0, -0.8f}, {0, 0, -1}};
    rk_shading lit = shading_of(RK_SHADING_LAMBERT, false); /* the others are later steps */
    rk_check(rk_shade(&lit, white, white, 0, up, up, up, white).x > 0,
             "light from above gives nothing, either");
    for (int model = RK_SHADING_LAMBERT; model <= RK_SHADING_BLINN_PHONG; model++)
        for (int k = 0; k < 16; k++) {
            rk_shading shading = shading_of((rk_shading_model)model, k & 1);
            rk_vec3 got = rk_shade(&shading, white, white, k & 2 ? 4.0f : 0, up, lights[k / 4],
                                   direction(80, 180), white);
            double cosine = (double)lights[k / 4].z;
            rk_check(
                equal_bits(got, black),
                "%s, light %d: got %g, want 0: n.l = %g is not above 0, so there is no "
                "highlight either%s",
                model_names[model], k / 4, (double)got.x, cosine,
                rk_mistake_in((double)got.x, 0, few_roundings,
                              RK_MISTAKES({-cosine, "the absolute value of n.l is taken"},
                                          {cosine, "n.l is not limited to 0 and above"},
                                          {-cosine / pi, "the absolute value of n.l is taken"},
                                          {cosine / pi, "n.l is not limited to 0 and above"})));
        }
}

/* --- Highlights ----------------------------------------------------------------------------- */

/* The power of a cosine as it comes out for vectors that are not of unit length, by their product
 * or by their distance. */
static double by_product(rk_vec3 a, rk_vec3 b, double s)
{
    return pow(fmax(rk_ddot(rk_widen(a), rk_widen(b)), 0), s);
}

static double by_distance(rk_vec3 a, rk_vec3 b, double s)
{
    const rk_dvec3 apart = rk_dmadd(rk_widen(a), rk_widen(b), -1);
    return pow(fmax(1 - rk_ddot(apart, apart) / 2, 0), s);
}

/* A lobe of the shininess s, compared with those that it may be by mistake. */
static void check_lobe(rk_shading_model model, float s, rk_vec3 l, rk_vec3 v, double want,
                       const char *hint)
{
    const rk_vec3 mirror = rk_sub(rk_scale(up, 2 * l.z), l), near = rk_sub(rk_scale(up, l.z), l);
    const rk_vec3 sum = rk_add(l, v), mean = rk_scale(sum, 0.5f), half = rk_normalize(sum);
    const double k = (double)s;
    const char *const no_two = "the 2 of r = 2 (n.l) n - l is missing";
    const char *const long_h = "h is l + v, not normalized: its length is not 1";
    const char *const short_h = "h is (l + v) / 2, not normalized: its length is not 1";
    rk_check_near_or(
        highlight(model, s, l, v), want, few_roundings,
        RK_MISTAKES({by_product(rk_negate(mirror), v, k), "r has the other sign: 2 (n.l) n - l"},
                    {by_product(near, v, k), no_two}, {by_distance(near, v, k), no_two},
                    {by_product(l, v, k), "the light's own direction is compared with v, not its "
                                          "mirror direction r"},
                    {want * want, "the shininess is doubled"},
                    {pow(want, 4), "the shininess is taken four times"},
                    {want * (double)l.z, "the lobe is multiplied by n.l"},
                    {by_product(up, sum, k), long_h}, {by_distance(up, sum, k), long_h},
                    {by_product(up, mean, k), short_h}, {by_distance(up, mean, k), short_h},
                    {by_product(half, v, k), "h is compared with v, not with n"},
                    {by_product(mirror, v, k), "the lobe is Phong's, around the mirror direction"},
                    {by_product(half, up, k), "the lobe is Blinn-Phong's, around the normal"}),
        "%s, shininess %g, l = (%g, %g, %g), v = (%g, %g, %g): %s", model_names[model], k,
        (double)l.x, (double)l.y, (double)l.z, (double)v.x, (double)v.y, (double)v.z, hint);
}

static void phong_is_the_cosine_from_the_mirror_direction_to_a_power(void **state)
{
    (void)state;
    /* The mirror direction of l, 30 degrees to one side, is 30 degrees to the other. */
    rk_vec3 l = direction(30, 180);
    const char *hint = "(r.v)^s with r = 2 (n.l) n - l, and not times n.l";
    check_lobe(RK_SHADING_PHONG, 3, l, direction(-75, 0), 0, hint);
    check_lobe(RK_SHADING_PHONG, 7, l, direction(30, 0), 1, hint);
    check_lobe(RK_SHADING_PHONG, 1, l, direction(90, 0), 0.5, hint);
    check_lobe(RK_SHADING_PHONG, 2, l, direction(90, 0), 0.25, hint);
    check_lobe(RK_SHADING_PHONG, 2, l, direction(-30, 0), 0.25, hint);
    check_lobe(RK_SHADING_PHONG, 4, l, direction(75, 0), 0.25, hint);
    /* Roots, where the shininess is below 1. */
    for (float s = 1; s > 1e-6f; s *= 0.5f)
        check_lobe(RK_SHADING_PHONG, s, l, direction(90, 0), pow(0.5, (double)s), hint);
}

static void blinn_phong_is_the_cosine_from_the_normal_to_the_half_vector_to_a_power(void **state)
{
    (void)state;
    /* Halfway between 75 degrees to one side and 15 to the other is 30 degrees from `up`. */
    rk_vec3 l = direction(75, 180), v = direction(15, 0);
    const char *hint = "(n.h)^s with h = (l + v) / |l + v|, and not times n.l";
    check_lobe(RK_SHADING_BLINN_PHONG, 2, l, v, 0.75, hint);
    check_lobe(RK_SHADING_BLINN_PHONG, 4, l, v, 0.5625, hint);
    for (float s = 1; s > 1e-6f; s *= 0.5f)
        check_lobe(RK_SHADING_BLINN_PHONG, s, l, v, pow(0.75, (double)s / 2), hint);
    /* Out of the plane: h = (1, 1, 1) / sqrt 3 between the middles of two sides of a cube. */
    rk_vec3 a = rk_vec(0.8944272f, 0, 0.4472136f), b = rk_vec(0, 0.8944272f, 0.4472136f);
    check_lobe(RK_SHADING_BLINN_PHONG, 2, a, b, 1.0 / 3, hint);
}

static void in_the_mirror_direction_both_highlights_are_one(void **state)
{
    (void)state;
    const float shininess[] = {0, 1, 10, 1e3f, 1e5f};
    for (int degrees = 0; degrees < 90; degrees += 5)
        for (int i = 0; i < 5; i++)
            for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
                rk_vec3 l = direction(degrees, 200), v = direction(degrees, 20);
                float got = highlight((rk_shading_model)model, shininess[i], l, v);
                rk_check(got <= 1, "%s, shininess %g: got %.9g, which is more than one",
                         model_names[model], (double)shininess[i], (double)got);
                /* v is off the mirror direction by some roundings, which hardly change the cosine.
                 * */
                rk_check_close(got, 1, few_roundings, "the cosine is one, and so is its power");
            }
    for (int i = 0; i < grazing_count; i++)
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
            rk_check_close(highlight((rk_shading_model)model, 3, at_cosine(grazing[i], 1),
                                     at_cosine(grazing[i], -1)),
                           1, few_roundings,
                           "however nearly light and viewer are opposite, there is a half vector, "
                           "and a highlight in the mirror direction");
}

static void a_highlight_ends_at_a_right_angle(void **state)
{
    (void)state;
    /* r is at 70 degrees to one side. With v at 10 to the other they are 80 apart, with v at 30
     * they are 100 apart, and an even power of a negative cosine is positive. */
    rk_vec3 l = direction(70, 180), v = direction(-10, 0);
    double cosine = cos(80 * pi / 180);
    rk_check_close(highlight(RK_SHADING_PHONG, 2, l, v), cosine * cosine, few_roundings,
                   "up to a right angle there is a highlight");
    v = direction(-30, 0);
    rk_check_close(highlight(RK_SHADING_PHONG, 2, l, v), 0, 0, "max(0, r.v), before the power");
    rk_check_close(highlight(RK_SHADING_PHONG, 0, l, v), 0, 0, "this holds for s = 0 too");
    const float shininess[] = {0, 0x1p-149f, 1e-6f, 1, 2, 3, 1e5f};
    for (int i = 0; i < 7; i++) {
        rk_check_close(highlight(RK_SHADING_PHONG, shininess[i], up, rk_vec(1, 0, 0)), 0, 0,
                       "r.v is exactly 0 at a right angle, and no power of it is a highlight");
        rk_check_close(highlight(RK_SHADING_PHONG, shininess[i], up, rk_vec(0, 0, -1)), 0, 0,
                       "r.v = -1, from below the surface: no highlight");
    }
}

/* Just before a right angle the power is small, and its logarithm steep: what stays exact is the
 * cosine, up to a few roundings of r, of v and of their lengths. Relative to a small cosine they
 * are large, for any formula: the last digits of n, l and v already change it by as much. */
static void close_to_a_right_angle_the_cosine_keeps_its_digits(void **state)
{
    (void)state;
    const double shininess[] = {0.25, 0.5, 1, 2};
    for (int i = 0; i < 4 * 400; i++) {
        double s = shininess[i % 4], short_of_right = pow(10, -1 - 5 * (i / 4) / 400.0);
        /* r is to the other side of `up` than l, v nearly a right angle back. */
        double incidence = 20 + i % 50;
        rk_vec3 l = direction(incidence, i);
        rk_vec3 v = direction(incidence - 90 + short_of_right * 180 / pi, i + 180.0);
        double want = exact_highlight(RK_SHADING_PHONG, false, 1, up, l, v);
        double got = pow((double)highlight(RK_SHADING_PHONG, (float)s, l, v), 1 / s);
        rk_check(
            fabs(got - want) <= 2 * few_roundings,
            "shininess %g, %g before a right angle: got the power of %.7g, want of %.7g within "
            "%.2g: no epsilon ends the highlight earlier",
            s, short_of_right, got, want, 2 * few_roundings);
    }
}

static void blinn_phong_highlights_end_at_a_right_angle_too(void **state)
{
    (void)state;
    /* h is at 80 degrees to the side of the light. */
    rk_vec3 l = direction(70, 180), v = direction(90, 180);
    double cosine = cos(80 * pi / 180);
    rk_check_close(highlight(RK_SHADING_BLINN_PHONG, 2, l, v), cosine * cosine, few_roundings,
                   "up to a right angle there is a highlight");
    /* Viewers below the surface: one opposite to the light, and one beyond, where n.h is negative.
     */
    v = direction(120, 0);
    rk_check_close(highlight(RK_SHADING_BLINN_PHONG, 2, l, v), 0, 0, "max(0, n.h)");
    rk_check_close(highlight(RK_SHADING_BLINN_PHONG, 0, l, v), 0, 0, "this holds for s = 0 too");
    v = rk_negate(l);
    rk_check_close(highlight(RK_SHADING_BLINN_PHONG, 2, l, v), 0, 0,
                   "l + v is zero: there is no half vector");
    /* l + v = (1, 0, 0) exactly. */
    l = rk_vec(0.5f, 0, 0.8660254f), v = rk_vec(0.5f, 0, -0.8660254f);
    const float shininess[] = {0, 0x1p-149f, 1e-6f, 1, 2, 3, 1e5f};
    for (int i = 0; i < 7; i++)
        rk_check_close(highlight(RK_SHADING_BLINN_PHONG, shininess[i], l, v), 0, 0,
                       "n.h is exactly 0 at a right angle, and no power of it is a highlight");
}

static void without_shininess_the_highlight_is_constant(void **state)
{
    (void)state;
    for (int degrees = -50; degrees < 90; degrees += 10) {
        rk_vec3 l = direction(30, 180), v = direction(degrees, 0);
        const char *hint = "a positive cosine to the power of 0 is one";
        rk_check_close(highlight(RK_SHADING_PHONG, 0, l, v), 1, 0, hint);
        rk_check_close(highlight(RK_SHADING_BLINN_PHONG, 0, l, v), 1, 0, hint);
    }
}

static void a_highlight_has_the_specular_colour_however_faint(void **state)
{
    (void)state;
    /* In the mirror direction the lobe is one. */
    rk_vec3 l = direction(60, 180), v = direction(60, 0);
    const rk_vec3 colours[] = {{1, 0, 0},          {0, 1, 0},         {0, 0, 1},
                               {0, 1, 0.5f},       {3e-4f, 0, 0},     {0, 1e-6f, 0},
                               {1e-4f, 0, 1e-20f}, {0x1p-126f, 0, 0}, {0, 0, 1e-30f}};
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (size_t i = 0; i < sizeof colours / sizeof *colours; i++) {
            rk_shading shading = shading_of((rk_shading_model)model, false);
            rk_vec3 ks = colours[i], got = rk_shade(&shading, black, ks, 5, up, l, v, white);
            for (int k = 0; k < 3; k++)
                rk_check(
                    fabsf(rk_axis(got, k) - rk_axis(ks, k)) <=
                        8 * (float)few_roundings * rk_axis(ks, k),
                    "%s, ks = (%g, %g, %g), in the mirror direction of white light: got %g in %s, "
                    "want %g: only ks = (0, 0, 0) has no highlight",
                    model_names[model], (double)ks.x, (double)ks.y, (double)ks.z,
                    (double)rk_axis(got, k),
                    k == 0   ? "red"
                    : k == 1 ? "green"
                             : "blue",
                    (double)rk_axis(ks, k));
        }
}

/* Each channel has its own mistakes. */
static void check_sum(rk_vec3 got, rk_vec3 kd, rk_vec3 ks, rk_vec3 light, float cosine)
{
    for (int k = 0; k < 3; k++) {
        const double d = (double)rk_axis(kd, k), s = (double)rk_axis(ks, k),
                     i = (double)rk_axis(light, k), c = (double)cosine;
        rk_check_near_or(
            rk_axis(got, k), i * (d * c + s), 8 * few_roundings,
            RK_MISTAKES({i * d * c + s, "the highlight is not multiplied by the light"},
                        {d * c + i * s, "the diffuse part is not multiplied by the light"},
                        {i * (d * c + s * c), "the classic lobe is multiplied by n.l"},
                        {i * (d * c + d * s), "the highlight is multiplied by kd as well"},
                        {i * (d + s), "the diffuse part is not multiplied by n.l"}),
            "channel %d: I (kd n.l + ks lobe), with I = %g, kd = %g, n.l = 0.5, ks = %g, lobe = 1: "
            "the light times both parts; the classic lobe has no factor n.l",
            k, i, d, s);
    }
}

static void diffuse_part_and_highlight_add_up(void **state)
{
    (void)state;
    /* n.l = 1/2, and the viewer is in the mirror direction. */
    rk_vec3 l = direction(60, 180), v = direction(60, 0);
    rk_vec3 kd = rk_vec(0.5f, 0, 0.25f), ks = rk_vec(0, 0.25f, 0.5f), light = rk_vec(2, 4, 8);
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
        rk_shading shading = shading_of((rk_shading_model)model, false);
        check_sum(rk_shade(&shading, kd, ks, 5, up, l, v, light), kd, ks, light, 0.5f);
    }
}

static void without_specular_colour_every_model_is_lambert(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 l = random_direction(i, 0), v = random_direction(i, 1), n = random_direction(i, 2);
        rk_vec3 kd = random_colour(i, 0), light = random_colour(i, 1);
        rk_shading lambert = shading_of(RK_SHADING_LAMBERT, i & 1);
        rk_vec3 want = rk_shade(&lambert, kd, white, 3, n, l, v, light);
        rk_check(equal_bits(want, rk_shade(&lambert, kd, white, NAN, n, l, black, light)),
                 "lambert without shininess and viewer is not the same: it reads neither");
        check_colour(want,
                     rk_scale(rk_mul(kd, light), rk_max(0, rk_dot(n, l)) / (i & 1 ? (float)pi : 1)),
                     few_roundings, "Lambert: I kd n.l, divided by pi if normalized");
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
            rk_shading shading = shading_of((rk_shading_model)model, i & 1);
            rk_vec3 none = i & 2 ? rk_vec(NAN, NAN, NAN) : black;
            rk_vec3 got = rk_shade(&shading, kd, black, NAN, n, l, i & 4 ? v : none, light);
            rk_check(equal_bits(got, want),
                     "%s with ks = 0, and a shininess and perhaps a viewer that are no numbers: "
                     "got %.9g, Lambert has "
                     "%.9g: without ks, compute no highlight",
                     model_names[model], (double)got.x, (double)want.x);
        }
    }
}

static void twice_the_light_is_twice_the_colour(void **state)
{
    (void)state;
    /* Multiplying by these is exact. */
    const float powers[] = {0, 0x1p-60f, 0.5f, 2, 0x1p60f};
    for (uint32_t i = 0; i < 1000; i++)
        for (int model = RK_SHADING_OFF; model <= RK_SHADING_GRADIENT; model++) {
            rk_vec3 l = random_direction(i, 3), v = random_direction(i, 4);
            rk_vec3 kd = random_colour(i, 2), ks = random_colour(i, 3), light = random_colour(i, 4);
            rk_vec3 more = {powers[i % 5], powers[i / 5 % 5], powers[i / 25 % 5]};
            rk_shading shading = shading_of((rk_shading_model)model, i & 1);
            if (model != RK_SHADING_GRADIENT)
                shading.gradient.count = UINT32_MAX; /* only the gradient reads its stops */
            rk_vec3 once = rk_shade(&shading, kd, ks, 2, up, l, v, light);
            rk_vec3 scaled = rk_shade(&shading, kd, ks, 2, up, l, v, rk_mul(light, more));
            rk_vec3 want = rk_mul(once, more);
            rk_check(scaled.x == want.x && scaled.y == want.y && scaled.z == want.z,
                     "%s: got (%.9g, %.9g, %.9g) for the light and (%.9g, %.9g, %.9g) for (%g, %g, "
                     "%g) times the light: each channel grows with the light's, exactly for powers "
                     "of two, and with no other",
                     model_names[model], (double)once.x, (double)once.y, (double)once.z,
                     (double)scaled.x, (double)scaled.y, (double)scaled.z, (double)more.x,
                     (double)more.y, (double)more.z);
        }
}

/* --- The gradient --------------------------------------------------------------------------- */

static void a_gradient_is_linear_between_its_stops(void **state)
{
    (void)state;
    const rk_gradient gradient = {3, {{-1, {0, 0, 1}}, {0, {1, 0, 0}}, {0.5f, {0, 1, 0}}}};
    const char *hint = "linear between two neighbouring stops";
    check_colour(rk_gradient_at(&gradient, -1), rk_vec(0, 0, 1), 0, hint);
    check_colour(rk_gradient_at(&gradient, -0.75f), rk_vec(0.25f, 0, 0.75f), 0, hint);
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(1, 0, 0), 0, hint);
    check_colour(rk_gradient_at(&gradient, 0.125f), rk_vec(0.75f, 0.25f, 0), 0, hint);
    check_colour(rk_gradient_at(&gradient, 0.5f), rk_vec(0, 1, 0), 0, hint);
    for (int e = -120; e <= 127; e++) {
        float end = ldexpf(1, e);
        const rk_gradient wide = {2, {{-end, {0, 0, 1}}, {end, {1, 0, 0}}}};
        check_colour(rk_gradient_at(&wide, 0), rk_vec(0.5f, 0, 0.5f), few_roundings,
                     "linear however close or far apart the stops are, 2^-119 to 2^128: halfway");
        check_colour(rk_gradient_at(&wide, end / 2), rk_vec(0.75f, 0, 0.25f), few_roundings,
                     "linear however close or far apart the stops are, 2^-119 to 2^128: at 3/4");
    }
    const rk_gradient bright = {2, {{0, {0, 8, 1e20f}}, {1, {16, 0, 3e20f}}}};
    check_relative(rk_gradient_at(&bright, 0.5f), rk_vec(8, 4, 2e20f),
                   "linear between colours brighter than white, too");
    const rk_gradient far_apart = {2, {{0, {3e38f, -3e38f, 0}}, {1, {-3e38f, 3e38f, 3e38f}}}};
    for (int k = 0; k <= 4; k++) {
        const double part = k / 4.0, want = 3e38 * (1 - 2 * part);
        rk_vec3 got = rk_gradient_at(&far_apart, (float)part);
        rk_check(
            fabs((double)got.x - want) <= 3e38 * few_roundings &&
                fabs((double)got.y + want) <= 3e38 * few_roundings,
            "stops of 3e38 and -3e38, at %g: got %g and %g, want %g and %g: their difference is "
            "no float",
            part, (double)got.x, (double)got.y, want, -want);
    }
    /* Four floats apart. */
    const rk_gradient narrow = {2, {{0.5f, {0, 0, 1}}, {0.5f + 0x1p-22f, {1, 0, 0}}}};
    check_colour(rk_gradient_at(&narrow, 0.5f + 0x1p-23f), rk_vec(0.5f, 0, 0.5f), 0, hint);
    const float least = 0x1p-149f; /* half of it is 0 */
    for (int apart = 1; apart <= 4; apart += 3) {
        const rk_gradient tiny = {2, {{0, {0, 0, 1}}, {(float)apart * least, {1, 0, 0}}}};
        for (int i = 0; i <= apart; i++) {
            float part = (float)i / (float)apart;
            check_colour(rk_gradient_at(&tiny, (float)i * least), rk_vec(part, 0, 1 - part), 0,
                         "stops at 0 and at the smallest floats, whose halves may be equal");
        }
    }
}

static void a_gradient_is_read_at_each_call(void **state)
{
    (void)state;
    rk_gradient gradient = {2, {{-1, {0, 0, 1}}, {1, {1, 0, 0}}, {0, {0, 1, 0}}}};
    rk_gradient unsorted = {3, {{1, {1, 0, 0}}, {-1, {0, 0, 1}}, {0, {0, 1, 0}}}};
    const rk_gradient *constant = rk_read_only(&unsorted, sizeof unsorted, "gradient");
    check_colour(rk_gradient_at(constant, 0.5f), rk_vec(0.5f, 0.5f, 0), 0, "stops in any order");
    rk_read_only_free();
    const char *hint = "the same gradient in memory, changed between two calls";
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0.5f, 0, 0.5f), 0, hint);
    gradient.stops[1].colour = rk_vec(0, 1, 0);
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0, 0.5f, 0.5f), 0, hint);
    gradient.stops[1].at = 3;
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0, 0.25f, 0.75f), 0, hint);
    gradient.count = 3;
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0, 1, 0), 0, hint);
    gradient.stops[2].at = 5;
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0, 0.25f, 0.75f), 0, hint);
    gradient.stops[0].colour = rk_vec(1, 0, 1);
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0.75f, 0.25f, 0.75f), 0, hint);
    check_colour(rk_gradient_at(&gradient, 1), rk_vec(0.5f, 0.5f, 0.5f), 0,
                 "the same gradient, at another place");
    const rk_gradient other = {2, {{-1, {1, 1, 1}}, {1, {0, 0, 0}}}};
    check_colour(rk_gradient_at(&other, 1), black, 0, "another gradient, at the same place");
    check_colour(rk_gradient_at(&gradient, 1), rk_vec(0.5f, 0.5f, 0.5f), 0,
                 "and the first one again");
}

static void the_default_gradient_runs_from_blue_to_orange(void **state)
{
    (void)state;
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    rk_vec3 blue = rk_gradient_at(&gradient, -1), orange = rk_gradient_at(&gradient, 1);
    rk_check(blue.z > blue.x && blue.z > blue.y, "at -1: got (%g, %g, %g), want blue",
             (double)blue.x, (double)blue.y, (double)blue.z);
    rk_check(orange.x > orange.y && orange.y > orange.z, "at 1: got (%g, %g, %g), want orange",
             (double)orange.x, (double)orange.y, (double)orange.z);
    rk_vec3 before = blue;
    for (int i = -7; i <= 8; i++) {
        rk_vec3 here = rk_gradient_at(&gradient, (float)i / 8);
        rk_check(here.x > before.x && here.z < before.z,
                 "from %g to %g: red from %g to %g, blue from %g to %g: want the one to rise and "
                 "the other to fall all the way from -1 to 1",
                 (i - 1) / 8.0, i / 8.0, (double)before.x, (double)here.x, (double)before.z,
                 (double)here.z);
        rk_check(here.x >= 0 && here.x <= 1 && here.y >= 0 && here.y <= 1 && here.z >= 0,
                 "at %g: got (%g, %g, %g), want colours in [0, 1]", i / 8.0, (double)here.x,
                 (double)here.y, (double)here.z);
        before = here;
    }
    check_colour(rk_gradient_at(&gradient, -2), blue, few_roundings,
                 "the first stop is at n.l = -1, and below it the colour stays");
    check_colour(rk_gradient_at(&gradient, 2), orange, few_roundings,
                 "the last stop is at n.l = 1, and above it the colour stays");
}

static void beyond_its_end_stops_a_gradient_is_constant(void **state)
{
    (void)state;
    const rk_gradient gradient = {2, {{-0.5f, {1, 0, 0}}, {0.5f, {0, 1, 0}}}};
    const char *hint = "the colour of the end stop, not the line continued";
    check_colour(rk_gradient_at(&gradient, -0.75f), rk_vec(1, 0, 0), 0, hint);
    check_colour(rk_gradient_at(&gradient, 0.75f), rk_vec(0, 1, 0), 0, hint);
    check_colour(rk_gradient_at(&gradient, -INFINITY), rk_vec(1, 0, 0), 0, hint);
    check_colour(rk_gradient_at(&gradient, INFINITY), rk_vec(0, 1, 0), 0, hint);
    /* Rounding may make a unit vector's product with itself this large. */
    const rk_gradient whole = {2, {{-1, {1, 0, 0}}, {1, {0, 1, 0}}}};
    check_colour(rk_gradient_at(&whole, 1 + 0x1p-22f), rk_vec(0, 1, 0), 0, hint);
}

static void stops_may_come_in_any_order(void **state)
{
    (void)state;
    const rk_gradient_stop sorted[4] = {
        {-1, {0, 0, 1}}, {-0.25f, {1, 0, 0}}, {0.25f, {0, 1, 0}}, {1, {1, 1, 1}}};
    const rk_gradient want = {4, {sorted[0], sorted[1], sorted[2], sorted[3]}};
    for (int order = 0; order < 256; order++) {
        int place[4] = {order & 3, order >> 2 & 3, order >> 4 & 3, order >> 6};
        if ((1 << place[0] | 1 << place[1] | 1 << place[2] | 1 << place[3]) != 15)
            continue;
        rk_gradient gradient = {
            4, {sorted[place[0]], sorted[place[1]], sorted[place[2]], sorted[place[3]]}};
        const rk_gradient same = gradient;
        for (float x = -1.125f; x <= 1.125f; x += 0.0625f) {
            rk_vec3 got = rk_gradient_at(&gradient, x), expected = rk_gradient_at(&want, x);
            rk_check(equal_bits(got, expected),
                     "stops %d %d %d %d, x = %g: got (%g, %g, %g), in order (%g, %g, %g): take the "
                     "neighbours in x, not in the list",
                     place[0], place[1], place[2], place[3], (double)x, (double)got.x,
                     (double)got.y, (double)got.z, (double)expected.x, (double)expected.y,
                     (double)expected.z);
            rk_check(memcmp(&gradient, &same, sizeof gradient) == 0,
                     "stops %d %d %d %d, x = %g: the caller's gradient was changed, its first stop "
                     "from %g to %g: it is constant, and other threads read it",
                     place[0], place[1], place[2], place[3], (double)x, (double)same.stops[0].at,
                     (double)gradient.stops[0].at);
        }
    }
    check_colour(rk_gradient_at(&want, 0), rk_vec(0.5f, 0.5f, 0), 0, "halfway");
}

static void as_many_stops_as_there_is_room_for_all_count(void **state)
{
    (void)state;
    /* Grey, and as bright as x; in the list from the last to the first, too. */
    for (uint32_t reversed = 0; reversed < 2; reversed++) {
        rk_gradient gradient = {.count = RK_GRADIENT_STOPS_MAX};
        for (uint32_t i = 0; i < RK_GRADIENT_STOPS_MAX; i++) {
            float at = (float)i / 8 - 1;
            gradient.stops[reversed ? RK_GRADIENT_STOPS_MAX - 1 - i : i] =
                (rk_gradient_stop){at, {at, at, at}};
        }
        for (float x = -1; x <= 0.875f; x += 0.0625f)
            check_colour(
                rk_gradient_at(&gradient, x), rk_vec(x, x, x), 0,
                "a gradient may have RK_GRADIENT_STOPS_MAX stops, and each of them counts");
    }
}

static void stops_at_one_place_make_a_step(void **state)
{
    (void)state;
    const rk_gradient gradient = {
        5, {{1, {1, 1, 1}}, {0, {1, 0, 0}}, {0, {0, 0, 1}}, {0, {0, 1, 0}}, {-1, {0, 0, 0}}}};
    check_colour(rk_gradient_at(&gradient, -0.5f), rk_vec(0.5f, 0, 0), 0,
                 "below the step: linear up to the first of them");
    check_colour(rk_gradient_at(&gradient, -0x1p-20f), rk_vec(1, 0, 0), 0x1p-19,
                 "just below the step: the first of them");
    check_colour(rk_gradient_at(&gradient, 0), rk_vec(0, 1, 0), 0, "at the step: the last of them");
    check_colour(rk_gradient_at(&gradient, 0.5f), rk_vec(0.5f, 1, 0.5f), 0,
                 "above the step: linear from the last of them on");
    for (uint32_t n = 1; n <= RK_GRADIENT_STOPS_MAX; n++) { /* any number at one place */
        rk_gradient many = {n, {{0, {0, 0, 0}}}};
        for (uint32_t i = 0; i < n; i++)
            many.stops[i].colour = rk_vec((float)i, 1, 0);
        check_colour(rk_gradient_at(&many, 0), rk_vec((float)(n - 1), 1, 0), 0,
                     "1 to 16 stops at 0, their red 0, 1, 2 ...: at the step, the last of them");
        check_colour(
            rk_gradient_at(&many, -1), rk_vec(0, 1, 0), 0,
            "1 to 16 stops at 0, their red 0, 1, 2 ...: below the step, the first of them");
    }
    const rk_gradient zeros = {2, {{0, {1, 0, 0}}, {-0.0f, {0, 1, 0}}}};
    check_colour(rk_gradient_at(&zeros, 0), rk_vec(0, 1, 0), 0, "0 and -0 are one place");
    check_colour(rk_gradient_at(&zeros, -0.0f), rk_vec(0, 1, 0), 0, "0 and -0 are one place");
    const rk_gradient ends = {4,
                              {{-1, {1, 0, 0}}, {-1, {0, 1, 0}}, {1, {0, 0, 1}}, {1, {1, 1, 1}}}};
    check_colour(rk_gradient_at(&ends, -2), rk_vec(1, 0, 0), 0,
                 "below all: the first of the lowest");
    check_colour(rk_gradient_at(&ends, 2), rk_vec(1, 1, 1), 0,
                 "above all: the last of the highest");
    /* Red before green at one place; a stop below and one above it anywhere in the list. */
    for (uint32_t low = 0; low < 4; low++)
        for (uint32_t high = 0; high < 4; high++) {
            if (low == high)
                continue;
            rk_gradient step = {.count = 4};
            rk_gradient_stop pair[] = {{0.5f, {1, 0, 0}}, {0.5f, {0, 1, 0}}}, *next = pair;
            for (uint32_t i = 0; i < 4; i++)
                step.stops[i] = i == low    ? (rk_gradient_stop){0, {0, 0, 0}}
                                : i == high ? (rk_gradient_stop){1, {1, 1, 1}}
                                            : *next++;
            check_colour(rk_gradient_at(&step, 0.25f), rk_vec(0.5f, 0, 0), 0,
                         "below the step the first of them in the list counts, wherever in the "
                         "list lower and higher stops are");
            check_colour(rk_gradient_at(&step, 0.5f), rk_vec(0, 1, 0), 0,
                         "at the step the last of them in the list counts, wherever in the list "
                         "lower and higher stops are");
        }
}

static void one_stop_is_one_colour_and_none_is_black(void **state)
{
    (void)state;
    const rk_gradient one = {1, {{0.25f, {0.5f, 0.25f, 1}}}}, none = {0, {{0, {0, 1, 0}}}};
    for (float x = -1; x <= 1; x += 0.25f) {
        check_colour(rk_gradient_at(&one, x), rk_vec(0.5f, 0.25f, 1), 0,
                     "there is only one colour");
        check_colour(rk_gradient_at(&none, x), black, 0,
                     "no stops, no light: with a count of 0, stops[0] is not read");
        rk_shading shading = {RK_SHADING_GRADIENT, false, none};
        check_colour(rk_shade(&shading, white, white, 5, up, at_cosine(x, 1), up, white), black, 0,
                     "no stops, no light, by rk_shade, too");
    }
}

static void a_gradient_also_colours_surfaces_that_face_away(void **state)
{
    (void)state;
    rk_shading shading = {RK_SHADING_GRADIENT, false, {2, {{-1, {0, 0.5f, 1}}, {1, {1, 0.5f, 0}}}}};
    for (int normalized = 0; normalized < 2; normalized++)
        for (int degrees = 0; degrees <= 180; degrees += 15) {
            shading.normalized = normalized;
            float blend = (float)(0.5 + 0.5 * cos(degrees * pi / 180));
            for (uint32_t turns = 0; turns < 6; turns++) {
                rk_vec3 n = turned(up, turns), l = turned(direction(degrees, 70), turns);
                rk_vec3 v = turns & 1 ? n : black, light = {0.5f, 1, 0.25f};
                rk_vec3 kd = turns & 2 ? white : black, ks = turns & 4 ? black : white;
                rk_vec3 got = rk_shade(&shading, kd, ks, 5, n, l, v, light);
                check_colour(got, rk_vec(0.5f * blend, 0.5f, 0.25f * (1 - blend)), few_roundings,
                             "I gradient(n.l), n.l in [-1, 1], whatever kd, ks and v are");
            }
        }
}

/* --- In double precision -------------------------------------------------------------------- */

/* A power multiplies the roundings of a cosine by its exponent. */
static double power_tolerance(double s)
{
    return few_roundings * (1 + s);
}

/* There is a better way. Unit vectors at distance d have 1 - cos = d^2 / 2. Computed from their
 * difference, whose components are off by some roundings, its error is d times roundings, and the
 * error of the power, about p = exp(-s d^2 / 2), is p s d times roundings: at most sqrt(s / e),
 * where s d^2 = 1. */
static double highlight_tolerance(double s)
{
    return few_roundings * (1 + sqrt(s));
}

static void check_highlights(bool normalized, double s, double tolerance_of_one, uint32_t seed)
{
    /* Viewers around the mirror direction, from the lobe's middle to where it has vanished. */
    double spread = 6 / sqrt(s + 1) * 180 / pi;
    for (uint32_t i = 0; i < 2000; i++) {
        double theta = 89 * (double)rk_unit_float(rk_case(seed, i, 0, 3));
        double around = 360 * (double)rk_unit_float(rk_case(seed, i, 1, 3));
        rk_vec3 l = direction(theta, around);
        rk_vec3 v = direction(
            theta + spread * (2 * (double)rk_unit_float(rk_case(seed, i, 2, 3)) - 1), around + 180);
        rk_vec3 n = turned(up, i);
        l = turned(l, i), v = turned(v, i);
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
            rk_shading shading = shading_of((rk_shading_model)model, normalized);
            double want = exact_highlight((rk_shading_model)model, normalized, s, n, l, v);
            double largest =
                normalized ? exact_highlight((rk_shading_model)model, true, s, up, up, up) : 1;
            /* For nearly opposite directions, roundings are large compared with their sum. */
            float sum = model == RK_SHADING_PHONG ? 1 : rk_length(rk_add(l, v));
            double tolerance = tolerance_of_one * largest / (double)rk_min(sum, 1);
            double got = (double)rk_shade(&shading, black, white, (float)s, n, l, v, white).x;
            rk_check(
                fabs(got - want) <= tolerance,
                "%s%s, shininess %g, normal (%g, %g, %g), light at %.3f degrees from it: got %.9g, "
                "want %.9g within %.3g: %s",
                model_names[model], normalized ? ", normalized" : "", s, (double)n.x, (double)n.y,
                (double)n.z, theta, got, want, tolerance,
                !normalized ? "the lobe's power"
                            : "the lobe times n.l, and times its model's factor N");
        }
    }
}

/* Cosines whose power of s is e^-2 to e^-80; the smallest float with all of its digits is e^-87.
 */
static void check_faint_highlights(bool normalized, double s)
{
    for (int faint = 2; faint <= 80; faint += 2)
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
            /* The viewer is where the light is: h = l, and r is twice as far from v as `up` is. */
            double angle = acos(exp(-faint / s)) * 180 / pi;
            rk_vec3 l = direction(model == RK_SHADING_PHONG ? angle / 2 : angle, 20);
            rk_shading shading = shading_of((rk_shading_model)model, normalized);
            double got = (double)rk_shade(&shading, black, white, (float)s, up, l, l, white).x;
            double want = exact_highlight((rk_shading_model)model, normalized, s, up, l, l);
            /* A cosine of 0.2 or more is off by some roundings of order one, its power relatively
             * by 50 times as much. */
            rk_check(fabs(got - want) <= s / 0.2 * few_roundings * want,
                     "%s, shininess %g: got %.9g, want %.9g: however faint, a strong light makes "
                     "the lobe visible",
                     model_names[model], s, got, want);
        }
}

static void highlights_agree_with_double_precision(void **state)
{
    (void)state;
    const double shininess[] = {0, 1, 1.5, 2, 7, 10, 50};
    for (uint32_t i = 0; i < sizeof shininess / sizeof shininess[0]; i++)
        check_highlights(false, shininess[i], power_tolerance(shininess[i]), i);
    check_faint_highlights(false, 50);
    check_faint_highlights(false, 2000);
}

static void normalized_highlights_agree_with_double_precision(void **state)
{
    (void)state;
    const double shininess[] = {0, 1, 1.5, 2, 7, 10, 50};
    for (uint32_t i = 0; i < sizeof shininess / sizeof shininess[0]; i++)
        check_highlights(true, shininess[i], power_tolerance(shininess[i]), i);
    check_faint_highlights(true, 50);
    for (int i = 0; i < grazing_count; i++)
        for (int model = RK_SHADING_LAMBERT; model <= RK_SHADING_BLINN_PHONG; model++) {
            rk_shading shading = shading_of((rk_shading_model)model, true);
            rk_vec3 l = at_cosine(grazing[i], 1), v = at_cosine(grazing[i], -1);
            double lobe = model == RK_SHADING_LAMBERT
                              ? 0
                              : exact_highlight((rk_shading_model)model, true, 1, up, up, up);
            float want = (float)((1 / pi + lobe) * (double)grazing[i]);
            check_relative(rk_shade(&shading, white, white, 1, up, l, v, white),
                           rk_scale(white, want),
                           "normalized, in the mirror direction: I (kd / pi + ks N) n.l, however "
                           "small n.l is");
        }
}

/* --- Nothing is remembered ------------------------------------------------------------------ */

typedef struct inputs {
    rk_shading shading;
    rk_vec3 kd, ks, n, l, v, light;
    float s;
} inputs;

/* One number: of the first channel. */
static double exact_red(const inputs *in)
{
    double light = (double)in->light.x, kd = (double)in->kd.x, ks = (double)in->ks.x;
    double cos_i = rk_ddot(exact(in->n), exact(in->l));
    bool normalized = in->shading.normalized;
    if (in->shading.model == RK_SHADING_OFF)
        return light * kd;
    if (in->shading.model == RK_SHADING_GRADIENT) /* of one stop */
        return light * (double)in->shading.gradient.stops[0].colour.x;
    double diffuse = kd * cos_i / (normalized ? pi : 1);
    return light * (in->shading.model == RK_SHADING_LAMBERT
                        ? diffuse
                        : diffuse + ks * exact_highlight(in->shading.model, normalized,
                                                         (double)in->s, in->n, in->l, in->v));
}

static void each_input_counts_at_each_call(void **state)
{
    (void)state;
    const char *const changed[] = {"nothing", "normalized", "the gradient", "kd",    "ks", "n",
                                   "l",       "v",          "the light",    "model", "s"};
    for (int model = RK_SHADING_OFF; model <= RK_SHADING_GRADIENT; model++)
        for (int k = 0; k < 2 * 11; k++) {
            inputs in = {shading_of((rk_shading_model)model, false),
                         {0.5f, 0.5f, 0.5f},
                         {0.25f, 0.25f, 0.25f},
                         up,
                         direction(50, 0),
                         direction(40, 180),
                         white,
                         4};
            int change = k % 2 ? k / 2 : 0; /* and back */
            in.shading.normalized = change == 1;
            in.shading.gradient.stops[0].colour.x = change == 2 ? 0.75f : 0.5f;
            in.kd.x = change == 3 ? 0.75f : 0.5f;
            in.ks.x = change == 4 ? 0.75f : 0.25f;
            in.n = change == 5 ? direction(10, 30) : in.n;
            in.l = change == 6 ? direction(30, 0) : in.l;
            in.v = change == 7 ? direction(20, 180) : in.v;
            in.light.x = change == 8 ? 0.5f : 1;
            if (change == 9)
                in.shading.model = (rk_shading_model)((model + 1) % 5);
            in.s = change == 10 ? 8 : 4;
            double got =
                (double)rk_shade(&in.shading, in.kd, in.ks, in.s, in.n, in.l, in.v, in.light).x;
            rk_check_near(got, exact_red(&in), 4 * power_tolerance(8),
                          "%s, different from the call before: %s", model_names[in.shading.model],
                          changed[k / 2]);
        }
}

/* Far sharper ones, with vectors whose difference is exact: x^2 / 2 short of 1 for Phong, a quarter
 * of that for the half vector. */
static void check_needles(void)
{
    const double sharpness[] = {1e8, 1e8, 1e12, 1e12}, x[] = {0x1p-13, 0x1p-14, 0x1p-20, 0x1p-21};
    for (int i = 0; i < 4; i++)
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
            double short_of_one = x[i] * x[i] / (model == RK_SHADING_PHONG ? 2 : 8);
            double s = (double)(float)sharpness[i], want = exp(s * log1p(-short_of_one));
            rk_vec3 v = rk_vec((float)x[i], 0, 1);
            double got = (double)highlight((rk_shading_model)model, (float)s, up, v);
            rk_check(fabs(got - want) <= 8 * few_roundings,
                     "%s, shininess %g, %g from the mirror direction: got %.7g, want %.7g: the "
                     "shininess has no limit",
                     model_names[model], s, x[i], got, want);
        }
}

/* Here a power of a float dot product is off by 1e-2. */
static void the_sharpest_highlights_keep_three_digits(void **state)
{
    (void)state;
    const double shininess[] = {1e3, 1e4, 1e5, 1e6};
    for (uint32_t i = 0; i < sizeof shininess / sizeof shininess[0]; i++)
        check_highlights(false, shininess[i], highlight_tolerance(shininess[i]), 100 + i);
    rk_check(highlight_tolerance(1e6) < 1e-3, "the tolerance is too large for three digits");
    check_needles();
}

/* --- Energy --------------------------------------------------------------------------------- */

/* The fraction of uniform light from all sides that is reflected to v: a white furnace. The
 * integral over l becomes one over directions (u, phi) around an axis in which the lobe is u^s: for
 * Phong l itself around the mirror direction of v, for Blinn-Phong the half vector around the
 * normal, where dl = 4 (v.h) dh. With w = u^(s + 1), du = dw / ((s + 1) u^s), the integrand is
 * smooth, apart from a kink at the horizon, and of the same size for any shininess: the midpoint
 * rule on 96 x 64 cells is off by less than 5e-4 (checked with a hundred times as many cells). */
static const double furnace_error = 5e-4;

static double furnace(const rk_shading *shading, double s, double degrees)
{
    const int rings = 96, sectors = 32; /* of half a turn */
    rk_vec3 v = direction(degrees, 0);
    rk_dvec3 to_viewer = exact(v), axis = {-to_viewer.x, 0, to_viewer.z};
    if (shading->model != RK_SHADING_PHONG)
        axis = (rk_dvec3){0, 0, 1};
    rk_dvec3 side = {axis.z, 0, -axis.x};
    double sum = 0;
    for (int ring = 0; ring < rings; ring++) {
        double u = pow((ring + 0.5) / rings, 1 / (s + 1)), across = sqrt(1 - u * u);
        for (int sector = 0; sector < sectors; sector++) {
            /* Both sides of the viewer's plane reflect the same: each ring is on one. */
            double phi = pi * (sector + 0.5) / sectors, weight = pow(u, -s);
            phi = ring % 2 ? -phi : phi;
            rk_dvec3 l = rk_dmadd(rk_dscale(axis, u), side, across * cos(phi));
            l.y += across * sin(phi);
            if (shading->model != RK_SHADING_PHONG) {
                double v_h = rk_ddot(to_viewer, l);
                weight *= v_h > 0 ? 4 * v_h : 0;
                l = rk_dmadd(rk_dscale(l, 2 * v_h), to_viewer, -1);
            }
            rk_vec3 to_light = rk_vec((float)l.x, (float)l.y, (float)l.z);
            rk_vec3 got = rk_shade(shading, black, white, (float)s, up, to_light, v, white);
            sum += (double)got.x * weight;
        }
    }
    return sum / (s + 1) / rings * 2 * pi / sectors;
}

static const double furnace_shininess[] = {1, 2, 5, 10, 30, 100, 1e3, 1e4, 1e5};

/* In the mirror direction of light that grazes the surface, however sharp the lobe. */
static void check_grazing_lobes(void)
{
    const float shininess[] = {1, 100, 1e4f, 1e6f, 1e8f};
    for (int k = 0; k < 5 * grazing_count; k++)
        for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
            const float s = shininess[k / grazing_count], z = grazing[k % grazing_count];
            const rk_shading shading = shading_of((rk_shading_model)model, true);
            rk_vec3 l = at_cosine(z, -1), v = at_cosine(z, 1);
            double want =
                exact_highlight((rk_shading_model)model, true, (double)s, up, up, up) * (double)z;
            double got = (double)rk_shade(&shading, black, white, s, up, l, v, white).x;
            rk_check(fabs(got - want) <= 4 * few_roundings * want,
                     "%s, normalized, shininess %g, light at the cosine %g and its mirror "
                     "direction: got %.9g, want N n.l = %.9g: the lobe is 1 there",
                     model_names[model], (double)s, (double)z, got, want);
        }
}

static void normalized_highlights_reflect_all_light_along_the_normal(void **state)
{
    (void)state;
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (size_t i = 0; i < sizeof furnace_shininess / sizeof furnace_shininess[0]; i++) {
            rk_shading shading = shading_of((rk_shading_model)model, true);
            double s = furnace_shininess[i], got = furnace(&shading, s, 0);
            rk_check(fabs(got - 1) <= furnace_error + highlight_tolerance(s),
                     "%s, shininess %g: the lobe integrates to %.6f, want 1: multiply by n.l and "
                     "by this model's factor",
                     model_names[model], s, got);
        }
    check_grazing_lobes();
    const double any[] = {0, 1e-30, 1e-6, 0.5, 60, 250, 300, 1e6, 1e7, 1e10, 1e19, 1e30, 3.4e38};
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (size_t i = 0; i < sizeof any / sizeof *any; i++) {
            rk_shading shading = shading_of((rk_shading_model)model, true);
            double want = exact_highlight((rk_shading_model)model, true, any[i], up, up, up);
            double got =
                (double)rk_shade(&shading, black, white, (float)any[i], up, up, up, white).x;
            rk_check(fabs(got - want) <= 2 * few_roundings * want,
                     "%s, normalized, shininess %g, light and viewer along the normal: got %.9g, "
                     "want N = %.9g: any shininess from 0 up has its factor",
                     model_names[model], any[i], got, want);
        }
}

static void normalized_highlights_never_reflect_more_light_than_arrives(void **state)
{
    (void)state;
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (size_t i = 0; i < sizeof furnace_shininess / sizeof furnace_shininess[0]; i++)
            for (double degrees = 0; degrees < 90; degrees += 5.933) {
                rk_shading shading = shading_of((rk_shading_model)model, true);
                double s = furnace_shininess[i], got = furnace(&shading, s, degrees);
                rk_check(got <= 1 + furnace_error + highlight_tolerance(s),
                         "%s, shininess %g, viewer at %.1f degrees: the lobe integrates to %.6f, "
                         "want at most 1",
                         model_names[model], s, degrees, got);
                rk_check(got > 0, "%s, shininess %g, viewer at %.1f degrees: nothing is reflected",
                         model_names[model], s, degrees);
            }
}

static void normalized_diffuse_light_reflects_the_fraction_kd(void **state)
{
    (void)state;
    /* Cells of equal n.l^2 and equal angle around: the integral of a constant times n.l. */
    rk_shading shading = shading_of(RK_SHADING_LAMBERT, true);
    const int rings = 32;
    double sum = 0;
    for (int ring = 0; ring < rings; ring++) {
        double cos_i = sqrt((ring + 0.5) / rings);
        rk_vec3 l = direction(acos(cos_i) * 180 / pi, 25);
        sum +=
            (double)rk_shade(&shading, rk_vec(0.75f, 0, 0), black, 0, up, l, up, white).x / cos_i;
    }
    rk_check_close(sum / rings * pi, 0.75, 8 * few_roundings, "kd / pi integrates to kd");
}

static void swapping_light_and_viewer_changes_only_the_cosine(void **state)
{
    (void)state;
    for (int model = RK_SHADING_LAMBERT; model <= RK_SHADING_BLINN_PHONG; model++)
        for (uint32_t i = 0; i < 1000; i++) {
            rk_shading shading = shading_of((rk_shading_model)model, true);
            rk_vec3 l = random_direction(i, 5), v = random_direction(i, 6);
            rk_vec3 kd = random_colour(i, 5), ks = random_colour(i, 6);
            l.z = fabsf(l.z), v.z = fabsf(v.z);
            float s = (float)(i % 100);
            double there = (double)rk_shade(&shading, kd, ks, s, up, l, v, white).x * (double)v.z;
            double back = (double)rk_shade(&shading, kd, ks, s, up, v, l, white).x * (double)l.z;
            double largest = (double)(s + 2);
            rk_check(there > 0, "%s: nothing is reflected between two directions above the surface",
                     model_names[model]);
            rk_check(fabs(there - back) <= highlight_tolerance((double)s) * largest,
                     "%s, shininess %g: %.9g for (l, v), %.9g for (v, l): f(l, v) = f(v, l)",
                     model_names[model], (double)s, there, back);
        }
    /* Equal numbers count only if they are a highlight's. */
    rk_shading phong = shading_of(RK_SHADING_PHONG, true);
    rk_check(rk_shade(&phong, black, white, 99, up, up, up, white).x > 10,
             "got no normalized highlight of shininess 99 in the mirror direction");
}

/* --- Odd values ----------------------------------------------------------------------------- */

static void no_colour_is_nan(void **state)
{
    (void)state;
    const float shininess[] = {0, 0x1p-149f, 1e-30f, 0.5f, 1, 1e5f, 1e10f, 1e20f, 3.4e38f};
    const double angles[] = {0, 1e-30, 1e-5, 45, 89.99999, 90, 90.00001, 120, 179.99999, 180};
    for (int model = RK_SHADING_OFF; model <= RK_SHADING_GRADIENT; model++)
        for (size_t s = 0; s < sizeof shininess / sizeof shininess[0]; s++)
            for (uint32_t i = 0; i < 10 * 10 * 4; i++) {
                rk_shading shading = shading_of((rk_shading_model)model, i & 1);
                rk_vec3 l = direction(angles[i / 4 % 10], 0), v = direction(angles[i / 40], 180);
                rk_vec3 got =
                    rk_shade(&shading, white, i & 2 ? white : black, shininess[s], up, l, v, white);
                rk_check(isfinite(got.x) && got.x >= 0,
                         "%s%s, shininess %g, light at %g degrees, viewer at %g: got %g",
                         model_names[model], i & 1 ? ", normalized" : "", (double)shininess[s],
                         angles[i / 4 % 10], angles[i / 40], (double)got.x);
            }
    /* No colour counts as finite only if there are bright ones. */
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
        rk_shading shading = shading_of((rk_shading_model)model, true);
        float got = rk_shade(&shading, black, white, 1e5f, up, up, up, white).x;
        rk_check(got > 1000,
                 "%s, normalized, shininess 1e+05, in the mirror direction: got %g, want thousands",
                 model_names[model], (double)got);
    }
}

/* A cosine so small that a part of it is 0, under a light that is infinite times kd. */
static void check_grazing_light(void)
{
    const rk_vec3 l = rk_vec(1, 0, 0x1p-149f), v = direction(45, 0);
    for (int i = 0; i < 6; i++) {
        rk_shading shading = shading_of((rk_shading_model)(RK_SHADING_LAMBERT + i / 2), i & 1);
        rk_vec3 got =
            rk_shade(&shading, rk_vec(10, 10, 10), white, 5, up, l, v, rk_vec(3e38f, 3e38f, 3e38f));
        rk_check(got.x >= 0,
                 "%s%s, light of 3e38 with n.l = 2^-149, kd = 10: got %g, want 0 or more: multiply "
                 "kd by the cosine before the light",
                 model_names[RK_SHADING_LAMBERT + i / 2], i & 1 ? ", normalized" : "",
                 (double)got.x);
    }
}

static void no_colour_is_nan_though_products_overflow(void **state)
{
    (void)state;
    check_grazing_light();
    /* Of each three channels some are bright and some black; infinity times 0 would be NaN. */
    const float bright[] = {1e20f, 1e38f};
    const double angles[] = {0, 45, 89.99999, 90, 120};
    for (int model = RK_SHADING_OFF; model <= RK_SHADING_GRADIENT; model++)
        for (uint32_t i = 0; i < 5 * 5 * 2 * 2 * 8 * 2; i++) {
            bool normalized = i >= 5 * 5 * 2 * 2 * 8;
            float large = bright[i & 1];
            rk_vec3 ks = rk_vec(large, i & 4 ? large : 0, 0);
            rk_vec3 kd = rk_vec(i & 8 ? large : 0, 0, large);
            rk_vec3 light = i & 16 ? rk_vec(large, large, 0) : rk_vec(0, large, large);
            rk_vec3 l = direction(angles[i / 32 % 5], 0), v = direction(angles[i / 160 % 5], 180);
            rk_shading shading = shading_of((rk_shading_model)model, normalized);
            /* N is below 2 for the one, and 16,000 for the other, too much for the brightest. */
            float s = i & 2 || (normalized && large > 1e30f) ? 10 : 1e5f;
            rk_vec3 got = rk_shade(&shading, kd, ks, s, up, l, v, light);
            const bool is_negative = got.x < 0 || got.y < 0 || got.z < 0;
            rk_check(
                got.x >= 0 && got.y >= 0 && got.z >= 0,
                "%s, kd (%g, %g, %g), ks (%g, %g, %g), light (%g, %g, %g) at %g degrees, viewer "
                "at %g: got (%g, %g, %g), want %s",
                model_names[model], (double)kd.x, (double)kd.y, (double)kd.z, (double)ks.x,
                (double)ks.y, (double)ks.z, (double)light.x, (double)light.y, (double)light.z,
                angles[i / 32 % 5], angles[i / 160 % 5], (double)got.x, (double)got.y,
                (double)got.z,
                is_negative ? "no negative light: is the light behind the surface?"
                            : "no NaN: multiply ks by the lobe, which may be 0, before the light");
        }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(off_is_the_light_times_the_diffuse_colour),
    cmocka_unit_test(lambert_falls_with_the_cosine),
    cmocka_unit_test(light_from_behind_or_along_the_surface_gives_nothing),
    cmocka_unit_test(phong_is_the_cosine_from_the_mirror_direction_to_a_power),
    cmocka_unit_test(blinn_phong_highlights_end_at_a_right_angle_too),
    cmocka_unit_test(a_highlight_has_the_specular_colour_however_faint),
    cmocka_unit_test(as_many_stops_as_there_is_room_for_all_count),
    cmocka_unit_test(blinn_phong_is_the_cosine_from_the_normal_to_the_half_vector_to_a_power),
    cmocka_unit_test(in_the_mirror_direction_both_highlights_are_one),
    cmocka_unit_test(a_highlight_ends_at_a_right_angle),
    cmocka_unit_test(close_to_a_right_angle_the_cosine_keeps_its_digits),
    cmocka_unit_test(without_shininess_the_highlight_is_constant),
    cmocka_unit_test(diffuse_part_and_highlight_add_up),
    cmocka_unit_test(without_specular_colour_every_model_is_lambert),
    cmocka_unit_test(twice_the_light_is_twice_the_colour),
    cmocka_unit_test(a_gradient_is_linear_between_its_stops),
    cmocka_unit_test(a_gradient_is_read_at_each_call),
    cmocka_unit_test(the_default_gradient_runs_from_blue_to_orange),
    cmocka_unit_test(beyond_its_end_stops_a_gradient_is_constant),
    cmocka_unit_test(stops_may_come_in_any_order),
    cmocka_unit_test(stops_at_one_place_make_a_step),
    cmocka_unit_test(one_stop_is_one_colour_and_none_is_black),
    cmocka_unit_test(a_gradient_also_colours_surfaces_that_face_away),
    cmocka_unit_test(highlights_agree_with_double_precision),
    cmocka_unit_test(normalized_highlights_agree_with_double_precision),
    cmocka_unit_test(each_input_counts_at_each_call),
    cmocka_unit_test(the_sharpest_highlights_keep_three_digits),
    cmocka_unit_test(normalized_diffuse_light_reflects_the_fraction_kd),
    cmocka_unit_test(normalized_highlights_reflect_all_light_along_the_normal),
    cmocka_unit_test(normalized_highlights_never_reflect_more_light_than_arrives),
    cmocka_unit_test(swapping_light_and_viewer_changes_only_the_cosine),
    cmocka_unit_test(no_colour_is_nan),
    cmocka_unit_test(no_colour_is_nan_though_products_overflow),
};

RK_SUITE("shading", tests)
