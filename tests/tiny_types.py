"""Data folders of small schools and offices that classifiers can learn from."""

from pathlib import Path

# A label, how many rooms of it a building has, and their sides in metres.
ROOMS = {
    "school": (("CLASSROOM", 6, (8, 7)), ("CLOSET", 6, (2, 2)), ("HALL", 1, (12, 11))),
    "office": (("OFFICE", 6, (4, 4)), ("WASHROOM", 6, (2, 3)), ("LOBBY", 1, (8, 6))),
    "house": (("M", 6, (4, 3)), ("S", 6, (2, 3)), ("H", 1, (5, 6))),
}


def write_types(data: Path, *types: str, buildings: int = 2) -> None:
    """data/buildings/TYPE: each building has a corridor (two where there are more rooms) with a door to every room."""
    for name in types:
        folder = data / "buildings" / name
        folder.mkdir(parents=True)
        for number in range(buildings):
            (folder / f"{name}{number}.xml").write_text(write_labelled(name, stretch=1 + number / 10))


def write_labelled(building_type: str, *, stretch: float) -> str:
    """Layout XML, 0.1 m a pixel, whose rooms lie in a row below their corridor and are a little different in width."""
    corridor = "C" if building_type == "house" else "CORRIDOR"
    rooms, left = [], 0.0
    for label, count, (width, height) in ROOMS[building_type]:
        for index in range(count):
            right = left + width * (stretch + index / 100)
            rooms.append((label, (left, 2.2, right, 2.2 + height)))
            left = right + 0.2
    spaces = [(corridor, (0, 0, left, 2)), *rooms]
    return (
        "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance>"
        "<real_distance><value>90</value><um>cm</um></real_distance></scale>"
        f"<floor><spaces>{''.join(_write_space(n, *space, len(rooms)) for n, space in enumerate(spaces))}</spaces>"
        "</floor></building>"
    )


def _write_space(number: int, label: str, bounds: tuple[float, ...], rooms: int) -> str:
    left, top, right, bottom = (10 * side for side in bounds)
    corners = (left, top), (right, top), (right, bottom), (left, bottom)
    outline = "".join(f'<point x="{x:.1f}" y="{y:.1f}"/>' for x, y in corners)
    others = range(1, rooms + 1) if number == 0 else (0,)
    portals = "".join(
        f"<portal><target><id>{number}</id><id>{other}</id></target><type>EXPLICIT</type></portal>" for other in others
    )
    return (
        f'<space id="{number}"><labels><label>{label}</label></labels>'
        f"<bounding_polygon>{outline}</bounding_polygon><portals>{portals}</portals></space>"
    )
