/* Fog in the renderer: it is planned only where it is wanted. */
#include "test_scene.h"

static void fog_is_planned_where_it_is_wanted(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = rk_render_options_default();
    rk_check(!rk_plan_of(&scene, &options).fog, "fog is planned by default");
    options.fog.strength = 1;
    rk_check(rk_plan_of(&scene, &options).fog, "fog is not planned at strength 1");
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(fog_is_planned_where_it_is_wanted),
};

RK_SUITE("fog_stage", tests)
