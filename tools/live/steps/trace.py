"""gdb: follows a unit's functions line by line, and writes what their variables hold after each line.

    UNIT=bvh_median gdb -q -batch -nx -x trace.py bvh_median

writes bvh_median.json, a figure a line, and for each a table for where no scripts run. The unit is as its
author wrote it, compiled with -O0 -g: nothing is added to it, and no part of it is written again."""

import csv
import json
import math
import os
import re

import gdb

# By unit and figure: the functions that are followed, from the first call of the first one to its end, or
# to that of `last`;
# `once`, what is noted at the beginning; `each`, what is noted after each line; `numbered`, the array in
# which a pointer stands for an index; `still`, a part of a line, and what the table shows before each time
# that this is run, or the first few times; NAME:b is in binary. NAME[:COUNT] are the first COUNT entries,
# NAME[:COUNT].M the members M of these.
TRACES = {
    "bvh_median": {
        "selection": {
            "functions": ["select_lowest"],
            "once": {"wanted": "wanted"},
            "each": {"keys": "keys[:count]", "triangles": "(uint32_t)keys[:count]", "begin": "begin",
                     "end": "end", "pivot": "pivot", "boundary": "boundary", "i": "i", "key": "key"},
            "still": ("while (end - begin > few)", ["begin", "end", "keys"]),
        },
        "traversal": {
            "functions": ["rk_bvh_closest", "push_far_return_near", "pop_nearer"],
            "numbered": "bvh->nodes",
            "once": {"nodes": "bvh->nodes[:bvh->node_count]",
                     "triangles": "bvh->triangles[:bvh->triangle_count]", "ray": "*ray"},
            "each": {"node": "node", "next": "next", "near": "near", "far": "far", "enter_near": "enter_near",
                     "enter_far": "enter_far", "stack": "stack.entries[:stack.size]", "hit": "hit",
                     "box_tests": "box_tests", "triangle_tests": "triangle_tests"},
            "still": ("while (node)", ["node", "stack", "hit"]),
        },
    },
    "sah_binning": {
        "bins": {
            "functions": ["candidates_on", "fill_bins", "sweep"],
            "numbered": "&filled[0]",
            "once": {"references": "references[:count]"},
            "each": {"bins": "along.bins", "low": "along.low", "bins_per_unit": "along.bins_per_unit",
                     "filled": "filled[:along.bins]", "i": "i", "bin": "bin", "above": "above[:along.bins]",
                     "k": "k", "below": "below", "boundary": "boundary",
                     "tried": "candidates[:found].boundary", "costs": "candidates[:found].cost"},
            "still": ("if (bins[boundary - 1].count == 0)", ["boundary", "tried", "costs"]),
        },
    },
    "parallelogram_light": {
        "clip": {
            "functions": ["clip_at_horizon"],
            "once": {"corners": "corners[:count]", "n": "n"},
            "each": {"i": "i", "a": "a", "b": "b", "above_a": "above_a", "above_b": "above_b", "at": "at",
                     "left": "left", "kept": "kept[:left]"},
            "still": ("if ((above_a >= 0) != (above_b >= 0))", ["i", "above_a", "above_b", "kept"]),
        },
    },
    "sampling": {
        "owen": {
            "functions": ["rk_owen_scramble"],
            "once": {"bits": "bits", "key": "key"},
            "each": {"digit": "digit", "before": "before", "scrambled": "scrambled"},
            "still": ("scrambled ^= rk_hash(", ["digit", "before:b", "scrambled:032b"], 8),
        },
    },
    "adaptive_sampling": {
        "rounds": {
            "functions": ["rk_adaptive_plan_generation", "keep_samples", "start_generation",
                          "rk_adaptive_plan_second_round", "plan_colour"],
            "last": "rk_adaptive_plan_second_round",
            "once": {"width": "plan->width"},
            "each": {"i": "i", "own": "plan->pilots[:plan->pixels].variance",
                     "variance": "plan->estimates[:plan->pixels].variance",
                     "kept": "plan->is_kept[:plan->pixels]", "has": "plan->samples[:plan->pixels].count",
                     "counts": "plan->counts[:plan->pixels]", "around": "around", "lambda": "lambda",
                     "colour": "colour", "n": "n"},
            "still": ("return is_last", ["lambda", "counts"]),
        },
    },
}

MOST_ENTRIES = 1000  # of an array: more are of a count that is not set yet
MOST_STOPS = 5000  # of a unit that does not end
MOST_EXACT = 2**53  # of a number in JSON


class Unknown(Exception):
    """A variable that is not in scope, or has no value yet."""


class Known:
    """The variables that had a value at the last stop: that of a loop has one again in the loop's line."""

    def __init__(self):
        self.before, self.now = set(), set()

    def next_stop(self):
        self.before, self.now = self.now, set()

    def has(self, frame, symbol):
        line, variable = frame.find_sal().line, (frame.function().name, symbol.name)
        known = symbol.is_argument or line > symbol.line or line == symbol.line and variable in self.before
        if known:
            self.now.add(variable)
        return known


known = Known()


def frame_with(name, functions):
    """Returns the innermost frame of these functions that has the variable, with a value."""
    frame = gdb.newest_frame()
    while frame is not None and frame.function() is not None and frame.function().name in functions:
        symbol = gdb.lookup_symbol(name, frame.block())[0]
        if symbol and symbol.needs_frame and known.has(frame, symbol):
            return frame
        frame = frame.older()
    raise Unknown


def evaluate(text, functions):
    """Returns the value of an expression of C where its first variable is known."""
    frame_with(re.search(r"\w+", re.sub(r"\(\w+\)", "", text)).group(), functions).select()
    return gdb.parse_and_eval(text)


def plain(value, numbered):
    """Returns a value as JSON has it."""
    kind = value.type.strip_typedefs()
    if kind.code == gdb.TYPE_CODE_STRUCT:
        return {field.name: plain(value[field.name], numbered) for field in kind.fields()}
    if kind.code == gdb.TYPE_CODE_ARRAY:
        return [plain(value[k], numbered) for k in range(kind.range()[1] + 1)]
    if kind.code == gdb.TYPE_CODE_PTR:
        return int(value - numbered) if numbered is not None and int(value) != 0 else None
    if kind.code == gdb.TYPE_CODE_FLT:
        number = float(value)
        if not math.isfinite(number):
            return str(number)
        return float(f"{number:.9g}") if kind.sizeof == 4 else number
    return int(value)


arrays = {}  # by their expression: the bytes that were there, and their values


def plain_entries(text, entries, kind, member, numbered):
    """Returns the entries of an array, or a member of each; most are as they were at the stop before."""
    memory = gdb.selected_inferior().read_memory(int(entries.address), entries.type.sizeof).tobytes()
    key = memory, numbered is None
    if arrays.get(text, [None])[0] != key:
        values = [entries[k][member] if member else entries[k] for k in range(entries.type.range()[1] + 1)]
        values = [value.cast(gdb.lookup_type(kind)) if kind else value for value in values]
        arrays[text] = key, [plain(value, numbered) for value in values]
    return arrays[text][1]


def noted(text, trace):
    """Returns the value of an expression, or of an array's first entries; None where it has none yet."""
    functions, numbered = trace["functions"], trace.get("numbered")
    try:
        base = evaluate(numbered, functions) if numbered else None
    except Unknown:
        base = None
    try:
        array = re.fullmatch(r"(?:\((\w+)\))?(.*)\[:(.*)\](?:\.(\w+))?", text)
        if not array:
            return plain(evaluate(text, functions), base)
        kind, name, count, member = array.groups()
        count = int(evaluate(count, functions))
        if not 0 < count <= MOST_ENTRIES:
            return [] if count == 0 else None
        entries = evaluate(f"*{name}@{count}", functions)
        return plain_entries(text, entries, kind, member, base)
    except (Unknown, gdb.MemoryError):
        return None


def function(name):
    """Returns the unit's function of this name."""
    symbol = gdb.lookup_global_symbol(name) or gdb.lookup_static_symbol(name)
    if symbol is None:
        raise gdb.GdbError(f"the unit has no function {name}")
    return symbol


def stop_at_lines(functions):
    """Returns new breakpoints at the beginning of each line of the functions."""
    breakpoints = []
    for name in functions:
        symbol = function(name)
        block = gdb.block_for_pc(int(symbol.value().address))
        for entry in symbol.symtab.linetable():
            if block.start < entry.pc < block.end:
                breakpoints.append(gdb.Breakpoint(f"*{entry.pc}", internal=True))
    return breakpoints


def follow(trace, out):
    """Runs the program, whose output goes to a file; returns the unit's file, what was noted once, and for
    each stop the function, the line, and what was noted before it is run."""
    gdb.execute("tbreak " + trace["functions"][0], to_string=True)
    gdb.execute(f"run >'{out}'", to_string=True)
    file = gdb.newest_frame().find_sal().symtab.filename
    breakpoints = stop_at_lines(trace["functions"])
    once = {name: noted(text, trace) for name, text in trace["once"].items()}
    last, caller, stops = trace.get("last", trace["functions"][0]), None, []
    while caller is None or gdb.newest_frame().pc() != caller:
        frame = gdb.newest_frame()
        if frame.function().name == last and caller is None:
            caller = frame.older().pc()
            breakpoints.append(gdb.Breakpoint(f"*{caller}", internal=True))
        known.next_stop()
        values = {name: noted(text, trace) for name, text in trace["each"].items()}
        stops.append((frame.function().name, frame.find_sal().line, values))
        if len(stops) == MOST_STOPS:
            raise gdb.GdbError(f"{last} has run {MOST_STOPS} lines; does it end?")
        gdb.execute("continue", to_string=True)
    for point in breakpoints:
        point.delete()
    gdb.execute("continue", to_string=True)
    return file, once, stops


def steps_of(stops):
    """Returns for each line that was run the function, the line, and what is noted at the next stop."""
    steps = []
    for (name, line, _), (_, _, after) in zip(stops, stops[1:]):
        if steps and steps[-1][:2] == (name, line):
            steps.pop()
        steps.append((name, line, after))
    return steps


def with_ranks(value, ranks):
    """Returns a value in which numbers that are too large for JSON are replaced by their ranks."""
    if isinstance(value, list):
        return [with_ranks(entry, ranks) for entry in value]
    return ranks.get(value, value) if isinstance(value, int) else value


def large_in(value):
    """Yields the numbers in a value that are too large for JSON."""
    if isinstance(value, list):
        for entry in value:
            yield from large_in(entry)
    elif isinstance(value, int) and value > MOST_EXACT:
        yield value


def changes(before, after):
    """Returns what differs from the step before; NAME@K is entry K of an array."""
    changed = {}
    for name, value in after.items():
        old = before.get(name)
        if isinstance(value, list) and isinstance(old, list) and len(value) == len(old):
            entries = {f"{name}@{k}": entry for k, entry in enumerate(value) if entry != old[k]}
            changed.update(entries if 2 * len(entries) <= len(value) else {name: value})
        elif value != old:
            changed[name] = value
    return changed


def update(state, changed):
    """Changes a state by what differs."""
    for name, value in changed.items():
        name, _, k = name.partition("@")
        state[name] = [*state[name][:int(k)], value, *state[name][int(k) + 1:]] if k else value


def trace_of(trace, out):
    """Returns what a figure shows: the file, what is noted once, at the beginning and after each line, and
    what the program got by the unit."""
    file, once, stops = follow(trace, out)
    steps = steps_of(stops)
    states = [once, stops[0][2], *(after for _, _, after in steps)]
    large = sorted({number for state in states for part in state.values() for number in large_in(part)})
    ranks = {number: rank for rank, number in enumerate(large, 1)}
    once, begin, *after = ({name: with_ranks(part, ranks) for name, part in state.items()}
                           for state in states)
    with open(out, encoding="utf-8") as said:
        result = json.load(said)
    changed = [[name, line, changes(before, now)]
               for (name, line, _), before, now in zip(steps, [begin, *after], after)]
    return {"file": re.sub(r".*(?=src/)", "", file), "once": once, "begin": begin, "steps": changed,
            "result": result}


def brief(value, form=""):
    """Returns a value as a cell of a table."""
    if form and value is not None:
        return format(value, form)
    if isinstance(value, dict):
        return ", ".join(f"{name} {brief(part)}" for name, part in value.items())
    if isinstance(value, list):
        return ("; " if value and isinstance(value[0], dict) else " ").join(brief(entry) for entry in value)
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def write_table(trace, shown, source, path):
    """Writes the states before a line is run, each time."""
    part, names, *most = trace["still"]
    forms = [name.partition(":")[::2] for name in names]
    state, rows = dict(shown["begin"]), []
    for _, line, changed in shown["steps"]:
        if part in source[line - 1]:
            rows.append([brief(state[name], form) for name, form in forms])
        update(state, changed)
    rows = rows[:most[0]] if most else rows
    end = [brief(state[name], form) for name, form in forms]
    if any(end) and rows[-1:] != [end]:
        rows.append(end)
    with open(path, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([[name for name, _ in forms], *rows])


def main():
    unit = os.environ["UNIT"]
    for setting in ("confirm off", "pagination off", "breakpoint pending off", "startup-with-shell on",
                    "breakpoint always-inserted on"):
        gdb.execute("set " + setting)
    shown = {name: trace_of(trace, f"{unit}.said") for name, trace in TRACES[unit].items()}
    os.remove(f"{unit}.said")
    for name, trace in TRACES[unit].items():
        with open(function(trace["functions"][0]).symtab.fullname(), encoding="utf-8") as file:
            write_table(trace, shown[name], file.read().split("\n"), f"{unit}.{name}.csv")
    lines = (f'"{name}":' + json.dumps(figure, separators=(",", ":")) for name, figure in shown.items())
    with open(f"{unit}.json", "w", encoding="utf-8") as file:
        file.write("{\n" + ",\n".join(lines) + "\n}\n")


main()
