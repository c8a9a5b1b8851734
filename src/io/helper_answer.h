/* What precedes each answer of a helper program that stays (io/helper.h), in native byte order.
 * Common to the library (C) and raykit-image (C++); not installed. */
#ifndef RK_IO_HELPER_ANSWER_H
#define RK_IO_HELPER_ANSWER_H

#include <stdint.h>

typedef struct rk_helper_answer {
    uint64_t size;   /* of the bytes that follow */
    uint64_t failed; /* 1: they are the reason, one line; else 0 */
} rk_helper_answer;

#endif
