"""Charts of results: empty figures of one style, and their files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pianta.io._files import atomic_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def start_chart(width: float, height: float) -> Figure:
    """An empty white figure, size in inches, whose parts do not overlap."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def save_chart(chart: Figure, path: Path, *, dpi: int) -> None:
    """Write a figure as a PNG, the same bytes for the same figure; raises PiantaError when it cannot be written."""
    with atomic_file(path) as temporary:
        chart.savefig(temporary, format="png", dpi=dpi, metadata={"Software": None})
