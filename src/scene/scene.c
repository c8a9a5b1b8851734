/* Assembles scenes, and finds the surface of a hit: numbers up to the mesh's are triangles, those
 * from there on spheres. */
#include "scene/scene.h"

#include <stdio.h>

void rk_scene_free(rk_scene *scene)
{
    rk_mesh_free(&scene->mesh);
    rk_cubemap_free(&scene->environment);
    *scene = (rk_scene){0};
}

void rk_scene_init(rk_scene *scene, const char *name, rk_mesh *mesh)
{
    *scene = (rk_scene){.mesh = *mesh, .camera = rk_camera_default()};
    snprintf(scene->name, sizeof scene->name, "%s", name);
    *mesh = (rk_mesh){0};
}

void rk_scene_default_light(rk_scene *scene)
{
    scene->lights[0] = rk_light_point(rk_vec(0, 2.4f, -3.2f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}

bool rk_scene_around(rk_scene *scene, const char *name, rk_mesh *mesh, rk_error *error)
{
    rk_scene_init(scene, name, mesh);
    if (!rk_mesh_validate(&scene->mesh, name, error) || !rk_mesh_normalize(&scene->mesh, error)) {
        rk_scene_free(scene);
        return false;
    }
    rk_scene_default_light(scene);
    return true;
}

void rk_scene_move_mesh(rk_scene *scene, rk_motion motion)
{
    scene->moving_count = 1;
    scene->moving[0] = (rk_moving){0, scene->mesh.triangle_count, motion};
}

void rk_scene_surface(rk_surface *surface, const rk_scene *scene, const rk_ray *ray,
                      const rk_hit *hit)
{
    uint32_t triangles = scene->mesh.triangle_count;
    if (hit->triangle < triangles)
        rk_surface_at(surface, &scene->mesh, ray, hit);
    else
        rk_surface_at_sphere(surface, &scene->spheres[hit->triangle - triangles],
                             &scene->sphere_materials[hit->triangle - triangles], ray, hit);
}
