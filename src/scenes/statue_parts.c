/* The statue's smooth tubes: a part's spine, its length and girth, and the points of a ring. Source
 * of the spline: de Boor, "A practical guide to splines", 1978 (uniform cubic case). */
#include "scenes/statue_parts.h"

/* --- arithmetic ------------------------------------------------------------------------------ */

typedef rk_statue_vec vec;

static vec along(vec a, vec b, double s)
{
    return (vec){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double length(vec a)
{
    return sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
}

static vec unit(vec a)
{
    return along((vec){0, 0, 0}, a, 1 / length(a));
}

/* Sine and cosine of an angle in turns from 0 to 1: libm's may differ in the last bit between
 * machines. Taylor series on an eighth of a turn, with errors below 1e-11. */
static void sine_cosine(double turns, double *sine, double *cosine)
{
    int quarter = (int)(4 * turns + 0.5);
    double a = (turns - 0.25 * quarter) * 6.28318530717958647692, q = a * a;
    double s = a * (1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110)))));
    double c =
        1 - q / 2 * (1 - q / 12 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132)))));
    *sine = quarter % 2 ? c : s, *cosine = quarter % 2 ? s : c;
    if (quarter == 2 || quarter == 3)
        *sine = -*sine;
    if (quarter == 1 || quarter == 2)
        *cosine = -*cosine;
}

/* --- the spine ------------------------------------------------------------------------------- */

/* The spine's position and direction at a key, and the oval's radii. */
typedef struct section {
    vec centre, direction;
    double wide, thin;
} section;

/* Keys beyond the ends reflect the inner ones, so that the spline starts and ends on a key. */
static double key_value(const rk_statue_shape *s, int i, int member)
{
    int last = (int)s->key_count - 1;
    if (i < 0)
        return 2 * key_value(s, 0, member) - key_value(s, -i, member);
    if (i > last)
        return 2 * key_value(s, last, member) - key_value(s, 2 * last - i, member);
    const rk_statue_key *k = &s->keys[i];
    const float members[5] = {k->x, k->y, k->z, k->wide, k->thin};
    return (double)members[member];
}

static section section_at(const rk_statue_part *part, double at)
{
    const rk_statue_shape *s = &rk_statue_shapes[part->index];
    int i = (int)fmin(floor(at), s->key_count - 2.0);
    double t = at - i, r = 1 - t;
    const double value[4] = {r * r * r / 6, (4 + 3 * t * t * (t - 2)) / 6,
                             (4 + 3 * r * r * (r - 2)) / 6, t * t * t / 6};
    const double slope[4] = {-r * r / 2, t * (1.5 * t - 2), -r * (1.5 * r - 2), t * t / 2};
    double v[5] = {0}, d[5] = {0};
    for (int member = 0; member < 5; member++)
        for (int k = 0; k < 4; k++) {
            double at_key = key_value(s, i - 1 + k, member);
            v[member] += value[k] * at_key, d[member] += slope[k] * at_key;
        }
    return (section){{v[0], v[1], v[2]}, unit((vec){d[0], d[1], d[2]}), v[3], v[4]};
}

/* The radii shrink to 0 at both ends like a sphere's, over two thirds of a key. */
static double closing(const rk_statue_part *part, double at)
{
    double end = fmin(at, part->key_count - 1 - at) * 1.5;
    return end >= 1 ? 1 : sqrt(end * (2 - end));
}

/* An oval's circumference (Ramanujan 1914). */
static double oval_girth(double a, double b)
{
    return RK_PI_DOUBLE * (3 * (a + b) - sqrt((3 * a + b) * (a + 3 * b)));
}

static double key_of_step(const rk_statue_part *part, double step)
{
    return step * (part->key_count - 1) / RK_STATUE_STEPS;
}

static int least_axis(const rk_statue_shape *s)
{
    const rk_statue_key *a = &s->keys[0], *b = &s->keys[s->key_count - 1];
    float x = fabsf(a->x - b->x), y = fabsf(a->y - b->y), z = fabsf(a->z - b->z);
    return z <= x && z <= y ? 2 : x <= y ? 0 : 1;
}

void rk_statue_measure(rk_statue_part *part, uint32_t index)
{
    const rk_statue_shape *s = &rk_statue_shapes[index];
    *part = (rk_statue_part){.index = index,
                             .key_count = s->key_count,
                             .material = s->material,
                             .least_axis = least_axis(s)};
    section before = section_at(part, 0);
    double closed_before = 0;
    for (int i = 1; i <= RK_STATUE_STEPS; i++) {
        section here = section_at(part, key_of_step(part, i));
        double closed = i == RK_STATUE_STEPS ? 0 : closing(part, key_of_step(part, i));
        double along_spine = length(along(here.centre, before.centre, -1));
        double outwards = here.wide * closed - before.wide * closed_before;
        double step = sqrt(along_spine * along_spine + outwards * outwards);
        part->arc_length[i] = part->arc_length[i - 1] + step;
        part->area += step * oval_girth(here.wide * closed, here.thin * closed);
        before = here, closed_before = closed;
    }
    part->length = part->arc_length[RK_STATUE_STEPS];
}

void rk_statue_locate(const rk_statue_part *part, double fraction, double *at, double *girth)
{
    double wanted = fraction * part->length;
    int low = 0, high = RK_STATUE_STEPS; /* arc_length[low] <= wanted < arc_length[high] */
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (part->arc_length[middle] <= wanted)
            low = middle;
        else
            high = middle;
    }
    double t = (wanted - part->arc_length[low]) / (part->arc_length[high] - part->arc_length[low]);
    *at = key_of_step(part, low + t);
    section here = section_at(part, *at);
    double closed = closing(part, *at);
    *girth = oval_girth(here.wide * closed, here.thin * closed);
}

/* --- points ---------------------------------------------------------------------------------- */

/* Picture coordinates have x to the right and z towards the viewer; half a turn about y makes them
 * the world's. */
static rk_vec3 to_world(vec p)
{
    return rk_vec((float)-p.x, (float)p.y, (float)-p.z);
}

rk_vec3 rk_statue_pole(const rk_statue_part *part, int end)
{
    return to_world(section_at(part, end ? part->key_count - 1 : 0).centre);
}

enum { arcs = 64 };

/* The oval's arc length up to each of 64 equal parts of a turn. */
static void measure_oval(double a, double b, double arc_length[arcs + 1])
{
    double x = a, y = 0;
    arc_length[0] = 0;
    for (int i = 1; i <= arcs; i++) {
        double sine, cosine;
        sine_cosine((double)i / arcs, &sine, &cosine);
        double dx = a * cosine - x, dy = b * sine - y;
        arc_length[i] = arc_length[i - 1] + sqrt(dx * dx + dy * dy);
        x = a * cosine, y = b * sine;
    }
}

void rk_statue_ring(const rk_statue_part *part, double at, rk_vec3 *points, uint32_t count)
{
    section here = section_at(part, at);
    double closed = closing(part, at), a = here.wide * closed, b = here.thin * closed;
    const vec axis = {part->least_axis == 0, part->least_axis == 1, part->least_axis == 2};
    vec side = unit(cross(axis, here.direction)), across = cross(here.direction, side);
    double arc_length[arcs + 1];
    measure_oval(a, b, arc_length);
    int arc = 0;
    for (uint32_t i = 0; i < count; i++) {
        double wanted = arc_length[arcs] * i / count, sine, cosine;
        while (arc_length[arc + 1] < wanted)
            arc++;
        double turns =
            (arc + (wanted - arc_length[arc]) / (arc_length[arc + 1] - arc_length[arc])) / arcs;
        sine_cosine(turns, &sine, &cosine);
        vec p = along(along(here.centre, side, a * cosine), across, b * sine);
        /* The oval's normal; on a fin it points across, on a round stem along the radius. */
        vec outward = unit(along(along((vec){0, 0, 0}, side, b * cosine), across, a * sine));
        double height =
            rk_statue_relief_at(rk_statue_shapes[part->index].relief, p, at, turns, here.thin);
        points[i] = to_world(along(p, outward, height * closed));
    }
}
