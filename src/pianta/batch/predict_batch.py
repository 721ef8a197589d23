"""Predict the unexplored parts of thousands of floors: a folder each, with a journal of what is done."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pianta._arguments import check_argument
from pianta.batch.inputs import expand_patterns, walk_folder
from pianta.batch.run_batch import (
    Batch,
    BatchItem,
    Progress,
    RunOptions,
    WorkItem,
    WorkResult,
    collect_warnings,
    describe_files,
    digest_options,
    name_file,
)
from pianta.errors import BuildingWarning, FloorError, GraphError, LabelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._files import is_filled_file, real_path, short_repr
from pianta.io._folders import atomic_folder, check_output_folder, number_outputs
from pianta.io.graphs import FLOOR_FILE
from pianta.reading.read import name_folders

if TYPE_CHECKING:
    import networkx as nx

    from pianta.generation.type_model import TypeModel
    from pianta.gridmap import GridMap
    from pianta.prediction.continuation.continuations import Continuations
    from pianta.prediction.prediction import Prediction
    from pianta.prediction.revealed_floor import RevealedFloor

PREDICTION = "prediction.json"
PICTURE = "picture.png"
EXPLORED = ("explored.geojson", "explored.npz")  # the explored floor and its map, for `pianta view`
PLANS = ("plan-1.geojson", "plan-2.geojson", "plan-3.geojson")  # drawn samples
PLANS_PICTURE = "plans.png"
SHARES = "shares.npz"  # of samples that are free at each cell
PLAN_FILES = (*PLANS, PLANS_PICTURE, SHARES)
GRID = "grid.npz"  # the map in a folder that `pianta read` has written


def predict_batch(
    paths: Iterable[str | Path],
    model: TypeModel,
    *,
    out: str | Path,
    count: int = 100,
    seed: int = 0,
    explored: int | None = None,
    as_printed: bool = False,
    plans: bool = False,
    jobs: int = 1,
    resume: bool = True,
    only_failed: bool = False,
    shard: str | None = None,
    time_limit: float | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Iterator[BatchItem]:
    """Predict the unexplored parts of many floors into a folder, with a journal of what is done.

    Parameters
    ----------
    paths
        Files of floors, folders of `pianta read`, folders that have such folders in them, and patterns with `*`.
    model
        Model of the building's type, from `train_type` or `load_model`.
    out
        Each floor gets a folder of its own in it, as of `pianta predict`; journal.sqlite is beside them.
    count, seed
        As of `predict`.
    explored
        Of whole floors: this many corridors are explored, the rest is predicted, and the truth is in prediction.json.
    as_printed
        As of `predict`.
    plans
        Whether samples are also drawn as floors, by `draw_continuations`: plan-1.geojson to plan-3.geojson, plans.png,
        and shares.npz.
    jobs, resume, only_failed, shard, time_limit, scheduler, progress
        As of `read_batch`.

    Returns
    -------
    iterator of BatchItem
        First what was predicted before, then each floor when it is done. `description` has the number of rooms that are
        known (`known`) and of open ends (`open_ends`), and mean, low and high of the rooms and the area of the whole
        floor (`rooms`; `area` in m², None if unknown).

    Raises
    ------
    OptionError
        As of `predict` and `read_batch`; no floor is found.

    Warns
    -----
    BuildingWarning
        Rooms of a floor have no door; the model was trained on an `explored` floor.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> for item in pianta.predict_batch(["buildings"], model, out="predicted", jobs=4):  # doctest: +SKIP
    ...     print(item.path, item.fault or item.description["rooms"]["mean"])
    """
    from pianta.generation.type_model import TypeModel
    from pianta.generation.type_model_file import dump_type_model
    from pianta.prediction.prediction import check_samples

    if isinstance(paths, str | Path):
        raise OptionError(f"paths is {short_repr(paths)}, give a list of files and folders")
    check_argument(model, (TypeModel,), "model", "a model of train_type or load_model")
    run = RunOptions(jobs, resume, only_failed, shard, time_limit, scheduler)
    check_samples(count, seed)
    if explored is not None and explored < 1:
        raise OptionError(f"explored is {explored}, give 1 corridor or more")
    files = list_floors(paths)
    target = Path(out)
    check_output_folder(target)
    options = {"count": count, "seed": seed, "explored": explored, "as_printed": as_printed, "plans": plans}
    digest = digest_options({**options, "model": dump_type_model(model).decode()})
    names = name_folders([file.parent if file.name == FLOOR_FILE else file for file in files])
    items = [_make_item(file, target / name) for file, name in zip(files, names, strict=True)]
    work = _Work(FloorPredictor(model, count, seed, explored, as_printed, plans))
    batch = Batch(target, "predict", digest, run, [PREDICTION], work.is_complete, "predict")
    return batch.do_all(items, work, progress, check=lambda item: name_samples(item.path, count, item.folder))


def name_samples(floor: Path, count: int, out: Path) -> list[str]:
    """Names of the sampled floors in the folder of a prediction.

    Raises OptionError if the folder has others, or the floor lies in it and it or its picture would be replaced.
    """
    names = number_outputs("sample", count, out)
    results = {PREDICTION, PICTURE, *EXPLORED, *PLAN_FILES, *(f"{name}.json" for name in names)}
    is_inside = real_path(floor if floor.is_dir() else floor.parent) == real_path(out)
    if is_inside and (floor.is_dir() or floor.name == FLOOR_FILE or floor.name in results):
        fault = f"floor {short_repr(floor)} is in the output folder, whose files would be replaced"
        raise OptionError(f"{fault}; give another folder")
    return names


def list_floors(paths: Iterable[str | Path]) -> list[Path]:
    """The files of floors, each once: those that are given, and each floor.geojson in folders and their subfolders.

    Raises OptionError for a pattern that nothing matches and a folder without a floor.
    """
    files: dict[Path, Path] = {}
    for path in expand_patterns(paths):
        inside = [*_list_folder(path)] if path.is_dir() else [path]
        if not inside:
            raise OptionError(f"folder {short_repr(path)} has no {FLOOR_FILE}, give one that `pianta read` has written")
        for file in inside:
            files.setdefault(real_path(file), file)
    return [*files.values()]


def _list_folder(folder: Path) -> Iterator[Path]:
    for name, _, names in walk_folder(folder):
        if FLOOR_FILE in names:
            yield name / FLOOR_FILE


def _make_item(file: Path, folder: Path) -> WorkItem[None]:
    undone = f"floor {short_repr(file)} cannot be predicted"
    return WorkItem(name_file(file), folder, (file,), describe_files([file]), file, undone, None)


@dataclass(frozen=True)
class _Work:
    """What is done for each floor, in a process."""

    predictor: FloorPredictor

    def __call__(self, item: WorkItem[None]) -> WorkResult:
        """Predict a floor and write the results."""
        return collect_warnings(lambda: self._predict(item))

    def is_complete(self, item: WorkItem[Any]) -> bool:
        """Whether all results of a floor are there, each with content."""
        samples = [f"{name}.json" for name in number_outputs("sample", self.predictor.count, None)]
        plans = PLAN_FILES[len(PLANS) :] if self.predictor.plans else ()
        return all(is_filled_file(item.folder / name) for name in (PREDICTION, PICTURE, *plans, *samples))

    def _predict(self, item: WorkItem[None]) -> dict[str, Any]:
        names = name_samples(item.path, self.predictor.count, item.folder)
        predicted = self.predictor.predict(item.path)
        predicted.save(names, item.folder)
        content = predicted.describe()
        counts = {name: len(content[name]) for name in ("known", "open_ends")}
        return {**counts, **{name: content[name] for name in ("rooms", "area")}}


@dataclass(frozen=True)
class FloorPredictor:
    """Predicts floors of files. count, seed, as_printed: as of `predict`; explored, plans: as of `predict_batch`."""

    model: TypeModel
    count: int = 100
    seed: int = 0
    explored: int | None = None
    as_printed: bool = False
    plans: bool = False

    def predict(self, path: Path) -> PredictedFloor:
        """The prediction of a floor, a file or a folder of `pianta read`, with its plans if they are wanted.

        Raises PiantaError that names the file; warns of rooms that do not count, and of a truth that the model knows.
        """
        from pianta.generation.type_model import check_model_type
        from pianta.io.graphs import read_floor_graph
        from pianta.prediction.prediction import predict

        graph = read_floor_graph(path)
        check_model_type(graph.graph.get("building_type"), self.model, f"floor {short_repr(path)}")
        try:
            truth = None if self.explored is None else _explore(graph, self.model, self.explored)
            part = truth.part if truth else graph
            prediction = predict(part, self.model, count=self.count, seed=self.seed, as_printed=self.as_printed)
            continuations = self._draw(path, prediction, truth) if self.plans else None
        except PiantaError as error:
            remedy = _find_remedy(error, self.model, self.explored)
            raise type(error)(f"floor {short_repr(path)}: {error}{remedy}") from error
        _warn(graph, truth, self.model, path)
        return PredictedFloor(path, prediction, truth, self.model, continuations)

    def _draw(self, path: Path, prediction: Prediction, truth: RevealedFloor | None) -> Continuations:
        """The drawn samples. Raises FloorError for a floor without outlines."""
        from pianta.prediction.continuation.continuations import draw_continuations

        floor, grid = _read_outlines(path)
        if not floor.rooms:
            raise FloorError(
                "it has no outlines of rooms, which plans need; give floor.geojson, or leave out plans=True"
            )
        observed_map = grid if truth is None else None
        return draw_continuations(prediction, floor, model=self.model, grid=observed_map, truth=truth, seed=self.seed)


@dataclass(frozen=True)
class PredictedFloor:
    """A floor of a file with its prediction, the truth if it was a whole floor, and its drawn samples if wanted."""

    path: Path
    prediction: Prediction
    truth: RevealedFloor | None
    model: TypeModel
    continuations: Continuations | None = None

    def describe(self) -> dict[str, Any]:
        """The content of the file of the prediction."""
        from pianta.prediction.prediction_file import describe_prediction

        building_type = self.model.building_type
        return describe_prediction(self.prediction, building_type, truth=self.truth, plans=self._describe_plans())

    def save(self, names: Sequence[str], out: Path) -> None:
        """Write the prediction, its picture, the samples by name, plans, and the known part if any, all or none."""
        from pianta.io.floors import save_floor
        from pianta.io.graphs import save_graph
        from pianta.plot.figure import save_figure
        from pianta.plot.prediction import draw_prediction
        from pianta.prediction.prediction_file import name_rooms, save_content

        explored, grid = self._read_known_part()
        with atomic_folder(out, optional=[*EXPLORED, *PLAN_FILES]) as new:
            save_content(self.describe(), new / PREDICTION)
            save_figure(draw_prediction(self.prediction, truth=self.truth), new / PICTURE)
            if explored.rooms:
                save_floor(explored, new / EXPLORED[0])
                if grid is not None:
                    grid.save(new / EXPLORED[1])
            if self.continuations is not None:
                self._save_plans(self.continuations, new)
            for name, sample in zip(names, self.prediction.samples, strict=True):
                graph = name_rooms(sample, self.prediction)
                graph.graph.update(source=name, building_type=self.model.building_type)
                save_graph(graph, new / f"{name}.json")

    def _describe_plans(self) -> dict[str, Any] | None:
        """What the file of the prediction has of the plans."""
        from pianta.prediction.prediction_file import describe_plans

        return None if self.continuations is None else describe_plans(self.continuations, PLANS, SHARES)

    def _save_plans(self, continuations: Continuations, new: Path) -> None:
        """Write the drawn samples, their picture and the shares."""
        from pianta.io.floors import save_floor
        from pianta.plot.continuations import draw_continuations_picture
        from pianta.plot.figure import save_figure

        for name, plan in zip(PLANS, continuations.plans, strict=False):
            save_floor(replace(plan.floor, source=name.removesuffix(".geojson")), new / name)
        _, grid = self._read_known_part()
        samples = len(self.prediction.samples)
        save_figure(
            draw_continuations_picture(continuations, schema=self.model.schema, grid=grid, samples=samples),
            new / PLANS_PICTURE,
        )
        continuations.grid.save(new / SHARES)

    def _read_known_part(self) -> tuple[Floor, GridMap | None]:
        """The rooms that are known or behind open doors, and their map; without rooms if the file has no outlines."""
        floor, grid = _read_outlines(self.path)
        if self.truth is None:
            return floor, grid
        # Nothing of what is not explored; its map would show that.
        names = {name for _, name in self.prediction.explored.graph.nodes(data="room")}
        rooms = tuple(room for room in floor.rooms if room.id in names)
        doors = tuple(door for door in floor.doors if {room.id for room in rooms}.issuperset(door.room_ids))
        return replace(floor, rooms=rooms, doors=doors, walls=(), furniture=(), possible_doors=()), None


def _read_outlines(path: Path) -> tuple[Floor, GridMap | None]:
    """The floor of a file or a folder of `pianta read`, and its map if any; without rooms if it has no outlines."""
    from pianta.io.buildings.read import read_building
    from pianta.io.maps import read_npz_map

    file = path / FLOOR_FILE if path.is_dir() else path
    try:
        with warnings.catch_warnings():
            # The graph was read from it with the same warnings.
            warnings.simplefilter("ignore", BuildingWarning)
            floor = read_building(file)
    except PiantaError:
        return Floor(()), None
    grid = file.parent / GRID
    return floor, read_npz_map(grid) if file.name == FLOOR_FILE and grid.is_file() else None


def _explore(graph: nx.Graph, model: TypeModel, corridors: int) -> RevealedFloor:
    from pianta.prediction.revealed_floor import reveal_corridors

    return reveal_corridors(graph, model.schema, corridors=corridors)


def _find_remedy(error: PiantaError, model: TypeModel, explored: int | None) -> str:
    """A remedy to append: for a floor without labels of the type, and for a floor that is explored completely."""
    if isinstance(error, LabelError):
        return f"; `pianta read --type {model.building_type}` labels a map so"
    is_complete = isinstance(error, GraphError) and "nothing to predict" in str(error)
    if is_complete and explored is None:
        return "; to try it on a whole floor give explored=K"
    remedy = "give a smaller explored=" if explored and explored > 1 else "leave out this floor"
    return f"; {remedy}" if is_complete else ""


def _warn(graph: nx.Graph, truth: RevealedFloor | None, model: TypeModel, floor: Path) -> None:
    """Warn of rooms that do not count, and of a truth that is a training floor of the model."""
    from pianta.evaluation.graph_sets import find_copies
    from pianta.graphs.labelled_graphs import name_some

    messages = []
    if alone := [node for node, doors in graph.degree if not doors]:
        messages.append(f"floor {short_repr(floor)}: rooms {name_some(alone)} have no door and are left out")
    if truth and any(find_copies([truth.graph], [training_floor.graph for training_floor in model.floors])):
        trained = f"the model was trained on floor {short_repr(floor)} too"
        messages.append(f"{trained}, so this is no test; train one without it")
    for message in messages:
        warnings.warn(BuildingWarning(message), stacklevel=3)
