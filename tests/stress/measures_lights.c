/* Lights with an extent: the closed forms, and samples. References in binary128 where the compiler
 * has it, because lights that are seen from the side or from afar cancel nearly all digits of
 * smaller formats. */
#include "measure.h"

#include "features/parallelogram_light.h"

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 real;
#else
typedef long double real;
#endif

typedef struct real3 {
    real x, y, z;
} real3;

static real3 real_of(rk_vec3 v)
{
    return (real3){v.x, v.y, v.z};
}

static real3 madd(real3 a, real3 b, real s)
{
    return (real3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static real dot(real3 a, real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static real3 cross(real3 a, real3 b)
{
    return (real3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* One step of Newton's method doubles the digits. */
static real root(real square)
{
    real estimate = sqrtl((wide)square);
    return estimate > 0 ? (estimate + square / estimate) / 2 : 0;
}

static real size(real3 a)
{
    return root(dot(a, a));
}

static real absolute(real x)
{
    return x < 0 ? -x : x;
}

/* Inputs: corner, two edges, the point. */
static rk_light light_of(const float *in, rk_light_kind kind)
{
    const rk_vec3 white = {1, 1, 1};
    return (rk_light){
        kind, vector_of(in), vector_of(in + 3), vector_of(in + 6), {white, white, white, white}};
}

typedef struct seen {
    real3 corner[4];
} seen;

static seen seen_from(const rk_light *light, rk_vec3 point)
{
    real3 at = madd(real_of(light->position), real_of(point), -1);
    real3 edge01 = real_of(light->edge01), edge02 = real_of(light->edge02);
    return (seen){
        {at, madd(at, edge01, 1), madd(madd(at, edge01, 1), edge02, 1), madd(at, edge02, 1)}};
}

/* The angles of 0 of lights without area, and of edges that point at the point, are not measured:
 * the suite has them. */
static bool is_plain(const rk_light *light, const seen *s)
{
    real3 normal = cross(real_of(light->edge01), real_of(light->edge02));
    real largest = 0, smallest = (real)INFINITY;
    for (int i = 0; i < 4; i++) {
        real length = size(s->corner[i]);
        largest = length > largest ? length : largest;
        smallest = length < smallest ? length : smallest;
    }
    return dot(normal, normal) > 0 && dot(normal, s->corner[0]) != 0 && smallest > 0 &&
           largest < 0x1p40;
}

/* --- The solid angle -------------------------------------------------------------------------- */

/* A triangle's solid angle is twice the angle of (rest, volume). */
typedef struct triangle_seen {
    real volume, rest, lengths; /* lengths: of the corners, multiplied */
} triangle_seen;

static triangle_seen look_at(real3 a, real3 b, real3 c)
{
    real la = size(a), lb = size(b), lc = size(c);
    real volume = absolute(dot(a, cross(madd(b, a, -1), madd(c, a, -1))));
    return (triangle_seen){volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb,
                           la * lb * lc};
}

static real solid_angle(triangle_seen t)
{
    return 2 * atan2l((wide)t.volume, (wide)t.rest);
}

/* How much of `rest` cancels: between the ends of a needle, where corners lie in nearly opposite
 * directions, all of it. */
static real cancellation(triangle_seen t)
{
    return t.lengths / root(t.volume * t.volume + t.rest * t.rest);
}

static double error_of_solid_angle(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_PARALLELOGRAM);
    rk_vec3 point = vector_of(in + 9);
    seen s = seen_from(&light, point);
    if (!is_plain(&light, &s))
        return (double)NAN;
    /* The routine divides at the diagonal from corner 1 to corner 2. */
    triangle_seen one = look_at(s.corner[0], s.corner[1], s.corner[2]);
    triangle_seen other = look_at(s.corner[0], s.corner[2], s.corner[3]);
    triangle_seen low = look_at(s.corner[0], s.corner[1], s.corner[3]);
    triangle_seen high = look_at(s.corner[2], s.corner[1], s.corner[3]);
    real want = solid_angle(one) + solid_angle(other);
    real3 edge01 = real_of(light.edge01), edge02 = real_of(light.edge02);
    real area = size(cross(edge01, edge02)), farthest = 0;
    real plane = absolute(dot(cross(edge01, edge02), s.corner[0])) / area;
    for (int i = 0; i < 4; i++)
        farthest = size(s.corner[i]) > farthest ? size(s.corner[i]) : farthest;
    real needle = size(edge01) * size(edge02) / area, of_low = cancellation(low);
    real of_rest = cancellation(high) > of_low ? cancellation(high) : of_low;
    real error = absolute(rk_light_solid_angle(&light, point) - want) / want;
    return (double)(error / (0x1p-53 * (farthest / plane * needle + of_rest)));
}

/* --- The irradiance --------------------------------------------------------------------------- */

/* Lambert's sum, clipped at the horizon. `angles` receives the sum of the angles, each times the
 * farthest corner's distance over that of its own line, by which roundings of corners grow. */
static wide polygon_irradiance(const seen *s, rk_vec3 normal, wide *angles)
{
    real3 n = real_of(normal), kept[8];
    int count = 0;
    for (int i = 0; i < 4; i++) {
        real3 a = s->corner[i], b = s->corner[(i + 1) % 4];
        real above_a = dot(n, a), above_b = dot(n, b);
        if (above_a >= 0)
            kept[count++] = a;
        if ((above_a >= 0) != (above_b >= 0))
            kept[count++] = madd(a, madd(b, a, -1), above_a / (above_a - above_b));
    }
    wide sum = 0, farthest = 0;
    for (int i = 0; i < 4; i++)
        farthest = fmaxl(farthest, (wide)size(s->corner[i]));
    *angles = 0;
    for (int i = 0; i < count; i++) {
        real3 a = kept[i], b = kept[(i + 1) % count], across = cross(a, b);
        real sine = size(across);
        if (!(sine > 0))
            continue;
        wide angle = atan2l((wide)sine, (wide)dot(a, b));
        sum += angle * (wide)(dot(n, across) / sine);
        *angles += angle * farthest * (wide)(size(madd(b, a, -1)) / sine);
    }
    return fabsl(sum) / 2;
}

static double error_of_irradiance(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_PARALLELOGRAM);
    rk_vec3 point = vector_of(in + 9), normal = direction_of(in + 12);
    seen s = seen_from(&light, point);
    if (!is_plain(&light, &s) || normal.x != normal.x)
        return (double)NAN;
    wide angles, want = polygon_irradiance(&s, normal, &angles);
    return error_in((wide)rk_light_irradiance(&light, point, normal), want,
                    eps * want + 0x1p-50L * angles);
}

/* --- Segments --------------------------------------------------------------------------------- */

/* Gauss and Legendre's rule with 8 points on each of 8 parts: for an arc of up to pi and waves of
 * twice the angle, its error is below 1e-20. */
static wide integrate(wide from, wide turn, wide cosine_part, wide sine_part)
{
    static const wide place[4] = {0.18343464249564980494L, 0.52553240991632898582L,
                                  0.79666647741362673959L, 0.96028985649753623168L};
    static const wide weight[4] = {0.36268378337836198297L, 0.31370664587788728734L,
                                   0.22238103445337447054L, 0.10122853629037625915L};
    wide sum = 0;
    for (int part = 0; part < 8; part++)
        for (int i = 0; i < 8; i++) {
            wide at = i < 4 ? place[i] : -place[i - 4];
            wide phi = from + turn * (part + 0.5L + at / 2) / 8;
            sum +=
                weight[i % 4] / 16 * cosl(phi) * (cosine_part * cosl(phi) + sine_part * sinl(phi));
        }
    return sum * turn;
}

/* False for inputs that the measures are not about. `unit` receives the angle that the segment
 * subtends, over its line's distance, times the farther end's over that distance, by which
 * roundings of the ends grow. */
static bool segment_irradiance(const rk_light *light, rk_vec3 point, rk_vec3 normal, wide *want,
                               wide *unit)
{
    real3 n = real_of(normal), a = seen_from(light, point).corner[0];
    real3 edge = real_of(light->edge01), b = madd(a, edge, 1);
    real whole = size(edge), begin = dot(n, a), end = dot(n, b);
    if (normal.x != normal.x || !(whole > 0) || !(size(cross(a, edge)) > 0))
        return false;
    real farther = size(a) > size(b) ? size(a) : size(b);
    if (begin < 0 && end > 0)
        a = madd(a, edge, begin / (begin - end));
    if (end < 0 && begin > 0)
        b = madd(b, edge, -end / (end - begin));
    *want = *unit = 0;
    real distance = size(cross(a, edge)) / whole;
    real3 foot = madd(a, edge, -dot(a, edge) / (whole * whole));
    if (begin > 0 || end > 0) {
        wide turn = atan2l((wide)size(cross(a, madd(b, a, -1))), (wide)dot(a, b));
        wide from = atan2l((wide)(dot(a, edge) / whole), (wide)distance);
        wide along = (wide)(dot(n, foot) / distance), across = (wide)(dot(n, edge) / whole);
        *want = integrate(from, turn, along, across) / (wide)distance;
        *unit = turn / (wide)distance * (wide)(farther / distance);
    }
    return *want < 0x1p100L && (wide)distance > 0x1p-40L;
}

static double error_of_segment(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_SEGMENT);
    rk_vec3 point = vector_of(in + 9), normal = direction_of(in + 12);
    wide want, unit;
    if (!segment_irradiance(&light, point, normal, &want, &unit))
        return (double)NAN;
    return error_in((wide)rk_light_irradiance(&light, point, normal), want,
                    eps * want + 0x1p-50L * unit);
}

/* Before it is rounded to a float, which would hide small errors from the search. */
static double error_of_segment_in_double(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_SEGMENT);
    rk_vec3 point = vector_of(in + 9), normal = direction_of(in + 12);
    wide want, unit;
    if (!segment_irradiance(&light, point, normal, &want, &unit) || !(unit > 0))
        return (double)NAN;
    rk_dvec3 from = rk_dmadd(rk_widen(light.position), rk_widen(point), -1);
    double got = rk_light_segment_irradiance(from, rk_widen(light.edge01), rk_widen(normal));
    return got == got ? (double)(fabsl((wide)got - want) / (0x1p-53L * unit)) : (double)INFINITY;
}

/* --- Samples ---------------------------------------------------------------------------------- */

static double error_of_position(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_PARALLELOGRAM);
    wide3 p = widen3(light.position), e = widen3(light.edge01), f = widen3(light.edge02);
    wide x = (wide)in[12], y = (wide)in[13];
    rk_light_sample sample = rk_light_sample_at(&light, RK_FALLOFF_NONE, RK_LIGHT_DOMAIN_AREA,
                                                vector_of(in + 9), (rk_vec2){in[12], in[13]});
    wide3 sizes = {fabsl(p.x) + fabsl(e.x * x) + fabsl(f.x * y),
                   fabsl(p.y) + fabsl(e.y * x) + fabsl(f.y * y),
                   fabsl(p.z) + fabsl(e.z * x) + fabsl(f.z * y)};
    return error3_each(sample.position, wide_madd(wide_madd(p, e, x), f, y),
                       wide_scale(sizes, eps));
}

static double error_of_weight(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_PARALLELOGRAM);
    seen s = seen_from(&light, vector_of(in + 9));
    real3 edge01 = real_of(light.edge01), edge02 = real_of(light.edge02);
    real3 d = madd(madd(s.corner[0], edge01, in[12]), edge02, in[13]),
          normal = cross(edge01, edge02);
    real distance = size(d), square = distance * distance;
    if (!(distance > 0))
        return (double)NAN;
    wide want = (wide)(absolute(dot(d, normal)) / (square * distance));
    wide most = (wide)(size(edge01) * size(edge02) / square);
    if (!(most < 0x1p100L && most > 0x1p-100L) || size(s.corner[0]) > 0x1p20 * distance)
        return (double)NAN;
    rk_light_sample sample = rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_AREA,
                                                vector_of(in + 9), (rk_vec2){in[12], in[13]});
    return error_in((wide)sample.colour.x, want, eps * want + 0x1p-29L * eps * most);
}

/* How far beside the parallelogram is a sample over the solid angle? */
static double outside_of_light(const float *in)
{
    rk_light light = light_of(in, RK_LIGHT_PARALLELOGRAM);
    rk_light_sample sample =
        rk_light_sample_at(&light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_SOLID_ANGLE,
                           vector_of(in + 9), (rk_vec2){in[12], in[13]});
    seen s = seen_from(&light, vector_of(in + 9));
    if (!is_plain(&light, &s))
        return (double)NAN;
    if (!isfinite(sample.colour.x) || !(sample.colour.x >= 0 && sample.colour.x <= 6.5f))
        return rk_light_solid_angle(&light, vector_of(in + 9)) > 0x1p-32 ? (double)INFINITY
                                                                         : (double)NAN;
    real3 edge01 = real_of(light.edge01), edge02 = real_of(light.edge02);
    real3 normal = cross(edge01, edge02);
    real3 at = madd(real_of(sample.position), real_of(light.position), -1);
    real area = dot(normal, normal);
    real x = dot(cross(at, edge02), normal) / area, y = dot(cross(edge01, at), normal) / area;
    real over = x > 1 ? x - 1 : x < 0 ? -x : 0, beside = y > 1 ? y - 1 : y < 0 ? -y : 0;
    real far = over * size(edge01) + beside * size(edge02);
    real needle = size(edge01) * size(edge02) / root(area);
    real all = size(real_of(light.position)) + size(edge01) + size(edge02);
    return (double)(far / ((real)eps * all * needle));
}

#define LIGHT_INPUTS                                                                               \
    {SIGNED, 9, -20, 20},                                                                          \
    {                                                                                              \
        SIGNED, 3, -20, 20                                                                         \
    }

static const measure list[] = {
    {.routine = "rk_light_solid_angle",
     .what = "relative error, 2^-53 of the distance to the farthest corner over that to the plane, "
             "times edges over height, and of the cancellation between a needle's ends",
     .error = error_of_solid_angle,
     .domains = {LIGHT_INPUTS},
     .bound = 16,
     .because = "the volume: 6, the other sum: 10 of corners, roots, products and sums",
     .reference = "binary128, divided at the other diagonal",
     .cost = 8},
    {.routine = "rk_light_irradiance: parallelogram",
     .what = "error, eps of the value and 2^-50 of the angles of its sides, times the farthest "
             "corner's "
             "distance over the side's",
     .error = error_of_irradiance,
     .domains = {LIGHT_INPUTS, {SIGNED, 3, -20, 1}},
     .bound = 2,
     .because = "a rounding to float; those to double, of sides and horizon, are 8 each",
     .reference = "binary128",
     .cost = 8},
    {.routine = "rk_light_irradiance: segment",
     .what = "error, eps of the value and 2^-50 of the angle over the distance, times the farther "
             "end's over that",
     .error = error_of_segment,
     .domains = {LIGHT_INPUTS, {SIGNED, 3, -20, 1}},
     .bound = 2,
     .because = "a rounding to float; those to double are 8",
     .reference = "binary128, quadrature over the angle",
     .cost = 8},
    {.routine = "rk_light_segment_irradiance",
     .what = "error, 2^-53 of the angle over the distance, times the farther end's over that",
     .error = error_of_segment_in_double,
     .domains = {LIGHT_INPUTS, {SIGNED, 3, -20, 1}},
     .bound = 24,
     .because =
         "the line's distance: 3, in the angle, its foot and the quotient; both ends' angles: 3 "
         "each; products and sums: 9",
     .reference = "binary128, quadrature over the angle",
     .cost = 8},
    {.routine = "rk_light_sample_at",
     .what = "error of the position, eps times the sum of its terms",
     .error = error_of_position,
     .domains = {LIGHT_INPUTS, {FRACTION, 2, 0, 1}},
     .bound = 3,
     .because = "a product and two sums",
     .reference = "long double"},
    {.routine = "rk_light_sample_at: by area",
     .what =
         "error of the weight, eps of it and 2^-53 of the weight of a light that faces the point",
     .error = error_of_weight,
     .domains = {LIGHT_INPUTS, {FRACTION, 2, 0, 1}},
     .bound = 6,
     .because = "the weight: 1, four equal colours mixed: 3, their product; twelve of 2^-53",
     .reference = "binary128",
     .cost = 4},
    {.routine = "rk_light_sample_at: by solid angle",
     .what = "distance of a position outside of the light, eps times size, edges over height",
     .error = outside_of_light,
     .domains = {LIGHT_INPUTS, {FRACTION, 2, 0, 1}},
     .bound = 8,
     .because = "a product and two sums, of the place on each edge, which is itself rounded",
     .reference = "binary128",
     .cost = 4},
};

const measures measures_of_lights = {list, sizeof list / sizeof *list};
