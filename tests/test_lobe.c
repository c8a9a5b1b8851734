/* Directions in the lobes of highlights: distributed by the density that they claim, for both
 * models, and to the digits that sharp lobes need. */
#include "test.h"

#include "base/random.h"
#include "render/lobe.h"

static const double pi = RK_PI_DOUBLE;

static rk_vec3 direction(double degrees_from_up, double degrees_around)
{
    double theta = degrees_from_up * pi / 180, phi = degrees_around * pi / 180;
    return rk_vec((float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                  (float)cos(theta));
}

static const rk_vec3 up = {0, 0, 1};
static const char *const names[] = {"off", "Lambert", "Phong", "Blinn-Phong"};

static rk_vec2 random_pair(uint32_t i)
{
    return (rk_vec2){rk_unit_float(rk_hash(i, 0, 0, 3)), rk_unit_float(rk_hash(i, 0, 1, 3))};
}

/* Cells of directions above the surface: equal intervals of n.l, and of the angle around n. */
enum { heights = 10, turns = 16, cells = heights * turns, drawn = 200000 };

static uint32_t cell_of(rk_vec3 l)
{
    double around = atan2((double)l.y, (double)l.x) / (2 * pi) + 0.5;
    int height = (int)((double)l.z * heights), turn = (int)(around * turns);
    return (uint32_t)((height < heights ? height : heights - 1) * turns +
                      (turn < turns ? turn : turns - 1));
}

/* The density's integral over a cell, by the midpoint rule. */
static double expected(const rk_lobe *lobe, uint32_t cell)
{
    enum { side = 32 };
    double sum = 0, area = 2 * pi / cells;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            double z = (cell / turns + (j + 0.5) / side) / heights;
            double around = ((cell % turns + (i + 0.5) / side) / turns - 0.5) * 360;
            sum += rk_lobe_density(lobe, direction(acos(z) * 180 / pi, around));
        }
    return sum / side / side * area;
}

static void directions_are_distributed_by_their_density(void **state)
{
    (void)state;
    const double shininess[] = {0, 3, 40}, viewers[] = {0, 40, 75};
    for (int k = 0; k < 2 * 3 * 3; k++) {
        rk_shading_model model = k % 2 ? RK_SHADING_BLINN_PHONG : RK_SHADING_PHONG;
        double s = shininess[k / 2 % 3];
        rk_lobe lobe = rk_lobe_of(model, (float)s, up, direction(viewers[k / 6], 25));
        double counts[cells] = {0}, square = 0, all = 0, degrees = 0;
        uint32_t above = 0;
        for (uint32_t i = 0; i < drawn; i++) {
            rk_vec3 l;
            if (!rk_lobe_direction(&lobe, random_pair(i), &l))
                continue;
            above++;
            counts[cell_of(l)]++;
        }
        for (uint32_t cell = 0; cell < cells; cell++) {
            double want = drawn * expected(&lobe, cell);
            all += want;
            if (want < 20) /* the counts of rare cells are not normally distributed */
                continue;
            square += (counts[cell] - want) * (counts[cell] - want) / want;
            degrees++;
        }
        /* The mean of chi squared is its degrees of freedom, its variance twice that; 5 sigma. */
        rk_check(square < degrees + 5 * sqrt(2 * degrees),
                 "%s, shininess %g, viewer at %g degrees: chi squared %.1f in %g cells",
                 names[model], s, viewers[k / 6], square, degrees);
        rk_check(degrees > 5, "most directions are in %g cells", degrees);
        rk_check(
            fabs(above - all) < 5 * sqrt((double)drawn) / 2 + 1,
            "%s, shininess %g, viewer at %g degrees: %u directions above the surface, want %.1f",
            names[model], s, viewers[k / 6], above, all);
    }
}

/* The power of the direction that xi maps to is known, so density and map can be compared. */
static void sharp_lobes_keep_three_digits(void **state)
{
    (void)state;
    for (double s = 1e2; s < 2e6; s *= 10)
        for (uint32_t i = 0; i < 2000; i++)
            for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
                rk_vec3 v = direction(50, i), l;
                rk_lobe lobe = rk_lobe_of((rk_shading_model)model, (float)s, up, v);
                rk_vec2 xi = random_pair(i);
                if (!rk_lobe_direction(&lobe, xi, &l))
                    continue;
                double half_v = sqrt((1 + (double)rk_dot(l, v)) / 2); /* cos of half their angle */
                double want = (s + 1) / (2 * pi) * pow(1 - (double)xi.x, s / (s + 1)) /
                              (model == RK_SHADING_PHONG ? 1 : 4 * half_v);
                double got = rk_lobe_density(&lobe, l);
                /* The direction is off by about 2^-23, the lobe's logarithm by s times its angle
                 * times that; angles are up to sqrt(2 log(2^24) / s). */
                double tolerance = 4 * sqrt(s * 2 * 24 * log(2)) * 0x1p-23 + 1e-6;
                rk_check(fabs(got - want) <= tolerance * want,
                         "%s, shininess %g: density %.7g, want %.7g within %.2g of it",
                         names[model], s, got, want, tolerance);
            }
}

static void below_the_surface_there_is_no_density(void **state)
{
    (void)state;
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++) {
        rk_lobe lobe = rk_lobe_of((rk_shading_model)model, 1, up, direction(85, 0));
        rk_check_equal(rk_lobe_density(&lobe, direction(91, 180)), 0, "no light is reflected");
        uint32_t below = 0;
        for (uint32_t i = 0; i < 1000; i++) {
            rk_vec3 l;
            bool above = rk_lobe_direction(&lobe, random_pair(i), &l);
            rk_check(!above || l.z > 0, "a direction below the surface is kept");
            rk_check_close(rk_length(l), 1, 1e-6, "directions are unit vectors");
            below += !above;
        }
        rk_check(below > 100, "%u of 1000 directions of a broad, grazing lobe are below", below);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(directions_are_distributed_by_their_density),
    cmocka_unit_test(sharp_lobes_keep_three_digits),
    cmocka_unit_test(below_the_surface_there_is_no_density),
};

RK_SUITE("lobe", tests)
