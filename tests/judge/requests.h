/* The memory for requests to the unit's process, and waiting for their answers. It is used in laps,
 * from its front to its end. */
#ifndef RK_TESTS_JUDGE_REQUESTS_H
#define RK_TESTS_JUDGE_REQUESTS_H

#include "judge/judge.h"

enum {
    RK_JUDGE_LAP_BYTES = 16 << 20,
    RK_JUDGE_LAP_REQUESTS = 1 << 17,
};

extern struct rk_judge {
    unsigned char *asked_memory;
    const unsigned char *answered_memory;
    rk_judge_asked *asked;
    const rk_judge_answered *answered;
    int unit;        /* end of a pipe that the unit's process keeps open */
    bool predicts;   /* this process goes on with the reference's answers: see judge.c */
    bool speculates; /* and is the judge nevertheless, as long as the unit's are the same */
    uint64_t calls;
    uint32_t lap, lap_begin; /* the number of its first request */
    uint32_t known;          /* requests so far, as this process knows them */
    size_t end;              /* their end */
    size_t mapped_end;       /* of this process, if it predicts */
    size_t objects;          /* bytes of this lap that are objects, and their number: */
    uint32_t object_count;
    bool lap_is_over;
} rk_judge;

static inline const rk_judge_request *rk_judge_request_at(size_t place)
{
    return (const rk_judge_request *)(rk_judge.asked_memory + place);
}

static inline bool rk_judge_is_answered(uint32_t number)
{
    uint32_t answered = atomic_load_explicit(&rk_judge.answered->answered, memory_order_acquire);
    return (int32_t)(answered - number) > 0;
}

/* Has all be seen that was published. */
void rk_judge_wake_readers(void);

bool rk_judge_unit_has_ended(void);

/* Fails the test if the unit's process ends before. */
void rk_judge_wait_for_answer(uint32_t number);

/* The judge begins first, when it is past all that a predictor will then overwrite. */
void rk_judge_begin_lap(void);

/* Has the next pages of both memories mapped. */
void rk_judge_map_next_pages(void);

bool rk_judge_lap_is_full(size_t requests);
void rk_judge_make_room_in_lap(size_t bytes, size_t requests);
void rk_judge_publish_end_of_lap(void);

/* Copies the first bytes of a request, whose others stand there already. */
void rk_judge_publish(rk_judge_request *head, size_t bytes);

/* The judge's own memory is none of the unit's, whose allocations are counted. */
void rk_judge_begin_own_memory(void);
void rk_judge_end_own_memory(void);

/* Of whole words of 8 bytes. */
static inline uint64_t rk_judge_hash_of_words(const void *bytes, size_t size, uint64_t hash)
{
    for (size_t i = 0; i < size; i += sizeof hash) {
        uint64_t word;
        memcpy(&word, (const unsigned char *)bytes + i, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 32;
    }
    return hash;
}

#endif
