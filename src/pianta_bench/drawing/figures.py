"""A picture: real floors, and what is drawn from their graphs without their geometry."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pianta.plot.floor import plot_floor
from pianta_bench.drawing.measure import REAL, WITHHELD
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 110
PAIRS = 4
WIDTH, HEIGHT = 4.2, 7.0  # inches, of a pair


def save_figures(results: Results, folder: Path) -> None:
    """Write pairs.png into a folder. Raises PiantaError if it cannot be written."""
    save_chart(draw_pairs(results), folder / "pairs.png", dpi=DPI)


def draw_pairs(results: Results) -> Figure:
    """The floors with a median number of rooms, above what is drawn from their graphs."""
    plans = {floor.source: floor for floor in results.objects["floors"][WITHHELD]}
    real = sorted((floor for floor in results.objects["floors"][REAL] if floor.source in plans), key=len)
    first = max((len(real) - PAIRS) // 2, 0)
    chosen = real[first : first + PAIRS]
    figure = start_chart(WIDTH * len(chosen), HEIGHT)
    for floor, (above, below) in zip(chosen, figure.subplots(2, len(chosen), squeeze=False).T, strict=True):
        plot_floor(floor, ax=above, furniture=False)
        plot_floor(plans[floor.source], ax=below, furniture=False)
        above.set_title(f"{floor.source}, {len(floor)} rooms", fontsize=9)
        below.set_title("drawn from its graph", fontsize=9)
    return figure
