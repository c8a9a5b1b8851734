/* Gathers the crossings of a path, and asks the feature for their weights: the fractions of the
 * light that arrive from each. */
#include "render/stages/transparency_stage.h"

#include "render/ray_record.h"
#include "render/stages/trace_transparent.h"

void rk_transparency_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                           uint32_t i, rk_visible_hits *visible)
{
    rk_crossing_list list;
    visible->time = rk_trace_crossings(r, pass, paths, i, &list).time;
    rk_transparency_weights(list.crossings, list.count, visible->weights, &visible->behind);
    if (list.count == list.limit)
        visible->behind = 0;
    visible->count = list.count;
    for (uint32_t k = 0; k < list.count; k++)
        visible->hits[k] = rk_crossing_hit(&list.crossings[k]);
    if (r->record)
        rk_ray_record_path(r, pass, paths, i, &list);
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_glass_model_names, rk_glass_model, RK_GLASS_BEER_LAMBERT, "multiplicative", "ordered",
         "beer-lambert");

static const rk_option rows[] = {
    {"transparency", RK_FIELD(rk_render_options, transparency), NULL,
     "surfaces with an opacity below 1 transmit light, and their shadows are coloured"},
    {"glass", RK_CHOICE(rk_render_options, glass, rk_glass_model_names),
     "model of coloured shadows", .initial = RK_GLASS_ORDERED},
    {0},
};

static bool is_transparent(const rk_material *material)
{
    return material->alpha < 1;
}

/* Rays go on through what is cut out, also where all else is opaque. */
static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return (options->transparency && rk_plan_any_material(scene, is_transparent)) ||
           rk_mesh_has_cutouts(&scene->mesh);
}

const rk_feature rk_transparency_feature = {
    .stem = "transparency",
    .options = rows,
    .takes = "--transparency and a material that is not opaque, or one that a picture cuts out",
    .wanted = wanted};
