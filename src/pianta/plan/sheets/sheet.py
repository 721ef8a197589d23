"""A plan as pixels, with the texts, walls and doors that its file names, and its scale."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite
from typing import Any

import numpy as np

from pianta._types import Colors, Floats, Mask
from pianta.floor.area_trust import AreaTrust
from pianta.plan.sheets.binarization import Contrast, PaperContrast, compare_to_paper, invert_if_dark

# Metres of a single door: the width at which the network was trained, and that a plan's doors are taken for
DOOR_WIDTH = 0.9
# Factors by which areas may be wrong
DOUBTED_AREA_FACTOR = 1.5  # from which on a warning is given
ROUGH_AREA_FACTOR = 2.0  # from which on areas are marked
LARGEST_AREA_FACTOR = 10.0  # that is given in figures


@dataclass(frozen=True, eq=False)
class PlacedText:
    """A text on a sheet.

    corners: shape (4, 2), row and col in continuous pixels, clockwise on the sheet from the upper left corner of the
    text as it is read, anticlockwise where the sheet is mirrored. confidence: of the reader, 0 … 1.
    """

    text: str
    corners: Floats
    confidence: float = 1.0

    @property
    def middle(self) -> Floats:
        """Row and col of its middle, shape (2,)."""
        return np.asarray(self.corners.mean(axis=0))

    @property
    def is_mirrored(self) -> bool:
        """Whether it is read in a mirror."""
        (rows, cols), (down, right) = (self.corners[side] - self.corners[0] for side in (1, 3))
        return bool(rows * right - cols * down > 0)

    @property
    def height(self) -> float:
        """Height of its line, pixels."""
        return float(np.hypot(*(self.corners[3] - self.corners[0])))


@dataclass(frozen=True)
class PlanScale:
    """Metres per pixel of a sheet, where they come from, and how certain they are.

    Attributes
    ----------
    resolution
        Metres per pixel.
    source
        Where the scale comes from, in a few words.
    confidence
        Probability that it is right within 15 %, 0 … 1.
    interval
        Metres per pixel between which it lies with a probability of 80 %; None if it is stated.
    wide_interval
        The same with 95 %.
    is_look
        Whether nothing but the look of the drawing speaks for it.
    """

    resolution: float
    source: str
    confidence: float
    interval: tuple[float, float] | None = None
    wide_interval: tuple[float, float] | None = None
    is_look: bool = False

    def __str__(self) -> str:
        return self.describe()

    @property
    def area_factor(self) -> float:
        """The factor by which areas may be wrong, with a probability of 95 % no more; 1 if the scale is stated."""
        if self.wide_interval is None:
            return 1.0
        low, high = self.wide_interval
        return max(high / self.resolution, self.resolution / low) ** 2

    @property
    def is_rough(self) -> bool:
        """Whether areas are too uncertain to be given without a mark."""
        return self.is_look or self.area_factor >= ROUGH_AREA_FACTOR

    @property
    def area_trust(self) -> AreaTrust:
        """How areas are shown: as they are, with a mark, or not at all."""
        return AreaTrust.for_scale(is_rough=self.is_rough, is_look=self.is_look)

    def scaled(self, factor: float) -> PlanScale:
        """Change the pixels and keep the scale.

        Parameters
        ----------
        factor
            By which the new pixels are larger.

        Returns
        -------
        PlanScale
            Metres per new pixel, with the same source.

        Examples
        --------
        >>> from pianta.plan.sheets.sheet import PlanScale
        >>> PlanScale(0.02, "the units of the file", 0.95, (0.018, 0.022)).scaled(2.0).interval
        (0.036, 0.044)
        """
        ends = (each and (each[0] * factor, each[1] * factor) for each in (self.interval, self.wide_interval))
        interval, wide_interval = ends
        return replace(self, resolution=self.resolution * factor, interval=interval, wide_interval=wide_interval)

    def as_json(self) -> dict[str, Any]:
        """List the scale, its intervals and its sources as an object of JSON.

        Returns
        -------
        dict
            With the keys metres_per_pixel, interval, wide_interval, sources, confidence, is_rough and is_look.
        """
        return {
            "metres_per_pixel": self.resolution,
            "interval": self.interval and [*self.interval],
            "wide_interval": self.wide_interval and [*self.wide_interval],
            "sources": self.source.split(", "),
            "confidence": self.confidence,
            "is_rough": self.is_rough,
            "is_look": self.is_look,
        }

    @classmethod
    def from_json(cls, member: Any) -> PlanScale | None:  # noqa: ANN401 - whatever a file holds
        """Read what `as_json` gives.

        Parameters
        ----------
        member
            The object.

        Returns
        -------
        PlanScale or None
            The scale; None if the object does not describe one.

        Examples
        --------
        >>> from pianta.plan.sheets.sheet import PlanScale
        >>> PlanScale.from_json(PlanScale(0.02, "8 doors", 0.9, (0.018, 0.022)).as_json()).interval
        (0.018, 0.022)
        """
        try:
            interval, wide_interval = (_read_pair(member[key]) for key in ("interval", "wide_interval"))
            resolution, confidence = float(member["metres_per_pixel"]), float(member["confidence"])
            source, is_look = ", ".join(map(str, member["sources"])), bool(member.get("is_look", False))
        except (AttributeError, KeyError, TypeError, ValueError):
            return None
        if not (isfinite(resolution) and resolution > 0):
            return None
        return cls(resolution, source, confidence, interval, wide_interval, is_look)

    def corrected(self, factor: float) -> PlanScale:
        """Take the scale that a person has given.

        Parameters
        ----------
        factor
            By which all lengths have been corrected; 1 for no correction.

        Returns
        -------
        PlanScale
            Certain, unless the factor is 1.

        Examples
        --------
        >>> from pianta.plan.sheets.sheet import PlanScale
        >>> PlanScale(0.02, "8 doors", 0.9).corrected(1.5).describe()
        '0.03 m per pixel (a correction)'
        """
        return self if factor == 1 else PlanScale(self.resolution * factor, "a correction", 1.0)

    def describe(self, *, px_per_unit: float = 1.0) -> str:
        """Describe the scale in one line, in the unit that `resolution=` takes.

        Parameters
        ----------
        px_per_unit
            Pixels per unit of a vector drawing; 1 where pixels are the unit.

        Returns
        -------
        str
            Such as "0.0296 m per pixel, 0.0275 to 0.032 (sizes written in 5 rooms, 8 doors)".
        """
        unit = "pixel" if px_per_unit == 1 else "drawing unit"
        between = ""
        if self.interval is not None:
            low, high = (end * px_per_unit for end in self.interval)
            between = f", {low:.3g} to {high:.3g}"
        described = f"{self.resolution * px_per_unit:.3g} m per {unit}{between} ({self.source})"
        if self.is_look or self.area_factor >= DOUBTED_AREA_FACTOR:
            described += f"; areas may be wrong by a factor of {_round_factor(self.area_factor)}, give the resolution"
        return described


def _read_pair(value: Any) -> tuple[float, float] | None:  # noqa: ANN401 - whatever a file holds
    """Two positive numbers, None for None; raises TypeError or ValueError for anything else."""
    if value is None:
        return None
    low, high = map(float, value)
    if not 0 < low <= high < inf:
        raise ValueError(f"{value} is no interval")
    return low, high


def _round_factor(factor: float) -> str:
    if factor >= LARGEST_AREA_FACTOR:
        return f"{LARGEST_AREA_FACTOR:.0f} or more"
    return f"{factor:.1f}" if factor < 3 else f"{factor:.0f}"


@dataclass(frozen=True, eq=False)
class Sheet:
    """A plan as pixels, with what its file says beyond them.

    colors: shape (H, W, 3), red, green, blue. walls: shape (H, W), what the file names wall; None for pictures.
    doors: shape (D, 2, 2), from jamb to jamb, row and col in continuous pixels, of doors that the file names.
    unnamed_doors: the same, of leaves with their arcs that the file draws.
    texts: None if they must be read from the pixels. resolution: metres per pixel, None if the file does not state it.
    px_per_unit: pixels per unit of the file, 1 for a picture. px_per_inch: of a picture, None if its file does not say.
    source: the name of the file. notes: how the pixels differ from those of the file, a line each.
    """

    colors: Colors
    walls: Mask | None = None
    doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    unnamed_doors: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    texts: tuple[PlacedText, ...] | None = None
    resolution: float | None = None
    px_per_unit: float = 1.0
    px_per_inch: float | None = None
    source: str = ""
    notes: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, pixels."""
        height, width, _ = self.colors.shape
        return height, width

    @cached_property
    def paper(self) -> Colors:
        """The colours on light paper, shape (H, W, 3)."""
        return invert_if_dark(self.colors)

    @cached_property
    def _contrast(self) -> PaperContrast:
        return compare_to_paper(self.paper)

    @cached_property
    def ink(self) -> Mask:
        """What is drawn, shape (H, W)."""
        return self._contrast.ink(self.paper)

    @property
    def contrast(self) -> Contrast:
        """How much darker each pixel is than the paper around it, shape (H, W), 0 … 1; above 0.5 is ink."""
        return self._contrast.contrast
