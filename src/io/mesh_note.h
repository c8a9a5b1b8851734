/* Notes on a mesh file: sentences worth printing, in one line; not installed. */
#ifndef RK_IO_MESH_NOTE_H
#define RK_IO_MESH_NOTE_H

#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Adds a sentence after the others. */
static inline void __attribute__((format(printf, 2, 3)))
rk_mesh_note_add(rk_error *note, const char *format, ...)
{
    char text[sizeof note->text];
    if (!note)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const rk_error before = *note;
    rk_fail(note, "%s%s%s", before.text, *before.text ? "; " : "", text);
}

#endif
