#include "judge/kept.h"
#include "base/error.h"
#include "judge/requests.h"
#include "judge_hooks.h"
#include "test.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

enum {
    KEPT_PLACES = 2 * RK_JUDGE_KEPT_MAX,
    GUARDED_AFTER = 8, /* calls with the same object */
    GUARDED_BYTES = 1 << 15,
};

/* The objects of this call, and the last ones of each slot. */
static int of_call[RK_JUDGE_KEPT_SLOTS]; /* slots */
static size_t of_call_count;
static struct last_object {
    uint64_t id;
    unsigned char *bytes;
    size_t size, room;
    rk_judge_piece pieces[RK_JUDGE_PIECES];
    size_t count;
    int seen;        /* so many times the same */
    bool is_guarded; /* whole pages of its pieces cannot be written to: so they are unchanged */
} last_of_slot[RK_JUDGE_KEPT_SLOTS];
/* What the unit's process has, until the next lap. */
static struct kept_id {
    uint64_t id;
    uint32_t lap;
} kept_ids[KEPT_PLACES];

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
    for (int slot = 0; slot < RK_JUDGE_KEPT_SLOTS; slot++) {
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
    rk_judge_begin_own_memory();
    if (size > last->room) {
        free(last->bytes);
        last->bytes = malloc(size);
        last->room = size;
    }
    rk_judge_end_own_memory();
    rk_check(last->bytes, "no memory for an object of %zu bytes", size);
    copy_pieces(last->bytes, pieces, count);
    last->size = size;
    last->id = rk_judge_hash_of_words(last->bytes, size, size);
    last->seen = 0;
}

/* Other memory could come to the same place. */
void rk_judge_forget(const void *memory)
{
    for (int slot = 0; slot < RK_JUDGE_KEPT_SLOTS; slot++)
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
    while (kept_ids[i].lap == rk_judge.lap && kept_ids[i].id != id)
        i = (i + 1) % KEPT_PLACES;
    return &kept_ids[i];
}

void rk_judge_object_is_there(uint64_t id, size_t bytes)
{
    *place_of_id(id) = (struct kept_id){id, rk_judge.lap};
    rk_judge.objects += bytes;
    rk_judge.object_count++;
}

static void publish_object(uint64_t id, const unsigned char *bytes, size_t size)
{
    struct {
        rk_judge_request head;
        rk_judge_kept kept;
    } begin = {{.function = RK_JUDGE_KEEP}, {.id = id, .bytes = size}};
    size_t all = sizeof begin + size;
    begin.head.bytes = begin.head.span = (uint32_t)all;
    memcpy(rk_judge.asked_memory + rk_judge.end + sizeof begin, bytes, size);
    rk_judge_publish(&begin.head, sizeof begin);
    rk_judge_object_is_there(id, all);
}

void rk_judge_begin_objects(void)
{
    of_call_count = 0;
}

size_t rk_judge_object_bytes(void)
{
    size_t bytes = 0;
    for (size_t i = 0; i < of_call_count; i++)
        bytes += last_of_slot[of_call[i]].size + RK_JUDGE_KEPT_ALIGNMENT;
    return bytes;
}

bool rk_judge_objects_are_there(void)
{
    for (size_t i = 0; i < of_call_count; i++)
        if (place_of_id(last_of_slot[of_call[i]].id)->lap != rk_judge.lap)
            return false;
    return true;
}

void rk_judge_publish_objects(void)
{
    for (size_t i = 0; i < of_call_count; i++) {
        uint64_t id = last_of_slot[of_call[i]].id;
        if (place_of_id(id)->lap == rk_judge.lap)
            continue;
        publish_object(id, last_of_slot[of_call[i]].bytes, last_of_slot[of_call[i]].size);
    }
}
