/* Whole numbers whose lowest byte comes first, as most formats of files store them. Common to C and
 * C++; not installed. */
#ifndef RK_IO_LITTLE_ENDIAN_H
#define RK_IO_LITTLE_ENDIAN_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* `count`: at most 8. */
static inline uint64_t rk_little_endian(const void *bytes, size_t count)
{
    unsigned char copy[8] = {0};
    uint64_t number = 0;
    memcpy(copy, bytes, count);
    for (size_t i = sizeof copy; i > 0; i--)
        number = number << 8 | copy[i - 1];
    return number;
}

static inline uint16_t rk_little_endian_16(const void *bytes)
{
    return (uint16_t)rk_little_endian(bytes, 2);
}

static inline uint32_t rk_little_endian_32(const void *bytes)
{
    return (uint32_t)rk_little_endian(bytes, 4);
}

#endif
