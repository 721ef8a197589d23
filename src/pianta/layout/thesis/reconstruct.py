"""Layout reconstruction by Algorithm 1 of the thesis (section 3.1)."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.sparse import csr_array

from pianta._types import Indices, LabelImage, Mask
from pianta.errors import MapError
from pianta.floor import Floor, Room
from pianta.floor.polygons import find_largest_polygon
from pianta.gridmap import GridMap
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.layout._numbering import assemble_floor
from pianta.layout._voronoi_doors import find_doors
from pianta.layout._working_grid import NO_ROOM, WorkingGrid, check_shows_rooms, remove_clutter, to_working_grid
from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis.affinity import cluster_faces, compute_affinity_matrix, find_partial_faces, normalise_affinity
from pianta.layout.thesis.contour import compute_map_contour
from pianta.layout.thesis.faces import FRINGE, Faces, cut_lines, find_faces, label_faces, share_free, share_inside
from pianta.layout.thesis.lines import get_representative_lines
from pianta.layout.thesis.segments import detect_edges, detect_segments


def reconstruct_layout(grid: GridMap, *, parameters: ThesisParameters, with_doors: bool = True) -> Floor:
    """Layout of a grid map by Algorithm 1, with the doors of the topological map; metres in the map frame.

    Rooms are numbered in reading order of the map image. with_doors: False to leave out the doors, which cost most of
    the time. Raises MapError when the map shows no room.
    """
    check_shows_rooms(grid)
    # M: free space, without the small groups of cells that are furniture (section 3.2)
    size_px = parameters.clutter_size / grid.resolution
    free = remove_clutter(grid.free, size_px=size_px) if parameters.remove_clutter else grid.free
    working_grid = to_working_grid(
        grid, free, resolution=parameters.working_resolution, normal_pose=parameters.normal_pose
    )
    # Compute features from the map
    edges = detect_edges(working_grid, parameters)
    segments = detect_segments(edges, working_grid.resolution, parameters)
    # Obtain the contour of the map
    inner = compute_map_contour(working_grid, parameters)
    # Create clusters of collinear segments, and their representative lines
    lines = get_representative_lines(segments, parameters)
    # Find faces from representative lines
    faces = find_faces(lines, working_grid)
    # Compute the spatial affinity between faces
    local_affinity = normalise_affinity(compute_affinity_matrix(faces, sigma=parameters.sigma))
    # Remove faces outside the border
    face_of_cell = label_faces(faces, working_grid)
    internal = share_inside(face_of_cell, inner, len(faces.polygons)) >= parameters.inside_share
    free_share = share_free(faces, working_grid) if parameters.need_open_edge else np.ones(len(faces.weight))
    partial = find_partial_faces(faces, internal, free_share, partial_weight=parameters.partial_weight)
    # Cluster faces together into rooms
    room_of_face = _cluster_internal_faces(local_affinity, internal, parameters)
    room_of_face = _drop_small_rooms(room_of_face, face_of_cell, working_grid, parameters)
    rooms = _merge_faces(faces, room_of_face, partial, working_grid)
    if not rooms:
        raise MapError(NO_ROOM)
    # Find the connections between rooms
    room_of_cell = np.append(room_of_face, -1)[face_of_cell]
    doors = find_doors(working_grid, room_of_cell, parameters) if with_doors else []
    # A line along the outer wall may run just outside the rooms.
    extent = shapely.box(*shapely.total_bounds(faces.polygons[room_of_face >= 0])).buffer(FRINGE, join_style="mitre")
    walls = cut_lines(lines, extent)
    return assemble_floor(rooms, doors, [working_grid.to_map(wall) for wall in walls], grid)


def _cluster_internal_faces(local_affinity: csr_array, internal: Mask, parameters: ThesisParameters) -> Indices:
    """Cluster of each face, shape (F,); -1 for external faces."""
    clusters = np.full(len(internal), -1, np.intp)
    chosen = np.flatnonzero(internal)
    clusters[chosen] = cluster_faces(local_affinity[chosen][:, chosen], epsilon=parameters.epsilon)
    return clusters


def _drop_small_rooms(
    cluster_of_face: Indices, face_of_cell: LabelImage, working_grid: WorkingGrid, parameters: ThesisParameters
) -> Indices:
    """Room 0 … R - 1 of each face, shape (F,): clusters with at least the free area of a room; -1 for other faces.

    As printed (drop_small_rooms is False) every cluster is a room.
    """
    clusters = np.append(cluster_of_face, -1)[face_of_cell[working_grid.free]]
    free_area = np.bincount(clusters + 1, minlength=cluster_of_face.max(initial=-1) + 2) * working_grid.resolution**2
    is_room = free_area >= (parameters.room_area if parameters.drop_small_rooms else 0.0)
    is_room[0] = False
    return np.where(is_room, np.cumsum(is_room) - 1, -1)[cluster_of_face + 1]


def _merge_faces(faces: Faces, room_of_face: Indices, partial: Mask, working_grid: WorkingGrid) -> list[Room]:
    """Rooms, with ids 1 … R, as the union of their faces, in the map frame; partial if one of the faces is."""
    count = int(room_of_face.max(initial=-1)) + 1
    merged = [shapely.coverage_union_all(faces.polygons[room_of_face == i]) for i in range(count)]
    largest = np.array([find_largest_polygon(shape) for shape in merged], dtype=object)
    return [
        Room(i + 1, working_grid.to_map(outline), partial=bool(partial[room_of_face == i].any()))
        for i, outline in enumerate(shapely.coverage_simplify(largest, SNAP_DISTANCE))
    ]
