/* Stages hand over each batch that they have traced; the pixel's rays are copied out of it. A pixel
 * belongs to one tile, so only one thread at a time writes. */
#include "render/ray_record.h"

#include <stdlib.h>
#include <string.h>

static bool is_recorded(const rk_rendering *r, const rk_sample_pass *pass, uint32_t pixel)
{
    return rk_picture_pixel(pass, r->options->width, pixel) == r->record->pixel;
}

/* Twice as many each time, so that one costs O(1) on average. Returns the array, or NULL. */
static void *with_room(rk_ray_record *record, void *array, size_t *capacity, size_t count,
                       size_t size)
{
    if (count <= *capacity)
        return array;
    array = realloc(array, 2 * count * size);
    record->is_short |= !array;
    *capacity = array ? 2 * count : *capacity;
    return array;
}

static void put_crossings(rk_ray_record *record, const rk_crossing_list *list)
{
    const size_t count = record->crossing_count + list->count;
    rk_crossing *crossings =
        with_room(record, record->crossings, &record->crossing_capacity, count, sizeof *crossings);
    if (!crossings)
        return;
    memcpy(&crossings[record->crossing_count], list->crossings, list->count * sizeof *crossings);
    record->crossings = crossings;
    record->crossing_count = count;
}

/* `list`: NULL without transparent surfaces. */
static void put(rk_ray_record *record, rk_ray_record_entry ray, const rk_crossing_list *list)
{
    ray.first_crossing = record->crossing_count;
    if (list)
        put_crossings(record, list);
    ray.crossing_count = (uint32_t)(record->crossing_count - ray.first_crossing);
    rk_ray_record_entry *rays =
        with_room(record, record->rays, &record->capacity, record->count + 1, sizeof *rays);
    if (!rays)
        return;
    record->rays = rays;
    rays[record->count++] = ray;
}

static void put_path(const rk_rendering *r, const rk_sample_pass *pass, const rk_path_batch *paths,
                     uint32_t i, rk_hit hit, const rk_crossing_list *list)
{
    if (!is_recorded(r, pass, paths->pixel[i]))
        return;
    put(r->record,
        (rk_ray_record_entry){.ray = rk_batch_ray(&paths->rays, i),
                              .kind = pass->bounce > 0 ? RK_RAY_REFLECTED : RK_RAY_CAMERA,
                              .sample = rk_sample_at(pass, paths->pixel[i]).sample,
                              .bounce = pass->bounce,
                              .hit = hit},
        list);
}

void rk_ray_record_path(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_path_batch *paths, uint32_t i, const rk_crossing_list *list)
{
    const rk_hit miss = {.triangle = RK_MISS};
    put_path(r, pass, paths, i, list->count ? rk_crossing_hit(&list->crossings[0]) : miss, list);
}

void rk_ray_record_paths(const rk_rendering *r, const rk_sample_pass *pass,
                         const rk_path_batch *paths, const rk_hit_batch *hits)
{
    for (uint32_t i = 0; i < paths->rays.count; i++)
        put_path(r, pass, paths, i, rk_batch_hit(hits, i), NULL);
}

void rk_ray_record_shadow_ray(const rk_rendering *r, const rk_sample_pass *pass, const rk_ray *ray,
                              uint32_t pixel, bool occluded, const rk_crossing_list *list)
{
    if (is_recorded(r, pass, pixel))
        put(r->record,
            (rk_ray_record_entry){.ray = *ray,
                                  .kind = RK_RAY_SHADOW,
                                  .sample = rk_sample_at(pass, pixel).sample,
                                  .bounce = pass->bounce,
                                  .occluded = occluded},
            list);
}

void rk_ray_record_shadow_rays(const rk_rendering *r, const rk_sample_pass *pass,
                               const rk_ray_batch *rays, const uint16_t *pixels,
                               const bool *occluded)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        const rk_ray ray = rk_batch_ray(rays, i);
        rk_ray_record_shadow_ray(r, pass, &ray, pixels[i], occluded[i], NULL);
    }
}

void rk_ray_record_free(rk_ray_record *record)
{
    free(record->rays);
    free(record->crossings);
    *record = (rk_ray_record){.pixel = record->pixel, .through_lens = record->through_lens};
}

size_t rk_ray_record_count(const rk_ray_record *record, rk_ray_record_kind kind, uint32_t bounce)
{
    size_t count = 0;
    for (size_t i = 0; i < record->count; i++)
        count += record->rays[i].kind == kind && record->rays[i].bounce == bounce;
    return count;
}
