/* Do two pictures differ visibly? Prints which part of their pixels does, from 0 to 1, or "no pair"
 * if they have not one size. The weaver asks for each pair of pictures in a row
 * (tools/weave/pictures.lua).
 */
#include "io/png.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Of 255: below, a border between two surfaces cannot be seen. */
enum { invisible = 4 };

static bool is_visible(rk_vec3 a, rk_vec3 b)
{
    for (int axis = 0; axis < 3; axis++)
        if (rintf(255 * rk_srgb_encode(rk_axis(a, axis))) -
                rintf(255 * rk_srgb_encode(rk_axis(b, axis))) >
            invisible)
            return true;
    return false;
}

/* The pixels that the fraction `start` to `start + part` of `count` touches. */
static void find_span(size_t count, double start, double part, size_t span[2])
{
    span[0] = (size_t)floor(start * (double)count + 1e-6);
    span[1] = (size_t)fmin(ceil((start + part) * (double)count - 1e-6), (double)count);
}

static double part_that_differs(const rk_image *a, const rk_image *b, const double part[4])
{
    size_t columns[2], rows[2], differ = 0;
    find_span(a->width, part[0], part[2], columns);
    find_span(a->height, part[1], part[3], rows);
    for (size_t y = rows[0]; y < rows[1]; y++)
        for (size_t x = columns[0]; x < columns[1]; x++) {
            rk_vec3 p = *rk_image_at(a, x, y), q = *rk_image_at(b, x, y);
            differ += is_visible(p, q) || is_visible(q, p);
        }
    return (double)differ / (double)((columns[1] - columns[0]) * (rows[1] - rows[0]));
}

int main(int argc, char **argv)
{
    double part[4] = {0, 0, 1, 1};
    if (argc != 3 && argc != 7) {
        fputs(
            "usage: pair ONE.png OTHER.png [LEFT TOP WIDTH HEIGHT], in fractions of the picture\n",
            stderr);
        return 2;
    }
    for (int i = 3; i < argc; i++)
        part[i - 3] = strtod(argv[i], NULL);
    rk_error error;
    rk_image a = {0}, b = {0};
    bool ok = rk_png_read(&a, argv[1], &error) && rk_png_read(&b, argv[2], &error);
    if (!ok)
        fprintf(stderr, "pair: %s\n", error.text);
    else if (a.width != b.width || a.height != b.height)
        puts("no pair");
    else
        printf("%.6f\n", part_that_differs(&a, &b, part));
    rk_image_free(&a);
    rk_image_free(&b);
    return ok ? 0 : 1;
}
