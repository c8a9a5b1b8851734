/* Walks a table of rows and finds each field by its offset in the struct: to set its default, or to
 * compare its value with the range. */
#include "base/options_words.h"

#include <math.h>
#include <stdio.h>

/* --- Defaults -------------------------------------------------------------------------------- */

static void set_default(const rk_option *row, void *value)
{
    switch (row->kind) {
    case RK_OPTION_FLAG:
        *(bool *)value = row->initial != 0;
        break;
    case RK_OPTION_UINT:
    case RK_OPTION_CHOICE:
        *(uint32_t *)value = (uint32_t)row->initial;
        break;
    case RK_OPTION_FLOAT:
        *(float *)value = (float)row->initial;
        break;
    case RK_OPTION_TEXT:
        *(const char **)value = row->initial_text;
        break;
    case RK_OPTION_LIST:
        *(rk_text_list *)value = (rk_text_list){0};
        break;
    case RK_OPTION_PIXEL:
        *(rk_pixel *)value = (rk_pixel){0};
        break;
    }
}

void rk_options_set_defaults(const rk_option *rows, void *values)
{
    for (const rk_option *row = rows; row->name; row++)
        set_default(row, (char *)values + row->offset);
}

/* --- Ranges ---------------------------------------------------------------------------------- */

static bool is_in_range(const rk_option *row, double number)
{
    return number >= row->low && number <= row->high;
}

static bool check_uint(const rk_option *row, uint32_t number, rk_error *error)
{
    return is_in_range(row, number) || number == row->initial ||
           rk_fail(error, "the option %s is %u, but it takes %s", row->field, number,
                   rk_option_takes(row).text);
}

static bool check_float(const rk_option *row, float number, rk_error *error)
{
    return is_in_range(row, (double)number) || (isnan(number) && isnan(row->initial)) ||
           rk_fail(error, "the option %s is %g, but it takes %s", row->field, (double)number,
                   rk_option_takes(row).text);
}

static bool check_choice(const rk_option *row, uint32_t value, rk_error *error)
{
    return value < row->names->count ||
           rk_fail(error, "the option %s is %u, but %s goes from 0 to %u", row->field, value,
                   row->names->type, row->names->count - 1);
}

static bool check_value(const rk_option *row, const void *value, rk_error *error)
{
    switch (row->kind) {
    case RK_OPTION_UINT:
        return check_uint(row, *(const uint32_t *)value, error);
    case RK_OPTION_FLOAT:
        return check_float(row, *(const float *)value, error);
    case RK_OPTION_CHOICE:
        return check_choice(row, *(const uint32_t *)value, error);
    case RK_OPTION_FLAG:
    case RK_OPTION_TEXT:
    case RK_OPTION_LIST:
    case RK_OPTION_PIXEL:
        break;
    }
    return true;
}

bool rk_options_check(const rk_option *rows, const void *values, rk_error *error)
{
    for (const rk_option *row = rows; row->name; row++)
        if (!check_value(row, (const char *)values + row->offset, error))
            return false;
    return true;
}
