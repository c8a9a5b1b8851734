/* Damaged mesh files: from any damage to a good one, rk_mesh_file_read gives a valid mesh, or the
 * reason in one line that names the file; it never crashes, leaks or hangs.
 *
 * Deterministic: case i of a format is the same file on every machine, and case 0 is undamaged.
 * RAYKIT_STRESS=N runs N times as many cases (make stress), RAYKIT_FUZZ_FIRST=I starts at case I,
 * to debug one. */
#include "../test.h"

#include "../mesh_seeds.h"
#include "../remedy.h"
#include "../test_folder.h"

#include "base/random.h"
#include "io/mesh_file.h"

#include <ctype.h>

enum { cases_in_check = 20, longest = sizeof(((mesh_seed *)0)->bytes) };

static test_folder folder;

typedef struct chance {
    uint32_t format, number, draws;
} chance;

/* Returns one of 0 ... count - 1, all as likely; 0 if count is 0. */
static size_t draw(chance *c, size_t count)
{
    uint32_t bits = rk_hash(0x66757a7a, c->format, c->number, c->draws++);
    return (size_t)((uint64_t)bits * count >> 32);
}

/* --- damage -------------------------------------------------------------------------------- */

static void truncate_seed(mesh_seed *seed, chance *c)
{
    seed->size = draw(c, seed->size);
}

static void flip_bits(mesh_seed *seed, chance *c)
{
    for (size_t n = 1 + draw(c, 8); n > 0 && seed->size > 0; n--)
        seed->bytes[draw(c, seed->size)] ^= (unsigned char)(1u << draw(c, 8));
}

static void overwrite_run(mesh_seed *seed, chance *c)
{
    const unsigned char fills[] = {0x00, 0xff, 0x80, ' ', '\n', '9'};
    size_t begin = draw(c, seed->size), length = 1 + draw(c, 16);
    unsigned char fill = fills[draw(c, sizeof fills)];
    for (size_t i = begin; i < seed->size && i < begin + length; i++)
        seed->bytes[i] = fill;
}

static void remove_run(mesh_seed *seed, chance *c)
{
    size_t begin = draw(c, seed->size), length = 1 + draw(c, 16);
    if (begin + length > seed->size)
        return;
    memmove(seed->bytes + begin, seed->bytes + begin + length, seed->size - begin - length);
    seed->size -= length;
}

static bool is_number_byte(const mesh_seed *seed, size_t i)
{
    return i < seed->size &&
           (isdigit(seed->bytes[i]) || seed->bytes[i] == '-' || seed->bytes[i] == '.');
}

static void replace_number(mesh_seed *seed, chance *c)
{
    static const char *const odd[] = {
        "nan",        "inf", "1e999", "-1", "4294967295", "2147483648",
        "1000000000", "0",   "",      "-",  "1e-999",     "99999999999999999999"};
    size_t begin = draw(c, seed->size);
    while (begin < seed->size && !is_number_byte(seed, begin))
        begin++;
    size_t end = begin;
    while (is_number_byte(seed, end))
        end++;
    const char *text = odd[draw(c, sizeof odd / sizeof *odd)];
    size_t length = strlen(text);
    if (seed->size - (end - begin) + length > longest)
        return;
    memmove(seed->bytes + begin + length, seed->bytes + end, seed->size - end);
    memcpy(seed->bytes + begin, text, length);
    seed->size = seed->size - (end - begin) + length;
}

static void damage(mesh_seed *seed, chance *c)
{
    static void (*const ways[])(mesh_seed *, chance *) = {
        truncate_seed, flip_bits, overwrite_run, remove_run, replace_number, replace_number};
    for (size_t n = 1 + draw(c, 2); n > 0 && seed->size > 0; n--)
        ways[draw(c, sizeof ways / sizeof *ways)](seed, c);
}

/* --- verdict ------------------------------------------------------------------------------- */

static uint32_t number_from(const char *variable, uint32_t otherwise)
{
    const char *text = getenv(variable);
    return text && *text ? (uint32_t)strtoul(text, NULL, 10) : otherwise;
}

typedef struct tally {
    uint32_t loaded, refused, died;
} tally;

static void run_case(int format, uint32_t number, tally *t)
{
    mesh_seed seed = make_seed(format);
    chance c = {(uint32_t)format, number, 0};
    if (number > 0)
        damage(&seed, &c);
    test_path path = test_folder_write(&folder, seed.name, seed.bytes, seed.size, 0600);
    rk_mesh mesh;
    rk_error error = {0};
    const char *again = "run it again with RAYKIT_FUZZ_FIRST and RAYKIT_STRESS=1";
    if (rk_mesh_file_read(&mesh, path.text, &error)) {
        rk_check(mesh.triangle_count > 0, "%s, case %u: no triangles; %s", seed.name, number,
                 again);
        rk_check(rk_mesh_validate(&mesh, seed.name, &error), "%s, case %u: %s; %s", seed.name,
                 number, error.text, again);
        t->loaded++;
    } else {
        rk_check(number > 0, "%s: the undamaged seed was refused: %s", seed.name, error.text);
        rk_check(strncmp(error.text, path.text, strlen(path.text)) == 0 &&
                     !strchr(error.text, '\n') && strlen(error.text) > strlen(path.text) + 2,
                 "%s, case %u: the error should name the file and a reason, but is: \"%s\"; %s",
                 seed.name, number, error.text, again);
        rk_check_remedy(error.text);
        rk_check(mesh.triangle_count == 0 && !mesh.positions, "%s, case %u: left a mesh behind; %s",
                 seed.name, number, again);
        rk_check(!strstr(error.text, "was silent"), "%s, case %u: the helper hung; %s", seed.name,
                 number, again);
        bool died = strstr(error.text, "by signal") != NULL;
        if (died && getenv("RAYKIT_FUZZ_VERBOSE"))
            fprintf(stderr, "# case %u: %s\n", number, error.text);
        t->died += died;
        t->refused += !died;
    }
    rk_mesh_free(&mesh);
}

static void run_format(int format)
{
    uint32_t first = number_from("RAYKIT_FUZZ_FIRST", 0);
    uint32_t count = cases_in_check * number_from("RAYKIT_STRESS", 1);
    test_folder_write(&folder, "seed.mtl", seed_mtl, sizeof seed_mtl - 1, 0600);
    tally t = {0};
    for (uint32_t i = first; i < first + count; i++)
        run_case(format, i, &t);
    print_message("# %s: %u cases: %u loaded, %u refused, %u ended by a signal in the helper\n",
                  make_seed(format).name, count, t.loaded, t.refused, t.died);
    rk_check_equal(t.loaded + t.refused + t.died, count, "every case has a verdict");
}

static void damaged_obj_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_obj);
}

static void damaged_text_ply_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_ply_text);
}

static void damaged_binary_ply_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_ply_binary);
}

static void damaged_off_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_off);
}

static void damaged_gltf_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_gltf);
}

static void damaged_gltf_with_a_picture_gives_a_mesh_or_a_reason(void **state)
{
    (void)state;
    run_format(seed_gltf_textured);
}

/* Too large for tests/test_mesh_file.c. */
static test_path write_parts(uint32_t count, uint32_t materials)
{
    const size_t room = (size_t)count * 130 + 4096;
    char *text = malloc(room);
    assert_non_null(text);
    size_t n =
        (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
                              "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[");
    for (uint32_t i = 0; i < count; i++)
        n += (size_t)sprintf(text + n, "%s{\"attributes\":{\"POSITION\":0},\"material\":%u}",
                             i ? "," : "", i % materials);
    n += (size_t)sprintf(text + n, "]}],\"materials\":[{}");
    for (uint32_t i = 1; i < materials; i++)
        n += (size_t)sprintf(text + n, ",{}");
    sprintf(text + n, "],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
                      "\"count\":3,\"type\":\"VEC3\"}],"
                      "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                      "\"buffers\":[{\"byteLength\":36,\"uri\":"
                      "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"
                      "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}");
    test_path path = test_folder_write(&folder, "many.gltf", text, strlen(text), 0600);
    free(text);
    return path;
}

static void more_materials_than_16_bits_count_are_refused(void **state)
{
    (void)state;
    const test_path path = write_parts(UINT16_MAX + 1, UINT16_MAX + 1);
    rk_mesh mesh;
    rk_error error;
    rk_check(!rk_mesh_file_read(&mesh, path.text, &error), "65536 materials were accepted");
    rk_check_error_names(error, "many.gltf: uses 65536 materials, more than 65535");
}

static void each_of_many_parts_is_found_quickly(void **state)
{
    (void)state;
    const test_path path = write_parts(UINT16_MAX, 1);
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_file_read(&mesh, path.text, &error), error);
    rk_check_equal(mesh.triangle_count, UINT16_MAX, "triangles");
    rk_mesh_free(&mesh);
}

static int make_folder(void **state)
{
    (void)state;
    return !test_folder_make(&folder);
}

static int remove_folder(void **state)
{
    (void)state;
    test_folder_remove(&folder);
    return 0;
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(damaged_obj_gives_a_mesh_or_a_reason),
    cmocka_unit_test(damaged_text_ply_gives_a_mesh_or_a_reason),
    cmocka_unit_test(damaged_binary_ply_gives_a_mesh_or_a_reason),
    cmocka_unit_test(damaged_off_gives_a_mesh_or_a_reason),
    cmocka_unit_test(damaged_gltf_gives_a_mesh_or_a_reason),
    cmocka_unit_test(damaged_gltf_with_a_picture_gives_a_mesh_or_a_reason),
    cmocka_unit_test(more_materials_than_16_bits_count_are_refused),
    cmocka_unit_test(each_of_many_parts_is_found_quickly),
};

RK_SUITE_IN("fuzz_mesh_file", tests, make_folder, remove_folder)
