/* io/mesh_helper/text_encoding.h by the C library's iconv. */
#include "io/mesh_helper/text_encoding.h"

#include <iconv.h>
#include <stdlib.h>
#include <string.h>

static bool has_mark(const char *text, size_t size)
{
    return size >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
}

bool rk_text_encoding_is_utf16(const char *text, size_t size)
{
    if (size < 4 || has_mark(text, size))
        return has_mark(text, size);
    return (text[0] == '\0') != (text[1] == '\0') && (text[0] == '\0') == (text[2] == '\0') &&
           (text[1] == '\0') == (text[3] == '\0');
}

char *rk_text_encoding_to_utf8(const char *path, const char *text, size_t size, size_t *utf8_size,
                               rk_error *error)
{
    const bool is_big = text[0] == '\0' || text[0] == '\xfe';
    const size_t mark = has_mark(text, size) ? 2 : 0;
    size_t left = size - mark, room = left / 2 * 3 + 1; /* three bytes of UTF-8 for two */
    char *from = (char *)text + mark, *utf8 = rk_allocate_unset(room, 1, path, error), *to = utf8;
    if (!utf8)
        return NULL;
    iconv_t converter = iconv_open("UTF-8", is_big ? "UTF-16BE" : "UTF-16LE");
    const bool ok = converter != (iconv_t)-1 &&
                    iconv(converter, &from, &left, &to, &room) != (size_t)-1 && to > utf8;
    if (converter != (iconv_t)-1)
        iconv_close(converter);
    *utf8_size = (size_t)(to - utf8);
    if (ok)
        return utf8;
    free(utf8);
    rk_fail(error, "%s: its text is in UTF-16, but damaged: save it as UTF-8", path);
    return NULL;
}

static char *read_whole(FILE *file, size_t *size)
{
    char *text = NULL;
    FILE *all = open_memstream(&text, size);
    char block[4096];
    for (size_t n; all && (n = fread(block, 1, sizeof block, file)) > 0;)
        fwrite(block, 1, n, all);
    return all && fclose(all) == 0 ? text : NULL;
}

FILE *rk_text_encoding_open(FILE *file)
{
    char first[4];
    const long start = ftell(file);
    const bool is_utf16 = rk_text_encoding_is_utf16(first, fread(first, 1, sizeof first, file));
    fseek(file, start, SEEK_SET);
    if (!is_utf16)
        return file;
    size_t size = 0, utf8_size = 0;
    char *text = read_whole(file, &size);
    char *utf8 = text ? rk_text_encoding_to_utf8("", text, size, &utf8_size, NULL) : NULL;
    FILE *stream = fmemopen(NULL, utf8_size + 1, "w+b"); /* frees its bytes when it is closed */
    if (stream && utf8)
        fwrite(utf8, 1, utf8_size, stream);
    if (stream)
        rewind(stream);
    free(text);
    free(utf8);
    fclose(file);
    return stream;
}
