/* Many points of the unit disk at once; not installed. */
#ifndef RK_RENDER_DISK_RUN_H
#define RK_RENDER_DISK_RUN_H

#include <stdint.h>

enum { RK_DISK_RUN_MAX = 256 };

/* Replaces points of the unit square by those of the unit disk, each as by rk_disk_at with
 * RK_DISK_CONCENTRIC, to the bit. `count`: at most RK_DISK_RUN_MAX; up to three more are read and
 * written, to make it a multiple of 4. */
void rk_disk_run(uint32_t count, float *x, float *y);

#endif
