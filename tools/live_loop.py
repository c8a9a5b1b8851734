#!/usr/bin/env python3
"""Shows a unit in the browser: after every save its picture, the wanted one, where they differ, and the
claims. Ctrl-C ends it.

A server for this machine alone. The page is the site's workbench, with tools/live/native.mjs in the place of
the compiler; it gets everything that is known, as JSON, whenever something of it changes. A click on a
picture asks both drivers to explain the pixel."""

import glob
import http.server
import json
import mimetypes
import os
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.parse

from draw import choose_look, small
from drivers import driver_of, private_folder
from grade import require_units, stop_on_signals
from grading.assignments import Parser, choose, find_unit, read_features, read_looks, read_points, run_loop
from grading.build import Toolchain
from grading.private_copy import own_folder
from grading.processor_time import limited
from grading.starters import unsolved_steps
from task_page import task_page
from watch import Check, changed_at, claims_in, command_of_tool, late_line, state

_LOOK_SECONDS = 0.05
_PATIENCE = 20  # seconds of processor time for a picture, of 400 x 400 pixels and few samples
_SOON = 3  # seconds in which most pictures are drawn
_TURNING = "turning to the next step"
_SIDE = 400  # of a picture, as large as the page shows it
_TOOLS = os.path.dirname(os.path.abspath(__file__))
_PAGE = os.path.join(_TOOLS, "workbench", "workbench.html")
_PARTS = {os.path.basename(path): path for path in (os.path.join(_TOOLS, "live", "native.mjs"),
                                                    *glob.glob(os.path.join(_TOOLS, "workbench", "*")))}
_KINDS = {".css": "text/css; charset=utf-8", ".mjs": "text/javascript; charset=utf-8",
          ".svg": "image/svg+xml"}
_SITE_OR_NATIVE = re.compile(r"(?:<!-- site -->\n.*?)?<!-- native\n(.*?)end -->\n", re.DOTALL)


_EXPLAINS = re.compile(r"^camera ray$", re.MULTILINE)
_OF_A_VIEW = re.compile(r": (--[\w-]+) goes with --debug")


def _without(options, option):
    """Returns the options without one, and without its value."""
    at = options.index(option)
    is_alone = "".join(options[at + 1 : at + 2]).startswith("--") or at + 1 == len(options)
    return options[:at] + options[at + (1 if is_alone else 2) :]


def _shown(output, start):
    """Returns the file that a driver's line names, and what the line says of it."""
    for line in output.splitlines():
        path, found, says = line.partition(": ")
        if found and path.endswith(".png") and path.startswith(start):
            return path, says
    return "", ""


class Picture:
    """The student's driver, built and drawn in a thread of its own until a newer save ends it. The claims
    matter more: it leaves them the processors."""

    def __init__(self, loop):
        self._loop, self._process, self._lock, self._ended = loop, None, threading.Lock(), False
        self._thread = threading.Thread(target=self._make, daemon=True)
        self._thread.start()

    def _run(self, command):
        """Returns the status and what was said; None if a newer save has ended it. The clock limits nothing:
        a busy machine says nothing about the unit."""
        with self._lock:
            if self._ended:
                return None
            self._process = subprocess.Popen(["nice", *command], stdin=subprocess.DEVNULL,
                                             stdout=subprocess.PIPE,
                                             stderr=subprocess.STDOUT, start_new_session=True)
        said = self._process.communicate()[0].decode(errors="replace")
        status = self._process.wait()
        if status == -signal.SIGXCPU:
            said = f"no picture after {_PATIENCE} s of processor time; does a loop in your unit never end?"
        return None if self._ended else (status, said)

    def _make(self):
        loop = self._loop
        if "wanted" not in loop.files:
            wanted = self._run(loop.drawing("wanted", loop.kit))
            if wanted:
                loop.files["wanted"], _ = _shown(wanted[1], loop.out)
        built = self._run(loop.building)
        if built and built[0]:
            loop.tell(ends="drawing", failed=built[1])
        elif built:
            said = re.sub(r"^run .*\n", "", built[1], flags=re.MULTILINE)
            loop.tell(warned=said if ": warning: " in said else "")
            commands = loop.commands()
            drawn = self._run(limited(commands[0], _PATIENCE))
            compared = self._run(limited(commands[1], _PATIENCE)) if drawn and commands[1:] else drawn
            if drawn and compared:
                loop.take_picture(*drawn, compared[1])

    def _kill(self):
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def is_over(self):
        return not self._thread.is_alive()

    def end(self):
        with self._lock:
            self._ended = True
            if self._process and self._process.poll() is None:
                self._kill()
        self._thread.join()


class Loop:
    """What is known of the unit: `known` for the page, `files` by the names of pictures."""

    def __init__(self, toolchain, feature, impl, step, folder):
        self._impl, self._feature, self._tests = impl, feature, {test.name: test
                                                                 for test in read_points(feature)}
        self._is_step_chosen, self.asked, self.goes_on = bool(step), None, False
        self._own = os.path.join(folder, feature.stem)
        of_the_kit = f"assignments/{feature.folder}/{feature.stem}"
        self.kit = None if toolchain.handed_out else toolchain.built(of_the_kit)
        self.out = os.path.join(toolchain.build, "impl", "loop")
        self.building = [*command_of_tool("drivers", "-B"), "--build", toolchain.build, "--impl", impl,
                         "--only", feature.stem, "--into", folder]
        self.files, self.changed, self._doing = {}, threading.Condition(), set()
        self.known = {"version": 0, "save": 0, "stem": feature.stem, "claims": "", "busy": "", "says": "",
                      "failed": "", "warned": "", "undrawn": "", "seconds": 0,
                      "held": [], "broken": [], "late": [],
                      "of": len(self._tests), "drawn": False, "passed": "", "next": "", "kit": bool(self.kit),
                      "unwritten": [],
                      "looks": [[look.step, look.caption] for look in read_looks(feature)]}
        self._look_at(choose_look(feature, step) if step else read_looks(feature)[0], task=step or 1)

    def _look_at(self, look, passed="", task=None):
        """Shows another step's picture from now on; `passed` tells why the one before is left. `task`: the
        step to work on, if that has no picture of its own."""
        self.files = {} if self.kit else {"wanted": look.picture}
        self._options, self._small = small(look.options, _SIDE), small(look.options)
        self.tell(step=look.step, caption=look.caption, command=f"{driver_of(self._feature)} {look.options}",
                  task=int(task or look.step), same=False, compared="", says="", undrawn="", drawn=False,
                  passed=passed, ends=_TURNING)

    def unwritten(self):
        """Returns the steps that are left to write."""
        unit = find_unit(self._feature, self._impl)
        return unsolved_steps(unit) if unit.path else []

    def task(self):
        """Returns what the page shows of the assignment."""
        page = self._feature.page()
        book = f"/{os.path.relpath(page.parent, self._feature.source)}/" if page else ""
        task = task_page(self._feature.source, self._feature, str, book,
                         lambda section: self._feature.page(section).name if page else "")
        return {**task, "file": find_unit(self._feature, self._impl).shown}

    def _next_look(self, step):
        """Returns the row of the next picture that the student can reach; None if that is shown, or another
        one was asked for."""
        looks = read_looks(self._feature)
        look = next((look for look in looks if step and int(look.step) >= int(step)), looks[-1])
        return None if self._is_step_chosen or look.step == self.known["step"] else look

    def _follow(self, step):
        """Shows the next picture; returns whether it is another."""
        look = self._next_look(step)
        if not look:
            return False
        before, is_right = self.known["step"], self.known["same"]
        held = int(step) - 1 if step else read_looks(self._feature)[-1].step
        picture = f", and the picture of step {before} is the wanted one" if is_right else ""
        self._look_at(look, f"all claims up to step {held} hold{picture}" if look.step > before else "", step)
        return True

    def file_at(self, address):
        """Returns the file of a book, or the kit's header, that the page may ask for; None if there is none
        of this name."""
        source = os.path.realpath(self._feature.source)
        path = os.path.realpath(source + urllib.parse.unquote(address))
        books = tuple(os.path.join(source, "docs", room, "") for room in ("out", "handout"))
        is_header = path.startswith(os.path.join(source, "src", "")) and path.endswith(".h")
        return path if (path.startswith(books) or is_header) and os.path.isfile(path) else None

    def drawing(self, name, driver=None):
        """Returns the command that draws the picture of this name."""
        return [driver or self._own, *self._options, "--out", os.path.join(self.out, name)]

    def commands(self):
        """Returns the commands that draw the student's picture and compare it. The wanted pictures of a pack
        are small, and so is what is compared with them."""
        compare = ["--compare", self.files["wanted"]]
        if self.kit:
            return [[*self.drawing("own"), *compare]]
        compared = [self._own, *self._small, "--quiet", "--out", os.path.join(self.out, "compared"), *compare]
        return [self.drawing("own"), compared]

    def tell(self, begins=(), ends="", **news):
        with self.changed:
            self._doing = (self._doing | set(begins)) - {ends}
            self.known.update(news, version=self.known["version"] + 1, busy=" and ".join(sorted(self._doing)))
            self.changed.notify_all()

    def take_picture(self, status, said, compared):
        """Tells of a picture that was drawn, or why there is none, and what its comparison said."""
        path, caption = _shown(said, self.out)
        comparison = next((line for line in compared.splitlines() if ": the picture " in line), "")
        difference = _shown(compared, self.out)[0][:-4] + "_difference.png"
        self.files["own"] = path or self.files.get("own", "")
        self.files["difference"] = difference if os.path.exists(difference) else ""
        self.tell(ends="drawing", drawn=bool(path),
                  undrawn=(said or f"the driver ended with status {status}") if status else "", says=caption,
                  same=comparison.endswith("is the same"),
                  compared=comparison.partition(": the picture ")[2].partition(";")[0])

    def explain(self, pixel):
        """Returns the explanations of a pixel by the student's unit and by the kit's, or why a picture has
        none. Some debug views show the scene and do not explain it: then it is explained without them and the
        options that go with them."""
        options, option = self._options, "--debug"
        texts = self._explain(options, pixel)
        while option in options and not _EXPLAINS.search(texts[0]):
            if "there is no pixel to explain" in texts[0]:
                return [texts[0]]
            options = _without(options, option)
            texts = self._explain(options, pixel)
            odd = _OF_A_VIEW.search(texts[0])
            option = odd[1] if odd else ""
        return texts

    def _explain(self, options, pixel):
        runs = [subprocess.Popen(limited([driver, *options, "--pixel", pixel, "--quiet", "--out",
                                          os.path.join(self.out, f"pixel{at}")], _PATIENCE),
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                for at, driver in enumerate(filter(None, (self._own, self.kit)))]
        texts = []
        for run in runs:
            said = run.communicate()[0].decode(errors="replace")
            texts.append(f"no answer after {_PATIENCE} s of processor time\n"
                         if run.returncode == -signal.SIGXCPU else said)
        return texts

    def look_asked(self):
        """Turns to the step that the page has asked for, "" for the next one after the claims; returns
        whether it is another."""
        step, self.asked = self.asked, None
        self._is_step_chosen = bool(step)
        if not step:
            return self._follow(self._first_step())
        if step == str(self.known["step"]):
            return False
        self._look_at(choose_look(self._feature, step))
        return True

    def _first_step(self):
        """Returns the step of the first broken claim, "" if none is broken."""
        return next((str(claim["step"]) for claim in self.known["broken"] if claim["step"]), "")

    def _take_claims(self, claims, seconds):
        """Tells the grader's verdict, and at once whether another picture follows."""
        step = self._first_step()
        self.known["claims"] = claims
        self.tell(begins=[_TURNING] if self._may_go_on() else [], ends="checking the claims", seconds=seconds)
        if step and not self._is_step_chosen:
            self.tell(task=int(step))  # which may have no picture of its own

    def _may_go_on(self):
        """Whether the picture of the first broken claim is another."""
        step = self._first_step()
        return ((step or self.known["claims"].startswith("ok")) and not self._loops_forever()
                and self._next_look(step))

    def _tell_claims_of(self, record):
        """Tells which claims have ended, from the grader's record: those that hold, and those that are broken
        or late with their reasons, in the order of work."""
        claims = claims_in(record)
        ended = [{"name": name, "points": test.points, "step": test.step, **claims[name]}
                 for name, test in self._tests.items() if name in claims]
        news = {"held": [claim["name"] for claim in ended if claim["passed"]],
                "broken": [claim for claim in ended if not claim["passed"] and not claim["is_open"]],
                "late": [claim for claim in ended if claim["is_open"]]}
        if any(self.known[name] != found for name, found in news.items()):
            self.tell(**news)

    def _loops_forever(self):
        return any(claim["reason"].startswith("did not end") for claim in self.known["broken"])

    def _is_left(self, now, seen):
        """Whether the student goes on to the next assignment: by the page's button, or by saving another
        file."""
        return self.known["next"] and (self.goes_on or now != seen and f"{self._feature.stem}.c" not in
                                       {name for name, *_ in set(now) ^ set(seen)})

    def run(self, grader, kept, judged=None, screen=None):
        """Draws and checks at once and after every save, until interrupted. `judged` is called with each
        verdict; it returns the name of the next assignment once this one is done, and the loop ends when the
        student goes on to that. A screen shows which claim is late."""
        seen, check, picture, is_judged, record = None, None, None, False, os.path.join(kept, "claims")
        try:
            while True:
                now = state(self._impl)
                if self._is_left(now, seen):
                    return
                if now != seen:
                    for work in filter(None, (check, picture)):
                        work.end()
                    seen, saved = now, time.monotonic()
                    before = changed_at(record)
                    self.tell(begins=("drawing", "checking the claims"), save=self.known["save"] + 1,
                              failed="", undrawn="", held=[], broken=[], late=[], drawn=False, same=False,
                              compared="", says="", passed="", next="", unwritten=self.unwritten(),
                              ends=_TURNING)
                    check, picture, is_judged, told = Check(grader), Picture(self), False, None
                elif self.asked is not None:
                    if self.look_asked():
                        picture.end()
                        self.tell(begins=["drawing"])
                        picture = Picture(self)
                elif check and check.is_over():
                    claims = check.verdict()
                    if changed_at(record) != before:
                        self._tell_claims_of(record)
                    check.end()
                    check, is_judged = None, True
                    self._take_claims(claims, round(time.monotonic() - saved, 1))
                    if judged:
                        self.tell(next=judged(claims))
                elif is_judged and picture.is_over():
                    is_judged = False
                    if self._may_go_on() and self._follow(self._first_step()):
                        self.tell(begins=["drawing"])
                        picture = Picture(self)
                    else:
                        self.tell(ends=_TURNING)
                elif check and changed_at(record) != before:
                    self._tell_claims_of(record)
                    if screen and self.known["late"] and self.known["late"][0] != told:
                        told = self.known["late"][0]
                        screen.status(late_line(told))
                    if self._loops_forever() and not picture.is_over() and time.monotonic() - saved > _SOON:
                        picture.end()  # its threads slow down the rest of the claims
                        self.tell(ends="drawing", undrawn="no picture: a claim did not end, and the picture "
                                                          "might not, either")
                time.sleep(_LOOK_SECONDS)
        except KeyboardInterrupt:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)  # a second one changes nothing
            raise
        finally:
            for work in filter(None, (check, picture)):
                work.end()


class Page(http.server.BaseHTTPRequestHandler):
    """Answers the page: /, its _PARTS, /task, /events, /picture/NAME, /pixel?X,Y, /look?STEP, /next, the book
    in /docs, and headers in /src."""

    def log_message(self, *_):
        pass

    def _answer(self, content, kind):
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(content)

    def do_GET(self):  # pylint: disable=invalid-name
        loop, place = self.server.loop, urllib.parse.urlparse(self.path)
        name = place.path.rpartition("/")[2]
        host = self.headers.get("Host", "").replace("localhost", "127.0.0.1")
        if host != self.server.host:  # a page from elsewhere that names this machine
            self.send_error(403)
        elif place.path == "/":
            with open(_PAGE, encoding="utf-8") as file:
                self._answer(_SITE_OR_NATIVE.sub(r"\1", file.read()).encode(), "text/html; charset=utf-8")
        elif name in _PARTS and place.path == f"/{name}" and (kind := _KINDS.get(os.path.splitext(name)[1])):
            with open(_PARTS[name], "rb") as file:
                self._answer(file.read(), kind)
        elif place.path == "/task":
            self._answer(json.dumps(loop.task()).encode(), "application/json")
        elif place.path == "/events":
            self._send_events()
        elif place.path == "/pixel" and place.query.replace(",", "", 1).isdigit():
            self._answer(json.dumps(loop.explain(place.query)).encode(), "application/json")
        elif place.path == "/look" and place.query in ["", *(str(step) for step, _ in loop.known["looks"])]:
            loop.asked = place.query
            self._answer(b"", "text/plain")
        elif place.path == "/next":
            loop.goes_on = True
            self._answer(b"", "text/plain")
        elif place.path.startswith(("/docs/", "/src/")) and (path := loop.file_at(place.path)):
            with open(path, "rb") as file:
                self._answer(file.read(), mimetypes.guess_type(path)[0] or "application/octet-stream")
        elif place.path.startswith("/picture/") and os.path.isfile(loop.files.get(name, "")):
            with open(loop.files[name], "rb") as file:
                self._answer(file.read(), "image/png")
        else:
            self.send_error(404)

    def _send_events(self):
        self._answer(b"", "text/event-stream")
        sent = None
        try:
            while True:
                loop = self.server.loop
                with loop.changed:
                    loop.changed.wait_for(lambda: self.server.loop is not loop  # noqa: B023
                                          or (loop, loop.known["version"]) != sent, timeout=5)
                    sent, text = (loop, loop.known["version"]), json.dumps({**loop.known, "pictures": {
                        name: str(changed_at(path)) for name, path in loop.files.items() if path}})
                self.wfile.write(f"data: {text}\n\n".encode())
                self.wfile.flush()
        except OSError:
            pass  # the page is closed


class Server:
    """The page's server, for this machine alone; `show` turns it to a loop."""

    def __init__(self):
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page)
        self._server.daemon_threads, self._server.host = True, f"127.0.0.1:{self._server.server_port}"
        self.url, self._is_shown = f"http://{self._server.host}/", False

    def show(self, loop):
        self._server.loop = loop
        loop.tell()
        if not self._is_shown:
            threading.Thread(target=self._server.serve_forever, daemon=True).start()
            self._is_shown = True


def grader_of(stem, build, impl, kept):
    """Returns the command that checks a unit, and keeps in a folder what makes the next check faster."""
    return [*command_of_tool("grade", "-X", f"pycache_prefix={os.path.join(kept, 'python')}"), stem,
            "--build", build, "--impl", impl, "--own", "--kept", kept]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--step", default="", metavar="N",
                        help="of the handout; the first that is not done for none")
    arguments = parser.parse_args()
    stop_on_signals()

    def work():
        toolchain = Toolchain(arguments.build)
        feature = choose(read_features(toolchain.source), [arguments.stem])[0]
        require_units(arguments.build, [arguments.stem], arguments.impl)
        with own_folder() as kept, private_folder(toolchain) as folder:
            loop = Loop(toolchain, feature, arguments.impl, arguments.step, folder)
            server = Server()
            server.show(loop)
            print(f"open {server.url} in a browser of this machine, and edit {arguments.impl}; "
                  "Ctrl-C ends", flush=True)
            loop.run(grader_of(arguments.stem, arguments.build, arguments.impl, kept), kept)

    return run_loop("live", os.path.abspath(arguments.build), work)


if __name__ == "__main__":
    sys.exit(main())
