/* A ray is tested against the boxes that the objects sweep while the shutter is open; only if it
 * enters one, a time is drawn, once per sample. */
#include "render/stages/motion_blur_stage.h"

/* If all rays have the same: when the shutter opens, or options->motion.single_time. */
static float common_time(const rk_motion_options *motion)
{
    return isnan(motion->single_time)
               ? motion->shutter.open
               : rk_shutter_equidistant(&motion->shutter, motion->single_time, motion->samples);
}

/* A box test suffices for most rays. But a sample that needs a time costs further passes, so before
 * the first of them the ray is tested against the boxes of leaves, too. */
static bool may_reach(const rk_rendering *r, const rk_sample_pass *pass, uint32_t pixel,
                      uint32_t object, const rk_slabs *ray, float t_max)
{
    const rk_box *swept = &r->swept[object];
    pass->counters->box_tests++;
    return rk_motion_may_intersect(swept, ray, t_max) &&
           (!r->plan.time_samples || pass->needs_time[pixel] ||
            rk_motion_may_intersect_leaf(&r->accel->moving[object], swept, ray, t_max));
}

static uint16_t reachable_objects(const rk_rendering *r, rk_sample_pass *pass, uint32_t pixel,
                                  const rk_ray *ray, float t_max)
{
    const rk_slabs slabs = rk_slabs_of(ray);
    uint16_t objects = 0;
    for (uint32_t k = 0; k < r->scene->moving_count; k++)
        if (may_reach(r, pass, pixel, k, &slabs, t_max)) {
            objects |= (uint16_t)(1u << k);
            pass->needs_time[pixel] |= r->plan.time_samples;
        }
    return objects;
}

/* The time of one of a pixel's samples. */
static float draw_time(const rk_render_options *options, uint32_t pixel, uint32_t sample,
                       uint32_t samples)
{
    const rk_motion_options *motion = &options->motion;
    rk_sampler_kind kind = RK_SAMPLER_SOBOL;
    if (motion->sampling == RK_TIME_ZSOBOL)
        kind = RK_SAMPLER_ZSOBOL;
    else if (motion->sampling == RK_TIME_UNIFORM)
        kind = RK_SAMPLER_UNIFORM;
    else if (motion->sampling != RK_TIME_SOBOL)
        return rk_shutter_time(&motion->shutter, motion->sampling, options->seed, pixel, sample,
                               samples);
    const rk_sampler sampler = rk_render_sampler(options, kind, samples);
    float xi = rk_joint_1d(&sampler, pixel, sample, RK_DIMENSION_TIME);
    return rk_shutter_equidistant(&motion->shutter, xi + 0.5f, 1);
}

/* Of the pixel's sample, drawn if this is the first ray that needs it. */
static float time_of(const rk_rendering *r, rk_sample_pass *pass, uint32_t pixel)
{
    if (!pass->has_time[pixel]) {
        uint32_t key = rk_picture_pixel(pass, r->options->width, pixel);
        pass->has_time[pixel] = true;
        pass->time[pixel] = draw_time(
            r->options, key, pass->time_pass * pass->samples + rk_sample_at(pass, pixel).sample,
            pass->time_passes * pass->samples);
        pass->counters->time_samples++;
    }
    return pass->time[pixel];
}

rk_ray_time rk_motion_blur_ray_time(const rk_rendering *r, rk_sample_pass *pass, uint32_t pixel,
                                    bool from_camera, const rk_ray *ray, float t_max)
{
    /* Further time passes take the same camera rays. */
    const bool is_known = from_camera && pass->time_pass > 0;
    rk_ray_time when = {NAN, is_known ? pass->camera_objects[pixel]
                                      : reachable_objects(r, pass, pixel, ray, t_max)};
    if (when.objects == 0)
        return when;
    if (from_camera)
        pass->camera_objects[pixel] = when.objects;
    when.time = r->plan.time_samples ? time_of(r, pass, pixel) : common_time(&r->options->motion);
    return when;
}

void rk_motion_blur_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                          const uint16_t *pixels, bool from_camera, const float *t_max,
                          rk_ray_times *times)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_ray_time when = {NAN, 0};
        if (t_max[i] > 0)
            when = rk_motion_blur_ray_time(r, pass, pixels[i], from_camera, &ray, t_max[i]);
        times->time[i] = when.time;
        times->objects[i] = when.objects;
    }
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_time_sampling_names, rk_time_sampling, RK_TIME_UNIFORM, "equidistant", "stratified",
         "low-discrepancy", "sobol", "zsobol", "uniform");

static const rk_option rows[] = {
    {"shutter-open", RK_FIELD(rk_render_options, motion.shutter.open), "X",
     "when the shutter opens; a moving object is then displaced by (X, y(X), 0), where y(x) is its "
     "path (rk_motion)",
     -1e6, 1e6, 0},
    {"shutter-close", RK_FIELD(rk_render_options, motion.shutter.close), "X", "when it closes",
     -1e6, 1e6, 0.05},
    {"time-samples", RK_FIELD(rk_render_options, motion.samples), "N",
     "times per pixel, divided among its --samples; pixels that motion cannot change need none; "
     "0: everything is at rest",
     0, RK_SAMPLES_MAX, 0},
    {"time-sampling", RK_CHOICE(rk_render_options, motion.sampling, rk_time_sampling_names),
     "distribution of the times; equidistant ones are the same for all pixels",
     .initial = RK_TIME_STRATIFIED},
    {"single-time", RK_FIELD(rk_render_options, motion.single_time), "K",
     "render the equidistant time K of --time-samples N alone; K < 1 is before the shutter opens, "
     "K > N after it closes",
     -1e6, 1e6, NAN, .alias = "isolate"},
    {0},
};

/* The boxes that moving objects sweep while the shutter is open. */
static bool prepare(rk_rendering *r, rk_error *error)
{
    (void)error;
    const rk_motion_options *motion = &r->options->motion;
    rk_shutter shutter = motion->shutter;
    if (!isnan(motion->single_time))
        shutter.open = shutter.close = common_time(motion);
    for (uint32_t i = 0; i < r->scene->moving_count; i++) {
        const rk_box *rest = &r->accel->moving[i].nodes[0].box;
        r->swept[i] = rk_motion_sweep(&r->scene->moving[i].motion, &shutter, rest);
    }
    return true;
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return options->motion.samples > 0 && scene->moving_count > 0;
}

static bool check(const rk_render_options *options, rk_error *error)
{
    const rk_shutter *shutter = &options->motion.shutter;
    return shutter->open <= shutter->close ||
           rk_fail(error, "the shutter opens at x = %g, after it closes at x = %g",
                   (double)shutter->open, (double)shutter->close);
}

static bool check_command(const rk_render_options *options, rk_error *error)
{
    const rk_motion_options *motion = &options->motion;
    return isnan(motion->single_time) || motion->samples > 0 ||
           rk_fail(error,
                   "the single time %g is one of the --time-samples, and there are none; give "
                   "--time-samples N, 1 or more",
                   (double)motion->single_time);
}

const rk_feature rk_motion_blur_feature = {.stem = "motion_blur",
                                           .options = rows,
                                           .takes = "--time-samples and a moving object",
                                           .wanted = wanted,
                                           .prepare = prepare,
                                           .check = check,
                                           .check_command = check_command};
