"""Limits what a command may compute, not how long it may take on a busy machine."""


def limited(command, seconds):
    """Returns the command with a limit of whole seconds of processor time, at which SIGXCPU ends it. By a
    shell, since Python's own way to set limits between fork and exec is not safe in threads."""
    return ["/bin/sh", "-c", 'ulimit -S -t "$0" && exec "$@"', str(max(1, round(seconds))), *command]
