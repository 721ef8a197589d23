"""The scale of a sheet whose rooms are known, by all its evidence together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log, sqrt

from pianta.io._files import count_noun
from pianta.io.drawings.pdf import INCH, PAPER_TOLERANCE, PAPERS, find_scaled_paper, find_written_scale, has_shape_of
from pianta.plan.doors.swings import DoorWidth
from pianta.plan.scale.dimension_lines import list_dimension_lines, measure_dimension_lines
from pianta.plan.scale.evidence import Measure, ScaleEvidence, combine_evidence
from pianta.plan.scale.room_evidence import by_look, home_probability, list_room_evidence
from pianta.plan.scale.sheet_scale import LOOK, SheetScale
from pianta.plan.scale.sheet_scale import PARAMETERS as SHEET_PARAMETERS
from pianta.plan.scale.spaces import Space
from pianta.plan.scale.stairs import find_flights, measure_stairs
from pianta.plan.sheets.sheet import DOOR_WIDTH, PlacedText, PlanScale, Sheet
from pianta.plan.walls.segmentation import DOOR_CELLS


@dataclass(frozen=True, kw_only=True)
class RefinedScaleParameters:
    """Errors of the evidence from doors, scale bars and the network, of the logarithm of a length."""

    # The leaf of a door as it is drawn, m. In homes 0.61 to 0.86 by norms (EN 1529, BS 4787), and 0.6 to 0.87 on
    # six flats whose scale is known; elsewhere 0.86 to 0.985 (DIN 18101), 0.91 (three feet)
    home_door: float = 0.78
    home_door_sd: float = 0.16
    other_door: float = DOOR_WIDTH
    other_door_sd: float = 0.12
    least_outlier_rate: float = 0.1  # that curves which agree are no single doors
    odd_doors_outlier_rate: float = 0.6  # the same, if the look of the walls does not allow that width
    bar_sd: float = 0.02
    # A scale such as 1:100, if the picture is the paper: it may have been cropped, resized or printed to fit
    scanned_sd: float = 0.02
    whole_outlier_rate: float = 0.2  # of a picture that is as large as a paper, by its pixels per inch
    scanned_outlier_rate: float = 0.5  # of other pictures, by pixels per inch that are not those of screens
    paper_sd: float = 0.03
    paper_outlier_rate: float = 0.6  # of a picture with the shape of a paper
    # Pixels per inch of screens and cameras: below 100, and multiples up to 288, as 144 and 192 of dense screens
    min_scan: float = 100.0
    max_screen: float = 288.0
    screen_step: float = 24.0
    # The network was trained on schools and offices; there its best size is right within 1.26 on the median plan
    network_sd: float = 0.35
    network_outlier_rate: float = 0.2
    # The network sees a home again if it took doors for wider or narrower by a factor, unless the scale is doubtful.
    # It sees homes enlarged, since their walls are thin and their rooms small. By hand on the homes of `planfiles`
    home_share: float = 0.4  # of a door's pixels
    again_factor: float = 1.6
    again_area_factor: float = 2.5
    again_at_home: float = 0.5


PARAMETERS = RefinedScaleParameters()


def refine_scale(
    measured: SheetScale,
    sheet: Sheet,
    textless: Sheet,
    spaces: Sequence[Space],
    texts: Sequence[PlacedText],
) -> PlanScale:
    """The scale by everything that the sheet shows, unless the user or the file states it.

    textless: the sheet without its texts.
    """
    if measured.is_stated:
        return measured.scale
    at_home, longest = home_probability(spaces, texts), max(sheet.shape)
    evidence = [*list_room_evidence(spaces, texts), *_list_sheet_evidence(measured, at_home)]
    dimensions = measure_dimension_lines(list_dimension_lines(texts, sheet.ink))
    stairs = measure_stairs(find_flights(textless.contrast, textless.ink, texts))
    others = [dimensions, _by_written_scale(sheet, texts), stairs, by_look(spaces, at_home)]
    evidence += [each for each in others if each is not None]
    limits = SHEET_PARAMETERS.min_sheet / longest, SHEET_PARAMETERS.max_sheet / longest
    combined = combine_evidence(evidence, low=limits[0], high=limits[1])
    sources = [each.text for each in combined.agreeing if not each.is_look]
    return PlanScale(
        combined.resolution,
        ", ".join(sources) or LOOK,
        combined.certainty,
        interval=combined.usual,
        wide_interval=combined.wide,
        is_look=not sources,
    )


def scale_door_px(measured: SheetScale, scale: PlanScale, at_home: float, *, shape: tuple[int, int]) -> float | None:
    """Pixels of a door for the network to see a home at its size; None if it need not see the sheet again.

    at_home: probability that the sheet shows a home. shape: of the sheet, pixels.
    """
    p = PARAMETERS
    least = DOOR_CELLS * sqrt(shape[0] * shape[1] / SHEET_PARAMETERS.max_cells)
    door_px = max(p.home_share * DOOR_WIDTH / scale.resolution, least)
    # For a stated scale all sizes near it were tried
    is_known = not (measured.is_stated or scale.is_look) and scale.area_factor <= p.again_area_factor
    is_other = abs(log(door_px / measured.door_px)) > log(p.again_factor)
    return door_px if at_home > p.again_at_home and is_known and is_other else None


def _list_sheet_evidence(measured: SheetScale, at_home: float) -> list[ScaleEvidence]:
    """The evidence of the scale bar, the doors and the network. at_home: probability that the sheet shows a home."""
    p, evidence = PARAMETERS, []
    if measured.bar is not None:
        measure = Measure((measured.bar.resolution,), p.bar_sd)
        evidence.append(ScaleEvidence(measured.bar.source, (measure,), 0.0, 1 - measured.bar.confidence, 0.0))
    if measured.door_width is not None:
        evidence.append(_by_doors(measured.door_width, measured.doors_agree, at_home))
    if not measured.doors_agree:
        # On homes the network takes rooms for those of a school
        measure = Measure((DOOR_WIDTH / measured.door_px,), p.network_sd)
        outlier_rate = at_home + (1 - at_home) * p.network_outlier_rate
        evidence.append(ScaleEvidence(LOOK, (measure,), 0.0, outlier_rate, 0.0, is_look=True))
    return evidence


def _by_doors(width: DoorWidth, doors_agree: bool, at_home: float) -> ScaleEvidence:  # noqa: FBT001
    """The width on which doors agree is that of a leaf. doors_agree: whether the look of the walls allows it."""
    p = PARAMETERS
    outlier_rate = max(1 - width.confidence, p.least_outlier_rate if doors_agree else p.odd_doors_outlier_rate)
    metres = p.home_door**at_home * p.other_door ** (1 - at_home)
    sd = at_home * p.home_door_sd + (1 - at_home) * p.other_door_sd
    return ScaleEvidence(count_noun(width.count, "door"), (Measure((metres / width.px,), sd),), 0.0, outlier_rate, 0.0)


def _by_written_scale(sheet: Sheet, texts: Sequence[PlacedText]) -> ScaleEvidence | None:
    """A scale such as 1:100, if the picture is a paper whose size is known, or states the pixels per inch of a scan."""
    p, written = PARAMETERS, [text.text for text in texts]
    ratio, longest = find_written_scale(written), max(sheet.shape)
    if ratio is None:
        return None

    def on_paper(*inches: float, sd: float, outlier_rate: float) -> ScaleEvidence:
        """The scale if the longer side is that long."""
        measure = Measure(tuple(ratio * INCH * side / longest for side in inches), sd)
        return ScaleEvidence(f"1:{ratio}", (measure,), 0.0, outlier_rate, 0.0)

    stated = find_scaled_paper(written, sheet.shape)
    if stated is not None:
        return on_paper(stated, sd=p.scanned_sd, outlier_rate=p.whole_outlier_rate)
    alike = [max(sides) for paper, sides in PAPERS.items() if has_shape_of(paper, sheet.shape)]
    if sheet.px_per_inch is not None:
        side = longest / sheet.px_per_inch
        if any(abs(side / other - 1) <= PAPER_TOLERANCE for other in alike):
            return on_paper(side, sd=p.scanned_sd, outlier_rate=p.whole_outlier_rate)
        if not _is_of_screen(sheet.px_per_inch):
            return on_paper(side, sd=p.scanned_sd, outlier_rate=p.scanned_outlier_rate)
    return on_paper(*alike, sd=p.paper_sd, outlier_rate=p.paper_outlier_rate) if alike else None


def _is_of_screen(px_per_inch: float) -> bool:
    """Whether pixels per inch are those of screenshots and photos, which say nothing of a paper."""
    p = PARAMETERS
    steps = px_per_inch / p.screen_step
    return px_per_inch < p.min_scan or (px_per_inch <= p.max_screen + 1 and abs(steps - round(steps)) < 0.05)
