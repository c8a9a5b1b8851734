/* The main of the process that runs a unit: it waits for a judge's requests, and answers them. It
 * knows nothing of the suite, nor of what is wanted. */
#define _DEFAULT_SOURCE /* for MAP_NORESERVE */
#include "judge/unit.h"
#include "judge/protocol.h"
#include "test.h"

#include <sys/mman.h>

enum { BETWEEN_ROOMS = 64, CLOSED_AT_ONCE = 65536 };

static struct {
    const rk_judge_asked *asked;
    rk_judge_answered *answered;
    unsigned char *rooms;
    size_t rooms_end, closed_end;
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
    else
        memset(unit.rooms + begin, 0xa5, bytes);
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

static void open_request(const rk_judge_request *head)
{
    if (__asan_unpoison_memory_region)
        __asan_unpoison_memory_region(head, head->bytes);
}

static void answer_request(const unsigned char *requests, unsigned char *answers, size_t place)
{
    const rk_judge_request *head = (const rk_judge_request *)(requests + place);
    rk_unit_call.request = requests + place + sizeof *head;
    rk_unit_call.answer = answers + place;
    rk_unit_functions[head->function]();
    close_rooms();
    open_request(head);
}

static void serve(const unsigned char *requests, unsigned char *answers)
{
    size_t place = RK_JUDGE_FIRST;
    for (uint32_t count = 0;; count++) {
        while (atomic_load_explicit(&unit.asked->published, memory_order_acquire) == count)
            rk_judge_wait(&unit.asked->published, count, &unit.answered->is_waiting);
        if (unit.asked->ended)
            return;
        const rk_judge_request *head = (const rk_judge_request *)(requests + place);
        if (head->function != RK_JUDGE_FROM_FRONT)
            answer_request(requests, answers, place);
        place = head->function == RK_JUDGE_FROM_FRONT ? RK_JUDGE_FIRST : place + head->span;
        atomic_store_explicit(&unit.answered->answered, count + 1, memory_order_release);
        bool is_all =
            atomic_load_explicit(&unit.asked->published, memory_order_acquire) == count + 1;
        if (is_all || count % RK_JUDGE_BATCH == 0)
            rk_judge_wake(&unit.answered->answered, &unit.asked->is_waiting);
    }
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
    unit.rooms = mmap((void *)RK_JUDGE_ROOMS, RK_JUDGE_BYTES, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (requests == MAP_FAILED || answers == MAP_FAILED || unit.rooms == MAP_FAILED) {
        perror("the memory that a unit shares with its judge cannot be seen");
        return 2;
    }
    unit.asked = (const rk_judge_asked *)requests;
    unit.answered = (rk_judge_answered *)answers;
    serve(requests, answers);
    bool leaks = __lsan_do_recoverable_leak_check && __lsan_do_recoverable_leak_check() != 0;
    return leaks ? RK_JUDGE_LEAKS : 0;
}
