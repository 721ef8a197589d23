"""The data that benches measure on: where it is, and which maps it has."""

from __future__ import annotations

import os
from pathlib import Path

from pianta.errors import DataError, OptionError
from pianta.io._files import one_line_reason, short_repr

DATA_VARIABLE = "PIANTA_DATA"
DEFAULT_DATA = Path("..", "shared", "data")
REMEDY = f"give the folder of the data by --data, or by ${DATA_VARIABLE}"

# Maps of schools with their true layouts: folder, ending of the truths, and resolution.
SLAM_FOLDER = "slam"
SLAM_TRUTH = "_gt.xml"
SLAM_RESOLUTION = 0.1  # m per cell, benchmarks/README.md

SET_NAMES = ("survey", "furniture", "clutter", "doors", "schools", "growing")


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


def check_set(name: str) -> None:
    """Raise OptionError for the name of no set of maps."""
    if name not in SET_NAMES:
        raise OptionError(f"set is {name!r}, give one of {', '.join(SET_NAMES)}")


def _list_names(folder: Path) -> list[str]:
    try:
        return [file.name for file in folder.iterdir()]
    except (OSError, ValueError) as exception:
        raise DataError(f"no data in {short_repr(folder)}: {one_line_reason(exception)}, {REMEDY}") from None
