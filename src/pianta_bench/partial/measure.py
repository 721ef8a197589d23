"""Rooms that were seen in part, predicted as a whole (section 8.2), against the true ones and two simple guesses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import fmean

import cv2
import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import rotate

from pianta.errors import PiantaError
from pianta.floor import Floor, Room, cells_of_polygon
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.layout.partial.scene import find_main_direction
from pianta.layout.reconstruct import DEFAULT_METHOD, reconstruct
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable, Items
from pianta_bench.harness.table import Figures, Row
from pianta_bench.partial.maps import SIMULATED, SIMULATED_COUNT, PartialMap, list_real_maps, simulate_world

# The share of a true room from which on predictions have to hold, and that was not seen of a room truly seen in part.
A_THIRD, UNSEEN = 1 / 3, 0.1
# Unknown space thinner than this is in walls, m; less than this share of a true room tells nothing of it.
WALL, TRACE = 1.0, 0.02
GUESSES = ("seen", "rectangle", "predicted")
BINS = ((0.0, 0.4), (0.4, 0.6), (0.6, 0.75), (0.75, 1.0))
NOTES = (
    "seen: what was seen of a room, as it is; rectangle: the one around that, along the walls nearby.",
    (
        f"A room is truly partial when more than {100 * UNSEEN:.0f} % of the true room is unknown, but for what is "
        f"thinner than {WALL:g} m. Each room found is judged by the true one that it overlaps most."
    ),
    "freiburg79 r: true rooms are those that its last map shows, which is left out itself.",
)


@dataclass(frozen=True)
class JudgedRoom:
    """A room that is found partial, or is so.

    seen_share: of the true room that is in the room found. unseen_share: of the true room that nobody has seen.
    seen, rectangle, predicted: IoU of each guess with the true room. confidence: None where nothing is predicted.
    """

    item: str
    room: int
    found_partial: bool
    seen_share: float
    unseen_share: float
    seen: float
    rectangle: float
    predicted: float
    confidence: float | None

    @property
    def truly_partial(self) -> bool:
        """Whether part of the true room was not seen."""
        return self.unseen_share > UNSEEN


@dataclass(frozen=True)
class PartialBench:
    """What was measured. rooms, failed: by run; what failed, and why."""

    method: str
    rooms: Mapping[str, Sequence[JudgedRoom]]
    failed: Mapping[str, Sequence[Row]]

    @property
    def items(self) -> Items:
        """Every figure of every room, and the maps that failed, by run."""
        return {run: [*map(_row, rooms), *self.failed.get(run, ())] for run, rooms in self.rooms.items()}


def measure_partial(
    data: Path,
    *,
    method: str = DEFAULT_METHOD,
    simulated: int = SIMULATED_COUNT,
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> PartialBench:
    """Judge the predictions on the maps of data/partial, and on so many simulated ones.

    pictures: an existing folder for RUN_STEP.png. track: wraps the names of the maps, to show progress.
    Raises DataError when there are no maps.
    """
    jobs: list[tuple[str, str, Callable[[], PartialMap]]] = [
        (found.run, found.item, found.read) for found in list_real_maps(data)
    ]
    jobs += [(SIMULATED, f"world {i}", partial(simulate_world, i)) for i in range(simulated)]
    rooms: dict[str, list[JudgedRoom]] = {run: [] for run, _, _ in jobs}
    failed: dict[str, list[Row]] = {run: [] for run, _, _ in jobs}
    for _, (run, item, read) in zip(track([item for _, item, _ in jobs]), jobs, strict=True):
        try:
            known = read()
            floor = reconstruct(replace(known.grid, source=known.item), method=method)
            rooms[run] += judge_rooms(floor, known)
            if pictures:
                save_figure(draw_floor(floor, known.grid), pictures / f"{known.item.replace('/', '_')}.png")
        # A bench must find out what breaks a prediction, whatever it is, and go on
        except Exception as error:
            kind = "" if isinstance(error, PiantaError) else f"{type(error).__name__}: "
            failed[run].append(Row(item, {}, kind + one_line_reason(error)))
    return PartialBench(method, rooms, failed)


def judge_rooms(floor: Floor, known: PartialMap) -> Iterator[JudgedRoom]:
    """The rooms of a floor that are found partial, or whose true room was seen in part."""
    true = np.array(known.rooms, dtype=object)
    unseen = [measure_unseen(polygon, known.grid) for polygon in known.rooms]
    for room in floor.rooms:
        shared = shapely.area(shapely.intersection(true, room.polygon, grid_size=SNAP_DISTANCE))
        index = int(shared.argmax())
        best, seen_share = true[index], float(shared[index]) / true[index].area
        if room.partial or (unseen[index] > UNSEEN and seen_share > TRACE):
            rectangle = draw_rectangle(room, find_main_direction(floor, room))
            guesses = (room.polygon, rectangle, room.predicted or room.polygon)
            seen, around, predicted = (measure_iou(guess, best) for guess in guesses)
            found = (known.item, room.id, room.partial, seen_share, unseen[index])
            yield JudgedRoom(*found, seen, around, predicted, room.confidence)


def draw_rectangle(room: Room, direction: float) -> Polygon:
    """The rectangle around what was seen of a room, along a direction, radians."""
    upright = rotate(room.polygon, -direction, origin=(0, 0), use_radians=True)
    return rotate(shapely.box(*upright.bounds), direction, origin=(0, 0), use_radians=True)


def measure_iou(one: Polygon, other: Polygon) -> float:
    """Area that two polygons share over that of both together."""
    shared = shapely.intersection(one, other, grid_size=SNAP_DISTANCE).area
    return float(shared / (one.area + other.area - shared))


def measure_unseen(room: Polygon, grid: GridMap) -> float:
    """Share of a true room that is unknown on a map or beyond it, but for what is thinner than WALL."""
    rows, cols, inside = cells_of_polygon(room, grid)
    count = room.area / grid.resolution**2
    unknown = (inside & grid.unknown[rows, cols]).astype(np.uint8)
    if not inside.any():
        return 1.0
    square = np.ones((round(WALL / grid.resolution),) * 2, np.uint8)
    thick = cv2.morphologyEx(unknown, cv2.MORPH_OPEN, square, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    beyond = max(0.0, count - float(inside.sum()))
    return float((thick.sum() + beyond) / count)


def tabulate_partial(bench: PartialBench) -> tuple[ComparisonTable, ...]:
    """IoU by run, for three choices of rooms, then how far confidence can be trusted, and what is found partial."""
    choices: dict[str, Callable[[JudgedRoom], bool]] = {
        "at least a third seen": lambda room: room.found_partial and room.seen_share >= A_THIRD,
        "at least a third seen, truly partial": lambda room: room.truly_partial and room.seen_share >= A_THIRD,
        "all found partial": lambda room: room.found_partial,
    }
    scores = [_tabulate_scores(bench, name, chosen) for name, chosen in choices.items()]
    return *scores, tabulate_confidence(bench), tabulate_recall(bench)


def _tabulate_scores(bench: PartialBench, name: str, chosen: Callable[[JudgedRoom], bool]) -> ComparisonTable:
    rows = []
    for run, of_run in _list_runs(bench).items():
        rooms = [room for room in of_run if chosen(room)]
        cells = [Cell.over([100 * getattr(room, guess) for room in rooms]) for guess in GUESSES]
        gains = [Cell.over([100 * (room.predicted - getattr(room, guess)) for room in rooms]) for guess in GUESSES[:2]]
        rows.append(ComparisonRow(f"{run} ({len(rooms)})", (*cells, *gains)))
    title = f"IoU with the true room, {bench.method}, rooms: {name}"
    return ComparisonTable(title, (*GUESSES, "over seen", "over rectangle"), tuple(rows), NOTES, "%")


def tabulate_confidence(bench: PartialBench) -> ComparisonTable:
    """Confidence beside the IoU that came about, by how high it is; real and simulated maps."""
    rows = []
    for name, of_name in _split_simulated(bench).items():
        for low, high in BINS:
            known = [
                room for room in of_name if room.confidence is not None and low <= room.confidence < high + (high == 1)
            ]
            said = [100 * room.confidence for room in known if room.confidence is not None]
            cells = Cell.over(said), Cell.over([100 * room.predicted for room in known])
            rows.append(ComparisonRow(f"{name}, {low:g} to {high:g} ({len(known)})", cells))
    return ComparisonTable("Confidence, the expected IoU, and the IoU", ("confidence", "IoU"), tuple(rows), unit="%")


def tabulate_recall(bench: PartialBench) -> ComparisonTable:
    """How many rooms that are truly partial are found so, and how many that are found so are it."""
    rows = []
    for run, rooms in _list_runs(bench).items():
        found = [room.truly_partial for room in rooms if room.found_partial]
        true = [room.found_partial for room in rooms if room.truly_partial]
        cells = [Cell(100 * fmean(flags) if flags else None, count=len(flags)) for flags in (true, found)]
        rows.append(ComparisonRow(f"{run} ({len(true)}, {len(found)})", tuple(cells)))
    columns = ("of truly partial, found", "of found, truly partial")
    return ComparisonTable("Rooms that are found partial", columns, tuple(rows), unit="%")


def _list_runs(bench: PartialBench) -> dict[str, list[JudgedRoom]]:
    """The rooms of each run, then of all real ones together."""
    runs = {run: [*rooms] for run, rooms in bench.rooms.items()}
    layouts = [room for run, rooms in runs.items() if run != SIMULATED for room in rooms]
    return runs | ({"all real maps": layouts} if layouts else {})


def _split_simulated(bench: PartialBench) -> dict[str, list[JudgedRoom]]:
    real = [room for run, rooms in bench.rooms.items() if run != SIMULATED for room in rooms]
    return {"real": real, SIMULATED: [*bench.rooms.get(SIMULATED, ())]}


def _row(room: JudgedRoom) -> Row:
    figures: Figures = {
        "found_partial": float(room.found_partial),
        "seen_share": 100 * room.seen_share,
        "unseen_share": 100 * room.unseen_share,
        **{guess: 100 * getattr(room, guess) for guess in GUESSES},
        "confidence": None if room.confidence is None else 100 * room.confidence,
    }
    return Row(f"{room.item} room {room.room}", figures)
