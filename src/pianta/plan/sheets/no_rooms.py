"""False rooms that are no part of the building: boxes of text that touch it, small plans beside it, open spaces.

Boxes that stand apart are erased before walls are looked for, so that they make none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import Polygon

from pianta.floor import OUTSIDE_FLAG, Floor, Room
from pianta.plan.sheets.boxes import SITE_PLAN, count_words, name_box, share_in_columns
from pianta.plan.sheets.parts import SheetParts
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.legend import find_legend
from pianta.plan.text.storey_titles import parse_level


@dataclass(frozen=True, kw_only=True)
class NoRoomParameters:
    """Thresholds of `leave_out`.

    Chosen on the plans of `floorplans` and `planfiles`, and on drawn sheets with such boxes. Of the rooms that are true
    there, none without a door has more than 8 words; boxes have 15 and more.
    """

    # A box of text that touches the building
    lines: int = 5
    words: int = 12
    text_cover: float = 0.3  # of its area that is text
    listed_share: float = 0.6  # of its lines that are in columns
    # A site plan or key plan without a title
    site_size: float = 0.4  # of the area of the building, at most
    small_room: float = 1 / 6  # of the median area of the rooms of the building
    least_rooms: int = 4
    max_texts: int = 2
    max_doors: float = 0.5  # doors a room: its small rectangles may be taken for doors
    drawn_doors: int = 3  # of the building, so that a part without one is no building
    # What the layout method adds beside a building: rooms that no lines enclose
    enclosed: float = 0.9  # of a room that lies within lines
    enclosed_rooms: float = 0.85  # of the rooms that do, if the lines of the building are closed
    open_room: float = 0.5  # of a room that lies within lines, at most


PARAMETERS = NoRoomParameters()


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A room of a floor, in pixels with y up.

    part: the number of its part. enclosed: share that lies within lines. texts: those in it. text_area: square pixels.
    doors: drawn ones.
    """

    floor: int
    room: Room
    part: int
    enclosed: float
    texts: tuple[PlacedText, ...]
    text_area: float
    doors: int

    @property
    def area(self) -> float:
        return float(self.room.polygon.area)


def leave_out(
    floors: Sequence[Floor], parts: SheetParts, texts: Sequence[PlacedText], *, height: int
) -> tuple[list[Floor], list[str]]:
    """The floors without what is certainly no room, and what was left out, as kinds of `boxes`.

    Rooms that no lines enclose, beside a building whose other rooms are enclosed, get the flag "outside". A sheet on
    which nothing else is drawn keeps all.
    floors: in pixels of the sheet, y up. height: of the sheet, pixels.
    """
    candidates = list(_list_candidates(floors, parts, texts, height))
    left_out = _find_left_out(candidates, texts)
    rooms = {key for _, keys in left_out for key in keys}
    remaining_rooms = [each for each in candidates if _key(each) not in rooms]
    if not remaining_rooms:
        return list(floors), []
    outside = {_key(each) for each in _list_open(remaining_rooms)}
    remaining = (_change(floor, number, rooms, outside) for number, floor in enumerate(floors))
    return [floor for floor in remaining if floor is not None], [name for name, _ in left_out]


def _key(candidate: _Candidate) -> tuple[int, int]:
    return candidate.floor, candidate.room.id


def _list_candidates(
    floors: Sequence[Floor], parts: SheetParts, texts: Sequence[PlacedText], height: int
) -> Iterator[_Candidate]:
    """All rooms of the floors with what is drawn and written in them."""
    boxes = [_box_of(text, height) for text in texts]
    tree = shapely.STRtree(boxes)
    for number, floor in enumerate(floors):
        for room in floor:
            touching = sorted(tree.query(room.polygon, predicate="intersects").tolist())
            shares = [boxes[index].intersection(room.polygon).area for index in touching]
            inside = [
                (index, share) for index, share in zip(touching, shares, strict=True) if share > boxes[index].area / 2
            ]
            part, enclosed = _part_of(room.polygon, parts, height)
            yield _Candidate(
                number,
                room,
                part,
                enclosed,
                tuple(texts[index] for index, _ in inside),
                sum(share for _, share in inside),
                sum(door.kind == "door" and room.id in door.room_ids for door in floor.doors),
            )


def _box_of(text: PlacedText, height: int) -> Polygon:
    """The convex hull of the corners of a text, y up."""
    hull = shapely.MultiPoint([(col, height - row) for row, col in text.corners]).convex_hull
    return hull if isinstance(hull, Polygon) else Polygon()


def _part_of(polygon: Polygon, parts: SheetParts, height: int) -> tuple[int, float]:
    """The number of the part in which most of a room lies, 0 for none, and the share of it that lies in any part."""
    left, bottom, right, top = polygon.bounds
    rows, cols = parts.numbers.shape
    y, x = np.mgrid[
        max(0, int((height - top) / parts.cell_px)) : min(rows, int((height - bottom) / parts.cell_px) + 1),
        max(0, int(left / parts.cell_px)) : min(cols, int(right / parts.cell_px) + 1),
    ]
    inside = shapely.contains_xy(polygon, (x + 0.5) * parts.cell_px, height - (y + 0.5) * parts.cell_px)
    numbers = parts.numbers[y[inside], x[inside]]
    if not numbers.size:
        return 0, 1.0
    inked = numbers[numbers > 0]
    return int(np.bincount(inked).argmax()) if inked.size else 0, inked.size / numbers.size


def _find_left_out(
    candidates: Sequence[_Candidate], texts: Sequence[PlacedText]
) -> list[tuple[str, set[tuple[int, int]]]]:
    """What is no room, as its kind and its rooms."""
    by_part: dict[int, list[_Candidate]] = {}
    for candidate in candidates:
        by_part.setdefault(candidate.part, []).append(candidate)
    legend = find_legend(texts).texts
    building = max(by_part.values(), key=lambda rooms: (_sum_doors(rooms), _sum_areas(rooms)), default=[])
    no_rooms = []
    for rooms in by_part.values():
        if rooms is not building and _is_small_plan(rooms, building):
            no_rooms.append((SITE_PLAN, {_key(room) for room in rooms}))
        else:
            no_rooms += [(name_box(room.texts, legend), {_key(room)}) for room in rooms if _is_touching_box(room)]
    return no_rooms


def _sum_doors(rooms: Sequence[_Candidate]) -> int:
    return sum(room.doors for room in rooms)


def _sum_areas(rooms: Sequence[_Candidate]) -> float:
    return sum(room.area for room in rooms)


def _is_touching_box(room: _Candidate) -> bool:
    """Whether a room of a building is a box of text."""
    p = PARAMETERS
    is_list = len(room.texts) >= p.lines and count_words(room.texts) >= p.words
    is_list = is_list and share_in_columns(room.texts) >= p.listed_share
    return is_list and not room.doors and room.text_area >= p.text_cover * room.area


def _is_small_plan(rooms: Sequence[_Candidate], building: Sequence[_Candidate]) -> bool:
    """Whether a part is a site plan or key plan, since its rooms are far too small."""
    p = PARAMETERS
    small = p.small_room * float(np.median([room.area for room in building]))
    return (
        _sum_areas(rooms) <= p.site_size * _sum_areas(building)
        and len(rooms) >= p.least_rooms
        and float(np.median([room.area for room in rooms])) <= small
        and sum(len(room.texts) for room in rooms) <= p.max_texts
        and _sum_doors(rooms) <= p.max_doors * len(rooms)
        and _sum_doors(building) >= p.drawn_doors
    )


def _list_open(rooms: Sequence[_Candidate]) -> list[_Candidate]:
    """Rooms without name and door that no lines enclose, where nearly all others are enclosed."""
    p = PARAMETERS
    if np.mean([room.enclosed >= p.enclosed for room in rooms]) < p.enclosed_rooms:
        return []
    open_rooms = (room for room in rooms if room.enclosed <= p.open_room and not room.doors)
    # The title of a storey stands outside
    return [room for room in open_rooms if all(parse_level(text.text) is not None for text in room.texts)]


def _change(floor: Floor, number: int, dropped: set[tuple[int, int]], outside: set[tuple[int, int]]) -> Floor | None:
    """The floor without some rooms, and with the flag "outside" for others; None if no room is left."""
    remaining_rooms = [room for room in floor if (number, room.id) not in dropped]
    if not remaining_rooms:
        return None
    flagged = [replace(room, flag=OUTSIDE_FLAG) if (number, room.id) in outside else room for room in remaining_rooms]
    if len(remaining_rooms) == len(floor):
        return replace(floor, rooms=tuple(flagged)) if any(room.flag for room in flagged) else floor
    new_ids = {room.id: index for index, room in enumerate(remaining_rooms, start=1)}
    doors = tuple(door.renumber_rooms(new_ids) for door in floor.doors if new_ids.keys() >= set(door.room_ids))
    rooms = tuple(replace(room, id=new_ids[room.id]) for room in flagged)
    return replace(floor, rooms=rooms, doors=doors, last_id=0)
