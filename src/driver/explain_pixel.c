/* Runs the renderer's own stages on a tile of one pixel, one path at a time, and prints what they
 * return: so the explanation cannot differ from the picture. */
#include "driver/explain_pixel.h"

#include "driver/unsolved.h"
#include "render/feature_hooks.h"
#include "render/feature_list.h"
#include "render/stages/cubemap_stage.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/light_stage.h"
#include "render/stages/reflection_stage.h"
#include "render/stages/shade_stage.h"
#include "render/stages/trace_stage.h"
#include "render/time_passes.h"

typedef struct explanation {
    FILE *out;
    const rk_rendering *r;
    rk_sample_pass *pass;
    rk_shading_points *points; /* one */
    rk_light_workspace *lights;
    rk_film *film;
} explanation;

static void print_vector(FILE *out, const char *label, rk_vec3 v)
{
    fprintf(out, "%-22s (% .6f, % .6f, % .6f)\n", label, (double)v.x, (double)v.y, (double)v.z);
}

/* The tests since the counters were last cleared. */
static void print_tests(const explanation *e)
{
    fprintf(e->out, "    tested %llu boxes and %llu triangles\n",
            (unsigned long long)e->pass->counters->box_tests,
            (unsigned long long)e->pass->counters->triangle_tests);
    *e->pass->counters = (rk_counters){0};
}

static void print_shadows(const explanation *e, const rk_light *light)
{
    const rk_light_sums *sums = &e->lights->sums;
    uint32_t traced = sums->traced[0], unoccluded = sums->unoccluded[0];
    if (traced == 0)
        return;
    if (light->kind == RK_LIGHT_POINT) {
        const rk_surface *surface = &e->points->points[0].surface;
        print_vector(e->out, "    shadow ray origin",
                     rk_surface_spawn(surface, rk_sub(light->position, surface->point)));
    } else {
        fprintf(e->out, "    %u shadow rays, %u unoccluded\n", traced, unoccluded);
    }
    print_tests(e);
    fprintf(e->out, "    %s\n",
            unoccluded == 0                              ? "occluded: in shadow"
            : sums->visibility[0] == RK_LIGHT_ATTENUATED ? "attenuated by transparent surfaces"
            : unoccluded == traced                       ? "unoccluded"
                                                         : "occluded in part: in penumbra");
}

static const char *const kinds[] = {
    [RK_LIGHT_POINT] = "a point",
    [RK_LIGHT_SEGMENT] = "a segment",
    [RK_LIGHT_PARALLELOGRAM] = "a parallelogram",
};

static void print_nothing(const explanation *e)
{
    const rk_unsolved unsolved = rk_unsolved_features_of(&e->r->plan);
    fprintf(e->out, "    nothing is reflected to the viewer%s%s\n", *unsolved.text ? ": " : "",
            unsolved.text);
}

/* The radiance that the light adds at the shading point. */
static void print_light(const explanation *e, uint32_t index)
{
    const rk_light *light = &e->r->scene->lights[index];
    const rk_shading_point *point = &e->points->points[0];
    rk_vec3 before = e->film->sum[0];
    fprintf(e->out, "light %u, %s\n", index, kinds[light->kind]);
    print_vector(e->out, "    position", light->position);
    print_vector(e->out, "    colour", light->colours[0]);
    float cos_i =
        rk_dot(point->surface.normal, rk_normalize(rk_sub(light->position, point->surface.point)));
    fprintf(e->out, "    n.l = %.6f%s\n", (double)cos_i,
            cos_i > 0 ? "" : ": the surface faces away");
    if (!rk_light_emits(light)) {
        fprintf(e->out, "    the light is black\n");
        return;
    }
    *e->pass->counters = (rk_counters){0};
    rk_parallelogram_light_stage(e->r, e->pass, e->points, index, &e->lights->queue,
                                 &e->lights->answers, &e->lights->sums, e->film);
    rk_vec3 all = e->lights->sums.unshadowed[0];
    if (all.x == 0 && all.y == 0 && all.z == 0)
        print_nothing(e);
    print_shadows(e, light);
    print_vector(e->out, "    adds to the pixel", rk_sub(e->film->sum[0], before));
}

/* The contributions of features by their own hooks. */
static void print_features(const explanation *e)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (!rk_features[i]->shade || !rk_plan_has(&e->r->plan, i))
            continue;
        rk_vec3 before = e->film->sum[0];
        fprintf(e->out, "%s\n", rk_features[i]->stem);
        *e->pass->counters = (rk_counters){0};
        rk_features[i]->shade(e->r, e->pass, e->points, e->film);
        print_tests(e);
        print_vector(e->out, "    adds to the pixel", rk_sub(e->film->sum[0], before));
    }
}

static void print_hit(const explanation *e, const rk_hit *hit)
{
    const rk_shading_point *point = &e->points->points[0];
    uint32_t triangles = e->r->scene->mesh.triangle_count;
    if (hit->triangle < triangles)
        fprintf(e->out, "    hit triangle %u at t = %.6f\n", hit->triangle, (double)hit->t);
    else
        fprintf(e->out, "    hit sphere %u at t = %.6f\n", hit->triangle - triangles,
                (double)hit->t);
    print_vector(e->out, "    point", point->surface.point);
    if (hit->triangle < triangles)
        print_vector(e->out, "    barycentric", point->surface.barycentric);
    print_vector(e->out, "    face normal", point->surface.face_normal);
    print_vector(e->out, "    shading normal", point->surface.normal);
    print_vector(e->out, "    kd", point->kd);
    if (e->r->plan.transparency)
        fprintf(e->out, "    alpha = %.6f\n", (double)point->surface.material->alpha);
    print_vector(e->out, "    throughput", point->path.throughput);
}

static void print_path(const explanation *e, const rk_path_batch *path, const char *name);

static void print_disk(const explanation *e)
{
    const rk_glossy_disk disk = rk_glossy_disk_at(&e->r->options->glossy, &e->points->points[0]);
    fprintf(e->out, "    reflects into a disk of radius %g, %.1f %% of it above the surface\n",
            (double)disk.radius, 100 * (double)rk_glossy_fraction_above(&disk));
}

/* The shading point, its lights, and its reflection. */
static void print_surface(const explanation *e, const rk_hit *hit)
{
    const rk_shading_point *point = &e->points->points[0];
    rk_path_batch reflected;
    reflected.rays.count = 0;
    print_hit(e, hit);
    print_features(e);
    for (uint32_t i = 0; i < e->r->scene->light_count; i++)
        print_light(e, i);
    if (e->r->plan.reflections && rk_is_specular(point))
        rk_spawn_reflection(point, &reflected);
    if (reflected.rays.count && e->r->plan.glossy_reflection)
        print_disk(e);
    if (reflected.rays.count)
        print_path(e, &reflected, "reflected ray");
}

static void print_environment(const explanation *e, const rk_path_batch *path, float fraction)
{
    if (!e->r->plan.cubemap) {
        fprintf(e->out, "    no hit: black\n");
        return;
    }
    rk_vec3 adds = rk_environment_radiance(e->r, path, 0, fraction, e->pass->counters);
    fprintf(e->out, "%s: the environment\n",
            fraction < 1 ? "    behind all surfaces" : "    no hit");
    print_vector(e->out, "    adds to the pixel", adds);
    rk_film_add(e->film, 0, adds);
}

static void print_closest(const explanation *e, const rk_path_batch *path)
{
    rk_hit_batch hits;
    rk_ray_times times = {.time = {0}};
    rk_trace_closest(e->r, e->pass, path, &hits, &times);
    print_tests(e);
    rk_hit hit = rk_batch_hit(&hits, 0);
    if (hit.triangle == RK_MISS) {
        print_environment(e, path, 1);
        return;
    }
    rk_shading_point_at(e->points->points, e->r, path, 0, &hit, times.time[0]);
    print_surface(e, &hit);
}

static void print_visible(const explanation *e, const rk_path_batch *path)
{
    rk_visible_hits visible;
    rk_transparency_stage(e->r, e->pass, path, 0, &visible);
    print_tests(e);
    for (uint32_t k = 0; k < visible.count; k++) {
        rk_shading_point_behind(e->points->points, e->r, path, 0, &visible, k);
        print_surface(e, &visible.hits[k]);
    }
    if (visible.count == 0 || (e->r->plan.cubemap && visible.behind > 0))
        print_environment(e, path, visible.behind);
}

static void print_path(const explanation *e, const rk_path_batch *path, const char *name)
{
    rk_ray ray = rk_batch_ray(&path->rays, 0);
    fprintf(e->out, "%s\n", name);
    print_vector(e->out, "    origin", ray.origin);
    print_vector(e->out, "    direction", ray.direction);
    *e->pass->counters = (rk_counters){0};
    if (e->r->plan.transparency)
        print_visible(e, path);
    else
        print_closest(e, path);
}

/* How the picture differs from the one path that is printed. */
static void print_notes(FILE *out, const rk_rendering *r)
{
    const rk_render_options *options = r->options;
    if (r->plan.pixel_samples)
        fprintf(out, "the picture averages %u rays per pixel; this one passes through its centre\n",
                options->samples);
    if (r->plan.depth_of_field)
        fprintf(out, "out of focus, rays start all over the lens; this one starts at its centre\n");
    if (r->plan.glossy_reflection)
        fprintf(out,
                "a rough mirror averages %u ray%s over a disk of directions; those printed here "
                "pass through its centre\n",
                options->glossy.samples, options->glossy.samples == 1 ? "" : "s");
}

static void print_pixel(FILE *out, const rk_rendering *r, uint32_t x, uint32_t y)
{
    rk_counters counters = {0};
    uint32_t samples = r->options->samples;
    rk_sample_pass pass = {.tile = {x, y, 1, 1},
                           .samples = samples,
                           .time_passes = rk_time_passes(&r->plan, r->options, samples),
                           .counters = &counters};
    rk_path_batch camera;
    rk_ray ray = rk_view_ray(&r->view, (float)x + 0.5f, (float)y + 0.5f);
    camera.rays.count = 0;
    rk_path_push(&camera, &ray, 0, rk_path_start(0, r->options->max_depth));
    rk_shading_points points = {.count = 1};
    rk_light_workspace lights;
    rk_film film = {.sum = {{0, 0, 0}}};
    const explanation e = {out, r, &pass, &points, &lights, &film};
    print_path(&e, &camera, "camera ray");
    if (pass.needs_time[0])
        fprintf(out, "a ray may hit a moving object: the time is x = %.6f, one of %u\n",
                (double)pass.time[0], pass.time_passes * samples);
    print_vector(out, "colour (linear)", film.sum[0]);
}

void rk_explain_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y)
{
    rk_error error = {""};
    rk_rendering r = {.scene = scene,
                      .accel = accel,
                      .options = options,
                      .plan = rk_plan_of(scene, options),
                      .view = rk_view_of(&scene->camera, options->width, options->height)};
    fprintf(out, "pixel (%u, %u) of %s\n", x, y, scene->name);
    print_notes(out, &r);
    if (rk_features_prepare(&r, &error))
        print_pixel(out, &r, x, y);
    else
        fprintf(out, "%s\n", error.text);
    rk_features_release(&r);
    if (r.plan.bloom)
        fprintf(out, "bloom is added when all pixels are rendered\n");
}
