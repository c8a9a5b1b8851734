/* base/table.h in a page: a row is printed, and goes to the page, which has no files (wasm-ld
 * --wrap). */
#include "base/table.h"

#include <stdio.h>

#define IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* A cell of a table's row. */
IMPORT("cell") void raykit_cell(const char *column, const char *text, bool last);

bool __wrap_rk_table_put(const char *path, const char *const *header, const char *const *cells,
                         size_t columns, size_t key_columns, rk_error *error);

/* A row is printed, name by name, and goes to the page cell by cell. */
bool __wrap_rk_table_put(const char *path, const char *const *header, const char *const *cells,
                         size_t columns, size_t key_columns, rk_error *error)
{
    (void)path;
    (void)key_columns;
    (void)error;
    for (size_t i = 0; i < columns; i++) {
        printf("%s%s=%s", i ? ", " : "", header[i], cells[i]);
        raykit_cell(header[i], cells[i], i + 1 == columns);
    }
    printf("\n");
    return true;
}
