"""PNG files as far as tools read them: their chunks (Portable Network Graphics Specification, 5.3)."""

import struct
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunks_of(png):
    """Yields (kind, content) of a file's bytes."""
    at = len(SIGNATURE)
    while at + 12 <= len(png):
        length, kind = struct.unpack(">I4s", png[at : at + 8])
        yield kind, png[at + 8 : at + 8 + length]
        at += 12 + length


def chunk(kind, content):
    """Returns a chunk's bytes."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def read_chunks(path):
    """Returns the chunks of a file, a list of (kind, content)."""
    with open(path, "rb") as file:
        return list(chunks_of(file.read()))


def size_of(path):
    """Returns (width, height) in pixels."""
    return struct.unpack(">II", read_chunks(path)[0][1][:8])


def filtered_rows(path):
    """Returns the rows of a picture as the file has them, filtered, a byte that names the filter before each.
    With size_of, the same for the same picture, whatever texts the file has."""
    return zlib.decompress(b"".join(content for kind, content in read_chunks(path) if kind == b"IDAT"))
