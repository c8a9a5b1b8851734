/* What the figure of chapter 13 follows: the point 7/16 as it is scrambled, by a key that makes
 * heads and tails on its way; and where the unit takes each eighth of the interval. */
#include "features/sampling.h"

#include <stdio.h>

int main(void)
{
    const uint32_t key = 26, eighth = 1u << 29;
    printf("{\"scrambled\": %u, \"eighths\": [", rk_owen_scramble(7 * (eighth / 2), key));
    for (uint32_t i = 0; i < 8; i++)
        printf("%s%u", i ? ", " : "", rk_owen_scramble(i * eighth, key) / eighth);
    printf("]}\n");
    return 0;
}
