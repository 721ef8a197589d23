"""The building that a file of the data shows, by which benches and training scripts leave whole buildings out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from pianta.errors import DataError
from pianta.io._files import short_repr

MANIFEST = "manifest.json"
# End of the names of true rooms of maps.
TRUTH = "_gt"
# Names of maps in data/kth begin with those of their buildings, of this number of digits.
KTH_FOLDER = "kth"
KTH_BUILDING_DIGITS = 7
# Maps of one home that have different names; manifest.json has no maps of this folder.
SAME_HOMES: Mapping[str, str] = MappingProxyType(
    {"vacuum/l10su_1058_goto_target": "home1058", "vacuum/z10_1056_paths": "home1058"}
)


def building_of(data: Path, file: str) -> str:
    """The building that a file of the data shows: all its floors, maps and plans have the same name of it.

    manifest.json of the data says it. A file that it does not list, or any file without it, is a building of its own,
    apart from maps whose names or README say more.

    Parameters
    ----------
    data
        Folder of the data.
    file
        Path inside that folder, such as "buildings/school/plans1.xml".

    Raises
    ------
    DataError
        If manifest.json is not a list of files with their buildings.

    Examples
    --------
    >>> building_of(Path("no data"), "buildings/school/plans2.xml")
    'plans2'
    """
    manifest = data / MANIFEST
    if manifest.is_file():
        building = _read_manifest(manifest, manifest.stat().st_mtime_ns, manifest.stat().st_size).get(file)
        if building is not None:
            return building
    folder, _, name = file.partition("/")
    if folder == KTH_FOLDER:
        return name[:KTH_BUILDING_DIGITS]
    item = Path(file).name.partition(".")[0].removesuffix(TRUTH)
    return SAME_HOMES.get(f"{folder}/{item}", item)


@lru_cache(maxsize=8)
def _read_manifest(manifest: Path, _modified: int, _size: int) -> Mapping[str, str]:
    """The building of each listed file; read again once the file was modified."""
    try:
        return {record["path"]: record["building"] for record in json.loads(manifest.read_text(encoding="utf-8"))}
    except (OSError, ValueError, KeyError, TypeError):
        raise DataError(
            f"{short_repr(manifest)} is no list of files with `path` and `building`, repair or remove it"
        ) from None
