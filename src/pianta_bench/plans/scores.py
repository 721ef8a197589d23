"""How well a plan was read: its floors moved to the truth by their pixels, and their scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, unary_union

from pianta.errors import PlanError
from pianta.evaluation.coverage import score_layout
from pianta.evaluation.doors import DetectionScores, score_connections, score_doors
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.plan.read_plan import PlanFloor, PlanReading
from pianta_bench.harness.records import Figures
from pianta_bench.plans.plan_sets import DOOR_METRES, TruePlan

SCORES = ("a_fc", "a_bc", "precision", "recall", "mean_iou", "f1")
LINKS = ("doors", "edges")
PERCENT = (*SCORES, *(f"{link}_{score}" for link in LINKS for score in ("precision", "recall", "f1")))
# Of each metric.
UNITS = {
    **dict.fromkeys(PERCENT, "%"),
    "found": "rooms",
    "true": "rooms",
    "floors": "floors on the sheet",
    "unmatched": "% of the area, in floors that the truth does not have",
    "scale_error": "%, metres per pixel against true ones",
    "seconds": "s",
    "megapixels": "million pixels",
}
FAILED = {**dict.fromkeys(UNITS), **dict.fromkeys(PERCENT, 0.0), "found": 0}


def score_reading(reading: PlanReading, plan: TruePlan) -> Figures:
    """The figures of UNITS except time and size.

    Rooms and doors are moved to the truth by their pixels, so that a wrong scale does not affect their scores. A door
    is right within half the width of a true one, openings do not count; edges are the pairs of rooms that either joins.
    """
    floor, unmatched = match_floors(reading.floors, plan)
    rooms = score_layout([room.polygon for room in floor.rooms], [room.polygon for room in plan.truth.rooms])
    shares = {key: 100 * getattr(rooms, key) for key in SCORES}
    shares |= _describe_links("doors", score_doors(_without_openings(floor), plan.truth))
    shares |= _describe_links("edges", score_connections(floor, plan.truth))
    error = 100 * (reading.floors[0].scale.resolution / plan.grid.resolution - 1) if reading.floors else None
    counts = {"found": len(floor.rooms), "true": len(plan.truth.rooms), "floors": len(reading.floors)}
    return {**shares, **counts, "unmatched": 100 * unmatched, "scale_error": error}


def match_floors(floors: Sequence[PlanFloor], plan: TruePlan) -> tuple[Floor, float]:
    """The floors of a sheet that the truth has, as one in its frame, and the share of the area in the others.

    A sheet may show two floors while the truth has one. A floor alone always counts. Of several, those count, with all
    their rooms, that lie by more than half on the true rooms and the walls between them; the others are neither right
    nor wrong. If none does, all count. So more floors never score higher, and two floors that were read as one count
    as one.
    Raises PlanError if the grid of a floor does not have the shape of the sheet.
    """
    moved = [move_floor(one.floor, one.grid, plan.grid) for one in floors]
    outlines = [_outline(floor) for floor in moved]
    extent = _outline(plan.truth).buffer(DOOR_METRES, join_style="mitre").buffer(-DOOR_METRES, join_style="mitre")
    on_truth = [2 * outline.intersection(extent).area > outline.area for outline in outlines]
    matches = [match or len(moved) == 1 or not any(on_truth) for match in on_truth]
    area = sum(outline.area for outline in outlines)
    unmatched = sum(outline.area for outline, match in zip(outlines, matches, strict=True) if not match)
    matching = merge_floors([floor for floor, match in zip(moved, matches, strict=True) if match])
    return matching, unmatched / area if area else 0


def move_floor(floor: Floor, start: GridMap, goal: GridMap) -> Floor:
    """The floor, whose pixels are those of one grid, in the map frame of another grid of the same shape.

    Raises PlanError if the shapes differ.
    """
    if start.shape != goal.shape:
        raise PlanError(f"the floor has a grid of {start.shape} cells, give {goal.shape}, the pixels of its sheet")

    def move(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.column_stack(goal.pixel_to_map(*start.map_to_pixel(*xy.T)))

    def move_room(room: Room) -> Room:
        return replace(room, polygon=shapely.transform(room.polygon, move), predicted=None, confidence=None)

    def move_door(door: Door) -> Door:
        width = door.width * goal.resolution / start.resolution
        return replace(door, line=shapely.transform(door.line, move), width=width)

    return Floor(tuple(map(move_room, floor.rooms)), tuple(map(move_door, floor.doors)), source=floor.source)


def merge_floors(floors: Sequence[Floor]) -> Floor:
    """One floor with the rooms and doors of all; the numbers of rooms are continued."""
    rooms: list[Room] = []
    doors: list[Door] = []
    for floor in floors:
        ids = {room.id: number for number, room in enumerate(floor.rooms, start=len(rooms) + 1)}
        rooms += [replace(room, id=ids[room.id]) for room in floor.rooms]
        doors += [door.renumber_rooms(ids) for door in floor.doors]
    return Floor(tuple(rooms), tuple(doors))


def _without_openings(floor: Floor) -> Floor:
    return replace(floor, doors=tuple(door for door in floor.doors if door.kind == "door"))


def _outline(floor: Floor) -> Polygon:
    return unary_union([room.polygon for room in floor.rooms])


def _describe_links(name: str, scores: DetectionScores) -> dict[str, float]:
    """Precision, recall and their harmonic mean, percent."""
    precision, recall = scores.precision, scores.recall
    f1 = 2 * precision * recall / (precision + recall) if precision + recall else 0.0
    return {f"{name}_precision": 100 * precision, f"{name}_recall": 100 * recall, f"{name}_f1": 100 * f1}
