/* In which pixels does a picture differ from the wanted one? Both are compared as 8-bit files show
 * them. */
#ifndef RK_DRIVER_PICTURE_DIFFERENCE_H
#define RK_DRIVER_PICTURE_DIFFERENCE_H

#include "base/image.h"

typedef struct rk_picture_difference {
    size_t pixels;   /* that differ */
    size_t x, y;     /* the one that differs most */
    bool are_single; /* no two of them touch, not even at a corner */
} rk_picture_difference;

/* Pictures of equal size. A channel that is off by one of its 255 steps is not counted: the last
 * bit of a float may decide between two neighbouring steps. Fills in `shown`, of the same size: the
 * differences of the stored channels, scaled so that the largest is 1. */
rk_picture_difference rk_picture_difference_of(const rk_image *drawn, const rk_image *wanted,
                                               rk_image *shown);

#endif
