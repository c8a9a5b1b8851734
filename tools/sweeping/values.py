"""The values that VARY walks options through: lists, ranges, and all their combinations."""

import fractions
import itertools
import re
import shlex

from grading.assignments import ToolError

MOST = 9999  # frames have four digits
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?"
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER}):([^:]*)")


def words_of(name, text):
    """Returns the words of a make variable: quotes hold a word together as in the shell, and nothing else
    means anything."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise ToolError(f"{name}: {text}: {str(error).lower()}; each quote needs its other one") from error


def _range(text, ends):
    """Returns the values of from:to:count, both ends included."""
    if not re.fullmatch(r"\d{1,6}", ends[3]) or int(ends[3]) < 2:
        raise ToolError(f"VARY: {text}: a range is from:to:count, such as 2:6:9, with a count of 2 or more: "
                        "both ends belong to it")
    first, last, count = fractions.Fraction(ends[1]), fractions.Fraction(ends[2]), int(ends[3])
    return [f"{float(first + (last - first) * step / (count - 1)):.9g}" for step in range(count)]


def _values(text):
    """Returns the values of one option. A list whose values have commas is separated by semicolons."""
    values = []
    for part in text.split(";" if ";" in text else ","):
        ends = _RANGE.fullmatch(part)
        values += _range(part, ends) if ends else [part]
    return values


def _varied(words):
    """Returns a dictionary from the options' names, without dashes, to their values."""
    varied = {}
    for word in words:
        found = re.fullmatch(r"--([^=]+)=(.+)", word, re.DOTALL)
        if not found:
            raise ToolError(f"VARY: {word}: write --option=values, such as --aperture=10,20,40 or "
                            "--yaw=0:90:10")
        name = found[1]
        if name in varied:
            raise ToolError(f"VARY: --{name} stands there twice; give it all its values in one list")
        varied[name] = _values(found[2])
    if not varied:
        raise ToolError("say which option takes which values: VARY=\"--aperture=10,20,40\"")
    return varied


def frames(vary, options):
    """Returns (names of the varied options, the values of each frame): the last option changes fastest.
    `options` are the words for all frames."""
    varied = _varied(words_of("VARY", vary))
    given = {word.split("=", 1)[0] for word in options}
    for name in varied:
        if f"--{name}" in given:
            raise ToolError(f"--{name} stands in VARY and in OPTIONS; leave it out of one of them")
    if "--out" in given or "out" in varied:
        raise ToolError("--out: the pictures go to the folder OUT=...; leave this option out")
    count = 1
    for values in varied.values():
        count *= len(values)
    if count > MOST:
        raise ToolError(f"VARY: these are {count} combinations; {MOST} are the most, in one folder")
    return list(varied), list(itertools.product(*varied.values()))
