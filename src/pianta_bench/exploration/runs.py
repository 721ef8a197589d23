"""The runs of all policies in one building: from its starts through all of it, and to rooms that robots search for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from math import inf, isfinite
from time import process_time
from typing import Any

import numpy as np

from pianta.exploration.explore import explore
from pianta.exploration.record import Exploration
from pianta.exploration.starts import Point, find_rooms, find_starts
from pianta.exploration.world import World, build_world, read_world
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.exploration.buildings import ExploredBuilding
from pianta_bench.exploration.campus import choose_starts, count_joined, join_cells
from pianta_bench.exploration.policies import ComparedPolicy
from pianta_bench.harness.records import NO_FIGURES, Figures, Item, Results

# Shares of the area of which the distances are in the tables, and those of the curves.
SHARES = (0.8, 0.9, 0.95, 0.99)
CURVE = tuple((np.arange(100) / 100).tolist())
TO_ROOM, METRES, SHARE, AREA = "metres to the room", "metres", "share", "area"
DECISIONS, SCANS, SECONDS = "decisions", "scans", "seconds"
METRICS = (METRES, SHARE, AREA, DECISIONS, SCANS, SECONDS)


def name_share(share: float) -> str:
    """The metric of the metres to a share."""
    return f"metres to {100 * share:.0f} %"


@dataclass(frozen=True)
class RunSettings:
    """How buildings are explored.

    policies: by name. starts: the most for each building, 0 for all. resolution: metres per cell.
    """

    policies: Mapping[str, ComparedPolicy]
    starts: int = 3
    resolution: float = 0.1
    searches: bool = True
    seed: int = 0


@dataclass
class Run:
    """A run of a policy from a start, numbered from 1; its figures are the records of its item.

    position: x, y of the start, m. label: what it searches for, None for an exploration. outcome: why it ended, empty
    if it failed. curve: of an exploration, metres to each share of CURVE, inf for never.
    """

    part: str
    building: str
    start: int
    position: Point
    policy: str
    label: str | None = None
    outcome: str = ""
    failure: str | None = None
    curve: tuple[float, ...] = ()

    @property
    def item(self) -> str:
        """Its name in the results."""
        label = f", {self.label}" if self.label else ""
        return f"{self.building} start {self.start}, {self.policy}{label}"

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of its records besides part, item and metric."""
        return {"building": self.building, "start": self.start, "policy": self.policy, "label": self.label}

    def as_json(self) -> dict[str, object]:
        """The run without its figures and its curve."""
        run = {"part": self.part, "item": self.item, **self.fields}
        return run | {"position": self.position, "outcome": self.outcome, "failure": self.failure}


@dataclass(frozen=True, eq=False)
class PreparedBuilding:
    """A building ready to be explored: its world, starts, and sampler are made once for all runs."""

    building: ExploredBuilding
    settings: RunSettings

    @cached_property
    def world(self) -> World:
        """The building with walls and doors of the usual sizes, or its map."""
        if self.building.grid is not None:
            return read_world(join_cells(self.building.grid, count_joined(self.settings.resolution)))
        return build_world(self.building.floor, resolution=self.settings.resolution)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """x, y of the starts, m."""
        points = find_starts(self.world) if self.building.grid is None else choose_starts(self.world)
        return tuple(points[: self.settings.starts or len(points)])

    @cached_property
    def sampler(self) -> FloorSampler | None:
        """Samples floors like the other buildings; None if no model fits."""
        if not self.building.others:
            return None
        return FloorSampler(learn_type(self.building.others, SCHEMAS[self.building.building_type]))

    def explore(self, policy: str, start: int, *, label: str | None = None) -> tuple[Exploration, float]:
        """A run from a start, numbered from 1, and its processor time, s."""
        compared = self.settings.policies[policy]
        chosen = compared.make(sampler=self.sampler if compared.predicts else None, find=label)
        began = process_time()
        run = explore(self.world, chosen, starts=[self.points[start - 1]], find=label, seed=self.settings.seed)
        return run, process_time() - began


def run_building(building: ExploredBuilding, settings: RunSettings) -> Results:
    """Explore a building with all policies from all starts, and search for its rooms; objects["runs"]: each `Run`."""
    prepared, results = PreparedBuilding(building, settings), Results(objects={"runs": []})
    results.measure(building.part, building.name, lambda: [NO_FIGURES] * len(prepared.points))
    if not results.failed:
        results.items.clear()  # the runs are the items
        for start in range(1, len(prepared.points) + 1):
            _run_from(prepared, start, results)
    return results


def _run_from(prepared: PreparedBuilding, start: int, results: Results) -> None:
    """All runs from a start. The searches of classical policies are the beginnings of their explorations."""
    building, policies = prepared.building, prepared.settings.policies
    new_run = partial(Run, building.part, building.name, start, prepared.points[start - 1])
    runs = {policy: new_run(policy) for policy in policies}
    explorations = {policy: _measure_run(prepared, run, results) for policy, run in runs.items()}
    for label in building.labels if prepared.settings.searches else ():
        metres = {
            policy: measure_search(prepared.world, exploration, label) if exploration else inf
            for policy, exploration in explorations.items()
            if not policies[policy].predicts
        }
        if not isfinite(min(metres.values(), default=inf)):
            continue  # what no classical policy reaches cannot be reached
        for policy in policies:
            run = new_run(policy, label)
            if policies[policy].predicts:
                _measure_run(prepared, run, results)
                continue
            run.outcome, run.failure = runs[policy].outcome, runs[policy].failure
            results.items.append(Item(run.part, run.item, run.failure))
            reached = metres[policy] if isfinite(metres[policy]) else None
            results.add(run.part, run.item, {TO_ROOM: reached}, **run.fields)
            results.objects["runs"].append(run)


def _measure_run(prepared: PreparedBuilding, run: Run, results: Results) -> Exploration | None:
    """Drive one run, and add it with its figures to the results; None if it failed."""
    explorations: list[Exploration] = []

    def measure() -> Iterator[Figures]:
        exploration, seconds = prepared.explore(run.policy, run.start, label=run.label)
        explorations.append(exploration)
        yield {
            METRES: float(exploration.distance[-1]),
            SHARE: float(exploration.share[-1]),
            AREA: exploration.reachable_area,
            DECISIONS: float(exploration.decisions),
            SCANS: float(len(exploration.area)),
            SECONDS: seconds,
        }
        if run.label is not None:
            is_found = exploration.outcome.startswith("found ")
            yield {TO_ROOM: float(exploration.distance[-1]) if is_found else None}
            return
        metres = {share: exploration.distance_to(share) for share in SHARES}
        yield {name_share(share): distance if isfinite(distance) else None for share, distance in metres.items()}

    failed = dict.fromkeys((*METRICS, *([TO_ROOM] if run.label else map(name_share, SHARES))))
    results.measure(run.part, run.item, measure, failed=failed, **run.fields)
    results.objects["runs"].append(run)
    run.failure = results.items[-1].failure
    if not explorations:
        return None
    (exploration,) = explorations
    run.outcome = exploration.outcome
    run.curve = tuple(map(exploration.distance_to, CURVE)) if run.label is None else ()
    return exploration


def measure_search(world: World, exploration: Exploration, label: str) -> float:
    """Metres of an exploration until a room of a label was recognised; inf if none was."""
    metres = [
        distances.get(room, inf)
        for room in find_rooms(world.floor, [label])
        for distances in (exploration.recognised_at, exploration.entered_at)
    ]
    return min(metres, default=inf)
