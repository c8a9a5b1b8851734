"""A sandbox for untrusted programs, made by bubblewrap from Linux namespaces. Inside are the system's
programs and libraries to read, a /proc, /dev and /tmp of its own, and no network; nothing else of this
machine, unless a command is given it.

The environment's RAYKIT_SANDBOX (make's SANDBOX) says "no" or "container" to do without.
"""

import glob
import os
import re
import shutil
import subprocess

from grading import seccomp
from grading.assignments import MachineError, ToolError

_SYSTEM = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/nix/store",
           "/etc/alternatives", "/etc/ld.so.cache")
_BYTES_MAX = 256 << 20  # of all files in /tmp, and in /dev/shm


class Bubblewrap:
    """The sandbox for a build of the kit."""

    def __init__(self, toolchain, program):
        known = subprocess.run([program, "--help"], capture_output=True, text=True, check=False).stdout
        limited = ["--size", str(_BYTES_MAX)] if "--size" in known else []
        # Namespaces within the sandbox would show a unit much of the kernel.
        alone = ["--unshare-user", "--disable-userns"] if "--disable-userns" in known else []
        self._begin = [program, "--unshare-all", *alone, "--die-with-parent", "--cap-drop", "ALL"]
        self.filter = seccomp.program(toolchain.compiler) if "--seccomp" in known else b""
        for path in _SYSTEM:
            if os.path.islink(path):
                self._begin += ["--symlink", os.readlink(path), path]
            else:
                self._begin += ["--ro-bind-try", path, path]
        # Process 1 is bubblewrap's own, and its memory can be written to in its folder.
        self._begin += ["--proc", "/proc", "--tmpfs", "/proc/1", "--remount-ro", "/proc/1"]
        self._begin += ["--dev", "/dev", *limited, "--tmpfs", "/dev/shm", "--remount-ro", "/dev",
                        *limited, "--tmpfs", "/tmp"]
        for path in os.environ.get("LD_LIBRARY_PATH", "").split(":"):
            self._begin += ["--ro-bind-try", path, path] if os.path.isabs(path) else []
        # A kit that lies or is installed among the system's files is hidden.
        for path in (toolchain.source, toolchain.build):
            if os.path.realpath(path).startswith(tuple(top + "/" for top in _SYSTEM)):
                self._begin += ["--tmpfs", os.path.realpath(path)]
        for pattern in ("/usr/lib*/libraykit.a", "/usr/lib/*/libraykit.a", "/usr/local/lib*/libraykit.a"):
            for path in glob.glob(pattern):
                self._begin += ["--ro-bind", "/dev/null", path]

    def around(self, command, binds=(), folder="/tmp"):
        """Returns the command that runs this one inside, in a folder; `binds` are bubblewrap's
        options for what it needs beside the system."""
        return [*self._begin, *binds, "--remount-ro", "/", "--chdir", folder, "--", *command]

    def around_compiler(self, command, folder, kit):
        """The same for a compiler, which can write to the folder, and read the copied kit and the
        files that its command names."""
        named = [re.sub("^-(I|L|isystem|include)", "", word) for word in command]
        readable = [kit, *[path for path in named if os.path.isabs(path)]]
        binds = [option for path in readable for option in ("--ro-bind-try", path, path)]
        return self.around(command, [*binds, "--bind", folder, folder], folder)


def _without():
    """What is said to do without a sandbox; from root "no" would not be taken."""
    if os.geteuid() == 0:
        return ("as you are root, grade as another user, or say SANDBOX=container in one that is thrown "
                "away, to run it all the same")
    return "say SANDBOX=no to run it all the same, as a user who has nothing to lose"


def find(toolchain):
    """Returns the sandbox and ""; or None, and what is to be said where the code ran without one."""
    wish = os.environ.get("RAYKIT_SANDBOX", "")
    if wish not in ("", "yes", "no", "container"):
        raise ToolError(f"SANDBOX={wish}: say yes, no or container")
    if wish == "no" and os.geteuid() == 0:
        raise ToolError("SANDBOX=no would give graded code all rights on this machine, as you are root: "
                        "grade as another user, or say SANDBOX=container in one that is thrown away")
    if wish in ("no", "container"):
        return None, f"without a sandbox (SANDBOX={wish}): the code had the grader's rights"
    program, reason, remedy = shutil.which("bwrap"), "bubblewrap is not installed", "install bubblewrap"
    compiler = shutil.which(toolchain.compiler[0]) or ""
    if program and not os.path.realpath(compiler).startswith(tuple(path + "/" for path in _SYSTEM)):
        raise ToolError(f"the sandbox has no compiler, as {compiler or toolchain.compiler[0]} stands outside "
                        "of the system's folders, and graded code would run with your rights: configure with "
                        f"one of /usr, or {_without()}")
    if program:
        sandbox = Bubblewrap(toolchain, program)
        tried = subprocess.run(sandbox.around([*toolchain.compiler, "--version"]), stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, errors="replace", check=False)
        if tried.returncode == 0:
            return sandbox, ""
        reason = (tried.stderr.strip().splitlines() or ["bwrap fails"])[-1]
        remedy = "docs/machines.md says how one starts"
    raise MachineError(f"there is no sandbox ({reason}), and graded code would run with your rights: "
                       f"{remedy}, or {_without()}")
