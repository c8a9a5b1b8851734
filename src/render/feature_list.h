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

#endif
