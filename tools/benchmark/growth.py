"""How times and memory grow: with triangles, 1,000 to 10 million of them; with megapixels, 0.1 to 64; and
with lights, 1 to 16. Slopes are those of lines through logarithms: 1 is proportional."""

import math

from benchmark.statistics import fit_line
from benchmark.timings import Call

THREADS = (1, 2)
RUNS, FEW_RUNS = 5, 3
MANY = {"triangles": 1000000, "megapixels": 16, "lights": 16}  # so many have few runs
SIDE, SMALL_SIDE, SAMPLES = 800, 200, 4  # pixels, and samples of a light
TRIANGLES = (1000, 3000, 10000, 30000, 100000, 300000, 1000000, 3000000, 10000000)
MEGAPIXELS = (0.1, 0.3, 1, 4, 16, 64)
LIGHTS = (1, 2, 4, 8, 16)
QUICK = {"triangles": (1000, 10000, 100000), "megapixels": (0.1, 1, 4), "lights": (1, 4, 16)}
# Guesses in seconds: to make a triangle of the statue, to put it into a tree, to trace a ray.
MAKE, BUILD, TRACE = 6e-7, 6e-7, 5e-8

MEBIBYTE = 2 ** 20
# Of ten million triangles, on two threads.
BUILD_GOAL, MEMORY_GOAL = 5000, 2048  # milliseconds, mebibytes


def _side(megapixels):
    return round(math.sqrt(1e6 * megapixels))


def _options(what, n):
    if what == "triangles":
        return "wide_bvh", f"--scene statue:{n} --width {SIDE} --height {SIDE} --split wide"
    if what == "megapixels":
        return "wide_bvh", f"--scene statue --width {_side(n)} --height {_side(n)} --split wide"
    return "parallelogram_light", (f"--scene cornell-light --width {SMALL_SIDE} --height {SMALL_SIDE} "
                                   f"--light-samples {SAMPLES} --lights {n}")


def camera_rays(what, n):
    return {"triangles": SIDE, "lights": SMALL_SIDE}.get(what, _side(n)) ** 2


def _guess(what, n, threads, runs):
    rays = camera_rays(what, n) * (SAMPLES * n if what == "lights" else 1)
    triangles = n if what == "triangles" else 0
    return 0.2 + triangles * (MAKE + runs * BUILD / threads) + runs * rays * TRACE / threads


def _call(what, n, threads, quick=False):
    runs = 1 if quick else FEW_RUNS if n >= MANY[what] else RUNS
    return Call(*_options(what, n), threads, runs, _guess(what, n, threads, runs))


def _plan(quick=False):
    plan = {"triangles": TRIANGLES, "megapixels": MEGAPIXELS, "lights": LIGHTS}
    return [(what, n, threads) for what in plan for n in (QUICK if quick else plan)[what]
            for threads in THREADS]


def calls(_, quick):
    return [_call(*at, quick) for at in _plan(quick)]


def _row(what, n, threads, measured):
    traced = 1e6 * measured["render_median"] / camera_rays(what, n)
    of_triangles, peak = what == "triangles", measured["peak_mib"]
    return {
        "what": what, "n": n, "threads": threads, **{name: measured[name] for name in (
            "build_median", "build_min", "build_max", "render_median", "render_min", "render_max")},
        "trace_ns_per_ray": traced,
        "bytes_per_triangle": measured["bytes_per_triangle"] if of_triangles else "",
        "peak_mib": peak, "peak_bytes_per_triangle": peak * MEBIBYTE / n if of_triangles and peak else "",
        "runs": measured["runs"],
    }


def rows(_, timings):
    """Of growth.csv, as far as it is measured."""
    found = [(at, timings.row(_call(*at, quick=True))) for at in _plan()]
    return [_row(*at, measured) for at, measured in found if measured]


# What each plot shows: the column, and what its lines are called; lines for each number of threads, or one
# for all.
CURVES = {
    "triangles": (("build", "build_median", ""), ("trace", "trace_ns_per_ray", ""),
                  ("memory", "bytes_per_triangle", "the tree"),
                  ("memory", "peak_bytes_per_triangle", "the whole process")),
    "megapixels": (("render", "render_median", ""),),
    "lights": (("render", "render_median", ""),),
}


def _curve(of_growth, what, column, threads):
    return [(row["n"], row[column]) for row in of_growth if row["what"] == what and row["threads"] == threads
            and row[column] != "" and row[column] > 0]


def curve_rows(of_growth):
    """Of growth_curves.csv: the points of the plots, their lines' names with the slopes; and of
    growth_slopes.csv."""
    points, slopes = [], []
    for what, curves in CURVES.items():
        for quantity, column, name in curves:
            for threads in THREADS[-1:] if name else THREADS:
                curve = _curve(of_growth, what, column, threads)
                title = name or f"{threads} thread{'s' * (threads > 1)}"
                if len(curve) >= 3:
                    (slope, low, high), _ = fit_line(*zip(*[(math.log(x), math.log(y)) for x, y in curve]))
                    slopes.append({"what": what, "quantity": quantity, "line": title, "slope": slope,
                                   "slope_low": low,
                                   "slope_high": high, "points": len(curve)})
                    title += f", slope {slope:.2f}".replace("-", "\N{MINUS SIGN}")
                points += [{"what": what, "quantity": quantity, "line": title, "n": x, "value": y}
                           for x, y in curve]
    return points, slopes


def goal_rows(of_growth):
    """Of growth_goals.csv, once ten million triangles are measured."""
    most = [row for row in of_growth
            if (row["what"], row["n"], row["threads"]) == ("triangles", TRIANGLES[-1], 2)]
    return [{"goal": quantity, "unit": unit, "value": row[column], "limit": limit,
             "reached": "yes" if row[column] <= limit else "no"} for row in most
            for quantity, unit, column, limit in (("building the tree", "ms", "build_median", BUILD_GOAL),
                                                  ("memory of the whole process", "MiB", "peak_mib",
                                                   MEMORY_GOAL))
            if row[column] != ""]
