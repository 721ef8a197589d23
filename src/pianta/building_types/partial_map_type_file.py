"""The file of a PartialMapTypeModel: a NumPy archive (.npz) of its weights, trees and examples, and pianta.json."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from pianta.building_types.map_type_file import (
    MAX_FILE_BYTES,
    REMEDY,
    ExamplesHeader,
    describe_examples,
    pack_forest,
    read_examples,
    read_forest,
    read_header,
    save_archive,
)
from pianta.building_types.partial_map_types import PartialMapTypeModel, Regression
from pianta.errors import ModelError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._files import one_line_reason
from pianta.models import MODELS
from pianta.rooms.model_archive import ModelArchive

DEFAULT_PARTIAL_MODEL = MODELS / "partial_map_types.npz"
# The arrays of the regression, and their axes.
ARRAYS = {"mean": 1, "spread": 1, "weights": 2, "biases": 1}
ARRAYS_TYPE = "<f8"
FORMAT = FileFormat("pianta partial map types", 1, remedy=REMEDY)


def save_partial_map_type_model(model: PartialMapTypeModel, path: str | Path) -> None:
    """Write a model; what is read again predicts the same, and the same model always gives the same bytes."""
    header = ExamplesHeader(**describe_examples(FORMAT, model.classes, model.examples))
    arrays = {name: getattr(model.regression, name).astype(ARRAYS_TYPE) for name in ARRAYS}
    save_archive(path, header, arrays | pack_forest(model.forest), model.examples)


def read_partial_map_type_model(path: str | Path) -> PartialMapTypeModel:
    """Read a model that save_partial_map_type_model has written.

    Raises ModelError, in one line, for a file that is not a model, has other features, or whose weights or trees are
    damaged.
    """
    return read_checked(path, "model", ModelError, _parse_model, max_bytes=MAX_FILE_BYTES)


@cache
def read_default_partial_map_type_model() -> PartialMapTypeModel:
    """The model that comes with pianta."""
    return read_partial_map_type_model(DEFAULT_PARTIAL_MODEL)


def _parse_model(content: bytes) -> PartialMapTypeModel:
    with ModelArchive(content) as archive:
        header = read_header(archive, ExamplesHeader, FORMAT)
        examples = read_examples(archive, header)
        forest = read_forest(archive, header)
        try:
            arrays = {name: archive.read_array(name, ARRAYS_TYPE, axes=axes) for name, axes in ARRAYS.items()}
            regression = Regression(**arrays)
        except ModelError as error:
            raise ModelError(f"its weights are damaged: {one_line_reason(error)}; {REMEDY}") from None
    if regression.weights.shape != (len(header.classes), len(header.features)):
        raise ModelError(f"its weights are over other features or types than its header says; {REMEDY}")
    return PartialMapTypeModel(regression, forest, tuple(header.classes), examples)
