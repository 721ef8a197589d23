"""Metres per unit of a vector plan with exact rooms: by written areas, the file, doors, or the usual size of rooms."""

from __future__ import annotations

from collections.abc import Sequence
from math import log, sqrt

import numpy as np

from pianta._types import Floats
from pianta.io._files import count_noun
from pianta.io.drawings._drawing import PlanDrawing
from pianta.plan.drawn_rooms.outlines import DrawnRoom
from pianta.plan.sheets.sheet import DOOR_WIDTH, PlanScale

# Metres of the units in which buildings are drawn: mm, cm, m, inch, foot.
UNITS = (0.001, 0.01, 1.0, 0.0254, 0.3048)
MIN_ROOMS = 2  # whose written areas agree
AGREEMENT = 0.12  # share of lengths: areas are net, gross or rounded
SNAP = 0.08  # share of lengths by which a unit is taken for that of the written areas
USUAL_ROOM = 15.0  # m²: of offices and bedrooms, between closets and halls
# Confidences, 0 … 1: of a file's units as elsewhere; written areas are right if they agree.
AREAS_CONFIDENCE = 0.95
FILE_CONFIDENCE = 0.95
DOORS_CONFIDENCE = 0.8
ROOMS_CONFIDENCE = 0.4
# Factors within which lengths are right in 80 % of all plans; chosen by hand.
DOORS_FACTOR = 1.2
ROOMS_FACTOR = 1.8


def find_unit(drawing: PlanDrawing, rooms: Sequence[DrawnRoom], *, resolution: float | None = None) -> PlanScale:
    """Metres per drawing unit, where they come from, and how certain they are.

    resolution: what the user gives. The areas written in rooms count before the unit of the file, if at least two
    agree: headers are often those of a template. Without both the unit is the one in which doors, else rooms, are as
    large as usual; on paper any scale is possible.
    """
    if resolution is not None:
        return PlanScale(resolution, "the given resolution", 1.0)
    written = unit_by_areas(rooms, drawing.metres_per_unit)
    if written is not None:
        return written
    if drawing.metres_per_unit is not None:
        return PlanScale(drawing.metres_per_unit, "the units of the file", FILE_CONFIDENCE)
    doors = drawing.doors if len(drawing.doors) else drawing.unnamed_doors
    if len(doors):
        width = float(np.median(np.linalg.norm(np.diff(doors, axis=1), axis=2)))
        if width > 0:
            source = f"{count_noun(len(doors), 'door')} of about {DOOR_WIDTH} m"
            return _scale_of(drawing, DOOR_WIDTH / width, source, DOORS_CONFIDENCE, DOORS_FACTOR)
    side = sqrt(float(np.median([room.polygon.area for room in rooms])))
    return _scale_of(drawing, sqrt(USUAL_ROOM) / side, "the usual size of rooms", ROOMS_CONFIDENCE, ROOMS_FACTOR)


def _scale_of(drawing: PlanDrawing, metres: float, source: str, confidence: float, factor: float) -> PlanScale:
    """The scale by a length: the nearest unit of CAD, or on paper any, within the factor in 80 % of all plans."""
    if not drawing.is_on_paper:
        return PlanScale(_nearest_unit(metres), source, confidence)
    interval, wide = ((metres / each, metres * each) for each in (factor, factor ** (1.96 / 1.28)))
    return PlanScale(metres, source, confidence, interval, wide)


def unit_by_areas(rooms: Sequence[DrawnRoom], stated: float | None) -> PlanScale | None:
    """The unit by which most rooms have the areas that are written in them; None unless enough agree."""
    ratios = np.array([sqrt(room.stated / room.polygon.area) for room in rooms if room.stated])
    if len(ratios) < MIN_ROOMS:
        return None
    middle = float(np.median(ratios))
    agreeing = int((np.abs(ratios / middle - 1) <= AGREEMENT).sum())
    if agreeing < max(MIN_ROOMS, len(ratios) / 2):
        return None
    if stated is not None and abs(middle / stated - 1) <= SNAP:
        return PlanScale(stated, f"the units of the file and the areas written in {agreeing} rooms", AREAS_CONFIDENCE)
    near = [unit for unit in UNITS if abs(middle / unit - 1) <= SNAP]
    return PlanScale(near[0] if near else middle, f"the areas written in {agreeing} rooms", AREAS_CONFIDENCE)


def _nearest_unit(metres: float) -> float:
    return min(UNITS, key=lambda unit: abs(log(unit / metres)))


def lengths_of(lines: Floats) -> Floats:
    """The lengths of lines, shape (N, 2, 2)."""
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))
