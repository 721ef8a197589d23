"""Buildings classified from the thesis' fact files, in R/C, in F/C/E/S, and by the labels of the types themselves."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask
from pianta.errors import DataError
from pianta.io._files import short_repr
from pianta.labels import LabelSet
from pianta.relational.fact_files import read_interpretations
from pianta.relational.facts import Interpretation
from pianta.relational.kernels import BINS, COST, FloorKernel, decide, fit_svm
from pianta_bench.buildings.floors import MIN_BUILDINGS
from pianta_bench.buildings.models import KLOG, FloorScores, Folds, Outcomes, compare_by_fold
from pianta_bench.data.annotated_floors import KINDS
from pianta_bench.data.building_of import building_of
from pianta_bench.harness.folds import list_folds
from pianta_bench.harness.timing import measure_time

FACTS_FOLDER = "klog"
FACT_TASK = "fact files"
# By label set the end of the files' names.
FILES: Mapping[LabelSet, str] = MappingProxyType({LabelSet.R_C: "RC", LabelSet.F_C_E_S: "RCES", LabelSet.TYPE: "all"})
CHOSEN = "kLog-style, settings chosen in each fold"


class Setting(NamedTuple):
    """Bins of the kernel, of which one hides all numbers, and C of the support vector machine."""

    bins: int
    cost: float


# Among these the settings of a fold are chosen; of equally good ones the first, that of all other tables.
SETTINGS = tuple(Setting(*each) for each in product((BINS, 2, 1), (COST, 100.0, 1.0)))


@dataclass(frozen=True, eq=False)
class FactFloor:
    """A floor of the fact files: name, type, building, and by label set its facts with the labels of the rooms."""

    item: str
    kind: str
    building: str
    facts: Mapping[LabelSet, Interpretation]


@dataclass(frozen=True, eq=False)
class FactScores:
    """Scores of the types of floors, by model and label set, whole buildings left out."""

    floors: Sequence[FactFloor]
    types: dict[tuple[str, LabelSet], FloorScores] = field(default_factory=dict)

    def wrong_floors(self, model: str, label_set: LabelSet) -> Mask:
        """Which floors have a wrong type, shape (floors,)."""
        columns = self.types[model, label_set].values.argmax(axis=1)
        predicted = np.array([sorted(KINDS)[column] for column in columns])
        return np.asarray(predicted != np.array([floor.kind for floor in self.floors]))

    def as_json(self) -> list[dict[str, object]]:
        """For each floor its building and type, and by model and label set whether a wrong type was given."""
        wrong = {key: self.wrong_floors(*key).tolist() for key in self.types}
        return [
            {
                "item": floor.item,
                "building": floor.building,
                "wrong": [
                    {"model": model, "labels": label_set, "wrong": each[index]}
                    for (model, label_set), each in wrong.items()
                ],
            }
            for index, floor in enumerate(self.floors)
        ]


def read_fact_floors(data: Path) -> list[FactFloor]:
    """The floors of data/klog/TYPE_LABELS.pl; none without this folder.

    The building of a floor is that of the drawing of its name.
    Raises DataError if a file is not there, if the files of a type have different floors, or if a type has too few
    buildings; RelationError for files that read_interpretations refuses.
    """
    folder = data / FACTS_FOLDER
    if not folder.is_dir():
        return []
    floors = [floor for building_type in KINDS for floor in _read_type(data, building_type)]
    for building_type in KINDS:
        count = len({floor.building for floor in floors if floor.kind == building_type})
        if count < MIN_BUILDINGS:
            raise DataError(
                f"fact files of {building_type}s in {short_repr(folder)} have {count} buildings, "
                f"give {MIN_BUILDINGS} at least"
            )
    return floors


def _read_type(data: Path, building_type: str) -> Iterator[FactFloor]:
    """The floors of a type."""
    by_set: dict[LabelSet, dict[str, Interpretation]] = {}
    for label_set, ending in FILES.items():
        file = data / FACTS_FOLDER / f"{building_type}_{ending}.pl"
        if not file.is_file():
            raise DataError(f"{short_repr(file)} is not there, give it or remove the folder {FACTS_FOLDER}")
        by_set[label_set] = {floor.name: floor for floor in read_interpretations(file)}
    names = [*by_set[LabelSet.R_C]]
    if any({*floors} != {*names} for floors in by_set.values()):
        raise DataError(
            f"files {building_type}_*.pl of {short_repr(data / FACTS_FOLDER)} have different floors, give the same"
        )
    for name in names:
        item = name_item(name, building_type)
        building = building_of(data, f"buildings/{building_type}/{item}.xml")
        facts = {label_set: floors[name] for label_set, floors in by_set.items()}
        yield FactFloor(item, building_type, f"{building_type}/{building}", facts)


def name_item(name: str, building_type: str) -> str:
    """The name of the drawing of a floor of the fact files.

    >>> name_item("ischoolSKF_FloorPlan_updatedxml", "school")
    'skffloorplan'
    """
    plain = name.removeprefix(f"i{building_type}").removesuffix("xml").removesuffix("_updated")
    return re.sub(r"[^0-9a-z]", "", plain.lower())


def classify_facts(floors: Sequence[FactFloor], label_set: LabelSet, settings: Sequence[Setting]) -> FloorScores:
    """Decision values of the types, whole buildings left out, shape (floors, types).

    settings: the one that makes the fewest errors on the training floors, each without its building, classifies a
    building that was left out.
    """
    facts = [floor.facts[label_set] for floor in floors]
    buildings, kinds = [floor.building for floor in floors], np.array([floor.kind for floor in floors])
    compare = {bins: compare_by_fold(buildings, partial(_compare, facts, bins)) for bins, _ in settings}
    decisions = np.zeros((len(floors), len(KINDS)))
    for training, held_out in list_folds(buildings, most=len(buildings)):
        grams = {bins: compare_one(buildings[held_out[0]]) for bins, compare_one in compare.items()}
        setting = _choose(grams, kinds, [buildings[i] for i in training], training, settings)
        decisions[held_out] = _decide(grams[setting.bins], kinds, training, held_out, setting.cost)
    return FloorScores(decisions)


def _compare(facts: Sequence[Interpretation], bins: int, others: Indices) -> Floats:
    """The Gram matrix of floors, with bins fitted to some of them."""
    return FloorKernel(bins=bins).fit(facts, binned=[facts[i] for i in others]).compare()


def _choose(
    grams: Mapping[int, Floats],
    kinds: NDArray[np.str_],
    buildings: Sequence[str],
    training: Indices,
    settings: Sequence[Setting],
) -> Setting:
    """The first of the settings with the fewest errors on training floors, each without its building."""
    if len(settings) == 1:
        return settings[0]
    folds: Folds = [(training[others], training[own]) for others, own in list_folds(buildings, most=len(buildings))]

    def count_errors(setting: Setting) -> int:
        wrong = 0
        for others, own in folds:
            columns = _decide(grams[setting.bins], kinds, others, own, setting.cost).argmax(axis=1)
            wrong += int((np.array(sorted(KINDS))[columns] != kinds[own]).sum())
        return wrong

    return min(settings, key=count_errors)


def _decide(gram: Floats, kinds: NDArray[np.str_], training: Indices, tested: Indices, cost: float) -> Floats:
    """Decision values of tested floors by a machine of the training floors."""
    machine = fit_svm(gram[np.ix_(training, training)], kinds[training].tolist(), cost=cost)
    return decide(machine, gram[np.ix_(tested, training)], sorted(KINDS))


def list_fact_steps(floors: Sequence[FactFloor]) -> Iterator[tuple[str, Callable[[], Outcomes]]]:
    """The steps that classify floors of the fact files, by name; none without floors."""
    models = {KLOG: SETTINGS[:1], CHOSEN: SETTINGS}
    for model, label_set in product(models, FILES if floors else ()):
        yield f"fact files, {model}, {label_set}", partial(_score, floors, (model, label_set), models[model])


def _score(floors: Sequence[FactFloor], key: tuple[str, LabelSet], settings: Sequence[Setting]) -> Outcomes:
    model, label_set = key
    seconds, scores = measure_time(partial(classify_facts, floors, label_set, settings))
    return [(FACT_TASK, model, seconds, {key: scores})]
