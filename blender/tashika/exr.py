"""Planes of the OpenEXR files that `tashika` writes.

Blender opens them, too, but shows Python only the colours. They have one part, lines from the top, samples of 32 bits (floating
point, or whole numbers), and ZIP compression; anything else is refused.
"""

import struct
import zlib

import numpy

MAGIC = 20000630
#: Number of the compression, and how many lines are compressed together.
LINES = {0: 1, 2: 1, 3: 16}
TYPES = {0: numpy.dtype("<u4"), 2: numpy.dtype("<f4")}


class Unreadable(Exception):
    """The file is not one that `tashika` writes."""


class File:
    """All channels of a file, by name, as arrays of `height` times `width` samples, lines from the bottom as Blender has them."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        try:
            self._read(data)
        except (struct.error, zlib.error, IndexError, KeyError, ValueError) as error:
            raise Unreadable(f"{path}: {error or type(error).__name__}") from error

    def _read(self, data):
        magic, version = struct.unpack_from("<ii", data)
        if magic != MAGIC or version & 0x1A00:
            raise Unreadable("not an OpenEXR image of one part in lines")
        attributes, at = _attributes(data, 8)
        x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
        self.width, self.height = x1 - x0 + 1, y1 - y0 + 1
        compression = attributes["compression"][0]
        channels = list(_channels(attributes["channels"]))
        lines = LINES[compression]
        chunks = -(-self.height // lines)
        row = self.width * sum(kind.itemsize for _, kind in channels)
        raw = bytearray(row * self.height)
        for offset in struct.unpack_from(f"<{chunks}q", data, at):
            y, size = struct.unpack_from("<ii", data, offset)
            whole = row * min(lines, y1 + 1 - y)
            packed = data[offset + 8 : offset + 8 + size]
            plain = packed if size == whole else _unzip(packed, whole)
            start = (y - y0) * row
            raw[start : start + whole] = plain
        rows = numpy.frombuffer(bytes(raw), dtype=numpy.uint8).reshape(self.height, row)[::-1]
        self._planes, at = {}, 0
        for name, kind in channels:
            end = at + self.width * kind.itemsize
            self._planes[name] = numpy.ascontiguousarray(rows[:, at:end]).view(kind)
            at = end

    def __contains__(self, name):
        return name in self._planes

    def plane(self, *names):
        """Samples of these channels beside each other: `height` times `width` times their number, 32-bit floating point."""
        return numpy.stack([self._planes[name].astype(numpy.float32) for name in names], axis=-1)


def _text(data, at):
    end = data.index(0, at)
    return data[at:end].decode("utf-8"), end + 1


def _attributes(data, at):
    """The header: values by name, and where it ends."""
    found = {}
    while data[at]:
        name, at = _text(data, at)
        _kind, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data):
    """Names and types of the channels, in their order."""
    at = 0
    while data[at]:
        name, at = _text(data, at)
        kind, _linear, x, y = struct.unpack_from("<iB3xii", data, at)
        if (x, y) != (1, 1):
            raise Unreadable(f"the channel {name} has samples for some pixels only")
        yield name, TYPES[kind]
        at += 16


def _unzip(packed, size):
    """ZIP of OpenEXR: differences of bytes, of which first every other one, then the rest are stored."""
    stored = numpy.frombuffer(zlib.decompress(packed), dtype=numpy.uint8)
    if stored.size != size:
        raise Unreadable(f"{stored.size} bytes where there should be {size}")
    differences = stored.astype(numpy.int64)
    differences[1:] -= 128
    values = numpy.cumsum(differences).astype(numpy.uint8)
    half = (size + 1) // 2
    plain = numpy.empty(size, dtype=numpy.uint8)
    plain[0::2], plain[1::2] = values[:half], values[half:]
    return plain.tobytes()
