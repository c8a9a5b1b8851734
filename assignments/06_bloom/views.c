/* The debug views: the bright pixels of a picture, and the bloom alone. */
#include "driver.h"

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
