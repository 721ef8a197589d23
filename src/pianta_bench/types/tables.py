"""A TypesBench as people read it, in a terminal of 80 columns, and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import isfinite
from pathlib import Path
from statistics import fmean, stdev

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from pianta import __version__
from pianta.io._files import atomic_file
from pianta_bench.harness.comparison import tell_faults
from pianta_bench.harness.old_report import show_figure, start_table
from pianta_bench.types import published as printed
from pianta_bench.types.classifiers import ALGORITHMS, CrossValidation, Transfer
from pianta_bench.types.clusters import EPSILON, MIN_POINTS, RoomClusters
from pianta_bench.types.measure import BY_AREA, BY_NAME, OF_THESIS, TypesBench, bounds_of_sizes, characterise
from pianta_bench.types.room_sets import GENERAL_LABELS, RoomSet

NOTES = (
    "S, M and B are told by a label's name (docs/building-types.md), or by area halfway between those of Table 4.2.",
    "The thesis' rooms are others: 1300 of houses, 1400 of schools, 2600 of offices; its union has all three.",
)
Columns = Sequence[tuple[str, str, float, int]]
# Of clusters: heading, key of the figures, factor, digits.
CLUSTER_COLUMNS: Columns = (
    ("clus-\nters", "clusters", 1, 0),
    ("out-\nliers", "outliers", 100, 1),
    ("C of\nthem", "corridors_in_outliers", 100, 1),
    ("homo-\ngeneity", "homogeneity", 1, 2),
    ("complete-\nness", "completeness", 1, 2),
)
RULE_COLUMNS: Columns = (
    ("homog.\nR/C", "homogeneity_r_c", 1, 2),
    ("without\noutliers", "homogeneity_r_c_clustered", 1, 2),
    ("rule, in\nclusters", "accuracy_clustered", 100, 1),
    ("outliers\ntogether", "accuracy_outliers_together", 100, 1),
    ("outliers\nmajority", "accuracy_outliers_majority", 100, 1),
    ("all ma-\njority", "always_majority", 100, 1),
    ("4+\ndoors", "four_doorways", 100, 1),
)


def show_types_bench(bench: TypesBench) -> Group:
    """The tables of chapter 4, ours beside printed ones, and what a reader must know about them."""
    parts = (
        _show_characteristics(bench.sets),
        _show_accuracies(bench),
        _show_confusions(bench.validations[BY_NAME]),
        _show_transfers(bench),
        _show_clusters(bench.clusters),
    )
    lines: list[RenderableType] = [Text(f"Building types (chapter 4), seed {bench.seed}", style="bold"), Text()]
    for part in chain.from_iterable(parts):
        lines += [part, Text()] if isinstance(part, Table) else [part]
    faults = chain.from_iterable(tell_faults(f"{kind}s", rows) for kind, rows in bench.failed.items())
    return Group(*lines, *faults, *map(Text, NOTES))


def _show_characteristics(sets: Sequence[RoomSet]) -> Iterator[RenderableType]:
    yield Text("Rooms of each label: mean and standard deviation (Table 4.2); thesis in ( )")
    for rooms in sets:
        headings = ("rooms\n%", "area\nm²", "sd\n", "doorways\n", "sd\n", "axes ratio\n", "sd\n")
        table = start_table(f"{rooms.name}\n{len(rooms.labels)} rooms", *headings)
        for row in characterise(rooms):
            ours = (100 * row.share, *chain.from_iterable(zip(row.means, row.sds, strict=True)))
            theirs = printed.CHARACTERISTICS.get(rooms.name, {}).get(row.label, ())
            table.add_row(row.label, *(_beside(*pair) for pair in zip(ours, _pad(theirs, 7), strict=True)))
        yield table


def _show_accuracies(bench: TypesBench) -> Iterator[RenderableType]:
    """A row a set, features and division; means of the folds of each algorithm."""
    captions = {
        BY_NAME: "Accuracy, %, 10-fold cross-validation (Fig. 4.3); sd over algorithms, over folds",
        BY_AREA: "The same where area alone tells S, M and B",
    }
    for sizes, validations in bench.validations.items():
        yield Text(captions[sizes])
        table = _start_table(3, "set", "features", "folds of", *ALGORITHMS, "mean", "sd\nalg.", "sd\nfolds", "thesis")
        for each in validations:
            of_thesis = (each.representation, each.divided) == OF_THESIS
            theirs = printed.ACCURACIES.get(each.rooms) if of_thesis else None
            means = [fmean(folds) for folds in each.accuracies.values()]
            shares = (*means, each.mean, each.sd_of_algorithms, each.sd_of_folds)
            figures = [show_figure(100 * share, 1) for share in shares]
            beside = f"{theirs[0]}±{theirs[1]}" if theirs else ""
            table.add_row(each.rooms, each.representation, each.divided, *figures, beside)
        yield table


def _show_confusions(validations: Iterable[CrossValidation]) -> Iterator[RenderableType]:
    yield Text("True labels (rows) and given, %, mean over algorithms (Table 4.3), thesis in ( )")
    for validation in validations:
        if (validation.representation, validation.divided) != OF_THESIS:
            continue
        table = start_table(validation.rooms, *GENERAL_LABELS, "TP", "FP")
        theirs = printed.CONFUSIONS.get(validation.rooms, ((),) * len(GENERAL_LABELS))
        for row, label in enumerate(GENERAL_LABELS):
            right = 100 * validation.confusion[row, row]
            cells = (100 * validation.confusion[row]).tolist()
            beside = [_beside(*pair) for pair in zip(cells, _pad(theirs[row], len(cells)), strict=True)]
            table.add_row(label, *beside, show_figure(right, 1), show_figure(100 - right, 1))
        misled = (100 * validation.misled).tolist()
        wrong = _pad(printed.MISLED.get(validation.rooms, ()), len(misled))
        right_ones = [100 - value if value is not None else None for value in wrong]
        table.add_section()
        table.add_row("TN", *(_beside(100 - ours, other) for ours, other in zip(misled, right_ones, strict=True)))
        table.add_row("FN", *(_beside(*pair) for pair in zip(misled, wrong, strict=True)))
        yield table


def _show_transfers(bench: TypesBench) -> Iterator[RenderableType]:
    if not bench.transfers[BY_NAME]:
        return
    captions = {
        BY_NAME: "Accuracy, %, learnt on a type and tested on another (Table 4.4); sd over 10 learnings",
        BY_AREA: "The same where area alone tells S, M and B",
    }
    for sizes, transfers in bench.transfers.items():
        yield Text(captions[sizes])
        table = _start_table(2, "learnt, tested", "features", *ALGORITHMS, "mean", "thesis")
        for each in transfers:
            theirs = printed.TRANSFERS.get((each.train, each.test)) if each.representation == OF_THESIS[0] else None
            runs = (f"{100 * fmean(runs):.1f}±{100 * stdev(runs):.1f}" for runs in each.accuracies.values())
            beside = f"{theirs[-1]}" if theirs else ""
            table.add_row(
                f"{each.train}, {each.test}", each.representation, *runs, show_figure(100 * _mean_of(each), 1), beside
            )
        yield table
    pairs = (f"{train} to {test} {means[-1]}" for (train, test), means in printed.TRANSFERS.items())
    yield Text(f"The thesis' means: {', '.join(pairs)}.\n")


def _show_clusters(clusters: Sequence[RoomClusters]) -> Iterator[RenderableType]:
    yield Text(f"DBSCAN, MinPts {MIN_POINTS}, ε {EPSILON:g} (Fig. 4.4); % of rooms, homogeneity over L_general")
    table = _start_table(2, "set", "features", *(heading for heading, *_ in CLUSTER_COLUMNS), "bend", "below\nε, %")
    for each in clusters:
        below = 100 * float((each.distances <= EPSILON).mean())
        table.add_row(*_show_figures(each, CLUSTER_COLUMNS), show_figure(each.bend, 1), show_figure(below, 1))
    theirs = printed.CLUSTERS, str(printed.OUTLIERS), str(printed.CORRIDORS_IN_OUTLIERS)
    table.add_row("thesis", "?", *theirs, *[""] * 4)
    yield table
    yield Text("ROOM or CORRIDOR: homogeneity, accuracy of the naive rule in % (section 4.3.1)")
    table = _start_table(2, "set", "features", *(heading for heading, *_ in RULE_COLUMNS))
    for each in clusters:
        table.add_row(*_show_figures(each, RULE_COLUMNS))
    table.add_row("thesis", "?", str(printed.HOMOGENEITY_R_C), "", str(printed.RULE_ACCURACY), *[""] * 4)
    yield table


def _start_table(names: int, *headings: str) -> Table:
    """A table whose first columns are names."""
    table = start_table(*headings)
    for column in table.columns[:names]:
        column.justify = "left"
    return table


def _show_figures(clusters: RoomClusters, columns: Columns) -> list[str]:
    figures = [(clusters.figures[key], factor, digits) for _, key, factor, digits in columns]
    shown = [show_figure(None if value is None else value * factor, digits) for value, factor, digits in figures]
    return [clusters.rooms, clusters.scale, *shown]


def _mean_of(measured: Transfer) -> float:
    return fmean(map(fmean, measured.accuracies.values()))


def _beside(ours: float | None, theirs: float | None) -> str:
    return show_figure(ours, 1) + (f" ({show_figure(theirs, 1)})" if theirs is not None else "")


def _pad(values: Sequence[float], length: int) -> list[float | None]:
    return [*values, *[None] * (length - len(values))]


def save_types_bench(bench: TypesBench, path: str | Path) -> None:
    """Write every figure as JSON, shares from 0 to 1, areas in m²; raises PiantaError when it cannot be written."""
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(_as_json(bench), indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _as_json(bench: TypesBench) -> dict[str, object]:
    return {
        "pianta": __version__,
        "bench": "types",
        "seed": bench.seed,
        "sets": [_set_as_json(rooms) for rooms in bench.sets],
        "bounds_by_area": {rooms.name: bounds_of_sizes(rooms.name) for rooms in bench.sets if "+" not in rooms.name},
        "classifiers": [
            _validation_as_json(each, sizes) for sizes, every in bench.validations.items() for each in every
        ],
        "transfers": [
            {"train": each.train, "test": each.test, "features": each.representation, "sizes": sizes}
            | {"accuracies": each.accuracies, "mean": _mean_of(each)}
            for sizes, every in bench.transfers.items()
            for each in every
        ],
        "clusters": [
            {"set": each.rooms, "features": each.scale, "min_points": MIN_POINTS, "epsilon": EPSILON}
            | {"bend": each.bend, **each.figures}
            for each in bench.clusters
        ],
        "failures": [
            {"type": kind, "item": row.item, "failure": row.failure}
            for kind, rows in bench.failed.items()
            for row in rows
        ],
        "printed": {
            "accuracies_percent": dict(printed.ACCURACIES),
            "confusions_percent": dict(printed.CONFUSIONS),
            "transfers_percent": {f"{train}, {test}": row for (train, test), row in printed.TRANSFERS.items()},
            "characteristics": dict(printed.CHARACTERISTICS),
        },
        "notes": NOTES,
    }


def _set_as_json(rooms: RoomSet) -> dict[str, object]:
    return {
        "name": rooms.name,
        "rooms": len(rooms.labels),
        "buildings": len(set(rooms.buildings.tolist())),
        "labels": [vars(row) for row in characterise(rooms)],
        "mapping": {
            label: {name: count for (general, name), count in sorted(rooms.names.items()) if general == label}
            for label in GENERAL_LABELS
        },
    }


def _validation_as_json(each: CrossValidation, sizes: str) -> dict[str, object]:
    known = each.confusion.tolist()
    return {
        "set": each.rooms,
        "features": each.representation,
        "folds_of": each.divided,
        "sizes": sizes,
        "accuracies": each.accuracies,
        "mean": each.mean,
        "sd_of_algorithms": each.sd_of_algorithms,
        "sd_of_folds": each.sd_of_folds,
        "confusion": [[share if isfinite(share) else None for share in row] for row in known],
        "misled": [share if isfinite(share) else None for share in each.misled.tolist()],
    }
