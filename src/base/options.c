/* Turns tables of options into the table of getopt_long, and checks its results, so that each error
 * message is one sentence of ours. */
#include "base/options_words.h"
#include "base/plain_numbers.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef PACKAGE_VERSION
#define PACKAGE_VERSION "(unknown version)"
#endif

/* Results of getopt_long: these, or first_option + the option's number; all above the characters
 * that it returns itself. */
enum { ask_help = 1000, ask_version, first_option };

/* All tables in one, twice: as ours, and as getopt_long's, which also lists aliases. */
typedef struct option_list {
    size_t count;
    rk_bound_option *options; /* count */
    size_t getopt_count;
    struct option *getopt; /* options, their aliases, help, version, and a zeroed end */
} option_list;

static size_t count_rows(const rk_option_table *tables, size_t table_count)
{
    size_t count = 0;
    for (size_t t = 0; t < table_count; t++)
        for (const rk_option *row = tables[t].rows; row->name; row++)
            count++;
    return count;
}

static void add_spelling(option_list *list, const char *name, int has_argument, int answer)
{
    list->getopt[list->getopt_count++] = (struct option){name, has_argument, NULL, answer};
}

static void add_option(option_list *list, const rk_option *row, void *values)
{
    int has_argument = row->kind == RK_OPTION_FLAG ? no_argument : required_argument;
    int answer = first_option + (int)list->count;
    add_spelling(list, row->name, has_argument, answer);
    if (row->alias)
        add_spelling(list, row->alias, has_argument, answer);
    list->options[list->count++] = (rk_bound_option){row, (char *)values + row->offset};
}

static bool option_list_init(option_list *list, const rk_option_table *tables, size_t table_count,
                             rk_error *error)
{
    size_t rows = count_rows(tables, table_count);
    *list = (option_list){0};
    list->options = rk_allocate(rows, sizeof *list->options, "options", error);
    list->getopt = rk_allocate(2 * rows + 3, sizeof *list->getopt, "options", error);
    if (!list->options || !list->getopt)
        return false;
    for (size_t t = 0; t < table_count; t++)
        for (const rk_option *row = tables[t].rows; row->name; row++)
            add_option(list, row, tables[t].values);
    add_spelling(list, "help", no_argument, ask_help);
    add_spelling(list, "version", no_argument, ask_version);
    return true;
}

static void option_list_free(option_list *list)
{
    free(list->options);
    free(list->getopt);
}

/* --- reading values -------------------------------------------------------------------------- */

/* Reads decimal digits, and moves *text past them. strtoul alone would accept " -1" as 2^64 - 1. */
static bool read_digits(const char **text, uint32_t *value)
{
    if (!isdigit((unsigned char)**text))
        return false;
    char *end;
    unsigned long long number = strtoull(*text, &end, 10);
    if (number > UINT32_MAX)
        return false;
    *text = end;
    *value = (uint32_t)number;
    return true;
}

static bool read_uint(const rk_option *row, const char *text, uint32_t *to)
{
    uint32_t value;
    if (!read_digits(&text, &value) || *text)
        return false;
    if (!(value >= row->low && value <= row->high))
        return false;
    *to = value;
    return true;
}

static bool read_float(const rk_option *row, const char *text, float *to)
{
    if (isspace((unsigned char)*text))
        return false;
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end)
        return false;
    if (!(value >= row->low && value <= row->high)) /* false for NaN */
        return false;
    /* Infinity only by name: 1e39 overflows a float. */
    if (isinf((float)value) && strpbrk(text, "0123456789"))
        return false;
    *to = (float)value;
    return true;
}

static bool read_pixel(const char *text, rk_pixel *to)
{
    uint32_t x, y;
    if (!read_digits(&text, &x) || *text++ != ',' || !read_digits(&text, &y) || *text)
        return false;
    *to = (rk_pixel){true, x, y};
    return true;
}

static bool read_choice(const rk_names *names, const char *text, uint32_t *to)
{
    for (uint32_t value = 0; value < names->count; value++)
        if (strcmp(text, names->items[value]) == 0) {
            *to = value;
            return true;
        }
    return false;
}

static bool add_to_list(const char *spelling, const char *text, rk_text_list *list, rk_error *error)
{
    if (list->count == RK_TEXT_LIST_MAX)
        return rk_fail(error, "--%s: given more than %d times; see --help", spelling,
                       RK_TEXT_LIST_MAX);
    list->items[list->count++] = text;
    return true;
}

static bool read_value(rk_bound_option option, const char *spelling, const char *text,
                       rk_error *error)
{
    bool good = true;
    switch (option.row->kind) {
    case RK_OPTION_FLAG:
        *(bool *)option.value = true;
        break;
    case RK_OPTION_UINT:
        good = read_uint(option.row, text, option.value);
        break;
    case RK_OPTION_FLOAT:
        good = read_float(option.row, text, option.value);
        break;
    case RK_OPTION_PIXEL:
        good = read_pixel(text, option.value);
        break;
    case RK_OPTION_CHOICE:
        good = read_choice(option.row->names, text, option.value);
        break;
    case RK_OPTION_TEXT:
        *(const char **)option.value = text;
        break;
    case RK_OPTION_LIST:
        return add_to_list(spelling, text, option.value, error);
    }
    return good || rk_fail(error, "--%s %.80s: it takes %s; see --help", spelling, text,
                           rk_option_takes(option.row).text);
}

/* --- reading argv ---------------------------------------------------------------------------- */

/* getopt_long keeps its position in globals; this resets it, and silences its messages. */
static void restart_getopt(void)
{
    optind = 0; /* not 1: glibc and musl then also reset the position within an argument */
    opterr = 0;
}

/* "+": stop at the first word that is no option; ":": distinguish a missing value from an unknown
 * option. */
static int next_option(int argc, char **argv, const option_list *list)
{
    return getopt_long(argc, argv, "+:h", list->getopt, NULL);
}

/* Looks for --help and --version alone: help shows the defaults, so it is printed before any value
 * is stored, even if another option is mistyped. */
static int find_request(int argc, char **argv, const option_list *list)
{
    restart_getopt();
    for (int answer; (answer = next_option(argc, argv, list)) != -1;)
        if (answer == 'h' || answer == ask_help || answer == ask_version)
            return answer == 'h' ? ask_help : answer;
    return 0;
}

static bool is_ambiguous(const char *argument, const option_list *list)
{
    size_t length = strncmp(argument, "--", 2) == 0 ? strcspn(argument + 2, "=") : 0;
    size_t matches = 0;
    for (const struct option *option = list->getopt; length && option->name; option++)
        matches += strncmp(option->name, argument + 2, length) == 0;
    return matches > 1;
}

/* The name or the alias that was typed, perhaps in part. */
static const char *spelling_of(int answer, const char *argument, const option_list *list)
{
    const char *name = list->options[answer - first_option].row->name;
    size_t length = strncmp(argument, "--", 2) == 0 ? strcspn(argument + 2, "=") : 0;
    for (const struct option *option = list->getopt; length && option->name; option++)
        if (option->val == answer && strncmp(option->name, argument + 2, length) == 0)
            return option->name;
    return name;
}

static bool refuse(char answer, const char *argument, const option_list *list, rk_error *error)
{
    const rk_option *option =
        optopt >= first_option ? list->options[optopt - first_option].row : NULL;
    if (answer == ':' && option)
        return rk_fail(error, "--%s: the value is missing: it takes %s; see --help",
                       spelling_of(optopt, argument, list), rk_option_takes(option).text);
    if (option || optopt == ask_help || optopt == ask_version)
        return rk_fail(error, "%.80s: this option takes no value; see --help", argument);
    if (is_ambiguous(argument, list))
        return rk_fail(error, "%.80s: stands for more than one option: write it out; see --help",
                       argument);
    return rk_fail(error, "%.80s: there is no such option; see --help", argument);
}

static bool read_all(int argc, char **argv, const option_list *list, rk_error *error)
{
    restart_getopt();
    for (;;) {
        /* Within -xyz getopt stays at the same argument, so remember it before each step. */
        const char *argument = argv[optind ? optind : 1];
        int answer = next_option(argc, argv, list);
        if (answer == -1)
            break;
        if (answer == '?' || answer == ':')
            return refuse((char)answer, argument, list, error);
        if (!read_value(list->options[answer - first_option], spelling_of(answer, argument, list),
                        optarg, error))
            return false;
    }
    if (optind < argc)
        return rk_fail(
            error, "unexpected argument %.80s: it follows no option that takes a value; see --help",
            argv[optind]);
    return true;
}

static rk_options_result finish_printing(rk_error *error)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout))
        return RK_OPTIONS_DONE;
    rk_fail(error, "standard output cannot be written: %s",
            errno ? strerror(errno) : "write error");
    return RK_OPTIONS_BAD;
}

static bool is_spelled(const char *name, const char *text, size_t length)
{
    return name && strlen(name) == length && strncmp(name, text, length) == 0;
}

const rk_option *rk_options_find(const rk_option_table *tables, size_t table_count,
                                 const char *argument)
{
    if (strncmp(argument, "--", 2) != 0)
        return NULL;
    const char *name = argument + 2;
    size_t length = strcspn(name, "=");
    for (size_t t = 0; t < table_count; t++)
        for (const rk_option *row = tables[t].rows; row->name; row++)
            if (is_spelled(row->name, name, length) || is_spelled(row->alias, name, length))
                return row;
    return NULL;
}

static rk_options_result parse(int argc, char **argv, const char *summary,
                               const rk_option_table *tables, size_t table_count, rk_error *error)
{
    option_list list;
    rk_options_result result = RK_OPTIONS_BAD;
    if (!option_list_init(&list, tables, table_count, error)) {
        option_list_free(&list);
        return result;
    }
    int request = find_request(argc, argv, &list);
    if (request == ask_help)
        rk_options_print_help(argc > 0 ? argv[0] : "raykit", summary, list.options, list.count);
    if (request == ask_version)
        printf("raykit %s\n", PACKAGE_VERSION);
    if (request)
        result = finish_printing(error);
    else if (read_all(argc, argv, &list, error))
        result = RK_OPTIONS_OK;
    option_list_free(&list);
    return result;
}

rk_options_result rk_options_parse(int argc, char **argv, const char *summary,
                                   const rk_option_table *tables, size_t table_count,
                                   rk_error *error)
{
    rk_plain_numbers plain = rk_plain_numbers_begin();
    rk_options_result result = parse(argc, argv, summary, tables, table_count, error);
    rk_plain_numbers_end(plain);
    return result;
}
