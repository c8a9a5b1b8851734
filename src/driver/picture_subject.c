/* Counts the pixels that look black, and bounds the others by a rectangle. */
#include "driver/picture_subject.h"

static bool looks_black(rk_vec3 colour)
{
    const float least = 0.01f;
    return colour.x < least && colour.y < least && colour.z < least;
}

rk_picture_subject rk_picture_subject_of(const rk_image *image)
{
    size_t black = 0, left = image->width, right = 0, top = image->height, bottom = 0;
    for (size_t y = 0; y < image->height; y++)
        for (size_t x = 0; x < image->width; x++) {
            if (looks_black(image->pixels[y * image->width + x])) {
                black++;
                continue;
            }
            left = x < left ? x : left;
            right = x + 1 > right ? x + 1 : right;
            top = y < top ? y : top;
            bottom = y + 1;
        }
    const double pixels = (double)image->width * (double)image->height;
    const bool is_empty = right == 0;
    return (rk_picture_subject){
        .black = (double)black / pixels,
        .frame = is_empty ? 0 : (double)(right - left) * (double)(bottom - top) / pixels,
    };
}
