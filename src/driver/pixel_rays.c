/* Projects recorded rays by the view of the picture that they make; what is behind the viewer is
 * clipped, as debug views do it. */
#include "driver/pixel_rays.h"

#include "driver/overlay.h"

/* Where a ray that hits nothing is said to end: far beyond any scene. */
static const float FAR = 1e4f;

/* Behind transparent surfaces a ray ends at the last one that it crosses. */
static float end_of(const rk_ray_record *record, const rk_ray_record_entry *entry)
{
    float t = entry->ray.t_max;
    if (entry->kind != RK_RAY_SHADOW && entry->crossing_count > 0)
        t = record->crossings[entry->first_crossing + entry->crossing_count - 1].t;
    else if (entry->kind != RK_RAY_SHADOW && entry->hit.triangle != RK_MISS)
        t = entry->hit.t;
    return rk_min(t, FAR);
}

static const char *kind_of(const rk_ray_record_entry *entry)
{
    static const char *const kinds[] = {"camera", "reflected", "shadow"};
    return entry->occluded ? "occluded" : kinds[entry->kind];
}

void rk_print_pixel_rays(FILE *out, const rk_ray_record *record, const rk_view *view)
{
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *entry = &record->rays[i];
        const float t = end_of(record, entry);
        rk_vec3 from = entry->ray.origin, to = rk_madd(from, entry->ray.direction, t);
        rk_vec2 a, b;
        float depth;
        if (rk_overlay_clip(view, &from, &to) && rk_view_project(view, from, &a, &depth) &&
            rk_view_project(view, to, &b, &depth))
            fprintf(out, "@ %s %.3f %.3f %.3f %.3f\n", kind_of(entry), (double)a.x, (double)a.y,
                    (double)b.x, (double)b.y);
    }
}
