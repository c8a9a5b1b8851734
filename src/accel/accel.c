/* A tree over the static triangles, and one for each moving object, because rays are moved and the
 * objects stay. An object that moves also has its boxes as a binary tree: the time stage reads
 * them. */
#include "accel/accel.h"

#include "accel/build/wide_build.h"
#include "accel/kernel/wide_kernel.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"
#include "features/wide_bvh.h"

#include <stdio.h>

/* --- Building --------------------------------------------------------------------------------- */

static bool has_bins(rk_accel_kind kind)
{
    return kind == RK_ACCEL_SAH || kind == RK_ACCEL_SAH_3 || kind == RK_ACCEL_COLLAPSED;
}

static bool build_tree(rk_bvh *bvh, const rk_accel *accel, const rk_mesh *mesh, rk_error *error)
{
    if (accel->kind == RK_ACCEL_MEDIAN)
        return rk_bvh_build_median(bvh, mesh, error);
    rk_sah_options options = rk_sah_options_default();
    if (has_bins(accel->kind))
        options = (rk_sah_options){accel->bins, accel->kind != RK_ACCEL_SAH};
    return rk_bvh_build_sah(bvh, mesh, &options, error);
}

/* A tree over a part of the mesh's triangles, which keep their indices. */
static bool build_part(rk_bvh *bvh, const rk_accel *accel, uint32_t first, uint32_t count,
                       rk_error *error)
{
    rk_mesh part = accel->scene->mesh;
    part.triangle_count = count;
    if (first > 0) {
        part.triangles += first;
        part.triangle_materials += first;
    }
    if (!build_tree(bvh, accel, &part, error))
        return false;
    for (uint32_t i = 0; first > 0 && i < count; i++)
        bvh->triangles[i].index += first;
    return true;
}

/* Straight from the mesh, without a binary tree. */
static bool is_built_wide(rk_accel_kind kind)
{
    return kind == RK_ACCEL_MORTON || kind == RK_ACCEL_WIDE;
}

static bool check_method(const rk_accel *accel, rk_error *error)
{
    if (accel->kind > RK_ACCEL_WIDE)
        return rk_fail(error, "the kind is %u, but rk_accel_kind goes from 0 to %u", accel->kind,
                       RK_ACCEL_WIDE);
    if (has_bins(accel->kind) && (accel->bins < 2 || accel->bins > RK_SAH_BINS_MAX))
        return rk_fail(error, "there are 2 to %d bins, not %u", RK_SAH_BINS_MAX, accel->bins);
    return true;
}

/* Fills in the number of static triangles. */
static bool check_moving(const rk_scene *scene, uint32_t *still, rk_error *error)
{
    uint32_t end = scene->mesh.triangle_count;
    if (scene->moving_count > RK_MOVING_MAX)
        return rk_fail(error, "%s: %u objects move, but at most %d can", scene->name,
                       scene->moving_count, RK_MOVING_MAX);
    for (uint32_t i = scene->moving_count; i > 0; i--) {
        const rk_moving *object = &scene->moving[i - 1];
        if (object->count < 1 || object->count > end || object->first != end - object->count)
            return rk_fail(error,
                           "%s: moving object %u has %u triangles from %u on: moving objects are a "
                           "mesh's last triangles, one after the other",
                           scene->name, i - 1, object->count, object->first);
        end = object->first;
    }
    *still = end;
    return true;
}

/* The trees over a part of the mesh, those that the kind has. */
static bool build_trees(rk_bvh *bvh, rk_wide_bvh *wide, const rk_accel *accel, uint32_t first,
                        uint32_t count, rk_pool *pool, rk_error *error)
{
    if (is_built_wide(accel->kind))
        return rk_wide_bvh_build_parts(
            wide, &accel->scene->mesh, first, count,
            accel->kind == RK_ACCEL_WIDE ? RK_BUILD_SAH : RK_BUILD_MORTON, pool, error);
    return build_part(bvh, accel, first, count, error) &&
           (accel->kind != RK_ACCEL_COLLAPSED || rk_wide_bvh_build(wide, bvh, error));
}

/* The shutter's stage needs binary boxes. */
static bool build_moving(rk_accel *accel, uint32_t i, rk_pool *pool, rk_error *error)
{
    const rk_moving *object = &accel->scene->moving[i];
    return build_trees(&accel->moving[i], &accel->wide_moving[i], accel, object->first,
                       object->count, pool, error) &&
           (!is_built_wide(accel->kind) ||
            rk_bvh_of_wide(&accel->moving[i], &accel->wide_moving[i], error));
}

rk_accel_options rk_accel_options_default(void)
{
    return (rk_accel_options){RK_ACCEL_WIDE, rk_sah_options_default().bins, NULL};
}

bool rk_accel_build_with(rk_accel *accel, const rk_accel_options *options, const rk_scene *scene,
                         rk_error *error)
{
    *accel = (rk_accel){.kind = options->kind,
                        .bins = options->bins,
                        .scene = scene,
                        .has_cutouts = rk_mesh_has_cutouts(&scene->mesh)};
    uint32_t still = 0;
    bool ok = check_method(accel, error) && check_moving(scene, &still, error);
    if (options->kind == RK_ACCEL_COLLAPSED)
        accel->kernel = rk_wide_kernel_plain();
    if (ok && is_built_wide(options->kind))
        ok = (accel->kernel = rk_wide_kernel_chosen(error)) != NULL;
    ok = ok && build_trees(&accel->bvh, &accel->wide, accel, 0, still, options->pool, error);
    for (uint32_t i = 0; ok && i < scene->moving_count; i++)
        ok = build_moving(accel, i, options->pool, error);
    if (!ok)
        rk_accel_free(accel);
    return ok;
}

bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error)
{
    rk_accel_options options = rk_accel_options_default();
    options.kind = kind;
    return rk_accel_build_with(accel, &options, scene, error);
}

void rk_accel_free(rk_accel *accel)
{
    rk_bvh_free(&accel->bvh);
    for (uint32_t i = 0; i < RK_MOVING_MAX; i++)
        rk_bvh_free(&accel->moving[i]);
    rk_wide_bvh_free(&accel->wide);
    for (uint32_t i = 0; i < RK_MOVING_MAX; i++)
        rk_wide_bvh_free(&accel->wide_moving[i]);
    accel->kernel = NULL;
}

rk_accel_title rk_accel_name(const rk_accel *accel)
{
    static const char *const names[] = {"median", "sah", "sah", "collapsed", "morton", "wide"};
    static const char *const axes[] = {"", "", "_3", "", "", ""};
    rk_accel_title title;
    if (has_bins(accel->kind))
        snprintf(title.text, sizeof title.text, "%s%u%s", names[accel->kind], accel->bins,
                 axes[accel->kind]);
    else
        snprintf(title.text, sizeof title.text, "%s", names[accel->kind]);
    return title;
}

const char *rk_accel_isa(rk_accel_kind kind)
{
    return is_built_wide(kind) ? rk_wide_kernel_best()->isa : rk_wide_kernel_plain()->isa;
}
