"""The storeys of a file, or of several maps, as one building: their order, and the stairs and lifts between them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from pianta.building import Building, Link, LinkKind, Storey
from pianta.errors import OptionError
from pianta.floor import Room
from pianta.io._files import short_repr
from pianta.io.building_folders import BUILDING_FILE, check_storey_name, save_building_file

# Labels of rooms in which people change the storey end in these words.
_KINDS: dict[str, LinkKind] = {"STAIRS": "stairs", "ELEVATOR": "lift"}
# What folders cannot have in their names on some systems, and names of other folders and of results
_UNSAFE = re.compile(r'[\x00-\x1f\x7f<>:"/\\|?*\s]+')
_RESERVED = re.compile(
    r"(?:con|prn|aux|nul|com\d|lpt\d|floor-\d+)(?:\..*)?|.*\.(?:json|geojson|png|npz)", re.IGNORECASE
)
MAX_FOLDER_NAME = 60  # characters, of at most 4 bytes each; systems take 255 bytes
# Stairs of two storeys in one frame are the same if this share of the smaller one overlaps; chosen by hand.
SAME_SHARE = 0.5
MAX_ELEVATION = 1e4  # metres, above any building


def make_building(storeys: Sequence[Storey], name: str, *, one_frame: bool) -> Building:
    """The building of the storeys of a file, the lowest first; one_frame: whether all are in one, as in an IFC."""
    ordered = sort_storeys(storeys)
    return Building(ordered, name, tuple(find_links(ordered, one_frame=one_frame)))


def sort_storeys(storeys: Sequence[Storey]) -> tuple[Storey, ...]:
    """The storeys from the lowest up; in their order if an elevation is unknown."""
    heights = {storey.name: storey.elevation for storey in storeys}
    if None in heights.values():
        return tuple(storeys)
    return tuple(sorted(storeys, key=lambda each: heights[each.name] or 0.0))


def save_storeys(storeys: Sequence[Storey], out: str | Path, links: Iterable[Link]) -> Building:
    """Write building.json beside the folders of maps that are the storeys of one building.

    links: stairs and lifts that a user names; besides, those with the same names are found.

    Raises PiantaError if links lead to rooms that do not exist.
    """
    ordered = sort_storeys(storeys)
    by_user = [*links]
    by_name = [link for link in find_links(ordered, one_frame=False) if link not in by_user]
    building = Building(ordered, Path(out).name, (*by_user, *by_name))
    save_building_file(building, Path(out) / BUILDING_FILE)
    return building


def name_folders(titles: Sequence[str]) -> list[str]:
    """The names of the folders of storeys: what people call them, else floor-1, floor-2, …; "" for the only one."""
    if len(titles) == 1:
        return [""]
    names: list[str] = []
    for number, title in enumerate(titles, start=1):
        name = _UNSAFE.sub(" ", title)[:MAX_FOLDER_NAME].strip(" .")
        names_in_use = {each.casefold() for each in names}
        is_free = name and name.casefold() not in names_in_use and not _RESERVED.fullmatch(name)
        names.append(name if is_free else f"floor-{number}")
    return names


def find_links(storeys: Sequence[Storey], *, one_frame: bool) -> Iterator[Link]:
    """Stairs and lifts of neighbouring storeys with the same name, or, in one frame, at the same position."""
    for lower, upper in pairwise(storeys):
        for room in lower.floor:
            link_kind = _kind_of(room)
            others = [other for other in upper.floor if link_kind is not None and _kind_of(other) == link_kind]
            same = [other for other in others if room.name and other.name and _is_same_name(room.name, other.name)]
            if not same and one_frame:
                same = [other for other in others if _measure_overlap(room, other) >= SAME_SHARE]
            if link_kind is not None and len(same) == 1:
                yield Link(link_kind, ((lower.name, room.id), (upper.name, same[0].id)))


def parse_storeys(texts: Sequence[str], count: int) -> list[tuple[str, float | None]]:
    """Names and elevations of as many maps, from NAME or NAME:METRES; raises OptionError."""
    if len(texts) != count:
        raise OptionError(f"{len(texts)} storeys and {count} files are given, give a storey for each file, in order")
    storeys = []
    for text in texts:
        name, colon, height = text.rpartition(":") if ":" in text else (text, "", "")
        try:
            elevation = float(height) if colon else None
        except ValueError:
            raise OptionError(f"storey {short_repr(text)} has no height in metres, give NAME:METRES") from None
        if elevation is not None and not abs(elevation) <= MAX_ELEVATION:
            raise OptionError(f"storey {short_repr(text)} has no height within ±{MAX_ELEVATION:g} m, give metres")
        check_storey_name(name)
        storeys.append((name, elevation))
    if len({name.casefold() for name, _ in storeys}) < count:
        raise OptionError(f"two storeys have one name in {', '.join(map(short_repr, texts))}, give different names")
    return storeys


def parse_links(texts: Iterable[str], link_kind: LinkKind) -> Iterator[Link]:
    """Links from "STOREY:ROOM STOREY:ROOM"; raises OptionError."""
    for text in texts:
        ends = [end.rpartition(":") for end in text.split()]
        if len(ends) != 2 or not all(name and room.isdecimal() for name, _, room in ends):
            raise OptionError(f"{link_kind} {short_repr(text)} have no two ends, give 'STOREY:ROOM STOREY:ROOM'")
        (one, _, room), (other, _, upper) = ends
        yield Link(link_kind, ((one, int(room)), (other, int(upper))))


def _kind_of(room: Room) -> LinkKind | None:
    words = (room.label or "").split()
    return _KINDS.get(words[-1]) if words else None


def _is_same_name(one: str, other: str) -> bool:
    return " ".join(one.casefold().split()) == " ".join(other.casefold().split())


def _measure_overlap(one: Room, other: Room) -> float:
    common = one.polygon.intersection(other.polygon).area
    return float(common / min(one.polygon.area, other.polygon.area))
