"""The file of a MapTypeModel: a NumPy archive (.npz) of its trees and its examples, with all else in pianta.json."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.building_types.map_types import MapExamples, MapTypeModel, name_map_features
from pianta.errors import ModelError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.io._files import atomic_file, one_line_reason
from pianta.models import MODELS
from pianta.rooms.forest import Forest
from pianta.rooms.model_archive import ModelArchive, pack_archive

HEADER = "pianta.json"
DEFAULT_MODEL = MODELS / "map_types.npz"
MAX_FILE_BYTES = 16 * 2**20
# The arrays of the forest and the examples, their types and axes.
FOREST_ARRAYS = {"features": ("<i2", 1), "thresholds": ("<f4", 1), "votes": ("<f8", 2)}
EXAMPLES = "examples"
EXAMPLES_TYPE = "<f4"
REMEDY = "make it again by the script that its card names"
FORMAT = FileFormat("pianta map types", 1, remedy=REMEDY)


class ExamplesHeader(BaseModel):
    """What the file of a model of maps says of it and of its examples."""

    model_config = ConfigDict(strict=True, frozen=True)

    format: str
    version: str
    features: list[str]
    classes: Annotated[list[str], Field(min_length=2)]
    types: list[str]
    buildings: list[str]
    sources: list[str]


class _Header(ExamplesHeader):
    temperature: Annotated[FiniteFloat, Field(gt=0)]


HeaderT = TypeVar("HeaderT", bound=ExamplesHeader)


def save_map_type_model(model: MapTypeModel, path: str | Path) -> None:
    """Write a model; what is read again predicts the same, and the same model always gives the same bytes."""
    header = _Header(**describe_examples(FORMAT, model.classes, model.examples), temperature=model.temperature)
    save_archive(path, header, pack_forest(model.forest), model.examples)


def describe_examples(file_format: FileFormat, classes: tuple[str, ...], examples: MapExamples) -> dict[str, Any]:
    """The fields of an ExamplesHeader."""
    return {
        **file_format.header,
        "features": list(name_map_features()),
        "classes": list(classes),
        "types": list(examples.types),
        "buildings": list(examples.buildings),
        "sources": list(examples.sources),
    }


def pack_forest(forest: Forest) -> dict[str, NDArray[Any]]:
    """The arrays of a forest by name."""
    return {name: getattr(forest, name).astype(dtype) for name, (dtype, _) in FOREST_ARRAYS.items()}


def save_archive(
    path: str | Path, header: ExamplesHeader, arrays: Mapping[str, NDArray[Any]], examples: MapExamples
) -> None:
    """Write the archive of a model with its examples, whole or not at all."""
    stored = {**arrays, EXAMPLES: examples.features.astype(EXAMPLES_TYPE)}
    with atomic_file(path) as temporary:
        temporary.write_bytes(pack_archive(header.model_dump_json(indent=1), HEADER, stored))


def read_map_type_model(path: str | Path) -> MapTypeModel:
    """Read a model that save_map_type_model has written.

    Raises ModelError, in one line, for a file that is not a model, has other features, or whose trees are damaged.
    """
    return read_checked(path, "model", ModelError, _parse_model, max_bytes=MAX_FILE_BYTES)


@cache
def read_default_map_type_model() -> MapTypeModel:
    """The model that comes with pianta."""
    return read_map_type_model(DEFAULT_MODEL)


def _parse_model(content: bytes) -> MapTypeModel:
    with ModelArchive(content) as archive:
        header = read_header(archive, _Header, FORMAT)
        forest, examples = read_forest(archive, header), read_examples(archive, header)
    return MapTypeModel(forest, tuple(header.classes), header.temperature, examples)


@validation_as(ModelError)
def read_header(archive: ModelArchive, header_class: type[HeaderT], file_format: FileFormat) -> HeaderT:
    """The header of the file of a model of maps; a fault of its version comes before all others.

    Raises ModelError for a damaged header, and for other features than those that are computed.
    """
    text = archive.read(HEADER)
    file_format.check_version(text, ModelError)
    header = header_class.model_validate_json(text)
    if tuple(header.features) != name_map_features():
        raise ModelError(f"it was trained on other features of floors than this pianta computes; {REMEDY}")
    return header


def read_forest(archive: ModelArchive, header: ExamplesHeader) -> Forest:
    """The forest of a model of maps; raises ModelError if it is damaged, or not that of the header."""
    try:
        arrays = {name: archive.read_array(name, dtype, axes=axes) for name, (dtype, axes) in FOREST_ARRAYS.items()}
        forest = Forest(**arrays)
    except ModelError as error:
        raise ModelError(f"its trees are damaged: {one_line_reason(error)}; {REMEDY}") from None
    if forest.features.max() >= len(header.features) or forest.classes != len(header.classes):
        raise ModelError(f"its trees are over other features or types than its header says; {REMEDY}")
    return forest


def read_examples(archive: ModelArchive, header: ExamplesHeader) -> MapExamples:
    """The examples of a model of maps; raises ModelError if they are damaged, or not those of the header."""
    features = archive.read_array(EXAMPLES, EXAMPLES_TYPE, axes=2)
    lengths = {len(features), len(header.types), len(header.buildings), len(header.sources)}
    if len(lengths) > 1 or features.shape[1] != len(header.features):
        raise ModelError(f"its examples are not those of its header; {REMEDY}")
    examples = MapExamples(features.astype(float), tuple(header.types), tuple(header.buildings), tuple(header.sources))
    if not np.isfinite(examples.features).all() or examples.classes != tuple(header.classes):
        raise ModelError(f"its examples are not finite, or not of the types of its header; {REMEDY}")
    return examples
