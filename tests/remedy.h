/* A refusal ends by what the user can do: after a colon or a semicolon, one of these verbs.
 * tests/test_remedies.sh reads the list, too. */
#ifndef RK_TESTS_REMEDY_H
#define RK_TESTS_REMEDY_H

#include "test.h"

#include <string.h>

static const char *const remedy_verbs[] = {
    "check",   "choose", "close",    "convert", "copy",        "divide", "download", "export",
    "flatten", "free",   "give",     "gunzip",  "install",     "join",   "leave",    "make",
    "merge",   "move",   "name",     "open",    "put",         "reduce", "rename",   "repair",
    "run",     "save",   "simplify", "try",     "reconstruct", "set",    "unzip",    "use"};

static inline bool has_remedy(const char *message)
{
    for (const char *at = message; (at = strpbrk(at, ":;")); at++)
        for (size_t i = 0; at[1] == ' ' && i < sizeof remedy_verbs / sizeof *remedy_verbs; i++) {
            const size_t length = strlen(remedy_verbs[i]);
            if (strncmp(at + 2, remedy_verbs[i], length) == 0 && strchr(" ,", at[2 + length]))
                return true;
        }
    return false;
}

#define rk_check_remedy(message)                                                                   \
    rk_check(has_remedy(message), "the refusal has no remedy (tests/remedy.h): %s", message)

#endif
