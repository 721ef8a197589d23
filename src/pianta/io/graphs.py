"""graph.json: the topological graph of a floor as networkx node-link JSON."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import networkx as nx
from pydantic import AfterValidator, BaseModel, ConfigDict, JsonValue, ValidationError, model_validator

from pianta.errors import FloorError
from pianta.io._faults import describe_validation, join_faults
from pianta.io._files import checked_input, shown, written_atomically

MAX_FILE_BYTES = 64 * 2**20


def save_graph(graph: nx.Graph, path: str | Path) -> None:
    """Write a graph in node-link form, nodes and edges in the graph's order; read_graph gives back an equal graph.

    Raises FloorError for attributes that JSON does not have (NaN, tuples, objects), PiantaError when the file cannot be
    written.
    """
    try:
        content = json.dumps(nx.node_link_data(graph, edges="edges"), indent=1, allow_nan=False).encode()
        if not nx.utils.graphs_equal(_parse_graph(content), graph):
            raise FloorError("it has attributes that node-link JSON cannot hold, such as tuples or a node's `id`")
    except (ValueError, TypeError, RecursionError) as exception:
        raise FloorError(f"cannot save the graph as {shown(path)}: {exception}") from exception
    with written_atomically(path) as temporary:
        temporary.write_bytes(content + b"\n")


def read_graph(path: str | Path) -> nx.Graph:
    """Read an undirected graph without parallel edges from node-link JSON; `networkx.node_link_graph` does the same.

    Raises FloorError, with every fault in one message, for a file that holds no such graph.
    """
    file = checked_input(path, "graph", FloorError)
    if file.stat().st_size > MAX_FILE_BYTES:
        raise FloorError(f"graph {shown(file)} has more than {MAX_FILE_BYTES} bytes, too many for a floor")
    try:
        return _parse_graph(file.read_bytes())
    except (FloorError, OSError) as exception:
        raise FloorError(f"cannot read the graph {shown(file)}: {exception}") from exception


def _refuse_infinity(value: JsonValue) -> JsonValue:
    """The value; pydantic takes NaN, and 1e999 for infinity, which JSON does not have."""
    json.dumps(value, allow_nan=False)
    return value


_Value = Annotated[JsonValue, AfterValidator(_refuse_infinity)]


class _Node(BaseModel):
    model_config = ConfigDict(strict=True, extra="allow")
    __pydantic_extra__: dict[str, _Value]

    id: int | str


class _Edge(BaseModel):
    model_config = ConfigDict(strict=True, extra="allow")
    __pydantic_extra__: dict[str, _Value]

    source: int | str
    target: int | str


class _NodeLink(BaseModel):
    model_config = ConfigDict(strict=True)

    directed: Literal[False]
    multigraph: Literal[False]
    graph: dict[str, _Value] = {}
    nodes: list[_Node]
    edges: list[_Edge]

    @model_validator(mode="after")
    def _check_ids(self) -> _NodeLink:
        ids = Counter(node.id for node in self.nodes)
        ends = {end for edge in self.edges for end in (edge.source, edge.target)}
        faults = [f"node {shown(node)} occurs {count} times" for node, count in ids.items() if count > 1]
        faults += [
            f"an edge leads to node {shown(end)}, which does not exist" for end in sorted(ends - ids.keys(), key=str)
        ]
        if faults:
            raise ValueError(join_faults(faults))
        return self


def _parse_graph(content: bytes) -> nx.Graph:
    try:
        node_link = _NodeLink.model_validate_json(content)
    except ValidationError as exception:
        raise FloorError(describe_validation(exception)) from None
    graph = nx.Graph()
    graph.graph.update(node_link.graph)
    graph.add_nodes_from((node.id, node.__pydantic_extra__) for node in node_link.nodes)
    graph.add_edges_from((edge.source, edge.target, edge.__pydantic_extra__) for edge in node_link.edges)
    return graph
