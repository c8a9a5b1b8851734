/* Draws the figures and measures the tables of watertight: a closed ball seen from inside, with a
 * dot wherever a ray that is aimed at an edge or a corner leaves it. */
#include "driver/driver_main.h"

#include "features/watertight.h"

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
    float scale;
} choices;

static const rk_option options[] = {
    {"ball-radius", RK_FIELD(choices, scale), "R",
     "of the ball of the debug views, from 1e-15 to 1e15", 1e-15, 1e15, 1},
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

typedef struct leak_count {
    uint32_t rays, leaks;
} leak_count;

/* --- Drawing ---------------------------------------------------------------------------------- */

/* Half a picture is as wide as the distance to it. */
static void draw_dot(rk_image *image, rk_vec3 direction)
{
    if (!(direction.z > 0))
        return;
    float half = 0.5f * (float)image->width, x = half * (1 + direction.x / direction.z);
    float y = 0.5f * (float)image->height - half * direction.y / direction.z;
    for (int dy = -2; dy <= 2; dy++)
        for (int dx = -2; dx <= 2; dx++) {
            float px = floorf(x) + (float)dx, py = floorf(y) + (float)dy;
            bool inside =
                px >= 0 && py >= 0 && px < (float)image->width && py < (float)image->height;
            if (inside && dx * dx + dy * dy <= 5)
                *rk_image_at(image, (uint32_t)px, (uint32_t)py) = rk_vec(1, 1, 1);
        }
}

/* Each triangle in a tone of its own. */
static void draw_triangles(rk_image *image, const ball *b, rk_vec3 eye)
{
    float half = 0.5f * (float)image->width;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            rk_ray ray = {eye,
                          rk_vec(((float)x + 0.5f - half) / half,
                                 (0.5f * (float)image->height - (float)y - 0.5f) / half, 1),
                          INFINITY};
            uint32_t hit = watertight_hit(b, &ray);
            float tone = hit < triangles ? 0.03f + 0.02f * (float)(hit * 7 % 5) : 1;
            *rk_image_at(image, x, y) = rk_vec(tone, 1.3f * tone, 1.8f * tone);
        }
}

/* Aims at 64 points of each edge, its ends among them. With an image, draws a dot where a ray
 * leaves. */
static leak_count count_leaks(const ball *b, rk_vec3 eye, first_hit_test *test, rk_image *image)
{
    leak_count count = {0, 0};
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        const rk_vec3 *corner = &b->triangles[i / 3].a;
        rk_vec3 from = corner[i % 3], to = corner[(i + 1) % 3];
        for (uint32_t k = 0; k < parts_of_edge; k++) {
            rk_vec3 at = rk_mix(from, to, (float)k / parts_of_edge);
            rk_ray ray = {eye, rk_sub(at, eye), INFINITY};
            bool leaves = test(b, &ray) == triangles;
            count.rays++;
            count.leaks += leaves;
            if (leaves && image)
                draw_dot(image, ray.direction);
        }
    }
    return count;
}

static bool draw_with(rk_driver *driver, first_hit_test *test)
{
    const choices *c = driver->choices;
    static ball b;
    make_ball(&b, c->scale);
    draw_triangles(&driver->image, &b, eye_of(&b, c->scale));
    count_leaks(&b, eye_of(&b, c->scale), test, &driver->image);
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

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    static ball b;
    make_ball(&b, c->scale);
    leak_count classic = count_leaks(&b, eye_of(&b, c->scale), classic_hit, NULL);
    leak_count now = count_leaks(&b, eye_of(&b, c->scale), watertight_hit, NULL);
    return rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_row(driver, "aimed", "rays", rk_timing_once(now.rays), error) &&
           rk_driver_row(driver, "leaks_classic", "rays", rk_timing_once(classic.leaks), error) &&
           rk_driver_row(driver, "leaks_watertight", "rays", rk_timing_once(now.leaks), error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    return rk_driver_save(driver, driver->debug, error);
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
