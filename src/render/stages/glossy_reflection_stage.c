/* Rough mirrors: a seen one sends rays into a disk of directions, many if it is the first on its
 * way, otherwise one. A pixel's rays come one after the other, so that those of a batch go nearly
 * the same way. */
#include "render/tile.h"

rk_glossy_disk rk_glossy_disk_at(const rk_glossy_options *options, const rk_shading_point *seen)
{
    float radius = options->radius >= 0 ? options->radius
                                        : rk_glossy_radius(seen->surface.material->shininess);
    return rk_glossy_disk_of(rk_reflected_direction(seen), radius, seen->surface.face_normal);
}

enum { at_once = 64 }; /* samples are drawn so many together */

/* Where a mirror's samples come from. */
typedef struct source {
    rk_glossy_disk disk;
    rk_disk_map map;
    rk_sampler sampler;
    uint32_t pixel, dimension;
    uint32_t first, count; /* samples of the pixel */
    rk_vec2 drawn[at_once];
} source;

static source source_of(const rk_rendering *r, const rk_tile *t, const rk_shading_point *seen)
{
    const rk_render_options *options = r->options;
    /* Each bounce is a stream of its own. */
    uint32_t bounce = options->max_depth - seen->path.left;
    uint32_t count = seen->path.spread ? 1 : options->glossy.samples;
    return (source){
        .disk = rk_glossy_disk_at(&options->glossy, seen),
        .map = options->glossy.map,
        .sampler = {options->glossy.sampling, options->seed,
                    rk_path_samples(r, t, seen->pixel, true)},
        .pixel = rk_tile_pixel(r, t, seen->pixel),
        .dimension =
            rk_sample_index_of(t, seen->pixel).dimension + RK_DIMENSION_GLOSSY + 2 * bounce,
        .first = seen->path.sample * count,
        .count = count,
    };
}

/* To be asked for one i after the other, from 0. */
static bool direction_of(source *s, uint32_t i, rk_vec3 *direction)
{
    uint32_t left = s->count - i;
    if (i % at_once == 0)
        rk_sample_2d_run(&s->sampler, s->pixel, s->first + i, left < at_once ? left : at_once,
                         s->dimension, s->drawn);
    return rk_glossy_direction(&s->disk, rk_disk_at(s->map, s->drawn[i % at_once]), direction);
}

/* What each direction counts for. How many are above has to be known beforehand, but can be asked
 * only where the surface cuts the disk. */
static float weight_of(source *s, rk_glossy_weights weights)
{
    float share = rk_glossy_fraction_above(&s->disk);
    uint32_t above = s->count;
    if (share < 1 && weights == RK_GLOSSY_RENORMALIZED) {
        rk_vec3 direction;
        above = 0;
        for (uint32_t i = 0; i < s->count; i++)
            above += direction_of(s, i, &direction);
    }
    return rk_glossy_weight(weights, above, s->count, share);
}

static void follow(const rk_rendering *r, rk_tile *t, rk_path_batch *mirrored)
{
    t->counters->reflected_rays += mirrored->rays.count;
    if (mirrored->rays.count)
        rk_trace_paths(r, t, mirrored);
    mirrored->rays.count = 0;
}

static void send(const rk_rendering *r, rk_tile *t, const rk_shading_point *seen,
                 rk_path_batch *mirrored)
{
    source s = source_of(r, t, seen);
    if (s.disk.radius == 0) {
        rk_spawn_reflection(seen, mirrored);
        return;
    }
    rk_vec3 weight = rk_scale(rk_mul(seen->path.weight, seen->surface.material->ks),
                              weight_of(&s, r->options->glossy.weights));
    t->counters->glossy_samples += s.count;
    const rk_surface *surface = &seen->surface;
    rk_vec3 start = rk_surface_spawn(surface, s.disk.w);
    for (uint32_t i = 0; i < s.count; i++) {
        rk_vec3 direction;
        if (!direction_of(&s, i, &direction))
            continue;
        if (mirrored->rays.count == RK_BATCH_MAX)
            follow(r, t, mirrored);
        rk_ray ray = {start, direction, INFINITY};
        if (!rk_surface_spawns_alike(surface, s.disk.w, direction))
            ray.origin = rk_surface_spawn(surface, direction);
        rk_path_push(mirrored, &ray, seen->pixel,
                     rk_path_of(weight, s.first + i, true, seen->path.left - 1u));
    }
}

void rk_glossy_stage(const rk_rendering *r, rk_tile *t)
{
    /* Rays that are followed make new seen surfaces in the tile, so mirrors are put aside. */
    rk_shading_point mirrors[RK_BATCH_MAX];
    uint32_t count = 0;
    for (uint32_t i = 0; i < t->seen_count; i++)
        if (rk_is_specular(&t->seen[i]))
            mirrors[count++] = t->seen[i];
    t->seen_count = 0;
    rk_path_batch mirrored;
    mirrored.rays.count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (mirrored.rays.count == RK_BATCH_MAX)
            follow(r, t, &mirrored);
        send(r, t, &mirrors[i], &mirrored);
    }
    follow(r, t, &mirrored);
}
