"""The verb predict: what probably lies beyond the explored part of a floor."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, make_table, print_result, print_table, stderr
from pianta.errors import BuildingWarning, GraphError, LabelError, PiantaError
from pianta.floor import Floor
from pianta.io._files import count_noun, short_repr
from pianta.io._folders import atomic_folder, number_outputs

if TYPE_CHECKING:
    import networkx as nx

    from pianta.generation.type_model import TypeModel
    from pianta.gridmap import GridMap
    from pianta.prediction.prediction import OpenEnd, Prediction, SampleInterval
    from pianta.prediction.revealed_floor import RevealedFloor

EXAMPLES = (
    "pianta predict explored school.json",
    "pianta predict explored/floor.geojson school.json -n 500 -o predicted",
    "pianta predict school.xml others.json --explored 3 -o predicted",
)
PREDICTION = "prediction.json"
PICTURE = "picture.png"
# The explored floor and its map, for `pianta view`.
EXPLORED_STEM = "explored"
# The map in a folder that `pianta read` has written.
GRID = "grid.npz"
MAX_COUNT = 10_000
# Labels of an open end that are printed.
MAX_LABELS = 3

FloorFile = Annotated[Path, typer.Argument(metavar="FLOOR", help="A partly explored floor.")]
Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model of its building type, of `pianta train type`.")]
Count = Annotated[int, typer.Option("--count", "-n", help="How many floors to sample.", min=1, max=MAX_COUNT)]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for prediction, picture and samples.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same prediction.")]
Explored = Annotated[
    int | None,
    typer.Option(metavar="K", help="For a whole FLOOR: explore K corridors, predict the rest, and compare.", min=1),
]
Printed = Annotated[
    bool, typer.Option("--as-printed", help="Sample as section 8.3 of the thesis is printed, to compare.")
]


def predict_floor(
    floor: FloorFile,
    model: Model,
    *,
    count: Count = 100,
    out: Out = None,
    seed: Seed = 0,
    explored: Explored = None,
    as_printed: Printed = False,
    json_file: Json = None,
    quiet: Quiet = False,
) -> None:
    """Predict what lies behind unopened doors and along open corridors of a floor.

    FLOOR is a folder of `pianta read --type`, or a floor.geojson, layout XML,
    graph.json or GraphML whose rooms have labels of the type. It continues at its
    partial rooms: a partial corridor is open; another partial room, if little of
    it was seen, has an unknown label.

    With -o writes prediction.json, picture.png, and each sampled floor,
    sample-001.json (networkx node-link) and so on, in which known rooms have
    their ids as `room`. If FLOOR has outlines, `pianta view` draws the
    prediction over explored.geojson and, of a map, explored.npz.
    """
    from pianta.generation.type_model import check_model_type
    from pianta.generation.type_model_file import read_type_model
    from pianta.io.graphs import read_floor_graph
    from pianta.prediction.prediction import predict
    from pianta.prediction.prediction_file import describe_prediction

    quiet = check_json(json_file, quiet=quiet)
    names = number_outputs("sample", count, out)
    type_model, graph = read_type_model(model), read_floor_graph(floor)
    check_model_type(graph.graph.get("building_type"), type_model, f"floor {short_repr(floor)}")
    try:
        truth = None if explored is None else _explore(graph, type_model, explored)
        with nullcontext() if quiet else stderr.status(f"sampling {count} floors"):
            prediction = predict(
                truth.part if truth else graph, type_model, count=count, seed=seed, as_printed=as_printed
            )
    except PiantaError as error:
        remedy = _find_remedy(error, type_model, explored)
        raise type(error)(f"floor {short_repr(floor)}: {error}{remedy}") from error
    _warn(graph, truth, type_model, floor)
    if out is not None:
        save_outputs(
            prediction, names, type_model, out, truth=truth, explored=read_known_part(floor, prediction, truth)
        )
    if json_file is not None:
        write_json(describe_prediction(prediction, type_model.building_type, truth=truth), json_file)
    if not quiet:
        _print_prediction(prediction, truth)
        if out is not None:
            print_result(f"in {out}: {PREDICTION}, {PICTURE}, sample-*.json")


def read_known_part(path: Path, prediction: Prediction, truth: RevealedFloor | None) -> tuple[Floor, GridMap | None]:
    """The rooms of a file that are known or behind open doors, and their map; without rooms if it has no outlines."""
    from pianta.io.buildings.read import read_building
    from pianta.io.graphs import FLOOR_FILE
    from pianta.io.maps import read_npz_map

    file = path / FLOOR_FILE if path.is_dir() else path
    try:
        with warnings.catch_warnings():
            # The graph was read from it with the same warnings.
            warnings.simplefilter("ignore", BuildingWarning)
            floor = read_building(file)
    except PiantaError:
        return Floor(()), None
    if truth is not None:
        # Nothing of what is not explored; its map would show that.
        names = {name for _, name in prediction.explored.graph.nodes(data="room")}
        rooms = tuple(room for room in floor.rooms if room.id in names)
        doors = tuple(door for door in floor.doors if {room.id for room in rooms}.issuperset(door.room_ids))
        return replace(floor, rooms=rooms, doors=doors, walls=(), furniture=(), possible_doors=()), None
    grid = file.parent / GRID
    return floor, read_npz_map(grid) if file.name == FLOOR_FILE and grid.is_file() else None


def save_outputs(
    prediction: Prediction,
    names: Sequence[str],
    model: TypeModel,
    out: Path,
    *,
    truth: RevealedFloor | None = None,
    explored: tuple[Floor, GridMap | None] | None = None,
) -> None:
    """Write the prediction, its picture, the samples by name, and the known rooms and map if any, all or none."""
    from pianta.io.floors import save_floor
    from pianta.io.graphs import save_graph
    from pianta.plot.figure import save_figure
    from pianta.plot.prediction import draw_prediction
    from pianta.prediction.prediction_file import name_rooms, save_prediction

    with atomic_folder(out) as new:
        save_prediction(prediction, new / PREDICTION, building_type=model.building_type, truth=truth)
        save_figure(draw_prediction(prediction, truth=truth), new / PICTURE)
        if explored is not None and explored[0].rooms:
            save_floor(explored[0], new / f"{EXPLORED_STEM}.geojson")
            if explored[1] is not None:
                explored[1].save(new / f"{EXPLORED_STEM}.npz")
        for name, sample in zip(names, prediction.samples, strict=True):
            graph = name_rooms(sample, prediction)
            graph.graph.update(source=name, building_type=model.building_type)
            save_graph(graph, new / f"{name}.json")


def _explore(graph: nx.Graph, model: TypeModel, corridors: int) -> RevealedFloor:
    from pianta.prediction.revealed_floor import reveal_corridors

    return reveal_corridors(graph, model.schema, corridors=corridors)


def _find_remedy(error: PiantaError, model: TypeModel, explored: int | None) -> str:
    """A remedy to append: for a floor without labels of the type, and for a floor that is explored completely."""
    if isinstance(error, LabelError):
        return f"; `pianta read --type {model.building_type}` labels a map so"
    is_complete = isinstance(error, GraphError) and "nothing to predict" in str(error)
    if is_complete and explored is None:
        return "; to try it on a whole floor give --explored K"
    return "; give a smaller --explored" if is_complete else ""


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
        warnings.warn(BuildingWarning(message), stacklevel=2)


def _print_prediction(prediction: Prediction, truth: RevealedFloor | None) -> None:
    """Print the size of the floor, the rooms behind each open end, and the unknown rooms by label."""
    known_rooms = count_noun(len(prediction.explored.known_graph), "room")
    open_ends = count_noun(len(prediction.ends), "open end")
    print_result(f"{known_rooms} known, {open_ends}, {len(prediction.samples)} floors sampled")
    size = f"the whole floor: {_describe_spread(prediction.rooms)} rooms"
    if prediction.area:
        size += f", {_describe_spread(prediction.area)} m²"
    if truth:
        size += f"; in truth {len(truth.graph)} rooms" + (f", {truth.area:.0f} m²" if truth.area else "")
    print_result(size)
    print_table(tabulate_ends(prediction, truth))
    print_table(tabulate_unknown(prediction, truth))
    print_result("8 (2–15): mean, and the interval of four of five samples; leads on: to unknown corridors")


def tabulate_ends(prediction: Prediction, truth: RevealedFloor | None = None) -> Table:
    """Table of the open ends: where, the most probable labels, how many rooms are nearest to it, and their area."""
    rooms = dict(prediction.explored.graph.nodes(data="room"))
    labels = {rooms[node]: label for node, label in prediction.explored.graph.nodes(data="label")}
    ends = prediction.ends
    true_labels = {door: truth.graph.nodes[room]["label"] for door, room in truth.behind.items()} if truth else {}
    columns = {
        "open end": [f"door {end.room}" if end.is_door else f"corridor {end.room}" for end in ends],
        "of": [f"{end.near} {labels[end.near]}" if end.is_door else "" for end in ends],
        "behind": [_describe_labels(end) for end in ends],
        "leads on": [f"{100 * end.leads_on:.0f} %" for end in ends],
        "rooms": [_describe_spread(end.rooms) for end in ends],
        "m²": [_describe_spread(end.area) if end.area else "" for end in ends],
        "true": [true_labels.get(end.room, "") for end in ends],
    }
    return make_table(columns, left=("open end", "of", "behind", "true"), wrapped=("behind",))


def tabulate_unknown(prediction: Prediction, truth: RevealedFloor | None = None) -> Table:
    """Table of the expected unknown rooms by label."""
    true_counts = truth.counts if truth else {}
    counts = prediction.counts
    names = [*counts, *(label for label in true_counts if label not in counts)]
    columns = {
        "unknown rooms": names,
        "expected": [_describe_spread(counts[name], digits=1) if name in counts else "0" for name in names],
        "true": [str(true_counts.get(name, 0)) if truth else "" for name in names],
    }
    return make_table(columns, left=("unknown rooms",))


def _describe_labels(end: OpenEnd) -> str:
    shares = [f"{label} {100 * share:.0f} %" for label, share in end.labels.items()]
    return ", ".join(shares[:MAX_LABELS]) or "nothing"


def _describe_spread(spread: SampleInterval, *, digits: int = 0) -> str:
    return f"{spread.mean:.{digits}f} ({spread.low:.0f}–{spread.high:.0f})"
