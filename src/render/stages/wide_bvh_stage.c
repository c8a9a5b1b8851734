/* The descriptor alone (render/feature.h): the tree is chosen when it is built (accel/accel.h), so
 * the renderer has nothing to decide. */
#include "render/feature.h"

const rk_feature rk_wide_bvh_feature = {.stem = "wide_bvh"};
