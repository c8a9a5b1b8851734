/* The rays that the renderer traces for one pixel, in their order. A view that draws them computes
 * none of its own, and so it cannot differ from the picture; not installed. */
#ifndef RK_RENDER_RAY_RECORD_H
#define RK_RENDER_RAY_RECORD_H

#include "base/parallel.h"
#include "features/transparency.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

typedef enum rk_ray_record_kind {
    RK_RAY_CAMERA,
    RK_RAY_REFLECTED,
    RK_RAY_SHADOW
} rk_ray_record_kind;

typedef struct rk_ray_record_entry {
    rk_ray ray;
    rk_ray_record_kind kind;
    uint32_t sample;         /* of the pixel */
    uint32_t bounce;         /* reflections before its start: 0 for camera rays */
    rk_hit hit;              /* the closest, RK_MISS without one; unset for shadow rays */
    bool occluded;           /* a shadow ray, by something opaque */
    size_t first_crossing;   /* of record->crossings; sorted, with transparent surfaces in the */
    uint32_t crossing_count; /* scene, else 0. An occluded ray ends its search at what is opaque */
} rk_ray_record_entry;

typedef struct rk_ray_record {
    uint32_t pixel;    /* of the picture, row by row */
    bool through_lens; /* with a lens: as if the pixel were out of focus */
    rk_ray_record_entry *rays;
    size_t count, capacity;
    rk_crossing *crossings; /* of all rays, one ray after the other */
    size_t crossing_count, crossing_capacity;
    bool is_short; /* of memory: rays are missing */
} rk_ray_record;

/* Renders the record's pixel as rk_render does, and records its rays: those of its samples, but
 * not of what is looked at before, such as the centre rays of a lens. Adaptive sampling renders the
 * whole picture. The caller frees the record, also after an error. */
bool rk_ray_record_pixel(rk_ray_record *record, const rk_scene *scene, const rk_accel *accel,
                         const rk_render_options *options, rk_pool *pool, rk_error *error);

/* Leaves what is to be recorded. */
void rk_ray_record_free(rk_ray_record *record);

/* Returns the number of rays of a kind that are `bounce` reflections from the camera, among all
 * samples of the pixel. */
size_t rk_ray_record_count(const rk_ray_record *record, rk_ray_record_kind kind, uint32_t bounce);

/* For the stages. `hits`: the closest, ray for ray. */
void rk_ray_record_paths(const rk_rendering *r, const rk_sample_pass *pass,
                         const rk_path_batch *paths, const rk_hit_batch *hits);
/* With the ray's crossings. */
void rk_ray_record_path(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_path_batch *paths, uint32_t i, const rk_crossing_list *list);
/* `pixels`: of the tile. */
void rk_ray_record_shadow_rays(const rk_rendering *r, const rk_sample_pass *pass,
                               const rk_ray_batch *rays, const uint16_t *pixels,
                               const bool *occluded);
void rk_ray_record_shadow_ray(const rk_rendering *r, const rk_sample_pass *pass, const rk_ray *ray,
                              uint32_t pixel, bool occluded, const rk_crossing_list *list);

#endif
