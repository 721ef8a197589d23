"""Table 3.1a: layouts of schools, reconstructed from the maps of a simulated robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from pianta.evaluation.connectivity import score_connections
from pianta.evaluation.coverage import score_layout
from pianta.evaluation.segmentation import score_labels
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.maps import read_map
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, list_maps
from pianta_bench.harness.table import BenchTable, Column, Figures, Part, Printed, measure_rows
from pianta_bench.layout.scores import TIME_NOTE, compare_counts, describe_scores, name_columns, time_reconstruction

SCORES = ("a_fc", "a_bc")
HEADINGS = ("A_FC", "A_BC")
PRINTED = (Printed("thesis, our method", {"schools": ((87.6, 5.7), (87.8, 4.5))}),)
DOOR_COLUMNS = (
    Column("door_precision", "doors\nP", "%", failed=0.0),
    Column("door_recall", "doors\nR", "%", failed=0.0),
)
DOOR_NOTE = "doors: pairs of true rooms that found doors join, against those that true doors join."
COUNT_NOTE = (
    "What counts: free: the cells that are free in the map; walls: the whole polygons, walls between rooms too."
)


def measure_layout(
    data: Path,
    *,
    method: str = "thesis",
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BenchTable:
    """Forward and backward accuracy of the layouts of data/slam/NAME.png against NAME_gt.xml (Table 3.1a).

    Counted twice: on free cells (`GridMap.free`) as label images, and with the walls, on the whole polygons.
    Precision and recall of doors are those of the pairs of rooms that they join.

    method: one of METHODS. pictures: an existing folder for NAME.png, the floor found.
    track: wraps the names of the maps, to show progress.
    Raises DataError when there are no maps.
    """
    *scores, found, true, seconds, transforms = name_columns(SCORES, HEADINGS)
    columns = (*scores, *DOOR_COLUMNS, found, true, seconds, transforms)
    folder = data / SLAM_FOLDER
    measure = partial(_measure_map, folder=folder, method=method, pictures=pictures)
    rows = measure_rows(track(list_maps(folder, SLAM_TRUTH)), measure, columns=columns)
    return BenchTable(
        bench="layout",
        title="Table 3.1a, accuracy of layout reconstruction",
        methods=(method,),
        columns=columns,
        parts=(Part("schools", rows, method),),
        scores=HEADINGS,
        compared=compare_counts(SCORES),
        printed=PRINTED,
        notes=(COUNT_NOTE, DOOR_NOTE, TIME_NOTE),
    )


def _measure_map(name: str, *, folder: Path, method: str, pictures: Path | None) -> Iterator[Figures]:
    grid = read_map(folder / f"{name}.png", resolution=SLAM_RESOLUTION)
    truth = read_building_xml(folder / f"{name}{SLAM_TRUTH}", grid=grid)
    yield {"true": len(truth.rooms)}
    floor, time = time_reconstruction(grid, method=method)
    free = score_labels(floor.label_image(grid), truth.label_image(grid), counted=grid.free)
    walls = score_layout([room.polygon for room in floor.rooms], [room.polygon for room in truth.rooms])
    doors = score_connections(floor, truth)
    connected = {"door_precision": 100 * doors.precision, "door_recall": 100 * doors.recall}
    yield {**describe_scores(free, walls, SCORES), **connected, **time}
    if pictures:
        save_figure(draw_floor(floor, grid), pictures / f"{name}.png")
