"""Evidence of the scale from rooms: the areas and sizes that are written in them, their names, and how large they look.

Standard deviations are of the logarithm of a length. Those without a source are estimates, chosen by hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log, sqrt

import numpy as np

from pianta.io._files import count_noun
from pianta.plan.scale.evidence import Measure, ScaleEvidence
from pianta.plan.scale.known_rooms import KnownRoom, find_known_rooms
from pianta.plan.scale.spaces import Space
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.areas import WrittenArea, parse_areas, states_total
from pianta.plan.text.sizes import parse_possible_sizes


@dataclass(frozen=True, kw_only=True)
class RoomEvidenceParameters:
    """Errors of the evidence from rooms."""

    # Written areas and sizes, against the floor of the room: rooms that were cut or joined are outliers
    room_sd: float = 0.05
    written_common_sd: float = 0.025  # the walls' faces are found within a cell
    cut_room_sd: float = 0.25
    written_outlier_rate: float = 0.4
    written_failure_rate: float = 0.05  # furniture or dimension lines can cut all rooms of a sheet
    max_side_disagreement: float = 0.7  # of the logarithm: above, the sides of a size are not those of the room
    # A total, against all rooms together: with or without walls and balconies, of one floor or of several
    total_sd: float = 0.12
    total_outlier_rate: float = 0.3
    rooms_of_total: float = 0.93  # of a total is floor of rooms, the rest walls
    # Names: dwellings are large or small as a whole
    names_common_sd: float = 0.1
    names_outlier_rate: float = 0.12
    names_failure_rate: float = 0.05
    # The look: the floor on which a random spot of all rooms lies, m², and the error of a length by it
    home_area: float = 16.0
    home_sd: float = 0.27
    other_area: float = 45.0
    other_sd: float = 0.45
    room_look_outlier_rate: float = 0.1
    home_rooms: float = 16.0  # rooms of a sheet that is as likely a home as anything else
    home_rooms_spread: float = 10.0  # of the logistic function of their number


PARAMETERS = RoomEvidenceParameters()


def list_room_evidence(spaces: Sequence[Space], texts: Sequence[PlacedText]) -> list[ScaleEvidence]:
    """The evidence of a sheet by its rooms. texts: all of the sheet."""
    by_kind = (_by_areas(spaces), _by_sizes(spaces), _by_total(spaces, texts), _by_names(spaces, texts))
    return [each for each in by_kind if each is not None]


def home_probability(spaces: Sequence[Space], texts: Sequence[PlacedText]) -> float:
    """How likely a sheet shows a home, by the names of rooms on it, or else by their number; 0 … 1."""
    kinds = _list_home_names(texts)
    if kinds:
        return (sum(kinds) + 0.1) / (len(kinds) + 0.2)
    p = PARAMETERS
    return 1 / (1 + float(np.exp((len(spaces) - p.home_rooms) / p.home_rooms_spread)))


def _list_home_names(texts: Sequence[PlacedText]) -> list[bool]:
    """For each name of a room that occurs in homes alone or elsewhere alone, whether it is of a home."""
    rooms = (room for text in texts for room in find_known_rooms(text.text))
    return [room.in_home for room in rooms if room.in_home is not None]


def _by_areas(spaces: Sequence[Space]) -> ScaleEvidence | None:
    """The areas that are written in rooms; several in one room, which are of open parts of it, add up."""
    measures: list[Measure] = []
    for space in spaces:
        areas = [area for text in space.texts if not states_total(text.text) and (area := _first_area(text))]
        if areas:
            total, step = sum(area.area for area in areas), max(area.step for area in areas)
            measures.append(Measure((sqrt(total / space.area),), _rounded_sd(step / total), PARAMETERS.cut_room_sd))
    return _written(measures, f"areas written in {count_noun(len(measures), 'room')}")


def _by_sizes(spaces: Sequence[Space]) -> ScaleEvidence | None:
    measures: list[Measure] = []
    for space in spaces:
        for text in space.texts:
            ratios = [
                (first / width, second / height)
                for first, second in parse_possible_sizes(text.text)
                for width, height in ((space.width, space.height), (space.height, space.width))
            ]
            measures += _fit_sizes(ratios)
    rooms = sum(any(parse_possible_sizes(text.text) for text in space.texts) for space in spaces)
    return _written(measures, f"sizes written in {count_noun(rooms, 'room')}")


def _fit_sizes(ratios: Sequence[tuple[float, float]]) -> Iterator[Measure]:
    """Metres per pixel by the ways to read a size, unless its sides are not those of the room in any of them."""
    off = [abs(log(first / second)) for first, second in ratios]
    close = [ratio for ratio, each in zip(ratios, off, strict=True) if each <= min(off) + PARAMETERS.room_sd]
    if close and min(off) <= PARAMETERS.max_side_disagreement:
        sd = sqrt(PARAMETERS.room_sd**2 + (min(off) / 2) ** 2)
        yield Measure(tuple(sqrt(first * second) for first, second in close), sd, PARAMETERS.cut_room_sd)


def _written(measures: Sequence[Measure], text: str) -> ScaleEvidence | None:
    p = PARAMETERS
    if not measures:
        return None
    return ScaleEvidence(text, tuple(measures), p.written_common_sd, p.written_outlier_rate, p.written_failure_rate)


def _by_total(spaces: Sequence[Space], texts: Sequence[PlacedText]) -> ScaleEvidence | None:
    """An area outside of all rooms, or with a word such as total, is that of all rooms and the walls between them."""
    p, inside = PARAMETERS, {id(text) for space in spaces for text in space.texts}
    totals = [
        area for text in texts if (area := _first_area(text)) and (id(text) not in inside or states_total(text.text))
    ]
    floor = sum(space.area for space in spaces)
    if not totals or not floor:
        return None
    # The largest is that of the whole, if several are stated
    largest = max(area.area for area in totals)
    measure = Measure((sqrt(largest * p.rooms_of_total / floor),), p.total_sd)
    return ScaleEvidence("the total area", (measure,), 0.0, p.total_outlier_rate, 0.0)


def _by_names(spaces: Sequence[Space], texts: Sequence[PlacedText]) -> ScaleEvidence | None:
    """The usual areas of rooms with these names; those of one room with several names add up."""
    p, measures = PARAMETERS, list[Measure]()
    names = _list_home_names(texts)
    in_home = 2 * sum(names) >= len(names) > 0
    for space in spaces:
        # What is WC or study in homes has other sizes elsewhere
        rooms = [room for room in _known_rooms(space) if in_home == (room.in_home is not False)]
        if rooms:
            area, sd = sum(room.area for room in rooms), max(room.log_sd for room in rooms)
            measures.append(Measure((sqrt(area / space.area),), sd / 2))
    if not measures:
        return None
    text = f"the names of {count_noun(len(measures), 'room')}"
    return ScaleEvidence(text, tuple(measures), p.names_common_sd, p.names_outlier_rate, p.names_failure_rate)


def by_look(spaces: Sequence[Space], at_home: float) -> ScaleEvidence | None:
    """How large the rooms of homes, and those of other buildings, usually are.

    at_home: probability that the sheet shows a home.
    """
    areas = np.sort([space.area for space in spaces])
    if not len(areas):
        return None
    p, reached = PARAMETERS, np.cumsum(areas)
    middle = float(areas[int(np.searchsorted(reached, reached[-1] / 2))])
    area = p.home_area**at_home * p.other_area ** (1 - at_home)
    # Between the two kinds of buildings the error of taking one for the other adds up
    between = at_home * (1 - at_home) * (log(p.other_area / p.home_area) / 2) ** 2
    sd = sqrt(at_home * p.home_sd**2 + (1 - at_home) * p.other_sd**2 + between)
    measure = Measure((sqrt(area / middle),), sd)
    return ScaleEvidence("the sizes of rooms", (measure,), 0.0, p.room_look_outlier_rate, 0.0, is_look=True)


def _known_rooms(space: Space) -> tuple[KnownRoom, ...]:
    joined = " ".join(text.text for text in space.texts)
    named = find_known_rooms(joined) or tuple(room for text in space.texts for room in find_known_rooms(text.text))
    return tuple(dict.fromkeys(named))


def _first_area(text: PlacedText) -> WrittenArea | None:
    return next(iter(parse_areas(text.text)), None)


def _rounded_sd(share: float) -> float:
    """The error of a room's length by an area that is rounded to a share of itself."""
    return sqrt(PARAMETERS.room_sd**2 + (share / sqrt(12) / 2) ** 2)
