/* Memory and processor time are limited by setrlimit. A failed allocation is an ordinary error;
 * the other two arrive as signals, whose handlers may make system calls only, so their lines are
 * written beforehand. Source: POSIX.1-2017, setrlimit, sigaltstack. */
#include "io/mesh_helper/mesh_guard.h"

#include "base/sanitized.h"

#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>

/* Assimp takes 10 to 20 bytes for each of a text, 40 for one of compressed triangles, and 200 in
 * files of thousands of parts; it reads 5 MB a second or more. */
static const uint64_t memory_base = (uint64_t)256 << 20, memory_per_byte = 128;
static const uint64_t seconds_base = 20, bytes_per_second = 1 << 20;

enum { most_files = 64 }; /* further ones are read, but raise no limit */

static struct {
    const char *path;
    uint64_t bytes, memory, seconds;
    int file_count;
    struct {
        dev_t device;
        ino_t number;
    } files[most_files];
    const char *stack; /* the first function's */
    char time_line[1400], stack_line[1400];
    char fault_line[1400]; /* or "" */
} guard;

static void say(const char *line)
{
    if (write(STDERR_FILENO, line, strlen(line)) >= 0)
        _exit(EXIT_FAILURE);
    _exit(EXIT_FAILURE);
}

static void on_time(int number)
{
    (void)number;
    say(guard.time_line);
}

/* A fault just below the lowest address that the stack may have is its overflow. */
static void on_fault(int number, siginfo_t *info, void *context)
{
    (void)context;
    struct rlimit stack;
    const uintptr_t at = (uintptr_t)info->si_addr, top = (uintptr_t)guard.stack;
    const uintptr_t slack = 1 << 20; /* arguments and environment; one large function */
    if (getrlimit(RLIMIT_STACK, &stack) == 0 && at < top && top - at > stack.rlim_cur - slack &&
        top - at < stack.rlim_cur + slack)
        say(guard.stack_line);
    if (*guard.fault_line)
        say(guard.fault_line);
    signal(number, SIG_DFL); /* it happens again, and ends the process */
}

static void catch_signals(void)
{
    static char block[1 << 16];
    const stack_t other = {.ss_sp = block, .ss_size = sizeof block};
    struct sigaction time = {.sa_handler = on_time};
    struct sigaction fault = {.sa_sigaction = on_fault, .sa_flags = SA_ONSTACK | SA_SIGINFO};
    sigaction(SIGXCPU, &time, NULL);
    if (sigaltstack(&other, NULL) == 0)
        sigaction(SIGSEGV, &fault, NULL);
}

static void limit(int resource, uint64_t value)
{
    struct rlimit now;
    if (getrlimit(resource, &now) != 0)
        return;
    now.rlim_cur = now.rlim_max == RLIM_INFINITY || value < now.rlim_max ? value : now.rlim_max;
    setrlimit(resource, &now);
}

/* Sanitizers reserve terabytes, and are several times slower. */
#ifdef RK_SANITIZED
enum { sanitized = 1 };
#else
enum { sanitized = 0 };
#endif

static void set_limits(void)
{
    guard.memory = memory_base + memory_per_byte * guard.bytes;
    guard.seconds = seconds_base + guard.bytes / bytes_per_second;
    snprintf(
        guard.time_line, sizeof guard.time_line,
        "%.900s: takes more than %llu s of processor time, which is too much for a file of "
        "%llu bytes: it has too many parts or materials: join some, or export it as glTF or PLY\n",
        guard.path, (unsigned long long)guard.seconds, (unsigned long long)guard.bytes);
    if (!sanitized) {
        limit(RLIMIT_AS, guard.memory);
        limit(RLIMIT_CPU, guard.seconds);
    }
}

void rk_mesh_guard_begin(const char *path)
{
    guard.path = path;
    guard.stack = __builtin_frame_address(0);
    snprintf(guard.stack_line, sizeof guard.stack_line,
             "%.900s: its parts are nested too deeply: export it again, with fewer levels\n", path);
    const char *dot = strrchr(path, '.');
    if (dot && strcasecmp(dot, ".blend") == 0) /* of newer versions, Assimp crashes on some */
        snprintf(guard.fault_line, sizeof guard.fault_line,
                 "%.900s: could not be read: open it in Blender, and export it as glTF\n", path);
    set_limits();
    catch_signals();
}

static bool is_known(const struct stat *file)
{
    for (int i = 0; i < guard.file_count; i++)
        if (guard.files[i].device == file->st_dev && guard.files[i].number == file->st_ino)
            return true;
    return false;
}

void rk_mesh_guard_allow(const struct stat *file)
{
    if (!guard.path || is_known(file) || guard.file_count == most_files)
        return;
    guard.files[guard.file_count].device = file->st_dev;
    guard.files[guard.file_count++].number = file->st_ino;
    guard.bytes += (uint64_t)file->st_size;
    set_limits();
}

bool rk_mesh_guard_fail_memory(size_t uses, rk_error *error)
{
    char reason[100] = "it is damaged, or has too many parts or materials";
    if (uses > 1000)
        snprintf(reason, sizeof reason, "it has too many parts or materials (%zu usemtl lines)",
                 uses);
    return rk_fail(
        error,
        "%.700s: takes more than %llu MB of memory, which is too much for a file of %llu "
        "bytes: %s: export it again, or join some",
        guard.path, (unsigned long long)(guard.memory >> 20), (unsigned long long)guard.bytes,
        reason);
}
