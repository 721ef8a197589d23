"""Lines that are as wide as what they stand for: matplotlib has widths in points only. Imported when one is drawn."""

from __future__ import annotations

import numpy as np
from matplotlib.backend_bases import RendererBase
from matplotlib.lines import Line2D

# Of doors: width on the floor, m, so that small doors are longer than wide, and its limits, points.
WIDTH = 0.45
LIMITS = (1.4, 3.0)
# The same of the diamonds of entrances.
DIAMOND_WIDTH = 1.6
DIAMOND_LIMITS = (3.5, 7.0)


class DoorStroke(Line2D):
    """The line of a door on an ax in metres, whose scale is known when it is drawn.

    Its line width and marker size are the largest ones, which it has in a legend.
    """

    def draw(self, renderer: RendererBase) -> None:
        """Draw the line as wide as the scale of its ax requires."""
        largest = self.get_linewidth(), self.get_markersize()
        width, diamond = self.fit_sizes(renderer)
        self.set(linewidth=width, markersize=diamond)
        super().draw(renderer)
        self.set(linewidth=largest[0], markersize=largest[1])

    def fit_sizes(self, renderer: RendererBase) -> tuple[float, float]:
        """Line width and marker size on its ax, points."""
        width, diamond = self.get_linewidth(), self.get_markersize()
        if self.axes is None or not self.get_transform().contains_branch(self.axes.transData):
            return width, diamond
        pixels = abs(float(self.axes.transData.get_matrix()[0, 0]))
        points = pixels / float(np.asarray(renderer.points_to_pixels(1.0)))
        return (
            min(width, max(WIDTH * points, LIMITS[0])),
            min(diamond, max(DIAMOND_WIDTH * points, DIAMOND_LIMITS[0])),
        )
