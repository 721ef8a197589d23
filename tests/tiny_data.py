"""Data folders of two tiny rooms, whose scores can be reckoned by hand, and tiny schools."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from PIL import Image
from shapely import Polygon, box

from pianta.floor import Floor, Room
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings

Output = TypeVar("Output")

# A room of 4 m × 3 m and one of 2 m × 3 m, with a wall of 0.2 m between them, in a map of 8 m × 5 m.
SIZE = (8.0, 5.0)
ROOMS = (box(1, 1, 5, 4), box(5.2, 1, 7.2, 4))
# The same as the schools' truth has them: their outlines meet in the middle of the wall.
OUTLINES = (box(1, 1, 5.1, 4), box(5.1, 1, 7.2, 4))
TRUE_FLOOR = Floor(tuple(Room(number, polygon) for number, polygon in enumerate(ROOMS, start=1)))
ONE_ROOM = Floor((Room(1, box(1, 1, 7.2, 4)),))

UNKNOWN_GREY, FREE_GREY = 205, 254

ROOM_LABELS = {"K": "CLASSROOM", "C": "CLOSET", "L": "LAB", "W": "WASHROOM", "S": "STAIRS"}


def write_survey(data: Path, *names: str) -> None:
    """data/survey: each map without and with furniture, and the truth."""
    folder = data / "survey"
    folder.mkdir(parents=True)
    for name in names:
        for ending in (".png", "_furnitures.png"):
            write_image(folder / f"{name}{ending}", 0.05, other=0)
        write_image(folder / f"{name}_gt_segmentation.png", 0.05, other=0)


def write_slam(data: Path, *names: str, outlines: tuple[Polygon, ...] = OUTLINES) -> None:
    """data/slam: each map and its layout XML."""
    folder = data / "slam"
    folder.mkdir(parents=True)
    for name in names:
        write_image(folder / f"{name}.png", 0.1, other=UNKNOWN_GREY)
        (folder / f"{name}_gt.xml").write_text(write_building(outlines, 0.1))


def write_colors(folder: Path, *names: str) -> None:
    """Maps with a coloured truth, as in data/clutter and data/partial/freiburg79."""
    folder.mkdir(parents=True)
    for name in names:
        write_image(folder / f"{name}.png", 0.05, other=UNKNOWN_GREY)
        with Image.open(folder / f"{name}.png") as image:
            free = np.asarray(image) == FREE_GREY
        colors = np.zeros((*free.shape, 3), np.uint8)
        colors[free] = 0, 0, 200
        colors[:, 102:][free[:, 102:]] = 90, 0, 0
        Image.fromarray(colors).save(folder / f"{name}_gt.png")


def write_doors(data: Path, *names: str) -> None:
    """data/doors: each full map, and the same without the smaller room, whose door is closed."""
    folder = data / "doors"
    folder.mkdir(parents=True)
    for name in names:
        write_image(folder / f"{name}_GT.png", 0.05, other=UNKNOWN_GREY)
        write_image(folder / f"{name}_01_IN.png", 0.05, other=UNKNOWN_GREY)
        write_image(folder / f"{name}_02_IN.png", 0.05, other=UNKNOWN_GREY, rooms=ROOMS[:1])


def write_vacuum(data: Path, *names: str) -> None:
    """data/vacuum: each map.yaml with its image, and the rooms as 16-bit ids 7 and 300 on free cells."""
    folder = data / "vacuum"
    folder.mkdir(parents=True)
    for name in names:
        write_image(folder / f"{name}.png", 0.05, other=UNKNOWN_GREY)
        text = f"image: {name}.png\nresolution: 0.05\norigin: [0, 0, 0]\n"
        (folder / f"{name}.yaml").write_text(text + "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
        with Image.open(folder / f"{name}.png") as image:
            ids = np.where(np.asarray(image) == FREE_GREY, 7, 0).astype(np.uint16)
        ids[:, 102:][ids[:, 102:] > 0] = 300
        Image.fromarray(ids).save(folder / f"{name}_gt.png")


def write_all_sets(data: Path, *names: str) -> None:
    """Every folder that bench segmentation reads."""
    write_survey(data, *names)
    write_colors(data / "clutter", *names)
    write_vacuum(data, *names)
    write_doors(data, *names)
    write_slam(data, *names)
    write_colors(data / "partial" / "freiburg79", *names)


def write_image(path: Path, resolution: float, *, other: int, rooms: tuple[Polygon, ...] = ROOMS) -> None:
    """The rooms in white, the rest in another grey."""
    width, height = (round(side / resolution) for side in SIZE)
    greys = np.full((height, width), other, np.uint8)
    for room in rooms:
        left, bottom, right, top = (round(side / resolution) for side in room.bounds)
        greys[height - top : height - bottom, left:right] = FREE_GREY
    Image.fromarray(greys).save(path)


def write_building(outlines: tuple[Polygon, ...], resolution: float) -> str:
    """Layout XML in the pixels of the image, where y grows downwards."""
    spaces = ""
    for number, outline in enumerate(outlines):
        corners = [(x / resolution, (SIZE[1] - y) / resolution) for x, y in outline.exterior.coords[:-1]]
        points = "".join(f'<point x="{x:.0f}" y="{y:.0f}"/>' for x, y in corners)
        spaces += f'<space id="{number}"><bounding_polygon>{points}</bounding_polygon></space>'
    return (
        "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance>"
        "<real_distance><value>90</value><um>cm</um></real_distance></scale>"
        f"<floor><spaces>{spaces}</spaces></floor></building>"
    )


def write_schools(data: Path, *wings: str) -> None:
    """data/buildings/school: each named by its wings, such as "KKW-LC", with a letter of ROOM_LABELS for each room."""
    folder = data / "buildings" / "school"
    folder.mkdir(parents=True)
    for number, school in enumerate(wings):
        (folder / f"school{number}.xml").write_text(write_school(school.split("-")))


def read_as_buildings(data: Path, building_type: str, make: Callable[[AnnotatedFloor], Output]) -> Any:
    """read_annotated_buildings with a building for each drawing."""
    return read_annotated_buildings(data, building_type, lambda floor: make(replace(floor, building=floor.item)))


def write_school(wings: Sequence[str]) -> str:
    """Layout XML, 0.1 m a pixel: wings of a corridor with a door to each of its rooms, and to the next corridor."""
    spaces, left = [], 0
    hubs = [sum(len(wing) + 1 for wing in wings[:index]) for index in range(len(wings))]
    for hub, wing in zip(hubs, wings, strict=True):
        rooms = range(hub + 1, hub + 1 + len(wing))
        beside = [other for other in hubs if abs(hubs.index(other) - hubs.index(hub)) == 1]
        spaces.append(_write_space(hub, "CORRIDOR", (left, 0, left + 40 * len(wing), 20), [*rooms, *beside]))
        for room, letter in zip(rooms, wing, strict=True):
            right = left + 40
            spaces.append(_write_space(room, ROOM_LABELS[letter], (left, 20, right, 60), [hub]))
            left = right
    return (
        "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance>"
        "<real_distance><value>90</value><um>cm</um></real_distance></scale>"
        f"<floor><spaces>{''.join(spaces)}</spaces></floor></building>"
    )


def _write_space(number: int, label: str, bounds: tuple[int, int, int, int], others: Sequence[int]) -> str:
    left, top, right, bottom = bounds
    corners = (left, top), (right, top), (right, bottom), (left, bottom)
    outline = "".join(f'<point x="{x}" y="{y}"/>' for x, y in corners)
    portals = "".join(
        f"<portal><target><id>{number}</id><id>{other}</id></target><type>EXPLICIT</type></portal>" for other in others
    )
    return (
        f'<space id="{number}"><labels><label>{label}</label></labels>'
        f"<bounding_polygon>{outline}</bounding_polygon><portals>{portals}</portals></space>"
    )
