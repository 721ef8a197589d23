"""Which session shows the files at a path: a floor, or results that are recognised by their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

from pianta.view.buildings_session import BuildingsSession
from pianta.view.exploration_session import ExplorationSession
from pianta.view.prediction_session import PredictionSession
from pianta.view.realism_session import RealismSession
from pianta.view.result_sessions import ResultSession
from pianta.view.sessions import Session

AnySession: TypeAlias = Session | ResultSession[Any]


def open_session(number: int, name: str, path: Path) -> AnySession:
    """The session of a path of `find_folders`. number: on the page."""
    kinds: dict[str, type[ResultSession[Any]]] = {
        "prediction": PredictionSession,
        "exploration": ExplorationSession,
        "realism": RealismSession,
    }
    if path.suffix != ".json":
        return Session(number, name, path)
    return kinds.get(path.stem, BuildingsSession)(number, name, path)
