"""Training of a RoomModel on labelled floors."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pianta import __version__
from pianta._types import Floats, Indices
from pianta.errors import LabelError, ModelError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import ALL_SCHEMAS, FCES, LabelSchema, LabelSet
from pianta.rooms.extra_trees import ExtraTrees, TreeParameters, grow_extra_trees
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.forest import Forest
from pianta.rooms.model import (
    CONNECTION,
    FUNCTIONS,
    RoomModel,
    Training,
    choose_functions,
    describe_neighbours,
    join_neighbourhoods,
)
from pianta.rooms.random_field import fit_random_field

# Folds of the cross-validation by buildings.
FOLDS = 5
# Extra-Trees over F/C/E/S, those of them that are grown for each fold, and trees over the labels of a building type.
# Chosen among a dozen runs on the 43 annotated floors (docs/methods/places.md), as the next weight.
FUNCTION_TREES = TreeParameters(trees=80, feature_share=0.4, min_leaf=4)
FOLD_TREES = replace(FUNCTION_TREES, trees=40)
LABEL_TREES = TreeParameters(trees=30, feature_share=0.4, max_leaves=48)
# Weight of a room on a simulated map, beside 1 for an annotated one.
SIMULATED_WEIGHT = 0.3


@dataclass(frozen=True, eq=False)
class TrainingFloor:
    """A labelled floor with the weight of its rooms.

    context: of the n rooms. functions, names: indices of their labels in FUNCTIONS and in the schema, shape (n,).
    """

    weight: float
    source: str
    building_type: str
    context: RoomContext
    functions: Indices
    names: Indices


def train_rooms(
    floors: Sequence[Floor],
    *,
    simulated: Sequence[Floor] = (),
    schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS,
    seed: int = 0,
) -> RoomModel:
    """Train a model of what rooms are for.

    Needs scikit-learn, which comes with pianta.

    Parameters
    ----------
    floors
        Floors whose rooms have labels of the schema of their building type. Each has its own `source`, which names the
        building: house1.xml and house2.xml are floors of one, and are left out together when errors are measured.
        If there are fewer than five buildings, each floor counts as one.
    simulated
        Floors reconstructed from simulated maps of them, with their true labels; their rooms have less weight.
    schemas
        By building type, its labels.
    seed
        The same seed gives the same model.

    Returns
    -------
    RoomModel
        The model for `label_rooms`; `model.save(path)` writes it, `model.training` has its errors on buildings
        that were left out.

    Raises
    ------
    LabelError
        Floors have no building type, or rooms no label of its schema; one message lists every fault.
    ModelError
        There are fewer than two buildings.

    References
    ----------
    M. Luperto, PhD thesis, chapter 5.

    Examples
    --------
    >>> import pianta
    >>> from dataclasses import replace
    >>> files = ("school1.xml", "town.xml")
    >>> floors = [replace(pianta.read_building(file), building_type={"school": 1}) for file in files]  # doctest: +SKIP
    >>> pianta.train_rooms(floors).save("rooms.npz")  # doctest: +SKIP
    """
    check_labels(floors, schemas)
    check_labels(simulated, schemas)
    examples = [*prepare_floors(floors, schemas), *prepare_floors(simulated, schemas, weight=SIMULATED_WEIGHT)]
    model = train_on_prepared(examples, schemas=schemas, seed=seed)
    sources = tuple(sorted(floor.source for floor in floors))
    return replace(model, training=replace(model.training, floors=sources))


def train_on_prepared(
    examples: Sequence[TrainingFloor], *, schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS, seed: int = 0
) -> RoomModel:
    """Train a model as `train_rooms`, on floors that `prepare_floors` has described; annotated ones come first."""
    folds = _assign_folds(examples, np.random.default_rng(seed))
    # First pass: the context of a room
    features = [example.context.features for example in examples]
    first = Forest.from_trees(_grow(features, examples, FUNCTION_TREES, seed=seed), len(FUNCTIONS))
    held_out = _predict_held_out(features, examples, folds, seed=seed)
    # Second pass: also what trees that were not trained on the building predict for the rooms around
    features = [describe_neighbours(each.context, around) for each, around in zip(examples, held_out, strict=True)]
    second = Forest.from_trees(_grow(features, examples, FUNCTION_TREES, seed=seed), len(FUNCTIONS))
    held_out = _predict_held_out(features, examples, folds, seed=seed)
    # Random field and its calibration: on predictions of the second pass for buildings that were left out
    near = join_neighbourhoods([example.context for example in examples])
    field = fit_random_field(np.concatenate(held_out), _join_truth(examples), near, _join_weights(examples))
    marginals = field.compute_marginals(np.concatenate(held_out), near)
    names = {
        building_type: Forest.from_trees(trees, len(schemas[building_type].labels))
        for building_type, trees in _grow_names(examples, features, seed=seed)
    }
    training = _describe_training(examples, _measure_errors(marginals, examples), seed=seed)
    return RoomModel(first, second, field, names, {name: schemas[name] for name in names}, training)


def building_name(source: str) -> str:
    """The building that a floor belongs to: its file name without suffix and the number at its end, with its folders.

    house/floor1.xml and house/floor2.xml are floors of house/floor. A name that is only a number stays.
    """
    folders, slash, name = source.rpartition("/")
    stem = re.sub(r"\.[a-z]+$", "", name, flags=re.IGNORECASE)
    return folders + slash + (re.sub(r"[-_ ]*\d+$", "", stem) or name)


def most_probable_type(floor: Floor) -> str:
    """The most probable building type of a floor, empty if unknown."""
    return next(iter(floor.building_types), "")


def check_labels(floors: Sequence[Floor], schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS) -> None:
    """Check that floors can be trained on: each has a building type with a schema, and each room a label of it.

    Raises LabelError, with every fault in one message.
    """
    faults = [*_find_missing(floors)]
    labels: dict[str, list[str]] = {}
    for floor in floors:
        labels.setdefault(most_probable_type(floor), []).extend(room.label for room in floor.rooms if room.label)
    for building_type in filter(None, labels):
        try:
            if building_type not in schemas:
                names = ", ".join(schemas)
                raise LabelError(f"there is no schema of building type {building_type!r}, give one of {names}")
            schemas[building_type].map_labels(labels[building_type], LabelSet.TYPE)
        except LabelError as error:
            faults.append(str(error))
    if faults:
        raise LabelError(join_faults(faults))


def prepare_floors(
    floors: Sequence[Floor], schemas: Mapping[str, LabelSchema], *, weight: float = 1.0
) -> Iterator[TrainingFloor]:
    """The floors that have rooms, described for training; their labels are known to be right (`check_labels`)."""
    for floor in floors:
        building_type, labels = most_probable_type(floor), [str(room.label) for room in floor.rooms]
        schema = schemas[building_type]
        functions = [FUNCTIONS.index(FCES(name)) for name in schema.map_labels(labels, LabelSet.F_C_E_S)]
        all_names = [label.name for label in schema.labels]
        names = [all_names.index(name) for name in schema.map_labels(labels, LabelSet.TYPE)]
        if labels:
            context = describe_rooms(floor)
            yield TrainingFloor(weight, floor.source, building_type, context, np.array(functions), np.array(names))


def _find_missing(floors: Sequence[Floor]) -> Iterator[str]:
    """Faults: floors without a building type, and rooms without a label."""
    untyped = sorted({floor.source for floor in floors if not most_probable_type(floor)})
    if untyped:
        yield f"floors {join_faults(untyped)} do not have a building type, give it by building_type="
    for floor in floors:
        unlabelled = [str(room.id) for room in floor.rooms if not room.label]
        if unlabelled:
            yield f"rooms {' '.join(unlabelled[:10])} of {floor.source} have no label, label every room or leave it out"


def _assign_folds(examples: Sequence[TrainingFloor], rng: np.random.Generator) -> Indices:
    """The fold of each floor, shape (floors,); floors of one building have the same."""
    names = [building_name(example.source) for example in examples]
    if len(set(names)) < FOLDS:  # house1, house2 and house3 may be all there are, and are then not of one building.
        names = [example.source for example in examples]
    buildings = sorted(set(names))
    if len(buildings) < 2:
        raise ModelError(f"{len(buildings)} building is too few to train on, give two at least, better dozens")
    order = rng.permutation(len(buildings)) % min(FOLDS, len(buildings))
    return np.array([order[buildings.index(name)] for name in names])


def _join_truth(examples: Sequence[TrainingFloor]) -> Indices:
    return np.concatenate([example.functions for example in examples])


def _join_weights(examples: Sequence[TrainingFloor]) -> Floats:
    return np.concatenate([np.full(len(example.functions), example.weight) for example in examples])


def _grow(
    features: Sequence[Floats], examples: Sequence[TrainingFloor], parameters: TreeParameters, *, seed: int
) -> ExtraTrees:
    """Extra-Trees over F/C/E/S."""
    rows, truth, weights = np.concatenate(features), _join_truth(examples), _join_weights(examples)
    return grow_extra_trees(rows, truth, weights, parameters=parameters, seed=seed)


def _predict_held_out(
    features: Sequence[Floats], examples: Sequence[TrainingFloor], folds: Indices, *, seed: int
) -> list[Floats]:
    """Probabilities of F/C/E/S of the rooms of each floor, by trees that were not trained on its building."""
    probabilities: list[Floats] = [np.zeros((0, len(FUNCTIONS)))] * len(examples)
    for fold in np.unique(folds):
        others = np.flatnonzero(folds != fold).tolist()
        forest = _grow([features[i] for i in others], [examples[i] for i in others], FOLD_TREES, seed=seed)
        for i in np.flatnonzero(folds == fold).tolist():
            probabilities[i] = forest.class_probabilities(features[i], len(FUNCTIONS))
    return probabilities


def _measure_errors(probabilities: Floats, examples: Sequence[TrainingFloor]) -> dict[str, float]:
    """Share of annotated rooms with a wrong label, in both label sets."""
    annotated = _join_weights(examples) == 1
    chosen, truth = choose_functions(probabilities[annotated]), _join_truth(examples)[annotated]
    return {
        str(LabelSet.R_C): float(((chosen == CONNECTION) != (truth == CONNECTION)).mean()),
        str(LabelSet.F_C_E_S): float((chosen != truth).mean()),
    }


def _grow_names(
    examples: Sequence[TrainingFloor], features: Sequence[Floats], *, seed: int
) -> Iterator[tuple[str, ExtraTrees]]:
    """By building type, Extra-Trees over its labels."""
    for building_type in sorted({example.building_type for example in examples}):
        chosen = [i for i, example in enumerate(examples) if example.building_type == building_type]
        names = np.concatenate([examples[i].names for i in chosen])
        weights = _join_weights([examples[i] for i in chosen])
        rows = np.concatenate([features[i] for i in chosen])
        forest = grow_extra_trees(rows, names, weights, parameters=LABEL_TREES, seed=seed)
        yield building_type, forest


def _describe_training(examples: Sequence[TrainingFloor], errors: Mapping[str, float], *, seed: int) -> Training:
    """What the model was trained on; errors: by label set, the share of wrong labels, 0 … 1."""
    from sklearn import __version__ as sklearn_version

    rooms: Counter[str] = Counter()
    for example in examples:
        rooms[example.building_type] += len(example.functions)
    return Training(
        floors=tuple(sorted(example.source for example in examples if example.weight == 1)),
        rooms=rooms,
        simulated=sum(example.weight != 1 for example in examples),
        errors=errors,
        seed=seed,
        pianta=__version__,
        sklearn=sklearn_version,
    )
