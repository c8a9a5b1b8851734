/* Helper programs read foreign files in a process of their own: a corrupt file can crash only the
 * helper, and nobody pays for the big libraries who does not need them. */
#ifndef RK_IO_HELPER_H
#define RK_IO_HELPER_H

#include "base/error.h"

typedef struct rk_helper_call {
    const char *program;          /* "raykit-mesh" or "raykit-image" */
    const char *const *arguments; /* NULL-terminated, without the program's name */
    const void *input;            /* bytes for its standard input, or NULL */
    size_t input_size;
    size_t output_max; /* a longer answer is an error */
} rk_helper_call;

/* Runs the helper and returns its standard output in a new block to free(). False with an error:
 * when the program is missing (naming the package to install), when it exits non-zero (its last
 * line on standard error is the reason), when a signal ends it, when it is silent for 60 s, or
 * when it wants more memory than this machine has. */
bool rk_helper_run(const rk_helper_call *call, unsigned char **output, size_t *output_size,
                   rk_error *error);

#endif
