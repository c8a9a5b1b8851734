/* The output of driver/driver.h: pictures with their parameters, and rows of tables. */
#include "base/file.h"
#include "driver/driver.h"
#include "driver/implementation_note.h"
#include "driver/picture_difference.h"
#include "driver/picture_subject.h"
#include "driver/unsolved.h"
#include "io/image_file.h"
#include "io/png.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* OUT/folder, made if it is missing. */
static bool out_folder(const rk_driver *driver, const char *folder, char path[3072],
                       rk_error *error)
{
    if (snprintf(path, 3072, "%s/%s", driver->out, folder) >= 3072)
        return rk_fail(error, "--out: the folder's name is longer than 3000 bytes");
    return rk_file_make_folder(path, error);
}

bool rk_driver_try_folder(const rk_driver *driver, rk_error *error)
{
    char folder[3072], path[4096];
    rk_file file;
    if (driver->out[0] == '\0')
        return rk_fail(error, "--out: names no folder");
    if (!out_folder(driver, driver->timing ? "tables" : "figures", folder, error))
        return false;
    snprintf(path, sizeof path, "%s/%s", folder, driver->feature);
    if (!rk_file_begin(&file, path, error))
        return false;
    rk_file_abort(&file);
    return true;
}

/* Scene names and file names become parts of file names: letters, digits, dots, dashes and
 * underscores. */
static void append_name(char *path, size_t size, const char *name)
{
    size_t used = strlen(path);
    for (; *name && used + 1 < size; name++)
        path[used++] = isalnum((unsigned char)*name) || *name == '.' || *name == '_' ? *name : '-';
    path[used] = '\0';
}

rk_driver_scale rk_driver_scale_of(const char *unit, double least, double most,
                                   rk_vec3 (*colour)(float fraction))
{
    rk_driver_scale scale = {.unit = unit, .least = least, .most = most};
    for (int i = 0; i < RK_DRIVER_SCALE_COLOURS; i++)
        scale.colours[i] = colour((float)i / (RK_DRIVER_SCALE_COLOURS - 1));
    return scale;
}

typedef struct scale_text {
    char text[256];
} scale_text;

static unsigned byte_of(float linear)
{
    return (unsigned)lroundf(255 * rk_srgb_encode(rk_min(rk_max(linear, 0), 1)));
}

static void append(scale_text *shown, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void append(scale_text *shown, const char *format, ...)
{
    const size_t used = strlen(shown->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(shown->text + used, sizeof shown->text - used, format, arguments);
    va_end(arguments);
}

/* By logarithms the power of two next to the middle, if one lies between the ends. */
static double middle_of(double least, double most, bool logarithmic)
{
    if (!logarithmic)
        return (least + most) / 2;
    const double middle = sqrt(least * most), round = exp2(rint(log2(middle)));
    return round > least && round < most ? round : middle;
}

/* Both ends, and between them 0, if it lies there, or else a number in the middle. */
static void append_ticks(scale_text *shown, const rk_driver_scale *scale)
{
    const double least = scale->least, most = scale->most;
    const bool changes_sign = least < 0 && most > 0;
    const double middle = changes_sign ? 0 : middle_of(least, most, scale->logarithmic);
    double place = 0.5; /* if there is but one number */
    if (least < most)
        place = scale->logarithmic ? log(middle / least) / log(most / least)
                                   : (middle - least) / (most - least);
    append(shown, "%.3g@0 %.3g@%.3g %.3g%s@1", least, middle, place, most,
           scale->clipped ? "+" : "");
}

/* "4@0 32@0.5 256+@1 #0044cc ... samples per pixel": ticks with their places, 256 and more at the
 * end; colours; the unit. Empty without a scale. */
static scale_text text_of(const rk_driver_scale *scale)
{
    scale_text shown = {""};
    if (!scale->unit)
        return shown;
    append_ticks(&shown, scale);
    for (int i = 0; i < RK_DRIVER_SCALE_COLOURS; i++) {
        const rk_vec3 c = scale->colours[i];
        append(&shown, " #%02x%02x%02x", byte_of(c.x), byte_of(c.y), byte_of(c.z));
    }
    append(&shown, " %s", scale->unit);
    return shown;
}

static bool write_picture(const rk_driver *driver, const char *path, const char *seconds,
                          rk_error *error)
{
    char samples[16], triangles[16], black[16], frame[16], rays[24] = "", deviation[16] = "";
    const rk_picture_subject subject = rk_picture_subject_of(&driver->image);
    snprintf(black, sizeof black, "%.3f", subject.black);
    snprintf(frame, sizeof frame, "%.3f", subject.frame);
    snprintf(samples, sizeof samples, "%u", driver->render.samples);
    snprintf(triangles, sizeof triangles, "%u", driver->scene.mesh.triangle_count);
    if (rk_counters_rays(&driver->counters) > 0)
        snprintf(rays, sizeof rays, "%" PRIu64, rk_counters_rays(&driver->counters));
    if (driver->counters.estimated_error > 0)
        snprintf(deviation, sizeof deviation, "%.4g", driver->counters.estimated_error);
    const scale_text scale = text_of(&driver->scale);
    const rk_png_text all[] = {
        {"Software", "raykit " PACKAGE_VERSION},
        {"raykit:command", driver->parameters},
        {"raykit:scene", driver->scene.name},
        {"raykit:triangles", triangles},
        {"raykit:samples", samples},
        {"raykit:seconds", seconds},
        {"raykit:rays", rays},
        {"raykit:error", deviation}, /* as adaptive sampling estimates it, relative */
        {"raykit:black", black},     /* weaving refuses pictures of which little can be seen */
        {"raykit:frame", frame},
        {"raykit:units", rk_implementation_note},
        {"raykit:scale", scale.text},
    };
    rk_png_text texts[sizeof all / sizeof *all];
    size_t count = 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (*all[i].value)
            texts[count++] = all[i];
    return rk_png_write(path, &driver->image, texts, count, error);
}

typedef struct shown_duration {
    char text[32];
} shown_duration;

/* Three digits, in ms or s. */
static shown_duration duration(double milliseconds)
{
    shown_duration shown;
    if (milliseconds < 999.5)
        snprintf(shown.text, sizeof shown.text, "%.3g ms", milliseconds);
    else if (milliseconds < 999500)
        snprintf(shown.text, sizeof shown.text, "%.3g s", milliseconds / 1e3);
    else
        snprintf(shown.text, sizeof shown.text, "%.0f s", milliseconds / 1e3);
    return shown;
}

static const char *plural(uint32_t count)
{
    return count == 1 ? "" : "s";
}

/* More than the wanted error by this factor is told. */
static const double tolerated = 1.2;

/* Of adaptive sampling. It cannot tell a smooth picture from one whose details all samples missed.
 */
static void print_error(const rk_driver *driver)
{
    const rk_adaptive_sampling_options *options = &driver->render.adaptive_sampling;
    const double error = driver->counters.estimated_error, wanted = (double)options->error;
    if (!(error > 0)) {
        printf("alike in every pixel: no error can be estimated");
        return;
    }
    printf("estimated error %.2g %%", 100 * error);
    if (error <= tolerated * wanted)
        return;
    printf(" in place of %.2g %%", 100 * wanted);
    if (driver->counters.most_samples >= options->max_samples)
        printf(" (--max-samples %u allows no more)", options->max_samples);
}

static void print_samples(const rk_driver *driver)
{
    const rk_counters *counters = &driver->counters;
    const uint32_t samples = driver->render.samples;
    const double pixels = (double)driver->render.width * driver->render.height;
    if (counters->rounds == 0) {
        printf("%u sample%s per pixel", samples, plural(samples));
        return;
    }
    printf("%.1f samples per pixel on average and %llu at most, ",
           (double)counters->kept_samples / pixels, (unsigned long long)counters->most_samples);
    print_error(driver);
}

/* Lens and motion are mentioned if they took samples of their own. */
static void print_rendering(const rk_driver *driver)
{
    const rk_render_options *render = &driver->render;
    const uint32_t processes = driver->team.processes;
    uint32_t threads = processes > 0 ? driver->team_threads : rk_pool_threads(driver->pool);
    printf("%u triangle%s", driver->scene.mesh.triangle_count,
           plural(driver->scene.mesh.triangle_count));
    if (driver->mesh_path && driver->framed.triangles < driver->scene.mesh.triangle_count)
        printf(" (framed by %u in %.2g %% of their extent)", driver->framed.triangles,
               100 * driver->framed.extent);
    printf(", %u x %u, ", render->width, render->height);
    print_samples(driver);
    if (driver->counters.lens_samples > 0 && render->lens_samples > render->samples)
        printf(", %u where the lens blurs", render->lens_samples);
    if (driver->counters.time_samples > 0 && driver->counters.rounds == 0)
        printf(", %u time%s where things move", render->motion.samples,
               plural(render->motion.samples));
    if (driver->build_ms.runs > 0)
        printf(", built in %s", duration(driver->build_ms.median).text);
    printf(", rendered in %s on %u thread%s", duration(driver->render_ms.median).text, threads,
           plural(threads));
    if (processes > 0)
        printf(" of %u process%s", processes, processes == 1 ? "" : "es");
}

static void print_caption(const rk_driver *driver, const char *path)
{
    printf("%s: %s, ", path, driver->scene.name);
    if (driver->render_ms.runs > 0)
        print_rendering(driver);
    else
        printf("%u x %u", driver->render.width, driver->render.height);
    const rk_unsolved units = rk_driver_units(driver);
    printf(", %s%sraykit %s\n", units.text, *units.text ? ", " : "", PACKAGE_VERSION);
}

/* With two digits, but not 1e+02. */
static void print_per_cent(size_t part, size_t all)
{
    const double per_cent = 100 * (double)part / (double)all;
    printf(per_cent < 10 ? "%.2g %%" : "%.0f %%", per_cent);
}

/* Its starter decides in double where the exact sum would, so a few hits are another triangle's:
 * here and there a pixel, and no two that touch. */
static bool is_of_rays_along_edges(const rk_picture_difference *d, const rk_image *wanted)
{
    return rk_is_starter("watertight") && d->are_single &&
           1000 * d->pixels <= wanted->width * wanted->height;
}

static void print_place(const rk_driver *driver, const rk_picture_difference *d,
                        const rk_image *wanted, const char *shown)
{
    const rk_unsolved unsolved = rk_driver_unsolved(driver);
    const bool is_of_edges = !*unsolved.text && is_of_rays_along_edges(d, wanted);
    const bool is_of_others = (*unsolved.text || is_of_edges) && !rk_is_starter(driver->feature);
    printf("%s: %sthe picture differs in ", driver->compared,
           is_of_others ? "as good as it can be here, if all your claims hold: " : "");
    print_per_cent(d->pixels, wanted->width * wanted->height);
    printf(" of the %zu x %zu pixels, most at %zu,%zu; %s shows where", wanted->width,
           wanted->height, d->x, d->y, shown);
    if (*unsolved.text)
        printf("; %s here, and solved in the wanted picture, so it cannot be the same yet",
               unsolved.text);
    if (is_of_edges)
        printf("; watertight, which decides about rays along edges, is still the starter here, so "
               "single pixels may differ");
    printf("\n");
}

/* What is known of the difference, and the picture of it beside the one at `path`. */
static bool print_difference(const rk_driver *driver, const char *path, const rk_image *wanted,
                             rk_error *error)
{
    rk_image shown;
    if (!rk_image_init(&shown, wanted->width, wanted->height, error))
        return false;
    const rk_picture_difference d = rk_picture_difference_of(&driver->image, wanted, &shown);
    char place[4096];
    snprintf(place, sizeof place, "%.*s_difference.png", (int)(strlen(path) - 4), path);
    if (d.pixels == 0)
        remove(place);
    bool ok = d.pixels == 0 || rk_png_write(place, &shown, NULL, 0, error);
    rk_image_free(&shown);
    if (ok && d.pixels == 0)
        printf("%s: the picture is the same%s\n", driver->compared,
               rk_driver_has_stand_in(driver) && !driver->debug
                   ? ", but was traced through another tree, so it does not show yours"
                   : "");
    else if (ok)
        print_place(driver, &d, wanted, place);
    return ok;
}

static bool compare(const rk_driver *driver, const char *path, rk_error *error)
{
    rk_image wanted;
    if (!rk_image_file_read(&wanted, driver->compared, error))
        return false;
    const rk_image *drawn = &driver->image;
    bool same_size = wanted.width == drawn->width && wanted.height == drawn->height;
    bool ok = same_size ? print_difference(driver, path, &wanted, error)
                        : rk_fail(error,
                                  "--compare %s: it has %zu x %zu pixels; draw as many by --width "
                                  "and --height",
                                  driver->compared, wanted.width, wanted.height);
    rk_image_free(&wanted);
    return ok;
}

bool rk_driver_save(rk_driver *driver, const char *label, rk_error *error)
{
    char folder[3072], path[4096], seconds[32];
    if (!out_folder(driver, "figures", folder, error))
        return false;
    snprintf(path, sizeof path, "%s/%s_", folder, driver->feature);
    append_name(path, sizeof path, driver->scene.name);
    if (label) {
        strcat(path, "_");
        append_name(path, sizeof path, label);
    }
    strcat(path, ".png");
    snprintf(seconds, sizeof seconds, "%.6f", driver->render_ms.median / 1e3);
    if (!write_picture(driver, path, seconds, error))
        return false;
    if (!driver->quiet)
        print_caption(driver, path);
    return !driver->compared || compare(driver, path, error);
}

bool rk_driver_table(const rk_driver *driver, const char *name, char path[4096], rk_error *error)
{
    char folder[3072];
    if (!out_folder(driver, "tables", folder, error))
        return false;
    snprintf(path, 4096, "%s/%s.csv", folder, name);
    return true;
}

bool rk_driver_row(rk_driver *driver, const char *metric, const char *unit, rk_timing timing,
                   rk_error *error)
{
    char path[4096];
    if (!rk_driver_table(driver, driver->feature, path, error))
        return false;
    const rk_accel_title method = rk_accel_name(&driver->accel);
    const rk_timing_row row = {
        .feature = driver->feature,
        .scene = driver->scene.name,
        .triangles = driver->scene.mesh.triangle_count,
        .method = method.text,
        .isa = rk_accel_isa(driver->accel.kind),
        .threads = rk_pool_threads(driver->pool),
        .metric = metric,
        .unit = unit,
        .timing = timing,
    };
    if (!rk_table_put_timing(path, &row, error))
        return false;
    if (!driver->quiet)
        printf("%s: %s, %s %.6g%s%s\n", path, row.scene, metric, timing.median,
               strcmp(unit, "1") == 0 ? "" : " ", strcmp(unit, "1") == 0 ? "" : unit);
    return true;
}

bool rk_driver_count_rows(rk_driver *driver, rk_error *error)
{
    const rk_counters *counters = &driver->counters;
    const double pixels = (double)driver->render.width * driver->render.height;
    const struct {
        const char *metric;
        uint64_t count;
    } counts[] = {
        {"rays_per_pixel", rk_counters_rays(counters)},
        {"boxes_per_pixel", counters->box_tests},
        {"triangles_per_pixel", counters->triangle_tests},
    };
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof counts / sizeof *counts; i++)
        ok = rk_driver_row(driver, counts[i].metric, "1",
                           rk_timing_once((double)counts[i].count / pixels), error);
    return ok;
}

rk_timing rk_timing_once(double figure)
{
    return (rk_timing){figure, figure, figure, 1};
}
