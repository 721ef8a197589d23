"""Ways of a robot through furnished rooms: pieces that close them are taken out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from scipy.ndimage import label
from shapely import LineString, MultiLineString, MultiPolygon, Polygon
from skimage.graph import MCP_Geometric

from pianta.floor import Floor, Room
from pianta.worlds.dense_furniture import StandingPiece

# All chosen by hand.
# Cells of the search; metres.
CELL = 0.1
# How much longer a way round a piece may be than the way through it.
DETOUR = 30.0
# Beyond the radius of the robot, because ways have the steps of cells; metres.
SLACK = 0.08


def keep_ways(floor: Floor, pieces: Sequence[StandingPiece], *, radius: float) -> list[StandingPiece]:
    """The pieces without those that close the ways of a robot from the doors of a room to its largest free part.

    radius: of the robot, metres. Rooms and doors that are too narrow for it even when empty stay as they are.
    """
    remaining: list[StandingPiece] = []
    for room in floor.rooms:
        own = [piece for piece in pieces if piece.room == room.id]
        doors = [door.line for door in floor.doors if room.id in door.room_ids]
        ways = _find_ways(room, doors, [part for piece in own for part in piece.parts], radius + SLACK)
        shapely.prepare(ways)
        remaining += [piece for piece in own if not shapely.dwithin(ways, MultiPolygon(piece.parts), radius)]
    return remaining


def _find_ways(
    room: Room, doors: Sequence[LineString], obstacles: Sequence[Polygon], clearance: float
) -> MultiLineString:
    """The shortest ways from doors to the largest free part of a room; those through obstacles count DETOUR times.

    doors: from jamb to jamb. clearance: of the ways from walls, and if possible from obstacles; all metres.
    """
    inner = room.polygon.buffer(-clearance)
    if inner.is_empty or not doors or not obstacles:
        return MultiLineString()
    # The cells of the room, and what a step on each costs
    left, low, right, high = inner.bounds
    x, y = np.meshgrid(np.arange(left, right, CELL), np.arange(low, high, CELL))
    inside = shapely.contains_xy(inner, x, y)
    blocked = shapely.contains_xy(shapely.union_all(shapely.buffer([*obstacles], clearance, quad_segs=2)), x, y)
    if not inside.any():
        return MultiLineString()
    costs = np.where(inside, np.where(blocked, DETOUR, 1.0), np.inf)
    # From the largest free part to each door
    parts, _ = label(inside & ~blocked if (inside & ~blocked).any() else inside)
    start = np.argwhere(parts == np.bincount(parts[parts > 0]).argmax())[0]
    search = MCP_Geometric(costs)
    reached, _ = search.find_costs([start])
    cells = np.argwhere(np.isfinite(reached))
    cell_x, cell_y = x[tuple(cells.T)], y[tuple(cells.T)]
    ways = []
    for door in doors:
        (goal,) = door.interpolate(0.5, normalized=True).coords
        nearest = np.hypot(cell_x - goal[0], cell_y - goal[1]).argmin()
        rows, cols = np.array(search.traceback(cells[nearest])).T
        ways.append(LineString([*zip(x[rows, cols], y[rows, cols], strict=True), goal]))
    return MultiLineString(ways).simplify(0)
