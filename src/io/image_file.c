/* Pictures in any format: PNG here, all others through raykit-image, whose output is checked before
 * it is used. */
#include "io/image_file.h"

#include "base/file.h"
#include "io/helper.h"
#include "io/image_stream.h"
#include "io/png.h"
#include "io/stand_in.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

_Static_assert((int)RK_IMAGE_STREAM_SIDE_MAX == (int)RK_IMAGE_SIDE_MAX,
               "library and helper agree on the largest picture");
_Static_assert(sizeof(rk_vec3) == 3 * sizeof(float), "pixels are sent as they are in memory");

typedef rk_image_stream_head head;

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path), end = strlen(ending);
    return length > end && strcasecmp(path + length - end, ending) == 0;
}

static rk_helper_call make_call(const char *path, const char *const *arguments, size_t output_max)
{
    return (rk_helper_call){.program = "raykit-image",
                            .package = "libopenimageio-dev 2.4 or later",
                            .subject = path,
                            .arguments = arguments,
                            .output_max = output_max};
}

static bool check_stand_in(const char *path, rk_error *error)
{
    char first[RK_STAND_IN_MARK];
    FILE *stream = fopen(path, "rb");
    const size_t size = stream ? fread(first, 1, sizeof first, stream) : 0;
    if (stream)
        fclose(stream);
    return rk_stand_in_check(path, first, size, error);
}

/* A device or a pipe may never end, and the helper would wait for it. A missing file is reported
 * where it is opened. */
static bool check_kind(const char *path, rk_error *error)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return true;
    if (S_ISREG(status.st_mode))
        return check_stand_in(path, error);
    if (S_ISDIR(status.st_mode))
        return rk_fail(error, "%s: is a folder: name a picture in it", path);
    return rk_fail(error, "%s: is not a regular file: copy the picture to one", path);
}

/* --- reading --------------------------------------------------------------------------------- */

static bool fail_reply(const char *path, rk_error *error)
{
    return rk_fail(error,
                   "%s: raykit-image sent an invalid answer: its version differs from this "
                   "library's; run make again",
                   path);
}

static bool check_finite(const rk_image *image, const char *path, rk_error *error)
{
    for (size_t i = 0; i < image->width * image->height; i++) {
        rk_vec3 v = image->pixels[i];
        if (!(isfinite(v.x) && isfinite(v.y) && isfinite(v.z)))
            return rk_fail(error, "%s: the pixel at x %zu, y %zu is not a finite number; repair it",
                           path, i % image->width, i / image->width);
    }
    return true;
}

static bool unpack(rk_image *image, const unsigned char *reply, size_t size, const char *path,
                   rk_error *error)
{
    head h;
    if (size < sizeof h)
        return fail_reply(path, error);
    memcpy(&h, reply, sizeof h);
    if (h.magic != RK_IMAGE_STREAM_MAGIC || h.version != RK_IMAGE_STREAM_VERSION || h.width < 1 ||
        h.height < 1 || h.width > RK_IMAGE_SIDE_MAX || h.height > RK_IMAGE_SIDE_MAX ||
        (size - sizeof h) / sizeof(rk_vec3) != (size_t)h.width * h.height ||
        (size - sizeof h) % sizeof(rk_vec3) != 0)
        return fail_reply(path, error);
    if (!rk_image_init(image, h.width, h.height, error))
        return false;
    memcpy(image->pixels, reply + sizeof h, size - sizeof h);
    if (check_finite(image, path, error))
        return true;
    rk_image_free(image);
    return false;
}

void rk_image_file_reader_end(rk_image_file_reader *reader)
{
    rk_helper_end(&reader->helper);
}

/* The request and the file's name, to free(). */
static unsigned char *make_request(const char *path, rk_image_stream_part part,
                                   const rk_image_file_wish *wish, size_t *size, rk_error *error)
{
    const rk_image_stream_request request = {
        .magic = RK_IMAGE_STREAM_MAGIC,
        .version = RK_IMAGE_STREAM_VERSION,
        .part = part,
        .shape = wish->shape,
        .most_pixels = wish->most_pixels,
        .least_width = wish->least_width,
        .name_size = strlen(path),
    };
    *size = sizeof request + request.name_size;
    unsigned char *bytes = rk_allocate(*size, 1, path, error);
    if (!bytes)
        return NULL;
    memcpy(bytes, &request, sizeof request);
    memcpy(bytes + sizeof request, path, request.name_size);
    return bytes;
}

static bool read_by(rk_image_file_reader *reader, rk_image *image, const char *path,
                    rk_image_stream_part part, const rk_image_file_wish *wish, rk_error *error)
{
    size_t request_size, size;
    unsigned char *request = make_request(path, part, wish, &request_size, error), *reply;
    if (!request)
        return false;
    rk_helper_call call = make_call(path, (const char *[]){"read", NULL},
                                    sizeof(head) + sizeof(rk_vec3) * wish->most_pixels);
    call.input = request;
    call.input_size = request_size;
    bool ok = rk_helper_ask(&reader->helper, &call, &reply, &size, error);
    free(request);
    if (ok)
        ok = unpack(image, reply, size, path, error);
    free(reply);
    return ok;
}

static bool read_by_helper(rk_image *image, const char *path, rk_image_stream_part part,
                           const rk_image_file_wish *wish, rk_error *error)
{
    if (wish->reader)
        return read_by(wish->reader, image, path, part, wish, error);
    rk_image_file_reader reader = {0};
    bool ok = read_by(&reader, image, path, part, wish, error);
    rk_image_file_reader_end(&reader);
    return ok;
}

static bool read_limited(rk_image *image, const char *path, const rk_image_file_wish *wish,
                         rk_error *error)
{
    *image = (rk_image){0};
    if (!check_kind(path, error))
        return false;
    if (has_ending(path, ".png"))
        return rk_png_read_shaped(image, path, wish->most_pixels, wish->shape, error);
    return read_by_helper(image, path, RK_IMAGE_STREAM_COLOUR, wish, error);
}

bool rk_image_file_read(rk_image *image, const char *path, rk_error *error)
{
    const rk_image_file_wish any = {.most_pixels = RK_IMAGE_PIXELS_MAX};
    return read_limited(image, path, &any, error);
}

/* Photos take a twentieth of a byte per pixel or more; a surface of one colour, a thousandth. */
size_t rk_image_file_budget(size_t most_pixels, size_t bytes)
{
    const size_t base = (size_t)1 << 24, per_byte = 32;
    size_t budget = bytes < (SIZE_MAX - base) / per_byte ? base + per_byte * bytes : SIZE_MAX;
    return budget < most_pixels ? budget : most_pixels;
}

static rk_image_file_wish bounded(const rk_image_file_wish *wish, const char *path)
{
    rk_image_file_wish result = *wish;
    struct stat status;
    if (result.most_pixels > RK_IMAGE_PIXELS_MAX)
        result.most_pixels = RK_IMAGE_PIXELS_MAX;
    if (stat(path, &status) == 0)
        result.most_pixels = rk_image_file_budget(result.most_pixels, (size_t)status.st_size);
    return result;
}

bool rk_image_file_read_wished(rk_image *image, const char *path, const rk_image_file_wish *wish,
                               rk_error *error)
{
    const rk_image_file_wish within = bounded(wish, path);
    return read_limited(image, path, &within, error);
}

/* These formats have no alpha, so the file need not be read to learn it. */
static bool is_opaque_format(const char *path)
{
    return has_ending(path, ".jpg") || has_ending(path, ".jpeg") || has_ending(path, ".hdr") ||
           has_ending(path, ".pnm") || has_ending(path, ".ppm") || has_ending(path, ".pgm");
}

bool rk_image_file_read_opacity(rk_image *image, const char *path, const rk_image_file_wish *wish,
                                bool alpha_only, rk_error *error)
{
    const rk_image_file_wish within = bounded(wish, path);
    *image = (rk_image){0};
    if (!check_kind(path, error))
        return false;
    if (has_ending(path, ".png"))
        return rk_png_read_opacity(image, path, within.most_pixels, alpha_only, error);
    if (!alpha_only)
        return read_by_helper(image, path, RK_IMAGE_STREAM_OPACITY, &within, error);
    return is_opaque_format(path) ||
           read_by_helper(image, path, RK_IMAGE_STREAM_ALPHA, &within, NULL) || true;
}

/* --- writing --------------------------------------------------------------------------------- */

static bool write_exr(const char *path, const rk_image *image, rk_error *error)
{
    rk_file_place place;
    if (!rk_file_destination(&place, path, error))
        return false;
    path = place.text;
    size_t bytes = image->width * image->height * sizeof *image->pixels;
    unsigned char *input = rk_allocate(sizeof(head) + bytes, 1, path, error);
    if (!input)
        return false;
    head h = {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, (uint32_t)image->width,
              (uint32_t)image->height};
    memcpy(input, &h, sizeof h);
    memcpy(input + sizeof h, image->pixels, bytes);
    rk_helper_call call = make_call(path, (const char *[]){"write", path, NULL}, 0);
    call.input = input;
    call.input_size = sizeof h + bytes;
    unsigned char *reply;
    size_t size;
    bool ok = rk_helper_run(&call, &reply, &size, error);
    free(input);
    if (ok)
        free(reply);
    return ok;
}

bool rk_image_file_can_write(const char *path, rk_error *error)
{
    return has_ending(path, ".png") || has_ending(path, ".exr") ||
           rk_fail(error, "%s: pictures are written as .png or .exr; use one of these endings",
                   path);
}

bool rk_image_file_write(const char *path, const rk_image *image, rk_error *error)
{
    if (!rk_image_file_can_write(path, error))
        return false;
    if (image->width < 1 || image->height < 1 || image->width > RK_IMAGE_SIDE_MAX ||
        image->height > RK_IMAGE_SIDE_MAX)
        return rk_fail(error,
                       "%s: the picture to be written has %zu x %zu pixels: make each side 1 to %d",
                       path, image->width, image->height, RK_IMAGE_SIDE_MAX);
    return has_ending(path, ".png") ? rk_png_write(path, image, NULL, 0, error)
                                    : write_exr(path, image, error);
}
