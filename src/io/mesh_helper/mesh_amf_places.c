/* Assimp's node of a constellation has its identifier as name, and a node for each instance, in the
 * file's order. Format: ISO/ASTM 52915: an object is turned by degrees about x, then y, then z, and
 * then moved. */
#include "io/mesh_helper/mesh_amf_places.h"

#include "io/mesh_helper/xml_tag.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { longest_name = 40 };

typedef struct rk_mesh_amf_place {
    char constellation[longest_name];
    double numbers[6]; /* move along x, y and z, turns about them */
} rk_mesh_amf_place;

static void read_id(char id[longest_name], const char *tag, const char *close)
{
    static const char word[] = "id=";
    id[0] = '\0';
    for (const char *at = tag + 1; close - at > 4; at++) {
        if (memcmp(at, word, 3) != 0 || !strchr(" \t\r\n", at[-1]))
            continue;
        const char *end = memchr(at + 4, at[3], (size_t)(close - at - 4));
        const size_t length = end ? (size_t)(end - at - 4) : longest_name;
        if (length < longest_name) {
            memcpy(id, at + 4, length);
            id[length] = '\0';
        }
        return;
    }
}

static bool add_place(rk_mesh_hints *hints, const char *id)
{
    const size_t n = hints->place_count;
    if ((n & (n - 1)) == 0) {
        void *room = realloc(hints->places, (n ? 2 * n : 1) * sizeof *hints->places);
        if (!room)
            return false;
        hints->places = room;
    }
    hints->places[n] = (rk_mesh_amf_place){0};
    strcpy(hints->places[n].constellation, id);
    hints->place_count++;
    return true;
}

bool rk_mesh_amf_places_read(rk_mesh_hints *hints, const char *path, const char *text, size_t size,
                             rk_error *error)
{
    static const char *const words[] = {"deltax", "deltay", "deltaz", "rx", "ry", "rz"};
    const char *const end = text + size;
    char id[longest_name] = "";
    for (const char *at = text; (at = memchr(at, '<', (size_t)(end - at))); at++) {
        const char *close = memchr(at, '>', (size_t)(end - at));
        if (!close)
            break;
        const xml_span tag = {at, close + 1};
        if (xml_is_tag(tag, "constellation"))
            read_id(id, at, close);
        else if (xml_is_tag(tag, "/constellation"))
            id[0] = '\0';
        else if (id[0] && xml_is_tag(tag, "instance") && !add_place(hints, id))
            return rk_fail(error, "%s: no memory for its objects' places: simplify the mesh", path);
        for (int k = 0; id[0] && hints->place_count > 0 && k < 6; k++)
            if (xml_is_tag(tag, words[k]))
                hints->places[hints->place_count - 1].numbers[k] =
                    xml_number((xml_span){close + 1, end});
    }
    return true;
}

static struct aiMatrix4x4 matrix_of(const double n[6])
{
    double m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int axis = 0; axis < 3; axis++) {
        const double angle = n[3 + axis] * 3.14159265358979323846 / 180;
        const double c = cos(angle), s = sin(angle);
        const int i = (axis + 1) % 3, k = (axis + 2) % 3;
        for (int column = 0; column < 3; column++) {
            const double u = m[i][column], v = m[k][column];
            m[i][column] = c * u - s * v;
            m[k][column] = s * u + c * v;
        }
    }
    return (struct aiMatrix4x4){(float)m[0][0],
                                (float)m[0][1],
                                (float)m[0][2],
                                (float)n[0],
                                (float)m[1][0],
                                (float)m[1][1],
                                (float)m[1][2],
                                (float)n[1],
                                (float)m[2][0],
                                (float)m[2][1],
                                (float)m[2][2],
                                (float)n[2],
                                0,
                                0,
                                0,
                                1};
}

/* A constellation's instances follow each other. Deeper ones are refused later. */
static void place(const struct aiNode *node, const rk_mesh_hints *hints, int depth)
{
    const bool is_named = node->mName.length > 0 && node->mNumChildren > 0;
    size_t first = is_named ? 0 : hints->place_count, count = 0;
    while (first < hints->place_count &&
           strcmp(hints->places[first].constellation, node->mName.data) != 0)
        first++;
    while (first + count < hints->place_count &&
           strcmp(hints->places[first + count].constellation, node->mName.data) == 0)
        count++;
    for (uint32_t i = 0; i < node->mNumChildren && depth < 1000; i++) {
        if (count == node->mNumChildren)
            node->mChildren[i]->mTransformation = matrix_of(hints->places[first + i].numbers);
        place(node->mChildren[i], hints, depth + 1);
    }
}

void rk_mesh_amf_places_apply(const struct aiScene *scene, const rk_mesh_hints *hints)
{
    if (hints->place_count > 0 && scene->mRootNode)
        place(scene->mRootNode, hints, 0);
}
