/* The plan: what a scene and its options need. What is not needed is not built, sampled or
 * branched on; the counters prove it. */
#ifndef RK_RENDER_PLAN_H
#define RK_RENDER_PLAN_H

#include "base/sampler.h"
#include "features/bloom.h"
#include "features/cubemap.h"
#include "features/depth_of_field.h"
#include "features/glossy_reflection.h"
#include "features/motion_blur.h"
#include "features/parallelogram_light.h"
#include "features/shading.h"
#include "features/transparency.h"
#include "scene/scene.h"

/* How lights with an extent are sampled. */
typedef struct rk_light_options {
    uint32_t samples; /* a light and a point that it may shine on */
    rk_sampler_kind sampling;
    rk_light_domain domain;
    rk_light_falloff falloff;
    bool ratio;         /* unshadowed light in closed form, times the share that is seen */
    uint32_t early_out; /* so many shadow rays that agree settle a point; 0: trace all */
} rk_light_options;

/* When what moves is seen. */
typedef struct rk_motion_options {
    rk_shutter shutter;
    uint32_t samples; /* times that a pixel's samples see together, each that motion may change as
                         many as the others; 0: everything rests */
    rk_time_sampling sampling;
    float isolate; /* NaN, or the one equidistant time to see, 1 to `samples` or beyond; counts for
                      nothing where `samples` is 0 */
} rk_motion_options;

/* How rough mirrors blur what they show. The first one on a way spreads a ray into `samples`; each
 * of those takes a single random direction at every further one, so that work does not multiply. */
typedef struct rk_glossy_options {
    uint32_t samples; /* 0: mirrors are perfect */
    float radius;     /* of all disks; NaN or negative: by the material's shininess */
    rk_glossy_weights weights;
    rk_disk_map map;
    rk_sampler_kind sampling;
} rk_glossy_options;

typedef struct rk_render_options {
    uint32_t width, height; /* pixels */
    uint32_t samples;       /* a pixel; 1 looks through its centre */
    rk_sampler_kind sampling;
    uint32_t seed;
    bool shadows;
    rk_shading shading;
    bool reflections; /* surfaces with ks mirror what is around them */
    bool
        transparency; /* surfaces with alpha < 1 show what is behind them, and tint their shadows */
    rk_glass_model glass;
    uint32_t
        max_depth; /* surfaces behind the first that a ray may go on to, by mirrors and panes */
    rk_light_options light;
    rk_bloom_options bloom;
    rk_cubemap_filter environment_filter;
    rk_lens lens;
    uint32_t lens_samples; /* a pixel that is out of focus, and at least `samples`; each has a place
                              of its own on the lens and in the pixel; 0 is a pinhole */
    rk_sampler_kind lens_sampling; /* of both places */
    rk_motion_options motion;
    rk_glossy_options glossy;
} rk_render_options;

enum { RK_MAX_DEPTH = 16 };

/* What --help lists: each option's row has its default. */
rk_render_options rk_render_options_default(void);

typedef struct rk_plan {
    bool rays;          /* is there an environment, or anything to meet and light to see it by? */
    bool pixel_samples; /* random positions within the pixel */
    bool lights;        /* any light that is not black */
    bool shadow_rays;
    bool textures;     /* some material has one */
    bool viewer;       /* something looks different from elsewhere: highlights, mirrors */
    bool reflections;  /* a surface reflects, and may */
    bool time_samples; /* at times that differ from sample to sample */

    /* One for each feature: is it wanted? */
#define RK_FEATURE(stem) bool stem;
#include "features/list.h"
#undef RK_FEATURE
} rk_plan;

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options);

/* Is one of its colours anything but black? */
bool rk_light_emits(const rk_light *light);

/* Does one of the scene's lights shine? */
bool rk_plan_has_light(const rk_scene *scene);

/* Does it hold for a material of the mesh or of a sphere? */
bool rk_plan_any_material(const rk_scene *scene, bool (*holds)(const rk_material *material));

/* Is a material specular, and may rays be reflected? */
bool rk_plan_reflects(const rk_scene *scene, const rk_render_options *options);

/* Can rk_render draw it? False with an error for a value out of its range or its enumeration, a
 * wrong field of view, more lights or spheres than a scene has room for, and more samples than a
 * sampler has numbers for. The mesh is not looked at: see rk_accel_build. */
bool rk_render_check(const rk_scene *scene, const rk_render_options *options, rk_error *error);

#endif
