"""The format of a file of a building, which is detected by its content and never by its name."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Any

from pydantic_core import from_json

from pianta.errors import BuildingError
from pianta.io._files import check_input_file, one_line_reason, short_repr
from pianta.io._xml import check_building_size, parse_xml


class BuildingFormat(StrEnum):
    """The formats of buildings that pianta reads."""

    LAYOUT = "layout XML"
    KTH = "KTH XML"
    MIT = "MIT XML"
    HOUSE_EXPO = "HouseExpo JSON"
    VALETUDO = "Valetudo's map JSON"
    FLOOR = "floor.geojson"


# By the name of the root element, in lower case.
_XML_FORMATS = {"building": BuildingFormat.LAYOUT, "floor": BuildingFormat.KTH, "mitquest": BuildingFormat.MIT}
_FOREIGN_ROOTS = {
    "svg": "an SVG drawing",
    "osm": "OpenStreetMap XML",
    "indoorfeatures": "IndoorGML",
    "html": "a web page",
}
_BLANKS = b"\xef\xbb\xbf \t\r\n"


def detect_building_format(path: str | Path) -> BuildingFormat:
    """The format of a file.

    Raises BuildingError, in one line that describes the content, for other formats.
    """
    file, building_format, description, _ = _inspect(path)
    if building_format is None:
        formats = ", ".join(BuildingFormat)
        raise BuildingError(
            f"building {short_repr(file)} is {description}, which pianta cannot read, give one of {formats}"
        )
    return building_format


def open_building(path: str | Path, expected: BuildingFormat) -> tuple[Path, Any]:
    """A file of the expected format, and its content: the root element of an XML, the bytes of a JSON.

    Raises BuildingError, in one line that describes the content, for other formats.
    """
    file, building_format, description, content = _inspect(path)
    if building_format is not expected:
        remedy = "read it with read_building" if building_format else "give another file"
        raise BuildingError(f"building {short_repr(file)} is {description} and not {expected}, {remedy}")
    return file, content


def _inspect(path: str | Path) -> tuple[Path, BuildingFormat | None, str, Any]:
    """The file, its format (None if unknown), a description of it, and its content as of open_building."""
    file = check_input_file(path, "building", BuildingError)
    with file.open("rb") as stream:
        is_json = stream.read(1000).lstrip(_BLANKS)[:1] in {b"{", b"["}
    if is_json:
        check_building_size(file)
        content = file.read_bytes()
        return file, *_detect_json(file, content), content
    root = parse_xml(file)
    tag = root.tag.rpartition("}")[2]  # without the namespace
    xml_format = _XML_FORMATS.get(tag.lower())
    other = _FOREIGN_ROOTS.get(tag.lower()) or f"XML of another kind (its root is {short_repr(tag)})"
    return file, xml_format, xml_format or other, root


def _detect_json(file: Path, content: bytes) -> tuple[BuildingFormat | None, str]:
    """The format of a JSON file, None if it is no building, and a description; BuildingError if it is no JSON."""
    try:
        members = from_json(content.lstrip(_BLANKS))
    except ValueError as exception:
        raise BuildingError(f"building {short_repr(file)} is no JSON: {one_line_reason(exception)}") from None
    names = set(members) if isinstance(members, dict) else set()
    if {"verts", "room_category"} & names:
        return BuildingFormat.HOUSE_EXPO, BuildingFormat.HOUSE_EXPO
    if "__class" in names and members["__class"] == "ValetudoMap":
        return BuildingFormat.VALETUDO, BuildingFormat.VALETUDO
    if "features" in names:
        if members.get("format") == "pianta floor":
            return BuildingFormat.FLOOR, BuildingFormat.FLOOR
        return None, "GeoJSON that pianta did not write"
    if {"nodes", "edges"} <= names:
        return None, "a graph"
    return None, f"JSON of another kind (with {short_repr(', '.join(members)) if names else 'no names'})"
