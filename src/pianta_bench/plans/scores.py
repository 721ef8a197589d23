"""How well a plan was read: found floors put on the truth by their pixels, and what they score."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, unary_union

from pianta.errors import PlanError
from pianta.evaluation.coverage import score_layout
from pianta.evaluation.doors import DetectionScores, score_connections, score_doors
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta_bench.harness.table import Column, Figures
from pianta_bench.plans.plan_sets import DOOR_METRES, TruePlan

SCORES = {"a_fc": "A_FC", "a_bc": "A_BC", "precision": "prec.", "recall": "recall", "mean_iou": "IoU", "f1": "F1"}
LINKS = {"doors": "doors", "edges": "edges"}
COLUMNS = (
    *(Column(key, heading, "%", failed=0.0) for key, heading in SCORES.items()),
    *(Column(f"{key}_{of}", f"{key}\n{of}", "%", failed=0.0) for key in LINKS for of in ("precision", "recall", "f1")),
    Column("found", "rooms\nfound", "rooms", failed=0),
    Column("true", "rooms\ntrue", "rooms"),
    Column("floors", "floors", "floors found on the sheet"),
    Column("aside", "aside", "% of the found area, in floors that the truth does not tell of"),
    Column("scale_error", "scale\nerror", "%, found metres per pixel against true ones"),
    Column("seconds", "time\ns", "s"),
    Column("megapixels", "Mpx", "million pixels"),
)


class ScaleRead(Protocol):
    """What the bench needs of a scale: metres per pixel, and where they are from."""

    @property
    def resolution(self) -> float:
        """Metres per pixel."""

    @property
    def source(self) -> str:
        """What tells it."""


class FloorRead(Protocol):
    """What the bench needs of a floor that was read from a sheet."""

    @property
    def floor(self) -> Floor:
        """Its rooms and doors, metres."""

    @property
    def grid(self) -> GridMap:
        """Its frame, of the sheet's pixels."""

    @property
    def scale(self) -> ScaleRead:
        """Its scale."""


class PlanRead(Protocol):
    """What the bench needs of a reading: one floor or more."""

    @property
    def floors(self) -> Sequence[FloorRead]:
        """The largest first."""


def score_reading(reading: PlanRead, plan: TruePlan) -> Figures:
    """The figures of COLUMNS but for the time; shares in percent.

    Found floors are put on the truth by their pixels, so that a wrong scale is no fault of rooms and doors. Doors are
    right within half the width of a true one, openings being none; edges are the pairs of rooms that either joins.
    """
    found, aside = judge_floors(reading.floors, plan)
    rooms = score_layout([room.polygon for room in found.rooms], [room.polygon for room in plan.truth.rooms])
    shares = {key: 100 * getattr(rooms, key) for key in SCORES}
    shares |= _describe_links("doors", score_doors(_without_openings(found), plan.truth))
    shares |= _describe_links("edges", score_connections(found, plan.truth))
    error = 100 * (reading.floors[0].scale.resolution / plan.grid.resolution - 1) if reading.floors else None
    counts = {"found": len(found.rooms), "true": len(plan.truth.rooms), "floors": len(reading.floors)}
    return {**shares, **counts, "aside": 100 * aside, "scale_error": error}


def judge_floors(floors: Sequence[FloorRead], plan: TruePlan) -> tuple[Floor, float]:
    """The found floors that the truth tells of, as one in its frame, and the share of the found area in the others.

    A sheet may show two floors while the truth tells of one. A floor that was found alone is judged whole. Of several,
    those are judged, with all their rooms, of which more than half lies on the true rooms and the walls between them;
    the others are neither right nor wrong. Where none does, all are judged. So nobody gains by finding more, and two
    floors that were found as one are judged as one.
    Raises PlanError for a floor whose grid has not the shape of the sheet.
    """
    moved = [move_floor(one.floor, one.grid, plan.grid) for one in floors]
    bodies = [_body_of(floor) for floor in moved]
    extent = _body_of(plan.truth).buffer(DOOR_METRES, join_style="mitre").buffer(-DOOR_METRES, join_style="mitre")
    told = [2 * body.intersection(extent).area > body.area for body in bodies]
    judged = [keep or len(moved) == 1 or not any(told) for keep in told]
    whole = sum(body.area for body in bodies)
    aside = sum(body.area for body, keep in zip(bodies, judged, strict=True) if not keep)
    return merge_floors(
        [floor for floor, keep in zip(moved, judged, strict=True) if keep]
    ), aside / whole if whole else 0


def move_floor(floor: Floor, start: GridMap, goal: GridMap) -> Floor:
    """The floor where its pixels of one grid lie in the map frame of another of the same shape.

    Raises PlanError when the shapes differ.
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
    """One floor with the rooms and doors of all, numbered on."""
    rooms: list[Room] = []
    doors: list[Door] = []
    for floor in floors:
        ids = {room.id: number for number, room in enumerate(floor.rooms, start=len(rooms) + 1)}
        rooms += [replace(room, id=ids[room.id]) for room in floor.rooms]
        doors += [door.renumber_rooms(ids) for door in floor.doors]
    return Floor(tuple(rooms), tuple(doors))


def _without_openings(floor: Floor) -> Floor:
    return replace(floor, doors=tuple(door for door in floor.doors if door.kind == "door"))


def _body_of(floor: Floor) -> Polygon:
    return unary_union([room.polygon for room in floor.rooms])


def _describe_links(name: str, scores: DetectionScores) -> dict[str, float]:
    """Precision, recall and their harmonic mean, percent."""
    precision, recall = scores.precision, scores.recall
    f1 = 2 * precision * recall / (precision + recall) if precision + recall else 0.0
    return {f"{name}_precision": 100 * precision, f"{name}_recall": 100 * recall, f"{name}_f1": 100 * f1}
