"""What kind of building a floor is of (thesis, section 6.2.2), or that it is like none that is known.

The thesis gives whole floors to kLog: an SVM on a graph kernel. Here the SVM sees the local patterns of the floor and
how it is made up (BuildingKernel), says how probable each type is, and a floor unlike all known ones gets none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from pianta._types import Indices
from pianta.building_types.description import BuildingDescription, describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.machine import TypeMachine, fit_machine
from pianta.building_types.typicality import Typicality, find_most_alike, learn_typicality, measure_likeness
from pianta.errors import LabelError, ModelError
from pianta.evaluation.folds import leave_buildings_out
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.rooms.completion import spread_labels
from pianta.rooms.training import building_of, check_labels

# A floor that is less typical than this share of the known ones is of no known type.
LEAST_TYPICAL = 0.05


@dataclass(frozen=True)
class Verdict:
    """What a model says of the building of a floor.

    probabilities: by type, summing to 1. typicality: the share of known floors that are less typical of buildings.
    alike: sources of the known floors that it is most like.
    """

    probabilities: Mapping[str, float]
    typicality: float
    alike: tuple[str, ...]

    @property
    def known(self) -> bool:
        """Whether it is like the known floors at all."""
        return self.typicality >= LEAST_TYPICAL

    @property
    def likeliest(self) -> str:
        """The most probable type, known or not."""
        return max(self.probabilities, key=self.probabilities.__getitem__)


@dataclass(frozen=True, eq=False)
class Learnt:
    """What is learnt from known floors: a machine that tells their types, and how much they are like each other."""

    machine: TypeMachine
    typicality: Typicality


@dataclass(frozen=True, eq=False)
class BuildingModel:
    """A trained model of building types: the floors that it knows, and what is learnt from them.

    Attributes
    ----------
    known
        Descriptions of floors, by rooms that have labels of `label_set`.
    types
        The building type of each.
    buildings
        The building of each; floors of one building have the same.
    label_set
        The labels by which floors are compared.
    given
        What was learnt from them before, None if nothing was.
    """

    known: tuple[BuildingDescription, ...]
    types: tuple[str, ...]
    buildings: tuple[str, ...]
    label_set: LabelSet
    given: Learnt | None = None

    @cached_property
    def building_types(self) -> tuple[str, ...]:
        """The types that it tells apart."""
        return tuple(sorted(set(self.types)))

    def save(self, path: str | Path) -> None:
        """Write the model as a JSON file that `load_model` reads.

        Parameters
        ----------
        path
            The file; an older one is replaced.

        Raises
        ------
        ModelError
            The model could not be read again.
        PiantaError
            The file cannot be written.
        """
        from pianta.building_types.model_file import save_building_model

        save_building_model(self, path)

    def judge(self, floor: Floor) -> Verdict:
        """Say what kind of building a floor is of.

        Parameters
        ----------
        floor
            A floor whose rooms have labels of the label set.

        Returns
        -------
        Verdict
            Probabilities of the types, how typical the floor is, and the known floors that it is most like.

        Raises
        ------
        LabelError
            Rooms have no label of the label set.
        """
        return self.judge_description(describe_building(floor, self.label_set))

    def judge_description(self, description: BuildingDescription) -> Verdict:
        """Say what `judge` says, of a floor that is described in the label set of the model.

        Parameters
        ----------
        description
            Of the floor.

        Returns
        -------
        Verdict
            As of `judge`.
        """
        gram = self._kernel.compare([description])
        likeness = measure_likeness(gram)
        typicality = float(self.learnt.typicality.rank(likeness)[0])
        probabilities = self.learnt.machine.judge(gram, self._truth)[0]
        by_type = dict(zip(self.building_types, map(float, probabilities), strict=True))
        return Verdict(by_type, typicality, find_most_alike(gram, self.known))

    def leave_out(self, places: Indices) -> BuildingModel:
        """The model of all floors that it knows but those at some places.

        Parameters
        ----------
        places
            Of floors in `known`, shape (n,).

        Returns
        -------
        BuildingModel
            A model that learns anew when it is first used.
        """
        kept = np.setdiff1d(np.arange(len(self.known)), places)
        known, types, buildings = (tuple(every[i] for i in kept) for every in (self.known, self.types, self.buildings))
        return replace(self, known=known, types=types, buildings=buildings, given=None)

    @cached_property
    def learnt(self) -> Learnt:
        """What is learnt from the known floors; where it was not given, it is learnt now, with scikit-learn."""
        if self.given is not None:
            return self.given
        machine = fit_machine(self._kernel.compare(), self._truth, self.buildings)
        return Learnt(machine, learn_typicality(self.known, self.buildings))

    @cached_property
    def _kernel(self) -> BuildingKernel:
        return BuildingKernel().fit(self.known)

    @cached_property
    def _truth(self) -> Indices:
        """The type of each known floor, its place in `building_types`."""
        return np.array([self.building_types.index(name) for name in self.types])


def train_building_types(
    floors: Sequence[Floor],
    *,
    buildings: Sequence[str] | None = None,
    schemas: Mapping[str, LabelSchema] = SCHEMAS,
    label_set: LabelSet = LabelSet.F_C_E_S,
    convention: LabelConvention = LabelConvention.EXPERIMENTS,
) -> BuildingModel:
    """Train a model of building types.

    Needs scikit-learn, which comes with pianta.

    Parameters
    ----------
    floors
        Floors whose rooms have labels of the schema of their building type; those without rooms are passed by.
    buildings
        The building that each floor with rooms belongs to; None to see it in the sources: house1.xml and house2.xml are
        floors of one. A type that would have one building only has as many as floors.
    schemas
        By building type, its labels.
    label_set
        The labels by which floors are compared: R/C or F/C/E/S.
    convention
        Which of the splits of the thesis is taken for these labels.

    Returns
    -------
    BuildingModel
        The model for `classify_building`; `model.save(path)` writes it.

    Raises
    ------
    LabelError
        Floors have no building type, or rooms no label of its schema; every fault is in one message.
    ModelError
        There are fewer than two types, or a type has fewer than two buildings; every fault is in one message.

    References
    ----------
    M. Luperto, PhD thesis, section 6.2.

    Examples
    --------
    >>> import pianta
    >>> files = ("school.geojson", "other_school.geojson", "office.geojson", "other_office.geojson")
    >>> floors = [pianta.read_floor(file) for file in files]  # doctest: +SKIP
    >>> pianta.train_building_types(floors).save("types.json")  # doctest: +SKIP
    """
    floors = [floor for floor in floors if floor.rooms]
    types = [next(iter(floor.building_types), "") for floor in floors]
    names = list(buildings) if buildings is not None else _name_buildings(floors, types)
    if len({*zip(types, names, strict=True)}) > len({*names}):
        # Buildings of different types are not one, whatever they are called.
        names = [f"{kind}/{name}" for kind, name in zip(types, names, strict=True)]
    _check_examples(floors, types, names, schemas)
    spread = (
        spread_labels(floor, schemas[kind], convention=convention) for floor, kind in zip(floors, types, strict=True)
    )
    known = tuple(describe_building(floor, label_set) for floor in spread)
    return BuildingModel(known, tuple(types), tuple(names), label_set)


def judge_held_out(model: BuildingModel) -> list[Verdict]:
    """What is said of each floor that a model knows, by the model of all other buildings."""
    verdicts: dict[int, Verdict] = {}
    for _, held_out in leave_buildings_out(model.buildings):
        others = model.leave_out(held_out)
        verdicts |= {place: others.judge_description(model.known[place]) for place in held_out.tolist()}
    return [verdicts[place] for place in range(len(model.known))]


def check_types(types: Sequence[str], buildings: Sequence[str]) -> None:
    """Raise ModelError unless floors, given types and buildings of each, are of two types with two buildings each."""
    faults = [*_find_lonely_types(types, buildings)]
    if faults:
        raise ModelError(f"{join_faults(faults)}, give two types at least and two buildings of each, better dozens")


def _name_buildings(floors: Sequence[Floor], types: Sequence[str]) -> list[str]:
    """The building of each floor by building_of; where a type would have one only, its floors are one each."""
    names = [building_of(floor.source) for floor in floors]
    of_types = _group_buildings(types, names)
    named = zip(floors, types, names, strict=True)
    return [name if len(of_types[kind]) > 1 else floor.source for floor, kind, name in named]


def _check_examples(
    floors: Sequence[Floor], types: Sequence[str], buildings: Sequence[str], schemas: Mapping[str, LabelSchema]
) -> None:
    """Raise what check_labels and check_types do; where both do, LabelError with the faults of both."""
    try:
        check_labels(floors, schemas)
    except LabelError as error:
        # Who does not tell all types is not blamed for there being few.
        lonely = _find_lonely_types(types, buildings) if all(types) else ()
        raise LabelError(join_faults([str(error), *lonely])) from None
    check_types(types, buildings)


def _find_lonely_types(types: Sequence[str], buildings: Sequence[str]) -> Iterator[str]:
    of_types = _group_buildings(types, buildings)
    yield from (f"{kind} has 1 building" for kind, names in of_types.items() if len(names) < 2)
    if len(of_types) < 2:
        yield f"{len(of_types)} building type{' is' if of_types else 's are'} given"


def _group_buildings(types: Sequence[str], buildings: Sequence[str]) -> dict[str, set[str]]:
    """The buildings of each type."""
    of_types: dict[str, set[str]] = {}
    for kind, name in zip(types, buildings, strict=True):
        of_types.setdefault(kind, set()).add(name)
    return of_types
