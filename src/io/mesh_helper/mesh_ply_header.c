/* io/mesh_helper/mesh_ply_header.h: lines change their places; none is lost. */
#include "io/mesh_helper/mesh_ply_header.h"

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

static void write_lines(FILE *out, const char *from, const char *to, int kind)
{
    for (const char *line = from; line < to;) {
        const char *next = (const char *)memchr(line, '\n', (size_t)(to - line)) + 1;
        if (kind_of_line(line) == kind)
            fwrite(line, 1, (size_t)(next - line), out);
        line = next;
    }
}

static void write_corrected(FILE *out, const char *text, size_t size, size_t rows,
                            bool begins_with_feed)
{
    const char *second = (const char *)memchr(text, '\n', rows) + 1;
    fwrite(text, 1, (size_t)(second - text), out);
    for (int kind = BEGINNING; kind < line_kinds; kind++)
        write_lines(out, second, text + rows, kind);
    fseek(out, -1, SEEK_CUR); /* the last line's end */
    fputs(begins_with_feed ? "\r\n" : "\n", out);
    fwrite(text + rows, 1, size - rows, out);
}

bool rk_mesh_ply_header_mend(rk_mesh_hints *hints, const char *text, size_t size, size_t rows,
                             bool has_misplaced_remark, bool begins_with_feed)
{
    const bool is_taken_for_end = begins_with_feed && text[rows - 2] != '\r';
    if (!has_misplaced_remark && !is_taken_for_end)
        return true;
    char *corrected = NULL;
    size_t corrected_size = 0;
    FILE *out = open_memstream(&corrected, &corrected_size);
    if (!out)
        return false;
    write_corrected(out, hints->text ? hints->text : text, hints->text ? hints->size : size, rows,
                    begins_with_feed);
    if (fclose(out) != 0) {
        free(corrected);
        return false;
    }
    free(hints->text);
    hints->text = corrected;
    hints->size = corrected_size;
    return true;
}
