/* One small mesh in each format: a unit square in the plane z = 0 and a triangle perpendicular to
 * it on its first edge. Three triangles, five distinct points; OBJ and glTF give the square and the
 * triangle a material each. The textured glTF has only the square. */
#ifndef RK_TESTS_MESH_SEEDS_H
#define RK_TESTS_MESH_SEEDS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef struct mesh_seed {
    const char *name; /* of the file; its ending is the format */
    unsigned char bytes[4096];
    size_t size;
} mesh_seed;

enum { seed_obj, seed_ply_text, seed_ply_binary, seed_off, seed_gltf, seed_gltf_textured };

static const float seed_points[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0, 1}};

static const char seed_mtl[] = "newmtl red\nKd 1 0 0\nKs 0.1 0.2 0.3\nNs 50\nd 0.5\n"
                               "newmtl green\nKd 0 1 0\nTr 0.25\n";

static const char seed_obj_text[] = "# square and triangle\n"
                                    "mtllib seed.mtl\n"
                                    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0 1\n"
                                    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 -2 0\n"
                                    "usemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                                    "usemtl green\nf -5/1/2 -4/2/2 -1/3/2\n";

static const char seed_ply_header[] =
    "comment a square and a triangle\nelement vertex 5\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

static const char seed_rows[] = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0 1\n4 0 1 2 3\n3 0 1 4\n";

static inline void seed_append(mesh_seed *seed, const void *bytes, size_t size)
{
    memcpy(seed->bytes + seed->size, bytes, size);
    seed->size += size;
}

static inline void seed_append_text(mesh_seed *seed, const char *text)
{
    seed_append(seed, text, strlen(text));
}

/* Least significant byte first, whatever the machine. */
static inline void seed_append_word(mesh_seed *seed, uint32_t word)
{
    for (int i = 0; i < 4; i++)
        seed->bytes[seed->size++] = (unsigned char)(word >> 8 * i);
}

static inline void seed_append_points(mesh_seed *seed)
{
    for (int i = 0; i < 15; i++) {
        uint32_t bits;
        memcpy(&bits, &seed_points[i / 3][i % 3], sizeof bits);
        seed_append_word(seed, bits);
    }
}

static inline void seed_append_base64(mesh_seed *seed, const unsigned char *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t group = (uint32_t)bytes[i] << 16;
        group |= i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0;
        group |= i + 2 < size ? bytes[i + 2] : 0;
        for (size_t k = 0; k < 4; k++)
            seed->bytes[seed->size++] =
                i + k <= size ? (unsigned char)digits[group >> (18 - 6 * k) & 63] : '=';
    }
}

/* The nodes move the square by (10, 0, 0), and double the triangle. */
static inline void seed_append_gltf(mesh_seed *seed)
{
    mesh_seed buffer = {0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 0, 1, 4};
    seed_append_points(&buffer);
    for (int i = 0; i < 9; i++)
        seed_append_word(&buffer, indices[i]);
    seed_append_text(
        seed,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
        "\"nodes\":[{\"mesh\":0,\"translation\":[10,0,0]},{\"mesh\":1,\"scale\":[2,2,2]}],"
        "\"meshes\":["
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]},"
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":1}]}],"
        "\"materials\":["
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,0.5]},\"alphaMode\":\"BLEND\"},"
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,1,0,0.5]}}],"
        "\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":5,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,1]},"
        "{\"bufferView\":1,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"},"
        "{\"bufferView\":1,\"byteOffset\":24,\"componentType\":5125,\"count\":3,"
        "\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":60},"
        "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":96,\"uri\":\"data:application/octet-stream;base64,");
    seed_append_base64(seed, buffer.bytes, buffer.size);
    seed_append_text(seed, "\"}]}\n");
}

/* Four texels in a PNG: red and green above blue and white. */
static const char seed_picture[] =
    "\"uri\":\"data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAEklEQVR4nGP4z8DAAMIM/4EAAB/u"
    "BfsL2WiLAAAAAElFTkSuQmCC"
    "\"";

/* A square whose picture is `image`, the members of a glTF object; `sampler` are those of the
 * sampler. Its second set of texture coordinates, the one in use, has the texels' centres; the
 * first is all 0. */
static inline void seed_append_textured_gltf(mesh_seed *seed, const char *image,
                                             const char *sampler)
{
    mesh_seed buffer = {0};
    char text[1500];
    const float numbers[4 * 3 + 4 * 2 + 4 * 2] = {
        0,     0,     0,     1,     0,     0,     1,
        1,     0,     0,     1,     0,     0,     0,
        0,     0,     0,     0,     0,     0,     /* v goes down: */ 0.25f,
        0.75f, 0.75f, 0.75f, 0.75f, 0.25f, 0.25f, 0.25f};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 28; i++) {
        uint32_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        seed_append_word(&buffer, bits);
    }
    for (int i = 0; i < 6; i++)
        seed_append_word(&buffer, indices[i]);
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
             "{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2},\"indices\":3,"
             "\"material\":0}]}],\"materials\":[{\"pbrMetallicRoughness\":"
             "{\"baseColorTexture\":{\"index\":0,\"texCoord\":1}}}],"
             "\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{%s}],"
             "\"images\":[{%s}],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
             "{\"bufferView\":2,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
             "{\"bufferView\":3,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
             "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":32},"
             "{\"buffer\":0,\"byteOffset\":80,\"byteLength\":32},"
             "{\"buffer\":0,\"byteOffset\":112,\"byteLength\":24}],"
             "\"buffers\":[{\"byteLength\":136,\"uri\":\"data:application/octet-stream;base64,",
             sampler, image);
    seed_append_text(seed, text);
    seed_append_base64(seed, buffer.bytes, buffer.size);
    seed_append_text(seed, "\"}]}\n");
}

static inline mesh_seed make_seed(int format)
{
    static const char *const names[] = {"seed.obj", "text.ply",  "binary.ply",
                                        "seed.off", "seed.gltf", "textured.gltf"};
    mesh_seed seed = {.name = names[format]};
    switch (format) {
    case seed_obj:
        seed_append_text(&seed, seed_obj_text);
        break;
    case seed_ply_text:
        seed_append_text(&seed, "ply\nformat ascii 1.0\n");
        seed_append_text(&seed, seed_ply_header);
        seed_append_text(&seed, seed_rows);
        break;
    case seed_ply_binary:
        seed_append_text(&seed, "ply\nformat binary_little_endian 1.0\n");
        seed_append_text(&seed, seed_ply_header);
        seed_append_points(&seed);
        for (uint32_t face = 0; face < 2; face++) {
            const uint32_t corners[2][4] = {{0, 1, 2, 3}, {0, 1, 4}};
            seed.bytes[seed.size++] = (unsigned char)(4 - face);
            for (uint32_t i = 0; i < 4 - face; i++)
                seed_append_word(&seed, corners[face][i]);
        }
        break;
    case seed_off:
        seed_append_text(&seed, "OFF\n# vertices faces edges\n5 2 0\n");
        seed_append_text(&seed, seed_rows);
        break;
    case seed_gltf:
        seed_append_gltf(&seed);
        break;
    default:
        seed_append_textured_gltf(&seed, seed_picture, "\"wrapS\":33071");
    }
    return seed;
}

#endif
