"""What shows the scale of a sheet before its rooms are known: what is stated, doors, and the look of its walls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, log, sqrt

import cv2
import numpy as np

from pianta._types import Colors, Floats, Indices
from pianta.errors import PlanError
from pianta.plan.doors.swings import DoorWidth, Swing, consensus_door_width, find_swings
from pianta.plan.sheets.sheet import DOOR_WIDTH, PlacedText, PlanScale, Sheet
from pianta.plan.text.dimensions import SCALE_BAR, parse_scale_bar
from pianta.plan.walls.segmentation import DOOR_CELLS, NETWORKS, mean_entropy, segment_sheet


@dataclass(frozen=True, kw_only=True)
class ScaleParameters:
    """Thresholds of `find_scale`; a sheet's length is its longer side, a door's width is `DOOR_WIDTH`.

    Chosen by hand on plans of schools and offices, which are longer than flats; no fit is on record.
    """

    min_sheet: float = 2.0  # m of length of a sheet, at least: what states less is wrong
    max_sheet: float = 5000.0  # m, at most
    # The doors that are drawn with a swing
    min_doors: int = 3  # swings of one radius that are needed
    min_door_px: float = 8.0  # px of their width
    n_certain_doors: int = 8  # with at least as many, all are doors, and no other scale is tried
    max_sheet_doors: float = 250.0  # door widths of length; on longer sheets the swings are letters
    min_swing: float = 0.5  # of the network's door; if drawn doors do not agree with it, smaller swings are dropped
    # Confidences, 0 … 1; those of scale bars are in text/dimensions.py
    confidence_of_file_units: float = 0.95
    confidence_of_doors: float = 0.6  # times that of their width: people draw doors as they like
    confidence_of_network_scale: float = 0.3  # of the scale at which the network is least uncertain
    # Candidate scales for the network
    door_factors: tuple[float, ...] = (0.5, 0.8, 1.0)  # of the drawn doors, which may be too wide for their rooms
    max_larger: float = 3.0  # other sizes are at most larger by this factor: arcs in furniture are not much smaller
    sheet_doors: tuple[float, ...] = (25.0, 40.0, 63.0, 100.0, 160.0)  # lengths in doors that are tried anyway
    neighbour_factor: float = 1.26  # from the best size to those that are tried next to it
    min_gain: float = 0.05  # nats by which another size must be less uncertain than those of the drawn doors
    usual_sheet_doors: float = 100.0  # length in doors of most sheets
    length_deviation: float = 0.42  # standard deviation of its logarithm
    length_weight: float = 0.04  # nats: weight of an unusual length, where no doors are drawn
    window_cells: int = 448  # cells of a side of the part of the sheet that the network is tried on
    max_cells: float = 4e6  # cells of a sheet, for the network's memory; larger sheets are read more coarsely


PARAMETERS = ScaleParameters()

LOOK = "the look of the drawing"


@dataclass(frozen=True, eq=False)
class SheetScale:
    """The first scale of a sheet, and what was measured for it.

    scale: metres per pixel. is_stated: whether the user or the file states it, so that nothing can refine it.
    bar: the scale by a scale bar, None without one. swings: the doors that are drawn with a swing. door_width: the
    width on which they agree, None if they do not. doors_agree: whether the look of the walls allows that width.
    door_px: pixels of a door for the network. drawn_door_px: pixels of the doors that are drawn, which may be too wide
    for their rooms.
    """

    scale: PlanScale
    is_stated: bool
    bar: PlanScale | None
    swings: tuple[Swing, ...]
    door_width: DoorWidth | None
    doors_agree: bool
    door_px: float
    drawn_door_px: float


def find_scale(
    sheet: Sheet,
    textless: Sheet,
    texts: Sequence[PlacedText],
    *,
    resolution: float | None = None,
    networks: Sequence[str] = NETWORKS,
) -> SheetScale:
    """The scale of a sheet: the stated one, or that of its doors, or the one at which the network is least uncertain.

    textless: the sheet without its texts. resolution: as of find_stated_scale.
    A stated scale that is less certain than doors counts only if the doors are less certain still.
    """
    swings = find_swings(np.maximum(textless.contrast, textless.ink))
    width = measure_door_width(swings, sheet.doors)
    stated = find_stated_scale(sheet, texts, resolution=resolution)
    certain = stated if stated and stated.confidence > PARAMETERS.confidence_of_doors else None
    expected_px = DOOR_WIDTH / certain.resolution if certain else width.px if width else None
    is_reliable = certain is not None or len(sheet.doors) > 0 or is_reliable_width(width, max(sheet.shape))
    door_px = fit_door_px(sheet, door_px=expected_px, is_reliable=is_reliable, networks=networks)
    drawn_width, agree = width, width is not None and agrees_with_doors(door_px, width)
    if width is not None and certain is None and not agree:
        # The curves that agreed are letters or furniture
        smallest = PARAMETERS.min_swing * door_px
        width, swings = None, tuple(swing for swing in swings if swing.radius >= smallest)
    candidates = filter(None, (stated, find_door_scale(width, door_px)))
    scale = certain or max(candidates, key=lambda scale: scale.confidence)
    is_bar = stated is not None and stated.source == SCALE_BAR
    return SheetScale(
        scale=scale,
        is_stated=certain is not None and not is_bar,
        bar=stated if is_bar else None,
        swings=swings,
        door_width=drawn_width,
        doors_agree=agree,
        door_px=door_px,
        drawn_door_px=width.px if width else door_px,
    )


def find_stated_scale(
    sheet: Sheet, texts: Sequence[PlacedText], *, resolution: float | None = None
) -> PlanScale | None:
    """The scale that the user, the file or a scale bar states; None if none of them does.

    resolution: metres per pixel from the user, per unit of a vector drawing.
    A scale of the file or the bar is ignored if no building has such a size.
    Raises PlanError if the user's is no positive number, or gives the sheet no size of a building.
    """
    longest = max(sheet.shape)

    def is_plausible(metres: float) -> bool:
        return PARAMETERS.min_sheet <= metres * longest <= PARAMETERS.max_sheet

    if resolution is not None:
        if not (isfinite(resolution) and resolution > 0):
            raise PlanError(f"the resolution is {resolution}, give positive metres per pixel")
        metres = resolution / sheet.px_per_unit
        if not is_plausible(metres):
            units = "pixels" if sheet.px_per_unit == 1 else "drawing units"
            size = f"{metres * longest:.3g} m of a sheet of {longest / sheet.px_per_unit:.4g} {units}"
            raise PlanError(f"the resolution is {resolution}, which makes {size}, give that of a building")
        return PlanScale(metres, "the given resolution", 1.0)
    if sheet.resolution is not None and is_plausible(sheet.resolution):
        return PlanScale(sheet.resolution, "the units of the file", PARAMETERS.confidence_of_file_units)
    bar = parse_scale_bar(texts, sheet.ink)
    return bar if bar is not None and is_plausible(bar.resolution) else None


def measure_door_width(swings: Sequence[Swing], named: Floats) -> DoorWidth | None:
    """The width of the doors of a sheet; None if so few or so small swings agree that they may be letters.

    named: shape (N, 2, 2), doors that the file names, which count before swings.
    """
    if len(named):
        widths = np.linalg.norm(np.diff(named, axis=1), axis=2)
        return DoorWidth(float(np.median(widths)), len(named), 1.0)
    width = consensus_door_width(swings)
    if width and width.count >= PARAMETERS.min_doors and width.px >= PARAMETERS.min_door_px:
        return width
    return None


def is_reliable_width(width: DoorWidth | None, longest: int) -> bool:
    """Whether enough swings agree to be doors for certain, on a sheet with a longer side of that many pixels."""
    if width is None or width.count < PARAMETERS.n_certain_doors:
        return False
    return longest <= PARAMETERS.max_sheet_doors * width.px


def find_door_scale(width: DoorWidth | None, door_px: float) -> PlanScale:
    """The scale at which doors are 0.9 m wide.

    width: of the doors that are drawn, None if unknown. door_px: pixels of a door by fit_door_px, which count if the
    drawn doors do not agree with them.
    """
    if width is None or not agrees_with_doors(door_px, width):
        return PlanScale(DOOR_WIDTH / door_px, LOOK, PARAMETERS.confidence_of_network_scale)
    count = f"{width.count} door{'s' * (width.count > 1)} of {DOOR_WIDTH} m"
    return PlanScale(DOOR_WIDTH / width.px, count, PARAMETERS.confidence_of_doors * width.confidence)


def agrees_with_doors(door_px: float, width: DoorWidth) -> bool:
    """Whether the result of fit_door_px is one of the sizes that it tried for the doors that are drawn."""
    factors = PARAMETERS.door_factors
    return 0.99 * factors[0] <= door_px / width.px <= 1.01 * factors[-1]


def fit_door_px(
    sheet: Sheet, *, door_px: float | None, is_reliable: bool = False, networks: Sequence[str] = NETWORKS
) -> float:
    """Pixels of a door at which the network is least uncertain about the part of the sheet with the most ink.

    The network was trained on plans of one scale. door_px: of the doors that are drawn, None if unknown; it is tried
    with smaller sizes, since drawn doors may be too wide for their rooms. is_reliable: whether no others are tried.
    Without drawn doors, an unusual length of the sheet counts against a size. If door_px makes the sheet longer than
    any is, all larger sizes are tried, too.
    """
    p, longest = PARAMETERS, max(sheet.shape)
    least = DOOR_CELLS * sqrt(sheet.shape[0] * sheet.shape[1] / p.max_cells)
    near = [door_px * factor for factor in p.door_factors] if door_px else []
    usual = [] if is_reliable and near else [longest / length for length in p.sheet_doors]
    most = p.max_larger * door_px if door_px and longest <= p.max_sheet_doors * door_px else inf
    far = [size for size in usual if not door_px or size < near[0] or near[-1] < size <= most]
    sizes = [max(size, least) for size in (*near, *far)]
    density = cv2.blur(sheet.contrast, (longest // 8 + 1, longest // 8 + 1))
    densest = np.array(np.unravel_index(int(density.argmax()), density.shape))
    uncertainties: dict[float, float] = {}

    def uncertainty(size: float) -> float:
        """Mean entropy, nats, with the cost of an unusual length."""
        if size not in uncertainties:
            window = _crop(sheet.colors, densest, side=max(1, round(p.window_cells * size / DOOR_CELLS)))
            class_map = segment_sheet(window, door_px=size, networks=networks[:1])
            deviation = 0.0 if door_px else (log(longest / size / p.usual_sheet_doors) / p.length_deviation) ** 2 / 2
            uncertainties[size] = mean_entropy(class_map) + p.length_weight * deviation
        return uncertainties[size]

    best = min(sizes, key=lambda size: uncertainty(size) + p.min_gain * (size in far))
    low, high = (near[0], near[-1]) if best in near else (0.0, inf)
    neighbours = [
        size for size in (best / p.neighbour_factor, best * p.neighbour_factor) if max(low, least) <= size <= high
    ]
    return float(min((best, *neighbours), key=uncertainty))


def _crop(colors: Colors, middle: Indices, *, side: int) -> Colors:
    """A square of a sheet around a row and col, or as near to it as the sheet allows."""
    low = np.clip(middle - side // 2, 0, np.maximum(np.array(colors.shape[:2]) - side, 0))
    return colors[low[0] : low[0] + side, low[1] : low[1] + side]
