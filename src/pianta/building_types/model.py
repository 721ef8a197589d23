"""The building type of a floor (thesis, section 6.2.2), or that it is unlike all training floors.

The thesis gives whole floors to kLog: an SVM on a graph kernel. Here the SVM uses the local patterns of a floor and
features of the whole floor (BuildingKernel) and gives probabilities; a floor unlike all training floors has no type.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pianta._types import Indices
from pianta.building_types.description import BuildingDescription, describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.svm import BuildingTypeSvm, fit_type_svm
from pianta.building_types.typicality import Typicality, find_most_similar, fit_typicality, measure_likeness
from pianta.errors import LabelError, ModelError
from pianta.evaluation.folds import leave_buildings_out
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import ALL_SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.rooms.completion import map_labels_upwards
from pianta.rooms.training import building_name, check_labels, most_probable_type

# A floor that is less typical than this share of the training floors has no type: 5 % false alarms.
MIN_TYPICALITY = 0.05


@dataclass(frozen=True)
class TypePrediction:
    """The predicted building type of a floor.

    probabilities: by type, summing to 1. typicality: the share of training floors that are less typical.
    alike: sources of the most similar training floors.
    """

    probabilities: Mapping[str, float]
    typicality: float
    alike: tuple[str, ...]

    @property
    def is_known(self) -> bool:
        """Whether the floor is similar enough to the training floors to have one of their types."""
        return self.typicality >= MIN_TYPICALITY

    @property
    def likeliest(self) -> str:
        """The most probable type, whether `is_known` or not."""
        return max(self.probabilities, key=self.probabilities.__getitem__)


@dataclass(frozen=True, eq=False)
class FittedTypes:
    """What is fitted to the training floors: the classifier of types, and how similar the floors are to each other."""

    svm: BuildingTypeSvm
    typicality: Typicality


@dataclass(frozen=True, eq=False)
class BuildingTypeModel:
    """A trained model of building types: its training floors, and what is fitted to them.

    Attributes
    ----------
    training_floors
        Descriptions of floors whose rooms have labels of `label_set`.
    types
        The building type of each.
    buildings
        The building of each; floors of one building have the same.
    label_set
        The labels by which floors are compared.
    stored_fit
        What was fitted to them before; None to fit when the model is first used.
    """

    training_floors: tuple[BuildingDescription, ...]
    types: tuple[str, ...]
    buildings: tuple[str, ...]
    label_set: LabelSet
    stored_fit: FittedTypes | None = None

    @cached_property
    def building_types(self) -> tuple[str, ...]:
        """The types that it can predict."""
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
        from pianta.building_types.model_file import save_building_type_model

        save_building_type_model(self, path)

    def predict(self, floor: Floor) -> TypePrediction:
        """Predict the building type of a floor.

        Parameters
        ----------
        floor
            A floor whose rooms have labels of the label set.

        Returns
        -------
        TypePrediction
            Probabilities of the types, how typical the floor is, and the most similar training floors.

        Raises
        ------
        LabelError
            Rooms have no label of the label set.
        """
        return self.predict_description(describe_building(floor, self.label_set))

    def predict_description(self, description: BuildingDescription) -> TypePrediction:
        """Predict the building type of a floor from its description.

        Parameters
        ----------
        description
            Of the floor, in the label set of the model.

        Returns
        -------
        TypePrediction
            As of `predict`.
        """
        gram = self._kernel.compare([description])
        typicality = float(self.fitted.typicality.rank(measure_likeness(gram))[0])
        probabilities = self.fitted.svm.predict_probabilities(gram, self._type_indices)[0]
        by_type = dict(zip(self.building_types, map(float, probabilities), strict=True))
        return TypePrediction(by_type, typicality, find_most_similar(gram, self.training_floors))

    def leave_out(self, indices: Indices) -> BuildingTypeModel:
        """The model without some of its training floors.

        Parameters
        ----------
        indices
            Of floors in `training_floors`, shape (n,).

        Returns
        -------
        BuildingTypeModel
            A model that is fitted anew when it is first used.
        """
        rest = np.setdiff1d(np.arange(len(self.training_floors)), indices)
        floors, types, buildings = (
            tuple(values[i] for i in rest) for values in (self.training_floors, self.types, self.buildings)
        )
        return BuildingTypeModel(floors, types, buildings, self.label_set)

    @cached_property
    def fitted(self) -> FittedTypes:
        """The stored fit; without one, what scikit-learn fits now."""
        if self.stored_fit is not None:
            return self.stored_fit
        svm = fit_type_svm(self._kernel.compare(), self._type_indices, self.buildings)
        return FittedTypes(svm, fit_typicality(self.training_floors, self.buildings))

    @cached_property
    def _kernel(self) -> BuildingKernel:
        return BuildingKernel().fit(self.training_floors)

    @cached_property
    def _type_indices(self) -> Indices:
        """The type of each training floor, as its index in `building_types`."""
        return np.array([self.building_types.index(name) for name in self.types])


def train_building_types(
    floors: Sequence[Floor],
    *,
    buildings: Sequence[str] | None = None,
    schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS,
    label_set: LabelSet = LabelSet.F_C_E_S,
    convention: LabelConvention = LabelConvention.EXPERIMENTS,
) -> BuildingTypeModel:
    """Train a model of building types.

    Needs scikit-learn, which comes with pianta.

    Parameters
    ----------
    floors
        Floors whose rooms have labels of the schema of their building type; floors without rooms are skipped.
    buildings
        The building of each floor with rooms; None to derive it from the sources: house1.xml and house2.xml are floors
        of one. If a type would have only one building, each of its floors counts as one.
    schemas
        By building type, its labels.
    label_set
        The labels by which floors are compared: R/C or F/C/E/S.
    convention
        Which of the thesis' conventions holds for these labels.

    Returns
    -------
    BuildingTypeModel
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
    types = [most_probable_type(floor) for floor in floors]
    names = list(buildings) if buildings is not None else _name_buildings(floors, types)
    if len({*zip(types, names, strict=True)}) > len({*names}):
        # Floors of different types are never of one building, even if the names are equal.
        names = [f"{building_type}/{name}" for building_type, name in zip(types, names, strict=True)]
    _check_training_floors(floors, types, names, schemas)
    descriptions = tuple(
        describe_building(map_labels_upwards(floor, schemas[building_type], convention=convention), label_set)
        for floor, building_type in zip(floors, types, strict=True)
    )
    return BuildingTypeModel(descriptions, tuple(types), tuple(names), label_set)


def predict_held_out(model: BuildingTypeModel) -> list[TypePrediction]:
    """Cross-validation: the prediction for each training floor, by the model of all other buildings."""
    predictions: dict[int, TypePrediction] = {}
    for _, held_out in leave_buildings_out(model.buildings):
        others = model.leave_out(held_out)
        predictions |= {i: others.predict_description(model.training_floors[i]) for i in held_out.tolist()}
    return [predictions[i] for i in range(len(model.training_floors))]


def check_types(types: Sequence[str], buildings: Sequence[str]) -> None:
    """Raise ModelError unless floors, given types and buildings of each, are of two types with two buildings each."""
    faults = [*_find_type_faults(types, buildings)]
    if faults:
        raise ModelError(f"{join_faults(faults)}, give two types at least and two buildings of each, better dozens")


def _name_buildings(floors: Sequence[Floor], types: Sequence[str]) -> list[str]:
    """The building of each floor by its file name; if a type would have only one, each of its floors is one."""
    names = [building_name(floor.source) for floor in floors]
    by_type = _group_buildings(types, names)
    rows = zip(floors, types, names, strict=True)
    return [name if len(by_type[building_type]) > 1 else floor.source for floor, building_type, name in rows]


def _check_training_floors(
    floors: Sequence[Floor], types: Sequence[str], buildings: Sequence[str], schemas: Mapping[str, LabelSchema]
) -> None:
    """Raise what check_labels and check_types raise; if both do, LabelError with the faults of both."""
    try:
        check_labels(floors, schemas)
    except LabelError as error:
        # While types are missing, their number is unknown and no fault.
        type_faults = _find_type_faults(types, buildings) if all(types) else ()
        raise LabelError(join_faults([str(error), *type_faults])) from None
    check_types(types, buildings)


def _find_type_faults(types: Sequence[str], buildings: Sequence[str]) -> Iterator[str]:
    """Types with one building, and fewer than two types."""
    by_type = _group_buildings(types, buildings)
    yield from (f"{building_type} has 1 building" for building_type, names in by_type.items() if len(names) < 2)
    if len(by_type) < 2:
        yield f"{len(by_type)} building type{' is' if by_type else 's are'} given"


def _group_buildings(types: Sequence[str], buildings: Sequence[str]) -> dict[str, set[str]]:
    by_type: dict[str, set[str]] = {}
    for building_type, name in zip(types, buildings, strict=True):
        by_type.setdefault(building_type, set()).add(name)
    return by_type
