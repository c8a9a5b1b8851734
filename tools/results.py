"""Reports of graded suites: for people (text, table), for test tools (TAP, JUnit XML), and for
Gradescope (results.json). Files are written whole or not at all."""

import json
import os
import re
import sys
import tempfile

_DETAILS_MAX = 10000  # characters of a program's output that go into a report


def _printable(text):
    """XML holds no control characters, and nobody wants them on a terminal."""
    return re.sub(r"[^\t\n\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", text)


def _details(verdict):
    text = _printable(verdict.details)
    if len(text) > _DETAILS_MAX:
        text = text[:_DETAILS_MAX // 2] + "\n[...]\n" + text[-_DETAILS_MAX // 2:]
    return text


def _counts(suite):
    passed = sum(suite.verdicts[test.name].passed for test in suite.tests)
    return f"{passed} of {len(suite.tests)} claims, {suite.points()} of {suite.points_max()} points"


def _read(suite, test):
    return f"read {suite.feature.chapter}{test.section}"


def _explained(suite, test):
    """The reason, the place and where to read, a line each."""
    verdict = suite.verdicts[test.name]
    lines = _printable(verdict.reason).split("\n") + ([verdict.place] if verdict.place else [])
    return lines + [_read(suite, test)]


# --- Text ---------------------------------------------------------------------------------------


def _short(reason, width):
    line = _printable(reason).split("\n")[-1]
    return line if len(line) <= width else line[:width - 3] + "..."


def _text_of_failures(suite):
    failed = [test for test in suite.tests if not suite.verdicts[test.name].passed]
    if not failed:
        return []
    first = failed[0]
    if suite.problem:
        details = _details(suite.verdicts[first.name]).strip().split("\n")
        said = [f"          {line}" for line in details[:20] if line]
        return [f"      {_printable(suite.problem)}", *said]
    lines = [f"      work on this one first: {first.name} ({first.points} points)"]
    lines += [f"          {line}" for line in _explained(suite, first)]
    if len(failed) > 1:
        lines.append("      after that:")
    for test in failed[1:]:
        reason = _short(suite.verdicts[test.name].reason, max(40, 130 - len(test.name)))
        lines.append(f"          {test.name} ({test.points}): {reason}")
    return lines


def _whose(suite):
    if suite.fallback:
        return "  (not there; this is the reference, which earns no points)"
    return "  (this is the reference, which earns no points)" if suite.unit.is_reference else ""


def text(suites, _impl, colours=False):
    """As `make check` speaks: a line for a suite, and what to do next."""
    lines = []
    for suite in suites:
        if suite.warnings:
            lines += _printable(suite.warnings).split("\n")[:60]
        word = "ok    " if suite.passed() else "FAIL  "
        if colours:
            word = f"\033[{32 if suite.passed() else 31}m{word}\033[m"
        lines.append(f"{word}{suite.feature.stem:<24}{_counts(suite)}{_whose(suite)}")
        lines += _text_of_failures(suite)
    if len(suites) > 1:
        lines.append(f"in all {sum(s.points() for s in suites)} of {sum(s.points_max() for s in suites)} points")
    return "\n".join(lines) + "\n"


def table(suites, impl):
    """One line for each assignment: how far a student has come."""
    lines = [f"{'assignment':<24}{'claims':>10}{'points':>12}  next"]
    for suite in suites:
        failed = [test for test in suite.tests if not suite.verdicts[test.name].passed]
        passed = f"{len(suite.tests) - len(failed)} of {len(suite.tests)}"
        points = f"{suite.points()} of {suite.points_max()}"
        following = "done" if not failed else suite.problem or failed[0].name
        lines.append(f"{suite.feature.folder:<24}{passed:>10}{points:>12}  {_short(following, 80)}")
    total = f"{sum(suite.points() for suite in suites)} of {sum(suite.points_max() for suite in suites)}"
    lines.append(f"{'total, ' + impl:<24}{'':>10}{total:>12}")
    return "\n".join(lines) + "\n"


# --- For machines -------------------------------------------------------------------------------


def tap(suites, _impl):
    """Test Anything Protocol 12."""
    lines = [f"1..{sum(len(suite.tests) for suite in suites)}"]
    for suite in suites:
        for test in suite.tests:
            word = "ok" if suite.verdicts[test.name].passed else "not ok"
            lines.append(f"{word} {len([l for l in lines if not l.startswith('# ')])} - "
                         f"{suite.feature.stem}: {test.name} ({test.points} points)")
            if word == "not ok":
                lines += [f"# {line}" for line in _explained(suite, test)]
    return "\n".join(lines) + "\n"


def junit(suites, impl):
    """JUnit XML, a test case for each claim."""
    import xml.etree.ElementTree as ElementTree  # takes 20 ms, which only this report should pay

    root = ElementTree.Element("testsuites", name=impl)
    for suite in suites:
        failures = sum(not suite.verdicts[test.name].passed for test in suite.tests)
        seconds = sum(verdict.seconds for verdict in suite.verdicts.values())
        element = ElementTree.SubElement(
            root, "testsuite", name=suite.feature.stem, tests=str(len(suite.tests)),
            failures=str(failures), errors="0", skipped="0", time=f"{seconds:.3f}",
        )
        properties = ElementTree.SubElement(element, "properties")
        ElementTree.SubElement(properties, "property", name="points", value=str(suite.points()))
        ElementTree.SubElement(properties, "property", name="points_max", value=str(suite.points_max()))
        for test in suite.tests:
            verdict = suite.verdicts[test.name]
            case = ElementTree.SubElement(
                element, "testcase", classname=f"raykit.{suite.feature.stem}", name=test.name,
                time=f"{verdict.seconds:.3f}",
            )
            if not verdict.passed:
                failure = ElementTree.SubElement(case, "failure", message=_printable(verdict.reason))
                failure.text = "\n".join([*_explained(suite, test), "", _details(verdict)])
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def gradescope(suites, impl):
    """Gradescope's results.json (its manual, "Autograder Specifications")."""
    tests = []
    for suite in suites:
        for test in suite.tests:
            verdict = suite.verdicts[test.name]
            tests.append({
                "name": f"{suite.feature.stem}: {test.name}",
                "score": test.points if verdict.passed and not suite.unit.is_reference else 0,
                "max_score": test.points,
                "status": "passed" if verdict.passed else "failed",
                "output": "" if verdict.passed else "\n".join(_explained(suite, test)),
            })
    report = {
        "score": sum(suite.points() for suite in suites),
        "execution_time": round(sum(v.seconds for suite in suites for v in suite.verdicts.values())),
        "output": text(suites, impl),
        # What the harness prints is for instructors; students read the tests' outputs.
        "stdout_visibility": "hidden",
        "tests": tests,
    }
    return json.dumps(report, indent=1) + "\n"


FORMATS = {"text": text, "table": table, "tap": tap, "junit": junit, "gradescope": gradescope}


def write_whole(path, content):
    """Puts a file in place when it is complete."""
    folder = os.path.dirname(path) or "."
    descriptor, part = tempfile.mkstemp(prefix=".part-", dir=folder)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(part, 0o666 & ~mask)
        os.replace(part, path)
    except BaseException:
        os.unlink(part)
        raise


def write(suites, format_name, impl, path=None):
    """Writes the report in this format to a file, or to standard output."""
    if format_name == "text" and not path:
        report = text(suites, impl, sys.stdout.isatty())
    else:
        report = FORMATS[format_name](suites, impl)
    if path:
        write_whole(path, report)
        total = f"{sum(suite.points() for suite in suites)} of {sum(suite.points_max() for suite in suites)}"
        print(f"grade: {impl}: {total} points; wrote {path}")
    else:
        sys.stdout.write(report)
