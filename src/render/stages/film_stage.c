/* Divides sums by the number of samples, unless it is one, and copies rows. */
#include "render/stages/film_stage.h"

#include "render/stages/depth_of_field_stage.h"

#include <string.h>

void rk_film_mean(const rk_rendering *r, const rk_sample_pass *pass, rk_film *film)
{
    const rk_tile *tile = &pass->tile;
    if (pass->samples == 1)
        return;
    uint32_t pixel = 0;
    for (uint32_t y = tile->y; y < tile->y + tile->height; y++)
        for (uint32_t x = tile->x; x < tile->x + tile->width; x++, pixel++)
            if (rk_is_in_pass(r, pass, x, y))
                film->sum[pixel] = rk_scale(film->sum[pixel], 1 / (float)pass->samples);
}

void rk_film_stage(const rk_tile *tile, const rk_film *film, rk_image *image)
{
    for (uint32_t y = 0; y < tile->height; y++)
        memcpy(rk_image_at(image, tile->x, tile->y + y), film->sum + y * tile->width,
               tile->width * sizeof *film->sum);
}
