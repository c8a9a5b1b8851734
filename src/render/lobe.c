/* A direction is drawn around the lobe's axis by a power of the cosine: for Phong the axis is the
 * mirror direction; for Blinn and Phong it is the normal, and the half vector is drawn. */
#include "render/lobe.h"

#include "base/reflect.h"
#include "features/glossy_reflection.h"

rk_lobe rk_lobe_of(rk_shading_model model, float shininess, rk_vec3 normal, rk_vec3 to_viewer)
{
    rk_lobe lobe = {
        .model = model, .shininess = shininess, .normal = normal, .to_viewer = to_viewer};
    lobe.axis =
        model == RK_SHADING_PHONG ? rk_normalize(rk_reflect(rk_negate(to_viewer), normal)) : normal;
    rk_basis_of(lobe.axis, &lobe.u, &lobe.v);
    return lobe;
}

/* The density (s + 1) / (2 pi) cos^s is that of cos = (1 - xi.x)^(1 / (s + 1)). The sine comes from
 * the exponent: 1 - cos^2 of a sharp lobe would have lost its digits. */
static rk_vec3 around_axis(const rk_lobe *lobe, rk_vec2 xi)
{
    float exponent = log1pf(-xi.x) / (lobe->shininess + 1), phi = 2 * RK_PI * xi.y;
    float sine = sqrtf(-expm1f(2 * exponent));
    rk_vec3 aside = rk_madd(rk_scale(lobe->u, cosf(phi)), lobe->v, sinf(phi));
    return rk_madd(rk_scale(lobe->axis, expf(exponent)), aside, sine);
}

bool rk_lobe_direction(const rk_lobe *lobe, rk_vec2 xi, rk_vec3 *to_light)
{
    rk_vec3 direction = around_axis(lobe, xi);
    *to_light = lobe->model == RK_SHADING_PHONG ? direction
                                                : rk_reflect(rk_negate(lobe->to_viewer), direction);
    /* A half vector away from the viewer reflects nothing to it. */
    return rk_dot(lobe->normal, *to_light) > 0 && rk_dot(direction, *to_light) > 0;
}

double rk_lobe_density(const rk_lobe *lobe, rk_vec3 to_light)
{
    const rk_shading shading = {.model = lobe->model};
    const rk_vec3 black = {0, 0, 0}, white = {1, 1, 1};
    rk_vec3 power = rk_shade(&shading, black, white, lobe->shininess, lobe->normal, to_light,
                             lobe->to_viewer, white);
    double density = ((double)lobe->shininess + 1) / (2 * RK_PI_DOUBLE) * (double)power.x;
    if (lobe->model == RK_SHADING_PHONG || !(density > 0))
        return density;
    rk_vec3 half = rk_normalize(rk_add(to_light, lobe->to_viewer));
    return density / (4 * (double)rk_dot(half, lobe->to_viewer));
}
