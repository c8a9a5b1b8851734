/* A feature, as the renderer sees it: one descriptor in a file of its own, found by its line in
 * features/list.h. Options, plan, checks and the renderer loop over the list, and know no feature
 * by name. Hooks are called per picture or per batch of shading points, never per ray. Any of them
 * may be NULL. */
#ifndef RK_RENDER_FEATURE_H
#define RK_RENDER_FEATURE_H

#include "base/counters.h"
#include "base/image.h"
#include "base/options.h"
#include "base/parallel.h"
#include "render/plan.h"

struct rk_rendering;
struct rk_sample_pass;
struct rk_shading_points;
struct rk_film;

typedef struct rk_feature {
    const char *stem;         /* "bloom" */
    const rk_option *options; /* rows over rk_render_options, ended by a NULL name */

    const char *takes; /* what it takes for the options to have an effect */

    /* Its bit of the plan: does the scene need it, by these options? Asked only where there is
     * something to render. Without this its bit is unset: the renderer has no say in it. */
    bool (*wanted)(const rk_scene *scene, const rk_render_options *options);

    /* Are the options right beyond the ranges of their rows? */
    bool (*check)(const rk_render_options *options, rk_error *error);

    /* Does what a user asked for on the command line go together? */
    bool (*check_command)(const rk_render_options *options, rk_error *error);

    /* Where it is wanted: the samples that it takes for each of a pixel's; 1 without this. */
    uint32_t (*samples)(const rk_scene *scene, const rk_render_options *options);

    /* Where it is wanted: data of the whole picture. `prepass` runs when all features are prepared,
     * before the first tile, and may trace rays; `counters` has one for each thread of the pool. */
    bool (*prepare)(struct rk_rendering *r, rk_error *error);
    bool (*prepass)(struct rk_rendering *r, rk_pool *pool, rk_counters *counters, rk_error *error);
    void (*release)(struct rk_rendering *r);

    /* Where it is wanted, once per batch of shading points, before the lights add to them. */
    void (*shade)(const struct rk_rendering *r, struct rk_sample_pass *pass,
                  const struct rk_shading_points *points, struct rk_film *film);

    /* Where it is wanted, on the whole picture when all tiles are rendered. */
    bool (*post)(rk_image *image, const rk_render_options *options, rk_pool *pool,
                 rk_counters *counters, rk_error *error);
} rk_feature;

#define RK_FEATURE(stem) extern const rk_feature rk_##stem##_feature;
#include "features/list.h"
#undef RK_FEATURE

enum {
#define RK_FEATURE(stem) RK_FEATURE_##stem,
#include "features/list.h"
#undef RK_FEATURE
    RK_FEATURE_COUNT
};

/* All of them, in the list's order. */
extern const rk_feature *const rk_features[RK_FEATURE_COUNT];

/* Has the plan this feature's bit set? `feature` counts as in the list. */
bool rk_plan_has(const rk_plan *plan, uint32_t feature);

/* These run the hooks of the features that r->plan wants, in the list's order. */
bool rk_features_prepare(struct rk_rendering *r, rk_pool *pool, rk_counters *counters,
                         rk_error *error);
void rk_features_release(struct rk_rendering *r);
void rk_features_shade(const struct rk_rendering *r, struct rk_sample_pass *pass,
                       const struct rk_shading_points *points, struct rk_film *film);
bool rk_features_post(rk_image *image, const struct rk_rendering *r, rk_pool *pool,
                      rk_counters *counters, rk_error *error);

#endif
