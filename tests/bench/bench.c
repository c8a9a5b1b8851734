/* Measures errors and times of pictures for tools/bench.py. The command line has a driver's
 * options: a scene, a camera, a size. Each line of the input then asks for one of
 *
 *   reference PATH OPTIONS | OPTIONS    true values by two methods, kept in the file
 *   picture OPTIONS                     a picture's error against them, and its cost
 *   kinds                               the names of the sampler kinds that differ in single pixels
 *   tree LEAF                           the cost of the scene's tree; LEAF: most triangles of a
 * leaf, 0 as built numbers                             three lines: functions in float against the
 * same in double
 *
 * with options of the renderer, and --pictures N for the mean of N pictures with the seeds from
 * --seed on. Each line is answered by one of numbers, separated by commas. Errors count where the
 * two references' pictures vary, and are relative to the root mean square of the true values there.
 */
#include "numbers.h"
#include "picture_sum.h"
#include "trees.h"

#include "base/file.h"
#include "driver/driver_options.h"
#include "render/options.h"

#include <stdio.h>
#include <string.h>

/* --- options of a line ----------------------------------------------------------------------- */

enum { WORDS_MAX = 64 };

typedef struct job {
    rk_render_options render;
    uint32_t pictures;
} job;

static const rk_option job_rows[] = {
    {"pictures", RK_FIELD(job, pictures), "N", "the mean of this many pictures", 1, 1 << 20, 1},
    {0},
};

/* Reads options that come on top of the case's own. */
static bool read_job(job *to, const rk_driver *driver, char *text, rk_error *error)
{
    static char name[] = "bench";
    char *words[WORDS_MAX + 1] = {name};
    int count = 1;
    for (char *word = strtok(text, " \n"); word; word = strtok(NULL, " \n")) {
        if (count == WORDS_MAX)
            return rk_fail(error, "a line has more than %d words", WORDS_MAX);
        words[count++] = word;
    }
    *to = (job){.render = driver->render, .pictures = 1};
    const rk_render_option_tables render = rk_render_options_tables(&to->render);
    rk_option_table tables[2 + RK_FEATURE_COUNT] = {{job_rows, to}};
    memcpy(tables + 1, render.tables, render.count * sizeof *tables);
    return rk_options_parse(count, words, "", tables, 1 + render.count, error) == RK_OPTIONS_OK;
}

/* --- rendering ------------------------------------------------------------------------------- */

typedef struct cost {
    double seconds; /* of processor time */
    rk_counters counters;
} cost;

static bool render(picture_sum *sum, cost *total, rk_driver *driver, job *j, rk_error *error)
{
    *total = (cost){0};
    for (uint32_t i = 0; i < j->pictures; i++, j->render.seed++) {
        rk_counters counters;
        double start = rk_clock_thread(); /* the only thread: see main */
        if (!rk_render(&driver->image, &driver->scene, &driver->accel, &j->render, driver->pool,
                       &counters, NULL, error))
            return false;
        total->seconds += rk_clock_thread() - start;
        rk_counters_add(&total->counters, &counters);
        picture_sum_add(sum, &driver->image);
    }
    return true;
}

/* --- the reference --------------------------------------------------------------------------- */

/* Two independent means; the true values are taken to be their mean, weighted by their variances.
 */
typedef struct reference {
    picture_sum half[2];
    double weight; /* of the first */
    double norm;   /* root mean square of the true values that count */
    double values; /* that count */
} reference;

static void free_reference(reference *r)
{
    picture_sum_free(&r->half[0]);
    picture_sum_free(&r->half[1]);
}

/* Does the feature matter here: do pictures vary? */
static bool counts(const reference *r, size_t i)
{
    return r->half[0].squares[i] > 0 || r->half[1].squares[i] > 0;
}

static double truth(const reference *r, size_t i)
{
    return r->weight * r->half[0].mean[i] + (1 - r->weight) * r->half[1].mean[i];
}

static double truth_variance(const reference *r, size_t i)
{
    double other = 1 - r->weight;
    return r->weight * r->weight * picture_sum_variance(&r->half[0], i) +
           other * other * picture_sum_variance(&r->half[1], i);
}

static bool weigh(reference *r, rk_error *error)
{
    double variance[2] = {0}, squares = 0;
    r->values = 0;
    for (size_t i = 0; i < r->half[0].values; i++)
        if (counts(r, i)) {
            r->values++;
            for (int h = 0; h < 2; h++)
                variance[h] += picture_sum_variance(&r->half[h], i);
        }
    if (r->values == 0)
        return rk_fail(error, "the references do not vary: the options draw no random samples");
    r->weight = variance[1] / (variance[0] + variance[1]);
    for (size_t i = 0; i < r->half[0].values; i++)
        squares += counts(r, i) ? truth(r, i) * truth(r, i) : 0;
    r->norm = sqrt(squares / r->values);
    return r->norm > 0 || rk_fail(error, "the picture is black where it varies");
}

/* The variance of a sum over pixels, from standard deviations of their values. The channels of a
 * pixel share samples, so their errors are added as if they were the same. */
static double variance_of_sum(const reference *r, double (*variance)(const reference *r, size_t i))
{
    double total = 0;
    for (size_t pixel = 0; pixel < r->half[0].values / 3; pixel++) {
        double deviation = 0;
        for (size_t i = 3 * pixel; i < 3 * pixel + 3; i++)
            deviation += counts(r, i) ? sqrt(variance(r, i)) : 0;
        total += deviation * deviation;
    }
    return total;
}

static double difference_variance(const reference *r, size_t i)
{
    return picture_sum_variance(&r->half[0], i) + picture_sum_variance(&r->half[1], i);
}

/* Values that count, their root mean square; the reference's own mean squared error, and the
 * standard error of its bias; and the comparison of the halves: their mean difference in standard
 * errors, and their mean squared difference over its expectation, which is 1 if both are right. */
static void print_reference(const reference *r)
{
    double own = 0, difference = 0, squares = 0, expected = 0;
    for (size_t i = 0; i < r->half[0].values; i++)
        if (counts(r, i)) {
            double d = r->half[0].mean[i] - r->half[1].mean[i];
            own += truth_variance(r, i);
            difference += d;
            squares += d * d;
            expected += difference_variance(r, i);
        }
    printf("%.0f,%.9g,%.9g,%.9g,%.9g,%.9g\n", r->values, r->norm,
           own / (r->norm * r->norm * r->values),
           sqrt(variance_of_sum(r, truth_variance)) / r->values / r->norm,
           difference / sqrt(variance_of_sum(r, difference_variance)), squares / expected);
}

static bool put_half(FILE *file, const picture_sum *sum)
{
    return fwrite(&sum->pictures, sizeof sum->pictures, 1, file) == 1 &&
           fwrite(sum->mean, sizeof *sum->mean, sum->values, file) == sum->values &&
           fwrite(sum->squares, sizeof *sum->squares, sum->values, file) == sum->values;
}

static bool save_reference(const reference *r, const char *path, rk_error *error)
{
    rk_file file;
    if (!rk_file_begin(&file, path, error))
        return false;
    if (put_half(file.stream, &r->half[0]) && put_half(file.stream, &r->half[1]))
        return rk_file_commit(&file, error);
    rk_file_abort(&file);
    return rk_fail(error, "%.900s: it could not be written: free some space", path);
}

static bool get_half(FILE *file, picture_sum *sum)
{
    return fread(&sum->pictures, sizeof sum->pictures, 1, file) == 1 &&
           fread(sum->mean, sizeof *sum->mean, sum->values, file) == sum->values &&
           fread(sum->squares, sizeof *sum->squares, sum->values, file) == sum->values;
}

/* A file that is missing, or not whole, is made again. */
static bool load_reference(reference *r, const char *path)
{
    FILE *file = fopen(path, "rb");
    bool ok =
        file && get_half(file, &r->half[0]) && get_half(file, &r->half[1]) && fgetc(file) == EOF;
    if (file)
        fclose(file);
    return ok;
}

static bool make_reference(reference *r, rk_driver *driver, char *first, char *second,
                           rk_error *error)
{
    char *options[] = {first, second};
    for (int h = 0; h < 2; h++) {
        job j;
        cost spent;
        memset(r->half[h].mean, 0, r->half[h].values * sizeof *r->half[h].mean);
        memset(r->half[h].squares, 0, r->half[h].values * sizeof *r->half[h].squares);
        r->half[h].pictures = 0;
        if (!read_job(&j, driver, options[h], error) ||
            !render(&r->half[h], &spent, driver, &j, error))
            return false;
    }
    return true;
}

static bool answer_reference(reference *r, rk_driver *driver, char *line, rk_error *error)
{
    char *second = strchr(line, '|'), *first = strchr(line, ' ');
    if (!second || !first || first > second)
        return rk_fail(error,
                       "a reference is a path and two lists of options, with | between them");
    *first++ = *second++ = '\0';
    const char *path = line;
    if (!load_reference(r, path) && !(make_reference(r, driver, first, second, error) &&
                                      weigh(r, error) && save_reference(r, path, error)))
        return false;
    if (!weigh(r, error))
        return false;
    print_reference(r);
    return true;
}

/* --- a picture ------------------------------------------------------------------------------- */

/* Seconds, mean squared error, bias, largest error, rays by kind. */
static void print_picture(const reference *r, const picture_sum *got, const cost *spent)
{
    double squares = 0, sum = 0, worst = 0;
    for (size_t i = 0; i < got->values; i++)
        if (counts(r, i)) {
            double error = got->mean[i] - truth(r, i);
            squares += error * error;
            sum += error;
            worst = fmax(worst, fabs(error));
        }
    const rk_counters *c = &spent->counters;
    printf("%.9g,%.9g,%.9g,%.9g,%llu,%llu,%llu\n", spent->seconds,
           squares / r->values / (r->norm * r->norm), sum / r->values / r->norm, worst / r->norm,
           (unsigned long long)c->primary_rays, (unsigned long long)c->shadow_rays,
           (unsigned long long)c->reflected_rays);
}

static bool answer_picture(const reference *r, rk_driver *driver, char *line, rk_error *error)
{
    job j;
    cost spent;
    picture_sum got;
    if (!read_job(&j, driver, line, error))
        return false;
    if (r->values == 0)
        return rk_fail(error, "a picture needs a reference before it");
    if (!picture_sum_init(&got, r->half[0].values / 3, error))
        return false;
    bool ok = render(&got, &spent, driver, &j, error);
    if (ok)
        print_picture(r, &got, &spent);
    picture_sum_free(&got);
    return ok;
}

/* --- trees ----------------------------------------------------------------------------------- */

/* Seconds to build the tree, and to render with it; leaves, levels, expected cost; tests per camera
 * ray. */
static bool answer_tree(rk_driver *driver, const char *line, rk_error *error)
{
    unsigned leaf;
    if (sscanf(line, "%u", &leaf) != 1 || leaf > RK_BVH_LEAF_MAX)
        return rk_fail(error, "tree: a leaf has 0 to %d triangles", RK_BVH_LEAF_MAX);
    rk_accel_free(&driver->accel);
    double start = rk_clock_thread();
    const rk_accel_options options = {driver->split, driver->bins, NULL};
    if (!rk_accel_build_with(&driver->accel, &options, &driver->scene, error))
        return false;
    double built = rk_clock_thread();
    if (leaf && !(trees_resize_leaves(&driver->accel, leaf, error) &&
                  rk_bvh_validate(&driver->accel.bvh, &driver->scene.mesh, error)))
        return false;
    double begun = rk_clock_thread();
    if (!rk_render(&driver->image, &driver->scene, &driver->accel, &driver->render, driver->pool,
                   &driver->counters, NULL, error))
        return false;
    double rendered = rk_clock_thread();
    const rk_counters *c = &driver->counters;
    rk_bvh_measures measures = rk_bvh_measure(&driver->accel.bvh);
    printf("%.9g,%.9g,%u,%u,%.6g,%.6g,%.6g\n", built - start, rendered - begun, measures.leaves,
           measures.levels, measures.sah_cost, (double)c->box_tests / (double)c->primary_rays,
           (double)c->triangle_tests / (double)c->primary_rays);
    return true;
}

/* --- the program ----------------------------------------------------------------------------- */

/* zsobol has the errors of sobol in single pixels, which are what is measured: its gain shows in
 * their means (assignments/13_sampling). */
static void print_kinds(void)
{
    for (uint32_t kind = 0; kind < rk_sampler_names.count; kind++)
        if (kind != RK_SAMPLER_ZSOBOL)
            printf("%s%s", kind ? "," : "", rk_sampler_names.items[kind]);
    printf("\n");
}

static bool answer(reference *r, rk_driver *driver, char *line, rk_error *error)
{
    if (strncmp(line, "reference ", 10) == 0)
        return answer_reference(r, driver, line + 10, error);
    if (strncmp(line, "picture ", 8) == 0)
        return answer_picture(r, driver, line + 8, error);
    if (strcmp(line, "kinds\n") == 0) {
        print_kinds();
        return true;
    }
    if (strncmp(line, "tree ", 5) == 0)
        return answer_tree(driver, line + 5, error);
    if (strcmp(line, "numbers\n") == 0) {
        numbers_print();
        return true;
    }
    return rk_fail(error, "this is neither reference, picture, kinds, tree nor numbers: %.80s",
                   line);
}

static bool answer_all(rk_driver *driver, rk_error *error)
{
    reference r = {.values = 0};
    size_t pixels = driver->image.width * driver->image.height;
    char line[4096];
    bool ok =
        picture_sum_init(&r.half[0], pixels, error) && picture_sum_init(&r.half[1], pixels, error);
    while (ok && fgets(line, sizeof line, stdin))
        ok = answer(&r, driver, line, error) &&
             (fflush(stdout) == 0 || rk_fail(error, "standard output could not be written"));
    free_reference(&r);
    return ok;
}

int main(int argc, char **argv)
{
    static const rk_driver_spec spec = {
        .feature = "bench",
        .summary = "Measures errors and times of pictures for tools/bench.py, which says which.\n",
    };
    rk_error error = {""};
    rk_driver driver = rk_driver_default(spec.feature, spec.summary);
    rk_driver_set_defaults(&driver, &spec);
    driver.quiet = true;
    rk_options_result result = rk_driver_read_options(&driver, &spec, argc, argv, &error);
    driver.threads = 1; /* a thread's own clock measures all of the work */
    bool ok = result == RK_OPTIONS_OK && rk_driver_start(&driver, &error) &&
              rk_driver_build(&driver, &error) && answer_all(&driver, &error);
    return rk_driver_finish(&driver, ok || result == RK_OPTIONS_DONE, &error);
}
