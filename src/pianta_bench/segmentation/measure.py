"""Table 3.1b and more: rooms on the maps of the survey (Bormann et al., ICRA 2016) and on four other sets of maps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.coverage import Scores
from pianta.evaluation.persistence import score_persistence
from pianta.evaluation.segmentation import drop_small_rooms, keep_rooms_at, label_rest, score_labels
from pianta.floor import Floor
from pianta.layout.reconstruct import METHODS
from pianta.layout.room_ids import keep_room_ids
from pianta_bench.data.map_sets import MapSet, TrueMap, choose_sets
from pianta_bench.harness.table import BenchTable, Column, Figures, Part, Printed, Row, measure_row
from pianta_bench.layout.scores import TIME_NOTE, time_reconstruction
from pianta_bench.segmentation.figures import save_comparison

SCORES = {"precision": "prec.", "recall": "recall", "a_fc": "A_FC", "mean_iou": "mean\nIoU", "f1": "\nF1"}
# Of the two counts that stand beside the main one in the JSON file.
FREE_SCORES, REST_SCORES = ("precision", "recall", "a_fc", "mean_iou", "f1"), ("precision", "recall")
COLUMNS = (
    *(Column(key, heading, "%", failed=0.0) for key, heading in SCORES.items()),
    Column("found", "rooms\nfound", "rooms", failed=0),
    Column("true", "\ntrue", "rooms"),
    Column("matched", "", "rooms", failed=0, printed=False),
    Column("seconds", "time\ns", "s", digits=2),
    Column("transforms", "time\nDT", "exact distance transforms of the same map"),
    *(Column(f"{key}_free", "", "%", failed=0.0, printed=False) for key in FREE_SCORES),
    *(Column(f"{key}_rest", "", "%", failed=0.0, printed=False) for key in REST_SCORES),
    *(Column(key, "", "rooms", printed=False) for key in ("rooms_before", "still_there", "kept_id")),
)
RATIOS = {
    "found_per_true": ("found", "true"),
    "still_there": ("still_there", "rooms_before"),
    "kept_id": ("kept_id", "still_there"),
}
PRINTED = tuple(
    Printed(f"thesis, {name}", {"survey": empty, "furniture": furnished})
    for name, empty, furnished in (
        ("our method", ((90.1, 6.3), (90.0, 4.1)), ((94.0, 2.2), (89.5, 6.2))),
        ("morph", ((88.5, 9.2), (98.1, 2.4)), ((90.5, 8.1), (84.6, 7.2))),
        ("distance", ((88.4, 9.3), (96.9, 2.8)), ((88.4, 8.5), (76.1, 12.3))),
        ("Voronoi", ((94.8, 5.0), (95.0, 2.3)), ((94.5, 5.1), (86.6, 5.2))),
        ("feature-based", ((90.2, 8.0), (89.2, 11.8)), ((87.0, 14.5), (85.5, 7.2))),
    )
)
COUNT_NOTE = (
    "What counts: all pixels of a room, floor under furniture too; rooms of up to 0.25 m² on neither side. schools and "
    "doors: free cells only; doors: only rooms at the known ones, which lie behind one closed door each."
)
REST_NOTE = (
    "Beside the thesis: on free cells, where those in no found room are one more room, as Table 3.1b was counted. "
    "Its rooms begin at 1 m²."
)


def measure_segmentation(
    data: Path,
    *,
    methods: Sequence[str] = METHODS,
    sets: Sequence[str] = (),
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BenchTable:
    """Scores of the rooms that methods find on the survey, real clutter, closed doors, schools, and growing maps.

    Three counts. The main one takes a room as a space: each pixel of it counts, and rooms of up to 0.25 m² are dropped
    on both sides; where the truth includes walls (schools), or only knows free cells behind closed doors (doors), both
    sides are cut to free cells first. _free: all rooms on free cells alone. _rest: like _free, with the free cells in
    no found room as one more, which is the count of Table 3.1b. Where maps grow, the ids of the floor before are kept,
    and the rooms and ids that lasted are counted.

    methods: of METHODS. sets: of SET_NAMES, all that are in the data when empty.
    pictures: an existing folder for METHOD/SET/NAME.png, truth beside result.
    track: wraps what is measured, to show progress.
    Raises OptionError for the name of no set, DataError when there are no maps.
    """
    chosen = choose_sets(sets, data)
    rows = _measure_sets(chosen, data, methods=methods, pictures=pictures, track=track)
    in_thesis = any(mapset.name in PRINTED[0].figures for mapset in chosen)
    return BenchTable(
        bench="segmentation",
        title="Table 3.1b and more, accuracy of room segmentation",
        methods=tuple(methods),
        columns=COLUMNS,
        parts=tuple(Part(mapset.name, tuple(part), method) for (mapset, method), part in rows.items()),
        scores=("prec.", "recall"),
        compared={"rest a room": ("precision_rest", "recall_rest")},
        printed=PRINTED,
        notes=(COUNT_NOTE, *([REST_NOTE] if in_thesis else []), TIME_NOTE),
        summarised=tuple(SCORES),
        ratios=RATIOS,
    )


def _measure_sets(
    sets: Mapping[MapSet, Sequence[str]],
    data: Path,
    *,
    methods: Sequence[str],
    pictures: Path | None,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> dict[tuple[MapSet, str], list[Row]]:
    """Rows of the maps by set and method; all methods see a map before the next, so that it is read once."""
    jobs = [(mapset, method, item) for mapset, items in sets.items() for item, method in product(items, methods)]
    read = lru_cache(maxsize=1)(lambda mapset, item: mapset.read(data / mapset.folder, item))
    rows: dict[tuple[MapSet, str], list[Row]] = {(mapset, method): [] for mapset in sets for method in methods}
    earlier: dict[str, list[Floor]] = {method: [] for method in methods}
    for _, (mapset, method, item) in zip(track([f"{item}, {method}" for _, method, item in jobs]), jobs, strict=True):
        folder = pictures / method / mapset.name if pictures else None
        before = earlier[method] if mapset.grows else None
        measure = partial(_measure_map, mapset=mapset, method=method, read=read, earlier=before, pictures=folder)
        rows[mapset, method].append(measure_row(item, measure, columns=COLUMNS))
    return rows


def _measure_map(
    item: str,
    *,
    mapset: MapSet,
    method: str,
    read: Callable[[MapSet, str], TrueMap],
    earlier: list[Floor] | None,
    pictures: Path | None,
) -> Iterator[Figures]:
    known = read(mapset, item)
    truth = _cut_spaces(known.spaces, known, mapset)
    yield {"true": len(np.unique(truth[truth > 0]))}
    floor, time = time_reconstruction(known.grid, method=method)
    labels = floor.label_image(known.grid).astype(np.int32)
    found = _cut_spaces(labels, known, mapset)
    if mapset.in_places:
        labels, found = keep_rooms_at(labels, truth), keep_rooms_at(found, truth)
    yield {**_describe(score_labels(found, truth)), **_describe_free_counts(labels, known, mapset), **time}
    if earlier is not None:
        earlier.append(keep_room_ids(floor, earlier[-1]) if earlier else floor)
        yield _describe_persistence(earlier[-2:])
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
        save_comparison(found, truth, known.grid, pictures / f"{item}.png")


def _cut_spaces(labels: NDArray[np.int32], known: TrueMap, mapset: MapSet) -> NDArray[np.int32]:
    counted = np.where(known.free, labels, 0) if mapset.free_only else labels
    return drop_small_rooms(counted, resolution=known.grid.resolution)


def _describe(scores: Scores) -> Figures:
    shares = {key: 100 * getattr(scores, key) for key in SCORES}
    matched = round(scores.f1 * (scores.found + scores.true) / 2)
    return shares | {"found": scores.found, "true": scores.true, "matched": matched}


def _describe_free_counts(labels: NDArray[np.int32], known: TrueMap, mapset: MapSet) -> Figures:
    """The scores on free cells, without and with what is in no found room as one more room."""
    free = score_labels(labels, known.rooms, counted=known.free)
    figures = {f"{key}_free": 100 * getattr(free, key) for key in FREE_SCORES}
    if mapset.in_places:  # most free cells are in rooms that nobody knows
        return figures | dict.fromkeys((f"{key}_rest" for key in REST_SCORES), None)
    rest = score_labels(label_rest(labels, counted=known.free), known.rooms, counted=known.free)
    return figures | {f"{key}_rest": 100 * getattr(rest, key) for key in REST_SCORES}


def _describe_persistence(floors: Sequence[Floor]) -> Figures:
    """What became of the rooms of the step before the last."""
    lasting = score_persistence(floors)
    return {"rooms_before": lasting.rooms, "still_there": lasting.still_there, "kept_id": lasting.kept_id}
