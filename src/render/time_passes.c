/* Sums before the first pass are kept, so that the mean of the passes can be taken pixel by pixel.
 * */
#include "render/time_passes.h"

#include <string.h>

uint32_t rk_time_passes(const rk_plan *plan, const rk_render_options *options, uint32_t samples)
{
    uint64_t times = options->motion.samples;
    return plan->time_samples ? (uint32_t)((times + samples - 1) / samples) : 1;
}

void rk_time_pass_start(rk_sample_pass *pass)
{
    memset(pass->has_time, 0, sizeof pass->has_time);
    if (pass->time_pass > 0)
        return;
    memset(pass->needs_time, 0, sizeof pass->needs_time);
    memset(pass->camera_objects, 0, sizeof pass->camera_objects);
}

void rk_time_passes_average(const rk_sample_pass *pass, const rk_film *before, rk_film *film)
{
    for (uint32_t i = 0; i < pass->tile.width * pass->tile.height; i++)
        if (pass->needs_time[i])
            film->sum[i] = rk_madd(before->sum[i], rk_sub(film->sum[i], before->sum[i]),
                                   1 / (float)pass->time_passes);
}
