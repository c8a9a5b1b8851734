#define _DEFAULT_SOURCE /* for MAP_ANONYMOUS, MAP_NORESERVE */
#include "judge/held.h"
#include "base/error.h"
#include "judge/published.h"
#include "judge/requests.h"
#include "judge/speculation.h"
#include "test.h"

#include <sys/mman.h>

enum { BYTES = 4 << 20 };

/* What judge and predictors share, and no unit sees: copies of answers, at their places, and who
 * was first at each request of a lap: twice the lap, and 1 more if a predictor has copied it. */
static unsigned char *copies;
static struct shared {
    _Atomic uint64_t oldest; /* the number of the first call that is held, or more than any */
    _Atomic uint32_t first[RK_JUDGE_LAP_REQUESTS];
} * shared;

static const uint64_t *after;
static uint64_t awaited; /* a bit for each function that others come after */

/* Calls for which the reference has answered. */
static struct call {
    uint32_t function;
    uint32_t next;           /* of this function: its number, or 0 */
    size_t place;            /* of the request, or 0: it is held */
    size_t contents, answer; /* where the request and the answer stand below */
    size_t bytes;            /* of the answer; 0 if it was not noted */
    uint64_t made[2];        /* allocations until the call */
    uint64_t number;         /* of the call in the test */
} calls[1 + RK_JUDGE_HELD_MAX];
static uint32_t count;
static _Alignas(RK_JUDGE_ALIGNMENT) unsigned char contents[BYTES];
static size_t used;

static struct of_function {
    uint32_t last;
    uint32_t held;  /* the first that is held, or 0 */
    uint32_t open;  /* the first that the unit has not answered in the same way */
    uint32_t wrong; /* from here on, its answers are not the unit's, or may be not */
    bool is_wrong;
} of[RK_JUDGE_FUNCTIONS];
static uint64_t used_answers; /* a bit for each function of which the reference's answer was used */

void rk_judge_begin_holding(const uint64_t in_test[RK_JUDGE_FUNCTIONS])
{
    after = in_test;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        awaited |= after[i] == UINT64_MAX ? 0 : after[i];
    int how = MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE;
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, how, -1, 0);
    copies = mmap(NULL, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE, how, -1, 0);
    if (shared == MAP_FAILED || copies == MAP_FAILED) {
        perror("no memory for copies of answers");
        exit(2);
    }
    rk_judge_forget_held();
}

bool rk_judge_can_hold(const rk_judge_request *head)
{
    return 2 * (size_t)head->span <= BYTES;
}

bool rk_judge_may_hold(uint64_t call)
{
    return shared->oldest <= call;
}

void rk_judge_forget_held(void)
{
    shared->oldest = UINT64_MAX;
}

static bool is_awaited(int function)
{
    return (awaited >> function & 1) != 0;
}

/* --- Answers that are taken once --- */

/* Returns whether it is up to this process to take the answer. */
static bool is_first(const rk_judge_request *head, uint32_t mark)
{
    _Atomic uint32_t *first = &shared->first[head->number - rk_judge.lap_begin];
    uint32_t seen = *first;
    return seen / 2 != rk_judge.lap && atomic_compare_exchange_strong(first, &seen, mark);
}

static bool has_copy(const rk_judge_request *head)
{
    return shared->first[head->number - rk_judge.lap_begin] == 2 * rk_judge.lap + 1;
}

void rk_judge_take_answer(size_t place)
{
    const rk_judge_request *head = rk_judge_request_at(place);
    rk_judge_take(place);
    bool may_be_copied = is_awaited(head->function) || rk_judge_was_wrong();
    if (may_be_copied && !is_first(head, 2 * rk_judge.lap) && has_copy(head))
        rk_judge_call.answer = copies + place;
}

static void copy_answer(const struct call *call)
{
    const rk_judge_request *head = rk_judge_request_at(call->place);
    if (has_copy(head))
        return;
    memcpy(copies + call->place, rk_judge.answered_memory + call->place, call->bytes);
    is_first(head, 2 * rk_judge.lap + 1);
}

/* Returns whether the unit has answered as the reference has. Where requests tell of it, and where
 * a speculation ends with it, the answer is copied. */
static bool is_answered_so(const struct call *call)
{
    const unsigned char *want = contents + call->answer;
    if (call->bytes == 0)
        return false;
    if (!is_awaited((int)call->function) &&
        memcmp(rk_judge.answered_memory + call->place, want, call->bytes) == 0)
        return true;
    copy_answer(call);
    return memcmp(copies + call->place, want, call->bytes) == 0;
}

/* --- What the predictor has asked --- */

static void begin_wrong(int function, uint32_t from)
{
    if (rk_judge.speculates)
        rk_judge_retreat();
    if (!of[function].is_wrong || from < of[function].wrong)
        of[function].wrong = from;
    of[function].is_wrong = true;
}

rk_judge_way rk_judge_way_of(const rk_judge_request *head)
{
    uint64_t told = after[head->function] & used_answers;
    if (told && after[head->function] == UINT64_MAX)
        return RK_JUDGE_LEAVE_OUT;
    rk_judge_way way = RK_JUDGE_PUBLISH;
    for (int i = 0; told >> i != 0 && i < RK_JUDGE_FUNCTIONS; i++) {
        if ((told >> i & 1) == 0)
            continue;
        if (of[i].is_wrong)
            return RK_JUDGE_LEAVE_OUT;
        if (of[i].open)
            way = RK_JUDGE_HOLD;
    }
    return way;
}

bool rk_judge_holds_all(const rk_judge_request *head)
{
    return count == RK_JUDGE_HELD_MAX || used + 2 * (size_t)head->span > BYTES;
}

static struct call *last_call; /* if its answer is to be noted */

void rk_judge_hold(const rk_judge_request *head, rk_judge_way way, size_t place)
{
    int function = head->function;
    used_answers |= UINT64_C(1) << function;
    last_call = NULL;
    if (way == RK_JUDGE_LEAVE_OUT)
        begin_wrong(function, count + 1);
    bool is_compared = is_awaited(function) || rk_judge.speculates;
    if (way == RK_JUDGE_LEAVE_OUT || (way == RK_JUDGE_PUBLISH && !is_compared))
        return;
    rk_check(!rk_judge_holds_all(head), "a call is too large to be held");
    struct of_function *it = &of[function];
    struct call *call = &calls[++count];
    *call =
        (struct call){.function = (uint32_t)function, .contents = used, .number = rk_judge.calls};
    call->place = way == RK_JUDGE_HOLD ? 0 : place;
    if (way == RK_JUDGE_HOLD) {
        memcpy(contents + used, head, head->bytes);
        used += head->span;
        if (call->number < shared->oldest)
            shared->oldest = call->number;
        it->held = it->held ? it->held : count;
    }
    call->answer = used;
    call->made[0] = rk_allocations;
    call->made[1] = rk_allocations_kept;
    if (it->last)
        calls[it->last].next = count;
    it->last = count;
    it->open = it->open ? it->open : count;
    last_call = is_compared ? call : NULL;
}

void *rk_judge_note(size_t bytes)
{
    if (!last_call)
        return NULL;
    unsigned char *place = contents + last_call->answer + last_call->bytes;
    last_call->bytes += rk_judge_aligned(bytes);
    memset(place, 0, rk_judge_aligned(bytes));
    return place;
}

void rk_judge_note_allocations(void)
{
    if (!last_call)
        return;
    const uint64_t made[2] = {rk_allocations - last_call->made[0],
                              rk_allocations_kept - last_call->made[1]};
    memcpy(rk_judge_note(sizeof made), made, sizeof made);
    used = last_call->answer + last_call->bytes;
    last_call = NULL;
}

/* --- What the unit has answered --- */

/* The word that the unit's process writes is read where it may tell something new. */
static bool is_answered(uint32_t number)
{
    static uint32_t answered;
    if ((int32_t)(answered - number) <= 0)
        answered = atomic_load_explicit(&rk_judge.answered->answered, memory_order_acquire);
    return (int32_t)(answered - number) > 0;
}

static bool compare(struct of_function *it)
{
    uint32_t before = it->open;
    for (; it->open && calls[it->open].place; it->open = calls[it->open].next) {
        const struct call *call = &calls[it->open];
        bool is_compared = is_awaited((int)call->function) || rk_judge.speculates;
        if (!is_compared || (it->is_wrong && it->wrong <= it->open))
            continue;
        if (!is_answered(rk_judge_request_at(call->place)->number))
            break;
        if (!is_answered_so(call))
            begin_wrong((int)call->function, it->open);
    }
    return it->open != before;
}

/* What the unit may be asked: nothing where it has answered in another way than the reference. */
static rk_judge_way way_of_held(uint32_t number)
{
    rk_judge_way way = RK_JUDGE_PUBLISH;
    uint64_t told = after[calls[number].function];
    for (int i = 0; told >> i != 0 && i < RK_JUDGE_FUNCTIONS; i++) {
        if ((told >> i & 1) == 0)
            continue;
        if (of[i].is_wrong && of[i].wrong < number)
            return RK_JUDGE_LEAVE_OUT;
        if (of[i].open && of[i].open < number)
            way = RK_JUDGE_HOLD;
    }
    return way;
}

static bool publish_held(struct of_function *it)
{
    uint32_t before = it->held;
    while (it->held) {
        struct call *call = &calls[it->held];
        rk_judge_way way = way_of_held(it->held);
        if (way == RK_JUDGE_HOLD)
            break;
        rk_judge_request *head = (rk_judge_request *)(contents + call->contents);
        if (way == RK_JUDGE_LEAVE_OUT)
            begin_wrong(head->function, it->held);
        else
            rk_judge_publish(head, head->bytes);
        call->place = rk_judge.end - head->span; /* what is wrong is not looked at */
        if (way == RK_JUDGE_PUBLISH)
            rk_judge_take(call->place);
        do
            it->held = calls[it->held].next;
        while (it->held && calls[it->held].place);
    }
    return it->held != before;
}

void rk_judge_settle(void)
{
    if (count == 0)
        return;
    for (bool is_more = true; is_more;) {
        is_more = false;
        for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
            if (of[i].last) {
                bool is_compared = compare(&of[i]);
                is_more = publish_held(&of[i]) || is_compared || is_more;
            }
    }
    uint64_t oldest = UINT64_MAX;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        if (of[i].held && calls[of[i].held].number < oldest)
            oldest = calls[of[i].held].number;
    shared->oldest = oldest;
    rk_judge_wake_readers();
}

static bool is_settled(void)
{
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        if (of[i].open)
            return false;
    return true;
}

void rk_judge_settle_all(void)
{
    for (rk_judge_settle(); !is_settled(); rk_judge_settle())
        rk_judge_wait_for_answer(rk_judge.known - 1);
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        of[i] = (struct of_function){.is_wrong = of[i].is_wrong};
    count = 0;
    used = 0;
    if (rk_judge.speculates)
        used_answers = 0; /* they are the unit's own */
}
