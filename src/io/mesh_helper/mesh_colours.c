/* Formats do not say how their colours are encoded; this is what programs that write them do. */
#include "io/mesh_helper/mesh_colours.h"

#include "base/image.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool has_ending(const char *path, const char *const *endings)
{
    const char *dot = strrchr(path, '.');
    for (int i = 0; dot && endings[i]; i++)
        if (strcasecmp(dot + 1, endings[i]) == 0)
            return true;
    return false;
}

static void see(rk_mesh_colours *colours, rk_vec3 rgb)
{
    colours->any |= !(rgb.x == 1 && rgb.y == 1 && rgb.z == 1);
    if (isfinite(rgb.x + rgb.y + rgb.z) && (rgb.x > 1 || rgb.y > 1 || rgb.z > 1))
        colours->scale = 1 / 255.0f;
}

/* Faces of several materials are not in the file's order any more. */
static void take_faces(rk_mesh_colours *colours, const struct aiScene *scene, rk_mesh_hints *hints)
{
    if (scene->mNumMeshes != 1) {
        colours->torn = true;
        return;
    }
    colours->faces = hints->face_colours;
    colours->face_count = (uint32_t)hints->face_colour_count;
    hints->face_colours = NULL;
}

static bool lacks(const rk_mesh_colours *colours, const struct aiColor4D *c)
{
    return colours->may_lack && c->a == 0 && c->r == 0 && c->g == 0 && c->b == 0;
}

void rk_mesh_colours_init(rk_mesh_colours *colours, const struct aiScene *scene, const char *path,
                          rk_mesh_hints *hints)
{
    *colours = (rk_mesh_colours){
        .is_gltf = has_ending(path, (const char *const[]){"gltf", "glb", "vrm", NULL}),
        .replace = has_ending(path, (const char *const[]){"obj", "ply", "off", "stl", "x3d", NULL}),
        .may_lack = has_ending(path, (const char *const[]){"amf", NULL}),
        .scale = 1};
    const bool is_obj = has_ending(path, (const char *const[]){"obj", NULL});
    const bool is_stl = has_ending(path, (const char *const[]){"stl", NULL});
    bool has_alpha = false;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        const struct aiMesh *mesh = scene->mMeshes[i];
        for (uint32_t k = 0; mesh->mColors[0] && k < mesh->mNumVertices; k++) {
            if (!lacks(colours, &mesh->mColors[0][k]))
                see(colours, rk_mesh_colours_rgb(&mesh->mColors[0][k]));
            colours->is_clear |= colours->is_gltf && mesh->mColors[0][k].a < 1;
            has_alpha |= mesh->mColors[0][k].a > 0;
            colours->torn |= is_obj && !(mesh->mColors[0][k].a > 0);
        }
    }
    colours->any &= !colours->torn;
    colours->is_clear &= has_alpha; /* Assimp makes it 0 where colours have three numbers */
    if ((!colours->any || is_stl) && hints->face_colour_count > 0)
        take_faces(colours, scene, hints);
    for (uint32_t i = 0; i < colours->face_count; i++)
        if (colours->faces[i].rgb.x >= 0)
            see(colours, colours->faces[i].rgb);
}

void rk_mesh_colours_free(rk_mesh_colours *colours)
{
    free(colours->faces);
    *colours = (rk_mesh_colours){0};
}

static float linear(const rk_mesh_colours *colours, float value)
{
    value = isfinite(value) ? value * colours->scale : 0;
    if (!colours->is_gltf)
        return rk_srgb_decode(value);
    return value > 0 ? (value < 1 ? value : 1) : 0;
}

rk_vec3 rk_mesh_colour(const rk_mesh_colours *colours, rk_vec3 rgb)
{
    return rk_vec(linear(colours, rgb.x), linear(colours, rgb.y), linear(colours, rgb.z));
}

/* Where there is none, the grey of a surface without material. */
rk_vec3 rk_mesh_colours_vertex(const rk_mesh_colours *colours, const struct aiColor4D *colour)
{
    return lacks(colours, colour) ? rk_vec(0.8f, 0.8f, 0.8f)
                                  : rk_mesh_colour(colours, rk_mesh_colours_rgb(colour));
}

/* Assimp leaves out some faces, such as those with more than nine corners. */
rk_vec3 rk_mesh_colours_next_face(rk_mesh_colours *colours, uint32_t corners)
{
    while (colours->next_face < colours->face_count) {
        const rk_mesh_colours_face *face = &colours->faces[colours->next_face++];
        if (face->corners != corners)
            continue;
        colours->is_unfinite = !isfinite(face->rgb.x + face->rgb.y + face->rgb.z);
        return face->rgb.x >= 0 || colours->is_unfinite ? rk_mesh_colour(colours, face->rgb)
                                                        : rk_vec(1, 1, 1);
    }
    return rk_vec(1, 1, 1);
}
