/* The weaver reads this table, too (tools/weave/steps.lua), and stops where a function no longer
 * has its line. Lines of a student's task are named by a word of them, because this file is handed
 * out. */
#include "driver/pixel_code.h"

typedef struct code_place {
    const char *file, *function, *line;
} code_place;

/* clang-format off */
static const code_place places[RK_CODE_COUNT] = {
    {"src/scene/camera.h", "rk_view_ray", "return (rk_ray){view->position"},
    {"src/features/bvh_median.c", "rk_bvh_closest", "next = push_far_return_near("},
    {"src/accel/kernel/wide_trace.h", "trace_started", "trace_masks("},
    {"src/features/transparency.c", "rk_transparency_insert", "list->crossings[place] ="},
    {"src/scene/surface.c", "rk_surface_at", "const rk_simd4 point = point_at("},
    {"src/scene/surface.c", "rk_surface_at_sphere", "*surface = (rk_surface){"},
    {"src/features/shading.c", "rk_shade", "float cos_i ="},
    {"src/scene/surface.c", "rk_surface_spawn", "rk_simd4 normal ="},
    {"src/features/bvh_median.c", "rk_bvh_occluded", "found = first_hit"},
    {"src/accel/kernel/wide_trace.h", "trace_started", "put_results("},
    {"src/features/transparency.c", "rk_transparency_transmit", "switch (model)"},
    {"src/features/parallelogram_light.c", "rk_light_sample_at", "return (rk_light_sample)"},
    {"src/features/shading.c", "rk_shade", "light_colour, kd)"},
    {"src/features/shading.c", "rk_shade", "rk_gradient_at("},
    {"src/features/shading.c", "rk_shade", "(cos_i > 0)"},
    {"src/features/shading.c", "rk_shade", "light_colour, rk_scale("},
    {"src/features/shading.c", "rk_shade", "light_colour, rk_madd("},
    {"src/features/ambient_occlusion.c", "rk_ambient_radiance", "return rk_mul("},
    {"src/base/reflect.h", "rk_reflect", "return rk_madd("},
    {"src/features/glossy_reflection.c", "rk_glossy_disk_of", "rk_glossy_disk disk ="},
    {"src/features/cubemap.c", "rk_cubemap_at", "quad q = quad_around("},
    {"src/io/srgb8.h", "rk_srgb8_encode", "return (uint8_t)"},
    {"src/features/bvh_median.c", "rk_bvh_closest", "root->box"},
    {"src/features/bvh_median.c", "push_far_return_near", "near->box"},
    {"src/features/bvh_median.c", "push_far_return_near", "far->box"},
    {"src/features/bvh_median.c", "rk_bvh_closest", "rk_triangles_closest("},
};
/* clang-format on */

void rk_print_pixel_code(FILE *out, rk_pixel_code code)
{
    const code_place *place = &places[code];
    fprintf(out, "# %s, %s: %s\n", place->file, place->function, place->line);
}
