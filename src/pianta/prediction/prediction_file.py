"""The file of a prediction: JSON with the expected rooms behind each open end and of the whole floor."""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import networkx as nx
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.errors import DataError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.io._files import atomic_file
from pianta.prediction.continuation.continuations import Continuations
from pianta.prediction.prediction import OpenEnd, Prediction, SampleInterval
from pianta.prediction.revealed_floor import RevealedFloor
from pianta.prediction.unexplored_part import SampledFloor

FORMAT: Final = FileFormat("pianta prediction", 1)
MAX_FILE_BYTES: Final = 64 * 2**20
# Decimals of probabilities, shares and m².
DIGITS = 4


def save_prediction(
    prediction: Prediction, path: str | Path, *, building_type: str, truth: RevealedFloor | None = None
) -> None:
    """Write a prediction; equal predictions give equal bytes.

    truth: is added to the file. Raises PiantaError if the file cannot be written.
    """
    save_content(describe_prediction(prediction, building_type, truth=truth), path)


def save_content(content: Mapping[str, Any], path: str | Path) -> None:
    """Write what describe_prediction has described. Raises PiantaError if the file cannot be written."""
    with atomic_file(path) as temporary:
        temporary.write_text(
            json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8"
        )


def describe_prediction(
    prediction: Prediction,
    building_type: str,
    *,
    truth: RevealedFloor | None = None,
    plans: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The content of the file of a prediction, with a truth and plans if there are; areas in m²."""
    content = _describe(prediction, building_type)
    if plans is not None:
        content["plans"] = plans
    return content if truth is None else {**content, "truth": _describe_truth(truth)}


def describe_plans(continuations: Continuations, names: Sequence[str], grid: str) -> dict[str, Any]:
    """Drawn samples in the file of a prediction; names: of their files; grid: of that of the shares."""
    floors = [
        {
            "file": name,
            "sample": plan.sample + 1,
            "share": round(plan.share, DIGITS),
            "unplaced": plan.unplaced,
            "given_up": plan.given_up,
        }
        for name, plan in zip(names, continuations.plans, strict=False)
    ]
    rows, columns = continuations.grid.free.shape
    frame = {
        "resolution": continuations.grid.resolution,
        "origin": [*continuations.grid.origin],
        "shape": [rows, columns],
    }
    placed, doors = round(continuations.placed, DIGITS), round(continuations.doors, DIGITS)
    return {"floors": floors, "rooms_placed": placed, "doors_drawn": doors, "grid": {"file": grid, **frame}}


def name_rooms(sample: SampledFloor, prediction: Prediction) -> nx.Graph:
    """A sampled floor with the names of known rooms as `room`, and of unknown rooms behind doors as `door`."""
    names = dict(prediction.explored.graph.nodes(data="room"))
    graph: nx.Graph = sample.graph.copy()
    for node, sampled in sample.known_nodes.items():
        graph.nodes[sampled]["room"] = names[node]
    # Two doors may lead to the same room, which then has the name of the first.
    for door, sampled in sample.behind.items():
        graph.nodes[sampled].setdefault("door", names[door])
    return graph


def _describe(prediction: Prediction, building_type: str) -> dict[str, Any]:
    """The content of the file of a prediction; areas in m²."""
    explored = prediction.explored
    names = dict(explored.graph.nodes(data="room"))
    return {
        **FORMAT.header,
        "source": explored.source,
        "building_type": building_type,
        "samples": len(prediction.samples),
        "known": [names[node] for node in explored.known_graph],
        "rooms": _describe_interval(prediction.rooms),
        "area": _describe_interval(prediction.area),
        "unknown": {label: _describe_interval(interval) for label, interval in prediction.counts.items()},
        "shares": _round(prediction.shares),
        "average": _round(prediction.average),
        "open_ends": [_describe_end(end) for end in prediction.ends],
        "skeleton": _describe_skeleton(prediction.skeleton),
    }


def _describe_end(end: OpenEnd) -> dict[str, Any]:
    """An open end in the file of a prediction; area in m²."""
    return {
        "kind": "door" if end.is_door else "corridor",
        "room": end.room,
        "near": end.near,
        "labels": {label: share for label, share in _round(end.labels).items() if share},
        "leads_on": round(end.leads_on, DIGITS),
        "rooms": _describe_interval(end.rooms),
        "area": _describe_interval(end.area),
    }


def _describe_skeleton(skeleton: nx.Graph) -> dict[str, Any]:
    """Node-link data; nodes are numbers, because names can be of any type."""
    numbers = {node: number for number, node in enumerate(skeleton)}
    numbered = nx.Graph()
    for node, probability in skeleton.nodes(data="probability"):
        room, beyond = (node[1], True) if isinstance(node, tuple) else (node, False)
        numbered.add_node(numbers[node], room=room, beyond=beyond, probability=round(probability, DIGITS))
    for one, other, probability in skeleton.edges(data="probability"):
        numbered.add_edge(numbers[one], numbers[other], probability=round(probability, DIGITS))
    data: dict[str, Any] = nx.node_link_data(numbered, edges="edges")
    return data


def _describe_truth(truth: RevealedFloor) -> dict[str, Any]:
    """The true floor in the file of a prediction: its rooms, unknown ones by label, and those behind doors."""
    labels = dict(truth.graph.nodes(data="label"))
    behind: list[dict[str, Hashable]] = [
        {"door": door, "room": room, "label": labels[room]} for door, room in truth.behind.items()
    ]
    area = None if truth.area is None else round(truth.area, DIGITS)
    return {"rooms": len(truth.graph), "area": area, "unknown": dict(truth.counts), "behind": behind}


def _describe_interval(interval: SampleInterval | None) -> dict[str, float] | None:
    return None if interval is None else _round({"mean": interval.mean, "low": interval.low, "high": interval.high})


def _round(figures: Mapping[str, float]) -> dict[str, float]:
    return {name: round(figure, DIGITS) for name, figure in figures.items()}


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)


Share = Annotated[FiniteFloat, Field(ge=0, le=1)]


class SavedInterval(_Part):
    """A SampleInterval."""

    mean: FiniteFloat
    low: FiniteFloat
    high: FiniteFloat


class SavedEnd(_Part):
    """An OpenEnd; labels: label -> probability."""

    kind: Literal["door", "corridor"]
    room: int | str
    near: int | str
    labels: dict[str, Share]
    leads_on: Share
    rooms: SavedInterval
    area: SavedInterval | None = None


class SavedPrediction(_Part):
    """The content of prediction.json that pages show; area in m²; unknown: expected unknown rooms by label."""

    source: str
    building_type: str
    samples: Annotated[int, Field(ge=1)]
    known_rooms: Annotated[list[int | str], Field(alias="known")]
    rooms: SavedInterval
    area: SavedInterval | None = None
    unknown: dict[str, SavedInterval]
    open_ends: list[SavedEnd]


def read_prediction(path: str | Path) -> SavedPrediction:
    """Read prediction.json; raises DataError, with every fault in one message, for a file of another form."""

    def parse(content: bytes) -> SavedPrediction:
        with validation_as(DataError):
            FORMAT.check_version(content, DataError)
            return SavedPrediction.model_validate_json(content)

    return read_checked(path, "prediction", DataError, parse, max_bytes=MAX_FILE_BYTES)
