/* io/mesh_helper/mesh_syntax.h for STL. Text that is in capitals is given to Assimp in small
 * letters, which alone it knows. Binary: 80 bytes, a count of triangles, and 50 bytes for
 * each, of which the last two are its colour. VisCAM's way, which Assimp reads, has bit 15 set, and
 * blue in the lowest bits. In Magics's way the 80 bytes hold COLOR= and four bytes, the whole
 * part's colour; red is in the lowest bits, and bit 15 is clear where a triangle has a colour of
 * its own. MeshLab writes the same with bit 15 set. Sources: Wikipedia, "STL (file format)";
 * VCGlib, wrap/io_trimesh/export_stl.h. */
#include "io/little_endian.h"
#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { head_size = 80, rows_begin = 84, row_size = 50 };

typedef struct stl_colour {
    rk_vec3 whole; /* as sRGB from 0 to 1 */
    unsigned char alpha;
    unsigned own_bit; /* bit 15 of a triangle with a colour of its own */
} stl_colour;

static bool is_binary(const char *text, size_t size, uint32_t *count)
{
    *count = size >= rows_begin ? rk_little_endian_32(text + head_size) : 0;
    return size >= rows_begin && size - rows_begin == (size_t)*count * row_size;
}

/* Without a terminating NUL. */
static const char *find_word(const char *text, size_t size, const char *word)
{
    const size_t length = strlen(word);
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(text + i, word, length) == 0)
            return text + i;
    return NULL;
}

static bool find_colour(const char *text, stl_colour *colour)
{
    const char *word = find_word(text, head_size, "COLOR=");
    if (!word || text + head_size - word < 10)
        return false;
    const unsigned char *bytes = (const unsigned char *)word + 6;
    const bool is_meshlab = find_word((const char *)bytes + 3, 10, " MATERIAL=") != NULL;
    *colour =
        (stl_colour){rk_vec((float)bytes[0] / 255, (float)bytes[1] / 255, (float)bytes[2] / 255),
                     is_meshlab ? 255 : bytes[3], is_meshlab};
    return true;
}

static rk_vec3 colour_of_triangle(const stl_colour *colour, uint32_t bits)
{
    if (bits >> 15 != colour->own_bit)
        return colour->whole;
    return rk_vec((float)(bits & 31) / 31, (float)(bits >> 5 & 31) / 31,
                  (float)(bits >> 10 & 31) / 31);
}

static bool is_text_in_capitals(const char *text, size_t size)
{
    size_t begin = 0;
    while (begin < size && strchr(" \t\r\n", text[begin]) && text[begin])
        begin++;
    const char *word = text + begin;
    return size - begin >= 5 && strncasecmp(word, "solid", 5) == 0 && !memchr(text, 0, size) &&
           (memcmp(word, "solid", 5) != 0 || find_word(text, size, "FACET"));
}

static bool write_small_letters(const char *path, const char *text, size_t size,
                                rk_mesh_hints *hints, rk_error *error)
{
    hints->text = rk_allocate_unset(size, 1, path, error);
    hints->size = size;
    for (size_t i = 0; hints->text && i < size; i++)
        hints->text[i] = text[i] >= 'A' && text[i] <= 'Z' ? (char)(text[i] - 'A' + 'a') : text[i];
    return hints->text != NULL;
}

/* Bytes of triangles. Programs that write them as they come leave the count at 0 or at its largest,
 * and some write more behind them, while Assimp wants the file's size to be that of its count. */
static bool mend_count(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                       rk_error *error)
{
    const uint32_t count = rk_little_endian_32(text + head_size);
    const size_t left = size - rows_begin;
    const bool is_unset = count == 0 || count == UINT32_MAX;
    if (left < row_size || (is_unset && left % row_size != 0))
        return true;
    if (!is_unset && left / row_size < count)
        return rk_fail(error, "%s: claims %u triangles, but has %zu: download or export it again",
                       path, count, left / row_size);
    const uint32_t kept = is_unset ? (uint32_t)(left / row_size) : count;
    hints->size = rows_begin + (size_t)kept * row_size;
    hints->text = rk_allocate_unset(hints->size, 1, path, error);
    if (!hints->text)
        return false;
    memcpy(hints->text, text, hints->size);
    for (int i = 0; i < 4; i++)
        hints->text[head_size + i] = (char)(kept >> 8 * i);
    rk_mesh_hints_note(hints, path, "claims %u triangles, but has bytes of %zu: %u are drawn",
                       count, left / row_size, kept);
    return true;
}

/* Assimp, too, takes a file for text that begins with solid, unless its size tells otherwise. */
static bool may_be_text(const char *text, size_t size)
{
    size_t begin = 0;
    while (begin < size && strchr(" \t\r\n", text[begin]) && text[begin])
        begin++;
    return size - begin >= 5 && strncasecmp(text + begin, "solid", 5) == 0 &&
           find_word(text, size < 1000 ? size : 1000, "facet");
}

/* Assimp reads three corners of each face. */
static void count_text(const char *text, size_t size, rk_mesh_hints *hints)
{
    for (text_cursor c = text_begin(text, size); text_next_content(&c); text_next_line(&c)) {
        const size_t left = (size_t)(c.end - c.at);
        hints->faces += left > 5 && memcmp(c.at, "outer", 5) == 0;
        hints->corners += left > 6 && memcmp(c.at, "vertex", 6) == 0;
    }
}

bool rk_mesh_syntax_stl(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    uint32_t count;
    stl_colour colour;
    if (is_text_in_capitals(text, size)) {
        if (!write_small_letters(path, text, size, hints, error))
            return false;
        count_text(hints->text, size, hints);
        return true;
    }
    if (size >= rows_begin && !is_binary(text, size, &count) && memchr(text, 0, size) &&
        !may_be_text(text, size))
        return mend_count(path, text, size, hints, error);
    if (!is_binary(text, size, &count) && may_be_text(text, size))
        count_text(text, size, hints);
    if (!is_binary(text, size, &count) || count == 0 || !find_colour(text, &colour))
        return true;
    hints->face_colours = rk_allocate(count, sizeof *hints->face_colours, path, error);
    if (!hints->face_colours)
        return false;
    hints->face_colour_count = hints->faces = count;
    hints->corners = 3 * (size_t)count;
    for (uint32_t i = 0; i < count; i++) {
        const size_t row = rows_begin + (size_t)i * row_size;
        hints->face_colours[i] = (rk_mesh_colours_face){
            3, colour_of_triangle(&colour, rk_little_endian_16(text + row + row_size - 2))};
    }
    if (colour.alpha < 255)
        rk_mesh_hints_note(hints, path, "has a transparent colour, which is drawn as opaque");
    return true;
}
