"""What grading has found out: a file for each assignment and submission, RESULTS/verdicts/STEM/NAME.json,
with the key of all that it depends on. What has its key already is not graded again; files that several
machines wrote are one class."""

import hashlib
import json
import os
import time

from grading import judged
from grading import private_copy
from grading import results
from grading import sandbox
from grading import verdict_store
from grading.starters import is_starter

_LONGEST = 200  # bytes of a name that files begin with; systems take 255


def file_name(name):
    """Returns how the files of a submission are called, without an ending."""
    data = os.fsencode(name)
    if len(data) <= _LONGEST:
        return name
    return os.fsdecode(data[:_LONGEST]) + "-" + hashlib.sha256(data).hexdigest()[:8]


def path_of(out, stem, name):
    return os.path.join(out, "verdicts", stem, file_name(name) + ".json")


def kit_digest(toolchain, features, folder, seconds):
    """Returns the Digest of what all verdicts depend on: the kit's copy in this folder, the grader, the
    compiler, and how units are run."""
    digest = verdict_store.Digest()
    tools = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    copied = private_copy.kit_in(folder, toolchain)
    of_suites = {os.path.join(copied.source, "tests", name)
                 for name in private_copy.sources_of_suites(features)}
    of_suites |= {os.path.join(copied.build, name) for stem in features
                  for name in [f"tests/test_{stem}.o", *judged.files(stem)]}
    for top in (copied.source, copied.build, tools):
        for where, folders, names in os.walk(top):
            folders.sort()
            for path in sorted(os.path.join(where, name) for name in names):
                if path not in of_suites and (top != tools or path.endswith(".py")):
                    digest.add_file(os.path.relpath(path, top), path)
    flags = [word.replace(toolchain.source, "SOURCE") for word in toolchain.flags]
    for name, words in {"compiler": toolchain.compiler, "flags": flags, "sanitize": toolchain.sanitize,
                        "fill": toolchain.fill,
                        "link": [*toolchain.grade_link, *toolchain.link_flags], "seed": [sandbox.seed()],
                        "way": [toolchain.remark], "seconds": [str(seconds)]}.items():
        digest.add(name, "\0".join(words))
    verdict_store.add_compiler(digest, toolchain.compiler[0])
    verdict_store.add_machine(digest)
    return digest


def key_of(digest, toolchain, suite):
    """Returns the key of a suite's verdicts, as text."""
    digest, stem = digest.copy(), suite.feature.stem
    copied = private_copy.kit_in(toolchain.kit_copy, toolchain)
    for name in private_copy.objects_of_suites(copied, [stem]):
        digest.add_file(name, copied.built(name))
    digest.add_file("suite", os.path.join(copied.source, "tests", f"test_{stem}.c"))
    digest.add("assignment", stem)
    digest.add_file("points", suite.feature.points_table)
    digest.add("remarks", json.dumps([suite.remarks, suite.unit.shown, suite.unit.is_reference]))
    digest.add_file("unit", suite.unit.path)
    for name in private_copy.own_headers(suite.unit):
        digest.add_file(name, os.path.join(os.path.dirname(suite.unit.path), name))
    return digest.text()


def _claims(suite):
    scores = suite.scores()
    for test in suite.tests:
        verdict = suite.verdicts[test.name]
        yield {"name": test.name, "step": test.step, "points": test.points, "score": scores[test.name],
               "passed": verdict.passed, "reason": verdict.reason, "place": verdict.place}


def _is_starter(suite):
    return bool(suite.unit.path) and not suite.not_graded and is_starter(suite.unit)


def write(out, name, suite, key, notes):
    """Writes what a graded suite found, with notes for the instructor, and returns it."""
    first, reason = results.first_failed([suite])
    found = {
        "submission": results.name_of(name), "assignment": suite.feature.stem, "key": key,
        "graded": time.strftime("%Y-%m-%d %H:%M:%S %z"), "not_graded": suite.not_graded,
        "points": suite.points(), "maximum": suite.points_max(), "passed": suite.passed(),
        "problem": suite.problem, "first": first, "reason": reason, "notes": notes,
        "seconds": round(sum(verdict.worked for verdict in suite.verdicts.values()), 2),
        "is_starter": _is_starter(suite), "claims": list(_claims(suite)),
        "judged": suite.judged(),
    }
    path = path_of(out, suite.feature.stem, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    results.write_whole(path, json.dumps(found, indent=1) + "\n")
    return found


def read(out, stem, name):
    """Returns what was found before, or None."""
    return read_file(path_of(out, stem, name))


def read_file(path):
    """The same of a file."""
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        return found if isinstance(found, dict) and "judged" in found else None
    except (OSError, ValueError):
        return None
