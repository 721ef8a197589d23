"""Which kind of building a file holds, told by its content and never by its name."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic_core import from_json

from pianta.errors import BuildingError
from pianta.io._files import check_input_file, one_line_reason, short_repr
from pianta.io._xml import check_file_size, parse_xml

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element


class Kind(StrEnum):
    """The files of buildings that pianta reads."""

    LAYOUT = "layout XML"
    KTH = "KTH XML"
    MIT = "MIT XML"
    HOUSE_EXPO = "HouseExpo JSON"
    FLOOR = "floor.geojson"


_KINDS_OF_ROOTS = {"building": Kind.LAYOUT, "floor": Kind.KTH, "mitquest": Kind.MIT}
_FOREIGN_ROOTS = {
    "svg": "an SVG drawing",
    "osm": "OpenStreetMap XML",
    "indoorfeatures": "IndoorGML",
    "html": "a web page",
}
_BLANKS = b"\xef\xbb\xbf \t\r\n"


def kind_of_building(path: str | Path) -> Kind:
    """The kind of a file.

    Raises BuildingError, in one line that names what the file looks like, when it is none of the kinds.
    """
    file = check_input_file(path, "building", BuildingError)
    kind, looks = _look_at_json(file) if _starts_as_json(file) else _look_at_xml(parse_xml(file))
    if kind is None:
        known = ", ".join(Kind)
        raise BuildingError(f"building {short_repr(file)} is {looks}, which pianta cannot read, give one of {known}")
    return kind


def parse_building(path: str | Path, kind: Kind) -> tuple[Path, Element]:
    """A file of one of the XML kinds, and its root element.

    Raises BuildingError, in one line that names what the file looks like, when it is of another kind.
    """
    file = check_input_file(path, "building", BuildingError)
    if _starts_as_json(file):
        found, looks = _look_at_json(file)
    else:
        root = parse_xml(file)
        found, looks = _look_at_xml(root)
        if found is kind:
            return file, root
    raise BuildingError(_tell_other_kind(file, kind, found, looks))


def read_building_json(path: str | Path, kind: Kind) -> tuple[Path, bytes]:
    """A file of one of the JSON kinds, and its content, which is JSON of at most MAX_FILE_BYTES.

    Raises BuildingError, in one line that names what the file looks like, when it is of another kind.
    """
    file = check_input_file(path, "building", BuildingError)
    if _starts_as_json(file):
        found, looks = _look_at_json(file)
        if found is kind:
            return file, file.read_bytes()
    else:
        found, looks = _look_at_xml(parse_xml(file))
    raise BuildingError(_tell_other_kind(file, kind, found, looks))


def _tell_other_kind(file: Path, kind: Kind, found: Kind | None, looks: str) -> str:
    remedy = "read it with read_building" if found else "give another file"
    return f"building {short_repr(file)} is {looks} and not {kind}, {remedy}"


def _starts_as_json(file: Path) -> bool:
    with file.open("rb") as stream:
        return stream.read(1000).lstrip(_BLANKS)[:1] in {b"{", b"["}


def _look_at_xml(root: Element) -> tuple[Kind | None, str]:
    tag = root.tag.rpartition("}")[2]  # behind a namespace
    kind = _KINDS_OF_ROOTS.get(tag.lower())
    return kind, kind or _FOREIGN_ROOTS.get(tag.lower()) or f"XML of another kind (its root is {short_repr(tag)})"


def _look_at_json(file: Path) -> tuple[Kind | None, str]:
    check_file_size(file)
    try:
        content = from_json(file.read_bytes().lstrip(_BLANKS))
    except (ValueError, OSError) as exception:
        raise BuildingError(f"building {short_repr(file)} is no JSON: {one_line_reason(exception)}") from None
    names = content.keys() if isinstance(content, dict) else ()
    if {"verts", "room_category"} & set(names):
        return Kind.HOUSE_EXPO, Kind.HOUSE_EXPO
    if "features" in names:
        ours = content.get("format") == "pianta floor"
        return (Kind.FLOOR, Kind.FLOOR) if ours else (None, "GeoJSON that pianta did not write")
    if {"nodes", "edges"} <= set(names):
        return None, "a graph"
    return None, f"JSON of another kind (with {short_repr(', '.join(names)) if names else 'no names'})"
