/* Bloom: weights against rows of Pascal's triangle in big integers, the separable filter against
 * the full one in double, borders against sums worked out by hand. */
#define _DEFAULT_SOURCE /* mincore */

#include "test.h"

#include "base/random.h"
#include "base/table.h"
#include "features/bloom.h"

#include <sys/mman.h>
#include <unistd.h>

/* --- Helpers ---------------------------------------------------------------------------------- */

static const rk_vec3 white = {1, 1, 1};
static const char *const border_names[] = {"zero", "clamp", "renormalize"};

/* Roundings of a few operations on numbers of order one, each 2^-24. */
static const double few_roundings = 8 * 0x1p-24;

static rk_vec3 random_colour(uint32_t i)
{
    return rk_vec(rk_unit_float(rk_case(i, 0, 0, 1)), rk_unit_float(rk_case(i, 1, 0, 1)),
                  rk_unit_float(rk_case(i, 2, 0, 1)));
}

/* Memory of exactly this size: sanitizers know where allocated memory ends, but not where an array
 * of the suite ends. Without them, any bytes that malloc leaves behind it are NaN. */
static void *exactly(size_t size)
{
    size_t least = size > 0 ? size : 1, more = least + 64;
    void *longer = malloc(more);
    rk_check(longer != NULL, "no memory for %zu bytes", more);
    memset(longer, 0xff, more);
    void *memory = realloc(longer, least);
    rk_check(memory != NULL, "no memory for %zu bytes", least);
    return memory;
}

static void *exact_copy(const void *values, size_t size)
{
    void *copy = exactly(size);
    memcpy(copy, values, size);
    return copy;
}

/* Floats that a unit must not write, on both sides of its output; enough for a block. */
enum { fence = RK_BLOOM_BLOCK };

/* `room` is for count floats and two fences. Returns the floats between, which hold NaN; fences
 * hold a number so small that adding anything changes it. */
static float *fenced(float *room, size_t count)
{
    memset(room, 0x2a, (count + 2 * fence) * sizeof *room);
    memset(room + fence, 0xff, count * sizeof *room);
    return room + fence;
}

static void check_fences(const float *floats, size_t count, const char *name)
{
    uint32_t bits, untouched = 0x2a2a2a2a;
    for (size_t i = 0; i < fence; i++) {
        memcpy(&bits, floats - 1 - i, sizeof bits);
        rk_check(bits == untouched, "%s: float -%zu was written; the first one is float 0", name,
                 i + 1);
        memcpy(&bits, floats + count + i, sizeof bits);
        rk_check(bits == untouched, "%s: float %zu was written; there are %zu, from 0 on", name,
                 count + i, count);
    }
}

static rk_bloom_filter filter_of(const float *weights, uint32_t reach, rk_bloom_border border)
{
    return (rk_bloom_filter){reach, weights, border};
}

/* --- Luminance and threshold ------------------------------------------------------------------ */

static const char *mistake_of_luminance(rk_vec3 colour, double got, double want, double tolerance)
{
    const double r = (double)colour.x, g = (double)colour.y, b = (double)colour.z;
    return rk_mistake_in(
        got, want, tolerance,
        RK_MISTAKES({(r + g + b) / 3, "it is the mean of red, green and blue"},
                    {0.299 * r + 0.587 * g + 0.114 * b,
                     "the weights are those of BT.601, of old television"},
                    {0.2126 * b + 0.7152 * g + 0.0722 * r, "red and blue are exchanged"},
                    {fmax(r, fmax(g, b)), "it is the largest channel"}));
}

static void check_luminance(rk_vec3 colour, const char *name)
{
    double want = 0.2126 * (double)colour.x + 0.7152 * (double)colour.y + 0.0722 * (double)colour.z;
    double got = (double)rk_bloom_luminance(colour);
    rk_vec3 size = rk_abs3(colour);
    double tolerance = few_roundings * (double)rk_max(size.x, rk_max(size.y, size.z));
    rk_check(fabs(got - want) <= tolerance,
             "the luminance of %s, (%g, %g, %g): got %.9g, want %.9g within %.3g: the weights of "
             "BT.709%s",
             name, (double)colour.x, (double)colour.y, (double)colour.z, got, want, tolerance,
             mistake_of_luminance(colour, got, want, tolerance));
}

static void luminance_weighs_green_most(void **state)
{
    (void)state;
    check_luminance(rk_vec(3, 2, 1), "three red, two green and one blue");
    check_luminance(rk_vec(1, 0, 0), "red");
    check_luminance(rk_vec(0, 1, 0), "green");
    check_luminance(rk_vec(0, 0, 1), "blue");
    check_luminance(rk_vec(-1, 0.5f, 0), "minus red and half green, as filters give it");
    check_luminance(rk_vec(-1, -2, -3), "a colour below 0");
    check_luminance(rk_vec(0x1p120f, 0x1p119f, 0), "a very bright colour");
    check_luminance(rk_vec(0x1p-80f, 0, 0x1p-79f), "a very dark colour");
    for (uint32_t i = 0; i < 100; i++) {
        rk_vec3 a = random_colour(i), b = random_colour(i + 1);
        check_luminance(a, "a random colour");
        check_luminance(rk_vec(b.x, a.y, a.z), "the same with another red");
        check_luminance(rk_vec(b.x, b.y, a.z), "the same with another green");
        check_luminance(b, "the same with another blue");
    }
}

static void the_luminance_of_a_grey_is_the_grey(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        float grey = i == 0 ? 1 : 2 * rk_unit_float(rk_case(i, 0, 0, 2));
        if (i > 5000) /* of any size, and below 0 */
            grey = ldexpf(grey - 1, (int)(i % 250) - 125);
        float got = rk_bloom_luminance(rk_vec(grey, grey, grey));
        rk_check(got == grey,
                 "the luminance of grey %.9g: got %.9g, want %.9g: rounding must not push it below "
                 "a threshold that it reaches",
                 (double)grey, (double)got, (double)grey);
    }
}

static void check_bright(rk_vec3 colour, float threshold, bool want, const char *hint)
{
    rk_check(rk_bloom_is_bright(colour, threshold) == want,
             "(%g, %g, %g) at a threshold of %.9g: got %s, want %s: %s", (double)colour.x,
             (double)colour.y, (double)colour.z, (double)threshold, want ? "dark" : "bright",
             want ? "bright" : "dark", hint);
}

static void a_pixel_at_the_threshold_is_bright(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        float grey = i == 0 ? 1 : rk_unit_float(rk_case(i, 0, 0, 6));
        rk_vec3 colour = rk_vec(grey, grey, grey);
        check_bright(colour, grey, true, "only pixels below the threshold are dark");
        check_bright(colour, nextafterf(grey, 2), false, "it is below, by one step of a float");
    }
    check_bright(white, 0.5f, true, "a luminance of 1 is above");
    check_bright(rk_vec(0.49f, 0.49f, 0.49f), 0.5f, false, "a luminance of .49 is below");
    check_bright(rk_vec(0, 0.75f, 0), 0.5f, true, "green of .75 has a luminance of .536");
    check_bright(rk_vec(1, 0, 1), 0.5f, false, "magenta has a luminance of .285");
    check_bright(rk_vec(0, 0, 0), 0, true, "black is at a threshold of 0");
    check_bright(rk_vec(-1, -1, -1), 0.5f, false, "a luminance of -1 is below");
    check_bright(rk_vec(-1, 2, 0), 1, true, "its luminance is 1.218, though its red is below 0");
    check_bright(rk_vec(-1, -1, -1), -0.5f, false, "a luminance of -1 is below");
    check_bright(rk_vec(-1, -1, -1), -1, true, "a luminance of -1 is at a threshold of -1");
    check_bright(white, INFINITY, false, "nothing finite reaches it");
    check_bright(white, NAN, false, "no luminance is at or above NaN");
}

static void only_finite_pixels_are_bright(void **state)
{
    (void)state;
    const rk_vec3 odd[] = {
        {NAN, NAN, NAN},   {NAN, 1, 1},       {1, 1, NAN},       {INFINITY, 1, 1},
        {1, INFINITY, 1},  {0, 0, INFINITY},  {1, NAN, 1},       {INFINITY, -INFINITY, 0},
        {-INFINITY, 0, 0}, {0, -INFINITY, 0}, {0, 0, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    check_bright(rk_vec(1e30f, 1e30f, 1e30f), 0.5f, true, "it is very bright, but finite");
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        check_bright(odd[i], 0.5f, false, "it would make all pixels around it infinite, or NaN");
        check_bright(odd[i], -INFINITY, false, "infinite or NaN, it is dark for every threshold");
    }
}

static void sums_of_two_bright_pixels_are_finite(void **state)
{
    (void)state;
    const float most = RK_BLOOM_BRIGHTEST, beyond = nextafterf(most, INFINITY);
    for (int axis = 0; axis < 3; axis++)
        for (int sign = -1; sign <= 1; sign += 2) {
            float colour[3] = {1, 1, 1};
            colour[axis] = (float)sign * most;
            check_bright(rk_vec(colour[0], colour[1], colour[2]), -INFINITY, true,
                         "no colour is beyond RK_BLOOM_BRIGHTEST, 2^126");
            colour[axis] = (float)sign * beyond;
            check_bright(
                rk_vec(colour[0], colour[1], colour[2]), -INFINITY, false,
                "twice as much as a colour beyond RK_BLOOM_BRIGHTEST, 2^126, may be infinite");
        }
    for (int signs = 0; signs < 8; signs++)
        check_bright(
            rk_vec(signs & 1 ? -most : most, signs & 2 ? -most : most, signs & 4 ? -most : most),
            -INFINITY, true, "each colour for itself is not beyond RK_BLOOM_BRIGHTEST");
}

static void check_row_unchanged(const rk_vec3 *own, const rk_vec3 *row, size_t width)
{
    rk_check(
        memcmp(own, row, width * sizeof *row) == 0,
        "the row of %zu pixels was changed: it is constant, and the mask has memory of its own",
        width);
}

static void check_bright_span(const rk_vec3 *row, size_t width, size_t first, size_t end,
                              const char *hint)
{
    rk_vec3 *own = exact_copy(row, width * sizeof *row);
    rk_bloom_span bright = rk_bloom_bright_span(own, width, 1); /* the luminance of white */
    check_row_unchanged(own, row, width);
    if (first == end)
        rk_check(bright.first == bright.end, "%s: got [%zu, %zu), want an empty span", hint,
                 bright.first, bright.end);
    else
        rk_check(bright.first == first && bright.end == end, "%s: got [%zu, %zu), want [%zu, %zu)",
                 hint, bright.first, bright.end, first, end);
    free(own);
}

static void the_bright_span_is_from_the_first_to_the_last_bright_pixel(void **state)
{
    (void)state;
    rk_vec3 row[9] = {{0, 0, 0}};
    check_bright_span(row, 9, 0, 0, "a dark row of nine");
    row[3] = white;
    check_bright_span(row, 9, 3, 4, "pixel 3 of nine is bright");
    row[6] = white;
    check_bright_span(row, 9, 3, 7, "pixels 3 and 6 of nine are bright");
    row[1] = row[7] = rk_vec(INFINITY, 1, 1);
    check_bright_span(row, 9, 3, 7,
                      "pixels 3 and 6 are bright, 1 and 7 infinite, which is not bright");
    row[0] = row[8] = white;
    check_bright_span(row, 9, 0, 9, "both ends of a row of nine are bright");
    check_bright_span(row + 8, 1, 0, 1, "a row of one bright pixel");
    check_bright_span(row, 0, 0, 0, "a row of no pixels");
    for (size_t first = 0; first < 9; first++)
        for (size_t last = first; last < 9; last++) {
            memset(row, 0, sizeof row);
            row[first] = row[last] = white;
            char name[64];
            snprintf(name, sizeof name, "pixels %zu and %zu of nine are bright", first, last);
            check_bright_span(row, 9, first, last + 1, name);
        }
}

/* A row of black pixels in pages of its own, not one of which has been read or written. */
enum { row_pages = 256 }; /* more than 65536 pixels */

static rk_vec3 *untouched_row(size_t *width)
{
    size_t size = row_pages * (size_t)sysconf(_SC_PAGESIZE);
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    rk_check(memory != MAP_FAILED, "no memory for %zu bytes", size);
#ifdef MADV_NOHUGEPAGE
    madvise(memory, size, MADV_NOHUGEPAGE);
#endif
    *width = size / sizeof(rk_vec3);
    return memory;
}

/* The number of pages that have been read or written, from `first` to before `end`. */
static int touched_pages(rk_vec3 *row, int first, int end)
{
    unsigned char resident[row_pages];
    int count = 0;
    rk_check(mincore(row, row_pages * (size_t)sysconf(_SC_PAGESIZE), (void *)resident) == 0,
             "mincore cannot tell which pages were read");
    for (int i = first; i < end; i++)
        count += resident[i] & 1;
    return count;
}

static void the_search_reads_no_pixel_between_the_ends(void **state)
{
    (void)state;
    size_t width;
    rk_vec3 *row = untouched_row(&width);
    row[0] = row[width - 1] = white;
    rk_bloom_span bright = rk_bloom_bright_span(row, width, 1);
    int touched = touched_pages(row, 1, row_pages - 1);
    munmap(row, row_pages * (size_t)sysconf(_SC_PAGESIZE));
    rk_check(bright.first == 0 && bright.end == width,
             "both ends of a row of %zu are bright: got [%zu, %zu), want [0, %zu)", width,
             bright.first, bright.end, width);
    rk_check(
        touched == 0,
        "the first and the last pixel of %zu are bright, and the search read %d of the %d pages "
        "of memory between them, want 0: search from both ends",
        width, touched, row_pages - 2);
}

/* --- The mask --------------------------------------------------------------------------------- */

/* Calls the unit with a row in memory of its own; `masked` is fenced. */
static void mask_of(const rk_bloom_filter *filter, const rk_vec3 *row, size_t width,
                    float threshold, rk_bloom_span bright, size_t from, size_t count, float *masked)
{
    size_t total = count + 2 * filter->reach;
    rk_vec3 *own = exact_copy(row, width * sizeof *row);
    rk_bloom_bright_pass(filter, own, width, threshold, bright, from, count, (rk_vec3 *)masked);
    check_row_unchanged(own, row, width);
    free(own);
    check_fences(masked, 3 * total, "the mask, three floats per pixel");
}

/* The formula, for colours that are not finite or not near the threshold. */
static rk_vec3 plain_mask(rk_vec3 colour, double threshold)
{
    double luminance =
        0.2126 * (double)colour.x + 0.7152 * (double)colour.y + 0.0722 * (double)colour.z;
    bool is_bright = luminance >= threshold && isfinite(luminance);
    return is_bright ? colour : rk_vec(0, 0, 0);
}

/* A dark row, whose empty bright span may lie anywhere. */
static void check_dark_mask(size_t at)
{
    enum { width = 50 };
    const rk_bloom_filter alone = filter_of((const float[]){1}, 0, RK_BLOOM_ZERO);
    float room[3 * width + 2 * fence], *masked = fenced(room, 3 * width);
    rk_vec3 row[width] = {{0, 0, 0}};
    mask_of(&alone, row, width, 0.5f, (rk_bloom_span){at, at}, 0, width, masked);
    for (size_t i = 0; i < 3 * width; i++)
        rk_check(masked[i] == 0,
                 "a black row, bright span [%zu, %zu): pixel %zu, colour %zu: got %g, want 0", at,
                 at, i / 3, i % 3, (double)masked[i]);
}

static void check_constant_rows(void)
{
    enum { width = 8 };
    const float weights[] = {0.5f, 0.25f};
    rk_vec3 colours[width], masked[width + 2];
    for (uint32_t x = 0; x < width; x++)
        colours[x] = random_colour(x);
    const rk_vec3 *row = rk_read_only(colours, sizeof colours, "row");
    const rk_bloom_filter own =
        filter_of(rk_read_only(weights, sizeof weights, "weights"), 1, RK_BLOOM_CLAMP);
    const rk_bloom_filter *filter = rk_read_only(&own, sizeof own, "filter");
    rk_bloom_span bright = rk_bloom_bright_span(row, width, 0.4f);
    rk_bloom_bright_pass(filter, row, width, 0.4f, bright, 0, width, masked);
    rk_bloom_weight_inside(filter, 0, width);
    rk_read_only_free();
}

static void the_mask_keeps_bright_pixels_and_nothing_else(void **state)
{
    (void)state;
    check_constant_rows();
    enum { width = 50 };
    const rk_bloom_filter alone = filter_of((const float[]){1}, 0, RK_BLOOM_ZERO);
    float room[3 * width + 2 * fence], *masked = fenced(room, 3 * width);
    rk_vec3 row[width];
    for (uint32_t x = 0; x < width; x++)
        row[x] = random_colour(x);
    row[20] = rk_vec(INFINITY, 1, 1);
    row[30] = rk_vec(1, NAN, 1);
    row[40] = rk_vec(-2, 3, -1); /* bright, though two of its colours are below 0 */
    row[45] = rk_vec(0x1p100f, 0x1p120f, 1);
    /* By the formula, so that this claim does not depend on rk_bloom_bright_span. */
    rk_bloom_span bright = {0, width};
    while (plain_mask(row[bright.first], 0.5).y == 0)
        bright.first++;
    while (plain_mask(row[bright.end - 1], 0.5).y == 0)
        bright.end--;
    mask_of(&alone, row, width, 0.5f, bright, 0, width, masked);
    for (uint32_t x = 0; x < width; x++) {
        rk_vec3 want = plain_mask(row[x], 0.5), got;
        memcpy(&got, masked + 3 * x, sizeof got);
        rk_check(got.x == want.x && got.y == want.y && got.z == want.z,
                 "pixel %u, (%g, %g, %g), threshold .5: got (%g, %g, %g), want (%g, %g, %g): %s", x,
                 (double)row[x].x, (double)row[x].y, (double)row[x].z, (double)got.x, (double)got.y,
                 (double)got.z, (double)want.x, (double)want.y, (double)want.z,
                 want.y > 0 ? "it is bright, and keeps its colour" : "it is not bright, and is 0");
    }
    check_dark_mask(0);
    check_dark_mask(50);
    mask_of(&alone, row, width, 0.5f, bright, width / 2, 0, fenced(room, 0)); /* no pixels */
}

static void the_mask_reads_no_pixel_outside_of_the_bright_span(void **state)
{
    (void)state;
    const rk_bloom_filter alone = filter_of((const float[]){1}, 0, RK_BLOOM_ZERO);
    size_t width, page = (size_t)sysconf(_SC_PAGESIZE);
    rk_vec3 *row = untouched_row(&width), *masked = malloc(width * sizeof *masked);
    rk_check(masked != NULL, "no memory for %zu pixels", width);
    /* Three pages of pixels, so that the pixels beside them are on other pages. */
    enum { first_page = row_pages / 2 / 3 * 3, end_page = first_page + 3 };
    const rk_bloom_span bright = {first_page * page / sizeof *row, end_page * page / sizeof *row};
    row[bright.first] = row[bright.end - 1] = white;
    rk_bloom_bright_pass(&alone, row, width, 1, bright, 0, width, masked);
    int before = touched_pages(row, 0, first_page);
    int after = touched_pages(row, end_page, row_pages);
    bool kept = masked[bright.first].x == 1 && masked[bright.end - 1].x == 1;
    munmap(row, row_pages * page);
    free(masked);
    rk_check(kept, "the pixels %zu and %zu of %zu are white, and not in the mask", bright.first,
             bright.end - 1, width);
    rk_check(before == 0 && after == 0,
             "only the pixels [%zu, %zu) of %zu are bright: read %d pages of memory before "
             "them and %d after them, want 0: pixels outside of the bright span are dark",
             bright.first, bright.end, width, before, after);
}

/* Ten greys, 1 to 10 or 10 to 1; from 7 on they are bright. */
static rk_vec3 grey_at(size_t x, bool rising)
{
    return rk_scale(white, rising ? (float)x + 1 : 10 - (float)x);
}

/* A part of the row of greys. */
static void check_mask(uint32_t reach, rk_bloom_border border, bool rising, size_t from,
                       size_t count)
{
    size_t total = count + 2 * reach;
    float *weights = exactly((reach + 1) * sizeof *weights);
    const rk_bloom_filter filter = filter_of(weights, reach, border);
    const rk_bloom_span bright = rising ? (rk_bloom_span){6, 10} : (rk_bloom_span){0, 4};
    float *room = exactly((3 * total + 2 * fence) * sizeof *room),
          *masked = fenced(room, 3 * total);
    rk_vec3 row[10];
    for (size_t x = 0; x < 10; x++)
        row[x] = grey_at(x, rising);
    mask_of(&filter, row, 10, 7, bright, from, count, masked);
    for (size_t i = 0; i < total; i++) {
        size_t away = from + i, x = away < reach ? 0 : away - reach < 10 ? away - reach : 9;
        bool beyond = x + reach != away, dark = beyond && border != RK_BLOOM_CLAMP;
        float grey = grey_at(x, rising).x, want = grey < 7 || dark ? 0 : grey;
        for (int axis = 0; axis < 3; axis++)
            rk_check(masked[3 * i + (size_t)axis] == want,
                     "border %s, greys %s, threshold 7, from %zu, %zu pixels, reach %u: entry %zu, "
                     "colour %d: got %g, want %g: it stands for %s pixel %zu, of grey %g",
                     border_names[border], rising ? "1 to 10" : "10 to 1", from, count, reach, i,
                     axis, (double)masked[3 * i + (size_t)axis], (double)want,
                     beyond ? "the outside beside" : "the row's", x, (double)grey);
    }
    free(room);
    free(weights);
}

/* All parts of the row for a short filter, a few for others. */
static void check_masks(rk_bloom_border border)
{
    const uint32_t reaches[] = {0, 1, 9, 10, 11, 300, RK_BLOOM_RADIUS_MAX};
    for (int rising = 1; rising >= 0; rising--) {
        for (size_t from = 0; from <= 10; from++)
            for (size_t count = 10 - from + 1; count-- > 0;)
                check_mask(4, border, rising, from, count);
        for (size_t i = 0; i < sizeof reaches / sizeof *reaches; i++) {
            check_mask(reaches[i], border, rising, 0, 10);
            check_mask(reaches[i], border, rising, 3, 4);
        }
    }
}

/* A row in which all pixels but one are as bright as can be; the unit is told that only those from
 * `first` to before `end` are. */
static void check_span_of_mask(rk_bloom_border border, size_t first, size_t end)
{
    enum { width = 6, reach = 2, total = width + 2 * reach };
    const float weights[] = {1, 0, 0};
    const rk_bloom_filter filter = filter_of(weights, reach, border);
    float room[3 * total + 2 * fence], *masked = fenced(room, 3 * total);
    rk_vec3 row[width];
    for (size_t x = 0; x < width; x++)
        row[x] = x == 2 ? rk_vec(1, NAN, 1) : grey_at(x, true);
    mask_of(&filter, row, width, 0.5f, (rk_bloom_span){first, end}, 0, width, masked);
    for (size_t i = 0; i < total; i++) {
        size_t x = i < reach ? 0 : i - reach < width ? i - reach : width - 1;
        bool is_bright = x >= first && x < end && x != 2;
        bool dark = !is_bright || (x + reach != i && border != RK_BLOOM_CLAMP);
        float want = dark ? 0 : row[x].x, got = masked[3 * i];
        rk_check(got == want,
                 "border %s, a row of six with the bright span [%zu, %zu): entry "
                 "%zu, of pixel %zu: got %g, want %g: pixels outside of the span are dark",
                 border_names[border], first, end, i, x, (double)got, (double)want);
    }
}

static void the_mask_is_zero_beyond_the_border(void **state)
{
    (void)state;
    const rk_bloom_border borders[] = {RK_BLOOM_ZERO, RK_BLOOM_RENORMALIZE};
    for (int i = 0; i < 2; i++) {
        check_masks(borders[i]);
        for (size_t first = 0; first <= 6; first++)
            for (size_t end = first; end <= 6; end++)
                check_span_of_mask(borders[i], first, end);
    }
}

static void clamping_repeats_the_borders_own_pixel(void **state)
{
    (void)state;
    check_masks(RK_BLOOM_CLAMP);
    for (size_t first = 0; first <= 6; first++)
        for (size_t end = first; end <= 6; end++)
            check_span_of_mask(RK_BLOOM_CLAMP, first, end);
    const float weights[5] = {1, 0, 0, 0, 0};
    const rk_bloom_filter filter = filter_of(weights, 4, RK_BLOOM_CLAMP);
    float room[3 * 9 + 2 * fence], *masked = fenced(room, 3 * 9);
    mask_of(&filter, &white, 1, 0.5f, (rk_bloom_span){0, 1}, 0, 1, masked);
    for (size_t i = 0; i < 3 * 9; i++)
        rk_check(masked[i] == 1,
                 "a row of one white pixel, reach 4: entry %zu, colour %zu: got %g, want 1: all "
                 "entries repeat that pixel",
                 i / 3, i % 3, (double)masked[i]);
}

/* --- Weights ---------------------------------------------------------------------------------- */

static const char *mistake_of_weights(const float *got, const float *want, uint32_t radius)
{
    bool is_reversed = true, is_large = true, is_small = true;
    for (uint32_t k = 0; k <= radius; k++) {
        is_reversed &= got[k] == want[radius - k];
        is_large &= got[k] == ldexpf(want[k], (int)radius);
        is_small &= got[k] == ldexpf(want[k], -(int)radius);
    }
    if (is_large)
        return RK_EXAMPLE_IF "the row is divided by 2^r, not by its sum 4^r";
    if (is_reversed)
        return RK_EXAMPLE_IF "the weights are in the opposite order: weight 0 is the "
                             "middle's";
    return is_small ? RK_EXAMPLE_IF "the row is divided by 8^r, not by its sum 4^r" : "";
}

static void small_filters_are_rows_of_pascals_triangle(void **state)
{
    (void)state;
    const float want[4][4] = {{1},
                              {2 / 4.0f, 1 / 4.0f},
                              {6 / 16.0f, 4 / 16.0f, 1 / 16.0f},
                              {20 / 64.0f, 15 / 64.0f, 6 / 64.0f, 1 / 64.0f}};
    for (uint32_t i = 0; i < 2 * 4; i++) { /* each radius twice in a row, in other memory */
        uint32_t radius = i / 2;
        float rooms[2][4 + 2 * fence], *weights = fenced(rooms[i % 2], radius + 1);
        rk_bloom_weights(radius, weights);
        for (uint32_t k = 0; k <= radius; k++)
            rk_check(weights[k] == want[radius][k],
                     "radius %u, weight %u: got %.9g, want %.9g: row %u of the triangle over its "
                     "sum, from the middle on%s",
                     radius, k, (double)weights[k], (double)want[radius][k], 2 * radius,
                     mistake_of_weights(weights, want[radius], radius));
        check_fences(weights, radius + 1, "the weights");
    }
}

/* An integer of any size up to C(2 r, r), for the largest radius. */
typedef struct big {
    uint32_t words[2 * RK_BLOOM_RADIUS_MAX / 32 + 1]; /* of 32 bits, the lowest first */
    int count;                                        /* of words; the highest is not 0 */
} big;

static void multiply(big *b, uint32_t factor)
{
    uint64_t carry = 0;
    for (int i = 0; i < b->count; i++) {
        carry += (uint64_t)b->words[i] * factor;
        b->words[i] = (uint32_t)carry;
        carry >>= 32;
    }
    if (carry)
        b->words[b->count++] = (uint32_t)carry;
}

/* Without a remainder. */
static void divide(big *b, uint32_t divisor)
{
    uint64_t rest = 0;
    for (int i = b->count; i-- > 0;) {
        rest = rest << 32 | b->words[i];
        b->words[i] = (uint32_t)(rest / divisor);
        rest %= divisor;
    }
    rk_check(rest == 0, "a binomial is not an integer: this test is wrong");
    if (b->words[b->count - 1] == 0)
        b->count--;
}

static int bit_of(const big *b, int i)
{
    return i < 0 ? 0 : (int)(b->words[i / 32] >> (i % 32) & 1);
}

/* The float nearest to b / 4^radius, ties to the even one. */
static float nearest_float(const big *b, int radius)
{
    int top = 32 * b->count - 1;
    while (!bit_of(b, top))
        top--;
    /* The unit in the last place is 2^exponent, or 2^lowest bits of b. */
    int exponent = top - 2 * radius - 23 > -149 ? top - 2 * radius - 23 : -149;
    int lowest = exponent + 2 * radius;
    uint32_t digits = 0;
    for (int i = top; i >= lowest; i--)
        digits = 2 * digits + (uint32_t)bit_of(b, i);
    bool more_than_half = false;
    for (int i = lowest - 2; i >= 0 && !more_than_half; i--)
        more_than_half = bit_of(b, i);
    if (lowest - 1 <= top && bit_of(b, lowest - 1) && (more_than_half || digits % 2))
        digits++;
    return ldexpf((float)digits, exponent);
}

static void weights_are_pascals_rows_to_the_last_bit(void **state)
{
    (void)state;
    const uint32_t large[] = {100, 250, 513, 538, 1000, 1354, 2000, RK_BLOOM_RADIUS_MAX};
    float *room = exactly((RK_BLOOM_RADIUS_MAX + 1 + 2 * fence) * sizeof *room);
    for (uint32_t i = 0; i < 61 + sizeof large / sizeof *large; i++) {
        uint32_t radius = i < 61 ? i : large[i - 61];
        float *weights = fenced(room, radius + 1);
        rk_bloom_weights(radius, weights);
        check_fences(weights, radius + 1, "the weights");
        big binomial = {{1}, 1}; /* C(2 r, k), from its left neighbour */
        for (uint32_t k = 0; k <= radius; k++) {
            float want = nearest_float(&binomial, (int)radius), got = weights[radius - k];
            rk_check(got == want, "radius %u, weight %u: got %a, want C(%u, %u) / 4^%u = %a%s",
                     radius, radius - k, (double)got, 2 * radius, k, radius, (double)want,
                     got == 0 && radius > 537 ? ": 4^-538 is too small for a double" : "");
            multiply(&binomial, 2 * radius - k);
            divide(&binomial, k + 1);
        }
    }
    free(room);
}

static void the_weights_of_any_radius_sum_to_one(void **state)
{
    (void)state;
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    const uint32_t radii[] = {0, 1, 2, 15, 60, 100, 500, 513, 537, 538, 1000, RK_BLOOM_RADIUS_MAX};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++) {
        rk_bloom_weights(radii[i], weights);
        double sum = (double)weights[0];
        for (uint32_t k = 1; k <= radii[i]; k++)
            sum += 2 * (double)weights[k];
        /* Each is rounded by at most 2^-24 of itself; weights too small for a float don't matter.
         */
        const double tolerance = 0x1p-24 + 1e-30;
        rk_check(fabs(sum - 1) <= tolerance,
                 "radius %u: the weights of both sides sum to %.12g, want 1 within %.3g", radii[i],
                 sum, tolerance);
    }
}

static void the_variance_is_half_the_radius(void **state)
{
    (void)state;
    const uint32_t radii[] = {1, 15, 100, 1000};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++) {
        float weights[1001];
        rk_bloom_weights(radii[i], weights);
        double sum = 0;
        for (uint32_t k = 1; k <= radii[i]; k++)
            sum += 2 * (double)weights[k] * k * k;
        double want = 0.5 * radii[i], tolerance = 0x1p-23 * radii[i];
        rk_check(fabs(sum - want) <= tolerance,
                 "radius %u, the sum of w_k k^2: got %.9g, want %.9g within %.3g: the variance of "
                 "%u coins, 1/4 each",
                 radii[i], sum, want, tolerance, 2 * radii[i]);
    }
}

/* --- The weights that matter ------------------------------------------------------------------ */

static double left_out(const float *weights, uint32_t reach, uint32_t radius)
{
    double sum = 0;
    for (uint32_t k = radius; k > reach; k--)
        sum += 2 * (double)weights[k];
    return sum;
}

static void check_reach(const float *weights, uint32_t radius, uint32_t want, const char *hint)
{
    const size_t size = (radius + 1) * sizeof *weights;
    float *own = exact_copy(weights, size);
    uint32_t reach = rk_bloom_reach(radius, own);
    free(own);
    rk_bloom_reach(radius, rk_read_only(weights, size, "weights"));
    rk_read_only_free();
    uint32_t one_sided = radius;
    while (one_sided > 0 && left_out(weights, one_sided - 1, radius) / 2 <= 0x1p-25)
        one_sided--;
    rk_check(reach == want, "radius %u, weights of no binomial: got a reach of %u, want %u: %s%s",
             radius, reach, want, hint,
             reach == one_sided && reach != want ? RK_EXAMPLE_IF
                 "the weights left out are summed of one side only"
                                                 : "");
}

static void the_reach_is_the_shortest_within_half_an_ulp(void **state)
{
    (void)state;
    check_reach((const float[]){1, 0x1p-27f, 0x1p-27f}, 2, 0, "four times 2^-27 are 2^-25");
    check_reach((const float[]){1, 0x1.000002p-27f, 0x1p-27f}, 2, 1,
                "four times 2^-27 and a little more than 2^-25, which a float's sum would lose");
    check_reach((const float[]){1, 0, 0, 0}, 3, 0, "weights of 0 can all be left out");
    check_reach((const float[]){1, 0, 0, 0x1p-20f}, 3, 3, "the last weight is too large");
    check_reach((const float[]){1, 0, 0x1p-20f, 0}, 3, 2, "only the last weight is 0");
    check_reach((const float[]){0x1p-30f, 0x1p-30f, 0x1p-30f}, 2, 0,
                "four times 2^-30 are less than 2^-25, however small the others are");
    check_reach((const float[]){0x1p-30f}, 0, 0, "the middle is always within reach");
    static float all[RK_BLOOM_RADIUS_MAX + 1];
    for (uint32_t radius = 0; radius <= RK_BLOOM_RADIUS_MAX;
         radius += radius < 64 ? 1 : radius / 8) {
        rk_bloom_weights(radius, all);
        float *weights = exact_copy(all, (radius + 1) * sizeof *all);
        uint32_t reach = rk_bloom_reach(radius, weights), want = radius;
        free(weights);
        while (want > 0 && left_out(all, want - 1, radius) <= 0x1p-25)
            want--;
        rk_check(reach >= want,
                 "radius %u: got a reach of %u, want %u: the weights beyond, of both sides, sum to "
                 "%.3g, more than 2^-25 = 2.98e-08",
                 radius, reach, want, left_out(all, reach, radius));
        rk_check(reach == want,
                 "radius %u: got a reach of %u, want %u: the weights beyond that, of both sides, "
                 "sum to %.3g, no more than 2^-25 = 2.98e-08",
                 radius, reach, want, left_out(all, want, radius));
    }
}

/* --- Sums of lines ---------------------------------------------------------------------------- */

/* `weights` belong to no real filter: they are between 1 and 2, so that each of them matters. Each
 * line has memory of exactly its size; a missing line is NULL. */
typedef struct line_sum {
    uint32_t reach, taps; /* taps: lines that are not NULL */
    size_t count;
    float *weights, **lines;
} line_sum;

static line_sum make_lines(uint32_t reach, uint32_t present, size_t count)
{
    line_sum s = {reach, 0, count, exactly((reach + 1) * sizeof *s.weights),
                  exactly((2 * reach + 1) * sizeof *s.lines)};
    for (uint32_t k = 0; k <= reach; k++)
        s.weights[k] = 1 + rk_unit_float(rk_case(k, reach, present, 3));
    for (uint32_t k = 0; k <= 2 * reach; k++) {
        bool there = present >> k % 32 & 1;
        s.lines[k] = there ? exactly(count * sizeof *s.lines[k]) : NULL;
        s.taps += there;
        for (uint32_t i = 0; there && i < count; i++)
            s.lines[k][i] = 2 * rk_unit_float(rk_case(k, reach ^ present, i, 4)) - 1;
    }
    return s;
}

static void free_lines(line_sum *s)
{
    for (uint32_t k = 0; k <= 2 * s->reach; k++)
        free(s->lines[k]);
    free(s->lines);
    free(s->weights);
}

static double plain_sum(const line_sum *s, size_t i)
{
    double sum = 0;
    for (uint32_t k = 0; k <= 2 * s->reach; k++) {
        uint32_t away = k < s->reach ? s->reach - k : k - s->reach;
        sum += s->lines[k] ? (double)s->weights[away] * (double)s->lines[k][i] : 0;
    }
    return sum;
}

/* Lines, some of them missing, against the sum in double. Returns the number of allocations. */
static size_t check_sum_of(uint32_t reach, uint32_t present, size_t count, const char *hint)
{
    line_sum s = make_lines(reach, present, count);
    const rk_bloom_filter filter = filter_of(s.weights, reach, RK_BLOOM_ZERO);
    float *fenced_sum = exactly((count + 2 * fence) * sizeof *fenced_sum);
    float *sum = fenced(fenced_sum, count);
    double *wanted = exactly(count * sizeof *wanted);
    for (size_t i = 0; i < count; i++)
        wanted[i] = plain_sum(&s, i);
    size_t before = rk_allocations;
    uint32_t taps = rk_bloom_blur_lines(&filter, (const float *const *)s.lines, s.count, sum);
    size_t allocated = rk_allocations - before;
    /* Each term, of 2 at most, is rounded three times, and the sum once per term. */
    double tolerance = (2 * reach + 4) * 0x1p-24 * 2 * (2 * reach + 1);
    for (size_t i = 0; i < s.count; i++) {
        double want = wanted[i], got = (double)sum[i];
        rk_check(fabs(got - want) <= tolerance,
                 "%s, reach %u, float %zu of %zu: got %.9g, want %.9g within %.3g: %s%s", hint,
                 reach, i, s.count, got, want, tolerance,
                 isnan(got) ? "the memory for the sum holds NaN at first"
                            : "entry reach + k of the lines has the weight |k|",
                 rk_mistake_in(got, want, tolerance,
                               RK_MISTAKES({2 * want, "the line is added twice"})));
        rk_check(plain_sum(&s, i) == want,
                 "%s, reach %u: a line or a weight was changed, and they are constant", hint,
                 reach);
    }
    free(wanted);
    check_fences(sum, s.count, "the sum");
    rk_check(taps == s.taps, "%s, reach %u: returned %u, want %u: the lines that are not NULL",
             hint, reach, taps, s.taps);
    free_lines(&s);
    free(fenced_sum);
    return allocated;
}

static size_t check_sum(uint32_t reach, uint32_t present, const char *hint)
{
    return check_sum_of(reach, present, RK_BLOOM_BLOCK * (1 + (reach + 2) % 3), hint);
}

static void a_single_line_is_weighted_by_its_distance(void **state)
{
    (void)state;
    for (uint32_t k = 0; k <= 8; k++) {
        char hint[64];
        snprintf(hint, sizeof hint, "of the lines 0 to 8 only %u is not NULL", k);
        check_sum(4, 1u << k, hint);
    }
    check_sum(0, 1, "a filter that reaches only the pixel itself");
    float line[RK_BLOOM_BLOCK] = {0x1p20f}, sum[RK_BLOOM_BLOCK];
    const rk_bloom_filter tiny = filter_of((const float[]){0x1p-100f}, 0, RK_BLOOM_ZERO);
    rk_bloom_blur_lines(&tiny, (const float *const[]){line}, RK_BLOOM_BLOCK, sum);
    rk_check(sum[0] == 0x1p-80f,
             "a line of 2^20, weight 2^-100: got %g, want 2^-80 = %g: no weight is too small",
             (double)sum[0], 0x1p-80);
    /* Nor is one that is no normal float, beside the middle. */
    const rk_bloom_filter faint = filter_of((const float[]){0, 0x1p-130f}, 1, RK_BLOOM_ZERO);
    float bright[RK_BLOOM_BLOCK] = {0x1p120f};
    for (int side = 0; side <= 2; side += 2) {
        const float *lines[3] = {NULL, NULL, NULL};
        lines[side] = bright;
        rk_bloom_blur_lines(&faint, lines, RK_BLOOM_BLOCK, sum);
        rk_check(sum[0] == 0x1p-10f,
                 "a line of 2^120, weight 2^-130: got %g, want 2^-10 = %g: no weight is too small",
                 (double)sum[0], 0x1p-10);
    }
}

static void check_constant_lines(void)
{
    const float weights[] = {0.5f, 0.25f}, zeros[RK_BLOOM_BLOCK] = {0};
    float sum[RK_BLOOM_BLOCK];
    const rk_bloom_filter own =
        filter_of(rk_read_only(weights, sizeof weights, "weights"), 1, RK_BLOOM_ZERO);
    const float *line = rk_read_only(zeros, sizeof zeros, "line"),
                *own_lines[] = {line, NULL, line};
    const float *const *lines = rk_read_only(own_lines, sizeof own_lines, "list of lines");
    rk_bloom_blur_lines(rk_read_only(&own, sizeof own, "filter"), lines, RK_BLOOM_BLOCK, sum);
    rk_read_only_free();
}

static void all_lines_are_summed(void **state)
{
    (void)state;
    check_constant_lines();
    for (uint32_t reach = 0; reach <= 15; reach++)
        check_sum(reach, UINT32_MAX, "no line is NULL");
    check_sum(RK_BLOOM_RADIUS_MAX, UINT32_MAX, "the longest filter, no line is NULL");
    check_sum_of(2, UINT32_MAX, 0, "lines of no floats");
    check_sum_of(1, UINT32_MAX, 1366 * RK_BLOOM_BLOCK, "lines of more than 65536 floats");
}

/* Weights of 0, and equal ones, times lines as bright as may be: a sum of four is infinite. */
static void check_box_filter(void)
{
    enum { reach = 4 };
    float weights[reach + 1] = {0.2f, 0.2f, 0.2f}, line[RK_BLOOM_BLOCK], sum[RK_BLOOM_BLOCK];
    const float *lines[2 * reach + 1];
    for (size_t i = 0; i < RK_BLOOM_BLOCK; i++)
        line[i] = RK_BLOOM_BRIGHTEST;
    for (size_t k = 0; k <= 2 * reach; k++)
        lines[k] = line;
    const rk_bloom_filter filter = filter_of(weights, reach, RK_BLOOM_ZERO);
    uint32_t taps = rk_bloom_blur_lines(&filter, lines, RK_BLOOM_BLOCK, sum);
    rk_check(
        taps == 2 * reach + 1,
        "four of nine lines have the weight 0: returned %u, want 9: the lines that are not NULL",
        taps);
    rk_check_near(
        sum[0] / RK_BLOOM_BRIGHTEST, 1, 16 * 0x1p-24,
        "five lines of 2^126, each of weight 1/5, over 2^126: two may be added before their "
        "weight, and no more");
}

static void lines_that_are_null_are_zeros(void **state)
{
    (void)state;
    check_box_filter();
    for (uint32_t i = 0; i < 200; i++) {
        char hint[64];
        uint32_t present = rk_case(i, 0, 0, 4);
        snprintf(hint, sizeof hint, "line k is NULL unless bit k of 0x%x is set", present);
        check_sum(i % 16, present, hint);
    }
    check_sum(7, 0, "all lines are NULL");
    check_sum(RK_BLOOM_RADIUS_MAX, 4,
              "of each 32 lines of the longest filter all but one are NULL");
    for (uint32_t reach = 0; reach <= 2; reach++)
        for (uint32_t present = 0; present < 1u << (2 * reach + 1); present++) {
            char hint[64];
            snprintf(hint, sizeof hint, "line k is NULL unless bit k of 0x%x is set", present);
            check_sum(reach, present, hint);
        }
}

/* Seconds of processor time for a sum of lines, all of them the same; the fastest of five. */
static double seconds_of_sum(const rk_bloom_filter *filter, const float *const *lines, size_t count,
                             float *sum)
{
    double fastest = INFINITY;
    for (int i = 0; i < 5; i++) {
        double start = rk_clock_thread();
        rk_bloom_blur_lines(filter, lines, count, sum);
        fastest = fmin(fastest, rk_clock_thread() - start);
    }
    return fastest;
}

static void lines_that_are_null_cost_nothing(void **state)
{
    (void)state;
    enum { reach = RK_BLOOM_RADIUS_MAX, count = 64 * RK_BLOOM_BLOCK };
    static float weights[reach + 1], line[count], sum[count];
    static const float *lines[2 * reach + 1];
    for (size_t k = 0; k <= reach; k++)
        weights[k] = 1;
    const rk_bloom_filter filter = filter_of(weights, reach, RK_BLOOM_ZERO);
    for (size_t k = 0; k <= 2 * reach; k++)
        lines[k] = line;
    double all = seconds_of_sum(&filter, lines, count, sum);
    memset(lines, 0, sizeof lines);
    line[0] = 1;
    /* The first one alone, then the one in the middle. */
    for (size_t at = 0; at <= reach; at += reach) {
        lines[0] = NULL, lines[at] = line;
        double one = seconds_of_sum(&filter, lines, count, sum);
        rk_check(sum[0] == 1, "the only line that is not NULL is 1: got %g", (double)sum[0]);
        /* About a thousandth: looking at the pointers is left. */
        rk_check(one <= all / 20,
                 "line %zu alone of %d is not NULL: the sum took %.3g ms, and %.3g ms with all "
                 "lines; want a twentieth of that at most: look for the lines that are not NULL "
                 "once, not again for each number",
                 at, 2 * reach + 1, 1000 * one, 1000 * all);
    }
}

static void blurring_allocates_no_memory(void **state)
{
    (void)state;
    size_t allocated = check_sum(15, UINT32_MAX, "no line is NULL");
    rk_check(!rk_allocations_are_counted || allocated == 0,
             "reach 15: a sum of lines allocated memory %zu times, want 0: it is called in the "
             "innermost loop",
             allocated);
}

/* Small multiples of 1/32, so that sums and products are exact. */
static void the_blurred_mask_is_added_times_the_gain(void **state)
{
    (void)state;
    float dark[20] = {0}, faint[20];
    for (int k = 0; k < 20; k++)
        faint[k] = 0x1p-60f;
    rk_bloom_composite(dark, rk_read_only(faint, sizeof faint, "blurred mask"), 20, 0.5f);
    rk_read_only_free();
    for (int k = 0; k < 20; k++)
        rk_check(dark[k] == 0x1p-61f, "black plus 1/2 times 2^-60, float %d: got %g, want 2^-61", k,
                 (double)dark[k]);
    const float gains[] = {0.125f, 0.5f, 0.875f, 1, 2.5f, 16, 0};
    /* Up to 100 floats, and then one line of more than 65536. */
    for (size_t i = 0; i <= 101; i++) {
        size_t count = i <= 100 ? i : 65537;
        float *fenced_pixels = exactly((count + 2 * fence) * sizeof *fenced_pixels);
        float *pixels = fenced(fenced_pixels, count), gain = gains[i % 7];
        float *blurred = exactly(count * sizeof *blurred);
        for (size_t k = 0; k < count; k++) {
            pixels[k] = (float)k - 20;
            blurred[k] = (float)(count - k) / 4 - 5;
        }
        rk_bloom_composite(pixels, blurred, count, gain);
        for (size_t k = 0; k < count; k++) {
            float before = (float)k - 20, mask = (float)(count - k) / 4 - 5;
            rk_check(pixels[k] == before + gain * mask,
                     "float %zu of %zu: got %g, want %g: %g plus the gain %g times the mask %g", k,
                     count, (double)pixels[k], (double)(before + gain * mask), (double)before,
                     (double)gain, (double)mask);
            rk_check(blurred[k] == mask,
                     "float %zu of %zu of the blurred mask, which is constant, was changed", k,
                     count);
        }
        check_fences(pixels, count, "the pixels");
        free(blurred);
        free(fenced_pixels);
    }
}

/* --- Whole pictures --------------------------------------------------------------------------- */

enum { width = 37, height = 29, room = 144 }; /* 3 * 37 floats, in whole blocks */

typedef struct picture {
    rk_vec3 pixels[height][width];
} picture;

/* The plainest use of the unit: every row, then every column, with all their taps. */
static void bloom(picture *p, const rk_bloom_filter *filter, float threshold, float intensity)
{
    static float across[height][room], masked[3 * (48 + 2 * 64)];
    const float *lines[129];
    int reach = (int)filter->reach;
    for (int y = 0; y < height; y++) {
        rk_bloom_span bright = rk_bloom_bright_span(p->pixels[y], width, threshold);
        memset(masked, 0, sizeof masked);
        rk_bloom_bright_pass(filter, p->pixels[y], width, threshold, bright, 0, width,
                             (rk_vec3 *)masked);
        for (int k = 0; k <= 2 * reach; k++)
            lines[k] = masked + 3 * k;
        rk_bloom_blur_lines(filter, lines, room, across[y]);
    }
    for (int y = 0; y < height; y++) {
        float sum[room];
        for (int k = 0; k <= 2 * reach; k++) {
            int row = y + k - reach, inside = row < 0 ? 0 : row < height ? row : height - 1;
            bool there = row == inside || filter->border == RK_BLOOM_CLAMP;
            lines[k] = there ? across[inside] : NULL;
        }
        rk_bloom_blur_lines(filter, lines, room, sum);
        for (int x = 0; x < width; x++) {
            float weight_inside = filter->border != RK_BLOOM_RENORMALIZE
                                      ? 1
                                      : rk_bloom_weight_inside(filter, (size_t)x, width) *
                                            rk_bloom_weight_inside(filter, (size_t)y, height);
            rk_bloom_composite(&p->pixels[y][x].x, sum + 3 * x, 3, intensity / weight_inside);
        }
    }
}

static void bloom_of_radius(picture *p, uint32_t radius, rk_bloom_border border, float threshold,
                            float intensity)
{
    float weights[65];
    rk_bloom_weights(radius, weights);
    const rk_bloom_filter filter = filter_of(weights, radius, border);
    bloom(p, &filter, threshold, intensity);
}

/* C(2r, r + k) / 4^r by halves of neighbours' sums, each exact to a rounding. */
static void weights_in_double(int radius, double *weights)
{
    double row[130] = {1};
    for (int n = 1; n <= 2 * radius; n++)
        for (int k = n; k >= 0; k--)
            row[k] = (row[k] + (k ? row[k - 1] : 0)) / 2;
    for (int k = 0; k <= radius; k++)
        weights[k] = row[radius + k];
}

static double full_filter(const picture *p, int x, int y, int axis, int radius,
                          rk_bloom_border border, double threshold)
{
    double weights[65], sum = 0, weight_inside = 0;
    weights_in_double(radius, weights);
    for (int dy = -radius; dy <= radius; dy++)
        for (int dx = -radius; dx <= radius; dx++) {
            int i = x + dx, j = y + dy;
            int ci = i < 0 ? 0 : i < width ? i : width - 1;
            int cj = j < 0 ? 0 : j < height ? j : height - 1;
            double weight = weights[abs(dx)] * weights[abs(dy)];
            if ((ci != i || cj != j) && border != RK_BLOOM_CLAMP)
                continue;
            rk_vec3 c = p->pixels[cj][ci];
            double luminance = 0.2126 * (double)c.x + 0.7152 * (double)c.y + 0.0722 * (double)c.z;
            weight_inside += weight;
            sum += luminance >= threshold ? weight * (double)rk_axis(c, axis) : 0;
        }
    return border == RK_BLOOM_RENORMALIZE ? sum / weight_inside : sum;
}

/* Pixels of at most 1: each of up to 2 x 65 sums and products per pass is rounded by 2^-24 of a
 * result of at most 1, and weights are off by another 2^-24. */
static double pass_tolerance(uint32_t radius)
{
    return 2 * (2 * radius + 4) * 0x1p-24;
}

static picture random_picture(uint32_t seed)
{
    picture p;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            p.pixels[y][x] = random_colour(rk_case(x, y, seed, 5));
    return p;
}

static void rows_then_columns_are_the_full_filter(void **state)
{
    (void)state;
    const uint32_t radii[] = {0, 1, 4, 15, 40};
    for (uint32_t i = 0; i < 5; i++)
        for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
            picture before = random_picture(i), after = before;
            bloom_of_radius(&after, radii[i], (rk_bloom_border)border, 0.5f, 0.8f);
            for (int y = 0; y < height; y += 4)
                for (int x = 0; x < width; x += 4)
                    for (int axis = 0; axis < 3; axis++) {
                        double want = (double)rk_axis(before.pixels[y][x], axis) +
                                      0.8 * full_filter(&before, x, y, axis, (int)radii[i],
                                                        (rk_bloom_border)border, 0.5);
                        double got = (double)rk_axis(after.pixels[y][x], axis);
                        rk_check(fabs(got - want) <= 4 * pass_tolerance(radii[i]),
                                 "radius %u, border %s, pixel (%d, %d), colour %d: got %.9g, want "
                                 "%.9g within %.3g: the sum over (2 r + 1)^2 pixels",
                                 radii[i], border_names[border], x, y, axis, got, want,
                                 4 * pass_tolerance(radii[i]));
                    }
        }
}

static void a_point_of_light_becomes_the_filter(void **state)
{
    (void)state;
    picture p = {{{{0, 0, 0}}}};
    p.pixels[14][18] = rk_vec(1, 2, 4);
    bloom_of_radius(&p, 8, RK_BLOOM_ZERO, 0.5f, 1);
    p.pixels[14][18] = rk_sub(p.pixels[14][18], rk_vec(1, 2, 4));
    double weights[9];
    weights_in_double(8, weights);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int dx = abs(x - 18), dy = abs(y - 14);
            double want = dx > 8 || dy > 8 ? 0 : weights[dx] * weights[dy];
            for (int axis = 0; axis < 3; axis++) {
                double light = 1 << axis, got = (double)rk_axis(p.pixels[y][x], axis);
                rk_check(fabs(got - light * want) <= light * pass_tolerance(8),
                         "a point of light at (18, 14), radius 8: pixel (%d, %d), colour %d: got "
                         "%.9g, want %.9g within %.3g: %g times the weights %d and %d away",
                         x, y, axis, got, light * want, light * pass_tolerance(8), light, dx, dy);
            }
        }
}

static void a_pixel_as_bright_as_floats_go_spoils_no_other(void **state)
{
    (void)state;
    const float brightest[] = {RK_BLOOM_BRIGHTEST, 2e38f, 3.4e38f};
    for (int i = 0; i < 3; i++)
        for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
            picture p = random_picture(9);
            for (int k = 0; k < 4; k++) /* in the middle, beside it, in a corner, at the right */
                p.pixels[k < 2 ? 14 : 0][k == 0   ? 18
                                         : k == 1 ? 19
                                         : k == 2 ? 0
                                                  : width - 1] = rk_scale(white, brightest[i]);
            bloom_of_radius(&p, 8, (rk_bloom_border)border, 0.5f, 0.8f);
            for (int y = 0; y < height; y++)
                for (int x = 0; x < width; x++) {
                    rk_vec3 got = p.pixels[y][x];
                    rk_check(
                        isfinite(got.x) && isfinite(got.y) && isfinite(got.z),
                        "four pixels of %.3g, border %s: pixel (%d, %d) became (%g, %g, %g), want "
                        "a finite colour: a sum or a product of them was infinite",
                        (double)brightest[i], border_names[border], x, y, (double)got.x,
                        (double)got.y, (double)got.z);
                }
        }
}

/* A picture of one colour, all or part of which the filter covers. */
static void check_constant(rk_bloom_border border, int x, int y, double want, const char *hint)
{
    const rk_vec3 colour = {0.5f, 1, 0.75f};
    picture p;
    for (int i = 0; i < width * height; i++)
        p.pixels[i / width][i % width] = colour;
    bloom_of_radius(&p, 4, border, 0.5f, 1);
    for (int axis = 0; axis < 3; axis++) {
        double light = (double)rk_axis(colour, axis);
        double got = (double)rk_axis(p.pixels[y][x], axis) - light;
        rk_check(fabs(got - light * want) <= pass_tolerance(4),
                 "%d x %d pixels, all (.5, 1, .75), radius 4, border %s: the bloom at (%d, %d), "
                 "colour %d: got %.9g, want %.9g within %.3g: %s",
                 width, height, border_names[border], x, y, axis, got, light * want,
                 pass_tolerance(4), hint);
    }
}

static void an_even_picture_stays_even_far_from_borders(void **state)
{
    (void)state;
    check_constant(RK_BLOOM_ZERO, 18, 14, 1, "the weights sum to one");
}

static void a_border_of_zeros_loses_light(void **state)
{
    (void)state;
    const double side = (70 + 56 + 28 + 8 + 1) / 256.0; /* of C(8, k): the middle and four more */
    check_constant(RK_BLOOM_ZERO, 0, 14, side, "at the left border a half, and the middle");
    check_constant(RK_BLOOM_ZERO, width - 1, 14, side, "at the right border");
    check_constant(RK_BLOOM_ZERO, 18, 0, side, "at the top");
    check_constant(RK_BLOOM_ZERO, 0, height - 1, side * side, "in a corner");
}

static void with_clamp_or_renormalize_an_even_picture_stays_even(void **state)
{
    (void)state;
    for (int border = RK_BLOOM_CLAMP; border <= RK_BLOOM_RENORMALIZE; border++)
        for (int i = 0; i < 6; i++) {
            check_constant((rk_bloom_border)border, i, 14, 1, "it is even up to the left border");
            check_constant((rk_bloom_border)border, width - 1 - i, height - 1, 1,
                           "it is even along the bottom, and in its right corner");
        }
}

static void check_weight_inside(size_t place, size_t length, double want, const char *hint)
{
    float *weights = exact_copy((const float[]){0.375f, 0.25f, 0.0625f}, 3 * sizeof *weights);
    const rk_bloom_filter filter = filter_of(weights, 2, RK_BLOOM_RENORMALIZE);
    double got = (double)rk_bloom_weight_inside(&filter, place, length);
    free(weights);
    rk_check(got == want,
             "pixel %zu of %zu, weights .375, .25 and .0625: got %.9g inside, want %.9g: %s", place,
             length, got, want, hint);
}

/* All places in short lines, with weights that are multiples of 1/64 and sum exactly. The border
 * and the weights change from call to call. */
static void check_weights_inside(uint32_t reach, size_t place, size_t length)
{
    float *weights = exactly((reach + 1) * sizeof *weights);
    for (uint32_t call = 0; call < 6; call++) {
        double want = 0;
        for (uint32_t k = 0; k <= reach; k++)
            weights[k] = (float)(1 + rk_case(k, reach, call % 2, 7) % 64) / 64;
        for (size_t i = 0; i < length; i++) {
            size_t away = i < place ? place - i : i - place;
            want += away <= reach ? (double)weights[away] : 0;
        }
        const rk_bloom_filter filter = filter_of(weights, reach, (rk_bloom_border)(call / 2));
        double got = (double)rk_bloom_weight_inside(&filter, place, length);
        rk_check(
            got == want,
            "pixel %zu of %zu, reach %u, border %s: got %.9g inside, want %.9g: the weights of "
            "the line's pixels, whatever the border",
            place, length, reach, border_names[call / 2], got, want);
    }
    free(weights);
}

/* 2^-13 each, so that sums are exact. */
static void check_equal_weights_inside(size_t place, size_t length, double want)
{
    enum { reach = RK_BLOOM_RADIUS_MAX };
    static float weights[reach + 1];
    for (size_t k = 0; k <= reach; k++)
        weights[k] = 0x1p-13f;
    const rk_bloom_filter filter = filter_of(weights, reach, RK_BLOOM_RENORMALIZE);
    double got = (double)rk_bloom_weight_inside(&filter, place, length) * 0x1p13;
    rk_check(got == want, "pixel %zu of %zu, reach %d: got the weights of %.9g pixels, want %.9g",
             place, length, reach, got, want);
}

/* Added to 1 in a float, each of them is lost. */
static void check_small_weights_inside(void)
{
    enum { reach = RK_BLOOM_RADIUS_MAX };
    static float weights[reach + 1];
    weights[0] = 1;
    for (size_t k = 1; k <= reach; k++)
        weights[k] = 0x1p-25f;
    const rk_bloom_filter filter = filter_of(weights, reach, RK_BLOOM_RENORMALIZE);
    float got = rk_bloom_weight_inside(&filter, reach, 2 * reach + 1);
    rk_check_near((double)got, 1 + 2 * reach * 0x1p-25, 0x1p-23,
                  "reach %d, a weight of 1 in the middle and all others 2^-25: sum in double",
                  reach);
}

static void the_weight_inside_sums_the_taps_in_the_picture(void **state)
{
    (void)state;
    check_small_weights_inside();
    check_weight_inside(0, 11, 0.6875, "the two on the left are beyond the border");
    check_weight_inside(9, 11, 0.9375, "the last one on the right is beyond the border");
    check_weight_inside(5, 11, 1, "all are inside");
    check_weight_inside(2, 5, 1, "all are just inside");
    check_weight_inside(0, 1, 0.375, "only the middle is inside");
    check_weight_inside(1, 3, 0.875, "the last ones of both sides are beyond the border");
    for (uint32_t reach = 0; reach <= 5; reach++)
        for (size_t length = 1; length <= 12; length++)
            for (size_t place = 0; place < length; place++)
                check_weights_inside(reach, place, length);
    check_equal_weights_inside(0, 1, 1);
    check_equal_weights_inside(100, 300, 300);
    check_equal_weights_inside(5000, 10000, 2 * 4096 + 1);
    check_equal_weights_inside(65536 + 4095, 65536 + 4096, 4096 + 1);
    check_equal_weights_inside(65536 + 100, 200000, 2 * 4096 + 1);
}

static void nothing_above_the_threshold_changes_nothing(void **state)
{
    (void)state;
    picture before = random_picture(7), after = before;
    bloom_of_radius(&after, 15, RK_BLOOM_CLAMP, 1.5f, 0.8f);
    for (int i = 0; i < width * height; i++) {
        rk_vec3 want = before.pixels[i / width][i % width],
                got = after.pixels[i / width][i % width];
        rk_check(
            memcmp(&want, &got, sizeof want) == 0,
            "pixel (%d, %d), threshold 1.5: got (%g, %g, %g), want (%g, %g, %g), as it was: no "
            "pixel is brighter than 1",
            i % width, i / width, (double)got.x, (double)got.y, (double)got.z, (double)want.x,
            (double)want.y, (double)want.z);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(luminance_weighs_green_most),
    cmocka_unit_test(the_luminance_of_a_grey_is_the_grey),
    cmocka_unit_test(a_pixel_at_the_threshold_is_bright),
    cmocka_unit_test(only_finite_pixels_are_bright),
    cmocka_unit_test(sums_of_two_bright_pixels_are_finite),
    cmocka_unit_test(the_bright_span_is_from_the_first_to_the_last_bright_pixel),
    cmocka_unit_test(the_search_reads_no_pixel_between_the_ends),
    cmocka_unit_test(the_mask_keeps_bright_pixels_and_nothing_else),
    cmocka_unit_test(the_mask_reads_no_pixel_outside_of_the_bright_span),
    cmocka_unit_test(the_mask_is_zero_beyond_the_border),
    cmocka_unit_test(small_filters_are_rows_of_pascals_triangle),
    cmocka_unit_test(weights_are_pascals_rows_to_the_last_bit),
    cmocka_unit_test(the_weights_of_any_radius_sum_to_one),
    cmocka_unit_test(the_variance_is_half_the_radius),
    cmocka_unit_test(a_single_line_is_weighted_by_its_distance),
    cmocka_unit_test(all_lines_are_summed),
    cmocka_unit_test(lines_that_are_null_are_zeros),
    cmocka_unit_test(lines_that_are_null_cost_nothing),
    cmocka_unit_test(blurring_allocates_no_memory),
    cmocka_unit_test(the_blurred_mask_is_added_times_the_gain),
    cmocka_unit_test(a_point_of_light_becomes_the_filter),
    cmocka_unit_test(a_pixel_as_bright_as_floats_go_spoils_no_other),
    cmocka_unit_test(an_even_picture_stays_even_far_from_borders),
    cmocka_unit_test(a_border_of_zeros_loses_light),
    cmocka_unit_test(clamping_repeats_the_borders_own_pixel),
    cmocka_unit_test(the_weight_inside_sums_the_taps_in_the_picture),
    cmocka_unit_test(with_clamp_or_renormalize_an_even_picture_stays_even),
    cmocka_unit_test(rows_then_columns_are_the_full_filter),
    cmocka_unit_test(the_reach_is_the_shortest_within_half_an_ulp),
    cmocka_unit_test(nothing_above_the_threshold_changes_nothing),
};

RK_SUITE("bloom", tests)
