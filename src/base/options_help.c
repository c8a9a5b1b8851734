/* Option values in words, and --help: the second half of base/options_words.h. */
#include "base/options_words.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* --- values in words -------------------------------------------------------------------------- */

rk_phrase rk_names_list(const rk_names *names)
{
    rk_phrase list = {""};
    for (uint32_t i = 0; i < names->count; i++) {
        strncat(list.text, i ? "|" : "", sizeof list.text - strlen(list.text) - 1);
        strncat(list.text, names->items[i], sizeof list.text - strlen(list.text) - 1);
    }
    return list;
}

rk_phrase rk_option_range(const rk_option *option)
{
    rk_phrase range = {""};
    bool whole = option->kind == RK_OPTION_UINT;
    bool above = whole || option->low > -(double)FLT_MAX;
    bool below = whole || option->high < (double)FLT_MAX;
    int digits = whole ? 10 : 7; /* all of a uint32_t; what a float holds */
    if (above && below)
        snprintf(range.text, sizeof range.text, "%.*g to %.*g", digits, option->low, digits,
                 option->high);
    else if (above)
        snprintf(range.text, sizeof range.text, "%.*g or more", digits, option->low);
    else if (below)
        snprintf(range.text, sizeof range.text, "up to %.*g", digits, option->high);
    return range;
}

rk_phrase rk_option_takes(const rk_option *option)
{
    rk_phrase takes = {"no value"}, range = rk_option_range(option);
    const char *comma = *range.text ? ", " : "";
    switch (option->kind) {
    case RK_OPTION_FLAG:
        break;
    case RK_OPTION_UINT:
        snprintf(takes.text, sizeof takes.text, "a whole number%s%.80s", comma, range.text);
        break;
    case RK_OPTION_FLOAT:
        snprintf(takes.text, sizeof takes.text, "a number%s%.80s", comma, range.text);
        break;
    case RK_OPTION_PIXEL:
        snprintf(takes.text, sizeof takes.text,
                 "a pixel's column and row from the top left as X,Y (such as 3,4)");
        break;
    case RK_OPTION_CHOICE:
        snprintf(takes.text, sizeof takes.text, "one of %.140s", rk_names_list(option->names).text);
        break;
    case RK_OPTION_TEXT:
    case RK_OPTION_LIST:
        snprintf(takes.text, sizeof takes.text, "a value (%.60s)",
                 option->argument ? option->argument : "text");
        break;
    }
    return takes;
}

/* --- --help ---------------------------------------------------------------------------------- */

enum { columns = 80, help_column = 24 };

static size_t width_of(const char *text, size_t bytes)
{
    size_t width = 0;
    for (size_t i = 0; i < bytes; i++)
        width += ((unsigned char)text[i] & 0xC0) != 0x80; /* UTF-8: not a continuation byte */
    return width;
}

/* Prints words from `column` on, where the cursor is; further lines begin at `indent`. Several
 * spaces between two words are kept, and wrapped words after them are aligned with the first: so a
 * text may hold a list of names and descriptions. Returns the column after the last word. */
static size_t print_wrapped(const char *text, size_t column, size_t indent)
{
    bool line_begins = column <= indent;
    size_t hanging = indent;
    while (*text) {
        size_t spaces = strspn(text, " ");
        text += spaces;
        size_t bytes = strcspn(text, " \n"), width = width_of(text, bytes);
        if (bytes) {
            size_t between = spaces > 1 ? spaces : 1;
            if (spaces > 1 && !line_begins)
                hanging = column + between;
            if (!line_begins && column + between + width > columns) {
                putchar('\n');
                column = 0;
                line_begins = true;
            }
            size_t gap = line_begins ? (column < hanging ? hanging - column : 0) : between;
            printf("%*s%.*s", (int)gap, "", (int)bytes, text);
            column += gap + width;
            line_begins = false;
        }
        text += bytes;
        if (*text == '\n') {
            putchar('\n');
            column = 0;
            line_begins = true;
            hanging = indent;
            text++;
        }
    }
    return column;
}

static rk_phrase default_of(rk_bound_option option)
{
    rk_phrase value = {""};
    const rk_text_list *list = option.value;
    const rk_pixel *pixel = option.value;
    const char *text;
    switch (option.row->kind) {
    /* A number out of range means "not given": the help says what happens then. */
    case RK_OPTION_UINT:
        if ((double)*(uint32_t *)option.value <= option.row->high)
            snprintf(value.text, sizeof value.text, "%u", (unsigned)*(uint32_t *)option.value);
        break;
    case RK_OPTION_FLOAT:
        if (!isnan(*(float *)option.value))
            snprintf(value.text, sizeof value.text, "%g", (double)*(float *)option.value);
        break;
    case RK_OPTION_CHOICE:
        text = option.row->names->items[*(uint32_t *)option.value];
        snprintf(value.text, sizeof value.text, "%.120s", text);
        break;
    case RK_OPTION_TEXT:
        text = *(const char **)option.value;
        snprintf(value.text, sizeof value.text, "%.120s", text ? text : "");
        break;
    case RK_OPTION_LIST:
        snprintf(value.text, sizeof value.text, "%.120s", list->count ? list->items[0] : "");
        break;
    case RK_OPTION_PIXEL:
        if (pixel->given)
            snprintf(value.text, sizeof value.text, "%u,%u", pixel->x, pixel->y);
        break;
    case RK_OPTION_FLAG:
        break;
    }
    return value;
}

/* The range, unless it is merely that of 32 bits. */
static rk_phrase range_worth_showing(const rk_option *option)
{
    if (option->kind == RK_OPTION_FLOAT)
        return rk_option_range(option);
    rk_phrase range = {""};
    if (option->kind != RK_OPTION_UINT)
        return range;
    if (option->high < UINT32_MAX - 1) /* the very last may mean "not given" */
        return rk_option_range(option);
    if (option->low > 0)
        snprintf(range.text, sizeof range.text, "%.10g or more", option->low);
    return range;
}

/* Prints a note after the text, or on a line of its own if it does not fit or the text ends with a
 * newline. */
static void print_whole(const char *note, size_t column)
{
    if (column == 0)
        printf("%*s%s", (int)help_column, "", note);
    else if (column + 1 + strlen(note) > columns)
        printf("\n%*s%s", (int)help_column, "", note);
    else
        printf(" %s", note);
}

/* Returns the column after it. */
static size_t print_name(const rk_option *option)
{
    size_t column = (size_t)printf("  --%s", option->name);
    if (option->kind == RK_OPTION_CHOICE)
        column += (size_t)printf(" %s", rk_names_list(option->names).text);
    else if (option->argument && option->kind != RK_OPTION_FLAG)
        column += (size_t)printf(" %s", option->argument);
    return column;
}

/* "(1 to 64; default 16)", or as much of it as there is. */
static rk_phrase note_of(rk_bound_option option)
{
    rk_phrase range = range_worth_showing(option.row), value = default_of(option), note = {""};
    if (*range.text && *value.text)
        snprintf(note.text, sizeof note.text, "(%.60s; default %.80s)", range.text, value.text);
    else if (*range.text)
        snprintf(note.text, sizeof note.text, "(%.80s)", range.text);
    else if (*value.text)
        snprintf(note.text, sizeof note.text, "(default %.120s)", value.text);
    return note;
}

static void print_option(rk_bound_option option)
{
    size_t column = print_name(option.row);
    if (column + 2 > help_column) {
        putchar('\n');
        column = 0;
    }
    column = print_wrapped(option.row->help, column, help_column);
    rk_phrase note = note_of(option);
    if (*note.text)
        print_whole(note.text, column);
    putchar('\n');
}

void rk_options_print_help(const char *program, const char *summary, const rk_bound_option *options,
                           size_t count)
{
    bool unset = false;
    const rk_option help = {.name = "help", .help = "this text"};
    const rk_option version = {.name = "version", .help = "the version"};
    const char *slash = strrchr(program, '/');
    printf("usage: %s [OPTION]...\n", slash ? slash + 1 : program);
    print_wrapped(summary, 0, 0);
    printf("\n\n");
    for (size_t i = 0; i < count; i++)
        print_option(options[i]);
    print_option((rk_bound_option){&help, &unset});
    print_option((rk_bound_option){&version, &unset});
}
