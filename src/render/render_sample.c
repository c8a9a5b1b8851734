/* A sample is a camera ray per pixel and all that follows from it; with motion blur it is taken
 * again in further time passes, and the mean of these counts. */
#include "render/render_sample.h"

#include "render/stages/camera_stage.h"
#include "render/time_passes.h"

/* False if no pixel of the tile belongs to the pass. */
static bool render_pass(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                        rk_film *film)
{
    rk_path_batch *camera = &rk_path_queue_push(&workspace->queue)->paths;
    if (r->plan.motion_blur)
        rk_time_pass_start(pass);
    rk_camera_stage(r, pass, camera);
    bool any = camera->rays.count > 0;
    rk_trace_paths(r, pass, workspace, film);
    return any;
}

/* Further time passes stop when no pixel needs a time. */
bool rk_render_sample(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                      rk_film *film)
{
    rk_film before;
    if (pass->time_passes > 1)
        before = *film;
    pass->time_pass = 0;
    bool any = render_pass(r, pass, workspace, film), more = any;
    for (pass->time_pass = 1; more && pass->time_pass < pass->time_passes; pass->time_pass++)
        more = render_pass(r, pass, workspace, film);
    if (pass->time_passes > 1)
        rk_time_passes_average(pass, &before, film);
    return any;
}
