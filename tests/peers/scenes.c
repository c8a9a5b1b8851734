#include "scenes.h"

#include "io/mesh_file.h"
#include "scenes/builtin.h"

#include <stdio.h>
#include <string.h>

static const char room_statue[] = "statue:203000";
enum { room_triangles = 12 };

/* Half a side: the camera, at a distance of 3, and the light are inside. */
static const float room_half = 4;

/* Corner k of a cube has its coordinates' signs in its bits; a side is four corners, and seen from
 * inside they go round counter-clockwise. */
static const uint32_t sides[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};

static void put_box(rk_mesh *mesh)
{
    const uint32_t first = mesh->vertex_count;
    for (uint32_t k = 0; k < 8; k++)
        mesh->positions[first + k] =
            rk_vec(k & 1 ? room_half : -room_half, k & 2 ? room_half : -room_half,
                   k & 4 ? room_half : -room_half);
    for (uint32_t side = 0; side < 6; side++)
        for (uint32_t half = 0; half < 2; half++) {
            uint32_t *corners = mesh->triangles[mesh->triangle_count++];
            corners[0] = first + sides[side][0];
            corners[1] = first + sides[side][1 + half];
            corners[2] = first + sides[side][2 + half];
        }
    mesh->vertex_count += 8;
}

/* The statue's triangles and the box, flat: only their shape is traced. */
static bool make_room(rk_scene *scene, const char *statue, const char *name, rk_error *error)
{
    rk_scene inside;
    rk_mesh mesh;
    if (!rk_builtin_scene(&inside, statue, error))
        return false;
    const rk_mesh *from = &inside.mesh;
    if (!rk_mesh_init(&mesh, from->vertex_count + 8, from->triangle_count + room_triangles, 1, 0,
                      error)) {
        rk_scene_free(&inside);
        return false;
    }
    mesh.vertex_count = from->vertex_count;
    mesh.triangle_count = from->triangle_count;
    memcpy(mesh.positions, from->positions, from->vertex_count * sizeof *mesh.positions);
    memcpy(mesh.triangles, from->triangles, from->triangle_count * sizeof *mesh.triangles);
    put_box(&mesh);
    rk_scene_init(scene, name, &mesh);
    scene->camera = inside.camera;
    rk_scene_default_light(scene);
    rk_scene_free(&inside);
    return true;
}

bool peers_scene(rk_scene *scene, const char *name, rk_error *error)
{
    char statue[64];
    const bool numbered = strncmp(name, "room:", 5) == 0;
    snprintf(statue, sizeof statue, "statue:%.40s", numbered ? name + 5 : "");
    if (numbered || strcmp(name, "room") == 0)
        return make_room(scene, numbered ? statue : room_statue, name, error);
    if (!rk_builtin_scene(scene, name, error))
        return false;
    const bool whole = scene->sphere_count == 0 && scene->light_count > 0;
    if (!whole) {
        rk_scene_free(scene);
        return rk_fail(error,
                       "%s: it has exact spheres, which Embree's triangles do not include, "
                       "or no light: choose another scene, such as statue:4000",
                       name);
    }
    return true;
}

bool peers_mesh_scene(rk_scene *scene, const char *path, rk_error *error)
{
    rk_mesh mesh;
    const char *slash = strrchr(path, '/');
    return rk_mesh_file_read(&mesh, path, error) &&
           rk_scene_around(scene, slash ? slash + 1 : path, &mesh, error);
}
