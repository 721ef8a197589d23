"""The whole shapes of rooms that were seen in part: an update predicts few, and keeps those of what is as before.

Section 8.2 of the thesis; what a shape is predicted from is in `pianta.layout.partial`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely
from shapely import Polygon

from pianta._types import Floats
from pianta.floor import Floor, Room, round_floor
from pianta.gridmap import GridMap
from pianta.layout.partial.predict import predict_partial_rooms
from pianta.mapping.changed_parts import have_same_frame
from pianta.mapping.state import MapState

# All chosen by hand.
SHAPE_MARGIN = 0.3  # m around a predicted shape, in which nothing has changed if it stays
# What an update may read and predict, as an area, m². A shape counts as much as this area, and more for each metre of
# its room, up to a limit, as longer rooms are drawn in larger cells.
MAX_COST = 600.0
SHAPE_COST = 80.0
LENGTH_COST = 10.0
MAX_SHAPE_COST = 400.0
MAX_OVERLAP = 0.01  # of a predicted shape with other rooms, up to which it stays while it waits


def predict_shapes(
    floor: Floor,
    grid: GridMap,
    before: MapState | None,
    changed: Floats | None,
    read_area: float | None,
) -> tuple[Floor, tuple[int, ...]]:
    """The floor with predicted shapes of partial rooms, and the ids of those whose shape waits for another update.

    Where nothing has changed, the shapes before stay. changed: x, y of the changed cells, shape (N, 2); None for all.
    read_area: that the update has read, with what its windows see around them, m²; None for an update without a limit.
    """
    old = {room.id: room for room in before.floor} if before and have_same_frame(grid, before.grid) else {}
    waiting = () if before is None else before.waiting
    same = {
        room.id: each
        for room in floor
        if room.id not in waiting and (each := _keep_shape(room, old.get(room.id), changed)) is not None
    }
    pending = [room.id for room in floor if room.partial and room.id not in same]
    pending.sort(key=lambda room_id: waiting.index(room_id) if room_id in waiting else len(waiting))
    left: list[int] = []
    if before is not None and read_area is not None:
        # The reading of a whole map has no limit, and one shape at least is predicted after it
        budget = max(MAX_COST - read_area, MAX_SHAPE_COST if changed is None else 0.0)
        left = list_waiting([floor[room_id] for room_id in pending], budget)
    same |= {room_id: let_wait(floor[room_id], old.get(room_id), floor) for room_id in left}
    # What was predicted before counts as a room
    rooms = [replace(strip_predictions(same[room.id]), partial=False) if room.id in same else room for room in floor]
    shapes = {room_id: room.predicted or room.polygon for room_id, room in same.items()}
    rooms = [replace(room, polygon=shapes.get(room.id, room.polygon)) for room in rooms]
    predicted = predict_partial_rooms(replace(floor, rooms=tuple(rooms)), grid)
    rooms = [same.get(room.id, new) for room, new in zip(floor, predicted, strict=True)]
    return round_floor(replace(floor, rooms=tuple(rooms))), tuple(left)


def list_waiting(rooms: Sequence[Room], budget: float) -> list[int]:
    """The ids of the rooms whose shapes have to wait, in the order of the rooms. budget: for the others, m²."""
    waiting = []
    for room in rooms:
        x0, y0, x1, y1 = room.polygon.bounds
        cost = min(SHAPE_COST + LENGTH_COST * max(x1 - x0, y1 - y0), MAX_SHAPE_COST)
        if cost <= budget:
            budget -= cost
        else:
            waiting.append(room.id)
    return waiting


def _keep_shape(room: Room, before: Room | None, changed: Floats | None) -> Room | None:
    """A partial room with the shape that was predicted before; None if something near it has changed."""
    if not room.partial or before is None or before.predicted is None or changed is None:
        return None
    near = before.predicted.buffer(SHAPE_MARGIN)
    x0, y0, x1, y1 = near.bounds
    x, y = changed.T
    is_near = (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
    if not near.contains(room.polygon) or shapely.contains_xy(near, changed[is_near]).any():
        return None
    return _extend_shape(room, before)


def let_wait(room: Room, before: Room | None, floor: Floor) -> Room:
    """A partial room with the shape before, as long as it overlaps no other room, else without one."""
    extended = None if before is None else _extend_shape(room, before)
    if extended is None or extended.predicted is None:
        return room
    others = [other.polygon for other in floor if other.id != room.id and other.polygon.intersects(extended.predicted)]
    overlap = shapely.area(shapely.intersection(others, extended.predicted)).sum()
    return extended if overlap <= MAX_OVERLAP * extended.predicted.area else room


def _extend_shape(room: Room, before: Room) -> Room | None:
    """The room with the shape that was predicted before, joined with its observed part; None if these are not one."""
    shape = None if before.predicted is None else before.predicted.union(room.polygon)
    return replace(room, predicted=shape, confidence=before.confidence) if isinstance(shape, Polygon) else None


def strip_predictions(room: Room) -> Room:
    """The room without what is predicted of it."""
    return replace(room, label=None, labels={}, label_probabilities={}, predicted=None, confidence=None)
