/* All drivers as one WebAssembly module: argv[0] is the driver's name, such as bloom. What a page
 * needs beside the printed text goes to functions of the page, imported from the module raykit. */
#include "driver/driver.h"
#include "io/png.h"
#include "io/srgb8.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* Four bytes per pixel, encoded as the driver's PNG would be. */
IMPORT("picture") void raykit_picture(const uint8_t *rgba, size_t width, size_t height);

/* How the run ended: the camera, in the units of its options, and the time. */
IMPORT("finish")
void raykit_finish(double yaw, double pitch, double distance, double build_ms, double render_ms);

/* A cell of a table's row. */
IMPORT("cell") void raykit_cell(const char *column, const char *text, bool last);

#define RK_FEATURE(stem) int rk_live_##stem(int argc, char **argv);
#include "features/list.h"
#undef RK_FEATURE

int main(int argc, char **argv)
{
#define RK_FEATURE(stem)                                                                           \
    if (strcmp(argv[0], #stem) == 0)                                                               \
        return rk_live_##stem(argc, argv);
#include "features/list.h"
    fprintf(stderr, "%s: there is no such driver\n", argv[0]);
    return 2;
}

/* --- in place of src/io/png_read.c and png_write.c -------------------------------------------- */

bool rk_png_write(const char *path, const rk_image *image, const rk_png_text *texts,
                  size_t text_count, rk_error *error)
{
    (void)texts;
    (void)text_count;
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

/* --- around functions of the kit (wasm-ld --wrap) --------------------------------------------- */

int __real_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);
int __wrap_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error);

int __wrap_rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error)
{
    const rk_camera *camera = &driver->scene.camera;
    raykit_finish(camera->rotation.y, camera->rotation.x, camera->distance, driver->build_ms.median,
                  driver->render_ms.median);
    return __real_rk_driver_finish(driver, ok, error);
}

bool __wrap_rk_table_put(const char *path, const char *const *header, const char *const *cells,
                         size_t columns, size_t key_columns, rk_error *error);

/* A row is printed, name by name, and goes to the page cell by cell. */
bool __wrap_rk_table_put(const char *path, const char *const *header, const char *const *cells,
                         size_t columns, size_t key_columns, rk_error *error)
{
    (void)path;
    (void)key_columns;
    (void)error;
    for (size_t i = 0; i < columns; i++) {
        printf("%s%s=%s", i ? ", " : "", header[i], cells[i]);
        raykit_cell(header[i], cells[i], i + 1 == columns);
    }
    printf("\n");
    return true;
}
