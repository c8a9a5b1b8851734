/* Rough mirrors split a path: its first one spawns many rays into a disk of directions, each
 * further one a single ray. The rays of a point come one after the other, so that those of a batch
 * go nearly the same way. */
#ifndef RK_RENDER_STAGES_GLOSSY_REFLECTION_STAGE_H
#define RK_RENDER_STAGES_GLOSSY_REFLECTION_STAGE_H

#include "render/feature.h"
#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"

enum { RK_GLOSSY_DRAWN = 64 }; /* samples are drawn so many together */

/* The samples of one rough mirror. */
typedef struct rk_glossy_samples {
    rk_glossy_disk disk;
    rk_disk_map map;
    rk_sampler sampler;
    uint32_t pixel, dimension;
    uint32_t first, count; /* samples of the pixel */
    rk_vec2 drawn[RK_GLOSSY_DRAWN];
} rk_glossy_samples;

/* Specular points that wait for their rays to be spawned: point `next` is the next one, and of its
 * samples the next one is `sample`. */
typedef struct rk_specular_queue {
    rk_shading_points waiting;
    uint32_t next, sample;
    rk_glossy_samples samples; /* of point `next`, once the first is drawn, */
    rk_vec3 throughput;        /* and of each of its rays */
} rk_specular_queue;

/* The specular ones among the points; the queue was empty. */
void rk_specular_queue_fill(rk_specular_queue *queue, const rk_shading_points *points);

/* Fills `reflected` with the next rays, as many as there is room for or as are left. */
void rk_glossy_reflection_stage(const rk_rendering *r, const rk_sample_pass *pass,
                                rk_specular_queue *queue, rk_path_batch *reflected);

/* The disk of directions of a rough mirror; of radius 0 where it is perfect. */
rk_glossy_disk rk_glossy_disk_at(const rk_glossy_options *options, const rk_shading_point *point);

extern const rk_names rk_glossy_weights_names, rk_disk_map_names;

#endif
