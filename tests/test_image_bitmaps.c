/* Pictures of BMP and TGA, byte by byte: where their colours are, and whether the rest is alpha. */
#include "test.h"

#include "byte_list.h"
#include "remedy.h"
#include "test_folder.h"

#include "io/image_file.h"

static rk_image_file_reader reader;

static int end_reader(void **state)
{
    (void)state;
    rk_image_file_reader_end(&reader);
    return 0;
}

/* Red, green / blue, and 255 192 64: what the files below store. */
static const unsigned char four_pixels[4][3] = {
    {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 192, 64}};

static void check_four_pixels(test_path path, double step)
{
    const rk_image_file_wish wish = {.most_pixels = RK_IMAGE_PIXELS_MAX, .reader = &reader};
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_file_read_wished(&image, path.text, &wish, &error), error);
    rk_check_equal(image.width, 2, path.text);
    rk_check_equal(image.height, 2, path.text);
    for (size_t i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++)
            rk_check_near(255 * rk_srgb_encode(rk_axis(image.pixels[i], c)), four_pixels[i][c],
                          step, "%s, pixel %zu, channel %d", path.text, i, c);
    rk_image_free(&image);
}

/* -1 if the picture says that it is opaque. */
static double opacity_of(test_path path)
{
    const rk_image_file_wish wish = {.most_pixels = RK_IMAGE_PIXELS_MAX, .reader = &reader};
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_file_read_opacity(&image, path.text, &wish, true, &error), error);
    const double opacity = image.pixels ? (double)image.pixels[3].x : -1;
    rk_image_free(&image);
    return opacity;
}

/* Moves each channel to the bits of its mask. */
static void append_pixel(byte_list *list, const unsigned char *rgb, unsigned char alpha,
                         const uint32_t masks[4], size_t bytes)
{
    const unsigned char values[4] = {rgb[0], rgb[1], rgb[2], alpha};
    uint32_t pixel = 0;
    for (int c = 0; c < 4; c++) {
        const uint32_t lowest = masks[c] & (~masks[c] + 1);
        if (masks[c])
            pixel |= (uint32_t)lround(values[c] / 255.0 * (masks[c] / lowest)) * lowest;
    }
    append(list, &pixel, bytes); /* little-endian */
}

/* Of 2 x 2 pixels, from the lowest row or from the top. `kind`: biCompression. */
static test_path write_bmp(const test_folder *folder, uint32_t head, uint32_t bits, uint32_t kind,
                           const uint32_t masks[4], unsigned char alpha, bool from_top)
{
    const uint32_t loose = head > 40 || kind == 0 ? 0 : kind == 6 ? 16 : 12; /* bytes of masks */
    const uint32_t begin = 14 + head + loose;
    const int32_t height = from_top ? -2 : 2;
    byte_list list = {.size = 0};
    unsigned char info[124] = {0};
    put_word(info, 0, head);
    put_word(info, 1, 2);
    put_word(info, 2, (uint32_t)height);
    put_word(info, 3, bits << 16 | 1);
    put_word(info, 4, kind);
    for (int c = 0; c < 4 && head > 40; c++)
        put_word(info, 10 + c, masks[c]);
    append(&list, "BM\0\0\0\0\0\0\0\0", 10);
    append(&list, &begin, sizeof begin);
    append(&list, info, head);
    append(&list, masks, loose);
    for (size_t i = 0; i < 4; i++)
        append_pixel(&list, four_pixels[from_top ? i : i ^ 2], alpha, masks, bits / 8);
    return test_folder_write(folder, "made.bmp", list.bytes, list.size, 0600);
}

static void the_masks_of_a_bitmap_say_where_its_colours_are(void **state)
{
    static const uint32_t masks[][4] = {{0xff0000, 0xff00, 0xff, 0},
                                        {0xff, 0xff00, 0xff0000, 0},
                                        {0xff000000, 0xff0000, 0xff00, 0xff},
                                        {0x3ff00000, 0xffc00, 0x3ff, 0},
                                        {0xff, 0x3ff00, 0xf8000000, 0x40000}};
    for (size_t i = 0; i < 5; i++)
        for (int from_top = 0; from_top < 2; from_top++) {
            const double step = i == 4 ? 4.2 : 0.51; /* half of one of 31 */
            check_four_pixels(write_bmp(*state, 40, 32, 3, masks[i], 0, from_top), step);
            check_four_pixels(write_bmp(*state, 124, 32, 3, masks[i], 255, from_top), step);
        }
    static const uint32_t masks16[][4] = {
        {0xf800, 0x7e0, 0x1f, 0}, {0x7c00, 0x3e0, 0x1f, 0}, {0x1f, 0x7e0, 0xf800, 0}};
    for (size_t i = 0; i < 3; i++)
        check_four_pixels(write_bmp(*state, 40, 16, 3, masks16[i], 0, false), 4.2);
}

static void a_fourth_byte_of_a_bitmap_is_alpha_if_its_header_says_so(void **state)
{
    static const uint32_t masks[4] = {0xff0000, 0xff00, 0xff, 0xff000000};
    static const struct {
        uint32_t head, kind;
        unsigned char alpha;
        double want;
    } files[] = {{40, 0, 0, -1},  {40, 0, 51, -1},   {40, 3, 51, -1},   {40, 6, 51, 0.2},
                 {52, 3, 51, -1}, {56, 3, 51, 0.2},  {108, 3, 51, 0.2}, {124, 3, 51, 0.2},
                 {124, 3, 0, -1}, {124, 3, 255, -1}, {124, 0, 51, -1}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        const test_path path =
            write_bmp(*state, files[i].head, 32, files[i].kind, masks, files[i].alpha, false);
        check_four_pixels(path, 0.51);
        const double got = opacity_of(path);
        rk_check_near(got == 1 ? -1 : got, files[i].want, 1e-6, "file %zu", i);
    }
}

/* `attributes`: bits of alpha, 16 if rows begin on the right, 32 if at the top. Each row is a run
 * of single pixels if `kind` is 9 or more. */
static test_path write_tga(const test_folder *folder, unsigned char kind, unsigned char bits,
                           unsigned char attributes, unsigned char alpha)
{
    const uint32_t masks[4] = {bits == 16 ? 0x7c00 : 0xff0000, bits == 16 ? 0x3e0 : 0xff00,
                               bits == 16 ? 0x1f : 0xff, bits == 16 ? 0x8000 : 0xff000000};
    const bool has_map = kind % 8 == 1;
    const unsigned char pixel = has_map ? 8 : bits, width = 2;
    const unsigned char head[18] = {
        0, has_map, kind, 0, 0, has_map ? 4 : 0, 0,         has_map ? bits : 0, 0, 0, 0,
        0, width,   0,    2, 0, pixel,           attributes};
    byte_list list = {.size = 0};
    append(&list, head, sizeof head);
    for (size_t i = 0; i < 4 && has_map; i++)
        append_pixel(&list, four_pixels[i], alpha, masks, bits / 8);
    for (size_t i = 0; i < 4; i++) {
        const unsigned char stored =
            (unsigned char)(i ^ (attributes & 32 ? 0 : 2) ^ (attributes & 16 ? 1 : 0));
        if (kind >= 9 && i % 2 == 0)
            append(&list, (unsigned char[]){width - 1}, 1);
        if (has_map)
            append(&list, &stored, 1);
        else
            append_pixel(&list, four_pixels[stored], alpha, masks, bits / 8);
    }
    return test_folder_write(folder, "made.tga", list.bytes, list.size, 0600);
}

static void a_tga_is_read_in_each_of_its_forms(void **state)
{
    static const unsigned char kinds[] = {1, 2, 9, 10}, depths[] = {16, 24, 32};
    for (size_t i = 0; i < 4 * 3 * 4; i++) {
        const unsigned char attributes = (unsigned char)(i % 4 << 4), bits = depths[i / 4 % 3];
        check_four_pixels(write_tga(*state, kinds[i / 12], bits, attributes, 0),
                          bits == 16 ? 4.2 : 0.51);
    }
}

static void a_fourth_byte_of_a_tga_is_alpha_if_its_header_says_so(void **state)
{
    for (unsigned char kind = 2; kind <= 10; kind += 8) {
        rk_check_close(opacity_of(write_tga(*state, kind, 32, 8, 51)), 0.2, 1e-6, "8 bits");
        rk_check_close(opacity_of(write_tga(*state, kind, 32, 8, 0)), -1, 0, "0 everywhere");
        rk_check_close(opacity_of(write_tga(*state, kind, 32, 0, 51)), -1, 0, "no bits");
        rk_check_close(opacity_of(write_tga(*state, kind, 32, 32, 0)), -1, 0,
                       "no bits, at the top");
    }
}

static void a_tga_whose_colour_map_does_not_begin_with_0_is_refused(void **state)
{
    static const unsigned char head[18] = {[1] = 1, 1, 1, [5] = 2, [7] = 24, [12] = 2, 0, 1, 0, 8};
    byte_list list = {.size = 0};
    rk_image image;
    rk_error error;
    append(&list, head, sizeof head);
    append(&list, four_pixels, 6);
    append(&list, "\1\2", 2);
    const test_path path = test_folder_write(*state, "first.tga", list.bytes, list.size, 0600);
    rk_check(!rk_image_file_read(&image, path.text, &error), "it was read");
    rk_check_error_names(error, "has a colour map that begins with number 1");
    rk_check_remedy(error.text);
}

static const struct CMUnitTest tests[] = {
    test_in_folder(the_masks_of_a_bitmap_say_where_its_colours_are),
    test_in_folder(a_fourth_byte_of_a_bitmap_is_alpha_if_its_header_says_so),
    test_in_folder(a_tga_is_read_in_each_of_its_forms),
    test_in_folder(a_fourth_byte_of_a_tga_is_alpha_if_its_header_says_so),
    test_in_folder(a_tga_whose_colour_map_does_not_begin_with_0_is_refused),
};

RK_SUITE_IN("image_bitmaps", tests, NULL, end_reader)
