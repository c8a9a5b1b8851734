/* WebAssembly's setjmp takes exceptions; a claim here ends with its instance instead. */
#ifndef SITE_SETJMP_H
#define SITE_SETJMP_H
#endif
