#!/usr/bin/env python3
"""Makes an album of a student's own pictures: a page with a row for each assignment and a picture for each
of its steps that is written, beside the wanted one. A picture is drawn once, and again when its unit has
changed."""

import contextlib
import hashlib
import html
import os
import subprocess
import sys

from draw import SECONDS, small
from drivers import Drivers, private_folder
from grading import build
from grading.assignments import (Parser, check_impl, choose, find_unit, read_features, read_looks,
                                 run_command)
from grading.processor_time import limited
from grading.results import command_of, write_whole
from grading.starters import unsolved_steps
from handout_text import handout_of

_SIDE = 128  # of a picture, as of the wanted one: larger ones would be shrunk, with thinner lines

_STYLE = """
:root { color-scheme: light dark; --line: #8884; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin: 2rem 0 .5rem; font-size: 1.2rem; }
.row { display: flex; flex-wrap: wrap; gap: 1.5rem; }
figure { margin: 0; width: 16rem; }
.both { display: flex; gap: 4px; }
.both img, .none { width: 128px; height: 128px; object-fit: contain; border: 1px solid var(--line); }
.none { display: grid; place-items: center; box-sizing: border-box; width: 100%; }
figcaption { font-size: .85rem; }
"""


def _key(unit, look):
    with open(unit.path, "rb") as file:
        text = file.read()
    return hashlib.sha256(text + b"\0" + look.options.encode() + b"\0%d" % _SIDE).hexdigest()[:16]


def _draw(driver, look, place, path):
    """Draws one picture to this path; returns why it could not, or ""."""
    command = [driver, *small(look.options, _SIDE), "--quiet", "--out", place]
    with subprocess.Popen(limited(command, SECONDS), stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE) as process:
        said = process.communicate()[1].decode(errors="replace").strip().splitlines()
    figures = os.path.join(place, "figures")
    names = [name for name in os.listdir(figures) if name.endswith(".png")] if os.path.isdir(figures) else []
    if process.returncode or len(names) != 1:
        return said[-1] if said else "it could not be drawn; make draw-... says why"
    os.replace(os.path.join(figures, names[0]), path)
    return ""


class Album:
    """The page's folder, with its pictures by the digest of what made them."""

    def __init__(self, toolchain, impl, out):
        self._toolchain, self._impl, self._out = toolchain, impl, out
        os.makedirs(os.path.join(out, "pictures"), exist_ok=True)

    def pictures(self, feature, unit):
        """Yields (look, file beside the page or None, why not) for each step that has something to see."""
        unsolved = unsolved_steps(unit)
        with contextlib.ExitStack() as stack:
            driver = None
            for look in read_looks(feature):
                name = f"pictures/{feature.stem}-{look.step}-{_key(unit, look)}.png"
                path = os.path.join(self._out, name)
                if look.step in unsolved:
                    yield look, None, "still the starter"
                    continue
                reason = ""
                if not os.path.exists(path):
                    if driver is None:
                        folder = stack.enter_context(private_folder(self._toolchain))
                        drivers = Drivers(self._toolchain, self._impl, folder, feature.stem)
                        driver, reason = drivers.link(feature)
                    print(f"album: {feature.stem}, step {look.step}", flush=True)
                    place = os.path.join(folder, f"step-{look.step}")
                    reason = _draw(driver, look, place, path) if driver else reason
                yield look, None if reason else name, reason

    def _figure(self, feature, look, name, reason):
        wanted = f"pictures/wanted-{feature.stem}-{look.step}.png"
        with open(look.picture, "rb") as source, open(os.path.join(self._out, wanted), "wb") as copy:
            copy.write(source.read())
        shown = (f'<a href="{name}"><img src="{name}" alt="yours"></a>'
                 f'<img src="{wanted}" alt="wanted">' if name
                 else f'<span class="none">{html.escape(reason)}</span>')
        return (f'<figure><div class="both">{shown}</div><figcaption>Step {look.step}: '
                f"{html.escape(look.caption)}</figcaption></figure>")

    def row(self, feature, unit):
        """Returns the assignment's part of the page, and how many pictures are in it."""
        title = html.escape(handout_of(self._toolchain.source, feature).splitlines()[0].lstrip("# "))
        found = list(self.pictures(feature, unit)) if unit.path else []
        figures = "".join(self._figure(feature, *one) for one in found) or (
            f"<p>Not begun: <code>{html.escape(command_of('start', feature, self._impl))}</code></p>")
        drawn = sum(name is not None for _, name, _ in found)
        return f'<h2>{title}</h2><div class="row">{figures}</div>', drawn


def make_album(build_folder, stems, impl):
    toolchain = build.Toolchain(build_folder)
    features = read_features(toolchain.source)
    chosen = choose(features, stems)
    check_impl(features, impl, [feature.stem for feature in chosen], may_be_empty=True)
    out = os.path.join(toolchain.build, "impl", "out", "album")
    album, rows, count = Album(toolchain, impl, out), [], 0
    for feature in chosen:
        row, drawn = album.row(feature, find_unit(feature, impl))
        rows.append(row)
        count += drawn
    page = os.path.join(out, "index.html")
    write_whole(page, f'<!doctype html><html lang="en"><meta charset="utf-8"><title>My pictures</title>'
                '<meta name="viewport" content="width=device-width"><link rel="icon" href="data:,">'
                f"<style>{_STYLE}</style><h1>My pictures</h1><p>Left what your unit draws, right the wanted "
                f"picture.</p>{''.join(rows)}\n")
    print(f"album: {count} pictures: file://{os.path.abspath(page)}")


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--impl", required=True, metavar="DIR", help="the folder with the units")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    arguments = parser.parse_args()
    return run_command("album", lambda: make_album(arguments.build, arguments.stems, arguments.impl),
                       2, "; finished pictures are kept")


if __name__ == "__main__":
    sys.exit(main())
