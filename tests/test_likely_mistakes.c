/* Sentences about wrong values: each names the mistake that the value comes of, and none appears by
 * chance. */
#include "test.h"

#include "base/random.h"

static void check_said(const char *said, const char *part)
{
    rk_check(part ? strstr(said, part) != NULL : *said == '\0', "said \"%s\", want %s%s", said,
             part ? "in it: " : "nothing", part ? part : "");
}

static void common_mistakes_are_named(void **state)
{
    (void)state;
    const struct {
        double got, want;
        const char *part;
    } cases[] = {
        {0.6, 0.3, "twice the wanted"},
        {0.15, 0.3, "half the wanted"},
        {-0.3, 0.3, "the other sign"},
        {0.7, 0.3, "1 minus"},
        {0.09, 0.3, "the square of"},
        {0.547722557505166, 0.3, "the square root"},
        {3.33333333333333, 0.3, "1 over"},
        {0.942477796076938, 0.3, "pi times"},
        {0.0954929658551372, 0.3, "over pi"},
        {17.1887338539247, 0.3, "in degrees"},
        {0.00523598775598299, 0.3, "in radians"},
        {0.953939201416946, 0.3, "the sine"},
        {0.31, 0.3, NULL},
        {NAN, 0.3, NULL},
        {INFINITY, 0.3, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_said(rk_mistake_in(cases[i].got, cases[i].want, 1e-9, NULL), cases[i].part);
}

/* Many mistakes end in these. */
static void nothing_is_said_of_0_and_1(void **state)
{
    (void)state;
    const double ends[] = {0, 1, -1};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            check_said(rk_mistake_in(ends[i], ends[k] + 1, 0, NULL), NULL);
            check_said(rk_mistake_in(ends[k] + 1, ends[i], 0, NULL), NULL);
        }
    check_said(rk_mistake_in(0, 0.3, 1e-9, RK_MISTAKES({0, "it is not added"})), NULL);
    check_said(rk_mistake_in_vector((const double[3]){0}, (const double[]){0, 0.5, 0.5}, 1e-9,
                                    RK_VECTOR_MISTAKES({{0, 0, 0}, "it is cut off"})),
               NULL);
    check_said(rk_mistake_in_whole(2, 1, NULL), NULL);
    check_said(rk_mistake_in_whole(0, 100, NULL), NULL);
    check_said(rk_mistake_in_vector((const double[]){0, 1, 0}, (const double[]){1, 0, 0}, 0, NULL),
               NULL);
}

static void a_suites_own_mistakes_come_first(void **state)
{
    (void)state;
    const rk_mistake *own = RK_MISTAKES({0.6, "the aperture is taken as the radius"}, {1, "all"});
    check_said(rk_mistake_in(0.6, 0.3, 1e-9, own),
               RK_EXAMPLE_IF "the aperture is taken as the radius");
    check_said(rk_mistake_in(1, 0.3, 1e-9, own), RK_EXAMPLE_IF "all");
    check_said(rk_mistake_in_whole(1, 3, own), RK_EXAMPLE_IF "all");
    check_said(rk_mistake_in(0.15, 0.3, 1e-9, own), "half the wanted");
}

/* Where both values are within the tolerance, the number got cannot tell them apart. */
static void a_mistake_too_near_to_the_wanted_is_not_named(void **state)
{
    (void)state;
    check_said(rk_mistake_in(0.5002, 0.5, 1e-4, RK_MISTAKES({0.50015, "it is swapped"})), NULL);
    check_said(rk_mistake_in(0.6, 0.3, 0.05, NULL), NULL);
    check_said(rk_mistake_in(0.601, 0.3, 1e-4, NULL), NULL);
}

/* A coarse tolerance of a large number is none for a small one. */
static void a_mistake_is_as_exact_as_its_own_size_asks(void **state)
{
    (void)state;
    const rk_mistake *small = RK_MISTAKES({23.8, "it is divided by f"});
    check_said(rk_mistake_in(5.8e25, 4.3e31, 4.3e26, small), NULL);
    check_said(rk_mistake_in(24.8, 4.3e31, 4.3e26, small), NULL);
    check_said(rk_mistake_in(23.8001, 4.3e31, 4.3e26, small), RK_EXAMPLE_IF "it is divided by f");
    check_said(rk_mistake_in(1 / 3e14, 3e14, 1e5, NULL), "1 over");
    check_said(rk_mistake_in(2.5, 3e14, 1e5, NULL), NULL);
    const rk_vector_mistake *short_one = RK_VECTOR_MISTAKES({{0.5, 0, 0}, "it is normalized"});
    const double large[] = {4e6, 0, 0};
    check_said(rk_mistake_in_vector((const double[]){0.7, 0.1, 0}, large, 1, short_one), NULL);
    check_said(rk_mistake_in_vector((const double[]){0.5, 0, 0}, large, 1, short_one),
               RK_EXAMPLE_IF "it is normalized");
}

static void mistakes_that_cannot_be_told_apart_are_not_named(void **state)
{
    (void)state;
    const rk_mistake *alike = RK_MISTAKES({0.7, "a is added"}, {0.7 + 1e-10, "b is added"});
    const rk_mistake *same = RK_MISTAKES({0.7, "a is added"}, {0.7 + 1e-10, "a is added"});
    check_said(rk_mistake_in(0.7, 0.4, 1e-9, alike), NULL);
    check_said(rk_mistake_in(0.7, 0.4, 1e-12, alike), RK_EXAMPLE_IF "a is added");
    check_said(rk_mistake_in(0.7, 0.4, 1e-9, same), RK_EXAMPLE_IF "a is added");
    check_said(rk_mistake_in_whole(3, 5, RK_MISTAKES({3, "a is added"}, {3, "b is added"})), NULL);
    const double got[] = {1, 2, 3}, want[] = {4, 5, 7};
    check_said(rk_mistake_in_vector(got, want, 1e-9,
                                    RK_VECTOR_MISTAKES({{1, 2, 3}, "a is added"},
                                                       {{1, 2, 3 + 1e-10}, "b is added"})),
               NULL);
}

static void whole_numbers_are_twice_or_reversed(void **state)
{
    (void)state;
    check_said(rk_mistake_in_whole(34, 17, NULL), "twice");
    check_said(rk_mistake_in_whole(17, 34, NULL), "half");
    check_said(rk_mistake_in_whole(0x8c41e000LL, 0x00078231LL, NULL), "reversed order");
    check_said(rk_mistake_in_whole(18, 17, NULL), NULL);
}

static void vectors_are_exchanged_turned_or_too_long(void **state)
{
    (void)state;
    const double want[] = {0.6, 0, 0.8}, bright[] = {4, 0.5, 0.25};
    const struct {
        double got[3];
        const double *want;
        const char *part;
    } cases[] = {
        {{0.8, 0, 0.6}, want, "x and z are exchanged"},
        {{-0.6, 0, -0.8}, want, "the opposite way"},
        {{0.6, 0, -0.8}, want, "z has the other sign"},
        {{1.8, 0, 2.4}, want, "its length is 3, not 1"},
        {{8, 1, 0.5}, bright, "2 times the wanted"},
        {{1, 0.5, 0.25}, bright, "limited to 1"},
        {{4, 4, 4}, bright, "x stands in all three"},
        {{0.6, 0.1, 0.8}, want, NULL},
        {{0, 0, 0}, want, NULL},
        {{NAN, 0, 0}, want, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_said(rk_mistake_in_vector(cases[i].got, cases[i].want, 1e-9, NULL), cases[i].part);
    check_said(rk_mistake_in_vector(bright, want, 1e-9,
                                    RK_VECTOR_MISTAKES({{4, 0.5, 0.25}, "the light is added"})),
               RK_EXAMPLE_IF "the light is added");
}

/* Twelve mistakes, each with 2e-5 of the range of numbers around it: fewer than one in a thousand.
 */
static void wrong_numbers_without_a_reason_get_none(void **state)
{
    (void)state;
    enum { numbers = 20000 };
    unsigned numbers_said = 0, vectors_said = 0;
    for (uint32_t i = 0; i < numbers; i++) {
        double v[6];
        for (uint32_t k = 0; k < 6; k++)
            v[k] = (double)rk_unit_float(rk_hash(i, k, 0, 0));
        numbers_said += *rk_mistake_in(v[0], v[1], 1e-5 * v[1], NULL) != '\0';
        vectors_said += *rk_mistake_in_vector(v, v + 3, 1e-5, NULL) != '\0';
    }
    rk_check(numbers_said < numbers / 1000, "%u of %d random numbers were given a reason",
             numbers_said, numbers);
    rk_check(vectors_said == 0, "%u of %d random vectors were given a reason", vectors_said,
             numbers);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(common_mistakes_are_named),
    cmocka_unit_test(nothing_is_said_of_0_and_1),
    cmocka_unit_test(a_suites_own_mistakes_come_first),
    cmocka_unit_test(a_mistake_too_near_to_the_wanted_is_not_named),
    cmocka_unit_test(a_mistake_is_as_exact_as_its_own_size_asks),
    cmocka_unit_test(mistakes_that_cannot_be_told_apart_are_not_named),
    cmocka_unit_test(whole_numbers_are_twice_or_reversed),
    cmocka_unit_test(vectors_are_exchanged_turned_or_too_long),
    cmocka_unit_test(wrong_numbers_without_a_reason_get_none),
};

RK_SUITE("likely_mistakes", tests)
