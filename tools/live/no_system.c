/* base/file.h and io/helper.h where there are neither files nor processes. */
#include "base/file.h"
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
