/* For programs inside the build tree: the helpers are where make built them. */
#include "io/helper.h"

const char *rk_helper_folder(void)
{
    return RK_BUILD_FOLDER;
}
