"""Rooms on the maps of the survey (Bormann et al., ICRA 2016) and on five other sets of maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.coverage import Scores, score_layout
from pianta.evaluation.persistence import score_persistence
from pianta.evaluation.segmentation import drop_small_rooms, keep_rooms_at, label_rest, score_labels
from pianta.floor import Floor
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.layout.reconstruct import METHODS, check_method
from pianta.layout.room_ids import keep_room_ids
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import MapSet, TrueMap, choose_sets
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.as_printed import AS_PRINTED, choose_method
from pianta_bench.layout.timing import NO_TIME, time_reconstruction
from pianta_bench.segmentation.counts import FAILED_COUNTS, count_map, count_true_rooms
from pianta_bench.segmentation.figures import save_comparison

SCORES = ("precision", "recall", "a_fc", "mean_iou", "f1")
# Scores of the counts that are only in the JSON file and in the comparison with the thesis, by the ending of a metric.
COUNT_SCORES = {
    "free": SCORES,
    "rest": ("precision", "recall"),
    "polygons": SCORES,
    "drawn_free": SCORES,
}
# Those of the layouts that were drawn of the survey.
DRAWN_COUNTS = ("polygons", "drawn_free")
DRAWN_METRICS = tuple(f"{score}_{count}" for count in DRAWN_COUNTS for score in COUNT_SCORES[count])
PERCENT = (*SCORES, *(f"{score}_{count}" for count, scores in COUNT_SCORES.items() for score in scores))
LASTING = ("rooms_before", "still_there", "kept_id")
FAILED = {
    **dict.fromkeys(PERCENT, 0.0),
    **dict.fromkeys(("found", "matched"), 0),
    **dict.fromkeys(("true", *LASTING)),
    **NO_TIME,
}


def measure(
    data: Path | None = None,
    *,
    methods: Sequence[str] | None = None,
    sets: Sequence[str] | None = None,
    maps: bool = False,
    count: bool = False,
    as_printed: bool = False,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Scores of reconstructed rooms on the survey, real clutter, homes, closed doors, schools, and growing maps.

    Several counts. The main one counts each pixel of a room, and drops rooms of up to 0.25 m² on both sides; where the
    truth includes walls (schools), or only has free cells (vacuum) or those behind closed doors (doors), both sides are
    cut to free cells first. _free: all rooms on free cells alone. _rest: like _free, with the free cells in
    no room as one more. _polygons: the whole polygons, against those that the thesis' author drew of the survey, and
    _drawn_free: these two on free cells alone. Where maps grow, rooms keep the ids of the floor before, and the
    persisting rooms and ids are counted.

    methods: of METHODS, all unless given. sets: of SET_NAMES, all that are in the data unless given.
    maps: whether the figures of each map are printed. count: whether right, split and merged rooms and wrong doors are
    counted, where all true rooms are known. as_printed: whether AS_PRINTED is measured too.
    pictures: folder for METHOD/SET/NAME.png. track: wraps what is measured, to show progress.
    Raises OptionError for the name of no method or set, DataError if there are no maps.
    """
    methods = tuple(dict.fromkeys(methods or METHODS))
    for method in methods:
        check_method(method)
    methods += (AS_PRINTED,) * as_printed
    folder = find_data(data)
    chosen = choose_sets(sets or (), folder)
    results = Results({"methods": methods, "sets": [mapset.name for mapset in chosen], "maps": maps, "count": count})
    # All methods run on a map before the next map, so that it is read once.
    jobs = [(mapset, item, method) for mapset, items in chosen.items() for item, method in product(items, methods)]
    read = lru_cache(maxsize=1)(lambda mapset, item: mapset.read(folder / mapset.folder, item))
    earlier: dict[str, list[Floor]] = {method: [] for method in methods}
    tracked = track([f"{item}, {method}" for _, item, method in jobs])
    for _, (mapset, item, method) in zip(tracked, jobs, strict=True):
        measure_one = partial(
            measure_map,
            item,
            mapset=mapset,
            method=method,
            read=read,
            earlier=earlier[method] if mapset.grows else None,
            count=count and not mapset.in_places,
            pictures=pictures / method / mapset.name if pictures else None,
        )
        failed = FAILED | FAILED_COUNTS if count and not mapset.in_places else FAILED
        results.measure(mapset.name, item, measure_one, failed=failed, method=method)
    return results


def measure_map(
    item: str,
    *,
    mapset: MapSet,
    method: str,
    read: Callable[[MapSet, str], TrueMap],
    earlier: list[Floor] | None,
    count: bool,
    pictures: Path | None,
) -> Iterator[Figures]:
    """Scores of the rooms of one map, %, rooms, and time; then counts, the persistence of rooms, and its picture."""
    true_map = read(mapset, item)
    truth = cut_spaces(true_map.spaces, true_map, mapset)
    yield {"true": len(np.unique(truth[truth > 0])), **(count_true_rooms(truth, true_map) if count else {})}
    if true_map.layout is None:
        yield dict.fromkeys(DRAWN_METRICS)
    name, parameters = choose_method(method, mapset.name)
    floor, time = time_reconstruction(true_map.grid, method=name, parameters=parameters)
    spaces = find_spaces(floor, true_map, mapset)
    yield {**score_floor(floor, true_map, mapset), **time}
    if count:
        yield count_map(floor, spaces, truth, true_map)
    if earlier is not None:
        earlier.append(keep_room_ids(floor, earlier[-1], earlier=earlier[-2::-1]) if earlier else floor)
        yield _describe_persistence(earlier[-2:])
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
        save_comparison(spaces, truth, true_map.grid, pictures / f"{item}.png")


def score_floor(floor: Floor, true_map: TrueMap, mapset: MapSet) -> Figures:
    """The scores of a floor by all counts, %, and numbers of rooms."""
    truth = cut_spaces(true_map.spaces, true_map, mapset)
    labels = floor.label_image(true_map.grid).astype(np.int32)
    if mapset.in_places:
        labels = keep_rooms_at(labels, truth)
    scores = score_labels(find_spaces(floor, true_map, mapset), truth)
    return {**_describe(scores), **_describe_free_counts(labels, true_map, mapset), **_describe_drawn(floor, true_map)}


def find_spaces(floor: Floor, true_map: TrueMap, mapset: MapSet) -> NDArray[np.int32]:
    """The rooms of a floor that count, shape (H, W), by the main count."""
    spaces = cut_spaces(floor.label_image(true_map.grid).astype(np.int32), true_map, mapset)
    if not mapset.in_places:
        return spaces
    return keep_rooms_at(spaces, cut_spaces(true_map.spaces, true_map, mapset))


def cut_spaces(labels: NDArray[np.int32], true_map: TrueMap, mapset: MapSet) -> NDArray[np.int32]:
    """The rooms that count, shape (H, W): on free cells where the set says so, and without the smallest."""
    counted = np.where(true_map.free, labels, 0) if mapset.free_only else labels
    return drop_small_rooms(counted, resolution=true_map.grid.resolution)


def _describe(scores: Scores) -> Figures:
    shares = {key: 100 * getattr(scores, key) for key in SCORES}
    matched = round(scores.f1 * (scores.reconstructed + scores.true) / 2)
    return shares | {"found": scores.reconstructed, "true": scores.true, "matched": matched}


def _describe_free_counts(labels: NDArray[np.int32], true_map: TrueMap, mapset: MapSet) -> Figures:
    """The scores on free cells, without and with the cells in no room as one more room."""
    free = score_labels(labels, true_map.rooms, counted=true_map.free)
    figures = _name_scores(free, "free")
    if mapset.in_places:  # most free cells are in rooms that are not in the truth
        return figures | dict.fromkeys((f"{key}_rest" for key in COUNT_SCORES["rest"]), None)
    rest = score_labels(label_rest(labels, counted=true_map.free), true_map.rooms, counted=true_map.free)
    return figures | _name_scores(rest, "rest")


def _describe_drawn(floor: Floor, true_map: TrueMap) -> Figures:
    """The scores against the drawn layout of the map: whole polygons, and free cells alone; None without a layout."""
    if true_map.layout is None:
        return dict.fromkeys(DRAWN_METRICS)
    layout = read_building_xml(true_map.layout, grid=true_map.grid)
    polygons = score_layout([room.polygon for room in floor], [room.polygon for room in layout])
    labels = (each.label_image(true_map.grid) for each in (floor, layout))
    free = score_labels(*labels, counted=true_map.grid.free)
    return _name_scores(polygons, "polygons") | _name_scores(free, "drawn_free")


def _name_scores(scores: Scores, count: str) -> dict[str, float | None]:
    return {f"{key}_{count}": 100 * getattr(scores, key) for key in COUNT_SCORES[count]}


def _describe_persistence(floors: Sequence[Floor]) -> Figures:
    """How many rooms of the step before the last persist, and how many keep their id."""
    lasting = score_persistence(floors)
    return {"rooms_before": lasting.rooms, "still_there": lasting.persisting, "kept_id": lasting.same_id}
