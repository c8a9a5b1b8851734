/* The descriptor alone (render/feature.h): all rays use the test (features/watertight.h), so the
 * renderer has nothing to decide. */
#include "render/feature.h"

const rk_feature rk_watertight_feature = {.stem = "watertight"};
