/* Between a judge, which runs a suite, and the process that runs the unit: two pieces of memory.
 * The judge writes requests to one, which the unit's process can only read; that process writes
 * answers to the other, which the judge can only read. A request and its answer have the same
 * place, so that no side needs to know of the other's. */
#ifndef RK_TESTS_JUDGE_PROTOCOL_H
#define RK_TESTS_JUDGE_PROTOCOL_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

enum {
    RK_JUDGE_BYTES = 256 << 20, /* of either memory; only pages that are used exist */
    RK_JUDGE_FIRST = 4096,      /* the place of the first request; before it are the heads below */
    RK_JUDGE_ALIGNMENT = 16,    /* of all values in requests and answers */
    RK_JUDGE_RUN = 16,        /* requests or answers that are counted at once where more follow: */
                              /* memory in which processes count moves from core to core */
    RK_JUDGE_BATCH = 256,     /* of them, after so many a reader that sleeps is woken */
    RK_JUDGE_FROM_FRONT = -1, /* in place of a function: the next request is the first again */
    RK_JUDGE_KEEP = -2,       /* the same: an object that later calls name by its id */
    RK_JUDGE_KEPT_ALIGNMENT = 64,
    RK_JUDGE_KEPT_MAX = 1 << 14, /* objects in a lap */
    RK_JUDGE_LEAKS = 23,         /* exit status of the unit's process: memory was lost */
};

/* Where the unit's process has requests, and memory for what it writes to: in every run the same,
 * so that a sanitizer's report tells which of them it is (tools/grading/verdicts.py). */
#define RK_JUDGE_PLACE 0x500000000000
#define RK_JUDGE_ROOMS 0x510000000000
#define RK_JUDGE_OBJECTS 0x520000000000

typedef enum rk_judge_end {
    RK_JUDGE_END_OF_CLAIM = 1, /* others follow, from the front */
    RK_JUDGE_END,
} rk_judge_end;

/* The judge's side. */
typedef struct rk_judge_asked {
    _Atomic uint32_t published; /* requests so far, by the judge or a predictor in its place */
    _Atomic uint32_t lap;       /* how often the judge has begun at the front */
    _Atomic uint32_t ended;     /* no more will come: an rk_judge_end, or 0 */
    _Atomic uint32_t claims;    /* that have ended, of several */
    _Atomic uint32_t predictor_ends;
    _Atomic uint32_t is_waiting, predictor_waits;
    _Atomic uint64_t predicted; /* calls that the predictor has made */
} rk_judge_asked;

/* The side of the unit's process. */
typedef struct rk_judge_answered {
    _Atomic uint32_t answered;
    _Atomic uint32_t is_waiting;
    _Atomic uint32_t claims; /* whose end was seen */
} rk_judge_answered;

typedef struct rk_judge_request {
    int32_t function;
    uint32_t bytes; /* of this and the values */
    uint32_t span;  /* to the next request; the answer fits, too */
    uint32_t number;
} rk_judge_request;

/* What follows the head of RK_JUDGE_KEEP; the object begins at the next RK_JUDGE_KEPT_ALIGNMENT. */
typedef struct rk_judge_kept {
    uint64_t id;
    uint64_t bytes;
    unsigned char unused[RK_JUDGE_KEPT_ALIGNMENT - 32]; /* with the head, 64 bytes */
} rk_judge_kept;

static inline size_t rk_judge_kept_aligned(size_t bytes)
{
    return (bytes + RK_JUDGE_KEPT_ALIGNMENT - 1) / RK_JUDGE_KEPT_ALIGNMENT *
           RK_JUDGE_KEPT_ALIGNMENT;
}

static inline size_t rk_judge_aligned(size_t bytes)
{
    return (bytes + RK_JUDGE_ALIGNMENT - 1) / RK_JUDGE_ALIGNMENT * RK_JUDGE_ALIGNMENT;
}

/* Waits a while for *word to be another value than `seen`; may return early. While
 * it sleeps, *is_waiting is one more. */
void rk_judge_wait(const _Atomic uint32_t *word, uint32_t seen, _Atomic uint32_t *is_waiting);

/* Wakes who waits for the word. */
void rk_judge_wake(const _Atomic uint32_t *word, const _Atomic uint32_t *is_waiting);

#endif
