/* The debug views: points in the unit square, and the error of a picture. */
#include "driver.h"

#include "base/scramble.h"
#include "base/table.h"
#include "driver/convergence.h"
#include "driver/number_row.h"
#include "features/shading.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* These pictures show no scene; names and captions don't, either. */
static void name_picture(rk_driver *driver, const char *name)
{
    snprintf(driver->scene.name, sizeof driver->scene.name, "%s", name);
}

/* --- Points ----------------------------------------------------------------------------------- */

/* The decision of the renderer that has this joint dimension; its coordinate. */
static uint32_t decision_of(uint32_t joint, uint32_t *coordinate)
{
    static const uint32_t of_joint[RK_SOBOL_DIMENSIONS] = {
        RK_DIMENSION_PIXEL, RK_DIMENSION_PIXEL,  RK_DIMENSION_LENS,
        RK_DIMENSION_LENS,  RK_DIMENSION_TIME,   RK_DIMENSION_LIGHT,
        RK_DIMENSION_LIGHT, RK_DIMENSION_GLOSSY, RK_DIMENSION_GLOSSY};
    *coordinate = joint > 0 && of_joint[joint - 1] == of_joint[joint];
    return of_joint[joint];
}

static float sample_of(const rk_driver *driver, uint32_t i, uint32_t joint)
{
    const choices *c = driver->choices;
    const rk_sampler sampler = rk_render_sampler(&driver->render, c->kind, c->points);
    uint32_t pixel = driver->pixel.y * driver->render.width + driver->pixel.x, coordinate;
    uint32_t dimension = decision_of(joint, &coordinate);
    if (dimension == RK_DIMENSION_TIME)
        return rk_joint_1d(&sampler, pixel, i, dimension);
    rk_vec2 pair = rk_joint_2d(&sampler, pixel, i, dimension);
    return coordinate ? pair.y : pair.x;
}

static float point_of(const rk_driver *driver, uint32_t i, uint32_t joint)
{
    const choices *c = driver->choices;
    uint32_t v[RK_SOBOL_DIGITS];
    if (c->of == POINTS_SAMPLES)
        return sample_of(driver, i, joint);
    if (c->of == POINTS_DIRECTIONS)
        rk_sobol_directions(joint, v);
    for (uint32_t k = 0; c->of != POINTS_DIRECTIONS && k < RK_SOBOL_DIGITS; k++)
        v[k] = rk_reverse_bits(rk_sobol_columns[joint][k]);
    uint32_t bits = rk_sobol_bits(v, i);
    if (c->of == POINTS_OWEN)
        bits = rk_owen_scramble(bits, rk_hash(driver->render.seed, joint, 0, 0));
    return rk_unit_float(bits);
}

/* Squares of a side that is a power of two, at most as many as there are points. */
static uint32_t cells_of(uint32_t points)
{
    uint32_t cells = 1;
    while (4 * cells * cells <= points)
        cells *= 2;
    return cells;
}

/* The share of these squares without a point. */
static double empty_share(const rk_driver *driver, uint32_t joint_x, uint32_t joint_y)
{
    enum { MOST = 256 }; /* a side of 65536 points */
    const choices *c = driver->choices;
    const uint32_t side = cells_of(c->points);
    static bool is_taken[MOST][MOST];
    uint32_t taken = 0;
    memset(is_taken, 0, sizeof is_taken);
    for (uint32_t i = 0; i < c->points; i++) {
        const float x = point_of(driver, i, joint_x), y = point_of(driver, i, joint_y);
        bool *cell = &is_taken[(uint32_t)(y * (float)side)][(uint32_t)(x * (float)side)];
        taken += !*cell;
        *cell = true;
    }
    return 1 - (double)taken / ((double)side * side);
}

bool put_pairs(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    name_picture(driver, "unit-square");
    for (uint32_t x = 0; x < RK_SOBOL_DIMENSIONS; x++)
        for (uint32_t y = x + 1; y < RK_SOBOL_DIMENSIONS; y++) {
            double numbers[8] = {x, y, c->points};
            for (uint32_t kind = 0; kind <= RK_SAMPLER_ZSOBOL; kind++) {
                c->kind = (rk_sampler_kind)kind;
                numbers[3 + kind] = empty_share(driver, x, y);
            }
            if (!rk_driver_number_row(driver, "sampling_pairs",
                                      "x y points uniform stratified low_discrepancy sobol zsobol",
                                      3, numbers, error))
                return false;
        }
    return true;
}

/* Grey lines between cells: as many on each side as there are points, or about their root. */
static rk_vec3 paper(size_t x, size_t y, size_t side, uint32_t cells)
{
    const rk_vec3 white = {1, 1, 1}, line = {0.75f, 0.75f, 0.75f};
    bool on_line =
        x * cells / side != (x + 1) * cells / side || y * cells / side != (y + 1) * cells / side;
    return on_line ? line : white;
}

static void put_dot(const rk_image *image, float x, float y, float radius)
{
    for (size_t row = 0; row < image->height; row++)
        for (size_t column = 0; column < image->width; column++) {
            float r = hypotf((float)column + 0.5f - x, (float)row + 0.5f - y);
            float cover = rk_min(rk_max(radius - r + 0.5f, 0), 1);
            rk_vec3 *pixel = rk_image_at(image, column, row);
            *pixel = rk_madd(*pixel, rk_sub(rk_vec(0.02f, 0.1f, 0.3f), *pixel), cover);
        }
}

bool draw_points(rk_driver *driver, rk_error *error)
{
    (void)error;
    name_picture(driver, "unit-square");
    const choices *c = driver->choices;
    const rk_image *image = &driver->image;
    size_t side = image->width < image->height ? image->width : image->height;
    const uint32_t cells = cells_of(c->points);
    for (size_t y = 0; y < image->height; y++)
        for (size_t x = 0; x < image->width; x++)
            *rk_image_at(image, x, y) = paper(x, y, side, cells);
    float radius = rk_max(1, 0.12f * (float)side / sqrtf((float)c->points));
    for (uint32_t i = 0; i < c->points; i++) /* y upwards */
        put_dot(image, point_of(driver, i, c->x) * (float)side,
                (1 - point_of(driver, i, c->y)) * (float)side, rk_min(radius, 6));
    return true;
}

/* --- Z order ---------------------------------------------------------------------------------- */

/* A line of this width, from the middle of one pixel of the drawing to that of another. */
static void put_line(const rk_image *image, rk_vec2 from, rk_vec2 to, float width, rk_vec3 colour)
{
    const float dx = to.x - from.x, dy = to.y - from.y, squared = dx * dx + dy * dy;
    for (size_t row = 0; row < image->height; row++)
        for (size_t column = 0; column < image->width; column++) {
            float x = (float)column + 0.5f - from.x, y = (float)row + 0.5f - from.y;
            float t = rk_min(rk_max((x * dx + y * dy) / squared, 0), 1);
            float cover = width / 2 - hypotf(x - t * dx, y - t * dy) + 0.5f;
            rk_vec3 *pixel = rk_image_at(image, column, row);
            *pixel = rk_madd(*pixel, rk_sub(colour, *pixel), rk_min(rk_max(cover, 0), 1));
        }
}

/* 8 x 8 pixels, connected in their order, from blue to yellow. */
bool draw_order(rk_driver *driver, rk_error *error)
{
    enum { pixels = 8 };
    (void)error;
    name_picture(driver, "8x8-pixels");
    const choices *c = driver->choices;
    const rk_image *image = &driver->image;
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    size_t side = image->width < image->height ? image->width : image->height;
    struct {
        uint32_t place;
        rk_vec2 at;
    } path[pixels * pixels], moved;
    for (size_t y = 0; y < image->height; y++)
        for (size_t x = 0; x < image->width; x++)
            *rk_image_at(image, x, y) = paper(x, y, side, pixels);
    for (uint32_t i = 0; i < pixels * pixels; i++) {
        uint32_t x = i % pixels, y = i / pixels, place = rk_morton_index(x, y);
        path[i].place = c->permuted ? rk_permute_digits(place, driver->render.seed) : place;
        path[i].at = (rk_vec2){((float)x + 0.5f) * (float)side / pixels,
                               ((float)y + 0.5f) * (float)side / pixels};
        for (uint32_t k = i; k > 0 && path[k].place < path[k - 1].place; k--)
            moved = path[k], path[k] = path[k - 1], path[k - 1] = moved;
    }
    for (uint32_t i = 1; i < pixels * pixels; i++)
        put_line(image, path[i - 1].at, path[i].at, rk_max((float)side / 200, 1),
                 rk_gradient_at(&gradient, 2 * (float)i / (pixels * pixels) - 1));
    return true;
}

/* --- Errors ----------------------------------------------------------------------------------- */

/* Where errors of 0 are grey. */
static const float grey = 0.2f;

static rk_vec3 colour_of_error(float fraction)
{
    return rk_vec(fraction, fraction, fraction);
}

/* The root mean square of the picture of differences, as a row of a table. */
static bool put_rmse(const rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"effect", "samples", "kind", "blur", "rmse", NULL};
    const choices *c = driver->choices;
    char path[4096], samples[16], blur[32], rmse[32];
    snprintf(samples, sizeof samples, "%u", c->samples);
    snprintf(blur, sizeof blur, "%g", (double)c->blur);
    snprintf(rmse, sizeof rmse, "%.4g", sqrt(mean_square(&driver->image)));
    const char *row[] = {effect_names.items[c->effect], samples, rk_sampler_name(c->kind), blur,
                         rmse};
    return rk_driver_table(driver, "sampling_error", path, error) &&
           rk_table_put(path, header, row, 5, 4, error);
}

bool draw_error(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_image want;
    set_samples(driver, RK_SAMPLER_SOBOL, c->reference);
    if (!rk_convergence_reference(driver, &want, error))
        return false;
    set_samples(driver, c->kind, c->samples);
    bool ok = rk_driver_render(driver, error);
    for (size_t i = 0; ok && i < want.width * want.height; i++)
        driver->image.pixels[i] = rk_sub(driver->image.pixels[i], want.pixels[i]);
    if (c->blur > 0)
        ok = ok && blur_image(&driver->image, c->blur, error);
    ok = ok && put_rmse(driver, error);
    for (size_t i = 0; ok && i < want.width * want.height; i++) {
        rk_vec3 *pixel = &driver->image.pixels[i];
        *pixel = rk_madd(rk_vec(grey, grey, grey), *pixel, c->gain);
        *pixel = rk_vec(rk_max(pixel->x, 0), rk_max(pixel->y, 0), rk_max(pixel->z, 0));
    }
    if (c->gain > 0)
        driver->scale = rk_driver_scale_of("error of the radiance", -(double)grey / (double)c->gain,
                                           (1 - (double)grey) / (double)c->gain, colour_of_error);
    rk_image_free(&want);
    return ok;
}
