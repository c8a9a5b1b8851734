/* Traces paths from the camera to their ends; not installed. */
#ifndef RK_RENDER_PATHS_H
#define RK_RENDER_PATHS_H

#include "render/path_queue.h"
#include "render/stages/light_stage.h"

/* Per thread: the queue, and the data that stages hand to each other. */
typedef struct rk_path_workspace {
    rk_path_queue queue;
    rk_hit_batch hits;
    rk_ray_times times;
    rk_shading_points points;
    rk_light_workspace lights;
} rk_path_workspace;

/* Traces all paths of the queue and those that they spawn, until it is empty. Adds their radiance
 * to `film`. */
void rk_trace_paths(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                    rk_film *film);

#endif
