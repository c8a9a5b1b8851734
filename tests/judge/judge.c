/* Requests to a unit in another process, and what predicts them: see judge.h. The memory for
 * requests is used in laps, from its front to its end; a table finds those of a lap that no call
 * has taken. */
#define _GNU_SOURCE /* for F_SEAL_FUTURE_WRITE */
#include "judge/judge.h"
#include "base/error.h"
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
    LAP_BYTES = 16 << 20,
    LAP_REQUESTS = 1 << 17,
    SLOTS = 2 * LAP_REQUESTS,
    BATCH_MIN = 32, /* requests that a predictor makes at least, once one was wrong */
    BATCH_MAX = 1 << 13,
    MAPPED_BYTES = 1 << 20, /* at once */
    AHEAD_MAX = 1 << 15,    /* requests of a predictor that has to leave others out */
    JUDGED_PREDICTORS = 4,  /* after so many it is seen whether they are worth it: */
    USED_MIN = 400,         /* to begin one costs as much as some 100 calls without one */
    DIRECT_FIRST = 200,     /* calls without a predictor: at the beginning, */
    DIRECT_MIN = 64,        /* and where predictors are not worth it */
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
    size_t mapped_end;       /* of this process, if it predicts */
    size_t objects;          /* bytes of this lap that are objects, and their number: */
    uint32_t object_count;
    size_t learnt; /* those before it are in the table below */
    bool lap_is_over;
    uint64_t after[RK_JUDGE_FUNCTIONS]; /* as rk_judge_after, in this test */
    uint64_t given; /* a bit for each function of which the predictor used the reference's answer */
    bool leaves_out; /* requests that would tell one */
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
static size_t next_of[RK_JUDGE_FUNCTIONS]; /* where that of a function is expected */
static uint32_t taken_in[LAP_REQUESTS];    /* the lap in which each was taken */

struct rk_judge_call rk_judge_call;

/* The objects that are kept: of this call, and the last ones of each slot. */
enum {
    KEPT_SLOTS = 8,
    KEPT_PLACES = 2 * RK_JUDGE_KEPT_MAX,
    GUARDED_AFTER = 8, /* calls with the same object */
    GUARDED_BYTES = 1 << 15,
};
static int of_call[KEPT_SLOTS]; /* slots */
static size_t of_call_count;
static struct last_object {
    uint64_t id;
    unsigned char *bytes;
    size_t size, room;
    rk_judge_piece pieces[RK_JUDGE_PIECES];
    size_t count;
    int seen;        /* so many times the same */
    bool is_guarded; /* whole pages of its pieces cannot be written to: so they are unchanged */
} last_of_slot[KEPT_SLOTS];
/* What the unit's process has, until the next lap. */
static struct kept_id {
    uint64_t id;
    uint32_t lap;
} kept_ids[KEPT_PLACES];

/* --- Requests -------------------------------------------------------------------------------- */

/* The judge's own memory is none of the unit's, whose allocations are counted. */
static size_t own_made, own_kept;

static void begin_own_memory(void)
{
    own_made = rk_allocations;
    own_kept = rk_allocations_kept;
}

static void end_own_memory(void)
{
    rk_allocations = own_made;
    rk_allocations_kept = own_kept;
}

/* Of whole words of 8 bytes. */
static uint64_t hash_of_words(const void *bytes, size_t size, uint64_t hash)
{
    for (size_t i = 0; i < size; i += sizeof hash) {
        uint64_t word;
        memcpy(&word, (const unsigned char *)bytes + i, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 32;
    }
    return hash;
}

void rk_judge_grow(size_t bytes)
{
    size_t room = 2 * bytes > 65536 ? 2 * bytes : 65536;
    begin_own_memory();
    unsigned char *request = realloc(rk_judge_call.request, room);
    end_own_memory();
    rk_check(request, "no memory for a request of %zu bytes", bytes);
    rk_judge_call.request = request;
    rk_judge_call.room = room;
}

void rk_judge_ask(int function)
{
    rk_check(judge.asked, "the unit is called before the judge is connected");
    rk_judge_call.size = 0;
    of_call_count = 0;
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
    for (;;) {
        uint32_t answered = atomic_load_explicit(&judge.answered->answered, memory_order_acquire);
        if ((int32_t)(answered - number) > 0)
            return;
        rk_judge_wait(&judge.answered->answered, answered, &judge.asked->is_waiting);
        if (judge.answered->answered == answered && unit_has_ended())
            rk_claim_failed(__FILE__, __LINE__,
                            "the code ended the program in the middle of the test: does it call "
                            "exit, or _Exit?");
    }
}

/* --- Laps ------------------------------------------------------------------------------------ */

static void begin_at_front(void)
{
    judge.end = judge.learnt = RK_JUDGE_FIRST;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        next_of[i] = RK_JUDGE_FIRST;
}

/* The judge begins first, when it is past all that a predictor will then overwrite. */
static void begin_lap(void)
{
    wait_for_answer(judge.known - 1);
    judge.lap++;
    if (!judge.predicts)
        judge.asked->lap = judge.lap;
    judge.lap_begin = judge.known;
    begin_at_front();
    judge.objects = judge.object_count = 0;
    judge.lap_is_over = false;
}

/* Of pages that a fork has not mapped, each one would be a fault. */
static void map_what_comes(void)
{
#if defined(MADV_POPULATE_WRITE) && defined(MADV_POPULATE_READ)
    size_t page = (size_t)sysconf(_SC_PAGESIZE), begin = judge.end / page * page;
    madvise(judge.asked_memory + begin, MAPPED_BYTES, MADV_POPULATE_WRITE);
    madvise((unsigned char *)judge.answered_memory + begin, MAPPED_BYTES, MADV_POPULATE_READ);
    judge.mapped_end = begin + MAPPED_BYTES;
#endif
}

/* Copies the first bytes of a request, whose others stand there already. */
static void publish(rk_judge_request *head, size_t bytes)
{
    head->number = judge.known++;
    if (judge.predicts && judge.end + head->span > judge.mapped_end)
        map_what_comes();
    memcpy(judge.asked_memory + judge.end, head, bytes);
    judge.end += head->span;
    atomic_store_explicit(&judge.asked->published, judge.known, memory_order_release);
    if (!judge.predicts || judge.known % RK_JUDGE_BATCH == 0)
        wake_readers();
}

static void publish_end_of_lap(void)
{
    rk_judge_request turn = {RK_JUDGE_FROM_FRONT, sizeof turn, sizeof turn, 0};
    publish(&turn, sizeof turn);
    wake_readers();
}

static bool lap_is_full(size_t requests)
{
    return judge.end - judge.objects > RK_JUDGE_FIRST + LAP_BYTES ||
           judge.end > RK_JUDGE_BYTES / 2 || judge.object_count + KEPT_SLOTS > RK_JUDGE_KEPT_MAX ||
           judge.known - judge.lap_begin + requests >= LAP_REQUESTS;
}

static void make_room_in_lap(size_t bytes)
{
    if (lap_is_full(1 + KEPT_SLOTS)) {
        publish_end_of_lap();
        for (uint32_t lap; judge.predicts && (lap = judge.asked->lap) == judge.lap;)
            rk_judge_wait(&judge.asked->lap, lap, &judge.asked->predictor_waits);
        begin_lap();
    }
    rk_check(judge.end + bytes + sizeof(rk_judge_request) <= RK_JUDGE_BYTES,
             "a call of %zu MB is more than a judge can ask", bytes >> 20);
}

/* --- Objects that are kept ------------------------------------------------------------------- */

static size_t size_of(const rk_judge_piece *pieces, size_t count)
{
    size_t size = 0;
    for (size_t i = 0; i < count; i++)
        size += rk_judge_kept_aligned(pieces[i].bytes + RK_JUDGE_ALIGNMENT);
    return size;
}

static void copy_pieces(unsigned char *to, const rk_judge_piece *pieces, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        size_t size = rk_judge_kept_aligned(pieces[i].bytes + RK_JUDGE_ALIGNMENT);
        if (pieces[i].bytes)
            memcpy(to, pieces[i].data, pieces[i].bytes);
        memset(to + pieces[i].bytes, 0, size - pieces[i].bytes);
        to += size;
    }
}

/* The whole pages of a piece. */
static rk_judge_piece pages_of(rk_judge_piece piece)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), begin = (uintptr_t)piece.data;
    uintptr_t end = (begin + piece.bytes) / page * page;
    begin = (begin + page - 1) / page * page;
    return (rk_judge_piece){(void *)begin, begin < end ? end - begin : 0};
}

/* The first piece is the structure, which is a copy of the caller's. */
static void guard(struct last_object *last, int protection)
{
    for (size_t i = 1; i < last->count; i++) {
        rk_judge_piece pages = pages_of(last->pieces[i]);
        if (pages.bytes)
            mprotect((void *)(uintptr_t)pages.data, pages.bytes, protection);
    }
    last->is_guarded = protection == PROT_READ;
}

static struct sigaction before_guards;

static void note_a_write(int signal, siginfo_t *info, void *context)
{
    (void)context;
    uintptr_t at = (uintptr_t)info->si_addr;
    for (int slot = 0; slot < KEPT_SLOTS; slot++) {
        struct last_object *last = &last_of_slot[slot];
        for (size_t i = 1; i < last->count && last->is_guarded; i++) {
            rk_judge_piece pages = pages_of(last->pieces[i]);
            if (at - (uintptr_t)pages.data < pages.bytes) {
                guard(last, PROT_READ | PROT_WRITE);
                last->seen = 0;
                return;
            }
        }
    }
    sigaction(signal, &before_guards, NULL); /* the fault comes again */
}

static void begin_to_guard(struct last_object *last)
{
    struct sigaction note = {.sa_sigaction = note_a_write, .sa_flags = SA_SIGINFO}, now;
    sigaction(SIGSEGV, NULL, &now);
    if (!(now.sa_flags & SA_SIGINFO) || now.sa_sigaction != note_a_write)
        sigaction(SIGSEGV, &note, &before_guards);
    guard(last, PROT_READ);
}

static bool is_same_piece(const unsigned char *bytes, rk_judge_piece piece, bool is_guarded)
{
    rk_judge_piece pages = is_guarded ? pages_of(piece) : (rk_judge_piece){0};
    if (pages.bytes == 0)
        return piece.bytes == 0 || memcmp(bytes, piece.data, piece.bytes) == 0;
    const unsigned char *data = piece.data, *end = data + piece.bytes;
    size_t head = (size_t)((const unsigned char *)pages.data - data);
    size_t tail = (size_t)(end - ((const unsigned char *)pages.data + pages.bytes));
    return memcmp(bytes, data, head) == 0 &&
           memcmp(bytes + piece.bytes - tail, end - tail, tail) == 0;
}

static bool is_same_object(struct last_object *last, const rk_judge_piece *pieces, size_t count)
{
    if (last->size != size_of(pieces, count) || last->count != count)
        return false;
    for (size_t i = 1; i < count && last->is_guarded; i++)
        if (pieces[i].data != last->pieces[i].data || pieces[i].bytes != last->pieces[i].bytes)
            guard(last, PROT_READ | PROT_WRITE);
    const unsigned char *bytes = last->bytes;
    for (size_t i = 0; i < count; i++) {
        if (!is_same_piece(bytes, pieces[i], last->is_guarded && i > 0))
            return false;
        bytes += rk_judge_kept_aligned(pieces[i].bytes + RK_JUDGE_ALIGNMENT);
    }
    return true;
}

static void keep_copy(struct last_object *last, const rk_judge_piece *pieces, size_t count)
{
    size_t size = size_of(pieces, count);
    if (last->is_guarded)
        guard(last, PROT_READ | PROT_WRITE);
    begin_own_memory();
    if (size > last->room) {
        free(last->bytes);
        last->bytes = malloc(size);
        last->room = size;
    }
    end_own_memory();
    rk_check(last->bytes, "no memory for an object of %zu bytes", size);
    copy_pieces(last->bytes, pieces, count);
    last->size = size;
    last->id = hash_of_words(last->bytes, size, size);
    last->seen = 0;
}

/* Other memory could come to the same place. */
void rk_judge_forget(const void *memory)
{
    for (int slot = 0; slot < KEPT_SLOTS; slot++)
        for (size_t i = 1; i < last_of_slot[slot].count && last_of_slot[slot].is_guarded; i++)
            if (last_of_slot[slot].pieces[i].data == memory)
                guard(&last_of_slot[slot], PROT_READ | PROT_WRITE);
}

void rk_judge_put_kept(int slot, const rk_judge_piece *pieces, size_t count)
{
    struct last_object *last = &last_of_slot[slot];
    if (!is_same_object(last, pieces, count))
        keep_copy(last, pieces, count);
    memcpy(last->pieces, pieces, count * sizeof *pieces);
    last->count = count;
    if (++last->seen == GUARDED_AFTER && last->size >= GUARDED_BYTES)
        begin_to_guard(last);
    rk_judge_put(&last->id, sizeof last->id);
    of_call[of_call_count++] = slot;
}

static struct kept_id *place_of_id(uint64_t id)
{
    uint32_t i = (uint32_t)id % KEPT_PLACES;
    while (kept_ids[i].lap == judge.lap && kept_ids[i].id != id)
        i = (i + 1) % KEPT_PLACES;
    return &kept_ids[i];
}

static void remember(uint64_t id, size_t bytes)
{
    *place_of_id(id) = (struct kept_id){id, judge.lap};
    judge.objects += bytes;
    judge.object_count++;
}

static void publish_object(uint64_t id, const unsigned char *bytes, size_t size)
{
    struct {
        rk_judge_request head;
        rk_judge_kept kept;
    } begin = {{.function = RK_JUDGE_KEEP}, {.id = id, .bytes = size}};
    size_t all = sizeof begin + size;
    begin.head.bytes = begin.head.span = (uint32_t)all;
    memcpy(judge.asked_memory + judge.end + sizeof begin, bytes, size);
    publish(&begin.head, sizeof begin);
    remember(id, all);
}

/* Sends the objects of this call that the unit's process lacks. */
static void publish_objects(void)
{
    for (size_t i = 0; i < of_call_count; i++) {
        uint64_t id = last_of_slot[of_call[i]].id;
        if (place_of_id(id)->lap == judge.lap)
            continue;
        publish_object(id, last_of_slot[of_call[i]].bytes, last_of_slot[of_call[i]].size);
    }
}

static void publish_request(rk_judge_request *head)
{
    size_t bytes = head->span;
    for (size_t i = 0; i < of_call_count; i++)
        bytes += last_of_slot[of_call[i]].size + RK_JUDGE_KEPT_ALIGNMENT;
    make_room_in_lap(bytes);
    publish_objects();
    publish(head, head->bytes);
}

static uint64_t id_at(size_t place)
{
    return ((const rk_judge_kept *)(request_at(place) + 1))->id;
}

/* --- Requests that were published ------------------------------------------------------------ */

static uint32_t hash_of(const rk_judge_request *head)
{
    return (
        uint32_t)(hash_of_words(head + 1, head->bytes - sizeof *head, (uint32_t)head->function) >>
                  32);
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

static void learn_all(void)
{
    for (; judge.learnt != judge.end; judge.learnt += request_at(judge.learnt)->span)
        if (request_at(judge.learnt)->function >= 0 && is_open(judge.learnt))
            learn(judge.learnt);
}

/* Looks at the next request that the predictor has published; false if there is none. */
static bool look_at_next(void)
{
    if (judge.lap_is_over ||
        judge.known == atomic_load_explicit(&judge.asked->published, memory_order_acquire))
        return false;
    const rk_judge_request *head = request_at(judge.end);
    judge.known++;
    judge.end += head->span;
    judge.lap_is_over = head->function == RK_JUDGE_FROM_FRONT;
    if (head->function == RK_JUDGE_KEEP)
        remember(id_at(judge.end - head->span), head->span);
    return !judge.lap_is_over;
}

static void look_at_all(void)
{
    while (look_at_next()) {
    }
}

/* In most cases it is the next one of its function. */
static bool find_in_order(const rk_judge_request *head, size_t *place)
{
    size_t *next = &next_of[head->function];
    for (;;) {
        if (*next == judge.end && !look_at_next())
            return false;
        const rk_judge_request *request = request_at(*next);
        *place = *next;
        if (request->function == head->function && is_open(*next))
            return is_same(request, head);
        *next += request->span;
    }
}

static bool find_learnt(const rk_judge_request *head, size_t *place)
{
    look_at_all();
    learn_all();
    uint32_t hash = hash_of(head);
    for (uint32_t i = hash % SLOTS; slots[i].lap == judge.lap; i = (i + 1) % SLOTS)
        if (slots[i].hash == hash && is_open(slots[i].place) &&
            is_same(request_at(slots[i].place), head)) {
            *place = slots[i].place;
            return true;
        }
    return false;
}

/* Finds a request that was published, and that no call has taken. */
static bool find(const rk_judge_request *head, size_t *place)
{
    if (find_in_order(head, place))
        return true;
    if (judge.lap_is_over && judge.asked->predicted < judge.calls) { /* it waits to go on */
        begin_lap();
        rk_judge_wake(&judge.asked->lap, &judge.asked->predictor_waits);
        return find(head, place);
    }
    return next_of[head->function] != judge.end && find_learnt(head, place);
}

static void take(size_t place)
{
    taken_in[request_at(place)->number - judge.lap_begin] = judge.lap;
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
    map_what_comes();
}

static _Noreturn void end_as_predictor(void)
{
    judge.asked->predictor_ends = 1;
    wake_readers();
    _exit(0);
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
    judge.asked->predictor_ends = 0;
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
    look_at_all();
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
    bool has_ended =
        waitpid(predictor.process, NULL, judge.asked->predictor_ends ? 0 : WNOHANG) != 0;
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

/* The unit's process could read in a request what the reference answered before. */
static bool would_tell_an_answer(const rk_judge_request *head)
{
    return (judge.after[head->function] & judge.given) != 0;
}

/* A predictor could publish one such request and no other. */
static bool may_be_ahead(const rk_judge_request *head)
{
    return judge.after[head->function] != UINT64_MAX;
}

/* In the predictor: true where the reference is to be called. */
static bool predict(rk_judge_request *head)
{
    size_t place;
    bool is_known = find(head, &place);
    if (is_known)
        take(place);
    else if (would_tell_an_answer(head))
        judge.leaves_out = true;
    else {
        publish_request(head);
        take(judge.end - head->span);
    }
    atomic_store_explicit(&judge.asked->predicted, judge.calls, memory_order_release);
    if (judge.leaves_out && judge.known - predictor.begin >= AHEAD_MAX)
        end_as_predictor(); /* the next one knows the answers of these */
    bool is_answer_known = is_known && is_answered(request_at(place)->number);
    if (!is_answer_known)
        judge.given |= UINT64_C(1) << head->function;
    return !is_answer_known;
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
        else if (predictor.direct == 0 && may_be_ahead(head))
            begin_prediction();
        else {
            predictor.direct -= predictor.direct > 0;
            publish_request(head);
        }
    }
    if (judge.predicts)
        return predict(head);
    predictor.used++;
    wait_for_answer(request_at(place)->number);
    take(place);
    return false;
}

void *rk_judge_get_made(size_t count, size_t most, size_t size)
{
    rk_check(count <= most, "%zu values were allocated, want at most %zu", count, most);
    begin_own_memory();
    void *memory = rk_allocate_unset(count, size, "tree", NULL);
    end_own_memory();
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

/* RAYKIT_JUDGE names three descriptors: of both memories, and of the pipe. The unit's process gets
 * the first as well, but can write to it no more. */
void rk_judge_connect(const char *test)
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
    begin_at_front();
    judge.asked->lap = judge.lap = 1; /* 0 is that of slots without a request */
    predictor.batch = BATCH_MAX;
    predictor.direct = DIRECT_FIRST;
    predictor.direct_most = DIRECT_MIN;
    memcpy(judge.after, rk_judge_after, sizeof judge.after);
    for (const rk_judge_exception *it = rk_judge_exceptions; it->test; it++)
        if (strcmp(it->test, test) == 0)
            judge.after[it->function] = UINT64_MAX;
}

/* The predictor's work ends here. */
bool rk_judge_end_of_test(void)
{
    if (judge.predicts)
        end_as_predictor();
    return false;
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
