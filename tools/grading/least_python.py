"""Ends a tool that an old Python runs, with one sentence: parts of the others fail only halfway. This file
itself can be read by each Python 3."""

import sys

LEAST = (3, 10)

if sys.version_info < LEAST:
    sys.stderr.write("raykit's tools need Python %d.%d or later, but this is Python %d.%d (%s); "
                     "docs/machines.md says what to do\n" % (*LEAST, *sys.version_info[:2], sys.executable))
    sys.exit(2)
