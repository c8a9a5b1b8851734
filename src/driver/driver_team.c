/* Loads the module, and compares the processes of a team before they begin: by short hashes of all
 * that a picture follows from. */
#include "driver/driver_team.h"

#include "driver/likeness.h"
#include "io/helper.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- Joining ---------------------------------------------------------------------------------- */

static bool is_asked_for(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--mpi") == 0)
            return true;
    return false;
}

static const char module[] = "raykit-mpi.so";

static void *load_module(rk_error *error)
{
    const char *folders[] = {getenv("RAYKIT_HELPERS"), rk_helper_folder()};
    char path[4096];
    for (size_t i = 0; i < 2; i++) {
        snprintf(path, sizeof path, "%s/%s", folders[i] ? folders[i] : "", module);
        FILE *file = folders[i] ? fopen(path, "rb") : NULL;
        if (!file)
            continue;
        fclose(file);
        void *loaded = dlopen(path, RTLD_NOW | RTLD_GLOBAL);
        if (!loaded)
            rk_fail(error, "--mpi: %.900s", dlerror());
        return loaded;
    }
    rk_fail(error,
            "--mpi: this build has no MPI: install libopenmpi-dev and openmpi-bin (./bootstrap "
            "--mpi), then run ./configure and make again");
    return NULL;
}

/* As mpirun says it, for errors before MPI is there: they are the same in all processes. */
static uint32_t early_process(void)
{
    const char *number = getenv("OMPI_COMM_WORLD_RANK");
    return number ? (uint32_t)strtoul(number, NULL, 10) : 0;
}

bool rk_driver_join_team(rk_driver *driver, int argc, char **argv, rk_error *error)
{
    if (!is_asked_for(argc, argv))
        return true;
    driver->team = (rk_team){.process = early_process(), .is_over = true};
    void *loaded = load_module(error);
    if (!loaded)
        return false;
    rk_team_start *start = NULL;
    *(void **)&start = dlsym(loaded, "rk_mpi_start"); /* POSIX's way past C's types */
    if (!start)
        return rk_fail(error, "--mpi: %s is of another version: run make again", module);
    if (!start(&driver->team, error))
        return false;
    if (!rk_driver_speaks(driver) && !freopen("/dev/null", "w", stdout))
        return rk_fail(error, "--mpi: /dev/null cannot be opened");
    return true;
}

static bool has_team(const rk_driver *driver)
{
    return driver->team.processes > 0;
}

bool rk_driver_speaks(const rk_driver *driver)
{
    return driver->team.process == 0;
}

bool rk_driver_check_team(const rk_driver *driver, const rk_driver_spec *spec, rk_error *error)
{
    if (!driver->mpi)
        return true;
    if (!has_team(driver))
        return rk_fail(error, "--mpi: write it out");
    for (const rk_driver_study *study = spec->studies; study && study->wanted; study++)
        if (*study->wanted)
            return rk_fail(error, "--mpi: renders pictures, no tables; leave it out");
    if (driver->timing || driver->debug || driver->pixel.given)
        return rk_fail(error, "--mpi and --%s: choose one of them",
                       driver->timing  ? "timing"
                       : driver->debug ? "debug"
                                       : "pixel");
    return true;
}

/* --- Agreeing --------------------------------------------------------------------------------- */

typedef struct member {
    rk_likeness likeness;
    uint32_t threads;
    char machine[256];
} member;

/* Adds up the threads of all. */
static bool compare_members(rk_driver *driver, const member *all, uint32_t count, rk_error *error)
{
    driver->team_threads = 0;
    for (uint32_t i = 0; i < count; i++) {
        const char *what = rk_likeness_difference(&all[0].likeness, &all[i].likeness);
        if (what)
            return rk_fail(error,
                           "--mpi: process %u on %s has %s than process 0 on %s: their parts of "
                           "the picture would not fit together",
                           i, all[i].machine, what, all[0].machine);
        driver->team_threads += all[i].threads;
    }
    return true;
}

static bool compare_all(rk_driver *driver, rk_error *error)
{
    rk_team *team = &driver->team;
    void *all = NULL;
    uint32_t count = 0;
    member own;
    memset(&own, 0, sizeof own);
    own.likeness = rk_likeness_of(driver);
    own.threads = driver->pool ? rk_pool_threads(driver->pool) : 0;
    memcpy(own.machine, team->machine, sizeof own.machine);
    if (!team->exchange(team->context, &own, 1, sizeof own, &all, &count, error))
        return false;
    const bool ok = compare_members(driver, all, count, error);
    free(all);
    team->is_over = !ok;
    return ok;
}

bool rk_driver_agree(rk_driver *driver, bool ok, rk_error *error)
{
    if (!has_team(driver))
        return ok;
    if (!rk_team_agree(&driver->team, ok, error) || !compare_all(driver, error))
        return false;
    if (driver->pool)
        rk_pool_join(driver->pool, &driver->team);
    return true;
}

/* --- Ending ----------------------------------------------------------------------------------- */

void rk_driver_leave_team(rk_driver *driver)
{
    driver->team.is_over = true;
    rk_pool_join(driver->pool, NULL);
}

bool rk_driver_tell(const rk_driver *driver, const char *text)
{
    const rk_team *team = &driver->team;
    if (team->processes > 1 && !team->is_over)
        fprintf(stderr, "%s: process %u on %s: %s\n", driver->feature, team->process, team->machine,
                text);
    else if (rk_driver_speaks(driver))
        fprintf(stderr, "%s: %s\n", driver->feature, text);
    return false;
}

void rk_driver_end_team(rk_driver *driver, bool ok)
{
    rk_team *team = &driver->team;
    if (has_team(driver))
        team->end(team->context, !ok && !team->is_over && team->processes > 1);
    team->processes = 0;
}
