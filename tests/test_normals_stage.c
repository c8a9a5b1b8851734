/* Normals in the renderer: their colours are added where they are wanted, and nothing elsewhere. */
#include "test_scene.h"

#include "features/normals.h"

static void normals_are_planned_where_they_are_wanted(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell"), nothing = test_scene_make(0);
    rk_render_options options = rk_render_options_default();
    rk_check(!rk_plan_of(&scene, &options).normals, "normals are planned by default");
    options.normals = RK_NORMALS_FLAT;
    rk_check(rk_plan_of(&scene, &options).normals, "flat normals are not planned");
    rk_check(!rk_plan_of(&nothing, &options).rays, "rays are planned without a surface");
    rk_scene_free(&nothing);
    rk_scene_free(&scene);
}

/* A wall without light, whose corners have normals that are not the plane's. */
static rk_vec3 colour_of_wall(rk_normals_shown shown)
{
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 0, 0);
    const rk_vec3 slanted = rk_normalize(rk_vec(0, 3, -4));
    rk_vec3 normals[6] = {slanted, slanted, slanted, slanted, slanted, slanted};
    scene.mesh.normals = shown == RK_NORMALS_SMOOTH ? normals : NULL;
    rk_render_options options = rk_render_options_default();
    options.width = options.height = 4;
    options.normals = shown;
    test_picture picture = test_render(&scene, options, 1);
    rk_vec3 colour = *rk_image_at(&picture.image, 1, 2);
    rk_image_free(&picture.image);
    scene.mesh.normals = NULL;
    rk_scene_free(&scene);
    return colour;
}

static void check_colour(rk_vec3 got, rk_vec3 want, const char *hint)
{
    /* A few roundings of numbers up to 1. */
    rk_vec3 off = rk_abs3(rk_sub(got, want));
    rk_check(off.x <= 0x1p-20f && off.y <= 0x1p-20f && off.z <= 0x1p-20f,
             "got (%g, %g, %g), want (%g, %g, %g): %s", (double)got.x, (double)got.y, (double)got.z,
             (double)want.x, (double)want.y, (double)want.z, hint);
}

static void surfaces_show_the_colours_of_their_normals(void **state)
{
    (void)state;
    check_colour(colour_of_wall(RK_NORMALS_NONE), rk_vec(0, 0, 0), "a wall without light");
    check_colour(colour_of_wall(RK_NORMALS_FLAT), rk_vec(0.5f, 0.5f, 0),
                 "the wall faces the camera, against z");
    check_colour(colour_of_wall(RK_NORMALS_SMOOTH), rk_vec(0.5f, 0.8f, 0.1f),
                 "the normal of all corners is (0, 0.6, -0.8)");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(normals_are_planned_where_they_are_wanted),
    cmocka_unit_test(surfaces_show_the_colours_of_their_normals),
};

RK_SUITE("normals_stage", tests)
