"""Constants that are volatile, as `static const volatile int k = 5;`. gcc places them among the data, where a
cast could write to them, clang among the constants. Here they go there, too: nothing in them lasts from call
to call, and a unit that writes to one crashes."""

import re

from grading.c_source import closing, tokens_of

_NEAR = 200  # characters before and after "volatile", in which a declaration has its "const"
_SPECIFIERS = 8  # words before and after "static"


def _is_word(tokens, at):
    return 0 <= at < len(tokens) and re.fullmatch(r"[A-Za-z_]\w*", tokens[at].text)


def _behind_brackets(tokens, at):
    return closing(tokens, at) + 1 if tokens[at].text in ("(", "[", "{") else at + 1


def _declared(tokens, at):
    """Returns the variables that a declaration names from here on, and where it ends. A pointer or a function
    ends it."""
    names = []
    while _is_word(tokens, at):
        name, at = tokens[at].text, at + 1
        while at < len(tokens) and tokens[at].text == "[":
            at = _behind_brackets(tokens, at)
        if at < len(tokens) and tokens[at].text == "=":
            while at < len(tokens) and tokens[at].text not in (",", ";"):
                at = _behind_brackets(tokens, at)
        if at >= len(tokens) or tokens[at].text not in (",", ";"):
            break
        names.append(name)
        if tokens[at].text == ";":
            break
        at += 1
    return names, at


def names_in(text):
    """Returns the names of the static variables that are const and volatile, unless others have them, too."""
    if not any("const" in text[max(0, found.start() - _NEAR):found.end() + _NEAR]
               for found in re.finditer(r"\bvolatile\b", text)):
        return set()
    tokens, at, constants, others = tokens_of(text), 0, set(), set()
    while at < len(tokens):
        if tokens[at].text != "static":
            at += 1
            continue
        begin, end = at, at + 1
        while _is_word(tokens, begin - 1) and at - begin < _SPECIFIERS:
            begin -= 1
        while _is_word(tokens, end) and end - at < _SPECIFIERS:
            end += 1
        words = {token.text for token in tokens[begin:end]}
        names, at = _declared(tokens, end - 1) if end - 1 > at else ([], end)
        (constants if {"const", "volatile"} <= words else others).update(names)
        at = max(at, end)
    return constants - others


def place(path, names):
    """Puts these variables among the constants, in a file of assembly where each variable has a section of
    its own (-fdata-sections)."""
    section = rf'^([ \t]*\.section[ \t]+)\.data\.((?:{"|".join(sorted(names))})(?:\.\d+)?),"aw"'
    with open(path, "r+", encoding="utf-8", errors="surrogateescape", newline="") as file:
        placed = re.sub(section, r'\1.rodata.\2,"a"', file.read(), flags=re.MULTILINE)
        file.seek(0)
        file.truncate()
        file.write(placed)
