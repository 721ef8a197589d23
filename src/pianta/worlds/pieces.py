"""Pieces of furniture as a lidar at the height of a robot detects them: outlines of legs, panels and bodies.

The frame of a piece: x along its back, 0 in the middle; y from its back to its front; metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pianta._types import Floats

Outlines = list[Floats]

# Corners of the outline of a round part.
ROUND_CORNERS = 10
_TURNS = np.linspace(0, 2 * np.pi, ROUND_CORNERS, endpoint=False)
_CIRCLE = np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])


@dataclass(frozen=True)
class Piece:
    """A piece of furniture, or a group of pieces that stand together.

    bounds: x0, y0, x1, y1 of the space that it needs, at least that of the outlines.
    outlines: what the lidar detects, each of shape (n, 2).
    kind: what it is, such as "desk", with the chairs that belong to it; empty for boxes, bins, plants and others.
    """

    bounds: tuple[float, float, float, float]
    outlines: Outlines
    kind: str = ""

    def __post_init__(self) -> None:
        corners = np.vstack([np.reshape(self.bounds, (2, 2)), *self.outlines])
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        object.__setattr__(self, "bounds", (float(x0), float(y0), float(x1), float(y1)))


@dataclass(frozen=True)
class FurnitureStyle:
    """The furniture of one building: how its chairs, tables, beds and shelves stand on the ground.

    chair: "legs", "star" or "seat"; table: "legs", "panels" or "solid"; bed, shelf: "legs" or "solid".
    leg: side of a leg, metres.
    """

    chair: str
    table: str
    bed: str
    shelf: str
    leg: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> FurnitureStyle:
        """Random furniture; the shares were chosen by hand."""
        return cls(
            chair=str(rng.choice(["legs", "star", "seat"], p=(0.5, 0.3, 0.2))),
            table=str(rng.choice(["legs", "panels", "solid"], p=(0.55, 0.25, 0.2))),
            bed=str(rng.choice(["legs", "solid"], p=(0.35, 0.65))),
            shelf=str(rng.choice(["legs", "solid"], p=(0.1, 0.9))),
            leg=float(rng.uniform(0.03, 0.07)),
        )

    def place_chair(self, x: float, y: float, rng: np.random.Generator) -> Outlines:
        """A chair about a point, at a random angle."""
        if self.chair == "seat":
            return [outline_disc(x, y, 0.21)]
        if self.chair == "star":
            turns = rng.uniform(0, 2 * np.pi) + 2 * np.pi / 5 * np.arange(5)
            feet = [outline_disc(x + 0.26 * np.cos(turn), y + 0.26 * np.sin(turn), self.leg / 2) for turn in turns]
            return [outline_disc(x, y, 0.04), *feet]
        turn = rng.uniform(-0.3, 0.3)
        corners = 0.2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) @ _rotation(turn) + (x, y)
        return [outline_square(float(u), float(v), self.leg) for u, v in corners]

    def place_table(self, x0: float, y0: float, x1: float, y1: float) -> Outlines:
        """A table or desk with corners at two points."""
        if self.table == "solid":
            return [outline_box(x0, y0, x1, y1)]
        if self.table == "panels":
            return [outline_box(x0, y0, x0 + 0.04, y1), outline_box(x1 - 0.04, y0, x1, y1)]
        half = self.leg / 2
        corners = ((x0 + half, y0 + half), (x1 - half, y0 + half), (x1 - half, y1 - half), (x0 + half, y1 - half))
        return [outline_square(x, y, self.leg) for x, y in corners]

    def place_body(self, part: str, x0: float, y0: float, x1: float, y1: float) -> Outlines:
        """A body from one point to another, or its legs."""
        if part == "solid":
            return [outline_box(x0, y0, x1, y1)]
        return FurnitureStyle(self.chair, "legs", self.bed, self.shelf, self.leg).place_table(x0, y0, x1, y1)


def outline_box(x0: float, y0: float, x1: float, y1: float) -> Floats:
    """Corners of a rectangle, counter-clockwise."""
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def outline_square(x: float, y: float, side: float) -> Floats:
    """Corners of a square about a point."""
    return outline_box(x - side / 2, y - side / 2, x + side / 2, y + side / 2)


def outline_disc(x: float, y: float, radius: float) -> Floats:
    """Corners of a disc about a point."""
    return _CIRCLE * radius + (x, y)


def transform_outlines(outlines: Sequence[Floats], x: float, y: float, turn: float) -> Outlines:
    """The outlines turned about 0, radians counter-clockwise, and moved to a point."""
    if not outlines:
        return []
    corners = np.concatenate(outlines) @ _rotation(turn) + (x, y)
    return np.split(corners, np.cumsum([len(outline) for outline in outlines])[:-1])


def make_block(width: float, depth: float, name: str = "") -> Piece:
    """A solid piece: a cabinet, box, counter or pallet."""
    return Piece((-width / 2, 0, width / 2, depth), [outline_box(-width / 2, 0, width / 2, depth)], name)


def make_round(radius: float) -> Piece:
    """A round piece: a plant, a column of a display, a bin or a pouffe."""
    return Piece((-radius, 0, radius, 2 * radius), [outline_disc(0, radius, radius)])


def make_shelf(furniture: FurnitureStyle, width: float, depth: float) -> Piece:
    """A shelf or cabinet."""
    outlines = furniture.place_body(furniture.shelf, -width / 2, 0, width / 2, depth)
    return Piece((-width / 2, 0, width / 2, depth), outlines, "shelf")


def make_person(rng: np.random.Generator) -> Piece:
    """A person: two legs, or a blob from one who moved."""
    if rng.random() < 0.4:
        return replace(make_round(float(rng.uniform(0.15, 0.25))), kind="person")
    gap, radius = rng.uniform(0.1, 0.18), rng.uniform(0.055, 0.08)
    half = gap + radius
    step = rng.uniform(0, 0.15)
    return Piece(
        (-half, 0, half, 2 * radius + step),
        [outline_disc(-gap, radius, radius), outline_disc(gap, radius + step, radius)],
        "person",
    )


def make_bed(furniture: FurnitureStyle, rng: np.random.Generator, *, width: float) -> Piece:
    """A bed with its head at the back, and perhaps tables beside it."""
    length, half = 2.0 + 0.1 * rng.random(), width / 2
    outlines = furniture.place_body(furniture.bed, -half, 0.02, half, length)
    left, right = (0.45 if rng.random() < 0.5 else 0.0 for _ in range(2))
    if left:
        outlines.append(outline_box(-half - left, 0.02, -half - 0.05, 0.42))
    if right:
        outlines.append(outline_box(half + 0.05, 0.02, half + right, 0.42))
    return Piece((-half - left, 0, half + right, length), outlines, "bed")


def make_desk(furniture: FurnitureStyle, rng: np.random.Generator, *, with_screen: bool = False) -> Piece:
    """A desk with a chair in front, perhaps with drawers below, or a screen behind."""
    half, depth = rng.uniform(0.6, 0.9), rng.uniform(0.65, 0.85)
    outlines = furniture.place_table(-half, 0.03, half, depth)
    if rng.random() < 0.5:
        side = 1 if rng.random() < 0.5 else -1
        outlines.append(outline_box(side * (half - 0.25) - 0.2, 0.1, side * (half - 0.25) + 0.2, depth - 0.1))
    if with_screen:
        outlines.append(outline_box(-half, 0, half, 0.05))
    if rng.random() < 0.9:
        outlines += furniture.place_chair(rng.uniform(-0.3, 0.3), depth + rng.uniform(0.1, 0.35), rng)
    return Piece((-half, 0, half, depth + 0.65), outlines, "desk")


def make_cubicle(furniture: FurnitureStyle, rng: np.random.Generator) -> Piece:
    """A desk between low partitions on two or three sides."""
    half, depth, thick = rng.uniform(0.9, 1.2), rng.uniform(1.6, 2.1), 0.06
    desk = make_desk(furniture, rng)
    scale = min(1.0, (half - 0.1) / -desk.bounds[0])
    outlines = [outline * (scale, 1) + (0, thick) for outline in desk.outlines]
    outlines.append(outline_box(-half, 0, half, thick))
    outlines.append(outline_box(-half, 0, -half + thick, depth))
    if rng.random() < 0.7:
        outlines.append(outline_box(half - thick, 0, half, depth * rng.uniform(0.5, 1)))
    return Piece((-half, 0, half, depth), outlines, "desk")


def make_table_group(furniture: FurnitureStyle, rng: np.random.Generator, *, width: float, depth: float) -> Piece:
    """A table with chairs on its two long sides, and perhaps at its ends."""
    half, edge = width / 2, 0.55
    outlines = furniture.place_table(-half, edge, half, edge + depth)
    count = max(int(width / 0.7), 1)
    for x in (np.arange(count) + 0.5) * width / count - half:
        for y in (edge - 0.12, edge + depth + 0.12):
            if rng.random() < 0.85:
                shift = rng.uniform(-0.15, 0.15)
                outlines += furniture.place_chair(float(x) + rng.uniform(-0.1, 0.1), y + shift, rng)
    ends = 0.0
    if width > 1.3 and rng.random() < 0.5:
        ends = 0.5
        outlines += furniture.place_chair(-half - 0.2, edge + depth / 2, rng)
        outlines += furniture.place_chair(half + 0.2, edge + depth / 2, rng)
    return Piece((-half - ends, 0, half + ends, depth + 2 * edge), outlines, "table")


def make_round_table(furniture: FurnitureStyle, rng: np.random.Generator) -> Piece:
    """A round table on one foot, with chairs around it."""
    radius, seats = rng.uniform(0.35, 0.6), int(rng.integers(2, 5))
    reach = radius + 0.5
    outlines = [outline_disc(0, reach, 0.08 if rng.random() < 0.6 else 0.25)]
    start = rng.uniform(0, 2 * np.pi)
    for turn in start + 2 * np.pi / seats * np.arange(seats):
        distance = radius + rng.uniform(0.05, 0.2)
        outlines += furniture.place_chair(distance * np.cos(turn), reach + distance * np.sin(turn), rng)
    return Piece((-reach, 0, reach, 2 * reach), outlines, "table")


def make_sofa(furniture: FurnitureStyle, rng: np.random.Generator) -> Piece:
    """A sofa, perhaps with a leg to the front, and perhaps a low table before it."""
    half, depth = rng.uniform(0.75, 1.25), rng.uniform(0.8, 1.0)
    outlines = furniture.place_body(furniture.bed, -half, 0.02, half, depth)
    front = depth
    if half > 1.0 and rng.random() < 0.35:
        front = depth + 0.7
        outlines.append(outline_box(half - 0.8, depth, half, front))
    elif rng.random() < 0.6:
        front = depth + 1.0
        outlines += furniture.place_table(-0.5, depth + 0.35, 0.5, front - 0.1)
    return Piece((-half, 0, half, front), outlines, "sofa")


def make_bath_fitting(rng: np.random.Generator, name: str) -> Piece:
    """A tub, shower, basin, washing machine or toilet."""
    if name == "toilet":
        return Piece((-0.25, 0, 0.25, 0.65), [outline_box(-0.2, 0, 0.2, 0.2), outline_disc(0, 0.4, 0.19)], name)
    sizes = {"tub": (1.65, 0.75), "shower": (0.85, 0.85), "basin": (0.6, 0.45), "machine": (0.6, 0.6)}
    width, depth = sizes[name]
    # Plans call these kinds so, too
    standard_name = {"tub": "bath", "basin": "sink", "machine": "washing machine"}.get(name, name)
    return make_block(width * rng.uniform(0.95, 1.1), depth * rng.uniform(0.95, 1.05), standard_name)


def make_rack(rng: np.random.Generator, *, length: float, depth: float, solid: bool) -> Piece:
    """A rack of a store: a solid body, or posts with pallets between them."""
    half = length / 2
    if solid:
        return make_block(length, depth, "rack")
    bays = max(round(length / 2.7), 1)
    posts = np.linspace(-half, half - 0.1, bays + 1)
    outlines = [outline_box(x, y, x + 0.1, y + 0.1) for x in posts for y in (0.0, depth - 0.1)]
    for x, x_next in pairwise(posts):
        starts = np.arange(x + 0.15, x_next - 0.85, 0.9)
        outlines += [outline_box(start, 0.05, start + 0.8, depth - 0.05) for start in starts if rng.random() < 0.7]
    return Piece((-half, 0, half, depth), outlines, "rack")


def _rotation(turn: float) -> Floats:
    """Matrix by which rows of x and y are multiplied to turn them counter-clockwise."""
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array([(cos, sin), (-sin, cos)])
