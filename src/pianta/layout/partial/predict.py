"""Partial rooms as a whole: what a room that was seen in part looks like, given the rest of the building.

Section 8.2 of the thesis takes the faces between the representative lines of the building that a partial room reaches
into. Here its frontiers are moved on to such lines, to what stops them, and until the room is like others, and of all
these hypotheses the one is chosen that a model expects to overlap most with the true room.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon, STRtree

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._outlines import GRID, largest_part, outline_labels
from pianta.layout.partial.hypotheses import FEATURES, Hypothesis, list_hypotheses
from pianta.layout.partial.scene import Sight, View, look_around
from pianta.models import MODELS

MODEL_FILE = MODELS / "partial_rooms.json"
# Half a wall where no two rooms tell, the thickest wall between rooms, and how far apart walls are measured, m.
USUAL_HALF_WALL, THICKEST, SPACING = 0.08, 0.6, 0.5
# Rooms nearer than this touch, and no wall counts for more than this half, m; there are walls where at least this share
# of the outlines does not touch.
TOUCHING, THICK, FEW = 0.03, 0.1, 0.2
# Corners nearer than this share of a cell to a straight line are none; smaller holes are no courtyards, m².
SMOOTHING, LEAST_HOLE = 0.75, 1.0
# Share of a shape that another may have claimed before it is thought over, and digits of a confidence.
DISPUTED, DIGITS = 0.01, 3


@dataclass(frozen=True)
class PartialModel:
    """Expected IoU of a hypothesis with the true room: a perceptron with one hidden layer.

    means, spreads: of the features, shape (26,). hidden: shape (26, H). hidden_bias: shape (H,). output: shape (H,).
    """

    means: Floats
    spreads: Floats
    hidden: Floats
    hidden_bias: Floats
    output: Floats
    output_bias: float

    def expect_iou(self, features: Floats) -> Floats:
        """Expected IoU, 0 … 1, shape (N,), of hypotheses with features of shape (N, 26)."""
        standard = ((features - self.means) / self.spreads).clip(-4, 4)
        layer = np.maximum(standard @ self.hidden + self.hidden_bias, 0)
        return np.asarray((layer @ self.output + self.output_bias).clip(0, 1))


def read_partial_model(path: Path = MODEL_FILE) -> PartialModel:
    """The model that training/fit_partial_rooms.py has written."""
    fitted = json.loads(path.read_text(encoding="utf-8"))
    means, spreads, hidden = (
        np.array([fitted[key][name] for name in FEATURES]) for key in ("means", "spreads", "hidden")
    )
    bias, output = np.array(fitted["hidden_bias"]), np.array(fitted["output"])
    return PartialModel(means, spreads, hidden, bias, output, float(fitted["output_bias"]))


def predict_partial_rooms(floor: Floor, grid: GridMap, *, model: PartialModel | None = None) -> Floor:
    """The floor with the predicted whole of every partial room, in the map frame, and a confidence (section 8.2).

    A prediction contains what was seen, reaches to the middle of its walls, as faces do, and overlaps neither another
    room nor another prediction. The confidence is the IoU with the true room that is expected; it was learned on
    simulated maps. Other rooms stay as they are.
    """
    if not any(room.partial for room in floor.rooms):
        return floor
    model, sight, half_wall = model or read_partial_model(), Sight.of(grid), measure_half_wall(floor)
    guesses = {room.id: _guess(floor, room, sight, model, half_wall) for room in floor.rooms if room.partial}
    rooms = {room.id: room for room in floor.rooms}
    claimed: list[Polygon] = []
    # What is most certain comes first
    for room_id in sorted(guesses, key=lambda room_id: (-guesses[room_id][1], room_id)):
        shape, confidence = guesses[room_id]
        taken = shapely.union_all(claimed, grid_size=GRID)
        if shapely.intersection(shape, taken, grid_size=GRID).area > DISPUTED * shape.area:
            shape, confidence = _guess(floor, rooms[room_id], sight, model, half_wall, claimed=claimed)
        shape = _subtract(shape, taken, rooms[room_id])
        claimed.append(shape)
        rooms[room_id] = replace(rooms[room_id], predicted=shape, confidence=confidence)
    return replace(floor, rooms=tuple(rooms[room.id] for room in floor.rooms))


def measure_half_wall(floor: Floor) -> float:
    """Half the thickness of the walls between the rooms of a floor, metres: the median over their outlines.

    It is 0 where rooms reach to the middle of their walls anyway.
    """
    polygons = np.array([room.polygon for room in floor.rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=THICKEST)
    gaps = [np.zeros(0)]
    for i, polygon in enumerate(polygons):
        near = polygons[second[(first == i) & (second != i)]]
        if len(near):
            outline = polygon.exterior.segmentize(SPACING)
            gaps.append(shapely.distance(shapely.points(shapely.get_coordinates(outline)), MultiPolygon([*near])))
    gap = np.concatenate(gaps)
    near = gap[gap < THICKEST]
    if not len(near):
        return USUAL_HALF_WALL
    # Rooms touch at openings too
    walls = near[near > TOUCHING]
    return min(THICK, float(np.median(walls)) / 2) if len(walls) > FEW * len(near) else 0.0


def _guess(
    floor: Floor, room: Room, sight: Sight, model: PartialModel, half_wall: float, *, claimed: Sequence[Polygon] = ()
) -> tuple[Polygon, float]:
    """The best hypothesis for a room, to the middle of its walls, map frame; and its expected IoU."""
    scene = look_around(floor, room, sight, claimed=claimed)
    hypotheses = list_hypotheses(scene)
    expected = model.expect_iou(np.array([hypothesis.features for hypothesis in hypotheses]))
    # Of equals the first, which adds least
    best = int((expected >= expected.max() - 1e-9).argmax())
    shape = _outline(hypotheses[best], scene.view, room).buffer(half_wall, join_style="mitre", mitre_limit=2)
    rest = [other.polygon for other in floor.rooms if other.id != room.id]
    near = [polygon for polygon in rest if polygon.intersects(shape)]
    free = _subtract(shape, shapely.union_all([*near, *claimed], grid_size=GRID), room)
    return free, round(float(expected[best]), DIGITS)


def _outline(hypothesis: Hypothesis, view: View, room: Room) -> Polygon:
    """The cells of a hypothesis as a polygon of the map frame that contains the room."""
    outlines, _ = outline_labels(hypothesis.cells.astype(np.int32))
    corner = np.array([hypothesis.window[1].start, hypothesis.window[0].start], float)
    smooth = shapely.simplify(outlines[0], SMOOTHING)
    cells = shapely.transform(largest_part(smooth), lambda places: view.to_map(places + corner))
    part = _subtract(cells, Polygon(), room)
    return Polygon(part.exterior, [hole for hole in part.interiors if Polygon(hole).area >= LEAST_HOLE])


def _subtract(shape: Polygon, taken: shapely.Geometry, room: Room) -> Polygon:
    """The part around the room of a shape without what is taken, with all that was seen."""
    # Rounded to a grid, outlines that nearly lie on each other are no trouble
    rest = shapely.get_parts(shapely.difference(shape, taken, grid_size=GRID))
    # What only touches leaves points and lines behind
    areas = [part for part in rest if isinstance(part, Polygon)]
    inside = room.polygon.representative_point()
    whole = shapely.get_parts(shapely.union_all([*areas, room.polygon], grid_size=GRID))
    parts = [part for part in whole if isinstance(part, Polygon) and part.intersects(inside)]
    return max(parts, key=lambda part: part.area, default=room.polygon)
