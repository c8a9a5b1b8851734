/* Starts a helper program, sends its input, collects its output and its last error, and never
 * hangs.
 *
 * The three standard streams are socket pairs, not pipes: they are created with close-on-exec, so
 * that no other thread's child inherits them, and sending can suppress SIGPIPE. One poll loop
 * serves all three, because a helper that blocks on a full stream would otherwise wait for us while
 * we wait for it. Calls and their guarantees: POSIX.1-2017. */
#include "io/helper.h"

#include "base/sanitized.h"
#include "io/helper_answer.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { INPUT, OUTPUT, REASON, streams }; /* the helper's standard input, output and error */
enum { first_block = 1 << 16 };          /* of output: a small mesh fits */
enum { longest_reason = 4096 };          /* of a helper that stays */
static const double default_timeout = 60;

typedef struct rk_helper {
    const rk_helper_call *call;
    bool stays; /* it answers more than one input */
    const char *subject;
    pid_t process;
    int ends[streams]; /* ours; -1 when closed */
    size_t sent;
    unsigned char *output;
    size_t output_size, output_room;
    char line[1000]; /* the last line of standard error that is not empty */
    size_t line_length;
    bool line_ended;
    double deadline;
} session;

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static double timeout_of(const rk_helper_call *call)
{
    return call->timeout_seconds > 0 ? call->timeout_seconds : default_timeout;
}

static void close_end(int *end)
{
    if (*end >= 0)
        close(*end);
    *end = -1;
}

/* --- finding ------------------------------------------------------------------------------- */

static bool is_program(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) && access(path, X_OK) == 0;
}

static bool find_program(const rk_helper_call *call, char *path, size_t size, rk_error *error)
{
    const char *named = getenv("RAYKIT_HELPERS");
    const char *folders[] = {named, rk_helper_folder()};
    for (int i = 0; i < 2; i++) {
        if (!folders[i] || !*folders[i])
            continue;
        int length = snprintf(path, size, "%s/%s", folders[i], call->program);
        if (length > 0 && (size_t)length < size && is_program(path))
            return true;
    }
    return rk_fail(
        error,
        "%s: the helper program %s is not in %s%s%s: %s%s%srun ./configure and make again, "
        "or name its folder in RAYKIT_HELPERS",
        call->subject ? call->subject : call->program, call->program, named ? named : "",
        named ? " nor in " : "", folders[1], call->package ? "install " : "",
        call->package ? call->package : "", call->package ? ", then " : "");
}

/* --- starting ------------------------------------------------------------------------------ */

/* Both ends above the standard three, which a caller may have closed: dup2 of a descriptor onto
 * itself would leave close-on-exec set. */
static bool make_stream(int ends[2])
{
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return false;
    for (int i = 0; i < 2; i++) {
        if (ends[i] > STDERR_FILENO)
            continue;
        int moved = fcntl(ends[i], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        close(ends[i]);
        ends[i] = moved;
    }
    if (ends[0] >= 0 && ends[1] >= 0)
        return true;
    close_end(&ends[0]);
    close_end(&ends[1]);
    return false;
}

/* Three quarters of the memory: for a file that claims a billion vertices an allocation fails, and
 * the machine does not swap. Sanitizers reserve terabytes of addresses for their shadow memory, so
 * builds with them have no limit. */
static rlim_t memory_limit(void)
{
#ifndef RK_SANITIZED
    long pages = sysconf(_SC_PHYS_PAGES), page_size = sysconf(_SC_PAGESIZE);
    if (pages > 0 && page_size > 0)
        return (rlim_t)pages / 4 * 3 * (rlim_t)page_size;
#endif
    return RLIM_INFINITY;
}

static void lower_limit(int resource, rlim_t value)
{
    struct rlimit limit;
    if (getrlimit(resource, &limit) != 0)
        return;
    if (limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur > value)
        limit.rlim_cur = value;
    setrlimit(resource, &limit);
}

/* The child, between fork and exec: system calls only, because locks of other threads stay
 * locked. */
static _Noreturn void become_helper(const char *path, char *const *arguments,
                                    const int ends[streams], rlim_t memory, pid_t caller)
{
    (void)caller;
    for (int i = 0; i < streams; i++)
        if (dup2(ends[i], i) < 0)
            _exit(127);
#ifdef __linux__
    /* It ends with its caller, also if that is killed; a caller that is dead already is not noticed
     * by prctl. */
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != caller)
        _exit(127);
#endif
    lower_limit(RLIMIT_AS, memory);
    lower_limit(RLIMIT_CORE, 0);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    signal(SIGPIPE, SIG_DFL);
    execv(path, arguments);
    static const char reason[] =
        "the helper program could not be started: it is not a program for this "
        "machine: run make again\n";
    if (write(STDERR_FILENO, reason, sizeof reason - 1) < 0)
        _exit(126);
    _exit(127);
}

/* argv: the path, then the call's arguments; execv takes char * but changes nothing. */
static char **make_arguments(const rk_helper_call *call, char *path, rk_error *error)
{
    size_t count = 0;
    while (call->arguments && call->arguments[count])
        count++;
    char **arguments = rk_allocate(count + 2, sizeof *arguments, call->program, error);
    if (!arguments)
        return NULL;
    arguments[0] = path;
    if (count)
        memcpy(arguments + 1, call->arguments, count * sizeof *arguments);
    return arguments;
}

static bool start(session *s, rk_error *error)
{
    char path[4096];
    if (!find_program(s->call, path, sizeof path, error))
        return false;
    char **arguments = make_arguments(s->call, path, error);
    if (!arguments)
        return false;
    int theirs[streams] = {-1, -1, -1};
    bool ready = true;
    for (int i = 0; i < streams && ready; i++) {
        int ends[2];
        ready = make_stream(ends);
        if (ready)
            s->ends[i] = ends[0], theirs[i] = ends[1];
    }
    rlim_t memory = memory_limit();
    pid_t caller = getpid();
    s->process = ready ? fork() : -1;
    int reason = errno;
    if (s->process == 0)
        become_helper(path, arguments, theirs, memory, caller);
    for (int i = 0; i < streams; i++)
        close_end(&theirs[i]);
    free(arguments);
    if (s->process < 0)
        return rk_fail(error, "%s: %s could not be started: %s: close other programs", s->subject,
                       s->call->program, strerror(reason));
    return true;
}

/* --- talking ------------------------------------------------------------------------------- */

static void send_input(session *s)
{
    const char *input = s->call->input;
    ssize_t n = send(s->ends[INPUT], input + s->sent, s->call->input_size - s->sent,
                     MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n >= 0)
        s->sent += (size_t)n;
    bool again = n < 0 && (errno == EINTR || errno == EAGAIN);
    /* A helper may close its input early: it needs no more, or has failed, as its exit status
     * says. */
    if ((n < 0 && !again) || (s->sent == s->call->input_size && !s->stays))
        close_end(&s->ends[INPUT]);
}

/* Of a helper that stays: false until the answer's beginning is there. */
static bool read_answer(const session *s, rk_helper_answer *answer)
{
    if (s->output_size < sizeof *answer)
        return false;
    memcpy(answer, s->output, sizeof *answer);
    return true;
}

/* The longest output: an answer, or the reason for none. */
static size_t most_output(const session *s)
{
    const size_t most = s->call->output_max;
    if (!s->stays)
        return most;
    return sizeof(rk_helper_answer) + (most > longest_reason ? most : longest_reason);
}

/* Room for one byte more than allowed, so that an excess is noticed. */
static bool grow_output(session *s, rk_error *error)
{
    if (s->output_size < s->output_room)
        return true;
    size_t most = most_output(s) < SIZE_MAX ? most_output(s) + 1 : SIZE_MAX;
    size_t room = s->output_room ? s->output_room : first_block / 2;
    room = room < most / 2 ? room * 2 : most;
    unsigned char *output = realloc(s->output, room);
    if (!output)
        return rk_fail(error, "%s: no memory for an answer of %.1f MB: close other programs",
                       s->subject, (double)room / 1e6);
    s->output = output;
    s->output_room = room;
    return true;
}

static bool read_output(session *s, rk_error *error)
{
    if (!grow_output(s, error))
        return false;
    ssize_t n = read(s->ends[OUTPUT], s->output + s->output_size, s->output_room - s->output_size);
    if (n > 0)
        s->output_size += (size_t)n;
    else if (n == 0 || errno != EINTR)
        close_end(&s->ends[OUTPUT]);
    if (s->output_size > most_output(s))
        return rk_fail(error,
                       "%s: %s sent more than the allowed %zu bytes: the file "
                       "is damaged or too large: save it again, or make it smaller",
                       s->subject, s->call->program, s->call->output_max);
    return true;
}

static void keep_last_line(session *s, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '\n' || text[i] == '\r') {
            s->line_ended = true;
            continue;
        }
        if (s->line_ended)
            s->line_length = 0;
        s->line_ended = false;
        if (s->line_length < sizeof s->line - 1)
            s->line[s->line_length++] = text[i];
    }
    s->line[s->line_length] = '\0';
}

static void read_reason(session *s)
{
    char text[1024];
    ssize_t n = read(s->ends[REASON], text, sizeof text);
    if (n > 0)
        keep_last_line(s, text, (size_t)n);
    else if (n == 0 || errno != EINTR)
        close_end(&s->ends[REASON]);
}

static bool fail_silent(const session *s, rk_error *error)
{
    return rk_fail(
        error,
        "%s: %s took longer than %g s and was stopped: the file is damaged, or too large or "
        "intricate: make it smaller, or try another format",
        s->subject, s->call->program, timeout_of(s->call));
}

static bool has_answered(const session *s)
{
    rk_helper_answer answer;
    return s->stays && s->sent == s->call->input_size && read_answer(s, &answer) &&
           s->output_size - sizeof answer == answer.size;
}

/* Runs until the helper has answered, or has closed its output and its error stream. */
static bool talk(session *s, rk_error *error)
{
    if (s->call->input_size == 0 && !s->stays)
        close_end(&s->ends[INPUT]);
    while (!has_answered(s) && (s->ends[OUTPUT] >= 0 || s->ends[REASON] >= 0)) {
        const int input = s->sent < s->call->input_size ? s->ends[INPUT] : -1;
        struct pollfd polled[streams] = {
            {input, POLLOUT, 0}, {s->ends[OUTPUT], POLLIN, 0}, {s->ends[REASON], POLLIN, 0}};
        double left = s->deadline - seconds_now();
        int wait_ms = left <= 0 ? 0 : left > 1e6 ? 1000000000 : (int)(left * 1e3) + 1;
        int ready = poll(polled, streams, wait_ms);
        if (ready < 0 && errno != EINTR && errno != EAGAIN)
            return rk_fail(error, "%s: waiting for %s failed: %s: try again", s->subject,
                           s->call->program, strerror(errno));
        if (ready == 0 && seconds_now() >= s->deadline)
            return fail_silent(s, error);
        if (ready <= 0)
            continue;
        if (polled[INPUT].revents)
            send_input(s);
        if (polled[OUTPUT].revents && !read_output(s, error))
            return false;
        if (polled[REASON].revents)
            read_reason(s);
        s->deadline = seconds_now() + timeout_of(s->call);
    }
    return true;
}

/* --- ending -------------------------------------------------------------------------------- */

static void stop(session *s)
{
    kill(s->process, SIGKILL);
    while (waitpid(s->process, NULL, 0) < 0 && errno == EINTR)
        ;
}

/* A helper that has closed its streams usually ends within a millisecond, but one that keeps
 * running must not hang the caller. */
static bool reap(session *s, int *status, rk_error *error)
{
    long pause = 50000; /* nanoseconds, doubled up to 10 ms */
    for (;;) {
        pid_t ended = waitpid(s->process, status, WNOHANG);
        if (ended == s->process)
            return true;
        if (ended < 0 && errno != EINTR)
            return rk_fail(error,
                           "%s: the exit status of %s is unknown: %s: leave SIGCHLD at its default",
                           s->subject, s->call->program, strerror(errno));
        if (seconds_now() >= s->deadline) {
            stop(s);
            return fail_silent(s, error);
        }
        nanosleep(&(struct timespec){0, pause}, NULL);
        pause = pause < 5000000 ? pause * 2 : 10000000;
    }
}

static bool judge(const session *s, int status, rk_error *error)
{
    if (WIFSIGNALED(status))
        return rk_fail(error,
                       "%s: %s was ended by signal %d (%s): the file is damaged or too large, or "
                       "its reader fails on it: save it again, or in another format",
                       s->subject, s->call->program, WTERMSIG(status), strsignal(WTERMSIG(status)));
    if (WEXITSTATUS(status) == 0) {
        rk_fail(error, "%s", s->line);
        return true;
    }
    if (s->line_length == 0)
        return rk_fail(error,
                       "%s: %s failed with exit status %d and gave no reason: save the file again, "
                       "or in another format",
                       s->subject, s->call->program, WEXITSTATUS(status));
    return rk_fail(error, "%s", s->line);
}

static void close_all(session *s)
{
    for (int i = 0; i < streams; i++)
        close_end(&s->ends[i]);
}

bool rk_helper_run(const rk_helper_call *call, unsigned char **output, size_t *output_size,
                   rk_error *error)
{
    *output = NULL;
    *output_size = 0;
    session s = {.call = call, .ends = {-1, -1, -1}};
    s.subject = call->subject ? call->subject : call->program;
    s.deadline = seconds_now() + timeout_of(call);
    int status = 0;
    bool started = start(&s, error);
    bool talked = started && talk(&s, error);
    close_all(&s);
    if (started && !talked)
        stop(&s);
    if (!talked || !reap(&s, &status, error) || !judge(&s, status, error)) {
        free(s.output);
        return false;
    }
    *output = s.output;
    *output_size = s.output_size;
    return true;
}

/* --- staying ------------------------------------------------------------------------------- */

void rk_helper_end(rk_helper **helper)
{
    session *s = *helper;
    *helper = NULL;
    if (!s)
        return;
    close_all(s);
    if (s->process > 0)
        stop(s); /* rather than wait until it has unloaded its libraries */
    free(s->output);
    free(s);
}

static bool start_staying(session **helper, const rk_helper_call *call, rk_error *error)
{
    session *s = rk_allocate(1, sizeof *s, call->program, error);
    if (!s)
        return false;
    *s = (session){.call = call, .stays = true, .ends = {-1, -1, -1}};
    s->subject = call->subject ? call->subject : call->program;
    if (!start(s, error)) {
        close_all(s);
        free(s);
        return false;
    }
    *helper = s;
    return true;
}

static void begin_call(session *s, const rk_helper_call *call)
{
    s->call = call;
    s->subject = call->subject ? call->subject : call->program;
    s->sent = s->output_size = s->output_room = s->line_length = 0;
    s->output = NULL;
    s->line[0] = '\0';
    s->line_ended = false;
    s->deadline = seconds_now() + timeout_of(call);
}

/* Of one that has closed its streams. */
static bool fail_ended(session *s, rk_error *error)
{
    int status = 0;
    close_all(s);
    const bool known = reap(s, &status, error);
    s->process = 0;
    if (!known || !judge(s, status, error))
        return false;
    return rk_fail(error, "%s: %s ended without a whole answer: run make again", s->subject,
                   s->call->program);
}

/* Hands the answer's bytes over, or makes them the error. */
static bool take_answer(session *s, unsigned char **output, size_t *output_size, rk_error *error)
{
    rk_helper_answer answer;
    read_answer(s, &answer);
    if (answer.failed) {
        const size_t length = answer.size < longest_reason ? (size_t)answer.size : longest_reason;
        return rk_fail(error, "%.*s", (int)length, (const char *)s->output + sizeof answer);
    }
    memmove(s->output, s->output + sizeof answer, (size_t)answer.size);
    *output = s->output;
    *output_size = (size_t)answer.size;
    s->output = NULL;
    return true;
}

bool rk_helper_ask(rk_helper **helper, const rk_helper_call *call, unsigned char **output,
                   size_t *output_size, rk_error *error)
{
    *output = NULL;
    *output_size = 0;
    if (!*helper && !start_staying(helper, call, error))
        return false;
    session *s = *helper;
    begin_call(s, call);
    bool talked = talk(s, error), answered = talked && has_answered(s);
    bool ok = answered && take_answer(s, output, output_size, error);
    if (!answered) {
        if (talked)
            fail_ended(s, error);
        rk_helper_end(helper);
        return false;
    }
    free(s->output);
    s->output = NULL;
    return ok;
}
