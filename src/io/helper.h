/* Helper programs read foreign files in a process of their own: a corrupt file can crash only the
 * helper, and the big libraries cost only those who need them; not installed. */
#ifndef RK_IO_HELPER_H
#define RK_IO_HELPER_H

#include "base/error.h"

typedef struct rk_helper_call {
    const char *program;          /* "raykit-mesh" or "raykit-image" */
    const char *package;          /* that building it requires, such as "libassimp-dev"; or NULL */
    const char *subject;          /* begins errors: the file's name; NULL: the program's */
    const char *const *arguments; /* NULL-terminated, without the program's name */
    const void *input;            /* bytes for its standard input, or NULL */
    size_t input_size;
    size_t output_max;      /* a longer answer is an error */
    double timeout_seconds; /* of silence before it is stopped; 0 means 60 */
} rk_helper_call;

/* Runs the helper and returns its standard output in a new block to free(). False with an error
 * if the program is missing (naming the package to install), exits non-zero (its last line on
 * standard error, which should name the file, becomes the error), is ended by a signal, neither
 * reads nor writes during the timeout, or writes more than output_max bytes. On success error->text
 * is "" or the last line that it wrote to standard error: a note.
 *
 * The helper may use three quarters of the machine's memory and writes no core file. The folder
 * in RAYKIT_HELPERS is searched for it first, then rk_helper_folder(). The caller's signal
 * handlers, SIGPIPE included, stay as they are, and several threads may call at the same time. */
bool rk_helper_run(const rk_helper_call *call, unsigned char **output, size_t *output_size,
                   rk_error *error);

/* A helper that stays, so that several calls start it once: it answers each input by an
 * rk_helper_answer and that many bytes, and waits for the next. */
typedef struct rk_helper rk_helper;

/* Sends the call's input and returns the answer, in a new block to free(). Starts the helper, with
 * the call's arguments, where *helper is NULL. False with the reason that it answers, and for all
 * that makes rk_helper_run fail; a helper that has ended is NULL again, so the next call starts
 * another. One thread at a time. */
bool rk_helper_ask(rk_helper **helper, const rk_helper_call *call, unsigned char **output,
                   size_t *output_size, rk_error *error);

/* Ends it; NULL is accepted. */
void rk_helper_end(rk_helper **helper);

/* The folder where this copy of the library expects its helpers: the build folder in the source
 * tree, the package's libexec folder once installed. */
const char *rk_helper_folder(void);

#endif
