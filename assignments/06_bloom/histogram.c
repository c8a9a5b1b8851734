/* The tables of --histogram: how many pixels of the picture without bloom have which luminance, and
 * how many are bright. */
#include "driver.h"

#include "driver/number_row.h"

/* Four bins per octave, from 1/64 to 16; the first also counts darker pixels, the last brighter
 * ones. */
enum { BINS_PER_OCTAVE = 4, LOWEST_OCTAVE = -6, BINS = 10 * BINS_PER_OCTAVE };

static int bin_of(float luminance)
{
    if (!(luminance > 0))
        return 0;
    const float place = BINS_PER_OCTAVE * (log2f(luminance) - LOWEST_OCTAVE);
    return (int)rk_min(rk_max(place, 0), BINS - 1);
}

static double edge_of(int bin)
{
    return exp2((double)bin / BINS_PER_OCTAVE + LOWEST_OCTAVE);
}

static bool put_bins(const rk_driver *driver, rk_error *error)
{
    uint32_t counts[BINS] = {0};
    for (size_t i = 0; i < pixels_of(&driver->image); i++)
        counts[bin_of(rk_bloom_luminance(driver->image.pixels[i]))]++;
    for (int k = 0; k < BINS; k++) {
        const double numbers[] = {k, edge_of(k), edge_of(k + 1), counts[k]};
        if (!rk_driver_number_row(driver, "bloom_histogram", "bin low high pixels", 1, numbers,
                                  error))
            return false;
    }
    return true;
}

static bool put_bright(const rk_driver *driver, float threshold, rk_error *error)
{
    uint32_t bright = 0;
    float most = 0;
    for (size_t i = 0; i < pixels_of(&driver->image); i++) {
        bright += rk_bloom_is_bright(driver->image.pixels[i], threshold);
        most = rk_max(most, rk_bloom_luminance(driver->image.pixels[i]));
    }
    const double numbers[] = {(double)threshold, bright, (double)pixels_of(&driver->image),
                              (double)most};
    return rk_driver_number_row(driver, "bloom_bright", "threshold bright pixels most", 1, numbers,
                                error);
}

bool put_histogram(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return rk_driver_render(driver, error) && put_bins(driver, error) &&
           put_bright(driver, c->bloom.threshold, error);
}
