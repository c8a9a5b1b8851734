#!/usr/bin/env python3
"""Sweeps of small pictures: all combinations, the same pictures as by the driver alone, and what is done
stays done, whether stopped, killed or out of space. Speaks TAP, for make check-sweep; runs in a build
folder."""

import contextlib
import csv
import glob
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from grading import parallel_jobs  # noqa: E402
from grading.assignments import ToolError, read_features  # noqa: E402
from png import filtered_rows, size_of  # noqa: E402
from sweeping import values  # noqa: E402
from sweeping.picture import texts_of  # noqa: E402
from tap import check, finish, read, run, start, wait, write  # noqa: E402

MAKE = os.environ.get("MAKE", "make")
FEATURES = read_features(SOURCE)
SMALL = "--scene teapot:2 --width 24 --height 20"
SLOW = "--scene teapot:2 --width 64 --height 64 --samples 512"  # a tenth of a second or two
TRIANGLE = "mtllib paint.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def driver(stem):
    return os.path.abspath(os.path.join("assignments", FEATURES[stem].folder, stem))


def command(out, vary, options=SMALL, *more, stem="normals"):
    return [sys.executable, "-B", os.path.join(SOURCE, "tools", "sweep.py"), f"--driver={stem}",
            f"--out={out}", f"--vary={vary}", f"--options={options}", *more]


def sweep(*arguments, **more):
    return run(".", *command(*arguments, **more))


def _rows(out):
    with contextlib.suppress(FileNotFoundError):
        return rows_of(out)


def rows_of(out):
    with open(os.path.join(out, "sweep.csv"), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def pixels(path):
    """Returns size and pixels of a PNG file, without its texts, which say how long it took."""
    return size_of(path), filtered_rows(path)


def pictures(out):
    return {name: pixels(os.path.join(out, name)) for name in sorted(os.listdir(out))
            if name.endswith(".png")}


def alone(folder, *words, stem="normals", options=SMALL):
    """Returns the driver's own picture."""
    out = tempfile.mkdtemp(dir=folder)
    run(".", driver(stem), *options.split(), *words, "--quiet", "--out", out)
    return glob.glob(os.path.join(glob.escape(out), "figures", "*.png"))[0]


def copies():
    """Returns the folders in which sweeps have copies of their drivers."""
    return set(glob.glob(os.path.join("impl", "drivers-*")))


def hidden(out):
    return [name for name in os.listdir(out) if name.startswith(".")]


def lists_and_ranges_combine(_folder):
    names, frames = values.frames("--aperture=0.01,0.02 --focus=2:6:3", [])
    check(names == ["aperture", "focus"] and frames == [
        ("0.01", "2"), ("0.01", "4"), ("0.01", "6"), ("0.02", "2"), ("0.02", "4"), ("0.02", "6")],
        "all combinations, both ends of a range, the last option fastest", frames)

    def of(text):
        return [frame[0] for frame in values.frames(f"--x={text}", [])[1]]

    check(of("1:0:4") == ["1", "0.666666667", "0.333333333", "0"] and of("0,1:2:2,9") == ["0", "1", "2", "9"]
          and of("-1:1:3") == ["-1", "0", "1"] and of("0.1:0.3:3") == ["0.1", "0.2", "0.3"],
          "ranges go down, stand in lists, begin below 0, and have no noise in their digits", of("1:0:4"))
    check(of("1,2;3,4") == ["1,2", "3,4"] and of("statue:87130,teapot") == ["statue:87130", "teapot"]
          and of("'a b'") == ["a b"] and of("-x,z") == ["-x", "z"],
          "values hold commas, colons, spaces and dashes", of("1,2;3,4"))


def what_cannot_be_varied_is_told(folder):
    for vary, options, reason in (
            ("", "", "say which option"), ("--x", "", "write --option="), ("x=1", "", "write --option="),
            ("--x=1:2:1", "", "from:to:count"), ("--x=1:2:many", "", "from:to:count"),
            ("--x='1", "", "each quote needs its other one"),
            ("--x=1 --x=2", "", "twice"), ("--x=1,2", "--x=3", "VARY and in OPTIONS"),
            ("--x=1,2", "--out there", "OUT=..."), ("--x=1:2:101 --y=1:2:101", "", "10201 combinations")):
        try:
            values.frames(vary, values.words_of("OPTIONS", options))
            said = ""
        except ToolError as error:
            said = str(error)
        check(reason in said, f"VARY={vary}: {reason}", said)
    out = os.path.join(folder, "nothing")
    for arguments, reason in (((out, "--yaw=1,2"), "choose one of: normals"),
                              (("", "--yaw=1,2"), "OUT=pictures")):
        status, said = sweep(*arguments, stem="normal" if arguments[0] else "normals")
        check(status == 2 and reason in said and said.count("\n") == 1 and not os.path.exists(out),
              f"nothing is begun without {reason}", said)
    write("x", folder, "file")
    status, said = sweep(os.path.join(folder, "file", "below"), "--yaw=1,2")
    check(status == 2 and "cannot be written" in said, "a folder that cannot be is told", said)


def frames_are_the_drivers_pictures(folder):
    out = os.path.join(folder, "frames")
    status, said = sweep(out, "--yaw=-20:20:3 --distance=3,4.5")
    rows = rows_of(out)
    told = [[row[name] for name in ("frame", "files", "yaw", "distance", "status")] for row in rows]
    both = [(yaw, distance) for yaw in ("-20", "0", "20") for distance in ("3", "4.5")]
    check(status == 0 and told == [[str(n), f"000{n}.png", *chosen, "0"] for n, chosen in enumerate(both, 1)],
          "a table says which options each frame has", f"{said}\n{rows}")
    own = [pixels(alone(folder, f"--yaw={row['yaw']}", "--distance", row["distance"])) for row in rows]
    check(list(pictures(out).values()) == own and len(set(own)) == 6 and not hidden(out),
          "a frame is the picture that the driver draws by itself", said)
    check(all(float(row["seconds"]) >= float(row["render_seconds"]) > 0 for row in rows)
          and {row["triangle_count"] for row in rows} == {"240"}, "it says what the driver reports", rows)
    for jobs in ("1", "3"):
        other = os.path.join(folder, f"{jobs} at once")
        status, said = sweep(other, "--yaw=-20:20:3 --distance=3,4.5", SMALL, f"--jobs={jobs}")
        check(status == 0 and pictures(other) == pictures(out), f"JOBS={jobs} draws the same", said)
    status, said = sweep(os.path.join(folder, "hosts"), "--yaw=-20,0", SMALL, "--hosts=:", "--jobs=2")
    check(status == 0 and len(pictures(os.path.join(folder, "hosts"))) == 2,
          "so does this machine as one of HOSTS", said)


def numbers_are_the_drivers(folder):
    out, table = os.path.join(folder, "numbers"), os.path.join(folder, "timed")
    status, said = sweep(out, "--samples=1,4", f"{SMALL} --shadows", stem="shading")
    run(".", driver("shading"), *SMALL.split(), "--shadows", "--samples=4", "--timing", "--out", table)
    with open(os.path.join(table, "tables", "shading.csv"), encoding="utf-8", newline="") as file:
        rays = [row for row in csv.reader(file) if "rays_per_pixel" in row]
    counted = rows_of(out)[1]["ray_count"]
    check(status == 0 and any(abs(float(cell) - int(counted) / 480) < 1e-3 for cell in rays[0]
                              if cell.replace(".", "").isdigit()),
          "the rays of a frame are those that the driver counts", f"{counted}, {rays}")
    options = "--scene cornell-light --width 24 --height 20 --max-samples 64"
    status, said = sweep(out + "2", "--error=0.05,0.2", options, stem="adaptive_sampling")
    errors = [float(row["estimated_error"]) for row in rows_of(out + "2")]
    check(status == 0 and 0 < errors[0] < errors[1], "adaptive sampling reports its error", f"{said}{errors}")
    status, said = sweep(out + "3", "--yaw=0,9", SMALL + " --timing")
    tables = sorted(os.listdir(out + "3"))
    check(status == 0 and tables == ["0001_normals.csv", "0002_normals.csv", "sweep.csv"],
          "tables of a driver are numbered, too", said)
    status, said = sweep(out + "4", "--pixel=2,3;4,5")
    check(status == 0 and "pixel (4, 5)" in read(out + "4", "0002_said.txt"), "so is what it explains", said)
    status, said = sweep(out + "6", "--yaw=0,1", f"{SMALL} --compare '{out}4/0001.png'")
    check(status == 0 and os.path.exists(os.path.join(out + "6", "0002.png"))
          and len(glob.glob(os.path.join(out + "6", "0002_*_difference.png"))) == 1,
          "a difference stands beside its picture", said)
    status, said = sweep(out + "5", "--aperture=1,2")
    check(status == 0 and said.count("--aperture changes nothing") == 1 and "(2 frames)" in said,
          "what the driver remarks is said once", said)


def done(said):
    """Returns how many frames were rendered."""
    for line in said.splitlines():
        words = line.split()
        if line.startswith("sweep: ") and "frames are done" in line:
            return int(words[1]) - int(words[7])
    return None


def what_is_there_is_not_rendered_again(folder):
    out, mesh = os.path.join(folder, "again"), os.path.join(folder, "mesh")
    write(TRIANGLE, mesh, "a.obj")
    write("newmtl red\nKd 1 0 0\n", mesh, "paint.mtl")
    options = f"--mesh '{mesh}/a.obj' --width 24 --height 20"

    def again(more=options, vary="--yaw=0:40:3", *flags):
        status, said = sweep(out, vary, more, *flags)
        return done(said) if status == 0 else said

    check([again(), again()] == [3, 0], "the same command renders nothing again")
    write("damaged", out, "0002.png")
    os.unlink(os.path.join(out, "0003.png"))
    check(again() == 2, "a frame that is damaged or gone is rendered")
    check(again(options, "--yaw=0,20,45") == 1 and again(options, "--yaw=0,20,45,50") == 1,
          "so is one whose options have changed")
    status, said = sweep(out, "--yaw=0,20", options)
    check(status == 2 and "0003.png" in said and "another folder" in said,
          "frames of a longer sweep are told", said)
    check(again(options + " --samples 2", "--yaw=0,20,45,50") == 4, "other OPTIONS are other frames")
    check(again(options, "--yaw=0,20,45,50") == 4 and again(options, "--yaw=0,20,45,50", "--again") == 4,
          "AGAIN renders all")
    write("newmtl red\nKd 1 1 0\n", mesh, "paint.mtl")
    check(again(options, "--yaw=0,20,45,50") == 4, "a mesh whose material has changed is another one")
    write(TRIANGLE.replace("0 1 0", "0 2 0"), mesh, "a.obj")
    check(again(options, "--yaw=0,20,45,50") == 4, "so is one whose vertices have")
    own = os.path.join(folder, "own")
    write(read(FEATURES["normals"].reference), own, "normals.c")
    check([again(options, "--yaw=0,20,45,50", "--impl", own) for _ in range(2)] == [4, 0],
          "a student's unit draws other frames, once")


# However quick a driver is, Python begins for each frame: so many take seconds, and the table is written
# each second.
MANY, MANY_FRAMES = "--yaw=0:40:30", 30


def _drivers(out):
    """Returns the numbers of the drivers that render for this folder."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{name}/cmdline", "rb") as file:
            words = file.read().split(b"\0")
            if words[0].endswith(b"/normals") and any(word.startswith(os.fsencode(out)) for word in words):
                found.append(int(name))
    return found


def begin(*arguments):
    return subprocess.Popen(command(*arguments), stdout=subprocess.PIPE, text=True,
                            stderr=subprocess.STDOUT, start_new_session=True)


def expected(folder):
    out = os.path.join(folder, "expected")
    if not os.path.exists(out):
        sweep(out, MANY, SLOW)
    return pictures(out)


def a_sweep_is_interrupted(folder):
    for jobs in ("1", "2"):
        for number in (signal.SIGINT, signal.SIGKILL) if jobs == "2" else (signal.SIGTERM,):
            status = -number if number == signal.SIGKILL else 130
            out, before = os.path.join(folder, f"{jobs} {number.name}"), copies()
            process = begin(out, MANY, SLOW, f"--jobs={jobs}")
            begun = wait(lambda out=out: _rows(out) and _drivers(out))
            process.send_signal(number)
            said = process.communicate()[0]
            check(begun and process.returncode == status and (number == signal.SIGKILL or "goes on" in said),
                  f"a sweep is stopped by {number.name} (JOBS={jobs})", said)
            check(wait(lambda out=out: not _drivers(out)), "no driver outlives it")
            check(number == signal.SIGKILL or not hidden(out), "and nothing is half-written", hidden(out))
            left = copies() - before
            check(bool(left) == (number == signal.SIGKILL), "nor is a copy of the driver left, unless killed",
                  list(left))
            _, said = sweep(out, MANY, SLOW)
            check(not left & copies(), "which the next sweep removes", list(copies()))
            check(pictures(out) == expected(folder) and not hidden(out)
                  and 0 < (done(said) or MANY_FRAMES) < MANY_FRAMES, "the same command goes on", said)


def a_killed_driver_is_tried_again(folder):
    for jobs in ("1", "2"):
        out = os.path.join(folder, f"{jobs} victims")
        process = begin(out, MANY, SLOW, f"--jobs={jobs}")
        victims = wait(lambda out=out: _drivers(out))
        for victim in victims:
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
        said = process.communicate()[0]
        check(victims and process.returncode == 0 and pictures(out) == expected(folder),
              f"a driver that is killed is tried again (JOBS={jobs})", said)


def a_refused_option_is_told_once(folder):
    for jobs in ("1", "2"):
        out = os.path.join(folder, f"{jobs} refused")
        status, said = sweep(out, "--yaw=0,10", SMALL)
        status, said = sweep(out, "--yaw=400:500:50", SMALL, f"--jobs={jobs}")
        check(status == 1 and said.count("--yaw 400: it takes a number, -360 to 360") == 1
              and len(said.splitlines()) <= 4 and "mend VARY" in said,
              f"the driver's reason is said once, and it stops (JOBS={jobs})", said)
        status, said = sweep(out, "--yaw=0,10", SMALL)
        check(done(said) == 0, "and what was there stays", said)
    status, said = sweep(out, "--yaw=0,400,10", SMALL)
    rows = rows_of(out)
    check(status == 1 and [row["status"] for row in rows] == ["0", "1", "0"]
          and "--yaw 400" in rows[1]["reason"], "the table has its reason", rows)
    status, said = sweep(out, "--speed=1:9:9", SMALL)
    check(status == 1 and "there is no such option" in said, "an option that is not there is told", said)


def a_full_disk_is_told(folder):
    small = os.path.join(folder, "small disk")
    os.mkdir(small)
    script = ('mount -t tmpfs -o size=100k none "$0" || exit 99; "$@"; echo "status $?"; ls -A "$0"; '
              'mount -o remount,size=10m none "$0"; "$@"; echo "status $?"')
    for jobs in ("1", "2"):
        status, said = run(
            ".", "unshare", "--user", "--map-root-user", "--mount", "sh", "-c", script, small,
            *command(small, "--yaw=0:40:9", "--width 200 --height 200 --environment sky", f"--jobs={jobs}"))
        if status in (1, 99) and "status" not in said:
            check(True, f"a full disk (JOBS={jobs}) # SKIP no disk can be made here")
            continue
        first, _, second = said.partition("status 75")
        check(second and "No space left" in first and "free some space" in first.splitlines()[-1],
              f"a full disk is told (JOBS={jobs})", said)
        check("9 of 9 frames are done" in second and "status 0" in second and ", 0 of them" not in second,
              "with space, the same command goes on", said)


def values_reach_the_driver_as_they_are(folder):
    strange = os.path.join(folder, "it's $(touch pwned) \"a\" {} %04d;&*")
    write(TRIANGLE, strange, "-mesh `touch pwned` $HOME.obj")
    mesh = os.path.join(strange, "-mesh `touch pwned` $HOME.obj")
    quoted = mesh.replace("'", "'\\''")
    out = os.path.join(strange, "out")
    status, said = run(".", MAKE, "-s", "sweep", "DRIVER=normals", f"OUT={out}", "VARY=--yaw=-10,10",
                       f"OPTIONS=--mesh '{quoted}' --width 24 --height 20", "JOBS=2")
    check(status == 0 and len(pictures(out)) == 2, "names of any letters are passed on", said)
    own = alone(folder, "--mesh", mesh, "--yaw", "-10", options="--width 24 --height 20")
    check(pictures(out).get("0001.png") == pixels(own), "as they are", said)
    status, said = run(".", MAKE, "-s", "sweep", "DRIVER=normals", f"OUT={out}2",
                       "VARY=--scene='$(touch pwned)','a b','-'", f"OPTIONS={SMALL.partition(' ')[0]}")
    check(status != 0 and not glob.glob("pwned") and not glob.glob(os.path.join(folder, "**", "pwned")),
          "no shell sees them", said)


def without_gnu_parallel_it_works(folder):
    write("#!/bin/sh\necho 'parallel: invalid option'\n", folder, "tools", "parallel")
    os.chmod(os.path.join(folder, "tools", "parallel"), 0o755)
    out = os.path.join(folder, "without")
    with mock.patch.dict(os.environ, PATH=os.path.join(folder, "tools") + ":" + os.environ["PATH"]):
        status, said = sweep(out, "--yaw=0,10")
        is_said = parallel_jobs.processors() == 1 or "as GNU parallel is not installed" in said
        check(status == 0 and is_said and len(pictures(out)) == 2,
              "one after the other without GNU parallel", said)
        status, said = sweep(out + "2", "--yaw=0,10,20", SMALL, "--jobs=2")
        check(status == 2 and "need GNU parallel" in said, "JOBS needs it", said)
    status, said = sweep(out + "2", "--yaw=0,10", SMALL, "--jobs=many")
    check(status == 2 and "JOBS=many" in said, "JOBS is a number", said)


def threads_are_divided(folder):
    out = os.path.join(folder, "threads")
    count = parallel_jobs.processors()
    for jobs, frames in ((1, 1), (2, 2), (2, 1)):
        sweep(out, f"--yaw={','.join(map(str, range(frames)))}", SMALL, f"--jobs={jobs}", "--again")
        threads = max(1, count // min(jobs, frames))
        said = texts_of(os.path.join(out, "0001.png"))["command"]
        check(f"--threads {threads} " in said, f"{frames} frames, JOBS={jobs}: {threads} threads each", said)
        shutil.rmtree(out)
    sweep(out, "--threads=1,2")
    check("--threads=2" in texts_of(os.path.join(out, "0002.png"))["command"], "threads can be varied, too")


def two_sweeps_do_not_mix(folder):
    out, before = os.path.join(folder, "two"), copies()
    process = begin(out, MANY, SLOW)
    wait(lambda: _drivers(out))
    own = copies() - before
    status, said = sweep(out + " others", "--yaw=0,1")
    check(status == 0 and own and own <= copies(), "a sweep leaves another one its driver", said)
    status, said = sweep(out, "--yaw=0,1")
    check(status == 2 and "another sweep" in said, "a folder into which another one is writing is told", said)
    process.send_signal(signal.SIGTERM)
    process.communicate()
    write("a photo", folder, "photos", "0002.png")
    status, said = sweep(os.path.join(folder, "photos"), "--yaw=0,1")
    check(status == 2 and "not a sweep's" in said and read(folder, "photos", "0002.png") == "a photo",
          "no picture of others is replaced", said)
    write("name;points\nann;3\n", folder, "foreign", "sweep.csv")
    status, said = sweep(os.path.join(folder, "foreign"), "--yaw=0,1")
    check(status == 2 and "another program's table" in said, "so is a table of others", said)


def a_film_is_made(folder):
    out, tools = os.path.join(folder, "film"), os.path.join(folder, "no tools")
    os.mkdir(tools)
    with mock.patch.dict(os.environ, PATH=tools):
        status, said = sweep(out, "--yaw=0,10", SMALL, "--animate=yes")
    check(status == 2 and "apt-get install ffmpeg" in said and not os.path.exists(out),
          "without ffmpeg it says so before it renders", said)
    status, said = sweep(out, "--yaw=0,10", SMALL, "--animate=fast")
    check(status == 2 and "ANIMATE=fast" in said, "a rate is a number", said)
    write("#!/bin/sh\nfor last; do :; done\necho \"$@\" >\"$last\"\n", tools, "ffmpeg")
    os.chmod(os.path.join(tools, "ffmpeg"), 0o755)
    with mock.patch.dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}"):
        status, said = sweep(out, "--yaw=0,10", SMALL, "--animate=12")
        film = os.path.join(out, "sweep.mp4")
        check(status == 0 and os.path.exists(film) and "-framerate 12" in read(film)
              and not hidden(out), "ffmpeg makes a film of the frames", said)
        status, said = sweep(out, "--width=10,20", SMALL.partition(" --width")[0], "--animate=yes")
        check(status == 2 and "different sizes" in said, "of one size", said)
    if shutil.which("ffmpeg"):
        status, said = sweep(out + "2", "--yaw=0:10:3", SMALL.replace("24", "25"), "--animate=yes")
        check(status == 0 and os.path.getsize(os.path.join(out + "2", "sweep.mp4")) > 500,
              "the real one, too", said)


def main():
    folder = tempfile.mkdtemp(prefix="raykit-test-sweep-")
    try:
        if not parallel_jobs.find_parallel():
            print("1..0 # SKIP needs GNU parallel")
            return 0
        for claim in (lists_and_ranges_combine, what_cannot_be_varied_is_told,
                      frames_are_the_drivers_pictures, numbers_are_the_drivers,
                      what_is_there_is_not_rendered_again, a_sweep_is_interrupted,
                      a_killed_driver_is_tried_again, a_refused_option_is_told_once, a_full_disk_is_told,
                      values_reach_the_driver_as_they_are, without_gnu_parallel_it_works, threads_are_divided,
                      two_sweeps_do_not_mix, a_film_is_made):
            claim(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
