"""Realism of an environment: whether it is built like real ones (thesis, section 8.1), and why not.

The thesis learns to tell real floors from simulated ones. Here the real ones alone are enough (typicality); where
unrealistic ones are known too, a classifier says how probable it is that a floor is realistic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pianta.building_types.description import BuildingDescription, describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.model import BuildingModel
from pianta.building_types.typicality import Typicality, find_most_alike, learn_typicality, measure_likeness
from pianta.errors import ModelError
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta.realism.classifier import RealismClassifier
from pianta.realism.measures import OffMeasure, find_off_measures, measure_description
from pianta.realism.patterns import OffPattern, RoomPattern, find_off_patterns, list_patterns
from pianta.rooms.training import FOLDS, building_of

LEAST_BUILDINGS, LEAST_UNLIKE = 3, 2
# Between these shares of the reference floors that are less typical, a floor is typical.
LOW, HIGH = 0.25, 0.75
# Where no more than this share of the reference floors is less typical, a floor is not built like them.
UNLIKE = 0.1


@dataclass(frozen=True)
class Realism:
    """What a model says of a floor.

    Attributes
    ----------
    likeness
        Mean likeness to the three reference floors that it is most like, from 0 to 1.
    usual
        The likeness of each reference floor to those of other buildings, ascending.
    typicality
        The share of reference floors that are less like the others than this floor: 0 when all are more so, 0.5 for
        the median one.
    probability
        That it is realistic; None for a model that knows no unrealistic floors.
    alike
        Sources of the reference floors that it is most like.
    measures, patterns
        What is off, the worst first.
    """

    likeness: float
    usual: tuple[float, ...]
    typicality: float
    probability: float | None
    alike: tuple[str, ...]
    measures: tuple[OffMeasure, ...]
    patterns: tuple[OffPattern, ...]

    @property
    def score(self) -> float:
        """From 0 to 1: the probability where there is one, else the typicality."""
        return self.typicality if self.probability is None else self.probability

    @property
    def is_unlike(self) -> bool:
        """Whether it is not built like the reference floors, by its typicality."""
        return self.typicality <= UNLIKE

    @property
    def verdict(self) -> str:
        """The score in words."""
        typical = self._compare()
        if self.probability is None:
            return typical
        realistic = self.probability >= 0.5
        side = "realistic" if realistic else "not realistic"
        # Two classes put every floor on a side, a single room as well.
        joined = ", but " if realistic and self.is_unlike else "; "
        return f"{side}, probability {self.probability:.2f} of being so{joined}{typical}"

    @property
    def reasons(self) -> tuple[str, ...]:
        """In words what is off."""
        return (*map(str, self.measures), *map(str, self.patterns))

    def as_json(self) -> dict[str, object]:
        """All of it, as JSON can hold it.

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

    def _compare(self) -> str:
        floors = f"{len(self.usual)} reference floors"
        if self.typicality <= 0:
            return f"less typical than any of the {floors}"
        if self.typicality >= 1:
            return f"more typical than any of the {floors}"
        if self.typicality < LOW:
            return f"less typical than {1 - self.typicality:.0%} of the {floors}"
        if self.typicality > HIGH:
            return f"more typical than {self.typicality:.0%} of the {floors}"
        return f"typical, {self.typicality:.0%} of the {floors} are less so"


@dataclass(frozen=True, eq=False)
class RealismModel:
    """A model of what is realistic: it is the floors that it knows.

    known: real floors, by rooms that have labels of label_set. buildings: of each, which are floors of one building.
    unlike, unlike_buildings: the same of unrealistic floors, none for a model of one class.
    Raises ModelError for fewer than three buildings, and for a single unrealistic one.
    """

    known: tuple[BuildingDescription, ...]
    buildings: tuple[str, ...]
    label_set: LabelSet
    unlike: tuple[BuildingDescription, ...] = ()
    unlike_buildings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count, count_unlike = len(set(self.buildings)), len(set(self.unlike_buildings))
        if count < LEAST_BUILDINGS:
            raise ModelError(f"{count} reference buildings are too few, give {LEAST_BUILDINGS} at least, better dozens")
        if self.unlike and count_unlike < LEAST_UNLIKE:
            raise ModelError(f"{count_unlike} unrealistic building is too few, give {LEAST_UNLIKE} at least or none")

    def judge(self, floor: Floor) -> Realism:
        """Whether a floor is built like the known ones.

        Raises LabelError for rooms without a label of the label set, and for a floor without rooms.
        """
        return self.judge_description(describe_building(floor, self.label_set), [room.id for room in floor.rooms])

    def judge_description(self, description: BuildingDescription, room_ids: Sequence[int]) -> Realism:
        """As `judge`, for a floor that is described in the label set of the model; room_ids: of its rooms."""
        gram = self._kernel.compare([description])
        likeness = measure_likeness(gram)
        return Realism(
            likeness=float(likeness[0]),
            usual=tuple(self._typicality.likenesses.tolist()),
            typicality=float(self._typicality.rank(likeness)[0]),
            probability=self._classifier.judge(description) if self.unlike else None,
            alike=find_most_alike(gram, self.known),
            measures=find_off_measures(
                measure_description(description, self.label_set), self._measured, self.label_set
            ),
            patterns=find_off_patterns(list_patterns(description), self._patterns, room_ids),
        )

    def find_building(self, told: BuildingDescription) -> str | None:
        """The building of a known floor, realistic or not, that is the same but for its source; None for no such."""
        pairs = zip((*self.known, *self.unlike), (*self.buildings, *self.unlike_buildings), strict=True)
        return next((building for each, building in pairs if _is_same(told, each)), None)

    def leave_out(self, building: str) -> RealismModel:
        """The model of all floors that it knows but those of a building; raises ModelError where too few are left."""
        kept = [place for place, name in enumerate(self.buildings) if name != building]
        kept_unlike = [place for place, name in enumerate(self.unlike_buildings) if name != building]
        return replace(
            self,
            known=tuple(self.known[place] for place in kept),
            buildings=tuple(self.buildings[place] for place in kept),
            unlike=tuple(self.unlike[place] for place in kept_unlike),
            unlike_buildings=tuple(self.unlike_buildings[place] for place in kept_unlike),
        )

    @cached_property
    def _kernel(self) -> BuildingKernel:
        return BuildingKernel().fit(self.known)

    @cached_property
    def _typicality(self) -> Typicality:
        return learn_typicality(self.known, self.buildings)

    @cached_property
    def _classifier(self) -> RealismClassifier:
        realistic = [True] * len(self.known) + [False] * len(self.unlike)
        floors, buildings = (*self.known, *self.unlike), (*self.buildings, *self.unlike_buildings)
        return RealismClassifier().fit(floors, realistic, buildings)

    @cached_property
    def _measured(self) -> list[dict[str, float | None]]:
        return [measure_description(description, self.label_set) for description in self.known]

    @cached_property
    def _patterns(self) -> list[list[RoomPattern]]:
        return [list_patterns(description) for description in self.known]


def learn_realism(
    floors: Sequence[Floor],
    *,
    label_set: LabelSet,
    buildings: Sequence[str] | None = None,
    unlike: Sequence[Floor] = (),
    unlike_buildings: Sequence[str] | None = None,
) -> RealismModel:
    """Learn what is realistic from real floors, and from unrealistic ones where there are any.

    floors, unlike: with labels in the label set, R/C or F/C/E/S; those without rooms are left out.
    buildings: of which building each floor is; by name_buildings unless given.
    Raises LabelError for rooms without such a label, and ModelError as RealismModel does.
    """
    names, unlike_names = (
        list(given) if given is not None else name_buildings([floor.source for floor in of_class])
        for given, of_class in ((buildings, floors), (unlike_buildings, unlike))
    )
    known, known_buildings = _describe(floors, names, label_set)
    others, others_buildings = _describe(unlike, unlike_names, label_set)
    return RealismModel(known, known_buildings, label_set, others, others_buildings)


def realism_of_types(model: BuildingModel, types: Sequence[str] = ()) -> RealismModel:
    """The floors of some types that a model of building types knows, as what is realistic; of all types unless given.

    Raises ModelError for types that it does not know, and as RealismModel does.
    """
    unknown = sorted(set(types) - set(model.building_types))
    if unknown:
        raise ModelError(
            f"no building of type {', '.join(unknown)} is known, give of {', '.join(model.building_types)}"
        )
    kept = [place for place, kind in enumerate(model.types) if not types or kind in types]
    known = tuple(model.known[place] for place in kept)
    return RealismModel(known, tuple(model.buildings[place] for place in kept), model.label_set)


def name_buildings(sources: Sequence[str]) -> list[str]:
    """The building of each floor, by building_of; where these were fewer than five, each floor is one."""
    names = [building_of(source) for source in sources]
    return names if len(set(names)) >= FOLDS else [*sources]


def _is_same(one: BuildingDescription, other: BuildingDescription) -> bool:
    told, known = ((each.labels, each.sizes, each.sides, each.doors) for each in (one, other))
    return told == known and np.array_equal(one.features, other.features)


def _describe(
    floors: Sequence[Floor], buildings: Sequence[str], label_set: LabelSet
) -> tuple[tuple[BuildingDescription, ...], tuple[str, ...]]:
    pairs = [(floor, name) for floor, name in zip(floors, buildings, strict=True) if floor.rooms]
    return tuple(describe_building(floor, label_set) for floor, _ in pairs), tuple(name for _, name in pairs)
