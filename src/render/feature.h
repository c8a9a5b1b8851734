/* A feature for the renderer: one descriptor, at the end of its stage's file. Options, plan, checks
 * and the renderer loop over all of them (render/feature_list.h), and know no feature by name.
 * Hooks are called per picture or per batch of shading points, never per ray. Any of them may be
 * NULL. */
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

    const char *takes; /* preconditions for the options to have an effect, for a note to the user */

    /* Its bit of the plan: does the scene need it, by these options? Called only if there is
     * something to render, or if the feature `shines`. NULL: the bit stays unset. */
    bool (*wanted)(const rk_scene *scene, const rk_render_options *options);

    /* Are the options valid, beyond the ranges of their rows? */
    bool (*check)(const rk_render_options *options, rk_error *error);

    /* Do the options of a command line go together? */
    bool (*check_command)(const rk_render_options *options, rk_error *error);

    bool shines; /* it brings light of its own: if wanted, a scene needs no other */

    /* If wanted: the number of its samples per sample of a pixel; NULL: 1. If it `splits` paths,
     * each of them goes on alone, and other features take theirs for each. */
    uint32_t (*samples)(const rk_scene *scene, const rk_render_options *options);
    bool splits;

    /* If wanted: data for the whole picture. `prepass` runs after `prepare` of all features and
     * before the first tile, and may trace rays; `counters`: one per thread of the pool. */
    bool (*prepare)(struct rk_rendering *r, rk_error *error);
    bool (*prepass)(struct rk_rendering *r, rk_pool *pool, rk_counters *counters, rk_error *error);
    void (*release)(struct rk_rendering *r);

    /* If wanted: once per batch of shading points, before the lights. */
    void (*shade)(const struct rk_rendering *r, struct rk_sample_pass *pass,
                  const struct rk_shading_points *points, struct rk_film *film);

    /* If wanted: on the whole picture, after the last tile. */
    bool (*post)(rk_image *image, const rk_render_options *options, rk_pool *pool,
                 rk_counters *counters, rk_error *error);
} rk_feature;

#define RK_FEATURE(stem) extern const rk_feature rk_##stem##_feature;
#include "features/list.h"
#undef RK_FEATURE

#endif
