"""Results of realism on the page: floors with their figures, and why a floor is unusual."""

from __future__ import annotations

import json
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, JsonValue

from pianta.errors import DataError
from pianta.gridmap import GridMap
from pianta.io._checked import read_checked
from pianta.io._faults import validation_as
from pianta.io._files import count_noun
from pianta.io.floors import parse_floor
from pianta.view.result_sessions import ResultSession, describe_shapes

FILE_NAME = "realism.json"
MAX_FILE_BYTES = 256 * 2**20
# Floors that the page shows; a limit of time, chosen by hand.
MAX_FLOORS = 1000


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)


class _Measure(_Part):
    name: str
    value: FiniteFloat
    reason: str


class _Pattern(_Part):
    reason: str


class _Floor(_Part):
    floor: str
    score: FiniteFloat
    verdict: str
    typicality: FiniteFloat
    probability: FiniteFloat | None
    likeness: FiniteFloat
    alike: list[str]
    measures: list[_Measure]
    patterns: list[_Pattern]
    shapes: dict[str, JsonValue] | None = None


class SavedRealism(_Part):
    """The content of realism.json; shapes: GeoJSON as in floor.geojson."""

    label_set: str
    reference: list[str]
    unrealistic: list[str]
    floors: Annotated[list[_Floor], Field(min_length=1, max_length=MAX_FLOORS)]


class RealismSession(ResultSession[SavedRealism]):
    """A folder of `pianta realism -o`; its parts are the floors."""

    kind: ClassVar[str] = "realism"
    patterns: ClassVar[tuple[str, ...]] = (FILE_NAME,)

    def _read(self) -> SavedRealism:
        parse = validation_as(DataError)(SavedRealism.model_validate_json)
        return read_checked(self.file, "realism", DataError, parse, max_bytes=MAX_FILE_BYTES)

    def _list_facts(self, content: SavedRealism) -> list[str]:
        scores = [floor.score for floor in content.floors]
        compared = f"{len(content.reference)} reference floors"
        return [count_noun(len(scores), "floor"), f"scores {min(scores):.2f} to {max(scores):.2f}", compared]

    def _describe(self, content: SavedRealism, version: str) -> dict[str, Any]:
        del version
        measures = {each.name for floor in content.floors for each in floor.measures}
        columns = {"score": "score", "typicality": "typicality", "likeness": "likeness"}
        columns |= {"probability": "probability"} if content.unrealistic else {}
        return {
            "columns": columns | {name: name for name in sorted(measures)},
            "items": [*map(_describe, content.floors)],
        }

    def _count_parts(self, content: SavedRealism) -> int:
        return len(content.floors)

    def _describe_part(self, content: SavedRealism, part: int, version: str) -> dict[str, Any]:
        del version
        shapes = content.floors[part].shapes
        if shapes is None:
            return {"floor": {"features": []}, "graph": []}
        return describe_shapes(parse_floor(json.dumps(shapes).encode()))

    def _open_picture(self, content: SavedRealism, part: int) -> GridMap | None:
        del content, part
        return None


def _describe(floor: _Floor) -> dict[str, Any]:
    """A floor in the list: its figures, and the texts that explain its score."""
    figures = {"score": floor.score, "typicality": floor.typicality, "likeness": floor.likeness}
    figures |= {"probability": floor.probability} if floor.probability is not None else {}
    figures |= {each.name: each.value for each in floor.measures}
    reasons = [*(each.reason for each in floor.measures), *(each.reason for each in floor.patterns)]
    texts = [floor.verdict, f"most like {', '.join(floor.alike)}", *reasons]
    return {"name": floor.floor, "figures": figures, "texts": texts}
