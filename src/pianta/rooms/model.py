"""What each room of a floor is for: R/C, F/C/E/S, and the labels of its building type, with probabilities.

The thesis classifies rooms one by one with Extra-Trees (sections 5.3 and 6.1.3). Here the same trees see a room in its
building (RoomContext), see in a second pass what the first one thinks of the rooms around it, and a random field judges
the floor as one object.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.labels import FCES, RC, LabelSchema, LabelSet
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.forest import Forest
from pianta.rooms.random_field import Neighbourhood, RandomField

FUNCTIONS = tuple(FCES)
CONNECTION = FUNCTIONS.index(FCES.CONNECTION)
# Columns for each label that describe_neighbours adds to the context of a room.
N_NEIGHBOUR_BLOCKS = 9


@dataclass(frozen=True)
class Training:
    """What a model was trained on.

    floors: sources of the drawn floors, sorted. rooms: by building type, how many rooms, those of simulated maps
    included. simulated: how many simulated maps were read besides. errors: by label set, the share of drawn rooms that
    would get a wrong label, judged by trees that have not seen their building; the tables, temperature and strengths
    of the random field were fitted on the same rooms. seed, pianta, sklearn: what it takes to train it again.
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
        Extra-Trees over F/C/E/S, on the context of a room, and on that and what the first says around it.
    field
        The random field that judges a floor as one object.
    names
        By building type, Extra-Trees over its labels.
    schemas
        By building type, which labels it has.
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
        """Give the probabilities of F/C/E/S after each step.

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
        return self._judge(describe_rooms(floor))

    def _judge(self, context: RoomContext) -> dict[str, Floats]:
        first = self.first.predict(context.features)
        second = self.second.predict(describe_neighbours(context, first))
        judged = self.field.compute_marginals(second, find_neighbourhood(context))
        return {"first pass": first, "second pass": second, "random field": judged}

    def label(self, floor: Floor) -> Floor:
        """The floor with labels, from R/C down to those of its building type where the model knows it.

        Parameters
        ----------
        floor
            The floor, metres of the map frame.

        Returns
        -------
        Floor
            The floor, as `label_rooms` gives it.
        """
        if not floor.rooms:
            return floor
        context = describe_rooms(floor)
        judged = self._judge(context)["random field"]
        known = next((name for name in floor.building_types if name in self.names), None)
        names = np.zeros((len(judged), 0)) if known is None else self._name(context, judged, known)
        schema = None if known is None else self.schemas[known]
        rows = zip(floor.rooms, judged, choose_functions(judged), names, strict=True)
        rooms = [_label_room(*row, schema) for row in rows]
        return replace(floor, rooms=tuple(rooms))

    def _name(self, context: RoomContext, judged: Floats, building_type: str) -> Floats:
        """Probabilities of the labels of a building type, shape (rooms, labels); those of a function sum to its own."""
        schema = self.schemas[building_type]
        votes = self.names[building_type].predict(describe_neighbours(context, judged))
        functions = np.array([FUNCTIONS.index(label.function_in()) for label in schema.labels])
        for number in np.unique(functions):
            of_function = functions == number
            # Where no tree thinks of the function, its labels are equally likely.
            votes[:, of_function] += 1e-6
            votes[:, of_function] *= (judged[:, number] / votes[:, of_function].sum(axis=1))[:, None]
        return votes

    @cached_property
    def building_types(self) -> tuple[str, ...]:
        """The building types whose labels it knows."""
        return tuple(sorted(self.names))


def has_manual_label(room: Room) -> bool:
    """Whether its label is not one that `label_rooms` gave it: somebody has said or corrected it.

    What the model says has a probability, and is the finest of the room's labels.
    """
    said_by_model = [*room.labels.values()][-1:] if room.label_probabilities else []
    return room.label is not None and room.label not in said_by_model


def keep_manual_label(room: Room) -> Room:
    """The room with nothing but the label that somebody gave it, or with no label at all."""
    return replace(room, label=room.label if has_manual_label(room) else None, labels={}, label_probabilities={})


def choose_functions(judged: Floats) -> NDArray[np.intp]:
    """Which of FUNCTIONS each room is called, shape (n,), given their probabilities, shape (n, 4).

    From R/C down: a CONNECTION is what is more likely one than not, other rooms are the most probable of the rest.
    """
    others = judged.copy()
    others[:, CONNECTION] = -1
    return np.where(judged[:, CONNECTION] > 0.5, CONNECTION, others.argmax(axis=1))


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
        within = [label.name for label in schema.labels if label.function_in() == function]
        # A schema of few labels may have none for this function.
        if within:
            labels[schema.building_type] = max(within, key=lambda name: by_name[name])
    finest = list(labels.values())[-1]
    return replace(room, label=finest, labels=labels, label_probabilities=probabilities)


def describe_neighbours(context: RoomContext, probabilities: Floats) -> Floats:
    """Features of rooms, what is thought of each, and of the rooms around it: shape (n, k + N_NEIGHBOUR_BLOCKS L).

    probabilities: of L labels, shape (n, L).
    """
    at_two_doors = (context.hops == 2).astype(float)
    surroundings = [
        probabilities,
        context.doors @ probabilities,
        _average(context.doors, probabilities),
        _highest(context.doors, probabilities),
        _average(at_two_doors, probabilities),
        _average(context.walls, probabilities),
        _average(context.alike, probabilities),
        np.broadcast_to(probabilities.mean(axis=0), probabilities.shape),
        np.broadcast_to(np.average(probabilities, axis=0, weights=context.area), probabilities.shape),
    ]
    return np.hstack([context.features, *surroundings])


def find_neighbourhood(context: RoomContext) -> Neighbourhood:
    """The pairs of rooms with a door between them, and those that are alike."""
    doors = np.argwhere(np.triu(context.doors, 1) > 0)
    alike = np.argwhere(np.triu(context.alike, 1))
    count = context.alike.sum(axis=1)
    return Neighbourhood(doors, alike, 2 / np.maximum(count[alike].sum(axis=1), 1))


def join_neighbourhoods(contexts: Sequence[RoomContext]) -> Neighbourhood:
    """The pairs of several floors, their rooms numbered through."""
    near = [find_neighbourhood(context) for context in contexts]
    starts = np.cumsum([0, *(len(context.features) for context in contexts[:-1])])
    doors = [each.doors + start for each, start in zip(near, starts, strict=True)]
    alike = [each.alike + start for each, start in zip(near, starts, strict=True)]
    return Neighbourhood(np.concatenate(doors), np.concatenate(alike), np.concatenate([each.share for each in near]))


def _average(weights: NDArray[np.generic], probabilities: Floats) -> Floats:
    """Weighted means of the rows of probabilities, 0 where all weights are, shape (n, L)."""
    totals = np.asarray(weights, float).sum(axis=1, keepdims=True)
    return np.asarray(np.asarray(weights, float) @ probabilities / np.maximum(totals, 1e-9))


def _highest(doors: NDArray[np.generic], probabilities: Floats) -> Floats:
    """Highest probability of each label behind any door, 0 where there is none, shape (n, L)."""
    behind = np.where(np.asarray(doors)[:, :, None] > 0, probabilities[None], 0.0)
    return np.asarray(behind.max(axis=1, initial=0))
