/* What the kit's own units say of themselves: nothing. Drivers of other units are linked with
 * another object in the place of this one. */
#include "driver/implementation_note.h"

#include <stddef.h>

const char rk_implementation_note[] = "";
const rk_implementation_author rk_implementation_authors[] = {{NULL, NULL}};
const char rk_implementation_others[] = "the kit's";
const char rk_pictures_folder[] = "out";
/* In a pack for students the build says which of its starters nobody has touched. */
#ifndef RK_UNSOLVED_FEATURES
#define RK_UNSOLVED_FEATURES " "
#endif
const char rk_unsolved_features[] = RK_UNSOLVED_FEATURES;
