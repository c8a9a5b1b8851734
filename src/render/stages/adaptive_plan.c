/* Sums of all pixels give the picture's error; variances, pooled with those of neighbours, give
 * each pixel's number of samples (features/adaptive_sampling.h has the formulas). */
#include "render/stages/adaptive_plan.h"

#include <math.h>
#include <stdlib.h>

/* The first round of the last generation takes this part of the samples that are predicted to
 * suffice, or less, because that prediction is often too large; */
static const double first_part = 1.0 / 3;

/* and at most this many times the samples of all generations before. */
static const double most_growth = 8;

/* The second round multiplies them by this at most. */
static const double second_growth = 4;

/* If that does not suffice by far, an earlier generation has this many times the samples of all
 * before it, and they are thrown away. */
static const double earlier_growth = 2;

/* A pixel keeps its samples if this part of the wanted variance is not exceeded around it. */
static const double kept_part = 1.0 / 64;

bool rk_adaptive_plan_init(rk_adaptive_plan *plan, const rk_adaptive_sampling_options *options,
                           uint32_t width, uint32_t height, rk_error *error)
{
    const size_t pixels = (size_t)width * height;
    *plan =
        (rk_adaptive_plan){.width = width, .height = height, .pixels = pixels, .options = *options};
    plan->samples = rk_allocate(pixels, sizeof *plan->samples, "samples", error);
    plan->counts = rk_allocate_unset(pixels, sizeof *plan->counts, "samples", error);
    plan->is_kept = rk_allocate(pixels, sizeof *plan->is_kept, "samples", error);
    plan->pilots = rk_allocate(pixels, sizeof *plan->pilots, "samples", error);
    plan->estimates = rk_allocate(pixels, sizeof *plan->estimates, "samples", error);
    plan->of_colour = rk_allocate(pixels, sizeof *plan->of_colour, "samples", error);
    plan->variances = rk_allocate(pixels, sizeof *plan->variances, "samples", error);
    if (!plan->samples || !plan->counts || !plan->is_kept || !plan->pilots || !plan->estimates ||
        !plan->of_colour || !plan->variances) {
        rk_adaptive_plan_free(plan);
        return false;
    }
    for (size_t i = 0; i < pixels; i++)
        plan->counts[i] = RK_ADAPTIVE_FIRST;
    return true;
}

void rk_adaptive_plan_free(rk_adaptive_plan *plan)
{
    free(plan->samples);
    free(plan->counts);
    free(plan->is_kept);
    free(plan->pilots);
    free(plan->estimates);
    free(plan->of_colour);
    free(plan->variances);
    *plan = (rk_adaptive_plan){0};
}

/* --- Sums ------------------------------------------------------------------------------------- */

static int colour_of(const rk_adaptive_plan *plan, size_t pixel)
{
    return (int)((pixel % plan->width + pixel / plan->width) % 2);
}

/* The colour that decides on this one. A picture of one pixel has no other. */
static int other_colour(const rk_adaptive_plan *plan, int colour)
{
    return plan->pixels > 1 ? 1 - colour : colour;
}

/* Variance is summed for each number of samples alone, because the ratio differs. */
static rk_adaptive_sums sums_of(const rk_adaptive_plan *plan, int colour)
{
    rk_adaptive_differences levels[32] = {{0, 0}};
    rk_adaptive_sums sums = {0, 0, 0, {0, 0}};
    for (size_t i = 0; i < plan->pixels; i++) {
        const rk_pixel_samples *pixel = &plan->samples[i];
        if (colour_of(plan, i) != colour)
            continue;
        const rk_adaptive_differences d = rk_adaptive_differences_of(pixel);
        const rk_vec3 mean = rk_adaptive_mean(pixel);
        const double square = (double)rk_dot(mean, mean) / 3;
        rk_adaptive_differences *level = &levels[ilogbf((float)pixel->count)];
        level->quarters += d.quarters;
        level->halves += d.halves;
        sums.samples += pixel->count;
        sums.squares += isfinite(square) ? square : 0;
    }
    for (int i = 0; i < 32; i++) {
        sums.differences.quarters += levels[i].quarters;
        sums.differences.halves += levels[i].halves;
        sums.variance += rk_adaptive_variance(levels[i]);
    }
    return sums;
}

void rk_adaptive_plan_measure(rk_adaptive_plan *plan)
{
    for (int colour = 0; colour < 2; colour++)
        plan->colours[colour] = sums_of(plan, colour);
}

rk_adaptive_sums rk_adaptive_plan_sums(const rk_adaptive_plan *plan)
{
    const rk_adaptive_sums *a = &plan->colours[0], *b = &plan->colours[1];
    return (rk_adaptive_sums){a->samples + b->samples,
                              a->variance + b->variance,
                              a->squares + b->squares,
                              {a->differences.quarters + b->differences.quarters,
                               a->differences.halves + b->differences.halves}};
}

/* The largest variance, of as many pixels. */
static double wanted_variance(const rk_adaptive_plan *plan, const rk_adaptive_sums *sums)
{
    const double error = (double)plan->options.error;
    return error * error * (sums->squares - sums->variance);
}

/* --- Estimates -------------------------------------------------------------------------------- */

/* Of both together, each from samples of its own. */
static rk_adaptive_estimate combined(rk_adaptive_estimate a, const rk_pixel_samples *b)
{
    const float n = (float)a.count, m = (float)b->count;
    const float variance = (n * a.variance + m * rk_adaptive_own_variance(b)) / (n + m);
    return (rk_adaptive_estimate){.variance = variance, .count = a.count + b->count};
}

static float mean_variance(const rk_adaptive_plan *plan)
{
    double sum = 0;
    for (size_t i = 0; i < plan->pixels; i++)
        sum += (double)plan->pilots[i].variance;
    return (float)(sum / (double)plan->pixels);
}

static float pooled_variance(const rk_adaptive_plan *plan, size_t pixel, float mean, uint32_t count)
{
    return rk_adaptive_pooled_variance(plan->variances, mean, count, plan->width, plan->height,
                                       (uint32_t)(pixel % plan->width),
                                       (uint32_t)(pixel / plan->width));
}

static void set_estimate(rk_adaptive_plan *plan, size_t pixel, float mean)
{
    plan->estimates[pixel] = (rk_adaptive_estimate){
        .variance = pooled_variance(plan, pixel, mean,
                                    plan->is_kept[pixel] ? 0 : plan->pilots[pixel].count),
        .count = plan->samples[pixel].count};
}

static void add_pilots(rk_adaptive_plan *plan)
{
    for (size_t i = 0; i < plan->pixels; i++) {
        if (!plan->is_kept[i])
            plan->pilots[i] = combined(plan->pilots[i], &plan->samples[i]);
        plan->variances[i] = plan->pilots[i].variance;
    }
}

static rk_adaptive_prediction predict(const rk_adaptive_estimate *estimates, size_t pixels,
                                      const rk_adaptive_plan *plan, float lambda, double ratio)
{
    return rk_adaptive_predict(estimates, pixels, lambda, plan->options.max_samples, ratio);
}

static float lambda_of(const rk_adaptive_estimate *estimates, size_t pixels,
                       const rk_adaptive_plan *plan, double ratio, double variance, double samples)
{
    return rk_adaptive_lambda(estimates, pixels, plan->options.max_samples, ratio, variance,
                              samples);
}

/* --- A generation ----------------------------------------------------------------------------- */

/* A pixel whose neighbours have far less variance than is wanted keeps its samples. Its own samples
 * have no part in that, or else those that happen to look smooth would be kept, and the others
 * not. */
static void keep_samples(rk_adaptive_plan *plan)
{
    const double pixels = fmax((double)plan->pixels / 2, 1);
    double most[2];
    for (int colour = 0; colour < 2; colour++)
        most[colour] = kept_part * wanted_variance(plan, &plan->colours[colour]) / pixels;
    for (size_t i = 0; i < plan->pixels; i++) {
        const double around = (double)pooled_variance(plan, i, 0, 0);
        if (around <= most[other_colour(plan, colour_of(plan, i))] * plan->samples[i].count)
            plan->is_kept[i] = true;
    }
}

static bool all_are_kept(const rk_adaptive_plan *plan)
{
    for (size_t i = 0; i < plan->pixels; i++)
        if (!plan->is_kept[i])
            return false;
    return true;
}

/* The pixels that do not keep their samples throw them away, and take new ones. */
static void start_generation(rk_adaptive_plan *plan, float lambda)
{
    for (size_t i = 0; i < plan->pixels; i++)
        if (!plan->is_kept[i]) {
            plan->thrown_away += plan->samples[i].count;
            plan->samples[i] = (rk_pixel_samples){.count = 0};
            plan->counts[i] =
                rk_adaptive_count(plan->estimates[i].variance, lambda, plan->options.max_samples);
        }
}

static double predicted_variance(const rk_adaptive_plan *plan)
{
    double sum = 0;
    for (size_t i = 0; i < plan->pixels; i++)
        sum += (double)plan->estimates[i].variance / plan->estimates[i].count;
    return sum;
}

rk_adaptive_generation rk_adaptive_plan_generation(rk_adaptive_plan *plan)
{
    const rk_adaptive_sums now = rk_adaptive_plan_sums(plan);
    const double so_far = plan->thrown_away + now.samples;
    const double ratio = rk_adaptive_ratio(now.differences);
    add_pilots(plan);
    keep_samples(plan);
    if (all_are_kept(plan))
        return RK_ADAPTIVE_NO_GENERATION;
    const float mean = mean_variance(plan);
    for (size_t i = 0; i < plan->pixels; i++)
        set_estimate(plan, i, mean);
    /* Estimates say how pixels compare; the sums, how large the variance is. */
    double want = wanted_variance(plan, &now);
    if (now.variance > 0)
        want *= predicted_variance(plan) / now.variance;
    const float enough =
        lambda_of(plan->estimates, plan->pixels, plan, ratio, want, (double)INFINITY);
    const double need = predict(plan->estimates, plan->pixels, plan, enough, ratio).samples;
    const bool is_last = need <= most_growth * most_growth * so_far;
    const double most = (is_last ? most_growth : earlier_growth) * so_far;
    const double part = is_last ? need * first_part : most;
    float lambda = lambda_of(plan->estimates, plan->pixels, plan, ratio, 0, fmin(part, most));
    if (part < most) /* in pixels that take more than the least number, n / 3 */
        lambda = fminf(lambda, enough / (float)(first_part * first_part));
    start_generation(plan, lambda);
    return is_last ? RK_ADAPTIVE_LAST_GENERATION : RK_ADAPTIVE_EARLIER_GENERATION;
}

/* --- The second round ------------------------------------------------------------------------- */

/* Estimates the pixels of a colour anew: neighbours of the other colour add the samples of the
 * first round. Those of the colour itself have no part in it. Gathers them in plan->of_colour;
 * returns their number. */
static size_t estimate_again(rk_adaptive_plan *plan, int colour)
{
    const float mean = mean_variance(plan);
    size_t count = 0;
    for (size_t i = 0; i < plan->pixels; i++)
        plan->variances[i] = colour_of(plan, i) == colour || plan->is_kept[i]
                                 ? plan->pilots[i].variance
                                 : combined(plan->pilots[i], &plan->samples[i]).variance;
    for (size_t i = 0; i < plan->pixels; i++)
        if (colour_of(plan, i) == colour) {
            if (!plan->is_kept[i])
                set_estimate(plan, i, mean);
            plan->estimates[i].least = plan->samples[i].count;
            plan->of_colour[count++] = plan->estimates[i];
        }
    return count;
}

static void plan_colour(rk_adaptive_plan *plan, int colour)
{
    rk_adaptive_estimate *estimates = plan->of_colour;
    const rk_adaptive_sums *other = &plan->colours[other_colour(plan, colour)];
    const double want = wanted_variance(plan, other);
    /* There are two doublings at most, too few for the ratio to rise much. */
    const double ratio = rk_adaptive_ratio(other->differences);
    const size_t count = estimate_again(plan, colour);
    if (other->variance <= want)
        return;
    const rk_adaptive_prediction now = predict(estimates, count, plan, INFINITY, ratio);
    const float lambda =
        lambda_of(estimates, count, plan, ratio, now.variance * want / other->variance,
                  second_growth * now.samples);
    for (size_t i = 0; i < plan->pixels; i++)
        if (colour_of(plan, i) == colour) {
            uint32_t n =
                rk_adaptive_count(plan->estimates[i].variance, lambda, plan->options.max_samples);
            plan->counts[i] = n > plan->samples[i].count ? n : plan->samples[i].count;
        }
}

void rk_adaptive_plan_second_round(rk_adaptive_plan *plan)
{
    plan_colour(plan, 0);
    plan_colour(plan, 1);
}
