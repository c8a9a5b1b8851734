/* A step is the linear value of a half code, computed in double and rounded up to a float: floats
 * from there on have the next code, those below do not. */
#include "io/srgb8.h"

#include <math.h>

/* The transfer function of IEC 61966-2-1, from the stored value to linear light. */
static double decode(double stored)
{
    return stored <= 0.04045 ? stored / 12.92 : pow((stored + 0.055) / 1.055, 2.4);
}

static float round_up(double value)
{
    float rounded = (float)value;
    return rounded < value ? nextafterf(rounded, INFINITY) : rounded;
}

void rk_srgb8_init(rk_srgb8 *table)
{
    table->step[0] = 0;
    for (int k = 1; k < 256; k++)
        table->step[k] = round_up(decode((k - 0.5) / 255));
    table->step[256] = INFINITY;
    uint8_t value = 0;
    for (int i = 0; i <= RK_SRGB8_INTERVALS; i++) {
        while ((float)i / RK_SRGB8_INTERVALS >= table->step[value + 1])
            value++;
        table->below[i] = value;
    }
}
