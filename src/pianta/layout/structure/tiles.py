"""Large maps in overlapping tiles, so that memory is that of one tile and time grows with the area.

Each tile is read as a map of its own. A room belongs to the tile in whose core its middle lies. Where tiles overlap
they see the same rooms; those that agree there are one, so that a corridor that leads through several tiles is put
together from its parts in their cores.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import ceil

import networkx as nx
import numpy as np
import shapely
from shapely import LineString, Polygon, STRtree

from pianta._types import Indices
from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.floor.polygons import find_largest_polygon, list_polygons
from pianta.gridmap import GridMap
from pianta.layout._numbering import assemble_floor
from pianta.layout._working_grid import NO_ROOM


@dataclass(frozen=True, kw_only=True)
class TileParameters:
    """Sizes of `reconstruct_in_tiles`. Chosen by hand, no fit is on record."""

    max_whole: int = 36_000_000  # cells of a map that is read at once; 100 bytes each
    core: int = 4000  # cells of the longer side of a core, at most
    overlap: float = 20.0  # m around a core that its tile sees, too
    rim: float = 1.0  # m: a room that is nearer to the edge of its tile is cut there
    min_agreement: float = 0.5  # IoU, where both tiles see them, of two rooms that are one
    min_contained: float = 0.8  # of the smaller part, where both tiles see them, of two cut rooms that are one
    min_inside: float = 0.3  # of a room that is left out, in the room that has its place: its doors lead there
    seam: float = 0.15  # m between the parts of a room in two cores, at most
    min_left: float = 0.5  # of a room that overlaps others: below, it is left out
    same_door: float = 0.5  # m between the middles of a door in two tiles, at most


PARAMETERS = TileParameters()


@dataclass(frozen=True, eq=False)
class Tile:
    """A part of a map. core, extent: rectangles in the map frame; edge: of the extent, where the map goes on."""

    grid: GridMap
    core: Polygon
    extent: Polygon
    edge: shapely.Geometry


@dataclass(frozen=True, eq=False)
class _TileRoom:
    """A room of a tile, by the number of the tile.

    within: its part in the core. is_cut: whether it goes on beyond the tile. is_own: whether its middle is in the core.
    """

    tile: int
    room: Room
    within: shapely.Geometry
    is_cut: bool
    is_own: bool


def reconstruct_in_tiles(grid: GridMap, read: Callable[[GridMap], Floor]) -> Floor:
    """The floor of a large map, as `read` finds it in each tile.

    Raises MapError when no tile shows a room.
    """
    tiles, floors = [], []
    for tile in list_tiles(grid):
        try:
            floors.append(read(tile.grid))
            tiles.append(tile)
        except MapError:  # a tile of open space, or of none
            continue
    return join_tiles(grid, tiles, floors)


def join_tiles(grid: GridMap, tiles: Sequence[Tile], floors: Sequence[Floor]) -> Floor:
    """The floor of a map, of the floors of tiles whose cores cover it.

    Raises MapError when no tile shows a room.
    """
    tile_rooms = [_see(number, tiles[number], room) for number, floor in enumerate(floors) for room in floor]
    if not tile_rooms:
        raise MapError(NO_ROOM)
    rooms, room_of = _choose_rooms(tile_rooms, tiles)
    doors = _join_doors([floor.doors for floor in floors], tiles, room_of)
    possible_doors = _join_doors([floor.possible_doors for floor in floors], tiles, room_of)
    walls = [
        part
        for tile, floor in zip(tiles, floors, strict=True)
        for wall in floor.walls
        for part in shapely.get_parts(wall.intersection(tile.core))
        if isinstance(part, LineString) and part.length > 0
    ]
    furniture = tuple(
        piece
        for tile, floor in zip(tiles, floors, strict=True)
        for piece in floor.furniture
        if tile.core.contains(piece.polygon.centroid)
    )
    floor = assemble_floor(rooms, doors, walls, grid, possible_doors=possible_doors)
    return replace(floor, furniture=furniture)


def list_tiles(grid: GridMap) -> Iterator[Tile]:
    """The tiles of a map that have free cells, in reading order; their cores cover it."""
    p = PARAMETERS
    margin = ceil(p.overlap / grid.resolution)
    height, width = grid.shape
    bounds = [np.linspace(0, side, ceil(side / p.core) + 1).round().astype(int) for side in (height, width)]
    spans = [list(zip(each[:-1].tolist(), each[1:].tolist(), strict=True)) for each in bounds]
    for (top, bottom), (left, right) in product(*spans):
        rows = slice(max(0, top - margin), min(height, bottom + margin))
        cols = slice(max(0, left - margin), min(width, right + margin))
        x, y = grid.pixel_to_map(rows.stop, cols.start)
        part = GridMap(grid.cells[rows, cols], grid.resolution, (float(x), float(y), grid.origin[2]), grid.source)
        if not part.free[top - rows.start : bottom - rows.start, left - cols.start : right - cols.start].any():
            continue
        sides = [
            _in_map(grid, [(rows.start, cols.start), (rows.start, cols.stop)], is_edge=rows.start > 0),
            _in_map(grid, [(rows.stop, cols.start), (rows.stop, cols.stop)], is_edge=rows.stop < height),
            _in_map(grid, [(rows.start, cols.start), (rows.stop, cols.start)], is_edge=cols.start > 0),
            _in_map(grid, [(rows.start, cols.stop), (rows.stop, cols.stop)], is_edge=cols.stop < width),
        ]
        yield Tile(
            part,
            make_rectangle(grid, (top, left, bottom, right)),
            make_rectangle(grid, (rows.start, cols.start, rows.stop, cols.stop)),
            shapely.union_all([side for side in sides if side is not None]),
        )


def _in_map(grid: GridMap, ends: Sequence[tuple[int, int]], *, is_edge: bool) -> LineString | None:
    """A side of a tile in the map frame, from row and col; None if the map ends there."""
    return LineString(np.column_stack(grid.pixel_to_map(*np.array(ends, float).T))) if is_edge else None


def make_rectangle(grid: GridMap, sides: tuple[int, int, int, int]) -> Polygon:
    """The rectangle of top, left, bottom and right, cells, in the map frame."""
    top, left, bottom, right = sides
    corners = np.array([(top, left), (bottom, left), (bottom, right), (top, right)], float)
    return Polygon(np.column_stack(grid.pixel_to_map(*corners.T)))


def _see(number: int, tile: Tile, room: Room) -> _TileRoom:
    within = room.polygon.intersection(tile.core)
    is_cut = not tile.edge.is_empty and room.polygon.distance(tile.edge) < PARAMETERS.rim
    return _TileRoom(number, room, within, is_cut, tile.core.contains(room.polygon.centroid))


def _choose_rooms(
    tile_rooms: Sequence[_TileRoom], tiles: Sequence[Tile]
) -> tuple[list[Room], dict[tuple[int, int], int]]:
    """The rooms of the map, and for each (tile, id) the number of the room that has its place."""
    groups = [[tile_rooms[index] for index in sorted(group)] for group in _match(tile_rooms, tiles)]
    drafts = [draft for group in groups if (draft := _draft(group)) is not None]
    chosen = _separate(drafts)
    rooms = [replace(room, id=number) for number, (room, _) in enumerate(chosen, start=1)]
    room_of = {(each.tile, each.room.id): number for number, (_, group) in enumerate(chosen, start=1) for each in group}
    tree = STRtree([room.polygon for room in rooms])
    for each in tile_rooms:
        if (each.tile, each.room.id) not in room_of:
            near = tree.query(each.room.polygon, predicate="intersects").tolist()
            shared = {index: rooms[index].polygon.intersection(each.room.polygon).area for index in near}
            best = max(shared, key=lambda index: shared[index], default=None)
            if best is not None and shared[best] >= PARAMETERS.min_inside * each.room.polygon.area:
                room_of[each.tile, each.room.id] = rooms[best].id
    return rooms, room_of


def _match(tile_rooms: Sequence[_TileRoom], tiles: Sequence[Tile]) -> Iterator[set[int]]:
    """Groups of rooms, by their index, that are one: they agree where their tiles overlap."""
    same = nx.Graph()
    same.add_nodes_from(range(len(tile_rooms)))
    polygons = [each.room.polygon for each in tile_rooms]
    pairs: Indices = STRtree(polygons).query(polygons, predicate="intersects").T
    for first, second in pairs[pairs[:, 0] < pairs[:, 1]].tolist():
        one, other = tile_rooms[first], tile_rooms[second]
        if one.tile != other.tile:
            both = _keep_area(tiles[one.tile].extent.intersection(tiles[other.tile].extent))
            parts = [_keep_area(polygon.intersection(both)) for polygon in (polygons[first], polygons[second])]
            shared = parts[0].intersection(parts[1]).area
            together = parts[0].area + parts[1].area - shared
            # A room that both tiles cut may be in parts in one of them
            smaller = min(part.area for part in parts) if one.is_cut and other.is_cut else together
            if shared > 0 and (
                shared >= PARAMETERS.min_agreement * together or shared >= PARAMETERS.min_contained * smaller
            ):
                same.add_edge(first, second)
    yield from nx.connected_components(same)


def _keep_area(shape: shapely.Geometry) -> shapely.Geometry:
    """The polygons of a shape, as GEOS cannot intersect what also has lines, of sides that only touch."""
    return shapely.union_all(list_polygons(shape))


def _draft(group: Sequence[_TileRoom]) -> tuple[Room, Sequence[_TileRoom]] | None:
    """The room of a group, put together from its parts if every tile cuts it; None if it is another tile's."""
    uncut = [each for each in group if not each.is_cut]
    if uncut:
        own = [each for each in uncut if each.is_own]
        if not own and len(group) == 1:
            return None
        return max(own or uncut, key=lambda each: each.within.area).room, group
    joined = shapely.union_all([each.within.buffer(PARAMETERS.seam, join_style="mitre") for each in group])
    polygon = find_largest_polygon(joined.buffer(-PARAMETERS.seam, join_style="mitre"))
    if not polygon.area:
        return None
    largest = max(group, key=lambda each: each.within.area).room
    probabilities = [each.room.probability for each in group if each.room.probability is not None]
    is_partial = any(each.room.partial for each in group)
    probability = min(probabilities, default=None)
    return replace(largest, polygon=polygon, partial=is_partial, probability=probability), group


def _separate(
    drafts: Sequence[tuple[Room, Sequence[_TileRoom]]],
) -> list[tuple[Room, Sequence[_TileRoom]]]:
    """The rooms without what they share with others: the larger one keeps it."""
    order = sorted(range(len(drafts)), key=lambda index: -drafts[index][0].polygon.area)
    rank = {index: number for number, index in enumerate(order)}
    tree = STRtree([room.polygon for room, _ in drafts])
    separate = []
    for index, (room, group) in enumerate(drafts):
        near = tree.query(room.polygon, predicate="intersects").tolist()
        larger = [drafts[other][0].polygon for other in near if rank[other] < rank[index]]
        left = room.polygon.difference(shapely.union_all(larger)) if larger else room.polygon
        rest = find_largest_polygon(left)
        if rest.area >= PARAMETERS.min_left * room.polygon.area:
            separate.append((replace(room, polygon=rest) if larger else room, group))
    return separate


def _join_doors(
    doors: Sequence[Sequence[Door]], tiles: Sequence[Tile], room_of: dict[tuple[int, int], int]
) -> list[Door]:
    """The doors of the rooms that are left, each once."""
    joined: list[Door] = []
    middles: dict[frozenset[int | None], list[shapely.Point]] = {}
    for number, (tile, own) in enumerate(zip(tiles, doors, strict=True)):
        near = tile.core.buffer(PARAMETERS.same_door)
        for door in own:
            first, second = room_of.get((number, door.rooms[0])), None
            if door.rooms[1] is not None:
                second = room_of.get((number, door.rooms[1]))
            is_lost = first is None or (second is None and door.rooms[1] is not None)
            middle = door.line.interpolate(0.5, normalized=True)
            if first is None or is_lost or first == second or not near.contains(middle):
                continue
            there = middles.setdefault(frozenset({first, second}), [])
            if all(middle.distance(other) > PARAMETERS.same_door for other in there):
                there.append(middle)
                joined.append(replace(door, rooms=(first, second)))
    return joined
