"""Table 3.1b beside the published one, the means of each set of maps, and the figures of each map."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from statistics import fmean

from pianta.layout.rivals.methods import SEGMENTATIONS
from pianta_bench.harness.records import Record, Results, name_parts
from pianta_bench.harness.tables import Cell, FilledTable, Table, read_published
from pianta_bench.layout.as_printed import AS_PRINTED
from pianta_bench.layout.timing import FAILED_NOTE, TIME_NOTE
from pianta_bench.segmentation.counts import pool_counts
from pianta_bench.segmentation.measure import FAILED, SCORES

SCORE_LABELS = {"precision": "prec.", "recall": "recall", "a_fc": "A_FC", "mean_iou": "mean\nIoU", "f1": "\nF1"}
TIME_LABELS = {"seconds": "time\ns", "transforms": "time\nDT"}
PUBLISHED_SETS = ("survey", "furniture")
PUBLISHED_MAPS = 20  # thesis, Table 3.1b
# Ratios of sums over all maps: by metric the numerator and the denominator.
RATIOS = {
    "found_per_true": ("found", "true"),
    "still_there": ("still_there", "rooms_before"),
    "kept_id": ("kept_id", "still_there"),
}
COUNT_NOTE = (
    "survey and furniture: all pixels of a room count, also under furniture; the others: free cells only. Rooms of up "
    "to 0.25 m² are dropped on both sides. doors: only rooms at the known ones, which are behind one closed door each."
)
COUNTS_NOTE = (
    "Three counts of the same rooms; the thesis does not say which its rows are. free: the free cells of the map, "
    "against the survey's image of true rooms of at least 1 m². rest: the same, with the free cells in no room as one "
    "more found room. polygons: the whole polygons, against the layout that the thesis' author drew of the map, in "
    "which corridors that turn are several rooms. drawn, free: that layout on free cells alone."
)

SCORES_OF_SET = Table(
    title="Room segmentation, {part}",
    rows=("method",),
    columns=("metric",),
    where={"metric": list(SCORES)},
    labels=SCORE_LABELS,
    unit="%",
)
ROOMS_OF_SET = Table(
    title="Rooms in all, {part}",
    rows=("method",),
    columns=("metric",),
    where={"metric": ["found_per_true", "mean seconds", "median transforms"]},
    labels={"found_per_true": "found / true", "mean seconds": "time, s", "median transforms": "time, DT"},
    digits={"found_per_true": 2, "median transforms": 0},
)
MAPS = Table(
    title="Room segmentation of each map, {part}, {method}",
    rows=("item",),
    columns=("metric",),
    where={"metric": [*SCORES, "found", "true", *TIME_LABELS]},
    labels={**SCORE_LABELS, "found": "rooms\nfound", "true": "\ntrue", **TIME_LABELS},
    summarise=Cell.only,
    digits={"seconds": 2},
    summaries=("mean", "sd", "median"),
)
# The three counts of which one may be that of the thesis, and their names in the tables.
COUNTS = {"free": "free", "rest": "rest", "polygons": "polygons"}
# In place of a count: what the thesis prints.
PRINTED = "printed"
# Counts with mean IoU and F1; those of the rest as a room would say little.
OTHER_COUNTS = {"free": "free", "polygons": "polygons", "drawn_free": "drawn, free"}
TABLE_3_1B = Table(
    title="Table 3.1b, accuracy of room segmentation by three counts, {part}",
    rows=("method",),
    columns=("metric",),
    where={"metric": [f"{score}_{count}" for count in (*COUNTS, PRINTED) for score in ("precision", "recall")]},
    labels={
        f"{score}_{count}": f"{name}\n{label}"
        for count, name in (COUNTS | {PRINTED: ""}).items()
        for score, label in (("precision", "prec."), ("recall", "recall"))
    },
    published="table_3_1b.csv",
    unit="%",
)
OTHER_SCORES = Table(
    title="Mean IoU and F1 by the same counts, {part}",
    rows=("method",),
    columns=("metric",),
    where={"metric": [f"{score}_{count}" for count in OTHER_COUNTS for score in ("mean_iou", "f1")]},
    labels={
        f"{score}_{count}": f"{name}\n{label}"
        for count, name in OTHER_COUNTS.items()
        for score, label in (("mean_iou", "IoU"), ("f1", "F1"))
    },
    unit="%",
)
COUNT_LABELS = {
    "right": "right",
    "right_whole": "right,\nwhole",
    "splits": "splits",
    "merges": "merges",
    "no_rooms": "no\nrooms",
    "doors": "doors",
    "within": "doors\nin one",
    "nowhere": "doors\nnowhere",
}
COUNTED_NOTE = (
    "On free cells. right: true rooms with which a room has an IoU of at least 0.6; whole: those that are not split. "
    "splits: rooms of at least 0.4 m² that lie mostly (with more than half of their cells) in one true room, without "
    "the first; merges: true rooms that lie mostly in one room, without the first. no rooms: at most half in true "
    "rooms. doors in one: both rooms lie in the same true room; doors nowhere: beside what is no room, and entrances."
)
COUNTS_OF_SET = Table(
    title="Counts, {part}",
    rows=("method",),
    columns=("metric",),
    labels={
        "all_counted_true": "true",
        "share_right": "right\n%",
        "share_whole": "whole\n%",
        "splits_per_map": "splits\na map",
        "merges_per_map": "merges\na map",
        "all_no_rooms": "no\nrooms",
        "all_doors": "doors",
        "all_within": "doors\nin one",
        "all_nowhere": "doors\nnowhere",
        "share_doors_wrong": "wrong\n%",
    },
    digits={"all_counted_true": 0, "all_no_rooms": 0, "all_doors": 0, "all_within": 0, "all_nowhere": 0},
    notes=(COUNTED_NOTE,),
)
COUNTS_OF_MAPS = Table(
    title="Counts of each map, {part}, {method}",
    rows=("item",),
    columns=("metric",),
    where={"metric": ["counted_true", "counted_found", *COUNT_LABELS]},
    labels={"counted_true": "rooms\ntrue", "counted_found": "rooms\nfound", **COUNT_LABELS},
    summarise=Cell.only,
    summaries=("mean",),
)
# Every figure of every map, by method and set.
MEANS = Table(
    title="Means of all figures",
    rows=("part", "method"),
    columns=("metric",),
    where={"metric": list(FAILED)},
    is_printed=False,
)
MEDIANS = Table(
    title="Medians of all figures",
    rows=("part", "method"),
    columns=("metric",),
    where={"metric": list(FAILED)},
    summarise=Cell.median,
    is_printed=False,
)


def tabulate(results: Results) -> list[FilledTable]:
    """Means of each set, the figures of the maps where wanted, and Table 3.1b where its maps are there."""
    methods, maps = results.options["methods"], results.options["maps"]
    tables = []
    for part in name_parts(results.items):
        own = results.select(part=part)
        tables.append(SCORES_OF_SET.fill(own, part=part))
        derived = [*divide_sums(results, part), *summarise_times(results, part)]
        tables.append(ROOMS_OF_SET.fill(derived, notes=list_lasting(derived), part=part))
        if maps or len(methods) == 1:
            tables += [MAPS.fill(results.select(part=part, method=each), part=part, method=each) for each in methods]
        tables += tabulate_counts(results, part)
        if part in PUBLISHED_SETS:
            tables += compare_counts(results, part)
    notes = [COUNT_NOTE, TIME_NOTE, *[FAILED_NOTE] * results.failed]
    tables[-1] = replace(tables[-1], notes=(*tables[-1].notes, *notes))
    return [*tables, MEANS.fill(results.records), MEDIANS.fill(results.records)]


def compare_counts(results: Results, part: str) -> Iterator[FilledTable]:
    """Table 3.1b of a set by three counts; and other scores by them."""
    count = len({item.item for item in results.items if item.part == part})
    note = f"The thesis' figures are over {PUBLISHED_MAPS} maps; here are {count}."
    # Rows that nothing was measured for are those of the thesis
    methods = [*results.options["methods"], *(row["method"] for row in read_published(TABLE_3_1B.published))]
    methods = [*dict.fromkeys(each for each in methods if each in results.options["methods"] or each != AS_PRINTED)]
    table = TABLE_3_1B.narrow(part=part, method=methods)
    yield table.fill(results.records, notes=(note, *compare_with_rivals(results, part)), part=part)
    yield OTHER_SCORES.fill(results.select(part=part), notes=(COUNTS_NOTE,), part=part)


def compare_with_rivals(results: Results, part: str) -> Iterator[str]:
    """How far the rows of the rivals are from the published ones by each count: which count is the thesis' own."""
    distances: dict[str, list[float]] = {count: [] for count in COUNTS}
    rows = [row for row in read_published(TABLE_3_1B.published) if row["part"] == part]
    for row, count in product(rows, COUNTS):
        metric = row["metric"].replace(PRINTED, count)
        values = results.values(part=part, method=row["method"], metric=metric)
        if values and row["method"] in SEGMENTATIONS:
            distances[count].append(abs(fmean(values) - float(row["mean"])))
    if all(distances.values()):
        text = ", ".join(f"{COUNTS[count]} {fmean(each):.1f}" for count, each in distances.items())
        yield f"Mean distance of the other authors' rows from those of the thesis, in points: {text}."


def tabulate_counts(results: Results, part: str) -> Iterator[FilledTable]:
    """The counts of a set and of its maps, where rooms were counted."""
    methods, maps = results.options["methods"], results.options["maps"]
    pooled = [*pool_counts(results, part)]
    if not pooled:
        return
    yield COUNTS_OF_SET.narrow(metric=list(COUNTS_OF_SET.labels)).fill(pooled, part=part)
    if maps or len(methods) == 1:
        for method in methods:
            yield COUNTS_OF_MAPS.fill(results.select(part=part, method=method), part=part, method=method)


def divide_sums(results: Results, part: str) -> Iterator[Record]:
    """For each method the ratios of sums over the maps that have both figures."""
    for method in results.options["methods"]:
        for ratio, (numerator, denominator) in RATIOS.items():
            figures = {
                metric: [record["value"] for record in results.select(part=part, method=method, metric=metric)]
                for metric in (numerator, denominator)
            }
            pairs = [pair for pair in zip(figures[numerator], figures[denominator], strict=True) if None not in pair]
            total = sum(below for _, below in pairs)
            value = sum(above for above, _ in pairs) / total if total else None
            yield {"part": part, "method": method, "metric": ratio, "value": value}


def summarise_times(results: Results, part: str) -> Iterator[Record]:
    """For each method the mean of the seconds, and the median of the distance transforms."""
    for method in results.options["methods"]:
        seconds, transforms = (results.values(part=part, method=method, metric=metric) for metric in TIME_LABELS)
        yield {"part": part, "method": method, "metric": "mean seconds", "value": Cell.over(seconds).mean}
        yield {"part": part, "method": method, "metric": "median transforms", "value": Cell.median(transforms).mean}


def list_lasting(derived: list[Record]) -> list[str]:
    """Where maps grow, for each method: the rooms that the next step still has, and the ids that they keep."""
    ratios = {(record["method"], record["metric"]): record["value"] for record in derived}
    notes = []
    for method in dict.fromkeys(record["method"] for record in derived):
        rooms, ids = ratios[method, "still_there"], ratios[method, "kept_id"]
        if rooms is not None and ids is not None:
            notes.append(
                f"{method}: {rooms:.1%} of rooms are there in the next step, {ids:.1%} of these with their id."
            )
    return notes
