"""PlanLook: the style of a drawn plan; and Canvas, which it is drawn on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from shapely import get_coordinates
from shapely.geometry.base import BaseGeometry

from pianta._types import Colors, Floats
from pianta.errors import OptionError
from pianta.floor.polygons import list_polygons
from pianta.gridmap import GridMap
from pianta.plan.symbols.drawings import SUBPIXEL_BITS, Color, Mark, paint_marks, pixel_matrix
from pianta.worlds.plans.lettering import DEFAULT_FONT
from pianta.worlds.plans.symbols import DOOR_STYLES, DoorStyle

WallStyle = Literal["thick", "double", "single"]
WALL_STYLES: tuple[WallStyle, ...] = get_args(WallStyle)


@dataclass(frozen=True)
class PlanLook:
    """The style of a plan.

    style: of the walls: filled, the two lines of their faces, or one line along their axes.
    px_per_metre: of the sheet. doors: style of doors; "double" gives wide doors two leaves, and other doors one.
    windows: 0, or the number of lines of each window in the outer walls, 2 or 3. furniture: 0 none … 1 full.
    lettering: height of names, metres; font: one of matplotlib's; text_angle: degrees. legend: whether rooms have
    numbers, which a list beside the plan explains. title: above the plan. dimensions, scale_bar: whether to draw them.
    colored: whether rooms are filled in pastels. evacuation: whether passages have signs and arrows.
    noise: 0 none … 1 a bad photo: JPEG, grain, uneven light.
    rotation: of the building on the sheet, degrees, counter-clockwise. ink: grey of the lines, 0 black.

    Raises OptionError, naming all of them, for values out of range.
    """

    style: WallStyle = "thick"
    px_per_metre: float = 30.0
    doors: DoorStyle = "arc"
    windows: int = 0
    furniture: float = 0.0
    lettering: float = 0.4
    font: str = DEFAULT_FONT
    text_angle: float = 0.0
    legend: bool = False
    title: str = ""
    dimensions: bool = False
    scale_bar: bool = False
    colored: bool = False
    evacuation: bool = False
    noise: float = 0.0
    rotation: float = 0.0
    ink: int = 0

    def __post_init__(self) -> None:
        faults = []
        if self.style not in WALL_STYLES:
            faults.append(f"style is {self.style!r}, give one of {', '.join(WALL_STYLES)}")
        if self.doors not in DOOR_STYLES:
            faults.append(f"doors is {self.doors!r}, give one of {', '.join(DOOR_STYLES)}")
        if self.windows not in {0, 2, 3}:
            faults.append(f"windows is {self.windows}, give 0, 2 or 3 lines")
        if not 5 <= self.px_per_metre <= 500:
            faults.append(f"px_per_metre is {self.px_per_metre}, give 5 to 500")
        faults += [
            f"{name} is {share}, give 0 to 1"
            for name, share in (("furniture", self.furniture), ("noise", self.noise))
            if not 0 <= share <= 1
        ]
        if not 0 <= self.ink <= 200:
            faults.append(f"ink is {self.ink}, give a grey of 0 to 200")
        if faults:
            raise OptionError("not a plan: " + "; ".join(faults))

    @property
    def stroke_px(self) -> int:
        """Width of thin lines."""
        return max(round(self.px_per_metre / 40), 1)

    @property
    def color(self) -> tuple[int, int, int]:
        """Red, green and blue of the ink."""
        return (self.ink, self.ink, self.ink)


@dataclass(frozen=True, eq=False)
class Canvas:
    """The paper of a plan.

    colors: shape (H, W, 3), painted in place. grid: the frame of the paper. footprint: the floor with its outer walls,
    metres.
    """

    colors: Colors
    grid: GridMap
    look: PlanLook
    footprint: BaseGeometry

    @property
    def matrix(self) -> Floats:
        """From x, y, metres, to continuous pixels col, row; shape (2, 3)."""
        return pixel_matrix(self.grid)

    @property
    def bounds_px(self) -> tuple[float, float, float, float]:
        """First row and col, and last row and col, of the building."""
        rows, cols = self.grid.map_to_pixel(*get_coordinates(self.footprint).T)
        return float(rows.min()), float(cols.min()), float(rows.max()), float(cols.max())

    def paint(self, marks: list[Mark], *, strokes: int = 1) -> None:
        """Draw marks, metres, in ink; strokes: width of the lines, as a multiple of thin ones."""
        paint_marks(self.colors, marks, self.matrix, stroke_px=strokes * self.look.stroke_px, ink=self.look.color)

    def fill(self, shape: BaseGeometry, color: Color) -> None:
        """Fill polygons, metres, without their holes."""
        matrix = self.matrix
        for part in list_polygons(shape):
            rings = [get_coordinates(ring) for ring in (part.exterior, *part.interiors)]
            pixels = [ring @ matrix[:, :2].T + matrix[:, 2] - 0.5 for ring in rings]
            points = [np.round(ring * 2**SUBPIXEL_BITS).astype(np.int32) for ring in pixels]
            cv2.fillPoly(self.colors, points, color, cv2.LINE_AA, SUBPIXEL_BITS)
