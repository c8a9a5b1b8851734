/* The built-in scenes: number of triangles, closed, facing outwards, in the unit ball, in view,
 * well lit. */
#include "test.h"

#include "base/reflect.h"
#include "features/watertight.h"
#include "scenes/builtin.h"
#include "scenes/makers.h"

/* --- measures of a mesh ---------------------------------------------------------------------- */

static rk_scene make_scene(const char *name)
{
    rk_scene scene;
    rk_error error;
    rk_check_ok(rk_builtin_scene(&scene, name, &error), error);
    rk_check_ok(rk_mesh_validate(&scene.mesh, name, &error), error);
    return scene;
}

static rk_scene make_statue(uint32_t triangles)
{
    char name[32];
    snprintf(name, sizeof name, "statue:%u", triangles);
    return make_scene(name);
}

static void check_count(const char *name, uint32_t triangles)
{
    rk_scene scene = make_scene(name);
    rk_check_equal(scene.mesh.triangle_count, triangles, name);
    rk_check(strcmp(scene.name, name) == 0, "the scene is called %s instead of %s", scene.name,
             name);
    rk_scene_free(&scene);
}

typedef struct vec {
    double x, y, z;
} vec;

static vec corner_of(const rk_mesh *mesh, uint32_t triangle, int k)
{
    rk_vec3 p = mesh->positions[mesh->triangles[triangle][k]];
    return (vec){(double)p.x, (double)p.y, (double)p.z};
}

static vec minus(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* Perpendicular to the triangle; its length is twice the area. */
static vec normal_of(const rk_mesh *mesh, uint32_t triangle)
{
    vec a = corner_of(mesh, triangle, 0);
    vec u = minus(corner_of(mesh, triangle, 1), a), v = minus(corner_of(mesh, triangle, 2), a);
    return (vec){u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

static double area_of(const rk_mesh *mesh, uint32_t triangle)
{
    vec n = normal_of(mesh, triangle);
    return 0.5 * sqrt(dot(n, n));
}

/* By the divergence theorem; positive if faces are counter-clockwise from outside. */
static double volume_of(const rk_mesh *mesh)
{
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        sum += dot(corner_of(mesh, i, 0), normal_of(mesh, i));
    return sum / 6;
}

static void check_no_flat_triangle(const rk_mesh *mesh, const char *name)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        rk_check(area_of(mesh, i) > 0, "%s: triangle %u has no area", name, i);
}

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Counts the edges that belong to one triangle only; every other edge must belong to two that use
 * it in opposite directions. Vertices are the same if `id` gives them the same number. */
static uint32_t free_edges(const rk_mesh *mesh, const uint32_t *id)
{
    size_t count = 3 * (size_t)mesh->triangle_count;
    uint64_t *edges = malloc(count * sizeof *edges);
    for (size_t i = 0; i < count; i++) {
        const uint32_t *row = mesh->triangles[i / 3];
        uint64_t from = row[i % 3], to = row[(i + 1) % 3];
        if (id)
            from = id[from], to = id[to];
        rk_check(from != to, "triangle %zu has an edge without length", i / 3);
        /* The direction is the lowest bit, so that both of a pair become neighbours. */
        edges[i] = from < to ? from << 32 | to << 1 : to << 32 | from << 1 | 1;
    }
    qsort(edges, count, sizeof *edges, compare_keys);
    uint32_t alone = 0;
    for (size_t i = 0; i < count;) {
        size_t same = i + 1;
        while (same < count && edges[same] >> 1 == edges[i] >> 1)
            same++;
        bool paired = same == i + 2 && edges[i] != edges[i + 1];
        rk_check(paired || same == i + 1,
                 "edge %u - %u: %zu triangles, or two that run the same way",
                 (unsigned)(edges[i] >> 32), (unsigned)(edges[i] >> 1 & 0x7fffffff), same - i);
        alone += !paired;
        i = same;
    }
    free(edges);
    return alone;
}

static const rk_mesh *sorted_mesh; /* qsort passes no context */

static int compare_positions(const void *a, const void *b)
{
    rk_vec3 p = sorted_mesh->positions[*(const uint32_t *)a];
    rk_vec3 q = sorted_mesh->positions[*(const uint32_t *)b];
    if (p.x != q.x)
        return p.x < q.x ? -1 : 1;
    if (p.y != q.y)
        return p.y < q.y ? -1 : 1;
    return (p.z > q.z) - (p.z < q.z);
}

/* Gives vertices at exactly the same position the same number. */
static uint32_t *weld(const rk_mesh *mesh)
{
    uint32_t *order = malloc(mesh->vertex_count * sizeof *order);
    uint32_t *id = malloc(mesh->vertex_count * sizeof *id);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        order[i] = i;
    sorted_mesh = mesh;
    qsort(order, mesh->vertex_count, sizeof *order, compare_positions);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        id[order[i]] =
            i > 0 && compare_positions(&order[i - 1], &order[i]) == 0 ? id[order[i - 1]] : i;
    free(order);
    return id;
}

/* --- all scenes ------------------------------------------------------------------------------ */

/* All but the cover and the lanterns, whose floors extend to the horizon. */
static const char *const names[] = {"triangle",      "cube",          "cube-textured", "cornell",
                                    "cornell-glass", "cornell-light", "panes",         "panes:1",
                                    "glass",         "sphere",        "teapot",        "teapot:3",
                                    "statue",        "statue:967",    "moving",        "plates"};

enum { name_count = sizeof names / sizeof names[0] };

/* Scenes that keep the size given by their makers. */
static bool is_arranged(const char *name)
{
    return strncmp(name, "cornell", 7) == 0 || strncmp(name, "panes", 5) == 0 ||
           strcmp(name, "glass") == 0 || strcmp(name, "plates") == 0 || strcmp(name, "moving") == 0;
}

static void every_scene_is_valid_and_has_its_count(void **state)
{
    (void)state;
    check_count("triangle", 1);
    check_count("cube", 12);
    check_count("cube-textured", 12);
    check_count("cornell", 32);
    check_count("cornell-glass", 36); /* bottoms, too: 2 blocks x 2 */
    check_count("cornell-light", 30); /* no lamp */
    check_count("panes", 8);
    check_count("panes:1", 8);
    check_count("glass", 26);
    check_count("plates", 8);
    check_count("lanterns", 2 + 6 * 8); /* water, posts */
    check_count("sphere", 1280);
    check_count("moving", 2 + 4032 + 320); /* 32 x 8 x 8 squares of 2, less 8 x 8 at the poles */
    check_count("cover:967", 12 + 12 + 967 + 5120); /* floor, block, statue, ball */
    check_count("statue", 87130);
    check_count("teapot", 16256); /* 32 x 16 x 16 squares of 2, less 8 x 16 at the poles */
    check_count("teapot:2", 240);
    check_count("teapot:7", 3080);
}

static void every_scene_fits_into_the_unit_ball(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = make_scene(names[i]);
        float farthest = 0;
        for (uint32_t v = 0; v < scene.mesh.vertex_count; v++)
            farthest = fmaxf(farthest, rk_length(scene.mesh.positions[v]));
        const double rounding = 4 * 0x1p-24;
        if (is_arranged(names[i]))
            rk_check(farthest <= 1 && farthest > 0.98f, "%s reaches to %f", names[i],
                     (double)farthest);
        else
            rk_check_close(farthest, 1, rounding, names[i]);
        rk_scene_free(&scene);
    }
}

static void normals_are_unit_and_agree_with_the_faces(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = make_scene(names[i]);
        const rk_mesh *mesh = &scene.mesh;
        for (uint32_t v = 0; mesh->normals && v < mesh->vertex_count; v++)
            rk_check_close(rk_length(mesh->normals[v]), 1, 4 * 0x1p-24, names[i]);
        /* On a rough surface a corner's normal may point away from one of its faces. */
        uint32_t turned = 0;
        for (uint32_t t = 0; mesh->normals && t < mesh->triangle_count; t++)
            for (int k = 0; k < 3; k++) {
                rk_vec3 n = mesh->normals[mesh->triangles[t][k]];
                turned += dot(normal_of(mesh, t), (vec){(double)n.x, (double)n.y, (double)n.z}) < 0;
            }
        rk_check(turned <= 3 * mesh->triangle_count / 100,
                 "%s: %u corners turn their normal inwards", names[i], turned);
        rk_scene_free(&scene);
    }
}

static void the_light_is_above_left_of_the_camera_and_lights_its_view(void **state)
{
    (void)state;
    rk_scene scene = make_scene("sphere:80");
    rk_view view = rk_view_of(&scene.camera, 800, 800);
    rk_check_equal(scene.light_count, 1, "one light");
    rk_vec3 light = rk_normalize(scene.lights[0].position);
    rk_check(rk_dot(light, view.right) < -0.1f, "to the left");
    rk_check(rk_dot(light, view.up) > 0.1f, "above");
    rk_check(rk_dot(light, rk_normalize(view.position)) > 0.5f,
             "more than 60 degrees from the view: most of the visible side is dark");
    rk_check(rk_length(scene.lights[0].position) > 1, "outside the unit ball");
    rk_scene_free(&scene);
}

static void a_scene_around_a_mesh_takes_it_over(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_scene scene;
    rk_error error;
    rk_check_ok(rk_builtin_make_cube(&mesh, 0, &error), error);
    rk_check_ok(rk_scene_around(&scene, "dice", &mesh, &error), error);
    rk_check(mesh.positions == NULL && mesh.triangle_count == 0, "the mesh is still the caller's");
    rk_check_equal(scene.mesh.triangle_count, 12, "the scene has it");
    rk_check_close(scene.mesh.positions[7].x, 1 / sqrt(3), 0x1p-24, "moved into the unit ball");
    rk_check_close(scene.camera.distance, 3, 0, "the default camera");
    rk_scene_free(&scene);
    rk_scene_free(&scene); /* freeing twice, as freeing a zeroed scene, does nothing */
}

static void a_scene_around_a_broken_mesh_is_refused_and_empty(void **state)
{
    (void)state;
    for (int broken = 0; broken < 3; broken++) {
        const char *const want[] = {"triangle 11", "vertex 7", "material 0"};
        rk_mesh mesh;
        rk_scene scene;
        rk_error error = {""};
        rk_check_ok(rk_builtin_make_cube(&mesh, 0, &error), error);
        if (broken == 0)
            mesh.triangles[11][2] = mesh.vertex_count;
        if (broken == 1)
            mesh.positions[7].y = NAN;
        if (broken == 2)
            mesh.materials[0].alpha = 2;
        rk_check(!rk_scene_around(&scene, "dice", &mesh, &error), "%s is broken", want[broken]);
        rk_check_error_names(error, "dice: ");
        rk_check_error_names(error, want[broken]);
        rk_check(!mesh.positions && !scene.mesh.positions, "the mesh is freed");
        rk_check(scene.light_count == 0 && scene.mesh.triangle_count == 0, "an empty scene");
    }
}

static void a_wrong_name_or_number_is_refused_with_the_list(void **state)
{
    (void)state;
    const char *const wrong[] = {"nosuch",
                                 "",
                                 "tri",
                                 "triangles",
                                 "cube:3",
                                 "cornell:",
                                 "cornell-",
                                 "cornell-mirror",
                                 "cornell-glass:1",
                                 "cube_textured",
                                 "panes:2",
                                 "panes:",
                                 "teapot:",
                                 "teapot:1",
                                 "teapot:1001",
                                 "statue:0",
                                 "statue:abc",
                                 "statue:-5",
                                 "statue: 5",
                                 "statue:5 ",
                                 "statue:5x",
                                 "statue:1e3",
                                 "statue:99999999999",
                                 "sphere:0",
                                 ":",
                                 ":5",
                                 "statue:18446744073709551617",
                                 "SCAN"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        rk_scene scene;
        rk_error error = {""};
        rk_check(!rk_builtin_scene(&scene, wrong[i], &error), "\"%s\" was accepted", wrong[i]);
        rk_check_error_names(error, wrong[i]);
        rk_check_error_names(error, "triangle, cube, cube-textured, cornell, cornell-glass, "
                                    "cornell-light, panes:N, glass, sphere:N, spheres:N, "
                                    "shininess, plates, lanterns, teapot:N, statue:N");
        rk_scene_free(&scene); /* a refused scene is a zeroed one */
    }
}

static void the_help_names_every_scene(void **state)
{
    (void)state;
    char help[2000];
    rk_builtin_help(help, sizeof help);
    const char *const wanted[] = {
        "triangle  ", "cube  ",     "cube-textured  ", "cornell  ",      "panes:N  ",  "glass  ",
        "shininess ", "plates  ",   "cornell-glass  ", "cornell-light ", "sphere:N  ", "spheres:N ",
        "teapot:N  ", "statue:N  ", "moving:N  ",      "cover:N  ",      "lanterns  "};
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        char line[40];
        snprintf(line, sizeof line, "  %s", wanted[i]);
        rk_check(strstr(help, line), "the help misses %s", wanted[i]);
    }
    rk_check(
        strstr(help, "a statue as if from a scanner, of exactly N triangles (default 87130)\n"),
        "the help misses the number of triangles that a statue has by default:\n%s", help);
}

static void help_that_does_not_fit_is_truncated(void **state)
{
    (void)state;
    char whole[2000], part[100];
    rk_builtin_help(whole, sizeof whole);
    rk_builtin_help(part, sizeof part);
    rk_check(strlen(part) == sizeof part - 1 && strncmp(part, whole, sizeof part - 1) == 0,
             "got \"%s\"", part);
}

static void the_statue_is_still_made_by_its_old_name_which_is_not_listed(void **state)
{
    (void)state;
    rk_scene statue = make_scene("statue:50"), scan = make_scene("scan:50"), none;
    rk_check_equal(scan.mesh.triangle_count, 50, "scan:50");
    rk_check(memcmp(scan.mesh.positions, statue.mesh.positions,
                    statue.mesh.vertex_count * sizeof *statue.mesh.positions) == 0,
             "scan:50 is not statue:50");
    rk_error error = {""};
    rk_check(!rk_builtin_scene(&none, "scan:0", &error) && strstr(error.text, "as in statue:87130"),
             "got \"%s\"", error.text);
    char help[2000];
    rk_builtin_help(help, sizeof help);
    rk_check(!strstr(help, "  scan"), "the help lists scan");
    rk_scene_free(&statue);
    rk_scene_free(&scan);
}

/* --- simple shapes --------------------------------------------------------------------------- */

static void the_triangle_faces_the_camera(void **state)
{
    (void)state;
    rk_scene scene = make_scene("triangle");
    rk_view view = rk_view_of(&scene.camera, 8, 8);
    vec eye = {(double)view.position.x, (double)view.position.y, (double)view.position.z};
    rk_check(dot(normal_of(&scene.mesh, 0), eye) > 0, "its back is to the camera");
    rk_scene_free(&scene);
}

static void the_cube_is_closed_and_each_side_has_one_colour(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_builtin_make_cube(&mesh, 0, &error), error);
    rk_check_equal(free_edges(&mesh, NULL), 0, "closed");
    rk_check_close(volume_of(&mesh), 8, 0, "an edge of 2, outwards, in whole numbers");
    for (uint32_t i = 0; i < 12; i++) {
        /* The normals, 4 long, point to -x +x -y +y -z +z, as the materials are numbered. */
        vec n = normal_of(&mesh, i);
        const double component[3] = {n.x, n.y, n.z};
        uint32_t side = mesh.triangle_materials[i];
        rk_check_close(component[side / 2], side % 2 ? 4 : -4, 0, "the side of its material");
    }
    rk_mesh_free(&mesh);
}

/* The derivative of p by one texture coordinate of a triangle, with the other constant. */
static void texture_axes(const rk_mesh *mesh, uint32_t triangle, vec *along_u, vec *along_v)
{
    const uint32_t *row = mesh->triangles[triangle];
    const rk_vec2 *t = mesh->texcoords;
    vec a = corner_of(mesh, triangle, 0);
    vec p = minus(corner_of(mesh, triangle, 1), a), q = minus(corner_of(mesh, triangle, 2), a);
    double pu = (double)(t[row[1]].x - t[row[0]].x), pv = (double)(t[row[1]].y - t[row[0]].y);
    double qu = (double)(t[row[2]].x - t[row[0]].x), qv = (double)(t[row[2]].y - t[row[0]].y);
    double det = pu * qv - pv * qu;
    *along_u = (vec){(qv * p.x - pv * q.x) / det, (qv * p.y - pv * q.y) / det,
                     (qv * p.z - pv * q.z) / det};
    *along_v = (vec){(pu * q.x - qu * p.x) / det, (pu * q.y - qu * p.y) / det,
                     (pu * q.z - qu * p.z) / det};
}

static void the_textured_cube_shows_each_letter_upright_and_unmirrored(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_builtin_make_cube_textured(&mesh, 0, &error), error);
    rk_check_ok(rk_mesh_validate(&mesh, "cube", &error), error);
    uint32_t *id = weld(&mesh);
    rk_check_equal(free_edges(&mesh, id), 0, "closed");
    free(id);
    for (uint32_t i = 0; i < 12; i++) {
        vec n = normal_of(&mesh, i), right, up;
        texture_axes(&mesh, i, &right, &up);
        const double normal[3] = {n.x, n.y, n.z};
        uint32_t side = mesh.triangle_materials[i];
        rk_check_close(normal[side / 2], side % 2 ? 4 : -4, 0, "the side of its material");
        /* The picture is 1 across, the side 2; on top up is to the back, below to the front. */
        rk_check_close(up.y, side / 2 == 1 ? 0 : 2, 0, "v goes up");
        rk_check_close(up.z, side == 3 ? 2 : side == 2 ? -2 : 0, 0, "v goes up");
        vec outwards = {right.y * up.z - right.z * up.y, right.z * up.x - right.x * up.z,
                        right.x * up.y - right.y * up.x};
        rk_check_close(dot(outwards, n), 16, 0, "u goes right as seen from outside: no mirror");
        rk_check(mesh.materials[side].kd_texture == &mesh.textures[0], "side %u is plain", side);
    }
    rk_mesh_free(&mesh);
}

static void the_letter_differs_from_its_turned_and_mirrored_selves(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_builtin_make_cube_textured(&mesh, 0, &error), error);
    /* Ink in the quarters, top left, top right, bottom left, bottom right: an F has most in the
     * first and least in the last, and differs in any two that a reflection would swap. */
    int ink[4] = {0};
    const rk_image *image = &mesh.textures[0].image;
    for (size_t y = 0; y < image->height; y++)
        for (size_t x = 0; x < image->width; x++)
            ink[2 * (y >= image->height / 2) + (x >= image->width / 2)] +=
                rk_image_at(image, x, y)->x < 0.5f;
    rk_check(ink[0] > ink[1] && ink[0] > ink[2] && ink[1] != ink[2] && ink[3] == 0,
             "%d and %d above %d and %d", ink[0], ink[1], ink[2], ink[3]);
    rk_mesh_free(&mesh);
}

static void the_sphere_is_the_smallest_with_enough_triangles(void **state)
{
    (void)state;
    const uint32_t wanted[][2] = {{1, 20},  {20, 20},     {21, 80},
                                  {80, 80}, {1281, 1620}, {2000, 2000}};
    for (int i = 0; i < 6; i++) {
        rk_mesh mesh;
        rk_error error;
        rk_check_ok(rk_builtin_make_sphere(&mesh, wanted[i][0], &error), error);
        rk_check_equal(mesh.triangle_count, wanted[i][1], "20 f f");
        rk_check_equal(mesh.vertex_count, wanted[i][1] / 2 + 2, "Euler: no vertex twice");
        rk_check_equal(free_edges(&mesh, NULL), 0, "closed");
        rk_mesh_free(&mesh);
    }
}

static void sphere_triangles_are_the_icosahedrons_own(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_builtin_make_sphere(&mesh, 20 * 12 * 12, &error), error);
    double smallest = INFINITY, largest = 0;
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        smallest = fmin(smallest, area_of(&mesh, i));
        largest = fmax(largest, area_of(&mesh, i));
    }
    /* The projection stretches a face's middle against its corners by at most (R / r)^3 = 1.258^3 =
     * 1.99; a wrong diagonal would give slivers. */
    rk_check(largest < 2 * smallest, "areas from %g to %g", smallest, largest);
    rk_check_close(volume_of(&mesh), 4.18879, 0.02,
                   "4 pi / 3 minus the volume outside 2880 flat faces");
    rk_mesh_free(&mesh);
}

/* --- the Cornell box ------------------------------------------------------------------------- */

enum { white, red, green, lamp, mirror };

static void check_corners_are_in_the_picture(const char *name)
{
    rk_scene scene = make_scene(name);
    rk_view view = rk_view_of(&scene.camera, 800, 800);
    for (uint32_t i = 0; i < scene.mesh.vertex_count; i++) {
        rk_vec2 p;
        float depth;
        rk_check(rk_view_project(&view, scene.mesh.positions[i], &p, &depth), "behind the camera");
        rk_check(p.x > 0 && p.x < 800 && p.y > 0 && p.y < 800, "%s: corner %u appears at %f, %f",
                 name, i, (double)p.x, (double)p.y);
    }
    rk_scene_free(&scene);
}

static void every_corner_of_an_arranged_scene_is_in_its_picture(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++)
        if (is_arranged(names[i]))
            check_corners_are_in_the_picture(names[i]);
}

static void the_red_wall_is_left_and_the_green_one_right(void **state)
{
    (void)state;
    rk_scene scene = make_scene("cornell");
    rk_view view = rk_view_of(&scene.camera, 800, 800);
    int seen[5] = {0};
    for (uint32_t i = 0; i < 32; i++) {
        int material = scene.mesh.triangle_materials[i];
        seen[material]++;
        for (int k = 0; k < 3; k++) {
            rk_vec2 p;
            float depth;
            rk_view_project(&view, scene.mesh.positions[scene.mesh.triangles[i][k]], &p, &depth);
            rk_check(material != red || p.x < 250, "red at column %f of 800", (double)p.x);
            rk_check(material != green || p.x > 550, "green at column %f of 800", (double)p.x);
        }
    }
    const int wanted[5] = {16, 2, 2, 2, 10};
    for (int m = 0; m < 5; m++)
        rk_check_equal(seen[m], wanted[m], "white, red, green, lamp, mirror");
    rk_check_close(scene.mesh.materials[mirror].ks.x, 0.95, 1e-7, "the tall block is a mirror");
    rk_check_close(scene.mesh.materials[mirror].kd.x, 0.01, 1e-7, "the tall block is a mirror");
    rk_scene_free(&scene);
}

static void cornell_walls_face_inwards_and_blocks_outwards(void **state)
{
    (void)state;
    rk_scene scene = make_scene("cornell");
    for (uint32_t i = 0; i < 32; i++) {
        uint32_t block_start = i < 12 ? 0 : i < 22 ? 12 : 22, block_end = i < 22 ? 22 : 32;
        vec middle = {0, 0, 0};
        for (uint32_t t = block_start; i >= 12 && t < block_end; t++)
            for (int k = 0; k < 3; k++) {
                vec c = corner_of(&scene.mesh, t, k);
                middle.x += c.x / 30, middle.y += c.y / 30, middle.z += c.z / 30;
            }
        double out = dot(normal_of(&scene.mesh, i), minus(corner_of(&scene.mesh, i, 0), middle));
        rk_check(i < 12 ? out < 0 : out > 0, "triangle %u faces the wrong way", i);
    }
    rk_scene_free(&scene);
}

static void the_cornell_light_hangs_just_below_the_lamp(void **state)
{
    (void)state;
    rk_scene scene = make_scene("cornell");
    float lamp_y = NAN, ceiling = rk_mesh_bounds(&scene.mesh).corner[1].y;
    for (uint32_t i = 0; i < 32; i++)
        if (scene.mesh.triangle_materials[i] == lamp)
            lamp_y = scene.mesh.positions[scene.mesh.triangles[i][0]].y;
    rk_check(lamp_y < ceiling, "the lamp is hidden in the ceiling");
    float below = lamp_y - scene.lights[0].position.y;
    rk_check(below > 0 && below < 0.05f, "the light is %f below the lamp", (double)below);
    rk_scene_free(&scene);
}

static void only_the_mirror_of_the_cornell_box_reflects(void **state)
{
    (void)state;
    const char *const boxes[] = {"cornell", "cornell-glass", "cornell-light"};
    for (int i = 0; i < 3; i++) {
        rk_scene scene = make_scene(boxes[i]);
        for (uint32_t t = 0; t < scene.mesh.triangle_count; t++) {
            uint32_t m = scene.mesh.triangle_materials[t];
            rk_vec3 ks = scene.mesh.materials[m].ks;
            bool reflects = ks.x > 0 || ks.y > 0 || ks.z > 0;
            rk_check(reflects == (i == 0 && m == mirror), "%s: material %u", boxes[i], m);
        }
        rk_scene_free(&scene);
    }
}

/* Some triangles of a mesh, as a mesh of its own that borrows all arrays. */
static rk_mesh part_of(const rk_mesh *mesh, uint32_t first, uint32_t count)
{
    rk_mesh part = *mesh;
    part.triangles = mesh->triangles + first;
    part.triangle_count = count;
    return part;
}

/* Triangles first .. first + 11 are a closed block of glass, outwards, and of this volume. */
static void check_block(const rk_mesh *mesh, uint32_t first, double volume, double tolerance)
{
    rk_mesh block = part_of(mesh, first, 12);
    uint32_t *id = weld(&block);
    rk_check_equal(free_edges(&block, id), 0, "a block is closed, or rays never leave it");
    free(id);
    rk_check_close(volume_of(&block), volume, tolerance, "the volume, outwards");
    for (uint32_t t = first; t < first + 12; t++) {
        const rk_material *m = &mesh->materials[mesh->triangle_materials[t]];
        rk_check_close(m->alpha, 0.3, 1e-7, "transparent");
        /* It filters every channel: none passes unchanged, none is absorbed completely. */
        rk_check(m->absorption.x > 0 && m->absorption.y > 0 && m->absorption.z > 0 &&
                     m->absorption.x < 10,
                 "the glass is clear, or black");
    }
}

/* The footprint's area, by the shoelace formula, times the height minus 1 mm, in units of 481
 * mm. */
static double cornell_block(const double (*p)[2], double height)
{
    double twice = 0;
    for (int i = 0; i < 4; i++)
        twice += p[i][0] * p[(i + 1) % 4][1] - p[i][1] * p[(i + 1) % 4][0];
    return fabs(twice) / 2 * (height - 1) / (481.0 * 481 * 481);
}

static void the_cornell_blocks_of_glass_are_closed_and_coloured(void **state)
{
    (void)state;
    const double low[4][2] = {{130, 65}, {82, 225}, {240, 272}, {290, 114}};
    const double tall[4][2] = {{423, 247}, {265, 296}, {314, 456}, {472, 406}};
    rk_scene scene = make_scene("cornell-glass");
    /* Corners below 1 are rounded by 2^-25, and areas are below 1; there are 12. */
    const double rounding = 12 * 0x1p-25;
    check_block(&scene.mesh, 12, cornell_block(low, 165), rounding);
    check_block(&scene.mesh, 24, cornell_block(tall, 330), rounding);
    const rk_material *m = scene.mesh.materials;
    rk_vec3 amber = m[scene.mesh.triangle_materials[12]].kd;
    rk_vec3 blue = m[scene.mesh.triangle_materials[24]].kd;
    rk_check(amber.x > amber.z && blue.z > blue.x, "one is amber, the other blue");
    rk_scene_free(&scene);
}

static void glass_of_its_thickness_filters_to_its_colour(void **state)
{
    (void)state;
    rk_material m = rk_builtin_glass(rk_vec(0.25f, 0.5f, 1), 0.3f, 2);
    for (int axis = 0; axis < 3; axis++)
        rk_check_close(exp(-2 * (double)rk_axis(m.absorption, axis)), rk_axis(m.kd, axis), 1e-7,
                       "exp(-sigma 2), a few roundings");
    rk_check_close(m.ks.x, 0, 0, "it does not reflect");
}

static void the_parallelogram_light_is_where_the_lamp_was(void **state)
{
    (void)state;
    rk_scene with_lamp = make_scene("cornell"), scene = make_scene("cornell-light");
    const rk_mesh *mesh = &with_lamp.mesh;
    const rk_light *light = &scene.lights[0];
    rk_check(scene.light_count == 1 && light->kind == RK_LIGHT_PARALLELOGRAM, "one light");
    for (uint32_t t = 0; t < scene.mesh.triangle_count; t++)
        rk_check(scene.mesh.triangle_materials[t] != lamp, "triangle %u blocks the light", t);
    int matches = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            if (mesh->triangle_materials[t] != lamp)
                continue;
            rk_vec3 p = mesh->positions[mesh->triangles[t][k]];
            for (int c = 0; c < 4; c++) {
                rk_vec3 q = rk_madd(light->position, light->edge01, (float)(c & 1));
                q = rk_madd(q, light->edge02, (float)(c >> 1));
                matches += rk_length(rk_sub(p, q)) < 0.002f; /* the lamp is closer to the ceiling */
            }
        }
    rk_check_equal(matches, 6, "all corners of the lamp's two triangles are the light's");
    for (int c = 0; c < 4; c++)
        rk_check(light->colours[c].x > 0, "corner %d is dark", c);
    rk_scene_free(&with_lamp);
    rk_scene_free(&scene);
}

/* --- panes and blocks of glass --------------------------------------------------------------- */

/* The materials between a and b, nearest first, without the ends'. */
static uint32_t crossed(const rk_scene *scene, rk_vec3 a, rk_vec3 b, uint32_t materials[8],
                        float t[8])
{
    const rk_mesh *mesh = &scene->mesh;
    uint32_t count = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->triangles[i];
        rk_triangle triangle = {mesh->positions[corner[0]], mesh->positions[corner[1]],
                                mesh->positions[corner[2]], i};
        rk_ray ray = {a, rk_sub(b, a), 1};
        rk_hit hit = rk_watertight_intersect(&triangle, &ray);
        /* A hit within a thousandth of an end is the surface of that end. */
        if (hit.t < 0.001f || hit.t > 0.999f)
            continue;
        rk_check(count < 8, "more than 8 crossings");
        uint32_t k = count++;
        for (; k > 0 && t[k - 1] > hit.t; k--)
            t[k] = t[k - 1], materials[k] = materials[k - 1];
        t[k] = hit.t, materials[k] = mesh->triangle_materials[i];
    }
    return count;
}

enum { plaster, red_pane, yellow_pane };

static void panes_stand_in_the_same_order_for_the_light_and_the_viewer(void **state)
{
    (void)state;
    for (uint32_t order = 0; order < 2; order++) {
        rk_scene scene = make_scene(order ? "panes:1" : "panes");
        const rk_vec3 eye = rk_view_of(&scene.camera, 8, 8).position,
                      lit = scene.lights[0].position;
        uint32_t first = order ? yellow_pane : red_pane, second = order ? red_pane : yellow_pane;
        int seen_through_both = 0, seen_through_one[2] = {0}, in_full_shadow = 0, in_light = 0;
        /* For points on the wall: the materials towards the viewer and towards the light. */
        for (int y = 0; y < 40; y++)
            for (int x = 0; x < 40; x++) {
                rk_vec3 p = rk_vec(((float)x + 0.5f) * 0.035f - 0.7f,
                                   ((float)y + 0.5f) * 0.025f - 0.5f, 0.5f);
                uint32_t m[8], n[8];
                float t[8];
                uint32_t to_eye = crossed(&scene, eye, p, m, t);
                uint32_t to_light = crossed(&scene, lit, p, n, t);
                rk_check(to_eye < 2 || (m[0] == first && m[1] == second), "the viewer's order");
                rk_check(to_light < 2 || (n[0] == first && n[1] == second), "the light's order");
                seen_through_both += to_eye == 2;
                if (to_eye == 1)
                    seen_through_one[m[0] - red_pane]++;
                in_full_shadow += to_eye == 0 && to_light == 2;
                in_light += to_eye == 0 && to_light == 0;
            }
        /* Of 1600 points. */
        rk_check(seen_through_both > 50, "%d places are seen through both", seen_through_both);
        rk_check(seen_through_one[0] > 50 && seen_through_one[1] > 50,
                 "%d and %d are seen through one", seen_through_one[0], seen_through_one[1]);
        rk_check(in_full_shadow > 50, "both panes' shadow is seen at %d places", in_full_shadow);
        rk_check(in_light > 200, "%d places are in the light and in view", in_light);
        rk_scene_free(&scene);
    }
}

static void the_two_orders_differ_in_depth_alone(void **state)
{
    (void)state;
    rk_scene a = make_scene("panes:0"), b = make_scene("panes:1");
    for (uint32_t t = 0; t < 8; t++)
        for (int k = 0; k < 3; k++) {
            vec p = corner_of(&a.mesh, t, k), q = corner_of(&b.mesh, t, k);
            rk_check(p.x == q.x && p.y == q.y, "triangle %u is elsewhere", t);
            rk_check((p.z != q.z) == (a.mesh.triangle_materials[t] != plaster), "triangle %u", t);
            rk_check(a.mesh.triangle_materials[t] == b.mesh.triangle_materials[t], "colours");
        }
    rk_vec3 red_kd = a.mesh.materials[red_pane].kd, yellow_kd = a.mesh.materials[yellow_pane].kd;
    rk_check(red_kd.x > 0.5f && red_kd.y < 0.2f && yellow_kd.y > 0.5f && yellow_kd.z < 0.2f,
             "red and yellow");
    rk_check_close(a.mesh.materials[red_pane].alpha, 0.5, 0, "half transparent");
    rk_check_close(a.mesh.materials[yellow_pane].alpha, 0.5, 0, "half transparent");
    rk_scene_free(&a);
    rk_scene_free(&b);
}

static void thin_and_thick_glass_are_closed_and_of_one_material(void **state)
{
    (void)state;
    rk_scene scene = make_scene("glass");
    check_block(&scene.mesh, 2, 0.4 * 0.35 * 0.06, 12 * 0x1p-25);
    check_block(&scene.mesh, 14, 0.4 * 0.35 * 0.4, 12 * 0x1p-25);
    for (uint32_t t = 2; t < 26; t++)
        rk_check_equal(scene.mesh.triangle_materials[t], scene.mesh.triangle_materials[2],
                       "the same glass");
    rk_scene_free(&scene);
}

static void both_shadows_of_the_glass_are_seen_on_the_floor(void **state)
{
    (void)state;
    rk_scene scene = make_scene("glass");
    const rk_vec3 eye = rk_view_of(&scene.camera, 8, 8).position, lit = scene.lights[0].position;
    int in_shadow[2] = {0};
    double inside[2] = {0}; /* the longest path of light in the glass */
    for (int z = 0; z < 60; z++)
        for (int x = 0; x < 60; x++) {
            rk_vec3 p = rk_vec(((float)x + 0.5f) * 1.4f / 60 - 0.7f, -0.35f,
                               ((float)z + 0.5f) * 0.02f - 0.6f);
            uint32_t m[8];
            float t[8];
            if (crossed(&scene, eye, p, m, t) > 0 || crossed(&scene, p, lit, m, t) != 2)
                continue;
            bool thin = p.x > 0; /* x grows to the left of the picture */
            in_shadow[thin]++;
            inside[thin] = fmax(inside[thin], (double)((t[1] - t[0]) * rk_length(rk_sub(lit, p))));
        }
    /* Of 3600 points on the floor. */
    rk_check(in_shadow[0] > 100 && in_shadow[1] > 100, "shadows are seen at %d and %d places",
             in_shadow[0], in_shadow[1]);
    rk_check(inside[0] > 4 * inside[1], "light goes %f in the thick block, %f in the thin one",
             inside[0], inside[1]);
    rk_scene_free(&scene);
}

/* --- the teapot ------------------------------------------------------------------------------ */

static rk_mesh make_teapot(uint32_t n)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_builtin_make_teapot(&mesh, n, &error), error);
    return mesh;
}

static void teapot_patches_have_common_edges_to_the_bit(void **state)
{
    (void)state;
    for (uint32_t n = 2; n <= 14; n += 3) {
        rk_mesh mesh = make_teapot(n);
        uint32_t *id = weld(&mesh);
        /* Open edges: the inside of the rim and the lid's edge, 4 patches each, and both ends of
         * handle and spout, 2 patches each. */
        rk_check_equal(free_edges(&mesh, id), 16 * n, "free edges of the welded teapot");
        free(id);
        rk_mesh_free(&mesh);
    }
}

static void the_teapots_patches_are_the_published_ones(void **state)
{
    (void)state;
    /* The middle of each published patch, sum of w_i w_j P_ij with w = (1, 3, 3, 1) / 8: each of
     * the 16 control points, published one by one, counts. */
    static const struct {
        uint32_t patch;
        double middle[3];
    } wanted[] = {
        {2, {-0.99621875, 2.4984375, -0.99621875}}, {6, {-1.3090625, 1.621875, -1.3090625}},
        {10, {-1.2425, 0.384375, -1.2425}},         {14, {-0.23103125, 2.98125, -0.23103125}},
        {18, {-0.58575, 2.55, -0.58575}},           {22, {-0.91190625, 0.046875, -0.91190625}},
        {24, {2.51875, 2.0953125, -0.225}},         {26, {2.634375, 1.25390625, -0.225}},
        {28, {-2.5375, 1.621875, -0.34125}},        {30, {-3.1265625, 2.46679688, -0.15}},
    };
    rk_mesh mesh = make_teapot(2);
    for (int i = 0; i < 10; i++) {
        rk_vec3 got = mesh.positions[9 * wanted[i].patch + 4];
        const float component[3] = {got.x, got.y, got.z};
        for (int k = 0; k < 3; k++)
            rk_check_close(component[k], wanted[i].middle[k], 1.5e-7, "rounded to float below 4");
    }
    rk_mesh_free(&mesh);
}

static void the_teapot_has_its_known_size(void **state)
{
    (void)state;
    rk_mesh mesh = make_teapot(64);
    rk_box box = rk_mesh_bounds(&mesh);
    rk_check_close(box.corner[1].x, 3, 0, "the handle reaches to 3 at a patch's edge");
    /* The lip's control points 3.3, 3.525, 3.45, 3.2 are farthest out at t = .410025. */
    const double t = 0.410025, s = 1 - t;
    double lip = 3.3 * s * s * s + 3 * 3.525 * s * s * t + 3 * 3.45 * s * t * t + 3.2 * t * t * t;
    rk_check_close(-box.corner[0].x, lip, 0.6 / 8 / 64 / 64, "a 64th of the curve, curvature .6");
    rk_check_close(box.corner[0].y, 0, 0, "the bottom's pole");
    rk_check_close(box.corner[1].y, 3.15, 1.2e-7, "the knob's pole, rounded to float");
    rk_check_close(box.corner[0].z, -2, 0, "the belly");
    rk_check_close(box.corner[1].z, 2, 0, "the belly");
    rk_mesh_free(&mesh);
}

static void the_teapot_is_its_own_mirror_image_to_the_bit(void **state)
{
    (void)state;
    rk_mesh mesh = make_teapot(6), both = make_teapot(6);
    for (uint32_t i = 0; i < both.vertex_count; i++)
        both.positions[i].z = -both.positions[i].z;
    /* As sets of places: sort both, then compare. */
    uint32_t *order[2];
    const rk_mesh *meshes[2] = {&mesh, &both};
    for (int m = 0; m < 2; m++) {
        order[m] = malloc(mesh.vertex_count * sizeof *order[m]);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            order[m][i] = i;
        sorted_mesh = meshes[m];
        qsort(order[m], mesh.vertex_count, sizeof *order[m], compare_positions);
    }
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        rk_vec3 p = mesh.positions[order[0][i]], q = both.positions[order[1][i]];
        rk_check(p.x == q.x && p.y == q.y && p.z == q.z, "%.9g %.9g %.9g has no mirror image",
                 (double)p.x, (double)p.y, (double)p.z);
    }
    free(order[0]);
    free(order[1]);
    rk_mesh_free(&mesh);
    rk_mesh_free(&both);
}

static void the_teapot_faces_outwards(void **state)
{
    (void)state;
    const uint32_t n = 8;
    rk_mesh mesh = make_teapot(n);
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        vec a = corner_of(&mesh, i, 0), face = normal_of(&mesh, i);
        uint32_t patch = mesh.triangles[i][0] / ((n + 1) * (n + 1));
        if (patch >= 4 && patch < 12) /* the body, away from the axis at half height */
            rk_check(dot(face, (vec){a.x, a.y - 1.2, a.z}) > 0, "body triangle %u faces inwards",
                     i);
        if (patch >= 20 && patch < 24) /* the bottom */
            rk_check(face.y <= 0, "bottom triangle %u faces up", i);
        if (patch < 4) /* the rim: from the ring in its middle */
            rk_check(dot(face, minus(a, (vec){a.x * 1.42 / hypot(a.x, a.z), 2.4,
                                              a.z * 1.42 / hypot(a.x, a.z)})) > 0,
                     "rim triangle %u faces inwards", i);
        if (patch >= 24 && patch < 30 && fabs(a.z) > 0.1) /* handle and spout without its lip */
            rk_check(face.z * a.z > -1e-4 * fabs(a.z), "triangle %u of handle or spout", i);
    }
    rk_mesh_free(&mesh);
}

static void teapot_normals_fit_the_surface(void **state)
{
    (void)state;
    const uint32_t n = 64;
    rk_mesh mesh = make_teapot(n);
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        vec face = normal_of(&mesh, i);
        double length = sqrt(dot(face, face));
        for (int k = 0; k < 3; k++) {
            rk_vec3 v = mesh.normals[mesh.triangles[i][k]];
            double cosine = dot(face, (vec){(double)v.x, (double)v.y, (double)v.z}) / length;
            rk_check(cosine > 0.8, "triangle %u and its corner's normal differ by cos %f", i,
                     cosine);
        }
    }
    rk_mesh_free(&mesh);
}

static void teapot_poles_have_vertical_normals(void **state)
{
    (void)state;
    rk_mesh mesh = make_teapot(5);
    int knob = 0, bottom = 0;
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        rk_vec3 p = mesh.positions[i], n = mesh.normals[i];
        if (p.x != 0 || p.z != 0)
            continue;
        bool top = p.y > 1;
        rk_check_close(n.y, top ? 1 : -1, 0, "straight up on the knob, down below");
        knob += top, bottom += !top;
    }
    rk_check_equal(knob, 4 * 6, "each patch of the knob ends in the pole");
    rk_check_equal(bottom, 4 * 6, "each patch of the bottom ends in the pole");
    rk_mesh_free(&mesh);
}

static void no_teapot_triangle_is_flat(void **state)
{
    (void)state;
    for (uint32_t n = 2; n <= 34; n += 8) {
        rk_mesh mesh = make_teapot(n);
        check_no_flat_triangle(&mesh, "teapot");
        rk_mesh_free(&mesh);
    }
}

/* --- the statue ------------------------------------------------------------------------------- */

static const uint32_t statue_counts[] = {6, 7, 50, 100, 333, 500, 966, 967, 5000, 20001, 87130};

enum { statue_count_count = sizeof statue_counts / sizeof statue_counts[0] };

static void a_statue_has_exactly_the_requested_triangles(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 50; n++) {
        rk_scene scene = make_statue(n);
        rk_check_equal(scene.mesh.triangle_count, n, "exactly N");
        check_no_flat_triangle(&scene.mesh, scene.name);
        rk_scene_free(&scene);
    }
    for (int i = 0; i < statue_count_count; i++) {
        rk_scene scene = make_statue(statue_counts[i]);
        rk_check_equal(scene.mesh.triangle_count, statue_counts[i], "exactly N");
        check_no_flat_triangle(&scene.mesh, scene.name);
        rk_scene_free(&scene);
    }
}

static void a_statue_is_closed_but_for_one_hole_when_odd(void **state)
{
    (void)state;
    for (int i = 0; i < statue_count_count; i++) {
        rk_scene scene = make_statue(statue_counts[i]);
        rk_check_equal(free_edges(&scene.mesh, NULL), statue_counts[i] % 2 ? 3 : 0, scene.name);
        rk_check(volume_of(&scene.mesh) > 0, "%s is inside out", scene.name);
        rk_scene_free(&scene);
    }
}

static void every_vertex_of_a_statue_belongs_to_a_triangle(void **state)
{
    (void)state;
    for (uint32_t n = 1; n < 300; n += n < 10 ? 1 : 37) {
        rk_scene scene = make_statue(n);
        char used[1000] = {0};
        for (uint32_t i = 0; i < 3 * n; i++)
            used[scene.mesh.triangles[i / 3][i % 3]] = 1;
        for (uint32_t v = 0; v < scene.mesh.vertex_count; v++)
            rk_check(used[v], "statue:%u: vertex %u belongs to no triangle", n, v);
        rk_scene_free(&scene);
    }
}

static void statue_triangles_are_of_similar_size(void **state)
{
    (void)state;
    const uint32_t n = 87130;
    rk_scene scene = make_statue(n);
    double mean = 0;
    for (uint32_t i = 0; i < n; i++)
        mean += area_of(&scene.mesh, i) / n;
    uint32_t odd = 0;
    for (uint32_t i = 0; i < n; i++)
        odd += area_of(&scene.mesh, i) < mean / 3 || area_of(&scene.mesh, i) > 3 * mean;
    rk_check(odd < n / 100, "%u of %u triangles are under a third or over thrice the mean", odd, n);
    rk_scene_free(&scene);
}

static void the_shininess_scene_is_five_spheres_in_a_row_from_dull_to_sharp(void **state)
{
    (void)state;
    rk_scene scene = make_scene("shininess");
    rk_check_equal(scene.sphere_count, 5, "shininess 1, 10, 100, 1000 and 100,000");
    rk_check_equal(scene.mesh.triangle_count, 0, "exact spheres alone");
    for (uint32_t i = 0; i + 1 < scene.sphere_count; i++) {
        const rk_sphere *left = &scene.spheres[i], *right = &scene.spheres[i + 1];
        rk_check(left->centre.x - left->radius > right->centre.x + right->radius,
                 "spheres %u and %u touch, or do not go from left to right", i, i + 1);
        rk_check(scene.sphere_materials[i].shininess < scene.sphere_materials[i + 1].shininess,
                 "sphere %u is as shiny as the next", i);
    }
    rk_scene_free(&scene);
}

/* The middle of each plate shows the middle of the row of lamps. */
static void each_plate_reflects_the_lamps_to_the_camera(void **state)
{
    (void)state;
    rk_scene scene = make_scene("plates");
    rk_vec3 eye = rk_view_of(&scene.camera, 4, 3).position;
    for (uint32_t i = 0; i < 4; i++) {
        const rk_vec3 *corner = &scene.mesh.positions[4 * i];
        rk_vec3 middle = rk_scale(rk_add(corner[0], corner[2]), 0.5f);
        rk_vec3 normal =
            rk_normalize(rk_cross(rk_sub(corner[1], corner[0]), rk_sub(corner[3], corner[0])));
        rk_vec3 from_eye = rk_sub(middle, eye);
        rk_check(rk_dot(from_eye, normal) < 0, "plate %u shows its back", i);
        rk_vec3 mirrored = rk_reflect(from_eye, normal);
        for (uint32_t k = 0; k < scene.light_count; k++) {
            const rk_light *light = &scene.lights[k];
            rk_vec3 to_light =
                rk_sub(rk_madd(rk_madd(light->position, light->edge01, 0.5f), light->edge02, 0.5f),
                       middle);
            rk_check_close(mirrored.y / mirrored.z, (double)(to_light.y / to_light.z), 1e-5,
                           "the lamps are beside each other in the mirror direction");
        }
        rk_check(i == 0 ||
                     scene.mesh.materials[i].shininess < scene.mesh.materials[i - 1].shininess,
                 "plate %u is as sharp as the one below", i);
    }
    rk_scene_free(&scene);
}

static double brightest(rk_vec3 colour)
{
    return fmax((double)colour.x, fmax((double)colour.y, (double)colour.z));
}

static void the_lanterns_are_brighter_than_white_and_all_else_is_dark(void **state)
{
    (void)state;
    rk_scene scene = make_scene("lanterns");
    double light = (double)scene.lights[0].colours[0].x;
    for (uint32_t i = 0; i < scene.sphere_count; i++)
        rk_check(light * brightest(scene.sphere_materials[i].kd) > 1,
                 "lantern %u is darker than white", i);
    for (uint32_t m = 0; m < scene.mesh.material_count; m++)
        rk_check(light * brightest(scene.mesh.materials[m].kd) < 0.1, "material %u is not dark", m);
    rk_scene_free(&scene);
}

static uint64_t fingerprint(const rk_mesh *mesh)
{
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a over the words */
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i++) {
        uint32_t word;
        memcpy(&word, &mesh->positions[0].x + i, sizeof word);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    return hash;
}

static void a_statue_is_the_same_to_the_bit_on_every_machine(void **state)
{
    (void)state;
    rk_scene scene = make_statue(967);
    uint64_t got = fingerprint(&scene.mesh);
    rk_check(got == 0x1cea92e97efc7850u,
             "the fingerprint is %#llx: only a change of the statue may change it",
             (unsigned long long)got);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_scene_is_valid_and_has_its_count),
    cmocka_unit_test(every_scene_fits_into_the_unit_ball),
    cmocka_unit_test(normals_are_unit_and_agree_with_the_faces),
    cmocka_unit_test(the_light_is_above_left_of_the_camera_and_lights_its_view),
    cmocka_unit_test(a_scene_around_a_mesh_takes_it_over),
    cmocka_unit_test(a_scene_around_a_broken_mesh_is_refused_and_empty),
    cmocka_unit_test(a_wrong_name_or_number_is_refused_with_the_list),
    cmocka_unit_test(the_help_names_every_scene),
    cmocka_unit_test(help_that_does_not_fit_is_truncated),
    cmocka_unit_test(the_statue_is_still_made_by_its_old_name_which_is_not_listed),
    cmocka_unit_test(the_triangle_faces_the_camera),
    cmocka_unit_test(the_cube_is_closed_and_each_side_has_one_colour),
    cmocka_unit_test(the_textured_cube_shows_each_letter_upright_and_unmirrored),
    cmocka_unit_test(the_letter_differs_from_its_turned_and_mirrored_selves),
    cmocka_unit_test(the_sphere_is_the_smallest_with_enough_triangles),
    cmocka_unit_test(sphere_triangles_are_the_icosahedrons_own),
    cmocka_unit_test(the_lanterns_are_brighter_than_white_and_all_else_is_dark),
    cmocka_unit_test(each_plate_reflects_the_lamps_to_the_camera),
    cmocka_unit_test(the_shininess_scene_is_five_spheres_in_a_row_from_dull_to_sharp),
    cmocka_unit_test(every_corner_of_an_arranged_scene_is_in_its_picture),
    cmocka_unit_test(the_red_wall_is_left_and_the_green_one_right),
    cmocka_unit_test(cornell_walls_face_inwards_and_blocks_outwards),
    cmocka_unit_test(the_cornell_light_hangs_just_below_the_lamp),
    cmocka_unit_test(only_the_mirror_of_the_cornell_box_reflects),
    cmocka_unit_test(the_cornell_blocks_of_glass_are_closed_and_coloured),
    cmocka_unit_test(glass_of_its_thickness_filters_to_its_colour),
    cmocka_unit_test(the_parallelogram_light_is_where_the_lamp_was),
    cmocka_unit_test(panes_stand_in_the_same_order_for_the_light_and_the_viewer),
    cmocka_unit_test(the_two_orders_differ_in_depth_alone),
    cmocka_unit_test(thin_and_thick_glass_are_closed_and_of_one_material),
    cmocka_unit_test(both_shadows_of_the_glass_are_seen_on_the_floor),
    cmocka_unit_test(teapot_patches_have_common_edges_to_the_bit),
    cmocka_unit_test(the_teapots_patches_are_the_published_ones),
    cmocka_unit_test(the_teapot_has_its_known_size),
    cmocka_unit_test(the_teapot_is_its_own_mirror_image_to_the_bit),
    cmocka_unit_test(the_teapot_faces_outwards),
    cmocka_unit_test(teapot_normals_fit_the_surface),
    cmocka_unit_test(teapot_poles_have_vertical_normals),
    cmocka_unit_test(no_teapot_triangle_is_flat),
    cmocka_unit_test(a_statue_has_exactly_the_requested_triangles),
    cmocka_unit_test(a_statue_is_closed_but_for_one_hole_when_odd),
    cmocka_unit_test(every_vertex_of_a_statue_belongs_to_a_triangle),
    cmocka_unit_test(statue_triangles_are_of_similar_size),
    cmocka_unit_test(a_statue_is_the_same_to_the_bit_on_every_machine),
};

RK_SUITE("scenes", tests)
