/* Assimp's meshes have arrays of the same form, so that nothing is copied. */
#include "io/mesh_helper/mesh_attributes.h"

#include <assert.h>
#include <stddef.h>

static_assert(sizeof(struct aiVector3D) == sizeof(float[3]), "built with single precision");
static_assert(sizeof(struct aiColor4D) == sizeof(float[4]), "built with single precision");

void rk_mesh_attributes_lend(const struct aiScene *scene, const rk_mesh_hints *hints)
{
    if (scene->mNumMeshes != 1 || scene->mMeshes[0]->mNumVertices != hints->vertices)
        return;
    struct aiMesh *mesh = scene->mMeshes[0];
    if (hints->normals && !mesh->mNormals)
        mesh->mNormals = (struct aiVector3D *)hints->normals;
    if (hints->colours && !mesh->mColors[0])
        mesh->mColors[0] = (struct aiColor4D *)hints->colours;
    if (hints->texcoords && !mesh->mTextureCoords[0])
        mesh->mTextureCoords[0] = (struct aiVector3D *)hints->texcoords;
}
