"""The name of a frame, and what a driver's picture says of itself: its size, and the texts that are written
into it (Portable Network Graphics Specification, 11.3)."""


def _chunks(path):
    """Yields (kind, content) of a PNG file."""
    with open(path, "rb") as file:
        png = file.read()
    at = 8
    while at + 12 <= len(png):
        length = int.from_bytes(png[at : at + 4], "big")
        yield png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        at += 12 + length


def stem_of(number):
    """Returns how the names of a frame's files begin: they sort."""
    return f"{number:04}"


def size_of(path):
    """Returns (width, height) in pixels."""
    _, head = next(_chunks(path))
    return int.from_bytes(head[:4], "big"), int.from_bytes(head[4:8], "big")


def texts_of(path):
    """Returns a dictionary of raykit's texts of one line in ASCII, without their common prefix."""
    texts = {}
    for kind, content in _chunks(path):
        name, _, text = content.partition(b"\0")
        if kind == b"tEXt" and name.startswith(b"raykit:"):
            texts[name.decode("latin-1").removeprefix("raykit:")] = text.decode("latin-1")
    return texts
