"""Measures of a floor that people understand, and which of them are unusual among reference floors.

They are the metrics of section 5.1 of the thesis, and features of a BuildingDescription.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from pianta.building_types.description import (
    CONNECTING_LABELS,
    MIN_SHARE,
    BuildingDescription,
    list_described_labels,
    name_features,
)
from pianta.graphs.metrics import measure_graph
from pianta.labels import LabelSet

# Quantiles that bound the usual range: nine tenths of the reference floors.
USUAL = (0.05, 0.95)
# An unusual value is outside by at least this share of the width of the range; chosen by hand, as is MIN_RANGE.
MARGIN = 0.1
# The least width of a range, as a share of the median.
MIN_RANGE = 0.02
# Unusual measures that are reported, those with the largest deviation.
MAX_MEASURES = 5


@dataclass(frozen=True)
class Measure:
    """A number of a floor.

    key: one of GRAPH_METRICS, or the name of a feature of a description. name: in words.
    family: measures of one family mean much the same; only one of them is reported.
    high, low: the meaning of a larger, or smaller, value than usual.
    digits: decimals to show; None for a share, which is shown in percent.
    """

    key: str
    name: str
    family: str
    high: str
    low: str
    digits: int | None = 3


@dataclass(frozen=True)
class UnusualMeasure:
    """A measure whose value on a floor is outside the usual range.

    usual: the values of the reference floors, ascending. deviation: from their median, in widths of the usual range.
    """

    measure: Measure
    value: float
    usual: tuple[float, ...]
    deviation: float

    @property
    def median(self) -> float:
        """Of the reference floors."""
        return float(np.median(self.usual))

    @property
    def usual_range(self) -> tuple[float, float]:
        """The bounds of nine tenths of the reference floors."""
        low, high = np.quantile(self.usual, USUAL)
        return float(low), float(high)

    @property
    def meaning(self) -> str:
        """What the value means, in words."""
        return self.measure.high if self.value > self.median else self.measure.low

    def as_json(self) -> dict[str, object]:
        """All attributes, as values that JSON can hold."""
        return {
            "measure": self.measure.key,
            "name": self.measure.name,
            "value": self.value,
            "usual": self.usual,
            "deviation": self.deviation,
            "reason": str(self),
        }

    def __str__(self) -> str:
        low, high = (format_value(bound, self.measure.digits) for bound in self.usual_range)
        value, median = (format_value(number, self.measure.digits) for number in (self.value, self.median))
        usual = f"{low} to {high} (median {median})" if low != high else low
        return f"{self.meaning}: {self.measure.name} {value}, usually {usual}"


GRAPH_MEASURES: tuple[Measure, ...] = (
    Measure("nodes", "rooms", "size", "the floor is large", "the floor is small", 0),
    Measure("edges", "connected pairs of rooms", "size", "there are many doors", "there are few doors", 0),
    Measure("nodes_r", "rooms that are no corridors", "size", "there are many rooms", "there are few rooms", 0),
    Measure("nodes_c", "corridors", "size", "there are many corridors", "there are few corridors", 0),
    Measure(
        "path_length",
        "doors on the mean way",
        "paths",
        "ways lead through many doors",
        "ways lead through few doors",
        1,
    ),
    Measure(
        "diameter",
        "doors on the longest way",
        "paths",
        "the longest way leads through many doors",
        "the longest way leads through few doors",
        0,
    ),
    Measure(
        "art_points",
        "rooms that would divide the floor if closed",
        "cuts",
        "many rooms hold the floor together",
        "few rooms hold the floor together, there are ways around",
        0,
    ),
    Measure(
        "assortativity",
        "degree assortativity",
        "assortativity",
        "rooms do not hang on corridors with many doors",
        "nearly all rooms hang on corridors with many doors",
        2,
    ),
    Measure(
        "betweenness",
        "mean betweenness",
        "betweenness",
        "many rooms lie on the ways between others",
        "few rooms lie on the ways between others",
    ),
    Measure(
        "betweenness_r",
        "betweenness of rooms",
        "betweenness",
        "rooms lead on to other rooms",
        "rooms lead nowhere else",
    ),
    Measure(
        "betweenness_c",
        "betweenness of corridors",
        "betweenness",
        "each corridor carries much of the ways",
        "corridors carry little of the ways",
    ),
    Measure("closeness", "mean closeness", "closeness", "all is near to all", "all is far from all"),
    Measure("closeness_r", "closeness of rooms", "closeness", "rooms are near to all", "rooms are far from all"),
    Measure(
        "closeness_c", "closeness of corridors", "closeness", "corridors are near to all", "corridors are far from all"
    ),
    *(
        Measure(
            f"{key}_{part[0]}",
            f"{name} of {part}",
            "importance",
            f"single {part} matter much",
            f"single {part} matter little",
        )
        for key, name in (("eigenvector", "eigenvector centrality"), ("katz", "Katz centrality"))
        for part in ("rooms", "corridors")
    ),
)
FEATURE_MEASURES: tuple[Measure, ...] = (
    Measure(
        "mean leaves",
        "rooms with a single neighbour",
        "dead ends",
        "nearly all rooms are dead ends",
        "few rooms are dead ends",
        None,
    ),
    Measure(
        "mean door_span",
        "way between the outermost doors over the length of the room",
        "doors' places",
        "doors lie at opposite ends of rooms",
        "doors lie next to each other",
        2,
    ),
    Measure(
        "mean facade",
        "outline of rooms at the façade",
        "facade",
        "rooms have much façade",
        "rooms have little façade",
        None,
    ),
    Measure(
        "mean wall_neighbours",
        "rooms behind the walls of a room",
        "walls",
        "rooms have many rooms around",
        "rooms have few rooms around",
        1,
    ),
    Measure(
        "corridors' elongation",
        "length over width of corridors",
        "corridors",
        "corridors are long and narrow",
        "corridors are short and wide",
        1,
    ),
    Measure(
        "corridors' rectangularity",
        "corridors' share of the rectangles around them",
        "corridors",
        "corridors are plain rectangles",
        "corridors have bends and branches",
        None,
    ),
    Measure(
        "largest_share",
        "the largest room's share of the area",
        "largest room",
        "one room takes much of the area",
        "no room is large",
        None,
    ),
)


def list_measures(label_set: LabelSet) -> tuple[Measure, ...]:
    """The measures of floors whose rooms have labels of a set."""
    labels = [
        measure
        for label in list_described_labels(label_set)
        for measure in (
            Measure(f"{label} share", f"{label} among rooms", label, f"much is {label}", f"little is {label}", None),
            Measure(
                f"{label} area_share",
                f"area of {label}",
                label,
                f"much area is {label}",
                f"little area is {label}",
                None,
            ),
        )
    ]
    return (*GRAPH_MEASURES, *FEATURE_MEASURES, *labels)


def measure_description(description: BuildingDescription, label_set: LabelSet) -> dict[str, float | None]:
    """The values of all measures of a floor, by their keys; None if undefined."""
    graph = nx.Graph(description.doors)
    graph.add_nodes_from(range(len(description.labels)))
    corridors = [room for room, label in enumerate(description.labels) if label in CONNECTING_LABELS]
    values: dict[str, float | None] = dict(measure_graph(graph, corridors))
    for name, feature in zip(name_features(label_set), description.features.tolist(), strict=True):
        values[name] = _undo_logarithm(name, feature)
    return {measure.key: values[measure.key] for measure in list_measures(label_set)}


def find_unusual_measures(
    values: Mapping[str, float | None], reference: Sequence[Mapping[str, float | None]], label_set: LabelSet
) -> tuple[UnusualMeasure, ...]:
    """The measures outside their usual range, one of each family, the largest deviation first.

    values, reference: what measure_description gives for the floor and for each reference floor.
    """
    unusual = sorted(_list_unusual_measures(values, reference, label_set), key=lambda each: -each.deviation)
    by_family: dict[str, UnusualMeasure] = {}
    for each in unusual:
        by_family.setdefault(each.measure.family, each)
    return tuple(by_family.values())[:MAX_MEASURES]


def format_value(value: float, digits: int | None) -> str:
    """A value in words: a share in percent; a count with one decimal unless it is a whole number."""
    if digits is None:
        return f"{value:.0%}"
    return f"{value:.{digits}f}" if digits or round(value, 1) == round(value) else f"{value:.1f}"


def _list_unusual_measures(
    values: Mapping[str, float | None], reference: Sequence[Mapping[str, float | None]], label_set: LabelSet
) -> Iterator[UnusualMeasure]:
    """Measures outside their usual range; one that fewer than half of the reference floors have is not compared."""
    for measure in list_measures(label_set):
        value = values[measure.key]
        usual = sorted(number for floor in reference if (number := floor[measure.key]) is not None)
        if value is None or 2 * len(usual) < len(reference):
            continue
        low, median, high = np.quantile(usual, (USUAL[0], 0.5, USUAL[1])).tolist()
        width = max(high - low, MIN_RANGE * abs(median), MIN_SHARE)
        if not low - MARGIN * width <= value <= high + MARGIN * width:
            yield UnusualMeasure(measure, value, tuple(usual), abs(value - median) / width)


def _undo_logarithm(name: str, feature: float) -> float:
    """The share of area behind a feature that is its logarithm; other features as they are."""
    if name == "largest_share":
        return float(np.exp(feature))
    return max(float(np.exp(feature)) - MIN_SHARE, 0.0) if name.endswith(" area_share") else feature
