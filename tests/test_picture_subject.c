/* How much of a picture is there to be seen. */
#include "test.h"

#include "driver/picture_subject.h"

enum { width = 10, height = 4 };

static rk_image black_picture(void)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    for (size_t i = 0; i < width * height; i++)
        image.pixels[i] = rk_vec(0, 0, 0);
    return image;
}

static void a_black_picture_has_no_subject(void **state)
{
    (void)state;
    rk_image image = black_picture();
    rk_picture_subject subject = rk_picture_subject_of(&image);
    rk_check(subject.black == 1 && subject.frame == 0, "%g is black, the subject %g of the frame",
             subject.black, subject.frame);
    rk_image_free(&image);
}

static void the_subject_is_all_between_the_outermost_pixels(void **state)
{
    (void)state;
    rk_image image = black_picture();
    image.pixels[1 * width + 2] = rk_vec(1, 0, 0);
    image.pixels[3 * width + 6] = rk_vec(0, 0, 0.02f);
    rk_picture_subject subject = rk_picture_subject_of(&image);
    rk_check(subject.black == 38.0 / 40, "%g is black, not 38 of 40 pixels", subject.black);
    rk_check(subject.frame == 5.0 * 3 / 40, "the subject has %g of the frame, not 5 by 3 pixels",
             subject.frame);
    rk_image_free(&image);
}

static void nearly_black_is_black(void **state)
{
    (void)state;
    rk_image image = black_picture();
    image.pixels[5] = rk_vec(0.009f, 0.009f, 0.009f);
    rk_check(rk_picture_subject_of(&image).black == 1, "0.9 %% of white is not black");
    rk_image_free(&image);
}

static void a_full_picture_is_all_subject(void **state)
{
    (void)state;
    rk_image image = black_picture();
    for (size_t i = 0; i < width * height; i++)
        image.pixels[i] = rk_vec(0, 0.5f, 0);
    rk_picture_subject subject = rk_picture_subject_of(&image);
    rk_check(subject.black == 0 && subject.frame == 1, "%g is black, the subject %g of the frame",
             subject.black, subject.frame);
    rk_image_free(&image);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_black_picture_has_no_subject),
    cmocka_unit_test(the_subject_is_all_between_the_outermost_pixels),
    cmocka_unit_test(nearly_black_is_black),
    cmocka_unit_test(a_full_picture_is_all_subject),
};

RK_SUITE("picture_subject", tests)
