/* Pictures in any format: PNG by libpng, all others through the helper program based on
 * OpenImageIO. */
#ifndef RK_IO_IMAGE_FILE_H
#define RK_IO_IMAGE_FILE_H

#include "base/image.h"
#include "io/image_shape.h"

/* Reads JPG, PNG, EXR, HDR, TIFF and OpenImageIO's other formats to linear RGB: integers are
 * sRGB-encoded and floats linear unless the file says otherwise, grey is replicated, alpha dropped,
 * a photo rotated upright. A pixel that is NaN or infinite is an error that names its x and y; so
 * is a path that is not a regular file. */
bool rk_image_file_read(rk_image *image, const char *path, rk_error *error);

/* Keeps raykit-image between pictures: it takes a quarter of a second or more to start. All its
 * members are zero before the first picture. */
typedef struct rk_image_file_reader {
    struct rk_helper *helper;
} rk_image_file_reader;

void rk_image_file_reader_end(rk_image_file_reader *reader);

/* What is asked of a picture. */
typedef struct rk_image_file_wish {
    size_t most_pixels;   /* one of more is refused before memory is taken for it; so is, because
                             a small file should cost little, one of more than 2^24 + 32 for each
                             byte of the file */
    rk_image_shape shape; /* others are refused */
    rk_image_file_reader *reader; /* or NULL */
    size_t least_width; /* or 0: a world by longitude and latitude may come as means of squares of
                           pixels if it keeps this many columns */
} rk_image_file_wish;

/* The same as rk_image_file_read, for a picture that is as wished. */
bool rk_image_file_read_wished(rk_image *image, const char *path, const rk_image_file_wish *wish,
                               rk_error *error);

/* The pixels that a picture file of this many bytes may have, `most_pixels` or fewer. */
size_t rk_image_file_budget(size_t most_pixels, size_t bytes);

/* Reads the opacity instead, of any shape; see rk_png_read_opacity. */
bool rk_image_file_read_opacity(rk_image *image, const char *path, const rk_image_file_wish *wish,
                                bool alpha_only, rk_error *error);

/* Writes .png (8 bits, sRGB-encoded) or .exr (32-bit float, linear; NaN and infinity are kept), by
 * the ending. Equal pictures give equal files; a file is written whole or not at all. A picture
 * without pixels is an error. */
bool rk_image_file_write(const char *path, const rk_image *image, rk_error *error);

/* Does rk_image_file_write know the ending? For asking before the work is done. */
bool rk_image_file_can_write(const char *path, rk_error *error);

#endif
