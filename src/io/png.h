/* PNG pictures by libpng: 8 bits per channel, sRGB-encoded, with the parameters as text. */
#ifndef RK_IO_PNG_H
#define RK_IO_PNG_H

#include "base/image.h"
#include "io/image_shape.h"

typedef struct rk_png_text {
    const char *key;   /* 1 to 79 Latin-1 characters, such as "Software" or "raykit:samples" */
    const char *value; /* UTF-8 */
} rk_png_text;

/* Writes the linear image sRGB-encoded and rounded; values outside [0, 1] are clamped, NaN becomes
 * 0. The file is written whole or not at all. */
bool rk_png_write(const char *path, const rk_image *image, const rk_png_text *texts,
                  size_t text_count, rk_error *error);

/* Reads any PNG (grey, palette, 16 bits; alpha is dropped) to linear RGB; a gAMA chunk other than
 * sRGB's is applied. False with an error that names the file when it is missing, damaged,
 * truncated, not a regular file, or larger than RK_IMAGE_SIDE_MAX per side. */
bool rk_png_read(rk_image *image, const char *path, rk_error *error);

/* The same, but refuses a picture of more than `most_pixels` before it takes memory for them. */
bool rk_png_read_within(rk_image *image, const char *path, size_t most_pixels, rk_error *error);

/* And one of another shape. */
bool rk_png_read_shaped(rk_image *image, const char *path, size_t most_pixels, rk_image_shape shape,
                        rk_error *error);

/* Reads the opacity instead, as a grey image of the stored values: the alpha channel, or the one
 * transparent colour of a picture without it; else, unless `alpha_only`, the mean of red, green and
 * blue. With `alpha_only` a picture that is opaque by its format gives no pixels. */
bool rk_png_read_opacity(rk_image *image, const char *path, size_t most_pixels, bool alpha_only,
                         rk_error *error);

/* Returns the value stored under `key` as a new string to free(), or NULL when there is none or
 * the file cannot be read (then with an error). */
char *rk_png_read_text(const char *path, const char *key, rk_error *error);

#endif
