"""The files that the commands of the pages name, made small: maps, a plan, symbols, buildings and a model."""

from dataclasses import replace
from pathlib import Path

from PIL import Image

import pianta
from pianta.plan.symbols.drawings import draw_symbol
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan
from tests.labelled_floors import labelled_floors
from tests.typed_floors import make_office

NAMES = ("Classroom", "Office", "Store", "Kitchen", "Library")


def make_page_samples(folder: Path) -> None:
    """Write all of them into a folder."""
    _, grid = pianta.make_world("sample")
    for path in (folder / "map.yaml", folder / "demo" / "map.yaml"):
        path.parent.mkdir(exist_ok=True)
        grid.save(path)
    Image.open(folder / "map.png").save(folder / "scan.png")
    draw_page_plan(folder / "plan.png")
    (folder / "symbols").mkdir()
    Image.fromarray(draw_symbol("door", size_px=28)).save(folder / "symbols" / "door1.png")
    save_buildings(folder / "buildings")


def draw_page_plan(path: Path) -> None:
    """A small plan with names in its rooms, which is quickly read."""
    floor = make_corridor_floor(seed=4, length=14.0)
    texts = {room.id: NAMES[room.id % len(NAMES)] for room in floor.rooms[1:]}
    Image.fromarray(draw_plan(floor, seed=4, style="double", px_per_metre=24, texts=texts).colors).save(path)


def save_buildings(folder: Path) -> None:
    """Labelled floors of both types that pianta knows."""
    for floor in labelled_floors():
        name = f"{floor.source.split()[0]}-{'ab'[int(floor.source.split()[2][0]) - 1]}"
        save_floor(replace(floor, source=name), folder / "school")
    for number, name in enumerate("abcde", start=2):
        save_floor(make_office(number, source=f"office-{name}"), folder / "office")


def save_floor(floor: pianta.Floor, folder: Path) -> None:
    """Write a floor into a folder, named after its source."""
    folder.mkdir(parents=True, exist_ok=True)
    floor.save(folder / f"{floor.source}.geojson")
