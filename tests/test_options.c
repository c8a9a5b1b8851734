/* Options: read, refused with a sentence that helps, and listed by --help. */
#include "test.h"
#include "test_comma_locale.h"

#include "base/options.h"

#include <fcntl.h>
#include <float.h>

typedef enum colour { red, green, blue } colour;

typedef struct choices {
    bool quiet;
    uint32_t width, seed, last;
    float fov, far, near;
    const char *out, *way;
    rk_text_list meshes;
    rk_pixel pixel;
    colour light;
} choices;

static choices values;

RK_NAMES(colour_names, colour, blue, "red", "green", "blue");

static const rk_option common[] = {
    {"width", RK_FIELD(choices, width), "N", "picture width in pixels", 1, 32768, 800,
     .alias = "columns"},
    {"seed", RK_FIELD(choices, seed), "N", "seed of the random numbers", 0, UINT32_MAX, 0},
    {"quiet", RK_FIELD(choices, quiet), NULL, "shows no progress"},
    {"out", RK_FIELD(choices, out), "FOLDER", "where the pictures go",
     .initial_text = "reports/out"},
    {0},
};
static const rk_option own[] = {
    {"fov", RK_FIELD(choices, fov), "DEGREES",
     "vertical field of view in degrees, which is a help text that needs more than one line of a "
     "terminal",
     1, 179, 50},
    {"far", RK_FIELD(choices, far), "X", "any distance", 0, INFINITY, 2.5},
    {"near", RK_FIELD(choices, near), "X", "any distance; by default none", 0, 9, NAN},
    {"last", RK_FIELD(choices, last), "N", "by default all", 0, 9, UINT32_MAX},
    {"way", RK_FIELD(choices, way), "NAME",
     "left   a way\nright  a way which is told in more words than a line will ever hold"},
    {"mesh", RK_FIELD(choices, meshes), "FILE", "a mesh file\nmay come again"},
    {"pixel", RK_FIELD(choices, pixel), "X,Y", "explains one pixel"},
    {"light", RK_CHOICE(choices, light, colour_names), "its colour", .alias = "lamp"},
    {"narrow", RK_FIELD(choices, quiet), NULL,
     "a b c d e f g h i j k l m n o p q r s t u v w x y z a b c d e f g h i j k l m n o p q r s t "
     "u v"},
    {"an-option-with-a-long-name", RK_FIELD(choices, quiet), NULL, "as quiet"},
    {0},
};
static const rk_option_table tables[] = {{common, &values}, {own, &values}};
static const char summary[] =
    "Renders a picture, which takes a summary that does not fit one line of "
    "eighty columns.\nSecond line.";

enum { arguments_max = 100 };

/* Parses a line of words. */
static rk_options_result parse(const char *line, rk_error *error)
{
    static char text[4096];
    char *argv[arguments_max + 2] = {(char[]){"folder/program"}};
    int argc = 1;
    memset(&values, 0xff, sizeof values);
    rk_options_set_defaults(common, &values);
    rk_options_set_defaults(own, &values);
    snprintf(text, sizeof text, "%s", line);
    for (char *word = strtok(text, " "); word && argc <= arguments_max; word = strtok(NULL, " "))
        argv[argc++] = word;
    *error = (rk_error){""};
    return rk_options_parse(argc, argv, summary, tables, 2, error);
}

static void check_accepted(const char *line)
{
    rk_error error;
    rk_check(parse(line, &error) == RK_OPTIONS_OK, "%s: %s", line, error.text);
}

/* Refused with a sentence that names the option, its values, and --help. */
static void check_refused(const char *line, const char *name, const char *takes)
{
    rk_error error;
    rk_check(parse(line, &error) == RK_OPTIONS_BAD, "\"%s\" was accepted", line);
    rk_check_error_names(error, name);
    rk_check_error_names(error, takes);
    rk_check_error_names(error, "see --help");
}

/* --- values ---------------------------------------------------------------------------------- */

static void without_arguments_the_defaults_stay(void **state)
{
    (void)state;
    check_accepted("");
    rk_check(values.width == 800 && values.fov == 50 && values.meshes.count == 0 &&
                 !values.pixel.given && !values.quiet && strcmp(values.out, "reports/out") == 0,
             "a default has changed");
    rk_check(isnan(values.near) && values.last == UINT32_MAX && !values.way &&
                 values.light == red && values.seed == 0,
             "options that are not given are NaN, above the range, or NULL");
}

static void a_row_knows_the_kind_of_its_field(void **state)
{
    (void)state;
    const struct {
        const char *name, *field;
        rk_option_kind kind;
    } want[] = {{"fov", "fov", RK_OPTION_FLOAT},     {"last", "last", RK_OPTION_UINT},
                {"way", "way", RK_OPTION_TEXT},      {"mesh", "meshes", RK_OPTION_LIST},
                {"pixel", "pixel", RK_OPTION_PIXEL}, {"light", "light", RK_OPTION_CHOICE},
                {"narrow", "quiet", RK_OPTION_FLAG}};
    for (size_t i = 0; i < sizeof want / sizeof *want; i++)
        for (const rk_option *row = own; row->name; row++)
            if (strcmp(row->name, want[i].name) == 0) {
                rk_check_equal(row->kind, want[i].kind, row->name);
                assert_string_equal(row->field, want[i].field);
            }
}

static void each_kind_of_value_is_read(void **state)
{
    (void)state;
    check_accepted(
        "--width 640 --fov=35.5 --quiet --out there --mesh a.obj --pixel 3,4 --mesh b.ply");
    rk_check_equal(values.width, 640, "--width 640");
    rk_check_close(values.fov, 35.5, 0, "--fov=35.5");
    rk_check(values.quiet, "--quiet");
    assert_string_equal(values.out, "there");
    rk_check_equal(values.meshes.count, 2, "--mesh came twice");
    assert_string_equal(values.meshes.items[0], "a.obj");
    assert_string_equal(values.meshes.items[1], "b.ply");
    rk_check(values.pixel.given && values.pixel.x == 3 && values.pixel.y == 4, "--pixel 3,4");
}

static void both_ends_of_a_range_belong_to_it(void **state)
{
    (void)state;
    check_accepted("--width 1 --fov 1 --seed 0");
    check_accepted("--width 32768 --fov 179 --seed 4294967295");
    rk_check_equal(values.width, 32768, "the highest");
    rk_check_equal(values.seed, UINT32_MAX, "all 32 bits");
    check_accepted("--far 0 --pixel 0,4294967295");
    rk_check_equal(values.pixel.y, UINT32_MAX, "all 32 bits");
    check_accepted("--far inf");
    rk_check(isinf(values.far), "infinity is accepted if it is in the range");
}

static void the_last_of_several_values_counts(void **state)
{
    (void)state;
    check_accepted("--width 3 --width 4");
    rk_check_equal(values.width, 4, "so that a script's options can be overridden");
}

static void an_unambiguous_prefix_of_a_name_is_enough(void **state)
{
    (void)state;
    check_accepted("--wid 3 --pix 1,2");
    rk_check(values.width == 3 && values.pixel.x == 1, "as getopt_long does everywhere");
    check_refused("--f 3", "--f", "more than one");
}

static void parsing_again_starts_anew(void **state)
{
    (void)state;
    rk_error error;
    for (int i = 0; i < 3; i++) {
        check_accepted("--width 3");
        rk_check_equal(values.width, 3, "each parse reads the first argument");
        rk_check(parse("-xyz --width 5", &error) == RK_OPTIONS_BAD, "stops within -xyz");
        check_accepted("--quiet --width 4");
        rk_check(values.quiet && values.width == 4, "nothing is left of the parse before");
    }
}

static void an_older_spelling_sets_the_same(void **state)
{
    (void)state;
    check_accepted("--columns 3 --lamp blue");
    rk_check(values.width == 3 && values.light == blue, "--columns is --width, --lamp is --light");
    check_accepted("--columns=3 --width=4");
    rk_check_equal(values.width, 4, "the last one counts, however it is spelled");
    check_refused("--columns 0", "--columns 0", "1 to 32768");
    check_refused("--col=0", "--columns 0", "1 to 32768");
    check_refused("--columns", "--columns: the value is missing", "1 to 32768");
    check_refused("--lamp pink", "--lamp pink", "one of red|green|blue");
}

static void numbers_have_a_decimal_point_in_every_locale(void **state)
{
    rk_error error;
    if (!test_comma_locale_begin(*state))
        skip();
    check_accepted("--fov 1.5");
    rk_check_close(values.fov, 1.5, 0, "as where numbers have a point");
    rk_check(parse("--fov 1,5", &error) == RK_OPTIONS_BAD, "a comma was accepted");
    rk_check(parse("--far x", &error) == RK_OPTIONS_BAD, "x is no number");
    check_refused("--fov 0.5", "--fov 0.5", "1 to 179");
}

static void an_argument_that_is_spelled_out_is_found(void **state)
{
    (void)state;
    const char *const good[] = {"--width", "--width=3", "--columns", "--columns=3", "--width="};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        rk_check(rk_options_find(tables, 2, good[i]) == &common[0], "%s is --width", good[i]);
    const char *const others[] = {"width", "--col", "--columnss", "--", "--=", "", "-width", "3"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        rk_check(!rk_options_find(tables, 2, others[i]), "%s is no option's name", others[i]);
}

/* --- values that programs set ---------------------------------------------------------------- */

static void check_row_refuses(const rk_option *rows, const char *field, const char *takes)
{
    rk_error error = {""};
    rk_check(!rk_options_check(rows, &values, &error), "%s was accepted", field);
    rk_check_error_names(error, field);
    rk_check_error_names(error, takes);
    check_accepted("");
}

static void a_value_out_of_range_is_refused_by_its_field(void **state)
{
    (void)state;
    check_accepted("");
    values.width = 0;
    check_row_refuses(common, "width is 0", "a whole number, 1 to 32768");
    values.width = 32769;
    check_row_refuses(common, "width is 32769", "1 to 32768");
    values.fov = NAN;
    check_row_refuses(own, "fov is nan", "1 to 179");
    values.far = -0.5f;
    check_row_refuses(own, "far is -0.5", "0 or more");
    values.last = 10;
    check_row_refuses(own, "last is 10", "0 to 9");
    values.light = (colour)3;
    check_row_refuses(own, "light is 3", "colour goes from 0 to 2");
}

static void defaults_and_both_ends_of_a_range_are_accepted(void **state)
{
    (void)state;
    rk_error error;
    check_accepted("");
    rk_check_ok(rk_options_check(common, &values, &error), error);
    rk_check_ok(rk_options_check(own, &values, &error), error);
    values.width = 32768, values.fov = 179, values.far = INFINITY, values.near = 9, values.last = 9,
    values.light = blue;
    rk_check_ok(rk_options_check(common, &values, &error), error);
    rk_check_ok(rk_options_check(own, &values, &error), error);
}

/* --- refusals -------------------------------------------------------------------------------- */

static void unknown_options_are_refused(void **state)
{
    (void)state;
    check_refused("--widht 3", "--widht", "no such option");
    check_refused("--quiet -q", "-q", "no such option");
    check_refused("-", "-", "unexpected argument");
    check_refused("--=3", "--=3", "no such option");
}

static void a_missing_value_is_refused_with_what_it_takes(void **state)
{
    (void)state;
    check_refused("--width", "--width", "a whole number, 1 to 32768");
    check_refused("--quiet --fov", "--fov", "a number, 1 to 179");
    check_refused("--mesh", "--mesh", "FILE");
    check_refused("--pixel", "--pixel", "X,Y");
}

static void a_value_for_a_flag_is_refused(void **state)
{
    (void)state;
    check_refused("--quiet=yes", "--quiet=yes", "takes no value");
    check_refused("--help=yes", "--help=yes", "takes no value");
}

static void a_value_that_is_no_whole_number_in_range_is_refused(void **state)
{
    (void)state;
    const char *bad[] = {"abc",
                         "0",
                         "32769",
                         "-1",
                         "+5",
                         "3.5",
                         "1e3",
                         "12px",
                         "0x10",
                         "3,4",
                         "nan",
                         "4294967297",
                         "18446744073709551617",
                         "99999999999999999999999999"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char line[80];
        snprintf(line, sizeof line, "--width %s", bad[i]);
        check_refused(line, line, "a whole number, 1 to 32768");
        rk_check_equal(values.width, 800, "a refused value is not stored");
    }
    check_refused("--width=", "--width", "a whole number");
    check_refused("--seed 4294967296", "--seed", "0 to 4294967295");
}

static void a_value_that_is_no_number_in_range_is_refused(void **state)
{
    (void)state;
    const char *bad[] = {"abc", "0.999", "179.001", "-1",  "3x",
                         "3,5", "nan",   "-nan",    "inf", "1e400"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char line[80];
        snprintf(line, sizeof line, "--fov %s", bad[i]);
        check_refused(line, line, "a number, 1 to 179");
        rk_check_close(values.fov, 50, 0, "a refused value is not stored");
    }
    check_refused("--fov=", "--fov", "a number");
    check_refused("--far=", "--far", "a number, 0 or more");
    check_refused("--far nan", "--far", "0 or more");
    check_refused("--far 1e39", "--far", "0 or more");
    check_refused("--far -0.001", "--far", "0 or more");
}

static void a_value_that_is_no_pixel_is_refused(void **state)
{
    (void)state;
    const char *bad[] = {"3",    "3,",    ",4",           "3,4x", "3,4,5", "3;4",
                         "-3,4", "3.5,4", "4294967296,0", "a,b",  "3,-4"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char line[80];
        snprintf(line, sizeof line, "--pixel %s", bad[i]);
        check_refused(line, line, "X,Y");
        rk_check(!values.pixel.given, "a refused value is not stored");
    }
}

static void a_choice_is_one_of_its_names(void **state)
{
    (void)state;
    check_accepted("");
    rk_check_equal(values.light, red, "the default");
    check_accepted("--light blue");
    rk_check_equal(values.light, blue, "--light blue");
    const char *const bad[] = {"--light gre", "--light greenish", "--light red|green",
                               "--light 1",   "--light=",         "--light |"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        check_refused(bad[i], "--light", "one of red|green|blue");
        rk_check_equal(values.light, red, "a refused value is not stored");
    }
}

static void stray_words_are_refused(void **state)
{
    (void)state;
    check_refused("picture.png", "picture.png", "unexpected argument");
    check_refused("--width 3 picture.png --quiet", "picture.png", "unexpected argument");
    check_refused("picture.png --widht", "picture.png", "unexpected argument");
    check_refused("-- picture.png", "picture.png", "unexpected argument");
    check_accepted("--width 3 --");
}

static void a_list_that_is_full_is_refused(void **state)
{
    (void)state;
    char line[2000] = "";
    for (int i = 0; i < RK_TEXT_LIST_MAX; i++)
        strcat(line, "--mesh=a ");
    check_accepted(line);
    strcat(line, "--mesh=a");
    check_refused(line, "--mesh", "64 times");
}

static void the_longest_value_leaves_room_for_the_remedy(void **state)
{
    (void)state;
    char line[3000] = "--width ";
    memset(line + 8, '9', 2900);
    line[2908] = '\0';
    check_refused(line, "--width 999", "1 to 32768");
}

/* --- output ---------------------------------------------------------------------------------- */

typedef struct print {
    rk_options_result result;
    char output[4096], errors[4096];
} print;

static int redirect(FILE *stream, const char *path)
{
    fflush(stream);
    int kept = dup(fileno(stream)), file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, fileno(stream));
    close(file);
    return kept;
}

static void restore(FILE *stream, int kept)
{
    fflush(stream);
    dup2(kept, fileno(stream));
    close(kept);
    clearerr(stream);
}

static void read_back(const char *path, char *text, size_t size)
{
    FILE *stream = fopen(path, "rb");
    rk_check(stream, "%s should exist", path);
    text[fread(text, 1, size - 1, stream)] = '\0';
    fclose(stream);
}

static print parse_printing(const test_folder *folder, const char *line)
{
    print got = {0};
    rk_error error;
    int output = redirect(stdout, test_folder_path(folder, "output").text);
    int errors = redirect(stderr, test_folder_path(folder, "errors").text);
    got.result = parse(line, &error);
    restore(stdout, output);
    restore(stderr, errors);
    read_back(test_folder_path(folder, "output").text, got.output, sizeof got.output);
    read_back(test_folder_path(folder, "errors").text, got.errors, sizeof got.errors);
    return got;
}

static void check_lists(const char *help, const char *part)
{
    rk_check(strstr(help, part), "--help should contain \"%s\":\n%s", part, help);
}

static void help_lists_every_option_with_range_and_default(void **state)
{
    print help = parse_printing(*state, "--help");
    rk_check_equal(help.result, RK_OPTIONS_DONE, "help ends the program with success");
    check_lists(help.output, "usage: program [OPTION]...\n");
    check_lists(help.output,
                "  --width N             picture width in pixels (1 to 32768; default 800)\n");
    check_lists(help.output, "  --seed N ");
    check_lists(help.output, "seed of the random numbers (default 0)\n");
    check_lists(help.output, "any distance; by default none (0 to 9)\n");
    check_lists(help.output, "  --quiet               shows no progress\n");
    check_lists(help.output,
                "  --out FOLDER          where the pictures go (default reports/out)\n");
    check_lists(help.output, "  --fov DEGREES         vertical field of view");
    check_lists(help.output, "default 50)\n");
    check_lists(help.output, "(0 or more; default 2.5)\n");
    check_lists(help.output,
                "  --mesh FILE           a mesh file\n                        may come again\n");
    check_lists(help.output, "  --pixel X,Y           explains one pixel\n");
    check_lists(help.output, "its colour (default red)\n");
    check_lists(help.output, "  --light red|green|blue\n");
    rk_check(!strstr(help.output, "--columns") && !strstr(help.output, "--lamp"),
             "older spellings are not listed:\n%s", help.output);
    check_lists(help.output, "by default all (0 to 9)\n");
    check_lists(help.output, "  --an-option-with-a-long-name\n                        as quiet\n");
    check_lists(help.output, "  --help                this text\n");
    check_lists(help.output, "  --version             the version\n");
    check_lists(help.output, "\nSecond line.\n\n");
    rk_check(help.errors[0] == '\0', "standard error should stay empty: %s", help.errors);
}

static void help_keeps_the_columns_of_a_list(void **state)
{
    print help = parse_printing(*state, "--help");
    check_lists(help.output,
                "  --way NAME            left   a way\n"
                "                        right  a way which is told in more words than a line\n"
                "                               will ever hold\n");
}

static void help_fits_eighty_columns_and_fills_them(void **state)
{
    print help = parse_printing(*state, "--help");
    size_t longest = 0;
    for (const char *line = help.output; *line;) {
        size_t length = strcspn(line, "\n");
        rk_check(length <= 80, "a line of %zu columns: %.*s", length, (int)length, line);
        rk_check(length == 0 || line[length - 1] != ' ', "a space ends: %.*s", (int)length, line);
        longest = length > longest ? length : longest;
        line += length + 1;
    }
    rk_check(longest > 70, "the longest line has %zu columns", longest);
    check_lists(help.output, "\n                        ");
}

static void help_shows_defaults_whatever_else_is_given(void **state)
{
    const char *lines[] = {"--width 3 --help", "-h", "--widht --help", "--width x --help", "--he"};
    for (int i = 0; i < 5; i++) {
        print help = parse_printing(*state, lines[i]);
        rk_check_equal(help.result, RK_OPTIONS_DONE, lines[i]);
        check_lists(help.output, "(1 to 32768; default 800)");
    }
}

static void version_is_the_name_and_a_number(void **state)
{
    print version = parse_printing(*state, "--version");
    rk_check_equal(version.result, RK_OPTIONS_DONE, "the version ends the program with success");
    assert_string_equal(version.output, "raykit " PACKAGE_VERSION "\n");
}

static void refusals_print_nothing(void **state)
{
    const char *lines[] = {"--widht", "--width", "--width x", "--quiet=1", "-x", "x"};
    for (int i = 0; i < 6; i++) {
        print refusal = parse_printing(*state, lines[i]);
        rk_check_equal(refusal.result, RK_OPTIONS_BAD, lines[i]);
        rk_check(!*refusal.output && !*refusal.errors, "%s printed: %s%s", lines[i], refusal.output,
                 refusal.errors);
    }
}

static void help_into_a_full_device_is_an_error(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0)
        return; /* only Linux has it */
    rk_error error;
    int output = redirect(stdout, "/dev/full");
    rk_options_result result = parse("--help", &error);
    restore(stdout, output);
    rk_check_equal(result, RK_OPTIONS_BAD, "a write error is not a success");
    rk_check_error_names(error, "standard output");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(without_arguments_the_defaults_stay),
    cmocka_unit_test(a_row_knows_the_kind_of_its_field),
    cmocka_unit_test(each_kind_of_value_is_read),
    cmocka_unit_test(both_ends_of_a_range_belong_to_it),
    cmocka_unit_test(the_last_of_several_values_counts),
    cmocka_unit_test(an_unambiguous_prefix_of_a_name_is_enough),
    cmocka_unit_test(parsing_again_starts_anew),
    cmocka_unit_test(an_older_spelling_sets_the_same),
    test_in_comma_locale(numbers_have_a_decimal_point_in_every_locale),
    cmocka_unit_test(an_argument_that_is_spelled_out_is_found),
    cmocka_unit_test(a_value_out_of_range_is_refused_by_its_field),
    cmocka_unit_test(defaults_and_both_ends_of_a_range_are_accepted),
    cmocka_unit_test(unknown_options_are_refused),
    cmocka_unit_test(a_missing_value_is_refused_with_what_it_takes),
    cmocka_unit_test(a_value_for_a_flag_is_refused),
    cmocka_unit_test(a_value_that_is_no_whole_number_in_range_is_refused),
    cmocka_unit_test(a_value_that_is_no_number_in_range_is_refused),
    cmocka_unit_test(a_value_that_is_no_pixel_is_refused),
    cmocka_unit_test(a_choice_is_one_of_its_names),
    cmocka_unit_test(stray_words_are_refused),
    cmocka_unit_test(a_list_that_is_full_is_refused),
    cmocka_unit_test(the_longest_value_leaves_room_for_the_remedy),
    test_in_folder(help_lists_every_option_with_range_and_default),
    test_in_folder(help_keeps_the_columns_of_a_list),
    test_in_folder(help_fits_eighty_columns_and_fills_them),
    test_in_folder(help_shows_defaults_whatever_else_is_given),
    test_in_folder(version_is_the_name_and_a_number),
    test_in_folder(refusals_print_nothing),
    cmocka_unit_test(help_into_a_full_device_is_an_error),
};

RK_SUITE("options", tests)
