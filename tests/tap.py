"""TAP for suites in Python: claims with their verdicts, commands as at a prompt, and files."""

import os
import subprocess
import sys
import time

checks = []


def check(condition, name, said=""):
    """Notes a claim's verdict; of a failed one also the last lines of `said`, a text or a list of lines."""
    checks.append(bool(condition))
    lines = map(str, said) if isinstance(said, list) else str(said).splitlines()
    for line in [] if condition else list(lines)[-30:]:
        print(f"# {line[:1000]}")  # a longer one is too much for some awk
    print(f"{'ok' if condition else 'not ok'} {len(checks)} - {name}", flush=True)


def start(main):
    """Runs a suite, and exits with its status. The driver asks for names of tests, which it can do
    without."""
    sys.exit(0 if "--list" in sys.argv else main())


def finish():
    """Prints the plan; returns the exit status."""
    print(f"1..{len(checks)}")
    return 0 if all(checks) else 1


def run(folder, *command):
    """Runs a command as at a prompt, without make's own variables; returns its exit status and output."""
    dropped = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "srcdir")
    environment = {name: value for name, value in os.environ.items() if name not in dropped}
    answer = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace", check=False)
    return answer.returncode, answer.stdout


def wait(condition, seconds=60, pause=0.01):
    """Waits until the condition holds, or so many seconds are over; returns its value."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(pause)
    return condition()


def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


def write(text, *path):
    os.makedirs(os.path.dirname(os.path.join(*path)), exist_ok=True)
    with open(os.path.join(*path), "w", encoding="utf-8") as file:
        file.write(text)
