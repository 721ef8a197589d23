"""GridMap: the cells of an occupancy grid, their size, and their position in the map frame."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isfinite, sin
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pianta.errors import MapError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Cell values of ROS.
UNKNOWN = -1
FREE = 0
OCCUPIED = 100
# Thresholds on cell values of Nav2's map_saver.
MAX_FREE = 25
MIN_OCCUPIED = 65


@dataclass(frozen=True, eq=False)
class GridMap:
    """An occupancy grid with ROS's cell values, row 0 at the top.

    A notebook shows a map as its picture.

    Parameters
    ----------
    cells
        Shape (H, W), any integers from -1 to 100; -1 unknown, 0 free … 100 occupied. Kept as read-only int8.
    resolution
        Metres per cell, positive.
    origin
        The x, y (m) and yaw (rad, counter-clockwise) of the outer corner of the lower-left cell, in the map frame.
    source
        The name of the map's file; empty if unknown.

    Raises
    ------
    MapError
        A parameter is invalid; every fault is in one message.

    Examples
    --------
    >>> import numpy as np
    >>> import pianta
    >>> grid = pianta.GridMap(np.zeros((20, 30), int), 0.05, (1.0, 2.0, 0.0))
    >>> grid.shape, bool(grid.free.all())
    ((20, 30), True)
    """

    cells: NDArray[np.int8]
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    source: str = ""

    def __post_init__(self) -> None:
        faults = []
        cells = np.asarray(self.cells)
        if cells.ndim != 2 or cells.size == 0:
            faults.append(f"cells have shape {cells.shape}, give a non-empty 2-D array")
        elif cells.dtype.kind not in "iu":
            faults.append(f"cells are of type {cells.dtype}, give integers from -1 to 100")
        elif cells.min() < UNKNOWN or cells.max() > OCCUPIED:
            faults.append(f"cells lie in {cells.min()} … {cells.max()}, give integers from -1 to 100")
        if not (isfinite(self.resolution) and self.resolution > 0):
            faults.append(f"resolution is {self.resolution}, give positive metres per cell")
        if len(self.origin) != 3 or not all(isfinite(value) for value in self.origin):
            faults.append(f"origin is {self.origin}, give three finite numbers x, y, yaw")
        if faults:
            raise MapError("not a map: " + "; ".join(faults))
        cells = cells.astype(np.int8)
        cells.setflags(write=False)
        object.__setattr__(self, "cells", cells)
        object.__setattr__(self, "resolution", float(self.resolution))
        object.__setattr__(self, "origin", tuple(float(value) for value in self.origin))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.cells.shape
        return rows, cols

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that a robot may enter: value 0 … 25; shape (H, W)."""
        # As bytes, unknown cells are 255: one comparison instead of two
        return np.asarray(self.cells.view(np.uint8) <= MAX_FREE)

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells that hold an obstacle: value 65 … 100; shape (H, W)."""
        return np.asarray(self.cells >= MIN_OCCUPIED)

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Cells that are neither free nor occupied; shape (H, W)."""
        return ~(self.free | self.occupied)

    def __repr__(self) -> str:
        """The source, the size in cells, and the side of a cell."""
        rows, cols = self.shape
        return f"<GridMap {self.source!r}: {rows} × {cols} cells of {self.resolution:g} m>"

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the map in soft greys, in metres of the map frame: free white, unknown light, occupied dark.

        Parameters
        ----------
        ax
            Where to draw; a new figure if None.

        Returns
        -------
        Axes
            The ax with the drawing; nothing is shown.

        Examples
        --------
        >>> import pianta
        >>> _, grid = pianta.make_world("corridor")
        >>> ax = grid.plot()
        """
        from pianta.plot.grid import plot_grid

        return plot_grid(self, ax=ax)

    def _repr_png_(self) -> bytes:
        """The map as a notebook shows it, upright as its image."""
        from pianta.plot.grid import render_grid

        return render_grid(self)

    def scaled(self, factor: float) -> GridMap:
        """Make the same map with all lengths multiplied.

        Parameters
        ----------
        factor
            A positive number.

        Returns
        -------
        GridMap
            The cells with another resolution and origin; the angle of the origin is the same.

        Raises
        ------
        MapError
            The factor is not positive.

        Examples
        --------
        >>> import pianta
        >>> grid = pianta.make_world("corridor")[1]
        >>> grid.resolution, grid.scaled(2).resolution
        (0.05, 0.1)
        """
        x, y, yaw = self.origin
        return GridMap(self.cells, self.resolution * factor, (x * factor, y * factor, yaw), self.source)

    def save(self, path: str | Path) -> None:
        """Write the map: as a ROS map.yaml with a PNG beside it, or as a NumPy archive; `read_map` reads both.

        Parameters
        ----------
        path
            Ends in .yaml, .yml or .npz, which gives the format.

        Raises
        ------
        MapError
            The path ends otherwise.
        PiantaError
            A file cannot be written.

        Examples
        --------
        >>> import pianta
        >>> _, grid = pianta.make_world("corridor")
        >>> grid.save("map.yaml")
        >>> pianta.read_map("map.yaml").shape == grid.shape
        True
        """
        from pianta.io.maps import save_map

        save_map(self, path)

    def pixel_to_map(self, row: ArrayLike, col: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Map frame x, y of continuous pixel coordinates; (0, 0) is the outer corner of the top left cell.

        Parameters
        ----------
        row, col
            Pixels, numbers or arrays of one shape; the centre of cell [i, j] is (i + 0.5, j + 0.5).

        Returns
        -------
        x : numpy.ndarray
            Metres, of the shape of `row` and `col`.
        y : numpy.ndarray
            As `x`.

        Examples
        --------
        >>> import numpy as np
        >>> import pianta
        >>> grid = pianta.GridMap(np.zeros((20, 30), int), 0.1, (1.0, 2.0, 0.0))
        >>> x, y = grid.pixel_to_map(20, 0)
        >>> float(x), float(y)
        (1.0, 2.0)
        """
        x0, y0, yaw = self.origin
        right = np.asarray(col, float) * self.resolution
        up = (self.shape[0] - np.asarray(row, float)) * self.resolution
        return x0 + right * cos(yaw) - up * sin(yaw), y0 + right * sin(yaw) + up * cos(yaw)

    def map_to_pixel(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Give the continuous pixel row, col of map frame x, y; the inverse of `pixel_to_map`.

        Parameters
        ----------
        x, y
            Metres, numbers or arrays of one shape.

        Returns
        -------
        row : numpy.ndarray
            Pixels, of the shape of `x` and `y`; they may lie outside the map.
        col : numpy.ndarray
            As `row`.

        Examples
        --------
        >>> import numpy as np
        >>> import pianta
        >>> grid = pianta.GridMap(np.zeros((20, 30), int), 0.1, (1.0, 2.0, 0.0))
        >>> row, col = grid.map_to_pixel(1.0, 4.0)
        >>> float(row), float(col)
        (0.0, 0.0)
        """
        x0, y0, yaw = self.origin
        east, north = np.asarray(x, float) - x0, np.asarray(y, float) - y0
        right = east * cos(yaw) + north * sin(yaw)
        up = north * cos(yaw) - east * sin(yaw)
        return self.shape[0] - up / self.resolution, right / self.resolution
