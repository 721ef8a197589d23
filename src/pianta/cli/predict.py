"""The verb predict: what probably lies beyond the explored part of a floor."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.console import JustifyMethod
from rich.markup import escape
from rich.table import Table

from pianta.cli.terminal import stderr, stdout, tell_result
from pianta.errors import BuildingWarning, GraphError, LabelError, PiantaError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_leftovers, check_output_folder

if TYPE_CHECKING:
    import networkx as nx

    from pianta.generation.type_model import TypeModel
    from pianta.prediction.prediction import OpenEnd, Prediction, SampleInterval
    from pianta.prediction.revealed_floor import RevealedFloor

EXAMPLES = (
    "pianta predict explored school.json",
    "pianta predict explored/floor.geojson school.json -n 500 -o predicted",
    "pianta predict school.xml others.json --explored 3 -o predicted",
)
PREDICTION, PICTURE = "prediction.json", "picture.png"
MAX_COUNT = 10_000
# Labels of an open end that are printed.
MOST_PROBABLE = 3

Floor = Annotated[Path, typer.Argument(metavar="FLOOR", help="A floor that is explored in part.")]
Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model of its building type, of `pianta train type`.")]
Count = Annotated[int, typer.Option("--count", "-n", help="How many floors are sampled.", min=1, max=MAX_COUNT)]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for prediction, picture and samples.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same prediction.")]
Explored = Annotated[
    int | None,
    typer.Option(metavar="K", help="FLOOR is a whole one: explore its first K corridors, predict, and compare.", min=1),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


def predict_floor(
    floor: Floor,
    model: Model,
    *,
    count: Count = 100,
    out: Out = None,
    seed: Seed = 0,
    explored: Explored = None,
    quiet: Quiet = False,
) -> None:
    """Tell what probably lies behind unopened doors and along open corridors of a floor.

    FLOOR is a folder of `pianta read --type`, or a floor.geojson, layout XML, graph.json or
    GraphML whose rooms have labels of the type. Rooms that were seen in part are where it
    goes on: a corridor is open; another room, if little was seen of it, is unknown.

    With -o writes prediction.json, picture.png, and each sampled floor, sample-001.json
    (networkx node-link) and so on, in which known rooms have their ids as `room`.
    """
    from pianta.generation.type_model_file import read_type_model
    from pianta.io.graphs import read_floor_graph
    from pianta.prediction.prediction import check_model_type, predict

    names = [f"sample-{number:0{max(3, len(str(count)))}}" for number in range(1, count + 1)]
    if out is not None:
        check_output_folder(out)
        check_leftovers(out, names, stem="sample")
    known, graph = read_type_model(model), read_floor_graph(floor)
    check_model_type(graph.graph.get("building_type"), known, f"floor {short_repr(floor)}")
    try:
        truth = None if explored is None else _explore(graph, known, explored)
        with nullcontext() if quiet else stderr.status(f"sampling {count} floors"):
            prediction = predict(truth.part if truth else graph, known, count=count, seed=seed)
    except PiantaError as error:
        raise type(error)(f"floor {short_repr(floor)}: {error}{_find_remedy(error, known, explored)}") from error
    _warn(graph, truth, known, floor)
    if out is not None:
        save_outputs(prediction, names, known, out, truth=truth)
    if not quiet:
        _tell_prediction(prediction, truth)
        if out is not None:
            tell_result(f"in {out}: {PREDICTION}, {PICTURE}, sample-*.json")


def save_outputs(
    prediction: Prediction, names: Sequence[str], model: TypeModel, out: Path, *, truth: RevealedFloor | None = None
) -> None:
    """Write the prediction, its picture and the samples by name, all or none."""
    from pianta.io.graphs import save_graph
    from pianta.plot.prediction import save_prediction_picture
    from pianta.prediction.prediction_file import name_rooms, save_prediction

    with atomic_folder(out) as new:
        save_prediction(prediction, new / PREDICTION, building_type=model.building_type, truth=truth)
        save_prediction_picture(prediction, new / PICTURE, truth=truth)
        for name, sample in zip(names, prediction.samples, strict=True):
            graph = name_rooms(sample, prediction)
            graph.graph.update(source=name, building_type=model.building_type)
            save_graph(graph, new / f"{name}.json")


def _explore(graph: nx.Graph, model: TypeModel, corridors: int) -> RevealedFloor:
    from pianta.prediction.revealed_floor import reveal_corridors

    return reveal_corridors(graph, model.schema, corridors=corridors)


def _find_remedy(error: PiantaError, model: TypeModel, explored: int | None) -> str:
    """What else may help: of a reading without labels of the type, and of a floor that is known as a whole."""
    if isinstance(error, LabelError):
        return f"; `pianta read --type {model.building_type}` labels a map so"
    is_whole = isinstance(error, GraphError) and "nothing to predict" in str(error)
    if is_whole and explored is None:
        return "; to try it on a whole floor give --explored K"
    return "; give a smaller --explored" if is_whole else ""


def _warn(graph: nx.Graph, truth: RevealedFloor | None, model: TypeModel, floor: Path) -> None:
    """Tell of rooms that do not count, and of a truth that the model has seen."""
    from pianta.evaluation.graph_sets import find_copies
    from pianta.graphs.labelled_graphs import name_some

    if alone := [node for node, doors in graph.degree if not doors]:
        message = f"floor {short_repr(floor)}: rooms {name_some(alone)} have no door and are left out"
        warnings.warn(BuildingWarning(message), stacklevel=2)
    if truth and any(find_copies([truth.graph], [known.graph for known in model.floors])):
        message = f"the model was trained on floor {short_repr(floor)} too, so this is no test; train one without it"
        warnings.warn(BuildingWarning(message), stacklevel=2)


def _tell_prediction(prediction: Prediction, truth: RevealedFloor | None) -> None:
    """Print the size of the floor, what lies behind each open end, and the unknown rooms by label."""
    explored = prediction.explored
    known, ends = len(explored.known_graph), len(prediction.ends)
    tell_result(f"{_count(known, 'room')} known, {_count(ends, 'open end')}, {len(prediction.samples)} floors sampled")
    size = f"the whole floor: {_describe_spread(prediction.rooms)} rooms"
    if prediction.area:
        size += f", {_describe_spread(prediction.area)} m²"
    if truth:
        size += f"; in truth {len(truth.graph)} rooms" + (f", {truth.area:.0f} m²" if truth.area else "")
    tell_result(size)
    stdout.print(tabulate_ends(prediction, truth))
    stdout.print(tabulate_unknown(prediction, truth))


def tabulate_ends(prediction: Prediction, truth: RevealedFloor | None = None) -> Table:
    """Table of the open ends: where, the most probable labels, how many rooms lie nearest to it and of which area."""
    rooms = dict(prediction.explored.graph.nodes(data="room"))
    labels = {rooms[node]: label for node, label in prediction.explored.graph.nodes(data="label")}
    ends = prediction.ends
    true = {door: truth.graph.nodes[room]["label"] for door, room in truth.behind.items()} if truth else {}
    columns = {
        "open end": [f"door {end.room}" if end.is_door else f"corridor {end.room}" for end in ends],
        "of": [f"{end.near} {labels[end.near]}" if end.is_door else "" for end in ends],
        "behind": [_describe_labels(end) for end in ends],
        "leads on": [f"{100 * end.leads_on:.0f} %" for end in ends],
        "rooms": [_describe_spread(end.rooms) for end in ends],
        "m²": [_describe_spread(end.area) if end.area else "" for end in ends],
        "true": [true.get(end.room, "") for end in ends],
    }
    return _make_table(columns, words=("open end", "of", "behind", "true"))


def tabulate_unknown(prediction: Prediction, truth: RevealedFloor | None = None) -> Table:
    """Table of the unknown rooms that are expected, by label."""
    true = truth.counts if truth else {}
    names = [*prediction.counts, *(label for label in true if label not in prediction.counts)]
    columns = {
        "unknown rooms": names,
        "expected": [
            _describe_spread(prediction.counts[name], digits=1) if name in prediction.counts else "0" for name in names
        ],
        "true": [str(true.get(name, 0)) if truth else "" for name in names],
    }
    return _make_table(columns, words=("unknown rooms",))


def _make_table(columns: Mapping[str, Sequence[str]], *, words: Sequence[str]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    told = {name: cells for name, cells in columns.items() if any(cells)}
    for name in told:
        justify: JustifyMethod = "left" if name in words else "right"
        table.add_column(name, justify=justify, no_wrap=name != "behind", overflow="fold")
    for row in zip(*told.values(), strict=True):
        # Names come from files.
        table.add_row(*map(escape, row))
    return table


def _describe_labels(end: OpenEnd) -> str:
    shares = [f"{label} {100 * share:.0f} %" for label, share in end.labels.items()]
    return ", ".join(shares[:MOST_PROBABLE]) or "nothing"


def _describe_spread(spread: SampleInterval, *, digits: int = 0) -> str:
    return f"{spread.mean:.{digits}f} ({spread.low:.0f}–{spread.high:.0f})"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
