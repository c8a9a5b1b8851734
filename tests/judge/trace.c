/* Looks at the requests that a test makes of the reference, which answers in place of a unit. With
 * RAYKIT_DISTURB, a bit for each function, the answers of these are made slightly wrong, and failed
 * claims are passed over. Functions whose requests become others depend on such answers: so a
 * predictor may not publish them before the unit has given these (tests/judge/judge.h). For each
 * function, its number, how many requests it had and their hash are written to RAYKIT_TRACE. */
#include "base/error.h"
#include "judge/judge.h"
#include "judge_hooks.h"
#include "test.h"

#include <inttypes.h>

enum { SAMPLED_WORDS = 512 }; /* of a large object, which many calls have */

struct rk_judge_call rk_judge_call;
static uint64_t disturbed;
static struct traced {
    uint64_t count, hash;
} traced[RK_JUDGE_FUNCTIONS];

static uint64_t with_word(uint64_t hash, const unsigned char *bytes, size_t size)
{
    uint64_t word = 0;
    memcpy(&word, bytes, size < sizeof word ? size : sizeof word);
    hash = (hash ^ word) * 0x9e3779b97f4a7c15;
    return hash ^ hash >> 32;
}

static uint64_t with_bytes(uint64_t hash, const void *bytes, size_t size, size_t step)
{
    for (size_t i = 0; i < size; i += step)
        hash = with_word(hash, (const unsigned char *)bytes + i, size - i);
    return hash;
}

void rk_judge_grow(size_t bytes)
{
    rk_judge_call.room = 2 * bytes;
    rk_judge_call.request = realloc(rk_judge_call.request, rk_judge_call.room);
    if (!rk_judge_call.request)
        abort();
}

void rk_judge_ask(int function)
{
    rk_judge_call.size = 0;
    rk_judge_put(&function, sizeof function);
}

void rk_judge_put_kept(int slot, const rk_judge_piece *pieces, size_t count)
{
    uint64_t hash = (uint64_t)slot;
    for (size_t i = 0; i < count; i++)
        hash = with_bytes(hash, pieces[i].data, pieces[i].bytes,
                          8 * (1 + pieces[i].bytes / (8 * SAMPLED_WORDS)));
    rk_judge_put(&hash, sizeof hash);
}

static int asked(void)
{
    return *(const int *)rk_judge_call.request;
}

bool rk_judge_predicts(size_t bytes_max)
{
    (void)bytes_max;
    struct traced *it = &traced[asked()];
    it->count++;
    it->hash = with_bytes(it->hash, rk_judge_call.request, rk_judge_call.size, 8);
    return true;
}

static unsigned next_random(void)
{
    static unsigned state = 1;
    state = state * 1664525 + 1013904223;
    return state >> 16;
}

/* A number from 0 to 1 stays one: it may be an index of the test's. */
void rk_judge_disturb(void *data, size_t bytes)
{
    unsigned char *at = data;
    if (!(disturbed & UINT64_C(1) << asked()))
        return;
    if (bytes == 1 && next_random() % 8 == 0)
        at[0] ^= 1;
    for (size_t i = 0; i + 4 <= bytes; i += 4)
        if (next_random() % 64 == 0)
            memset(at + i, 0, 4);
        else if (next_random() % 2 == 0)
            at[i] ^= 1;
}

void *rk_judge_get_made(size_t count, size_t most, size_t size)
{
    (void)count, (void)most, (void)size;
    abort(); /* the reference has answered */
}

void rk_judge_get_allocations(void)
{
}

void rk_judge_cannot_ask(const char *function)
{
    fprintf(stderr, "%s cannot be asked\n", function);
    exit(2);
}

void rk_judge_connect(const char *test)
{
    (void)test;
    const char *mask = getenv("RAYKIT_DISTURB");
    disturbed = mask ? strtoull(mask, NULL, 0) : 0;
}

bool rk_judge_end_of_test(void)
{
    return disturbed != 0;
}

void rk_judge_forget(const void *memory)
{
    (void)memory;
}

void rk_judge_disconnect(void)
{
    const char *path = getenv("RAYKIT_TRACE");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    for (int i = 0; i < RK_JUDGE_FUNCTIONS; i++)
        if (traced[i].count)
            fprintf(file, "%d %" PRIu64 " %016" PRIx64 "\n", i, traced[i].count, traced[i].hash);
    fclose(file);
}
