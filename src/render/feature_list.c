#include "render/feature_list.h"

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
