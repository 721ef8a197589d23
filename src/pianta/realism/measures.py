"""Measures of a floor that people can read, and which of them are off: not what is usual among reference floors.

The metrics of section 5.1 of the thesis, and numbers of a BuildingDescription.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from pianta.building_types.description import CONNECTING, LEAST_SHARE, BuildingDescription, name_features
from pianta.graphs.metrics import measure_graph
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS

# The usual range is that of nine tenths of the reference floors.
USUAL = (0.05, 0.95)
# What is off lies outside of it, by this share of its width at least.
OUTSIDE = 0.1
# A range is no narrower than this share of the median.
LEAST_RANGE = 0.02
# So many measures are told, the farthest from the usual ones first.
MEASURES_TOLD = 5


@dataclass(frozen=True)
class Measure:
    """A number of a floor.

    key: of GRAPH_METRICS, or the name of a feature of a description. name: in words.
    family: measures of one family say much the same.
    high, low: what it means when the number is larger or smaller than usual.
    digits: shown behind the point; None for a share, which is shown in percent.
    """

    key: str
    name: str
    family: str
    high: str
    low: str
    digits: int | None = 3


@dataclass(frozen=True)
class OffMeasure:
    """A measure whose value on a floor is not usual.

    usual: the values of the reference floors, ascending. strangeness: from their median, in widths of the usual range.
    """

    measure: Measure
    value: float
    usual: tuple[float, ...]
    strangeness: float

    @property
    def median(self) -> float:
        """Of the reference floors."""
        return float(np.median(self.usual))

    @property
    def usual_range(self) -> tuple[float, float]:
        """Bounds within which nine tenths of the reference floors are."""
        low, high = np.quantile(self.usual, USUAL)
        return float(low), float(high)

    @property
    def meaning(self) -> str:
        """What the value tells."""
        return self.measure.high if self.value > self.median else self.measure.low

    def as_json(self) -> dict[str, object]:
        """All of it, as JSON can hold it."""
        of_measure = {"measure": self.measure.key, "name": self.measure.name, "value": self.value, "usual": self.usual}
        return of_measure | {"strangeness": self.strangeness, "reason": str(self)}

    def __str__(self) -> str:
        low, high = (show_value(bound, self.measure.digits) for bound in self.usual_range)
        value, median = (show_value(number, self.measure.digits) for number in (self.value, self.median))
        usually = f"{low} to {high} (median {median})" if low != high else low
        return f"{self.meaning}: {self.measure.name} {value}, usually {usually}"


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
        "closeness_c",
        "closeness of corridors",
        "closeness",
        "corridors are near to all",
        "corridors are far from all",
    ),
    *(
        Measure(f"{key}{of}", f"{name}{whose}", "importance", f"{who} matter much", f"{who} matter little")
        for key, name in (("eigenvector", "eigenvector centrality"), ("katz", "Katz centrality"))
        for of, whose, who in (
            ("_r", " of rooms", "single rooms"),
            ("_c", " of corridors", "single corridors"),
        )
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
    kinds = LABELS[label_set][1:] if label_set is LabelSet.R_C else LABELS[label_set]
    of_labels = (
        measure
        for kind in kinds
        for measure in (
            Measure(f"{kind} share", f"{kind} among rooms", kind, f"much is {kind}", f"little is {kind}", None),
            Measure(
                f"{kind} area_share", f"area of {kind}", kind, f"much area is {kind}", f"little area is {kind}", None
            ),
        )
    )
    return (*GRAPH_MEASURES, *FEATURE_MEASURES, *of_labels)


def measure_description(description: BuildingDescription, label_set: LabelSet) -> dict[str, float | None]:
    """The values of all measures of a floor, by their keys; None for what it does not have."""
    graph = nx.Graph(description.doors)
    graph.add_nodes_from(range(len(description.labels)))
    corridors = [place for place, label in enumerate(description.labels) if label in CONNECTING]
    values: dict[str, float | None] = dict(measure_graph(graph, corridors))
    for name, feature in zip(name_features(label_set), description.features.tolist(), strict=True):
        values[name] = _undo_logarithm(name, feature)
    return {measure.key: values[measure.key] for measure in list_measures(label_set)}


def find_off_measures(
    values: Mapping[str, float | None], known: Sequence[Mapping[str, float | None]], label_set: LabelSet
) -> tuple[OffMeasure, ...]:
    """The measures outside their usual range, one of a family, the farthest from the median first.

    values, known: as measure_description gives them, of the floor and of each reference floor.
    """
    off = sorted(_list_off_measures(values, known, label_set), key=lambda found: -found.strangeness)
    of_families: dict[str, OffMeasure] = {}
    for found in off:
        of_families.setdefault(found.measure.family, found)
    return tuple(of_families.values())[:MEASURES_TOLD]


def show_value(value: float, digits: int | None) -> str:
    """A number of a measure, in percent when it is a share; of what is counted, one digit where that tells more."""
    if digits is None:
        return f"{value:.0%}"
    return f"{value:.{digits}f}" if digits or round(value, 1) == round(value) else f"{value:.1f}"


def _list_off_measures(
    values: Mapping[str, float | None], known: Sequence[Mapping[str, float | None]], label_set: LabelSet
) -> Iterator[OffMeasure]:
    for measure in list_measures(label_set):
        value = values[measure.key]
        usual = sorted(number for floor in known if (number := floor[measure.key]) is not None)
        if value is None or 2 * len(usual) < len(known):
            continue
        low, median, high = np.quantile(usual, (USUAL[0], 0.5, USUAL[1])).tolist()
        width = max(high - low, LEAST_RANGE * abs(median), LEAST_SHARE)
        if not low - OUTSIDE * width <= value <= high + OUTSIDE * width:
            yield OffMeasure(measure, value, tuple(usual), abs(value - median) / width)


def _undo_logarithm(name: str, feature: float) -> float:
    """Shares of area are logarithms in a description, and begin at LEAST_SHARE where they may be 0."""
    if name == "largest_share":
        return float(np.exp(feature))
    return max(float(np.exp(feature)) - LEAST_SHARE, 0.0) if name.endswith(" area_share") else feature
