#include "judge/published.h"
#include "judge/kept.h"
#include "judge/requests.h"

enum { SLOTS = 2 * RK_JUDGE_LAP_REQUESTS };

static uint32_t lap; /* of what follows */

/* Requests that were published, by the hash of their bytes. */
static struct slot {
    uint32_t lap, hash, place;
} slots[SLOTS];
static size_t learnt;                            /* those before it are in the table */
static size_t next_of[RK_JUDGE_FUNCTIONS];       /* where that of a function is expected */
static uint32_t taken_in[RK_JUDGE_LAP_REQUESTS]; /* the lap in which each was taken */

static uint64_t id_at(size_t place)
{
    return ((const rk_judge_kept *)(rk_judge_request_at(place) + 1))->id;
}

static uint32_t hash_of(const rk_judge_request *head)
{
    return (uint32_t)(rk_judge_hash_of_words(head + 1, head->bytes - sizeof *head,
                                             (uint32_t)head->function) >>
                      32);
}

static bool is_open(size_t place)
{
    return taken_in[rk_judge_request_at(place)->number - rk_judge.lap_begin] != rk_judge.lap;
}

static bool is_same(const rk_judge_request *a, const rk_judge_request *b)
{
    return a->function == b->function && a->bytes == b->bytes &&
           memcmp(a + 1, b + 1, a->bytes - sizeof *a) == 0;
}

static void begin_at_front_in_a_new_lap(void)
{
    if (lap == rk_judge.lap)
        return;
    lap = rk_judge.lap;
    learnt = RK_JUDGE_FIRST;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        next_of[i] = RK_JUDGE_FIRST;
}

void rk_judge_skip_published(void)
{
    begin_at_front_in_a_new_lap();
    learnt = rk_judge.end;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        next_of[i] = rk_judge.end;
}

static void learn(size_t place)
{
    uint32_t hash = hash_of(rk_judge_request_at(place)), i = hash % SLOTS;
    while (slots[i].lap == rk_judge.lap && is_open(slots[i].place))
        i = (i + 1) % SLOTS;
    slots[i] = (struct slot){rk_judge.lap, hash, (uint32_t)place};
}

static void learn_all(void)
{
    for (; learnt != rk_judge.end; learnt += rk_judge_request_at(learnt)->span)
        if (rk_judge_request_at(learnt)->function >= 0 && is_open(learnt))
            learn(learnt);
}

/* Looks at the next request that the predictor has published; false if there is none. */
static bool look_at_next(void)
{
    if (rk_judge.lap_is_over ||
        rk_judge.known == atomic_load_explicit(&rk_judge.asked->published, memory_order_acquire))
        return false;
    const rk_judge_request *head = rk_judge_request_at(rk_judge.end);
    rk_judge.known++;
    rk_judge.end += head->span;
    rk_judge.lap_is_over = head->function == RK_JUDGE_FROM_FRONT;
    if (head->function == RK_JUDGE_KEEP)
        rk_judge_object_is_there(id_at(rk_judge.end - head->span), head->span);
    return !rk_judge.lap_is_over;
}

void rk_judge_look_at_all(void)
{
    while (look_at_next()) {
    }
}

/* In most cases it is the next one of its function. */
static bool find_in_order(const rk_judge_request *head, size_t *place)
{
    begin_at_front_in_a_new_lap();
    size_t *next = &next_of[head->function];
    for (;;) {
        if (*next == rk_judge.end && !look_at_next())
            return false;
        const rk_judge_request *request = rk_judge_request_at(*next);
        *place = *next;
        if (request->function == head->function && is_open(*next))
            return is_same(request, head);
        *next += request->span;
    }
}

static bool find_learnt(const rk_judge_request *head, size_t *place)
{
    rk_judge_look_at_all();
    learn_all();
    uint32_t hash = hash_of(head);
    for (uint32_t i = hash % SLOTS; slots[i].lap == rk_judge.lap; i = (i + 1) % SLOTS)
        if (slots[i].hash == hash && is_open(slots[i].place) &&
            is_same(rk_judge_request_at(slots[i].place), head)) {
            *place = slots[i].place;
            return true;
        }
    return false;
}

bool rk_judge_find(const rk_judge_request *head, size_t *place)
{
    if (find_in_order(head, place))
        return true;
    if (rk_judge.lap_is_over &&
        rk_judge.asked->predicted < rk_judge.calls) { /* it waits to go on */
        rk_judge_begin_lap();
        rk_judge_wake(&rk_judge.asked->lap, &rk_judge.asked->predictor_waits);
        return rk_judge_find(head, place);
    }
    return next_of[head->function] != rk_judge.end && find_learnt(head, place);
}

void rk_judge_take(size_t place)
{
    taken_in[rk_judge_request_at(place)->number - rk_judge.lap_begin] = rk_judge.lap;
    rk_judge_call.answer = rk_judge.answered_memory + place;
}
