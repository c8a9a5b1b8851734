/* The comparison of a picture with the wanted one. */
#include "test.h"

#include "driver/picture_difference.h"

enum { width = 5, height = 4 };

typedef struct pictures {
    rk_image drawn, wanted, shown;
} pictures;

static pictures make_grey(void)
{
    pictures p;
    rk_error error;
    rk_check_ok(rk_image_init(&p.drawn, width, height, &error) &&
                    rk_image_init(&p.wanted, width, height, &error) &&
                    rk_image_init(&p.shown, width, height, &error),
                error);
    for (size_t i = 0; i < width * height; i++)
        p.drawn.pixels[i] = p.wanted.pixels[i] = rk_vec(0.25f, 0.5f, 0.75f);
    return p;
}

static void free_all(pictures *p)
{
    rk_image_free(&p->drawn);
    rk_image_free(&p->wanted);
    rk_image_free(&p->shown);
}

static float at_step(int step)
{
    return rk_srgb_decode((float)step / 255);
}

static void equal_pictures_do_not_differ(void **state)
{
    (void)state;
    pictures p = make_grey();
    rk_check(rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown).pixels == 0,
             "equal pictures differ");
    for (size_t i = 0; i < width * height; i++)
        rk_check(rk_length(p.shown.pixels[i]) == 0, "pixel %zu of the difference is not black", i);
    free_all(&p);
}

static void one_step_of_8_bits_is_no_difference_and_two_are(void **state)
{
    (void)state;
    pictures p = make_grey();
    for (int step = 1; step < 254; step++) {
        p.wanted.pixels[7].y = at_step(step);
        p.drawn.pixels[7].y = at_step(step + 1);
        rk_check(rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown).pixels == 0,
                 "step %d for %d counts as different", step + 1, step);
        p.drawn.pixels[7].y = at_step(step - 1);
        p.wanted.pixels[7].y = at_step(step + 1);
        rk_check(rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown).pixels == 1,
                 "step %d for %d does not count as different", step - 1, step + 1);
    }
    free_all(&p);
}

static void the_pixel_that_differs_most_is_named_and_brightest(void **state)
{
    (void)state;
    pictures p = make_grey();
    rk_image_at(&p.drawn, 1, 0)->x = at_step(100);
    rk_image_at(&p.drawn, 3, 2)->z = 0;
    rk_image_at(&p.drawn, 4, 3)->y = NAN;
    rk_picture_difference d = rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown);
    rk_check(d.pixels == 3, "got %zu pixels that differ, want 3; NaN is drawn black", d.pixels);
    rk_check(d.x == 3 && d.y == 2, "the pixel that differs most: got %zu,%zu, want 3,2", d.x, d.y);
    rk_check_near(rk_image_at(&p.shown, 3, 2)->z, 1, 1e-6, "the largest difference is shown as 1");
    rk_check(rk_length(*rk_image_at(&p.shown, 2, 2)) == 0, "a pixel that is right is not black");
    free_all(&p);
}

static void pixels_are_single_unless_two_touch(void **state)
{
    (void)state;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -2; dx <= 2; dx++) {
            pictures p = make_grey();
            rk_image_at(&p.drawn, 2, 1)->x = 1;
            rk_image_at(&p.drawn, (size_t)(2 + dx), (size_t)(1 + dy))->x = 1;
            bool want = abs(dx) > 1 || (dx == 0 && dy == 0);
            rk_check(rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown).are_single == want,
                     "pixels that differ, %d,%d apart: want them %s", dx, dy,
                     want ? "single" : "joined");
            free_all(&p);
        }
    /* The last of a row and the first of the next, which memory has side by side. */
    pictures p = make_grey();
    rk_image_at(&p.drawn, width - 1, 1)->x = rk_image_at(&p.drawn, 0, 2)->x = 1;
    rk_check(rk_picture_difference_of(&p.drawn, &p.wanted, &p.shown).are_single,
             "at the ends of two rows: want them single");
    free_all(&p);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(equal_pictures_do_not_differ),
    cmocka_unit_test(one_step_of_8_bits_is_no_difference_and_two_are),
    cmocka_unit_test(the_pixel_that_differs_most_is_named_and_brightest),
    cmocka_unit_test(pixels_are_single_unless_two_touch),
};

RK_SUITE("picture_difference", tests)
