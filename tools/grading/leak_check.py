"""Is a pack for students free of solutions? Searches all of its files for their lines.

A line of a solution that was packed by mistake is an error. Lines that the kit's own code has in common
with a solution cannot be left out, because the kit needs them; the instructor gets a list of these
places with the remedy.
"""

import filecmp
import gzip
import html
import os
import re

from grading.assignments import ToolError
from grading.starters import solution_lines, starter_of

# The same steps in other words, which no comparison of lines finds. (feature, its step, file, the line
# of that file where it begins)
SAME_STEPS = [
    ("bvh_median", "step 4, the traversal, for all leaves on the way", "src/accel/query/tree.c",
     "static void visit_binary_leaves("),
    ("bvh_median", "step 4, the traversal, step by step to look at", "assignments/01_bvh_median/traversal.c",
     "static void visit("),
    ("wide_bvh", "step 2, the blocks, straight from the mesh", "src/accel/build/wide_build.c",
     "static void fill_block("),
    ("wide_bvh", "step 3, the order, by vectors", "src/accel/kernel/wide_boxes.h",
     "RK_INLINE uint32_t push_children("),
    ("wide_bvh", "step 4, any hit, of many rays at once", "src/accel/kernel/wide_pairs.h",
     "RK_INLINE void judge_pair("),
    ("shading", "steps 2, 3 and 5, in double, to compare with", "tests/test_shading.c",
     "static double exact_highlight("),
    ("parallelogram_light", "step 2, in double, to integrate", "tests/test_parallelogram_light.c",
     "static double irradiance_from("),
    ("cubemap", "step 3, bilinear, in a picture", "src/base/texture.c", "static rk_vec3 bilinear("),
    ("cubemap", "step 3, as a sum over all texels", "tests/test_cubemap.c", "static rk_vec3 under_tents("),
    ("sah_binning", "steps 1 to 3, boundary by boundary", "tests/test_sah_binning.c",
     "static trial try_boundary("),
    ("motion_blur", "step 6, the stable roots, of a sphere", "src/base/sphere.h",
     "static inline bool rk_sphere_span("),
]


def _files(folder):
    return sorted(os.path.relpath(os.path.join(where, name), folder)
                  for where, _, names in os.walk(folder) for name in names)


def _spaced(text):
    return " ".join(text.split())


def _read_lines(path):
    """The file's lines with normalized spaces; a page's without tags."""
    with (gzip.open if path.endswith(".json.gz") else open)(path, "rt", encoding="utf-8",
                                                            errors="replace") as file:
        text = file.read()
    if path.endswith((".json", ".json.gz")):
        text = text.replace("\\n", "\n").replace('\\"', '"')
    if path.endswith(".html"):
        text = "\n".join(html.unescape(re.sub("<[^>]*>", "", line)) for line in text.split("\n"))
    return [_spaced(line) for line in text.split("\n")]


def secret_lines(source, features):
    """Returns the features' solution lines with normalized spaces, and those of them that prove
    nothing alone, because another C file of the kit has them, too."""
    secrets = {_spaced(line) for feature in features for line in solution_lines(feature.reference)}
    for feature in features:
        secrets -= {_spaced(line) for line in starter_of(feature.reference).split("\n")}
    own = {os.path.realpath(feature.reference) for feature in features}
    common = set()
    for part in ("src", "tests", "assignments"):
        for name in _files(os.path.join(source, part)):
            path = os.path.join(source, part, name)
            if name.endswith((".c", ".h")) and os.path.realpath(path) not in own:
                text = "\n".join(_read_lines(path))
                common |= {line for line in secrets if line in text}
    return secrets, common


def _is_the_kits(source, pack, name):
    """Whether packing left this file of the kit as it was."""
    own, packed = os.path.join(source, name), os.path.join(pack, name)
    return os.path.isfile(own) and filecmp.cmp(own, packed, shallow=False)


def solution_in(text, source, features):
    """Returns (number, stem) of the first line of a text that gives a feature's solution away, or None."""
    secrets, common = secret_lines(source, features)
    for number, line in enumerate(text.split("\n"), 1):
        held = [secret for secret in secrets - common if secret in _spaced(line)]
        for feature in features:
            if {_spaced(own) for own in solution_lines(feature.reference)} & set(held):
                return number, feature.stem
    return None


_FEW = 2  # a solution line in more places of the kit tells nothing, nor does one alone
_PASSAGE = 4  # so many solution lines, at most so far apart, are no coincidence


def _passages(lines, secrets):
    """Returns the numbers of lines where a passage of a solution begins: several different
    lines of it with few others between them."""
    places = [number for number, line in enumerate(lines) if line in secrets]
    return [number for number in places
            if len({line for line in lines[number:number + _PASSAGE + 1] if line in secrets}) >= _PASSAGE]


def find_secrets(source, pack, features, secrets, common, beside=None):
    """Returns "file:line: text" for each line of the pack, or of a site, that gives a solution away; its
    folder `beside` is not the kit's. In the solutions' own files that is any of their lines, including
    common ones; in files that packing made or changed, any that is not common; in the kit's other files,
    which may contain a line by chance, a passage."""
    own = {f"{folder}/{feature.stem}.c" for feature in features
           for folder in ("workbook", "src/features", "starters")}
    found = []
    for name in _files(pack):
        if beside and name.startswith(beside + os.sep):
            continue
        lines = _read_lines(os.path.join(pack, name))
        if name in own:
            numbers = [number for number, line in enumerate(lines) if line in secrets]
        elif _is_the_kits(source, pack, name):
            numbers = _passages(lines, secrets)
        else:
            held = [line for line in secrets - common if line in "\n".join(lines)]
            numbers = [number for number, line in enumerate(lines) if any(secret in line for secret in held)]
        found += [f"{name}:{number + 1}: {lines[number][:100]}" for number in numbers]
    return found


def lines_elsewhere(pack, features, secrets):
    """Returns a list of (file, number, line, how many places) for solution lines outside the
    solutions' own files: the first place of each, code before text, the rarest first."""
    own = {f"{folder}/{feature.stem}.c" for feature in features for folder in ("workbook", "src/features")}
    places = {}
    for name in sorted(_files(pack), key=lambda name: (not name.endswith((".c", ".h")), name)):
        lines = [] if name in own else _read_lines(os.path.join(pack, name))
        text = "\n".join(lines)
        for secret in (secret for secret in secrets if secret in text):
            numbers = [number for number, line in enumerate(lines, 1) if secret in line]
            places.setdefault(secret, []).extend((name, number) for number in numbers)
    return sorted(((*where[0], secret, len(where)) for secret, where in places.items()),
                  key=lambda found: (found[3], found[:2]))


def _beside_another(found):
    """Returns those of lines_elsewhere that stand beside another."""
    places = {(name, number) for name, number, *_ in found}
    return [line for line in found if places & {(line[0], line[1] - 1), (line[0], line[1] + 1)}]


def steps_elsewhere(pack, features):
    """Returns a list of (file, number, what) for the known steps of these features in other words."""
    chosen = {feature.stem for feature in features}
    found = []
    for stem, what, name, beginning in SAME_STEPS:
        if stem in chosen and name not in {f"src/features/{other}.c" for other in chosen}:
            with open(os.path.join(pack, name), encoding="utf-8") as file:
                number = next((n for n, line in enumerate(file, 1) if line.startswith(beginning)), None)
            if number is None:
                raise ToolError(f"{name} has no line that begins with \"{beginning}\"; "
                                "correct SAME_STEPS in tools/grading/leak_check.py")
            found.append((name, number, f"{stem}, {what}"))
    return found


def prove(source, pack, all_features, features):
    """Returns lines that report the search and the kit's lines in common with solutions, or raises
    ToolError with the places of solutions left in the pack."""
    secrets, common = secret_lines(source, features)
    found = find_secrets(source, pack, features, secrets, common)
    if found:
        more = [f"and {len(found) - 10} more"] if len(found) > 10 else []
        raise ToolError("\n".join([
            "these lines of the pack are solutions:", *found[:10], *more,
            "take them out; if another feature has them, name it in ASSIGNMENTS, too"]))
    lines, steps = lines_elsewhere(pack, features, secrets), steps_elsewhere(pack, features)
    looked = f"Searched {len(_files(pack))} files for {len(secrets)} lines of the solutions: "
    if not lines and not steps:
        return [looked + "none found."]
    told = [f"  {name}:{number}: {what}, in other words" for name, number, what in steps]
    rare = _beside_another([found for found in lines if found[3] <= _FEW])
    told += [f"  {name}:{number}: {line}" for name, number, line, _ in rare]
    if len(rare) < len(lines):
        more = len(lines) - len(rare)
        alone = f"{more} line{'s' * (more > 1)}"
        told.append(f"  and {alone} alone, which tell{'s' * (more == 1)} nothing, such as {lines[-1][2]}")
    holders = {f"src/features/{stem}.c": stem for stem in all_features}
    others = sorted({holders[name] for name, *_ in [*rare, *steps] if name in holders})
    remedy = "Check whether they give a step away."
    if others:
        remedy = (f"To leave them out as well, add {' and '.join(others)} to ASSIGNMENTS; otherwise check "
                  "whether they give a step away.")
    return [f"{looked}no solution is left.", "These places of the kit have something of the solutions:",
            *told, remedy]
