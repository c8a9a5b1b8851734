// The number of pixels with a visible difference between two pictures: the metric of Yee, "A
// perceptual metric for production testing", Journal of Graphics Tools 9(4), 2004.
#ifndef RK_IO_IMAGE_HELPER_PERCEPTUAL_H
#define RK_IO_IMAGE_HELPER_PERCEPTUAL_H

#include <cstddef>

// Both are width * height pixels of linear sRGB. The viewer sees them 45 degrees wide, white at
// 100 candela per square metre.
size_t count_seen(const float *a, const float *b, size_t width, size_t height);

#endif
