/* The command line for captions (driver/driver_options.h): without folders, in present spelling. */
#include "driver/driver_options.h"

#include <string.h>

/* Appends to the caption's command line, truncated to its size. */
static void note(rk_driver *driver, const char *text, size_t length)
{
    size_t used = strlen(driver->parameters), room = sizeof driver->parameters - 1 - used;
    length = length < room ? length : room;
    memcpy(driver->parameters + used, text, length);
    driver->parameters[used + length] = '\0';
}

/* The name in its present spelling, if the argument is not an abbreviation. */
static void note_name(rk_driver *driver, const rk_driver_tables *all, const char *argument,
                      size_t length)
{
    const rk_option *row = rk_options_find(all->tables, all->count, argument);
    note(driver, row ? "--" : argument, row ? 2 : length);
    if (row)
        note(driver, row->name, strlen(row->name));
}

/* File names without folders: captions must not reveal the machine's. */
static void note_value(rk_driver *driver, const char *value, bool is_out)
{
    const char *slash = strrchr(value, '/');
    const char *shown = is_out ? "DIR" : slash ? slash + 1 : value;
    note(driver, shown, strlen(shown));
}

/* --name, --name=value, or the value of the argument before it. */
static void note_argument(rk_driver *driver, const rk_driver_tables *all, const char *argument,
                          bool after_out)
{
    size_t name = strncmp(argument, "--", 2) == 0 ? strcspn(argument, "=") : 0;
    if (name > 0)
        note_name(driver, all, argument, name);
    if (argument[name] == '=')
        note(driver, "=", 1);
    if (argument[name])
        note_value(driver, argument + name + (argument[name] == '='),
                   after_out || (name == 5 && strncmp(argument, "--out", 5) == 0));
}

void rk_driver_note_command(rk_driver *driver, const rk_driver_tables *all)
{
    bool after_out = false;
    for (char **argument = driver->argv; *argument; argument++) {
        note(driver, " ", argument > driver->argv);
        note_argument(driver, all, *argument, after_out);
        after_out = strcmp(*argument, "--out") == 0;
    }
}
