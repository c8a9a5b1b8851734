/* Surfaces in the colours of their normals (render/feature.h), added to the light that they
 * reflect. */
#include "render/feature.h"

#include "features/normals.h"
#include "render/film.h"
#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"

/* A sphere has no triangle; where it is flat, it is as flat as it is smooth. */
static rk_vec3 flat_normal(const rk_surface *surface)
{
    const rk_triangle *t = &surface->triangle;
    if (t->index == RK_MISS)
        return surface->face_normal;
    rk_vec3 n = rk_normals_of_triangle(t->a, t->b, t->c);
    return rk_dot(n, surface->face_normal) < 0 ? rk_negate(n) : n;
}

/* The colour that the surface shows, on the side of the viewer. */
static rk_vec3 colour_of(rk_normals_shown shown, const rk_surface *surface)
{
    return rk_normals_colour(shown == RK_NORMALS_FLAT ? flat_normal(surface) : surface->normal);
}

static void shade(const rk_rendering *r, rk_sample_pass *pass, const rk_shading_points *points,
                  rk_film *film)
{
    (void)pass;
    for (uint32_t i = 0; i < points->count; i++) {
        const rk_shading_point *point = &points->points[i];
        rk_vec3 colour = colour_of(r->options->normals, &point->surface);
        rk_film_add(film, point->pixel, rk_mul(point->path.throughput, colour));
    }
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_normals_shown_names, rk_normals_shown, RK_NORMALS_FLAT, "none", "smooth", "flat");

static const rk_option rows[] = {
    {"normals", RK_CHOICE(rk_render_options, normals, rk_normals_shown_names),
     "surfaces add the colours of their normals to the light that they reflect"},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return options->normals != RK_NORMALS_NONE &&
           (scene->mesh.triangle_count > 0 || scene->sphere_count > 0);
}

const rk_feature rk_normals_feature = {.stem = "normals",
                                       .options = rows,
                                       .takes = "a surface",
                                       .wanted = wanted,
                                       .shines = true,
                                       .shade = shade};
