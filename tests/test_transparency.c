/* Transparency: the list keeps the nearest crossings in order, view rays blend them, and three
 * models say how much light passes them. All numbers are exact powers of two, unless there is a
 * bound. */
#include "test.h"

#include "base/random.h"
#include "features/transparency.h"

/* --- Crossings to try ------------------------------------------------------------------------- */

static const rk_vec3 white = {1, 1, 1}, red = {1, 0, 0}, yellow = {1, 1, 0};

/* A pane of glass without thickness, entered from its outside. */
static rk_crossing pane(float t, float alpha, rk_vec3 kd)
{
    return (rk_crossing){.t = t, .alpha = alpha, .kd = kd, .entering = true};
}

/* A face of a block of clear glass that absorbs: its front where `entering`. */
static rk_crossing face(float t, uint32_t medium, bool entering, rk_vec3 absorption)
{
    return (rk_crossing){
        .t = t, .medium = medium, .entering = entering, .kd = white, .absorption = absorption};
}

static void check_colour_or(rk_vec3 got, rk_vec3 want, float tolerance,
                            const rk_vector_mistake *known, const char *hint)
{
    const double *a = RK_XYZ(got), *b = RK_XYZ(want);
    bool close = true;
    for (int k = 0; k < 3; k++)
        close = close && fabs(a[k] - b[k]) <= (double)tolerance;
    rk_check(close, "got (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g) within %.3g: %s%s", a[0], a[1],
             a[2], b[0], b[1], b[2], (double)tolerance, hint,
             rk_mistake_in_vector(a, b, (double)tolerance, known));
}

static void check_colour(rk_vec3 got, rk_vec3 want, float tolerance, const char *hint)
{
    check_colour_or(got, want, tolerance, NULL, hint);
}

/* The largest float below 1. */
static const float nearly_opaque = 1 - 0x1p-24f;

static bool is_before(const rk_crossing *a, const rk_crossing *b)
{
    return a->t < b->t || (a->t == b->t && a->primitive < b->primitive);
}

static bool is_same_colour(rk_vec3 a, rk_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool is_same(const rk_crossing *a, const rk_crossing *b)
{
    return a->t == b->t && a->u == b->u && a->v == b->v && a->primitive == b->primitive &&
           a->medium == b->medium && a->entering == b->entering && a->alpha == b->alpha &&
           is_same_colour(a->kd, b->kd) && is_same_colour(a->absorption, b->absorption);
}

static rk_vec3 random_colour(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_vec(rk_unit_float(rk_case(a, b, c, 0)), rk_unit_float(rk_case(a, b, c + 1, 0)),
                  rk_unit_float(rk_case(a, b, c + 2, 0)));
}

/* Any alpha below 1, most of them small enough for some light to pass many surfaces. */
static float random_alpha(uint32_t a, uint32_t b)
{
    const float special[] = {0, 1e-30f, 1e-8f, 0.5f, nearly_opaque};
    uint32_t kind = rk_case(a, b, 41, 0) % 40;
    float any = rk_unit_float(rk_case(a, b, 42, 0));
    return kind < 5 ? special[kind] : any * any;
}

/* All members are random, and t ascends in k: what a result should not depend on varies, too. */
static rk_crossing random_crossing(uint32_t trial, uint32_t k, uint32_t count)
{
    return (rk_crossing){.t = (float)(k / 2 + 1) / (float)(count + 1),
                         .u = rk_unit_float(rk_case(trial, k, 11, 0)),
                         .v = rk_unit_float(rk_case(trial, k, 12, 0)),
                         .primitive = k,
                         .medium = rk_case(trial, k, 13, 0) % 3,
                         .entering = rk_case(trial, k, 14, 0) % 2,
                         .alpha = random_alpha(trial, k),
                         .kd = random_colour(trial, k, 15),
                         .absorption = random_colour(trial, k, 18)};
}

/* Mostly few crossings, now and then as many as a list may have, so clear that the last counts. */
static uint32_t random_crossings(uint32_t trial, rk_crossing *crossings)
{
    uint32_t count =
        trial % 50 == 49 ? RK_CROSSINGS_MAX - trial / 50 % 2 : rk_case(trial, 0, 43, 0) % 16;
    for (uint32_t k = 0; k < count; k++) {
        crossings[k] = random_crossing(trial, k, count);
        if (count > 16) {
            crossings[k].alpha /= 64;
            crossings[k].kd = rk_madd(white, crossings[k].kd, -1.0f / 64);
        }
    }
    return count;
}

static void check_unchanged(const rk_crossing *crossings, const rk_crossing *before, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        rk_check(is_same(&crossings[k], &before[k]),
                 "crossing %u of %u was changed: they are the caller's, and constant", k, count);
}

/* Lists are read by several threads at once. */
static void check_constant_crossings(rk_glass_model model)
{
    const rk_crossing own[] = {face(0.25f, 1, true, rk_vec(1, 0.5f, 0)),
                               face(0.75f, 1, false, rk_vec(1, 0.5f, 0))};
    const rk_crossing *constant = rk_read_only(own, sizeof own, "crossings");
    float weights[2], transmittance;
    rk_transparency_weights(constant, 2, weights, &transmittance);
    rk_vec3 got = rk_transparency_transmit(model, constant, 2, 3);
    rk_vec3 want = rk_transparency_transmit(model, own, 2, 3);
    check_colour(got, want, 0, "the same crossings at another place in memory");
    rk_crossing_list list;
    rk_transparency_start(&list, RK_CROSSINGS_MAX);
    rk_transparency_insert(&list, &constant[1]);
    rk_transparency_insert(&list, &constant[0]);
    rk_read_only_free();
}

/* --- The list --------------------------------------------------------------------------------- */

static void insert(rk_crossing_list *list, float t, uint32_t primitive, float alpha)
{
    rk_crossing crossing = {.t = t, .primitive = primitive, .alpha = alpha};
    rk_transparency_insert(list, &crossing);
}

static void check_list(const rk_crossing_list *list, const uint32_t *primitives, uint32_t count,
                       const char *hint)
{
    rk_check_equal(list->count, count, hint);
    for (uint32_t i = 0; i < count; i++)
        rk_check(list->crossings[i].primitive == primitives[i],
                 "entry %u: got primitive %u, want %u: %s", i, list->crossings[i].primitive,
                 primitives[i], hint);
}

static void crossings_inserted_in_any_order_are_sorted_by_t(void **state)
{
    (void)state;
    rk_crossing_list list;
    rk_transparency_start(&list, RK_CROSSINGS_MAX);
    const float t[] = {0.5f, 0.25f, 1, 0.125f, 0.75f};
    for (uint32_t i = 0; i < 5; i++)
        insert(&list, t[i], i, 0.5f);
    check_list(&list, (const uint32_t[]){3, 1, 0, 4, 2}, 5, "sorted by t");
}

static void crossings_at_equal_t_are_sorted_by_primitive(void **state)
{
    (void)state;
    rk_crossing_list list;
    rk_transparency_start(&list, RK_CROSSINGS_MAX);
    const uint32_t primitives[] = {7, 2, 9, 4};
    for (uint32_t i = 0; i < 4; i++)
        insert(&list, 0.5f, primitives[i], 0.5f);
    check_list(&list, (const uint32_t[]){2, 4, 7, 9}, 4,
               "coinciding crossings are all kept, the smaller primitive first");
    /* A ray that touches a sphere enters and leaves it at one t. */
    insert(&list, 0.5f, 4, 0.5f);
    insert(&list, 0.5f, 2, 0.5f);
    check_list(&list, (const uint32_t[]){2, 2, 4, 4, 7, 9}, 6,
               "two crossings of one primitive at one t are two crossings");
}

static void crossings_at_neighbouring_t_are_all_kept(void **state)
{
    (void)state;
    const float starts[] = {0x1p-100f, 1e-3f, 1, 1000, 1e30f};
    for (int s = 0; s < 5; s++) {
        rk_crossing_list list;
        rk_transparency_start(&list, RK_CROSSINGS_MAX);
        float t[4] = {starts[s]};
        for (int i = 1; i < 4; i++)
            t[i] = nextafterf(t[i - 1], INFINITY);
        insert(&list, t[2], 2, 0.5f);
        insert(&list, t[0], 0, 0.5f);
        insert(&list, t[3], 3, 0.5f);
        insert(&list, t[1], 1, 0.5f);
        check_list(&list, (const uint32_t[]){0, 1, 2, 3}, 4,
                   "four t, each the next float after the one before, are four crossings");
    }
}

static void the_largest_alpha_below_1_is_not_opaque(void **state)
{
    (void)state;
    rk_crossing_list list;
    rk_transparency_start(&list, 3);
    insert(&list, 2, 2, 0.5f);
    insert(&list, 1, 1, nearly_opaque);
    rk_check_close(rk_transparency_end(&list, 9), 9, 0, "alpha 1 - 2^-24 lets some light through");
    insert(&list, 3, 3, 0.5f);
    check_list(&list, (const uint32_t[]){1, 2, 3}, 3, "alpha 1 - 2^-24 lets some light through");
}

static void a_list_of_the_greatest_length_stays_in_its_memory(void **state)
{
    (void)state;
    struct {
        rk_crossing_list list;
        unsigned char beyond[sizeof(rk_crossing)];
    } memory;
    for (int ascending = 0; ascending < 2; ascending++) {
        memset(&memory, 0x5a, sizeof memory);
        rk_transparency_start(&memory.list, RK_CROSSINGS_MAX);
        for (uint32_t i = 0; i <= RK_CROSSINGS_MAX; i++) {
            uint32_t at = ascending ? i : RK_CROSSINGS_MAX - i;
            insert(&memory.list, (float)(at + 1), at, 0.5f);
        }
        rk_check_equal(memory.list.count, RK_CROSSINGS_MAX, "a full list stays full");
        for (uint32_t i = 0; i < RK_CROSSINGS_MAX; i++)
            rk_check(memory.list.crossings[i].primitive == i,
                     "entry %u: got primitive %u, want %u: sorted by t", i,
                     memory.list.crossings[i].primitive, i);
        for (size_t i = 0; i < sizeof memory.beyond; i++)
            rk_check(memory.beyond[i] == 0x5a,
                     "RK_CROSSINGS_MAX + 1 crossings, %s: wrote beyond the list's last entry",
                     ascending ? "nearest first" : "farthest first");
    }
}

static void a_full_list_keeps_the_nearest(void **state)
{
    (void)state;
    for (uint32_t limit = 1; limit <= 4; limit++) {
        rk_crossing_list list;
        rk_transparency_start(&list, limit);
        const float t[] = {5, 3, 6, 1, 4, 2};
        for (uint32_t i = 0; i < 6; i++)
            insert(&list, t[i], (uint32_t)t[i], 0.5f);
        check_list(&list, (const uint32_t[]){1, 2, 3, 4}, limit,
                   "the nearest crossings, up to the list's limit");
    }
}

static void crossings_behind_an_opaque_one_are_dropped(void **state)
{
    (void)state;
    rk_crossing_list list;
    rk_transparency_start(&list, 4);
    insert(&list, 1, 1, 0.5f);
    insert(&list, 4, 4, 0.5f);
    insert(&list, 5, 5, 0.5f);
    insert(&list, 3, 3, 1);
    check_list(&list, (const uint32_t[]){1, 3}, 2, "the opaque crossing at 3 hides 4 and 5");
    insert(&list, 6, 6, 0.5f);
    check_list(&list, (const uint32_t[]){1, 3}, 2, "6 lies behind the opaque crossing at 3");
    insert(&list, 2, 2, 0.5f);
    check_list(&list, (const uint32_t[]){1, 2, 3}, 3, "2 lies before it");
}

static void the_end_is_where_no_crossing_can_be_added(void **state)
{
    (void)state;
    rk_crossing_list list;
    rk_transparency_start(&list, 2);
    rk_check_close(rk_transparency_end(&list, 9), 9, 0,
                   "an empty list takes crossings up to t_max");
    rk_check(rk_transparency_end(&list, INFINITY) == INFINITY,
             "an empty list takes crossings up to t_max, which may be infinite");
    insert(&list, 5, 5, 0.5f);
    rk_check_close(rk_transparency_end(&list, 9), 9, 0, "there is room for another crossing");
    insert(&list, 7, 7, 0.5f);
    rk_check_close(rk_transparency_end(&list, 9), 7, 0, "a full list ends with its last entry");
    insert(&list, 3, 3, 1);
    rk_check_close(rk_transparency_end(&list, 9), 3, 0, "an opaque crossing ends it in any case");
    const float places[] = {0x1p-149f, 1e-30f, 1e-6f, 1e30f, 3e38f};
    for (int i = 0; i < 5; i++)
        for (int opaque = 0; opaque < 2; opaque++) {
            rk_transparency_start(&list, opaque ? 2 : 1);
            insert(&list, places[i], 1, opaque ? 1 : 0.5f);
            rk_check(rk_transparency_end(&list, INFINITY) == places[i],
                     "a list that ends with a crossing at %g: got an end of %g", (double)places[i],
                     (double)rk_transparency_end(&list, INFINITY));
        }
}

static void the_list_does_not_depend_on_the_order_of_insertion(void **state)
{
    (void)state;
    const float units[] = {1, 0x1p-140f, 1e-20f, 1e20f, 4e37f};
    const uint32_t primitives[12] = {
        0,         1,        255,       256, 65535, 65536, 65537, 1u << 24, (1u << 24) + 1,
        INT32_MAX, 1u << 31, UINT32_MAX};
    for (uint32_t trial = 0; trial < 2000; trial++) {
        float unit = units[trial % 5];
        uint32_t count = rk_case(trial, 0, 1, 0) % 12, limit = 1 + rk_case(trial, 0, 2, 0) % 8;
        rk_crossing all[12];
        char inserted[640] = "", hint[768];
        size_t said = 0;
        rk_crossing_list list;
        rk_transparency_start(&list, limit);
        for (uint32_t i = 0; i < count; i++) {
            all[i] = random_crossing(trial, i, count);
            all[i].t = unit * (float)(1 + rk_case(trial, i, 3, 0) % 8);
            all[i].primitive = primitives[(5 * i + 7) % 12]; /* comes in any order */
            all[i].medium = rk_case(trial, i, 13, 0);
            if (rk_case(trial, i, 4, 0) % 6 == 0)
                all[i].alpha = 1;
            rk_crossing inserted_one = all[i];
            rk_transparency_insert(&list, &inserted_one);
            rk_check(is_same(&inserted_one, &all[i]), "the crossing that is inserted was changed");
            said += (size_t)snprintf(inserted + said, sizeof inserted - said, "%s%g %u %g",
                                     i ? ", " : "", (double)all[i].t, all[i].primitive,
                                     (double)all[i].alpha);
        }
        for (uint32_t i = 1; i < count; i++)
            for (uint32_t j = i; j > 0 && is_before(&all[j], &all[j - 1]); j--) {
                rk_crossing swapped = all[j];
                all[j] = all[j - 1];
                all[j - 1] = swapped;
            }
        uint32_t want[12], wanted = 0;
        while (wanted < count && wanted < limit && (wanted == 0 || all[wanted - 1].alpha < 1)) {
            want[wanted] = all[wanted].primitive;
            wanted++;
        }
        snprintf(
            hint, sizeof hint,
            "limit %u, inserted (t primitive alpha): %s; the nearest, none behind an opaque one",
            limit, inserted);
        check_list(&list, want, wanted, hint);
        for (uint32_t i = 0; i < wanted; i++)
            rk_check(is_same(&list.crossings[i], &all[i]),
                     "entry %u is the crossing of primitive %u, but not all of its members are "
                     "those that were inserted",
                     i, all[i].primitive);
    }
}

/* --- View rays -------------------------------------------------------------------------------- */

/* The memory of what is to be written holds NaN at first. */
static void weigh(const rk_crossing *crossings, uint32_t count, float *weights,
                  float *transmittance)
{
    for (uint32_t k = 0; k < count; k++)
        weights[k] = NAN;
    *transmittance = NAN;
    rk_transparency_weights(crossings, count, weights, transmittance);
    for (uint32_t k = 0; k < count; k++)
        rk_check(!isnan(weights[k]),
                 "weight %u of %u is NaN, which its memory holds before the call: is each weight "
                 "written, also of a surface of alpha 0, and of those behind an opaque one?",
                 k, count);
    rk_check(!isnan(*transmittance),
             "the transmittance of %u surfaces is NaN, which its memory holds before the call: is "
             "it written?",
             count);
}

static void one_surface_weighs_alpha_and_transmits_the_rest(void **state)
{
    (void)state;
    rk_crossing crossing = pane(1, 0.25f, red);
    float weight, transmittance;
    weigh(&crossing, 1, &weight, &transmittance);
    rk_check_near_or(
        weight, 0.25, 0,
        RK_MISTAKES({0.75, "alpha is taken for what is transmitted, 1 - alpha"},
                    {0.25 * 0.75, "the surface's own 1 - alpha is in its weight, too"}),
        "alpha 0.25 is opacity: the weight of the surface's own colour");
    rk_check_close(transmittance, 0.75, 0, "1 - alpha is transmitted");
}

static void weights_are_alpha_times_the_transmittance_before(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {pane(1, 0.5f, red), pane(2, 0.25f, red), pane(3, 0, red),
                                     pane(4, 0.75f, red)};
    const float want[] = {0.5f, 0.125f, 0, 0.28125f};
    float weights[4], transmittance;
    weigh(crossings, 4, weights, &transmittance);
    for (int k = 0; k < 4; k++)
        rk_check(weights[k] == want[k], "pane %d: got %g, want %g: alpha_k prod (1 - alpha_j)", k,
                 (double)weights[k], (double)want[k]);
    rk_check_close(transmittance, 0.09375, 0, "the product of all 1 - alpha");
    for (uint32_t trial = 0; trial < 500; trial++) {
        rk_crossing many[RK_CROSSINGS_MAX], before[RK_CROSSINGS_MAX];
        float fractions[RK_CROSSINGS_MAX];
        uint32_t count = random_crossings(trial, many);
        double behind = 1;
        memcpy(before, many, sizeof before);
        for (uint32_t k = 0; k < RK_CROSSINGS_MAX; k++)
            fractions[k] = NAN;
        rk_transparency_weights(many, count, fractions, &transmittance);
        for (uint32_t k = count; k < RK_CROSSINGS_MAX; k++)
            rk_check(isnan(fractions[k]), "%u surfaces: weight %u, beyond the last, was written",
                     count, k);
        for (uint32_t k = 0; k < count; k++) {
            /* Two roundings per surface, or what the smallest floats lose. */
            double expected = (double)before[k].alpha * behind;
            rk_check_near(fractions[k], expected, 2 * (k + 1) * (expected * 0x1p-24 + 0x1p-149),
                          "weight of surface %u of %u, of alpha %g, behind surfaces that transmit "
                          "%g: alpha_k prod (1 - alpha_j), however small, whatever else it is",
                          k, count, (double)before[k].alpha, behind);
            behind *= 1 - (double)before[k].alpha;
        }
        rk_check_near(transmittance, behind, 2 * (count + 1) * (behind * 0x1p-24 + 0x1p-149),
                      "transmittance of %u surfaces: the product of all 1 - alpha", count);
        check_unchanged(many, before, count);
    }
}

/* Many surfaces of alpha 0 and of alpha 1, and others. */
static void check_clear_and_opaque(uint32_t trial)
{
    rk_crossing crossings[8];
    float weights[8], transmittance;
    uint32_t count = 1 + trial % 8;
    double behind = 1;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t kind = rk_case(trial, k, 44, 0) % 4;
        float alpha = kind < 2 ? (float)kind : rk_unit_float(rk_case(trial, k, 45, 0));
        crossings[k] = pane((float)(k + 1), alpha, white);
    }
    weigh(crossings, count, weights, &transmittance);
    for (uint32_t k = 0; k < count; k++) {
        double want = (double)crossings[k].alpha * behind;
        /* Two roundings per surface. */
        rk_check_near(weights[k], want, 2 * (k + 1) * want * 0x1p-24,
                      "weight of surface %u of %u, of alpha %g, behind surfaces that transmit %g",
                      k, count, (double)crossings[k].alpha, behind);
        behind *= 1 - (double)crossings[k].alpha;
    }
}

static void nothing_is_seen_behind_an_opaque_surface(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {pane(1, 0.5f, red), pane(2, 1, red), pane(3, 0.5f, red)};
    float weights[3], transmittance;
    weigh(crossings, 2, weights, &transmittance);
    rk_check_close(weights[1], 0.5, 0, "opaque: all of the remaining transmittance");
    rk_check_close(transmittance, 0, 0, "nothing is transmitted");
    weigh(crossings, 3, weights, &transmittance);
    rk_check_close(weights[2], 0, 0, "behind an opaque surface: 0, and written, too");
    for (uint32_t trial = 0; trial < 400; trial++)
        check_clear_and_opaque(trial);
}

static void without_crossings_the_transmittance_is_1(void **state)
{
    (void)state;
    float transmittance = 0;
    rk_transparency_weights(NULL, 0, NULL, &transmittance);
    rk_check_close(transmittance, 1, 0, "a ray that crosses nothing shows the background alone");
    const rk_crossing crossing = pane(1, 0, red);
    float weight;
    rk_transparency_weights(&crossing, 1, &weight, &transmittance);
    rk_check_close(transmittance, 1, 0, "behind a pane of alpha 0 the transmittance is 1, too");
}

static void weights_and_transmittance_sum_to_one(void **state)
{
    (void)state;
    for (uint32_t trial = 0; trial < 1000; trial++) {
        rk_crossing crossings[16];
        float weights[16], transmittance;
        double sum = 0;
        for (uint32_t k = 0; k < 16; k++)
            crossings[k] = pane((float)k, rk_unit_float(rk_case(trial, k, 5, 0)), white);
        rk_transparency_weights(crossings, 16, weights, &transmittance);
        for (uint32_t k = 0; k < 16; k++)
            sum += (double)weights[k];
        /* Three roundings per pane, each at most 2^-24 of a number below 1. */
        rk_check_close(sum + (double)transmittance, 1, 48 * 0x1p-24,
                       "no light is created and none is lost");
    }
}

static void the_transmittance_is_a_product(void **state)
{
    (void)state;
    rk_crossing crossings[40];
    float weights[40], transmittance;
    for (uint32_t k = 0; k < 40; k++)
        crossings[k] = pane((float)k, 0.5f, white);
    rk_transparency_weights(crossings, 40, weights, &transmittance);
    rk_check_close(transmittance, 0x1p-40, 0, "40 panes of alpha 0.5: 2^-40, not lost in a sum");
    for (uint32_t trial = 0; trial < 1000; trial++) {
        uint32_t count = 1 + trial % 16;
        double want = 1;
        for (uint32_t k = 0; k < count; k++) {
            crossings[k] = pane((float)k, rk_unit_float(rk_case(trial, k, 10, 0)), white);
            want *= 1 - (double)crossings[k].alpha;
        }
        rk_transparency_weights(crossings, count, weights, &transmittance);
        /* Two roundings per pane. */
        rk_check(fabs((double)transmittance - want) <= 32 * 0x1p-24 * want,
                 "%u panes: got a transmittance of %.9g, want %.9g: the product of all 1 - alpha",
                 count, (double)transmittance, want);
        crossings[count - 1].alpha = 1;
        rk_transparency_weights(crossings, count, weights, &transmittance);
        rk_check_close(transmittance, 0, 0, "exactly 0 through an opaque surface");
    }
}

static void max_depth_is_exact(void **state)
{
    (void)state;
    const uint32_t panes = 12;
    for (uint32_t limit = 0; limit < 10; limit++) {
        rk_crossing_list list;
        float weights[RK_CROSSINGS_MAX], transmittance;
        rk_transparency_start(&list, limit + 1);
        for (uint32_t i = 0; i < panes; i++)
            insert(&list, (float)(panes - i), panes - i, 0.5f);
        rk_check_equal(list.count, limit + 1,
                       "a max depth of n keeps the first surface and n behind it");
        rk_transparency_weights(list.crossings, list.count, weights, &transmittance);
        rk_check_close(weights[limit], ldexp(1, -(int)limit - 1), 0,
                       "the last surface kept is weighted like all others");
        rk_check_close(transmittance, ldexp(1, -(int)limit - 1), 0,
                       "the rest, which is not traced");
    }
}

/* --- Shadow rays: all models ------------------------------------------------------------------ */

static const rk_glass_model models[] = {RK_GLASS_MULTIPLICATIVE, RK_GLASS_ORDERED,
                                        RK_GLASS_BEER_LAMBERT};
enum { model_count = sizeof models / sizeof models[0] };

/* A pane that takes about half of the green light or more by each model, and not all. */
static rk_crossing tinted_pane(float t)
{
    rk_crossing crossing = pane(t, 0.5f, red);
    crossing.kd.y = 0x1p-10f;
    crossing.absorption = rk_vec(0, 2, 0);
    return crossing;
}

static void check_some_light(rk_glass_model model, const rk_crossing *crossings, uint32_t count)
{
    rk_vec3 got = rk_transparency_transmit(model, crossings, count, 1);
    rk_check(got.y > 0 && got.y < 0.75f,
             "%u red panes: got %g of the green light by %s, want some, and not all", count,
             (double)got.y,
             model == RK_GLASS_MULTIPLICATIVE ? "the product"
             : model == RK_GLASS_ORDERED      ? "blending"
                                              : "Beer-Lambert");
}

static void without_crossings_all_light_arrives(void **state)
{
    (void)state;
    for (int m = 0; m < model_count; m++) {
        check_colour(rk_transparency_transmit(models[m], NULL, 0, 2), white, 0,
                     "no pane, no shadow, for every model");
        const rk_crossing crossing = tinted_pane(0.5f);
        check_some_light(models[m], &crossing, 1);
    }
}

static void opaque_surfaces_transmit_no_light(void **state)
{
    (void)state;
    for (int m = 0; m < model_count; m++)
        for (uint32_t opaque = 0; opaque < 3; opaque++) {
            rk_crossing crossings[] = {pane(0.25f, 0.5f, white), pane(0.5f, 0.5f, white),
                                       pane(0.75f, 0.5f, white)};
            crossings[opaque].alpha = 1;
            check_colour(rk_transparency_transmit(models[m], crossings, 3, 1), rk_vec(0, 0, 0), 0,
                         "an opaque surface casts a black shadow, for every colour and position");
            crossings[opaque].alpha = nearly_opaque;
            rk_vec3 some = rk_transparency_transmit(models[m], crossings, 3, 1);
            rk_check(some.x > 0, "got no light through a pane of alpha 1 - 2^-24, want some");
            rk_vec3 without =
                rk_transparency_transmit(models[m], crossings + opaque + 1, 2 - opaque, 1);
            rk_check(without.x > 0, "got no light through %u panes of alpha 0.5, want some",
                     2 - opaque);
        }
    for (int m = 0; m < model_count; m++) {
        const rk_crossing tinted[] = {tinted_pane(0.25f), tinted_pane(0.5f)};
        check_some_light(models[m], tinted, 2);
    }
    rk_crossing many[RK_CROSSINGS_MAX];
    for (uint32_t k = 0; k < RK_CROSSINGS_MAX; k++)
        many[k] = pane((float)(k + 1) / (RK_CROSSINGS_MAX + 1), 0, white);
    for (int m = 0; m < model_count; m++)
        for (uint32_t opaque = 0; opaque < RK_CROSSINGS_MAX; opaque++) {
            rk_check(rk_transparency_transmit(models[m], many, RK_CROSSINGS_MAX, 1).x > 0.99f,
                     "got no light through %d clear panes", RK_CROSSINGS_MAX);
            many[opaque].alpha = 1;
            many[opaque].entering = opaque % 2;
            check_colour(rk_transparency_transmit(models[m], many, RK_CROSSINGS_MAX, 1),
                         rk_vec(0, 0, 0), 0, "one opaque surface of many, any of them, is enough");
            many[opaque].alpha = 0;
        }
}

/* --- Multiplicative --------------------------------------------------------------------------- */

static void multiplicative_is_the_product_of_colours_and_one_minus_alpha(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {pane(0.25f, 0.5f, rk_vec(1, 0.5f, 0.25f)),
                                     pane(0.5f, 0.75f, rk_vec(0.5f, 1, 0.5f))};
    check_colour_or(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, crossings + 1, 1, 1),
                    rk_vec(0.125f, 0.25f, 0.125f), 0,
                    RK_VECTOR_MISTAKES(
                        {{0.375, 0.75, 0.375}, "alpha lets light through, but it is the opacity"},
                        {{0.25, 0.25, 0.25}, "the surface's colour kd is left out"},
                        {{0.5, 1, 0.5}, "1 - alpha is left out"}),
                    "kd (1 - alpha), with kd = (0.5, 1, 0.5) and alpha = 0.75");
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, crossings, 1, 1),
                 rk_vec(0.5f, 0.25f, 0.125f), 0, "kd (1 - alpha)");
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, crossings, 2, 1),
                 rk_vec(0.0625f, 0.0625f, 0.015625f), 0, "the product over both panes");
    check_constant_crossings(RK_GLASS_MULTIPLICATIVE);
    const rk_crossing clear = pane(0.5f, 0, rk_vec(1, 0.5f, 0.25f));
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, &clear, 1, 1),
                 rk_vec(1, 0.5f, 0.25f), 0,
                 "a pane of alpha 0 colours the light by kd all the same");
    rk_crossing block[] = {face(0.25f, 1, true, red), face(0.75f, 1, false, red)};
    block[0].alpha = block[1].alpha = 0.5f;
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, block, 2, 1),
                 rk_vec(0.25f, 0.25f, 0.25f), 0,
                 "a block is crossed twice, where it is entered and where it is left");
    for (uint32_t trial = 0; trial < 500; trial++) {
        rk_crossing many[RK_CROSSINGS_MAX], before[RK_CROSSINGS_MAX];
        uint32_t count = random_crossings(trial, many);
        memcpy(before, many, sizeof before);
        rk_vec3 got = rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, many, count, 3);
        for (int axis = 0; axis < 3; axis++) {
            double want = 1;
            for (uint32_t k = 0; k < count; k++)
                want *= (double)rk_axis(before[k].kd, axis) * (1 - (double)before[k].alpha);
            /* Three roundings per surface, or what the smallest floats lose. */
            rk_check_near(rk_axis(got, axis), want, 3 * (count + 1) * (want * 0x1p-24 + 0x1p-149),
                          "%u surfaces, colour %d: each crossing counts, whether it enters or "
                          "leaves, and whatever its medium",
                          count, axis);
        }
        check_unchanged(many, before, count);
    }
}

static void a_black_channel_leaves_the_others(void **state)
{
    (void)state;
    const rk_vec3 colours[] = {{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
    for (int i = 0; i < 6; i++) {
        const rk_crossing crossings[] = {pane(0.25f, 0.5f, white), pane(0.5f, 0.5f, colours[i])};
        check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, crossings, 2, 1),
                     rk_scale(colours[i], 0.25f), 0,
                     "glass that is black in one channel is not opaque");
    }
}

static void multiplicative_ignores_the_order(void **state)
{
    (void)state;
    const rk_crossing red_first[] = {pane(0.25f, 0.5f, red), pane(0.5f, 0.5f, yellow)};
    const rk_crossing yellow_first[] = {pane(0.25f, 0.5f, yellow), pane(0.5f, 0.5f, red)};
    const rk_vec3 want = {0.25f, 0, 0};
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, red_first, 2, 1), want, 0,
                 "red then yellow");
    check_colour(rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, yellow_first, 2, 1), want, 0,
                 "yellow then red: a product does not know the order");
}

/* --- Ordered ---------------------------------------------------------------------------------- */

static void ordered_blends_one_pane_over_white(void **state)
{
    (void)state;
    const rk_crossing crossing = pane(0.5f, 0.25f, rk_vec(0, 0.5f, 1));
    check_colour(rk_transparency_transmit(RK_GLASS_ORDERED, &crossing, 1, 1),
                 rk_vec(0.75f, 0.875f, 1), 0, "alpha kd + (1 - alpha) white");
}

static void ordered_tells_red_then_yellow_from_yellow_then_red(void **state)
{
    (void)state;
    const rk_crossing red_first[] = {pane(0.25f, 0.5f, red), pane(0.5f, 0.5f, yellow)};
    const rk_crossing yellow_first[] = {pane(0.25f, 0.5f, yellow), pane(0.5f, 0.5f, red)};
    check_colour_or(
        rk_transparency_transmit(RK_GLASS_ORDERED, red_first, 2, 1), rk_vec(1, 0.5f, 0.25f), 0,
        RK_VECTOR_MISTAKES({{1, 0.75, 0.25}, "the surface nearest to the light is in front"},
                           {{0.25, 0, 0}, "surfaces multiply, as in the multiplicative model"},
                           {{0.75, 0.25, 0}, "the white light behind all surfaces is left out"}),
        "red nearest to the point: red / 2 + yellow / 4 + white / 4");
    check_colour(rk_transparency_transmit(RK_GLASS_ORDERED, yellow_first, 2, 1),
                 rk_vec(1, 0.75f, 0.25f), 0,
                 "yellow nearest to the point: yellow / 2 + red / 4 + white / 4");
}

static void ordered_equals_a_view_ray_towards_a_white_light(void **state)
{
    (void)state;
    check_constant_crossings(RK_GLASS_ORDERED);
    for (uint32_t trial = 0; trial < 1000; trial++) {
        rk_crossing crossings[RK_CROSSINGS_MAX], before[RK_CROSSINGS_MAX];
        uint32_t count = random_crossings(trial, crossings);
        memcpy(before, crossings, sizeof before);
        /* alpha kd + (1 - alpha) behind, from the light to the point. */
        rk_vec3 want = white;
        float densest = 0;
        for (uint32_t k = count; k-- > 0;) {
            want = rk_mix(want, crossings[k].kd, crossings[k].alpha);
            densest = rk_max(densest, crossings[k].alpha);
        }
        char hint[160];
        snprintf(hint, sizeof hint,
                 "each of %u surfaces over those behind it, whether it is entered or left, a white "
                 "light last; the largest alpha is %.9g",
                 count, (double)densest);
        /* Four roundings per surface on either side, each at most 2^-24 of a number below 1. */
        check_colour(rk_transparency_transmit(RK_GLASS_ORDERED, crossings, count, 3), want,
                     8 * (float)(count + 1) * 0x1p-24f, hint);
        check_unchanged(crossings, before, count);
    }
    rk_crossing black[40];
    for (uint32_t k = 0; k < 40; k++)
        black[k] = pane((float)(k + 1) / 41, 0.5f, rk_vec(0, 0, 0));
    rk_vec3 faint = rk_transparency_transmit(RK_GLASS_ORDERED, black, 40, 1);
    rk_check_close(faint.x, 0x1p-40, 0, "behind 40 black panes of alpha 0.5: 2^-40 of the light");
}

/* --- Beer-Lambert ----------------------------------------------------------------------------- */

static const rk_vec3 sigma = {1, 0.5f, 0};

/* `thickness` world units of glass that absorbs sigma; expf may be off by two units in the last
 * place, and the product sigma thickness (at most 8) by one. */
static void check_thickness(const rk_crossing *crossings, uint32_t count, float length,
                            double thickness, const char *hint)
{
    rk_vec3 got = rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, crossings, count, length);
    const double x = (double)sigma.x * thickness, y = (double)sigma.y * thickness;
    check_colour_or(
        got, rk_vec((float)exp(-x), (float)exp(-y), 1), 10 * 0x1p-23f,
        RK_VECTOR_MISTAKES(
            {{exp(-2 * x), exp(-2 * y), 1}, "each of the block's faces absorbs its thickness"},
            {{exp(-x / (double)length), exp(-y / (double)length), 1},
             "the thickness is left in units of t, not multiplied by the ray's length"},
            {{1 - x, 1 - y, 1}, "absorption is linear, 1 - sigma thickness"},
            {{exp(x), exp(y), 1}, "the exponent lacks its minus sign"},
            {{1, 1, 1},
             "nothing is absorbed: is the interval between entering and leaving found?"}),
        hint);
}

static void a_block_absorbs_by_its_thickness(void **state)
{
    (void)state;
    check_constant_crossings(RK_GLASS_BEER_LAMBERT);
    const rk_crossing thin[] = {face(0.5f, 1, true, sigma), face(0.625f, 1, false, sigma)};
    const rk_crossing thick[] = {face(0.25f, 1, true, sigma), face(0.75f, 1, false, sigma)};
    check_thickness(
        thin, 2, 1, 0.125,
        "exp(-sigma thickness), from entering to leaving; alpha is 0: glass absorbs whatever "
        "its alpha");
    check_thickness(thick, 2, 1, 0.5, "four times as thick");
    check_thickness(thick, 2, 4, 2, "thickness is in world units: t times the ray's length");
    rk_vec3 a = rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, thin, 2, 1);
    rk_vec3 b = rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, thick, 2, 1);
    check_colour(a, b, 0, "the multiplicative model does not depend on thickness");
    /* Between a float and the next, on so long a ray that the block is one unit thick. */
    const float places[] = {0x1p-100f, 0.25f, 0.5f, 0.75f};
    for (int i = 0; i < 4; i++) {
        float next = nextafterf(places[i], 1), length = 1 / (next - places[i]);
        const rk_crossing block[] = {face(places[i], 1, true, sigma), face(next, 1, false, sigma)};
        check_thickness(block, 2, length, 1,
                        "however close in t a block's two faces are, it absorbs by its thickness");
    }
    for (int e = -120; e <= 120; e += 20) {
        rk_vec3 scaled = rk_scale(sigma, ldexpf(1, -e));
        const rk_crossing block[] = {face(0.25f, 1, true, scaled), face(0.75f, 1, false, scaled)};
        check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, block, 2, ldexpf(1, e)),
                     rk_vec(expf(-0.5f), expf(-0.25f), 1), 4 * 0x1p-23f,
                     "thickness 2^e / 2 of glass that absorbs 2^-e per unit, e from -120 to 120");
    }
    for (float depth = 10; depth <= 80; depth += 10) {
        const rk_vec3 dark = {2 * depth, depth, 0};
        const rk_crossing block[] = {face(0.25f, 1, true, dark), face(0.75f, 1, false, dark)};
        double want = exp(-(double)depth);
        rk_vec3 got = rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, block, 2, 1);
        /* A rounding of the exponent, and two units in the last place of expf. */
        rk_check_near(got.x, want, want * ((double)depth * 0x1p-23 + 4 * 0x1p-24),
                      "exp(-%g): dark glass lets little light through, and not none",
                      (double)depth);
    }
}

static void several_blocks_of_a_medium_add_up(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {face(0.125f, 1, true, sigma), face(0.25f, 1, false, sigma),
                                     face(0.5f, 1, true, sigma), face(0.875f, 1, false, sigma)};
    check_thickness(crossings, 4, 2, 1, "an eighth and three eighths of 2");
}

static void a_start_inside_a_block_counts_from_the_start(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {face(0.25f, 1, false, sigma), face(0.5f, 1, true, sigma),
                                     face(0.75f, 1, false, sigma)};
    check_thickness(crossings, 1, 1, 0.25, "left without having been entered: the start is inside");
    check_thickness(crossings, 3, 1, 0.5, "from the start to 0.25, from 0.5 to 0.75");
    const rk_crossing near = face(0x1p-100f, 1, false, sigma);
    check_thickness(&near, 1, 0x1p100f, 1, "from the start to t = 2^-100 on a ray of 2^100 units");
    for (int e = 2; e <= 24; e++) { /* down to the next float */
        float gap = ldexpf(1, -e);
        const rk_crossing blocks[] = {face(0.5f, 1, false, sigma),
                                      face(0.5f + gap, 1, true, sigma)};
        check_thickness(blocks, 2, 1, 1 - (double)gap,
                        "however narrow the gap between two blocks, a ray that leaves before it "
                        "enters starts inside: only crossings at one t count together");
    }
}

static void a_light_inside_a_block_counts_up_to_the_light(void **state)
{
    (void)state;
    const rk_crossing crossings[] = {face(0.25f, 1, true, sigma), face(0.5f, 1, false, sigma),
                                     face(0.75f, 1, true, sigma)};
    check_thickness(crossings, 1, 1, 0.75, "entered and never left: the light is inside");
    check_thickness(crossings, 3, 1, 0.5, "from 0.25 to 0.5, from 0.75 to the light");
    check_thickness(crossings + 1, 2, 1, 0.75, "start and light in different blocks");
    const rk_crossing near = face(1 - 0x1p-24f, 1, true, sigma);
    check_thickness(&near, 1, 0x1p24f, 1, "from t = 1 - 2^-24 to the light on a ray of 2^24 units");
}

static void different_media_absorb_where_they_overlap(void **state)
{
    (void)state;
    const rk_vec3 other = {0, 2, 4};
    const rk_crossing crossings[] = {face(0.125f, 1, true, sigma), face(0.25f, 2, true, other),
                                     face(0.5f, 2, false, other), face(0.875f, 1, false, sigma)};
    /* Thickness 0.75 of the one, 0.25 of the other, inside it. */
    check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, crossings, 4, 1),
                 rk_vec(expf(-0.75f), expf(-0.375f - 0.5f), expf(-1.0f)), 4 * 0x1p-23f,
                 "each medium by its own pairs of crossings");
    /* Two media may absorb alike: their numbers tell them apart. */
    const rk_crossing alike[] = {face(0.125f, 1, true, sigma), face(0.25f, 2, true, sigma),
                                 face(0.5f, 2, false, sigma), face(0.875f, 1, false, sigma)};
    check_thickness(alike, 4, 1, 0.75 + 0.25, "two media with the same sigma each absorb");
}

static void a_medium_absorbs_once_where_its_blocks_overlap(void **state)
{
    (void)state;
    const rk_crossing overlapping[] = {face(0.125f, 1, true, sigma), face(0.25f, 1, true, sigma),
                                       face(0.5f, 1, false, sigma), face(0.75f, 1, false, sigma)};
    check_thickness(overlapping, 4, 1, 0.625, "glass in the same glass is one piece");
    check_thickness(overlapping + 2, 2, 1, 0.75, "the start is in both blocks");
    enum { half = RK_CROSSINGS_MAX / 2 };
    rk_crossing nested[RK_CROSSINGS_MAX];
    for (uint32_t k = 0; k < RK_CROSSINGS_MAX; k++)
        nested[k] = face(0.25f + (float)k / (2 * RK_CROSSINGS_MAX), 1, k < half, sigma);
    check_thickness(nested, RK_CROSSINGS_MAX, 1, (double)(RK_CROSSINGS_MAX - 1) / 512,
                    "128 blocks, each in the one before, are one piece");
    check_thickness(nested + half, half, 1, (double)(RK_CROSSINGS_MAX - 1) / 512 + 0.25,
                    "the start is in 128 blocks");
    check_thickness(nested, half, 1, 0.75, "the light is in 128 blocks");
    for (uint32_t k = 0; k < RK_CROSSINGS_MAX; k++)
        nested[k].entering = true;
    check_thickness(nested, RK_CROSSINGS_MAX, 1, 0.75, "the light is in 256 blocks");
    for (uint32_t k = 0; k < RK_CROSSINGS_MAX; k++)
        nested[k].entering = false;
    check_thickness(nested, RK_CROSSINGS_MAX, 1, (double)(RK_CROSSINGS_MAX - 1) / 512 + 0.25,
                    "the start is in 256 blocks");
}

static void touching_blocks_are_one_piece(void **state)
{
    (void)state;
    /* Faces at one t come in either order. */
    for (int swapped = 0; swapped < 2; swapped++) {
        const rk_crossing crossings[] = {face(0.25f, 1, true, sigma), face(0.5f, 1, swapped, sigma),
                                         face(0.5f, 1, !swapped, sigma),
                                         face(0.75f, 1, false, sigma)};
        check_thickness(crossings, 4, 1, 0.5, "no gap and no overlap where two blocks touch");
        check_thickness(crossings + 1, 3, 1, 0.75, "the start is in the first of them");
        check_thickness(crossings, 3, 1, 0.75, "the light is in the second of them");
    }
}

static void a_grazed_edge_absorbs_nothing(void **state)
{
    (void)state;
    const rk_crossing left_first[] = {face(0.5f, 1, false, sigma), face(0.5f, 1, true, sigma)};
    const rk_crossing entered_first[] = {face(0.5f, 1, true, sigma), face(0.5f, 1, false, sigma)};
    check_thickness(entered_first, 2, 1, 0, "no distance inside");
    check_thickness(left_first, 2, 1, 0,
                    "rounding may swap the faces at an edge: this does not put the start inside");
    const rk_vec3 dense = {3e38f, 1e30f, 1e20f};
    const float lengths[] = {0, 1e-30f, 1, 1e10f, 3e38f};
    for (int i = 0; i < 5; i++)
        for (int order = 0; order < 2; order++) {
            const rk_crossing grazed[] = {face(0.5f, 1, order, dense),
                                          face(0.5f, 1, !order, dense)};
            check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, grazed, 2, lengths[i]),
                         white, 0,
                         "a grazed block absorbs nothing, however dense it is and however long the "
                         "ray: no infinity times 0");
        }
    const rk_crossing block[] = {face(0.25f, 1, true, sigma), face(0.75f, 1, false, sigma)};
    check_thickness(block, 2, 1, 0.5, "a block that is crossed does absorb");
}

static void a_sheet_absorbs_along_its_whole_inner_side(void **state)
{
    (void)state;
    const rk_crossing front = face(0.25f, 1, true, sigma), back = face(0.25f, 1, false, sigma);
    check_thickness(&front, 1, 1, 0.75, "from outside: the whole distance behind the sheet");
    check_thickness(&back, 1, 1, 0.25, "from inside: the whole distance before it");
}

static void clear_glass_absorbs_nothing_and_dense_glass_all(void **state)
{
    (void)state;
    const rk_vec3 dense = {3e38f, 1e30f, 0};
    rk_crossing block[] = {face(0.25f, 1, true, dense), face(0.75f, 1, false, dense)};
    block[0].kd = block[1].kd = red;
    block[0].alpha = block[1].alpha = 0.5f;
    check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, block, 2, 1), rk_vec(0, 0, 1), 0,
                 "0 where all is absorbed, 1 where nothing is; kd and alpha do not matter");
    check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, block, 2, 3e38f), rk_vec(0, 0, 1),
                 0, "the same on the longest ray: sigma times thickness may overflow");
    check_colour(rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, block, 2, 0), white, 0,
                 "without a distance to the light there is nothing to absorb it");
}

/* Numbers of media and what they absorb: any uint32_t is a medium. */
static const uint32_t some_media[] = {
    0, 1, 256, 65536, 65537, UINT32_MAX, 65535, 1u << 24, (1u << 24) + 1, 1u << 31, 4000000000u};
enum { media_count = sizeof some_media / sizeof *some_media };

static rk_vec3 sigma_of(uint32_t medium)
{
    return random_colour(medium, 0, 21);
}

/* The ray in cells of equal length, with faces only between them: in each cell a medium is either
 * everywhere or nowhere. The optical depth of a ray of length 1. */
enum { ray_cells = 16 };

static void optical_depth(const rk_crossing *crossings, uint32_t count, double *depth)
{
    depth[0] = depth[1] = depth[2] = 0;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t medium = crossings[k].medium, earlier = 0;
        int blocks[ray_cells] = {0}, fewest = 0, inside = 0;
        for (uint32_t j = 0; j < k; j++)
            earlier += crossings[j].medium == medium;
        if (earlier > 0)
            continue;
        for (uint32_t j = 0; j < count; j++)
            for (int cell = 0; cell < ray_cells; cell++)
                if (crossings[j].medium == medium && (float)cell / ray_cells >= crossings[j].t)
                    blocks[cell] += crossings[j].entering ? 1 : -1;
        for (int cell = 0; cell < ray_cells; cell++)
            fewest = blocks[cell] < fewest ? blocks[cell] : fewest;
        for (int cell = 0; cell < ray_cells; cell++)
            inside += blocks[cell] > fewest;
        for (int axis = 0; axis < 3; axis++)
            depth[axis] += (double)rk_axis(sigma_of(medium), axis) * inside / ray_cells;
    }
}

/* A block in another one. */
static void check_two_media(uint32_t a, uint32_t b)
{
    const rk_crossing faces[] = {face(0.125f, a, true, sigma), face(0.25f, b, true, sigma),
                                 face(0.5f, b, false, sigma), face(0.875f, a, false, sigma)};
    char hint[160];
    snprintf(hint, sizeof hint,
             "a block of medium %u in a block of medium %u: two media, which absorb by 0.25 and by "
             "0.75 units; all 32 bits of their numbers tell them apart",
             b, a);
    check_thickness(faces, 4, 1, 0.25 + 0.75, hint);
}

/* Faces at random places, many at the same, of few media or of one for each. */
static void each_part_of_a_ray_absorbs_by_the_media_around_it(void **state)
{
    (void)state;
    for (int bit = 1; bit < 32; bit++) {
        check_two_media(1, 1 + (1u << bit));
        check_two_media(0, 1u << bit);
    }
    const rk_crossing left[] = {face(0.25f, 1, false, sigma), face(0.75f, 1, false, sigma)};
    check_thickness(left, 2, 1, 0.75,
                    "two faces are left, none is entered: a start in two blocks of a medium, of "
                    "which the longer reaches to 0.75");
    for (uint32_t trial = 0; trial < 1000; trial++) {
        bool is_long = trial % 100 == 99; /* after short ones, whose messages are easier to read */
        uint32_t count = is_long ? RK_CROSSINGS_MAX : 1 + rk_case(trial, 0, 24, 0) % 12;
        rk_crossing *crossings = malloc(count * sizeof *crossings), before[RK_CROSSINGS_MAX];
        rk_check(crossings != NULL, "no memory for %u crossings", count);
        memset(before, 0, sizeof before);
        for (uint32_t k = 0; k < count; k++) {
            uint32_t cell = is_long ? 1 + k * (ray_cells - 1) / count
                                    : 1 + rk_case(trial, k, 25, 0) % (ray_cells - 1);
            uint32_t medium =
                is_long ? 7 * (k % 200)
                        : some_media[rk_case(trial, k, 26, 0) % (1 + trial % media_count)];
            before[k] = face((float)cell / ray_cells, medium, rk_case(trial, k, 27, 0) % 2,
                             sigma_of(medium));
            before[k].kd = random_colour(trial, k, 28);
            before[k].alpha = rk_unit_float(rk_case(trial, k, 31, 0));
            before[k].primitive = k;
            for (uint32_t j = k; j > 0 && before[j].t < before[j - 1].t; j--) {
                rk_crossing swapped = before[j];
                before[j] = before[j - 1];
                before[j - 1] = swapped;
            }
        }
        memcpy(crossings, before, count * sizeof *crossings);
        const float length = is_long ? 0x1p-5f : 2;
        rk_vec3 got = rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, crossings, count, length);
        double depth[3];
        optical_depth(before, count, depth);
        /* Roundings of an optical depth d: one per crossing, each at most 2^-24 of d; they change
         * exp(-d) by d exp(-d) < 0.37 times as much. expf is off by two units in the last place. */
        double tolerance = (0.37 * (count + 4) + 4) * 0x1p-24;
        for (int axis = 0; axis < 3; axis++)
            rk_check_near(
                rk_axis(got, axis), exp(-depth[axis] * (double)length), tolerance,
                "trial %u, %u faces, the first of alpha %g, %s, many at one t: colour %d, exp "
                "of minus the sum of sigma times thickness, each medium by its own faces",
                trial, count, (double)before[0].alpha,
                is_long ? "of 200 media" : "of media from 0 to 4294967295", axis);
        for (uint32_t k = 0; k < count; k++)
            rk_check(is_same(&crossings[k], &before[k]), "crossing %u was changed", k);
        free(crossings);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(crossings_inserted_in_any_order_are_sorted_by_t),
    cmocka_unit_test(crossings_at_equal_t_are_sorted_by_primitive),
    cmocka_unit_test(crossings_at_neighbouring_t_are_all_kept),
    cmocka_unit_test(a_full_list_keeps_the_nearest),
    cmocka_unit_test(a_list_of_the_greatest_length_stays_in_its_memory),
    cmocka_unit_test(crossings_behind_an_opaque_one_are_dropped),
    cmocka_unit_test(the_largest_alpha_below_1_is_not_opaque),
    cmocka_unit_test(the_end_is_where_no_crossing_can_be_added),
    cmocka_unit_test(the_list_does_not_depend_on_the_order_of_insertion),
    cmocka_unit_test(one_surface_weighs_alpha_and_transmits_the_rest),
    cmocka_unit_test(weights_are_alpha_times_the_transmittance_before),
    cmocka_unit_test(nothing_is_seen_behind_an_opaque_surface),
    cmocka_unit_test(without_crossings_the_transmittance_is_1),
    cmocka_unit_test(weights_and_transmittance_sum_to_one),
    cmocka_unit_test(the_transmittance_is_a_product),
    cmocka_unit_test(max_depth_is_exact),
    cmocka_unit_test(multiplicative_is_the_product_of_colours_and_one_minus_alpha),
    cmocka_unit_test(a_black_channel_leaves_the_others),
    cmocka_unit_test(multiplicative_ignores_the_order),
    cmocka_unit_test(ordered_blends_one_pane_over_white),
    cmocka_unit_test(ordered_tells_red_then_yellow_from_yellow_then_red),
    cmocka_unit_test(ordered_equals_a_view_ray_towards_a_white_light),
    cmocka_unit_test(a_block_absorbs_by_its_thickness),
    cmocka_unit_test(several_blocks_of_a_medium_add_up),
    cmocka_unit_test(a_start_inside_a_block_counts_from_the_start),
    cmocka_unit_test(a_light_inside_a_block_counts_up_to_the_light),
    cmocka_unit_test(different_media_absorb_where_they_overlap),
    cmocka_unit_test(each_part_of_a_ray_absorbs_by_the_media_around_it),
    cmocka_unit_test(a_medium_absorbs_once_where_its_blocks_overlap),
    cmocka_unit_test(touching_blocks_are_one_piece),
    cmocka_unit_test(a_grazed_edge_absorbs_nothing),
    cmocka_unit_test(a_sheet_absorbs_along_its_whole_inner_side),
    cmocka_unit_test(clear_glass_absorbs_nothing_and_dense_glass_all),
    cmocka_unit_test(without_crossings_all_light_arrives),
    cmocka_unit_test(opaque_surfaces_transmit_no_light),
};

RK_SUITE("transparency", tests)
