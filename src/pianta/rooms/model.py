"""What each room is for: R/C, F/C/E/S, and the labels of its building type, with probabilities.

The thesis classifies rooms one by one with Extra-Trees (sections 5.3 and 6.1.3). Here the same trees know the context
of a room in its building (RoomContext), a second pass uses what the first one predicts for the rooms around it, and a
random field decides about the floor as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.floor import Floor, Room
from pianta.labels import FCES, RC, LabelSchema, LabelSet
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.forest import Forest
from pianta.rooms.random_field import Neighbourhood, RandomField

FUNCTIONS = tuple(FCES)
CONNECTION = FUNCTIONS.index(FCES.CONNECTION)
# Blocks of columns, each with one column a label, that describe_neighbours adds to the context of a room.
N_NEIGHBOUR_BLOCKS = 9
# Added to the votes for each name, so that names without any vote share the probability of their function.
VOTE_SMOOTHING = 1e-6


@dataclass(frozen=True)
class Training:
    """What a model was trained on.

    floors: sources of the annotated floors, sorted. rooms: number of rooms by building type, with simulated maps.
    simulated: number of simulated maps. errors: by label set, the share of annotated rooms with a wrong label when
    their building is left out; the random field was fitted on the same rooms. seed, pianta, sklearn: seed and versions
    that train the same model again.
    """

    floors: tuple[str, ...]
    rooms: Mapping[str, int]
    simulated: int
    errors: Mapping[str, float]
    seed: int
    pianta: str
    sklearn: str

    def __str__(self) -> str:
        rooms = ", ".join(f"{count} rooms of type {name}" for name, count in sorted(self.rooms.items()))
        simulated = f", and {self.simulated} simulated maps of them" if self.simulated else ""
        return f"{len(self.floors)} floors{simulated}: {rooms}"


@dataclass(frozen=True, eq=False)
class RoomModel:
    """A trained model of what rooms are for.

    Attributes
    ----------
    first, second
        Extra-Trees over F/C/E/S, on the context of a room, and on that and the predictions of the first around it.
    field
        The random field over the rooms of a floor.
    names
        By building type, Extra-Trees over its labels.
    schemas
        By building type, its labels.
    training
        What it was trained on, and its errors on buildings that were left out.
    """

    first: Forest
    second: Forest
    field: RandomField
    names: Mapping[str, Forest]
    schemas: Mapping[str, LabelSchema]
    training: Training

    def save(self, path: str | Path) -> None:
        """Write the model as an .npz file that `load_model` reads.

        Parameters
        ----------
        path
            The file, which ends in .npz; an older one is replaced.

        Raises
        ------
        ModelError
            The path has another suffix.
        PiantaError
            The file cannot be written.
        """
        from pianta.rooms.model_file import save_room_model

        save_room_model(self, path)

    def passes(self, floor: Floor) -> dict[str, Floats]:
        """Compute the probabilities of F/C/E/S after each step.

        Parameters
        ----------
        floor
            A floor with rooms.

        Returns
        -------
        dict
            By "first pass", "second pass" and "random field", probabilities of shape (rooms, 4), columns in the order
            of FCES; those of the last step are calibrated.
        """
        return self.predict_functions(describe_rooms(floor))

    def predict_functions(self, context: RoomContext) -> dict[str, Floats]:
        """Compute the probabilities of F/C/E/S after each step, from the context of the rooms.

        Parameters
        ----------
        context
            Of the rooms of a floor, by `describe_rooms`.

        Returns
        -------
        dict
            As of `passes`.
        """
        first = self.first.predict(context.features)
        second = self.second.predict(describe_neighbours(context, first))
        marginals = self.field.compute_marginals(second, find_neighbourhood(context))
        return {"first pass": first, "second pass": second, "random field": marginals}

    def label(self, floor: Floor, *, context: RoomContext | None = None) -> Floor:
        """Label the rooms of a floor, from R/C down to the labels of its building type if the model has these.

        Parameters
        ----------
        floor
            The floor, metres of the map frame.
        context
            Of its rooms, by `describe_rooms`; None to compute it.

        Returns
        -------
        Floor
            The floor, as `label_rooms` gives it.
        """
        if not floor.rooms:
            return floor
        context = context or describe_rooms(floor)
        functions = self.predict_functions(context)["random field"]
        building_type = find_labelled_type(floor, self)
        schema = None if building_type is None else self.schemas[building_type]
        names = np.zeros((len(functions), 0))
        if building_type is not None:
            names = self._predict_names(context, functions, building_type)
        rows = zip(floor.rooms, functions, choose_functions(functions), names, strict=True)
        return replace(floor, rooms=tuple(_label_room(*row, schema) for row in rows))

    def _predict_names(self, context: RoomContext, functions: Floats, building_type: str) -> Floats:
        """Probabilities of the labels of a type, shape (rooms, labels); those of a function sum to its probability."""
        votes = self.names[building_type].predict(describe_neighbours(context, functions))
        for function, columns in columns_by_function(self.schemas[building_type]).items():
            votes[:, columns] += VOTE_SMOOTHING
            votes[:, columns] *= (functions[:, function] / votes[:, columns].sum(axis=1))[:, None]
        return votes

    @cached_property
    def building_types(self) -> tuple[str, ...]:
        """The building types whose labels it has."""
        return tuple(sorted(self.names))


def find_labelled_type(floor: Floor, model: RoomModel) -> str | None:
    """The most probable building type of a floor whose labels the model has; None if it has those of no type."""
    return next((name for name in floor.building_types if name in model.names), None)


def columns_by_function(schema: LabelSchema) -> dict[int, Indices]:
    """The indices of the labels of a schema by the index of their function in FUNCTIONS, ascending."""
    functions = np.array([FUNCTIONS.index(label.function_in()) for label in schema.labels])
    return {int(function): np.flatnonzero(functions == function) for function in np.unique(functions)}


def has_manual_label(room: Room) -> bool:
    """Whether the label of a room was set or corrected by a person, not predicted by `label_rooms`.

    A predicted label has a probability, and is the finest of the room's labels.
    """
    predicted = [*room.labels.values()][-1:] if room.label_probabilities else []
    return room.label is not None and room.label not in predicted


def keep_manual_label(room: Room) -> Room:
    """The room with no label but its manual one, if it has one."""
    return replace(room, label=room.label if has_manual_label(room) else None, labels={}, label_probabilities={})


def choose_functions(probabilities: Floats) -> NDArray[np.intp]:
    """The index in FUNCTIONS of each room's label, shape (n,); probabilities: shape (n, 4).

    From R/C down: a room is CONNECTION if that is more probable than not, else the most probable of the rest.
    """
    others = probabilities.copy()
    others[:, CONNECTION] = -1
    return np.where(probabilities[:, CONNECTION] > 0.5, CONNECTION, others.argmax(axis=1))


def _label_room(room: Room, functions: Floats, chosen: int, names: Floats, schema: LabelSchema | None) -> Room:
    """The room with its labels from the coarsest set down, and the probabilities of all sets."""
    corridor = float(functions[CONNECTION])
    by_function = dict(zip(map(str, FUNCTIONS), functions.tolist(), strict=True))
    probabilities = {str(LabelSet.R_C): {str(RC.ROOM): 1 - corridor, str(RC.CORRIDOR): corridor}}
    probabilities[str(LabelSet.F_C_E_S)] = by_function
    function = str(FUNCTIONS[chosen])
    r_c = RC.CORRIDOR if chosen == CONNECTION else RC.ROOM
    labels = {str(LabelSet.R_C): str(r_c), str(LabelSet.F_C_E_S): function}
    if schema is not None:
        by_name = dict(zip((label.name for label in schema.labels), names.tolist(), strict=True))
        probabilities[schema.building_type] = by_name
        candidates = [label.name for label in schema.labels if label.function_in() == function]
        # A small schema may have no label of this function.
        if candidates:
            labels[schema.building_type] = max(candidates, key=lambda name: by_name[name])
    finest = list(labels.values())[-1]
    return replace(room, label=finest, labels=labels, label_probabilities=probabilities)


def describe_neighbours(context: RoomContext, probabilities: Floats) -> Floats:
    """Room features, and the probabilities of labels around each room, shape (n, features + N_NEIGHBOUR_BLOCKS L).

    probabilities: of L labels, shape (n, L).
    """
    at_two_doors = (context.hops == 2).astype(float)
    surroundings = [
        probabilities,
        context.doors @ probabilities,
        _average_probabilities(context.doors, probabilities),
        _highest_probabilities(context.doors, probabilities),
        _average_probabilities(at_two_doors, probabilities),
        _average_probabilities(context.walls, probabilities),
        _average_probabilities(context.alike, probabilities),
        np.broadcast_to(probabilities.mean(axis=0), probabilities.shape),
        np.broadcast_to(np.average(probabilities, axis=0, weights=context.area), probabilities.shape),
    ]
    return np.hstack([context.features, *surroundings])


def find_neighbourhood(context: RoomContext) -> Neighbourhood:
    """The pairs of rooms with a door between them, and of rooms that are alike."""
    doors = np.argwhere(np.triu(context.doors, 1) > 0)
    alike = np.argwhere(np.triu(context.alike, 1))
    counts = context.alike.sum(axis=1)
    return Neighbourhood(doors, alike, 2 / np.maximum(counts[alike].sum(axis=1), 1))


def join_neighbourhoods(contexts: Sequence[RoomContext]) -> Neighbourhood:
    """The pairs of several floors, with rooms numbered through."""
    parts = [find_neighbourhood(context) for context in contexts]
    starts = np.cumsum([0, *(len(context.features) for context in contexts[:-1])])
    doors = [part.doors + start for part, start in zip(parts, starts, strict=True)]
    alike = [part.alike + start for part, start in zip(parts, starts, strict=True)]
    return Neighbourhood(np.concatenate(doors), np.concatenate(alike), np.concatenate([part.share for part in parts]))


def _average_probabilities(weights: NDArray[np.generic], probabilities: Floats) -> Floats:
    """Mean class probabilities of the rooms to which each room has a relation, such as a door; shape (n, L).

    weights: of the relations of a room (row) to others (column), shape (n, n). probabilities: shape (n, L). The means
    are 0 for a room without relations.
    """
    totals = np.asarray(weights, float).sum(axis=1, keepdims=True)
    return np.asarray(np.asarray(weights, float) @ probabilities / np.maximum(totals, 1e-9))


def _highest_probabilities(doors: NDArray[np.generic], probabilities: Floats) -> Floats:
    """The highest probability of each label among the rooms behind the doors of a room, 0 without doors; shape (n, L).

    doors: above 0 where two rooms have a door, shape (n, n). probabilities: shape (n, L).
    """
    behind = np.where(np.asarray(doors)[:, :, None] > 0, probabilities[None], 0.0)
    return np.asarray(behind.max(axis=1, initial=0))
