/* The worked examples of the chapters: each row of numbers is computed by the kit's units, written
 * as the chapter writes it, and has to stand there. */
#include "test.h"

#include "features/bloom.h"
#include "features/bvh_median.h"
#include "features/glossy_reflection.h"
#include "features/normals.h"
#include "features/parallelogram_light.h"
#include "features/shading.h"
#include "features/transparency.h"

#include <stdarg.h>

static const double pi = 3.14159265358979323846;

/* --- Rows ------------------------------------------------------------------------------------- */

/* A row of a table, in which a minus is as long as a plus, and -0 is 0. */
typedef struct row {
    char text[400];
    size_t length;
} row;

static void put(row *r, const char *text)
{
    int length = snprintf(r->text + r->length, sizeof r->text - r->length, "%s", text);
    r->length += (size_t)length;
    rk_check(r->length < sizeof r->text, "the row is too long: %s", r->text);
}

static void put_number(row *r, double value)
{
    char digits[40];
    snprintf(digits, sizeof digits, "%.4g", fabs(value) < 1e-6 ? 0 : fabs(value));
    put(r, value <= -1e-6 ? "−" : "");
    put(r, digits);
}

/* A letter for each cell: n, a number (double); v, a vector (rk_vec3); s, a text. */
static void put_cells(row *r, const char *kinds, va_list cells)
{
    put(r, "|");
    for (; *kinds; kinds++) {
        put(r, " ");
        if (*kinds == 'n')
            put_number(r, va_arg(cells, double));
        else if (*kinds == 's')
            put(r, va_arg(cells, const char *));
        else {
            rk_vec3 v = va_arg(cells, rk_vec3);
            put(r, "(");
            for (int axis = 0; axis < 3; axis++) {
                put_number(r, (double)rk_axis(v, axis));
                put(r, axis < 2 ? ", " : ")");
            }
        }
        put(r, " |");
    }
}

static char *read_chapter(const char *name)
{
    const char *folder = getenv("RAYKIT_CHAPTERS");
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.md", folder ? folder : "docs", name);
    FILE *file = fopen(path, "rb");
    rk_check(file != NULL, "%s cannot be read: run make check in the build folder", path);
    const size_t room = 1 << 20;
    char *text = malloc(room);
    rk_check(text != NULL, "no memory for %s", path);
    size_t length = fread(text, 1, room - 1, file);
    fclose(file);
    text[length] = 0;
    return text;
}

/* The chapter has a line that begins so. */
static void check_row(const char *chapter, const char *kinds, ...)
{
    row r = {"\n", 1};
    va_list cells;
    va_start(cells, kinds);
    put_cells(&r, kinds, cells);
    va_end(cells);
    char *text = read_chapter(chapter);
    bool is_there = strstr(text, r.text) != NULL;
    free(text);
    rk_check(is_there, "docs/%s.md has no row of a table that begins with what the unit gives: %s",
             chapter, r.text + 1);
}

/* --- Normals ---------------------------------------------------------------------------------- */

static void normals_have_these_colours(void **state)
{
    (void)state;
    const rk_vec3 normals[] = {rk_vec(0, 1, 0), rk_vec(0.6f, -0.8f, 0), rk_vec(0, 0, -1)};
    for (int i = 0; i < 3; i++)
        check_row("00_normals", "vv", normals[i], rk_normals_colour(normals[i]));
}

static void triangles_have_these_normals(void **state)
{
    (void)state;
    const rk_vec3 a = rk_vec(1, 1, 1), b = rk_vec(3, 1, 1), c = rk_vec(1, 4, 1);
    const rk_vec3 e = rk_sub(b, a), f = rk_sub(c, a);
    check_row("00_normals", "svvvv", "a, b, c", e, f, rk_cross(e, f),
              rk_normals_of_triangle(a, b, c));
    check_row("00_normals", "svvvv", "a, c, b", f, e, rk_cross(f, e),
              rk_normals_of_triangle(a, c, b));
}

/* --- The tree --------------------------------------------------------------------------------- */

/* What a builder is asked: a node for each call of its split. */
typedef struct splits {
    const rk_bvh *bvh;
    uint32_t calls;
    uint32_t node[8], begin[8], count[8], left[8];
} splits;

static uint32_t halve(void *builder, uint32_t begin, uint32_t count, uint32_t depth_left,
                      rk_box *box)
{
    (void)depth_left;
    splits *s = builder;
    uint32_t i = s->calls++, left = count <= RK_BVH_LEAF_TARGET ? 0 : count - count / 2;
    *box = rk_box_empty();
    s->node[i] = (uint32_t)((const rk_bvh_node *)box - s->bvh->nodes);
    s->begin[i] = begin;
    s->count[i] = count;
    s->left[i] = left;
    return left;
}

static void nine_triangles_become_five_nodes(void **state)
{
    (void)state;
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_init(&bvh, 9, 9, &error), error);
    splits s = {.bvh = &bvh};
    rk_bvh_build_nodes(&bvh, halve, &s);
    rk_check_equal(s.calls, 5, "the calls of split");
    rk_check_equal(bvh.node_count, 6, "the nodes in use, with node 1, which has no use");
    for (uint32_t i = 0; i < s.calls; i++) {
        const rk_bvh_node *node = &bvh.nodes[s.node[i]];
        check_row("01_bvh_median", "nnnnnn", (double)s.node[i], (double)s.begin[i],
                  (double)s.count[i], (double)s.left[i], (double)node->first, (double)node->count);
    }
    rk_bvh_free(&bvh);
}

/* --- Shading ---------------------------------------------------------------------------------- */

static double highlight(rk_shading_model model, bool normalized, float s, rk_vec3 l, rk_vec3 v)
{
    const rk_shading shading = {.model = model, .normalized = normalized};
    rk_vec3 white = rk_vec(1, 1, 1), black = rk_vec(0, 0, 0);
    return (double)rk_shade(&shading, black, white, s, rk_vec(0, 1, 0), l, v, white).x;
}

static void highlights_are_as_bright_as_told(void **state)
{
    (void)state;
    const rk_vec3 l = rk_vec(0.6f, 0.8f, 0), v = rk_vec(0, 0.8f, 0.6f), n = rk_vec(0, 1, 0);
    const rk_vec3 r = rk_vec(-0.6f, 0.8f, 0), h = rk_normalize(rk_add(l, v));
    check_row("03_shading", "svnnn", "Phong, $\\mathbf{r}$", r, (double)rk_dot(r, v),
              highlight(RK_SHADING_PHONG, false, 10, l, v),
              highlight(RK_SHADING_PHONG, true, 50, n, n));
    check_row("03_shading", "svnnn", "Blinn-Phong, $\\mathbf{h}$", h, (double)rk_dot(n, h),
              highlight(RK_SHADING_BLINN_PHONG, false, 10, l, v),
              highlight(RK_SHADING_BLINN_PHONG, true, 50, n, n));
}

/* --- Area lights ------------------------------------------------------------------------------ */

static rk_light lamp(rk_vec3 corner, rk_vec3 edge01, rk_vec3 edge02)
{
    return (rk_light){RK_LIGHT_PARALLELOGRAM,
                      corner,
                      edge01,
                      edge02,
                      {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
}

static void samples_of_a_lamp_weigh_as_told(void **state)
{
    (void)state;
    const rk_light light = lamp(rk_vec(0, 0, 0), rk_vec(2, 0, 0), rk_vec(1, 3, 0));
    const rk_vec3 cross = rk_cross(light.edge01, light.edge02);
    const rk_vec3 points[] = {rk_vec(0, 0, 2), rk_vec(4, 0, 3)};
    for (int i = 0; i < 2; i++) {
        rk_vec3 d = rk_scale(points[i], -1);
        rk_light_sample sample = rk_light_sample_at(
            &light, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_AREA, points[i], (rk_vec2){0, 0});
        check_row("04_parallelogram_light", "vnnn", points[i], (double)rk_length(d),
                  (double)fabsf(rk_dot(d, cross)), (double)sample.colour.x);
    }
}

/* The side of a cube, seen from its middle. */
static void the_side_of_a_cube_fills_the_angle_told(void **state)
{
    (void)state;
    const rk_light side = lamp(rk_vec(-1, -1, 1), rk_vec(2, 0, 0), rk_vec(0, 2, 0));
    const rk_vec3 middle = rk_vec(0, 0, 0), up = rk_vec(0, 0, 1);
    check_row("04_parallelogram_light", "sn", "irradiance over $L$",
              (double)rk_light_irradiance(&side, middle, up));
    check_row("04_parallelogram_light", "sn", "solid angle", rk_light_solid_angle(&side, middle));
}

static void two_numbers_become_these_points_of_a_lamp(void **state)
{
    (void)state;
    const rk_light side = lamp(rk_vec(-1, -1, 1), rk_vec(2, 0, 0), rk_vec(0, 2, 0));
    const rk_vec2 xi[] = {{0.25f, 0.5f}, {0.75f, 0.5f}};
    for (int i = 0; i < 2; i++) {
        rk_vec3 at = rk_light_sample_at(&side, RK_FALLOFF_PHYSICAL, RK_LIGHT_DOMAIN_SOLID_ANGLE,
                                        rk_vec(0, 0, 0), xi[i])
                         .position;
        double x = ((double)at.x + 1) / 2, y = ((double)at.y + 1) / 2;
        double across = i ? x : 1 - x, along = (i ? 1 - y : y) / across;
        check_row("04_parallelogram_light", "nnsnnnnn", (double)xi[i].x, (double)xi[i].y,
                  i ? "second" : "first", 2 * (double)xi[i].x - i, along, across, x, y);
    }
}

/* --- Transparency ----------------------------------------------------------------------------- */

static void a_list_of_three_keeps_these_crossings(void **state)
{
    (void)state;
    const float t[] = {5, 2, 7, 4, 3, 3.5f}, alpha[] = {0.5f, 0.5f, 0.5f, 0.5f, 1, 0.5f};
    rk_crossing_list list;
    rk_transparency_start(&list, 3);
    for (int i = 0; i < 6; i++) {
        rk_crossing crossing = {.t = t[i], .alpha = alpha[i]};
        rk_transparency_insert(&list, &crossing);
        row kept = {"", 0};
        for (uint32_t k = 0; k < list.count; k++) {
            put(&kept, k ? ", " : "");
            put_number(&kept, (double)list.crossings[k].t);
        }
        check_row("05_transparency", "nssn", (double)t[i], alpha[i] < 1 ? "no" : "yes", kept.text,
                  (double)rk_transparency_end(&list, 9));
    }
}

static void three_surfaces_have_these_weights(void **state)
{
    (void)state;
    const rk_crossing c[] = {{.alpha = 0.5f}, {.alpha = 0.25f}, {.alpha = 0.5f}};
    float weights[3], transmittance;
    rk_transparency_weights(c, 3, weights, &transmittance);
    check_row("05_transparency", "snnnn", "weight", (double)weights[0], (double)weights[1],
              (double)weights[2], (double)transmittance);
}

static void a_ray_out_of_a_block_transmits_as_told(void **state)
{
    (void)state;
    const rk_vec3 sigma = rk_vec(0.5f, 0.5f, 0.5f);
    const rk_crossing c[] = {{.t = 0.25f, .alpha = 0.5f, .absorption = sigma},
                             {.t = 0.5f, .alpha = 0.5f, .absorption = sigma, .entering = true},
                             {.t = 0.75f, .alpha = 0.5f, .absorption = sigma}};
    double got = (double)rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, c, 3, 4).x;
    check_row("05_transparency", "nnnn", -log(got) / (0.5 * 4), 4., 0.5, got);
}

/* --- Bloom ------------------------------------------------------------------------------------ */

enum { WIDTH = 8, REACH = 2 };

static void radius_2_has_these_weights(void **state)
{
    (void)state;
    float w[REACH + 1];
    rk_bloom_weights(REACH, w);
    check_row("06_bloom", "snnn", "weight", (double)w[0], (double)w[1], (double)w[2]);
    const rk_bloom_filter filter = {REACH, w, RK_BLOOM_RENORMALIZE};
    check_row("06_bloom", "snnn", "weight inside", (double)rk_bloom_weight_inside(&filter, 0, 9),
              (double)rk_bloom_weight_inside(&filter, 1, 9),
              (double)rk_bloom_weight_inside(&filter, 2, 9));
}

static void check_mask(const char *name, rk_bloom_border border, size_t from)
{
    const float greys[WIDTH] = {2, 0.5f, 3, 0, 0, 4, 0, 5}, weights[REACH + 1] = {1, 0, 0};
    rk_vec3 pixels[WIDTH], masked[3 + 2 * REACH];
    for (int x = 0; x < WIDTH; x++)
        pixels[x] = rk_vec(greys[x], greys[x], greys[x]);
    const rk_bloom_filter filter = {REACH, weights, border};
    rk_bloom_bright_pass(&filter, pixels, WIDTH, 1, rk_bloom_bright_span(pixels, WIDTH, 1), from, 3,
                         masked);
    check_row("06_bloom", "snnnnnnn", name, (double)masked[0].x, (double)masked[1].x,
              (double)masked[2].x, (double)masked[3].x, (double)masked[4].x, (double)masked[5].x,
              (double)masked[6].x);
}

static void a_row_has_these_masks(void **state)
{
    (void)state;
    check_mask("from 1, zero", RK_BLOOM_ZERO, 1);
    check_mask("from 1, clamp", RK_BLOOM_CLAMP, 1);
    check_mask("from 5, clamp", RK_BLOOM_CLAMP, 5);
}

static void five_lines_have_this_sum(void **state)
{
    (void)state;
    const float values[2 * REACH + 1] = {16, 0, 8, 4, 32};
    float room[2 * REACH + 1][RK_BLOOM_BLOCK], w[REACH + 1], sum[RK_BLOOM_BLOCK];
    const float *lines[2 * REACH + 1];
    for (int k = 0; k <= 2 * REACH; k++) {
        for (int i = 0; i < RK_BLOOM_BLOCK; i++)
            room[k][i] = values[k];
        lines[k] = values[k] > 0 ? room[k] : NULL;
    }
    rk_bloom_weights(REACH, w);
    const rk_bloom_filter filter = {REACH, w, RK_BLOOM_ZERO};
    uint32_t taps = rk_bloom_blur_lines(&filter, lines, RK_BLOOM_BLOCK, sum);
    check_row("06_bloom", "snn", "sum, lines", (double)sum[0], (double)taps);
}

/* --- Glossy reflection ------------------------------------------------------------------------ */

static void a_disk_has_these_axes(void **state)
{
    (void)state;
    const rk_vec3 w[] = {rk_vec(0.6f, 0, 0.8f), rk_vec(0.6f, 0, -0.8f)};
    for (int i = 0; i < 2; i++) {
        rk_vec3 u, v;
        rk_basis_of(w[i], &u, &v);
        check_row("07_glossy_reflection", "vvv", w[i], u, v);
    }
}

static void a_square_becomes_these_points(void **state)
{
    (void)state;
    const rk_vec2 xi[] = {{0.25f, 0.625f}, {0.625f, 0.75f}, {0.5f, 0.5f}};
    for (int i = 0; i < 3; i++) {
        rk_vec2 at = rk_disk_at(RK_DISK_CONCENTRIC, xi[i]);
        check_row("07_glossy_reflection", "nnnn", 2 * (double)xi[i].x - 1, 2 * (double)xi[i].y - 1,
                  (double)at.x, (double)at.y);
    }
}

/* Of the unit disk at 60 degrees to a normal along y, up is along its axis v. */
static void a_disk_is_cut_as_told(void **state)
{
    (void)state;
    const rk_glossy_disk disk = {.w = rk_vec(0, 0.5f, 0.8660254f),
                                 .u = rk_vec(1, 0, 0),
                                 .v = rk_vec(0, 0.8660254f, -0.5f),
                                 .radius = 1,
                                 .face_normal = rk_vec(0, 1, 0)};
    float above = rk_glossy_fraction_above(&disk);
    check_row("07_glossy_reflection", "nnnnn", 60., 1., 0.5, 0.5 / sin(pi / 3), (double)above);
    const rk_vec2 points[] = {{0, -1}, {0.5f, 0}, {0, 1}};
    for (int i = 0; i < 3; i++) {
        rk_vec2 at = rk_glossy_point_above(&disk, above, points[i]);
        check_row("07_glossy_reflection", "nnnn", (double)points[i].y, (double)points[i].x,
                  (double)at.y, (double)at.x);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(normals_have_these_colours),
    cmocka_unit_test(triangles_have_these_normals),
    cmocka_unit_test(nine_triangles_become_five_nodes),
    cmocka_unit_test(highlights_are_as_bright_as_told),
    cmocka_unit_test(samples_of_a_lamp_weigh_as_told),
    cmocka_unit_test(the_side_of_a_cube_fills_the_angle_told),
    cmocka_unit_test(two_numbers_become_these_points_of_a_lamp),
    cmocka_unit_test(a_list_of_three_keeps_these_crossings),
    cmocka_unit_test(three_surfaces_have_these_weights),
    cmocka_unit_test(a_ray_out_of_a_block_transmits_as_told),
    cmocka_unit_test(radius_2_has_these_weights),
    cmocka_unit_test(a_row_has_these_masks),
    cmocka_unit_test(five_lines_have_this_sum),
    cmocka_unit_test(a_disk_has_these_axes),
    cmocka_unit_test(a_square_becomes_these_points),
    cmocka_unit_test(a_disk_is_cut_as_told),
};

RK_SUITE("worked_examples", tests)
