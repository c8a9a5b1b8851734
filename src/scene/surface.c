#include "scene/surface.h"

#include "base/interpolate.h"

/* gamma_n = n eps / (1 - n eps) bounds the relative error of n roundings (Higham, "Accuracy and
 * Stability of Numerical Algorithms", 2002, section 3.1). */
static float gamma_bound(int n)
{
    const float eps = 0x1p-24f;
    return (float)n * eps / (1 - (float)n * eps);
}

/* Summed in double and rounded once: in float, 1 - u - v loses its digits near the edge opposite a,
 * and a distant corner would then move the point off the plane. */
static float point_on_axis(float a, float b, float c, const rk_hit *hit)
{
    double u = (double)hit->u, v = (double)hit->v;
    return (float)((1 - u - v) * (double)a + u * (double)b + v * (double)c);
}

static rk_vec3 facing(rk_vec3 normal, rk_vec3 side)
{
    return rk_dot(normal, side) < 0 ? rk_negate(normal) : normal;
}

/* In double, where neither the differences of a sliver nor the squares of a tiny triangle vanish. A
 * triangle without area has no normal: the result is 0. */
static rk_vec3 unit_normal(rk_vec3 a, rk_vec3 b, rk_vec3 c)
{
    double bx = (double)b.x - (double)a.x, cx = (double)c.x - (double)a.x;
    double by = (double)b.y - (double)a.y, cy = (double)c.y - (double)a.y;
    double bz = (double)b.z - (double)a.z, cz = (double)c.z - (double)a.z;
    double x = by * cz - bz * cy, y = bz * cx - bx * cz, z = bx * cy - by * cx;
    double length = sqrt(x * x + y * y + z * z);
    double scale = length > 0 ? 1 / length : 0;
    return rk_vec((float)(x * scale), (float)(y * scale), (float)(z * scale));
}

void rk_surface_at(rk_surface *surface, const rk_mesh *mesh, const rk_ray *ray, const rk_hit *hit)
{
    const uint32_t *corner = mesh->triangles[hit->triangle];
    rk_vec3 a = mesh->positions[corner[0]];
    rk_vec3 b = mesh->positions[corner[1]];
    rk_vec3 c = mesh->positions[corner[2]];
    rk_vec3 weights = rk_vec(1 - hit->u - hit->v, hit->u, hit->v);
    surface->triangle = (rk_triangle){a, b, c, hit->triangle};
    surface->offset = rk_vec(0, 0, 0);
    surface->point = rk_vec(point_on_axis(a.x, b.x, c.x, hit), point_on_axis(a.y, b.y, c.y, hit),
                            point_on_axis(a.z, b.z, c.z, hit));
    surface->barycentric = weights;
    surface->material = &mesh->materials[mesh->triangle_materials[hit->triangle]];
    /* Two roundings: to float, and of this sum, which also covers the errors in double. */
    rk_vec3 sizes = rk_max3(rk_abs3(surface->point),
                            rk_interpolate3(rk_abs3(a), rk_abs3(b), rk_abs3(c), rk_abs3(weights)));
    surface->point_error = rk_scale(sizes, gamma_bound(2));
    surface->face_normal = facing(unit_normal(a, b, c), rk_negate(ray->direction));
    if (!(rk_dot(surface->face_normal, surface->face_normal) > 0))
        surface->face_normal = rk_normalize(rk_negate(ray->direction));
    surface->normal = surface->face_normal;
    if (mesh->normals) {
        rk_vec3 smooth = rk_normalize(rk_interpolate3(
            mesh->normals[corner[0]], mesh->normals[corner[1]], mesh->normals[corner[2]], weights));
        if (rk_dot(smooth, smooth) > 0)
            surface->normal = facing(smooth, surface->face_normal);
    }
}

void rk_surface_at_sphere(rk_surface *surface, const rk_sphere *sphere, const rk_material *material,
                          const rk_ray *ray, const rk_hit *hit)
{
    /* The hit gives the direction from the centre; the point is moved back onto the sphere along
     * it. */
    rk_vec3 along = rk_madd(ray->origin, ray->direction, hit->t);
    rk_vec3 outward = rk_normalize(rk_sub(along, sphere->centre));
    /* There is no plane to leave: a triangle without edges is never ahead. */
    *surface = (rk_surface){.point = rk_madd(sphere->centre, outward, sphere->radius),
                            .material = material,
                            .triangle = {.index = RK_MISS}};
    /* Five roundings: of the unit vector (a sum of squares, a root, a quotient), of its product
     * with the radius, and of the sum; and as many again in the sphere test of the spawned ray. */
    rk_vec3 radius = rk_vec(sphere->radius, sphere->radius, sphere->radius);
    surface->point_error = rk_scale(rk_add(rk_abs3(sphere->centre), radius), gamma_bound(10));
    surface->face_normal = facing(outward, rk_negate(ray->direction));
    surface->normal = surface->face_normal;
}

void rk_surface_move(rk_surface *surface, rk_vec3 offset)
{
    rk_vec3 rest = surface->point;
    surface->point = rk_add(rest, offset);
    surface->offset = offset;
    /* The point is rounded here, and so is the origin of a spawned ray when the ray is moved back;
     * the third rounding is of this sum, and allows for the origin's distance from the point. */
    rk_vec3 sizes = rk_max3(rk_abs3(surface->point), rk_abs3(rest));
    surface->point_error = rk_madd(surface->point_error, sizes, gamma_bound(3));
}

rk_vec3 rk_surface_textured_kd(const rk_surface *surface, const rk_mesh *mesh)
{
    const rk_material *material = surface->material;
    if (!mesh->texcoords || surface->triangle.index == RK_MISS)
        return material->kd;
    const uint32_t *corner = mesh->triangles[surface->triangle.index];
    rk_vec2 uv = rk_interpolate2(mesh->texcoords[corner[0]], mesh->texcoords[corner[1]],
                                 mesh->texcoords[corner[2]], surface->barycentric);
    return rk_mul(material->kd, rk_texture_at(material->kd_texture, uv));
}

/* The next float away from zero in the direction of `step`. */
static float round_outward(float value, float step)
{
    return step > 0 ? nextafterf(value, INFINITY) : step < 0 ? nextafterf(value, -INFINITY) : value;
}

static rk_vec3 step_along(rk_vec3 point, rk_vec3 normal, float distance)
{
    rk_vec3 step = rk_scale(normal, distance);
    rk_vec3 start = rk_add(point, step);
    return rk_vec(round_outward(start.x, step.x), round_outward(start.y, step.y),
                  round_outward(start.z, step.z));
}

/* May the plane be ahead of the ray from `start`? Rays are moved back by the offset of a moving
 * object, with the same rounding; without an offset nothing is rounded. */
static bool plane_may_be_ahead(const rk_triangle_plane *plane, rk_vec3 point, double heading)
{
    double side = rk_triangle_plane_side(plane, point);
    return (heading > 0 && side <= 0) || (heading < 0 && side >= 0);
}

rk_vec3 rk_surface_spawn(const rk_surface *surface, rk_vec3 direction)
{
    const rk_triangle *triangle = &surface->triangle;
    rk_vec3 normal = facing(surface->face_normal, direction);
    /* The normal is rounded; for grazing directions the corners decide. */
    rk_triangle_plane plane = rk_triangle_plane_of(triangle);
    double heading = rk_triangle_plane_heading(&plane, direction);
    double normal_heading = rk_triangle_plane_heading(&plane, normal);
    if ((heading > 0 && normal_heading < 0) || (heading < 0 && normal_heading > 0))
        normal = rk_negate(normal);
    /* Past the point's error, and past two roundings of the edges: u and v are rounded, so close to
     * an edge the point may lie behind the neighbour's plane. */
    rk_vec3 edges = rk_add(rk_abs3(rk_sub(triangle->b, triangle->a)),
                           rk_abs3(rk_sub(triangle->c, triangle->a)));
    rk_vec3 error = rk_madd(surface->point_error, edges, gamma_bound(2));
    float distance = rk_dot(rk_abs3(normal), error);
    rk_vec3 start = step_along(surface->point, normal, distance);
    /* In slivers the normal's error grows with the ratio of length to width. A step of 2^-24 of the
     * triangle's size reaches that size after 24 doublings. */
    for (int i = 0; i < 24 && plane_may_be_ahead(&plane, rk_sub(start, surface->offset), heading);
         i++) {
        distance *= 2;
        start = step_along(surface->point, normal, distance);
    }
    return start;
}
