/* Stages hand over each batch that they have traced; the pixel's rays are copied out of it. A pixel
 * belongs to one tile, so only one thread at a time writes. */
#include "render/ray_record.h"

#include <stdlib.h>

static bool is_recorded(const rk_rendering *r, const rk_sample_pass *pass, uint32_t pixel)
{
    return rk_picture_pixel(pass, r->options->width, pixel) == r->record->pixel;
}

/* Twice as much each time, so that a ray costs O(1) on average. */
static bool make_room(rk_ray_record *record)
{
    if (record->count < record->capacity)
        return true;
    const size_t capacity = record->capacity ? 2 * record->capacity : 64;
    rk_ray_record_entry *rays = realloc(record->rays, capacity * sizeof *rays);
    record->is_short |= !rays;
    if (!rays)
        return false;
    record->rays = rays;
    record->capacity = capacity;
    return true;
}

static void put(rk_ray_record *record, rk_ray_record_entry ray)
{
    if (make_room(record))
        record->rays[record->count++] = ray;
}

void rk_ray_record_path(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_path_batch *paths, uint32_t i, rk_hit hit)
{
    if (!is_recorded(r, pass, paths->pixel[i]))
        return;
    put(r->record,
        (rk_ray_record_entry){.ray = rk_batch_ray(&paths->rays, i),
                              .kind = pass->bounce > 0 ? RK_RAY_REFLECTED : RK_RAY_CAMERA,
                              .sample = rk_sample_at(pass, paths->pixel[i]).sample,
                              .bounce = pass->bounce,
                              .hit = hit});
}

void rk_ray_record_paths(const rk_rendering *r, const rk_sample_pass *pass,
                         const rk_path_batch *paths, const rk_hit_batch *hits)
{
    for (uint32_t i = 0; i < paths->rays.count; i++)
        rk_ray_record_path(r, pass, paths, i, rk_batch_hit(hits, i));
}

void rk_ray_record_shadow_rays(const rk_rendering *r, const rk_sample_pass *pass,
                               const rk_ray_batch *rays, const uint16_t *pixels,
                               const bool *occluded)
{
    for (uint32_t i = 0; i < rays->count; i++)
        if (is_recorded(r, pass, pixels[i]))
            put(r->record, (rk_ray_record_entry){.ray = rk_batch_ray(rays, i),
                                                 .kind = RK_RAY_SHADOW,
                                                 .sample = rk_sample_at(pass, pixels[i]).sample,
                                                 .bounce = pass->bounce,
                                                 .occluded = occluded[i]});
}

size_t rk_ray_record_count(const rk_ray_record *record, rk_ray_record_kind kind, uint32_t bounce)
{
    size_t count = 0;
    for (size_t i = 0; i < record->count; i++)
        count += record->rays[i].kind == kind && record->rays[i].bounce == bounce;
    return count;
}
