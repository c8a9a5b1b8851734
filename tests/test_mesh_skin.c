/* Parts that move: bones and morph targets stand as the file says, or it is told. */
#include "test_mesh_reading.h"

/* A triangle whose part has two joints, and the numbers of its skin. */
typedef struct skinned {
    const char *node, *joints,
        *skin;        /* further words of the part's node, the two joints, the skin */
    int weight_kind;  /* componentType */
    float weights[2]; /* of each vertex */
    float offset;     /* of both inverse bind matrices, along x */
} skinned;

static void put_float(unsigned char *to, size_t *size, float value)
{
    memcpy(to + *size, &value, sizeof value);
    *size += sizeof value;
}

static test_path write_skinned(const skinned *s)
{
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    unsigned char bytes[400] = {0};
    char text[3000];
    size_t size = 0;
    for (int i = 0; i < 9; i++)
        put_float(bytes, &size, corners[i]);
    for (int i = 0; i < 9; i++)
        put_float(bytes, &size, i % 3 == 2);
    for (int i = 0; i < 3; i++, size += 4)
        bytes[size + 1] = 1; /* joints 0 and 1 */
    for (int i = 0; i < 12; i++)
        put_float(bytes, &size, i % 4 < 2 ? s->weights[i % 4] : 0);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 16; k++)
            put_float(bytes, &size, k == 12 ? s->offset : k % 5 == 0);
    test_folder_write(&folder, "skin.bin", (const char *)bytes, size, 0600);
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
             "\"nodes\":[{\"mesh\":0,\"skin\":0%s},%s],"
             "\"skins\":[{\"joints\":[1,2]%s}],\"meshes\":[{\"primitives\":[{\"attributes\":"
             "{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":2,\"WEIGHTS_0\":3}}]}],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
             "{\"bufferView\":2,\"componentType\":5121,\"count\":3,\"type\":\"VEC4\"},"
             "{\"bufferView\":3,\"componentType\":%d,\"normalized\":%s,\"count\":3,"
             "\"type\":\"VEC4\"},"
             "{\"bufferView\":4,\"componentType\":5126,\"count\":2,\"type\":\"MAT4\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
             "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},"
             "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":12},"
             "{\"buffer\":0,\"byteOffset\":84,\"byteLength\":48},"
             "{\"buffer\":0,\"byteOffset\":132,\"byteLength\":128}],"
             "\"buffers\":[{\"byteLength\":%zu,\"uri\":\"skin.bin\"}]}",
             s->node, s->joints, s->skin, s->weight_kind, s->weight_kind == 5126 ? "false" : "true",
             size);
    return write_text("skin.gltf", text);
}

#define MATRICES ",\"inverseBindMatrices\":4"
#define JOINTS(a, b) "{\"name\":\"a\"," a "},{\"name\":\"b\"," b "}"
#define UP "\"translation\":[0,5,0]"
#define AHEAD "\"translation\":[0,0,3]"

static void a_skin_stands_as_its_joints_do(void **state)
{
    (void)state;
    static const struct {
        skinned file;
        float x, y, z; /* of the first vertex */
    } cases[] = {
        {{"", JOINTS(UP, AHEAD), MATRICES, 5126, {1, 0}, 0}, 0, 5, 0},
        {{"", JOINTS(UP, AHEAD), MATRICES, 5126, {0.5f, 0.5f}, 2}, 2, 2.5f, 1.5f},
        {{"", JOINTS(UP, AHEAD), MATRICES, 5126, {1, 1}, 2}, 2, 2.5f, 1.5f},
        {{",\"translation\":[7,0,0]", JOINTS(UP, AHEAD), MATRICES, 5126, {1, 0}, 0}, 0, 5, 0},
        /* Without weights, its node moves it. */
        {{",\"translation\":[7,0,0]", JOINTS(UP, AHEAD), MATRICES, 5126, {0, 0}, 0}, 7, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_mesh mesh = load(write_skinned(&cases[i].file));
        check_point(corner(&mesh, 0, 0), cases[i].x, cases[i].y, cases[i].z);
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        rk_mesh_free(&mesh);
    }
}

/* By half a turn about x. */
static void normals_of_a_skin_turn_with_it(void **state)
{
    (void)state;
    const skinned file = {"", JOINTS("\"rotation\":[1,0,0,0]", UP), MATRICES, 5126, {1, 0}, 0};
    rk_mesh mesh = load(write_skinned(&file));
    check_point(mesh.normals[mesh.triangles[0][0]], 0, 0, -1);
    check_point(vector_area(&mesh, 0), 0, 0, -0.5f);
    rk_mesh_free(&mesh);
}

/* To the bit, though matrices are rounded. */
static void a_skin_at_rest_stays_where_it_is(void **state)
{
    (void)state;
    const skinned file = {"", JOINTS("\"translation\":[-2.00001,0,0]", UP), MATRICES, 5126, {1, 0},
                          2};
    rk_mesh mesh = load(write_skinned(&file));
    check_point(corner(&mesh, 0, 0), 0, 0, 0);
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_mesh_free(&mesh);
}

static void a_skin_that_is_not_applied_is_told(void **state)
{
    (void)state;
    static const struct {
        skinned file;
        const char *note;
    } cases[] = {
        {{"", "{\"name\":\"a\"," UP "},{\"name\":\"a\"," AHEAD "}", MATRICES, 5126, {1, 0}, 0},
         "its joint \"a\" is missing, or has the name of another"},
        {{"", JOINTS(UP, AHEAD), MATRICES, 5121, {1, 0}, 0}, "its weights are integers"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_mesh mesh = load_with_note(write_skinned(&cases[i].file), cases[i].note);
        check_point(corner(&mesh, 0, 0), 0, 0, 0);
        rk_mesh_free(&mesh);
    }
}

static void a_skin_without_matrices_is_refused(void **state)
{
    (void)state;
    const skinned file = {"", JOINTS(UP, AHEAD), "", 5126, {1, 0}, 0};
    check_refused_path(write_skinned(&file).text, ": has a skin without inverse bind matrices", "");
}

#define SOURCE(id, array, param, type, stride)                                                     \
    "<source id=\"" id "\">" array "<technique_common><accessor source=\"#" id "a\" count=\"1\" "  \
    "stride=\"" #stride "\"><param name=\"" param "\" type=\"" type "\"/></accessor>"              \
    "</technique_common></source>"
#define UNIT "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"

/* A triangle bound to a joint at the origin, which has moved by `place` since. */
static test_path write_collada_skin(const char *place)
{
    char text[4000];
    snprintf(
        text, sizeof text,
        "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"
        "<up_axis>Y_UP</up_axis></asset><library_controllers><controller id=\"c\"><skin "
        "source=\"#g\"><bind_shape_matrix>" UNIT "</bind_shape_matrix>" SOURCE(
            "j", "<Name_array id=\"ja\" count=\"1\">J</Name_array>", "JOINT", "Name",
            1) SOURCE("b", "<float_array id=\"ba\" count=\"16\">" UNIT "</float_array>",
                      "TRANSFORM", "float4x4", 16)
            SOURCE(
                "w", "<float_array id=\"wa\" count=\"1\">1</float_array>", "WEIGHT", "float",
                1) "<joints><input semantic=\"JOINT\" source=\"#j\"/><input "
                   "semantic=\"INV_BIND_MATRIX\" "
                   "source=\"#b\"/></joints><vertex_weights count=\"3\"><input semantic=\"JOINT\" "
                   "source=\"#j\" offset=\"0\"/><input semantic=\"WEIGHT\" source=\"#w\" "
                   "offset=\"1\"/>"
                   "<vcount>1 1 1</vcount><v>0 0 0 0 0 0</v></vertex_weights></skin></controller>"
                   "</library_controllers><library_geometries><geometry id=\"g\"><mesh><source "
                   "id=\"p\">"
                   "<float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 1 "
                   "0</float_array><technique_common>"
                   "<accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" "
                   "type=\"float\"/>"
                   "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
                   "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
                   "source=\"#p\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" "
                   "source=\"#v\" "
                   "offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"
                   "<library_visual_scenes><visual_scene id=\"s\"><node id=\"J\" sid=\"J\" "
                   "type=\"JOINT\">"
                   "<translate>%s</translate></node><node><instance_controller "
                   "url=\"#c\"><skeleton>#J"
                   "</skeleton></instance_controller></node></visual_scene></"
                   "library_visual_scenes><scene>"
                   "<instance_visual_scene url=\"#s\"/></scene></COLLADA>",
        place);
    return write_text("skin.dae", text);
}

static void a_skin_of_collada_is_drawn_as_it_was_bound(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_collada_skin("0 0 0"));
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_collada_skin("0 5 0"),
                          "joints stand elsewhere than where it was bound to them");
    check_point(corner(&mesh, 0, 1), 1, 0, 0);
    rk_mesh_free(&mesh);
}

/* Of a file without meshes, Assimp draws the nodes. */
static void a_skeleton_is_no_mesh(void **state)
{
    (void)state;
    check_refused("bones.dae",
                  "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
                  "version=\"1.4.1\"><asset/><library_visual_scenes><visual_scene id=\"s\">"
                  "<node id=\"a\"><translate>0 0 1</translate><node id=\"b\"/></node>"
                  "</visual_scene></library_visual_scenes><scene>"
                  "<instance_visual_scene url=\"#s\"/></scene></COLLADA>",
                  ": has no triangles", "");
}

/* By half of the second triangle's difference, (0, 0, 2). */
static void morph_targets_have_the_files_weights(void **state)
{
    (void)state;
    static const float rows[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 2, 0, 0, 2};
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
        "{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":["
        "{\"POSITION\":1}]}],\"weights\":[%s]}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":72,\"uri\":\"morph.bin\"}]}";
    static const char *const weights[] = {"0", "0.5"};
    test_folder_write(&folder, "morph.bin", (const char *)rows, sizeof rows, 0600);
    for (int i = 0; i < 2; i++) {
        char file[2000];
        snprintf(file, sizeof file, text, weights[i]);
        rk_mesh mesh = load(write_text("morph.gltf", file));
        check_point(corner(&mesh, 0, 1), 1, 0, (float)i);
        rk_mesh_free(&mesh);
    }
}

static void morph_weights_of_a_node_are_told(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("node.gltf",
                   "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                   "\"nodes\":[{\"mesh\":0,\"weights\":[0.5]}],\"meshes\":[{\"primitives\":["
                   "{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":0}]}]}],"
                   "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
                   "\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                   "\"buffers\":[{\"byteLength\":36,\"uri\":\"morph.bin\"}]}"),
        "weights of morph targets in its nodes, which Assimp does not read");
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_skin_stands_as_its_joints_do),
    cmocka_unit_test(normals_of_a_skin_turn_with_it),
    cmocka_unit_test(a_skin_at_rest_stays_where_it_is),
    cmocka_unit_test(a_skin_that_is_not_applied_is_told),
    cmocka_unit_test(a_skin_without_matrices_is_refused),
    cmocka_unit_test(a_skin_of_collada_is_drawn_as_it_was_bound),
    cmocka_unit_test(morph_targets_have_the_files_weights),
    cmocka_unit_test(morph_weights_of_a_node_are_told),
    cmocka_unit_test(a_skeleton_is_no_mesh),
};

RK_SUITE_IN("mesh_skin", tests, make_folder, remove_folder)
