/* Searches for a measure's worst inputs: from many random starts, each climbs by small and large
 * changes of a few inputs as long as the error does not get smaller. Changes are those that floats
 * are sensitive to: neighbours, bits, exponents, signs, equal numbers, and the ends of their
 * domains. */
#include "measure.h"

#include "base/random.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct dice {
    uint32_t key, draws;
} dice;

static uint32_t bits(dice *d)
{
    return rk_hash(0x73747265, d->key, d->draws++, 0);
}

static uint32_t below(dice *d, uint32_t count)
{
    return (uint32_t)((uint64_t)bits(d) * count >> 32);
}

static float fraction(dice *d)
{
    return rk_unit_float(bits(d));
}

/* A number in [-1/2, 1/2), of any size down to 2^-24. Drawn one after the other: the order in which
 * a call's arguments are evaluated is the compiler's. */
static float step(dice *d)
{
    float part = fraction(d) - 0.5f;
    return ldexpf(part, -(int)below(d, 24));
}

unsigned measure_input_count(const measure *m)
{
    unsigned count = 0;
    for (size_t i = 0; i < DOMAINS_MAX && m->domains[i].count; i++)
        count += m->domains[i].count;
    return count;
}

static const domain *domain_of(const measure *m, unsigned input)
{
    const domain *at = m->domains;
    while (input >= at->count)
        input -= (at++)->count;
    return at;
}

/* The nearest value of the domain. Not by fminf and fmaxf, whose zero may have either sign: every
 * build is to try the same inputs. */
static float into(const domain *at, float x)
{
    if (x != x)
        return at->kind == SIGNED || at->kind == FRACTION ? 0 : at->low;
    if (at->kind == BETWEEN)
        return rk_min(rk_max(x, at->low), at->high);
    if (at->kind == FRACTION)
        return rk_min(rk_max(rintf(x * 0x1p24f) * 0x1p-24f, 0), 1 - 0x1p-24f);
    float least = exp2f(at->low), most = rk_min(exp2f(at->high), FLT_MAX);
    if (at->kind == SIGNED && fabsf(x) < least)
        return copysignf(0, x);
    return copysignf(rk_min(rk_max(fabsf(x), least), most), at->kind == SIGNED ? x : 1);
}

/* Round numbers are frequent in scenes, and often the boundary between two cases. */
static float round_number(dice *d)
{
    const float numbers[] = {0, -0.0f, 1, -1, 0.5f, -0.5f, 2, 0.25f, 0.75f, 3};
    return numbers[below(d, sizeof numbers / sizeof *numbers)];
}

static float anything(const domain *at, dice *d)
{
    if (below(d, 12) == 0)
        return into(at, round_number(d));
    if (at->kind == BETWEEN)
        return into(at, at->low + (at->high - at->low) * fraction(d));
    if (at->kind == FRACTION) /* small ones are as likely as others of their exponent */
        return into(at, below(d, 4) ? fraction(d) : 2 * fabsf(step(d)));
    /* Half of them near 1, where sizes are comparable. */
    float low = at->low, high = at->high;
    if (below(d, 2) && low < -1 && high > 1)
        low = -1, high = 1;
    float size = exp2f(low + (high - low) * fraction(d));
    return into(at, below(d, 2) ? size : -size);
}

static float neighbour(float x, uint32_t steps, bool up)
{
    for (uint32_t i = 0; i < steps; i++)
        x = nextafterf(x, up ? INFINITY : -INFINITY);
    return x;
}

static void change(const measure *m, unsigned count, float *in, dice *d)
{
    unsigned i = below(d, count), other = below(d, count);
    const domain *at = domain_of(m, i);
    float x = in[i];
    bool up = below(d, 2);
    switch (below(d, 9)) {
    case 0:
        x = at->kind == FRACTION ? x + (up ? 0x1p-24f : -0x1p-24f)
                                 : neighbour(x, 1 + below(d, 4), up);
        break;
    case 1:
    case 2: /* by a step of any size, relative to the number */
        x *= 1 + step(d);
        break;
    case 3: /* or to its domain */
        x += step(d) * (at->kind == BETWEEN ? at->high - at->low : 1);
        break;
    case 4:
        x = up ? 2 * x : x / 2;
        break;
    case 5:
        x = -x;
        break;
    case 6:
        x = up ? in[other] : neighbour(-in[other], below(d, 3), true);
        break;
    case 7: {
        uint32_t word;
        memcpy(&word, &x, sizeof word);
        word ^= 1u << below(d, 23);
        memcpy(&x, &word, sizeof x);
        break;
    }
    default:
        x = anything(at, d);
    }
    in[i] = into(at, x);
}

/* Inputs that the measure is not about are worse than any other. */
static double error_at(const measure *m, const float *in)
{
    double error = m->error(in);
    return error == error ? error : (double)-INFINITY;
}

static void start_anywhere(const measure *m, unsigned count, float *in, dice *d)
{
    for (unsigned i = 0; i < count; i++)
        in[i] = anything(domain_of(m, i), d);
}

finding search_for_worst(const measure *m, unsigned long trials)
{
    enum { starts = 32, patience = 300 };
    const unsigned count = measure_input_count(m);
    finding worst = {.error = (double)-INFINITY};
    dice d = {0};
    for (const char *c = m->what; *c; c++)
        d.key = d.key * 31 + (unsigned char)*c;
    for (const char *c = m->routine; *c; c++)
        d.key = d.key * 31 + (unsigned char)*c;
    while (worst.tried < trials) {
        float best[INPUTS_MAX] = {0}, next[INPUTS_MAX];
        double error = (double)-INFINITY;
        for (int i = 0; i < starts; i++, worst.tried++) {
            start_anywhere(m, count, next, &d);
            double found = error_at(m, next);
            if (found >= error)
                error = found, memcpy(best, next, sizeof best);
        }
        for (int failures = 0; failures < patience && worst.tried < trials; worst.tried++) {
            memcpy(next, best, sizeof next);
            for (uint32_t n = 1 + below(&d, 3); n > 0; n--)
                change(m, count, next, &d);
            double found = error_at(m, next);
            failures = found > error ? 0 : failures + 1;
            if (found >= error)
                error = found, memcpy(best, next, sizeof best);
        }
        if (error > worst.error)
            worst.error = error, memcpy(worst.input, best, sizeof worst.input);
    }
    return worst;
}
