/* Draws the figures and measures the tables of cubemap: a scene in its environment, the map as a
 * cross, marked faces, the filters close up where faces meet, and how far they are off. */
#include "render/driver.h"
#include "base/file.h"
#include "base/random.h"
#include "scene/sky.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char summary[] =
    "Renders a scene in an environment (--environment), which mirrors and misses see.\n"
    "--marked takes a map with a letter on each face.\n"
    "--debug cross draws the map unfolded.\n"
    "--debug seam draws a map of random colours where three faces meet.\n"
    "--filters puts the filters' errors and steps into a table.";

static const char *const filter_names[] = {"nearest", "bilinear", "seamless"};
enum { filter_count = sizeof filter_names / sizeof filter_names[0] };

typedef struct choices {
    float mirror;  /* NaN: materials are their own */
    uint32_t side; /* 0: the map's own */
    bool marked, filters;
} choices;

static void set_material(rk_material *material, float mirror)
{
    material->ks = rk_vec(mirror, mirror, mirror);
    material->kd = rk_scale(material->kd, 1 - mirror);
}

static void set_materials(rk_scene *scene, float mirror)
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], mirror);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], mirror);
}

/* --- Maps that show something ---------------------------------------------------------------- */

typedef rk_vec3 paint(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row);

static bool paint_map(rk_cubemap *map, uint32_t side, paint *colour, rk_error *error)
{
    rk_cubemap_free(map);
    if (!rk_cubemap_init(map, side, error))
        return false;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t row = 0; row < side; row++)
            for (uint32_t column = 0; column < side; column++)
                *rk_cubemap_texel(map, (rk_cube_face)face, column, row) =
                    colour(side, (rk_cube_face)face, column, row);
    return true;
}

static rk_vec3 sky(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    return rk_sky_at(rk_cubemap_texel_direction(side, face, column, row));
}

static rk_vec3 random_colour(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    uint32_t texel = ((uint32_t)face * side + row) * side + column;
    return rk_vec(rk_unit_float(rk_hash(texel, 0, 0, 0)), rk_unit_float(rk_hash(texel, 1, 0, 0)),
                  rk_unit_float(rk_hash(texel, 2, 0, 0)));
}

/* Each face in a colour: that of its axis, red, green or blue, or the opposite of it for the
 * negative side; and on it an F, which is another letter in a mirror, and however it is turned. */
static rk_vec3 marked(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    static const rk_vec3 colours[RK_FACES] = {{0.7f, 0.1f, 0.1f}, {0.1f, 0.6f, 0.6f},
                                              {0.1f, 0.6f, 0.1f}, {0.6f, 0.1f, 0.6f},
                                              {0.1f, 0.1f, 0.7f}, {0.7f, 0.6f, 0.1f}};
    static const char letter[5][4] = {"###", "#..", "##.", "#..", "#.."};
    uint32_t x = column * 11 / side, y = row * 11 / side;
    bool ink = x >= 4 && x < 7 && y >= 3 && y < 8 && letter[y - 3][x - 4] == '#';
    bool border = column == 0 || row == 0 || column == side - 1 || row == side - 1;
    return ink ? rk_vec(1, 1, 1) : border ? rk_vec(0, 0, 0) : colours[face];
}

static bool prepare(rk_driver *driver, const choices *c, rk_error *error)
{
    rk_scene *scene = &driver->scene;
    bool seam = rk_driver_debug(driver, "seam"), is_sky = strcmp(driver->environment, "sky") == 0;
    if (c->side && !is_sky && !seam && !c->marked)
        return rk_fail(error, "--side: a file has a size of its own; this goes with --environment "
                              "sky, --marked and --debug seam");
    if (driver->debug && driver->pixel.given)
        return rk_fail(error,
                       "--debug %s shows the map and not the scene, so --pixel has no story: "
                       "leave one of them out",
                       driver->debug);
    if (!isnan(c->mirror))
        set_materials(scene, c->mirror);
    if (seam)
        return paint_map(&scene->environment, c->side ? c->side : 8, random_colour, error);
    if (c->marked)
        return paint_map(&scene->environment, c->side ? c->side : 256, marked, error);
    return c->side == 0 || paint_map(&scene->environment, c->side, sky, error);
}

/* --- Pictures of the map --------------------------------------------------------------------- */

/* The faces of the cross in columns and rows; blank cells are none. */
static const int cross[3][4] = {{-1, RK_FACE_Y, -1, -1},
                                {RK_FACE_MINUS_X, RK_FACE_MINUS_Z, RK_FACE_X, RK_FACE_Z},
                                {-1, RK_FACE_MINUS_Y, -1, -1}};

static rk_vec3 seen(const rk_driver *driver, rk_vec3 direction)
{
    return rk_cubemap_at(&driver->scene.environment, direction, driver->render.environment_filter);
}

/* The cross as large as it fits, in the picture's middle. */
static void draw_cross(rk_driver *driver)
{
    float width = (float)driver->image.width, height = (float)driver->image.height;
    float cell = rk_min(width / 4, height / 3);
    for (size_t y = 0; y < driver->image.height; y++)
        for (size_t x = 0; x < driver->image.width; x++) {
            float across = ((float)x + 0.5f - width / 2) / cell + 2;
            float down = ((float)y + 0.5f - height / 2) / cell + 1.5f;
            bool outside = across < 0 || across >= 4 || down < 0 || down >= 3;
            int face = outside ? -1 : cross[(int)down][(int)across];
            *rk_image_at(&driver->image, x, y) =
                face < 0
                    ? rk_vec(0.02f, 0.02f, 0.02f)
                    : seen(driver, rk_cube_direction((rk_cube_face)face, across - floorf(across),
                                                     1 - (down - floorf(down))));
        }
}

/* The map takes the scene's place, in names and captions as well. */
static void show_map_alone(rk_driver *driver, const choices *c)
{
    const char *slash = strrchr(driver->environment, '/');
    const char *own = slash ? slash + 1 : driver->environment;
    bool seam = rk_driver_debug(driver, "seam");
    rk_cubemap map = driver->scene.environment;
    driver->scene.environment = (rk_cubemap){0};
    rk_scene_free(&driver->scene);
    driver->scene.environment = map;
    snprintf(driver->scene.name, sizeof driver->scene.name, "%s",
             seam        ? "random-colours"
             : c->marked ? "marked"
                         : own);
}

/* From the cube's centre to the corner of +x, +y and -z, half a face to each side. */
static void draw_seam(rk_driver *driver)
{
    const rk_camera camera = {.distance = 1, .rotation = rk_vec(-35.264f, 135, 0), .fov = 40};
    rk_view view = rk_view_of(&camera, driver->image.width, driver->image.height);
    for (size_t y = 0; y < driver->image.height; y++)
        for (size_t x = 0; x < driver->image.width; x++)
            *rk_image_at(&driver->image, x, y) =
                seen(driver, rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f).direction);
}

/* --- Tables ---------------------------------------------------------------------------------- */

static rk_vec3 random_direction(uint32_t n)
{
    float z = 2 * rk_unit_float(rk_hash(n, 0, 1, 0)) - 1, r = sqrtf(1 - z * z);
    float angle = 6.2831853f * rk_unit_float(rk_hash(n, 1, 1, 0));
    return rk_vec(r * cosf(angle), r * sinf(angle), z);
}

/* Nanoseconds a lookup in random directions, and the time of the picture. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    enum { directions = 1 << 16, rounds = 32 };
    double nanoseconds[RK_RUNS_MAX];
    rk_vec3 *d = rk_allocate(directions, sizeof *d, "directions", error);
    if (!d)
        return false;
    for (uint32_t n = 0; n < directions; n++)
        d[n] = random_direction(n);
    bool ok = rk_driver_row(driver, "render", "ms", driver->render_ms, error);
    for (int filter = 0; ok && filter < filter_count; filter++) {
        float sum = 0; /* is asked for below, or the compiler would leave the lookups out */
        for (uint32_t run = 0; run < driver->runs; run++) {
            double start = rk_clock_thread();
            for (uint32_t n = 0; n < rounds * directions; n++)
                sum += rk_cubemap_at(&driver->scene.environment, d[n % directions],
                                     (rk_cubemap_filter)filter)
                           .x;
            nanoseconds[run] = 1e9 * (rk_clock_thread() - start) / (rounds * directions);
        }
        if (!isfinite(sum))
            ok = rk_fail(error, "the environment is too bright to be added up");
        char metric[48];
        snprintf(metric, sizeof metric, "lookup_%s_%u", filter_names[filter],
                 driver->scene.environment.side);
        ok = ok &&
             rk_driver_row(driver, metric, "ns", rk_timing_of(nanoseconds, driver->runs), error);
    }
    free(d);
    return ok;
}

/* A smooth function, to be told from its map. */
static rk_vec3 smooth(rk_vec3 d)
{
    d = rk_normalize(d);
    return rk_vec(0.5f + 0.5f * sinf(3 * d.x + d.y), 0.5f + 0.5f * d.y * d.z,
                  0.5f + 0.5f * cosf(2 * d.z));
}

static rk_vec3 smooth_texel(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    return smooth(rk_cubemap_texel_direction(side, face, column, row));
}

static double distance(rk_vec3 a, rk_vec3 b)
{
    return (double)rk_length(rk_sub(a, b));
}

/* Root mean square error over the sphere. */
static double error_of(const rk_cubemap *map, rk_cubemap_filter filter)
{
    enum { directions = 1 << 15 };
    double sum = 0;
    for (uint32_t n = 0; n < directions; n++) {
        rk_vec3 d = random_direction(n);
        double error = distance(rk_cubemap_at(map, d, filter), smooth(d));
        sum += error * error;
    }
    return sqrt(sum / directions);
}

/* The largest difference between two directions on the two sides of an edge, nearly the same. */
static double step_of(const rk_cubemap *map, rk_cubemap_filter filter)
{
    const float below = 0.5f - 0x1p-22f, above = 0.5f + 0x1p-22f;
    double largest = 0;
    for (int i = 0; i < RK_FACES * 4 * 1024; i++) {
        rk_cube_face face = (rk_cube_face)(i / 4096);
        float along = ((float)(i % 1024) + 0.5f) / 1024, sign = i / 1024 % 2 ? 1 : -1;
        float in = 0.5f + sign * below, out = 0.5f + sign * above;
        bool upright = i / 2048 % 2;
        rk_vec3 a = rk_cube_direction(face, upright ? in : along, upright ? along : in);
        rk_vec3 b = rk_cube_direction(face, upright ? out : along, upright ? along : out);
        double step = distance(rk_cubemap_at(map, a, filter), rk_cubemap_at(map, b, filter));
        largest = step > largest ? step : largest;
    }
    return largest;
}

static bool put_filters(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"filter", "side", "rmse", "step", NULL};
    char path[4096], cells[3][32];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/cubemap_filters.csv", driver->out);
    for (uint32_t side = 2; side <= 256; side *= 2) {
        if (!paint_map(&driver->scene.environment, side, smooth_texel, error))
            return false;
        for (int filter = 0; filter < filter_count; filter++) {
            const rk_cubemap *map = &driver->scene.environment;
            snprintf(cells[0], sizeof cells[0], "%u", side);
            snprintf(cells[1], sizeof cells[1], "%.4g", error_of(map, (rk_cubemap_filter)filter));
            snprintf(cells[2], sizeof cells[2], "%.4g", step_of(map, (rk_cubemap_filter)filter));
            const char *row[] = {filter_names[filter], cells[0], cells[1], cells[2]};
            if (!rk_table_put(path, header, row, 4, 2, error))
                return false;
        }
    }
    return true;
}

/* --- The driver ------------------------------------------------------------------------------ */

static bool save(rk_driver *driver, const choices *c, rk_error *error)
{
    char label[64];
    const char *filter = filter_names[driver->render.environment_filter];
    if (driver->debug)
        snprintf(label, sizeof label, "%s_%s", driver->debug, filter);
    else
        snprintf(label, sizeof label, "%s%s%s", c->marked ? "marked_" : "",
                 isnan(c->mirror) ? "" : "mirror_", filter);
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c = {.mirror = NAN};
    const rk_option options[] = {
        {"mirror", RK_OPTION_FLOAT, &c.mirror, "K",
         "specular colour of all materials, a grey, which their diffuse colour loses; by default "
         "their own",
         0, 1},
        {"side", RK_OPTION_UINT, &c.side, "N",
         "texels a side of the built-in sky, or of --marked or --debug seam; 0: 256, "
         "and 8 for --debug seam",
         0, RK_CUBEMAP_SIDE_MAX},
        {"marked", RK_OPTION_FLAG, &c.marked, NULL,
         "an environment of six colours, with the letter F upright on each face", 0, 0},
        {"filters", RK_OPTION_FLAG, &c.filters, NULL,
         "put errors and steps at edges, by the map's size, into DIR/tables/cubemap_filters.csv "
         "instead of drawing",
         0, 0},
        {0},
    };
    const char *const views[] = {"cross", "seam", NULL};
    rk_driver driver = rk_driver_default("cubemap", summary);
    driver.scene_name = "scan";
    driver.environment = "sky";
    driver.render.reflections = true; /* what else would a mirror show? */
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = prepare(&driver, &c, &error);
    if (ok && c.filters)
        return rk_driver_finish(&driver, put_filters(&driver, &error), &error);
    if (ok && driver.debug)
        show_map_alone(&driver, &c);
    if (ok && rk_driver_debug(&driver, "cross"))
        draw_cross(&driver);
    else if (ok && rk_driver_debug(&driver, "seam"))
        draw_seam(&driver);
    else
        ok = ok && rk_driver_build(&driver, &error) && rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        ok = put_rows(&driver, &error);
    else if (ok)
        ok = save(&driver, &c, &error);
    return rk_driver_finish(&driver, ok, &error);
}
