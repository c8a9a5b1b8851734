// Bitmaps of 32 bits per pixel, of which OpenImageIO 2.4 takes the fourth byte for alpha, and the
// others for blue, green and red, whatever the file says. Format: Microsoft, "BITMAPV5HEADER".
#ifndef RK_IO_IMAGE_HELPER_BMP_H
#define RK_IO_IMAGE_HELPER_BMP_H

#include "io/little_endian.h"

#include <OpenImageIO/imageio.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

struct Bmp {
    OIIO::ImageSpec spec;
    std::array<uint32_t, 4> masks; // of red, green, blue and alpha
    uint32_t begin;
    bool from_top;
};

// Of the mask moved down to bit 0.
inline uint32_t bmp_most(uint32_t mask)
{
    return mask ? mask / (mask & (~mask + 1)) : 1;
}

// False if the file is no such bitmap, and for OpenImageIO to read or to refuse.
inline bool bmp_open(const std::string &path, Bmp *bmp)
{
    enum { plain = 0, three_masks = 3, four_masks = 6 };
    unsigned char head[70] = {};
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char *>(head), sizeof head);
    const uint32_t size = rk_little_endian_32(head + 14), kind = rk_little_endian_32(head + 30);
    const auto width = int32_t(rk_little_endian_32(head + 18)),
               height = int32_t(rk_little_endian_32(head + 22));
    if (file.gcount() < 54 || std::memcmp(head, "BM", 2) != 0 || size < 40 || head[28] != 32 ||
        (kind != plain && kind != three_masks && kind != four_masks) || width < 1 ||
        height == INT32_MIN)
        return false;
    bmp->masks = {0xff0000, 0xff00, 0xff, 0};
    const int masks = kind == plain ? 0 : size >= 56 || kind == four_masks ? 4 : 3;
    bool is_fine = true;
    for (int i = 0; i < masks; i++)
        bmp->masks[size_t(i)] = rk_little_endian_32(head + 54 + 4 * i);
    for (uint32_t mask : bmp->masks)
        is_fine &= bmp_most(mask) <= 0xff;
    bmp->spec = OIIO::ImageSpec(width, std::abs(height), bmp->masks[3] ? 4 : 3,
                                is_fine ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16);
    bmp->begin = rk_little_endian_32(head + 10);
    bmp->from_top = height < 0;
    return true;
}

// Values of some channels of all pixels; false if the file ends too early.
inline bool bmp_read(const std::string &path, const Bmp &bmp, int first, int count, float *to)
{
    const size_t width = size_t(bmp.spec.width), height = size_t(bmp.spec.height);
    std::ifstream file(path, std::ios::binary);
    std::vector<unsigned char> row(4 * width);
    for (size_t y = 0; y < height; y++) {
        const size_t stored = bmp.from_top ? y : height - 1 - y;
        file.seekg(std::streamoff(bmp.begin + uint64_t(stored) * row.size()));
        if (!file.read(reinterpret_cast<char *>(row.data()), std::streamsize(row.size())))
            return false;
        for (size_t x = 0; x < width; x++)
            for (int c = first; c < first + count; c++) {
                const uint32_t mask = bmp.masks[size_t(c)], most = bmp_most(mask);
                const uint32_t lowest = mask & (~mask + 1);
                const uint32_t bits = rk_little_endian_32(row.data() + 4 * x) & mask;
                *to++ = mask ? float(double(bits / lowest) / most) : 0;
            }
    }
    return true;
}

#endif
