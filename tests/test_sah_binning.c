/* The bounding volume hierarchy split by the surface area heuristic: that binning loses no
 * triangle, that each split is the one found by brute force, and that the tree is cheap and sound.
 * */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include "little_stack.h"
#include "short_memory.h"
#include "test.h"
#include "test_soup.h"

#include "base/table.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"
#include "scenes/builtin.h"

/* --- Nodes to split -------------------------------------------------------------------------- */

/* The reference of a triangle that fills a box, with the centroid in its middle. */
static rk_bvh_reference box_at(rk_vec3 low, rk_vec3 extent)
{
    return (rk_bvh_reference){{{low, rk_add(low, extent)}}, rk_madd(low, extent, 0.5f), 0};
}

/* A cube with sides of 1. */
static rk_bvh_reference cube_at(float x, float y, float z)
{
    return box_at(rk_vec(x, y, z), rk_vec(1, 1, 1));
}

static rk_bvh_reference *references_of(const rk_mesh *mesh)
{
    rk_bvh_reference *references = calloc(mesh->triangle_count, sizeof *references);
    rk_check(references != NULL, "no memory for %u references", mesh->triangle_count);
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        references[i] = rk_bvh_reference_of(mesh, i);
    return references;
}

static rk_sah_split candidates[RK_SAH_CANDIDATES_MAX];

static uint32_t list(const rk_bvh_reference *references, uint32_t count, uint32_t bins,
                     bool all_axes)
{
    const rk_sah_options options = {bins, all_axes};
    return rk_sah_candidates(references, count, &options, candidates);
}

/* The node of so many triangles has this number of candidates. */
static void check_found(const rk_bvh_reference *references, uint32_t count, uint32_t bins,
                        bool all_axes, uint32_t want, const char *hint)
{
    uint32_t got = list(references, count, bins, all_axes);
    rk_check(got == want, "%u triangles, %u bins%s: got %u candidates, want %u: %s", count, bins,
             all_axes ? " on each axis" : "", got, want, hint);
}

static void check_counts(const rk_sah_split *split, uint32_t left, uint32_t right, const char *hint)
{
    rk_check(split->count[0] == left && split->count[1] == right,
             "boundary %u: got %u triangles to the left and %u to the right, want %u and %u: %s",
             split->boundary, split->count[0], split->count[1], left, right, hint);
}

/* --- The same by brute force, in double ------------------------------------------------------ */

/* One bin boundary, with which every centroid is compared: the boxes on either side. */
typedef struct trial {
    int axis;
    uint32_t boundary, triangles[2];
    double low[2][3], high[2][3]; /* of the boxes */
    double cost;
} trial;

static double surface(const double *low, const double *high)
{
    double x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return 2 * (x * y + y * z + z * x);
}

/* fmin and fmax are calls; no number here is NaN. */
static double smaller_of(double a, double b)
{
    return a < b ? a : b;
}

static double larger_of(double a, double b)
{
    return a > b ? a : b;
}

static void put_on_side(trial *t, int side, const rk_box *box)
{
    t->triangles[side]++;
    for (int axis = 0; axis < 3; axis++) {
        t->low[side][axis] = smaller_of(t->low[side][axis], (double)rk_axis(box->corner[0], axis));
        t->high[side][axis] = larger_of(t->high[side][axis], (double)rk_axis(box->corner[1], axis));
    }
}

/* 1.5 and the mean number of triangle tests: all of them where areas of 0 cannot tell. */
static double cost_of_trial(const trial *t)
{
    double low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = smaller_of(t->low[0][axis], t->low[1][axis]);
        high[axis] = larger_of(t->high[0][axis], t->high[1][axis]);
    }
    double whole = surface(low, high), tests = 0;
    for (int side = 0; side < 2; side++)
        tests +=
            t->triangles[side] * (whole > 0 ? surface(t->low[side], t->high[side]) / whole : 1);
    return 1.5 + tests;
}

/* The extent of the centroids. */
static void find_extent(const rk_bvh_reference *references, uint32_t count, int axis, double *low,
                        double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        *low = smaller_of(*low, (double)rk_axis(references[i].centroid, axis));
        *high = larger_of(*high, (double)rk_axis(references[i].centroid, axis));
    }
}

static trial try_boundary(const rk_bvh_reference *references, uint32_t count, int axis,
                          uint32_t bins, uint32_t boundary, double first, double last)
{
    trial t = {.axis = axis, .boundary = boundary};
    for (int k = 0; k < 6; k++) {
        t.low[k / 3][k % 3] = INFINITY;
        t.high[k / 3][k % 3] = -INFINITY;
    }
    const double bins_per_unit = bins / (last - first);
    for (uint32_t i = 0; i < count; i++) {
        double in_bins = ((double)rk_axis(references[i].centroid, axis) - first) * bins_per_unit;
        put_on_side(&t, in_bins < boundary ? 0 : 1, &references[i].box);
    }
    t.cost = cost_of_trial(&t);
    return t;
}

static int longest_axis_of_centroids(const rk_bvh_reference *references, uint32_t count)
{
    int longest = 0;
    double extent = -INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        double low, high;
        find_extent(references, count, axis, &low, &high);
        if (high - low > extent) {
            extent = high - low;
            longest = axis;
        }
    }
    return longest;
}

/* All boundaries that divide the triangles differently, by axis; returns their number. */
static uint32_t try_boundaries(const rk_bvh_reference *references, uint32_t count,
                               const rk_sah_options *options, trial *trials)
{
    uint32_t bins = options->bins < count ? options->bins : count, tried = 0;
    int longest = longest_axis_of_centroids(references, count);
    for (int axis = 0; axis < 3; axis++) {
        if (!options->all_axes && axis != longest)
            continue;
        double first, last;
        find_extent(references, count, axis, &first, &last);
        uint32_t on_the_left = 0;
        for (uint32_t boundary = 1; boundary < bins; boundary++) {
            trials[tried] = try_boundary(references, count, axis, bins, boundary, first, last);
            if (trials[tried].triangles[0] > on_the_left && trials[tried].triangles[1] > 0)
                on_the_left = trials[tried++].triangles[0];
        }
    }
    return tried;
}

static bool is_box_of_side(const rk_box *box, const trial *t, int side)
{
    bool same = true;
    for (int axis = 0; axis < 3; axis++)
        same = same && (double)rk_axis(box->corner[0], axis) == t->low[side][axis] &&
               (double)rk_axis(box->corner[1], axis) == t->high[side][axis];
    return same;
}

/* Boxes are minima and maxima of the same numbers, so they are equal to the bit. A cost takes a
 * dozen roundings of double, in any order. */
static const double cost_tolerance = 16 * 0x1p-53;

static void check_split(const rk_sah_split *got, const trial *want, uint32_t count)
{
    int axis = want->axis;
    rk_check(got->axis == axis && got->boundary == want->boundary,
             "%u triangles: got boundary %u on axis %c, want %u on %c: each bin boundary that "
             "divides the triangles differently is listed, in order",
             count, got->boundary, "xyz"[got->axis], want -> boundary, "xyz"[axis]);
    check_counts(got, want->triangles[0], want->triangles[1],
                 "is each triangle counted in the bin of its centroid?");
    for (int side = 0; side < 2; side++)
        rk_check(is_box_of_side(&got->box[side], want, side),
                 "boundary %u of %u triangles: the %s box is not the smallest around its triangles",
                 got->boundary, count, side ? "right" : "left");
    rk_check(fabs(got->cost - want->cost) <= cost_tolerance * want->cost,
             "boundary %u of %u triangles: got the cost %.17g, want %.17g, which is 1.5 + "
             "(area_left N_left + area_right N_right) / area, in double",
             got->boundary, count, got->cost, want->cost);
}

/* --- Two bins along x ------------------------------------------------------------------------ */

static void a_split_costs_as_computed_by_hand(void **state)
{
    (void)state;
    /* Cubes from 0 to 3 and from 9 to 10 in a row of 10 x 1 x 1, area 42. Left 3 x 1 x 1, area 14;
     * right one cube, area 6. */
    const rk_bvh_reference row[] = {cube_at(0, 0, 0), cube_at(9, 0, 0), cube_at(1, 0, 0),
                                    cube_at(2, 0, 0)};
    check_found(row, 4, 2, false, 1, "two bins have one boundary");
    rk_check_equal(candidates[0].axis, 0, "the row is along x");
    check_counts(&candidates[0], 3, 1,
                 "three cubes lie in the lower half of the centroids' extent");
    rk_check_near_or(
        candidates[0].cost, 1.5 + (14 * 3 + 6 * 1) / 42.0, 4 * cost_tolerance,
        RK_MISTAKES({1.5, "the bins' boxes are around centroids, so their areas are 0 here: take "
                          "the triangles' boxes"},
                    {1.5 + (14 + 6) / 42.0, "areas are not multiplied by numbers of triangles"},
                    {1.5 + 3 + 1, "numbers of triangles are not multiplied by areas"},
                    {1.5 + 14 * 3 + 6 * 1, "the areas are not divided by the node's, 42"},
                    {(14 * 3 + 6 * 1) / 42.0, "1.5, the cost of visiting a node, is left out"},
                    {1.5 + (14 * 1 + 6 * 3) / 42.0, "each area has the other side's number"}),
        "the cost: 1.5 + (area_left N_left + area_right N_right) / area");
}

static void no_centroid_is_beyond_the_last_bin(void **state)
{
    (void)state;
    /* Extents whose product with bins / extent rounds up as well as down. */
    for (uint32_t i = 0; i < 2000; i++) {
        const rk_bvh_reference row[] = {cube_at(noise(1, i, 0), 0, 0),
                                        cube_at(3 + noise(2, i, 0), 0, 0),
                                        cube_at(1 + noise(3, i, 0), 0, 0)};
        check_found(row, 3, 2, false, 1, "three different centroids, two bins");
        rk_check_equal(candidates[0].count[0] + candidates[0].count[1], 3,
                       "the highest centroid is in the last bin, and in no other");
    }
}

static void without_area_a_split_costs_all_its_triangles(void **state)
{
    (void)state;
    /* Boxes without height and depth, all on one line. */
    rk_bvh_reference row[7];
    for (uint32_t i = 0; i < 7; i++)
        row[i] = box_at(rk_vec((float)i * 2, 1, 1), rk_vec(1, 0, 0));
    check_found(row, 7, 2, false, 1, "two bins have one boundary");
    rk_check_close(
        candidates[0].cost, 1.5 + 7, 0,
        "areas of 0 cannot be divided: both sides count as if they were as large as the node");
    /* Two upright lines, with a node of area 4 around them. */
    const rk_bvh_reference lines[] = {box_at(rk_vec(0, 0, 0), rk_vec(0, 1, 0)),
                                      box_at(rk_vec(2, 0, 0), rk_vec(0, 1, 0))};
    check_found(lines, 2, 2, false, 1, "two bins have one boundary");
    rk_check_close(candidates[0].cost, 1.5, 0,
                   "where the node has an area, a side without one costs nothing");
}

static void coinciding_centroids_have_no_candidate(void **state)
{
    (void)state;
    rk_bvh_reference same[20];
    for (uint32_t i = 0; i < 20; i++)
        same[i] =
            (rk_bvh_reference){cube_at(1, 2, 3).box, rk_vec(1.1f, 2.2f, i < 10 ? 0.0f : -0.0f), i};
    check_found(same, 20, 2, false, 0, "an extent of 0 has no bins: do not divide by it");
    check_found(same, 20, 50, true, 0, "nor on any other axis, with any number of bins");
    rk_check(rk_sah_cheapest(candidates, 0) == NULL, "without candidates there is no cheapest");
    check_found(same, 1, 2, true, 0, "a single triangle cannot be split");
    /* Finding none counts only if candidates are found elsewhere. */
    same[7].centroid.x = 3;
    check_found(same, 20, 2, false, 1, "one centroid apart from the others: one split");
    check_counts(&candidates[0], 19, 1, "the one apart is alone");
}

/* --- Bins along x ----------------------------------------------------------------------------- */

static void bins_divide_the_extent_of_the_centroids_equally(void **state)
{
    (void)state;
    /* Centroids at 0.5, 1.5 ... 8.5 in four bins of two units each; the last one ends the extent.
     */
    rk_bvh_reference row[9];
    for (uint32_t i = 0; i < 9; i++)
        row[i] = cube_at((float)(i * 4 % 9), 0, 0);
    check_found(row, 9, 4, false, 3, "four bins have three boundaries");
    for (uint32_t k = 0; k < 3; k++) {
        rk_check_equal(candidates[k].boundary, k + 1,
                       "boundaries 1, 2, 3: the number of bins to the left");
        check_counts(&candidates[k], 2 * k + 2, 7 - 2 * k,
                     "two centroids per bin, three in the last, which has the highest too");
    }
}

static void empty_bins_add_no_candidate_and_no_box(void **state)
{
    (void)state;
    const rk_bvh_reference row[] = {cube_at(5, 5, 5), cube_at(15, 5, 5), cube_at(6, 5, 5),
                                    cube_at(14, 5, 5), cube_at(5, 5, 5)};
    uint32_t found = list(row, 5, 5, false);
    rk_check_equal(found, 1, "of five bins only the outermost are filled: one split");
    check_counts(&candidates[0], 3, 2, "three at 5 and 6, two at 14 and 15");
    rk_check_equal(candidates[0].boundary, 1,
                   "of several boundaries with the same split, the first");
    rk_check_close(candidates[0].box[0].corner[0].x, 5, 0, "an empty bin's box would begin at 0");
    rk_check_close(candidates[0].box[0].corner[1].x, 7, 0, "the left box ends with its cubes");
    rk_check_close(candidates[0].box[1].corner[0].x, 14, 0, "the right box begins with its cubes");
}

static void no_node_has_more_bins_than_triangles(void **state)
{
    (void)state;
    const rk_bvh_reference row[] = {cube_at(0, 0, 0), cube_at(4, 0, 0), cube_at(10, 0, 0)};
    check_found(row, 3, 50, false, 2, "three bins with one cube each");
    rk_check_equal(candidates[1].boundary, 2, "more bins than triangles would mostly be empty");
}

static void tiny_and_huge_extents_are_binned_correctly(void **state)
{
    (void)state;
    /* The smallest floats, far from 0 as well, and the largest, whose difference overflows a float.
     * With 2^23 added, places are as close to each other as floats can be. */
    const float units[] = {0x1p-149f, 0x1p-140f, 0x1p-126f, 1, 0x1p100f, FLT_MAX / 8};
    for (uint32_t u = 0; u < sizeof units / sizeof *units; u++)
        for (int far = 0; far <= (units[u] <= 0x1p100f); far++) {
            /* The ends, and the middles of eight bins of two units each. */
            rk_bvh_reference row[10];
            for (uint32_t i = 0; i < 10; i++) {
                float at = i == 0 ? -8 : i == 9 ? 8 : 2 * (float)i - 9;
                rk_vec3 place = rk_vec((at + (far ? 0x1p23f + 8 : 0)) * units[u], 0, 0);
                row[i] = (rk_bvh_reference){{{place, place}}, place, i};
            }
            uint32_t found = list(row, 10, 8, false);
            rk_check(found == 7,
                     "ten centroids, from %g to %g: got %u candidates, want 7: eight bins over the "
                     "whole extent, none of them empty",
                     (double)row[0].centroid.x, (double)row[9].centroid.x, found);
            for (uint32_t k = 0; k < 7; k++) {
                rk_check_equal(candidates[k].axis, 0, "along x");
                check_counts(&candidates[k], k + 2, 8 - k,
                             "one per bin, two in the first and in the last; an extent may be too "
                             "small to divide by, and it, or a part of it, too large for a float: "
                             "compute the bin in double");
            }
        }
    /* Neighbouring floats still differ. */
    const float places[] = {0, 1, 0x1.fffffep0f, -1, 1e-20f, 1e30f, -3e38f, -0x1p-149f};
    for (uint32_t i = 0; i < sizeof places / sizeof *places; i++) {
        rk_vec3 at = rk_vec(places[i], 0, 0), next = rk_vec(nextafterf(at.x, INFINITY), 0, 0);
        const rk_bvh_reference pair[] = {{{{at, at}}, at, 0}, {{{next, next}}, next, 1}};
        uint32_t found = list(pair, 2, 2, false);
        rk_check(found == 1,
                 "two centroids, at %.9g and the next float: got %u candidates, want 1: no extent "
                 "but 0 is too small, not even for its place",
                 (double)at.x, found);
    }
}

static void check_same_options(const rk_sah_options *got, const rk_sah_options *given)
{
    rk_check(got->bins == given->bins && got->all_axes == given->all_axes,
             "the caller's options, which are constant, were changed from %u bins to %u, all axes "
             "from %d to %d",
             given->bins, got->bins, given->all_axes, got->all_axes);
}

static void check_candidates(const rk_mesh *mesh, rk_sah_options options)
{
    static trial want[RK_SAH_CANDIDATES_MAX];
    uint32_t count = mesh->triangle_count;
    rk_bvh_reference *references = references_of(mesh), *before = references_of(mesh);
    const rk_sah_options given = options;
    uint32_t found = rk_sah_candidates(references, count, &options, candidates);
    rk_check(memcmp(references, before, count * sizeof *references) == 0,
             "listing the candidates changed the caller's %u references, which are constant: only "
             "splitting moves them",
             count);
    check_same_options(&options, &given);
    free(before);
    uint32_t wanted = try_boundaries(references, count, &options, want);
    rk_check(found == wanted,
             "%u triangles, %u bins%s: got %u candidates, want %u: every boundary that divides the "
             "triangles differently, once",
             count, options.bins, options.all_axes ? " on all axes" : "", found, wanted);
    for (uint32_t k = 0; k < found; k++)
        check_split(&candidates[k], &want[k], count);
    free(references);
}

static const uint32_t counts_to_try[] = {2, 3, 7, 49, 50, 51, 300, 3000},
                      bins_to_try[] = {2, 3, 16, 50, RK_SAH_BINS_MAX};
enum {
    COUNTS_TO_TRY = sizeof counts_to_try / sizeof *counts_to_try,
    BINS_TO_TRY = sizeof bins_to_try / sizeof *bins_to_try,
};

static void stretch_along_x(rk_mesh *mesh)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        mesh->positions[i].x *= 100;
}

static void candidates_along_x_equal_brute_force(void **state)
{
    (void)state;
    for (uint32_t c = 0; c < COUNTS_TO_TRY; c++)
        for (uint32_t b = 0; b < BINS_TO_TRY; b++) {
            rk_mesh mesh = make_soup(counts_to_try[c], 0.2f, 10 + b);
            stretch_along_x(&mesh);
            check_candidates(&mesh, (rk_sah_options){bins_to_try[b], false});
            rk_mesh_free(&mesh);
        }
}

/* Processor seconds to list the candidates, which must be right, `times` times: the least of five,
 * because other programs can only add time. */
static double seconds_to_list(const rk_mesh *mesh, uint32_t bins, uint32_t times)
{
    check_candidates(mesh, (rk_sah_options){bins, false});
    rk_bvh_reference *references = references_of(mesh);
    const uint32_t count = mesh->triangle_count, wanted = list(references, count, bins, false);
    double least = INFINITY;
    for (int attempt = 0; attempt < 5; attempt++) {
        double start = rk_clock_thread();
        uint32_t calls = 0;
        while (calls < times && list(references, count, bins, false) == wanted)
            calls++;
        least = fmin(least, rk_clock_thread() - start);
        rk_check(calls == times, "call %u gives another number of candidates than the one before",
                 calls + 1);
    }
    free(references);
    return least;
}

/* Processor seconds to go over the triangles twice, which bins need at least: for the centroids'
 * box, and for the triangles'. The least of five. */
static double seconds_to_merge(const rk_mesh *mesh, uint32_t times)
{
    rk_bvh_reference *references = references_of(mesh);
    double least = INFINITY;
    for (int attempt = 0; attempt < 5; attempt++) {
        double start = rk_clock_thread();
        for (uint32_t call = 0; call < times; call++) {
            rk_box centroids = rk_box_empty(), triangles = rk_box_empty();
            for (uint32_t i = 0; i < mesh->triangle_count; i++)
                centroids = rk_box_add(centroids, references[i].centroid);
            for (uint32_t i = 0; i < mesh->triangle_count; i++)
                triangles = rk_box_merge(triangles, references[i].box);
            volatile float sink = centroids.corner[0].x + triangles.corner[0].x;
            (void)sink;
        }
        least = fmin(least, rk_clock_thread() - start);
    }
    free(references);
    return least;
}

static void many_bins_cost_hardly_more_than_few(void **state)
{
    (void)state;
    /* With O(count + bins), 256 bins instead of 2 take up to twice as long where there are many
     * triangles, and up to five times where there are as few as bins. Testing every triangle at
     * every boundary takes 128 times as long; merging all bins at every boundary, 60 times with
     * few. That is 400 and 240 times as long as merging all boxes once, and with sanitizers
     * 2300 and 3300 times; the right ways are 5 and 25 times, and 20 and 160 with sanitizers. So
     * who slows 2 bins down is not taken for fast. */
    const uint32_t counts[] = {20000, 256}, times[] = {8, 800}, limits[] = {250, 1500};
    for (int i = 0; i < 2; i++) {
        rk_mesh mesh = make_soup(counts[i], 0.01f, 3);
        stretch_along_x(&mesh);
        double few = seconds_to_list(&mesh, 2, times[i]);
        double many = seconds_to_list(&mesh, 256, times[i]);
        double merged = seconds_to_merge(&mesh, times[i]);
        rk_check(many <= 20 * few,
                 "%u triangles: 256 bins take %.3g s and 2 bins %.3g s, want at most 20 times as "
                 "much: count each triangle once, then sweep over the bins",
                 counts[i], many, few);
        rk_check(many <= limits[i] * merged,
                 "%u triangles: 256 bins take %.3g s, want at most %u times the %.3g s of merging "
                 "all centroids, and all boxes, once: 2 bins must not be slow, either",
                 counts[i], many, limits[i], merged);
        rk_mesh_free(&mesh);
    }
}

/* --- Axes ------------------------------------------------------------------------------------- */

static void candidates_are_on_the_longest_axis_of_the_centroids(void **state)
{
    (void)state;
    /* A long beam along x over cubes in a row along y: the node is longest where there is nothing
     * to split. */
    rk_bvh_reference row[5] = {box_at(rk_vec(-100, 0, 0), rk_vec(200, 1, 1))};
    for (uint32_t i = 1; i < 5; i++)
        row[i] = cube_at(0, (float)i * 10, (float)i);
    uint32_t found = list(row, 5, 5, false);
    rk_check(found > 0, "got no candidate, want those along y");
    for (uint32_t k = 0; k < found; k++)
        rk_check_equal(candidates[k].axis, 1, "0, 1, 2: the longest axis of the centroids' box");
    for (int axis = 0; axis < 3; axis++) {
        const rk_bvh_reference pair[] = {cube_at(0, 0, 0), cube_at(axis == 0, axis <= 1, 1)};
        check_found(pair, 2, 2, false, 1, "two cubes");
        rk_check_equal(candidates[0].axis, axis, "among equal extents x before y before z");
        /* All three extents overflow a float. */
        const float half[] = {axis == 0 ? 3e38f : 2e38f, axis == 1 ? 3e38f : 2e38f,
                              axis == 2 ? 3e38f : 2e38f};
        rk_vec3 high = rk_vec(half[0], half[1], half[2]), low = rk_negate(high);
        const rk_bvh_reference far[] = {{{{low, low}}, low, 0}, {{{high, high}}, high, 1}};
        check_found(far, 2, 2, false, 1, "two points");
        rk_check_equal(candidates[0].axis, axis,
                       "-3e38 to 3e38 on one axis, -2e38 to 2e38 on the others");
    }
}

/* Centroids at 0 and `length` on one axis and at 0 and 1 on another, in four combinations. */
static void check_short_axis(int axis, int other, float length)
{
    rk_bvh_reference four[4];
    for (int k = 0; k < 4; k++) {
        float at[3] = {0, 0, 0};
        at[axis] = (float)(k & 1) * length;
        at[other] = (float)(k >> 1);
        four[k] = cube_at(at[0], at[1], at[2]);
    }
    uint32_t found = list(four, 4, 4, true);
    rk_check(found == 2 && candidates[0].axis != candidates[1].axis,
             "four centroids, 0 or %g along %c, 0 or 1 along %c: got %u candidates, want one on "
             "each of the two axes: none is too short",
             (double)length, "xyz"[axis], "xyz"[other], found);
}

static void check_short_axes(void)
{
    for (int axis = 0; axis < 3; axis++)
        for (int other = 0; other < 3; other++) {
            if (axis == other)
                continue;
            check_short_axis(axis, other, 4000);
            check_short_axis(axis, other, 0x1p60f);
        }
}

static void all_axes_are_tried_on_request(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(100, 0.1f, 1);
    rk_bvh_reference *references = references_of(&mesh);
    uint32_t found = list(references, 100, 8, true), on[3] = {0, 0, 0};
    for (uint32_t k = 0; k < found; k++) {
        on[candidates[k].axis]++;
        rk_check(k == 0 || candidates[k].axis >= candidates[k - 1].axis,
                 "candidate %u is on axis %c, after one on %c: want x, then y, then z", k,
                 "xyz"[candidates[k].axis], "xyz"[candidates[k - 1].axis]);
    }
    for (int axis = 0; axis < 3; axis++)
        rk_check_equal(on[axis], 7,
                       "eight bins, none of them empty, have seven boundaries per axis");
    free(references);
    rk_mesh_free(&mesh);
    /* Where all centroids coincide on two of the axes, only the third has candidates. */
    for (int axis = 0; axis < 3; axis++) {
        rk_bvh_reference row[4];
        for (uint32_t i = 0; i < 4; i++) {
            float along = (float)(i * 3 % 4);
            row[i] = cube_at(axis == 0 ? along : 5, axis == 1 ? along : 5, axis == 2 ? along : 5);
        }
        found = list(row, 4, 4, true);
        rk_check(found == 3, "a row of four cubes along %c, on all axes: got %u candidates, want 3",
                 "xyz"[axis], found);
        for (uint32_t k = 0; k < found; k++)
            rk_check_equal(candidates[k].axis, axis, "the axis of the row");
    }
    check_short_axes();
    /* As many candidates as there may be: one cube in each bin of each axis. */
    rk_bvh_reference diagonal[RK_SAH_BINS_MAX];
    for (uint32_t i = 0; i < RK_SAH_BINS_MAX; i++)
        diagonal[i] = cube_at((float)i, (float)i, (float)i);
    check_found(diagonal, RK_SAH_BINS_MAX, RK_SAH_BINS_MAX, true, RK_SAH_CANDIDATES_MAX,
                "256 bins, none of them empty, have 255 boundaries on each of three axes");
}

static void the_first_of_equally_cheap_splits_is_taken(void **state)
{
    (void)state;
    /* Symmetrical, and all numbers are integers: the costs are equal to the bit. */
    rk_bvh_reference square[9];
    for (uint32_t i = 0; i < 9; i++)
        square[i] = cube_at((float)(i % 3), 0, (float)(i / 3));
    uint32_t found = list(square, 9, 3, true);
    rk_check_equal(found, 4, "two boundaries on x, none on y, two on z");
    const rk_sah_split *best = rk_sah_cheapest(candidates, found);
    for (uint32_t k = 1; k < found; k++)
        rk_check_close(candidates[k].cost, candidates[0].cost, 0, "all four cost the same");
    rk_check(best == &candidates[0],
             "got the cheapest on axis %c at boundary %u, want x and 1: among equal costs the "
             "first wins",
             best ? "xyz"[best->axis] : '-', best ? best->boundary : 0);
    /* Splits of a node of billions of triangles, all of which are tested. */
    const double lower = nextafter(3e9, 0), costs[] = {4e9, 3e9, lower, lower};
    rk_sah_split costly[4];
    for (uint32_t k = 0; k < 4; k++) {
        costly[k] = candidates[k];
        costly[k].cost = costs[k];
    }
    for (uint32_t count = 1; count <= 4; count++) {
        best = rk_sah_cheapest(costly, count);
        uint32_t want = count < 3 ? count - 1 : 2;
        rk_check(best == &costly[want],
                 "the first %u of candidates that cost 4e9, 3e9, and twice the next lower double: "
                 "got %s, "
                 "want that of %.17g: no cost is too high to be the lowest, and costs are compared "
                 "in double",
                 count, best ? "another" : "none", costs[want]);
    }
}

static void candidates_equal_brute_force(void **state)
{
    (void)state;
    for (uint32_t c = 0; c < COUNTS_TO_TRY; c++)
        for (uint32_t b = 0; b < BINS_TO_TRY; b++)
            for (int all_axes = 0; all_axes < 2; all_axes++) {
                rk_mesh mesh = make_soup(counts_to_try[c], 0.2f, 10 + b);
                check_candidates(&mesh, (rk_sah_options){bins_to_try[b], all_axes});
                rk_mesh_free(&mesh);
            }
}

/* --- The tree -------------------------------------------------------------------------------- */

static rk_bvh build_with(const rk_mesh *mesh, uint32_t bins, bool all_axes)
{
    rk_sah_options options = {bins, all_axes};
    const rk_sah_options given = options;
    rk_bvh bvh;
    rk_error error;
    uint32_t checksum = mesh_checksum(mesh);
    rk_check_ok(rk_bvh_build_sah(&bvh, mesh, &options, &error), error);
    check_mesh_unchanged(mesh, checksum);
    check_same_options(&options, &given);
    rk_check(rk_bvh_validate(&bvh, mesh, &error),
             "the tree over %u triangles, with %u nodes, is not sound: %s", mesh->triangle_count,
             bvh.node_count, error.text);
    return bvh;
}

static rk_bvh build(const rk_mesh *mesh)
{
    return build_with(mesh, rk_sah_options_default().bins, false);
}

static void no_triangles_give_a_tree_without_nodes(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.node_count, 0, "without triangles there is no root either");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void the_default_is_fifty_bins_on_the_longest_axis(void **state)
{
    (void)state;
    rk_check_equal(rk_sah_options_default().bins, 50, "the classic course's");
    rk_check(!rk_sah_options_default().all_axes,
             "the classic form splits on the longest axis only");
}

/* Triangles whose box is the unit cube, with centroids on a line along x and y. */
static void place_across(rk_mesh *mesh, uint32_t triangle, float where)
{
    mesh->positions[3 * triangle] = rk_vec(0, 1, 0);
    mesh->positions[3 * triangle + 1] = rk_vec(1, 0, 1);
    mesh->positions[3 * triangle + 2] = rk_vec(where, where, 0.5f);
}

static void a_node_is_a_leaf_where_no_split_pays(void **state)
{
    (void)state;
    /* Every box is the node's own: any split costs 1.5 more than testing all triangles. */
    rk_mesh mesh = make_mesh(20);
    for (uint32_t i = 0; i < 20; i++)
        place_across(&mesh, i, (float)i / 19);
    rk_bvh_reference *references = references_of(&mesh);
    check_found(references, 20, 20, false, 19, "one centroid per bin");
    for (uint32_t k = 0; k < 19; k++)
        rk_check_close(candidates[k].cost, 21.5, 0, "both boxes are as large as the node's");
    free(references);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 20, "1.5 + 20 is more than 20: a leaf");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    /* A tie: one flat triangle beside two that coincide, on either half of the node's area. */
    mesh = make_mesh(3);
    for (uint32_t i = 0; i < 3; i++) {
        float x = i ? 2 : 0;
        mesh.positions[3 * i] = rk_vec(x, 0, 0);
        mesh.positions[3 * i + 1] = rk_vec(x + 2, 0, 0);
        mesh.positions[3 * i + 2] = rk_vec(x + 1, 1, 0);
    }
    references = references_of(&mesh);
    check_found(references, 3, 3, false, 1, "two places of centroids");
    rk_check_close(candidates[0].cost, 3, 0, "1.5 + (4 x 1 + 4 x 2) / 8");
    free(references);
    bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 3, "3 is no less than 3: a leaf, too");
    rk_bvh_free(&bvh);
    /* The one becomes smaller by a rounding of its height. */
    mesh.positions[2].y = 1 - 0x1p-24f;
    bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 0, "3 - 2^-25 is less than 3: compare the costs in double");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void two_distant_triangles_are_split(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(2, 0.01f, 5);
    for (uint32_t i = 3; i < 6; i++)
        mesh.positions[i].x += 100;
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 0, "a little more than 1.5 is less than 2: no leaf yet");
    rk_check_equal(bvh.nodes[bvh.nodes[0].first].count, 1, "one to the left");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* What becomes of a node. */
typedef enum node_case {
    CHEAPEST,
    LEAF,
    LEAF_THOUGH_A_SPLIT_PAYS, /* which does not fit the depth */
    BALANCED,
    BALANCED_THOUGH_A_SPLIT_PAYS,
    HALVED,
    CASES,
} node_case;

/* A tree and the data to check its nodes against. */
typedef struct comparison {
    const rk_bvh *bvh;
    const rk_bvh_reference *references; /* of the mesh */
    rk_bvh_reference *some;             /* room for one node's references */
    rk_sah_options options;
    uint32_t cases[CASES]; /* the nodes of each case */
} comparison;

/* May a split leave this many triangles on one side of a node of this level? */
static bool fits_below(uint32_t level, uint32_t triangles)
{
    uint64_t most = RK_BVH_LEAF_MAX;
    for (uint32_t below = level + 2; below < RK_BVH_LEVELS_MAX && most < triangles; below++)
        most *= 2;
    return level + 1 < RK_BVH_LEVELS_MAX && triangles <= most;
}

static node_case case_of(uint32_t level, uint32_t count, const trial *cheapest, uint32_t smaller)
{
    bool pays = cheapest->cost < count;
    const uint32_t *sides = cheapest->triangles;
    if (pays && fits_below(level, sides[0] > sides[1] ? sides[0] : sides[1]))
        return CHEAPEST;
    if (count <= RK_BVH_LEAF_MAX)
        return pays ? LEAF_THOUGH_A_SPLIT_PAYS : LEAF;
    if (smaller && fits_below(level, count - smaller))
        return pays ? BALANCED_THOUGH_A_SPLIT_PAYS : BALANCED;
    return HALVED;
}

static void check_larger_than_a_leaf(const rk_bvh *bvh, const rk_bvh_node *node, uint32_t level,
                                     uint32_t count, uint32_t smaller)
{
    uint32_t left = node->count ? 0 : rk_bvh_range_of(bvh, node->first).count;
    uint32_t got = left < count - left ? left : count - left;
    rk_check(got == smaller,
             "a node of %u triangles, depth_left = %u: got %u of them in the smaller child, want "
             "%u: where no split pays, or the cheapest does not fit the depth, such a node takes "
             "the most balanced split; where not even that one fits, half of its triangles",
             count, RK_BVH_LEVELS_MAX - 1 - level, got, smaller);
}

static bool is_side_of(const comparison *c, const rk_bvh_node *node, const trial *t, int side)
{
    uint32_t child = node->first + (uint32_t)side;
    return rk_bvh_range_of(c->bvh, child).count == t->triangles[side] &&
           is_box_of_side(&c->bvh->nodes[child].box, t, side);
}

static bool is_split_so(const comparison *c, const rk_bvh_node *node, const trial *t)
{
    return is_side_of(c, node, t, 0) && is_side_of(c, node, t, 1);
}

/* A triangle that is on the other side than in the cheapest split, as "; ..."; "" if there is none.
 */
static const char *strayed(const comparison *c, const rk_bvh_node *node, const trial *t,
                           uint32_t count)
{
    static char text[400];
    uint32_t left = rk_bvh_range_of(c->bvh, node->first).count;
    uint32_t bins = c->options.bins < count ? c->options.bins : count;
    double low = INFINITY, high = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        low = fmin(low, (double)rk_axis(c->some[i].centroid, t->axis));
        high = fmax(high, (double)rk_axis(c->some[i].centroid, t->axis));
    }
    text[0] = 0;
    for (uint32_t i = 0; i < count && !text[0]; i++) {
        double centroid = (double)rk_axis(c->some[i].centroid, t->axis);
        double place = (centroid - low) * (bins / (high - low));
        if ((place < t->boundary) != (i < left))
            snprintf(text, sizeof text,
                     "; one that went %s: centroid %.17g of low %.17g to high %.17g, %u bins, so "
                     "in double at %.17g, bin %u",
                     i < left ? "left" : "right", centroid, low, high, bins, place,
                     place < bins ? (uint32_t)place : bins - 1);
    }
    return text;
}

/* Where two splits cost the same, roundings decide which is the cheapest: either will do. */
static void compare_with_brute_force(const rk_bvh_node *node, uint32_t level, void *context)
{
    comparison *c = context;
    static trial all[RK_SAH_CANDIDATES_MAX];
    rk_bvh_range range = rk_bvh_range_of(c->bvh, (uint32_t)(node - c->bvh->nodes));
    rk_box box = rk_box_empty();
    for (uint32_t i = 0; i < range.count; i++) {
        c->some[i] = c->references[c->bvh->triangles[range.begin + i].index];
        box = rk_box_merge(box, c->some[i].box);
    }
    for (int k = 0; k < 6; k++)
        rk_check(rk_axis(node->box.corner[k / 3], k % 3) == rk_axis(box.corner[k / 3], k % 3),
                 "a node of %u triangles: got %.9g for the %s %c of its box, want %.9g: the "
                 "smallest box around its triangles",
                 range.count, (double)rk_axis(node->box.corner[k / 3], k % 3),
                 k / 3 ? "highest" : "lowest", "xyz"[k % 3],
                 (double)rk_axis(box.corner[k / 3], k % 3));
    uint32_t found = try_boundaries(c->some, range.count, &c->options, all);
    trial best = {.cost = INFINITY};
    uint32_t smaller = 0; /* of the two sides of the most balanced split */
    for (uint32_t k = 0; k < found; k++) {
        const uint32_t *sides = all[k].triangles;
        uint32_t smaller_side = sides[0] < sides[1] ? sides[0] : sides[1];
        smaller = smaller_side > smaller ? smaller_side : smaller;
        if (all[k].cost < best.cost)
            best = all[k];
    }
    node_case is = case_of(level, range.count, &best, smaller);
    c->cases[is]++;
    if (is >= BALANCED) {
        check_larger_than_a_leaf(c->bvh, node, level, range.count,
                                 is == HALVED ? range.count / 2 : smaller);
        return;
    }
    rk_check((is == CHEAPEST) == (node->count == 0),
             "a node of %u triangles, depth_left = %u, whose cheapest split costs %.9g: got %s, "
             "want %s",
             range.count, RK_BVH_LEVELS_MAX - 1 - level, best.cost,
             node->count ? "a leaf" : "an inner node", is == CHEAPEST ? "an inner node" : "a leaf");
    for (uint32_t k = 0; k < found && is == CHEAPEST; k++)
        if (all[k].cost <= (1 + 2 * cost_tolerance) * best.cost && is_split_so(c, node, &all[k]))
            return;
    for (int side = 0; side < 2 && is == CHEAPEST; side++) {
        uint32_t got = rk_bvh_range_of(c->bvh, node->first + (uint32_t)side).count;
        rk_check(is_side_of(c, node, &best, side),
                 "a node of %u triangles: its %s child has %u of them, want the %u, and their box, "
                 "of the cheapest split, on axis %c at boundary %u: a triangle goes to the side on "
                 "which its bin was counted%s",
                 range.count, side ? "right" : "left", got, best.triangles[side], "xyz"[best.axis],
                 best.boundary, strayed(c, node, &best, range.count));
    }
}

/* Adds the nodes of each case to `cases`. */
static void check_nodes(const rk_mesh *mesh, rk_sah_options options, bool only_the_root,
                        uint32_t *cases)
{
    rk_bvh bvh = build_with(mesh, options.bins, options.all_axes);
    rk_bvh_reference *references = references_of(mesh);
    comparison c = {
        &bvh, references, calloc(mesh->triangle_count, sizeof *references), options, {0}};
    rk_check(c.some != NULL, "no memory for %u references", mesh->triangle_count);
    if (only_the_root)
        compare_with_brute_force(&bvh.nodes[0], 0, &c);
    else
        rk_bvh_visit(&bvh, compare_with_brute_force, &c);
    for (int k = 0; k < CASES; k++)
        cases[k] += c.cases[k];
    free(c.some);
    free(references);
    rk_bvh_free(&bvh);
}

static void check_tree(const rk_mesh *mesh, rk_sah_options options)
{
    check_nodes(mesh, options, false, (uint32_t[CASES]){0});
}

static void check_constant_options(void)
{
    rk_mesh mesh = make_soup(50, 0.05f, 3);
    const rk_sah_options options = rk_sah_options_default();
    const rk_sah_options *constant = rk_read_only(&options, sizeof options, "options");
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_sah(&bvh, &mesh, constant, &error), error);
    rk_read_only_free();
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void every_node_is_split_where_brute_force_would(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 2, 3, 5, 50, 51, 400, 3000};
    for (uint32_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        rk_mesh mesh = make_soup(counts[i], 0.05f, 20 + i);
        check_tree(&mesh, rk_sah_options_default());
        check_tree(&mesh, (rk_sah_options){16, true});
        check_tree(&mesh, (rk_sah_options){2, false});
        if (counts[i] <= 400)
            check_tree(&mesh, (rk_sah_options){RK_SAH_BINS_MAX, true});
        rk_mesh_free(&mesh);
    }
    /* The root of a large mesh, ever less dense along x: the cheapest split is not the most
     * balanced. */
    rk_mesh mesh = make_soup(110000, 0.01f, 28);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float x = mesh.positions[i].x + 1;
        mesh.positions[i].x = 2 * x * x;
    }
    check_nodes(&mesh, (rk_sah_options){8, false}, true, (uint32_t[CASES]){0});
    rk_mesh_free(&mesh);
    check_constant_options();
}

static void rows_of_whole_numbers_are_split_as_counted(void **state)
{
    (void)state;
    /* Centroids exactly on boundaries between bins: whoever computes the boundary's place, and not
     * the centroid's bin once more, moves some of them to the other side. */
    for (uint32_t n = 3; n <= 61; n++) {
        rk_mesh mesh = make_mesh(n);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_vec(3 * (float)(i / 3), i % 3 == 1, i % 3 == 2);
        for (uint32_t bins = 2; bins <= n && bins <= 60; bins++)
            check_tree(&mesh, (rk_sah_options){bins, false});
        rk_mesh_free(&mesh);
    }
}

static void trees_cost_less_than_the_median_except_glass_on_one_axis(void **state)
{
    (void)state;
    const char *const names[] = {"cube",    "cornell", "cornell-glass", "cornell-light",
                                 "panes",   "panes:1", "glass",         "sphere",
                                 "spheres", "teapot",  "statue:967",    "statue:20000"};
    for (uint32_t i = 0; i < sizeof names / sizeof *names; i++) {
        rk_scene scene;
        rk_error error;
        rk_check_ok(rk_builtin_scene(&scene, names[i], &error), error);
        rk_bvh median;
        rk_check_ok(rk_bvh_build_median(&median, &scene.mesh, &error), error);
        double limit = rk_bvh_measure(&median).sah_cost;
        rk_bvh_free(&median);
        /* In "glass" few splits on the longest axis pay: three large leaves cost 18.4, the median's
         * eight 17.2. On all axes it is 7.0. */
        bool one_axis_pays = strcmp(names[i], "glass") != 0;
        for (int all_axes = !one_axis_pays; all_axes < 2; all_axes++) {
            rk_bvh bvh = build_with(&scene.mesh, 50, all_axes);
            double cost = rk_bvh_measure(&bvh).sah_cost;
            rk_check(cost < limit,
                     "%s, %s: got a tree of cost %.6g, want less than the %.6g of median splits",
                     names[i], all_axes ? "all axes" : "longest axis", cost, limit);
            rk_bvh_free(&bvh);
        }
        rk_scene_free(&scene);
    }
}

/* --- Difficult meshes ------------------------------------------------------------------------ */

/* Build has found the tree to be sound, so few rays will do; 24 go along each axis. */
static void check_rays(const rk_mesh *mesh, const rk_bvh *bvh, uint32_t rays, uint32_t seed)
{
    rk_counters counters = {0};
    const rk_box bounds = rk_mesh_bounds(mesh);
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray(i, seed, bounds);
        rk_hit want = closest_by_brute_force(mesh, &ray);
        rk_hit got = rk_bvh_closest(bvh, &ray, &counters);
        rk_check(got.triangle == want.triangle && got.t == want.t,
                 "ray %u: got triangle %u at t = %.9g, want %u at %.9g, by brute force", i,
                 got.triangle, (double)got.t, want.triangle, (double)want.t);
        rk_check(rk_bvh_occluded(bvh, &ray, &counters) == (want.triangle != RK_MISS),
                 "ray %u: occluded differs from brute force", i);
    }
}

static void rays_find_the_same_hits_as_brute_force(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 5, 50, 500, 3000};
    for (uint32_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (int all_axes = 0; all_axes < 2; all_axes++) {
            rk_mesh mesh = make_soup(counts[i], 0.1f, 30 + i);
            rk_bvh bvh = build_with(&mesh, 50, all_axes);
            check_rays(&mesh, &bvh, 200, 40 + i);
            rk_bvh_free(&bvh);
            rk_mesh_free(&mesh);
        }
}

static void identical_triangles_become_leaves_of_64_at_most(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(1000);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_vec(i % 3 == 1, i % 3 == 2, 0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(rk_bvh_measure(&bvh).leaves, 16,
                   "no boundary: 1,000 are halved until they fit into leaves of 64");
    rk_check_equal(rk_bvh_measure(&bvh).levels, 5, "1,000, 500, 250, 125, then 62 or 63");
    check_rays(&mesh, &bvh, 24, 50);
    rk_bvh_free(&bvh);
    for (uint32_t n = RK_BVH_LEAF_MAX - 1; n <= RK_BVH_LEAF_MAX + 1; n++) {
        mesh.triangle_count = n;
        bvh = build(&mesh);
        rk_check(rk_bvh_measure(&bvh).leaves == (n <= RK_BVH_LEAF_MAX ? 1 : 2),
                 "%u equal triangles: got %u leaves, want %s: RK_BVH_LEAF_MAX, 64, still fit into "
                 "one",
                 n, rk_bvh_measure(&bvh).leaves, n <= RK_BVH_LEAF_MAX ? "one" : "two");
        rk_bvh_free(&bvh);
    }
    /* The same where centroids differ, but no split pays. */
    for (uint32_t n = RK_BVH_LEAF_MAX - 1; n <= RK_BVH_LEAF_MAX + 1; n++) {
        mesh.triangle_count = n;
        for (uint32_t i = 0; i < n; i++)
            place_across(&mesh, i, (float)i / (float)(n - 1));
        bvh = build(&mesh);
        rk_check(rk_bvh_measure(&bvh).leaves == (n <= RK_BVH_LEAF_MAX ? 1 : 2),
                 "%u triangles with the same box: got %u leaves, want %s: no split pays, and "
                 "RK_BVH_LEAF_MAX, 64, still fit into one",
                 n, rk_bvh_measure(&bvh).leaves, n <= RK_BVH_LEAF_MAX ? "one" : "two");
        rk_bvh_free(&bvh);
    }
    mesh.triangle_count = 1000;
    rk_mesh_free(&mesh);
}

static void large_nodes_are_split_even_where_no_split_pays(void **state)
{
    (void)state;
    /* A hundred triangles from corner to corner of a cube, ten thousand small ones among them. Each
     * boundary has large ones on both sides, so no split pays, yet one leaf with all of them would
     * be bad. */
    const uint32_t large = 100, n = 10100;
    rk_mesh mesh = make_soup(n, 0.001f, 6);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_add(rk_scale(mesh.positions[i], 0.15f), rk_vec(0.5f, 0.5f, 0.5f));
    for (uint32_t i = 0; i < large; i++)
        place_across(&mesh, i * (n / large), (float)i / (float)(large - 1));
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    const uint32_t rays = 500;
    const rk_box bounds = rk_mesh_bounds(&mesh);
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray(i, 7, bounds);
        rk_bvh_closest(&bvh, &ray, &counters);
    }
    uint64_t tests = counters.triangle_tests / rays;
    /* Measured: 108 by balanced splits, 191 where the triangles are halved in the order of the
     * mesh, 1,018 by the cheapest splits, which separate a few at a time. */
    rk_check(tests < 150,
             "got %llu triangle tests per ray, want fewer than 150: where no split pays, but a "
             "leaf would be too large, take the most balanced one",
             (unsigned long long)tests);
    check_rays(&mesh, &bvh, 24, 8);
    rk_bvh_free(&bvh);
    check_tree(&mesh, rk_sah_options_default());
    rk_mesh_free(&mesh);
    /* All boxes are the same. On x, the longest axis, most centroids are in the first bin; on y
     * they are evenly spaced. */
    mesh = make_mesh(200);
    for (uint32_t i = 0; i < 200; i++) {
        place_across(&mesh, i, powf((float)i / 199, 8));
        mesh.positions[3 * i + 2].y = (float)(i * 7 % 200) / 398;
    }
    check_tree(&mesh, (rk_sah_options){16, true});
    rk_mesh_free(&mesh);
}

static void find_largest(const rk_bvh_node *node, uint32_t level, void *context)
{
    (void)level;
    uint32_t *largest = context;
    *largest = node->count > *largest ? node->count : *largest;
}

static uint32_t largest_leaf_of(const rk_mesh *mesh, uint32_t bins)
{
    const rk_sah_options options = {bins, false};
    rk_bvh bvh;
    rk_error error;
    uint32_t largest = 0;
    rk_check_ok(rk_bvh_build_sah(&bvh, mesh, &options, &error), error);
    rk_bvh_visit(&bvh, find_largest, &largest);
    rk_bvh_free(&bvh);
    return largest;
}

/* Each triangle half as large and half as far from 0 as the one before: with two bins, each split
 * takes one octave away, and there are twice as many octaves as levels. Eight triangles an octave
 * are too many for one last leaf. */
static rk_mesh make_progression(float side, int axis)
{
    const uint32_t octaves = 2 * RK_BVH_LEVELS_MAX;
    rk_mesh mesh = make_soup(8 * octaves, 0.05f, 9);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        rk_vec3 p = rk_add(mesh.positions[i], rk_vec(6 * side, 0, 0));
        p = axis == 0 ? p : axis == 1 ? rk_vec(p.z, p.x, p.y) : rk_vec(p.y, p.z, p.x);
        mesh.positions[i] = rk_scale(p, ldexpf(1, 40 - (int)(i / 24)));
    }
    return mesh;
}

/* Triangles each a quarter as large and as far from 0 as the one before, of which each split takes
 * one away, until one more level may follow; then a crowd in three places, 9 to 7 to 4. Where they
 * are narrow the cheapest split takes the 4 away, otherwise none pays. */
static rk_mesh make_progression_to_a_crowd(uint32_t crowd, bool narrow, float side)
{
    const uint32_t alone = RK_BVH_LEVELS_MAX - 2;
    const float places[2][3][3] = {
        {{0, 1, 0}, {0, 1, 0.5f}, {0, 1, 1}},
        {{0, 0.625f, 0.25f}, {0.25f, 0.6875f, 0.6875f}, {0.9375f, 1, 1}}};
    rk_mesh mesh = make_mesh(alone + crowd);
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        uint32_t in_turn = i * 7 % 20, place = in_turn < 9 ? 0 : in_turn < 16 ? 1 : 2;
        const float *x = i < alone ? (const float[]){1, 2, 1} : places[narrow][place];
        float scale = ldexpf(1, 60 - 2 * (int)(i < alone ? i : alone));
        const rk_vec3 corner[] = {{x[0], 1, 0}, {x[1], 0, 1}, {x[2], 0.5f, 0.5f}};
        for (uint32_t k = 0; k < 3; k++)
            mesh.positions[3 * i + k] = rk_scale(rk_mul(corner[k], rk_vec(side, 1, 1)), scale);
    }
    return mesh;
}

static void check_progression(const rk_mesh *mesh, uint32_t bins, uint32_t *cases)
{
    uint32_t largest = largest_leaf_of(mesh, bins);
    rk_check(largest <= RK_BVH_LEAF_MAX,
             "got a leaf of %u triangles, want %d at most: where depth_left is 0 no node can be "
             "split, so before that a split may leave no side more than RK_BVH_LEAF_MAX, doubled "
             "for each level that may follow",
             largest, RK_BVH_LEAF_MAX);
    rk_bvh bvh = build_with(mesh, bins, false);
    uint32_t levels = rk_bvh_measure(&bvh).levels;
    rk_check(
        bins > 2 || levels > 40,
        "got %u levels with two bins, want over 40: splits were refused that leave no side more "
        "than RK_BVH_LEAF_MAX << levels that may follow; that product has 64 bits",
        levels);
    check_rays(mesh, &bvh, 10, 11);
    rk_bvh_free(&bvh);
    check_nodes(mesh, (rk_sah_options){bins, false}, false, cases);
}

static void a_geometric_progression_is_not_too_deep(void **state)
{
    (void)state;
    uint32_t cases[CASES] = {0};
    for (int k = 0; k < 6; k++) {
        rk_mesh mesh = make_progression(k % 2 ? -1 : 1, k / 2);
        const uint32_t bins[] = {2, 3, 50};
        for (int b = 0; b < 3; b++)
            check_progression(&mesh, bins[b], cases);
        rk_mesh_free(&mesh);
    }
    for (uint32_t crowd = RK_BVH_LEAF_MAX; crowd <= 2 * RK_BVH_LEAF_MAX; crowd += 3)
        for (int k = 0; k < 4; k++) {
            rk_mesh mesh = make_progression_to_a_crowd(crowd, k % 2, k / 2 ? -1 : 1);
            check_progression(&mesh, 3, cases);
            rk_mesh_free(&mesh);
        }
    for (int k = 0; k < CASES; k++)
        rk_check(cases[k] > 0, "no node of case %d: this test cannot tell", k);
}

static void flat_long_and_huge_meshes_equal_brute_force(void **state)
{
    (void)state;
    const rk_vec3 scales[] = {{1, 1, 0},
                              {0, 1, 0},
                              {0, 0, 0},
                              {1e6f, 1, 1e-6f},
                              {1e15f, 1e15f, 1e15f},
                              {1e-6f, 1e-6f, 1e-6f}};
    for (uint32_t s = 0; s < sizeof scales / sizeof *scales; s++) {
        rk_mesh mesh = make_soup(200, 0.1f, 60 + s);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_mul(mesh.positions[i], scales[s]);
        rk_bvh bvh = build(&mesh);
        check_rays(&mesh, &bvh, 48, s);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void coordinates_near_the_largest_float_build_as_good_a_tree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(2000, 0.05f, 12);
    rk_bvh plain = build(&mesh);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_scale(mesh.positions[i], 0x1p127f);
    rk_bvh huge = build(&mesh);
    /* Scaling by a power of two changes no ratio of areas, so the sums are equal but for their
     * roundings: one for each of up to 4,000 nodes. */
    double got = rk_bvh_measure(&huge).sah_cost, want = rk_bvh_measure(&plain).sah_cost;
    rk_check_close(got, want, 4000 * 0x1p-53 * want,
                   "areas overflow a float, and so may an extent, or a part of it: compute them in "
                   "double");
    rk_bvh_free(&plain);
    rk_bvh_free(&huge);
    rk_mesh_free(&mesh);
}

static void a_scaled_mesh_builds_the_same_tree(void **state)
{
    (void)state;
    /* Scaling by a power of two changes no bit of a fraction, and no ratio of areas. At 2^-70 those
     * areas are too small for a float, at 2^70 too large; at 2^127 extents are, too. */
    const int powers[] = {-100, -70, -40, -15, 40, 70, 127};
    rk_mesh mesh = make_soup(1000, 0.05f, 13), scaled = make_mesh(1000);
    rk_bvh plain = build(&mesh);
    for (size_t p = 0; p < sizeof powers / sizeof *powers; p++) {
        float scale = ldexpf(1, powers[p]);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            scaled.positions[i] = rk_scale(mesh.positions[i], scale);
        rk_bvh bvh = build(&scaled);
        rk_check(
            bvh.node_count == plain.node_count,
            "scaled by 2^%d: got %u nodes, want the %u of the mesh as it was: no area but 0 is "
            "too small to divide by, in double",
            powers[p], bvh.node_count, plain.node_count);
        for (uint32_t i = 0; i < bvh.node_count; i += i ? 1 : 2) { /* node 1 is unused */
            rk_bvh_node got = bvh.nodes[i], want = plain.nodes[i];
            for (int k = 0; k < 2; k++)
                want.box.corner[k] = rk_scale(want.box.corner[k], scale);
            rk_check(memcmp(&got, &want, sizeof got) == 0,
                     "scaled by 2^%d: node %u has another box or other triangles than in the mesh "
                     "as it was: no number in a split depends on the scale",
                     powers[p], i);
        }
        rk_bvh_free(&bvh);
    }
    rk_bvh_free(&plain);
    rk_mesh_free(&mesh);
    rk_mesh_free(&scaled);
}

static void more_than_65535_triangles_are_counted(void **state)
{
    (void)state;
    /* One cube in three is far from the others. */
    const uint32_t n = 210000;
    rk_bvh_reference *row = calloc(n, sizeof *row);
    rk_check(row != NULL, "no memory for %u references", n);
    for (uint32_t i = 0; i < n; i++)
        row[i] = cube_at(i % 3 ? 0 : 9, 0, 0);
    check_found(row, n, 2, false, 1, "two bins have one boundary");
    for (uint32_t i = 0; i < 60000; i++)
        row[i] = cube_at((float)(2 * i), 0, 0);
    check_found(row, 60000, 50, false, 49,
                "60,000 cubes in a row: all 50 bins are taken, in large nodes, too");
    for (uint32_t i = 0; i < n; i++)
        row[i] = cube_at(i % 3 ? 0 : 9, 0, 0);
    list(row, n, 2, false);
    check_counts(&candidates[0], n / 3 * 2, n / 3, "a bin may have more than 65,535 triangles");
    rk_check_close(candidates[0].cost, 1.5 + 6.0 * n / 42, 4 * cost_tolerance * n,
                   "1.5 + (area_left N_left + area_right N_right) / area");
    free(row);
}

static bool build_by_default(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    const rk_sah_options options = rk_sah_options_default();
    bool built = rk_bvh_build_sah(bvh, mesh, &options, error);
    rk_check(built || (!bvh->nodes && !bvh->triangles && bvh->node_count == 0),
             "got false, but not the empty tree that rk_bvh_free leaves: whoever releases it once "
             "more releases memory twice");
    return built;
}

static void where_memory_runs_out_nothing_is_kept(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(50, 0.05f, 14);
    check_every_allocation_failing(&mesh, build_by_default);
    rk_mesh_free(&mesh);
}

static void building_a_large_tree_takes_no_more_stack(void **state)
{
    (void)state;
    rk_mesh small = make_soup(100, 0.1f, 41), large = make_soup(50000, 0.1f, 41);
    check_stack_does_not_grow(&small, &large, build_by_default);
    rk_mesh_free(&small);
    rk_mesh_free(&large);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(where_memory_runs_out_nothing_is_kept),
    cmocka_unit_test(without_area_a_split_costs_all_its_triangles),
    cmocka_unit_test(candidates_along_x_equal_brute_force),
    cmocka_unit_test(rows_of_whole_numbers_are_split_as_counted),
    cmocka_unit_test(no_triangles_give_a_tree_without_nodes),
    cmocka_unit_test(the_default_is_fifty_bins_on_the_longest_axis),
    cmocka_unit_test(bins_divide_the_extent_of_the_centroids_equally),
    cmocka_unit_test(no_centroid_is_beyond_the_last_bin),
    cmocka_unit_test(a_split_costs_as_computed_by_hand),
    cmocka_unit_test(empty_bins_add_no_candidate_and_no_box),
    cmocka_unit_test(coinciding_centroids_have_no_candidate),
    cmocka_unit_test(tiny_and_huge_extents_are_binned_correctly),
    cmocka_unit_test(no_node_has_more_bins_than_triangles),
    cmocka_unit_test(candidates_are_on_the_longest_axis_of_the_centroids),
    cmocka_unit_test(all_axes_are_tried_on_request),
    cmocka_unit_test(the_first_of_equally_cheap_splits_is_taken),
    cmocka_unit_test(candidates_equal_brute_force),
    cmocka_unit_test(many_bins_cost_hardly_more_than_few),
    cmocka_unit_test(two_distant_triangles_are_split),
    cmocka_unit_test(a_node_is_a_leaf_where_no_split_pays),
    cmocka_unit_test(every_node_is_split_where_brute_force_would),
    cmocka_unit_test(rays_find_the_same_hits_as_brute_force),
    cmocka_unit_test(identical_triangles_become_leaves_of_64_at_most),
    cmocka_unit_test(large_nodes_are_split_even_where_no_split_pays),
    cmocka_unit_test(a_geometric_progression_is_not_too_deep),
    cmocka_unit_test(flat_long_and_huge_meshes_equal_brute_force),
    cmocka_unit_test(coordinates_near_the_largest_float_build_as_good_a_tree),
    cmocka_unit_test(a_scaled_mesh_builds_the_same_tree),
    cmocka_unit_test(more_than_65535_triangles_are_counted),
    cmocka_unit_test(building_a_large_tree_takes_no_more_stack),
    cmocka_unit_test(trees_cost_less_than_the_median_except_glass_on_one_axis),
};

RK_SUITE("sah_binning", tests)
