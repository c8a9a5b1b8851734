/* When rays are traced. A sample of a pixel has one time for all its rays, from the camera's to the
 * last shadow ray, and it is drawn when the first of them reaches the swept boxes of something that
 * moves. Until then nothing depends on the time: so a sample none of whose rays does so is the same
 * at all times, and taken once. Others are taken in turns, at times of their own, and count for
 * their mean. */
#include "render/tile.h"

/* With one time for all, it is known; else the sample's own, drawn if need be. */
static float time_of(const rk_rendering *r, rk_tile *t, uint32_t pixel)
{
    const rk_motion_options *motion = &r->options->motion;
    if (!r->plan.time_samples)
        return isnan(motion->isolate)
                   ? motion->shutter.open
                   : rk_shutter_equidistant(&motion->shutter, motion->isolate, motion->samples);
    if (!t->has_time[pixel]) {
        t->has_time[pixel] = t->in_motion[pixel] = true;
        t->time[pixel] = rk_shutter_time(&motion->shutter, motion->sampling, r->options->seed,
                                         rk_tile_pixel(r, t, pixel),
                                         t->turn * t->samples + t->sample, t->turns * t->samples);
        t->counters->time_samples++;
    }
    return t->time[pixel];
}

/* Whether a sample is in motion is worth a closer look, once. */
static bool reaches(void *context, uint32_t index, uint32_t object, const rk_slabs *ray,
                    float t_max, rk_vec3 *offset)
{
    const rk_asker *asker = context;
    const rk_rendering *r = asker->r;
    uint32_t pixel = asker->pixels[index];
    bool settled = !r->plan.time_samples || asker->t->in_motion[pixel];
    asker->t->counters->box_tests++;
    if (!rk_motion_may_intersect(&r->swept[object], ray, t_max) ||
        !(settled ||
          rk_motion_may_intersect_leaf(&r->accel->moving[object], &r->swept[object], ray, t_max)))
        return false;
    asker->t->in_sight[pixel] |= asker->from_camera;
    *offset = rk_motion_offset(&r->scene->moving[object].motion, time_of(r, asker->t, pixel));
    return true;
}

rk_moments rk_moments_of(rk_asker *asker)
{
    return (rk_moments){reaches, asker};
}

void rk_moving_prepare(rk_rendering *r)
{
    const rk_motion_options *motion = &r->options->motion;
    rk_shutter shutter = motion->shutter;
    if (!r->plan.motion)
        return;
    if (!isnan(motion->isolate))
        shutter.open = shutter.close =
            rk_shutter_equidistant(&motion->shutter, motion->isolate, motion->samples);
    for (uint32_t i = 0; i < r->scene->moving_count; i++) {
        const rk_box *rest = &r->accel->moving[i].nodes[0].box;
        r->swept[i] = rk_motion_sweep(&r->scene->moving[i].motion, &shutter, rest);
    }
}

void rk_moving_place(const rk_rendering *r, rk_tile *t, uint32_t pixel, uint32_t triangle,
                     rk_surface *surface)
{
    uint32_t object = rk_scene_moving_object(r->scene, triangle);
    if (object != RK_MISS)
        rk_surface_move(surface,
                        rk_motion_offset(&r->scene->moving[object].motion, time_of(r, t, pixel)));
}
