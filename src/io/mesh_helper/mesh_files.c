/* Each part of a path is looked for as it is written, then in its folder regardless of case. */
#include "io/mesh_helper/mesh_files.h"

#include "io/stand_in.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* Replaces the part of `path` from `part` to its end by the entry of the folder before it that
 * differs in case only, which is as long. */
static bool mend_case(char *path, char *part)
{
    char kept = *part;
    *part = '\0';
    DIR *folder = opendir(part == path ? "." : path);
    *part = kept;
    bool found = false;
    for (struct dirent *entry; folder && !found && (entry = readdir(folder));)
        if (strcasecmp(entry->d_name, part) == 0) {
            memcpy(part, entry->d_name, strlen(part));
            found = true;
        }
    if (folder)
        closedir(folder);
    return found;
}

static bool is_file(char *path)
{
    struct stat status;
    for (char *part = path, *slash; *part; part = slash + 1) {
        slash = strchr(part, '/');
        if (slash)
            *slash = '\0';
        bool there = *part == '\0' || stat(path, &status) == 0 || mend_case(path, part);
        if (slash)
            *slash = '/';
        if (!there || !slash)
            break;
    }
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) && access(path, R_OK) == 0;
}

static void clean(char *to, const char *name, size_t length)
{
    while (length > 0 && strchr(" \t\r", name[length - 1]))
        length--;
    if (length > 1 && (name[0] == '"' || name[0] == '\'') && name[length - 1] == name[0])
        name++, length -= 2;
    for (size_t i = 0; i < length; i++)
        to[i] = name[i] == '\\' ? '/' : name[i];
    to[length] = '\0';
}

bool rk_mesh_files_has_ending(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, ending) == 0;
}

bool rk_mesh_files_unescape(char *name)
{
    char *to = name;
    for (const char *from = name; *from; from++) {
        const bool is_escape =
            from[0] == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]);
        const char digits[3] = {from[is_escape], is_escape ? from[2] : '\0', '\0'};
        *to++ = is_escape ? (char)strtoul(digits, NULL, 16) : *from;
        from += is_escape ? 2 : 0;
    }
    const bool changed = *to != '\0';
    *to = '\0';
    return changed;
}

bool rk_mesh_files_find(char found[RK_MESH_FILES_NAME], const char *mesh_path, const char *folder,
                        const char *name, size_t length)
{
    char cleaned[RK_MESH_FILES_NAME], path[4096];
    if (length == 0 || length >= sizeof cleaned)
        return false;
    clean(cleaned, name, length);
    const char *slash = strrchr(mesh_path, '/');
    size_t before = slash && cleaned[0] != '/' ? (size_t)(slash - mesh_path) + 1 : 0;
    int size = snprintf(path, sizeof path, "%.*s%s%s", (int)before, mesh_path,
                        cleaned[0] == '/' ? "" : folder, cleaned);
    if (size < 0 || (size_t)size >= sizeof path || (size_t)size - before >= RK_MESH_FILES_NAME ||
        cleaned[0] == '\0' ||
        !(is_file(path) || (rk_mesh_files_unescape(path + before) && is_file(path))))
        return false;
    strcpy(found, path + before);
    return true;
}

bool rk_mesh_files_is_stand_in(const char *mesh_path, const char *found, rk_error *what)
{
    char path[4096], first[RK_STAND_IN_MARK];
    const char *slash = strrchr(mesh_path, '/');
    const int before = slash && found[0] != '/' ? (int)(slash - mesh_path) + 1 : 0;
    const int size = snprintf(path, sizeof path, "%.*s%s", before, mesh_path, found);
    FILE *file = size > 0 && (size_t)size < sizeof path ? fopen(path, "rb") : NULL;
    if (!file)
        return false;
    const size_t count = fread(first, 1, sizeof first, file);
    fclose(file);
    rk_error error;
    if (rk_stand_in_check("", first, count, &error))
        return false;
    snprintf(what->text, sizeof what->text, "%s", error.text + 2);
    return true;
}
