/* Shapes of pictures that a reader may ask for, so that others are refused by their header, before
 * they are decoded. Common to the library (C) and raykit-image (C++). */
#ifndef RK_IO_IMAGE_SHAPE_H
#define RK_IO_IMAGE_SHAPE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum rk_image_shape {
    RK_IMAGE_ANY,
    RK_IMAGE_SQUARE,     /* a face of a cube */
    RK_IMAGE_ENVIRONMENT /* a cross, a strip, or longitude and latitude */
} rk_image_shape;

/* Follows "FILE: has W x H pixels: ". */
#define RK_IMAGE_SHAPE_SQUARE_NEEDED "choose a square one as a face"
#define RK_IMAGE_SHAPE_ENVIRONMENT_NEEDED                                                          \
    "choose an environment whose width : height is 4:3 or 3:4 (a cross), 6:1 or 1:6 (a strip), "   \
    "or 2:1 (longitude and latitude)"

static inline bool rk_image_shape_has_cells(size_t width, size_t height, size_t columns,
                                            size_t rows)
{
    return width * rows == height * columns && width % columns == 0;
}

/* Longitude and latitude; programs that crop or scale leave a row or a column more or less. */
static inline bool rk_image_shape_has_world(size_t width, size_t height)
{
    size_t twice = 2 * height;
    return width > 1 && (width > twice ? width - twice : twice - width) <= (width > 64 ? 2 : 0);
}

/* NULL if the picture has the shape, or what is needed. */
static inline const char *rk_image_shape_fault(rk_image_shape shape, size_t width, size_t height)
{
    static const unsigned char cells[4][2] = {{4, 3}, {3, 4}, {6, 1}, {1, 6}};
    if (shape == RK_IMAGE_SQUARE && width != height)
        return RK_IMAGE_SHAPE_SQUARE_NEEDED;
    if (shape != RK_IMAGE_ENVIRONMENT || rk_image_shape_has_world(width, height))
        return NULL;
    for (int i = 0; i < 4; i++)
        if (rk_image_shape_has_cells(width, height, cells[i][0], cells[i][1]))
            return NULL;
    return RK_IMAGE_SHAPE_ENVIRONMENT_NEEDED;
}

#endif
