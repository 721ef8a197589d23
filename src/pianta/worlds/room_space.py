"""A room in which furniture is put: in free space, at walls and in rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats
from pianta.worlds.pieces import FurnitureStyle, Outlines, Piece, outline_box, transform_outlines

# The measures were chosen by hand.
# A piece that touches a wall stands this far from it, so that rounding does not put it into the wall; metres.
WALL_GAP = 0.01
# Clear space between pieces; metres.
PIECE_GAP = 0.03
# Attempts to find a free position for a piece.
ATTEMPTS = 6


@dataclass
class RoomSpace:
    """A room in a frame along its longest side, and the pieces that stand in it.

    starts, directions, lengths: of its sides; the room is on the left of each.
    footprints, bounds: space that the pieces take, with a gap, and its x0, y0, x1, y1, one row each.
    pieces: kind and number of outlines of each piece, in the order of the outlines.
    """

    polygon: Polygon
    doors: shapely.Geometry
    turn: float
    rng: np.random.Generator
    furniture: FurnitureStyle
    density: float
    starts: Floats
    directions: Floats
    lengths: Floats
    footprints: list[Polygon] = field(default_factory=list)
    bounds: Floats = field(default_factory=lambda: np.zeros((16, 4)))
    outlines: Outlines = field(default_factory=list)
    pieces: list[tuple[str, int]] = field(default_factory=list)

    @property
    def area(self) -> float:
        """Area of the room; m²."""
        return float(self.polygon.area)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the bounding box in the frame; metres."""
        x0, y0, x1, y1 = self.polygon.bounds
        return x1 - x0, y1 - y0

    def chance(self, share: float) -> bool:
        """Whether something is there that occurs so often at density 1."""
        return bool(self.rng.random() < share * min(self.density, 1.5))

    def count(self, mean: float) -> int:
        """A number of pieces about a mean, at density 1."""
        mean *= self.density
        return int(mean) + int(self.rng.random() < mean - int(mean))

    def put(self, piece: Piece, x: float, y: float, turn: float, *, gap: float = PIECE_GAP) -> bool:
        """Put a piece with the middle of its back at a point, if it has space there; gap: kept from later pieces."""
        x0, y0, x1, y1 = piece.bounds
        around = outline_box(x0 - gap, y0 - gap, x1 + gap, y1 + gap)
        corners, wider = transform_outlines([outline_box(x0, y0, x1, y1), around], x, y, turn)
        low, high = corners.min(axis=0), corners.max(axis=0)
        bounds = self.bounds[: len(self.footprints)]
        near = np.flatnonzero((bounds[:, :2] < high).all(axis=1) & (bounds[:, 2:] > low).all(axis=1))
        footprint, wider_footprint = shapely.polygons([corners, wider])
        if not self.polygon.contains(footprint) or self.doors.intersects(footprint):
            return False
        if shapely.intersects([self.footprints[index] for index in near], footprint).any():
            return False
        if len(self.footprints) == len(self.bounds):
            self.bounds = np.concatenate([self.bounds, np.zeros_like(self.bounds)])
        self.bounds[len(self.footprints)] = *wider.min(axis=0), *wider.max(axis=0)
        self.footprints.append(wider_footprint)
        self.outlines += transform_outlines(piece.outlines, x, y, turn)
        self.pieces.append((piece.kind, len(piece.outlines)))
        return True

    def put_at_wall(self, piece: Piece, gap: float = WALL_GAP, *, attempts: int = ATTEMPTS) -> bool:
        """Put a piece with its back at a random side of the room, or a gap before it; often in a corner."""
        x0, _, x1, _ = piece.bounds
        fitting = np.flatnonzero(self.lengths > x1 - x0 + 2 * WALL_GAP)
        if len(fitting) == 0:
            return False
        weights = self.lengths[fitting] / self.lengths[fitting].sum()
        for _ in range(attempts):
            side = int(self.rng.choice(fitting, p=weights))
            free = self.lengths[side] - (x1 - x0) - 2 * WALL_GAP
            draw = self.rng.random()
            offset = WALL_GAP - x0 + free * (0.0 if draw < 0.25 else 1.0 if draw < 0.5 else self.rng.random())
            dx, dy = self.directions[side]
            x, y = self.starts[side] + offset * self.directions[side] + gap * np.array([-dy, dx])
            if self.put(piece, float(x), float(y), float(np.arctan2(dy, dx))):
                return True
        return False

    def put_free(self, piece: Piece, *, any_angle: float = 0.2, attempts: int = ATTEMPTS) -> bool:
        """Put a piece anywhere; any_angle: how often it does not stand along the room."""
        left, low, right, high = self.polygon.bounds
        for _ in range(attempts):
            turn = np.pi / 2 * int(self.rng.integers(4))
            if self.rng.random() < any_angle:
                turn += self.rng.uniform(0, np.pi / 2)
            x, y = self.rng.uniform(left, right), self.rng.uniform(low, high)
            if self.put(piece, float(x), float(y), float(turn)):
                return True
        return False

    def put_rows(
        self,
        make: Callable[[], Piece],
        *,
        pitch: float,
        aisle: float,
        missing: float = 0.1,
        back_to_back: bool = False,
        margin: float | None = None,
    ) -> int:
        """Put pieces in rows: pitch along a row, and the aisle between rows, metres; return their number.

        missing: share of the positions that stay empty. margin: from the walls; by default half an aisle.
        """
        left, low, right, high = self.polygon.bounds
        along_x = (right - left > high - low) == (self.rng.random() < 0.75)
        length, depth = (right - left, high - low) if along_x else (high - low, right - left)
        sample = make()
        piece_depth = sample.bounds[3]
        margin = aisle / 2 if margin is None else margin
        step = (2 * piece_depth if back_to_back else piece_depth) + aisle
        rows = max(int((depth - 2 * margin + aisle) / step), 1)
        count = int((length - 2 * margin) / pitch)
        flip = bool(self.rng.random() < 0.5)
        number = 0
        for row in range(rows):
            base = margin + row * step + (depth - 2 * margin + aisle - rows * step) / 2
            for column in range(count):
                position = margin + (length - 2 * margin - count * pitch) / 2 + (column + 0.5) * pitch
                middle = base + piece_depth
                backs: tuple[tuple[float, bool], ...] = ((middle, True), (middle + 0.01 + 2 * PIECE_GAP, False))
                if not back_to_back:
                    backs = ((middle, True),) if flip else ((base, False),)
                for back, turned in backs:
                    if self.rng.random() < missing:
                        continue
                    x, y = (left + position, low + back) if along_x else (left + back, low + position)
                    turn = (np.pi if turned else 0.0) if along_x else (np.pi / 2 if turned else -np.pi / 2)
                    number += self.put(make(), x, y, turn)
        return number
