/* Memory that is watched, for claims in a page: WebAssembly itself lets a program read and write
 * all that it has. Units are compiled with clang's address sanitizer, whose checks call
 * __asan_load4 and so on before each access; what these know is kept here, and is of two kinds:
 *
 *   - bytes that belong to nothing: beside and in freed blocks of malloc, and beside globals
 *     (Serebryany et al., "AddressSanitizer: a fast address sanity checker", 2012), a bit for each;
 *   - pages of 4 KiB that mprotect closed, or that nothing has touched yet (mincore). A closed page
 *     calls the handler of SIGSEGV, as a processor does.
 *
 * The margins of variables on the stack are kept by the compiler itself. Suites and the
 * kit's own objects are not checked, but for what reads through a unit's pointers. */
#include "page.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

enum { page_bits = 12, page_size = 1 << page_bits, page_count = 1 << (32 - page_bits) };
enum { no_read = 1, no_write = 2, untouched = 4, has_poison = 8 };

/* A bit for each byte, and so many more that the last one's word can be read. */
enum { poison_size = page_size / 8 + sizeof(uint32_t) };

/* The lowest addresses, as toolchain.mjs links: the stack, what is known of variables on it, and
 * the state of each page, both at constant addresses, since every access asks for them. */
enum { stack_end = 8 << 20, known_bytes = 256 << 20 };
static int8_t *const margins = (int8_t *)stack_end;
static uint8_t *const state_of = (uint8_t *)(stack_end + known_bytes / 8);
static uint8_t **poison_of; /* of each page that has_poison; made when an instance begins */
static uint8_t all_poison[poison_size]; /* of pages that belong to nothing as a whole */

void *__real_malloc(size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void __real_free(void *memory);

/* Of tests/count_allocations.c. */
void __sanitizer_malloc_hook(const volatile void *memory, size_t size);
void __sanitizer_free_hook(const volatile void *memory);

/* Returns zeros. */
static char *grow(size_t size)
{
    const size_t grown = 65536;
    size_t before = __builtin_wasm_memory_grow(0, (size + grown - 1) / grown);
    return before == SIZE_MAX ? NULL : (char *)(before * grown);
}

/* Before all code that is checked. The lowest page is the stack's last: what overflows it is
 * caught, too. */
__attribute__((constructor(1))) static void begin(void)
{
    if (poison_of) /* a constructor that registers globals came first */
        return;
    poison_of = (uint8_t **)(void *)grow(page_count * sizeof *poison_of);
    state_of[0] = no_read | no_write;
    memset(all_poison, 0xff, sizeof all_poison);
}

/* --- Bytes that belong to nothing ------------------------------------------------------------- */

/* What is known of a page's bytes, for what changes a part of it. */
static uint8_t *own_poison(uintptr_t page)
{
    const uint8_t *before = poison_of[page];
    if (!before || before == all_poison) {
        poison_of[page] = __real_malloc(poison_size);
        memset(poison_of[page], before ? 0xff : 0, poison_size);
        state_of[page] |= has_poison;
    }
    return poison_of[page];
}

static void set_page_poison(uintptr_t page, bool is_set)
{
    if (poison_of[page] != all_poison)
        __real_free(poison_of[page]);
    poison_of[page] = is_set ? all_poison : NULL;
    state_of[page] = (uint8_t)((state_of[page] & ~has_poison) | (is_set ? has_poison : 0));
}

static void set_poison(uintptr_t start, size_t size, bool is_set)
{
    while (size > 0) {
        const uintptr_t page = start >> page_bits;
        const size_t first = start & (page_size - 1);
        const size_t count = size < page_size - first ? size : page_size - first;
        start += count;
        size -= count;
        if (count == page_size)
            set_page_poison(page, is_set);
        if (count == page_size || (!poison_of[page] && !is_set))
            continue;
        uint8_t *poison = own_poison(page);
        for (size_t i = first; i < first + count; i++) {
            if (i % 8 == 0 && i + 8 <= first + count) {
                poison[i / 8] = is_set ? 0xff : 0;
                i += 7;
            } else if (is_set)
                poison[i / 8] |= (uint8_t)(1 << i % 8);
            else
                poison[i / 8] &= (uint8_t) ~(1 << i % 8);
        }
    }
}

static bool is_poisoned(uintptr_t at)
{
    const uint8_t *poison = poison_of[at >> page_bits];
    return poison && (poison[at % page_size / 8] >> at % 8 & 1) != 0;
}

/* --- Blocks ----------------------------------------------------------------------------------- */

/* New memory has no zeros by chance: as natively, so much of it has this byte. */
enum { filled_bytes = 4096, filling = 0xbe };

enum { margin = 32 }; /* bytes on each side of a block, the header among those before it */

typedef struct block {
    struct block *previous, *next; /* of all blocks; once freed, of those that wait */
    void *memory;                  /* as malloc returned it */
    size_t size;
    uint32_t mark; /* of its address, so that other memory is hardly taken for a block */
    bool is_freed;
} block;

_Static_assert(sizeof(block) <= margin, "a header fits before its block");

static block *blocks, *freed_first, *freed_last;
static size_t freed_bytes;
static const size_t freed_bytes_at_most = (size_t)4 << 20;

static uint32_t mark_of(const block *b)
{
    return (uint32_t)(uintptr_t)b ^ 0x5eed1e57;
}

static uintptr_t start_of(const block *b)
{
    return (uintptr_t)b + margin;
}

static void *allocate(size_t alignment, size_t size)
{
    size_t before = alignment > margin ? alignment : margin;
    if (size > SIZE_MAX / 2)
        return NULL;
    size_t whole = (before + size + margin + alignment - 1) / alignment * alignment;
    char *memory = __real_aligned_alloc(alignment, whole);
    if (!memory)
        return NULL;
    block *b = (block *)(void *)(memory + before - margin);
    *b = (block){.next = blocks, .memory = memory, .size = size, .mark = mark_of(b)};
    if (blocks)
        blocks->previous = b;
    blocks = b;
    set_poison((uintptr_t)b, margin, true);
    set_poison(start_of(b) + size, margin, true);
    memset((void *)start_of(b), filling, size < filled_bytes ? size : filled_bytes);
    __sanitizer_malloc_hook((void *)start_of(b), size);
    return (void *)start_of(b);
}

static void forget_oldest(void)
{
    block *b = freed_first;
    freed_first = b->next;
    if (!freed_first)
        freed_last = NULL;
    freed_bytes -= b->size;
    set_poison((uintptr_t)b, margin + b->size + margin, false);
    __real_free(b->memory);
}

/* Replace libc's, by wasm-ld --wrap. */
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
    return allocate(16, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    return allocate(alignment > 16 ? alignment : 16, size);
}

void *__wrap_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size)
{
    size_t whole;
    if (__builtin_mul_overflow(count, size, &whole))
        return NULL;
    void *memory = allocate(16, whole);
    return memory ? memset(memory, 0, whole) : NULL;
}

void __wrap_free(void *memory);
void __wrap_free(void *memory)
{
    if (!memory)
        return;
    block *b = (block *)(void *)((char *)memory - margin);
    if ((uintptr_t)memory < page_size || b->mark != mark_of(b) || b->is_freed) {
        site_fault("free is called for memory that is freed already, or that malloc did not return",
                   "", 0);
        __builtin_trap();
    }
    __sanitizer_free_hook(memory);
    if (b->previous)
        b->previous->next = b->next;
    else
        blocks = b->next;
    if (b->next)
        b->next->previous = b->previous;
    b->is_freed = true;
    b->next = NULL;
    set_poison(start_of(b), b->size, true);
    if (freed_last)
        freed_last->next = b;
    else
        freed_first = b;
    freed_last = b;
    freed_bytes += b->size;
    while (freed_bytes > freed_bytes_at_most)
        forget_oldest();
}

void *__wrap_realloc(void *old, size_t size);
void *__wrap_realloc(void *old, size_t size)
{
    void *memory = allocate(16, size);
    if (old && memory) {
        size_t had = ((block *)(void *)((char *)old - margin))->size;
        memcpy(memory, old, had < size ? had : size);
        __wrap_free(old);
    }
    return memory;
}

/* --- Variables -------------------------------------------------------------------------------- */

/* What the code of units writes beside its variables: 0 for 8 bytes that may be used, 1 to 7 if
 * only so many may, else a negative number. */
static __attribute__((noinline)) bool is_beside_variable(uintptr_t at, size_t size)
{
    for (uintptr_t i = at; i < at + size; i = (i | 7) + 1) {
        uintptr_t end = (i | 7) < at + size ? (i | 7) + 1 : at + size;
        if (margins[i / 8] != 0 &&
            (margins[i / 8] < 0 || (intptr_t)((end - 1) % 8) >= margins[i / 8]))
            return true;
    }
    return false;
}

/* --- Faults ----------------------------------------------------------------------------------- */

static struct sigaction handler;

int sigaction(int signal, const struct sigaction *now, struct sigaction *before)
{
    if (signal != SIGSEGV)
        return 0;
    if (before)
        *before = handler;
    if (now)
        handler = *now;
    return 0;
}

static const block *block_near(const block *b, uintptr_t at)
{
    while (b && (at + margin < start_of(b) || at >= start_of(b) + b->size + margin))
        b = b->next;
    return b;
}

/* Says where `at` is in the block that it is in or beside, if there is one. */
static void tell_block(char *text, size_t length, uintptr_t at)
{
    const block *b = block_near(blocks, at);
    if (!b)
        b = block_near(freed_first, at);
    if (!b)
        return;
    uintptr_t start = start_of(b), end = start + b->size;
    if (b->is_freed)
        snprintf(text, length, " of a block of %zu bytes that is freed already", b->size);
    else if (at == end)
        snprintf(text, length, " beyond the end of a block of %zu bytes that malloc gave", b->size);
    else if (at > end)
        snprintf(text, length,
                 ", %zu bytes beyond the end of a block of %zu bytes that malloc gave",
                 (size_t)(at - end), b->size);
    else if (at < start)
        snprintf(text, length, ", %zu bytes before a block of %zu bytes that malloc gave",
                 (size_t)(start - at), b->size);
    else
        snprintf(text, length, " of a block of %zu bytes that malloc gave, too few", b->size);
}

static _Noreturn void report(bool writes, uintptr_t at, size_t size)
{
    if (at < page_size &&
        (uintptr_t)__builtin_frame_address(0) < 2 * page_size) { /* its end is at 0 */
        site_fault("the stack is used up: does a function call itself for ever?", "", 0);
        __builtin_trap();
    }
    char text[400], where[200] = " of memory that is not its own";
    const block *b = block_near(blocks, at);
    uintptr_t end = b ? start_of(b) + b->size : 0;
    if (at < end && at + size > end) { /* the part that is beyond it */
        size -= end - at;
        at = end;
    }
    if (at < page_size)
        snprintf(where, sizeof where, " by a pointer that is NULL, or almost");
    else if (at < stack_end)
        snprintf(where, sizeof where,
                 " just outside of a variable, or of one that is gone with its block");
    else
        tell_block(where, sizeof where, at);
    snprintf(text, sizeof text, "%s %zu byte%s%s", writes ? "writes" : "reads", size,
             size == 1 ? "" : "s", where);
    site_fault(text, "", 0);
    __builtin_trap();
}

/* A handler may open the page, and may close it again. */
static void fault(uintptr_t at, size_t size, bool writes)
{
    uint8_t closed = writes ? no_write : no_read;
    for (int i = 0; i < 1000 && handler.sa_sigaction; i++) {
        uintptr_t where = (state_of[at >> page_bits] & closed) != 0 ? at : at + size - 1;
        if ((state_of[where >> page_bits] & closed) == 0)
            return;
        siginfo_t info = {(void *)where};
        handler.sa_sigaction(SIGSEGV, &info, NULL);
    }
    report(writes, at, size);
}

static __attribute__((noinline)) void look(uintptr_t at, size_t size, bool writes)
{
    uint8_t closed = writes ? no_write : no_read;
    for (uintptr_t page = at >> page_bits; page <= (at + size - 1) >> page_bits; page++) {
        uintptr_t first = page << page_bits > at ? page << page_bits : at;
        uintptr_t end = (page + 1) << page_bits < at + size ? (page + 1) << page_bits : at + size;
        if (state_of[page] & closed)
            fault(first, end - first, writes);
        state_of[page] &= (uint8_t)~untouched;
        for (uintptr_t i = first; i < end && state_of[page] & has_poison; i++)
            if (i % 8 == 0 && i + 8 <= end && poison_of[page][i % page_size / 8] == 0)
                i += 7;
            else if (is_poisoned(i))
                report(writes, i, end - i);
    }
}

/* Of up to 16 bytes: most are in one page, whose bits a word has. */
static inline void check(uintptr_t at, size_t size, bool writes)
{
    if (at < stack_end && (margins[at / 8] != 0 || at % 8 + size > 8) &&
        is_beside_variable(at, size))
        report(writes, at, size);
    size_t first = at % page_size;
    uint8_t state = state_of[at >> page_bits];
    if (first + size <= page_size && (state & ~has_poison) == 0) {
        uint32_t bits = 0;
        if (state)
            memcpy(&bits, &poison_of[at >> page_bits][first / 8], sizeof bits);
        if ((bits >> first % 8 & ((1u << size) - 1)) == 0)
            return;
    }
    look(at, size, writes);
}

/* --- What the compiler calls ------------------------------------------------------------------ */

#define ACCESS(bytes)                                                                              \
    void __asan_load##bytes(uintptr_t at);                                                         \
    void __asan_load##bytes(uintptr_t at)                                                          \
    {                                                                                              \
        check(at, bytes, false);                                                                   \
    }                                                                                              \
    void __asan_store##bytes(uintptr_t at);                                                        \
    void __asan_store##bytes(uintptr_t at)                                                         \
    {                                                                                              \
        check(at, bytes, true);                                                                    \
    }

ACCESS(1)
ACCESS(2)
ACCESS(4)
ACCESS(8)
ACCESS(16)

void __asan_loadN(uintptr_t at, size_t size);
void __asan_loadN(uintptr_t at, size_t size)
{
    if (size == 0)
        return;
    if (at < stack_end && is_beside_variable(at, size))
        report(false, at, size);
    look(at, size, false);
}

void __asan_storeN(uintptr_t at, size_t size);
void __asan_storeN(uintptr_t at, size_t size)
{
    if (size == 0)
        return;
    if (at < stack_end && is_beside_variable(at, size))
        report(true, at, size);
    look(at, size, true);
}

/* Most copies are of a struct, for which engines' own instruction, which calls a function outside
 * of the program, takes longer. */
enum { small = 64 };

__attribute__((no_builtin("memcpy"))) static inline void copy_small(char *to, const char *from,
                                                                    size_t size)
{
    size_t i = 0;
    for (; i + sizeof(uint64_t) <= size; i += sizeof(uint64_t))
        __builtin_memcpy(&to[i], &from[i], sizeof(uint64_t));
    for (; i < size; i++)
        to[i] = from[i];
}

void *__asan_memcpy(void *to, const void *from, size_t size);
void *__asan_memcpy(void *to, const void *from, size_t size)
{
    __asan_loadN((uintptr_t)from, size);
    __asan_storeN((uintptr_t)to, size);
    if (size > small)
        return memcpy(to, from, size);
    copy_small(to, from, size);
    return to;
}

void *__asan_memmove(void *to, const void *from, size_t size);
void *__asan_memmove(void *to, const void *from, size_t size)
{
    __asan_loadN((uintptr_t)from, size);
    __asan_storeN((uintptr_t)to, size);
    return memmove(to, from, size);
}

void *__asan_memset(void *to, int value, size_t size);
void *__asan_memset(void *to, int value, size_t size)
{
    __asan_storeN((uintptr_t)to, size);
    return memset(to, value, size);
}

#define SET_SHADOW(name, value)                                                                    \
    void __asan_set_shadow_##name(void *start, size_t size);                                       \
    void __asan_set_shadow_##name(void *start, size_t size)                                        \
    {                                                                                              \
        memset(start, value, size);                                                                \
    }

SET_SHADOW(00, 0)
SET_SHADOW(01, 1)
SET_SHADOW(02, 2)
SET_SHADOW(03, 3)
SET_SHADOW(04, 4)
SET_SHADOW(05, 5)
SET_SHADOW(06, 6)
SET_SHADOW(07, 7)
SET_SHADOW(f1, 0xf1)
SET_SHADOW(f2, 0xf2)
SET_SHADOW(f3, 0xf3)
SET_SHADOW(f5, 0xf5)
SET_SHADOW(f8, 0xf8)

typedef struct global {
    uintptr_t start;
    size_t size, size_with_margin;
    const char *name, *module;
    uintptr_t is_dynamic, place, odr;
} global;

void __asan_register_globals(const global *globals, size_t count);
void __asan_register_globals(const global *globals, size_t count)
{
    begin();
    for (size_t i = 0; i < count; i++)
        set_poison(globals[i].start + globals[i].size,
                   globals[i].size_with_margin - globals[i].size, true);
}

void __asan_unregister_globals(const global *globals, size_t count);
void __asan_unregister_globals(const global *globals, size_t count)
{
    (void)globals, (void)count;
}

void __asan_handle_no_return(void);
void __asan_handle_no_return(void)
{
}

void __asan_version_mismatch_check_v8(void);
void __asan_version_mismatch_check_v8(void)
{
}

void __asan_init(void);
void __asan_init(void)
{
}

/* Called at each branch of a unit that is run again because a claim did not end: stops after five
 * seconds, so that the engine's list of calls tells where. */
void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    static const int64_t limit = 5000000000; /* ns */
    static struct timespec begun;
    static uint32_t calls;
    if (calls++ % (1 << 16) != 0)
        return;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (calls == 1)
        begun = now;
    if ((now.tv_sec - begun.tv_sec) * 1000000000LL + now.tv_nsec - begun.tv_nsec >= limit)
        __builtin_trap();
}

/* --- Pages ------------------------------------------------------------------------------------ */

static const size_t large = (size_t)1 << 20;

static struct {
    char *start;
    size_t size;
} unmapped[16];

static size_t whole_pages(size_t size)
{
    return (size + page_size - 1) / page_size * page_size;
}

static void set_state(void *start, size_t size, uint8_t clear, uint8_t set)
{
    uintptr_t page = (uintptr_t)start >> page_bits;
    for (size_t i = 0; i < whole_pages(size) / page_size; i++)
        state_of[page + i] = (uint8_t)((state_of[page + i] & ~clear) | set);
}

/* Memory that was mapped before, or else grown; all of it zeros, which the latter is untouched. */
static char *map_large(size_t size)
{
    for (size_t i = 0; i < sizeof unmapped / sizeof *unmapped; i++)
        if (unmapped[i].start && unmapped[i].size == size) {
            char *start = memset(unmapped[i].start, 0, size);
            unmapped[i].start = NULL;
            return start;
        }
    return grow(size);
}

void *mmap(void *at, size_t size, int protection, int flags, int file, long long offset)
{
    (void)at, (void)flags, (void)file, (void)offset;
    size = whole_pages(size);
    char *start = size >= large ? map_large(size) : __real_aligned_alloc(page_size, size);
    if (!start)
        return MAP_FAILED;
    if (size < large)
        memset(start, 0, size);
    set_state(start, size, 0xff & ~has_poison, untouched);
    mprotect(start, size, protection);
    return start;
}

int munmap(void *start, size_t size)
{
    size = whole_pages(size);
    set_state(start, size, 0xff & ~has_poison, 0);
    if (size < large)
        __real_free(start);
    for (size_t i = 0; i < sizeof unmapped / sizeof *unmapped && size >= large; i++)
        if (!unmapped[i].start) {
            unmapped[i].start = start;
            unmapped[i].size = size;
            break;
        }
    return 0;
}

int mprotect(void *start, size_t size, int protection)
{
    uint8_t closed =
        (protection & PROT_READ ? 0 : no_read) | (protection & PROT_WRITE ? 0 : no_write);
    set_state(start, size, no_read | no_write, closed);
    return 0;
}

int mincore(void *start, size_t size, unsigned char *touched)
{
    uintptr_t page = (uintptr_t)start >> page_bits;
    for (size_t i = 0; i < whole_pages(size) / page_size; i++)
        touched[i] = (state_of[page + i] & untouched) == 0;
    return 0;
}

long sysconf(int name)
{
    return name == _SC_PAGESIZE ? page_size : -1;
}

/* --- Threads ---------------------------------------------------------------------------------- */

int pthread_attr_init(pthread_attr_t *attributes)
{
    *attributes = (pthread_attr_t){NULL, 0};
    return 0;
}

int pthread_attr_setstack(pthread_attr_t *attributes, void *stack, size_t size)
{
    *attributes = (pthread_attr_t){stack, size};
    return 0;
}

int pthread_attr_destroy(pthread_attr_t *attributes)
{
    (void)attributes;
    return 0;
}

static __attribute__((noinline)) void run_on(char *stack, void *(*run)(void *), void *context)
{
    char *own;
    __asm__ volatile("global.get __stack_pointer\n local.set %0" : "=r"(own));
    __asm__ volatile("local.get %0\n global.set __stack_pointer" ::"r"(stack));
    run(context);
    __asm__ volatile("local.get %0\n global.set __stack_pointer" ::"r"(own));
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *context)
{
    *thread = 0;
    if (!attributes || !attributes->stack ||
        (uintptr_t)attributes->stack + attributes->size > known_bytes)
        return EAGAIN;
    run_on(attributes->stack + attributes->size, run, context);
    return 0;
}

int pthread_join(pthread_t thread, void **result)
{
    (void)thread, (void)result;
    return 0;
}
