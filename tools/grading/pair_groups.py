"""Groups of units that have code in common: k of them are k (k - 1) / 2 pairs, which nobody reads.

Of a large group, the pairs of a maximum spanning tree (Kruskal, 1956) are enough: each unit is in one with
the unit that it has most in common with, so those that share more than the rest are still side by side."""

import collections

SMALL = 5  # units, of which all pairs are listed


def _strength(pair):
    return -pair.tokens, -pair.share, pair


def spanning(pairs):
    """Returns those of the pairs that are listed, and the sizes of the large groups, the largest first."""
    parents = {}

    def top(name):
        while parents.setdefault(name, name) != name:
            parents[name] = parents[parents[name]]
            name = parents[name]
        return name

    tree = []
    for pair in sorted(pairs, key=_strength):
        one, other = top(pair.one), top(pair.other)
        if one != other:
            parents[one] = other
            tree.append(pair)
    sizes = collections.Counter(map(top, list(parents)))
    large = [top for top, size in sizes.items() if size > SMALL]
    kept = [pair for pair in pairs if top(pair.one) not in large]
    return kept + [pair for pair in tree if top(pair.one) in large], sorted(
        (sizes[top] for top in large), reverse=True)


def strongest(pairs):
    """Returns the few pairs of each `one` that have most in common."""
    kept, counts = [], collections.Counter()
    for pair in sorted(pairs, key=_strength):
        counts[pair.one] += 1
        if counts[pair.one] <= SMALL:
            kept.append(pair)
    return kept
