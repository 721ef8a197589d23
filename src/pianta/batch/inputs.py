"""The maps and plans that folders and patterns stand for."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from glob import glob, has_magic
from pathlib import Path

from pianta.batch.journal import has_journal, is_reserved
from pianta.errors import OptionError
from pianta.io._files import check_path, is_folder, one_line_reason, real_path, short_repr
from pianta.io.bags import is_bag
from pianta.io.graphs import FLOOR_FILE
from pianta.io.maps import JSON_SUFFIX, MAP_SUFFIXES
from pianta.io.ros_maps import YAML_SUFFIXES, find_map_image
from pianta.plan.sheets.map_or_plan import PLAN_SUFFIXES

# JSON files are read if they are given themselves: most in folders are no maps
SUFFIXES = tuple(suffix for suffix in dict.fromkeys([*MAP_SUFFIXES, *PLAN_SUFFIXES]) if suffix != JSON_SUFFIX)
RESULTS = (FLOOR_FILE, "prediction.json")  # in folders of results
READING = frozenset({"graph.json", "grid.npz", "rooms.png"})  # beside the floor
# Files in such folders that could be taken for maps or plans.
RESULT_NAME = re.compile(r"(picture|rooms|paper|explain|plans|sheet|building-[0-9]+)\.png|(grid|explored|shares)\.npz")
_IMAGE_LINE = re.compile(rb"^\s*[\"']?image[\"']?\s*:[ \t]*[\"']?([^\"'#\r\n]*)", re.MULTILINE)
REMEDY = "give one with a map.yaml, pictures or drawings"
HEAD_BYTES = 65536  # of a YAML file, in which a map names its image


def list_inputs(paths: Sequence[str | Path]) -> list[Path]:
    """The files of maps and plans, each once, in the given order.

    A pattern with *, ? or [ ] stands for the files and folders that match, sorted, ** for any folders; a folder for the
    maps and plans in it and its subfolders. Of a folder hidden files, results of `pianta read`, `predict` and
    `generate`, images that a map.yaml names, and YAML files without an image are left out.
    Raises OptionError, in one line, for what is no path, patterns that nothing matches, folders without a map or plan.
    """
    files: dict[Path, Path] = {}
    for pattern in paths:
        matches = expand_patterns([pattern])
        if matches != [Path(pattern)]:
            matches = [path for path in matches if not _is_result(path)]
        inside = [file for path in matches for file in _list_path(path)]
        # The results of an earlier run may be beside the files, and match as they do
        if not inside and not all(map(has_journal, matches)):
            raise OptionError(f"folder {short_repr(pattern)} has no map or plan, {REMEDY}")
        for file in inside:
            files.setdefault(real_path(file), file)
    if not files and paths:
        raise OptionError(f"folder {short_repr(paths[0])} has no map or plan, {REMEDY}")
    return [*files.values()]


def _list_path(path: Path) -> Iterable[Path]:
    return _list_folder(path) if is_folder(path) and not is_bag(path) else [path]


def is_collection(path: str | Path) -> bool:
    """Whether a path stands for several files: a folder that is no bag, or a pattern."""
    if os.path.lexists(path):
        return is_folder(Path(path)) and not is_bag(Path(path))
    return has_magic(str(path))


def expand_patterns(paths: Iterable[str | Path]) -> list[Path]:
    """The paths that patterns with *, ? or [ ] stand for, and those that are no patterns.

    Raises OptionError for a pattern that nothing matches.
    """
    return [match for pattern in paths for match in _expand(pattern)]


def _expand(pattern: str | Path) -> list[Path]:
    """The paths that match a pattern; the path itself if it exists, or has no pattern. Raises OptionError."""
    check_path(pattern, "paths")
    if not has_magic(str(pattern)) or os.path.lexists(pattern):
        return [Path(pattern)]
    paths = [Path(match) for match in sorted(glob(str(pattern), recursive=True))]  # noqa: PTH207 - Path.glob takes no absolute pattern
    matches = [path for path in paths if not (is_reserved(path.name) and has_journal(path.parent))]
    if not matches:
        raise OptionError(f"nothing matches {short_repr(pattern)}, check the pattern")
    return matches


def _list_folder(folder: Path) -> list[Path]:
    inputs: list[Path] = []
    images: set[Path] = set()
    for name, folders, names in walk_folder(folder):
        if is_bag(name):
            folders.clear()
            inputs.append(name)
            continue
        is_result = is_result_folder(names)
        # A map or a plan may be beside its results
        usable = [file for file in names if not (is_result and RESULT_NAME.fullmatch(file))]
        files = [name / file for file in usable if not file.startswith(".")]
        named = {file: _find_image(file) for file in files if file.suffix.lower() in YAML_SUFFIXES}
        maps = [file for file, image in named.items() if image is not None]
        images |= {real_path(image) for image in named.values() if image}
        others = [
            file for file in files if file.suffix.lower() in SUFFIXES and file.suffix.lower() not in YAML_SUFFIXES
        ]
        inputs += sorted([*maps, *others])
    # An image may be in another folder than the map that names it
    return [file for file in inputs if file.suffix.lower() in YAML_SUFFIXES or real_path(file) not in images]


def _is_result(path: Path) -> bool:
    """Whether a file is a result of `pianta read`, `predict` or `generate`."""
    return bool(RESULT_NAME.fullmatch(path.name)) and is_result_folder([file.name for file in path.parent.iterdir()])


def is_result_folder(names: Sequence[str]) -> bool:
    """Whether files with these names in a folder are results of `pianta read`, `predict` or `generate`."""
    is_reading = READING.issubset(names)  # also without its floor, which may have been lost
    return is_reading or any(
        name in RESULTS or (name.startswith("building-") and name.endswith(".graphml")) for name in names
    )


def walk_folder(folder: Path) -> Iterator[tuple[Path, list[str], list[str]]]:
    """A folder and the folders in it, as of `os.walk`, sorted, without hidden ones; those behind links last, each once.

    Raises OptionError for a folder that cannot be listed.
    """
    waiting, visited = [folder], set()
    while waiting:
        for name, folders, names in os.walk(waiting.pop(0), onerror=_refuse_folder):
            path = Path(name)
            folders.sort()
            if (real := real_path(path)) in visited:
                folders.clear()
                continue
            visited.add(real)
            visible = [inner for inner in folders if not inner.startswith(".")]
            waiting += [path / inner for inner in visible if (path / inner).is_symlink()]
            folders[:] = [inner for inner in visible if not (path / inner).is_symlink()]
            yield path, folders, names


def _refuse_folder(error: OSError) -> None:
    raise OptionError(f"folder {short_repr(error.filename)} cannot be listed: {one_line_reason(error)}")


def _find_image(file: Path) -> Path | None:
    """The image that a YAML file names, as that of a map does, also if the file has faults; None without one."""
    if image := find_map_image(file):
        return image
    if not file.is_file():
        # A pipe would be waited for; as a map it has a fault
        return file
    try:
        with file.open("rb") as opened:
            line = _IMAGE_LINE.search(opened.read(HEAD_BYTES))
    except OSError:
        return file
    return file.parent / os.fsdecode(line[1].strip()) if line else None
