#!/usr/bin/env python3
"""Mutants, read and made, the tables of their pictures, and what their authors hear of slips. Speaks TAP, for
make check-suites."""

import os
import re
import sys
import tempfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from grading.assignments import Feature, ToolError, read_features  # noqa: E402
from grading.c_source import functions_of, tokens_of  # noqa: E402
from grading.mutants import MutantError, mutate, read_mutants  # noqa: E402
from tap import check, finish, read as read_file, start, write  # noqa: E402
from wrong import SEES, read_wrong  # noqa: E402

UNIT = """#include "features/fog.h"

#include <math.h>

/* Fog; in a comment, } and ( mean nothing. */
typedef struct fog {
    float density, height;
} fog;

static const float thin = 0x1p-24;

static float depth_of(const fog *fog, float t);

static float depth_of(const fog *fog, float t)
{
    /* solution */
    if (t < thin)
        return 0; /* too thin */
    return fog->density *
           t;
    /* starter
    // First step: return fog->density * 2;
    end */
}

float fog_at(const fog *fog, float t)
{
    float depth = depth_of(fog, t);
    if (depth <= thin)
        return 0;
    for (int i = 0; i < 3; i++) {
        depth += i;
        depth *= 2;
    }
    return 1 - expf(-depth);
}
"""
HEAD = "mutant thick\nmistake: One.\nfails: a_claim\n"


def read(text):
    """Returns the mutants that are written so."""
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", suffix=".mutants") as file:
        file.write(text)
        file.flush()
        return read_mutants(file.name, "fog.mutants")


def made(changes):
    """Returns the unit with these changes."""
    return mutate(read(HEAD + changes)[0], UNIT, "fog.c")


def code(text):
    return [token.text for token in tokens_of(text)]


def is_made(changes, old, new, name):
    """A mutant's claim: these changes put the new text where the old one is, and leave the rest."""
    assert UNIT.count(old) == 1
    try:
        text = made(changes)
        check(code(text) == code(UNIT.replace(old, new)), name, text)
    except MutantError as error:
        check(False, name, error)


def mutants_are_read():
    got = read("# A comment.\n\n" + HEAD + "in fog_at\n- depth\n+ t\n\n"
               "mutant thin\nmistake: Two\n    lines.\nfails: a b\n  c\nsays: it is\n  twice\n"
               "in struct fog\n- x\n+\n")
    check([mutant.name for mutant in got] == ["thick", "thin"], "blocks come in the file's order", got)
    check(got[1].mistake == "Two lines." and got[1].fails == ["a", "b", "c"], "indented lines go on", got[1])
    check(got[1].says == "it is twice" and got[0].says is None,
          "what the first message says may stand there", got)
    check((got[0].line, got[1].line, got[1].fails_line, got[1].changes[0].line) == (3, 10, 13, 18),
          "each thing knows its line", got)


def mistakes_are_made():
    is_made("in fog_at\n- depth <= thin\n+ depth < thin\n", "depth <= thin", "depth < thin",
            "a text is replaced")
    is_made("in depth_of\n- fog->density*t\n+ t\n", "fog->density *\n           t", "t",
            "line breaks and spaces do not count")
    is_made("in depth_of\n- return 0; return\n+ return\n", "return 0; /* too thin */\n    return", "return",
            "comments do not count")
    is_made("in depth_of\n- if (t < thin) return 0;\n+\n", "if (t < thin)\n        return 0;", "",
            "\"+\" alone removes")
    is_made("in fog_at\n- float depth = depth_of(fog, t);\n"
            "+ float depth = depth_of(fog, t);\n+ if (t > 1) // far\n+     return 1;\n",
            "depth_of(fog, t);", "depth_of(fog, t); if (t > 1) return 1;", "text of several lines is put in")
    is_made("in fog_at\n- for (int i = 0;\n- ...\n- depth *= 2; }\n+ depth = 2;\n",
            UNIT[UNIT.index("    for (int"):UNIT.index("    return 1 -")], "depth = 2;",
            "\"...\" stands for a long passage")
    is_made("in file\n- #include <math.h>\n+ #include <math.h>\n+ #include <stdlib.h>\n",
            "#include <math.h>\n",
            "#include <math.h>\n#include <stdlib.h>\n", "a header is added outside of functions")
    is_made("in struct fog\n- float density\n+ double density\n", "float density", "double density",
            "a struct is a place")
    both = made("in fog_at\n- 1 - expf(-depth)\n+ depth\n- depth += i\n+ depth -= i\n"
                "in depth_of\n- t < thin\n+ t > thin\n")
    check("return depth;" in both and "depth -= i;" in both and "t > thin" in both,
          "several changes make one mistake", both)


def is_refused(text, line, parts, name):
    try:
        got = [mutate(mutant, UNIT, "fog.c") for mutant in read(text)]
        check(False, name, got)
    except MutantError as error:
        check(str(error).startswith(f"fog.mutants:{line}: ") and all(part in str(error) for part in parts),
              name, error)


def slips_in_writing_are_told():
    whole = HEAD + "in fog_at\n- depth <= thin\n+ 1\n"
    is_refused("mutant\n", 1, ["no name"], "a mutant without a name is refused")
    is_refused(whole + whole, 7, ["two mutants thick"], "a name that is taken is refused")
    is_refused(HEAD, 1, ["thick changes nothing", "in FUNCTION"], "a mutant without a change is refused")
    is_refused(whole.replace("mistake: One.\n", ""), 1, ["mistake:"],
               "a mutant without its sentence is refused")
    is_refused(whole.replace("fails: a_claim", "fails:"), 1, ["fails:"],
               "a mutant that fails nothing is refused")
    is_refused(whole.replace("a_claim", "a_claim a_claim"), 3, ["twice"],
               "a test that is named twice is refused")
    is_refused("fails: a_claim\n", 1, ["mutant NAME"], "a line before the first mutant is refused")
    is_refused(HEAD + "fails: another\n", 4, ["remove one"], "a second line of the same kind is refused")
    is_refused(HEAD + "says:\nin fog_at\n- depth <= thin\n+ 1\n", 4, ["says:"],
               "a message of nothing is refused")
    is_refused(HEAD + "Fails: another\n", 4, ["no line of a mutant"], "an unknown line is refused")
    is_refused(HEAD + "- depth\n+ t\n", 4, ["which function"], "a text without a place is refused")
    is_refused(HEAD + "in fog at\n", 4, ["names no place"], "what is no place's name is refused")
    is_refused(HEAD + "in fog_at\n+ t\n", 5, ["instead of none"], "a text instead of none is refused")
    is_refused(HEAD + "in fog_at\n- depth <= thin\n", 5, ["a \"+\" alone"],
               "a text with none instead is refused")
    is_refused(HEAD + "in fog_at\n-\n+ t\n", 5, ["empty"], "an empty text is refused")
    is_refused(HEAD + "in fog_at\n- depth <= thin\n+ depth  <=  thin\n", 5, ["the same"],
               "a change to the same is refused")
    is_refused(HEAD + "in fog_at\n- depth\n  <= thin\n", 6, ["begin it with"],
               "text without its sign is refused")


def slips_in_the_unit_are_told():
    is_refused(HEAD + "in haze_at\n- t\n+ 1\n", 5, ["no function haze_at", "fog.c"],
               "a function that is not there is told")
    is_refused(HEAD + "in enum fog\n- t\n+ 1\n", 5, ["no enum fog"], "an enum that is not there is told")
    is_refused(HEAD + "in fog_at\n- t <\n+ 1\n", 5, ["does not stand in function fog_at"],
               "a text that is not there is told")
    is_refused(HEAD + "in fog_at\n- fog->density\n+ 1\n", 5, ["does not stand"],
               "other functions are not searched")
    is_refused(HEAD + "in depth_of\n- fog->density * 2\n+ 1\n", 5, ["does not stand"],
               "the starter's text is not searched")
    is_refused(HEAD + "in fog_at\n- dept\n+ 1\n", 5, ["does not stand"], "parts of names are not found")
    is_refused(HEAD + "in fog_at\n- depth\n+ 1\n", 5, ["5 times", "lines 28, 29, 32, 33, 35"],
               "a text that stands twice is told, with its lines")
    is_refused(HEAD + "in fog_at\n- depth <= thin\n+ 1\n- if (depth <= thin)\n+ if (0)\n", 5, ["overlaps"],
               "changes that overlap are told")


def functions_are_found():
    tokens = tokens_of(UNIT)
    names = functions_of(tokens)
    check(list(names) == ["depth_of", "fog_at"], "functions are found where they are defined", names)
    begin, end = names["depth_of"]
    check(tokens[begin].text == "static" and tokens[end - 1].text == "}", "from the type to the last brace",
          tokens[begin:end])


# --- Pictures -------------------------------------------------------------------------------------


def table_is_refused(rows, line, part, name):
    """A claim about assignments/01_fog/wrong.tsv with these rows."""
    with tempfile.TemporaryDirectory() as source:
        write("".join("\t".join(row) + "\n" for row in [("mutant", "sees", "options", "caption"), *rows]),
              source, "assignments", "01_fog", "wrong.tsv")
        write(HEAD + "in fog_at\n- depth <= thin\n+ 1\n", source, "tests", "mutants", "fog.mutants")
        try:
            check(False, name, read_wrong(source, Feature(source, "fog", "01_fog", "")))
        except ToolError as error:
            check(str(error).startswith(f"assignments/01_fog/wrong.tsv:{line}: ") and part in str(error),
                  name, error)


def slips_in_tables_of_pictures_are_told():
    row = ("thick", "holes", "--scene cube", "It has holes.")
    table_is_refused([("thin", *row[1:])], 2, "no mutant thin", "a picture of an unknown mutant is refused")
    table_is_refused([row, row], 3, "a picture already", "a second picture of a mutant is refused")
    table_is_refused([("thick", "gaps", *row[2:])], 2, "nobody sees \"gaps\"; choose one of: holes",
                     "what nobody sees is refused")
    table_is_refused([(*row[:3], "It has holes")], 2, "full stop", "a caption that is no sentence is refused")


def pictures_are_shown():
    seen = set()
    for feature in read_features(SOURCE).values():
        try:
            rows = read_wrong(SOURCE, feature)
            shown = f"::: {{.wrong stem={feature.stem}}}" in read_file(SOURCE, feature.chapter)
            check(shown == bool(rows),
                  f"{feature.chapter} shows the wrong pictures of {feature.stem}, if it has any", rows)
            seen.update(row.sees for row in rows)
        except ToolError as error:
            check(False, f"the wrong pictures of {feature.stem} are described", error)
    sections = re.findall(r"::: \{\.wrong sees=\"?([^\"}]*)",
                          read_file(SOURCE, "docs", "92_wrong_pictures.md"))
    check(sections == list(SEES), "all that can be seen has its section, in order", sections)
    check(seen == set(SEES), "and a picture", sorted(seen ^ set(SEES)))


def main():
    mutants_are_read()
    mistakes_are_made()
    slips_in_writing_are_told()
    slips_in_the_unit_are_told()
    functions_are_found()
    slips_in_tables_of_pictures_are_told()
    pictures_are_shown()
    return finish()


if __name__ == "__main__":
    start(main)
