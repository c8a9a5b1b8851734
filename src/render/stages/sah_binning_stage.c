/* The descriptor alone (render/feature.h): the tree is chosen when it is built (accel/accel.h), so
 * the renderer has nothing to decide. */
#include "render/feature.h"

const rk_feature rk_sah_binning_feature = {.stem = "sah_binning"};
