/* The plan: the work that a scene and its options need. Anything else is not built, sampled or
 * branched on; the counters prove it. */
#ifndef RK_RENDER_PLAN_H
#define RK_RENDER_PLAN_H

#include "features/adaptive_sampling.h"
#include "features/ambient_occlusion.h"
#include "features/bloom.h"
#include "features/cubemap.h"
#include "features/depth_of_field.h"
#include "features/glossy_reflection.h"
#include "features/motion_blur.h"
#include "features/normals.h"
#include "features/parallelogram_light.h"
#include "features/sampling.h"
#include "features/shading.h"
#include "features/transparency.h"
#include "scene/scene.h"

/* How highlights of lights with an extent are sampled. */
typedef enum rk_highlight_sampling {
    RK_HIGHLIGHT_LIGHT,   /* by the light's samples alone */
    RK_HIGHLIGHT_BALANCE, /* sharp ones by directions of their lobe, too: render/lobe.h */
} rk_highlight_sampling;

/* Which samples of a light with an extent have a shadow ray. */
typedef enum rk_light_visibility_method {
    RK_LIGHT_RAYS,     /* all of them */
    RK_LIGHT_PYRAMIDS, /* not those of points between which and the light there is no surface:
                          accel/query/pyramid.h */
} rk_light_visibility_method;

/* Sampling of lights with an extent. */
typedef struct rk_light_options {
    uint32_t samples; /* per light and shading point */
    rk_sampler_kind sampling;
    rk_light_domain domain;
    rk_light_falloff falloff;
    rk_light_visibility_method visibility;
    rk_highlight_sampling highlights;
    bool ratio; /* ratio estimator: unshadowed light in closed form, times a sampled ratio */
    uint32_t early_out; /* stop after this many shadow rays that agree; 0: trace all */
} rk_light_options;

/* Motion, and the times of rays. */
typedef struct rk_motion_options {
    rk_shutter shutter;
    uint32_t samples; /* times per pixel, over all of its samples, where motion may change it; 0:
                         everything is at rest */
    rk_time_sampling sampling;
    float single_time; /* NaN, or a single equidistant time for all rays, 1 to `samples` or beyond;
                      ignored if `samples` is 0 */
} rk_motion_options;

/* Rough mirrors. The first one of a path splits it into `samples` rays; each of these is reflected
 * in a single random direction at every further one, so that work does not multiply. */
typedef struct rk_glossy_options {
    uint32_t samples; /* 0: mirrors are perfect */
    float radius;     /* of all disks; NaN or negative: by the material's shininess */
    rk_glossy_weights weights;
    rk_disk_map map;
    rk_sampler_kind sampling;
} rk_glossy_options;

typedef struct rk_render_options {
    uint32_t width, height; /* pixels */
    uint32_t samples;       /* per pixel; 1: through its centre */
    rk_sampler_kind sampling;
    uint32_t seed;
    bool shadows;
    bool face_shadows; /* shadow rays start on the faces of smooth meshes, see
                          rk_surface_spawn_above */
    rk_shading shading;
    bool reflections;  /* of surfaces with ks > 0 */
    bool transparency; /* surfaces with alpha < 1 transmit light, and colour their shadows */
    rk_glass_model glass;
    uint32_t max_depth; /* bounces of a path: reflections and transparent surfaces passed */
    rk_light_options light;
    rk_bloom_options bloom;
    rk_cubemap_filter environment_filter;
    rk_lens lens;
    uint32_t lens_samples; /* per pixel out of focus, and at least `samples`; each through a point
                              of its own on the lens and in the pixel; 0: a pinhole */
    rk_sampler_kind lens_sampling; /* of both points */
    rk_motion_options motion;
    rk_glossy_options glossy;
    rk_ambient_occlusion_options ambient_occlusion;
    rk_normals_shown normals;
    rk_adaptive_sampling_options adaptive_sampling;
} rk_render_options;

/* A sampler of the picture's pixels. */
static inline rk_sampler rk_render_sampler(const rk_render_options *options, rk_sampler_kind kind,
                                           uint32_t samples)
{
    return (rk_sampler){kind, options->seed, samples, options->width};
}

enum { RK_MAX_DEPTH = 16 };

/* The defaults of the options' rows, as --help lists them. */
rk_render_options rk_render_options_default(void);

typedef struct rk_plan {
    bool rays;          /* a background, or light (a feature's, too) and something to shine on */
    bool background;    /* rays that hit nothing have radiance: an environment's, or a grey */
    bool pixel_samples; /* at random positions within pixels */
    bool lights;        /* some light is not black */
    bool shadow_rays;
    bool varying_kd;       /* some material has a texture, or the vertices have colours */
    bool viewer;           /* shading depends on the direction to the viewer: highlights, mirrors */
    bool sharp_highlights; /* some highlight of a parallelogram may need directions of its lobe */
    bool reflections;      /* some surface is specular, and rays may be reflected */
    bool time_samples;     /* each sample has a time of its own */

    /* One for each feature: is it wanted? */
#define RK_FEATURE(stem) bool stem;
#include "features/list.h"
#undef RK_FEATURE
} rk_plan;

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options);

/* Is one of its colours anything but black? */
bool rk_light_emits(const rk_light *light);

/* Does one of the scene's lights emit? */
bool rk_plan_has_light(const rk_scene *scene);

/* Does it hold for a material of the mesh or of a sphere? */
bool rk_plan_any_material(const rk_scene *scene, bool (*holds)(const rk_material *material));

/* Is a material specular, and may rays be reflected? */
bool rk_plan_reflects(const rk_scene *scene, const rk_render_options *options);

/* Can rk_render draw it? False with an error for a value out of its range or its enumeration, a
 * wrong field of view, a camera or a light that is not finite, more lights or spheres than a scene
 * has room for, and more samples than a sampler has numbers for. The mesh is not checked: see
 * rk_accel_build. */
bool rk_render_check(const rk_scene *scene, const rk_render_options *options, rk_error *error);

#endif
