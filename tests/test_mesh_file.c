/* Mesh files: each format loads to the same mesh, and a fault is reported in one line that names
 * the file and the place. */
#include "test.h"

#include "mesh_seeds.h"
#include "quarters.h"
#include "test_cost.h"
#include "test_mesh_reading.h"

#include "io/mesh_stream.h"

static test_path write_seed(int format)
{
    mesh_seed seed = make_seed(format);
    test_folder_write(&folder, "seed.mtl", seed_mtl, sizeof seed_mtl - 1, 0600);
    return test_folder_write(&folder, seed.name, seed.bytes, seed.size, 0600);
}

/* --- loading -------------------------------------------------------------------------------- */

static void every_format_gives_the_same_square_and_triangle(void **state)
{
    (void)state;
    for (int format = seed_obj; format <= seed_off; format++) {
        rk_mesh mesh = load(write_seed(format));
        rk_check_equal(mesh.triangle_count, 3, "a square as two triangles, and a triangle");
        check_point(vector_area(&mesh, 0), 0, 0, 0.5f);
        check_point(vector_area(&mesh, 1), 0, 0, 0.5f);
        check_point(corner(&mesh, 2, 0), 0, 0, 0);
        check_point(corner(&mesh, 2, 1), 1, 0, 0);
        check_point(corner(&mesh, 2, 2), 0.5f, 0, 1);
        if (format != seed_obj) {
            rk_check_equal(mesh.vertex_count, 5, "common corners are one vertex");
            rk_check_equal(mesh.material_count, 1, "the default");
            check_point(mesh.materials[0].kd, 0.8f, 0.8f, 0.8f);
            rk_check(!mesh.normals && !mesh.texcoords, "the file has none");
        }
        rk_mesh_free(&mesh);
    }
}

static void the_order_of_bytes_in_a_ply_does_not_matter(void **state)
{
    (void)state;
    mesh_seed little = make_seed(seed_ply_binary), big = {.name = "big.ply"};
    size_t body = little.size - (60 + 17 + 13), at = body;
    const char *rest = strstr((char *)little.bytes, "1.0");
    seed_append_text(&big, "ply\nformat binary_big_endian ");
    seed_append(&big, rest, body - (size_t)(rest - (char *)little.bytes));
    for (int word = 0; word < 15 + 4 + 3; word++) {
        if (word == 15 || word == 19)
            big.bytes[big.size++] = little.bytes[at++];
        for (size_t i = 0; i < 4; i++)
            big.bytes[big.size++] = little.bytes[at + 3 - i];
        at += 4;
    }
    rk_mesh mesh = load(test_folder_write(&folder, big.name, big.bytes, big.size, 0600));
    rk_check_equal(mesh.triangle_count, 3, "as from the other order");
    check_point(corner(&mesh, 2, 2), 0.5f, 0, 1);
    rk_mesh_free(&mesh);
}

static void obj_brings_materials_unit_normals_and_texture_coordinates(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_seed(seed_obj));
    rk_check_equal(mesh.vertex_count, 7, "four corners, and three with another normal");
    rk_check_equal(mesh.material_count, 2, "red and green");
    const rk_material *red = &mesh.materials[mesh.triangle_materials[0]];
    const rk_material *green = &mesh.materials[mesh.triangle_materials[2]];
    rk_check_equal(mesh.triangle_materials[1], mesh.triangle_materials[0],
                   "one square, one material");
    check_point(red->kd, 1, 0, 0);
    check_point(red->ks, 0.1f, 0.2f, 0.3f);
    rk_check_close(red->shininess, 50, 0, "Ns as written");
    rk_check_close(red->alpha, 0.5, 0, "d is the opacity");
    check_point(green->kd, 0, 1, 0);
    rk_check_close(green->alpha, 0.75, 0, "Tr is 1 - opacity");
    rk_check_close(rk_length(red->absorption), 0, 0, "not read from meshes: clear glass");
    assert_non_null(mesh.normals);
    assert_non_null(mesh.texcoords);
    check_point(mesh.normals[mesh.triangles[0][0]], 0, 0, 1);
    check_point(mesh.normals[mesh.triangles[2][0]], 0, -1, 0);
    rk_vec2 uv = mesh.texcoords[mesh.triangles[2][2]];
    rk_check(uv.x == 1 && uv.y == 1, "got texture coordinate (%g, %g)", (double)uv.x, (double)uv.y);
    rk_mesh_free(&mesh);
}

static void gltf_parts_stand_where_their_nodes_put_them(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_seed(seed_gltf));
    rk_check_equal(mesh.triangle_count, 3, "two parts");
    rk_check_equal(mesh.vertex_count, 7,
                   "the moved parts have no common point; unused ones are left out");
    check_point(corner(&mesh, 0, 0), 10, 0, 0);
    check_point(corner(&mesh, 0, 2), 11, 1, 0);
    check_point(corner(&mesh, 2, 2), 1, 0, 2);
    const rk_material *glass = &mesh.materials[mesh.triangle_materials[0]];
    const rk_material *solid = &mesh.materials[mesh.triangle_materials[2]];
    check_point(glass->kd, 1, 0, 0);
    rk_check_close(glass->alpha, 0.5, 0, "alphaMode BLEND takes the base colour's alpha");
    check_point(solid->kd, 0, 1, 0);
    rk_check_close(solid->alpha, 1, 0, "alphaMode OPAQUE, the default, ignores it");
    rk_mesh_free(&mesh);
}

static void a_part_without_normals_takes_its_faces_own(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("mixed.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 3\n"
                                                "o a\nf 1//1 2//1 3//1\no b\nf 1 3 4\n"));
    assert_non_null(mesh.normals);
    check_point(mesh.normals[mesh.triangles[0][0]], 0, 0, 1);
    for (int k = 0; k < 3; k++)
        check_point(mesh.normals[mesh.triangles[1][k]], 1, 0, 0);
    rk_mesh_free(&mesh);
}

static void a_zero_normal_is_replaced_by_the_faces(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\n"
                                               "f 1//1 2//1 3//1\n"));
    assert_non_null(mesh.normals);
    check_point(mesh.normals[0], 0, 0, 1);
    rk_mesh_free(&mesh);
}

/* An L, from its inner corner's neighbour, clockwise and counterclockwise: a fan would extend
 * beyond it. */
static void a_polygon_that_is_not_convex_is_triangulated_inside(void **state)
{
    (void)state;
    const char *texts[] = {"f 1 2 3 4 5 6\n", "f 6 5 4 3 2 1\n", "f 3 4 5 6 1 2\n"};
    for (int i = 0; i < 3; i++) {
        char text[200];
        snprintf(text, sizeof text, "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n%s",
                 texts[i]);
        rk_mesh mesh = load(write_text("ell.obj", text));
        rk_check_equal(mesh.triangle_count, 4, "corners - 2");
        double area = 0;
        for (uint32_t t = 0; t < 4; t++) {
            float z = vector_area(&mesh, t).z;
            rk_check(i == 1 ? z < 0 : z > 0, "triangle %u turns the other way", t);
            area += fabs((double)z);
        }
        rk_check_close(area, 3, 0, "with one sense of turn, the area is right only inside the L");
        rk_mesh_free(&mesh);
    }
}

/* A comb: every other corner turns the other way. */
static void check_comb(uint32_t corners, const char *part)
{
    test_path path = test_folder_path(&folder, "comb.obj");
    FILE *file = fopen(path.text, "wb");
    rk_check(file, "%s can be written", path.text);
    for (uint32_t i = 0; i + 2 < corners; i++)
        fprintf(file, "v %u %d 0\n", i, i % 2 ? -2 : -1);
    fprintf(file, "v %u 9 0\nv 0 9 0\nf", corners);
    for (uint32_t i = 1; i <= corners; i++)
        fprintf(file, " %u", i);
    fputs("\n", file);
    rk_check(fclose(file) == 0, "%s can be written", path.text);
    if (part) {
        check_refused_path(path.text, ": ", part);
        return;
    }
    rk_mesh mesh = load(path);
    rk_check_equal(mesh.triangle_count, corners - 2, "corners - 2");
    rk_mesh_free(&mesh);
}

static void a_polygon_that_would_take_minutes_is_refused(void **state)
{
    (void)state;
    check_comb(2000, NULL);
    check_comb(32769, "a face has 32769 corners and is not convex: at most 32768");
}

static void a_byte_order_mark_is_no_part_of_the_text(void **state)
{
    (void)state;
    write_text("marked.mtl", "\xef\xbb\xbfnewmtl red\nKd 1 0 0\n");
    rk_mesh mesh = load(write_text("marked.obj", "\xef\xbb\xbfv 3 0 0\nv 1 0 0\nv 0 1 0\n"
                                                 "mtllib marked.mtl\nusemtl red\nf 1 2 3\n"));
    rk_check_close(corner(&mesh, 0, 0).x, 3, 0, "the first line counts");
    rk_check_close(mesh.materials[0].kd.y, 0, 0, "and so does that of the materials");
    rk_mesh_free(&mesh);
}

/* Opening it would wait for a process at its other end. */
static void a_pipe_as_material_file_is_as_good_as_none(void **state)
{
    (void)state;
    rk_check(mkfifo(test_folder_path(&folder, "pipe.mtl").text, 0600) == 0, "a pipe can be made");
    test_path path = write_text("piped.obj", "mtllib pipe.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                             "f 1 2 3\n");
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check_error_names(error, ":1: the material file pipe.mtl is missing");
    rk_mesh_free(&mesh);
}

static void points_and_lines_are_dropped(void **state)
{
    (void)state;
    rk_mesh mesh =
        load_with_note(write_text("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1\nl 1 2\nf 1 2 3\n"),
                       "has points or lines, which the picture does not show");
    rk_check_equal(mesh.triangle_count, 1, "the one face");
    rk_mesh_free(&mesh);
}

static void windows_line_ends_and_long_lines_are_fine(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_text("dos.obj", "v 0 0 0\r\nv 1 0 0 # comment\r\nv 0 1 0\r\n"
                                              "f 1 2 \\\r\n3\r\n"));
    rk_check_equal(mesh.triangle_count, 1, "a backslash joins lines");
    rk_mesh_free(&mesh);
}

static void a_missing_mtl_is_a_note_not_an_error(void **state)
{
    (void)state;
    test_path path = write_text("lonely.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                              "usemtl red\nf 1 2 3\n");
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check_error_names(error, "lonely.obj:1: the material file gone.mtl is missing");
    check_point(mesh.materials[0].kd, 0.8f, 0.8f, 0.8f);
    rk_mesh_free(&mesh);
}

/* --- colours of vertices and faces ----------------------------------------------------------- */

/* (0, 0), (1, 0) and (0, 1) of a plane have these colours: red, 128 of 255 of green, white. */
static void check_coloured_corners(const rk_mesh *mesh, double half)
{
    assert_non_null(mesh->colours);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 p = mesh->positions[i], got = mesh->colours[i];
        const double want[3] = {p.x == 1 ? 0 : 1, p.x == 1 ? half : p.y == 1, p.y == 1};
        for (int c = 0; c < 3; c++) /* text of six digits, or 16 bits of 65535 */
            rk_check_close(rk_axis(got, c), want[c], 2e-5, "the corner's own colour");
    }
    check_point(mesh->materials[0].kd, 1, 1, 1);
}

#define PLY_OF(type, rows)                                                                         \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"                \
    "property float z\nproperty " type " red\nproperty " type " green\nproperty " type             \
    " blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" rows "3 0 1 2\n"

/* 128 / 255 is .215861 in linear light, by IEC 61966-2-1. */
static void colours_of_vertices_are_srgb_in_scans(void **state)
{
    (void)state;
    static const char *const files[][2] = {
        {"v.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 0.501961 0\nv 0 1 0 1 1 1\nf 1 2 3\n"},
        {"v255.obj", "v 0 0 0 255 0 0\nv 1 0 0 0 128 0\nv 0 1 0 255 255 255\nf 1 2 3\n"},
        {"v.off", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 128 0 255\n0 1 0 255 255 255 255\n"
                  "3 0 1 2\n"},
        {"vf.off", "COFF\n3 1 0\n0 0 0 1.0 0 0 1\n1 0 0 0 0.501961 0 1\n0 1 0 1 1 1 1\n3 0 1 2\n"},
        {"vb.ply", PLY_OF("uchar", "0 0 0 255 0 0\n1 0 0 0 128 0\n0 1 0 255 255 255\n")},
        {"vs.ply", PLY_OF("ushort", "0 0 0 65535 0 0\n1 0 0 0 32896 0\n0 1 0 65535 65535 65535\n")},
        {"vf.ply", PLY_OF("float", "0 0 0 1 0 0\n1 0 0 0 0.501961 0\n0 1 0 1 1 1\n")},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        rk_mesh mesh = load(write_text(files[i][0], files[i][1]));
        rk_check_equal(mesh.vertex_count, 3, "as many as in the file");
        check_coloured_corners(&mesh, 0.215861);
        rk_mesh_free(&mesh);
    }
}

/* By the specification COLOR_0 is linear, and multiplies the base colour. */
static void check_gltf_colours(const char *type, const char *stride)
{
    mesh_seed seed = {0}, buffer = {0};
    const unsigned char colours[12] = {255, 0, 0, 255, 0, 128, 0, 255, 255, 255, 255, 255};
    const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 9; i++) {
        uint32_t bits;
        memcpy(&bits, &points[i], sizeof bits);
        seed_append_word(&buffer, bits);
    }
    seed_append(&buffer, colours, sizeof colours);
    seed_append_text(
        &seed,
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},"
        "\"material\":0}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":"
        "[1,0.5,0.25,1]}}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5121,\"normalized\":true,\"count\":3,"
        "\"type\":\"");
    seed_append_text(&seed, type);
    seed_append_text(&seed, "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
                            "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":12");
    seed_append_text(&seed, stride);
    seed_append_text(&seed, "}],\"buffers\":[{"
                            "\"byteLength\":48,\"uri\":\"data:application/octet-stream;base64,");
    seed_append_base64(&seed, buffer.bytes, buffer.size);
    seed_append_text(&seed, "\"}]}\n");
    rk_mesh mesh = load(test_folder_write(&folder, "v.gltf", seed.bytes, seed.size, 0600));
    check_point(mesh.materials[0].kd, 1, 0.5f, 0.25f);
    mesh.materials[0].kd = rk_vec(1, 1, 1);
    check_coloured_corners(&mesh, 128 / 255.0);
    rk_mesh_free(&mesh);
}

/* Of three numbers they are opaque. */
static void colours_of_vertices_are_linear_in_gltf_and_multiply_the_base_colour(void **state)
{
    (void)state;
    check_gltf_colours("VEC4", "");
    check_gltf_colours("VEC3", ",\"byteStride\":4");
}

/* Two triangles of a square; a quadrilateral and one that Assimp drops, of ten corners, follow. */
static void faces_of_an_off_file_have_colours_of_their_own(void **state)
{
    (void)state;
    rk_mesh mesh = load_with_note(
        write_text("faces.off", "OFF\n# four corners\n4 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                                "3 0 1 2 255 0 0\n10 0 1 2 3 0 1 2 3 0 1 9 9 9\n"
                                "3 0 2 3  0 0 255 255 # blue\n4 0 1 2 3\n"),
        "has 4 faces of 20 corners, but Assimp reads 3 of 10");
    assert_non_null(mesh.colours);
    for (int k = 0; k < 3; k++) {
        check_point(mesh.colours[mesh.triangles[0][k]], 1, 0, 0);
        check_point(mesh.colours[mesh.triangles[1][k]], 0, 0, 1);
        check_point(mesh.colours[mesh.triangles[2][k]], 1, 1, 1);
    }
    rk_mesh_free(&mesh);
}

static void a_file_whose_vertices_are_all_white_has_no_colours(void **state)
{
    (void)state;
    write_text("red.mtl", "newmtl red\nKd 1 0 0\n");
    rk_mesh mesh = load(write_text("white.obj", "mtllib red.mtl\nusemtl red\nv 0 0 0 1 1 1\n"
                                                "v 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n"));
    rk_check(!mesh.colours, "they would hide the material's red, and take memory");
    check_point(mesh.materials[0].kd, 1, 0, 0);
    rk_mesh_free(&mesh);
}

/* Exporters of scans write both: drawn together, the picture would be too dark. */
static void a_scans_picture_is_not_multiplied_by_its_vertices_colours(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    write_text("both.mtl", "newmtl a\nmap_Kd quarters.png\nnewmtl b\nKd 0 1 0\n");
    rk_mesh mesh = load_with_note(
        write_text("both.obj",
                   "mtllib both.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\n"
                   "vt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 3/1 2/2 1/3\n"),
        "has colours of vertices where there are pictures");
    assert_non_null(mesh.colours);
    check_point(mesh.colours[mesh.triangles[0][0]], 1, 1, 1);
    check_point(mesh.colours[mesh.triangles[1][0]], 1, 0, 0);
    check_point(mesh.materials[mesh.triangle_materials[1]].kd, 1, 1, 1);
    rk_mesh_free(&mesh);
}

static void colours_of_only_some_vertices_are_not_drawn(void **state)
{
    (void)state;
    rk_mesh mesh =
        load_with_note(write_text("some.obj", "v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nf 1 2 3\n"),
                       "has colours of only some vertices");
    rk_check(!mesh.colours, "whose they are is not known");
    check_point(mesh.materials[0].kd, 0.8f, 0.8f, 0.8f);
    rk_mesh_free(&mesh);
}

/* --- textures ------------------------------------------------------------------------------ */

/* A square with the centres of the four texels as texture coordinates of its corners, once per
 * material. */
static test_path write_textured_obj(const char *mtl, const char *materials)
{
    char text[400];
    snprintf(text, sizeof text,
             "mtllib textured.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
             "vt 0.25 0.25\nvt 0.75 0.25\nvt 0.75 0.75\nvt 0.25 0.75\n");
    for (const char *name = materials; *name; name++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "usemtl %c\nf 1/1 2/2 3/3 4/4\n",
                 *name);
    write_text("textured.mtl", mtl);
    return write_text("textured.obj", text);
}

static const rk_texture *texture_of(const rk_mesh *mesh, uint32_t triangle)
{
    return mesh->materials[mesh->triangle_materials[triangle]].kd_texture;
}

/* Seen from +z, the picture is upright on the unit square. */
static void check_upright(const rk_mesh *mesh)
{
    const rk_texture *texture = texture_of(mesh, 0);
    assert_non_null(texture);
    assert_non_null(mesh->texcoords);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 p = mesh->positions[i], red = {1, 0, 0}, green = {0, 1, 0}, blue = {0, 0, 1},
                white = {1, 1, 1};
        rk_vec2 uv = mesh->texcoords[i];
        check_texel(texture, uv.x, uv.y,
                    p.y > 0.5f ? (p.x > 0.5f ? green : red) : (p.x > 0.5f ? white : blue));
    }
}

static void an_obj_shows_its_picture_upright(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_textured_obj("newmtl a\nKd 1 0.5 1\nmap_Kd quarters.png\n", "a"));
    check_upright(&mesh);
    check_point(mesh.materials[0].kd, 1, 0.5f, 1);
    rk_check_equal(texture_of(&mesh, 0)->wrap, RK_TEXTURE_REPEAT, "unless -clamp is on");
    rk_mesh_free(&mesh);
}

static void a_picture_without_kd_is_not_darkened(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd quarters.png\nnewmtl b\nKs 0 0 0\n"
                                           "newmtl c\nKd 0.6 0.6 0.5\nmap_Kd quarters.png\n",
                                           "abc"));
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 1, 1);
    check_point(mesh.materials[mesh.triangle_materials[2]].kd, 0.6f, 0.6f, 0.6f);
    check_point(mesh.materials[mesh.triangle_materials[4]].kd, 0.6f, 0.6f, 0.5f);
    rk_mesh_free(&mesh);
}

static void a_ply_shows_the_picture_of_its_comment_in_its_own_colours(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_text(
        "textured.ply", "ply\nformat ascii 1.0\ncomment TextureFile quarters.png\n"
                        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                        "property float s\nproperty float t\nelement face 1\n"
                        "property list uchar int vertex_indices\nend_header\n"
                        "0 0 0 0.25 0.25\n1 0 0 0.75 0.25\n1 1 0 0.75 0.75\n0 1 0 0.25 0.75\n"
                        "4 0 1 2 3\n"));
    check_upright(&mesh);
    check_point(mesh.materials[0].kd, 1, 1, 1);
    rk_mesh_free(&mesh);
}

static test_path write_textured_gltf(const char *image, const char *sampler)
{
    mesh_seed seed = {0};
    seed_append_textured_gltf(&seed, image, sampler);
    return test_folder_write(&folder, "textured.gltf", seed.bytes, seed.size, 0600);
}

static void a_gltf_shows_its_picture_upright_by_the_set_that_it_names(void **state)
{
    (void)state;
    write_quarters(&folder, "two words.png");
    rk_mesh mesh = load(write_textured_gltf("\"uri\":\"two%20words.png\"", ""));
    check_upright(&mesh);
    check_point(mesh.materials[0].kd, 1, 1, 1);
    rk_check_equal(texture_of(&mesh, 0)->wrap, RK_TEXTURE_REPEAT, "the default");
    rk_mesh_free(&mesh);
}

static void a_gltf_may_hold_its_picture_and_clamp_it(void **state)
{
    (void)state;
    rk_mesh mesh = load(write_textured_gltf(seed_picture, "\"wrapS\":33071,\"wrapT\":33071"));
    check_upright(&mesh);
    rk_check_equal(texture_of(&mesh, 0)->wrap, RK_TEXTURE_CLAMP, "CLAMP_TO_EDGE");
    rk_mesh_free(&mesh);
}

static void options_and_blanks_around_a_pictures_name_are_not_part_of_it(void **state)
{
    (void)state;
    write_quarters(&folder, "two words.png");
    rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd -s 1 1 1 two words.png \t\r\n"
                                           "newmtl b\nmap_Kd -clamp on two words.png\r\n",
                                           "ab"));
    check_upright(&mesh);
    rk_check_equal(texture_of(&mesh, 0)->wrap, RK_TEXTURE_REPEAT, "the first has no -clamp");
    assert_non_null(texture_of(&mesh, 2));
    rk_check_equal(texture_of(&mesh, 2)->wrap, RK_TEXTURE_CLAMP, "the second has -clamp on");
    rk_check_equal(mesh.texture_count, 2, "one repeats, one is clamped");
    rk_mesh_free(&mesh);
}

static void materials_that_name_the_same_picture_share_it(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd quarters.png\n"
                                           "newmtl b\nKd 1 0 0\nmap_Kd quarters.png\n"
                                           "newmtl c\nKd 0 1 0\n",
                                           "abc"));
    rk_check_equal(mesh.material_count, 3, "a, b and c");
    rk_check_equal(mesh.texture_count, 1, "read once");
    assert_non_null(texture_of(&mesh, 0));
    rk_check(texture_of(&mesh, 0) == texture_of(&mesh, 2), "a and b name the same picture");
    rk_check(texture_of(&mesh, 4) == NULL, "c names none");
    rk_mesh_free(&mesh);
}

static void a_missing_or_damaged_picture_is_a_note_not_an_error(void **state)
{
    (void)state;
    size_t size;
    unsigned char *bytes = test_folder_read(write_quarters(&folder, "quarters.png"), &size);
    test_folder_write(&folder, "half.png", bytes, size / 2, 0600);
    free(bytes);
    test_path path = write_textured_obj("newmtl a\nKd 1 0 0\nmap_Kd gone.png\n"
                                        "newmtl b\nmap_Kd quarters.png\n"
                                        "newmtl c\nmap_Kd half.png\n",
                                        "abc");
    rk_mesh mesh = load_with_note(path, "gone.png: No such file");
    rk_check(texture_of(&mesh, 0) == NULL, "a shows its colour alone");
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 1, 0, 0);
    assert_non_null(texture_of(&mesh, 2));
    check_quarters(texture_of(&mesh, 2));
    rk_check(texture_of(&mesh, 4) == NULL, "half a picture is none");
    rk_mesh_free(&mesh);
    mesh = load_with_note(path, "2 of 3 textures");
    rk_mesh_free(&mesh);
}

/* Puts this helper's real program, with a count of its starts, into the folder. False if there is
 * none: raykit can be built without it. */
static bool install_counted(const char *program)
{
    const char *named = getenv("RAYKIT_HELPERS");
    char script[3 * sizeof folder + 500];
    int length = snprintf(script, sizeof script, "%s/%s", named ? named : ".", program);
    if (access(script, X_OK) != 0)
        return false;
    length =
        snprintf(script, sizeof script, "#!/bin/sh\necho >>'%s/%s-starts'\nexec '%s/%s' \"$@\"\n",
                 folder.path, program, named ? named : ".", program);
    test_folder_write(&folder, program, script, (size_t)length, 0700);
    return true;
}

/* A picture of one colour that only raykit-image reads. */
static void write_ppm(const char *name, unsigned char r, unsigned char g, unsigned char b)
{
    unsigned char bytes[] = "P6\n1 1\n255\nrgb";
    bytes[11] = r, bytes[12] = g, bytes[13] = b;
    test_folder_write(&folder, name, bytes, sizeof bytes - 1, 0600);
}

static void the_pictures_of_a_mesh_start_their_helper_once(void **state)
{
    (void)state;
    if (!install_counted("raykit-mesh") || !install_counted("raykit-image"))
        skip();
    write_ppm("red.ppm", 255, 0, 0);
    write_text("broken.ppm", "P6\n900 900\n255\n");
    write_ppm("blue.ppm", 0, 0, 255);
    test_path path = write_textured_obj("newmtl a\nmap_Kd red.ppm\n"
                                        "newmtl b\nmap_Kd broken.ppm\n"
                                        "newmtl c\nmap_Kd blue.ppm\n",
                                        "abc");
    char *before = strdup(getenv("RAYKIT_HELPERS"));
    setenv("RAYKIT_HELPERS", folder.path, 1);
    rk_mesh mesh = load_with_note(path, "1 of 3 textures cannot be read");
    setenv("RAYKIT_HELPERS", before, 1);
    free(before);
    check_texel(texture_of(&mesh, 0), 0.5f, 0.5f, rk_vec(1, 0, 0));
    rk_check(texture_of(&mesh, 2) == NULL, "the broken picture costs only itself");
    check_texel(texture_of(&mesh, 4), 0.5f, 0.5f, rk_vec(0, 0, 1));
    rk_mesh_free(&mesh);
    size_t starts = 0;
    free(test_folder_read(test_folder_path(&folder, "raykit-image-starts"), &starts));
    rk_check_equal(starts, 1, "starts for three pictures");
}

static void pictures_without_texture_coordinates_are_a_note(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    write_text("bare.mtl", "newmtl a\nmap_Kd quarters.png\n");
    test_path path = write_text("bare.obj", "mtllib bare.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                            "usemtl a\nf 1 2 3\n");
    rk_mesh mesh = load_with_note(path, "no texture coordinates");
    rk_check(texture_of(&mesh, 0) == NULL, "there is no place for it");
    rk_mesh_free(&mesh);
}

/* Otherwise its surface would have the colour of one texel. */
static void a_part_without_texture_coordinates_shows_its_colour_alone(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    write_text("mixed.mtl", "newmtl a\nKd 1 0.5 1\nmap_Kd quarters.png\n");
    rk_mesh mesh = load_with_note(
        write_text("mixed.obj",
                   "mtllib mixed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                   "o with\nusemtl a\nf 1/1 2/2 3/3\no without\nusemtl a\nf 3 2 1\n"),
        "has pictures on parts without texture coordinates, which the picture does not show");
    assert_non_null(texture_of(&mesh, 0));
    rk_check(texture_of(&mesh, 1) == NULL, "there is no place for it");
    for (uint32_t i = 0; i < 2; i++)
        check_point(mesh.materials[mesh.triangle_materials[i]].kd, 1, 0.5f, 1);
    rk_mesh_free(&mesh);
}

/* At most 1024 files are opened, and none of these exists. */
static void more_pictures_than_1024_are_a_note(void **state)
{
    (void)state;
    enum { count = 1030, room = count * 40 + 200 };
    char *obj = malloc(room), *mtl = malloc(room);
    rk_check(obj && mtl, "no memory");
    size_t n = (size_t)sprintf(
        obj, "mtllib many.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n");
    size_t m = 0;
    for (int i = 0; i < count; i++) {
        n += (size_t)sprintf(obj + n, "usemtl m%d\nf 1/1 2/2 3/3\n", i);
        m += (size_t)sprintf(mtl + m, "newmtl m%d\nmap_Kd p%d.png\n", i, i);
    }
    write_text("many.mtl", mtl);
    test_path path = write_text("many.obj", obj);
    free(obj);
    free(mtl);
    rk_mesh mesh = load_with_note(path, "more than 1024 textures");
    rk_check_equal(mesh.material_count, count, "all materials are there");
    rk_mesh_free(&mesh);
}

/* --- opacity from pictures ------------------------------------------------------------------ */

/* Pictures of 2 x 1 texels: green and opaque beside magenta and invisible; a grey one of 1 and .2;
 * one with an alpha channel that is 1; one with .2 and .4. */
static const unsigned char half_png[] = {
    137, 80,  78,  71,  13,  10,  26,  10, 0,  0,   0,   13,  73, 72,  68,  82, 0,  0,
    0,   2,   0,   0,   0,   1,   8,   6,  0,  0,   0,   244, 34, 127, 138, 0,  0,  0,
    15,  73,  68,  65,  84,  120, 218, 99, 96, 248, 207, 240, 31, 136, 24,  0,  17, 247,
    3,   253, 119, 181, 152, 73,  0,   0,  0,  0,   73,  69,  78, 68,  174, 66, 96, 130};
static const unsigned char grey_png[] = {
    137, 80, 78, 71, 13, 10, 26,  10, 0,  0,  0, 13, 73, 72, 68, 82, 0,  0,  0,   2,   0,  0,   0,
    1,   8,  0,  0,  0,  0,  209, 73, 32, 86, 0, 0,  0,  11, 73, 68, 65, 84, 120, 218, 99, 248, 111,
    12,  0,  2,  52, 1,  51, 12,  7,  9,  13, 0, 0,  0,  0,  73, 69, 78, 68, 174, 66,  96, 130};
static const unsigned char opaque_png[] = {
    137, 80,  78,  71,  13, 10,  26,  10, 0,  0,   0,   13,  73, 72,  68,  82, 0,   0,
    0,   2,   0,   0,   0,  1,   8,   6,  0,  0,   0,   244, 34, 127, 138, 0,  0,   0,
    14,  73,  68,  65,  84, 120, 218, 99, 96, 248, 207, 240, 31, 132, 0,   18, 246, 4,
    252, 222, 190, 183, 32, 0,   0,   0,  0,  73,  69,  78,  68, 174, 66,  96, 130};
static const unsigned char faint_png[] = {
    137, 80,  78, 71,  13,  10, 26, 10,  0,   0,  0,   13,  73,  72,  68, 82, 0,  0,  0,
    2,   0,   0,  0,   1,   8,  6,  0,   0,   0,  244, 34,  127, 138, 0,  0,  0,  17, 73,
    68,  65,  84, 120, 218, 99, 96, 248, 207, 96, 252, 159, 225, 127, 26, 0,  14, 97, 3,
    151, 122, 39, 253, 174, 0,  0,  0,   0,   73, 69,  78,  68,  174, 66, 96, 130};

static void write_picture(const char *name, const unsigned char *bytes, size_t size)
{
    test_folder_write(&folder, name, bytes, size, 0600);
}

static void check_alpha(const rk_mesh *mesh, uint32_t triangle, float left, float right)
{
    const rk_texture *alpha = mesh->materials[mesh->triangle_materials[triangle]].alpha_texture;
    rk_check(alpha != NULL, "triangle %u has no opacity", triangle);
    check_texel(alpha, 0.25f, 0.5f, rk_vec(left, left, left));
    check_texel(alpha, 0.75f, 0.5f, rk_vec(right, right, right));
}

static void an_alpha_channel_or_map_d_is_the_opacity(void **state)
{
    (void)state;
    write_picture("half.png", half_png, sizeof half_png);
    write_picture("grey.png", grey_png, sizeof grey_png);
    write_picture("opaque.png", opaque_png, sizeof opaque_png);
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd half.png\n"
                                           "newmtl b\nmap_Kd quarters.png\nmap_d grey.png\n"
                                           "newmtl c\nmap_Kd opaque.png\n"
                                           "newmtl d\nd 0.5\nmap_d half.png\n",
                                           "abcd"));
    check_alpha(&mesh, 0, 1, 0);
    check_texel(texture_of(&mesh, 0), 0.25f, 0.5f, rk_vec(0, 1, 0));
    check_alpha(&mesh, 2, 1, 0.2f);
    check_quarters(texture_of(&mesh, 2));
    const rk_material *c = &mesh.materials[mesh.triangle_materials[4]];
    rk_check(c->kd_texture && !c->alpha_texture, "an opaque picture costs nothing per ray");
    check_alpha(&mesh, 6, 1, 0);
    rk_check_close(mesh.materials[mesh.triangle_materials[6]].alpha, 0.5, 0, "d, times map_d");
    rk_mesh_free(&mesh);
}

/* FORM LWO2: a triangle whose colour is half.png. Its alpha lets the surface's colour show, and
 * cuts nothing out. */
static const char lwo_file[] =
    "FORM\000\000\001\036LWO2"
    "TAGS\000\000\000\002a\000"
    "LAYR\000\000\000\022\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
    "\000\000"
    "PNTS\000\000\000$\000\000\000\000\000\000\000\000\000\000\000\000?\200\000\000\000"
    "\000\000\000\000\000\000\000\000\000\000\000?\200\000\000\000\000\000\000"
    "VMAP\000\000\000(TXUV\000\002uv\000\000\000\000\000\000\000\000\000\000\000\000\000"
    "\001?\200\000\000\000\000\000\000\000\002\000\000\000\000?\200\000\000"
    "POLS\000\000\000\014FACE\000\003\000\000\000\001\000\002"
    "PTAG\000\000\000\010SURF\000\000\000\000"
    "CLIP\000\000\000\024\000\000\000\001STIL\000\012half.png\000\000"
    "SURF\000\000\000Ra\000\000\000COLR\000\016?\200\000\000?\200\000\000?\200\000\000"
    "\000\000BLOK\0004IMAP\000\024\200\000CHAN\000\004COLRENAB\000\002\000\001PROJ\000"
    "\002\000\005IMAG\000\002\000\001VMAP\000\004uv\000\000";

static void the_alpha_of_a_lightwave_picture_cuts_nothing_out(void **state)
{
    (void)state;
    write_picture("half.png", half_png, sizeof half_png);
    rk_mesh mesh =
        load(test_folder_write(&folder, "half.lwo", lwo_file, sizeof lwo_file - 1, 0600));
    const rk_material *a = &mesh.materials[mesh.triangle_materials[0]];
    rk_check(a->kd_texture && !a->alpha_texture, "its colour alone");
    rk_mesh_free(&mesh);
}

/* Green beside magenta, which is transparent if the file has the control block. */
static void the_transparent_colour_of_a_gif_is_its_opacity(void **state)
{
    (void)state;
    static const char head[] = "GIF89a\2\0\1\0\200\0\0\0\377\0\377\0\377";
    static const char block[] = "\41\371\4\1\0\0\1\0";
    static const char rest[] = ",\0\0\0\0\2\0\1\0\0\2\2\104\12\0;";
    for (int is_clear = 0; is_clear < 2; is_clear++) {
        char bytes[60];
        const size_t begin = sizeof head - 1, size = is_clear ? sizeof block - 1 : 0;
        memcpy(bytes, head, begin);
        memcpy(bytes + begin, block, size);
        memcpy(bytes + begin + size, rest, sizeof rest - 1);
        test_folder_write(&folder, "two.gif", bytes, begin + size + sizeof rest - 1, 0600);
        rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd two.gif\n", "a"));
        check_texel(texture_of(&mesh, 0), 0.25f, 0.5f, rk_vec(0, 1, 0));
        if (is_clear)
            check_alpha(&mesh, 0, 1, 0);
        else
            rk_check(!mesh.materials[0].alpha_texture, "a GIF without it is opaque");
        rk_mesh_free(&mesh);
    }
}

/* Cut at one half, nothing of it would be left. */
static void a_picture_that_is_faint_all_over_is_not_cut_out(void **state)
{
    (void)state;
    write_picture("faint.png", faint_png, sizeof faint_png);
    rk_mesh mesh = load(write_textured_obj("newmtl a\nmap_Kd faint.png\n", "a"));
    rk_check(!mesh.materials[0].alpha_texture, "its opacity is that of the material");
    rk_check_close(mesh.materials[0].alpha, 0.3, 1e-7, "the mean of .2 and .4, rounded to float");
    rk_mesh_free(&mesh);
}

/* The seed with a member of its material. */
static rk_mesh load_gltf_with_mode(const char *mode)
{
    mesh_seed seed = {0}, changed = {0};
    write_picture("half.png", half_png, sizeof half_png);
    seed_append_textured_gltf(&seed, "\"uri\":\"half.png\"", "");
    seed.bytes[seed.size] = '\0';
    char *place = strstr((char *)seed.bytes, "\"pbrMetallicRoughness\"");
    assert_non_null(place);
    seed_append(&changed, seed.bytes, (size_t)(place - (char *)seed.bytes));
    seed_append_text(&changed, mode);
    seed_append_text(&changed, place);
    return load(test_folder_write(&folder, "mode.gltf", changed.bytes, changed.size, 0600));
}

static void gltf_says_by_its_mode_whether_alpha_cuts_out(void **state)
{
    (void)state;
    rk_mesh mesh = load_gltf_with_mode("");
    rk_check(!mesh.materials[0].alpha_texture, "OPAQUE, the default, ignores alpha");
    rk_mesh_free(&mesh);
    mesh = load_gltf_with_mode("\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25,");
    check_alpha(&mesh, 0, 1, 0);
    rk_check_close(mesh.materials[0].alpha_cutoff, 0.25, 0, "as written");
    rk_mesh_free(&mesh);
    mesh = load_gltf_with_mode("\"alphaMode\":\"MASK\",");
    rk_check_close(mesh.materials[0].alpha_cutoff, 0.5, 0, "the default");
    rk_mesh_free(&mesh);
    mesh = load_gltf_with_mode("\"alphaMode\":\"BLEND\",");
    check_alpha(&mesh, 0, 1, 0);
    rk_check_close(mesh.materials[0].alpha_cutoff, 0, 0, "transparency, with --transparency");
    rk_mesh_free(&mesh);
}

/* --- as people have them -------------------------------------------------------------------- */

static void a_bad_face_costs_itself(void **state)
{
    (void)state;
#define CORNERS "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    rk_mesh mesh =
        load_with_note(write_text("short.obj", CORNERS "f 1 2\nf 1 2 3\nf 3\n"),
                       "2 faces of fewer than three corners are left out (first in line 4)");
    rk_check_equal(mesh.triangle_count, 1, "the good face");
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_text("lacking.obj",
                                     CORNERS "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/2/1\n"
                                             "f 1/1/1 2/1/1 3/1/-2\nf 1/1/1 2/1/1 3/1/1\n"),
                          "2 faces use texture coordinates or normals that are not there");
    rk_check_equal(mesh.triangle_count, 3, "all are drawn");
    rk_mesh_free(&mesh);
    mesh = load_with_note(write_text("nan.obj", CORNERS "vn nan nan nan\nf 1//1 2//1 3//1\n"),
                          "1 texture coordinates or normals are not finite numbers");
    check_point(mesh.normals[0], 0, 0, 1);
    rk_mesh_free(&mesh);
    mesh = load(write_text("later.obj", "f 1/1 2/1 3/1\n" CORNERS "vt 0 0\n"));
    assert_non_null(mesh.texcoords);
    rk_mesh_free(&mesh);
#undef CORNERS
}

/* The same bump near the origin and 5,000,000 away: Assimp's single precision keeps half a unit
 * there. The first point is the new origin. */
static void check_far(const char *name, const char *format)
{
    char text[900];
    snprintf(text, sizeof text, format, 4500000.25, 5400000.5, 100.0, 4500001.25, 5400000.5,
             100.125, 4500000.25, 5400001.625, 100.25);
    rk_mesh mesh = load(write_text(name, text));
    check_point(corner(&mesh, 0, 0), 0, 0, 0);
    check_point(corner(&mesh, 0, 1), 1, 0, 0.125f);
    check_point(corner(&mesh, 0, 2), 0, 1.125f, 0.25f);
    rk_mesh_free(&mesh);
}

static void details_far_from_the_origin_survive(void **state)
{
    (void)state;
    check_far("far.obj", "v %.4f %.4f %.4f\nv %.4f %.4f %.4f\nv %.4f %.4f %.4f\nf 1 2 3\n");
    check_far("far.off", "OFF\n3 1 0\n%.4f %.4f %.4f\n%.4f %.4f %.4f\n%.4f %.4f %.4f\n3 0 1 2\n");
#define PLY                                                                                        \
    "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"                  \
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    check_far("far.ply", "ply\nformat ascii 1.0\n" PLY
                         "%.4f %.4f %.4f\n%.4f %.4f %.4f\n%.4f %.4f %.4f\n3 0 1 2\n");
    mesh_seed seed = {.name = "far_binary.ply"};
    const double at[9] = {4500000.25, 5400000.5,  100,         4500001.25, 5400000.5,
                          100.125,    4500000.25, 5400001.625, 100.25};
    seed_append_text(&seed, "ply\nformat binary_little_endian 1.0\n" PLY);
    for (int i = 0; i < 9; i++) {
        uint64_t bits;
        memcpy(&bits, &at[i], sizeof bits);
        seed_append_word(&seed, (uint32_t)bits);
        seed_append_word(&seed, (uint32_t)(bits >> 32));
    }
    seed_append(&seed, "\3\0\0\0\0\1\0\0\0\2\0\0", 13);
    rk_mesh mesh = load(test_folder_write(&folder, seed.name, seed.bytes, seed.size, 0600));
    check_point(corner(&mesh, 0, 2), 0, 1.125f, 0.25f);
    rk_mesh_free(&mesh);
#undef PLY
    char stl[600];
    snprintf(stl, sizeof stl,
             "solid a\nfacet normal 0 0 1\nouter loop\nvertex 4500000 5400000 0\n"
             "vertex 4500001 5400000 0\nvertex 4500000 5400001 0\nendloop\nendfacet\nendsolid a\n");
    mesh = load_with_note(write_text("far.stl", stl), "away from the origin");
    rk_mesh_free(&mesh);
}

static rk_vec3 first_kd(const char *mtllib)
{
    char text[400];
    snprintf(text, sizeof text, "mtllib %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl b\nf 1 2 3\n",
             mtllib);
    rk_mesh mesh = load(write_text("named.obj", text));
    rk_vec3 kd = mesh.materials[0].kd;
    rk_mesh_free(&mesh);
    return kd;
}

static void materials_are_found_as_people_name_them(void **state)
{
    (void)state;
    write_text("one.mtl", "newmtl a\nKd 1 0 0\n");
    write_text("Two.mtl", "newmtl b\nKd 0 0 1\n");
    mkdir(test_folder_path(&folder, "mats").text, 0700);
    write_text("mats/in folder.mtl", "newmtl b\nKd 0 0 1\n");
    static const char *const lines[] = {
        "one.mtl Two.mtl",        "one.mtl two.MTL",    "\"Two.mtl\"", "mats\\in folder.mtl",
        "\"mats/in folder.mtl\"", "Mats/In Folder.mtl", "./Two.mtl",   "one.mtl\nmtllib Two.mtl"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        rk_vec3 kd = first_kd(lines[i]);
        rk_check(kd.x == 0 && kd.z == 1, "mtllib %s: got (%g, %g, %g), want blue", lines[i],
                 (double)kd.x, (double)kd.y, (double)kd.z);
    }
    rk_mesh mesh = load_with_note(
        write_text("half.obj", "mtllib Two.mtl gone.mtl\nv 0 0 0\nv 1 0 0\n"
                               "v 0 1 0\nusemtl b\nf 1 2 3\n"),
        ":1: the material file gone.mtl is missing: surfaces of its materials are grey");
    rk_check_close(mesh.materials[0].kd.z, 1, 0, "the other is read");
    rk_mesh_free(&mesh);
}

static void pictures_are_found_beside_their_material_file(void **state)
{
    (void)state;
    mkdir(test_folder_path(&folder, "mats").text, 0700);
    write_quarters(&folder, "mats/Beside.png");
    static const char *const names[] = {"Beside.png", "beside.PNG", "C:\\work\\Beside.png"};
    for (int i = 0; i < 3; i++) {
        char mtl[100];
        snprintf(mtl, sizeof mtl, "newmtl a\nmap_Kd %s\n", names[i]);
        write_text("mats/beside.mtl", mtl);
        rk_mesh mesh =
            load(write_text("beside.obj", "mtllib mats/beside.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                          "vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"));
        rk_check(texture_of(&mesh, 0) != NULL, "map_Kd %s is not found", names[i]);
        rk_mesh_free(&mesh);
    }
}

static void line_ends_of_old_macintoshs_are_read_or_told(void **state)
{
    (void)state;
    check_refused("mac.off", "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r", ": ", "line feeds");
    rk_mesh mesh = load(write_text("mac.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r"));
    rk_check_equal(mesh.triangle_count, 1, "the one face");
    rk_mesh_free(&mesh);
}

/* --- moved or left out ------------------------------------------------------------------------ */

static void check_texcoord(const rk_mesh *mesh, rk_vec3 at, double u, double v)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 p = mesh->positions[i];
        if (!(p.x == at.x && p.y == at.y))
            continue;
        rk_check_close(mesh->texcoords[i].x, u, 2e-6, "float's digits in the file");
        rk_check_close(mesh->texcoords[i].y, v, 2e-6, "float's digits in the file");
    }
}

static void an_mtl_tiles_and_moves_its_picture(void **state)
{
    (void)state;
    write_quarters(&folder, "quarters.png");
    rk_mesh mesh = load(write_textured_obj(
        "newmtl a\nmap_Kd -s 4 2 1 -o 0.5 -0.25 0 -clamp off quarters.png\n", "a"));
    check_texcoord(&mesh, rk_vec(0, 0, 0), 4 * 0.25 + 0.5, 2 * 0.25 - 0.25);
    check_texcoord(&mesh, rk_vec(1, 1, 0), 4 * 0.75 + 0.5, 2 * 0.75 - 0.25);
    rk_mesh_free(&mesh);
}

/* By the extension: scaled, turned, moved, in coordinates whose v goes down; a turn of a quarter
 * takes u from v. */
static void a_gltf_moves_its_picture_by_the_extension(void **state)
{
    (void)state;
    mesh_seed seed = {0}, changed = {0};
    seed_append_textured_gltf(&seed, seed_picture, "");
    seed.bytes[seed.size] = '\0';
    char *place = strstr((char *)seed.bytes, "{\"index\":0,\"texCoord\":1}");
    assert_non_null(place);
    seed_append_text(&changed, "{\"extensionsUsed\":[\"KHR_texture_transform\"],");
    seed_append(&changed, seed.bytes + 1, (size_t)(place - (char *)seed.bytes) - 1);
    seed_append_text(&changed,
                     "{\"index\":0,\"texCoord\":1,\"extensions\":{\"KHR_texture_transform\":{"
                     "\"offset\":[0.125,0.5],\"rotation\":1.5707963,\"scale\":[2,4]}}}");
    seed_append_text(&changed, strchr(place, '}') + 1);
    rk_mesh mesh =
        load(test_folder_write(&folder, "moved.gltf", changed.bytes, changed.size, 0600));
    for (int x = 0; x < 2; x++)
        for (int y = 0; y < 2; y++) {
            const double u = x ? 0.75 : 0.25, down = y ? 0.25 : 0.75;
            check_texcoord(&mesh, rk_vec((float)x, (float)y, 0), 0.125 + 4 * down,
                           1 - (0.5 - 2 * u));
        }
    rk_mesh_free(&mesh);
}

/* Not by another set, in which it may lie anywhere. */
static void a_gltf_part_without_the_pictures_set_is_plain(void **state)
{
    (void)state;
    mesh_seed seed = {0};
    seed_append_textured_gltf(&seed, seed_picture, "");
    seed.bytes[seed.size] = '\0';
    char *place = strstr((char *)seed.bytes, "\"texCoord\":1}");
    assert_non_null(place);
    place[strlen("\"texCoord\":")] = '3';
    rk_mesh mesh =
        load_with_note(test_folder_write(&folder, "set.gltf", seed.bytes, seed.size, 0600),
                       "pictures on parts without texture coordinates");
    rk_check_equal(mesh.texture_count, 0, "textures");
    rk_mesh_free(&mesh);
}

static void an_mtl_with_tr_1_alone_is_drawn_with_a_note(void **state)
{
    (void)state;
    write_text("tr.mtl",
               "newmtl a\nKd 1 0 0\nTr 1.000000\nnewmtl b\nTr 1\nd 0\nnewmtl c\nd 0\nTr 1\n");
    rk_mesh mesh = load_with_note(
        write_text("tr.obj", "mtllib tr.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"
                             "usemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"),
        "Tr 1 makes a material invisible; it is drawn as opaque");
    const float want[3] = {1, 0, 0};
    for (int i = 0; i < 3; i++)
        rk_check_close(mesh.materials[mesh.triangle_materials[i]].alpha, (double)want[i], 0,
                       "d says what is meant");
    rk_mesh_free(&mesh);
}

static void specular_glossiness_gives_its_diffuse_colour(void **state)
{
    (void)state;
    mesh_seed seed = make_seed(seed_gltf), changed = {0};
    seed.bytes[seed.size] = '\0';
    char *place = strstr((char *)seed.bytes, "{\"pbrMetallicRoughness\"");
    assert_non_null(place);
    seed_append_text(&changed, "{\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"],");
    seed_append(&changed, seed.bytes + 1, (size_t)(place - (char *)seed.bytes) - 1);
    seed_append_text(&changed, "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{"
                               "\"diffuseFactor\":[0,0.25,1,1]}},\"emissiveFactor\":[1,0,0]},");
    seed_append_text(&changed, strstr(place, "},{") + 2);
    rk_mesh mesh =
        load_with_note(test_folder_write(&folder, "gloss.gltf", changed.bytes, changed.size, 0600),
                       "has surfaces that emit light, which the picture does not show");
    check_point(mesh.materials[mesh.triangle_materials[0]].kd, 0, 0.25f, 1);
    rk_mesh_free(&mesh);
}

static void several_notes_are_in_one_line(void **state)
{
    (void)state;
    write_text("notes.mtl", "newmtl a\nKe 1 1 1\nmap_Kd gone.png\nmap_bump b.png\nTr 1\n");
    test_path path = write_text("notes.obj", "mtllib notes.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
                                             "usemtl a\nf 1/1 2/1 3/1\nl 1 2\n");
    rk_mesh mesh = load_with_note(
        path, "has points or lines, bump or normal maps and surfaces that emit light");
    rk_mesh_free(&mesh);
    mesh = load_with_note(path, "; ");
    rk_mesh_free(&mesh);
    mesh = load_with_note(path, "gone.png: No such file");
    rk_mesh_free(&mesh);
}

/* A quadrilateral as two triangles, a third triangle with a corner "nan", and a vertex "inf" that
 * no face uses; in `format` %s stands for the words. */
static void check_unfinite(const char *name, const char *format, const char *nan, const char *inf)
{
    char text[1000];
    snprintf(text, sizeof text, format, nan, inf);
    rk_mesh mesh = load_with_note(write_text(name, text),
                                  "1 face is left out: a corner is not a finite number");
    rk_check_equal(mesh.triangle_count, 2, name);
    for (uint32_t i = 0; i < 2; i++)
        rk_check_close(vector_area(&mesh, i).z, 0.5f, 0, name);
    rk_mesh_free(&mesh);
}

static void faces_with_a_corner_that_is_no_number_are_left_out(void **state)
{
    static const char *const words[][2] = {
        {"nan", "inf"}, {"-NaN", "-Infinity"}, {"nan(ind)", "1e99"}, {"1.#QNAN", "-1.#IND"}};
    static const char *const formats[][2] = {
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 %s 2\nv %s 0 0\n"
                  "f 1 2 3\nf 1 2 5\nf 1 3 4\n"},
        {"a.off", "OFF\n6 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n1 2 %s\n0 %s 0\n"
                  "3 0 1 2\n3 0 1 4\n3 0 2 3\n"},
        {"far.off", "OFF\n6 3 0\n9e5 0 0\n900001 0 0\n900001 1 0\n9e5 1 0\n9e5 2 %s\n0 %s 0\n"
                    "3 0 1 2\n3 0 1 4\n3 0 2 3\n"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty double y\n"
                  "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
                  "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n1 %s 0\n%s 0 0\n"
                  "3 0 1 2\n3 0 1 4\n3 0 2 3\n"}};
    (void)state;
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        for (size_t k = 0; k < sizeof words / sizeof *words; k++)
            check_unfinite(formats[i][0], formats[i][1], words[k][0], words[k][1]);
    mesh_seed seed = make_seed(seed_ply_binary);
    const float nan = NAN;
    memcpy(seed.bytes + seed.size - (60 + 17 + 13) + 16, &nan, sizeof nan);
    check_refused_path(test_folder_write(&folder, "nan.ply", seed.bytes, seed.size, 0600).text,
                       ": ", "each face (2 in all) has a corner that is not a finite number");
    check_refused("all.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ": ",
                  "each face (1 in all) has a corner that is not a finite number");
}

/* MeshLab and CloudCompare write them. */
static void faces_of_a_ply_file_have_colours_of_their_own(void **state)
{
    (void)state;
#define HEADER(type)                                                                               \
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"                \
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"                   \
    "property " type " red\nproperty " type " green\nproperty " type " blue\nend_header\n"         \
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
    static const char *const texts[] = {HEADER("uchar") "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n",
                                        HEADER("float") "3 0 1 2 1 0 0\n3 0 2 3 0 0 1\n",
                                        HEADER("ushort") "3 0 1 2 65535 0 0\n3 0 2 3 0 0 65535\n"};
    for (int i = 0; i < 3; i++) {
        rk_mesh mesh = load(write_text("faces.ply", texts[i]));
        assert_non_null(mesh.colours);
        for (int k = 0; k < 3; k++) {
            check_point(mesh.colours[mesh.triangles[0][k]], 1, 0, 0);
            check_point(mesh.colours[mesh.triangles[1][k]], 0, 0, 1);
        }
        check_point(mesh.materials[0].kd, 1, 1, 1);
        rk_mesh_free(&mesh);
    }
    rk_mesh mesh = load(write_text("dark.ply", HEADER("uchar") "3 0 1 2 1 0 0\n3 0 2 3 0 0 1\n"));
    check_point(mesh.colours[mesh.triangles[1][0]], 0, 0, rk_srgb_decode(1 / 255.0f));
    rk_mesh_free(&mesh);
    mesh = load(write_text("white.ply", /* MeshLab adds white vertices */
                           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                           "property float y\nproperty float z\nproperty uchar red\n"
                           "property uchar green\nproperty uchar blue\nelement face 1\n"
                           "property list uchar int vertex_indices\nproperty uchar red\n"
                           "property uchar green\nproperty uchar blue\nend_header\n"
                           "0 0 0 255 255 255\n1 0 0 255 255 255\n1 1 0 255 255 255\n"
                           "3 0 1 2 0 255 0\n"));
    assert_non_null(mesh.colours);
    check_point(mesh.colours[mesh.triangles[0][0]], 0, 1, 0);
    rk_mesh_free(&mesh);
#undef HEADER
}

/* --- refusals ------------------------------------------------------------------------------- */

static void obj_mistakes_are_found_with_their_line(void **state)
{
    (void)state;
#define CORNERS "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    check_refused("a.obj", "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ":1: ", "three numbers");
    check_refused("a.obj", "v 0 0 0\n\n# c\nv 1 none 0\nv 0 1 0\nf 1 2 3\n", ":4: ", "numbers");
    check_refused("a.obj", "v 0 0 0\nv 1 1e999x 0\nv 0 1 0\nf 1 2 3\n", ":2: ", "numbers");
    check_refused("a.obj", "v 0 0 0\nv 1 0,5 0\nv 0 1 0\nf 1 2 3\n", ":2: ", "numbers");
    check_refused("a.obj", CORNERS "f 1 2\n", ":4: ", "2 corners");
    check_refused("a.obj", CORNERS "f 1 2 0\n", ":4: ", "index 0");
    check_refused("a.obj", CORNERS "f 1 2 x\n", ":4: ", "not a number");
    check_refused("a.obj", CORNERS "f 1 2 4\n", ":4: ", "index 4");
    check_refused("a.obj", CORNERS "f 1 2 4294967297\n", ":4: ", "index 4294967297");
    check_refused("a.obj", CORNERS "f 1 2 99999999999999999999\n", ":4: ", "not a number");
    check_refused("a.obj", CORNERS "f -1 -2 -4\n", ":4: ", "index -4");
    check_refused("a.obj", CORNERS "f 1/1/1/1 2 3\n", ":4: ", "corner");
    check_refused("a.obj", CORNERS, ": ", "no face");
    check_refused("a.obj", "All that glitters\nis not gold\n", ": ", "no face");
#undef CORNERS
}

static void ply_mistakes_are_found_with_their_place(void **state)
{
    (void)state;
#define HEADER(vertices, faces)                                                                    \
    "ply\nformat ascii 1.0\nelement vertex " vertices "\nproperty float x\nproperty float y\n"     \
    "property float z\nelement face " faces                                                        \
    "\nproperty list uchar int vertex_indices\nend_header\n"
    check_refused("a.ply", HEADER("3", "1") "0 0 0\n1 none 0\n0 1 0\n3 0 1 2\n",
                  ":11: ", "is missing");
    check_refused("a.ply", HEADER("3", "1") "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":13: ", "vertex 3");
    check_refused("a.ply", HEADER("3", "1") "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
                  ":13: ", "vertex -1");
    check_refused("a.ply", HEADER("3", "1") "0 0 0\n1 0 0\n0 1 0\n3 0 1\n", ":13: ", "missing");
    check_refused("a.ply", HEADER("3", "1") "0 0 0\n1 0 0\n", ":3: ", "ends in row 3");
    check_refused("a.ply", HEADER("3", "4000000000") "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                  ":7: ", "4000000000 rows of face");
    check_refused("a.ply", HEADER("9999999999", "1") "0 0 0\n", ":3: ", "32-bit");
    check_refused("a.ply", HEADER("3", "0") "0 0 0\n1 0 0\n0 1 0\n", ": ", "no triangles");
    check_refused("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                  "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                  "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n",
                  ":7: ", "triangle strips");
    check_refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n",
                  ":4: ", "within the header");
    check_refused("a.ply", "solid cube\n", ":1: ", "begins with the line ply");
#undef HEADER
}

static void binary_ply_mistakes_are_found_with_their_place(void **state)
{
    (void)state;
    mesh_seed seed = make_seed(seed_ply_binary);
    size_t body = seed.size - (60 + 17 + 13);
    mesh_seed damaged = seed;
    damaged.bytes[body + 60 + 17 + 1] = 200;
    check_refused_path(
        test_folder_write(&folder, "index.ply", damaged.bytes, damaged.size, 0600).text, ": ",
        "face 1 uses vertex 200");
    for (size_t cut = 1; cut <= 60 + 17 + 13; cut += 8)
        check_refused_path(
            test_folder_write(&folder, "truncated.ply", seed.bytes, seed.size - cut, 0600).text,
            cut <= 30 ? ":8: " : ":4: ", "the file ends in row");
}

static void off_mistakes_are_found_with_their_line(void **state)
{
    (void)state;
    check_refused("a.off", "OFF\n3 1 0\n0 0 0\n1 0 info\n0 1 0\n3 0 1 2\n",
                  ":4: ", "three numbers");
    check_refused("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":6: ", "vertex 3");
    check_refused("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", ":6: ", "missing");
    check_refused("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", ":2: ", "after 4 of");
    check_refused("a.off", "OFF\n4000000000 1 0\n0 0 0\n", ":2: ", "after 1 of");
    check_refused("a.off", "OFF\nmany\n", ":2: ", "counts");
    check_refused("a.off", "solid 3 1 0\n0 0 0\n", ":1: ", "begins with the word OFF");
}

static void gltf_mistakes_are_refused(void **state)
{
    (void)state;
    check_refused("a.gltf", "{\"asset\":{\"version\":\"2.0\"}}\n", ": ", "");
    check_refused("a.gltf", "{\"asset\":{\"version\":\n", ": ", "");
    check_refused("a.gltf", "not JSON at all\n", ": ", "");
    mesh_seed seed = make_seed(seed_gltf);
    seed.bytes[seed.size] = '\0';
    char *count = strstr((char *)seed.bytes, "\"count\":6");
    assert_non_null(count);
    count[8] = '9'; /* the buffer's view holds no ninth: the next accessor's bytes end with it */
    char *length = strstr((char *)seed.bytes, "\"byteLength\":96");
    assert_non_null(length);
    memcpy(length, "\"byteLength\":10", 15);
    check_refused("short.gltf", (char *)seed.bytes, ": ", "");
}

static void files_that_are_not_meshes_are_refused(void **state)
{
    (void)state;
    check_refused_path(test_folder_path(&folder, "nowhere.obj").text, ": ", "No such file");
    check_refused("empty.obj", "", ": ", "is empty");
    check_refused("empty.ply", "", ": ", "is empty");
    check_refused("a.txt", "v 0 0 0\n", ": ", "has a format that Assimp does not read");
    test_path inner = test_folder_path(&folder, "folder.obj");
    mkdir(inner.text, 0700);
    check_refused_path(inner.text, ": ", "is a folder");
    test_path pipe = test_folder_path(&folder, "pipe.obj");
    rk_check_equal(mkfifo(pipe.text, 0600), 0, "the test needs a pipe");
    check_refused_path(pipe.text, ": ", "not a regular file");
    if (geteuid() != 0) /* root reads all */
        check_refused_path(test_folder_write(&folder, "secret.obj", "v", 1, 0000).text, ": ",
                           "Permission denied");
}

static void a_file_of_absurd_size_is_refused_unread(void **state)
{
    (void)state;
    test_path path = write_text("huge.obj", "v 0 0 0\n");
    rk_check_equal(truncate(path.text, (off_t)1 << 40), 0, "a hole of a terabyte takes no disk");
    check_refused_path(path.text, ": ", "larger than 4 GB");
}

/* --- cost ----------------------------------------------------------------------------------- */

static bool read_and_free(const char *path, rk_error *error)
{
    rk_mesh mesh;
    bool ok = rk_mesh_file_read(&mesh, path, error);
    rk_mesh_free(&mesh);
    return ok;
}

/* A file of kilobytes may take 256 MB, as the helper allows itself, and the helper starts in 0.1 s.
 */
static void check_cheap(test_path path, const char *reason)
{
    test_cost cost = test_cost_of(read_and_free, path.text);
    test_check_cost(path.text, &cost, 300, 2);
    if (!reason) {
        rk_check_ok(cost.ok, cost.error);
        return;
    }
    rk_check(!cost.ok, "%s was accepted", path.text);
    rk_check_error_names(cost.error, path.text);
    rk_check_error_names(cost.error, reason);
}

/* All its elements are zero but one, so it needs no buffer. */
static test_path write_sparse(const char *count)
{
    char text[1000];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
             "{\"POSITION\":0}}]}],\"accessors\":[{\"componentType\":5126,\"count\":%s,"
             "\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,"
             "\"componentType\":5125},\"values\":{\"bufferView\":1}}}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":4},"
             "{\"buffer\":0,\"byteOffset\":4,\"byteLength\":12}],\"buffers\":[{\"byteLength\":16,"
             "\"uri\":\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAA==\"}]}",
             count);
    return write_text("sparse.gltf", text);
}

static void a_small_gltf_cannot_claim_gigabytes(void **state)
{
    (void)state;
    check_cheap(write_sparse("3"), NULL);
#ifndef RK_SANITIZED /* they lift the limit */
    check_cheap(write_sparse("10000000"), "");
    check_cheap(write_sparse("300000000"), "of memory, which is too much for a file of");
#endif
}

static void a_glb_that_is_shorter_than_it_says_is_refused(void **state)
{
    (void)state;
    char lie[] = "glTF\2\0\0\0\26\0\0\0\xf0\xff\xff\xffJSON{}";
    check_cheap(test_folder_write(&folder, "lie.glb", lie, 22, 0600),
                "claims 4294967280 bytes, but only 2 follow");
    lie[12] = 2, lie[13] = lie[14] = lie[15] = 0, lie[8] = 23;
    check_cheap(test_folder_write(&folder, "lie.glb", lie, 22, 0600),
                "claims 23 bytes, but has 22");
    check_cheap(test_folder_write(&folder, "lie.glb", lie, 12, 0600), "not a binary glTF file");
}

/* Each level takes some of the stack. */
static void deep_nesting_is_refused_in_words(void **state)
{
    (void)state;
    enum { levels = 200000, room = 2 * levels + 100 };
    char *text = malloc(room);
    assert_non_null(text);
    size_t n = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"extras\":");
    memset(text + n, '[', levels);
    memset(text + n + levels, ']', levels);
    memcpy(text + n + 2 * levels, "}", 2);
    test_path path = write_text("nested.gltf", text);
    free(text);
    check_cheap(path, "nested too deeply");
}

/* Assimp's time and memory grow with the square of their number; files of a few thousand exist. */
static test_path write_materials(int count)
{
    test_path path = test_folder_path(&folder, "parts.obj");
    FILE *obj = fopen(path.text, "w"),
         *mtl = fopen(test_folder_path(&folder, "parts.mtl").text, "w");
    rk_check(obj && mtl, "files can be written");
    fputs("mtllib parts.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", obj);
    for (int i = 0; i < count; i++) {
        fprintf(obj, "g g%d\nusemtl m%d\nf 1 2 3\n", i, i);
        fprintf(mtl, "newmtl m%d\n", i);
    }
    fclose(obj);
    fclose(mtl);
    return path;
}

static void many_materials_are_read_or_stopped_with_a_reason(void **state)
{
    (void)state;
    test_cost cost = test_cost_of(read_and_free, write_materials(2000).text);
    rk_check_ok(cost.ok, cost.error);
#ifndef RK_SANITIZED
    test_path path = write_materials(40000);
    cost = test_cost_of(read_and_free, path.text);
    rk_check(!cost.ok, "40000 parts take gigabytes");
    rk_check_error_names(cost.error, "it has too many parts or materials (40000 usemtl lines)");
    test_check_cost(path.text, &cost, 500, 25);
#endif
}

/* --- answers of a helper -------------------------------------------------------------------- */

typedef struct triangle_stream {
    rk_mesh_stream_header header;
    float positions[3][3];
    uint32_t triangle[3];
    /* The triangle's material, the material, a texture without a picture and its name "gone". */
    unsigned char rest[2 + sizeof(rk_mesh_stream_material) + sizeof(rk_mesh_stream_texture) + 4];
} triangle_stream;

enum { triangle_stream_size = 40 + 36 + 12 + 2 + 44 + 12 + 4 };

static void set_texture(triangle_stream *s, uint32_t of_material, rk_mesh_stream_texture texture)
{
    rk_mesh_stream_material material = {.kd = {1, 1, 1}, .alpha = 1, .texture = of_material};
    memcpy(s->rest + 2, &material, sizeof material);
    memcpy(s->rest + 2 + sizeof material, &texture, sizeof texture);
    memcpy(s->rest + 2 + sizeof material + sizeof texture, "gone", 4);
}

static triangle_stream make_stream(void)
{
    triangle_stream s = {.header = {.magic = RK_MESH_STREAM_MAGIC,
                                    .version = RK_MESH_STREAM_VERSION,
                                    .vertex_count = 3,
                                    .triangle_count = 1,
                                    .material_count = 1,
                                    .texture_count = 1,
                                    .texture_bytes = 4},
                         .positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                         .triangle = {0, 1, 2}};
    set_texture(&s, 1, (rk_mesh_stream_texture){.name_size = 4});
    return s;
}

/* Passes these bytes to rk_mesh_file_read, written by a shell script in the helper's place. */
static bool read_stream(const triangle_stream *stream, size_t size, rk_error *error)
{
    const char *before = getenv("RAYKIT_HELPERS");
    char *saved = before ? strdup(before) : NULL;
    test_folder_write(&folder, "answer", stream, size, 0600);
    char script[700];
    int length = snprintf(script, sizeof script, "#!/bin/sh\nexec cat '%s/answer'\n", folder.path);
    test_folder_write(&folder, "raykit-mesh", script, (size_t)length, 0700);
    setenv("RAYKIT_HELPERS", folder.path, 1);
    rk_mesh mesh;
    bool ok = rk_mesh_file_read(&mesh, "fake.obj", error);
    rk_mesh_free(&mesh);
    if (saved)
        setenv("RAYKIT_HELPERS", saved, 1);
    else
        unsetenv("RAYKIT_HELPERS");
    free(saved);
    return ok;
}

static void check_stream_refused(const triangle_stream *stream, size_t size, const char *what)
{
    rk_error error;
    rk_check(!read_stream(stream, size, &error), "accepted, although: %s", what);
    rk_check_error_names(error, "fake.obj: ");
    rk_check_error_names(error, what);
}

static void an_answer_is_accepted_only_if_consistent(void **state)
{
    (void)state;
    rk_error error;
    triangle_stream good = make_stream();
    rk_check_ok(read_stream(&good, triangle_stream_size, &error), error);
    check_stream_refused(&good, 0, "only 0 bytes");
    check_stream_refused(&good, 39, "only 39 bytes");
    check_stream_refused(&good, triangle_stream_size - 1, "149 bytes, but its counts require 150");
    triangle_stream bad = good;
    bad.header.magic[0] = 'X';
    check_stream_refused(&bad, triangle_stream_size, "another version's format");
    bad = good;
    bad.header.version = RK_MESH_STREAM_VERSION - 1;
    check_stream_refused(&bad, triangle_stream_size, "another version's format");
    bad = good;
    bad.header.up = 4;
    check_stream_refused(&bad, triangle_stream_size, "up axis of number 4");
    bad = good;
    bad.header.vertex_count = UINT32_MAX;
    check_stream_refused(&bad, triangle_stream_size, "but its counts require");
    bad = good;
    bad.triangle[2] = 3;
    check_stream_refused(&bad, triangle_stream_size, "triangle 0 uses vertex 3");
    bad = good;
    bad.positions[1][1] = NAN;
    check_stream_refused(&bad, triangle_stream_size, "vertex 1 is not a finite point");
    bad = good;
    bad.header.material_count = 65536;
    check_stream_refused(&bad, triangle_stream_size, "uses 65536 materials, more than 65535");
}

static void textures_are_accepted_only_if_consistent(void **state)
{
    (void)state;
    const triangle_stream good = make_stream();
    triangle_stream bad = good;
    set_texture(&bad, 2, (rk_mesh_stream_texture){.name_size = 4});
    check_stream_refused(&bad, triangle_stream_size, "material 0 uses texture 2");
    set_texture(&bad, 1, (rk_mesh_stream_texture){.name_size = 5});
    check_stream_refused(&bad, triangle_stream_size,
                         "4 bytes of textures, but their sizes require 5");
    set_texture(&bad, 1, (rk_mesh_stream_texture){.name_size = 4, .data_size = UINT32_MAX});
    check_stream_refused(&bad, triangle_stream_size, "but their sizes require 4294967299");
    bad = good;
    bad.header.texture_bytes = UINT32_MAX;
    check_stream_refused(&bad, triangle_stream_size, "but its counts require");
    bad = good;
    bad.header.texture_count = 1025;
    check_stream_refused(&bad, triangle_stream_size, "sent 1025 textures, more than 1024");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_format_gives_the_same_square_and_triangle),
    cmocka_unit_test(the_order_of_bytes_in_a_ply_does_not_matter),
    cmocka_unit_test(obj_brings_materials_unit_normals_and_texture_coordinates),
    cmocka_unit_test(gltf_parts_stand_where_their_nodes_put_them),
    cmocka_unit_test(a_part_without_normals_takes_its_faces_own),
    cmocka_unit_test(a_zero_normal_is_replaced_by_the_faces),
    cmocka_unit_test(a_polygon_that_is_not_convex_is_triangulated_inside),
    cmocka_unit_test(a_polygon_that_would_take_minutes_is_refused),
    cmocka_unit_test(a_byte_order_mark_is_no_part_of_the_text),
    cmocka_unit_test(a_pipe_as_material_file_is_as_good_as_none),
    cmocka_unit_test(points_and_lines_are_dropped),
    cmocka_unit_test(windows_line_ends_and_long_lines_are_fine),
    cmocka_unit_test(a_missing_mtl_is_a_note_not_an_error),
    cmocka_unit_test(colours_of_vertices_are_srgb_in_scans),
    cmocka_unit_test(colours_of_vertices_are_linear_in_gltf_and_multiply_the_base_colour),
    cmocka_unit_test(faces_of_an_off_file_have_colours_of_their_own),
    cmocka_unit_test(a_file_whose_vertices_are_all_white_has_no_colours),
    cmocka_unit_test(a_scans_picture_is_not_multiplied_by_its_vertices_colours),
    cmocka_unit_test(colours_of_only_some_vertices_are_not_drawn),
    cmocka_unit_test(an_obj_shows_its_picture_upright),
    cmocka_unit_test(a_picture_without_kd_is_not_darkened),
    cmocka_unit_test(a_ply_shows_the_picture_of_its_comment_in_its_own_colours),
    cmocka_unit_test(a_gltf_shows_its_picture_upright_by_the_set_that_it_names),
    cmocka_unit_test(a_gltf_may_hold_its_picture_and_clamp_it),
    cmocka_unit_test(options_and_blanks_around_a_pictures_name_are_not_part_of_it),
    cmocka_unit_test(materials_that_name_the_same_picture_share_it),
    cmocka_unit_test(a_missing_or_damaged_picture_is_a_note_not_an_error),
    cmocka_unit_test(the_pictures_of_a_mesh_start_their_helper_once),
    cmocka_unit_test(pictures_without_texture_coordinates_are_a_note),
    cmocka_unit_test(a_part_without_texture_coordinates_shows_its_colour_alone),
    cmocka_unit_test(more_pictures_than_1024_are_a_note),
    cmocka_unit_test(an_alpha_channel_or_map_d_is_the_opacity),
    cmocka_unit_test(the_alpha_of_a_lightwave_picture_cuts_nothing_out),
    cmocka_unit_test(the_transparent_colour_of_a_gif_is_its_opacity),
    cmocka_unit_test(a_picture_that_is_faint_all_over_is_not_cut_out),
    cmocka_unit_test(gltf_says_by_its_mode_whether_alpha_cuts_out),
    cmocka_unit_test(a_bad_face_costs_itself),
    cmocka_unit_test(details_far_from_the_origin_survive),
    cmocka_unit_test(materials_are_found_as_people_name_them),
    cmocka_unit_test(pictures_are_found_beside_their_material_file),
    cmocka_unit_test(line_ends_of_old_macintoshs_are_read_or_told),
    cmocka_unit_test(an_mtl_tiles_and_moves_its_picture),
    cmocka_unit_test(a_gltf_moves_its_picture_by_the_extension),
    cmocka_unit_test(a_gltf_part_without_the_pictures_set_is_plain),
    cmocka_unit_test(an_mtl_with_tr_1_alone_is_drawn_with_a_note),
    cmocka_unit_test(specular_glossiness_gives_its_diffuse_colour),
    cmocka_unit_test(several_notes_are_in_one_line),
    cmocka_unit_test(faces_with_a_corner_that_is_no_number_are_left_out),
    cmocka_unit_test(faces_of_a_ply_file_have_colours_of_their_own),
    cmocka_unit_test(obj_mistakes_are_found_with_their_line),
    cmocka_unit_test(ply_mistakes_are_found_with_their_place),
    cmocka_unit_test(binary_ply_mistakes_are_found_with_their_place),
    cmocka_unit_test(off_mistakes_are_found_with_their_line),
    cmocka_unit_test(gltf_mistakes_are_refused),
    cmocka_unit_test(files_that_are_not_meshes_are_refused),
    cmocka_unit_test(a_file_of_absurd_size_is_refused_unread),
    cmocka_unit_test(a_small_gltf_cannot_claim_gigabytes),
    cmocka_unit_test(a_glb_that_is_shorter_than_it_says_is_refused),
    cmocka_unit_test(deep_nesting_is_refused_in_words),
    cmocka_unit_test(many_materials_are_read_or_stopped_with_a_reason),
    cmocka_unit_test(an_answer_is_accepted_only_if_consistent),
    cmocka_unit_test(textures_are_accepted_only_if_consistent),
};

RK_SUITE_IN("mesh_file", tests, make_folder, remove_folder)
