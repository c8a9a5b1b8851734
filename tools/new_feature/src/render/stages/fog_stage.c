#include "render/stages/fog_stage.h"

bool rk_fog_wanted(const rk_fog_options *options)
{
    return options->strength > 0;
}

void rk_fog_stage(rk_image *image, const rk_fog_options *options)
{
    if (!rk_fog_wanted(options))
        return;
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_fog_colour(image->pixels[i], options->strength);
}
