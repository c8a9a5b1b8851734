"""Frames as a film, by ffmpeg, where it is installed."""

import os
import re
import shutil
import subprocess

from grading.assignments import ToolError
from grading.temporary_folder import temporary_folder
from png import size_of

NAME = "sweep.mp4"


def read_rate(text):
    """Returns the frames per second that ANIMATE asks for, or None without it."""
    if text in ("", "no"):
        return None
    if not re.fullmatch(r"yes|[1-9]\d?", text):
        raise ToolError(f"ANIMATE={text}: say yes, for 25 frames per second, or how many, up to 99")
    if not shutil.which("ffmpeg"):
        raise ToolError("ANIMATE needs ffmpeg (Debian: apt-get install ffmpeg); without it, leave ANIMATE "
                        "out: the frames are numbered, for any other program")
    return 25 if text == "yes" else int(text)


def write(out, names, rate):
    """Makes OUT/sweep.mp4 of pictures of the same size, whose names are 0001.png and so on; returns its
    path."""
    sizes = {size_of(os.path.join(out, name)) for name in names}
    if len(sizes) > 1:
        raise ToolError("ANIMATE: the frames have different sizes; give all the same --width and --height")
    path = os.path.join(out, NAME)
    with temporary_folder(".sweep-", out) as folder:
        part = os.path.join(folder, NAME)
        # The film's coding takes even sizes, and colours that all players know.
        ended = subprocess.run(
            ["ffmpeg", "-nostdin", "-loglevel", "error", "-framerate", str(rate), "-start_number", "1", "-i",
             os.path.join(os.path.abspath(out).replace("%", "%%"), "%04d.png"), "-frames:v", str(len(names)),
             "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", part],
            stdin=subprocess.DEVNULL, check=False)
        if ended.returncode or not os.path.exists(part):
            raise ToolError("ffmpeg could not make the film; its reason is above, and the frames are there")
        os.replace(part, path)
    return path
