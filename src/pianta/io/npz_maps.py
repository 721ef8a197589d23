"""Maps as NumPy archives: the arrays cells, resolution and origin, as GridMap has them."""

from __future__ import annotations

import zipfile
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.gridmap import GridMap
from pianta.io._files import MAX_CELLS, check_cell_count, checked_input, reason_of, shown, written_atomically

NPZ_SUFFIX = ".npz"

# How many numbers the members have; None: as many as the map has cells.
_COUNTS = {"cells": None, "resolution": 1, "origin": 3}


def read_npz_map(path: str | Path, *, max_cells: int = MAX_CELLS) -> GridMap:
    """Map from a NumPy archive with the arrays cells (H, W), resolution (m per cell) and origin (x, y, yaw).

    Nothing is unpickled, and no array of more than max_cells numbers is unpacked.

    Raises MapError, with every fault in one message.
    """
    file = checked_input(path, "map", MapError)
    try:
        arrays, faults = _read_arrays(file, max_cells)
    # zipfile, zlib and numpy raise whatever a hostile file drives them to.
    except Exception as exception:
        raise MapError(f"map {shown(file)} is no NumPy archive or damaged: {reason_of(exception)}") from exception
    # Harmless stand-ins for what could not be read, so that GridMap finds the faults of the rest.
    cells = arrays.get("cells", np.zeros((1, 1), np.int8))
    resolution = arrays.get("resolution", np.ones(1)).item()
    origin = arrays.get("origin", np.zeros(3)).ravel().tolist()
    try:
        grid = GridMap(cells, resolution, tuple(origin))
    except MapError as error:
        faults.append(str(error).removeprefix("not a map: "))
    if faults:
        raise MapError(f"map {shown(file)}: " + "; ".join(faults))
    return grid


def _read_arrays(file: Path, max_cells: int) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """The members that are arrays of numbers, of the right count; and what is wrong with the others."""
    arrays, faults = {}, []
    with zipfile.ZipFile(file) as archive:
        for key, count in _COUNTS.items():
            try:
                _check_member(archive, key, count, max_cells)
                with archive.open(f"{key}.npy") as stream:
                    arrays[key] = npy.read_array(stream, allow_pickle=False)
            except MapError as error:
                faults.append(str(error))
    return arrays, faults


def _check_member(archive: zipfile.ZipFile, key: str, count: int | None, max_cells: int) -> None:
    """Raise MapError when the header of a member promises what must not or need not be unpacked."""
    if f"{key}.npy" not in archive.namelist():
        raise MapError(f"{key} is missing, save it with numpy.savez")
    with archive.open(f"{key}.npy") as stream:
        version = npy.read_magic(stream)
        read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read_header(stream)
    check_cell_count(shape, f"array {key}", max_cells=max_cells)
    if dtype.kind not in "iuf":
        raise MapError(f"{key} is of type {shown(str(dtype))}, give numbers")
    if count is not None and prod(shape) != count:
        raise MapError(f"{key} holds {prod(shape)} numbers, give {count}")


def save_npz_map(grid: GridMap, path: str | Path) -> None:
    """Write a map as a compressed NumPy archive that read_npz_map reads back exactly.

    Raises MapError when the path does not end in .npz and PiantaError when it cannot be written.
    """
    if Path(path).suffix.lower() != NPZ_SUFFIX:
        raise MapError(f"the map cannot be saved: the path is {shown(path)}, give one that ends in .npz")
    with written_atomically(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, cells=grid.cells, resolution=grid.resolution, origin=grid.origin)
