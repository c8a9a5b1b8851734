/* The relief on the statue's smooth tubes: bony rings and keels, fin rays, knobs, and a scanner's
 * small unevenness. Declared in scenes/statue_parts.h. */
#include "base/random.h"
#include "scenes/statue_parts.h"

static double at_corner(int x, int y, int z)
{
    return (double)rk_unit_float(rk_hash((uint32_t)x, (uint32_t)y, (uint32_t)z, 0x5ca9u)) * 2 - 1;
}

static double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

/* Random values on a grid of cells of width 1, smoothly interpolated; in [-1, 1]. */
static double noise(rk_statue_vec p)
{
    double fx = floor(p.x), fy = floor(p.y), fz = floor(p.z);
    int x = (int)fx, y = (int)fy, z = (int)fz;
    double tx = p.x - fx, ty = p.y - fy, tz = p.z - fz;
    tx *= tx * (3 - 2 * tx), ty *= ty * (3 - 2 * ty), tz *= tz * (3 - 2 * tz);
    double layer[2];
    for (int k = 0; k < 2; k++)
        layer[k] = mix(mix(at_corner(x, y, z + k), at_corner(x + 1, y, z + k), tx),
                       mix(at_corner(x, y + 1, z + k), at_corner(x + 1, y + 1, z + k), tx), ty);
    return mix(layer[0], layer[1], tz);
}

static double noise_at(rk_statue_vec p, double frequency)
{
    return noise((rk_statue_vec){p.x * frequency, p.y * frequency, p.z * frequency});
}

/* A wave of period 1 with sharp crests of height 1 at integers and flat troughs. */
static double crest(double x)
{
    double distance = fabs(x - floor(x + 0.5));
    double w = 1 - 2 * distance;
    return w * w * w;
}

double rk_statue_relief_at(rk_statue_relief kind, rk_statue_vec p, double key, double turns,
                           double radius)
{
    const double scanner = 0.006 * noise_at(p, 23);
    switch (kind) {
    case RK_STATUE_BONY: {
        double rings = crest(3.5 * key), keels = crest(8 * turns);
        return radius * (0.09 * rings + 0.07 * keels + 0.22 * rings * keels * keels) +
               0.02 * noise_at(p, 5) + scanner;
    }
    case RK_STATUE_SOFT:
        return 0.03 * noise_at(p, 4) + scanner;
    case RK_STATUE_FIN:
        return 0.03 * crest(9 * key) + scanner;
    case RK_STATUE_BRANCH:
        return radius * (0.35 * noise_at(p, 2.2) + 0.16 * noise_at(p, 7)) + scanner;
    case RK_STATUE_ROCK:
        return 0.5 * noise_at(p, 0.9) + 0.25 * noise_at(p, 2.1) + 0.1 * noise_at(p, 5) + scanner;
    }
    return 0;
}
