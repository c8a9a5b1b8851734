"""Copies of a C text as somebody makes them who hopes that nobody sees it: the same code in other clothes."""

import random
import re

from grading.c_source import closing, functions_of, tokens_of

_TYPES = {"int", "float", "double", "size_t", "uint32_t", "uint64_t", "bool", "rk_vec3", "rk_box", "rk_ray"}
_WORDS = re.compile(r"if|else|while|for|do|return|break|continue|goto|switch|case|default|sizeof|typedef|void"
                    r"|const|static|inline|restrict|struct|enum|union|unsigned|signed|long|short|char"
                    r"|NULL|true|false|rk_\w+|RK_\w+|\w+_t")
_STEPS = {"++", "--"}


def _texts(code):
    return [token.text for token in tokens_of(code)]


def _laid_out(texts, rng):
    """Lines break anywhere but in directives; here and there is a comment."""
    lines = "".join(f"\n{text}\n" if text.startswith("#") else text + rng.choice([" ", " ", " ", "\n", "  "])
                    for text in texts)
    return "/* all my own work */\n" + lines + "\n"


def renamed(texts, rng):
    """Other names for locals and for functions that are no one else's."""
    names, members = {}, {text for before, text in zip(texts, texts[1:]) if before in (".", "->")}
    for before, text, after in zip(["", *texts], texts, [*texts[1:], ""]):
        is_name = re.fullmatch(r"[A-Za-z_]\w*", text) and not _WORDS.fullmatch(text) and text not in _TYPES
        if (is_name and text not in members and before not in (".", "->")
                and after in ("=", ",", ")", ";", "[", "++", "--")):
            names.setdefault(text, f"my_{rng.randrange(10 ** 6)}")
    for name in functions_of(tokens_of(" ".join(texts))):
        if not name.startswith("rk_"):
            names.setdefault(name, f"do_{rng.randrange(10 ** 6)}")
    return [names.get(text, text) if before not in (".", "->") else text
            for before, text in zip(["", *texts], texts)]


def functions_reordered(texts, rng):
    """Functions in another order, all behind what comes before the first."""
    tokens = tokens_of("\n".join(texts))
    ranges = list(functions_of(tokens).values())
    taken = {at for begin, end in ranges for at in range(begin, end)}
    rng.shuffle(ranges)
    return [texts[at] for at in range(len(texts)) if at not in taken] + [
        text for begin, end in ranges for text in texts[begin:end]]


def statements_swapped(texts, rng):
    """Half of the simple statements that can change places with the next one do."""
    parts, part, depth = [], [], 0
    for text in texts:
        part.append(text)
        depth += (text in "([") - (text in ")]")
        if depth == 0 and text in ("{", "}", ";") or text.startswith("#"):
            parts.append(part)
            part = []
    parts.append(part)
    simple = [part and part[-1] == ";" and not {"return", "if", "else", "while", "for", "break", "continue"}
              & set(part) and "=" in part for part in parts]
    at = 0
    while at < len(parts) - 1:
        if (simple[at] and simple[at + 1] and not _written(parts[at]) & set(parts[at + 1])
                and not _written(parts[at + 1]) & set(parts[at]) and rng.random() < 1 / 2):
            parts[at:at + 2] = parts[at + 1], parts[at]
            at += 1
        at += 1
    return [text for part in parts for text in part]


def _written(part):
    """The names whose values a statement may change."""
    if "&" in part and "(" in part:
        return {text for text in part if text[0].isalpha()}
    pairs = list(zip(part, part[1:]))
    return ({text for text, after in pairs if after[-1] == "=" or after in (*_STEPS, ",", "[")}
            | {after for text, after in pairs if text == "&" or text in _STEPS})


def loops_rewritten(texts, _rng):
    """for becomes while, where nothing in the body continues."""
    at = 0
    while at < len(texts):
        if texts[at] == "for" and texts[at + 1] == "(":
            tokens = tokens_of("\n".join(texts[at + 1:]))
            close = at + 1 + closing(tokens, 0)
            heading = texts[at + 2:close]
            cuts = [i for i, text in enumerate(heading) if text == ";"]
            end = _end_of_statement(texts, close + 1)
            body = texts[close + 1:end]
            if len(cuts) == 2 and "continue" not in body:
                begin, test, step = heading[:cuts[0]], heading[cuts[0] + 1:cuts[1]], heading[cuts[1] + 1:]
                texts = [*texts[:at], "{", *begin, ";", "while", "(", *(test or ["1"]), ")",
                         "{", *body, *step, ";", "}", "}", *texts[end:]]
        at += 1
    return texts


def _end_of_statement(texts, at):
    if texts[at] == "{":
        return at + 1 + closing(tokens_of("\n".join(texts[at:])), 0)
    if texts[at] in ("for", "while", "if"):
        end = _end_of_statement(texts, at + 2 + closing(tokens_of("\n".join(texts[at + 1:])), 0))
        return _end_of_statement(texts, end + 1) if end < len(texts) and texts[end] == "else" else end
    depth = 0
    while texts[at] != ";" or depth:
        depth += (texts[at] in "([{") - (texts[at] in ")]}")
        at += 1
    return at + 1


def steps_turned(texts, _rng):
    """i++ becomes ++i where nobody looks at its value."""
    texts = list(texts)
    for at in range(1, len(texts) - 1):
        if texts[at] in _STEPS and texts[at + 1] in (";", ")") and texts[at - 2] in (";", "{", "}", ")"):
            texts[at - 1:at + 1] = texts[at], texts[at - 1]
    return texts


def brackets_added(texts, rng):
    """Brackets around what is returned and around numbers."""
    new, at = [], 0
    while at < len(texts):
        if texts[at] == "return" and texts[at + 1] != ";":
            end = at + texts[at:].index(";")
            if "{" not in texts[at:end]:
                new += ["return", "(", *texts[at + 1:end], ")"]
                at = end
                continue
        is_number = texts[at][0].isdigit() and texts[at - 1] not in ("[", "=", "{", ",")
        new += ["(", texts[at], ")"] if is_number and rng.random() < 0.5 else [texts[at]]
        at += 1
    return new


def semicolons_added(texts, rng):
    """An empty statement behind some."""
    new, depth = [], 0
    for text, after in zip(texts, [*texts[1:], ""]):
        depth += (text in "([") - (text in ")]")
        new.append(text)
        if text == ";" and depth == 0 and after != "else" and rng.random() < 0.3:
            new.append(";")
    return new


def qualifiers_sprinkled(texts, rng):
    """const before what is declared with a value and never changed; functions are static."""
    new = []
    changed = {before for before, text in zip(texts, texts[1:]) if text.endswith("=") and text not in
               ("==", "<=", ">=", "!=", "=") or text in _STEPS}
    changed |= {after for text, after in zip(texts, texts[1:]) if text in (*_STEPS, "&")}
    changed |= {name for name in set(texts) if
                sum(text == name and after == "=" for text, after in zip(texts, texts[1:])) > 1}
    for at, text in enumerate(texts):
        name, sign = texts[at + 1:at + 2], texts[at + 2:at + 3]
        if (text in _TYPES and sign == ["="] and texts.count(name[0]) > 1 and name[0] not in changed
                and texts[at - 1] in (";", "{", "}") and rng.random() < 0.7):
            new.append("const")
        new.append(text)
    return new


ALL = [loops_rewritten, statements_swapped, steps_turned, brackets_added, semicolons_added,
       qualifiers_sprinkled, functions_reordered, renamed]


def copy_of(code, seed, ways=tuple(ALL)):
    """Returns a copy disguised in these ways, one after the other, without the comments."""
    rng, texts = random.Random(seed), _texts(code)
    for way in ways:
        texts = way(texts, rng)
    return _laid_out(texts, rng)
