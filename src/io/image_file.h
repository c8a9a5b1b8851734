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

/* The same, but refuses a picture of more than `most_pixels` before it takes memory for them; and,
 * so that a small file costs little, one of more than 2^24 + 32 for each byte of the file. */
bool rk_image_file_read_within(rk_image *image, const char *path, size_t most_pixels,
                               rk_error *error);

/* And one of another shape. */
bool rk_image_file_read_shaped(rk_image *image, const char *path, size_t most_pixels,
                               rk_image_shape shape, rk_error *error);

/* The pixels that a picture file of this many bytes may have, `most_pixels` or fewer. */
size_t rk_image_file_budget(size_t most_pixels, size_t bytes);

/* Reads the opacity instead; see rk_png_read_opacity. */
bool rk_image_file_read_opacity(rk_image *image, const char *path, size_t most_pixels,
                                bool alpha_only, rk_error *error);

/* Writes .png (8 bits, sRGB-encoded) or .exr (32-bit float, linear; NaN and infinity are kept), by
 * the ending. Equal pictures give equal files; a file is written whole or not at all. A picture
 * without pixels is an error. */
bool rk_image_file_write(const char *path, const rk_image *image, rk_error *error);

/* Does rk_image_file_write know the ending? For asking before the work is done. */
bool rk_image_file_can_write(const char *path, rk_error *error);

#endif
