/* Maps from samples to points and directions, and the bases that they are rotated by. */
#include "measure.h"

#include "features/ambient_occlusion.h"
#include "features/glossy_reflection.h"

static const wide pi = 3.14159265358979323846264338L;

/* --- Disk and hemisphere ---------------------------------------------------------------------- */

typedef struct wide2 {
    wide x, y;
} wide2;

static wide2 concentric(rk_vec2 xi)
{
    wide x = 2 * (wide)xi.x - 1, y = 2 * (wide)xi.y - 1;
    bool wider = fabsl(x) > fabsl(y);
    wide radius = wider ? x : y;
    if (radius == 0)
        return (wide2){0, 0};
    wide angle = wider ? pi / 4 * (y / x) : pi / 2 - pi / 4 * (x / y);
    return (wide2){radius * cosl(angle), radius * sinl(angle)};
}

static double error_of_concentric(const float *in)
{
    const rk_vec2 xi = {in[0], in[1]}, got = rk_disk_at(RK_DISK_CONCENTRIC, xi);
    wide2 want = concentric(xi);
    return fmax(error_in((wide)got.x, want.x, eps), error_in((wide)got.y, want.y, eps));
}

static double error_of_polar(const float *in)
{
    const rk_vec2 got = rk_disk_at(RK_DISK_POLAR, (rk_vec2){in[0], in[1]});
    wide radius = sqrtl((wide)in[0]), angle = 2 * pi * (wide)in[1];
    return fmax(error_in((wide)got.x, radius * cosl(angle), eps),
                error_in((wide)got.y, radius * sinl(angle), eps));
}

static double error_of_uniform_direction(const float *in)
{
    rk_vec3 got = rk_ambient_hemisphere(RK_AMBIENT_UNIFORM, (rk_vec2){in[0], in[1]});
    wide z = 1 - (wide)in[0], radius = sqrtl(1 - z * z), angle = 2 * pi * (wide)in[1];
    if (!(got.z > 0))
        return (double)INFINITY;
    return error3_in(got, (wide3){radius * cosl(angle), radius * sinl(angle), z}, eps);
}

/* Near the horizon z is the root of a difference: the length of the vector says more. */
static double length_of_cosine_direction(const float *in)
{
    rk_vec3 got = rk_ambient_hemisphere(RK_AMBIENT_COSINE, (rk_vec2){in[0], in[1]});
    if (!(got.z >= 0))
        return (double)INFINITY;
    return error_in(wide_length(widen3(got)), 1, eps);
}

static double length_of_ambient_direction(const float *in)
{
    rk_vec3 normal = direction_of(in), direction;
    if (normal.x != normal.x)
        return (double)NAN;
    rk_ambient_frame frame = rk_ambient_frame_of(normal, normal);
    rk_vec3 local = rk_ambient_hemisphere(RK_AMBIENT_UNIFORM, (rk_vec2){in[3], in[4]});
    rk_ambient_direction(&frame, local, &direction);
    return error_in(wide_length(widen3(direction)), 1, eps);
}

/* --- Bases ------------------------------------------------------------------------------------ */

static double error_of_basis(const float *in)
{
    rk_vec3 w = direction_of(in), u, v;
    if (w.x != w.x)
        return (double)NAN;
    rk_basis_of(w, &u, &v);
    wide3 a = widen3(u), b = widen3(v), c = wide_unit(widen3(w));
    double lengths = fmax(error_in(wide_length(a), 1, eps), error_in(wide_length(b), 1, eps));
    double angles = fmax(error_in(wide_dot(a, c), 0, eps), error_in(wide_dot(b, c), 0, eps));
    return fmax(fmax(lengths, angles), error_in(wide_dot(a, b), 0, eps));
}

/* --- Rough mirrors ---------------------------------------------------------------------------- */

static double error_of_radius(const float *in)
{
    wide want = 0.5L / fmaxl((wide)in[0], 0.5L);
    return error_in((wide)rk_glossy_radius(in[0]), want, eps * want);
}

/* Inputs: the reflected direction, the normal, the radius; then a sample. */
static bool disk_of(const float *in, rk_glossy_disk *disk)
{
    rk_vec3 w = direction_of(in), n = direction_of(in + 3);
    if (!(rk_dot(w, n) >= 0))
        return false;
    *disk = rk_glossy_disk_of(w, in[6], n);
    return true;
}

static double length_of_glossy_direction(const float *in)
{
    rk_glossy_disk disk;
    rk_vec3 direction;
    if (!disk_of(in, &disk))
        return (double)NAN;
    rk_glossy_direction(&disk, rk_disk_at(RK_DISK_CONCENTRIC, (rk_vec2){in[7], in[8]}), &direction);
    return error_in(wide_length(widen3(direction)), 1, eps);
}

/* How the disk lies above the plane, exactly. */
typedef struct tilt {
    wide height, reach;
} tilt;

static tilt tilt_of(const rk_glossy_disk *disk)
{
    wide3 w = widen3(disk->w), n = widen3(disk->face_normal);
    return (tilt){wide_dot(w, n), (wide)disk->radius * wide_length(wide_cross(w, n))};
}

static double error_of_fraction(const float *in)
{
    rk_glossy_disk disk;
    if (!disk_of(in, &disk))
        return (double)NAN;
    tilt t = tilt_of(&disk);
    wide d = fmaxl(t.height, 0) / t.reach, want = 1;
    if (d < 1)
        want = 1 - (acosl(d) - d * sqrtl(1 - d * d)) / pi;
    /* The height is known to eps, the reach to eps of the radius: both in units of the reach. */
    wide unit = eps * (1 + (1 + (wide)disk.radius) / t.reach);
    return t.reach > 0x1p-20L ? error_in((wide)rk_glossy_fraction_above(&disk), want, unit)
                              : (double)NAN;
}

static double outside_of_disk(const float *in)
{
    rk_glossy_disk disk;
    if (!disk_of(in, &disk))
        return (double)NAN;
    rk_vec2 at = rk_disk_at(RK_DISK_CONCENTRIC, (rk_vec2){in[7], in[8]});
    float fraction = rk_glossy_fraction_above(&disk);
    if (!(fraction >= 0.5f - 0x1p-20f && fraction <= 1))
        return (double)INFINITY;
    rk_vec2 got = rk_glossy_point_above(&disk, fraction, at);
    if (got.x != got.x || got.y != got.y)
        return (double)INFINITY;
    wide length = sqrtl((wide)got.x * (wide)got.x + (wide)got.y * (wide)got.y);
    return (double)((length - 1) / eps);
}

/* How far below the face does a point lie that should be above it, on the disk at distance 1? The
 * fraction is a float near 1 where little is below, and the area there is the cube of half the
 * arc's angle; below 0.005 it rounds to 1, and nothing is moved. */
static double below_face(const float *in)
{
    rk_glossy_disk disk;
    if (!disk_of(in, &disk))
        return (double)NAN;
    rk_vec2 at = rk_disk_at(RK_DISK_CONCENTRIC, (rk_vec2){in[7], in[8]});
    rk_vec2 got = rk_glossy_point_above(&disk, rk_glossy_fraction_above(&disk), at);
    wide3 to = wide_madd(widen3(disk.w), widen3(disk.u), (wide)disk.radius * (wide)got.x);
    to = wide_madd(to, widen3(disk.v), (wide)disk.radius * (wide)got.y);
    tilt t = tilt_of(&disk);
    wide angle = t.height < t.reach ? acosl(fmaxl(t.height, 0) / t.reach) : 0;
    wide unit = eps * (1 + (wide)disk.radius) * (1 + 1 / fmaxl(angle, 0.005L));
    return (double)(-wide_dot(to, widen3(disk.face_normal)) / unit);
}

#define GLOSSY_INPUTS                                                                              \
    {SIGNED, 6, -24, 1}, {POSITIVE, 1, -20, 9.9657f},                                              \
    {                                                                                              \
        FRACTION, 2, 0, 1                                                                          \
    }

static const measure list[] = {
    {.routine = "rk_disk_at: concentric",
     .what = "error of a coordinate, eps",
     .error = error_of_concentric,
     .domains = {{FRACTION, 2, 0, 1}},
     .bound = 4,
     .because = "an angle of pi / 4 at most: 2, the cosine: 1, a product: 0.5; pi / 4: 0.5",
     .reference = "long double"},
    {.routine = "rk_disk_at: polar",
     .what = "error of a coordinate, eps",
     .error = error_of_polar,
     .domains = {{FRACTION, 2, 0, 1}},
     .bound = 12,
     .because = "an angle of 2 pi at most: 9.2, the root: 1, the cosine: 1, a product: 0.5",
     .reference = "long double"},
    {.routine = "rk_ambient_hemisphere: uniform",
     .what = "error of a component, eps",
     .error = error_of_uniform_direction,
     .domains = {{FRACTION, 2, 0, 1}},
     .bound = 13,
     .because = "an angle of 2 pi at most: 9.2, the radius: 2, the cosine: 1, a product: 0.5",
     .reference = "long double"},
    {.routine = "rk_ambient_hemisphere: cosine",
     .what = "length, above or below 1, eps",
     .error = length_of_cosine_direction,
     .domains = {{FRACTION, 2, 0, 1}},
     .bound = 4,
     .because = "the disk's point, in so far as it leaves it: 2; squares and differences: 1.5, "
                "halved; the root",
     .reference = "long double"},
    {.routine = "rk_basis_of",
     .what = "length of an axis or cosine between two, eps",
     .error = error_of_basis,
     .domains = {{SIGNED, 3, -24, 1}},
     .bound = 6,
     .because = "a component of each axis is a product of two, times a quotient of two roundings, "
                "and a sum; w's own length: 1",
     .reference = "long double"},
    {.routine = "rk_ambient_direction",
     .what = "length, above or below 1, eps",
     .error = length_of_ambient_direction,
     .domains = {{SIGNED, 3, -24, 1}, {FRACTION, 2, 0, 1}},
     .bound = 12,
     .because = "the basis: 6, the direction: 3, three roundings of each component",
     .reference = "long double"},
    {.routine = "rk_glossy_radius",
     .what = "relative error, eps",
     .error = error_of_radius,
     .domains = {{POSITIVE, 1, -20, 120}},
     .bound = 1,
     .because = "a quotient",
     .reference = "long double"},
    {.routine = "rk_glossy_direction",
     .what = "length, above or below 1, eps",
     .error = length_of_glossy_direction,
     .domains = {GLOSSY_INPUTS},
     .bound = 12,
     .because = "the basis: 6, two sums and products of each component: 3; the length: 3",
     .reference = "long double"},
    {.routine = "rk_glossy_fraction_above",
     .what = "error, eps (1 + (1 + radius) / reach)",
     .error = error_of_fraction,
     .domains = {GLOSSY_INPUTS},
     .bound = 4,
     .because = "height: 3, reach: 3 and more of the cross product, times 2 / pi",
     .reference = "long double"},
    {.routine = "rk_glossy_point_above",
     .what = "distance beyond the disk's rim, eps",
     .error = outside_of_disk,
     .domains = {GLOSSY_INPUTS},
     .bound = 1,
     .because = "two coordinates are rounded once",
     .reference = "long double"},
    {.routine = "rk_glossy_point_above",
     .what = "height below the face on the disk, eps (1 + radius) (1 + 1 / angle of the arc below)",
     .error = below_face,
     .domains = {GLOSSY_INPUTS},
     .bound = 6,
     .because = "height: 3 and reach: 3, of which the fraction is made",
     .reference = "long double"},
};

const measures measures_of_samples = {list, sizeof list / sizeof *list};
