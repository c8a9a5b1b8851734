"""Measures what is missing. Each case has a process of tests/bench/bench, which renders its pictures one
after the other on one thread; as many cases at a time as there are processors. Within a case, methods take
turns: a picture of each method and number of samples for the first seed, then for the second, and so on, so
that a machine that gets slower meanwhile is slower for all. Numbers of samples rise for one seed and fall for
the next: a short picture after a long one would find the caches cold, and take half as long again."""

import concurrent.futures
import hashlib
import os
import subprocess
import sys
import threading
import time

from benchmark.measurements import NUMBERS
from grading.assignments import ToolError

REFERENCE_NUMBERS = ("values", "norm", "own", "bias_error", "z", "ratio")


class Program:
    """A running bench, in the folder where it keeps its references."""

    def __init__(self, path, options, folder):
        self._process = subprocess.Popen([path, *options.split(), "--out", "."], cwd=folder,
                                         stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def ask(self, line):
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # its answer says why
        return self.answer()

    def answer(self):
        """The cells of the next line."""
        answer = self._process.stdout.readline()
        if not answer:
            raise ToolError(self._process.stderr.read().strip() or "bench: it ended without a message")
        return answer.strip().split(",")

    def stop(self):
        """Ends it; a question that waits gets no answer."""
        self._process.kill()

    def close(self):
        self.stop()
        self._process.communicate()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def processor():
    """The processor's name, "" if it is unknown."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
            return next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        return ""


def digest(path):
    """Names a program on this machine: on another, times are other ones."""
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read() + processor().encode()).hexdigest()[:12]
    except OSError as error:
        raise ToolError(f"{path}: cannot be read: {error.strerror}; run make bench") from None


def kinds_of(path, folder):
    with Program(path, "--scene triangle --width 1 --height 1", folder) as program:
        return program.ask("kinds")


class Schedule:
    def __init__(self, cases, settings, kept, program, folder):
        self.cases, self.settings, self.kept = cases, settings, kept
        self.program, self.folder = program, folder
        self.references = {}
        self._lock, self._stopped, self._running = threading.Lock(), threading.Event(), []
        self._processors = os.cpu_count() or 1
        self._measured, self._waited, self._said = 0.0, 0.0, 0.0

    def row(self, method, samples, seed):
        return self.kept.rows.get(self.kept.key(method, self.settings.side, samples, seed))

    def seconds(self, method, samples):
        """The time of one picture, as far as known: as measured, or as half as many samples promise."""
        for seed in range(1, self.settings.seeds + 1):
            row = self.row(method, samples, seed)
            if row:
                return row["seconds"]
        return 2 * self.seconds(method, samples // 2) if samples > 1 else None

    def wanted(self, method, samples):
        """Is a picture cheap enough? The first seed decides."""
        half = self.row(method, samples // 2, 1) if samples > 1 else None
        return samples == 1 or (half is not None and self.wanted(method, samples // 2) and
                                2 * half["seconds"] <= self.settings.dearest)

    def _left(self):
        """Seconds of processor time that are left, as far as known. A case that has not begun takes as long
        as others."""
        known, unknown = [], 0
        for case in self.cases:
            total = 0.0
            for method in case.methods:
                first = self.row(method, 1, 1)
                if first is None:
                    unknown += 1
                    continue
                done = sum(self.row(method, n, s) is not None for n in self.settings.counts()
                           for s in range(1, self.settings.seeds + 1))
                cost = [self.seconds(method, n) for n in self.settings.counts()]
                cost = [c for c in cost if c <= self.settings.dearest]
                missing = sum(c for n, c in zip(self.settings.counts(), cost)
                              for s in range(1, self.settings.seeds + 1) if self.row(method, n, s) is None)
                known.append(sum(cost) * self.settings.seeds)
                total += missing if done else known[-1]
            yield total
        if known and unknown:
            yield unknown * sum(known) / len(known)

    def _say(self):
        now = time.monotonic()
        if now - self._said < 5:
            return
        self._said = now
        pace = max(self._waited / self._measured, 1) if self._measured > 0 else 1  # other programs run, too
        left = sum(self._left()) * pace / self._processors
        text = f"about {left / 60:.0f} min left" if left > 90 else f"about {left:.0f} s left"
        done = len(self.kept.rows)
        print(f"bench: {done} picture{'s' * (done != 1)} measured, {text}", file=sys.stderr, flush=True)

    def _measure_case(self, case):
        if self._stopped.is_set():
            return
        with Program(self.program, case.options, self.folder) as program:
            self._running.append(program)
            drawn = f"{digest(self.program)} {case.options} {case.reference}"
            name = hashlib.sha256(drawn.encode()).hexdigest()[:16]
            numbers = program.ask(f"reference {case.name}-{name}.reference {case.reference}")
            self.references[case.name] = dict(zip(REFERENCE_NUMBERS, map(float, numbers)))
            for seed in range(1, self.settings.seeds + 1):
                for samples in self.settings.counts()[::1 if seed % 2 else -1]:
                    for method in case.methods:
                        if self._stopped.is_set():
                            return
                        self._measure(program, method, samples, seed)

    def _measure(self, program, method, samples, seed):
        if self.row(method, samples, seed) or not self.wanted(method, samples):
            return
        start = time.monotonic()
        numbers = [float(cell) for cell in program.ask("picture " + method.options(samples, seed))]
        if len(numbers) != len(NUMBERS):
            raise ToolError(f"bench: {len(numbers)} numbers in place of {len(NUMBERS)}: "
                            "run make bench to build it anew")
        with self._lock:
            self.kept.add_picture(self.kept.key(method, self.settings.side, samples, seed), numbers)
            self._measured += numbers[0]
            self._waited += time.monotonic() - start
            self._say()

    def run(self):
        """All that is missing; the error of the first case that has one."""
        with concurrent.futures.ThreadPoolExecutor(self._processors) as pool:
            waiting = [pool.submit(self._measure_case, case) for case in self.cases]
            try:
                for done in concurrent.futures.as_completed(waiting):
                    done.result()
            finally:
                self._stopped.set()
                for program in self._running:  # where an error or an interruption ends all
                    program.stop()
                for future in waiting:
                    future.cancel()
