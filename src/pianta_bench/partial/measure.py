"""Predicted shapes of partly explored rooms (section 8.2), against the true ones and simpler guesses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import shapely
from shapely import Polygon

from pianta.floor import Floor, cells_of_polygon
from pianta.gridmap import GridMap
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.layout.reconstruct import DEFAULT_METHOD, check_method, reconstruct
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta_bench.data.folders import find_data
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.partial.guesses import GUESSES, Guesser
from pianta_bench.partial.maps import SIMULATED, SIMULATED_COUNT, PartialMap, list_real_maps, simulate_world

MIN_UNSEEN = 0.1  # share of a true room; a room with a larger unexplored share is truly partial
WALL = 1.0  # m; unknown space thinner than this is in walls
MIN_SHARED = 0.02  # share of a true room, below which a reconstructed room is not compared with it


@dataclass(frozen=True)
class EvaluatedRoom:
    """A room that is reconstructed as partial, or whose true room is partly explored.

    called_partial: whether it is reconstructed as partial. seen_share: of the true room, the share in this room.
    unseen_share: of the true room, the unexplored share. ious: of each of GUESSES with the true room.
    confidence: None if nothing is predicted.
    """

    item: str
    room: int
    called_partial: bool
    seen_share: float
    unseen_share: float
    ious: Mapping[str, float]
    confidence: float | None

    @property
    def truly_partial(self) -> bool:
        """Whether more than MIN_UNSEEN of the true room is unexplored."""
        return self.unseen_share > MIN_UNSEEN

    @property
    def figures(self) -> Figures:
        """All figures, in %."""
        shares = {name: 100 * getattr(self, name) for name in ("seen_share", "unseen_share")}
        shares |= {guess: 100 * self.ious[guess] for guess in GUESSES}
        confidence = None if self.confidence is None else 100 * self.confidence
        return {"called_partial": float(self.called_partial), **shares, "confidence": confidence}


def measure(
    data: Path | None = None,
    *,
    method: str = DEFAULT_METHOD,
    simulated: int = SIMULATED_COUNT,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Evaluate the predictions on the maps of data/partial, and on simulated ones; a record for each figure of a room.

    simulated: the number of simulated maps. pictures: folder for RUN_STEP.png. track: wraps the names of the maps, to
    show progress.
    Raises DataError if there are no maps.
    """
    check_method(method)
    jobs = [(each.run, each.item, each.read) for each in list_real_maps(find_data(data))]
    jobs += [(SIMULATED, f"world {number}", partial(simulate_world, number)) for number in range(simulated)]
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    results = Results({"method": method})
    rooms: dict[str, list[EvaluatedRoom]] = {run: [] for run, _, _ in jobs}
    results.objects["rooms"] = rooms
    for _, (run, item, read) in zip(track([item for _, item, _ in jobs]), jobs, strict=True):

        def measure_map(run: str = run, read: Callable[[], PartialMap] = read) -> Iterator[Figures]:
            partial_map = read()
            floor = reconstruct(replace(partial_map.grid, source=partial_map.item), method=method)
            evaluated = [*evaluate_rooms(floor, partial_map)]
            rooms[run] += evaluated
            for room in evaluated:
                results.add(run, f"{room.item} room {room.room}", room.figures)
            if pictures:
                save_figure(draw_floor(floor, partial_map.grid), pictures / f"{partial_map.item.replace('/', '_')}.png")
            yield {}

        results.measure(run, item, measure_map)
    return results


def evaluate_rooms(floor: Floor, partial_map: PartialMap) -> Iterator[EvaluatedRoom]:
    """The rooms of a floor that are reconstructed as partial, or whose true room is partly explored."""
    true = np.array(partial_map.rooms, dtype=object)
    unseen = [measure_unseen(polygon, partial_map.grid) for polygon in partial_map.rooms]
    guesser = Guesser.make(floor, partial_map.grid)
    for room in floor.rooms:
        shared = shapely.area(shapely.intersection(true, room.polygon, grid_size=SNAP_DISTANCE))
        index = int(shared.argmax())
        best, seen_share = true[index], float(shared[index]) / true[index].area
        if room.partial or (unseen[index] > MIN_UNSEEN and seen_share > MIN_SHARED):
            ious = {name: measure_iou(guess, best) for name, guess in guesser.guess(room).items()}
            shares = seen_share, unseen[index]
            yield EvaluatedRoom(partial_map.item, room.id, room.partial, *shares, ious, room.confidence)


def measure_iou(one: Polygon, other: Polygon) -> float:
    """Intersection over union of two polygons."""
    shared = shapely.intersection(one, other, grid_size=SNAP_DISTANCE).area
    return float(shared / (one.area + other.area - shared))


def measure_unseen(room: Polygon, grid: GridMap) -> float:
    """Share of a true room that is unknown on a map or outside it; unknown strips thinner than WALL do not count."""
    rows, cols, inside = cells_of_polygon(room, grid)
    count = room.area / grid.resolution**2
    unknown = (inside & grid.unknown[rows, cols]).astype(np.uint8)
    if not inside.any():
        return 1.0
    square = np.ones((round(WALL / grid.resolution),) * 2, np.uint8)
    thick = cv2.morphologyEx(unknown, cv2.MORPH_OPEN, square, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    beyond = max(0.0, count - float(inside.sum()))
    return float((thick.sum() + beyond) / count)
