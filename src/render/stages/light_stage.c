/* Sends each light that shines to the stage of its kind. */
#include "render/stages/light_stage.h"

#include "render/stages/point_light_stage.h"

void rk_light_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_shading_points *points,
                    rk_light_workspace *w, rk_film *film)
{
    bool physical = r->options->light.falloff == RK_FALLOFF_PHYSICAL;
    for (uint32_t i = 0; i < r->scene->light_count; i++) {
        const rk_light *light = &r->scene->lights[i];
        if (!rk_light_emits(light))
            continue;
        if (light->kind == RK_LIGHT_POINT && !physical)
            rk_point_light_stage(r, pass, points, light, &w->queue, &w->answers, film);
        else
            rk_parallelogram_light_stage(r, pass, points, i, &w->queue, &w->answers, &w->sums,
                                         film);
    }
}
