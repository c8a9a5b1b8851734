/* Normals as colours, in the renderer; not installed. */
#ifndef RK_RENDER_STAGES_NORMALS_STAGE_H
#define RK_RENDER_STAGES_NORMALS_STAGE_H

#include "features/normals.h"
#include "render/shading_point.h"

/* The colour that the point's surface shows, on the side of the viewer. */
rk_vec3 rk_normals_shown_at(rk_normals_shown shown, const rk_surface *surface);

#endif
