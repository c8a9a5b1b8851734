/* A locale with a decimal comma, which a bare system does not have; not to be used by two tests at
 * a time. */
#ifndef RK_TESTS_TEST_COMMA_LOCALE_H
#define RK_TESTS_TEST_COMMA_LOCALE_H

#include "test_folder.h"

#include <locale.h>

/* Makes numbers have a comma until test_comma_locale_end. False where the C library takes no locale
 * in glibc's format (locale/loadlocale.c): six values of LC_NUMERIC, found by their offsets. */
static inline bool test_comma_locale_begin(const test_folder *folder)
{
    enum { words = 8, decimal_point = words * 4, separators = decimal_point + 2 };
    enum { wide_point = 40, wide_separator = 44, codeset = 48, size = 54 };
    const uint32_t head[words] = {
        0x20031115 ^ 1, 6,          decimal_point,  separators,
        separators,     wide_point, wide_separator, codeset,
    };
    unsigned char bytes[size] = {0};
    memcpy(bytes, head, sizeof head);
    bytes[decimal_point] = ',';
    memcpy(bytes + wide_point, &(uint32_t){','}, 4);
    memcpy(bytes + codeset, "UTF-8", 6);
    mkdir(test_folder_path(folder, "comma").text, 0700);
    test_folder_write(folder, "comma/LC_NUMERIC", bytes, size, 0600);
    setenv("LOCPATH", folder->path, 1);
    char text[8] = "";
    if (setlocale(LC_NUMERIC, "comma"))
        snprintf(text, sizeof text, "%.1f", 1.5);
    return strcmp(text, "1,5") == 0;
}

static inline void test_comma_locale_end(void)
{
    setlocale(LC_NUMERIC, "C");
    unsetenv("LOCPATH");
}

/* In place of test_folder_teardown. */
static inline int test_comma_locale_teardown(void **state)
{
    test_comma_locale_end();
    return test_folder_teardown(state);
}

#define test_in_comma_locale(name)                                                                 \
    cmocka_unit_test_setup_teardown(name, test_folder_setup, test_comma_locale_teardown)

#endif
