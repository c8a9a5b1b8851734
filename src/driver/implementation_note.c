#include "driver/implementation_note.h"

const char rk_implementation_note[] = "";
