"""What stands in rooms, by their labels: a recipe for each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pianta.worlds.pieces import (
    FurnitureStyle,
    Piece,
    make_bath_fitting,
    make_bed,
    make_block,
    make_cubicle,
    make_desk,
    make_rack,
    make_round,
    make_round_table,
    make_shelf,
    make_sofa,
    make_table_group,
    outline_box,
    transform_outlines,
)
from pianta.worlds.room_space import PIECE_GAP, WALL_GAP, RoomSpace

# The measures and shares of this module were chosen by hand.


def furnish_by_label(space: RoomSpace, label: str | None) -> None:
    """Furnish a room as its label says, or at random if there is no recipe for it."""
    recipe = _RECIPES.get(label or "") or _choose_recipe(space)
    recipe(space)


def _choose_recipe(space: RoomSpace) -> Callable[[RoomSpace], None]:
    """A recipe for a room without a label that has one, by its area and at random."""
    if space.area < 4:
        return _furnish_store
    names: tuple[str, ...] = ("OFFICE", "CONFERENCE ROOM", "LAB", "CLASSROOM", "LIVING ROOM")
    if space.area < 12:
        names = ("OFFICE", "STORE", "BEDROOM")
    elif space.area > 60:
        names = ("OPENSPACE", "LAB", "CLASSROOM", "CAFETERIA", "LIBRARY")
    return _RECIPES[names[int(space.rng.integers(len(names)))]]


def _add_storage(space: RoomSpace, mean: float) -> None:
    """Shelves and cabinets at walls; some stand a gap before the wall, and things are behind them."""
    rng = space.rng
    for _ in range(space.count(mean)):
        width, depth = rng.uniform(0.6, 2.2), rng.uniform(0.28, 0.6) if rng.random() < 0.75 else rng.uniform(0.6, 0.8)
        piece = make_shelf(space.furniture, width, depth)
        if rng.random() < 0.15:
            gap = rng.uniform(0.2, 0.6)
            thing = make_block(rng.uniform(0.2, 0.5), min(gap - 0.05, 0.3))
            behind = transform_outlines(thing.outlines, rng.uniform(-0.2, 0.2), 0.02 - gap, 0)
            piece = Piece(piece.bounds, piece.outlines + (behind if rng.random() < 0.5 else []), piece.kind)
            space.put_at_wall(piece, gap)
        else:
            space.put_at_wall(piece)


def _add_clutter(space: RoomSpace, mean: float) -> None:
    """Boxes, bins, plants, bags and single chairs."""
    rng = space.rng
    for _ in range(space.count(mean)):
        draw = rng.random()
        if draw < 0.4:
            piece = make_block(rng.uniform(0.25, 0.65), rng.uniform(0.2, 0.5))
        elif draw < 0.7:
            piece = make_round(rng.uniform(0.1, 0.25))
        else:
            piece = Piece((-0.3, 0, 0.3, 0.6), space.furniture.place_chair(0, 0.3, rng), "chair")
        if rng.random() < 0.65:
            space.put_at_wall(piece, WALL_GAP + rng.uniform(0, 0.1))
        else:
            space.put_free(piece, any_angle=0.6)


def _furnish_bedroom(space: RoomSpace) -> None:
    rng = space.rng
    for _ in range(max(1, space.count(0.4 + space.area / 25))):
        width = rng.uniform(1.4, 1.85) if space.area > 9 and rng.random() < 0.6 else rng.uniform(0.9, 1.1)
        space.put_at_wall(make_bed(space.furniture, rng, width=width), attempts=15)
    if space.chance(0.85):
        space.put_at_wall(make_block(rng.uniform(0.9, 2.4), rng.uniform(0.55, 0.65), "wardrobe"), attempts=10)
    if space.chance(0.4):
        space.put_at_wall(make_desk(space.furniture, rng))
    _add_storage(space, 0.8)
    _add_clutter(space, 0.1 * space.area)


def _furnish_living_room(space: RoomSpace) -> None:
    rng = space.rng
    if space.chance(0.9):
        sofa = make_sofa(space.furniture, rng)
        if space.area < 20 or rng.random() < 0.7 or not space.put_free(sofa, any_angle=0.05):
            space.put_at_wall(sofa, attempts=12)
    if space.chance(0.7):
        space.put_at_wall(make_block(rng.uniform(1.2, 2.2), rng.uniform(0.35, 0.5)))
    for _ in range(space.count(space.area / 20)):
        space.put_free(make_block(rng.uniform(0.7, 0.9), rng.uniform(0.75, 0.9)), any_angle=0.5)
    if space.area > 13 and space.chance(0.75):
        _add_table(space)
    _add_storage(space, space.area / 9)
    _add_clutter(space, 0.12 * space.area)


def _add_table(space: RoomSpace) -> None:
    """A table with chairs."""
    rng = space.rng
    if rng.random() < 0.3:
        space.put_free(make_round_table(space.furniture, rng), attempts=12)
    else:
        piece = make_table_group(space.furniture, rng, width=rng.uniform(0.9, 1.9), depth=rng.uniform(0.7, 0.95))
        space.put_free(piece, any_angle=0.1, attempts=12)


def _furnish_dining_room(space: RoomSpace) -> None:
    _add_table(space)
    _add_storage(space, 1.5)
    _add_clutter(space, 0.08 * space.area)


def _add_counters(space: RoomSpace, runs: int) -> None:
    """Counters of units of 0.6 m along sides of the room, as far as doors let them."""
    rng = space.rng
    order = sorted(range(len(space.lengths)), key=lambda side: -space.lengths[side] * rng.uniform(0.5, 1))
    for side in order[:runs]:
        depth, most = rng.uniform(0.58, 0.66), int(rng.integers(4, 9))
        for unit in range(min(int(space.lengths[side] / 0.6), most)):
            dx, dy = space.directions[side]
            x, y = space.starts[side] + (0.6 * unit + 0.3 + WALL_GAP) * space.directions[side]
            # Units of a counter stand beside each other without a gap, short of rounding.
            turn = float(np.arctan2(dy, dx))
            space.put(
                make_block(0.598, depth, "counter"), float(x - WALL_GAP * dy), float(y + WALL_GAP * dx), turn, gap=0
            )


def _furnish_kitchen(space: RoomSpace) -> None:
    rng = space.rng
    _add_counters(space, 1 + int(rng.random() < 0.6) + int(rng.random() < 0.2))
    if space.area > 11 and space.chance(0.35):
        space.put_free(make_block(rng.uniform(1.2, 2.2), rng.uniform(0.7, 1.0), "counter"), any_angle=0)
    if space.area > 7 and space.chance(0.6):
        for _ in range(1 + int(space.area / 25)):
            _add_table(space)
    _add_clutter(space, 0.1 * space.area)


def _furnish_bathroom(space: RoomSpace) -> None:
    rng = space.rng
    if space.area > 9:
        # Cabins and basins of a washroom.
        for _ in range(space.count(space.area / 4)):
            space.put_at_wall(make_bath_fitting(rng, "toilet" if rng.random() < 0.5 else "basin"))
        return
    names = ["tub" if rng.random() < 0.5 else "shower", "toilet", "basin", "machine"]
    for name in names:
        if space.chance({"machine": 0.4, "tub": 0.8, "shower": 0.8}.get(name, 0.95)):
            space.put_at_wall(make_bath_fitting(rng, name), attempts=12)
    _add_clutter(space, 0.15 * space.area)


def _furnish_toilet(space: RoomSpace) -> None:
    space.put_at_wall(make_bath_fitting(space.rng, "toilet"), attempts=12)
    if space.chance(0.4):
        space.put_at_wall(make_bath_fitting(space.rng, "basin"))


def _furnish_store(space: RoomSpace) -> None:
    rng = space.rng
    for _ in range(space.count(1 + space.area / 4)):
        space.put_at_wall(make_shelf(space.furniture, rng.uniform(0.5, 2.0), rng.uniform(0.3, 0.55)))
    if space.area > 18:
        _add_shelf_rows(space)
    _add_clutter(space, 0.3 * space.area)


def _add_shelf_rows(space: RoomSpace) -> None:
    """Rows of free-standing shelves."""
    rng = space.rng
    depth, width = rng.uniform(0.35, 0.8), rng.uniform(0.9, 1.2)
    missing = 1 - min(0.9, 0.75 * space.density)
    space.put_rows(
        lambda: make_shelf(space.furniture, width, depth),
        pitch=width + 2 * PIECE_GAP + 0.01,
        aisle=rng.uniform(0.9, 1.6),
        missing=0.3 * missing,
        margin=rng.uniform(0.9, 1.5),
    )


def _furnish_corridor(space: RoomSpace) -> None:
    """Low pieces along the walls: lockers, shelves, wardrobes, benches; bins, plants and boxes."""
    rng = space.rng
    width = 2 * space.area / space.polygon.length
    if rng.random() < 0.25:
        return
    deepest = min(0.55, 0.3 * width)
    for _ in range(space.count(space.area / 14)):
        if deepest < 0.2:
            break
        length = rng.uniform(0.5, 2.0) if rng.random() < 0.7 else rng.uniform(2, 5)
        space.put_at_wall(make_shelf(space.furniture, length, rng.uniform(0.2, deepest)))
    for _ in range(space.count(space.area / 40) if width > 2 else 0):
        # Beds, carts and sofas that stand in wide corridors.
        space.put_at_wall(make_block(rng.uniform(0.8, 2.1), rng.uniform(0.45, 0.95)), WALL_GAP + rng.uniform(0, 0.15))
    for _ in range(space.count(space.area / 16)):
        size = rng.uniform(0.2, max(0.2, min(0.45, 0.35 * width)))
        piece = make_round(size / 2) if rng.random() < 0.5 else make_block(size * rng.uniform(1, 1.6), size)
        space.put_at_wall(piece, WALL_GAP + rng.uniform(0, 0.1))


def _furnish_office(space: RoomSpace) -> None:
    rng = space.rng
    for _ in range(max(1, space.count(space.area / 8))):
        piece = make_desk(space.furniture, rng, with_screen=rng.random() < 0.2)
        # Desks stand at walls, or across the room with the chair behind them.
        if rng.random() < 0.65:
            space.put_at_wall(piece, attempts=8)
        else:
            space.put_free(piece, any_angle=0.1)
    if space.area > 14 and space.chance(0.4):
        _add_table(space)
    _add_storage(space, space.area / 7)
    _add_clutter(space, 0.1 * space.area)


def _furnish_open_plan(space: RoomSpace) -> None:
    rng = space.rng
    furniture = space.furniture
    missing = max(0.05, 0.5 - 0.4 * space.density) * rng.uniform(0.5, 1.5)
    draw = rng.random()
    if draw < 0.4:
        space.put_rows(
            lambda: make_cubicle(furniture, rng),
            pitch=2.45,
            aisle=rng.uniform(1.1, 1.8),
            missing=missing,
            back_to_back=True,
        )
    elif draw < 0.85:
        with_screen = rng.random() < 0.5
        space.put_rows(
            lambda: make_desk(furniture, rng, with_screen=with_screen),
            pitch=rng.uniform(1.75, 2.0),
            aisle=rng.uniform(0.5, 1.3),
            missing=missing,
            back_to_back=rng.random() < 0.75,
        )
    else:
        for _ in range(space.count(space.area / 7)):
            space.put_free(make_desk(furniture, rng, with_screen=rng.random() < 0.5))
    for _ in range(space.count(space.area / 60)):
        _add_table(space)
    for _ in range(space.count(space.area / 40)):
        # Partitions and cabinets that divide the room.
        space.put_free(make_block(rng.uniform(1.2, 3.6), rng.choice([0.05, 0.08, 0.45])), any_angle=0.05)
    _add_storage(space, space.area / 14)
    _add_clutter(space, 0.06 * space.area)


def _furnish_meeting_room(space: RoomSpace) -> None:
    rng = space.rng
    short, long = sorted(space.size)
    width = float(np.clip(long - rng.uniform(2.0, 3.5), 1.0, 6.0))
    depth = float(np.clip(short - rng.uniform(2.2, 3.0), 0.8, 1.6))
    piece = make_table_group(space.furniture, rng, width=width, depth=depth)
    x, y = space.polygon.representative_point().coords[0]
    along_x = space.size[0] >= space.size[1]
    middle = (piece.bounds[3]) / 2
    if not space.put(piece, x if along_x else x + middle, y - middle if along_x else y, 0 if along_x else np.pi / 2):
        _add_table(space)
    if space.area > 45:
        _furnish_classroom(space)
    _add_storage(space, 0.8 + space.area / 40)
    _add_clutter(space, 0.1 * space.area)


def _furnish_classroom(space: RoomSpace) -> None:
    rng = space.rng
    space.put_at_wall(make_desk(space.furniture, rng), rng.uniform(0.8, 1.5))
    width = rng.uniform(0.65, 1.4)

    def make() -> Piece:
        outlines = space.furniture.place_table(-width / 2, 0, width / 2, 0.5)
        for x in (0.0,) if width < 1 else (-width / 4, width / 4):
            outlines = outlines + space.furniture.place_chair(x, 0.72 + rng.uniform(-0.1, 0.15), rng)
        return Piece((-width / 2, 0, width / 2, 1.05), outlines, "desk")

    space.put_rows(
        make,
        pitch=width + rng.choice([0.08, 0.5, 0.8]),
        aisle=rng.uniform(0.1, 0.6),
        missing=max(0.05, 0.6 - 0.5 * space.density),
        margin=rng.uniform(0.8, 1.6),
    )
    _add_storage(space, space.area / 20)
    _add_clutter(space, 0.04 * space.area)


def _furnish_lab(space: RoomSpace) -> None:
    rng = space.rng
    depth, pitch = rng.uniform(0.75, 1.5), rng.uniform(1.5, 3.5)
    solid = rng.random() < 0.5

    def make() -> Piece:
        body = [outline_box(-pitch / 2, 0, pitch / 2, depth)]
        outlines = body if solid else space.furniture.place_table(-pitch / 2, 0, pitch / 2, depth)
        for _ in range(int(rng.integers(0, 3))):
            outlines = outlines + space.furniture.place_chair(
                rng.uniform(-pitch / 2, pitch / 2) * 0.8, depth + 0.25, rng
            )
        return Piece((-pitch / 2, 0, pitch / 2, depth + 0.55), outlines, "bench")

    missing = max(0.05, 0.5 - 0.4 * space.density)
    space.put_rows(make, pitch=pitch + 0.07, aisle=rng.uniform(0.6, 1.2), missing=missing, margin=rng.uniform(0.7, 1.4))
    if rng.random() < 0.5:
        _add_counters(space, 1)
    _add_storage(space, space.area / 9)
    _add_clutter(space, 0.08 * space.area)


def _furnish_library(space: RoomSpace) -> None:
    if space.area > 15:
        _add_shelf_rows(space)
    for _ in range(space.count(space.area / 25)):
        _add_table(space)
    _add_storage(space, space.area / 8)
    _add_clutter(space, 0.03 * space.area)


def _furnish_ward(space: RoomSpace) -> None:
    rng = space.rng
    wheels = FurnitureStyle(space.furniture.chair, "legs", "legs" if rng.random() < 0.6 else "solid", "solid", 0.1)
    for _ in range(max(1, min(space.count(space.area / 9), 6))):
        space.put_at_wall(make_bed(wheels, rng, width=rng.uniform(0.9, 1.0)), rng.uniform(0.02, 0.3), attempts=12)
    for _ in range(space.count(1.5)):
        space.put_free(make_block(rng.uniform(0.4, 0.8), rng.uniform(0.35, 0.5)), any_angle=0.5)
    if space.chance(0.5):
        space.put_free(make_round_table(space.furniture, rng))
    _add_storage(space, 1.5)
    _add_clutter(space, 0.12 * space.area)


def _furnish_reception(space: RoomSpace) -> None:
    rng = space.rng
    if space.chance(0.9):
        width, depth = rng.uniform(1.8, 3.2), rng.uniform(0.6, 0.8)
        outlines = [
            outline_box(-width / 2, 0, width / 2, depth),
            outline_box(width / 2 - depth, depth, width / 2, depth + 0.9),
        ]
        outlines += space.furniture.place_chair(0, depth + 0.4, rng)
        space.put_free(Piece((-width / 2, 0, width / 2, depth + 0.9), outlines, "counter"), any_angle=0, attempts=15)
    for _ in range(space.count(space.area / 10)):
        space.put_at_wall(make_desk(space.furniture, rng))
    _add_storage(space, space.area / 8)
    _add_clutter(space, 0.12 * space.area)


def _furnish_lobby(space: RoomSpace) -> None:
    rng = space.rng
    for _ in range(space.count(space.area / 16)):
        draw = rng.random()
        if draw < 0.4:
            space.put_at_wall(make_sofa(space.furniture, rng))
        elif draw < 0.7:
            _add_table(space)
        else:
            bench = Piece((-0.9, 0, 0.9, 0.5), space.furniture.place_table(-0.9, 0, 0.9, 0.45), "bench")
            space.put_free(bench)
    _add_storage(space, space.area / 25)
    _add_clutter(space, 0.05 * space.area)


def _furnish_cafeteria(space: RoomSpace) -> None:
    rng = space.rng
    width = rng.uniform(0.75, 1.7)
    space.put_rows(
        lambda: make_table_group(space.furniture, rng, width=width, depth=0.75),
        pitch=width + rng.uniform(0.9, 1.4),
        aisle=rng.uniform(0.1, 0.7),
        missing=max(0.05, 0.5 - 0.4 * space.density),
    )
    if space.chance(0.6):
        _add_counters(space, 1)
    _add_clutter(space, 0.03 * space.area)


def _furnish_gym(space: RoomSpace) -> None:
    rng = space.rng
    for _ in range(space.count(space.area / 25)):
        piece = Piece((-1.5, 0, 1.5, 0.4), space.furniture.place_table(-1.5, 0, 1.5, 0.35), "bench")
        space.put_at_wall(piece) if rng.random() < 0.7 else space.put_free(piece)
    for _ in range(space.count(space.area / 40)):
        space.put_free(make_block(rng.uniform(0.8, 2), rng.uniform(0.8, 1.2)), any_angle=0.5)


def _furnish_warehouse(space: RoomSpace) -> None:
    rng = space.rng
    draw = rng.random()
    if draw < 0.65:
        length, depth, solid = rng.uniform(2.5, 8), rng.uniform(0.5, 1.2), bool(rng.random() < 0.5)
        space.put_rows(
            lambda: make_rack(rng, length=length, depth=depth, solid=solid),
            pitch=length + (2 * PIECE_GAP + 0.01 if rng.random() < 0.6 else rng.uniform(1.2, 2.5)),
            aisle=rng.uniform(1.6, 3.5),
            missing=max(0.05, 0.4 - 0.3 * space.density),
            back_to_back=rng.random() < 0.6,
            margin=rng.uniform(1.5, 3.0),
        )
    for _ in range(space.count(space.area / (12 if draw > 0.65 else 40))):
        piece = make_block(rng.uniform(0.8, 1.3), rng.uniform(0.8, 1.2))
        space.put_free(piece, any_angle=0.3)
    for _ in range(space.count(space.area / 120)):
        space.put_free(make_block(rng.uniform(1.0, 1.3), rng.uniform(2.0, 3.0)), any_angle=0.5)
    _add_storage(space, space.area / 40)
    _add_clutter(space, 0.02 * space.area)


def _leave_empty(space: RoomSpace) -> None:
    """Stairs, lifts and shafts stay empty."""


# Label of a room -> how it is furnished; labels of all schemas whose furniture is evident, and of the synthetic floors.
_RECIPES: dict[str, Callable[[RoomSpace], None]] = {
    "BEDROOM": _furnish_bedroom,
    "CHILD ROOM": _furnish_bedroom,
    "GUEST ROOM": _furnish_bedroom,
    "LIVING ROOM": _furnish_living_room,
    "DINING ROOM": _furnish_dining_room,
    "KITCHEN": _furnish_kitchen,
    "BATHROOM": _furnish_bathroom,
    "WASHROOM": _furnish_bathroom,
    "TOILET": _furnish_toilet,
    "CLOSET": _furnish_store,
    "WARDROBE": _furnish_store,
    "STORAGE": _furnish_store,
    "PHARMACY": _furnish_store,
    "STORE": _furnish_store,
    "MEDIUM SERVICE": _furnish_store,
    "BIG SERVICE": _furnish_store,
    "CONVENIENCE STORE": _furnish_library,
    "CORRIDOR": _furnish_corridor,
    "HALLWAY": _furnish_corridor,
    "ENTRANCE": _furnish_corridor,
    "ENTRYWAY": _furnish_corridor,
    "OFFICE": _furnish_office,
    "SHARED OFFICE": _furnish_office,
    "EXECUTIVE OFFICE": _furnish_office,
    "CUBICULE": _furnish_office,
    "SMALL ADMINISTRATIVE": _furnish_office,
    "MEDIUM ADMINISTRATIVE": _furnish_office,
    "BIG ADMINISTRATIVE": _furnish_office,
    "SMALL": _furnish_office,
    "OPENSPACE": _furnish_open_plan,
    "CONFERENCE ROOM": _furnish_meeting_room,
    "CONFERENCE": _furnish_classroom,
    "CONFERENCE HALL": _furnish_classroom,
    "CLASSROOM": _furnish_classroom,
    "MEDIUM": _furnish_classroom,
    "LAB": _furnish_lab,
    "LIBRARY": _furnish_library,
    "WARD": _furnish_ward,
    "INTENSIVE CARE": _furnish_ward,
    "RECOVERY ROOM": _furnish_ward,
    "RECEPTION": _furnish_reception,
    "NURSE STATION": _furnish_reception,
    "LOBBY": _furnish_lobby,
    "HALL": _furnish_lobby,
    "WAITING ROOM": _furnish_lobby,
    "DAY ROOM": _furnish_lobby,
    "COLLECTIVE SERVICE ROOM": _furnish_lobby,
    "CAFETERIA": _furnish_cafeteria,
    "CANTEEN": _furnish_cafeteria,
    "GYM": _furnish_gym,
    "WAREHOUSE": _furnish_warehouse,
    "STAIRS": _leave_empty,
    "ELEVATOR": _leave_empty,
    "PASSENGER ELEVATOR": _leave_empty,
    "FREIGHT ELEVATOR": _leave_empty,
    "AERATION": _leave_empty,
}
