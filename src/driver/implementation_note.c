#include "driver/implementation_note.h"

const char rk_units[] = "";
