/* Draws the figures and measures the tables of watertight: a closed ball seen from inside, with a
 * dot wherever a ray that is aimed at an edge or a corner leaves it. */
#include "driver/driver_main.h"

#include "features/watertight.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene.\n"
    "--debug leaks draws a closed ball from inside, and a white dot where "
    "a ray at an edge or a corner leaves it; --debug classic the same for "
    "Moeller and Trumbore's test in float.";

enum { rows = 10, triangles = 8 * rows * rows, parts_of_edge = 64 };

typedef struct ball {
    rk_vec3 centre;
    rk_triangle triangles[triangles];
} ball;

typedef struct choices {
    float scale, magnify;
} choices;

static const rk_option options[] = {
    {"ball-radius", RK_FIELD(choices, scale), "R",
     "of the ball of the debug views, from 1e-15 to 1e15", 1e-15, 1e15, 1},
    {"magnify", RK_FIELD(choices, magnify), "N",
     "the debug views N times as large, around the classic test's leak that is nearest to the "
     "middle; above 1, smaller dots show the rays that do not leave",
     1, 64, 1},
    {0},
};

/* --- The ball --------------------------------------------------------------------------------- */

/* An octahedron whose faces are split into rows of triangles, pushed outward. Each corner is
 * computed from whole numbers, so neighbours have the same to the bit. */
static rk_vec3 corner_at(const ball *b, float radius, int x, int y, int z)
{
    rk_vec3 at = rk_vec((float)x, (float)y, (float)z);
    return rk_madd(b->centre, rk_normalize(at), radius);
}

static void make_ball(ball *b, float radius)
{
    uint32_t count = 0;
    b->centre = rk_scale(rk_vec(0.3f, -0.7f, 0.2f), radius);
    for (int octant = 0; octant < 8; octant++) {
        int x = octant & 1 ? -1 : 1, y = octant & 2 ? -1 : 1, z = octant & 4 ? -1 : 1;
        for (int i = 0; i < rows; i++)
            for (int j = 0; i + j < rows; j++)
                for (int upper = 0; upper < 2 && i + j + upper < rows; upper++) {
                    int at[3][2] = {{i + upper, j + upper}, {i + 1, j}, {i, j + 1}};
                    rk_vec3 c[3];
                    for (int k = 0; k < 3; k++)
                        c[k] = corner_at(b, radius, x * at[k][0], y * at[k][1],
                                         z * (rows - at[k][0] - at[k][1]));
                    b->triangles[count] = (rk_triangle){c[0], c[1], c[2], count};
                    count++;
                }
    }
}

/* --- Rays ------------------------------------------------------------------------------------- */

typedef uint32_t first_hit_test(const ball *b, const rk_ray *ray);

static uint32_t watertight_hit(const ball *b, const rk_ray *ray)
{
    return rk_triangles_first_hit(b->triangles, triangles, ray);
}

/* As in their paper, but for an epsilon, with edges in float. */
static bool classic_intersect(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_vec3 ab = rk_sub(triangle->b, triangle->a), ac = rk_sub(triangle->c, triangle->a);
    rk_vec3 s = rk_sub(ray->origin, triangle->a), p = rk_cross(ray->direction, ac);
    rk_vec3 q = rk_cross(s, ab);
    float det = rk_dot(ab, p), u = rk_dot(s, p) / det, v = rk_dot(ray->direction, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && rk_dot(ac, q) / det > 0;
}

static uint32_t classic_hit(const ball *b, const rk_ray *ray)
{
    for (uint32_t i = 0; i < triangles; i++)
        if (classic_intersect(&b->triangles[i], ray))
            return i;
    return triangles;
}

/* Where in the ball the rays start. */
static rk_vec3 eye_of(const ball *b, float radius)
{
    return rk_madd(b->centre, rk_vec(0.13f, 0.21f, -0.34f), radius);
}

/* --- Aiming ----------------------------------------------------------------------------------- */

typedef void ray_visitor(void *context, const rk_ray *ray, bool leaves);
typedef bool ray_choice(const void *context, rk_vec3 direction);

/* Aims at 64 points of each edge, its ends among them. Only rays that are `wanted` are traced. */
static void aim_at_edges(const ball *b, rk_vec3 eye, first_hit_test *test, ray_choice *wanted,
                         ray_visitor *visit, void *context)
{
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        const rk_vec3 *corner = &b->triangles[i / 3].a;
        rk_vec3 from = corner[i % 3], to = corner[(i + 1) % 3];
        for (uint32_t k = 0; k < parts_of_edge; k++) {
            rk_vec3 at = rk_mix(from, to, (float)k / parts_of_edge);
            rk_ray ray = {eye, rk_sub(at, eye), INFINITY};
            if (wanted(context, ray.direction))
                visit(context, &ray, test(b, &ray) == triangles);
        }
    }
}

/* --- Drawing ---------------------------------------------------------------------------------- */

/* A part of the plane at distance 1, and the picture of it. */
typedef struct view {
    rk_image *image;
    rk_vec2 middle;
    float pixels;          /* per unit */
    bool magnified, leaks; /* which rays are drawn: those that leave, or the others */
} view;

static rk_vec2 on_plane(rk_vec3 direction)
{
    return (rk_vec2){direction.x / direction.z, direction.y / direction.z};
}

static rk_vec3 direction_at(const view *v, uint32_t x, uint32_t y)
{
    float right = (float)x + 0.5f - 0.5f * (float)v->image->width;
    float up = 0.5f * (float)v->image->height - (float)y - 0.5f;
    return rk_vec(v->middle.x + right / v->pixels, v->middle.y + up / v->pixels, 1);
}

static void draw_dot(const view *v, rk_vec2 at, int radius, rk_vec3 colour)
{
    float x = floorf(0.5f * (float)v->image->width + v->pixels * (at.x - v->middle.x));
    float y = floorf(0.5f * (float)v->image->height - v->pixels * (at.y - v->middle.y));
    for (int dy = -radius; dy <= radius; dy++)
        for (int dx = -radius; dx <= radius; dx++) {
            float px = x + (float)dx, py = y + (float)dy;
            bool inside =
                px >= 0 && py >= 0 && px < (float)v->image->width && py < (float)v->image->height;
            if (inside && dx * dx + dy * dy <= radius * radius + 1)
                *rk_image_at(v->image, (uint32_t)px, (uint32_t)py) = colour;
        }
}

/* Most rays of the ball lie outside the picture, and are not traced for it. */
static bool is_seen(const void *context, rk_vec3 direction)
{
    const view *v = context;
    const rk_vec2 at = on_plane(direction);
    const float margin = 8, /* more than a dot's radius */
        x = 0.5f * (float)v->image->width + margin, y = 0.5f * (float)v->image->height + margin;
    return direction.z > 0 && fabsf(v->pixels * (at.x - v->middle.x)) < x &&
           fabsf(v->pixels * (at.y - v->middle.y)) < y;
}

static void draw_ray(void *context, const rk_ray *ray, bool leaves)
{
    const view *v = context;
    if (leaves != v->leaks)
        return;
    if (leaves)
        draw_dot(v, on_plane(ray->direction), v->magnified ? 4 : 2, rk_vec(1, 1, 1));
    else
        draw_dot(v, on_plane(ray->direction), 1, rk_vec(0.02f, 0.02f, 0.03f));
}

/* Each triangle in a tone of its own. */
static void draw_triangles(const view *v, const ball *b, rk_vec3 eye)
{
    for (uint32_t y = 0; y < v->image->height; y++)
        for (uint32_t x = 0; x < v->image->width; x++) {
            rk_ray ray = {eye, direction_at(v, x, y), INFINITY};
            uint32_t hit = watertight_hit(b, &ray);
            float tone = hit < triangles ? 0.03f + 0.02f * (float)(hit * 7 % 5) : 1;
            *rk_image_at(v->image, x, y) = rk_vec(tone, 1.3f * tone, 1.8f * tone);
        }
}

static bool is_nearer(const void *context, rk_vec3 direction)
{
    const rk_vec2 *nearest = context, at = on_plane(direction);
    return direction.z > 0 && hypotf(at.x, at.y) < hypotf(nearest->x, nearest->y);
}

/* The leak nearest to the middle, for both tests: their pictures show the same place. */
static void keep_leak(void *context, const rk_ray *ray, bool leaves)
{
    rk_vec2 *nearest = context;
    if (leaves)
        *nearest = on_plane(ray->direction);
}

static bool draw_with(rk_driver *driver, first_hit_test *test)
{
    const choices *c = driver->choices;
    static ball b;
    make_ball(&b, c->scale);
    rk_vec3 eye = eye_of(&b, c->scale);
    view v = {.image = &driver->image,
              /* Half a picture is as wide as the distance to it. */
              .pixels = 0.5f * (float)driver->image.width * c->magnify,
              .magnified = c->magnify > 1};
    if (v.magnified) {
        v.middle = (rk_vec2){1, 1};
        aim_at_edges(&b, eye, classic_hit, is_nearer, keep_leak, &v.middle);
    }
    draw_triangles(&v, &b, eye);
    if (v.magnified)
        aim_at_edges(&b, eye, test, is_seen, draw_ray, &v);
    v.leaks = true;
    snprintf(driver->scene.name, sizeof driver->scene.name, "ball"); /* for names and captions */
    aim_at_edges(&b, eye, test, is_seen, draw_ray, &v);
    return true;
}

static bool draw_leaks(rk_driver *driver, rk_error *error)
{
    (void)error;
    return draw_with(driver, watertight_hit);
}

static bool draw_classic(rk_driver *driver, rk_error *error)
{
    (void)error;
    return draw_with(driver, classic_hit);
}

/* --- The table -------------------------------------------------------------------------------- */

typedef struct leak_count {
    uint32_t rays, leaks;
} leak_count;

static bool is_any(const void *context, rk_vec3 direction)
{
    (void)context;
    (void)direction;
    return true;
}

static void count_ray(void *context, const rk_ray *ray, bool leaves)
{
    (void)ray;
    leak_count *count = context;
    count->rays++;
    count->leaks += leaves;
}

static leak_count leaks_of(const ball *b, rk_vec3 eye, first_hit_test *test)
{
    leak_count count = {0, 0};
    aim_at_edges(b, eye, test, is_any, count_ray, &count);
    return count;
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    static ball b;
    make_ball(&b, c->scale);
    leak_count classic = leaks_of(&b, eye_of(&b, c->scale), classic_hit);
    leak_count now = leaks_of(&b, eye_of(&b, c->scale), watertight_hit);
    return rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_count_rows(driver, error) &&
           rk_driver_row(driver, "aimed", "rays", rk_timing_once(now.rays), error) &&
           rk_driver_row(driver, "leaks_classic", "rays", rk_timing_once(classic.leaks), error) &&
           rk_driver_row(driver, "leaks_watertight", "rays", rk_timing_once(now.leaks), error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    if (!driver->debug || c->magnify <= 1)
        return rk_driver_save(driver, driver->debug, error);
    char label[64];
    snprintf(label, sizeof label, "%s_%g", driver->debug, (double)c->magnify);
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "watertight",
        .summary = summary,
        .options = options,
        .choices = &c,
        .views =
            (rk_driver_view[]){{"leaks", draw_leaks, true}, {"classic", draw_classic, true}, {0}},
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
