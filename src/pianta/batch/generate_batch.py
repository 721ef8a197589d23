"""Generate a hundred thousand buildings: in parts of a folder each, with a journal of what is done."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pianta.batch.processes import Fault, run_items
from pianta.batch.run_batch import (
    UNFORESEEN,
    Batch,
    BatchItem,
    Progress,
    RunOptions,
    WorkItem,
    WorkResult,
    collect_warnings,
    digest_options,
)
from pianta.batch.world_folders import (
    FURNITURE,
    NOISE,
    RESOLUTION,
    WorldOptions,
    list_world_files,
    save_worlds,
)
from pianta.errors import BuildingWarning, OptionError, PiantaError
from pianta.io._files import is_filled_file, short_repr
from pianta.io._folders import atomic_folder, check_output_folder

if TYPE_CHECKING:
    import networkx as nx
    from shapely import Polygon

    from pianta.floor import Floor
    from pianta.generation.buildings import BuildingSampler
    from pianta.generation.drawing.draw import DrawnPlan
    from pianta.generation.type_model import TypeModel

PART = 1000  # buildings of a folder, which file managers still list
SHEET = "sheet.png"
PLAN_SHEET = "plans.png"
HAS_PLAN = "drawn"  # attribute of a graph; False if its building could not be drawn


def generate_batch(
    model: TypeModel,
    count: int,
    *,
    out: str | Path,
    rooms: int | tuple[int, int] | None = None,
    at_least: Mapping[str, int] | None = None,
    at_most: Mapping[str, int] | None = None,
    similar_to: Floor | nx.Graph | None = None,
    keep: Floor | nx.Graph | None = None,
    costs: str = "density",
    recombine: bool = True,
    kernel: str = "weisfeiler-lehman",
    seed: int = 0,
    plans: bool = False,
    outline: Polygon | None = None,
    worlds: bool = False,
    scan: bool = False,
    furniture: float = FURNITURE,
    noise: float = NOISE,
    resolution: float = RESOLUTION,
    jobs: int = 1,
    resume: bool = True,
    only_failed: bool = False,
    shard: str | None = None,
    time_limit: float | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> Iterator[BatchItem]:
    """Generate many buildings into a folder, with a journal of what is done.

    They are those that `generate` returns, in parts of 1,000, each in a folder part-0001, part-0002, … with their
    graphs (networkx node-link and GraphML) and the picture sheet.png.

    Parameters
    ----------
    model
        Model of the building type, from `train_type` or `load_model`.
    count
        Number of buildings.
    out
        The folder; journal.sqlite is beside the parts.
    rooms, at_least, at_most, similar_to, keep, costs, recombine, kernel, seed
        As of `generate`.
    plans
        Whether the buildings are also drawn as floors, by `draw_plan`: building-000001.geojson and .png, and plans.png.
    outline
        In which each building is drawn, metres, as of `draw_plan`; without `rooms` the buildings have about as many as
        there is space for. Buildings are then drawn.
    worlds
        Whether the floors also become worlds, in folders building-000001 and so on: map.yaml with its image, a world of
        Gazebo, and the truth with its furniture. Floors are then drawn, too.
    scan
        Whether a robot's map of each world is made, too, in folders scan-000001 and so on.
    furniture, noise, resolution
        Of worlds: how full rooms are, by their labels; how bad robots' maps are; and metres per cell, as of
        `make_world`.
    jobs, resume, only_failed, shard, time_limit, scheduler, progress
        As of `read_batch`, for parts instead of files.
    track
        Wraps the names of the steps of a part, to show progress within it; with one job.

    Returns
    -------
    iterator of BatchItem
        Of each part, first those that were generated before. `description` has the rooms of each building (`rooms`),
        whether it is a copy of a floor of the model (`copies`), and a fingerprint that is equal for equal graphs with
        equal labels, and hardly ever for others (`fingerprints`).

    Raises
    ------
    OptionError, ModelError, GraphError, LabelError
        As of `generate` and `read_batch`; the folder has more buildings of an earlier batch.

    Warns
    -----
    BuildingWarning
        As of `generate`; a door of a graph, or a building, could not be drawn.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> for part in pianta.generate_batch(model, 100_000, out="schools", jobs=8):  # doctest: +SKIP
    ...     print(part.folder, len(part.description["rooms"]))
    """
    from pianta.generation.buildings import check_count
    from pianta.generation.drawing.site import choose_rooms
    from pianta.generation.generate import make_sampler
    from pianta.generation.type_model_file import dump_type_model

    run = RunOptions(jobs, resume, only_failed, shard, time_limit, scheduler)
    check_count(count, seed)
    world_options = WorldOptions(furniture, resolution, scan, noise) if worlds or scan else None
    target = Path(out)
    check_output_folder(target)
    check_parts(target, count)
    options: dict[str, Any] = {
        "rooms": choose_rooms(outline, model) if rooms is None and outline is not None else rooms,
        "at_least": at_least,
        "at_most": at_most,
        "similar_to": similar_to,
        "keep": keep,
        "costs": costs,
        "recombine": recombine,
        "kernel": kernel,
    }
    sampler = make_sampler(model, **options)
    graphs = {name: _describe_floor(options[name]) for name in ("similar_to", "keep")}
    content = dump_type_model(model).decode()
    drawing: dict[str, Any] = {"plans": plans or world_options is not None or outline is not None}
    if outline is not None:
        drawing["outline"] = outline.wkt
    if world_options is not None:
        drawing["worlds"] = asdict(world_options)
    digest = digest_options({**options, **graphs, "seed": seed, "model": content, **drawing})
    # Processes and other machines cannot show what they do
    tracked = track if jobs == 1 and scheduler is None else iter
    work = _Work(sampler, seed, drawing["plans"], outline, world_options, tracked)
    batch = Batch(target, "generate", digest, run, [SHEET], work.is_complete, "generate")
    return batch.do_all([*_list_parts(target, count)], work, progress)


def count_repeats(parts: Iterable[BatchItem]) -> int:
    """How many buildings of the parts of a batch have the fingerprint of another one before them."""
    fingerprints = Counter(chain.from_iterable(part.description["fingerprints"] for part in parts if part.description))
    return fingerprints.total() - len(fingerprints)


def draw_plans(
    buildings: Sequence[nx.Graph],
    model: TypeModel,
    *,
    outline: Polygon | None = None,
    first: int = 0,
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[DrawnPlan | None]:
    """The floor of each building, whose number depends on its position and that of the first one.

    outline: in which it is drawn. track: wraps the names of the steps, to show progress.

    None for a building that cannot be drawn, which is a warning, as are doors that were given up. Raises OptionError if
    none can be drawn, or for an unforeseen fault.
    """
    from pianta.generation.drawing.draw import warn_of_missing_doors

    plans: dict[int, DrawnPlan] = {}
    faults: dict[int, Fault] = {}
    numbers = range(first, first + len(buildings))
    outcomes = run_items(_Drawing(model, seed, outline), [*zip(numbers, buildings, strict=True)], jobs=jobs)
    for _, outcome in zip(track([f"plan {number + 1}" for number in numbers]), outcomes, strict=True):
        number, _ = outcome.item
        if outcome.result is not None:
            plans[number] = outcome.result
        elif outcome.fault is not None:
            faults[number] = outcome.fault
    # Another run may draw what lacked memory, or was killed
    unforeseen = [number for number in sorted(faults) if faults[number].group in UNFORESEEN]
    if unforeseen or (faults and not plans):
        number = min(unforeseen or faults)
        raise _make_drawing_error(number, faults[number])
    for number in numbers:
        if number in faults:
            warnings.warn(BuildingWarning(_describe_undrawn(number, faults[number])), stacklevel=2)
        else:
            warn_of_missing_doors(plans[number], f"building {number + 1}")
    return [plans.get(number) for number in numbers]


def _describe_undrawn(number: int, fault: Fault) -> str:
    return f"building {number + 1} cannot be drawn: {fault.message}"


def _make_drawing_error(number: int, fault: Fault) -> OptionError:
    """The error of a building that was not drawn, with the report of an unforeseen fault as a note."""
    error = OptionError(_describe_undrawn(number, fault))
    if fault.report:
        error.add_note(fault.report)
    return error


@dataclass(frozen=True)
class _Drawing:
    """Draws a building, in a process."""

    model: TypeModel
    seed: int
    outline: Polygon | None

    def __call__(self, item: tuple[int, nx.Graph]) -> DrawnPlan:
        from pianta.generation.buildings import find_building_seed
        from pianta.generation.drawing.draw import draw_plan

        number, graph = item
        return draw_plan(graph, self.model, seed=find_building_seed(self.seed, number), outline=self.outline)


def save_buildings(
    buildings: Sequence[nx.Graph],
    names: Sequence[str],
    model: TypeModel,
    out: Path,
    *,
    plans: Sequence[DrawnPlan | None] | None = None,
    worlds: WorldOptions | None = None,
    first: int = 0,
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> None:
    """Write the graphs as NAME.json and NAME.graphml, and their contact sheet, all or none.

    plans: also NAME.geojson and NAME.png, and a contact sheet of them. The graph of a building without a plan has the
    attribute `drawn`, which is False. worlds: of the plans, also a folder NAME.
    first: number of the first building, from 0; seed: of all. track: wraps the names of the steps, to show progress.
    """
    from pianta.io.graphml import save_graphml
    from pianta.io.graphs import save_graph
    from pianta.plot.figure import save_figure
    from pianta.plot.graphs import draw_contact_sheet

    kept_rooms = [[node for node, room in building.nodes(data="room") if room is not None] for building in buildings]
    drawn_files = [PLAN_SHEET, *list_plan_files(names), *list_world_files(names)]
    floors = {} if plans is None else {name: plan.floor for name, plan in zip(names, plans, strict=True) if plan}
    with atomic_folder(out, optional=drawn_files) as new:
        for name, building in zip(names, buildings, strict=True):
            building.graph.update(source=name, building_type=model.building_type)
            if plans is not None and name not in floors:
                building.graph[HAS_PLAN] = False
            save_graph(building, new / f"{name}.json")
            save_graphml(building, new / f"{name}.graphml")
        save_figure(draw_contact_sheet(buildings, schema=model.schema, fixed=kept_rooms), new / SHEET)
        if floors:
            _save_plans(floors, model, new, track)
        if worlds is not None:
            numbered = [(number, name, floors[name]) for number, name in enumerate(names, first) if name in floors]
            save_worlds(numbered, new, worlds, seed=seed, jobs=jobs, track=track)


def list_plan_files(names: Iterable[str]) -> list[str]:
    """The files of the drawn floors of buildings."""
    return [f"{name}{suffix}" for name in names for suffix in (".geojson", ".png")]


def _save_plans(
    floors: Mapping[str, Floor], model: TypeModel, out: Path, track: Callable[[Sequence[str]], Iterable[str]]
) -> None:
    from pianta.io.floors import save_floor
    from pianta.plot.figure import save_figure
    from pianta.plot.floor import render_floor
    from pianta.plot.plan_sheet import draw_plan_sheet

    for (name, floor), _ in zip(floors.items(), track([f"picture of {name}" for name in floors]), strict=True):
        drawn_floor = replace(floor, source=name)
        save_floor(drawn_floor, out / f"{name}.geojson")
        (out / f"{name}.png").write_bytes(render_floor(drawn_floor))
    save_figure(draw_plan_sheet([*floors.values()], [*floors], schema=model.schema), out / PLAN_SHEET)


def check_parts(out: Path, count: int) -> None:
    """Raise OptionError for a folder that has buildings which are not among as many in parts, and would stay."""
    wanted = {item.folder.name: set(_name_buildings(item.value)) for item in _list_parts(out, count)}
    for folder in (out, *sorted(out.glob("part-*"))):
        others = {file.stem for file in folder.glob("building-*.json")} - wanted.get(folder.name, set())
        if others:
            fault = f"folder {short_repr(folder)} has {min(others)}, which is not among {count} buildings in parts"
            raise OptionError(f"{fault}; give as many as before, or another folder")


def refuse_parts(out: Path) -> None:
    """Raise OptionError for a folder that has buildings in parts."""
    parts = sorted(folder.name for folder in out.glob("part-*") if folder.is_dir())
    if parts:
        raise OptionError(f"folder {short_repr(out)} has buildings in parts, {parts[0]}; give another folder")


def _list_parts(out: Path, count: int) -> Iterator[WorkItem[range]]:
    parts = [range(first, min(first + PART, count)) for first in range(0, count, PART)]
    for number, part in enumerate(parts, start=1):
        yield _make_item(out, number, part)


def _name_buildings(numbers: Iterable[int]) -> list[str]:
    return [f"building-{number + 1:06}" for number in numbers]


def _is_undrawn(folder: Path, name: str) -> bool:
    """Whether a building has no floor, and its graph says so."""
    from pianta.io.graphs import read_graph

    if is_filled_file(folder / f"{name}.geojson"):
        return False
    try:
        return read_graph(folder / f"{name}.json").graph.get(HAS_PLAN) is False
    except PiantaError:
        return False


def _make_item(out: Path, number: int, part: range) -> WorkItem[range]:
    folder = out / f"part-{number:04}"
    undone = f"buildings {part[0] + 1} to {part[-1] + 1} cannot be generated"
    return WorkItem(folder.name, folder, (), str(len(part)), folder, undone, part)


def _describe_floor(floor: Floor | nx.Graph | None) -> Any:  # noqa: ANN401  # what JSON can hold
    """What distinguishes a floor from others, for the digest of options."""
    import networkx as nx

    if floor is None:
        return None
    graph = floor if isinstance(floor, nx.Graph) else floor.graph()
    return nx.node_link_data(graph, edges="edges")


@dataclass(frozen=True)
class _Work:
    """What is done for each part, in a process."""

    sampler: BuildingSampler
    seed: int
    plans: bool
    outline: Polygon | None
    worlds: WorldOptions | None
    track: Callable[[Sequence[str]], Iterable[str]]

    def __call__(self, item: WorkItem[range]) -> WorkResult:
        """Sample the buildings of a part and write them."""
        return collect_warnings(lambda: self._generate(item))

    def is_complete(self, item: WorkItem[range]) -> bool:
        """Whether all buildings of a part are there, each with content."""
        names = _name_buildings(item.value)
        graphs = [f"{name}{suffix}" for name in names for suffix in (".json", ".graphml")]
        with_plan = [name for name in names if not _is_undrawn(item.folder, name)] if self.plans else []
        plans = [PLAN_SHEET, *list_plan_files(with_plan)] if self.plans else []
        worlds = list_world_files(with_plan, scan=self.worlds.scan) if self.worlds else []
        return all(is_filled_file(item.folder / name) for name in (SHEET, *graphs, *plans, *worlds))

    def _generate(self, item: WorkItem[range]) -> dict[str, Any]:
        from pianta.evaluation.graph_sets import find_copies, find_fingerprints
        from pianta.generation.buildings import sample_numbers

        buildings = sample_numbers(self.sampler, item.value, seed=self.seed, track=self.track)
        model, names = self.sampler.model, _name_buildings(item.value)
        how: dict[str, Any] = {"first": item.value[0], "seed": self.seed, "track": self.track}
        plans = draw_plans(buildings, model, outline=self.outline, **how) if self.plans else None
        save_buildings(buildings, names, model, item.folder, plans=plans, worlds=self.worlds, **how)
        return {
            "rooms": [len(building) for building in buildings],
            "copies": find_copies(buildings, [floor.graph for floor in model.floors]),
            "fingerprints": find_fingerprints(buildings),
        }
