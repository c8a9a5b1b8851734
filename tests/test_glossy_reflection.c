/* Glossy reflection: the basis, the maps from square to disk, the discarded directions, the points
 * moved above the surface, and that both estimate their integrals. */
#include "test.h"

#include "base/dvec3.h"
#include "base/random.h"
#include "base/sampler.h"
#include "features/glossy_reflection.h"

static const double pi = 3.14159265358979323846;

/* A number in [0, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_case(a, b, c, 7));
}

static rk_vec2 noise2(uint32_t a, uint32_t b)
{
    return (rk_vec2){noise(a, b, 0), noise(a, b, 1)};
}

/* Uniform over the sphere, because height and angle are. In double, so that it is a unit vector
 * apart from the rounding to float. */
static rk_vec3 noise_direction(uint32_t a, uint32_t b)
{
    double z = 2 * (double)noise(a, b, 2) - 1, phi = 2 * pi * (double)noise(a, b, 3);
    double r = sqrt(fmax(1 - z * z, 0));
    return rk_vec((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

/* --- The basis ------------------------------------------------------------------------------- */

typedef struct basis_error {
    double size;
    const char *of;
} basis_error;

static const rk_vec3 guard = {7, 8, 9};

/* Places for results stand in arrays between elements that must stay as they are. */
static void check_guard(const rk_vec3 *element, const char *function)
{
    rk_check(memcmp(element, &guard, sizeof guard) == 0,
             "%s writes more than a vector: its neighbour in an array has changed", function);
}

/* The largest error of the two squared lengths, the three products, and u x v = w. */
static basis_error basis_error_of(rk_vec3 direction)
{
    rk_vec3 axes[] = {guard, guard, guard, guard, guard};
    rk_basis_of(direction, &axes[1], &axes[3]);
    for (int i = 0; i < 5; i += 2)
        check_guard(&axes[i], "rk_basis_of");
    rk_dvec3 w = rk_widen(direction), u = rk_widen(axes[1]), v = rk_widen(axes[3]);
    rk_dvec3 off = rk_dmadd(rk_dcross(u, v), w, -1);
    const basis_error errors[] = {
        {rk_ddot(u, u) - 1, "u's length squared"},
        {rk_ddot(v, v) - 1, "v's length squared"},
        {rk_ddot(u, v), "u . v"},
        {rk_ddot(u, w), "u . w"},
        {rk_ddot(v, w), "v . w"},
        {rk_dlength(off), "u x v, which should be w,"},
    };
    basis_error most = {0, "nothing"};
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        double size = isnan(errors[i].size) ? INFINITY : fabs(errors[i].size);
        if (size > most.size)
            most = (basis_error){size, errors[i].of};
    }
    return most;
}

/* 4 units in the last place of 1. A component of u or v is a sum with a product of at most 1, and
 * takes four roundings of up to 2^-24 each; w is rounded, too. They never all add up: the largest
 * measured error is 2.5 times 2^-24. */
static const double basis_bound = 8 * 0x1p-24;

static void check_basis_error(rk_vec3 w, basis_error error, double most)
{
    rk_check(error.size <= most, "w = (%.9g, %.9g, %.9g): %s is off by %.3g, want %.3g at most",
             (double)w.x, (double)w.y, (double)w.z, error.of, error.size, most);
}

static void check_basis(rk_vec3 w, double most)
{
    check_basis_error(w, basis_error_of(w), most);
}

static void a_basis_around_an_axis_is_exact(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++)
        for (int sign = -1; sign <= 1; sign += 2)
            for (int zeros = -1; zeros <= 1; zeros += 2) {
                float zero = copysignf(0, (float)zeros), one = (float)sign;
                /* u and v are axes, too. */
                check_basis(
                    rk_vec(axis == 0 ? one : zero, axis == 1 ? one : zero, axis == 2 ? one : zero),
                    0);
            }
}

static void a_basis_is_orthonormal_for_a_million_directions(void **state)
{
    (void)state;
    /* Each differs from the one before in one sign: no basis belongs to another direction. */
    for (uint32_t i = 0; i < 250000; i++) {
        rk_vec3 w = noise_direction(1, i);
        check_basis(w, basis_bound);
        check_basis(rk_vec(-w.x, w.y, w.z), basis_bound);
        check_basis(rk_vec(-w.x, -w.y, w.z), basis_bound);
        check_basis(rk_vec(-w.x, -w.y, -w.z), basis_bound);
    }
}

/* The worst of all, so that the message shows how far off a basis can be. */
static void a_basis_is_orthonormal_near_the_poles(void **state)
{
    (void)state;
    rk_vec3 worst = {0, 0, 1};
    basis_error most = basis_error_of(worst);
    /* From a tilt of the smallest float to 45 degrees, on both sides. */
    for (int e = 149; e >= 0; e--)
        for (uint32_t i = 0; i < 128; i++) {
            double tilt = ldexp(pi / 4, -e), phi = 2 * pi * (double)noise(2, i / 2, 0);
            float x = (float)(sin(tilt) * cos(phi)), y = (float)(sin(tilt) * sin(phi));
            float z = (float)cos(tilt);
            rk_vec3 w = rk_vec(x, y, i % 2 ? -z : z);
            basis_error error = basis_error_of(w);
            if (error.size > most.size)
                worst = w, most = error;
        }
    check_basis_error(worst, most, basis_bound);
}

static void a_basis_is_orthonormal_on_and_near_the_equator(void **state)
{
    (void)state;
    for (int e = 0; e <= 149; e++)
        for (uint32_t i = 0; i < 64; i++) {
            double z = ldexp(1, -e), phi = 2 * pi * (double)noise(3, i, 0), r = sqrt(1 - z * z);
            rk_vec3 w = rk_vec((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
            check_basis(w, basis_bound);
            check_basis(rk_vec(w.x, w.y, -w.z), basis_bound);
            check_basis(rk_vec((float)cos(phi), (float)sin(phi), e % 2 ? -0.f : 0), basis_bound);
        }
}

/* --- Points of the disk ----------------------------------------------------------------------- */

static const rk_disk_map maps[] = {RK_DISK_POLAR, RK_DISK_CONCENTRIC};
static const char *const map_names[] = {
    [RK_DISK_POLAR] = "polar", [RK_DISK_CONCENTRIC] = "concentric"};

/* A few roundings of numbers up to 1, and of an angle up to 2 pi. */
static const double disk_rounding = 0x1p-20;

static const char *mistake_of_point(rk_disk_map map, rk_vec2 xi, rk_vec2 got, double x, double y)
{
    const double a = (double)xi.x, b = (double)xi.y, turn = 2 * pi * b, r = sqrt(a);
    const double other = sqrt(b), degrees = (double)(360 * xi.y), radius = hypot(x, y);
    const rk_vector_mistake *polar = RK_VECTOR_MISTAKES(
        {{other * cos(2 * pi * a), other * sin(2 * pi * a), 0}, "xi.x and xi.y are exchanged"},
        {{a * cos(turn), a * sin(turn), 0}, "the radius is xi.x, without its root"},
        {{r * cos(degrees), r * sin(degrees), 0}, "the angle is in degrees, not in radians"},
        {{r * cos(turn / 2), r * sin(turn / 2), 0}, "the angle goes half around only"},
        {{r * sin(turn), r * cos(turn), 0}, "sine and cosine of the angle are exchanged"});
    const rk_vector_mistake *concentric = RK_VECTOR_MISTAKES(
        {{x, -y, 0}, "y points down"}, {{y, x, 0}, "x and y are exchanged"},
        {{x * radius, y * radius, 0}, "the radius is squared"},
        {{x / 2, y / 2, 0}, "the square is moved to [-1/2, 1/2], not to [-1, 1]"});
    return rk_mistake_in_vector((const double[]){(double)got.x, (double)got.y, 0},
                                (const double[]){x, y, 0}, disk_rounding * radius,
                                map == RK_DISK_POLAR ? polar : concentric);
}

/* Near the middle points are as exact as at the rim, in proportion. */
static void check_point(rk_disk_map map, rk_vec2 xi, double x, double y, const char *hint)
{
    double tolerance = disk_rounding * hypot(x, y);
    (void)rk_disk_at(map == RK_DISK_POLAR ? RK_DISK_CONCENTRIC : RK_DISK_POLAR, xi);
    rk_vec2 got = rk_disk_at(map, xi);
    rk_check(fabs((double)got.x - x) <= tolerance && fabs((double)got.y - y) <= tolerance,
             "%s map of xi (%.9g, %.9g), after a call for the other map: got (%.9g, %.9g), want "
             "(%.9g, %.9g) within %.3g: %s%s",
             map_names[map], (double)xi.x, (double)xi.y, (double)got.x, (double)got.y, x, y,
             tolerance, hint, mistake_of_point(map, xi, got, x, y));
}

static void the_polar_map_takes_a_root_and_an_angle(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec2 xi = noise2(4, i / 2);
        if (i % 4 == 1) /* near the middle, at the same angle */
            xi.x = ldexpf(1, -(int)(i % 100));
        if (i % 4 == 3) /* near the rim */
            xi.x = 1 - ldexpf(1, -(int)(i % 24) - 1);
        double r = sqrt((double)xi.x), phi = 2 * pi * (double)xi.y;
        check_point(RK_DISK_POLAR, xi, r * cos(phi), r * sin(phi),
                    "r = sqrt(xi.x), phi = 2 pi xi.y");
    }
}

static void the_concentric_map_keeps_the_middle_and_the_axes(void **state)
{
    (void)state;
    check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, 0.5f}, 0, 0, "the middle");
    check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, 0.125f}, 0, -0.75, "on the y axis, below");
    check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.3125f, 0.5f}, -0.375, 0, "on the x axis, left");
    for (int e = 2; e <= 24; e++)
        for (int sign = -1; sign <= 1; sign += 2) {
            float at = 0.5f + ldexpf((float)sign, -e);
            double r = sign * ldexp(1, 1 - e);
            check_point(RK_DISK_CONCENTRIC, (rk_vec2){at, 0.5f}, r, 0,
                        "near the middle, but not the middle");
            check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, at}, 0, r,
                        "near the middle, but not the middle");
        }
    for (float r = -1; r < 1; r += 0.125f) {
        float at = (1 + r) / 2;
        check_point(RK_DISK_CONCENTRIC, (rk_vec2){at, 0.5f}, (double)r, 0,
                    "points on the x axis stay there");
        check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, at}, 0, (double)r,
                    "points on the y axis stay there");
        double shortened = (double)r * sqrt(0.5);
        check_point(RK_DISK_CONCENTRIC, (rk_vec2){at, at}, shortened, shortened,
                    "the diagonal is shortened to the circle");
    }
}

static void the_concentric_map_makes_squares_into_circles(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec2 xi = noise2(5, i / 2);
        if (i % 2) /* in the same column of the square */
            xi.y = noise(5, i / 2, 2);
        double x = 2 * (double)xi.x - 1, y = 2 * (double)xi.y - 1;
        double r = fabs(x) > fabs(y) ? x : y;
        double theta = pi / 4 * (fabs(x) > fabs(y) ? y / x : 2 - x / y);
        check_point(RK_DISK_CONCENTRIC, xi, r * cos(theta), r * sin(theta),
                    "the larger of |2 xi - 1| is the distance from the middle, and the place along "
                    "the square's side that along an eighth of the circle");
    }
}

static void the_concentric_map_keeps_neighbours_together(void **state)
{
    (void)state;
    /* A step of the square, twice as long from -1 to 1, grows by sqrt(1.911) at most: the larger
     * singular value of ((1, 0), (pi / 4, pi / 4)), on a diagonal. */
    const double step = 0x1p-10, most = 2 * sqrt(1.911) * step;
    double longest = 0;
    for (uint32_t i = 0; i < 100000; i++) {
        rk_vec2 xi = noise2(6, i);
        double phi = 2 * pi * (double)noise(6, i, 2);
        rk_vec2 beside = {xi.x + (float)(step * cos(phi)), xi.y + (float)(step * sin(phi))};
        if (!(beside.x >= 0 && beside.x < 1 && beside.y >= 0 && beside.y < 1))
            continue;
        rk_vec2 a = rk_disk_at(RK_DISK_CONCENTRIC, xi), b = rk_disk_at(RK_DISK_CONCENTRIC, beside);
        double moved = hypot((double)(a.x - b.x), (double)(a.y - b.y));
        longest = fmax(longest, moved);
        rk_check(moved <= most + disk_rounding,
                 "(%g, %g): a step of %g became one of %g, want %g at most: no seams", (double)xi.x,
                 (double)xi.y, step, moved, most);
    }
    rk_check(longest > 1.9 * step, "nothing moved farther than %g: is this a disk of radius 1?",
             longest);
}

static void points_stay_in_the_disk(void **state)
{
    (void)state;
    double longest = 0;
    for (int m = 0; m < 2; m++)
        for (uint32_t i = 0; i <= 4096; i++)
            for (int edge = 0; edge < 4; edge++) {
                float along = (float)i / 4097, end = edge % 2 ? 1 - 0x1p-24f : 0;
                rk_vec2 xi = edge < 2 ? (rk_vec2){end, along} : (rk_vec2){along, end};
                rk_vec2 p = rk_disk_at(maps[m], xi);
                double length = hypot((double)p.x, (double)p.y);
                longest = fmax(longest, length);
                rk_check(length <= 1 + 0x1p-22, "%s map of (%.9g, %.9g): %.9g from the middle",
                         map_names[m], (double)xi.x, (double)xi.y, length);
            }
    rk_check(longest > 0.999, "no point near the rim: the farthest is at %g", longest);
}

/* 16 rings of equal area, cut into 16 sectors. */
static void points_fill_cells_of_the_disk_evenly(void **state)
{
    (void)state;
    enum { side = 16, cells = side * side, points = 256 * 250 };
    for (int m = 0; m < 2; m++) {
        static uint32_t counts[cells];
        memset(counts, 0, sizeof counts);
        for (uint32_t i = 0; i < points; i++) {
            rk_vec2 p = rk_disk_at(maps[m], noise2(8 + (uint32_t)m, i));
            double area = (double)p.x * (double)p.x + (double)p.y * (double)p.y;
            double turn = atan2((double)p.y, (double)p.x) / (2 * pi) + 0.5;
            int ring = (int)fmin(area * side, side - 1), sector = (int)fmin(turn * side, side - 1);
            counts[ring * side + sector]++;
        }
        double chi2 = 0, want = (double)points / cells;
        int worst = 0;
        for (int i = 0; i < cells; i++) {
            chi2 += (counts[i] - want) * (counts[i] - want) / want;
            if (fabs(counts[i] - want) > fabs(counts[worst] - want))
                worst = i;
        }
        /* 255 degrees of freedom: above 378 once in a million times, below 161 as rarely. */
        rk_check(chi2 > 161 && chi2 < 378,
                 "%s map: of %d points in %d cells of equal area, chi^2 is %.1f, want 161 to 378; "
                 "ring %d of %d from the middle, at %d to %d degrees, got %u, want about %.0f",
                 map_names[m], points, cells, chi2, worst / side + 1, side,
                 (int)(worst % side * 360.0 / side) - 180,
                 (int)((worst % side + 1) * 360.0 / side) - 180, counts[worst], want);
    }
}

/* Kolmogorov's statistic: the largest distance of a distribution from the uniform one on [0, 1], at
 * multiples of 1/count; elsewhere it is at most 1/count more. */
static double distance_from_uniform(const double *numbers, uint32_t count, uint32_t *in_part)
{
    double most = 0;
    memset(in_part, 0, count * sizeof *in_part);
    for (uint32_t i = 0; i < count; i++)
        in_part[(uint32_t)fmin(fmax(numbers[i] * count, 0), count - 1)]++;
    for (uint32_t i = 0, below = 0; i < count; i++) {
        below += in_part[i];
        most = fmax(most, fabs((double)below - (i + 1)));
    }
    return most / count;
}

static void radius_squared_and_angle_are_uniform(void **state)
{
    (void)state;
    enum { points = 100000 };
    static double areas[points], turns[points];
    static uint32_t in_part[points];
    for (int m = 0; m < 2; m++) {
        for (uint32_t i = 0; i < points; i++) {
            rk_vec2 p = rk_disk_at(maps[m], noise2(10 + (uint32_t)m, i));
            areas[i] = (double)p.x * (double)p.x + (double)p.y * (double)p.y;
            turns[i] = atan2((double)p.y, (double)p.x) / (2 * pi) + 0.5;
        }
        /* Exceeded once in a million times: 2 exp(-2 n d^2) = 1e-6 for d = 2.69 / sqrt(n). */
        double most = 2.69 / sqrt(points);
        rk_check_near(distance_from_uniform(areas, points, in_part), 0, most,
                      "%s map: largest gap between the distribution of the radius squared, the "
                      "fraction of the area inside, and the uniform one",
                      map_names[m]);
        rk_check_near(distance_from_uniform(turns, points, in_part), 0, most,
                      "%s map: largest gap between the distribution of the angle and the uniform "
                      "one",
                      map_names[m]);
    }
}

/* --- Directions ------------------------------------------------------------------------------- */

static void the_radius_is_half_over_the_shininess(void **state)
{
    (void)state;
    rk_check_near_or(rk_glossy_radius(8), 0.0625, 0,
                     RK_MISTAKES({0.125, "the disk's diameter is returned, 1 / s"},
                                 {1, "shininess is a factor, not a divisor"}),
                     "rk_glossy_radius(8), 0.5 / s");
    rk_check_close(rk_glossy_radius(1), 0.5, 0, "0.5 / s");
    rk_check_close(rk_glossy_radius(1000), 0.0005, 1e-10, "a shiny surface has a small disk");
    rk_check_close(rk_glossy_radius(INFINITY), 0, 0, "a perfect mirror");
    for (int i = 1; i <= 400; i++) { /* from 1/2, where the radius is 1, to 2^49 */
        float shininess = exp2f((float)i / 8 - 1);
        double want = 0.5 / (double)shininess;
        rk_check_near(rk_glossy_radius(shininess), want, 2 * 0x1p-24 * want,
                      "shininess %g, above 0.5: 0.5 / s", (double)shininess);
    }
}

static void a_dull_surface_has_the_widest_disk(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_radius(0), 1, 0, "shininess 0: radius 1, not infinity");
    rk_check_close(rk_glossy_radius(-0.f), 1, 0,
                   "shininess -0, as a file may have it: radius 1, too");
    const float below_half[] = {1e-45f, 1e-38f, 1e-30f, 1e-6f, 0.01f, 0.1f, 0.25f, 0.5f - 0x1p-25f};
    for (int i = 0; i < 8; i++)
        rk_check_near(rk_glossy_radius(below_half[i]), 1, 0,
                      "shininess %g, below 0.5: the radius, which 0.5 / s would make wider than 1",
                      (double)below_half[i]);
    rk_check_close(rk_glossy_radius(0.5f), 1, 0, "where 0.5 / s reaches 1");
}

/* A surface, and the direction that it reflects into. */
typedef struct setting {
    rk_vec3 reflected, face_normal;
} setting;

static setting random_setting(uint32_t i)
{
    setting s = {noise_direction(20, i), noise_direction(21, i)};
    if (rk_dot(s.reflected, s.face_normal) < 0)
        s.face_normal = rk_negate(s.face_normal);
    return s;
}

/* The reflected direction `degrees` above the surface, which is oriented at random. */
static setting setting_at(double degrees, uint32_t i)
{
    rk_vec3 n = noise_direction(22, i), aside = noise_direction(23, i);
    rk_dvec3 normal = rk_widen(n);
    normal = rk_dscale(normal, 1 / rk_dlength(normal));
    rk_dvec3 along = rk_dmadd(rk_widen(aside), normal, -rk_ddot(rk_widen(aside), normal));
    along = rk_dscale(along, cos(degrees * pi / 180) / rk_dlength(along));
    rk_dvec3 w = rk_dmadd(along, normal, sin(degrees * pi / 180));
    return (setting){rk_vec((float)w.x, (float)w.y, (float)w.z), n};
}

static void check_reflected(uint32_t i, float radius, rk_vec2 at)
{
    setting s = random_setting(i);
    rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, radius, s.face_normal);
    rk_vec3 direction = {NAN, NAN, NAN};
    bool above = rk_glossy_direction(&disk, at, &direction);
    rk_check(above, "(%g, %g, %g), the reflected direction above the surface, was discarded",
             (double)s.reflected.x, (double)s.reflected.y, (double)s.reflected.z);
    rk_check(
        direction.x == s.reflected.x && direction.y == s.reflected.y &&
            direction.z == s.reflected.z,
        "radius %g, point (%g, %g): got (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g) to the bit",
        (double)radius, (double)at.x, (double)at.y, (double)direction.x, (double)direction.y,
        (double)direction.z, (double)s.reflected.x, (double)s.reflected.y, (double)s.reflected.z);
}

static void radius_0_and_the_middle_give_the_reflected_direction_exactly(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        check_reflected(i, 0, rk_disk_at(maps[i % 2], noise2(24, i)));
        check_reflected(i, noise(24, i, 2), (rk_vec2){0, 0});
    }
}

static void check_unchanged(const rk_glossy_disk *disk, const rk_glossy_disk *before,
                            const char *function)
{
    rk_check(memcmp(disk, before, sizeof *disk) == 0, "%s changed the disk, which is the caller's",
             function);
}

/* Returns whether the direction is kept. */
static bool check_direction(setting s, float radius, rk_vec2 at)
{
    rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, radius, s.face_normal), before = disk;
    rk_vec3 row[] = {guard, {NAN, NAN, NAN}, guard}, u, v;
    bool above = rk_glossy_direction(&disk, at, &row[1]);
    check_unchanged(&disk, &before, "rk_glossy_direction");
    check_guard(&row[0], "rk_glossy_direction");
    check_guard(&row[2], "rk_glossy_direction");
    rk_vec3 got = row[1];
    rk_basis_of(s.reflected, &u, &v);
    rk_check(rk_length(u) > 0.5f && rk_length(v) > 0.5f,
             "rk_basis_of: u and v have the lengths %g and %g, want 1", (double)rk_length(u),
             (double)rk_length(v));
    rk_dvec3 w = rk_widen(s.reflected);
    rk_dvec3 to = rk_dmadd(rk_dmadd(w, rk_widen(u), (double)radius * (double)at.x), rk_widen(v),
                           (double)radius * (double)at.y);
    rk_dvec3 want = rk_dscale(to, 1 / rk_dlength(to));
    rk_dvec3 off = rk_dmadd(rk_widen(got), want, -1);
    /* The basis' own error, and a handful of roundings. */
    rk_check(rk_dlength(off) <= basis_bound + 8 * 0x1p-24,
             "w (%g, %g, %g), radius %g, point (%g, %g): got (%g, %g, %g), want (%g, %g, %g), the "
             "unit vector of w + x u + y v, even if it is discarded: off by %.3g",
             w.x, w.y, w.z, (double)radius, (double)at.x, (double)at.y, (double)got.x,
             (double)got.y, (double)got.z, want.x, want.y, want.z, rk_dlength(off));
    double height = rk_ddot(want, rk_widen(s.face_normal));
    /* The direction's error, and roundings of the product. */
    rk_check(above ? height > -(basis_bound + 12 * 0x1p-24) : height < basis_bound + 12 * 0x1p-24,
             "w (%g, %g, %g), radius %g, point (%g, %g), face normal (%g, %g, %g): %s a direction "
             "whose height above the face is %.9g",
             w.x, w.y, w.z, (double)radius, (double)at.x, (double)at.y, (double)s.face_normal.x,
             (double)s.face_normal.y, (double)s.face_normal.z, above ? "kept" : "discarded",
             height);
    return above;
}

static rk_vec3 on_the_side_of(rk_vec3 v, rk_vec3 of)
{
    return rk_dot(v, of) < 0 ? rk_negate(v) : v;
}

static void directions_are_unit_and_go_through_their_point_of_the_disk(void **state)
{
    (void)state;
    const float radii[] = {1e-4f, 0.1f, 1, 30, 1000};
    uint32_t kept = 0;
    for (uint32_t i = 0; i < 10000; i++) {
        setting s = random_setting(i), other = random_setting(i + 1);
        rk_vec2 at = rk_disk_at(maps[i / 4 % 2], noise2(25, i));
        kept += check_direction(s, radii[i % 5], at);
        /* Each differs from the one before in one thing. */
        check_direction(s, radii[(i + 1) % 5], at);
        at.x = -at.x;
        check_direction(s, radii[(i + 1) % 5], at);
        at.y = -at.y;
        kept += check_direction(s, radii[(i + 1) % 5], at);
        s.face_normal = on_the_side_of(other.face_normal, s.reflected);
        check_direction(s, radii[(i + 1) % 5], at);
        s.reflected = on_the_side_of(other.reflected, s.face_normal);
        check_direction(s, radii[(i + 1) % 5], at);
    }
    rk_check(kept > 10000, "only %u of 20000 are above the surface", kept);
}

static void no_direction_leads_into_the_surface(void **state)
{
    (void)state;
    uint32_t kept = 0, discarded = 0;
    for (uint32_t i = 0; i < 50000; i++) {
        /* From a grazing direction to a steep one. */
        double degrees = 90 * pow((double)noise(26, i, 0), 3);
        setting s = setting_at(degrees, i);
        rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, noise(26, i, 1), s.face_normal);
        rk_vec3 direction = {NAN, NAN, NAN};
        bool above = rk_glossy_direction(&disk, rk_disk_at(maps[i % 2], noise2(27, i)), &direction);
        double height = rk_ddot(rk_widen(direction), rk_widen(s.face_normal));
        /* Three products and two sums of numbers up to 1. */
        rk_check(
            above ? height > -3 * 0x1p-24 : height <= 3 * 0x1p-24,
            "w %.3g degrees above the face, radius %.3g: %s a direction whose height above the "
            "face is %.9g",
            degrees, (double)disk.radius, above ? "kept" : "discarded", height);
        kept += above;
        discarded += !above;
    }
    rk_check(kept > 5000 && discarded > 5000, "kept %u, discarded %u: both should happen", kept,
             discarded);
}

/* Halfway from the middle to the rim; exact where u and v are axes, as around an axis. */
static rk_vec2 halfway_along(const rk_glossy_disk *disk, rk_vec3 axis)
{
    return (rk_vec2){0.5f * rk_dot(axis, disk->u), 0.5f * rk_dot(axis, disk->v)};
}

static void a_direction_along_the_surface_is_discarded(void **state)
{
    (void)state;
    rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(1, 0, 0), 0.5f, rk_vec(0, 0, 1));
    const rk_vec3 along = {0, 1, 0}, up = {0, 0, 1};
    rk_vec3 direction;
    rk_check(!rk_glossy_direction(&disk, halfway_along(&disk, along), &direction),
             "w (1, 0, 0), face normal (0, 0, 1): kept (1, 0.25, 0), which runs in the face");
    rk_check(!rk_glossy_direction(&disk, halfway_along(&disk, rk_negate(up)), &direction),
             "w (1, 0, 0), face normal (0, 0, 1): kept (1, 0, -0.25), which leads below it");
    rk_check(rk_glossy_direction(&disk, halfway_along(&disk, up), &direction),
             "w (1, 0, 0), face normal (0, 0, 1): discarded (1, 0, 0.25), which leads above it");
    /* However small the angle: there is no epsilon. */
    for (int e = 2; e <= 140; e++) {
        disk.radius = ldexpf(1, -e);
        rk_check(rk_glossy_direction(&disk, halfway_along(&disk, up), &direction),
                 "w (1, 0, 0), face normal (0, 0, 1): discarded (1, 0, %g), which leads above it",
                 ldexp(0.5, -e));
        rk_check(!rk_glossy_direction(&disk, halfway_along(&disk, rk_negate(up)), &direction),
                 "w (1, 0, 0), face normal (0, 0, 1): kept (1, 0, %g), which leads below it",
                 -ldexp(0.5, -e));
    }
    /* The reflected direction itself, along the face or a rounding below it. */
    for (int i = 0; i < 6; i++) {
        rk_vec3 w = rk_vec(1, 0, i < 2 ? 0 : -ldexpf(1, -4 - 10 * i));
        disk = rk_glossy_disk_of(w, i % 2 ? 0.5f : 0, up);
        rk_check(disk.radius == 0 ||
                     rk_glossy_direction(&disk, halfway_along(&disk, up), &direction),
                 "w (1, 0, %g), face normal (0, 0, 1), radius %g: discarded the direction halfway "
                 "up, which leads above the face, although w does not",
                 (double)w.z, (double)disk.radius);
        direction = rk_vec(NAN, NAN, NAN);
        rk_check(!rk_glossy_direction(&disk, (rk_vec2){0, 0}, &direction),
                 "w (1, 0, %g), face normal (0, 0, 1), radius %g: kept w, which runs along the "
                 "face or below it",
                 (double)w.z, (double)disk.radius);
        rk_check(direction.x == w.x && direction.y == w.y && direction.z == w.z,
                 "w (1, 0, %g), radius %g: got (%g, %g, %g), want w, filled in although it is "
                 "discarded",
                 (double)w.z, (double)disk.radius, (double)direction.x, (double)direction.y,
                 (double)direction.z);
    }
}

/* --- The fraction above the surface ----------------------------------------------------------- */

/* The radiance from a direction: smooth, and not constant. */
static double radiance_from(rk_dvec3 d)
{
    return 1 + 0.5 * d.x - 0.25 * d.y + 0.75 * d.z * d.z;
}

typedef struct integral {
    double fraction, radiance; /* means over the disk, of 1 and of radiance, 0 below the surface */
} integral;

/* In double, with other axes: for each angle the radii above the surface are known exactly, and
 * Simpson's rule does the rest. */
static integral integrate(const setting *s, double radius, int angles, bool with_radiance)
{
    enum { steps = 8 };
    rk_dvec3 w = rk_widen(s->reflected), n = rk_widen(s->face_normal);
    rk_dvec3 other = fabs(w.x) < 0.5 ? (rk_dvec3){1, 0, 0} : (rk_dvec3){0, 1, 0};
    rk_dvec3 u = rk_dcross(w, other);
    u = rk_dscale(u, 1 / rk_dlength(u));
    rk_dvec3 v = rk_dcross(w, u);
    integral sum = {0, 0};
    for (int i = 0; i < angles; i++) {
        double theta = 2 * pi * (i + 0.5) / angles;
        rk_dvec3 out = rk_dmadd(rk_dscale(u, cos(theta)), v, sin(theta));
        double slope = radius * rk_ddot(n, out), end = 1;
        if (rk_ddot(n, w) + slope < 0)
            end = -rk_ddot(n, w) / slope;
        sum.fraction += end * end;
        for (int k = 0; k <= steps && with_radiance; k++) {
            double r = end * k / steps, weight = k % steps == 0 ? 1 : k % 2 ? 4 : 2;
            rk_dvec3 d = rk_dmadd(w, out, radius * r);
            sum.radiance +=
                weight * end / (3 * steps) * 2 * r * radiance_from(rk_dscale(d, 1 / rk_dlength(d)));
        }
    }
    return (integral){sum.fraction / angles, sum.radiance / angles};
}

static void a_disk_above_the_surface_has_a_fraction_above_of_1(void **state)
{
    (void)state;
    const float radii[] = {0, 0.01f, 0.5f, 1};
    for (int i = 0; i < 4; i++) {
        rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(0, 0, 1), radii[i], rk_vec(0, 0, 1));
        rk_check_near(rk_glossy_fraction_above(&disk), 1, 0,
                      "fraction above, for a disk of radius %g straight above the surface",
                      (double)radii[i]);
        disk = rk_glossy_disk_of(rk_vec(0.6f, 0, 0.8f), radii[i], rk_vec(0, 0, 1));
        rk_check_near(
            rk_glossy_fraction_above(&disk), 1, 0,
            "fraction above, for a disk of radius %g, 53 degrees above the surface, which cuts "
            "disks from radius 1.33 on",
            (double)radii[i]);
        /* The product of a unit vector with itself is 1 apart from rounding, and may exceed 1. */
        for (uint32_t k = 0; k < 1000; k++) {
            rk_vec3 w = noise_direction(28, k);
            disk = rk_glossy_disk_of(w, radii[i], w);
            rk_check_near(rk_glossy_fraction_above(&disk), 1, 0,
                          "fraction above, for a disk of radius %g, w and face normal both (%.9g, "
                          "%.9g, %.9g)",
                          (double)radii[i], (double)w.x, (double)w.y, (double)w.z);
        }
    }
}

static void a_disk_halved_by_the_surface_has_a_fraction_above_of_one_half(void **state)
{
    (void)state;
    const float radii[] = {0.01f, 0.5f, 1, 100};
    for (int i = 0; i < 4; i++) {
        rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(0, 1, 0), radii[i], rk_vec(0, 0, 1));
        rk_check_near(rk_glossy_fraction_above(&disk), 0.5, 0x1p-22,
                      "fraction above, for a disk of radius %g whose middle is in the plane",
                      (double)radii[i]);
    }
}

/* The face's normal is an axis, so that every computation of w's height above the face is exact. */
static setting leaning_on(int axis, double height)
{
    double along = sqrt(1 - height * height);
    float of[3] = {0}, normal[3] = {0};
    of[axis] = (float)height;
    of[(axis + 1) % 3] = (float)(0.6 * along);
    of[(axis + 2) % 3] = (float)(-0.8 * along);
    normal[axis] = 1;
    return (setting){rk_vec(of[0], of[1], of[2]), rk_vec(normal[0], normal[1], normal[2])};
}

static void check_one_half_at_least(rk_vec3 w, rk_vec3 n, float radius)
{
    rk_glossy_disk disk = rk_glossy_disk_of(w, radius, n);
    float got = rk_glossy_fraction_above(&disk);
    rk_check(got >= 0.5f && got <= 1,
             "radius %.3g, w (%.9g, %.9g, %.9g), face normal (%.9g, %.9g, %.9g), w . n %.3g: got a "
             "fraction of %.9g, want 1/2 to 1: rounding may take w along the face or below it",
             (double)radius, (double)w.x, (double)w.y, (double)w.z, (double)n.x, (double)n.y,
             (double)n.z, (double)rk_dot(w, n), (double)got);
}

static void rounding_never_takes_more_than_half_of_the_disk_below(void **state)
{
    (void)state;
    const float radii[] = {0, 1e-30f, 2.5e-8f, 1e-7f, 1e-4f, 1};
    uint32_t below = 0;
    for (int r = 0; r < 6; r++) {
        check_one_half_at_least(rk_vec(1, 0, 0), rk_vec(0, 0, 1), radii[r]);
        for (uint32_t i = 0; i < 5000; i++) {
            setting s = setting_at(0, i);
            below += rk_dot(s.reflected, s.face_normal) < 0;
            check_one_half_at_least(s.reflected, s.face_normal, radii[r]);
        }
    }
    rk_check(below > 1000, "only %u of 30000 directions were rounded to below the face", below);
    /* Below the face by any computation: the centre counts as on the line. */
    const float heights[] = {0, -0.f, -1e-30f, -1e-10f, -3e-8f, -0x1p-24f, -0x1p-22f};
    for (int r = 1; r < 6; r++)
        for (int h = 0; h < 7; h++)
            for (int axis = 0; axis < 3; axis++) {
                setting s = leaning_on(axis, (double)heights[h]);
                rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, radii[r], s.face_normal);
                rk_check_near(rk_glossy_fraction_above(&disk), 0.5, 0x1p-22,
                              "radius %.3g, the centre %.3g above the face, as rounding may take "
                              "it: fraction above of a disk whose centre is on the line",
                              (double)radii[r], (double)heights[h]);
            }
}

/* A disk, and the part of it above the surface, in double. */
typedef struct part {
    rk_glossy_disk disk;
    rk_dvec3 up; /* its x and y: the unit vector in the disk that leads up */
    double line; /* the face's plane, along `up` */
    double fraction;
} part;

/* The fraction of the unit disk farther up than `height`: chords are 2 cos(phi) long at the height
 * sin(phi). By Gauss's rule with five points in each of eight intervals, exact to 13 digits. */
static double area_beyond(double height)
{
    static const double at[] = {0, 0.5384693101056831, 0.9061798459386640};
    static const double weights[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    double from = asin(height), half = (pi / 2 - from) / 16, sum = 0;
    for (int i = 0; i < 8; i++)
        for (int k = -2; k <= 2; k++) {
            double c = cos(from + half * (2 * i + 1 + (k < 0 ? -at[-k] : at[k])));
            sum += weights[abs(k)] * c * c;
        }
    return 2 / pi * half * sum;
}

static part part_of_disk(rk_glossy_disk disk, double radius)
{
    part p = {.disk = disk};
    rk_dvec3 n = rk_widen(disk.face_normal);
    rk_dvec3 up = {rk_ddot(rk_widen(p.disk.u), n), rk_ddot(rk_widen(p.disk.v), n), 0};
    double height = fmax(rk_ddot(rk_widen(p.disk.w), n), 0), reach = radius * rk_dlength(up);
    p.up = rk_dscale(up, 1 / rk_dlength(up));
    p.line = height < reach ? -height / reach : -1;
    p.fraction = area_beyond(p.line);
    return p;
}

static part part_of(const setting *s, float radius)
{
    return part_of_disk(rk_glossy_disk_of(s->reflected, radius, s->face_normal), (double)radius);
}

/* The same disk, with its axes turned by a third of a right angle. */
static part with_other_axes(part p)
{
    rk_glossy_disk disk = p.disk;
    const float c = 0.8660254f, s = 0.5f;
    disk.u = rk_madd(rk_scale(p.disk.u, c), p.disk.v, s);
    disk.v = rk_madd(rk_scale(p.disk.v, c), p.disk.u, -s);
    return part_of_disk(disk, (double)disk.radius);
}

/* A disk is constant for all its directions. */
static void check_constant_disk(void)
{
    const rk_vec3 up = {0, 0, 1};
    const rk_glossy_disk own = rk_glossy_disk_of(up, 0.5f, up);
    const rk_glossy_disk *disk = rk_read_only(&own, sizeof own, "disk");
    rk_vec3 direction;
    rk_glossy_direction(disk, (rk_vec2){0.25f, 0.25f}, &direction);
    rk_glossy_fraction_above(disk);
    rk_glossy_point_above(disk, 1, (rk_vec2){0.25f, 0.25f});
    rk_read_only_free();
}

static void the_fraction_above_equals_quadrature(void **state)
{
    (void)state;
    check_constant_disk();
    const double radii[] = {0.02, 0.3, 1, 5}, large[] = {100, 1000};
    for (uint32_t i = 0; i < 100; i++) {
        double radius = i % 10 == 0 ? large[i / 10 % 2] : radii[i % 4];
        double degrees = atan(radius) * 180 / pi * (i % 50 + 0.5) / 50;
        if (i % 5 == 0) /* hardly cut */
            degrees = atan(radius * (1 - 0.0005 * (i % 8 + 1))) * 180 / pi;
        setting s = setting_at(degrees, i);
        rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, (float)radius, s.face_normal),
                       before = disk;
        /* Roundings of 2^-24, which are divided by the radius near the surface; and the kink where
         * the plane cuts the rim, between two of 16384 angles. */
        rk_check_near(rk_glossy_fraction_above(&disk), integrate(&s, radius, 16384, false).fraction,
                      8 * 0x1p-24 / radius + 2e-6,
                      "fraction above, for a disk of radius %g, %.3g degrees above the surface: "
                      "the disk without its segment",
                      radius, degrees);
        check_unchanged(&disk, &before, "rk_glossy_fraction_above");
    }
}

static float fraction_of(setting s, float radius)
{
    rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, radius, s.face_normal);
    return rk_glossy_fraction_above(&disk);
}

/* With the same line a disk of any size has the same fraction above. */
static void a_small_disk_is_cut_like_a_large_one(void **state)
{
    (void)state;
    const float radii[] = {1, 0.5f, 0.1f, 1e-3f, 1e-6f, 1e-7f, 1e-10f, 1e-15f, 1e-20f, 1e-30f};
    const double lines[] = {0, 0.1, 0.5, 0.9, 0.999, 1, 1.001, 1.5, 20};
    for (int r = 0; r < 10; r++)
        for (int i = 0; i < 9; i++)
            for (int axis = 0; axis < 3; axis++) {
                double slope = lines[i] * (double)radii[r];
                setting s = leaning_on(axis, slope / sqrt(1 + slope * slope));
                /* Few roundings, also in floats. */
                rk_check_near(fraction_of(s, radii[r]), area_beyond(-fmin(lines[i], 1)), 1e-6,
                              "radius %g, the face's plane %g radii from the centre: the fraction "
                              "above",
                              (double)radii[r], lines[i]);
            }
}

static void check_fraction(setting s, float radius)
{
    part p = part_of(&s, radius);
    /* Roundings of the height are divided by the radius. */
    rk_check_near(fraction_of(s, radius), p.fraction, 8 * 0x1p-24 / (double)radius + 1e-6,
                  "radius %g, w (%g, %g, %g), face normal (%g, %g, %g): the fraction above, which "
                  "depends on each of them",
                  (double)radius, (double)s.reflected.x, (double)s.reflected.y,
                  (double)s.reflected.z, (double)s.face_normal.x, (double)s.face_normal.y,
                  (double)s.face_normal.z);
}

static void the_fraction_above_depends_on_direction_radius_and_face(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 2000; i++) {
        setting s = setting_at(20 * (double)noise(30, i, 0), i), other = random_setting(i);
        float radius = 0.4f + noise(30, i, 1);
        /* Each differs from the one before in one thing. */
        check_fraction(s, radius);
        check_fraction(s, radius / 4);
        check_fraction(s, 2 * radius);
        s.face_normal = on_the_side_of(other.face_normal, s.reflected);
        check_fraction(s, 2 * radius);
        s.reflected = on_the_side_of(other.reflected, s.face_normal);
        check_fraction(s, 2 * radius);
    }
}

/* --- Points above the surface ----------------------------------------------------------------- */

static rk_vec2 moved(const part *p, rk_vec2 at)
{
    rk_glossy_disk disk = p->disk;
    rk_vec2 to = rk_glossy_point_above(&disk, (float)p->fraction, at);
    check_unchanged(&disk, &p->disk, "rk_glossy_point_above");
    return to;
}

/* A point's coordinates along `up`, and from there to the right. */
static rk_dvec3 seen_upright(const part *p, rk_vec2 at)
{
    double x = (double)at.x, y = (double)at.y;
    return (rk_dvec3){x * p->up.x + y * p->up.y, y * p->up.x - x * p->up.y, 0};
}

static rk_vec2 point_upright(const part *p, double up, double across)
{
    return (rk_vec2){(float)(up * p->up.x - across * p->up.y),
                     (float)(up * p->up.y + across * p->up.x)};
}

static void check_moved(const part *p, rk_vec2 from, double up, double across, double tolerance,
                        const char *hint)
{
    rk_dvec3 at = seen_upright(p, from), got = seen_upright(p, moved(p, from));
    rk_check(hypot(got.x - up, got.y - across) <= tolerance,
             "fraction above %.4f: the point %.6f up and %.6f across came to %.6f and %.6f, want "
             "%.6f and %.6f within %.2g: %s",
             p->fraction, at.x, at.y, got.x, got.y, up, across, tolerance, hint);
}

static void a_halved_disk_moves_its_points_up(void **state)
{
    (void)state;
    /* Beyond this height lies a quarter of the disk, half as much as beyond its middle. */
    const double quarter = 0.4039727533, end = sqrt(1 - quarter * quarter);
    rk_check_near(area_beyond(quarter), 0.25, 1e-9, "the area beyond that height");
    for (uint32_t i = 0; i < 100; i++) {
        setting s = setting_at(0, i);
        part p = part_of(&s, 0.5f);
        check_moved(&p, (rk_vec2){0, 0}, quarter, 0, disk_rounding,
                    "half of the disk is farther up than its middle, and a quarter than the place "
                    "it goes to");
        check_moved(&p, point_upright(&p, 0, 0.5), quarter, end / 2, disk_rounding,
                    "halfway between the middle and the rim, and so it stays");
        check_moved(&p, point_upright(&p, 0, -0.999999), quarter, -0.999999 * end, disk_rounding,
                    "a point at the rim comes to the rim");
        /* A point this near the top has an area of 5e-5 beyond it. */
        check_moved(&p, point_upright(&p, 0.999, 0), 0.99937, 0, 1e-5, "almost the top");
        check_moved(&p, point_upright(&p, 1, 0), 1, 0, disk_rounding, "the top stays the top");
        part turned = with_other_axes(p);
        check_moved(&turned, point_upright(&turned, 0, 0.5), quarter, end / 2, disk_rounding,
                    "points are in the disk's own axes, u and v, which may be others than those of "
                    "rk_basis_of");
    }
}

/* Returns false, without a check, where the face does not cut the disk, and at the rim. */
static bool check_area_fits(const part *p, rk_vec2 from)
{
    rk_dvec3 at = seen_upright(p, from), to = seen_upright(p, moved(p, from));
    double room = 1 - at.x * at.x;
    if (!(p->line > -1 && room > 2e-6))
        return false;
    rk_check_near(area_beyond(fmin(fmax(to.x, -1), 1)), p->fraction * area_beyond(at.x),
                  8 * 0x1p-24,
                  "fraction above %.4f: the area beyond the point %.6f up, which came from %.6f up",
                  p->fraction, to.x, at.x);
    /* A rounding of the height changes the distance to the rim by 1 / room times as much. */
    double across = at.y / sqrt(room) * sqrt(fmax(1 - to.x * to.x, 0));
    rk_check_near(to.y, across, 4 * 0x1p-24 / room + 2 * 0x1p-24,
                  "fraction above %.4f: the point %.6f across, %.6f of its chord's half, came to "
                  "%.6f up, and this far across",
                  p->fraction, at.y, at.y / sqrt(room), to.x);
    return true;
}

/* The height with this area beyond it, by bisection. */
static double height_of_area(double area)
{
    double low = -1, high = 1;
    for (int i = 0; i < 32; i++) { /* to 5e-10 */
        double middle = (low + high) / 2;
        if (area_beyond(middle) > area)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* At the ends of chords and close to them, on long chords, against the same in double: floats,
 * whose roundings count up to five times as much on the shortest of these, come within 1e-6. */
static void check_ends_of_chords(void)
{
    uint32_t cut = 0;
    for (uint32_t i = 0; i < 2000; i++) {
        float radius = 0.5f + noise(61, i, 0);
        setting s = setting_at(90 * pow((double)noise(61, i, 1), 3), i);
        part p = part_of(&s, radius);
        if (!(p.line > -1))
            continue;
        cut++;
        double short_of_end = i % 8 == 0 ? 0 : pow(10, -1 - 6 * (double)noise(61, i, 2));
        double from_up = i % 5 == 0 ? -0.9 : 1.8 * (double)noise(61, i, 3) - 0.9;
        double place = i % 2 ? 1 - short_of_end : short_of_end - 1;
        rk_vec2 from = point_upright(&p, from_up, place * sqrt(1 - from_up * from_up));
        rk_dvec3 at = seen_upright(&p, from);
        double up = height_of_area((double)(float)p.fraction * area_beyond(at.x));
        double end = fmin(fmax(at.y / sqrt(1 - at.x * at.x), -1), 1);
        check_moved(&p, from, up, end * sqrt(1 - up * up), 1e-6,
                    "near an end of its chord, and there it stays");
    }
    rk_check(cut > 500, "only %u of 2000 disks are cut by the face", cut);
}

static void points_move_until_the_area_beyond_them_fits(void **state)
{
    (void)state;
    uint32_t cut = 0;
    for (uint32_t i = 0; i < 5000; i++) {
        float radius = 2 * noise(41, i, 1);
        double degrees = i % 5 == 0 /* hardly cut */
                             ? atan((double)radius * (1 - 0.0001 * (i % 16 + 1))) * 180 / pi
                             : 90 * pow((double)noise(41, i, 0), 3);
        setting s = setting_at(degrees, i);
        part p = part_of(&s, radius);
        rk_vec2 from = rk_disk_at(RK_DISK_POLAR, noise2(42, i));
        cut += check_area_fits(&p, from);
        /* Each differs from the one before in one thing. */
        from.x = -from.x;
        cut += check_area_fits(&p, from);
        from.y = -from.y;
        cut += check_area_fits(&p, from);
        part wider = part_of(&s, 1.5f * radius);
        cut += check_area_fits(&wider, from);
        /* Turned half around w, so that the fraction stays the same. */
        setting turned = {
            s.reflected,
            rk_sub(rk_scale(s.reflected, 2 * rk_dot(s.reflected, s.face_normal)), s.face_normal)};
        part across = part_of(&turned, 1.5f * radius);
        across.fraction = wider.fraction;
        cut += check_area_fits(&across, from);
        /* Near the top or the bottom, where chords are short. */
        double up = 1 - 0.1 * pow(10, -5 * (double)noise(41, i, 2)), end = sqrt(1 - up * up);
        cut += check_area_fits(
            &p, point_upright(&p, i % 2 ? up : -up, 0.9 * end * (2 * (double)noise(41, i, 3) - 1)));
    }
    rk_check(cut > 5000, "only %u of 30000 points are in disks cut by the face", cut);
    check_ends_of_chords();
}

/* Where little area is left, few roundings are a large part of it. */
static void points_near_the_top_keep_their_digits(void **state)
{
    (void)state;
    uint32_t cut = 0;
    for (uint32_t i = 0; i < 5000; i++) {
        setting s = setting_at(20 * (double)noise(51, i, 0), i);
        part p = part_of(&s, 0.5f + noise(51, i, 1));
        if (!(p.line > -1))
            continue;
        cut++;
        double up = 1 - 0.1 * pow(10, -3 * (double)noise(51, i, 2)); /* to 1e-4 below the top */
        double across = 0.9 * (2 * (double)noise(51, i, 3) - 1) * sqrt(1 - up * up);
        rk_vec2 from = point_upright(&p, up, across);
        rk_dvec3 at = seen_upright(&p, from), to = seen_upright(&p, moved(&p, from));
        double below = 1 - at.x, come = fmax(1 - to.x, 0x1p-24);
        /* The area grows with the height below the top to the power 3/2. Heights are off by a
         * rounding, and by that of the direction up times the distance across. */
        double of_heights = 0x1p-24 / come + 16 * 0x1p-24 * (sqrt(2 / below) + sqrt(2 / come));
        double want = p.fraction * area_beyond(at.x);
        rk_check_near(area_beyond(fmin(to.x, 1)), want, 2 * 1.5 * of_heights * want,
                      "fraction above %.4f: the area beyond the point %.6f up, which came from "
                      "%.6f up; in floats acos(d) - d sqrt(1 - d^2) has no digits left there",
                      p.fraction, to.x, at.x);
    }
    rk_check(cut > 2000, "only %u of 5000 disks are cut by the face", cut);
}

static void moved_points_are_in_the_disk_and_above_the_surface(void **state)
{
    (void)state;
    uint32_t cut = 0, along = 0;
    for (uint32_t i = 0; i < 100000; i++) {
        setting s = setting_at(90 * pow((double)noise(43, i, 0), 3), i);
        part p = part_of(&s, noise(43, i, 1));
        rk_vec2 from = rk_disk_at(maps[i % 2], noise2(44, i));
        if (i % 4 == 0) { /* at the rim's top or bottom, or near it, a rounding outside of it */
            double aside = i % 16 < 8 ? 0 : pow(10, -1 - 6 * (double)noise(43, i, 2));
            double rim = i % 3 ? 1 + 0x1p-23 : 1, up = (i % 8 ? rim : -rim) * cos(aside);
            from = point_upright(&p, up, (i % 5 ? rim : -rim) * sin(aside));
        }
        rk_vec2 to = moved(&p, from);
        rk_vec3 direction;
        bool above = rk_glossy_direction(&p.disk, to, &direction);
        double length = hypot((double)to.x, (double)to.y);
        rk_check(
            length <= 1 + 0x1p-22,
            "fraction above %.4f: (%.9g, %.9g), %.9g from the middle and %.9g up, was moved to "
            "(%.9g, %.9g), %.9g from the middle, outside the disk",
            p.fraction, (double)from.x, (double)from.y, hypot((double)from.x, (double)from.y),
            seen_upright(&p, from).x, (double)to.x, (double)to.y, length);
        /* The fraction is rounded to a float, which moves the line by that over its length. */
        double rounding = 0x1p-22 + pi * 0x1p-25 / sqrt(fmax(1 - p.line * p.line, 1e-30));
        rk_check(
            seen_upright(&p, to).x >= p.line - rounding,
            "radius %.3g, fraction above %.4f: a point was moved to %.9g, below the face at %.9g",
            (double)p.disk.radius, p.fraction, seen_upright(&p, to).x, p.line);
        cut += p.line > -1;
        along += !above && i % 4;
    }
    rk_check(cut > 10000, "only %u disks are cut by the face", cut);
    /* Apart from a few so near the line that rounding takes them to the other side. */
    rk_check(along <= 2, "%u of 75000 moved points lead into the surface", along);
}

static void a_disk_above_the_surface_keeps_its_points(void **state)
{
    (void)state;
    rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(0, 0, 1), 1, rk_vec(0, 0, 1));
    for (uint32_t i = 0; i < 10000; i++) {
        if (i % 2)
            disk = rk_glossy_disk_of(noise_direction(45, i), 0.5f, noise_direction(46, i));
        rk_vec2 at = rk_disk_at(maps[i % 2], noise2(47, i)),
                to = rk_glossy_point_above(&disk, 1, at);
        rk_check(to.x == at.x && to.y == at.y,
                 "fraction above 1: (%.9g, %.9g) was moved to (%.9g, %.9g), want it where it is",
                 (double)at.x, (double)at.y, (double)to.x, (double)to.y);
    }
}

/* 16 strips of equal area along the surface, each cut into 16 parts. */
static void moved_points_fill_the_part_above_evenly(void **state)
{
    (void)state;
    enum { side = 16, cells = side * side, points = 256 * 200 };
    const double degrees[] = {0.5, 10, 20};
    for (uint32_t k = 0; k < 3; k++) {
        static uint32_t counts[cells];
        memset(counts, 0, sizeof counts);
        setting s = setting_at(degrees[k], k);
        part p = part_of(&s, 0.5f);
        for (uint32_t i = 0; i < points; i++) {
            rk_dvec3 to = seen_upright(&p, moved(&p, rk_disk_at(maps[k % 2], noise2(48 + k, i))));
            double up = fmin(fmax(to.x, p.line), 1);
            /* area_beyond(up), but for the last digits near the top, in a few steps. */
            double beyond = (acos(up) - up * sqrt(1 - up * up)) / pi;
            double strip = beyond / p.fraction * side;
            double place = (to.y / sqrt(1 - up * up) + 1) / 2 * side;
            counts[(int)fmin(strip, side - 1) * side + (int)fmin(fmax(place, 0), side - 1)]++;
        }
        double chi2 = 0, want = (double)points / cells;
        for (int i = 0; i < cells; i++)
            chi2 += (counts[i] - want) * (counts[i] - want) / want;
        /* 255 degrees of freedom: above 378 once in a million times, below 161 as rarely. */
        rk_check(
            chi2 > 161 && chi2 < 378,
            "%g degrees above the surface: of %d moved points in %d cells of equal area, chi^2 is "
            "%.1f, want 161 to 378",
            degrees[k], points, cells, chi2);
    }
}

/* --- Estimates -------------------------------------------------------------------------------- */

static const char *const weight_names[] = {
    [RK_GLOSSY_CLASSIC] = "classic", [RK_GLOSSY_RENORMALIZED] = "renormalized"};
static const char *const sampler_names[] = {"uniform", "stratified", "low-discrepancy"};

typedef struct estimates {
    uint32_t samples; /* in each */
    double mean, standard_error;
} estimates;

/* The mean radiance of the samples, by many pixels with few samples each. */
static estimates estimate(const part *p, rk_glossy_weights weights, rk_sampler_kind kind,
                          rk_disk_map map, uint32_t samples)
{
    const uint32_t pixels = 8000 / samples;
    const rk_sampler sampler = {kind, 5, samples, 0};
    double sum = 0, squares = 0;
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        double radiance = 0;
        for (uint32_t i = 0; i < samples; i++) {
            rk_vec2 at = rk_disk_at(map, rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_GLOSSY));
            rk_vec3 direction;
            if (rk_glossy_direction(&p->disk, weights == RK_GLOSSY_CLASSIC ? at : moved(p, at),
                                    &direction))
                radiance += radiance_from(rk_widen(direction)) / samples;
        }
        sum += radiance;
        squares += radiance * radiance;
    }
    double mean = sum / pixels;
    return (estimates){samples, mean, sqrt(fmax(squares / pixels - mean * mean, 0) / pixels)};
}

static void check_unbiased(rk_glossy_weights weights)
{
    const double degrees[] = {0.5, 10, 30, 60};
    const uint32_t sample_counts[] = {1, 2, 3, 4, 16};
    for (uint32_t i = 0; i < 60; i++) {
        setting s = setting_at(degrees[i % 4], i);
        part p = part_of(&s, 0.6f);
        /* The kink at the rim costs up to 4e-6. */
        integral whole = integrate(&s, 0.6, 4096, true);
        double want =
            weights == RK_GLOSSY_CLASSIC ? whole.radiance : whole.radiance / whole.fraction;
        rk_sampler_kind kind = (rk_sampler_kind)(i % 3);
        estimates got = estimate(&p, weights, kind, maps[i % 2], sample_counts[i % 5]);
        /* 5 standard errors, exceeded once in 1.7 million times; and roundings to float. */
        double tolerance = 5 * got.standard_error + 1e-5;
        rk_check(fabs(got.mean - want) <= tolerance,
                 "%s weights, %u %s samples in each pixel, fraction above %.4f: the mean of all "
                 "pixels is %.6f, want %.6f within %.6f",
                 weight_names[weights], got.samples, sampler_names[kind], p.fraction, got.mean,
                 want, tolerance);
    }
}

static void discarded_directions_count_as_black(void **state)
{
    (void)state;
    check_unbiased(RK_GLOSSY_CLASSIC);
}

static void moved_points_estimate_the_mean_over_the_part_above(void **state)
{
    (void)state;
    check_unbiased(RK_GLOSSY_RENORMALIZED);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_basis_around_an_axis_is_exact),
    cmocka_unit_test(a_basis_is_orthonormal_near_the_poles),
    cmocka_unit_test(a_basis_is_orthonormal_for_a_million_directions),
    cmocka_unit_test(a_basis_is_orthonormal_on_and_near_the_equator),
    cmocka_unit_test(the_polar_map_takes_a_root_and_an_angle),
    cmocka_unit_test(the_concentric_map_keeps_the_middle_and_the_axes),
    cmocka_unit_test(the_concentric_map_makes_squares_into_circles),
    cmocka_unit_test(the_concentric_map_keeps_neighbours_together),
    cmocka_unit_test(points_stay_in_the_disk),
    cmocka_unit_test(points_fill_cells_of_the_disk_evenly),
    cmocka_unit_test(radius_squared_and_angle_are_uniform),
    cmocka_unit_test(the_radius_is_half_over_the_shininess),
    cmocka_unit_test(a_dull_surface_has_the_widest_disk),
    cmocka_unit_test(radius_0_and_the_middle_give_the_reflected_direction_exactly),
    cmocka_unit_test(directions_are_unit_and_go_through_their_point_of_the_disk),
    cmocka_unit_test(no_direction_leads_into_the_surface),
    cmocka_unit_test(a_direction_along_the_surface_is_discarded),
    cmocka_unit_test(discarded_directions_count_as_black),
    cmocka_unit_test(a_disk_above_the_surface_has_a_fraction_above_of_1),
    cmocka_unit_test(a_disk_halved_by_the_surface_has_a_fraction_above_of_one_half),
    cmocka_unit_test(rounding_never_takes_more_than_half_of_the_disk_below),
    cmocka_unit_test(the_fraction_above_equals_quadrature),
    cmocka_unit_test(a_small_disk_is_cut_like_a_large_one),
    cmocka_unit_test(the_fraction_above_depends_on_direction_radius_and_face),
    cmocka_unit_test(a_disk_above_the_surface_keeps_its_points),
    cmocka_unit_test(a_halved_disk_moves_its_points_up),
    cmocka_unit_test(points_move_until_the_area_beyond_them_fits),
    cmocka_unit_test(points_near_the_top_keep_their_digits),
    cmocka_unit_test(moved_points_are_in_the_disk_and_above_the_surface),
    cmocka_unit_test(moved_points_fill_the_part_above_evenly),
    cmocka_unit_test(moved_points_estimate_the_mean_over_the_part_above),
};

RK_SUITE("glossy_reflection", tests)
