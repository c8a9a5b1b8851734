#include "render/converge.h"

#include <math.h>

void rk_converge_compare(rk_convergence_row *row, const rk_image *got, const rk_image *want)
{
    double squares = 0, sum = 0, count = 3 * (double)(got->width * got->height);
    row->max_error = 0;
    for (size_t i = 0; i < got->width * got->height; i++)
        for (int k = 0; k < 3; k++) {
            double error = (double)(rk_axis(got->pixels[i], k) - rk_axis(want->pixels[i], k));
            squares += error * error;
            sum += error;
            row->max_error = fmax(row->max_error, fabs(error));
        }
    row->rmse = sqrt(squares / count);
    row->bias = sum / count;
}
