#include "rays.h"

#include "accel/query/trace.h"
#include "base/random.h"
#include "features/ambient_occlusion.h"
#include "features/parallelogram_light.h"

#include <assert.h>
#include <stdlib.h>

RK_NAMES(peers_workload_names, peers_workload, PEERS_DIFFUSE, "primary", "point-shadow",
         "area-shadow", "diffuse");

size_t peers_ray_count(const peers_rays *rays)
{
    return rays->batch_count == 0 ? 0
                                  : (rays->batch_count - 1) * RK_BATCH_MAX +
                                        rays->batches[rays->batch_count - 1].count;
}

void peers_rays_free(peers_rays *rays)
{
    free(rays->batches);
    *rays = (peers_rays){0};
}

/* Appends to the last batch; there is memory for one ray per pixel. */
static void push(peers_rays *rays, rk_ray ray)
{
    if (rays->batch_count == 0 || rays->batches[rays->batch_count - 1].count == RK_BATCH_MAX)
        rays->batch_count++;
    rk_batch_push(&rays->batches[rays->batch_count - 1], &ray);
}

/* --- Camera rays ------------------------------------------------------------------------------ */

/* Every second bit of k, from bit 0 on: a coordinate of place k in Z order. */
static uint32_t even_bits(uint32_t k)
{
    uint32_t found = 0;
    for (uint32_t bit = 0; bit < 4; bit++)
        found |= (k >> 2 * bit & 1) << bit;
    return found;
}

static void make_primary(peers_rays *rays, const rk_scene *scene, uint32_t side)
{
    const rk_view view = rk_view_of(&scene->camera, side, side);
    for (uint32_t y = 0; y < side; y += RK_TILE_SIDE)
        for (uint32_t x = 0; x < side; x += RK_TILE_SIDE)
            for (uint32_t k = 0; k < RK_BATCH_MAX; k++)
                push(rays, rk_view_ray(&view, (float)(x + even_bits(k)) + 0.5f,
                                       (float)(y + even_bits(k >> 1)) + 0.5f));
}

/* --- Rays from the primary hits --------------------------------------------------------------- */

/* Two numbers in [0, 1) of ray `index`. */
static rk_vec2 sample_of(size_t index, peers_workload workload)
{
    return (rk_vec2){rk_unit_float(rk_hash((uint32_t)index, workload, 0, 1)),
                     rk_unit_float(rk_hash((uint32_t)index, workload, 1, 1))};
}

/* A parallelogram of area 1 around a point light; others as they are. */
static rk_light with_extent(rk_light light)
{
    if (light.kind != RK_LIGHT_POINT)
        return light;
    light.kind = RK_LIGHT_PARALLELOGRAM;
    light.edge01 = rk_vec(1, 0, 0);
    light.edge02 = rk_vec(0, 0, 1);
    light.position = rk_add(light.position, rk_vec(-0.5f, 0, -0.5f));
    return light;
}

static void push_shadow_ray(peers_rays *rays, const rk_surface *surface, rk_vec3 light)
{
    const rk_vec3 to_light = rk_sub(light, surface->point);
    if (rk_dot(surface->normal, to_light) <= 0)
        return;
    const rk_vec3 start = rk_surface_spawn(surface, to_light);
    push(rays, (rk_ray){start, rk_sub(light, start), 1});
}

static void push_diffuse_ray(peers_rays *rays, const rk_surface *surface, rk_vec2 xi)
{
    rk_vec3 direction;
    const rk_ambient_frame frame = rk_ambient_frame_of(surface->normal, surface->face_normal);
    if (rk_ambient_direction(&frame, rk_ambient_hemisphere(RK_AMBIENT_COSINE, xi), &direction))
        push(rays, (rk_ray){rk_surface_spawn(surface, direction), direction, INFINITY});
}

static void push_from(peers_rays *rays, const rk_scene *scene, const rk_surface *surface,
                      size_t index)
{
    const rk_vec2 xi = sample_of(index, rays->workload);
    rk_light light = scene->lights[0];
    if (rays->workload == PEERS_DIFFUSE) {
        push_diffuse_ray(rays, surface, xi);
        return;
    }
    if (rays->workload == PEERS_AREA_SHADOW)
        light = with_extent(light);
    push_shadow_ray(
        rays, surface,
        rk_light_sample_at(&light, RK_FALLOFF_NONE, RK_LIGHT_DOMAIN_AREA, surface->point, xi)
            .position);
}

static void make_secondary(peers_rays *rays, const rk_accel *accel, const peers_rays *primary)
{
    rk_counters counters = {0};
    for (size_t b = 0; b < primary->batch_count; b++) {
        const rk_ray_batch *batch = &primary->batches[b];
        rk_hit_batch hits;
        rk_accel_closest(accel, batch, &hits, &counters);
        for (uint32_t i = 0; i < batch->count; i++) {
            rk_surface surface;
            const rk_ray ray = rk_batch_ray(batch, i);
            const rk_hit hit = rk_batch_hit(&hits, i);
            if (hit.triangle == RK_MISS)
                continue;
            rk_scene_surface(&surface, accel->scene, &ray, &hit);
            push_from(rays, accel->scene, &surface, b * RK_BATCH_MAX + i);
        }
    }
}

bool peers_rays_make(peers_rays *rays, peers_workload workload, const rk_accel *accel,
                     uint32_t side, rk_error *error)
{
    assert(side % RK_TILE_SIDE == 0);
    const size_t batches = (size_t)side * side / RK_BATCH_MAX;
    *rays = (peers_rays){.workload = workload};
    rays->batches = rk_allocate(batches, sizeof *rays->batches, "rays", error);
    if (!rays->batches)
        return false;
    if (workload == PEERS_PRIMARY) {
        make_primary(rays, accel->scene, side);
        return true;
    }
    peers_rays primary;
    if (!peers_rays_make(&primary, PEERS_PRIMARY, accel, side, error)) {
        peers_rays_free(rays);
        return false;
    }
    make_secondary(rays, accel, &primary);
    peers_rays_free(&primary);
    return true;
}
