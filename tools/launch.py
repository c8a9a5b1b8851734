#!/usr/bin/env python3
"""Starts another tool so that Ctrl-C ends it quietly at any moment.

Before the tool's own main begins, and after it has ended, the system ends the process; Python would show
where in its libraries it was. Make starts all tools by it."""

import _signal  # in C: signal itself is read from files, which takes a while

# What a script runs in the background ignores it.
_is_asked = _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler
if _is_asked:
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)

import importlib
import os
import sys


def _ctrl_c(handler):
    if _is_asked:
        _signal.signal(_signal.SIGINT, handler)


def main():
    import grading.least_python  # noqa: F401
    del sys.argv[0]
    tool = importlib.import_module(os.path.basename(sys.argv[0]).removesuffix(".py"))
    try:
        _ctrl_c(_signal.default_int_handler)
        return tool.main()
    except KeyboardInterrupt:
        return 130
    finally:
        _ctrl_c(_signal.SIG_DFL)


if __name__ == "__main__":
    sys.exit(main())
