"""Prediction of the whole shape of partial rooms from the rest of the building.

Section 8.2 of the thesis uses the faces between the representative lines of the building that a partial room overlaps.
Here the frontiers of the room are moved to such lines, to the obstacles that stop them, and to the size of other rooms.
A model says how well each of these hypotheses fits, and a network which cells are probable; both together choose.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon, STRtree

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.gridmap import GridMap
from pianta.layout._label_images import SNAP_DISTANCE, largest_part, outline_labels
from pianta.layout.partial.consensus import Shape, choose_shape, mix_cells
from pianta.layout.partial.hypotheses import FEATURES, list_hypotheses
from pianta.layout.partial.scene import (
    FloorIndex,
    ObservedCells,
    View,
    build_scene,
    find_main_direction,
    make_view,
)
from pianta.layout.partial.shape_network import expect_cells
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
# OpenCV draws the cells on the outline of a polygon too, so that drawn rooms, from which shapes are made and learned,
# are larger by this on each side; cells.
DRAWN_EXCESS = 0.5
# The confidence is this line of the expected IoU, which is too high on maps that the network did not learn from:
# fitted, with rounding, to the IoU of 155 rooms of the buildings of VALIDATION in training/partial_maps.py.
CONFIDENCE_OFFSET = -0.04
CONFIDENCE_SLOPE = 0.96
# Other rooms are cut off this far from a prediction; metres.
CLIP_MARGIN = 0.5
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

    A prediction contains the observed part, and overlaps neither another room nor another prediction. It is the
    observed part itself if the model does not expect that a larger shape is better; a larger one reaches to the middle
    of its walls, as faces do. The confidence is the expected IoU with the true room; it was learned on simulated maps.
    Complete rooms stay as they are.
    """
    if not any(room.partial for room in floor.rooms):
        return floor
    predictor = _Predictor.make(floor, grid, model)
    rooms = {room.id: room for room in floor.rooms}
    shapes = {room.id: predictor.predict(room) for room in floor.rooms if room.partial}
    predictions = _Predictions()
    # The most certain prediction comes first
    for room_id in sorted(shapes, key=lambda room_id: (-shapes[room_id][1], room_id)):
        room, (shape, confidence) = rooms[room_id], shapes[room_id]
        occupied = shapely.union_all(predictions.find_near(shape), grid_size=SNAP_DISTANCE)
        if shapely.intersection(shape, occupied, grid_size=SNAP_DISTANCE).area > MAX_OVERLAP * shape.area:
            shape, confidence = predictor.predict(room, predictions)
            occupied = shapely.union_all(predictions.find_near(shape), grid_size=SNAP_DISTANCE)
        shape = subtract_obstacles(shape, occupied, room)
        predictions.add(shape)
        rooms[room_id] = replace(room, predicted=shape, confidence=confidence)
    return replace(floor, rooms=tuple(rooms[room.id] for room in floor.rooms))


class _Predictions:
    """The predictions so far, by position."""

    def __init__(self) -> None:
        self._shapes: list[Polygon] = []
        self._bounds: list[tuple[float, float, float, float]] = []

    def add(self, shape: Polygon) -> None:
        """Add a prediction."""
        self._shapes.append(shape)
        self._bounds.append(shape.bounds)

    def find_near(self, shape: Polygon) -> list[Polygon]:
        """Those whose bounding box meets that of a shape."""
        left, bottom, right, top = shape.bounds
        low_x, low_y, high_x, high_y = np.reshape(self._bounds, (-1, 4)).T
        meets = (low_x <= right) & (high_x >= left) & (low_y <= top) & (high_y >= bottom)
        return [self._shapes[i] for i in np.flatnonzero(meets)]


def measure_half_wall(floor: Floor) -> float:
    """Half the thickness of the walls between the rooms of a floor, metres: the median over their outlines.

    It is 0 if rooms already reach to the middle of their walls.
    """
    polygons = np.array([room.polygon for room in floor.rooms], dtype=object)
    tree = STRtree(polygons)
    gaps = [np.zeros(0)]
    for i, polygon in enumerate(polygons):
        indices = tree.query(polygon, predicate="dwithin", distance=MAX_WALL)
        near = polygons[indices[indices != i]]
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


@dataclass(frozen=True, eq=False)
class _Predictor:
    """What the predictions for all rooms of a floor have in common.

    half_wall: metres. views: around the partial rooms, by their id.
    """

    index: FloorIndex
    cells: ObservedCells
    model: PartialModel
    half_wall: float
    views: Mapping[int, View]

    @classmethod
    def make(cls, floor: Floor, grid: GridMap, model: PartialModel | None) -> _Predictor:
        """What is found once for a floor. model: None for the one that comes with pianta."""
        index = FloorIndex.from_floor(floor)
        views = {room.id: make_view(room, find_main_direction(index, room), grid) for room in floor if room.partial}
        cells = ObservedCells.from_grid(grid, [*views.values()])
        return cls(index, cells, model or read_partial_model(), measure_half_wall(floor), views)

    def predict(self, room: Room, predictions: _Predictions | None = None) -> tuple[Polygon, float]:
        """The probable shape of a room, to the middle of its walls, map frame; and its expected IoU.

        It is the observed part, if the probable cells are nearly the same.
        predictions: for other rooms; None to ignore them.
        """
        view = self.views[room.id]
        others = predictions.find_near(view.window) if predictions else []
        scene = build_scene(self.index, room, self.cells, view, predictions=others)
        # Hypotheses: the frontiers moved to walls in line, obstacles, and extents of other rooms (section 8.2)
        hypotheses = list_hypotheses(scene)
        by_features = self.model.predict_iou(np.array([hypothesis.features for hypothesis in hypotheses]))
        # What the network expects of each cell, and what the hypotheses do, weighted by their expected IoU
        probability = mix_cells(scene, expect_cells(scene), hypotheses, by_features)
        # The probable cells, or a straight shape that is nearly the same
        shape = choose_shape(scene, hypotheses, probability)
        confidence = round(max(0.0, CONFIDENCE_OFFSET + CONFIDENCE_SLOPE * shape.expected_iou), DIGITS)
        if np.array_equal(shape.cells, hypotheses[0].cells):
            return room.polygon, confidence
        return self._finish(shape, view, room, predictions), confidence

    def _finish(self, cells: Shape, view: View, room: Room, predictions: _Predictions | None) -> Polygon:
        """The outline of cells to the middle of its walls, without other rooms and their predictions."""
        reach = (0.0 if cells.reaches_walls else self.half_wall) - DRAWN_EXCESS * view.cell
        shape = _outline(cells, view, room).buffer(reach, join_style="mitre", mitre_limit=2)
        near = [self.index.rooms[i] for i in np.sort(self.index.tree.query(shape, predicate="intersects"))]
        obstacles = [other.polygon for other in near if other.id != room.id]
        obstacles += predictions.find_near(shape) if predictions else []
        return subtract_obstacles(shape, clip_obstacles(obstacles, shape), room)


def _outline(shape: Shape, view: View, room: Room) -> Polygon:
    """Cells as a polygon of the map frame that contains the room."""
    outlines, _ = outline_labels(shape.cells.astype(np.int32))
    corner = np.array([shape.window[1].start, shape.window[0].start], float)
    smooth = shapely.simplify(outlines[0], OUTLINE_TOLERANCE)
    cells = shapely.transform(largest_part(smooth), lambda pixels: view.to_map(pixels + corner))
    part = subtract_obstacles(cells, Polygon(), room)
    return Polygon(part.exterior, [hole for hole in part.interiors if Polygon(hole).area >= MIN_HOLE])


def clip_obstacles(obstacles: Sequence[Polygon], shape: Polygon) -> shapely.Geometry:
    """The union of obstacles near a shape: rounding to a grid takes long for all of a long corridor."""
    near = shapely.intersection(obstacles, shapely.box(*shape.buffer(CLIP_MARGIN).bounds))
    # Where sides touch the box, lines remain
    return shapely.union_all(list_polygons(near), grid_size=SNAP_DISTANCE)


def subtract_obstacles(shape: Polygon, occupied: shapely.Geometry, room: Room) -> Polygon:
    """The shape and the room, without the occupied area outside the room; only the part that contains the room."""
    # Rounding to a grid avoids slivers between outlines that nearly coincide.
    areas = list_polygons(shapely.difference(shape, occupied, grid_size=SNAP_DISTANCE))
    inside = room.polygon.representative_point()
    joined = shapely.union_all([*areas, room.polygon], grid_size=SNAP_DISTANCE)
    parts = [part for part in list_polygons(joined) if part.intersects(inside)]
    return max(parts, key=lambda part: part.area, default=room.polygon)
