"""Semantic mapping on-line, in drawn buildings: what is right over the way, what it costs, and how far robots drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import isfinite
from pathlib import Path
from time import process_time
from typing import TypeAlias

import networkx as nx
import numpy as np

from pianta.building_types.growing_map_types import read_default_growing_map_type_model
from pianta.errors import DataError, MapError, OptionError, PiantaError
from pianta.evaluation.floor_scores import score_floor
from pianta.exploration.explore import explore
from pianta.exploration.map_perception import UPDATE_DISTANCE
from pianta.exploration.perceptions import PERFECT
from pianta.exploration.policies import PREDICTED, make_policy
from pianta.exploration.policy_input import Policy
from pianta.exploration.record import Exploration
from pianta.exploration.starts import find_starts
from pianta.exploration.world import World, build_world
from pianta.floor import Floor, Room
from pianta.generation.type_model import MIN_FLOORS, learn_type, prepare_room_graph
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason
from pianta.labels import SCHEMAS, LabelConvention, LabelSet
from pianta.mapping.events import Event, EventKind
from pianta.mapping.mapper import Mapper, MapUpdate
from pianta.prediction.unexplored_part import FloorSampler
from pianta.rooms.completion import map_labels_upwards
from pianta.rooms.training import train_rooms
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings, set_building_type
from pianta_bench.data.folders import find_data
from pianta_bench.data.typed_maps import name_training_building
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.online import MOST_ROOMS, STARTS

STAGES = (0.25, 0.5, 0.75, 1.0)  # of the area that the robot observes, at which the last map is also read as a whole
CURVE = tuple(sorted({*STAGES, *(tenth / 10 for tenth in range(1, 11))}))  # at which figures are taken
SHARE_DRIVEN = 0.9  # of the area, to which metres are compared
FES = "F/C/E/S"
MIN_SEEN = 0.5  # of a true room, for it to count
SAME_ROOM = 0.5  # IoU
TOLERANCE = 1e-9  # of shares, which are sums of cells
ROOMS, DOORS, LABELS, TYPE = "rooms F1", "doors F1", "labels right", "type right"
READ_ROOMS, READ_LABELS, READ_TYPE = (f"{name}, one reading" for name in (ROOMS, LABELS, TYPE))
COST, LARGEST, READING, RATIO = "update, s", "longest update, s", "reading, s", "update over reading"
CHANGED_IDS, TYPE_AT = "ids changed", "share when the type is right"
METRES_MAP, METRES_PERFECT, LONGER = "metres to 90 %", "metres to 90 %, perfect", "metres over perfect"
LABEL_BELIEF, TYPE_BELIEF = "belief in labels", "belief in types"
# Of the room behind an unopened door; by the mean shares of labels on the floors of the model, the same at all doors
END_BELIEF, END_BASELINE = "belief behind doors", "mean shares behind doors"
SIZE, BEHIND = "expected rooms, error", "behind doors right"

Belief: TypeAlias = tuple[str, float, bool]  # metric, probability of the likeliest answer, whether that is right


@dataclass(frozen=True, eq=False)
class _Building:
    """A building to explore.

    others: floors of other buildings; graphs: theirs, with labels of the type. starts: the most, 0 for all.
    """

    annotated: AnnotatedFloor
    others: tuple[Floor, ...]
    graphs: tuple[nx.Graph, ...]
    building_type: str
    starts: int
    seed: int


def measure(
    data: Path | None = None,
    *,
    type: str = "school",  # noqa: A002 - the option --type
    items: Sequence[str] | None = None,
    most_rooms: int = MOST_ROOMS,
    starts: int = STARTS,
    jobs: int = 1,
    seed: int = 0,
    track: Track = iter,
) -> Results:
    """Explore data/buildings/TYPE/*.xml with perfect perception, and with that of the map.

    items: names of buildings, None for all. most_rooms: larger ones are left out. starts: from which robots drive, the
    most for each building, 0 for all; what they understand is that of the first one. jobs: processes.
    Models of rooms and types, and what the policy predicts, are learned without the building. Floors in several parts,
    or with labels that the type does not have, are explored, but what the policy predicts is not learned from them;
    details["unmodelled"] has the reason of each.
    Raises DataError for too few buildings, and OptionError for an unknown type or name, and for starts below 0.
    """
    if starts < 0:
        raise OptionError(f"starts is {starts}, give how many at most, or 0 for all")
    if type not in SCHEMAS:
        raise OptionError(f"type is {type!r}, give one of {', '.join(SCHEMAS)}")
    results = Results({"type": type, "most_rooms": most_rooms, "starts": starts, "seed": seed})
    floors, failed = read_annotated_buildings(
        find_data(data), type, lambda each: replace(each, floor=set_building_type(each.floor, type))
    )
    results.items += [replace(each, part=type) for each in failed]
    if len(floors) <= MIN_FLOORS:
        raise DataError(f"{len(floors)} floors are too few to learn from, give {MIN_FLOORS + 1}")
    if unknown := {*(items or ())} - {floor.item for floor in floors}:
        raise OptionError(f"no building is called {', '.join(sorted(unknown))}")
    graphs, results.details["unmodelled"] = _prepare_graphs(floors, type)
    steps = {}
    for floor in floors:
        if (items and floor.item not in items) or (not items and len(floor.floor) > most_rooms):
            continue
        others = [other for other in floors if other.building != floor.building]
        learned = tuple(graphs[each.item] for each in others if each.item in graphs)
        building = _Building(floor, tuple(other.floor for other in others), learned, type, starts, seed)
        steps[floor.item] = partial(_measure_building, building)
    for measured in run_steps(steps, jobs=jobs, track=track):
        results.extend(measured)
    return results


def _prepare_graphs(floors: Sequence[AnnotatedFloor], building_type: str) -> tuple[dict[str, nx.Graph], dict[str, str]]:
    """The graphs of floors by item, and of those of which a model cannot learn the reason."""
    graphs, unmodelled = {}, {}
    for each in floors:
        try:
            graphs[each.item] = prepare_room_graph(each.floor.graph(), SCHEMAS[building_type])
        except PiantaError as error:
            unmodelled[each.item] = one_line_reason(error)
    return graphs, unmodelled


def _measure_building(building: _Building) -> Results:
    results = Results()
    name, part = building.annotated.item, building.building_type
    beliefs: list[Belief] = []
    ways: list[Figures] = []
    results.measure(part, name, lambda: _explore_building(building, beliefs, ways))
    if results.failed:
        return results
    for metric, probability, is_right in beliefs:
        results.add(part, name, {metric: float(is_right)}, probability=probability)
    for start, metres in enumerate(ways):
        results.add(part, name, metres, start=start)
    return results


def _explore_building(building: _Building, beliefs: list[Belief], ways: list[Figures]) -> Iterator[Figures]:
    """Figures of mappers on the way from the first start; ways gets the metres from each start."""
    truth = replace(building.annotated.floor, source=building.annotated.item)
    world = build_world(truth)
    model = learn_type(building.graphs, SCHEMAS[building.building_type])
    sampler = FloorSampler(model)
    room_model = train_rooms(building.others)
    own = name_training_building(building.annotated.building)
    type_model = read_default_growing_map_type_model()
    if own in type_model.buildings:
        type_model = type_model.leave_out(own)
    make_mapper = partial(Mapper, room_model=room_model, type_model=type_model)
    # The robot that drives knows the type, as the policy needs labels of it
    make_driving = partial(make_mapper, building_type=building.building_type)
    drive = partial(_drive, world, partial(make_policy, PREDICTED, sampler=sampler), make_driving, building.seed)
    first, *further = find_starts(world)[: building.starts or None]
    by_map, metres = drive(first)
    # The robot that is asked does not
    compared = _Compared(by_map, world, truth)
    yield from _follow(make_mapper(), by_map, compared, beliefs)
    # One that knows the type can say what lies behind doors
    yield from _follow_ends(make_mapper(model=model), by_map, compared, beliefs)
    ways += [metres, *(drive(start)[1] for start in further)]


def _drive(
    world: World,
    make_predicting: Callable[[], Policy],
    make_driving: Callable[[], Mapper],
    seed: int,
    start: tuple[float, float],
) -> tuple[Exploration, Figures]:
    """The run of a robot that reads its map, and its metres beside those without error; None if not so far."""
    run, perfect = (
        explore(world, make_predicting(), starts=[start], perception=perception, seed=seed)
        for perception in (make_driving(), PERFECT)
    )
    by_map, without_error = (
        metres if isfinite(metres := each.distance_to(SHARE_DRIVEN)) else None for each in (run, perfect)
    )
    longer = by_map / without_error if by_map is not None and without_error else None
    return run, {METRES_MAP: by_map, METRES_PERFECT: without_error, LONGER: longer}


def _follow(mapper: Mapper, run: Exploration, compared: _Compared, beliefs: list[Belief]) -> Iterator[Figures]:
    """Figures of a mapper that gets the maps of a run, at the shares of STAGES and at the end."""
    history: list[_Comparison] = []
    stages, readings, final = [*CURVE], [], None
    changed, last = 0, len(run.distance) - 1
    seconds: list[float] = []
    since = 0  # the updates before the last stage
    for scan in choose_update_scans(run):
        grid = run.map_at(scan)
        try:
            update = _update(mapper, grid, seconds)
            while scan == last and update.waiting_share:
                update = _update(mapper, grid, seconds)
        except MapError:
            continue  # the robot has hardly started
        comparison = compared.compare(update, scan)
        changed += _count_changed_ids(history[-1].ids if history else {}, comparison.ids, update.events)
        history.append(comparison)
        beliefs += comparison.beliefs
        passed = _pop_passed(stages, comparison.share)
        for stage in passed:
            yield _describe_stage(comparison, stage)
            yield {name_stage(COST, stage): float(np.mean(seconds[since:]))}
        since = len(seconds) if passed else since
        for _ in {*passed} & {*STAGES}:
            start = process_time()
            reading = Mapper(room_model=mapper.room_model, type_model=mapper.type_model).update(grid)
            readings.append(process_time() - start)
            final = compared.compare(reading, scan)
    if final is None:
        return
    yield {READ_ROOMS: final.rooms, READ_LABELS: final.labels, READ_TYPE: final.is_type_right}
    yield {
        COST: float(np.mean(seconds)),
        LARGEST: max(seconds),
        READING: float(np.mean(readings)),
        RATIO: float(np.mean(seconds) / np.mean(readings)),
        CHANGED_IDS: changed / len(compared.truth),
        TYPE_AT: _find_type_share(history) if final.is_type_right else None,
    }


def _follow_ends(mapper: Mapper, run: Exploration, compared: _Compared, beliefs: list[Belief]) -> Iterator[Figures]:
    """How wrong the expected number of rooms is, and how much behind doors is right since the last share of CURVE.

    beliefs get those of what is behind doors.
    """
    stages, true_rooms = [*CURVE], len(compared.truth)
    behind: list[bool] = []
    for scan in choose_update_scans(run):
        try:
            update = mapper.update(run.map_at(scan))
        except MapError:
            continue  # the robot has hardly started
        rated = [*compared.rate_ends(update)]
        beliefs += rated
        behind += [is_right for metric, _, is_right in rated if metric == END_BELIEF]
        passed = _pop_passed(stages, float(run.share[scan] / run.share[-1]))
        for stage in passed:
            expected = update.prediction.rooms.mean if update.prediction else len(update.floor)
            yield {name_stage(SIZE, stage): abs(expected - true_rooms) / true_rooms}
            yield {name_stage(BEHIND, stage): float(np.mean(behind)) if behind else None}
        if passed:
            behind.clear()


def _pop_passed(stages: list[float], share: float) -> list[float]:
    """The stages up to a share of the area, which are removed; stages: in order."""
    passed = [stage for stage in stages if share >= stage - TOLERANCE]
    del stages[: len(passed)]
    return passed


def _update(mapper: Mapper, grid: GridMap, seconds: list[float]) -> MapUpdate:
    """An update of a mapper, whose time of the processor is added to the others, seconds."""
    start = process_time()
    update = mapper.update(grid)
    seconds.append(process_time() - start)
    return update


@dataclass(frozen=True)
class _Comparison:
    """What is right at a scan.

    share: of the area that the run observes. ids: of the room of the map by that of the true one. beliefs: with whether
    they are right.
    """

    share: float
    rooms: float
    doors: float
    labels: float | None
    is_type_right: bool
    ids: Mapping[int, int]
    beliefs: list[Belief]


def choose_update_scans(run: Exploration) -> list[int]:
    """Scans every few metres, at which a robot updates its building, the first and the last among them."""
    chosen = [0]
    for scan, metres in enumerate(run.distance.tolist()):
        if metres - run.distance[chosen[-1]] >= UPDATE_DISTANCE:
            chosen.append(scan)
    last = len(run.distance) - 1
    return chosen if chosen[-1] == last else [*chosen, last]


@dataclass(frozen=True, eq=False)
class _Compared:
    """The true building of a run."""

    run: Exploration
    world: World
    truth: Floor

    @cached_property
    def labels(self) -> Mapping[int, str]:
        """The label in F/C/E/S of each room."""
        floor = map_labels_upwards(self.truth, SCHEMAS[self.truth.building_types[0]])
        return {room.id: room.labels[FES] for room in floor}

    def compare(self, update: MapUpdate, scan: int) -> _Comparison:
        """Compare with the true rooms of which at least half was observed at a scan."""
        run, world, truth = self.run, self.world, self.truth
        is_observed = (run.scan_of_cell >= 0) & (run.scan_of_cell <= scan) & world.free
        counts = np.bincount(world.room_of_cell[is_observed], minlength=len(world.room_cells))
        rooms = tuple(room for room in truth if counts[room.id] >= MIN_SEEN * max(world.room_cells[room.id], 1))
        ids = {room.id for room in rooms}
        doors = tuple(door for door in truth.doors if {*door.room_ids} <= ids and door.joins_rooms)
        scores = score_floor(update.floor, replace(truth, rooms=rooms, doors=doors, walls=()))
        name = truth.building_types[0]
        likeliest = max(update.types, key=update.types.__getitem__)
        matches = [(room, true) for room in update.floor if (true := _find_room(room, rooms)) is not None]
        beliefs = [(TYPE_BELIEF, update.types[likeliest], likeliest == name), *self._rate_labels(matches)]
        right = [is_right for metric, _, is_right in beliefs if metric == LABEL_BELIEF]
        return _Comparison(
            float(run.share[scan] / run.share[-1]),
            scores.rooms.f1,
            scores.doors.f1,
            float(np.mean(right)) if right else None,
            next(iter(update.floor.building_type), None) == name,
            {true.id: room.id for room, true in matches},
            beliefs,
        )

    def rate_ends(self, update: MapUpdate) -> Iterator[Belief]:
        """The likeliest function of the room behind each unopened door, by belief and by mean shares."""
        if update.prediction is None:
            return
        schema, rooms = update.prediction.schema, {str(room.id): room for room in update.floor}
        for end in update.ends:
            point = rooms[str(end.room)].polygon.representative_point()
            true = next((room for room in self.truth if room.polygon.contains(point)), None)
            if true is None or not end.is_door:
                continue
            for metric, labels in ((END_BELIEF, end.labels), (END_BASELINE, update.prediction.average)):
                shares: dict[str, float] = {}
                functions = schema.map_labels([*labels], LabelSet.F_C_E_S, convention=LabelConvention.EXPERIMENTS)
                for function, probability in zip(functions, labels.values(), strict=True):
                    shares[str(function)] = shares.get(str(function), 0.0) + probability
                best = max(shares, key=shares.__getitem__)
                yield metric, shares[best], best == self.labels[true.id]

    def _rate_labels(self, matches: Sequence[tuple[Room, Room]]) -> Iterator[Belief]:
        """The probability of the likeliest label of each room that is a true one, and whether it is right."""
        for room, true in matches:
            belief = room.label_probabilities[FES]
            best = max(belief, key=belief.__getitem__)
            yield LABEL_BELIEF, belief[best], best == self.labels[true.id]


def _count_changed_ids(before: Mapping[int, int], ids: Mapping[int, int], events: Sequence[Event]) -> int:
    """The true rooms whose id has changed, although they were neither joined nor divided.

    before, ids: of the room of the map by that of the true one.
    """
    kinds = EventKind.JOINED_ROOMS, EventKind.DIVIDED_ROOM
    explained = {room for event in events if event.kind in kinds for room in event.rooms}
    changes = [(before[true], new) for true, new in ids.items() if true in before and before[true] != new]
    return sum(explained.isdisjoint(change) for change in changes)


def _find_room(room: Room, rooms: Sequence[Room]) -> Room | None:
    """The true room that a room of the map is."""
    for true in rooms:
        shared = room.polygon.intersection(true.polygon).area
        if shared > SAME_ROOM * (room.polygon.area + true.polygon.area - shared):
            return true
    return None


def _describe_stage(comparison: _Comparison, stage: float) -> Figures:
    return {
        name_stage(metric, stage): value
        for metric, value in (
            (ROOMS, comparison.rooms),
            (DOORS, comparison.doors),
            (LABELS, comparison.labels),
            (TYPE, comparison.is_type_right),
        )
    }


def name_stage(metric: str, stage: float) -> str:
    """The name of a metric at a share of the area."""
    return f"{metric} at {stage:.0%}"


def _find_type_share(history: Sequence[_Comparison]) -> float | None:
    """The share of the area from which on the type is right to the end; None if it is wrong at the end."""
    first = None
    for comparison in reversed(history):
        if not comparison.is_type_right:
            break
        first = comparison.share
    return first
