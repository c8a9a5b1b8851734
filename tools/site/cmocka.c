/* cmocka's runner for one claim, tests/suite.c's --only. The claim's instance ends when it fails:
 * nothing of it is left that would have to be freed. */
#include "page.h"

#include <cmocka.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static char message[4000];

void print_error(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    size_t length = strlen(message);
    if (length > 0 && message[length - 1] == '\n')
        message[length - 1] = 0;
    site_message(message);
}

_Noreturn void _fail(const char *file, int line)
{
    site_failed(file, line);
    _Exit(1);
}

void cmocka_set_test_filter(const char *pattern)
{
    (void)pattern;
}

static void fixture(CMFixtureFunction function, void **state, const char *what)
{
    if (function && function(state) != 0)
        print_error("%s failed", what), _fail("", 0);
}

int _cmocka_run_group_tests(const char *group, const struct CMUnitTest *tests, size_t count,
                            CMFixtureFunction set_up, CMFixtureFunction tear_down)
{
    (void)group;
    setvbuf(stdout, NULL, _IONBF, 0); /* told even if the claim ends here, or never */
    void *shared = NULL;
    fixture(set_up, &shared, "the suite's set-up");
    for (size_t i = 0; i < count; i++) {
        void *state = tests[i].initial_state ? tests[i].initial_state : shared;
        fixture(tests[i].setup_func, &state, "the claim's set-up");
        tests[i].test_func(&state);
        fixture(tests[i].teardown_func, &state, "the claim's tear-down");
    }
    fixture(tear_down, &shared, "the suite's tear-down");
    site_passed();
    return 0;
}

int getrusage(int who, struct rusage *used)
{
    (void)who;
    memset(used, 0, sizeof *used);
    return 0;
}
