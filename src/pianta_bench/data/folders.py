"""The data that benches measure on: where it is, and which maps it has."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from pianta.errors import DataError, OptionError
from pianta.io._files import one_line_reason, short_repr

Set = TypeVar("Set")

DATA_VARIABLE = "PIANTA_DATA"
DEFAULT_DATA = Path("..", "shared", "data")
REMEDY = f"give the folder of the data by --data, or by ${DATA_VARIABLE}"

# Maps of schools with their true layouts: folder, ending of the truths, and resolution.
SLAM_FOLDER = "slam"
SLAM_TRUTH = "_gt.xml"
SLAM_RESOLUTION = 0.1  # m per cell, benchmarks/README.md

SET_NAMES = ("survey", "furniture", "clutter", "vacuum", "doors", "schools", "growing")
# Maps with true rooms and doors.
LAYOUT_SET_NAMES = ("schools", "survey", "furniture", "worlds")
# Maps that noise and turns are measured on, and those of a bench without options.
ROBUSTNESS_SET_NAMES = ("survey", "furniture", "clutter", "vacuum", "schools", "worlds")
DEFAULT_ROBUSTNESS_SETS = ("survey", "clutter", "vacuum", "worlds")
# Maps that probabilities of rooms and doors are measured on, and those of a bench without options.
CALIBRATION_SET_NAMES = ("survey", "furniture", "clutter", "vacuum", "schools", "growing", "worlds")
DEFAULT_CALIBRATION_SETS = ("survey", "furniture", "clutter", "vacuum", "schools", "worlds")


def find_data(folder: Path | None = None) -> Path:
    """The folder of the data: the given one, else $PIANTA_DATA, else ../shared/data.

    Raises DataError when it is no folder.
    """
    data = folder or Path(os.environ.get(DATA_VARIABLE) or DEFAULT_DATA)
    _list_names(data)
    return data


def list_maps(folder: Path, ending: str) -> list[str]:
    """Names of the maps with a truth in a folder, sorted; `ending` follows the name in the truth's file name.

    Raises DataError without such maps.
    """
    names = sorted(name.removesuffix(ending) for name in _list_names(folder) if name.endswith(ending))
    if not names:
        raise DataError(f"no maps with a truth in {short_repr(folder)}: no file is called *{ending}, {REMEDY}")
    return names


def check_set(name: str, names: Sequence[str] = SET_NAMES) -> None:
    """Raise OptionError for the name of no set of maps, where `names` are those of all sets."""
    if name not in names:
        raise OptionError(f"set is {name!r}, give one of {', '.join(names)}")


def choose_items(chosen: Mapping[Set, Sequence[str]], items: Sequence[str] | None) -> list[tuple[Set, str]]:
    """The maps to measure, each with its set; all maps of the chosen sets unless items are named.

    Raises OptionError for a name that no chosen set has.
    """
    pairs = [(map_set, name) for map_set, names in chosen.items() for name in names]
    for item in items or ():
        if item not in {name for _, name in pairs}:
            raise OptionError(f"item is {short_repr(item)}, give the name of a map of the sets, without its ending")
    return [(map_set, name) for map_set, name in pairs if not items or name in items]


def _list_names(folder: Path) -> list[str]:
    try:
        return [file.name for file in folder.iterdir()]
    except (OSError, ValueError) as exception:
        raise DataError(f"no data in {short_repr(folder)}: {one_line_reason(exception)}, {REMEDY}") from None
