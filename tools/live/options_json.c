/* --help of a live figure's module: the option rows as JSON, from which the page makes its controls
 * (in the place of rk_options_print_help, base/options_words.h). */
#include "base/options_words.h"

#include <math.h>
#include <stdio.h>

void __wrap_rk_options_print_help(const char *program, const char *summary,
                                  const rk_bound_option *options, size_t count);

static void print_text(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            printf("\\%c", *text);
        else if (*text == '\n')
            printf("\\n");
        else
            putchar(*text);
    }
    putchar('"');
}

/* The range and default of a number; null stands for "not given". */
static void print_number(const rk_option *row, double value)
{
    printf(", \"low\": %.9g, \"high\": %.9g, \"value\": ", row->low, row->high);
    if (isnan(value) || value > row->high)
        printf("null");
    else
        printf("%.7g", value);
}

static void print_names(const rk_names *names, uint32_t value)
{
    printf(", \"names\": [");
    for (uint32_t i = 0; i < names->count; i++) {
        printf("%s", i ? ", " : "");
        print_text(names->items[i]);
    }
    printf("], \"value\": ");
    print_text(names->items[value]);
}

static void print_option(rk_bound_option option)
{
    static const char *const kinds[] = {"flag", "uint", "float", "text", "list", "pixel", "choice"};
    const rk_option *row = option.row;
    const char *const *text = option.value;
    printf("\"%s\": {\"kind\": \"%s\", \"help\": ", row->name, kinds[row->kind]);
    print_text(row->help);
    if (row->views) {
        printf(", \"views\": ");
        print_text(row->views);
    }
    if (row->kind == RK_OPTION_FLAG)
        printf(", \"value\": %s", *(const bool *)option.value ? "true" : "false");
    else if (row->kind == RK_OPTION_UINT)
        print_number(row, *(const uint32_t *)option.value);
    else if (row->kind == RK_OPTION_FLOAT)
        print_number(row, (double)*(const float *)option.value);
    else if (row->kind == RK_OPTION_CHOICE)
        print_names(row->names, *(const uint32_t *)option.value);
    else if (row->kind == RK_OPTION_TEXT && *text) {
        printf(", \"value\": ");
        print_text(*text);
    }
    if (row->of_scene)
        printf(", \"of_scene\": true");
    printf("}");
}

void __wrap_rk_options_print_help(const char *program, const char *summary,
                                  const rk_bound_option *options, size_t count)
{
    (void)program;
    (void)summary;
    for (size_t i = 0; i < count; i++) {
        printf("%s", i ? ",\n" : "{");
        print_option(options[i]);
    }
    printf("}\n");
}
