/* Checks a mesh file before Assimp reads it, to report faults with their lines: Assimp accepts,
 * drops or crashes on many that a user should know about. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_SYNTAX_H
#define RK_IO_MESH_HELPER_MESH_SYNTAX_H

#include "base/error.h"
#include "io/mesh_helper/json_cursor.h"

#include <stdint.h>

enum { RK_MESH_HINTS_FOLDERS = 8 };

/* Stands for the name of a picture that has none, on which Assimp would abort. */
#define RK_MESH_NO_PICTURE "raykit: no picture's name"

/* Further results of the check. */
typedef struct rk_mesh_hints {
    bool plain;            /* no surface has a material: Assimp's grey does not count */
    rk_error note;         /* a warning for the user, or "" */
    char *text;            /* the corrected file, which Assimp is to read instead; or NULL */
    size_t size;           /* of the text */
    size_t faces, corners; /* that Assimp should find, faces of three or more; 0: not counted */
    size_t vertices;       /* the same; 0 where Assimp makes one of each corner, as of OBJ */
    /* Of vertices in the file's order, where Assimp does not read them; or NULL. */
    float (*normals)[3], (*colours)[4], (*texcoords)[3];
    struct rk_mesh_colours_face *face_colours; /* of OFF, PLY and STL, one a face, or NULL */
    size_t face_colour_count;
    float (*wedges)[2]; /* texture coordinates of a PLY file's corners, face by face of three or
                           more; or NULL */
    size_t wedge_count;
    struct rk_mesh_gltf_parts_one *parts; /* of a glTF file, in its order, or NULL */
    size_t part_count;
    struct rk_mesh_amf_place *places; /* of an AMF file's instances, in its order, or NULL */
    size_t place_count;
    size_t models;         /* in the archive of a 3MF file, of which Assimp reads one */
    bool has_wide_draco;   /* compressed indices of 32 bits, which Assimp does not decode */
    size_t uses;           /* usemtl lines of an OBJ file */
    uint32_t up;           /* the axis that a Collada file names, 1 to 3 for x to z; or 0 */
    bool pictures_replace; /* the diffuse colour, as in X3D before 4.0 */
    bool is_gltf_1;        /* version 1.0, of which Assimp reads some */
    char undrawn[256];     /* nodes of an X3D file that Assimp leaves out, or "" */
    char missing[256]; /* the name of a file that a glTF or X3D file needs, if it is not there, or
                          "" */
    char folders[RK_MESH_HINTS_FOLDERS][1024]; /* of material files, relative, with a slash */
    int folder_count;
} rk_mesh_hints;

/* Adds to the note, which names the file once. */
void rk_mesh_hints_note(rk_mesh_hints *hints, const char *path, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* True if the file exists and no fault is found; formats without a checker here pass. False with an
 * error `FILE: what` or `FILE:LINE: what`. */
bool rk_mesh_syntax_check(const char *path, rk_mesh_hints *hints, rk_error *error);

/* Each checks one format, given the file's bytes (no NUL at the end). */
bool rk_mesh_syntax_obj(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_ply(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_off(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_stl(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_3mf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_amf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_ac(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                       rk_error *error);
bool rk_mesh_syntax_x3d(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_dae(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_3ds(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_fbx(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_glb(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_gltf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                         rk_error *error);

/* The same for a part of the file. */
bool rk_mesh_syntax_gltf_part(const char *path, json_cursor part, json_cursor file,
                              rk_mesh_hints *hints, rk_error *error);

#endif
