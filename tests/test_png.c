/* PNG pictures: written ones read back the same, broken ones are refused with a sentence. */
#include "test.h"
#include "test_folder.h"

#include "base/random.h"
#include "io/png.h"
#include "io/srgb8.h"

#include <errno.h>
#include <png.h>
#include <signal.h>
#include <sys/resource.h>

/* The transfer function again, in double and by the standard's inverse formula. */
static double encode_exactly(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static rk_image make_noise(size_t width, size_t height)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    for (uint32_t i = 0; i < width * height; i++)
        image.pixels[i] =
            rk_vec(rk_unit_float(rk_hash(7, i, 0, 0)), rk_unit_float(rk_hash(7, i, 1, 0)),
                   rk_unit_float(rk_hash(7, i, 2, 0)) * 0.01f);
    return image;
}

static test_path write_image(const test_folder *folder, const char *name, const rk_image *image)
{
    test_path path = test_folder_path(folder, name);
    rk_error error;
    rk_check_ok(rk_png_write(path.text, image, NULL, 0, &error), error);
    return path;
}

static rk_image read_image(const char *path)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_png_read(&image, path, &error), error);
    return image;
}

/* The picture must be refused in one line that names the file and says `part`. */
static void check_refused(const char *path, const char *part)
{
    rk_image image;
    rk_error error;
    rk_check(!rk_png_read(&image, path, &error), "%s was accepted", path);
    rk_check(!image.pixels, "%s: pixels were left behind", path);
    rk_check_error_names(error, path);
    rk_check_error_names(error, part);
    rk_check(!strchr(error.text, '\n'), "the error is longer than a line: %s", error.text);
}

/* --- eight bits ------------------------------------------------------------------------------ */

static void stored_values_are_exactly_rounded(void **state)
{
    (void)state;
    rk_srgb8 table;
    rk_srgb8_init(&table);
    /* Every 3001st float from the smallest to 1, in the order of their bits. */
    for (uint32_t bits = 0; bits <= 0x3f800000u; bits += 3001) {
        float linear;
        memcpy(&linear, &bits, sizeof linear);
        int want = (int)floor(255 * encode_exactly((double)linear) + 0.5);
        rk_check(rk_srgb8_encode(&table, linear) == want, "linear %a: got %d, want %d",
                 (double)linear, rk_srgb8_encode(&table, linear), want);
    }
}

static void stored_values_are_exactly_rounded_beside_each_step(void **state)
{
    (void)state;
    rk_srgb8 table;
    rk_srgb8_init(&table);
    for (int k = 1; k < 256; k++) {
        float at = table.step[k], before = nextafterf(at, 0);
        rk_check(encode_exactly((double)at) * 255 >= k - 0.5 - 1e-12,
                 "%a begins value %d too early", (double)at, k);
        rk_check(encode_exactly((double)before) * 255 < k - 0.5 + 1e-12,
                 "%a should have value %d already", (double)before, k);
        rk_check_equal(rk_srgb8_encode(&table, at), k, "a step belongs to the value above it");
        rk_check_equal(rk_srgb8_encode(&table, before), k - 1, "the float before it does not");
    }
}

static void the_fast_encoding_agrees_with_the_plain_one(void **state)
{
    (void)state;
    rk_srgb8 table;
    rk_srgb8_init(&table);
    for (uint32_t i = 0; i < 200000; i++) {
        float linear = rk_unit_float(rk_hash(3, i, 0, 0));
        /* Half a step is the rounding; powf is good to a few 2^-24, here times 255. */
        rk_check_close(rk_srgb8_encode(&table, linear), 255 * rk_srgb_encode(linear), 0.5 + 1e-4,
                       "both are the transfer function of IEC 61966-2-1");
    }
}

static void values_outside_the_range_are_clamped_and_nan_is_black(void **state)
{
    const float linear[] = {NAN, -NAN, INFINITY, -INFINITY, -1, -0.0f, 2, 1e38f, 1e-45f, 1};
    const float want[] = {0, 0, 1, 0, 0, 0, 1, 1, 0, 1};
    enum { count = sizeof linear / sizeof *linear };
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, count, 1, &error), error);
    for (int i = 0; i < count; i++)
        image.pixels[i] = rk_vec(linear[i], linear[i], linear[i]);
    test_path path = write_image(*state, "clamp.png", &image);
    rk_image back = read_image(path.text);
    for (int i = 0; i < count; i++)
        rk_check_close(back.pixels[i].y, want[i], 0, "0 and 1 are stored as 0 and 255");
    rk_image_free(&image);
    rk_image_free(&back);
}

/* --- there and back -------------------------------------------------------------------------- */

static void check_round_trip(const test_folder *folder, size_t width, size_t height)
{
    rk_image image = make_noise(width, height);
    test_path path = write_image(folder, "noise.png", &image);
    rk_image back = read_image(path.text);
    rk_check_equal(back.width, width, "the width is kept");
    rk_check_equal(back.height, height, "the height is kept");
    for (size_t i = 0; i < width * height; i++)
        for (int c = 0; c < 3; c++)
            /* Half of an 8-bit step, and the float arithmetic of two encodings. */
            rk_check_close(rk_srgb_encode(rk_axis(back.pixels[i], c)),
                           rk_srgb_encode(rk_axis(image.pixels[i], c)), 0.5 / 255 + 1e-6,
                           "the picture should come back within half a step");
    rk_image_free(&image);
    rk_image_free(&back);
}

static void a_picture_comes_back_within_half_a_step(void **state)
{
    check_round_trip(*state, 61, 47);
}

static void pictures_of_one_row_one_column_and_one_pixel_come_back(void **state)
{
    check_round_trip(*state, 1, 1);
    check_round_trip(*state, 500, 1);
    check_round_trip(*state, 1, 500);
}

static void the_same_picture_gives_the_same_file(void **state)
{
    rk_image image = make_noise(20, 20);
    size_t size_a, size_b;
    unsigned char *a = test_folder_read(write_image(*state, "a.png", &image), &size_a);
    unsigned char *b = test_folder_read(write_image(*state, "b.png", &image), &size_b);
    rk_check(size_a == size_b && memcmp(a, b, size_a) == 0, "a date or an address is in the file");
    free(a);
    free(b);
    rk_image_free(&image);
}

static void the_file_says_that_it_is_srgb(void **state)
{
    rk_image image = make_noise(1, 1);
    size_t size;
    unsigned char *bytes = test_folder_read(write_image(*state, "one.png", &image), &size);
    /* Signature 8, IHDR 25, then the sRGB chunk's length 4 and its name. */
    rk_check(size > 41 && memcmp(bytes + 37, "sRGB", 4) == 0, "the sRGB chunk should follow IHDR");
    free(bytes);
    rk_image_free(&image);
}

/* --- texts ----------------------------------------------------------------------------------- */

static void texts_come_back(void **state)
{
    const rk_png_text texts[] = {{"Software", "raykit 0.1.0"},
                                 {"raykit:samples", "64"},
                                 {"raykit:scene", "Größe 3 µm, \xe2\x88\x9a"
                                                  "2, \xf0\x9f\x8c\x84"},
                                 {"Comment", "two\nlines"},
                                 {"empty", ""}};
    enum { count = sizeof texts / sizeof *texts };
    rk_image image = make_noise(3, 2);
    test_path path = test_folder_path(*state, "texts.png");
    rk_error error;
    rk_check_ok(rk_png_write(path.text, &image, texts, count, &error), error);
    for (int i = 0; i < count; i++) {
        char *value = rk_png_read_text(path.text, texts[i].key, &error);
        rk_check(value, "%s: %s", texts[i].key, error.text[0] ? error.text : "not found");
        rk_check(strcmp(value, texts[i].value) == 0, "%s: got \"%s\", want \"%s\"", texts[i].key,
                 value, texts[i].value);
        free(value);
    }
    rk_image_free(&image);
}

static void a_missing_text_is_null_without_an_error(void **state)
{
    rk_image image = make_noise(3, 2);
    test_path path = write_image(*state, "plain.png", &image);
    rk_error error;
    rk_check(!rk_png_read_text(path.text, "Software", &error), "a text from nowhere");
    rk_check(error.text[0] == '\0', "no text is no error, but it says: %s", error.text);
    rk_check(!rk_png_read_text(test_folder_path(*state, "none.png").text, "Software", &error),
             "a text from a missing file");
    rk_check_error_names(error, "none.png");
    rk_image_free(&image);
}

static void keys_that_png_forbids_are_refused(void **state)
{
    char long_key[81] = "";
    memset(long_key, 'k', 80);
    const char *keys[] = {"", " a", "a ", "a  b", "a\nb", "\x7f", "\xa0", long_key};
    rk_image image = make_noise(2, 2);
    test_path path = test_folder_path(*state, "keys.png");
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        rk_error error;
        rk_check(!rk_png_write(path.text, &image, &(rk_png_text){keys[i], "v"}, 1, &error),
                 "the key \"%s\" was accepted", keys[i]);
        rk_check_error_names(error, "keys.png");
    }
    rk_check_equal(test_folder_count(*state), 0, "nothing is left of a refused picture");
    long_key[79] = '\0';
    rk_error error;
    rk_check_ok(rk_png_write(path.text, &image, &(rk_png_text){long_key, "v"}, 1, &error), error);
    rk_image_free(&image);
}

/* --- foreign PNG files ----------------------------------------------------------------------- */

typedef struct kind {
    int colour, depth, interlace;
    double gamma;       /* 0: no gAMA chunk */
    bool transparent;   /* with a tRNS chunk */
    unsigned char *row; /* the bytes of each row, as they are stored */
    int width, height;
} kind;

/* Writes a picture of any kind directly with libpng. */
static test_path write_kind(const test_folder *folder, const kind *k)
{
    test_path path = test_folder_path(folder, "kind.png");
    FILE *stream = fopen(path.text, "wb");
    rk_check(stream, "%s: the test cannot write its file", path.text);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_IHDR(png, info, (png_uint_32)k->width, (png_uint_32)k->height, k->depth, k->colour,
                 k->interlace, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    const png_color palette[] = {{0, 0, 0}, {255, 0, 0}, {0, 128, 0}, {0, 0, 255}};
    if (k->colour == PNG_COLOR_TYPE_PALETTE)
        png_set_PLTE(png, info, palette, 4);
    if (k->transparent)
        png_set_tRNS(png, info, (const png_byte[]){0, 10, 20, 30}, 4, &(png_color_16){.gray = 1});
    if (k->gamma > 0)
        png_set_gAMA(png, info, k->gamma);
    png_write_info(png, info);
    int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; pass++)
        for (int y = 0; y < k->height; y++)
            png_write_row(png, k->row);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    fclose(stream);
    return path;
}

static void check_pixel(const rk_image *image, size_t x, double r, double g, double b)
{
    /* One rounding to float, and powf's. */
    rk_vec3 got = *rk_image_at(image, x, image->height - 1);
    rk_check_close(got.x, r, 2e-7, "red");
    rk_check_close(got.y, g, 2e-7, "green");
    rk_check_close(got.z, b, 2e-7, "blue");
}

/* The linear value of the stored byte 128 (that is, of 128 / 255 = 0.50196), by the standard. */
static const double half = 0.21586050011389926;

static void a_palette_is_looked_up_with_and_without_transparency(void **state)
{
    for (int transparent = 0; transparent < 2; transparent++) {
        kind k = {.colour = PNG_COLOR_TYPE_PALETTE,
                  .depth = 2,
                  .transparent = transparent != 0,
                  .row = (unsigned char[]){0x1b},
                  .width = 4,
                  .height = 1};
        rk_image image = read_image(write_kind(*state, &k).text);
        check_pixel(&image, 0, 0, 0, 0);
        check_pixel(&image, 1, 1, 0, 0);
        check_pixel(&image, 2, 0, half, 0);
        check_pixel(&image, 3, 0, 0, 1);
        rk_image_free(&image);
    }
}

static void grey_is_replicated_at_one_eight_and_sixteen_bits(void **state)
{
    kind one = {.colour = PNG_COLOR_TYPE_GRAY,
                .depth = 1,
                .transparent = true,
                .row = (unsigned char[]){0x40},
                .width = 2,
                .height = 1};
    kind eight = {.colour = PNG_COLOR_TYPE_GRAY,
                  .depth = 8,
                  .row = (unsigned char[]){0, 128},
                  .width = 2,
                  .height = 1};
    kind sixteen = {.colour = PNG_COLOR_TYPE_GRAY,
                    .depth = 16,
                    .row = (unsigned char[]){0, 0, 128, 128},
                    .width = 2,
                    .height = 1};
    const kind *kinds[] = {&one, &eight, &sixteen};
    const double second[] = {1, half, half};
    for (int i = 0; i < 3; i++) {
        rk_image image = read_image(write_kind(*state, kinds[i]).text);
        check_pixel(&image, 0, 0, 0, 0);
        check_pixel(&image, 1, second[i], second[i], second[i]);
        rk_image_free(&image);
    }
}

static void sixteen_bits_keep_what_eight_would_lose(void **state)
{
    /* 1 / 65535 is on the linear foot of the curve. */
    kind k = {.colour = PNG_COLOR_TYPE_RGB,
              .depth = 16,
              .row = (unsigned char[]){0, 1, 128, 128, 255, 255},
              .width = 1,
              .height = 1};
    rk_image image = read_image(write_kind(*state, &k).text);
    rk_check_close(image.pixels[0].x, 1 / 65535.0 / 12.92, 1e-12, "the lowest bit, linear");
    check_pixel(&image, 0, 1 / 65535.0 / 12.92, half, 1);
    rk_image_free(&image);
}

static void alpha_is_dropped_and_does_not_darken(void **state)
{
    kind k = {.colour = PNG_COLOR_TYPE_RGB_ALPHA,
              .depth = 8,
              .row = (unsigned char[]){255, 128, 0, 0, 0, 128, 255, 77},
              .width = 2,
              .height = 1};
    rk_image image = read_image(write_kind(*state, &k).text);
    check_pixel(&image, 0, 1, half, 0);
    check_pixel(&image, 1, 0, half, 1);
    rk_image_free(&image);
}

static void interlaced_rows_come_in_order(void **state)
{
    unsigned char row[13 * 3];
    for (int i = 0; i < 13 * 3; i++)
        row[i] = (unsigned char)(i * 5);
    kind k = {.colour = PNG_COLOR_TYPE_RGB,
              .depth = 8,
              .interlace = PNG_INTERLACE_ADAM7,
              .row = row,
              .width = 13,
              .height = 11};
    rk_image image = read_image(write_kind(*state, &k).text);
    for (size_t y = 0; y < 11; y++)
        for (size_t x = 0; x < 13; x++)
            rk_check_close(rk_srgb_encode(rk_image_at(&image, x, y)->z) * 255, row[3 * x + 2], 1e-3,
                           "float arithmetic of two encodings, far below a step");
    rk_image_free(&image);
}

static void a_gamma_other_than_srgbs_is_honoured(void **state)
{
    kind k = {.colour = PNG_COLOR_TYPE_GRAY,
              .depth = 8,
              .row = (unsigned char[]){128},
              .width = 1,
              .height = 1};
    const double gamma[] = {0, 1 / 2.2, 1, 0.5};
    const double stored = 128 / 255.0, want[] = {half, half, stored, stored * stored};
    for (int i = 0; i < 4; i++) {
        k.gamma = gamma[i];
        rk_image image = read_image(write_kind(*state, &k).text);
        check_pixel(&image, 0, want[i], want[i], want[i]);
        rk_image_free(&image);
    }
}

static void latin1_texts_become_utf8(void **state)
{
    /* A 1 x 1 picture with a tEXt chunk that contains byte 0xe9, made by libpng. */
    test_path path = test_folder_path(*state, "latin1.png");
    FILE *stream = fopen(path.text, "wb");
    rk_check(stream, "%s: the test cannot write its file", path.text);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_IHDR(png, info, 1, 1, 8, PNG_COLOR_TYPE_GRAY, 0, 0, 0);
    png_write_info(png, info);
    png_write_row(png, (const unsigned char[]){9});
    /* After the picture, where a reader must still find it. */
    char key[] = "Author", value[] = "Ren\xe9";
    png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = value};
    png_set_text(png, info, &text, 1);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    fclose(stream);
    rk_error error;
    char *back = rk_png_read_text(path.text, "Author", &error);
    rk_check(back, "the text behind the picture was not found: %s", error.text);
    rk_check(strcmp(back, "Ren\xc3\xa9") == 0, "got \"%s\", want it as UTF-8", back);
    free(back);
}

/* --- broken files ---------------------------------------------------------------------------- */

static void every_truncation_is_refused(void **state)
{
    rk_image image = make_noise(9, 7);
    size_t size;
    unsigned char *bytes = test_folder_read(write_image(*state, "whole.png", &image), &size);
    test_path path;
    for (size_t length = 0; length < size; length++) {
        path = test_folder_write(*state, "short.png", bytes, length, 0600);
        check_refused(path.text, length ? "" : "empty");
        rk_error error;
        char *text = rk_png_read_text(path.text, "none", &error);
        rk_check(!text && error.text[0], "a text from a file of %zu bytes", length);
    }
    free(bytes);
    rk_image_free(&image);
}

static void every_damaged_byte_is_refused_or_read(void **state)
{
    rk_image image = make_noise(9, 7);
    size_t size;
    unsigned char *bytes = test_folder_read(write_image(*state, "whole.png", &image), &size);
    test_path path;
    for (size_t at = 0; at < size; at++) {
        bytes[at] ^= 0x55;
        path = test_folder_write(*state, "damaged.png", bytes, size, 0600);
        rk_image back;
        rk_error error;
        if (rk_png_read(&back, path.text, &error))
            rk_image_free(&back);
        else
            rk_check_error_names(error, "damaged.png");
        bytes[at] ^= 0x55;
    }
    free(bytes);
    rk_image_free(&image);
}

/* Reads a complete 1 x 1 picture whose header was changed to claim another size. */
static void check_claim(const test_folder *folder, uint32_t width, uint32_t height,
                        const char *part)
{
    rk_image image = make_noise(1, 1);
    size_t size;
    unsigned char *bytes = test_folder_read(write_image(folder, "one.png", &image), &size);
    rk_image_free(&image);
    for (int i = 0; i < 4; i++) {
        bytes[16 + i] = (unsigned char)(width >> (24 - 8 * i));
        bytes[20 + i] = (unsigned char)(height >> (24 - 8 * i));
    }
    png_uint_32 crc = 0xffffffffu; /* the chunk's checksum, so that only the size is wrong */
    for (int i = 12; i < 29; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc & 1 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
    }
    for (int i = 0; i < 4; i++)
        bytes[29 + i] = (unsigned char)(~crc >> (24 - 8 * i));
    test_path path = test_folder_write(folder, "claim.png", bytes, size, 0600);
    free(bytes);
    check_refused(path.text, part);
}

static void absurd_sizes_are_refused_before_memory_is_taken(void **state)
{
    check_claim(*state, 0x80000000u, 0x80000000u, "2147483648 x 2147483648");
    check_claim(*state, 0xffffffffu, 1, "4294967295 x 1");
    check_claim(*state, 32769, 1, "1 to 32768");
    check_claim(*state, 0, 1, "0 x 1");
    check_claim(*state, 1, 0, "1 x 0");
    check_claim(*state, 32768, 32768, "too short for its size");
    check_claim(*state, 2, 2, "damaged");
}

/* The files end after a header of at least 24 bytes: the limit is asked before anything is read. */
static void a_limit_of_pixels_is_asked_before_reading(void **state)
{
    rk_image image = make_noise(9, 7), back;
    test_path path = write_image(*state, "nine.png", &image);
    rk_error error = {""};
    rk_image_free(&image);
    rk_check(!rk_png_read_within(&back, path.text, 62, &error), "63 pixels were read into 62");
    rk_check_error_names(error, "9 x 7 pixels, more than the 62 allowed");
    rk_check_ok(rk_png_read_within(&back, path.text, 63, &error), error);
    rk_image_free(&back);
    size_t size;
    unsigned char *bytes = test_folder_read(path, &size);
    path = test_folder_write(*state, "head.png", bytes, 24, 0600);
    free(bytes);
    rk_check(!rk_png_read_within(&back, path.text, 62, &error), "a header was read as a picture");
    rk_check_error_names(error, "9 x 7 pixels, more than the 62 allowed");
}

/* The signature, the head of a grey picture of one pixel, and the head of a text. */
static const unsigned char text_of_two_gigabytes[] =
    "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x8\0\0\0\0\x3a\x7e\x9b\x55"
    "\x7f\xff\xff\xf0tEXtKey\0and so on";

static void a_text_that_claims_gigabytes_takes_no_memory(void **state)
{
    test_path path = test_folder_write(*state, "claim.png", text_of_two_gigabytes,
                                       sizeof text_of_two_gigabytes, 0600);
    check_refused(path.text, "damaged PNG"); /* the reason depends on libpng's version */
    struct rusage usage;
    rk_check(getrusage(RUSAGE_SELF, &usage) == 0, "the system tells the memory that was used");
    /* The suite itself takes a few MB, with sanitizers a few hundred. */
    rk_check(usage.ru_maxrss < 1000000, "%ld KB were used for a file of %zu bytes", usage.ru_maxrss,
             sizeof text_of_two_gigabytes);
}

static void a_text_of_seven_megabytes_is_read(void **state)
{
    enum { length = 7000000 };
    char *value = malloc(length + 1);
    rk_check(value, "no memory");
    memset(value, 'x', length);
    value[length] = '\0';
    rk_image image = make_noise(3, 2);
    test_path path = test_folder_path(*state, "long.png");
    const rk_png_text text = {"Comment", value};
    rk_error error = {""};
    rk_check_ok(rk_png_write(path.text, &image, &text, 1, &error), error);
    free(value);
    rk_image_free(&image);
    char *back = rk_png_read_text(path.text, "Comment", &error);
    rk_check(back, "the text is lost: %s", error.text);
    rk_check_equal(strlen(back), length, "its length");
    free(back);
}

static void a_pipe_is_refused_at_once(void **state)
{
    test_path pipe = test_folder_path(*state, "pipe.png");
    rk_check(mkfifo(pipe.text, 0600) == 0, "a pipe can be made");
    check_refused(pipe.text, "is not a regular file");
    rk_error error = {""};
    rk_check(!rk_png_read_text(pipe.text, "Key", &error), "a text came out of a pipe");
    rk_check_error_names(error, "is not a regular file");
}

static void files_that_are_not_png_are_refused(void **state)
{
    const char jpeg[] = "\xff\xd8\xff\xe0 JFIF and so on, longer than a header of PNG";
    test_path path = test_folder_write(*state, "photo.png", jpeg, sizeof jpeg, 0600);
    check_refused(path.text, "not a PNG");
    path = test_folder_write(*state, "photo.png", "", 0, 0600);
    check_refused(path.text, "empty");
    check_refused(test_folder_path(*state, "none.png").text, strerror(ENOENT));
    check_refused(((test_folder *)*state)->path, strerror(EISDIR));
}

/* --- places that cannot be written ----------------------------------------------------------- */

static void a_missing_folder_is_an_error(void **state)
{
    rk_image image = make_noise(2, 2);
    test_folder_write(*state, "file", "x", 1, 0600);
    const char *names[] = {"none/a.png", "file/a.png"};
    for (int i = 0; i < 2; i++) {
        rk_error error;
        test_path path = test_folder_path(*state, names[i]);
        rk_check(!rk_png_write(path.text, &image, NULL, 0, &error), "%s was written", path.text);
        rk_check_error_names(error, path.text);
    }
    rk_check_equal(test_folder_count(*state), 1, "nothing is left of a failed picture");
    rk_image_free(&image);
}

/* A limit on file sizes simulates a full disk: fwrite fails in the middle or, if the picture fits
 * the stream's buffer, only at the end. */
static bool write_on_full_disk(const char *path, const rk_image *image, rlim_t room,
                               rk_error *error)
{
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = room;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    bool ok = rk_png_write(path, image, NULL, 0, error);
    setrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, handler);
    return ok;
}

static void a_full_disk_keeps_the_older_picture(void **state)
{
    rk_image older = make_noise(1, 1);
    test_path path = write_image(*state, "picture.png", &older);
    const size_t sides[] = {8, 200};
    for (int i = 0; i < 2; i++) {
        rk_image image = make_noise(sides[i], sides[i]);
        rk_error error;
        rk_check(!write_on_full_disk(path.text, &image, 100, &error), "100 bytes were enough");
        rk_check_error_names(error, path.text);
        rk_check_error_names(error, strerror(EFBIG));
        rk_check_equal(test_folder_count(*state), 1, "no temporary file may be left");
        rk_image_free(&image);
    }
    rk_image back = read_image(path.text);
    rk_check_equal(back.width, 1, "the older picture is still there");
    rk_image_free(&older);
    rk_image_free(&back);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(stored_values_are_exactly_rounded),
    cmocka_unit_test(stored_values_are_exactly_rounded_beside_each_step),
    cmocka_unit_test(the_fast_encoding_agrees_with_the_plain_one),
    test_in_folder(values_outside_the_range_are_clamped_and_nan_is_black),
    test_in_folder(a_picture_comes_back_within_half_a_step),
    test_in_folder(pictures_of_one_row_one_column_and_one_pixel_come_back),
    test_in_folder(the_same_picture_gives_the_same_file),
    test_in_folder(the_file_says_that_it_is_srgb),
    test_in_folder(texts_come_back),
    test_in_folder(a_missing_text_is_null_without_an_error),
    test_in_folder(keys_that_png_forbids_are_refused),
    test_in_folder(a_palette_is_looked_up_with_and_without_transparency),
    test_in_folder(grey_is_replicated_at_one_eight_and_sixteen_bits),
    test_in_folder(sixteen_bits_keep_what_eight_would_lose),
    test_in_folder(alpha_is_dropped_and_does_not_darken),
    test_in_folder(interlaced_rows_come_in_order),
    test_in_folder(a_gamma_other_than_srgbs_is_honoured),
    test_in_folder(latin1_texts_become_utf8),
    test_in_folder(every_truncation_is_refused),
    test_in_folder(every_damaged_byte_is_refused_or_read),
    test_in_folder(absurd_sizes_are_refused_before_memory_is_taken),
    test_in_folder(a_limit_of_pixels_is_asked_before_reading),
    test_in_folder(a_text_that_claims_gigabytes_takes_no_memory),
    test_in_folder(a_text_of_seven_megabytes_is_read),
    test_in_folder(a_pipe_is_refused_at_once),
    test_in_folder(files_that_are_not_png_are_refused),
    test_in_folder(a_missing_folder_is_an_error),
    test_in_folder(a_full_disk_keeps_the_older_picture),
};

RK_SUITE("png", tests)
