/* The table of built-in scenes. A row is all that a scene needs: its name, its line of --help, its
 * maker, its own camera and lights, and the range of its number. */
#include "scenes/builtin.h"
#include "scenes/makers.h"

#include <stdio.h>
#include <string.h>

typedef struct builtin {
    const char *name, *contents;
    bool (*make)(rk_mesh *mesh, uint32_t number, rk_error *error);
    void (*arrange)(rk_scene *scene);                       /* NULL: as rk_scene_around does */
    uint32_t lowest_number, default_number, highest_number; /* 0: takes no number */
} builtin;

static const builtin builtins[] = {
    {"triangle", "a single triangle", rk_builtin_make_triangle, NULL, 0, 0, 0},
    {"cube", "12 triangles, each side in its own colour", rk_builtin_make_cube, NULL, 0, 0, 0},
    {"cube-textured", "the same, with a letter on each side", rk_builtin_make_cube_textured, NULL,
     0, 0, 0},
    {"cornell", "the Cornell box, 32 triangles, with a mirror (--reflections)",
     rk_builtin_make_cornell, rk_builtin_arrange_cornell, 0, 0, 0},
    {"cornell-glass", "the Cornell box with two blocks of glass (--transparency)",
     rk_builtin_make_cornell_glass, rk_builtin_arrange_cornell, 0, 0, 0},
    {"cornell-light", "the Cornell box with a parallelogram light", rk_builtin_make_cornell_light,
     rk_builtin_arrange_cornell_light, 0, 0, 0},
    {"panes", "a red pane in front of a yellow one, or behind it if N is 1", rk_builtin_make_panes,
     rk_builtin_arrange_panes, 0, 0, 1},
    {"glass", "a thin and a thick block of the same glass", rk_builtin_make_glass,
     rk_builtin_arrange_glass, 0, 0, 0},
    {"sphere", "a sphere of at least N triangles", rk_builtin_make_sphere, NULL, 1, 1280,
     100000000},
    {"spheres", "such a sphere beside an exact one, on a floor", rk_builtin_make_spheres,
     rk_builtin_arrange_spheres, 1, 80, 100000000},
    {"shininess", "five exact spheres, of shininess 1 to 100,000", rk_builtin_make_nothing,
     rk_builtin_arrange_shininess, 0, 0, 0},
    {"plates", "four plates, from dull to sharp, that reflect four lamps", rk_builtin_make_plates,
     rk_builtin_arrange_plates, 0, 0, 0},
    {"lanterns", "lanterns over water at night, many times as bright as white",
     rk_builtin_make_lanterns, rk_builtin_arrange_lanterns, 0, 0, 0},
    /* One square per patch would leave the spout's lip without area. */
    {"teapot", "the Utah teapot, each of its 32 patches as N x N squares", rk_builtin_make_teapot,
     NULL, 2, 16, 1000},
    {"statue", "a statue as if from a scanner, of exactly N triangles", rk_builtin_make_statue,
     NULL, 1, 87130, 100000000},
    {"cover", "all features in one scene, its statue of N triangles", rk_builtin_make_cover,
     rk_builtin_arrange_cover, 1, 87130, 100000000},
    {"moving", "a ball and the teapot in motion, its patches as N x N squares",
     rk_builtin_make_moving, rk_builtin_arrange_moving, 2, 8, 1000},
};

enum { builtin_count = sizeof builtins / sizeof builtins[0] };

/* --- what users read ------------------------------------------------------------------------- */

typedef struct usage {
    char text[24]; /* the name, and :N where it takes a number */
} usage;

static usage usage_of(const builtin *entry)
{
    usage u;
    snprintf(u.text, sizeof u.text, "%.20s%s", entry->name, entry->highest_number ? ":N" : "");
    return u;
}

void rk_builtin_help(char *text, size_t size)
{
    size_t used = 0;
    for (size_t i = 0; i < builtin_count && used < size; i++) {
        const builtin *entry = &builtins[i];
        char by_default[32] = "";
        if (entry->highest_number)
            snprintf(by_default, sizeof by_default, " (default %u)", entry->default_number);
        used += (size_t)snprintf(text + used, size - used, "  %-15s %s%s\n", usage_of(entry).text,
                                 entry->contents, by_default);
    }
}

typedef struct name_list {
    char text[builtin_count * sizeof(usage)];
} name_list;

static name_list list_names(void)
{
    name_list list;
    size_t used = 0;
    for (size_t i = 0; i < builtin_count; i++)
        used += (size_t)snprintf(list.text + used, sizeof list.text - used, "%s%s", i ? ", " : "",
                                 usage_of(&builtins[i]).text);
    return list;
}

/* --- names ----------------------------------------------------------------------------------- */

/* The statue was once called scan: that name still works, unlisted. */
static bool is_name(const builtin *entry, const char *name, size_t length)
{
    if (length == strlen("scan") && strncmp(name, "scan", length) == 0)
        return strcmp(entry->name, "statue") == 0;
    return strlen(entry->name) == length && strncmp(entry->name, name, length) == 0;
}

static const builtin *find_builtin(const char *name, size_t length)
{
    for (size_t i = 0; i < builtin_count; i++)
        if (is_name(&builtins[i], name, length))
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

static bool parse_name(const char *name, const builtin **entry, uint32_t *number, rk_error *error)
{
    const char *colon = strchr(name, ':');
    const name_list names = list_names();
    const builtin *found = *entry =
        find_builtin(name, colon ? (size_t)(colon - name) : strlen(name));
    if (!found)
        return rk_fail(error, "%s: there is no such built-in scene: choose one of %s", name,
                       names.text);
    *number = found->default_number;
    if (!colon || (found->highest_number && read_number(colon + 1, found, number)))
        return true;
    if (!found->highest_number)
        return rk_fail(error, "%s: %s takes no number: the built-in scenes are %s", name,
                       found->name, names.text);
    return rk_fail(error,
                   "%s: after the colon goes a whole number from %u to %u, as in %s:%u: the "
                   "built-in scenes are %s",
                   name, found->lowest_number, found->highest_number, found->name,
                   found->default_number, names.text);
}

bool rk_builtin_scene(rk_scene *scene, const char *name, rk_error *error)
{
    const builtin *entry;
    uint32_t number = 0;
    rk_mesh mesh;
    *scene = (rk_scene){0};
    if (!parse_name(name, &entry, &number, error) || !entry->make(&mesh, number, error))
        return false;
    if (!entry->arrange)
        return rk_scene_around(scene, name, &mesh, error);
    rk_scene_init(scene, name, &mesh);
    entry->arrange(scene);
    return true;
}
