"""What a mapper knows, and the folder in which it is saved: the map, its floor, floors before it, and beliefs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from pianta.errors import MapError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.io._folders import atomic_folder, finish_changes
from pianta.io.floors import read_floor, save_floor
from pianta.io.maps import read_map

FORMAT = FileFormat("pianta mapper", 1)
STATE_FILE, MAP_FILE, FLOOR_FILE = "mapper.json", "map.npz", "floor.geojson"
AS_READ_FILE = "as_read.npz"  # only if cells wait to be read
EARLIER_FILES = ("earlier-1.geojson", "earlier-2.geojson", "earlier-3.geojson")  # the newest first
MAX_FILE_BYTES = 1_000_000

Probability = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True, eq=False)
class MapState:
    """What a mapper knows.

    grid: the last map. floor: its floor, with beliefs. earlier: floors before it, the newest first. types: the belief
    over types. time: of the map, seconds, None if unknown. building_type: given by the user, None if unknown. waiting:
    ids of partial rooms whose shape is to be predicted, that which waits longest first. as_read: the map, with the
    cells that wait to be read as they were when they were read last; None if none wait. ends: the belief over labels at
    each open end, by its name. tried: ids of rooms whose border was read again, as they may be one.
    """

    grid: GridMap
    floor: Floor
    earlier: tuple[Floor, ...] = ()
    types: Mapping[str, float] = field(default_factory=dict)
    time: float | None = None
    building_type: str | None = None
    waiting: tuple[int, ...] = ()
    as_read: GridMap | None = None
    ends: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    tried: frozenset[tuple[int, int]] = frozenset()

    def measure_waiting_share(self) -> float:
        """The share of the cells, seen now or before, that wait to be read, 0 … 1."""
        if self.as_read is None:
            return 0.0
        is_seen = (self.grid.free | self.grid.occupied) | (self.as_read.free | self.as_read.occupied)
        is_changed = (self.grid.free != self.as_read.free) | (self.grid.occupied != self.as_read.occupied)
        return float(is_changed.sum() / max(is_seen.sum(), 1))


class _File(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)

    types: dict[str, Probability]
    time: Annotated[float, Field(allow_inf_nan=False)] | None
    building_type: str | None
    earlier: Annotated[int, Field(ge=0, le=len(EARLIER_FILES))]
    waiting: list[int] = []
    has_as_read: bool = False
    ends: dict[str, dict[str, Probability]] = {}
    tried: list[tuple[int, int]] = []


def save_state(state: MapState, folder: Path) -> None:
    """Write a state into a folder; all of its files change together, also if the process is killed.

    Raises WriteError if the folder cannot be written.
    """
    content = {
        **FORMAT.header,
        "types": dict(state.types),
        "time": state.time,
        "building_type": state.building_type,
        "earlier": len(state.earlier),
        "waiting": list(state.waiting),
        "has_as_read": state.as_read is not None,
        "tried": sorted(state.tried),
        "ends": {name: dict(belief) for name, belief in state.ends.items()},
    }
    with atomic_folder(folder, optional=(*EARLIER_FILES, AS_READ_FILE)) as temporary:
        state.grid.save(temporary / MAP_FILE)
        if state.as_read is not None:
            state.as_read.save(temporary / AS_READ_FILE)
        save_floor(state.floor, temporary / FLOOR_FILE)
        for floor, name in zip(state.earlier, EARLIER_FILES, strict=False):
            save_floor(floor, temporary / name)
        (temporary / STATE_FILE).write_text(json.dumps(content, allow_nan=False) + "\n", encoding="utf-8")


def read_state(folder: Path) -> MapState:
    """The state in a folder.

    Raises MapError or FloorError, in one line, if a file is missing or damaged.
    """
    finish_changes(folder)
    content = read_checked(folder / STATE_FILE, "state", MapError, _parse, max_bytes=MAX_FILE_BYTES)
    grid = read_map(folder / MAP_FILE)
    as_read = read_map(folder / AS_READ_FILE) if content.has_as_read else None
    if as_read is not None and as_read.shape != grid.shape:
        sizes = " and ".join("{} × {}".format(*each.shape) for each in (grid, as_read))
        raise MapError(f"state {folder}: {MAP_FILE} and {AS_READ_FILE} have {sizes} cells; save the state again")
    return MapState(
        grid,
        read_floor(folder / FLOOR_FILE),
        tuple(read_floor(folder / name) for name in EARLIER_FILES[: content.earlier]),
        content.types,
        content.time,
        content.building_type,
        tuple(content.waiting),
        as_read,
        content.ends,
        frozenset(content.tried),
    )


@validation_as(MapError)
def _parse(content: bytes) -> _File:
    FORMAT.check_version(content, MapError)
    return _File.model_validate_json(content)
