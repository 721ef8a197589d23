"""Prediction of the whole shape of partial rooms from the rest of the building.

Section 8.2 of the thesis uses the faces between the representative lines of the building that a partial room overlaps.
Here the frontiers of the room are moved to such lines, to the obstacles that stop them, and to the size of other rooms;
of all these hypotheses a model chooses the one with the largest expected overlap with the true room.
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
from pianta.layout._label_images import SNAP_DISTANCE, largest_part, outline_labels
from pianta.layout.partial.hypotheses import FEATURES, Hypothesis, list_hypotheses
from pianta.layout.partial.scene import ObservedCells, View, build_scene
from pianta.models import MODELS

MODEL_FILE = MODELS / "partial_rooms.json"
# The constants were chosen by hand.
# Half the thickness of walls if no two rooms are near each other; metres.
USUAL_HALF_WALL = 0.08
# Rooms further apart than this have no common wall; metres.
MAX_WALL = 0.6
# Spacing of the points of outlines at which walls are measured; metres.
WALL_SAMPLE_SPACING = 0.5
# Rooms nearer than this touch, with no wall between them; metres.
TOUCH_DISTANCE = 0.03
# Half the thickness of walls, at most; metres.
MAX_HALF_WALL = 0.1
# There are walls between rooms if more than this share of the outlines near other rooms does not touch them.
MIN_WALL_SHARE = 0.2
# Tolerance of the simplified outline; cells of the scene.
OUTLINE_TOLERANCE = 0.75
# Smaller holes of a prediction are filled; m².
MIN_HOLE = 1.0
# Share of a prediction that may overlap others before the room is predicted again without their area.
MAX_OVERLAP = 0.01
# Digits of a confidence after the point.
DIGITS = 3


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

    def predict_iou(self, features: Floats) -> Floats:
        """Expected IoU, 0 … 1, shape (N,), of hypotheses with features of shape (N, 26)."""
        standard = ((features - self.means) / self.spreads).clip(-4, 4)
        layer = np.maximum(standard @ self.hidden + self.hidden_bias, 0)
        return np.asarray((layer @ self.output + self.output_bias).clip(0, 1))


def read_partial_model(path: Path = MODEL_FILE) -> PartialModel:
    """The model in a file of training/fit_partial_rooms.py."""
    fitted = json.loads(path.read_text(encoding="utf-8"))
    means, spreads, hidden = (
        np.array([fitted[key][name] for name in FEATURES]) for key in ("means", "spreads", "hidden")
    )
    bias, output = np.array(fitted["hidden_bias"]), np.array(fitted["output"])
    return PartialModel(means, spreads, hidden, bias, output, float(fitted["output_bias"]))


def predict_partial_rooms(floor: Floor, grid: GridMap, *, model: PartialModel | None = None) -> Floor:
    """The floor with a prediction of the whole shape of every partial room, and a confidence (section 8.2).

    A prediction contains the observed part, reaches to the middle of its walls, as faces do, and overlaps neither
    another room nor another prediction. The confidence is the expected IoU with the true room; it was learned on
    simulated maps. Complete rooms stay as they are.
    """
    if not any(room.partial for room in floor.rooms):
        return floor
    model, cells, half_wall = model or read_partial_model(), ObservedCells.from_grid(grid), measure_half_wall(floor)
    shapes = {room.id: _predict_shape(floor, room, cells, model, half_wall) for room in floor.rooms if room.partial}
    rooms = {room.id: room for room in floor.rooms}
    predictions: list[Polygon] = []
    # The most certain prediction comes first
    for room_id in sorted(shapes, key=lambda room_id: (-shapes[room_id][1], room_id)):
        shape, confidence = shapes[room_id]
        occupied = shapely.union_all(predictions, grid_size=SNAP_DISTANCE)
        if shapely.intersection(shape, occupied, grid_size=SNAP_DISTANCE).area > MAX_OVERLAP * shape.area:
            shape, confidence = _predict_shape(floor, rooms[room_id], cells, model, half_wall, predictions=predictions)
        shape = _subtract(shape, occupied, rooms[room_id])
        predictions.append(shape)
        rooms[room_id] = replace(rooms[room_id], predicted=shape, confidence=confidence)
    return replace(floor, rooms=tuple(rooms[room.id] for room in floor.rooms))


def measure_half_wall(floor: Floor) -> float:
    """Half the thickness of the walls between the rooms of a floor, metres: the median over their outlines.

    It is 0 if rooms already reach to the middle of their walls.
    """
    polygons = np.array([room.polygon for room in floor.rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=MAX_WALL)
    gaps = [np.zeros(0)]
    for i, polygon in enumerate(polygons):
        near = polygons[second[(first == i) & (second != i)]]
        if len(near):
            outline = polygon.exterior.segmentize(WALL_SAMPLE_SPACING)
            gaps.append(shapely.distance(shapely.points(shapely.get_coordinates(outline)), MultiPolygon([*near])))
    gap = np.concatenate(gaps)
    near = gap[gap < MAX_WALL]
    if not len(near):
        return USUAL_HALF_WALL
    # Rooms touch at openings too
    walls = near[near > TOUCH_DISTANCE]
    return min(MAX_HALF_WALL, float(np.median(walls)) / 2) if len(walls) > MIN_WALL_SHARE * len(near) else 0.0


def _predict_shape(
    floor: Floor,
    room: Room,
    cells: ObservedCells,
    model: PartialModel,
    half_wall: float,
    *,
    predictions: Sequence[Polygon] = (),
) -> tuple[Polygon, float]:
    """The best hypothesis for a room, to the middle of its walls, map frame; and its expected IoU.

    predictions: for other rooms.
    """
    scene = build_scene(floor, room, cells, predictions=predictions)
    hypotheses = list_hypotheses(scene)
    expected = model.predict_iou(np.array([hypothesis.features for hypothesis in hypotheses]))
    # Of equal ones the first, which adds least
    best = int((expected >= expected.max() - 1e-9).argmax())
    shape = _outline(hypotheses[best], scene.view, room).buffer(half_wall, join_style="mitre", mitre_limit=2)
    rest = [other.polygon for other in floor.rooms if other.id != room.id]
    near = [polygon for polygon in rest if polygon.intersects(shape)]
    free = _subtract(shape, shapely.union_all([*near, *predictions], grid_size=SNAP_DISTANCE), room)
    return free, round(float(expected[best]), DIGITS)


def _outline(hypothesis: Hypothesis, view: View, room: Room) -> Polygon:
    """The cells of a hypothesis as a polygon of the map frame that contains the room."""
    outlines, _ = outline_labels(hypothesis.cells.astype(np.int32))
    corner = np.array([hypothesis.window[1].start, hypothesis.window[0].start], float)
    smooth = shapely.simplify(outlines[0], OUTLINE_TOLERANCE)
    cells = shapely.transform(largest_part(smooth), lambda pixels: view.to_map(pixels + corner))
    part = _subtract(cells, Polygon(), room)
    return Polygon(part.exterior, [hole for hole in part.interiors if Polygon(hole).area >= MIN_HOLE])


def _subtract(shape: Polygon, occupied: shapely.Geometry, room: Room) -> Polygon:
    """The shape and the room, without the occupied area outside the room; only the part that contains the room."""
    # Rounding to a grid avoids slivers between outlines that nearly coincide.
    rest = shapely.get_parts(shapely.difference(shape, occupied, grid_size=SNAP_DISTANCE))
    # Where the shapes only touch, points and lines remain.
    areas = [part for part in rest if isinstance(part, Polygon)]
    inside = room.polygon.representative_point()
    joined = shapely.get_parts(shapely.union_all([*areas, room.polygon], grid_size=SNAP_DISTANCE))
    parts = [part for part in joined if isinstance(part, Polygon) and part.intersects(inside)]
    return max(parts, key=lambda part: part.area, default=room.polygon)
