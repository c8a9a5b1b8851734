/* The makers of the built-in scenes, declared here for all their files; not installed. A maker
 * fills a mesh in coordinates of its own, with faces counter-clockwise as seen from outside; an
 * arranger adds camera, lights, exact spheres and motion, where the scene has its own. */
#ifndef RK_SCENES_MAKERS_H
#define RK_SCENES_MAKERS_H

#include "scene/mesh.h"
#include "scene/scene.h"

/* The table in builtin.c gives the range of `number`; makers without a range ignore it. */
bool rk_builtin_make_triangle(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cube(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cube_textured(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cornell(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cornell_glass(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cornell_light(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_panes(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_glass(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_sphere(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_spheres(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_teapot(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_statue(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_cover(rk_mesh *mesh, uint32_t number, rk_error *error);
bool rk_builtin_make_moving(rk_mesh *mesh, uint32_t number, rk_error *error);

/* Four plates of different shininess under four lamps. */
bool rk_builtin_make_plates(rk_mesh *mesh, uint32_t number, rk_error *error);
void rk_builtin_arrange_plates(rk_scene *scene);

/* Lanterns over water, brighter than white. */
bool rk_builtin_make_lanterns(rk_mesh *mesh, uint32_t number, rk_error *error);
void rk_builtin_arrange_lanterns(rk_scene *scene);

/* Makes an empty mesh with memory for `quads` parallelograms. */
bool rk_builtin_init_quads(rk_mesh *mesh, uint32_t quads, uint32_t materials, rk_error *error);

/* Appends the parallelogram from `corner` along `a` and `b`, counter-clockwise as seen against a
 * cross b. */
void rk_builtin_put_quad(rk_mesh *mesh, rk_vec3 corner, rk_vec3 a, rk_vec3 b, uint16_t material);

/* No triangles, for scenes that consist of exact spheres. */
bool rk_builtin_make_nothing(rk_mesh *mesh, uint32_t number, rk_error *error);

/* These scenes have a camera and a light of their own. */
void rk_builtin_arrange_cornell(rk_scene *scene);
void rk_builtin_arrange_cornell_light(rk_scene *scene);
void rk_builtin_arrange_panes(rk_scene *scene);
void rk_builtin_arrange_glass(rk_scene *scene);
void rk_builtin_arrange_cover(rk_scene *scene);
void rk_builtin_arrange_moving(rk_scene *scene);

/* Glass of a colour and an opacity; a thickness of `thickness` world units filters white light to
 * `colour`, whose components are above 0. */
rk_material rk_builtin_glass(rk_vec3 colour, float alpha, float thickness);

/* Adds the exact sphere and the default light. */
void rk_builtin_arrange_spheres(rk_scene *scene);

/* Adds its spheres, with a camera and a light of their own. */
void rk_builtin_arrange_shininess(rk_scene *scene);

#endif
