"""Temporary folders in places where those of killed processes would stay for good. Each has a lock file, and
the system ends the lock with its process: a folder that can be locked is nobody's."""

import contextlib
import fcntl
import glob
import os
import shutil
import tempfile
import time

TRIES, PAUSE = 40, 0.05  # of removing what processes that are ending still write into


def _open_lock(folder):
    return os.open(os.path.join(folder, ".lock"), os.O_RDWR | os.O_CREAT, 0o600)


def remove_left(prefix, place):
    """Removes the folders of this prefix in `place` whose process no longer lives."""
    for folder in glob.glob(os.path.join(glob.escape(place), prefix + "*")):
        try:
            lock = _open_lock(folder)
        except OSError:  # another user's, or removed meanwhile
            continue
        with contextlib.suppress(OSError):  # where there are no locks, nobody knows
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def _is_lock_of(lock, folder):
    try:
        return os.path.samestat(os.fstat(lock), os.stat(os.path.join(folder, ".lock")))
    except FileNotFoundError:
        return False


def _make(prefix, place):
    """Returns a new folder and the descriptor of its lock."""
    while True:
        folder = tempfile.mkdtemp(prefix=prefix, dir=place)
        try:
            lock = _open_lock(folder)
        except FileNotFoundError:
            continue
        except OSError:
            os.rmdir(folder)
            raise
        with contextlib.suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX)
        if _is_lock_of(lock, folder):
            return folder, lock
        os.close(lock)  # before it was locked, another process took it for one that was left


def _remove(folder):
    for _ in range(TRIES):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.exists(folder):
            return
        time.sleep(PAUSE)


@contextlib.contextmanager
def temporary_folder(prefix, place):
    """Gives a folder of this prefix in `place`, and removes it in the end; before that, it removes those that
    killed processes left."""
    remove_left(prefix, place)
    folder, lock = _make(prefix, place)
    try:
        yield folder
    finally:
        _remove(folder)
        os.close(lock)
