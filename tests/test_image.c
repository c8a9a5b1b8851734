/* Images: their sizes and layout, and sRGB against its definition in double. */
#include "test.h"

#include "base/image.h"

static void a_new_image_is_black(void **state)
{
    (void)state;
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, 5, 3, &error), error);
    rk_check(image.width == 5 && image.height == 3, "5 x 3 pixels");
    for (size_t i = 0; i < 15; i++)
        rk_check_close(rk_length(image.pixels[i]), 0, 0, "black");
    rk_image_free(&image);
    rk_check(image.pixels == NULL && image.width == 0 && image.height == 0, "freed and zeroed");
    rk_image_free(&image);
}

static void rows_follow_each_other_from_the_top(void **state)
{
    (void)state;
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, 5, 3, &error), error);
    rk_check(rk_image_at(&image, 0, 0) == image.pixels, "the first pixel");
    rk_check(rk_image_at(&image, 4, 0) == image.pixels + 4, "along the row");
    rk_check(rk_image_at(&image, 1, 2) == image.pixels + 11, "2 rows of 5, and 1");
    rk_image_free(&image);
}

static void sizes_from_1_to_the_largest_side_are_made(void **state)
{
    (void)state;
    const size_t sizes[][2] = {{1, 1}, {RK_IMAGE_SIDE_MAX, 1}, {1, RK_IMAGE_SIDE_MAX}};
    for (int i = 0; i < 3; i++) {
        rk_image image;
        rk_error error;
        rk_check_ok(rk_image_init(&image, sizes[i][0], sizes[i][1], &error), error);
        *rk_image_at(&image, sizes[i][0] - 1, sizes[i][1] - 1) = rk_vec(1, 1, 1);
        rk_image_free(&image);
    }
}

static void other_sizes_are_refused_with_the_limit(void **state)
{
    (void)state;
    const size_t sizes[][2] = {{0, 1},
                               {1, 0},
                               {RK_IMAGE_SIDE_MAX + 1, 1},
                               {1, RK_IMAGE_SIDE_MAX + 1},
                               {SIZE_MAX, SIZE_MAX}};
    for (int i = 0; i < 5; i++) {
        rk_image image = {1, 1, (rk_vec3 *)&image};
        rk_error error;
        rk_check(!rk_image_init(&image, sizes[i][0], sizes[i][1], &error), "%zu x %zu was accepted",
                 sizes[i][0], sizes[i][1]);
        rk_check(image.pixels == NULL, "a refused image is zeroed, so that freeing it is harmless");
        rk_check_error_names(error, "32768");
    }
}

/* --- sRGB ------------------------------------------------------------------------------------ */

static double encode_wide(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

static double decode_wide(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void srgb_keeps_black_and_white(void **state)
{
    (void)state;
    rk_check_close(rk_srgb_encode(0), 0, 0, "black");
    rk_check_close(rk_srgb_decode(0), 0, 0, "black");
    /* 1.055 - 0.055 is rounded twice. */
    rk_check_close(rk_srgb_encode(1), 1, 0x1p-23, "white");
    rk_check_close(rk_srgb_decode(1), 1, 0x1p-23, "white");
}

static void srgb_follows_its_definition(void **state)
{
    (void)state;
    rk_check_close(rk_srgb_encode(0.214041140f), 0.5, 1e-7, "a well-known pair");
    /* The power's few roundings, and its base's error times the exponent: 8 units of 2^-24. */
    for (int i = 0; i <= 100000; i++) {
        float v = (float)i / 100000;
        rk_check_close(rk_srgb_encode(v), encode_wide((double)v), 8 * 0x1p-24, "encoding");
        rk_check_close(rk_srgb_decode(v), decode_wide((double)v), 8 * 0x1p-24, "decoding");
    }
}

static void srgb_clamps_and_turns_nan_black(void **state)
{
    (void)state;
    const float low[] = {-1, -INFINITY, NAN, -0.0f};
    for (int i = 0; i < 4; i++) {
        rk_check_close(rk_srgb_encode(low[i]), 0, 0, "below black");
        rk_check_close(rk_srgb_decode(low[i]), 0, 0, "below black");
    }
    rk_check_close(rk_srgb_encode(2), rk_srgb_encode(1), 0, "above white");
    rk_check_close(rk_srgb_encode(INFINITY), rk_srgb_encode(1), 0, "above white");
    rk_check_close(rk_srgb_decode(INFINITY), rk_srgb_decode(1), 0, "above white");
}

static void every_stored_byte_survives_decoding_and_encoding(void **state)
{
    (void)state;
    for (int i = 0; i < 256; i++) {
        float linear = rk_srgb_decode((float)i / 255);
        rk_check_equal(lrintf(255 * rk_srgb_encode(linear)), i, "8 bits are restored");
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_new_image_is_black),
    cmocka_unit_test(rows_follow_each_other_from_the_top),
    cmocka_unit_test(sizes_from_1_to_the_largest_side_are_made),
    cmocka_unit_test(other_sizes_are_refused_with_the_limit),
    cmocka_unit_test(srgb_keeps_black_and_white),
    cmocka_unit_test(srgb_follows_its_definition),
    cmocka_unit_test(srgb_clamps_and_turns_nan_black),
    cmocka_unit_test(every_stored_byte_survives_decoding_and_encoding),
};

RK_SUITE("image", tests)
