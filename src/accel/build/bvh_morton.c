/* Codes are computed from the centres whenever they are needed, not stored; a radix sort orders
 * references by them, and a range is cut where the highest bit that differs changes. */
#include "accel/build/bvh_morton.h"

/* The ten bits of x, two places apart from each other. */
static inline uint32_t spread(uint32_t x)
{
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

/* The place of a centre on a curve through the cells of a grid, that stays in an eighth of the grid
 * before it goes on to the next, and likewise in each eighth. */
static inline uint32_t code_of(const binning *grid, const reference *r)
{
    const rk_simd4_mask cell = bins_of(grid, centre_of(r));
    return spread((uint32_t)cell[0]) << 2 | spread((uint32_t)cell[1]) << 1 |
           spread((uint32_t)cell[2]);
}

/* In three passes of ten bits, each of which keeps the order of the one before (radix sort). */
void rk_morton_sort(reference *references[2], uint32_t count, const binning *grid)
{
    uint32_t first[3][1 << 10] = {{0}};
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t code = code_of(grid, &references[0][i]);
        for (int pass = 0; pass < 3; pass++)
            first[pass][code >> 10 * pass & 1023]++;
    }
    for (int pass = 0; pass < 3; pass++) {
        uint32_t sum = 0;
        for (int k = 0; k < 1 << 10; k++) {
            const uint32_t here = first[pass][k];
            first[pass][k] = sum;
            sum += here;
        }
        const reference *from = references[pass % 2];
        reference *to = references[(pass + 1) % 2];
        for (uint32_t i = 0; i < count; i++)
            to[first[pass][code_of(grid, &from[i]) >> 10 * pass & 1023]++] = from[i];
    }
}

uint32_t rk_morton_boundary(const reference *r, uint32_t count, const binning *grid)
{
    uint32_t low = 0, high = count - 1; /* of the one the bit is 0, of the other 1 */
    const uint32_t differ = code_of(grid, &r[low]) ^ code_of(grid, &r[high]);
    if (differ == 0)
        return count - count / 2;
    const uint32_t bit = 1u << (31 - __builtin_clz(differ));
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (code_of(grid, &r[middle]) & bit)
            high = middle;
        else
            low = middle;
    }
    return high;
}
