"""Georeference: from metres of the map frame to a coordinate system of the earth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Georeference:
    """An affine motion from the map frame to a coordinate system.

    crs: its name, such as "EPSG:32632". matrix: (a, b, c, d, e, f); a point x, y of the map is at a x + b y + c and
    d x + e y + f.
    """

    crs: str
    matrix: tuple[float, float, float, float, float, float]
