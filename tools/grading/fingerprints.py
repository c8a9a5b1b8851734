"""Which code two C texts have in common, whatever its names, layout and order.

A text becomes a row of tokens without what costs nothing to change: comments, types and qualifiers,
brackets, names of its own, the place of a loop's step. Each run of GRAM tokens is a fingerprint: Schleimer,
Wilkerson and Aiken, "Winnowing: local algorithms for document fingerprinting", SIGMOD 2003. Units are so
short that all are kept, none winnowed.
"""

import bisect
import itertools
import re
import zlib

from grading.c_source import functions_of, prototypes_of, tokens_of

GRAM = 10  # tokens
_LONGEST_HEADING = 400  # of a loop, in tokens
_PLACES = 16  # of one fingerprint in one text
_QUALIFIERS = {"const", "static", "inline", "register", "extern", "volatile", "restrict", "auto"}
_TYPES = {"int", "float", "double", "unsigned", "signed", "long", "short", "char", "bool", "_Bool", "struct",
          "union", "enum"}
_KEYWORDS = {"if", "else", "while", "for", "do", "return", "break", "continue", "goto", "switch", "case",
             "default", "sizeof", "typedef", "void"}
_DROPPED = _QUALIFIERS | _TYPES | {"(", ")", "{", "}", ";"}
_NAME = re.compile(r"[A-Za-z_]\w*")


def _own_names(tokens):
    """Names that the text itself gives, which a copy may change: functions, macros, members of structures."""
    names, end = {*functions_of(tokens), *prototypes_of(tokens)}, 0
    for at, token in enumerate(tokens):
        if token.text.startswith("#"):
            names.update(re.findall(r"^# ?define (\w+)", token.text))
        elif at >= end and token.text in ("struct", "union"):
            if "{" in [inner.text for inner in tokens[at + 1:at + 3]]:
                end = next((i for i in range(at, len(tokens)) if tokens[i].text == "}"), len(tokens))
                names.update(inner.text for inner in tokens[at:end])
    return names


def _number(text):
    """1, 1u, 1.0f and 1. are the same."""
    text = text.lower()
    text = text.rstrip("ul") if text.startswith("0x") else text.rstrip("ulf")
    try:
        return repr(float(text))
    except ValueError:
        return text


def _heading(tokens, at):
    """Returns the three parts in the brackets of a for, and where these end; None for what is none."""
    parts, depth = [[]], 0
    for end in range(at + 1, min(at + _LONGEST_HEADING, len(tokens))):
        text = tokens[end].text
        depth += (text in "([{") - (text in ")]}")
        if depth == 0:
            return (parts, end) if len(parts) == 3 else None
        if text == ";" and depth == 1:
            parts.append([])
        elif end > at + 1:
            parts[-1].append(tokens[end])
    return None


def _without_for(tokens):
    """Loops as while would have them, without the step's place."""
    at = 0
    while at < len(tokens):
        heading = _heading(tokens, at) if tokens[at].text == "for" else None
        if heading:
            (before, condition, step), end = heading
            mark, word = tokens[at]._replace(text=";"), tokens[at]._replace(text="while")
            yield from [*before, mark, word, *(condition or [word._replace(text="1")]), mark, *step, mark]
            at = end
        else:
            yield tokens[at]
        at += 1


def _statements(tokens):
    """Ranges of tokens between what begins or ends a statement or a block."""
    begin = 0
    for at, token in enumerate(tokens):
        if token.text in ("{", "}", ";"):
            yield begin, at
            begin = at + 1
    yield begin, len(tokens)


def _is_idle(words):
    """A declaration without a value, or one step of a counter."""
    return set(words) <= {"V", ",", "*", "++", "--"} or words in (["V", "+=", "1.0"], ["V", "-=", "1.0"],
                                                                  ["V", "=", "V", "+", "1.0"])


def _word(tokens, at, own):
    """What stands for a token; "" for what is left out."""
    text, before = tokens[at].text, tokens[at - 1].text if at else ""
    after = tokens[at + 1].text if at + 1 < len(tokens) else ""
    if text in _DROPPED or text.startswith("#") or text.endswith("_t") and before != ".":
        return ""
    if text in _KEYWORDS or text.startswith(("rk_", "RK_")):
        return text
    if _NAME.fullmatch(text):
        return text if text not in own and (before in (".", "->") or after == "(") else "V"
    if text[0].isdigit() or text[0] == "." and text[1:2].isdigit():
        return _number(text)
    return "." if text == "->" else "S" if text[0] == '"' else text


class Text:
    """A C text as a row of letters, one for each token that counts."""

    def __init__(self, text):
        tokens = tokens_of(text)
        own, places, letters = _own_names(tokens), [], []
        tokens = list(_without_for(tokens))
        words = [_word(tokens, at, own) for at in range(len(tokens))]
        for begin, end in _statements(tokens):
            kept = [at for at in range(begin, end) if words[at]]
            if not _is_idle([words[at] for at in kept]):
                letters += [chr(1 + zlib.crc32(words[at].encode("utf-8", "replace")) % 1000000)
                            for at in kept]
                places += [tokens[at].start for at in kept]
        self._letters, self._places = "".join(letters), {}
        for at in range(len(letters) - GRAM + 1):
            self._places.setdefault(self._letters[at:at + GRAM], []).append(at)
        self._lines, self.prints = _lines(text, places), frozenset(self._places)

    def _places_of(self, prints):
        return sorted(itertools.chain.from_iterable(self._places[gram] for gram in prints))

    def covered(self, prints):
        """Returns how many tokens stand in at least one of these fingerprints of the text."""
        count, end = 0, -GRAM
        for at in self._places_of(prints):
            count += min(GRAM, at + GRAM - end)
            end = at + GRAM
        return count

    def rows(self, prints, length):
        """Returns each row of so many tokens all of whose fingerprints are among these, as one long one."""
        rows, begin, end = set(), 0, -GRAM
        for at in self._places_of(prints):
            begin, end = at if at > end - GRAM + 1 else begin, at + GRAM
            if end - begin >= length:
                rows.add(self._letters[end - length:end])
        return rows

    def longest_passage(self, other, prints):
        """Returns the lines, here and there, of the longest row of these fingerprints that both have:
        ((first, last), (first, last))."""
        best, runs, before = (0, 0, 0), {}, None
        grams = {at: gram for gram in prints for at in self._places[gram]}
        for at in sorted(grams):
            runs = runs if before == at - 1 else {}
            runs = {there: runs.get(there - 1, 0) + 1 for there in other._places[grams[at]][:_PLACES]}
            best, before = max(best, *((length, at, there) for there, length in runs.items())), at
        length, at, there = best
        return tuple((text._lines[end - length + 1], text._lines[end + GRAM - 1])
                     for text, end in ((self, at), (other, there)))


def _lines(text, places):
    """Returns the numbers of the lines of these places."""
    ends = [match.start() for match in re.finditer("\n", text)]
    return [1 + bisect.bisect_left(ends, place) for place in places]
