/* Before version 4.0, pictures of three channels replace the diffuse colour, and those of one
 * multiply it (ISO/IEC 19775-1:2013, 17.2.2.4). Channels are counted as the file says: JPEG by
 * ITU-T T.81, B.2.2, PNG by its specification, 11.2.1. */
#include "io/mesh_helper/mesh_x3d_colours.h"

#include <stdio.h>
#include <string.h>

/* The number of components follows a frame's length, precision, height and width. */
static bool is_grey_jpeg(FILE *file)
{
    unsigned char segment[10];
    for (long at = 2; fseek(file, at, SEEK_SET) == 0 && fread(segment, 1, 10, file) == 10;) {
        const unsigned kind = segment[1];
        if (segment[0] != 0xff)
            return false;
        if (kind >= 0xc0 && kind <= 0xcf && kind != 0xc4 && kind != 0xc8 && kind != 0xcc)
            return segment[9] == 1;
        at += kind == 0xff ? 1 : 2 + (segment[2] << 8 | segment[3]);
    }
    return false;
}

static bool is_grey(FILE *file)
{
    static const unsigned char png[] = {0x89, 'P', 'N', 'G'};
    unsigned char head[26] = {0};
    const size_t size = fread(head, 1, sizeof head, file);
    if (size == sizeof head && memcmp(head, png, sizeof png) == 0)
        return head[25] == 0 || head[25] == 4;
    if (head[0] == 0xff && head[1] == 0xd8)
        return is_grey_jpeg(file);
    return head[0] == 'P' && (head[1] == '2' || head[1] == '5');
}

static bool has_grey(const rk_mesh_texture *texture, const char *path)
{
    char whole[4096];
    const char *slash = strrchr(path, '/'), *name = texture->name.data;
    const int folder = slash && name[0] != '/' ? (int)(slash - path) + 1 : 0;
    if (snprintf(whole, sizeof whole, "%.*s%s", folder, path, name) >= (int)sizeof whole)
        return false;
    FILE *file = fopen(whole, "rb");
    const bool grey = file && is_grey(file);
    if (file)
        fclose(file);
    return grey;
}

void rk_mesh_x3d_colours_replace(rk_mesh *mesh, const rk_mesh_textures *textures, const char *path)
{
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        const uint32_t number = textures->of_material[i];
        if (number > 0 && !has_grey(&textures->entries[number - 1], path))
            mesh->materials[i].kd = rk_vec(1, 1, 1);
    }
}
