"""Plans of the probable continuations of a partly explored floor: the function behind `pianta predict --plans`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import cast

import numpy as np

from pianta._arguments import check_argument
from pianta._types import Mask
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.generation.drawing.room_sizes import sample_areas
from pianta.generation.type_model import TypeModel
from pianta.graphs.metrics import find_corridors
from pianta.gridmap import GridMap
from pianta.prediction.continuation.count_samples import SampleCounts
from pianta.prediction.continuation.drawn_floor import SampleRooms, draw_floor
from pianta.prediction.continuation.ground import Ground, prepare_ground
from pianta.prediction.continuation.known_part import KnownPart, locate_known_part
from pianta.prediction.continuation.shares import ShareGrid, crop_grid, move_to_map
from pianta.prediction.prediction import Prediction
from pianta.prediction.revealed_floor import RevealedFloor
from pianta.prediction.unexplored_part import SampledFloor
from pianta.worlds.wall_axes import INNER_WALL

PLANS = 3  # plans that are drawn
COMPARED = 200  # samples of which these are chosen, the first ones; limits time and memory
EMPTY = 1.0  # cell that any two samples have in common, so that two without rooms are equal
LARGE = 0.9  # quantile of the areas of unknown rooms for which there is space


@dataclass(frozen=True)
class Continuation:
    """A sample as a floor.

    Attributes
    ----------
    floor
        The known rooms, and the sampled ones in the map frame: open corridors, and rooms of which a part is seen, have
        a prediction, and others the flag "predicted" and ids after those of the floor.
    sample
        Its number in the samples of the prediction, from 0.
    share
        Of the samples, those that resemble it more than the other drawn ones.
    unplaced
        Its unknown rooms that have no space.
    given_up
        Doors between its unknown rooms that have no wall, beside those of unplaced rooms.
    """

    floor: Floor
    sample: int
    share: float
    unplaced: int
    given_up: int


@dataclass(frozen=True, eq=False)
class Continuations:
    """The samples of a prediction, drawn behind the open ends of the known part.

    Attributes
    ----------
    plans
        Three samples that stand for all, or fewer if there are fewer samples: that of the most samples first.
    grid
        The share of samples that have free space and walls at each cell.
    placed
        Share of the unknown rooms of all samples that have space.
    doors
        Share of the doors between unknown rooms of all samples that have a wall.
    """

    plans: tuple[Continuation, ...]
    grid: ShareGrid
    placed: float
    doors: float


def draw_continuations(
    prediction: Prediction,
    floor: Floor,
    *,
    model: TypeModel,
    grid: GridMap | None = None,
    truth: RevealedFloor | None = None,
    seed: int = 0,
) -> Continuations:
    """Draw the samples of a prediction as plans behind the open ends of a floor, and count where they are free.

    Known rooms stay as they are. Sampled corridors and rooms are rectangles along the main direction of the walls, of
    their sampled areas, in space that is not known; where there is little they are smaller. The command `pianta predict
    --plans` calls this function.

    Parameters
    ----------
    prediction
        Of `predict`.
    floor
        The floor that was predicted, with outlines in metres of the map frame.
    model
        The model of the prediction; it has the areas of rooms without one.
    grid
        The map of the floor, if there is one: its known cells stay free of rooms, and the grid of shares has its frame.
    truth
        The whole floor, if the explored part is one of `reveal_corridors`; of open corridors only what lies within 3 m
        of a door to a known room then counts as seen.
    seed
        The same seed gives the same plans.

    Returns
    -------
    Continuations
        Three plans and the grid of shares.

    Raises
    ------
    FloorError
        The prediction is of another floor, or the floor is too large.
    ModelError
        Samples lack areas that the model does not have either.
    OptionError
        The seed is negative, or an argument of another type.

    References
    ----------
    M. Luperto, PhD thesis, section 8.3, whose predictions are graphs.

    Examples
    --------
    >>> import pianta
    >>> floor = pianta.read_floor("explored/floor.geojson")  # doctest: +SKIP
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> prediction = pianta.predict(floor, model)  # doctest: +SKIP
    >>> continuations = pianta.draw_continuations(prediction, floor, model=model)  # doctest: +SKIP
    >>> continuations.plans[0].floor.save("plan-1.geojson")  # doctest: +SKIP
    """
    check_argument(prediction, (Prediction,), "prediction", "a result of predict")
    check_argument(floor, (Floor,), "floor", "the Floor that was predicted")
    check_argument(model, (TypeModel,), "model", "a model of train_type or load_model")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    # The known part in cells along its walls, with its open ends
    drawer = SampleDrawer.make(prediction, locate_known_part(prediction.explored, floor, truth), model, grid, seed=seed)
    # Each sample is laid out in free space, and counted
    counts = drawer.count()
    # Three of them stand for all, by the cells in which they differ
    chosen = choose_typical(counts.first, PLANS)
    plans = tuple(drawer.draw(number, share) for number, share in chosen.items())
    # Shares go into the frame of the map
    shares = crop_grid(counts.cells.to_grid())
    return Continuations(plans, shares if grid is None else move_to_map(shares, grid), counts.placed, counts.doors)


@dataclass(eq=False)
class Counts:
    """Counts over all samples. first: where each of the first samples has rooms, on the ground."""

    cells: SampleCounts
    first: list[Mask] = field(default_factory=list)
    numbers: Counter[str] = field(default_factory=Counter)

    @property
    def placed(self) -> float:
        """Share of the unknown rooms that have space; 1 without any."""
        return 1 - self.numbers["unplaced"] / max(1, self.numbers["rooms"])

    @property
    def doors(self) -> float:
        """Share of the doors between unknown rooms that have a wall; 1 without any."""
        return self.numbers["walls"] / self.numbers["doors"] if self.numbers["doors"] else 1.0


@dataclass(frozen=True, eq=False)
class SampleDrawer:
    """Lays out the samples of a prediction on the ground around a known part."""

    prediction: Prediction
    known_part: KnownPart
    ground: Ground
    model: TypeModel
    seed: int = 0

    @classmethod
    def make(
        cls,
        prediction: Prediction,
        known_part: KnownPart,
        model: TypeModel,
        grid: GridMap | None = None,
        *,
        seed: int = 0,
    ) -> SampleDrawer:
        """With space for large samples. grid: the map of the known part."""
        areas = [
            sum(
                area
                for node, area in find_areas(sample, model, np.random.default_rng(seed)).items()
                if node in {*sample.unseen}
            )
            for sample in prediction.samples
        ]
        ground = prepare_ground(known_part, grid, unknown_area=float(np.quantile(areas, LARGE)))
        return cls(prediction, known_part, ground, model, seed)

    def arrange(self, number: int) -> SampleRooms:
        """The rooms of a sample; they depend only on its number and the seed."""
        sample = self.prediction.samples[number]
        rng = np.random.default_rng((self.seed, number))
        areas = find_areas(sample, self.model, rng)
        corridors = frozenset(cast("frozenset[int]", find_corridors(sample.graph, self.prediction.schema)))
        layout = self.ground.arrange(sample, areas=areas, corridors=corridors, rng=rng)
        partial = {layout.numbers[node]: node for node in self.ground.partial if node in layout.numbers}
        return SampleRooms(
            layout.cells, sample.graph, partial, sample.behind, frozenset(sample.unseen) | partial.keys()
        )

    def count(self) -> Counts:
        """Lay out all samples."""
        counts = Counts(SampleCounts.make(self.ground, self.known_part))
        for number in range(len(self.prediction.samples)):
            rooms = self.arrange(number)
            counts.cells.add(rooms.cells, rooms.contacts.values())
            counts.numbers.update(rooms.numbers)
            if number < COMPARED:
                counts.first.append(rooms.cells >= 0)
        return counts

    def draw(self, number: int, share: float) -> Continuation:
        """The floor of a sample."""
        rooms = self.arrange(number)
        floor = draw_floor(rooms, self.known_part, self.ground.frame)
        return Continuation(floor, number, share, rooms.numbers["unplaced"], rooms.numbers["given up"])


def find_areas(sample: SampledFloor, model: TypeModel, rng: np.random.Generator) -> dict[int, float]:
    """The area of each room of a sample, m² between the axes of its walls; of the type where it has none."""
    areas = {node: area for node, area in sample.graph.nodes(data="area") if area is not None}
    areas = {node: (sqrt(area) + INNER_WALL) ** 2 for node, area in areas.items()}
    missing = [node for node in sample.unseen if node not in areas]
    return areas | (sample_areas(sample.graph.subgraph(missing), model, rng) if missing else {})


def choose_typical(masks: Sequence[Mask], count: int) -> dict[int, float]:
    """Masks that stand for all: their numbers, and the share of masks to which each is the nearest, the largest first.

    The distance of two masks is one minus the cells of both over those of either. The first one is the nearest to all;
    each further one lowers the sum of the distances to the nearest most.
    """
    rows = np.array([mask.ravel() for mask in masks], np.float32)
    both = rows @ rows.T
    either = np.diag(both)[:, None] + np.diag(both) - both
    distances = 1 - (both + EMPTY) / (either + EMPTY)
    chosen: list[int] = []
    nearest = np.full(len(rows), np.inf)
    for _ in range(min(count, len(rows))):
        totals = np.minimum(distances, nearest[:, None]).sum(axis=0)
        totals[chosen] = np.inf
        chosen.append(int(totals.argmin()))
        nearest = np.minimum(nearest, distances[:, chosen[-1]])
    groups = Counter(distances[:, chosen].argmin(axis=1).tolist())
    return {
        chosen[group]: groups[group] / len(rows)
        for group in sorted(range(len(chosen)), key=lambda group: -groups[group])
    }
