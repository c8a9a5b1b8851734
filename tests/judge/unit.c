/* The main of the process that runs a unit: it waits for a judge's requests, and answers them. It
 * knows nothing of the suite, nor of what is wanted. */
#define _DEFAULT_SOURCE /* for MAP_NORESERVE */
#include "judge/unit.h"
#include "judge/protocol.h"
#include "test.h"

#include <errno.h>
#include <sys/mman.h>
#include <unistd.h>

enum { BETWEEN_ROOMS = 64, CLOSED_AT_ONCE = 65536 };

static struct {
    const rk_judge_asked *asked;
    rk_judge_answered *answered;
    unsigned char *rooms;
    size_t rooms_end, closed_end;
    unsigned char *kept;
    size_t kept_end;
} unit;

struct rk_unit_call rk_unit_call;

int __lsan_do_recoverable_leak_check(void) __attribute__((weak));
void __asan_poison_memory_region(const volatile void *start, size_t size) __attribute__((weak));
void __asan_unpoison_memory_region(const volatile void *start, size_t size) __attribute__((weak));

/* Rooms lie in memory that is poisoned, each with some of it before and behind. */
static void close_from(size_t begin, size_t end)
{
    if (__asan_poison_memory_region && begin < end)
        __asan_poison_memory_region(unit.rooms + begin, end - begin);
}

void *rk_unit_room(const void *contents, size_t bytes)
{
    size_t begin = unit.rooms_end + BETWEEN_ROOMS, end = begin + rk_judge_aligned(bytes);
    if (end + CLOSED_AT_ONCE > RK_JUDGE_BYTES)
        exit(1);
    if (end + BETWEEN_ROOMS > unit.closed_end) {
        close_from(unit.closed_end, end + CLOSED_AT_ONCE);
        unit.closed_end = end + CLOSED_AT_ONCE;
    }
    unit.rooms_end = end;
    if (__asan_unpoison_memory_region)
        __asan_unpoison_memory_region(unit.rooms + begin, bytes);
    if (contents)
        memcpy(unit.rooms + begin, contents, bytes);
    else /* NaN as floats: what is not written is not taken for a small number */
        memset(unit.rooms + begin, 0xff, bytes);
    return unit.rooms + begin;
}

static void close_rooms(void)
{
    close_from(0, unit.rooms_end);
    unit.rooms_end = 0;
}

/* Before it stands whether there is one, and behind it nothing (RK_JUDGE_ALIGNMENT bytes). */
const void *rk_unit_take_array(size_t bytes)
{
    const unsigned char *value = rk_unit_take(bytes), *end = rk_unit_take(RK_JUDGE_ALIGNMENT);
    if (__asan_poison_memory_region) {
        __asan_poison_memory_region(value - RK_JUDGE_ALIGNMENT, RK_JUDGE_ALIGNMENT);
        size_t behind = (size_t)(end + RK_JUDGE_ALIGNMENT - (value + bytes));
        __asan_poison_memory_region(value + bytes, behind);
    }
    return value;
}

void rk_unit_give_made(void *values, size_t count, size_t most, size_t size)
{
    if (count <= most) /* of others the judge wants no more than the number */
        rk_unit_give(values, count * size);
    free(values);
}

/* --- Objects that are kept --- */

enum { KEPT_PLACES = 2 * RK_JUDGE_KEPT_MAX };
static struct kept {
    uint64_t id;
    unsigned char *bytes;
    size_t size;
    bool is_open;
} all_kept[KEPT_PLACES];
static size_t kept_count, kept_places[RK_JUDGE_KEPT_MAX];
static unsigned char *piece; /* of the object that is being opened */

static struct kept *place_of_id(uint64_t id)
{
    uint32_t i = (uint32_t)id % KEPT_PLACES;
    while (all_kept[i].id && all_kept[i].id != id)
        i = (i + 1) % KEPT_PLACES;
    return &all_kept[i];
}

static void keep(const rk_judge_request *head)
{
    const rk_judge_kept *sent = (const rk_judge_kept *)(head + 1);
    struct kept *kept = place_of_id(sent->id);
    if (kept->id)
        return;
    size_t page = (size_t)sysconf(_SC_PAGESIZE), pages = (sent->bytes + page - 1) / page * page;
    if (unit.kept_end + pages > RK_JUDGE_BYTES)
        exit(1);
    kept->bytes = unit.kept + unit.kept_end;
    unit.kept_end += pages;
    memcpy(kept->bytes, sent + 1, sent->bytes);
    kept->id = sent->id;
    kept->size = sent->bytes;
    kept_places[kept_count++] = (size_t)(kept - all_kept);
}

/* At the end of a lap: what is needed again is sent again. */
static void forget_all(void)
{
    while (kept_count > 0)
        all_kept[kept_places[--kept_count]] = (struct kept){0};
    if (__asan_unpoison_memory_region)
        __asan_unpoison_memory_region(unit.kept, unit.kept_end);
    mprotect(unit.kept, unit.kept_end, PROT_READ | PROT_WRITE);
    unit.kept_end = 0;
}

void *rk_unit_kept_piece(size_t bytes)
{
    unsigned char *begin = piece;
    piece += rk_judge_kept_aligned(bytes + RK_JUDGE_ALIGNMENT);
    if (__asan_poison_memory_region)
        __asan_poison_memory_region(begin + bytes, (size_t)(piece - begin) - bytes);
    return begin;
}

const void *rk_unit_take_kept(size_t bytes, void (*open)(void *structure))
{
    struct kept *kept = place_of_id(*(const uint64_t *)rk_unit_take(sizeof(uint64_t)));
    if (!kept->is_open) {
        piece = kept->bytes;
        open(rk_unit_kept_piece(bytes));
        mprotect(kept->bytes, kept->size, PROT_READ);
        kept->is_open = true;
    }
    return kept->bytes;
}

static void open_request(const rk_judge_request *head)
{
    if (__asan_unpoison_memory_region)
        __asan_unpoison_memory_region(head, head->bytes);
}

/* Rounding and flushing to zero, as another call may have left them. */
static void reset_floating_point(void)
{
#ifdef __SSE__
    const unsigned at_first = 0x1f80, flags = 0x3f;
    if ((__builtin_ia32_stmxcsr() & ~flags) != at_first)
        __builtin_ia32_ldmxcsr(at_first);
#endif
}

static void answer_request(const unsigned char *requests, unsigned char *answers, size_t place)
{
    const rk_judge_request *head = (const rk_judge_request *)(requests + place);
    rk_unit_call.request = requests + place + sizeof *head;
    rk_unit_call.answer = answers + place;
    errno = 0; /* no call finds what another one left there */
    reset_floating_point();
    rk_unit_functions[head->function]();
    close_rooms();
    open_request(head);
}

/* Waits for requests; returns the number after those that are answered next. */
static uint32_t end_of_run(uint32_t count)
{
    uint32_t published;
    while ((published = atomic_load_explicit(&unit.asked->published, memory_order_acquire)) ==
           count)
        rk_judge_wait(&unit.asked->published, count, &unit.answered->is_waiting);
    uint32_t run = RK_JUDGE_RUN - count % RK_JUDGE_RUN;
    return count + (published - count < run ? published - count : run);
}

static void count_answered(uint32_t count)
{
    atomic_store_explicit(&unit.answered->answered, count, memory_order_release);
    bool is_all = atomic_load_explicit(&unit.asked->published, memory_order_acquire) == count;
    if (is_all || count % RK_JUDGE_BATCH == 0)
        rk_judge_wake(&unit.answered->answered, &unit.asked->is_waiting);
}

static void serve(const unsigned char *requests, unsigned char *answers)
{
    size_t place = RK_JUDGE_FIRST;
    uint32_t run_end = 0;
    for (uint32_t count = 0;; count++) {
        if (count == run_end) {
            run_end = end_of_run(count);
            if (unit.asked->ended)
                return;
        }
        const rk_judge_request *head = (const rk_judge_request *)(requests + place);
        if (head->function == RK_JUDGE_KEEP)
            keep(head);
        else if (head->function == RK_JUDGE_FROM_FRONT)
            forget_all();
        else
            answer_request(requests, answers, place);
        place = head->function == RK_JUDGE_FROM_FRONT ? RK_JUDGE_FIRST : place + head->span;
        if (count + 1 == run_end)
            count_answered(run_end);
    }
}

/* Tells that it is done with a claim, the first one being 1, and waits for the next one; false if
 * there is none. */
static bool await_claim_after(uint32_t claim)
{
    forget_all();
    unit.answered->answered = 0;
    unit.answered->claims = claim;
    rk_judge_wake(&unit.answered->claims, &unit.asked->is_waiting);
    while (unit.asked->claims < claim)
        rk_judge_wait(&unit.asked->claims, claim - 1, &unit.answered->is_waiting);
    return unit.asked->ended != RK_JUDGE_END;
}

/* Answers for one claim after the other, or for the only one. */
static void serve_all(const unsigned char *requests, unsigned char *answers)
{
    serve(requests, answers);
    for (uint32_t claim = 1; unit.asked->ended != RK_JUDGE_END && await_claim_after(claim); claim++)
        serve(requests, answers);
}

static void *memory_at(uintptr_t place)
{
    return mmap((void *)place, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE,
                MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
}

/* --list is for a grader that tries how the sanitizers work. */
int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "--list") == 0)
        return 0;
    int asked, answered;
    const char *value = getenv("RAYKIT_JUDGE");
    if (!value || sscanf(value, "%d,%d", &asked, &answered) != 2)
        return 2;
    const unsigned char *requests =
        mmap((void *)RK_JUDGE_PLACE, RK_JUDGE_BYTES, PROT_READ, MAP_SHARED, asked, 0);
    unsigned char *answers =
        mmap(NULL, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, answered, 0);
    unit.rooms = memory_at(RK_JUDGE_ROOMS);
    unit.kept = memory_at(RK_JUDGE_OBJECTS);
    if (requests == MAP_FAILED || answers == MAP_FAILED || unit.rooms == MAP_FAILED ||
        unit.kept == MAP_FAILED) {
        perror("the memory that a unit shares with its judge cannot be seen");
        return 2;
    }
    unit.asked = (const rk_judge_asked *)requests;
    unit.answered = (rk_judge_answered *)answers;
    static char printed[4096]; /* so that the C library allocates none, and keeps it */
    setvbuf(stdout, printed, _IOFBF, sizeof printed);
    size_t kept = rk_allocations_kept;
    serve_all(requests, answers);
    bool leaks = __lsan_do_recoverable_leak_check && __lsan_do_recoverable_leak_check() != 0;
    /* The leak sanitizer finds no memory whose address somebody has hidden in the C library's. */
    leaks = leaks || (rk_allocations_are_counted && rk_allocations_kept > kept);
    fflush(stdout);
    _exit(leaks ? RK_JUDGE_LEAKS : 0); /* a handler of exit() could say something else */
}
