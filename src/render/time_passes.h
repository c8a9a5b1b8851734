/* Time passes: a sample with a ray that may hit a moving object is taken several times, each pass
 * at a time of its own, and the mean of the passes counts; not installed. */
#ifndef RK_RENDER_TIME_PASSES_H
#define RK_RENDER_TIME_PASSES_H

#include "render/film.h"
#include "render/plan.h"
#include "render/sample_pass.h"

/* Returns the number of passes of a sample that needs a time, so that a pixel's `samples` take
 * together at least as many times as the options ask for. */
uint32_t rk_time_passes(const rk_plan *plan, const rk_render_options *options, uint32_t samples);

/* Before each pass: no time is drawn; before a sample's first, no ray is known to need one. */
void rk_time_pass_start(rk_sample_pass *pass);

/* After a sample's last pass: replaces the sum that its passes added to `before` by their mean. */
void rk_time_passes_average(const rk_sample_pass *pass, const rk_film *before, rk_film *film);

#endif
