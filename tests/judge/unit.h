/* The unit's side of a judge's calls: what tools/judge_calls.py writes for each of a unit's
 * functions takes its arguments from the request, and gives its results to the answer. */
#ifndef RK_TESTS_JUDGE_UNIT_H
#define RK_TESTS_JUDGE_UNIT_H

#include "judge/protocol.h"
#include "test.h"

/* The call that is being served: what is left of the request, the answer's end, and how many
 * allocations there were when it began. */
extern struct rk_unit_call {
    const unsigned char *request;
    unsigned char *answer;
    uint64_t made[2];
} rk_unit_call;

/* Returns the next value of the request: memory that cannot be written to. */
static inline const void *rk_unit_take(size_t bytes)
{
    const unsigned char *value = rk_unit_call.request;
    rk_unit_call.request += rk_judge_aligned(bytes);
    return value;
}

/* Takes whether there is a value: a pointer may be NULL. */
static inline bool rk_unit_takes(void)
{
    return *(const bool *)rk_unit_take(sizeof(bool));
}

/* The same for what a pointer points to: the address sanitizer sees what goes beyond it. */
const void *rk_unit_take_array(size_t bytes);

/* Takes an object that is kept: its structure, whose pointers `open` sets, each to what
 * rk_unit_kept_piece returns, in order. It cannot be written to. */
const void *rk_unit_take_kept(size_t bytes, void (*open)(void *structure));
void *rk_unit_kept_piece(size_t bytes);

/* Returns memory of just so many bytes, with these contents, or, where they are NULL, with bytes
 * that are no value. The address sanitizer sees what goes beyond. It holds until the call is
 * answered. */
void *rk_unit_room(const void *contents, size_t bytes);

/* Returns where the answer's next value is to be written. Its bytes are zeros, so that equal values
 * have equal bytes. */
static inline void *rk_unit_give_room(size_t bytes)
{
    void *place = memset(rk_unit_call.answer, 0, rk_judge_aligned(bytes));
    rk_unit_call.answer += rk_judge_aligned(bytes);
    return place;
}

static inline void rk_unit_give(const void *data, size_t bytes)
{
    memcpy(rk_unit_give_room(bytes), data, bytes);
}

/* Gives values that the call has allocated, none if they are too many, and frees them. */
void rk_unit_give_made(void *values, size_t count, size_t most, size_t size);

/* Around the call: counts its allocations, which are the answer's last value. */
static inline void rk_unit_begin_call(void)
{
    rk_unit_call.made[0] = rk_allocations;
    rk_unit_call.made[1] = rk_allocations_kept;
}

static inline void rk_unit_end_call(void)
{
    rk_unit_call.made[0] = rk_allocations - rk_unit_call.made[0];
    rk_unit_call.made[1] = rk_allocations_kept - rk_unit_call.made[1];
}

static inline void rk_unit_give_allocations(void)
{
    rk_unit_give(rk_unit_call.made, sizeof rk_unit_call.made);
}

/* Written for each unit: what serves a request, by the function's number. */
extern void (*const rk_unit_functions[])(void);

#endif
