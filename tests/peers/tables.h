/* What was measured, and the tables that are made of it. */
#ifndef RK_TESTS_PEERS_TABLES_H
#define RK_TESTS_PEERS_TABLES_H

#include "base/table.h"
#include "measure.h"

/* A build or a mode on one workload. */
typedef struct peers_row {
    const char *workload; /* of peers_workload_names, or "build" */
    char scene[64];
    uint32_t triangles;
    const char *engine;
    peers_name mode;
    bool usual; /* raykit's mode that others are compared with */
    uint32_t threads;
    const char *unit; /* "Mrays/s" or "ms" */
    rk_timing timing;
    double bytes; /* of a build; -1: not known */
    peers_differences differences;
} peers_row;

typedef struct peers_rows {
    size_t count, capacity;
    peers_row *items;
} peers_rows;

extern const char peers_build[]; /* "build" */

/* Appends a row. False when memory is short. */
bool peers_rows_put(peers_rows *rows, const peers_row *row, rk_error *error);
void peers_rows_free(peers_rows *rows);

/* raykit's usual mode on the same workload, scene and threads. */
const peers_row *peers_usual(const peers_rows *rows, const peers_row *row);

/* Embree's fastest mode on the workload of `ours`, a usual row; of builds that of medium quality,
 * because others do not build an equal tree. With `robust` only robust modes. NULL: there is none.
 */
const peers_row *peers_best(const peers_rows *rows, const peers_row *ours, bool robust);

/* How many times as fast as Embree raykit is. */
double peers_speed_ratio(const peers_row *ours, const peers_row *theirs);

/* The number of this engine's answers on one thread that differ, by causes from `first` on. */
size_t peers_differing(const peers_rows *rows, const char *engine, peers_cause first);

/* Writes OUT/tables/peers.csv and its companions, whole or not at all. `about` is a list of
 * key, value, key, value, ..., NULL for peers_machine.csv. */
bool peers_tables_write(const peers_rows *rows, const char *out, const char *const *about,
                        rk_error *error);

#endif
