"""Literal floors of three building types, each built in its own way."""

from functools import cache
from math import cos, sin

from shapely import LineString, Polygon, box
from shapely.affinity import affine_transform

from pianta.building_types.model import BuildingTypeModel, train_building_types
from pianta.floor import Door, Floor, Room
from pianta.labels import FCES, SCHEMAS, GeneralLabel, Label, LabelSchema

HOUSE = LabelSchema(
    "house",
    (
        Label("LIVING ROOM", FCES.FUNCTIONAL, GeneralLabel.BIG, "#2267f2"),
        Label("BATH", FCES.SERVICE, GeneralLabel.SMALL, "#aa66f2"),
    ),
)
ALL_SCHEMAS = {**SCHEMAS, "house": HOUSE}


def build(type_name: str, source: str, rooms: list[tuple[str, Polygon]], doors: list[Door]) -> Floor:
    return Floor(
        tuple(Room(number, polygon, label=label) for number, (label, polygon) in enumerate(rooms, start=1)),
        tuple(doors),
        building_type={type_name: 1.0},
        source=source,
    )


def hang_door(one: int, other: int, x: float, y: float, *, upright: bool = False) -> Door:
    """A door from x, y on to the right, or upwards."""
    return Door((one, other), LineString([(x, y), (x, y + 0.9) if upright else (x + 0.9, y)]), 0.9)


def make_school(rooms: int, *, width: float = 7.0, source: str = "school.xml") -> Floor:
    """Classrooms above a long corridor, and as many below it, the last of them a closet."""
    above = [("CLASSROOM", box(i * width, 3, (i + 1) * width, 10)) for i in range(rooms)]
    below = [("CLASSROOM", box(i * width, -7, (i + 1) * width, 0)) for i in range(rooms - 1)]
    closet = ("CLOSET", box((rooms - 1) * width, -3, rooms * width, 0))
    doors = [hang_door(1, 2 + i, i * width + 1, 3) for i in range(rooms)]
    doors += [hang_door(1, 2 + rooms + i, i * width + 1, 0) for i in range(rooms)]
    return build("school", source, [("CORRIDOR", box(0, 0, rooms * width, 3)), *above, *below, closet], doors)


def make_office(rooms: int, *, depth: float = 3.0, source: str = "office.xml") -> Floor:
    """A square hall with small rooms on its four sides."""
    side = rooms * 2.5
    result: list[tuple[str, Polygon]] = [("HALL", box(0, 0, side, side))]
    doors = []
    for i in range(rooms):
        a, b = i * 2.5, (i + 1) * 2.5
        sides = (
            box(a, side, b, side + depth),
            box(a, -depth, b, 0),
            box(-depth, a, 0, b),
            box(side, a, side + depth, b),
        )
        indices = ((a + 0.8, side), (a + 0.8, 0), (0, a + 0.8), (side, a + 0.8))
        for number, (polygon, (x, y)) in enumerate(zip(sides, indices, strict=True)):
            result.append(("OFFICE" if i else "BATHROOM", polygon))
            doors.append(hang_door(1, len(result), x, y, upright=number >= 2))
    return build("office", source, result, doors)


def make_house(rooms: int, *, width: float = 5.0, source: str = "house.xml") -> Floor:
    """Rooms one behind the other, without a corridor."""
    result = [("BATH" if i == rooms - 1 else "LIVING ROOM", box(0, i * 4, width, (i + 1) * 4)) for i in range(rooms)]
    return build("house", source, result, [hang_door(i, i + 1, 1, i * 4) for i in range(1, rooms)])


@cache
def typed_floors() -> tuple[Floor, ...]:
    """Five buildings of each type, the first school with two floors."""
    schools = [make_school(4 + i, width=6.5 + 0.3 * i, source=f"school {'abcde'[i]}.xml") for i in range(5)]
    offices = [make_office(3 + i, depth=2.5 + 0.3 * i, source=f"office {'abcde'[i]}.xml") for i in range(5)]
    houses = [make_house(4 + i, width=4.5 + 0.3 * i, source=f"house {'abcde'[i]}.xml") for i in range(5)]
    return (make_school(6, width=7.2, source="school a 2.xml"), *schools, *offices, *houses)


@cache
def typed_model() -> BuildingTypeModel:
    """A model trained on them."""
    return train_building_types(typed_floors(), schemas=ALL_SCHEMAS)


def move(floor: Floor, *, turn: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)) -> Floor:
    """The floor turned, enlarged and shifted."""
    a, b = scale * cos(turn), scale * sin(turn)
    matrix = (a, -b, b, a, *shift)
    rooms = [Room(room.id, affine_transform(room.polygon, matrix), room.label, room.labels) for room in floor.rooms]
    doors = [Door(door.rooms, affine_transform(door.line, matrix), door.width * scale) for door in floor.doors]
    return Floor(tuple(rooms), tuple(doors), building_type=floor.building_type, source=floor.source)
