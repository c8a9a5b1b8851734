#include "render/units.h"

const char rk_units[] = "";
