/* A scene as JSON, for a renderer that is not raykit (tools/compare/cycles.py): everything that its
 * picture follows from, in world units and linear RGB. */
#ifndef RK_DRIVER_SCENE_JSON_H
#define RK_DRIVER_SCENE_JSON_H

#include "base/error.h"
#include "render/plan.h"

/* Writes
 *
 *     name, width, height
 *     camera     position; right, up, forward: unit; half_height of the picture plane at distance 1
 *     lens       focal_distance of the plane in focus, diameter; or null: a pinhole
 *     shutter    open, close; or null: everything is at rest
 *     materials  a list: kd, the diffuse reflectance
 *     objects    a list: vertices, three for each triangle; triangle_materials; path [a, b, c] as
 *                in rk_motion, or null
 *     lights     a list: position, edge01, edge02; radiance, of both sides
 *
 * False with an error if the scene or the options need more than that: spheres, environments,
 * smooth normals, textures, mirrors, glass, other lights, shading other than Lambert's normalized,
 * light without physical falloff, a focal sphere; or if the file cannot be written. */
bool rk_scene_json_write(const char *path, const rk_scene *scene, const rk_render_options *options,
                         rk_error *error);

#endif
