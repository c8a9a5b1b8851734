/* Pictures in formats other than PNG, through the real helper and through fake ones.
 *
 * Each start of the real helper loads OpenImageIO with its 260 libraries, a quarter of a second or
 * more, so tests share one where their claim allows. */
#include "test.h"

#include "byte_list.h"
#include "remedy.h"
#include "test_picture_file.h"

#include "base/random.h"
#include "io/helper.h"
#include "io/helper_answer.h"
#include "io/image_file.h"
#include "io/image_stream.h"

#include <signal.h>
#include <sys/wait.h>
#include <time.h>

/* Replaces the archive's own function, so that a test can hide the helper. */
static const char *helper_folder = RK_BUILD_FOLDER;

const char *rk_helper_folder(void)
{
    return helper_folder;
}

/* The suite's own, for claims about what is read and not about starting. */
static rk_image_file_reader reader;

static int end_reader(void **state)
{
    (void)state;
    rk_image_file_reader_end(&reader);
    return 0;
}

static bool read_shared(rk_image *image, test_path path, rk_error *error)
{
    const rk_image_file_wish wish = {.most_pixels = RK_IMAGE_PIXELS_MAX, .reader = &reader};
    return rk_image_file_read_wished(image, path.text, &wish, error);
}

static rk_image make_noise(size_t width, size_t height)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    for (uint32_t i = 0; i < width * height; i++)
        image.pixels[i] =
            rk_vec(rk_unit_float(rk_hash(5, i, 0, 0)), rk_unit_float(rk_hash(5, i, 1, 0)),
                   rk_unit_float(rk_hash(5, i, 2, 0)));
    return image;
}

static rk_image make_constant(size_t width, size_t height, rk_vec3 colour)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    for (size_t i = 0; i < width * height; i++)
        image.pixels[i] = colour;
    return image;
}

static test_path write_image(const test_folder *folder, const char *name, const rk_image *image)
{
    test_path path = test_folder_path(folder, name);
    rk_error error;
    rk_check_ok(rk_image_file_write(path.text, image, &error), error);
    return path;
}

static rk_image read_image(test_path path)
{
    rk_image image;
    rk_error error;
    rk_check_ok(read_shared(&image, path, &error), error);
    return image;
}

static void check_refused(test_path path, const char *part)
{
    rk_image image;
    rk_error error;
    rk_check(!read_shared(&image, path, &error), "%s was accepted", path.text);
    rk_check(!image.pixels, "%s: pixels were left behind", path.text);
    rk_check_error_names(error, path.text);
    rk_check_error_names(error, part);
    rk_check_remedy(error.text);
}

/* --- there and back -------------------------------------------------------------------------- */

static void exr_keeps_every_bit_of_every_float(void **state)
{
    rk_image image = make_noise(13, 7);
    image.pixels[0] = rk_vec(-0.0f, 1e-45f, -1e-38f);
    image.pixels[90] = rk_vec(3.4e38f, -3.4e38f, 1e6f);
    rk_image back = read_image(write_image(*state, "noise.EXR", &image));
    rk_check_equal(back.width, 13, "the width is kept");
    rk_check_equal(back.height, 7, "the height is kept");
    rk_check(memcmp(back.pixels, image.pixels, 13 * 7 * sizeof(rk_vec3)) == 0,
             "32-bit floats without loss should come back as they were");
    rk_check_equal(test_folder_count(*state), 1, "no temporary file may be left");
    rk_image_free(&image);
    rk_image_free(&back);
}

static void the_same_picture_gives_the_same_exr(void **state)
{
    rk_image image = make_noise(5, 5);
    size_t size_a, size_b;
    unsigned char *a = test_folder_read(write_image(*state, "a.exr", &image), &size_a);
    /* The date in an EXR counts seconds, so wait for the next one. */
    for (time_t now = time(NULL); time(NULL) == now;)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    unsigned char *b = test_folder_read(write_image(*state, "b.exr", &image), &size_b);
    rk_check(size_a == size_b && memcmp(a, b, size_a) == 0, "a date or a name is in the file");
    free(a);
    free(b);
    rk_image_free(&image);
}

static void float_tiff_is_linear_and_exact(void **state)
{
    rk_image image = make_noise(6, 5);
    image.pixels[7] = rk_vec(-2, 1e20f, 0.5f);
    rk_image back = read_image(write_by_helper(*state, "noise.tif", &image));
    rk_check(memcmp(back.pixels, image.pixels, 6 * 5 * sizeof(rk_vec3)) == 0,
             "floats in a TIFF should come back as they were");
    rk_image_free(&image);
    rk_image_free(&back);
}

static void hdr_keeps_a_hundredth_of_the_brightest_channel(void **state)
{
    rk_image image = make_noise(40, 30);
    for (int i = 0; i < 40 * 30; i += 3)
        image.pixels[i] = rk_scale(image.pixels[i], 1e4f);
    rk_image back = read_image(write_by_helper(*state, "noise.hdr", &image));
    for (size_t i = 0; i < 40 * 30; i++) {
        rk_vec3 v = image.pixels[i];
        /* RGBE: three mantissas of 8 bits have the exponent of the largest, whose mantissa is at
         * least 128, and the last bit is truncated. */
        float step = rk_max(v.x, rk_max(v.y, v.z)) / 128;
        for (int c = 0; c < 3; c++)
            rk_check_close(rk_axis(back.pixels[i], c), rk_axis(v, c), step,
                           "linear, in steps of RGBE");
    }
    rk_image_free(&image);
    rk_image_free(&back);
}

/* A Portable Float Map of one pixel, little-endian like the machines that these tests know. */
static void a_portable_float_map_is_linear(void **state)
{
    const float colour[] = {0.5f, 0.25f, 3};
    const char head[] = "PF\n1 1\n-1.0\n";
    unsigned char bytes[sizeof head - 1 + sizeof colour];
    memcpy(bytes, head, sizeof head - 1);
    memcpy(bytes + sizeof head - 1, colour, sizeof colour);
    rk_image image = read_image(test_folder_write(*state, "probe.pfm", bytes, sizeof bytes, 0600));
    for (int c = 0; c < 3; c++)
        rk_check_close(rk_axis(image.pixels[0], c), colour[c], 0, "floats are stored as they are");
    rk_image_free(&image);
}

/* As of a picture within a mesh file; the smallest ones have fewer bytes than other formats' heads.
 */
static void the_first_bytes_name_the_format(void **state)
{
    static const char red[] = "P6\n1 1\n255\n\xff\0";
    const char *names[] = {"none", "lies.tga", "lies.jpg"};
    for (int i = 0; i < 3; i++) {
        rk_image image =
            read_image(test_folder_write(*state, names[i], red, sizeof red, 0600)); /* 3 values */
        rk_check_close(image.pixels[0].x, 1, 0, "red");
        rk_check_close(image.pixels[0].z, 0, 0, "blue");
        rk_image_free(&image);
    }
}

static void append_attribute(byte_list *list, const char *name, const char *type, const void *value,
                             uint32_t size)
{
    append(list, name, strlen(name) + 1);
    append(list, type, strlen(type) + 1);
    append(list, &size, sizeof size);
    append(list, value, size);
}

/* An OpenEXR file of floats, uncompressed ("OpenEXR File Layout"), with the name of its colour
 * space. `names`: of its channels, each followed by a blank. A window has its first column and row,
 * and its last. */
static test_path write_exr(const test_folder *folder, const char *names, const char *space,
                           const uint32_t *data, const uint32_t *display, const float *values)
{
    byte_list channels = {.size = 0};
    uint32_t size = 0;
    const uint32_t width = data[2] - data[0] + 1, height = data[3] - data[1] + 1, version = 2;
    for (const char *name = names; *name; name = strchr(name, ' ') + 1) {
        append(&channels, name, (size_t)(strchr(name, ' ') - name));
        append(&channels, "\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0", 17);
        size += width * (uint32_t)sizeof *values;
    }
    append(&channels, "", 1);
    const float one = 1, centre[2] = {0};
    byte_list list = {.size = 0};
    append(&list, "\x76\x2f\x31\x01", 4);
    append(&list, &version, sizeof version);
    append_attribute(&list, "channels", "chlist", channels.bytes, (uint32_t)channels.size);
    append_attribute(&list, "compression", "compression", "", 1);
    append_attribute(&list, "dataWindow", "box2i", data, 4 * sizeof *data);
    append_attribute(&list, "displayWindow", "box2i", display, 4 * sizeof *display);
    append_attribute(&list, "lineOrder", "lineOrder", "", 1);
    append_attribute(&list, "oiio:ColorSpace", "string", space, (uint32_t)strlen(space));
    append_attribute(&list, "pixelAspectRatio", "float", &one, sizeof one);
    append_attribute(&list, "screenWindowCenter", "v2f", centre, sizeof centre);
    append_attribute(&list, "screenWindowWidth", "float", &one, sizeof one);
    append(&list, "", 1);
    const uint64_t rows = list.size + height * sizeof rows;
    for (uint32_t y = 0; y < height; y++)
        append(&list, &(uint64_t){rows + y * (8 + size)}, sizeof rows);
    for (uint32_t y = 0; y < height; y++) {
        append(&list, &(uint32_t){data[1] + y}, sizeof y);
        append(&list, &size, sizeof size);
        append(&list, (const char *)values + y * size, size);
    }
    return test_folder_write(folder, "made.exr", list.bytes, list.size, 0600);
}

static test_path write_small_exr(const test_folder *folder, const char *names, const char *space,
                                 const float *values)
{
    static const uint32_t pixel[4] = {0};
    return write_exr(folder, names, space, pixel, pixel, values);
}

static void floats_are_decoded_only_if_their_file_names_a_curve(void **state)
{
    const struct {
        const char *space;
        double want;
    } spaces[] = {{"lin_srgb", 0.5}, {"lin_rec709", 0.5}, {"Rec709", 0.5}, {"sRGB", 0.21404114}};
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++) {
        rk_image image =
            read_image(write_small_exr(*state, "Y ", spaces[i].space, (float[]){0.5f}));
        rk_check_near(image.pixels[0].x, spaces[i].want, 1e-7, "0.5 stored in the space %s",
                      spaces[i].space);
        rk_image_free(&image);
    }
}

/* As Blender and other renderers save them. */
static void an_exr_whose_colours_are_in_layers_names_the_first(void **state)
{
    static const float values[] = {1, 2, 3, 4, 5, 6, 7};
    check_refused(write_small_exr(*state, "a.Z key.light.B key.light.G key.light.R z.B z.G z.R ",
                                  "lin_srgb", values),
                  ": has its colours in layers (the first: key.light), and no R, G and B outside");
    rk_image image =
        read_image(write_small_exr(*state, "A.B A.G A.R B G R x.R ", "lin_srgb", values));
    for (int c = 0; c < 3; c++)
        rk_check_close(rk_axis(image.pixels[0], c), 6 - c, 0, "those outside");
    rk_image_free(&image);
}

/* As of layers and crops, whose files hold only a part of the picture, or more than it. */
static void an_exr_shows_what_is_in_its_display_window(void **state)
{
    static const uint32_t display[4] = {-1u, 0, 2, 1};
    static const struct {
        uint32_t data[4];
        float want[8];
    } cases[] = {{{1, 1, 2, 1}, {0, 0, 0, 0, 0, 0, 1, 2}},
                 {{2, -1u, 3, 1}, {0, 0, 0, 3, 0, 0, 0, 5}},
                 {{0, 0, 3, 1}, {0, 1, 2, 3, 0, 5, 6, 7}},
                 {{3, 0, 4, 0}, {0}}};
    static const float values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const test_path path = write_exr(*state, "Y ", "lin_srgb", cases[i].data, display, values);
        rk_image image = read_image(path);
        rk_check_equal(image.width, 4, "columns");
        rk_check_equal(image.height, 2, "rows");
        for (size_t k = 0; k < 8; k++)
            rk_check_near(image.pixels[k].y, cases[i].want[k], 0, "case %zu, pixel %zu", i, k);
        rk_image_free(&image);
    }
}

static void an_exr_is_transparent_outside_its_data(void **state)
{
    static const uint32_t display[4] = {0, 0, 1, 0}, data[4] = {1, 0, 1, 0};
    const test_path path =
        write_exr(*state, "A B G R ", "lin_srgb", data, display, (float[]){1, 1, 1, 1});
    const rk_image_file_wish wish = {.most_pixels = RK_IMAGE_PIXELS_MAX, .reader = &reader};
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_file_read_opacity(&image, path.text, &wish, true, &error), error);
    rk_check_equal(image.width, 2, "columns");
    rk_check_close(image.pixels[0].x, 0, 0, "outside");
    rk_check_close(image.pixels[1].x, 1, 0, "inside");
    rk_image_free(&image);
}

static void an_exr_with_a_display_window_too_large_is_refused(void **state)
{
    static const uint32_t display[4] = {0, 0, 0xfffff, 0}, pixel[4] = {0};
    check_refused(write_exr(*state, "Y ", "lin_srgb", pixel, display, (float[]){1}),
                  ": claims 1048576 x 1 pixels");
}

static void jpeg_is_srgb_encoded(void **state)
{
    rk_vec3 colour = rk_vec(0.5f, 0.02f, 0.2f);
    rk_image image = make_constant(16, 16, colour);
    rk_image back = read_image(write_by_helper(*state, "plain.jpg", &image));
    for (int c = 0; c < 3; c++)
        /* A picture of one colour survives the cosine transform; colours go through 8 bits twice,
         * as RGB and as YCbCr: each at most half a step, 1.772 wide for blue. */
        rk_check_close(255 * rk_srgb_encode(rk_axis(back.pixels[100], c)),
                       255 * rk_srgb_encode(rk_axis(colour, c)), 2.5, "stored sRGB-encoded");
    rk_image_free(&image);
    rk_image_free(&back);
}

/* --- integers, byte by byte ------------------------------------------------------------------ */

/* Writes an uncompressed TIFF 6.0 file, little-endian, all samples in one strip; `extra` is 0 or 2
 * (the last sample is an unassociated alpha), `orientation` 1 to 8. */
static test_path write_tiff(const test_folder *folder, uint16_t width, uint16_t height,
                            uint16_t bits, uint16_t samples, uint16_t orientation,
                            const void *pixels)
{
    bool rgb = samples >= 3, alpha = samples == 2 || samples == 4;
    enum { entries = 11, data = 8 + 2 + entries * 12 + 4, strip = data + 8 };
    uint16_t size = (uint16_t)(width * height * samples * bits / 8);
    const uint16_t tags[entries][4] = {{256, 3, 1, width},
                                       {257, 3, 1, height},
                                       {258, 3, samples, samples > 2 ? data : bits},
                                       {259, 3, 1, 1},
                                       {262, 3, 1, rgb ? 2 : 1},
                                       {273, 3, 1, strip},
                                       {274, 3, 1, orientation},
                                       {277, 3, 1, samples},
                                       {278, 3, 1, height},
                                       {279, 3, 1, size},
                                       {338, 3, 1, 2}};
    uint16_t count = alpha ? entries : entries - 1;
    unsigned char bytes[strip + 256] = {'I', 'I', 42, 0, 8, 0, 0, 0, (unsigned char)count};
    rk_check(size <= 256, "the test's own picture is too large");
    for (int i = 0; i < count; i++) {
        const uint16_t words[6] = {tags[i][0], tags[i][1], tags[i][2], 0, tags[i][3], 0};
        for (int k = 0; k < 6; k++) {
            bytes[10 + 12 * i + 2 * k] = (unsigned char)(words[k] & 255);
            bytes[10 + 12 * i + 2 * k + 1] = (unsigned char)(words[k] >> 8);
        }
    }
    for (int i = 0; i < 4; i++)
        bytes[data + 2 * i] = (unsigned char)bits;
    memcpy(bytes + strip, pixels, size);
    return test_folder_write(folder, "made.tif", bytes, strip + (size_t)size, 0600);
}

/* The linear value of 128 / 255 stored, by IEC 61966-2-1. */
static const double half = 0.21586050011389926;

static void eight_bit_grey_is_decoded_and_replicated(void **state)
{
    rk_image image = read_image(write_tiff(*state, 3, 1, 8, 1, 1, (unsigned char[]){0, 128, 255}));
    const double want[] = {0, half, 1};
    for (size_t x = 0; x < 3; x++)
        for (int c = 0; c < 3; c++)
            rk_check_close(rk_axis(image.pixels[x], c), want[x], 1e-7, "one rounding to float");
    rk_image_free(&image);
}

static void sixteen_bits_are_decoded_and_alpha_is_dropped(void **state)
{
    /* 0x8080 is 128 / 255 exactly; the alphas are a fourth and zero. */
    const unsigned char pixels[] = {0x80, 0x80, 0xff, 0xff, 1, 0, 0, 0x40,
                                    0xff, 0xff, 0x80, 0x80, 0, 0, 0, 0};
    rk_image image = read_image(write_tiff(*state, 2, 1, 16, 4, 1, pixels));
    rk_check_close(image.pixels[0].x, half, 1e-7, "one rounding to float");
    rk_check_close(image.pixels[0].y, 1, 0, "not darkened by its alpha");
    rk_check_close(image.pixels[0].z, 1 / 65535.0 / 12.92, 1e-12, "8 bits would lose it");
    rk_check_close(image.pixels[1].x, 1, 0, "colour stays where alpha is 0");
    rk_check_close(image.pixels[1].y, half, 1e-7, "one rounding to float");
    rk_image_free(&image);
}

/* The picture 0 1 2 / 3 4 5 in steps of a 51st, as the file stores it in each orientation:
 * TIFF 6.0, page 36. */
static void photos_in_all_orientations_are_turned_upright(void **state)
{
    static const unsigned char stored[8][6] = {
        {0, 1, 2, 3, 4, 5}, {2, 1, 0, 5, 4, 3}, {5, 4, 3, 2, 1, 0}, {3, 4, 5, 0, 1, 2},
        {0, 3, 1, 4, 2, 5}, {2, 5, 1, 4, 0, 3}, {5, 2, 4, 1, 3, 0}, {3, 0, 4, 1, 5, 2}};
    for (uint16_t i = 0; i < 8; i++) {
        unsigned char pixels[6];
        for (int k = 0; k < 6; k++)
            pixels[k] = (unsigned char)(51 * stored[i][k]);
        const uint16_t width = i < 4 ? 3 : 2;
        rk_image image = read_image(write_tiff(*state, width, 5 - width, 8, 1, i + 1, pixels));
        rk_check_equal(image.width, 3, "width");
        rk_check_equal(image.height, 2, "height");
        for (int k = 0; k < 6; k++)
            rk_check_close(255 * rk_srgb_encode(image.pixels[k].x), 51 * k, 0.01, "turned upright");
        rk_image_free(&image);
    }
}

/* The format's manual: values are those of the scene times the exposure. */
static void the_exposure_of_an_hdr_is_taken_back(void **state)
{
    static const char *const lines[] = {"", "EXPOSURE=4\n", "EXPOSURE= 0.5\n", "EXPOSURE=0\n",
                                        "EXPOSURE=4\nEXPOSURE=2\n"};
    static const double want[] = {1, 0.25, 2, 1, 0.125};
    for (int i = 0; i < 5; i++) {
        char text[200];
        snprintf(text, sizeof text, "#?RADIANCE\n%sFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n%s",
                 lines[i], "\x80\x80\x80\x81");
        rk_image image = read_image(test_folder_write(*state, "e.hdr", text, strlen(text), 0600));
        rk_check_close(image.pixels[0].y, want[i], 0.01, "divided by it");
        rk_image_free(&image);
    }
}

/* A red and three green pixels: as runs of 4 bytes, as channels, and flat. */
static void an_hdr_that_is_not_read_has_its_reason(void **state)
{
    static const struct {
        const char *format, *rows, *what;
        size_t size;
    } files[] = {
        {"32-bit_rle_rgbe", "\x80\0\0\x81\0\x80\0\x81\1\1\1\2", "old run-length encoding", 12},
        {"32-bit_rle_rgbe", "\x80\0\0\x81\0\x80\0\x81\1\1\1\1\0\x80\0\x81",
         "old run-length encoding", 16},
        {"32-bit_rle_xyze", "\x80\0\0\x81\0\x80\0\x81\0\x80\0\x81\0\x80\0\x81", "colours in XYZ",
         16},
        {"32-bit_rle_rgbe", "\x80\0\0\x81\0\x80\0\x81\0\x80\0\x81\0\x80\0\x81", NULL, 16},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char bytes[200];
        const int head =
            snprintf(bytes, sizeof bytes, "#?RADIANCE\nFORMAT=%s\n\n-Y 1 +X 4\n", files[i].format);
        memcpy(bytes + head, files[i].rows, files[i].size);
        const test_path path =
            test_folder_write(*state, "old.hdr", bytes, (size_t)head + files[i].size, 0600);
        if (files[i].what) {
            check_refused(path, files[i].what);
            continue;
        }
        rk_image image = read_image(path);
        rk_check_close(image.pixels[0].x, 1, 0.01, "red");
        rk_check_close(image.pixels[3].y, 1, 0.01, "green");
        rk_image_free(&image);
    }
}

/* --- broken files ---------------------------------------------------------------------------- */

/* A cube whose faces are of 2 x 2 pixels and of 1 x 1, of half floats ("DDS_HEADER_DXT10"). */
static test_path write_dds(const test_folder *folder, uint32_t format, size_t lost)
{
    enum { head = 148, face = 5 * 8 };
    static const uint16_t halves[6] = {0x3c00, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600}; /* 1 to 6 */
    unsigned char bytes[head + 6 * face] = "DDS ";
    const uint32_t words[][2] = {
        {1, 124},         {2, 0x21007},   {3, 2},       {4, 2},       {7, 2},  {19, 32}, {20, 4},
        {21, 0x30315844}, {27, 0x401008}, {28, 0xfe00}, {32, format}, {33, 3}, {34, 4},  {35, 1}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        put_word(bytes, (int)words[i][0], words[i][1]);
    for (size_t i = 0; i < 6 * 5 * 4; i++) {
        const bool is_small = i / 4 % 5 == 4;
        const uint16_t value = is_small || i % 4 == 1 ? 0 : halves[i / 20];
        bytes[head + 2 * i] = (unsigned char)value;
        bytes[head + 2 * i + 1] = (unsigned char)(value >> 8);
    }
    return test_folder_write(folder, "cube.dds", bytes, sizeof bytes - lost, 0600);
}

static void a_dds_of_half_floats_is_read_face_by_face(void **state)
{
    rk_image image = read_image(write_dds(*state, 10, 0));
    rk_check(image.width == 2 && image.height == 12, "six faces, one below the other");
    for (size_t i = 0; i < 24; i++) {
        rk_check_near(image.pixels[i].x, (double)(i / 4 + 1), 0, "red of pixel %zu", i);
        rk_check_near(image.pixels[i].y, 0, 0, "green of pixel %zu", i);
    }
    rk_image_free(&image);
    check_refused(write_dds(*state, 10, 9), "ends too early");
}

static void a_format_that_is_not_read_has_its_reason(void **state)
{
    check_refused(write_dds(*state, 26, 0), "is a DDS picture of a kind that is not read; convert");
    check_refused(test_folder_write(*state, "a.ktx2", "\253KTX 20\273\r\n\032\n", 12, 0600),
                  "has a format that OpenImageIO does not read; convert it to PNG, HDR or EXR");
}

static void a_pixel_that_is_not_a_number_is_named(void **state)
{
    rk_image image = make_noise(4, 3);
    rk_image_at(&image, 1, 2)->y = NAN;
    rk_image_at(&image, 3, 2)->y = INFINITY;
    test_path path = write_image(*state, "nan.exr", &image);
    check_refused(path, "x 1, y 2");
    rk_image_free(&image);
}

static void check_broken_kind(const test_folder *folder, const char *name)
{
    rk_image image = make_noise(48, 40);
    size_t size;
    unsigned char *bytes = test_folder_read(write_by_helper(folder, name, &image), &size);
    rk_image_free(&image);
    check_refused(test_folder_write(folder, name, bytes, size * 3 / 5, 0600), "; save or download");
    /* Damage in the middle may stay unnoticed, but must not be worse than an error. */
    for (size_t i = size / 2; i < size / 2 + 40; i++)
        bytes[i] ^= 0x5a;
    test_path path = test_folder_write(folder, name, bytes, size, 0600);
    free(bytes);
    rk_error error;
    if (read_shared(&image, path, &error))
        rk_image_free(&image);
    else
        rk_check_error_names(error, name);
}

static void a_broken_jpeg_is_refused(void **state)
{
    check_broken_kind(*state, "broken.jpg");
}

static void a_broken_tiff_is_refused(void **state)
{
    check_broken_kind(*state, "broken.tif");
}

static void a_broken_exr_is_refused(void **state)
{
    check_broken_kind(*state, "broken.exr");
}

static void a_broken_hdr_is_refused(void **state)
{
    check_broken_kind(*state, "broken.hdr");
}

static void missing_empty_and_foreign_files_are_refused(void **state)
{
    check_refused(test_folder_path(*state, "none.jpg"), "No such file");
    check_refused(test_folder_write(*state, "empty.exr", "", 0, 0600), "");
    check_refused(test_folder_write(*state, "text.hdr", "hello\n", 6, 0600), "");
}

static void folders_pipes_and_devices_are_refused_at_once(void **state)
{
    const test_folder *folder = *state;
    const char *const names[] = {"pipe.jpg", "pipe.png", "pipe"};
    for (int i = 0; i < 3; i++) {
        test_path pipe = test_folder_path(folder, names[i]);
        rk_check(mkfifo(pipe.text, 0600) == 0, "a pipe can be made");
        check_refused(pipe, "is not a regular file");
    }
    test_path endless = {"/dev/zero"};
    check_refused(endless, "is not a regular file");
    test_path below = test_folder_path(folder, "below.exr");
    rk_check(mkdir(below.text, 0700) == 0, "a folder can be made");
    check_refused(below, "is a folder");
}

/* OpenImageIO's reader gives no reason. */
static void a_fault_without_a_reason_is_still_a_sentence(void **state)
{
    const char text[] = "PF\n4 4\n-1.0\nabc";
    check_refused(test_folder_write(*state, "x.pfm", text, sizeof text - 1, 0600),
                  "x.pfm: is damaged; save or download it again");
}

/* The same for formats that the helper reads and for PNG. */
static void a_pointer_of_git_lfs_is_no_picture(void **state)
{
    static const char text[] = "version https://git-lfs.github.com/spec/v1\n"
                               "oid sha256:0123456789abcdef\nsize 12345\n";
    static const char *const names[] = {"a.jpg", "a.exr", "a.hdr", "a.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_refused(test_folder_write(*state, names[i], text, sizeof text - 1, 0600),
                      ": is a Git LFS pointer, not the file: run git lfs pull");
}

static void a_web_page_is_no_picture(void **state)
{
    static const char text[] = "<!DOCTYPE html>\n<html><body>404</body></html>\n";
    static const char *const names[] = {"a.jpg", "a.exr", "a.hdr", "a.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_refused(test_folder_write(*state, names[i], text, sizeof text - 1, 0600),
                      ": is a web page, not the file");
}

static void absurd_sizes_are_refused(void **state)
{
    const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n";
    check_refused(test_folder_write(*state, "huge.hdr", head, sizeof head - 1, 0600), "1 to 32768");
    const char wide[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32768 +X 32768\n";
    test_path path = test_folder_write(*state, "wide.hdr", wide, sizeof wide - 1, 0600);
    check_refused(path, "");
    rk_image image;
    rk_error error = {""};
    const rk_image_file_wish wish = {.most_pixels = 1 << 20, .reader = &reader};
    rk_check(!rk_image_file_read_wished(&image, path.text, &wish, &error), "it was accepted");
    rk_check_error_names(error, "32768 x 32768 pixels, more than the 1048576 allowed");
}

/* --- places and endings ---------------------------------------------------------------------- */

static void an_exr_into_a_missing_folder_is_an_error(void **state)
{
    rk_image image = make_noise(2, 2);
    test_path path = test_folder_path(*state, "none/a.exr");
    rk_error error;
    rk_check(!rk_image_file_write(path.text, &image, &error), "%s was written", path.text);
    rk_check_error_names(error, path.text);
    rk_image_free(&image);
}

static void an_exr_goes_where_its_link_points(void **state)
{
    rk_image image = make_noise(2, 2);
    test_path link = test_folder_path(*state, "link.exr"),
              target = test_folder_path(*state, "to.exr");
    rk_check(symlink("to.exr", link.text) == 0, "a link can be made");
    write_image(*state, "link.exr", &image);
    struct stat status;
    rk_check(lstat(link.text, &status) == 0 && S_ISLNK(status.st_mode), "the link was replaced");
    rk_check(stat(target.text, &status) == 0 && status.st_size > 0, "there is no picture");
    rk_image_free(&image);
}

static void a_picture_without_pixels_is_not_written(void **state)
{
    const rk_image none[] = {{0}, {.width = 3}, {.height = 3}, {.width = 32769, .height = 1}};
    const char *const names[] = {"none.png", "none.exr"};
    for (int i = 0; i < 8; i++) {
        test_path path = test_folder_path(*state, names[i % 2]);
        rk_error error = {""};
        rk_check(!rk_image_file_write(path.text, &none[i / 2], &error), "%s was written",
                 path.text);
        rk_check_error_names(error, path.text);
        rk_check_error_names(error, "make each side 1 to 32768");
    }
    rk_check_equal(test_folder_count(*state), 0, "nothing is written");
}

static pid_t start_writing(test_path input, test_path output)
{
    test_path program;
    snprintf(program.text, sizeof program.text, "%s/raykit-image", RK_BUILD_FOLDER);
    pid_t child = fork();
    if (child == 0) {
        signal(SIGINT, SIG_DFL); /* ignored in a script's background */
        if (freopen(input.text, "rb", stdin))
            execl(program.text, program.text, "write", output.text, (char *)NULL);
        _exit(127);
    }
    return child;
}

static void an_interrupted_exr_leaves_nothing(void **state)
{
    /* Large enough to take about a second, so that the temporary file is seen before it is
     * complete. */
    rk_image image = make_noise(2048, 2048);
    size_t bytes;
    unsigned char *stream = stream_of(&image, &bytes);
    rk_image_free(&image);
    test_path input = test_folder_write(*state, "input", stream, bytes, 0600);
    free(stream);
    pid_t child = start_writing(input, test_folder_path(*state, "a.exr"));
    int status = 0;
    pid_t ended = 0;
    while (test_folder_count(*state) < 2 && (ended = waitpid(child, &status, WNOHANG)) == 0)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    rk_check(ended == 0, "the helper ended before it wrote: status %d", status);
    rk_check(kill(child, SIGINT) == 0 && waitpid(child, &status, 0) == child, "it is interrupted");
    rk_check(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT, "SIGINT ends it: status %d",
             status);
    rk_check_equal(test_folder_count(*state), 1, "nothing but the input");
}

static void other_endings_are_not_written(void **state)
{
    rk_image image = make_noise(2, 2);
    const char *names[] = {"a.jpg", "a", ".png", "exr", "a.exr.bak"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rk_error error;
        rk_check(!rk_image_file_write(names[i], &image, &error), "%s was written", names[i]);
        rk_check_error_names(error, ".exr");
        rk_check(!rk_image_file_can_write(names[i], &error), "%s could be written", names[i]);
        rk_check_error_names(error, names[i]);
    }
    rk_error error;
    rk_check(rk_image_file_can_write("a.PNG", &error) && rk_image_file_can_write("b.exr", &error),
             "these are written: %s", error.text);
    rk_check_equal(test_folder_count(*state), 0, "nothing is written");
    rk_image_free(&image);
}

/* --- fake helpers ---------------------------------------------------------------------------- */

/* From here until the end of the test, only the test's folder is searched for helpers. */
static void use_helpers_of(const test_folder *folder)
{
    rk_image_file_reader_end(&reader);
    setenv("RAYKIT_HELPERS", folder->path, 1);
    helper_folder = folder->path;
}

static char *named_folder; /* RAYKIT_HELPERS as it was */

static int setup_false(void **state)
{
    const char *named = getenv("RAYKIT_HELPERS");
    named_folder = named ? strdup(named) : NULL;
    return test_folder_setup(state);
}

static int teardown_false(void **state)
{
    if (named_folder)
        setenv("RAYKIT_HELPERS", named_folder, 1);
    else
        unsetenv("RAYKIT_HELPERS");
    free(named_folder);
    helper_folder = RK_BUILD_FOLDER;
    rk_image_file_reader_end(&reader);
    return test_folder_teardown(state);
}

#define test_with_false_helper(name)                                                               \
    cmocka_unit_test_setup_teardown(name, setup_false, teardown_false)

/* A helper that takes a request, always gives this answer, and ends. */
static void install_answer(const test_folder *folder, const void *bytes, size_t size)
{
    rk_image_file_reader_end(&reader);
    unsigned char *whole = malloc(sizeof(rk_helper_answer) + size);
    rk_check(whole, "no memory");
    memcpy(whole, &(rk_helper_answer){.size = size}, sizeof(rk_helper_answer));
    memcpy(whole + sizeof(rk_helper_answer), bytes, size);
    test_path answer =
        test_folder_write(folder, "answer", whole, sizeof(rk_helper_answer) + size, 0600);
    free(whole);
    char script[1000];
    int length =
        snprintf(script, sizeof script, "#!/bin/sh\nhead -c 1 >'%s.asked'\nexec cat '%s'\n",
                 answer.text, answer.text);
    test_folder_write(folder, "raykit-image", script, (size_t)length, 0700);
}

static void a_missing_helper_names_the_package_but_png_needs_none(void **state)
{
    use_helpers_of(*state);
    rk_image image = make_noise(2, 2);
    rk_error error;
    check_refused(test_folder_path(*state, "a.jpg"), "libopenimageio-dev");
    rk_check(!rk_image_file_write("a.exr", &image, &error), "an EXR was written without a helper");
    rk_check_error_names(error, "libopenimageio-dev");
    rk_image back = read_image(write_image(*state, "a.PNG", &image));
    rk_image_free(&back);
    rk_image_free(&image);
}

static void invalid_answers_are_refused(void **state)
{
    use_helpers_of(*state);
    typedef struct answer {
        rk_image_stream_head head;
        float pixels[6];
    } answer;
    const answer valid = {{RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 2, 1},
                          {1, 2, 3, 4, 5, 6}};
    const rk_image_stream_head heads[] = {
        {RK_IMAGE_STREAM_MAGIC + 1, RK_IMAGE_STREAM_VERSION, 2, 1},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION + 1, 2, 1},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 1, 1},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 2, 2},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 0, 1},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 2, 0},
        {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION, 40000, 1}};
    test_path path = test_folder_path(*state, "a.exr");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        answer broken = valid;
        broken.head = heads[i];
        install_answer(*state, &broken, sizeof broken);
        check_refused(path, "invalid answer");
    }
    const size_t sizes[] = {0, 1, sizeof valid.head, sizeof valid - 1};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        install_answer(*state, &valid, sizes[i]);
        check_refused(path, "invalid answer");
    }
    answer infinite = valid;
    infinite.pixels[4] = INFINITY;
    install_answer(*state, &infinite, sizeof infinite);
    check_refused(path, "x 1, y 0");
    install_answer(*state, &valid, sizeof valid);
    rk_image image = read_image(path);
    rk_check_close(image.pixels[1].z, 6, 0, "the valid answer is accepted");
    rk_image_free(&image);
}

static void a_helper_that_dies_is_an_error_with_the_files_name(void **state)
{
    use_helpers_of(*state);
    const char script[] = "#!/bin/sh\nkill -SEGV $$\n";
    test_folder_write(*state, "raykit-image", script, sizeof script - 1, 0700);
    check_refused(test_folder_path(*state, "a.exr"), "signal");
}

/* --- one start for several pictures ---------------------------------------------------------- */

/* A helper that counts its starts, and is the real one. */
static void count_starts(const test_folder *folder)
{
    char script[2 * sizeof(test_path) + 100];
    int length = snprintf(script, sizeof script,
                          "#!/bin/sh\necho >>'%s/starts'\nexec '%s/raykit-image' \"$@\"\n",
                          folder->path, RK_BUILD_FOLDER);
    test_folder_write(folder, "raykit-image", script, (size_t)length, 0700);
    use_helpers_of(folder);
}

static size_t starts(const test_folder *folder)
{
    size_t size = 0;
    free(test_folder_read(test_folder_path(folder, "starts"), &size));
    return size;
}

static void a_reader_starts_the_helper_once_whatever_the_files_are(void **state)
{
    const unsigned char grey[] = {0, 128, 255};
    const char text[] = "hello\n";
    count_starts(*state);
    test_path good = write_tiff(*state, 3, 1, 8, 1, 1, grey),
              bad = test_folder_write(*state, "bad.jpg", text, sizeof text - 1, 0600);
    for (int i = 0; i < 3; i++) {
        rk_image image = read_image(good);
        rk_check_close(image.pixels[2].y, 1, 0, "the picture is whole");
        rk_image_free(&image);
        check_refused(bad, "cannot be read");
    }
    rk_check_equal(starts(*state), 1, "six pictures, three of them broken");
}

static void a_helper_that_has_died_is_started_again(void **state)
{
    const unsigned char grey[] = {0, 128, 255};
    test_path good = write_tiff(*state, 3, 1, 8, 1, 1, grey);
    char script[2 * sizeof(test_path) + 200];
    int length =
        snprintf(script, sizeof script,
                 "#!/bin/sh\nif [ -e '%s/once' ]; then exec '%s/raykit-image' \"$@\"; fi\n"
                 "touch '%s/once'\nkill -SEGV $$\n",
                 ((test_folder *)*state)->path, RK_BUILD_FOLDER, ((test_folder *)*state)->path);
    test_folder_write(*state, "raykit-image", script, (size_t)length, 0700);
    use_helpers_of(*state);
    check_refused(good, "signal");
    rk_image image = read_image(good);
    rk_image_free(&image);
}

#if defined(__linux__) && !defined(RK_SANITIZED)
/* The number after this name in /proc/PID/limits; 0 if unlimited. */
static double limit_of(long process, const char *name)
{
    test_path path;
    char line[200];
    double limit = -1;
    snprintf(path.text, sizeof path.text, "/proc/%ld/limits", process);
    FILE *file = fopen(path.text, "r");
    rk_check(file, "%s cannot be read", path.text);
    while (fgets(line, sizeof line, file))
        if (strncmp(line, name, strlen(name)) == 0)
            limit = strtod(line + strlen(name), NULL);
    fclose(file);
    return limit;
}

/* The only child of this process. */
static long find_child(void)
{
    test_path path;
    long child = 0;
    snprintf(path.text, sizeof path.text, "/proc/self/task/%ld/children", (long)getpid());
    FILE *file = fopen(path.text, "r");
    if (file && fscanf(file, "%ld", &child) != 1)
        child = 0;
    if (file)
        fclose(file);
    return child;
}

/* Three pixels may take what 2^24 may, because the header could claim as many: 1 GB for these, 1 GB
 * for what is fixed, and OpenImageIO's own addresses. */
static void a_small_picture_may_cost_little(void **state)
{
    const unsigned char grey[] = {0, 128, 255};
    rk_image image = read_image(write_tiff(*state, 3, 1, 8, 1, 1, grey));
    rk_image_free(&image);
    const long child = find_child();
    if (!child) /* this kernel does not tell */
        skip();
    const double memory = limit_of(child, "Max address space"),
                 time = limit_of(child, "Max cpu time");
    rk_check(memory > 2e9 && memory < 6e9, "%.3g bytes of addresses", memory);
    rk_check(time >= 20 && time < 60, "%g s of processor time", time);
}
#endif

static const struct CMUnitTest tests[] = {
    test_in_folder(exr_keeps_every_bit_of_every_float),
    test_in_folder(the_same_picture_gives_the_same_exr),
    test_in_folder(float_tiff_is_linear_and_exact),
    test_in_folder(hdr_keeps_a_hundredth_of_the_brightest_channel),
    test_in_folder(a_portable_float_map_is_linear),
    test_in_folder(the_first_bytes_name_the_format),
    test_in_folder(floats_are_decoded_only_if_their_file_names_a_curve),
    test_in_folder(an_exr_whose_colours_are_in_layers_names_the_first),
    test_in_folder(an_exr_shows_what_is_in_its_display_window),
    test_in_folder(an_exr_is_transparent_outside_its_data),
    test_in_folder(an_exr_with_a_display_window_too_large_is_refused),
    test_in_folder(jpeg_is_srgb_encoded),
    test_in_folder(eight_bit_grey_is_decoded_and_replicated),
    test_in_folder(sixteen_bits_are_decoded_and_alpha_is_dropped),
    test_in_folder(photos_in_all_orientations_are_turned_upright),
    test_in_folder(the_exposure_of_an_hdr_is_taken_back),
    test_in_folder(an_hdr_that_is_not_read_has_its_reason),
    test_in_folder(a_dds_of_half_floats_is_read_face_by_face),
    test_in_folder(a_format_that_is_not_read_has_its_reason),
    test_in_folder(a_pixel_that_is_not_a_number_is_named),
    test_in_folder(a_broken_jpeg_is_refused),
    test_in_folder(a_broken_tiff_is_refused),
    test_in_folder(a_broken_exr_is_refused),
    test_in_folder(a_broken_hdr_is_refused),
    test_in_folder(missing_empty_and_foreign_files_are_refused),
    test_in_folder(a_pointer_of_git_lfs_is_no_picture),
    test_in_folder(a_web_page_is_no_picture),
    test_in_folder(absurd_sizes_are_refused),
    test_in_folder(a_fault_without_a_reason_is_still_a_sentence),
    test_in_folder(folders_pipes_and_devices_are_refused_at_once),
    test_in_folder(an_exr_goes_where_its_link_points),
    test_in_folder(a_picture_without_pixels_is_not_written),
    test_in_folder(an_exr_into_a_missing_folder_is_an_error),
    test_in_folder(an_interrupted_exr_leaves_nothing),
    test_in_folder(other_endings_are_not_written),
    test_with_false_helper(a_missing_helper_names_the_package_but_png_needs_none),
    test_with_false_helper(invalid_answers_are_refused),
    test_with_false_helper(a_helper_that_dies_is_an_error_with_the_files_name),
    test_with_false_helper(a_reader_starts_the_helper_once_whatever_the_files_are),
    test_with_false_helper(a_helper_that_has_died_is_started_again),
#if defined(__linux__) && !defined(RK_SANITIZED)
    test_in_folder(a_small_picture_may_cost_little),
#endif
};

RK_SUITE_IN("image_file", tests, NULL, end_reader)
