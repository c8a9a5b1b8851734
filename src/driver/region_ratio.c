/* Each renderer draws two pictures that differ only in the seed: half of their difference estimates
 * the noise of a region's sum, pixel by pixel. */
#include "driver/region_ratio.h"

typedef struct sum {
    double mean, variance; /* of the region's sum */
} sum;

static double channels(rk_vec3 colour)
{
    return (double)colour.x + (double)colour.y + (double)colour.z;
}

/* The channels of a pixel share its rays and so its noise; they count as one. */
static void add(sum *total, const rk_picture_pair *pair, size_t i)
{
    const double first = channels(pair->first.pixels[i]), second = channels(pair->second.pixels[i]);
    const double half = 0.5 * (first - second);
    total->mean += 0.5 * (first + second);
    total->variance += half * half;
}

/* The square of the standard error over the mean. */
static double relative_variance(sum s)
{
    return s.variance / (s.mean * s.mean);
}

rk_region_ratio rk_region_ratio_of(const rk_picture_pair *ours, const rk_picture_pair *theirs,
                                   const uint8_t *regions, unsigned region)
{
    sum us = {0, 0}, them = {0, 0};
    rk_region_ratio found = {.pixels = 0};
    for (size_t i = 0; i < ours->first.width * ours->first.height; i++)
        if (region == RK_REGION_ALL || regions[i] == region) {
            add(&us, ours, i);
            add(&them, theirs, i);
            found.pixels++;
        }
    found.ratio = them.mean != 0 ? us.mean / them.mean : NAN;
    found.standard_error = found.ratio * sqrt(relative_variance(us) + relative_variance(them));
    return found;
}

RK_NAMES(rk_agreement_names, rk_agreement, RK_TOO_NOISY, "agree", "disagree", "too noisy");

/* Written so that NaN does not agree. */
rk_agreement rk_region_ratio_agreement(const rk_region_ratio *ratio)
{
    const double off = fabs(ratio->ratio - 1), allowed = RK_RATIO_TOLERANCE;
    if (!(off <= allowed + 3 * ratio->standard_error))
        return RK_DISAGREE;
    return ratio->standard_error <= RK_RATIO_NOISE_MAX ? RK_AGREE : RK_TOO_NOISY;
}

static rk_vec3 mean_at(const rk_picture_pair *pair, size_t i)
{
    return rk_scale(rk_add(pair->first.pixels[i], pair->second.pixels[i]), 0.5f);
}

void rk_picture_pair_mean(rk_image *mean, const rk_picture_pair *pair)
{
    for (size_t i = 0; i < mean->width * mean->height; i++)
        mean->pixels[i] = mean_at(pair, i);
}

void rk_picture_pair_difference(rk_image *shown, const rk_picture_pair *a, const rk_picture_pair *b,
                                float scale)
{
    for (size_t i = 0; i < shown->width * shown->height; i++)
        shown->pixels[i] = rk_abs3(rk_scale(rk_sub(mean_at(a, i), mean_at(b, i)), scale));
}
