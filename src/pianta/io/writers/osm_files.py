"""Files of OpenStreetMap: nodes, ways and relations with tags, all new, so that their ids are negative."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from shapely import MultiPoint

from pianta.errors import OptionError
from pianta.io.georeference import Georeference

DEGREE_DIGITS = 9  # a tenth of a millimetre
# Points of the map frame are one node if they are as close, metres.
SAME_DIGITS = 4
MAX_TEXT = 255  # characters of a key or value, the limit of OpenStreetMap

XY = tuple[float, float]


class OsmFile:
    """The nodes, ways and relations of a building; points are metres of the map frame, and equal ones are one node."""

    def __init__(self, georeference: Georeference | None) -> None:
        if georeference is None:
            raise OptionError("OpenStreetMap has longitudes and latitudes alone, give georeference=")
        self._georeference = georeference
        self._elements: dict[str, list[Element]] = {"node": [], "way": [], "relation": []}
        self._nodes: dict[tuple[int, float, float], Element] = {}
        self._points: list[tuple[Element, XY]] = []
        self._count = 0
        self.shortened = 0

    def add_node(self, point: XY, tags: Mapping[str, str] | None = None, *, level: int = 0) -> int:
        """The id of the node at a point of a storey; tags are added to those that it has, which stay."""
        key = level, round(point[0], SAME_DIGITS), round(point[1], SAME_DIGITS)
        if key not in self._nodes:
            self._nodes[key] = self._add("node")
            self._points.append((self._nodes[key], point))
        self._set_tags(self._nodes[key], tags or {})
        return int(self._nodes[key].get("id", "0"))

    def add_way(self, points: Iterable[XY], tags: Mapping[str, str], *, level: int = 0) -> int:
        """The id of a new way through points of a storey, closed if the last is the first."""
        return self.join_nodes([self.add_node(point, level=level) for point in points], tags)

    def join_nodes(self, nodes: Sequence[int], tags: Mapping[str, str]) -> int:
        """The id of a new way through nodes."""
        way = self._add("way")
        # Corners closer than nodes can be would be one node twice
        distinct = [node for index, node in enumerate(nodes) if index == 0 or node != nodes[index - 1]]
        for node in distinct:
            SubElement(way, "nd", {"ref": str(node)})
        self._set_tags(way, tags)
        return int(way.get("id", "0"))

    def add_multipolygon(self, rings: Iterable[int], tags: Mapping[str, str]) -> int:
        """The id of a new relation of closed ways, the first outside."""
        relation = self._add("relation")
        for index, way in enumerate(rings):
            SubElement(relation, "member", {"type": "way", "ref": str(way), "role": "inner" if index else "outer"})
        self._set_tags(relation, {"type": "multipolygon", **tags})
        return int(relation.get("id", "0"))

    def write(self, path: Path) -> None:
        """Write the file, version 0.6 of the format."""
        locations = self._georeference.to_wgs84(MultiPoint([point for _, point in self._points])).geoms
        for (node, _), location in zip(self._points, locations, strict=True):
            node.attrib |= {"lat": f"{location.y:.{DEGREE_DIGITS}f}", "lon": f"{location.x:.{DEGREE_DIGITS}f}"}
        root = Element("osm", {"version": "0.6", "generator": "pianta", "upload": "false"})
        for elements in self._elements.values():
            root.extend(elements)
        indent(root)
        ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)

    def _add(self, tag: str) -> Element:
        self._count += 1
        element = Element(tag, {"id": str(-self._count), "action": "modify", "visible": "true"})
        self._elements[tag].append(element)
        return element

    def _set_tags(self, element: Element, tags: Mapping[str, str]) -> None:
        """Add tags; those that the element has stay, for a key twice is refused: two doors can be at one node."""
        present = {tag.get("k") for tag in element.iter("tag")}
        for key, value in tags.items():
            if key in present:
                continue
            self.shortened += len(value) > MAX_TEXT
            SubElement(element, "tag", {"k": key, "v": value[:MAX_TEXT]})
