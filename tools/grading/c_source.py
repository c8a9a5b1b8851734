"""C as far as tools read it: tokens and the functions that they make up."""

import collections
import re

Token = collections.namedtuple("Token", "text start end")

_TOKEN = re.compile(r"""(?P<skipped> \s+ | /\*(?:[^*]|\*(?!/))*(?:\*/|\Z) | //[^\n]* )
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


def _declared(tokens):
    """Yields (name, first, end, whether it has a body) for each function that is declared outside of
    everything; its range of tokens begins with "static" or the type that is returned."""
    begin, at = 0, 0
    while at < len(tokens):
        text, end = tokens[at].text, at + 1
        if text in "([{":
            end = closing(tokens, at) + 1
        after = tokens[end].text if end < len(tokens) else ""
        if text == "(" and after in ("{", ";") and "=" not in [token.text for token in tokens[begin:at]]:
            end = closing(tokens, end) + 1 if after == "{" else end + 1
            yield tokens[at - 1].text, begin, end, after == "{"
            begin = end
        if text == ";" or text[0] == "#":
            begin = end
        at = end


def functions_of(tokens):
    """Returns {name: (first, end)} of the functions that are defined, as ranges of tokens, in the
    file's order."""
    return {name: (begin, end) for name, begin, end, defined in _declared(tokens) if defined}


def prototypes_of(tokens):
    """Returns the same of the functions that are declared only, before or after their definitions."""
    return {name: (begin, end) for name, begin, end, defined in _declared(tokens) if not defined}


def line_of(text, token):
    """Returns the number of the line in which the token begins."""
    return text.count("\n", 0, token.start) + 1
