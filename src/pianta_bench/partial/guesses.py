"""Guesses of the whole shape of a room that was seen in part, all with the same reach: to the middle of its walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon, STRtree
from shapely.affinity import rotate

from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import SNAP_DISTANCE, largest_part
from pianta.layout._working_grid import to_working_grid
from pianta.layout.parameters import ThesisParameters
from pianta.layout.partial.predict import measure_half_wall
from pianta.layout.partial.scene import FloorIndex, find_main_direction
from pianta.layout.thesis.faces import find_faces
from pianta.layout.thesis.lines import get_representative_lines
from pianta.layout.thesis.segments import detect_edges, detect_segments

SEEN_PART = "seen"
RECTANGLE = "rectangle"
FACES = "faces"
PREDICTED = "predicted"
GUESSES = (SEEN_PART, RECTANGLE, FACES, PREDICTED)


@dataclass(frozen=True, eq=False)
class Guesser:
    """What the guesses for all rooms of a floor have in common.

    half_wall: metres by which a seen part ends before the middle of its walls. faces: of the representative lines of
    Algorithm 1, map frame.
    """

    index: FloorIndex
    half_wall: float
    faces: STRtree

    @classmethod
    def make(cls, floor: Floor, grid: GridMap) -> Guesser:
        """The guesser of a floor that was reconstructed from a grid map."""
        return cls(FloorIndex.from_floor(floor), measure_half_wall(floor), STRtree(list_faces(grid)))

    def guess(self, room: Room) -> dict[str, Polygon]:
        """Each of GUESSES for a room, map frame; none covers the seen part of another room."""
        observed = self._reach_walls(room.polygon, room)
        # A prediction that adds nothing is the seen part without walls; a larger one ends in the walls already.
        added = self._cut(shapely.union(room.predicted or observed, observed, grid_size=SNAP_DISTANCE), room)
        rectangle = draw_rectangle(room, find_main_direction(self.index, room))
        return {
            SEEN_PART: observed,
            RECTANGLE: self._reach_walls(rectangle, room),
            # Faces end at the lines of the walls, which are in their middle.
            FACES: self._cut(complete_by_faces(room, self.faces), room),
            PREDICTED: added,
        }

    def _reach_walls(self, shape: Polygon, room: Room) -> Polygon:
        return self._cut(shape.buffer(self.half_wall, join_style="mitre", mitre_limit=2), room)

    def _cut(self, shape: shapely.Geometry, room: Room) -> Polygon:
        """A shape without other rooms, and with all of its own; only its largest part."""
        near = [self.index.rooms[i] for i in np.sort(self.index.tree.query(shape, predicate="intersects"))]
        others = shapely.union_all([other.polygon for other in near if other.id != room.id], grid_size=SNAP_DISTANCE)
        rest = shapely.difference(shape, others, grid_size=SNAP_DISTANCE)
        return largest_part(shapely.union(rest, room.polygon, grid_size=SNAP_DISTANCE))


def draw_rectangle(room: Room, direction: float) -> Polygon:
    """The rectangle around the explored part of a room, along a direction, radians."""
    upright = rotate(room.polygon, -direction, origin=(0, 0), use_radians=True)
    return rotate(shapely.box(*upright.bounds), direction, origin=(0, 0), use_radians=True)


def list_faces(grid: GridMap, parameters: ThesisParameters | None = None) -> list[Polygon]:
    """The faces F of Algorithm 1 (section 3.1), map frame."""
    if not grid.free.any():
        return []
    chosen = parameters or ThesisParameters()
    working_grid = to_working_grid(grid, grid.free, resolution=chosen.working_resolution)
    segments = detect_segments(detect_edges(working_grid, chosen), working_grid.resolution, chosen)
    faces = find_faces(get_representative_lines(segments, chosen), working_grid)
    return [working_grid.to_map(face) for face in faces.polygons]


def complete_by_faces(room: Room, faces: STRtree, *, inside_share: float | None = None) -> shapely.Geometry:
    """The union of the faces in which a room has a part: what section 8.2 predicts for it.

    inside_share: a face with a smaller share in the room is external, δ of the thesis; None for that of
    ThesisParameters.
    """
    share = ThesisParameters().inside_share if inside_share is None else inside_share
    near = faces.geometries[faces.query(room.polygon, predicate="intersects")]
    shared = shapely.area(shapely.intersection(near, room.polygon, grid_size=SNAP_DISTANCE))
    chosen = near[shared >= share * shapely.area(near)]
    return shapely.union_all([*chosen, room.polygon], grid_size=SNAP_DISTANCE)
