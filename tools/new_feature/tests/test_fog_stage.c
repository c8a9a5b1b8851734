/* Fog in the renderer: where it is not wanted nothing changes, and nothing is done. */
#include "test_scene.h"

#include "render/stages/fog_stage.h"

static void without_fog_the_picture_stays_as_it_is(void **state)
{
    (void)state;
    rk_vec3 before[] = {{0.25f, 0.5f, 2}, {0, 0, 0}}, after[] = {before[0], before[1]};
    rk_image image = {.width = 2, .height = 1, .pixels = after};
    const rk_fog_options none = {.strength = 0};
    rk_fog_stage(&image, &none);
    rk_check(!rk_fog_wanted(&none), "fog is wanted at strength 0");
    rk_check(memcmp(before, after, sizeof before) == 0, "fog changes a picture at strength 0");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(without_fog_the_picture_stays_as_it_is),
};

RK_SUITE("fog_stage", tests)
