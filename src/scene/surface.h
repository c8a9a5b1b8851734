/* What stands at a hit: the point with its error bound, the normals, the material; and how a new
 * ray leaves from there without meeting the same surface again (Pharr, Jakob, Humphreys,
 * "Physically Based Rendering", section 3.9 of the third edition). */
#ifndef RK_SCENE_SURFACE_H
#define RK_SCENE_SURFACE_H

#include "base/sphere.h"
#include "base/triangle.h"
#include "scene/mesh.h"

typedef struct rk_surface {
    rk_vec3 point;
    rk_vec3 point_error; /* bounds |point - the exact point on the triangle| on each axis */
    rk_vec3 face_normal; /* unit, of the triangle's plane, turned to face the ray; a triangle
                            without area has the ray's opposite */
    rk_vec3 normal;      /* unit, for shading: interpolated where the mesh has normals, on the same
                            side as face_normal */
    rk_vec3 barycentric; /* weights of the triangle's corners, sum 1 */
    const rk_material *material;
    rk_triangle triangle; /* as the triangle test sees it; on a sphere its index is RK_MISS */
    rk_vec3 offset;       /* of what moves: where it stands, from where its triangle rests; or 0 */
} rk_surface;

/* Fills in the surface at a hit that `ray` found in `mesh`. */
void rk_surface_at(rk_surface *surface, const rk_mesh *mesh, const rk_ray *ray, const rk_hit *hit);

/* The same on a sphere made of `material`. */
void rk_surface_at_sphere(rk_surface *surface, const rk_sphere *sphere, const rk_material *material,
                          const rk_ray *ray, const rk_hit *hit);

/* Takes a surface of an object at rest to where the object stands, `offset` from there. The point's
 * error then bounds what this rounds and what moving a ray from there the other way rounds. */
void rk_surface_move(rk_surface *surface, rk_vec3 offset);

/* Returns the diffuse colour there: the material's kd, times its texture where it has one. `mesh`
 * is the one of the hit; a mesh without texture coordinates and a sphere show no texture. */
rk_vec3 rk_surface_textured_kd(const rk_surface *surface, const rk_mesh *mesh);
static inline rk_vec3 rk_surface_kd(const rk_surface *surface, const rk_mesh *mesh)
{
    return surface->material->kd_texture ? rk_surface_textured_kd(surface, mesh)
                                         : surface->material->kd;
}

/* The point to start a ray from that leaves into `direction` (any length): moved along the face
 * normal just past the error bound, to the side into which the ray leaves, and farther where
 * the triangle test itself is less exact than that. No epsilon to tune: the step follows from the
 * rounding errors, at any scale. The ray never meets the triangle that it leaves. */
rk_vec3 rk_surface_spawn(const rk_surface *surface, rk_vec3 direction);

/* Do rays into both directions start from the same point? It depends on the sides of the plane into
 * which they lead: as the normal says it, and as the triangle test does. */
static inline bool rk_surface_spawns_alike(const rk_surface *surface, rk_vec3 a, rk_vec3 b)
{
    float heading_a = rk_triangle_heading(&surface->triangle, a);
    float heading_b = rk_triangle_heading(&surface->triangle, b);
    return (rk_dot(surface->face_normal, a) < 0) == (rk_dot(surface->face_normal, b) < 0) &&
           (heading_a > 0) == (heading_b > 0) && (heading_a < 0) == (heading_b < 0);
}

#endif
