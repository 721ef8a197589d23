"""Layouts of schools, of the survey and of made worlds, reconstructed from their maps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from pianta.evaluation.coverage import Scores, score_layout
from pianta.evaluation.doors import score_connections
from pianta.evaluation.segmentation import score_labels
from pianta.layout.reconstruct import check_as_printed, check_method
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta_bench.data.folders import LAYOUT_SET_NAMES, check_set, choose_items, find_data
from pianta_bench.data.layout_sets import LAYOUT_SETS, LayoutSet
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.as_printed import AS_PRINTED, choose_method
from pianta_bench.layout.graph_scores import FAILED_GRAPH, count_true, score_graph
from pianta_bench.layout.timing import NO_TIME, time_reconstruction

DEFAULT_SETS = ("schools",)
SCORES = ("a_fc", "a_bc")
COUNTS = ("free", "walls")
PERCENT = (
    *(f"{score}_{count}" for count in COUNTS for score in SCORES),
    "mean_iou",
    "f1",
    "door_precision",
    "door_recall",
)
FAILED = {**dict.fromkeys(PERCENT, 0.0), "found": 0, "true": None, **FAILED_GRAPH, **NO_TIME}


def measure(
    data: Path | None = None,
    *,
    method: str = "thesis",
    sets: Sequence[str] | None = None,
    items: Sequence[str] | None = None,
    maps: bool = False,
    as_printed: bool = False,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Forward and backward accuracy of layouts against the true ones (Table 3.1a), and their doors and edges.

    Counted twice: on free cells (`GridMap.free`) as label images, and with the walls, on the whole polygons.
    Precision and recall of doors are those of the pairs of rooms that they join; F1 of doors is by their positions, F1
    of edges by rooms that match. A map that fails counts as 0.
    method: one of METHODS. sets: of LAYOUT_SET_NAMES, the schools unless given. items: only maps of these names.
    maps: whether doors and edges of each map are printed. as_printed: as of reconstruct. pictures: folder for NAME.png,
    the reconstructed floor, or for SET/NAME.png where several sets are measured. track: wraps the names of the maps,
    to show progress.
    Raises OptionError for the name of no method, set or map, DataError if there are no maps.
    """
    check_method(method)
    if as_printed:
        check_as_printed(method)
        method = AS_PRINTED
    for name in sets or ():
        check_set(name, LAYOUT_SET_NAMES)
    folder = find_data(data)
    chosen = [LAYOUT_SETS[name] for name in dict.fromkeys(sets or DEFAULT_SETS)]
    jobs = choose_items({layout_set: layout_set.list_items(folder) for layout_set in chosen}, items)
    results = Results({"method": method, "sets": [layout_set.name for layout_set in chosen], "maps": maps})
    for _, (layout_set, name) in zip(track([name for _, name in jobs]), jobs, strict=True):
        target = pictures / layout_set.name if pictures and len(chosen) > 1 else pictures
        measure_one = partial(measure_map, folder, name, layout_set=layout_set, method=method, pictures=target)
        results.measure(layout_set.name, name, measure_one, failed=FAILED, method=method)
    return results


def measure_map(
    data: Path, name: str, *, layout_set: LayoutSet, method: str, pictures: Path | None
) -> Iterator[Figures]:
    """Scores of the layout of one map, %, rooms, and time; then its picture."""
    grid, truth = layout_set.read(data, name)
    yield {"true": len(truth.rooms), **count_true(truth)}
    name_of_method, parameters = choose_method(method, layout_set.name)
    floor, time = time_reconstruction(grid, method=name_of_method, parameters=parameters)
    free = score_labels(floor.label_image(grid), truth.label_image(grid), counted=grid.free)
    walls = score_layout([room.polygon for room in floor.rooms], [room.polygon for room in truth.rooms])
    doors = score_connections(floor, truth)
    connected = {"door_precision": 100 * doors.precision, "door_recall": 100 * doors.recall}
    yield {**describe_scores(free, walls), **connected, **score_graph(floor, truth, grid), **time}
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
        save_figure(draw_floor(floor, grid), pictures / f"{name}.png")


def describe_scores(free: Scores, walls: Scores) -> Figures:
    """Scores by both ways of counting, then mean IoU and F1 on free cells, %, and numbers of rooms.

    free: scores on free cells. walls: scores with the walls counted, where no room is lost.
    """
    counted = {"free": free, "walls": walls}
    shares = {f"{score}_{count}": getattr(counted[count], score) for count in COUNTS for score in SCORES}
    shares |= {"mean_iou": free.mean_iou, "f1": free.f1}
    return {key: 100 * share for key, share in shares.items()} | {"found": walls.reconstructed, "true": walls.true}
