/* Environments from files: every layout with marked faces, so that reflected, rotated or swapped
 * ones are detected; the same map by every layout; and other pictures refused in a sentence.
 *
 * Each start of the helper takes a quarter of a second, so most pictures here are PNG, which needs
 * none. */
#include "test.h"

#include "remedy.h"
#include "test_cost.h"
#include "test_picture_file.h"

#include "base/random.h"
#include "io/environment_file.h"
#include "io/image_file.h"
#include "io/image_world.h"

/* --- marked faces ----------------------------------------------------------------------------- */

/* Of a face's 2 x 2 texels the top left one identifies the face, the top right one is white, and
 * those below are black, so that a face differs in each orientation. PNG keeps 0 and 1 exactly. */
typedef struct mark {
    rk_cube_face face;
    rk_vec3 colour;
} mark;

static const mark marks[RK_FACES] = {
    {RK_FACE_X, {1, 0, 0}},       {RK_FACE_MINUS_X, {0, 1, 1}}, {RK_FACE_Y, {0, 1, 0}},
    {RK_FACE_MINUS_Y, {1, 0, 1}}, {RK_FACE_Z, {0, 0, 1}},       {RK_FACE_MINUS_Z, {1, 1, 0}},
};

static rk_image make_image(size_t width, size_t height)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    return image;
}

static rk_vec3 marked(rk_cube_face face, size_t column, size_t row)
{
    return row > 0 ? rk_vec(0, 0, 0) : column > 0 ? rk_vec(1, 1, 1) : marks[face].colour;
}

/* A 2 x 2 face with its top left corner at (x, y), rotated by 180 degrees if the layout requires
 * it. */
static void draw_face(rk_image *image, rk_cube_face face, size_t x, size_t y, bool upside_down)
{
    for (size_t row = 0; row < 2; row++)
        for (size_t column = 0; column < 2; column++)
            *rk_image_at(image, x + (upside_down ? 1 - column : column),
                         y + (upside_down ? 1 - row : row)) = marked(face, column, row);
}

static test_path write_image(const test_folder *folder, const char *name, rk_image *image)
{
    test_path path = test_folder_path(folder, name);
    rk_error error;
    rk_check_ok(rk_image_file_write(path.text, image, &error), error);
    rk_image_free(image);
    return path;
}

static rk_cubemap read_map(const char *path)
{
    rk_cubemap map;
    rk_error error = {""};
    rk_check_ok(rk_environment_file_read(&map, path, &error), error);
    return map;
}

static void check_marks(const char *path)
{
    rk_cubemap map = read_map(path);
    rk_check_equal(map.side, 2, path);
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < 4; i++) {
            rk_vec3 got = map.faces[face][i];
            rk_vec3 want = marked((rk_cube_face)face, i % 2, i / 2);
            rk_check(
                rk_length(rk_sub(got, want)) == 0,
                "%s: face %d, column %u, row %u: got (%g, %g, %g), want (%g, %g, %g): swapped, "
                "mirrored or turned",
                path, face, i % 2, i / 2, (double)got.x, (double)got.y, (double)got.z,
                (double)want.x, (double)want.y, (double)want.z);
        }
    rk_cubemap_free(&map);
}

static void check_refused(const char *path, const char *part)
{
    rk_cubemap map;
    rk_error error = {""};
    rk_check(!rk_environment_file_read(&map, path, &error), "%s was accepted", path);
    rk_check(map.side == 0 && !map.faces[0], "%s: a map was left behind", path);
    rk_check_error_names(error, part);
    rk_check(!strchr(error.text, '\n'), "one line: %s", error.text);
    rk_check_remedy(error.text);
}

/* --- layouts ---------------------------------------------------------------------------------- */

/* The row of four in both crosses, as far as it goes. */
static void draw_row(rk_image *image)
{
    draw_face(image, RK_FACE_MINUS_X, 0, 2, false);
    draw_face(image, RK_FACE_MINUS_Z, 2, 2, false);
    draw_face(image, RK_FACE_X, 4, 2, false);
    draw_face(image, RK_FACE_Y, 2, 0, false);
    draw_face(image, RK_FACE_MINUS_Y, 2, 4, false);
}

static void a_lying_cross_is_the_header_s_picture(void **state)
{
    rk_image image = make_image(8, 6);
    draw_row(&image);
    draw_face(&image, RK_FACE_Z, 6, 2, false);
    check_marks(write_image(*state, "lying.png", &image).text);
}

static void a_standing_cross_has_z_below_upside_down(void **state)
{
    rk_image image = make_image(6, 8);
    draw_row(&image);
    draw_face(&image, RK_FACE_Z, 2, 6, true);
    check_marks(write_image(*state, "standing.png", &image).text);
}

/* OpenGL's order and names, where +z is ahead, like our -z. */
static const struct {
    const char *name;
    rk_cube_face face;
} order[RK_FACES] = {
    {"px", RK_FACE_X},       {"nx", RK_FACE_MINUS_X}, {"py", RK_FACE_Y},
    {"ny", RK_FACE_MINUS_Y}, {"pz", RK_FACE_MINUS_Z}, {"nz", RK_FACE_Z},
};

static void strips_are_in_the_order_of_opengl(void **state)
{
    rk_image lying = make_image(12, 2), standing = make_image(2, 12);
    for (size_t i = 0; i < RK_FACES; i++) {
        draw_face(&lying, order[i].face, 2 * i, 0, false);
        draw_face(&standing, order[i].face, 0, 2 * i, false);
    }
    check_marks(write_image(*state, "lying.png", &lying).text);
    check_marks(write_image(*state, "standing.png", &standing).text);
}

static void write_six(const test_folder *folder, const char *before, const char *after)
{
    for (int i = 0; i < RK_FACES; i++) {
        char name[64];
        rk_image image = make_image(2, 2);
        draw_face(&image, order[i].face, 0, 0, false);
        snprintf(name, sizeof name, "%s%s%s", before, order[i].name, after);
        write_image(folder, name, &image);
    }
}

static void six_files_go_by_other_names_too(void **state)
{
    static const char *const others[][RK_FACES] = {
        {"posx", "negx", "posy", "negy", "posz", "negz"},
        {"right", "left", "top", "bottom", "front", "back"},
        {"Right", "Left", "Up", "Down", "Front", "Back"},
        {"sky_ft", "sky_bk", "sky_up", "sky_dn", "sky_rt", "sky_lf"},
        {"sky_rt", "sky_lf", "sky_up", "sky_dn", "sky_fr", "sky_bk"},
        {"a-PX", "a-NX", "a-PY", "a-NY", "a-PZ", "a-NZ"},
        {"a.px", "a.nx", "a.py", "a.ny", "a.pz", "a.nz"},
        {"a px", "a nx", "a py", "a ny", "a pz", "a nz"},
        {"x+", "x-", "y+", "y-", "z+", "z-"},
        {"xp", "xn", "yp", "yn", "zp", "zn"},
        {"XPos", "XNeg", "YPos", "YNeg", "ZPos", "ZNeg"},
        {"PositiveX", "NegativeX", "PositiveY", "NegativeY", "PositiveZ", "NegativeZ"},
        {"positive_x", "negative_x", "positive_y", "negative_y", "positive_z", "negative_z"},
        {"pano_r", "pano_l", "pano_u", "pano_d", "pano_f", "pano_b"},
        {"face_0", "face_1", "face_2", "face_3", "face_4", "face_5"},
    };
    const test_folder *folder = *state;
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        for (int i = 0; i < RK_FACES; i++) {
            char name[64];
            rk_image image = make_image(2, 2);
            draw_face(&image, order[i].face, 0, 0, false);
            snprintf(name, sizeof name, "%s.png", others[k][i]);
            write_image(folder, name, &image);
        }
        check_marks(folder->path);
        if (k < 2)
            check_marks(test_folder_path(folder, "%s.png").text);
        for (int i = 0; i < RK_FACES; i++) {
            char name[64];
            snprintf(name, sizeof name, "%s.png", others[k][i]);
            remove(test_folder_path(folder, name).text);
        }
    }
}

static void six_files_go_by_a_pattern(void **state)
{
    write_six(*state, "room_", "_2k.png");
    check_marks(test_folder_path(*state, "room_%s_2k.png").text);
    /* Other conversions of printf are plain text. */
    write_six(*state, "100%d_", ".png");
    check_marks(test_folder_path(*state, "100%d_%s.png").text);
}

static void six_files_go_by_their_folder(void **state)
{
    const test_folder *folder = *state;
    write_six(folder, "", ".png");
    test_folder_write(folder, "readme.txt", "x", 1, 0600);
    test_folder_write(folder, "pxx.png", "x", 1, 0600);
    check_marks(folder->path);
    check_marks(test_folder_path(folder, "").text); /* with a slash at its end */
}

/* --- longitude and latitude ------------------------------------------------------------------- */

/* A smooth function of direction, in [0, 1]. */
static rk_vec3 smooth(rk_vec3 d)
{
    d = rk_normalize(d);
    return rk_vec(0.5f + 0.4f * d.x, 0.5f + 0.4f * d.y, 0.5f + 0.4f * d.z);
}

static rk_image make_world(size_t width)
{
    const double pi = 3.14159265358979323846;
    rk_image image = make_image(width, width / 2);
    for (size_t y = 0; y < image.height; y++)
        for (size_t x = 0; x < width; x++) {
            double longitude = ((double)x + 0.5) / (double)width * 2 * pi - pi;
            double from_top = ((double)y + 0.5) / (double)image.height * pi;
            *rk_image_at(&image, x, y) =
                smooth(rk_vec((float)(sin(from_top) * sin(longitude)), (float)cos(from_top),
                              (float)(-sin(from_top) * cos(longitude))));
        }
    return image;
}

static void check_smooth(const char *path, double tolerance)
{
    rk_cubemap map = read_map(path);
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < map.side * map.side; i++) {
            rk_vec3 want = smooth(rk_cubemap_texel_direction(map.side, (rk_cube_face)face,
                                                             i % map.side, i / map.side));
            rk_vec3 got = map.faces[face][i], apart = rk_abs3(rk_sub(got, want));
            rk_check((double)rk_max(apart.x, rk_max(apart.y, apart.z)) <= tolerance,
                     "%s: face %d, texel %u: got (%g, %g, %g), want (%g, %g, %g) within %g", path,
                     face, i, (double)got.x, (double)got.y, (double)got.z, (double)want.x,
                     (double)want.y, (double)want.z, tolerance);
        }
    rk_cubemap_free(&map);
}

static void longitude_and_latitude_become_the_cube(void **state)
{
    rk_image world = make_world(128);
    test_path path = write_image(*state, "world.exr", &world);
    rk_cubemap map = read_map(path.text);
    /* 128 pixels around the equator: from 128 / pi on, texels in the middle of a face are no
     * coarser. */
    rk_check_equal(map.side, 41, "as fine as the picture's equator");
    rk_cubemap_free(&map);
    /* Linear interpolation between pixels 2 pi / 128 apart: an eighth of the square of that on each
     * axis; 1 / 10 more at the poles, on the last ring of pixels. */
    double pixel = 2 * 3.1416 / 128;
    check_smooth(path.text, 2 * pixel * pixel / 8);
}

/* The direction at s (to the right) and t (upwards) of each picture: 1 is s, 2 is t, 3 is the
 * distance; Quake's axes are forward, left and up. Source: st_to_vec in Quake II's gl_warp.c. */
static const struct {
    const char *name;
    int axes[3];
} quake[RK_FACES] = {
    {"rt", {3, -1, 2}},  {"lf", {-3, 1, 2}},  {"bk", {1, 3, 2}},
    {"ft", {-1, -3, 2}}, {"up", {-2, -1, 3}}, {"dn", {2, -1, -3}},
};

static rk_vec3 quake_direction(const int axes[3], float s, float t)
{
    const float b[3] = {s, t, 1};
    float v[3];
    for (int i = 0; i < 3; i++)
        v[i] = axes[i] < 0 ? -b[-axes[i] - 1] : b[axes[i] - 1];
    return rk_vec(-v[1], v[2], -v[0]); /* forward is our -z */
}

static void the_faces_of_quake_fit_at_their_edges(void **state)
{
    for (int face = 0; face < RK_FACES; face++) {
        rk_image image = make_image(16, 16);
        for (size_t i = 0; i < 256; i++) {
            float s = ((float)(i % 16) + 0.5f) / 8 - 1, t = 1 - ((float)(i / 16) + 0.5f) / 8;
            image.pixels[i] = smooth(quake_direction(quake[face].axes, s, t));
        }
        char name[20];
        snprintf(name, sizeof name, "sky_%s.png", quake[face].name);
        write_image(*state, name, &image);
    }
    check_smooth(((test_folder *)*state)->path, 0.5 / 255 * 2.3); /* as of a cross in a PNG */
}

/* Cropped or scaled. The rows still go from pole to pole. */
static void a_world_may_lack_a_row_or_a_column(void **state)
{
    const size_t sizes[][2] = {{255, 128}, {257, 128}, {256, 127}, {256, 129}};
    for (int i = 0; i < 4; i++) {
        rk_image image = make_image(sizes[i][0], sizes[i][1]);
        rk_cubemap map = read_map(write_image(*state, "cropped.png", &image).text);
        rk_check(map.side == 82 || map.side == 81, "got %u texels per side", map.side);
        rk_cubemap_free(&map);
    }
    rk_image image = make_image(256, 126);
    check_refused(write_image(*state, "cropped.png", &image).text,
                  "256 x 126 pixels: choose an environment");
}

static void the_smallest_world_is_two_pixels(void **state)
{
    rk_image world = make_image(2, 1);
    *rk_image_at(&world, 0, 0) = rk_vec(1, 0, 0);
    *rk_image_at(&world, 1, 0) = rk_vec(0, 1, 0);
    rk_cubemap map = read_map(write_image(*state, "world.png", &world).text);
    rk_check_equal(map.side, 1, "one texel per face");
    rk_check(rk_length(rk_sub(map.faces[RK_FACE_X][0], rk_vec(0, 1, 0))) < 1e-6f,
             "the right half is around +x");
    rk_check(rk_length(rk_sub(map.faces[RK_FACE_MINUS_X][0], rk_vec(1, 0, 0))) < 1e-6f,
             "the left half is around -x");
    rk_check(rk_length(rk_sub(map.faces[RK_FACE_Y][0], rk_vec(0.5f, 0.5f, 0))) < 1e-6f,
             "both agree at the pole");
    rk_cubemap_free(&map);
}

/* --- formats ---------------------------------------------------------------------------------- */

/* A smooth function on the lying cross. */
static rk_image make_cross(size_t side)
{
    const struct {
        rk_cube_face face;
        size_t column, row;
    } cells[] = {{RK_FACE_Y, 1, 0}, {RK_FACE_MINUS_X, 0, 1}, {RK_FACE_MINUS_Z, 1, 1},
                 {RK_FACE_X, 2, 1}, {RK_FACE_Z, 3, 1},       {RK_FACE_MINUS_Y, 1, 2}};
    rk_image image = make_image(4 * side, 3 * side);
    for (int i = 0; i < RK_FACES; i++)
        for (size_t k = 0; k < side * side; k++) {
            size_t column = k % side, row = k / side;
            *rk_image_at(&image, cells[i].column * side + column, cells[i].row * side + row) =
                smooth(rk_cubemap_texel_direction((uint32_t)side, cells[i].face, (uint32_t)column,
                                                  (uint32_t)row));
        }
    return image;
}

static void every_format_arrives_linear(void **state)
{
    /* The error of each format: none; a step of 8-bit sRGB, whose slope is 2.3 at 1; a 128th of the
     * brightest channel. JPG blurs the edges of cells, so it gets one colour. */
    const struct {
        const char *name;
        double tolerance;
    } formats[] = {{"cross.exr", 1e-6}, {"cross.png", 0.5 / 255 * 2.3}, {"cross.hdr", 1.0 / 128}};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        rk_image image = make_cross(16);
        check_smooth(write_by_helper(*state, formats[i].name, &image).text, formats[i].tolerance);
        rk_image_free(&image);
    }
    rk_image grey = make_image(64, 48);
    for (size_t i = 0; i < 64 * 48; i++)
        grey.pixels[i] = rk_vec(0.2f, 0.2f, 0.2f);
    rk_cubemap map = read_map(write_by_helper(*state, "grey.jpg", &grey).text);
    rk_image_free(&grey);
    for (int i = 0; i < RK_FACES * 256; i++)
        rk_check_close(map.faces[0][i].x, 0.2, 1.0 / 255 * 2.3, "JPG stores sRGB: decode it");
    rk_cubemap_free(&map);
}

/* --- large worlds ----------------------------------------------------------------------------- */

/* The mean over all directions: texels count by their solid angle, 1 / (1 + u^2 + v^2)^(3/2). */
static double mean_radiance(const rk_cubemap *map)
{
    double sum = 0, weights = 0;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < map->side * map->side; i++) {
            const double u = 2 * (i % map->side + 0.5) / map->side - 1;
            const double v = 2 * (double)(i / map->side + 0.5) / map->side - 1;
            const double weight = pow(1 + u * u + v * v, -1.5);
            sum += weight * (double)map->faces[face][i].y;
            weights += weight;
        }
    return sum / weights;
}

static rk_image make_noisy_world(void)
{
    rk_image world = make_image(512, 256);
    for (uint32_t i = 0; i < 512 * 256; i++) {
        const float value = rk_unit_float(rk_hash(i, 1, 2, 3));
        world.pixels[i] = rk_vec(value, value, value);
    }
    return world;
}

/* Sums to the picture's mean over directions, of pixels that reach over all of their square. */
static double weighted_mean(const rk_vec3 *pixels, size_t width, size_t height)
{
    double sum = 0;
    for (size_t i = 0; i < width * height; i++) {
        const double top = acos(-1.0) * (double)(i / width) / (double)height;
        sum += (cos(top) - cos(top + acos(-1.0) / (double)height)) * (double)pixels[i].y;
    }
    return sum / (2 * (double)width);
}

/* A sun of 3000 pixels' worth stands beside the pole, where rows differ most. The bound is the
 * rounding of a mean to float, 6e-8, with room for the sums. */
static void means_of_squares_keep_the_mean_radiance(void **state)
{
    (void)state;
    rk_image world = make_noisy_world();
    rk_image_at(&world, 100, 1)->y = 3000;
    const double before = weighted_mean(world.pixels, 512, 256);
    for (size_t factor = 2; factor <= 64; factor *= 2) {
        static rk_vec3 means[256 * 128];
        double shares[64];
        for (size_t y = 0; y < 256 / factor; y++) {
            rk_image_world_shares(shares, factor, y * factor, 256);
            rk_image_world_average(&means[y * (512 / factor)].x,
                                   &rk_image_at(&world, 0, y * factor)->x, 512, factor, shares);
        }
        rk_check_close(weighted_mean(means, 512 / factor, 256 / factor), before, 1e-6 * before,
                       "by solid angle");
    }
    rk_image_free(&world);
}

/* Noise of deviation .29 in 131,072 pixels: the mean over 10,000 texels of either cube deviates by
 * .003 at most. */
static void a_world_is_reduced_to_what_a_view_needs(void **state)
{
    static const char *const names[] = {"noisy.exr", "noisy.hdr", "noisy.png"};
    for (int i = 0; i < 3; i++) {
        rk_image world = make_noisy_world();
        test_path path = write_by_helper(*state, names[i], &world);
        rk_image_free(&world);
        rk_cubemap whole = read_map(path.text), map;
        rk_error error;
        rk_check_ok(rk_environment_file_read_for(&map, path.text, 40, &error), error);
        rk_check_equal(map.side, 41, "512 / 4 columns make ceil(128 / pi) texels");
        rk_check_close(mean_radiance(&map), mean_radiance(&whole), 0.01, names[i]);
        rk_cubemap_free(&map);
        rk_check_ok(rk_environment_file_read_for(&map, path.text, 82, &error), error);
        rk_check_equal(map.side, whole.side, "256 columns would be too few");
        rk_check(memcmp(map.faces[0], whole.faces[0], map.side * map.side * sizeof(rk_vec3)) == 0,
                 "%s: it is read as it is", names[i]);
        rk_cubemap_free(&map);
        rk_cubemap_free(&whole);
    }
}

/* --- OpenEXR's own kinds ---------------------------------------------------------------------- */

typedef struct exr_bytes {
    unsigned char bytes[8192];
    size_t size;
} exr_bytes;

static void put(exr_bytes *e, const void *bytes, size_t size)
{
    assert_true(e->size + size <= sizeof e->bytes);
    memcpy(e->bytes + e->size, bytes, size);
    e->size += size;
}

static void put_word(exr_bytes *e, uint32_t word)
{
    put(e,
        (const unsigned char[]){word & 255, word >> 8 & 255, word >> 16 & 255,
                                (unsigned char)(word >> 24)},
        4);
}

static void put_float(exr_bytes *e, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_word(e, bits);
}

static void put_attribute(exr_bytes *e, const char *name, const char *type, uint32_t size)
{
    put(e, name, strlen(name) + 1);
    put(e, type, strlen(type) + 1);
    put_word(e, size);
}

static void put_box(exr_bytes *e, const char *name, uint32_t width, uint32_t height)
{
    put_attribute(e, name, "box2i", 16);
    put_word(e, 0);
    put_word(e, 0);
    put_word(e, width - 1);
    put_word(e, height - 1);
}

/* Uncompressed floats: "OpenEXR File Layout". An environment has its kind as an attribute. */
static void put_header(exr_bytes *e, const rk_image *image, uint32_t shown_width, bool is_cube)
{
    put(e, "\x76\x2f\x31\x01\2\0\0", 8);
    put_attribute(e, "channels", "chlist", 3 * 18 + 1);
    for (int i = 0; i < 3; i++) {
        put(e, &"B\0G\0R"[2 * i], 2);
        put_word(e, 2);
        put_word(e, 0);
        put_word(e, 1);
        put_word(e, 1);
    }
    put(e, "", 1);
    put_attribute(e, "compression", "compression", 1);
    put(e, "", 1);
    put_box(e, "dataWindow", (uint32_t)image->width, (uint32_t)image->height);
    put_box(e, "displayWindow", shown_width, (uint32_t)image->height);
    put_attribute(e, "lineOrder", "lineOrder", 1);
    put(e, "", 1);
    put_attribute(e, "pixelAspectRatio", "float", 4);
    put_float(e, 1);
    put_attribute(e, "screenWindowCenter", "v2f", 8);
    put_float(e, 0);
    put_float(e, 0);
    put_attribute(e, "screenWindowWidth", "float", 4);
    put_float(e, 1);
    if (is_cube) {
        put_attribute(e, "envmap", "envmap", 1);
        put(e, "\1", 1);
    }
    put(e, "", 1);
}

static test_path write_exr(const test_folder *folder, const rk_image *image, uint32_t shown_width,
                           bool is_cube)
{
    static exr_bytes e;
    e.size = 0;
    put_header(&e, image, shown_width, is_cube);
    const uint32_t row = 12 * (uint32_t)image->width;
    const uint32_t first = (uint32_t)(e.size + 8 * image->height);
    for (uint32_t y = 0; y < image->height; y++) {
        put_word(&e, first + y * (row + 8));
        put_word(&e, 0);
    }
    for (uint32_t y = 0; y < image->height; y++) {
        put_word(&e, y);
        put_word(&e, row);
        for (int c = 2; c >= 0; c--)
            for (size_t x = 0; x < image->width; x++)
                put_float(&e, rk_axis(*rk_image_at(image, x, y), c));
    }
    return test_folder_write(folder, "own.exr", e.bytes, e.size, 0600);
}

/* Of the face's texel at (u, v), from -1 to 1, to the right and down; in ours, which looks along
 * its -z (ImfEnvmap.h, CubeMap::pixelPosition). */
static rk_vec3 openexr_direction(int face, float u, float v)
{
    const rk_vec3 theirs[] = {{1, -v, u}, {-1, -v, -u}, {u, 1, -v},
                              {u, -1, v}, {-u, -v, 1},  {u, -v, -1}};
    return rk_normalize(rk_vec(-theirs[face].x, theirs[face].y, -theirs[face].z));
}

static void a_cube_of_openexr_has_its_own_order(void **state)
{
    enum { side = 6 };
    rk_image image = make_image(side, 6 * side);
    for (int k = 0; k < 6 * side * side; k++) {
        const float u = ((float)(k % side) + 0.5f) / side * 2 - 1;
        const float v = ((float)(k / side % side) + 0.5f) / side * 2 - 1;
        image.pixels[k] = smooth(openexr_direction(k / (side * side), u, v));
    }
    check_smooth(write_exr(*state, &image, side, true).text, 1e-6);
    rk_image_free(&image);
}

static void a_part_of_a_picture_is_no_environment(void **state)
{
    rk_image image = make_image(4, 2);
    rk_cubemap map = read_map(write_exr(*state, &image, 4, false).text);
    rk_cubemap_free(&map);
    check_refused(write_exr(*state, &image, 8, false).text,
                  "stores 4 x 2 pixels of a picture of 8 x 2");
    rk_image_free(&image);
}

static void one_pixel_faces_are_a_map(void **state)
{
    const size_t sizes[][2] = {{4, 3}, {3, 4}, {6, 1}, {1, 6}};
    for (size_t i = 0; i < 4; i++) {
        rk_image image = make_image(sizes[i][0], sizes[i][1]);
        for (size_t k = 0; k < image.width * image.height; k++)
            image.pixels[k] = rk_vec(1, 1, 0);
        rk_cubemap map = read_map(write_image(*state, "tiny.png", &image).text);
        rk_check_equal(map.side, 1, "one texel a face");
        for (int face = 0; face < RK_FACES; face++)
            rk_check(rk_length(rk_sub(map.faces[face][0], rk_vec(1, 1, 0))) == 0, "its colour");
        rk_cubemap_free(&map);
    }
}

/* --- refusals --------------------------------------------------------------------------------- */

static void other_shapes_are_refused_with_their_size(void **state)
{
    const size_t sizes[][2] = {{1, 1}, {5, 5}, {16, 9}, {8, 7}, {13, 2}, {2, 3}, {1, 2}, {7, 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char part[32];
        rk_image image = make_image(sizes[i][0], sizes[i][1]);
        test_path path = write_image(*state, "shape.png", &image);
        snprintf(part, sizeof part, "%zu x %zu pixels", sizes[i][0], sizes[i][1]);
        check_refused(path.text, part);
        check_refused(path.text, "4:3");
        check_refused(path.text, path.text);
    }
}

static void a_missing_face_is_named(void **state)
{
    const test_folder *folder = *state;
    write_six(folder, "", ".png");
    remove(test_folder_path(folder, "ny.png").text);
    check_refused(folder->path, "no picture ny.*");
    check_refused(test_folder_path(folder, "%s.png").text, "ny.png");
    write_six(folder, "", ".png");
    test_folder_write(folder, "px.txt", "x", 1, 0600);
    check_refused(folder->path, "more than one picture px.*");
    check_refused(test_folder_path(folder, "%s_%s.png").text, "more than one %s");
}

static void faces_of_different_sizes_are_refused(void **state)
{
    const test_folder *folder = *state;
    write_six(folder, "", ".png");
    rk_image larger = make_image(3, 3);
    write_image(folder, "nz.png", &larger);
    check_refused(folder->path, "nz.png: has 3 x 3 pixels, but the first face has 2 x 2");
    rk_image oblong = make_image(3, 2);
    write_image(folder, "px.png", &oblong);
    check_refused(folder->path, "px.png: has 3 x 2 pixels: choose a square one");
}

static void a_missing_file_is_an_error(void **state)
{
    const test_folder *folder = *state;
    check_refused(test_folder_path(folder, "none.png").text, "none.png");
    check_refused(test_folder_path(folder, "none.exr").text, "none.exr");
    check_refused(folder->path, "no picture px.*");
    check_refused("", "");
    char path[6000];
    memset(path, 'a', sizeof path);
    memcpy(path + 5000, "%s", 3);
    check_refused(path, "too long");
}

static void a_pixel_that_is_not_a_number_is_named(void **state)
{
    rk_image image = make_cross(4);
    image.pixels[5].y = NAN;
    check_refused(write_image(*state, "nan.exr", &image).text, "x 5, y 0");
}

/* The files end after a header that claims too much. */
static void huge_sizes_are_refused(void **state)
{
    const char more[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 75000 +X 100000\n";
    check_refused(test_folder_write(*state, "more.hdr", more, sizeof more - 1, 0600).text,
                  "1 to 32768");
    const char most[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 24576 +X 32768\n";
    check_refused(test_folder_write(*state, "most.hdr", most, sizeof most - 1, 0600).text,
                  "32768 x 24576 pixels, more than the 1677");
    const unsigned char png[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x80\0\0\0\x60\0";
    check_refused(test_folder_write(*state, "most.png", png, sizeof png, 0600).text,
                  "32768 x 24576 pixels, more than the 1677");
}

static bool read_and_free(const char *path, rk_error *error)
{
    rk_cubemap map;
    bool ok = rk_environment_file_read(&map, path, error);
    rk_cubemap_free(&map);
    return ok;
}

/* In one colour, so that it compresses to a thousandth. Reading 2048 x 2048 pixels takes 67 MB. */
static void another_shape_is_refused_by_its_header(void **state)
{
    const test_folder *folder = *state;
    rk_image image = make_image(2048, 2048);
    test_path path = write_image(folder, "square.png", &image);
    test_cost cost = test_cost_of(read_and_free, path.text);
    rk_check(!cost.ok, "1:1 is no environment");
    rk_check_error_names(cost.error,
                         "2048 x 2048 pixels: choose an environment whose width : height");
    test_check_cost(path.text, &cost, 10, 0.5);
    image = make_image(2048, 1024);
    write_six(folder, "", ".png");
    write_image(folder, "px.png", &image);
    cost = test_cost_of(read_and_free, folder->path);
    rk_check_error_names(cost.error, "2048 x 1024 pixels: choose a square one");
    test_check_cost(path.text, &cost, 10, 0.5);
}

/* Less than 400 KB, which would take as many megabytes. */
static void a_small_file_of_many_pixels_is_refused(void **state)
{
    rk_image image = make_image(8192, 4096);
    test_path path = write_image(*state, "black.png", &image);
    test_cost cost = test_cost_of(read_and_free, path.text);
    rk_check(!cost.ok, "a thousandth of a byte per pixel was accepted");
    rk_check_error_names(cost.error, "8192 x 4096 pixels, more than the");
    test_check_cost(path.text, &cost, 10, 0.5);
}

/* Files truncated or with bytes changed: the result is a map or one sentence. */
static void damaged_files_are_refused_or_read(void **state)
{
    const test_folder *folder = *state;
    rk_image image = make_cross(4);
    size_t size;
    unsigned char *whole = test_folder_read(write_image(folder, "whole.png", &image), &size);
    unsigned refused = 0;
    for (uint32_t n = 0; n < 300; n++) {
        unsigned char *damaged = malloc(size);
        rk_check(damaged, "no memory");
        memcpy(damaged, whole, size);
        size_t length = n < 100 ? size * n / 100 : size;
        for (uint32_t k = 0; n >= 100 && k < 1 + n % 4; k++)
            damaged[rk_hash(n, k, 0, 0) % size] = (unsigned char)rk_hash(n, k, 1, 0);
        test_path path = test_folder_write(folder, "damaged.png", damaged, length, 0600);
        free(damaged);
        rk_cubemap map;
        rk_error error = {""};
        if (rk_environment_file_read(&map, path.text, &error)) {
            rk_check(n >= 100, "a file truncated to %zu of %zu bytes was accepted", length, size);
        } else {
            rk_check(map.side == 0 && !map.faces[0], "a map was left behind");
            rk_check_error_names(error, "damaged.png");
            refused++;
        }
        rk_cubemap_free(&map);
    }
    rk_check(refused > 200, "only %u of 300 were refused", refused);
    free(whole);
}

static void truncated_files_of_other_formats_are_refused(void **state)
{
    const test_folder *folder = *state;
    const char *const names[] = {"truncated.exr", "truncated.hdr", "truncated.jpg"};
    for (int i = 0; i < 3; i++) {
        size_t size;
        rk_image image = make_cross(16);
        unsigned char *whole = test_folder_read(write_by_helper(folder, names[i], &image), &size);
        rk_image_free(&image);
        test_path path = test_folder_write(folder, names[i], whole, size / 2, 0600);
        free(whole);
        check_refused(path.text, names[i]);
    }
}

static const struct CMUnitTest tests[] = {
    test_in_folder(a_lying_cross_is_the_header_s_picture),
    test_in_folder(a_standing_cross_has_z_below_upside_down),
    test_in_folder(strips_are_in_the_order_of_opengl),
    test_in_folder(six_files_go_by_a_pattern),
    test_in_folder(six_files_go_by_other_names_too),
    test_in_folder(six_files_go_by_their_folder),
    test_in_folder(longitude_and_latitude_become_the_cube),
    test_in_folder(the_faces_of_quake_fit_at_their_edges),
    test_in_folder(a_world_may_lack_a_row_or_a_column),
    test_in_folder(the_smallest_world_is_two_pixels),
    test_in_folder(every_format_arrives_linear),
    test_in_folder(means_of_squares_keep_the_mean_radiance),
    test_in_folder(a_world_is_reduced_to_what_a_view_needs),
    test_in_folder(a_cube_of_openexr_has_its_own_order),
    test_in_folder(a_part_of_a_picture_is_no_environment),
    test_in_folder(one_pixel_faces_are_a_map),
    test_in_folder(other_shapes_are_refused_with_their_size),
    test_in_folder(a_missing_face_is_named),
    test_in_folder(faces_of_different_sizes_are_refused),
    test_in_folder(a_missing_file_is_an_error),
    test_in_folder(a_pixel_that_is_not_a_number_is_named),
    test_in_folder(huge_sizes_are_refused),
    test_in_folder(another_shape_is_refused_by_its_header),
    test_in_folder(a_small_file_of_many_pixels_is_refused),
    test_in_folder(damaged_files_are_refused_or_read),
    test_in_folder(truncated_files_of_other_formats_are_refused),
};

RK_SUITE("environment_file", tests)
