"""Realism of a floor: whether it is built like real ones (thesis, section 8.1), and why not.

The thesis trains a classifier of real and simulated floors. Here real floors alone are enough (typicality); with
unrealistic floors too, a classifier gives the probability that a floor is realistic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pianta.building_types.description import BuildingDescription, describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.model import BuildingTypeModel
from pianta.building_types.typicality import Typicality, find_most_similar, fit_typicality, measure_likeness
from pianta.errors import ModelError
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta.realism.classifier import RealismClassifier
from pianta.realism.measures import UnusualMeasure, find_unusual_measures, measure_description
from pianta.realism.patterns import RoomPattern, UnusualPattern, find_unusual_patterns, list_patterns
from pianta.rooms.training import FOLDS, building_name

MIN_BUILDINGS = 3
MIN_UNREALISTIC_BUILDINGS = 2
# Between these shares of less typical reference floors a floor counts as typical: half of the reference.
TYPICAL = (0.25, 0.75)
# Up to this share of less typical reference floors, a floor is not built like them: 10 % false alarms.
MAX_ATYPICAL = 0.1


@dataclass(frozen=True)
class Realism:
    """How realistic a floor is.

    Attributes
    ----------
    likeness
        Mean similarity to the three most similar reference floors, from 0 to 1.
    usual
        The same of each reference floor, compared with those of other buildings; ascending.
    typicality
        The share of reference floors with a lower likeness: 0 if all are more typical, 0.5 for the median.
    probability
        That the floor is realistic; None for a model without unrealistic floors.
    alike
        Sources of the most similar reference floors.
    measures, patterns
        What is unusual, the most unusual first.
    """

    likeness: float
    usual: tuple[float, ...]
    typicality: float
    probability: float | None
    alike: tuple[str, ...]
    measures: tuple[UnusualMeasure, ...]
    patterns: tuple[UnusualPattern, ...]

    @property
    def score(self) -> float:
        """From 0 to 1: the probability; else the typicality."""
        return self.typicality if self.probability is None else self.probability

    @property
    def is_atypical(self) -> bool:
        """Whether, by its typicality, the floor is not built like the reference floors."""
        return self.typicality <= MAX_ATYPICAL

    @property
    def verdict(self) -> str:
        """The score in words."""
        typical = self._describe_typicality()
        if self.probability is None:
            return typical
        realistic = self.probability >= 0.5
        side = "realistic" if realistic else "not realistic"
        # A classifier puts every floor in a class, even a single room.
        joined = ", but " if realistic and self.is_atypical else "; "
        return f"{side}, probability {self.probability:.2f} of being so{joined}{typical}"

    @property
    def reasons(self) -> tuple[str, ...]:
        """What is unusual, in words."""
        return (*map(str, self.measures), *map(str, self.patterns))

    def as_json(self) -> dict[str, object]:
        """All attributes, as values that JSON can hold.

        Returns
        -------
        dict
            The content of realism.json.
        """
        return {
            "score": self.score,
            "verdict": self.verdict,
            "typicality": self.typicality,
            "probability": self.probability,
            "likeness": self.likeness,
            "usual_likenesses": self.usual,
            "alike": self.alike,
            "measures": [measure.as_json() for measure in self.measures],
            "patterns": [pattern.as_json() for pattern in self.patterns],
        }

    def _describe_typicality(self) -> str:
        """A phrase that compares the floor with the reference floors by its typicality."""
        floors = f"{len(self.usual)} reference floors"
        if self.typicality <= 0:
            return f"less typical than any of the {floors}"
        if self.typicality >= 1:
            return f"more typical than any of the {floors}"
        if self.typicality < TYPICAL[0]:
            return f"less typical than {1 - self.typicality:.0%} of the {floors}"
        if self.typicality > TYPICAL[1]:
            return f"more typical than {self.typicality:.0%} of the {floors}"
        return f"typical, {self.typicality:.0%} of the {floors} are less so"


@dataclass(frozen=True, eq=False)
class RealismModel:
    """A reference of real floors, and optionally of unrealistic ones.

    reference_floors: descriptions of real floors in `label_set`. buildings: of each; floors of one building share it.
    unrealistic_floors, unrealistic_buildings: the same for unrealistic floors; empty for a one-class model.
    Raises ModelError for fewer than three real buildings, and for a single unrealistic one.
    """

    reference_floors: tuple[BuildingDescription, ...]
    buildings: tuple[str, ...]
    label_set: LabelSet
    unrealistic_floors: tuple[BuildingDescription, ...] = ()
    unrealistic_buildings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        real, unrealistic = len(set(self.buildings)), len(set(self.unrealistic_buildings))
        if real < MIN_BUILDINGS:
            raise ModelError(f"{real} reference buildings are too few, give {MIN_BUILDINGS} at least, better dozens")
        if self.unrealistic_floors and unrealistic < MIN_UNREALISTIC_BUILDINGS:
            remedy = f"give {MIN_UNREALISTIC_BUILDINGS} at least or none"
            raise ModelError(f"{unrealistic} unrealistic building is too few, {remedy}")

    def assess(self, floor: Floor) -> Realism:
        """Compare a floor with the reference.

        Raises LabelError for rooms without a label of the label set, and for a floor without rooms.
        """
        return self.assess_description(describe_building(floor, self.label_set), [room.id for room in floor.rooms])

    def assess_description(self, description: BuildingDescription, room_ids: Sequence[int]) -> Realism:
        """As `assess`, for a description in the label set of the model; room_ids: of its rooms."""
        gram = self._kernel.compare([description])
        likeness = measure_likeness(gram)
        values = measure_description(description, self.label_set)
        return Realism(
            likeness=float(likeness[0]),
            usual=tuple(self._typicality.likenesses.tolist()),
            typicality=float(self._typicality.rank(likeness)[0]),
            probability=self._classifier.predict_probability(description) if self.unrealistic_floors else None,
            alike=find_most_similar(gram, self.reference_floors),
            measures=find_unusual_measures(values, self._measures, self.label_set),
            patterns=find_unusual_patterns(list_patterns(description), self._patterns, room_ids),
        )

    def find_building(self, description: BuildingDescription) -> str | None:
        """The building of a floor of the model, realistic or not, with the same description, or None."""
        same = (name for floor, name in zip(*self._all_floors, strict=True) if _is_same(description, floor))
        return next(same, None)

    def leave_out(self, building: str) -> RealismModel:
        """The model without the floors of a building; raises ModelError if too few are left."""
        floors, buildings = _drop_building(self.reference_floors, self.buildings, building)
        others, other_buildings = _drop_building(self.unrealistic_floors, self.unrealistic_buildings, building)
        return RealismModel(floors, buildings, self.label_set, others, other_buildings)

    @property
    def _all_floors(self) -> tuple[tuple[BuildingDescription, ...], tuple[str, ...]]:
        """Real and unrealistic floors, and the building of each."""
        floors = (*self.reference_floors, *self.unrealistic_floors)
        return floors, (*self.buildings, *self.unrealistic_buildings)

    @cached_property
    def _kernel(self) -> BuildingKernel:
        return BuildingKernel().fit(self.reference_floors)

    @cached_property
    def _typicality(self) -> Typicality:
        return fit_typicality(self.reference_floors, self.buildings)

    @cached_property
    def _classifier(self) -> RealismClassifier:
        realistic = [True] * len(self.reference_floors) + [False] * len(self.unrealistic_floors)
        floors, buildings = self._all_floors
        return RealismClassifier().fit(floors, realistic, buildings)

    @cached_property
    def _measures(self) -> list[dict[str, float | None]]:
        return [measure_description(description, self.label_set) for description in self.reference_floors]

    @cached_property
    def _patterns(self) -> list[list[RoomPattern]]:
        return [list_patterns(description) for description in self.reference_floors]


def train_realism(
    floors: Sequence[Floor],
    *,
    label_set: LabelSet,
    buildings: Sequence[str] | None = None,
    unrealistic: Sequence[Floor] = (),
    unrealistic_buildings: Sequence[str] | None = None,
) -> RealismModel:
    """Make a model of real floors, and of unrealistic ones if there are any.

    floors, unrealistic: with labels in the label set, R/C or F/C/E/S; those without rooms are skipped.
    buildings: the building of each floor; None to derive it from the sources by name_buildings.
    Raises LabelError for rooms without such a label, and ModelError as RealismModel does.
    """
    real = _describe(floors, buildings, label_set)
    return RealismModel(*real, label_set, *_describe(unrealistic, unrealistic_buildings, label_set))


def reference_from_types(model: BuildingTypeModel, types: Sequence[str] = ()) -> RealismModel:
    """The training floors of a model of building types as a reference: those of some types, or of all.

    Raises ModelError for types that the model does not have, and as RealismModel does.
    """
    unknown = sorted(set(types) - set(model.building_types))
    if unknown:
        raise ModelError(
            f"no building of type {', '.join(unknown)} is known, give of {', '.join(model.building_types)}"
        )
    chosen = [i for i, name in enumerate(model.types) if not types or name in types]
    floors = tuple(model.training_floors[i] for i in chosen)
    return RealismModel(floors, tuple(model.buildings[i] for i in chosen), model.label_set)


def name_buildings(sources: Sequence[str]) -> list[str]:
    """The building of each floor by its file name; if that gives fewer than five buildings, each floor is one."""
    names = [building_name(source) for source in sources]
    return names if len(set(names)) >= FOLDS else [*sources]


def _is_same(one: BuildingDescription, other: BuildingDescription) -> bool:
    """Whether two descriptions are equal except for their source."""
    rooms, other_rooms = ((each.labels, each.sizes, each.sides, each.doors) for each in (one, other))
    return rooms == other_rooms and np.array_equal(one.features, other.features)


def _drop_building(
    floors: Sequence[BuildingDescription], buildings: Sequence[str], building: str
) -> tuple[tuple[BuildingDescription, ...], tuple[str, ...]]:
    others = [i for i, name in enumerate(buildings) if name != building]
    return tuple(floors[i] for i in others), tuple(buildings[i] for i in others)


def _describe(
    floors: Sequence[Floor], buildings: Sequence[str] | None, label_set: LabelSet
) -> tuple[tuple[BuildingDescription, ...], tuple[str, ...]]:
    """Descriptions of the floors that have rooms, and their buildings."""
    names = name_buildings([floor.source for floor in floors]) if buildings is None else buildings
    pairs = [(floor, name) for floor, name in zip(floors, names, strict=True) if floor.rooms]
    return tuple(describe_building(floor, label_set) for floor, _ in pairs), tuple(name for _, name in pairs)
