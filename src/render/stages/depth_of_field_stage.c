/* A first pass with the options of a larger picture, one ray per pixel, writes the circle of
 * confusion of each; rk_lens_coc then counts, for each pixel, the circles that reach it. */
#include "render/stages/depth_of_field_stage.h"

#include "render/lens_rays.h"
#include "render/stages/trace_stage.h"
#include "render/stages/transparency_stage.h"
#include "render/tiles.h"

#include <stdlib.h>
#include <string.h>

/* The picture with a margin around it, where only circles of confusion are found. */
typedef struct coc_job {
    rk_rendering wide; /* with its own options */
    rk_render_options options;
    uint32_t margin;
    rk_counters *counters; /* one per thread */
    float *diameter;       /* of the circle of confusion of each pixel, pixels */
} coc_job;

/* --- The margin ------------------------------------------------------------------------------- */

typedef struct depth_range {
    float nearest, farthest;
} depth_range;

static void add_depth(depth_range *range, const rk_view *view, rk_vec3 point, float radius)
{
    float depth = rk_dot(rk_sub(point, view->position), view->forward);
    range->nearest = rk_min(range->nearest, depth - radius);
    range->farthest = rk_max(range->farthest, depth + radius);
}

static void add_box(depth_range *range, const rk_view *view, const rk_box *box)
{
    for (int i = 0; i < 8; i++)
        add_depth(range, view,
                  rk_vec(box->corner[i & 1].x, box->corner[i >> 1 & 1].y, box->corner[i >> 2].z),
                  0);
}

static depth_range depths_of(const rk_rendering *r)
{
    const rk_scene *scene = r->scene;
    depth_range range = {INFINITY, -INFINITY};
    for (uint32_t i = 0; i < scene->mesh.vertex_count; i++)
        add_depth(&range, &r->view, scene->mesh.positions[i], 0);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        add_depth(&range, &r->view, scene->spheres[i].centre, scene->spheres[i].radius);
    for (uint32_t i = 0; r->plan.motion_blur && i < scene->moving_count; i++)
        add_box(&range, &r->view, &r->swept[i]);
    return range;
}

/* The circle at a depth, largest in the margin's corners on a focal sphere. */
static float largest_coc(const rk_rendering *r, float depth, uint32_t margin)
{
    const rk_view *view = &r->view;
    rk_ray corner = rk_view_ray(view, -(float)margin, -(float)margin);
    rk_ray ahead = {view->position, view->forward, INFINITY};
    bool plane = r->options->lens.focal == RK_FOCAL_PLANE;
    return rk_lens_coc_diameter(&r->options->lens, view, plane ? &ahead : &corner, depth);
}

/* Half a picture, and of a long one at most 16 centre rays per pixel, where half of its length
 * would take as many as the square of its length: the m with (width + 2m) (height + 2m) = 16 width
 * height. */
static uint32_t largest_margin(uint32_t width, uint32_t height)
{
    uint32_t half = (width > height ? width : height) / 2;
    double sides = (double)width + (double)height, area = (double)width * (double)height;
    double margin = (sqrt(sides * sides + 60 * area) - sides) / 4;
    return margin < half ? (uint32_t)margin : half;
}

/* What is just outside of the picture may be blurred into it. So centre rays look there, too, as
 * far as the largest circle reaches; of what is right before the lens, as far as they may. */
static uint32_t margin_of(const rk_rendering *r)
{
    uint32_t most = largest_margin(r->options->width, r->options->height);
    depth_range range = depths_of(r);
    if (!(range.nearest > 0))
        return range.farthest > 0 ? most : 0;
    float coc = rk_max(largest_coc(r, range.nearest, most), largest_coc(r, range.farthest, most));
    float reach = coc < RK_LENS_COC_MIN ? 0 : ceilf(0.5f * coc);
    return reach < (float)most ? (uint32_t)reach : most;
}

/* --- Circles of confusion --------------------------------------------------------------------- */

static const rk_material *material_at(const rk_scene *scene, const rk_hit *hit)
{
    const rk_mesh *mesh = &scene->mesh;
    return hit->triangle < mesh->triangle_count
               ? &mesh->materials[mesh->triangle_materials[hit->triangle]]
               : &scene->sphere_materials[hit->triangle - mesh->triangle_count];
}

/* A reflection is as far away as the whole path is long, so mirrors in focus need samples, too. */
static float coc_at(const rk_rendering *r, const rk_ray *ray, const rk_hit *hit)
{
    float coc = rk_lens_coc_diameter(&r->options->lens, &r->view, ray, hit->t);
    if (!r->plan.reflections)
        return coc;
    rk_vec3 ks = material_at(r->scene, hit)->ks;
    return ks.x > 0 || ks.y > 0 || ks.z > 0 ? rk_max(coc, RK_LENS_COC_MIN) : coc;
}

/* Of the background; one that is black is not blurred. */
static float coc_at_infinity(const rk_rendering *r, const rk_ray *ray)
{
    return r->plan.background ? rk_lens_coc_diameter(&r->options->lens, &r->view, ray, INFINITY)
                              : 0;
}

static float coc_of_hit(const rk_rendering *r, const rk_ray *ray, const rk_hit *hit)
{
    return hit->triangle != RK_MISS ? coc_at(r, ray, hit) : coc_at_infinity(r, ray);
}

/* The largest circle of confusion of all visible hits. */
static float coc_of_visible(const rk_rendering *r, const rk_ray *ray,
                            const rk_visible_hits *visible)
{
    float coc = visible->behind > 0 ? coc_at_infinity(r, ray) : 0;
    for (uint32_t k = 0; k < visible->count; k++)
        if (visible->weights[k] > 0)
            coc = rk_max(coc, coc_at(r, ray, &visible->hits[k]));
    return coc;
}

/* Moving objects are at a random time. */
static void trace_hits(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *camera,
                       float *coc)
{
    rk_hit_batch hits;
    rk_ray_times times;
    rk_trace_closest(r, pass, camera, &hits, &times);
    for (uint32_t i = 0; i < camera->rays.count; i++) {
        rk_ray ray = rk_batch_ray(&camera->rays, i);
        rk_hit hit = rk_batch_hit(&hits, i);
        coc[camera->pixel[i]] = coc_of_hit(r, &ray, &hit);
    }
}

static void trace_visible(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *camera,
                          float *coc)
{
    for (uint32_t i = 0; i < camera->rays.count; i++) {
        rk_visible_hits visible;
        rk_ray ray = rk_batch_ray(&camera->rays, i);
        rk_transparency_stage(r, pass, camera, i, &visible);
        coc[camera->pixel[i]] = coc_of_visible(r, &ray, &visible);
    }
}

/* A ray that needs a time may hit another surface at another time, so its pixel takes samples. */
static void put_tile(const coc_job *job, const rk_sample_pass *pass, const float *coc)
{
    const rk_tile *tile = &pass->tile;
    for (uint32_t i = 0; i < tile->width * tile->height; i++) {
        size_t x = tile->x + i % tile->width, y = tile->y + i / tile->width;
        bool moves = job->wide.plan.motion_blur && pass->needs_time[i];
        job->diameter[y * job->options.width + x] =
            moves ? rk_max(coc[i], RK_LENS_COC_MIN) : coc[i];
    }
}

/* Sixteen rays of a square traverse the tree as a packet, as in camera_stage.c. */
enum { SQUARE = 4, SQUARES = RK_TILE_SIDE / SQUARE };

static void push_centres(const coc_job *job, const rk_sample_pass *pass, rk_path_batch *camera)
{
    const rk_tile *tile = &pass->tile;
    const float centre = 0.5f - (float)job->margin;
    camera->rays.count = 0;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        const uint32_t square = i / (SQUARE * SQUARE);
        const uint32_t x = square % SQUARES * SQUARE + i % SQUARE;
        const uint32_t y = square / SQUARES * SQUARE + i / SQUARE % SQUARE;
        if (x >= tile->width || y >= tile->height)
            continue;
        const rk_ray ray = rk_view_ray(&job->wide.view, (float)(tile->x + x) + centre,
                                       (float)(tile->y + y) + centre);
        rk_path_push(camera, &ray, y * tile->width + x, rk_path_start(0, job->options.max_depth));
    }
    pass->counters->primary_rays += camera->rays.count;
}

static void find_coc_of_tile(uint32_t index, uint32_t thread, void *context)
{
    const coc_job *job = context;
    const rk_rendering *r = &job->wide;
    rk_sample_pass pass = {.tile = rk_tile_at(&job->options, index),
                           .samples = 1,
                           .time_passes = 1,
                           .counters = &job->counters[thread]};
    rk_path_batch camera;
    float coc[RK_BATCH_MAX];
    push_centres(job, &pass, &camera);
    if (r->plan.transparency)
        trace_visible(r, &pass, &camera, coc);
    else
        trace_hits(r, &pass, &camera, coc);
    put_tile(job, &pass, coc);
}

/* Moves the numbers of the picture itself to the front. */
static void crop(int32_t *coc_count, const coc_job *job, const rk_render_options *picture)
{
    size_t stride = (size_t)job->options.width + 1, row = (size_t)picture->width + 1;
    for (size_t y = 0; y < picture->height; y++)
        memmove(coc_count + y * row, coc_count + (y + job->margin) * stride + job->margin,
                row * sizeof *coc_count);
}

bool rk_depth_of_field_prepass(rk_rendering *r, rk_pool *pool, rk_counters *counters,
                               rk_error *error)
{
    coc_job job = {
        .wide = *r, .options = *r->options, .margin = margin_of(r), .counters = counters};
    job.wide.options = &job.options;
    job.wide.record = NULL;
    /* Equidistant times would show moving objects to all centre rays at the same place. */
    if (job.options.motion.sampling == RK_TIME_EQUIDISTANT)
        job.options.motion.sampling = RK_TIME_STRATIFIED;
    uint32_t width = job.options.width += 2 * job.margin;
    uint32_t height = job.options.height += 2 * job.margin;
    job.diameter = rk_allocate_unset((size_t)width * height, sizeof *job.diameter, "focus", error);
    if (job.diameter)
        r->coc_count = rk_allocate_unset(((size_t)width + 1) * (height + 1), sizeof *r->coc_count,
                                         "focus", error);
    if (r->coc_count) {
        rk_pool_run(pool, rk_tile_count(&job.options), find_coc_of_tile, &job);
        rk_lens_coc(job.diameter, width, height, r->coc_count);
        crop(r->coc_count, &job, r->options);
    }
    free(job.diameter);
    r->lens_rays_agree = rk_lens_rays_agree(r, r->options->lens_samples);
    return r->coc_count != NULL;
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_focal_surface_names, rk_focal_surface, RK_FOCAL_SPHERE, "plane", "sphere");

static const rk_option rows[] = {
    {"focal-distance", RK_FIELD(rk_render_options, lens.focal_distance), "D",
     "distance of the focal surface from the camera, world units", 1e-3, 1e6, 1.8},
    {"focal", RK_CHOICE(rk_render_options, lens.focal, rk_focal_surface_names),
     "measured along the view, as in photographs, or along each ray", .initial = RK_FOCAL_PLANE},
    {"aperture", RK_FIELD(rk_render_options, lens.aperture), "A",
     "diameter of the lens, thousandths of a world unit; 0: a pinhole", 0, 1e6, 10},
    {"lens-samples", RK_FIELD(rk_render_options, lens_samples), "N",
     "rays through the lens per pixel out of focus; 0: a pinhole", 0, RK_SAMPLES_MAX, 0},
    {"lens-sampling", RK_CHOICE(rk_render_options, lens_sampling, rk_sampler_names),
     "distribution of the samples over the lens and the pixel", .initial = RK_SAMPLER_SOBOL},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->lens_samples > 0 && options->lens.aperture > 0;
}

static void release(rk_rendering *r)
{
    free(r->coc_count);
}

const rk_feature rk_depth_of_field_feature = {.stem = "depth_of_field",
                                              .options = rows,
                                              .takes = "--lens-samples and an aperture above 0",
                                              .wanted = wanted,
                                              .prepass = rk_depth_of_field_prepass,
                                              .release = release};
