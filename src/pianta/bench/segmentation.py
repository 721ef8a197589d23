"""Table 3.1b: rooms on the maps of the survey of room segmentation (Bormann et al., ICRA 2016)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from pianta.bench.data import list_maps
from pianta.bench.rooms import TIME_NOTE, compare_counts, describe_scores, name_columns, time_reconstruction
from pianta.bench.table import BenchTable, Figures, Part, Printed, measure_rows
from pianta.drawing import save_picture
from pianta.evaluation.segmentation import score_labels
from pianta.formats.image import read_grey
from pianta.formats.maps import read_map
from pianta.formats.survey_truth import ROOM_ABOVE_GREY, label_free_rooms

SCORES = ("precision", "recall")
HEADINGS = ("prec.", "recall")
RESOLUTION = 0.05
TRUTH_ENDING = "_gt_segmentation.png"
EMPTY, FURNISHED = "no furniture", "furniture"
IMAGE_ENDINGS = {EMPTY: ".png", FURNISHED: "_furnitures.png"}
PRINTED = tuple(
    Printed(f"thesis, {name}", {EMPTY: empty, FURNISHED: furnished})
    for name, empty, furnished in (
        ("our method", ((90.1, 6.3), (90.0, 4.1)), ((94.0, 2.2), (89.5, 6.2))),
        ("morph", ((88.5, 9.2), (98.1, 2.4)), ((90.5, 8.1), (84.6, 7.2))),
        ("distance", ((88.4, 9.3), (96.9, 2.8)), ((88.4, 8.5), (76.1, 12.3))),
        ("Voronoi", ((94.8, 5.0), (95.0, 2.3)), ((94.5, 5.1), (86.6, 5.2))),
        ("feature-based", ((90.2, 8.0), (89.2, 11.8)), ((87.0, 14.5), (85.5, 7.2))),
    )
)
COUNT_NOTE = f"What counts: free: the pixels of the truth image above grey {ROOM_ABOVE_GREY}; walls: all pixels."


def measure_segmentation(
    data: Path,
    *,
    method: str = "thesis",
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BenchTable:
    """Precision and recall of the rooms of data/survey/NAME.png and NAME_furnitures.png (Table 3.1b).

    The truth of both is NAME_gt_segmentation.png. Counted twice: on its free cells, which are the pixels above grey
    250 before small patches are dropped, and on all pixels, where what a room covers of the walls counts against it.

    method: one of METHODS. pictures: an existing folder for NAME.png and NAME_furnitures.png, the floors found.
    track: wraps the names of the maps, to show progress.
    Raises DataError when there are no maps.
    """
    columns = name_columns(SCORES, HEADINGS)
    names = list_maps(data / "survey", TRUTH_ENDING)
    measure = partial(_measure_map, folder=data / "survey", method=method, pictures=pictures)
    parts = tuple(
        Part(part, measure_rows(track(names), partial(measure, ending=ending), columns=columns))
        for part, ending in IMAGE_ENDINGS.items()
    )
    return BenchTable(
        bench="segmentation",
        title="Table 3.1b, accuracy of room segmentation",
        method=method,
        columns=columns,
        parts=parts,
        scores=HEADINGS,
        compared=compare_counts(SCORES),
        printed=PRINTED,
        notes=(COUNT_NOTE, TIME_NOTE),
    )


def _measure_map(name: str, *, ending: str, folder: Path, method: str, pictures: Path | None) -> Iterator[Figures]:
    grey, _ = read_grey(folder / f"{name}{TRUTH_ENDING}")
    truth = label_free_rooms(grey)
    yield {"true": int(truth.max())}
    grid = read_map(folder / f"{name}{ending}", resolution=RESOLUTION)
    floor, time = time_reconstruction(grid, method=method)
    labels = floor.label_image(grid)
    free, walls = score_labels(labels, truth, counted=grey > ROOM_ABOVE_GREY), score_labels(labels, truth)
    yield {**describe_scores(free, walls, SCORES), **time}
    if pictures:
        save_picture(floor, grid, pictures / f"{name}{ending}")
