/* The table of --radiance: what a surface reflects of white light, by the viewer's angle. */
#include "driver.h"

#include "driver/number_row.h"

/* By default as much is diffuse as is specular, with a highlight that is seen well. */
static float given_or(float given, float usual)
{
    return isnan(given) ? usual : given;
}

bool put_radiance(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_vec3 white = {1, 1, 1}, black = {0, 0, 0}, l = at_angle(-c->incidence);
    const float ks = given_or(c->ks, 0.5f), shininess = given_or(c->shininess, 30);
    const rk_vec3 kd = rk_scale(white, 1 - ks), specular = rk_scale(white, ks);
    const rk_shading *shading = &driver->render.shading;
    for (int k = -180; k <= 180; k++) {
        const float angle = 0.5f * (float)k;
        const rk_vec3 v = at_angle(angle);
        const rk_vec3 both = rk_shade(shading, kd, specular, shininess, up, l, v, white);
        const rk_vec3 diffuse = rk_shade(shading, kd, black, shininess, up, l, v, white);
        const rk_vec3 highlight = rk_shade(shading, black, specular, shininess, up, l, v, white);
        const double numbers[] = {(double)c->incidence, (double)angle, (double)both.x,
                                  (double)diffuse.x, (double)highlight.x};
        if (!rk_driver_number_row(driver, "shading_radiance",
                                  "incidence angle radiance diffuse highlight", 2, numbers, error))
            return false;
    }
    return true;
}
