/* Runs the hooks of the features that r->plan wants, in the order of features/list.h;
 * not installed. */
#ifndef RK_RENDER_FEATURE_HOOKS_H
#define RK_RENDER_FEATURE_HOOKS_H

#include "base/counters.h"
#include "base/image.h"
#include "base/parallel.h"
#include "render/rendering.h"

struct rk_sample_pass;
struct rk_shading_points;
struct rk_film;

bool rk_features_prepare(rk_rendering *r, rk_error *error);
/* `counters`: one per thread of the pool. */
bool rk_features_prepass(rk_rendering *r, rk_pool *pool, rk_counters *counters, rk_error *error);
void rk_features_release(rk_rendering *r);
void rk_features_shade(const rk_rendering *r, struct rk_sample_pass *pass,
                       const struct rk_shading_points *points, struct rk_film *film);
/* Does any feature of the plan shade? */
bool rk_features_any_shade(const rk_plan *plan);
bool rk_features_post(rk_image *image, const rk_rendering *r, rk_pool *pool, rk_counters *counters,
                      rk_error *error);

#endif
