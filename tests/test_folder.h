/* A folder for a suite that needs files: made under TMPDIR, removed with its contents. */
#ifndef RK_TESTS_TEST_FOLDER_H
#define RK_TESTS_TEST_FOLDER_H

#include "test.h"

#include <dirent.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct test_folder {
    char path[512];
} test_folder;

typedef struct test_path {
    char text[800];
} test_path;

static inline bool test_folder_make(test_folder *folder)
{
    const char *parent = getenv("TMPDIR");
    snprintf(folder->path, sizeof folder->path, "%s/raykit-test-XXXXXX", parent ? parent : "/tmp");
    return mkdtemp(folder->path) != NULL;
}

/* The path of `name` in the folder. */
static inline test_path test_folder_path(const test_folder *folder, const char *name)
{
    test_path path;
    snprintf(path.text, sizeof path.text, "%s/%s", folder->path, name);
    return path;
}

/* Writes `size` bytes to a new file with the given permissions and returns its path. */
static inline test_path test_folder_write(const test_folder *folder, const char *name,
                                          const void *bytes, size_t size, mode_t mode)
{
    test_path path = test_folder_path(folder, name);
    FILE *file = fopen(path.text, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0 ||
        chmod(path.text, mode) != 0) {
        perror(path.text);
        abort();
    }
    return path;
}

/* Removes the folder with its contents. */
static inline void test_folder_remove(const test_folder *folder)
{
    DIR *directory = opendir(folder->path);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        test_folder below;
        snprintf(below.path, sizeof below.path, "%.250s/%.250s", folder->path, entry->d_name);
        if (unlink(below.path) != 0)
            test_folder_remove(&below);
    }
    if (directory)
        closedir(directory);
    rmdir(folder->path);
}

/* The number of files and folders directly in it. */
static inline int test_folder_count(const test_folder *folder)
{
    DIR *directory = opendir(folder->path);
    int count = 0;
    for (struct dirent *entry; directory && (entry = readdir(directory));)
        count += entry->d_name[0] != '.';
    if (directory)
        closedir(directory);
    return count;
}

/* Returns a whole file in a new block to free(). */
static inline unsigned char *test_folder_read(test_path path, size_t *size)
{
    FILE *file = fopen(path.text, "rb");
    struct stat status = {0};
    if (file)
        fstat(fileno(file), &status);
    *size = (size_t)status.st_size;
    unsigned char *bytes = malloc(*size + 1);
    if (!file || !bytes || fread(bytes, 1, *size, file) != *size) {
        perror(path.text);
        abort();
    }
    fclose(file);
    return bytes;
}

/* Makes a file with this text. */
static inline void test_file_put(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    rk_check(file && fputs(text, file) >= 0 && fclose(file) == 0, "%s cannot be made", path);
}

/* The file contains exactly this text. */
static inline void test_file_check(const char *path, const char *want)
{
    char got[4096] = "";
    FILE *file = fopen(path, "rb");
    rk_check(file, "%s should exist", path);
    size_t size = fread(got, 1, sizeof got - 1, file);
    fclose(file);
    rk_check(size == strlen(want) && memcmp(got, want, size) == 0,
             "%s holds\n%s\nbut should hold\n%s", path, got, want);
}

/* A folder for one test, passed as a test_folder * in its state; removed even if the test fails. */
static inline int test_folder_setup(void **state)
{
    test_folder *folder = malloc(sizeof *folder);
    *state = folder;
    return folder && test_folder_make(folder) ? 0 : -1;
}

static inline int test_folder_teardown(void **state)
{
    test_folder_remove(*state);
    free(*state);
    return 0;
}

#define test_in_folder(name)                                                                       \
    cmocka_unit_test_setup_teardown(name, test_folder_setup, test_folder_teardown)

#endif
