"""A prediction on the page: what was expected behind each open end, over the known floor if it has outlines."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar

import networkx as nx
import shapely
from shapely.geometry import mapping
from shapely.geometry.base import BaseGeometry

from pianta.corrections._positions import position_in
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.io._files import count_noun
from pianta.io.floors import read_floor
from pianta.io.maps import read_npz_map
from pianta.prediction.prediction_file import SavedEnd, SavedPrediction, read_prediction
from pianta.view.drawn_graphs import NodeStyle, count_labels, describe_graph, open_graph, style_nodes
from pianta.view.result_sessions import ResultSession, describe_shapes
from pianta.view.room_positions import place_unknown, radius_of

FILE_NAME = "prediction.json"
# The known rooms and their map, as `pianta predict` writes them.
KNOWN_FLOOR, KNOWN_MAP = "explored.geojson", "explored.npz"
# Samples that the page shows; they are independent, so that the first ones are as good as any.
MAX_SAMPLES = 20


@dataclass(frozen=True, eq=False)
class _Prediction:
    """saved: the figures. floor, grid: the known rooms and their map, None if the folder has none. samples: files."""

    saved: SavedPrediction
    floor: Floor | None
    samples: tuple[str, ...]
    has_map: bool


class PredictionSession(ResultSession[_Prediction]):
    """A folder of `pianta predict`; its parts are sampled floors."""

    kind: ClassVar[str] = "prediction"
    patterns: ClassVar[tuple[str, ...]] = (FILE_NAME, KNOWN_FLOOR, KNOWN_MAP, "sample-*.json")

    def _read(self) -> _Prediction:
        saved = read_prediction(self.file)
        floor = read_floor(self.folder / KNOWN_FLOOR) if (self.folder / KNOWN_FLOOR).is_file() else None
        samples = sorted(file.name for file in self.folder.glob("sample-*.json"))[:MAX_SAMPLES]
        return _Prediction(saved, floor, tuple(samples), (self.folder / KNOWN_MAP).is_file())

    def _list_facts(self, content: _Prediction) -> list[str]:
        saved = content.saved
        size = f"{saved.rooms.low:.0f}–{saved.rooms.high:.0f} rooms expected"
        return [
            f"{count_noun(len(saved.known_rooms), 'room')} known",
            count_noun(len(saved.open_ends), "open end"),
            size,
            saved.building_type,
        ]

    def _describe(self, content: _Prediction, version: str) -> dict[str, Any]:
        saved, floor = content.saved, content.floor
        prediction = {
            "ends": [_describe_end(end, floor) for end in saved.open_ends],
            "total": saved.samples,
            "shown": len(content.samples),
            **saved.model_dump(include={"source", "building_type", "rooms", "area", "unknown"}),
        }
        if floor is None:
            return {"prediction": prediction, "columns": SAMPLE_COLUMNS, "items": self._list_samples(content)}
        grid = self._open_picture(content, 0)
        return {**describe_shapes(floor, grid, self._address_of(0, version)), "prediction": prediction}

    def _count_parts(self, content: _Prediction) -> int:
        return len(content.samples)

    def _describe_part(self, content: _Prediction, part: int, version: str) -> dict[str, Any]:
        del version
        graph = open_graph(self.folder / content.samples[part])
        if content.floor is None:
            return describe_graph(graph)
        starts = _find_known(graph, content.floor)
        doors = {node for node, door in graph.nodes(data="door") if door is not None}
        shape = shapely.union_all([room.polygon for room in content.floor.rooms])
        xy = place_unknown(graph, starts, shape)
        unknown = graph.subgraph([node for node in xy if node not in starts or node in doors])
        drawn_at = {node: xy[node] for node in graph if node in xy}
        return {
            "nodes": [_describe_node(graph, node, drawn_at, style) for node, style in style_nodes(unknown).items()],
            "edges": [
                [drawn_at[one], drawn_at[other]]
                for one, other in graph.edges
                if one in drawn_at and other in drawn_at and (one in unknown or other in unknown)
            ],
        }

    def _open_picture(self, content: _Prediction, part: int) -> GridMap | None:
        del part
        return read_npz_map(self.folder / KNOWN_MAP) if content.has_map else None

    def _list_samples(self, content: _Prediction) -> list[dict[str, Any]]:
        graphs = [open_graph(self.folder / name) for name in content.samples]
        return [
            {"name": graph_name(graph, index), "figures": count_labels(graph)} for index, graph in enumerate(graphs)
        ]


SAMPLE_COLUMNS = {"rooms": "rooms", "corridors": "corridors", "doors": "doors", "labels": "labels", "area": "m²"}


def graph_name(graph: nx.Graph, index: int) -> str:
    """The name of a graph; its number, from 1, if it has none."""
    source = graph.graph.get("source")
    return source if isinstance(source, str) and source else str(index + 1)


def _find_room(floor: Floor, name: object) -> Room | None:
    """The room of a name in a prediction; ids may have become text in GraphML."""
    return next((room for room in floor.rooms if str(room.id) == str(name)), None)


def _find_known(graph: nx.Graph, floor: Floor) -> dict[Hashable, tuple[float, float]]:
    """The positions of the nodes that are rooms of the floor, or behind an open door of it."""
    xy = {}
    for node, data in graph.nodes(data=True):
        name = data.get("room", data.get("door"))
        room = None if name is None else _find_room(floor, name)
        if room is not None:
            xy[node] = position_in(room.polygon)
    return xy


def _describe_end(end: SavedEnd, floor: Floor | None) -> dict[str, Any]:
    """An open end; outline: of the room that was seen in part, as predicted, else as seen; None without one."""
    room = None if floor is None else _find_room(floor, end.room)
    shape: BaseGeometry | None = None if room is None else (room.predicted or room.polygon)
    return {
        **end.model_dump(),
        "whole": room is not None and room.predicted is not None,
        "outline": None if shape is None else mapping(shape)["coordinates"],
        "position": None if room is None else position_in(room.polygon),
    }


def _describe_node(
    graph: nx.Graph, node: Hashable, xy: dict[Hashable, tuple[float, float]], style: NodeStyle
) -> dict[str, Any]:
    data = graph.nodes[node]
    return {
        "label": data.get("label") if isinstance(data.get("label"), str) else None,
        "colour": style.color,
        "corridor": style.is_corridor,
        "position": xy[node],
        "radius": radius_of(graph, node),
        "area": data.get("area") if isinstance(data.get("area"), int | float) else None,
        "door": None if data.get("door") is None else str(data["door"]),
    }
