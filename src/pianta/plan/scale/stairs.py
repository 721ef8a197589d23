"""Flights of stairs, evenly spaced thin lines between two sides; and the scale by the usual depth of a tread."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.io._files import count_noun
from pianta.plan.scale.evidence import Measure, ScaleEvidence
from pianta.plan.sheets.binarization import Contrast
from pianta.plan.sheets.sheet import PlacedText

MAX_LINES = 10_000  # of one direction of a sheet, for time


@dataclass(frozen=True, kw_only=True)
class StairParameters:
    """Thresholds and errors of flights. The pitch is the distance of two treads, the length that of their lines.

    Chosen by hand on 47 plans of schools and offices and 15 others.
    """

    # Lines of treads
    thickest: float = 0.0025  # of the longer side of the sheet, for the stroke of a tread
    least_thickest_px: int = 3  # the same, at least
    min_length_px: int = 8
    bridged: int = 2  # thickest strokes of a gap in a tread: the line of walking and that of a break cross it
    level_px: float = 1.0  # by which the rows of its pieces differ
    # Runs of lines
    min_pitch_px: float = 5.0
    pitch_tolerance: float = 0.13  # pitches by which a distance is off
    pitch_tolerance_px: float = 1.0
    end_tolerance: float = 0.1  # lengths by which the ends of neighbours are off
    min_lines: int = 5
    max_lines: int = 30
    min_length: float = 2.6  # pitches: a flight of 0.7 m with treads of 0.27 m
    max_length: float = 8.0  # pitches
    # What is drawn between and around them
    max_stroke: float = 0.35  # pitches: thicker lines are no treads
    max_between: float = 0.2  # share of ink between two treads: grates and squared floors have more
    max_line_between: float = 0.35  # mean contrast along a line between two treads
    bounded: float = 0.7  # share of the height of a flight along which a side is drawn, on both sides
    next_line: float = 0.3  # share of ink along a row where the next tread is expected: the run goes on, cut or covered
    missing_lines: int = 1  # in a row, before a run ends
    end_wall: float = 0.6  # share of ink along a row that ends the space before a run
    landing: float = 1.5  # pitches of free space before or behind a flight: boards and tables fill theirs
    max_crossing: int = 2  # lines through all treads: those of walking and of a handrail; tiles have more
    board: float = 12.0  # pitches of lines, and
    min_boards: int = 6  # their number, from which on the floors of the sheet are hatched, and runs may be boards
    max_text: int = 4  # letters of a text between treads, such as UP: longer ones are in tables
    agreement: float = 1.3  # factor between the pitches of flights of one sheet
    min_agreeing: float = 0.75  # share of the flights that agree, or else some are tiers of seats, and which is unknown
    # The depth of a tread, m: 0.22 to 0.32 by norms; 0.24 to 0.30 on a dozen plans by their doors and written lengths
    tread: float = 0.275
    common_sd: float = 0.1
    flight_sd: float = 0.05  # between flights of one building
    outlier_rate: float = 0.15
    failure_rate: float = 0.1  # of one flight, and less of several


PARAMETERS = StairParameters()


@dataclass(frozen=True)
class Flight:
    """A flight of stairs on a sheet, of one run of treads.

    rows, cols: pixels, the first and the last. pitch: pixels from tread to tread. n_lines: of the treads.
    """

    rows: tuple[float, float]
    cols: tuple[float, float]
    pitch: float
    n_lines: int


def find_flights(contrast: Contrast, ink: Mask, texts: Sequence[PlacedText]) -> list[Flight]:
    """The flights of a sheet without its texts, whose treads are level or upright, the one with most treads first.

    None on a sheet whose floors are hatched with boards: in passages these look like treads.
    contrast, ink: shape (H, W), of the sheet. texts: that stood on it.
    """
    candidates = []
    for is_level in (True, False):
        # Upright treads are level on the turned sheet
        turned, pale = (ink, contrast) if is_level else (ink.T, contrast.T)
        for lines in _list_thin_lines(np.ascontiguousarray(turned)):
            runs = [lines[run] for run in _even_runs(lines)]
            if any(map(_are_boards, runs)):
                return []
            flights = [_make_flight(run) for run in runs if _is_flight(run, turned, pale)]
            candidates += flights if is_level else [_transpose(flight) for flight in flights]
    candidates = [flight for flight in candidates if not _holds_text(flight, texts)]
    distinct: list[Flight] = []
    for flight in sorted(candidates, key=lambda flight: -flight.n_lines):
        if not any(_overlap(flight, other) for other in distinct):
            distinct.append(flight)
    return distinct


def measure_stairs(flights: Sequence[Flight]) -> ScaleEvidence | None:
    """The scale by the usual depth of a tread; None without flights, or if they disagree."""
    p = PARAMETERS
    if not flights:
        return None
    pitches = np.array([flight.pitch for flight in flights])
    agreeing = pitches[np.abs(np.log(pitches / np.median(pitches))) <= np.log(p.agreement)]
    if len(agreeing) < p.min_agreeing * len(flights):
        return None
    measures = tuple(Measure((p.tread / pitch,), p.flight_sd) for pitch in agreeing.tolist())
    title = f"the steps of {count_noun(len(agreeing), 'flight')} of stairs"
    return ScaleEvidence(title, measures, p.common_sd, p.outlier_rate, p.failure_rate / len(measures))


def _list_thin_lines(ink: Mask) -> Iterator[Floats]:
    """Row, first column, column after the last, and thickness of level lines, shape (N, 4), from top to bottom.

    Once as drawn, and once with the pieces of interrupted lines joined. ink: shape (H, W).
    """
    p, image = PARAMETERS, ink.astype(np.uint8)
    thickest = max(p.least_thickest_px, round(p.thickest * max(ink.shape)))
    thick = cv2.morphologyEx(image, cv2.MORPH_OPEN, np.ones((thickest + 1, 1), np.uint8))
    lines = cv2.morphologyEx(image - thick, cv2.MORPH_OPEN, np.ones((1, p.min_length_px), np.uint8))
    stats, middles = (each[1:] for each in cv2.connectedComponentsWithStats(lines, connectivity=8)[2:])
    is_line = stats[:, cv2.CC_STAT_HEIGHT] <= thickest + 1
    left, width, _, area = stats[is_line].T[[0, 2, 3, 4]]
    pieces = np.column_stack([middles[is_line, 1], left, left + width, area / width])
    pieces = pieces[np.argsort(pieces[:, 0], kind="stable")][:MAX_LINES]
    yield pieces
    yield _join_pieces(pieces, p.bridged * thickest)


def _join_pieces(lines: Floats, gap: float) -> Floats:
    """Lines with those joined that go on behind a gap, from top to bottom; gap: pixels, at most."""
    in_order = lines[np.argsort(lines[:, 1], kind="stable")]
    joined = np.ones(len(lines), bool)
    # From right to left, so that what goes on is whole
    for index in range(len(lines) - 1, -1, -1):
        row, _, stop, _ = in_order[index]
        behind = slice(*np.searchsorted(in_order[:, 1], (stop, stop + gap + 1)))
        level = np.flatnonzero(joined[behind] & (np.abs(in_order[behind, 0] - row) <= PARAMETERS.level_px))
        if len(level):
            other = behind.start + int(level[0])
            in_order[index, 2], joined[other] = in_order[other, 2], False
    rest = in_order[joined]
    return rest[np.argsort(rest[:, 0], kind="stable")]


def _even_runs(lines: Floats) -> Iterator[Indices]:
    """The lines of each run, each of which lies below the one before, with the same ends, at the same distance."""
    p, following, used = PARAMETERS, _find_following(lines), np.zeros(len(lines), bool)
    for first in np.flatnonzero(following >= 0):
        run = [int(first)]
        while not used[run[-1]] and (below := int(following[run[-1]])) >= 0:
            if len(run) > 1:
                pitch = (lines[run[-1], 0] - lines[run[0], 0]) / (len(run) - 1)
                off = abs(lines[below, 0] - lines[run[-1], 0] - pitch)
                if off > max(p.pitch_tolerance * pitch, p.pitch_tolerance_px):
                    break
            run.append(below)
        if p.min_lines <= len(run) <= p.max_lines and not used[run].any():
            used[run] = True
            yield np.array(run)


def _find_following(lines: Floats) -> Indices:
    """The nearest line below each that has the same ends, -1 without one, shape (N,)."""
    p, following = PARAMETERS, np.full(len(lines), -1)
    rows, starts, stops = lines.T[:3]
    lengths = stops - starts
    nearest, farthest = (np.searchsorted(rows, rows + reach) for reach in (p.min_pitch_px, lengths / p.min_length))
    tolerances = p.end_tolerance * lengths
    for index in np.flatnonzero(nearest < farthest):
        near = slice(nearest[index], farthest[index])
        off = np.maximum(abs(starts[near] - starts[index]), abs(stops[near] - stops[index]))
        fitting = np.flatnonzero(off <= tolerances[index])
        if len(fitting):
            following[index] = near.start + fitting[0]
    return following


def _make_flight(run: Floats) -> Flight:
    """The flight of level treads; run: shape (N, 4), as of `_list_thin_lines`."""
    (top, bottom), (start, stop) = run[[0, -1], 0], np.median(run[:, 1:3], axis=0)
    pitch = (bottom - top) / (len(run) - 1)
    return Flight((float(top), float(bottom)), (float(start), float(stop)), float(pitch), len(run))


def _are_boards(run: Floats) -> bool:
    flight = _make_flight(run)
    return len(run) >= PARAMETERS.min_boards and flight.cols[1] - flight.cols[0] > PARAMETERS.board * flight.pitch


def _is_flight(run: Floats, ink: Mask, contrast: Contrast) -> bool:
    """Whether lines are treads by their length, and by what is drawn between and beside them."""
    p, flight = PARAMETERS, _make_flight(run)
    length, stroke = flight.cols[1] - flight.cols[0], float(np.median(run[:, 3]))
    if not p.min_length <= length / flight.pitch <= p.max_length or stroke > p.max_stroke * flight.pitch:
        return False
    inner = slice(round(flight.cols[0] + 0.1 * length), round(flight.cols[1] - 0.1 * length))
    half = stroke / 2 + 1
    gaps = [
        slice(int(np.ceil(row + half)), int(below - half) + 1)
        for row, below in zip(run[:-1, 0], run[1:, 0], strict=True)
    ]
    between = [float(ink[gap, inner].mean()) for gap in gaps]
    lines = [float(contrast[gap, inner].mean(axis=1).max()) for gap in gaps]
    if np.median(between) > p.max_between or np.median(lines) > p.max_line_between:
        return False
    crossing = np.concatenate([ink[gap, inner] for gap in gaps]).mean(axis=0) >= p.bounded
    if np.count_nonzero(crossing[1:] & ~crossing[:-1]) > p.max_crossing:
        return False
    if not all(_is_bounded(ink, gaps, round(col), reach=round(stroke) + 2) for col in flight.cols):
        return False
    along = np.asarray(ink[:, inner].mean(axis=1))
    top, bottom = flight.rows
    return _has_landing(along, bottom, flight.pitch) or _has_landing(along[::-1], len(along) - 1 - top, flight.pitch)


def _is_bounded(ink: Mask, gaps: Sequence[slice], col: int, *, reach: int) -> bool:
    """Whether something is drawn along a side of a flight, between the ends of its treads."""
    beside = slice(max(col - reach, 0), col + reach + 1)
    inked = np.concatenate([ink[gap, beside].any(axis=1) for gap in gaps])
    return bool(inked.mean() >= PARAMETERS.bounded)


def _has_landing(along: Floats, row: float, pitch: float) -> bool:
    """Whether the space behind a run of treads is free, where the run ends.

    along: share of ink in the columns of the treads, for each row. row: of the last tread of the run.
    """
    p, last, missing = PARAMETERS, row, 0
    while missing <= p.missing_lines:
        expected = last + (missing + 1) * pitch
        near = slice(round(expected - p.pitch_tolerance * pitch - 1), round(expected + p.pitch_tolerance * pitch) + 2)
        if near.stop > len(along) or along[near].max() < p.next_line:
            missing += 1
        else:
            last, missing = near.start + float(along[near].argmax()), 0
    # Where the stroke of the last tread ends
    behind = along[round(last + PARAMETERS.max_stroke * pitch) : round(last + p.landing * pitch)]
    return bool(len(behind) and behind.max() < p.end_wall)


def _transpose(flight: Flight) -> Flight:
    return Flight(flight.cols, flight.rows, flight.pitch, flight.n_lines)


def _holds_text(flight: Flight, texts: Sequence[PlacedText]) -> bool:
    """Whether a text stands among the treads that is longer than the direction in which they lead."""
    low, high = np.array([flight.rows, flight.cols]).T
    return any(
        len(text.text) > PARAMETERS.max_text and bool(((low <= text.middle) & (text.middle <= high)).all())
        for text in texts
    )


def _overlap(flight: Flight, other: Flight) -> bool:
    sides = [
        min(one[1], two[1]) - max(one[0], two[0]) for one, two in ((flight.rows, other.rows), (flight.cols, other.cols))
    ]
    return min(sides) > 0
