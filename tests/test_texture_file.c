/* Pictures named by mesh files: where they are found, and which are refused. */
#include "test.h"

#include "quarters.h"

#include "io/texture_file.h"

static const size_t plenty = 1000;

/* Reads the picture by a mesh file's name for it. */
static bool read_named(rk_texture *texture, const test_folder *folder, const char *name,
                       rk_error *error)
{
    test_path mesh = test_folder_path(folder, "mesh.obj");
    rk_texture_file_source source = {.name = name};
    size_t texels_left = plenty;
    return rk_texture_file_read(texture, &source, mesh.text, &texels_left, error);
}

static void check_found(const test_folder *folder, const char *name)
{
    rk_texture texture;
    rk_error error;
    rk_check(read_named(&texture, folder, name, &error), "%s: %s", name, error.text);
    check_quarters(&texture);
    rk_texture_free(&texture);
}

static void check_refused(const test_folder *folder, const char *name, const char *part)
{
    rk_texture texture;
    rk_error error;
    rk_check(!read_named(&texture, folder, name, &error), "%s was accepted", name);
    rk_check(!texture.image.pixels, "%s: pixels were left behind", name);
    rk_check_error_names(error, name);
    rk_check_error_names(error, part);
}

static void a_name_is_relative_to_the_mesh_files_folder(void **state)
{
    write_quarters(*state, "quarters.png");
    check_found(*state, "quarters.png");
    check_found(*state, "./quarters.png");
}

static void a_name_that_begins_with_a_slash_is_taken_as_it_is(void **state)
{
    test_folder elsewhere;
    assert_true(test_folder_make(&elsewhere));
    test_path path = write_quarters(&elsewhere, "quarters.png");
    check_found(*state, path.text);
    test_folder_remove(&elsewhere);
}

static void backslashes_are_slashes(void **state)
{
    mkdir(test_folder_path(*state, "sub").text, 0700);
    write_quarters(*state, "sub/quarters.png");
    check_found(*state, "sub\\quarters.png");
}

static void percent_signs_may_stand_for_characters_or_for_themselves(void **state)
{
    write_quarters(*state, "two words.png");
    check_found(*state, "two words.png");
    check_found(*state, "two%20words.png");
    write_quarters(*state, "100%25.png");
    check_found(*state, "100%25.png");
    write_quarters(*state, "50%.png");
    check_found(*state, "50%.png");
}

static void without_the_folder_the_file_beside_the_mesh_is_read(void **state)
{
    write_quarters(*state, "quarters.png");
    check_found(*state, "C:\\Users\\artist\\quarters.png");
    check_found(*state, "/home/artist/quarters.png");
    check_found(*state, "gone/quarters.png");
}

static void files_that_are_not_pictures_are_refused(void **state)
{
    test_folder_write(*state, "text.png", "root:x:0:0", 10, 0600);
    mkdir(test_folder_path(*state, "folder.png").text, 0700);
    test_path pipe = test_folder_path(*state, "pipe.png");
    rk_check_equal(mkfifo(pipe.text, 0600), 0, "the test needs a pipe");
    check_refused(*state, "text.png", "PNG");
    check_refused(*state, "folder.png", "not a regular file");
    check_refused(*state, "pipe.png", "not a regular file");
    check_refused(*state, "gone.png", "No such file");
    check_refused(*state, "gone/", "No such file");
}

static void a_name_of_absurd_length_is_refused(void **state)
{
    char name[5001];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    rk_texture texture;
    rk_error error;
    rk_check(!read_named(&texture, *state, name, &error), "5000 characters were accepted");
    rk_check_error_names(error, "too long");
}

static void it_repeats_unless_clamped_and_mixes_texels(void **state)
{
    test_path path = write_quarters(*state, "quarters.png");
    for (int clamps = 0; clamps < 2; clamps++) {
        rk_texture texture;
        rk_error error;
        rk_texture_file_source source = {.name = path.text, .clamps = clamps};
        size_t texels_left = plenty;
        rk_check_ok(rk_texture_file_read(&texture, &source, "mesh.obj", &texels_left, &error),
                    error);
        check_texel(&texture, 1.25f, 0.75f, clamps ? rk_vec(0, 1, 0) : rk_vec(1, 0, 0));
        check_texel(&texture, 0.5f, 0.75f, rk_vec(0.5f, 0.5f, 0));
        rk_texture_free(&texture);
    }
}

static void texels_are_counted_and_too_many_refused(void **state)
{
    test_path path = write_quarters(*state, "quarters.png");
    rk_texture texture;
    rk_error error;
    rk_texture_file_source source = {.name = path.text};
    size_t texels_left = 7;
    rk_check_ok(rk_texture_file_read(&texture, &source, "mesh.obj", &texels_left, &error), error);
    rk_texture_free(&texture);
    rk_check_equal(texels_left, 3, "of 7, the picture takes 4");
    rk_check(!rk_texture_file_read(&texture, &source, "mesh.obj", &texels_left, &error),
             "4 texels were read where there is room for 3");
    rk_check(!texture.image.pixels, "pixels were left behind");
    rk_check_error_names(error, "quarters.png: has 2 x 2 pixels, more than the 3");
    rk_check_equal(texels_left, 3, "a refused picture takes nothing");
    /* Of this file only the head is left, so nobody has read its texels. */
    rk_check(truncate(path.text, 24) == 0, "the file can be cut");
    rk_check(!rk_texture_file_read(&texture, &source, "mesh.obj", &texels_left, &error),
             "a header was read as a picture");
    rk_check_error_names(error, "quarters.png: has 2 x 2 pixels, more than the 3");
}

/* --- pictures inside the mesh file --------------------------------------------------------- */

/* With the folder as TMPDIR. */
static bool read_embedded(rk_texture *texture, const test_folder *folder,
                          const unsigned char *bytes, size_t size, rk_error *error)
{
    const char *before = getenv("TMPDIR");
    char *saved = before ? strdup(before) : NULL;
    setenv("TMPDIR", folder->path, 1);
    rk_texture_file_source source = {.name = "*0", .data = bytes, .data_size = size};
    size_t texels_left = plenty;
    bool ok = rk_texture_file_read(texture, &source, "mesh.gltf", &texels_left, error);
    if (saved)
        setenv("TMPDIR", saved, 1);
    else
        unsetenv("TMPDIR");
    free(saved);
    return ok;
}

static void an_embedded_picture_is_read_and_leaves_no_file(void **state)
{
    rk_texture texture;
    rk_error error;
    size_t size;
    unsigned char *bytes = test_folder_read(write_quarters(*state, "quarters.png"), &size);
    bool ok = read_embedded(&texture, *state, bytes, size, &error);
    free(bytes);
    rk_check_ok(ok, error);
    check_quarters(&texture);
    rk_texture_free(&texture);
    rk_check_equal(test_folder_count(*state), 1, "the picture's own file");
}

static void a_damaged_embedded_picture_is_refused_and_leaves_no_file(void **state)
{
    rk_texture texture;
    rk_error error;
    size_t size;
    unsigned char *bytes = test_folder_read(write_quarters(*state, "quarters.png"), &size);
    bool ok = read_embedded(&texture, *state, bytes, size / 2, &error);
    free(bytes);
    rk_check(!ok, "half a picture was accepted");
    rk_check(!texture.image.pixels, "pixels were left behind");
    rk_check_error_names(error, "picture *0 in the mesh file: ");
    rk_check_equal(test_folder_count(*state), 1, "the picture's own file");
}

static void without_a_place_for_temporary_files_the_remedy_is_named(void **state)
{
    test_folder nowhere = {"/nowhere"};
    rk_texture texture;
    rk_error error;
    (void)state;
    rk_check(!read_embedded(&texture, &nowhere, (const unsigned char *)"x", 1, &error),
             "read without a temporary file");
    rk_check_error_names(error, "set TMPDIR");
}

static const struct CMUnitTest tests[] = {
    test_in_folder(a_name_is_relative_to_the_mesh_files_folder),
    test_in_folder(a_name_that_begins_with_a_slash_is_taken_as_it_is),
    test_in_folder(backslashes_are_slashes),
    test_in_folder(percent_signs_may_stand_for_characters_or_for_themselves),
    test_in_folder(without_the_folder_the_file_beside_the_mesh_is_read),
    test_in_folder(files_that_are_not_pictures_are_refused),
    test_in_folder(a_name_of_absurd_length_is_refused),
    test_in_folder(it_repeats_unless_clamped_and_mixes_texels),
    test_in_folder(texels_are_counted_and_too_many_refused),
    test_in_folder(an_embedded_picture_is_read_and_leaves_no_file),
    test_in_folder(a_damaged_embedded_picture_is_refused_and_leaves_no_file),
    cmocka_unit_test(without_a_place_for_temporary_files_the_remedy_is_named),
};

RK_SUITE("texture_file", tests)
