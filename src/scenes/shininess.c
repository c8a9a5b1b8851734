/* Five exact spheres side by side that differ only in shininess: 1, 10, 100, 1000 and 100,000.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"

bool rk_builtin_make_nothing(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    return rk_mesh_init(mesh, 0, 0, 1, 0, error);
}

/* The camera is far away, so that all five are seen from the front. The default field of view fits
 * the row's width, --fov 3.6 its height. The light, to the upper left, is as far away. */
void rk_builtin_arrange_shininess(rk_scene *scene)
{
    static const float shininess[] = {1, 10, 100, 1e3f, 1e5f};
    for (uint32_t i = 0; i < 5; i++) {
        scene->spheres[i] = (rk_sphere){rk_vec(2.2f - 1.1f * (float)i, 0, 0), 0.5f};
        scene->sphere_materials[i] = (rk_material){
            .kd = rk_vec(0.45f, 0.1f, 0.06f),
            .ks = rk_vec(0.5f, 0.5f, 0.5f),
            .shininess = shininess[i],
            .alpha = 1,
        };
    }
    scene->sphere_count = 5;
    scene->camera = (rk_camera){.distance = 20, .fov = 17};
    scene->lights[0] = rk_light_point(rk_vec(8, 10, -16), rk_vec(1, 1, 1));
    scene->light_count = 1;
}
