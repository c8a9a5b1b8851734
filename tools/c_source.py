"""C as far as the proof of the suites reads it: tokens and the functions that they make up."""

import collections
import re

Token = collections.namedtuple("Token", "text start end")

_TOKEN = re.compile(r"""(?P<skipped> \s+ | /\*.*?\*/ | //[^\n]* )
    | \#(?:[^\n/\\]|\\\n|/(?![/*]))*                       # a directive
    | "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])*'
    | \.?[0-9](?:[eEpP][+-]|[\w.])* | [A-Za-z_]\w*
    | \.\.\. | <<= | >>= | -> | \+\+ | -- | << | >> | && | \|\| | [-+*/%&^|<>=!]=
    | .""", re.VERBOSE | re.DOTALL)


def tokens_of(text):
    """Returns the code's tokens with their places in the text. A directive is one token."""
    return [Token(" ".join(match.group().split()) if "#" in match.group() else match.group(), *match.span())
            for match in _TOKEN.finditer(text) if not match.group("skipped")]


def closing(tokens, at):
    """Returns the index of the bracket that closes the one at `at`."""
    depth = 0
    for i in range(at, len(tokens)):
        depth += (tokens[i].text in "([{") - (tokens[i].text in ")]}")
        if depth == 0:
            return i
    return len(tokens) - 1


def functions_of(tokens):
    """Returns {name: (first, end)} of the functions that are defined, as ranges of tokens that begin
    with the type that is returned."""
    functions, begin, at = {}, 0, 0
    while at < len(tokens):
        text = tokens[at].text
        if text == "(" and at > begin:
            after = closing(tokens, at) + 1
            if after < len(tokens) and tokens[after].text == "{":
                end = closing(tokens, after) + 1
                functions[tokens[at - 1].text] = (begin, end)
                begin = at = end
                continue
        if text in "([{":
            at = closing(tokens, at)
        if text == ";" or text[0] == "#":
            begin = at + 1
        at += 1
    return functions
