/* Calls to a unit in another process, and what predicts them: see judge.h. */
#define _GNU_SOURCE /* for F_SEAL_FUTURE_WRITE */
#include "judge/judge.h"
#include "base/error.h"
#include "judge/held.h"
#include "judge/kept.h"
#include "judge/published.h"
#include "judge/requests.h"
#include "judge/speculation.h"
#include "judge_hooks.h"
#include "test.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

enum {
    BATCH_MIN = 32, /* requests that a predictor makes at least, once one was wrong */
    BATCH_MAX = 1 << 13,
    AHEAD_MAX = 1 << 15,   /* requests of a predictor that has to leave others out */
    JUDGED_PREDICTORS = 4, /* after so many it is seen whether they are worth it: */
    USED_MIN = 400,        /* to begin one costs as much as some 100 calls without one */
    DIRECT_FIRST = 200,    /* calls without a predictor: at the beginning, */
    DIRECT_MIN = 64,       /* and where predictors are not worth it */
    DIRECT_MAX = 1 << 20,
    SETTLED_AFTER = 256, /* calls */
};

static struct {
    pid_t process;
    uint32_t begin;             /* published before it */
    uint32_t batch;             /* that it shall publish */
    size_t direct, direct_most; /* calls to make without one, and how many it will be next time */
    int count;
    size_t asked, used; /* requests of the last ones, and those that the judge made, too */
} predictor;

static uint64_t speculated_from; /* the call */

static uint64_t after[RK_JUDGE_FUNCTIONS]; /* as rk_judge_after, in this test */

static bool
    leaves_out; /* the predictor does: requests that would tell an answer of the reference */

void rk_judge_ask(int function)
{
    rk_check(rk_judge.asked, "the unit is called before the judge is connected");
    rk_judge_call.size = 0;
    rk_judge_begin_objects();
    rk_judge_put(&(rk_judge_request){.function = function}, sizeof(rk_judge_request));
}

static void publish_request(rk_judge_request *head)
{
    if (rk_judge.speculates) { /* there is room in the lap */
        rk_judge_publish_objects();
        rk_judge_publish(head, head->bytes);
        return;
    }
    size_t requests = rk_judge.predicts ? RK_JUDGE_HELD_MAX : 1;
    if (rk_judge.predicts && rk_judge_lap_is_full(requests + RK_JUDGE_KEPT_SLOTS))
        rk_judge_settle_all();
    rk_judge_make_room_in_lap(head->span + rk_judge_object_bytes(), requests);
    rk_judge_publish_objects();
    rk_judge_publish(head, head->bytes);
}

/* --- The predictor --------------------------------------------------------------------------- */

/* Its output is not the judge's, and neither are its verdicts. */
static void become_predictor(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    rk_judge.predicts = true;
    rk_judge_map_next_pages();
}

static _Noreturn void end_as_predictor(void)
{
    static bool ends; /* also where the unit's process has ended, and nothing is to be waited for */
    if (!ends) {
        ends = true;
        rk_judge_settle_all();
    }
    rk_judge.asked->predictor_ends = 1;
    rk_judge_wake_readers();
    _exit(0);
}

static void make_calls_directly(void)
{
    predictor.direct = predictor.direct_most;
    if (predictor.direct_most < DIRECT_MAX)
        predictor.direct_most *= 2;
}

static void end_speculation(void)
{
    rk_judge_end_speculation();
    if (rk_judge.calls - speculated_from >= USED_MIN)
        predictor.direct_most = DIRECT_MIN;
    else
        make_calls_directly();
}

static void begin_prediction(const rk_judge_request *head)
{
    if (rk_judge_lap_is_full(BATCH_MAX)) { /* also enough for a speculation */
        rk_judge_publish_end_of_lap();
        rk_judge_begin_lap();
    }
    if (rk_judge_may_speculate(head)) {
        speculated_from = rk_judge.calls;
        if (!rk_judge_begin_speculation() && !rk_judge_was_wrong())
            predictor.direct = DIRECT_MAX;
        return;
    }
    if (predictor.asked == 0)
        predictor.used = 0; /* calls without a predictor say nothing of it */
    predictor.begin = rk_judge.known;
    rk_judge.asked->predicted = rk_judge.calls - 1;
    rk_judge.asked->predictor_ends = 0;
    predictor.process = fork();
    if (predictor.process == 0)
        become_predictor();
    if (predictor.process < 0) {
        predictor.process = 0;
        predictor.direct = DIRECT_MAX;
    }
}

static void weigh_predictors(void)
{
    if (++predictor.count % JUDGED_PREDICTORS != 0)
        return;
    if (10 * predictor.used < predictor.asked || predictor.used < USED_MIN)
        predictor.batch /= 4;
    else if (2 * predictor.used > predictor.asked) {
        predictor.batch = predictor.batch * 4 < BATCH_MAX ? predictor.batch * 4 : BATCH_MAX;
        predictor.direct_most = DIRECT_MIN;
    }
    if (predictor.batch < BATCH_MIN) {
        predictor.batch = BATCH_MIN;
        make_calls_directly();
    }
    predictor.asked = predictor.used = 0;
}

static void stop_predictor(void)
{
    if (!predictor.process)
        return;
    kill(predictor.process, SIGKILL);
    waitpid(predictor.process, NULL, 0);
    predictor.process = 0;
    rk_judge_forget_held();
}

static void end_prediction(void)
{
    stop_predictor();
    rk_judge_look_at_all();
    rk_judge_wait_for_answer(rk_judge.known - 1);
    predictor.asked += rk_judge.known - predictor.begin;
    weigh_predictors();
    if (rk_judge.lap_is_over)
        rk_judge_begin_lap();
}

/* The judge's request is none of those that were published: the predictor is not there yet, or it
 * came along here with another request. Then it shall make some more, which may be right. */
static void look_at_predictor(void)
{
    uint32_t published = rk_judge.asked->published;
    bool has_ended =
        waitpid(predictor.process, NULL, rk_judge.asked->predictor_ends ? 0 : WNOHANG) != 0;
    if (has_ended) {
        predictor.process = 0;
        rk_judge_forget_held();
    }
    bool has_passed = rk_judge.asked->predicted >= rk_judge.calls;
    if (rk_judge.asked->published != rk_judge.known && !rk_judge.lap_is_over)
        return;
    bool has_made_enough =
        published - predictor.begin >= predictor.batch ||
        rk_judge.asked->predicted - rk_judge.calls >= 4 * (uint64_t)predictor.batch;
    if (has_ended || rk_judge.lap_is_over ||
        (has_passed && has_made_enough && !rk_judge_may_hold(rk_judge.calls)))
        end_prediction();
    else
        rk_judge_wait(&rk_judge.asked->published, published, &rk_judge.asked->is_waiting);
}

/* A predictor could publish one such request and no other. */
static bool may_be_ahead(const rk_judge_request *head)
{
    return after[head->function] != UINT64_MAX;
}

/* What is known is the unit's own once all is settled, also to a request that would tell answers.
 */
static void speculate(rk_judge_request *head)
{
    if (rk_judge_holds_all(head))
        rk_judge_settle_all();
    else if (rk_judge.calls % SETTLED_AFTER == 0)
        rk_judge_settle();
    rk_judge_way way = rk_judge_way_of(head);
    if (way == RK_JUDGE_LEAVE_OUT || (way == RK_JUDGE_HOLD && !rk_judge_objects_are_there())) {
        rk_judge_settle_all();
        way = RK_JUDGE_PUBLISH;
    }
    size_t place = 0;
    if (way == RK_JUDGE_PUBLISH) {
        publish_request(head);
        place = rk_judge.end - head->span;
        rk_judge_take(place);
    }
    rk_judge_hold(head, way, place);
}

/* In the predictor: true where the reference is to be called. */
static bool predict(rk_judge_request *head)
{
    size_t place = 0;
    if (rk_judge_holds_all(head))
        rk_judge_settle_all();
    else if (rk_judge.calls % SETTLED_AFTER == 0)
        rk_judge_settle();
    bool is_known = rk_judge_find(head, &place);
    rk_judge_way way = is_known ? RK_JUDGE_PUBLISH : rk_judge_way_of(head);
    if (way == RK_JUDGE_HOLD && !rk_judge_objects_are_there()) {
        rk_judge_settle_all();
        way = rk_judge_way_of(head);
    }
    if (way == RK_JUDGE_PUBLISH && !is_known) {
        publish_request(head);
        place = rk_judge.end - head->span;
    }
    if (way == RK_JUDGE_PUBLISH)
        rk_judge_take(place);
    leaves_out = leaves_out || way == RK_JUDGE_LEAVE_OUT;
    atomic_store_explicit(&rk_judge.asked->predicted, rk_judge.calls, memory_order_release);
    if (leaves_out && rk_judge.known - predictor.begin >= AHEAD_MAX)
        end_as_predictor(); /* the next one knows the answers of these */
    bool is_answer_known = is_known && rk_judge_is_answered(rk_judge_request_at(place)->number);
    if (!is_answer_known)
        rk_judge_hold(head, way, place);
    return !is_answer_known;
}

bool rk_judge_predicts(size_t bytes_max)
{
    rk_judge_request *head = (rk_judge_request *)rk_judge_call.request;
    size_t most = rk_judge_call.size > bytes_max ? rk_judge_call.size : bytes_max, place;
    rk_check(most < RK_JUDGE_BYTES, "a call of %zu MB is more than a judge can ask", most >> 20);
    head->bytes = (uint32_t)rk_judge_call.size;
    head->span = (uint32_t)rk_judge_aligned(most);
    rk_judge.calls++;
    if (rk_judge.speculates && !rk_judge_may_speculate(head))
        end_speculation();
    while (!rk_judge.predicts && !rk_judge_find(head, &place)) {
        if (predictor.process)
            look_at_predictor();
        else if (predictor.direct == 0 && may_be_ahead(head))
            begin_prediction(head);
        else {
            predictor.direct -= predictor.direct > 0;
            publish_request(head);
        }
    }
    if (rk_judge.speculates) {
        speculate(head);
        return true;
    }
    if (rk_judge.predicts)
        return predict(head);
    predictor.used++;
    rk_judge_wait_for_answer(rk_judge_request_at(place)->number);
    rk_judge_take_answer(place);
    return false;
}

void *rk_judge_get_made(size_t count, size_t most, size_t size)
{
    rk_check(count <= most, "%zu values were allocated, want at most %zu", count, most);
    rk_judge_begin_own_memory();
    void *memory = rk_allocate_unset(count, size, "tree", NULL);
    rk_judge_end_own_memory();
    rk_check(memory, "no memory for %zu values", count);
    rk_judge_get(memory, count * size);
    return memory;
}

void rk_judge_cannot_ask(const char *function)
{
    rk_claim_failed(__FILE__, __LINE__, "%s cannot be asked in another process", function);
    abort();
}

void rk_judge_get_allocations(void)
{
    uint64_t made[2];
    rk_judge_get(made, sizeof made);
    rk_allocations += made[0];
    rk_allocations_kept += made[1];
}

/* --- What tests/suite.c calls ---------------------------------------------------------------- */

/* RAYKIT_JUDGE names three descriptors: of both memories, and of the pipe; and the process that
 * begins judges, with which they end. The unit's process gets the first descriptor as well, but can
 * write to that memory no more. */
static void map_memories(void)
{
    int asked, answered, grader;
    const char *value = getenv("RAYKIT_JUDGE");
    if (!value || sscanf(value, "%d,%d,%d,%d", &asked, &answered, &rk_judge.unit, &grader) != 4) {
        fprintf(stderr, "this judge of a unit is run by make grade\n");
        exit(2);
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != grader)
        exit(2);
    rk_judge.asked_memory =
        mmap(NULL, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, asked, 0);
    rk_judge.answered_memory = mmap(NULL, RK_JUDGE_BYTES, PROT_READ, MAP_SHARED, answered, 0);
    if (rk_judge.asked_memory == MAP_FAILED || rk_judge.answered_memory == MAP_FAILED ||
        fcntl(asked, F_ADD_SEALS, F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
        perror("the memory that a judge shares with a unit cannot be made");
        exit(2);
    }
    rk_judge.asked = (rk_judge_asked *)rk_judge.asked_memory;
    rk_judge.answered = (const rk_judge_answered *)rk_judge.answered_memory;
}

void rk_judge_connect(const char *test)
{
    if (!rk_judge.asked)
        map_memories();
    rk_judge.asked->lap = rk_judge.lap = 1; /* 0 is that of slots without a request */
    predictor.batch = BATCH_MAX;
    predictor.direct = DIRECT_FIRST;
    predictor.direct_most = DIRECT_MIN;
    memcpy(after, rk_judge_after, sizeof after);
    for (const rk_judge_exception *it = rk_judge_exceptions; it->test; it++)
        if (strcmp(it->test, test) == 0)
            after[it->function] = UINT64_MAX;
    rk_judge_prepare_speculation();
    rk_judge_begin_holding(after);
}

/* The predictor's work ends here, and a speculation's. */
bool rk_judge_end_of_test(void)
{
    if (rk_judge.speculates)
        end_speculation();
    if (rk_judge.predicts)
        end_as_predictor();
    return false;
}

static bool is_one_of_several;

static void tell_the_end(rk_judge_end end)
{
    rk_judge.asked->ended = end;
    atomic_fetch_add(&rk_judge.asked->published, 1); /* ends waiting for the next one */
    rk_judge_wake_readers();
}

/* Also after a test that has failed. */
void rk_judge_disconnect(void)
{
    rk_judge_end_of_test();
    stop_predictor();
    tell_the_end(is_one_of_several ? RK_JUDGE_END_OF_CLAIM : RK_JUDGE_END);
}

/* --- Several claims -------------------------------------------------------------------------- */

static bool wait_until_unit_has_seen_ends(uint32_t claims)
{
    for (uint32_t seen; (seen = rk_judge.answered->claims) != claims;) {
        rk_judge_wait(&rk_judge.answered->claims, seen, &rk_judge.asked->is_waiting);
        if (rk_judge.answered->claims == seen && rk_judge_unit_has_ended())
            return false;
    }
    return true;
}

static void have_unit_go_on(void)
{
    atomic_fetch_add(&rk_judge.asked->claims, 1);
    rk_judge_wake(&rk_judge.asked->claims, &rk_judge.answered->is_waiting);
}

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool holds_in_fork(bool (*holds)(void *claim), void *claim)
{
    pid_t parent = getpid(), child = fork();
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        _exit(getppid() == parent && holds(claim) ? 0 : 1);
    }
    int status;
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

bool rk_judge_all_hold(bool (*holds)(void *claim), void *claims[], double seconds[], size_t count)
{
    map_memories();
    is_one_of_several = true;
    for (uint32_t i = 0; i < count; i++) {
        double began = seconds_now();
        if (!holds_in_fork(holds, claims[i]) || !wait_until_unit_has_seen_ends(i + 1)) {
            tell_the_end(RK_JUDGE_END);
            have_unit_go_on();
            return false;
        }
        seconds[i] = seconds_now() - began;
        *rk_judge.asked = (rk_judge_asked){.claims = i, .ended = i + 1 == count ? RK_JUDGE_END : 0};
        have_unit_go_on();
    }
    return true;
}
