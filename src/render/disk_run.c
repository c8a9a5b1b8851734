/* Four points at a time, except for sine and cosine: those of the library decide the last bit. */
#include "render/disk_run.h"

#include "base/simd4.h"

/* Which coordinate becomes the radius: then four points at a time, without a branch that is hard to
 * predict. In the middle both are 0, and any angle will do. */
static inline void polar_of(rk_simd4 xi_x, rk_simd4 xi_y, float *radius, float *angle,
                            rk_simd4_mask *is_wide)
{
    const rk_simd4 x = 2 * xi_x - 1, y = 2 * xi_y - 1, zero = rk_simd4_all(0);
    *is_wide = rk_simd4_abs(x) > rk_simd4_abs(y);
    const rk_simd4 larger = rk_simd4_select(*is_wide, x, y);
    const rk_simd4 ratio = rk_simd4_select(*is_wide, y, x) / larger;
    rk_simd4_store(radius, larger);
    rk_simd4_store(angle, RK_PI / 4 * rk_simd4_select(larger == zero, zero, ratio));
}

void rk_disk_run(uint32_t count, float *x, float *y)
{
    float radius[RK_DISK_RUN_MAX], angle[RK_DISK_RUN_MAX];
    float cosine[RK_DISK_RUN_MAX], sine[RK_DISK_RUN_MAX];
    rk_simd4_mask is_wide[RK_DISK_RUN_MAX / RK_SIMD4_WIDTH];
    for (uint32_t i = 0; i < count; i += RK_SIMD4_WIDTH)
        polar_of(rk_simd4_load(&x[i]), rk_simd4_load(&y[i]), &radius[i], &angle[i],
                 &is_wide[i / RK_SIMD4_WIDTH]);
    for (uint32_t i = 0; i < count; i++) {
        cosine[i] = cosf(angle[i]);
        sine[i] = sinf(angle[i]);
    }
    for (uint32_t i = count; i % RK_SIMD4_WIDTH; i++)
        cosine[i] = sine[i] = 0;
    for (uint32_t i = 0; i < count; i += RK_SIMD4_WIDTH) {
        const rk_simd4 r = rk_simd4_load(&radius[i]);
        const rk_simd4 along = r * rk_simd4_load(&cosine[i]), aside = r * rk_simd4_load(&sine[i]);
        const rk_simd4_mask wide = is_wide[i / RK_SIMD4_WIDTH];
        rk_simd4_store(&x[i], rk_simd4_select(wide, along, aside));
        rk_simd4_store(&y[i], rk_simd4_select(wide, aside, along));
    }
}
