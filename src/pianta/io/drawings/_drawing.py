"""PlanDrawing: the lines, doors and texts of a vector plan, independent of the format of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats

Role = Literal["wall", "door", "window", "other"]
ROLES: tuple[Role, ...] = ("wall", "door", "window", "other")


@dataclass(frozen=True)
class DrawnText:
    """A text of a vector plan.

    x, y: its middle, in drawing units. height: of its capitals, in drawing units. angle: of its base line, radians,
    counter-clockwise from x.
    """

    text: str
    x: float
    y: float
    height: float
    angle: float = 0.0


@dataclass(frozen=True)
class DrawnStamp:
    """What the attributes of a block say about the room in which it stands.

    x, y: where it stands, in drawing units. number, name: "" if it has none. area: as it is written, "" if it has none.
    """

    x: float
    y: float
    number: str = ""
    name: str = ""
    area: str = ""


@dataclass(frozen=True, eq=False)
class DrawnOutline:
    """A closed outline of a vector plan.

    ring: its corners, shape (N, 2), in drawing units. holes: in it, each shape (M, 2). layer: on which it is drawn.
    """

    ring: Floats
    layer: str = ""
    holes: tuple[Floats, ...] = ()


@dataclass(frozen=True)
class LayerChoice:
    """The names of layers that a user gives; capitals do not count, and * stands for any letters.

    walls, doors, rooms: what is drawn on these layers and nowhere else; empty to find it.
    """

    walls: tuple[str, ...] = ()
    doors: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        """Whether any layers are given."""
        return bool(self.walls or self.doors or self.rooms)


@dataclass(frozen=True, eq=False)
class PlanDrawing:
    """A vector plan: x to the right and y up, in drawing units.

    lines: shape (N, 2, 2), ends of straight pieces; curves come as chains of them.
    roles: shape (N,), index into ROLES of each line; "other" if unknown.
    widths: shape (N,), stroke widths in drawing units; 0 for a hair line.
    fills: outlines of dark filled areas (poché of walls), each shape (M, 2).
    doors: shape (D, 2, 2), from jamb to jamb, of doors that the file names (blocks, layers).
    texts: all texts.
    outlines: closed outlines, where the format marks them. stamps: attributes of blocks about rooms.
    unnamed_doors: shape (D, 2, 2), from jamb to jamb, of leaves with their arcs on layers that are not named as doors.
    line_layers: shape (N,), index into layers of each line; empty if the format has no layers.
    skipped: counts of what is in the file and was not read, by kind.
    metres_per_unit: None if unknown. is_on_paper: whether the coordinates are those of a sheet of paper, at any scale.
    source: the name of the file.
    """

    lines: Floats
    roles: NDArray[np.intp]
    widths: Floats
    fills: tuple[Floats, ...] = ()
    doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    texts: tuple[DrawnText, ...] = ()
    outlines: tuple[DrawnOutline, ...] = ()
    stamps: tuple[DrawnStamp, ...] = ()
    unnamed_doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    line_layers: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp))
    layers: tuple[str, ...] = ()
    skipped: Mapping[str, int] = field(default_factory=dict)
    metres_per_unit: float | None = None
    is_on_paper: bool = False
    source: str = ""
