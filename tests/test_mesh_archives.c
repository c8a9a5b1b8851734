/* Mesh files that are archives, XML or chunks: 3MF, AMF, Collada, X3D, 3DS, MD2. */
#include "byte_list.h"
#include "test_mesh_reading.h"

#include "base/image.h"

/* --- archives ------------------------------------------------------------------------------- */

/* An archive whose files are stored as they are (APPNOTE.TXT, .ZIP File Format Specification). */
typedef struct archive {
    unsigned char bytes[4000], directory[400];
    size_t size, directory_size;
    unsigned count;
} archive;

static void put(unsigned char *to, size_t *size, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        to[(*size)++] = (unsigned char)(value >> 8 * i);
}

static uint32_t crc_of(const char *text)
{
    uint32_t crc = 0xffffffff;
    for (; *text; text++) {
        crc ^= (unsigned char)*text;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    return ~crc;
}

/* What a file has in common before its text and in the directory. */
static void put_entry(unsigned char *to, size_t *size, const char *name, const char *text)
{
    put(to, size, 20, 2); /* version */
    put(to, size, 0, 4);  /* flags, stored */
    put(to, size, 0x210000, 4);
    put(to, size, crc_of(text), 4);
    put(to, size, (uint32_t)strlen(text), 4);
    put(to, size, (uint32_t)strlen(text), 4);
    put(to, size, (uint32_t)strlen(name), 2);
    put(to, size, 0, 2);
}

static void add_file(archive *a, const char *name, const char *text)
{
    const uint32_t begin = (uint32_t)a->size;
    put(a->bytes, &a->size, 0x04034b50, 4);
    put_entry(a->bytes, &a->size, name, text);
    a->size += (size_t)sprintf((char *)a->bytes + a->size, "%s%s", name, text);
    put(a->directory, &a->directory_size, 0x02014b50, 4);
    put(a->directory, &a->directory_size, 20, 2);
    put_entry(a->directory, &a->directory_size, name, text);
    put(a->directory, &a->directory_size, 0, 4); /* no comment, first disk */
    put(a->directory, &a->directory_size, 0, 2);
    put(a->directory, &a->directory_size, 0, 4);
    put(a->directory, &a->directory_size, begin, 4);
    a->directory_size += (size_t)sprintf((char *)a->directory + a->directory_size, "%s", name);
    a->count++;
}

static test_path write_archive(archive *a, const char *name)
{
    const uint32_t begin = (uint32_t)a->size;
    memcpy(a->bytes + a->size, a->directory, a->directory_size);
    a->size += a->directory_size;
    put(a->bytes, &a->size, 0x06054b50, 4);
    put(a->bytes, &a->size, 0, 4);
    put(a->bytes, &a->size, a->count, 2);
    put(a->bytes, &a->size, a->count, 2);
    put(a->bytes, &a->size, (uint32_t)a->directory_size, 4);
    put(a->bytes, &a->size, begin, 4);
    put(a->bytes, &a->size, 0, 2);
    return test_folder_write(&folder, name, (const char *)a->bytes, a->size, 0600);
}

/* --- 3MF ------------------------------------------------------------------------------------ */

#define RELATIONS                                                                                  \
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"       \
    "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "                                      \
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"
#define MODEL(resources, build)                                                                    \
    "<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "                  \
    "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" "                   \
    "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/"                      \
    "06\"><resources>" resources "</resources><build>" build "</build></model>"
#define MESH(attributes)                                                                           \
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"           \
    "<vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" "          \
    "v3=\"2\"" attributes "/></triangles></mesh>"
#define ONE_PART                                                                                   \
    MODEL("<object id=\"1\" type=\"model\">" MESH("") "</object>", "<item objectid=\"1\"/>")

static archive begin_3mf(const char *model)
{
    archive a = {0};
    add_file(&a, "_rels/.rels", RELATIONS);
    add_file(&a, "3D/3dmodel.model", model);
    return a;
}

/* A part's material is drawn; those of its triangles are not. */
static void what_a_3mf_does_not_show_is_told(void **state)
{
    (void)state;
    archive a =
        begin_3mf(MODEL("<basematerials id=\"1\"><base name=\"r\" displaycolor=\"#FF0000\"/>"
                        "<base name=\"g\" displaycolor=\"#00FF00\"/></basematerials>"
                        "<object id=\"9\" type=\"model\" pid=\"1\" pindex=\"0\">" MESH(
                            " pid=\"1\" p1=\"1\"") "</object>",
                        "<item objectid=\"9\"/>"));
    rk_mesh mesh = load_with_note(write_archive(&a, "part.3mf"),
                                  "each part shows one material: colours of triangles");
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 0, 0);
    check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
    rk_mesh_free(&mesh);
}

static void colours_of_a_3mf_are_srgb(void **state)
{
    (void)state;
    archive a = begin_3mf(MODEL("<basematerials id=\"1\"><base name=\"a\" "
                                "displaycolor=\"#60C000\"/></basematerials>"
                                "<object id=\"9\" type=\"model\" pid=\"1\" "
                                "pindex=\"0\">" MESH("") "</object>",
                                "<item objectid=\"9\"/>"));
    rk_mesh mesh;
    rk_error error;
    const test_path path = write_archive(&a, "srgb.3mf");
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    const rk_vec3 kd = mesh.materials[mesh.triangle_materials[0]].kd;
    rk_check_close(kd.x, rk_srgb_decode(0x60 / 255.0f), 1e-6, "red");
    rk_check_close(kd.y, rk_srgb_decode(0xc0 / 255.0f), 1e-6, "green");
    rk_check_close(kd.z, 0, 0, "blue");
    rk_mesh_free(&mesh);
    a = begin_3mf(ONE_PART);
    const test_path plain = write_archive(&a, "plain.3mf");
    rk_check_ok(rk_mesh_file_read(&mesh, plain.text, &error), error);
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 0.8f, 0.8f, 0.8f);
    rk_mesh_free(&mesh);
}

static void in_a_3mf_z_points_up(void **state)
{
    (void)state;
    archive a = begin_3mf(ONE_PART);
    rk_mesh mesh;
    rk_error error;
    const test_path path = write_archive(&a, "up.3mf");
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check_equal(mesh.up, 3, "z");
    rk_mesh_free(&mesh);
}

/* As it is told: Assimp gives its material black, and one place in the picture to each vertex. */
static void a_3mf_with_a_texture_is_plain(void **state)
{
    (void)state;
    archive a = begin_3mf(MODEL(
        "<m:texture2d id=\"3\" path=\"/3D/Textures/a.png\" contenttype=\"image/png\"/>"
        "<m:texture2dgroup id=\"4\" texid=\"3\"><m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup>"
        "<object id=\"1\" type=\"model\">" MESH(
            " pid=\"4\" p1=\"0\" p2=\"0\" p3=\"0\"") "</object>",
        "<item objectid=\"1\"/>"));
    add_file(&a, "3D/Textures/a.png", "a picture");
    rk_mesh mesh = load_with_note(write_archive(&a, "textured.3mf"), "textures and painting");
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 0.8f, 0.8f, 0.8f);
    rk_check_equal(mesh.texture_count, 0, "textures");
    rk_mesh_free(&mesh);
}

/* Slicers write one. */
static void a_3mf_may_hold_a_thumbnail(void **state)
{
    (void)state;
    archive a = begin_3mf(ONE_PART);
    add_file(&a, "Metadata/thumbnail.png", "a picture");
    const test_path path = write_archive(&a, "thumbnail.3mf");
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check(!strstr(error.text, "compression"), "a thumbnail is told: %s", error.text);
    rk_check_equal(mesh.triangle_count, 1, "triangles");
    rk_mesh_free(&mesh);
}

static void parts_of_a_3mf_in_other_models_are_told(void **state)
{
    (void)state;
    static const char component[] =
        "<object id=\"2\" type=\"model\"><components>"
        "<component objectid=\"7\" p:path=\"/3D/Objects/a.model\"/></components></object>";
    char model[2000];
    snprintf(model, sizeof model, MODEL("%s", "<item objectid=\"2\"/>"), component);
    archive a = begin_3mf(model);
    add_file(&a, "3D/Objects/a.model",
             MODEL("<object id=\"7\" type=\"model\">" MESH("") "</object>", ""));
    check_refused_path(write_archive(&a, "other.3mf").text,
                       ": has its parts in other models of its archive (production extension)", "");
    a = begin_3mf(ONE_PART);
    add_file(&a, "3D/Objects/a.model", MODEL("", ""));
    rk_mesh mesh = load_with_note(write_archive(&a, "both.3mf"),
                                  "has 2 models in its archive, of which Assimp reads one");
    rk_mesh_free(&mesh);
}

static void a_3mf_that_cannot_be_read_has_a_true_reason(void **state)
{
    (void)state;
    archive a = begin_3mf(ONE_PART);
    test_path path = write_archive(&a, "wide.3mf");
    memset(a.bytes + a.size - 12, 0xff, 10); /* sizes are in a record of 64 bits */
    path = test_folder_write(&folder, "wide.3mf", (const char *)a.bytes, a.size, 0600);
    check_refused_path(path.text, ": its archive has sizes of 64 bits (ZIP64)", "zip it again");
    path = test_folder_write(&folder, "cut.3mf", (const char *)a.bytes, a.size - 1, 0600);
    check_refused_path(path.text, ": its archive has no end", "");
    check_refused("text.3mf", "solid a\n", ": is not an archive", "ending of its format");
    a = begin_3mf("\xff\xfe<");
    check_refused_path(write_archive(&a, "utf16.3mf").text, ": Assimp finds nothing in it",
                       "UTF-16");
}

static void shapes_of_a_3mf_without_triangles_are_refused(void **state)
{
    (void)state;
    archive a =
        begin_3mf(MODEL("<object id=\"1\" type=\"model\">" MESH(
                            "") "</object>"
                                "<object id=\"8\" type=\"model\"><levelset functionid=\"5\" "
                                "channel=\"shape\" meshid=\"1\"/></object>",
                        "<item objectid=\"8\"/>"));
    check_refused_path(write_archive(&a, "level.3mf").text,
                       ": has no triangles in what it builds; shapes of 3MF's extensions",
                       "export it as STL");
}

/* --- AMF ------------------------------------------------------------------------------------ */

#define POINT(x, y) "<vertex><coordinates><x>" #x "</x><y>" #y "</y><z>0</z></coordinates></vertex>"
#define CORNERS(a, b, c) "<v1>" #a "</v1><v2>" #b "</v2><v3>" #c "</v3>"
#define AMF(volumes)                                                                               \
    "<?xml version=\"1.0\"?>\n<amf unit=\"millimeter\">\n<material "                               \
    "id=\"2\"><color><r>1</r><g>0</g>"                                                             \
    "<b>0</b></color></material><object id=\"1\"><mesh><vertices>" POINT(0, 0) POINT(1, 0)         \
        POINT(1, 1) POINT(0, 1) "</vertices>\n" volumes "</mesh></object></amf>\n"

static void every_volume_of_an_amf_is_drawn(void **state)
{
    (void)state;
    static const char *const volumes[] = {
        "<volume><triangle>" CORNERS(
            0, 1, 2) "</triangle></volume>\n"
                     "<volume >\n<metadata type=\"name\">b</metadata><triangle>" CORNERS(
                         0, 2, 3) "</triangle></volume>",
        "<volume/><volume><triangle>" CORNERS(
            0, 1, 2) "</triangle>"
                     "<triangle>" CORNERS(0, 2, 3) "</triangle></volume><volume />",
    };
    for (size_t i = 0; i < 2; i++) {
        char text[2000];
        snprintf(text, sizeof text, AMF("%s"), volumes[i]);
        rk_mesh mesh = load(write_text("volumes.amf", text));
        rk_check_equal(mesh.triangle_count, 2, "triangles");
        for (uint32_t k = 0; k < mesh.triangle_count; k++)
            check_point(vector_area(&mesh, k), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load_with_note(
        write_text("looks.amf", AMF("<volume><triangle>" CORNERS(
                                    0, 1, 2) "</triangle></volume>"
                                             "<volume materialid=\"2\"><triangle>" CORNERS(
                                                 0, 2, 3) "</triangle></volume>")),
        "objects of several volumes, which are drawn in the colour of their first one");
    rk_check_equal(mesh.triangle_count, 2, "triangles");
    rk_mesh_free(&mesh);
}

/* Assimp makes them black. */
static void an_amf_without_colours_is_grey(void **state)
{
    (void)state;
    rk_mesh mesh = load(
        write_text("grey.amf", AMF("<volume><triangle>" CORNERS(0, 1, 2) "</triangle></volume>")));
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 0.8f, 0.8f, 0.8f);
    rk_check(!mesh.colours, "has colours");
    rk_mesh_free(&mesh);
    mesh = load(write_text(
        "red.amf", AMF("<volume><triangle><color><r>1</r><g>0</g><b>0</b></color>" CORNERS(
                       0, 1, 2) "</triangle><triangle>" CORNERS(0, 2, 3) "</triangle></volume>")));
    check_point(mesh.colours[mesh.triangles[0][0]], 1, 0, 0);
    check_point(mesh.colours[mesh.triangles[1][0]], 0.8f, 0.8f, 0.8f);
    rk_mesh_free(&mesh);
}

/* Assimp takes a missing opacity for 0. */
static void a_colour_of_an_amf_without_opacity_is_opaque(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "black.amf", AMF("<volume><triangle><color><r>0</r><g>0</g><b>0</b></color>" CORNERS(
                         0, 1, 2) "</triangle><triangle><color><r>1</r><g>0</g><b>0</b><a>1</a>"
                                  "</color>" CORNERS(0, 2, 3) "</triangle></volume>")));
    check_point(mesh.colours[mesh.triangles[0][0]], 0, 0, 0);
    check_point(mesh.colours[mesh.triangles[1][0]], 1, 0, 0);
    rk_mesh_free(&mesh);
    mesh = load_with_note(
        write_text("clear.amf", AMF("<volume><triangle><color><r>1</r><g>0</g><b>0</b><a>0.5</a>"
                                    "</color>" CORNERS(0, 1, 2) "</triangle></volume>")),
        "transparent colours, which are drawn as opaque");
    rk_mesh_free(&mesh);
}

/* By degrees about x, then y, then z, before they are moved. */
static void constellations_of_an_amf_turn_and_move_their_objects(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "placed.amf",
        "<amf><object id=\"1\"><mesh><vertices>" POINT(1, 0) POINT(0, 1)
            POINT(0, 0) "</vertices><volume><triangle>" CORNERS(
                0, 1,
                2) "</triangle></volume></mesh></object>"
                   "<constellation id=\"2\"><instance objectid=\"1\"><deltax>5</deltax><rx>0</rx>"
                   "</instance><instance objectid=\"1\"><deltax>0</deltax><deltay>0</deltay>"
                   "<deltaz>10</deltaz><rx>90</rx><ry>0</ry><rz>90</rz></instance></constellation>"
                   "<constellation id=\"3\"><instance "
                   "objectid=\"2\"><deltay>100</deltay></instance>"
                   "</constellation></amf>"));
    static const double wanted[6][3] = {{6, 100, 0},  {5, 101, 0},  {5, 100, 0},
                                        {0, 101, 10}, {0, 100, 11}, {0, 100, 10}};
    rk_check_equal(mesh.triangle_count, 2, "only the outer constellation");
    for (uint32_t i = 0; i < 6; i++) {
        const rk_vec3 p = corner(&mesh, i / 3, (int)i % 3);
        rk_check_close(p.x, wanted[i][0], 1e-6, "x");
        rk_check_close(p.y, wanted[i][1], 1e-6, "y");
        rk_check_close(p.z, wanted[i][2], 1e-6, "z");
    }
    rk_mesh_free(&mesh);
}

static void an_amf_in_an_archive_is_refused(void **state)
{
    (void)state;
    archive a = {0};
    add_file(&a, "a.amf", AMF(""));
    check_refused_path(write_archive(&a, "packed.amf").text, ": is compressed by ZIP", "unzip");
}

/* --- XML ------------------------------------------------------------------------------------ */

#define COLLADA_OF(libraries, binding)                                                             \
    "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"    \
    "<up_axis>Y_UP</up_axis></asset>" libraries "<library_geometries><geometry id=\"g\"><mesh>"    \
    "<source id=\"p\"><float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 1 0</float_array>"          \
    "<technique_common><accessor source=\"#pa\" count=\"3\" stride=\"3\">"                         \
    "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"                         \
    "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\">" \
    "<input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles material=\"s\" "            \
    "count=\"1\">"                                                                                 \
    "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh>"       \
    "</geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node>"         \
    "<instance_geometry url=\"#g\">" binding                                                       \
    "</instance_geometry></node></visual_scene></library_visual_scenes><scene>"                    \
    "<instance_visual_scene url=\"#s\"/></scene></COLLADA>"
#define COLLADA COLLADA_OF("", "")

static void xml_may_be_in_utf16(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } files[] = {
        {"wide.dae", COLLADA},
        {"wide.x3d",
         "<X3D><Scene><Shape><IndexedFaceSet coordIndex=\"0 1 2 -1\">"
         "<Coordinate point=\"0 0 0 1 0 0 0 1 0\"/></IndexedFaceSet></Shape></Scene></X3D>"},
        {"wide.amf", "<amf><object id=\"1\"><mesh><vertices>" POINT(0, 0) POINT(1, 0)
                         POINT(0, 1) "</vertices><volume><triangle>" CORNERS(
                             0, 1, 2) "</triangle></volume></mesh></object></amf>"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        for (int kind = 0; kind < 4; kind++) { /* ends, with a mark or without */
            char text[2000];
            snprintf(text, sizeof text, "<?xml version=\"1.0\" encoding=\"UTF-16\"?>\r\n%s",
                     files[i].text);
            rk_mesh mesh = load(write_utf16(files[i].name, text, kind & 1, kind & 2));
            check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
            rk_mesh_free(&mesh);
        }
}

/* By the specification it is; some exporters mean the opposite. */
static void a_transparency_of_0_in_collada_is_drawn_with_a_note(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text(
            "clear.dae",
            COLLADA_OF("<library_effects><effect id=\"e\"><profile_COMMON>"
                       "<technique sid=\"t\"><lambert><diffuse><color>1 0 0 1</color></diffuse>"
                       "<transparent><color>1 1 1 1</color></transparent><transparency>"
                       "<float>0</float></transparency></lambert></technique>"
                       "</profile_COMMON></effect></library_effects><library_materials>"
                       "<material id=\"m\"><instance_effect url=\"#e\"/></material>"
                       "</library_materials>",
                       "<bind_material><technique_common><instance_material symbol=\"s\" "
                       "target=\"#m\"/></technique_common></bind_material>")),
        "a transparency of 0 makes a material invisible; it is drawn as opaque");
    const rk_material *material = &mesh.materials[mesh.triangle_materials[0]];
    check_point(material->kd, 1, 0, 0);
    rk_check_close(material->alpha, 1, 0, "opaque");
    rk_mesh_free(&mesh);
}

/* Assimp draws the nodes. */
static void a_collada_scene_without_its_geometry_is_refused(void **state)
{
    (void)state;
    check_refused("unused.dae",
                  "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
                  "version=\"1.4.1\"><library_effects><effect id=\"e\"><profile_COMMON>"
                  "<technique sid=\"t\"><lambert/></technique></profile_COMMON></effect>"
                  "</library_effects><library_materials><material id=\"m\">"
                  "<instance_effect url=\"#e\"/></material></library_materials>"
                  "<library_visual_scenes><visual_scene id=\"s\"><node name=\"a\"/>"
                  "</visual_scene></library_visual_scenes><scene>"
                  "<instance_visual_scene url=\"#s\"/></scene></COLLADA>",
                  ": has no triangles in its scene", "that a node shows");
}

static void what_an_x3d_does_not_show_is_told(void **state)
{
    (void)state;
    const test_path path =
        write_text("rest.x3d", "<X3D><Scene><Shape><Appearance><ProtoInstance name=\"red\" "
                               "containerField=\"material\"/></Appearance><IndexedFaceSet "
                               "creaseAngle=\"4\" coordIndex=\"0 1 2 -1\">"
                               "<Coordinate point=\"0 0 0 1 0 0 0 1 0\"/></IndexedFaceSet>"
                               "</Shape></Scene></X3D>");
    rk_mesh mesh = load_with_note(path, "has creaseAngle, which Assimp does not read");
    rk_mesh_free(&mesh);
    mesh = load_with_note(path, "has prototypes (ProtoInstance)");
    rk_mesh_free(&mesh);
    mesh = load(write_text("flat.x3d", "<X3D><Scene><Shape><IndexedFaceSet creaseAngle=\"0.0\" "
                                       "coordIndex=\"0 1 2 -1\">"
                                       "<Coordinate point=\"0 0 0 1 0 0 0 1 0\"/>"
                                       "</IndexedFaceSet></Shape></Scene></X3D>"));
    rk_mesh_free(&mesh);
}

/* As Godot writes them; Assimp reads no number after them. */
static void blanks_around_numbers_of_collada_are_skipped(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "blanks.dae",
        COLLADA_OF("<library_effects><effect id=\"e\"><profile_COMMON>"
                   "<technique sid=\"t\"><lambert><diffuse><color>  1 0 .5 1 </color></diffuse>"
                   "</lambert></technique></profile_COMMON></effect></library_effects>"
                   "<library_materials><material id=\"m\"><instance_effect url=\"#e\"/>"
                   "</material></library_materials>",
                   "<bind_material><technique_common><instance_material symbol=\"s\" "
                   "target=\"#m\"/></technique_common></bind_material>")));
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 0, 0.5f);
    check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
    rk_mesh_free(&mesh);
}

/* As OpenCOLLADA for 3ds Max counts. `name` in init_from, `uv`: further inputs of the triangles,
 * and `set`: that of the channel. */
#define COLLADA_WITH_PICTURE(name, uv, corners, set)                                               \
    "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"    \
    "<up_axis>Y_UP</up_axis></asset><library_images><image id=\"i\"><init_from>" name              \
    "</init_from>"                                                                                 \
    "</image></library_images><library_effects><effect id=\"e\"><profile_COMMON>"                  \
    "<newparam sid=\"f\"><surface type=\"2D\"><init_from>i</init_from></surface></newparam>"       \
    "<newparam sid=\"x\"><sampler2D><source>f</source></sampler2D></newparam>"                     \
    "<technique sid=\"t\"><lambert><diffuse><texture texture=\"x\" texcoord=\"CHANNEL1\"/>"        \
    "</diffuse></lambert></technique></profile_COMMON></effect></library_effects>"                 \
    "<library_materials><material id=\"m\"><instance_effect url=\"#e\"/></material>"               \
    "</library_materials><library_geometries><geometry id=\"g\"><mesh><source id=\"p\">"           \
    "<float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 1 0</float_array><technique_common>"         \
    "<accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/>"         \
    "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"              \
    "</technique_common></source><source id=\"u\"><float_array id=\"ua\" count=\"6\">0 0 1 0 0 1"  \
    "</float_array><technique_common><accessor source=\"#ua\" count=\"3\" stride=\"2\">"           \
    "<param name=\"S\" type=\"float\"/><param name=\"T\" type=\"float\"/></accessor>"              \
    "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "                 \
    "source=\"#p\"/></vertices><triangles material=\"s\" count=\"1\"><input semantic=\"VERTEX\" "  \
    "source=\"#v\" offset=\"0\"/>" uv "<p>" corners "</p></triangles></mesh></geometry>"           \
    "</library_geometries><library_visual_scenes><visual_scene id=\"s\"><node>"                    \
    "<instance_geometry url=\"#g\"><bind_material><technique_common><instance_material "           \
    "symbol=\"s\" target=\"#m\"><bind_vertex_input semantic=\"CHANNEL1\" "                         \
    "input_semantic=\"TEXCOORD\" input_set=\"" set "\"/></instance_material></technique_common>"   \
    "</bind_material></instance_geometry></node></visual_scene></library_visual_scenes><scene>"    \
    "<instance_visual_scene url=\"#s\"/></scene></COLLADA>"

static void a_channel_that_a_collada_mesh_lacks_is_its_first(void **state)
{
    (void)state;
    test_folder_write(&folder, "a.ppm", "P6\n1 1\n255\n\377\0\0", 14, 0600);
    rk_mesh mesh = load(
        write_text("channel.dae", COLLADA_WITH_PICTURE("a.ppm",
                                                       "<input semantic=\"TEXCOORD\" source=\"#u\" "
                                                       "offset=\"1\" set=\"0\"/>",
                                                       "0 0 1 1 2 2", "0")));
    rk_check_equal(mesh.texture_count, 1, "textures");
    if (mesh.texcoords)
        rk_check_close(mesh.texcoords[mesh.triangles[0][1]].x, 1, 0, "u of the second corner");
    else
        rk_check(false, "has no texture coordinates");
    rk_mesh_free(&mesh);
}

#define SET(offset, set)                                                                           \
    "<input semantic=\"TEXCOORD\" source=\"#u\" offset=\"" offset "\" set=\"" set "\"/>"
#define SETS(first, second) SET("1", first) SET("2", second)

/* Of two sets, whose second has u = 0 at the second corner. */
static void a_material_of_collada_is_bound_to_a_set_of_coordinates(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double u;
    } files[] = {
        {COLLADA_WITH_PICTURE("a.ppm", SETS("0", "1"), "0 0 2 1 1 0 2 2 1", "0"), 1},
        {COLLADA_WITH_PICTURE("a.ppm", SETS("0", "1"), "0 0 2 1 1 0 2 2 1", "1"), 0},
        {COLLADA_WITH_PICTURE("a.ppm", SETS("1", "2"), "0 0 2 1 1 0 2 2 1", "1"), 1},
        {COLLADA_WITH_PICTURE("a.ppm", SETS("1", "2"), "0 0 2 1 1 0 2 2 1", "2"), 0},
        {COLLADA_WITH_PICTURE("a.ppm", SETS("3", "0"), "0 0 2 1 1 0 2 2 1", "3"), 1},
    };
    test_folder_write(&folder, "a.ppm", "P6\n1 1\n255\n\377\0\0", 14, 0600);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load(write_text("sets.dae", files[i].text));
        rk_check(mesh.texcoords != NULL, "has no texture coordinates");
        rk_check_close(mesh.texcoords[mesh.triangles[0][1]].x, files[i].u, 0,
                       "u of the second corner");
        rk_mesh_free(&mesh);
    }
}

/* Cinema 4D writes such. Assimp aborts. */
static void a_picture_of_collada_may_have_no_name(void **state)
{
    (void)state;
    static const char text[] = COLLADA_WITH_PICTURE("", SETS("0", "1"), "0 0 0 1 1 1 2 2 2", "0");
    rk_mesh mesh =
        load_with_note(write_text("nameless.dae", text), "has a picture without a file's name");
    rk_check_equal(mesh.texture_count, 0, "textures");
    rk_mesh_free(&mesh);
    char other[sizeof text] = "";
    const char *empty = strstr(text, "<init_from></init_from>");
    snprintf(other, sizeof other, "%.*s<init_from/>%s", (int)(empty - text), text, empty + 23);
    mesh = load_with_note(write_text("nameless.dae", other), "has a picture without a file's name");
    rk_mesh_free(&mesh);
}

static void an_index_of_collada_below_0_is_refused(void **state)
{
    (void)state;
    check_refused("below.dae",
                  COLLADA_WITH_PICTURE("a.ppm", SETS("0", "1"), "0 0 0 1 1 1 -1 2 2", "0"),
                  ": a face has the index -1", "export it again");
}

static void pictures_of_collada_for_other_programs_are_told(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("cg.dae", COLLADA_OF("<library_effects><effect id=\"e\"><profile_CG><newparam "
                                        "sid=\"f\"><surface type=\"2D\"><init_from>i</init_from>"
                                        "</surface></newparam></profile_CG><profile_COMMON>"
                                        "<technique sid=\"t\"><lambert/></technique>"
                                        "</profile_COMMON></effect></library_effects>",
                                        "")),
        "has pictures in effects for other programs (such as profile_CG)");
    rk_mesh_free(&mesh);
}

/* --- 3DS ------------------------------------------------------------------------------------ */

/* A number of 2 bytes, the size of 4 with these six, and what it holds. */
static size_t begin_chunk(byte_list *list, unsigned kind)
{
    append(list, (const unsigned char[]){kind & 255, (unsigned char)(kind >> 8), 0, 0, 0, 0}, 6);
    return list->size - 6;
}

static void end_chunk(byte_list *list, size_t begin)
{
    put_word(list->bytes + begin + 2, 0, (uint32_t)(list->size - begin));
}

/* A triangle whose right angle is at (x, 0, 0). */
static void append_object(byte_list *list, const char *name, float x)
{
    const float points[9] = {x, 0, 0, x + 2, 0, 0, x, 2, 0};
    const size_t object = begin_chunk(list, 0x4000);
    append(list, name, strlen(name) + 1);
    const size_t mesh = begin_chunk(list, 0x4100), vertices = begin_chunk(list, 0x4110);
    append(list, "\3", 2);
    append(list, points, sizeof points);
    end_chunk(list, vertices);
    const size_t faces = begin_chunk(list, 0x4120);
    append(list, "\1\0\0\0\1\0\2\0\0", 10);
    end_chunk(list, faces);
    end_chunk(list, mesh);
    end_chunk(list, object);
}

/* At (x, 0, 0) in the first frame. */
static void append_node(byte_list *list, const char *name, bool has_number, float x, float pivot)
{
    const float place[3] = {x, 0, 0}, from[3] = {pivot, 0, 0};
    const size_t node = begin_chunk(list, 0xb002);
    if (has_number) {
        const size_t number = begin_chunk(list, 0xb030);
        append(list, "\0", 2);
        end_chunk(list, number);
    }
    const size_t head = begin_chunk(list, 0xb010);
    append(list, name, strlen(name) + 1);
    append(list, "\0\0\0\0\xff\xff", 6);
    end_chunk(list, head);
    const size_t origin = begin_chunk(list, 0xb013);
    append(list, from, sizeof from);
    end_chunk(list, origin);
    const size_t track = begin_chunk(list, 0xb020);
    append(list, "\0\0\0\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0\0", 20);
    append(list, place, sizeof place);
    end_chunk(list, track);
    end_chunk(list, node);
}

/* Two objects at 0 and 10, and the nodes of the first ones. */
static test_path write_3ds(int nodes, bool have_numbers)
{
    byte_list list = {.size = 0};
    const size_t whole = begin_chunk(&list, 0x4d4d), scene = begin_chunk(&list, 0x3d3d);
    append_object(&list, "a", 0);
    append_object(&list, "b", 10);
    end_chunk(&list, scene);
    const size_t keys = list.size;
    if (nodes > 0) {
        begin_chunk(&list, 0xb000);
        append_node(&list, "a", have_numbers, 1, 0);
        if (nodes > 1)
            append_node(&list, "b", have_numbers, 16, 5);
        end_chunk(&list, keys);
    }
    end_chunk(&list, whole);
    return test_folder_write(&folder, "made.3ds", list.bytes, list.size, 0600);
}

static void check_3ds(test_path path, const char *note, float a, float b)
{
    rk_mesh mesh = load_with_note(path, note);
    rk_check_equal(mesh.triangle_count, 2, "triangles");
    check_point(corner(&mesh, 0, 0), a, 0, 0);
    check_point(corner(&mesh, 1, 0), b, 0, 0);
    rk_mesh_free(&mesh);
}

static void flat_faces_of_3ds_are_told(void **state)
{
    (void)state;
    check_3ds(write_3ds(0, false), "flat faces may be drawn smooth", 0, 10);
}

static void nodes_of_3ds_move_their_objects_from_the_pivot(void **state)
{
    (void)state;
    check_3ds(write_3ds(2, true), "flat faces", 1, 21);
}

/* In some files, as here, the pivot counts from the middle of the object's box. */
static void nodes_of_3ds_without_numbers_are_told_and_left_out(void **state)
{
    (void)state;
    check_3ds(write_3ds(2, false), "keyframes whose nodes have no numbers", 0, 10);
}

static void objects_of_3ds_without_a_node_are_told(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(write_3ds(1, true), "1 of its 2 parts has no node");
    rk_check_equal(mesh.triangle_count, 1, "triangles");
    rk_mesh_free(&mesh);
}

/* --- MD2 ------------------------------------------------------------------------------------ */

/* A head of 17 words, three texture coordinates, a triangle, a frame of three vertices, and no
 * commands; or with the name of a skin before them. */
static test_path write_md2(uint32_t skins)
{
    enum { head = 68, skin = 64, frame = 52 };
    const uint32_t texcoords = head + skin * skins, triangle = texcoords + 12,
                   frames = triangle + 12, end = frames + frame + 4;
    const uint32_t words[17] = {
        0x32504449, 8,    64,        64,       frame,  skins,          3,  3, 1, 1,
        1,          head, texcoords, triangle, frames, frames + frame, end};
    static const uint16_t corners[12] = {0, 0, 63, 0, 0, 63, 0, 1, 2, 0, 1, 2};
    static const float scale[6] = {1, 1, 1};
    static const char points[12] = {0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0};
    char bytes[head + skin + 12 + 12 + frame + 4] = {0};
    memcpy(bytes, words, sizeof words);
    memcpy(bytes + head, "gone.pcx", skins ? 9 : 0);
    memcpy(bytes + texcoords, corners, sizeof corners);
    memcpy(bytes + frames, scale, sizeof scale);
    memcpy(bytes + frames + 40, points, sizeof points);
    return test_folder_write(&folder, "skin.md2", bytes, end, 0600);
}

static void an_md2_without_a_skin_lacks_no_picture(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_md2(0));
    rk_check_equal(mesh.triangle_count, 1, "triangles");
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_md2(1), "gone.pcx: No such file");
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(what_a_3mf_does_not_show_is_told),
    cmocka_unit_test(colours_of_a_3mf_are_srgb),
    cmocka_unit_test(in_a_3mf_z_points_up),
    cmocka_unit_test(a_3mf_with_a_texture_is_plain),
    cmocka_unit_test(a_3mf_may_hold_a_thumbnail),
    cmocka_unit_test(parts_of_a_3mf_in_other_models_are_told),
    cmocka_unit_test(a_3mf_that_cannot_be_read_has_a_true_reason),
    cmocka_unit_test(shapes_of_a_3mf_without_triangles_are_refused),
    cmocka_unit_test(every_volume_of_an_amf_is_drawn),
    cmocka_unit_test(an_amf_without_colours_is_grey),
    cmocka_unit_test(a_colour_of_an_amf_without_opacity_is_opaque),
    cmocka_unit_test(constellations_of_an_amf_turn_and_move_their_objects),
    cmocka_unit_test(an_amf_in_an_archive_is_refused),
    cmocka_unit_test(xml_may_be_in_utf16),
    cmocka_unit_test(a_transparency_of_0_in_collada_is_drawn_with_a_note),
    cmocka_unit_test(a_collada_scene_without_its_geometry_is_refused),
    cmocka_unit_test(what_an_x3d_does_not_show_is_told),
    cmocka_unit_test(blanks_around_numbers_of_collada_are_skipped),
    cmocka_unit_test(a_material_of_collada_is_bound_to_a_set_of_coordinates),
    cmocka_unit_test(a_picture_of_collada_may_have_no_name),
    cmocka_unit_test(an_index_of_collada_below_0_is_refused),
    cmocka_unit_test(pictures_of_collada_for_other_programs_are_told),
    cmocka_unit_test(flat_faces_of_3ds_are_told),
    cmocka_unit_test(nodes_of_3ds_move_their_objects_from_the_pivot),
    cmocka_unit_test(nodes_of_3ds_without_numbers_are_told_and_left_out),
    cmocka_unit_test(objects_of_3ds_without_a_node_are_told),
    cmocka_unit_test(an_md2_without_a_skin_lacks_no_picture),
    cmocka_unit_test(a_channel_that_a_collada_mesh_lacks_is_its_first),
};

RK_SUITE_IN("mesh_archives", tests, make_folder, remove_folder)
