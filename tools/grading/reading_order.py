"""Does a unit read as its chapter? Prototypes of its static functions are its contents, at the top
and in the order of the definitions. These stand in the order in which the chapter shows them and the
handout's steps solve them, and each starter names the steps that the handout gives to its function.
"""

import re

from grading.c_source import functions_of, line_of, prototypes_of, tokens_of
from grading.starters import ORDINALS


class _Unit:
    """A unit's text, and the lines of what it declares."""

    def __init__(self, root, name):
        self.name, self.text = name, (root / name).read_text(encoding="utf-8")
        self.tokens = tokens_of(self.text)
        self.functions = functions_of(self.tokens)
        self.prototypes = self._static(prototypes_of(self.tokens))
        self.lines = {name: self._line(span) for name, span in self.functions.items()}
        self.prototype_lines = {name: self._line(span) for name, span in self.prototypes.items()}

    def _line(self, span):
        return line_of(self.text, self.tokens[span[0]])

    def _static(self, declared):
        return {name: span for name, span in declared.items() if self.tokens[span[0]].text == "static"}

    def static_functions(self):
        return list(self._static(self.functions))

    def body(self, name):
        """Returns the function's text with its comments."""
        begin, end = self.functions[name]
        return self.text[self.tokens[begin].start:self.tokens[end - 1].end]

    def to_solve(self):
        return [name for name in self.functions if "/* solution */" in self.body(name)]


def _contents(unit):
    static, top = unit.static_functions(), min(unit.lines.values())
    faults = [f"{unit.name}:{unit.lines[name]}: {name} has no prototype in the contents at the top; "
              "write it there"
              for name in static if name not in unit.prototypes]
    for name, line in unit.prototype_lines.items():
        if name not in static:
            faults.append(f"{unit.name}:{line}: {name} has a prototype only; remove it")
        elif line > top:
            faults.append(f"{unit.name}:{line}: the prototype of {name} stands below the first definition; "
                          "put it above")
    listed = [name for name in unit.prototypes if name in static]
    return faults + [f"{unit.name}:{unit.prototype_lines[second]}: the contents have {second} below {first}, "
                     f"but it is defined above it, in line {unit.lines[second]}; order them alike"
                     for first, second in zip(listed, listed[1:]) if unit.lines[first] > unit.lines[second]]


def _shown(chapter, unit):
    """Returns {function: the chapter's line} in the order in which the chapter shows them first."""
    shown = {}
    for number, line in enumerate(chapter.split("\n"), 1):
        for names in re.findall(rf'\{{\.code file={re.escape(unit.name)} name=("[^"]*"|\w+)', line):
            for name in names.strip('"').split():
                if name in unit.functions:
                    shown.setdefault(name, number)
    return shown


def _as_shown(root, chapter, unit):
    shown = _shown((root / chapter).read_text(encoding="utf-8"), unit)
    names = list(shown)
    return [f"{chapter}:{shown[second]}: {second} is shown after {first}, but stands above it in {unit.name}:"
            f"{unit.lines[second]}; order them alike"
            for first, second in zip(names, names[1:]) if unit.lines[first] > unit.lines[second]]


def _steps(handout, unit):
    """Returns {function: the numbers of its steps}."""
    steps = {}
    for number, text in re.findall(r"^\| (\d+) \|([^|]*)\|", handout, re.MULTILINE):
        for name in re.findall(r"`(\w+)`", text):
            if name in unit.functions:
                steps.setdefault(name, []).append(int(number))
    return steps


def _as_solved(handout, steps, unit):
    """A function that several steps work on stands where one of them is due."""
    faults, due, last = [], 0, ""
    for name in unit.to_solve():
        later = [step for step in steps.get(name, []) if step >= due]
        if later:
            due, last = min(later), name
        elif name in steps:
            faults.append(f"{unit.name}:{unit.lines[name]}: {name} of step {max(steps[name])} in {handout} "
                          f"stands below {last} of step {due}; order the functions or the steps alike")
    return faults


def _starters(handout, steps, unit):
    faults = []
    for name in unit.to_solve():
        words = re.findall(r"(\w+) step\b", unit.body(name))
        said = [ORDINALS.index(word) + 1 for word in words if word in ORDINALS]
        if said != steps.get(name, []):
            faults.append(f"{unit.name}:{unit.lines[name]}: the starter of {name} names the steps {said}, "
                          f"{handout} has {steps.get(name, [])}; number them alike")
    return faults


def find_faults(root, stem, folder):
    """Returns a list of sentences with file and line, empty if the unit, its chapter and its handout
    agree."""
    unit = _Unit(root, f"src/features/{stem}.c")
    handout = f"assignments/{folder}/handout.md"
    steps = _steps((root / handout).read_text(encoding="utf-8"), unit)
    return [*_contents(unit), *_as_shown(root, f"docs/{folder}.md", unit), *_as_solved(handout, steps, unit),
            *_starters(handout, steps, unit)]
