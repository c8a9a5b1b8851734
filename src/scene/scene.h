/* A scene: a mesh, exact spheres, lights, an environment, a camera. */
#ifndef RK_SCENE_SCENE_H
#define RK_SCENE_SCENE_H

#include "base/sphere.h"
#include "scene/camera.h"
#include "scene/environment.h"
#include "scene/light.h"
#include "scene/mesh.h"
#include "scene/motion.h"
#include "scene/surface.h"

enum { RK_LIGHTS_MAX = 16, RK_SPHERES_MAX = 16, RK_MOVING_MAX = 16 };

/* rk_render refuses a camera whose field of view is outside (0, 180) degrees, and a count above its
 * maximum; rk_accel_build requires a valid mesh. */
typedef struct rk_scene {
    char name[64];
    rk_mesh mesh;
    uint32_t sphere_count; /* only a few: every ray is tested against each */
    rk_sphere spheres[RK_SPHERES_MAX];
    rk_material sphere_materials[RK_SPHERES_MAX];
    rk_camera camera;
    uint32_t light_count;
    rk_light lights[RK_LIGHTS_MAX];
    rk_cubemap environment; /* for rays that hit nothing; side 0: `background` instead */
    float background;       /* radiance, grey; 0: black */
    uint32_t moving_count; /* moving objects are the mesh's last triangles, one after the other; all
                              triangles before them are static */
    rk_moving moving[RK_MOVING_MAX];
} rk_scene;

/* A scene that owns the mesh (and zeroes the caller's), without lights, with the default camera. */
void rk_scene_init(rk_scene *scene, const char *name, rk_mesh *mesh);
void rk_scene_free(rk_scene *scene);

/* A white point light above the default camera and to its left, so that shading and shadows show
 * the shape. */
void rk_scene_default_light(rk_scene *scene);

/* Fills in the surface at a hit: of the mesh, or of sphere k if hit->triangle is the mesh's
 * triangle_count + k. */
void rk_scene_surface(rk_surface *surface, const rk_scene *scene, const rk_ray *ray,
                      const rk_hit *hit);

/* Makes the whole mesh move as one object. */
void rk_scene_move_mesh(rk_scene *scene, rk_motion motion);

/* Returns the index of the moving object that contains the triangle, or RK_MISS. */
static inline uint32_t rk_scene_moving_object(const rk_scene *scene, uint32_t triangle)
{
    for (uint32_t i = 0; i < scene->moving_count; i++)
        if (triangle - scene->moving[i].first < scene->moving[i].count)
            return i;
    return RK_MISS;
}

/* A scene around a mesh, which it takes over (and zeroes): the mesh scaled into the unit ball, the
 * default camera and the default light. False when memory is short, or with the error of
 * rk_mesh_validate. In either case the caller no longer owns the mesh: on failure it is freed, and
 * the scene is empty. */
bool rk_scene_around(rk_scene *scene, const char *name, rk_mesh *mesh, rk_error *error);

#endif
