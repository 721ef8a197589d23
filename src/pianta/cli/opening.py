"""What `pianta read` reads: a robot's map, with one floor, or a plan, with one or several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from pianta.errors import MapError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import MAX_CELLS, checked_input, shown
from pianta.io.maps import MAP_SUFFIXES, read_map
from pianta.io.ros_maps import YAML_SUFFIXES
from pianta.layout.reconstruct import DEFAULT_METHOD

if TYPE_CHECKING:
    from pianta.plan.symbols.poses import PlacedSymbol


@dataclass(frozen=True, eq=False)
class OpenedFloor:
    """A floor of a file.

    grid: the map, or the frame of the sheet of a plan. folder: where its results go within those of the file, "" for
    the same place. paper: the sheet, shape (H, W, 3) of the grid; None for maps. told: what else is worth a line each.
    """

    floor: Floor
    grid: GridMap
    folder: str = ""
    paper: NDArray[np.uint8] | None = None
    told: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Opening:
    """How files are opened.

    method: how rooms are found. kind: None where each file tells. resolution, max_cells: as of read_map and read_plan.
    trust_thresholds: as of read_map. page, symbols: as of read_plan.
    """

    method: str = DEFAULT_METHOD
    kind: Literal["map", "plan"] | None = None
    resolution: float | None = None
    trust_thresholds: bool = False
    max_cells: int = MAX_CELLS
    page: int | None = None
    symbols: Path | None = None

    def open(self, path: str) -> list[OpenedFloor]:
        """The floors of a file, one of a map.

        Raises PiantaError, in one line that names the file.
        """
        from pianta.plan.sheets.map_or_plan import tell_kind

        _refuse_folder(path)
        if self.kind is None:
            _refuse_suffix(path)
        kind = self.kind or tell_kind(path, max_cells=self.max_cells)
        return self._open_plan(path) if kind == "plan" else [self._open_map(path)]

    def _open_map(self, path: str) -> OpenedFloor:
        from pianta.layout.reconstruct import reconstruct

        given = {"--page": self.page, "--symbols": self.symbols}
        useless = " and ".join(name for name, value in given.items() if value is not None)
        if useless:
            raise OptionError(f"map {shown(path)} is no plan, leave out {useless} or give --as plan")
        grid = read_map(
            path, resolution=self.resolution, trust_thresholds=self.trust_thresholds, max_cells=self.max_cells
        )
        try:
            return OpenedFloor(reconstruct(grid, method=self.method), grid)
        except PiantaError as error:
            raise type(error)(f"map {shown(path)}: {error}") from error

    def _open_plan(self, path: str) -> list[OpenedFloor]:
        from pianta.plan.read_plan import read_plan

        if self.trust_thresholds:
            raise OptionError(f"plan {shown(path)} is no map, leave out --trust-thresholds or give --as map")
        reading = read_plan(
            path,
            resolution=self.resolution,
            page=self.page,
            symbols=self.symbols,
            method=self.method,
            max_cells=self.max_cells,
        )
        paper = reading.sheet.colors if reading.sheet else None
        unit = reading.sheet.px_per_unit if reading.sheet else 1.0
        several = len(reading.floors) > 1
        matched = (_describe_matches(reading.symbols, self.symbols),) if self.symbols else ()
        told = [(f"scale: {one.scale.describe(px_per_unit=unit)}", *matched) for one in reading.floors]
        folders = [f"floor-{number}" if several else "" for number in range(1, len(reading.floors) + 1)]
        return [
            OpenedFloor(one.floor, one.grid, folder, paper, lines)
            for one, folder, lines in zip(reading.floors, folders, told, strict=True)
        ]


def _describe_matches(symbols: Iterable[PlacedSymbol], folder: Path) -> str:
    """How many symbols were found of each file of a folder."""
    counts = Counter(symbol.name for symbol in symbols if Path(symbol.name).suffix)
    if not counts:
        return f"symbols: none of {shown(folder)} found, cut them out of a sheet like this one, at its scale"
    named = ", ".join(f"{count} {name}" for name, count in counts.most_common())
    return f"symbols: {counts.total()} of {shown(folder)} found: {named}"


def _refuse_suffix(path: str | Path) -> None:
    """Raise MapError for a file that is there and is neither a map nor a plan by its suffix."""
    from pianta.plan.sheets.map_or_plan import PLAN_SUFFIXES

    known = dict.fromkeys([*MAP_SUFFIXES, *PLAN_SUFFIXES])
    if Path(path).suffix.lower() not in known:
        file = checked_input(path, "file", MapError)
        raise MapError(f"file {shown(file)} is of no known kind, give one of {', '.join(known)}")


def _refuse_folder(path: str | Path) -> None:
    """Raise MapError for a folder, naming the YAMLs in it, one of which may be meant."""
    try:
        inside = sorted(Path(path).iterdir())
    except (OSError, ValueError):  # no folder; the reader says what it is
        return
    yamls = [shown(file) for file in inside if file.suffix.lower() in YAML_SUFFIXES]
    more = " …" if len(yamls) > 3 else ""
    remedy = " or ".join(yamls[:3]) + more if yamls else "the map.yaml or the image of a map"
    raise MapError(f"map {shown(path)} is a folder, give {remedy}")
