/* Assimp turns no FBX file, and Collada files if it is not told to leave them: whoever asks for an
 * axis that the file names, too, would get a mesh that is turned twice. */
#include "io/mesh_helper/mesh_up.h"

#include "io/mesh_helper/mesh_files.h"

#include <string.h>

uint32_t rk_mesh_up_of_collada(const char *text, size_t size)
{
    static const char word[] = "<up_axis>", blanks[] = " \t\r\n";
    const char *const end = text + size;
    for (const char *at = text; (at = memchr(at, '<', (size_t)(end - at))); at++) {
        if ((size_t)(end - at) < sizeof word || memcmp(at, word, sizeof word - 1) != 0)
            continue;
        for (at += sizeof word - 1; at < end && *at && strchr(blanks, *at);)
            at++;
        const bool is_axis = end - at >= 4 && memcmp(at + 1, "_UP", 3) == 0;
        return is_axis && *at >= 'X' && *at <= 'Z' ? (uint32_t)(*at - 'X') + 1 : 0;
    }
    return 0;
}

static int32_t number_of(const struct aiScene *scene, const char *name, int32_t otherwise)
{
    const struct aiMetadata *data = scene->mMetaData;
    int32_t number = otherwise;
    for (uint32_t i = 0; data && i < data->mNumProperties; i++)
        if (data->mValues[i].mType == AI_INT32 && strcmp(data->mKeys[i].data, name) == 0)
            memcpy(&number, data->mValues[i].mData, sizeof number);
    return number;
}

static rk_vec3 turned(rk_vec3 v, int32_t axis)
{
    return rk_vec(axis == 0 ? v.x : -v.x, axis == 1 ? v.y : -v.y, axis == 2 ? v.z : -v.z);
}

static void turn_by_half(rk_mesh *mesh, int32_t axis)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        mesh->positions[i] = turned(mesh->positions[i], axis);
        if (mesh->normals)
            mesh->normals[i] = turned(mesh->normals[i], axis);
    }
}

static void set_of_fbx(rk_mesh *mesh, const struct aiScene *scene)
{
    const int32_t up = number_of(scene, "UpAxis", -1);
    if (up < 0 || up > 2)
        return;
    mesh->up = (uint32_t)up + 1;
    int32_t front = number_of(scene, "FrontAxis", -1);
    if (front < 0 || front > 2 || front == up)
        front = up == 1 ? 2 : 1;
    if (number_of(scene, "UpAxisSign", 1) < 0)
        turn_by_half(mesh, front);
}

void rk_mesh_up_set(rk_mesh *mesh, const struct aiScene *scene, const char *path, uint32_t named)
{
    mesh->up = named;
    if (rk_mesh_files_has_ending(path, "blend") || rk_mesh_files_has_ending(path, "3mf"))
        mesh->up = 3;
    if (rk_mesh_files_has_ending(path, "fbx"))
        set_of_fbx(mesh, scene);
}
