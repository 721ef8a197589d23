"""The file of a BuildingTypeModel: JSON with its training floors, a line for each, and what is fitted to them.

A model file may be hostile. All of it is numbers and names, which are checked before they are used. Files of version 1
have only the floors: the model is then fitted when it is first used.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from pianta.building_types.description import BuildingDescription, name_features
from pianta.building_types.model import BuildingTypeModel, FittedTypes, check_types
from pianta.building_types.svm import BuildingTypeSvm
from pianta.building_types.typicality import Typicality
from pianta.errors import ModelError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import describe_validation, join_faults
from pianta.io._files import atomic_file, short_repr
from pianta.labels import LabelSet, standard_building_type
from pianta.models import MODELS
from pianta.rooms.completion import LABELS

FORMAT = FileFormat("pianta buildings", 2)
# The version that has only floors.
VERSION_WITHOUT_FIT = 1
DEFAULT_MODEL = MODELS / "building_types.json"
# Limits far above any real model, against files that would exhaust time or memory.
MAX_FILE_BYTES = 16 * 2**20
MAX_FLOORS = 1000
MAX_ROOMS = 1000
# Pairs of rooms of one floor, over all floors: counting patterns takes time in proportion. 6000 floors of 40 rooms.
MAX_PAIRS = 10_000_000
# Absolute value of any number of a floor.
MAX_NUMBER = 1e6


def save_building_type_model(model: BuildingTypeModel, path: str | Path) -> None:
    """Write a model; what is read again predicts the same, and the same model always gives the same bytes.

    Raises ModelError for a model that read_building_type_model would refuse, PiantaError if it cannot be written.
    """
    try:
        floors = _describe_floors(model)
        # Checked first, as nothing can be fitted to floors of one type.
        _check_model(floors)
        content = _FittedModel(**dict(floors), learnt=_describe_fit(model.fitted))
        _check_model(content)
    except (ModelError, ValidationError) as error:
        reason = describe_validation(error) if isinstance(error, ValidationError) else error
        raise ModelError(f"the model cannot be saved: {reason}") from None
    head = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in content.model_dump(exclude={"floors"}).items()]
    lines = [json.dumps(floor.model_dump(by_alias=True), separators=(",", ":")) for floor in content.floors]
    text = "{\n" + ",\n".join([*head, '"floors": [\n' + ",\n".join(lines) + "\n]"]) + "\n}\n"
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def read_building_type_model(path: str | Path) -> BuildingTypeModel:
    """Read a model that save_building_type_model has written.

    Raises ModelError, in one line, for a file that is not a model, has a newer format or other features, or whose
    floors are impossible.
    """
    content = read_checked(path, "model", ModelError, _parse_model, max_bytes=MAX_FILE_BYTES)
    return BuildingTypeModel(
        training_floors=tuple(floor.describe() for floor in content.floors),
        types=tuple(floor.building_type for floor in content.floors),
        buildings=tuple(floor.building for floor in content.floors),
        label_set=LabelSet(content.label_set),
        stored_fit=content.learnt.describe() if isinstance(content, _FittedModel) else None,
    )


@cache
def read_default_building_type_model() -> BuildingTypeModel:
    """The model that comes with pianta."""
    return read_building_type_model(DEFAULT_MODEL)


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, populate_by_name=True)


_Name = Annotated[str, Field(max_length=1000)]
_Number = Annotated[FiniteFloat, Field(ge=-MAX_NUMBER, le=MAX_NUMBER)]
_Rooms = Field(min_length=1, max_length=MAX_ROOMS)


class _Floor(_Part):
    source: _Name
    building_type: Annotated[str, AfterValidator(standard_building_type), Field(alias="type")]
    building: _Name
    features: tuple[_Number, ...]
    labels: Annotated[tuple[str, ...], _Rooms]
    sizes: Annotated[tuple[_Number, ...], _Rooms]
    sides: Annotated[tuple[Annotated[int, Field(ge=0, le=2)], ...], _Rooms]
    doors: tuple[tuple[int, int], ...]

    @model_validator(mode="after")
    def _check(self) -> Self:
        """Raise ValueError for lists of unequal length, and unless doors are distinct pairs of rooms, smaller first."""
        rooms = len(self.labels)
        if not rooms == len(self.sizes) == len(self.sides):
            raise ValueError("labels, sizes and sides are not of the same rooms")
        if not all(0 <= one < other < rooms for one, other in self.doors) or len(set(self.doors)) < len(self.doors):
            raise ValueError(f"doors are not pairs of its {rooms} rooms, each once and the smaller number first")
        return self

    def describe(self) -> BuildingDescription:
        """The floor as a BuildingTypeModel has it."""
        features = np.array(self.features)
        return BuildingDescription(self.source, features, self.labels, self.sizes, self.sides, self.doors)


_Numbers = tuple[_Number, ...]


class _Fit(_Part):
    weights: tuple[_Numbers, ...]
    intercepts: _Numbers
    slopes: tuple[_Numbers, ...]
    offsets: _Numbers
    likenesses: _Numbers

    def find_faults(self, floors: int, types: int) -> str | None:
        """What in the fit contradicts a model of these numbers of floors and types; None if nothing does."""
        shapes = {
            "weights": (floors, types - 1),
            "intercepts": (types * (types - 1) // 2,),
            "slopes": (1 if types == 2 else types, types),
            "offsets": (types,),
            "likenesses": (floors,),
        }
        faults = [
            f"{name} are not {' × '.join(map(str, shape))}"
            for name, shape in shapes.items()
            if _find_shape(getattr(self, name)) != shape
        ]
        if list(self.likenesses) != sorted(self.likenesses):
            faults.append("likenesses do not ascend")
        return join_faults(faults) if faults else None

    def describe(self) -> FittedTypes:
        """The fit as a BuildingTypeModel has it."""
        arrays = (np.array(each) for each in (self.weights, self.intercepts, self.slopes, self.offsets))
        return FittedTypes(BuildingTypeSvm(*arrays), Typicality(np.array(self.likenesses)))


class _Model(_Part):
    format: str
    version: str
    label_set: Literal["R/C", "F/C/E/S"]
    features: tuple[str, ...]
    floors: Annotated[tuple[_Floor, ...], Field(max_length=MAX_FLOORS)]


class _FittedModel(_Model):
    learnt: _Fit


def _find_shape(numbers: tuple[object, ...]) -> tuple[int, ...] | None:
    """The shape of an array, None if its rows differ in length."""
    lengths = {len(row) for row in numbers if isinstance(row, tuple)}
    return (len(numbers), *lengths) if len(lengths) <= 1 else None


def _describe_fit(fitted: FittedTypes) -> _Fit:
    """What is fitted to the training floors, as the file has it."""
    svm = fitted.svm
    return _Fit(
        weights=tuple(map(tuple, svm.weights.tolist())),
        intercepts=tuple(svm.intercepts.tolist()),
        slopes=tuple(map(tuple, svm.slopes.tolist())),
        offsets=tuple(svm.offsets.tolist()),
        likenesses=tuple(fitted.typicality.likenesses.tolist()),
    )


def _describe_floors(model: BuildingTypeModel) -> _Model:
    """The content of a model file, except what is fitted."""
    floors = tuple(
        _Floor(
            source=floor.source,
            building_type=building_type,
            building=building,
            features=tuple(floor.features.tolist()),
            labels=floor.labels,
            sizes=floor.sizes,
            sides=floor.sides,
            doors=floor.doors,
        )
        for floor, building_type, building in zip(model.training_floors, model.types, model.buildings, strict=True)
    )
    return _Model.model_validate(
        {
            **FORMAT.header,
            "label_set": str(model.label_set),
            "features": name_features(model.label_set),
            "floors": floors,
        }
    )


def _parse_model(content: bytes) -> _Model:
    """The checked content of a model file; a wrong version is reported before any other fault."""
    try:
        major, _ = FORMAT.check_version(content, ModelError)
        model = (_FittedModel if major > VERSION_WITHOUT_FIT else _Model).model_validate_json(content)
    except ValidationError as exception:
        if any(
            fault["type"] == "json_invalid" or not fault["loc"] or fault["loc"] == ("format",)
            for fault in exception.errors()
        ):
            reason = "it is no model of building types, or damaged; make one with `pianta train buildings`"
            raise ModelError(reason) from None
        raise ModelError(describe_validation(exception)) from None
    _check_model(model)
    return model


def _check_model(model: _Model) -> None:
    """Raise ModelError for other features or labels, too many rooms, fewer than two types, or a fit of other floors."""
    label_set = LabelSet(model.label_set)
    names = name_features(label_set)
    if model.features != names:
        raise ModelError("it was trained on other features of floors than this pianta computes, train it again")
    faults = [
        f"floor {short_repr(floor.source)} has {len(floor.features)} features of {len(names)}"
        for floor in model.floors
        if len(floor.features) != len(names)
    ]
    unknown = sorted({label for floor in model.floors for label in floor.labels} - set(LABELS[label_set]))
    if unknown:
        faults.append(f"its rooms have labels that are not of {label_set}: {join_faults([*map(short_repr, unknown)])}")
    if sum(len(floor.labels) ** 2 for floor in model.floors) > MAX_PAIRS:
        faults.append(f"its floors have more than {MAX_PAIRS} pairs of rooms, too many for a model")
    if faults:
        raise ModelError(join_faults(faults))
    check_types([floor.building_type for floor in model.floors], [floor.building for floor in model.floors])
    if isinstance(model, _FittedModel):
        types = len({floor.building_type for floor in model.floors})
        if fault := model.learnt.find_faults(len(model.floors), types):
            raise ModelError(f"what it has learnt does not fit its floors: {fault}; train it again")
