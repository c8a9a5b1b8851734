"""A course's own words for its packs: a title and a note, which stand at the top of HANDOUT.md. What would
break that page is refused."""

import os
import re

from grading.assignments import ToolError
from grading.results import printable

_TITLE_MAX, _NOTE_MAX = 120, 20_000  # characters
_CODE = re.compile(r"`+[^`\n]*`+")
_FENCE = re.compile(r" {0,3}(```+|~~~+)")
_TAG = re.compile(r"</?[a-z][a-z0-9]*(?:\s[^<>]*)?/?>", re.IGNORECASE)
_TARGET = re.compile(r"\]\(<?([^)\s>]+)|^ {0,3}\[[^]]+\]: *<?([^\s>]+)")
_FIRST = "# What is handed out here\n"  # of assignments/handout_page.md


class Words:
    """`title` and `note`, each may be empty. `place` begins the place of a line of the note."""

    def __init__(self, title, note, place="NOTE:"):
        self.title, self.note, self.place = title, note, place

    def named(self):
        """Returns what there is of them, for a sentence."""
        return " and ".join(filter(None, ["title" * bool(self.title), "note" * bool(self.note)]))

    def put_into(self, page):
        """Returns HANDOUT.md with them."""
        if not self.title and not self.note:
            return page
        rest = page.removeprefix(_FIRST)
        head = [f"# {self.title}" if self.title else _FIRST.strip(), self.note,
                f"#{_FIRST}".strip() if self.title else ""]
        return "\n\n".join(filter(None, head)) + "\n" + rest

    def refuse(self, number, text):
        """Raises ToolError for a line of the note."""
        raise ToolError(printable(f"{self.place}{number}: {text}"))

    def lines(self):
        """Yields the number of each line of the note that is no code, and the line without code."""
        fence = ""
        for number, line in enumerate(self.note.split("\n"), 1):
            mark = _FENCE.match(line)
            if mark and not fence:
                fence, begun = mark[1], number
            elif mark and mark[1].startswith(fence):
                fence = ""
            elif not fence:
                yield number, _CODE.sub("", line)
        if fence:
            self.refuse(begun, f"the code that begins here has no end; put {fence} on a line below it")

    def check_links(self, pack, has_book, what="pack"):
        """Raises ToolError if a link leads to no file of the pack, or of the site."""
        for number, line in self.lines():
            for target in (first or second for first, second in _TARGET.findall(line)):
                path = target.partition("#")[0]
                if not path or re.match(r"[a-z][a-z0-9+.-]*:", path, re.IGNORECASE):
                    continue
                place = os.path.normpath(os.path.join(pack, path))
                is_book = has_book and path.startswith("docs/handout/")
                if not place.startswith(os.path.join(pack, "")) or not (is_book or os.path.exists(place)):
                    self.refuse(number, f"{path} is not in the {what}; give its address on the web")


def _read(note):
    """Returns the text of NOTE, a file's name or a text, and how its places begin."""
    is_name = "\n" not in note and (note.lower().endswith((".md", ".txt"))
                                    or os.sep in note and not re.search(r"\s", note))
    if not os.path.exists(note) and not is_name:
        return note, "NOTE:"
    if os.path.isdir(note):
        raise ToolError(f"NOTE: {note} is a folder; name a file, or write the text itself")
    try:
        with open(note, "rb") as file:
            data = file.read(16 * _NOTE_MAX)
    except FileNotFoundError as error:
        raise ToolError(f"NOTE: there is no file {note}; name one, or write the text itself") from error
    except OSError as error:
        raise ToolError(f"NOTE: {note} cannot be read: {error.strerror}") from error
    try:
        return data.decode("utf-8-sig"), f"NOTE: {note}:"
    except UnicodeDecodeError as error:
        line = data[:error.start].count(b"\n") + 1
        raise ToolError(f"NOTE: {note}:{line}: this is not UTF-8; save it as UTF-8") from error


def _check_note(words):
    for number, line in enumerate(words.note.split("\n"), 1):
        if printable(line) != line:
            words.refuse(number, "a character here cannot be seen; remove it")
        if "<!--" in line or "-->" in line:
            words.refuse(number, "<!-- and --> hide text; leave them out")
        if "IMPL=mine" in line:
            words.refuse(number, "IMPL=mine means a folder of the whole kit; leave it out here")
    for number, line in words.lines():
        if re.match(r" {0,3}#(\s|$)", line) or re.fullmatch(r" {0,3}=+\s*", line):
            words.refuse(number, "begin headings with ##; the page's title is TITLE")
        tag = _TAG.search(line)
        if tag:
            words.refuse(number, f"{tag[0]} is HTML, which could hide what follows; write Markdown, and code "
                         "between `...`")


def read_words(title, note):
    """Returns the Words that TITLE and NOTE say. Raises ToolError with what is wrong."""
    title = title.strip()
    if printable(title) != title or re.search(r"[\n\t<>]|-->", title) or len(title) > _TITLE_MAX:
        raise ToolError(f"TITLE: write one line of up to {_TITLE_MAX} characters, without < and >")
    text, place = _read(note) if note.strip() else ("", "NOTE:")
    words = Words(title, text.replace("\r\n", "\n").strip("\n").rstrip(), place)
    if len(words.note) > _NOTE_MAX:
        raise ToolError(f"NOTE: it has {len(words.note)} characters, and {_NOTE_MAX} are a long page; "
                        "shorten it, or link to the rest")
    _check_note(words)
    return words
