/* The folder of io/helper.h for programs with the installed library: its libexec folder. */
#include "io/helper.h"

const char *rk_helper_folder(void)
{
    return RK_LIBEXEC_FOLDER;
}
