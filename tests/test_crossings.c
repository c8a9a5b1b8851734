/* Gathering a ray's crossings: the same as by brute force, each once, at edges and corners too. */
#include "test.h"
#include "test_scene.h"

#include "accel/query/crossings.h"
#include "base/random.h"
#include "features/watertight.h"
#include "scene/bvh_build.h"

/* --- Scenes and rays to try ------------------------------------------------------------------- */

/* A number in [-1, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return 2 * rk_unit_float(rk_hash(a, b, c, 5)) - 1;
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(noise(a, b, 0), noise(a, b, 1), noise(a, b, 2));
}

/* Panes of half opacity scattered in the cube [-1, 1]^3. */
static rk_scene make_soup(uint32_t triangles, float size, uint32_t seed)
{
    rk_scene scene = test_scene_make(triangles);
    for (uint32_t i = 0; i < triangles; i++) {
        rk_vec3 centre = noise3(seed, 4 * i);
        test_scene_triangle(&scene, i, rk_madd(centre, noise3(seed, 4 * i + 1), size),
                            rk_madd(centre, noise3(seed, 4 * i + 2), size),
                            rk_madd(centre, noise3(seed, 4 * i + 3), size));
    }
    scene.mesh.materials[0].alpha = 0.5f;
    return scene;
}

/* `count` squares [-1, 1]^2 across the z axis, at the given heights, their outside facing down: two
 * triangles each. */
static rk_scene make_panes(const float *heights, uint32_t count)
{
    rk_scene scene = test_scene_make(2 * count);
    for (uint32_t i = 0; i < count; i++)
        test_scene_quad(&scene, 2 * i, rk_vec(-1, -1, heights[i]), rk_vec(0, 2, 0),
                        rk_vec(2, 0, 0));
    scene.mesh.materials[0].alpha = 0.5f;
    return scene;
}

/* Puts a quad of side x side squares from `corner` on; indices from `first` on. */
static uint32_t put_grid(rk_scene *scene, uint32_t first, rk_vec3 corner, rk_vec3 a, rk_vec3 b,
                         uint32_t side)
{
    for (uint32_t i = 0; i < side; i++)
        for (uint32_t j = 0; j < side; j++, first += 2) {
            rk_vec3 start = rk_madd(rk_madd(corner, a, (float)i), b, (float)j);
            test_scene_quad(scene, first, start, a, b);
        }
    return first;
}

/* A closed block of glass from (0, 0, 0) to (side, side, side), each face side x side squares of
 * two triangles, all corners on whole coordinates. */
static rk_scene make_block(uint32_t side)
{
    const rk_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    const float s = (float)side;
    rk_scene scene = test_scene_make(12 * side * side);
    uint32_t next = 0;
    next = put_grid(&scene, next, rk_vec(0, 0, 0), y, x, side);
    next = put_grid(&scene, next, rk_vec(0, 0, s), x, y, side);
    next = put_grid(&scene, next, rk_vec(0, 0, 0), z, y, side);
    next = put_grid(&scene, next, rk_vec(s, 0, 0), y, z, side);
    next = put_grid(&scene, next, rk_vec(0, 0, 0), x, z, side);
    put_grid(&scene, next, rk_vec(0, s, 0), z, x, side);
    scene.mesh.materials[0].alpha = 0.5f;
    return scene;
}

static rk_accel build(const rk_scene *scene)
{
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, scene, &error), error);
    return accel;
}

static void release(rk_scene *scene, rk_accel *accel)
{
    rk_accel_free(accel);
    rk_scene_free(scene);
}

/* All crossings of one ray, by a tree built for it. */
static rk_crossing_list gather_in(const rk_scene *scene, rk_ray ray)
{
    rk_crossing_list list;
    rk_counters counters = {0};
    rk_accel accel = build(scene);
    rk_crossings_gather(&accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
    rk_accel_free(&accel);
    return list;
}

/* The number of crossings that enter, minus those that leave. */
static int balance(const rk_crossing_list *list)
{
    int entered = 0;
    for (uint32_t i = 0; i < list->count; i++)
        entered += list->crossings[i].entering ? 1 : -1;
    return entered;
}

/* --- Brute force ------------------------------------------------------------------------------ */

/* By the triangle test that the tree's suite uses, for rays that pass through no edge. */
static rk_crossing_list gather_by_brute_force(const rk_scene *scene, const rk_ray *ray,
                                              uint32_t limit)
{
    rk_crossing_list list;
    rk_transparency_start(&list, limit);
    const rk_mesh *mesh = &scene->mesh;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        rk_triangle triangle = rk_bvh_triangle_of(mesh, i);
        rk_vec3 ab = rk_sub(triangle.b, triangle.a), ac = rk_sub(triangle.c, triangle.a);
        rk_hit hit = rk_watertight_intersect(&triangle, ray);
        if (!(hit.t < ray->t_max))
            continue;
        const rk_material *material = &mesh->materials[mesh->triangle_materials[i]];
        rk_crossing crossing = {.t = hit.t,
                                .u = hit.u,
                                .v = hit.v,
                                .primitive = i,
                                .medium = mesh->triangle_materials[i],
                                .entering = rk_dot(rk_cross(ab, ac), ray->direction) < 0,
                                .alpha = material->alpha,
                                .kd = material->kd};
        rk_transparency_insert(&list, &crossing);
    }
    return list;
}

static void check_same(const rk_crossing_list *got, const rk_crossing_list *want, uint32_t ray)
{
    rk_check(got->count == want->count, "ray %u: got %u crossings, want %u", ray, got->count,
             want->count);
    for (uint32_t i = 0; i < got->count; i++) {
        const rk_crossing *g = &got->crossings[i], *w = &want->crossings[i];
        rk_check(g->primitive == w->primitive && g->entering == w->entering &&
                     g->medium == w->medium && g->alpha == w->alpha,
                 "ray %u, crossing %u: got triangle %u, want %u, or its side or material is wrong",
                 ray, i, g->primitive, w->primitive);
        /* The triangle test loses digits where the ray is nearly in the triangle's plane; with
         * these seeds the sine of their angle is at least 1e-3. */
        rk_check_close(g->t, w->t, 1e-4, "the crossing's t");
        rk_check_close(g->u, w->u, 1e-3, "barycentric");
        rk_check_close(g->v, w->v, 1e-3, "barycentric");
    }
}

static void rays_gather_the_same_crossings_as_brute_force(void **state)
{
    (void)state;
    uint32_t crossings = 0;
    for (uint32_t seed = 0; seed < 8; seed++) {
        rk_scene scene = make_soup(300, 0.6f, seed);
        scene.mesh.materials[0].kd = rk_vec(0.25f, 0.5f, 0.75f);
        rk_accel accel = build(&scene);
        for (uint32_t i = 0; i < 500; i++) {
            float t_max = i % 2 ? INFINITY : 1;
            rk_ray ray = {rk_scale(noise3(100 + seed, 2 * i), 2), noise3(100 + seed, 2 * i + 1),
                          t_max};
            uint32_t limit = i % 3 ? 256 : 4;
            rk_crossing_list got, want = gather_by_brute_force(&scene, &ray, limit);
            rk_counters counters = {0};
            rk_crossings_gather(&accel, &ray, limit, &got, &counters);
            check_same(&got, &want, i);
            crossings += got.count;
        }
        release(&scene, &accel);
    }
    rk_check(crossings > 2000, "got %u crossings in all, want many", crossings);
}

static void opaque_triangles_end_the_list(void **state)
{
    (void)state;
    rk_scene scene = make_soup(300, 0.6f, 20);
    rk_error error;
    rk_mesh *mesh = &scene.mesh;
    free(mesh->materials);
    mesh->materials = rk_allocate(2, sizeof *mesh->materials, "materials", &error);
    rk_check_ok(mesh->materials != NULL, error);
    mesh->material_count = 2;
    mesh->materials[0].alpha = 0.5f;
    mesh->materials[1].alpha = 1;
    for (uint32_t i = 0; i < 300; i += 9)
        mesh->triangle_materials[i] = 1;
    rk_accel accel = build(&scene);
    uint32_t opaque = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_ray ray = {rk_scale(noise3(21, 2 * i), 2), noise3(21, 2 * i + 1), INFINITY};
        rk_crossing_list got, want = gather_by_brute_force(&scene, &ray, 7);
        rk_counters counters = {0};
        rk_crossings_gather(&accel, &ray, 7, &got, &counters);
        check_same(&got, &want, i);
        opaque += got.count && got.crossings[got.count - 1].alpha >= 1;
    }
    rk_check(opaque > 50, "got %u rays that end at an opaque triangle, want many", opaque);
    release(&scene, &accel);
}

/* --- Panes ------------------------------------------------------------------------------------ */

static void coinciding_surfaces_are_each_crossed(void **state)
{
    (void)state;
    const float heights[] = {0.5f, 0.5f, 0.5f};
    rk_scene scene = make_panes(heights, 3);
    /* Through the middle, where each surface's diagonal runs, and beside it. */
    for (int i = 0; i < 2; i++) {
        rk_ray ray = {rk_vec(0, (float)i / 4, 0), rk_vec(0, 0, 1), 1};
        rk_crossing_list list = gather_in(&scene, ray);
        rk_check_equal(list.count, 3, "three coinciding surfaces are three crossings");
        rk_check_equal(balance(&list), 3, "each is entered from its outside");
        for (uint32_t k = 0; k < 3; k++)
            rk_check_close(list.crossings[k].t, 0.5, 0, "all at the same t");
    }
    rk_scene_free(&scene);
}

static void surfaces_a_millionth_apart_are_each_crossed(void **state)
{
    (void)state;
    const float heights[] = {0.5f, 0.500001f, 0.500002f};
    rk_scene scene = make_panes(heights, 3);
    for (uint32_t i = 0; i < 1000; i++) {
        /* Every fourth one through the diagonals. */
        float x = noise(30, i, 0) / 2, y = i % 4 ? noise(30, i, 1) / 2 : x;
        rk_ray ray = {rk_vec(x, y, 0), rk_vec(0, 0, 1), 1};
        rk_crossing_list list = gather_in(&scene, ray);
        rk_check_equal(list.count, 3, "no fixed step skips a surface, none is counted twice");
        for (uint32_t k = 0; k < 3; k++)
            rk_check_close(list.crossings[k].t, heights[k], 0x1p-24, "sorted by t");
    }
    rk_scene_free(&scene);
}

static void only_crossings_strictly_between_point_and_light_count(void **state)
{
    (void)state;
    const float heights[] = {-0.5f, 0, 0x1p-20f, 0.5f, 1 - 0x1p-20f, 1, 1.5f};
    rk_scene scene = make_panes(heights, 7);
    rk_ray ray = {rk_vec(0.125f, 0.25f, 0), rk_vec(0, 0, 1), 1};
    rk_crossing_list list = gather_in(&scene, ray);
    rk_check_equal(list.count, 3, "0 < t < 1: neither at the point nor at the light");
    for (uint32_t k = 0; k < 3; k++)
        rk_check_close(list.crossings[k].t, heights[2 + k], 0, "t is exact here");
    rk_scene_free(&scene);
}

/* The number of crossings from a point on surface `index` of the scene to a light. */
static uint32_t crossings_from(const rk_accel *accel, uint32_t triangle, float u, float v,
                               rk_vec3 light)
{
    rk_hit hit = {1, u, v, triangle};
    rk_ray seen_by = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_surface surface;
    rk_scene_surface(&surface, accel->scene, &seen_by, &hit);
    rk_vec3 start = rk_surface_spawn(&surface, rk_sub(light, surface.point));
    rk_ray ray = {start, rk_sub(light, start), 1};
    rk_crossing_list list;
    rk_counters counters = {0};
    rk_crossings_gather(accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
    return list.count;
}

static void a_ray_does_not_cross_the_surface_it_starts_on(void **state)
{
    (void)state;
    const float heights[] = {0.3f, 0.3f + 1e-6f, 0.7f};
    rk_scene scene = make_panes(heights, 3);
    rk_accel accel = build(&scene);
    for (uint32_t i = 0; i < 2000; i++) {
        float u = rk_unit_float(rk_hash(i, 0, 40, 0)) * 0.5f, v = i % 4 ? 0.25f : 0;
        rk_vec3 light = rk_vec(noise(41, i, 0), noise(41, i, 1), i % 2 ? 1 : -1);
        rk_check_equal(crossings_from(&accel, 0, u, v, light), i % 2 ? 2 : 0,
                       "from the lowest surface: the other two upwards, nothing downwards");
        rk_check_equal(crossings_from(&accel, 4, u, v, light), i % 2 ? 0 : 2,
                       "from the highest surface: nothing upwards, the other two downwards");
    }
    release(&scene, &accel);
}

static void no_ray_crosses_the_triangle_it_starts_on(void **state)
{
    (void)state;
    const float sizes[] = {1, 1e-3f, 1e3f}, offsets[] = {0, 1, 1e3f};
    for (uint32_t i = 0; i < 20000; i++) {
        rk_scene scene = test_scene_make(1);
        rk_vec3 centre = rk_scale(noise3(50, 5 * i), offsets[i / 3 % 3]);
        float size = sizes[i % 3];
        test_scene_triangle(&scene, 0, rk_madd(centre, noise3(50, 5 * i + 1), size),
                            rk_madd(centre, noise3(50, 5 * i + 2), size),
                            rk_madd(centre, noise3(50, 5 * i + 3), size));
        rk_accel accel = build(&scene);
        float u = rk_unit_float(rk_hash(i, 1, 51, 0)), v = rk_unit_float(rk_hash(i, 2, 51, 0));
        if (u + v > 1)
            u = 1 - u, v = 1 - v;
        rk_vec3 light = rk_madd(centre, noise3(50, 5 * i + 4), 3 * size);
        rk_check_equal(crossings_from(&accel, 0, u, v, light), 0, "it starts on the triangle");
        release(&scene, &accel);
    }
}

/* --- Blocks ----------------------------------------------------------------------------------- */

static void a_closed_block_is_entered_and_left(void **state)
{
    (void)state;
    rk_scene scene = make_block(2);
    rk_ray ray = {rk_vec(0.3f, 0.6f, -1), rk_vec(0, 0, 4), 1};
    rk_crossing_list list = gather_in(&scene, ray);
    rk_check_equal(list.count, 2, "front and back");
    rk_check(list.crossings[0].entering && !list.crossings[1].entering,
             "the front is entered, the back is left: faces are counter-clockwise from outside");
    rk_check_close(list.crossings[0].t, 0.25, 0, "the front");
    rk_check_close(list.crossings[1].t, 0.75, 0, "the back");
    rk_scene_free(&scene);
}

static void a_camera_inside_glass_crosses_its_far_side(void **state)
{
    (void)state;
    rk_scene scene = make_block(3);
    rk_accel accel = build(&scene);
    for (uint32_t i = 0; i < 1000; i++) {
        rk_ray ray = {rk_vec(1.5f, 1.25f, 1.75f), noise3(60, i), INFINITY};
        rk_crossing_list list;
        rk_counters counters = {0};
        rk_crossings_gather(&accel, &ray, 7, &list, &counters);
        rk_check_equal(list.count, 1, "from inside, a box is left once");
        rk_check(!list.crossings[0].entering, "it is left, not entered");
    }
    release(&scene, &accel);
}

/* Whether the point is inside, on the surface of, or outside a block of this side. */
static int place_in_block(const int point[3], int side)
{
    int place = 1;
    for (int k = 0; k < 3; k++) {
        if (point[k] < 0 || point[k] > side)
            return -1;
        if (point[k] == 0 || point[k] == side)
            place = 0;
    }
    return place;
}

/* Rays from whole coordinates along whole directions: through corners, along edges, within faces.
 * Rays do not start in faces, where the block may begin on either side. */
static void edges_and_corners_are_crossed_once(void **state)
{
    (void)state;
    const int side = 3;
    rk_scene scene = make_block((uint32_t)side);
    rk_accel accel = build(&scene);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 100000; i++) {
        int from[3], along[3];
        for (uint32_t k = 0; k < 3; k++) {
            from[k] = (int)(rk_hash(i, k, 70, 0) % 10) - 3;
            along[k] = (int)(rk_hash(i, k, 71, 0) % 7) - 3;
        }
        int place = place_in_block(from, side);
        if (place == 0 || (along[0] == 0 && along[1] == 0 && along[2] == 0))
            continue;
        rk_ray ray = {rk_vec((float)from[0], (float)from[1], (float)from[2]),
                      rk_vec((float)along[0], (float)along[1], (float)along[2]), INFINITY};
        rk_crossing_list list;
        rk_counters counters = {0};
        rk_crossings_gather(&accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
        char name[96];
        snprintf(name, sizeof name, "from (%d, %d, %d) along (%d, %d, %d)", from[0], from[1],
                 from[2], along[0], along[1], along[2]);
        if (place > 0)
            rk_check_equal(list.count, 1, name);
        else
            rk_check(list.count == 0 || list.count == 2,
                     "%s: got %u crossings, want the front and the back, or none where the ray "
                     "only touches the block",
                     name, list.count);
        rk_check_equal(balance(&list), place > 0 ? -1 : 0, name);
        hits += list.count;
    }
    rk_check(hits > 10000, "got %u crossings in all, want many", hits);
    release(&scene, &accel);
}

/* Corners to the left and right of a slanted ray, so that the edge between them misses it by less
 * than products of doubles resolve: x has 34 bits and y 24, as a unit of z moves x by 2^-10. */
static rk_vec3 corner_at(int64_t x, int64_t y)
{
    int64_t whole = (x + 1023 + 1024) >> 10;
    return rk_vec((float)whole, (float)y, (float)(whole * 1024 - x));
}

static void a_ray_near_an_edge_crosses_one_of_its_two_triangles(void **state)
{
    (void)state;
    /* x_a y_b - x_b y_a is 1: these are Bezout's numbers, and multiples of y added to both x. */
    const int64_t y_a = 16777213, y_b = 12345679;
    int64_t x_a = 1, x_b;
    while ((x_a * y_b - 1) % y_a != 0)
        x_a++;
    x_b = (x_a * y_b - 1) / y_a;
    for (int sign = -1; sign <= 1; sign += 2) {
        /* The reflected corner b puts the ray between the two; it passes a-b on the left or right.
         * */
        int64_t ax = sign * x_a + 997 * y_a, bx = sign * x_b + 997 * y_b;
        rk_vec3 a = corner_at(ax, y_a), b = corner_at(-bx, -y_b);
        rk_scene scene = test_scene_make(2);
        test_scene_triangle(&scene, 0, a, b, rk_vec(-1e6f, 1e6f, 1));
        test_scene_triangle(&scene, 1, b, a, rk_vec(1e6f, -1e6f, 1));
        scene.mesh.materials[0].alpha = 0.5f;
        rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0x1p-10f, 0, 1), INFINITY};
        rk_crossing_list list = gather_in(&scene, ray);
        rk_check_equal(list.count, 1, "exactly one of the two triangles at the edge");
        rk_check_equal(list.crossings[0].primitive, sign > 0 ? 0 : 1,
                       "the one on the ray's side of the edge, in exact arithmetic");
        rk_scene_free(&scene);
    }
}

/* A ray into a face, through edges and corners inside it, does cross the block. */
static void rays_into_a_face_cross_it_exactly_once(void **state)
{
    (void)state;
    const int side = 4;
    rk_scene scene = make_block((uint32_t)side);
    rk_accel accel = build(&scene);
    for (int x = 1; x < 2 * side; x++)
        for (int y = 1; y < 2 * side; y++)
            for (int slant = -2; slant <= 2; slant++)
                for (int axis = 0; axis < 3; axis++) {
                    rk_vec3 target = rk_vec((float)x / 2, (float)y / 2, 0);
                    rk_vec3 along = rk_vec((float)slant, (float)(slant * slant) / 2, 1);
                    if (axis == 1)
                        target = rk_vec(target.z, target.x, target.y),
                        along = rk_vec(along.z, along.x, along.y);
                    if (axis == 2)
                        target = rk_vec(target.y, target.z, target.x),
                        along = rk_vec(along.y, along.z, along.x);
                    rk_ray ray = {rk_sub(target, along), along, INFINITY};
                    rk_crossing_list list;
                    rk_counters counters = {0};
                    rk_crossings_gather(&accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
                    rk_check(list.count == 2 && list.crossings[0].entering &&
                                 list.crossings[0].t == 1,
                             "at (%g, %g) of the face across axis %d, slant %d: got %u crossings, "
                             "want one at t = 1, where it enters the face, and one behind it",
                             x / 2.0, y / 2.0, 2 - axis, slant, list.count);
                }
    release(&scene, &accel);
}

static rk_vec3 random_target(const rk_mesh *mesh, uint32_t i)
{
    const uint32_t *corner = mesh->triangles[rk_hash(i, 0, 80, 0) % mesh->triangle_count];
    rk_vec3 a = mesh->positions[corner[0]], b = mesh->positions[corner[1]];
    /* A corner, or a point on an edge, as close as floats get to it. */
    return i % 2 ? a : rk_mix(a, b, rk_unit_float(rk_hash(i, 1, 80, 0)));
}

static void a_closed_mesh_of_any_shape_is_left_as_often_as_entered(void **state)
{
    (void)state;
    const char *const names[] = {"sphere:320", "statue:1000"};
    for (int s = 0; s < 2; s++) {
        rk_scene scene = test_scene_builtin(names[s]);
        for (uint32_t i = 0; i < scene.mesh.material_count; i++)
            scene.mesh.materials[i].alpha = 0.5f;
        rk_accel accel = build(&scene);
        for (uint32_t i = 0; i < 20000; i++) {
            rk_vec3 from = rk_scale(rk_normalize(noise3(81, i)), 4);
            rk_ray ray = {from, rk_sub(random_target(&scene.mesh, i), from), INFINITY};
            rk_crossing_list list;
            rk_counters counters = {0};
            rk_crossings_gather(&accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
            rk_check(balance(&list) == 0,
                     "%s, ray %u at a corner or an edge: entered %d more "
                     "times than left",
                     names[s], i, balance(&list));
        }
        release(&scene, &accel);
    }
}

/* --- Spheres ---------------------------------------------------------------------------------- */

static rk_scene make_ball(void)
{
    rk_scene scene = test_scene_make(1); /* a triangle without area, which no ray crosses */
    scene.sphere_count = 1;
    scene.spheres[0] = (rk_sphere){rk_vec(0, 0, 4), 1};
    scene.sphere_materials[0] =
        (rk_material){.alpha = 0.25f, .kd = rk_vec(1, 0.5f, 0), .absorption = rk_vec(0, 1, 2)};
    return scene;
}

static void a_sphere_is_entered_and_left(void **state)
{
    (void)state;
    rk_scene scene = make_ball();
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 8), 1};
    rk_crossing_list list = gather_in(&scene, ray);
    rk_check_equal(list.count, 2, "both intersections");
    rk_check_close(list.crossings[0].t, 0.375, 0, "where it is entered");
    rk_check_close(list.crossings[1].t, 0.625, 0, "where it is left");
    rk_check(list.crossings[0].entering && !list.crossings[1].entering,
             "first it enters, then it leaves");
    rk_check_equal(list.crossings[0].primitive, 1, "spheres are numbered after the triangles");
    rk_check(list.crossings[0].medium == list.crossings[1].medium && list.crossings[0].medium > 0,
             "a medium that no material of the mesh has");
    rk_check_close(list.crossings[0].alpha, 0.25, 0, "its material");
    rk_check_close(list.crossings[0].absorption.z, 2, 0, "its material");
    ray.origin = rk_vec(0, 0, 4);
    list = gather_in(&scene, ray);
    rk_check_equal(list.count, 1, "from inside it is only left");
    rk_check(!list.crossings[0].entering, "from inside it is left");
    rk_scene_free(&scene);
}

static void a_ray_does_not_cross_the_sphere_it_starts_on(void **state)
{
    (void)state;
    rk_scene scene = make_ball();
    rk_accel accel = build(&scene);
    for (uint32_t i = 0; i < 5000; i++) {
        rk_vec3 outward = rk_normalize(noise3(90, i));
        rk_vec3 target = rk_madd(rk_vec(0, 0, 4), outward, 1);
        rk_ray seen_by = {rk_madd(target, outward, 2), rk_scale(outward, -2), INFINITY};
        rk_hit hit = {1, 0, 0, 1};
        rk_surface surface;
        rk_scene_surface(&surface, &scene, &seen_by, &hit);
        bool away = i % 2;
        rk_vec3 light = rk_madd(target, outward, away ? 2 : -6);
        rk_vec3 start = rk_surface_spawn(&surface, rk_sub(light, surface.point));
        rk_ray ray = {start, rk_sub(light, start), 1};
        rk_crossing_list list;
        rk_counters counters = {0};
        rk_crossings_gather(&accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
        rk_check_equal(list.count, away ? 0 : 1,
                       "away from the ball nothing, through it only the far side");
    }
    release(&scene, &accel);
}

/* --- Transmittance ---------------------------------------------------------------------------- */

static rk_vec3 transmit_in(const rk_scene *scene, rk_ray ray, rk_glass_model model,
                           rk_counters *counters)
{
    rk_accel accel = build(scene);
    rk_vec3 transmittance = rk_crossings_transmit(&accel, &ray, model, counters);
    rk_accel_free(&accel);
    return transmittance;
}

static void absorption_is_per_world_unit_of_glass(void **state)
{
    (void)state;
    rk_scene scene = make_block(2);
    scene.mesh.materials[0].absorption = rk_vec(1, 0.5f, 0);
    rk_counters counters = {0};
    rk_ray ray = {rk_vec(1.25f, 0.75f, -3), rk_vec(0, 0, 8), 1};
    rk_vec3 transmittance = transmit_in(&scene, ray, RK_GLASS_BEER_LAMBERT, &counters);
    rk_check_close(transmittance.x, exp(-2), 4 * 0x1p-24,
                   "exp(-sigma 2), for any length of the direction");
    rk_check_close(transmittance.y, exp(-1), 4 * 0x1p-24,
                   "exp(-sigma 2), for any length of the direction");
    rk_check_close(transmittance.z, 1, 0, "clear");
    rk_scene_free(&scene);
}

static void an_opaque_surface_ends_the_search(void **state)
{
    (void)state;
    float heights[64];
    for (uint32_t i = 0; i < 64; i++)
        heights[i] = (float)(i + 1) / 65;
    rk_scene scene = make_panes(heights, 64);
    rk_ray ray = {rk_vec(0.125f, 0.25f, 0), rk_vec(0, 0, 1), 1};
    rk_counters clear = {0}, occluded = {0};
    rk_vec3 transmittance = transmit_in(&scene, ray, RK_GLASS_ORDERED, &clear);
    rk_check(transmittance.x > 0, "got no light through 64 clear surfaces, want some");
    rk_check_equal(clear.triangle_tests, 128, "all surfaces are tested, two triangles each");
    scene.mesh.materials[0].alpha = 1;
    transmittance = transmit_in(&scene, ray, RK_GLASS_ORDERED, &occluded);
    rk_check_close(transmittance.x, 0, 0, "opaque surfaces transmit nothing");
    rk_check(
        occluded.triangle_tests >= 1 && occluded.triangle_tests <= 4,
        "got %llu triangle tests, want one leaf at most: the first opaque surface ends the search",
        (unsigned long long)occluded.triangle_tests);
    rk_scene_free(&scene);
}

static void a_view_ray_gathers_no_more_crossings_than_its_limit(void **state)
{
    (void)state;
    float heights[64];
    for (uint32_t i = 0; i < 64; i++)
        heights[i] = (float)(i + 1) / 65;
    rk_scene scene = make_panes(heights, 64);
    rk_accel accel = build(&scene);
    for (uint32_t i = 0; i < 14; i++) {
        uint32_t limit = 1 + i / 2;
        bool back = i % 2;
        rk_ray ray = {rk_vec(0.125f, 0.25f, back), rk_vec(0, 0, back ? -1 : 1), INFINITY};
        rk_crossing_list list;
        rk_counters counters = {0};
        rk_crossings_gather(&accel, &ray, limit, &list, &counters);
        rk_check_equal(list.count, limit, "the nearest surfaces up to the limit");
        rk_check_close(list.crossings[limit - 1].t, heights[limit - 1], 0x1p-23,
                       "the nearest, from either side");
        /* 128 triangles are 32 leaves of two surfaces each. */
        rk_check(counters.triangle_tests <= 4 * ((limit + 1) / 2 + 1),
                 "limit %u: got %llu triangle tests, want those of the leaves with the nearest "
                 "surfaces and of one more: visit the nearer child first, and stop at a full list",
                 limit, (unsigned long long)counters.triangle_tests);
    }
    release(&scene, &accel);
}

static void too_many_crossings_occlude_the_light(void **state)
{
    (void)state;
    static float heights[RK_CROSSINGS_MAX];
    for (uint32_t i = 0; i < RK_CROSSINGS_MAX; i++)
        heights[i] = (float)(i + 1) / (RK_CROSSINGS_MAX + 1);
    rk_ray ray = {rk_vec(0.125f, 0.25f, 0), rk_vec(0, 0, 1), 1};
    rk_counters counters = {0};
    for (int fewer = 1; fewer >= 0; fewer--) {
        rk_scene scene = make_panes(heights, (uint32_t)(RK_CROSSINGS_MAX - fewer));
        scene.mesh.materials[0].alpha = 0;
        rk_vec3 transmittance = transmit_in(&scene, ray, RK_GLASS_ORDERED, &counters);
        rk_check_close(transmittance.x, fewer, 0, "a full list may be incomplete");
        rk_scene_free(&scene);
    }
}

static void rays_of_nan_and_of_no_direction_cross_nothing(void **state)
{
    (void)state;
    rk_scene scene = make_block(2);
    const rk_vec3 directions[] = {{NAN, 0, 1}, {NAN, NAN, NAN}, {0, 0, 0}};
    for (size_t i = 0; i < sizeof directions / sizeof *directions; i++) {
        rk_ray ray = {rk_vec(1, 1, -1), directions[i], INFINITY};
        rk_check_equal(gather_in(&scene, ray).count, 0, "no direction, no crossings");
    }
    rk_ray ray = {rk_vec(1, 1, -1), rk_vec(0, 0, 1), INFINITY};
    rk_check_equal(gather_in(&scene, ray).count, 2, "a ray with a direction does cross the block");
    rk_scene_free(&scene);
}

static void gathering_allocates_nothing(void **state)
{
    (void)state;
    rk_scene scene = make_soup(300, 0.6f, 3);
    rk_accel accel = build(&scene);
    rk_counters counters = {0};
    size_t before = rk_allocations;
    for (uint32_t i = 0; i < 100; i++) {
        rk_crossing_list list;
        rk_ray ray = {noise3(95, 2 * i), noise3(95, 2 * i + 1), 1};
        rk_crossings_gather(&accel, &ray, 7, &list, &counters);
        rk_crossings_transmit(&accel, &ray, RK_GLASS_BEER_LAMBERT, &counters);
    }
    rk_check_equal(rk_allocations - before, 0, "keep all arrays on the stack");
    release(&scene, &accel);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_closed_block_is_entered_and_left),
    cmocka_unit_test(a_camera_inside_glass_crosses_its_far_side),
    cmocka_unit_test(rays_gather_the_same_crossings_as_brute_force),
    cmocka_unit_test(opaque_triangles_end_the_list),
    cmocka_unit_test(coinciding_surfaces_are_each_crossed),
    cmocka_unit_test(surfaces_a_millionth_apart_are_each_crossed),
    cmocka_unit_test(only_crossings_strictly_between_point_and_light_count),
    cmocka_unit_test(a_ray_does_not_cross_the_surface_it_starts_on),
    cmocka_unit_test(no_ray_crosses_the_triangle_it_starts_on),
    cmocka_unit_test(edges_and_corners_are_crossed_once),
    cmocka_unit_test(a_ray_near_an_edge_crosses_one_of_its_two_triangles),
    cmocka_unit_test(rays_into_a_face_cross_it_exactly_once),
    cmocka_unit_test(a_closed_mesh_of_any_shape_is_left_as_often_as_entered),
    cmocka_unit_test(a_sphere_is_entered_and_left),
    cmocka_unit_test(a_ray_does_not_cross_the_sphere_it_starts_on),
    cmocka_unit_test(absorption_is_per_world_unit_of_glass),
    cmocka_unit_test(an_opaque_surface_ends_the_search),
    cmocka_unit_test(a_view_ray_gathers_no_more_crossings_than_its_limit),
    cmocka_unit_test(too_many_crossings_occlude_the_light),
    cmocka_unit_test(rays_of_nan_and_of_no_direction_cross_nothing),
    cmocka_unit_test(gathering_allocates_nothing),
};

RK_SUITE("crossings", tests)
