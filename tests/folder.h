/* A temporary folder for each test that writes files: made before it, removed with all that is in
 * it afterwards, whether it passed or not. */
#ifndef RK_TESTS_FOLDER_H
#define RK_TESTS_FOLDER_H

#include "test.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct rk_folder {
    char path[512];
} rk_folder;

typedef struct rk_path {
    char text[1024];
} rk_path;

static inline rk_path rk_in_folder(const rk_folder *folder, const char *name)
{
    rk_path path;
    snprintf(path.text, sizeof path.text, "%s/%s", folder->path, name);
    return path;
}

/* Files in the folder, those included that begin with a dot. */
static inline int rk_count_files(const rk_folder *folder)
{
    DIR *listing = opendir(folder->path);
    int count = 0;
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    if (listing)
        closedir(listing);
    return count;
}

static inline void rk_put_file(const char *path, const void *bytes, size_t size)
{
    FILE *stream = fopen(path, "wb");
    rk_check(stream && fwrite(bytes, 1, size, stream) == size && fclose(stream) == 0,
             "%s: the test cannot write its file", path);
}

/* Returns the file's bytes in a new block to free(). */
static inline unsigned char *rk_get_file(const char *path, size_t *size)
{
    struct stat status = {0};
    FILE *stream = fopen(path, "rb");
    rk_check(stream && stat(path, &status) == 0, "%s: the test cannot read its file", path);
    *size = (size_t)status.st_size;
    unsigned char *bytes = malloc(*size + 1);
    rk_check(bytes && fread(bytes, 1, *size, stream) == *size, "%s: the test cannot read it", path);
    fclose(stream);
    return bytes;
}

/* cmocka's setup and teardown: the state is the rk_folder. */
static inline int rk_make_test_folder(void **state)
{
    const char *parent = getenv("TMPDIR");
    rk_folder *folder = calloc(1, sizeof *folder);
    if (!folder)
        return -1;
    snprintf(folder->path, sizeof folder->path, "%s/raykit-test-XXXXXX",
             parent && *parent ? parent : "/tmp");
    *state = folder;
    return mkdtemp(folder->path) ? 0 : -1;
}

static inline int rk_remove_test_folder(void **state)
{
    rk_folder *folder = *state;
    DIR *listing = opendir(folder->path);
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;)
        unlink(rk_in_folder(folder, entry->d_name).text);
    if (listing)
        closedir(listing);
    int result = rmdir(folder->path);
    free(folder);
    return result;
}

/* An entry of a suite's array, for a test that writes files. */
#define rk_folder_test(name)                                                                       \
    cmocka_unit_test_setup_teardown(name, rk_make_test_folder, rk_remove_test_folder)

#endif
