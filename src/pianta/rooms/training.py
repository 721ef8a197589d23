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
from pianta.labels import FCES, SCHEMAS, LabelSchema, LabelSet
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

# Buildings are left out by so many parts, to see what the trees say of rooms that they have not seen.
FOLDS = 5
# Trees of each forest; of those that only serve to leave buildings out; of those that give names.
TREES, FOLD_TREES, NAME_TREES = 80, 40, 30
# Of trees for functions, and of those that give names.
FUNCTION_PARAMETERS = TreeParameters(feature_share=0.4, min_leaf=4)
NAME_PARAMETERS = TreeParameters(feature_share=0.4, max_leaves=48)
# How much a room on a simulated map counts, where a drawn one counts 1.
SIMULATED_WEIGHT = 0.3


@dataclass(frozen=True, eq=False)
class Example:
    """A labelled floor: the context of its rooms, which function each has, and how much each counts."""

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
    schemas: Mapping[str, LabelSchema] = SCHEMAS,
    seed: int = 0,
) -> RoomModel:
    """Train a model of what rooms are for.

    Needs scikit-learn, which comes with pianta.

    Parameters
    ----------
    floors
        Floors whose rooms have labels of the schema of their building type. Each has a `source` of its own, which tells
        the building: house1.xml and house2.xml are floors of one, and are left out together when errors are measured.
        Where there are fewer than five buildings each floor counts as one.
    simulated
        Floors that were read from simulated maps of them, labelled by the truth; their rooms count less.
    schemas
        By building type, its labels.
    seed
        The same seed gives the same model.

    Returns
    -------
    RoomModel
        The model for `label_rooms`; `model.save(path)` writes it, `model.training` tells its errors on buildings that
        were left out.

    Raises
    ------
    LabelError
        Floors have no building type, or rooms no label of its schema; every fault is in one message.
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
    examples = [*list_examples(floors, schemas), *list_examples(simulated, schemas, weight=SIMULATED_WEIGHT)]
    model = train_on_examples(examples, schemas=schemas, seed=seed)
    sources = tuple(sorted(floor.source for floor in floors))
    return replace(model, training=replace(model.training, floors=sources))


def train_on_examples(
    examples: Sequence[Example], *, schemas: Mapping[str, LabelSchema] = SCHEMAS, seed: int = 0
) -> RoomModel:
    """Train a model on floors that are examples already, drawn ones before simulated ones; else as `train_rooms`."""
    folds = _leave_out(examples, np.random.default_rng(seed))
    # First pass: what the context of a room says
    seen = [example.context.features for example in examples]
    first = Forest.from_trees(_grow(seen, examples, trees=TREES, seed=seed), len(FUNCTIONS))
    held_out = _vote_on_held_out(seen, examples, folds, seed=seed)
    # Second pass: what is thought of the rooms around it, by trees that have not seen them
    around = [describe_neighbours(example.context, said) for example, said in zip(examples, held_out, strict=True)]
    second = Forest.from_trees(_grow(around, examples, trees=TREES, seed=seed), len(FUNCTIONS))
    held_out = _vote_on_held_out(around, examples, folds, seed=seed)
    # Random field and calibration, on what the second pass says of buildings that it has not seen
    near = join_neighbourhoods([example.context for example in examples])
    field = fit_random_field(np.concatenate(held_out), _truth(examples), near, _weights(examples))
    judged = field.compute_marginals(np.concatenate(held_out), near)
    names = {
        kind: Forest.from_trees(trees, len(schemas[kind].labels))
        for kind, trees in _grow_names(examples, around, seed=seed)
    }
    training = _describe_training(examples, _measure_errors(judged, examples), seed=seed)
    return RoomModel(first, second, field, names, {kind: schemas[kind] for kind in names}, training)


def building_name(source: str) -> str:
    """The building that a floor belongs to, by its file: folders as given, and the name up to one number at its end.

    house/floor1.xml and house/floor2.xml are floors of house/floor. A name that is a number stays as it is.
    """
    folders, slash, name = source.rpartition("/")
    stem = re.sub(r"\.[a-z]+$", "", name, flags=re.IGNORECASE)
    return folders + slash + (re.sub(r"[-_ ]*\d+$", "", stem) or name)


def check_labels(floors: Sequence[Floor], schemas: Mapping[str, LabelSchema] = SCHEMAS) -> None:
    """Check that floors can be learned from: each tells a type that has a schema, each room a label of it.

    Raises LabelError, with every fault in one message.
    """
    faults = [*_find_missing(floors)]
    for kind in dict.fromkeys(map(most_probable_type, floors)):
        labels = [
            room.label for floor in floors if most_probable_type(floor) == kind for room in floor.rooms if room.label
        ]
        try:
            if kind and kind not in schemas:
                raise LabelError(f"there is no schema of building type {kind!r}, give one of {', '.join(schemas)}")
            if kind:
                schemas[kind].map_labels(labels, LabelSet.TYPE)
        except LabelError as error:
            faults.append(str(error))
    if faults:
        raise LabelError(join_faults(faults))


def list_examples(
    floors: Sequence[Floor], schemas: Mapping[str, LabelSchema], *, weight: float = 1.0
) -> Iterator[Example]:
    """The floors that have rooms, as examples; their labels are those of their schemas (check_labels)."""
    for floor in floors:
        schema, labels = schemas[most_probable_type(floor)], [str(room.label) for room in floor.rooms]
        functions = [FUNCTIONS.index(FCES(name)) for name in schema.map_labels(labels, LabelSet.F_C_E_S)]
        every = [label.name for label in schema.labels]
        names = [every.index(name) for name in schema.map_labels(labels, LabelSet.TYPE)]
        if labels:
            context = describe_rooms(floor)
            kinds = floor.source, most_probable_type(floor)
            yield Example(weight, *kinds, context, np.array(functions), np.array(names))


def _find_missing(floors: Sequence[Floor]) -> Iterator[str]:
    """Faults of floors without a type, and of rooms without a label."""
    untyped = sorted({floor.source for floor in floors if not most_probable_type(floor)})
    if untyped:
        yield f"floors {join_faults(untyped)} do not tell their building type, give it by building_type="
    for floor in floors:
        unlabelled = [str(room.id) for room in floor.rooms if not room.label]
        if unlabelled:
            yield f"rooms {' '.join(unlabelled[:10])} of {floor.source} have no label, label every room or leave it out"


def most_probable_type(floor: Floor) -> str:
    """The most probable type of the building, empty if unknown."""
    return next(iter(floor.building_types), "")


def _leave_out(examples: Sequence[Example], rng: np.random.Generator) -> Indices:
    """Number of the part in which each example is left out, shape (examples,); a building is in one part."""
    names = [building_name(example.source) for example in examples]
    if len(set(names)) < FOLDS:  # house1, house2 and house3 are not the floors of one
        names = [example.source for example in examples]
    buildings = sorted(set(names))
    if len(buildings) < 2:
        raise ModelError(f"{len(buildings)} building is too few to train on, give two at least, better dozens")
    order = rng.permutation(len(buildings)) % min(FOLDS, len(buildings))
    return np.array([order[buildings.index(name)] for name in names])


def _truth(examples: Sequence[Example]) -> Indices:
    return np.concatenate([example.functions for example in examples])


def _weights(examples: Sequence[Example]) -> Floats:
    return np.concatenate([np.full(len(example.functions), example.weight) for example in examples])


def _grow(features: Sequence[Floats], examples: Sequence[Example], *, trees: int, seed: int) -> ExtraTrees:
    return grow_extra_trees(
        np.concatenate(features),
        _truth(examples),
        _weights(examples),
        trees=trees,
        seed=seed,
        parameters=FUNCTION_PARAMETERS,
    )


def _vote_on_held_out(
    features: Sequence[Floats], examples: Sequence[Example], folds: Indices, *, seed: int
) -> list[Floats]:
    """Probabilities of F/C/E/S for the rooms of each example, by trees that have not seen its building."""
    votes: list[Floats] = [np.zeros((0, len(FUNCTIONS)))] * len(examples)
    for fold in np.unique(folds):
        seen = np.flatnonzero(folds != fold).tolist()
        forest = _grow([features[i] for i in seen], [examples[i] for i in seen], trees=FOLD_TREES, seed=seed)
        for i in np.flatnonzero(folds == fold).tolist():
            votes[i] = forest.class_probabilities(features[i], len(FUNCTIONS))
    return votes


def _measure_errors(judged: Floats, examples: Sequence[Example]) -> dict[str, float]:
    """Share of drawn rooms that would get a wrong label, in both label sets."""
    drawn = _weights(examples) == 1
    chosen, truth = choose_functions(judged[drawn]), _truth(examples)[drawn]
    return {
        str(LabelSet.R_C): float(((chosen == CONNECTION) != (truth == CONNECTION)).mean()),
        str(LabelSet.F_C_E_S): float((chosen != truth).mean()),
    }


def _grow_names(
    examples: Sequence[Example], features: Sequence[Floats], *, seed: int
) -> Iterator[tuple[str, ExtraTrees]]:
    """By building type, trees that give the labels of the type."""
    for kind in sorted({example.building_type for example in examples}):
        of_kind = [i for i, example in enumerate(examples) if example.building_type == kind]
        names = np.concatenate([examples[i].names for i in of_kind])
        weights = _weights([examples[i] for i in of_kind])
        rows = np.concatenate([features[i] for i in of_kind])
        yield kind, grow_extra_trees(rows, names, weights, trees=NAME_TREES, seed=seed, parameters=NAME_PARAMETERS)


def _describe_training(examples: Sequence[Example], errors: Mapping[str, float], *, seed: int) -> Training:
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
