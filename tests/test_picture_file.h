/* Pictures in formats that the helper writes, but not the library. */
#ifndef RK_TESTS_TEST_PICTURE_FILE_H
#define RK_TESTS_TEST_PICTURE_FILE_H

#include "test.h"
#include "test_folder.h"

#include "base/image.h"
#include "io/helper.h"
#include "io/image_stream.h"

/* The picture in the helper's input format, to free(). */
static inline unsigned char *stream_of(const rk_image *image, size_t *bytes)
{
    size_t pixels = image->width * image->height * sizeof *image->pixels;
    rk_image_stream_head head = {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION,
                                 (uint32_t)image->width, (uint32_t)image->height};
    unsigned char *stream = malloc(sizeof head + pixels);
    rk_check(stream, "no memory");
    memcpy(stream, &head, sizeof head);
    memcpy(stream + sizeof head, image->pixels, pixels);
    *bytes = sizeof head + pixels;
    return stream;
}

/* The helper writes more formats than the library offers. */
static inline test_path write_by_helper(const test_folder *folder, const char *name,
                                        const rk_image *image)
{
    test_path path = test_folder_path(folder, name);
    size_t bytes;
    unsigned char *input = stream_of(image, &bytes);
    rk_helper_call call = {.program = "raykit-image",
                           .arguments = (const char *[]){"write", path.text, NULL},
                           .input = input,
                           .input_size = bytes};
    unsigned char *output;
    size_t size;
    rk_error error;
    bool ok = rk_helper_run(&call, &output, &size, &error);
    free(input);
    rk_check(ok, "%s: %s", name, error.text);
    free(output);
    return path;
}

#endif
