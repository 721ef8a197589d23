"""The folders that are shown, of floors and of results: those of a command, and those in them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pianta.errors import OptionError
from pianta.io._files import real_path, short_repr
from pianta.io._folders import choose_names
from pianta.io.building_folders import read_storey_folders
from pianta.reading.saved_reading import FLOOR

# Folders of floors in a gallery, at most; a limit of time, chosen by hand.
MAX_FOLDERS = 2000
# Results in a folder, by a file of theirs; a folder of buildings has a file for each.
RESULTS = ("prediction.json", "exploration.json", "realism.json")
BUILDINGS = "building-*.json"
# Levels below a given folder: the maps of a gallery, and the storeys of a map.
DEPTH = 2


def find_folders(paths: Sequence[str | Path]) -> dict[str, Path]:
    """What is shown by different names, in its order: a folder with a floor, or the file by which results are known.

    A file of them stands for its folder. A folder may have both a floor and results.

    Raises OptionError, in one line, for a folder that has neither, or more than MAX_FOLDERS of them.
    """
    named: dict[Path, tuple[str, Path]] = {}
    for path in map(Path, paths):
        folder = path.parent if path.name == FLOOR or path.name in RESULTS else path
        inner = _find_below(folder, DEPTH)
        if not inner:
            raise OptionError(f"folder {short_repr(path)} has no {FLOOR}, give a folder of `pianta read`")
        top = real_path(folder).name
        for each in inner:
            below = each.parent if each.suffix == ".json" else each
            name = "/".join(below.relative_to(folder).parts) or top
            named.setdefault(_real_path(each), (_name_results(name, each, inner), folder))
    if len(named) > MAX_FOLDERS:
        raise OptionError(f"{len(named)} floors are too many for a page, give {MAX_FOLDERS} at most")
    long = [f"{real_path(folder).name}/{name}" for name, folder in named.values()]
    return dict(zip(choose_names([name for name, _ in named.values()], long), named, strict=True))


def _real_path(path: Path) -> Path:
    """The path without links in its folders; the name of a file stays, as it says what it is."""
    return real_path(path.parent) / path.name if path.suffix == ".json" else real_path(path)


def _name_results(name: str, path: Path, others: Sequence[Path]) -> str:
    """The name of results; with what they are if the folder has more than these."""
    folder = path.parent
    if path.suffix != ".json" or not any(each in (folder, *folder.glob("*.json")) for each in others if each != path):
        return name
    return f"{name} ({path.stem.partition('-')[0]})"


def _find_below(folder: Path, depth: int) -> list[Path]:
    """What the folder shows, else what those below it show, by name."""
    try:
        paths = [folder] if (folder / FLOOR).is_file() else []
        paths += [folder / name for name in RESULTS if (folder / name).is_file()]
        paths += sorted(folder.glob(BUILDINGS))[:1]
        if paths:
            return paths
        inner = sorted(path for path in folder.iterdir() if path.is_dir()) if depth else []
    except (OSError, ValueError):
        return []
    storeys = read_storey_folders(folder) if depth else None
    if storeys is not None:
        inner = [folder / name for name in storeys.titles]
    return [below for path in inner for below in _find_below(path, depth - 1)]
