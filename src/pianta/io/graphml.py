"""GraphML: room graphs for yEd, Gephi and networkx, with the attribute types that their tables can show.

Attributes are texts, integers, numbers and booleans. A key is declared for each name and type; a name with values of
several types has several keys. networkx has a reader and a writer, too, which lose carriage returns and attributes
called `id`, stop at the first fault, and accept NaN, repeated nodes and edges to missing nodes.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, SubElement, indent, tostring

import networkx as nx
import numpy as np
from defusedxml import DefusedXmlException, ElementTree

from pianta.errors import FloorError
from pianta.io._checked import read_checked, save_checked
from pianta.io._faults import join_faults
from pianta.io._files import check_byte_count, one_line_reason, short_repr
from pianta.io._xml import MAX_FILE_BYTES

NAMESPACE = "http://graphml.graphdrawing.org/xmlns"
MAX_INTEGER = 2**63 - 1

_Value = str | bool | int | float

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_INTEGER_ID = re.compile("0|-?[1-9][0-9]{0,17}")


def save_graphml(graph: nx.Graph, path: str | Path) -> None:
    """Write an undirected graph without parallel edges as GraphML, in UTF-8, nodes and edges in the graph's order.

    Attributes are texts, integers of 64 bits, finite numbers and booleans, of Python or numpy. A dict or list becomes
    its JSON text; None is left out. Equal graphs give equal bytes.
    read_graphml returns an equal graph if attributes are flat, and ids are all integers, or texts not all of digits.

    Raises FloorError, with every fault in one message, for other graphs, ids and attributes and for characters that XML
    does not have; PiantaError if the file cannot be written.
    """
    save_checked(path, "graph", FloorError, lambda: _dump_graph(graph))


def read_graphml(path: str | Path) -> nx.Graph:
    """Read an undirected graph without parallel edges from GraphML.

    Ids of nodes are integers if all of them are written as integers of at most 18 digits, else texts. Nodes and edges
    without a value get the default of a key. The text of a node drawn in yEd becomes its `label` unless it has one;
    other drawings, ids of edges and ports are skipped.

    Raises FloorError, with every fault in one message, for a file without a graph, with several graphs or groups of
    nodes, of more than 16 MiB, or with entities.
    """
    return read_checked(path, "graph", FloorError, _parse_graph, max_bytes=MAX_FILE_BYTES)


def _dump_graph(graph: nx.Graph) -> bytes:
    """A graph as GraphML; FloorError if it is directed, has parallel edges, or has values that GraphML cannot hold."""
    if graph.is_directed() or graph.is_multigraph():
        raise FloorError("it is directed or has parallel edges, give a networkx.Graph")
    faults: list[str] = []
    keys = _KeysByType({}, faults)
    body = Element("graph", edgedefault="undirected")
    keys.add_attributes(body, "graph", graph.graph, "the graph")
    ids = _texts_of_ids(graph, faults)
    for node, attributes in graph.nodes(data=True):
        element = SubElement(body, "node", id=ids[node])
        keys.add_attributes(element, "node", attributes, f"node {short_repr(node)}")
    for source, target, attributes in graph.edges(data=True):
        element = SubElement(body, "edge", source=ids[source], target=ids[target])
        keys.add_attributes(element, "edge", attributes, f"edge {short_repr(source)} to {short_repr(target)}")
    if faults:
        raise FloorError(join_faults(faults))
    root = Element("graphml", xmlns=NAMESPACE)
    for (scope, name, type_name), key in keys.ids.items():
        SubElement(root, "key", {"id": key, "for": scope, "attr.name": name, "attr.type": type_name})
    root.append(body)
    indent(root)
    content: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    # ElementTree writes carriage returns as they are, and parsers read them as line feeds.
    content = content.replace(b"\r", b"&#13;") + b"\n"
    check_byte_count(len(content), FloorError, max_bytes=MAX_FILE_BYTES)
    return content


def _texts_of_ids(nodes: Iterable[Hashable], faults: list[str]) -> dict[Hashable, str]:
    """The ids of nodes as text; adds faults for ids of other types, equal texts, and characters that XML lacks."""
    texts = {node: str(node) for node in nodes}
    invalid = [node for node in texts if isinstance(node, bool) or not isinstance(node, str | int | np.integer)]
    faults += [
        f"node {short_repr(node)} is neither text nor an integer, rename it (networkx.convert_node_labels_to_integers)"
        for node in invalid
    ]
    faults += [f"{count} nodes are {short_repr(text)} as text, rename one" for text, count in _repeated(texts.values())]
    faults += [
        fault for node, text in texts.items() for fault in _faults_of_text(text, f"the id of node {short_repr(node)}")
    ]
    return texts


def _repeated(names: Iterable[str]) -> list[tuple[str, int]]:
    return [(name, count) for name, count in Counter(names).items() if count > 1]


def _faults_of_text(text: str, what: str) -> list[str]:
    match = _NOT_IN_XML.search(text)
    return [f"{what} has the character {short_repr(match[0])}, which XML does not have, leave it out"] if match else []


@dataclass
class _KeysByType:
    """The keys of a file during writing: their ids by scope, name and type."""

    ids: dict[tuple[str, str, str], str]
    faults: list[str]

    def add_attributes(self, element: Element, scope: str, attributes: Mapping[Hashable, object], what: str) -> None:
        """Add attributes to an element as data; what: the noun for the element in faults."""
        for name, value in attributes.items():
            attribute = f"attribute {short_repr(name)} of {what}"
            if not isinstance(name, str):
                self.faults.append(f"{attribute} has a name that is no text, rename it")
            elif value is not None:
                self._add_value(element, scope, name, value, attribute)

    def _add_value(self, element: Element, scope: str, name: str, value: object, attribute: str) -> None:
        """Add an attribute to an element, or a fault; scope: graph, node or edge. attribute: its name in faults."""
        try:
            type_name, text = _describe_value(value)
        except (ValueError, TypeError, RecursionError) as exception:
            self.faults.append(f"{attribute} {one_line_reason(exception)}")
            return
        self.faults += _faults_of_text(name, f"the name of {attribute}") + _faults_of_text(text, attribute)
        # Not d0, d1, …: Gephi reads the key d3 as the label, as in old files of yEd.
        key = self.ids.setdefault((scope, name, type_name), f"{scope}{len(self.ids)}")
        SubElement(element, "data", key=key).text = text


def _describe_value(value: object) -> tuple[str, str]:
    """The GraphML type of a value, and the value as text; the message of an error follows a noun."""
    plain: object = value.item() if isinstance(value, np.generic) else value
    match plain:
        case bool(flag):
            return "boolean", str(flag).lower()
        case int(number):
            if abs(number) > MAX_INTEGER:
                raise ValueError("has more than 64 bits, give a smaller number or text")
            return "long", str(int(number))
        case float(number):
            if not isfinite(number):
                raise ValueError(f"is {number}, give a finite number or leave it out")
            return "double", repr(float(number))
        case str(text):
            return "string", str(text)
        case dict() | list() as parts:
            try:
                return "string", json.dumps(parts, allow_nan=False, ensure_ascii=False)
            except (ValueError, TypeError, RecursionError) as exception:
                raise ValueError(f"has no JSON text: {one_line_reason(exception)}") from None
        case other:
            raise TypeError(f"is of type {type(other).__name__}, give text, a number or a boolean")


def _parse_graph(content: bytes) -> nx.Graph:
    """The graph in a GraphML; FloorError, in one message, for invalid XML, entities, or any fault of the graph."""
    try:
        root: Element = ElementTree.fromstring(content, forbid_dtd=True)
    except DefusedXmlException:
        raise FloorError("it declares a document type or entities, remove them") from None
    except (ParseError, ValueError, LookupError) as exception:
        raise FloorError(f"it is no XML: {one_line_reason(exception)}") from None
    body = _find_graph(root)
    reader = _Reader()
    reader.read_keys(root)
    graph = nx.Graph()
    graph.graph.update(reader.read_attributes(body, "graph", "the graph"))
    reader.read_nodes(body, graph)
    reader.read_edges(body, graph)
    if reader.faults:
        raise FloorError(join_faults(reader.faults))
    return graph


def _find_graph(root: Element) -> Element:
    """The one graph element of a GraphML; FloorError for other XML and for groups, directions or hyperedges."""
    tag = root.tag.rpartition("}")[2]
    graphs = root.findall("{*}graph")
    if tag != "graphml":
        raise FloorError(f"it is XML of another kind (its root is {short_repr(tag)}), give GraphML")
    if len(graphs) != 1:
        raise FloorError(f"it has {len(graphs)} graphs, give one")
    (body,) = graphs
    edges = body.get("edgedefault", "undirected")
    if edges != "undirected":
        raise FloorError(f"its edges are {short_repr(edges)}, give an undirected graph")
    if body.find("{*}hyperedge") is not None:
        raise FloorError("it has edges of many ends (hyperedge), give edges of two")
    if body.find("{*}node/{*}graph") is not None:
        raise FloorError("it has groups of nodes, ungroup them")
    return body


def _parse_boolean(text: str) -> bool:
    return {"true": True, "1": True, "false": False, "0": False}[text.strip().lower()]


def _parse_double(text: str) -> float:
    number = float(text)
    if not isfinite(number):
        raise ValueError(text)
    return number


_PARSERS: MappingProxyType[str, Callable[[str], _Value]] = MappingProxyType(
    {
        "string": str,
        "boolean": _parse_boolean,
        **dict.fromkeys(("int", "long", "integer"), int),  # Gephi also writes integer
        **dict.fromkeys(("float", "double"), _parse_double),
    }
)


class _Key(NamedTuple):
    """A declared attribute; scope: graph, node, edge or all. name: None for a drawing of yEd."""

    scope: str
    name: str | None
    type_name: str
    default: _Value | None = None


@dataclass
class _Reader:
    """Reads the elements of a file, and collects all faults."""

    keys: dict[str, _Key] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def read_keys(self, root: Element) -> None:
        """Read the declared attributes, by the ids of their keys."""
        for element in root.iterfind("{*}key"):
            key_id, name = element.get("id", ""), element.get("attr.name")
            what, type_name = f"key {short_repr(key_id)}", element.get("attr.type", "string")
            if key_id in self.keys:
                self.faults.append(f"{what} is declared more than once")
            if name is not None and type_name not in _PARSERS:
                self.faults.append(f"{what} has type {short_repr(type_name)}, give one of {', '.join(_PARSERS)}")
                type_name = "string"
            key = _Key(element.get("for", "all"), name, type_name)
            default = element.find("{*}default")
            if name is not None and default is not None:
                key = key._replace(default=self._parse_value(key, default.text, f"{what} by default"))
            self.keys[key_id] = key

    def _parse_value(self, key: _Key, text: str | None, what: str) -> _Value:
        """The value of an attribute; an empty text, and a fault, if it is not of the key's type. what: the element."""
        try:
            return _PARSERS[key.type_name](text or "")
        except (ValueError, KeyError):
            value = short_repr(text or "")
            self.faults.append(f"attribute {short_repr(key.name)} of {what} is {value}, which is no {key.type_name}")
            return ""

    def read_attributes(self, element: Element, scope: str, what: str) -> dict[str, _Value]:
        """The attributes of the graph, a node or an edge; defaults are last."""
        attributes: dict[str, _Value] = {}
        for data in element.iterfind("{*}data"):
            key = self.keys.get(data.get("key", ""))
            if key is None:
                self.faults.append(f"{what} has data of key {short_repr(data.get('key'))}, which is not declared")
            elif key.name in attributes:
                self.faults.append(f"{what} has attribute {short_repr(key.name)} twice")
            elif key.name is not None and not len(data):
                attributes[key.name] = self._parse_value(key, data.text, what)
        for key in self.keys.values():
            if key.scope in (scope, "all") and key.name is not None and key.default is not None:
                attributes.setdefault(key.name, key.default)
        yed_label = element.findtext("{*}data//{*}NodeLabel", "").strip()
        if yed_label:
            attributes.setdefault("label", yed_label)
        return attributes

    def read_nodes(self, body: Element, graph: nx.Graph) -> None:
        """Add the nodes to the graph; ids are integers if all are written so."""
        elements = body.findall("{*}node")
        texts = [element.get("id", "") for element in elements]
        self.faults += [
            f"{count} nodes have the id {short_repr(text)}, rename them" for text, count in _repeated(texts)
        ]
        self.faults += ["a node has no id, give it one" for element in elements if element.get("id") is None][:1]
        to_id = int if all(map(_INTEGER_ID.fullmatch, texts)) else str
        for text, element in zip(texts, elements, strict=True):
            graph.add_node(to_id(text))
            graph.nodes[to_id(text)].update(self.read_attributes(element, "node", f"node {short_repr(text)}"))

    def read_edges(self, body: Element, graph: nx.Graph) -> None:
        """Add the edges to the graph, which has all nodes."""
        nodes = {str(node): node for node in graph}
        for element in body.iterfind("{*}edge"):
            source, target = element.get("source", ""), element.get("target", "")
            what = f"edge {short_repr(source)} to {short_repr(target)}"
            missing = sorted({source, target} - nodes.keys())
            self.faults += [f"{what} leads to node {short_repr(end)}, which does not exist" for end in missing]
            if element.get("directed", "false") != "false":
                self.faults.append(f"{what} is directed, give an undirected graph")
            if missing:
                continue
            ends = nodes[source], nodes[target]
            if graph.has_edge(*ends):
                self.faults.append(f"{what} occurs more than once, give a graph without parallel edges")
            graph.add_edge(*ends)
            graph.edges[ends].update(self.read_attributes(element, "edge", what))
