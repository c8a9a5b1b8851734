/* A light with an extent is many points, each with its own colour, direction and shadow. A sample
 * picks one of them and weights it, so that the mean over samples is the light of all points.
 * Beside the samples stands the same integral in closed form, for an unoccluded light.
 * Arvo, "Stratified sampling of spherical triangles", SIGGRAPH 1995; Van Oosterom, Strackee, "The
 * solid angle of a plane triangle", 1983; Lambert, "Photometria", 1760. */
#include "features/parallelogram_light.h"

/* The light relative to a surface point: corner 0 and the edges; edges that its kind does not have
 * are zero. */
typedef struct relative_light {
    rk_dvec3 corner, edge01, edge02;
} relative_light;

/* The two halves of a parallelogram as triangles: at corner 0, and at corner 3. */
typedef struct halves {
    rk_dvec3 far, back10, back20; /* corner 3 relative to the point, and its edges */
    double angle0, angle3;        /* solid angles */
} halves;

/* Contents, in the order of the chapter. */
static relative_light relative_to_point(const rk_light *light, rk_vec3 point);
static rk_dvec3 relative_point(const relative_light *rel, double x, double y);
static rk_vec3 position_at(const rk_light *light, rk_vec2 at);
static rk_vec3 colour_at(const rk_light *light, rk_vec2 at);
static double falloff_at(rk_light_kind kind, const relative_light *rel, rk_dvec3 d);
static double polygon_irradiance(const rk_dvec3 *corners, int count, rk_dvec3 n);
static int clip_at_horizon(rk_dvec3 *kept, const rk_dvec3 *corners, int count, rk_dvec3 n);
static double solid_angle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac);
static halves halves_of(const relative_light *rel);
static double edge_fraction(rk_dvec3 p, rk_dvec3 edge, double h);
static rk_vec2 spherical_triangle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac, double angle, rk_vec2 xi);
static rk_vec2 by_solid_angle(const relative_light *rel, const halves *h, rk_vec2 xi);
static float ratio(float unshadowed, float visible, float all);

static relative_light relative_to_point(const rk_light *light, rk_vec3 point)
{
    relative_light rel = {.corner = rk_dmadd(rk_widen(light->position), rk_widen(point), -1)};
    if (light->kind != RK_LIGHT_POINT)
        rel.edge01 = rk_widen(light->edge01);
    if (light->kind == RK_LIGHT_PARALLELOGRAM)
        rel.edge02 = rk_widen(light->edge02);
    return rel;
}

static rk_dvec3 relative_point(const relative_light *rel, double x, double y)
{
    return rk_dmadd(rk_dmadd(rel->corner, rel->edge01, x), rel->edge02, y);
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
    return light->position;
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
    return light->colours[0];
    end */
}

/* The weight of the light's point at `d` in the integral over uniform x and y: the light's
 * projected area or length, or 1 for a point, over the squared distance. */
static double falloff_at(rk_light_kind kind, const relative_light *rel, rk_dvec3 d)
{
    /* solution */
    double square = rk_ddot(d, d);
    if (!(square > 0))
        return 0;
    if (kind == RK_LIGHT_POINT)
        return 1 / square;
    double projected = kind == RK_LIGHT_SEGMENT
                           ? rk_dlength(rk_dcross(d, rel->edge01))
                           : fabs(rk_ddot(d, rk_dcross(rel->edge01, rel->edge02)));
    return projected / (square * sqrt(square));
    /* starter
    // Second step: 1 / r^2 for a point; length x sin' / r^2 or area x cos' / r^2 for the
    // others, which a cross product gives without angles. On the light itself, r = 0, it is 0.
    return 0;
    end */
}

/* --- In closed form --------------------------------------------------------------------------- */

float rk_light_irradiance(const rk_light *light, rk_vec3 point, rk_vec3 normal)
{
    relative_light rel = relative_to_point(light, point);
    rk_dvec3 n = rk_widen(normal), kept[8];
    double r = rk_dlength(rel.corner), cos_r = fmax(rk_ddot(n, rel.corner), 0);
    if (light->kind == RK_LIGHT_POINT)
        return r > 0 ? (float)(cos_r / (r * r * r)) : 0;
    if (light->kind == RK_LIGHT_SEGMENT)
        return (float)rk_light_segment_irradiance(rel.corner, rel.edge01, n);
    if (rk_ddot(rel.corner, rk_dcross(rel.edge01, rel.edge02)) == 0) /* edge-on, or no area */
        return 0;
    const rk_dvec3 corners[4] = {rel.corner, relative_point(&rel, 1, 0), relative_point(&rel, 1, 1),
                                 relative_point(&rel, 0, 1)};
    return (float)polygon_irradiance(kept, clip_at_horizon(kept, corners, 4, n), n);
}

/* Lambert: half the sum, over the edges, of the angle that the edge subtends times the cosine
 * between the surface normal and the normal of the plane through edge and point. */
static double polygon_irradiance(const rk_dvec3 *corners, int count, rk_dvec3 n)
{
    /* solution */
    double sum = 0;
    for (int i = 0; i < count; i++) {
        rk_dvec3 a = corners[i], b = corners[(i + 1) % count];
        rk_dvec3 across = rk_dcross(a, rk_dmadd(b, a, -1)); /* a x b, with less cancellation */
        double sine = rk_dlength(across);
        if (sine > 0)
            sum += atan2(sine, rk_ddot(a, b)) * rk_ddot(n, across) / sine;
    }
    return fabs(sum) / 2; /* the sign tells which side faces the point */
    /* starter
    // Third step: the angle by atan2, which is exact for small ones too. An edge that points at
    // the surface point subtends no angle.
    return 0;
    end */
}

/* Clips a polygon of `count` corners at the horizon n.p = 0, into `kept`, which has room for twice
 * as many; returns the number of corners kept (Sutherland and Hodgman, 1974). */
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
    // Third step: nothing is clipped yet.
    for (int i = 0; i < count; i++)
        kept[i] = corners[i];
    return count;
    end */
}

/* --- Uniform over the solid angle ------------------------------------------------------------- */

/* The solid angle of the triangle with corners a, a + ab and a + ac. */
static double solid_angle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac)
{
    /* solution */
    rk_dvec3 b = rk_dmadd(a, ab, 1), c = rk_dmadd(a, ac, 1);
    double la = rk_dlength(a), lb = rk_dlength(b), lc = rk_dlength(c);
    /* The volume from the edges: from the corners themselves it would cancel far away. */
    double volume = fabs(rk_ddot(a, rk_dcross(ab, ac)));
    if (volume == 0)
        return 0;
    return 2 * atan2(volume,
                     la * lb * lc + rk_ddot(a, b) * lc + rk_ddot(b, c) * la + rk_ddot(c, a) * lb);
    /* starter
    // Fourth step: the formula of Van Oosterom and Strackee. In the light's plane it is 0.
    return 0;
    end */
}

static halves halves_of(const relative_light *rel)
{
    halves h = {relative_point(rel, 1, 1), rk_dscale(rel->edge01, -1), rk_dscale(rel->edge02, -1),
                solid_angle(rel->corner, rel->edge01, rel->edge02), 0};
    h.angle3 = solid_angle(h.far, h.back10, h.back20);
    return h;
}

double rk_light_solid_angle(const rk_light *light, rk_vec3 point)
{
    relative_light rel = relative_to_point(light, point);
    halves h = halves_of(&rel);
    return h.angle0 + h.angle3;
}

/* Turns the direction p towards p + edge, by an angle whose half has the tangent h. Returns the
 * fraction of the edge at which the turned direction crosses it. */
static double edge_fraction(rk_dvec3 p, rk_dvec3 edge, double h)
{
    double fraction = 2 * h * rk_ddot(p, p) /
                      (rk_dlength(rk_dcross(p, edge)) * (1 - h * h) - 2 * h * rk_ddot(p, edge));
    return fmin(fmax(fraction, 0), 1);
}

/* Arvo's map, in tangents of half angles, which don't cancel in small triangles. First a point c'
 * on the edge from a to c is chosen such that the triangle a, b, c' has the fraction xi.x of the
 * solid angle; then xi.y chooses a point on the arc from b to c'. Returns the fractions y of ac and
 * x of the line from b to c'. */
static rk_vec2 spherical_triangle(rk_dvec3 a, rk_dvec3 ab, rk_dvec3 ac, double angle, rk_vec2 xi)
{
    /* solution */
    double half = (double)xi.x * angle / 2, la = rk_dlength(a);
    rk_dvec3 b = rk_dmadd(a, ab, 1), across_ab = rk_dcross(a, ab), across_ac = rk_dcross(a, ac);
    double h = sin(half) * (la * rk_dlength(b) + rk_ddot(a, b)) * rk_dlength(across_ac) /
               (cos(half) * fabs(rk_ddot(a, rk_dcross(ab, ac))) * la -
                sin(half) * rk_ddot(across_ab, across_ac));
    double y = edge_fraction(a, ac, h);

    rk_dvec3 c = rk_dmadd(a, ac, y), bc = rk_dmadd(rk_dscale(ab, -1), ac, y);
    double arc = rk_dlength(rk_dcross(b, bc)) / (rk_dlength(b) * rk_dlength(c) + rk_ddot(b, c));
    double sin2 = (double)xi.y * arc * arc / (1 + arc * arc); /* of half the angle from b */
    double x = edge_fraction(b, bc, sqrt(sin2 / (1 - sin2)));
    return (rk_vec2){(float)x, (float)y};
    /* starter
    // Fourth step: first y, from the tangent of half the angle between a and c'; then x.
    return (rk_vec2){0, 0};
    end */
}

/* Returns x and y on the light. One number serves twice: it chooses the half, and its position in
 * the chosen interval is uniform again. */
static rk_vec2 by_solid_angle(const relative_light *rel, const halves *h, rk_vec2 xi)
{
    /* solution */
    double chosen = (double)xi.x * (h->angle0 + h->angle3);
    bool first = chosen < h->angle0;
    xi.x = (float)(first ? chosen / h->angle0 : (chosen - h->angle0) / h->angle3);
    rk_vec2 at = first ? spherical_triangle(rel->corner, rel->edge01, rel->edge02, h->angle0, xi)
                       : spherical_triangle(h->far, h->back10, h->back20, h->angle3, xi);
    at = (rk_vec2){1 - at.x, at.x * at.y};
    return first ? at : (rk_vec2){1 - at.x, 1 - at.y};
    /* starter
    // Fourth step: choose a half by its solid angle, then a point of its triangle.
    return xi;
    end */
}

/* Below this solid angle the light looks like a dot or a line, and rounding errors of 2^-53 in the
 * directions to its corners would begin to displace samples. Samples over the area are unbiased as
 * well, and so small a light makes little noise. */
static const double smallest_solid_angle = 0x1p-32;

rk_light_sample rk_light_sample_at(const rk_light *light, rk_light_falloff falloff,
                                   rk_light_domain domain, rk_vec3 point, rk_vec2 xi)
{
    rk_vec2 at = xi;
    double weight = 1;
    /* solution */
    if (falloff == RK_FALLOFF_PHYSICAL) {
        relative_light rel = relative_to_point(light, point);
        weight = 0;
        if (domain == RK_LIGHT_DOMAIN_SOLID_ANGLE) {
            halves h = halves_of(&rel);
            weight = h.angle0 + h.angle3;
            if (weight > smallest_solid_angle)
                at = by_solid_angle(&rel, &h, xi);
        }
        if (!(weight > smallest_solid_angle))
            weight =
                falloff_at(light->kind, &rel, relative_point(&rel, (double)at.x, (double)at.y));
    }
    /* starter
    // Second step: with physical falloff, the weight is falloff_at. Fourth step: for samples
    // over the solid angle, it is that angle, if above the smallest one.
    end */
    return (rk_light_sample){position_at(light, at), rk_scale(colour_at(light, at), (float)weight)};
}

/* --- Fewer shadow rays ------------------------------------------------------------------------ */

static float ratio(float unshadowed, float visible, float all)
{
    /* solution */
    return all > 0 ? unshadowed * (visible / all) : 0;
    /* starter
    // Fifth step: the visible fraction; 0 / 0 is 0.
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
