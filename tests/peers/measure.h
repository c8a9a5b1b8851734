/* Speed and answers of an engine in one of its modes. */
#ifndef RK_TESTS_PEERS_MEASURE_H
#define RK_TESTS_PEERS_MEASURE_H

#include "base/parallel.h"
#include "difference.h"
#include "engine.h"
#include "rays.h"

/* Memory for each thread, large enough for both engines. */
typedef struct peers_lanes {
    uint32_t count;
    size_t bytes;
    char *memory;
} peers_lanes;

bool peers_lanes_init(peers_lanes *lanes, uint32_t count, peers_engine *const *engines,
                      uint32_t engine_count, rk_error *error);
void peers_lanes_free(peers_lanes *lanes);

typedef struct peers_speed {
    double rate; /* millions of rays per second: the sum of the threads' rates, each by its
                    processor time if it is the only one, else by the wall clock */
    double wall,
        processor; /* seconds of all threads; wall time is longer where other programs ran */
} peers_speed;

/* Traces all rays once. */
peers_speed peers_speed_of(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                           rk_pool *pool, const peers_lanes *lanes);

/* Fills in the answer to each ray. */
void peers_answers(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                   const peers_lanes *lanes, peers_hit *answers);

/* Counts how this mode's answers differ from `answers`, by cause; PEERS_SAME counts the equal ones.
 */
typedef struct peers_differences {
    size_t rays[PEERS_CAUSES];
    peers_largest largest;
} peers_differences;

peers_differences peers_compare(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                                rk_pool *pool, const peers_lanes *lanes, const peers_hit *answers);

void peers_differences_add(peers_differences *to, const peers_differences *from);

/* The number of rays that differ. */
size_t peers_mismatches(const peers_differences *differences);

#endif
