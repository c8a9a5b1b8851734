/* The format in which library and raykit-image exchange pictures: this head, then width * height *
 * 3 floats of linear RGB, row by row from the top, in native byte order. To read pictures, the
 * library sends requests, each followed by the file's name; not installed. */
#ifndef RK_IO_IMAGE_STREAM_H
#define RK_IO_IMAGE_STREAM_H

#include <stdint.h>

#define RK_IMAGE_STREAM_MAGIC 0x4d496b72u /* "rkIM" */

enum {
    RK_IMAGE_STREAM_VERSION = 3,
    RK_IMAGE_STREAM_SIDE_MAX = 32768,
};

typedef struct rk_image_stream_head {
    uint32_t magic, version, width, height;
} rk_image_stream_head;

/* What of a picture to read. */
typedef enum rk_image_stream_part {
    RK_IMAGE_STREAM_COLOUR,
    RK_IMAGE_STREAM_ALPHA,   /* its alpha channel, as a grey picture of the stored values */
    RK_IMAGE_STREAM_OPACITY, /* the same, or its grey values if it has no alpha */
} rk_image_stream_part;

typedef struct rk_image_stream_request {
    uint32_t magic, version;
    uint32_t part;        /* rk_image_stream_part */
    uint32_t shape;       /* rk_image_shape: others are refused */
    uint64_t most_pixels; /* pictures of more are refused */
    uint64_t least_width; /* see rk_image_file_wish */
    uint64_t name_size;   /* of the file's name, which follows */
} rk_image_stream_request;

#endif
