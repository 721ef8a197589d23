"""Which session shows the files at a path: a floor, or results that are recognised by their files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from pianta.io._files import real_path
from pianta.view.buildings_session import BuildingsSession
from pianta.view.exploration_session import ExplorationSession
from pianta.view.prediction_session import PredictionSession
from pianta.view.realism_session import RealismSession
from pianta.view.result_sessions import ResultSession
from pianta.view.sessions import Session

AnySession: TypeAlias = Session | ResultSession[Any]


def open_sessions(folders: Mapping[str, Path]) -> list[AnySession]:
    """The sessions of folders of `find_folders`, in the order of the page."""
    numbers = {real_path(path): number for number, path in enumerate(folders.values())}
    return [_open_session(number, name, path, numbers) for number, (name, path) in enumerate(folders.items())]


def _open_session(number: int, name: str, path: Path, numbers: Mapping[Path, int]) -> AnySession:
    kinds: dict[str, type[ResultSession[Any]]] = {
        "prediction": PredictionSession,
        "exploration": ExplorationSession,
        "realism": RealismSession,
    }
    if path.suffix != ".json":
        return Session(number, name, path, numbers)
    return kinds.get(path.stem, BuildingsSession)(number, name, path)
