/* The inputs of a picture: shared by all threads, and constant while they work; not installed. */
#ifndef RK_RENDER_RENDERING_H
#define RK_RENDER_RENDERING_H

#include "accel/accel.h"
#include "render/joint_run.h"
#include "render/plan.h"

typedef struct rk_rendering {
    const rk_scene *scene;
    const rk_accel *accel;
    const rk_render_options *options;
    rk_plan plan;
    rk_view view;
    int32_t *coc_count;           /* see rk_lens_coc; NULL without a lens */
    bool lens_rays_agree;         /* see render/lens_rays.h; false without a lens */
    rk_joint_runs joint_runs;     /* unset without plan.parallelogram_light and glossy_reflection */
    bool glossy_run_agrees;       /* see render/glossy_run.h; false without rough mirrors */
    rk_box swept[RK_MOVING_MAX];  /* of each moving object; unset unless plan.motion_blur */
    struct rk_ray_record *record; /* see render/ray_record.h; NULL in pictures */
} rk_rendering;

/* Before the features' own preparations. */
static inline rk_rendering rk_rendering_of(const rk_scene *scene, const rk_accel *accel,
                                           const rk_render_options *options)
{
    return (rk_rendering){.scene = scene,
                          .accel = accel,
                          .options = options,
                          .plan = rk_plan_of(scene, options),
                          .view = rk_view_of(&scene->camera, options->width, options->height)};
}

#endif
