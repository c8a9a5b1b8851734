#include "accel/accel.h"

#include "features/bvh_median.h"
#include "features/sah_binning.h"

#include <stdio.h>

/* --- Building --------------------------------------------------------------------------------- */

static bool build_tree(rk_bvh *bvh, const rk_accel *accel, const rk_mesh *mesh, rk_error *error)
{
    if (accel->kind == RK_ACCEL_MEDIAN)
        return rk_bvh_build_median(bvh, mesh, error);
    const rk_sah_options options = {accel->bins, accel->kind == RK_ACCEL_SAH_3};
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

static bool check_method(const rk_accel *accel, rk_error *error)
{
    if (accel->kind > RK_ACCEL_SAH_3)
        return rk_fail(error, "the kind is %u, but rk_accel_kind goes from 0 to %u", accel->kind,
                       RK_ACCEL_SAH_3);
    if (accel->kind != RK_ACCEL_MEDIAN && (accel->bins < 2 || accel->bins > RK_SAH_BINS_MAX))
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

bool rk_accel_build_binned(rk_accel *accel, rk_accel_kind kind, uint32_t bins,
                           const rk_scene *scene, rk_error *error)
{
    *accel = (rk_accel){.kind = kind, .bins = bins, .scene = scene};
    uint32_t still = 0;
    bool ok = check_method(accel, error) && check_moving(scene, &still, error) &&
              build_part(&accel->bvh, accel, 0, still, error);
    for (uint32_t i = 0; ok && i < scene->moving_count; i++)
        ok = build_part(&accel->moving[i], accel, scene->moving[i].first, scene->moving[i].count,
                        error);
    if (!ok)
        rk_accel_free(accel);
    return ok;
}

bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error)
{
    return rk_accel_build_binned(accel, kind, rk_sah_options_default().bins, scene, error);
}

void rk_accel_free(rk_accel *accel)
{
    rk_bvh_free(&accel->bvh);
    for (uint32_t i = 0; i < RK_MOVING_MAX; i++)
        rk_bvh_free(&accel->moving[i]);
}

rk_accel_title rk_accel_name(const rk_accel *accel)
{
    rk_accel_title title = {"median"};
    if (accel->kind != RK_ACCEL_MEDIAN)
        snprintf(title.text, sizeof title.text, "sah%u%s", accel->bins,
                 accel->kind == RK_ACCEL_SAH_3 ? "_3" : "");
    return title;
}

const char *rk_accel_isa(rk_accel_kind kind)
{
    (void)kind;
    return "scalar";
}
