/* Builds and renders as often as --runs says, and keeps each time. A tree that finds no triangles,
 * as a starter's, is replaced by the wide tree, with a note. */
#include "driver/driver.h"

#include "accel/query/tree.h"
#include "driver/driver_team.h"
#include "driver/explain_pixel.h"
#include "driver/unsolved.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Which features' work the missing tree is; rays traverse binary trees by bvh_median's functions.
 */
static const char *builders_of(rk_accel_kind split)
{
    if (split == RK_ACCEL_MEDIAN)
        return "bvh_median";
    if (split == RK_ACCEL_COLLAPSED)
        return rk_is_starter("sah_binning") ? "sah_binning" : "wide_bvh";
    return !rk_is_starter("bvh_median")    ? "sah_binning"
           : !rk_is_starter("sah_binning") ? "bvh_median"
                                           : "bvh_median and sah_binning";
}

/* Traces the renderer's own tree in place of the one that was built. */
static bool stand_in(rk_driver *driver, rk_error *error)
{
    driver->unfinished = driver->accel;
    driver->accel = (rk_accel){0};
    if (!driver->quiet)
        fprintf(stderr,
                "%s: the tree of %s finds no triangles yet, so the picture is traced through the "
                "renderer's own tree\n",
                driver->feature, builders_of(driver->split));
    return rk_accel_build(&driver->accel, RK_ACCEL_WIDE, &driver->scene, error);
}

bool rk_driver_has_stand_in(const rk_driver *driver)
{
    return driver->unfinished.scene != NULL;
}

const rk_bvh *rk_driver_tree(const rk_driver *driver)
{
    return rk_driver_has_stand_in(driver) ? &driver->unfinished.bvh : &driver->accel.bvh;
}

bool rk_driver_build(rk_driver *driver, rk_error *error)
{
    double milliseconds[RK_RUNS_MAX];
    rk_progress progress;
    const rk_accel_options options = {driver->split, driver->bins, driver->pool};
    rk_progress_say(&progress, "building the tree", driver->quiet);
    bool ok = true;
    for (uint32_t run = 0; ok && run < driver->runs; run++) {
        rk_accel_free(&driver->accel);
        double start = rk_clock_wall();
        ok = rk_accel_build_with(&driver->accel, &options, &driver->scene, error);
        milliseconds[run] = 1e3 * (rk_clock_wall() - start);
    }
    rk_progress_end(&progress);
    if (ok)
        driver->build_ms = rk_timing_of(milliseconds, driver->runs);
    return ok && (rk_accel_finds_triangles(&driver->accel) || stand_in(driver, error));
}

static bool time_renders(rk_driver *driver, double *milliseconds, rk_error *error)
{
    rk_progress progress;
    if (driver->render.adaptive_sampling.error > 0) /* in rounds, and nobody knows how many */
        rk_progress_say(&progress, "rendering until the error is reached", driver->quiet);
    else
        rk_progress_start(&progress, "rendering", driver->runs * rk_render_tiles(&driver->render),
                          driver->quiet);
    if (driver->team.processes > 1 && progress.total > 0)
        rk_progress_in_lines(&progress, driver->quiet);
    bool ok = true;
    for (uint32_t run = 0; ok && run < driver->runs; run++) {
        double start = rk_clock_wall();
        ok = rk_render(&driver->image, &driver->scene, &driver->accel, &driver->render,
                       driver->pool, &driver->counters, &progress, error);
        milliseconds[run] = 1e3 * (rk_clock_wall() - start);
    }
    rk_progress_end(&progress);
    return ok;
}

/* In one piece, before which stands what units print meanwhile, and after which an empty line. */
static bool explain_pixel(const rk_driver *driver, rk_error *error)
{
    char *text = NULL;
    size_t size;
    FILE *apart = open_memstream(&text, &size);
    if (apart)
        rk_explain_pixel(apart, &driver->scene, &driver->accel, &driver->render, driver->pixel.x,
                         driver->pixel.y, driver->pixel_code, driver->pixel_rays);
    const bool ok = apart && fclose(apart) == 0;
    if (ok)
        puts(text);
    free(text);
    return ok ||
           rk_fail(error, "memory is short for what is said of the pixel: close other programs");
}

bool rk_driver_render(rk_driver *driver, rk_error *error)
{
    double milliseconds[RK_RUNS_MAX];
    if (driver->pixel.given && !explain_pixel(driver, error))
        return false;
    if (!time_renders(driver, milliseconds, error))
        return false;
    driver->render_ms = rk_timing_of(milliseconds, driver->runs);
    return true;
}

bool rk_driver_render_overlay(rk_driver *driver, rk_overlay *overlay, rk_error *error)
{
    return rk_driver_render(driver, error) &&
           rk_overlay_init(overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                           error);
}

bool rk_driver_debug(const rk_driver *driver, const char *view)
{
    return driver->debug && strcmp(driver->debug, view) == 0;
}

void rk_driver_draw_pixel(rk_driver *driver)
{
    rk_pixel *pixel = &driver->pixel;
    if (!pixel->given)
        *pixel = (rk_pixel){.x = driver->render.width * driver->drawn_x / 100,
                            .y = driver->render.height * driver->drawn_y / 100};
    pixel->given = false;
}

bool rk_driver_record_pixel(rk_driver *driver, const rk_scene *scene,
                            const rk_render_options *options, rk_error *error)
{
    rk_ray_record *record = &driver->record;
    rk_ray_record_free(record);
    record->pixel = driver->pixel.y * options->width + driver->pixel.x;
    return rk_ray_record_pixel(record, scene, &driver->accel, options, driver->pool, error);
}

bool rk_driver_record_surface(rk_driver *driver, const rk_scene *scene,
                              const rk_render_options *options, rk_error *error)
{
    if (!rk_driver_record_pixel(driver, scene, options, error))
        return false;
    return (driver->record.count > 0 && driver->record.rays[0].hit.triangle != RK_MISS) ||
           rk_fail(error,
                   "--debug %s: the pixel %u,%u sees no surface; choose one that does by "
                   "--pixel X,Y",
                   driver->debug, driver->pixel.x, driver->pixel.y);
}

int rk_driver_finish(rk_driver *driver, bool ok, const rk_error *error)
{
    if (ok)
        rk_driver_note_unsolved(driver);
    rk_pool_stop(driver->pool);
    rk_ray_record_free(&driver->record);
    rk_image_free(&driver->image);
    rk_accel_free(&driver->accel);
    rk_accel_free(&driver->unfinished);
    rk_scene_free(&driver->scene);
    if (ok && fflush(stdout) != 0)
        ok = rk_driver_tell(driver, "standard output could not be written");
    else if (!ok)
        rk_driver_tell(driver, error->text);
    rk_driver_end_team(driver, ok);
    return ok ? 0 : 1;
}
