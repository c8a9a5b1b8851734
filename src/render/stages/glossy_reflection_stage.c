/* Points wait until the batch of reflected rays has room; a point's samples are drawn in runs
 * (render/glossy_run.h), and it goes on where the last batch was full. */
#include "render/stages/glossy_reflection_stage.h"

#include "render/stages/reflection_stage.h"

void rk_specular_queue_fill(rk_specular_queue *queue, const rk_shading_points *points)
{
    queue->next = queue->sample = queue->waiting.count = 0;
    for (uint32_t i = 0; i < points->count; i++)
        if (rk_is_specular(&points->points[i]))
            queue->waiting.points[queue->waiting.count++] = points->points[i];
}

rk_glossy_disk rk_glossy_disk_at(const rk_glossy_options *options, const rk_shading_point *point)
{
    float radius = options->radius >= 0 ? options->radius
                                        : rk_glossy_radius(point->surface.material->shininess);
    return rk_glossy_disk_of(rk_reflected_direction(point), radius, point->surface.face_normal);
}

static rk_glossy_samples samples_of(const rk_rendering *r, const rk_sample_pass *pass,
                                    const rk_shading_point *point)
{
    const rk_render_options *options = r->options;
    const rk_path *path = &point->path;
    const rk_sample_index index = rk_sample_index_of(pass, point->pixel);
    /* Each bounce has dimensions of its own. */
    uint32_t bounce = options->max_depth - path->bounces_left;
    uint32_t count = path->split ? 1 : options->glossy.samples;
    const rk_glossy_disk disk = rk_glossy_disk_at(&options->glossy, point);
    bool discards = options->glossy.weights == RK_GLOSSY_CLASSIC;
    return (rk_glossy_samples){
        .disk = disk,
        .fraction = discards ? 1 : rk_glossy_fraction_above(&disk),
        .map = options->glossy.map,
        .sampler = rk_render_sampler(options, options->glossy.sampling,
                                     index.samples * options->glossy.samples),
        .pixel = rk_picture_pixel(pass, options->width, point->pixel),
        .dimension = index.dimension + RK_DIMENSION_GLOSSY + 2 * bounce,
        .first = path->sample * count,
        .count = count,
    };
}

/* The directions of the point's samples from this one on, as many as fit. */
static void draw(const rk_rendering *r, const rk_glossy_samples *s, uint32_t from,
                 rk_glossy_run *run)
{
    const uint32_t left = s->count - from;
    const uint32_t count = left < RK_GLOSSY_RUN_MAX ? left : RK_GLOSSY_RUN_MAX;
    rk_vec2 numbers[RK_GLOSSY_RUN_MAX];
    rk_joint_run(&r->joint_runs, &s->sampler, s->pixel, s->first + from, count, s->dimension,
                 numbers);
    for (uint32_t i = 0; i < count; i++) {
        run->x[i] = numbers[i].x;
        run->y[i] = numbers[i].y;
    }
    rk_glossy_run_map(run, s->map, count, r->glossy_run_agrees);
    for (uint32_t i = 0; s->fraction != 1 && i < count; i++) {
        const rk_vec2 at =
            rk_glossy_point_above(&s->disk, s->fraction, (rk_vec2){run->x[i], run->y[i]});
        run->x[i] = at.x;
        run->y[i] = at.y;
    }
    rk_glossy_run_aim(run, &s->disk, count, r->glossy_run_agrees);
}

static void start_point(const rk_rendering *r, const rk_sample_pass *pass, rk_specular_queue *queue)
{
    const rk_shading_point *point = &queue->waiting.points[queue->next];
    queue->samples = samples_of(r, pass, point);
    if (queue->samples.disk.radius == 0)
        return;
    queue->throughput = rk_scale(rk_mul(point->path.throughput, point->surface.material->ks),
                                 1 / (float)queue->samples.count);
    pass->counters->glossy_samples += queue->samples.count;
}

/* The rays of the point, from its next sample on. False if the batch is full before the last. */
static bool spawn_samples(const rk_rendering *r, rk_specular_queue *queue, rk_path_batch *reflected)
{
    const rk_shading_point *point = &queue->waiting.points[queue->next];
    const rk_glossy_samples *s = &queue->samples;
    const rk_glossy_run *run = &queue->run;
    const uint32_t bounces_left = point->path.bounces_left - 1u;
    rk_spawner spawner;
    rk_spawner_start(&spawner, &point->surface);
    for (; queue->sample < s->count; queue->sample++) {
        const uint32_t i = queue->sample % RK_GLOSSY_RUN_MAX;
        if (reflected->rays.count == RK_BATCH_MAX)
            return false;
        if (i == 0)
            draw(r, s, queue->sample, &queue->run);
        if (!(run->is_above[i] > 0))
            continue;
        const rk_vec3 direction =
            rk_vec(run->direction_x[i], run->direction_y[i], run->direction_z[i]);
        const rk_ray ray = {rk_spawner_origin(&spawner, direction), direction, INFINITY};
        rk_path_push(reflected, &ray, point->pixel,
                     rk_path_of(queue->throughput, s->first + queue->sample, true, bounces_left));
    }
    return true;
}

static bool spawn_point(const rk_rendering *r, const rk_sample_pass *pass, rk_specular_queue *queue,
                        rk_path_batch *reflected)
{
    if (queue->sample == 0)
        start_point(r, pass, queue);
    if (queue->samples.disk.radius > 0)
        return spawn_samples(r, queue, reflected);
    rk_spawn_reflection(&queue->waiting.points[queue->next], reflected);
    return true;
}

void rk_glossy_reflection_stage(const rk_rendering *r, const rk_sample_pass *pass,
                                rk_specular_queue *queue, rk_path_batch *reflected)
{
    reflected->rays.count = 0;
    while (queue->next < queue->waiting.count && reflected->rays.count < RK_BATCH_MAX &&
           spawn_point(r, pass, queue, reflected)) {
        queue->next++;
        queue->sample = 0;
    }
    pass->counters->reflected_rays += reflected->rays.count;
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_glossy_weights_names, rk_glossy_weights, RK_GLOSSY_RENORMALIZED, "classic",
         "renormalized");
RK_NAMES(rk_disk_map_names, rk_disk_map, RK_DISK_CONCENTRIC, "polar", "concentric");

static const rk_option rows[] = {
    {"glossy", RK_FIELD(rk_render_options, glossy.samples), "N",
     "directions per ray at the first rough mirror of a path; 0: mirrors are perfect", 0,
     RK_SAMPLES_MAX, 0},
    {"glossy-radius", RK_FIELD(rk_render_options, glossy.radius), "R",
     "radius of the disk around the reflected direction, at distance 1; negative, and by default, "
     "0.5 over the material's shininess",
     -1, 1000, NAN},
    {"glossy-weights", RK_CHOICE(rk_render_options, glossy.weights, rk_glossy_weights_names),
     "the part of the disk below the surface counts as black, or is left out",
     .initial = RK_GLOSSY_RENORMALIZED},
    {"glossy-map", RK_CHOICE(rk_render_options, glossy.map, rk_disk_map_names),
     "map of the unit square to the disk", .initial = RK_DISK_CONCENTRIC},
    {"glossy-sampling", RK_CHOICE(rk_render_options, glossy.sampling, rk_sampler_names),
     "distribution of the directions over the disk", .initial = RK_SAMPLER_SOBOL},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return options->glossy.samples > 0 && options->glossy.radius != 0 &&
           rk_plan_reflects(scene, options);
}

static bool prepare(rk_rendering *r, rk_error *error)
{
    (void)error;
    r->joint_runs = rk_joint_runs_of();
    r->glossy_run_agrees = rk_glossy_run_agrees();
    return true;
}

static uint32_t samples(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->glossy.samples;
}

const rk_feature rk_glossy_reflection_feature = {
    .stem = "glossy_reflection",
    .options = rows,
    .takes = "--glossy, a radius other than 0, --reflections and a mirror",
    .wanted = wanted,
    .samples = samples,
    .prepare = prepare,
    .splits = true};
