/* io/mesh_helper/mesh_ply_header.h: lines change their places; none is lost but those of elements
 * that are dropped. */
#include "io/mesh_helper/mesh_ply_header.h"

#include "io/mesh_helper/text_cursor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BEGINNING, REMARK, DECLARATION, line_kinds };

static int kind_of_line(const char *line)
{
    if (strncmp(line, "comment", 7) == 0 || strncmp(line, "obj_info", 8) == 0)
        return REMARK;
    return strncmp(line, "format", 6) == 0 ? BEGINNING : DECLARATION;
}

/* Is this line of an element that is neither vertices nor faces? `was`: that before it. */
static bool is_of_foreign(const char *line, const char *next, bool was)
{
    char word[32] = "";
    text_cursor c = text_begin(line, (size_t)(next - line));
    text_read_word(&c, word, sizeof word);
    if (strcmp(word, "element") != 0)
        return was && strcmp(word, "end_header") != 0;
    text_read_word(&c, word, sizeof word);
    return strcmp(word, "vertex") != 0 && strcmp(word, "face") != 0;
}

static void write_lines(FILE *out, const char *from, const char *to, int kind, bool drops_foreign)
{
    bool is_foreign = false;
    for (const char *line = from; line < to;) {
        const char *next = (const char *)memchr(line, '\n', (size_t)(to - line)) + 1;
        is_foreign = is_of_foreign(line, next, is_foreign);
        if (kind_of_line(line) == kind && !(kind == DECLARATION && is_foreign && drops_foreign))
            fwrite(line, 1, (size_t)(next - line), out);
        line = next;
    }
}

static void write_corrected(FILE *out, const char *text, size_t size, size_t rows,
                            bool begins_with_feed, bool drops_foreign)
{
    const char *second = (const char *)memchr(text, '\n', rows) + 1;
    fwrite(text, 1, (size_t)(second - text), out);
    for (int kind = BEGINNING; kind < line_kinds; kind++)
        write_lines(out, second, text + rows, kind, drops_foreign);
    fseek(out, -1, SEEK_CUR); /* the last line's end */
    fputs(begins_with_feed ? "\r\n" : "\n", out);
    fwrite(text + rows, 1, size - rows, out);
}

bool rk_mesh_ply_header_mend(rk_mesh_hints *hints, const char *text, size_t size, size_t rows,
                             bool has_misplaced_remark, bool begins_with_feed, bool drops_foreign)
{
    const bool is_taken_for_end = begins_with_feed && text[rows - 2] != '\r';
    if (!has_misplaced_remark && !is_taken_for_end && !drops_foreign)
        return true;
    char *corrected = NULL;
    size_t corrected_size = 0;
    FILE *out = open_memstream(&corrected, &corrected_size);
    if (!out)
        return false;
    write_corrected(out, hints->text ? hints->text : text, hints->text ? hints->size : size, rows,
                    begins_with_feed, drops_foreign);
    if (fclose(out) != 0) {
        free(corrected);
        return false;
    }
    free(hints->text);
    hints->text = corrected;
    hints->size = corrected_size;
    return true;
}
