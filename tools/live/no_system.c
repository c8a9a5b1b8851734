/* base/file.h, io/helper.h and driver/driver_team.h where there are neither files nor processes. */
#include "base/file.h"
#include "driver/driver_team.h"
#include "io/helper.h"

#include <stddef.h>

/* Missing in wasi-libc. */
int madvise(void *memory, size_t size, int advice);
int mkstemp(char *template);

int madvise(void *memory, size_t size, int advice)
{
    (void)memory;
    (void)size;
    (void)advice;
    return 0;
}

int mkstemp(char *template)
{
    (void)template;
    return -1;
}

/* Drivers try their folder before they work; pictures and rows do not come here (live.c). */
bool rk_file_begin(rk_file *file, const char *path, rk_error *error)
{
    (void)path;
    (void)error;
    file->stream = NULL;
    return true;
}

void rk_file_abort(rk_file *file)
{
    (void)file;
}

bool rk_file_make_folder(const char *path, rk_error *error)
{
    (void)path;
    (void)error;
    return true;
}

bool rk_helper_run(const rk_helper_call *call, unsigned char **output, size_t *output_size,
                   rk_error *error)
{
    (void)output;
    (void)output_size;
    return rk_fail(error, "%s: a page reads no files; run the driver itself",
                   call->subject ? call->subject : call->program);
}

bool rk_helper_ask(rk_helper **helper, const rk_helper_call *call, unsigned char **output,
                   size_t *output_size, rk_error *error)
{
    (void)helper;
    return rk_helper_run(call, output, output_size, error);
}

void rk_helper_end(rk_helper **helper)
{
    (void)helper;
}

bool rk_driver_join_team(rk_driver *driver, int argc, char **argv, rk_error *error)
{
    (void)driver;
    (void)argc;
    (void)argv;
    (void)error;
    return true;
}

bool rk_driver_speaks(const rk_driver *driver)
{
    (void)driver;
    return true;
}

bool rk_driver_check_team(const rk_driver *driver, const rk_driver_spec *spec, rk_error *error)
{
    (void)spec;
    return !driver->mpi ||
           rk_fail(error, "--mpi: a page is one process; run the driver itself by mpirun");
}

bool rk_driver_agree(rk_driver *driver, bool ok, rk_error *error)
{
    (void)driver;
    (void)error;
    return ok;
}

void rk_driver_leave_team(rk_driver *driver)
{
    (void)driver;
}

bool rk_driver_tell(const rk_driver *driver, const char *text)
{
    fprintf(stderr, "%s: %s\n", driver->feature, text);
    return false;
}

void rk_driver_end_team(rk_driver *driver, bool ok)
{
    (void)driver;
    (void)ok;
}
