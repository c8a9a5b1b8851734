"""What decides about a frame, as a key: the driver, its options, and the files that these name. A frame that
has it already is not rendered again."""

import glob
import hashlib
import os
import re
import subprocess
import tempfile

# A mesh names its materials and pictures, and these their textures.
_ENDING = re.compile(rb"\.(?:mtl|bin|png|jpe?g|tga|bmp|exr|hdr|tiff?|gif|dds|ktx2?|webp|p[pgn]m)\b",
                     re.IGNORECASE)
_LONGEST = 300  # bytes before the ending


def _bytes(path):
    with open(path, "rb") as file:
        return file.read()


def _named_in(path, content):
    """Yields the files that this one names. Before a name may stand a keyword, which names of files may look
    like, so the longest one that exists is it."""
    folder, lines = os.path.dirname(path), set()
    for ending in _ENDING.finditer(content):
        before = content[max(0, ending.start() - _LONGEST):ending.start()]
        lines.add(re.split(rb"[\r\n\"'\0<>]", before)[-1] + ending[0])
    for line in lines:
        words = os.fsdecode(line).replace("%20", " ").lstrip().split(" ")
        for first in range(len(words)):
            named = os.path.join(folder, " ".join(words[first:]).replace("\\", "/"))
            if os.path.isfile(named):
                yield named
                break


def _put_file(state, path, seen):
    if path in seen:
        return
    seen.add(path)
    content = _bytes(path)
    state.update(b"%s\0%d\0" % (os.fsencode(os.path.basename(path)), len(content)) + content)
    for named in sorted(_named_in(path, content)):
        _put_file(state, named, seen)


def _files_of(value):
    """Returns the files that an option's value names: one, those of a folder, or those of a name with %s."""
    if os.path.isfile(value):
        return [value]
    pattern = os.path.join(glob.escape(value), "*") if os.path.isdir(value) else (
        glob.escape(value).replace("%s", "*") if "%s" in value else "")
    return sorted(filter(os.path.isfile, glob.glob(pattern)))


def _digest_of(value):
    state, seen = hashlib.sha256(), set()
    for path in _files_of(value) if value else []:
        _put_file(state, path, seen)
    return state.digest()


def _code_of(driver, objcopy):
    """Returns a driver's bytes without what only debuggers read: the names of folders where it was linked."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(driver)) as folder:
        stripped = os.path.join(folder, "stripped")
        try:
            subprocess.run([objcopy, "--strip-all", "--remove-section=.note.gnu.build-id", driver, stripped],
                           stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
            return _bytes(stripped)
        except (OSError, subprocess.CalledProcessError):
            return _bytes(driver)


class Keys:
    """The keys of frames of one driver; `helpers` are the programs that read files for it."""

    def __init__(self, driver, objcopy, helpers, options):
        self._common, self._digests = hashlib.sha256(_code_of(driver, objcopy)), {}
        for helper in filter(os.path.exists, helpers):
            self._common.update(_bytes(helper))
        self._put(self._common, options)

    def _put(self, state, words):
        for word in words:
            value = word.split("=", 1)[1] if word.startswith("--") and "=" in word else word
            if value not in self._digests:
                self._digests[value] = _digest_of(value)
            state.update(os.fsencode(word) + b"\0" + self._digests[value])

    def of(self, words):
        """Returns the key of the frame with these words."""
        state = self._common.copy()
        self._put(state, words)
        return state.hexdigest()[:16]
