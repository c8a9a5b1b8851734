/* Sobol' sequences: direction numbers, points, Owen scrambling, and the joint dimensions of a
 * pixel's samples. Evenness is counted, point by point. Randomness is tested with fixed seeds; all
 * statistics together would exceed their limits once in a million times (Bonferroni's correction:
 * each gets the same part of that millionth). */
#include "test.h"

#include "base/scramble.h"
#include "features/sampling.h"

enum { STATISTICS = 2000 }; /* at most so many in this suite: the chance for each is 5e-10 */
static const double z_limit = 6.11;  /* a normal deviate exceeds it with that chance */
static const double ks_limit = 3.33; /* sqrt(n) D: sqrt(ln(2 / 5e-10) / 2), Massart 1990 */

/* --- Points from direction numbers ------------------------------------------------------------ */

static uint32_t any_bits(uint32_t a, uint32_t b)
{
    return rk_hash(a, b, 77, 3);
}

static void fill_directions(uint32_t v[RK_SOBOL_DIGITS], uint32_t which)
{
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
        v[j] = any_bits(j, which);
}

static void point_0_is_at_0(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    for (uint32_t which = 0; which < 8; which++) {
        fill_directions(v, which);
        rk_check_equal(rk_sobol_bits(v, 0), 0, "no digit of 0 selects a direction number");
    }
}

static void a_power_of_two_selects_one_direction_number(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    for (uint32_t which = 0; which < 8; which++) {
        fill_directions(v, which);
        for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
            rk_check(rk_sobol_bits(v, UINT32_C(1) << j) == v[j],
                     "index 2^%u: got 0x%08x, want v[%u] = 0x%08x", j,
                     rk_sobol_bits(v, UINT32_C(1) << j), j, v[j]);
    }
}

static void the_digits_of_the_index_combine_by_xor(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    for (uint32_t k = 0; k < 1000; k++) {
        fill_directions(v, k);
        uint32_t a = any_bits(k, 100), b = any_bits(k, 101);
        uint32_t got = rk_sobol_bits(v, a ^ b), want = rk_sobol_bits(v, a) ^ rk_sobol_bits(v, b);
        rk_check(got == want,
                 "point %u xor %u: got 0x%08x, want 0x%08x: points combine as their "
                 "indices do",
                 a, b, got, want);
        want = v[0] ^ v[2] ^ v[3];
        rk_check(rk_sobol_bits(v, 13) == want,
                 "index 13 = 1101 in binary: got 0x%08x, want v[0] ^ "
                 "v[2] ^ v[3] = 0x%08x",
                 rk_sobol_bits(v, 13), want);
    }
}

static void halved_numbers_give_van_der_corputs_sequence(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
        v[j] = UINT32_C(0x80000000) >> j;
    const double want[8] = {0, 1. / 2, 1. / 4, 3. / 4, 1. / 8, 5. / 8, 3. / 8, 7. / 8};
    for (uint32_t i = 0; i < 8; i++)
        rk_check_near((double)rk_sobol_bits(v, i) * 0x1p-32, want[i], 0,
                      "direction numbers 1/2, 1/4, 1/8 and so on, point %u", i);
}

/* --- Direction numbers ------------------------------------------------------------------------ */

static void dimension_0_is_van_der_corputs(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    rk_sobol_directions(0, v);
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
        rk_check(v[j] == UINT32_C(0x80000000) >> j, "v[%u]: got 0x%08x, want 2^-%u = 0x%08x", j,
                 v[j], j + 1, UINT32_C(0x80000000) >> j);
}

static void the_given_numbers_come_first(void **state)
{
    (void)state;
    for (uint32_t d = 1; d < RK_SOBOL_DIMENSIONS; d++) {
        uint32_t v[RK_SOBOL_DIGITS];
        const rk_sobol_initial *p = &rk_sobol_initials[d];
        rk_sobol_directions(d, v);
        for (uint32_t j = 0; j < p->degree; j++)
            rk_check_near((double)v[j] * 0x1p-32, ldexp(p->m[j], -(int)j - 1), 0,
                          "dimension %u, v[%u] = m / 2^%u with m = %u", d, j, j + 1, p->m[j]);
    }
}

/* Of degree 1: m_j = 2 m_(j-1) xor m_(j-1), Pascal's triangle modulo 2. */
static void dimension_1_is_pascals_triangle(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    rk_sobol_directions(1, v);
    const uint32_t first[] = {1, 3, 5, 15, 17, 51, 85, 255, 257};
    for (uint32_t j = 0; j < sizeof first / sizeof *first; j++)
        rk_check_near((double)v[j] * 0x1p-32, ldexp(first[j], -(int)j - 1), 0, "v[%u]", j);
}

/* The same recurrence for the fractions, of which s digits are shifted out. */
static void further_numbers_follow_the_recurrence(void **state)
{
    (void)state;
    for (uint32_t d = 1; d < RK_SOBOL_DIMENSIONS; d++) {
        uint32_t v[RK_SOBOL_DIGITS];
        const rk_sobol_initial *p = &rk_sobol_initials[d];
        rk_sobol_directions(d, v);
        for (uint32_t j = p->degree; j < RK_SOBOL_DIGITS; j++) {
            uint32_t want = v[j - p->degree] ^ v[j - p->degree] >> p->degree;
            for (uint32_t bit = 0; bit + 1 < p->degree; bit++) /* the coefficient of x^(bit + 1) */
                want ^= p->inner >> bit & 1 ? v[j - (p->degree - 1 - bit)] : 0;
            rk_check(v[j] == want,
                     "dimension %u, v[%u]: got 0x%08x, want 0x%08x from the numbers "
                     "before it",
                     d, j, v[j], want);
        }
    }
}

static void the_table_holds_the_same_numbers(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
        uint32_t v[RK_SOBOL_DIGITS];
        rk_sobol_directions(d, v);
        for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
            rk_check(rk_reverse_bits(v[j]) == rk_sobol_columns[d][j],
                     "dimension %u, v[%u]: got 0x%08x, the table has 0x%08x, reversed", d, j, v[j],
                     rk_reverse_bits(rk_sobol_columns[d][j]));
    }
}

/* --- Evenness, counted ------------------------------------------------------------------------ */

enum { M_MAX = 10, POINTS = 1 << M_MAX };

typedef struct point_set {
    uint32_t count, dimensions;
    uint32_t bits[4][POINTS]; /* coordinates as fractions of 2^32 */
} point_set;

/* The most points in a cell of 2^-k_0 x 2^-k_1 x ..., over all shapes of cells with the volume of
 * 2^t / count: 2^t in each, if the quality is t. Depth first over the shapes. */
static uint32_t most_in_a_cell(const point_set *set, uint32_t dimension, uint32_t digits,
                               const uint32_t cells[POINTS])
{
    uint32_t most = 0, next[POINTS];
    bool last = dimension + 1 == set->dimensions;
    for (uint32_t here = last ? digits : 0; here <= digits; here++) {
        for (uint32_t i = 0; i < set->count; i++)
            next[i] = cells[i] << here | (here ? set->bits[dimension][i] >> (32 - here) : 0);
        uint32_t inside = 0;
        if (last) {
            uint32_t counts[POINTS] = {0};
            for (uint32_t i = 0; i < set->count; i++)
                inside = counts[next[i]]++ >= inside ? counts[next[i]] : inside;
        } else {
            inside = most_in_a_cell(set, dimension + 1, digits - here, next);
        }
        most = inside > most ? inside : most;
    }
    return most;
}

/* The quality t of 2^m points: every elementary interval of 2^t / 2^m has 2^t of them. */
static uint32_t quality(const point_set *set, uint32_t m)
{
    const uint32_t none[POINTS] = {0};
    for (uint32_t t = 0; t < m; t++)
        if (most_in_a_cell(set, 0, m - t, none) == 1u << t)
            return t;
    return m;
}

/* The quality of dimensions that pictures need together, as the search for the table found it. */
static const struct {
    const char *name;
    uint32_t count, dimensions[4], t[8]; /* of 2^1 to 2^8 points */
} together[] = {
    {"pixel", 2, {0, 1}, {0, 0, 0, 0, 0, 0, 0, 0}},
    {"lens", 2, {2, 3}, {0, 0, 1, 1, 1, 1, 1, 2}},
    {"light", 2, {5, 6}, {0, 0, 0, 0, 0, 1, 1, 1}},
    {"mirror", 2, {7, 8}, {0, 0, 0, 0, 1, 0, 0, 1}},
    {"pixel and time", 3, {0, 1, 4}, {0, 1, 2, 1, 2, 2, 1, 2}},
    {"lens and time", 3, {2, 3, 4}, {0, 1, 1, 2, 1, 2, 2, 2}},
    {"pixel and lens", 4, {0, 1, 2, 3}, {0, 1, 1, 2, 2, 3, 2, 2}},
    {"pixel and light", 4, {0, 1, 5, 6}, {0, 1, 1, 2, 2, 3, 2, 2}},
    {"lens and light", 4, {2, 3, 5, 6}, {0, 1, 2, 2, 2, 3, 3, 4}},
    {"pixel and mirror", 4, {0, 1, 7, 8}, {0, 1, 2, 1, 2, 2, 3, 3}},
};

enum { TOGETHER = sizeof together / sizeof *together };

static void every_elementary_interval_has_its_points(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < TOGETHER; k++)
        for (uint32_t m = 1; m <= 8; m++) {
            point_set set = {.count = 1u << m, .dimensions = together[k].count};
            for (uint32_t d = 0; d < set.dimensions; d++) {
                uint32_t v[RK_SOBOL_DIGITS];
                rk_sobol_directions(together[k].dimensions[d], v);
                for (uint32_t i = 0; i < set.count; i++)
                    set.bits[d][i] = rk_sobol_bits(v, i);
            }
            uint32_t t = quality(&set, m);
            rk_check(t == together[k].t[m - 1], "%s, 2^%u points: got the quality t = %u, want %u",
                     together[k].name, m, t, together[k].t[m - 1]);
        }
}

static void every_dimension_alone_is_stratified(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
        uint32_t v[RK_SOBOL_DIGITS];
        rk_sobol_directions(d, v);
        for (uint32_t m = 1; m <= M_MAX; m++) {
            bool seen[POINTS] = {false};
            for (uint32_t i = 0; i < 1u << m; i++) {
                uint32_t part = rk_sobol_bits(v, i) >> (32 - m);
                rk_check(!seen[part],
                         "dimension %u: of the first 2^%u points, point %u is a second "
                         "one in part %u of as many",
                         d, m, i, part);
                seen[part] = true;
            }
        }
    }
}

/* --- Owen scrambling -------------------------------------------------------------------------- */

static void the_first_digit_is_flipped_for_all_or_for_none(void **state)
{
    (void)state;
    bool flips = false, keeps = false;
    for (uint32_t key = 0; key < 64; key++) {
        uint32_t flip = rk_owen_scramble(0, key) >> 31;
        for (uint32_t i = 0; i < 64; i++) {
            uint32_t x = any_bits(i, key);
            rk_check((rk_owen_scramble(x, key) ^ x) >> 31 == flip,
                     "key %u: the first digit of 0x%08x is %sflipped, that of 0 is %sflipped", key,
                     x, flip ? "not " : "", flip ? "" : "not ");
        }
        flips |= flip == 1;
        keeps |= flip == 0;
    }
    rk_check(flips && keeps, "64 keys %s the first digit", flips ? "all flip" : "never flip");
}

static void a_digits_coin_depends_on_the_digits_before_it_alone(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 20000; k++) {
        uint32_t key = any_bits(k, 1), x = any_bits(k, 2), equal = k % 32;
        uint32_t rest = equal ? UINT32_MAX >> equal : UINT32_MAX;
        uint32_t y = (x & ~rest) | (any_bits(k, 3) & rest); /* the same first digits */
        uint32_t flips = (rk_owen_scramble(x, key) ^ x) ^ (rk_owen_scramble(y, key) ^ y);
        rk_check(flips >> (31 - equal) == 0,
                 "key 0x%08x: 0x%08x and 0x%08x have the same first %u digits, but of the first %u "
                 "not all are flipped alike",
                 key, x, y, equal, equal + 1);
    }
}

/* The coins of the 31 largest intervals, one bit per node of a tree: root 1, children 2n, 2n + 1.
 */
static void all_coins_are_fair_and_independent(void **state)
{
    (void)state;
    enum { draws = 1 << 14, levels = 5, nodes = 1 << levels };
    static int sums[nodes][nodes];
    for (uint32_t key = 0; key < draws; key++) {
        int coin[nodes];
        for (uint32_t node = 1; node < nodes; node++) {
            uint32_t depth = 0;
            while (node >> (depth + 1))
                depth++;
            uint32_t x = depth ? (node ^ 1u << depth) << (32 - depth) : 0;
            coin[node] = (rk_owen_scramble(x, key) ^ x) >> (31 - depth) & 1 ? 1 : -1;
        }
        for (int a = 1; a < nodes; a++)
            for (int b = 1; b <= a; b++)
                sums[a][b] += a == b ? coin[a] : coin[a] * coin[b];
    }
    for (int a = 1; a < nodes; a++)
        for (int b = 1; b <= a; b++)
            rk_check(
                abs(sums[a][b]) <= z_limit * sqrt(draws),
                "the coins of intervals %d and %d (one coin: heads and tails) agree %+d times more "
                "often than not in %d throws",
                a, b, sums[a][b], draws);
}

static void late_digits_are_scrambled_too(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 32; k++) {
        int flipped = 0;
        const int draws = 4096;
        for (uint32_t key = 0; key < (uint32_t)draws; key++) {
            uint32_t x = any_bits(key, k);
            flipped += (int)((rk_owen_scramble(x, any_bits(key, 5)) ^ x) >> (31 - k) & 1);
        }
        rk_check(fabs(flipped - 0.5 * draws) <= z_limit * sqrt(draws) / 2,
                 "digit %u is flipped in %d of %d cases, want about half", k + 1, flipped, draws);
    }
}

static void scrambling_keeps_every_elementary_interval(void **state)
{
    (void)state;
    for (uint32_t key = 0; key < 30; key++)
        for (uint32_t m = 1; m <= 8; m++) {
            point_set set = {.count = 1u << m, .dimensions = 2};
            for (uint32_t d = 0; d < 2; d++) {
                for (uint32_t i = 0; i < set.count; i++) {
                    uint32_t bits = 0; /* of the pixel's dimensions, from the table */
                    for (uint32_t j = 0; j < m; j++)
                        bits ^= i >> j & 1 ? rk_reverse_bits(rk_sobol_columns[d][j]) : 0;
                    set.bits[d][i] = rk_owen_scramble(bits, any_bits(key, d));
                }
            }
            bool scrambled = set.bits[0][0] != 0 && set.bits[1][0] != 0;
            rk_check(scrambled, "key %u: point 0 is still at 0", key);
            rk_check_equal(quality(&set, m), 0, "scrambled points are as even as before");
        }
}

/* --- Which dimensions are joint --------------------------------------------------------------- */

static const struct {
    const char *name;
    uint32_t dimension, count;
    int joint;
} decisions[] = {
    {"pixel", RK_DIMENSION_PIXEL, 2, 0},         {"lens", RK_DIMENSION_LENS, 2, 2},
    {"time", RK_DIMENSION_TIME, 1, 4},           {"first light", RK_DIMENSION_LIGHT, 2, 5},
    {"first mirror", RK_DIMENSION_GLOSSY, 2, 7},
};

enum { DECISIONS = sizeof decisions / sizeof *decisions };

static void each_decision_has_dimensions_of_its_own(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < DECISIONS; k++)
        rk_check(rk_joint_dimension(decisions[k].dimension) == decisions[k].joint,
                 "%s: got the joint dimension %d, want %d", decisions[k].name,
                 rk_joint_dimension(decisions[k].dimension), decisions[k].joint);
}

static void further_lights_bounces_and_passes_are_not_joint(void **state)
{
    (void)state;
    const uint32_t others[] = {RK_DIMENSION_LIGHT + 2,
                               RK_DIMENSION_LIGHT + 100,
                               RK_DIMENSION_GLOSSY + 2,
                               RK_DIMENSION_FEATURES,
                               RK_DIMENSION_FEATURES + 2,
                               RK_DIMENSION_FURTHER + RK_DIMENSION_PIXEL,
                               RK_DIMENSION_FURTHER + RK_DIMENSION_LIGHT};
    for (uint32_t k = 0; k < sizeof others / sizeof *others; k++)
        rk_check(rk_joint_dimension(others[k]) == -1, "dimension %u: got %d, want -1", others[k],
                 rk_joint_dimension(others[k]));
}

/* --- Joint numbers ---------------------------------------------------------------------------- */

static const rk_sampler joint = {RK_SAMPLER_SOBOL, 7, 64};

/* Coordinate k of a decision's sample. */
static float number(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t decision,
                    uint32_t k)
{
    if (decisions[decision].count == 1)
        return rk_joint_1d(sampler, pixel, sample, decisions[decision].dimension);
    rk_vec2 pair = rk_joint_2d(sampler, pixel, sample, decisions[decision].dimension);
    return k ? pair.y : pair.x;
}

/* Coordinate `d` of the nine. */
static float coordinate(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t d)
{
    uint32_t k = 0;
    while (k + 1 < DECISIONS && (uint32_t)decisions[k + 1].joint <= d)
        k++;
    return number(sampler, pixel, sample, k, d - (uint32_t)decisions[k].joint);
}

static void numbers_are_multiples_of_2_to_the_minus_24_below_one(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
        for (uint32_t i = 0; i < 3000; i++) {
            uint32_t sample = i % 2 ? i : RK_SAMPLES_MAX - 1 - i;
            float x = coordinate(&joint, i, sample, d);
            rk_check(x >= 0 && x < 1 && floorf(x * 0x1p24f) == x * 0x1p24f,
                     "pixel %u, sample %u, joint dimension %u: %.9g is not a multiple of 2^-24 in "
                     "[0, 1)",
                     i, sample, d, (double)x);
        }
}

static void every_samples_number_is_the_scrambled_point_of_its_index(void **state)
{
    (void)state;
    /* Of two samples the flips agree up to and with the first digit that differs in the sequence.
     */
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
        for (uint32_t k = 0; k < 2000; k++) {
            uint32_t a = any_bits(k, d) >> (8 + k % 24), b = any_bits(k, d + 9) >> (8 + k % 24);
            uint32_t xs[2] = {0, 0}, samples[2] = {a, b};
            uint32_t ys[2];
            for (int i = 0; i < 2; i++) {
                for (uint32_t j = 0; j < 24; j++)
                    xs[i] ^= samples[i] >> j & 1 ? rk_reverse_bits(rk_sobol_columns[d][j]) : 0;
                ys[i] = (uint32_t)(coordinate(&joint, k % 5, samples[i], d) * 0x1p24f) << 8;
            }
            uint32_t apart = xs[0] ^ xs[1], got = ys[0] ^ ys[1], digits = 0;
            while (digits < 24 && !(apart << digits >> 31))
                digits++;
            bool same = digits < 24 ? got >> (31 - digits) == 1 : got == 0;
            rk_check(same,
                     "joint dimension %u: samples %u and %u have numbers 0x%08x and 0x%08x, but "
                     "points 0x%08x and 0x%08x, which agree in %u digits",
                     d, a, b, ys[0], ys[1], xs[0], xs[1], digits);
        }
}

static void a_run_is_its_samples_one_by_one_in_any_order(void **state)
{
    (void)state;
    enum { n = 600 };
    static rk_vec2 run[n], before[n];
    for (uint32_t k = 0; k < DECISIONS; k++) {
        if (decisions[k].count == 1)
            continue;
        for (uint32_t i = n; i-- > 0;)
            before[i] = rk_joint_2d(&joint, 5, i, decisions[k].dimension);
        for (uint32_t first = 0, count; first < n; first += count) {
            count = first % 97 + 1 < n - first ? first % 97 + 1 : n - first;
            rk_joint_2d_run(&joint, 5, first, count, decisions[k].dimension, run + first);
        }
        for (uint32_t i = 0; i < n; i++)
            rk_check(run[i].x == before[i].x && run[i].y == before[i].y,
                     "%s: sample %u of the run "
                     "differs",
                     decisions[k].name, i);
    }
}

static void the_number_of_samples_changes_none_of_them(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
        for (uint32_t i = 0; i < 100; i++) {
            rk_sampler few = joint, many = joint;
            few.samples = i + 1;
            many.samples = 2 * (i + 1);
            rk_check(coordinate(&few, 3, i, d) == coordinate(&many, 3, i, d),
                     "joint dimension %u: sample %u of %u is another one of %u", d, i, i + 1,
                     2 * (i + 1));
        }
}

static void other_kinds_and_dimensions_are_as_before(void **state)
{
    (void)state;
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_SOBOL; kind++)
        for (uint32_t i = 0; i < 64; i++)
            for (uint32_t k = 0; k <= DECISIONS; k++) {
                rk_sampler sampler = joint;
                sampler.kind = (rk_sampler_kind)kind;
                uint32_t dimension =
                    k < DECISIONS ? decisions[k].dimension : RK_DIMENSION_LIGHT + 2;
                if (kind == RK_SAMPLER_SOBOL && k < DECISIONS)
                    continue;
                rk_vec2 got = rk_joint_2d(&sampler, 9, i, dimension);
                rk_vec2 want = rk_sample_2d(&sampler, 9, i, dimension);
                rk_check(got.x == want.x && got.y == want.y &&
                             rk_joint_1d(&sampler, 9, i, dimension) ==
                                 rk_sample_1d(&sampler, 9, i, dimension),
                         "kind %d, dimension %u, sample %u: want rk_sample_2d's numbers", kind,
                         dimension, i);
            }
}

static void fill_set(point_set *set, uint32_t k, uint32_t pixel, uint32_t first)
{
    for (uint32_t d = 0; d < set->dimensions; d++)
        for (uint32_t i = 0; i < set->count; i++)
            set->bits[d][i] =
                (uint32_t)(coordinate(&joint, pixel, first + i, together[k].dimensions[d]) *
                           0x1p24f)
                << 8;
}

static void a_pixels_samples_are_even_in_all_dimensions_together(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < TOGETHER; k++)
        for (uint32_t m = 1; m <= 7; m++)
            for (uint32_t pixel = 0; pixel < 3; pixel++) {
                point_set set = {.count = 1u << m, .dimensions = together[k].count};
                fill_set(&set, k, pixel * 1000 + m, 0);
                uint32_t t = quality(&set, m);
                rk_check(
                    t <= together[k].t[m - 1],
                    "%s, pixel %u, %u samples: got the quality t = %u, want %u: the dimensions "
                    "of one pixel share the sequence's index",
                    together[k].name, pixel * 1000 + m, set.count, t, together[k].t[m - 1]);
            }
}

/* Light sample j of pixel sample k has the index k L + j. */
static void aligned_blocks_are_as_even_as_the_first(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 4; k++)
        for (uint32_t m = 2; m <= 6; m++)
            for (uint32_t block = 1; block < 40; block += 3) {
                point_set set = {.count = 1u << m, .dimensions = 2};
                fill_set(&set, k, 11, block << m);
                uint32_t t = quality(&set, m);
                rk_check(t <= together[k].t[m - 1],
                         "%s, samples %u to %u: got the quality t = %u, "
                         "want %u",
                         together[k].name, block << m, ((block + 1) << m) - 1, t,
                         together[k].t[m - 1]);
            }
}

/* --- Randomness ------------------------------------------------------------------------------- */

enum { side = 16, draws = 1 << 14 };

/* Chi-squared as a normal deviate (Wilson and Hilferty, "The distribution of chi-square", 1931). */
static double deviate(const unsigned *counts, int cells, double number_of_draws)
{
    double want = number_of_draws / cells, chi = 0, f = cells - 1;
    for (int i = 0; i < cells; i++)
        chi += (counts[i] - want) * (counts[i] - want) / want;
    return (cbrt(chi / f) - (1 - 2 / (9 * f))) / sqrt(2 / (9 * f));
}

static int compare(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Kolmogorov's statistic of numbers that should be uniform, times sqrt(n); sorts them. */
static double kolmogorov(float *numbers, int n)
{
    double d = 0;
    qsort(numbers, (size_t)n, sizeof *numbers, compare);
    for (int i = 0; i < n; i++)
        d = fmax(
            d, fmax((double)numbers[i] - i / (double)n, (i + 1) / (double)n - (double)numbers[i]));
    return d * sqrt(n);
}

static void each_sample_is_uniform_over_pixels(void **state)
{
    (void)state;
    static float numbers[draws];
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
        for (uint32_t sample = 0; sample < 7; sample++) {
            unsigned counts[side * side] = {0};
            for (uint32_t pixel = 0; pixel < draws; pixel++) {
                numbers[pixel] = coordinate(&joint, pixel, sample, d);
                counts[(int)(numbers[pixel] * side * side)]++;
            }
            double z = deviate(counts, side * side, draws), ks = kolmogorov(numbers, draws);
            rk_check(z <= z_limit,
                     "joint dimension %u, sample %u: chi-squared is %.2f standard "
                     "deviations too large, limit %.2f",
                     d, sample, z, z_limit);
            rk_check(ks <= ks_limit,
                     "joint dimension %u, sample %u: Kolmogorov's statistic is %.2f, "
                     "limit %.2f",
                     d, sample, ks, ks_limit);
        }
}

static void check_unrelated(uint32_t d, uint32_t e, uint32_t sample, uint32_t pixels_on,
                            uint32_t seeds_on)
{
    unsigned counts[side * side] = {0};
    rk_sampler other = joint;
    other.seed += seeds_on;
    for (uint32_t pixel = 0; pixel < draws; pixel++) {
        float x = coordinate(&joint, pixel, sample, d);
        float y = coordinate(&other, pixel + pixels_on, sample, e);
        counts[(int)(y * side) * side + (int)(x * side)]++;
    }
    double z = deviate(counts, side * side, draws);
    rk_check(z <= z_limit,
             "sample %u in joint dimensions %u and %u, %u pixels and %u seeds on: related "
             "by %.2f standard deviations of chi-squared, limit %.2f",
             sample, d, e, pixels_on, seeds_on, z, z_limit);
}

static void dimensions_pixels_and_seeds_are_independent(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
        for (uint32_t sample = 0; sample < 3; sample++) {
            for (uint32_t e = 0; e < d; e++)
                check_unrelated(d, e, sample, 0, 0);
            check_unrelated(d, d, sample, 1, 0);
            check_unrelated(d, d, sample, 800, 0);
            check_unrelated(d, d, sample, 0, 1);
        }
}

/* Points 0 and 1 lie at 0 and 1/2, so their second digits are 0, and those of the numbers are two
 * coins: with a random xor in place of scrambling, they would be one. */
static void the_halves_of_a_dimension_have_coins_of_their_own(void **state)
{
    (void)state;
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
        int alike = 0;
        for (uint32_t pixel = 0; pixel < draws; pixel++) {
            int a = (int)(4 * coordinate(&joint, pixel, 0, d));
            int b = (int)(4 * coordinate(&joint, pixel, 1, d));
            alike += (a & 1) == (b & 1);
        }
        rk_check(
            fabs(alike - 0.5 * draws) <= z_limit * sqrt(draws) / 2,
            "joint dimension %u: the second digits of samples 0 and 1 agree in %d of %d pixels, "
            "want about half",
            d, alike, draws);
    }
}

/* The mean over many pixels of the means over n samples of f, whose integral is known. */
static void any_number_of_samples_is_unbiased(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 3, 5, 12, 17};
    for (uint32_t c = 0; c < 5; c++) {
        double sum = 0, squares = 0;
        const uint32_t n = counts[c], pixels = 4000;
        for (uint32_t pixel = 0; pixel < pixels; pixel++) {
            double mean = 0;
            for (uint32_t i = 0; i < n; i++) {
                float x = coordinate(&joint, pixel, i, 0), y = coordinate(&joint, pixel, i, 5);
                mean += (x + y < 0.8f) / (double)n; /* a triangle of 0.32 */
            }
            sum += mean;
            squares += mean * mean;
        }
        double mean = sum / pixels, error = sqrt((squares / pixels - mean * mean) / pixels);
        rk_check_near(mean, 0.32, z_limit * error, "mean of %u samples in %u pixels", n, pixels);
    }
}

/* --- Errors ----------------------------------------------------------------------------------- */

/* The variance of means of n samples of an edge that is blurred along x: a step in the sum of the
 * position in the pixel and, twice as wide, that on the lens, light or mirror. */
static double variance(rk_sampler_kind kind, uint32_t dimension, uint32_t n)
{
    const rk_sampler sampler = {kind, 3, n};
    const uint32_t pixels = 4000;
    double sum = 0, squares = 0;
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        uint32_t inside = 0;
        for (uint32_t i = 0; i < n; i++) {
            rk_vec2 a = rk_joint_2d(&sampler, pixel, i, RK_DIMENSION_PIXEL);
            rk_vec2 b = rk_joint_2d(&sampler, pixel, i, dimension);
            inside += a.x + 2 * b.x < 1.4f;
        }
        double mean = inside / (double)n;
        sum += mean;
        squares += mean * mean;
    }
    return squares / pixels - sum / pixels * (sum / pixels);
}

/* A relative standard error of a variance from 4000 means is 2.2 %, that of a ratio 3.2 %; so a
 * ratio of 1.5 is more than 6 of them above 1. */
static void joint_samples_have_smaller_errors_than_independent_pairs(void **state)
{
    (void)state;
    const uint32_t pairs[] = {RK_DIMENSION_LENS, RK_DIMENSION_LIGHT, RK_DIMENSION_GLOSSY};
    for (int k = 0; k < 3; k++) {
        double low = variance(RK_SAMPLER_LOW_DISCREPANCY, pairs[k], 64);
        double got = variance(RK_SAMPLER_SOBOL, pairs[k], 64);
        rk_check(got * 1.5 <= low,
                 "pixel and dimension %u, 64 samples of an edge: got the variance "
                 "%.3g, want at most 1/1.5 of that of independent pairs, %.3g",
                 pairs[k], got, low);
    }
}

static void errors_fall_faster_than_by_the_root_of_n(void **state)
{
    (void)state;
    double few = variance(RK_SAMPLER_SOBOL, RK_DIMENSION_LENS, 16);
    double many = variance(RK_SAMPLER_SOBOL, RK_DIMENSION_LENS, 256);
    double slope = log(many / few) / log(16) / 2;
    /* Independent pairs: -0.5. An edge in d dimensions that are even together: -(d + 1) / (2 d), so
     * -0.75 in two. The slope's standard error is 0.032 / (2 ln 16), 0.006. */
    rk_check(slope <= -0.6,
             "slope of the error from 16 to 256 samples: got %.3f, "
             "want about -0.75",
             slope);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(point_0_is_at_0),
    cmocka_unit_test(a_power_of_two_selects_one_direction_number),
    cmocka_unit_test(the_digits_of_the_index_combine_by_xor),
    cmocka_unit_test(halved_numbers_give_van_der_corputs_sequence),
    cmocka_unit_test(dimension_0_is_van_der_corputs),
    cmocka_unit_test(the_given_numbers_come_first),
    cmocka_unit_test(dimension_1_is_pascals_triangle),
    cmocka_unit_test(further_numbers_follow_the_recurrence),
    cmocka_unit_test(the_table_holds_the_same_numbers),
    cmocka_unit_test(every_dimension_alone_is_stratified),
    cmocka_unit_test(every_elementary_interval_has_its_points),
    cmocka_unit_test(the_first_digit_is_flipped_for_all_or_for_none),
    cmocka_unit_test(a_digits_coin_depends_on_the_digits_before_it_alone),
    cmocka_unit_test(all_coins_are_fair_and_independent),
    cmocka_unit_test(late_digits_are_scrambled_too),
    cmocka_unit_test(scrambling_keeps_every_elementary_interval),
    cmocka_unit_test(each_decision_has_dimensions_of_its_own),
    cmocka_unit_test(further_lights_bounces_and_passes_are_not_joint),
    cmocka_unit_test(numbers_are_multiples_of_2_to_the_minus_24_below_one),
    cmocka_unit_test(every_samples_number_is_the_scrambled_point_of_its_index),
    cmocka_unit_test(a_run_is_its_samples_one_by_one_in_any_order),
    cmocka_unit_test(the_number_of_samples_changes_none_of_them),
    cmocka_unit_test(other_kinds_and_dimensions_are_as_before),
    cmocka_unit_test(a_pixels_samples_are_even_in_all_dimensions_together),
    cmocka_unit_test(aligned_blocks_are_as_even_as_the_first),
    cmocka_unit_test(each_sample_is_uniform_over_pixels),
    cmocka_unit_test(dimensions_pixels_and_seeds_are_independent),
    cmocka_unit_test(the_halves_of_a_dimension_have_coins_of_their_own),
    cmocka_unit_test(any_number_of_samples_is_unbiased),
    cmocka_unit_test(joint_samples_have_smaller_errors_than_independent_pairs),
    cmocka_unit_test(errors_fall_faster_than_by_the_root_of_n),
};

RK_SUITE("sampling", tests)
