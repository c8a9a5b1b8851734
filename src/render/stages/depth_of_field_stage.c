/* Which pixels does the lens blur? A ray through each pixel's centre says how large the circle of
 * confusion is of what it sees, and where circles reach, the renderer takes lens samples.
 *
 * Nothing nearer than the focal surface is overlooked: what hides a blurred thing there is nearer
 * still, and has a larger circle. Overlooked is what no centre ray sees: things smaller than a
 * pixel, and things behind the focal surface that sharper ones hide altogether, which a lens sees
 * around their edges. */
#include "render/render.h"
#include "render/tile.h"

#include <stdlib.h>
#include <string.h>

typedef struct focus_pass {
    const rk_rendering *r;
    float *blur; /* diameters in pixels, one for each pixel */
} focus_pass;

static const rk_material *material_at(const rk_scene *scene, const rk_hit *hit)
{
    const rk_mesh *mesh = &scene->mesh;
    return hit->triangle < mesh->triangle_count
               ? &mesh->materials[mesh->triangle_materials[hit->triangle]]
               : &scene->sphere_materials[hit->triangle - mesh->triangle_count];
}

/* What a mirror shows is as far as the ray's whole way, so a sharp mirror needs samples, too. */
static float blur_at(const rk_rendering *r, const rk_ray *ray, const rk_hit *hit)
{
    float blur = rk_lens_coc_diameter(&r->options->lens, &r->view, ray, hit->t);
    if (!r->plan.reflections)
        return blur;
    rk_vec3 ks = material_at(r->scene, hit)->ks;
    return ks.x > 0 || ks.y > 0 || ks.z > 0 ? rk_max(blur, RK_LENS_COC_MIN) : blur;
}

/* What is as far as the environment; without one, nothing is there to be blurred. */
static float blur_at_infinity(const rk_rendering *r, const rk_ray *ray)
{
    return r->plan.environment ? rk_lens_coc_diameter(&r->options->lens, &r->view, ray, INFINITY)
                               : 0;
}

/* The largest circle of all that a ray sees, through panes as well. */
static float blur_through_panes(const rk_rendering *r, rk_tile *t, const rk_path_batch *camera,
                                uint32_t i)
{
    rk_crossing_list list;
    float weights[RK_MAX_DEPTH + 1], blur = 0;
    rk_ray ray = rk_batch_ray(&camera->rays, i);
    float behind = rk_trace_transparent(r, t, camera, i, &list, weights);
    if (r->plan.environment && behind > 0)
        blur = blur_at_infinity(r, &ray);
    for (uint32_t k = 0; k < list.count; k++) {
        rk_hit hit = rk_crossing_hit(&list.crossings[k]);
        if (weights[k] > 0)
            blur = rk_max(blur, blur_at(r, &ray, &hit));
    }
    return blur;
}

static void find_blur(const focus_pass *pass, rk_tile *t, const rk_path_batch *camera)
{
    const rk_rendering *r = pass->r;
    if (!r->plan.transparency)
        rk_trace_closest(r, t, camera);
    for (uint32_t i = 0; i < camera->rays.count; i++) {
        rk_ray ray = rk_batch_ray(&camera->rays, i);
        float *blur =
            &pass->blur[(size_t)(t->y + i / t->width) * r->options->width + t->x + i % t->width];
        rk_hit hit = rk_batch_hit(&t->hits, i);
        if (r->plan.transparency)
            *blur = blur_through_panes(r, t, camera, i);
        else
            *blur = hit.triangle != RK_MISS ? blur_at(r, &ray, &hit) : blur_at_infinity(r, &ray);
        /* At other times it may see something else. */
        if (r->plan.motion && t->in_motion[i])
            *blur = rk_max(*blur, RK_LENS_COC_MIN);
    }
}

static void find_blur_of_tile(uint32_t index, uint32_t thread, void *context)
{
    const focus_pass *pass = context;
    const rk_rendering *r = pass->r;
    rk_tile t;
    rk_path_batch camera;
    rk_tile_start(r, &t, index, thread);
    t.sample = 0; /* what moves is seen at the first of its times */
    t.samples = t.turns = 1;
    camera.rays.count = 0;
    for (uint32_t y = t.y; y < t.y + t.height; y++)
        for (uint32_t x = t.x; x < t.x + t.width; x++) {
            rk_ray ray = rk_view_ray(&r->view, (float)x + 0.5f, (float)y + 0.5f);
            rk_path_push(&camera, &ray, camera.rays.count, rk_path_start(0, r->options->max_depth));
        }
    t.counters->primary_rays += camera.rays.count;
    find_blur(pass, &t, &camera);
}

bool rk_focus_find(rk_rendering *r, rk_pool *pool, rk_error *error)
{
    uint32_t width = r->options->width, height = r->options->height;
    if (!r->plan.lens)
        return true;
    focus_pass pass = {
        r, rk_allocate_unset((size_t)width * height, sizeof *pass.blur, "focus", error)};
    if (pass.blur)
        r->coc_count = rk_allocate_unset(((size_t)width + 1) * (height + 1), sizeof *r->coc_count,
                                         "focus", error);
    if (r->coc_count) {
        rk_pool_run(pool, rk_render_tiles(r->options), find_blur_of_tile, &pass);
        rk_lens_coc(pass.blur, width, height, r->coc_count);
    }
    free(pass.blur);
    return r->coc_count != NULL;
}
