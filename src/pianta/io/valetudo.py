"""Valetudo's map JSON: the map of a robot vacuum, with its floor, its walls, and its segments, which are rooms.

Facts from Valetudo's source (backend/lib/entities/map): pixels are columns and rows of squares, row 0 at the top;
`pixels` lists x, y of each, `compressedPixels` x, y and the length of each run to the right; points of entities are
in centimetres. A point x, y of the map frame, in metres, is Valetudo's point 100 x, -100 y, in centimetres.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.errors import MapError
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._checked import read_checked
from pianta.io._faults import validation_as
from pianta.io._files import MAX_CELLS, check_byte_count, check_cell_count
from pianta.io._names import clean_name

CLASS_NAME = "ValetudoMap"
CM_PER_METRE = 100
# Limits against hostile files; the largest map in the data has 0.3 MB, 15 layers and 110 000 pixels.
MAX_FILE_BYTES = 2**24
MAX_LAYERS = 1000
MAX_PIXEL = 100_000  # column or row
MAX_PIXELS = 5_000_000  # of all layers
MAX_MAP_CELLS = 25_000_000  # between the outermost pixels; two that are far apart would make a map of gigabytes
_PNG = b"\x89PNG\r\n\x1a\n"
# The chunk of compressed text, and its keyword, in the PNGs that Valetudo sends over MQTT.
_TEXT_CHUNK, _KEYWORD = b"zTXt", CLASS_NAME.encode()

LayerType = Literal["floor", "wall", "segment"]
_Coordinate = Annotated[int, Field(ge=0, le=MAX_PIXEL)]


class MetaData(BaseModel):
    """What is read of the data about a layer."""

    model_config = ConfigDict(frozen=True)

    segmentId: Annotated[str | int, Field(union_mode="left_to_right")] = ""  # noqa: N815
    name: str | None = None


class Layer(BaseModel):
    """A layer: the pixels of all floor, of all walls, or of a segment."""

    model_config = ConfigDict(frozen=True, populate_by_name=True)

    type: LayerType
    metaData: MetaData = MetaData()  # noqa: N815
    pixels: list[_Coordinate] = []
    compressedPixels: list[_Coordinate] = []  # noqa: N815

    def list_runs(self) -> NDArray[np.int64]:
        """Column, row and length of each run of pixels, shape (N, 3); raises MapError for an incomplete list."""
        if len(self.pixels) % 2 or len(self.compressedPixels) % 3:
            raise MapError(
                f"layer {self.type} has {len(self.pixels)} numbers in pixels and {len(self.compressedPixels)} in "
                "compressedPixels, give pairs and triples"
            )
        pairs = np.array(self.pixels, np.int64).reshape(-1, 2)
        runs = np.array(self.compressedPixels, np.int64).reshape(-1, 3)
        return np.concatenate([np.insert(pairs, 2, 1, axis=1), runs[runs[:, 2] > 0]])


class ValetudoMap(BaseModel):
    """What is read of a map JSON."""

    model_config = ConfigDict(frozen=True, populate_by_name=True)

    class_name: Literal["ValetudoMap"] = Field(alias="__class")
    pixelSize: Annotated[FiniteFloat, Field(gt=0, le=1000)]  # noqa: N815
    layers: Annotated[list[Layer], Field(max_length=MAX_LAYERS)]


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment: the id and the name that the robot has, and its runs of pixels, shape (N, 3)."""

    id: str
    name: str | None
    runs: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class VacuumMap:
    """The map of a vacuum. corner: column and row of the first pixel of the grid. members: the JSON as it was."""

    grid: GridMap
    corner: tuple[int, int]
    segments: tuple[Segment, ...]
    members: dict[str, Any]


def read_valetudo_map(path: str | Path, *, max_cells: int = MAX_CELLS) -> GridMap:
    """Map from Valetudo's map JSON, or from a PNG with one in it: floor and segments are free, walls are occupied.

    Raises MapError, in one line, for a file that is damaged, has no pixels, or is larger than max_cells.
    """
    return read_vacuum_map(path, max_cells=max_cells).grid


def read_vacuum_map(path: str | Path, *, max_cells: int = MAX_CELLS) -> VacuumMap:
    """Map with the segments of the robot; files and errors as of read_valetudo_map."""

    def parse(content: bytes) -> VacuumMap:
        return parse_vacuum_map(unwrap_png(content) or content, Path(path).name, max_cells=max_cells)

    return read_checked(path, "map", MapError, parse, max_bytes=MAX_FILE_BYTES)


def parse_vacuum_map(content: bytes, source: str, *, max_cells: int = MAX_CELLS) -> VacuumMap:
    """The map of a JSON; raises MapError without the name of the file."""
    from pydantic_core import from_json

    with validation_as(MapError):
        parsed = ValetudoMap.model_validate_json(content.removeprefix(b"\xef\xbb\xbf"))
    layers = [(layer, layer.list_runs()) for layer in parsed.layers]
    runs = np.concatenate([np.zeros((0, 3), np.int64), *(each for _, each in layers)])
    if not len(runs):
        raise MapError("it has no pixels, drive the robot once around")
    if runs[:, 2].sum() > MAX_PIXELS:
        raise MapError(f"its layers have {runs[:, 2].sum()} pixels, the limit is {MAX_PIXELS}")
    left, top = runs[:, 0].min(), runs[:, 1].min()
    height, width = runs[:, 1].max() + 1 - top, (runs[:, 0] + runs[:, 2]).max() - left
    check_cell_count((int(height), int(width)), "the map", max_cells=max_cells)
    if height * width > MAX_MAP_CELLS:
        raise MapError(f"its pixels are on {height} × {width} cells, the limit is {MAX_MAP_CELLS} in all; check them")
    cells = np.full((height, width), UNKNOWN, np.int8)
    # A pixel of a wall is a wall, also where a segment has it
    for layer, each in sorted(layers, key=lambda pair: pair[0].type == "wall"):
        cells[list_pixels(each - (left, top, 0))] = OCCUPIED if layer.type == "wall" else FREE
    side = parsed.pixelSize / CM_PER_METRE
    origin = (float(left * side), float(-(top + height) * side), 0.0)
    segments = (
        Segment(str(layer.metaData.segmentId), clean_name(layer.metaData.name), each)
        for layer, each in layers
        if layer.type == "segment" and len(each)
    )
    members = from_json(content.removeprefix(b"\xef\xbb\xbf"))
    return VacuumMap(GridMap(cells, side, origin, source), (int(left), int(top)), tuple(segments), members)


def list_pixels(runs: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of all pixels of runs."""
    lengths = runs[:, 2]
    steps = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    return np.repeat(runs[:, 1], lengths), np.repeat(runs[:, 0], lengths) + steps


def is_wrapped(path: str | Path) -> bool:
    """Whether a file is a PNG of Valetudo, with the map JSON in it."""
    try:
        with Path(path).open("rb") as file:
            return unwrap_png(file.read(MAX_FILE_BYTES)) is not None
    except MapError:  # damaged, and a map all the same
        return True
    except (OSError, ValueError):
        return False


def unwrap_png(content: bytes) -> bytes | None:
    """The map JSON in a PNG of Valetudo; None for other files. Raises MapError if it is damaged or too large."""
    position = len(_PNG)
    while content.startswith(_PNG) and position + 8 <= len(content):
        size = int.from_bytes(content[position : position + 4], "big")
        chunk_type, data = content[position + 4 : position + 8], content[position + 8 : position + 8 + size]
        keyword, _, text = data.partition(b"\0")
        if chunk_type == _TEXT_CHUNK and keyword == _KEYWORD:
            unpacker = zlib.decompressobj()
            try:
                # The first byte is the method of compression, of which there is one
                unpacked = unpacker.decompress(text[1:], MAX_FILE_BYTES + 1)
            except zlib.error as exception:
                raise MapError(f"the map in it is damaged: {exception}") from None
            check_byte_count(len(unpacked), MapError, max_bytes=MAX_FILE_BYTES)
            return unpacked
        position += size + 12  # with length, kind and checksum
    return None
