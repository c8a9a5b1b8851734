/* The surface at a hit: the point with its error bound, the normals, the material; and how to spawn
 * a ray there that does not intersect the same surface again (Pharr, Jakob, Humphreys, "Physically
 * Based Rendering", section 3.9 of the third edition). */
#ifndef RK_SCENE_SURFACE_H
#define RK_SCENE_SURFACE_H

#include "base/sphere.h"
#include "base/triangle.h"
#include "scene/mesh.h"

typedef struct rk_surface {
    rk_vec3 point;
    rk_vec3 point_error; /* bounds |point - the exact point on the triangle| on each axis */
    rk_vec3 face_normal; /* unit, of the triangle's plane, facing the ray; of a triangle without
                            area, the opposite of the ray's direction */
    rk_vec3 normal;      /* unit, for shading: interpolated where the mesh has normals, on the same
                            side as face_normal */
    rk_vec3 barycentric; /* weights of the triangle's corners, sum 1 */
    const rk_material *material;
    rk_triangle triangle;  /* on a sphere its index is RK_MISS */
    rk_vec3 offset;        /* of a moving object from its position at rest; else 0 */
    const rk_mesh *smooth; /* whose normals were interpolated; NULL: flat, or a sphere */
} rk_surface;

/* Fills in the surface at a hit of `ray` on `mesh`. */
void rk_surface_at(rk_surface *surface, const rk_mesh *mesh, const rk_ray *ray, const rk_hit *hit);

/* The same on a sphere made of `material`. */
void rk_surface_at_sphere(rk_surface *surface, const rk_sphere *sphere, const rk_material *material,
                          const rk_ray *ray, const rk_hit *hit);

/* Translates a surface of an object at rest by the object's `offset`. The point's error then also
 * bounds the rounding of this sum and of moving a ray back by the offset. */
void rk_surface_move(rk_surface *surface, rk_vec3 offset);

/* Returns the diffuse colour: the material's kd, times its texture if it has one, times the colours
 * of the vertices if the mesh has these. `mesh` is the one that was hit; a mesh without texture
 * coordinates and a sphere show no texture, and a sphere shows no colours of vertices. */
rk_vec3 rk_surface_varying_kd(const rk_surface *surface, const rk_mesh *mesh);
static inline rk_vec3 rk_surface_kd(const rk_surface *surface, const rk_mesh *mesh)
{
    return surface->material->kd_texture || mesh->colours ? rk_surface_varying_kd(surface, mesh)
                                                          : surface->material->kd;
}

/* Returns the way from a point of the triangle, given by its weights, to where it is `distance`
 * from all edges; to the incentre of a triangle that is too narrow for that. The shortest way, but
 * in acute corners, where two edges have to be left. The area must not be 0. */
rk_dvec3 rk_surface_inset(const rk_triangle *triangle, rk_vec3 barycentric, double distance);

/* Returns alpha, times its texture if it has one, at the barycentric weights of a triangle. */
float rk_surface_alpha(const rk_material *material, const rk_mesh *mesh, uint32_t triangle,
                       rk_vec3 weights);

/* The origin of a ray spawned into `direction` (any length): moved along the face normal just past
 * the error bound, to the side of the direction, and farther where the plane would still be ahead.
 * No epsilon to tune: the step follows from the rounding errors, at any scale. The ray never hits
 * the triangle at which it starts. Close to an edge, within 6 error bounds, the origin is moved
 * away from it, too, so that it does not lie beyond a neighbour: where triangles meet at 45 degrees
 * or more and are wide enough, no ray leaves a closed room. */
rk_vec3 rk_surface_spawn(const rk_surface *surface, rk_vec3 direction);

/* Is the direction above the shading normal's plane, but below the face? A ray to a light there
 * would enter the mesh at once: faces near the edge of a smooth mesh's shadow would be black. */
static inline bool rk_surface_bulges_to(const rk_surface *surface, rk_vec3 direction)
{
    return surface->smooth && rk_dot(surface->face_normal, direction) <= 0 &&
           rk_dot(surface->normal, direction) > 0;
}

/* The origin of such a ray: above the face, where the smooth surface that the normals describe
 * would be (Hanika, "Hacking the shadow terminator", Ray Tracing Gems II, chapter 4, 2021); where
 * that is concave, as by rk_surface_spawn. */
rk_vec3 rk_surface_spawn_above(const rk_surface *surface, rk_vec3 direction);

/* The origin of a ray to a light, or anywhere else that light comes from. */
static inline rk_vec3 rk_surface_spawn_to_light(const rk_surface *surface, rk_vec3 direction)
{
    return rk_surface_bulges_to(surface, direction) ? rk_surface_spawn_above(surface, direction)
                                                    : rk_surface_spawn(surface, direction);
}

/* The origins of many rays spawned from one surface, which must stay as long as this. */
typedef struct rk_spawner {
    const rk_surface *surface;
    rk_triangle_plane plane;
    uint32_t known; /* bits: which of the origins have been computed */
    rk_vec3 origin[6];
} rk_spawner;

static inline void rk_spawner_start(rk_spawner *spawner, const rk_surface *surface)
{
    spawner->surface = surface;
    spawner->plane = rk_triangle_plane_of(&surface->triangle);
    spawner->known = 0;
}

/* As rk_surface_spawn, to the bit. The origin depends only on the side of the plane to which the
 * direction points, both by the normal and by the corners. */
static inline rk_vec3 rk_spawner_origin(rk_spawner *spawner, rk_vec3 direction)
{
    const double heading = rk_triangle_plane_heading(&spawner->plane, direction);
    const uint32_t side = (heading > 0) + 2u * (heading < 0) +
                          3u * (rk_dot(spawner->surface->face_normal, direction) < 0);
    if (!(spawner->known >> side & 1)) {
        spawner->known |= 1u << side;
        spawner->origin[side] = rk_surface_spawn(spawner->surface, direction);
    }
    return spawner->origin[side];
}

/* As rk_surface_spawn_to_light, to the bit. */
static inline rk_vec3 rk_spawner_origin_to_light(rk_spawner *spawner, rk_vec3 direction)
{
    return rk_surface_bulges_to(spawner->surface, direction)
               ? rk_surface_spawn_above(spawner->surface, direction)
               : rk_spawner_origin(spawner, direction);
}

#endif
