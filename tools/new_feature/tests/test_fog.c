/* Fog: its claims, simplest first. Each failure says what it got, what it wanted, and a hint. */
#include "test.h"

#include "features/fog.h"

static bool same(rk_vec3 a, rk_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void a_strength_of_0_changes_nothing(void **state)
{
    (void)state;
    rk_vec3 colour = rk_vec(0.25f, 0.5f, 2);
    rk_check(same(rk_fog_colour(colour, 0), colour), "strength 0 changes a colour");
}

static void a_strength_of_1_changes_a_colour(void **state)
{
    (void)state;
    rk_vec3 colour = rk_vec(0.25f, 0.5f, 2);
    rk_check(!same(rk_fog_colour(colour, 1), colour),
             "rk_fog_colour returns what it is given. Next: claim here, in tests/test_fog.c, the "
             "simplest thing that fog does, and fulfil it in src/features/fog.c; \"Adding a "
             "feature\" in docs/architecture.md has the steps from there on");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_strength_of_0_changes_nothing),
    cmocka_unit_test(a_strength_of_1_changes_a_colour),
};

RK_SUITE("fog", tests)
