"""How good a prediction of the unexplored part of a floor is, beside simple baselines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeAlias

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
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.labels import LabelConvention, LabelSchema, LabelSet
from pianta.prediction.prediction import Prediction
from pianta_bench.prediction.baselines import ANY_DOOR, LOCAL, Baselines, corridor_graph

# Predictors beside the baselines: by the distribution nearest to the samples', the mean of the samples, a sample each.
PREDICTED = "predicted"
MEAN = "mean"
SAMPLE = "one sample"
TYPICAL = "typical"  # the most typical sample
MEDOID = "medoid"  # the most typical floor of the model
ORACLE = "oracle"  # as many labels as are unseen, drawn from this floor's own
PRINTED = "as printed"  # by the sampler of section 8.3 as it is printed
PRINTED_TYPICAL = "as printed, typical"
SAMPLED = "samples alone"  # behind doors
SIMILAR_DOORS = "similar doors alone"
LABEL_SETS: Mapping[LabelSet, str] = MappingProxyType(
    {LabelSet.TYPE: "labels", LabelSet.F_C_E_S: "F/C/E/S", LabelSet.R_C: "R/C"}
)
WL = "WL"
NSPDK = "NSPDK"
EDITS = "edits"
DISTANCES = (WL, NSPDK, EDITS)
ORACLE_DRAWS = 200  # whose mean divergence is the oracle's; chosen by hand
MAX_EDITED = 30  # corridors of skeletons whose edits are counted, which takes long for more; chosen by hand

# Figures by metric and predictor; None if there is nothing to compare.
Scores: TypeAlias = dict[tuple[str, str], float | None]


def score_prediction(
    graph: nx.Graph,
    prediction: Prediction,
    baselines: Baselines,
    *,
    printed: Prediction | None = None,
    edited: bool = True,
    seed: int = 0,
) -> Scores:
    """Scores of a prediction and of the baselines by the whole floor.

    printed: the prediction by the printed sampler, if there is one. edited: whether edits are counted.
    """
    return {
        **score_labels(graph, prediction, baselines, printed, seed=seed),
        **score_sizes(graph, prediction, baselines, printed),
        **score_skeletons(graph, prediction, baselines, printed, edited=edited),
    }


def describe_stage(graph: nx.Graph, prediction: Prediction, baselines: Baselines) -> dict[str, float]:
    """Known and unseen rooms, and shares of 0 or 1: of stages with an interval that holds, or without local labels.

    The interval is that of the rooms of four of five samples.
    """
    unseen = len(_list_unseen(graph, prediction))
    return {
        "known rooms": len(graph) - unseen,
        "unseen rooms": unseen,
        "interval holds": float(prediction.rooms.low <= len(graph) <= prediction.rooms.high),
        "no local labels": float(not any(row.any() for row in baselines.expect_behind(prediction.explored).values())),
    }


def score_labels(
    graph: nx.Graph, prediction: Prediction, baselines: Baselines, printed: Prediction | None = None, *, seed: int
) -> Scores:
    """Divergence of the predicted labels from those of the unseen rooms, bits, by label set."""
    schema = prediction.schema
    unseen = graph.subgraph(_list_unseen(graph, prediction))
    true, total = count_labels([unseen, graph], schema).astype(float)
    shares, means, printed_shares = (
        np.array([[float(figures.get(name, 0.0)) for name in schema.by_name]])
        for figures in (
            prediction.shares,
            {name: interval.mean for name, interval in prediction.counts.items()},
            printed.shares if printed else {},
        )
    )
    samples = count_labels([sample.graph.subgraph(sample.unseen) for sample in prediction.samples], schema)
    predicted = {PREDICTED: shares, MEAN: means, SAMPLE: samples.astype(float)}
    if printed:
        predicted[PRINTED] = printed_shares
    predicted |= {name: row[None] for name, row in baselines.predict_shares(prediction.explored).items()}
    scores: Scores = {}
    for label_set, name in LABEL_SETS.items():
        merge = merge_labels(schema, label_set)
        truth = true @ merge / true.sum()
        for predictor, rows in predicted.items():
            merged = rows @ merge
            usable = merged[merged.sum(axis=1) > 0]
            distributions = usable / usable.sum(axis=1, keepdims=True)
            divergence = float(measure_divergence(distributions, truth).mean()) if len(usable) else None
            scores[name, predictor] = divergence
        scores[name, ORACLE] = expect_divergence(truth, total @ merge, count=len(unseen), draws=ORACLE_DRAWS, seed=seed)
    return scores


def merge_labels(schema: LabelSchema, label_set: LabelSet) -> Floats:
    """Which label of a coarser set each label of a schema is, shape (labels, labels of the set)."""
    coarse = schema.map_labels(schema.by_name, label_set, convention=LabelConvention.GRAPHS)
    names = [*dict.fromkeys(coarse)]
    return np.array([[float(label == name) for name in names] for label in coarse])


def score_sizes(
    graph: nx.Graph, prediction: Prediction, baselines: Baselines, printed: Prediction | None = None
) -> Scores:
    """Error and bias of the predicted rooms, and of the corridors among them, of the whole floor."""
    true = len(graph), len(corridor_graph(graph, prediction.schema))
    sizes = {PREDICTED: _count_sampled(prediction), **baselines.count_rooms(prediction.explored)}
    if printed:
        sizes[PRINTED] = _count_sampled(printed)
    scores: Scores = {}
    for predictor, numbers in sizes.items():
        for name, number, right in zip(("rooms", "corridors"), numbers, true, strict=True):
            bias = float(number - right)
            scores |= {(f"{name}, error", predictor): abs(bias), (f"{name}, bias", predictor): bias}
    return scores


def score_skeletons(
    graph: nx.Graph,
    prediction: Prediction,
    baselines: Baselines,
    printed: Prediction | None = None,
    *,
    edited: bool,
) -> Scores:
    """Distances of the predicted skeletons from the true one; the mean of a predictor with several."""
    truth = corridor_graph(graph, prediction.schema)
    predicted: dict[str, Sequence[nx.Graph]] = {
        PREDICTED: [prediction.corridor_graph(sample) for sample in prediction.samples],
        TYPICAL: [prediction.corridor_graph(prediction.typical)],
        MEDOID: [baselines.medoid],
        **baselines.predict_skeletons(prediction.explored),
    }
    if printed:
        predicted[PRINTED] = [printed.corridor_graph(sample) for sample in printed.samples]
        predicted[PRINTED_TYPICAL] = [printed.corridor_graph(printed.typical)]
    skeletons = [skeleton for several in predicted.values() for skeleton in several]
    distances = {
        WL: measure_kernel_distances(truth, skeletons, WeisfeilerLehman()),
        NSPDK: measure_kernel_distances(truth, skeletons, NeighborhoodPairs()),
        EDITS: np.array([_count_edits(truth, skeleton) if edited else np.nan for skeleton in skeletons]),
    }
    ends = np.cumsum([len(several) for several in predicted.values()])
    scores: Scores = {}
    for name, values in distances.items():
        for predictor, own in zip(predicted, np.split(values, ends[:-1]), strict=True):
            counted = own[~np.isnan(own)]
            scores[name, predictor] = float(counted.mean()) if len(counted) else None
    return scores


def predict_doors(
    graph: nx.Graph, prediction: Prediction, baselines: Baselines, printed: Prediction | None = None
) -> list[dict[str, Any]]:
    """What is behind each unopened door whose name gives the rooms that it joins.

    true: the label of the room behind. By predictor the probability of each label; of a baseline its only label, with
    probability 1. Empty without a prediction.
    """
    explored = prediction.explored
    baseline = baselines.predict_doors(explored)
    doors = {explored.graph.nodes[door]["room"]: door for door in explored.doors}
    by_printed = {end.room: dict(end.labels) for end in printed.ends} if printed else {}
    return [
        {
            "door": str(end.room),
            "true": graph.nodes[int(str(end.room).split("-")[1])]["label"],
            PREDICTED: dict(end.labels),
            SAMPLED: dict(end.sampled),
            SIMILAR_DOORS: dict(prediction.similar_doors.get(doors[end.room], {})),
            **{
                name: {} if label is None else {label: 1.0}
                for name, label in zip((LOCAL, ANY_DOOR), baseline[doors[end.room]], strict=True)
            },
            **({PRINTED: by_printed[end.room]} if printed else {}),
        }
        for end in prediction.ends
        if end.is_door
    ]


def _count_sampled(prediction: Prediction) -> tuple[float, float]:
    """The mean rooms of the samples, and the mean corridors among them."""
    corridors = [len(prediction.corridor_graph(sample)) for sample in prediction.samples]
    return prediction.rooms.mean, float(np.mean(corridors))


def _list_unseen(graph: nx.Graph, prediction: Prediction) -> list[int]:
    rooms = {room for _, room in prediction.explored.known_graph.nodes(data="room")}
    return [node for node in graph if node not in rooms]


def _count_edits(truth: nx.Graph, skeleton: nx.Graph) -> float:
    return bound_edit_distance(truth, skeleton) if max(len(truth), len(skeleton)) <= MAX_EDITED else np.nan
