/* Assimp says of them that it has no reader, or takes them for another format. */
#include "io/mesh_helper/mesh_unread.h"

#include <string.h>
#include <strings.h>

static const char solid[] = "is a CAD model of exact surfaces";
static const char solid_remedy[] =
    "open it in a CAD program, such as FreeCAD, and export it as STL or OBJ";
static const char points[] = "holds points, and no triangles";
static const char points_remedy[] =
    "reconstruct its surface, for instance in MeshLab, and save that";
static const char splats[] = "holds Gaussian splats, and no triangles";
static const char scene[] = "has a format that Assimp does not read";
static const char blender_remedy[] = "open it in Blender, and export it as glTF";

static const struct {
    const char *ending, *what, *remedy;
} formats[] = {
    {"step", solid, solid_remedy},
    {"stp", solid, solid_remedy},
    {"iges", solid, solid_remedy},
    {"igs", solid, solid_remedy},
    {"brep", solid, solid_remedy},
    {"fcstd", solid, solid_remedy},
    {"sldprt", solid, "export it as STL or OBJ in its CAD program"},
    {"x_t", solid, "export it as STL or OBJ in its CAD program"},
    {"pcd", points, points_remedy},
    {"las", points, points_remedy},
    {"laz", points, points_remedy},
    {"e57", points, points_remedy},
    {"xyz", points, points_remedy},
    {"pts", points, points_remedy},
    {"splat", splats, "choose a mesh with faces"},
    {"ksplat", splats, "choose a mesh with faces"},
    {"spz", splats, "choose a mesh with faces"},
    {"usd", scene, blender_remedy},
    {"usda", scene, blender_remedy},
    {"usdc", scene, blender_remedy},
    {"usdz", scene, blender_remedy},
    {"abc", scene, blender_remedy},
    {"wrl", scene, "open it in MeshLab, and export it as PLY or OBJ"},
    {"wrz", scene, "open it in MeshLab, and export it as PLY or OBJ"},
    {"vtk", scene, "open it in ParaView, and save it as PLY"},
    {"vtp", scene, "open it in ParaView, and save it as PLY"},
    {"vtu", scene, "open it in ParaView, and save it as PLY"},
    {"drc", "is compressed by Draco", "convert it to PLY, for instance by draco_decoder"},
    {"scad", "is a program of OpenSCAD", "open it there, and export it as STL"},
    {"zip", "is an archive", "unzip it, and name the mesh in it"},
    {"7z", "is an archive", "open it, and name the mesh in it"},
    {"rar", "is an archive", "open it, and name the mesh in it"},
    {"tar", "is an archive", "open it, and name the mesh in it"},
};

static bool begins_with(const char *text, size_t size, const char *word)
{
    return size >= strlen(word) && memcmp(text, word, strlen(word)) == 0;
}

/* MeshLab reads VRML 2.0, uncompressed. */
static bool check_vrml(const char *path, const char *text, size_t size, rk_error *error)
{
    if (begins_with(text, size, "\x1f\x8b"))
        return rk_fail(error,
                       "%s: is VRML compressed by gzip: gunzip it (gzip -dc), open it in MeshLab, "
                       "and export it as PLY or OBJ",
                       path);
    if (begins_with(text, size, "#VRML V1.0"))
        return rk_fail(error,
                       "%s: is VRML 1.0, which Assimp does not read: convert it to VRML 2.0, open "
                       "that in MeshLab, and export it as PLY or OBJ",
                       path);
    return true;
}

/* Blitz3D's begin with their mark; BVE's have sections. */
static bool check_b3d(const char *path, const char *text, size_t size, rk_error *error)
{
    static const char section[] = "[MeshBuilder]";
    if (begins_with(text, size, "BB3D"))
        return true;
    for (size_t i = 0; i + sizeof section <= size && i < 1 << 16; i++)
        if (strncasecmp(text + i, section, sizeof section - 1) == 0)
            return rk_fail(error,
                           "%s: is a text of train simulators (BVE, OpenBVE), which is not read: "
                           "open it in Blender by an add-on, and export it as glTF",
                           path);
    return rk_fail(error,
                   "%s: does not begin with BB3D, as Blitz3D's files do: rename it with the ending "
                   "of its format, or export it again",
                   path);
}

bool rk_mesh_unread_check(const char *path, const char *text, size_t size, rk_error *error)
{
    const char *dot = strrchr(path, '.');
    const bool is_vrml = dot && (strcasecmp(dot, ".wrl") == 0 || strcasecmp(dot, ".wrz") == 0);
    if (is_vrml && !check_vrml(path, text, size, error))
        return false;
    if (dot && strcasecmp(dot, ".b3d") == 0 && !check_b3d(path, text, size, error))
        return false;
    for (size_t i = 0; dot && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(dot + 1, formats[i].ending) == 0) {
            const char *const remedy = formats[i].remedy;
            return rk_fail(error, "%s: %s: %s", path, formats[i].what, remedy);
        }
    return true;
}
