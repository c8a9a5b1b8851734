/* Text in UTF-16, as programs of Windows save it, becomes UTF-8. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_TEXT_ENCODING_H
#define RK_IO_MESH_HELPER_TEXT_ENCODING_H

#include "base/error.h"

#include <stdio.h>

/* True for a text that begins with UTF-16's byte order mark, or in which every other of the first
 * four bytes is a NUL. */
bool rk_text_encoding_is_utf16(const char *text, size_t size);

/* Returns the text in UTF-8 without a mark, which the caller frees; NULL with an error that begins
 * with `path` if it is damaged or memory is short. */
char *rk_text_encoding_to_utf8(const char *path, const char *text, size_t size, size_t *utf8_size,
                               rk_error *error);

/* Returns the file as it is; if UTF-16 follows, closes it and returns the text in UTF-8 as a file.
 * NULL if memory is short. */
FILE *rk_text_encoding_open(FILE *file);

#endif
