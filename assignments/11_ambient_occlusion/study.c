/* The tables: convergence of each map and sampler to a reference picture or the closed form, and
 * estimates of both maps for a disk, a sphere and a wall. */
#include "driver.h"

#include "base/dvec3.h"
#include "driver/convergence.h"

#include <stdio.h>
#include <string.h>

/* --- A sphere on a floor ---------------------------------------------------------------------- */

static const rk_sphere ball = {{0, 0, 0}, 0.5f};

bool put_on_floor(rk_driver *driver, rk_error *error)
{
    const float far = 1000; /* the floor beyond it covers less than a millionth of a hemisphere */
    rk_mesh mesh;
    if (!rk_mesh_init(&mesh, 4, 2, 1, 0, error))
        return false;
    for (uint32_t i = 0; i < 4; i++)
        mesh.positions[i] = rk_vec(i & 1 ? far : -far, -ball.radius, i & 2 ? far : -far);
    const uint32_t floor[2][3] = {{0, 2, 1}, {1, 2, 3}};
    memcpy(mesh.triangles, floor, sizeof floor);
    rk_scene_free(&driver->scene);
    rk_scene_init(&driver->scene, "floor", &mesh);
    driver->scene.spheres[0] = ball;
    driver->scene.sphere_materials[0] = driver->scene.mesh.materials[0];
    driver->scene.sphere_count = 1;
    /* The horizon is above the picture. */
    driver->scene.camera = (rk_camera){.distance = 2.6f, .rotation = rk_vec(40, 0, 0), .fov = 50};
    rk_scene_default_light(&driver->scene);
    return true;
}

/* A at the ray's intersection with the sphere, (1 + n_y) / 2, or else with the floor. */
static double visibility_along(const rk_ray *ray)
{
    rk_dvec3 o = rk_widen(ray->origin), d = rk_widen(ray->direction);
    d = rk_dscale(d, 1 / rk_dlength(d));
    double radius = (double)ball.radius, half = rk_ddot(o, d);
    double discriminant = half * half - rk_ddot(o, o) + radius * radius;
    if (discriminant > 0)
        return (1 + rk_dmadd(o, d, -half - sqrt(discriminant)).y / radius) / 2;
    rk_dvec3 p = rk_dmadd(o, d, (-radius - o.y) / d.y);
    double distance = rk_dlength(p);
    return (double)rk_ambient_below_sphere(ball.radius, (float)distance,
                                           (float)(radius / distance));
}

static bool draw_closed_form(const rk_driver *driver, rk_image *image, rk_error *error)
{
    uint32_t width = driver->render.width, height = driver->render.height;
    rk_view view = rk_view_of(&driver->scene.camera, width, height);
    if (!rk_image_init(image, width, height, error))
        return false;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
            float visibility = (float)visibility_along(&ray);
            *rk_image_at(image, x, y) = rk_vec(visibility, visibility, visibility);
        }
    return true;
}

/* --- Convergence ------------------------------------------------------------------------------ */

bool put_convergence(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_ambient_occlusion_options *ambient = &driver->render.ambient_occlusion;
    const char *table =
        c->on_floor ? "ambient_occlusion_on_floor" : "ambient_occlusion_convergence";
    char reference[32] = "closed form", method[64];
    rk_image want;
    show_visibility_alone(driver);
    if (!c->on_floor)
        snprintf(reference, sizeof reference, "%u samples", c->reference);
    ambient->samples = c->reference;
    if (!(c->on_floor ? draw_closed_form(driver, &want, error)
                      : rk_convergence_reference(driver, &want, error)))
        return false;
    const rk_convergence study = {table, &want, reference, c->seeds};
    bool ok = true;
    for (uint32_t i = 0; ok && i < 6; i++) {
        ambient->sampling = (rk_sampler_kind)(i / 2);
        ambient->map = (rk_ambient_map)(i % 2);
        snprintf(method, sizeof method, "%s, %s", rk_sampler_name(ambient->sampling),
                 rk_ambient_map_names.items[ambient->map]);
        for (ambient->samples = 1; ok && ambient->samples <= c->most; ambient->samples *= 4)
            ok = rk_convergence_row_of(driver, &study, method, ambient->samples, NULL, error);
    }
    rk_image_free(&want);
    return ok;
}

/* --- Closed forms ----------------------------------------------------------------------------- */

/* Above the point 0, whose normal is z. */
typedef struct occluder {
    const char *name, *where;
    enum { disk, sphere, wall } shape;
    float size;     /* radius or height */
    float distance; /* from the point */
    float cosine;   /* of a sphere's direction and the normal */
} occluder;

static bool is_occluded(const occluder *o, rk_vec3 d)
{
    if (o->shape == disk) /* the ray's distance from the axis at the disk's height */
        return d.x * d.x + d.y * d.y < d.z * d.z * o->size * o->size / (o->distance * o->distance);
    if (o->shape == wall) /* its height at the wall */
        return d.x > 0 && d.z * o->distance < d.x * o->size;
    float along = d.x * sqrtf(1 - o->cosine * o->cosine) + d.z * o->cosine;
    return along > 0 && 1 - along * along < o->size * o->size / (o->distance * o->distance);
}

static float closed_form_of(const occluder *o)
{
    if (o->shape == disk)
        return rk_ambient_below_disk(o->size, o->distance);
    if (o->shape == wall)
        return rk_ambient_beside_wall(o->size, o->distance);
    return rk_ambient_below_sphere(o->size, o->distance, o->cosine);
}

typedef struct estimate {
    double mean, rmse;
} estimate;

/* The mean over `pixels` pixels, and the root mean square error of a pixel. */
static estimate estimate_of(const rk_driver *driver, const occluder *o, rk_ambient_map map)
{
    enum { pixels = 4096 };
    const rk_ambient_occlusion_options *ambient = &driver->render.ambient_occlusion;
    const rk_sampler sampler =
        rk_render_sampler(&driver->render, ambient->sampling, ambient->samples);
    double sum = 0, squares = 0, want = (double)closed_form_of(o);
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        double visibility = 0;
        for (uint32_t i = 0; i < ambient->samples; i++) {
            rk_vec3 d = rk_ambient_hemisphere(map, rk_sample_2d(&sampler, pixel, i, 0));
            if (!is_occluded(o, d))
                visibility += (double)rk_ambient_weight(map, d.z) / ambient->samples;
        }
        sum += visibility;
        squares += (visibility - want) * (visibility - want);
    }
    return (estimate){sum / pixels, sqrt(squares / pixels)};
}

bool put_closed_forms(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"above it", "where",       "closed form", "uniform",
                                         "cosine",   "uniform_rms", "cosine_rms",  NULL};
    static const occluder occluders[] = {
        {"nothing", "", disk, 0, 1, 1},
        {"disk", "radius 1, height 2", disk, 1, 2, 1},
        {"disk", "radius 1, height 1", disk, 1, 1, 1},
        {"sphere", "radius 1, distance 2, overhead", sphere, 1, 2, 1},
        {"sphere", "radius 1, distance 2, at 60 degrees", sphere, 1, 2, 0.5f},
        {"wall", "height 1, distance 1", wall, 1, 1, 0},
        {"wall", "height 1, distance 0.01", wall, 1, 0.01f, 0},
    };
    char path[4096];
    if (!rk_driver_table(driver, "ambient_occlusion_closed_forms", path, error))
        return false;
    for (size_t i = 0; i < sizeof occluders / sizeof *occluders; i++) {
        const occluder *o = &occluders[i];
        const estimate uniform = estimate_of(driver, o, RK_AMBIENT_UNIFORM);
        const estimate cosine = estimate_of(driver, o, RK_AMBIENT_COSINE);
        const double figures[] = {(double)closed_form_of(o), uniform.mean, cosine.mean,
                                  uniform.rmse, cosine.rmse};
        char cells[5][32];
        const char *row[7] = {o->name, o->where};
        for (int k = 0; k < 5; k++) {
            snprintf(cells[k], sizeof cells[k], "%.4f", figures[k]);
            row[2 + k] = cells[k];
        }
        if (!rk_table_put(path, header, row, 7, 2, error))
            return false;
    }
    return true;
}
