/* Counts of the work done: they prove that a scene costs no work that it does not need. */
#ifndef RK_BASE_COUNTERS_H
#define RK_BASE_COUNTERS_H

#include <stdint.h>

typedef struct rk_counters {
    uint64_t primary_rays;
    uint64_t shadow_rays;
    uint64_t reflected_rays;
    uint64_t glossy_samples; /* directions drawn around reflected ones, including discarded ones */
    uint64_t light_samples;  /* random points drawn on lights with an extent */
    uint64_t lobe_samples;   /* directions drawn in highlights, towards such lights or past them */
    uint64_t crossings; /* of rays with transparent surfaces: those that light passes or ends at */
    uint64_t box_tests;
    uint64_t triangle_tests;
    uint64_t sphere_tests;
    uint64_t pixel_samples;     /* random positions drawn within pixels */
    uint64_t bloom_pixels_read; /* by the bright pass and the filter */
    uint64_t bloom_taps;        /* weights times pixels, along rows and columns */
    uint64_t environment_lookups;
    uint64_t lens_samples;  /* random points drawn on the lens */
    uint64_t time_samples;  /* times drawn, for samples that may see motion */
    uint64_t rounds;        /* of adaptive sampling */
    uint64_t taken_samples; /* of all its generations */
    uint64_t kept_samples;  /* those that make the picture */
    uint64_t most_samples;  /* of these, in one pixel */
    double estimated_error; /* of its picture, relative; 0 without it */
} rk_counters;

/* Rays of all kinds. */
static inline uint64_t rk_counters_rays(const rk_counters *counters)
{
    return counters->primary_rays + counters->shadow_rays + counters->reflected_rays;
}

static inline void rk_counters_add(rk_counters *sum, const rk_counters *part)
{
    sum->primary_rays += part->primary_rays;
    sum->shadow_rays += part->shadow_rays;
    sum->reflected_rays += part->reflected_rays;
    sum->glossy_samples += part->glossy_samples;
    sum->light_samples += part->light_samples;
    sum->lobe_samples += part->lobe_samples;
    sum->crossings += part->crossings;
    sum->box_tests += part->box_tests;
    sum->triangle_tests += part->triangle_tests;
    sum->sphere_tests += part->sphere_tests;
    sum->pixel_samples += part->pixel_samples;
    sum->bloom_pixels_read += part->bloom_pixels_read;
    sum->bloom_taps += part->bloom_taps;
    sum->environment_lookups += part->environment_lookups;
    sum->lens_samples += part->lens_samples;
    sum->time_samples += part->time_samples;
    sum->rounds += part->rounds;
    sum->taken_samples += part->taken_samples;
    sum->kept_samples += part->kept_samples;
    sum->most_samples += part->most_samples;
    sum->estimated_error += part->estimated_error; /* only one part has it */
}

#endif
