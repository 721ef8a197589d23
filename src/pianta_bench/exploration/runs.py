"""The runs of all policies in one building: from its starts through all of it, and to rooms that robots search for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite
from time import process_time

import numpy as np

from pianta.exploration.explore import explore
from pianta.exploration.record import Exploration
from pianta.exploration.starts import Point, find_rooms, find_starts
from pianta.exploration.world import World, build_world
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.exploration.buildings import ExploredBuilding
from pianta_bench.exploration.policies import ComparedPolicy
from pianta_bench.harness.records import Figures, Item, Results

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


@dataclass(frozen=True)
class Run:
    """A run of a policy from a start, numbered from 1; its figures are the records of its item.

    position: x, y of the start, m. label: what it searched for, None for an exploration. outcome: why it ended, empty
    if it failed. curve: of an exploration, metres to each share of CURVE, inf for never. distances: of an exploration,
    metres until a room of each label to search for was recognised.
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
    distances: Mapping[str, float] = field(default_factory=dict)

    @property
    def item(self) -> str:
        """Its name in the results."""
        return ", ".join([f"{self.building} start {self.start}", self.policy, *[self.label or ""] * bool(self.label)])

    @property
    def fields(self) -> dict[str, object]:
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
        """The building with walls and doors of the usual sizes."""
        return build_world(self.building.floor, resolution=self.settings.resolution)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """x, y of the starts, m."""
        points = find_starts(self.world)
        return tuple(points[: self.settings.starts or len(points)])

    @cached_property
    def sampler(self) -> FloorSampler | None:
        """Samples floors like the other buildings; None if no model fits."""
        if not self.building.others:
            return None
        return FloorSampler(learn_type(self.building.others, SCHEMAS[self.building.part]))

    def explore(self, policy: str, start: int, *, label: str | None = None) -> tuple[Exploration, float]:
        """A run from a start, numbered from 1, and its processor time, s."""
        compared = self.settings.policies[policy]
        chosen = compared.make(sampler=self.sampler if compared.predicts else None, find=label)
        began = process_time()
        run = explore(self.world, chosen, starts=[self.points[start - 1]], find=label, seed=self.settings.seed)
        return run, process_time() - began


def run_building(building: ExploredBuilding, settings: RunSettings) -> Results:
    """Explore a building with all policies from all starts, and search for its rooms; objects["runs"]: all `Run`s.

    Failures become items of the results.
    """
    prepared = PreparedBuilding(building, settings)

    def prepare() -> Iterator[Figures]:
        yield {METRES: float(len(prepared.points))}

    preparation = Results(objects={"runs": []})
    preparation.measure(building.part, building.name, prepare)
    if preparation.failed:
        return replace(preparation, records=[])
    results = Results()
    starts = range(1, len(prepared.points) + 1)
    runs = [_run(prepared, policy, start, results) for start in starts for policy in settings.policies]
    if settings.searches:
        runs += [search for start in starts for search in _search(prepared, start, runs, results)]
    results.objects["runs"] = runs
    return results


def _run(prepared: PreparedBuilding, policy: str, start: int, results: Results, *, label: str | None = None) -> Run:
    """One run, whose figures are added to the results."""
    building, explorations = prepared.building, list[Exploration]()

    def measure() -> Iterator[Figures]:
        exploration, seconds = prepared.explore(policy, start, label=label)
        explorations.append(exploration)
        yield {**_describe(exploration), SECONDS: seconds}
        if label is not None:
            yield {TO_ROOM: float(exploration.distance[-1]) if exploration.found_room is not None else None}
            return
        metres = {share: exploration.distance_to(share) for share in SHARES}
        yield {name_share(share): distance if isfinite(distance) else None for share, distance in metres.items()}

    run = Run(building.part, building.name, start, prepared.points[start - 1], policy, label)
    failed = dict.fromkeys((*METRICS, *([TO_ROOM] if label else map(name_share, SHARES))))
    results.measure(run.part, run.item, measure, failed=failed, **run.fields)
    if not explorations:
        return replace(run, failure=results.items[-1].failure)
    (exploration,) = explorations
    run = replace(run, outcome=exploration.outcome, failure=results.items[-1].failure)
    if label is not None:
        return run
    distances = {name: measure_search(prepared.world, exploration, name) for name in building.labels}
    return replace(
        run,
        curve=tuple(map(exploration.distance_to, CURVE)),
        distances={name: metres for name, metres in distances.items() if isfinite(metres)},
    )


def _describe(exploration: Exploration) -> dict[str, float]:
    return {
        METRES: float(exploration.distance[-1]),
        SHARE: float(exploration.share[-1]),
        AREA: exploration.reachable_area,
        DECISIONS: float(exploration.decisions),
        SCANS: float(len(exploration.area)),
    }


def _search(prepared: PreparedBuilding, start: int, runs: Sequence[Run], results: Results) -> Iterator[Run]:
    """The runs to each label from a start; those of classical policies are the beginnings of their explorations."""
    policies = prepared.settings.policies
    explorations = [run for run in runs if run.start == start and run.label is None]
    classical = [run for run in explorations if not policies[run.policy].predicts]
    # A label that no classical policy reaches cannot be reached.
    reachable = [label for label in prepared.building.labels if any(label in run.distances for run in classical)]
    for label in reachable:
        for exploration in explorations:
            if policies[exploration.policy].predicts:
                yield _run(prepared, exploration.policy, start, results, label=label)
                continue
            run = replace(exploration, label=label)
            results.items.append(Item(run.part, run.item, run.failure))
            results.add(run.part, run.item, {TO_ROOM: run.distances.get(label)}, **run.fields)
            yield run


def measure_search(world: World, exploration: Exploration, label: str) -> float:
    """Metres of an exploration until a room of a label was recognised; inf if none was."""
    metres = [
        distances.get(room, inf)
        for room in find_rooms(world.floor, [label])
        for distances in (exploration.recognised_at, exploration.entered_at)
    ]
    return min(metres, default=inf)
