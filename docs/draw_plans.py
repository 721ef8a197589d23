"""Draw the pictures of docs/methods/plans.md: python docs/draw_plans.py."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib.figure import Figure
from PIL import Image

from pianta.gridmap import GridMap
from pianta.plan.read_plan import PlanFloor, read_plan
from pianta.plan.walls.segmentation import DOOR, OUTSIDE, WALL, segment_sheet
from pianta.plot.floor_parts import plot_doors, plot_rooms
from pianta.plot.grid import plot_ink
from pianta.worlds.floors import make_l_floor
from pianta.worlds.plans.drawing import DrawnPlan, draw_plan
from pianta_bench.harness.charts import save_chart

IMAGES = Path(__file__).parent / "images"
SEED, DPI = 4, 110
NAMES = ("Classroom", "Office", "Store", "Staff room", "Kitchen", "Library", "Laboratory")


def main() -> None:
    """Draw a plan, the classes that the network predicts, and the floor that is read from it."""
    plan = draw_sample()
    with TemporaryDirectory() as folder:
        file = Path(folder, "plan.png")
        Image.fromarray(plan.colors).save(file)
        (plan_floor,) = read_plan(file).floors
    regions = segment_sheet(plan.colors, door_px=0.9 / plan.grid.resolution)
    figure = Figure(figsize=(15, 5), layout="constrained")
    sheet, classes, rooms = figure.subplots(1, 3)
    sheet.imshow(plan.colors)
    classes.imshow(regions.probabilities[[OUTSIDE, WALL, DOOR]].transpose(1, 2, 0))
    plot_reading(plan_floor, plan, rooms)
    titles = ("the plan", "outside red, wall green, door blue", "rooms and doors that were read")
    for ax, title in zip((sheet, classes, rooms), titles, strict=True):
        ax.set(title=title, aspect="equal")
        ax.set_axis_off()
    IMAGES.mkdir(exist_ok=True)
    save_chart(figure, IMAGES / "plan.png", dpi=DPI)


def draw_sample() -> DrawnPlan:
    """The plan of a synthetic floor, as an architect draws it."""
    floor = make_l_floor(seed=SEED)
    texts = {room.id: NAMES[room.id % len(NAMES)] for room in floor.rooms[1:]}
    return draw_plan(
        floor, seed=SEED, style="double", px_per_metre=32, windows=2, furniture=0.5, texts=texts, scale_bar=True
    )


def plot_reading(plan_floor: PlanFloor, plan: DrawnPlan, ax: object) -> None:
    """Draw the rooms and doors that were read, with the ink of the plan over them."""
    grid = GridMap(plan_floor.grid.cells, plan_floor.grid.resolution)
    plot_rooms(plan_floor.floor, ax=ax)
    plot_ink(plan.colors, grid, ax=ax)
    plot_doors(plan_floor.floor, ax=ax)


if __name__ == "__main__":
    main()
