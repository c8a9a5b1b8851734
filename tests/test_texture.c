/* Textures: exact at texel centres, linear between them, and valid for any coordinate. */
#include "test.h"

#include "base/random.h"
#include "base/texture.h"

static const rk_texture_wrap wraps[2] = {RK_TEXTURE_CLAMP, RK_TEXTURE_REPEAT};
static const rk_texture_filter filters[2] = {RK_TEXTURE_NEAREST, RK_TEXTURE_BILINEAR};

static rk_texture make_texture(size_t width, size_t height, rk_texture_wrap wrap,
                               rk_texture_filter filter)
{
    rk_texture texture = {.wrap = wrap, .filter = filter};
    rk_error error;
    rk_check_ok(rk_image_init(&texture.image, width, height, &error), error);
    return texture;
}

/* Gives every texel its own colour, in [0, 1]. */
static rk_texture make_noise(size_t width, size_t height, rk_texture_wrap wrap,
                             rk_texture_filter filter)
{
    rk_texture texture = make_texture(width, height, wrap, filter);
    for (uint32_t i = 0; i < width * height; i++)
        texture.image.pixels[i] =
            rk_vec(rk_unit_float(rk_hash(i, 0, 0, 0)), rk_unit_float(rk_hash(i, 1, 0, 0)),
                   rk_unit_float(rk_hash(i, 2, 0, 0)));
    return texture;
}

static void check_colour(rk_vec3 got, rk_vec3 want, double tolerance, const char *hint)
{
    for (int axis = 0; axis < 3; axis++)
        rk_check_close(rk_axis(got, axis), rk_axis(want, axis), tolerance, hint);
}

static rk_vec3 look_up(const rk_texture *texture, float u, float v)
{
    return rk_texture_at(texture, (rk_vec2){u, v});
}

/* The texel `i` from the left and `j` from the bottom. */
static rk_vec3 texel_of(const rk_texture *texture, size_t i, size_t j)
{
    return *rk_image_at(&texture->image, i, texture->image.height - 1 - j);
}

/* --- inside ---------------------------------------------------------------------------------- */

static void u_goes_right_and_v_goes_up(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        rk_texture texture = make_texture(2, 2, wraps[k / 2], filters[k % 2]);
        const rk_vec3 colours[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
        memcpy(texture.image.pixels, colours, sizeof colours);
        check_colour(look_up(&texture, 0.25f, 0.75f), colours[0], 0, "the first row is the top");
        check_colour(look_up(&texture, 0.75f, 0.75f), colours[1], 0, "top right");
        check_colour(look_up(&texture, 0.25f, 0.25f), colours[2], 0, "bottom left");
        check_colour(look_up(&texture, 0.75f, 0.25f), colours[3], 0, "bottom right");
        rk_texture_free(&texture);
    }
}

static void texel_centres_give_the_texels(void **state)
{
    (void)state;
    const size_t sizes[][2] = {{1, 1}, {2, 8}, {64, 16}, {1024, 1}, {3, 5}, {100, 7}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int k = 0; k < 4; k++) {
            size_t width = sizes[s][0], height = sizes[s][1];
            rk_texture texture = make_noise(width, height, wraps[k / 2], filters[k % 2]);
            /* To the bit, unless (i + .5) / width is rounded, by 2^-24 of the width, and the filter
             * is bilinear: the texture changes by at most 1 per texel in each direction. */
            bool exact = s < 4 || filters[k % 2] == RK_TEXTURE_NEAREST;
            double tolerance = exact ? 0 : 2 * 0x1p-24 * (double)(width + height);
            for (size_t j = 0; j < height; j++)
                for (size_t i = 0; i < width; i++)
                    check_colour(look_up(&texture, ((float)i + 0.5f) / (float)width,
                                         ((float)j + 0.5f) / (float)height),
                                 texel_of(&texture, i, j), tolerance, "a texel's centre");
            rk_texture_free(&texture);
        }
}

static void the_nearest_texel_contains_the_point(void **state)
{
    (void)state;
    rk_texture texture = make_noise(16, 8, RK_TEXTURE_CLAMP, RK_TEXTURE_NEAREST);
    for (uint32_t k = 0; k < 20000; k++) {
        float u = rk_unit_float(rk_hash(k, 0, 1, 1)), v = rk_unit_float(rk_hash(k, 1, 1, 1));
        check_colour(look_up(&texture, u, v), texel_of(&texture, (size_t)(u * 16), (size_t)(v * 8)),
                     0, "texel i covers [i / n, (i + 1) / n)");
    }
    for (size_t i = 0; i < 16; i++) {
        float left_edge = (float)i / 16;
        check_colour(look_up(&texture, left_edge, 0), texel_of(&texture, i, 0), 0, "its left edge");
        check_colour(look_up(&texture, nextafterf(left_edge + 0.0625f, 0), 0),
                     texel_of(&texture, i, 0), 0, "just before the next one");
    }
    rk_texture_free(&texture);
}

static void bilinear_mixes_the_four_around(void **state)
{
    (void)state;
    rk_texture texture = make_texture(2, 2, RK_TEXTURE_CLAMP, RK_TEXTURE_BILINEAR);
    const rk_vec3 colours[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    memcpy(texture.image.pixels, colours, sizeof colours);
    check_colour(look_up(&texture, 0.5f, 0.5f), rk_vec(0.5f, 0.5f, 0.5f), 0, "a quarter of each");
    check_colour(look_up(&texture, 0.5f, 0.75f), rk_vec(0.5f, 0.5f, 0), 0, "half of the top two");
    check_colour(look_up(&texture, 0.375f, 0.75f), rk_vec(0.75f, 0.25f, 0), 0,
                 "a quarter of the way");
    check_colour(look_up(&texture, 0.25f, 0.375f), rk_vec(0.25f, 0, 0.75f), 0,
                 "a quarter of the way up");
    rk_texture_free(&texture);
}

static void bilinear_reproduces_linear_images(void **state)
{
    (void)state;
    const size_t width = 24, height = 10;
    rk_texture texture = make_texture(width, height, RK_TEXTURE_CLAMP, RK_TEXTURE_BILINEAR);
    for (size_t j = 0; j < height; j++)
        for (size_t i = 0; i < width; i++)
            *rk_image_at(&texture.image, i, height - 1 - j) =
                rk_vec((float)i, (float)j, 1 + 2 * (float)i - 3 * (float)j);
    for (uint32_t k = 0; k < 20000; k++) {
        float u = rk_unit_float(rk_hash(k, 0, 2, 2)), v = rk_unit_float(rk_hash(k, 1, 2, 2));
        double x = (double)u * (double)width - 0.5, y = (double)v * (double)height - 0.5;
        if (x < 0 || y < 0 || x > (double)width - 1 || y > (double)height - 1)
            continue; /* between the outer centres and the edge, clamping is constant */
        rk_vec3 got = look_up(&texture, u, v);
        /* Two or three roundings each way of numbers up to 24, and of 78 in the sum. */
        rk_check_close(got.x, x, 8 * 24 * 0x1p-24, "the column");
        rk_check_close(got.y, y, 8 * 10 * 0x1p-24, "the row, from the bottom");
        rk_check_close(got.z, 1 + 2 * x - 3 * y, 8 * 78 * 0x1p-24, "a plane");
    }
    rk_texture_free(&texture);
}

static void bilinear_is_continuous_across_texels_and_repeats(void **state)
{
    (void)state;
    const size_t side = 16;
    rk_texture texture = make_noise(side, side, RK_TEXTURE_REPEAT, RK_TEXTURE_BILINEAR);
    const float h = 0x1p-16f;
    for (int k = -40; k <= 40; k++) {
        float u = (float)k / 32, v = 0.3f;
        /* Noise changes by at most 1 per texel: by 2 h side over a step of 2 h. */
        check_colour(look_up(&texture, u - h, v), look_up(&texture, u + h, v),
                     2 * (double)h * (double)side + 0x1p-20, "no jump in u");
        check_colour(look_up(&texture, v, u - h), look_up(&texture, v, u + h),
                     2 * (double)h * (double)side + 0x1p-20, "no jump in v");
    }
    rk_texture_free(&texture);
}

/* --- outside --------------------------------------------------------------------------------- */

static void clamping_continues_the_edge(void **state)
{
    (void)state;
    const float beyond[] = {1, 1.001f, 2, 7.25f, 1e10f, 3.4e38f, INFINITY};
    for (int f = 0; f < 2; f++) {
        rk_texture texture = make_noise(8, 4, RK_TEXTURE_CLAMP, filters[f]);
        for (size_t k = 0; k < sizeof beyond / sizeof *beyond; k++) {
            check_colour(look_up(&texture, beyond[k], 0.375f), texel_of(&texture, 7, 1), 0,
                         "right");
            check_colour(look_up(&texture, 1 - beyond[k], 0.375f), texel_of(&texture, 0, 1), 0,
                         "left");
            check_colour(look_up(&texture, 0.3125f, beyond[k]), texel_of(&texture, 2, 3), 0, "top");
            check_colour(look_up(&texture, 0.3125f, 1 - beyond[k]), texel_of(&texture, 2, 0), 0,
                         "bottom");
        }
        rk_texture_free(&texture);
    }
}

static void repeating_has_period_one(void **state)
{
    (void)state;
    const float shifts[] = {1, -1, 2, -3, 100, -4096, 8192};
    for (int f = 0; f < 2; f++) {
        rk_texture texture = make_noise(8, 5, RK_TEXTURE_REPEAT, filters[f]);
        for (uint32_t k = 0; k < 2000; k++) {
            /* Multiples of 2^-10, so that sums with integers are exact. */
            float u = (float)(rk_hash(k, 0, 3, 3) >> 22) * 0x1p-10f;
            float v = (float)(rk_hash(k, 1, 3, 3) >> 22) * 0x1p-10f;
            rk_vec3 want = look_up(&texture, u, v);
            for (size_t s = 0; s < sizeof shifts / sizeof *shifts; s++) {
                check_colour(look_up(&texture, u + shifts[s], v), want, 0, "in u");
                check_colour(look_up(&texture, u, v + shifts[s]), want, 0, "in v");
            }
        }
        rk_texture_free(&texture);
    }
}

static void repeating_puts_the_last_texel_before_the_first(void **state)
{
    (void)state;
    rk_texture texture = make_noise(8, 4, RK_TEXTURE_REPEAT, RK_TEXTURE_NEAREST);
    check_colour(look_up(&texture, -0.0625f, 0.125f), texel_of(&texture, 7, 0), 0, "left of 0");
    check_colour(look_up(&texture, 1.0625f, 0.125f), texel_of(&texture, 0, 0), 0, "right of 1");
    check_colour(look_up(&texture, 0.0625f, -0.125f), texel_of(&texture, 0, 3), 0, "below 0");
    check_colour(look_up(&texture, 1, 1), texel_of(&texture, 0, 0), 0, "1 is 0 again");
    texture.filter = RK_TEXTURE_BILINEAR;
    rk_vec3 want = rk_mix(texel_of(&texture, 7, 1), texel_of(&texture, 0, 1), 0.5f);
    check_colour(look_up(&texture, 0, 0.375f), want, 0, "half of the last, half of the first");
    rk_texture_free(&texture);
}

static void integers_of_any_size_give_the_pictures_corner(void **state)
{
    (void)state;
    for (int f = 0; f < 2; f++) {
        rk_texture texture = make_noise(7, 7, RK_TEXTURE_REPEAT, filters[f]);
        rk_vec3 corner = look_up(&texture, 0, 0);
        for (int exponent = 24; exponent < 128; exponent++)
            for (int sign = -1; sign <= 1; sign += 2)
                check_colour(look_up(&texture, ldexpf((float)sign, exponent), 0), corner, 0,
                             "no float beyond 2^24 has a fraction");
        rk_texture_free(&texture);
    }
}

/* AddressSanitizer would catch reads out of range, UndefinedBehaviorSanitizer conversions that no
 * integer can hold; results are always within the picture's range. */
static void any_coordinate_gives_a_colour_of_the_picture(void **state)
{
    (void)state;
    const float odd[] = {NAN,     -NAN,     INFINITY, -INFINITY, 3.4e38f,       -3.4e38f,
                         1e-45f,  -1e-45f,  -1e-10f,  -0.0f,     0.99999994f,   1.0000001f,
                         1,       -1,       1e9f,     -1e9f,     2147483647.0f, 4294967296.0f,
                         9.3e18f, -9.3e18f, 0.5f,     16777215,  8388607.5f};
    const size_t count = sizeof odd / sizeof *odd;
    const size_t sides[] = {1, 2, 3, 64, 1000};
    for (size_t s = 0; s < sizeof sides / sizeof *sides; s++)
        for (int k = 0; k < 4; k++) {
            rk_texture texture = make_noise(sides[s], sides[s], wraps[k / 2], filters[k % 2]);
            for (size_t i = 0; i < count * count; i++) {
                rk_vec3 got = look_up(&texture, odd[i / count], odd[i % count]);
                for (int axis = 0; axis < 3; axis++)
                    rk_check(rk_axis(got, axis) >= 0 && rk_axis(got, axis) <= 1,
                             "(%g, %g) gives %g", (double)odd[i / count], (double)odd[i % count],
                             (double)rk_axis(got, axis));
            }
            rk_texture_free(&texture);
        }
}

static void nan_counts_as_zero(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        rk_texture texture = make_noise(4, 4, wraps[k / 2], filters[k % 2]);
        check_colour(look_up(&texture, NAN, NAN), look_up(&texture, 0, 0), 0, "NaN");
        texture.wrap = RK_TEXTURE_REPEAT;
        check_colour(look_up(&texture, INFINITY, -INFINITY), look_up(&texture, 0, 0), 0,
                     "infinity has no place in a period");
        rk_texture_free(&texture);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(u_goes_right_and_v_goes_up),
    cmocka_unit_test(texel_centres_give_the_texels),
    cmocka_unit_test(the_nearest_texel_contains_the_point),
    cmocka_unit_test(bilinear_mixes_the_four_around),
    cmocka_unit_test(bilinear_reproduces_linear_images),
    cmocka_unit_test(bilinear_is_continuous_across_texels_and_repeats),
    cmocka_unit_test(clamping_continues_the_edge),
    cmocka_unit_test(repeating_has_period_one),
    cmocka_unit_test(repeating_puts_the_last_texel_before_the_first),
    cmocka_unit_test(integers_of_any_size_give_the_pictures_corner),
    cmocka_unit_test(any_coordinate_gives_a_colour_of_the_picture),
    cmocka_unit_test(nan_counts_as_zero),
};

RK_SUITE("texture", tests)
