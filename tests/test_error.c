/* Errors are one sentence on one line; short memory is one of them. */
#include "test.h"

#include "base/error.h"

/* AddressSanitizer and ThreadSanitizer end a program that requests too much, unless told that the
 * program handles NULL. */
const char *__asan_default_options(void);
const char *__tsan_default_options(void);

const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1";
}

const char *__tsan_default_options(void)
{
    return "allocator_may_return_null=1";
}

static void failing_writes_the_sentence_and_returns_false(void **state)
{
    (void)state;
    rk_error error = {"old"};
    rk_check(!rk_fail(&error, "%s: line %d", "a.obj", 7), "so that callers can return it");
    assert_string_equal(error.text, "a.obj: line 7");
    rk_fail(&error, "new");
    assert_string_equal(error.text, "new");
}

static void failing_without_an_error_is_allowed(void **state)
{
    (void)state;
    rk_check(!rk_fail(NULL, "%s", "nobody listens"), "the caller learns only that it failed");
}

static void line_breaks_become_spaces(void **state)
{
    (void)state;
    rk_error error;
    rk_fail(&error, "a\nb\r\nc");
    assert_string_equal(error.text, "a b  c");
}

/* Of names in files, which could clear a terminal, or write what looks like ours. */
static void control_characters_are_escaped(void **state)
{
    (void)state;
    rk_error error;
    rk_fail(&error, "a\x1b[2J\x7f\b\tb \xc2\x9b \xc3\xa9 \xc2\xa0");
    assert_string_equal(error.text, "a\\x1b[2J\\x7f\\x08\tb \\xc2\\x9b \xc3\xa9 \xc2\xa0");
    char text[sizeof error.text + 10];
    memset(text, '\a', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    rk_fail(&error, "%s", text);
    rk_check_equal(strlen(error.text), (sizeof error.text - 1) / 4 * 4, "none is cut in two");
}

static void a_long_sentence_is_truncated(void **state)
{
    (void)state;
    struct {
        rk_error error;
        char guard;
    } box = {.guard = '!'};
    char text[3000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    rk_fail(&box.error, "%s", text);
    rk_check_equal(strlen(box.error.text), sizeof box.error.text - 1, "truncated and terminated");
    rk_check(box.guard == '!', "nothing is written beyond the end");
}

static void memory_comes_zeroed_on_a_cache_line(void **state)
{
    (void)state;
    for (size_t count = 0; count < 200; count++) {
        rk_error error;
        unsigned char *memory = rk_allocate(count, 3, "bytes", &error);
        rk_check_ok(memory != NULL, error);
        rk_check((uintptr_t)memory % 64 == 0, "%zu elements lie at %p", count, (void *)memory);
        for (size_t i = 0; i < 3 * count; i++) {
            rk_check_equal(memory[i], 0, "zeroed");
            memory[i] = 255; /* so that the next block at this address starts dirty */
        }
        free(memory);
    }
}

static void memory_that_was_used_before_comes_zeroed(void **state)
{
    (void)state;
    enum { blocks = 100, bytes = 1000 };
    for (int round = 0; round < 2; round++) {
        unsigned char *memory[blocks];
        for (int i = 0; i < blocks; i++) {
            rk_error error;
            memory[i] = rk_allocate(bytes, 1, "bytes", &error);
            rk_check_ok(memory[i] != NULL, error);
            for (int k = 0; k < bytes; k++)
                rk_check_equal(memory[i][k], 0, "zeroed, whatever stood there");
        }
        for (int i = 0; i < blocks; i++) {
            memset(memory[i], 255, bytes);
            free(memory[i]);
        }
    }
}

static void memory_that_is_filled_at_once_comes_unset(void **state)
{
    (void)state;
    rk_error error = {""};
    unsigned char *memory = rk_allocate_unset(100, 3, "bytes", &error);
    rk_check_ok(memory != NULL, error);
    rk_check((uintptr_t)memory % 64 == 0, "it is at %p", (void *)memory);
    memset(memory, 1, 300);
    free(memory);
    rk_check(!rk_allocate_unset(SIZE_MAX, 2, "bytes", &error), "the same limits");
    rk_check_error_names(error, "bytes");
}

static void a_product_that_overflows_is_refused_by_name(void **state)
{
    (void)state;
    const size_t cases[][2] = {{SIZE_MAX, 2}, {SIZE_MAX / 2 + 1, 2}, {SIZE_MAX, SIZE_MAX},
                               {SIZE_MAX, 1}, {SIZE_MAX - 10, 1},    {(SIZE_MAX >> 4) + 1, 16}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_error error = {""};
        rk_check(!rk_allocate(cases[i][0], cases[i][1], "pixels", &error),
                 "%zu x %zu was allocated", cases[i][0], cases[i][1]);
        rk_check_error_names(error, "pixels");
        rk_check_error_names(error, "more than this machine can address");
    }
}

static void too_much_memory_is_refused_by_name_and_size(void **state)
{
    (void)state;
    rk_error error = {""};
    rk_check(!rk_allocate((size_t)1 << 40, 1 << 10, "pixels", &error), "2^50 bytes were allocated");
    rk_check_error_names(error, "pixels");
    rk_check_error_names(error, "1125899906.8 MB");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(failing_writes_the_sentence_and_returns_false),
    cmocka_unit_test(failing_without_an_error_is_allowed),
    cmocka_unit_test(line_breaks_become_spaces),
    cmocka_unit_test(control_characters_are_escaped),
    cmocka_unit_test(a_long_sentence_is_truncated),
    cmocka_unit_test(memory_comes_zeroed_on_a_cache_line),
    cmocka_unit_test(memory_that_was_used_before_comes_zeroed),
    cmocka_unit_test(memory_that_is_filled_at_once_comes_unset),
    cmocka_unit_test(a_product_that_overflows_is_refused_by_name),
    cmocka_unit_test(too_much_memory_is_refused_by_name_and_size),
};

RK_SUITE("error", tests)
