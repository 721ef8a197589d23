"""Route graphs for Nav2's route server: GeoJSON in metres of the map frame, as its graph loader reads it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any, Literal

import networkx as nx
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, TypeAdapter

from pianta.building import Building
from pianta.errors import FloorError
from pianta.floor import Floor
from pianta.io._checked import read_checked
from pianta.io._faults import join_faults, validation_as
from pianta.io._files import count_noun, short_repr
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers._only_storey import get_only_storey
from pianta.navigation.route_graph import FRAME, build_route_graph

# As in Nav2's samples, so that QGIS shows metres; the loader does not read it.
CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}
MAX_FILE_BYTES = 2**28
MAX_LISTED = 10  # rooms or pairs of rooms in a note


def write_route_graph(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The route graph of a floor; notes name rooms and doors through which the robot does not fit."""
    floor, grid = get_only_storey(building, "nav2-route")
    graph = build_route_graph(floor, grid, robot_radius=options.robot_radius)
    if not graph.number_of_edges():
        raise FloorError(
            f"the route graph of {count_noun(len(floor), 'room')} has no edge, which Nav2 refuses: no door joins two "
            f"rooms for a robot of {options.robot_radius} m radius; give a map of two rooms, or a smaller robot_radius"
        )
    target.write_text(json.dumps(format_route_graph(graph), ensure_ascii=False, allow_nan=False), encoding="utf-8")
    return list_route_gaps(floor, graph)


def format_route_graph(graph: nx.DiGraph) -> dict[str, Any]:
    """The GeoJSON of a route graph; edges have numbers after those of all nodes."""
    frame = graph.graph["frame"]
    points = {node: [data["x"], data["y"]] for node, data in graph.nodes(data=True)}
    nodes = [
        _make_feature("Point", points[node], {"id": node, "frame": frame, "metadata": data["metadata"]})
        for node, data in graph.nodes(data=True)
    ]
    edges = []
    for number, (start, end, data) in enumerate(graph.edges(data=True), start=max(graph, default=0) + 1):
        properties = {"id": number, "startid": start, "endid": end, **data}
        edges.append(_make_feature("LineString", [points[start], points[end]], properties))
    return {"type": "FeatureCollection", "name": "route", "crs": CRS, "features": nodes + edges}


def list_route_gaps(floor: Floor, graph: nx.DiGraph) -> list[str]:
    """Lines about the rooms in which the robot fits nowhere, and those whose doors it cannot pass."""
    outside = [room.id for room in floor if room.id not in graph]
    parts = {node: index for index, part in enumerate(nx.weakly_connected_components(graph)) for node in part}
    pairs = sorted({door.rooms for door in floor.doors if door.joins_rooms})
    shut = [(a, b) for a, b in pairs if a in parts and b in parts and parts[a] != parts[b]]
    notes = [f"the robot fits nowhere in rooms {_list_some(outside)}"] if outside else []
    return notes + ([f"the robot passes no door between rooms {_list_some(shut)}"] if shut else [])


def read_route_graph(path: str | Path) -> nx.DiGraph:
    """Read a route graph for Nav2's route server, by the rules of its loader and the advice of its manual.

    Parameters
    ----------
    path
        A GeoJSON file, of `pianta convert --to nav2-route` or from elsewhere.

    Returns
    -------
    networkx.DiGraph
        As `build_route_graph` makes it: nodes with `x`, `y` and `metadata`, edges with `cost` and `metadata`; the
        graph has the `frame`.

    Raises
    ------
    FloorError
        The file breaks a rule; the faults are in one line.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> _ = pianta.convert(floor, "route.geojson", to="nav2-route", grid=grid)
    >>> pianta.read_route_graph("route.geojson").nodes[1]["metadata"]["class"]
    'CORRIDOR'
    """
    return read_checked(path, "route graph", FloorError, _parse_route_graph, max_bytes=MAX_FILE_BYTES)


def _make_feature(geometry: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": geometry, "coordinates": coordinates}}


def _list_some(items: list[Any]) -> str:
    listed = ", ".join(
        "–".join(map(str, item)) if isinstance(item, tuple) else str(item) for item in items[:MAX_LISTED]
    )
    return listed + (", …" if len(items) > MAX_LISTED else "")


class _Feature(BaseModel):
    """A part of a file; all values have the types of the file."""

    model_config = ConfigDict(strict=True, frozen=True)


_Id = Annotated[int, Field(ge=0, lt=2**32)]
_Coordinates = Annotated[list[FiniteFloat], Field(min_length=2, max_length=3)]


def _check_metadata(value: object, *, in_list: bool = False) -> object:
    """Raise ValueError for null, and for lists and objects in lists, on which the loader stops."""
    if value is None:
        raise ValueError("null is no value of metadata, leave it out")
    if in_list and isinstance(value, list | dict):
        raise ValueError("a list of metadata has lists or objects in it, give x_values and y_values")
    for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        _check_metadata(each, in_list=isinstance(value, list))
    return value


_Metadata = Annotated[dict[str, Any], AfterValidator(_check_metadata)]


class _Node(_Feature):
    id: _Id
    frame: str = FRAME
    metadata: _Metadata = {}


class _Edge(_Feature):
    id: _Id
    startid: _Id
    endid: _Id
    cost: Annotated[FiniteFloat, Field(ge=0)] = 0.0
    metadata: _Metadata = {}


class _Geometry(_Feature):
    type: str
    coordinates: list[Any]


class _AnyFeature(_Feature):
    type: Literal["Feature"]
    geometry: _Geometry
    properties: dict[str, Any]


class _Collection(_Feature):
    type: Literal["FeatureCollection"]
    features: list[_AnyFeature]


_POINT = TypeAdapter(_Coordinates)


def _parse_route_graph(content: bytes) -> nx.DiGraph:
    with validation_as(FloorError):
        features = _Collection.model_validate_json(content).features
        points = [each for each in features if each.geometry.type == "Point"]
        lines = [each for each in features if each.geometry.type in {"LineString", "MultiLineString"}]
        nodes = [_Node.model_validate(each.properties) for each in points]
        positions = [_POINT.validate_python(each.geometry.coordinates) for each in points]
        edges = [_Edge.model_validate(each.properties) for each in lines]
    _check_ids(nodes, edges)
    graph: nx.DiGraph = nx.DiGraph(frame=nodes[0].frame)
    for node, (x, y, *_) in zip(nodes, positions, strict=True):
        graph.add_node(node.id, x=x, y=y, metadata=node.metadata)
    for edge in edges:
        graph.add_edge(edge.startid, edge.endid, cost=edge.cost, metadata=edge.metadata)
    return graph


def _check_ids(nodes: list[_Node], edges: list[_Edge]) -> None:
    """Raise FloorError, with every fault, for a graph that the loader refuses or mixes up."""
    faults = [f"it has no {noun}" for noun, parts in (("node", nodes), ("edge", edges)) if not parts]
    ids = Counter([*(node.id for node in nodes), *(edge.id for edge in edges)])
    faults += [f"id {number} occurs {count} times" for number, count in ids.items() if count > 1]
    node_ids = {node.id for node in nodes}
    ends = [(edge.id, end) for edge in edges for end in (edge.startid, edge.endid)]
    faults += [f"edge {number} has the end {end}, which is no node" for number, end in ends if end not in node_ids]
    frames = sorted({node.frame for node in nodes})
    faults += [f"it has the frames {', '.join(map(short_repr, frames))}, give one"] if len(frames) > 1 else []
    if faults:
        raise FloorError(join_faults(faults))
