"""The command that grades one submission of a class, tools/grade_one.py: tools/grading/parallel_jobs.py runs
it for each."""

import os
import sys

_TOOLS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def command_of(build, stems, out, format_name, kit, listed, processors, again):
    """Returns the command that grades one submission of the list, but for its number."""
    launch, tool = (os.path.join(_TOOLS, name) for name in ("launch.py", "grade_one.py"))
    return [sys.executable, "-B", "-S", launch, tool, *stems, "--build", os.path.abspath(build),
            "--out", os.path.abspath(out), "--format", format_name, "--kit", kit, "--list", listed,
            "--jobs", str(processors), *(["--again"] if again else [])]
