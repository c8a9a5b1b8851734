/* Ambient occlusion: directions above a surface, their weights, directions into the surface, and
 * the agreement of both maps' estimates with closed forms. Random numbers have fixed seeds; a
 * correct unit would fail a statistical test for one seed in a million. */
#include "test.h"

#include "base/dvec3.h"
#include "base/random.h"
#include "features/ambient_occlusion.h"
#include "features/glossy_reflection.h"

static const double pi = RK_PI_DOUBLE;

/* A number in [0, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_case(a, b, c, 11));
}

static rk_vec2 noise2(uint32_t a, uint32_t b)
{
    return (rk_vec2){noise(a, b, 0), noise(a, b, 1)};
}

static rk_vec3 narrow(rk_dvec3 v)
{
    return rk_vec((float)v.x, (float)v.y, (float)v.z);
}

/* The unit vector at the angle theta to the z axis, and phi around it. */
static rk_dvec3 polar(double theta, double phi)
{
    return (rk_dvec3){sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
}

/* Uniform over the sphere. */
static rk_vec3 noise_direction(uint32_t a, uint32_t b)
{
    return narrow(polar(acos(2 * (double)noise(a, b, 2) - 1), 2 * pi * (double)noise(a, b, 3)));
}

static const rk_ambient_map maps[] = {RK_AMBIENT_UNIFORM, RK_AMBIENT_COSINE};
static const char *const map_names[] = {
    [RK_AMBIENT_UNIFORM] = "uniform", [RK_AMBIENT_COSINE] = "cosine"};

/* --- Directions around the z axis ------------------------------------------------------------- */

/* A squared length is a sum of three squares, each rounded a few times by half of 2^-23 or less. */
static const double length_rounding = 8 * 0x1p-24;

static void check_direction(rk_ambient_map map, rk_vec2 xi)
{
    rk_vec3 d = rk_ambient_hemisphere(map, xi);
    rk_dvec3 wide = rk_widen(d);
    rk_check_near(rk_ddot(wide, wide), 1, length_rounding,
                  "%s map of xi (%.9g, %.9g): the squared length of (%.9g, %.9g, %.9g)",
                  map_names[map], (double)xi.x, (double)xi.y, (double)d.x, (double)d.y,
                  (double)d.z);
    rk_check(map == RK_AMBIENT_UNIFORM ? d.z > 0 : d.z >= 0,
             "%s map of xi (%.9g, %.9g): z is %.9g, not above the horizon", map_names[map],
             (double)xi.x, (double)xi.y, (double)d.z);
}

/* Inside the unit square, and on its edges, where square roots of 0 occur. */
static void check_directions(rk_ambient_map map)
{
    rk_vec3 a = rk_ambient_hemisphere(map, (rk_vec2){0.25f, 0.5f});
    rk_vec3 b = rk_ambient_hemisphere(map, (rk_vec2){0.75f, 0.5f});
    rk_vec3 c = rk_ambient_hemisphere(map, (rk_vec2){0.5f, 0.75f});
    rk_check(rk_length(rk_sub(a, b)) > 0.1f && rk_length(rk_sub(a, c)) > 0.1f,
             "xi (.25, .5), (.75, .5) and (.5, .75) have nearly the same direction");
    for (uint32_t i = 0; i < 100000; i++)
        check_direction(map, noise2(1, i));
    for (uint32_t i = 0; i <= 4096; i++)
        for (int edge = 0; edge < 4; edge++) {
            float along = (float)i / 4097, end = edge % 2 ? 1 - 0x1p-24f : 0;
            check_direction(map, edge < 2 ? (rk_vec2){end, along} : (rk_vec2){along, end});
        }
}

enum { side = 16, cells = side * side, points = 256 * 1000 };

static uint32_t counts[cells];

/* Equally likely cells: by height, or by its square, and by angle. */
static void count_in_cells(rk_ambient_map map, bool squared)
{
    memset(counts, 0, sizeof counts);
    for (uint32_t i = 0; i < points; i++) {
        rk_vec3 d = rk_ambient_hemisphere(map, noise2(2 + (uint32_t)map, i));
        double z = (double)d.z, around = atan2((double)d.y, (double)d.x) / (2 * pi) + 0.5;
        int zone = (int)fmax(fmin((squared ? z * z : z) * side, side - 1), 0);
        counts[zone * side + (int)fmin(around * side, side - 1)]++;
    }
}

static void check_cells(rk_ambient_map map, bool squared, const char *hint)
{
    double chi2 = 0, want = (double)points / cells;
    int worst = 0;
    count_in_cells(map, squared);
    for (int i = 0; i < cells; i++) {
        chi2 += (counts[i] - want) * (counts[i] - want) / want;
        if (fabs(counts[i] - want) > fabs(counts[worst] - want))
            worst = i;
    }
    /* 255 degrees of freedom: above 378 once in a million times, below 161 as rarely. */
    rk_check(chi2 > 161 && chi2 < 378,
             "%s map: chi^2 of %d directions in %d equally likely cells is %.1f, want 161 "
             "to 378; zone %d of %d from the horizon, at %d degrees, got %u, want about %.0f: %s",
             map_names[map], points, cells, chi2, worst / side + 1, side,
             (int)(worst % side * 360.0 / side) - 180, counts[worst], want, hint);
}

/* A number uniform in [0, 1] is below 2^-k, or above 1 - 2^-k, with the probability 2^-k; a cell
 * would hide that it is not. */
enum { first_end = 5, last_end = 12 };

static void count_ends(uint32_t ends[2][last_end + 1], double number)
{
    double near = fmin(number, 1 - number);
    for (int k = first_end; k <= last_end && near < ldexp(1, -k); k++)
        ends[number > 0.5][k]++;
}

static void check_ends(rk_ambient_map map, bool squared)
{
    static const char *const names[] = {"the horizon", "the normal", "a full turn, beyond",
                                        "a full turn, before"};
    uint32_t ends[4][last_end + 1] = {{0}}; /* of the height, or its square, and of the angle */
    for (uint32_t i = 0; i < points; i++) {
        rk_vec3 d = rk_ambient_hemisphere(map, noise2(2 + (uint32_t)map, i));
        double z = (double)d.z, around = atan2((double)d.y, (double)d.x) / (2 * pi);
        count_ends(ends, squared ? z * z : z);
        count_ends(ends + 2, around < 0 ? around + 1 : around);
    }
    for (int end = 0; end < 4; end++)
        for (int k = first_end; k <= last_end; k++) {
            double want = ldexp(points, -k);
            /* Binomial: five standard deviations. */
            rk_check_near(ends[end][k], want, 5 * sqrt(want),
                          "%s map: of %d directions those nearest to %s, a part of 2^-%d",
                          map_names[map], points, names[end], k);
        }
}

static void uniform_directions_are_unit_and_above_the_horizon(void **state)
{
    (void)state;
    check_directions(RK_AMBIENT_UNIFORM);
}

static void the_uniform_map_is_uniform_in_solid_angle(void **state)
{
    (void)state;
    check_cells(RK_AMBIENT_UNIFORM, false, "zones of equal height have equal areas");
    check_ends(RK_AMBIENT_UNIFORM, false);
}

static const char *mistake_of_direction(rk_vec2 xi, rk_vec3 d)
{
    const double y = 1 - (double)xi.y, around = 2 * pi * (double)xi.x, s = sqrt(1 - y * y);
    const double z = 1 - (double)xi.x, r = sqrt(1 - z * z), phi = 2 * pi * (double)xi.y;
    return rk_mistake_in_vector(
        RK_XYZ(d), (const double[]){r * cos(phi), r * sin(phi), z}, 1e-5,
        RK_VECTOR_MISTAKES(
            {{s * cos(around), s * sin(around), y}, "xi.x and xi.y are exchanged"},
            {{r * cos(phi / 2), r * sin(phi / 2), z}, "the angle goes half around only"},
            {{r * cos(phi * pi / 180), r * sin(phi * pi / 180), z}, "the angle is in degrees"},
            {{cos(phi), sin(phi), z}, "x and y are not multiplied by the root of 1 - z^2"},
            {{r * sin(phi), r * cos(phi), z}, "sine and cosine of the angle are exchanged"}));
}

static void check_height_and_angle(rk_vec2 xi)
{
    rk_vec3 d = rk_ambient_hemisphere(RK_AMBIENT_UNIFORM, xi);
    double z = 1 - (double)xi.x, r = sqrt(1 - z * z), phi = 2 * pi * (double)xi.y;
    /* A float's angle is off by a few roundings of 2 pi, and so is a radius of 1 / 5 or more that
     * is computed from the height, by 1 - z^2; the smallest is 0. */
    double off = fmax(fabs((double)d.x - r * cos(phi)), fabs((double)d.y - r * sin(phi)));
    rk_check(fabs((double)d.z - z) <= length_rounding && off <= 1e-6,
             "xi (%.9g, %.9g): got (%.9g, %.9g, %.9g), want the height 1 - xi.x and the angle "
             "2 pi xi.y, (%.9g, %.9g, %.9g)%s",
             (double)xi.x, (double)xi.y, (double)d.x, (double)d.y, (double)d.z, r * cos(phi),
             r * sin(phi), z, mistake_of_direction(xi, d));
}

static void a_uniform_direction_has_its_height_and_its_angle(void **state)
{
    (void)state;
    enum { steps = 32 };
    check_height_and_angle((rk_vec2){0.375f, 0.625f}); /* no two of its numbers are equal */
    for (int i = 0; i < steps * steps; i++)
        check_height_and_angle((rk_vec2){(float)(i % steps) / steps, (float)(i / steps) / steps});
    for (int e = 1; e <= 24; e++)
        for (int turn = 0; turn < 2; turn++) {
            float near = ldexpf(1, -e), y = turn ? 1 - near : near;
            check_height_and_angle((rk_vec2){0.5f, y});
            check_height_and_angle((rk_vec2){1 - near, y});
        }
}

static void cosine_directions_are_unit_and_never_below_the_horizon(void **state)
{
    (void)state;
    check_directions(RK_AMBIENT_COSINE);
}

static void cosine_directions_are_cosine_distributed(void **state)
{
    (void)state;
    check_cells(RK_AMBIENT_COSINE, true,
                "the fraction above a height z is the integral of 2 z dz, 1 - z^2");
    check_ends(RK_AMBIENT_COSINE, true);
}

static void check_projected(rk_vec2 xi)
{
    rk_vec2 disk = rk_disk_at(RK_DISK_CONCENTRIC, xi);
    rk_vec3 d = rk_ambient_hemisphere(RK_AMBIENT_COSINE, xi);
    double off = hypot((double)(d.x - disk.x), (double)(d.y - disk.y));
    /* A normalization's roundings. */
    rk_check(off <= 8 * 0x1p-24 && d.z >= 0,
             "xi (%.9g, %.9g): got (%.9g, %.9g, %.9g) above the point (%.9g, %.9g) of "
             "rk_disk_at by the concentric map, which keeps neighbours together",
             (double)xi.x, (double)xi.y, (double)d.x, (double)d.y, (double)d.z, (double)disk.x,
             (double)disk.y);
    double z_squared = 1 - (double)disk.x * (double)disk.x - (double)disk.y * (double)disk.y;
    rk_check_near((double)d.z * (double)d.z, z_squared, 2 * length_rounding,
                  "xi (%.9g, %.9g): the squared height above the point (%.9g, %.9g)", (double)xi.x,
                  (double)xi.y, (double)disk.x, (double)disk.y);
}

/* Anywhere, and near the centre, where xi is 1/2. */
static void a_cosine_direction_projects_onto_its_point_of_the_disk(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec2 xi = noise2(4, i);
        float near = ldexpf(1, -(int)(i % 20));
        check_projected(xi);
        check_projected((rk_vec2){0.5f + (xi.x - 0.5f) * near, 0.5f + (xi.y - 0.5f) * near});
    }
}

/* --- Weights ---------------------------------------------------------------------------------- */

/* For weights that are computed as a quotient, of the cosine and the density. */
static const double few_roundings = 4 * 0x1p-24;

static void the_uniform_weight_is_twice_the_cosine(void **state)
{
    (void)state;
    for (int i = 64; i >= 0; i--) {
        int k = (i + 13) % 65; /* a cosine first that is neither 0 nor 1: 12 / 64 */
        double cosine = k / 64.0;
        rk_check_near_or(rk_ambient_weight(RK_AMBIENT_UNIFORM, (float)cosine), 2 * cosine,
                         few_roundings,
                         RK_MISTAKES({cosine, "the factor 2 is missing"},
                                     {1, "the weight is that of cosine-distributed directions"},
                                     {2, "the cosine is missing"},
                                     {2 * cosine * cosine, "the cosine counts twice"}),
                         "uniform directions, cosine %d / 64, density 1 / (2 pi)", k);
    }
}

static void the_cosine_weight_is_1(void **state)
{
    (void)state;
    for (int i = 64; i >= 0; i--) {
        int k = (i + 13) % 65;
        double cosine = k / 64.0;
        rk_check_near_or(
            rk_ambient_weight(RK_AMBIENT_COSINE, (float)cosine), 1, few_roundings,
            RK_MISTAKES({cosine, "the cosine, which the density has already, counts once more"},
                        {2 * cosine, "the weight is that of uniform directions"}),
            "cosine-distributed directions, cosine %d / 64, density cos(theta) / pi", k);
    }
}

enum { powers = 5 };

/* The means over the unit square of weight times each power of the cosine from 0 on, at the cell
 * centres of a grid. */
static void find_means_of_powers(rk_ambient_map map, int grid, double means[powers])
{
    for (int power = 0; power < powers; power++)
        means[power] = 0;
    for (int i = 0; i < grid * grid; i++) {
        rk_vec2 xi = {((float)(i % grid) + 0.5f) / (float)grid,
                      ((float)(i / grid) + 0.5f) / (float)grid};
        rk_vec3 d = rk_ambient_hemisphere(map, xi);
        double weight = (double)rk_ambient_weight(map, d.z);
        double term = weight / (grid * grid);
        for (int power = 0; power < powers; power++, term *= (double)d.z)
            means[power] += term;
    }
}

/* Of the midpoint rule with cells of width h = 1 / 512: about h^1.5 / 2 for the root at the rim,
 * and h^2 elsewhere. */
static const double grid_error = 1e-4;

static void weights_are_1_on_average(void **state)
{
    (void)state;
    for (int m = 0; m < 2; m++) {
        double means[powers];
        find_means_of_powers(maps[m], 128, means); /* exact where weights are linear in xi */
        rk_check_near(means[0], 1, 1e-6,
                      "%s map: the integral of cos(theta) / pi over the hemisphere", map_names[m]);
    }
}

static void both_maps_estimate_the_same_integrals(void **state)
{
    (void)state;
    for (int m = 0; m < 2; m++) {
        double means[powers];
        find_means_of_powers(maps[m], 512, means);
        for (int power = 1; power < powers; power++)
            rk_check_near(means[power], 2.0 / (power + 2), grid_error,
                          "%s map: the integral of cos(theta)^%d / pi", map_names[m], power + 1);
    }
}

/* --- Around the normal ------------------------------------------------------------------------ */

/* The basis' own error, 8 units of 2^-24, for each of three terms, and their sum. */
static const double rotation_rounding = 32 * 0x1p-24;

/* The memory of what is to be filled in holds NaN at first. */
static rk_vec3 direction_of(const rk_ambient_frame *frame, rk_vec3 local)
{
    rk_vec3 got = {NAN, NAN, NAN};
    bool above = rk_ambient_direction(frame, local, &got);
    rk_check(!isnan(got.x) && !isnan(got.y) && !isnan(got.z),
             "the local direction (%.9g, %.9g, %.9g), reported %s the face: got (%g, %g, %g), and "
             "its memory holds NaN before the call: the direction is to be filled in, above the "
             "face or not",
             (double)local.x, (double)local.y, (double)local.z, above ? "above" : "not above",
             (double)got.x, (double)got.y, (double)got.z);
    return got;
}

static void check_rotated(rk_vec3 normal, rk_vec3 local)
{
    rk_ambient_frame frame = rk_ambient_frame_of(normal, normal);
    rk_vec3 got = direction_of(&frame, local);
    rk_dvec3 d = rk_widen(got);
    rk_check_near(rk_dlength(d), 1, rotation_rounding,
                  "normal (%.9g, %.9g, %.9g): length of the direction", (double)normal.x,
                  (double)normal.y, (double)normal.z);
    rk_check_near(rk_ddot(d, rk_widen(normal)), local.z, rotation_rounding,
                  "normal (%.9g, %.9g, %.9g): cosine of (%.9g, %.9g, %.9g)", (double)normal.x,
                  (double)normal.y, (double)normal.z, (double)local.x, (double)local.y,
                  (double)local.z);
}

static rk_vec3 noise_local(uint32_t a, uint32_t b)
{
    rk_vec3 d = noise_direction(a, b);
    return rk_vec(d.x, d.y, fabsf(d.z));
}

static void a_direction_keeps_its_cosine_around_any_normal(void **state)
{
    (void)state;
    const rk_ambient_frame frame = rk_ambient_frame_of(rk_vec(0, 0, 1), rk_vec(0, 0, 1));
    rk_vec3 direction;
    rk_ambient_direction(rk_read_only(&frame, sizeof frame, "frame"), rk_vec(0, 0, 1), &direction);
    rk_read_only_free();
    for (uint32_t i = 0; i < 100000; i++)
        check_rotated(noise_direction(5, i), noise_local(6, i));
}

static void a_direction_keeps_its_cosine_near_the_poles(void **state)
{
    (void)state;
    for (int e = 0; e <= 149; e++)
        for (uint32_t i = 0; i < 16; i++) {
            double tilt = ldexp(pi / 4, -e), phi = 2 * pi * (double)noise(7, i, 0);
            for (int below = 0; below < 2; below++)
                check_rotated(narrow(polar(below ? pi - tilt : tilt, phi)), noise_local(8, i));
        }
}

static void the_frame_is_a_rotation(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec3 normal = noise_direction(9, i);
        rk_ambient_frame frame = rk_ambient_frame_of(normal, normal);
        rk_vec3 p = noise_local(10, i), q = noise_local(11, i), r = noise_local(12, i);
        rk_vec3 a = direction_of(&frame, p), b = direction_of(&frame, q),
                c = direction_of(&frame, r);
        rk_check_near(rk_dot(a, b), rk_dot(p, q), 4 * rotation_rounding,
                      "the cosine between two directions");
        rk_check_near(rk_dot(rk_cross(a, b), c), rk_dot(rk_cross(p, q), r), 8 * rotation_rounding,
                      "the volume of three directions: a rotation does not reflect");
        rk_vec3 face = noise_direction(17, i), axis[] = {frame.u, frame.v, frame.normal};
        face = rk_dot(normal, face) < 0 ? rk_negate(face) : face;
        frame = rk_ambient_frame_of(normal, face);
        rk_check(memcmp(&frame.normal, &normal, sizeof normal) == 0 &&
                     memcmp(&frame.face_normal, &face, sizeof face) == 0,
                 "the frame has another normal, or face normal, than it was made of");
        static const char *const names[] = {"x and u", "y and v", "z and normal"};
        rk_ambient_frame turned = {frame.v, rk_negate(frame.u), normal, face};
        for (int k = 0; k < 3; k++) {
            a = direction_of(&frame, rk_vec(k == 0, k == 1, k == 2));
            b = direction_of(&turned, rk_vec(k == 0, k == 1, k == 2));
            rk_check_near(rk_length(rk_sub(a, axis[k])), 0, rotation_rounding,
                          "the distance between the direction of the local axis and the frame's: "
                          "%s",
                          names[k]);
            rk_check_near(rk_length(rk_sub(b, k == 0   ? turned.u
                                              : k == 1 ? turned.v
                                                       : normal)),
                          0, rotation_rounding,
                          "the same in a frame with the axes v, -u, normal of this one: %s",
                          names[k]);
        }
        for (int k = 0; k < 9; k++)
            rk_check_near(rk_dot(axis[k / 3], axis[k % 3]), k / 3 == k % 3, rotation_rounding,
                          "the dot product of the frame's axes %d and %d", k / 3, k % 3);
        rk_check_near(rk_dot(rk_cross(frame.u, frame.v), normal), 1, rotation_rounding,
                      "the volume of u, v and normal: the frame is right-handed");
    }
}

static void check_writes_one_direction(uint32_t i)
{
    const rk_vec3 guard = rk_vec(7, 8, 9);
    rk_vec3 got[] = {guard, guard, guard}, normal = noise_direction(18, i);
    rk_ambient_frame frame = rk_ambient_frame_of(normal, normal), same = frame;
    rk_ambient_direction(&frame, noise_local(19, i), &got[1]);
    rk_check(memcmp(&got[0], &guard, sizeof guard) == 0 &&
                 memcmp(&got[2], &guard, sizeof guard) == 0,
             "the direction is an element of an array: its neighbours are written, too");
    rk_check(memcmp(&frame, &same, sizeof frame) == 0, "the frame, which is const, is changed");
}

static void directions_into_the_surface_are_reported_and_filled_in(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 100; i++)
        check_writes_one_direction(i);
    uint32_t above = 0, below = 0;
    for (uint32_t i = 0; i < 100000; i++) {
        rk_vec3 normal = noise_direction(13, i), face = noise_direction(14, i),
                got = {NAN, NAN, NAN};
        rk_vec3 local = noise_local(15, i);
        if (i % 4 == 0) /* along the horizon of the shading normal */
            local = rk_normalize(rk_vec(local.x, local.y, 0));
        if (rk_dot(normal, face) < 0)
            face = rk_negate(face);
        rk_ambient_frame frame = rk_ambient_frame_of(normal, face);
        direction_of(&frame, local);
        bool above_face = rk_ambient_direction(&frame, local, &got);
        double height = rk_ddot(rk_widen(got), rk_widen(face));
        /* Three products and two sums of numbers up to 1. */
        rk_check(above_face ? height > -3 * 0x1p-24 : height <= 3 * 0x1p-24,
                 "a direction %.9g above the face is reported %s it", height,
                 above_face ? "above" : "below");
        rk_check_near(rk_ddot(rk_widen(got), rk_widen(normal)), local.z, rotation_rounding,
                      "its cosine with the shading normal, above or below the face");
        above += above_face;
        below += !above_face;
    }
    rk_check(above > 50000 && below > 5000, "%u above, %u below: both should happen", above, below);
    rk_vec3 got, up = rk_vec(0, 0, 1);
    rk_ambient_frame frame = rk_ambient_frame_of(up, up);
    rk_check(!rk_ambient_direction(&frame, rk_vec(1, 0, 0), &got),
             "a direction in the plane of the face is not above it");
}

static void directions_barely_above_the_face_are_not_into_it(void **state)
{
    (void)state;
    const rk_vec3 axes[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    for (int i = 0; i < 6; i++) { /* around these nothing is rounded */
        const rk_ambient_frame frame = rk_ambient_frame_of(axes[i], axes[i]);
        for (int e = 1; e <= 126; e++) {
            rk_vec3 got, local = rk_vec((float)(e % 2), (float)((e + 1) % 2), ldexpf(1, -e));
            rk_check(rk_ambient_direction(&frame, local, &got),
                     "normal and face normal (%g, %g, %g): the local direction (%g, %g, %g) is "
                     "above the face, however little",
                     (double)axes[i].x, (double)axes[i].y, (double)axes[i].z, (double)local.x,
                     (double)local.y, (double)local.z);
        }
    }
    int tried = 0;
    for (uint32_t i = 0; i < 10000; i++) {
        /* A direction at a height above the face of twice what a rotation is rounded by. */
        rk_vec3 normal = noise_direction(18, i), face = noise_direction(19, i), got;
        face = rk_dot(normal, face) < 0 ? rk_negate(face) : face;
        rk_ambient_frame frame = rk_ambient_frame_of(normal, face);
        rk_vec3 along = rk_normalize(rk_cross(face, normal)),
                up = rk_madd(rk_cross(along, face), face, 2 * (float)rotation_rounding);
        up = rk_dot(up, normal) < 0 ? rk_madd(up, rk_cross(along, face), -2) : up;
        rk_vec3 local = rk_vec(rk_dot(up, frame.u), rk_dot(up, frame.v), rk_dot(up, frame.normal));
        if (local.z < 0)
            continue;
        tried++;
        rk_check(rk_ambient_direction(&frame, local, &got),
                 "the local direction (%.9g, %.9g, %.9g) around the normal (%.9g, %.9g, %.9g) is "
                 "%.3g above the face with the normal (%.9g, %.9g, %.9g)",
                 (double)local.x, (double)local.y, (double)local.z, (double)normal.x,
                 (double)normal.y, (double)normal.z, 2 * rotation_rounding, (double)face.x,
                 (double)face.y, (double)face.z);
    }
    rk_check(tried > 5000, "only %d directions were tried, want more than 5000", tried);
}

/* --- Radiance --------------------------------------------------------------------------------- */

static void one_unoccluded_cosine_direction_is_exact(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 local = rk_ambient_hemisphere(RK_AMBIENT_COSINE, noise2(16, i));
        float w = rk_ambient_weight(RK_AMBIENT_COSINE, local.z);
        rk_vec3 got = rk_ambient_radiance(rk_vec(0.5f, 0.25f, 1), 2, rk_vec(w, w, w), 1);
        rk_check(got.x == 1 && got.y == 0.5f && got.z == 2,
                 "got (%.9g, %.9g, %.9g), want ka kd, (1, 0.5, 2), to the bit%s", (double)got.x,
                 (double)got.y, (double)got.z,
                 rk_mistake_in_vector(
                     RK_XYZ(got), (const double[]){1, 0.5, 2}, 1e-6,
                     RK_VECTOR_MISTAKES(
                         {{1 / pi, 0.5 / pi, 2 / pi}, "it is divided by pi, which the weights are"},
                         {{0.5, 0.25, 1}, "the intensity ka = 2 is left out"},
                         {{2, 2, 2}, "the surface's colour kd is left out"})));
    }
}

static void occluded_directions_count_among_the_samples(void **state)
{
    (void)state;
    rk_vec3 got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(3, 3, 3), 16);
    rk_check_close(got.x, 3.0 / 16, 1e-7, "3 of 16 directions are unoccluded");
    got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(50000, 50000, 50000), 100000);
    rk_check_close(got.x, 0.5, 1e-7, "50000 of 100000 directions are unoccluded");
    got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(1.5e9f, 1.5e9f, 1.5e9f), 3000000000u);
    rk_check_close(got.x, 0.5, 1e-7,
                   "half of 3000000000 directions are unoccluded: an int has no room for so many");
    for (int e = 0; e < 32; e++) {
        uint32_t samples = (2u << e) - 1; /* the last one is the largest number */
        float half = (float)samples / 2;
        got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(half, 1, 0), samples);
        rk_check_near(got.x, 0.5, 1e-7, "half of %u directions are unoccluded", (unsigned)samples);
        rk_check_near((double)got.y * samples, 1, 1e-6, "one of %u directions is unoccluded",
                      (unsigned)samples);
    }
    got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(0, 0, 0), 16);
    rk_check(got.x == 0 && got.y == 0 && got.z == 0, "none is unoccluded: black, got %.9g",
             (double)got.x);
}

/* ka kd A = 2^e (1 / 4, 1 / 16, 3 / 4), each channel. */
static void check_scaled(rk_vec3 got, int e, const char *what)
{
    const double want[] = {0.25, 0.0625, 0.75};
    for (int axis = 0; axis < 3; axis++) {
        char text[100];
        snprintf(text, sizeof text, what, e);
        rk_check_near(ldexp((double)rk_axis(got, axis), -e), want[axis], 1e-6,
                      "%s: channel %d times 2^%d", text, axis, -e);
    }
}

static void colour_intensity_and_visibility_multiply_per_channel(void **state)
{
    (void)state;
    rk_vec3 got = rk_ambient_radiance(rk_vec(0.5f, 0.25f, 0.75f), 3, rk_vec(4, 2, 1), 4);
    rk_check_close(got.x, 1.5, 1e-6, "red: 3 x 0.5 x 4 / 4");
    rk_check_close(got.y, 0.375, 1e-6, "green: 3 x 0.25 x 2 / 4");
    rk_check_close(got.z, 0.5625, 1e-6, "blue: 3 x 0.75 x 1 / 4");
    got = rk_ambient_radiance(rk_vec(0.5f, 0.5f, 0.5f), 64, rk_vec(1, 1, 1), 1);
    rk_check_close(got.x, 32, 1e-5, "bright light, of intensity 64");
    got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(1.5f, 0.5f, 1.5f), 1);
    rk_check_near_or(got.x, 1.5, 1e-6,
                     RK_MISTAKES({1, "the mean of the weights is clamped to 1, but weights of the "
                                     "uniform map go up to 2"}),
                     "one sample of the weight 1.5");
    for (int e = -100; e <= 40; e++) {
        got = rk_ambient_radiance(rk_vec(0.5f, 0.25f, 0.75f), ldexpf(1, e), rk_vec(2, 1, 4), 4);
        check_scaled(got, e, "light of the intensity 2^%d on a surface of (0.5, 0.25, 0.75)");
        got = rk_ambient_radiance(rk_scale(rk_vec(0.5f, 0.25f, 0.75f), ldexpf(1, e)), 1,
                                  rk_vec(2, 1, 4), 4);
        check_scaled(got, e, "light on a surface of 2^%d (0.5, 0.25, 0.75)");
        got = rk_ambient_radiance(rk_vec(0.5f, 0.25f, 0.75f), 1,
                                  rk_scale(rk_vec(2, 1, 4), ldexpf(1, e)), 4);
        check_scaled(got, e, "a sum of 2^%d (2, 1, 4) over 4 samples");
    }
    got = rk_ambient_radiance(rk_vec(1, 1, 1), 0, rk_vec(1, 1, 1), 1);
    rk_check(got.x == 0 && got.y == 0 && got.z == 0, "an intensity of 0 is no light, got %.9g",
             (double)got.x);
    /* The most light: the uniform map's weights are at most 2. */
    for (int e = 0; e <= 32; e++) {
        uint32_t samples = e == 32 ? UINT32_MAX : 1u << e;
        float most = 2 * (float)samples;
        got = rk_ambient_radiance(rk_vec(1, 1, 1), 0x1p40f, rk_vec(most, most, most), samples);
        rk_check_near(ldexp((double)got.y, -41), 1, 1e-6,
                      "an intensity of 2^40, %u samples: half of the light times 2^-40",
                      (unsigned)samples);
    }
    for (int black = 0; black < 3; black++) { /* red, green, blue */
        rk_vec3 colour = rk_vec(black != 0, black != 1, black != 2), white = rk_vec(1, 1, 1);
        rk_vec3 surface = rk_ambient_radiance(colour, 1, white, 1);
        rk_vec3 light = rk_ambient_radiance(white, 1, colour, 1);
        for (int axis = 0; axis < 3; axis++) {
            double want = (double)rk_axis(colour, axis);
            rk_check_near(rk_axis(surface, axis), want, 0,
                          "a surface that is black in channel %d only: channel %d", black, axis);
            rk_check_near(rk_axis(light, axis), want, 0,
                          "light, behind glass, that is black in channel %d only: channel %d",
                          black, axis);
        }
    }
}

static void an_estimate_of_the_visibility_may_exceed_1(void **state)
{
    (void)state;
    /* Two directions near the normal, by the uniform map. */
    rk_vec3 got = rk_ambient_radiance(rk_vec(1, 1, 1), 1, rk_vec(3.5f, 3.5f, 3.5f), 2);
    rk_check_close(
        got.x, 1.75, 1e-6,
        "2 directions with weights of 3.5 together: clamped to 1, means would be too dark");
}

/* --- Closed forms ----------------------------------------------------------------------------- */

/* Occludes directions from the point 0 with the normal z; your closed form for it. */
typedef struct occluder {
    double size, distance, cosine;
    float closed_form;
} occluder;

enum { occluders = 3 };

typedef bool occludes(const occluder *o, rk_dvec3 d);

static bool disk_occludes(const occluder *o, rk_dvec3 d)
{
    return hypot(d.x, d.y) * o->distance < d.z * o->size;
}

static bool sphere_occludes(const occluder *o, rk_dvec3 d)
{
    rk_dvec3 centre = rk_dscale(polar(acos(o->cosine), 1), o->distance);
    double along = rk_ddot(centre, d);
    return along > 0 && o->distance * o->distance - along * along < o->size * o->size;
}

static bool wall_occludes(const occluder *o, rk_dvec3 d)
{
    return d.x > 0 && d.z * o->distance < d.x * o->size;
}

enum { strata = 128, estimates = strata * strata };

/* The mean of weight times V. An occluder's rim crosses at most 8 strata in each row, where weights
 * of up to 2 have a variance of up to 1; elsewhere they hardly vary. The mean is off by more than 5
 * standard errors less than once in a million times. */
static void check_estimate(const occluder *o, double estimate, rk_ambient_map map, const char *name)
{
    double tolerance = 5 * sqrt(8.0 * strata) / estimates;
    rk_check(fabs((double)o->closed_form - estimate) <= tolerance,
             "%s of size %g at the distance %g, cosine %g: your closed form says %.6f, but of %d "
             "of your directions by the %s map those that miss it weigh %.6f, and both should be "
             "equal within %.3g; the claim about the closed form tells which is wrong",
             name, o->size, o->distance, o->cosine, (double)o->closed_form, estimates,
             map_names[map], estimate, tolerance);
}

static void check_estimates(const occluder all[occluders], occludes *is_occluded, const char *name)
{
    for (int k = 0; k < occluders; k++) /* a constant direction estimates 0 or 1 */
        rk_check(all[k].closed_form > 0.01f && all[k].closed_form < 0.99f,
                 "%s: the closed form is %g, want one of those that are neither 0 nor 1", name,
                 (double)all[k].closed_form);
    for (int m = 0; m < 2; m++) {
        double sums[occluders] = {0};
        for (uint32_t i = 0; i < estimates; i++) {
            const rk_vec2 within = noise2(20 + (uint32_t)m, i);
            const rk_vec2 xi = {((float)(i % strata) + 0.999f * within.x) / strata,
                                ((float)(i / strata) + 0.999f * within.y) / strata};
            rk_vec3 d = rk_ambient_hemisphere(maps[m], xi);
            double weight = (double)rk_ambient_weight(maps[m], d.z);
            for (int k = 0; k < occluders; k++)
                sums[k] += is_occluded(&all[k], rk_widen(d)) ? 0 : weight;
        }
        for (int k = 0; k < occluders; k++)
            check_estimate(&all[k], sums[k] / estimates, maps[m], name);
    }
}

static void a_disk_occludes_the_squared_sine_of_its_rim_angle(void **state)
{
    (void)state;
    rk_check_close(rk_ambient_below_disk(1, 1), 0.5, 1e-7,
                   "its rim is at 45 degrees from the normal");
    rk_check_close(rk_ambient_below_disk(0, 3), 1, 0, "no disk");
    rk_check_close(rk_ambient_below_disk(3, 1), 0.1, 1e-7, "1 - 9 / 10");
    rk_check_close(rk_ambient_below_disk(300, 100), 0.1, 1e-7, "the same, larger");
    rk_check_close(rk_ambient_below_disk(1e6f, 1) * 1e12, 1, 1e-3,
                   "a disk over nearly everything: h^2 / (R^2 + h^2) does not cancel");
    rk_check_near((double)rk_ambient_below_disk(1e20f, 1), 1e-40, 0x1p-148,
                  "a disk whose squared radius is beyond the largest float");
    for (int h = 1; h <= 8; h++)
        rk_check_near(rk_ambient_below_disk(1, (float)h), h * h / (1.0 + h * h), 1e-6,
                      "a disk of radius 1, %d above", h);
    for (int e = -60; e <= 60; e++)
        rk_check_near((double)rk_ambient_below_disk(ldexpf(1, e), 1) * (1 + ldexp(1, 2 * e)), 1,
                      8 * 0x1p-24, "a disk whose radius is 2^%d of its height: A (1 + (R / h)^2)",
                      e);
}

static void estimates_agree_with_the_disk(void **state)
{
    (void)state;
    const double sizes[] = {0.25, 1, 4};
    occluder disks[occluders];
    for (int i = 0; i < occluders; i++)
        disks[i] = (occluder){sizes[i], 1, 1, rk_ambient_below_disk((float)sizes[i], 1)};
    check_estimates(disks, disk_occludes, "a disk");
}

static void a_sphere_occludes_its_squared_sine_times_the_cosine(void **state)
{
    (void)state;
    rk_check_close(rk_ambient_below_sphere(1, 2, 1), 0.75, 1e-7, "straight above");
    rk_check_close(rk_ambient_below_sphere(1, 2, 0.5f), 0.875, 1e-7, "60 degrees from the normal");
    rk_check_close(rk_ambient_below_sphere(3, 3, 1), 0, 1e-7, "it touches the point");
    rk_check_close(rk_ambient_below_sphere(0, 3, 1), 1, 0, "no sphere");
    rk_check_close(rk_ambient_below_sphere(1, 8, 0.25f), 1 - 0.25 / 64, 1e-7, "near the horizon");
    for (int i = 0; i <= 64; i++)
        for (int k = 0; k <= i; k++)
            rk_check_near(rk_ambient_below_sphere((float)k, 64, (float)i / 64),
                          1 - i / 64.0 * k * k / 4096, 2e-7,
                          "radius %d, distance 64, cosine %d / 64: 1 - cosine (r / d)^2", k, i);
    for (int d = 1; d <= 8; d++)
        rk_check_near(rk_ambient_below_sphere(1, (float)d, 1), 1 - 1.0 / (d * d), 2e-7,
                      "a sphere of radius 1 straight above, at the distance %d", d);
    for (int e = 0; e <= 24; e++)
        rk_check_near(rk_ambient_below_sphere(ldexpf(1, -e), 1, 1), 1 - ldexp(1, -2 * e), 2e-7,
                      "a sphere straight above, whose radius is 2^-%d of its distance", e);
}

static void estimates_agree_with_the_sphere(void **state)
{
    (void)state;
    occluder spheres[occluders];
    for (int i = 0; i < occluders; i++) {
        double cosine = 0.5 + 0.25 * i; /* above the horizon, because 0.45 < 0.5 */
        float closed_form = rk_ambient_below_sphere(0.45f, 1, (float)cosine);
        spheres[i] = (occluder){0.45, 1, cosine, closed_form};
    }
    check_estimates(spheres, sphere_occludes, "a sphere");
}

static void a_wall_occludes_half_at_its_foot_and_less_farther_away(void **state)
{
    (void)state;
    rk_check_close(rk_ambient_beside_wall(1, 1e-8f), 0.5, 1e-6, "at the foot");
    rk_check_close(rk_ambient_beside_wall(3, 4), 0.9, 1e-7, "(1 + 4 / 5) / 2");
    rk_check_close(rk_ambient_beside_wall(1e-8f, 1), 1, 1e-7, "no wall");
    for (int e = -60; e <= 60; e++)
        rk_check_near(rk_ambient_beside_wall(ldexpf(1, e), 1), 0.5 + 0.5 / hypot(1, ldexp(1, e)),
                      2e-7, "a wall 2^%d times as high as far away", e);
}

static void estimates_agree_with_the_wall(void **state)
{
    (void)state;
    const double distances[] = {0.1, 1, 3};
    occluder walls[occluders];
    for (int i = 0; i < occluders; i++)
        walls[i] = (occluder){1, distances[i], 0, rk_ambient_beside_wall(1, (float)distances[i])};
    check_estimates(walls, wall_occludes, "a wall");
}

static void closed_forms_do_not_depend_on_the_unit_of_length(void **state)
{
    (void)state;
    for (int e = -124; e <= 125; e += 3) {
        float unit = ldexpf(1, e);
        rk_check_near(rk_ambient_below_disk(3 * unit, 4 * unit), 0.64, 1e-6,
                      "a disk of radius 3 x 2^%d, 4 x 2^%d above", e, e);
        rk_check_near(rk_ambient_below_sphere(3 * unit, 5 * unit, 0.75f), 0.73, 1e-6,
                      "a sphere of radius 3 x 2^%d, 5 x 2^%d away, cosine 0.75", e, e);
        rk_check_near(rk_ambient_beside_wall(3 * unit, 4 * unit), 0.9, 1e-6,
                      "a wall 3 x 2^%d high, 4 x 2^%d away", e, e);
    }
    const float largest = 0x1.fffffep127f, smallest = 0x1p-126f;
    rk_check_close(rk_ambient_below_disk(largest, largest), 0.5, 1e-6,
                   "lengths as large as can be");
    rk_check_close(rk_ambient_below_sphere(largest / 2, largest, 1), 0.75, 1e-6,
                   "lengths as large as can be");
    rk_check_close(rk_ambient_beside_wall(largest, largest), 0.5 + sqrt(0.125), 1e-6,
                   "lengths as large as can be, and a diagonal that is larger");
    rk_check_close(rk_ambient_below_disk(largest, smallest), 0, 1e-30, "a disk over everything");
    rk_check_close(rk_ambient_below_disk(smallest, largest), 1, 0, "a disk that is not seen");
    rk_check_close(rk_ambient_beside_wall(largest, smallest), 0.5, 1e-7, "at the wall's foot");
    rk_check_close(rk_ambient_beside_wall(smallest, largest), 1, 1e-7, "a wall that is not seen");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(uniform_directions_are_unit_and_above_the_horizon),
    cmocka_unit_test(the_uniform_map_is_uniform_in_solid_angle),
    cmocka_unit_test(a_uniform_direction_has_its_height_and_its_angle),
    cmocka_unit_test(cosine_directions_are_unit_and_never_below_the_horizon),
    cmocka_unit_test(cosine_directions_are_cosine_distributed),
    cmocka_unit_test(a_cosine_direction_projects_onto_its_point_of_the_disk),
    cmocka_unit_test(the_uniform_weight_is_twice_the_cosine),
    cmocka_unit_test(the_cosine_weight_is_1),
    cmocka_unit_test(weights_are_1_on_average),
    cmocka_unit_test(both_maps_estimate_the_same_integrals),
    cmocka_unit_test(a_direction_keeps_its_cosine_around_any_normal),
    cmocka_unit_test(a_direction_keeps_its_cosine_near_the_poles),
    cmocka_unit_test(the_frame_is_a_rotation),
    cmocka_unit_test(directions_into_the_surface_are_reported_and_filled_in),
    cmocka_unit_test(directions_barely_above_the_face_are_not_into_it),
    cmocka_unit_test(one_unoccluded_cosine_direction_is_exact),
    cmocka_unit_test(occluded_directions_count_among_the_samples),
    cmocka_unit_test(colour_intensity_and_visibility_multiply_per_channel),
    cmocka_unit_test(an_estimate_of_the_visibility_may_exceed_1),
    cmocka_unit_test(a_disk_occludes_the_squared_sine_of_its_rim_angle),
    cmocka_unit_test(estimates_agree_with_the_disk),
    cmocka_unit_test(a_sphere_occludes_its_squared_sine_times_the_cosine),
    cmocka_unit_test(estimates_agree_with_the_sphere),
    cmocka_unit_test(a_wall_occludes_half_at_its_foot_and_less_farther_away),
    cmocka_unit_test(estimates_agree_with_the_wall),
    cmocka_unit_test(closed_forms_do_not_depend_on_the_unit_of_length),
};

RK_SUITE("ambient_occlusion", tests)
