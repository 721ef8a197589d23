"""Sheet: a plan as pixels, with what its file says beyond them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pianta._types import Colors, Floats, Mask


@dataclass(frozen=True, eq=False)
class PlacedText:
    """A text on a sheet.

    corners: shape (4, 2), row and col in continuous pixels, clockwise on the sheet from the upper left corner of the
    text as it is read. confidence: of the reading, 0 … 1.
    """

    text: str
    corners: Floats
    confidence: float = 1.0

    @property
    def middle(self) -> Floats:
        """Row and col of its middle, shape (2,)."""
        return np.asarray(self.corners.mean(axis=0))

    @property
    def height(self) -> float:
        """Height of its line, pixels."""
        return float(np.hypot(*(self.corners[3] - self.corners[0])))


@dataclass(frozen=True, eq=False)
class Sheet:
    """A plan as pixels, with what its file says beyond them.

    colors: shape (H, W, 3), red, green, blue. walls: shape (H, W), where the file says what is wall; None for pictures.
    doors: shape (D, 2, 2), from jamb to jamb, row and col in continuous pixels, of doors that the file names.
    texts: None where they must be read from the pixels. resolution: metres per pixel, None where the file does not say.
    px_per_unit: pixels of a unit of the file, 1 of a picture. source: the name of the file.
    """

    colors: Colors
    walls: Mask | None = None
    doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    texts: tuple[PlacedText, ...] | None = None
    resolution: float | None = None
    px_per_unit: float = 1.0
    source: str = ""
