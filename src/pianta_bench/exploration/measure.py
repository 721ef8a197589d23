"""How far robots drive to explore buildings, and to find a room, with each policy (sections 8.3 and 8.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np

from pianta.errors import OptionError
from pianta.exploration.beams import has_numba
from pianta.exploration.lidar import Lidar, Pose, scan
from pianta.exploration.world import build_world
from pianta.worlds.floors import make_floor
from pianta_bench.data.folders import find_data
from pianta_bench.exploration import CAMPUS, DRAWN_SET, SYNTHETIC
from pianta_bench.exploration.buildings import (
    BuildingSet,
    choose_sets,
    draw_buildings,
    make_buildings,
    read_buildings,
)
from pianta_bench.exploration.campus import count_joined, read_campus
from pianta_bench.exploration.policies import COMPARED_POLICIES, ComparedPolicy, choose_policies
from pianta_bench.exploration.runs import SHARES, TO_ROOM, Run, RunSettings, name_share, run_building
from pianta_bench.exploration.scores import pair_runs
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Item, Results, Track

# Limits of the resolution, metres per cell.
FINEST, COARSEST = 0.02, 0.5
# Scans that are timed, by whether there is numba.
TIMED = {True: 2000, False: 40}


def measure(
    data: Path | None = None,
    *,
    sets: Sequence[str] | None = None,
    policies: Sequence[str] | None = None,
    starts: int = 3,
    resolution: float = 0.1,
    searches: bool = True,
    jobs: int = 1,
    seed: int = 0,
    track: Track = iter,
    registry: Mapping[str, ComparedPolicy] = COMPARED_POLICIES,
) -> Results:
    """Explore data/buildings/school/*.xml, office/*.xml, synthetic floors, drawn schools, campus floors by each policy.

    Policies that predict learn from all other buildings of the type, in drawn schools from those of the data; for
    synthetic ones and campus floors there is no model.
    data: as of `find_data`, not needed if all buildings are synthetic. sets: DEFAULT_SETS, policies: all by
    default.
    starts: the most for each building, 0 for all. resolution: metres per cell.
    searches: whether robots also search for rooms. jobs: processes; figures do not depend on them.
    track: wraps the names of the buildings, to show progress. registry: the policies to choose from.
    Raises OptionError for unknown names and invalid values; DataError if a set has no floor.
    """
    settings = RunSettings(choose_policies(policies or (), registry), starts, resolution, searches, seed)
    chosen = choose_sets(sets or ())
    if not FINEST <= resolution <= COARSEST:
        raise OptionError(f"resolution is {resolution}, give {FINEST} to {COARSEST} m")
    if CAMPUS in chosen:
        count_joined(resolution)
    if starts < 0 or jobs < 1:
        raise OptionError(f"starts are {starts} and jobs {jobs}, give 0 or more starts and 1 job or more")
    options = {"policies": [*settings.policies], "starts": starts, "resolution": resolution, "searches": searches}
    results = Results({"sets": chosen, **options, "seed": seed})
    read = {part: list_buildings(part, data) for part in chosen}
    for part, building_set in read.items():
        results.items += [Item(part, name, reason) for name, reason in building_set.failures.items()]
    buildings = [building for building_set in read.values() for building in building_set.buildings]
    steps = {f"{building.part} {building.name}": partial(run_building, building, settings) for building in buildings}
    runs: list[Run] = []
    for measured in run_steps(steps, jobs=jobs, track=track):
        results.extend(measured)
        runs += measured.objects["runs"]
    results.objects |= {"settings": settings, "buildings": buildings, "runs": runs}
    results.details["runs"] = [run.as_json() for run in runs]
    results.details["left_out"] = {part: list_left_out(results, part) for part in chosen}
    results.details["unmodelled"] = {part: building_set.unmodelled for part, building_set in read.items()}
    results.details["notes"] = {part: building_set.notes for part, building_set in read.items()}
    results.details["scans"] = time_scans()
    return results


def list_buildings(part: str, data: Path | None) -> BuildingSet:
    """The buildings of a set; data: as of `find_data`."""
    if part == SYNTHETIC:
        return make_buildings()
    if part == CAMPUS:
        return read_campus(find_data(data))
    return draw_buildings(find_data(data)) if part == DRAWN_SET else read_buildings(find_data(data), part)


def list_left_out(results: Results, part: str) -> dict[str, tuple[str, ...]]:
    """The starts and searches of a set that do not count in the tables, by share or "searches"."""
    metrics = {f"{share:g}": name_share(share) for share in SHARES} | {"searches": TO_ROOM}
    return {
        name: pair_runs(results.select(part=part, metric=metric), results.options["policies"]).left_out
        for name, metric in metrics.items()
    }


def time_scans() -> dict[str, float]:
    """Scans with noise per second of processor time on one core, from free positions of a synthetic building.

    The cells are of 0.1 m. beams: of each scan. numba: whether it was used.
    """
    world, lidar, rng = build_world(make_floor("ring", seed=0)), Lidar(), np.random.default_rng(0)
    cells = np.argwhere(world.free)
    count = TIMED[has_numba()]
    chosen = cells[rng.integers(len(cells), size=count)].tolist()
    poses = [Pose(*world.point((row, col))) for row, col in chosen]
    scan(world, poses[0], lidar, rng)  # the first one compiles
    began = process_time()
    for pose in poses:
        scan(world, pose, lidar, rng)
    scans_per_second = count / max(process_time() - began, 1e-9)
    return {"beams": lidar.beams, "scans_per_second": scans_per_second, "numba": has_numba()}
