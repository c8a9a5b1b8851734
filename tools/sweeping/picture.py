"""The name of a frame, and the texts that a driver writes into its picture (Portable Network Graphics
Specification, 11.3)."""

from png import read_chunks


def stem_of(number):
    """Returns how the names of a frame's files begin: they sort."""
    return f"{number:04}"


def texts_of(path):
    """Returns a dictionary of raykit's texts of one line in ASCII, without their common prefix."""
    texts = {}
    for kind, content in read_chunks(path):
        name, _, text = content.partition(b"\0")
        if kind == b"tEXt" and name.startswith(b"raykit:"):
            texts[name.decode("latin-1").removeprefix("raykit:")] = text.decode("latin-1")
    return texts
