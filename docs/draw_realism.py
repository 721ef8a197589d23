"""Draw the pictures of docs/methods/realism.md: python docs/draw_realism.py."""

from __future__ import annotations

import tempfile
from itertools import pairwise, product
from pathlib import Path

from shapely import LineString, Polygon, box

from pianta.cli import main as run_pianta
from pianta.errors import DataError
from pianta.floor import Door, Floor, Room
from pianta.io.floors import save_floor
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta_bench.harness.charts import save_chart
from pianta_bench.realism.figures import draw_scores
from pianta_bench.realism.measure import measure

IMAGES = Path(__file__).parent / "images"
SEEDS = range(4)
# Square rooms of 5 m in rows, with one path through them to and fro; the last row is a corridor.
COLUMNS, ROWS, SIDE = 6, 4, 5.0


def main() -> None:
    """Draw both pictures; without data, the picture of the scores stays."""
    draw_labyrinth()
    try:
        results = measure()
    except DataError:
        return
    save_chart(draw_scores(results), IMAGES / "realism_scores.png", dpi=110)


def draw_labyrinth() -> None:
    """Assess a labyrinth by `pianta realism`, with the floors of `pianta world` as reference."""
    with tempfile.TemporaryDirectory() as folder:
        reference = Path(folder, "offices")
        reference.mkdir()
        for floor_type, seed in product(FLOOR_MAKERS, SEEDS):
            # Files whose names differ only in a number count as one building.
            save_floor(make_floor(floor_type, seed=seed), reference / f"{floor_type} {'abcd'[seed]}.geojson")
        world = Path(folder, "labyrinth.geojson")
        save_floor(make_labyrinth(), world)
        try:
            run_pianta(["realism", str(world), "--reference", str(reference), "-o", folder])
        except SystemExit as end:
            if end.code:
                raise
        Path(folder, "labyrinth.png").replace(IMAGES / "realism.png")


def make_labyrinth() -> Floor:
    """A floor whose rooms lead from one to the next, and to a corridor at the end."""
    corners = [(x if y % 2 else COLUMNS - 1 - x, y) for y in range(ROWS) for x in range(COLUMNS)]
    rooms = [box(SIDE * x, SIDE * y, SIDE * (x + 1), SIDE * (y + 1)) for x, y in corners]
    corridor = box(0, SIDE * ROWS, SIDE * COLUMNS, SIDE * ROWS + 2.5)
    doors = [_hang_door(pair, rooms[pair[0] - 1], rooms[pair[1] - 1]) for pair in pairwise(range(1, len(rooms) + 1))]
    doors.append(_hang_door((len(rooms), len(rooms) + 1), rooms[-1], corridor))
    return Floor(
        rooms=(
            *(Room(number, polygon, label="ROOM") for number, polygon in enumerate(rooms, start=1)),
            Room(len(rooms) + 1, corridor, label="CORRIDOR"),
        ),
        doors=tuple(doors),
        source="labyrinth",
    )


def _hang_door(pair: tuple[int, int], one: Polygon, other: Polygon) -> Door:
    wall = one.intersection(other)
    ends = [wall.interpolate(wall.length / 2 + half) for half in (-0.5, 0.5)]
    return Door(pair, LineString(ends), 1.0)


if __name__ == "__main__":
    main()
