/* Runs the renderer's own stages on a tile of one pixel, one path at a time, and prints what they
 * return: so the explanation cannot differ from the picture. Lines are indented as the rays nest:
 * hits stand below their ray; lights and reflected rays, below their hit. */
#include "driver/explain_pixel.h"

#include "driver/pixel_code.h"
#include "driver/pixel_rays.h"
#include "driver/unsolved.h"
#include "io/srgb8.h"
#include "render/feature_hooks.h"
#include "render/feature_list.h"
#include "render/stages/cubemap_stage.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/light_stage.h"
#include "render/stages/reflection_stage.h"
#include "render/stages/shade_stage.h"
#include "render/stages/trace_stage.h"
#include "render/time_passes.h"

#include <stdarg.h>

typedef struct explanation {
    FILE *out;
    bool with_code;
    const rk_rendering *r;
    rk_sample_pass *pass;
    rk_shading_points *points; /* one */
    rk_light_workspace *lights;
    rk_film *film;
    int depth;      /* of the next line, in steps of four columns */
    bool *has_time; /* has the sample's time been printed? */
} explanation;

__attribute__((format(printf, 2, 3))) static void print_line(const explanation *e,
                                                             const char *format, ...)
{
    va_list values;
    fprintf(e->out, "%*s", 4 * e->depth, "");
    va_start(values, format);
    vfprintf(e->out, format, values);
    va_end(values);
    fprintf(e->out, "\n");
}

static void print_vector(const explanation *e, const char *label, rk_vec3 v)
{
    print_line(e, "%-18s (% .6f, % .6f, % .6f)", label, (double)v.x, (double)v.y, (double)v.z);
}

/* Announces the code of the lines that follow. */
static void print_code(const explanation *e, rk_pixel_code code)
{
    if (e->with_code)
        rk_print_pixel_code(e->out, code);
}

/* Linear, and as a picture file stores it. */
static void print_colour(const explanation *e, rk_vec3 colour)
{
    rk_srgb8 table;
    rk_srgb8_init(&table);
    print_line(e, "%-22s (% .6f, % .6f, % .6f)", "colour (linear)", (double)colour.x,
               (double)colour.y, (double)colour.z);
    print_code(e, RK_CODE_STORED);
    print_line(e, "%-22s (%d, %d, %d)", "colour (sRGB, 8 bits)", rk_srgb8_encode(&table, colour.x),
               rk_srgb8_encode(&table, colour.y), rk_srgb8_encode(&table, colour.z));
}

/* Once, before the tests of the first ray that needs it: all that follows depends on it. */
static void print_time(const explanation *e)
{
    if (!e->pass->needs_time[0] || *e->has_time)
        return;
    print_line(e, "may hit a moving object: the time is x = %.6f, one of %u",
               (double)e->pass->time[0], e->pass->time_passes * e->r->options->samples);
    *e->has_time = true;
}

/* The tests since the counters were last cleared. */
static void print_tests(const explanation *e)
{
    print_time(e);
    print_line(e, "tested %llu boxes and %llu triangles",
               (unsigned long long)e->pass->counters->box_tests,
               (unsigned long long)e->pass->counters->triangle_tests);
    *e->pass->counters = (rk_counters){0};
}

/* Binary trees are traversed by bvh_median's functions, wide ones by their kernel. */
static bool is_wide(const explanation *e)
{
    return e->r->accel->kind >= RK_ACCEL_COLLAPSED;
}

static void print_shadows(const explanation *e, const rk_light *light)
{
    const rk_light_sums *sums = &e->lights->sums;
    uint32_t traced = sums->traced[0], unoccluded = sums->unoccluded[0];
    const bool is_clear =
        sums->visibility[0] == RK_LIGHT_CLEAR ||
        (sums->visibility[0] == RK_LIGHT_SUMMED && !rk_is_black(sums->unshadowed[0]));
    if (is_clear && e->r->plan.shadow_rays) {
        print_line(e, "no shadow rays: there is no surface between point and light");
        print_tests(e);
        print_line(e, "unoccluded");
    }
    if (traced == 0)
        return;
    if (light->kind == RK_LIGHT_POINT) {
        const rk_surface *surface = &e->points->points[0].surface;
        print_code(e, RK_CODE_SPAWN);
        print_vector(e, "shadow ray origin",
                     rk_surface_spawn_to_light(surface, rk_sub(light->position, surface->point)));
    } else {
        print_code(e, RK_CODE_LIGHT_SAMPLE);
        print_line(e, "%u shadow rays, %u unoccluded", traced, unoccluded);
    }
    print_code(e, e->r->plan.transparency ? RK_CODE_TRANSMIT
                  : is_wide(e)            ? RK_CODE_WIDE_OCCLUSION
                                          : RK_CODE_BINARY_OCCLUSION);
    print_tests(e);
    print_line(e, "%s",
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
    print_line(e, "nothing is reflected to the viewer%s%s", *unsolved.text ? ": " : "",
               unsolved.text);
}

/* The line of rk_shade that a light of this cosine reaches. */
static rk_pixel_code shading_code(const explanation *e, float cos_i)
{
    const rk_shading_model model = e->r->options->shading.model;
    if (model == RK_SHADING_OFF)
        return RK_CODE_OFF;
    if (model == RK_SHADING_GRADIENT)
        return RK_CODE_GRADIENT;
    if (!(cos_i > 0))
        return RK_CODE_FACES_AWAY;
    const rk_material *material = e->points->points[0].surface.material;
    return model == RK_SHADING_LAMBERT || rk_is_black(material->ks) ? RK_CODE_LAMBERT
                                                                    : RK_CODE_HIGHLIGHT;
}

/* The radiance that the light adds at the shading point. */
static void print_light(const explanation *e, uint32_t index)
{
    const rk_light *light = &e->r->scene->lights[index];
    const rk_shading_point *point = &e->points->points[0];
    rk_vec3 before = e->film->sum[0];
    print_vector(e, "position", light->position);
    print_vector(e, "colour", light->colours[0]);
    float cos_i =
        rk_dot(point->surface.normal, rk_normalize(rk_sub(light->position, point->surface.point)));
    print_code(e, RK_CODE_COSINE);
    print_line(e, "n.l = %.6f%s", (double)cos_i, cos_i > 0 ? "" : ": the surface faces away");
    if (!rk_light_emits(light)) {
        print_line(e, "the light is black");
        return;
    }
    *e->pass->counters = (rk_counters){0};
    rk_parallelogram_light_stage(e->r, e->pass, e->points, index, &e->lights->queue,
                                 &e->lights->answers, &e->lights->sums, e->film);
    rk_vec3 all = e->lights->sums.unshadowed[0];
    if (all.x == 0 && all.y == 0 && all.z == 0)
        print_nothing(e);
    print_shadows(e, light);
    print_code(e, shading_code(e, cos_i));
    print_vector(e, "adds to the pixel", rk_sub(e->film->sum[0], before));
}

/* The contributions of features by their own hooks. */
static void print_features(explanation *e)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (!rk_features[i]->shade || !rk_plan_has(&e->r->plan, i))
            continue;
        rk_vec3 before = e->film->sum[0];
        if (i == RK_FEATURE_ambient_occlusion)
            print_code(e, RK_CODE_AMBIENT);
        print_line(e, "%s", rk_features[i]->stem);
        e->depth++;
        *e->pass->counters = (rk_counters){0};
        rk_features[i]->shade(e->r, e->pass, e->points, e->film);
        print_tests(e);
        print_vector(e, "adds to the pixel", rk_sub(e->film->sum[0], before));
        e->depth--;
    }
}

static void print_hit(const explanation *e, const rk_hit *hit)
{
    uint32_t triangles = e->r->scene->mesh.triangle_count;
    bool is_triangle = hit->triangle < triangles;
    print_line(e, "hit %s %u at t = %.6f", is_triangle ? "triangle" : "sphere",
               is_triangle ? hit->triangle : hit->triangle - triangles, (double)hit->t);
}

static void print_point(const explanation *e, const rk_hit *hit)
{
    const rk_shading_point *point = &e->points->points[0];
    const bool is_triangle = hit->triangle < e->r->scene->mesh.triangle_count;
    print_code(e, is_triangle ? RK_CODE_SURFACE : RK_CODE_SPHERE);
    print_vector(e, "point", point->surface.point);
    if (is_triangle)
        print_vector(e, "barycentric", point->surface.barycentric);
    print_vector(e, "face normal", point->surface.face_normal);
    print_vector(e, "shading normal", point->surface.normal);
    print_vector(e, "kd", point->kd);
    if (e->r->plan.transparency)
        print_line(e, "alpha = %.6f", (double)point->surface.material->alpha);
    print_vector(e, "throughput", point->path.throughput);
}

static void print_path(explanation *e, const rk_path_batch *path, const char *name,
                       rk_pixel_code code);

static void print_disk(const explanation *e)
{
    const rk_glossy_disk disk = rk_glossy_disk_at(&e->r->options->glossy, &e->points->points[0]);
    print_code(e, RK_CODE_DISK);
    print_line(e, "reflects into a disk of radius %g, %.1f %% of it above the surface",
               (double)disk.radius, 100 * (double)rk_glossy_fraction_above(&disk));
}

/* How a lens blurs what the camera ray hits, and one of the rays that start on the lens. */
static void print_lens(explanation *e, const rk_hit *hit)
{
    const rk_vec2 xi = {0.25f, 0.25f};
    const rk_tile *pixel = &e->pass->tile;
    float x = (float)pixel->x + 0.5f, y = (float)pixel->y + 0.5f;
    rk_ray ray = rk_lens_ray(&e->r->options->lens, &e->r->view, x, y, xi);
    print_line(e, "lens ray for xi = (%g, %g)", (double)xi.x, (double)xi.y);
    e->depth++;
    print_vector(e, "origin", ray.origin);
    print_vector(e, "direction", ray.direction);
    e->depth--;
    rk_ray centre = rk_view_ray(&e->r->view, x, y);
    float diameter = rk_lens_coc_diameter(&e->r->options->lens, &e->r->view, &centre, hit->t);
    print_line(e, "circle of confusion: %.6f pixels", (double)diameter);
}

/* The shading point, its lights, and its reflection. */
static void print_surface(explanation *e, const rk_hit *hit)
{
    const rk_shading_point *point = &e->points->points[0];
    rk_path_batch reflected;
    reflected.rays.count = 0;
    print_hit(e, hit);
    e->depth++;
    print_point(e, hit);
    if (e->depth == 2 && e->r->plan.depth_of_field)
        print_lens(e, hit);
    print_features(e);
    for (uint32_t i = 0; i < e->r->scene->light_count; i++) {
        print_line(e, "light %u, %s", i, kinds[e->r->scene->lights[i].kind]);
        e->depth++;
        print_light(e, i);
        e->depth--;
    }
    if (e->r->plan.reflections && rk_is_specular(point))
        rk_spawn_reflection(point, &reflected);
    if (reflected.rays.count && e->r->plan.glossy_reflection)
        print_disk(e);
    if (reflected.rays.count) {
        e->pass->bounce++;
        print_path(e, &reflected, "reflected ray", RK_CODE_REFLECT);
        e->pass->bounce--;
    }
    e->depth--;
}

static void print_environment(const explanation *e, const rk_path_batch *path, float fraction)
{
    if (!e->r->plan.background) {
        print_line(e, "no hit: black");
        return;
    }
    print_code(e, RK_CODE_ENVIRONMENT);
    rk_vec3 adds = rk_environment_radiance(e->r, path, 0, fraction, e->pass->counters);
    print_line(e, "%s: the %s", fraction < 1 ? "behind all surfaces" : "no hit",
               e->r->plan.cubemap ? "environment" : "background");
    print_vector(e, "adds to the pixel", adds);
    rk_film_add(e->film, 0, adds);
}

static void print_closest(explanation *e, const rk_path_batch *path)
{
    rk_hit_batch hits;
    rk_ray_times times = {.time = {0}};
    rk_trace_closest(e->r, e->pass, path, &hits, &times);
    print_code(e, is_wide(e) ? RK_CODE_WIDE_TREE : RK_CODE_BINARY_TREE);
    print_tests(e);
    rk_hit hit = rk_batch_hit(&hits, 0);
    if (hit.triangle == RK_MISS) {
        print_environment(e, path, 1);
        return;
    }
    rk_shading_point_at(e->points->points, e->r, path, 0, &hit, times.time[0]);
    print_surface(e, &hit);
}

static void print_visible(explanation *e, const rk_path_batch *path)
{
    rk_visible_hits visible;
    rk_transparency_stage(e->r, e->pass, path, 0, &visible);
    print_code(e, RK_CODE_TRANSPARENCY);
    print_tests(e);
    for (uint32_t k = 0; k < visible.count; k++) {
        rk_shading_point_behind(e->points->points, e->r, path, 0, &visible, k);
        print_surface(e, &visible.hits[k]);
    }
    if (visible.count == 0 || (e->r->plan.background && visible.behind > 0))
        print_environment(e, path, visible.behind);
}

static void print_path(explanation *e, const rk_path_batch *path, const char *name,
                       rk_pixel_code code)
{
    rk_ray ray = rk_batch_ray(&path->rays, 0);
    print_code(e, code);
    print_line(e, "%s", name);
    e->depth++;
    print_vector(e, "origin", ray.origin);
    print_vector(e, "direction", ray.direction);
    *e->pass->counters = (rk_counters){0};
    if (e->r->plan.transparency)
        print_visible(e, path);
    else
        print_closest(e, path);
    e->depth--;
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

static void print_pixel(FILE *out, const rk_rendering *r, uint32_t x, uint32_t y, bool with_code)
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
    bool has_time = false;
    explanation e = {out, with_code, r, &pass, &points, &lights, &film, 0, &has_time};
    print_path(&e, &camera, "camera ray", RK_CODE_CAMERA_RAY);
    print_colour(&e, film.sum[0]);
}

void rk_explain_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y, bool with_code,
                      bool with_rays)
{
    rk_error error = {""};
    rk_rendering r = rk_rendering_of(scene, accel, options);
    rk_ray_record record = {.pixel = y * options->width + x};
    r.record = with_rays ? &record : NULL;
    fprintf(out, "pixel (%u, %u) of %s\n", x, y, scene->name);
    print_notes(out, &r);
    if (rk_features_prepare(&r, &error))
        print_pixel(out, &r, x, y, with_code);
    else
        fprintf(out, "%s\n", error.text);
    rk_features_release(&r);
    if (r.plan.bloom)
        fprintf(out, "bloom is added when all pixels are rendered\n");
    rk_print_pixel_rays(out, &record, &r.view);
    rk_ray_record_free(&record);
}
