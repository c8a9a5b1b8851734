#include "driver/implementation_note.h"

const char rk_implementation_note[] = "";
const char rk_pictures_folder[] = "out";
