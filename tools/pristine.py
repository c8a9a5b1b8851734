#!/usr/bin/env python3
"""Puts back the files of a pack that were edited outside of the workbook. Each edited file is kept
beside the original, as NAME.edited. Files that were added are named, and stay."""

import shlex
import sys

from grading.assignments import Parser
from grading.originals import added_files, edited_files, has_originals, put_back


def tell(source):
    """Says which files were edited or added, if any."""
    for names, what, remedy in ((edited_files(source), "edited", "puts the originals back"),
                                (added_files(source), "added", "says how to move it away")):
        if names:
            more = f" and {len(names) - 3} more" if len(names) > 3 else ""
            print(f"{what} outside of the workbook: {', '.join(names[:3])}{more}; make pristine {remedy}",
                  flush=True)
    return 0


def how_to_move(names):
    """Returns lines for files that do not belong to the pack."""
    if not names:
        return []
    return ["not part of the pack, and may stop the build; move away what you added:",
            *(f"    mkdir -p moved && mv -i {shlex.quote(name)} moved" for name in names)]


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("--source", required=True, metavar="DIR", help="the pack")
    parser.add_argument("--tell", action="store_true", help="only say which there are")
    arguments = parser.parse_args()
    source = arguments.source
    if arguments.tell:
        return tell(source)
    if not has_originals(source):
        print("pristine: this is the whole kit, whose files git restores; "
              "a pack for students has its own copies", file=sys.stderr)
        return 1
    names, added = edited_files(source), added_files(source)
    try:
        saved = put_back(source, names)
    except OSError as error:
        print(f"pristine: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return 1
    for name in names:
        print(f"put back {name}" + (f"; your text is now {name}.edited"
                                    if name in saved else ", which was missing"))
    for line in how_to_move(added):
        print(line)
    if not names and not added:
        print("nothing outside of the workbook was edited")
    return 0


if __name__ == "__main__":
    sys.exit(main())
