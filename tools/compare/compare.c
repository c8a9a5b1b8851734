/* raykit beside another renderer, Blender's Cycles: writes scenes and raykit's pictures of them,
 * and compares these with the other renderer's. `make compare` runs it (tools/compare/compare.sh).
 */
#include "base/file.h"
#include "base/options.h"
#include "base/table.h"
#include "driver/compared_scene.h"
#include "driver/region_ratio.h"
#include "driver/scene_json.h"
#include "io/image_file.h"
#include "io/png.h"
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

RK_NAMES(shown_names, picture to show, 3, "nothing", "raykit", "cycles", "difference");

enum { show_nothing, show_raykit, show_cycles, show_difference };

typedef struct choices {
    bool export, table, check, quiet;
    uint32_t scene, show;
    uint32_t side, samples;
    const char *pictures, *out;
} choices;

static const char summary[] =
    "Compares raykit's pictures with those of Blender's Cycles; make compare runs it.";

static const rk_option rows[] = {
    {"export", RK_FIELD(choices, export), NULL,
     "write the scenes, and raykit's two pictures of each"},
    {"table", RK_FIELD(choices, table), NULL,
     "put the ratio of the pictures in each region into OUT/tables/compare.csv"},
    {"check", RK_FIELD(choices, check), NULL, "with --table: fail if the renderers disagree"},
    {"scene", RK_CHOICE(choices, scene, rk_compared_names), "the scene of --show"},
    {"show", RK_CHOICE(choices, show, shown_names),
     "draw a picture into OUT/figures: the mean of two, or 8 times the difference of the means"},
    {"side", RK_FIELD(choices, side), "N", "width and height of exported pictures, pixels", 1, 4096,
     192},
    {"samples", RK_FIELD(choices, samples), "N", "samples per pixel of raykit's pictures", 1, 65536,
     256},
    {"pictures", RK_FIELD(choices, pictures), "DIR", "the folder of scenes and EXR pictures",
     .initial_text = RK_BUILD_FOLDER "/compare"},
    {"quiet", RK_FIELD(choices, quiet), NULL, "print no lines of the table"},
    {"out", RK_FIELD(choices, out), "DIR", "the folder of figures and tables",
     .initial_text = "out"},
    {0},
};

typedef struct path {
    char text[4096];
} path;

/* FOLDER/SCENE and the suffix. */
static path path_of(const char *folder, rk_compared_kind kind, const char *suffix)
{
    path p;
    snprintf(p.text, sizeof p.text, "%s/%s%s", folder, rk_compared_names.items[kind], suffix);
    return p;
}

/* --- Exporting ------------------------------------------------------------------------------- */

static bool render(const rk_compared_scene *c, const rk_accel *accel, rk_pool *pool, const char *to,
                   rk_error *error)
{
    rk_image image;
    rk_counters counters;
    if (!rk_image_init(&image, c->options.width, c->options.height, error))
        return false;
    bool ok = rk_render(&image, &c->scene, accel, &c->options, pool, &counters, NULL, error) &&
              rk_image_file_write(to, &image, error);
    rk_image_free(&image);
    return ok;
}

static bool render_pair(rk_compared_scene *c, rk_compared_kind kind, const char *folder,
                        rk_pool *pool, rk_error *error)
{
    rk_accel accel;
    if (!rk_accel_build(&accel, RK_ACCEL_WIDE, &c->scene, error))
        return false;
    c->options.seed = 1;
    bool ok = render(c, &accel, pool, path_of(folder, kind, "_raykit_1.exr").text, error);
    c->options.seed = 2;
    ok = ok && render(c, &accel, pool, path_of(folder, kind, "_raykit_2.exr").text, error);
    rk_accel_free(&accel);
    return ok;
}

static bool export_scene(const choices *chosen, rk_compared_kind kind, rk_pool *pool,
                         rk_error *error)
{
    rk_compared_scene c;
    if (!rk_compared_scene_init(&c, kind, chosen->side, chosen->samples, error))
        return false;
    bool ok = rk_scene_json_write(path_of(chosen->pictures, kind, ".json").text, &c.scene,
                                  &c.options, error) &&
              render_pair(&c, kind, chosen->pictures, pool, error);
    rk_compared_scene_free(&c);
    return ok;
}

static bool export_all(const choices *chosen, rk_error *error)
{
    rk_pool *pool = NULL;
    bool ok =
        rk_file_make_folder(chosen->pictures, error) && (pool = rk_pool_start(0, error)) != NULL;
    for (uint32_t kind = 0; ok && kind < RK_COMPARED_COUNT; kind++)
        ok = export_scene(chosen, kind, pool, error);
    rk_pool_stop(pool);
    return ok;
}

/* --- Reading --------------------------------------------------------------------------------- */

typedef struct pictures {
    rk_picture_pair ours, theirs;
} pictures;

static void release(pictures *p)
{
    rk_image_free(&p->ours.first);
    rk_image_free(&p->ours.second);
    rk_image_free(&p->theirs.first);
    rk_image_free(&p->theirs.second);
}

static bool are_squares_of_one_size(const pictures *p)
{
    const rk_image *all[] = {&p->ours.first, &p->ours.second, &p->theirs.first, &p->theirs.second};
    for (int i = 0; i < 4; i++)
        if (all[i]->width != all[0]->width || all[i]->height != all[0]->width)
            return false;
    return true;
}

/* Reads SCENE_NAME.exr. */
static bool read_one(rk_image *image, const choices *chosen, rk_compared_kind kind,
                     const char *name, rk_error *error)
{
    const path from = path_of(chosen->pictures, kind, name);
    if (access(from.text, R_OK) != 0)
        return rk_fail(error, "%s: there is no such picture; make compare renders it", from.text);
    return rk_image_file_read(image, from.text, error);
}

static bool read_pairs(pictures *p, const choices *chosen, rk_compared_kind kind, rk_error *error)
{
    *p = (pictures){0};
    bool ok = read_one(&p->ours.first, chosen, kind, "_raykit_1.exr", error) &&
              read_one(&p->ours.second, chosen, kind, "_raykit_2.exr", error) &&
              read_one(&p->theirs.first, chosen, kind, "_cycles_1.exr", error) &&
              read_one(&p->theirs.second, chosen, kind, "_cycles_2.exr", error);
    if (ok && !are_squares_of_one_size(p))
        ok = rk_fail(error, "%s: its pictures of %s have different sizes; run make compare again",
                     chosen->pictures, rk_compared_names.items[kind]);
    if (!ok)
        release(p);
    return ok;
}

/* --- The table ------------------------------------------------------------------------------- */

static bool put_row(const choices *chosen, rk_compared_kind kind, const char *region,
                    const rk_region_ratio *found, bool *agree, rk_error *error)
{
    static const char *const header[] = {
        "scene", "region", "pixels", "ratio", "difference_percent", "error_percent", "verdict"};
    char file[4096], pixels[32], ratio[32], difference[32], noise[32];
    const rk_agreement agreement = rk_region_ratio_agreement(found);
    const char *verdict = rk_agreement_names.items[agreement];
    snprintf(pixels, sizeof pixels, "%zu", found->pixels);
    snprintf(ratio, sizeof ratio, "%.5f", found->ratio);
    /* Adding 0 makes a negative zero positive. */
    snprintf(difference, sizeof difference, "%.3f", rint(1e5 * (found->ratio - 1)) / 1e3 + 0.0);
    snprintf(noise, sizeof noise, "%.3f", 100 * found->standard_error);
    snprintf(file, sizeof file, "%s/tables/compare.csv", chosen->out);
    const char *cells[] = {
        rk_compared_names.items[kind], region, pixels, ratio, difference, noise, verdict};
    if (!chosen->quiet)
        printf("%-8s %-16s %6s pixels  ratio %s +- %.5f  %s\n", cells[0], region, pixels, ratio,
               found->standard_error, verdict);
    *agree = *agree && agreement == RK_AGREE;
    return rk_table_put(file, header, cells, sizeof cells / sizeof *cells, 2, error);
}

static bool put_regions(const choices *chosen, rk_compared_kind kind, const pictures *p,
                        const uint8_t *regions, bool *agree, rk_error *error)
{
    rk_region_ratio found = rk_region_ratio_of(&p->ours, &p->theirs, regions, RK_REGION_ALL);
    bool ok = put_row(chosen, kind, "whole picture", &found, agree, error);
    for (unsigned i = RK_REGION_NONE + 1; ok && i < RK_REGION_COUNT; i++) {
        found = rk_region_ratio_of(&p->ours, &p->theirs, regions, i);
        if (found.pixels > 0)
            ok = put_row(chosen, kind, rk_compared_region_names.items[i], &found, agree, error);
    }
    return ok;
}

static bool put_scene(const choices *chosen, rk_compared_kind kind, bool *agree, rk_error *error)
{
    pictures p;
    rk_compared_scene c;
    if (!read_pairs(&p, chosen, kind, error))
        return false;
    const uint32_t side = (uint32_t)p.ours.first.width;
    if (!rk_compared_scene_init(&c, kind, side, 1, error)) {
        release(&p);
        return false;
    }
    uint8_t *regions = rk_allocate((size_t)side * side, sizeof *regions, "regions", error);
    bool ok = regions && rk_compared_regions(&c, regions, error) &&
              put_regions(chosen, kind, &p, regions, agree, error);
    free(regions);
    rk_compared_scene_free(&c);
    release(&p);
    return ok;
}

static bool put_table(const choices *chosen, rk_error *error)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%s/tables", chosen->out);
    bool agree = true, ok = rk_file_make_folder(folder, error);
    for (uint32_t kind = 0; ok && kind < RK_COMPARED_COUNT; kind++)
        ok = put_scene(chosen, kind, &agree, error);
    if (ok && !agree && chosen->check)
        return rk_fail(
            error,
            "the renderers do not agree: in the regions above without the word \"agree\", the "
            "ratio is off by more than %g and 3 standard errors, or their noise is too large",
            RK_RATIO_TOLERANCE);
    return ok;
}

/* --- Figures --------------------------------------------------------------------------------- */

static void draw(rk_image *shown, const choices *chosen, const pictures *p)
{
    const float times = 8;
    if (chosen->show == show_difference)
        rk_picture_pair_difference(shown, &p->ours, &p->theirs, times);
    else
        rk_picture_pair_mean(shown, chosen->show == show_raykit ? &p->ours : &p->theirs);
}

static bool save(const choices *chosen, const rk_image *shown, rk_error *error)
{
    char folder[3072], file[4096];
    const char *scene = rk_compared_names.items[chosen->scene],
               *what = shown_names.items[chosen->show];
    if (snprintf(folder, sizeof folder, "%s/figures", chosen->out) >= (int)sizeof folder)
        return rk_fail(error, "--out: the folder's name is longer than 3000 bytes");
    snprintf(file, sizeof file, "%s/compare_%s_%s.png", folder, scene, what);
    const rk_png_text text = {"Software", "raykit " PACKAGE_VERSION};
    if (!rk_file_make_folder(folder, error) || !rk_png_write(file, shown, &text, 1, error))
        return false;
    printf("%s: %s, %s, %zu x %zu, raykit %s\n", file, scene, what, shown->width, shown->height,
           PACKAGE_VERSION);
    return true;
}

static bool show(const choices *chosen, rk_error *error)
{
    pictures p;
    rk_image shown;
    if (!read_pairs(&p, chosen, chosen->scene, error))
        return false;
    bool ok = rk_image_init(&shown, p.ours.first.width, p.ours.first.height, error);
    if (ok) {
        draw(&shown, chosen, &p);
        ok = save(chosen, &shown, error);
        rk_image_free(&shown);
    }
    release(&p);
    return ok;
}

/* --- Main ------------------------------------------------------------------------------------ */

static bool work(const choices *chosen, rk_error *error)
{
    if (!chosen->export && !chosen->table && !chosen->show)
        return rk_fail(error, "nothing to do: give --export, --table or --show; --help lists all");
    return (!chosen->export || export_all(chosen, error)) &&
           (!chosen->table || put_table(chosen, error)) && (!chosen->show || show(chosen, error));
}

int main(int argc, char **argv)
{
    rk_error error = {""};
    choices chosen;
    rk_options_set_defaults(rows, &chosen);
    const rk_option_table table = {rows, &chosen};
    const rk_options_result result = rk_options_parse(argc, argv, summary, &table, 1, &error);
    if (result == RK_OPTIONS_DONE || (result == RK_OPTIONS_OK && work(&chosen, &error)))
        return 0;
    fprintf(stderr, "compare: %s\n", error.text);
    return 1;
}
