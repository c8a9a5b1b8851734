/* rk_mesh_colours_read_off of io/mesh_helper/mesh_colours.h. Assimp skips what follows a face's
 * corners in OFF: three or four numbers are its colour, and its opacity (Geomview manual, "OFF
 * files"). A single number, of a colour map, is left out. */
#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/text_cursor.h"

#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>

typedef struct whole_file {
    char *text;
    size_t size;
} whole_file;

static bool read_whole(whole_file *whole, const char *path, rk_error *error)
{
    struct stat status;
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), &status) != 0) {
        if (file)
            fclose(file);
        return rk_fail(error, "%s: cannot be read: %s", path, strerror(errno));
    }
    whole->text = rk_allocate_unset((size_t)status.st_size, 1, path, error);
    whole->size = whole->text ? fread(whole->text, 1, (size_t)status.st_size, file) : 0;
    fclose(file);
    return whole->text != NULL;
}

static float next_number(text_cursor *c)
{
    char word[64];
    return text_read_word(c, word, sizeof word) ? strtof(word, NULL) : NAN;
}

static bool read_face(text_cursor *c, rk_mesh_colours_face *face)
{
    float numbers[5] = {NAN, NAN, NAN, NAN, NAN};
    const float corners = next_number(c);
    face->corners = corners >= 0 && corners < 0x1p31f ? (uint32_t)corners : 0;
    for (uint32_t i = 0; i < face->corners && !text_line_ended(c); i++)
        next_number(c);
    for (int i = 0; i < 5; i++)
        numbers[i] = next_number(c);
    const bool has_colour = numbers[2] >= 0 && isnan(numbers[4]);
    face->rgb = has_colour ? rk_vec(numbers[0], numbers[1], numbers[2]) : rk_vec(-1, -1, -1);
    return has_colour;
}

static bool read_faces(rk_mesh_colours *colours, text_cursor *c, const char *path, rk_error *error)
{
    char word[16];
    bool any = false;
    if (!text_next_content(c) || !text_read_word(c, word, sizeof word) || !text_next_content(c))
        return true;
    const float vertices = next_number(c), faces = next_number(c);
    const size_t size = (size_t)(c->end - c->at); /* a row takes at least two bytes */
    text_next_line(c);
    if (!(vertices >= 0 && faces >= 0 && vertices + faces <= (float)size))
        return true;
    for (uint32_t i = 0; i < (uint32_t)vertices && text_next_content(c); i++)
        text_next_line(c);
    colours->faces = rk_allocate((size_t)faces, sizeof *colours->faces, path, error);
    if (!colours->faces)
        return false;
    for (; colours->face_count < (uint32_t)faces && text_next_content(c); text_next_line(c))
        any |= read_face(c, &colours->faces[colours->face_count++]);
    if (!any)
        colours->face_count = 0;
    return true;
}

bool rk_mesh_colours_read_off(rk_mesh_colours *colours, const char *path, rk_error *error)
{
    whole_file whole = {0};
    bool ok = read_whole(&whole, path, error);
    if (ok) {
        text_cursor c = text_begin(whole.text, whole.size);
        ok = read_faces(colours, &c, path, error);
    }
    free(whole.text);
    return ok;
}
