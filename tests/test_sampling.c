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
    return rk_case(a, b, 77, 3);
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

/* The xor of the numbers that an index selects. */
static uint32_t selected(const uint32_t *v, uint32_t index)
{
    uint32_t bits = 0;
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
        bits ^= index >> j & 1 ? v[j] : 0;
    return bits;
}

static const char *mistake_of_point(const uint32_t *v, uint32_t index, uint32_t got)
{
    if (got == selected(v, rk_reverse_bits(index)))
        return RK_EXAMPLE_IF "the index's digits are read from the highest one";
    if (got == selected(v, index ^ index >> 1))
        return RK_EXAMPLE_IF "the index's Gray code selects the numbers: that is another "
                             "order of the points";
    if (got == selected(v, ~index))
        return RK_EXAMPLE_IF "the digits that are 0 select the numbers";
    if (got == selected(v, index + 1) || got == selected(v, index - 1))
        return "; it is the point of the index beside it";
    return got == rk_reverse_bits(selected(v, index)) ? "; its digits are in reversed order" : "";
}

static void a_power_of_two_selects_one_direction_number(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    for (uint32_t which = 0; which < 8; which++) {
        fill_directions(v, which);
        for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
            rk_check(rk_sobol_bits(v, UINT32_C(1) << j) == v[j],
                     "index 2^%u: got 0x%08x, want v[%u] = 0x%08x%s", j,
                     rk_sobol_bits(v, UINT32_C(1) << j), j, v[j],
                     mistake_of_point(v, UINT32_C(1) << j, rk_sobol_bits(v, UINT32_C(1) << j)));
    }
}

static void the_digits_of_the_index_combine_by_xor(void **state)
{
    (void)state;
    uint32_t v[RK_SOBOL_DIGITS];
    fill_directions(v, 1);
    rk_sobol_bits(rk_read_only(v, sizeof v, "direction numbers"), 3);
    rk_read_only_free();
    for (uint32_t k = 0; k < 1000; k++) {
        fill_directions(v, k);
        uint32_t a = any_bits(k, 100), b = any_bits(k, 101);
        uint32_t got = rk_sobol_bits(v, a ^ b);
        uint32_t want = v[0] ^ v[2] ^ v[3];
        rk_check(rk_sobol_bits(v, 13) == want,
                 "index 13 = 1101 in binary: got 0x%08x, want v[0] ^ "
                 "v[2] ^ v[3] = 0x%08x%s",
                 rk_sobol_bits(v, 13), want,
                 rk_mistake_in_whole(
                     rk_sobol_bits(v, 13), want,
                     RK_MISTAKES({v[0] + v[2] + v[3], "the numbers are added"},
                                 {v[0] | v[2] | v[3], "the numbers are combined by |, not ^"})));
        want = rk_sobol_bits(v, a) ^ rk_sobol_bits(v, b);
        rk_check(got == want,
                 "point %u xor %u: got 0x%08x, want 0x%08x: points combine as their "
                 "indices do",
                 a, b, got, want);
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
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++) {
        uint32_t want = UINT32_C(0x80000000) >> j;
        rk_check(v[j] == want, "v[%u]: got 0x%08x, want 2^-%u = 0x%08x%s", j, v[j], j + 1, want,
                 rk_mistake_in_whole(
                     v[j], want,
                     RK_MISTAKES({2.0 * want, "v[j] is m / 2^j, one digit too far"},
                                 {1, "v[j] is m itself, not the fraction m / 2^(j + 1) of 2^32"})));
    }
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
    const double by_hand[] = {1 / 2., 3 / 4., 1 / 8., 5 / 16., 31 / 32.}; /* see the chapter */
    uint32_t third[RK_SOBOL_DIGITS];
    rk_sobol_directions(3, third);
    for (uint32_t j = 0; j < 5; j++)
        rk_check_near((double)third[j] * 0x1p-32, by_hand[j], 0,
                      "dimension 3, x^3 + x + 1, after m = 1, 3, 1: v[%u]", j);
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

/* Two keys that differ in one bit toss coins of their own. */
static void check_owen_keys(void)
{
    for (uint32_t bit = 0; bit < 32; bit++) {
        const int throws = 256 * 32;
        int alike = 0;
        for (uint32_t k = 0; k < 256; k++) {
            uint32_t x = any_bits(k, 6), key = any_bits(k, 7);
            uint32_t apart = rk_owen_scramble(x, key) ^ rk_owen_scramble(x, key ^ 1u << bit);
            for (uint32_t digit = 0; digit < 32; digit++)
                alike += !(apart >> digit & 1);
        }
        rk_check(
            abs(2 * alike - throws) <= z_limit * sqrt(throws),
            "two keys that differ in bit %u toss the same coin for %d of %d digits, want about "
            "half: does the whole key enter the hash, and is the coin one of its upper 16 bits?",
            bit, alike, throws);
    }
}

/* The node of a tree is the digits before, behind a 1. */
static void name_digit(int node, char text[40])
{
    char digits[32] = "";
    int count = 0;
    while (node >> (count + 1))
        count++;
    for (int k = 0; k < count; k++)
        digits[k] = node >> (count - 1 - k) & 1 ? '1' : '0';
    snprintf(text, 40, count ? "after %s" : "before all others", digits);
}

static bool is_zeros_alone(int node)
{
    return (node & (node - 1)) == 0;
}

/* The coins of the 31 largest intervals, one bit per node of a tree: root 1, children 2n, 2n + 1.
 */
static void all_coins_are_fair_and_independent(void **state)
{
    (void)state;
    enum { draws = 1 << 12, levels = 5, nodes = 1 << levels };
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
        for (int b = 1; b <= a; b++) {
            char behind_a[40], behind_b[40];
            name_digit(a, behind_a);
            name_digit(b, behind_b);
            rk_check(abs(sums[a][a]) <= z_limit * sqrt(draws),
                     "the coin of the digit %s: heads %+d times more often than tails in %d throws",
                     behind_a, sums[a][a], draws);
            rk_check(abs(sums[a][b]) <= z_limit * sqrt(draws) || a == b,
                     "the coins of the digit %s and of the digit %s agree in %d of %d throws, want "
                     "about half%s",
                     behind_a, behind_b, (draws + sums[a][b]) / 2, draws,
                     abs(sums[a][b]) < draws ? ""
                     : is_zeros_alone(a) && is_zeros_alone(b)
                         ? ": they are one coin; does the hash see how many digits came before? 0 "
                           "and 00 are the same number"
                         : ": they are one coin; does the hash see all digits before?");
        }
    check_owen_keys();
}

/* A digit's coin is another one where the digit before it differs, down to the last. */
static void check_neighbouring_digits(void)
{
    for (uint32_t k = 1; k < 32; k++) {
        int alike = 0;
        const int draws = 256;
        for (uint32_t i = 0; i < (uint32_t)draws; i++) {
            uint32_t x = any_bits(i, k), key = any_bits(i, 5), y = x ^ 1u << (32 - k);
            uint32_t flips = rk_owen_scramble(x, key) ^ x ^ rk_owen_scramble(y, key) ^ y;
            alike += !(flips >> (31 - k) & 1);
        }
        rk_check(fabs(alike - 0.5 * draws) <= z_limit * sqrt(draws) / 2,
                 "digit %u: two numbers that differ in digit %u toss the same coin for it in %d of "
                 "%d cases, want about half: does the hash see all digits before?",
                 k + 1, k, alike, draws);
    }
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
    check_neighbouring_digits();
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

static const rk_sampler joint = {RK_SAMPLER_SOBOL, 7, 64, 128};

/* What counts are indexed by. */
static float below_one(float x)
{
    rk_check(x >= 0 && x < 1, "got the number %.9g, want one in [0, 1)", (double)x);
    return x;
}

/* Coordinate k of a decision's sample. */
static float number(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t decision,
                    uint32_t k)
{
    if (decisions[decision].count == 1)
        return below_one(rk_joint_1d(sampler, pixel, sample, decisions[decision].dimension));
    rk_vec2 pair = rk_joint_2d(sampler, pixel, sample, decisions[decision].dimension);
    return below_one(k ? pair.y : pair.x);
}

/* Coordinate `d` of the nine. */
static float coordinate(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t d)
{
    uint32_t k = 0;
    while (k + 1 < DECISIONS && (uint32_t)decisions[k + 1].joint <= d)
        k++;
    return number(sampler, pixel, sample, k, d - (uint32_t)decisions[k].joint);
}

/* All nine, by a call for each decision. */
static void find_all(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                     float x[RK_SOBOL_DIMENSIONS])
{
    for (uint32_t k = 0; k < DECISIONS; k++) {
        float *of_decision = x + decisions[k].joint;
        if (decisions[k].count == 1) {
            *of_decision = number(sampler, pixel, sample, k, 0);
        } else {
            rk_vec2 pair = rk_joint_2d(sampler, pixel, sample, decisions[k].dimension);
            of_decision[0] = below_one(pair.x);
            of_decision[1] = below_one(pair.y);
        }
    }
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

/* What pairs of samples have in common: in dimension 0, samples that differ by 2^20 have points of
 * equal first 20 digits; in all dimensions, those that differ by 1 have points that differ in the
 * first digit alone. By chance, 64 pairs never have it. */
static const char *mistake_of_numbers(void)
{
    bool not_reversed = true, last_first = true;
    for (uint32_t i = 0; i < 64; i++) {
        uint32_t bits = (uint32_t)(coordinate(&joint, 0, i, 0) * 0x1p24f);
        uint32_t far = (uint32_t)(coordinate(&joint, 0, i ^ 1u << 20, 0) * 0x1p24f);
        uint32_t beside = (uint32_t)(coordinate(&joint, 0, i ^ 1, 0) * 0x1p24f);
        not_reversed &= ((bits ^ far) & 0xfff) == 0;
        last_first &= (bits ^ beside) == 1u << 23;
    }
    if (last_first)
        return RK_EXAMPLE_IF "a number is scrambled from its last digit on: is it reversed "
                             "before?";
    return not_reversed ? RK_EXAMPLE_IF "the bits are not reversed back after scrambling" : "";
}

/* Of two samples the flips agree up to and with the first digit that differs in the sequence. */
static void check_scrambled(uint32_t d, const uint32_t samples[2], const float numbers[2])
{
    uint32_t xs[2] = {0, 0}, ys[2];
    for (int i = 0; i < 2; i++) {
        for (uint32_t j = 0; j < 24; j++)
            xs[i] ^= samples[i] >> j & 1 ? rk_reverse_bits(rk_sobol_columns[d][j]) : 0;
        ys[i] = (uint32_t)(numbers[i] * 0x1p24f) << 8;
    }
    uint32_t apart = xs[0] ^ xs[1], got = ys[0] ^ ys[1], digits = 0;
    while (digits < 24 && !(apart << digits >> 31))
        digits++;
    bool same = digits < 24 ? got >> (31 - digits) == 1 : got == 0;
    rk_check(same,
             "joint dimension %u: samples %u and %u have numbers 0x%08x and 0x%08x, but "
             "points 0x%08x and 0x%08x, which agree in the first %u digits: as "
             "many as the numbers must%s",
             d, samples[0], samples[1], ys[0], ys[1], xs[0], xs[1], digits, mistake_of_numbers());
}

static void every_samples_number_is_the_scrambled_point_of_its_index(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 720; k++) /* 30 times each number of digits */
        for (uint32_t i = 0; i < DECISIONS; i++) {
            const uint32_t d = (uint32_t)decisions[i].joint;
            uint32_t samples[2];
            float numbers[2][2];
            for (uint32_t n = 0; n < 2; n++) {
                samples[n] = any_bits(k, d + 9 * n) >> (8 + k % 24);
                if (decisions[i].count == 1) {
                    numbers[0][n] = rk_joint_1d(&joint, k % 5, samples[n], decisions[i].dimension);
                } else {
                    rk_vec2 pair = rk_joint_2d(&joint, k % 5, samples[n], decisions[i].dimension);
                    numbers[0][n] = pair.x;
                    numbers[1][n] = pair.y;
                }
            }
            for (uint32_t c = 0; c < decisions[i].count; c++)
                check_scrambled(d + c, samples, numbers[c]);
        }
}

/* Runs of up to 97 pairs and of all but the first, and one of none before each: they write their
 * own pairs and no other. */
static void check_runs(const rk_sampler *sampler, uint32_t pixel, uint32_t n, uint32_t dimension)
{
    enum { most = 600 };
    static rk_vec2 run[most + 1], before[most], whole[most];
    for (uint32_t i = n; i-- > 0;)
        before[i] = rk_joint_2d(sampler, pixel, i, dimension);
    for (uint32_t i = 0; i <= n; i++)
        run[i] = (rk_vec2){-1, -1};
    for (uint32_t first = 0, count; first < n; first += count) {
        count = first % 97 + 1 < n - first ? first % 97 + 1 : n - first;
        for (uint32_t pairs = 0; pairs <= count; pairs += count) {
            rk_joint_2d_run(sampler, pixel, first, pairs, dimension, run + first);
            rk_check(
                run[first + pairs].x == -1 && run[first + pairs].y == -1,
                "dimension %u: a run of %u pair%s, from sample %u on, wrote another one behind "
                "them",
                dimension, pairs, pairs == 1 ? "" : "s", first);
        }
    }
    rk_joint_2d_run(sampler, pixel, 1, n - 1, dimension, whole);
    for (uint32_t i = 0; i < n; i++)
        rk_check(run[i].x == before[i].x && run[i].y == before[i].y,
                 "dimension %u: sample %u of the run differs", dimension, i);
    for (uint32_t i = 1; i < n; i++)
        rk_check(whole[i - 1].x == before[i].x && whole[i - 1].y == before[i].y,
                 "dimension %u: sample %u of a run of %u from 1 on differs", dimension, i, n - 1);
}

/* From the sample before a power of two to that after it all digits change. */
static void check_runs_over_powers(const rk_sampler *own, uint32_t pixel, uint32_t dimension)
{
    enum { powers = 23 };
    rk_sampler sampler = *own;
    sampler.samples = RK_SAMPLES_MAX;
    rk_vec2 run[powers][3], want[powers][3];
    for (uint32_t k = 1; k < powers; k++) {
        for (uint32_t i = 0; i < 3; i++)
            want[k][i] = rk_joint_2d(&sampler, pixel, (1u << k) - 1 + i, dimension);
        rk_joint_2d_run(&sampler, pixel, (1u << k) - 1, 3, dimension, run[k]);
    }
    for (uint32_t k = 1; k < powers; k++)
        for (uint32_t i = 0; i < 3; i++)
            rk_check(run[k][i].x == want[k][i].x && run[k][i].y == want[k][i].y,
                     "dimension %u: sample %u of a run of 3 from 2^%u - 1 on differs", dimension,
                     (1u << k) - 1 + i, k);
}

static void check_constant_sampler(const rk_sampler *own)
{
    const rk_sampler *sampler = rk_read_only(own, sizeof *own, "sampler");
    rk_vec2 pairs[4];
    rk_joint_1d(sampler, 5, 1, RK_DIMENSION_TIME);
    rk_joint_2d(sampler, 5, 1, RK_DIMENSION_LENS);
    rk_joint_2d_run(sampler, 5, 0, 4, RK_DIMENSION_LENS, pairs);
    rk_read_only_free();
}

static void a_run_is_its_samples_one_by_one_in_any_order(void **state)
{
    (void)state;
    check_constant_sampler(&joint);
    for (uint32_t k = 0; k < DECISIONS; k++)
        if (decisions[k].count == 2) {
            check_runs(&joint, 5, 600, decisions[k].dimension);
            check_runs_over_powers(&joint, 5, decisions[k].dimension);
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
                float got_one = rk_joint_1d(&sampler, 9, i, dimension);
                rk_check(got.x == want.x && got.y == want.y &&
                             got_one == rk_sample_1d(&sampler, 9, i, dimension),
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

/* Kolmogorov's statistic of numbers that should be uniform, times sqrt(n): the largest one at
 * multiples of 1/n, elsewhere it is at most 1/sqrt(n) more. */
static double kolmogorov(const float *numbers, int n)
{
    static int in_part[draws + 1];
    memset(in_part, 0, sizeof in_part);
    for (int i = 0; i < n; i++)
        in_part[(int)(numbers[i] * (float)n)]++;
    int most = 0;
    for (int i = 0, below = 0; i < n; i++) {
        below += in_part[i];
        most = abs(below - (i + 1)) > most ? abs(below - (i + 1)) : most;
    }
    return most / sqrt(n);
}

/* Of many pixels a sample's numbers in each dimension. */
enum { far_on = 800 };
typedef float sample_numbers[RK_SOBOL_DIMENSIONS][draws + far_on];

static void fill_numbers(sample_numbers numbers, uint32_t count, const rk_sampler *sampler,
                         uint32_t sample)
{
    for (uint32_t pixel = 0; pixel < count; pixel++) {
        float x[RK_SOBOL_DIMENSIONS];
        find_all(sampler, pixel, sample, x);
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
            numbers[d][pixel] = x[d];
    }
}

static void each_sample_is_uniform_over_pixels(void **state)
{
    (void)state;
    static sample_numbers numbers;
    for (uint32_t sample = 0; sample < 7; sample++) {
        fill_numbers(numbers, draws, &joint, sample);
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
            unsigned counts[side * side] = {0};
            for (uint32_t pixel = 0; pixel < draws; pixel++)
                counts[(int)(numbers[d][pixel] * side * side)]++;
            double z = deviate(counts, side * side, draws), ks = kolmogorov(numbers[d], draws);
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
}

static void check_unrelated(const float *xs, const float *ys, uint32_t d, uint32_t e,
                            uint32_t sample, uint32_t pixels_on, uint32_t seeds_on)
{
    unsigned counts[side * side] = {0}, equal = 0;
    for (uint32_t i = 0; i < draws; i++) {
        float x = xs[i], y = ys[i + pixels_on];
        counts[(int)(y * side) * side + (int)(x * side)]++;
        equal += x == y;
    }
    rk_check(
        equal < draws / 4,
        "sample %u in joint dimensions %u and %u, %u pixels and %u seeds on: the same number in "
        "%u of %d pixels: %s",
        sample, d, e, pixels_on, seeds_on, equal, draws,
        equal < draws     ? "do the keys depend on all bits?"
        : d != e          ? "is the dimension in the key?"
        : pixels_on != 0u ? "is the pixel in the key?"
                          : "is the seed in the key?");
    double z = deviate(counts, side * side, draws);
    rk_check(
        z <= z_limit,
        "sample %u in joint dimensions %u and %u, %u pixels and %u seeds on: related "
        "by %.2f standard deviations of chi-squared, limit %.2f; does the key depend on all of "
        "them? Hash it once more, rk_hash(key, 0, 0, 0), which separates related keys",
        sample, d, e, pixels_on, seeds_on, z, z_limit);
}

/* Whose two first numbers these are. Those of two owners agree by chance once in 2^47 times. */
typedef struct owner {
    uint64_t numbers;
    uint32_t seed, pixel, dimension;
} owner;

enum { SEEDS = 8, PIXELS = 16, OWNERS = (SEEDS * PIXELS + 64) * RK_SOBOL_DIMENSIONS };

static int compare_owners(const void *a, const void *b)
{
    uint64_t x = ((const owner *)a)->numbers, y = ((const owner *)b)->numbers;
    return (x > y) - (x < y);
}

/* Sample 1 is that of another pixel, where pixels share their sequence. */
static int add_owners(owner *owners, const rk_sampler *sampler, uint32_t pixel, uint32_t other)
{
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
        float first = coordinate(sampler, pixel, 0, d), second = coordinate(sampler, other, 1, d);
        uint64_t numbers = (uint64_t)(first * 0x1p24f) << 24 | (uint64_t)(second * 0x1p24f);
        owners[d] = (owner){numbers, sampler->seed, pixel, d};
    }
    return RK_SOBOL_DIMENSIONS;
}

static void check_all_differ(owner *owners, int count)
{
    qsort(owners, (size_t)count, sizeof *owners, compare_owners);
    for (int i = 1; i < count; i++) {
        const owner *a = &owners[i - 1], *b = &owners[i];
        rk_check(a->numbers != b->numbers,
                 "seed %u, pixel %u, joint dimension %u has the same numbers as seed %u, pixel %u, "
                 "joint dimension %u: each of the three enters the key whole and by itself, not as "
                 "a sum or an xor "
                 "with another",
                 a->seed, a->pixel, a->dimension, b->seed, b->pixel, b->dimension);
    }
}

/* All seeds with all pixels and dimensions, then a seed or a pixel that differs in one high bit. */
static void check_owners(void)
{
    static owner owners[OWNERS];
    int count = 0;
    rk_sampler sampler = joint;
    for (sampler.seed = 0; sampler.seed < SEEDS; sampler.seed++)
        for (uint32_t pixel = 0; pixel < PIXELS; pixel++)
            count += add_owners(owners + count, &sampler, pixel, pixel);
    check_all_differ(owners, count);
    for (uint32_t bit = 4; bit < 32; bit++) {
        sampler.seed = joint.seed ^ 1u << bit;
        count += add_owners(owners + count, &sampler, 5, 5);
        count += add_owners(owners + count, &joint, 5 ^ 1u << bit, 5 ^ 1u << bit);
    }
    check_all_differ(owners, count);
}

static void dimensions_pixels_and_seeds_are_independent(void **state)
{
    (void)state;
    static sample_numbers here, by_next_seed;
    rk_sampler next = joint;
    next.seed++;
    for (uint32_t sample = 0; sample < 3; sample++) {
        fill_numbers(here, draws + far_on, &joint, sample);
        fill_numbers(by_next_seed, draws, &next, sample);
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
            for (uint32_t e = 0; e < d; e++)
                check_unrelated(here[d], here[e], d, e, sample, 0, 0);
            check_unrelated(here[d], here[d], d, d, sample, 1, 0);
            check_unrelated(here[d], here[d], d, d, sample, far_on, 0);
            check_unrelated(here[d], by_next_seed[d], d, d, sample, 0, 1);
        }
    }
    check_owners();
}

/* Points 0 and 1 lie at 0 and 1/2, so their second digits are 0, and those of the numbers are two
 * coins: with a random xor in place of scrambling, they would be one. */
static void the_halves_of_a_dimension_have_coins_of_their_own(void **state)
{
    (void)state;
    static sample_numbers first, second;
    fill_numbers(first, draws, &joint, 0);
    fill_numbers(second, draws, &joint, 1);
    for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++) {
        int alike = 0;
        for (uint32_t pixel = 0; pixel < draws; pixel++)
            alike += ((int)(4 * first[d][pixel]) & 1) == ((int)(4 * second[d][pixel]) & 1);
        rk_check(
            fabs(alike - 0.5 * draws) <= z_limit * sqrt(draws) / 2,
            "joint dimension %u: the second digits of samples 0 and 1 agree in %d of %d pixels, "
            "want about half",
            d, alike, draws);
    }
}

/* The mean over many pixels of the means over the first n samples of f, whose integral is known. */
static void any_number_of_samples_is_unbiased(void **state)
{
    (void)state;
    enum { number_of_counts = 5 };
    const uint32_t counts[number_of_counts] = {1, 3, 5, 12, 17}, pixels_seen = 4000;
    double sums[number_of_counts] = {0}, squares[number_of_counts] = {0};
    for (uint32_t pixel = 0; pixel < pixels_seen; pixel++)
        for (uint32_t i = 0, c = 0, inside = 0; c < number_of_counts; i++) {
            float x = coordinate(&joint, pixel, i, 0), y = coordinate(&joint, pixel, i, 5);
            inside += x + y < 0.8f; /* a triangle of 0.32 */
            if (i + 1 == counts[c]) {
                double mean = inside / (double)counts[c];
                sums[c] += mean;
                squares[c++] += mean * mean;
            }
        }
    for (uint32_t c = 0; c < number_of_counts; c++) {
        double mean = sums[c] / pixels_seen;
        double error = sqrt((squares[c] / pixels_seen - mean * mean) / pixels_seen);
        rk_check_near(mean, 0.32, z_limit * error, "mean of %u samples in %u pixels", counts[c],
                      pixels_seen);
    }
}

/* --- Errors ----------------------------------------------------------------------------------- */

enum { RUN_MAX = 256 }; /* samples */

/* The variance of means of n samples of an edge that is blurred along x: a step in the sum of the
 * position in the pixel and, twice as wide, that on the lens, light or mirror. */
static double variance(rk_sampler_kind kind, uint32_t dimension, uint32_t n)
{
    const rk_sampler sampler = {kind, 3, n, 64};
    const uint32_t pixels = 4000;
    /* The unit passes other kinds on, by a claim of its own. */
    void (*find_run)(const rk_sampler *, uint32_t, uint32_t, uint32_t, uint32_t, rk_vec2 *) =
        kind == RK_SAMPLER_SOBOL ? rk_joint_2d_run : rk_sample_2d_run;
    double sum = 0, squares = 0;
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        uint32_t inside = 0;
        rk_vec2 a[RUN_MAX], b[RUN_MAX];
        find_run(&sampler, pixel, 0, n, RK_DIMENSION_PIXEL, a);
        find_run(&sampler, pixel, 0, n, dimension, b);
        for (uint32_t i = 0; i < n; i++)
            inside += a[i].x + 2 * b[i].x < 1.4f;
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

/* --- Z order ---------------------------------------------------------------------------------- */

static const char *mistake_of_order(void)
{
    bool exchanged = true, along_rows = true, beside = true;
    for (uint32_t k = 1; k < 256; k++) {
        uint32_t x = k % 16, y = k / 16, alternating = 0;
        for (uint32_t j = 0; j < 4; j++)
            alternating |= (y >> j & 1) << 2 * j | (x >> j & 1) << (2 * j + 1);
        exchanged &= rk_morton_index(x, y) == alternating;
        along_rows &= rk_morton_index(x, 0) == x;
        beside &= rk_morton_index(0, y) == y << 16;
    }
    if (exchanged)
        return RK_EXAMPLE_IF "the digits of y come first, at even places: x and y are "
                             "exchanged";
    if (along_rows)
        return RK_EXAMPLE_IF "pixels follow one another along a row, as in memory";
    if (beside)
        return RK_EXAMPLE_IF "the digits of y stand beside those of x, and do not alternate";
    return "";
}

static void the_first_16_pixels_are_in_z_order(void **state)
{
    (void)state;
    const uint32_t want[4][4] = {{0, 1, 4, 5}, {2, 3, 6, 7}, {8, 9, 12, 13}, {10, 11, 14, 15}};
    for (uint32_t y = 0; y < 4; y++)
        for (uint32_t x = 0; x < 4; x++)
            rk_check(rk_morton_index(x, y) == want[y][x],
                     "pixel (%u, %u): got %u, want %u: the digits of x at even places, those of y "
                     "at odd ones%s",
                     x, y, rk_morton_index(x, y), want[y][x], mistake_of_order());
}

static void digits_of_x_and_y_alternate(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 3000; k++) {
        uint32_t x = any_bits(k, 20) >> (16 + k % 16), y = any_bits(k, 21) >> (16 + k % 16);
        uint32_t got = rk_morton_index(x, y), from_x = 0, from_y = 0;
        for (uint32_t digit = 32; digit-- > 0;) {
            uint32_t *to = digit % 2 ? &from_y : &from_x;
            *to = *to << 1 | (got >> digit & 1);
        }
        rk_check(from_x == x && from_y == y,
                 "pixel (%u, %u): got 0x%08x, whose digits at even places are those of %u, at odd "
                 "ones those of %u",
                 x, y, got, from_x, from_y);
    }
}

enum { PLACES = 1 << 2 * RK_MORTON_DIGITS };

static void permuting_gives_every_pixel_a_place_of_its_own(void **state)
{
    (void)state;
    for (uint32_t key = 0; key < 3; key++) {
        static bool seen[PLACES];
        memset(seen, 0, sizeof seen);
        for (uint32_t i = 0; i < PLACES; i++) {
            uint32_t got = rk_permute_digits(i, key);
            rk_check(got < PLACES, "index %u: got %u, want less than %d", i, got, PLACES);
            rk_check(!seen[got], "index %u: got %u, the place of an index before", i, got);
            seen[got] = true;
        }
    }
}

static void permuting_keeps_every_square_together(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 20000; k++) {
        uint32_t shift = 2 * (k % (RK_MORTON_DIGITS + 1)), key = any_bits(k, 30);
        uint32_t a = any_bits(k, 31) % PLACES;
        uint32_t b = (a >> shift << shift) | (any_bits(k, 32) & ((1u << shift) - 1));
        uint32_t place_of_a = rk_permute_digits(a, key), place_of_b = rk_permute_digits(b, key);
        rk_check(place_of_a >> shift == place_of_b >> shift,
                 "indices %u and %u are of one square of %u x %u pixels; got %u and %u", a, b,
                 1u << shift / 2, 1u << shift / 2, place_of_a, place_of_b);
    }
}

/* The order of the four indices that differ in the digit at `shift` alone, as a number in base 4.
 */
static uint32_t order_at(uint32_t index, uint32_t shift, uint32_t key)
{
    uint32_t order = 0;
    for (uint32_t digit = 0; digit < 4; digit++) {
        uint32_t i = (index & ~(3u << shift)) | digit << shift;
        order = 4 * order + (rk_permute_digits(i, key) >> shift & 3);
    }
    return order;
}

/* 0 to 23, of an order of 0 to 3 as a number in base 4. */
static int rank_of(uint32_t order)
{
    int rank = 0;
    for (uint32_t i = 0; i < 4; i++) {
        int smaller = 0;
        for (uint32_t j = i + 1; j < 4; j++)
            smaller += (order >> (6 - 2 * j) & 3) < (order >> (6 - 2 * i) & 3);
        rank = rank * (4 - (int)i) + smaller;
    }
    return rank;
}

static double deviate(const unsigned *counts, int cells, double number_of_draws);

/* Two keys that differ in one bit permute a digit alike by chance only, one time in four. */
static void check_permutation_keys(void)
{
    for (uint32_t bit = 0; bit < 32; bit++) {
        const int digits = 256 * RK_MORTON_DIGITS;
        int alike = 0;
        for (uint32_t k = 0; k < 256; k++) {
            uint32_t index = any_bits(k, 33) % PLACES, key = any_bits(k, 34);
            uint32_t apart =
                rk_permute_digits(index, key) ^ rk_permute_digits(index, key ^ 1u << bit);
            for (uint32_t digit = 0; digit < RK_MORTON_DIGITS; digit++)
                alike += !(apart >> 2 * digit & 3);
        }
        rk_check(
            fabs(alike - digits / 4.) <= z_limit * sqrt(digits * 3 / 16.),
            "two keys that differ in bit %u permute %d of %d digits alike, want about a quarter: "
            "does the whole key enter the hash?",
            bit, alike, digits);
    }
}

/* Squares at a different digit, or at the same with other digits before it: their orders are
 * independent, and each of the 24 as frequent. */
static void all_orders_are_as_frequent_and_independent(void **state)
{
    (void)state;
    static const struct {
        uint32_t index, shift;
    } squares[] = {{0, 10}, {0, 8}, {1 << 10, 8}, {2 << 10, 8}, {0, 6},
                   {1, 2},  {0, 0}, {4, 0},       {16, 0},      {1 << 10, 0}};
    enum { n = sizeof squares / sizeof *squares, keys = 1 << 14, orders = 24 };
    static unsigned counts[n][n][orders * orders];
    memset(counts, 0, sizeof counts);
    for (uint32_t key = 0; key < keys; key++) {
        int rank[n];
        for (int a = 0; a < n; a++) {
            rank[a] = rank_of(order_at(squares[a].index, squares[a].shift, key));
            counts[a][a][rank[a]]++;
            for (int b = 0; b < a; b++)
                counts[a][b][rank[a] * orders + rank[b]]++;
        }
    }
    for (int a = 0; a < n; a++)
        for (int b = 0; b <= a; b++) {
            double z = deviate(counts[a][b], a == b ? orders : orders * orders, keys);
            rk_check(z <= z_limit,
                     "the orders at digit %u of index %u and digit %u of %u: chi-squared is %.2f "
                     "standard deviations too large, limit %.2f",
                     squares[a].shift / 2, squares[a].index, squares[b].shift / 2, squares[b].index,
                     z, z_limit);
        }
    check_permutation_keys();
}

/* --- Pixels that share a sequence ------------------------------------------------------------- */

static rk_sampler shared_by(uint32_t seed, uint32_t samples)
{
    return (rk_sampler){RK_SAMPLER_ZSOBOL, seed, samples, 640};
}

static uint32_t pixel_at(uint32_t x, uint32_t y)
{
    return y * 640 + x;
}

/* A pair of a dimension that is not joint: of a further light, a bounce, a feature, a pass. */
static const uint32_t paddings[] = {RK_DIMENSION_LIGHT + 2, RK_DIMENSION_GLOSSY + 2,
                                    RK_DIMENSION_FEATURES + 6,
                                    RK_DIMENSION_FURTHER + RK_DIMENSION_LIGHT};

enum { PADDINGS = sizeof paddings / sizeof *paddings };

/* The samples of the square of 2^k x 2^k pixels at (x, y). */
static void fill_square(point_set *set, uint32_t which, const rk_sampler *sampler, uint32_t k,
                        uint32_t x, uint32_t y)
{
    const uint32_t width = 1u << k;
    set->count = 0;
    set->dimensions = which < TOGETHER ? together[which].count : 2;
    for (uint32_t i = 0; i < width * width; i++)
        for (uint32_t sample = 0; sample < sampler->samples; sample++, set->count++)
            for (uint32_t d = 0; d < set->dimensions; d++) {
                uint32_t pixel = pixel_at(x + i % width, y + i / width);
                float u;
                if (which < TOGETHER) {
                    u = coordinate(sampler, pixel, sample, together[which].dimensions[d]);
                } else {
                    rk_vec2 pair = rk_joint_2d(sampler, pixel, sample, paddings[which - TOGETHER]);
                    u = d ? pair.y : pair.x;
                }
                set->bits[d][set->count] = (uint32_t)(u * 0x1p24f) << 8;
            }
}

/* 4^k 2^m points that are as even as the first of the sequence: also those of a single pixel. */
static void samples_of_every_square_are_even_together(void **state)
{
    (void)state;
    for (uint32_t which = 0; which < TOGETHER + PADDINGS; which++)
        for (uint32_t k = 0; k < 4; k++)
            for (uint32_t m = 0; m + 2 * k <= 6; m++)
                for (uint32_t i = 0; i < 4 && m + 2 * k > 0; i++) {
                    static point_set set;
                    const rk_sampler sampler = shared_by(i, 1u << m);
                    uint32_t x = (any_bits(i, 40) % 500) >> k << k;
                    uint32_t y = (any_bits(i, 41) % 500) >> k << k;
                    fill_square(&set, which, &sampler, k, x, y);
                    uint32_t t = quality(&set, m + 2 * k);
                    uint32_t want = which < TOGETHER ? together[which].t[m + 2 * k - 1] : 0;
                    rk_check(t <= want,
                             "%s, %u samples of each of the %u x %u pixels from (%u, %u) on: got "
                             "the quality t = %u, want %u",
                             which < TOGETHER ? together[which].name : "a padded pair", 1u << m,
                             1u << k, 1u << k, x, y, t, want);
                }
}

/* The first samples of 2 x 2 pixels are points 4 z N, (4 z + 1) N and so on, all different. With
 * 2^20 samples the last of a square is point 2^32 - 1. */
static void check_many_samples(void)
{
    for (uint32_t m = 0; m <= 20; m++) {
        const rk_sampler sampler = shared_by(m, 1u << m);
        float first[4];
        for (uint32_t i = 0; i < 4; i++)
            first[i] = coordinate(&sampler, pixel_at(44 + i % 2, 300 + i / 2), 0, 0);
        for (uint32_t i = 0; i < 4; i++)
            for (uint32_t k = 0; k < i; k++)
                rk_check(first[i] != first[k],
                         "2^%u samples of each of 2 x 2 pixels: pixels %u and %u have the same "
                         "first number, want one from points of its own: is z N computed with all "
                         "32 bits of N?",
                         m, k, i);
    }
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The first samples of a whole square, 2^20 apart: their points' first 24 digits in dimension 1 are
 * all different, because all 32 digits of the index count there. */
static void check_last_digits(void)
{
    enum { pixels = 64 * 64 };
    static float first[pixels];
    const rk_sampler sampler = shared_by(5, 1u << 20);
    for (uint32_t i = 0; i < pixels; i++)
        first[i] = coordinate(&sampler, pixel_at(64 + i % 64, 128 + i / 64), 0, 1);
    qsort(first, pixels, sizeof *first, compare_floats);
    uint32_t equal = 0;
    for (uint32_t i = 1; i < pixels; i++)
        equal += first[i] == first[i - 1];
    rk_check(equal == 0,
             "2^20 samples of each pixel: in dimension 1 the first numbers of %u of the 4096 "
             "pixels of a square are those of others, want all different: has the index z N all 32 "
             "bits?",
             equal);
}

/* Any n consecutive points of a dimension: those of whole aligned blocks lie one in each part, and
 * of the two blocks that are not whole at most one does. */
static void any_number_of_samples_is_even_in_squares(void **state)
{
    (void)state;
    const uint32_t numbers[] = {3, 5, 6, 7, 12, 100};
    for (uint32_t c = 0; c < sizeof numbers / sizeof *numbers; c++)
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
            for (uint32_t parts = 2; parts <= 32; parts *= 2) {
                const rk_sampler sampler = shared_by(c, numbers[c]);
                uint32_t counts[32 + 1] = {0}, n = 16 * numbers[c], least = n, most = 0;
                for (uint32_t i = 0; i < 16; i++)
                    for (uint32_t sample = 0; sample < numbers[c]; sample++) {
                        uint32_t pixel = pixel_at(44 + i % 4, 300 + i / 4);
                        counts[(int)(coordinate(&sampler, pixel, sample, d) * (float)parts)]++;
                    }
                for (uint32_t p = 0; p < parts; p++) {
                    least = counts[p] < least ? counts[p] : least;
                    most = counts[p] > most ? counts[p] : most;
                }
                rk_check(least + 1 >= n / parts && most <= n / parts + 2,
                         "joint dimension %u, %u samples of each of 4 x 4 pixels: %u to %u in one "
                         "of %u parts, want about %.1f",
                         d, numbers[c], least, most, parts, (double)n / parts);
            }
    check_many_samples();
    check_last_digits();
}

/* No two of 4 x 4 squares, by any of the seeds, have the same numbers. */
static void check_square_owners(void)
{
    static owner owners[OWNERS];
    int count = 0;
    for (uint32_t seed = 0; seed < SEEDS; seed++)
        for (uint32_t i = 0; i < PIXELS; i++) {
            const rk_sampler sampler = shared_by(seed, 2);
            uint32_t x = 64 * (i % 4), y = 64 * (i / 4);
            count += add_owners(owners + count, &sampler, pixel_at(x + 17, y + 9),
                                pixel_at(x + 40, y + 30));
        }
    check_all_differ(owners, count);
}

/* The first two numbers of the first pixel of the square in this column and row of squares. */
static uint64_t numbers_of_square(uint32_t width, uint32_t column, uint32_t row)
{
    const rk_sampler sampler = {RK_SAMPLER_ZSOBOL, 7, 2, width};
    uint32_t pixel = 64 * row * width + 64 * column;
    float first = coordinate(&sampler, pixel, 0, 0), second = coordinate(&sampler, pixel, 1, 0);
    return (uint64_t)(first * 0x1p24f) << 24 | (uint64_t)(second * 0x1p24f);
}

static void check_squares_differ(uint32_t width, const uint32_t (*squares)[2], uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < i; k++) {
            const uint32_t *a = squares[k], *b = squares[i];
            rk_check(numbers_of_square(width, a[0], a[1]) != numbers_of_square(width, b[0], b[1]),
                     "width %u: the squares of 64 x 64 pixels that begin at (%u, %u) and (%u, %u) "
                     "have the same numbers, want a sequence for each: its key has the whole "
                     "Morton index of (x / 64, y / 64), whatever the width",
                     width, 64 * a[0], 64 * a[1], 64 * b[0], 64 * b[1]);
        }
}

/* Squares side by side where the last of a row is not whole, then some whose columns or rows differ
 * in one digit, up to pixels at 65535. */
static void check_squares_of_any_width(void)
{
    const uint32_t widths[] = {65, 100, 127, 129};
    uint32_t squares[1 + 2 * 10][2];
    for (uint32_t w = 0; w < 4; w++) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < 9; i++)
            if (64 * (i % 3) < widths[w]) {
                squares[count][0] = i % 3;
                squares[count++][1] = i / 3;
            }
        check_squares_differ(widths[w], squares, count);
    }
    /* Of very high and very wide pictures. */
    for (uint32_t axis = 0; axis < 2; axis++) {
        for (uint32_t i = 0; i < 17; i++) {
            squares[i][axis] = i ? 1u << (i - 1) : 0;
            squares[i][1 - axis] = 0;
        }
        check_squares_differ(axis ? 64 : 1u << 22, squares, 17);
    }
    squares[0][0] = squares[0][1] = 1023;
    for (uint32_t i = 0; i < 20; i++) {
        squares[1 + i][0] = 1023 ^ (i % 2 ? 0 : 1u << i / 2);
        squares[1 + i][1] = 1023 ^ (i % 2 ? 1u << i / 2 : 0);
    }
    check_squares_differ(1 << 16, squares, 21);
}

/* Of a pixel sample 1 by each seed. */
static void fill_by_seeds(sample_numbers numbers, uint32_t pixel)
{
    for (uint32_t seed = 0; seed < draws; seed++) {
        const rk_sampler sampler = shared_by(seed, 2);
        float x[RK_SOBOL_DIMENSIONS];
        find_all(&sampler, pixel, 1, x);
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
            numbers[d][seed] = x[d];
    }
}

static void check_square(const float *here, const float *there, uint32_t d, uint32_t x, uint32_t y)
{
    unsigned counts[side * side] = {0}, equal = 0;
    for (uint32_t seed = 0; seed < draws; seed++) {
        counts[(int)(there[seed] * side) * side + (int)(here[seed] * side)]++;
        equal += there[seed] == here[seed];
    }
    rk_check(equal < draws / 4,
             "joint dimension %u: pixel (81, 73) and pixel (%u, %u) of another square of 64 x "
             "64 pixels have the same number by %u of %d seeds: both coordinates of the "
             "square enter its key",
             d, x, y, equal, draws);
    double z = deviate(counts, side * side, draws);
    rk_check(z <= z_limit,
             "joint dimension %u, pixel (81, 73) and pixel (%u, %u) of another square of 64 x "
             "64 pixels: related by %.2f standard deviations of chi-squared, limit %.2f",
             d, x, y, z, z_limit);
}

/* Beyond 4^6 pixels, the next ones have another sequence. */
static void squares_of_64_pixels_are_independent(void **state)
{
    (void)state;
    static sample_numbers here, there;
    const uint32_t others[][2] = {
        {128 + 17, 64 + 9}, {64 + 17, 128 + 9}, {192 + 17, 128 + 9}, {17, 128 + 9}};
    fill_by_seeds(here, pixel_at(64 + 17, 64 + 9));
    for (uint32_t k = 0; k < 4; k++) {
        fill_by_seeds(there, pixel_at(others[k][0], others[k][1]));
        for (uint32_t d = 0; d < RK_SOBOL_DIMENSIONS; d++)
            check_square(here[d], there[d], d, others[k][0], others[k][1]);
    }
    check_square_owners();
    check_squares_of_any_width();
}

enum { NUMBERS = RK_SOBOL_DIMENSIONS + 2 * PADDINGS };

/* Number `draw` of each dimension: the nine joint ones of a pixel's sample, then its padded pairs.
 */
static void add_numbers(float numbers[NUMBERS][draws], uint32_t draw, const rk_sampler *sampler,
                        uint32_t pixel, uint32_t sample)
{
    float x[NUMBERS];
    find_all(sampler, pixel, sample, x);
    for (uint32_t k = 0; k < PADDINGS; k++) {
        rk_vec2 pair = rk_joint_2d(sampler, pixel, sample, paddings[k]);
        x[RK_SOBOL_DIMENSIONS + 2 * k] = below_one(pair.x);
        x[RK_SOBOL_DIMENSIONS + 2 * k + 1] = below_one(pair.y);
    }
    for (uint32_t d = 0; d < NUMBERS; d++)
        numbers[d][draw] = x[d];
}

static float shared_numbers[NUMBERS][draws];

static void shared_samples_are_uniform_over_seeds(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t pixel = pixel_at(any_bits(k, 50) % 640, any_bits(k, 51) % 640);
        for (uint32_t seed = 0; seed < draws; seed++) {
            const rk_sampler sampler = shared_by(seed, k + 1);
            add_numbers(shared_numbers, seed, &sampler, pixel, k);
        }
        for (uint32_t d = 0; d < NUMBERS; d++) {
            const float *numbers = shared_numbers[d];
            unsigned counts[side * side] = {0};
            for (uint32_t seed = 0; seed < draws; seed++)
                counts[(int)(numbers[seed] * side * side)]++;
            double z = deviate(counts, side * side, draws), ks = kolmogorov(numbers, draws);
            rk_check(z <= z_limit && ks <= ks_limit,
                     "number %u, pixel %u, sample %u: chi-squared is %.2f standard deviations too "
                     "large, limit %.2f; Kolmogorov's statistic is %.2f, limit %.2f",
                     d, pixel, k, z, z_limit, ks, ks_limit);
        }
    }
}

static void name_number(uint32_t d, char text[40])
{
    uint32_t k = d - RK_SOBOL_DIMENSIONS;
    if (d < RK_SOBOL_DIMENSIONS)
        snprintf(text, 40, "joint dimension %u", d);
    else
        snprintf(text, 40, "dimension %u", paddings[k / 2] + k % 2);
}

/* Two numbers of each draw. */
static void check_unrelated_draws(const float *x, const float *y, uint32_t n, const char *of_x,
                                  const char *of_y, const char *where)
{
    unsigned counts[side * side] = {0}, equal = 0;
    for (uint32_t i = 0; i < n; i++) {
        counts[(int)(x[i] * side) * side + (int)(y[i] * side)]++;
        equal += x[i] == y[i];
    }
    rk_check(equal < n / 4,
             "%s and %s %s: the same number in %u of %u cases: does the key have all bits of the "
             "dimension?",
             of_x, of_y, where, equal, n);
    double z = deviate(counts, side * side, n);
    rk_check(z <= z_limit,
             "%s and %s %s: related by %.2f standard deviations of chi-squared, limit %.2f", of_x,
             of_y, where, z, z_limit);
}

/* Of one sample, by seeds: for neighbours' samples in the same dimension it does not hold, by
 * intention. */
static void shared_dimensions_are_independent(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 2; k++) {
        for (uint32_t seed = 0; seed < draws; seed++) {
            const rk_sampler sampler = shared_by(seed, k + 1);
            add_numbers(shared_numbers, seed, &sampler, pixel_at(3, 7) + k, k);
        }
        for (uint32_t d = 0; d < NUMBERS; d++)
            for (uint32_t e = 0; e < d; e++) {
                char of_d[40], of_e[40];
                name_number(d, of_d);
                name_number(e, of_e);
                check_unrelated_draws(shared_numbers[d], shared_numbers[e], draws, of_d, of_e,
                                      k ? "of sample 1, by seeds" : "of sample 0, by seeds");
            }
    }
}

static const char over_pixels[] = "over pixels, which each dimension that is not joint "
                                  "takes in an order of its own";

/* Numbers of dimension 4, and of those that differ from it in one bit: 5 is the other one of its
 * pair. All of them are asked for before one is looked at. */
enum { orders_seen = draws / 4 };
static float of_4[orders_seen], of_bit[32][orders_seen];

static void fill_orders(const rk_sampler *sampler)
{
    for (uint32_t i = 0; i < orders_seen; i++) {
        const uint32_t pixel = pixel_at(2 * (i % 64), 2 * (i / 64));
        of_4[i] = below_one(rk_joint_1d(sampler, pixel, 0, 4));
        for (uint32_t bit = 0; bit < 32; bit++)
            of_bit[bit][i] = below_one(rk_joint_1d(sampler, pixel, 0, 4 ^ 1u << bit));
    }
}

static void check_order_of_each_dimension(void)
{
    for (uint32_t bit = 0; bit < 32; bit++) {
        const uint32_t dimension = 4 ^ 1u << bit;
        char name[40];
        if (rk_joint_dimension(dimension) >= 0)
            continue;
        snprintf(name, sizeof name, "dimension %u", dimension);
        check_unrelated_draws(of_4, of_bit[bit], orders_seen, "dimension 4", name, over_pixels);
    }
}

/* Over the pixels of one picture: a padded pair is taken in an order of its own. */
static void padded_pairs_are_in_an_order_of_their_own(void **state)
{
    (void)state;
    const rk_sampler sampler = shared_by(5, 1);
    for (uint32_t i = 0; i < draws; i++)
        add_numbers(shared_numbers, i, &sampler, pixel_at(i % 128, i / 128), 0);
    fill_orders(&sampler);
    for (uint32_t d = RK_SOBOL_DIMENSIONS; d < NUMBERS; d++)
        for (uint32_t e = 0; e < d - (d - RK_SOBOL_DIMENSIONS) % 2; e++) {
            char of_d[40], of_e[40];
            name_number(d, of_d);
            name_number(e, of_e);
            check_unrelated_draws(shared_numbers[d], shared_numbers[e], draws, of_d, of_e,
                                  over_pixels);
        }
    check_order_of_each_dimension();
}

static void a_shared_run_is_its_samples_one_by_one_in_any_order(void **state)
{
    (void)state;
    const rk_sampler sampler = shared_by(3, 300);
    const uint32_t dimensions[] = {RK_DIMENSION_PIXEL, RK_DIMENSION_LENS, RK_DIMENSION_LIGHT,
                                   RK_DIMENSION_GLOSSY, RK_DIMENSION_FEATURES + 2};
    check_constant_sampler(&sampler);
    for (uint32_t k = 0; k < 5; k++) {
        check_runs(&sampler, 5555, 300, dimensions[k]);
        check_runs_over_powers(&sampler, 5555, dimensions[k]);
    }
}

/* A penumbra: in a pixel, the part of the unit square below a line, which moves slowly over the
 * picture. From u + v / 2 < c follows the area c - 1/4, for c from 1/2 to 1. */
enum { picture = 64 };
static double errors[picture][picture];

static void fill_errors(const rk_sampler *sampler, uint32_t dimension)
{
    const bool is_the_kits = sampler->kind == RK_SAMPLER_LOW_DISCREPANCY;
    for (uint32_t y = 0; y < picture; y++)
        for (uint32_t x = 0; x < picture; x++) {
            const float c = 0.75f + 0.2f * sinf(0.05f * (float)(x + 2 * y));
            unsigned lit = 0;
            for (uint32_t i = 0; i < sampler->samples; i++) {
                rk_vec2 xi = is_the_kits ? rk_sample_2d(sampler, pixel_at(x, y), i, dimension)
                                         : rk_joint_2d(sampler, pixel_at(x, y), i, dimension);
                lit += xi.x + 0.5f * xi.y < c;
            }
            errors[y][x] = lit / (double)sampler->samples - ((double)c - 0.25);
        }
}

/* The mean squared error after the mean over each square of `blur` x `blur` pixels. */
static double blurred(int blur)
{
    static double in_rows[picture][picture];
    double squares = 0;
    for (int y = 0; y < picture; y++)
        for (int x = 0; x + blur <= picture; x++) {
            in_rows[y][x] = 0;
            for (int i = 0; i < blur; i++)
                in_rows[y][x] += errors[y][x + i] / (blur * blur);
        }
    for (int y = 0; y + blur <= picture; y++)
        for (int x = 0; x + blur <= picture; x++) {
            double sum = 0;
            for (int i = 0; i < blur; i++)
                sum += in_rows[y + i][x];
            squares += sum * sum;
        }
    return squares / ((picture - blur + 1.) * (picture - blur + 1.));
}

/* Over 16 seeds the standard error of shared samples is up to 5 % for single pixels, and for 5 x 5,
 * of which a picture has 160, 3 %; that of samples of a pixel's own over 4 is 1 % for single
 * pixels. */
static double mean_error(rk_sampler_kind kind, uint32_t seeds, uint32_t dimension, uint32_t n,
                         int blur)
{
    double sum = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        const rk_sampler sampler = {kind, seed, n, 640};
        fill_errors(&sampler, dimension);
        sum += blurred(blur) / seeds;
    }
    return sum;
}

/* Few samples of a pixel by itself are as good in all scrambled (0, 2)-sequences, also the kit's.
 */
static void few_shared_samples_have_smaller_errors_after_a_blur(void **state)
{
    (void)state;
    const uint32_t numbers[] = {1, 2, 3, 4};
    const uint32_t dimensions[] = {RK_DIMENSION_LIGHT, RK_DIMENSION_FEATURES + 6};
    for (uint32_t c = 0; c < 4; c++)
        for (uint32_t k = 0; k < 2; k++) {
            double own = mean_error(RK_SAMPLER_LOW_DISCREPANCY, 16, dimensions[k], numbers[c], 5);
            double got = mean_error(RK_SAMPLER_ZSOBOL, 16, dimensions[k], numbers[c], 5);
            rk_check(got * 1.5 <= own,
                     "dimension %u, %u samples, mean over 5 x 5 pixels: the squared error is %.3g, "
                     "want at most 1/1.5 of that of pixels by themselves, %.3g",
                     dimensions[k], numbers[c], got, own);
        }
}

/* In single pixels nothing is lost where the number is a power of two. */
static void shared_samples_are_as_good_in_single_pixels(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 16; n *= 4) {
        double own = mean_error(RK_SAMPLER_SOBOL, 4, RK_DIMENSION_LIGHT, n, 1);
        double got = mean_error(RK_SAMPLER_ZSOBOL, 16, RK_DIMENSION_LIGHT, n, 1);
        rk_check(got <= 1.15 * own,
                 "%u samples: the squared error is %.4g, want that of sobol, %.4g, or less than 15 "
                 "%% more",
                 n, got, own);
    }
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
    cmocka_unit_test(the_first_16_pixels_are_in_z_order),
    cmocka_unit_test(digits_of_x_and_y_alternate),
    cmocka_unit_test(permuting_gives_every_pixel_a_place_of_its_own),
    cmocka_unit_test(permuting_keeps_every_square_together),
    cmocka_unit_test(all_orders_are_as_frequent_and_independent),
    cmocka_unit_test(samples_of_every_square_are_even_together),
    cmocka_unit_test(any_number_of_samples_is_even_in_squares),
    cmocka_unit_test(squares_of_64_pixels_are_independent),
    cmocka_unit_test(shared_samples_are_uniform_over_seeds),
    cmocka_unit_test(shared_dimensions_are_independent),
    cmocka_unit_test(padded_pairs_are_in_an_order_of_their_own),
    cmocka_unit_test(a_shared_run_is_its_samples_one_by_one_in_any_order),
    cmocka_unit_test(few_shared_samples_have_smaller_errors_after_a_blur),
    cmocka_unit_test(shared_samples_are_as_good_in_single_pixels),
};

RK_SUITE("sampling", tests)
