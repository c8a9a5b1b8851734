/* A reflected ray goes through a random point of a disk around the reflected direction. A basis
 * made from one vector orients the disk; a map from the unit square fills it uniformly. Directions
 * into the surface are discarded, or the disk's points are moved into the part above it.
 * Cook, Porter, Carpenter, "Distributed ray tracing", SIGGRAPH 1984; Duff and others, "Building an
 * orthonormal basis, revisited", JCGT 6(1), 2017; Shirley and Chiu, "A low distortion map between
 * disk and square", JGT 2(3), 1997. */
#include "features/glossy_reflection.h"

/* Contents, in the order of the chapter. */
static rk_vec2 polar(float radius, float angle);
static rk_vec2 concentric(float x, float y);
static double segment_beyond(double d);
static double segment_at(double fraction);

/* --- The basis -------------------------------------------------------------------------------- */

/* The x and y axes under the smallest rotation that takes the z axis, or its opposite if that is
 * nearer, to w. So |sign + w.z| is at least 1, and nothing is divided by nearly 0. */
void rk_basis_of(rk_vec3 w, rk_vec3 *u, rk_vec3 *v)
{
    /* solution */
    float sign = copysignf(1, w.z);
    float a = -1 / (sign + w.z), b = w.x * w.y * a;
    *u = rk_vec(1 + sign * w.x * w.x * a, sign * b, -sign * w.x);
    *v = rk_vec(b, sign + w.y * w.y * a, -w.y);
    /* starter
    // First step: two unit vectors at right angles to w and to each other, for every w.
    *u = *v = rk_vec(0, 0, 0);
    end */
}

/* --- Points of the disk ----------------------------------------------------------------------- */

rk_vec2 rk_disk_at(rk_disk_map map, rk_vec2 xi)
{
    if (map == RK_DISK_CONCENTRIC)
        return concentric(2 * xi.x - 1, 2 * xi.y - 1);
    /* solution */
    return polar(sqrtf(xi.x), 2 * RK_PI * xi.y);
    /* starter
    // Second step: a ring twice as far out is twice as long, and gets twice as many points.
    return (rk_vec2){0, 0};
    end */
}

static rk_vec2 polar(float radius, float angle)
{
    return (rk_vec2){radius * cosf(angle), radius * sinf(angle)};
}

/* From the square [-1, 1)^2: the larger coordinate becomes the radius, the ratio of the two the
 * angle. */
static rk_vec2 concentric(float x, float y)
{
    /* solution */
    if (fabsf(x) > fabsf(y))
        return polar(x, RK_PI / 4 * (y / x));
    /* Above and below with both axes swapped, because pi / 2 - phi would be rounded. */
    rk_vec2 swapped = y == 0 ? (rk_vec2){0, 0} : polar(y, RK_PI / 4 * (x / y));
    return (rk_vec2){swapped.y, swapped.x};
    /* starter
    // Second step: the larger coordinate chooses the sector; begin with those of +x and -x.
    return (rk_vec2){0, 0};
    end */
}

/* --- Directions ------------------------------------------------------------------------------- */

float rk_glossy_radius(float shininess)
{
    /* solution */
    return 0.5f / rk_max(shininess, 0.5f);
    /* starter
    // Third step: inversely proportional to the shininess.
    return NAN;
    end */
}

rk_glossy_disk rk_glossy_disk_of(rk_vec3 reflected, float radius, rk_vec3 face_normal)
{
    rk_glossy_disk disk = {.w = reflected, .radius = radius, .face_normal = face_normal};
    rk_basis_of(reflected, &disk.u, &disk.v);
    return disk;
}

bool rk_glossy_direction(const rk_glossy_disk *disk, rk_vec2 at, rk_vec3 *direction)
{
    /* solution */
    float x = disk->radius * at.x, y = disk->radius * at.y;
    rk_vec3 to = rk_madd(rk_madd(disk->w, disk->u, x), disk->v, y);
    /* Its length is known, because the axes are at right angles. */
    *direction = rk_scale(to, 1 / sqrtf(1 + x * x + y * y));
    return rk_dot(*direction, disk->face_normal) > 0;
    /* starter
    // Third step: w + x u + y v with (x, y) = radius times the point, normalized.
    *direction = rk_vec(0, 0, 0);
    return false;
    end */
}

/* --- The part below the surface --------------------------------------------------------------- */

/* The fraction of the unit disk that a line cuts off, d from the centre: a segment, which is a
 * sector of the angle 2 acos(d) minus a triangle. */
static double segment_beyond(double d)
{
    /* solution */
    return (acos(d) - d * sqrt(1 - d * d)) / RK_PI_DOUBLE;
    /* starter
    // Fourth step: the sector's area, and the triangle's; the disk's is pi.
    return -1;
    end */
}

/* The face's plane intersects the disk in a line, d radii from the centre, which is above it. */
float rk_glossy_fraction_above(const rk_glossy_disk *disk)
{
    /* solution */
    /* Of the centre above the plane; a rounding may take it below. */
    float height = rk_max(rk_dot(disk->w, disk->face_normal), 0);
    float reach = disk->radius * rk_length(rk_cross(disk->w, disk->face_normal));
    if (height >= reach)
        return 1;
    return (float)(1 - segment_beyond((double)height / (double)reach));
    /* starter
    // Fourth step: how high above the plane is the centre, and how much lower is the lowest
    // point?
    return -1;
    end */
}

/* --- Points above the surface ----------------------------------------------------------------- */

/* Returns the d of the line that cuts off this fraction of the disk: the inverse of segment_beyond,
 * by Newton's method for half the sector's angle. */
static double segment_at(double fraction)
{
    if (fraction > 0.5)
        return -segment_at(1 - fraction);
    /* Small segments have the area 2/3 angle^3, and larger ones a little less. From there on the
     * method converges from above, because the area is convex; three steps suffice for a float. */
    double angle = cbrt(1.5 * RK_PI_DOUBLE * fraction);
    for (int i = 0; i < 3 && angle > 0; i++) {
        double s = sin(angle), c = cos(angle);
        angle -= (angle - s * c - RK_PI_DOUBLE * fraction) / (2 * s * s);
    }
    return cos(angle);
}

/* The point moves up until the segment beyond it has shrunk by the fraction above; its place on the
 * chord, between the two ends on the rim, stays. So areas shrink everywhere alike. */
rk_vec2 rk_glossy_point_above(const rk_glossy_disk *disk, float fraction_above, rk_vec2 at)
{
    if (fraction_above == 1)
        return at;
    /* solution */
    double x = (double)rk_dot(disk->u, disk->face_normal);
    double y = (double)rk_dot(disk->v, disk->face_normal);
    double length = sqrt(x * x + y * y);
    x /= length; /* (x, y) is straight up, in the disk's axes */
    y /= length;
    double up = fmin(fmax((double)at.x * x + (double)at.y * y, -1), 1);
    double chord = sqrt(1 - up * up), along = (double)at.y * x - (double)at.x * y;
    double to = segment_at((double)fraction_above * segment_beyond(up));
    /* A rounding may take a point of the rim out of the disk, beyond the ends of its chord. */
    double place = chord > 0 ? fmin(fmax(along / chord, -1), 1) : 0;
    double across = place * sqrt(1 - to * to);
    return (rk_vec2){(float)(to * x - across * y), (float)(to * y + across * x)};
    /* starter
    // Fifth step: find the direction in the disk that leads up, and split the point into a part
    // along it and a part across.
    (void)segment_at;
    return at;
    end */
}
