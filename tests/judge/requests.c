#include "judge/requests.h"
#include "base/error.h"
#include "judge/kept.h"
#include "test.h"

#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MAPPED_BYTES = 1 << 20 }; /* at once */

struct rk_judge rk_judge = {.end = RK_JUDGE_FIRST};
struct rk_judge_call rk_judge_call;

static size_t own_made, own_kept;

void rk_judge_begin_own_memory(void)
{
    own_made = rk_allocations;
    own_kept = rk_allocations_kept;
}

void rk_judge_end_own_memory(void)
{
    rk_allocations = own_made;
    rk_allocations_kept = own_kept;
}

void rk_judge_grow(size_t bytes)
{
    size_t room = 2 * bytes > 65536 ? 2 * bytes : 65536;
    rk_judge_begin_own_memory();
    unsigned char *request = realloc(rk_judge_call.request, room);
    rk_judge_end_own_memory();
    rk_check(request, "no memory for a request of %zu bytes", bytes);
    rk_judge_call.request = request;
    rk_judge_call.room = room;
}

/* --- Waiting --- */

static void count_published(void)
{
    atomic_store_explicit(&rk_judge.asked->published, rk_judge.known, memory_order_release);
}

void rk_judge_wake_readers(void)
{
    if (rk_judge.speculates)
        count_published();
    rk_judge_wake(&rk_judge.asked->published, &rk_judge.answered->is_waiting);
    rk_judge_wake(&rk_judge.asked->published, &rk_judge.asked->is_waiting);
}

bool rk_judge_unit_has_ended(void)
{
    struct pollfd pipe = {.fd = rk_judge.unit, .events = POLLIN};
    return poll(&pipe, 1, 0) > 0;
}

void rk_judge_wait_for_answer(uint32_t number)
{
    for (uint32_t answered;
         answered = rk_judge.answered->answered, !rk_judge_is_answered(number);) {
        rk_judge_wait(&rk_judge.answered->answered, answered, &rk_judge.asked->is_waiting);
        if (rk_judge.answered->answered == answered && rk_judge_unit_has_ended())
            rk_claim_failed(__FILE__, __LINE__,
                            "the code ended the program in the middle of the test: does it call "
                            "exit, or _Exit?");
    }
}

/* --- Laps --- */

void rk_judge_begin_lap(void)
{
    rk_judge_wait_for_answer(rk_judge.known - 1);
    rk_judge.lap++;
    if (!rk_judge.predicts || rk_judge.speculates)
        rk_judge.asked->lap = rk_judge.lap;
    rk_judge.lap_begin = rk_judge.known;
    rk_judge.end = RK_JUDGE_FIRST;
    rk_judge.objects = rk_judge.object_count = 0;
    rk_judge.lap_is_over = false;
}

/* Of pages that a fork has not mapped, each one would be a fault. */
void rk_judge_map_next_pages(void)
{
#if defined(MADV_POPULATE_WRITE) && defined(MADV_POPULATE_READ)
    size_t page = (size_t)sysconf(_SC_PAGESIZE), begin = rk_judge.end / page * page;
    madvise(rk_judge.asked_memory + begin, MAPPED_BYTES, MADV_POPULATE_WRITE);
    madvise((unsigned char *)rk_judge.answered_memory + begin, MAPPED_BYTES, MADV_POPULATE_READ);
    rk_judge.mapped_end = begin + MAPPED_BYTES;
#endif
}

void rk_judge_publish(rk_judge_request *head, size_t bytes)
{
    head->number = rk_judge.known++;
    if (rk_judge.predicts && rk_judge.end + head->span > rk_judge.mapped_end)
        rk_judge_map_next_pages();
    memcpy(rk_judge.asked_memory + rk_judge.end, head, bytes);
    rk_judge.end += head->span;
    if (!rk_judge.speculates || rk_judge.known % RK_JUDGE_RUN == 0)
        count_published();
    if (!rk_judge.predicts || rk_judge.known % RK_JUDGE_BATCH == 0)
        rk_judge_wake_readers();
}

void rk_judge_publish_end_of_lap(void)
{
    rk_judge_request turn = {RK_JUDGE_FROM_FRONT, sizeof turn, sizeof turn, 0};
    rk_judge_publish(&turn, sizeof turn);
    rk_judge_wake_readers();
}

bool rk_judge_lap_is_full(size_t requests)
{
    return rk_judge.end - rk_judge.objects > RK_JUDGE_FIRST + RK_JUDGE_LAP_BYTES ||
           rk_judge.end > RK_JUDGE_BYTES / 2 ||
           rk_judge.object_count + RK_JUDGE_KEPT_SLOTS > RK_JUDGE_KEPT_MAX ||
           rk_judge.known - rk_judge.lap_begin + requests >= RK_JUDGE_LAP_REQUESTS;
}

void rk_judge_make_room_in_lap(size_t bytes, size_t requests)
{
    if (rk_judge_lap_is_full(requests + RK_JUDGE_KEPT_SLOTS)) {
        rk_judge_publish_end_of_lap();
        for (uint32_t lap; rk_judge.predicts && (lap = rk_judge.asked->lap) == rk_judge.lap;)
            rk_judge_wait(&rk_judge.asked->lap, lap, &rk_judge.asked->predictor_waits);
        rk_judge_begin_lap();
    }
    rk_check(rk_judge.end + bytes + sizeof(rk_judge_request) <= RK_JUDGE_BYTES,
             "a call of %zu MB is more than a judge can ask", bytes >> 20);
}
