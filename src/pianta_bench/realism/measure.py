"""Table 8.2 and Fig. 8.4: whether simulated offices are told from real ones, and what one class alone says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from statistics import fmean, median
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pianta.errors import DataError
from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSet
from pianta.realism.model import MAX_ATYPICAL, MIN_BUILDINGS, MIN_UNREALISTIC_BUILDINGS, Realism, RealismModel
from pianta.rooms.completion import LABELS, fill_missing_labels, map_labels_upwards
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings, set_building_type
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable, Items, save_comparisons
from pianta_bench.harness.table import Row
from pianta_bench.places.models import CENTRAL, LOCAL, PIANTA, TREES
from pianta_bench.realism.models import GAUSSIAN, KLOG, SCORERS, describe_drawn, score_left_out
from pianta_bench.realism.readings import MAPPED, UNLABELLED, read_again

OFFICES, WORLDS, SCHOOLS = "offices", "worlds", "schools"
# By part: the folder of data/buildings, and the building type whose labels its rooms have.
SOURCES = MappingProxyType(
    {OFFICES: ("office", "office"), WORLDS: ("robocup", "office"), SCHOOLS: ("school", "school")}
)
COMPARED = (OFFICES, WORLDS)
TWO, ONE = f"{PIANTA}, two classes", f"{PIANTA}, one class"
MODELS = (LOCAL, CENTRAL, KLOG, GAUSSIAN, TWO, ONE)
# A floor with such a score or above is called realistic, by ONE above only; decisions are 0 where the classes meet.
THRESHOLDS: Mapping[str, float] = MappingProxyType(
    {LOCAL: 0.5, CENTRAL: 0.5, KLOG: 0.0, GAUSSIAN: 0.5, TWO: 0.5, ONE: MAX_ATYPICAL}
)
# Errors in R/C and in F/C/E/S, % (Table 8.2).
PRINTED: Mapping[str, tuple[float, float]] = MappingProxyType(
    {LOCAL: (16.67, 8.33), CENTRAL: (8.33, 0.0), KLOG: (0.0, 0.0)}
)
# Buildings that must be there so that enough are left when one is left out.
LEAST: Mapping[str, int] = MappingProxyType({OFFICES: MIN_BUILDINGS + 1, WORLDS: MIN_UNREALISTIC_BUILDINGS + 1})
NAME_LENGTH = 30


@dataclass(frozen=True, eq=False)
class JudgedRealism:
    """A floor and what is said of it by those who have not seen its building.

    drawn: with labels in R/C and F/C/E/S. part: OFFICES, WORLDS or SCHOOLS.
    scores: by model and label set; what is realistic has a higher one. ONE only for SCHOOLS.
    realism: by label set. views: by UNLABELLED and MAPPED, the same of what pianta sees by itself.
    """

    drawn: AnnotatedFloor
    part: str
    scores: Mapping[tuple[str, LabelSet], float]
    realism: Mapping[LabelSet, Realism]
    views: Mapping[tuple[str, LabelSet], Realism]


@dataclass(frozen=True)
class RealismBench:
    """What was measured.

    seed, trees: of Extra-Trees. failed: by part, the floors that could not be judged, and why.
    """

    seed: int
    trees: int
    floors: Sequence[JudgedRealism]
    failed: Mapping[str, tuple[Row, ...]]

    def of_part(self, part: str) -> list[JudgedRealism]:
        """The floors of a part."""
        return [floor for floor in self.floors if floor.part == part]

    @property
    def items(self) -> Items:
        """Every score of every floor, and what failed, by part."""
        return {part: [*map(_row, self.of_part(part)), *self.failed[part]] for part in SOURCES}


def measure_realism(
    data: Path, *, seed: int = 0, trees: int = TREES, track: Callable[[Sequence[str]], Iterable[str]] = iter
) -> RealismBench:
    """Judge the floors of data/buildings/office and data/buildings/robocup, each without its building.

    The schools of the data, when there are any, are judged by the offices alone.
    A floor that cannot be read or has unknown labels does not count. seed, trees: of Extra-Trees. track: wraps the
    names of models and label sets, to show progress.
    Raises DataError for floors of too few buildings, which are four of offices and three of worlds.
    """
    read: dict[str, list[AnnotatedFloor]] = {}
    failed: dict[str, tuple[Row, ...]] = {}
    for part in SOURCES:
        read[part], failed[part] = _read_part(data, part)
    for part in COMPARED:
        count = len({floor.building for floor in read[part]})
        if count < LEAST[part]:
            raise DataError(
                f"{len(read[part])} {part} of {count} building{'s' * (count != 1)} could be read, "
                f"give {LEAST[part]} buildings at least"
            )
    return RealismBench(seed, trees, _judge_all(read, seed, trees, track), failed)


def tabulate_realism(bench: RealismBench) -> tuple[ComparisonTable, ...]:
    """Table 8.2, what one class alone says, what is left of it on maps, and the scores of every floor."""
    return compare_with_table_8_2(bench), tabulate_one_class(bench), tabulate_views(bench), tabulate_floors(bench)


def compare_with_table_8_2(bench: RealismBench) -> ComparisonTable:
    """Share of floors that are taken for the other kind."""
    rows = []
    for model in MODELS:
        printed = PRINTED.get(model, (None, None))
        cells = [
            Cell(100 * measure_error(bench, model, label_set), None, of_thesis)
            for label_set, of_thesis in zip(LABELS, printed, strict=True)
        ]
        rows.append(ComparisonRow(model, tuple(cells), digits=2))
    counts = [len(bench.of_part(part)) for part in COMPARED]
    notes = (
        f"{counts[0]} real offices and {counts[1]} simulated (thesis: 20 and 6), each judged without its building.",
        f"Ex-T: {bench.trees} trees on single rooms and their labels, a floor is what most of its rooms are.",
        f"{GAUSSIAN}: the kernel of the one class, which compares features by a Gaussian.",
        f"{ONE}: has seen no simulated office; a typicality of {MAX_ATYPICAL} or less is called simulated.",
    )
    columns = tuple(map(str, LABELS))
    return ComparisonTable("Table 8.2, errors of validation", columns, tuple(rows), notes, "% of floors")


def tabulate_one_class(bench: RealismBench) -> ComparisonTable:
    """Typicality and likeness of worlds and schools beside those of the offices that they are compared with."""
    measured = {label_set: dict(_measure_one_class(bench, label_set)) for label_set in LABELS}
    rows = tuple(
        ComparisonRow(name, tuple(Cell(measured[label_set][name]) for label_set in LABELS), digits=3)
        for name in next(iter(measured.values()))
    )
    notes = (
        "typicality: share of the other offices that are less like the rest; likeness: to the three nearest offices.",
        "AUC: chance that an office is more like the others than a world is.",
    )
    return ComparisonTable("One class: the reference is real offices only", tuple(map(str, LABELS)), rows, notes)


def tabulate_views(bench: RealismBench) -> ComparisonTable:
    """Whether drawings without labels, and maps, are judged as drawings with labels are."""
    columns, cells = [], []
    for label_set, view in product(LABELS, (None, UNLABELLED, MAPPED)):
        judged = {
            part: [
                floor.realism[label_set] if view is None else floor.views[view, label_set]
                for floor in bench.of_part(part)
                if view is None or (view, label_set) in floor.views
            ]
            for part in COMPARED
        }
        columns.append(f"{label_set}\n{view or 'drawn'}")
        cells.append(_share_wrong(judged[OFFICES], judged[WORLDS]))
    names = ("worlds called simulated by one class", "offices called so", "two classes: errors")
    rows = [ComparisonRow(name, row) for name, row in zip(names, zip(*cells, strict=True), strict=True)]
    notes = (
        f"{UNLABELLED}: drawn rooms, labelled by the model that comes with pianta, which knows the offices.",
        f"{MAPPED}: rooms as read from a simulated robot's map, stretched at random, and labelled by it.",
    )
    return ComparisonTable("Without labels, and on maps", tuple(columns), tuple(rows), notes, "% of floors")


def tabulate_floors(bench: RealismBench) -> ComparisonTable:
    """The scores of each office and world: probability of being real, typicality and likeness."""
    columns = [f"{label_set}\n{name}" for label_set in LABELS for name in ("two", "one", "likeness")]
    rows = []
    for floor in (floor for part in COMPARED for floor in bench.of_part(part)):
        cells = []
        for label_set in LABELS:
            judged = floor.realism[label_set]
            cells += [Cell(value) for value in (judged.probability, judged.typicality, judged.likeness)]
        rows.append(ComparisonRow(_shorten(floor.drawn.item), tuple(cells), digits=2))
    notes = ("two: probability of being real, of two classes; one: typicality, of one class.",)
    return ComparisonTable("Scores of all floors", tuple(columns), tuple(rows), notes)


def measure_error(bench: RealismBench, model: str, label_set: LabelSet) -> float:
    """Share of offices and worlds that a model takes for the other kind."""
    wrong = [
        _is_realistic(model, score) is not (part == OFFICES)
        for part in COMPARED
        for score in list_scores(bench, model, label_set, part)
    ]
    return fmean(wrong)


def list_scores(bench: RealismBench, model: str, label_set: LabelSet, part: str) -> list[float]:
    """Scores of the floors of a part by a model; what is real has higher ones."""
    return [floor.scores[model, label_set] for floor in bench.of_part(part)]


def save_realism(bench: RealismBench, path: str | Path) -> None:
    """Write every figure, and what is said of every floor, as JSON; raises PiantaError when it cannot be written."""
    judged = [
        {"part": floor.part, "item": floor.drawn.item, "label_set": str(label_set), **realism.as_json()}
        for floor in bench.floors
        for label_set, realism in floor.realism.items()
    ]
    more = {"seed": bench.seed, "trees": bench.trees, "floors": judged}
    save_comparisons("realism", tabulate_realism(bench), bench.items, path, more=more)


def _read_part(data: Path, part: str) -> tuple[list[AnnotatedFloor], tuple[Row, ...]]:
    """The floors of a part with labels in both sets, and those that have failed; none of schools that are not there."""
    folder, kind = SOURCES[part]

    def give_labels(drawn: AnnotatedFloor) -> AnnotatedFloor:
        floor = map_labels_upwards(set_building_type(drawn.floor, kind), SCHEMAS[kind])
        return replace(drawn, floor=replace(floor, source=drawn.item))

    if part not in COMPARED and not (data / "buildings" / folder).is_dir():
        return [], ()
    return read_annotated_buildings(data, folder, give_labels)


def _judge_all(
    read: Mapping[str, Sequence[AnnotatedFloor]],
    seed: int,
    trees: int,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> list[JudgedRealism]:
    """All floors with what all models say of them."""
    compared = [floor for part in COMPARED for floor in read[part]]
    real = np.array([part == OFFICES for part in COMPARED for _ in read[part]])
    scores: list[dict[tuple[str, LabelSet], float]] = [{} for of_part in read.values() for _ in of_part]
    realism: list[dict[LabelSet, Realism]] = [{} for _ in scores]
    views: list[dict[tuple[str, LabelSet], Realism]] = [{} for _ in scores]
    trials = [(model, label_set) for label_set in LABELS for model in (*SCORERS, PIANTA)]
    names = ["maps", *(f"{model}, {label_set}" for model, label_set in trials)]
    tracked = iter(track(names))
    next(tracked)
    seen_again = [read_again(floor, seed=seed) for floor in compared]
    for (model, label_set), _ in zip(trials, tracked, strict=True):
        if model in SCORERS:
            said = score_left_out(model, compared, real, label_set, seed=seed, trees=trees)
            for of_floor, score in zip(scores, said, strict=False):
                of_floor[model, label_set] = score
            continue
        judged, judged_views = _judge_left_out(compared, real, read[SCHOOLS], seen_again, label_set)
        for of_floor_again, each_again in zip(views, judged_views, strict=False):
            of_floor_again |= {(view, label_set): said_again for view, said_again in each_again.items()}
        for of_floor, said_of_floor, each in zip(scores, realism, judged, strict=True):
            said_of_floor[label_set] = each
            of_floor[ONE, label_set] = each.typicality
            if each.probability is not None:
                of_floor[TWO, label_set] = each.probability
    drawn = [(floor, part) for part, of_part in read.items() for floor in of_part]
    return [
        JudgedRealism(floor, part, scores[place], realism[place], views[place])
        for place, (floor, part) in enumerate(drawn)
    ]


def _judge_left_out(
    compared: Sequence[AnnotatedFloor],
    real: NDArray[np.bool_],
    schools: Sequence[AnnotatedFloor],
    seen_again: Sequence[Mapping[str, Floor]],
    label_set: LabelSet,
) -> tuple[list[Realism], list[dict[str, Realism]]]:
    """What pianta says of each floor, by one class and by two; of schools by one; and of each floor's views."""
    described = [describe_drawn(floor, label_set) for floor in compared]
    offices, worlds = (np.flatnonzero(real == is_real).tolist() for is_real in (True, False))
    model = RealismModel(
        tuple(described[place] for place in offices),
        tuple(compared[place].building for place in offices),
        label_set,
        tuple(described[place] for place in worlds),
        tuple(compared[place].building for place in worlds),
    )
    judged, judged_views = [], []
    for floor, views in zip(compared, seen_again, strict=True):
        others = model.leave_out(floor.building)
        judged.append(others.assess(floor.floor))
        judged_views.append(
            {view: others.assess(fill_missing_labels(seen, label_set).floor) for view, seen in views.items()}
        )
    one_class = replace(model, unrealistic_floors=(), unrealistic_buildings=())
    return judged + [one_class.assess(floor.floor) for floor in schools], judged_views


def _is_realistic(model: str, score: float) -> bool:
    """Whether a model says so: as the verdicts of pianta, for which 0.5 of two classes is realistic."""
    return score > THRESHOLDS[model] if model == ONE else score >= THRESHOLDS[model]


def _share_wrong(offices: Sequence[Realism], worlds: Sequence[Realism]) -> tuple[Cell, ...]:
    """Worlds and offices that are unlike the offices, and errors of two classes, %."""
    wrong = [not _is_realistic(TWO, judged.probability or 0) for judged in offices]
    wrong += [_is_realistic(TWO, judged.probability or 0) for judged in worlds]
    untypical = ([judged.is_atypical for judged in of_part] for of_part in (worlds, offices))
    return tuple(Cell(100 * fmean(shares) if shares else None) for shares in (*untypical, wrong))


def _measure_one_class(bench: RealismBench, label_set: LabelSet) -> Iterable[tuple[str, float | None]]:
    from sklearn.metrics import roc_auc_score

    offices, worlds, schools = ([floor.realism[label_set] for floor in bench.of_part(part)] for part in SOURCES)
    likeness = [judged.likeness for judged in (*offices, *worlds)]
    usual = median(judged.likeness for judged in offices)
    yield "worlds less like offices than the median office", fmean(judged.likeness < usual for judged in worlds)
    yield "AUC", float(roc_auc_score([True] * len(offices) + [False] * len(worlds), likeness))
    for name, of_part in (("offices", offices), ("worlds", worlds), ("schools", schools)):
        typicality = [judged.typicality for judged in of_part]
        yield f"{name}: median typicality", median(typicality) if typicality else None
        yield f"{name}: called simulated", fmean(judged.is_atypical for judged in of_part) if of_part else None
        yield f"{name}: median likeness", median(judged.likeness for judged in of_part) if of_part else None
        yield f"{name}: reasons told", fmean(len(judged.reasons) for judged in of_part) if of_part else None


def _row(floor: JudgedRealism) -> Row:
    figures: dict[str, float | None] = {
        f"{model}, {label_set}": value for (model, label_set), value in floor.scores.items()
    }
    figures |= {f"likeness, {label_set}": judged.likeness for label_set, judged in floor.realism.items()}
    return Row(floor.drawn.item, figures)


def _shorten(name: str) -> str:
    return name if len(name) <= NAME_LENGTH else f"{name[: NAME_LENGTH - 1]}…"
