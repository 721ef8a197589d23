"""Which session shows the files at a path: a floor, or results that are recognised by their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

from pianta.view.sessions import Session
from pianta.view.shown import Shown
from pianta.view.shown_buildings import ShownBuildings
from pianta.view.shown_exploration import ShownExploration
from pianta.view.shown_prediction import ShownPrediction
from pianta.view.shown_realism import ShownRealism

AnySession: TypeAlias = Session | Shown[Any]


def open_session(number: int, name: str, path: Path) -> AnySession:
    """The session of a path of `find_folders`. number: on the page."""
    kinds: dict[str, type[Shown[Any]]] = {
        "prediction": ShownPrediction,
        "exploration": ShownExploration,
        "realism": ShownRealism,
    }
    if path.suffix != ".json":
        return Session(number, name, path)
    return kinds.get(path.stem, ShownBuildings)(number, name, path)
