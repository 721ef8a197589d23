"""Numbers of rooms on each map, on the map with noise, and on the rotated map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from pianta.errors import MapError, OptionError
from pianta.gridmap import GridMap
from pianta.layout.reconstruct import check_method, reconstruct
from pianta_bench.data.folders import DEFAULT_ROBUSTNESS_SETS, ROBUSTNESS_SET_NAMES, find_data
from pianta_bench.data.layout_sets import LAYOUT_SETS, choose_maps
from pianta_bench.data.map_sets import SETS
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.robustness.variants import add_salt_and_pepper, rotate_cells

# Share of the rooms of the map by which the number may change; issue 22.
TOLERANCE = 0.05
# The record of a figure of the map itself names no variant.
WHOLE_MAP = ""
NAMES = ("metric", "variant")


def measure(
    data: Path | None = None,
    *,
    method: str = "structure",
    sets: Sequence[str] | None = None,
    items: Sequence[str] | None = None,
    draws: int = 100,
    turns: int = 5,
    jobs: int = 1,
    seed: int = 0,
    track: Track = iter,
) -> Results:
    """Numbers of rooms of each map, of each draw of noise on it, and of each rotation of it.

    method: one of METHODS. sets: of ROBUSTNESS_SET_NAMES. items: only maps of these names.
    draws: of salt and pepper, 0 for none. turns: degrees from one rotation to the next, 0 for none.
    jobs: processes; the figures do not depend on them. seed: of the noise. track: wraps the maps, to show progress.
    Raises OptionError for the name of no method, set or map, DataError if there are no maps.
    """
    check_method(method)
    if not draws and not turns:
        raise OptionError("draws and turns are 0, give at least one of them")
    folder = find_data(data)
    pairs = choose_maps(folder, sets, items, names=ROBUSTNESS_SET_NAMES, usual=DEFAULT_ROBUSTNESS_SETS)
    results = Results({"method": method, "sets": [*dict.fromkeys(part for part, _ in pairs)]})
    results.options |= {"draws": draws, "turns": turns, "seed": seed}
    steps = {
        f"{part}, {name}": partial(
            measure_apart, folder, part, name, method=method, draws=draws, turns=turns, seed=seed
        )
        for part, name in pairs
    }
    for outcome in run_steps(steps, jobs=jobs, track=track):
        results.extend(outcome)
    return results


def read_grid(data: Path, part: str, name: str) -> GridMap:
    """The map of a set."""
    if part == "worlds":
        return LAYOUT_SETS[part].read(data, name)[0]
    return SETS[part].read(data / SETS[part].folder, name).grid


def measure_apart(data: Path, part: str, name: str, *, method: str, draws: int, turns: int, seed: int) -> Results:
    """The results of one map."""
    results = Results()
    angles = range(turns, 360, turns) if turns else ()
    failed = {("changed", WHOLE_MAP): 100.0 if draws else None, ("within", WHOLE_MAP): 0.0 if turns else None}
    measure_one = partial(measure_map, data, part, name, method=method, draws=draws, angles=angles, seed=seed)
    results.measure(part, name, measure_one, names=NAMES, failed=failed)
    return results


def measure_map(
    data: Path, part: str, name: str, *, method: str, draws: int, angles: Sequence[int], seed: int
) -> Iterator[Figures]:
    """The rooms of a map, of the map with noise and of the rotated map; and the shares that are as many, %."""
    grid = read_grid(data, part, name)
    rooms = len(reconstruct(grid, method=method, predict_partial=False).rooms)
    yield {("rooms", WHOLE_MAP): rooms}
    noisy = {
        f"draw {draw}": count_rooms(add_salt_and_pepper(grid, seed=seed, draw=draw), method) for draw in range(draws)
    }
    yield {("rooms", variant): number for variant, number in noisy.items()}
    yield describe_noise(rooms, [*noisy.values()])
    rotated = {f"turn {angle}": count_rooms(rotate_cells(grid, angle), method) for angle in angles}
    yield {("rooms", variant): number for variant, number in rotated.items()}
    yield describe_turns(rooms, [*rotated.values()])


def count_rooms(grid: GridMap, method: str) -> int:
    """The number of rooms of a map; 0 if it shows no room."""
    try:
        return len(reconstruct(grid, method=method, predict_partial=False).rooms)
    except MapError:
        return 0


def is_as_many(rooms: int, number: int) -> bool:
    """Whether a number differs by at most the tolerance from the number of rooms of the map."""
    return abs(number - rooms) <= TOLERANCE * rooms


def describe_noise(rooms: int, numbers: Sequence[int]) -> Figures:
    """The share of draws that change the number of rooms by more than the tolerance, %; least and most rooms."""
    changed = [not is_as_many(rooms, number) for number in numbers]
    return _describe("changed", changed) | _describe_range("noise", numbers)


def describe_turns(rooms: int, numbers: Sequence[int]) -> Figures:
    """The share of rotations with as many rooms but for the tolerance, %; the least and the most rooms."""
    within = [is_as_many(rooms, number) for number in numbers]
    return _describe("within", within) | _describe_range("turn", numbers)


def _describe(metric: str, holds: Sequence[bool]) -> dict[tuple[str, str], float | None]:
    return {(metric, WHOLE_MAP): 100 * sum(holds) / len(holds) if holds else None}


def _describe_range(prefix: str, numbers: Sequence[int]) -> dict[tuple[str, str], float | None]:
    return {
        (f"{prefix}_least", WHOLE_MAP): min(numbers, default=None),
        (f"{prefix}_most", WHOLE_MAP): max(numbers, default=None),
    }
