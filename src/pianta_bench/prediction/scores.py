"""How good the prediction of a floor is after each corridor that is explored, beside what simple rivals say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import process_time
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.evaluation.prediction import (
    bound_edit_distance,
    expect_divergence,
    measure_divergence,
    measure_kernel_distances,
)
from pianta.generation.type_model import count_labels
from pianta.graphs.metrics import find_corridors
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.labels import LabelConvention, LabelSchema, LabelSet
from pianta.prediction.explored_part import explore_by_corridors
from pianta.prediction.prediction import Prediction, predict
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.prediction.rivals import Rivals, corridor_graph

PREDICTED, MEAN, SAMPLE, TYPICAL, MEDOID, ORACLE = "predicted", "mean", "one sample", "typical", "medoid", "oracle"
LABEL_SETS: Mapping[LabelSet, str] = MappingProxyType(
    {LabelSet.TYPE: "labels", LabelSet.F_C_E_S: "F/C/E/S", LabelSet.R_C: "R/C"}
)
WL, NSPDK, EDITS = DISTANCES = ("WL", "NSPDK", "edits")
ORACLE_DRAWS = 200
# Edits are counted between skeletons of so many corridors at most.
MAX_EDITED = 30


@dataclass(frozen=True)
class DoorGuess:
    """What was said of an unopened door, and what is behind it. labels: label -> probability.

    local: what local prediction says, None where it says nothing.
    """

    door: str
    labels: Mapping[str, float]
    true: str
    local: str | None


@dataclass(frozen=True)
class JudgedStage:
    """The prediction after some corridors. corridors: that are explored. known, unseen: rooms.

    figures: by "MEASURE, WHO SAYS IT"; None where nothing can be said. interval: whether the rooms of the floor are in
    that of four of five samples. is_silent: whether local prediction says nothing of labels. seconds: of the processor,
    for the prediction.
    """

    corridors: int
    known: int
    unseen: int
    figures: Mapping[str, float | None]
    guesses: Sequence[DoorGuess]
    interval: bool
    is_silent: bool
    seconds: float


@dataclass(frozen=True)
class JudgedFloor:
    """A floor, explored by corridors. stages: while something is unseen. half: that with half of the corridors."""

    source: str
    rooms: int
    corridors: int
    stages: Sequence[JudgedStage]
    half: JudgedStage | None

    @property
    def first_guesses(self) -> list[DoorGuess]:
        """The guess of each door at the first stage at which it is unopened."""
        first = {guess.door: guess for stage in reversed(self.stages) for guess in stage.guesses}
        return [*first.values()]


def judge_floor(graph: nx.Graph, sampler: FloorSampler, rivals: Rivals, *, count: int, seed: int) -> JudgedFloor:
    """Explore a floor that the model does not have by corridors, and judge each prediction.

    graph: as `prepare_room_graph` gives it. count: samples of a prediction.
    """
    corridors = find_corridors(graph, rivals.model.schema, convention=LabelConvention.GRAPHS)
    explorations = explore_by_corridors(graph, corridors)
    half = -(-len(explorations) // 2)
    stages = {}
    for number, known in enumerate(explorations, 1):
        if {node for node in known if known.nodes[node]["label"] is not None} == {*graph}:
            continue
        start = process_time()
        prediction = predict(known, sampler, count=count, seed=seed)
        seconds = process_time() - start
        stages[number] = judge_stage(
            graph, prediction, rivals, corridors=number, seconds=seconds, edited=number == half, seed=seed
        )
    return JudgedFloor(graph.graph["source"], len(graph), len(corridors), [*stages.values()], stages.get(half))


def judge_stage(
    graph: nx.Graph,
    prediction: Prediction,
    rivals: Rivals,
    *,
    corridors: int,
    seconds: float = 0.0,
    edited: bool = True,
    seed: int = 0,
) -> JudgedStage:
    """Judge one prediction by the whole floor. corridors: that are explored. edited: whether edits are counted."""
    explored = prediction.explored
    known = {room for _, room in explored.known_graph.nodes(data="room")}
    unseen = graph.subgraph([node for node in graph if node not in known])
    figures = {
        **score_labels(graph, unseen, prediction, rivals, seed=seed),
        **score_sizes(graph, prediction, rivals),
        **score_skeletons(graph, prediction, rivals, edited=edited),
    }
    interval = prediction.rooms.low <= len(graph) <= prediction.rooms.high
    guesses = guess_doors(graph, prediction, rivals)
    is_silent = not rivals.guess_ends(explored)
    return JudgedStage(corridors, len(known), len(unseen), figures, guesses, interval, is_silent, seconds)


def score_labels(
    graph: nx.Graph, unseen: nx.Graph, prediction: Prediction, rivals: Rivals, *, seed: int
) -> dict[str, float | None]:
    """Divergence of what each says from the labels of the unseen rooms, bits, by label set."""
    schema = prediction.schema
    names = [*schema.by_name]
    true, whole = count_labels([unseen, graph], schema).astype(float)
    said = {PREDICTED: np.array([[prediction.shares.get(name, 0.0) for name in names]])}
    said[MEAN] = np.array([[prediction.counts[name].mean if name in prediction.counts else 0.0 for name in names]])
    samples = count_labels([sample.graph.subgraph(sample.unseen) for sample in prediction.samples], schema).astype(
        float
    )
    said[SAMPLE] = samples[samples.sum(axis=1) > 0]
    said |= {rival: shares[None] for rival, shares in rivals.share_labels(prediction.explored).items()}
    figures: dict[str, float | None] = {}
    for label_set, name in LABEL_SETS.items():
        merge = merge_labels(schema, label_set)
        truth = true @ merge / true.sum()
        for who, rows in said.items():
            merged = rows @ merge
            usable = merged[merged.sum(axis=1) > 0]
            shares = usable / usable.sum(axis=1, keepdims=True)
            figures[f"{name}, {who}"] = float(measure_divergence(shares, truth).mean()) if len(shares) else None
        figures[f"{name}, {ORACLE}"] = expect_divergence(
            truth, whole @ merge, count=len(unseen), draws=ORACLE_DRAWS, seed=seed
        )
    return figures


def merge_labels(schema: LabelSchema, label_set: LabelSet) -> Floats:
    """Which label of a coarser set each label of a schema is, shape (labels, labels of the set)."""
    coarse = schema.map_labels(schema.by_name, label_set, convention=LabelConvention.GRAPHS)
    names = [*dict.fromkeys(coarse)]
    return np.array([[float(of == name) for name in names] for of in coarse])


def score_sizes(graph: nx.Graph, prediction: Prediction, rivals: Rivals) -> dict[str, float | None]:
    """How many rooms, and corridors among them, each says too many of on the whole floor, negative for too few."""
    true = len(graph), len(corridor_graph(graph, prediction.schema))
    corridors = [len(prediction.corridor_graph(sample)) for sample in prediction.samples]
    said = {PREDICTED: (prediction.rooms.mean, float(np.mean(corridors))), **rivals.count_rooms(prediction.explored)}
    figures: dict[str, float | None] = {}
    for who, numbers in said.items():
        for name, number, right in zip(("rooms", "corridors"), numbers, true, strict=True):
            figures[f"{name}, {who}"] = float(number - right)
    return figures


def score_skeletons(
    graph: nx.Graph, prediction: Prediction, rivals: Rivals, *, edited: bool
) -> dict[str, float | None]:
    """Distances of the skeletons that each says from the true one; the mean where it says several."""
    truth = corridor_graph(graph, prediction.schema)
    said: dict[str, Sequence[nx.Graph]] = {
        PREDICTED: [prediction.corridor_graph(sample) for sample in prediction.samples],
        TYPICAL: [prediction.corridor_graph(prediction.typical)],
        MEDOID: [rivals.medoid],
        **rivals.draw_skeletons(prediction.explored),
    }
    skeletons = [skeleton for of in said.values() for skeleton in of]
    measured = {
        WL: measure_kernel_distances(truth, skeletons, WeisfeilerLehman()),
        NSPDK: measure_kernel_distances(truth, skeletons, NeighborhoodPairs()),
        EDITS: np.array([_count_edits(truth, skeleton) if edited else np.nan for skeleton in skeletons]),
    }
    ends = np.cumsum([len(of) for of in said.values()])
    figures: dict[str, float | None] = {}
    for name, distances in measured.items():
        for who, of in zip(said, np.split(distances, ends[:-1]), strict=True):
            counted = of[~np.isnan(of)]
            figures[f"{name}, {who}"] = float(counted.mean()) if len(counted) else None
    return figures


def guess_doors(graph: nx.Graph, prediction: Prediction, rivals: Rivals) -> list[DoorGuess]:
    """The guesses of all unopened doors whose names tell which rooms they join."""
    explored = prediction.explored
    local = rivals.guess_ends(explored)
    places = {explored.graph.nodes[door]["room"]: door for door in explored.doors}
    return [
        DoorGuess(
            str(end.room),
            end.labels,
            graph.nodes[int(str(end.room).split("-")[1])]["label"],
            local.get(places[end.room]),
        )
        for end in prediction.ends
        if end.is_door
    ]


def _count_edits(truth: nx.Graph, skeleton: nx.Graph) -> float:
    return bound_edit_distance(truth, skeleton) if max(len(truth), len(skeleton)) <= MAX_EDITED else np.nan
