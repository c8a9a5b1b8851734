/* A light with an extent is many points, each with its own colour, direction and shadow. A sample
 * picks one of them and weighs it, so that the mean over samples is the whole light. Beside that
 * stands the same integral in closed form, for a light that nothing hides.
 * Arvo, "Stratified sampling of spherical triangles", SIGGRAPH 1995; Van Oosterom, Strackee, "The
 * solid angle of a plane triangle", 1983; Lambert, "Photometria", 1760. */
#include "features/parallelogram_light.h"

/* The light as the point sees it: corner 0 from there, and the edges; those that its kind does not
 * have are zero. */
typedef struct sight {
    rk_dvec3 corner, edge01, edge02;
} sight;

/* The two halves of a parallelogram as triangles: at corner 0, and at corner 3. */
typedef struct halves {
    rk_dvec3 far, back10, back20; /* corner 3 as the point sees it, and the edges from there */
    double angle0, angle3;        /* solid angles */
} halves;

/* Contents, in the order of the chapter. */
static sight sight_of(const rk_light *light, rk_vec3 point);
static rk_dvec3 along(const sight *s, double x, double y);
static rk_vec3 position_at(const rk_light *light, rk_vec2 at);
static rk_vec3 colour_at(const rk_light *light, rk_vec2 at);
static double falloff_at(rk_light_kind kind, const sight *s, rk_dvec3 d);
static double polygon_irradiance(const rk_dvec3 *corners, int count, rk_dvec3 n);
static int clip_at_horizon(rk_dvec3 *kept, const rk_dvec3 *corners, int count, rk_dvec3 n);
static double solid_angle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac);
static halves halves_of(const sight *s);
static double share_of_edge(rk_dvec3 p, rk_dvec3 edge, double h);
static rk_vec2 spherical_triangle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac, double angle, rk_vec2 xi);
static rk_vec2 by_solid_angle(const sight *s, const halves *h, rk_vec2 xi);
static float ratio(float unshadowed, float visible, float all);

static sight sight_of(const rk_light *light, rk_vec3 point)
{
    sight s = {.corner = rk_dmadd(rk_widen(light->position), rk_widen(point), -1)};
    if (light->kind != RK_LIGHT_POINT)
        s.edge01 = rk_widen(light->edge01);
    if (light->kind == RK_LIGHT_PARALLELOGRAM)
        s.edge02 = rk_widen(light->edge02);
    return s;
}

static rk_dvec3 along(const sight *s, double x, double y)
{
    return rk_dmadd(rk_dmadd(s->corner, s->edge01, x), s->edge02, y);
}

/* --- A point of the light --------------------------------------------------------------------- */

static rk_vec3 position_at(const rk_light *light, rk_vec2 at)
{
    /* solution */
    rk_vec3 position = light->position;
    if (light->kind != RK_LIGHT_POINT)
        position = rk_madd(position, light->edge01, at.x);
    if (light->kind == RK_LIGHT_PARALLELOGRAM)
        position = rk_madd(position, light->edge02, at.y);
    return position;
    /* starter
    // First step: a segment has only the first edge, a point none.
    return rk_scale(light->position, NAN);
    end */
}

static rk_vec3 colour_at(const rk_light *light, rk_vec2 at)
{
    /* solution */
    const rk_vec3 *c = light->colours;
    if (light->kind == RK_LIGHT_POINT)
        return c[0];
    rk_vec3 low = rk_mix(c[0], c[1], at.x);
    return light->kind == RK_LIGHT_SEGMENT ? low : rk_mix(low, rk_mix(c[2], c[3], at.x), at.y);
    /* starter
    // First step: linear in x between corners 0 and 1, and between 2 and 3; then linear in y.
    return rk_vec(0, 0, 0);
    end */
}

/* What a point at `d` of the light weighs in the integral when x and y are spread evenly: all of
 * its area, length or nothing, as it is seen from there, over the distance squared. */
static double falloff_at(rk_light_kind kind, const sight *s, rk_dvec3 d)
{
    /* solution */
    double square = rk_ddot(d, d);
    if (!(square > 0))
        return 0;
    if (kind == RK_LIGHT_POINT)
        return 1 / square;
    double seen = kind == RK_LIGHT_SEGMENT ? rk_dlength(rk_dcross(d, s->edge01))
                                           : fabs(rk_ddot(d, rk_dcross(s->edge01, s->edge02)));
    return seen / (square * sqrt(square));
    /* starter
    // Second step: 1 / r^2 for a point; length x sin' / r^2 or area x cos' / r^2 for the others,
    // which a cross product gives without any angle. On the light itself, r = 0, it is 0.
    return 0;
    end */
}

/* --- In closed form --------------------------------------------------------------------------- */

float rk_light_irradiance(const rk_light *light, rk_vec3 point, rk_vec3 normal)
{
    sight s = sight_of(light, point);
    rk_dvec3 n = rk_widen(normal), kept[8];
    double r = rk_dlength(s.corner), cos_r = fmax(rk_ddot(n, s.corner), 0);
    if (light->kind == RK_LIGHT_POINT)
        return r > 0 ? (float)(cos_r / (r * r * r)) : 0;
    if (light->kind == RK_LIGHT_SEGMENT)
        return (float)rk_light_segment_irradiance(s.corner, s.edge01, n);
    if (rk_ddot(s.corner, rk_dcross(s.edge01, s.edge02)) == 0) /* edge-on, or no area */
        return 0;
    const rk_dvec3 corners[4] = {s.corner, along(&s, 1, 0), along(&s, 1, 1), along(&s, 0, 1)};
    return (float)polygon_irradiance(kept, clip_at_horizon(kept, corners, 4, n), n);
}

/* Lambert: half the sum, over the edges, of the angle under which the edge is seen times the cosine
 * between the surface's normal and that of the plane through edge and point. */
static double polygon_irradiance(const rk_dvec3 *corners, int count, rk_dvec3 n)
{
    /* solution */
    double sum = 0;
    for (int i = 0; i < count; i++) {
        rk_dvec3 a = corners[i], b = corners[(i + 1) % count];
        rk_dvec3 across = rk_dcross(a, rk_dmadd(b, a, -1)); /* a x b, of which less cancels */
        double sine = rk_dlength(across);
        if (sine > 0)
            sum += atan2(sine, rk_ddot(a, b)) * rk_ddot(n, across) / sine;
    }
    return fabs(sum) / 2; /* its sign tells from which side the light is seen */
    /* starter
    // Third step: the angle by atan2, which is exact for small ones too. An edge that points at
    // the surface point is seen under no angle.
    return 0;
    end */
}

/* Cuts off what of the polygon of `count` corners lies below the horizon n.p = 0, into `kept` with
 * room for twice as many; returns how many are left (Sutherland and Hodgman, 1974). */
static int clip_at_horizon(rk_dvec3 *kept, const rk_dvec3 *corners, int count, rk_dvec3 n)
{
    /* solution */
    int left = 0;
    for (int i = 0; i < count; i++) {
        rk_dvec3 a = corners[i], b = corners[(i + 1) % count];
        double above_a = rk_ddot(n, a), above_b = rk_ddot(n, b);
        if (above_a >= 0)
            kept[left++] = a;
        if ((above_a >= 0) != (above_b >= 0)) {
            double at = above_a / (above_a - above_b);
            kept[left++] = rk_dmadd(rk_dmadd(a, a, -at), b, at);
        }
    }
    return left;
    /* starter
    // Third step: nothing is cut off yet.
    for (int i = 0; i < count; i++)
        kept[i] = corners[i];
    return count;
    end */
}

/* --- Evenly over the directions --------------------------------------------------------------- */

/* Of the triangle with corners a, a + ab and a + ac. */
static double solid_angle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac)
{
    /* solution */
    rk_dvec3 b = rk_dmadd(a, ab, 1), c = rk_dmadd(a, ac, 1);
    double la = rk_dlength(a), lb = rk_dlength(b), lc = rk_dlength(c);
    /* The volume by its edges: that of the corners themselves cancels when they are far. */
    double volume = fabs(rk_ddot(a, rk_dcross(ab, ac)));
    return 2 * atan2(volume,
                     la * lb * lc + rk_ddot(a, b) * lc + rk_ddot(b, c) * la + rk_ddot(c, a) * lb);
    /* starter
    // Fourth step: the formula of Van Oosterom and Strackee.
    return 0;
    end */
}

static halves halves_of(const sight *s)
{
    halves h = {along(s, 1, 1), rk_dscale(s->edge01, -1), rk_dscale(s->edge02, -1),
                solid_angle(s->corner, s->edge01, s->edge02), 0};
    h.angle3 = solid_angle(h.far, h.back10, h.back20);
    return h;
}

double rk_light_solid_angle(const rk_light *light, rk_vec3 point)
{
    sight s = sight_of(light, point);
    halves h = halves_of(&s);
    return h.angle0 + h.angle3;
}

/* How far along the edge from p to p + edge a direction meets it that is turned away from p by the
 * angle whose half has the tangent h. */
static double share_of_edge(rk_dvec3 p, rk_dvec3 edge, double h)
{
    double share = 2 * h * rk_ddot(p, p) /
                   (rk_dlength(rk_dcross(p, edge)) * (1 - h * h) - 2 * h * rk_ddot(p, edge));
    return fmin(fmax(share, 0), 1);
}

/* Arvo's map, in tangents of half angles, which don't cancel in small triangles. First a point c'
 * of the edge from a to c cuts off a triangle a, b, c' of the share xi.x of the solid angle; then
 * xi.y chooses on the arc from b to c'. Returns the shares y of ac and x of the line from b to c'.
 */
static rk_vec2 spherical_triangle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac, double angle, rk_vec2 xi)
{
    /* solution */
    double half = (double)xi.x * angle / 2, la = rk_dlength(a);
    rk_dvec3 b = rk_dmadd(a, ab, 1), across_ab = rk_dcross(a, ab), across_ac = rk_dcross(a, ac);
    double h = sin(half) * (la * rk_dlength(b) + rk_ddot(a, b)) * rk_dlength(across_ac) /
               (cos(half) * fabs(rk_ddot(a, rk_dcross(ab, ac))) * la -
                sin(half) * rk_ddot(across_ab, across_ac));
    double y = share_of_edge(a, ac, h);

    rk_dvec3 c = rk_dmadd(a, ac, y), bc = rk_dmadd(rk_dscale(ab, -1), ac, y);
    double arc = rk_dlength(rk_dcross(b, bc)) / (rk_dlength(b) * rk_dlength(c) + rk_ddot(b, c));
    double sin2 = (double)xi.y * arc * arc / (1 + arc * arc); /* of half the angle from b */
    double x = share_of_edge(b, bc, sqrt(sin2 / (1 - sin2)));
    return (rk_vec2){(float)x, (float)y};
    /* starter
    // Fourth step: first y, from the tangent of half the angle between a and c'; then x.
    return (rk_vec2){0, 0};
    end */
}

/* Returns x and y on the light. One number serves twice: it chooses the half, and where it lies
 * between the ends of its choice is as even as before. */
static rk_vec2 by_solid_angle(const sight *s, const halves *h, rk_vec2 xi)
{
    /* solution */
    double chosen = (double)xi.x * (h->angle0 + h->angle3);
    bool first = chosen < h->angle0;
    xi.x = (float)(first ? chosen / h->angle0 : (chosen - h->angle0) / h->angle3);
    rk_vec2 at = first ? spherical_triangle(s->corner, s->edge01, s->edge02, h->angle0, xi)
                       : spherical_triangle(h->far, h->back10, h->back20, h->angle3, xi);
    at = (rk_vec2){1 - at.x, at.x * at.y};
    return first ? at : (rk_vec2){1 - at.x, 1 - at.y};
    /* starter
    // Fourth step: a half by its share of the solid angle, then a point of its triangle.
    return xi;
    end */
}

/* Below this solid angle the light is a dot or a line to the point. Rounding errors of 2^-53 in the
 * directions to its corners would begin to show in where the samples lie on it. Spread over the
 * area they are unbiased as well, and nothing this small can make much noise. */
static const double smallest_solid_angle = 0x1p-32;

rk_light_sample rk_light_sample_at(const rk_light *light, rk_light_falloff falloff,
                                   rk_light_domain domain, rk_vec3 point, rk_vec2 xi)
{
    rk_vec2 at = xi;
    double weight = 1;
    /* solution */
    if (falloff == RK_FALLOFF_PHYSICAL) {
        sight s = sight_of(light, point);
        halves h = {0};
        if (domain == RK_LIGHT_DOMAIN_SOLID_ANGLE)
            h = halves_of(&s);
        weight = h.angle0 + h.angle3;
        if (weight > smallest_solid_angle)
            at = by_solid_angle(&s, &h, xi);
        else
            weight = falloff_at(light->kind, &s, along(&s, (double)at.x, (double)at.y));
    }
    /* starter
    // Second step: with physical falloff, the weight is falloff_at. Fourth step: or, over the solid
    // angle, that angle, if it is not below the smallest one.
    end */
    return (rk_light_sample){position_at(light, at), rk_scale(colour_at(light, at), (float)weight)};
}

/* --- Fewer shadow rays ------------------------------------------------------------------------ */

static float ratio(float unshadowed, float visible, float all)
{
    /* solution */
    return all > 0 ? unshadowed * (visible / all) : 0;
    /* starter
    // Fifth step: the share of all that is visible; 0 / 0 is 0.
    return unshadowed;
    end */
}

rk_vec3 rk_light_ratio(rk_vec3 unshadowed, rk_vec3 visible, rk_vec3 all)
{
    return rk_vec(ratio(unshadowed.x, visible.x, all.x), ratio(unshadowed.y, visible.y, all.y),
                  ratio(unshadowed.z, visible.z, all.z));
}

bool rk_light_early_out(uint32_t round, uint32_t visible)
{
    /* solution */
    return round > 0 && (visible == 0 || visible == round);
    /* starter
    // Fifth step: do all agree?
    return false;
    end */
}
