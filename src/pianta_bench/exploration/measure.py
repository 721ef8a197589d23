"""Sections 8.3 and 8.4: how far robots drive to explore buildings, and to find a room, by each policy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np

from pianta.errors import OptionError
from pianta.exploration.beams import has_numba
from pianta.exploration.lidar import Lidar, Pose, scan
from pianta.exploration.world import build_world
from pianta.worlds.floors import make_floor
from pianta_bench.data.folders import find_data
from pianta_bench.exploration.buildings import (
    SYNTHETIC,
    BuildingSet,
    ExploredBuilding,
    check_sets,
    make_buildings,
    read_buildings,
)
from pianta_bench.exploration.policies import check_policies
from pianta_bench.exploration.runs import BuildingRuns, RunSettings, run_building
from pianta_bench.harness.comparison import Items
from pianta_bench.harness.table import Row

STARTS, RESOLUTION, SEED, JOBS = 3, 0.1, 0, 1
FINEST, COARSEST = 0.02, 0.5
# Scans that are timed, with numba and without.
TIMED = {True: 2000, False: 40}


@dataclass(frozen=True)
class ScanCost:
    """Scans a second of processor time on one core. numba: whether it did them."""

    beams: int
    scans_a_second: float
    numba: bool


@dataclass(frozen=True, eq=False)
class ExplorationBench:
    """What was measured. sets, results: by set; the buildings that could be read, and the runs in each of them."""

    settings: RunSettings
    sets: Mapping[str, BuildingSet]
    results: Mapping[str, Sequence[BuildingRuns]]
    scans: ScanCost

    @property
    def items(self) -> Items:
        """The figures of every run, and what failed, by set."""
        return {
            kind: [*self.sets[kind].failed, *(row for result in results for row in _list_rows(result))]
            for kind, results in self.results.items()
        }


def measure_exploration(
    data: Path | None = None,
    *,
    sets: Sequence[str] = (),
    policies: Sequence[str] = (),
    starts: int = STARTS,
    resolution: float = RESOLUTION,
    searches: bool = True,
    jobs: int = JOBS,
    seed: int = SEED,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> ExplorationBench:
    """Explore data/buildings/school/*.xml, office/*.xml and synthetic floors by each policy from several starts.

    What predicts learns from all other buildings of the type; for synthetic ones there is no model.
    data: as find_data takes it, not looked for where all is synthetic. sets, policies: all unless given.
    starts: at most so many of each building, 0 for all. resolution: metres per cell.
    searches: whether rooms are looked for. jobs: processes; figures do not depend on them.
    track: wraps the names of the buildings, to show progress.
    Raises OptionError for names that are none, and values without meaning; DataError where a set has no floor.
    """
    settings = RunSettings(check_policies(policies), starts, resolution, searches, seed)
    kinds = check_sets(sets)
    if not FINEST <= resolution <= COARSEST:
        raise OptionError(f"resolution is {resolution}, give {FINEST} to {COARSEST} m")
    if starts < 0 or jobs < 1:
        raise OptionError(f"starts are {starts} and jobs {jobs}, give 0 or more starts and 1 job or more")
    read = {kind: make_buildings() if kind == SYNTHETIC else read_buildings(find_data(data), kind) for kind in kinds}
    buildings = [building for of in read.values() for building in of.buildings]
    done = list(_run_all(buildings, settings, jobs, track))
    results = {kind: [result for result in done if result.kind == kind] for kind in kinds}
    return ExplorationBench(settings, read, results, time_scans())


def _run_all(
    buildings: Sequence[ExploredBuilding],
    settings: RunSettings,
    jobs: int,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> Iterable[BuildingRuns]:
    names = [f"{building.kind} {building.name}" for building in buildings]
    if jobs == 1:
        return (run_building(building, settings) for _, building in zip(track(names), buildings, strict=True))
    from joblib import Parallel, delayed

    made = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(run_building)(building, settings) for building in buildings
    )
    return (result for _, result in zip(track(names), made, strict=True))


def time_scans() -> ScanCost:
    """Time the lidar, with its noise, from free places of a synthetic building in cells of 0.1 m."""
    world, lidar, rng = build_world(make_floor("ring", seed=0)), Lidar(), np.random.default_rng(0)
    cells = np.argwhere(world.free)
    count = TIMED[has_numba()]
    chosen = cells[rng.integers(len(cells), size=count)].tolist()
    poses = [Pose(*world.point((row, col))) for row, col in chosen]
    # The first one compiles.
    scan(world, poses[0], lidar, rng)
    began = process_time()
    for pose in poses:
        scan(world, pose, lidar, rng)
    return ScanCost(lidar.beams, count / max(process_time() - began, 1e-9), has_numba())


def _list_rows(result: BuildingRuns) -> list[Row]:
    return [Row(result.name, {}, result.failure)] if result.failure else [run.row for run in result.runs]
