/* Environment lookups: the cube against a second definition of its faces, filters against a search
 * through all texels and against maps of smooth functions, and continuity at edges and corners. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */

#include "test.h"

#include "base/random.h"
#include "features/cubemap.h"

#include <sys/mman.h>

/* --- A second definition of the cube, in double ----------------------------------------------- */

static const double pi = 3.14159265358979323846;

/* Roundings of a few operations on numbers up to one, each 2^-24. */
static const double few_roundings = 8 * 0x1p-24;

typedef struct vec {
    double x, y, z;
} vec;

static vec combine(vec a, double s, vec b, double t)
{
    return (vec){a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}

static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec widen(rk_vec3 a)
{
    return (vec){(double)a.x, (double)a.y, (double)a.z};
}

static vec unit(vec a)
{
    return combine(a, 1 / sqrt(dot(a, a)), a, 0);
}

static rk_vec3 narrow(vec a)
{
    return rk_vec((float)a.x, (float)a.y, (float)a.z);
}

/* Read off the cross: for each face the directions to its middle, to its right and upwards. */
static const struct {
    rk_cube_face face;
    const char *name;
    vec ahead, right, up;
} cross[RK_FACES] = {
    {RK_FACE_X, "+x", {1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    {RK_FACE_MINUS_X, "-x", {-1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
    {RK_FACE_Y, "+y", {0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
    {RK_FACE_MINUS_Y, "-y", {0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {RK_FACE_Z, "+z", {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
    {RK_FACE_MINUS_Z, "-z", {0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
};

/* To the point (a, b) of face k of that table, in [-1, 1] to the right and upwards. */
static vec towards(int k, double a, double b)
{
    return combine(combine(cross[k].ahead, 1, cross[k].right, a), 1, cross[k].up, b);
}

static rk_vec3 random_direction(uint32_t n)
{
    double z = 2 * (double)rk_unit_float(rk_case(n, 0, 0, 7)) - 1, r = sqrt(1 - z * z);
    double phi = 2 * pi * (double)rk_unit_float(rk_case(n, 1, 0, 7));
    return rk_vec((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

/* --- Maps ------------------------------------------------------------------------------------- */

static rk_cubemap make_map(uint32_t side)
{
    rk_cubemap map;
    rk_error error;
    rk_check_ok(rk_cubemap_init(&map, side, &error), error);
    return map;
}

typedef rk_vec3 paint(uint32_t side, int face, uint32_t column, uint32_t row);

static rk_cubemap paint_map(uint32_t side, paint *colour)
{
    rk_cubemap map = make_map(side);
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t row = 0; row < side; row++)
            for (uint32_t column = 0; column < side; column++)
                *rk_cubemap_texel(&map, (rk_cube_face)face, column, row) =
                    colour(side, face, column, row);
    return map;
}

/* Encodes the texel's face, column and row. */
static rk_vec3 texel_name(uint32_t side, int face, uint32_t column, uint32_t row)
{
    (void)side;
    return rk_vec((float)face, (float)column, (float)row);
}

static rk_vec3 noise(uint32_t side, int face, uint32_t column, uint32_t row)
{
    uint32_t n = ((uint32_t)face * side + row) * side + column;
    return rk_vec(rk_unit_float(rk_case(n, 0, 0, 3)), rk_unit_float(rk_case(n, 1, 0, 3)),
                  rk_unit_float(rk_case(n, 2, 0, 3)));
}

static rk_vec3 one_colour_per_face(uint32_t side, int face, uint32_t column, uint32_t row)
{
    (void)side, (void)column, (void)row;
    return rk_vec((float)face, (float)(face * face), 1);
}

/* A smooth function of direction; no component changes by more than `steepest` per radian. */
static const double steepest = 2;

static vec smooth(vec d)
{
    d = unit(d);
    return (vec){sin(2 * d.x), d.y * d.z * 2, cos(1.5 * d.z + 0.5 * d.x)};
}

static rk_vec3 smooth_texel(uint32_t side, int face, uint32_t column, uint32_t row)
{
    return narrow(smooth(towards(face, (2 * column + 1.0) / side - 1, 1 - (2 * row + 1.0) / side)));
}

static double distance(rk_vec3 a, rk_vec3 b)
{
    rk_vec3 apart = rk_abs3(rk_sub(a, b));
    bool number = apart.x >= 0 && apart.y >= 0 && apart.z >= 0;
    return number ? (double)rk_max(apart.x, rk_max(apart.y, apart.z)) : INFINITY;
}

/* `said` is what a wrong colour tells of the mistake; a printf format with the position, and its
 * arguments, follow it. */
__attribute__((format(printf, 5, 6))) static void check_colour_or(rk_vec3 got, rk_vec3 want,
                                                                  double tolerance,
                                                                  const char *said,
                                                                  const char *format, ...)
{
    char where[500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(where, sizeof where, format, arguments);
    va_end(arguments);
    rk_check(distance(got, want) <= tolerance,
             "%s: got (%g, %g, %g), want (%g, %g, %g) within %.3g%s", where, (double)got.x,
             (double)got.y, (double)got.z, (double)want.x, (double)want.y, (double)want.z,
             tolerance, said);
}

__attribute__((format(printf, 4, 5))) static void
check_colour(rk_vec3 got, rk_vec3 want, double tolerance, const char *format, ...)
{
    char where[500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(where, sizeof where, format, arguments);
    va_end(arguments);
    check_colour_or(got, want, tolerance,
                    rk_mistake_in_vector(RK_XYZ(got), RK_XYZ(want), tolerance, NULL), "%s", where);
}

static const char *const filter_names[] = {"nearest", "bilinear", "seamless"};

static const char *name_of(rk_cube_face face)
{
    return (unsigned)face < RK_FACES ? cross[face].name : "that does not exist";
}

/* Of a colour that the map has, or would have, on another face. */
static const char *said_of_face(int face, int want)
{
    static char text[100];
    snprintf(text, sizeof text, "; that belongs to face %s, but the direction hits %s",
             cross[face].name, cross[want].name);
    return text;
}

/* --- Directions ------------------------------------------------------------------------------- */

static void the_largest_component_chooses_the_face(void **state)
{
    (void)state;
    for (int k = 0; k < RK_FACES; k++)
        for (int turn = 0; turn < 8; turn++) {
            double a = 0.9 * cos(turn * pi / 4), b = 0.9 * sin(turn * pi / 4);
            rk_cube_place place = rk_cubemap_place(narrow(towards(k, a, b)));
            rk_check(place.face == cross[k].face,
                     "near the middle of %s: got face %d (%s), want %d", cross[k].name,
                     (int)place.face, name_of(place.face), (int)cross[k].face);
        }
}

static void check_face(rk_vec3 direction, rk_cube_face want, const char *hint)
{
    rk_cube_face got = rk_cubemap_place(direction).face;
    rk_check(got == want, "(%g, %g, %g): got face %s, want %s: %s", (double)direction.x,
             (double)direction.y, (double)direction.z, name_of(got), name_of(want), hint);
}

static void on_edges_x_comes_before_y_before_z(void **state)
{
    (void)state;
    for (int sign = 0; sign < 8; sign++) {
        float x = sign & 1 ? -1 : 1, y = sign & 2 ? -1 : 1, z = sign & 4 ? -1 : 1;
        rk_cube_face on_x = x < 0 ? RK_FACE_MINUS_X : RK_FACE_X;
        rk_cube_face on_y = y < 0 ? RK_FACE_MINUS_Y : RK_FACE_Y;
        check_face(rk_vec(x, y, z), on_x, "a corner is on x");
        check_face(rk_vec(x, y, 0), on_x, "x before y");
        check_face(rk_vec(x, 0.3f, z), on_x, "x before z");
        check_face(rk_vec(0.3f, y, z), on_y, "y before z");
        check_face(rk_vec(x, y * (1 + 0x1p-23f), z), on_y,
                   "y is larger by one unit in the last place");
        check_face(rk_vec(x, 0.3f, z * (1 + 0x1p-23f)), z < 0 ? RK_FACE_MINUS_Z : RK_FACE_Z,
                   "z is larger than x by one unit in the last place");
        check_face(rk_vec(0.3f, y, z * (1 + 0x1p-23f)), z < 0 ? RK_FACE_MINUS_Z : RK_FACE_Z,
                   "z is larger than y by one unit in the last place");
    }
}

/* For the place (.75, .375). */
static const char *mistake_of_place(rk_cube_place place)
{
    const double length = sqrt(1 + 0.25 + 0.0625);
    return rk_mistake_in_vector(
        (const double[]){(double)place.u, (double)place.v, 0}, (const double[]){0.75, 0.375, 0},
        1e-6,
        RK_VECTOR_MISTAKES(
            {{0.25, 0.375, 0}, "u runs to the left: the face is mirrored, as seen from outside"},
            {{0.75, 0.625, 0}, "v runs downwards"},
            {{0.25, 0.625, 0}, "the face is upside down: u to the left, v downwards"},
            {{0.375, 0.75, 0}, "u and v are exchanged"},
            {{0.5, -0.25, 0}, "places from -1 to 1 are not moved to 0 to 1"},
            {{0.5, 0, 0}, "places from -1 to 1 are not moved to 0 to 1, only cut off"},
            {{(1 + 0.5 / length) / 2, (1 - 0.25 / length) / 2, 0},
             "the direction is divided by its length, not by its largest component"}));
}

static void u_runs_to_the_right_and_v_upwards(void **state)
{
    (void)state;
    /* By hand, from the cross: ahead 2, so that (u, v) = (.75, .375) is 1 to the right and .5 down.
     */
    const rk_vec3 directions[RK_FACES] = {
        {2, -0.5f, 1}, {-2, -0.5f, -1}, {1, 2, -0.5f},
        {1, -2, 0.5f}, {-1, -0.5f, 2},  {1, -0.5f, -2},
    };
    for (int face = 0; face < RK_FACES; face++) {
        rk_cube_place place = rk_cubemap_place(directions[face]);
        rk_check(place.face == (rk_cube_face)face && place.u == 0.75f && place.v == 0.375f,
                 "got face %d, (%g, %g), want face %d (%s), (0.75, 0.375): u = 1/2 + 1/4 to the "
                 "right, v = 1/2 - 1/8, as v grows upwards%s",
                 (int)place.face, (double)place.u, (double)place.v, face, cross[face].name,
                 (int)place.face == face ? mistake_of_place(place) : "");
    }
}

static void the_length_of_a_direction_does_not_matter(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 1000; n++) {
        rk_vec3 direction = random_direction(n);
        rk_cube_place want = rk_cubemap_place(direction);
        vec back = unit(widen(rk_cube_direction(want.face, want.u, want.v)));
        check_colour(narrow(back), narrow(unit(widen(direction))), few_roundings,
                     "direction %u, round trip: wrong even for length 1", n);
        for (int power = -120; power <= 128; power += 8) {
            /* Powers of two are exact, down to the smallest floats and up to the largest. */
            rk_vec3 scaled = rk_scale(direction, ldexpf(1, power / 2));
            scaled = rk_scale(scaled, ldexpf(1, power - power / 2));
            if (!(rk_max(fabsf(scaled.x), rk_max(fabsf(scaled.y), fabsf(scaled.z))) < INFINITY))
                continue;
            if (rk_min(fabsf(scaled.x), rk_min(fabsf(scaled.y), fabsf(scaled.z))) < 0x1p-126f)
                continue;
            rk_cube_place got = rk_cubemap_place(scaled);
            rk_check(
                got.face == want.face && got.u == want.u && got.v == want.v,
                "(%g, %g, %g) times 2^%d: got face %s, (%.9g, %.9g), want face %s, (%.9g, %.9g)",
                (double)direction.x, (double)direction.y, (double)direction.z, power,
                name_of(got.face), (double)got.u, (double)got.v, name_of(want.face), (double)want.u,
                (double)want.v);
        }
    }
    /* One over the largest component would be infinite. */
    rk_cube_place tiny = rk_cubemap_place(rk_vec(0x1p-147f, -0x1p-149f, 0x1p-148f));
    rk_check(tiny.face == RK_FACE_X && tiny.u == 0.75f && tiny.v == 0.375f,
             "(2, -0.5, 1) times 2^-148: got face %s, (%g, %g), want face +x, (0.75, 0.375)",
             name_of(tiny.face), (double)tiny.u, (double)tiny.v);
}

static void texel_centres_survive_the_round_trip(void **state)
{
    (void)state;
    const uint32_t sides[] = {1, 2, 3, 10, 64, 255};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++)
        for (uint32_t i = 0; i < RK_FACES * sides[k] * sides[k]; i++) {
            uint32_t side = sides[k], column = i % side, row = i / side % side;
            rk_cube_face face = (rk_cube_face)(i / side / side);
            rk_vec3 direction = rk_cubemap_texel_direction(side, face, column, row);
            rk_cube_place place = rk_cubemap_place(direction);
            rk_check(place.face == face, "side %u, face %s, texel (%u, %u): got face %s", side,
                     name_of(face), column, row, name_of(place.face));
            rk_check_near(place.u, (column + 0.5) / side, few_roundings,
                          "side %u, face %s, texel (%u, %u): u, to the right", side, name_of(face),
                          column, row);
            rk_check_near(place.v, 1 - (row + 0.5) / side, few_roundings,
                          "side %u, face %s, texel (%u, %u): v, upwards", side, name_of(face),
                          column, row);
        }
}

static void places_and_directions_are_inverse(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 100000; n++) {
        rk_vec3 direction = random_direction(n);
        rk_cube_place place = rk_cubemap_place(direction);
        rk_check(place.u >= 0 && place.u <= 1 && place.v >= 0 && place.v <= 1,
                 "direction %u: (%g, %g) is not on the face", n, (double)place.u, (double)place.v);
        vec back = widen(rk_cube_direction(place.face, place.u, place.v));
        check_colour(narrow(unit(back)), direction, few_roundings,
                     "direction %u, round trip by (%g, %g) on face %s", n, (double)place.u,
                     (double)place.v, name_of(place.face));
    }
}

static const float odd[] = {0, NAN, INFINITY, -INFINITY, -0.0f, 1, 3e38f};
enum { odd_count = sizeof odd / sizeof *odd, odd_directions = odd_count * odd_count * odd_count };

static rk_vec3 odd_direction(int n)
{
    return rk_vec(odd[n % odd_count], odd[n / odd_count % odd_count],
                  odd[n / odd_count / odd_count]);
}

static void invalid_directions_stay_on_the_cube(void **state)
{
    (void)state;
    for (int n = 0; n < odd_directions; n++) {
        rk_vec3 direction = odd_direction(n);
        rk_cube_place place = rk_cubemap_place(direction);
        rk_check((int)place.face >= 0 && place.face < RK_FACES, "(%g, %g, %g): there is no face %d",
                 (double)direction.x, (double)direction.y, (double)direction.z, (int)place.face);
        rk_check(
            place.u >= 0 && place.u <= 1 && place.v >= 0 && place.v <= 1,
            "(%g, %g, %g): got (u, v) = (%g, %g), want both in [0, 1]: to_unit clamps NaN, too",
            (double)direction.x, (double)direction.y, (double)direction.z, (double)place.u,
            (double)place.v);
    }
}

/* --- Nearest ---------------------------------------------------------------------------------- */

/* Brighter than a screen's white, as skies and lamps are. */
static void radiance_above_1_is_kept(void **state)
{
    (void)state;
    const rk_vec3 bright = {10, 2.5f, 1e6f};
    rk_cubemap map = make_map(2);
    for (int i = 0; i < RK_FACES * 4; i++)
        map.faces[0][i] = bright;
    for (uint32_t n = 0; n < 100; n++)
        check_colour(rk_cubemap_at(&map, random_direction(n), RK_CUBEMAP_NEAREST), bright, 0,
                     "direction %u: all texels have the same radiance, above 1: a map holds light, "
                     "which is not clamped",
                     n);
    rk_cubemap_free(&map);
}

/* Of a place in columns and rows, and the texel got for it. */
static const char *mistake_of_texel(uint32_t side, int face, rk_vec3 got, double x, double y)
{
    const double column = floor(x), row = floor(y), top = side - 1, most = side - 1;
    for (int other = 0; other < RK_FACES; other++)
        if (other != face && got.x == (float)other)
            return said_of_face(other, face);
    return rk_mistake_in_vector(
        (const double[]){0, (double)got.y, (double)got.z}, (const double[]){0, column, row}, 0,
        RK_VECTOR_MISTAKES(
            {{0, top - row, top - column}, "u counts rows and v columns: they are exchanged"},
            {{0, row, column}, "columns and rows are exchanged"},
            {{0, column, top - row}, "rows are counted from the bottom, but row 0 is at the top"},
            {{0, top - column, row}, "columns are counted from the right"},
            {{0, top - column, top - row}, "columns are counted from the right, rows from below"},
            {{0, top - row, column}, "the face is turned by a quarter"},
            {{0, row, top - column}, "the face is turned by a quarter"},
            {{0, fmin(floor(x + 0.5), most), fmin(floor(y + 0.5), most)},
             "places are rounded, not cut: texel 0 "
             "reaches from 0 to 1"},
            {{0, fmin(floor(x + 0.5), most), most - fmin(floor(side - y + 0.5), most)},
             "places are rounded, not cut: texel 0 reaches from 0 to 1"}));
}

static void nearest_is_the_texel_that_the_direction_hits(void **state)
{
    (void)state;
    const uint32_t sides[] = {5, 1, 2, 16, 300};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t side = sides[k];
        rk_cubemap map = paint_map(side, texel_name);
        for (uint32_t n = 0; n<RK_FACES * side * side * 9; n += side> 16 ? 97 : 1) {
            /* Nine points in each texel, near its corners too; first in one whose column and row
             * each mistake makes others. */
            uint32_t all = RK_FACES * side * side * 9, i = (n + (side > 1 ? 9 : 0)) % all;
            uint32_t column = i / 9 % side, row = i / 9 / side % side, face = i / 9 / side / side;
            double x = column + 0.5 + 0.49 * (i % 3 - 1.0),
                   y = row + 0.5 + 0.49 * (i / 3 % 3 - 1.0);
            vec d = towards((int)face, 2 * x / side - 1, 1 - 2 * y / side);
            rk_vec3 got = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_NEAREST);
            check_colour_or(got, rk_vec((float)face, (float)column, (float)row), 0,
                            mistake_of_texel(side, (int)face, got, x, y),
                            "side %u, face %s, %g columns from the left, %g rows from the top, as "
                            "(face, column, row)",
                            side, cross[face].name, x, y);
        }
        rk_cubemap_free(&map);
    }
    /* On the borders of texels, whose places are exact. */
    rk_cubemap map = paint_map(4, texel_name);
    for (int face = 0; face < RK_FACES; face++)
        for (int i = 1; i < 4; i++) {
            check_colour(
                rk_cubemap_at(&map, narrow(towards(face, i / 2.0 - 1, 0.25)), RK_CUBEMAP_NEAREST),
                rk_vec((float)face, (float)i, 1), 0,
                "side 4, face %s, u = %d / 4 is in the texel to its right, as (face, "
                "column, row)",
                cross[face].name, i);
            check_colour(rk_cubemap_at(&map, narrow(towards(face, i / 2.0 - 1 - 0x1p-20, 0.25)),
                                       RK_CUBEMAP_NEAREST),
                         rk_vec((float)face, (float)(i - 1), 1), 0,
                         "side 4, face %s, u = %d / 4 - 2^-21 is left of that border, as (face, "
                         "column, row)",
                         cross[face].name, i);
            check_colour(
                rk_cubemap_at(&map, narrow(towards(face, 0.25, i / 2.0 - 1)), RK_CUBEMAP_NEAREST),
                rk_vec((float)face, 2, 3 - (float)i), 0,
                "side 4, face %s, v = %d / 4 is in the texel above it, as (face, column, "
                "row)",
                cross[face].name, i);
        }
    rk_cubemap_free(&map);
}

static void the_last_texels_reach_to_the_edge(void **state)
{
    (void)state;
    rk_cubemap map = paint_map(4, texel_name);
    /* Corners and edges that belong to x, by the rule for ties. */
    check_colour(rk_cubemap_at(&map, rk_vec(1, 1, 1), RK_CUBEMAP_NEAREST), rk_vec(RK_FACE_X, 3, 0),
                 0,
                 "side 4, face +x, u = 1, v = 1 is in the last column, the first row, as (face, "
                 "column, row)");
    check_colour(rk_cubemap_at(&map, rk_vec(1, -1, -1), RK_CUBEMAP_NEAREST),
                 rk_vec(RK_FACE_X, 0, 3), 0,
                 "side 4, face +x, u = 0, v = 0 is in the first column, the last row, as (face, "
                 "column, row)");
    check_colour(rk_cubemap_at(&map, rk_vec(-1, 1, 0.1f), RK_CUBEMAP_NEAREST),
                 rk_vec(RK_FACE_MINUS_X, 1, 0), 0,
                 "side 4, face -x, v = 1 is in the first row, as (face, column, row)");
    rk_cubemap_free(&map);
}

/* --- Bilinear --------------------------------------------------------------------------------- */

static void filters_return_the_texel_at_its_centre(void **state)
{
    (void)state;
    const uint32_t side = 6;
    rk_cubemap map = paint_map(side, noise);
    for (int filter = RK_CUBEMAP_BILINEAR; filter <= RK_CUBEMAP_SEAMLESS; filter++)
        for (uint32_t i = 0; i < RK_FACES * side * side; i++) {
            uint32_t column = i % side, row = i / side % side;
            int face = (int)(i / side / side);
            rk_vec3 d = rk_cubemap_texel_direction(side, (rk_cube_face)face, column, row);
            /* The error of u, times `side`, is the error in texels. */
            rk_vec3 scaled = rk_scale(d, ldexpf(1, 60 * (int)(i % 5) - 120));
            check_colour(
                rk_cubemap_at(&map, scaled, (rk_cubemap_filter)filter),
                noise(side, face, column, row), side * few_roundings,
                "%s, side %u, face %s, at the centre of texel (%u, %u), where each neighbour's "
                "weight is 0, by a direction of the length %g",
                filter_names[filter], side, cross[face].name, column, row,
                sqrt(dot(widen(scaled), widen(scaled))));
        }
    rk_cubemap_free(&map);
}

/* Linear across each face. */
static rk_vec3 slope(uint32_t side, int face, uint32_t column, uint32_t row)
{
    float u = ((float)column + 0.5f) / (float)side, v = 1 - ((float)row + 0.5f) / (float)side;
    return rk_vec(u, v, (float)face + 2 * u - 3 * v);
}

static void filters_are_linear_between_centres(void **state)
{
    (void)state;
    const uint32_t sides[] = {8, 129, 300};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t side = sides[k];
        rk_cubemap map = paint_map(side, slope);
        for (int filter = RK_CUBEMAP_BILINEAR; filter <= RK_CUBEMAP_SEAMLESS; filter++)
            for (int i = 0; i < RK_FACES * 400; i++) {
                /* Between the first and the last centre. */
                double x = 0.001 + 0.998 * (i % 20) / 19, y = 0.001 + 0.998 * (i / 20 % 20) / 19;
                double u = (0.5 + (side - 1) * x) / side, v = (0.5 + (side - 1) * y) / side;
                int face = i / 400;
                rk_vec3 want = narrow((vec){u, v, face + 2 * u - 3 * v});
                /* Blue reaches 7: that many times the roundings. */
                check_colour(rk_cubemap_at(&map, narrow(towards(face, 2 * u - 1, 2 * v - 1)),
                                           (rk_cubemap_filter)filter),
                             want, 7 * few_roundings,
                             "%s, side %u, face %s, (u, v) = (%g, %g): a blend of four texels",
                             filter_names[filter], side, cross[face].name, u, v);
            }
        rk_cubemap_free(&map);
    }
}

/* A map with one valid face; the others, and a face before the first and behind the last, are NaN,
 * which survives a blend with any weight. The caller frees `block`. */
static rk_cubemap lone_face(uint32_t side, int lit, rk_vec3 colour, rk_vec3 **block)
{
    size_t texels = (size_t)side * side;
    rk_cubemap map = {.side = side};
    *block = malloc((RK_FACES + 2) * texels * sizeof **block);
    rk_check(*block != NULL, "there is memory");
    for (size_t i = 0; i < (RK_FACES + 2) * texels; i++)
        (*block)[i] = i / texels == (size_t)lit + 1 ? colour : rk_vec(NAN, NAN, NAN);
    for (size_t face = 0; face < RK_FACES; face++)
        map.faces[face] = *block + (face + 1) * texels;
    return map;
}

static void check_colours_of_faces(void)
{
    rk_cubemap map = paint_map(3, one_colour_per_face);
    for (int face = 0; face < RK_FACES; face++) {
        rk_vec3 got = rk_cubemap_at(&map, narrow(cross[face].ahead), RK_CUBEMAP_BILINEAR);
        int other = got.x >= 0 && got.x < RK_FACES ? (int)got.x : face;
        rk_vec3 want = one_colour_per_face(3, face, 0, 0);
        bool is_other = other != face && distance(got, one_colour_per_face(3, other, 0, 0)) == 0;
        check_colour_or(got, want, RK_FACES * RK_FACES * few_roundings,
                        is_other ? said_of_face(other, face) : "",
                        "side 3, the middle of face %s, which has one colour", cross[face].name);
    }
    rk_cubemap_free(&map);
}

static void bilinear_stays_within_its_face(void **state)
{
    (void)state;
    check_colours_of_faces();
    const uint32_t sides[] = {1, 2, 7};
    const rk_vec3 colour = {1, 2, 3};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++)
        for (int face = 0; face < RK_FACES; face++) {
            rk_vec3 *block;
            rk_cubemap map = lone_face(sides[k], face, colour, &block);
            for (int n = 0; n < 41 * 41; n++) {
                /* Up to the edges, where they belong to this face. */
                double a = (n % 41 - 20) / 20.0, b = (n / 41 - 20) / 20.0;
                if ((int)rk_cubemap_place(narrow(towards(face, a, b))).face != face)
                    a *= 0.999, b *= 0.999;
                check_colour(
                    rk_cubemap_at(&map, narrow(towards(face, a, b)), RK_CUBEMAP_BILINEAR), colour,
                    3 * few_roundings,
                    "side %u, face %s, (u, v) = (%g, %g): no texel beyond the face is read",
                    sides[k], cross[face].name, (a + 1) / 2, (b + 1) / 2);
            }
            free(block);
        }
}

/* In which part of the face a filter has texels on one side only. */
static const char *part_of(double x, double y, double last)
{
    return x < 0   ? "left of the first centres, where x = n u - 1/2 is negative and the first "
                     "column is repeated"
           : y < 0 ? "below the first centres, where y = n v - 1/2 is negative and the lowest row "
                     "is repeated"
           : x > last ? "right of the last centres, where the last column is repeated"
           : y > last ? "above the last centres, where the highest row is repeated"
                      : "between centres";
}

/* The sum over all texels of a face, each under a tent as wide as two. x to the right and y
 * upwards, in texels from the first centre; beyond the outer centres nothing changes. */
static rk_vec3 under_tents(const rk_cubemap *map, int face, double x, double y)
{
    vec sum = {0, 0, 0};
    double last = map->side - 1;
    x = fmin(fmax(x, 0), last), y = fmin(fmax(y, 0), last);
    for (uint32_t k = 0; k < map->side * map->side; k++) {
        uint32_t column = k % map->side, row = k / map->side;
        double weight = fmax(1 - fabs(x - column), 0) * fmax(1 - fabs(last - y - row), 0);
        sum =
            combine(sum, 1, widen(*rk_cubemap_texel(map, (rk_cube_face)face, column, row)), weight);
    }
    return narrow(sum);
}

static bool is_mistake(rk_vec3 got, rk_vec3 value, rk_vec3 want, double tolerance)
{
    return distance(got, value) <= tolerance && distance(want, value) > 2 * tolerance;
}

/* Left of the first centres, or below them. */
static const char *mistake_below(const rk_cubemap *map, int face, double x, double y, bool left,
                                 rk_vec3 got, double tolerance)
{
    const double last = map->side - 1, off = left ? -x : -y;
    rk_vec3 want = under_tents(map, face, x, y);
    vec first = widen(want), next = widen(under_tents(map, face, left ? off : x, left ? y : off));
    vec other = widen(under_tents(map, face, left ? last : x, left ? y : last));
    if (!(off > 0))
        return "";
    if (is_mistake(got, narrow(combine(first, 2, next, -1)), want, tolerance))
        return RK_EXAMPLE_IF "x or y is cut towards 0, as by (int): floorf turns -0.3 into -1";
    if (is_mistake(got, narrow(combine(other, off, first, 1 - off)), want, tolerance))
        return RK_EXAMPLE_IF "the face begins again at its other edge";
    return "";
}

/* Of a place in texels from the first centre, to the right and upwards. */
static const char *mistake_of_mix(const rk_cubemap *map, int face, double x, double y, rk_vec3 got,
                                  double tolerance)
{
    const rk_vec3 want = under_tents(map, face, x, y);
    const double last = map->side - 1, i = floor(x), j = floor(y), s = x - i, t = y - j;
    const char *cut = RK_EXAMPLE_IF "i or j is cut towards 0, as by (int), but s and t are not: "
                                    "floorf turns -0.3 into -1";
    const struct {
        double x, y;
        const char *said;
    } mistakes[] = {
        {y, x, RK_EXAMPLE_IF "u and v are exchanged"},
        {i + t, j + s, RK_EXAMPLE_IF "s and t are exchanged, or i and j in texels[j][i]"},
        {j + s, i + t, RK_EXAMPLE_IF "the quad's i and j are exchanged"},
        {last - x, y, RK_EXAMPLE_IF "columns are counted from the right"},
        {x, last - y, RK_EXAMPLE_IF "rows are counted from the top, but v runs upwards"},
        {x + 0.5, y + 0.5, RK_EXAMPLE_IF "the half in x = n u - 1/2 is missing"},
        {x < 0 ? x + 1 : x, y, cut},
        {x, y < 0 ? y + 1 : y, cut},
        {x < 0 ? x + 1 : x, y < 0 ? y + 1 : y, cut},
    };
    if (distance(got, want) <= tolerance)
        return "";
    for (size_t k = 0; k < sizeof mistakes / sizeof *mistakes; k++)
        if (is_mistake(got, under_tents(map, face, mistakes[k].x, mistakes[k].y), want, tolerance))
            return mistakes[k].said;
    for (int other = 0; other < RK_FACES; other++)
        if (is_mistake(got, under_tents(map, other, x, y), want, tolerance))
            return said_of_face(other, face);
    const char *said = mistake_below(map, face, x, y, true, got, tolerance);
    return *said ? said : mistake_below(map, face, x, y, false, got, tolerance);
}

static void bilinear_mixes_the_faces_own_texels_up_to_its_edges(void **state)
{
    (void)state;
    const uint32_t sides[] = {5, 1, 2};
    enum { places = 23, all = RK_FACES * places * places };
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        rk_cubemap map = paint_map(sides[k], noise);
        for (int m = 0; m < all; m++) {
            /* First at the left edge, where each mistake gives another colour. */
            int n = (m + 7 * places) % all, face = n / (places * places);
            double u = (n % places + 0.5) / places, v = (n / places % places + 0.5) / places;
            double x = u * sides[k] - 0.5, y = v * sides[k] - 0.5;
            /* u and v are rounded; colours differ by at most 1 per texel. */
            double tolerance = 2 * (sides[k] + 1) * few_roundings;
            rk_vec3 got = rk_cubemap_at(&map, narrow(towards(face, 2 * u - 1, 2 * v - 1)),
                                        RK_CUBEMAP_BILINEAR);
            check_colour_or(got, under_tents(&map, face, x, y), tolerance,
                            mistake_of_mix(&map, face, x, y, got, tolerance),
                            "side %u, face %s, (u, v) = (%.3g, %.3g), %s", sides[k],
                            cross[face].name, u, v, part_of(x, y, sides[k] - 1));
        }
        rk_cubemap_free(&map);
    }
}

/* --- Seamless --------------------------------------------------------------------------------- */

/* The mean of the `count` texels whose centres are nearest to a direction, by a search of all in
 * these columns and rows. */
static rk_vec3 mean_of_nearest_at(const rk_cubemap *map, const uint32_t *places, uint32_t n, vec d,
                                  int count)
{
    rk_vec3 colours[4];
    double cosines[4];
    uint32_t side = map->side;
    int found = 0;
    d = unit(d);
    for (uint32_t i = 0; i < RK_FACES * n * n; i++) {
        uint32_t column = places[i % n], row = places[i / n % n];
        int face = (int)(i / n / n), place = found;
        vec centre = towards(face, (2 * column + 1.0) / side - 1, 1 - (2 * row + 1.0) / side);
        double cosine = dot(unit(centre), d);
        for (; place > 0 && cosines[place - 1] < cosine; place--)
            if (place < count) {
                cosines[place] = cosines[place - 1];
                colours[place] = colours[place - 1];
            }
        if (place < count) {
            cosines[place] = cosine;
            colours[place] = *rk_cubemap_texel(map, (rk_cube_face)face, column, row);
            found += found < count;
        }
    }
    rk_vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; i++)
        sum = rk_add(sum, rk_scale(colours[i], 1 / (float)count));
    return sum;
}

static rk_vec3 mean_of_nearest(const rk_cubemap *map, vec d, int count)
{
    uint32_t all[16];
    rk_check(map->side <= 16, "a map of %u texels per side takes long to search", map->side);
    for (uint32_t i = 0; i < map->side; i++)
        all[i] = i;
    return mean_of_nearest_at(map, all, map->side, d, count);
}

static void within_a_face_seamless_is_bilinear(void **state)
{
    (void)state;
    const uint32_t side = 9;
    rk_cubemap map = paint_map(side, noise);
    vec between = towards(RK_FACE_Y, 1.0 / 9, 1.0 / 9); /* the common corner of four texels */
    check_colour(rk_cubemap_at(&map, narrow(between), RK_CUBEMAP_SEAMLESS),
                 mean_of_nearest(&map, between, 4), side * few_roundings,
                 "side 9, face +y, (u, v) = (5/9, 5/9), the mean of the four texels around it");
    for (uint32_t n = 0; n < 6000; n++) {
        rk_vec3 d = random_direction(n);
        rk_cube_place place = rk_cubemap_place(d);
        if (fabsf(place.u - 0.5f) > 0.44f || fabsf(place.v - 0.5f) > 0.44f)
            continue;
        rk_vec3 a = rk_cubemap_at(&map, d, RK_CUBEMAP_BILINEAR);
        rk_vec3 b = rk_cubemap_at(&map, d, RK_CUBEMAP_SEAMLESS);
        rk_vec3 c = rk_cubemap_at(&map, d, RK_CUBEMAP_NEAREST);
        rk_check(memcmp(&a, &b, sizeof a) == 0,
                 "side 9, face %s, (u, v) = (%g, %g): bilinear (%.9g, %.9g, %.9g), seamless (%.9g, "
                 "%.9g, %.9g), not the same to the bit",
                 name_of(place.face), (double)place.u, (double)place.v, (double)a.x, (double)a.y,
                 (double)a.z, (double)b.x, (double)b.y, (double)b.z);
        rk_check(
            distance(a, c) < 1,
            "side 9, face %s, (u, v) = (%g, %g): (%g, %g, %g) is no blend of colours in [0, 1]",
            name_of(place.face), (double)place.u, (double)place.v, (double)a.x, (double)a.y,
            (double)a.z);
    }
    rk_cubemap_free(&map);
}

/* What a colour at an edge or a corner tells: that of one texel comes from a lookup within the
 * face. */
static const char *is_own_texel(rk_vec3 own, rk_vec3 got, uint32_t side)
{
    return distance(got, own) <= side * few_roundings ? "; that is the face's own texel alone" : "";
}

/* Names the texel that is mixed with the face's own one, half and half; or "". */
static const char *other_half(const rk_cubemap *map, rk_vec3 own, rk_vec3 mean, char text[60])
{
    const uint32_t side = map->side;
    rk_vec3 other = narrow(combine(widen(mean), 2, widen(own), -1));
    for (uint32_t i = 0; i < RK_FACES * side * side; i++) {
        uint32_t column = i % side, row = i / side % side;
        rk_cube_face face = (rk_cube_face)(i / side / side);
        if (distance(*rk_cubemap_texel(map, face, column, row), other) > 2 * side * few_roundings)
            continue;
        snprintf(text, 60, "texel (%u, %u) of face %s", column, row, name_of(face));
        return text;
    }
    return "";
}

static const char *mistake_at_edge(const rk_cubemap *map, rk_vec3 own, rk_vec3 got, rk_vec3 want)
{
    static char said[200];
    char texels[2][60];
    const char *is_own = is_own_texel(own, got, map->side);
    if (distance(got, want) <= map->side * few_roundings || *is_own)
        return is_own;
    if (!*other_half(map, own, got, texels[0]) || !*other_half(map, own, want, texels[1]))
        return "";
    snprintf(said, sizeof said, "; its other half is %s, want %s", texels[0], texels[1]);
    return said;
}

static void an_edge_is_the_mean_of_the_two_texels_beside_it(void **state)
{
    (void)state;
    const uint32_t sides[] = {2, 3, 8};
    const int left = 0, right = 1, below = 2, above = 3;
    const char *const edges[] = {"left", "right", "lower", "upper"};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t side = sides[k];
        rk_cubemap map = paint_map(side, noise);
        for (int face = 0; face < RK_FACES; face++)
            for (int edge = left; edge <= above; edge++)
                for (uint32_t i = 0; i < side; i++) {
                    double along = (2 * i + 1.0) / side - 1;
                    double a = edge == left ? -1 : edge == right ? 1 : along;
                    double b = edge == below ? -1 : edge == above ? 1 : along;
                    vec d = towards(face, a, b);
                    rk_vec3 got = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_SEAMLESS);
                    rk_vec3 own = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_NEAREST);
                    rk_vec3 want = mean_of_nearest(&map, d, 2);
                    check_colour_or(got, want, side * few_roundings,
                                    mistake_at_edge(&map, own, got, want),
                                    "side %u, face %s, middle of texel %u of its %s edge: the mean "
                                    "of the texels on both sides",
                                    side, cross[face].name, i, edges[edge]);
                }
        rk_cubemap_free(&map);
    }
}

static void a_corner_is_the_mean_of_the_three_texels_around_it(void **state)
{
    (void)state;
    const uint32_t sides[] = {1, 2, 5};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        rk_cubemap map = paint_map(sides[k], noise);
        for (int sign = 0; sign < 8; sign++)
            for (int axis = 0; axis < 3; axis++) {
                vec d = {sign & 1 ? -1 : 1, sign & 2 ? -1 : 1, sign & 4 ? -1 : 1};
                vec want = d;
                /* From each of the three faces, a few floats away from the corner. */
                double *component = axis == 0 ? &d.x : axis == 1 ? &d.y : &d.z;
                *component *= 1 + 0x1p-22;
                rk_vec3 got = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_SEAMLESS);
                rk_vec3 own = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_NEAREST);
                check_colour_or(
                    got, mean_of_nearest(&map, want, 3), sides[k] * few_roundings,
                    is_own_texel(own, got, sides[k]),
                    "side %u, corner (%g, %g, %g), on face %s: the mean of the three texels "
                    "around it",
                    sides[k], want.x, want.y, want.z, name_of(rk_cubemap_place(narrow(d)).face));
            }
        rk_cubemap_free(&map);
    }
}

/* The neighbour's texel beyond the edge, from the mean of both. */
static vec texel_across(const rk_cubemap *map, vec own, vec edge)
{
    return combine(widen(mean_of_nearest(map, edge, 2)), 2, own, -1);
}

static void seamless_is_linear_from_the_outer_centres_to_the_edges(void **state)
{
    (void)state;
    const uint32_t sides[] = {1, 2, 5};
    const double fractions[] = {0, 0.125, 0.25, 0.4}; /* of the texels beyond: 1/2 is the edge */
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        rk_cubemap map = paint_map(sides[k], noise);
        double texel = 2.0 / sides[k], centre = 1 - texel / 2;
        for (int n = 0; n < RK_FACES * 4 * 16; n++) {
            /* The corner texel, and those beyond its two edges. */
            int face = n / 64;
            double a = n & 1 ? 1 : -1, b = n & 2 ? 1 : -1;
            double s = fractions[n / 4 % 4], t = fractions[n / 16 % 4];
            vec own = widen(rk_cubemap_at(&map, narrow(towards(face, a * centre, b * centre)),
                                          RK_CUBEMAP_NEAREST));
            vec across = texel_across(&map, own, towards(face, a, b * centre));
            vec along = texel_across(&map, own, towards(face, a * centre, b));
            vec mean = combine(combine(own, 1.0 / 3, across, 1.0 / 3), 1, along, 1.0 / 3);
            vec want =
                combine(combine(own, 1 - s, across, s), 1 - t, combine(along, 1 - s, mean, s), t);
            vec d = towards(face, a * (centre + s * texel), b * (centre + t * texel));
            check_colour(rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_SEAMLESS), narrow(want),
                         2 * (sides[k] + 1) * few_roundings,
                         "side %u, face %s, %g texels from the corner texel's centre to the %s "
                         "edge and %g to the %s one: a mix of four, as within a face",
                         sides[k], cross[face].name, s, a < 0 ? "left" : "right", t,
                         b < 0 ? "lower" : "upper");
        }
        rk_cubemap_free(&map);
    }
}

static void one_colour_stays_one_colour(void **state)
{
    (void)state;
    /* Light may be much brighter than white, and colours outside of a screen's are negative. */
    const rk_vec3 colours[] = {{0.25f, 0.5f, 4}, {1e30f, 1e-30f, -2}};
    rk_cubemap map = make_map(3);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < RK_FACES * 9; i++)
            map.faces[0][i] = colours[k];
        for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++)
            for (uint32_t n = 0; n < 10000; n++) {
                rk_vec3 got = rk_cubemap_at(&map, random_direction(n), (rk_cubemap_filter)filter);
                for (int axis = 0; axis < 3; axis++) {
                    double want = (double)rk_axis(colours[k], axis);
                    rk_check_near(rk_axis(got, axis), want, few_roundings * fabs(want),
                                  "side 3, all texels alike, %s, direction %u, colour %d: weights "
                                  "sum to one",
                                  filter_names[filter], n, axis);
                }
            }
    }
    rk_cubemap_free(&map);
}

typedef struct step {
    double size;
    vec at; /* on the edge */
} step;

/* The largest difference of colours across the cube's edges and around its corners, over pairs of
 * directions that are two millionths apart. */
static step largest_step(const rk_cubemap *map, rk_cubemap_filter filter, int steps)
{
    const double near = 1e-6;
    step largest = {0, {0, 0, 0}};
    for (int face = 0; face < RK_FACES; face++)
        for (int edge = 0; edge < 4; edge++)
            for (int i = -steps; i <= steps; i++) {
                /* Closest at the edge's ends, which are corners. */
                double along = sin(i * pi / (2 * steps + 2)), edge_at = edge & 1 ? 1 : -1;
                double in = edge_at * (1 - near), out = edge_at * (1 + near);
                bool upright = edge & 2;
                vec a = upright ? towards(face, in, along) : towards(face, along, in);
                vec b = upright ? towards(face, out, along) : towards(face, along, out);
                double size = distance(rk_cubemap_at(map, narrow(a), filter),
                                       rk_cubemap_at(map, narrow(b), filter));
                if (size > largest.size)
                    largest = (step){size, combine(a, 0.5, b, 0.5)};
            }
    return largest;
}

static void colours_are_continuous_at_edges_and_corners(void **state)
{
    (void)state;
    const uint32_t sides[] = {1, 2, 3, 16, 257};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t side = sides[k];
        rk_cubemap map = paint_map(side, noise);
        /* Colours in [0, 1] change by at most 1 per texel, over `side` texels in 2 units, in both
         * directions; twice, because the two points are on different faces. */
        double slope_allows = 2e-6 * side * 2, floats_allow = side * few_roundings;
        step found = largest_step(&map, RK_CUBEMAP_SEAMLESS, 400);
        rk_check(found.size <= slope_allows + floats_allow,
                 "side %u, on the edge at (%.4g, %.4g, %.4g), noise: a step of %g between "
                 "directions 2e-6 apart, want %.3g at most: the two faces must blend the same "
                 "texels by the same weights",
                 side, found.at.x, found.at.y, found.at.z, found.size, slope_allows + floats_allow);
        rk_check(largest_step(&map, RK_CUBEMAP_BILINEAR, 50).size > 0.5,
                 "bilinear within a face must have a step here, or this test detects none");
        rk_cubemap_free(&map);
    }
}

static void colours_are_continuous_around_a_corner(void **state)
{
    (void)state;
    const uint32_t side = 6;
    rk_cubemap map = paint_map(side, noise);
    for (int sign = 0; sign < 8; sign++)
        for (int circle = 1; circle <= 10; circle += 3) {
            vec corner = unit((vec){sign & 1 ? -1 : 1, sign & 2 ? -1 : 1, sign & 4 ? -1 : 1});
            vec a = unit((vec){corner.y, -corner.x, 0});
            vec b = {corner.y * a.z - corner.z * a.y, corner.z * a.x - corner.x * a.z,
                     corner.x * a.y - corner.y * a.x};
            double radius = 0.03 * circle;
            check_colour(rk_cubemap_at(&map, narrow(corner), RK_CUBEMAP_SEAMLESS),
                         mean_of_nearest(&map, corner, 3), side * few_roundings,
                         "side 6, corner (%.3g, %.3g, %.3g), the circle's middle", corner.x,
                         corner.y, corner.z);
            rk_vec3 last = {0, 0, 0};
            for (int i = 0; i <= 3000; i++) {
                double angle = 2 * pi * i / 3000;
                vec d = combine(combine(a, cos(angle), b, sin(angle)), radius, corner, 1);
                rk_vec3 next = rk_cubemap_at(&map, narrow(d), RK_CUBEMAP_SEAMLESS);
                /* An arc of 2 pi radius / 3000 at distance 1 is up to 3 times as long on the cube,
                 * where a unit has side / 2 texels; the slope is 1 per texel in both directions. */
                double most = 2 * pi * radius / 3000 * 3 * side / 2 * 2 + side * few_roundings;
                if (i > 0)
                    check_colour(next, last, most,
                                 "side 6, a circle of %g radians around the corner (%.3g, %.3g, "
                                 "%.3g), a step of a 3000th at (%.4g, %.4g, %.4g)",
                                 radius, corner.x, corner.y, corner.z, d.x, d.y, d.z);
                last = next;
            }
        }
    rk_cubemap_free(&map);
}

static void a_smooth_function_comes_back_everywhere(void **state)
{
    (void)state;
    const uint32_t sides[] = {4, 16, 200};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t side = sides[k];
        rk_cubemap map = paint_map(side, smooth_texel);
        /* All texels of a blend have their centres within one texel's diagonal, 2 sqrt(2) / side;
         * beyond edges and corners, where the cube bends, within one and a half. */
        double reach = 1.5 * 2 * sqrt(2) / side;
        for (uint32_t n = 0; n < 6000; n++) {
            /* On all of the sphere, then near edges. */
            vec d = widen(random_direction(n));
            if (n & 1) {
                d.x = copysign(1, d.x);
                d.y = copysign(1 + 0.1 * d.z * d.z * d.z, d.y);
            }
            if (n & 2)
                d = (vec){d.z, d.x, d.y};
            for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++)
                check_colour(rk_cubemap_at(&map, narrow(d), (rk_cubemap_filter)filter),
                             narrow(smooth(d)), steepest * reach,
                             "side %u, %s, (%.4g, %.4g, %.4g), on face %s: a map of a smooth "
                             "function is that function, up to a texel's size",
                             side, filter_names[filter], d.x, d.y, d.z,
                             name_of(rk_cubemap_place(narrow(d)).face));
        }
        rk_cubemap_free(&map);
    }
}

static rk_vec3 other_noise(uint32_t side, int face, uint32_t column, uint32_t row)
{
    return noise(side + 5, face, column, row);
}

/* The face's own texels and, by `seamless`, their neighbours on the edge between the faces of x and
 * z: side 4, at a quarter of the way from the centre at y to the next one. */
static rk_vec3 on_an_edge(const rk_cubemap *map, rk_vec3 d, rk_cubemap_filter filter)
{
    int count = filter == RK_CUBEMAP_SEAMLESS ? 2 : 1;
    double aside = filter == RK_CUBEMAP_SEAMLESS ? 1 : 1.001, y = (double)d.y - 0.125;
    vec at = {(double)d.x * aside, y, (double)d.z}, above = {at.x, y + 0.5, at.z};
    vec nearer = widen(mean_of_nearest(map, at, count));
    vec farther = widen(mean_of_nearest(map, above, count));
    return narrow(filter == RK_CUBEMAP_NEAREST ? nearer : combine(nearer, 0.75, farther, 0.25));
}

static void check_constant_map(void)
{
    rk_cubemap own = paint_map(4, noise), shared = {.side = 4};
    const size_t bytes = 4 * 4 * sizeof(rk_vec3);
    for (int face = 0; face < RK_FACES; face++)
        shared.faces[face] = (rk_vec3 *)rk_read_only(own.faces[face], bytes, "face");
    const rk_cubemap *map = rk_read_only(&shared, sizeof shared, "map");
    for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++)
        rk_cubemap_at(map, rk_vec(1, 0.9f, -0.9f), (rk_cubemap_filter)filter);
    rk_read_only_free();
    rk_cubemap_free(&own);
}

static void each_input_counts_at_each_lookup(void **state)
{
    (void)state;
    check_constant_map();
    const uint32_t side = 4;
    /* Each differs from the one before in one component. */
    const rk_vec3 directions[] = {{1, -0.125f, 1},  {-1, -0.125f, 1}, {-1, 0.375f, 1},
                                  {-1, 0.375f, -1}, {1, 0.375f, -1},  {1, -0.125f, -1}};
    rk_cubemap maps[] = {paint_map(side, noise), paint_map(side, other_noise)};
    size_t bytes = RK_FACES * side * side * sizeof(rk_vec3);
    rk_vec3 *before = malloc(bytes);
    rk_check(before != NULL, "there is memory");
    for (int repainted = 0; repainted < 2; repainted++) {
        if (repainted) /* in the same memory */
            for (uint32_t i = 0; i < RK_FACES * side * side; i++)
                maps[0].faces[0][i] = rk_scale(maps[0].faces[0][i], 0.5f);
        memcpy(before, maps[0].faces[0], bytes);
        /* The map, the filter or the direction changes from each lookup to the next. */
        for (int fastest = 0; fastest < 3; fastest++)
            for (int n = 0; n < 2 * 3 * 6; n++) {
                int m = fastest == 0 ? n % 2 : n / 18;
                int filter = fastest == 1 ? n % 3 : fastest == 0 ? n / 2 % 3 : n / 6 % 3;
                int k = fastest == 2 ? n % 6 : fastest == 0 ? n / 6 : n / 3 % 6;
                rk_vec3 d = directions[k];
                check_colour(rk_cubemap_at(&maps[m], d, (rk_cubemap_filter)filter),
                             on_an_edge(&maps[m], d, (rk_cubemap_filter)filter),
                             side * few_roundings,
                             "side 4, (%g, %g, %g), %s, map %d%s, after a lookup in another %s",
                             (double)d.x, (double)d.y, (double)d.z, filter_names[filter], m,
                             repainted ? " repainted" : "",
                             fastest == 0   ? "map"
                             : fastest == 1 ? "filter"
                                            : "direction");
            }
        rk_check(memcmp(before, maps[0].faces[0], bytes) == 0,
                 "a lookup changed the map, which is constant, and read by other threads");
    }
    free(before);
    rk_cubemap_free(&maps[0]);
    rk_cubemap_free(&maps[1]);
}

static void invalid_directions_have_a_colour(void **state)
{
    (void)state;
    rk_cubemap map = paint_map(3, one_colour_per_face);
    for (int n = 0; n < odd_directions; n++)
        for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++) {
            rk_vec3 direction = odd_direction(n);
            rk_check(isfinite(rk_cubemap_at(&map, direction, (rk_cubemap_filter)filter).x),
                     "(%g, %g, %g), %s: the colour is not a number", (double)direction.x,
                     (double)direction.y, (double)direction.z, filter_names[filter]);
        }
    rk_cubemap_free(&map);
}

/* --- The largest maps ---------------------------------------------------------------------------
 */

/* Some columns or rows, the first and the last among them; the last minus any of them is another
 * one, so that neighbours across an edge are among them, too. */
enum { PLACES = 6 };

static void fill_places(uint32_t side, uint32_t places[PLACES])
{
    const uint32_t some[] = {0, 1, side / 3};
    for (int k = 0; k < PLACES; k++)
        places[k] = k < PLACES / 2 ? some[k] : side - 1 - some[k - PLACES / 2];
}

/* A map of which only the texels at those places have memory: the rest is mapped, but never
 * touched. All faces share one, or they would not fit into the memory that a test may map. */
static rk_cubemap sparse_map(uint32_t side, const uint32_t places[PLACES])
{
    size_t size = (size_t)side * side * sizeof(rk_vec3);
    int flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, flags, -1, 0);
    rk_check(memory != MAP_FAILED, "no addresses for %zu bytes", size);
    rk_cubemap map = {.side = side};
    for (int face = 0; face < RK_FACES; face++)
        map.faces[face] = memory;
    for (uint32_t k = 0; k < PLACES * PLACES; k++) {
        uint32_t column = places[k % PLACES], row = places[k / PLACES];
        *rk_cubemap_texel(&map, RK_FACE_X, column, row) = noise(side, 0, column, row);
    }
    return map;
}

static void check_centres(const rk_cubemap *map, const uint32_t places[PLACES], int face,
                          int filter)
{
    const uint32_t side = map->side;
    for (uint32_t k = 0; k < PLACES * PLACES; k++) {
        uint32_t column = places[k % PLACES], row = places[k / PLACES];
        rk_vec3 d = rk_cubemap_texel_direction(side, (rk_cube_face)face, column, row);
        check_colour(rk_cubemap_at(map, d, (rk_cubemap_filter)filter), noise(side, 0, column, row),
                     filter == RK_CUBEMAP_NEAREST ? 0 : side * few_roundings,
                     "%s, side %u, face %s, at the centre of texel (%u, %u)", filter_names[filter],
                     side, cross[face].name, column, row);
    }
}

/* In the middle of texels at an edge, and in the corners at its ends. */
static void check_an_edge(const rk_cubemap *map, const uint32_t places[PLACES], int face, int edge)
{
    const uint32_t side = map->side;
    for (uint32_t k = 0; k < PLACES + 2; k++) {
        bool corner = k >= PLACES;
        double along = corner ? 2.0 * (k - PLACES) - 1 : (2.0 * places[k] + 1) / side - 1;
        double across = edge & 1 ? 1 : -1;
        vec d = edge < 2 ? towards(face, across, along) : towards(face, along, across);
        check_colour(rk_cubemap_at(map, narrow(d), RK_CUBEMAP_SEAMLESS),
                     mean_of_nearest_at(map, places, PLACES, d, corner ? 3 : 2),
                     side * few_roundings,
                     "seamless, side %u, at (%g, %g, %g) on %s of the cube: the mean of the texels "
                     "around it",
                     side, d.x, d.y, d.z, corner ? "a corner" : "an edge");
    }
}

static void the_largest_maps_have_all_their_texels(void **state)
{
    (void)state;
    const uint32_t sides[] = {2049, 4100, RK_CUBEMAP_SIDE_MAX};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        uint32_t places[PLACES];
        fill_places(sides[k], places);
        rk_cubemap map = sparse_map(sides[k], places);
        for (int face = 0; face < RK_FACES; face++) {
            for (int filter = RK_CUBEMAP_NEAREST; filter <= RK_CUBEMAP_SEAMLESS; filter++)
                check_centres(&map, places, face, filter);
            for (int edge = 0; edge < 4; edge++)
                check_an_edge(&map, places, face, edge);
        }
        munmap(map.faces[0], (size_t)sides[k] * sides[k] * sizeof(rk_vec3));
    }
}

static void lookups_allocate_no_memory(void **state)
{
    (void)state;
    if (!rk_allocations_are_counted)
        return;
    rk_cubemap map = paint_map(4, noise);
    for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++) {
        size_t before = rk_allocations;
        for (uint32_t n = 0; n < 1000; n++)
            rk_cubemap_at(&map, random_direction(n), (rk_cubemap_filter)filter);
        size_t allocated = rk_allocations - before;
        rk_check(allocated == 0, "%s: 1000 lookups allocated memory %zu times, want 0",
                 filter_names[filter], allocated);
    }
    rk_cubemap_free(&map);
}

/* --- Solid angles ----------------------------------------------------------------------------- */

static void a_face_is_a_sixth_of_the_sphere(void **state)
{
    (void)state;
    rk_check_near(rk_cubemap_solid_angle(1, 0, 0), 4 * pi / 6, 1e-14, "a whole face");
    for (uint32_t i = 0; i < 4; i++)
        rk_check_near(rk_cubemap_solid_angle(2, i & 1, i >> 1), 4 * pi / 24, 1e-14,
                      "side 2, texel (%u, %u), a quarter of a face", i & 1, i >> 1);
}

static void solid_angles_sum_to_the_sphere(void **state)
{
    (void)state;
    const uint32_t sides[] = {1, 2, 3, 10, 101, 512};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        double sum = 0;
        for (uint32_t row = 0; row < sides[k]; row++)
            for (uint32_t column = 0; column < sides[k]; column++) {
                double angle = rk_cubemap_solid_angle(sides[k], column, row);
                rk_check(angle > 0, "side %u: texel (%u, %u) covers %g, want more than 0", sides[k],
                         column, row, angle);
                sum += angle;
            }
        /* Four roundings per texel, of numbers up to 1/2. */
        rk_check_near(RK_FACES * sum, 4 * pi, 4 * 0x1p-54 * RK_FACES * sides[k] * sides[k] + 1e-14,
                      "side %u: the sum over all texels of six faces", sides[k]);
    }
}

/* A texel's solid angle is the integral of 1 / (1 + x^2 + y^2)^(3/2): here by the midpoint rule. */
static double integral(uint32_t side, uint32_t column, uint32_t row, int parts)
{
    double width = 2.0 / side / parts, sum = 0;
    for (int i = 0; i < parts; i++)
        for (int j = 0; j < parts; j++) {
            double x = 2.0 * column / side - 1 + (i + 0.5) * width;
            double y = 2.0 * row / side - 1 + (j + 0.5) * width;
            sum += pow(1 + x * x + y * y, -1.5) * width * width;
        }
    return sum;
}

static void a_texels_solid_angle_is_its_integral(void **state)
{
    (void)state;
    const uint32_t sides[] = {3, 7, 32};
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++)
        for (uint32_t i = 0; i < sides[k] * sides[k]; i++) {
            uint32_t column = i % sides[k], row = i / sides[k];
            /* The midpoint rule's error is width^2 / 24 of the second derivatives, at most 6 of the
             * value, so less than 1e-3 of it for 150 steps or more across. */
            double want = integral(sides[k], column, row, 50);
            rk_check_near(rk_cubemap_solid_angle(sides[k], column, row), want, 1e-3 * want,
                          "side %u, texel (%u, %u), against the midpoint rule", sides[k], column,
                          row);
        }
    /* In the largest map, seven digits of the differences are left. */
    const uint32_t corner = RK_CUBEMAP_SIDE_MAX - 1;
    double smallest = integral(RK_CUBEMAP_SIDE_MAX, 0, corner, 1);
    rk_check_near(rk_cubemap_solid_angle(RK_CUBEMAP_SIDE_MAX, 0, corner), smallest, 1e-6 * smallest,
                  "side %d, texel (0, %u), the smallest of all", RK_CUBEMAP_SIDE_MAX, corner);
    /* Not a power of two, so that coordinates are rounded. */
    const uint32_t side = 8191, places[] = {0, 1, 1000, 4095, 8190};
    for (uint32_t i = 0; i < 25; i++) {
        uint32_t column = places[i % 5], row = places[i / 5];
        double want = integral(side, column, row, 1);
        rk_check_near(rk_cubemap_solid_angle(side, column, row), want, 1e-6 * want,
                      "side %u, texel (%u, %u), against the midpoint rule", side, column, row);
    }
}

static void solid_angles_weight_integrals_over_the_sphere(void **state)
{
    (void)state;
    /* The integrals over the sphere of x^2 and of y^4 are 4 pi / 3 and 4 pi / 5. */
    const uint32_t side = 128;
    double square = 0, fourth = 0;
    for (uint32_t i = 0; i < RK_FACES * side * side; i++) {
        uint32_t column = i % side, row = i / side % side;
        rk_cube_face face = (rk_cube_face)(i / side / side);
        vec d = unit(widen(rk_cubemap_texel_direction(side, face, column, row)));
        double angle = rk_cubemap_solid_angle(side, column, row);
        square += d.x * d.x * angle;
        fourth += d.y * d.y * d.y * d.y * angle;
    }
    /* The midpoint's error is the square of a texel's size, 2^-12. */
    rk_check_near(square, 4 * pi / 3, 0x1p-12, "side 128: x^2 over the sphere");
    rk_check_near(fourth, 4 * pi / 5, 0x1p-12, "side 128: y^4 over the sphere");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_largest_component_chooses_the_face),
    cmocka_unit_test(on_edges_x_comes_before_y_before_z),
    cmocka_unit_test(u_runs_to_the_right_and_v_upwards),
    cmocka_unit_test(the_length_of_a_direction_does_not_matter),
    cmocka_unit_test(texel_centres_survive_the_round_trip),
    cmocka_unit_test(places_and_directions_are_inverse),
    cmocka_unit_test(invalid_directions_stay_on_the_cube),
    cmocka_unit_test(radiance_above_1_is_kept),
    cmocka_unit_test(nearest_is_the_texel_that_the_direction_hits),
    cmocka_unit_test(the_last_texels_reach_to_the_edge),
    cmocka_unit_test(filters_return_the_texel_at_its_centre),
    cmocka_unit_test(filters_are_linear_between_centres),
    cmocka_unit_test(bilinear_stays_within_its_face),
    cmocka_unit_test(bilinear_mixes_the_faces_own_texels_up_to_its_edges),
    cmocka_unit_test(within_a_face_seamless_is_bilinear),
    cmocka_unit_test(an_edge_is_the_mean_of_the_two_texels_beside_it),
    cmocka_unit_test(each_input_counts_at_each_lookup),
    cmocka_unit_test(a_corner_is_the_mean_of_the_three_texels_around_it),
    cmocka_unit_test(seamless_is_linear_from_the_outer_centres_to_the_edges),
    cmocka_unit_test(one_colour_stays_one_colour),
    cmocka_unit_test(colours_are_continuous_at_edges_and_corners),
    cmocka_unit_test(colours_are_continuous_around_a_corner),
    cmocka_unit_test(a_smooth_function_comes_back_everywhere),
    cmocka_unit_test(a_face_is_a_sixth_of_the_sphere),
    cmocka_unit_test(solid_angles_sum_to_the_sphere),
    cmocka_unit_test(a_texels_solid_angle_is_its_integral),
    cmocka_unit_test(solid_angles_weight_integrals_over_the_sphere),
    cmocka_unit_test(invalid_directions_have_a_colour),
    cmocka_unit_test(the_largest_maps_have_all_their_texels),
    cmocka_unit_test(lookups_allocate_no_memory),
};

RK_SUITE("cubemap", tests)
