"""What the last check of one's own work has found first, in impl/checked of the build folder: hints are
marked by it. Nothing else reads it."""

import hashlib
import json
import os

from grading.assignments import UnitError, submitted_unit


def _path(build, feature):
    return os.path.join(build, "impl", "checked", feature.stem + ".json")


def state_of(feature, impl):
    """Returns a hash of the unit, None if there is none to check."""
    try:
        path = submitted_unit(feature, impl).path
        with open(path, "rb") as file:
            return hashlib.sha256(os.fsencode(os.path.abspath(path)) + file.read()).hexdigest()
    except (OSError, UnitError, TypeError):
        return None


def write(build, suite, state):
    """Keeps the first claim that failed, of a check of all claims with the unit in this state."""
    failed = next((test for test in suite.tests if not suite.verdicts[test.name].passed), None)
    path = _path(build, suite.feature)
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"unit": state, "claim": failed.name if failed else "",
                       "step": str(failed.step) if failed else ""}, file)
    except OSError:
        pass  # hints are then listed without a mark


def read(build, feature, impl):
    """Returns the claim that failed first and its step, both "" if all held, or None if this state of the
    unit was not checked."""
    try:
        with open(_path(build, feature), encoding="utf-8") as file:
            kept = json.load(file)
        if kept["unit"] == state_of(feature, impl):
            return kept["claim"], kept["step"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return None
