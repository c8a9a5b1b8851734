/* The list is made of features/list.h by the preprocessor, so that descriptors and bits of the plan
 * cannot get into different orders. */
#include "render/feature_list.h"

/* These have no stage: a tree is chosen when it is built (accel/accel.h), and all rays use the one
 * triangle test (features/watertight.h), so the renderer has nothing to decide. */
const rk_feature rk_bvh_median_feature = {.stem = "bvh_median"};
const rk_feature rk_sah_binning_feature = {.stem = "sah_binning"};
const rk_feature rk_watertight_feature = {.stem = "watertight"};
const rk_feature rk_wide_bvh_feature = {.stem = "wide_bvh"};

const rk_feature *const rk_features[RK_FEATURE_COUNT] = {
#define RK_FEATURE(stem) &rk_##stem##_feature,
#include "features/list.h"
#undef RK_FEATURE
};

bool rk_plan_has(const rk_plan *plan, uint32_t feature)
{
    const bool bits[] = {
#define RK_FEATURE(stem) plan->stem,
#include "features/list.h"
#undef RK_FEATURE
    };
    return bits[feature];
}
