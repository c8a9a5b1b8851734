#!/usr/bin/env python3
"""Compares the units of a class with one another, with the reference and with last year's, and writes
similar.csv, the pairs that have much code in common.

Names, layout, comments, brackets, the order of functions, and whether a loop is for or while, hide nothing;
what students were given counts for nobody. A share is a reason to read two texts, never an accusation: short
answers to the same question look alike, and two who learned from the same page wrote the same.
"""

import collections
import csv
import io
import itertools
import os
import sys

from grade_class import submissions_in
from grading import results
from grading.assignments import (Parser, ToolError, UnitError, cannot_write, check_impl, choose, handed_in,
                                 read_features, run_command)
from grading.fingerprints import Text
from grading.pair_groups import spanning, strongest
from grading.starters import starter_of

# Between what was written apart and copies in disguise: docs/tools.md has the measurement.
SHARE, TOKENS = 0.6, 60  # of the smaller one's own code, if it is so many tokens
PASSAGE = 50  # tokens in a row are as telling: a single function that was copied
_CLASS = 10  # submissions, from which on what more than half of them have counts for nobody
_LARGEST = 200_000  # bytes; ten times the largest reference
_COLUMNS = ["assignment", "submission", "other", "share of the smaller one's own code",
            "tokens that are the same", "lines of the longest passage", "its lines in the other"]
_ADVICE = "a share is a reason to read two texts, never an accusation"

Pair = collections.namedtuple("Pair", "stem one other share tokens lines other_lines")


def _in_folder(variable, folder):
    if not os.path.isdir(folder):
        raise ToolError(f"{variable}: there is no folder {folder}" if folder else
                        "say where the submissions are: make similar SUBMISSIONS=folder OUT=results")
    return submissions_in(folder)[0]


def _read(feature, path, stems):
    """Returns a submission's unit as a Text; raises ToolError with what is wrong with it."""
    if os.path.islink(path):
        raise UnitError("it is a link; a submission is a folder or C file of its own")
    check_impl({feature.stem: feature}, path, stems, may_be_empty=True)
    unit, _ = handed_in(feature, path)
    if os.path.getsize(unit.path) > _LARGEST:
        raise UnitError(f"more than {_LARGEST // 1000} kB")
    with open(unit.path, encoding="utf-8", errors="replace") as file:
        return Text(file.read())


def _read_all(feature, found, stems, prefix=""):
    """Returns {name: Text} of a class, and what cannot be read."""
    texts, unread = {}, []
    for name, path in found.items():
        shown = prefix + results.name_of(name)
        try:
            texts[shown] = _read(feature, path, stems)
        except (ToolError, OSError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            unread.append(f"similar: {feature.stem}: {shown} was not compared: {reason}")
    return texts, unread


def _common(texts, given):
    """Returns what more than half of a class has beside what was given."""
    counts = collections.Counter(gram for text in texts for gram in text.prints - given)
    most = len(texts) / 2 if len(texts) >= _CLASS else len(texts)
    return {gram for gram, count in counts.items() if count > most}


class _Member:
    """A text in a comparison: what of it is its own."""

    def __init__(self, name, text, nobodys):
        self.name, self.text, self.own = name, text, text.prints - nobodys
        self.size, self.rows = text.covered(self.own), text.rows(self.own, PASSAGE)


class Comparison:
    """Pairs of one assignment. `compared` counts those whose texts were laid side by side."""

    def __init__(self, stem):
        self.stem, self.pairs, self.compared = stem, [], 0

    def _lay_side_by_side(self, one, other):
        common, smaller = one.own & other.own, min(one, other, key=lambda member: member.size)
        self.compared += 1
        same = smaller.text.covered(common)
        if same >= max(TOKENS, SHARE * smaller.size) or one.rows & other.rows:
            lines = one.text.longest_passage(other.text, common)
            self.pairs.append(Pair(self.stem, one.name, other.name, same / smaller.size, same, *lines))

    def compare(self, texts, others, nobodys):
        """Adds the pairs of each text with each of the others, or with those before it where others is None.
        An index leads from a fingerprint to all that have it: pairs with little in common cost little."""
        index, known = collections.defaultdict(list), []

        def put(member):
            for gram in (*member.own, *member.rows):
                index[gram].append(len(known))
            known.append(member)

        def in_index(grams):
            return collections.Counter(itertools.chain.from_iterable(index.get(gram, ()) for gram in grams))

        for name, text in (others or {}).items():
            put(_Member(name, text, nobodys))
        for name, text in texts.items():
            member = _Member(name, text, nobodys)
            found = in_index(member.rows)
            for number, count in in_index(member.own).items():
                if number in found or count > SHARE / 2 * min(len(member.own), len(known[number].own)):
                    self._lay_side_by_side(member, known[number])
            if others is None:
                put(member)


def _of_most(stem, texts, given, common):
    """Returns a row for those that would be pairs by what most of a class have, the first of them side by
    side; or None."""
    having = []
    for name, text in texts.items():
        own = text.prints & common
        same, size = text.covered(own), text.covered(text.prints - given)
        if same >= max(TOKENS, SHARE * size) or text.rows(own, PASSAGE):
            having.append((name, text, same, same / size))
    if len(having) < 2:
        return None
    (one, first, same, share), (other, second, _, _) = having[:2]
    lines = first.longest_passage(second, first.prints & second.prints & common)
    who = f"{len(having)} of {len(texts)} submissions, such as {one} and {other}"
    return Pair(stem, who, "one another", share, same, *lines)


def _not_listed(stem, sizes, of_most):
    """Yields a line for each reason why pairs are not listed."""
    for size in sizes:
        yield (f"similar: {stem}: {size} submissions share code, each with at least one other; each is "
               "listed with the one that it shares most with")
    if of_most:
        yield (f"similar: {stem}: {of_most.one}, have the same code, lines {_span(of_most.lines)} of the "
               "first; between submissions it counts for nobody: all were given it, or most copied it")


def compare_class(feature, texts, last_year):
    """Returns the pairs to read of an assignment's units, and lines that say which are not among them."""
    given = Text(starter_of(feature.reference)).prints
    with open(feature.reference, encoding="utf-8") as file:
        reference = Text(file.read())
    common = _common(texts.values(), given)
    # What most have is of interest where it is the reference's: most may have copied it.
    kinds = (None, given | common), ({"the reference": reference}, given), (last_year, given)
    found = []
    for others, nobodys in kinds:
        done = Comparison(feature.stem)
        done.compare(texts, others, nobodys)
        found.append(done.pairs)
    pairs, sizes = spanning(found[0])
    of_most = _of_most(feature.stem, texts, given, common)
    return [*([of_most] if of_most else []), *pairs, *found[1], *strongest(found[2])], _not_listed(
        feature.stem, sizes, of_most)


def _span(lines):
    return "-".join(map(str, lines))


def table(pairs):
    """Returns similar.csv, the largest shares first."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for pair in sorted(pairs, key=lambda pair: (-pair.share, -pair.tokens, pair)):
        writer.writerow([pair.stem, results.csv_cell(pair.one), results.csv_cell(pair.other),
                         f"{pair.share:.2f}", pair.tokens, f"lines {_span(pair.lines)}",
                         f"lines {_span(pair.other_lines)}"])
    return text.getvalue()


def similar(source, asked, submissions, out, last_year):
    """Writes OUT/similar.csv."""
    features = choose(read_features(source), asked)
    found = _in_folder("SUBMISSIONS", submissions)
    before = _in_folder("LASTYEAR", last_year) if last_year else {}
    if not out:
        raise ToolError("say where the results go: OUT=results, a folder")
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise cannot_write(out, error) from error
    pairs, stems, left_out = [], [feature.stem for feature in features], []
    for feature in features:
        texts, unread = _read_all(feature, found, stems)
        if not texts and not asked:
            left_out.append(feature.stem)
            continue
        others, unread_others = _read_all(feature, before, stems, "last year: ")
        of_stem, not_listed = compare_class(feature, texts, others)
        for line in [*unread, *unread_others, *not_listed]:
            print(results.printable(line))
        pairs += of_stem
        print(f"similar: {feature.stem}: {len(texts)} units, {len(of_stem)} pairs to read", flush=True)
    if left_out:
        print(f"similar: no units to compare of {', '.join(left_out)}; ASSIGNMENTS=\"...\" would say why")
    path = os.path.join(out, "similar.csv")
    results.write_whole(path, table(pairs))
    print(f"similar: {len(pairs)} pairs in {path}; {_ADVICE}")


def main():
    parser = Parser(description=__doc__.split("\n\n", maxsplit=1)[0], epilog=_ADVICE.capitalize() + ".")
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: those of the class")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--submissions", required=True, metavar="DIR",
                        help="a folder or C file for each student")
    parser.add_argument("--last-year", default="", metavar="DIR", help="the same of another class")
    parser.add_argument("--out", required=True, metavar="DIR", help="where similar.csv goes")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    return run_command("similar", lambda: similar(arguments.source, arguments.stems, arguments.submissions,
                                                  arguments.out, arguments.last_year), 2)


if __name__ == "__main__":
    sys.exit(main())
