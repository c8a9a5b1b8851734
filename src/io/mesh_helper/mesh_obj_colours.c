/* io/mesh_helper/mesh_obj_colours.h: the text is searched for the comment's first character. */
#include "io/mesh_helper/mesh_obj_colours.h"

#include <stdlib.h>
#include <string.h>

static bool add(rk_mesh_obj_colours *colours, uint32_t mrgb)
{
    if (colours->count == colours->room) {
        const size_t room = colours->room ? 2 * colours->room : 64;
        void *larger = realloc(colours->mrgb, room * sizeof *colours->mrgb);
        if (!larger)
            return false;
        colours->mrgb = larger;
        colours->room = room;
    }
    colours->mrgb[colours->count++] = mrgb;
    return true;
}

static int digit(char c)
{
    const char *const digits = "0123456789abcdefABCDEF", *at = c ? strchr(digits, c) : NULL;
    const int value = at ? (int)(at - digits) : -1;
    return value < 16 ? value : value - 6;
}

/* Ends at the first character that is no digit. */
static bool add_line(rk_mesh_obj_colours *colours, const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\t'))
        at++;
    for (; end - at >= 8; at += 8) {
        uint32_t mrgb = 0;
        for (int i = 0; i < 8; i++) {
            if (digit(at[i]) < 0)
                return true;
            mrgb = mrgb << 4 | (uint32_t)digit(at[i]);
        }
        if (!add(colours, mrgb))
            return false;
    }
    return true;
}

bool rk_mesh_obj_colours_find(rk_mesh_obj_colours *colours, const char *path, const char *text,
                              size_t size, rk_error *error)
{
    static const char word[] = "#MRGB ";
    const char *const end = text + size;
    for (const char *at = text; (at = memchr(at, '#', (size_t)(end - at))); at++) {
        if ((size_t)(end - at) < sizeof word || memcmp(at, word, sizeof word - 1) != 0)
            continue;
        if (!add_line(colours, at + sizeof word - 1, end))
            return rk_fail(error, "%s: no memory for its colours: simplify the mesh", path);
    }
    return true;
}
