/* What clang's checks for undefined behaviour (-fsanitize=undefined, without recovery) call: each
 * tells which kind of it, and where. */
#include "page.h"

#include <stdint.h>
#include <stdio.h>

/* The data of every check begin with the place in the source. */
typedef struct place {
    const char *file;
    uint32_t line, column;
} place;

static _Noreturn void undefined(const char *what, const place *at)
{
    site_fault(what, at->file, (int)at->line);
    __builtin_trap();
}

#define CHECK(name, arguments, what)                                                               \
    _Noreturn void __ubsan_handle_##name##_abort arguments;                                        \
    void __ubsan_handle_##name##_abort arguments                                                   \
    {                                                                                              \
        undefined(what, at);                                                                       \
    }
#define NO_VALUE (const place *at)
#define ONE_VALUE (const place *at, uintptr_t value __attribute__((unused)))
#define TWO_VALUES                                                                                 \
    (const place *at, uintptr_t a __attribute__((unused)), uintptr_t b __attribute__((unused)))
#define THREE_VALUES                                                                               \
    (const place *at, uintptr_t a __attribute__((unused)), uintptr_t b __attribute__((unused)),    \
     uintptr_t c __attribute__((unused)))

CHECK(add_overflow, TWO_VALUES, "the sum of two integers is beyond their type's range")
CHECK(sub_overflow, TWO_VALUES, "the difference of two integers is beyond their type's range")
CHECK(mul_overflow, TWO_VALUES, "the product of two integers is beyond their type's range")
CHECK(negate_overflow, ONE_VALUE, "the negative of an integer is beyond its type's range")
CHECK(divrem_overflow, TWO_VALUES,
      "an integer is divided by 0, or the quotient is beyond its type's range")
CHECK(shift_out_of_bounds, TWO_VALUES,
      "an integer is shifted by a negative number or by too many bits")
CHECK(out_of_bounds, ONE_VALUE, "an index is outside of its array")
CHECK(vla_bound_not_positive, ONE_VALUE, "an array's length is not positive")
CHECK(load_invalid_value, ONE_VALUE,
      "a value is none that its type has, such as a bool that is neither 0 nor 1")
CHECK(float_cast_overflow, ONE_VALUE,
      "a number is outside of the range of the type that it is converted to")
CHECK(type_mismatch_v1, ONE_VALUE,
      "a pointer is used whose address its type cannot have (it is not aligned)")
CHECK(alignment_assumption, THREE_VALUES,
      "a pointer has not the alignment that the code says it has")
CHECK(invalid_builtin, NO_VALUE, "a built-in function has no value for 0")
CHECK(nonnull_arg, NO_VALUE, "NULL is passed to a function that takes no NULL")

/* gcc and clang name these without an ending: they never return. */
_Noreturn void __ubsan_handle_builtin_unreachable(const place *at);
void __ubsan_handle_builtin_unreachable(const place *at)
{
    undefined("a place is reached that the code says is never reached", at);
}

_Noreturn void __ubsan_handle_missing_return(const place *at);
void __ubsan_handle_missing_return(const place *at)
{
    undefined("a function ends without the value that it should return", at);
}
