/* What an instance tells the page that runs it (tools/site/instance.mjs). */
#ifndef SITE_PAGE_H
#define SITE_PAGE_H

#define SITE_IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* The message of the claim that fails, and where it stands. */
SITE_IMPORT("message") void site_message(const char *text);
SITE_IMPORT("failed") void site_failed(const char *file, int line);

/* The claim holds; an instance that ends without it was ended by the unit. */
SITE_IMPORT("passed") void site_passed(void);

/* Undefined behaviour or a wrong access of memory; the page finds the line in the stack of calls
 * unless `place` says it. */
SITE_IMPORT("fault") void site_fault(const char *text, const char *place, int line);

#endif
