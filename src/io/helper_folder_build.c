/* The folder of io/helper.h for programs inside the build tree: where make built the helpers. */
#include "io/helper.h"

const char *rk_helper_folder(void)
{
    return RK_BUILD_FOLDER;
}
