"""How many people are in each room: by its label and its area, unless the user says so."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
from math import isfinite
from types import MappingProxyType

from pianta.errors import BuildingWarning, OptionError
from pianta.evacuation.exits import check_rooms
from pianta.floor import Floor, Room
from pianta.labels import FCES, LabelSet, normalize_label

SQUARE_FOOT = 0.09290304  # m²
# Square feet of floor per person, from the International Building Code 2021, Table 1004.5, "maximum floor area
# allowances per occupant"; which function of that table a label belongs to was chosen by hand.
CLASSROOM = 20  # educational: classroom area, net
WORKSHOP = 50  # educational: shops and other vocational room areas, net
TABLES = 15  # assembly: unconcentrated, tables and chairs, net
CHAIRS = 7  # assembly: concentrated, chairs only, net
BUSINESS = 150  # business areas, gross
READING = 50  # library: reading rooms, net
EXERCISE = 50  # exercise rooms, gross
KITCHEN = 200  # kitchens, commercial, gross
SHOP = 60  # mercantile, gross
STORAGE = 300  # accessory storage areas, mechanical equipment room, gross
WAREHOUSE = 500  # warehouses, gross
DWELLING = 200  # residential, gross
SLEEPING = 120  # institutional areas: sleeping areas, gross
SQUARE_FEET_PER_PERSON: Mapping[str, int] = MappingProxyType(
    {
        **dict.fromkeys(("CLASSROOM", "SMALL", "MEDIUM"), CLASSROOM),
        "LAB": WORKSHOP,
        **dict.fromkeys(("CANTEEN", "CAFETERIA", "CONFERENCE", "CONFERENCE ROOM"), TABLES),
        "CONFERENCE HALL": CHAIRS,
        **dict.fromkeys(("CUBICULE", "OFFICE", "EXECUTIVE OFFICE", "SHARED OFFICE", "OPENSPACE"), BUSINESS),
        **dict.fromkeys(("SMALL ADMINISTRATIVE", "MEDIUM ADMINISTRATIVE", "BIG ADMINISTRATIVE"), BUSINESS),
        "RECEPTION": BUSINESS,
        "LIBRARY": READING,
        "GYM": EXERCISE,
        "KITCHEN": KITCHEN,
        "CONVENIENCE STORE": SHOP,
        **dict.fromkeys(("CLOSET", "MEDIUM SERVICE", "BIG SERVICE", "COLLECTIVE SERVICE ROOM"), STORAGE),
        str(FCES.SERVICE): STORAGE,
        "WAREHOUSE": WAREHOUSE,
        **dict.fromkeys(("BEDROOM", "DINING ROOM", "LIVING ROOM"), DWELLING),
        "WARD": SLEEPING,
    }
)
# Of FUNCTIONAL rooms, the rooms for which a building was built, by its type.
FUNCTIONAL_SQUARE_FEET: Mapping[str, int] = MappingProxyType({"school": CLASSROOM, "office": BUSINESS})
# People in these are counted in the rooms that they come from, as for net areas of the code.
EMPTY_LABELS = frozenset(
    (
        "CORRIDOR",
        "LOBBY",
        "HALL",
        "ENTRANCE",
        "ELEVATOR",
        "STAIRS",
        "BATHROOM",
        "TOILET",
        "WASHROOM",
        str(FCES.CONNECTION),
    )
)
# People per m² of rooms without a label, or with one that is not above: business areas, which include corridors.
DEFAULT_DENSITY = 1 / (BUSINESS * SQUARE_FOOT)
# People per m², as many as can stand (Fruin, Pedestrian Planning and Design, 1971: bodies touch at 0.14 m² each).
MAX_DENSITY = 7.0


def count_people(
    floor: Floor,
    *,
    exit_rooms: Collection[int] = (),
    people: Mapping[int, int] | None = None,
    densities: Mapping[str, float] | None = None,
    density: float | None = None,
) -> dict[int, int]:
    """People in each room by its id: its area by the density of its label, rounded; none in exit rooms.

    people: of some rooms, by id. densities: people per m² by label. density: of rooms whose label has none.
    Raises OptionError for numbers that are negative, not finite or impossible, and for a room that does not exist.
    """
    people = {} if people is None else people
    check_rooms(floor, people, "people=")
    by_label = {normalize_label(label): value for label, value in (densities or {}).items()}
    given_values = [*by_label.items(), *([] if density is None else [("all rooms", density)])]
    for what, value in given_values:
        if not (isfinite(value) and 0 <= value <= MAX_DENSITY):
            raise OptionError(f"density= is {value} for {what}, give 0 to {MAX_DENSITY:g} people per m²")
    _warn_of_labels(floor, by_label)
    counts = {}
    for room in floor.rooms:
        limit = MAX_DENSITY * room.polygon.area
        count = people.get(room.id)
        if count is not None and not 0 <= count <= max(limit, 1):
            raise OptionError(f"people= has {count} for room {room.id}, give 0 to {max(int(limit), 1)}")
        if count is None:
            per_area = _find_density(floor, room, by_label, density)
            count = 0 if room.id in exit_rooms else int(per_area * room.polygon.area + 0.5)
        counts[room.id] = count
    return counts


def _warn_of_labels(floor: Floor, by_label: Mapping[str | None, float]) -> None:
    """Warn of densities for labels that no room has: a label may be mistyped, or the floor has none of the type."""
    labels = {normalize_label(room.label) for room in floor.rooms}
    missing = [str(label) for label in by_label if label not in labels]
    if missing:
        present = ", ".join(sorted(str(label) for label in labels if label)) or "none"
        message = f"no room has the label {', '.join(missing)} of density=, the floor's labels are: {present}"
        warnings.warn(f"floor {floor.source!r}: {message}", BuildingWarning, stacklevel=4)


def _find_density(floor: Floor, room: Room, by_label: Mapping[str | None, float], density: float | None) -> float:
    """People per m² of a room of a floor: given for its label, given for all rooms, or by the code."""
    label = normalize_label(room.label)
    if label in by_label:
        return by_label[label]
    if density is not None:
        return density
    if label in EMPTY_LABELS or (label not in SQUARE_FEET_PER_PERSON and room.labels.get(LabelSet.R_C) == "CORRIDOR"):
        return 0.0
    feet = SQUARE_FEET_PER_PERSON.get(label or "")
    if label == FCES.FUNCTIONAL and floor.building_types:
        feet = FUNCTIONAL_SQUARE_FEET.get(floor.building_types[0])
    return 1 / (feet * SQUARE_FOOT) if feet else DEFAULT_DENSITY
