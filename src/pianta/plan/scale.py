"""The scale of a plan: metres per pixel, what tells them, and how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, log, sqrt

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Floats, Mask
from pianta.errors import PlanError
from pianta.floor import DOOR_WIDTH, Floor
from pianta.plan.doors.swings import DoorSize, Swing, agree_on_size
from pianta.plan.sheets.binarization import measure_contrast
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.text.dimensions import parse_scale_bar, scale_from_dimensions
from pianta.plan.walls.regions import DOOR_CELLS, NETWORKS, find_regions, measure_doubt

# Doors with a swing tell the scale when so many agree, and are so large.
LEAST_DOORS, LEAST_DOOR_PX = 3, 8.0
# Of so many nobody doubts that they are doors.
SURE_DOORS = 8
# How sure doors make a scale: people draw them as they like.
SURE_BY_DOORS, SURE_BY_LOOK = 0.6, 0.3
# Longer sides that a sheet may have, metres; what states others is wrong.
SHEET_METRES = (2.0, 5000.0)
# Cells of a sheet that the network takes at most, for its memory; larger sheets are seen more coarsely.
MOST_CELLS = 4e6
# Longer sides of a drawing that are tried where no door is found, in doors, and by what factor each exceeds the next.
SIDES, STEP = (25.0, 40.0, 63.0, 100.0, 160.0), 1.26
# The longer side of a sheet is usually so many doors, with such a spread of its logarithm; how much that weighs, nats,
# where no door is found.
USUAL_SIDE, SPREAD_OF_SIDES, PRIOR = 100.0, 0.42, 0.04
# Cells of a side of the square that is asked about.
ASKED_CELLS = 448
# Where doors are known what a drawing may have whose doors are too wide for its rooms; what looks like doors and is
# none of these sizes is none, when another one leaves so much less doubt, nats. What lies between is asked about next
# to the best. Letters and furniture have arcs that are smaller than doors, but not by more than this factor.
FACTORS, LESS_DOUBT, MOST_LARGER = (0.5, 0.8, 1.0), 0.05, 3.0
# A sheet is seldom longer than so many doors: what makes it so is letters, whatever their number.
LONGEST_SIDE = 250.0


@dataclass(frozen=True)
class PlanScale:
    """Metres per pixel of a sheet, and what tells them.

    Attributes
    ----------
    resolution
        Metres per pixel.
    source
        What tells them, in a few words.
    confidence
        How sure they are, 0 … 1.
    """

    resolution: float
    source: str
    confidence: float

    def __str__(self) -> str:
        return self.describe()

    def describe(self, *, px_per_unit: float = 1.0) -> str:
        """Describe the scale in one line, in the unit that `resolution=` takes.

        Parameters
        ----------
        px_per_unit
            Pixels per unit of a vector drawing; 1 where pixels are the unit.

        Returns
        -------
        str
            Such as "0.0125 m per pixel by doors, confidence 0.60".
        """
        unit = "pixel" if px_per_unit == 1 else "drawing unit"
        metres = self.resolution * px_per_unit
        return f"{metres:.3g} m per {unit} by {self.source}, confidence {self.confidence:.2f}"


def find_stated_scale(
    sheet: Sheet, texts: Sequence[PlacedText], ink: Mask, *, given: float | None = None
) -> PlanScale | None:
    """The scale that the user, the file or a scale bar states; None where none of them does.

    ink: shape (H, W). given: metres per pixel of the user, per unit of a vector file.
    What the file and the bar state is passed over where no plan has such a size.
    Raises PlanError for a given one that is no positive number, or by which the sheet is no plan of a building.
    """
    longest = max(ink.shape)
    least, most = SHEET_METRES
    if given is not None:
        if not (isfinite(given) and given > 0):
            raise PlanError(f"the resolution is {given}, give positive metres per pixel")
        metres, of_file = given / sheet.px_per_unit, longest / sheet.px_per_unit
        if not least <= metres * longest <= most:
            units = "pixels" if sheet.px_per_unit == 1 else "drawing units"
            size = f"{metres * longest:.3g} m of a sheet of {of_file:.4g} {units}"
            raise PlanError(f"the resolution is {given}, which makes {size}, give that of a building")
        return PlanScale(metres, "the given resolution", 1.0)
    if sheet.resolution is not None and least <= sheet.resolution * longest <= most:
        return PlanScale(sheet.resolution, "the units of the file", 0.95)
    bar = parse_scale_bar(texts, ink)
    plausible = bar is not None and least <= bar.resolution * longest <= most
    return PlanScale(bar.resolution, "the scale bar", bar.confidence) if bar and plausible else None


def agree_on_doors(swings: Sequence[Swing], named: Floats) -> DoorSize | None:
    """The width of the doors; None where so few or so small ones agree that they may be letters.

    named: shape (N, 2, 2), doors that the file names; without any those with a swing count.
    """
    if len(named):
        widths = np.linalg.norm(np.diff(named, axis=1), axis=2)
        return DoorSize(float(np.median(widths)), len(named), 1.0)
    size = agree_on_size(swings)
    return size if size and size.count >= LEAST_DOORS and size.px >= LEAST_DOOR_PX else None


def are_surely_doors(doors: DoorSize | None, longest: int) -> bool:
    """Whether so many swings agree that nobody doubts them, on a sheet with a longer side of so many pixels."""
    return doors is not None and doors.count >= SURE_DOORS and longest <= LONGEST_SIDE * doors.px


def find_door_scale(doors: DoorSize | None, door_px: float) -> PlanScale:
    """The scale at which doors are 0.9 m wide.

    doors: those with a swing, None where they tell nothing. door_px: what the look of the drawing says, which stands
    where the two have nothing to do with each other.
    """
    if doors is None or not fits_doors(door_px, doors):
        return PlanScale(DOOR_WIDTH / door_px, "the look of its walls", SURE_BY_LOOK)
    count = f"{doors.count} door{'s' * (doors.count > 1)} of {DOOR_WIDTH} m"
    return PlanScale(DOOR_WIDTH / doors.px, count, SURE_BY_DOORS * doors.confidence)


def fits_doors(door_px: float, doors: DoorSize) -> bool:
    """Whether pixels of a door that fit_door_px found have to do with the doors that it was asked about."""
    return 0.99 * FACTORS[0] <= door_px / doors.px <= 1.01 * FACTORS[-1]


def fit_door_px(
    colors: Colors, *, door_px: float | None, is_sure: bool = False, networks: Sequence[str] = NETWORKS
) -> float:
    """Pixels that a door spans by the look of the drawing.

    colors: shape (H, W, 3). door_px: what is thought of it; what is smaller is tried, too, since a drawing's doors may
    be too wide for its rooms. is_sure: nothing else is tried.
    Where door_px makes the sheet longer than LONGEST_SIDE doors all that is larger is tried, too.
    The network was made with plans of one scale, and doubts least where a sheet has it; where it hardly minds and no
    door is known, a sheet is as large as most are. It is asked about the part of the sheet with the most ink.
    """
    longest = max(colors.shape[:2])
    least = DOOR_CELLS * sqrt(colors.shape[0] * colors.shape[1] / MOST_CELLS)
    near = [door_px * factor for factor in FACTORS] if door_px else []
    usual = [] if is_sure and near else [longest / side for side in SIDES]
    most = MOST_LARGER * door_px if door_px and longest <= LONGEST_SIDE * door_px else inf
    far = [size for size in usual if not door_px or size < near[0] or near[-1] < size <= most]
    sizes = [max(size, least) for size in (*near, *far)]
    density = cv2.blur(measure_contrast(colors), (longest // 8 + 1, longest // 8 + 1))
    middle = np.array(np.unravel_index(int(density.argmax()), density.shape))
    doubts: dict[float, float] = {}

    def doubt(size: float) -> float:
        if size not in doubts:
            part = _cut_out(colors, middle, side=max(1, round(ASKED_CELLS * size / DOOR_CELLS)))
            strange = 0.0 if door_px else (log(longest / size / USUAL_SIDE) / SPREAD_OF_SIDES) ** 2 / 2
            doubts[size] = measure_doubt(find_regions(part, door_px=size, networks=networks[:1])) + PRIOR * strange
        return doubts[size]

    best = min(sizes, key=lambda size: doubt(size) + LESS_DOUBT * (size in far))
    low, high = (near[0], near[-1]) if best in near else (0.0, inf)
    beside = [size for size in (best / STEP, best * STEP) if max(low, least) <= size <= high]
    return float(min((best, *beside), key=doubt))


def _cut_out(colors: Colors, middle: NDArray[np.int64], *, side: int) -> Colors:
    """A square of a sheet around a place, row and col, or as near to it as the sheet goes on."""
    low = np.clip(middle - side // 2, 0, np.maximum(np.array(colors.shape[:2]) - side, 0))
    return colors[low[0] : low[0] + side, low[1] : low[1] + side]


def refine_by_sizes(scale: PlanScale, floors: Sequence[Floor], texts: Sequence[PlacedText], height: int) -> PlanScale:
    """The scale on which the sizes that are written in rooms agree with the rooms; the same where none are.

    floors: in pixels, y up. height: of the sheet, pixels.
    """
    bounds = np.array([room.polygon.bounds for floor in floors for room in floor.rooms]).reshape(-1, 4)
    left, low, right, high = bounds.T
    sizes = scale_from_dimensions(texts, np.column_stack([height - high, left, height - low, right]))
    if sizes is None or sizes.confidence < scale.confidence:
        return scale
    return PlanScale(sizes.resolution, "sizes written in rooms", sizes.confidence)
