/* The common behaviour of the drivers, mostly tested with the first of them: the program itself is
 * run, and its output and files are checked. */
#include "test.h"
#include "test_folder.h"

#include "base/image.h"
#include "io/png.h"

#include <ctype.h>
#include <fcntl.h>
#include <ftw.h>
#include <glob.h>
#include <sys/resource.h>
#include <sys/wait.h>

static const char program[] = RK_BUILD_FOLDER "/assignments/01_bvh_median/bvh_median";
static const char wide_program[] = "15_wide_bvh/wide_bvh";
static const char sah_program[] = RK_BUILD_FOLDER "/assignments/02_sah_binning/sah_binning";

typedef struct run {
    int status; /* of the exit; -1: killed */
    char *out, *err;
} run;

static void run_free(run *r)
{
    free(r->out);
    free(r->err);
}

static void open_as(const char *path, int descriptor)
{
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0 || dup2(file, descriptor) < 0)
        _exit(126);
    close(file);
}

static char *read_text(test_path path)
{
    size_t size;
    char *text = (char *)test_folder_read(path, &size);
    text[size] = '\0';
    remove(path.text);
    return text;
}

/* Runs a driver in `folder` with words separated by single spaces. */
static run run_program(const char *path, const test_folder *folder, const char *arguments)
{
    char words[1024], *argv[64] = {(char *)(uintptr_t)path};
    int argc = 1;
    snprintf(words, sizeof words, "%s", arguments);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        argv[argc++] = word;
    test_path out = test_folder_path(folder, "stdout"), err = test_folder_path(folder, "stderr");
    pid_t child = fork();
    if (child == 0) {
        open_as(out.text, 1);
        open_as(err.text, 2);
        if (chdir(folder->path) == 0)
            execv(path, argv);
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return (run){WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
}

/* The program of any feature, such as "06_bloom/bloom". */
static run run_feature(const char *name, const test_folder *folder, const char *arguments)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/assignments/%s", RK_BUILD_FOLDER, name);
    return run_program(path, folder, arguments);
}

static run run_driver(const test_folder *folder, const char *arguments)
{
    return run_program(program, folder, arguments);
}

static run run_well(const test_folder *folder, const char *arguments)
{
    run r = run_driver(folder, arguments);
    rk_check(r.status == 0, "%s: exit status %d: %s", arguments, r.status, r.err);
    rk_check(r.err[0] == '\0', "%s: a success prints no error: %s", arguments, r.err);
    return r;
}

static double children_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_CHILDREN, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

/* --- Files in the folder --------------------------------------------------------------------- */

static int files_found;

static int count_file(const char *path, const struct stat *status, int type, struct FTW *place)
{
    (void)path, (void)status, (void)place;
    files_found += type != FTW_D;
    return 0;
}

static int count_files(const test_folder *folder)
{
    files_found = 0;
    nftw(folder->path, count_file, 8, FTW_PHYS);
    return files_found;
}

static bool is_there(const test_folder *folder, const char *name)
{
    return access(test_folder_path(folder, name).text, F_OK) == 0;
}

/* --- Help and complaints --------------------------------------------------------------------- */

static void check_contains(const char *text, const char *part)
{
    rk_check(strstr(text, part) != NULL, "\"%s\" is missing in:\n%s", part, text);
}

static void help_and_version_are_successes(void **state)
{
    run help = run_well(*state, "--help"), version = run_well(*state, "--version");
    check_contains(help.out, "usage: bvh_median [OPTION]...");
    check_contains(version.out, "raykit ");
    rk_check_equal(count_files(*state), 0, "neither writes a file");
    run_free(&help);
    run_free(&version);
}

static void helper_programs_have_the_drivers_version(void **state)
{
    static const char *const names[] = {"raykit-mesh", "raykit-image"};
    run version = run_well(*state, "--version");
    const char *number = version.out + strlen("raykit");
    int found = 0;
    for (int i = 0; i < 2; i++) {
        char path[4096], wanted[64];
        snprintf(path, sizeof path, "%s/%s", RK_BUILD_FOLDER, names[i]);
        if (access(path, X_OK) != 0)
            continue; /* it needs a library that is not installed */
        run r = run_program(path, *state, "--version");
        snprintf(wanted, sizeof wanted, "%s%s", names[i], number);
        rk_check(r.status == 0 && strcmp(r.out, wanted) == 0 && r.err[0] == '\0',
                 "%s --version: exit status %d, printed \"%s\" and \"%s\", wanted \"%s\"", names[i],
                 r.status, r.out, r.err, wanted);
        run_free(&r);
        found++;
    }
    run_free(&version);
    if (found == 0)
        skip();
}

/* A line must not end before a word that fits it. */
static void check_paragraphs(const char *name, const char *text)
{
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n");
        rk_check(length <= 80, "%s: a line of %zu columns: %.*s", name, length, (int)length, line);
        const char *next = line + length + (line[length] == '\n');
        size_t indent = strspn(next, " "), word = strcspn(next + indent, " \n");
        /* Continuations begin with a small letter at the same indent. */
        if (length > 0 && islower((unsigned char)next[indent]) && strspn(line, " ") == indent)
            rk_check(length + 1 + word > 80, "%s: \"%.*s\" has room in the line above it:\n%.*s",
                     name, (int)word, next + indent, (int)length, line);
        line = next;
    }
}

static void every_help_is_wrapped_as_if_by_hand(void **state)
{
    glob_t folders;
    rk_check(glob(RK_BUILD_FOLDER "/assignments/[0-9][0-9]_*", 0, NULL, &folders) == 0,
             "no drivers below %s", RK_BUILD_FOLDER);
    for (size_t i = 0; i < folders.gl_pathc; i++) {
        const char *folder = strrchr(folders.gl_pathv[i], '/') + 1;
        char name[512];
        snprintf(name, sizeof name, "%s/%s", folder, strchr(folder, '_') + 1);
        run help = run_feature(name, *state, "--help");
        rk_check_equal(help.status, 0, name);
        check_paragraphs(name, help.out);
        run_free(&help);
    }
    globfree(&folders);
}

static void help_speaks_to_a_newcomer(void **state)
{
    run help = run_well(*state, "--help");
    const char *const parts[] = {"draw a debug view: level, leaf", "by default the scene's",
                                 "cube            12 triangles", "(default cornell)",
                                 "(default out)"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        check_contains(help.out, parts[i]);
    const char *const riddles[] = {"nan",         "inf",         "4294967295", "4000000000", "e+",
                                   "--recursion", "--light-map", "--settle",   "--isolate"};
    for (size_t i = 0; i < sizeof riddles / sizeof *riddles; i++)
        rk_check(!strstr(help.out, riddles[i]), "a newcomer does not know \"%s\":\n%s", riddles[i],
                 help.out);
    run_free(&help);
}

/* One line on standard error that begins with the program's name and names the fault; no file. */
static void check_feature_complaint(const char *name, const test_folder *folder,
                                    const char *arguments, const char *thing, const char *remedy)
{
    int before = count_files(folder);
    const char *feature = strchr(name, '/') + 1;
    run r = run_feature(name, folder, arguments);
    rk_check_equal(r.status, 1, arguments);
    rk_check(r.out[0] == '\0', "%s: complaints go to standard error, not\n%s", arguments, r.out);
    rk_check(strncmp(r.err, feature, strlen(feature)) == 0 && r.err[strlen(feature)] == ':',
             "%s: the program's name is missing: %s", arguments, r.err);
    size_t length = strlen(r.err);
    rk_check(strcspn(r.err, "\n") + 1 == length, "%s: it should be one line:\n%s", arguments,
             r.err);
    check_contains(r.err, thing);
    check_contains(r.err, remedy);
    rk_check_equal(count_files(folder), before, "a failure leaves no file");
    run_free(&r);
}

static void check_complaint(const test_folder *folder, const char *arguments, const char *thing,
                            const char *remedy)
{
    check_feature_complaint("01_bvh_median/bvh_median", folder, arguments, thing, remedy);
}

static void every_bad_option_is_named_in_one_line(void **state)
{
    const char *const bad[][3] = {
        {"--bogus", "--bogus", "see --help"},
        {"--width 0", "--width 0", "1 to 32768"},
        {"--height 32769", "--height 32769", "1 to 32768"},
        {"--width 1e3", "--width 1e3", "a whole number"},
        {"--samples", "--samples", "the value is missing"},
        {"--fov nan", "--fov nan", "1 to 179"},
        {"--seed 4294967296", "--seed 4294967296", "see --help"},
        {"picture.png", "picture.png", "see --help"},
        {"--pixel 3", "--pixel 3", "X,Y"},
        {"--pixel 800,0", "--pixel 800,0", "800 x 800"},
        {"--width 9 --height 7 --pixel 3,7", "--pixel 3,7", "9 x 7"},
        {"--scene castle", "--scene castle", "cornell"},
        {"--scene cube:3", "--scene cube:3", "no number"},
        {"--debug everything", "--debug everything", "level, leaf"},
        {"--debug", "--debug", "the value is missing"},
        {"--scene cube --mesh a.obj", "--scene and --mesh", "choose one"},
        {"--up z", "--up", "--mesh"},
        {"--mesh a.obj --up -z", "--up -z", "x|y|z|file"},
        {"--front -z", "--front", "--mesh"},
        {"--mesh a.obj --up z --front -z", "--front -z", "points up"},
        {"--mesh a.obj --up x --front x", "--front x", "points up"},
        {"--environment sky --background 1", "--environment and --background", "choose one"},
        {"--background 2", "--background 2", "0 to 1"},
        {"--timing --debug leaf", "--timing and --debug", "choose one"},
        {"--threads 1025", "--threads 1025", "0 to 1024"},
        {"--split morton", "--split morton", "median|sah|sah3|collapsed"},
        {"--light-map round", "--light-map round", "area|solid-angle"},
        {"--recursion 17", "--recursion 17", "0 to 16"},
        {"--bins 1", "--bins 1", "2 to 256"},
        {"--single-time 3", "the single time 3", "--time-samples N"},
        {"--environment=", "--environment", "sky"},
        {"--move --time-samples 2 --debug level", "everything moves", "--move"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        check_complaint(*state, bad[i][0], bad[i][1], bad[i][2]);
}

static void options_that_do_not_go_together_are_refused(void **state)
{
    const char *const bad[][4] = {
        {"05_transparency/transparency", "--debug rays", "--debug rays", "--transparency"},
        {"08_cubemap/cubemap", "--scene cube --debug seam --pixel 3,4", "--debug seam", "--pixel"},
        {"09_depth_of_field/depth_of_field", "--scene cube --debug focus --pixel 3,4",
         "--debug focus", "--debug rays"},
        {"10_motion_blur/motion_blur", "--single-time 3 --time-samples 0", "the single time 3",
         "--time-samples N"},
        {"10_motion_blur/motion_blur", "--debug path --still", "--debug path", "--still"},
        {"10_motion_blur/motion_blur", "--convergence --still", "--convergence", "--still"},
        {"10_motion_blur/motion_blur", "--move", "--move", "see --help"},
        {"15_wide_bvh/wide_bvh", "--split half", "--split half", "collapsed|morton|wide"},
        {"15_wide_bvh/wide_bvh", "--debug node --split sah3", "--debug", "--split collapsed"},
        {"15_wide_bvh/wide_bvh", "--occupancy --split median", "--occupancy", "--split collapsed"},
        {"15_wide_bvh/wide_bvh", "--debug node --node 9", "--node 9", "0 to 1"},
        {"15_wide_bvh/wide_bvh", "--debug level --level 9", "--level 9", "0 to 2"},
        {"15_wide_bvh/wide_bvh", "--debug blocks --level 3", "--level", "--debug level"},
        {"15_wide_bvh/wide_bvh", "--debug node --move", "--debug", "--move"},
        {"15_wide_bvh/wide_bvh", "--steps --scene moving", "--steps", "statue"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        check_feature_complaint(bad[i][0], *state, bad[i][1], bad[i][2], bad[i][3]);
}

static void an_option_without_effect_is_noted(void **state)
{
    const char *const cases[][3] = {
        {"--glossy-radius 0.2", "--glossy-radius changes nothing", "--glossy, "},
        {"--bloom-radius 3 --bloom-border clamp", "--bloom-radius changes nothing", "--bloom, "},
        {"--light-map=area", "--light-map changes nothing", "a light that is"},
        {"--time-samples 2", "--time-samples changes nothing", "a moving object"},
        {"--max-depth 3", "--max-depth changes nothing", "--reflections and a specular surface"},
        {"--recursion=3", "--recursion changes nothing", "--reflections and a specular surface"},
        {"--error 0.5 --samples 2", "--samples changes nothing", "a picture without --error"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char words[128];
        snprintf(words, sizeof words, "--scene cube --width 4 --height 4 %s", cases[i][0]);
        run r = run_driver(*state, words);
        rk_check_equal(r.status, 0, "it is drawn nevertheless");
        check_contains(r.err, cases[i][1]);
        check_contains(r.err, cases[i][2]);
        rk_check_equal(strcspn(r.err, "\n") + 1, strlen(r.err), "one note for a feature");
        run_free(&r);
    }
}

static void an_option_with_effect_is_not_noted(void **state)
{
    const char *const cases[] = {"--reflections --glossy 2 --glossy-radius 0.2",
                                 "--bloom --bloom-radius 3",
                                 "--move --time-samples 2 --single-time 1",
                                 "--lens-samples 2 --aperture 20", "--shading phong"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char words[128];
        snprintf(words, sizeof words, "--width 4 --height 4 %s", cases[i]);
        run r = run_well(*state, words);
        run_free(&r);
    }
    run quiet = run_well(*state, "--scene cube --width 4 --height 4 --quiet --glossy-radius 0.2");
    run off = run_feature("06_bloom/bloom", *state,
                          "--scene cube --width 4 --height 4 --bloom-intensity 0");
    rk_check(off.status == 0 && !*off.err, "it turned the bloom off: %s", off.err);
    run_free(&quiet);
    run_free(&off);
}

static void an_error_that_is_not_reached_or_not_seen_is_told(void **state)
{
    const char *const feature = "14_adaptive_sampling/adaptive_sampling";
    run few = run_feature(feature, *state, "--width 48 --height 48 --error 0.001 --max-samples 16");
    check_contains(few.out, " in place of 0.1 % (--max-samples 16 allows no more)");
    run reached = run_feature(feature, *state, "--width 48 --height 48 --error 0.05");
    check_contains(reached.out, "estimated error ");
    rk_check(!strstr(reached.out, "in place of"), "it is reached: %s", reached.out);
    run missed = run_feature(feature, *state,
                             "--scene teapot --width 8 --height 8 --distance 1e6 --error 0.01");
    check_contains(missed.out, "alike in every pixel: no error can be estimated");
    run_free(&few);
    run_free(&reached);
    run_free(&missed);
}

static void levels_and_leaves_that_do_not_exist_are_named(void **state)
{
    check_complaint(*state, "--width 8 --height 8 --debug level --level 4", "--level 4", "0 to 3");
    check_complaint(*state, "--width 8 --height 8 --debug leaf --leaf 8", "--leaf 8", "0 to 7");
    check_complaint(*state, "--debug level --level 64", "--level 64", "0 to 63");
}

static void a_missing_mesh_is_named(void **state)
{
    check_complaint(*state, "--mesh nowhere/dragon.ply", "nowhere/dragon.ply", "");
}

static void an_impossible_out_folder_is_named_before_rendering(void **state)
{
    const test_folder *folder = *state;
    test_folder_write(folder, "file", "x", 1, 0600);
    double start = children_seconds();
    check_complaint(folder, "--width 3000 --height 3000 --samples 50 --out file", "file/figures",
                    "--out");
    check_complaint(folder, "--width 3000 --height 3000 --samples 50 --out file/below",
                    "file/below", "--out");
    check_complaint(folder, "--width 3000 --height 3000 --samples 50 --timing --out file",
                    "file/tables", "--out");
    rk_check(children_seconds() - start < 10,
             "a picture that takes a minute was rendered, and then could not be saved");
}

static void a_picture_that_cannot_be_written_leaves_nothing(void **state)
{
    const test_folder *folder = *state;
    const char *const path[] = {"out", "out/figures", "out/figures/bvh_median_cube.png"};
    for (int i = 0; i < 3; i++)
        mkdir(test_folder_path(folder, path[i]).text, 0700);
    check_complaint(folder, "--scene cube --width 8 --height 8", "bvh_median_cube.png", "");
}

/* --- Pictures -------------------------------------------------------------------------------- */

static void check_metadata(test_path picture, const char *key, const char *want)
{
    rk_error error;
    char *value = rk_png_read_text(picture.text, key, &error);
    rk_check(value != NULL, "%s: no text \"%s\": %s", picture.text, key, error.text);
    rk_check(strcmp(value, want) == 0, "%s: got \"%s\", want \"%s\"", key, value, want);
    free(value);
}

static void the_middle_of_a_scale_by_logarithms_is_a_round_number(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    run r = run_feature("14_adaptive_sampling/adaptive_sampling", folder,
                        "--scene cornell-light --width 24 --height 24 --error 0.02 --show samples");
    rk_check(r.status == 0, "the driver failed: %s", r.err);
    run_free(&r);
    char *value = rk_png_read_text(
        test_folder_path(folder, "out/figures/adaptive_sampling_cornell-light_samples_0.02.png")
            .text,
        "raykit:scale", &error);
    rk_check(value != NULL, "no scale: %s", error.text);
    float least = 0, middle = 0, place = 0, most = 0;
    const int read = sscanf(value, "%f@0 %f@%f %f", &least, &middle, &place, &most);
    rk_check(read == 4 && least < middle && middle < most, "\"%s\" has no three ticks", value);
    rk_check(exp2f(rintf(log2f(middle))) == middle, "%g is no power of two", middle);
    const float want = logf(middle / least) / logf(most / least);
    rk_check(fabsf(place - want) < 0.01f, "the tick is at %g, not at %g", place, want);
    free(value);
}

static void a_picture_lands_in_figures_with_its_parameters(void **state)
{
    const test_folder *folder = *state;
    run r = run_well(folder, "--scene sphere:99 --width 12 --height 9 --samples 3 --out my/folder");
    test_path picture = test_folder_path(folder, "my/folder/figures/bvh_median_sphere-99.png");
    rk_image image;
    rk_error error;
    rk_check_ok(rk_png_read(&image, picture.text, &error), error);
    rk_check_equal(image.width, 12, "the size of the options");
    rk_check_equal(image.height, 9, "the size of the options");
    rk_image_free(&image);
    rk_check_equal(count_files(folder), 1, "the picture and no other file");
    check_metadata(picture, "raykit:scene", "sphere:99");
    check_metadata(picture, "raykit:samples", "3");
    check_metadata(picture, "raykit:command",
                   "bvh_median --scene sphere:99 --width 12 --height 9 --samples 3 --out DIR");
    char *software = rk_png_read_text(picture.text, "Software", &error);
    char *seconds = rk_png_read_text(picture.text, "raykit:seconds", &error);
    char *triangles = rk_png_read_text(picture.text, "raykit:triangles", &error);
    rk_check(software && strncmp(software, "raykit ", 7) == 0, "the version is noted");
    rk_check(seconds && atof(seconds) > 0 && atof(seconds) < 60, "the time is noted");
    rk_check(triangles && atoi(triangles) >= 99, "the size of the mesh is noted");
    free(software);
    free(seconds);
    free(triangles);
    check_contains(r.out, "my/folder/figures/bvh_median_sphere-99.png: sphere:99");
    check_contains(r.out, "3 samples per pixel");
    run_free(&r);
}

static void captions_do_not_contain_the_machines_folders(void **state)
{
    const test_folder *folder = *state;
    run r = run_well(folder, "--scene=cube --width=4 --height=4 --out=secret/place");
    test_path picture = test_folder_path(folder, "secret/place/figures/bvh_median_cube.png");
    check_metadata(picture, "raykit:command",
                   "bvh_median --scene=cube --width=4 --height=4 --out=DIR");
    run_free(&r);
}

static void captions_name_the_present_spelling(void **state)
{
    const test_folder *folder = *state;
    run r = run_well(folder,
                     "--scene cube --width 4 --height 4 --recursion 3 --light-map=area --quiet");
    test_path picture = test_folder_path(folder, "out/figures/bvh_median_cube.png");
    check_metadata(picture, "raykit:command",
                   "bvh_median --scene cube --width 4 --height 4 --max-depth 3 "
                   "--light-domain=area --quiet");
    run_free(&r);
}

static void debug_views_have_pictures_of_their_own(void **state)
{
    const test_folder *folder = *state;
    run plain = run_well(folder, "--scene cornell --width 40 --height 40");
    run level = run_well(folder, "--width 40 --height 40 --debug level --level 2");
    run leaf = run_well(folder, "--width 40 --height 40 --debug leaf --leaf 5");
    const char *const names[] = {"out/figures/bvh_median_cornell.png",
                                 "out/figures/bvh_median_cornell_level2.png",
                                 "out/figures/bvh_median_cornell_leaf5.png"};
    rk_image image[3];
    rk_error error;
    for (int i = 0; i < 3; i++)
        rk_check_ok(rk_png_read(&image[i], test_folder_path(folder, names[i]).text, &error), error);
    for (int i = 1; i < 3; i++)
        rk_check(memcmp(image[0].pixels, image[i].pixels, 1600 * sizeof(rk_vec3)) != 0,
                 "%s shows the scene and nothing else", names[i]);
    for (int i = 0; i < 3; i++)
        rk_image_free(&image[i]);
    run_free(&plain);
    run_free(&level);
    run_free(&leaf);
}

/* Colour 0 has no blue, colour 1 much; 0.6 of either replaces the surface's own. */
static void a_level_s_triangles_have_the_colours_of_their_boxes(void **state)
{
    const test_folder *folder = *state;
    const char *const views[] = {"", "--debug level --level 0", "--debug level --level 1"};
    const char *const suffixes[] = {"", "_level0", "_level1"};
    rk_image image[3];
    rk_error error;
    for (int i = 0; i < 3; i++) {
        char words[128], name[128];
        snprintf(words, sizeof words, "--scene statue:500 --width 40 --height 40 %s", views[i]);
        snprintf(name, sizeof name, "out/figures/bvh_median_statue-500%s.png", suffixes[i]);
        run r = run_well(folder, words);
        rk_check_ok(rk_png_read(&image[i], test_folder_path(folder, name).text, &error), error);
        run_free(&r);
    }
    int less = 0, more = 0;
    for (size_t i = 0; i < 1600; i++) {
        const float blue = image[0].pixels[i].z;
        if (blue < 0.05f) /* beside the statue, where only edges are drawn, or too dark to tell */
            continue;
        rk_check(image[1].pixels[i].z < 0.4f * blue + 0.01f, "pixel %zu: one box, one colour", i);
        less += image[2].pixels[i].z < 0.4f * blue + 0.01f;
        more += image[2].pixels[i].z > 0.4f * blue + 0.2f;
    }
    rk_check(less > 20 && more > 20, "two boxes, two colours: of %d and %d pixels", less, more);
    for (int i = 0; i < 3; i++)
        rk_image_free(&image[i]);
}

static void the_splits_of_a_node_are_drawn_and_printed(void **state)
{
    const test_folder *folder = *state;
    const char *const views[] = {"split", "bad-split --candidate 2", "candidates"};
    const char *const printed[] = {", the cheapest\n", "candidate 2: axis x, boundary 3: ",
                                   "candidate 0: axis x, boundary 1: "};
    const char *const pictures[] = {"out/figures/sah_binning_statue-500_split1.png",
                                    "out/figures/sah_binning_statue-500_bad-split1_2.png",
                                    "out/figures/sah_binning_statue-500_candidates1.png"};
    for (int i = 0; i < 3; i++) {
        char words[128];
        snprintf(words, sizeof words,
                 "--scene statue:500 --width 40 --height 40 --bins 6 --node 1 --debug %s",
                 views[i]);
        run r = run_program(sah_program, folder, words);
        rk_check(r.status == 0, "%s: exit status %d: %s", words, r.status, r.err);
        check_contains(r.out, printed[i]);
        rk_check(is_there(folder, pictures[i]), "%s is missing", pictures[i]);
        run_free(&r);
    }
    rk_check(is_there(folder, "out/tables/sah_binning_candidates.csv"), "all costs, as a table");
    run far = run_program(sah_program, folder, "--debug split --node 999999");
    rk_check_equal(far.status, 1, "there is no such node");
    check_contains(far.err, "--node 999999: this tree's nodes are 0 to ");
    run_free(&far);
}

/* The tables that live figures draw. */
static void numbers_of_live_figures_are_put_into_tables(void **state)
{
    static const struct {
        const char *program, *words, *table, *header;
    } cases[] = {
        {"02_sah_binning/sah_binning", "--scene statue:20 --bins 6 --splits", "sah_binning_splits",
         "scene,node,candidate,axis,plane,left,right,cost,left_area,right_area,cheapest\n"},
        {"03_shading/shading", "--shading phong --radiance", "shading_radiance",
         "scene,incidence,angle,radiance,diffuse,highlight\n"},
        {"04_parallelogram_light/parallelogram_light",
         "--growth --most 2 --reference 4 --lamp-x 0.1 --lamp-z -0.1 --lamp-size 2",
         "parallelogram_light_growth", "scene,samples,rmse,shadow_rays\n"},
        {"06_bloom/bloom", "--histogram", "bloom_bright", "scene,threshold,bright,pixels,most\n"},
        {"06_bloom/bloom", "--halo", "bloom_halo", "scene,radius,pixels,most,sum\n"},
        {"13_sampling/sampling", "--pairs", "sampling_pairs",
         "scene,x,y,points,uniform,stratified,low_discrepancy,sobol,zsobol\n"},
        {"09_depth_of_field/depth_of_field", "--scene statue:20 --circles",
         "depth_of_field_circles", "scene,distance,diameter\n"},
        {"10_motion_blur/motion_blur", "--positions", "motion_blur_path",
         "scene,object,time,x,y\n"},
    };
    const test_folder *folder = *state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char words[256], table[128];
        snprintf(words, sizeof words, "%s --width 20 --height 20", cases[i].words);
        snprintf(table, sizeof table, "out/tables/%s.csv", cases[i].table);
        run r = run_feature(cases[i].program, folder, words);
        rk_check(r.status == 0, "%s: exit status %d: %s", words, r.status, r.err);
        rk_check(is_there(folder, table), "%s is missing", table);
        char *text = read_text(test_folder_path(folder, table));
        rk_check(strncmp(text, cases[i].header, strlen(cases[i].header)) == 0,
                 "%s: %s has the columns %s", words, table, text);
        free(text);
        run_free(&r);
    }
}

static void a_traversal_takes_the_unit_s_steps(void **state)
{
    const test_folder *folder = *state;
    for (int pixel = 5; pixel < 40; pixel += 10) {
        char words[160];
        snprintf(words, sizeof words,
                 "--scene statue:500 --debug traversal --steps 3 --width 40 --height 40 --pixel "
                 "%d,20",
                 pixel);
        run r = run_feature("01_bvh_median/bvh_median", folder, words);
        rk_check(r.status == 0, "%s: exit status %d: %s", words, r.status, r.err);
        check_contains(r.out, "step 1: box of node 0, ");
        check_contains(r.out, "rk_bvh_closest tests ");
        rk_check(!strstr(r.out, "not those above"), "%s: %s", words, r.out);
        run_free(&r);
    }
    rk_check(is_there(folder, "out/figures/bvh_median_statue-500_traversal3.png"), "a picture");
    check_feature_complaint("01_bvh_median/bvh_median", folder,
                            "--debug traversal --split collapsed", "--debug traversal",
                            "--split median");
}

static void wide_trees_are_drawn_and_printed(void **state)
{
    const test_folder *folder = *state;
    const char *const views[][3] = {
        {"node --node 1", "node1_collapsed50", "child 7: "},
        {"level --level 2 --split wide", "level2_wide", "built in"},
        {"blocks", "blocks_collapsed50", "built in"},
        {"visits", "visits_collapsed50", "visits to nodes per camera ray: "},
        {"visits --split sah3", "visits_sah50_3", "visits to nodes per camera ray: "},
    };
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        char words[128], name[128];
        snprintf(words, sizeof words, "--scene statue:500 --width 40 --height 40 --debug %s",
                 views[i][0]);
        snprintf(name, sizeof name, "out/figures/wide_bvh_statue-500_%s.png", views[i][1]);
        run r = run_feature(wide_program, folder, words);
        rk_check(r.status == 0 && !*r.err, "%s: exit status %d: %s", words, r.status, r.err);
        check_contains(r.out, views[i][2]);
        rk_check(is_there(folder, name), "%s is missing", name);
        run_free(&r);
    }
}

/* The sum of the last column in rows with this text. */
static double sum_of_rows(const char *table, const char *text)
{
    double sum = 0;
    for (const char *at = strstr(table, text); at; at = strstr(at + 1, text)) {
        const char *end = strchr(at, '\n');
        while (end[-1] != ',')
            end--;
        sum += atof(end);
    }
    return sum;
}

static void wide_trees_are_counted_and_timed(void **state)
{
    const test_folder *folder = *state;
    run full = run_feature(wide_program, folder, "--scene statue:500 --occupancy --quiet");
    run steps = run_feature(wide_program, folder,
                            "--scene statue:500 --steps --quiet --width 20 --height 20");
    rk_check(full.status == 0 && !*full.err && !*full.out, "--occupancy: %s%s", full.err, full.out);
    rk_check(steps.status == 0 && !*steps.err && !*steps.out, "--steps: %s%s", steps.err,
             steps.out);
    size_t size;
    char *shares = (char *)test_folder_read(
        test_folder_path(folder, "out/tables/wide_bvh_occupancy.csv"), &size);
    shares[size] = '\0';
    rk_check_near(sum_of_rows(shares, ",nodes,"), 100, 0.04,
                  "per cent of the nodes, eight numbers of four digits");
    rk_check_near(sum_of_rows(shares, ",blocks,"), 100, 0.02,
                  "per cent of the blocks, four numbers of four digits");
    char *times =
        (char *)test_folder_read(test_folder_path(folder, "out/tables/wide_bvh_steps.csv"), &size);
    times[size] = '\0';
    check_contains(times, ",1,1,1,"); /* the first step's gains over itself */
    check_contains(times, "statue:500,eight children,");
    check_contains(times, "statue:500,4 x 4 pixels: scalar,");
    free(shares);
    free(times);
    run_free(&full);
    run_free(&steps);
}

static void quiet_says_nothing(void **state)
{
    run r = run_well(*state, "--scene cube --width 4 --height 4 --quiet");
    rk_check(r.out[0] == '\0', "with --quiet it printed: %s", r.out);
    run timing = run_well(*state, "--scene cube --width 4 --height 4 --quiet --timing");
    rk_check(timing.out[0] == '\0', "with --quiet it printed: %s", timing.out);
    run split = run_feature("02_sah_binning/sah_binning", *state,
                            "--scene cube --width 4 --height 4 --quiet --debug split");
    rk_check_equal(split.status, 0, "a debug view, quietly");
    rk_check(split.out[0] == '\0', "with --quiet it printed: %s", split.out);
    run_free(&r);
    run_free(&timing);
    run_free(&split);
}

static void a_pixel_is_explained(void **state)
{
    run r = run_well(*state, "--width 20 --height 20 --pixel 10,10");
    check_contains(r.out, "pixel (10, 10) of cornell");
    check_contains(r.out, "colour (linear)");
    run_free(&r);
}

static void debug_rays_draws_the_pixel_and_names_the_picture_by_it(void **state)
{
    const struct {
        const char *name, *options;
        const char *own, *given; /* ends of names: without --pixel, and with it */
        const char *pixel;
    } drivers[] = {
        {"04_parallelogram_light/parallelogram_light", "", "_17_17.png", "_10_12.png", "10,12"},
        {"05_transparency/transparency", "--transparency", "_13_11.png", "_10_12.png", "10,12"},
        {"07_glossy_reflection/glossy_reflection", "", "_7_11.png", "_7_10.png", "7,10"},
        {"09_depth_of_field/depth_of_field", "--scene cube", "_10_10.png", "_10_12.png", "10,12"},
    };
    for (size_t i = 0; i < sizeof drivers / sizeof *drivers; i++) {
        char arguments[128];
        snprintf(arguments, sizeof arguments, "--debug rays --width 20 --height 20 %s",
                 drivers[i].options);
        run own = run_feature(drivers[i].name, *state, arguments);
        rk_check_equal(own.status, 0, own.err);
        check_contains(own.out, drivers[i].own);
        strcat(arguments, " --pixel ");
        strcat(arguments, drivers[i].pixel);
        run given = run_feature(drivers[i].name, *state, arguments);
        rk_check_equal(given.status, 0, given.err);
        check_contains(given.out, drivers[i].given);
        rk_check(!strstr(given.out, "pixel ("), "it is drawn, not explained:\n%s", given.out);
        run_free(&own);
        run_free(&given);
    }
}

static void check_shadow_rays(void **state, const char *options)
{
    char arguments[256];
    unsigned drawn[2] = {0, 0}, explained[2] = {1, 1};
    snprintf(arguments, sizeof arguments, "--width 40 --height 40 --pixel 34,35 %s", options);
    run text = run_feature("04_parallelogram_light/parallelogram_light", *state, arguments);
    rk_check_equal(text.status, 0, text.err);
    const char *line = strstr(text.out, " shadow rays, ");
    while (line && line > text.out && line[-1] >= '0' && line[-1] <= '9')
        line--;
    rk_check(line && sscanf(line, "%u shadow rays, %u", &explained[0], &explained[1]) == 2,
             "no shadow rays in:\n%s", text.out);
    strcat(arguments, " --debug rays");
    run view = run_feature("04_parallelogram_light/parallelogram_light", *state, arguments);
    rk_check_equal(view.status, 0, view.err);
    /* The first line is the picture's: tools read it there. */
    const char *second = strchr(view.out, '\n');
    rk_check(second && strstr(view.out, ".png: ") && strstr(view.out, ".png: ") < second &&
                 sscanf(second, " pixel 34,35: %u shadow rays, %u", &drawn[0], &drawn[1]) == 2,
             "no shadow rays below the picture's line in:\n%s", view.out);
    rk_check(drawn[0] == explained[0] && drawn[1] == explained[1],
             "%s: the view draws %u rays, %u unoccluded; the explanation has %u and %u", options,
             drawn[0], drawn[1], explained[0], explained[1]);
    run_free(&text);
    run_free(&view);
}

/* The explanation runs the light's stage for this pixel, the view records it in its tile. */
static void debug_rays_draws_as_many_shadow_rays_as_the_pixel_is_explained_with(void **state)
{
    check_shadow_rays(state, "--light-samples 64");
    check_shadow_rays(state, "--light-samples 64 --early-out 8");
    check_shadow_rays(state, "--light-samples 64 --seed 7 --light-sampling uniform");
}

static unsigned occurrences(const char *text, const char *word)
{
    unsigned count = 0;
    for (const char *at = text; (at = strstr(at, word)) != NULL; at += strlen(word))
        count++;
    return count;
}

static void debug_rays_draws_the_crossings_that_the_pixel_is_explained_with(void **state)
{
    const char *const pixels[] = {"13,11", "10,12", "8,14"};
    for (size_t i = 0; i < sizeof pixels / sizeof *pixels; i++) {
        char arguments[256];
        snprintf(arguments, sizeof arguments,
                 "--transparency --shadows --width 20 --height 20 --pixel %s", pixels[i]);
        run text = run_feature("05_transparency/transparency", *state, arguments);
        strcat(arguments, " --debug rays");
        run view = run_feature("05_transparency/transparency", *state, arguments);
        rk_check_equal(view.status, 0, view.err);
        char want[128];
        snprintf(want, sizeof want, "pixel %s: %u crossings, %u shadow rays, %u unoccluded",
                 pixels[i], occurrences(text.out, "    hit "),
                 occurrences(text.out, "shadow ray origin"),
                 occurrences(text.out, "unoccluded\n") + occurrences(text.out, "attenuated by"));
        check_contains(view.out, want);
        rk_check(!strstr(want, " 0 crossings"), "pixel %s sees no surface", pixels[i]);
        run_free(&text);
        run_free(&view);
    }
}

static void debug_rays_says_why_there_are_none(void **state)
{
    const char *options = "--width 40 --height 40 --debug rays --pixel 4,38";
    char all[128];
    snprintf(all, sizeof all, "%s --light-visibility rays", options);
    run none = run_feature("04_parallelogram_light/parallelogram_light", *state, options);
    run some = run_feature("04_parallelogram_light/parallelogram_light", *state, all);
    rk_check_equal(none.status, 0, none.err);
    rk_check_equal(some.status, 0, some.err);
    check_contains(none.out, "pixel 4,38: no shadow rays: ");
    check_contains(some.out, "pixel 4,38: 16 shadow rays, 16 unoccluded");
    run_free(&none);
    run_free(&some);
}

/* A lens so small that everything is in focus. */
static void debug_rays_of_a_pixel_in_focus_draws_those_that_it_would_take(void **state)
{
    run r = run_feature("09_depth_of_field/depth_of_field", *state,
                        "--scene cube --width 20 --height 20 --debug rays --aperture 0.001");
    rk_check_equal(r.status, 0, r.err);
    check_contains(r.out, "pixel 10,10: 1 camera ray: it is in focus, and takes none of the lens "
                          "samples drawn");
    run_free(&r);
}

/* The green of a pixel of the floor, which a coloured light's ends light differently. */
static double explained_green(void **state, const char *options)
{
    char arguments[256];
    snprintf(arguments, sizeof arguments,
             "--width 40 --height 40 --pixel 20,38 --light-samples 1024 %s", options);
    run r = run_feature("04_parallelogram_light/parallelogram_light", *state, arguments);
    rk_check_equal(r.status, 0, r.err);
    check_contains(r.out, "colour (linear)");
    double green = 0;
    const int found =
        sscanf(strstr(r.out, "colour (linear)"), "colour (linear) ( %*f, %lf", &green);
    rk_check(found == 1 && green > 0, "no green in:\n%s", r.out);
    run_free(&r);
    return green;
}

/* Samples differ; a share too many or too few is a factor of 4. */
static void strips_give_the_light_of_the_whole(void **state)
{
    static const char *const options[] = {"", "--coloured", "--falloff physical",
                                          "--falloff physical --light segment", "--light point"};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        char cut[128];
        snprintf(cut, sizeof cut, "%s --lights 4", options[i]);
        const double want = explained_green(state, options[i]), got = explained_green(state, cut);
        rk_check(fabs(got / want - 1) < 0.02, "%s: %g, want %g", cut, got, want);
    }
    run r = run_feature("04_parallelogram_light/parallelogram_light", *state,
                        "--lights 4 --scene cornell");
    rk_check_equal(r.status, 1, "a point cannot be cut");
    check_contains(r.err, "such as cornell-light");
    run_free(&r);
}

static void pictures_of_a_map_are_named_by_the_map(void **state)
{
    const char *const views[][2] = {{"--debug cross", "cubemap_sky_cross_seamless.png: sky"},
                                    {"--debug cross --marked", "cubemap_marked_cross_"},
                                    {"--debug seam", "cubemap_random-colours_seam_"}};
    for (int i = 0; i < 3; i++) {
        char arguments[128];
        snprintf(arguments, sizeof arguments, "--scene cube --width 20 --height 20 %s",
                 views[i][0]);
        run r = run_feature("08_cubemap/cubemap", *state, arguments);
        rk_check_equal(r.status, 0, r.err);
        check_contains(r.out, views[i][1]);
        run_free(&r);
    }
}

/* --- Timings --------------------------------------------------------------------------------- */

static int count_lines(const char *text)
{
    int lines = 0;
    for (; *text; text++)
        lines += *text == '\n';
    return lines;
}

static char *read_table(const test_folder *folder)
{
    size_t size;
    char *text =
        (char *)test_folder_read(test_folder_path(folder, "out/tables/bvh_median.csv"), &size);
    text[size] = '\0';
    return text;
}

static void timings_become_rows_and_the_next_run_replaces_them(void **state)
{
    const test_folder *folder = *state;
    run first = run_well(folder, "--scene cube --width 8 --height 8 --threads 2 --timing");
    rk_check(!is_there(folder, "out/figures"), "--timing draws no picture");
    char *table = read_table(folder);
    check_contains(table,
                   "feature,scene,triangles,method,isa,threads,metric,unit,median,min,max,runs\n");
    check_contains(table, "\nbvh_median,cube,12,median,scalar,2,build,ms,");
    check_contains(table, "\nbvh_median,cube,12,median,scalar,2,render,ms,");
    check_contains(table, "\nbvh_median,cube,12,median,scalar,2,levels,1,3,3,3,1\n");
    check_contains(table, "\nbvh_median,cube,12,median,scalar,2,leaves,1,4,4,4,1\n");
    rk_check(!strstr(table, "nan"), "a table of numbers:\n%s", table);
    int lines = count_lines(table);
    rk_check_equal(lines, 8, "the header and seven figures");
    free(table);
    run second =
        run_well(folder, "--scene cube --width 8 --height 8 --threads 2 --timing --runs 3");
    table = read_table(folder);
    rk_check_equal(count_lines(table), lines, "the same figures replace the older ones");
    check_contains(table, ",3\n");
    free(table);
    run third = run_well(folder, "--scene triangle --width 8 --height 8 --threads 2 --timing");
    table = read_table(folder);
    rk_check_equal(count_lines(table), 2 * lines - 1, "another scene has rows of its own");
    free(table);
    rk_check_equal(count_files(folder), 1, "one table and no other file");
    run_free(&first);
    run_free(&second);
    run_free(&third);
}

static void rows_name_how_the_tree_was_split(void **state)
{
    const test_folder *folder = *state;
    const char *const splits[] = {"median", "sah --bins 16", "sah3"};
    for (int i = 0; i < 3; i++) {
        char words[128];
        snprintf(words, sizeof words,
                 "--scene cube --width 8 --height 8 --threads 1 --timing --split %s", splits[i]);
        run r = run_well(folder, words);
        run_free(&r);
    }
    char *table = read_table(folder);
    check_contains(table, "\nbvh_median,cube,12,median,scalar,1,leaves,1,4,4,4,1\n");
    check_contains(table, "\nbvh_median,cube,12,sah16,scalar,1,leaves,1,1,1,1,1\n");
    check_contains(table, "\nbvh_median,cube,12,sah50_3,scalar,1,leaves,1,1,1,1,1\n");
    free(table);
}

static void a_foreign_table_is_left_alone(void **state)
{
    const test_folder *folder = *state;
    mkdir(test_folder_path(folder, "out").text, 0700);
    mkdir(test_folder_path(folder, "out/tables").text, 0700);
    test_folder_write(folder, "out/tables/bvh_median.csv", "a,b\n1,2\n", 8, 0600);
    check_complaint(folder, "--scene cube --width 8 --height 8 --timing", "bvh_median.csv",
                    "rename or remove");
    char *table = read_table(folder);
    rk_check(strcmp(table, "a,b\n1,2\n") == 0, "it became:\n%s", table);
    free(table);
}

/* --- Mesh files ------------------------------------------------------------------------------ */

/* A box whose sides towards +z, -z and -y are red, green and blue, all others grey; and, if asked
 * for, a triangle far from it. */
static void write_box(const test_folder *folder, bool has_strays)
{
    static const char colours[] = "newmtl grey\nKd .5 .5 .5\nnewmtl red\nKd 1 0 0\n"
                                  "newmtl green\nKd 0 1 0\nnewmtl blue\nKd 0 0 1\n";
    char mesh[4096] = "mtllib box.mtl\n"
                      "v 1 1 1\nv 3 1 1\nv 3 3 1\nv 1 3 1\nv 1 1 3\nv 3 1 3\nv 3 3 3\nv 1 3 3\n"
                      "usemtl red\nf 5 6 7 8\nusemtl green\nf 1 4 3 2\nusemtl blue\nf 1 2 6 5\n"
                      "usemtl grey\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";
    if (has_strays)
        strcat(mesh, "v 900 0 0\nv 901 0 0\nv 900 1 0\nf 9 10 11\n");
    test_folder_write(folder, "box.mtl", colours, strlen(colours), 0600);
    test_folder_write(folder, "box.obj", mesh, strlen(mesh), 0600);
}

/* The picture of the box by these options; freed by the caller. */
static rk_image box_picture(const test_folder *folder, const char *options)
{
    char arguments[200];
    rk_image image;
    rk_error error;
    snprintf(arguments, sizeof arguments, "--mesh box.obj --width 24 --height 24 --shadows %s",
             options);
    run r = run_well(folder, arguments);
    run_free(&r);
    test_path picture = test_folder_path(folder, "out/figures/bvh_median_box.obj.png");
    rk_check_ok(rk_png_read(&image, picture.text, &error), error);
    return image;
}

static void check_middle(const test_folder *folder, const char *options, rk_vec3 colour)
{
    rk_image image = box_picture(folder, options);
    rk_vec3 middle = image.pixels[12 * 24 + 12];
    rk_check(rk_dot(middle, colour) > 0.5f &&
                 rk_dot(middle, colour) == middle.x + middle.y + middle.z,
             "%s: the middle is (%g, %g, %g)", options, (double)middle.x, (double)middle.y,
             (double)middle.z);
    rk_image_free(&image);
}

static void a_mesh_file_is_seen_from_its_front(void **state)
{
    const rk_vec3 red = {1, 0, 0}, green = {0, 1, 0}, blue = {0, 0, 1};
    write_box(*state, false);
    check_middle(*state, "--pitch 0 --yaw 0", red);
    check_middle(*state, "--pitch 0 --yaw 180", green);
    check_middle(*state, "--pitch 0 --yaw 0 --up z", blue);
}

static void walking_round_a_mesh_file_never_ends_in_the_dark(void **state)
{
    write_box(*state, false);
    for (int yaw = -180; yaw < 180; yaw += 30) {
        char options[40];
        snprintf(options, sizeof options, "--yaw %d --pitch %d", yaw, yaw / 2);
        rk_image image = box_picture(*state, options);
        int lit = 0;
        for (int i = 0; i < 24 * 24; i++)
            lit += image.pixels[i].x + image.pixels[i].y + image.pixels[i].z > 0.1f;
        /* A square of two thirds has 256 pixels; a box that stands on a corner fills half of its
         * bounds. */
        rk_check(lit > 100, "%s: %d of 576 pixels are lit", options, lit);
        rk_image_free(&image);
    }
}

/* Red in its middle half, blue around its seam. */
static void write_panorama(const test_folder *folder)
{
    rk_image world;
    rk_error error;
    rk_check_ok(rk_image_init(&world, 64, 32, &error), error);
    for (size_t i = 0; i < 64 * 32; i++)
        world.pixels[i] = i % 64 / 16 % 3 ? rk_vec(1, 0, 0) : rk_vec(0, 0, 1);
    rk_check_ok(rk_png_write(test_folder_path(folder, "world.png").text, &world, NULL, 0, &error),
                error);
    rk_image_free(&world);
}

static void the_seam_of_a_panorama_is_behind_the_camera_of_open_scenes(void **state)
{
    write_panorama(*state);
    const char *const open[] = {"teapot", "statue", "glass", "shininess", "cover", "moving"};
    for (size_t at = 0; at < sizeof open / sizeof *open; at++) {
        const char *name = open[at];
        char options[120], file[120];
        rk_image image;
        rk_error error;
        snprintf(options, sizeof options,
                 "--scene %s --width 24 --height 24 --environment world.png", name);
        snprintf(file, sizeof file, "out/figures/bvh_median_%s.png", name);
        run r = run_well(*state, options);
        run_free(&r);
        rk_check_ok(rk_png_read(&image, test_folder_path(*state, file).text, &error), error);
        int blue = 0;
        for (int i = 0; i < 24 * 24; i++)
            blue += image.pixels[i].z > 0.9f && image.pixels[i].x < 0.1f;
        rk_check(blue == 0, "%s: %d pixels show the panorama's border", name, blue);
        rk_image_free(&image);
    }
}

static void strays_of_a_mesh_file_are_told(void **state)
{
    write_box(*state, true);
    run r = run_driver(*state, "--mesh box.obj --width 9 --height 9");
    check_contains(r.err,
                   "bvh_median: box.obj: 12 of its 13 triangles lie in 0.22 % of its extent; the "
                   "picture is framed by these, so that others may reach beyond its border");
    check_contains(r.out, "13 triangles (framed by 12 in 0.22 % of their extent), 9 x 9");
    run_free(&r);
}

static void transparent_materials_that_are_drawn_as_opaque_are_told(void **state)
{
    static const char mtl[] = "newmtl a\nKd 1 0 0\nd 0.5\n";
    static const char text[] = "mtllib half.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    test_folder_write(*state, "half.mtl", mtl, sizeof mtl - 1, 0600);
    test_folder_write(*state, "half.obj", text, sizeof text - 1, 0600);
    run r = run_driver(*state, "--mesh half.obj --width 9 --height 9");
    check_contains(r.err, "half.obj: 1 of 1 materials are transparent, and drawn as opaque without "
                          "--transparency");
    run_free(&r);
    r = run_driver(*state, "--mesh half.obj --width 9 --height 9 --transparency");
    rk_check(!strstr(r.err, "transparent"), "told though it is shown: %s", r.err);
    run_free(&r);
}

static void write_masked(const test_folder *folder, const char *opacity, const char *mask)
{
    static const char text[] =
        "mtllib masked.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl a\nf 1/1 2/2 3/3\n";
    char mtl[200];
    snprintf(mtl, sizeof mtl, "newmtl a\nKd 1 0 0\nd %s\nmap_d mask.pgm\n", opacity);
    test_folder_write(folder, "masked.mtl", mtl, strlen(mtl), 0600);
    test_folder_write(folder, "masked.obj", text, sizeof text - 1, 0600);
    test_folder_write(folder, "mask.pgm", mask, strlen(mask), 0600);
}

static void surfaces_that_a_picture_makes_transparent_are_told(void **state)
{
    static const struct {
        const char *opacity, *mask;
        bool is_told;
    } cases[] = {{"0.4", "P2\n2 1\n255\n255 0\n", true},
                 {"0.9", "P2\n2 1\n255\n255 0\n", true},
                 {"1", "P2\n4 1\n255\n255 160 100 160\n", true},
                 {"1", "P2\n12 1\n255\n255 255 255 255 255 128 0 0 0 0 0 0\n", false}};
    for (int i = 0; i < 4; i++) {
        write_masked(*state, cases[i].opacity, cases[i].mask);
        run r = run_driver(*state, "--mesh masked.obj --width 9 --height 9");
        rk_check(!!strstr(r.err, "1 of 1 materials are transparent, and drawn as opaque") ==
                     cases[i].is_told,
                 "case %d: %s", i, r.err);
        run_free(&r);
        r = run_driver(*state, "--mesh masked.obj --width 9 --height 9 --transparency");
        rk_check(!strstr(r.err, "transparent"), "told though it is shown: %s", r.err);
        run_free(&r);
    }
}

/* Quiet or not: the picture does not show the file as it is. */
static void quiet_still_tells_what_a_picture_lacks(void **state)
{
    write_box(*state, true);
    run r = run_driver(*state, "--mesh box.obj --width 9 --height 9 --quiet");
    check_contains(r.err, "12 of its 13 triangles");
    run_free(&r);
    const char text[] = "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    test_folder_write(*state, "grey.obj", text, sizeof text - 1, 0600);
    r = run_driver(*state, "--mesh grey.obj --width 9 --height 9 --quiet");
    check_contains(r.err, "gone.mtl is missing");
    run_free(&r);
}

/* --- Speed ----------------------------------------------------------------------------------- */

/* About 2 ms, the best of five. By turns with an empty shell, which takes about 1 ms: on a machine
 * that is busy or slow both take longer. */
static void starting_up_takes_milliseconds(void **state)
{
    double best = INFINITY, shell = INFINITY;
    for (int i = 0; i < 5; i++) {
        double start = children_seconds();
        rk_check_equal(system(":"), 0, "a shell that does nothing");
        double middle = children_seconds();
        run r = run_well(*state, "--width 1 --height 1 --threads 2");
        shell = fmin(shell, middle - start);
        best = fmin(best, children_seconds() - middle);
        run_free(&r);
    }
#if defined(RK_SANITIZED)
    const double allowed = 1; /* setting up the shadow alone takes many milliseconds */
#else
    const double allowed = fmax(0.010, 10 * shell);
#endif
    rk_check(
        best < allowed,
        "one pixel took %.1f ms of processor time, an empty shell %.1f ms: something is loaded "
        "or built that it does not need",
        1e3 * best, 1e3 * shell);
}

static const struct CMUnitTest tests[] = {
    test_in_folder(help_and_version_are_successes),
    test_in_folder(helper_programs_have_the_drivers_version),
    test_in_folder(help_speaks_to_a_newcomer),
    test_in_folder(every_help_is_wrapped_as_if_by_hand),
    test_in_folder(every_bad_option_is_named_in_one_line),
    test_in_folder(options_that_do_not_go_together_are_refused),
    test_in_folder(an_option_without_effect_is_noted),
    test_in_folder(an_option_with_effect_is_not_noted),
    test_in_folder(an_error_that_is_not_reached_or_not_seen_is_told),
    test_in_folder(levels_and_leaves_that_do_not_exist_are_named),
    test_in_folder(a_missing_mesh_is_named),
    test_in_folder(an_impossible_out_folder_is_named_before_rendering),
    test_in_folder(a_picture_that_cannot_be_written_leaves_nothing),
    test_in_folder(the_middle_of_a_scale_by_logarithms_is_a_round_number),
    test_in_folder(a_picture_lands_in_figures_with_its_parameters),
    test_in_folder(captions_do_not_contain_the_machines_folders),
    test_in_folder(captions_name_the_present_spelling),
    test_in_folder(debug_views_have_pictures_of_their_own),
    test_in_folder(a_level_s_triangles_have_the_colours_of_their_boxes),
    test_in_folder(the_splits_of_a_node_are_drawn_and_printed),
    test_in_folder(numbers_of_live_figures_are_put_into_tables),
    test_in_folder(a_traversal_takes_the_unit_s_steps),
    test_in_folder(wide_trees_are_drawn_and_printed),
    test_in_folder(wide_trees_are_counted_and_timed),
    test_in_folder(quiet_says_nothing),
    test_in_folder(a_pixel_is_explained),
    test_in_folder(debug_rays_draws_the_pixel_and_names_the_picture_by_it),
    test_in_folder(debug_rays_draws_as_many_shadow_rays_as_the_pixel_is_explained_with),
    test_in_folder(debug_rays_draws_the_crossings_that_the_pixel_is_explained_with),
    test_in_folder(debug_rays_says_why_there_are_none),
    test_in_folder(debug_rays_of_a_pixel_in_focus_draws_those_that_it_would_take),
    test_in_folder(strips_give_the_light_of_the_whole),
    test_in_folder(pictures_of_a_map_are_named_by_the_map),
    test_in_folder(timings_become_rows_and_the_next_run_replaces_them),
    test_in_folder(rows_name_how_the_tree_was_split),
    test_in_folder(a_foreign_table_is_left_alone),
    test_in_folder(a_mesh_file_is_seen_from_its_front),
    test_in_folder(walking_round_a_mesh_file_never_ends_in_the_dark),
    test_in_folder(the_seam_of_a_panorama_is_behind_the_camera_of_open_scenes),
    test_in_folder(strays_of_a_mesh_file_are_told),
    test_in_folder(transparent_materials_that_are_drawn_as_opaque_are_told),
    test_in_folder(surfaces_that_a_picture_makes_transparent_are_told),
    test_in_folder(quiet_still_tells_what_a_picture_lacks),
    test_in_folder(starting_up_takes_milliseconds),
};

RK_SUITE("driver", tests)
