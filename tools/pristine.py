#!/usr/bin/env python3
"""Puts back the files of a pack that were edited outside of the workbook. Each edited file is kept
beside the original, as NAME.edited."""

import sys

from grading.assignments import Parser
from grading.originals import edited_files, has_originals, put_back


def tell(source):
    """Says which files were edited, if any."""
    names = edited_files(source)
    if names:
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        print(f"edited outside of the workbook: {', '.join(names[:3])}{more}; make pristine puts the originals back")
    return 0


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("--source", required=True, metavar="DIR", help="the pack")
    parser.add_argument("--tell", action="store_true", help="only say which there are")
    arguments = parser.parse_args()
    source = arguments.source
    if arguments.tell:
        return tell(source)
    if not has_originals(source):
        print("pristine: this is the whole kit, whose files git restores; a pack for students has its own copies",
              file=sys.stderr)
        return 1
    names = edited_files(source)
    try:
        saved = put_back(source, names)
    except OSError as error:
        print(f"pristine: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return 1
    for name in names:
        print(f"put back {name}" + (f"; your text is now {name}.edited" if name in saved else ", which was missing"))
    if not names:
        print("nothing outside of the workbook was edited")
    return 0


if __name__ == "__main__":
    sys.exit(main())
