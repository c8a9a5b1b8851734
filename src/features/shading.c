/* The light that a surface sends to the viewer: a diffuse part, the same in all directions, and a
 * highlight around the mirror direction of the light.
 * Phong, "Illumination for computer generated pictures", 1975; Blinn, "Models of light reflection
 * for computer synthesized pictures", 1977. Normalized: Lafortune and Willems, "Using the modified
 * Phong reflectance model for physically based rendering", 1994; Giesen, "Derivation of
 * Phong and Blinn-Phong BRDF normalization factors", 2009. */
#include "features/shading.h"

#include "base/colour.h"

#include <stddef.h>

/* Contents, in the order of the chapter. */
static float phong_lobe(float shininess, rk_vec3 n, rk_vec3 l, rk_vec3 v);
static float blinn_phong_lobe(float shininess, rk_vec3 n, rk_vec3 l, rk_vec3 v);
static float power_of_cosine(rk_vec3 a, rk_vec3 b, float s);
static float normalizer(rk_shading_model model, float s);

/* --- Highlights ------------------------------------------------------------------------------- */

static float phong_lobe(float shininess, rk_vec3 n, rk_vec3 l, rk_vec3 v)
{
    /* solution */
    rk_vec3 r = rk_sub(rk_scale(n, 2 * rk_dot(n, l)), l);
    return power_of_cosine(r, v, shininess);
    /* starter
    // Second step: the cosine between the mirror direction and the viewer's, to a power.
    return 0;
    end */
}

/* Opposite directions have no half vector, and no highlight. */
static float blinn_phong_lobe(float shininess, rk_vec3 n, rk_vec3 l, rk_vec3 v)
{
    /* solution */
    rk_vec3 sum = rk_add(l, v);
    if (!(rk_dot(sum, sum) > 0))
        return 0;
    return power_of_cosine(n, rk_normalize(sum), shininess);
    /* starter
    // Third step: the cosine between the normal and the half vector, to a power.
    return 0;
    end */
}

/* --- Diffuse light and highlight together ----------------------------------------------------- */

rk_vec3 rk_shade(const rk_shading *shading, rk_vec3 kd, rk_vec3 ks, float shininess, rk_vec3 n,
                 rk_vec3 l, rk_vec3 v, rk_vec3 light_colour)
{
    /* solution */
    rk_shading_model model = shading->model;
    if (model == RK_SHADING_OFF)
        return rk_mul(light_colour, kd);
    float cos_i = rk_dot(n, l);
    if (model == RK_SHADING_GRADIENT)
        return rk_mul(light_colour, rk_gradient_at(&shading->gradient, cos_i));
    if (!(cos_i > 0))
        return rk_vec(0, 0, 0);
    float diffuse = shading->normalized ? cos_i / RK_PI : cos_i;
    if (model == RK_SHADING_LAMBERT || rk_is_black(ks))
        return rk_mul(light_colour, rk_scale(kd, diffuse));
    float highlight = model == RK_SHADING_PHONG ? phong_lobe(shininess, n, l, v)
                                                : blinn_phong_lobe(shininess, n, l, v);
    if (shading->normalized && highlight > 0)
        highlight *= normalizer(model, shininess) * cos_i;
    return rk_mul(light_colour, rk_madd(rk_scale(kd, diffuse), ks, highlight));
    /* starter
    // First step: off, and Lambert. Second step: Phong. Third step: Blinn-Phong. Fifth step:
    // normalized. Sixth step: the gradient. Until then surfaces are grey by their angle to the
    // light, on both sides.
    return rk_scale(light_colour, fabsf(rk_dot(n, l)));
    end */
}

/* --- Sharp highlights ------------------------------------------------------------------------- */

/* (a.b)^s for unit vectors, 0 from a right angle on. Near 1, where sharp highlights are, a.b has
 * lost the digits that matter: an error of 1e-7 becomes one of 1e-2 in the power of 1e5. The
 * difference of two vectors that are close together is nearly exact, and 1 - a.b is half of its
 * squared length. */
static float power_of_cosine(rk_vec3 a, rk_vec3 b, float s)
{
    /* solution */
    const float vanishing = 104; /* e^-104 is less than half of the smallest float */
    rk_vec3 apart = rk_sub(a, b);
    float short_of_one = 0.5f * rk_dot(apart, apart);
    if (!(short_of_one < 1) || s * short_of_one > vanishing)
        return 0;
    return expf(s * log1pf(-short_of_one));
    /* starter
    // Second step: powf of the dot product will do, where it is positive. Fourth step: 1 - a.b from
    // the vectors' difference, and the power by log1pf and expf.
    return 0;
    end */
}

/* --- Normalized ------------------------------------------------------------------------------- */

/* One over the integral of the lobe times n.l for light along the normal; for light from any other
 * direction the integral is smaller. */
static float normalizer(rk_shading_model model, float s)
{
    /* solution */
    if (model == RK_SHADING_PHONG)
        return (s + 2) / (2 * RK_PI);
    /* In this order the product of two large numbers cannot overflow. */
    return (s + 2) / (8 * RK_PI) * ((s + 4) / (exp2f(-0.5f * s) + s));
    /* starter
    // Fifth step: the factors N of the header.
    return 1;
    end */
}

/* --- The gradient ----------------------------------------------------------------------------- */

/* One pass finds the two neighbours of x, whatever the order of the stops. */
rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x)
{
    /* solution */
    const rk_gradient_stop *below = NULL, *above = NULL; /* below.at <= x < above.at */
    for (uint32_t i = 0; i < gradient->count; i++) {
        const rk_gradient_stop *stop = &gradient->stops[i];
        if (stop->at <= x)
            below = !below || stop->at >= below->at ? stop : below;
        else
            above = !above || stop->at < above->at ? stop : above;
    }
    if (!below || !above)
        return below ? below->colour : above ? above->colour : rk_vec(0, 0, 0);
    double start = (double)below->at; /* the distance of two floats may exceed the largest float */
    double fraction = ((double)x - start) / ((double)above->at - start);
    return rk_mix(below->colour, above->colour, (float)fraction);
    /* starter
    // Sixth step: the highest stop at or below x, the lowest above it, and the mix of the two.
    return rk_vec(1, 0, 1);
    end */
}

rk_gradient rk_gradient_cool_to_warm(void)
{
    return (rk_gradient){2, {{-1, {0.02f, 0.04f, 0.4f}}, {1, {1, 0.6f, 0.2f}}}};
}
