/* The format in which library and raykit-image exchange pictures: this head, then width * height *
 * 3 floats of linear RGB, row by row from the top, in native byte order; not installed. */
#ifndef RK_IO_IMAGE_STREAM_H
#define RK_IO_IMAGE_STREAM_H

#include <stdint.h>

#define RK_IMAGE_STREAM_MAGIC 0x4d496b72u /* "rkIM" */

enum {
    RK_IMAGE_STREAM_VERSION = 1,
    RK_IMAGE_STREAM_SIDE_MAX = 32768,
};

typedef struct rk_image_stream_head {
    uint32_t magic, version, width, height;
} rk_image_stream_head;

#endif
