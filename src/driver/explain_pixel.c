/* The story is told by the renderer's own stages, on a tile of one pixel. */
#include "driver/explain_pixel.h"

#include "accel/crossings.h"
#include "render/lighting.h"

typedef struct story {
    FILE *out;
    const rk_rendering *r;
    rk_tile *t;
} story;

static void tell_vector(FILE *out, const char *what, rk_vec3 v)
{
    fprintf(out, "%-22s (% .6f, % .6f, % .6f)\n", what, (double)v.x, (double)v.y, (double)v.z);
}

/* What was counted since the last time. */
static void tell_tests(const story *s)
{
    fprintf(s->out, "    tested %llu boxes and %llu triangles\n",
            (unsigned long long)s->t->counters->box_tests,
            (unsigned long long)s->t->counters->triangle_tests);
    *s->t->counters = (rk_counters){0};
}

static void tell_shadows(const story *s, const rk_light *light)
{
    const rk_tile_light_sums *sums = &s->t->sums;
    uint32_t asked = sums->asked[0], free = sums->free[0];
    if (asked == 0)
        return;
    if (light->kind == RK_LIGHT_POINT) {
        const rk_surface *surface = &s->t->seen[0].surface;
        tell_vector(s->out, "    shadow ray from",
                    rk_surface_spawn(surface, rk_sub(light->position, surface->point)));
    } else {
        fprintf(s->out, "    %u shadow rays, %u of them not blocked\n", asked, free);
    }
    tell_tests(s);
    fprintf(s->out, "    %s\n",
            free == 0                           ? "something is in the way: in shadow"
            : sums->state[0] == RK_LIGHT_TINTED ? "the way leads through glass"
            : free == asked                     ? "the way is free"
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
    const rk_shading_point *seen = &s->t->seen[0];
    rk_vec3 before = s->t->sum[0];
    fprintf(s->out, "light %u, %s\n", index, kinds[light->kind]);
    tell_vector(s->out, "    position", light->position);
    tell_vector(s->out, "    colour", light->colours[0]);
    float cos_i =
        rk_dot(seen->surface.normal, rk_normalize(rk_sub(light->position, seen->surface.point)));
    fprintf(s->out, "    n.l = %.6f%s\n", (double)cos_i,
            cos_i > 0 ? "" : ": the surface is turned away");
    if (!rk_light_emits(light)) {
        fprintf(s->out, "    the light is black\n");
        return;
    }
    *s->t->counters = (rk_counters){0};
    rk_parallelogram_light_stage(s->r, s->t, index);
    rk_vec3 all = s->t->sums.all[0];
    if (all.x == 0 && all.y == 0 && all.z == 0)
        fprintf(s->out, "    nothing is reflected to the viewer\n");
    tell_shadows(s, light);
    tell_vector(s->out, "    adds to the pixel", rk_sub(s->t->sum[0], before));
}

static void tell_hit(const story *s, const rk_hit *hit)
{
    const rk_shading_point *seen = &s->t->seen[0];
    uint32_t triangles = s->r->scene->mesh.triangle_count;
    if (hit->triangle < triangles)
        fprintf(s->out, "    met triangle %u at t = %.6f\n", hit->triangle, (double)hit->t);
    else
        fprintf(s->out, "    met sphere %u at t = %.6f\n", hit->triangle - triangles,
                (double)hit->t);
    tell_vector(s->out, "    point", seen->surface.point);
    if (hit->triangle < triangles)
        tell_vector(s->out, "    barycentric", seen->surface.barycentric);
    tell_vector(s->out, "    face normal", seen->surface.face_normal);
    tell_vector(s->out, "    shading normal", seen->surface.normal);
    tell_vector(s->out, "    kd", seen->kd);
    if (s->r->plan.transparency)
        fprintf(s->out, "    alpha = %.6f\n", (double)seen->surface.material->alpha);
    tell_vector(s->out, "    counts in the pixel", seen->path.weight);
}

static void tell_path(const story *s, const rk_path_batch *path, const char *name);

static void tell_disk(const story *s)
{
    const rk_glossy_disk disk = rk_glossy_disk_at(&s->r->options->glossy, &s->t->seen[0]);
    fprintf(s->out, "    mirrors into a disk of radius %g, %.1f %% of which is above the surface\n",
            (double)disk.radius, 100 * (double)rk_glossy_fraction_above(&disk));
}

/* A surface on a path, its light, and what it mirrors. */
static void tell_surface(const story *s, const rk_path_batch *path, const rk_hit *hit,
                         uint32_t panes, float share)
{
    rk_path_batch mirrored;
    mirrored.rays.count = 0;
    rk_shading_point_at(&s->t->seen[0], s->r, s->t, path, 0, hit, panes, share);
    s->t->seen_count = 1;
    tell_hit(s, hit);
    for (uint32_t i = 0; i < s->r->scene->light_count; i++)
        tell_light(s, i);
    if (s->r->plan.reflections)
        rk_spawn_reflection(&s->t->seen[0], &mirrored);
    if (mirrored.rays.count && s->r->plan.glossy)
        tell_disk(s);
    if (mirrored.rays.count)
        tell_path(s, &mirrored, "mirrored ray");
}

static void tell_environment(const story *s, const rk_path_batch *path, float share)
{
    rk_vec3 adds = rk_environment_radiance(s->r, path, 0, share, s->t->counters);
    fprintf(s->out, "%s: the environment\n", share < 1 ? "    behind it all" : "    met nothing");
    tell_vector(s->out, "    adds to the pixel", adds);
    s->t->sum[0] = rk_add(s->t->sum[0], adds);
}

static void tell_path(const story *s, const rk_path_batch *path, const char *name)
{
    rk_crossing_list list;
    float weights[RK_MAX_DEPTH + 1], behind = 1;
    rk_ray ray = rk_batch_ray(&path->rays, 0);
    fprintf(s->out, "%s\n", name);
    tell_vector(s->out, "    origin", ray.origin);
    tell_vector(s->out, "    direction", ray.direction);
    *s->t->counters = (rk_counters){0};
    if (s->r->plan.transparency) {
        behind = rk_trace_transparent(s->r, s->t, path, 0, &list, weights);
        tell_tests(s);
        for (uint32_t k = 0; k < list.count; k++) {
            rk_hit hit = rk_crossing_hit(&list.crossings[k]);
            tell_surface(s, path, &hit, k, weights[k]);
        }
        if (list.count > 0 && !(s->r->plan.environment && behind > 0))
            return;
    } else {
        rk_trace_closest(s->r, s->t, path);
        tell_tests(s);
        rk_hit hit = rk_batch_hit(&s->t->hits, 0);
        if (hit.triangle != RK_MISS) {
            tell_surface(s, path, &hit, 0, 1);
            return;
        }
    }
    if (s->r->plan.environment)
        tell_environment(s, path, behind);
    else
        fprintf(s->out, "    met nothing: black\n");
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
    rk_moving_prepare(&r);
    rk_tile t = {.x = x,
                 .y = y,
                 .width = 1,
                 .height = 1,
                 .samples = options->samples,
                 .turns = rk_time_passes(&r.plan, options, options->samples),
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
    if (r.plan.lens)
        fprintf(out,
                "where it is out of focus, rays start all over the lens; this one at its centre\n");
    if (r.plan.glossy)
        fprintf(out,
                "the picture averages %u ray%s in the disk of a rough mirror; those told here go "
                "through its middle\n",
                options->glossy.samples, options->glossy.samples == 1 ? "" : "s");
    const story s = {out, &r, &t};
    tell_path(&s, &camera, "camera ray");
    if (t.in_motion[0])
        fprintf(out, "a ray may meet what moves: this was seen at x = %.6f, one of %u times\n",
                (double)t.time[0], t.turns * t.samples);
    tell_vector(out, "colour (linear)", t.sum[0]);
    if (r.plan.bloom)
        fprintf(out, "the glow of bright pixels comes on top, when all are rendered\n");
}
