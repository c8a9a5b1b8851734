"""Reports of graded suites: for people (text, table), for test tools (TAP, JUnit XML), and for
Gradescope (results.json). Files are written whole or not at all."""

import copy
import functools
import json
import os
import re
import shlex
import shutil
import sys
import tempfile
import textwrap

from grading import sandbox
from grading.assignments import DEDUCTION, ToolError, cannot_write
from grading.build import without_what_is_shown
from grading.starters import is_handed_out
from grading.verdicts import printed_lines

_DETAILS_MAX = 10000  # characters of a program's output that go into a report


# Of all characters those that XML allows, without those that end a line, turn its direction, or take no room:
# two names that look alike would be two students.
_SHOWN = ("\\x20-\\x7e\\xa0-\\xac\\xae-\\u034e\\u0350-\\u061b\\u061d-\\u115e\\u1161-\\u17b3\\u17b6-\\u180a"
          "\\u1810-\\u200a\\u2010-\\u2027\\u202f-\\u205f\\u2070-\\u3163\\u3165-\\ud7ff\\ue000-\\ufdff"
          "\\ufe10-\\ufefe\\uff00-\\uff9f\\uffa1-\\uffef\\ufffc-\\ufffd\\U00010000-\\U000dffff"
          "\\U000e1000-\\U0010ffff")


def printable(text):
    """Control characters are not allowed in XML, and unwanted on a terminal."""
    return re.sub(rf"[^\t\n{_SHOWN}]", "?", text)


def _in_a_line(text):
    return re.sub("[\t\n]", " ", printable(text))


def _shown(suite):
    """Returns a suite of which all that comes from outside can be shown: what code and its compiler print,
    what the code tells of itself, names of files."""
    suite = copy.copy(suite)
    suite.problem, suite.warnings = printable(suite.problem), printable(suite.warnings)
    suite.not_graded = printable(suite.not_graded)
    suite.beside, suite.remarks = _in_a_line(suite.beside), list(map(_in_a_line, suite.remarks))
    suite.verdicts = {name: copy.copy(verdict) for name, verdict in suite.verdicts.items()}
    for verdict in suite.verdicts.values():
        verdict.reason, verdict.place = printable(verdict.reason), _in_a_line(verdict.place)
        verdict.details = printable(verdict.details)
    return suite


def _report(function):
    """A function of suites that tells of them: it gets them as they can be shown."""
    @functools.wraps(function)
    def of_shown(suites, *arguments, **options):
        return function([_shown(suite) for suite in suites], *arguments, **options)

    return of_shown


def _details(verdict):
    text = verdict.details
    if len(text) > _DETAILS_MAX:
        text = text[:_DETAILS_MAX // 2] + "\n[...]\n" + text[-_DETAILS_MAX // 2:]
    return text


def _counts(suite):
    passed = sum(suite.verdicts[test.name].passed for test in suite.tests)
    return f"{passed} of {len(suite.tests)} claims, {suite.points()} of {suite.points_max()} points"


def _lost(suite):
    """Says which claims cost points."""
    scores = suite.scores()
    lost = [name for name, score in scores.items() if score < 0]
    more = ", ..." if len(lost) > 2 else ""
    return f"less {-sum(scores[name] for name in lost)} for {', '.join(lost[:2])}{more}" if lost else ""


_BAR = 6  # characters for all claims of a step


def _steps(suite):
    """A bar for each step of the assignment: how many of its claims hold."""
    steps = {}
    for test in suite.claims():
        if test.step:
            steps.setdefault(test.step, []).append(suite.verdicts[test.name].passed)
    if suite.problem or len(steps) < 2:
        return []
    bars = []
    for step, held in sorted(steps.items()):
        full = sum(held) * _BAR // len(held)
        bars.append(f"{step} [{'#' * full}{'.' * (_BAR - full)}]")
    return _wrapped("steps  " + "  ".join(bars), " " * 6)


def name_of(impl):
    """The name of the work, without the path to it, which is the grader's. Different names stay different:
    bytes that cannot be shown become \\xfc."""
    name = os.path.basename(os.path.normpath(impl)).replace("\\", "\\\\")
    return re.sub(f"[^{_SHOWN}]",
                  lambda found: "".join(f"\\x{byte:02x}" for byte in os.fsencode(found[0])), name)


def _when(suite, test):
    """What did not end may end where others than its student's own check wait for it (scores)."""
    return " when graded" if suite.is_own and suite.verdicts[test.name].timed_out else ""


def _worth(suite, test):
    if test.name in suite.excused:
        return f"costs nothing: it fails with the starter, too, by {' or '.join(suite.feature.needs)}"
    if not test.points:
        return f"costs {DEDUCTION} points{_when(suite, test)}: it held with the starter"
    return f"{test.points} point{'s' * (test.points != 1)}"


def _explained(suite, test):
    """The reason, the place and the section to read, one line each. The whole unit's reason appears once."""
    verdict = suite.verdicts[test.name]
    if suite.problem:
        first = test is suite.tests[0]
        return suite.problem.split("\n") if first else ["not run, for the reason above"]
    lines = verdict.reason.split("\n") + ([verdict.place] if verdict.place else [])
    beside = [suite.beside] if suite.beside else []
    feature = suite.feature
    place = feature.where_to_read(test.section) if suite.is_own else feature.chapter + test.section
    return [*lines, *beside, *([f"read {place}"] if test.section else [])]


# --- Text ---------------------------------------------------------------------------------------

_SCREEN = 22  # lines of a small terminal, without make's last line and the prompt
_NEXT = 3  # claims that a student's own check names beside the first


def _width():
    return max(40, min(shutil.get_terminal_size((100, 24)).columns, 120))


def _wrapped(text, indent):
    return textwrap.wrap(text, _width(), initial_indent=indent, subsequent_indent=indent,
                         break_long_words=False,
                         break_on_hyphens=False)


def _some(lines, most, more):
    """Returns the first lines, and a last one with how many were left out."""
    return lines if len(lines) <= most else [*lines[:most - 1], more.format(len(lines) - most + 1)]


def _named(suite, test):
    cost = 0 if test.name in suite.excused else DEDUCTION
    return f"{test.name} ({test.points or f'costs {cost}{_when(suite, test)}'})"


def _all_others(suite, failed, first):
    """All claims that failed beside the first, those with the same reason together."""
    lines, groups = ["      then:"], {}
    for test in failed:
        groups.setdefault(suite.verdicts[test.name].reason.split("\n")[0], []).append(test)
    for reason, tests in groups.items():
        lines += [f"          {_named(suite, test)}" for test in tests]
        same = reason == suite.verdicts[first.name].reason.split("\n")[0]
        lines += _wrapped("for the same reason as the first" if same else reason, " " * 14)
    return lines


def _next_ones(suite, failed, see_all):
    named = _some([_named(suite, test) for test in failed], _NEXT + 1, f"and {{}} more: {see_all}")
    return [("      then: " if not number else " " * 12) + name for number, name in enumerate(named)]


def _text_of_failures(suite, brief, see_all):
    """What is brief fits on a terminal, so that it can be read in the order of work."""
    failed = [test for test in suite.tests if not suite.verdicts[test.name].passed]
    if not failed:
        return []
    first = failed[0]
    if suite.problem:
        details = [line for line in _details(suite.verdicts[first.name]).strip().split("\n") if line]
        said = _some(details, 15 if brief else 20, "and {} more lines")
        reason = without_what_is_shown(suite.problem, "\n".join(said))
        return [*(f"          {line}" for line in said), *_wrapped(reason, " " * 6)]
    lines = [f"      work on this one first: {first.name} ({_worth(suite, first)})"]
    explained = _explained(suite, first)
    if brief and first.step:
        explained.append(f"a hint: make hint-{suite.feature.stem} STEP={first.step}")
    for line in explained:
        lines += _wrapped(line, " " * 10)
    following = _next_ones(suite, failed[1:], see_all) if brief else _all_others(suite, failed[1:], first)
    return lines + (following if failed[1:] else [])


def _text_of_prints(suite):
    """What the code printed, where one test is run alone."""
    if len(suite.claims()) != 1:
        return []
    verdict = suite.verdicts[suite.claims()[0].name]
    printed = [line[:200] for line in printed_lines(verdict.details) if line not in verdict.reason]
    return ["      your code printed:",
            *(f"          {line}" for line in _some(printed, 40, "and {} more lines"))] if printed else []


def _whose(suite):
    return "this is the reference, which earns no points" if suite.unit.is_reference else ""


def command_of(does, feature, impl=None, options=""):
    """Returns "make DOES-STEM IMPL=mine"; in a pack for students the workbook is meant without a word."""
    command = f"make {does}-{feature.stem}{options}"
    if impl is None:
        return command
    own = os.path.basename(os.path.normpath(impl)) == "workbook" and is_handed_out(feature.reference)
    return command + ("" if own else f" IMPL={shlex.quote(impl)}")


@_report
def problems(suites):
    """Each claim that failed as a line that editors know from compilers, at its place in the suite or in the
    unit: VS Code lists them."""
    lines = []
    for suite in suites:
        for test in suite.tests if not suite.problem else []:
            verdict = suite.verdicts[test.name]
            place = re.match(r"(\S+):(\d+)", verdict.place)
            if not verdict.passed and place:
                reason = " ".join(verdict.reason.split())
                lines.append(f"{place[1]}:{place[2]}:1: error: {test.name}: {reason}\n")
    return "".join(lines)


@_report
def text(suites, impl, colours=False, brief=False):
    """In the format of `make check`: one line per suite, and the next step. What is brief fits on a
    small terminal."""
    lines = []
    for suite in suites:
        word = "ok    " if suite.passed() else "FAIL  "
        if colours:
            word = f"\033[{32 if suite.passed() else 31}m{word}\033[m"
        whose = f"  ({_whose(suite)})" if _whose(suite) else ""
        said = _text_of_prints(suite) if brief else []
        counts = "no claim was checked" if suite.problem and suite.is_own else _counts(suite)
        is_graded = suite.is_own or not suite.not_graded
        if not is_graded:
            word, counts = f"{'-':<{len('FAIL  ')}}", "not graded"
        said.append(f"{word}{suite.feature.stem:<24}{counts}{whose}")
        said += _wrapped(_lost(suite), " " * 6) if _lost(suite) else []
        said += _steps(suite) if brief and not suite.passed() else []
        said += [line for remark in suite.remarks for line in _wrapped(remark, " " * 6)]
        see_all = command_of("check", suite.feature, impl, " ALL=1")
        said += _text_of_failures(suite, brief, see_all) if is_graded else _wrapped(suite.not_graded, " " * 6)
        warnings = suite.warnings.split("\n") if suite.warnings else []
        room = max(4, _SCREEN - len(said)) if brief else 60
        lines += [*_some(warnings, room, f"and {{}} more lines of warnings: {see_all}"), *said]
        if len(suites) == 1 and suite.points() == 100 and suite.passed():
            # A folder of submissions is the grader's: the student has another.
            own = impl if suite.is_own else None
            lines.append(f"      draw it: {command_of('draw', suite.feature, own)}")
            if own and is_handed_out(suite.feature.reference):
                lines.append(f"      hand in {suite.unit.shown}, nothing else")
            if own and os.path.isdir(own):
                begin = command_of("start", suite.feature, own).replace(f"-{suite.feature.stem}", "", 1)
                lines.append(f"      next: {begin}")
    if len(suites) > 1:
        lines.append(f"in all {total(suites)}")
    return "\n".join(lines) + "\n"


def total(suites):
    """Returns "91 of 500 points", and how many were not graded."""
    points, most = sum(suite.points() for suite in suites), sum(suite.points_max() for suite in suites)
    left = sum(bool(suite.not_graded) for suite in suites)
    return f"{points} of {most} points" + (f", {left} not graded" if left else "")


@_report
def first_failed(suites):
    """Returns the claim to work on first, as "STEM: NAME", and why; ("", "") where all hold."""
    for suite in suites:
        for test in suite.tests:
            verdict = suite.verdicts[test.name]
            if not verdict.passed:
                reason = verdict.reason.split("\n")[0]
                if not suite.problem:
                    return f"{suite.feature.stem}: {test.name}", reason
                same = all(other.problem == suite.problem for other in suites)
                return "", reason if same else f"{suite.feature.stem}: {reason}"
    return "", ""


def _next(suite, suites):
    """The claim to work on, and what is known of the units that the suite needs, unless these have all
    points."""
    failed = [test.name for test in suite.tests if not suite.verdicts[test.name].passed]
    if suite.problem or not failed:
        return textwrap.shorten(suite.problem, 80, placeholder=" ...") or _whose(suite) or "done"
    solved = {other.feature.stem for other in suites if other.passed()}
    if not suite.beside or solved.issuperset(suite.feature.needs):
        return failed[0]
    return f"{failed[0]}; {suite.beside}"


@_report
def table(suites, impl):
    """One line for each assignment: the student's progress."""
    name = f"total ({name_of(impl)})"
    width = 2 + max(len(name), *(len(suite.feature.folder) for suite in suites))
    lines = [f"{'assignment':<{width}}{'claims':>10}{'points':>14}  next"]
    for suite in suites:
        passed = f"{sum(suite.verdicts[test.name].passed for test in suite.tests)} of {len(suite.tests)}"
        points = f"{suite.points()} of {suite.points_max()}"
        lines.append(f"{suite.feature.folder:<{width}}{passed:>10}{points:>14}  {_next(suite, suites)}")
    lines.append(f"{name:<{width}}{'':>10}{total(suites).replace(' points', ''):>14}")
    return "\n".join(lines) + "\n"


# --- For machines -------------------------------------------------------------------------------


@_report
def tap(suites, _impl):
    """Test Anything Protocol 12."""
    lines = [f"1..{sum(len(suite.tests) for suite in suites)}"]
    for suite in suites:
        lines += [f"# {suite.feature.stem}: {remark}" for remark in suite.remarks]
        for test in suite.tests:
            word = "ok" if suite.verdicts[test.name].passed else "not ok"
            lines.append(f"{word} {len([l for l in lines if not l.startswith('# ')])} - "
                         f"{suite.feature.stem}: {test.name} ({test.points} points)")
            if word == "not ok":
                lines += [f"# {line}" for line in _explained(suite, test)]
            elif _whose(suite):
                lines.append(f"# {_whose(suite)}")
    return "\n".join(lines) + "\n"


@_report
def junit(suites, impl):
    """JUnit XML, a test case for each claim."""
    import xml.etree.ElementTree as ElementTree  # takes 20 ms, which only this report should pay

    def totals(suites):
        verdicts = [suite.verdicts[test.name] for suite in suites for test in suite.tests]
        return {"tests": str(len(verdicts)), "failures": str(sum(not verdict.passed for verdict in verdicts)),
                "errors": "0", "time": f"{sum(verdict.seconds for verdict in verdicts):.3f}"}

    root = ElementTree.Element("testsuites", name=name_of(impl), **totals(suites))
    for suite in suites:
        element = ElementTree.SubElement(root, "testsuite", name=suite.feature.stem, skipped="0",
                                         **totals([suite]))
        properties = ElementTree.SubElement(element, "properties")
        ElementTree.SubElement(properties, "property", name="points", value=str(suite.points()))
        ElementTree.SubElement(properties, "property", name="points_max", value=str(suite.points_max()))
        for remark in filter(None, [_whose(suite), *suite.remarks]):
            ElementTree.SubElement(properties, "property", name="remark", value=remark)
        for test in suite.tests:
            verdict = suite.verdicts[test.name]
            case = ElementTree.SubElement(
                element, "testcase", classname=f"raykit.{suite.feature.stem}", name=test.name,
                time=f"{verdict.seconds:.3f}",
            )
            if not verdict.passed:
                explained = _explained(suite, test)
                failure = ElementTree.SubElement(case, "failure", message=explained[0])
                once = suite.problem and test is not suite.tests[0]
                failure.text = "\n".join(explained if once else [*explained, "", _details(verdict)])
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


_VISIBILITIES = "hidden", "after_due_date", "after_published", "visible"


def _visibility():
    """Returns what VISIBILITY says: when students see Gradescope's report."""
    return os.environ.get("RAYKIT_VISIBILITY", "")


def check_visibility():
    if _visibility() not in ("", *_VISIBILITIES):
        raise ToolError(f"VISIBILITY={_visibility()}: choose one of {', '.join(_VISIBILITIES)}")


@_report
def gradescope(suites, impl):
    """Gradescope's results.json (its manual, "Autograder Specifications")."""
    tests = []
    for first, suite in enumerate(suites, 1):
        scores = suite.scores()
        if suite.problem:  # an entry of its own: it is no claim's fault
            tests.append({
                "name": f"{suite.feature.stem}: can be graded", "number": f"{first}.0",
                "tags": [suite.feature.stem],
                "score": 0, "max_score": 0, "status": "failed", "output": suite.problem,
            })
        for second, test in enumerate(suite.tests, 1):
            verdict = suite.verdicts[test.name]
            tests.append({
                "name": f"{suite.feature.stem}: {test.name}",
                "number": f"{first}.{second}",
                # Instructors filter by tags.
                "tags": [suite.feature.stem, *([f"step {test.step}"] if test.step else [])],
                "score": scores[test.name],
                "max_score": test.points,
                "status": "passed" if verdict.passed else "failed",
                "output": ("no verdict" if suite.problem else _whose(suite) if verdict.passed else
                           "\n".join(_explained(suite, test))),
            })
    report = {
        "score": sum(suite.points() for suite in suites),
        "execution_time": round(sum(v.seconds for suite in suites for v in suite.verdicts.values())),
        "output": text(suites, impl),
        # Its default is read as HTML, which swallows indentation and <angle brackets>.
        "output_format": "text",
        # The harness's output is for instructors; students read the tests' outputs.
        "stdout_visibility": "hidden",
        **({"visibility": _visibility()} if _visibility() else {}),
        "extra_data": {"assignments": {suite.feature.stem: suite.points() for suite in suites},
                       "not_graded": {suite.feature.stem: suite.not_graded for suite in suites
                                      if suite.not_graded},
                       "seed": sandbox.seed()},
        "tests": tests,
    }
    return json.dumps(report, indent=1) + "\n"


def csv_cell(text):
    """Returns a text as spreadsheets show it: what begins so they take for a formula, and run it. Different
    texts of one line stay different."""
    text = _in_a_line(text)
    return "'" + text if text.startswith(tuple("=+-@＝＋－＠'")) else text


def text_of_cell(cell):
    """Returns the text that csv_cell made this cell of."""
    return cell.removeprefix("'")


FORMATS = {"text": text, "table": table, "tap": tap, "junit": junit, "gradescope": gradescope}


def write_whole(path, content, encoding="utf-8"):
    """Puts a file, a text or bytes, in place when it is complete."""
    folder = os.path.dirname(path) or "."
    try:
        descriptor, part = tempfile.mkstemp(prefix=".part-", dir=folder)
    except OSError as error:
        raise cannot_write(path, error) from error
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode(encoding))
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(part, 0o666 & ~mask)
        os.replace(part, path)
    except BaseException as error:
        os.unlink(part)
        if isinstance(error, OSError):
            raise cannot_write(path, error) from error
        raise


def check_place(path):
    """Raises ToolError unless a file can be made there."""
    folder = os.path.dirname(path or "") or "."
    if not os.path.isdir(folder):
        raise ToolError(f"OUT: there is no folder {folder}; make it first")
    if path and os.path.isdir(path):
        raise ToolError(f"OUT: {path} is a folder; name a file")


def write(suites, format_name, impl, path=None, brief=False):
    """Writes the report in this format to a file, or to standard output."""
    if format_name == "text" and not path:
        # An editor's task asks for lines that it can list.
        listed = problems(suites) if os.environ.get("RAYKIT_PROBLEMS") else ""
        report = listed + text(suites, impl, sys.stdout.isatty(), brief)
    else:
        report = FORMATS[format_name](suites, impl)
    if path:
        write_whole(path, report)
        print(printable(f"grade: {impl}: {total(suites)}; wrote {path}"))
    else:
        sys.stdout.write(report)
