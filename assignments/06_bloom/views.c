/* The debug views: the bright pixels of a picture, and the bloom alone; and the latter in numbers.
 */
#include "driver.h"

#include "driver/number_row.h"

static void show_threshold(rk_image *image, float threshold)
{
    for (size_t i = 0; i < pixels_of(image); i++) {
        float dark = 0.15f * rk_bloom_luminance(image->pixels[i]);
        image->pixels[i] = rk_bloom_is_bright(image->pixels[i], threshold)
                               ? rk_vec(1, 0, 0)
                               : rk_vec(dark, dark, dark);
    }
}

static bool show_mask(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    rk_image with;
    rk_timing ms;
    if (!rk_image_init(&with, driver->image.width, driver->image.height, error))
        return false;
    rk_bloom_options alone = *options;
    alone.intensity = 1;
    bool ok = bloom_copy(driver, &alone, &with, &ms, error);
    for (size_t i = 0; ok && i < pixels_of(&with); i++)
        driver->image.pixels[i] = rk_sub(with.pixels[i], driver->image.pixels[i]);
    rk_image_free(&with);
    return ok;
}

/* How many pixels the bloom reaches, its largest luminance, and the sum. */
bool put_halo(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    double pixels = 0, most = 0, sum = 0;
    if (!rk_driver_render(driver, error) || !show_mask(driver, &c->bloom, error))
        return false;
    for (size_t i = 0; i < pixels_of(&driver->image); i++) {
        const double luminance = (double)rk_bloom_luminance(driver->image.pixels[i]);
        pixels += luminance > 0;
        most = luminance > most ? luminance : most;
        sum += luminance;
    }
    const double numbers[] = {c->bloom.radius, pixels, most, sum};
    return rk_driver_number_row(driver, "bloom_halo", "radius pixels most sum", 1, numbers, error);
}

bool draw_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    if (!rk_driver_render(driver, error))
        return false;
    if (rk_driver_debug(driver, "mask"))
        return show_mask(driver, &c->bloom, error);
    show_threshold(&driver->image, c->bloom.threshold);
    return true;
}
