/* For programs that use the installed library: the helpers are in its libexec folder. */
#include "io/helper.h"

const char *rk_helper_folder(void)
{
    return RK_LIBEXEC_FOLDER;
}
