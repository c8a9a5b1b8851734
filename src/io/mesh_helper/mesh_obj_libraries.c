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
    rk_error what;
    const char *slash = strrchr(found, '/');
    if (!s->rewrite) {
        if (!s->stand_in[0] && rk_mesh_files_is_stand_in(s->path, found, &what))
            snprintf(s->stand_in, sizeof s->stand_in, "%.400s %.100s", found, what.text);
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

static void lose(rk_mesh_obj_libraries *s, const char *name, size_t length, size_t line)
{
    const size_t before = strlen(s->lost);
    if (before > 0 && s->lost_line != line)
        return;
    s->lost_line = line;
    snprintf(s->lost + before, sizeof s->lost - before, "%s%.*s", before ? ", " : "", (int)length,
             name);
}

/* If none is there, the line may be one name. */
static void use_each_library(rk_mesh_obj_libraries *s, const char *name, size_t length, size_t line)
{
    char word[RK_MESH_FILES_NAME];
    int used = 0;
    s->renames = true;
    for (text_cursor c = {name, name + length, line}; text_read_word(&c, word, sizeof word);)
        used += use_library(s, word, strlen(word));
    if (used == 0 && !use_own_library(s))
        lose(s, name, length, line);
    for (text_cursor c = {name, name + length, line};
         used > 0 && text_read_word(&c, word, sizeof word);) {
        char found[RK_MESH_FILES_NAME];
        if (!rk_mesh_files_find(found, s->path, "", word, strlen(word)))
            lose(s, word, strlen(word), line);
    }
}

void rk_mesh_obj_libraries_read(rk_mesh_obj_libraries *s, text_cursor *c, mesh_rewrite *rewrite)
{
    s->rewrite = rewrite;
    s->any = true;
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

void rk_mesh_obj_libraries_use(rk_mesh_obj_libraries *s, const text_cursor *c, bool has_faces)
{
    text_cursor at = *c;
    if (!s->material[0] && text_read_word(&at, s->material, sizeof s->material))
        s->begins_without |= has_faces;
}

void rk_mesh_obj_libraries_before_face(rk_mesh_obj_libraries *s, const char *line,
                                       mesh_rewrite *rewrite)
{
    if (!s->begins_without)
        return;
    while (line > rewrite->copied && (line[-1] == ' ' || line[-1] == '\t'))
        line--;
    rewrite_skip(rewrite, line, line);
    fputs("usemtl " RK_MESH_OBJ_NO_MATERIAL "\n", rewrite->out);
    s->begins_without = false;
    snprintf(s->material, sizeof s->material, RK_MESH_OBJ_NO_MATERIAL);
}

bool rk_mesh_obj_libraries_means_none(const char *material)
{
    return strcmp(material, RK_MESH_OBJ_NO_MATERIAL) == 0 || strcmp(material, "None") == 0 ||
           strcmp(material, "(null)") == 0;
}

void rk_mesh_obj_libraries_note(const rk_mesh_obj_libraries *s, bool coloured)
{
    const bool plain = s->hints->plain;
    if (s->stand_in[0])
        rk_mesh_hints_note(s->hints, s->path, "the material file %s", s->stand_in);
    if (s->lost[0])
        rk_fail(&s->hints->note, "%s:%zu: the material file %.500s is missing: %s", s->path,
                s->lost_line, s->lost,
                !plain     ? "surfaces of its materials are grey"
                : coloured ? "surfaces have only the colours of their vertices"
                           : "all surfaces are grey");
    else if (plain && !coloured && !s->any && s->material[0] &&
             !rk_mesh_obj_libraries_means_none(s->material))
        rk_mesh_hints_note(s->hints, s->path,
                           "uses materials (usemtl %s), but names no material file (mtllib): all "
                           "surfaces are grey",
                           s->material);
}
