/* io/mesh_helper/mesh_obj_libraries.h: names are looked for as they are written, regardless of
 * case, and word by word. */
#include "io/mesh_helper/mesh_obj_libraries.h"

#include "io/mesh_helper/mesh_files.h"

#include <string.h>

/* Keeps the folder, in which the pictures may be, and gives Assimp the name as it is. */
static bool use_library(rk_mesh_obj_libraries *s, const char *name, size_t length)
{
    char found[RK_MESH_FILES_NAME];
    if (!rk_mesh_files_find(found, s->path, "", name, length))
        return false;
    rk_mesh_hints *h = s->hints;
    const char *slash = strrchr(found, '/');
    if (!s->rewrite) {
        s->renames |= strlen(found) != length || memcmp(found, name, length) != 0;
        h->plain = false;
        if (slash && h->folder_count < RK_MESH_HINTS_FOLDERS)
            snprintf(h->folders[h->folder_count++], sizeof h->folders[0], "%.*s",
                     (int)(slash - found) + 1, found);
    } else {
        fprintf(s->rewrite->out, "mtllib %s\n", found);
    }
    return true;
}

/* Assimp, too, looks for a material file with the mesh's own name. */
static bool use_own_library(rk_mesh_obj_libraries *s)
{
    const char *slash = strrchr(s->path, '/'), *name = slash ? slash + 1 : s->path;
    char own[RK_MESH_FILES_NAME];
    int length = snprintf(own, sizeof own, "%.*s.mtl", (int)(strrchr(name, '.') - name), name);
    return length > 0 && (size_t)length < sizeof own && use_library(s, own, (size_t)length);
}

static void use_each_library(rk_mesh_obj_libraries *s, const char *name, size_t length, size_t line)
{
    text_cursor c = {name, name + length, line};
    char word[RK_MESH_FILES_NAME];
    int used = 0, lost = 0;
    while (text_read_word(&c, word, sizeof word)) {
        bool there = use_library(s, word, strlen(word));
        used += there, lost += !there;
    }
    s->renames = true;
    if (lost == 0 || (used == 0 && use_own_library(s)) || s->lost[0])
        return;
    s->lost_line = line;
    snprintf(s->lost, sizeof s->lost, "%.*s", (int)length, name);
}

void rk_mesh_obj_libraries_read(rk_mesh_obj_libraries *s, text_cursor *c, mesh_rewrite *rewrite)
{
    s->rewrite = rewrite;
    text_skip_blanks(c);
    size_t length = 0;
    while (c->at + length < c->end && c->at[length] != '\n')
        length++;
    const char *name = c->at;
    if (s->rewrite)
        rewrite_skip(s->rewrite, name - strlen("mtllib "), name + length);
    while (length > 0 && strchr(" \t\r", name[length - 1]))
        length--;
    if (!use_library(s, name, length))
        use_each_library(s, name, length, c->line);
}

void rk_mesh_obj_libraries_note(const rk_mesh_obj_libraries *s)
{
    if (s->lost[0])
        rk_fail(&s->hints->note,
                "%s:%zu: the material file %.500s is missing: %s surfaces are grey", s->path,
                s->lost_line, s->lost, s->hints->plain ? "all" : "its");
}
