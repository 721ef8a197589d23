"""The file of a PlaceModel: a skops archive of its trees, with what else it holds in a member pianta.json.

A model file may come from a stranger. Nothing of it is loaded before the header has been read and all types in it are
known; there is no pickle in it, and the trees are checked before anything walks through them.
"""

from __future__ import annotations

import io
import warnings
import zipfile
import zlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from pianta.errors import ModelError, PiantaError
from pianta.io._faults import describe_validation
from pianta.io._files import checked_input, reason_of, shown, written_atomically
from pianta.labels import Label, LabelSchema
from pianta.models import MODELS
from pianta.rooms.features import CONTEXT_FEATURES
from pianta.rooms.model import AROUND, FUNCTIONS, PlaceModel, Training, vote
from pianta.rooms.random_field import RandomField

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

FORMAT: Final = "pianta places"
MAJOR, MINOR = 1, 0
HEADER = "pianta.json"
DEFAULT_MODEL = MODELS / "rooms.skops"
MAX_FILE_BYTES, MAX_CONTENT_BYTES, MAX_MEMBERS = 32 * 2**20, 512 * 2**20, 20_000
# Reviewed: the arrays of a tree, which _check_trees looks at before they are used.
TRUSTED_TYPES = ("sklearn.tree._tree.Tree",)


def save_place_model(model: PlaceModel, path: str | Path) -> None:
    """Write a model; read_place_model gives back one that says the same.

    Raises PiantaError when the file cannot be written.
    """
    from skops.io import dump

    content = io.BytesIO()
    trees = {"first": model.first, "second": model.second, "names": dict(model.names)}
    dump(trees, content, compression=zipfile.ZIP_DEFLATED, compresslevel=9)
    with zipfile.ZipFile(content, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(HEADER, _describe_model(model).model_dump_json(indent=1))
    with written_atomically(path) as temporary:
        temporary.write_bytes(content.getvalue())


def read_place_model(path: str | Path) -> PlaceModel:
    """Read a model that save_place_model has written.

    Raises ModelError, in one line, for a file that is no model, one of a newer format or for other features, and one
    that asks for types which are not trusted; nothing of it is loaded then.
    """
    file = checked_input(path, "model", ModelError)
    try:
        if file.stat().st_size > MAX_FILE_BYTES:
            raise ModelError(f"it has more than {MAX_FILE_BYTES} bytes, too many for a model")
        content = file.read_bytes()
        header = _read_header(content)
        return _build_model(header, _load_trees(content))
    except (ModelError, OSError) as error:
        raise ModelError(f"cannot read the model {shown(file)}: {reason_of(error)}") from error


@cache
def read_default_place_model() -> PlaceModel:
    """The model that comes with pianta; `training` says what it was trained on."""
    return read_place_model(DEFAULT_MODEL)


class _Part(BaseModel):
    # Infinite numbers are refused in the dataclasses of the model too.
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


class _Version(_Part):
    format: Literal["pianta places"]
    version: Annotated[str, Field(pattern=r"^[0-9]{1,4}\.[0-9]{1,4}$")]


class _Header(_Version):
    features: list[str]
    field: _Field
    schemas: dict[str, tuple[Label, ...]]
    training: Training


def _describe_model(model: PlaceModel) -> _Header:
    field = model.field
    return _Header(
        format=FORMAT,
        version=f"{MAJOR}.{MINOR}",
        features=list(CONTEXT_FEATURES),
        field=_Field(
            doors=field.doors.tolist(),
            alike=field.alike.tolist(),
            temperature=field.temperature,
            door_strength=field.door_strength,
            alike_strength=field.alike_strength,
        ),
        schemas={kind: schema.labels for kind, schema in model.schemas.items()},
        training=model.training,
    )


def _read_header(content: bytes) -> _Header:
    """The header of a model file; nothing else of it is looked at."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            if len(members) > MAX_MEMBERS or sum(member.file_size for member in members) > MAX_CONTENT_BYTES:
                raise ModelError(f"it unpacks to more than {MAX_CONTENT_BYTES} bytes, too many for a model")
            text = archive.read(HEADER)
    except ModelError:
        raise
    # A way of packing that zipfile does not know is a NotImplementedError, and an encrypted member a RuntimeError.
    except (zipfile.BadZipFile, zlib.error, KeyError, EOFError, RuntimeError, OSError, ValueError):
        raise ModelError("it is no model of pianta, make one with `pianta train places`") from None
    try:
        version = _Version.model_validate_json(text).version
        if int(version.partition(".")[0]) > MAJOR:
            raise ModelError(f"it has format version {version}, this pianta reads {MAJOR}.x; update pianta")
        header = _Header.model_validate_json(text)
    except ValidationError as exception:
        raise ModelError(describe_validation(exception)) from None
    if tuple(header.features) != CONTEXT_FEATURES:
        raise ModelError("it was trained on other features of rooms than this pianta computes, train it again")
    return header


def _load_trees(content: bytes) -> dict[str, Any]:
    """The trees of a model file, once all types in it are known to be harmless."""
    from skops.io import get_untrusted_types, loads

    try:
        strange = sorted(set(get_untrusted_types(data=content)) - set(TRUSTED_TYPES))
        if strange:
            raise ModelError(f"it asks for types that are not trusted: {', '.join(strange)}; do not use it")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a version of scikit-learn that differs; what does not fit is told below
            trees = loads(content, trusted=list(TRUSTED_TYPES))
    except ModelError:
        raise
    except Exception as exception:  # whatever a damaged archive provokes in the library
        raise ModelError(f"its trees cannot be loaded: {reason_of(exception)}; train it again") from None
    if not (
        isinstance(trees, dict) and {"first", "second", "names"} <= trees.keys() and isinstance(trees["names"], dict)
    ):
        raise ModelError("its trees are incomplete, train it again")
    return trees


def _build_model(header: _Header, trees: dict[str, Any]) -> PlaceModel:
    try:
        schemas = {kind: LabelSchema(kind, labels) for kind, labels in header.schemas.items()}
    except (PiantaError, ValueError) as error:
        raise ModelError(f"its labels are none: {reason_of(error)}") from None
    context = len(CONTEXT_FEATURES)
    around = context + AROUND * len(FUNCTIONS)
    if trees["names"].keys() != schemas.keys():
        raise ModelError("its trees do not fit its labels, train it again")
    _check_trees(trees["first"], features=context, classes=len(FUNCTIONS))
    _check_trees(trees["second"], features=around, classes=len(FUNCTIONS))
    for kind, schema in schemas.items():
        _check_trees(trees["names"][kind], features=around, classes=len(schema.labels))
    field = {name: getattr(header.field, name) for name in ("temperature", "door_strength", "alike_strength")}
    return PlaceModel(
        first=trees["first"],
        second=trees["second"],
        field=RandomField(np.array(header.field.doors), np.array(header.field.alike), **field),
        names=trees["names"],
        schemas=schemas,
        training=header.training,
    )


def _check_trees(forest: ExtraTreesClassifier, *, features: int, classes: int) -> None:
    """Raise ModelError for what is no forest over these features and classes, or has a way out of its trees."""
    try:
        # Votes are only asked for once no tree can lead out of its memory.
        sound = _is_forest(forest, features, classes)
        with np.errstate(all="ignore"):
            sound = sound and bool(np.isfinite(vote(forest, np.zeros((1, features)), classes)).all())
    except Exception:  # whatever a forest provokes that lacks a part, or has one of another kind
        sound = False
    if not sound:
        raise ModelError("its trees are damaged or of another kind, train it again")


def _is_forest(forest: ExtraTreesClassifier, features: int, classes: int) -> bool:
    """Whether it is a forest over some of the classes, all of whose trees are sound; raises where it lacks a part."""
    from sklearn.ensemble import ExtraTreesClassifier
    from sklearn.tree import ExtraTreeClassifier

    if not (isinstance(forest, ExtraTreesClassifier) and forest.n_features_in_ == features and forest.estimators_):
        return False
    known = np.asarray(forest.classes_)
    of_classes = known.dtype.kind == "i" and np.isin(known, np.arange(classes)).all() and len(set(known)) == len(known)
    return bool(of_classes) and all(
        isinstance(tree, ExtraTreeClassifier) and _is_sound(tree.tree_, features, len(known))
        for tree in forest.estimators_
    )


def _is_sound(tree: Any, features: int, classes: int) -> bool:  # noqa: ANN401
    """Whether every node of a tree leads further down, to a node that exists, by a feature that exists."""
    left, right, nodes = tree.children_left, tree.children_right, np.arange(tree.node_count)
    inner = left >= 0
    children = np.stack([left[inner], right[inner]])
    downwards = (children > nodes[inner]).all() and (children < tree.node_count).all()
    leaves = (left[~inner] == -1).all() and (right[~inner] == -1).all()
    by_feature = ((tree.feature[inner] >= 0) & (tree.feature[inner] < features)).all()
    shares = tree.value.shape == (tree.node_count, 1, classes) and np.isfinite(tree.value).all()
    return bool(tree.node_count > 0 and tree.n_features == features and downwards and leaves and by_feature and shares)
