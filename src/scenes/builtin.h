/* The makers of the built-in scenes' meshes, for scene.c and its suite; not installed. Each makes a
 * mesh in coordinates of its own, faces counter-clockwise as seen from outside. */
#ifndef RK_SCENES_BUILTIN_H
#define RK_SCENES_BUILTIN_H

#include "scene/mesh.h"
#include "scene/scene.h"

/* What `number` means, and its range, stands in scene.c's table; those without a range ignore it.
 */
bool rk_mesh_make_triangle(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cube(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cube_textured(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cornell(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cornell_glass(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cornell_light(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_panes(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_glass(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_sphere(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_spheres(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_teapot(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_statue(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_cover(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_mesh_make_moving(rk_mesh *mesh, uint32_t number, rk_error *error);

/* No triangles, for scenes of exact spheres alone. */
bool rk_mesh_make_nothing(rk_mesh *mesh, uint32_t number, rk_error *error);

/* These come with a camera and a light of their own. */
void rk_scene_arrange_cornell(rk_scene *scene);
void rk_scene_arrange_cornell_light(rk_scene *scene);
void rk_scene_arrange_panes(rk_scene *scene);
void rk_scene_arrange_glass(rk_scene *scene);
void rk_scene_arrange_cover(rk_scene *scene);
void rk_scene_arrange_moving(rk_scene *scene);

/* Glass of a colour and an opacity; `thickness` world units of it filter white light to `colour`,
 * whose components are above 0. */
rk_material rk_glass(rk_vec3 colour, float alpha, float thickness);

/* Adds the exact sphere and the default light. */
void rk_scene_arrange_spheres(rk_scene *scene);

/* Adds its spheres, with a camera and a light of their own. */
void rk_scene_arrange_shininess(rk_scene *scene);

void rk_scene_default_light(rk_scene *scene);

/* Puts a part with normals behind what is there, `scale` times as large, moved by `shift`, its
 * materials from number `material` on. The arrays are large enough; the counts say how far they are
 * filled. */
void rk_mesh_append(rk_mesh *mesh, const rk_mesh *part, rk_vec3 shift, float scale,
                    uint16_t material);

/* Vertices first .. first + count - 1 around an axis, right-handed; a ring of one is a pole. */
typedef struct rk_ring {
    uint32_t first, count;
} rk_ring;

/* Fills the band from ring a to ring b, farther along the axis, with as many triangles as the two
 * have edges, and returns the row after the last. */
uint32_t (*rk_ring_stitch(uint32_t (*row)[3], rk_ring a, rk_ring b))[3];

#endif
