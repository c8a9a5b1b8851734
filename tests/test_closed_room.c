/* Rays spawned on the walls of closed rooms: none leaves through an edge or a corner, none enters
 * from outside, at any scale and at any distance from the origin, where floats are coarse. */
#include "noise.h"
#include "test.h"

#include "base/interpolate.h"
#include "base/random.h"
#include "features/watertight.h"
#include "scene/bvh_build.h"
#include "scene/surface.h"

enum { corners_max = 8, walls_max = 12, rays_per_room = 120, spawned_per_ray = 8 };

/* --- Rooms ------------------------------------------------------------------------------------ */

/* Of triangles whose corners are counter-clockwise seen from outside. */
typedef struct shape {
    const char *name;
    uint32_t corners, walls;
    rk_vec3 corner[corners_max];
    uint32_t wall[walls_max][3];
    bool is_tilted;
} shape;

#define CUBE                                                                                       \
    8, 12, {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},                                    \
            {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}},                                    \
    {                                                                                              \
        {0, 3, 1}, {0, 2, 3}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 7, 3}, {2, 6, 7},    \
            {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},                                            \
    }

/* The third room's walls meet at 45 and 90 degrees. */
static const shape shapes[] = {
    {"a cube", CUBE, false},
    {"a tilted cube", CUBE, true},
    {"a wedge",
     6,
     8,
     {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}},
     {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {0, 3, 5}, {0, 5, 2}, {1, 2, 5}, {1, 5, 4}},
     false},
};

typedef struct room {
    const shape *shape;
    float scale, away; /* of half an edge; of the centre from the origin, in scales */
    rk_vec3 centre;
    rk_mesh mesh;
    rk_triangle walls[walls_max];
} room;

/* Turned by 1 about all three axes together: no wall is parallel to an axis. */
static rk_vec3 tilted(rk_vec3 a)
{
    const float c = cosf(1), s = sinf(1), k = 0.57735027f;
    rk_vec3 axis = rk_vec(k, k, k);
    rk_vec3 turned = rk_madd(rk_scale(a, c), rk_cross(axis, a), s);
    return rk_madd(turned, axis, (1 - c) * rk_dot(axis, a));
}

static room room_of(const shape *walls_of, float scale, float away, noise *n)
{
    room r = {walls_of, scale, away, rk_scale(in_cube(n), scale * away), .mesh = {0}};
    rk_error error;
    rk_check_ok(rk_mesh_init(&r.mesh, walls_of->corners, walls_of->walls, 1, 0, &error), error);
    for (uint32_t i = 0; i < walls_of->corners; i++)
        r.mesh.positions[i] =
            rk_madd(r.centre,
                    walls_of->is_tilted ? tilted(walls_of->corner[i]) : walls_of->corner[i], scale);
    memcpy(r.mesh.triangles, walls_of->wall, walls_of->walls * sizeof *walls_of->wall);
    for (uint32_t i = 0; i < walls_of->walls; i++)
        r.walls[i] = rk_bvh_triangle_of(&r.mesh, i);
    return r;
}

/* --- Rays ------------------------------------------------------------------------------------- */

/* A point of a wall: every third on an edge, every ninth in a corner. */
static rk_vec3 target_in(const room *r, noise *n, int i)
{
    const rk_triangle *t = &r->walls[rk_hash(n->key, n->drawn++, 5, 4) % r->shape->walls];
    float u = between(n, 0, 1), v = between(n, 0, 1 - u);
    if (i % 3 == 0)
        v = i % 9 == 0 ? 0 : 1 - u, u = i % 9 == 0 ? 0 : u;
    return rk_interpolate3(t->a, t->b, t->c, rk_vec(1 - u - v, u, v));
}

static rk_hit closest(const room *r, const rk_ray *ray)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    rk_triangles_closest(r->walls, r->shape->walls, ray, &hit);
    return hit;
}

/* The surface that a ray from inside hits; false if floats are so coarse that it misses. */
static bool look(const room *r, noise *n, int i, rk_surface *surface)
{
    rk_vec3 inside = rk_madd(r->centre, rk_vec(-0.4f, -0.4f, between(n, -0.5f, 0.5f)), r->scale);
    rk_ray ray = {inside, rk_sub(target_in(r, n, i), inside), INFINITY};
    rk_hit hit = closest(r, &ray);
    if (hit.triangle != RK_MISS)
        rk_surface_at(surface, &r->mesh, &ray, &hit);
    return hit.triangle != RK_MISS;
}

/* Into the room, every second one close to the wall. The corners decide which side that is: close
 * to the wall the rounded normal may be wrong. */
static rk_vec3 direction_into_room(noise *n, const rk_surface *surface, int i)
{
    const rk_triangle_plane wall = rk_triangle_plane_of(&surface->triangle);
    rk_vec3 any = in_cube(n), normal = surface->face_normal;
    if (i % 2)
        any = rk_madd(rk_cross(normal, any), normal, between(n, 0, 1e-3f));
    double heading = rk_triangle_plane_heading(&wall, any);
    return heading == 0 ? normal : heading > 0 ? rk_negate(any) : any;
}

typedef struct tally {
    uint32_t spawned, escaped, again, entered;
} tally;

static void spawn_from(const room *r, noise *n, const rk_surface *surface, tally *t)
{
    for (int k = 0; k < spawned_per_ray; k++, t->spawned++) {
        rk_vec3 inward = direction_into_room(n, surface, k), outward = rk_negate(inward);
        rk_ray in = {rk_surface_spawn(surface, inward), inward, INFINITY};
        rk_ray out = {rk_surface_spawn(surface, outward), outward, INFINITY};
        rk_hit hit = closest(r, &in);
        t->escaped += hit.triangle == RK_MISS;
        t->again += hit.triangle == surface->triangle.index;
        t->entered += closest(r, &out).triangle != RK_MISS;
    }
}

static tally spawn_in(const shape *walls_of, float scale, float away)
{
    noise n = {(uint32_t)(walls_of - shapes), (uint32_t)(away + 100 * fabsf(log10f(scale)))};
    tally t = {0};
    room r = room_of(walls_of, scale, away, &n);
    for (int i = 0; i < rays_per_room; i++) {
        rk_surface surface;
        if (look(&r, &n, i, &surface))
            spawn_from(&r, &n, &surface, &t);
    }
    rk_mesh_free(&r.mesh);
    return t;
}

/* --- Claims ----------------------------------------------------------------------------------- */

static const float scales[] = {1e-15f, 1e-9f, 1e-3f, 1, 1e3f, 1e9f, 1e15f};
static const float distances[] = {0, 1, 10, 100, 1e3f, 1e4f, 1e5f, 1e6f};

static void no_spawned_ray_leaves_a_closed_room(void **state)
{
    (void)state;
    for (size_t p = 0; p < sizeof shapes / sizeof *shapes; p++)
        for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
            for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
                tally t = spawn_in(&shapes[p], scales[s], distances[d]);
                rk_check(t.spawned > 0, "%s was missed from inside", shapes[p].name);
                rk_check(t.escaped == 0,
                         "%s of size %g, %g sizes from the origin: %u of %u rays into the room "
                         "left it: they start beyond the neighbour of their wall",
                         shapes[p].name, (double)scales[s], (double)distances[d], t.escaped,
                         t.spawned);
                rk_check(t.again == 0, "%u of %u rays hit their own wall again", t.again,
                         t.spawned);
            }
}

/* The planes of this cube's walls are exact wherever it is, so it is convex: from outside, a ray
 * away from a wall meets nothing. */
static void no_ray_away_from_a_cube_enters_it(void **state)
{
    (void)state;
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
        for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
            tally t = spawn_in(&shapes[0], scales[s], distances[d]);
            rk_check(t.spawned > 0 && t.entered == 0, "%u of %u rays entered", t.entered,
                     t.spawned);
        }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(no_spawned_ray_leaves_a_closed_room),
    cmocka_unit_test(no_ray_away_from_a_cube_enters_it),
};

RK_SUITE("closed_room", tests)
