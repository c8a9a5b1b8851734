/* The descriptors of all features, for loops over them; the bits of the plan count alike;
 * not installed. */
#ifndef RK_RENDER_FEATURE_LIST_H
#define RK_RENDER_FEATURE_LIST_H

#include "render/feature.h"

enum {
#define RK_FEATURE(stem) RK_FEATURE_##stem,
#include "features/list.h"
#undef RK_FEATURE
    RK_FEATURE_COUNT
};

/* In the order of features/list.h. */
extern const rk_feature *const rk_features[RK_FEATURE_COUNT];

/* Has the plan this feature's bit set? `feature` counts as in the list. */
bool rk_plan_has(const rk_plan *plan, uint32_t feature);

/* Returns the first of the sample dimensions (base/sampler.h) that are the feature's own: for a
 * hook, rk_feature_dimension(RK_FEATURE_bloom), and a pair more for each bounce. */
enum { RK_FEATURE_DIMENSIONS = 1 << 8 };

_Static_assert(RK_DIMENSION_FEATURES + RK_FEATURE_COUNT * RK_FEATURE_DIMENSIONS <=
                   RK_DIMENSION_FURTHER,
               "each feature has a block");

static inline uint32_t rk_feature_dimension(uint32_t feature)
{
    return RK_DIMENSION_FEATURES + feature * RK_FEATURE_DIMENSIONS;
}

#endif
