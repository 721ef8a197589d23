"""A PredictionBench in tables: the bars, labels, numbers of rooms, skeletons, and doors, for each type."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import fmean, median

import numpy as np

from pianta._types import Floats
from pianta.evaluation.prediction import expect_calibration_error, measure_label_reliability
from pianta.evaluation.semantics import Reliability, measure_reliability
from pianta.labels import LabelSchema
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable
from pianta_bench.prediction.measure import PredictionBench, TypeOfFloors
from pianta_bench.prediction.rivals import BLIND, KNOWN, LOCAL, RIVALS
from pianta_bench.prediction.scores import (
    DISTANCES,
    LABEL_SETS,
    MEAN,
    MEDOID,
    ORACLE,
    PREDICTED,
    SAMPLE,
    TYPICAL,
    DoorGuess,
    JudgedStage,
)

HALF, ALL = "half", "all"
WHOLES = ("rooms", "corridors")
# Rooms of the floors whose prediction is timed.
TIMED = (35, 45)
MAX_NOTE = 78
CHANCE_DRAWS = 200
SKELETON_SAYERS = (PREDICTED, TYPICAL, BLIND, MEDOID, KNOWN, LOCAL)
# What the skeleton of a prediction is held against: the mean distance over its samples against that over floors.
FAIR_RIVALS = {PREDICTED: (BLIND, KNOWN, LOCAL), TYPICAL: (MEDOID, KNOWN, LOCAL)}


def tabulate_prediction(bench: PredictionBench) -> tuple[ComparisonTable, ...]:
    """For each type the bars, then labels, numbers of rooms, skeletons, doors, their reliability, and time."""
    return tuple(
        table
        for kind, of in bench.types.items()
        for table in (
            tabulate_bars(of, kind),
            tabulate_labels(of, kind),
            tabulate_sizes(of, kind),
            tabulate_skeletons(of, kind),
            tabulate_doors(of, kind),
            tabulate_reliability(of, kind),
            tabulate_time(of, kind, bench.count),
        )
    )


def tabulate_bars(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """How many floors are predicted better than by each rival with half of the corridors, and how much better."""
    rows = []
    notes = [f"{len(of.halves)} of {len(of.floors)} {kind}s have rooms unseen with half of their corridors explored."]
    measures = [
        ("labels", PREDICTED, RIVALS),
        *((d, who, fair) for d in DISTANCES for who, fair in FAIR_RIVALS.items()),
    ]
    for name, who, rivals in measures:
        shares, gains = [], []
        for rival in rivals:
            pairs = pair_figures(of, f"{name}, {who}", f"{name}, {rival}")
            shares.append(
                Cell(100 * fmean(ours < other for ours, other in pairs.values()) if pairs else None, count=len(pairs))
            )
            gains.append(Cell(measure_gain(pairs), count=len(pairs)))
            if name == "labels" and rival == BLIND:
                worse = [item for item, (ours, other) in pairs.items() if ours >= other]
                notes.append(f"Labels below the blind average in {len(pairs) - len(worse)} of {len(pairs)}; not in:")
                notes += wrap_names(worse)
        rows.append(ComparisonRow(f"{name}, {who}: better in", tuple(shares)))
        rows.append(ComparisonRow(f"{name}, {who}: mean lower by", tuple(gains)))
    pairs = pair_figures(of, f"labels, {ORACLE}", f"labels, {BLIND}")
    if (gain := measure_gain(pairs)) is not None:
        below = sum(oracle < blind for oracle, blind in pairs.values())
        notes.append(f"The oracle's labels, not to be had: lower by {gain:.1f} %, below in {below} of {len(pairs)}.")
    notes.append("blind: the mean over skeletons of other floors; beside typical the most typical one.")
    return ComparisonTable(
        f"Section 8.3, {kind}s, half of the corridors: against rivals", RIVALS, tuple(rows), tuple(notes), "%"
    )


def tabulate_labels(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """Divergence of the labels of unseen rooms."""
    says = (PREDICTED, MEAN, SAMPLE, *RIVALS, ORACLE)
    rows = [
        ComparisonRow(f"{name}, {stages}", tuple(summarise(of, f"{name}, {who}", stages) for who in says), digits=3)
        for stages in (HALF, ALL)
        for name in LABEL_SETS.values()
    ]
    silent = sum(bool(floor.half and floor.half.is_silent) for floor in of.floors)
    notes = (
        "predicted: the distribution nearest to the samples'; mean: of the samples.",
        "oracle: as many labels as are unseen, of this floor's own; not to be had.",
        f"local: blind where there is no guess, on {silent} floors with half of the corridors.",
        "half: of the corridors are explored; all: the mean over stages of a floor first.",
    )
    return ComparisonTable(
        f"Jensen-Shannon divergence of the labels of unseen rooms, {kind}s", says, tuple(rows), notes, "bits"
    )


def tabulate_sizes(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """Errors of the numbers of rooms and corridors."""
    says = (PREDICTED, *RIVALS)
    intervals = {
        HALF: share_intervals([stage for _, stage in of.halves]),
        ALL: share_intervals([stage for floor in of.floors for stage in floor.stages]),
    }
    rows = []
    for stages in (HALF, ALL):
        for whole in WHOLES:
            rows.append(
                ComparisonRow(
                    f"{whole}, error, {stages}", tuple(summarise(of, f"{whole}, {who}", stages, by=abs) for who in says)
                )
            )
            rows.append(
                ComparisonRow(
                    f"{whole}, bias, {stages}", tuple(summarise(of, f"{whole}, {who}", stages) for who in says)
                )
            )
    notes = (
        "blind: the mean of other floors, at least what is known; local: a room more for",
        "each open end; known part: times known corridors over explored ones.",
        f"Rooms in the interval of four of five samples: {intervals[HALF]} (half), {intervals[ALL]} (all).",
    )
    return ComparisonTable(f"Rooms of the whole floor, {kind}s", says, tuple(rows), notes, "rooms")


def tabulate_skeletons(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """Distances of skeletons of corridors."""
    rows = [
        ComparisonRow(
            f"{name}, {stages}", tuple(summarise(of, f"{name}, {who}", stages) for who in SKELETON_SAYERS), digits=2
        )
        for stages in (HALF, ALL)
        for name in DISTANCES
        if (name, stages) != (DISTANCES[-1], ALL)
    ]
    notes = (
        "WL, NSPDK: sqrt(2 - 2k) of the normalised kernel, which hardly sees sizes.",
        "edits: of nodes, edges, labels, from above; of skeletons of 30 corridors at most.",
        "predicted: mean over samples; typical: of one; medoid: one of the other floors.",
    )
    return ComparisonTable(f"Distance of the skeleton of corridors, {kind}s", SKELETON_SAYERS, tuple(rows), notes)


def tabulate_doors(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """How often guesses of what is behind a door are right, and how far their probabilities can be trusted."""
    rows = []
    for name, guesses in list_guesses(of).items():
        top, every = find_reliability(guesses, of.schema)
        right = [pick_top(guess) == guess.true for guess in guesses]
        local = [guess.local == guess.true for guess in guesses]
        figures = (
            100 * fmean(right) if right else None,
            100 * fmean(local) if local else None,
            100 * top.error if right else None,
            100 * expect_calibration_error(list_probabilities(guesses, of.schema), draws=CHANCE_DRAWS, seed=0)
            if right
            else None,
            100 * every.error if right else None,
        )
        rows.append(
            ComparisonRow(
                f"{name} ({len(guesses)} doors)", tuple(Cell(figure, count=len(guesses)) for figure in figures)
            )
        )
    columns = ("right", "local right", "error of\ntop label", "by chance\nalone", "error of\nevery label")
    notes = (
        "Expected calibration errors; by chance alone: if all probabilities were exact.",
        "all: each door once, at the first stage at which it is unopened.",
    )
    return ComparisonTable(f"What is behind unopened doors, {kind}s", columns, tuple(rows), notes, "%")


def tabulate_reliability(of: TypeOfFloors, kind: str) -> ComparisonTable:
    """How often the top label of a door is right, by its probability; doors of all stages."""
    top, _ = find_reliability(list_guesses(of)[ALL], of.schema)
    rows = []
    for low, count, said, right in zip(top.edges, top.counts, top.confidence, top.accuracy, strict=False):
        if count:
            cells = Cell(float(count)), Cell(100 * float(said)), Cell(100 * float(right))
            rows.append(ComparisonRow(f"{100 * low:.0f} to {100 * low + 10:.0f} %", cells))
    columns = ("doors", "probability, %", "right, %")
    return ComparisonTable(f"Reliability of guesses of doors, all stages, {kind}s", columns, tuple(rows))


def tabulate_time(of: TypeOfFloors, kind: str, count: int) -> ComparisonTable:
    """Seconds of the processor for a prediction, its sampler, and its model."""
    low, high = TIMED
    timed = {
        HALF: [stage.seconds for floor, stage in of.halves if low <= floor.rooms <= high],
        ALL: [stage.seconds for floor in of.floors if low <= floor.rooms <= high for stage in floor.stages],
    }
    rows = [
        ComparisonRow(f"prediction, {name}", (Cell(median(seconds) if seconds else None, count=len(seconds)),), 2)
        for name, seconds in timed.items()
    ]
    rows += [
        ComparisonRow(name, (Cell(median(seconds), count=len(seconds)),), 2)
        for name, seconds in (("sampler, once", of.sampler_seconds), ("model, once", of.learning_seconds))
    ]
    title = f"Time of {count} samples on floors of {low} to {high} rooms, {kind}s"
    return ComparisonTable(title, ("median",), tuple(rows), unit="s of one core")


def summarise(of: TypeOfFloors, key: str, stages: str, *, by: Callable[[float], float] = lambda figure: figure) -> Cell:
    """A figure over floors: of the half stage, or the mean over all stages of each."""
    if stages == HALF:
        return Cell.over([None if (figure := stage.figures[key]) is None else by(figure) for _, stage in of.halves])
    means = []
    for floor in of.floors:
        figures = [by(figure) for stage in floor.stages if (figure := stage.figures[key]) is not None]
        means.append(fmean(figures) if figures else None)
    return Cell.over(means)


def pair_figures(of: TypeOfFloors, ours: str, other: str) -> Mapping[str, tuple[float, float]]:
    """Two figures of the half stage, by floor, of floors that have both."""
    found = {floor.source: (stage.figures[ours], stage.figures[other]) for floor, stage in of.halves}
    return {item: (one, two) for item, (one, two) in found.items() if one is not None and two is not None}


def measure_gain(pairs: Mapping[str, tuple[float, float]]) -> float | None:
    """By how many per cent the mean of the first figures is lower than that of the others."""
    total = sum(other for _, other in pairs.values())
    return 100 * (1 - sum(ours for ours, _ in pairs.values()) / total) if total else None


def list_guesses(of: TypeOfFloors) -> dict[str, list[DoorGuess]]:
    """The guesses of doors with half of the corridors explored, and of each door once."""
    return {
        HALF: [guess for _, stage in of.halves for guess in stage.guesses],
        ALL: [guess for floor in of.floors for guess in floor.first_guesses],
    }


def find_reliability(guesses: Sequence[DoorGuess], schema: LabelSchema) -> tuple[Reliability, Reliability]:
    """Reliability of the top labels, and of all labels, of guesses."""
    probabilities = list_probabilities(guesses, schema)
    names = [*schema.by_name]
    truth = np.array([names.index(guess.true) for guess in guesses], int)
    return measure_reliability(probabilities, truth), measure_label_reliability(probabilities, truth)


def list_probabilities(guesses: Sequence[DoorGuess], schema: LabelSchema) -> Floats:
    """The probabilities of all labels, shape (guesses, labels)."""
    rows = [[guess.labels.get(name, 0.0) for name in schema.by_name] for guess in guesses]
    return np.array(rows, float).reshape(-1, len(schema.by_name))


def pick_top(guess: DoorGuess) -> str | None:
    """The most probable label, the first of several; None where nothing is said."""
    return max(guess.labels, key=lambda label: guess.labels[label]) if guess.labels else None


def share_intervals(stages: Sequence[JudgedStage]) -> str:
    """How many of the stages have their rooms in the interval."""
    return f"{sum(stage.interval for stage in stages)} of {len(stages)}"


def wrap_names(names: Sequence[str]) -> list[str]:
    """Names in lines of a note each."""
    lines = [""]
    for name in names or ("none",):
        if len(lines[-1]) + len(name) > MAX_NOTE:
            lines.append("")
        lines[-1] += ("  " if not lines[-1] else ", ") + name
    return lines
