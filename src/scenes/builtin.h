/* The built-in scenes, which need no file. The table in builtin.c describes them. */
#ifndef RK_SCENES_BUILTIN_H
#define RK_SCENES_BUILTIN_H

#include "scene/scene.h"

/* Makes the scene of this name; some names take a number after a colon, as in statue:5000. False,
 * with an error that lists the names, when there is no such scene or the number is out of range. */
bool rk_builtin_scene(rk_scene *scene, const char *name, rk_error *error);

/* Writes one line for each scene, for --help: name, contents, default number. */
void rk_builtin_help(char *text, size_t size);

#endif
