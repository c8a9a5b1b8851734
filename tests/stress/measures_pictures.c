/* Bloom, cube maps, textures, and the colours of picture files. */
#include "measure.h"

#include "base/image.h"
#include "base/texture.h"
#include "features/bloom.h"
#include "features/cubemap.h"
#include "io/srgb8.h"

#include <string.h>

/* --- Bloom ------------------------------------------------------------------------------------ */

/* From the middle outwards, where the routine starts at the ends: C(2r, r) / 4^r is the product of
 * (2k - 1) / 2k. */
static double error_of_weights(const float *in)
{
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    uint32_t radius = (uint32_t)in[0];
    rk_bloom_weights(radius, weights);
    wide want = 1;
    for (uint32_t k = 1; k <= radius; k++)
        want *= (2 * (wide)k - 1) / (2 * (wide)k);
    double worst = 0;
    for (uint32_t k = 0; k <= radius && want > 0x1p-120L; k++) {
        int exponent;
        frexpl(want, &exponent);
        worst = fmax(worst, error_in((wide)weights[k], want, ldexpl(1, exponent - 24)));
        want *= ((wide)radius - k) / ((wide)radius + k + 1);
    }
    return worst;
}

static double error_of_weight_inside(const float *in)
{
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    uint32_t radius = (uint32_t)in[0];
    size_t length = (size_t)in[1], place = (size_t)(in[2] * (float)length);
    if (place >= length)
        return (double)NAN;
    rk_bloom_weights(radius, weights);
    const rk_bloom_filter filter = {radius, weights, RK_BLOOM_RENORMALIZE};
    wide want = 0;
    for (long k = -(long)radius; k <= (long)radius; k++)
        if ((long)place + k >= 0 && (long)place + k < (long)length)
            want += (wide)weights[k < 0 ? -k : k];
    return error_in((wide)rk_bloom_weight_inside(&filter, place, length), want, eps * want);
}

/* Lines of one value each; most of a filter's error is in the order of its sum. */
static double error_of_blur(const float *in)
{
    enum { reach = 9, lines = 2 * reach + 1 };
    static float pixels[lines][RK_BLOOM_BLOCK], weights[reach + 1], sum[RK_BLOOM_BLOCK];
    const float *pointers[lines];
    rk_bloom_weights(reach, weights);
    const rk_bloom_filter filter = {reach, weights, RK_BLOOM_ZERO};
    wide want = 0, size = 0;
    for (int k = 0; k < lines; k++) {
        for (int i = 0; i < RK_BLOOM_BLOCK; i++)
            pixels[k][i] = in[k];
        pointers[k] = in[k] == 0 ? NULL : pixels[k];
        wide term = (wide)weights[k < reach ? reach - k : k - reach] * (wide)in[k];
        want += term, size += fabsl(term);
    }
    rk_bloom_blur_lines(&filter, pointers, RK_BLOOM_BLOCK, sum);
    for (int i = 1; i < RK_BLOOM_BLOCK; i++)
        if (memcmp(&sum[i], &sum[0], sizeof *sum) != 0)
            return (double)INFINITY;
    return error_in((wide)sum[0], want, eps * size);
}

static double error_of_luminance(const float *in)
{
    wide red = (wide)in[0], green = (wide)in[1], blue = (wide)in[2];
    wide want = 0.2126L * red + 0.7152L * green + 0.0722L * blue;
    wide size = green + 0.2126L * fabsl(red - green) + 0.0722L * fabsl(blue - green);
    return error_in((wide)rk_bloom_luminance(vector_of(in)), want, eps * size);
}

/* --- Cube maps -------------------------------------------------------------------------------- */

enum { SIDE_MAX = 64 };

/* Texels of 0 and 1, next to each other as different as can be. */
static const rk_cubemap *map_of(uint32_t side)
{
    static rk_cubemap maps[SIDE_MAX + 1];
    rk_cubemap *map = &maps[side];
    rk_error error;
    if (map->side || !rk_cubemap_init(map, side, &error))
        return map;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < side * side; i++)
            map->faces[face][i] = rk_vec((float)((i / side + i + (uint32_t)face) % 2), 0, 0);
    return map;
}

static double error_of_place(const float *in)
{
    rk_vec3 d = vector_of(in);
    wide largest = wide_max3(fabsl((wide)d.x), fabsl((wide)d.y), fabsl((wide)d.z));
    if (largest == 0)
        return (double)NAN;
    rk_cube_place got = rk_cubemap_place(d);
    const rk_cube_axes *axes = &rk_cube_faces[got.face];
    if (wide_dot(widen3(d), widen3(axes->ahead)) != largest)
        return (double)INFINITY;
    wide u = (1 + wide_dot(widen3(d), widen3(axes->right)) / largest) / 2;
    wide v = (1 + wide_dot(widen3(d), widen3(axes->up)) / largest) / 2;
    return fmax(error_in((wide)got.u, u, eps), error_in((wide)got.v, v, eps));
}

/* Linear interpolation between 0 and 1: a place that is wrong by eps is wrong by side eps texels.
 */
static double error_of_bilinear(const float *in)
{
    uint32_t side = (uint32_t)in[3];
    const rk_cubemap *map = map_of(side);
    rk_cube_place at = rk_cubemap_place(vector_of(in));
    wide x = (wide)at.u * side - 0.5L, y = (wide)at.v * side - 0.5L;
    long i = (long)floorl(x), j = (long)floorl(y), last = (long)side - 1;
    wide want = 0, s = x - i, t = y - j;
    for (int k = 0; k < 4; k++) {
        long column = i + k % 2, above = j + k / 2;
        column = column < 0 ? 0 : column > last ? last : column;
        above = above < 0 ? 0 : above > last ? last : above;
        const rk_vec3 *texel =
            rk_cubemap_texel(map, at.face, (uint32_t)column, (uint32_t)(last - above));
        want += (wide)texel->x * (k % 2 ? s : 1 - s) * (k / 2 ? t : 1 - t);
    }
    rk_vec3 got = rk_cubemap_at(map, vector_of(in), RK_CUBEMAP_BILINEAR);
    return error_in((wide)got.x, want, eps * side);
}

/* Two neighbouring directions: how much does the colour jump, above the slope of one texel? */
static double jump_of_seamless(const float *in)
{
    uint32_t side = (uint32_t)in[3];
    rk_vec3 one = vector_of(in), other = one;
    wide largest = wide_max3(fabsl((wide)one.x), fabsl((wide)one.y), fabsl((wide)one.z));
    if (!(largest > 0))
        return (double)NAN;
    float *moved = in[4] < 1 ? &other.x : in[4] < 2 ? &other.y : &other.z;
    *moved = nextafterf(*moved, in[5] < 0 ? -INFINITY : INFINITY);
    rk_vec3 a = rk_cubemap_at(map_of(side), one, RK_CUBEMAP_SEAMLESS);
    rk_vec3 b = rk_cubemap_at(map_of(side), other, RK_CUBEMAP_SEAMLESS);
    return error_in((wide)a.x, (wide)b.x, eps * side);
}

static double error_of_texel_angle(const float *in)
{
    uint32_t side = (uint32_t)in[0], column = (uint32_t)(in[1] * (float)side);
    uint32_t row = (uint32_t)(in[2] * (float)side);
    if (column >= side || row >= side)
        return (double)NAN;
    wide angle[4];
    for (uint32_t k = 0; k < 4; k++) {
        wide x = 2 * (wide)(column + k % 2) / side - 1, y = 2 * (wide)(row + k / 2) / side - 1;
        angle[k] = asinl(x * y / sqrtl((1 + x * x) * (1 + y * y)));
    }
    wide want = angle[3] - angle[2] - angle[1] + angle[0];
    return error_in((wide)rk_cubemap_solid_angle(side, column, row), want, 0x1p-53L);
}

/* --- Textures and colours --------------------------------------------------------------------- */

static double error_of_texture(const float *in)
{
    enum { side = 16 };
    static rk_vec3 pixels[side * side];
    static rk_texture texture = {{side, side, pixels}, RK_TEXTURE_REPEAT, RK_TEXTURE_BILINEAR};
    for (int i = 0; i < side * side && pixels[1].x == 0; i++)
        pixels[i].x = (float)((i + i / side) % 2);
    texture.wrap = in[2] < 0 ? RK_TEXTURE_CLAMP : RK_TEXTURE_REPEAT;
    wide place[2], part[2];
    long first[2];
    for (int k = 0; k < 2; k++) {
        wide u = (wide)in[k];
        u = texture.wrap == RK_TEXTURE_REPEAT ? u - floorl(u) : fminl(fmaxl(u, 0), 1);
        place[k] = u * side - 0.5L;
        first[k] = (long)floorl(place[k]);
        part[k] = place[k] - first[k];
    }
    wide want = 0;
    for (int k = 0; k < 4; k++) {
        long x = first[0] + k % 2, y = first[1] + k / 2;
        if (texture.wrap == RK_TEXTURE_REPEAT)
            x = (x + side) % side, y = (y + side) % side;
        x = x < 0 ? 0 : x >= side ? side - 1 : x, y = y < 0 ? 0 : y >= side ? side - 1 : y;
        want += (wide)pixels[(side - 1 - y) * side + x].x * (k % 2 ? part[0] : 1 - part[0]) *
                (k / 2 ? part[1] : 1 - part[1]);
    }
    return error_in((wide)rk_texture_at(&texture, (rk_vec2){in[0], in[1]}).x, want, eps * side);
}

static wide encoded(wide linear)
{
    return linear <= 0.0031308L ? 12.92L * linear : 1.055L * powl(linear, 1 / 2.4L) - 0.055L;
}

static double error_of_encode(const float *in)
{
    return error_in((wide)rk_srgb_encode(in[0]), encoded((wide)in[0]), eps);
}

static double error_of_decode(const float *in)
{
    wide stored = (wide)in[0];
    wide want = stored <= 0.04045L ? stored / 12.92L : powl((stored + 0.055L) / 1.055L, 2.4L);
    return error_in((wide)rk_srgb_decode(in[0]), want, eps * want);
}

static double error_of_srgb(const float *in)
{
    static rk_srgb8 table;
    if (table.step[256] == 0)
        rk_srgb8_init(&table);
    /* From the line to the curve at the same value as rk_srgb_decode. */
    wide linear = fminl(fmaxl((wide)in[0], 0), 1);
    wide stored =
        linear <= 0.04045L / 12.92L ? 12.92L * linear : encoded(fmaxl(linear, 0.00313081L));
    return fabs((double)(255 * stored) - rk_srgb8_encode(&table, in[0]));
}

#define CUBE_INPUTS                                                                                \
    {SIGNED, 3, -20, 20},                                                                          \
    {                                                                                              \
        BETWEEN, 1, 1, SIDE_MAX                                                                    \
    }

static const measure list[] = {
    {.routine = "rk_bloom_weights",
     .what = "error of a weight, ulps",
     .error = error_of_weights,
     .domains = {{BETWEEN, 1, 0, RK_BLOOM_RADIUS_MAX}},
     .bound = 0.5001,
     .because = "the nearest float; two roundings of double per step, 8192 of them",
     .reference = "long double, from the middle outwards",
     .cost = 200},
    {.routine = "rk_bloom_weight_inside",
     .what = "relative error, eps",
     .error = error_of_weight_inside,
     .domains = {{BETWEEN, 1, 0, 500}, {BETWEEN, 1, 1, 2000}, {FRACTION, 1, 0, 1}},
     .bound = 1.0001,
     .because = "rounded once, from a sum in double",
     .reference = "long double",
     .cost = 50},
    {.routine = "rk_bloom_blur_lines",
     .what = "error of a filter with 19 taps, eps times the sum of its terms' sizes",
     .error = error_of_blur,
     .domains = {{SIGNED, 19, -20, 20}},
     .bound = 8,
     .because = "a sum of two, a product, and 6 sums: five pairs are added at a time, twice",
     .reference = "long double",
     .cost = 4},
    {.routine = "rk_bloom_luminance",
     .what = "error, eps times the sum of its terms' sizes",
     .error = error_of_luminance,
     .domains = {{POSITIVE, 3, -20, 20}},
     .bound = 5,
     .because = "a weight, a difference, a product and two sums",
     .reference = "long double, the sum of the three products"},
    {.routine = "rk_cubemap_place",
     .what = "error of a coordinate, eps",
     .error = error_of_place,
     .domains = {{SIGNED, 3, -60, 60}},
     .bound = 1,
     .because = "half a quotient, and a sum of at most 1",
     .reference = "long double"},
    {.routine = "rk_cubemap_at: bilinear",
     .what = "error between texels of 0 and 1, eps times the side",
     .error = error_of_bilinear,
     .domains = {CUBE_INPUTS},
     .bound = 5,
     .because = "a product and a difference on both axes; a side of 1 or 2 adds the mix: 3",
     .reference = "long double, at the same place"},
    {.routine = "rk_cubemap_at: seamless",
     .what = "jump between neighbouring directions, texels of 0 and 1, eps times the side",
     .error = jump_of_seamless,
     .domains = {CUBE_INPUTS, {BETWEEN, 1, 0, 3}, {BETWEEN, 1, -1, 1}},
     .bound = 12,
     .because = "the step: 2, and twice the bilinear lookup's 5",
     .reference = "continuity, also across edges and corners"},
    {.routine = "rk_cubemap_solid_angle",
     .what = "error, 2^-53 sr",
     .error = error_of_texel_angle,
     .domains = {{BETWEEN, 1, 1, 8192}, {FRACTION, 2, 0, 1}},
     .bound = 12,
     .because =
         "each of four angles of 0.53 at most: places 1, product, root and atan2 1; the sums: 2",
     .reference = "long double, by the sine"},
    {.routine = "rk_texture_at: bilinear",
     .what = "error between texels of 0 and 1, eps times the side",
     .error = error_of_texture,
     .domains = {{SIGNED, 2, -20, 4}, {BETWEEN, 1, -1, 1}},
     .bound = 3,
     .because = "repeating, a product and a difference, of 0.5 each, on both axes",
     .reference = "long double"},
    {.routine = "rk_srgb_encode",
     .what = "error, eps",
     .error = error_of_encode,
     .domains = {{BETWEEN, 1, 0, 1}},
     .bound = 6,
     .because =
         "powf: 1, of an exponent rounded by 0.7, which counts -ln v v^(1/2.4) / 2.4: at most "
         "0.4; the factor and its product: 1; 0.055 and the difference: 1",
     .reference = "long double"},
    {.routine = "rk_srgb_decode",
     .what = "relative error, eps",
     .error = error_of_decode,
     .domains = {{BETWEEN, 1, 0, 1}},
     .bound = 10,
     .because = "0.055, 1.055, a sum and a quotient: 3, to the power of 2.4; powf: 1",
     .reference = "long double"},
    {.routine = "rk_srgb8_encode",
     .what = "distance from the exact value, steps of 1 / 255",
     .error = error_of_srgb,
     .domains = {{SIGNED, 1, -20, 1}},
     .bound = 0.5 + 1e-12,
     .because = "the nearest of 256 values",
     .reference = "long double, by the power"},
};

const measures measures_of_pictures = {list, sizeof list / sizeof *list};
