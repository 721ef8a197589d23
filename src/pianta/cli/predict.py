"""The verb predict: what probably lies beyond the explored part of a floor."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from pianta.batch.inputs import is_collection
from pianta.batch.predict_batch import (
    PICTURE,
    PLANS,
    PLANS_PICTURE,
    PREDICTION,
    SHARES,
    FloorPredictor,
    name_samples,
    predict_batch,
)
from pianta.batch.run_batch import BatchItem
from pianta.cli.batches import (
    BatchFlags,
    BatchWords,
    Jobs,
    Resume,
    RetryFailed,
    Scheduler,
    Shard,
    TimeLimit,
    exit_if_any_failed,
    refuse_batch,
    run_batch,
)
from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, make_table, print_result, print_table, stderr
from pianta.errors import OptionError
from pianta.io._files import count_noun
from pianta.io._folders import number_outputs
from pianta.io.graphs import FLOOR_FILE

if TYPE_CHECKING:
    from pianta.prediction.continuation.continuations import Continuations
    from pianta.prediction.prediction import OpenEnd, Prediction, SampleInterval
    from pianta.prediction.revealed_floor import RevealedFloor

EXAMPLES = (
    "pianta predict explored school.json",
    "pianta predict explored/floor.geojson school.json -n 500 -o predicted",
    "pianta predict explored school.json -o predicted --plans",
    "pianta predict buildings school.json -o predicted --jobs 4",
    "pianta predict school.xml others.json --explored 3 -o predicted",
)
PREDICTED = BatchWords("floor", "predicted", "predicts")
MAX_COUNT = 10_000
# Labels of an open end that are printed.
MAX_LABELS = 3

Floors = Annotated[list[str], typer.Argument(metavar="FLOOR", help="A partly explored floor, or several.")]
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
Plans = Annotated[bool, typer.Option("--plans", help="Draw samples as floors behind the open ends, too; needs -o.")]


def predict_floor(
    floors: Floors,
    model: Model,
    *,
    count: Count = 100,
    out: Out = None,
    seed: Seed = 0,
    explored: Explored = None,
    as_printed: Printed = False,
    plans: Plans = False,
    jobs: Jobs = 1,
    resume: Resume = True,
    retry_failed: RetryFailed = False,
    shard: Shard = None,
    time_limit: TimeLimit = None,
    scheduler: Scheduler = None,
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

    With --plans also draws the samples in the free space behind the open ends:
    three that stand for all, plan-1.geojson and so on and plans.png, and
    shares.npz, the share of samples that have free space, wall or outside at
    each cell. FLOOR must have outlines.

    Several floors get a folder each in OUT, as do those in a folder that `pianta
    read` has filled. If one cannot be predicted, the others still are; the exit
    code is then 1. Floors that the journal in OUT has are not predicted again.
    """
    from pianta.generation.type_model_file import read_type_model

    quiet = check_json(json_file, quiet=quiet)
    flags = BatchFlags(jobs, resume, retry_failed, shard, time_limit, scheduler)
    predictor = FloorPredictor(read_type_model(model), count, seed, explored, as_printed, plans)
    if plans and out is None:
        raise OptionError("plans have files, give a folder for them with -o")
    if len(floors) > 1 or flags.batch_only or _is_collection(floors[0]):
        if out is None:
            raise OptionError("several floors have results each, give a folder for them with -o")
        _predict_several(floors, predictor, out, flags, json_file, quiet=quiet)
        return
    floor = Path(floors[0])
    if out is not None:
        refuse_batch(out, floors[0])
    names = number_outputs("sample", count, None) if out is None else name_samples(floor, count, out)
    with nullcontext() if quiet else stderr.status(f"sampling {count} floors"):
        predicted = predictor.predict(floor)
    prediction, truth = predicted.prediction, predicted.truth
    if out is not None:
        predicted.save(names, out)
    if json_file is not None:
        write_json(predicted.describe(), json_file)
    if not quiet:
        _print_prediction(prediction, truth)
        if predicted.continuations is not None:
            print_result(_describe_plans(predicted.continuations))
        if out is not None:
            listed = f", {PLANS[0]} …, {PLANS_PICTURE}, {SHARES}" if plans else ""
            print_result(f"in {out}: {PREDICTION}, {PICTURE}, sample-*.json{listed}")


def _is_collection(path: str) -> bool:
    """Whether a path stands for several floors: a pattern, or a folder that is not that of one floor."""
    return is_collection(path) and not (Path(path) / FLOOR_FILE).is_file()


def _predict_several(
    floors: Sequence[str],
    predictor: FloorPredictor,
    out: Path,
    flags: BatchFlags,
    json_file: Path | None,
    *,
    quiet: bool,
) -> None:
    """Predict each floor that the journal does not have; the exit code is 1 if any has failed."""
    items = run_batch(
        lambda bar: predict_batch(
            floors,
            predictor.model,
            out=out,
            count=predictor.count,
            seed=predictor.seed,
            explored=predictor.explored,
            as_printed=predictor.as_printed,
            plans=predictor.plans,
            progress=bar.move,
            **flags.arguments,
        ),
        PREDICTED,
        lambda item: [_describe_item(item)],
        quiet=quiet,
    )
    described = sorted((item for item in items if item.description), key=lambda item: item.path)
    files = [{"path": str(item.path), "folder": str(item.folder), **item.description} for item in described]
    write_json({"files": files}, json_file)
    exit_if_any_failed(items)


def _describe_item(item: BatchItem) -> str:
    """A line for a floor of several."""
    content = item.description
    rooms = "{mean:.0f} ({low:.0f}–{high:.0f})".format_map(content["rooms"])
    ends = count_noun(content["open_ends"], "open end")
    return (
        f"{item.path}: {count_noun(content['known'], 'room')} known, {ends}, {rooms} rooms expected, in {item.folder}"
    )


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


def _describe_plans(continuations: Continuations) -> str:
    rooms, doors = (f"{100 * share:.0f} %" for share in (continuations.placed, continuations.doors))
    return f"plans: space for {rooms} of the unknown rooms of all samples, and walls for {doors} of their doors"


def _describe_labels(end: OpenEnd) -> str:
    shares = [f"{label} {100 * share:.0f} %" for label, share in end.labels.items()]
    return ", ".join(shares[:MAX_LABELS]) or "nothing"


def _describe_spread(spread: SampleInterval, *, digits: int = 0) -> str:
    return f"{spread.mean:.{digits}f} ({spread.low:.0f}–{spread.high:.0f})"
