/* What the figure of chapter 4 follows: the irradiance of a lamp beside a surface, with two of its
 * corners below the horizon, so that each kind of edge occurs once. */
#include "features/parallelogram_light.h"

#include <stdio.h>

int main(void)
{
    const rk_vec3 grey = rk_vec(1, 1, 1), point = rk_vec(0, 0, 0), normal = rk_vec(0, 1, 0);
    const rk_light lamp = {.kind = RK_LIGHT_PARALLELOGRAM,
                           .position = rk_vec(1.75f, -1, 2),
                           .edge01 = rk_vec(-1, 4, .5f),
                           .edge02 = rk_vec(3, .5f, .75f),
                           .colours = {grey, grey, grey, grey}};
    printf("{\"irradiance\": %.9g}\n", (double)rk_light_irradiance(&lamp, point, normal));
    return 0;
}
