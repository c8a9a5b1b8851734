/* io/png.h in a page: pictures go to it, by functions imported from the module raykit, and it has
 * no files to read. */
#include "io/png.h"
#include "io/srgb8.h"

#include <stdlib.h>
#include <string.h>

#define IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* Four bytes per pixel, encoded as the driver's PNG would be. */
IMPORT("picture") void raykit_picture(const uint8_t *rgba, size_t width, size_t height);

/* Of the next picture's false colours: text_of in driver/driver_save.c. */
IMPORT("scale") void raykit_scale(const char *text);

bool rk_png_write(const char *path, const rk_image *image, const rk_png_text *texts,
                  size_t text_count, rk_error *error)
{
    for (size_t i = 0; i < text_count; i++)
        if (strcmp(texts[i].key, "raykit:scale") == 0)
            raykit_scale(texts[i].value);
    rk_srgb8 table;
    rk_srgb8_init(&table);
    size_t count = image->width * image->height;
    uint8_t *rgba = rk_allocate(count, 4, path, error);
    if (!rgba)
        return false;
    for (size_t i = 0; i < count; i++) {
        rgba[4 * i] = rk_srgb8_encode(&table, image->pixels[i].x);
        rgba[4 * i + 1] = rk_srgb8_encode(&table, image->pixels[i].y);
        rgba[4 * i + 2] = rk_srgb8_encode(&table, image->pixels[i].z);
        rgba[4 * i + 3] = 255;
    }
    raykit_picture(rgba, image->width, image->height);
    free(rgba);
    return true;
}

static bool no_file(const char *path, rk_error *error)
{
    return rk_fail(error, "%s: a page reads no files; run the driver itself", path);
}

bool rk_png_read(rk_image *image, const char *path, rk_error *error)
{
    (void)image;
    return no_file(path, error);
}

bool rk_png_read_within(rk_image *image, const char *path, size_t most_pixels, rk_error *error)
{
    (void)image;
    (void)most_pixels;
    return no_file(path, error);
}

bool rk_png_read_shaped(rk_image *image, const char *path, size_t most_pixels, rk_image_shape shape,
                        rk_error *error)
{
    (void)image;
    (void)most_pixels;
    (void)shape;
    return no_file(path, error);
}

bool rk_png_read_opacity(rk_image *image, const char *path, size_t most_pixels, bool alpha_only,
                         rk_error *error)
{
    (void)image;
    (void)most_pixels;
    (void)alpha_only;
    return no_file(path, error);
}
