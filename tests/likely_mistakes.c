/* What a wrong number says about the mistake behind it. A sentence appears only if the number
 * equals a mistake's within the claim's own tolerance, which is finer for a smaller one, and
 * neither the wanted one nor another known mistake does. Nothing is said of 0, which mistakes of
 * all kinds give, and of 1 and -1 only what the suite itself knows. */
#include "test.h"

static const double pi = 3.14159265358979323846;

static const char *sentence(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* One message has one sentence. */
static const char *sentence(const char *format, ...)
{
    static char text[500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}

/* --- Numbers ---------------------------------------------------------------------------------- */

static bool is_telling(double value)
{
    return isfinite(value) && value != 0 && fabs(value) != 1;
}

/* A tolerance that is coarse beside a small mistake would match any small number. */
static double beside_small(double tolerance, double value, double want)
{
    double scaled = want != 0 ? tolerance * fabs(value / want) : tolerance;
    return fmin(tolerance, fmax(scaled, 1e-3 * fabs(value)));
}

/* The error of a multiple is as many times as large. */
static double tolerance_around(double value, double want, double tolerance)
{
    double multiple = want != 0 ? fabs(value / want) : 1;
    return multiple > 1 ? multiple * tolerance : beside_small(tolerance, value, want);
}

static bool is_mistake(double got, double value, double want, double tolerance)
{
    double around = tolerance_around(value, want, tolerance);
    return fabs(got - value) <= around && fabs(want - value) > 2 * fmax(around, tolerance);
}

/* Of any two numbers some relation holds by chance, within a coarse tolerance. */
static bool is_fine(double want, double tolerance)
{
    return tolerance <= 1e-3 * fabs(want);
}

static const char *common_mistake(double got, double want, double tolerance)
{
    const rk_mistake mistakes[] = {
        {2 * want, "twice the wanted: is a diameter taken for a radius, or something added twice?"},
        {want / 2, "half the wanted: is a radius taken for a diameter, or a factor 2 forgotten?"},
        {-want, "the wanted with the other sign: is a difference taken the other way round?"},
        {want * want, "the square of the wanted: is a root missing?"},
        {sqrt(want), "the square root of the wanted"},
        {1 / want, "1 over the wanted: are dividend and divisor exchanged?"},
        {1 - want, "1 minus the wanted: is it counted from the other end?"},
        {pi * want, "pi times the wanted: is it not divided by pi?"},
        {want / pi, "the wanted over pi: is it divided by pi once too often?"},
        {want * 180 / pi, "the wanted in degrees: are they taken for radians?"},
        {want * pi / 180, "the wanted in radians: are they taken for degrees?"},
        {sqrt(1 - want * want),
         "the sine of the angle whose cosine is wanted, or the other way round"},
    };
    const char *said[2] = {NULL, NULL}; /* of simple numbers, one may be half and square */
    for (int i = 0; i < (int)(sizeof mistakes / sizeof *mistakes); i++)
        if (is_mistake(got, mistakes[i].value, want, tolerance) && !said[1])
            said[said[0] != NULL] = mistakes[i].said;
    if (!said[0])
        return "";
    return sentence("; it is %s%s%s", said[0], said[1] ? " Or " : "", said[1] ? said[1] : "");
}

/* Where two mistakes give the same number, it could be either. */
static bool is_alone(const rk_mistake *it, const rk_mistake *known, double tolerance)
{
    for (; known->said; known++)
        if (strcmp(known->said, it->said) != 0 && fabs(known->value - it->value) <= 2 * tolerance)
            return false;
    return true;
}

const char *rk_mistake_in(double got, double want, double tolerance, const rk_mistake *known)
{
    for (const rk_mistake *it = known; it && it->said && got != 0; it++)
        if (is_mistake(got, it->value, want, tolerance) &&
            is_alone(it, known, tolerance_around(it->value, want, tolerance)))
            return sentence(RK_EXAMPLE_IF "%s", it->said);
    if (!is_telling(got) || !is_telling(want) || !is_fine(want, tolerance))
        return "";
    return common_mistake(got, want, tolerance);
}

/* --- Whole numbers ---------------------------------------------------------------------------- */

static uint32_t reversed_bits(uint32_t value)
{
    uint32_t reversed = 0;
    for (int bit = 0; bit < 32; bit++)
        reversed |= (value >> bit & 1) << (31 - bit);
    return reversed;
}

const char *rk_mistake_in_whole(long long got, long long want, const rk_mistake *known)
{
    enum { few = 8 }; /* small counts are often twice or half of one another */
    for (const rk_mistake *it = known; it && it->said && got != 0; it++)
        if ((double)got == it->value && (double)want != it->value && is_alone(it, known, 0))
            return sentence(RK_EXAMPLE_IF "%s", it->said);
    bool is_32_bits = got == (long long)(uint32_t)got && want == (long long)(uint32_t)want;
    if (is_32_bits && want > 255 && got != want && (uint32_t)got == reversed_bits((uint32_t)want))
        return "; its 32 bits are those of the wanted in reversed order";
    if (llabs(got) <= few || llabs(want) <= few)
        return "";
    if (got == 2 * want)
        return "; it is twice the wanted: is something counted twice?";
    if (want == 2 * got)
        return "; it is half the wanted";
    return got == -want ? "; it is the wanted with the other sign" : "";
}

/* --- Vectors and colours ---------------------------------------------------------------------- */

static bool is_vector(const double *got, const double *value, double tolerance)
{
    return fabs(got[0] - value[0]) <= tolerance && fabs(got[1] - value[1]) <= tolerance &&
           fabs(got[2] - value[2]) <= tolerance;
}

static bool is_vector_mistake(const double *got, const double *value, const double *want,
                              double tolerance)
{
    return is_vector(got, value, tolerance) && !is_vector(want, value, 2 * tolerance);
}

static double length_of(const double *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static const char *exchanged(const double *got, const double *want, double tolerance)
{
    const char names[] = "xyz";
    for (int i = 0; i < 3; i++)
        for (int k = i + 1; k < 3; k++) {
            double value[3] = {want[0], want[1], want[2]};
            value[i] = want[k];
            value[k] = want[i];
            if (is_vector_mistake(got, value, want, tolerance))
                return sentence("; %c and %c are exchanged", names[i], names[k]);
        }
    return NULL;
}

static const char *other_sign(const double *got, const double *want, double tolerance)
{
    const double opposite[3] = {-want[0], -want[1], -want[2]};
    if (is_vector_mistake(got, opposite, want, tolerance))
        return "; it points the opposite way: is a difference taken the other way round?";
    for (int k = 0; k < 3; k++) {
        double value[3] = {want[0], want[1], want[2]};
        value[k] = -want[k];
        if (is_vector_mistake(got, value, want, tolerance))
            return sentence("; %c has the other sign", "xyz"[k]);
    }
    return NULL;
}

/* The wanted vector, but longer or shorter. */
static const char *other_length(const double *got, const double *want, double tolerance)
{
    double factor = length_of(got) / length_of(want);
    const double value[3] = {factor * want[0], factor * want[1], factor * want[2]};
    double allowed = tolerance * fmax(1, factor) + 0x1p-22 * length_of(value);
    if (!(factor > 0) || !is_vector_mistake(got, value, want, allowed))
        return NULL;
    if (fabs(length_of(want) - 1) <= 1e-5)
        return sentence(
            "; its direction is right, but its length is %.4g, not 1: is it normalized?",
            length_of(got));
    return sentence("; all of it is %.6g times the wanted", factor);
}

static const char *limited(const double *got, const double *want, double tolerance)
{
    const double one[3] = {fmin(want[0], 1), fmin(want[1], 1), fmin(want[2], 1)};
    const double grey[3] = {want[0], want[0], want[0]};
    if (is_vector_mistake(got, one, want, tolerance))
        return "; it is the wanted, limited to 1: light may be brighter";
    return is_vector_mistake(got, grey, want, tolerance) ? "; x stands in all three places" : NULL;
}

static bool is_known_vector(const double *got, const rk_vector_mistake *it, const double *want,
                            double tolerance, const rk_vector_mistake *known)
{
    double around = beside_small(tolerance, length_of(it->value), length_of(want));
    if (!is_vector(got, it->value, around) || is_vector(want, it->value, 2 * tolerance))
        return false;
    for (; known->said; known++)
        if (strcmp(known->said, it->said) != 0 && is_vector(known->value, it->value, 2 * around))
            return false;
    return true;
}

const char *rk_mistake_in_vector(const double *got, const double *want, double tolerance,
                                 const rk_vector_mistake *known)
{
    if (length_of(got) == 0)
        return "";
    for (const rk_vector_mistake *it = known; it && it->said; it++)
        if (is_known_vector(got, it, want, tolerance, known))
            return sentence(RK_EXAMPLE_IF "%s", it->said);
    int telling = is_telling(want[0]) + is_telling(want[1]) + is_telling(want[2]);
    if (telling < 2 || !is_fine(length_of(want), tolerance))
        return "";
    const char *(*const kinds[])(const double *, const double *, double) = {exchanged, other_sign,
                                                                            other_length, limited};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const char *said = kinds[i](got, want, tolerance);
        if (said)
            return said;
    }
    return "";
}
