/* The renderer's own stages, on a tile of one pixel and one path at a time. */
#include "driver/explain_pixel.h"

#include "render/stages/cubemap_stage.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/light_stage.h"
#include "render/stages/motion_blur_stage.h"
#include "render/stages/reflection_stage.h"
#include "render/stages/shade_stage.h"
#include "render/stages/trace_stage.h"

typedef struct story {
    FILE *out;
    const rk_rendering *r;
    rk_sample_pass *pass;
    rk_shading_points *points; /* one */
    rk_light_workspace *lights;
    rk_film *film;
} story;

static void tell_vector(FILE *out, const char *what, rk_vec3 v)
{
    fprintf(out, "%-22s (% .6f, % .6f, % .6f)\n", what, (double)v.x, (double)v.y, (double)v.z);
}

/* What was counted since the last time. */
static void tell_tests(const story *s)
{
    fprintf(s->out, "    tested %llu boxes and %llu triangles\n",
            (unsigned long long)s->pass->counters->box_tests,
            (unsigned long long)s->pass->counters->triangle_tests);
    *s->pass->counters = (rk_counters){0};
}

static void tell_shadows(const story *s, const rk_light *light)
{
    const rk_light_sums *sums = &s->lights->sums;
    uint32_t asked = sums->traced[0], free = sums->unoccluded[0];
    if (asked == 0)
        return;
    if (light->kind == RK_LIGHT_POINT) {
        const rk_surface *surface = &s->points->points[0].surface;
        tell_vector(s->out, "    shadow ray from",
                    rk_surface_spawn(surface, rk_sub(light->position, surface->point)));
    } else {
        fprintf(s->out, "    %u shadow rays, %u of them not blocked\n", asked, free);
    }
    tell_tests(s);
    fprintf(s->out, "    %s\n",
            free == 0                                    ? "something is in the way: in shadow"
            : sums->visibility[0] == RK_LIGHT_ATTENUATED ? "the way leads through glass"
            : free == asked                              ? "the way is free"
                            : "the light is seen in part: in penumbra");
}

static const char *const kinds[] = {
    [RK_LIGHT_POINT] = "a point",
    [RK_LIGHT_SEGMENT] = "a segment",
    [RK_LIGHT_PARALLELOGRAM] = "a parallelogram",
};

/* The light's share in what the tile's one surface sends to the pixel. */
static void tell_light(const story *s, uint32_t index)
{
    const rk_light *light = &s->r->scene->lights[index];
    const rk_shading_point *point = &s->points->points[0];
    rk_vec3 before = s->film->sum[0];
    fprintf(s->out, "light %u, %s\n", index, kinds[light->kind]);
    tell_vector(s->out, "    position", light->position);
    tell_vector(s->out, "    colour", light->colours[0]);
    float cos_i =
        rk_dot(point->surface.normal, rk_normalize(rk_sub(light->position, point->surface.point)));
    fprintf(s->out, "    n.l = %.6f%s\n", (double)cos_i,
            cos_i > 0 ? "" : ": the surface is turned away");
    if (!rk_light_emits(light)) {
        fprintf(s->out, "    the light is black\n");
        return;
    }
    *s->pass->counters = (rk_counters){0};
    rk_parallelogram_light_stage(s->r, s->pass, s->points, index, &s->lights->queue,
                                 &s->lights->answers, &s->lights->sums, s->film);
    rk_vec3 all = s->lights->sums.unshadowed[0];
    if (all.x == 0 && all.y == 0 && all.z == 0)
        fprintf(s->out, "    nothing is reflected to the viewer\n");
    tell_shadows(s, light);
    tell_vector(s->out, "    adds to the pixel", rk_sub(s->film->sum[0], before));
}

static void tell_hit(const story *s, const rk_hit *hit)
{
    const rk_shading_point *point = &s->points->points[0];
    uint32_t triangles = s->r->scene->mesh.triangle_count;
    if (hit->triangle < triangles)
        fprintf(s->out, "    met triangle %u at t = %.6f\n", hit->triangle, (double)hit->t);
    else
        fprintf(s->out, "    met sphere %u at t = %.6f\n", hit->triangle - triangles,
                (double)hit->t);
    tell_vector(s->out, "    point", point->surface.point);
    if (hit->triangle < triangles)
        tell_vector(s->out, "    barycentric", point->surface.barycentric);
    tell_vector(s->out, "    face normal", point->surface.face_normal);
    tell_vector(s->out, "    shading normal", point->surface.normal);
    tell_vector(s->out, "    kd", point->kd);
    if (s->r->plan.transparency)
        fprintf(s->out, "    alpha = %.6f\n", (double)point->surface.material->alpha);
    tell_vector(s->out, "    counts in the pixel", point->path.throughput);
}

static void tell_path(const story *s, const rk_path_batch *path, const char *name);

static void tell_disk(const story *s)
{
    const rk_glossy_disk disk = rk_glossy_disk_at(&s->r->options->glossy, &s->points->points[0]);
    fprintf(s->out, "    mirrors into a disk of radius %g, %.1f %% of which is above the surface\n",
            (double)disk.radius, 100 * (double)rk_glossy_fraction_above(&disk));
}

/* The shading point, its light, and what it mirrors. */
static void tell_surface(const story *s, const rk_hit *hit)
{
    const rk_shading_point *point = &s->points->points[0];
    rk_path_batch mirrored;
    mirrored.rays.count = 0;
    tell_hit(s, hit);
    for (uint32_t i = 0; i < s->r->scene->light_count; i++)
        tell_light(s, i);
    if (s->r->plan.reflections && rk_is_specular(point))
        rk_spawn_reflection(point, &mirrored);
    if (mirrored.rays.count && s->r->plan.glossy_reflection)
        tell_disk(s);
    if (mirrored.rays.count)
        tell_path(s, &mirrored, "mirrored ray");
}

static void tell_environment(const story *s, const rk_path_batch *path, float share)
{
    if (!s->r->plan.cubemap) {
        fprintf(s->out, "    met nothing: black\n");
        return;
    }
    rk_vec3 adds = rk_environment_radiance(s->r, path, 0, share, s->pass->counters);
    fprintf(s->out, "%s: the environment\n", share < 1 ? "    behind it all" : "    met nothing");
    tell_vector(s->out, "    adds to the pixel", adds);
    rk_film_add(s->film, 0, adds);
}

static void tell_closest(const story *s, const rk_path_batch *path)
{
    rk_hit_batch hits;
    rk_ray_times times = {.time = {0}};
    rk_trace_closest(s->r, s->pass, path, &hits, &times);
    tell_tests(s);
    rk_hit hit = rk_batch_hit(&hits, 0);
    if (hit.triangle == RK_MISS) {
        tell_environment(s, path, 1);
        return;
    }
    rk_shading_point_at(s->points->points, s->r, path, 0, &hit, times.time[0]);
    tell_surface(s, &hit);
}

static void tell_visible(const story *s, const rk_path_batch *path)
{
    rk_visible_hits visible;
    rk_transparency_stage(s->r, s->pass, path, 0, &visible);
    tell_tests(s);
    for (uint32_t k = 0; k < visible.count; k++) {
        rk_shading_point_behind(s->points->points, s->r, path, 0, &visible, k);
        tell_surface(s, &visible.hits[k]);
    }
    if (visible.count == 0 || (s->r->plan.cubemap && visible.behind > 0))
        tell_environment(s, path, visible.behind);
}

static void tell_path(const story *s, const rk_path_batch *path, const char *name)
{
    rk_ray ray = rk_batch_ray(&path->rays, 0);
    fprintf(s->out, "%s\n", name);
    tell_vector(s->out, "    origin", ray.origin);
    tell_vector(s->out, "    direction", ray.direction);
    *s->pass->counters = (rk_counters){0};
    if (s->r->plan.transparency)
        tell_visible(s, path);
    else
        tell_closest(s, path);
}

void rk_explain_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y)
{
    rk_counters counters = {0};
    rk_rendering r = {.scene = scene,
                      .accel = accel,
                      .options = options,
                      .plan = rk_plan_of(scene, options),
                      .view = rk_view_of(&scene->camera, options->width, options->height)};
    if (r.plan.motion_blur)
        rk_motion_blur_prepare(&r);
    rk_sample_pass pass = {.tile = {x, y, 1, 1},
                           .samples = options->samples,
                           .time_passes = rk_time_passes(&r.plan, options, options->samples),
                           .counters = &counters};
    rk_path_batch camera;
    rk_ray ray = rk_view_ray(&r.view, (float)x + 0.5f, (float)y + 0.5f);
    camera.rays.count = 0;
    rk_path_push(&camera, &ray, 0, rk_path_start(0, options->max_depth));
    fprintf(out, "pixel (%u, %u) of %s\n", x, y, scene->name);
    if (r.plan.pixel_samples)
        fprintf(out,
                "the picture averages %u rays through it; this is the one through its centre\n",
                options->samples);
    if (r.plan.depth_of_field)
        fprintf(out,
                "where it is out of focus, rays start all over the lens; this one at its centre\n");
    if (r.plan.glossy_reflection)
        fprintf(out,
                "the picture averages %u ray%s in the disk of a rough mirror; those told here go "
                "through its middle\n",
                options->glossy.samples, options->glossy.samples == 1 ? "" : "s");
    rk_shading_points points = {.count = 1};
    rk_light_workspace lights;
    rk_film film = {.sum = {{0, 0, 0}}};
    const story s = {out, &r, &pass, &points, &lights, &film};
    tell_path(&s, &camera, "camera ray");
    if (pass.needs_time[0])
        fprintf(out, "a ray may meet what moves: this was seen at x = %.6f, one of %u times\n",
                (double)pass.time[0], pass.time_passes * pass.samples);
    tell_vector(out, "colour (linear)", film.sum[0]);
    if (r.plan.bloom)
        fprintf(out, "the glow of bright pixels comes on top, when all are rendered\n");
}
