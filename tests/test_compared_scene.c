/* The scenes that are rendered by another renderer, too, and their regions. */
#include "test.h"

#include "driver/compared_scene.h"

enum { side = 40 };

static rk_compared_scene make(rk_compared_kind kind)
{
    rk_compared_scene c;
    rk_error error;
    rk_check_ok(rk_compared_scene_init(&c, kind, side, 16, &error), error);
    return c;
}

static void each_scene_can_be_rendered(void **state)
{
    (void)state;
    for (uint32_t kind = 0; kind < RK_COMPARED_COUNT; kind++) {
        rk_compared_scene c = make(kind);
        rk_error error;
        rk_check_ok(rk_render_check(&c.scene, &c.options, &error), error);
        rk_compared_scene_free(&c);
    }
}

static void only_the_scene_with_a_lens_needs_one_and_only_one_moves(void **state)
{
    (void)state;
    for (uint32_t kind = 0; kind < RK_COMPARED_COUNT; kind++) {
        rk_compared_scene c = make(kind);
        const rk_plan plan = rk_plan_of(&c.scene, &c.options);
        rk_check(plan.depth_of_field == (kind == RK_COMPARED_LENS), "%s: a lens?", c.scene.name);
        rk_check(plan.motion_blur == (kind == RK_COMPARED_MOTION), "%s: motion?", c.scene.name);
        rk_check(plan.parallelogram_light && plan.shadow_rays, "%s: soft shadows?", c.scene.name);
        rk_compared_scene_free(&c);
    }
}

static rk_compared_region at(const uint8_t *regions, float x, float y)
{
    return regions[(size_t)(y * side) * side + (size_t)(x * side)];
}

static void check_region(const uint8_t *regions, float x, float y, rk_compared_region want)
{
    const rk_compared_region got = at(regions, x, y);
    rk_check(got == want, "at %g, %g: got %s, want %s", (double)x, (double)y,
             rk_compared_region_names.items[got], rk_compared_region_names.items[want]);
}

/* Places in the published photograph of the box. */
static void surfaces_are_where_the_photograph_shows_them(void **state)
{
    (void)state;
    rk_compared_scene c = make(RK_COMPARED_CORNELL);
    uint8_t regions[side * side];
    rk_error error;
    rk_check_ok(rk_compared_regions(&c, regions, &error), error);
    check_region(regions, 0.2f, 0.95f, RK_REGION_FLOOR);
    check_region(regions, 0.2f, 0.05f, RK_REGION_CEILING);
    check_region(regions, 0.6f, 0.35f, RK_REGION_BACK_WALL);
    check_region(regions, 0.08f, 0.5f, RK_REGION_LEFT_WALL);
    check_region(regions, 0.92f, 0.5f, RK_REGION_RIGHT_WALL);
    check_region(regions, 0.65f, 0.8f, RK_REGION_LOW_BLOCK);
    check_region(regions, 0.38f, 0.6f, RK_REGION_TALL_BLOCK);
    for (size_t i = 0; i < side * side; i++)
        rk_check(regions[i] != RK_REGION_MOVING, "nothing moves, but pixel %zu", i);
    rk_compared_scene_free(&c);
}

/* The block at rest and where the shutter closes; other regions stay as they are. */
static void the_way_of_the_block_covers_its_start_and_its_end(void **state)
{
    (void)state;
    rk_compared_scene still = make(RK_COMPARED_CORNELL), c = make(RK_COMPARED_MOTION);
    uint8_t before[side * side], regions[side * side];
    rk_error error;
    rk_check_ok(rk_compared_regions(&still, before, &error), error);
    rk_check_ok(rk_compared_regions(&c, regions, &error), error);
    const rk_view view = rk_view_of(&c.scene.camera, side, side);
    const rk_moving *block = &c.scene.moving[0];
    rk_vec3 middle = {0, 0, 0};
    for (uint32_t i = 0; i < 6; i++) /* of the top: its two triangles come first */
        middle = rk_madd(
            middle, c.scene.mesh.positions[c.scene.mesh.triangles[block->first + i / 3][i % 3]],
            1.0f / 6);
    for (float time = 0; time <= 1; time++) {
        const rk_shutter *s = &c.options.motion.shutter;
        const rk_vec3 offset =
            rk_motion_offset(&block->motion, s->open + time * (s->close - s->open));
        rk_vec3 below = rk_add(middle, offset);
        below.y -= 0.1f; /* within the block, behind a visible side */
        rk_vec2 pixel;
        float depth;
        rk_check(rk_view_project(&view, below, &pixel, &depth), "it is in front");
        check_region(regions, pixel.x / side, pixel.y / side, RK_REGION_MOVING);
    }
    for (size_t i = 0; i < side * side; i++)
        rk_check(regions[i] == RK_REGION_MOVING || regions[i] == before[i] ||
                     before[i] == RK_REGION_TALL_BLOCK,
                 "pixel %zu was %s and is %s", i, rk_compared_region_names.items[before[i]],
                 rk_compared_region_names.items[regions[i]]);
    rk_compared_scene_free(&still);
    rk_compared_scene_free(&c);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(each_scene_can_be_rendered),
    cmocka_unit_test(only_the_scene_with_a_lens_needs_one_and_only_one_moves),
    cmocka_unit_test(surfaces_are_where_the_photograph_shows_them),
    cmocka_unit_test(the_way_of_the_block_covers_its_start_and_its_end),
};

RK_SUITE("compared_scene", tests)
