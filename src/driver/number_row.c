/* Numbers are written with nine digits, which restore any float to the bit; column names arrive as
 * one text of words. */
#include "driver/number_row.h"

#include <stdio.h>
#include <string.h>

bool rk_driver_number_row(const rk_driver *driver, const char *name, const char *columns,
                          size_t keys, const double *numbers, rk_error *error)
{
    enum { MOST = 12 };
    const char *header[MOST + 2] = {"scene"}, *cells[MOST + 1] = {driver->scene.name};
    char path[4096], names[256], texts[MOST][32];
    size_t count = 0;
    snprintf(names, sizeof names, "%s", columns);
    for (char *name_of = strtok(names, " "); name_of && count < MOST; name_of = strtok(NULL, " ")) {
        snprintf(texts[count], sizeof texts[count], "%.9g", numbers[count]);
        cells[1 + count] = texts[count];
        header[1 + count++] = name_of;
    }
    return rk_driver_table(driver, name, path, error) &&
           rk_table_put(path, header, cells, 1 + count, 1 + keys, error);
}
