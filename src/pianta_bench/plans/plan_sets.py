"""The plans that are read: real ones with their truth and what they look like, and drawn ones."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np
import shapely
from shapely import get_coordinates

from pianta._types import Colors
from pianta.errors import DataError
from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import short_repr
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.io.buildings.thesis_xml import MAX_BEYOND_PX, read_building_xml
from pianta.io.images import read_colors
from pianta.worlds.floors import make_floor
from pianta.worlds.plans.drawing import draw_plan
from pianta.worlds.plans.look import PlanLook
from pianta_bench.data.folders import list_maps

PLANS_FOLDER, TRUTH = "floorplans", ".xml"
IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")
DOOR_METRES = 0.9  # width of a door by the scale of the truths
MAX_OVERLAP = 0.01  # share of the area in two rooms; chosen by hand

LINES, COLORED, OLD = "line drawing", "coloured", "old or by hand"
THIN, EVACUATION, SCREENSHOT = "thin and grey", "evacuation", "screenshot"
KINDS = (LINES, COLORED, OLD, THIN, EVACUATION, SCREENSHOT)

# The kind of each plan, and whether most of its doors have a leaf or an arc, or else are gaps in the walls. Both were
# assigned by eye, the latter from a dozen doors of each plan.
_KINDS_FILE = files("pianta_bench").joinpath("plans", "kinds.csv")
_PLANS = list(csv.DictReader(_KINDS_FILE.read_text(encoding="utf-8").splitlines()))
KIND_OF_PLAN: Mapping[str, str] = {row["plan"]: row["kind"] for row in _PLANS}
WITHOUT_DOOR_SYMBOLS = frozenset(row["plan"] for row in _PLANS if row["door_symbols"] == "no")


@dataclass(frozen=True, eq=False)
class TruePlan:
    """A plan and the truth about it.

    colors: shape (H, W, 3). truth: in the frame of the grid, whose cells are the pixels.
    kind: one of KINDS, or "drawn". building_type: as in the truth, or empty.
    draws_doors: whether most doors have a leaf or an arc. defects: of the truth; it is sound without any.
    """

    name: str
    colors: Colors
    truth: Floor
    grid: GridMap
    kind: str
    building_type: str = ""
    draws_doors: bool = True
    defects: tuple[str, ...] = ()


def list_plans(data: Path) -> list[str]:
    """Names of the plans with a truth, sorted; raises DataError without any."""
    return list_maps(data / PLANS_FOLDER, TRUTH)


def find_image(data: Path, name: str) -> Path:
    """The image of a plan; raises DataError if it does not exist."""
    files = [data / PLANS_FOLDER / f"{name}{suffix}" for suffix in IMAGE_SUFFIXES]
    image = next((file for file in files if file.is_file()), None)
    if image is None:
        raise DataError(f"no image of plan {short_repr(name)} in {short_repr(data / PLANS_FOLDER)}, give a PNG or JPEG")
    return image


def read_true_plan(data: Path, name: str) -> TruePlan:
    """A plan of data/floorplans; its truth is in metres by its own scale, by which a door is 0.9 m wide.

    A plan of which no kind is on record has the kind that its pixels suggest, and counts as drawing its doors.
    Raises DataError if there is no image, and the errors of read_colors and read_building_xml.
    """
    colors = read_colors(find_image(data, name))
    file = data / PLANS_FOLDER / f"{name}{TRUTH}"
    grid = GridMap(np.full(colors.shape[:2], UNKNOWN, np.int8), DOOR_METRES / _read_door_px(file))
    truth = read_building_xml(file, grid=grid)
    return TruePlan(
        name,
        colors,
        truth,
        grid,
        KIND_OF_PLAN.get(name) or detect_input_kind(colors),
        truth.given_type or "",
        name not in WITHOUT_DOOR_SYMBOLS,
        tuple(find_defects(truth, grid)),
    )


def _read_door_px(file: Path) -> float:
    """The pixels of DOOR_METRES; read_building_xml refuses what is not a number."""
    _, root = open_building(file, BuildingFormat.LAYOUT)
    try:
        return max(float(root.findtext("scale/represented_distance/value", "")), 1e-3)
    except ValueError:
        return 1.0


def find_defects(truth: Floor, grid: GridMap) -> Iterator[str]:
    """Why a truth is not sound: rooms that leave the image, or more than MAX_OVERLAP of the area in two rooms.

    What hardly changes a score is no defect: outlines that cross themselves, which the reader repairs, small overlaps,
    and rooms without doors to the others.
    """
    polygons = np.array([room.polygon for room in truth.rooms])
    pixels = np.column_stack(grid.map_to_pixel(*get_coordinates(polygons).T))
    beyond = float(np.maximum(-pixels, pixels - grid.shape).max())
    if beyond > MAX_BEYOND_PX:
        yield f"leaves the image by {beyond:.0f} px"
    area = float(shapely.area(polygons).sum())
    overlap = 1 - shapely.union_all(polygons).area / area
    if overlap > MAX_OVERLAP:
        yield f"{overlap:.0%} of its area is in two rooms"


def detect_input_kind(colors: Colors) -> str:
    """The kind of a plan by its pixels, one of KINDS except OLD.

    A screenshot has few light pixels; a coloured plan has more than a tenth coloured ones; evacuation signs are strong
    red and strong green; thin lines leave hardly any dark pixels. The thresholds were chosen by hand.
    """
    hue, saturation, value = (channel.astype(int) for channel in cv2.split(cv2.cvtColor(colors, cv2.COLOR_RGB2HSV)))
    strong = (saturation > 150) & (value > 120)
    red, green = strong & ((hue < 8) | (hue > 172)), strong & (hue > 45) & (hue < 85)
    if (value > 200).mean() < 0.35:
        return SCREENSHOT
    if ((saturation > 60) & (value > 60)).mean() > 0.1:
        return COLORED
    if min(red.mean(), green.mean()) > 0.002:
        return EVACUATION
    return THIN if (value < 100).mean() < 0.01 else LINES


# By name of a drawn plan the layout of its floor and the seed, as of make_floor, and how it is drawn.
DRAWN_PLANS: Mapping[str, tuple[str, int, PlanLook]] = MappingProxyType(
    {
        "drawn-thick": ("corridor", 1, PlanLook(windows=2, title="FIRST FLOOR")),
        "drawn-thick-furniture": ("l", 2, PlanLook(windows=3, furniture=1.0)),
        "drawn-thick-leaves": ("ring", 3, PlanLook(doors="leaf 45", dimensions=True)),
        "drawn-thick-double-doors": ("hall", 4, PlanLook(doors="double", scale_bar=True)),
        "drawn-double": ("corridor", 5, PlanLook("double", windows=2)),
        "drawn-double-furniture": ("ring", 6, PlanLook("double", windows=3, furniture=1.0, dimensions=True)),
        "drawn-double-legend": ("l", 7, PlanLook("double", px_per_metre=40.0, doors="arc 45", legend=True)),
        "drawn-single": ("l", 8, PlanLook("single", title="Second floor", scale_bar=True)),
        "drawn-single-thin": ("corridor", 9, PlanLook("single", windows=2, furniture=0.5, ink=150)),
        "drawn-coloured-turned": ("hall", 10, PlanLook(colored=True, rotation=20.0, ink=60)),
        "drawn-evacuation": ("ring", 11, PlanLook(ink=110, evacuation=True, windows=2)),
        "drawn-photo": ("l", 12, PlanLook(windows=2, furniture=0.5, noise=0.7, title="Ground floor")),
    }
)
ROOM_NAMES = (
    *("Office", "Class Room", "Library", "Main Office", "Health Room", "Store", "Laboratory", "Staff Room"),
    *("Kitchen", "Girls", "Boys", "Computer Room", "Reception"),
)


def draw_true_plan(name: str) -> TruePlan:
    """A plan of DRAWN_PLANS with its exact truth."""
    layout, seed, look = DRAWN_PLANS[name]
    floor = make_floor(layout, seed=seed)
    texts = {room.id: ROOM_NAMES[room.id % len(ROOM_NAMES)] for room in floor.rooms}
    texts[1] = (floor.rooms[0].label or "").capitalize()
    drawing = draw_plan(floor, look, seed=seed, texts=texts)
    return TruePlan(name, drawing.colors, replace(drawing.truth, source=name), drawing.grid, "drawn")
