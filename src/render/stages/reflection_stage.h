/* Perfect mirrors: one reflected ray per shading point; not installed. */
#ifndef RK_RENDER_STAGES_REFLECTION_STAGE_H
#define RK_RENDER_STAGES_REFLECTION_STAGE_H

#include "render/sample_pass.h"
#include "render/shading_point.h"

/* Does the surface reflect, and has the path bounces left? */
bool rk_is_specular(const rk_shading_point *point);

/* Returns the direction reflected about the shading normal, or about the face normal if the former
 * leads into the surface. */
rk_vec3 rk_reflected_direction(const rk_shading_point *point);

/* Pushes the reflected ray of a specular point. */
void rk_spawn_reflection(const rk_shading_point *point, rk_path_batch *reflected);

/* Fills `reflected` with the reflected rays of all specular points. */
void rk_reflection_stage(const rk_sample_pass *pass, const rk_shading_points *points,
                         rk_path_batch *reflected);

#endif
