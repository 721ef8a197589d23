"""PlanDrawing: the lines, doors and texts of a vector plan, independent of the format of its file."""

from __future__ import annotations

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


@dataclass(frozen=True, eq=False)
class PlanDrawing:
    """A vector plan: x to the right and y up, in drawing units.

    lines: shape (N, 2, 2), ends of straight pieces; curves come as chains of them.
    roles: shape (N,), index into ROLES of each line; "other" if unknown.
    widths: shape (N,), stroke widths in drawing units; 0 for a hair line.
    fills: outlines of dark filled areas (poché of walls), each shape (M, 2).
    doors: shape (D, 2, 2), from jamb to jamb, of doors that the file names (blocks, layers).
    texts: all texts.
    metres_per_unit: None if unknown.
    source: the name of the file.
    """

    lines: Floats
    roles: NDArray[np.intp]
    widths: Floats
    fills: tuple[Floats, ...] = ()
    doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    texts: tuple[DrawnText, ...] = ()
    metres_per_unit: float | None = None
    source: str = ""
