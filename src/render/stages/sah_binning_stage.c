/* A tree is chosen when it is built (accel/accel.h): nothing here is asked of a picture. */
#include "render/feature.h"

const rk_feature rk_sah_binning_feature = {.stem = "sah_binning"};
