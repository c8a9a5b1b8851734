/* Pages of memory and who may read and write them, by tools/site/memory.c. */
#ifndef SITE_MMAN_H
#define SITE_MMAN_H

#include <stddef.h>

enum { PROT_NONE = 0, PROT_READ = 1, PROT_WRITE = 2 };
enum { MAP_PRIVATE = 2, MAP_ANONYMOUS = 32, MAP_NORESERVE = 0x4000 };
#define MAP_FAILED ((void *)-1)

void *mmap(void *at, size_t size, int protection, int flags, int file, long long offset);
int munmap(void *start, size_t size);
int mprotect(void *start, size_t size, int protection);

/* Sets bit 0 of each page's byte if the page was read or written. */
int mincore(void *start, size_t size, unsigned char *touched);

#endif
