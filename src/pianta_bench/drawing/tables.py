"""Doors, sizes, realism, and the closed circle of drawn buildings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from statistics import median

from scipy.stats import ks_2samp

from pianta.generation.drawing.programme import LEAST_WINDOW
from pianta_bench.drawing.circle import DOORS, REACHED, ROOMS, SAME, SAME_LABELLED, SCANS
from pianta_bench.drawing.measure import (
    ALL_DOORS,
    COURTS,
    EDGES,
    FACADE,
    GENERATED,
    HULL,
    LARGEST_DRAWN,
    LARGEST_SCANNED,
    NARROW,
    NARROW_DOORS,
    OVERLAP,
    REAL,
    REALISED,
    SECONDS,
    WITHHELD,
    WORLDS,
    find_lit_shares,
    list_sizes,
    measure_compactness,
)
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table

SOURCES = [GENERATED, WITHHELD]
LABELS = 6  # most frequent ones of the real floors
SHARE, SMALL_SHARE, DOOR_SHARE = (
    "with all doors, %",
    f"of those up to {LARGEST_DRAWN} rooms, %",
    "doors of the graph, %",
)
LARGEST_TIME = "longest, s"
LIT = "windows, %"
SIZE_CLASSES = ((30, "up to 30"), (50, "31 to 50"), (inf, "more"))


def share_of(values: Sequence[float | None]) -> Cell:
    """The share of buildings for which something is true, without a deviation."""
    return replace(Cell.over(values), sd=None)


DOOR_TABLE = Table(
    title="Drawn {type} floors",
    where={"part": SOURCES},
    labels={
        "buildings": "buildings",
        SHARE: SHARE,
        "small": f"buildings up to {LARGEST_DRAWN} rooms",
        SMALL_SHARE: SMALL_SHARE,
        DOOR_SHARE: DOOR_SHARE,
        NARROW: NARROW,
        NARROW_DOORS: NARROW_DOORS,
        OVERLAP: "overlap of rooms, largest, m²",
        SECONDS: "processor time, s",
        LARGEST_TIME: LARGEST_TIME,
    },
    digits={"buildings": 0, "small": 0, NARROW: 0, NARROW_DOORS: 0, DOOR_SHARE: 2, OVERLAP: 3},
    notes=(
        "generated: by a model of all real floors. real graphs: those of the floors,",
        "with areas of other buildings. Width: of the largest circle in a room.",
    ),
)
SIZES = Table(
    title="Rooms of drawn {type} floors against real ones, by label",
    rows=("label", "part"),
    columns=("metric",),
    summarise=Cell.only,
    digits={"area": 1, "aspect": 2, "p of areas": 3, "p of aspects": 3, LIT: 0},
    notes=(
        "Medians, m², and p of the test of Kolmogorov and Smirnov. aspect: longer side",
        "of the smallest rectangle around a room over the shorter one. Windows: rooms",
        f"with {LEAST_WINDOW:g} m of outer wall.",
    ),
)
COMPACTNESS = Table(
    title="Compactness of {type} floors, by their number of rooms",
    rows=("metric", "part"),
    columns=("size",),
    where={"metric": [HULL, COURTS, FACADE], "part": [REAL, *SOURCES], "size": [name for _, name in SIZE_CLASSES]},
    summarise=Cell.median,
    digits=2,
    notes=(
        "Medians: share of the convex hull that is building, share of the outline that",
        "is court, facade over the side of a square of the same area.",
    ),
)
REALISM = Table(
    title="Realism of {type} floors by one class",
    rows=("label_set",),
    where={"metric": "typicality", "part": [REAL, *SOURCES, WORLDS]},
    summarise=Cell.median,
    digits=2,
    notes=(
        "Median share of real floors that are less like others: 0.5 is usual. The",
        "reference of a real floor, and of its graph, is without its building.",
    ),
)
CIRCLE = Table(
    title="Drawn {type} floors, scanned and read again",
    rows=("part", "scan"),
    columns=("metric",),
    where={"part": SOURCES, "scan": [*SCANS], "metric": [ROOMS, DOORS, REACHED]},
    factor=100,
    unit="%",
    notes=(
        f"{{generated}} generated and {{withheld}} real graphs of at most {LARGEST_SCANNED} rooms.",
        "Rooms: IoU above 0.5. In use: furniture by labels, with ways; noise 0.3.",
        "Reached: furnished rooms that a robot gets into from where it has most space.",
    ),
)
GRAPHS = replace(
    CIRCLE,
    title="Drawn {type} floors, scanned and read again: share with the same graph",
    where={**CIRCLE.where, "metric": [SAME, SAME_LABELLED]},
    summarise=share_of,
    notes=(
        "The graph that is read is isomorphic to the drawn one; with R/C also its",
        "labels, which the model that comes with pianta predicts.",
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Doors and widths, sizes by label, realism, and the closed circle."""
    name = results.options["type"]
    scanned = {part: len(results.select(part=part, metric=SAME, scan=next(iter(SCANS)))) for part in SOURCES}
    tables = [
        DOOR_TABLE.fill(_summarise(results), type=name),
        SIZES.fill(_compare_sizes(results), type=name),
        COMPACTNESS.fill(_describe_compactness(results), type=name),
        REALISM.fill(results.records, type=name),
    ]
    if any(scanned.values()):
        tables += [
            CIRCLE.fill(results.records, type=name, generated=scanned[GENERATED], withheld=scanned[WITHHELD]),
            GRAPHS.fill(results.records, type=name),
        ]
    return tables


def _summarise(results: Results) -> Iterator[Record]:
    """What is counted over all buildings of a part, and the processor time of each."""
    for part in SOURCES:
        values = partial(results.values, part=part)
        rooms, complete = values(metric="rooms"), values(metric=ALL_DOORS)
        if not complete:
            continue
        small = [each for each, size in zip(complete, rooms, strict=True) if size <= LARGEST_DRAWN]
        sums = {
            "buildings": len(complete),
            SHARE: 100 * sum(complete) / len(complete),
            "small": len(small),
            SMALL_SHARE: 100 * sum(small) / len(small) if small else None,
            DOOR_SHARE: 100 * sum(values(metric=REALISED)) / sum(values(metric=EDGES)),
            NARROW: sum(values(metric=NARROW)),
            NARROW_DOORS: sum(values(metric=NARROW_DOORS)),
            OVERLAP: max(values(metric=OVERLAP)),
            LARGEST_TIME: max(values(metric=SECONDS)),
        }
        yield from ({"part": part, "metric": metric, "value": value} for metric, value in sums.items())
        yield from results.select(part=part, metric=SECONDS)


def _describe_compactness(results: Results) -> Iterator[Record]:
    """The compactness of each floor, with the class of its size."""
    for part, floors in results.objects["floors"].items():
        for floor in floors:
            size = next(name for most, name in SIZE_CLASSES if len(floor) <= most)
            for metric, value in measure_compactness(floor).items():
                yield {"part": part, "metric": metric, "size": size, "value": value}


def _compare_sizes(results: Results) -> Iterator[Record]:
    """Medians of areas and aspects by label, and p of their tests against real ones."""
    sizes = {part: list_sizes(floors) for part, floors in results.objects["floors"].items()}
    lit = {part: find_lit_shares(floors) for part, floors in results.objects["floors"].items()}
    real = sizes[REAL]
    for label in sorted(real, key=lambda name: (-len(real[name][0]), name))[:LABELS]:
        for part in (REAL, *SOURCES):
            own = sizes[part].get(label)
            yield {"part": part, "metric": LIT, "label": label, "value": 100 * lit[part][label] if own else None}
            for number, metric in enumerate(("area", "aspect")):
                value = median(own[number]) if own else None
                yield {"part": part, "metric": metric, "label": label, "value": value}
                if part != REAL:
                    p = float(ks_2samp(real[label][number], own[number]).pvalue) if own else None
                    yield {"part": part, "metric": f"p of {metric}s", "label": label, "value": p}
