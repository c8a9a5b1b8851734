/* What the renderer's stages hand to each other, and the stages; not installed. */
#ifndef RK_RENDER_TILE_H
#define RK_RENDER_TILE_H

#include "accel/accel.h"
#include "accel/crossings.h"
#include "base/image.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "render/plan.h"
#include "scene/surface.h"

typedef struct rk_rendering {
    const rk_scene *scene;
    const rk_accel *accel;
    const rk_render_options *options;
    rk_plan plan;
    rk_view view;
    int32_t *coc_count;          /* see rk_lens_coc; NULL without a lens */
    rk_box swept[RK_MOVING_MAX]; /* by each moving object; unset unless plan.motion */
    uint32_t tiles_across;
    rk_image *image;
    rk_counters *counters; /* one for each thread */
    rk_progress *progress;
} rk_rendering;

/* How a ray belongs to the pixel that it was sent for. */
typedef struct rk_path {
    rk_vec3 weight; /* share of what it sees that reaches the pixel */
    /* Which of the pixel's samples it is: of the tile's, or, once a rough mirror has spread it, of
     * glossy.samples times as many. */
    uint32_t sample : 25;
    uint32_t spread : 1;
    uint32_t left : 6; /* surfaces behind the first that it may go on to */
} rk_path;

_Static_assert(RK_SAMPLES_MAX <= 1 << 25 && RK_MAX_DEPTH < 1 << 6, "both fit");

static inline rk_path rk_path_of(rk_vec3 weight, uint32_t sample, bool spread, uint32_t left)
{
    return (rk_path){weight, sample & ((1 << 25) - 1), spread, left & ((1 << 6) - 1)};
}

/* A camera ray. */
static inline rk_path rk_path_start(uint32_t sample, uint32_t left)
{
    return rk_path_of(rk_vec(1, 1, 1), sample, false, left);
}

typedef struct rk_path_batch {
    rk_ray_batch rays;
    uint16_t pixel[RK_BATCH_MAX]; /* within the tile, row by row */
    rk_path path[RK_BATCH_MAX];
} rk_path_batch;

/* A ray whose path stands in the batch already. */
static inline void rk_path_push_ray(rk_path_batch *paths, const rk_ray *ray, uint32_t pixel)
{
    paths->pixel[paths->rays.count] = (uint16_t)pixel;
    rk_batch_push(&paths->rays, ray);
}

static inline void rk_path_push(rk_path_batch *paths, const rk_ray *ray, uint32_t pixel,
                                rk_path path)
{
    paths->path[paths->rays.count] = path;
    rk_path_push_ray(paths, ray, pixel);
}

/* A surface that a ray has met. */
typedef struct rk_shading_point {
    rk_surface surface;
    rk_vec3 kd;
    rk_vec3 to_viewer; /* unit, back along the ray; 0 unless plan.viewer */
    rk_path path;      /* the part of it that is left here */
    uint16_t pixel;
} rk_shading_point;

/* What more light samples would tell of a seen surface: open questions, or no more; a tinted one
 * stays open. */
typedef enum rk_tile_light_state {
    RK_LIGHT_OPEN,
    RK_LIGHT_TINTED,
    RK_LIGHT_UNBLOCKED,
    RK_LIGHT_BLOCKED
} rk_tile_light_state;

/* One light's work on all that is seen, entry for entry. */
typedef struct rk_tile_light_sums {
    rk_vec3 lit[RK_BATCH_MAX];    /* over samples, as far as it arrives */
    rk_vec3 all[RK_BATCH_MAX];    /* as if nothing were in the way */
    uint32_t asked[RK_BATCH_MAX]; /* shadow rays, and how many of them found the way free */
    uint32_t free[RK_BATCH_MAX];
    rk_tile_light_state state[RK_BATCH_MAX];
} rk_tile_light_sums;

/* A thread's workspace for a tile. */
typedef struct rk_tile {
    uint32_t x, y, width, height; /* pixels */
    bool blurred;                 /* at work: pixels out of focus, by the lens, or all others */
    uint32_t sample, samples;     /* of each of them, and how many there will be */
    uint32_t turn, turns;         /* a sample that motion may change is taken so often */
    rk_hit_batch hits;
    uint32_t seen_count;
    rk_shading_point seen[RK_BATCH_MAX];
    rk_tile_light_sums sums;
    rk_ray_batch shadow; /* each asks whether something is in the way of a light; and for each: */
    uint16_t arriving_at[RK_BATCH_MAX]; /* the seen surface */
    rk_vec3 arriving[RK_BATCH_MAX]; /* what it would reflect of the light, or does, behind panes */
    rk_occlusion_batch blocked;     /* the answers */
    bool tinted[RK_BATCH_MAX];      /* with transparency alone: do panes take a part of it? */
    rk_vec3 sum[RK_BATCH_MAX];      /* over the samples so far, one a pixel */
    bool in_motion[RK_BATCH_MAX];   /* did a ray of this sample need a time? */
    bool in_sight[RK_BATCH_MAX];    /* did the camera's? */
    bool has_time[RK_BATCH_MAX];    /* did one in this turn? */
    float time[RK_BATCH_MAX];       /* then it is this */
    rk_counters *counters;
} rk_tile;

/* A tile before its first sample: its part of the picture, nothing seen, black. */
void rk_tile_start(const rk_rendering *r, rk_tile *t, uint32_t index, uint32_t thread);

/* Finds r->coc_count, by a ray through the centre of each pixel; leaves it NULL where the plan has
 * no lens. */
bool rk_focus_find(rk_rendering *r, rk_pool *pool, rk_error *error);

/* How often each of a pixel's samples is taken if motion may change it: so that all of them see as
 * many times as are asked for. */
static inline uint32_t rk_time_passes(const rk_plan *plan, const rk_render_options *options,
                                      uint32_t samples)
{
    uint64_t times = options->motion.samples;
    return plan->time_samples ? (uint32_t)((times + samples - 1) / samples) : 1;
}

/* Where a sample stands among those that are spread together. */
typedef struct rk_sample_index {
    uint32_t sample, samples;
    uint32_t dimension; /* to be added */
} rk_sample_index;

/* For what is drawn behind the camera: on lights, and by rough mirrors. Further turns are a set of
 * their own, so the first is the same as without motion. But where such a number decided that there
 * are further turns, all keep it: what it met in motion counts for no more than its own share. */
static inline rk_sample_index rk_sample_index_of(const rk_tile *t, uint32_t pixel)
{
    if (t->turn == 0 || !t->in_sight[pixel])
        return (rk_sample_index){t->sample, t->samples, 0};
    return (rk_sample_index){(t->turn - 1) * t->samples + t->sample, (t->turns - 1) * t->samples,
                             RK_DIMENSION_FURTHER};
}

/* The place in the picture, row by row, of a tile's pixel: where random numbers start from. */
static inline uint32_t rk_tile_pixel(const rk_rendering *r, const rk_tile *t, uint32_t pixel)
{
    return (t->y + pixel / t->width) * r->options->width + t->x + pixel % t->width;
}

/* Whose rays ask for a time: ray i of a batch is for pixels[i]. */
typedef struct rk_asker {
    const rk_rendering *r;
    rk_tile *t;
    const uint16_t *pixels;
    bool from_camera;
} rk_asker;

/* The moments of the asker's rays: a pixel's time is drawn when the first of its rays asks. */
rk_moments rk_moments_of(rk_asker *asker);

/* Works out the swept boxes. */
void rk_moving_prepare(rk_rendering *r);

/* Takes a surface that a ray of the pixel met to where its object stands then. */
void rk_moving_place(const rk_rendering *r, rk_tile *t, uint32_t pixel, uint32_t triangle,
                     rk_surface *surface);

/* How many samples like this one its pixel takes. */
static inline uint32_t rk_path_samples(const rk_rendering *r, const rk_tile *t, uint32_t pixel,
                                       bool spread)
{
    return rk_sample_index_of(t, pixel).samples * (spread ? r->options->glossy.samples : 1);
}

/* Adds to the pixels' sums what the rays of `paths` see, along mirrors and panes to the end. */
void rk_trace_paths(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths);

/* The nearest hits of the rays go into the tile's `hits`. */
void rk_trace_closest(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths);

/* Their parts, for who tells the story of one ray: path i goes through panes to a list of hits,
 * nearest first, of which `weights` are the shares that reach its beginning. Returns the share of
 * the environment: 0 behind something opaque, and where the ray may not go on that far; */
float rk_trace_transparent(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths,
                           uint32_t i, rk_crossing_list *list, float weights[RK_MAX_DEPTH + 1]);
/* what a hit of it shows, behind so many panes, with its share; */
void rk_shading_point_at(rk_shading_point *seen, const rk_rendering *r, rk_tile *t,
                         const rk_path_batch *paths, uint32_t i, const rk_hit *hit, uint32_t panes,
                         float share);
/* what the environment adds, with its share; */
rk_vec3 rk_environment_radiance(const rk_rendering *r, const rk_path_batch *paths, uint32_t i,
                                float share, rk_counters *counters);
/* and the ray that a perfect mirror sends on there, if one is and may be. */
void rk_spawn_reflection(const rk_shading_point *seen, rk_path_batch *mirrored);
/* Is there a mirror, and may a ray go on? */
bool rk_is_specular(const rk_shading_point *seen);
/* Where it goes: about the shading normal, unless that would lead into the surface. */
rk_vec3 rk_reflected_direction(const rk_shading_point *seen);

/* Sends on the rays of all mirrors among the tile's seen surfaces, rough ones among them, and
 * follows them to the end. No surface is left seen. */
void rk_glossy_stage(const rk_rendering *r, rk_tile *t);

/* The disk of directions of a rough mirror; of radius 0 where it is perfect. */
rk_glossy_disk rk_glossy_disk_at(const rk_glossy_options *options, const rk_shading_point *seen);

#endif
