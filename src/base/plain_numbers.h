/* Numbers with a decimal point, in a program whose locale has a comma; not installed. */
#ifndef RK_BASE_PLAIN_NUMBERS_H
#define RK_BASE_PLAIN_NUMBERS_H

#include <locale.h>

typedef struct rk_plain_numbers {
    locale_t plain, before;
} rk_plain_numbers;

/* From here to rk_plain_numbers_end, this thread reads and writes numbers as C does. */
static inline rk_plain_numbers rk_plain_numbers_begin(void)
{
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return (rk_plain_numbers){plain, plain == (locale_t)0 ? plain : uselocale(plain)};
}

static inline void rk_plain_numbers_end(rk_plain_numbers numbers)
{
    if (numbers.plain == (locale_t)0)
        return;
    uselocale(numbers.before);
    freelocale(numbers.plain);
}

#endif
