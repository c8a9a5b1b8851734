/* Mesh files as exporters write them: what a format's manual allows, or what many programs do, and
 * Assimp reads otherwise. */
#include "test_mesh_reading.h"

#include "base/image.h"

/* --- OBJ ------------------------------------------------------------------------------------ */

#define CORNERS "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
#define FACE "f 1 2 3\n"

static void numbers_of_an_obj_may_begin_with_their_point(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("points.obj", "v .5 -.25 +.125e+01 .5 .0 1\nv 1 .0 0 1 1 1\n"
                                                 "v 0 1 .5e-001 1 1 1\nvt .5 .25\nvn .0 .0 1\n"
                                                 "f 1/1/1 2/1/1 3/1/1\n"));
    check_point(corner(&mesh, 0, 0), 0.5f, -0.25f, 1.25f);
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    check_point(corner(&mesh, 0, 2), 0, 1, 0.05f);
    check_point(mesh.colours[mesh.triangles[0][0]], rk_srgb_decode(0.5f), 0, 1);
    rk_check_close(mesh.texcoords[0].x, 0.5, 0, "vt .5 .25");
    check_point(mesh.normals[0], 0, 0, 1);
    rk_mesh_free(&mesh);
}

static void a_comment_may_follow_any_numbers_of_an_obj(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("comments.obj",
                   "v 0 0 0 # 1 2 3\nv 1 0 0 #two\nv 1 1 0# three\nv 0 1 0\t# .5\n"
                   "vt 0 0 # 0\nvt 1 .5 # of .25\nvn 0 0 1 # up\ng all # of it\ns 1 # one\n"
                   "l 1 2 # edge 3\nf 1/1/1 2/2/1 \\\n3/1/1 4/1/1 # face 5\nf 1 2 3#6\n"),
        "has points or lines");
    rk_check_equal(mesh.triangle_count, 3, "a quad and a triangle");
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_check(!mesh.colours, "a comment's numbers are no colour");
    rk_mesh_free(&mesh);
}

/* The manual: it is for curves and surfaces only. Assimp divides by it. */
static void a_vertex_weight_moves_nothing(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("weights.obj", "v .5 0 0 .1\nv 1 0 0 0.5\nv 0 1 0 0\n" FACE));
    check_point(corner(&mesh, 0, 0), 0.5f, 0, 0);
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    check_point(corner(&mesh, 0, 2), 0, 1, 0);
    rk_mesh_free(&mesh);
}

/* As scripts write it. */
static void the_opacity_of_an_obj_vertex_is_left_out(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("opacity.obj", "v 0 0 0 .5 .25 1 .5\nv 1 0 0 1 0 0 1.0\n"
                                                  "v 0 1 0 0.5 1 1 0\n" FACE));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    check_point(mesh.colours[mesh.triangles[0][1]], 1, 0, 0);
    rk_check_close(mesh.colours[mesh.triangles[0][0]].y, rk_srgb_decode(0.25f), 1e-6, "green");
    rk_mesh_free(&mesh);
}

static rk_material material_of(const char *lines)
{
    write_text("lines.mtl", lines);
    rk_mesh mesh = load(write_text("lines.obj", "mtllib lines.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                "usemtl a\n" FACE));
    rk_material material = mesh.materials[mesh.triangle_materials[0]];
    rk_mesh_free(&mesh);
    return material;
}

/* Blender's exporter writes the first. */
static void a_line_that_assimp_does_not_know_costs_no_material(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "Pr 0.5\nPm 0.1\nPs 0\nPc 0\nPcr 0.03\naniso 0.1\nanisor 0\n",
        "d -halo 0.5\n",
        "Kd\nKs xyz 0.2 0.2 0.2\n",
        "  ext 1 2\n\tdecal -mm 0 1\nsharpness 60\n",
        "description made by hand\n",
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[300];
        snprintf(text, sizeof text, "\xef\xbb\xbf# PBR\n  newmtl a\n%sKd 1 .5 0\n", lines[i]);
        rk_material material = material_of(text);
        check_point(material.kd, 1, 0.5f, 0);
        check_point(rk_vec(material.alpha, 0, 0), 1, 0, 0);
    }
}

static void text_in_utf16_is_read_like_utf8(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } files[] = {
        {"wide.obj", "mtllib wide.mtl\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nusemtl a\r\n"
                     "f 1 2 3\r\n"},
        {"wide.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                     "property float y\nproperty float z\nelement face 1\n"
                     "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
                     "3 0 1 2\n"},
        {"wide.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {"wide.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                     "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        for (int kind = 0; kind < 4; kind++) { /* ends, with a mark or without */
            write_utf16("wide.mtl", "newmtl a\r\nKd 1 .5 0\r\n", kind & 1, kind & 2);
            rk_mesh mesh = load(write_utf16(files[i].name, files[i].text, kind & 1, kind & 2));
            rk_check_equal(mesh.triangle_count, 1, files[i].name);
            check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
            if (i == 0)
                check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 0.5f, 0);
            rk_mesh_free(&mesh);
        }
    rk_mesh mesh = load(write_text("mark.ply", "\xef\xbb\xbf"
                                               "ply\nformat ascii 1.0\nelement vertex 3\n"
                                               "property float x\nproperty float y\n"
                                               "property float z\nelement face 1\n"
                                               "property list uchar int vertex_indices\n"
                                               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    rk_mesh_free(&mesh);
    check_refused_path(test_folder_write(&folder, "half.obj", "\xff\xfev\0\0\xd8 \0", 8, 0600).text,
                       ": its text is in UTF-16, but damaged: save it as UTF-8", "");
    check_refused_path(write_utf16("short.obj", "v 0\n", false, true).text,
                       ":1: a v line needs three numbers", "");
}

static void the_picture_of_a_black_material_is_drawn(void **state)
{
    (void)state;
    test_folder_write(&folder, "a.ppm", "P6\n1 1\n255\n\377\0\0", 14, 0600);
    write_text("black.mtl", "newmtl a\nKd 0 0 0\nmap_Kd a.ppm\nnewmtl b\nKd 0 0 0\n");
    rk_mesh mesh = load_with_note(
        write_text("black.obj", "mtllib black.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\n"
                                "f 1/1 2/1 3/1\nusemtl b\nf 1/1 2/1 3/1\n"),
        "Kd 0 0 0 makes a picture (map_Kd) black; the picture is drawn as it is");
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 1, 1);
    check_point(mesh.materials[mesh.triangle_materials[1]].kd, 0, 0, 0);
    rk_mesh_free(&mesh);
}

static void words_of_an_mtl_may_be_in_capitals(void **state)
{
    (void)state;
    rk_material material = material_of("NEWMTL a\nKD 1 .5 0\nKS 0 0 1\nD 0.5\n");
    check_point(material.kd, 1, 0.5f, 0);
    check_point(material.ks, 0, 0, 1);
    rk_check_close(material.alpha, 0.5, 0, "D 0.5");
}

static void control_characters_in_a_name_are_escaped(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(write_text("control.obj", "mtllib a\x1b[2Jb.mtl\n" CORNERS FACE),
                                  "the material file a\\x1b[2Jb.mtl is missing");
    rk_mesh_free(&mesh);
    write_text("control.mtl", "newmtl a\nmap_Kd b\ac.ppm\n");
    mesh = load_with_note(write_text("control.obj",
                                     "mtllib control.mtl\nvt 0 0\n" CORNERS
                                     "usemtl a\nf 1/1 2/1 3/1\nusemtl \x1b[1m\nf 1/1 2/1 3/1\n"),
                          "(the first: \\x1b[1m), whose surfaces are grey");
    rk_mesh_free(&mesh);
    mesh = load_with_note(test_folder_path(&folder, "control.obj"), "b\\x07c.ppm: No such file");
    rk_mesh_free(&mesh);
}

static void check_told(const char *obj, const char *note, float kd)
{
    rk_mesh mesh = load_with_note(write_text("told.obj", obj), note);
    check_point(mesh.materials[mesh.triangle_materials[mesh.triangle_count - 1]].kd, kd, kd, kd);
    rk_mesh_free(&mesh);
}

static void a_material_that_no_file_has_is_named(void **state)
{
    (void)state;
    write_text("one.mtl", "newmtl red\nKd 1 0 0\n");
    write_text("empty.mtl", "# none\n");
    check_told("mtllib one.mtl\n" CORNERS "usemtl red\n" FACE "usemtl lost one\n" FACE,
               "uses 1 material that no material file has (the first: lost one)", 0.8f);
    check_told("mtllib empty.mtl\n" CORNERS "usemtl red\n" FACE,
               "uses 1 material that no material file has (the first: red)", 0.8f);
    check_told("mtllib one.mtl a.mtl b.mtl\n" CORNERS "usemtl red\n" FACE "usemtl blue\n" FACE,
               ":1: the material file a.mtl, b.mtl is missing: surfaces of its materials are grey",
               0.8f);
    check_told(CORNERS "usemtl red\n" FACE,
               "uses materials (usemtl red), but names no material file (mtllib)", 0.8f);
    check_told(
        "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nusemtl red\n" FACE,
        ": the material file a.mtl is missing: surfaces have only the colours of their vertices",
        1);
    static const char *const silent[] = {
        CORNERS "usemtl None\n" FACE,
        "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nusemtl red\n" FACE,
        "mtllib one.mtl\n" CORNERS FACE "usemtl red\n" FACE "usemtl (null)\n" FACE,
    };
    for (size_t i = 0; i < sizeof silent / sizeof *silent; i++) {
        rk_mesh mesh = load(write_text("silent.obj", silent[i]));
        rk_mesh_free(&mesh);
    }
}

/* A name may have the sign in it, as 3ds Max writes it. */
static void a_comment_may_follow_the_name_of_a_material(void **state)
{
    (void)state;
    write_text("named.mtl", "newmtl red\nKd 1 0 0\nnewmtl Material #2\nKd 0 1 0\nnewmtl a#b\n"
                            "Kd 0 0 1\nnewmtl Material\nKd 1 1 1\n");
    rk_mesh mesh = load(write_text("named.obj", "mtllib named.mtl # all of them\n" CORNERS
                                                "usemtl red # shiny # 2\n" FACE
                                                "usemtl Material #2 # green\n" FACE
                                                "usemtl a#b\t#c\n" FACE "usemtl red\n" FACE));
    rk_check_equal(mesh.triangle_count, 4, "triangles");
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        const rk_vec3 kd = mesh.materials[mesh.triangle_materials[i]].kd;
        check_point(kd, i == 0 || i == 3, i == 1, i == 2);
    }
    rk_mesh_free(&mesh);
}

static void a_comment_may_follow_the_name_of_a_new_material(void **state)
{
    (void)state;
    write_text("new.mtl", "newmtl red # shiny\nKd 1 0 0\nnewmtl Material #2\nKd 0 1 0\n"
                          "newmtl Material\t#none\nKd 0 0 1\nnewmtl red#ish\nKd 1 1 1\n");
    rk_mesh mesh =
        load(write_text("new.obj", "mtllib new.mtl\n" CORNERS "usemtl red\n" FACE
                                   "usemtl Material #2\n" FACE "usemtl red # dull\n" FACE));
    for (uint32_t i = 0; i < mesh.triangle_count; i++)
        check_point(mesh.materials[mesh.triangle_materials[i]].kd, i != 1, i == 1, 0);
    rk_mesh_free(&mesh);
}

/* Assimp gives them a later one. */
static void faces_before_the_first_material_have_none(void **state)
{
    (void)state;
    write_text("later.mtl", "newmtl red\nKd 1 0 0\n");
    static const char *const files[] = {
        "mtllib later.mtl\n" CORNERS FACE "usemtl red\n" FACE,
        "mtllib later.mtl\n" CORNERS "o a\n" FACE "g b\nusemtl red\n" FACE,
    };
    for (size_t i = 0; i < 2; i++) {
        rk_mesh mesh = load(write_text("later.obj", files[i]));
        rk_check_equal(mesh.triangle_count, 2, "triangles");
        check_point(mesh.materials[mesh.triangle_materials[0]].kd, 0.8f, 0.8f, 0.8f);
        check_point(mesh.materials[mesh.triangle_materials[1]].kd, 1, 0, 0);
        rk_mesh_free(&mesh);
    }
}

static void invisible_materials_are_told(void **state)
{
    (void)state;
    write_text("clear.mtl", "newmtl a\nKd .5 .5 .5\nd 0\nnewmtl b\nKd 1 1 1\nd 0.5\n");
    check_told(
        "mtllib clear.mtl\n" CORNERS "usemtl a\n" FACE,
        "1 of 1 materials have an opacity of 0 (such as d 0), so that --transparency shows nothing",
        0.5f);
    check_told("mtllib clear.mtl\n" CORNERS "usemtl a\n" FACE "usemtl b\n" FACE,
               "1 of 2 materials have an opacity of 0", 1);
    rk_mesh mesh = load(write_text("half.obj", "mtllib clear.mtl\n" CORNERS "usemtl b\n" FACE));
    rk_mesh_free(&mesh);
}

static void a_mesh_without_any_area_says_so(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("line.obj", "v 0 0 0\nv .1 .2 .3\nv .3 .6 .9\nv 0 0 0\nf 1 2 3\nf 1 4 2\n"),
        "the corners of each triangle are on a line");
    rk_mesh_free(&mesh);
    mesh = load(write_text("thin.obj", "v 0 0 0\nv 1 0 0\nv 0 1e-5 0\n" FACE "f 1 1 2\n"));
    rk_mesh_free(&mesh);
}

static void a_mesh_in_gzip_names_the_program(void **state)
{
    (void)state;
    static const char *const names[] = {"a.obj", "a.ply", "a.off", "a.stl", "a.glb", "a.fbx"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_refused(names[i], "\x1f\x8b\10 \r 3", ": is compressed by gzip: rename it", "gunzip");
    check_refused("a.obj.gz", "\x1f\x8b\10 \r 3", ": is compressed by gzip: gunzip it", "");
    check_refused("a.blend", "\x28\xb5\x2f\xfd\xa0",
                  ": is compressed by Zstandard: save it uncompressed", "");
}

/* Assimp takes the first for a mesh without faces. */
static void a_refusal_names_the_true_reason_and_a_remedy(void **state)
{
    (void)state;
    check_refused("a.egg",
                  "<CoordinateSystem> { Z-Up }\n<VertexPool> p {\n<Vertex> 0 { 0 0 0 }\n}\n",
                  ": has a format that Assimp does not read: export it as glTF or OBJ", "");
    check_refused(
        "splats.ply",
        "ply\nformat ascii 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\n"
        "property uint packed_position\nelement sh 1\nproperty uchar f_rest_0\nend_header\n"
        "0\n1\n2\n",
        ": has no triangles, only points", "surface");
    check_refused("a.step",
                  "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n",
                  ": is a CAD model of exact surfaces", "FreeCAD, and export it as STL or OBJ");
    check_refused("a.irr", "<?xml version=\"1.0\"?>\n<irr_scene></irr_scene>\n", ": ",
                  "name one of the meshes that it uses");
    check_refused("a.blend", "BLENDER-v300", ": could not be read", "open it in Blender");
}

static void a_format_that_nothing_reads_has_its_own_remedy(void **state)
{
    (void)state;
    const struct {
        const char *name, *what, *remedy;
    } files[] = {
        {"a.IGES", "exact surfaces", "export it as STL or OBJ"},
        {"a.usdz", "Assimp does not read", "open it in Blender"},
        {"a.spz", "Gaussian splats", "choose a mesh"},
        {"a.las", "holds points", "reconstruct its surface"},
        {"a.vtp", "Assimp does not read", "save it as PLY"},
        {"a.drc", "Draco", "draco_decoder"},
        {"a.obj.zip", "is an archive", "unzip it, and name the mesh in it"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        check_refused(files[i].name, "\x1f\x8b\10 \r 3", ": ", files[i].what);
        check_refused(files[i].name, "\x1f\x8b\10 \r 3", ": ", files[i].remedy);
    }
}

static void vrml_is_refused_by_its_version_and_packing(void **state)
{
    (void)state;
    static const char *const names[] = {"a.wrl", "a.WRZ"};
    for (size_t i = 0; i < 2; i++) {
        check_refused(names[i], "\x1f\x8b\10 \r 3", ": is VRML compressed by gzip",
                      ": gunzip it (gzip -dc), open it in MeshLab");
        check_refused(names[i], "#VRML V1.0 ascii\nSeparator {}\n", ": is VRML 1.0",
                      ": convert it to VRML 2.0, open that in MeshLab");
        check_refused(names[i], "#VRML V2.0 utf8\nShape {}\n",
                      ": has a format that Assimp does not read",
                      ": open it in MeshLab, and export it as PLY or OBJ");
    }
}

static void a_material_file_without_a_known_line_costs_no_mesh(void **state)
{
    (void)state;
    static const char *const files[] = {"", "# none\n"};
    for (size_t i = 0; i < 2; i++) {
        write_text("none.mtl", files[i]);
        rk_mesh mesh =
            load_with_note(write_text("none.obj", "mtllib none.mtl\n" CORNERS "usemtl a\n" FACE),
                           "(the first: a)");
        rk_check_equal(mesh.triangle_count, 1, "it is drawn");
        rk_mesh_free(&mesh);
    }
}

static void what_an_obj_has_beside_faces_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *line, *note;
    } lines[] = {
        {"curv 0 1 1 2 3", "has curves or curved surfaces"},
        {"curv2 1 2 3", "has curves or curved surfaces"},
        {"surf 0 1 0 1 1 2 3", "has curves or curved surfaces"},
        {"bzp 1 2 3", "has curves or curved surfaces"},
        {"l 1 2", "has points or lines, which the picture does not show"},
        {"p 1 2", "has points or lines, which the picture does not show"},
        {"call other.obj", "calls other files (call or csh lines), which are not read"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[200];
        snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 0\n" FACE "%s\n", lines[i].line);
        rk_mesh mesh = load_with_note(write_text("beside.obj", text), lines[i].note);
        rk_check_equal(mesh.triangle_count, 1, lines[i].line);
        rk_mesh_free(&mesh);
    }
    check_refused("only.obj", "v 0 0 0\nv 1 0 0\nsurf 0 1 0 1 1 2\n",
                  ": has no face, only points, lines, curves or curved surfaces, which are not "
                  "drawn",
                  "export it as polygons");
}

#define MRGB "v 0 0 0\r\nv 1.5 0 0 # b\r\nv 0 1 0\r\n#MRGB ffFF8000ff00ff00\r\n"

static void colours_of_an_obj_as_zbrush_writes_them_are_drawn(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("zbrush.obj", MRGB "#MRGB 000000ff\r\nf 3 1 2\r\n"));
    const uint32_t *corners = mesh.triangles[0];
    check_point(mesh.colours[corners[0]], 0, 0, 1);
    rk_check_close(mesh.colours[corners[1]].y, rk_srgb_decode(128 / 255.0f), 1e-6,
                   "green, of six digits");
    check_point(mesh.colours[corners[2]], 0, 1, 0);
    check_point(corner(&mesh, 0, 2), 1.5f, 0, 0);
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_text("zbrush.obj", MRGB "f 3 1 2\r\n"),
                          "has 2 colours (#MRGB) for 3 vertices, which the picture does not show");
    rk_check(!mesh.colours, "colours of two of three vertices were drawn");
    rk_mesh_free(&mesh);
}

/* --- OFF ------------------------------------------------------------------------------------ */

/* A triangle whose vertices have these numbers after their positions. */
static test_path write_off(const char *word, const char *a, const char *b, const char *c)
{
    char text[400];
    snprintf(text, sizeof text, "%s\n3 1 0\n0 0 0 %s\n1 0 0 %s\n0 1 0 %s\n3 0 1 2\n", word, a, b,
             c);
    return write_text("prefix.off", text);
}

/* Normals (0, 0, 1), (0, .6, .8), (.6, 0, .8), colours red, green, blue, coordinates (0, 0), (1,
 * 0), (0, 1). */
static void an_offs_vertices_have_what_its_first_word_announces(void **state)
{
    (void)state;
    static const struct {
        const char *word, *a, *b, *c;
        bool normals, colours, texcoords;
    } files[] = {
        {"NOFF", "0 0 1", "0 .6 .8", ".6 0 .8", true, false, false},
        {"COFF", "255 0 0 255", "0 255 0 255", "0 0 255 255", false, true, false},
        {"COFF", "1 0 0", "0 1 0", "0 0 1", false, true, false},
        {"STOFF", "0 0", "1 0", "0 1", false, false, true},
        {"CNOFF", "0 0 1 1 0 0 1", "0 .6 .8 0 1 0 1", ".6 0 .8 0 0 1 1", true, true, false},
        {"NCOFF", "255 0 0 255 0 0 1", "0 255 0 255 0 .6 .8", "0 0 255 255 .6 0 .8", true, true,
         false},
        {"STCOFF", "1 0 0 1 0 0", "0 1 0 1 1 0", "0 0 1 1 0 1", false, true, true},
        {"STCNOFF", "0 0 1 1 0 0 0 0", "0 .6 .8 0 1 0 1 0", ".6 0 .8 0 0 1 0 1", true, true, true},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load(write_off(files[i].word, files[i].a, files[i].b, files[i].c));
        rk_check(!mesh.normals != files[i].normals && !mesh.colours != files[i].colours &&
                     !mesh.texcoords != files[i].texcoords,
                 "%s: normals %d, colours %d, texture coordinates %d", files[i].word,
                 !!mesh.normals, !!mesh.colours, !!mesh.texcoords);
        for (int k = 0; k < 3; k++) {
            const uint32_t at = mesh.triangles[0][k];
            if (mesh.normals)
                rk_check_close(mesh.normals[at].z, k == 0 ? 1 : 0.8, 1e-6, files[i].word);
            if (mesh.normals)
                rk_check_close(mesh.normals[at].y, k == 1 ? 0.6 : 0, 1e-6, files[i].word);
            if (mesh.colours)
                check_point(mesh.colours[at], k == 0, k == 1, k == 2);
            if (mesh.texcoords)
                rk_check(mesh.texcoords[at].x == (k == 1) && mesh.texcoords[at].y == (k == 2),
                         "%s: corner %d at (%g, %g)", files[i].word, k,
                         (double)mesh.texcoords[at].x, (double)mesh.texcoords[at].y);
        }
        rk_mesh_free(&mesh);
    }
}

static void an_off_that_is_not_shown_as_it_is_says_so(void **state)
{
    (void)state;
    rk_mesh mesh =
        load_with_note(write_off("OFF", "1 0 0", "1 0 0", "1 0 0"),
                       "has numbers in its vertices' lines that the first line does not announce");
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_off("COFF", "", "", ""),
                          "announces colours of vertices (C), but their lines have none");
    rk_mesh_free(&mesh);
    mesh = load_with_note(
        write_text("map.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1\n"),
        "has colours of faces as numbers of a colour map, which the picture does not show");
    rk_mesh_free(&mesh);
    mesh = load(write_text("two.off", "OFF\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    rk_check_equal(mesh.triangle_count, 1, "the number of edges is missing");
    rk_mesh_free(&mesh);
    check_refused("binary.off", "OFF BINARY\n\1\2\3", ":1: is a binary OFF file",
                  "save it as text");
    check_refused("four.off", "4OFF\n3 1 0\n", ":1: OFF in four or more dimensions", "");
    check_refused("n.off", "nOFF\n3\n3 1 0\n", ":1: OFF in four or more dimensions", "");
    check_refused_path(write_off("NOFF", "0 0 1", "0 1", "0 0 1").text, ":4: a vertex needs 6", "");
}

/* Geomview's manual: lines mean nothing, but that a face's colour ends with its line. */
static void rows_of_an_off_may_go_over_several_lines(void **state)
{
    (void)state;
    static const char *const rows[] = {
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n\n4 0 \n1 \n2 \n3 \n\n3 0\n1 2 1 0 0\n",
        "0 0 0 1 0 0\n1 1\n0 # third\n0 1 0\n4\n0 1 2\n3\n3 0 1 2 1 0 0\n",
        "90000 0 0\n90001 0 0\n90001 1 0\n90000 1 0\n4 0 1\n2 3\n3 0 1 2 1 0 0\n",
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[200];
        snprintf(text, sizeof text, "OFF\n4 2 0\n%s", rows[i]);
        rk_mesh mesh = load(write_text("loose.off", text));
        rk_check_equal(mesh.triangle_count, 3, "a square and a triangle");
        for (uint32_t k = 0; k < 3; k++)
            check_point(vector_area(&mesh, k), 0, 0, 0.5f);
        check_point(mesh.colours[mesh.triangles[1][0]], 1, 1, 1);
        check_point(mesh.colours[mesh.triangles[2][0]], 1, 0, 0);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load(write_text("loose.off", "COFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 1 0 0\n"
                                                "0 1 0 1 0 0\n3 0 1\n2\n"));
    check_point(mesh.colours[mesh.triangles[0][2]], 1, 0, 0);
    rk_mesh_free(&mesh);
    check_refused("short.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n3 0 1 2\n",
                  ":6: a face's index is missing", "");
    check_refused("more.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n2\n9\n",
                  ":6: a face's index is missing", "");
}

/* Geomview's manual calls the word optional; some programs write it in small letters. */
static void the_first_word_of_an_off_may_be_missing(void **state)
{
    (void)state;
    static const char *const words[] = {"", "off\n", "\n \r\n\n  OFF\n", "\tOff # by hand\n\n",
                                        "# by hand\n\n"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        char text[100];
        snprintf(text, sizeof text, "%s3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", words[i]);
        rk_mesh mesh = load(write_text("words.off", text));
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
}

/* Assimp takes a comment's line for a row. */
static void comments_of_an_off_may_be_anywhere(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "# a\nOFF\n# b\n\n4 2 5 # c\n# d\n0 0 0 # e\n\t# f\n1 0 0\n  # 7 8 9\n1 1 0\n\n0 1 0\n"
        "# g\n3 0 1 2 # h\n# 3 0 0 0\n3 0 2 3\n# i\n",
        "OFF\n4 2 5\n0 0 0 1 0 0\n# two lines of two\n1 1 0 0 1 0\n3 0 1 2\n3 # a face\n0 2 3\n",
    };
    for (int i = 0; i < 2; i++) {
        rk_mesh mesh = load(write_text("comments.off", texts[i]));
        rk_check_equal(mesh.triangle_count, 2, texts[i]);
        check_point(corner(&mesh, 0, 1), 1, 0, 0);
        check_point(corner(&mesh, 1, 2), 0, 1, 0);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load(write_text("colours.off", "COFF\n3 1 0\n0 0 0 255 0 0\n# next\n"
                                                  "1 0 0 255 0 0\n0 1 0 255 0 0\n# last\n"
                                                  "3 0 1 2\n"));
    check_point(mesh.colours[mesh.triangles[0][1]], 1, 0, 0);
    rk_mesh_free(&mesh);
}

static void transparent_faces_of_an_off_are_told(void **state)
{
    (void)state;
    static const struct {
        const char *colours[2];
        bool is_clear;
    } files[] = {{{"255 0 0 128", "0 0 255 255"}, true},
                 {{"255 0 0 255", "0 0 255"}, false},
                 {{"1 0 0 .5", "1 1 1"}, true},
                 {{"1 0 0 1", "0 0 1 1"}, false},
                 {{"1 0 0", "0 0 1"}, false}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char text[200];
        snprintf(text, sizeof text, "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 %s\n3 0 2 1 %s\n",
                 files[i].colours[0], files[i].colours[1]);
        test_path path = write_text("clear.off", text);
        rk_mesh mesh = files[i].is_clear
                           ? load_with_note(path, "has transparent colours of faces, which are "
                                                  "drawn as opaque")
                           : load(path);
        rk_mesh_free(&mesh);
    }
}

/* --- STL ------------------------------------------------------------------------------------ */

static void an_stl_may_be_in_capitals(void **state)
{
    (void)state;
    static const char *const begins[] = {"SOLID A", "solid A", " Solid"};
    for (size_t i = 0; i < sizeof begins / sizeof *begins; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "%s\r\nFACET NORMAL 0 0 1\r\nOUTER LOOP\r\nVERTEX 0 0 0\r\n"
                 "VERTEX 1.0E+00 0 0\r\nVERTEX 0 1 0\r\nENDLOOP\r\nENDFACET\r\nENDSOLID\r\n",
                 begins[i]);
        rk_mesh mesh = load(write_text("capitals.stl", text));
        rk_check_equal(mesh.triangle_count, 1, begins[i]);
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
}

/* A triangle for each of these sixteen bits. */
static test_path write_stl(const char *head, size_t head_size, const uint16_t *bits, uint32_t count)
{
    char bytes[84 + 50 * 8] = {0};
    memcpy(bytes, head, head_size);
    bytes[80] = (char)count;
    for (uint32_t i = 0; i < count; i++) {
        const float x = (float)i, one = 1;
        char *row = bytes + 84 + (size_t)50 * i;
        for (size_t k = 0; k < 3; k++)
            memcpy(row + 12 + 12 * k, &x, 4);
        memcpy(row + 28, &one, 4);
        memcpy(row + 44, &one, 4);
        row[48] = (char)bits[i];
        row[49] = (char)(bits[i] >> 8);
    }
    return test_folder_write(&folder, "bits.stl", bytes, 84 + (size_t)50 * count, 0600);
}

static void check_stl_colours(const rk_mesh *mesh, const rk_vec3 *want)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            check_point(mesh->colours[mesh->triangles[i][k]], want[i].x, want[i].y, want[i].z);
}

/* Red of VisCAM is in bits 10 to 14, of Magics in bits 0 to 4. */
static void colours_of_an_stl_are_in_its_programs_order(void **state)
{
    (void)state;
    static const uint16_t own_by_set[] = {0x801f, 0x83e0, 0xfc00}, own[] = {31, 0x3e0, 0x7c00};
    static const rk_vec3 rgb[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                         bgr[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
    static const char magics[] = "a part COLOR=\xff\0\xff\xff,MATERIAL=";
    static const char meshlab[] = "COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f \x7f\x7f\x7f ";
    rk_mesh mesh = load(write_stl("", 0, own_by_set, 3));
    check_stl_colours(&mesh, bgr);
    rk_mesh_free(&mesh);
    mesh = load(write_stl(meshlab, sizeof meshlab - 1, own_by_set, 3));
    check_stl_colours(&mesh, rgb);
    rk_mesh_free(&mesh);
    mesh = load(write_stl(magics, sizeof magics - 1, own, 3));
    check_stl_colours(&mesh, rgb);
    rk_mesh_free(&mesh);
    mesh = load(write_stl(magics, sizeof magics - 1, (const uint16_t[]){0x8000, 31, 0xffff}, 3));
    check_stl_colours(&mesh, (const rk_vec3[]){{1, 0, 1}, {1, 0, 0}, {1, 0, 1}});
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_stl("COLOR=\xff\0\0\x80", 10, own, 3),
                          "has a transparent colour, which is drawn as opaque");
    rk_mesh_free(&mesh);
}

/* --- PLY ------------------------------------------------------------------------------------ */

#define PLY(encoding, count) "ply\nformat " encoding " 1.0\nelement vertex " #count "\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define FACES(count) "element face " #count "\nproperty list uchar int vertex_indices\n"
#define SQUARE "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"

static void check_texcoord_at(const rk_mesh *mesh, uint32_t triangle, int k, float u, float v)
{
    const rk_vec2 got = mesh->texcoords[mesh->triangles[triangle][k]];
    rk_check(got.x == u && got.y == v, "triangle %u, corner %d: got (%g, %g), want (%g, %g)",
             triangle, k, (double)got.x, (double)got.y, (double)u, (double)v);
}

static void write_picture(const char *name)
{
    test_folder_write(&folder, name, "P6\n1 1\n255\n\377\0\0", 14, 0600);
}

#define CORNER(x, y) "vertex " #x " " #y " 0\n"

static void a_text_stl_with_larger_faces_is_told(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("square.stl",
                   "solid a\nfacet normal 0 0 1\nouter loop\n" CORNER(0, 0) CORNER(1, 0)
                       CORNER(1, 1) CORNER(0, 1) "endloop\nendfacet\nendsolid a\n"),
        "has 1 faces of 4 corners, but Assimp reads 1 of 3");
    rk_mesh_free(&mesh);
    mesh = load(write_text("triangle.stl",
                           "solid vertex\r\n  facet normal 0 0 1\r\n outer loop\r\n" CORNER(0, 0)
                               CORNER(1, 0) CORNER(1, 1) "endloop\nendfacet\nendsolid vertex\n"));
    rk_mesh_free(&mesh);
}

/* Two triangles of 50 bytes after their count, and perhaps more. */
static test_path write_counted(const char *name, uint32_t count, size_t size)
{
    static const float rows[2][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0},
                                      {0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 0}};
    char bytes[300] = "solid by count";
    memcpy(bytes + 80, &count, 4);
    for (size_t i = 0; i < 2; i++)
        memcpy(bytes + 84 + 50 * i, rows[i], 48);
    return test_folder_write(&folder, name, bytes, size, 0600);
}

static void a_binary_stl_may_have_a_wrong_count(void **state)
{
    (void)state;
    static const struct {
        uint32_t count;
        size_t size;
        uint32_t drawn;
    } files[] = {{0, 184, 2}, {UINT32_MAX, 184, 2}, {2, 250, 2}, {1, 184, 1}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load_with_note(write_counted("count.stl", files[i].count, files[i].size),
                                      " triangles, but has bytes of ");
        rk_check_equal(mesh.triangle_count, files[i].drawn, "triangles");
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
    check_refused_path(write_counted("cut.stl", 3, 184).text,
                       ": claims 3 triangles, but has 2: download or export it again", "");
    rk_mesh mesh = load(write_counted("right.stl", 2, 184));
    rk_mesh_free(&mesh);
}

static void a_plys_properties_may_have_other_names(void **state)
{
    (void)state;
    static const char properties[] =
        "property float X\nproperty float Y\nproperty float Z\nproperty float normal_x\n"
        "property float normal_y\nproperty float normal_z\n";
    char text[1000];
    snprintf(text, sizeof text,
             "%s%s%send_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 1 0\n3 0 1 2\n", PLY("ascii", 3),
             properties, FACES(1));
    rk_mesh mesh = load(write_text("names.ply", text));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    check_point(mesh.normals[mesh.triangles[0][2]], 0, 1, 0);
    rk_mesh_free(&mesh);
}

static void words_of_a_plys_header_may_have_any_blanks_between_them(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "blanks.ply",
        "ply\nformat  ascii\t1.0 \ncomment  a  b\n element  vertex 3 \r\n"
        "property\tfloat  x\nproperty float y  \nproperty float z\nelement face\t 1\n"
        "property list  uchar int  vertex_indices\nend_header\n0 0 0\n1  0 0\n0 1 0\n3 0 1 2\n"));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
    rk_mesh_free(&mesh);
}

static void comments_of_a_ply_may_stand_anywhere(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "remarks.ply",
        "ply\ncomment a\nformat ascii 1.0\nelement vertex 4\ncomment b\n"
        "property float x\nobj_info c\nproperty float y\nproperty float z\n"
        "comment d\nelement face 1\ncomment e\n"
        "property list uchar int vertex_indices\ncomment f\nend_header\n" SQUARE "4 0 1 2 3\n"));
    rk_check_equal(mesh.triangle_count, 2, "a square");
    check_point(vector_area(&mesh, 1), 0, 0, 0.5f);
    rk_mesh_free(&mesh);
}

/* Two faces that share an edge, on which they have different texture coordinates; the second has
 * none in the last file. MeshLab writes these lists. */
static void texture_coordinates_of_a_plys_corners_are_their_own(void **state)
{
    (void)state;
    write_picture("a.ppm");
#define WEDGES                                                                                     \
    PLY("ascii", 5)                                                                                \
    "comment TextureFile a.ppm\n" XYZ FACES(                                                       \
        2) "property list uchar float texcoord\nend_header\n" SQUARE "2 0 0\n"
    rk_mesh mesh = load(write_text("wedges.ply", WEDGES "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"
                                                        "3 1 4 2 6 0.25 0 0.5 0 0.75 1\n"));
    rk_check_equal(mesh.triangle_count, 3, "a square and a triangle");
    for (uint32_t i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) {
            const rk_vec3 at = corner(&mesh, i, k);
            check_texcoord_at(&mesh, i, k, at.x, at.y);
        }
    check_texcoord_at(&mesh, 2, 0, 0.25f, 0);
    check_texcoord_at(&mesh, 2, 1, 0.5f, 0);
    check_texcoord_at(&mesh, 2, 2, 0.75f, 1);
    rk_mesh_free(&mesh);
    mesh = load(write_text("some.ply", WEDGES "4 0 1 2 3 0\n3 1 4 2 6 .25 0 .5 0 .75 1\n"));
    check_texcoord_at(&mesh, 0, 1, 0, 0);
    check_texcoord_at(&mesh, 2, 2, 0.75f, 1);
    rk_mesh_free(&mesh);
#undef WEDGES
}

static rk_mesh load_binary(const char *name, const char *header, const void *rows, size_t size)
{
    char bytes[1000];
    const size_t length = strlen(header);
    memcpy(bytes, header, length);
    memcpy(bytes + length, rows, size);
    return load(test_folder_write(&folder, name, bytes, length + size, 0600));
}

/* The first number's lowest byte, and its highest, is each of the bytes that text has between
 * lines and words. */
static void rows_of_a_binary_ply_may_begin_with_any_byte(void **state)
{
    (void)state;
    static const char bytes[] = "\n\r \t";
    for (int i = 0; i < 4; i++)
        for (int big = 0; big < 2; big++) {
            const char first = bytes[i];
            char rows[9 * 4 + 13] = {0};
            memcpy(rows, big ? (char[]){first, 0, 0, 0} : (char[]){first, 0, (char)0x80, 63}, 4);
            memcpy(rows + 12, big ? "\77\200\0" : "\0\0\200\77", 4); /* 1 */
            memcpy(rows + 28, big ? "\77\200\0" : "\0\0\200\77", 4);
            memcpy(rows + 36, big ? "\3\0\0\0\0\0\0\0\1\0\0\0\2" : "\3\0\0\0\0\1\0\0\0\2\0\0", 13);
            rk_mesh mesh =
                load_binary("first.ply",
                            big ? PLY("binary_big_endian", 3) XYZ FACES(1) "end_header\n"
                                : PLY("binary_little_endian", 3) XYZ FACES(1) "end_header\n",
                            rows, sizeof rows);
            uint32_t bits = big ? (uint32_t)first << 24 : 0x3f800000u + (uint32_t)first;
            float x;
            memcpy(&x, &bits, sizeof x);
            check_point(corner(&mesh, 0, 0), x, 0, 0);
            check_point(corner(&mesh, 0, 1), 1, 0, 0);
            check_point(corner(&mesh, 0, 2), 0, 1, 0);
            rk_mesh_free(&mesh);
        }
}

/* Cameras, as VCGLIB writes them, and lists; before the vertices, between them and the faces, and
 * after them. The vertices of the second file are far from the origin. */
static void elements_of_a_ply_may_precede_its_vertices(void **state)
{
    (void)state;
#define CAMERA "element camera 2\nproperty double at\ncomment c\nproperty list uchar short sizes\n"
#define TAG(name) "element " name " 1\nproperty uchar tag\n"
#define ELEMENTS(encoding)                                                                         \
    "ply\nformat " encoding " 1.0\n" CAMERA "element vertex 3\n" XYZ TAG("a") FACES(1)             \
        TAG("b") "end_header\n"
    static const char *const note = "has \"camera\" elements, which the picture does not show";
    for (int is_far = 0; is_far < 2; is_far++) {
        char text[600];
        const int x = is_far ? 9000 : 0;
        snprintf(text, sizeof text,
                 ELEMENTS("ascii") "1 2 3 4\n5 0\n%d 0 0\n%d 0 0\n\n%d 1 0\n7\n3 0 1 2\n8\n", x,
                 x + 1, x);
        rk_mesh mesh = load_with_note(write_text("camera.ply", text), note);
        check_point(corner(&mesh, 0, 0), 0, 0, 0);
        check_point(corner(&mesh, 0, 1), 1, 0, 0);
        check_point(corner(&mesh, 0, 2), 0, 1, 0);
        rk_mesh_free(&mesh);
    }
    for (int is_far = 0; is_far < 2; is_far++) {
        const float x = is_far ? 9000 : 10;
        const float points[9] = {x, 0, 0, x + 1, 0, 0, x, 1, 0};
        char bytes[600] = ELEMENTS("binary_little_endian");
        size_t size = strlen(bytes);
        memcpy(bytes + size, "........\2\1\2\3\4........\0", 22);
        memcpy(bytes + size + 22, points, sizeof points);
        memcpy(bytes + size + 58, "\7\3\0\0\0\0\1\0\0\0\2\0\0\0\10", 15);
        rk_mesh mesh =
            load_with_note(test_folder_write(&folder, "camera.ply", bytes, size + 73, 0600), note);
        check_point(corner(&mesh, 0, 0), is_far ? 0 : x, 0, 0);
        check_point(corner(&mesh, 0, 1), is_far ? 1 : x + 1, 0, 0);
        check_point(corner(&mesh, 0, 2), is_far ? 0 : x, 1, 0);
        rk_mesh_free(&mesh);
    }
#undef ELEMENTS
#undef TAG
#undef CAMERA
}

static void what_a_plys_faces_look_like_is_drawn_or_told(void **state)
{
    (void)state;
    static const struct {
        const char *text, *note;
    } files[] = {
        {PLY("ascii", 4) "comment TextureFile a.ppm\ncomment TextureFile b.ppm\n" XYZ FACES(
             2) "property list uchar float texcoord\nproperty int texnumber\nend_header\n" SQUARE
                "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0 0 1 1 0 1 1\n",
         "has several pictures for its faces (texnumber)"},
        {PLY("ascii", 4) "comment TextureFile a.ppm\ncomment TextureFile a.ppm\n" XYZ FACES(
             1) "property list uchar float texcoord\nend_header\n" SQUARE "3 0 1 2 6 0 0 1 0 1 1\n",
         "names 2 pictures (comment TextureFile): the picture shows one of them everywhere"},
        {PLY("ascii", 4) XYZ FACES(2) "property int material_index\n"
                                      "element material 2\nproperty uchar diffuse_red\n"
                                      "end_header\n" SQUARE "3 0 1 2 0\n3 0 2 3 1\n255\n0\n",
         "has several materials for its faces (material_index)"},
        {PLY("ascii", 4) XYZ FACES(1) "element edge 1\nproperty int vertex1\n"
                                      "end_header\n" SQUARE "3 0 1 2\n0\n",
         "has \"edge\" elements, which the picture does not show"},
        {PLY("ascii", 4) XYZ
         "property uchar diffuse_red\n" FACES(1) "end_header\n"
                                                 "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n3 0 1 2\n",
         "has colours of vertices as diffuse_red"},
    };
    write_picture("a.ppm");
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load_with_note(write_text("told.ply", files[i].text), files[i].note);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load(write_text(
        "one.ply", PLY("ascii", 4) XYZ FACES(2) "property int material_index\nelement edge 0\n"
                                                "property int vertex1\nend_header\n" SQUARE
                                                "3 0 1 2 7\n3 0 2 3 7\n"));
    rk_mesh_free(&mesh);
}

/* --- glTF ----------------------------------------------------------------------------------- */

/* The common triangle, with these lines in its part and in the outermost object. */
static test_path write_gltf_of(const char *part, const char *lines)
{
    static char text[2000];
    snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\",\"extras\":{\"extensionsRequired\":[\"OTHER_one\"],"
        "\"note\":\"\\\"extensionsRequired\\\": [\"}},%s\"scene\":0,"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{%s\"attributes\":{\"POSITION\":0}}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,0]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
        lines, part);
    return write_text("extensions.gltf", text);
}

static test_path write_gltf(const char *lines)
{
    return write_gltf_of("", lines);
}

static void a_gltf_that_needs_what_is_not_read_is_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
                                        "VENDOR_other"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char lines[300];
        snprintf(
            lines, sizeof lines,
            "\"extensionsUsed\":[\"%s\"], \"extensionsRequired\" :\n[\"KHR_texture_transform\", "
            "\"%s\"],",
            names[i], names[i]);
        check_refused_path(write_gltf(lines).text, ": needs the glTF extension ", names[i]);
    }
}

static void extensions_of_a_gltf_that_are_not_drawn_are_told(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_gltf("\"extensionsUsed\":[\"KHR_materials_transmission\",\"KHR_texture_transform\","
                   "\"KHR_texture_basisu\"],\"extensionsRequired\":[\"KHR_texture_basisu\"],"),
        "uses KHR_materials_transmission, KHR_texture_basisu, which the picture does not show");
    rk_check_equal(mesh.triangle_count, 1, "it is drawn");
    rk_mesh_free(&mesh);
    mesh = load(write_gltf("\"extensionsUsed\":[\"KHR_texture_transform\",\"FB_ngon_encoding\","
                           "\"EXT_meshopt_compression\"],"));
    rk_mesh_free(&mesh);
    mesh = load(write_gltf(""));
    rk_mesh_free(&mesh);
    rk_error error;
    rk_check(!rk_mesh_file_read(&mesh, write_text("cut.gltf", "{\"extensionsUsed\":[\"a\\").text,
                                &error),
             "a file that is cut off was accepted");
}

/* Three vertices, whose positions are the first `size` bytes. `line` is the accessors 1 and 2,
 * whose bytes are in bufferView 1; `part` is of the primitive. */
typedef struct gltf_bytes {
    const char *positions;
    int size, stride, kind; /* componentType */
    const char *rest;
    int rest_size, rest_stride;
    const char *part, *line;
} gltf_bytes;

static test_path write_gltf_bytes(const gltf_bytes *g)
{
    char bytes[200], text[2000];
    memcpy(bytes, g->positions, (size_t)g->size);
    memcpy(bytes + g->size, g->rest, (size_t)g->rest_size);
    test_folder_write(&folder, "bytes.bin", bytes, (size_t)(g->size + g->rest_size), 0600);
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{%s}]}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":%d,\"count\":3,\"type\":\"VEC3\"},"
             "%s],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%d,\"byteStride\":%d},"
             "{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d%s%.0d}],"
             "\"buffers\":[{\"byteLength\":%d,\"uri\":\"bytes.bin\"}]}",
             g->part, g->kind, g->line, g->size, g->stride, g->size, g->rest_size,
             g->rest_stride ? ",\"byteStride\":" : "", g->rest_stride, g->size + g->rest_size);
    return write_text("bytes.gltf", text);
}

static const float corner_positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
#define FLOAT_POSITIONS (const char *)corner_positions, 36, 12, 5126

/* Corners at (0, 0), (1, 0) and about (1/2, 1), v down, of which 1/2 is 128 or 32768 of the largest
 * integer, or -1/2 of a signed one. */
static void texture_coordinates_of_a_gltf_may_be_integers(void **state)
{
    (void)state;
    static const struct {
        const char *bytes, *accessor;
        int size, stride;
        double half;
    } kinds[] = {
        {"\0\0\0\0\xff\0\0\0\x80\xff\0\0", "5121,\"normalized\":true", 12, 4, 128 / 255.0},
        {"\0\0\xff\0\x80\xff", "5121,\"normalized\" : true", 6, 0, 128 / 255.0},
        {"\0\0\0\0\xff\xff\0\0\0\x80\xff\xff", "5123,\"normalized\":true", 12, 4, 32768 / 65535.0},
        {"\0\0\0\0\xff\x7f\0\0\0\xc0\xff\x7f", "5122,\"normalized\":true", 12, 4, -16384 / 32767.0},
        {"\0\0\0\0\1\0\0\0\7\1\0\0", "5121,\"normalized\":false", 12, 4, 7},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        char line[200];
        snprintf(line, sizeof line,
                 "{\"count\":3,\"type\":\"VEC2\",\"bufferView\":1,\"componentType\":%s}",
                 kinds[i].accessor);
        rk_mesh mesh = load(write_gltf_bytes(
            &(gltf_bytes){FLOAT_POSITIONS, kinds[i].bytes, kinds[i].size, kinds[i].stride,
                          "\"attributes\":{\"TEXCOORD_0\":1,\"POSITION\":0}", line}));
        const rk_vec2 *t = mesh.texcoords;
        const uint32_t *at = mesh.triangles[0];
        rk_check(t[at[0]].x == 0 && t[at[0]].y == 1 && t[at[1]].x == 1 && t[at[1]].y == 1 &&
                     t[at[2]].y == 0,
                 "%s: (%g, %g), (%g, %g), (.., %g)", kinds[i].accessor, (double)t[at[0]].x,
                 (double)t[at[0]].y, (double)t[at[1]].x, (double)t[at[1]].y, (double)t[at[2]].y);
        rk_check_close(t[at[2]].x, kinds[i].half, 1e-6, kinds[i].accessor);
        rk_mesh_free(&mesh);
    }
}

/* KHR_mesh_quantization, as gltfpack writes it: positions of 16 bits, normals of 8. */
static void positions_and_normals_of_a_gltf_may_be_integers(void **state)
{
    (void)state;
    gltf_bytes g = {"\0\0\0\0\0\0\0\0\x40\x9c\0\0\0\0\0\0\0\0\xf4\1\7\0\0\0",
                    24,
                    8,
                    5123,
                    "\0\0\x7f\0\0\0\x7f\0\0\x81\0\0",
                    12,
                    4,
                    "\"attributes\":{\"POSITION\":0,\"NORMAL\":1}",
                    "{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,\"count\":3,"
                    "\"type\":\"VEC3\"}"};
    rk_mesh mesh = load(write_gltf_bytes(&g));
    check_point(corner(&mesh, 0, 0), 0, 0, 0);
    check_point(corner(&mesh, 0, 1), 40000, 0, 0);
    check_point(corner(&mesh, 0, 2), 0, 500, 7);
    check_point(mesh.normals[mesh.triangles[0][1]], 0, 0, 1);
    check_point(mesh.normals[mesh.triangles[0][2]], 0, -1, 0);
    rk_mesh_free(&mesh);
    g.kind = 5122;
    mesh = load(write_gltf_bytes(&g));
    check_point(corner(&mesh, 0, 1), 40000 - 65536, 0, 0);
    rk_mesh_free(&mesh);
}

static void indices_of_a_gltf_that_are_out_of_range_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *indices, *mode, *what;
        int size;
    } files[] = {
        {"\0\1\2", "", NULL, 3},
        {"\0\1\2\0", "", NULL, 4}, /* the fourth is of no triangle */
        {"\0\1\3", "", ": all triangles of a part use vertices that are not there", 3},
        {"\0\1\2\0\1\3", "", ": 1 of 2 triangles of part 0", 6},
        {"\0\1\2\1", ",\"mode\":5", NULL, 4},
        {"\0\1\2\3", ",\"mode\":5", ": 1 of 2 triangles of part 0", 4},
        {"\0\1\2\3", ",\"mode\":6", ": 1 of 2 triangles of part 0", 4},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char line[200], part[100];
        snprintf(line, sizeof line,
                 "{\"bufferView\":1,\"componentType\":5121,\"count\":%d,\"type\":\"SCALAR\"}",
                 files[i].size);
        snprintf(part, sizeof part, "\"attributes\":{\"POSITION\":0},\"indices\":1%s",
                 files[i].mode);
        const test_path path = write_gltf_bytes(
            &(gltf_bytes){FLOAT_POSITIONS, files[i].indices, files[i].size, 0, part, line});
        if (files[i].what) {
            check_refused_path(path.text, files[i].what, "export it again");
            continue;
        }
        rk_mesh mesh = load(path);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load_with_note(
        write_gltf_bytes(&(gltf_bytes){
            FLOAT_POSITIONS, (const char *)corner_positions, 24, 12,
            "\"attributes\":{\"POSITION\":0,\"NORMAL\":1}",
            "{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}"}),
        "has normals or texture coordinates of another number than vertices");
    rk_mesh_free(&mesh);
}

/* Two meshes: of 3 and 6 vertices, floats; or both of 3, the first floats, the second int16. Their
 * names and the scene's nodes vary. */
static test_path write_two_meshes(const char *nodes, const char *name_a, const char *name_b,
                                  bool is_short)
{
    static const float floats[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    static const int16_t shorts[12] = {5, 0, 0, 0, 6, 0, 0, 0, 5, 1, 0, 0}; /* 8 bytes a vertex */
    char bytes[96], text[2000];
    memcpy(bytes, floats, 72);
    memcpy(bytes + 72, shorts, 24);
    test_folder_write(&folder, "two.bin", bytes, sizeof bytes, 0600);
    snprintf(text, sizeof text,
             "\xef\xbb\xbf{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":%s}],"
             "\"nodes\":[{\"mesh\":0},{\"mesh\":1},{\"mesh\":1,\"children\":[0]}],\"meshes\":["
             "{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]%s},"
             "{%s\"primitives\":[{\"attributes\":{\"POSITION\":%d}}]}],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
             "{\"bufferView\":0,\"componentType\":5126,\"count\":6,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5122,\"count\":3,\"type\":\"VEC3\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":72},"
             "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":24,\"byteStride\":8}],"
             "\"buffers\":[{\"byteLength\":96,\"uri\":\"two.bin\"}]}",
             nodes, name_a, name_b, is_short ? 2 : 1);
    return write_text("two.gltf", text);
}

static float most_x(const rk_mesh *mesh)
{
    float most = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        most = fmaxf(most, mesh->positions[i].x);
    return most;
}

/* Assimp's parts are in the order in which the scene reaches them, children first; those that it
 * does not reach are left out. The text begins with a byte order mark. */
static void meshes_of_a_gltf_may_be_in_any_order(void **state)
{
    (void)state;
    static const struct {
        const char *nodes;
        uint32_t triangles[2]; /* of each kind of file */
    } scenes[] = {{"[0,1]", {3, 2}}, {"[1,0]", {3, 2}}, {"[1]", {2, 1}},
                  {"[2]", {3, 2}},   {"[1,2]", {5, 3}}, {"[2,1]", {5, 3}}};
    static const char *const names[][2] = {{"", ""},
                                           {",\"name\":\"b\"", "\"name\":\"a\","},
                                           {",\"name\":\"\\u00e9\"", "\"name\":\"\\\"\","}};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        for (size_t k = 0; k < 6; k++) {
            const bool is_short = k & 1;
            if (is_short && k / 2 == 2)
                continue; /* see below */
            rk_mesh mesh =
                load(write_two_meshes(scenes[i].nodes, names[k / 2][0], names[k / 2][1], is_short));
            rk_check_equal(mesh.triangle_count, scenes[i].triangles[is_short], scenes[i].nodes);
            rk_check(most_x(&mesh) == 6, "nodes %s, case %zu: x reaches %g, want 6",
                     scenes[i].nodes, k, (double)most_x(&mesh));
            rk_mesh_free(&mesh);
        }
}

static void meshes_of_a_gltf_that_cannot_be_told_apart_are_named(void **state)
{
    (void)state;
    static const char a[] = ",\"name\":\"twin\"", b[] = "\"name\":\"twin\",";
    rk_mesh mesh = load_with_note(write_two_meshes("[1,0]", a, b, true),
                                  "has several parts named \"twin\" with coordinates of different "
                                  "kinds");
    rk_check_equal(mesh.triangle_count, 2, "both are kept");
    rk_mesh_free(&mesh);
    mesh = load(write_two_meshes("[1,0]", a, b, false)); /* by their vertices */
    rk_mesh_free(&mesh);
}

/* The same triangle, encoded in sequence by Draco 1.5.5. */
static test_path write_draco(const char *kind, const char *parts)
{
    char text[2000];
    snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],"
        "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"scene\":0,\"scenes\":[{"
        "\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0},\"indices\":1,\"extensions\":{"
        "\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0}}}}%s"
        "]}],\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"count\":3,\"componentType\" : %s,\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":61}],"
        "\"buffers\":[{\"byteLength\":61,\"uri\":\"data:application/octet-stream;base64,"
        "RFJBQ08CAgEAAAABAwEAAQIBAQAJAwAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAA==\"}"
        "]}",
        parts, kind);
    return write_text("draco.gltf", text);
}

static void indices_that_draco_compresses_may_have_32_bits(void **state)
{
    (void)state;
    static const char *const kinds[] = {"5121", "5123", "5125"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        rk_mesh mesh = load(write_draco(kinds[i], ""));
        rk_check_equal(mesh.triangle_count, 1, kinds[i]);
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
    check_refused_path(/* a part without compression may need the 32 bits */
                       write_draco("5125", ",{\"attributes\":{\"POSITION\":0},\"indices\":1}").text,
                       ": is compressed by Draco with 32-bit indices, which Assimp does not decode",
                       "export it uncompressed");
}

/* Its factor, which is 0 unless it is given, multiplies the picture. */
static void a_gltf_emits_light_by_its_factor_alone(void **state)
{
    (void)state;
    static const char texture[] = "\"materials\":[{\"emissiveTexture\":{\"index\":0}%s}],"
                                  "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"a.ppm\"}],";
    char lines[300];
    snprintf(lines, sizeof lines, texture, ",\"emissiveFactor\":[0,0,0]");
    rk_mesh mesh = load(write_gltf_of("\"material\":0,", lines));
    rk_mesh_free(&mesh);
    snprintf(lines, sizeof lines, texture, ",\"emissiveFactor\":[0,0,0.5]");
    mesh = load_with_note(write_gltf_of("\"material\":0,", lines), "has surfaces that emit light");
    rk_mesh_free(&mesh);
}

/* A picture whose coordinates go from 0 to this u, with these ways to continue it. */
static test_path write_wrapped(float u, int wrap_u, int wrap_v)
{
    static const char attributes[] =
        "\"material\":0,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}}]}],"
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
        "\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"a.ppm\"}],";
    const float texcoords[6] = {0, 0, u, 0, 0, 1};
    char part[600];
    write_picture("a.ppm");
    snprintf(part, sizeof part, "%s\"samplers\":[{\"wrapS\":%d,\"wrapT\":%d}],\"x\":[{\"y\":[{",
             attributes, wrap_u, wrap_v);
    return write_gltf_bytes(
        &(gltf_bytes){FLOAT_POSITIONS, (const char *)texcoords, 24, 8, part,
                      "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}"});
}

static void a_picture_that_does_not_continue_as_it_should_is_told(void **state)
{
    (void)state;
    enum { REPEAT = 10497, CLAMP = 33071, MIRROR = 33648 };
    static const int told[][2] = {{MIRROR, MIRROR}, {REPEAT, CLAMP}, {CLAMP, MIRROR}};
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        rk_mesh mesh = load_with_note(write_wrapped(2, told[i][0], told[i][1]),
                                      "has pictures that are mirrored or repeat in one direction");
        rk_mesh_free(&mesh);
        mesh = load(write_wrapped(1, told[i][0], told[i][1]));
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load(write_wrapped(2, REPEAT, REPEAT));
    rk_mesh_free(&mesh);
    mesh = load(write_wrapped(2, CLAMP, CLAMP));
    rk_mesh_free(&mesh);
}

/* --- colours -------------------------------------------------------------------------------- */

/* A square of vertices of which one has no number as its red; of a fan of two, one face has it. */
static void colours_that_are_no_numbers_are_counted_and_drawn_as_0(void **state)
{
    static const struct {
        const char *name, *text, *count;
    } files[] = {
        {"nan.obj",
         "v 0 0 0 .5 .5 .5\nv 1 0 0 nan .5 .5\nv 1 1 0 .5 .5 .5\nv 0 1 0 .5 .5 .5\n"
         "f 1 2 3\nf 1 3 4\n",
         "1 face has"},
        {"nan.ply",
         PLY("ascii", 4) XYZ
         "property float red\nproperty float green\n"
         "property float blue\n" FACES(2) "end_header\n"
                                          "0 0 0 nan .5 .5\n1 0 0 .5 .5 .5\n1 1 0 .5 .5 .5\n"
                                          "0 1 0 .5 .5 .5\n3 0 1 2\n3 0 2 3\n",
         "2 faces have"},
        {"faces.ply",
         PLY("ascii", 4) XYZ FACES(2) "property float red\nproperty float green\n"
                                      "property float blue\nend_header\n" SQUARE
                                      "3 0 1 2 inf .5 .5\n3 0 2 3 .5 .5 .5\n",
         "1 face has"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load_with_note(write_text(files[i].name, files[i].text), files[i].count);
        float least = 1, most = 0;
        for (uint32_t k = 0; k < mesh.vertex_count; k++) {
            least = fminf(least, mesh.colours[k].x);
            most = fmaxf(most, mesh.colours[k].x);
        }
        rk_check(least == 0, "%s: nan is drawn as %g, want 0", files[i].name, (double)least);
        rk_check_close(most, rk_srgb_decode(0.5f), 1e-6, "the others keep theirs");
        rk_mesh_free(&mesh);
        mesh = load_with_note(write_text(files[i].name, files[i].text),
                              "a colour that is not a finite number (nan or inf)");
        rk_mesh_free(&mesh);
    }
}

static void a_pointer_of_git_lfs_is_no_mesh(void **state)
{
    (void)state;
    static const char *const names[] = {"a.obj", "a.ply", "a.off",  "a.stl",
                                        "a.glb", "a.3ds", "a.gltf", "a.fbx"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_refused(names[i],
                      "version https://git-lfs.github.com/spec/v1\n"
                      "oid sha256:0123456789abcdef\nsize 12345\n",
                      ": is a Git LFS pointer, not the file", "run git lfs pull");
}

static void a_web_page_is_no_mesh(void **state)
{
    (void)state;
    static const char *const names[] = {"a.obj", "a.ply", "a.stl", "a.x3d", "a.3ds", "a.fbx"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        check_refused(names[i], "\n <!doctype HTML>\n<html><body>404</body></html>\n",
                      ": is a web page, not the file", "download the file itself");
        check_refused(names[i], "\xef\xbb\xbf<HTML lang=\"en\">\n<body>404</body></html>\n",
                      ": is a web page, not the file", "download the file itself");
    }
}

/* --- X -------------------------------------------------------------------------------------- */

/* Assimp would take the comma between two digits for the point of a number. */
static void numbers_of_an_x_may_be_separated_by_commas_alone(void **state)
{
    (void)state;
    static const char *const vertices[] = {"0,0,0,1,0,0,0,1,0;", "0,0,0;,1,0,0;,0,1,0;;",
                                           "0;0;0;,1;0;0;,0;1;0;;"};
    for (size_t i = 0; i < sizeof vertices / sizeof *vertices; i++) {
        char text[300];
        snprintf(text, sizeof text, "xof 0303txt 0032\nMesh a {\n3;\n%s\n1;\n3,0,1,2;\n}\n",
                 vertices[i]);
        rk_mesh mesh = load(write_text("commas.x", text));
        rk_check_equal(mesh.triangle_count, 1, vertices[i]);
        check_point(corner(&mesh, 0, 1), 1, 0, 0);
        check_point(vector_area(&mesh, 0), 0, 0, -0.5f); /* fronts are clockwise in X */
        rk_mesh_free(&mesh);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(numbers_of_an_obj_may_begin_with_their_point),
    cmocka_unit_test(a_comment_may_follow_any_numbers_of_an_obj),
    cmocka_unit_test(a_vertex_weight_moves_nothing),
    cmocka_unit_test(the_opacity_of_an_obj_vertex_is_left_out),
    cmocka_unit_test(a_line_that_assimp_does_not_know_costs_no_material),
    cmocka_unit_test(text_in_utf16_is_read_like_utf8),
    cmocka_unit_test(the_picture_of_a_black_material_is_drawn),
    cmocka_unit_test(words_of_an_mtl_may_be_in_capitals),
    cmocka_unit_test(control_characters_in_a_name_are_escaped),
    cmocka_unit_test(a_material_that_no_file_has_is_named),
    cmocka_unit_test(a_comment_may_follow_the_name_of_a_material),
    cmocka_unit_test(a_comment_may_follow_the_name_of_a_new_material),
    cmocka_unit_test(faces_before_the_first_material_have_none),
    cmocka_unit_test(invisible_materials_are_told),
    cmocka_unit_test(a_mesh_without_any_area_says_so),
    cmocka_unit_test(a_mesh_in_gzip_names_the_program),
    cmocka_unit_test(a_refusal_names_the_true_reason_and_a_remedy),
    cmocka_unit_test(a_format_that_nothing_reads_has_its_own_remedy),
    cmocka_unit_test(vrml_is_refused_by_its_version_and_packing),
    cmocka_unit_test(a_material_file_without_a_known_line_costs_no_mesh),
    cmocka_unit_test(what_an_obj_has_beside_faces_is_told),
    cmocka_unit_test(colours_of_an_obj_as_zbrush_writes_them_are_drawn),
    cmocka_unit_test(an_offs_vertices_have_what_its_first_word_announces),
    cmocka_unit_test(an_off_that_is_not_shown_as_it_is_says_so),
    cmocka_unit_test(rows_of_an_off_may_go_over_several_lines),
    cmocka_unit_test(the_first_word_of_an_off_may_be_missing),
    cmocka_unit_test(comments_of_an_off_may_be_anywhere),
    cmocka_unit_test(transparent_faces_of_an_off_are_told),
    cmocka_unit_test(an_stl_may_be_in_capitals),
    cmocka_unit_test(colours_of_an_stl_are_in_its_programs_order),
    cmocka_unit_test(a_text_stl_with_larger_faces_is_told),
    cmocka_unit_test(a_binary_stl_may_have_a_wrong_count),
    cmocka_unit_test(a_plys_properties_may_have_other_names),
    cmocka_unit_test(words_of_a_plys_header_may_have_any_blanks_between_them),
    cmocka_unit_test(comments_of_a_ply_may_stand_anywhere),
    cmocka_unit_test(texture_coordinates_of_a_plys_corners_are_their_own),
    cmocka_unit_test(rows_of_a_binary_ply_may_begin_with_any_byte),
    cmocka_unit_test(elements_of_a_ply_may_precede_its_vertices),
    cmocka_unit_test(what_a_plys_faces_look_like_is_drawn_or_told),
    cmocka_unit_test(a_gltf_that_needs_what_is_not_read_is_refused),
    cmocka_unit_test(extensions_of_a_gltf_that_are_not_drawn_are_told),
    cmocka_unit_test(texture_coordinates_of_a_gltf_may_be_integers),
    cmocka_unit_test(positions_and_normals_of_a_gltf_may_be_integers),
    cmocka_unit_test(indices_of_a_gltf_that_are_out_of_range_are_refused),
    cmocka_unit_test(meshes_of_a_gltf_may_be_in_any_order),
    cmocka_unit_test(meshes_of_a_gltf_that_cannot_be_told_apart_are_named),
    cmocka_unit_test(indices_that_draco_compresses_may_have_32_bits),
    cmocka_unit_test(a_gltf_emits_light_by_its_factor_alone),
    cmocka_unit_test(a_picture_that_does_not_continue_as_it_should_is_told),
    cmocka_unit_test(a_pointer_of_git_lfs_is_no_mesh),
    cmocka_unit_test(a_web_page_is_no_mesh),
    cmocka_unit_test(numbers_of_an_x_may_be_separated_by_commas_alone),
    cmocka_unit_test(colours_that_are_no_numbers_are_counted_and_drawn_as_0),
};

RK_SUITE_IN("mesh_dialects", tests, make_folder, remove_folder)
