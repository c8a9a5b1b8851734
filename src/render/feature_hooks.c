/* A loop over the features for each hook: if a feature has it and the plan wants the feature, it is
 * called. */
#include "render/feature_hooks.h"

#include "render/feature_list.h"

bool rk_features_prepare(rk_rendering *r, rk_error *error)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->prepare && rk_plan_has(&r->plan, i) &&
            !rk_features[i]->prepare(r, error))
            return false;
    return true;
}

bool rk_features_prepass(rk_rendering *r, rk_pool *pool, rk_counters *counters, rk_error *error)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->prepass && rk_plan_has(&r->plan, i) &&
            !rk_features[i]->prepass(r, pool, counters, error))
            return false;
    return true;
}

void rk_features_release(rk_rendering *r)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->release && rk_plan_has(&r->plan, i))
            rk_features[i]->release(r);
}

void rk_features_shade(const rk_rendering *r, struct rk_sample_pass *pass,
                       const struct rk_shading_points *points, struct rk_film *film)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->shade && rk_plan_has(&r->plan, i))
            rk_features[i]->shade(r, pass, points, film);
}

bool rk_features_any_shade(const rk_plan *plan)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->shade && rk_plan_has(plan, i))
            return true;
    return false;
}

bool rk_features_post(rk_image *image, const rk_rendering *r, rk_pool *pool, rk_counters *counters,
                      rk_error *error)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->post && rk_plan_has(&r->plan, i) &&
            !rk_features[i]->post(image, r->options, pool, counters, error))
            return false;
    return true;
}
