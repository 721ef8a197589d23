"""The file of a RoomModel: a NumPy archive (.npz) of its trees, with all else in a member pianta.json.

A model file may be hostile. Nothing of it is unpacked before its sizes are known, and no tree before the header has
been read; it has no pickle, and trees are checked before they are used.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.errors import ModelError, PiantaError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.io._files import atomic_file, one_line_reason, short_repr
from pianta.labels import Label, LabelSchema
from pianta.models import MODELS
from pianta.rooms.features import CONTEXT_FEATURES
from pianta.rooms.forest import Forest
from pianta.rooms.model import FUNCTIONS, N_NEIGHBOUR_BLOCKS, RoomModel, Training
from pianta.rooms.model_archive import NO_MODEL, ModelArchive, pack_archive
from pianta.rooms.random_field import RandomField

SUFFIX = ".npz"
HEADER = "pianta.json"
DEFAULT_MODEL = MODELS / "rooms.npz"
MAX_FILE_BYTES = 32 * 2**20
# The arrays of a Forest, their types and axes.
ARRAYS = {"features": ("<i2", 1), "thresholds": ("<f4", 1), "votes": ("<f8", 2)}
REMEDY = "train it again with `pianta train places`"
# Version 1 had the trees as objects of scikit-learn, in a skops archive.
FORMAT = FileFormat("pianta places", 2, oldest=2, remedy=REMEDY)


def check_model_path(path: str | Path) -> None:
    """Raise ModelError, in one line, for a file name that does not end in .npz."""
    if Path(path).suffix.lower() != SUFFIX:
        raise ModelError(f"model file {short_repr(path)} does not end in {SUFFIX}, give a name that does")


def save_room_model(model: RoomModel, path: str | Path) -> None:
    """Write a model; what is read again predicts the same, and the same model always gives the same bytes.

    Raises ModelError as check_model_path does, PiantaError if the file cannot be written.
    """
    check_model_path(path)
    forests = {"first": model.first, "second": model.second}
    forests |= {f"names.{number}": model.names[each] for number, each in enumerate(model.schemas)}
    arrays = {
        f"{key}.{name}": getattr(forest, name).astype(dtype)
        for key, forest in forests.items()
        for name, (dtype, _) in ARRAYS.items()
    }
    content = pack_archive(_describe_model(model).model_dump_json(indent=1), HEADER, arrays)
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


def read_room_model(path: str | Path) -> RoomModel:
    """Read a model that save_room_model has written.

    Raises ModelError, in one line, for a file that is not a model, has another version or other features, or whose
    trees are damaged.
    """
    return read_checked(path, "model", ModelError, _parse_model, max_bytes=MAX_FILE_BYTES)


def _parse_model(content: bytes) -> RoomModel:
    with ModelArchive(content) as archive:
        return _build_model(_read_header(archive), archive)


@cache
def read_default_room_model() -> RoomModel:
    """The model that comes with pianta."""
    return read_room_model(DEFAULT_MODEL)


class _Part(BaseModel):
    # allow_inf_nan holds for the dataclasses of the model too.
    model_config = ConfigDict(strict=True, frozen=True, allow_inf_nan=False)


_Table = Annotated[
    list[Annotated[list[FiniteFloat], Field(min_length=4, max_length=4)]], Field(min_length=4, max_length=4)
]


class _Field(_Part):
    doors: _Table
    alike: _Table
    temperature: Annotated[FiniteFloat, Field(gt=0)]
    door_strength: FiniteFloat
    alike_strength: FiniteFloat


class _Header(_Part):
    format: str
    version: str
    features: list[str]
    field: _Field
    schemas: dict[str, tuple[Label, ...]]
    training: Training


def _describe_model(model: RoomModel) -> _Header:
    """The header of a model file: the model without its trees."""
    field = model.field
    return _Header(
        **FORMAT.header,
        features=list(CONTEXT_FEATURES),
        field=_Field(
            doors=field.doors.tolist(),
            alike=field.alike.tolist(),
            temperature=field.temperature,
            door_strength=field.door_strength,
            alike_strength=field.alike_strength,
        ),
        schemas={name: schema.labels for name, schema in model.schemas.items()},
        training=model.training,
    )


@validation_as(ModelError)
def _read_header(archive: ModelArchive) -> _Header:
    """The header of a model file; a fault of its version comes before all others."""
    try:
        text = archive.read(HEADER)
    except ModelError:
        raise ModelError(NO_MODEL) from None
    FORMAT.check_version(text, ModelError)
    header = _Header.model_validate_json(text)
    if tuple(header.features) != CONTEXT_FEATURES:
        raise ModelError(f"it was trained on other features of rooms than this pianta computes; {REMEDY}")
    return header


def _build_model(header: _Header, archive: ModelArchive) -> RoomModel:
    """The model from its header and the trees in the archive; ModelError for invalid labels or trees."""
    try:
        schemas = {name: LabelSchema(name, labels) for name, labels in header.schemas.items()}
    except (PiantaError, ValueError) as error:
        raise ModelError(f"its labels are invalid: {one_line_reason(error)}") from None
    context = len(CONTEXT_FEATURES)
    around = context + N_NEIGHBOUR_BLOCKS * len(FUNCTIONS)
    field = {name: getattr(header.field, name) for name in ("temperature", "door_strength", "alike_strength")}
    return RoomModel(
        first=_read_forest(archive, "first", features=context, classes=len(FUNCTIONS)),
        second=_read_forest(archive, "second", features=around, classes=len(FUNCTIONS)),
        field=RandomField(np.array(header.field.doors), np.array(header.field.alike), **field),
        names={
            name: _read_forest(archive, f"names.{number}", features=around, classes=len(schema.labels))
            for number, (name, schema) in enumerate(schemas.items())
        },
        schemas=schemas,
        training=header.training,
    )


def _read_forest(archive: ModelArchive, key: str, *, features: int, classes: int) -> Forest:
    """A forest of the archive; raises ModelError if it is damaged or has other features or classes."""
    try:
        forest = Forest(
            **{name: archive.read_array(f"{key}.{name}", dtype, axes=axes) for name, (dtype, axes) in ARRAYS.items()}
        )
    except ModelError as error:
        raise ModelError(f"its trees are damaged: {one_line_reason(error)}; {REMEDY}") from None
    if forest.features.max() >= features or forest.classes != classes:
        raise ModelError(f"its trees are over other features or labels than its header says; {REMEDY}")
    return forest
