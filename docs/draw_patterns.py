"""Draw the picture of docs/methods/model-floor-plan.md from the annotated floors: python docs/draw_patterns.py."""

from __future__ import annotations

from pathlib import Path

from pianta.errors import DataError
from pianta.patterns.model_floor_plan import find_model_floor_plan
from pianta.plot.figure import new_figure, save_figure
from pianta.plot.model_floor_plan import plot_model_floor_plan
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.folders import find_data

IMAGE = Path(__file__).parent / "images" / "model_floor_plan.png"
FLOORS = (Path("office", "pinecondos.xml"), Path("school", "falaelem2.xml"))
WIDTH, HEIGHT = 7.0, 3.1  # inches


def main() -> None:
    """Draw the picture; without data it stays."""
    try:
        folder = find_data() / "buildings"
    except DataError:
        return
    figure = new_figure(WIDTH, HEIGHT)
    for ax, name in zip(figure.subplots(1, len(FLOORS)), FLOORS, strict=True):
        floor = read_drawing(folder / name)
        plot_model_floor_plan(floor, find_model_floor_plan(floor, shuffles=0), ax=ax)
        ax.set_aspect("equal")
        ax.set_axis_off()
    figure.subplots_adjust(left=0.01, right=0.99, top=0.99, bottom=0.01, wspace=0.03)
    save_figure(figure, IMAGE)


if __name__ == "__main__":
    main()
