/* Bloom: bright pixels, blurred by a binomial filter, are added to their picture.
 * The filter is separable: first along rows, then along columns. Either way a line of the result is
 * a weighted sum of lines, and one function computes it, in blocks that stay in registers.
 * Binomial filters: Jaehne, "Digital Image Processing", 6th edition 2005, chapter 11. */
#include "features/bloom.h"

#include <string.h>

/* Two lines at the same distance from the middle: one multiplication for both. */
typedef struct tap_pair {
    const float *a, *b;
    float weight;
} tap_pair;

/* Contents, in the order of the chapter. */
static tap_pair pair_of(const float *a, const float *b, float weight);
static void add_pairs(const tap_pair *pairs, uint32_t count, size_t at, float *restrict sum);

/* --- Bright pixels ---------------------------------------------------------------------------- */

/* Written with differences, so that rounding cannot push a white of 1 below a threshold of 1. */
float rk_bloom_luminance(rk_vec3 colour)
{
    /* solution */
    float red = colour.x, green = colour.y, blue = colour.z;
    return green + 0.2126f * (red - green) + 0.0722f * (blue - green);
    /* starter
    // First step: the weighted sum; for a grey it is the grey itself, to the bit. For now it is
    // half of the green.
    return 0.5f * colour.y;
    end */
}

bool rk_bloom_is_bright(rk_vec3 colour, float threshold)
{
    /* solution */
    float largest = rk_max(fabsf(colour.x), rk_max(fabsf(colour.y), fabsf(colour.z)));
    return largest <= RK_BLOOM_BRIGHTEST && rk_bloom_luminance(colour) >= threshold;
    /* starter
    // First step: at or above the threshold, and no colour beyond RK_BLOOM_BRIGHTEST or NaN.
    return false;
    end */
}

rk_bloom_span rk_bloom_bright_span(const rk_vec3 *row, size_t width, float threshold)
{
    /* solution */
    size_t first = 0, end = width;
    while (first < width && !rk_bloom_is_bright(row[first], threshold))
        first++;
    while (end > first && !rk_bloom_is_bright(row[end - 1], threshold))
        end--;
    return (rk_bloom_span){first, end};
    /* starter
    // First step: search from both ends.
    return (rk_bloom_span){0, 0};
    end */
}

void rk_bloom_bright_pass(const rk_bloom_filter *filter, const rk_vec3 *row, size_t width,
                          float threshold, rk_bloom_span bright, size_t from, size_t count,
                          rk_vec3 *masked)
{
    /* solution */
    size_t reach = filter->reach, total = count + 2 * reach;
    size_t before = reach > from ? reach - from : 0; /* entries beyond the left border */
    size_t start = from + before - reach;            /* the row's pixel at masked[before] */
    size_t after = start + (total - before) > width ? start + (total - before) - width : 0;
    size_t first = bright.first > start ? bright.first : start;
    size_t last = start + (total - before - after), end = bright.end < last ? bright.end : last;
    memset(masked, 0, total * sizeof *masked);
    for (size_t x = first; x < end; x++)
        if (rk_bloom_is_bright(row[x], threshold))
            masked[before + (x - start)] = row[x];
    if (filter->border != RK_BLOOM_CLAMP)
        return;
    for (size_t i = 0; i < before; i++)
        masked[i] = masked[before];
    for (size_t i = total - after; i < total; i++)
        masked[i] = masked[total - after - 1];
    /* starter
    // First step: the row's bright pixels, in their places; 0 everywhere else. Fourth step:
    // with RK_BLOOM_CLAMP, entries beyond the border are masked like the border's own pixel.
    memset(masked, 0, (count + 2 * filter->reach) * sizeof *masked);
    end */
}

/* --- The filter's weights --------------------------------------------------------------------- */

/* Along the row of Pascal's triangle, from its end. A double with an exponent of its own holds
 * C(2r, k): to the bit up to 2^53, and with two roundings per step from then on, far below a
 * float's precision. Only the quotient by 4^r may be too small for a float, and is then as good as
 * 0. */
void rk_bloom_weights(uint32_t radius, float *weights)
{
    /* solution */
    double mantissa = 1; /* C(2r, k) = mantissa 2^exponent */
    int exponent = 0;
    for (uint32_t k = 0; k <= radius; k++) {
        weights[radius - k] = (float)ldexp(mantissa, exponent - 2 * (int)radius);
        int more;
        mantissa = frexp(mantissa * (2 * radius - k) / (k + 1), &more);
        exponent += more;
    }
    /* starter
    // Second step: C(2r, k + 1) = C(2r, k) (2r - k) / (k + 1). C(200, 100) is beyond any float.
    for (uint32_t k = 0; k <= radius; k++)
        weights[k] = 0;
    end */
}

/* --- The weighted sum ------------------------------------------------------------------------- */

/* A line without a partner is its own partner, at half the weight; doubling and halving are
 * exact. */
static tap_pair pair_of(const float *a, const float *b, float weight)
{
    if (!a || !b)
        return (tap_pair){a ? a : b, a ? a : b, weight / 2};
    return (tap_pair){a, b, weight};
}

uint32_t rk_bloom_blur_lines(const rk_bloom_filter *filter, const float *const *lines, size_t count,
                             float *restrict sum)
{
    /* solution */
    tap_pair pairs[RK_BLOOM_RADIUS_MAX + 1 + 4];
    uint32_t used = 0, taps = 0;
    /* From the far ends to the middle, so that small terms are added first. */
    for (uint32_t k = filter->reach + 1; k-- > 0;) {
        const float *a = lines[filter->reach - k], *b = k ? lines[filter->reach + k] : NULL;
        taps += (a ? 1u : 0u) + (b ? 1u : 0u);
        if (a || b)
            pairs[used++] = pair_of(a, b, filter->weights[k]);
    }
    for (; used % 5; used++) /* filled up with pairs of weight 0 */
        pairs[used] = (tap_pair){pairs[0].a, pairs[0].b, 0};
    memset(sum, 0, count * sizeof *sum);
    for (size_t at = 0; at < count; at += RK_BLOOM_BLOCK)
        add_pairs(pairs, used, at, sum);
    return taps;
    /* starter
    // Third step: add each line that is not NULL, times its weight. Sixth step: list the pairs
    // of lines with the same weight (pair_of), fill the list up to a multiple of five with
    // pairs of weight 0, and add them up by add_pairs.
    memset(sum, 0, count * sizeof *sum);
    return 0;
    end */
}

/* The loop over a block has a fixed length, so that compilers vectorize it at -O2; with five pairs
 * at a time, sums are loaded and stored less often. `count` is a multiple of five. */
static void add_pairs(const tap_pair *pairs, uint32_t count, size_t at, float *restrict sum)
{
    for (const tap_pair *p = pairs; p < pairs + count; p += 5) {
        const float *a0 = p[0].a + at, *b0 = p[0].b + at, *a1 = p[1].a + at, *b1 = p[1].b + at;
        const float *a2 = p[2].a + at, *b2 = p[2].b + at, *a3 = p[3].a + at, *b3 = p[3].b + at;
        const float *a4 = p[4].a + at, *b4 = p[4].b + at;
        float w0 = p[0].weight, w1 = p[1].weight, w2 = p[2].weight, w3 = p[3].weight;
        float w4 = p[4].weight;
        for (size_t i = 0; i < RK_BLOOM_BLOCK; i++)
            sum[at + i] += w0 * (a0[i] + b0[i]) + w1 * (a1[i] + b1[i]) + w2 * (a2[i] + b2[i]) +
                           w3 * (a3[i] + b3[i]) + w4 * (a4[i] + b4[i]);
    }
}

void rk_bloom_composite(float *restrict pixels, const float *restrict blurred, size_t count,
                        float gain)
{
    /* solution */
    enum { together = 16 }; /* as above: loops of a fixed length are vectorized */
    size_t i = 0;
    for (; i + together <= count; i += together)
        for (size_t j = 0; j < together; j++)
            pixels[i + j] += gain * blurred[i + j];
    for (; i < count; i++)
        pixels[i] += gain * blurred[i];
    /* starter
    // Third step: add gain times blurred.
    end */
}

/* --- At the border, and far from the middle --------------------------------------------------- */

float rk_bloom_weight_inside(const rk_bloom_filter *filter, size_t place, size_t length)
{
    /* solution */
    double inside = (double)filter->weights[0];
    for (size_t k = 1; k <= filter->reach; k++) {
        inside += place >= k ? (double)filter->weights[k] : 0;
        inside += place + k < length ? (double)filter->weights[k] : 0;
    }
    return (float)inside;
    /* starter
    // Fourth step: the sum of the weights that fall inside.
    return 1;
    end */
}

uint32_t rk_bloom_reach(uint32_t radius, const float *weights)
{
    /* solution */
    const double half_an_ulp = 0x1p-25;
    double left_out = 0;
    uint32_t reach = radius;
    while (reach > 0 && left_out + 2 * (double)weights[reach] <= half_an_ulp)
        left_out += 2 * (double)weights[reach--];
    return reach;
    /* starter
    // Fifth step: leave out weights from the ends inwards, as long as it makes no difference.
    return radius;
    end */
}
