/* The writing half of io/png.h, by libpng (its manual, libpng-manual.txt, and the PNG
 * specification, third edition, W3C). */
#include "base/file.h"
#include "io/png_job.h"
#include "io/srgb8.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Measured on 800 x 800 pixels: zlib's default level with libpng's choice of filters takes 20 ms
 * for a smooth picture and 200 ms for a noisy one, more than rendering it; these settings take 10
 * ms and 40 ms, for noisy files that are a seventh larger. */
enum { compression_level = 2, row_filter = PNG_FILTER_PAETH };

static void write_bytes(png_structp png, png_bytep bytes, size_t size)
{
    job *j = png_get_io_ptr(png);
    if (fwrite(bytes, 1, size, j->stream) == size)
        return;
    snprintf(j->reason, sizeof j->reason, "%s", strerror(errno));
    png_error(png, "write error");
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

static bool is_ascii(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text > 126)
            return false;
    return true;
}

/* The specification's rules for keywords, which libpng would enforce silently. */
static bool check_key(const job *j, const char *key)
{
    size_t length = strlen(key);
    bool ok = length >= 1 && length <= 79 && key[0] != ' ' && key[length - 1] != ' ' &&
              !strstr(key, "  ");
    for (size_t i = 0; ok && i < length; i++) {
        unsigned char c = (unsigned char)key[i];
        ok = (c >= 32 && c <= 126) || c >= 161;
    }
    return ok || rk_fail(j->error,
                         "%s: \"%s\" cannot be a text's key: use 1 to 79 printable characters, "
                         "without spaces at the ends or side by side",
                         j->path, key);
}

/* tEXt is Latin-1, iTXt is UTF-8: ASCII texts go into the older chunk, which every program
 * shows. */
static void set_text(job *j, const rk_png_text *text)
{
    png_text chunk = {
        .compression =
            is_ascii(text->value) ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE,
        .key = (char *)text->key,
        .text = (char *)text->value,
        .text_length = strlen(text->value),
    };
    png_set_text(j->png, j->info, &chunk, 1);
}

static void encode_row(const rk_srgb8 *table, const rk_vec3 *pixels, size_t width,
                       unsigned char *bytes)
{
    for (size_t x = 0; x < width; x++) {
        bytes[3 * x] = rk_srgb8_encode(table, pixels[x].x);
        bytes[3 * x + 1] = rk_srgb8_encode(table, pixels[x].y);
        bytes[3 * x + 2] = rk_srgb8_encode(table, pixels[x].z);
    }
}

static void write_all(job *j)
{
    size_t width = j->source->width, height = j->source->height;
    png_set_write_fn(j->png, j, write_bytes, flush_nothing);
    png_set_IHDR(j->png, j->info, (png_uint_32)width, (png_uint_32)height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(j->png, compression_level);
    png_set_filter(j->png, PNG_FILTER_TYPE_BASE, row_filter);
    png_set_sRGB(j->png, j->info, PNG_sRGB_INTENT_PERCEPTUAL);
    for (size_t i = 0; i < j->text_count; i++)
        set_text(j, &j->texts[i]);
    png_write_info(j->png, j->info);
    rk_srgb8 table;
    rk_srgb8_init(&table);
    for (size_t y = 0; y < height; y++) {
        encode_row(&table, rk_image_at(j->source, 0, y), width, j->bytes);
        png_write_row(j->png, j->bytes);
    }
    png_write_end(j->png, j->info);
}

static bool encode(job *j)
{
    for (size_t i = 0; i < j->text_count; i++)
        if (!check_key(j, j->texts[i].key))
            return false;
    j->bytes = rk_allocate(j->source->width, 3, j->path, j->error);
    if (!j->bytes)
        return false;
    j->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, j, on_error, on_warning);
    j->info = j->png ? png_create_info_struct(j->png) : NULL;
    if (!j->info)
        return rk_fail(
            j->error,
            "%s: libpng cannot start: no memory, or another version than "
            "raykit was built with; close other programs, or run ./configure and make again",
            j->path);
    return guarded(j, write_all) ||
           rk_fail(j->error,
                   "%s: could not be written whole: %s; free some space, or choose another place",
                   j->path, j->reason);
}

bool rk_png_write(const char *path, const rk_image *image, const rk_png_text *texts,
                  size_t text_count, rk_error *error)
{
    rk_file file;
    if (!rk_file_begin(&file, path, error))
        return false;
    job j = {.path = path,
             .stream = file.stream,
             .error = error,
             .source = image,
             .texts = texts,
             .text_count = text_count};
    bool ok = encode(&j);
    png_destroy_write_struct(&j.png, &j.info);
    free(j.bytes);
    if (ok)
        return rk_file_commit(&file, error);
    rk_file_abort(&file);
    return false;
}
