/* Declarations that the files of this driver share. */
#ifndef RK_03_SHADING_DRIVER_H
#define RK_03_SHADING_DRIVER_H

#include "driver/driver_main.h"
#include "render/options.h"

static const float shininess_shown[] = {1, 10, 100, 1e3f, 1e5f};
enum { shown = sizeof shininess_shown / sizeof shininess_shown[0] };

typedef struct choices {
    float ks, shininess; /* of all materials; NaN: their own */
    float incidence;     /* degrees from the normal */
    uint32_t bands;      /* of the gradient; 0: smooth */
    bool lobes, radiance, terminator;
} choices;

static const rk_vec3 up = {0, 1, 0};

/* Returns the direction at an angle from `up` to the right of the picture, where x is negative. */
rk_vec3 at_angle(float degrees);

/* Returns the value of a model's lobe over a plane whose normal is `up`; l: to the light, v: to the
 * viewer. */
float lobe(rk_shading_model model, bool normalized, float shininess, rk_vec3 l, rk_vec3 v);

/* Replaces the scene by a plane, seen from the side. */
bool make_plane(rk_driver *driver, rk_error *error);

/* Renders the plane and draws driver->debug over it. */
bool draw_view(rk_driver *driver, rk_error *error);

/* Puts the table of --lobes. */
bool put_study(rk_driver *driver, rk_error *error);

/* Puts the table of --radiance. */
bool put_radiance(rk_driver *driver, rk_error *error);

/* Puts the table of --terminator. */
bool put_terminator(rk_driver *driver, rk_error *error);

#endif
