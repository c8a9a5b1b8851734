/* Requests to a unit in another process, and what predicts them: see judge.h. The memory for
 * requests is used in laps, from its front to its end; a table finds those of a lap that no call
 * has taken. */
#define _GNU_SOURCE /* for F_SEAL_FUTURE_WRITE */
#include "judge/judge.h"
#include "judge/protocol.h"
#include "judge_hooks.h"
#include "test.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

enum {
    LAP_BYTES = 4 << 20,
    LAP_REQUESTS = 1 << 13,
    SLOTS = 2 * LAP_REQUESTS,
    BATCH_MIN = 32, /* requests that a predictor makes at least, once one was wrong */
    BATCH_MAX = 1 << 11,
    JUDGED_PREDICTORS = 4, /* after so many it is seen whether they are worth it: */
    USED_MIN = 400,        /* to begin one costs as much as some 100 calls without one */
    DIRECT_MIN = 64,       /* calls without a predictor, if they are not */
    DIRECT_MAX = 1 << 20,
};

static struct {
    unsigned char *asked_memory;
    const unsigned char *answered_memory;
    rk_judge_asked *asked;
    const rk_judge_answered *answered;
    int unit; /* end of a pipe that the unit's process keeps open */
    bool predicts;
    uint64_t calls;
    uint32_t lap, lap_begin; /* the number of its first request */
    uint32_t known;          /* requests so far, as this process knows them */
    size_t end;              /* their end */
    size_t next;             /* where the next one is expected */
    bool lap_is_over;
} judge;

static struct {
    pid_t process;
    uint32_t begin;             /* published before it */
    uint32_t batch;             /* that it shall publish */
    size_t direct, direct_most; /* calls to make without one, and how many it will be next time */
    int count;
    size_t asked, used; /* requests of the last ones, and those that the judge made, too */
} predictor;

/* Requests of this lap that were published, by the hash of their bytes. */
static struct slot {
    uint32_t lap, hash, place;
} slots[SLOTS];
static uint32_t taken_in[LAP_REQUESTS]; /* the lap in which each was taken */

struct rk_judge_call rk_judge_call;

/* --- Requests -------------------------------------------------------------------------------- */

void rk_judge_grow(size_t bytes)
{
    size_t room = 2 * bytes > 65536 ? 2 * bytes : 65536;
    size_t made = rk_allocations, kept = rk_allocations_kept;
    unsigned char *request = realloc(rk_judge_call.request, room);
    rk_allocations = made; /* the unit's are counted */
    rk_allocations_kept = kept;
    rk_check(request, "no memory for a request of %zu bytes", bytes);
    rk_judge_call.request = request;
    rk_judge_call.room = room;
}

void rk_judge_ask(int function)
{
    rk_check(judge.asked, "the unit is called before the judge is connected");
    rk_judge_call.size = 0;
    rk_judge_put(&(rk_judge_request){.function = function}, sizeof(rk_judge_request));
}

static const rk_judge_request *request_at(size_t place)
{
    return (const rk_judge_request *)(judge.asked_memory + place);
}

static void wake_readers(void)
{
    rk_judge_wake(&judge.asked->published, &judge.answered->is_waiting);
    rk_judge_wake(&judge.asked->published, &judge.asked->is_waiting);
}

static bool unit_has_ended(void)
{
    struct pollfd pipe = {.fd = judge.unit, .events = POLLIN};
    return poll(&pipe, 1, 0) > 0;
}

static bool is_answered(uint32_t number)
{
    uint32_t answered = atomic_load_explicit(&judge.answered->answered, memory_order_acquire);
    return (int32_t)(answered - number) > 0;
}

static void wait_for_answer(uint32_t number)
{
    while (!is_answered(number)) {
        uint32_t answered = judge.answered->answered;
        if ((int32_t)(answered - number) > 0)
            return;
        rk_judge_wait(&judge.answered->answered, answered, &judge.asked->is_waiting);
        if (judge.answered->answered == answered && unit_has_ended())
            rk_claim_failed(__FILE__, __LINE__, "the process that runs the unit has ended");
    }
}

/* --- Laps ------------------------------------------------------------------------------------ */

/* The judge begins first, when it is past all that a predictor will then overwrite. */
static void begin_lap(void)
{
    wait_for_answer(judge.known - 1);
    judge.lap++;
    if (!judge.predicts)
        judge.asked->lap = judge.lap;
    judge.lap_begin = judge.known;
    judge.end = judge.next = RK_JUDGE_FIRST;
    judge.lap_is_over = false;
}

static void publish(rk_judge_request *head)
{
    head->number = judge.known++;
    memcpy(judge.asked_memory + judge.end, head, head->bytes);
    judge.end += head->span;
    atomic_store_explicit(&judge.asked->published, judge.known, memory_order_release);
    if (!judge.predicts || judge.known % RK_JUDGE_BATCH == 0)
        wake_readers();
}

static void publish_end_of_lap(void)
{
    rk_judge_request turn = {RK_JUDGE_FROM_FRONT, sizeof turn, sizeof turn, 0};
    publish(&turn);
    wake_readers();
}

static bool lap_is_full(size_t requests)
{
    return judge.end > RK_JUDGE_FIRST + LAP_BYTES ||
           judge.known - judge.lap_begin + requests >= LAP_REQUESTS;
}

static void publish_request(rk_judge_request *head)
{
    if (lap_is_full(1)) {
        publish_end_of_lap();
        for (uint32_t lap; judge.predicts && (lap = judge.asked->lap) == judge.lap;)
            rk_judge_wait(&judge.asked->lap, lap, &judge.asked->predictor_waits);
        begin_lap();
    }
    rk_check(judge.end + head->span + sizeof *head <= RK_JUDGE_BYTES,
             "a call of %u MB is more than a judge can ask", head->span >> 20);
    publish(head);
}

/* --- Requests that were published ------------------------------------------------------------ */

static uint32_t hash_of(const rk_judge_request *head)
{
    uint64_t hash = (uint32_t)head->function, word;
    for (size_t i = sizeof *head; i < head->bytes; i += sizeof word) {
        memcpy(&word, (const unsigned char *)head + i, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 29;
    }
    return (uint32_t)(hash >> 32);
}

static bool is_open(size_t place)
{
    return taken_in[request_at(place)->number - judge.lap_begin] != judge.lap;
}

static bool is_same(const rk_judge_request *a, const rk_judge_request *b)
{
    return a->function == b->function && a->bytes == b->bytes &&
           memcmp(a + 1, b + 1, a->bytes - sizeof *a) == 0;
}

static void learn(size_t place)
{
    uint32_t hash = hash_of(request_at(place)), i = hash % SLOTS;
    while (slots[i].lap == judge.lap && is_open(slots[i].place))
        i = (i + 1) % SLOTS;
    slots[i] = (struct slot){judge.lap, hash, (uint32_t)place};
}

/* Looks at what the predictor has published. */
static void learn_all(void)
{
    uint32_t published = atomic_load_explicit(&judge.asked->published, memory_order_acquire);
    while (judge.known != published && !judge.lap_is_over) {
        const rk_judge_request *head = request_at(judge.end);
        judge.lap_is_over = head->function == RK_JUDGE_FROM_FRONT;
        if (!judge.lap_is_over && is_open(judge.end))
            learn(judge.end);
        judge.end += head->span;
        judge.known++;
    }
}

static bool find_learnt(const rk_judge_request *head, size_t *place)
{
    uint32_t hash = hash_of(head);
    for (uint32_t i = hash % SLOTS; slots[i].lap == judge.lap; i = (i + 1) % SLOTS)
        if (slots[i].hash == hash && is_open(slots[i].place) &&
            is_same(request_at(slots[i].place), head)) {
            *place = slots[i].place;
            return true;
        }
    return false;
}

/* Finds a request that was published, and that no call has taken. In most cases it is the next. */
static bool find(const rk_judge_request *head, size_t *place)
{
    uint32_t published = atomic_load_explicit(&judge.asked->published, memory_order_acquire);
    *place = judge.next;
    if (judge.next == judge.end && judge.known != published && !judge.lap_is_over) {
        bool is_over = request_at(judge.end)->function == RK_JUDGE_FROM_FRONT;
        if (is_over) {
            judge.known++;
            begin_lap();
            rk_judge_wake(&judge.asked->lap, &judge.asked->predictor_waits);
            return find(head, place);
        }
        if (is_same(request_at(judge.end), head)) { /* nobody has to learn it */
            judge.end += request_at(judge.end)->span;
            judge.known++;
            return true;
        }
    } else if (judge.next < judge.end && is_open(judge.next) &&
               is_same(request_at(judge.next), head))
        return true;
    learn_all();
    return find_learnt(head, place);
}

static void take(size_t place)
{
    taken_in[request_at(place)->number - judge.lap_begin] = judge.lap;
    judge.next = place + request_at(place)->span;
    rk_judge_call.answer = judge.answered_memory + place;
}

/* --- The predictor --------------------------------------------------------------------------- */

/* Its output is not the judge's, and neither are its verdicts. */
static void become_predictor(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    judge.predicts = true;
}

static void begin_prediction(void)
{
    if (lap_is_full(BATCH_MAX)) {
        publish_end_of_lap();
        begin_lap();
    }
    if (predictor.asked == 0)
        predictor.used = 0; /* calls without a predictor say nothing of it */
    predictor.begin = judge.known;
    judge.asked->predicted = judge.calls - 1;
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
        predictor.direct = predictor.direct_most;
        if (predictor.direct_most < DIRECT_MAX)
            predictor.direct_most *= 2;
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
}

static void end_prediction(void)
{
    stop_predictor();
    learn_all();
    wait_for_answer(judge.known - 1);
    predictor.asked += judge.known - predictor.begin;
    weigh_predictors();
    if (judge.lap_is_over)
        begin_lap();
}

/* The judge's request is none of those that were published: the predictor is not there yet, or it
 * came along here with another request. Then it shall make some more, which may be right. */
static void look_at_predictor(void)
{
    uint32_t published = judge.asked->published;
    bool has_ended = waitpid(predictor.process, NULL, WNOHANG) != 0;
    if (has_ended)
        predictor.process = 0;
    bool has_passed = judge.asked->predicted >= judge.calls;
    if (judge.asked->published != judge.known && !judge.lap_is_over)
        return;
    bool has_made_enough = published - predictor.begin >= predictor.batch ||
                           judge.asked->predicted - judge.calls >= 4 * (uint64_t)predictor.batch;
    if (has_ended || judge.lap_is_over || (has_passed && has_made_enough))
        end_prediction();
    else
        rk_judge_wait(&judge.asked->published, published, &judge.asked->is_waiting);
}

/* In the predictor: true where the reference is to be called. */
static bool predict(rk_judge_request *head)
{
    size_t place;
    bool is_known = find(head, &place);
    if (!is_known) {
        publish_request(head);
        place = judge.end - head->span;
    }
    take(place);
    atomic_store_explicit(&judge.asked->predicted, judge.calls, memory_order_release);
    return !is_known || !is_answered(request_at(place)->number);
}

bool rk_judge_predicts(size_t bytes_max)
{
    rk_judge_request *head = (rk_judge_request *)rk_judge_call.request;
    size_t most = rk_judge_call.size > bytes_max ? rk_judge_call.size : bytes_max, place;
    rk_check(most < RK_JUDGE_BYTES, "a call of %zu MB is more than a judge can ask", most >> 20);
    head->bytes = (uint32_t)rk_judge_call.size;
    head->span = (uint32_t)rk_judge_aligned(most);
    judge.calls++;
    while (!judge.predicts && !find(head, &place)) {
        if (predictor.process)
            look_at_predictor();
        else if (predictor.direct == 0)
            begin_prediction();
        else {
            predictor.direct--;
            publish_request(head);
            judge.next = judge.end - head->span;
        }
    }
    if (judge.predicts)
        return predict(head);
    predictor.used++;
    wait_for_answer(request_at(place)->number);
    take(place);
    return false;
}

void rk_judge_get_allocations(void)
{
    uint64_t made[2];
    rk_judge_get(made, sizeof made);
    rk_allocations += made[0];
    rk_allocations_kept += made[1];
}

/* --- What tests/suite.c calls ---------------------------------------------------------------- */

/* RAYKIT_JUDGE names three descriptors: of both memories, and of the pipe. The unit's process gets
 * the first as well, but can write to it no more. */
void rk_judge_connect(void)
{
    int asked, answered;
    const char *value = getenv("RAYKIT_JUDGE");
    if (!value || sscanf(value, "%d,%d,%d", &asked, &answered, &judge.unit) != 3) {
        fprintf(stderr, "this judge of a unit is run by make grade\n");
        exit(2);
    }
    judge.asked_memory =
        mmap(NULL, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, asked, 0);
    judge.answered_memory = mmap(NULL, RK_JUDGE_BYTES, PROT_READ, MAP_SHARED, answered, 0);
    if (judge.asked_memory == MAP_FAILED || judge.answered_memory == MAP_FAILED ||
        fcntl(asked, F_ADD_SEALS, F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
        perror("the memory that a judge shares with a unit cannot be made");
        exit(2);
    }
    judge.asked = (rk_judge_asked *)judge.asked_memory;
    judge.answered = (const rk_judge_answered *)judge.answered_memory;
    judge.end = judge.next = RK_JUDGE_FIRST;
    judge.asked->lap = judge.lap = 1; /* 0 is that of slots without a request */
    predictor.batch = BATCH_MAX;
    predictor.direct_most = DIRECT_MIN;
}

/* The predictor's work ends here. */
void rk_judge_end_of_test(void)
{
    if (!judge.predicts)
        return;
    wake_readers();
    _exit(0);
}

/* Also after a test that has failed. */
void rk_judge_disconnect(void)
{
    rk_judge_end_of_test();
    stop_predictor();
    judge.asked->ended = 1;
    atomic_fetch_add(&judge.asked->published, 1); /* ends waiting for the next one */
    wake_readers();
}
