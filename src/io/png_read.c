/* The reading half of io/png.h, by libpng (its manual, libpng-manual.txt, and the PNG
 * specification, third edition, W3C). */
#include "io/png_job.h"
#include "io/srgb8.h"
#include "io/stand_in.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static void read_bytes(png_structp png, png_bytep bytes, size_t size)
{
    job *j = png_get_io_ptr(png);
    if (fread(bytes, 1, size, j->stream) != size)
        png_error(png, ferror(j->stream) ? strerror(errno) : "the file ends too early");
}

static uint32_t big_endian(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* libpng's own messages about a wrong size or a foreign file are of little help, so the first 24
 * bytes (signature, the chunk's length and name, width, height) are checked before it starts. */
static bool check_head(const job *j)
{
    unsigned char head[24];
    size_t size = fread(head, 1, sizeof head, j->stream);
    if (size == 0 && ferror(j->stream))
        return rk_fail(j->error, "%s: cannot be read: %s; check its name and permissions", j->path,
                       strerror(errno));
    if (size == 0)
        return rk_fail(j->error, "%s: the file is empty; save or download it again", j->path);
    if (!rk_stand_in_check(j->path, head, size, j->error))
        return false;
    if (png_sig_cmp(head, 0, size < 8 ? size : 8) != 0)
        return rk_fail(
            j->error, "%s: is not a PNG picture; rename it with the ending of its format", j->path);
    if (size < sizeof head)
        return rk_fail(j->error,
                       "%s: damaged PNG: the file ends too early; save or download it again",
                       j->path);
    uint32_t width = big_endian(head + 16), height = big_endian(head + 20);
    if (width < 1 || height < 1 || width > RK_IMAGE_SIDE_MAX || height > RK_IMAGE_SIDE_MAX)
        return rk_fail(j->error, "%s: claims %u x %u pixels: choose one with sides of 1 to %d",
                       j->path, width, height, RK_IMAGE_SIDE_MAX);
    if ((uintmax_t)width * height > j->most_pixels)
        return rk_fail(j->error,
                       "%s: has %u x %u pixels, more than the %zu allowed here: make it smaller",
                       j->path, width, height, j->most_pixels);
    const char *needed = rk_image_shape_fault(j->shape, width, height);
    if (needed)
        return rk_fail(j->error, "%.700s: has %u x %u pixels: %s", j->path, width, height, needed);
    rewind(j->stream);
    return true;
}

/* Of a chunk after decompression, and kept chunks; a small file may hold much or many. */
enum { chunk_max = 8 << 20, chunks_max = 1000 };

/* A file of 60 bytes may claim 2 GB for a text: libpng would allocate them and fill them with
 * zeros, in spite of png_set_chunk_malloc_max. */
static png_voidp allocate_block(png_structp png, png_alloc_size_t size)
{
    const job *j = png_get_mem_ptr(png);
    if (size > j->file_size + chunk_max)
        png_error(png, "a part claims to be larger than the file");
    return malloc(size);
}

static void free_block(png_structp png, png_voidp block)
{
    (void)png;
    free(block);
}

/* Opening a pipe would wait for a process at its other end. */
static bool open_picture(job *j)
{
    struct stat status;
    if (stat(j->path, &status) != 0)
        return rk_fail(j->error, "%s: cannot be read: %s; check its name and permissions", j->path,
                       strerror(errno));
    if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
        return rk_fail(j->error, "%s: is not a regular file: copy the picture to one", j->path);
    j->stream = fopen(j->path, "rb");
    if (!j->stream)
        return rk_fail(j->error, "%s: cannot be read: %s; check its name and permissions", j->path,
                       strerror(errno));
    j->file_size = (uintmax_t)status.st_size;
    if (!check_head(j))
        return false;
    j->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, j, on_error, on_warning, j,
                                      allocate_block, free_block);
    j->info = j->png ? png_create_info_struct(j->png) : NULL;
    return j->info ||
           rk_fail(j->error,
                   "%s: libpng cannot start: no memory, or another version than raykit was "
                   "built with; close other programs, or run ./configure and make again",
                   j->path);
}

static void close_picture(job *j)
{
    png_destroy_read_struct(&j->png, &j->info, NULL);
    if (j->stream)
        fclose(j->stream);
    free(j->bytes);
    free(j->linear);
}

static bool run(job *j, void (*work)(job *))
{
    return guarded(j, work) ||
           rk_fail(j->error, "%s: damaged PNG: %s; save or download it again", j->path, j->reason);
}

static void read_head(job *j)
{
    png_set_read_fn(j->png, j, read_bytes);
    png_set_user_limits(j->png, RK_IMAGE_SIDE_MAX, RK_IMAGE_SIDE_MAX);
    png_set_chunk_malloc_max(j->png, chunk_max);
    png_set_chunk_cache_max(j->png, chunks_max);
    png_read_info(j->png, j->info);
    /* Deflate compresses no more than 1032 bytes into one (zlib's technical details), so a small
     * file that claims a large size is detected here, before it takes gigabytes. */
    uintmax_t raw =
        (uintmax_t)png_get_rowbytes(j->png, j->info) * png_get_image_height(j->png, j->info);
    if (raw / 1032 > j->file_size)
        png_error(j->png, "the file is too short for its size in pixels");
}

/* From here on libpng delivers RGB of 8 or 16 bits, with alpha if the opacity is wanted. */
static void ask_for_rgb(job *j)
{
    j->has_alpha = png_get_color_type(j->png, j->info) & PNG_COLOR_MASK_ALPHA ||
                   png_get_valid(j->png, j->info, PNG_INFO_tRNS);
    png_set_expand(j->png);
    if (j->opacity)
        png_set_add_alpha(j->png, 0xffff, PNG_FILLER_AFTER);
    else
        png_set_strip_alpha(j->png);
    png_set_gray_to_rgb(j->png);
    png_set_interlace_handling(j->png);
    png_read_update_info(j->png, j->info);
}

static void read_rows(job *j)
{
    size_t row = png_get_rowbytes(j->png, j->info);
    int passes = png_get_interlace_type(j->png, j->info) == PNG_INTERLACE_NONE
                     ? 1
                     : PNG_INTERLACE_ADAM7_PASSES;
    for (int pass = 0; pass < passes; pass++)
        for (size_t y = 0; y < j->image->height; y++)
            png_read_row(j->png, j->bytes + y * row, NULL);
    png_read_end(j->png, NULL);
}

/* The exponent from stored to linear values, or 0 for the sRGB curve: without a gAMA chunk, or with
 * sRGB's (1 / 2.2, which programs round differently). */
static double power_of(const job *j)
{
    int intent;
    double gamma;
    if (png_get_sRGB(j->png, j->info, &intent) || !png_get_gAMA(j->png, j->info, &gamma) ||
        fabs(gamma - 1 / 2.2) < 0.001)
        return 0;
    return 1 / gamma;
}

static bool make_linear(job *j, size_t values)
{
    j->linear = rk_allocate(values, sizeof *j->linear, j->path, j->error);
    if (!j->linear)
        return false;
    double power = power_of(j);
    for (size_t i = 0; i < values; i++) {
        double stored = (double)i / (double)(values - 1);
        j->linear[i] = power > 0 ? (float)pow(stored, power) : rk_srgb_decode((float)stored);
    }
    return true;
}

static void decode_pixels(const job *j, bool deep)
{
    const unsigned char *b = j->bytes;
    const float *linear = j->linear;
    size_t count = j->image->width * j->image->height;
    for (size_t i = 0; i < count; i++, b += deep ? 6 : 3)
        j->image->pixels[i] = deep ? rk_vec(linear[b[0] << 8 | b[1]], linear[b[2] << 8 | b[3]],
                                            linear[b[4] << 8 | b[5]])
                                   : rk_vec(linear[b[0]], linear[b[1]], linear[b[2]]);
}

static double stored_value(const unsigned char *at, bool deep)
{
    return deep ? (at[0] << 8 | at[1]) / 65535.0 : at[0] / 255.0;
}

static void decode_opacity(const job *j, bool deep)
{
    const size_t size = deep ? 2 : 1, count = j->image->width * j->image->height;
    const unsigned char *b = j->bytes;
    for (size_t i = 0; i < count; i++, b += 4 * size) {
        const double sum =
            stored_value(b, deep) + stored_value(b + size, deep) + stored_value(b + 2 * size, deep);
        const float v = (float)(j->has_alpha ? stored_value(b + 3 * size, deep) : sum / 3);
        j->image->pixels[i] = rk_vec(v, v, v);
    }
}

static bool decode(job *j)
{
    if (!open_picture(j) || !run(j, read_head) || !run(j, ask_for_rgb))
        return false;
    if (j->alpha_only && !j->has_alpha)
        return true;
    size_t height = png_get_image_height(j->png, j->info);
    bool deep = png_get_bit_depth(j->png, j->info) == 16;
    j->bytes = rk_allocate(height, png_get_rowbytes(j->png, j->info), j->path, j->error);
    if (!j->bytes || !make_linear(j, deep ? 65536 : 256) ||
        !rk_image_init(j->image, png_get_image_width(j->png, j->info), height, j->error) ||
        !run(j, read_rows))
        return false;
    if (j->opacity)
        decode_opacity(j, deep);
    else
        decode_pixels(j, deep);
    return true;
}

static bool read_picture(job *j)
{
    *j->image = (rk_image){0};
    bool ok = decode(j);
    close_picture(j);
    if (!ok)
        rk_image_free(j->image);
    return ok;
}

bool rk_png_read_shaped(rk_image *image, const char *path, size_t most_pixels, rk_image_shape shape,
                        rk_error *error)
{
    return read_picture(&(job){
        .path = path, .error = error, .image = image, .most_pixels = most_pixels, .shape = shape});
}

bool rk_png_read_opacity(rk_image *image, const char *path, size_t most_pixels, bool alpha_only,
                         rk_error *error)
{
    return read_picture(&(job){.path = path,
                               .error = error,
                               .image = image,
                               .most_pixels = most_pixels,
                               .opacity = true,
                               .alpha_only = alpha_only});
}

bool rk_png_read_within(rk_image *image, const char *path, size_t most_pixels, rk_error *error)
{
    return rk_png_read_shaped(image, path, most_pixels, RK_IMAGE_ANY, error);
}

bool rk_png_read(rk_image *image, const char *path, rk_error *error)
{
    return rk_png_read_within(image, path, RK_IMAGE_PIXELS_MAX, error);
}

/* --- texts ----------------------------------------------------------------------------------- */

static char *utf8_of_latin1(const char *text)
{
    char *utf8 = malloc(2 * strlen(text) + 1), *end = utf8;
    if (!utf8)
        return NULL;
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c < 128) {
            *end++ = (char)c;
        } else {
            *end++ = (char)(0xc0 | c >> 6);
            *end++ = (char)(0x80 | (c & 0x3f));
        }
    }
    *end = '\0';
    return utf8;
}

static void find_text(job *j)
{
    png_textp texts;
    int count = 0;
    png_get_text(j->png, j->info, &texts, &count);
    for (int i = 0; i < count && !j->value; i++) {
        if (strcmp(texts[i].key, j->key) != 0)
            continue;
        bool latin1 = texts[i].compression <= PNG_TEXT_COMPRESSION_zTXt;
        j->value = latin1 ? utf8_of_latin1(texts[i].text) : strdup(texts[i].text);
        if (!j->value)
            png_error(j->png, "no memory for its text");
    }
}

/* Texts may also follow the picture. */
static void skip_picture(job *j)
{
    int passes = png_set_interlace_handling(j->png);
    for (int pass = 0; pass < passes; pass++)
        for (png_uint_32 y = 0; y < png_get_image_height(j->png, j->info); y++)
            png_read_row(j->png, NULL, NULL);
    png_read_end(j->png, j->info);
}

char *rk_png_read_text(const char *path, const char *key, rk_error *error)
{
    if (error)
        error->text[0] = '\0';
    job j = {.path = path, .error = error, .key = key, .most_pixels = RK_IMAGE_PIXELS_MAX};
    if (open_picture(&j) && run(&j, read_head) && run(&j, find_text) && !j.value &&
        run(&j, skip_picture))
        run(&j, find_text);
    close_picture(&j);
    return j.value;
}
