"""From measured pictures to tables: error and time of each method by number of samples, slopes, time to an
error of 1 %, and the best method of each case against the classic one. Errors are relative: see
tests/bench/bench.c."""

import math
import os
import random

from benchmark.measurements import write_table
from benchmark.statistics import crossing, fit_line, mean, mean_interval, median, rmse_interval

ERROR_WANTED = 0.01
FIT_FROM = 4  # samples: before, an error need not yet follow its power
RESAMPLINGS = 200
# Times the samples of the error before: where all pixels have the most, a smaller one draws the same.
FEWEST_MORE = 1.01


class Curve:
    """One method's measurements, by number of samples: lists of rows in the order of the seeds."""

    def __init__(self, schedule, method):
        settings, self.method = schedule.settings, method
        self.pixels = settings.side ** 2
        self.reference = schedule.references[method.case.name]
        self.rows, most = {}, 0
        for samples in settings.counts():
            rows = [schedule.row(method, samples, seed) for seed in range(1, settings.seeds + 1)]
            if all(rows) and schedule.wanted(method, samples):
                self.rows[samples] = rows
                if not method.counts_samples and self.rays(samples) < FEWEST_MORE * most:
                    del self.rows[samples]
                else:
                    most = self.rays(samples)

    def error(self, samples, seeds=None):
        """The root mean squared error without the reference's own."""
        rows = self.rows[samples]
        squares = mean([rows[i]["mse"] for i in seeds] if seeds else [row["mse"] for row in rows])
        return math.sqrt(max(squares - self.reference["own"], 0))

    def seconds(self, samples, seeds=None):
        rows = self.rows[samples]
        return median([rows[i]["seconds"] for i in seeds] if seeds else [row["seconds"] for row in rows])

    def time_to(self, level, seeds=None):
        return crossing([(self.seconds(n, seeds), self.error(n, seeds)) for n in self.rows], level)

    def rays(self, samples):
        """Camera rays per pixel."""
        return mean([row["camera_rays"] for row in self.rows[samples]]) / self.pixels

    def samples_taken(self, samples):
        """Their number, or that of a method that was asked for an error."""
        return samples if self.method.counts_samples else self.rays(samples)

    def samples_to(self, level):
        return crossing([(self.samples_taken(n), self.error(n)) for n in self.rows], level)

    def rays_to(self, level):
        return crossing([(self.rays(n), self.error(n)) for n in self.rows], level)

    def fixed_seconds(self):
        """Of the time, the part that all numbers of samples take, such as camera rays': where the line
        through the fewest samples and those that are wanted meets none. Or None."""
        few, many = min(self.rows), max(self.where_wanted(), sorted(self.rows)[min(1, len(self.rows) - 1)])
        if few == many or not self.method.counts_samples:
            return None
        return max((self.seconds(few) * many - self.seconds(many) * few) / (many - few), 0)

    def slope(self):
        """Of the error's logarithm over that of the number of samples, where the reference is much better; or
        None."""
        known = [n for n in self.rows if n >= FIT_FROM and self.error(n) ** 2 > 4 * self.reference["own"]]
        if len(known) < 3:
            return None
        return fit_line([math.log(self.samples_taken(n)) for n in known],
                        [math.log(self.error(n)) for n in known])[0]

    def bias(self, samples):
        return mean_interval([row["bias"] for row in self.rows[samples]],
                             more_error=self.reference["bias_error"])

    def where_wanted(self):
        """The number of samples that first reaches the wanted error, or the largest one."""
        return next((n for n in self.rows if self.error(n) <= ERROR_WANTED), max(self.rows))


def time_ratio(classic, best, seeds):
    """How many times less time the best method needs for the wanted error, as (middle, low, high): by
    resampling seeds with replacement (B. Efron, "Bootstrap methods", 1979). None where one of them never gets
    there."""
    middle = [curve.time_to(ERROR_WANTED)[0] for curve in (classic, best)]
    if None in middle:
        return None
    chance, ratios = random.Random(1), []
    for _ in range(RESAMPLINGS):
        drawn = chance.choices(range(seeds), k=seeds)
        times = [curve.time_to(ERROR_WANTED, drawn)[0] for curve in (classic, best)]
        if None not in times:
            ratios.append(times[0] / times[1])
    ratios.sort()
    low, high = (ratios[round(p * (len(ratios) - 1))] for p in (0.025, 0.975))
    return middle[0] / middle[1], low, high


def sample_ratio(classic, best):
    """How many times fewer samples the best method needs for the wanted error, or None. If it chooses their
    number, of which pixels differ, camera rays count."""
    needed = [(curve.samples_to if best.method.counts_samples else curve.rays_to)(ERROR_WANTED)[0]
              for curve in (classic, best)]
    return None if None in needed else needed[0] / needed[1]


def fixed_part(curve):
    """The fixed part of the time to the wanted error, or None."""
    seconds, (time, _) = curve.fixed_seconds(), curve.time_to(ERROR_WANTED)
    return None if seconds is None or time is None else min(seconds / time, 1)


def curves_of(schedule):
    """A list of curves for each case whose reference is known, the classic method first."""
    found = ([Curve(schedule, method) for method in case.methods] for case in schedule.cases)
    return [curves for curves in found if all(curve.rows for curve in curves)]


# --- tables --------------------------------------------------------------------------------------

def _figure(value):
    return "" if value is None else value if isinstance(value, str) else f"{value:.6g}"


def convergence_rows(schedule, curves):
    """The columns of all convergence tables, then intervals, rays and efficiency."""
    settings = schedule.settings
    for curve in (curve for of_case in curves for curve in of_case):
        own = math.sqrt(curve.reference["own"])
        for samples, rows in curve.rows.items():
            error = rmse_interval([row["mse"] for row in rows], curve.reference["own"])
            bias = curve.bias(samples)
            worst = mean_interval([row["worst"] for row in rows])
            seconds = mean_interval([math.log(row["seconds"]) for row in rows])
            efficiency = 1 / (error[0] ** 2 * curve.seconds(samples)) if error[0] > 0 else None
            yield {
                "feature": curve.method.case.name, "scene": curve.method.case.options.split()[1],
                "method": curve.method.name, "samples": f"{curve.samples_taken(samples):.6g}",
                "seconds": curve.seconds(samples),
                "rmse": error[0], "max_error": worst[0], "bias": bias[0],
                "reference": f"{2 * settings.pictures} pictures of {settings.reference} samples",
                "seconds_low": math.exp(seconds[1]), "seconds_high": math.exp(seconds[2]),
                "rmse_low": error[1], "rmse_high": error[2], "max_error_low": worst[1],
                "max_error_high": worst[2],
                "bias_low": bias[1], "bias_high": bias[2], "reference_error": own, "seeds": str(len(rows)),
                "camera_rays": mean([row["camera_rays"] for row in rows]),
                "shadow_rays": mean([row["shadow_rays"] for row in rows]),
                "reflected_rays": mean([row["reflected_rays"] for row in rows]), "efficiency": efficiency,
            }


def method_rows(curves):
    for curve in (curve for of_case in curves for curve in of_case):
        slope = curve.slope() or (None, None, None)
        samples, _ = curve.samples_to(ERROR_WANTED)
        seconds, how = curve.time_to(ERROR_WANTED)
        bias = curve.bias(curve.where_wanted())
        yield {
            "feature": curve.method.case.name, "title": curve.method.case.title, "method": curve.method.name,
            "slope": slope[0], "slope_low": slope[1], "slope_high": slope[2], "samples": samples,
            "seconds": seconds,
            "how": how, "bias": bias[0], "bias_low": bias[1], "bias_high": bias[2],
        }


def summary_rows(schedule, curves):
    for of_case in curves:
        case, classic = of_case[0].method.case, of_case[0]
        timed = [(curve.time_to(ERROR_WANTED)[0], i) for i, curve in enumerate(of_case)]
        best = of_case[min((time for time in timed if time[0] is not None), default=(0, 0))[1]]
        ratio = time_ratio(classic, best, schedule.settings.seeds) or (None, None, None)
        slope = best.slope() or (None, None, None)
        bias = best.bias(best.where_wanted())
        hows = {curve.time_to(ERROR_WANTED)[1] for curve in (classic, best)} - {"measured"}
        yield {
            "case": case.name, "feature": case.title, "classic": classic.method.name,
            "best": best.method.name,
            "time_ratio": ratio[0], "time_ratio_low": ratio[1], "time_ratio_high": ratio[2],
            "goal": case.goal,
            "goal_reached": verdict(ratio[0], case.goal), "sample_ratio": sample_ratio(classic, best),
            "fixed_percent": None if fixed_part(best) is None else 100 * fixed_part(best), "slope": slope[0],
            "slope_low": slope[1],
            "slope_high": slope[2], "slope_goal": case.slope,
            "slope_reached": verdict(None if slope[0] is None else -slope[0],
                                     None if case.slope is None else -case.slope),
            "bias": bias[0], "bias_low": bias[1], "bias_high": bias[2], "note": ", ".join(sorted(hows)),
        }


def verdict(value, goal):
    """Is a goal reached?"""
    return "" if goal is None else "yes" if value is not None and value >= goal else "no"


def reference_rows(schedule):
    for case in schedule.cases:
        numbers = schedule.references.get(case.name)
        if numbers:
            yield {"case": case.name, "feature": case.title, "values": numbers["values"],
                   "error": math.sqrt(numbers["own"]),
                   "difference": numbers["z"], "squares": numbers["ratio"],
                   "agree": "yes" if abs(numbers["z"]) < AGREE and numbers["ratio"] < AGREE_SQUARED else "no"}


# Standard errors between the means of two references; more are by chance once in 16,000 cases.
AGREE = 4
# Mean of the squared differences of their pixels over the variances: 1 is expected if only chance differs. Of
# the cases here it was 0.4 to 1.2 in full and in quick measurements; a bias of 1.4 deviations in every pixel
# makes it 3.
AGREE_SQUARED = 3


def write(schedule, folder):
    """Writes the tables, and returns the rows of the summary."""
    curves = curves_of(schedule)
    summary = list(summary_rows(schedule, curves))
    for name, rows in (("accuracy", summary), ("accuracy_methods", list(method_rows(curves))),
                       ("accuracy_convergence", list(convergence_rows(schedule, curves))),
                       ("accuracy_references", list(reference_rows(schedule)))):
        write_table(os.path.join(folder, name + ".csv"), list(rows[0]) if rows else [],
                    [[_figure(cell) for cell in row.values()] for row in rows])
    return summary
