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
    """The line of a door on an ax in metres, whose scale is known when it is drawn; in a legend it has full width."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw the line as wide as the scale of its ax requires."""
        width, diamond = LIMITS[1], DIAMOND_LIMITS[1]
        if self.axes is not None and self.get_transform().contains_branch(self.axes.transData):
            pixels = abs(float(self.axes.transData.get_matrix()[0, 0]))
            points = pixels / float(np.asarray(renderer.points_to_pixels(1.0)))
            width = float(np.clip(WIDTH * points, *LIMITS))
            diamond = float(np.clip(DIAMOND_WIDTH * points, *DIAMOND_LIMITS))
        self.set(linewidth=width, markersize=diamond)
        super().draw(renderer)
