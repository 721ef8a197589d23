"""Synthetic homes: flats and small houses."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pianta.errors import OptionError
from pianta.floor import Floor, Room
from pianta.worlds.layouts import (
    Layout,
    LayoutError,
    Strip,
    add_oblique_corner,
    add_shaft,
    add_stub,
    round_box,
    turn_layout,
)
from pianta.worlds.wall_axes import Range, Seed

# The measures are usual ones of European homes (chosen by hand).
# Smallest and largest home between the axes of its walls; m².
HOME_AREA = (30.0, 160.0)
# Shares of homes with rooms along a corridor, with rooms around the living room, and with rooms that lead to rooms.
STYLE_SHARES = (0.5, 0.25, 0.25)
# Least areas of homes, m², and the rooms that they have.
PROGRAMS: tuple[tuple[float, tuple[str, ...]], ...] = (
    (0, ("LIVING ROOM", "KITCHEN", "BATHROOM")),
    (38, ("LIVING ROOM", "KITCHEN", "BEDROOM", "BATHROOM")),
    (58, ("LIVING ROOM", "KITCHEN", "BEDROOM", "BEDROOM", "BATHROOM")),
    (78, ("LIVING ROOM", "KITCHEN", "BEDROOM", "BEDROOM", "BATHROOM", "TOILET")),
    (98, ("LIVING ROOM", "KITCHEN", "BEDROOM", "BEDROOM", "BEDROOM", "BATHROOM", "TOILET")),
    (120, ("LIVING ROOM", "KITCHEN", "DINING ROOM", "BEDROOM", "BEDROOM", "BEDROOM", "BATHROOM", "TOILET")),
)
# Smallest and largest room of each label, before it is fitted to the home; m².
ROOM_AREAS: dict[str, Range] = {
    "LIVING ROOM": (14, 34),
    "KITCHEN": (6, 14),
    "DINING ROOM": (8, 16),
    "BEDROOM": (8, 17),
    "OFFICE": (6, 12),
    "BATHROOM": (3.2, 6),
}
# Smallest and largest room that a home may have in the end, without walls; m².
ROOM_LIMITS: dict[str, Range] = {
    "TOILET": (0.8, 3.5),
    "CLOSET": (0.5, 4),
    "BATHROOM": (2.2, 9),
    "CORRIDOR": (1.5, 20),
    "LIVING ROOM": (10, 60),
    "KITCHEN": (4, 28),
    "DINING ROOM": (6, 28),
    "BEDROOM": (5.5, 28),
    "OFFICE": (4.5, 25),
}
# Longest shape of a room: its longer side, in shorter sides; other rooms at most 2.8.
LONGEST_SHAPE: dict[str, float] = {"CORRIDOR": 20}
# Rooms that are cut out of a corner of another one: their sides along and across the passage; metres.
SMALL_ROOMS: dict[str, tuple[Range, Range]] = {
    "TOILET": ((1.0, 1.3), (1.4, 1.9)),
    "CLOSET": ((1.0, 1.6), (0.85, 1.4)),
    "BATHROOM": ((1.7, 2.3), (1.9, 2.6)),
    "NICHE": ((1.0, 1.8), (0.6, 1.6)),
}
# Share of the corners at the passage out of which one of them is cut.
CORNER_SHARE = 0.4
# Width of doors of rooms; metres.
DOOR_WIDTH = (0.7, 0.9)
# Width of sliding doors and double doors; metres.
SLIDING_WIDTH = (1.2, 2.0)
# Width of the opening between kitchen and living room; metres.
OPENING_WIDTH = (1.5, 3.5)
# Narrowest passage wall that a room keeps when small rooms are cut out of its corners; metres.
MIN_FRONT = 1.1
# Share of the homes with an oblique corner.
OBLIQUE_SHARE = 0.1
# Layouts that are drawn until one can be built.
ATTEMPTS = 300


def make_home_floor(*, seed: Seed = 0, area: float | None = None) -> Floor:
    """Floor of a home: rooms along a corridor, around the living room, or leading to each other.

    The kitchen often is open to the living room; small rooms are cut out of corners, so that others are L-shaped.
    area: between the outer walls' axes, roughly, m²; drawn from HOME_AREA unless given.
    Raises OptionError when the area is not 25 … 180 m².
    """
    if area is not None and not 25 <= area <= 180:
        raise OptionError(f"area is {area}, give 25 … 180 m²")
    rng = np.random.default_rng(seed)
    size = float(rng.uniform(*HOME_AREA)) if area is None else area
    for _ in range(ATTEMPTS):
        style = rng.choice(3, p=STYLE_SHARES)
        try:
            layout = (
                _draw_strip_home(size, rng, with_corridor=style == 0) if style < 2 else _draw_nested_home(size, rng)
            )
            _add_details(layout)
            turn_layout(layout)
            floor = layout.build("home")
        except LayoutError:
            continue
        if all(_is_usable(room) for room in floor.rooms):
            return floor
    raise OptionError(f"no home of {area} m² could be drawn, give another area or seed")


def _is_usable(room: Room) -> bool:
    """Whether a room has a size and proportions that occur."""
    least, most = ROOM_LIMITS.get(room.label or "", ROOM_LIMITS["LIVING ROOM"])
    x0, y0, x1, y1 = room.polygon.bounds
    short, long = sorted((x1 - x0, y1 - y0))
    return bool(least <= room.polygon.area <= most and long <= LONGEST_SHAPE.get(room.label or "", 2.8) * short)


def _draw_program(area: float, rng: np.random.Generator) -> dict[str, list[float]]:
    """Label -> areas of its rooms, m², that fill the area; small rooms that are cut out are not in it."""
    labels = list(max((program for program in PROGRAMS if program[0] <= area), key=lambda program: program[0])[1])
    if rng.random() < 0.3 and labels.count("BEDROOM") > 1:
        labels[labels.index("BEDROOM")] = "OFFICE"
    if rng.random() < 0.25 and labels.count("BEDROOM") + labels.count("OFFICE") > 1:
        labels.remove("BEDROOM")
    areas: dict[str, list[float]] = {}
    for label in labels:
        if label in ROOM_AREAS:
            areas.setdefault(label, []).append(float(rng.uniform(*ROOM_AREAS[label])))
    service = sum(areas["BATHROOM"])
    scale = (area - service) / (sum(map(sum, areas.values())) - service)
    return {
        label: values if label == "BATHROOM" else [value * scale for value in values] for label, values in areas.items()
    }


@dataclass
class _Columns:
    """Rooms along one side of a passage: label and width, metres, in order."""

    depth: float
    rooms: list[tuple[str, float]] = field(default_factory=list)

    @property
    def length(self) -> float:
        return sum(width for _, width in self.rooms)


def _draw_strip_home(area: float, rng: np.random.Generator, *, with_corridor: bool) -> Layout:
    """Rooms on both sides of a corridor, or of the living room, along x."""
    layout = _new_layout(rng)
    program = _draw_program(area * (0.9 if with_corridor else 1.0), rng)
    living = program.pop("LIVING ROOM")[0]
    width = round(float(rng.uniform(1.0, 1.5)), 2)
    at_end = with_corridor and rng.random() < 0.5
    sides = [_Columns(float(depth)) for depth in rng.uniform(2.8, 4.6 if area > 50 else 3.6, 2)]
    if with_corridor and not at_end:
        sides[0].rooms.append(("LIVING ROOM", living / sides[0].depth))
    kitchen_side = 0 if rng.random() < 0.7 else 1
    sides[kitchen_side].rooms.append(("KITCHEN", program.pop("KITCHEN")[0] / sides[kitchen_side].depth))
    rest = [(label, size) for label, sizes in program.items() for size in sizes]
    for index in rng.permutation(len(rest)):
        label, size = rest[index]
        side = min(sides, key=lambda columns: columns.length)
        side.rooms.append((label, max(size / side.depth, 1.6 if label == "BATHROOM" else 2.2)))
    length = max(side.length for side in sides)
    if not with_corridor:
        # A living room of its area, as long as the rooms beside it.
        width = round(float(np.clip(living / length, 3.0, 5.5)), 2)
    hub = layout.add(round_box(0, 0, length, width), "CORRIDOR" if with_corridor else "LIVING ROOM")
    strips = [
        Strip((0, 0), (1, 0), (0, -1), length, sides[0].depth),
        Strip((0, width), (1, 0), (0, 1), length, sides[1].depth),
    ]
    for strip, side in zip(strips, sides, strict=True):
        _fill_side(layout, strip, side, hub)
    if at_end:
        depths = [side.depth for side in sides]
        end = max(living / (sum(depths) + width), 2.9)
        space = layout.add(round_box(-end, -depths[0], 0, width + depths[1]), "LIVING ROOM")
        layout.join(space, [hub], DOOR_WIDTH)
    _trim_hub(layout, hub, strips, sides, length) if with_corridor else None
    _join_kitchen(layout)
    return layout


def _fill_side(layout: Layout, strip: Strip, side: _Columns, hub: int) -> None:
    """Add the rooms of one side, with small rooms cut out of their corners at the passage, and bays outside."""
    rng, start = layout.rng, 0.0
    for label, width in side.rooms:
        stop = start + width
        bay = strip.depth + (rng.uniform(0.3, 1.2) if rng.random() < 0.15 else 0)
        space = layout.add(strip.box(start, stop, 0, strip.depth), label)
        if bay > strip.depth and width > 2.5:
            cut = rng.uniform(0.3, 0.8)
            layout.spaces[space] = layout.spaces[space].union(strip.box(start + cut, stop - cut, strip.depth, bay))
        layout.join(space, [hub], DOOR_WIDTH if label != "LIVING ROOM" or rng.random() < 0.6 else SLIDING_WIDTH)
        if label in ("BEDROOM", "OFFICE", "KITCHEN") and width > 2.4:
            _cut_corners(layout, strip, space, hub, (start, stop))
        start = stop


def _cut_corners(layout: Layout, strip: Strip, space: int, hub: int, ends: Range) -> None:
    """Perhaps cut toilets, closets, bathrooms or niches of the passage out of corners of a room."""
    rng, (start, stop) = layout.rng, ends
    for at_start in rng.permutation([True, False]):
        if rng.random() > CORNER_SHARE:
            continue
        label = str(rng.choice(["TOILET", "TOILET", "CLOSET", "CLOSET", "BATHROOM", "NICHE"]))
        along, across = SMALL_ROOMS[label]
        width, depth = round(rng.uniform(*along), 2), rng.uniform(*across)
        if stop - start - width < MIN_FRONT or strip.depth - depth < 1.2:
            continue
        part = strip.box(start, start + width, 0, depth) if at_start else strip.box(stop - width, stop, 0, depth)
        if at_start:
            start += width
        else:
            stop -= width
        if label == "NICHE":
            layout.move(part, space, hub)
            continue
        own = label != "TOILET" and rng.random() < 0.4
        layout.join(layout.carve(space, part, label), [space if own else hub], (0.65, 0.8))


def _trim_hub(layout: Layout, hub: int, strips: list[Strip], sides: list[_Columns], length: float) -> None:
    """Perhaps end the corridor where its last doors are; the last room of a side gets the rest."""
    rng = layout.rng
    lasts = [sum(width for _, width in side.rooms[:-1]) for side in sides]
    end = max(lasts) + MIN_FRONT + 0.2
    if length - end < 0.8 or rng.random() < 0.3:
        return
    longest = int(np.argmax([side.length for side in sides]))
    number = [index for index, space in enumerate(layout.spaces) if index != hub]
    corner = strips[longest].box(end, length, 0, 0.1)
    owner = next((index for index in number if layout.spaces[index].contains(corner.centroid)), None)
    if owner is not None:
        layout.move(round_box(end, 0, layout.spaces[hub].bounds[2], strips[1].origin[1]), hub, owner)


def _join_kitchen(layout: Layout) -> None:
    """Join the kitchen to the living room and the dining room to both, where they share walls."""
    rng = layout.rng
    living, kitchen = layout.labels.index("LIVING ROOM"), layout.labels.index("KITCHEN")
    draw = rng.random()
    if draw < 0.55:
        layout.join(kitchen, [living], OPENING_WIDTH, door_kind="opening", optional=True)
    elif draw < 0.75:
        layout.join(kitchen, [living], SLIDING_WIDTH, optional=True)
    if "DINING ROOM" in layout.labels:
        dining = layout.labels.index("DINING ROOM")
        for other in (living, kitchen):
            if rng.random() < 0.5:
                layout.join(dining, [other], OPENING_WIDTH, door_kind="opening", optional=True)
            else:
                layout.join(dining, [other], SLIDING_WIDTH, optional=True)


def _draw_nested_home(area: float, rng: np.random.Generator) -> Layout:
    """Rooms from cutting a rectangle, or the two or three of an L or T, again and again, joined by a tree of doors."""
    layout = _new_layout(rng)
    program = _draw_program(area, rng)
    rooms = [(label, size) for label, sizes in program.items() for size in sizes]
    if area > 55 and rng.random() < 0.7:
        rooms.append(("CORRIDOR", float(rng.uniform(4, 9))))
    if "TOILET" not in program and area > 75:
        rooms.append(("TOILET", float(rng.uniform(1.6, 2.6))))
    rooms = [rooms[index] for index in rng.permutation(len(rooms))]
    parts = _draw_footprint(rooms, rng)
    for bounds, members in parts:
        _split_box(layout, bounds, members)
    _join_tree(layout)
    return layout


Bounds = tuple[float, float, float, float]
Members = list[tuple[str, float]]


def _draw_footprint(rooms: Members, rng: np.random.Generator) -> list[tuple[Bounds, Members]]:
    """One to three boxes that meet, and the rooms in each."""
    shape = int(rng.choice(3, p=(0.4, 0.4, 0.2))) if len(rooms) > 4 else 0
    total = sum(size for _, size in rooms)
    # The wings get a room or two each.
    groups = [rooms[shape * 1 :]] + [[room] for room in rooms[:shape]]
    size = sum(value for _, value in groups[0])
    width = (size * rng.uniform(1.0, 1.8)) ** 0.5
    depth = size / width
    boxes: list[tuple[Bounds, Members]] = [((0, 0, width, depth), groups[0])]
    for number, group in enumerate(groups[1:]):
        wing = sum(value for _, value in group)
        reach = float(np.clip(wing**0.5 * rng.uniform(0.7, 1.2), 0.9, depth))
        start = 0 if rng.random() < 0.5 else (width - wing / reach) * rng.random()
        if wing / reach > width or total <= 0:
            raise LayoutError("a wing is too wide")
        x0 = round(start, 2)
        y = (depth, depth + reach) if number == 0 else (-reach, 0)
        boxes.append(((x0, y[0], x0 + wing / reach, y[1]), group))
    return boxes


def _split_box(layout: Layout, bounds: Bounds, members: Members) -> None:
    """Cut a box into the spaces of its members, in proportion to their areas."""
    x0, y0, x1, y1 = bounds
    if len(members) == 1:
        if min(x1 - x0, y1 - y0) < 0.95 or max(x1 - x0, y1 - y0) > 3.2 * min(x1 - x0, y1 - y0):
            raise LayoutError("a room is too narrow")
        layout.add(round_box(*bounds), members[0][0])
        return
    middle = int(layout.rng.integers(1, len(members)))
    share = sum(size for _, size in members[:middle]) / sum(size for _, size in members)
    if (x1 - x0 > y1 - y0) == (layout.rng.random() < 0.85):
        cut = round(x0 + share * (x1 - x0), 2)
        halves = (x0, y0, cut, y1), (cut, y0, x1, y1)
    else:
        cut = round(y0 + share * (y1 - y0), 2)
        halves = (x0, y0, x1, cut), (x0, cut, x1, y1)
    _split_box(layout, halves[0], members[:middle])
    _split_box(layout, halves[1], members[middle:])


def _join_tree(layout: Layout) -> None:
    """Doors that lead from the corridor, or else the living room, to all rooms, through as few others as they can."""
    from pianta.worlds.wall_axes import find_shared_wall

    count, rng = len(layout.spaces), layout.rng
    hubs = [label for label in ("CORRIDOR", "LIVING ROOM") if label in layout.labels]
    reached = [layout.labels.index(hubs[0])]
    while len(reached) < count:
        options = []
        for room in set(range(count)) - set(reached):
            for order, other in enumerate(reached):
                if find_shared_wall(layout.spaces[room], layout.spaces[other]).length >= MIN_FRONT:
                    cost = order + (9 if layout.labels[other] in ("BATHROOM", "TOILET") else 0)
                    cost += 4 if layout.labels[other] in ("BEDROOM", "OFFICE") else 0
                    options.append((cost, room, other))
        if not options:
            raise LayoutError("a room is cut off")
        cost, room, other = min(options)
        if cost >= 9:
            raise LayoutError("a room is behind a bathroom")
        reached.append(room)
        pair = {layout.labels[room], layout.labels[other]}
        wide = "LIVING ROOM" in pair and not pair & {"BATHROOM", "TOILET", "BEDROOM"} and rng.random() < 0.5
        if pair == {"LIVING ROOM", "KITCHEN"} and rng.random() < 0.6:
            layout.join(room, [other], OPENING_WIDTH, door_kind="opening")
        else:
            layout.join(room, [other], SLIDING_WIDTH if wide else DOOR_WIDTH)


def _new_layout(rng: np.random.Generator) -> Layout:
    return Layout(rng, inner_wall=float(rng.choice([0.08, 0.1, 0.12, 0.15, 0.2])), outer_wall=0.3)


def _add_details(layout: Layout) -> None:
    """Add shafts, stubs of walls in the larger rooms, and perhaps an oblique corner."""
    rng = layout.rng
    if rng.random() < OBLIQUE_SHARE:
        add_oblique_corner(layout, rng.uniform(0.8, 2.5))
    for number, label in enumerate(layout.labels):
        if label in ("BATHROOM", "KITCHEN", "BEDROOM") and rng.random() < 0.2:
            add_shaft(layout, number, float(rng.uniform(0.25, 0.55)))
        if label in ("LIVING ROOM", "DINING ROOM", "KITCHEN") and rng.random() < 0.25:
            add_stub(layout, number, float(rng.uniform(0.3, 0.9)))
