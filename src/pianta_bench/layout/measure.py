"""Layouts of schools, reconstructed from the maps of a simulated robot."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from pianta.evaluation.coverage import Scores, score_layout
from pianta.evaluation.doors import score_connections
from pianta.evaluation.segmentation import score_labels
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.maps import read_map
from pianta.layout.reconstruct import check_method
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, find_data, list_maps
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.timing import NO_TIME, time_reconstruction

PART = "schools"
SCORES = ("a_fc", "a_bc")
COUNTS = ("free", "walls")
PERCENT = (
    *(f"{score}_{count}" for count in COUNTS for score in SCORES),
    "mean_iou",
    "f1",
    "door_precision",
    "door_recall",
)
FAILED = {**dict.fromkeys(PERCENT, 0.0), "found": 0, "true": None, **NO_TIME}


def measure(
    data: Path | None = None, *, method: str = "thesis", pictures: Path | None = None, track: Track = iter
) -> Results:
    """Forward and backward accuracy of the layouts of data/slam/NAME.png against NAME_gt.xml (Table 3.1a).

    Counted twice: on free cells (`GridMap.free`) as label images, and with the walls, on the whole polygons.
    Precision and recall of doors are those of the pairs of rooms that they join. A map that fails counts as 0.
    method: one of METHODS. pictures: folder for NAME.png, the reconstructed floor.
    track: wraps the names of the maps, to show progress.
    Raises DataError if there are no maps.
    """
    check_method(method)
    folder = find_data(data) / SLAM_FOLDER
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    results = Results({"method": method})
    for name in track(list_maps(folder, SLAM_TRUTH)):
        measure_one = partial(measure_map, folder, name, method=method, pictures=pictures)
        results.measure(PART, name, measure_one, failed=FAILED, method=method)
    return results


def measure_map(folder: Path, name: str, *, method: str, pictures: Path | None) -> Iterator[Figures]:
    """Scores of the layout of one map, %, rooms, and time; then its picture."""
    grid = read_map(folder / f"{name}.png", resolution=SLAM_RESOLUTION)
    truth = read_building_xml(folder / f"{name}{SLAM_TRUTH}", grid=grid)
    yield {"true": len(truth.rooms)}
    floor, time = time_reconstruction(grid, method=method)
    free = score_labels(floor.label_image(grid), truth.label_image(grid), counted=grid.free)
    walls = score_layout([room.polygon for room in floor.rooms], [room.polygon for room in truth.rooms])
    doors = score_connections(floor, truth)
    connected = {"door_precision": 100 * doors.precision, "door_recall": 100 * doors.recall}
    yield {**describe_scores(free, walls), **connected, **time}
    if pictures:
        save_figure(draw_floor(floor, grid), pictures / f"{name}.png")


def describe_scores(free: Scores, walls: Scores) -> Figures:
    """Scores by both ways of counting, then mean IoU and F1 on free cells, %, and numbers of rooms.

    free: scores on free cells. walls: scores with the walls counted, where no room is lost.
    """
    counted = {"free": free, "walls": walls}
    shares = {f"{score}_{count}": getattr(counted[count], score) for count in COUNTS for score in SCORES}
    shares |= {"mean_iou": free.mean_iou, "f1": free.f1}
    return {key: 100 * share for key, share in shares.items()} | {"found": walls.reconstructed, "true": walls.true}
