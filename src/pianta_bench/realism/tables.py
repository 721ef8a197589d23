"""Table 8.2 beside the published one, one class alone, floors without labels and on maps, and scores of all floors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from statistics import fmean, median

from pianta.labels import LabelSet
from pianta.realism.model import MAX_ATYPICAL, Realism
from pianta.rooms.completion import LABELS
from pianta_bench.harness.error_rates import STATISTICS, STATISTICS_NOTE, measure_error_rates
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.realism.measure import (
    COMPARED,
    MODELS,
    OFFICES,
    ONE,
    SOURCES,
    TWO,
    AssessedFloor,
    is_realistic,
    list_scores,
)
from pianta_bench.realism.models import GAUSSIAN
from pianta_bench.realism.views import MAPPED, UNLABELLED

LABEL_SETS = [str(label_set) for label_set in LABELS]
NAME_LENGTH = 30  # characters of the names of floors
# Counted with the 20 offices and 6 worlds of the thesis.
PRINTED = (
    "Printed figures stand where they can be: 8.33 and 16.67 are no shares of the thesis' 26 floors;",
    "one and two of its 6 worlds give them as means over classes.",
)

TABLE_8_2 = Table(
    title="Table 8.2, errors of validation",
    rows=("model",),
    columns=("label_set", "statistic"),
    where={"model": list(MODELS), "label_set": LABEL_SETS, "statistic": list(STATISTICS)},
    summarise=Cell.only,
    digits=2,
    published="table_8_2.csv",
    unit="%",
)
ONE_CLASS = Table(
    title="One class: the reference is real offices only",
    columns=("label_set",),
    summarise=Cell.only,
    digits=3,
    notes=(
        "typicality: share of the other offices that are less like the rest; likeness: to the three nearest offices.",
        "AUC: probability that an office has a higher likeness than a world.",
    ),
)
VIEWS = Table(
    title="Without labels, and on maps",
    columns=("label_set", "view"),
    summarise=Cell.only,
    unit="% of floors",
    notes=(
        f"{UNLABELLED}: drawn rooms, labelled by the model that comes with pianta, which is trained on the offices.",
        f"{MAPPED}: rooms as read from a simulated robot's map, stretched at random, and labelled by it.",
    ),
)
FLOORS = Table(
    title="Scores of all floors",
    rows=("item",),
    columns=("label_set", "score"),
    summarise=Cell.only,
    digits=2,
    notes=("two: probability of being real, of two classes; one: typicality, of one class.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Table 8.2, one class alone, views of floors, and the scores of every floor."""
    floors: list[AssessedFloor] = results.objects["floors"]
    counts = [sum(floor.part == part for floor in floors) for part in COMPARED]
    notes = (
        f"{counts[0]} real offices and {counts[1]} simulated (thesis: 20 and 6), each assessed without its building.",
        f"Ex-T: {results.options['trees']} trees on single rooms and their labels; the majority of the rooms decides.",
        f"{GAUSSIAN}: the kernel of the one class, a Gaussian of the features.",
        f"{ONE}: not trained on simulated offices; a typicality of {MAX_ATYPICAL} or less is called simulated.",
        STATISTICS_NOTE,
        *PRINTED,
    )
    return [
        TABLE_8_2.fill(derive_errors(results), notes=notes),
        ONE_CLASS.fill(record for label_set in LABELS for record in derive_one_class(floors, label_set)),
        VIEWS.fill(derive_views(floors)),
        FLOORS.fill(derive_scores(floors)),
    ]


def derive_errors(results: Results) -> Iterator[Record]:
    """For each model and label set the error rates of offices and worlds, %, by statistic."""
    for model, label_set in product(MODELS, LABELS):
        scores = [(part, score) for part in COMPARED for score in list_scores(results, model, label_set, part).tolist()]
        if not scores:
            continue
        wrong = [is_realistic(model, score) is not (part == OFFICES) for part, score in scores]
        for statistic, rate in measure_error_rates([part for part, _ in scores], wrong).items():
            yield {"model": model, "label_set": str(label_set), "statistic": statistic, "value": rate}


def derive_one_class(floors: Sequence[AssessedFloor], label_set: LabelSet) -> Iterator[Record]:
    """Typicality and likeness of worlds and schools, and of the offices that they are compared with."""
    for metric, value in _measure_one_class(floors, label_set):
        yield {"metric": metric, "label_set": str(label_set), "value": value}


def _measure_one_class(floors: Sequence[AssessedFloor], label_set: LabelSet) -> Iterator[tuple[str, float | None]]:
    """Names and values of the figures of likeness, typicality and reasons; None for a part without floors."""
    from sklearn.metrics import roc_auc_score

    parts = {part: [floor.realism[label_set] for floor in floors if floor.part == part] for part in SOURCES}
    offices, worlds, _ = parts.values()
    likeness = [realism.likeness for realism in (*offices, *worlds)]
    usual = median(realism.likeness for realism in offices)
    yield "worlds less like offices than the median office", fmean(realism.likeness < usual for realism in worlds)
    yield "AUC", float(roc_auc_score([True] * len(offices) + [False] * len(worlds), likeness))
    for part, assessed in parts.items():
        yield f"{part}: median typicality", median(each.typicality for each in assessed) if assessed else None
        yield f"{part}: called simulated", fmean(each.is_atypical for each in assessed) if assessed else None
        yield f"{part}: median likeness", median(each.likeness for each in assessed) if assessed else None
        yield f"{part}: reasons", fmean(len(each.reasons) for each in assessed) if assessed else None


def derive_views(floors: Sequence[AssessedFloor]) -> Iterator[Record]:
    """Errors on drawings with labels, drawings without, and maps, %."""
    for label_set, view in product(LABELS, ("drawn", UNLABELLED, MAPPED)):
        parts: dict[str, list[Realism]] = {part: [] for part in COMPARED}
        for floor in floors:
            realism = floor.realism[label_set] if view == "drawn" else floor.views.get((view, label_set))
            if floor.part in COMPARED and realism:
                parts[floor.part].append(realism)
        atypical = {part: [realism.is_atypical for realism in assessed] for part, assessed in parts.items()}
        wrong = [
            is_realistic(TWO, realism.probability or 0) is not (part == OFFICES)
            for part, assessed in parts.items()
            for realism in assessed
        ]
        offices, worlds = atypical.values()
        figures = {
            "worlds called simulated by one class": worlds,
            "offices called simulated by one class": offices,
            "two classes: errors": wrong,
        }
        for metric, shares in figures.items():
            value = 100 * fmean(shares) if shares else None
            yield {"metric": metric, "label_set": str(label_set), "view": view, "value": value}


def derive_scores(floors: Sequence[AssessedFloor]) -> Iterator[Record]:
    """The scores of each office and world: probability of being real, typicality and likeness."""
    for floor, label_set in product(floors, LABELS):
        if floor.part in COMPARED:
            realism = floor.realism[label_set]
            scores = {"two": realism.probability, "one": realism.typicality, "likeness": realism.likeness}
            for score, value in scores.items():
                yield {
                    "item": _shorten(floor.annotated.item),
                    "label_set": str(label_set),
                    "score": score,
                    "value": value,
                }


def _shorten(name: str) -> str:
    return name if len(name) <= NAME_LENGTH else f"{name[: NAME_LENGTH - 1]}…"
