/* The scenes of the comparison. */
#ifndef RK_TESTS_PEERS_SCENES_H
#define RK_TESTS_PEERS_SCENES_H

#include "scene/scene.h"

/* A built-in scene by its name, or `room`, also `room:N`: the statue of N triangles, 203,000 unless
 * given, with camera and light in a closed box. False with an error for scenes that Embree would
 * not see whole. */
bool peers_scene(rk_scene *scene, const char *name, rk_error *error);

/* A mesh file, as drivers show it. The scene's name is the file's, without its folder. */
bool peers_mesh_scene(rk_scene *scene, const char *path, rk_error *error);

#endif
