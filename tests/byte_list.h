/* Files that a suite makes byte by byte. */
#ifndef RK_TESTS_BYTE_LIST_H
#define RK_TESTS_BYTE_LIST_H

#include "test.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct byte_list {
    unsigned char bytes[1000];
    size_t size;
} byte_list;

static inline void append(byte_list *list, const void *bytes, size_t size)
{
    assert_true(list->size + size <= sizeof list->bytes);
    memcpy(list->bytes + list->size, bytes, size);
    list->size += size;
}

/* Little-endian, at the index-th four bytes. */
static inline void put_word(unsigned char *header, int index, uint32_t word)
{
    for (int i = 0; i < 4; i++)
        header[4 * index + i] = (unsigned char)(word >> 8 * i);
}

#endif
