"""The rules of Nav2's graph loader, as its README and source state them: a checker that shares no code with pianta."""

import json
import math
from typing import Any

TRIGGERS = {"NODE", "ON_ENTER", "ON_EXIT"}
CONVENTIONS = {"speed_limit": (0, 100)}


def find_broken_rules(text: str) -> list[str]:
    """A line for each rule that a route graph breaks; none for a graph that loads and means what it says."""
    graph = json.loads(text, parse_constant=lambda name: [name])
    if graph.get("type") != "FeatureCollection":
        return ["it is no FeatureCollection"]
    by_type: dict[str, list[Any]] = {}
    for feature in graph["features"]:
        by_type.setdefault(feature["geometry"]["type"], []).append(feature)
    nodes = by_type.pop("Point", [])
    edges = [*by_type.pop("LineString", []), *by_type.pop("MultiLineString", [])]
    faults = [f"geometry {name} is skipped without a message" for name in by_type]
    faults += ["malformed: no nodes"] * (not nodes) + ["malformed: no edges"] * (not edges)
    for node in nodes:
        faults += check_node(node)
    for edge in edges:
        faults += check_edge(edge)
    return faults + check_whole(nodes, edges)


def check_node(node: dict[str, Any]) -> list[str]:
    properties, coordinates = node["properties"], node["geometry"]["coordinates"]
    faults = [] if is_id(properties.get("id")) else [f"node id {properties.get('id')!r} is not unsigned"]
    if len(coordinates) < 2 or not all(is_number(value) for value in coordinates[:2]):
        faults.append(f"node {properties.get('id')} has coordinates {coordinates}")
    if not isinstance(properties.get("frame"), str):
        faults.append(f"node {properties.get('id')} has no frame")
    return faults + check_properties(properties)


def check_edge(edge: dict[str, Any]) -> list[str]:
    properties = edge["properties"]
    faults = [
        f"edge {properties.get('id')} has {key} {properties.get(key)!r}"
        for key in ("id", "startid", "endid")
        if not is_id(properties.get(key))
    ]
    if "cost" in properties and not (is_number(properties["cost"]) and properties["cost"] >= 0):
        faults.append(f"edge {properties.get('id')} has cost {properties['cost']!r}")
    if not isinstance(properties.get("overridable", True), bool):
        faults.append(f"edge {properties.get('id')} has overridable {properties['overridable']!r}")
    return faults + check_properties(properties)


def check_properties(properties: dict[str, Any]) -> list[str]:
    """Metadata and operations of a node or an edge."""
    name, metadata = properties.get("id"), properties.get("metadata", {})
    if not isinstance(metadata, dict):
        return [f"metadata of {name} is no object"]
    faults = [f"metadata of {name}: {fault}" for fault in check_object(metadata)]
    operations = properties.get("operations", [])
    return faults + [
        f"operation {operation} of {name}"
        for operation in (operations.values() if isinstance(operations, dict) else operations)
        if not isinstance(operation.get("type"), str) or operation.get("trigger") not in TRIGGERS
    ]


def check_object(values: dict[str, Any]) -> list[str]:
    faults = []
    for key, value in values.items():
        if isinstance(value, dict):
            faults += check_object(value)
        elif isinstance(value, list):
            faults += [f"{key} has a value that is no primitive"] if not all(map(is_primitive, value)) else []
        elif not is_primitive(value):
            faults.append(f"{key} is {value!r}")
        if key in CONVENTIONS and not CONVENTIONS[key][0] <= value <= CONVENTIONS[key][1]:
            faults.append(f"{key} is {value!r}")
        if key == "class" and not isinstance(value, str):
            faults.append(f"class is {value!r}, no text")
    return faults


def check_whole(nodes: list[Any], edges: list[Any]) -> list[str]:
    """Ids are unique over nodes and edges; ends exist; frames agree."""
    ids = [each["properties"].get("id") for each in (*nodes, *edges)]
    faults = [f"id {number} occurs again" for index, number in enumerate(ids) if number in ids[:index]]
    node_ids = {node["properties"].get("id") for node in nodes}
    for edge in edges:
        ends = [edge["properties"].get(key) for key in ("startid", "endid")]
        faults += [f"end {end} is no node" for end in ends if end not in node_ids]
        faults += [f"edge from {ends[0]} to itself"] if ends[0] == ends[1] else []
    frames = {node["properties"].get("frame") for node in nodes}
    return faults + ([f"frames {frames}"] if len(frames) > 1 else [])


def is_id(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**32


def is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def is_primitive(value: object) -> bool:
    return isinstance(value, str | bool) or is_number(value)
