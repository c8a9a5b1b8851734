/* The judge's side of calls to a unit that runs in another process. Stubs, which stand in the
 * unit's place (tools/judge_calls.py writes them), put a call's arguments into a request
 * and take its results from the answer.
 *
 * To wait for each answer would take microseconds for each of millions of calls. So the judge
 * speculates: it goes on with the reference's answers, and compares them with the unit's as these
 * come in. If all are the same to the last bit, its verdict is that of the unit's answers, for the
 * unit's would have led the same way. A fork of it waits where the speculation began: with the
 * first answer that is another one, this fork becomes the judge, and from here on there is a
 * predictor.
 *
 * A predictor, a fork of the judge, runs the test ahead with the reference in the unit's place, and
 * publishes the requests that come of it. The judge takes the answers of those that turn out to be
 * its own. One that was not predicted depends on an answer that is not the reference's; then
 * another predictor begins there, and takes the unit's answers where they are known.
 *
 * The unit's process can read what is published. So a request in which the reference's answers
 * could be read is held until the unit has given these answers itself (held.h). If it has given
 * others, that predictor leaves the request out, and the next one takes the unit's answers.
 * Which requests depend on no answers is said in the files of calls, and checked
 * (tests/judge/trace.c). */
#ifndef RK_TESTS_JUDGE_H
#define RK_TESTS_JUDGE_H

#include "judge/protocol.h"

#include <stdbool.h>
#include <string.h>

/* The request that is being made, and what is left of the answer. */
extern struct rk_judge_call {
    unsigned char *request;
    size_t size, room;
    const unsigned char *answer;
} rk_judge_call;

/* Makes room for so many more bytes, or fails the test. */
void rk_judge_grow(size_t bytes);

/* Begins a request; rk_judge_put adds values to it. */
void rk_judge_ask(int function);

/* Returns where the next value of the request stands until the next call. With no data its bytes
 * are zeros. */
static inline void *rk_judge_put(const void *data, size_t bytes)
{
    size_t begin = rk_judge_call.size, end = begin + rk_judge_aligned(bytes);
    if (end > rk_judge_call.room)
        rk_judge_grow(end);
    rk_judge_call.size = end;
    unsigned char *place = rk_judge_call.request + begin;
    size_t copied = data ? bytes : 0;
    if (copied)
        memcpy(place, data, copied);
    memset(place + copied, 0, end - begin - copied);
    return place;
}

/* Puts whether there is something, and returns it. */
static inline bool rk_judge_put_whether(const void *pointer)
{
    bool is_there = pointer != NULL;
    rk_judge_put(&is_there, sizeof is_there);
    return is_there;
}

/* Puts what a pointer points to, which rk_judge_put_whether has said. Nothing stands behind it. */
static inline void *rk_judge_put_array(const void *data, size_t bytes)
{
    size_t begin = rk_judge_call.size;
    rk_judge_put(data, bytes);
    rk_judge_put(NULL, RK_JUDGE_ALIGNMENT);
    return rk_judge_call.request + begin;
}

/* A piece of an object that is kept: trees, meshes and maps, which many calls read. The first is
 * its structure. */
enum { RK_JUDGE_PIECES = 16 }; /* that an object has at most */
typedef struct rk_judge_piece {
    const void *data;
    size_t bytes;
} rk_judge_piece;

/* Puts the id of an object, which is sent if it is not there yet. `slot` numbers the parameters
 * that take such objects, from 0: to look whether the object is still the same, the last one is
 * kept. The pieces hold until the call has been answered. */
void rk_judge_put_kept(int slot, const rk_judge_piece *pieces, size_t count);

/* For each function a bit for each one whose answers can be read in its requests (all, unless the
 * file of calls says less), and the tests in which it is all nevertheless; the last has none. */
enum { RK_JUDGE_FUNCTIONS = 64 };
typedef struct rk_judge_exception {
    int function;
    const char *test;
} rk_judge_exception;
extern const uint64_t rk_judge_after[RK_JUDGE_FUNCTIONS];
extern const rk_judge_exception rk_judge_exceptions[];

/* Ends the request, and waits for its answer of at most so many bytes; true in the predictor,
 * where the reference gives the results instead. */
bool rk_judge_predicts(size_t bytes_max);

/* A bit for each function whose whole answer is noted below; others are not speculated on. */
extern const uint64_t rk_judge_noted;

/* In the predictor, where the reference has given a result, in the answer's order: returns where to
 * note so many bytes of it, or NULL if nobody will compare the unit's with them. */
void *rk_judge_note(size_t bytes);
void rk_judge_note_allocations(void);

/* In a trace (trace.c): makes an answer wrong. */
void rk_judge_disturb(void *data, size_t bytes);

/* Takes the next value of the answer. */
static inline void rk_judge_get(void *data, size_t bytes)
{
    memcpy(data, rk_judge_call.answer, bytes);
    rk_judge_call.answer += rk_judge_aligned(bytes);
}

/* Takes values that the call has allocated into memory of this process, to be freed by free().
 * Fails the test if they are more than `most`. */
void *rk_judge_get_made(size_t count, size_t most, size_t size);

/* Fails the test: its claim should be one of those with unit and suite in one process. */
_Noreturn void rk_judge_cannot_ask(const char *function);

/* Adds the allocations that the call made to those of this process: the answer's last value. */
void rk_judge_get_allocations(void);

#endif
