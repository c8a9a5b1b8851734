#include "render/narrate.h"

#include "scene/surface.h"

static void tell_vector(FILE *out, const char *what, rk_vec3 v)
{
    fprintf(out, "%-22s (% .6f, % .6f, % .6f)\n", what, (double)v.x, (double)v.y, (double)v.z);
}

static void tell_tests(FILE *out, const rk_counters *counters)
{
    fprintf(out, "    tested %llu boxes and %llu triangles\n",
            (unsigned long long)counters->box_tests, (unsigned long long)counters->triangle_tests);
}

static rk_hit closest(const rk_accel *accel, const rk_ray *ray, rk_counters *counters)
{
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_batch_push(&rays, ray);
    rk_accel_closest(accel, &rays, &hits, counters);
    return rk_batch_hit(&hits, 0);
}

static bool any(const rk_accel *accel, const rk_ray *ray, rk_counters *counters)
{
    rk_ray_batch rays = {.count = 0};
    rk_any_batch answers;
    rk_batch_push(&rays, ray);
    rk_accel_any(accel, &rays, &answers, counters);
    return answers.found[0];
}

static rk_vec3 tell_light(FILE *out, uint32_t index, const rk_scene *scene, const rk_accel *accel,
                          const rk_surface *surface, bool shadows)
{
    const rk_light *light = &scene->lights[index];
    rk_vec3 to_light = rk_sub(light->position, surface->point);
    float cos_i = rk_dot(surface->normal, rk_normalize(to_light));
    fprintf(out, "light %u\n", index);
    tell_vector(out, "    position", light->position);
    tell_vector(out, "    colour", light->colours[0]);
    fprintf(out, "    n.l = %.6f%s\n", (double)cos_i,
            cos_i > 0 ? "" : ": the surface is turned away, nothing arrives");
    if (!(cos_i > 0))
        return rk_vec(0, 0, 0);
    rk_vec3 reflected = rk_mul(surface->material->kd, light->colours[0]);
    if (reflected.x == 0 && reflected.y == 0 && reflected.z == 0) {
        fprintf(out, "    the light is black, or the surface is to it: nothing is reflected\n");
        return rk_vec(0, 0, 0);
    }
    if (shadows) {
        rk_vec3 start = rk_surface_leave(surface, to_light);
        rk_ray ray = {start, rk_sub(light->position, start), 1};
        rk_counters counters = {0};
        bool blocked = any(accel, &ray, &counters);
        tell_vector(out, "    shadow ray from", start);
        tell_tests(out, &counters);
        fprintf(out, "    %s\n",
                blocked ? "something is in the way: in shadow" : "the way is free");
        if (blocked)
            return rk_vec(0, 0, 0);
    }
    rk_vec3 arriving = rk_scale(reflected, cos_i);
    tell_vector(out, "    kd colour n.l =", arriving);
    return arriving;
}

void rk_narrate_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y)
{
    rk_view view = rk_view_of(&scene->camera, options->width, options->height);
    rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
    rk_plan plan = rk_plan_of(scene, options);
    rk_counters counters = {0};
    rk_hit hit = closest(accel, &ray, &counters);
    fprintf(out, "pixel (%u, %u) of %s\n", x, y, scene->name);
    if (plan.pixel_samples)
        fprintf(out,
                "the picture averages %u rays through it; this is the one through its centre\n",
                options->samples);
    fprintf(out, "camera ray\n");
    tell_vector(out, "    origin", ray.origin);
    tell_vector(out, "    direction", ray.direction);
    tell_tests(out, &counters);
    if (hit.triangle == RK_MISS) {
        fprintf(out, "    met nothing: the pixel is black\n");
        return;
    }
    rk_surface surface;
    rk_scene_surface(&surface, scene, &ray, &hit);
    uint32_t triangles = scene->mesh.triangle_count;
    if (hit.triangle < triangles)
        fprintf(out, "    met triangle %u at t = %.6f\n", hit.triangle, (double)hit.t);
    else
        fprintf(out, "    met sphere %u at t = %.6f\n", hit.triangle - triangles, (double)hit.t);
    tell_vector(out, "    point", surface.point);
    if (hit.triangle < triangles)
        tell_vector(out, "    barycentric", surface.barycentric);
    tell_vector(out, "    face normal", surface.face_normal);
    tell_vector(out, "    shading normal", surface.normal);
    tell_vector(out, "    kd", surface.material->kd);
    rk_vec3 colour = rk_vec(0, 0, 0);
    for (uint32_t i = 0; i < scene->light_count; i++)
        colour = rk_add(colour, tell_light(out, i, scene, accel, &surface, plan.shadow_rays));
    tell_vector(out, "colour (linear)", colour);
}
