/* The plan: what a scene and its options need. What is not needed is not built, sampled or
 * branched on; the counters prove it. */
#ifndef RK_RENDER_PLAN_H
#define RK_RENDER_PLAN_H

#include "scene/scene.h"

typedef struct rk_render_options {
    uint32_t width, height; /* pixels */
    uint32_t samples;       /* a pixel; 1 looks through its centre */
    uint32_t seed;
    bool shadows;
} rk_render_options;

/* 800 x 800, 1 sample, no shadows. */
rk_render_options rk_render_options_default(void);

typedef struct rk_plan {
    bool rays;          /* is there anything to meet? */
    bool pixel_samples; /* random positions within the pixel */
    bool lights;        /* any light that is not black */
    bool shadow_rays;
} rk_plan;

/* Is it anything but black? */
bool rk_light_shines(const rk_light *light);

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options);

#endif
