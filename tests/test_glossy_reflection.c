/* Glossy reflection: the basis, the maps from square to disk, the discarded directions, and that
 * both kinds of weights estimate their integrals. */
#include "test.h"

#include "base/dvec3.h"
#include "base/random.h"
#include "features/glossy_reflection.h"

static const double pi = 3.14159265358979323846;

/* A number in [0, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_hash(a, b, c, 7));
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

/* The largest error of the two squared lengths, the three products, and u x v = w. */
static basis_error basis_error_of(rk_vec3 direction)
{
    rk_vec3 u_float, v_float;
    rk_basis_of(direction, &u_float, &v_float);
    rk_dvec3 w = rk_widen(direction), u = rk_widen(u_float), v = rk_widen(v_float);
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

static void check_basis(rk_vec3 w, double most)
{
    basis_error error = basis_error_of(w);
    rk_check(error.size <= most, "w = (%.9g, %.9g, %.9g): %s is off by %.3g, want %.3g at most",
             (double)w.x, (double)w.y, (double)w.z, error.of, error.size, most);
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
    for (uint32_t i = 0; i < 1000000; i++)
        check_basis(noise_direction(1, i), basis_bound);
}

static void a_basis_is_orthonormal_near_the_poles(void **state)
{
    (void)state;
    /* From 45 degrees down to a tilt of the smallest float, on both sides. */
    for (int e = 0; e <= 149; e++)
        for (uint32_t i = 0; i < 64; i++) {
            double tilt = ldexp(pi / 4, -e), phi = 2 * pi * (double)noise(2, i, 0);
            float x = (float)(sin(tilt) * cos(phi)), y = (float)(sin(tilt) * sin(phi));
            float z = (float)cos(tilt);
            check_basis(rk_vec(x, y, z), basis_bound);
            check_basis(rk_vec(x, y, -z), basis_bound);
        }
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

static void check_point(rk_disk_map map, rk_vec2 xi, double x, double y, const char *hint)
{
    rk_vec2 got = rk_disk_at(map, xi);
    rk_check(fabs((double)got.x - x) <= disk_rounding && fabs((double)got.y - y) <= disk_rounding,
             "%s map of xi (%.9g, %.9g): got (%.9g, %.9g), want (%.9g, %.9g) within %.3g: %s",
             map_names[map], (double)xi.x, (double)xi.y, (double)got.x, (double)got.y, x, y,
             disk_rounding, hint);
}

static void the_polar_map_takes_a_root_and_an_angle(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec2 xi = noise2(4, i);
        double r = sqrt((double)xi.x), theta = 2 * pi * (double)xi.y;
        check_point(RK_DISK_POLAR, xi, r * cos(theta), r * sin(theta),
                    "r = sqrt(xi.x), theta = 2 pi xi.y");
    }
}

static void the_concentric_map_keeps_the_middle_and_the_axes(void **state)
{
    (void)state;
    check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, 0.5f}, 0, 0, "the middle");
    check_point(RK_DISK_CONCENTRIC, (rk_vec2){0.5f, 0.5f - 0x1p-18f}, 0, -0x1p-17,
                "near the middle, but not the middle");
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
        rk_vec2 xi = noise2(5, i), got = rk_disk_at(RK_DISK_CONCENTRIC, xi);
        double r = fmax(fabs(2 * (double)xi.x - 1), fabs(2 * (double)xi.y - 1));
        rk_check_near(hypot((double)got.x, (double)got.y), r, disk_rounding,
                      "xi (%.9g, %.9g): the larger of |2 xi - 1| is the distance from the middle",
                      (double)xi.x, (double)xi.y);
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
    rk_check(longest > step, "nothing moved farther than %g: is this a disk of radius 1?", longest);
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
    enum { side = 16, cells = side * side, points = 256 * 1000 };
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

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Kolmogorov's statistic: the largest distance of a distribution from the uniform one on [0, 1]. */
static double distance_from_uniform(double *numbers, size_t count)
{
    double most = 0;
    qsort(numbers, count, sizeof *numbers, compare_doubles);
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fmax(numbers[i] - (double)i / (double)count,
                               (double)(i + 1) / (double)count - numbers[i]));
    return most;
}

static void radius_squared_and_angle_are_uniform(void **state)
{
    (void)state;
    enum { points = 100000 };
    static double areas[points], turns[points];
    for (int m = 0; m < 2; m++) {
        for (uint32_t i = 0; i < points; i++) {
            rk_vec2 p = rk_disk_at(maps[m], noise2(10 + (uint32_t)m, i));
            areas[i] = (double)p.x * (double)p.x + (double)p.y * (double)p.y;
            turns[i] = atan2((double)p.y, (double)p.x) / (2 * pi) + 0.5;
        }
        /* Exceeded once in a million times: 2 exp(-2 n d^2) = 1e-6 for d = 2.69 / sqrt(n). */
        double most = 2.69 / sqrt(points);
        rk_check_near(distance_from_uniform(areas, points), 0, most,
                      "%s map: largest gap between the distribution of the radius squared, the "
                      "fraction of the area inside, and the uniform one",
                      map_names[m]);
        rk_check_near(distance_from_uniform(turns, points), 0, most,
                      "%s map: largest gap between the distribution of the angle and the uniform "
                      "one",
                      map_names[m]);
    }
}

/* --- Directions ------------------------------------------------------------------------------- */

static void the_radius_is_half_over_the_shininess(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_radius(1), 0.5, 0, "0.5 / s");
    rk_check_close(rk_glossy_radius(8), 0.0625, 0, "0.5 / s");
    rk_check_close(rk_glossy_radius(1000), 0.0005, 1e-10, "a shiny surface has a small disk");
    rk_check_close(rk_glossy_radius(INFINITY), 0, 0, "a perfect mirror");
}

static void a_dull_surface_has_the_widest_disk(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_radius(0), 1, 0, "shininess 0: radius 1, not infinity");
    rk_check_close(rk_glossy_radius(0.25f), 1, 0, "0.5 / 0.25 would be wider than 1");
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

static void directions_are_unit_and_go_through_their_point_of_the_disk(void **state)
{
    (void)state;
    const float radii[] = {1e-4f, 0.1f, 1, 30};
    uint32_t kept = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        setting s = random_setting(i);
        float radius = radii[i % 4];
        rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, radius, s.face_normal);
        rk_vec2 at = rk_disk_at(maps[i / 4 % 2], noise2(25, i));
        rk_vec3 got = {NAN, NAN, NAN};
        kept += rk_glossy_direction(&disk, at, &got);
        rk_dvec3 to =
            rk_dmadd(rk_dmadd(rk_widen(disk.w), rk_widen(disk.u), (double)(radius * at.x)),
                     rk_widen(disk.v), (double)(radius * at.y));
        rk_dvec3 want = rk_dscale(to, 1 / rk_dlength(to));
        rk_dvec3 off = rk_dmadd(rk_widen(got), want, -1);
        /* The basis' own error, and a handful of roundings. */
        rk_check(
            rk_dlength(off) <= basis_bound + 8 * 0x1p-24,
            "w (%g, %g, %g), radius %g, point (%g, %g): got (%g, %g, %g), want (%g, %g, %g), the "
            "unit vector of w + x u + y v, even if it is discarded: off by %.3g",
            (double)disk.w.x, (double)disk.w.y, (double)disk.w.z, (double)radius, (double)at.x,
            (double)at.y, (double)got.x, (double)got.y, (double)got.z, want.x, want.y, want.z,
            rk_dlength(off));
    }
    rk_check(kept > 10000, "only %u of 20000 are above the surface", kept);
}

static void no_direction_leads_into_the_surface(void **state)
{
    (void)state;
    uint32_t kept = 0, discarded = 0;
    for (uint32_t i = 0; i < 200000; i++) {
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
    rk_check(kept > 20000 && discarded > 20000, "kept %u, discarded %u: both should happen", kept,
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
    for (int e = 2; e <= 100; e++) {
        disk.radius = ldexpf(1, -e);
        rk_check(rk_glossy_direction(&disk, halfway_along(&disk, up), &direction),
                 "w (1, 0, 0), face normal (0, 0, 1): discarded (1, 0, %g), which leads above it",
                 ldexp(0.5, -e));
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
static integral integrate(const setting *s, double radius)
{
    enum { angles = 16384, steps = 8 };
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
        for (int k = 0; k <= steps; k++) {
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

static void the_fraction_above_equals_quadrature(void **state)
{
    (void)state;
    const double radii[] = {0.02, 0.3, 1, 5};
    for (uint32_t i = 0; i < 200; i++) {
        double radius = radii[i % 4], degrees = atan(radius) * 180 / pi * (i % 50 + 0.5) / 50;
        setting s = setting_at(degrees, i);
        rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, (float)radius, s.face_normal);
        /* Roundings of 2^-24, which are divided by the radius near the surface; and the kink where
         * the plane cuts the rim, between two of 16384 angles. */
        rk_check_near(rk_glossy_fraction_above(&disk), integrate(&s, radius).fraction,
                      8 * 0x1p-24 / radius + 2e-6,
                      "fraction above, for a disk of radius %g, %.3g degrees above the surface: "
                      "the disk without its segment",
                      radius, degrees);
    }
}

/* --- Weights ---------------------------------------------------------------------------------- */

static const char *const weight_names[] = {
    [RK_GLOSSY_CLASSIC] = "classic", [RK_GLOSSY_RENORMALIZED] = "renormalized"};

static void classic_counts_discarded_samples_as_black(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_weight(RK_GLOSSY_CLASSIC, 64, 64, 1), 1 / 64.0, 0, "1 / samples");
    rk_check_close(rk_glossy_weight(RK_GLOSSY_CLASSIC, 32, 64, 0.5f), 1 / 64.0, 0,
                   "1 / samples, however many are discarded");
}

static void renormalized_divides_by_the_samples_above(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_weight(RK_GLOSSY_RENORMALIZED, 64, 64, 1), 1 / 64.0, 0, "all above");
    /* (1/2)^64 is far below the rounding. */
    rk_check_close(rk_glossy_weight(RK_GLOSSY_RENORMALIZED, 40, 64, 0.5f), 1 / 40.0, 1e-9,
                   "1 / above");
}

static void a_single_sample_counts_for_more_where_it_might_be_discarded(void **state)
{
    (void)state;
    rk_check_close(rk_glossy_weight(RK_GLOSSY_RENORMALIZED, 1, 1, 0.625f), 1 / 0.625, 1e-6,
                   "it also represents discarded samples: 1 / fraction above");
    rk_check_close(rk_glossy_weight(RK_GLOSSY_RENORMALIZED, 1, 2, 0.5f), 1 / 0.75, 1e-6,
                   "1 / (above (1 - (1 - fraction)^samples))");
    rk_check_close(rk_glossy_weight(RK_GLOSSY_RENORMALIZED, 1, 1, 1), 1, 0, "nothing is discarded");
}

static void without_a_direction_above_the_weight_is_zero(void **state)
{
    (void)state;
    const rk_glossy_weights both[] = {RK_GLOSSY_CLASSIC, RK_GLOSSY_RENORMALIZED};
    const float fractions[] = {0.5f, 0.75f, 1};
    for (int w = 0; w < 2; w++)
        for (int i = 0; i < 3; i++)
            rk_check_near(
                rk_glossy_weight(both[w], 0, 64, fractions[i]), 0, 0,
                "%s weight, none of 64 samples above, fraction above %g: no division by 0",
                weight_names[both[w]], (double)fractions[i]);
}

/* The mean of many estimates with `samples` samples each, against `want`. */
static void check_unbiased(const setting *s, float radius, rk_glossy_weights weights,
                           rk_disk_map map, uint32_t samples, double want)
{
    const uint32_t estimates = 200000 / samples;
    rk_glossy_disk disk = rk_glossy_disk_of(s->reflected, radius, s->face_normal);
    float fraction = rk_glossy_fraction_above(&disk);
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < estimates; i++) {
        double radiance = 0;
        uint32_t above = 0;
        for (uint32_t k = 0; k < samples; k++) {
            rk_vec3 direction;
            if (!rk_glossy_direction(&disk, rk_disk_at(map, noise2(30 + samples, i * samples + k)),
                                     &direction))
                continue;
            radiance += radiance_from(rk_widen(direction));
            above++;
        }
        radiance *= (double)rk_glossy_weight(weights, above, samples, fraction);
        sum += radiance;
        squares += radiance * radiance;
    }
    double mean = sum / estimates;
    double deviation = sqrt(fmax(squares / estimates - mean * mean, 0) / estimates);
    /* 5 standard errors, exceeded once in 1.7 million times; and roundings to float. */
    rk_check(fabs(mean - want) <= 5 * deviation + 1e-5,
             "%s weights, %u samples per estimate, radius %g, fraction above %g: the mean of %u "
             "estimates is %.6f, want %.6f within %.6f",
             weight_names[weights], samples, (double)radius, (double)fraction, estimates, mean,
             want, 5 * deviation + 1e-5);
}

static const uint32_t sample_counts[] = {1, 2, 5, 64};

static void classic_weights_estimate_the_integral_with_black_below(void **state)
{
    (void)state;
    const double heights[] = {0.5, 10, 30, 60};
    for (uint32_t i = 0; i < 16; i++) {
        setting s = setting_at(heights[i / 4], i);
        check_unbiased(&s, 0.6f, RK_GLOSSY_CLASSIC, maps[i % 2], sample_counts[i % 4],
                       integrate(&s, 0.6).radiance);
    }
}

static void renormalized_weights_estimate_the_mean_over_the_part_above(void **state)
{
    (void)state;
    const double heights[] = {0.5, 10, 30, 60};
    for (uint32_t i = 0; i < 16; i++) {
        setting s = setting_at(heights[i / 4], i);
        integral want = integrate(&s, 0.6);
        check_unbiased(&s, 0.6f, RK_GLOSSY_RENORMALIZED, maps[i % 2], sample_counts[i % 4],
                       want.radiance / want.fraction);
    }
}

static void in_a_white_room_classic_loses_the_fraction_below(void **state)
{
    (void)state;
    enum { samples = 100000 };
    const double heights[] = {0, 5, 15, 30, 45};
    for (uint32_t i = 0; i < 5; i++) {
        setting s = setting_at(heights[i], i);
        rk_glossy_disk disk = rk_glossy_disk_of(s.reflected, 0.6f, s.face_normal);
        float fraction = rk_glossy_fraction_above(&disk);
        uint32_t above = 0;
        for (uint32_t k = 0; k < samples; k++) {
            rk_vec3 direction;
            above += rk_glossy_direction(&disk, rk_disk_at(RK_DISK_CONCENTRIC, noise2(40, k)),
                                         &direction);
        }
        double classic =
            above * (double)rk_glossy_weight(RK_GLOSSY_CLASSIC, above, samples, fraction);
        double renormalized =
            above * (double)rk_glossy_weight(RK_GLOSSY_RENORMALIZED, above, samples, fraction);
        /* 5 standard deviations, of at most 1/2 per sample. */
        rk_check_near(classic, integrate(&s, 0.6).fraction, 5 * 0.5 / sqrt(samples),
                      "radius 0.6, %g degrees above the surface: classic reflects a white room "
                      "times the fraction above",
                      heights[i]);
        rk_check_near(renormalized, 1, 1e-6,
                      "radius 0.6, %g degrees above the surface: renormalized, a white room stays "
                      "white",
                      heights[i]);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_basis_around_an_axis_is_exact),
    cmocka_unit_test(a_basis_is_orthonormal_for_a_million_directions),
    cmocka_unit_test(a_basis_is_orthonormal_near_the_poles),
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
    cmocka_unit_test(a_disk_above_the_surface_has_a_fraction_above_of_1),
    cmocka_unit_test(a_disk_halved_by_the_surface_has_a_fraction_above_of_one_half),
    cmocka_unit_test(the_fraction_above_equals_quadrature),
    cmocka_unit_test(classic_counts_discarded_samples_as_black),
    cmocka_unit_test(renormalized_divides_by_the_samples_above),
    cmocka_unit_test(a_single_sample_counts_for_more_where_it_might_be_discarded),
    cmocka_unit_test(without_a_direction_above_the_weight_is_zero),
    cmocka_unit_test(classic_weights_estimate_the_integral_with_black_below),
    cmocka_unit_test(renormalized_weights_estimate_the_mean_over_the_part_above),
    cmocka_unit_test(in_a_white_room_classic_loses_the_fraction_below),
};

RK_SUITE("glossy_reflection", tests)
