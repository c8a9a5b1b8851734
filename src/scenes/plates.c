/* Four plates, from dull at the top to sharp at the bottom, that reflect four square lamps from
 * small to large: each plate is tilted so that the camera sees the lamps in its middle. After Veach
 * and Guibas, "Optimally combining sampling techniques for Monte Carlo rendering", SIGGRAPH 1995.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"

static const float shininess[] = {1e5f, 1e4f, 1e3f, 100};
enum { plate_count = sizeof shininess / sizeof *shininess };

static const rk_vec3 viewer = {0, 0, -3.4f}, lamps = {0, 1.2f, 0.6f};

static rk_vec3 middle_of_plate(uint32_t i)
{
    return rk_vec(0, -0.49f + 0.31f * (float)i, -0.34f + 0.28f * (float)i);
}

bool rk_builtin_make_plates(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_builtin_init_quads(mesh, plate_count, plate_count, error))
        return false;
    for (uint32_t i = 0; i < plate_count; i++) {
        rk_vec3 middle = middle_of_plate(i), across = rk_vec(1.14f, 0, 0);
        rk_vec3 to_viewer = rk_normalize(rk_sub(viewer, middle));
        rk_vec3 to_lamps = rk_normalize(rk_sub(lamps, middle));
        rk_vec3 normal = rk_normalize(rk_add(to_viewer, to_lamps));
        rk_vec3 along = rk_scale(rk_normalize(rk_cross(normal, across)), 0.3f);
        rk_vec3 corner = rk_madd(rk_madd(middle, across, -0.5f), along, -0.5f);
        rk_builtin_put_quad(mesh, corner, across, along, (uint16_t)i);
        mesh->materials[i] = (rk_material){.kd = rk_vec(0.1f, 0.1f, 0.1f),
                                           .ks = rk_vec(0.4f, 0.4f, 0.4f),
                                           .shininess = shininess[i],
                                           .alpha = 1};
    }
    return true;
}

void rk_builtin_arrange_plates(rk_scene *scene)
{
    static const float sizes[] = {0.03f, 0.09f, 0.22f, 0.44f},
                       places[] = {0.62f, 0.4f, 0.08f, -0.42f};
    const rk_vec3 white = {2, 2, 2};
    scene->camera = (rk_camera){.distance = -viewer.z, .fov = 25};
    /* The lamps face the plates. */
    rk_vec3 up = rk_normalize(rk_cross(rk_vec(1, 0, 0), lamps));
    for (uint32_t i = 0; i < 4; i++) {
        rk_vec3 side = rk_vec(sizes[i], 0, 0), height = rk_scale(up, sizes[i]);
        rk_vec3 middle = rk_vec(places[i], lamps.y, lamps.z);
        scene->lights[i] = (rk_light){
            .kind = RK_LIGHT_PARALLELOGRAM,
            .position = rk_madd(rk_madd(middle, side, -0.5f), height, -0.5f),
            .edge01 = side,
            .edge02 = height,
            .colours = {white, white, white, white},
        };
    }
    scene->light_count = 4;
}
