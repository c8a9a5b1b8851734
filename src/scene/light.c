/* Properties of lights that need no samples. */
#include "scene/light.h"

#include <string.h>

static int corner_count(const rk_light *light)
{
    const int counts[] = {
        [RK_LIGHT_POINT] = 1, [RK_LIGHT_SEGMENT] = 2, [RK_LIGHT_PARALLELOGRAM] = 4};
    return counts[light->kind];
}

bool rk_light_emits(const rk_light *light)
{
    for (int i = 0; i < corner_count(light); i++)
        if (light->colours[i].x > 0 || light->colours[i].y > 0 || light->colours[i].z > 0)
            return true;
    return false;
}

bool rk_light_has_one_colour(const rk_light *light)
{
    for (int i = 1; i < corner_count(light); i++)
        if (memcmp(&light->colours[i], &light->colours[0], sizeof *light->colours) != 0)
            return false;
    return true;
}

/* With c from the point to corner 0, t direction = c + x edge01 + y edge02; crossed with an edge
 * and multiplied by the plane's normal, one unknown is left. */
bool rk_light_hit(const rk_light *light, rk_vec3 point, rk_vec3 direction, rk_vec2 *at)
{
    rk_dvec3 c = rk_dmadd(rk_widen(light->position), rk_widen(point), -1), d = rk_widen(direction);
    rk_dvec3 edge01 = rk_widen(light->edge01), edge02 = rk_widen(light->edge02);
    rk_dvec3 normal = rk_dcross(edge01, edge02);
    double t = rk_ddot(c, normal) / rk_ddot(d, normal), area2 = rk_ddot(normal, normal);
    rk_dvec3 from_corner = rk_dmadd(rk_dscale(c, -1), d, t);
    double x = rk_ddot(rk_dcross(from_corner, edge02), normal) / area2;
    double y = rk_ddot(rk_dcross(edge01, from_corner), normal) / area2;
    *at = (rk_vec2){(float)x, (float)y};
    return t > 0 && x >= 0 && x <= 1 && y >= 0 && y <= 1; /* NaN and infinity are no hit */
}

double rk_light_area_density(const rk_light *light, rk_vec3 point, rk_vec3 position)
{
    rk_dvec3 d = rk_dmadd(rk_widen(position), rk_widen(point), -1);
    double square = rk_ddot(d, d);
    rk_dvec3 normal = rk_dcross(rk_widen(light->edge01), rk_widen(light->edge02));
    double volume = fabs(rk_ddot(d, normal));
    return volume > 0 ? square * sqrt(square) / volume : (double)INFINITY;
}

/* Seen from the point, the segment is p + t |p| tan phi, where p is the foot of the perpendicular,
 * t the unit edge, and phi runs from phi0 to phi1. There r = |p| / cos phi and sin' = cos phi, so
 * the integrand becomes (n.p / |p| cos^2 phi + n.t sin phi cos phi) / |p|. */
double rk_light_segment_irradiance(rk_dvec3 from, rk_dvec3 edge, rk_dvec3 normal)
{
    double whole = rk_dlength(edge);
    rk_dvec3 t = rk_dscale(edge, 1 / whole), moment = rk_dcross(from, edge);
    rk_dvec3 p = rk_dscale(rk_dcross(t, moment), 1 / whole); /* from - t (t.from) would cancel */
    double distance = rk_dlength(moment) / whole, at = rk_ddot(from, t);
    double begin = rk_ddot(normal, from), end = begin + rk_ddot(normal, edge);
    if ((begin <= 0 && end <= 0) || !(distance > 0)) /* negated: a segment of no length gives NaN */
        return 0;
    /* Clipped at the horizon. */
    double low = begin < 0 ? begin / (begin - end) : 0, high = end < 0 ? begin / (begin - end) : 1;
    double begins = at + low * whole, ends = at + high * whole;
    /* phi1 - phi0, and their sum. Differences would cancel far away; here and below, for squared
     * sines and cosines, products stand in their place. */
    double turn = atan2(distance * (high - low) * whole, distance * distance + begins * ends);
    double sum = 2 * atan2(begins, distance) + turn;
    double across = (turn + sin(turn) * cos(sum)) * rk_ddot(normal, p) / distance;
    double along = sin(turn) * sin(sum) * rk_ddot(normal, t);
    return fmax(across + along, 0) / (2 * distance); /* the two nearly cancel at the horizon */
}
