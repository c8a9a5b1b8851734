/* A vertex stands at the weighted mean of where its bones put it: each by its offset, from the
 * part's coordinates to the joint's as it was bound, and then by the joint's place. The part's node
 * does not move it. Only glTF says so clearly: what the nodes of an FBX or a Collada file say
 * differs from what programs show, which is told, and Assimp poses others itself. Formulas:
 * Khronos, "glTF 2.0 Specification", section 3.7.3.
 */
#include "io/mesh_helper/mesh_skin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { deepest_node = 1000 };

static bool has_ending(const char *path, const char *const *endings)
{
    const char *dot = strrchr(path, '.');
    for (; dot && *endings; endings++)
        if (strcasecmp(dot, *endings) == 0)
            return true;
    return false;
}

static size_t count_nodes(const struct aiNode *node, int depth)
{
    size_t count = 1;
    for (uint32_t i = 0; i < node->mNumChildren && depth < deepest_node; i++)
        count += count_nodes(node->mChildren[i], depth + 1);
    return count;
}

static void add_nodes(rk_mesh_skin *skin, const struct aiNode *node, const rk_mesh_place *parent,
                      int depth)
{
    rk_mesh_skin_joint *joint = &skin->joints[skin->count++];
    joint->name = node->mName.data;
    joint->place = rk_mesh_place_in(parent, &node->mTransformation);
    const rk_mesh_place place = joint->place;
    for (uint32_t i = 0; i < node->mNumChildren && depth < deepest_node; i++)
        add_nodes(skin, node->mChildren[i], &place, depth + 1);
}

static int by_name(const void *a, const void *b)
{
    const rk_mesh_skin_joint *x = a, *y = b;
    return strcmp(x->name, y->name);
}

bool rk_mesh_skin_begin(rk_mesh_skin *skin, const struct aiScene *scene, const char *path,
                        rk_error *error)
{
    const rk_mesh_place world = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, true};
    bool has_bones = false;
    *skin = (rk_mesh_skin){0};
    for (uint32_t i = 0; i < scene->mNumMeshes; i++)
        has_bones |= scene->mMeshes[i]->mNumBones > 0;
    skin->is_told = has_ending(path, (const char *const[]){".dae", ".fbx", NULL});
    if (!has_bones ||
        !(skin->is_told || has_ending(path, (const char *const[]){".gltf", ".glb", ".vrm", NULL})))
        return true;
    skin->joints = rk_allocate(count_nodes(scene->mRootNode, 0), sizeof *skin->joints, path, error);
    if (!skin->joints)
        return false;
    add_nodes(skin, scene->mRootNode, &world, 0);
    qsort(skin->joints, skin->count, sizeof *skin->joints, by_name);
    for (size_t i = 1; i < skin->count; i++) {
        rk_mesh_skin_joint *a = &skin->joints[i - 1], *b = &skin->joints[i];
        b->is_unclear = strcmp(a->name, b->name) == 0 &&
                        (a->is_unclear || memcmp(a->place.m, b->place.m, sizeof a->place.m) != 0);
    }
    for (size_t i = skin->count; i-- > 1;)
        if (strcmp(skin->joints[i].name, skin->joints[i - 1].name) == 0)
            skin->joints[i - 1].is_unclear |= skin->joints[i].is_unclear;
    return true;
}

void rk_mesh_skin_end(rk_mesh_skin *skin)
{
    free(skin->joints);
    *skin = (rk_mesh_skin){0};
}

static void add_share(rk_mesh_place *sum, const rk_mesh_place *place, double weight)
{
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            sum->m[row][column] += weight * place->m[row][column];
}

static bool moves(const struct aiBone *bone, uint32_t i, uint32_t vertices)
{
    return bone->mWeights[i].mWeight > 0 && bone->mWeights[i].mVertexId < vertices;
}

static bool moves_any(const struct aiBone *bone, uint32_t vertices)
{
    for (uint32_t i = 0; bone->mWeights && i < bone->mNumWeights; i++)
        if (moves(bone, i, vertices))
            return true;
    return false;
}

/* False if a joint is missing or unclear. */
static bool add_bones(rk_mesh_skin *skin, const struct aiMesh *mesh, rk_mesh_place *places,
                      double *weights)
{
    for (uint32_t k = 0; k < mesh->mNumBones; k++) {
        const struct aiBone *bone = mesh->mBones[k];
        if (!moves_any(bone, mesh->mNumVertices))
            continue;
        const rk_mesh_skin_joint wanted = {.name = bone->mName.data};
        const rk_mesh_skin_joint *joint =
            bsearch(&wanted, skin->joints, skin->count, sizeof wanted, by_name);
        if (!joint || joint->is_unclear) {
            if (!skin->lost[0])
                snprintf(skin->lost, sizeof skin->lost, "%.90s", bone->mName.data);
            return false;
        }
        const rk_mesh_place place = rk_mesh_place_in(&joint->place, &bone->mOffsetMatrix);
        for (uint32_t i = 0; i < bone->mNumWeights; i++) {
            if (!moves(bone, i, mesh->mNumVertices))
                continue;
            const double weight = (double)bone->mWeights[i].mWeight;
            add_share(&places[bone->mWeights[i].mVertexId], &place, weight);
            weights[bone->mWeights[i].mVertexId] += weight;
        }
    }
    return true;
}

/* Exporters' matrices are rounded: a part that stays where it was keeps its numbers. */
static bool is_moved(const struct aiMesh *mesh, const rk_mesh_place *node,
                     const rk_mesh_place *places)
{
    double move = 0;
    rk_vec3 low = rk_vec(INFINITY, INFINITY, INFINITY), high = rk_negate(low);
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        const struct aiVector3D *v = &mesh->mVertices[i];
        const rk_vec3 at = rk_vec((float)v->x, (float)v->y, (float)v->z);
        const rk_vec3 from = rk_mesh_place_point(node, at);
        const rk_vec3 apart = rk_abs3(rk_sub(rk_mesh_place_point(&places[i], at), from));
        low = rk_min3(low, from);
        high = rk_max3(high, from);
        move = fmax(move, fmax((double)apart.x, fmax((double)apart.y, (double)apart.z)));
    }
    const double size =
        fmax((double)(high.x - low.x), fmax((double)(high.y - low.y), (double)(high.z - low.z)));
    return move > 1e-4 * size;
}

/* Vertices without a weight stay where the node puts them. */
static void settle(const struct aiMesh *mesh, const rk_mesh_place *node, rk_mesh_place *places,
                   const double *weights)
{
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        if (!(weights[i] > 0)) {
            places[i] = *node;
            continue;
        }
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 4; column++)
                places[i].m[row][column] /= weights[i];
    }
}

bool rk_mesh_skin_pose(rk_mesh_skin *skin, const struct aiMesh *mesh, const rk_mesh_place *node,
                       rk_mesh_place **places, const char *path, rk_error *error)
{
    *places = NULL;
    if (!skin->joints || mesh->mNumBones == 0 || !mesh->mBones || mesh->mNumVertices == 0)
        return true;
    rk_mesh_place *sums = rk_allocate(mesh->mNumVertices, sizeof *sums, path, error);
    double *weights = rk_allocate(mesh->mNumVertices, sizeof *weights, path, error);
    const bool ok = sums && weights;
    bool posed = ok && add_bones(skin, mesh, sums, weights);
    if (posed)
        settle(mesh, node, sums, weights);
    posed = posed && is_moved(mesh, node, sums);
    free(weights);
    skin->is_unposed |= posed && skin->is_told;
    if (posed && !skin->is_told)
        *places = sums;
    else
        free(sums);
    return ok;
}
