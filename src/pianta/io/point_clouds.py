"""Point files, PCD and PLY: the x, y, z of each point, in blocks, so that memory does not grow with the file."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pianta._types import Floats
from pianta.errors import MapError
from pianta.io._files import check_byte_count, check_input_file, one_line_reason, short_repr

CLOUD_SUFFIXES = (".pcd", ".ply")
BLOCK = 2**18  # points
MAX_HEADER_LINES = 1000
MAX_LINE_BYTES = 10_000
MAX_FIELDS = 1000
MAX_PACKED_BYTES = 2**29  # of a binary_compressed PCD, which is unpacked as a whole
_PCD_KINDS = {"F": "f", "I": "i", "U": "u"}
_PCD_ENCODINGS = {"ascii": "ascii", "binary": "<", "binary_compressed": "packed"}
_PLY_KINDS = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "float32": "f4",
    "float64": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
}
_PLY_ENCODINGS = {"ascii": "ascii", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, eq=False)
class PointFile:
    """A file of points whose header was read.

    encoding: "ascii", "<" or ">" for the order of bytes, or "packed" for a binary_compressed PCD. start: of the points,
    in bytes. fields: name, type as of NumPy without the order of bytes, and count of each value of a point.
    """

    path: Path
    encoding: str
    start: int
    count: int
    fields: tuple[tuple[str, str, int], ...]

    def iterate_blocks(self) -> Iterator[Floats]:
        """The x, y, z of points in metres, shape (N, 3), block after block, without points that are not finite.

        Raises MapError, in one line, if the file has fewer points than its header says.
        """
        try:
            with self.path.open("rb") as file:
                file.seek(self.start)
                yield from (block[np.isfinite(block).all(axis=1)] for block in self._read_blocks(file))
        except MapError:
            raise
        except (OSError, ValueError, EOFError) as exception:
            raise MapError(f"map {short_repr(self.path)} is damaged: {one_line_reason(exception)}") from None

    def _read_blocks(self, file: BinaryIO) -> Iterator[Floats]:
        if self.encoding == "ascii":
            yield from self._read_text(file)
            return
        if self.encoding == "packed":
            yield self._unpack(file)
            return
        dtype = np.dtype([(name, self.encoding + dtype_name, (n,)) for name, dtype_name, n in self.fields])
        for first in range(0, self.count, BLOCK):
            expected = min(BLOCK, self.count - first)
            points = np.frombuffer(file.read(expected * dtype.itemsize), dtype, -1) if expected else np.empty(0, dtype)
            if len(points) < expected:
                raise MapError(self._describe_end(first + len(points)))
            yield np.column_stack([points[name][:, 0].astype(float) for name in "xyz"])

    def _read_text(self, file: BinaryIO) -> Iterator[Floats]:
        names = [name for name, _, count in self.fields for _ in range(count)]
        columns = [names.index(name) for name in "xyz"]
        for first in range(0, self.count, BLOCK):
            expected = min(BLOCK, self.count - first)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of loadtxt about no data
                points = np.loadtxt(islice(file, expected), usecols=columns, ndmin=2, comments=None)
            if len(points) < expected:
                raise MapError(self._describe_end(first + len(points)))
            yield points

    def _unpack(self, file: BinaryIO) -> Floats:
        """All points of a binary_compressed PCD, in which each field is a block."""
        sizes = file.read(8)
        packed, unpacked = (int.from_bytes(sizes[at : at + 4], "little") for at in (0, 4))
        check_byte_count(unpacked, MapError, max_bytes=MAX_PACKED_BYTES)
        expected = self.count * sum(np.dtype(dtype_name).itemsize * count for _, dtype_name, count in self.fields)
        if unpacked != expected:
            name = short_repr(self.path)
            raise MapError(f"map {name} has {unpacked} bytes of points and not {expected}, copy it again")
        content = unpack_lzf(file.read(packed), unpacked)
        columns, at = {}, 0
        for name, dtype_name, count in self.fields:
            size = np.dtype(dtype_name).itemsize * count * self.count
            if name in "xyz":
                columns[name] = np.frombuffer(content[at : at + size], "<" + dtype_name).astype(float)
            at += size
        if any(len(column) != self.count for column in columns.values()):
            raise MapError(self._describe_end(0))
        return np.column_stack([columns[name] for name in "xyz"])

    def _describe_end(self, count: int) -> str:
        return f"map {short_repr(self.path)} ends after {count} of {self.count} points, copy it again"


def open_points(path: str | Path) -> PointFile:
    """A PCD or PLY by its header; raises MapError, in one line, for others and for one without x, y and z."""
    file = check_input_file(path, "map", MapError)
    name = f"map {short_repr(file)}"
    parse = parse_pcd_header if file.suffix.lower() == ".pcd" else parse_ply_header
    try:
        with file.open("rb") as stream:
            encoding, count, fields = parse(lambda: stream.readline(MAX_LINE_BYTES).decode("ascii", "replace"))
            points = PointFile(file, encoding, stream.tell(), count, tuple(fields))
    except (MapError, ValueError, KeyError, IndexError) as exception:
        text = f"no {exception}" if isinstance(exception, KeyError) else one_line_reason(exception)
        raise MapError(f"{name} is no PCD or PLY file that pianta reads: {text}") from None
    missing = {"x", "y", "z"} - {field for field, _, count in fields if count == 1}
    if missing:
        raise MapError(f"{name} has no {' and '.join(sorted(missing))} of its points")
    if count < 1:
        raise MapError(f"{name} has no points")
    return points


Header = tuple[str, int, list[tuple[str, str, int]]]


def parse_pcd_header(read_line: Callable[[], str]) -> Header:
    """Encoding, count of points, and fields of a PCD; raises ValueError or KeyError."""
    keys: dict[str, Sequence[str]] = {}
    for _ in range(MAX_HEADER_LINES):
        line = read_line()
        key, *values = line.split("#")[0].split() or [""]
        keys[key.upper()] = values
        if key.upper() == "DATA" or not line:
            break
    names, sizes, kinds = keys["FIELDS"], keys["SIZE"], keys["TYPE"]
    counts = keys.get("COUNT", ["1"] * len(names))
    if not len(names) == len(sizes) == len(kinds) == len(counts):
        raise ValueError("FIELDS, SIZE, TYPE and COUNT are not of one length, give a value for each field")
    fields = [
        (name, f"{_PCD_KINDS[dtype_name.upper()]}{int(size)}", int(count))
        for name, size, dtype_name, count in zip(names, sizes, kinds, counts, strict=True)
    ]
    encoding = _choose_encoding("DATA", " ".join(keys["DATA"]).lower(), _PCD_ENCODINGS)
    points = keys["POINTS"] if "POINTS" in keys else [str(int(keys["WIDTH"][0]) * int(keys["HEIGHT"][0]))]
    # PCL writes "_" for bytes without a meaning, several times
    return encoding, int(points[0]), _check_fields(fields)


def parse_ply_header(read_line: Callable[[], str]) -> Header:
    """Encoding, count of points, and fields of a PLY; raises ValueError or KeyError."""
    if read_line().strip() != "ply":
        raise ValueError("the first line is not ply")
    encoding, count, fields, element = "", 0, [], ""
    for _ in range(MAX_HEADER_LINES):
        words = read_line().split()
        match words:
            case ["format", name, _]:
                encoding = _choose_encoding("format", name, _PLY_ENCODINGS)
            case ["element", "vertex", number]:
                if element:
                    raise ValueError(f"its points come after the element {element}, write them first")
                element, count = "vertex", int(number)
            case ["element", name, _]:
                element = name
            case ["property", "list", *_] if element == "vertex":
                raise ValueError("its points have lists, write points without them")
            case ["property", dtype_name, name] if element == "vertex":
                fields.append((name, _PLY_KINDS[dtype_name], 1))
            case ["end_header"]:
                return encoding, count, _check_fields(fields)
    raise ValueError("its header has no end")


def _choose_encoding(key: str, name: str, encodings: Mapping[str, str]) -> str:
    """The encoding of a name in a header; raises ValueError for another name."""
    if name not in encodings:
        raise ValueError(f"{key} is {short_repr(name)}, give {', '.join(encodings)}")
    return encodings[name]


def _check_fields(fields: list[tuple[str, str, int]]) -> list[tuple[str, str, int]]:
    """The fields, repeated names with their indices; raises ValueError for impossible ones."""
    if len(fields) > MAX_FIELDS:
        raise ValueError(f"it has {len(fields)} fields, the limit is {MAX_FIELDS}")
    for name, _, count in fields:
        if not 1 <= count <= MAX_FIELDS:
            raise ValueError(f"field {short_repr(name)} has {count} values, give 1 to {MAX_FIELDS}")
    for _, dtype_name, _ in fields:
        try:
            np.dtype(dtype_name)
        except TypeError:
            raise ValueError(f"a field is of type {dtype_name}") from None
    names = [name for name, _, _ in fields]
    return [
        (name if names.index(name) == index else f"{name} {index}", dtype_name, count)
        for index, (name, dtype_name, count) in enumerate(fields)
    ]


def unpack_lzf(packed: bytes, size: int) -> bytes:
    """What LZF has packed (Lehmann, LibLZF); raises MapError if it is damaged or not of this size."""
    unpacked, at = bytearray(), 0
    try:
        while at < len(packed) and len(unpacked) <= size:
            control = packed[at]
            at += 1
            if control < 32:  # a run of bytes as they are
                unpacked += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            back = ((control & 31) << 8) + packed[at] + 1
            at, length = at + 1, length + 2
            start = len(unpacked) - back
            if start < 0:
                raise IndexError
            # A reference can reach into what it makes
            repeated = unpacked[start : start + length]
            unpacked += (repeated * (length // len(repeated) + 1))[:length]
    except IndexError:
        raise MapError("its compressed points are damaged") from None
    if len(unpacked) != size:
        raise MapError(f"its points unpack to {len(unpacked)} bytes and not to {size}")
    return bytes(unpacked)
