/* Mesh files as exporters write them: what a format's manual allows, or what many programs do, and
 * Assimp reads otherwise. */
#include "test_mesh_reading.h"

#include "base/image.h"

/* --- OBJ ------------------------------------------------------------------------------------ */

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

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(numbers_of_an_obj_may_begin_with_their_point),
    cmocka_unit_test(a_vertex_weight_moves_nothing),
    cmocka_unit_test(a_line_that_assimp_does_not_know_costs_no_material),
};

RK_SUITE_IN("mesh_dialects", tests, make_folder, remove_folder)
