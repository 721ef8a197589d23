"""Model floor plans of the annotated schools and offices, and of the storeys of their buildings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pianta.floor import Floor
from pianta.patterns.model_floor_plan import SHUFFLES, ModelFloorPlan, find_model_floor_plan
from pianta.plot.figure import save_figure
from pianta.plot.model_floor_plan import draw_model_floor_plan
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_floors
from pianta_bench.data.folders import find_data
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Item, Results, Track

PARTS: Mapping[str, str] = MappingProxyType({"school": "schools", "office": "offices"})
STOREYS = "storeys of one building"
STRANGERS = "storeys of two buildings"
# What must be alike, and which rooms are shuffled.
BY_LABEL = "shapes and labels"
WITHIN_LABEL = "shapes and labels, shuffled within a label"
BY_SHAPE = "shapes alone"
WAYS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {BY_LABEL: {}, WITHIN_LABEL: {"within_labels": True}, BY_SHAPE: {"labels": False}}
)


def measure(
    data: Path | None = None,
    *,
    shuffles: int = SHUFFLES,
    seed: int = 0,
    jobs: int | None = None,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Find the patterns of each floor of data/buildings, and of the storeys of each building of several floors.

    Records are shares, 0 … 1, of the rooms: repeated and saved, as ModelFloorPlan has them, the same of shuffled rooms,
    and the rooms of the largest pattern. Of storeys: `across`, the rooms in patterns that are on several storeys; as a
    baseline the first storeys of two buildings that follow each other.
    shuffles, seed: as in find_model_floor_plan. jobs: number of processes, None for one for each core.
    pictures: folder for NAME.png of each floor. track: wraps the steps, to show progress.
    Raises DataError if there are no floors of a type.
    """
    floors, failed = read_annotated_floors(find_data(data))
    results = Results({"shuffles": shuffles, "seed": seed})
    results.items += [Item(PARTS[name], row.item, row.failure) for name, rows in failed.items() for row in rows]
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    steps = {}
    for floor in floors:
        names = PARTS[floor.kind], floor.item
        search = partial(find_model_floor_plan, floor.floor, shuffles=shuffles, seed=seed)
        for way, options in WAYS.items():
            picture = pictures / f"{floor.item}.png" if pictures and way == BY_LABEL else None
            step = partial(_describe_plan, *names, partial(search, **options), way)
            steps[f"{floor.item}, {way}"] = partial(step, floor=floor.floor, picture=picture)
    for part, buildings in _group_storeys(floors).items():
        for name, storeys in buildings.items():
            search = partial(find_model_floor_plan, [each.floor for each in storeys], shuffles=shuffles, seed=seed)
            steps[f"{name}, {part}"] = partial(_describe_plan, part, name, search, BY_LABEL)
    for partial_results in run_steps(steps, jobs=jobs, track=track):
        results.extend(partial_results)
    return results


def _group_storeys(floors: Sequence[AnnotatedFloor]) -> dict[str, dict[str, list[AnnotatedFloor]]]:
    """By part and name the storeys of each building of several, and of two buildings that follow each other."""
    buildings: dict[str, list[AnnotatedFloor]] = {}
    for floor in floors:
        buildings.setdefault(floor.building, []).append(floor)
    several = {name: storeys for name, storeys in buildings.items() if len(storeys) > 1}
    names = [*several]
    strangers = {
        f"{one}, {other}": [several[one][0], several[other][0]]
        for one, other in zip(names, names[1:] + names[:1], strict=True)
        if one != other
    }
    return {STOREYS: several, STRANGERS: strangers}


def _describe_plan(
    part: str, item: str, search: Any, way: str, *, floor: Floor | None = None, picture: Path | None = None
) -> Results:
    """The records of one model floor plan; picture: its file, if any, and floor what it shows."""
    results = Results()

    def run() -> Iterator[Figures]:
        plan = search()
        yield describe_plan(plan)
        if floor is not None and picture is not None:
            save_figure(draw_model_floor_plan(floor, plan), picture)

    results.measure(part, item, run, way=way)
    return results


def describe_plan(plan: ModelFloorPlan) -> Figures:
    """Shares of the rooms, 0 … 1, and the number of rooms of the largest pattern."""
    chance = plan.chance
    across = [pattern for pattern in plan.patterns if len({each.storey for each in pattern.occurrences}) > 1]
    figures = {
        "rooms": plan.rooms,
        "repeated": plan.repeated,
        "repeated area": plan.repeated_area / plan.area,
        "saved": plan.saved,
        "largest": max((len(pattern.occurrences[0].rooms) for pattern in plan.patterns), default=0),
        "in rows": sum(pattern.rooms for pattern in plan.patterns if pattern.kind == "row") / plan.rooms,
        "across": sum(pattern.rooms for pattern in across) / plan.rooms,
    }
    if chance:
        shuffled = {"repeated shuffled": chance.repeated, "saved shuffled": chance.saved}
        figures |= {**shuffled, "above all": float(chance.below == 1)}
    return figures
