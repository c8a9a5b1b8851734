/* How much of a picture is there to be seen? What is left black teaches nothing. */
#ifndef RK_DRIVER_PICTURE_SUBJECT_H
#define RK_DRIVER_PICTURE_SUBJECT_H

#include "base/image.h"

typedef struct rk_picture_subject {
    double black; /* fraction of the pixels that look black: all channels below 1 % of white */
    double frame; /* fraction of the picture in the smallest rectangle around all others */
} rk_picture_subject;

/* Of a picture with at least one pixel. */
rk_picture_subject rk_picture_subject_of(const rk_image *image);

#endif
