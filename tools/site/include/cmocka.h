/* The part of cmocka that tests/test.h and tests/suite.c use, for one claim in an instance of its
 * own: a claim that fails ends the instance (tools/site/cmocka.c). */
#ifndef SITE_CMOCKA_H
#define SITE_CMOCKA_H

#include <stddef.h>

typedef void (*CMUnitTestFunction)(void **state);
typedef int (*CMFixtureFunction)(void **state);

struct CMUnitTest {
    const char *name;
    CMUnitTestFunction test_func;
    CMFixtureFunction setup_func, teardown_func;
    void *initial_state;
};

#define cmocka_unit_test(test) cmocka_unit_test_setup_teardown(test, NULL, NULL)
#define cmocka_unit_test_setup_teardown(test, setup, teardown)                                     \
    {                                                                                              \
#test, test, setup, teardown, NULL                                                         \
    }

/* Returns 0, or does not return. */
int _cmocka_run_group_tests(const char *group, const struct CMUnitTest *tests, size_t count,
                            CMFixtureFunction set_up, CMFixtureFunction tear_down);
void cmocka_set_test_filter(const char *pattern);

/* The message of the claim that fails next. */
void print_error(const char *format, ...) __attribute__((format(printf, 1, 2)));
_Noreturn void _fail(const char *file, int line);
#define fail_msg(...) (print_error(__VA_ARGS__), _fail(__FILE__, __LINE__))

#endif
