"""Does a unit read as its chapter? Prototypes of its static functions are its contents; functions
stand in the order in which the chapter shows them and the handout's steps solve them; and each
starter names the steps that the handout gives to its function."""

import re

ORDINALS = ["First", "Second", "Third", "Fourth", "Fifth", "Sixth", "Seventh", "Eighth", "Ninth"]

# From the first column: what a function returns, its name, its parameters; then its end or its body.
_FUNCTION = re.compile(r"^(?!typedef)(\w[^;{}=()/]*?)(\w+)\(([^;{}]*)\)(?:(;)|\n\{\n(.*?)^\}\n)",
                       re.MULTILINE | re.DOTALL)


def _out_of_order(told, names, teller):
    """Neighbours in `told` that stand the other way round in `names`."""
    return [f"{teller} {first} before {second}, the unit has them the other way round; order them alike"
            for first, second in zip(told, told[1:]) if names.index(first) > names.index(second)]


def _contents(prototypes, static, unit):
    places = zip(prototypes + ["none"], static + ["none"])
    return [f"{unit}: its contents have {listed} where its definitions have {defined}; order them alike"
            for listed, defined in places if listed != defined][:1]


def _shown(chapter, unit, names):
    code = re.findall(rf'\{{\.code file={re.escape(unit)} name=(?:"([^"]*)"|(\w+))', chapter)
    return [name for pair in code for name in "".join(pair).split() if name in names]


def _steps(handout, names):
    """Returns {function: its steps} in the order in which the handout names them first."""
    steps = {}
    for number, text in re.findall(r"^\| (\d+) \|([^|]*)\|", handout, re.MULTILINE):
        for name in re.findall(r"`(\w+)`", text):
            if name in names:
                steps.setdefault(name, []).append(int(number))
    return steps


def find_faults(root, stem, folder):
    """Returns a list of sentences, empty if the unit, its chapter and its handout agree."""
    unit = f"src/features/{stem}.c"
    functions = _FUNCTION.findall((root / unit).read_text(encoding="utf-8"))
    bodies = {name: body for _, name, _, end, body in functions if not end}
    names = list(bodies)
    static = [name for kind, name, _, end, _ in functions if not end and kind.startswith("static")]
    faults = _contents([name for _, name, _, end, _ in functions if end], static, unit)
    shown = _shown((root / "docs" / f"{folder}.md").read_text(encoding="utf-8"), unit, names)
    faults += _out_of_order(shown, names, f"docs/{folder}.md shows")
    handout = f"assignments/{folder}/handout.md"
    steps = _steps((root / handout).read_text(encoding="utf-8"), names)
    open_ones = [name for name in names if "/* solution */" in bodies[name]]
    once = [name for name in steps if len(steps[name]) == 1 and name in open_ones]
    faults += _out_of_order(sorted(once, key=lambda name: (steps[name], names.index(name))), names,
                            f"{handout} solves")
    for name in open_ones:
        said = [ORDINALS.index(word) + 1 for word in re.findall(r"(\w+) step\b", bodies[name]) if word in ORDINALS]
        if said != steps.get(name, []):
            faults.append(f"{unit}: the starter of {name} names the steps {said}, {handout} has {steps.get(name, [])}")
    return faults
