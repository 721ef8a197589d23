"""The schemas that pianta has: school and office of the thesis (Fig. 4.5), house and hospital.

The tables are in docs/methods/labels.md. The thesis has no schemas of houses and hospitals: these are ours. A house has
the labels of HouseExpo, and those of the homes that pianta makes; a hospital has the rooms that manuals of architecture
list for wards, operating departments, outpatients and supply.
"""

from __future__ import annotations

from types import MappingProxyType

from pianta.errors import LabelError
from pianta.labels._hierarchy import FCES, GeneralLabel, Label, LabelSchema

_F, _C, _E, _S = FCES

SCHOOL = LabelSchema(
    "school",
    (
        Label("CLASSROOM", _F, GeneralLabel.MEDIUM, "#1bddf2"),
        Label("SMALL", _F, GeneralLabel.SMALL, "#3fbf04"),
        Label("MEDIUM", _F, GeneralLabel.MEDIUM, "#2a90f2"),
        Label("LAB", _F, GeneralLabel.BIG, "#2267f2"),
        Label("SMALL ADMINISTRATIVE", _S, GeneralLabel.SMALL, "#beb94e"),
        Label("MEDIUM ADMINISTRATIVE", _S, GeneralLabel.MEDIUM, "#beb615"),
        Label("BIG ADMINISTRATIVE", _S, GeneralLabel.BIG, "#716d0d"),
        Label("GYM", _S, GeneralLabel.BIG, "#a81e1e", in_experiments=_F),
        Label("KITCHEN", _S, GeneralLabel.BIG, "#b27abe"),
        Label("CLOSET", _S, GeneralLabel.SMALL, "#bdbdbd"),
        Label("CONFERENCE", _S, GeneralLabel.BIG, "#a81e1e", in_experiments=_F),
        Label("MEDIUM SERVICE", _S, GeneralLabel.MEDIUM, "#8c8c8b"),
        Label("BIG SERVICE", _S, GeneralLabel.BIG, "#585859"),
        Label("LIBRARY", _S, GeneralLabel.BIG, "#3c3c3c"),
        Label("BATHROOM", _S, GeneralLabel.SMALL, "#fff87d"),
        Label("WASHROOM", _S, GeneralLabel.SMALL, "#e8caa7"),
        Label("CANTEEN", _S, GeneralLabel.BIG, "#282828"),
        Label("CORRIDOR", _C, GeneralLabel.CORRIDOR, "#f28705"),
        Label("LOBBY", _C, GeneralLabel.HALL, "#f24738"),
        Label("HALL", _C, GeneralLabel.HALL, "#bf5719"),
        Label("ENTRANCE", _E, GeneralLabel.SMALL, "#268080", corridor_in_graphs=True),
        Label("ELEVATOR", _E, GeneralLabel.SMALL, "#147171"),
        Label("STAIRS", _E, GeneralLabel.SMALL, "#5bbebe"),
    ),
)

OFFICE = LabelSchema(
    "office",
    (
        Label("CUBICULE", _F, GeneralLabel.SMALL, "#2e7880"),
        Label("CONFERENCE ROOM", _F, GeneralLabel.MEDIUM, "#3fbf04"),
        Label("EXECUTIVE OFFICE", _F, GeneralLabel.BIG, "#324872"),
        Label("OPENSPACE", _F, GeneralLabel.BIG, "#43bf89", corridor_in_graphs=True),
        Label("CONFERENCE HALL", _F, GeneralLabel.BIG, "#43bf89"),
        Label("OFFICE", _F, GeneralLabel.MEDIUM, "#1bddf2"),
        Label("SHARED OFFICE", _F, GeneralLabel.BIG, "#2267f2"),
        Label("SMALL ADMINISTRATIVE", _S, GeneralLabel.SMALL, "#beb94e"),
        Label("MEDIUM ADMINISTRATIVE", _S, GeneralLabel.MEDIUM, "#beb615"),
        Label("BIG ADMINISTRATIVE", _S, GeneralLabel.BIG, "#716d0d"),
        Label("RECEPTION", _S, GeneralLabel.MEDIUM, "#5f1978"),
        Label("KITCHEN", _S, GeneralLabel.BIG, "#b27abe"),
        Label("CLOSET", _S, GeneralLabel.SMALL, "#bdbdbd"),
        Label("CONVENIENCE STORE", _S, GeneralLabel.MEDIUM, "#a5a5be"),
        Label("MEDIUM SERVICE", _S, GeneralLabel.MEDIUM, "#8c8c8b"),
        Label("BIG SERVICE", _S, GeneralLabel.BIG, "#585859"),
        Label("COLLECTIVE SERVICE ROOM", _S, GeneralLabel.BIG, "#3c3c3c"),
        Label("BATHROOM", _S, GeneralLabel.SMALL, "#fff87d"),
        Label("WASHROOM", _S, GeneralLabel.SMALL, "#e8caa7"),
        Label("CAFETERIA", _S, GeneralLabel.BIG, "#282828"),
        Label("CORRIDOR", _C, GeneralLabel.CORRIDOR, "#f28705"),
        Label("LOBBY", _C, GeneralLabel.HALL, "#f24738"),
        Label("HALL", _C, GeneralLabel.HALL, "#bf5719"),
        Label("ENTRANCE", _E, GeneralLabel.SMALL, "#268080", corridor_in_graphs=True),
        Label("ELEVATOR", _E, GeneralLabel.SMALL, "#147171"),
        Label("STAIRS", _E, GeneralLabel.SMALL, "#5bbebe"),
    ),
)

HOUSE = LabelSchema(
    "house",
    (
        Label("LIVING ROOM", _F, GeneralLabel.BIG, "#1bddf2"),
        Label("DINING ROOM", _F, GeneralLabel.MEDIUM, "#43bf89"),
        Label("BEDROOM", _F, GeneralLabel.MEDIUM, "#2267f2"),
        Label("CHILD ROOM", _F, GeneralLabel.MEDIUM, "#2a90f2"),
        Label("GUEST ROOM", _F, GeneralLabel.MEDIUM, "#324872"),
        Label("OFFICE", _F, GeneralLabel.MEDIUM, "#3fbf04"),
        Label("ROOM", _F, GeneralLabel.MEDIUM, "#2e7880"),
        Label("KITCHEN", _S, GeneralLabel.MEDIUM, "#b27abe"),
        Label("BATHROOM", _S, GeneralLabel.SMALL, "#fff87d"),
        Label("TOILET", _S, GeneralLabel.SMALL, "#e8caa7"),
        Label("CLOSET", _S, GeneralLabel.SMALL, "#bdbdbd"),
        Label("WARDROBE", _S, GeneralLabel.SMALL, "#a5a5be"),
        Label("STORAGE", _S, GeneralLabel.SMALL, "#8c8c8b"),
        Label("LAUNDRY", _S, GeneralLabel.SMALL, "#beb94e"),
        Label("GARAGE", _S, GeneralLabel.BIG, "#585859"),
        Label("GYM", _S, GeneralLabel.MEDIUM, "#a81e1e"),
        Label("BOILER ROOM", _S, GeneralLabel.SMALL, "#3c3c3c"),
        Label("AERATION", _S, GeneralLabel.SMALL, "#282828"),
        Label("BALCONY", _S, GeneralLabel.SMALL, "#beb615"),
        Label("LOGGIA", _S, GeneralLabel.SMALL, "#716d0d"),
        Label("TERRACE", _S, GeneralLabel.MEDIUM, "#5f1978"),
        Label("CORRIDOR", _C, GeneralLabel.CORRIDOR, "#f28705"),
        Label("HALLWAY", _C, GeneralLabel.CORRIDOR, "#d97a0a"),
        Label("LOBBY", _C, GeneralLabel.HALL, "#f24738"),
        Label("HALL", _C, GeneralLabel.HALL, "#bf5719"),
        Label("ENTRANCE", _E, GeneralLabel.SMALL, "#268080", corridor_in_graphs=True),
        Label("ENTRYWAY", _E, GeneralLabel.SMALL, "#1f6b6b", corridor_in_graphs=True),
        Label("PASSENGER ELEVATOR", _E, GeneralLabel.SMALL, "#0f5c5c"),
        Label("FREIGHT ELEVATOR", _E, GeneralLabel.SMALL, "#0b4747"),
        Label("ELEVATOR", _E, GeneralLabel.SMALL, "#147171"),
        Label("STAIRS", _E, GeneralLabel.SMALL, "#5bbebe"),
    ),
)

# Houses and flats: names of rooms show a home, and not which of both
HOME = LabelSchema("home", HOUSE.labels)

HOSPITAL = LabelSchema(
    "hospital",
    (
        Label("WARD", _F, GeneralLabel.MEDIUM, "#1bddf2"),
        Label("INTENSIVE CARE", _F, GeneralLabel.BIG, "#324872"),
        Label("EXAMINATION ROOM", _F, GeneralLabel.SMALL, "#3fbf04"),
        Label("TREATMENT ROOM", _F, GeneralLabel.MEDIUM, "#2a90f2"),
        Label("OPERATING ROOM", _F, GeneralLabel.BIG, "#2267f2"),
        Label("RECOVERY ROOM", _F, GeneralLabel.BIG, "#43bf89"),
        Label("DELIVERY ROOM", _F, GeneralLabel.MEDIUM, "#2e7880"),
        Label("RADIOLOGY", _F, GeneralLabel.MEDIUM, "#16557a"),
        Label("THERAPY ROOM", _F, GeneralLabel.BIG, "#5aa9e6"),
        Label("LAB", _F, GeneralLabel.MEDIUM, "#1b7f5c"),
        Label("DAY ROOM", _S, GeneralLabel.MEDIUM, "#a81e1e"),
        Label("WAITING ROOM", _S, GeneralLabel.MEDIUM, "#c75d5d"),
        Label("RECEPTION", _S, GeneralLabel.MEDIUM, "#5f1978"),
        Label("NURSE STATION", _S, GeneralLabel.SMALL, "#beb94e"),
        Label("OFFICE", _S, GeneralLabel.MEDIUM, "#beb615"),
        Label("CONFERENCE ROOM", _S, GeneralLabel.MEDIUM, "#716d0d"),
        Label("STAFF ROOM", _S, GeneralLabel.MEDIUM, "#8c8c8b"),
        Label("CHANGING ROOM", _S, GeneralLabel.SMALL, "#cfa3c4"),
        Label("PHARMACY", _S, GeneralLabel.MEDIUM, "#9d8ad1"),
        Label("UTILITY", _S, GeneralLabel.SMALL, "#a5a5be"),
        Label("STORAGE", _S, GeneralLabel.SMALL, "#6f6f6f"),
        Label("CLOSET", _S, GeneralLabel.SMALL, "#bdbdbd"),
        Label("LAUNDRY", _S, GeneralLabel.MEDIUM, "#585859"),
        Label("KITCHEN", _S, GeneralLabel.BIG, "#b27abe"),
        Label("CAFETERIA", _S, GeneralLabel.BIG, "#282828"),
        Label("CHAPEL", _S, GeneralLabel.BIG, "#3c3c3c"),
        Label("TECHNICAL ROOM", _S, GeneralLabel.MEDIUM, "#4a4a55"),
        Label("BATHROOM", _S, GeneralLabel.SMALL, "#fff87d"),
        Label("TOILET", _S, GeneralLabel.SMALL, "#e0b98c"),
        Label("WASHROOM", _S, GeneralLabel.SMALL, "#e8caa7"),
        Label("CORRIDOR", _C, GeneralLabel.CORRIDOR, "#f28705"),
        Label("LOBBY", _C, GeneralLabel.HALL, "#f24738"),
        Label("HALL", _C, GeneralLabel.HALL, "#bf5719"),
        Label("ENTRANCE", _E, GeneralLabel.SMALL, "#268080", corridor_in_graphs=True),
        Label("ELEVATOR", _E, GeneralLabel.SMALL, "#147171"),
        Label("STAIRS", _E, GeneralLabel.SMALL, "#5bbebe"),
    ),
)

# The colour of the most common label of each function.
FCES_COLORS = MappingProxyType({_F: "#1bddf2", _C: "#f28705", _E: "#268080", _S: "#8c8c8b"})

# Those of the thesis, whose buildings the included models have learned from; and all.
SCHEMAS = MappingProxyType({schema.building_type: schema for schema in (SCHOOL, OFFICE)})
ALL_SCHEMAS = MappingProxyType({**SCHEMAS, **{schema.building_type: schema for schema in (HOUSE, HOME, HOSPITAL)}})


def schema_of(building_type: str) -> LabelSchema:
    """The schema of a building type that pianta has, in any case; LabelError for other types."""
    schema = ALL_SCHEMAS.get(" ".join(building_type.split()).lower())
    if schema is None:
        raise LabelError(
            f"there is no schema of building type {building_type[:50]!r}, "
            f"give one of {', '.join(ALL_SCHEMAS)} or a schema of your own"
        )
    return schema
