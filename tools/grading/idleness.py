"""How long have some processes done nothing, though the machine would have let them?

A program that sleeps takes no processor time, which is what else is limited; one that waits for a slow
machine does not sleep.
"""

import os
import time

_LONGEST = 0.1  # seconds that count of a look: while nobody looks, the machine may have stood still
_BUSY = 0.5  # of the time, so much work, or waiting for a processor, is no sleep


class Idleness:
    """`seconds` is the time at which none of the processes did anything."""

    def __init__(self):
        self.seconds, self._looked, self._times = 0.0, time.monotonic(), {}

    def look(self, processes):
        """To be called often, with the processes that there are; returns the seconds so far."""
        now = time.monotonic()
        passed, self._looked = now - self._looked, now
        states, times = "", {}
        for pid in processes:
            for thread in _threads(pid):
                state, nanoseconds = _look_at(thread)
                states += state
                times[thread] = nanoseconds
        worked = sum(max(0, spent - self._times.get(thread, 0)) for thread, spent in times.items()) / 1e9
        self._times = times
        # Sleeping, stopped, or ended; R works or waits for a processor, and D for a disk.
        if states and not states.strip("STtZX") and worked < _BUSY * passed:
            self.seconds += min(passed, _LONGEST)
        return self.seconds


def _threads(pid):
    try:
        return [f"/proc/{pid}/task/{thread}" for thread in os.listdir(f"/proc/{pid}/task")]
    except OSError:
        return []


def _look_at(thread):
    """Returns the state's letter, "" if the thread has ended, and the nanoseconds that it worked or waited
    for a processor, 0 if the system does not tell."""
    try:
        with open(thread + "/stat", encoding="ascii", errors="replace") as file:
            state = file.read().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return "", 0
    try:
        with open(thread + "/schedstat", encoding="ascii") as file:
            return state, sum(map(int, file.read().split()[:2]))
    except (OSError, ValueError):
        return state, 0
