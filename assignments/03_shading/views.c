/* The debug view: the lobes of a model over a plane. */
#include "driver.h"

#include <string.h>

static const rk_vec3 white = {1, 1, 1};

rk_vec3 at_angle(float degrees)
{
    float angle = degrees * 0.01745329f;
    return rk_vec(-sinf(angle), cosf(angle), 0);
}

float lobe(rk_shading_model model, bool normalized, float shininess, rk_vec3 l, rk_vec3 v)
{
    const rk_shading shading = {.model = model, .normalized = normalized};
    return rk_shade(&shading, rk_vec(0, 0, 0), white, shininess, up, l, v, white).x;
}

bool make_plane(rk_driver *driver, rk_error *error)
{
    rk_mesh plane;
    if (!rk_mesh_init(&plane, 4, 2, 1, 0, error))
        return false;
    for (uint32_t i = 0; i < 4; i++)
        plane.positions[i] = rk_vec(i & 1 ? 1.3f : -1.3f, 0, i & 2 ? 0.5f : -0.5f);
    plane.materials[0].kd = rk_vec(0.15f, 0.15f, 0.15f);
    memcpy(plane.triangles, (uint32_t[2][3]){{0, 2, 1}, {1, 2, 3}}, sizeof(uint32_t[2][3]));
    rk_scene_free(&driver->scene);
    driver->scene = (rk_scene){
        .name = "lobe",
        .mesh = plane,
        .camera = {{0, 0.5f, 0}, 4, {10, 0, 0}, 24},
        .light_count = 1,
        .lights = {rk_light_point(rk_vec(0, 8, 0), white)},
    };
    return true;
}

/* Each lobe as a curve whose distance from the point is the light reflected in that direction;
 * directions are denser around the mirror direction, where sharp lobes are. */
static void draw_lobes(rk_overlay *overlay, rk_shading_model model, float incidence)
{
    const rk_vec3 point = {0, 0, 0}, l = at_angle(-incidence);
    rk_overlay_line(overlay, point, up, rk_vec(0.5f, 0.5f, 0.5f), 1);
    rk_overlay_line(overlay, point, rk_scale(at_angle(incidence), 1.15f), white, 1);
    rk_overlay_line(overlay, rk_scale(l, 1.3f), point, rk_vec(1, 0.9f, 0.3f), 4);
    for (uint32_t i = 0; i < shown; i++) {
        rk_vec3 last = point;
        for (int k = -200; k <= 200; k++) {
            float offset = (float)k / 200, angle = incidence + 180 * offset * offset * offset;
            rk_vec3 v = at_angle(rk_max(-90, rk_min(angle, 90)));
            rk_vec3 next = rk_scale(v, lobe(model, false, shininess_shown[i], l, v));
            rk_overlay_line(overlay, last, next, rk_overlay_colour(i), 3);
            last = next;
        }
        rk_overlay_line(overlay, last, point, rk_overlay_colour(i), 3);
    }
}

bool draw_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_overlay overlay;
    if (!rk_driver_render_overlay(driver, &overlay, error))
        return false;
    draw_lobes(&overlay, driver->render.shading.model, c->incidence);
    rk_overlay_free(&overlay);
    return true;
}
