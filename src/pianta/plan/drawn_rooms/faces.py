"""Rooms that the lines of a vector plan enclose, as on plans whose walls are single lines."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import KDTree
from shapely import LineString, Polygon, STRtree

from pianta._types import Floats, Mask
from pianta.io.drawings._drawing import ROLES, DrawnOutline, PlanDrawing
from pianta.plan.drawn_rooms.outlines import DrawnRoom, find_room_outlines

# Limits against hostile files.
MAX_LINES = 20_000
MAX_CROSSINGS = 200_000

MAX_FEW_LINES = 60  # on so simple a plan faces without names are rooms, too
MIN_ROOMS = 3  # with a name, on other plans
MIN_NAMES_INSIDE = 0.6  # of the texts with words stand in rooms: else the lines are no walls
MIN_EXTENSION = 1e-6  # of the extent
# Chosen by hand: lines of walls end at the face of another wall, half a wall away from its line.
EXTENSION = 0.02  # of the shorter side of the plan, by which an end is drawn on to the next line
SLIVER = 0.05  # of the median area: pieces between a leaf and its wall, which belong to a room


def find_enclosed_rooms(drawing: PlanDrawing, *, only_walls: bool = False) -> tuple[DrawnRoom, ...]:
    """The rooms that lines enclose: those of named walls, else of one layer, else of all; empty without.

    only_walls: whether no other lines than those of walls count.
    """
    for lines in _candidate_lines(drawing, only_walls=only_walls):
        faces = _faces_of(lines)
        if not faces:
            continue
        rooms = find_room_outlines(drawing, metres=None, faces=faces)
        if len(rooms) >= 2 and _are_rooms(rooms, drawing):
            return rooms
    is_simple = 0 < len(drawing.lines) <= MAX_FEW_LINES
    if is_simple and not drawing.texts and not drawing.stamps:
        faces = _faces_of(drawing.lines)
        return tuple(DrawnRoom(Polygon(face.ring, face.holes)) for face in faces) if len(faces) >= 2 else ()
    return ()


def _candidate_lines(drawing: PlanDrawing, *, only_walls: bool) -> list[Floats]:
    """Lines of walls, of each layer with the longest lines first, and all but doors; each shape (N, 2, 2)."""
    is_wall = drawing.roles == ROLES.index("wall")
    if only_walls:
        return [drawing.lines[is_wall]]
    is_door = drawing.roles == ROLES.index("door")
    masks: list[Mask] = [is_wall] if is_wall.any() else []
    if len(drawing.line_layers):
        lengths = np.hypot(*(drawing.lines[:, 1] - drawing.lines[:, 0]).T)
        totals = np.bincount(drawing.line_layers, weights=lengths, minlength=len(drawing.layers))
        masks += [(drawing.line_layers == layer) & ~is_door for layer in np.argsort(-totals)[:3]]
    masks.append(~is_door)
    return [drawing.lines[mask] for mask in masks if mask.sum() >= 4]


def _faces_of(lines: Floats) -> list[DrawnOutline]:
    """The areas that lines, shape (N, 2, 2), enclose, without slivers; empty for too many lines or crossings."""
    if len(lines) > MAX_LINES or len(lines) < 4:
        return []
    shapes = shapely.linestrings(lines)
    shapes = shapes[shapely.length(shapes) > 0]
    if not _cross_rarely(shapes):
        return []
    extent = np.ptp(lines.reshape(-1, 2), axis=0).min()
    network = shapely.union_all([*shapes, *_extensions(lines, shapes, EXTENSION * extent)])
    faces = [face for face in shapely.get_parts(shapely.polygonize(shapely.get_parts(network))) if face.area > 0]
    return [
        DrawnOutline(
            np.asarray(shapely.get_coordinates(face.exterior)[:-1]),
            holes=tuple(np.asarray(shapely.get_coordinates(hole)[:-1]) for hole in face.interiors),
        )
        for face in _without_corners_on_edges(_join_slivers(faces))
    ]


def _cross_rarely(shapes: np.ndarray) -> bool:
    """Whether few lines cross each other: the time and memory of their areas grow with the crossings."""
    tree, count = STRtree(shapes), 0
    for start in range(0, len(shapes), 256):
        count += tree.query(shapes[start : start + 256], predicate="intersects").shape[1]
        if count > MAX_CROSSINGS:
            return False
    return True


def _extensions(lines: Floats, shapes: np.ndarray, longest: float) -> list[LineString]:
    """From ends that meet no other line, straight on to the next line that is at most `longest` away."""
    tree, ends = STRtree(shapes), KDTree(lines.reshape(-1, 2))
    tolerance = MIN_EXTENSION * longest / EXTENSION
    added = []
    for start, end in [*lines, *lines[:, ::-1]]:
        length = np.hypot(*(end - start))
        if length <= 0 or len(ends.query_ball_point(end, tolerance)) > 1:
            continue
        ahead = end + (end - start) / length * longest
        ray = LineString([end, ahead])
        hits = shapely.intersection(shapes[tree.query(ray, predicate="intersects")], ray)
        points = shapely.get_coordinates(hits)
        distances = np.hypot(*(points - end).T)
        points, distances = points[distances > tolerance], distances[distances > tolerance]
        if len(points):
            # A little beyond, so that the lines surely cross
            added.append(LineString([end, end + (end - start) / length * (distances.min() + tolerance)]))
    return added


def _join_slivers(faces: list[Polygon]) -> list[Polygon]:
    """Faces with those that are much smaller joined to the neighbour with which they share the longest border."""
    if len(faces) < 2:
        return faces
    areas = np.array([face.area for face in faces])
    least = SLIVER * float(np.median(areas[areas >= SLIVER * areas.max()]))
    large = [face for face in faces if face.area >= least]
    tree, joined = STRtree(large), [[face] for face in large]
    for face in faces:
        if face.area >= least:
            continue
        near = tree.query(face, predicate="intersects")
        beside = np.array(large, object)[near]
        # What a leaf cuts off lies in a room; what it sweeps outside does not
        within = shapely.area(shapely.intersection(shapely.convex_hull(beside), face)) >= face.area / 2
        borders = shapely.length(shapely.intersection(beside, face.exterior)) * within
        if len(near) and borders.max() > 0:
            joined[int(near[borders.argmax()])].append(face)
    unions = [shapely.union_all(parts) if len(parts) > 1 else parts[0] for parts in joined]
    return [union for union in unions if isinstance(union, Polygon)]


def _without_corners_on_edges(faces: list[Polygon]) -> list[Polygon]:
    """Faces without the corners at which a wall of another room begins, or an end was drawn on."""
    simple = [face.simplify(MIN_EXTENSION * float(np.sqrt(face.area))) for face in faces]
    return [face for face in simple if isinstance(face, Polygon) and face.is_valid and face.area > 0]


def _are_rooms(rooms: tuple[DrawnRoom, ...], drawing: PlanDrawing) -> bool:
    """Whether enough rooms have a name, and most texts with words stand in them."""
    named = sum(room.name is not None or room.number is not None for room in rooms)
    least = 2 if len(drawing.lines) <= MAX_FEW_LINES else MIN_ROOMS
    words = [text for text in drawing.texts if sum(map(str.isalpha, text.text)) > 2]
    if named < least or not words:
        return False
    tree = STRtree(shapely.points([[text.x, text.y] for text in words]))
    inside = np.unique(tree.query([room.polygon for room in rooms], predicate="intersects")[1])
    # One name for each room: in a face of several rooms are several
    return len(inside) >= MIN_NAMES_INSIDE * len(words) and named >= MIN_NAMES_INSIDE * len(inside)
