"""The system calls that a unit's program may make: a filter for bubblewrap's --seccomp, which the kernel runs
at each call. All others fail with "Operation not permitted".

The list is of what the suites, the sanitizers and the C library use. A socket is none of it, nor a namespace,
shared memory or memory without a size, nor a new process, but for one of the leak sanitizer's kind: it shares
the memory of the program, which it stops while it looks. Threads are allowed. No call that sleeps is, but for
the futex, by which a unit's process waits for its judge (idleness.py sees who sleeps there).
Source: Linux, Documentation/userspace-api/seccomp_filter.rst.
"""

import platform
import re
import struct
import subprocess

_ALLOWED = """
    access arch_prctl brk clock_getres clock_gettime close dup dup2 dup3 execve exit exit_group
    faccessat faccessat2 fcntl fstat fstatfs ftruncate futex getcwd getdents getdents64 getegid geteuid
    getgid getpgid getpgrp getpid getppid getpriority getrandom getrlimit getrusage getsid gettid
    gettimeofday getuid kill lseek lstat madvise membarrier mincore mmap mprotect mremap munmap
    newfstatat open openat personality pipe2 prctl pread64 prlimit64 read readlink readlinkat readv rseq
    rt_sigaction rt_sigpending rt_sigprocmask rt_sigreturn sched_getaffinity sched_yield set_robust_list
    set_tid_address setrlimit sigaltstack stat statfs statx sysinfo tgkill time times tkill uname wait4
    waitid write writev"""
_ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}  # AUDIT_ARCH_... of <linux/audit.h>
_X32 = 0x40000000  # numbers from here on are another interface to the same calls
_CLONE_THREAD = 0x10000
_CLONE_TRACER = 0x800700  # _VM, _FS, _FILES and _UNTRACED, without a signal at its end
_TCGETS = 0x5401  # is it a terminal?
_FIRST_PROCESS = 1

# Of <linux/bpf_common.h> and <linux/seccomp.h>.
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_KILL, _ALLOW, _FAIL = 0x80000000, 0x7FFF0000, 0x00050000
_NUMBER, _ARCHITECTURE, _ARGUMENTS = 0, 4, 16  # offsets in struct seccomp_data
_EPERM, _ENOSYS = 1, 38


def _instruction(code, value, if_true=0, if_false=0):
    return struct.pack("=HBBI", code, if_true, if_false, value)


def _numbers(compiler):
    """Returns the system's numbers by name, as its headers have them."""
    answer = subprocess.run([*compiler, "-E", "-dM", "-x", "c", "-"], input="#include <sys/syscall.h>\n",
                            capture_output=True, text=True, check=False)
    defined = dict(re.findall(r"^#define (__NR\w*) (\w+)$", answer.stdout, re.MULTILINE))
    numbers = {}
    for name, value in defined.items():
        while value in defined:
            value = defined[value]
        if value.isdigit():
            numbers[name.removeprefix("__NR_")] = int(value)
    return numbers


def _where(number, checks):
    """Instructions that end with a verdict for this call, and are skipped for others."""
    return _instruction(_EQUAL, number, 0, len(checks) // 8) + checks


def program(compiler):
    """Returns the filter's bytes, empty where the machine is none of those above."""
    architecture, numbers = _ARCHITECTURES.get(platform.machine()), _numbers(compiler)
    if not architecture or "read" not in numbers:
        return b""
    allow, fail = _instruction(_RETURN, _ALLOW), _instruction(_RETURN, _FAIL | _EPERM)
    text = (_instruction(_LOAD, _ARCHITECTURE) + _instruction(_EQUAL, architecture, 1, 0)
            + _instruction(_RETURN, _KILL) + _instruction(_LOAD, _NUMBER)
            + _instruction(_AT_LEAST, _X32, 0, 1) + fail)
    # The C library then takes clone, whose flags can be looked at.
    text += _where(numbers["clone3"], _instruction(_RETURN, _FAIL | _ENOSYS)) if "clone3" in numbers else b""
    text += _where(numbers["clone"], _instruction(_LOAD, _ARGUMENTS)
                   + _instruction(_ANY_BIT, _CLONE_THREAD, 1, 0)
                   + _instruction(_EQUAL, _CLONE_TRACER, 0, 1) + allow + fail)
    text += _where(numbers["ioctl"], _instruction(_LOAD, _ARGUMENTS + 8) + _instruction(_EQUAL, _TCGETS, 0, 1)
                   + allow + fail)
    # The sandbox's first process, which tells how the program ended, is nobody's to look into.
    for name, argument in (("ptrace", 1), ("process_vm_readv", 0)):
        text += _where(numbers[name], _instruction(_LOAD, _ARGUMENTS + 8 * argument)
                       + _instruction(_EQUAL, _FIRST_PROCESS, 0, 1) + fail + allow)
    for name in _ALLOWED.split():
        text += _where(numbers[name], allow) if name in numbers else b""
    return text + fail
