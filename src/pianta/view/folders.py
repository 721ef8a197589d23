"""The folders of floors that are shown: those of a command, and those in them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pianta.errors import OptionError
from pianta.io._files import real_path, short_repr
from pianta.io._folders import choose_names
from pianta.reading.saved_reading import FLOOR

# Folders of floors in a gallery, at most; a limit of time, chosen by hand.
MAX_FOLDERS = 2000
# Levels below a given folder: the maps of a gallery, and the storeys of a map.
DEPTH = 2


def find_folders(paths: Sequence[str | Path]) -> dict[str, Path]:
    """Folders with a floor by different names, in their order; floor.geojson stands for its folder.

    Raises OptionError, in one line, for a folder without a floor, or more than MAX_FOLDERS floors.
    """
    named: dict[Path, tuple[str, Path]] = {}
    for path in map(Path, paths):
        folder = path.parent if path.name == FLOOR else path
        inner = _find_below(folder, DEPTH)
        if not inner:
            raise OptionError(f"folder {short_repr(path)} has no {FLOOR}, give a folder of `pianta read`")
        top = real_path(folder).name
        for each in inner:
            named.setdefault(real_path(each), ("/".join(each.relative_to(folder).parts) or top, folder))
    if len(named) > MAX_FOLDERS:
        raise OptionError(f"{len(named)} floors are too many for a page, give {MAX_FOLDERS} at most")
    long = [f"{real_path(folder).name}/{name}" for name, folder in named.values()]
    return dict(zip(choose_names([name for name, _ in named.values()], long), named, strict=True))


def _find_below(folder: Path, depth: int) -> list[Path]:
    """The folder if it has a floor, else those below it that have one, by name."""
    try:
        if (folder / FLOOR).is_file():
            return [folder]
        inner = sorted(path for path in folder.iterdir() if path.is_dir()) if depth else []
    except (OSError, ValueError):
        return []
    return [below for path in inner for below in _find_below(path, depth - 1)]
