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

/* rk_render refuses a camera whose field of view is not in (0, 180) degrees, and a count above its
 * maximum; rk_accel_build relies on a valid mesh. */
typedef struct rk_scene {
    char name[64];
    rk_mesh mesh;
    uint32_t sphere_count; /* a handful: every ray is tested against each */
    rk_sphere spheres[RK_SPHERES_MAX];
    rk_material sphere_materials[RK_SPHERES_MAX];
    rk_camera camera;
    uint32_t light_count;
    rk_light lights[RK_LIGHTS_MAX];
    rk_cubemap environment; /* what rays see that meet nothing; side 0: black */
    uint32_t moving_count; /* objects that move are the mesh's last triangles, one behind the other;
                              all before them stand still */
    rk_moving moving[RK_MOVING_MAX];
} rk_scene;

void rk_scene_free(rk_scene *scene);

/* The built-in scenes, which need no file. A name may carry a number after a colon:
 *
 *   triangle        a single triangle
 *   cube            12 triangles
 *   cube-textured   the same with a letter on each side: u to the right, v up
 *   cornell         the Cornell box, 32 triangles, one of its blocks a mirror
 *   cornell-glass   the Cornell box with two closed blocks of glass, 36 triangles
 *   cornell-light   the Cornell box with a parallelogram light in place of the lamp, 30 triangles
 *   panes:N         two coloured panes between a light and a wall, on the viewer's side: red before
 *                   yellow (0, the default) or yellow before red (1), for the light as for the eye
 *   glass           a thin and a thick closed block of the same glass, and their shadows
 *   sphere:N        a sphere of at least N triangles (default 1280)
 *   spheres:N       such a sphere (default 80) beside an exact one, on a floor
 *   shininess       five exact spheres, of shininess 1 to 100,000
 *   teapot:N        the Utah teapot, each of its 32 patches as N x N squares (default 16)
 *   statue:N          a statue as from a scanner, of exactly N triangles (default 87130)
 *   cover:N         all features in one scene, its statue of N triangles (default 87130)
 *   moving:N        the teapot, patches as N x N squares (default 8), and a ball, on the move
 *
 * False with an error that lists the names when there is no such scene or N is out of range. */
bool rk_scene_builtin(rk_scene *scene, const char *name, rk_error *error);

/* One line each for --help: the names and what they are. */
extern const char rk_scene_builtin_help[];

/* Fills in the surface at a hit: of the mesh, or of sphere k where hit->triangle is the mesh's
 * triangle_count + k. */
void rk_scene_surface(rk_surface *surface, const rk_scene *scene, const rk_ray *ray,
                      const rk_hit *hit);

/* The whole mesh moves, as one object. */
void rk_scene_move_mesh(rk_scene *scene, rk_motion motion);

/* Returns which of the moving objects the triangle belongs to, or RK_MISS. */
static inline uint32_t rk_scene_moving_object(const rk_scene *scene, uint32_t triangle)
{
    for (uint32_t i = 0; i < scene->moving_count; i++)
        if (triangle - scene->moving[i].first < scene->moving[i].count)
            return i;
    return RK_MISS;
}

/* A scene around a mesh, which it takes over (and zeroes): the mesh moved into the unit ball, the
 * default camera and a light above it, to the left. False when memory is short, or with the error
 * of rk_mesh_validate. In either case the mesh is no longer the caller's: on failure it is freed,
 * and the scene is empty. */
bool rk_scene_around(rk_scene *scene, const char *name, rk_mesh *mesh, rk_error *error);

#endif
