"""Statistics of few measurements: intervals by Student's t, slopes of lines, and which of many differences
are more than noise. All by the standard library."""

import functools
import math


def incomplete_beta(a, b, x):
    """The regularized incomplete beta function by its continued fraction (Abramowitz and Stegun 26.5.8,
    Lentz)."""
    if x <= 0 or x >= 1:
        return float(x >= 1)
    if x > (a + 1) / (a + b + 2):  # converges fast on the other side only
        return 1 - incomplete_beta(b, a, 1 - x)
    front = math.exp(a * math.log(x) + b * math.log1p(-x)
                     - math.lgamma(a) - math.lgamma(b) + math.lgamma(a + b)) / a
    tiny = 1e-300  # stands for 0 in denominators, as Lentz proposed
    fraction, c, d = 1.0, 1.0, 0.0
    for i in range(400):
        m = i // 2
        if i == 0:
            numerator = 1.0
        elif i % 2 == 0:
            numerator = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        else:
            numerator = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        d = 1 / ((1 + numerator * d) or tiny)
        c = (1 + numerator / c) or tiny
        fraction *= c * d
        if abs(1 - c * d) < 1e-15:
            break
    return front * (fraction - 1)


def student_tails(t, freedom):
    """The probability that Student's t is at least as far from 0, on either side."""
    if math.isinf(t):
        return 0.0
    return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t))


@functools.lru_cache(maxsize=None)
def student_quantile(level, freedom):
    """The t that Student's distribution stays below on both sides with probability `level`, by bisection."""
    low, high = 0.0, 1.0
    while student_tails(high, freedom) > 1 - level:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if student_tails(middle, freedom) > 1 - level else (low, middle)
    return high


def mean(values):
    return math.fsum(values) / len(values)


def standard_error(values):
    """Of the mean of at least two values."""
    centre = mean(values)
    return math.sqrt(math.fsum((v - centre) ** 2 for v in values) / (len(values) - 1) / len(values))


def mean_interval(values, level=0.95, more_error=0.0):
    """The mean and its interval, (middle, low, high). `more_error` is a standard error that all values
    share."""
    half = student_quantile(level, len(values) - 1) * math.hypot(standard_error(values), more_error)
    return mean(values), mean(values) - half, mean(values) + half


def rmse_interval(squares, own, level=0.95):
    """The root mean squared error and its interval, from mean squared errors by seed. `own` is the
    reference's mean squared error, which is in each of them."""
    return tuple(math.sqrt(max(value - own, 0)) for value in mean_interval(squares, level))


def median(values):
    ordered, count = sorted(values), len(values)
    return (ordered[(count - 1) // 2] + ordered[count // 2]) / 2


def fit_line(xs, ys, level=0.95):
    """The least-squares line through at least three points: its slope as (middle, low, high), and its value
    at 0."""
    x, y = mean(xs), mean(ys)
    spread = math.fsum((xi - x) ** 2 for xi in xs)
    slope = math.fsum((xi - x) * (yi - y) for xi, yi in zip(xs, ys)) / spread
    left = math.fsum((yi - y - slope * (xi - x)) ** 2 for xi, yi in zip(xs, ys))
    half = student_quantile(level, len(xs) - 2) * math.sqrt(left / (len(xs) - 2) / spread)
    return (slope, slope - half, slope + half), y - slope * x


def crossing(points, level):
    """Where a curve through (x, y) with falling y passes below `level` for good, between points along a power
    of x; beyond the points along the power that its last four follow. Returns x and "measured",
    "extrapolated" or "at most"; or None and "never"."""
    above = [i for i, (_, y) in enumerate(points) if y > level]
    if not above:
        return points[0][0], "at most"
    i = above[-1]
    logs = [(math.log(x), math.log(y)) for x, y in points if y > 0]
    if i + 1 < len(points):
        if points[i + 1][1] <= 0:  # lost in the reference's error
            return points[i + 1][0], "at most"
        (x0, y0), (x1, y1) = ((math.log(x), math.log(y)) for x, y in points[i:i + 2])
        return math.exp(x0 + (math.log(level) - y0) * (x1 - x0) / (y1 - y0)), "measured"
    if len(logs) < 3:
        return None, "never"
    (slope, _, _), start = fit_line(*zip(*logs[-4:]))
    return (math.exp((math.log(level) - start) / slope), "extrapolated") if slope < 0 else (None, "never")


def paired_change(old, new):
    """The mean difference of pairs, and the probability of one at least as large by chance (Student's paired
    test)."""
    differences = [n - o for o, n in zip(old, new)]
    change, error = mean(differences), standard_error(differences)
    if error == 0:
        return change, float(change == 0)
    return change, student_tails(change / error, len(differences) - 1)


def beyond_chance(probabilities, level):
    """For each of these probabilities: is it beyond chance, if with probability `level` at most one of all
    may be so by chance? (S. Holm, "A simple sequentially rejective multiple test procedure", 1979.)"""
    found, order = [False] * len(probabilities), sorted(range(len(probabilities)),
                                                        key=probabilities.__getitem__)
    for rank, i in enumerate(order):
        if probabilities[i] > level / (len(order) - rank):
            break
        found[i] = True
    return found
