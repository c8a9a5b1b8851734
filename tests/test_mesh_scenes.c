/* Files of programs that model whole scenes, and of their exchange formats: FBX, Collada, X3D
 * and glTF. */
#include "test_mesh_reading.h"

#include "base/sanitized.h"

/* --- FBX ------------------------------------------------------------------------------------ */

/* A triangle in the xy-plane. `settings` are lines of the file, `picture` the name by which the
 * texture calls for it; the embedded one is a red pixel. */
static test_path write_fbx(const char *name, const char *settings, const char *picture)
{
    char text[4000];
    snprintf(
        text, sizeof text,
        "; FBX 7.4.0 project file\n"
        "FBXHeaderExtension: {\n FBXHeaderVersion: 1003\n FBXVersion: 7400\n}\n"
        "GlobalSettings: {\n Version: 1000\n Properties70: {\n%s }\n}\n"
        "Objects: {\n"
        " Geometry: 100, \"Geometry::\", \"Mesh\" {\n"
        "  Vertices: *9 {\n   a: 0,0,0,1,0,0,0,2,0\n  }\n"
        "  PolygonVertexIndex: *3 {\n   a: 0,1,-3\n  }\n  GeometryVersion: 124\n"
        "  LayerElementUV: 0 {\n   Version: 101\n   Name: \"\"\n"
        "   MappingInformationType: \"ByPolygonVertex\"\n"
        "   ReferenceInformationType: \"Direct\"\n   UV: *6 {\n    a: 0,0,1,0,0,1\n   }\n  }\n"
        "  LayerElementMaterial: 0 {\n   Version: 101\n   Name: \"\"\n"
        "   MappingInformationType: \"AllSame\"\n"
        "   ReferenceInformationType: \"IndexToDirect\"\n   Materials: *1 {\n    a: 0\n   }\n  }\n"
        "  Layer: 0 {\n   Version: 100\n   LayerElement: {\n    Type: \"LayerElementUV\"\n"
        "    TypedIndex: 0\n   }\n   LayerElement: {\n    Type: \"LayerElementMaterial\"\n"
        "    TypedIndex: 0\n   }\n  }\n }\n"
        " Model: 200, \"Model::t\", \"Mesh\" {\n  Version: 232\n }\n"
        " Material: 300, \"Material::m\", \"\" {\n  Version: 102\n  ShadingModel: \"lambert\"\n }\n"
        " Video: 400, \"Video::v\", \"Clip\" {\n  Type: \"Clip\"\n  Filename: "
        "\"C:\\work\\red.ppm\"\n"
        "  RelativeFilename: \"..\\red.ppm\"\n  Content: ,\n   \"UDYKMSAxCjI1NQr/AAA=\"\n }\n"
        " Texture: 500, \"Texture::u\", \"\" {\n  Type: \"TextureVideoClip\"\n  Version: 202\n"
        "  FileName: \"%s\"\n  RelativeFilename: \"%s\"\n }\n}\n"
        "Connections: {\n C: \"OO\",200,0\n C: \"OO\",100,200\n C: \"OO\",300,200\n"
        " C: \"OP\",500,300, \"DiffuseColor\"\n C: \"OO\",400,500\n}\n",
        settings, picture, picture);
    return write_text(name, text);
}

/* A binary file, record by record: where it ends, the number and size of its properties, its name.
 */
typedef struct fbx_file {
    unsigned char bytes[4000];
    size_t size, open[4];
    int depth;
} fbx_file;

static void put(fbx_file *f, const void *bytes, size_t size)
{
    rk_check(f->size + size <= sizeof f->bytes, "the test's own file is too large");
    memcpy(f->bytes + f->size, bytes, size);
    f->size += size;
}

static void put_word(fbx_file *f, uint32_t word)
{
    put(f, &word, sizeof word); /* little-endian like the machines that these tests know */
}

static void add_to_word(fbx_file *f, size_t at, uint32_t more)
{
    uint32_t word;
    memcpy(&word, f->bytes + at, sizeof word);
    word += more;
    memcpy(f->bytes + at, &word, sizeof word);
}

static void begin_record(fbx_file *f, const char *name)
{
    f->open[f->depth++] = f->size;
    put(f, (unsigned char[13]){[12] = (unsigned char)strlen(name)}, 13);
    put(f, name, strlen(name));
}

static void put_property(fbx_file *f, char type, const void *bytes, uint32_t size)
{
    const size_t record = f->open[f->depth - 1], before = f->size;
    put(f, &type, 1);
    if (type == 'S')
        put_word(f, size);
    if (type == 'd' || type == 'i') {
        put_word(f, size / (type == 'd' ? 8 : 4));
        put_word(f, 0);
        put_word(f, size);
    }
    put(f, bytes, size);
    add_to_word(f, record + 4, 1);
    add_to_word(f, record + 8, (uint32_t)(f->size - before));
}

static void end_record(fbx_file *f, bool has_children)
{
    if (has_children)
        put(f, (unsigned char[13]){0}, 13);
    add_to_word(f, f->open[--f->depth], (uint32_t)f->size);
}

static void put_record(fbx_file *f, const char *name, char type, const void *bytes, uint32_t size)
{
    begin_record(f, name);
    put_property(f, type, bytes, size);
    end_record(f, false);
}

static void begin_object(fbx_file *f, const char *name, int64_t id, const char *kind)
{
    begin_record(f, name);
    put_property(f, 'L', &id, sizeof id);
    put_property(f, 'S', "a\0\1b", 4);
    put_property(f, 'S', kind, (uint32_t)strlen(kind));
}

/* Two models of one triangle. `material`: of the second; the first has 300. */
static test_path write_shared_fbx(const char *name, int64_t material)
{
    static const double vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const int32_t corners[3] = {0, 1, -3}, version = 7400;
    const int64_t links[][2] = {{200, 0},   {201, 0},   {100, 200},
                                {100, 201}, {300, 200}, {material, 201}};
    fbx_file f = {.size = 0};
    put(&f, "Kaydara FBX Binary  \0\x1a\0", 23);
    put_word(&f, (uint32_t)version);
    begin_record(&f, "FBXHeaderExtension");
    put_record(&f, "FBXVersion", 'I', &version, sizeof version);
    end_record(&f, true);
    begin_record(&f, "GlobalSettings");
    begin_record(&f, "Properties70");
    end_record(&f, true);
    end_record(&f, true);
    begin_record(&f, "Objects");
    begin_object(&f, "Geometry", 100, "Mesh");
    put_record(&f, "Vertices", 'd', vertices, sizeof vertices);
    put_record(&f, "PolygonVertexIndex", 'i', corners, sizeof corners);
    end_record(&f, true);
    for (int64_t id = 200; id < 302; id += id == 201 ? 99 : 1) {
        begin_object(&f, id < 300 ? "Model" : "Material", id, id < 300 ? "Mesh" : "");
        put_record(&f, id < 300 ? "Version" : "ShadingModel", 'S', "lambert", 7);
        end_record(&f, true);
    }
    end_record(&f, true);
    begin_record(&f, "Connections");
    for (size_t i = 0; i < sizeof links / sizeof *links; i++) {
        begin_record(&f, "C");
        put_property(&f, 'S', "OO", 2);
        put_property(&f, 'L', &links[i][0], 8);
        put_property(&f, 'L', &links[i][1], 8);
        end_record(&f, false);
    }
    end_record(&f, true);
    put(&f, (unsigned char[13]){0}, 13);
    return test_folder_write(&folder, name, f.bytes, f.size, 0600);
}

static test_path write_shared_fbx_text(const char *name, int material)
{
    char text[2000];
    snprintf(text, sizeof text,
             "; FBX 7.4.0 project file\nFBXHeaderExtension: {\n FBXVersion: 7400\n}\n"
             "GlobalSettings: {\n Properties70: {\n }\n}\nObjects: {\n"
             " Geometry: 100, \"Geometry::\", \"Mesh\" {\n  Vertices: *9 {\n"
             "   a: 0,0,0,1,0,0,0,1,0\n  }\n  PolygonVertexIndex: *3 {\n   a: 0,1,-3\n  }\n }\n"
             " Model: 200, \"Model::a\", \"Mesh\" {\n  Version: 232\n }\n"
             " Model: 201, \"Model::b\", \"Mesh\" {\n  Version: 232\n }\n"
             " Material: 300, \"Material::a\", \"\" {\n  ShadingModel: \"lambert\"\n }\n"
             " Material: 301, \"Material::b\", \"\" {\n  ShadingModel: \"lambert\"\n }\n}\n"
             "Connections: {\n C: \"OO\",200,0\n C: \"OO\",201,0\n C: \"OO\",100,200\n"
             " C: \"OO\", 100, 201\n C: \"OO\",300,200\n C: \"OO\",%d,201\n}\n",
             material);
    return write_text(name, text);
}

/* Assimp gives both models the materials of one. */
static void a_mesh_of_an_fbx_in_different_materials_is_told(void **state)
{
    (void)state;
    static const char note[] = "shows a mesh several times in different materials";
    rk_mesh mesh = load_with_note(write_shared_fbx("shared.fbx", 301), note);
    rk_check_equal(mesh.triangle_count, 2, "triangles");
    rk_mesh_free(&mesh);
    mesh = load(write_shared_fbx("shared.fbx", 300));
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_shared_fbx_text("shared.fbx", 301), note);
    rk_mesh_free(&mesh);
    mesh = load(write_shared_fbx_text("shared.fbx", 300));
    rk_mesh_free(&mesh);
}

static void check_red(test_path path)
{
    rk_mesh mesh = load(path);
    rk_check_equal(mesh.texture_count, 1, "textures");
    if (mesh.texture_count == 1) {
        const rk_vec3 *pixel = mesh.textures[0].image.pixels;
        rk_check_close(pixel->x, 1, 0, "red");
        rk_check_close(pixel->y, 0, 0, "green");
    }
    rk_mesh_free(&mesh);
}

/* As Blender, Maya and 3ds Max write them: by a path of the computer on which they were. */
static void pictures_inside_an_fbx_are_found_by_their_names(void **state)
{
    (void)state;
    check_red(write_fbx("same.fbx", "", "..\\red.ppm"));
    check_red(write_fbx("folder.fbx", "", "D:\\elsewhere\\red.ppm"));
    check_red(write_fbx("slash.fbx", "", "textures/red.ppm"));
}

#define UP(axis, sign)                                                                             \
    "  P: \"UpAxis\", \"int\", \"Integer\", \"\"," #axis                                           \
    "\n  P: \"UpAxisSign\", \"int\", \"Integer\", \"\"," #sign "\n"

static void check_up(const char *settings, uint32_t up)
{
    rk_mesh mesh = load(write_fbx("up.fbx", settings, "red.ppm"));
    rk_check_equal(mesh.up, up, "the axis that points up, or 0");
    check_point(corner(&mesh, 0, 2), 0, 2, 0); /* nothing is turned yet */
    rk_mesh_free(&mesh);
}

static void an_fbx_names_the_axis_that_points_up(void **state)
{
    (void)state;
    check_up(UP(0, 1), 1);
    check_up(UP(1, 1), 2);
    check_up(UP(2, 1), 3);
    check_up(UP(7, 1), 0);
}

/* Turned by half about the axis to the front, which is y if the file names none. */
static void an_fbx_that_hangs_from_its_axis_is_turned(void **state)
{
    (void)state;
    static const char front[] = "  P: \"FrontAxis\", \"int\", \"Integer\", \"\",";
    char settings[300];
    check_up(UP(2, -1), 3);
    for (int axis = 0; axis < 3; axis += 2) { /* to the sides of y */
        snprintf(settings, sizeof settings, UP(1, -1) "%s%d\n", front, axis);
        rk_mesh mesh = load(write_fbx("hangs.fbx", settings, "red.ppm"));
        rk_check_equal(mesh.up, 2, "y");
        check_point(corner(&mesh, 0, 2), 0, -2, 0);
        check_point(corner(&mesh, 0, 1), axis == 0 ? 1 : -1, 0, 0);
        check_point(vector_area(&mesh, 0), 0, 0, axis == 0 ? -1 : 1);
        rk_mesh_free(&mesh);
    }
}

/* --- Collada -------------------------------------------------------------------------------- */

/* Each level shows the one below it twice. */
static test_path write_instances_up(const char *up, int levels)
{
    const test_path path = test_folder_path(&folder, "instances.dae");
    FILE *out = fopen(path.text, "w");
    rk_check(out, "the file can be written");
    fprintf(
        out,
        "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"
        "%s</asset><library_geometries><geometry id=\"g\"><mesh>"
        "<source id=\"p\"><float_array id=\"a\" count=\"9\">0 0 0 1 0 0 0 1 0</float_array>"
        "<technique_common><accessor source=\"#a\" count=\"3\" stride=\"3\">"
        "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
        "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
        "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
        "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
        "<p>0 1 2</p></triangles></mesh></geometry></library_geometries><library_nodes>"
        "<node id=\"n0\"><instance_geometry url=\"#g\"/></node>",
        up);
    for (int i = 1; i <= levels; i++)
        fprintf(out,
                "<node id=\"n%d\"><instance_node url=\"#n%d\"/><node><translate>%d 0 0</translate>"
                "<instance_node url=\"#n%d\"/></node></node>",
                i, i - 1, 1 << i, i - 1);
    fprintf(out,
            "</library_nodes><library_visual_scenes><visual_scene id=\"s\"><node>"
            "<instance_node url=\"#n%d\"/></node></visual_scene></library_visual_scenes><scene>"
            "<instance_visual_scene url=\"#s\"/></scene></COLLADA>",
            levels);
    fclose(out);
    return path;
}

static test_path write_instances(int levels)
{
    return write_instances_up("<up_axis>Y_UP</up_axis>", levels);
}

/* So that it is turned once, whether the user says it, too, or not. */
static void a_collada_file_names_the_axis_that_points_up(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        uint32_t up;
    } axes[] = {{"<up_axis>X_UP</up_axis>", 1},
                {"<up_axis>Y_UP</up_axis>", 2},
                {"<up_axis>Z_UP</up_axis>", 3},
                {"<up_axis>\n Z_UP\n</up_axis>", 3},
                {"", 0}};
    for (size_t i = 0; i < sizeof axes / sizeof *axes; i++) {
        rk_mesh mesh = load(write_instances_up(axes[i].text, 0));
        rk_check_equal(mesh.up, axes[i].up, axes[i].text);
        check_point(corner(&mesh, 0, 1), 1, 0, 0);
        check_point(corner(&mesh, 0, 2), 0, 1, 0);
        rk_mesh_free(&mesh);
    }
}

static void a_small_file_may_show_a_part_many_times(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_instances(14));
    rk_check_equal(mesh.triangle_count, 1 << 14, "triangles");
    rk_mesh_free(&mesh);
#ifndef RK_SANITIZED /* they lift the limit */
    check_refused_path(write_instances(24).text, "", "which is too much for a file of");
#endif
}

/* --- others --------------------------------------------------------------------------------- */

static void a_b3d_that_is_not_of_blitz3d_is_refused(void **state)
{
    (void)state;
    check_refused("post.b3d", "; a post\r\n[meshbuilder]\r\nVertex 0, 5, 0\r\nFace 0, 1, 2\r\n",
                  ": is a text of train simulators (BVE, OpenBVE)", "open it in Blender");
    check_refused("other.b3d", "ply\n", ": does not begin with BB3D", "rename it");
}

static void collada_before_1_4_is_refused(void **state)
{
    (void)state;
    check_refused("old.dae",
                  "<?xml version='1.0'?><COLLADA version='1.3.1'><library type='IMAGE'/></COLLADA>",
                  ": is Collada 1.3.1, of which Assimp reads 1.4 and 1.5", "or as OBJ");
}

#define LFS_POINTER                                                                                \
    "version https://git-lfs.github.com/spec/v1\noid sha256:133e7893875b9be4\nsize 2304564\n"

static void a_file_beside_the_mesh_that_git_lfs_has_not_fetched_is_named(void **state)
{
    (void)state;
    write_text("pointer.bin", LFS_POINTER);
    check_refused("pointer.gltf",
                  "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"pointer.bin\","
                  "\"byteLength\":36}]}",
                  ": needs the file pointer.bin, which is a Git LFS pointer", "run git lfs pull");
    write_text("pointer.mtl", LFS_POINTER);
    rk_mesh mesh =
        load_with_note(write_text("pointer.obj", "mtllib pointer.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                 "usemtl a\nf 1 2 3\n"),
                       "the material file pointer.mtl is a Git LFS pointer, not the "
                       "file: run git lfs pull");
    rk_mesh_free(&mesh);
}

/* --- AC3D ----------------------------------------------------------------------------------- */

#define AC3D_MATERIAL(name, rgb)                                                                   \
    "MATERIAL \"" name "\" rgb " rgb " amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 1 trans 0\n"
#define AC3D_SURFACE(number) "SURF 0x10\nmat " number "\nrefs 3\n0 0 0\n1 1 0\n2 0 1\n"

static test_path write_ac3d(const char *materials, const char *surfaces)
{
    char text[1000];
    snprintf(text, sizeof text,
             "AC3Db\n%sOBJECT world\nkids 1\nOBJECT poly\nname \"t\"\nnumvert 3\n0 0 0\n1 0 0\n"
             "0 1 0\nnumsurf 2\n%skids 0\n",
             materials, surfaces);
    return write_text("materials.ac", text);
}

static void a_material_of_ac3d_beyond_the_last_is_the_first(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_ac3d(AC3D_MATERIAL("mat 9", "1 0 0"), AC3D_SURFACE("0") AC3D_SURFACE("1")),
        ": 1 of its surfaces name a material beyond its 1: they are "
        "drawn in the first one");
    rk_check_equal(mesh.triangle_count, 2, "both");
    check_point(mesh.materials[mesh.triangle_materials[1]].kd, 1, 0, 0);
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_ac3d("", AC3D_SURFACE("0") AC3D_SURFACE("44")), "beyond its 0");
    rk_check_equal(mesh.triangle_count, 2, "both");
    rk_mesh_free(&mesh);
    mesh = load(write_ac3d(AC3D_MATERIAL("a", "1 0 0") AC3D_MATERIAL("b", "0 1 0"),
                           AC3D_SURFACE("0") AC3D_SURFACE("1")));
    check_point(mesh.materials[mesh.triangle_materials[1]].kd, 0, 1, 0);
    rk_mesh_free(&mesh);
}

/* --- X3D ------------------------------------------------------------------------------------ */

#define X3D(nodes) "<X3D><head><!-- <Text/> --></head><Scene>" nodes "</Scene></X3D>"
#define X3D_FACE(appearance, more)                                                                 \
    "<Shape>" appearance "<IndexedFaceSet coordIndex='0 1 2 -1'>"                                  \
    "<Coordinate point='0 0 0 1 0 0 0 1 0'/>" more "</IndexedFaceSet></Shape>"

static void nodes_of_an_x3d_that_are_not_drawn_are_told(void **state)
{
    (void)state;
    static const char *const nodes[][2] = {
        {"<LOD>" X3D_FACE("", "") "</LOD>", "has nodes (LOD), which Assimp does not read"},
        {"<Billboard>" X3D_FACE("", "") "</Billboard><LOD/>", "has nodes (Billboard, LOD), which"},
        {"<Shape><Text string='\"a\"'/></Shape>", "has nodes (Text), which"},
        {X3D_FACE("<Appearance><PixelTexture image='1 1 1 255'/></Appearance>", ""),
         "has nodes (PixelTexture), which"},
    };
    for (size_t i = 0; i < sizeof nodes / sizeof *nodes; i++) {
        char text[1000];
        snprintf(text, sizeof text, X3D("%s" X3D_FACE("", "")), nodes[i][0]);
        rk_mesh mesh = load_with_note(write_text("nodes.x3d", text), nodes[i][1]);
        rk_check_equal(mesh.triangle_count, i == 3 ? 2 : 1, nodes[i][1]);
        rk_mesh_free(&mesh);
    }
    check_refused("only.x3d", X3D("<LOD>" X3D_FACE("", "") "</LOD>"),
                  ": Assimp reads no triangles of it, only nodes that it leaves out (LOD)",
                  ": export it without them");
    rk_mesh mesh = load(write_text("none.x3d", X3D(X3D_FACE("", ""))));
    rk_mesh_free(&mesh);
}

static void check_begins_at(const rk_mesh *mesh, uint32_t want, float x, float y, float z)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const rk_vec3 p = corner(mesh, i, 0);
        count += p.x == x && p.y == y && p.z == z;
    }
    rk_check(count == want, "%u of %u triangles begin at (%g, %g, %g), want %u", count,
             mesh->triangle_count, (double)x, (double)y, (double)z, want);
}

/* Assimp 5.2 would leave one level too many, and lose what follows. */
static void a_group_of_an_x3d_may_be_used_again(void **state)
{
    (void)state;
    static const char *const uses[] = {
        "<Group USE='g'/>",
        "<Transform USE='g'></Transform>",
        "<StaticGroup USE = 'g' > <!-- again --> </StaticGroup>",
        "<Switch USE='g'/>",
        "<LOD><Group DEF='h'><Group USE='g'/></Group></LOD><Group USE='h'/>",
    };
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++) {
        char text[1000];
        snprintf(text, sizeof text,
                 X3D("<Script><![CDATA[if (a<b) '</Group>']]></Script>"
                     "<Transform DEF='g' translation='0 2 0'><Group/>" X3D_FACE(
                         "", "") "</Transform>"
                                 "<Transform translation='3 0 0'>%s</Transform>"
                                 "<Transform translation='0 0 5'>" X3D_FACE("", "") "</Transform>"),
                 uses[i]);
        const test_path path = write_text("uses.x3d", text);
        rk_mesh mesh = i < 4 ? load(path) : load_with_note(path, "has nodes (LOD)");
        rk_check_equal(mesh.triangle_count, 3, uses[i]);
        check_begins_at(&mesh, 1, 0, 2, 0);
        check_begins_at(&mesh, 1, 3, 2, 0);
        check_begins_at(&mesh, 1, 0, 0, 5);
        rk_mesh_free(&mesh);
    }
}

static void a_group_of_an_x3d_may_be_empty(void **state)
{
    (void)state;
    static const char *const groups[] = {
        "<Group/>",
        "<Transform translation='1 0 0'> </Transform>",
        "<Switch DEF='g'></Switch><Switch USE='g'/>",
        "<Group><StaticGroup/></Group>",
        "<Switch whichChoice='1'><Group/><Transform/></Switch>",
        "<Switch whichChoice='0'><Group/>" X3D_FACE("", "") "</Switch>",
    };
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) {
        char text[1000];
        snprintf(text, sizeof text,
                 X3D("<Transform translation='0 2 0'>%s" X3D_FACE("", "") "</Transform>" X3D_FACE(
                     "", "")),
                 groups[i]);
        rk_mesh mesh = load(write_text("empty.x3d", text));
        rk_check_equal(mesh.triangle_count, 2, groups[i]);
        check_begins_at(&mesh, 1, 0, 2, 0);
        check_begins_at(&mesh, 1, 0, 0, 0);
        rk_mesh_free(&mesh);
    }
}

static void what_an_x3d_uses_again_may_use_others(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "nested.x3d", X3D("<Group DEF='a'><Transform DEF='b' translation='1 0 0'><Shape DEF='s'>"
                          "<IndexedFaceSet coordIndex='0 1 2 -1'>"
                          "<Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet></Shape>"
                          "</Transform></Group><Transform DEF='c' translation='0 2 0'>"
                          "<Group USE='a'/><Transform USE='b'/><Shape USE='s'/></Transform>"
                          "<Transform translation='0 0 3'><Transform USE='c'/></Transform>")));
    rk_check_equal(mesh.triangle_count, 7, "1 + 3 + 3");
    check_begins_at(&mesh, 1, 1, 0, 0);
    check_begins_at(&mesh, 2, 1, 2, 0);
    check_begins_at(&mesh, 1, 0, 2, 0);
    check_begins_at(&mesh, 2, 1, 2, 3);
    check_begins_at(&mesh, 1, 0, 2, 3);
    rk_mesh_free(&mesh);
}

static void a_group_of_an_x3d_that_cannot_be_used_is_refused(void **state)
{
    (void)state;
    check_refused("unknown.x3d", X3D("<Group USE='g'/><Group DEF='g'/>" X3D_FACE("", "")),
                  ": uses the node g that is not defined before", "export it again");
    check_refused("cycle.x3d", X3D("<Group DEF='g'><Group USE='g'/>" X3D_FACE("", "") "</Group>"),
                  ": uses the node g in itself", "export it again");
    char text[20000] = "<X3D><Scene><Group DEF='g0'>" X3D_FACE("", "") "</Group>";
    for (int i = 1; i < 40; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text),
                 "<Group DEF='g%d'><Group USE='g%d'/><Group USE='g%d'/></Group>", i, i - 1, i - 1);
    strcat(text, "</Scene></X3D>");
    check_refused("many.x3d", text, ": its nodes with USE stand for more than ", "export it");
}

static void check_picture(const char *name, const char *url)
{
    char text[1000];
    snprintf(text, sizeof text,
             X3D(X3D_FACE("<Appearance><ImageTexture url=%s/></Appearance>",
                          "<TextureCoordinate point='0 0 1 0 0 1'/>")),
             url);
    test_folder_write(&folder, name, "P6\n1 1\n255\n\377\0\0", 14, 0600);
    check_red(write_text("picture.x3d", text));
}

static void a_picture_of_an_x3d_may_have_quotes_and_others_after_it(void **state)
{
    (void)state;
    check_picture("red.ppm", "'\"red.ppm\"'");
    check_picture("red.ppm", "\"red.ppm\"");
    check_picture("red.ppm", "\"&quot;red.ppm&quot;\"");
    check_picture("red.ppm", "'\"red.ppm\" \"b.ppm\" \"http://localhost/red.ppm\"'");
    check_picture("red.ppm", "'\"http://localhost/red.ppm\", \"red.ppm\"'");
    check_picture("a red.ppm", "'\"a red.ppm\"'");
    check_picture("a red.ppm", "'\"lost.ppm\" \"a red.ppm\"'");
}

/* ISO/IEC 19775-1, 17.2.2.4. */
static void colours_of_an_x3d_replace_the_diffuse_colour(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text(
        "colours.x3d",
        X3D(X3D_FACE("<Appearance><Material diffuseColor='0 1 0'/></Appearance>",
                     "<Color color='1 0 0 1 0 0 1 0 0'/>")
                X3D_FACE("<Appearance><Material diffuseColor='0 1 0'/></Appearance>", ""))));
    check_point(mesh.colours[mesh.triangles[0][0]], 1, 0, 0);
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 1, 1);
    check_point(mesh.colours[mesh.triangles[1][0]], 1, 1, 1);
    check_point(mesh.materials[mesh.triangle_materials[1]].kd, 0, 1, 0);
    rk_mesh_free(&mesh);
}

/* ISO/IEC 19775-1, 17.2.2.4; version 4.0 multiplies. */
static void a_picture_of_an_x3d_replaces_the_diffuse_colour_if_it_has_one(void **state)
{
    (void)state;
    static const char red[] = "P6\n1 1\n255\n\377\0\0", grey[] = "P5\n1 1\n255\n\200";
    static const char grey_png[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x8\0";
    static const char grey_jpeg[] = "\xff\xd8\xff\xe0\0\4ab\xff\xc2\0\xb\x8\0\1\0\1\1";
    static const char colour_jpeg[] = "\xff\xd8\xff\xe0\0\4ab\xff\xc0\0\x11\x8\0\1\0\1\3";
    static const struct {
        const char *picture;
        size_t size;
        const char *version;
        bool is_whole, replaces;
    } files[] = {
        {red, sizeof red - 1, "3.3", true, true},
        {red, sizeof red - 1, "4.0", true, false},
        {grey, sizeof grey - 1, "3.3", true, false},
        {grey_png, sizeof grey_png, "3.0", false, false},
        {grey_jpeg, sizeof grey_jpeg - 1, "3.0", false, false},
        {colour_jpeg, sizeof colour_jpeg - 1, "3.0", false, true},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char text[1000];
        test_folder_write(&folder, "a.pic", files[i].picture, files[i].size, 0600);
        snprintf(text, sizeof text,
                 "<X3D version='%s'><Scene>" X3D_FACE(
                     "<Appearance><Material diffuseColor='0 .5 0'/><ImageTexture url='\"a.pic\"'/>"
                     "</Appearance>",
                     "<TextureCoordinate point='0 0 1 0 0 1'/>") "</Scene></X3D>",
                 files[i].version);
        const test_path path = write_text("replace.x3d", text);
        rk_mesh mesh = files[i].is_whole ? load(path) : load_with_note(path, "cannot be read");
        const float other = files[i].replaces ? 1 : 0;
        check_point(mesh.materials[mesh.triangle_materials[0]].kd, other,
                    files[i].replaces ? 1 : 0.5f, other);
        rk_mesh_free(&mesh);
    }
}

/* ISO/IEC 19775-1, 13.3.2. */
static void check_cone(const char *attributes, float apex)
{
    char text[300];
    snprintf(text, sizeof text, X3D("<Shape><Cone %s/></Shape>"), attributes);
    rk_mesh mesh = load(write_text("cone.x3d", text));
    uint32_t top = 0, bottom = 0;
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        const rk_vec3 p = mesh.positions[i];
        top += p.y == apex && p.x == 0 && p.z == 0;
        bottom += p.y == -apex && (p.x != 0 || p.z != 0);
    }
    rk_check(top > 0 && bottom > 10, "%u corners at the top, %u around the bottom", top, bottom);
    rk_mesh_free(&mesh);
}

static void an_x3d_names_the_file_that_it_lacks(void **state)
{
    (void)state;
    check_refused(
        "inline.x3d",
        X3D("<Inline url='\"gone.x3d\" \"http://example.org/gone.x3d\"'/>" X3D_FACE("", "")),
        ": needs the file gone.x3d, which is missing", "put it beside the mesh file");
}

static void cones_of_an_x3d_point_upwards(void **state)
{
    (void)state;
    check_cone("", 1);
    check_cone("height='4'", 2);
    check_cone("bottomRadius=\"2\" height=\"3\" bottom='false'", 1.5f);
    rk_mesh mesh = load(write_text("disc.x3d", X3D("<Shape><Cone side='false'/></Shape>")));
    check_point(rk_vec(0, corner(&mesh, 0, 0).y, 0), 0, -1, 0);
    rk_mesh_free(&mesh);
}

/* --- glTF ----------------------------------------------------------------------------------- */

/* The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0), whose bytes are at the address. */
static test_path write_gltf(const char *address)
{
    char text[2000];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
             "{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
             "\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
             "\"buffers\":[{\"byteLength\":36,\"uri\":\"%s\"}]}",
             address);
    return write_text("a.gltf", text);
}

#define TRIANGLE_ADDRESS                                                                           \
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"

/* The same triangle; what was a list in version 2 was an object. */
#define GLTF_1(asset, address)                                                                     \
    "{" asset "\"scene\":\"s\",\"scenes\":{\"s\":{\"nodes\":[\"n\"]}},"                            \
    "\"nodes\":{\"n\":{\"meshes\":[\"m\"]}},\"meshes\":{\"m\":{\"primitives\":[{\"attributes\":"   \
    "{\"POSITION\":\"a\"},\"mode\":4}]}},\"accessors\":{\"a\":{\"bufferView\":\"v\","              \
    "\"byteOffset\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}},"                     \
    "\"bufferViews\":{\"v\":{\"buffer\":\"b\",\"byteOffset\":0,\"byteLength\":36}},"               \
    "\"buffers\":{\"b\":{\"byteLength\":36,\"type\":\"arraybuffer\",\"uri\":\"" address "\"}}}"

static const float triangle_bytes[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

static void a_gltf_names_the_file_that_it_lacks(void **state)
{
    (void)state;
    check_refused_path(write_gltf("lost.bin").text, ": needs the file lost.bin, which is missing",
                       ": put it beside the mesh file");
    check_refused_path(write_gltf("all/lost%20one.bin").text,
                       ": needs the file all/lost%20one.bin, which is missing",
                       ": put it beside the mesh file");
    check_refused("one.gltf", GLTF_1("\"asset\":{\"version\":\"1.0\"},", "lost.bin"),
                  ": needs the file lost.bin, which is missing", ": put it beside the mesh file");
}

static void blanks_in_the_name_of_a_gltfs_file_may_be_escaped(void **state)
{
    (void)state;
    test_folder_write(&folder, "two words.bin", triangle_bytes, sizeof triangle_bytes, 0600);
    rk_mesh mesh = load(write_gltf("two%20words.bin"));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_mesh_free(&mesh);
}

/* All corners are at (.1, .2) in set 0, and at (.5, .75) in set 1. */
static test_path write_sets(const char *name, const char *texture, bool is_glb)
{
    char json[2000];
    int size = snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_texture_transform\"],"
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
        "\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,"
        "\"TEXCOORD_1\":2}}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":"
        "{%s}}}],\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"red.ppm\"}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC2\"},{\"bufferView\":2,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC2\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24},"
        "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":24}],"
        "\"buffers\":[{\"byteLength\":84%s}]}",
        texture, is_glb ? "" : ",\"uri\":\"sets.bin\"");
    const float sets[2][6] = {{.1f, .2f, .1f, .2f, .1f, .2f}, {.5f, .75f, .5f, .75f, .5f, .75f}};
    unsigned char bytes[84], file[3000];
    memcpy(bytes, triangle_bytes, 36);
    memcpy(bytes + 36, sets, 48);
    test_folder_write(&folder, "red.ppm", "P6\n1 1\n255\n\377\0\0", 14, 0600);
    test_folder_write(&folder, "sets.bin", bytes, sizeof bytes, 0600);
    if (!is_glb)
        return write_text(name, json);
    while (size % 4)
        json[size++] = ' ';
    const uint32_t words[] = {2, (uint32_t)size + 112, (uint32_t)size}, length = 84;
    memcpy(file, "glTF", 4);
    memcpy(file + 4, words, 12);
    memcpy(file + 16, "JSON", 4);
    memcpy(file + 20, json, (size_t)size);
    memcpy(file + 20 + size, &length, 4);
    memcpy(file + 24 + size, "BIN", 4);
    memcpy(file + 28 + size, bytes, 84);
    return test_folder_write(&folder, name, file, (size_t)size + 112, 0600);
}

/* The extension's specification, "Overrides the textureInfo texCoord value". */
static void a_gltfs_transform_may_name_another_set_of_coordinates(void **state)
{
    (void)state;
#define TRANSFORM(members) "\"extensions\":{\"KHR_texture_transform\":{" members "}}"
    static const struct {
        const char *texture;
        float u, v;
    } sets[] = {
        {"\"index\":0," TRANSFORM(""), .1f, .2f},
        {"\"index\":0," TRANSFORM("\"texCoord\":1"), .5f, .75f},
        {"\"index\":0," TRANSFORM("\"texCoord\":1,\"offset\":[0.25,0]"), .75f, .75f},
        {"\"index\":0,\"texCoord\":1," TRANSFORM("\"texCoord\":0"), .1f, .2f},
        {TRANSFORM("\"texCoord\": 1") ",\"texCoord\":0,\"index\":0", .5f, .75f},
    };
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++)
        for (int is_glb = 0; is_glb < 2; is_glb++) {
            const char *name = is_glb ? "sets.glb" : "sets.gltf";
            rk_mesh mesh = load(write_sets(name, sets[i].texture, is_glb));
            rk_check_equal(mesh.texture_count, 1, sets[i].texture);
            const rk_vec2 at = mesh.texcoords[mesh.triangles[0][0]];
            rk_check_close(at.x, sets[i].u, 1e-6, sets[i].texture);
            rk_check_close(1 - at.y, sets[i].v, 1e-6, sets[i].texture);
            rk_mesh_free(&mesh);
        }
}

static void a_gltf_of_version_1_is_read_or_told_to_be_one(void **state)
{
    (void)state;
    rk_mesh mesh =
        load(write_text("one.gltf", GLTF_1("\"asset\":{\"version\":\"1.0\"},", TRIANGLE_ADDRESS)));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_mesh_free(&mesh);
    check_refused("none.gltf", GLTF_1("", TRIANGLE_ADDRESS), ": is glTF 1.0",
                  ": convert it to glTF 2.0");
    check_refused("broken.gltf", "{\"asset\":{\"version\":\"1.0\"},\"meshes\":{\"m\":3}}",
                  ": is glTF 1.0", ": convert it to glTF 2.0");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_mesh_of_an_fbx_in_different_materials_is_told),
    cmocka_unit_test(a_b3d_that_is_not_of_blitz3d_is_refused),
    cmocka_unit_test(collada_before_1_4_is_refused),
    cmocka_unit_test(a_file_beside_the_mesh_that_git_lfs_has_not_fetched_is_named),
    cmocka_unit_test(a_material_of_ac3d_beyond_the_last_is_the_first),
    cmocka_unit_test(nodes_of_an_x3d_that_are_not_drawn_are_told),
    cmocka_unit_test(a_group_of_an_x3d_may_be_used_again),
    cmocka_unit_test(a_group_of_an_x3d_may_be_empty),
    cmocka_unit_test(what_an_x3d_uses_again_may_use_others),
    cmocka_unit_test(a_group_of_an_x3d_that_cannot_be_used_is_refused),
    cmocka_unit_test(a_picture_of_an_x3d_may_have_quotes_and_others_after_it),
    cmocka_unit_test(colours_of_an_x3d_replace_the_diffuse_colour),
    cmocka_unit_test(an_x3d_names_the_file_that_it_lacks),
    cmocka_unit_test(a_picture_of_an_x3d_replaces_the_diffuse_colour_if_it_has_one),
    cmocka_unit_test(cones_of_an_x3d_point_upwards),
    cmocka_unit_test(a_gltf_names_the_file_that_it_lacks),
    cmocka_unit_test(blanks_in_the_name_of_a_gltfs_file_may_be_escaped),
    cmocka_unit_test(a_gltfs_transform_may_name_another_set_of_coordinates),
    cmocka_unit_test(a_gltf_of_version_1_is_read_or_told_to_be_one),
    cmocka_unit_test(a_small_file_may_show_a_part_many_times),
    cmocka_unit_test(pictures_inside_an_fbx_are_found_by_their_names),
    cmocka_unit_test(an_fbx_names_the_axis_that_points_up),
    cmocka_unit_test(an_fbx_that_hangs_from_its_axis_is_turned),
    cmocka_unit_test(a_collada_file_names_the_axis_that_points_up),
};

RK_SUITE_IN("mesh_scenes", tests, make_folder, remove_folder)
