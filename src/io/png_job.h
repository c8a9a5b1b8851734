/* Common to reading and writing PNG; not installed.
 *
 * libpng reports an error by a long jump. All work that can jump is therefore a function of its
 * own, run by `guarded`; its allocations are stored in a struct of the caller, which frees them
 * however the work ends. */
#ifndef RK_IO_PNG_JOB_H
#define RK_IO_PNG_JOB_H

#include "io/png.h"

#include <png.h>
#include <stdint.h>
#include <stdio.h>

/* One struct for both directions: NULL members are not in use. */
typedef struct job {
    const char *path;
    png_structp png;
    png_infop info;
    FILE *stream;
    unsigned char *bytes; /* a row when writing, the whole picture when reading */
    float *linear;        /* linear value of each stored one, when reading */
    rk_error *error;
    char reason[200]; /* libpng's or the system's, after a jump */

    const rk_image *source; /* writing */
    const rk_png_text *texts;
    size_t text_count;

    rk_image *image; /* reading */
    size_t most_pixels;
    bool opacity, alpha_only, has_alpha; /* see rk_png_read_opacity */
    rk_image_shape shape;
    uintmax_t file_size;
    const char *key;
    char *value;
} job;

static inline void on_error(png_structp png, png_const_charp message)
{
    job *j = png_get_error_ptr(png);
    if (!j->reason[0])
        snprintf(j->reason, sizeof j->reason, "%s", message);
    png_longjmp(png, 1);
}

static inline void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

/* False if the work ended by a jump. */
static inline bool guarded(job *j, void (*work)(job *))
{
    if (setjmp(png_jmpbuf(j->png)))
        return false;
    work(j);
    return true;
}

#endif
