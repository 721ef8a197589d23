"""Graphs of buildings: node-link JSON (graph.json), sampled graphs of the thesis, and the graph of any building."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import networkx as nx
from pydantic import AfterValidator, BaseModel, ConfigDict, JsonValue, model_validator
from pydantic_core import from_json

from pianta.errors import BuildingError, FloorError, LabelError
from pianta.io._checked import read_checked, save_checked
from pianta.io._faults import join_faults, validation_as
from pianta.io._files import check_input_file, short_repr
from pianta.labels import standard_building_type, standard_name

MAX_FILE_BYTES = 64 * 2**20
# The floor in a folder that `pianta read` has written.
FLOOR_FILE = "floor.geojson"


def save_graph(graph: nx.Graph, path: str | Path) -> None:
    """Write a graph in node-link form, nodes and edges in the graph's order; read_graph returns an equal graph.

    Raises FloorError for attributes that JSON does not have (NaN, tuples, objects), PiantaError if the file cannot be
    written.
    """
    save_checked(path, "graph", FloorError, lambda: _dump_graph(graph))


def read_graph(path: str | Path) -> nx.Graph:
    """Read an undirected graph without parallel edges from node-link JSON; `networkx.node_link_graph` does the same.

    Raises FloorError, with every fault in one message, for a file that holds no graph of this form.
    """
    return read_checked(path, "graph", FloorError, _parse_graph, max_bytes=MAX_FILE_BYTES)


def _dump_graph(graph: nx.Graph) -> bytes:
    content = json.dumps(nx.node_link_data(graph, edges="edges"), indent=1, allow_nan=False).encode()
    if not nx.utils.graphs_equal(_parse_graph(content), graph):
        raise FloorError("it has attributes that node-link JSON cannot hold, such as tuples or a node's `id`")
    return content + b"\n"


def _refuse_infinity(value: JsonValue) -> JsonValue:
    """Raise ValueError for NaN and infinity (1e999), which pydantic accepts and JSON does not have."""
    json.dumps(value, allow_nan=False)
    return value


_Value = Annotated[JsonValue, AfterValidator(_refuse_infinity)]


class _Node(BaseModel):
    model_config = ConfigDict(defer_build=True, strict=True, extra="allow")
    __pydantic_extra__: dict[str, _Value]

    id: int | str


class _Edge(BaseModel):
    model_config = ConfigDict(defer_build=True, strict=True, extra="allow")
    __pydantic_extra__: dict[str, _Value]

    source: int | str
    target: int | str


class _NodeLink(BaseModel):
    model_config = ConfigDict(defer_build=True, strict=True)

    directed: Literal[False]
    multigraph: Literal[False]
    graph: dict[str, _Value] = {}
    nodes: list[_Node]
    edges: list[_Edge]

    @model_validator(mode="after")
    def _check_ids(self) -> _NodeLink:
        """Raise ValueError for nodes of the same id, and for edges to nodes that do not exist."""
        ids = Counter(node.id for node in self.nodes)
        ends = {end for edge in self.edges for end in (edge.source, edge.target)}
        faults = [f"node {short_repr(node)} occurs {count} times" for node, count in ids.items() if count > 1]
        faults += [
            f"an edge leads to node {short_repr(end)}, which does not exist"
            for end in sorted(ends - ids.keys(), key=str)
        ]
        if faults:
            raise ValueError(join_faults(faults))
        return self


@validation_as(FloorError)
def _parse_graph(content: bytes) -> nx.Graph:
    """The graph in a node-link JSON, with all attributes; ValidationError for other content."""
    node_link = _NodeLink.model_validate_json(content)
    graph = nx.Graph()
    graph.graph.update(node_link.graph)
    graph.add_nodes_from((node.id, node.__pydantic_extra__) for node in node_link.nodes)
    graph.add_edges_from((edge.source, edge.target, edge.__pydantic_extra__) for edge in node_link.edges)
    return graph


_BLANKS = b"\xef\xbb\xbf \t\r\n"


def read_room_graphs(path: str | Path) -> list[nx.Graph]:
    """Read the graphs of a file of sampled graphs, those of chapter 7 of the thesis.

    The file is JSON with building_type, source and graphs; a graph has id, nodes (id and label) and edges (pairs of
    ids of nodes). Labels are in standard form; the graph attributes are `source`, the id of the graph, and
    `building_type`. Other members are skipped.

    Raises FloorError, with every fault in one message, for a file that holds no room graphs.
    """
    parse = validation_as(FloorError)(_Sample.model_validate_json)
    sample = read_checked(path, "file of room graphs", FloorError, parse, max_bytes=MAX_FILE_BYTES)
    return [part.room_graph(sample.building_type) for part in sample.graphs]


def read_room_graph(path: str | Path) -> nx.Graph:
    """Read the room graph of a building from graph.json, GraphML, or a file that read_building reads.

    The content decides which of them it is. Nodes keep their ids and attributes; `label` is in standard form, None if
    the file has none. The graph attribute `source` is the name of the file; `building_type`, in lower case, exists if
    the graph has one or the floor has a given type. Warnings are those of read_building.

    Raises FloorError, in one line, for a file that holds no room graph.
    """
    file = check_input_file(path, "room graph", FloorError)
    try:
        graph = _read_any_graph(file)
        _standardise_graph(graph, file)
    except BuildingError as exception:
        raise FloorError(f"{exception}; a room graph may also be graph.json or GraphML") from exception
    except OSError as exception:
        raise FloorError(f"cannot read the room graph {short_repr(file)}: {exception}") from exception
    graph.graph["source"] = file.name
    return graph


def read_floor_graph(path: str | Path) -> nx.Graph:
    """The room graph of a file, or of the folder that `pianta read` wrote, as `--previous` takes it.

    Raises FloorError, in one line.
    """
    file = Path(path)
    return read_room_graph(file / FLOOR_FILE if file.is_dir() else file)


def _read_any_graph(file: Path) -> nx.Graph:
    """The room graph in a GraphML, a graph.json or a building file; FloorError for a file of several graphs."""
    # Imported late: writing a graph needs none of the other readers.
    from pianta.io.buildings.read import read_building
    from pianta.io.graphml import read_graphml

    with file.open("rb") as stream:
        start = stream.read(1000).lstrip(_BLANKS)
    if file.suffix.lower() == ".graphml" or b"<graphml" in start:
        return read_graphml(file)
    names = _names_in_json(file) if start[:1] == b"{" else frozenset()
    if "nodes" in names:
        return read_graph(file)
    if "graphs" in names:
        raise FloorError(f"{short_repr(file)} holds several room graphs, read them with read_room_graphs")
    floor = read_building(file)
    graph = floor.graph()
    if floor.given_type is not None:
        graph.graph["building_type"] = floor.given_type
    return graph


def _names_in_json(file: Path) -> frozenset[str]:
    """The member names of a JSON object; empty for a file that is too large or no JSON, which read_building refuses."""
    if file.stat().st_size > MAX_FILE_BYTES:
        return frozenset()
    try:
        content = from_json(file.read_bytes().lstrip(_BLANKS))
    except ValueError:
        return frozenset()
    return frozenset(content)


def _standardise_graph(graph: nx.Graph, file: Path) -> None:
    """Set each node's label, or None, and the graph's building type, if any, in standard form."""
    faults = [f"node {short_repr(node)} has an edge to itself" for node in nx.nodes_with_selfloops(graph)]
    for node, attributes in graph.nodes(data=True):
        label = attributes.setdefault("label", None)
        try:
            attributes["label"] = None if label is None else standard_name(_checked_text(label))
        except LabelError as exception:
            faults.append(f"the label of node {short_repr(node)}: {exception}")
    building_type = graph.graph.pop("building_type", None)
    try:
        if building_type is not None:
            graph.graph["building_type"] = standard_building_type(_checked_text(building_type))
    except LabelError as exception:
        faults.append(f"its building_type: {exception}")
    if faults:
        raise FloorError(f"graph {short_repr(file)} is no room graph: {join_faults(faults)}")


def _checked_text(name: object) -> str:
    if not isinstance(name, str):
        raise LabelError(f"the name {short_repr(name)} is no text, give a word")
    return name


_Id = int | str


class _Part(BaseModel):
    """An object in the file; members without a field are skipped."""

    model_config = ConfigDict(defer_build=True, strict=True, frozen=True)


class _SampledNode(_Part):
    id: _Id
    label: Annotated[str, AfterValidator(standard_name)]


class _SampledGraph(_Part):
    id: str
    nodes: list[_SampledNode]
    edges: list[tuple[_Id, _Id]]

    @model_validator(mode="after")
    def _check(self) -> _SampledGraph:
        """Raise ValueError for equal nodes or edges, edges with one end, and edges to nodes that do not exist."""
        nodes = Counter(node.id for node in self.nodes)
        pairs = Counter(frozenset(edge) for edge in self.edges)
        faults = [f"node {short_repr(node)} occurs {count} times" for node, count in nodes.items() if count > 1]
        for pair, count in pairs.items():
            ends = sorted(pair, key=str)
            edge = f"edge {' to '.join(map(short_repr, ends))}"
            faults += [
                f"{edge} leads to node {short_repr(end)}, which does not exist" for end in ends if end not in nodes
            ]
            faults += [f"{edge} has one end"] if len(ends) == 1 else []
            faults += [f"{edge} occurs {count} times"] if count > 1 else []
        if faults:
            raise ValueError(join_faults(faults))
        return self

    def room_graph(self, building_type: str) -> nx.Graph:
        """The graph, with its id as source."""
        graph = nx.Graph(source=self.id, building_type=building_type)
        graph.add_nodes_from((node.id, {"label": node.label}) for node in self.nodes)
        graph.add_edges_from(self.edges)
        return graph


class _Sample(_Part):
    building_type: Annotated[str, AfterValidator(standard_building_type)]
    source: str
    graphs: list[_SampledGraph]

    @model_validator(mode="after")
    def _check_ids(self) -> _Sample:
        ids = Counter(graph.id for graph in self.graphs)
        faults = [f"graph {short_repr(name)} occurs {count} times" for name, count in ids.items() if count > 1]
        if faults:
            raise ValueError(join_faults(faults))
        return self
