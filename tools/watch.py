#!/usr/bin/env python3
"""Grades a unit again whenever it is saved. Ctrl-C ends it."""

import argparse
import os
import subprocess
import sys
import time

from assignments import ToolError, check_impl, read_features
from building import Toolchain
from grade import stop_on_signals

_LOOK_SECONDS = 0.15  # between looks at the files: soon enough, and no load


def state(impl):
    """Returns what changes when a C file or header of IMPL is saved."""
    folder = impl if os.path.isdir(impl) else os.path.dirname(impl) or "."
    files = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.endswith((".c", ".h")) and not entry.name.startswith("."):
                    status = entry.stat()
                    files.append((entry.name, status.st_mtime_ns, status.st_size, status.st_ino))
    except OSError:
        pass  # an editor is replacing something; the next look sees it
    return sorted(files)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--test", metavar="NAME")
    arguments = parser.parse_args()
    stop_on_signals()
    cache = f"pycache_prefix={os.path.join(arguments.build, 'impl', 'python')}"
    grader = os.path.join(os.path.dirname(__file__), "grade.py")
    command = [sys.executable, "-X", cache, grader, arguments.stem, "--build", arguments.build,
               "--impl", arguments.impl, "--fallback"]
    command += ["--test", arguments.test] if arguments.test else []
    try:
        features = read_features(Toolchain(arguments.build).source)
        check_impl(features, arguments.impl, [arguments.stem])
        seen = None
        while True:
            now = state(arguments.impl)
            if now != seen:
                seen = now
                print("\033[H\033[2J\033[3J" if sys.stdout.isatty() else "", end="", flush=True)
                subprocess.run(command, check=False)
                print(f"{time.strftime('%H:%M:%S')}, waiting for you to save; Ctrl-C ends", flush=True)
            time.sleep(_LOOK_SECONDS)
    except ToolError as error:
        print(f"watch: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print()
        return 0


if __name__ == "__main__":
    sys.exit(main())
