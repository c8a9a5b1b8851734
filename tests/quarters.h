/* A picture that shows its orientation: 2 x 2 texels, red and green above blue and white. */
#ifndef RK_TESTS_QUARTERS_H
#define RK_TESTS_QUARTERS_H

#include "test_folder.h"

#include "base/image.h"
#include "base/texture.h"
#include "io/png.h"

static inline test_path write_quarters(const test_folder *folder, const char *name)
{
    test_path path = test_folder_path(folder, name);
    rk_vec3 texels[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    rk_image image = {2, 2, texels};
    rk_error error;
    rk_check_ok(rk_png_write(path.text, &image, NULL, 0, &error), error);
    return path;
}

static inline void check_texel(const rk_texture *texture, float u, float v, rk_vec3 want)
{
    rk_vec3 got = rk_texture_at(texture, (rk_vec2){u, v});
    rk_check(got.x == want.x && got.y == want.y && got.z == want.z,
             "at u %g, v %g: got (%g, %g, %g), want (%g, %g, %g): v = 1 is the picture's top",
             (double)u, (double)v, (double)got.x, (double)got.y, (double)got.z, (double)want.x,
             (double)want.y, (double)want.z);
}

/* Texels' centres, where the bilinear mix is the texel's own colour. */
static inline void check_quarters(const rk_texture *texture)
{
    check_texel(texture, 0.25f, 0.75f, rk_vec(1, 0, 0));
    check_texel(texture, 0.75f, 0.75f, rk_vec(0, 1, 0));
    check_texel(texture, 0.25f, 0.25f, rk_vec(0, 0, 1));
    check_texel(texture, 0.75f, 0.25f, rk_vec(1, 1, 1));
}

#endif
