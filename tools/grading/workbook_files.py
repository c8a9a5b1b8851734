"""Files of a workbook beside units and tasks: what editors, make and git look for there."""

import os

_FORWARD = """\
# Here make works as in raykit's own folder.
MAKEFLAGS += --no-builtin-rules
all: ; +@$(MAKE) --no-print-directory -C {there}{impl} $@
.DEFAULT: ; +@$(MAKE) --no-print-directory -C {there}{impl} $@
"""


def _quoted(path):
    """Returns a path for a recipe, which make and then the shell read."""
    return "'" + path.replace("'", "'\\''").replace("$", "$$") + "'"


def workbook_files(source, folder, build, impl=None):
    """Returns a dictionary from name to text. `build` is where make runs, `impl` the workbook's name there;
    none if it is the usual one."""
    headers = os.path.join(os.path.relpath(source, folder), "src")
    files = {
        "compile_flags.txt": f"-I{headers}\n-std=c17\n-D_XOPEN_SOURCE=700\n",
        ".gitignore": "*.o\n.deps/\n.dirstamp\n",
    }
    there = os.path.relpath(build, folder)
    if "\n" not in there + (impl or ""):
        files["Makefile"] = _FORWARD.format(there=_quoted(there),
                                            impl=f" IMPL={_quoted(impl)}" if impl else "")
    return files
