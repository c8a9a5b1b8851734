/* Words of a line are separated by blanks; options of a map precede its file's name. Format:
 * Wavefront's Advanced Visualizer manual, appendix on MTL, 1995. */
#include "io/mesh_helper/mesh_mtl.h"

#include "io/mesh_helper/mesh_io.h"
#include "io/mesh_helper/text_encoding.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *const blanks = " \t\r\n";

static rk_mesh_mtl_material *add_material(rk_mesh_mtl *mtl, const char *path, rk_error *error)
{
    if (mtl->count == mtl->room) {
        mtl->room = mtl->room ? 2 * mtl->room : 64;
        void *larger = realloc(mtl->materials, mtl->room * sizeof *mtl->materials);
        if (!larger) {
            rk_fail(error, "%s: no memory for its %u materials: merge some", path, mtl->count);
            return NULL;
        }
        mtl->materials = larger;
    }
    rk_mesh_mtl_material *added = &mtl->materials[mtl->count++];
    *added = (rk_mesh_mtl_material){.scale = {1, 1}};
    return added;
}

/* Without blanks at both ends. */
static void set_name(rk_mesh_mtl_material *material, const char *rest)
{
    rest += strspn(rest, blanks);
    snprintf(material->name, sizeof material->name, "%s", rest);
    size_t length = strlen(material->name);
    while (length > 0 && strchr(blanks, material->name[length - 1]))
        material->name[--length] = '\0';
}

/* Reads one to three numbers; only u and v are kept. */
static const char *read_numbers(const char *at, float numbers[2])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        const float value = strtof(at, &end);
        if (end == at || !strchr(blanks, *end))
            break;
        if (i < 2)
            numbers[i] = value;
        at = end + strspn(end, blanks);
    }
    return at;
}

static const char *skip_word(const char *at)
{
    at += strcspn(at, blanks);
    return at + strspn(at, blanks);
}

static void read_map(rk_mesh_mtl_material *material, const char *at)
{
    float unused[2];
    at += strspn(at, blanks);
    while (*at == '-') {
        const char *option = at;
        const size_t length = strcspn(at, blanks);
        at = skip_word(at);
        if (length == 2 && option[1] == 's')
            at = read_numbers(at, material->scale);
        else if (length == 2 && option[1] == 'o')
            at = read_numbers(at, material->offset);
        else if (length == 2 && option[1] == 't')
            at = read_numbers(at, unused);
        else
            at = skip_word(length == 3 && memcmp(option, "-mm", 3) == 0 ? skip_word(at) : at);
    }
}

static bool is_word(const char *line, size_t length, const char *word)
{
    return length == strlen(word) && strncasecmp(line, word, length) == 0;
}

/* A later d takes the opacity back from Tr. */
static void read_line(rk_mesh_mtl_material *material, const char *line, bool *has_d)
{
    const size_t length = strcspn(line, blanks);
    if (is_word(line, length, "map_Kd"))
        read_map(material, line + length);
    *has_d |= is_word(line, length, "d");
    if (is_word(line, length, "Tr"))
        material->is_tr_one = strtof(line + length, NULL) == 1;
    material->is_tr_one &= !*has_d;
}

static bool read_file(rk_mesh_mtl *mtl, const char *file_path, rk_error *error)
{
    FILE *file = fopen(file_path, "rb");
    rk_mesh_mtl_material *material = NULL;
    char line[4096];
    bool has_d = false, ok = true;
    file = file ? rk_text_encoding_open(file) : NULL;
    while (file && ok && fgets(line, sizeof line, file)) {
        const char *start = line + (strncmp(line, "\xef\xbb\xbf", 3) == 0 ? 3 : 0);
        start += strspn(start, blanks);
        if (is_word(start, strcspn(start, blanks), "newmtl")) {
            material = add_material(mtl, file_path, error);
            ok = material != NULL;
            has_d = false;
            if (ok)
                set_name(material, start + strlen("newmtl"));
        } else if (material) {
            read_line(material, start, &has_d);
        }
    }
    if (file)
        fclose(file);
    return ok;
}

/* The word as Assimp knows it, if a name follows, or at least one number; of a map as it is; or
 * NULL. */
static const char *known_word(const char *line)
{
    static const char *const with_name[] = {"newmtl", "bump", "disp", "refl", "norm"};
    static const char *const with_number[] = {"Ka", "Kd", "Ks", "Ke", "Ns",
                                              "Ni", "d",  "Tr", "Tf", "illum"};
    const size_t length = strcspn(line, blanks);
    char *end;
    if (length > 4 && strncasecmp(line, "map_", 4) == 0)
        return "";
    for (size_t i = 0; i < sizeof with_name / sizeof *with_name; i++)
        if (is_word(line, length, with_name[i]))
            return with_name[i];
    for (size_t i = 0; i < sizeof with_number / sizeof *with_number; i++)
        if (is_word(line, length, with_number[i]))
            return strtof(line + length, &end), end != line + length ? with_number[i] : NULL;
    return NULL;
}

bool rk_mesh_mtl_copy_known(FILE *file, char **text, size_t *size)
{
    FILE *out = open_memstream(text, size);
    char *line = NULL;
    size_t room = 0;
    if (!out)
        return false;
    fputs("# lines that Assimp knows\n", out); /* it refuses files of a few bytes */
    while (getline(&line, &room, file) >= 0) {
        const char *start = line + strspn(line, blanks);
        const char *word = known_word(start);
        if (word)
            fprintf(out, "%s%s", word, start + strlen(word));
    }
    free(line);
    return fclose(out) == 0;
}

bool rk_mesh_mtl_read(rk_mesh_mtl *mtl, rk_error *error)
{
    bool ok = true;
    for (int i = 0; ok && rk_mesh_io_mtl(i); i++)
        ok = read_file(mtl, rk_mesh_io_mtl(i), error);
    return ok;
}

void rk_mesh_mtl_free(rk_mesh_mtl *mtl)
{
    free(mtl->materials);
    *mtl = (rk_mesh_mtl){0};
}

const rk_mesh_mtl_material *rk_mesh_mtl_find(const rk_mesh_mtl *mtl, const char *name)
{
    for (uint32_t i = 0; i < mtl->count; i++)
        if (strcmp(mtl->materials[i].name, name) == 0)
            return &mtl->materials[i];
    return NULL;
}

const rk_mesh_mtl_material *rk_mesh_mtl_find_commented(const rk_mesh_mtl *mtl, const char *name)
{
    const size_t length = strlen(name);
    const bool is_there = rk_mesh_mtl_find(mtl, name) != NULL;
    for (uint32_t i = 0; i < mtl->count && !is_there; i++) {
        const char *other = mtl->materials[i].name;
        if (strncmp(other, name, length) != 0 || !strchr(" \t", other[length]))
            continue;
        if (other[length + strspn(other + length, " \t")] == '#')
            return &mtl->materials[i];
    }
    return NULL;
}
