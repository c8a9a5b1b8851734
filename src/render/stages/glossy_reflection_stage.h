/* Rough mirrors. The first one of a path splits it into many rays within a disk of directions, each
 * further one spawns a single ray. The rays of a point follow each other in the batch, so that they
 * are traced together; not installed. */
#ifndef RK_RENDER_STAGES_GLOSSY_REFLECTION_STAGE_H
#define RK_RENDER_STAGES_GLOSSY_REFLECTION_STAGE_H

#include "render/feature.h"
#include "render/glossy_run.h"
#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"

/* The samples at one point of a rough mirror. */
typedef struct rk_glossy_samples {
    rk_glossy_disk disk;
    float fraction; /* of the disk, into which points are moved */
    rk_disk_map map;
    rk_sampler sampler;
    uint32_t pixel, dimension;
    uint32_t first, count; /* indices among the samples of the pixel */
} rk_glossy_samples;

/* Specular points whose reflected rays are still to be spawned, from sample `sample` of point
 * `next` on. */
typedef struct rk_specular_queue {
    rk_shading_points waiting;
    uint32_t next, sample;
    rk_glossy_samples samples; /* of point `next`, once the first is drawn */
    rk_glossy_run run;         /* of those of its samples that are drawn at once */
    rk_vec3 throughput;        /* of each of its rays */
} rk_specular_queue;

/* Replaces an empty queue by the specular ones of the points. */
void rk_specular_queue_fill(rk_specular_queue *queue, const rk_shading_points *points);

/* Fills `reflected` with the next rays of the queue, up to RK_BATCH_MAX. */
void rk_glossy_reflection_stage(const rk_rendering *r, const rk_sample_pass *pass,
                                rk_specular_queue *queue, rk_path_batch *reflected);

/* The disk of reflected directions; its radius is 0 for a perfect mirror. */
rk_glossy_disk rk_glossy_disk_at(const rk_glossy_options *options, const rk_shading_point *point);

extern const rk_names rk_glossy_weights_names, rk_disk_map_names;

#endif
