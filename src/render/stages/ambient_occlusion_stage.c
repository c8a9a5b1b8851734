/* Rays of many points fill a batch before it is traced; each that is unoccluded adds its weight to
 * the sum of its point. */
#include "render/stages/ambient_occlusion_stage.h"

#include "render/feature_list.h"
#include "render/film.h"
#include "render/stages/shadow_stage.h"

void rk_ambient_samples_start(rk_ambient_samples *s, const rk_rendering *r,
                              const rk_sample_pass *pass, const rk_shading_point *point)
{
    const rk_render_options *options = r->options;
    const rk_ambient_occlusion_options *ambient = &options->ambient_occlusion;
    const rk_path *path = &point->path;
    const rk_sample_index index = rk_sample_index_of(pass, point->pixel);
    /* Dimensions differ by bounce; the rays of a pixel at one bounce have the same ones. */
    uint32_t bounce = options->max_depth - path->bounces_left;
    uint32_t paths = index.samples * (path->split ? options->glossy.samples : 1);
    s->frame = rk_ambient_frame_of(point->surface.normal, point->surface.face_normal);
    s->map = ambient->map;
    s->distance = ambient->distance;
    s->sampler = rk_render_sampler(options, ambient->sampling, paths * ambient->samples);
    s->pixel = rk_picture_pixel(pass, options->width, point->pixel);
    s->dimension =
        index.dimension + rk_feature_dimension(RK_FEATURE_ambient_occlusion) + 2 * bounce;
    s->first = path->sample * ambient->samples;
    s->count = ambient->samples;
    rk_spawner_start(&s->spawner, &point->surface);
}

static void draw(rk_ambient_samples *s, uint32_t from)
{
    uint32_t left = s->count - from;
    rk_joint_2d_run(&s->sampler, s->pixel, s->first + from,
                    left < RK_AMBIENT_DRAWN ? left : RK_AMBIENT_DRAWN, s->dimension, s->drawn);
}

bool rk_ambient_ray(rk_ambient_samples *s, uint32_t i, rk_ray *ray, float *weight)
{
    if (i % RK_AMBIENT_DRAWN == 0)
        draw(s, i);
    rk_vec3 local = rk_ambient_hemisphere(s->map, s->drawn[i % RK_AMBIENT_DRAWN]), direction;
    bool above = rk_ambient_direction(&s->frame, local, &direction);
    *ray = (rk_ray){rk_spawner_origin(&s->spawner, direction), rk_scale(direction, s->distance), 1};
    *weight = rk_ambient_weight(s->map, local.z);
    return above;
}

/* Sums of weight times V for a batch of shading points, and rays not yet traced. */
typedef struct visibility {
    rk_shadow_queue queue;
    rk_shadow_answers answers;
    rk_vec3 sums[RK_BATCH_MAX]; /* one for each shading point */
} visibility;

static void trace(const rk_rendering *r, rk_sample_pass *pass, visibility *v)
{
    if (v->queue.rays.count == 0)
        return;
    rk_shadow_stage(r, pass, &v->queue, &v->answers);
    for (uint32_t k = 0; k < v->queue.rays.count; k++)
        if (!v->answers.occlusion.occluded[k]) {
            rk_vec3 *sum = &v->sums[v->queue.point[k]];
            *sum = rk_add(*sum, rk_unoccluded(r, &v->queue, &v->answers, k));
        }
    v->queue.rays.count = 0;
}

/* A batch gathers rays of many points and is traced when it is full. */
static void queue_rays(const rk_rendering *r, rk_sample_pass *pass, const rk_shading_point *point,
                       uint32_t i, visibility *v)
{
    rk_ambient_samples samples;
    rk_ambient_samples_start(&samples, r, pass, point);
    for (uint32_t sample = 0; sample < samples.count; sample++) {
        rk_ray ray;
        float weight;
        if (!rk_ambient_ray(&samples, sample, &ray, &weight))
            continue;
        uint32_t k = v->queue.rays.count;
        v->queue.point[k] = (uint16_t)i;
        v->queue.pixel[k] = point->pixel;
        v->queue.contribution[k] = rk_vec(weight, weight, weight);
        rk_batch_push(&v->queue.rays, &ray);
        if (v->queue.rays.count == RK_BATCH_MAX)
            trace(r, pass, v);
    }
}

static bool adds_light(const rk_shading_point *point)
{
    return !rk_is_black(rk_mul(point->path.throughput, point->kd));
}

static void shade(const rk_rendering *r, rk_sample_pass *pass, const rk_shading_points *points,
                  rk_film *film)
{
    const rk_ambient_occlusion_options *ambient = &r->options->ambient_occlusion;
    visibility v;
    v.queue.rays.count = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        v.sums[i] = rk_vec(0, 0, 0);
        if (adds_light(&points->points[i]))
            queue_rays(r, pass, &points->points[i], i, &v);
    }
    trace(r, pass, &v);
    for (uint32_t i = 0; i < points->count; i++) {
        const rk_shading_point *point = &points->points[i];
        rk_film_add(
            film, point->pixel,
            rk_mul(point->path.throughput, rk_ambient_radiance(point->kd, ambient->intensity,
                                                               v.sums[i], ambient->samples)));
    }
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_ambient_map_names, rk_ambient_map, RK_AMBIENT_COSINE, "uniform", "cosine");

static const rk_option rows[] = {
    {"ambient", RK_FIELD(rk_render_options, ambient_occlusion.intensity), "I",
     "radiance of ambient light, the same from all directions; 0: none", 0, 1000, 0},
    {"ambient-samples", RK_FIELD(rk_render_options, ambient_occlusion.samples), "N",
     "rays per shading point that test whether ambient light is occluded", 1, RK_SAMPLES_MAX, 16},
    {"ambient-distance", RK_FIELD(rk_render_options, ambient_occlusion.distance), "D",
     "largest distance of an occluder, world units", 1e-6, 1e6, 1000},
    {"ambient-map", RK_CHOICE(rk_render_options, ambient_occlusion.map, rk_ambient_map_names),
     "distribution of directions over the hemisphere", .initial = RK_AMBIENT_COSINE},
    {"ambient-sampling", RK_CHOICE(rk_render_options, ambient_occlusion.sampling, rk_sampler_names),
     "method of sampling the hemisphere", .initial = RK_SAMPLER_LOW_DISCREPANCY},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return options->ambient_occlusion.intensity > 0 &&
           (scene->mesh.triangle_count > 0 || scene->sphere_count > 0);
}

static uint32_t samples(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->ambient_occlusion.samples;
}

const rk_feature rk_ambient_occlusion_feature = {.stem = "ambient_occlusion",
                                                 .options = rows,
                                                 .takes = "an --ambient above 0 and a surface",
                                                 .wanted = wanted,
                                                 .shines = true,
                                                 .samples = samples,
                                                 .shade = shade};
