"""Steps of an exploration: the map that robots had at a scan, and the floor that it reads as."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.errors import DataError, MapError, MapWarning, OptionError
from pianta.exploration.record import Exploration
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.io._files import atomic_file
from pianta.io.floors import save_floor
from pianta.io.maps import save_npz_map
from pianta.mapping.mapper import Mapper

FORMAT = FileFormat("pianta exploration", 1)
FILE_NAME = "exploration.json"
# Steps of a run, at most; a limit of time and of files, chosen by hand.
MAX_STEPS = 200
# The file has the tracks; bytes.
MAX_FILE_BYTES = 64 * 2**20
# Decimals of metres, seconds and radians.
DIGITS = 3


@dataclass(frozen=True, eq=False)
class Step:
    """What is known at a scan.

    scan: its number, from 0. grid: the map. floor: what a mapper makes of the maps until then; a room keeps its id.
    """

    scan: int
    grid: GridMap
    floor: Floor


def choose_scans(run: Exploration, count: int) -> list[int]:
    """The scans of this number of steps at about equal distances driven, the first and the last among them.

    Raises OptionError for a count out of range.
    """
    if not 0 <= count <= MAX_STEPS:
        raise OptionError(f"{count} steps are wanted, give 0 to {MAX_STEPS}")
    last = len(run.area) - 1
    distances = np.linspace(0, run.distance[-1], count)
    scans = {min(int(scan), last) for scan in np.searchsorted(run.distance, distances - 1e-9)}
    # The last scan may be one of several at the last metre.
    return sorted([*sorted(scans)[:-1], last] if count > 1 else [last] * count)


def read_steps(run: Exploration, count: int, mapper: Mapper | None = None) -> Iterator[Step]:
    """What a mapper makes of the map of a run at this number of scans; a floor may have no rooms yet.

    mapper: one without a map; None for one that does not know the type of the building and
    reads all of each map.
    """
    mapper = mapper or Mapper(max_read_area=None)
    for scan in choose_scans(run, count):
        grid = run.map_at(scan)
        # Of a map that is not finished, nothing that it lacks is worth a warning or an error
        with warnings.catch_warnings(), suppress(MapError):
            warnings.simplefilter("ignore", MapWarning)
            mapper.update(grid)
        yield Step(scan, grid, replace(mapper.floor, source=f"scan {scan + 1}"))


def save_steps(
    run: Exploration, names: list[str], folder: Path, *, world: str, policy: str, mapper: Mapper | None = None
) -> None:
    """Write exploration.json, and the map and the floor of each step as NAME.npz and NAME.geojson.

    names: of the steps, as many as are wanted; with fewer scans the last names are not used. world, policy: for the
    reader of the file. mapper: as of `read_steps`.
    """
    steps = []
    for name, step in zip(names, read_steps(run, len(names), mapper), strict=False):
        save_npz_map(step.grid, folder / f"{name}.npz")
        save_floor(step.floor, folder / f"{name}.geojson")
        steps.append(
            {"name": name, "scan": step.scan, "pose_counts": _count_poses(run, step.scan), **_measure(run, step.scan)}
        )
    content = {
        **FORMAT.header,
        "world": world,
        "policy": policy,
        "outcome": run.outcome,
        "reachable_area": round(run.reachable_area, DIGITS),
        "tracks": [np.round(track, DIGITS).tolist() for track in run.tracks],
        "steps": steps,
    }
    with atomic_file(folder / FILE_NAME) as temporary:
        temporary.write_text(json.dumps(content, allow_nan=False) + "\n", encoding="utf-8")


def _measure(run: Exploration, scan: int) -> dict[str, float]:
    figures = {"distance": run.distance, "time": run.time, "area": run.area, "share": run.share}
    return {name: round(float(values[scan]), DIGITS) for name, values in figures.items()}


def _count_poses(run: Exploration, scan: int) -> list[int]:
    """The number of poses of each robot until a scan."""
    moved = run.robot[: scan + 1]
    return [int(np.count_nonzero(moved == number)) for number in range(len(run.tracks))]


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)


class SavedStep(_Part):
    """A step in exploration.json, in m, s and m²; pose_counts: the poses of each robot until then."""

    name: Annotated[str, Field(pattern=r"^step-\d{1,6}$")]
    scan: Annotated[int, Field(ge=0)]
    pose_counts: list[Annotated[int, Field(ge=0)]]
    distance: FiniteFloat
    time: FiniteFloat
    area: FiniteFloat
    share: FiniteFloat


class SavedExploration(_Part):
    """The content of exploration.json. tracks: poses x, y, heading of each robot, metres and radians."""

    format: Literal["pianta exploration"]
    version: str
    world: str
    policy: str
    outcome: str
    reachable_area: FiniteFloat
    tracks: list[list[Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]]]
    steps: Annotated[list[SavedStep], Field(max_length=MAX_STEPS)]


def read_exploration(path: str | Path) -> SavedExploration:
    """Read exploration.json; raises DataError, with every fault in one message, for a file of another form."""

    def parse(content: bytes) -> SavedExploration:
        with validation_as(DataError):
            FORMAT.check_version(content, DataError)
            return SavedExploration.model_validate_json(content)

    return read_checked(path, "exploration", DataError, parse, max_bytes=MAX_FILE_BYTES)
