#include "scene/surface.h"

/* gamma_n = n eps / (1 - n eps) bounds the relative error of n roundings (Higham, "Accuracy and
 * Stability of Numerical Algorithms", 2002, section 3.1). */
static float gamma_bound(int n)
{
    const float eps = 0x1p-24f;
    return (float)n * eps / (1 - (float)n * eps);
}

static rk_vec3 weighted_sum(rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 weights)
{
    return rk_madd(rk_madd(rk_scale(a, weights.x), b, weights.y), c, weights.z);
}

static rk_vec3 facing(rk_vec3 normal, rk_vec3 side)
{
    return rk_dot(normal, side) < 0 ? rk_negate(normal) : normal;
}

void rk_surface_at(rk_surface *surface, const rk_mesh *mesh, const rk_ray *ray, const rk_hit *hit)
{
    const uint32_t *corner = mesh->triangles[hit->triangle];
    rk_vec3 a = mesh->positions[corner[0]];
    rk_vec3 b = mesh->positions[corner[1]];
    rk_vec3 c = mesh->positions[corner[2]];
    rk_vec3 weights = rk_vec(1 - hit->u - hit->v, hit->u, hit->v);
    surface->point = weighted_sum(a, b, c, weights);
    surface->barycentric = weights;
    surface->material = &mesh->materials[mesh->triangle_materials[hit->triangle]];
    /* A sum of three products of rounded weights: seven roundings at most. */
    rk_vec3 sizes = weighted_sum(rk_abs3(a), rk_abs3(b), rk_abs3(c), rk_abs3(weights));
    surface->point_error = rk_scale(sizes, gamma_bound(7));
    rk_vec3 normal = rk_normalize(rk_cross(rk_sub(b, a), rk_sub(c, a)));
    surface->face_normal = facing(normal, rk_negate(ray->direction));
    surface->normal = surface->face_normal;
    if (mesh->normals) {
        rk_vec3 smooth = rk_normalize(weighted_sum(
            mesh->normals[corner[0]], mesh->normals[corner[1]], mesh->normals[corner[2]], weights));
        if (rk_dot(smooth, smooth) > 0)
            surface->normal = facing(smooth, surface->face_normal);
    }
}

/* The next float away from zero in the direction of `step`. */
static float round_outward(float value, float step)
{
    return step > 0 ? nextafterf(value, INFINITY) : step < 0 ? nextafterf(value, -INFINITY) : value;
}

rk_vec3 rk_surface_leave(const rk_surface *surface, rk_vec3 direction)
{
    rk_vec3 normal = facing(surface->face_normal, direction);
    float distance = rk_dot(rk_abs3(normal), surface->point_error);
    rk_vec3 step = rk_scale(normal, distance);
    rk_vec3 start = rk_add(surface->point, step);
    return rk_vec(round_outward(start.x, step.x), round_outward(start.y, step.y),
                  round_outward(start.z, step.z));
}
