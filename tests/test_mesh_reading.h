/* What suites on mesh files have in common: a folder of small files, each read as a whole or
 * refused in one line. */
#ifndef RK_TESTS_TEST_MESH_READING_H
#define RK_TESTS_TEST_MESH_READING_H

#include "test.h"

#include "remedy.h"
#include "test_folder.h"

#include "io/mesh_file.h"

#include <stdio.h>
#include <string.h>

static test_folder folder;

static inline test_path write_text(const char *name, const char *text)
{
    return test_folder_write(&folder, name, text, strlen(text), 0600);
}

static inline rk_mesh load(test_path path)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check(error.text[0] == '\0', "an unexpected note: %s", error.text);
    return mesh;
}

static inline rk_mesh load_with_note(test_path path, const char *note)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check_error_names(error, path.text);
    rk_check_error_names(error, note);
    return mesh;
}

static inline void check_refused_path(const char *path, const char *place, const char *what)
{
    rk_mesh mesh;
    rk_error error;
    rk_check(!rk_mesh_file_read(&mesh, path, &error), "%s was accepted", path);
    rk_check(mesh.triangle_count == 0 && !mesh.positions, "a failed read left a mesh behind");
    char begin[1000];
    snprintf(begin, sizeof begin, "%s%s", path, place);
    rk_check(strncmp(error.text, begin, strlen(begin)) == 0,
             "the error should begin with \"%s\", but says: %s", begin, error.text);
    rk_check_error_names(error, what);
    rk_check_remedy(error.text);
}

/* The file is refused with "PATHPLACE ...": `place` follows the file's name. */
static inline void check_refused(const char *name, const char *text, const char *place,
                                 const char *what)
{
    check_refused_path(write_text(name, text).text, place, what);
}

static inline rk_vec3 corner(const rk_mesh *mesh, uint32_t triangle, int k)
{
    return mesh->positions[mesh->triangles[triangle][k]];
}

static inline rk_vec3 vector_area(const rk_mesh *mesh, uint32_t triangle)
{
    rk_vec3 a = corner(mesh, triangle, 0);
    return rk_scale(
        rk_cross(rk_sub(corner(mesh, triangle, 1), a), rk_sub(corner(mesh, triangle, 2), a)), 0.5f);
}

static inline void check_point(rk_vec3 got, float x, float y, float z)
{
    rk_check(got.x == x && got.y == y && got.z == z, "got (%g, %g, %g), want (%g, %g, %g)",
             (double)got.x, (double)got.y, (double)got.z, (double)x, (double)y, (double)z);
}

/* By hand in both ends: each character is below 128. */
static inline test_path write_utf16(const char *name, const char *text, bool big, bool has_mark)
{
    char bytes[4000];
    size_t size = 0;
    if (has_mark) {
        memcpy(bytes, big ? "\xfe\xff" : "\xff\xfe", 2);
        size = 2;
    }
    for (; *text; text++) {
        bytes[size++] = big ? '\0' : *text;
        bytes[size++] = big ? *text : '\0';
    }
    return test_folder_write(&folder, name, bytes, size, 0600);
}

static inline int make_folder(void **state)
{
    (void)state;
    return !test_folder_make(&folder);
}

static inline int remove_folder(void **state)
{
    (void)state;
    test_folder_remove(&folder);
    return 0;
}

#endif
