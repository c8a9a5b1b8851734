/* Threads with a stack of their own, as suites use them to measure it: pthread_create runs the
 * thread to its end. */
#ifndef SITE_PTHREAD_H
#define SITE_PTHREAD_H

#include <stddef.h>

typedef int pthread_t;
typedef struct pthread_attr_t {
    char *stack;
    size_t size;
} pthread_attr_t;

int pthread_attr_init(pthread_attr_t *attributes);
int pthread_attr_setstack(pthread_attr_t *attributes, void *stack, size_t size);
int pthread_attr_destroy(pthread_attr_t *attributes);
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *context);
int pthread_join(pthread_t thread, void **result);

#endif
