/* io/mesh_helper/mesh_syntax.h for 3MF, an archive of ZIP's format whose models are XML. Assimp
 * reads one model, and nothing of an archive whose sizes have 64 bits. The list of the archive's
 * files is at its end. Formats: PKWARE, APPNOTE.TXT, sections 4.3.12 to 4.3.16; 3MF Consortium,
 * "Core Specification" and "Production Extension". */
#include "io/little_endian.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <stdint.h>
#include <string.h>
#include <strings.h>

enum { end_size = 22, entry_size = 46, longest_comment = 65535 };

/* The record at the end of the archive, which a comment may follow; or NULL. */
static const char *find_end(const char *text, size_t size)
{
    for (size_t back = end_size; back <= size && back <= end_size + longest_comment; back++)
        if (memcmp(text + size - back, "PK\5\6", 4) == 0)
            return text + size - back;
    return NULL;
}

static bool has_wide_sizes(const char *text, const char *end)
{
    return rk_little_endian_16(end + 10) == 0xffff || rk_little_endian_32(end + 12) == 0xffffffff ||
           rk_little_endian_32(end + 16) == 0xffffffff ||
           (end - text >= 20 && memcmp(end - 20, "PK\6\7", 4) == 0);
}

static bool is_model(const char *name, size_t length)
{
    static const char ending[] = ".model";
    return length >= sizeof ending &&
           strncasecmp(name + length - (sizeof ending - 1), ending, sizeof ending - 1) == 0;
}

static size_t count_models(const char *text, size_t size, const char *end)
{
    size_t models = 0, at = rk_little_endian_32(end + 16);
    for (uint32_t i = rk_little_endian_16(end + 10); i > 0; i--) {
        if (at > size || size - at < entry_size || memcmp(text + at, "PK\1\2", 4) != 0)
            return models;
        const size_t name = rk_little_endian_16(text + at + 28);
        if (size - at - entry_size < name)
            return models;
        models += is_model(text + at + entry_size, name);
        at += entry_size + name + rk_little_endian_16(text + at + 30) +
              rk_little_endian_16(text + at + 32);
    }
    return models;
}

bool rk_mesh_syntax_3mf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    const char *end = find_end(text, size);
    if (size < 4 || memcmp(text, "PK", 2) != 0)
        return rk_fail(error,
                       "%s: is not an archive, as a 3MF file is: rename it with the ending of its "
                       "format, or export it again",
                       path);
    if (!end)
        return rk_fail(error, "%s: its archive has no end: download or export it again", path);
    if (has_wide_sizes(text, end))
        return rk_fail(error,
                       "%s: its archive has sizes of 64 bits (ZIP64), which Assimp does not read: "
                       "unzip it, and zip it again with Info-ZIP's zip",
                       path);
    hints->models = count_models(text, size, end);
    return true;
}
