// DirectDraw surfaces whose pixels are stored as they are, which OpenImageIO 2.4 refuses if they
// are floats, or if their format stands in the header of DirectX 10. Format: Microsoft,
// "DDS_HEADER", "DDS_HEADER_DXT10".
#ifndef RK_IO_IMAGE_HELPER_DDS_H
#define RK_IO_IMAGE_HELPER_DDS_H

#include "io/little_endian.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

struct Dds {
    OIIO::ImageSpec spec; // of its faces one below the other, if it is a cube
    int faces;            // 6, or 1
    bool blue_first;
    uint64_t begin,
        stride; // in bytes: the first face, and from face to face, with smaller pictures of it
};

inline uint32_t dds_word(const unsigned char *header, int index)
{
    return rk_little_endian_32(header + 4 * index);
}

// The type of a channel by DXGI's number of a format of three or four; UNKNOWN if it is another.
inline OIIO::TypeDesc dds_type(uint32_t format, int *channels)
{
    *channels = format == 6 ? 3 : 4;
    switch (format) {
    case 2: // R32G32B32A32_FLOAT
    case 6: // R32G32B32_FLOAT
        return OIIO::TypeDesc::FLOAT;
    case 10: // R16G16B16A16_FLOAT
        return OIIO::TypeDesc::HALF;
    case 11: // R16G16B16A16_UNORM
        return OIIO::TypeDesc::UINT16;
    case 28: // R8G8B8A8, B8G8R8A8, B8G8R8X8, and each in sRGB
    case 29:
    case 87:
    case 88:
    case 91:
    case 93:
        return OIIO::TypeDesc::UINT8;
    default:
        return OIIO::TypeDesc::UNKNOWN;
    }
}

// DXGI's number of the format, or 0 if the older header describes what OpenImageIO knows.
inline uint32_t dds_format(const unsigned char *header)
{
    const uint32_t floats16 = 113, floats32 = 116, ten = 0x30315844; // "DX10"
    const uint32_t code = dds_word(header, 20) & 4 ? dds_word(header, 21) : 0;
    if (code == ten)
        return dds_word(header, 32);
    return code == floats16 ? 10 : code == floats32 ? 2 : 0;
}

// False if the file is no such picture, and for OpenImageIO to read or to refuse.
inline bool dds_open(const std::string &path, Dds *dds)
{
    unsigned char header[148] = {};
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char *>(header), sizeof header);
    if (file.gcount() < 128 || std::memcmp(header, "DDS ", 4) != 0)
        return false;
    const bool is_new = dds_word(header, 21) == 0x30315844;
    const uint32_t format = dds_format(header), all_faces = 0xfe00;
    const uint32_t height = dds_word(header, 3), width = dds_word(header, 4), most = 1 << 24;
    int channels;
    const OIIO::TypeDesc type = dds_type(format, &channels);
    const bool is_cube =
        (dds_word(header, 28) & all_faces) == all_faces || (is_new && dds_word(header, 34) & 4);
    if (type == OIIO::TypeDesc::UNKNOWN || width < 1 || height < 1 || width > most ||
        height > most || (!is_cube && dds_word(header, 28) & 0x200200) ||
        (is_new && dds_word(header, 35) > 1))
        return false;
    dds->faces = is_cube ? 6 : 1;
    dds->spec = OIIO::ImageSpec(int(width), int(height) * dds->faces, channels, type);
    if (format == 88 || format == 93)
        dds->spec.alpha_channel = -1;
    dds->blue_first = format >= 87;
    dds->begin = is_new ? 148 : 128;
    dds->stride = 0;
    for (uint32_t i = 0; i < std::min(std::max(dds_word(header, 7), 1u), 25u); i++)
        dds->stride += uint64_t(std::max(width >> i, 1u)) * std::max(height >> i, 1u) *
                       dds->spec.pixel_bytes();
    return true;
}

// Values of some channels of all pixels; false if the file ends too early.
inline bool dds_read(const std::string &path, const Dds &dds, int first, int count, float *to)
{
    const size_t row = size_t(dds.spec.width) * dds.spec.pixel_bytes(),
                 width = size_t(dds.spec.width);
    const size_t channels = size_t(dds.spec.nchannels), rows = size_t(dds.spec.height / dds.faces);
    std::ifstream file(path, std::ios::binary);
    std::string bytes(row, '\0');
    std::vector<float> values(width * channels);
    for (int face = 0; face < dds.faces; face++) {
        file.seekg(std::streamoff(dds.begin + uint64_t(face) * dds.stride));
        for (size_t y = 0; y < rows; y++) {
            if (!file.read(&bytes[0], std::streamsize(row)))
                return false;
            OIIO::convert_pixel_values(dds.spec.format, bytes.data(), OIIO::TypeDesc::FLOAT,
                                       values.data(), int(values.size()));
            for (size_t x = 0; x < width; x++)
                for (int c = first; c < first + count; c++)
                    *to++ = values[x * channels + size_t(dds.blue_first && c < 3 ? 2 - c : c)];
        }
    }
    return true;
}

#endif
