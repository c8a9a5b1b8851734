"""The result of a test in plain words: from a run's outcome to a verdict with its reason.

A test passes only if its program exits with 0 and sends back the secret of this run, which the
suite does after the test's function has returned. A program's printed output proves nothing.
"""

import os
import re
import secrets
import signal


def make_secret(decoy):
    """Returns the secret for one run. An odd first digit asks the suite for a decoy, see tests/suite.c."""
    return (secrets.choice("13579" if decoy else "02468") + secrets.token_hex(24)[1:]).encode()


class Verdict:
    """`reason` is one or two lines, `place` a file and line or "", `details` the whole output. `leak` is
    (reason, place) of memory that a passed test leaked, or None. One that `is_open` is to be run again.
    `seconds` are by the clock, `worked` of processors."""

    def __init__(self, passed, reason="", place="", details="", seconds=0.0):
        self.passed, self.reason, self.place, self.leak = passed, reason, place, None
        self.details, self.seconds, self.timed_out = details, seconds, False
        self.is_open, self.worked = False, 0.0


PRINTED = "\nyour code printed: "

# How the undefined behaviour sanitizer begins its reports, whose places in the text are the program's.
_UNDEFINED = re.compile(
    r"(signed|unsigned) integer overflow: |negation of |division (of|by) |(left )?shift (exponent|of) "
    r"|index -?\d+ out"
    r"|(load|store) (of|to) (null|misaligned|address|value)|load of value |member (access|call) |applying "
    r"|(addition|subtraction) of |pointer index |null pointer |reference binding |call to |passing "
    r"|execution reached |variable length array |assumption of |control flow "
    r"|[-+\w.]{1,60} is outside the range ")
# The sanitizers' terms, and explanations.
_CRASHES = [
    ("stack-overflow", "ran out of stack: endless recursion, or a very large local array?"),
    ("heap-buffer-overflow", "goes beyond the end of allocated memory"),
    ("stack-buffer-overflow", "goes beyond the end of a local array"),
    ("stack-buffer-underflow", "goes before the beginning of a local array"),
    ("dynamic-stack-buffer-overflow", "goes beyond the end of a local array"),
    ("global-buffer-overflow", "goes beyond the end of a constant or static array"),
    ("heap-use-after-free", "uses memory after it was freed"),
    ("stack-use-after-scope", "uses a local variable that no longer exists"),
    ("stack-use-after-return", "uses a local variable of a function that has returned"),
    ("use-after-poison", "looks at a node or a leaf that needs no look, whatever it counts"),
    ("attempting double-free", "frees the same memory twice"),
    ("attempting free on address", "frees memory that was not allocated"),
    ("alloc-dealloc-mismatch", "frees memory in another way than it was allocated"),
    ("negative-size-param", "copies a negative number of bytes"),
    ("param-overlap", "copies between ranges that overlap"),
    ("FPE", "divides an integer by zero"),
    ("ILL", "executed an illegal instruction"),
    ("BUS", "uses memory that does not exist"),
    ("ABRT", "called abort, or an assertion failed"),
]


_TERM = re.compile(r"[a-z]{1,20}(-[a-z]{1,20}){1,3}(?![^ :])")  # another of theirs


def _place_in_unit(text, unit):
    """Returns "file:line, in function" of the innermost place in the unit, with the function of the
    unit that led there, or ""."""
    name = "(?:" + "|".join(re.escape(os.path.basename(path)) for path in (unit.path, unit.shown)) + ")"
    frames = []
    own_frame = rf"^ *#(\d{{1,4}}) 0x[0-9a-f]+ in ([\w.$]{{1,200}}) (?:[^\n]*/)?{name}:(\d{{1,6}})\b"
    for number, function, line in re.findall(own_frame, text, re.MULTILINE):
        if frames and int(number) <= frames[-1][0]:
            break  # another trace
        frames.append((int(number), function, line))
    if not frames:
        return ""
    (_, inner, line), (_, outer, outer_line) = frames[0], frames[-1]
    led = "" if outer == inner else f", on the way from {outer} (line {outer_line})"
    return f"{unit.shown}:{line}, in {inner}{led}"


def _misuse_of_arguments(text, what):
    """Returns what was done to memory that the caller gave, which lies in certain places (RK_JUDGE_PLACE and
    the like of tests/judge/protocol.h) where a judge asks; or ""."""
    if re.match(r"use-after-poison on address 0x0*5[012]0\w{9}\b", what):
        return "goes beyond the end, or before the beginning, of an array that it was given"
    if re.match(r"SEGV on unknown address 0x0*5[02]0\w{9}\b", what) and "caused by a WRITE" in text:
        return ("a write to the caller's data, which is constant: other threads read it at the same time, so "
                "putting it back is too late")
    return ""


def _printed(what):
    """What pretends to be a sanitizer's report is told as what the code says, not as the grader's words."""
    return f"the code ended the program, after it printed \"{what[:200]}\"", ""


_REPORT = re.compile(r"^(.+?):(\d{1,6}):\d+: runtime error: (.+)$|ERROR: AddressSanitizer:? (.*)",
                     re.MULTILINE)


def _crash(text, unit):
    """Returns (reason, place) for a sanitizer's report, or None. A report is the last of its text: what
    stands before, the code itself has printed."""
    reports = list(_REPORT.finditer(text))
    if not reports:
        return None
    path, line, behaviour, crash = reports[-1].groups()
    text, what = text[reports[-1].start():], behaviour or crash
    if behaviour:
        if not _UNDEFINED.match(what):
            return _printed(what)
        if "null pointer" in what:
            what = f"it uses a NULL pointer ({what})"
        elif "insufficient space" in what:
            what = f"it goes beyond the end of the pointer's object ({what})"
        return f"undefined behaviour: {what}", _place_in_unit(text, unit) or f"{path}:{line}"
    given = _misuse_of_arguments(text, what)
    if given:
        return given, _place_in_unit(text, unit)
    term, words = next(((name.split(" on ")[0], words) for name, words in _CRASHES if what.startswith(name)),
                       ("", ""))
    if what.startswith("SEGV"):
        term, null = "SEGV", re.search(r"address 0x0000000000[0-9a-f]{2}\b|zero page", text)
        words = "uses a NULL pointer" if null else "uses a pointer to nowhere"
    other = _TERM.match(what)
    if not words and not other:
        return _printed(what)
    return f"crashed: it {words} ({term})" if words else f"crashed: {other[0]}", _place_in_unit(text, unit)


def printed_lines(output):
    """Returns the lines that the unit printed: those that are neither the suite's nor a sanitizer's."""
    before_reports = re.split(r"^=+\n==\d+==ERROR", output, maxsplit=1, flags=re.MULTILINE)[0]
    return [line for line in before_reports.split("\n")
            if line.strip() and not re.match(r"TAP version \d+$|1\.\.\d+$|ok \d+ - |not ok|# |==\d+==", line)]


def _failed_claim(outcome, name, suite_source):
    """Returns (message, place) of a claim that failed, or None. If a helper of the suite detected it,
    the place is the beginning of the claim."""
    told = re.match(r"([^\n]*):(\d{1,6})\n(.*)", outcome.testimony, re.DOTALL)
    if not told:
        return None
    file, line, message = told.groups()
    printed = [text for text in printed_lines(outcome.output) if text not in message]
    if printed:
        more = f" (and {len(printed) - 3} more lines)" if len(printed) > 3 else ""
        message += PRINTED + " | ".join(text[:100] for text in printed[:3]) + more
    if not file:
        return message, ""
    first, last = _lines_of(name, suite_source)
    if not last:
        return message, f"tests/{os.path.basename(file)}"
    suite = os.path.basename(suite_source)
    is_in_claim = os.path.basename(file) == suite and first <= int(line) <= last
    return message, f"tests/{suite}:{line if is_in_claim else first}"


def _lines_of(name, suite_source):
    """Returns the first and last line of a claim's function, or (0, 0)."""
    try:
        with open(suite_source, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError:
        text = ""
    found = re.search(rf"^static void {re.escape(name)}\(.*?^}}", text, re.DOTALL | re.MULTILINE)
    if not found:
        return 0, 0
    return text.count("\n", 0, found.start()) + 1, text.count("\n", 0, found.end()) + 1


_LIMITS = {
    "memory": "used more than {megabytes} MB of memory, and was stopped",
    "output": "printed megabytes of output, and was stopped: is there a print in a loop?",
    "processes": "started too many processes, and was stopped",
    "stopped": "was stopped before it ended",
}


def judge(outcome, suite, name, limit, megabytes):
    """Returns the Verdict on the run of one test. `limit` is a phrase for its time limit."""
    unit = suite.unit

    def fail(reason, place=""):
        return Verdict(False, reason, place, outcome.output, outcome.seconds)

    text = outcome.output
    if outcome.limit in ("seconds", "call"):
        where, filled = _place_in_unit(text, unit), outcome.occupied >> 20
        # A slow machine takes long to fill memory, so time may be over first.
        reason = (f"did not end within {limit}, and had filled {filled} MB of memory: "
                  "an endless allocation, or a very large one?" if filled > megabytes / 4 else
                  f"did not end within {limit}: an endless loop, or far too slow?")
        verdict = fail(reason, where and f"was at {where}")
        verdict.timed_out = True
        return verdict
    if outcome.limit:
        return fail(_LIMITS[outcome.limit].format(megabytes=megabytes))
    if outcome.status == 0 and outcome.attested:
        verdict = Verdict(True, details=text, seconds=outcome.seconds)
        verdict.leak = _leak(text, unit) if outcome.testimony == "leaks" else None
        return verdict
    crash, claim = _crash(text, unit), _failed_claim(outcome, name, suite.source)
    without = _refused(text, megabytes)
    if claim and outcome.status and not outcome.attested:
        return fail(without + claim[0], claim[1])
    if crash:
        return fail(without + crash[0], crash[1])
    if outcome.status < 0:
        return fail(f"crashed: {_name_of_signal(-outcome.status)}")
    if outcome.attested:
        return fail(f"the test was passed, but then the program ended with exit status {outcome.status}")
    pretends = "; its printed output does not count" if re.search(r"^ok\b", text, re.MULTILINE) else ""
    return fail(
        f"the code ended the program in the middle of the test, with exit status {outcome.status}: does it "
        f"call exit?{pretends}"
    )


def _name_of_signal(number):
    return signal.strsignal(number) if number < signal.NSIG else f"signal {number}"


def _refused(text, megabytes):
    """Returns the beginning of the reason for what fails after an allocation was refused for its size, or
    ""."""
    sizes = [int(size, 16) >> 20
             for size in re.findall(r"Sanitizer failed to allocate 0x([0-9a-f]{1,16}) bytes", text)]
    size = max(sizes, default=0)
    return (f"asks for {size} MB of memory at once, and gets NULL, because {megabytes} MB are allowed; then "
            if size >= megabytes else "")


def _leak(text, unit):
    size = re.search(r"SUMMARY: \w+Sanitizer: (\d{1,15}) byte\(s\) leaked in (\d{1,9}) alloc", text)
    what = f"{size[1]} bytes in {size[2]} allocations were never freed" if size else "not all of it was freed"
    place = _place_in_unit(text, unit)
    return f"leaks memory: {what}", place and f"allocated at {place}"


def judge_leaks(leaks):
    """Returns the Verdict on the memory of a suite's passed tests from the leaks, as (test's name,
    Verdict)."""
    if not leaks:
        return Verdict(True)
    name, verdict = leaks[0]
    reason, place = verdict.leak
    more = f" and in {len(leaks) - 1} more claims" if len(leaks) > 1 else ""
    return Verdict(False, f"{reason}, in {name}{more}", place, verdict.details)


def judge_kept_data(names):
    """Returns the Verdict on variables that last from call to call."""
    if not names:
        return Verdict(True)
    shown = " and ".join(f"`{name}`" for name in names[:3])
    them = "it" if len(names) == 1 else "them"
    return Verdict(False,
                   f"keeps {shown} from call to call, but an answer may depend on its arguments only, and "
                   f"several threads ask at once: make {them} local, or const, and not volatile, if nothing "
                   f"changes {them}")
