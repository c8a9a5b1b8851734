#include "scene/scene.h"

#include "scenes/builtin.h"

#include <stdio.h>
#include <string.h>

void rk_scene_free(rk_scene *scene)
{
    rk_mesh_free(&scene->mesh);
    rk_cubemap_free(&scene->environment);
    *scene = (rk_scene){0};
}

/* A scene that owns the mesh, without light and with the default camera. */
static void take_over(rk_scene *scene, const char *name, rk_mesh *mesh)
{
    *scene = (rk_scene){.mesh = *mesh, .camera = rk_camera_default()};
    snprintf(scene->name, sizeof scene->name, "%s", name);
    *mesh = (rk_mesh){0};
}

/* Above the default camera and to its left, so that shading and shadows show the shape. */
void rk_scene_default_light(rk_scene *scene)
{
    scene->lights[0] = rk_light_point(rk_vec(0, 2.4f, -3.2f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}

bool rk_scene_around(rk_scene *scene, const char *name, rk_mesh *mesh, rk_error *error)
{
    take_over(scene, name, mesh);
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

typedef struct builtin {
    const char *name;
    bool (*make)(rk_mesh *mesh, uint32_t number, rk_error *error);
    void (*arrange)(rk_scene *scene);                       /* NULL: as rk_scene_around does */
    uint32_t lowest_number, default_number, highest_number; /* 0: takes no number */
} builtin;

static const builtin builtins[] = {
    {"triangle", rk_mesh_make_triangle, NULL, 0, 0, 0},
    {"cube", rk_mesh_make_cube, NULL, 0, 0, 0},
    {"cube-textured", rk_mesh_make_cube_textured, NULL, 0, 0, 0},
    {"cornell", rk_mesh_make_cornell, rk_scene_arrange_cornell, 0, 0, 0},
    {"cornell-glass", rk_mesh_make_cornell_glass, rk_scene_arrange_cornell, 0, 0, 0},
    {"cornell-light", rk_mesh_make_cornell_light, rk_scene_arrange_cornell_light, 0, 0, 0},
    {"panes", rk_mesh_make_panes, rk_scene_arrange_panes, 0, 0, 1},
    {"glass", rk_mesh_make_glass, rk_scene_arrange_glass, 0, 0, 0},
    {"sphere", rk_mesh_make_sphere, NULL, 1, 1280, 100000000},
    {"spheres", rk_mesh_make_spheres, rk_scene_arrange_spheres, 1, 80, 100000000},
    {"shininess", rk_mesh_make_nothing, rk_scene_arrange_shininess, 0, 0, 0},
    /* One square a patch would leave the spout's lip without area. */
    {"teapot", rk_mesh_make_teapot, NULL, 2, 16, 1000},
    {"statue", rk_mesh_make_statue, NULL, 1, 87130, 100000000},
    {"cover", rk_mesh_make_cover, rk_scene_arrange_cover, 1, 87130, 100000000},
    {"moving", rk_mesh_make_moving, rk_scene_arrange_moving, 2, 8, 1000},
};

const char rk_scene_builtin_help[] =
    "  triangle        a single triangle\n"
    "  cube            12 triangles, each side in its own colour\n"
    "  cube-textured   the same, with a letter on each side\n"
    "  cornell         the Cornell box, 32 triangles, with a mirror (--reflections)\n"
    "  cornell-glass   the Cornell box with two blocks of glass (--transparency)\n"
    "  cornell-light   the Cornell box with a parallelogram light\n"
    "  panes:N         a red pane before a yellow one (0), or yellow before red (1)\n"
    "  glass           a thin and a thick block of the same glass\n"
    "  sphere:N        a sphere of at least N triangles (default 1280)\n"
    "  spheres:N       such a sphere (default 80) beside an exact one, on a floor\n"
    "  shininess       five exact spheres, of shininess 1 to 100,000\n"
    "  teapot:N        the Utah teapot, each of its 32 patches as N x N squares (default 16)\n"
    "  statue:N          a statue as from a scanner, of exactly N triangles (default 87130)\n"
    "  cover:N         all features in one scene, its statue of N triangles (default 87130)\n"
    "  moving:N        the teapot, patches as N x N squares (default 8), and a ball, on the move\n";

static const builtin *find_builtin(const char *name, size_t length)
{
    for (size_t i = 0; i < sizeof builtins / sizeof builtins[0]; i++)
        if (strlen(builtins[i].name) == length && strncmp(builtins[i].name, name, length) == 0)
            return &builtins[i];
    return NULL;
}

/* Digits only, to the end, from lowest to highest. */
static bool read_number(const char *digits, const builtin *entry, uint32_t *number)
{
    uint64_t value = 0;
    const char *c = digits;
    for (; *c >= '0' && *c <= '9' && value <= entry->highest_number; c++)
        value = 10 * value + (uint64_t)(*c - '0');
    *number = (uint32_t)value;
    return c > digits && *c == '\0' && value >= entry->lowest_number &&
           value <= entry->highest_number;
}

static const char list_of_names[] =
    "triangle, cube, cube-textured, cornell, cornell-glass, cornell-light, panes:N, glass, "
    "sphere:N, spheres:N, shininess, teapot:N, statue:N, moving:N, cover:N";

static bool parse_name(const char *name, const builtin **entry, uint32_t *number, rk_error *error)
{
    const char *colon = strchr(name, ':');
    *entry = find_builtin(name, colon ? (size_t)(colon - name) : strlen(name));
    if (!*entry)
        return rk_fail(error, "%s: there is no such built-in scene: choose one of %s", name,
                       list_of_names);
    *number = (*entry)->default_number;
    if (!colon || ((*entry)->highest_number > 0 && read_number(colon + 1, *entry, number)))
        return true;
    if ((*entry)->highest_number == 0)
        return rk_fail(error, "%s: %s takes no number: the built-in scenes are %s", name,
                       (*entry)->name, list_of_names);
    return rk_fail(
        error,
        "%s: after the colon stands a whole number from %u to %u, as in %s:%u: the built-in "
        "scenes are %s",
        name, (*entry)->lowest_number, (*entry)->highest_number, (*entry)->name,
        (*entry)->default_number, list_of_names);
}

bool rk_scene_builtin(rk_scene *scene, const char *name, rk_error *error)
{
    const builtin *entry;
    uint32_t number = 0;
    rk_mesh mesh;
    *scene = (rk_scene){0};
    if (!parse_name(name, &entry, &number, error) || !entry->make(&mesh, number, error))
        return false;
    if (!entry->arrange)
        return rk_scene_around(scene, name, &mesh, error);
    take_over(scene, name, &mesh);
    entry->arrange(scene);
    return true;
}
