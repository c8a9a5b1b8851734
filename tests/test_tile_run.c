/* A picture by several processes: the same to the bit, with the same counters, as by one. Here the
 * processes are threads, each with a pool, and exchange their tiles through memory; with real ones
 * see tests/test_mpi.py. */
#include "test_scene.h"

#include <pthread.h>
#include <stdatomic.h>

enum { most_processes = 5 };

/* What the processes share. */
typedef struct test_meeting {
    pthread_barrier_t barrier;
    uint32_t processes;
    atomic_uint next;
    const void *own[most_processes];
    uint32_t counts[most_processes];
} test_meeting;

typedef struct member {
    test_meeting *meeting;
    rk_team team;
    pthread_t thread;
    const rk_scene *scene;
    const rk_accel *accel;
    rk_render_options options;
    uint32_t threads;
    bool ok;
    rk_error error;
    rk_image image;
    rk_counters counters;
    rk_progress progress;
} member;

static uint32_t next_number(void *context, uint32_t at_once)
{
    (void)at_once;
    return atomic_fetch_add(&((const member *)context)->meeting->next, 1);
}

static bool exchange(void *context, const void *own, uint32_t count, size_t size, void **all,
                     uint32_t *total, rk_error *error)
{
    const member *m = context;
    test_meeting *meeting = m->meeting;
    (void)error;
    meeting->own[m->team.process] = own;
    meeting->counts[m->team.process] = count;
    pthread_barrier_wait(&meeting->barrier);
    *total = 0;
    for (uint32_t i = 0; i < meeting->processes; i++)
        *total += meeting->counts[i];
    char *to = *all = calloc(*total + 1, size);
    for (uint32_t i = 0; i < meeting->processes; to += meeting->counts[i++] * size)
        memcpy(to, meeting->own[i], meeting->counts[i] * size);
    meeting->next = 0;
    pthread_barrier_wait(&meeting->barrier);
    return true;
}

static void *take_part(void *context)
{
    member *m = context;
    rk_pool *pool = rk_pool_start(m->threads, &m->error);
    rk_pool_join(pool, &m->team);
    rk_progress_start(&m->progress, "rendering", rk_render_tiles(&m->options), true);
    m->ok = rk_render(&m->image, m->scene, m->accel, &m->options, pool, &m->counters, &m->progress,
                      &m->error);
    rk_pool_stop(pool);
    return NULL;
}

/* All processes have the same options and threads, but for what a test changes then. */
static void gather(member *members, test_meeting *meeting, uint32_t processes,
                   const rk_scene *scene, const rk_accel *accel, rk_render_options options,
                   uint32_t threads)
{
    rk_error error = {""};
    *meeting = (test_meeting){.processes = processes};
    pthread_barrier_init(&meeting->barrier, NULL, processes);
    for (uint32_t i = 0; i < processes; i++) {
        member *m = &members[i];
        *m = (member){.meeting = meeting,
                      .team = {.process = i,
                               .processes = processes,
                               .machine = "here",
                               .next = next_number,
                               .exchange = exchange},
                      .scene = scene,
                      .accel = accel,
                      .options = options,
                      .threads = threads};
        m->team.context = m;
        rk_check_ok(rk_image_init(&m->image, options.width, options.height, &error), error);
        memset(m->image.pixels, 0x55, options.width * options.height * sizeof(rk_vec3));
    }
}

static void render(member *members, test_meeting *meeting)
{
    for (uint32_t i = 1; i < meeting->processes; i++)
        pthread_create(&members[i].thread, NULL, take_part, &members[i]);
    take_part(&members[0]);
    for (uint32_t i = 1; i < meeting->processes; i++)
        pthread_join(members[i].thread, NULL);
}

static void part(member *members, test_meeting *meeting)
{
    for (uint32_t i = 0; i < meeting->processes; i++)
        rk_image_free(&members[i].image);
    pthread_barrier_destroy(&meeting->barrier);
}

static rk_accel tree_of(const rk_scene *scene)
{
    rk_accel accel;
    rk_error error = {""};
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, scene, &error), error);
    return accel;
}

static void check_same(const char *scene_name, rk_render_options options)
{
    static const uint32_t numbers[] = {1, 2, 3, most_processes};
    rk_scene scene = test_scene_builtin(scene_name);
    rk_accel accel = tree_of(&scene);
    test_picture want = test_render(&scene, options, 1);
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        for (uint32_t threads = 1; threads <= 2; threads++) {
            static member members[most_processes];
            test_meeting meeting;
            gather(members, &meeting, numbers[k], &scene, &accel, options, threads);
            render(members, &meeting);
            for (uint32_t i = 0; i < numbers[k]; i++) {
                const member *m = &members[i];
                rk_check_ok(m->ok, m->error);
                rk_check(test_same_pixels(&m->image, &want.image),
                         "%s, process %u of %u, %u threads: another picture", scene_name, i,
                         numbers[k], threads);
                rk_check(memcmp(&m->counters, &want.counters, sizeof want.counters) == 0,
                         "%s, process %u of %u, %u threads: other counters, such as %llu rays in "
                         "place of %llu",
                         scene_name, i, numbers[k], threads,
                         (unsigned long long)rk_counters_rays(&m->counters),
                         (unsigned long long)rk_counters_rays(&want.counters));
                rk_check_equal(m->progress.done, rk_render_tiles(&options),
                               "progress counts the tiles of all");
            }
            part(members, &meeting);
        }
    rk_image_free(&want.image);
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

/* Clipped tiles, and 4 x 3 of them. */
static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 53;
    options.height = 38;
    options.samples = 2;
    options.shadows = true;
    options.light.samples = 2;
    return options;
}

static void processes_make_the_picture_of_one(void **state)
{
    (void)state;
    check_same("cornell", small());
}

static void bloom_of_processes_is_that_of_one(void **state)
{
    (void)state;
    rk_render_options options = small();
    options.bloom.on = true;
    options.bloom.threshold = 0.2f;
    options.bloom.radius = 9;
    check_same("lanterns", options);
}

static void lens_and_motion_of_processes_are_those_of_one(void **state)
{
    (void)state;
    rk_render_options options = small();
    options.lens_samples = options.motion.samples = 4;
    options.lens.aperture = 60;
    check_same("moving", options);
}

static void more_processes_than_tiles_leave_some_without(void **state)
{
    (void)state;
    rk_render_options options = small();
    options.width = 20;
    options.height = 7;
    check_same("cornell", options);
}

static void an_error_of_one_process_is_everybodys(void **state)
{
    (void)state;
    static member members[3];
    test_meeting meeting;
    rk_scene scene = test_scene_builtin("cornell");
    rk_accel accel = tree_of(&scene);
    gather(members, &meeting, 3, &scene, &accel, small(), 1);
    members[1].options.samples = 0;
    render(members, &meeting);
    for (int i = 0; i < 3; i++) {
        rk_check(!members[i].ok, "process %d rendered without process 1", i);
        rk_check(strncmp(members[i].error.text, "process 1 on here: ", 19) == 0,
                 "process %d says: %s", i, members[i].error.text);
        rk_check(members[i].team.is_over, "process %d waits for others", i);
    }
    part(members, &meeting);
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static void rounds_of_processes_are_those_of_one(void **state)
{
    (void)state;
    rk_render_options options = small();
    options.adaptive_sampling.error = 0.05f;
    options.adaptive_sampling.max_samples = 64;
    rk_scene scene = test_scene_builtin("cornell");
    rk_accel accel = tree_of(&scene);
    test_picture want = test_render(&scene, options, 2);
    rk_check(want.counters.rounds > 1, "one round: make the error smaller");
    static member members[3];
    test_meeting meeting;
    gather(members, &meeting, 3, &scene, &accel, options, 1);
    render(members, &meeting);
    for (int i = 0; i < 3; i++) {
        rk_check_ok(members[i].ok, members[i].error);
        rk_check(test_same_pixels(&members[i].image, &want.image), "process %d: another picture",
                 i);
        rk_check(memcmp(&members[i].counters, &want.counters, sizeof want.counters) == 0,
                 "process %d: %llu rounds and %llu rays in place of %llu and %llu", i,
                 (unsigned long long)members[i].counters.rounds,
                 (unsigned long long)rk_counters_rays(&members[i].counters),
                 (unsigned long long)want.counters.rounds,
                 (unsigned long long)rk_counters_rays(&want.counters));
    }
    part(members, &meeting);
    rk_image_free(&want.image);
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(processes_make_the_picture_of_one),
    cmocka_unit_test(bloom_of_processes_is_that_of_one),
    cmocka_unit_test(lens_and_motion_of_processes_are_those_of_one),
    cmocka_unit_test(more_processes_than_tiles_leave_some_without),
    cmocka_unit_test(rounds_of_processes_are_those_of_one),
    cmocka_unit_test(an_error_of_one_process_is_everybodys),
};

RK_SUITE("tile_run", tests)
