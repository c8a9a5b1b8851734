"""What got slower or less accurate since an older measurement, beyond noise: pairs of pictures with the same
method, number of samples and seed."""

import math

from benchmark.statistics import beyond_chance, paired_change

LEVEL = 0.01  # the probability that chance alone makes any of all methods look changed
# A machine's pace changes between two runs, by its other work and its temperature, and no seed tells of that.
PACE = 0.05


class Change:
    """Of one method, as a factor on its time ("time") or on its root mean squared error ("error")."""

    def __init__(self, case, method, what, logarithm, probability):
        self.case, self.method, self.what, self.factor = case, method, what, math.exp(logarithm)
        self.probability, self.beyond_noise = probability, False

    def text(self):
        words = {("time", True): "slower", ("time", False): "faster",
                 ("error", True): "less accurate", ("error", False): "more accurate"}
        worse = self.factor > 1
        percent = 100 * (self.factor - 1 if worse else 1 - self.factor)
        by = {"time": "less time" if not worse else "more time",
              "error": "less error" if not worse else "more error"}
        return f"{self.case}, {self.method}: {words[self.what, worse]}, {percent:.1f} % {by[self.what]}"


def _by_method(rows):
    found = {}
    for row in rows:
        pairs = found.setdefault((row["case"], row["method"], row["size"]), {})
        pairs[row["samples"], row["seed"]] = row
    return found


def _per_seed(pairs, figure):
    """For each seed the figure over its pictures."""
    seeds = sorted({seed for _, seed in pairs})
    return [figure([row for (_, of), row in sorted(pairs.items()) if of == seed]) for seed in seeds]


def _log_time(rows):
    return math.log(sum(row["seconds"] for row in rows))


def _log_error(rows):
    return sum(0.5 * math.log(row["mse"]) for row in rows) / len(rows)


def changes(old_rows, new_rows):
    """A Change for each method that both have for at least two seeds, in time and in error."""
    old, new = _by_method(old_rows), _by_method(new_rows)
    found = []
    for name in sorted(old.keys() & new.keys()):
        common = old[name].keys() & new[name].keys()
        for what, figure, column in (("time", _log_time, "seconds"), ("error", _log_error, "mse")):
            # Logarithms; pairs, so what one side has no logarithm of, neither has.
            keys = [key for key in common if old[name][key][column] > 0 and new[name][key][column] > 0]
            sides = [_per_seed({key: side[key] for key in keys}, figure) for side in (old[name], new[name])]
            if len(sides[0]) >= 2:
                found.append(Change(name[0], name[1], what, *paired_change(*sides)))
    for change, beyond in zip(found, beyond_chance([change.probability for change in found], LEVEL)):
        change.beyond_noise = beyond and (change.what == "error"
                                          or abs(math.log(change.factor)) > math.log1p(PACE))
    return found
