"""Made floors that are built like offices, and others that are not."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

from shapely import LineString, box

from pianta.floor import Door, Floor, Room
from pianta.worlds.floors import make_floor


@cache
def make_offices() -> tuple[Floor, ...]:
    """Eight floors of corridors with rooms along them."""
    shapes = ("corridor", "l")
    return tuple(
        replace(make_floor(shape, seed=seed), source=f"{shape} {name}.xml")
        for shape in shapes
        for seed, name in enumerate("abcd", start=1)
    )


@cache
def make_worlds() -> tuple[Floor, ...]:
    """Three floors whose rooms lead to rooms: two rows that wind to and fro, and a grid."""
    return make_snake(5, 4), make_snake(6, 3), make_grid_floor(5, 4)


def make_snake(width: int, height: int) -> Floor:
    """Square rooms, each with a door to the next one only; the last is a corridor."""
    cells = [(x if y % 2 else width - 1 - x, y) for y in range(height) for x in range(width)]
    return join_cells(cells, list(pairwise(cells)), source=f"snake {width}x{height}.xml")


def make_grid_floor(width: int, height: int) -> Floor:
    """Square rooms with doors to all rooms beside them; the last is a corridor."""
    cells = [(x, y) for y in range(height) for x in range(width)]
    beside = [((x, y), near) for x, y in cells for near in ((x + 1, y), (x, y + 1)) if near in cells]
    return join_cells(cells, beside, source=f"grid {width}x{height}.xml")


def join_cells(
    cells: list[tuple[int, int]], beside: list[tuple[tuple[int, int], tuple[int, int]]], *, source: str
) -> Floor:
    """Rooms of 5 m on cells, with a door of 1 m in the middle of the wall between each two beside each other."""
    ids = {cell: number for number, cell in enumerate(cells, start=1)}
    rooms = tuple(
        Room(room_id, box(5 * x, 5 * y, 5 * x + 5, 5 * y + 5), label="CORRIDOR" if cell == cells[-1] else "ROOM")
        for cell, room_id in ids.items()
        for x, y in [cell]
    )
    doors = []
    for one, other in beside:
        x, y = (2.5 * (a + b + 1) for a, b in zip(one, other, strict=True))
        across = (0.5, 0) if one[0] == other[0] else (0, 0.5)
        ends = [(x - across[0], y - across[1]), (x + across[0], y + across[1])]
        doors.append(Door((ids[one], ids[other]), LineString(ends), 1.0))
    return Floor(rooms, tuple(doors), source=source)
