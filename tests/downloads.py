"""Made-up downloads in the forms that learning platforms give them, right and wicked ones."""

import datetime
import gzip
import io
import os
import struct
import tarfile
import zipfile
import zlib

DAY = (2026, 10, 5, 22, 0, 0)


def zipped(*files, encrypted=False):
    """Returns a zip's bytes of (name, bytes or text[, time])."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content, *time in files:
            info = zipfile.ZipInfo(name, time[0] if time else DAY)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, content)
    data = stream.getvalue()
    if encrypted:  # the flag alone: what no password opens
        data = bytearray(data)
        for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
            at = data.find(mark)
            while at >= 0:
                data[at + place] |= 1
                at = data.find(mark, at + 4)
    return bytes(data)


def with_link(name, target):
    """Returns a zip with a symbolic link."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        info = zipfile.ZipInfo(name, DAY)
        info.create_system, info.external_attr = 3, 0o120777 << 16
        archive.writestr(info, target)
    return stream.getvalue()


def with_zoned_time(name, content, time):
    """Returns a zip as Info-ZIP writes it: with the time in an extra field, which knows zones."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        info = zipfile.ZipInfo(name, DAY)
        info.extra = struct.pack("<HHBi", 0x5455, 5, 1, int(time.timestamp()))
        archive.writestr(info, content)
    return stream.getvalue()


def as_mac(name, content):
    """Returns a zip whose name is UTF-8 that is not said to be so."""
    data = zipped((name, content))
    data = bytearray(data)
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = data.find(mark)
        data[at + place + 1] &= ~8
    return bytes(data)


def tarred(*members, mode="w"):
    """Returns a tar's bytes of (name, bytes) or TarInfos."""
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode=mode, format=tarfile.GNU_FORMAT) as archive:
        for member in members:
            if isinstance(member, tarfile.TarInfo):
                archive.addfile(member)
                continue
            name, content = member
            info = tarfile.TarInfo(name)
            info.size = len(content)
            info.mtime = datetime.datetime(2026, 10, 5, 20, tzinfo=datetime.timezone.utc).timestamp()
            archive.addfile(info, io.BytesIO(content))
    return stream.getvalue()


def special(name, kind, target=""):
    info = tarfile.TarInfo(name)
    info.type, info.linkname = kind, target
    return info


def tar_bomb(name):
    """Returns a tar.gz of 10 GB of zeros."""
    info = tarfile.TarInfo(name)
    info.size = 100 * 100_000_000
    return gzip.compress(info.tobuf(tarfile.GNU_FORMAT)) + gzip.compress(bytes(100_000_000), 9) * 100


def zip_bomb(name):
    """Returns a zip of 10 GB of zeros, deflated in blocks that are all the same."""
    squeeze = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = squeeze.compress(bytes(100_000_000)) + squeeze.flush(zlib.Z_FULL_FLUSH)
    data, end = block * 100, squeeze.flush(zlib.Z_FINISH)
    data += end
    size = 100 * 100_000_000
    wide = struct.pack("<HHQQ", 1, 16, size, len(data))
    head = struct.pack("<HHHHHLLLHH", 45, 0, 8, 0, 0x5b45, 0, 0xffffffff, 0xffffffff, len(name), len(wide))
    entry = b"PK\x03\x04" + head + name.encode() + wide + data
    central = b"PK\x01\x02" + struct.pack("<H", 45) + head + struct.pack("<HHHLL", 0, 0, 0, 0, 0) + (
        name.encode() + wide)
    return entry + central + b"PK\x05\x06" + struct.pack("<HHHHLLH", 0, 0, 1, 1, len(central), len(entry), 0)


def many_files(count):
    """Returns a zip of so many empty files."""
    return zipped(*((f"{number}.txt", "") for number in range(count)))


def put(folder, files, time=None):
    """Writes files, given as a dictionary from their paths to bytes or text, into a folder."""
    for name, content in files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        if time:
            os.utime(path, (time.timestamp(), time.timestamp()))
