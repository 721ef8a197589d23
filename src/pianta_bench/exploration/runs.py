"""The runs of all policies in one building: from its starts through all of it, and to the rooms that are looked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
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
from pianta_bench.exploration.policies import CONTENDERS
from pianta_bench.harness.table import Column, Figures, Row, measure_row

SHARES = (0.8, 0.9, 0.95, 0.99)
CURVE = tuple((np.arange(100) / 100).tolist())
FOUND, METRES, SHARE, AREA = "metres to the room", "metres", "share", "area"
DECISIONS, SCANS, SECONDS = "decisions", "scans", "seconds"
COLUMNS = tuple(Column(key, key, "") for key in (METRES, SHARE, AREA, DECISIONS, SCANS, SECONDS))


def name_share(share: float) -> str:
    """The key of the metres to a share."""
    return f"metres to {100 * share:.0f} %"


@dataclass(frozen=True)
class RunSettings:
    """How buildings are explored. starts: at most so many of each, 0 for all. resolution: metres per cell."""

    policies: tuple[str, ...]
    starts: int = 3
    resolution: float = 0.1
    searches: bool = True
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Run:
    """A run of a policy from a start, by its number. label: what was looked for, None when all was explored.

    row: its figures. outcome: why it ended, empty for one that failed. curve: metres to each share of CURVE, inf for
    never. found: of an exploration, metres to each label to be looked for that came into sight.
    """

    start: int
    policy: str
    label: str | None
    row: Row
    outcome: str = ""
    curve: tuple[float, ...] = ()
    found: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class BuildingRuns:
    """All runs in a building. points: x, y of each start. failure: why there are no runs."""

    kind: str
    name: str
    points: tuple[Point, ...] = ()
    runs: tuple[Run, ...] = ()
    failure: str | None = None


@dataclass(frozen=True, eq=False)
class BuildingAtWork:
    """A building while it is explored: its world, starts, and sampler, made once for all runs."""

    building: ExploredBuilding
    settings: RunSettings

    @cached_property
    def world(self) -> World:
        """The building with walls and doors of the usual sizes."""
        return build_world(self.building.floor, resolution=self.settings.resolution)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """x, y of the starts."""
        points = find_starts(self.world)
        return tuple(points[: self.settings.starts or len(points)])

    @cached_property
    def sampler(self) -> FloorSampler | None:
        """Samples floors as those of the other buildings; None where no model fits."""
        if not self.building.others:
            return None
        return FloorSampler(learn_type(self.building.others, SCHEMAS[self.building.kind]))

    def explore(self, policy: str, start: int, *, label: str | None = None) -> tuple[Exploration, float]:
        """A run, and the seconds of the processor that it took."""
        contender = CONTENDERS[policy]
        chosen = contender.make(self.sampler if contender.predicts else None, label)
        began = process_time()
        run = explore(self.world, chosen, starts=[self.points[start]], find=label, seed=self.settings.seed)
        return run, process_time() - began


def run_building(building: ExploredBuilding, settings: RunSettings) -> BuildingRuns:
    """Explore a building by all policies from all starts, and look for its rooms; what fails is told, not raised."""
    work, name = BuildingAtWork(building, settings), building.name

    def begin(_: str) -> Iterator[Figures]:
        yield {METRES: float(len(work.points))}

    begun = measure_row(name, begin, columns=COLUMNS)
    if begun.failure:
        return BuildingRuns(building.kind, name, failure=begun.failure)
    runs = [_run(work, policy, start) for start in range(len(work.points)) for policy in settings.policies]
    if settings.searches:
        runs += [found for start in range(len(work.points)) for found in _search(work, start, runs)]
    return BuildingRuns(building.kind, name, work.points, tuple(runs))


def _run(work: BuildingAtWork, policy: str, start: int, *, label: str | None = None) -> Run:
    """One run, and what it found."""
    made: list[Exploration] = []

    def measure(_: str) -> Iterator[Figures]:
        run, seconds = work.explore(policy, start, label=label)
        made.append(run)
        yield {**_describe(run), SECONDS: seconds}
        reached = {share: run.distance_to(share) for share in SHARES} if label is None else {}
        yield {name_share(share): metres if isfinite(metres) else None for share, metres in reached.items()}
        if label is not None:
            yield {FOUND: float(run.distance[-1]) if run.found_room is not None else None}

    looked = f", {label}" if label else ""
    row = measure_row(f"{work.building.name} start {start + 1}, {policy}{looked}", measure, columns=COLUMNS)
    if not made:
        return Run(start, policy, label, row)
    (run,) = made
    if label is not None:
        return Run(start, policy, label, row, run.outcome)
    found = {name: metres for name in work.building.labels if isfinite(metres := measure_search(work.world, run, name))}
    return Run(start, policy, None, row, run.outcome, tuple(map(run.distance_to, CURVE)), found)


def _describe(run: Exploration) -> dict[str, float]:
    return {
        METRES: float(run.distance[-1]),
        SHARE: float(run.share[-1]),
        AREA: run.reachable_area,
        DECISIONS: float(run.decisions),
        SCANS: float(len(run.area)),
    }


def _search(work: BuildingAtWork, start: int, runs: Sequence[Run]) -> Iterator[Run]:
    """The runs to each label from a start; those of classical policies are the beginnings of their explorations."""
    explorations = {run.policy: run for run in runs if run.start == start and run.label is None}
    classical = [run for policy, run in explorations.items() if not CONTENDERS[policy].predicts]
    # What no classical policy finds cannot be reached.
    there = [label for label in work.building.labels if any(label in run.found for run in classical)]
    for label in there:
        for policy, run in explorations.items():
            if CONTENDERS[policy].predicts:
                yield _run(work, policy, start, label=label)
                continue
            item = f"{work.building.name} start {start + 1}, {policy}, {label}"
            row = Row(item, {FOUND: run.found.get(label)}, run.row.failure)
            yield Run(start, policy, label, row, run.outcome)


def measure_search(world: World, run: Exploration, label: str) -> float:
    """Metres of an exploration until a room of a label was recognised; inf when none was."""
    known = [
        at.get(room, float("inf"))
        for room in find_rooms(world.floor, [label])
        for at in (run.recognised_at, run.entered_at)
    ]
    return min(known, default=float("inf"))
