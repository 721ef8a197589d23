"""Plans as SVG: shapes with the transforms of all their groups, and roles by ids, classes and Inkscape's labels."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
from defusedxml import DefusedXmlException, ElementTree

from pianta._types import Floats
from pianta.errors import PlanWarning
from pianta.io._files import one_line_reason, short_repr
from pianta.io.drawings._clips import MAX_CORNERS, Clip, area_of_rings, join_clips
from pianta.io.drawings._drawing import DrawnText, PlanDrawing
from pianta.io.drawings._layers import (
    PAPER,
    DrawnPieces,
    bezier_points,
    chains_of_steps,
    check_plan_file,
    is_poche,
    jambs_of_symbol,
    jambs_of_wedges,
    luminance,
    plan_error,
    require_library,
    role_of_names,
    touching_pieces,
)
from pianta.io.drawings._room_shapes import RoomShapes, names_rooms

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Style = Mapping[str, str]

# Limits against hostile files.
MAX_FILE_BYTES = 32 * 2**20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 64  # of groups in groups, with what `use` shows
MAX_NESTED = 200  # elements in elements: Python's walk through them is recursive
MAX_CORNERS_READ = 5_000_000  # of all shapes, those that `use` repeats each time
METRES_ATTRIBUTE = "data-metres-per-unit"

_CAPITAL_HEIGHT = 0.7  # of the font size, on average
_LETTER_WIDTH = 0.6  # of the font size, on average
_CIRCLE = np.linspace(0, 2 * np.pi, 65)

_GROUPS = frozenset({"svg", "g", "a", "switch"})
_SHAPES = frozenset({"line", "polyline", "polygon", "rect", "circle", "ellipse", "path"})
_LEFT_OUT = {"image": "image", "foreignObject": "foreign object"}
_INHERITED = (
    *("fill", "stroke", "stroke-width", "fill-opacity", "stroke-opacity"),
    *("font-size", "text-anchor", "visibility", "color"),
)
_PROPERTIES = (*_INHERITED, "display", "opacity", "clip-path")
_PX = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "em": 16.0}
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_TARGET = re.compile(r"url\(\s*['\"]?([^'\")]*)", re.IGNORECASE)


def read_svg_plan(path: str | Path) -> PlanDrawing:
    """Read the shapes and texts of an SVG, in the units of its outermost coordinates, y turned up.

    Transforms of groups, `use`, symbols and nested viewports are applied; hidden shapes and white ones are left out.
    Ids, classes and Inkscape's labels of a shape and the groups around it give its role; shapes of doors that touch are
    one door, from jamb to jamb by its quarter circle, else by the longer side of its box; without any, leaves with
    their arcs are the unnamed doors. Only filled areas that are dark or walls are kept. Shapes and texts are clipped by
    clip paths in user space. Closed shapes that are named rooms become outlines, with the rest of their names for a
    stamp where no text stands in them.

    Width and height of an SVG are those of the paper, so metres per unit are unknown unless its root element has an
    attribute data-metres-per-unit. Masks, markers, scripts, style sheets with combined selectors, and clips within clip
    paths or in the units of a bounding box are ignored.

    One PlanWarning counts images and damaged shapes; they are left out.
    Raises PlanError, in one line, if svgelements (pianta[svg]) is missing, and for a file that is no SVG, declares
    entities or a document type of its own, refers to anything but images outside of itself, is too large, or draws
    nothing.
    Source of the format: SVG 1.1, W3C.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    root = _parse_svg(file)
    _check_references(root, file)
    metres = _metres_per_unit(root, file)
    reader = _Reader(DrawnPieces(file), root)
    with np.errstate(all="ignore"):  # shapes beyond the range of numbers are left out later
        reader.read_element(root, _Surroundings())
    if reader.left_out:
        counts = ", ".join(f"{count} {what}{'s' if count > 1 else ''}" for what, count in reader.left_out.items())
        warnings.warn(f"plan {short_repr(file)} has {counts} that cannot be read, left out", PlanWarning, stacklevel=2)
    if not reader.pieces.lines and not reader.pieces.fills:
        raise plan_error(file, "draws no lines, give a drawn plan, or a picture as PNG")
    reader.rooms.add_to(reader.pieces)
    doors = reader.doors()
    unnamed = [] if doors else jambs_of_wedges(reader.pieces.chains)
    return reader.pieces.drawing(doors, unnamed_doors=unnamed, metres_per_unit=metres, is_on_paper=True)


class _Parser(ElementTree.DefusedXMLParser):  # type: ignore[misc]  # of a library without types
    """Ignores the name of a document type, which expat does not load, and refuses a declaration in the file itself."""

    def defused_start_doctype_decl(self, *declaration: str | int | None) -> None:
        if declaration[-1]:  # has an internal subset
            super().defused_start_doctype_decl(*declaration)


def _parse_svg(file: Path) -> Element:
    """The root element; raises PlanError for a file that is no SVG, or declares entities or a document type."""
    require_library(file, "svgelements", "an SVG", "svg")
    try:
        root: Element = ElementTree.parse(file, parser=_Parser(forbid_dtd=True)).getroot()
    except DefusedXmlException:
        raise plan_error(file, "declares entities or a document type of its own, remove them") from None
    except (ParseError, ValueError, LookupError, OSError) as exception:
        raise plan_error(file, f"is no SVG or damaged, save it again as SVG: {one_line_reason(exception)}") from None
    if _local_name(root.tag) != "svg":
        raise plan_error(file, f"is no SVG, its outermost element is {short_repr(_local_name(root.tag))}")
    depth, level = 0, [root]
    while level:
        depth, level = depth + 1, [child for element in level for child in element]
        if depth > MAX_NESTED:
            raise plan_error(file, f"has elements more than {MAX_NESTED} deep in each other, ungroup some")
    return root


def _check_references(root: Element, file: Path) -> None:
    """Raise PlanError if the SVG needs another file or address, such as a style sheet or a symbol."""
    for element in root.iter():
        # Scripts are never run, and images are left out
        if _local_name(element.tag) in {"script", "image"}:
            continue
        targets: list[str] = []
        for name, value in element.attrib.items():
            if _local_name(name) in {"href", "src"} and _local_name(element.tag) != "a":
                targets.append(value)
            targets += _TARGET.findall(value)
        if _local_name(element.tag) == "style":
            css = "".join(element.itertext())
            targets += _TARGET.findall(css) + re.findall(r"@import[^;]*", css, re.IGNORECASE)
        for target in map(str.strip, targets):
            if target and not target.startswith(("#", "data:")):
                fault = f"refers to {short_repr(target)} outside of itself, remove the reference or embed its content"
                raise plan_error(file, fault)


def _metres_per_unit(root: Element, file: Path) -> float | None:
    """The attribute data-metres-per-unit, None without it; raises PlanError unless it is a positive number."""
    text = root.get(METRES_ATTRIBUTE)
    if text is None:
        return None
    try:
        metres = float(text)
    except ValueError:
        metres = 0.0
    if not (isfinite(metres) and metres > 0):
        raise plan_error(file, f"has {METRES_ATTRIBUTE}={short_repr(text)}, give a positive number")
    return metres


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """What an element has from the groups around it.

    matrix: shape (2, 3), from an element's coordinates to the drawing's. names: of the groups, from the innermost.
    clip: in coordinates of the drawing. room: the number of the innermost element that is named a room, None without.
    depth: the number of groups. used: whether `use` refers to the element, which shows symbols.
    """

    matrix: Floats = field(default_factory=lambda: np.array([[1.0, 0, 0], [0, -1, 0]]))
    style: Style = field(default_factory=dict)
    names: tuple[str, ...] = ()
    clip: Clip = None
    room: int | None = None
    depth: int = 0
    used: bool = False

    def moved(self, matrix: Floats) -> _Surroundings:
        """The surroundings after another matrix, shape (2, 3)."""
        return replace(self, matrix=self.matrix @ _square(matrix))

    def transform(self, chain: Floats) -> Floats:
        """Points of an element, shape (N, 2), in coordinates of the drawing."""
        return np.asarray(chain @ self.matrix[:, :2].T + self.matrix[:, 2])


@dataclass
class _Reader:
    """Reads elements into pieces."""

    pieces: DrawnPieces
    root: Element
    left_out: Counter[str] = field(default_factory=Counter)
    rooms: RoomShapes = field(default_factory=RoomShapes)
    shapes: dict[int, list[Floats]] = field(default_factory=dict)  # by id() of the element, in its own coordinates
    elements: int = 0
    corners: int = 0

    def __post_init__(self) -> None:
        self.by_id = {element.get("id"): element for element in self.root.iter()}
        sheets = (element for element in self.root.iter() if _local_name(element.tag) == "style")
        self.rules = _parse_rules(" ".join("".join(sheet.itertext()) for sheet in sheets))

    def read_element(self, element: Element, around: _Surroundings) -> None:
        """Read an element and its children."""
        self.elements += 1
        if self.elements > MAX_ELEMENTS:
            raise plan_error(self.pieces.file, f"draws more than {MAX_ELEMENTS} things, give one floor")
        if around.depth > MAX_DEPTH:
            raise plan_error(
                self.pieces.file, f"has groups more than {MAX_DEPTH} deep, or one that uses itself; ungroup some"
            )
        tag = _local_name(element.tag)
        style = self._style_of(element, tag, around.style)
        if style.get("display") == "none" or _number(style.get("opacity"), 1) == 0:
            return
        own_names = tuple(_names_of(element))
        within = replace(around, style=style, names=(*own_names, *around.names), used=False)
        if names_rooms(own_names):
            within = replace(within, room=self.rooms.add_element(own_names))
        within = self._clipped(within.moved(self._transform_of(element)))
        if tag in _GROUPS or (tag == "symbol" and around.used):
            if around.depth > 0 and tag in {"svg", "symbol"}:
                within = within.moved(_viewport(element))
            for child in element:
                self.read_element(child, replace(within, depth=around.depth + 1))
        elif tag == "use":
            self._read_use(element, within)
        elif style.get("visibility", "visible") == "visible":
            self._read_leaf(element, tag, within)

    def _clipped(self, within: _Surroundings) -> _Surroundings:
        """An element's own surroundings with its clip path; as they are without one."""
        target = _TARGET.match(within.style.get("clip-path", ""))
        path = self.by_id.get(target[1].strip().removeprefix("#")) if target else None
        if path is None or _local_name(path.tag) != "clipPath" or path.get("clipPathUnits") == "objectBoundingBox":
            return within
        user_space = within.moved(self._transform_of(path))
        areas, corners = [], 0
        for child in path:
            tag = _local_name(child.tag)
            if tag in _SHAPES:
                chains = self._chains_of_leaf(child, tag, user_space.moved(self._transform_of(child)))
                rings = _rings_of_chains([chain for chain in chains if np.isfinite(chain).all()])
                corners += sum(map(len, rings))
                if corners > MAX_CORNERS:
                    return within
                areas.append(area_of_rings(rings))
        return replace(within, clip=join_clips(within.clip, [shapely.union_all(areas)]))

    def _read_use(self, element: Element, within: _Surroundings) -> None:
        """Read the element that a `use` element refers to, shifted by its x and y."""
        href = next((value for name, value in element.attrib.items() if _local_name(name) == "href"), "")
        target = self.by_id.get(href.strip().removeprefix("#")) if href else None
        if target is not None:
            shift = np.array([[1.0, 0, _number(element.get("x"))], [0, 1, _number(element.get("y"))]])
            self.read_element(target, replace(within.moved(shift), depth=within.depth + 1, used=True))

    def _read_leaf(self, element: Element, tag: str, within: _Surroundings) -> None:
        """Read a text or a shape; count what is left out."""
        if tag in _LEFT_OUT:
            self.left_out[_LEFT_OUT[tag]] += 1
        elif tag == "text":
            self._read_text(element, within)
        elif tag in _SHAPES:
            self._add_shape(self._chains_of_leaf(element, tag, within), within)

    def _chains_of_leaf(self, element: Element, tag: str, within: _Surroundings) -> list[Floats]:
        """The lines of a shape in coordinates of the drawing; none, counted in left_out, if it is damaged.

        Raises PlanError for more than MAX_CORNERS_READ, by shapes that are used again and again.
        """
        try:
            if id(element) not in self.shapes:
                self.shapes[id(element)] = _chains_of_shape(element, tag)
            chains = self.shapes[id(element)]
        except Exception:  # svgelements raises various exceptions for damaged paths
            self.left_out["damaged shape"] += 1
            return []
        self.corners += sum(map(len, chains))
        if self.corners > MAX_CORNERS_READ:
            raise plan_error(
                self.pieces.file, f"draws shapes with more than {MAX_CORNERS_READ} corners, give one floor"
            )
        return [within.transform(chain) for chain in chains]

    def _add_shape(self, chains: list[Floats], within: _Surroundings) -> None:
        """Add the dark areas and the visible lines of a shape; chains: its lines in coordinates of the drawing."""
        style, role = within.style, role_of_names(within.names)
        if within.room is not None and role == "other":
            self.rooms.add_shape(within.room, _rings_of_chains(chains), within.names)
        fill = _color_of(style, "fill", "black")
        is_area = fill is not None and (
            luminance(fill) < PAPER if role == "wall" else role == "other" and is_poche(fill)
        )
        rings = _rings_of_chains(chains) if is_area else []
        if rings:
            self.pieces.add_clipped_fill(rings, role, within.clip)
        stroke = _color_of(style, "stroke", "none")
        # Shapes with a role and no style are drawn; white shapes of a door give its position.
        is_drawn = role == "door" or (role != "other" and "stroke" not in style and not rings)
        if is_drawn or (stroke is not None and luminance(stroke) < PAPER):
            width = _number(style.get("stroke-width"), 1) * abs(np.linalg.det(within.matrix[:, :2])) ** 0.5
            for chain in chains:
                self.pieces.add_clipped_chain(chain, role, within.clip, width=width if stroke is not None else 0)

    def _read_text(self, element: Element, within: _Surroundings) -> None:
        """Read a text as one line; its middle comes from the usual width of letters, for no fonts are measured."""
        style, matrix = within.style, within.matrix
        lines = [element, *(child for child in element.iter() if _local_name(child.tag) == "tspan")]
        points = np.array([[_number(line.get(axis), np.nan) for axis in ("x", "y")] for line in lines])
        points = points[1:] if len(points) > 1 and np.isfinite(points[1:]).all() else points[:1]
        text = " ".join(" ".join(element.itertext()).split())
        size = _number(style.get("font-size"), 16)
        width = len(text) / max(1, len(points)) * _LETTER_WIDTH * size
        x, y = np.nan_to_num(points).mean(axis=0)
        x += width * {"middle": 0.0, "end": -0.5}.get(style.get("text-anchor", ""), 0.5)
        middle = within.transform(np.array([[x, y - size * _CAPITAL_HEIGHT / 2]]))[0]
        if within.clip is not None and not shapely.intersects_xy(within.clip, *middle):
            return
        along, up = matrix[:, 0], matrix[:, 1]
        height = size * _CAPITAL_HEIGHT * np.hypot(*up)
        angle = float(np.arctan2(along[1], along[0]))
        self.pieces.add_text(DrawnText(text, float(middle[0]), float(middle[1]), float(height), angle))

    def doors(self) -> list[Floats]:
        """A door for each quarter circle, and for each group of touching shapes without one, shape (2, 2)."""
        walls = self.pieces.wall_ends()
        symbols = touching_pieces(self.pieces.chains_of("door"))
        return [door for symbol in symbols for door in jambs_of_symbol(symbol, walls=walls)]

    def _style_of(self, element: Element, tag: str, outer: Style) -> Style:
        """The style of an element by its attributes, style sheets and `style`; outer: of the group around it."""
        style = {name: value for name, value in outer.items() if name in _INHERITED}
        style |= {name: element.attrib[name] for name in _PROPERTIES if name in element.attrib}
        classes = (f".{name}" for name in element.get("class", "").split())
        for selector in ("*", tag, *(f"{start}{name}" for name in classes for start in ("", tag))):
            style |= self.rules.get(selector, {})
        style |= self.rules.get(f"#{element.get('id')}", {})
        style |= _parse_declarations(element.get("style", ""))
        return {name: outer.get(name, "") if value == "inherit" else value for name, value in style.items()}

    def _transform_of(self, element: Element) -> Floats:
        """The matrix of an element's transform; the identity, counted in left_out, if it cannot be read."""
        from svgelements import Matrix

        try:
            matrix = Matrix(element.get("transform", ""))
            return np.array([[matrix.a, matrix.c, matrix.e], [matrix.b, matrix.d, matrix.f]], float)
        except Exception:  # svgelements raises various exceptions for damaged texts
            self.left_out["damaged transform"] += 1
            return np.eye(2, 3)


def _square(matrix: Floats) -> Floats:
    """The homogeneous matrix, shape (3, 3), of one of shape (2, 3)."""
    return np.vstack([matrix, [0, 0, 1]])


def _local_name(name: Any) -> str:  # noqa: ANN401  # comments have a function for a tag
    """The name of an element or attribute without its namespace."""
    return str(name).rpartition("}")[2]


def _names_of(element: Element) -> Iterator[str]:
    """The label and id of an element, then its classes."""
    for name, value in element.attrib.items():
        if _local_name(name) in {"label", "id"}:
            yield value
    yield from element.get("class", "").split()


def _number(text: str | None, default: float = 0.0) -> float:
    """The first number of a text, a length in px; the default if it has no number."""
    match = _NUMBER.search(text or "")
    if match is None or text is None:
        return default
    unit = text[match.end() : match.end() + 2].strip()
    return float(match[0]) * _PX.get(unit, 1.0)


def _parse_rules(css: str) -> dict[str, dict[str, str]]:
    """Simple selectors and their declarations; combined selectors match no element later."""
    rules: dict[str, dict[str, str]] = {}
    # Parts of a text and no expression for all of it, which would take the square of its length
    for block in _without_comments(css).split("}")[:-1]:
        before, _, body = block.rpartition("{")
        for selector in before.rpartition("{")[2].split(","):
            rules.setdefault(selector.strip(), {}).update(_parse_declarations(body))
    return rules


def _without_comments(css: str) -> str:
    """CSS without its comments; one that does not end reaches to the end."""
    first, *others = css.split("/*")
    return " ".join([first, *(other.partition("*/")[2] for other in others)])


def _parse_declarations(text: str) -> dict[str, str]:
    """The properties that are read in CSS such as "fill: none; stroke: black"."""
    pairs = (part.partition(":") for part in text.split(";"))
    stripped = ((name.strip(), value.replace("!important", "").strip()) for name, _, value in pairs)
    return {name: value for name, value in stripped if name in _PROPERTIES}


def _color_of(style: Style, what: str, default: str) -> Floats | None:
    """Red, green and blue, 0 … 1, on white of a fill or stroke, None if it is not drawn; gradients count as light."""
    from svgelements import Color

    value = style.get(what) or default
    if value in {"none", "transparent"} or _number(style.get(f"{what}-opacity"), 1) == 0:
        return None
    if value == "currentColor":
        value = style.get("color") or "black"
    if value.startswith("url("):
        return np.full(3, 0.9)
    try:
        color = Color(value)
        channels = np.array([color.red, color.green, color.blue], float) / 255
        return np.asarray(1 - color.opacity * (1 - channels))
    except Exception:  # svgelements raises various exceptions for damaged texts
        return np.zeros(3)


def _viewport(element: Element) -> Floats:
    """Matrix from the viewBox of a nested viewport to its position and size."""
    matrix = np.array([[1.0, 0, _number(element.get("x"))], [0, 1, _number(element.get("y"))]])
    box = [float(number) for number in _NUMBER.findall(element.get("viewBox", ""))]
    if len(box) != 4 or min(box[2:]) <= 0:
        return matrix
    size = np.array([_number(element.get("width"), box[2]), _number(element.get("height"), box[3])])
    scale = (size / box[2:]).min()
    shift = (size - scale * np.array(box[2:])) / 2 - scale * np.array(box[:2])
    return np.asarray(matrix @ np.array([[scale, 0, shift[0]], [0, scale, shift[1]], [0, 0, 1]]))


def _chains_of_shape(element: Element, tag: str) -> list[Floats]:
    """The lines and curves of a shape in its own coordinates, each shape (N, 2)."""
    if tag == "path":
        # A command without numbers has no point: None becomes no float
        return [np.asarray(chain, float) for chain in _chains_of_path(element.get("d", ""))]
    if tag in {"polyline", "polygon"}:
        numbers = [float(number) for number in _NUMBER.findall(element.get("points", ""))]
        points = np.array(numbers[: len(numbers) // 2 * 2]).reshape(-1, 2)
        return [np.vstack([points, points[:1]]) if tag == "polygon" else points]
    number = {name: _number(value) for name, value in element.attrib.items()}
    x, y, width, height = (number.get(name, 0.0) for name in ("x", "y", "width", "height"))
    if tag == "rect":
        corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
        return [np.array(corners)] if width and height else []
    if tag == "line":
        return [np.array([[number.get(f"{axis}{end}", 0.0) for axis in "xy"] for end in "12"])]
    radii = [number.get(name, number.get("r", 0.0)) for name in ("rx", "ry")]
    middle = [number.get("cx", 0.0), number.get("cy", 0.0)]
    return [middle + np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)]) * radii]


def _chains_of_path(data: str) -> Iterator[Floats]:
    """The points of each connected piece of a path, shape (N, 2); data: its attribute `d`."""
    from svgelements import Move, Path

    start, steps = np.zeros(2), list[Floats]()
    for segment in Path(data):
        if isinstance(segment, Move):
            yield from chains_of_steps(start, steps)
            start, steps = np.array([segment.end.x, segment.end.y]), []
        elif segment.end is not None:
            steps += _steps_of_segment(segment)
    yield from chains_of_steps(start, steps)


def _steps_of_segment(segment: Any) -> list[Floats]:  # noqa: ANN401  # the segments share no typed class
    """The points of a segment of a path after its start, in arrays of shape (N, 2)."""
    from svgelements import Arc, CubicBezier, QuadraticBezier

    if isinstance(segment, Arc):
        return [np.concatenate([step for part in segment.as_cubic_curves() for step in _steps_of_segment(part)])]
    start, end = (np.array([point.x, point.y]) for point in (segment.start, segment.end))
    if isinstance(segment, CubicBezier):
        inner = [[point.x, point.y] for point in (segment.control1, segment.control2)]
        return [bezier_points(np.array([start, *inner, end]))[1:]]
    if isinstance(segment, QuadraticBezier):
        return [bezier_points(np.array([start, [segment.control.x, segment.control.y], end]))[1:]]
    return [end[None]]


def _rings_of_chains(chains: list[Floats]) -> list[Floats]:
    """Rings of consecutive chains; those of two points are left out."""
    rings: list[list[Floats]] = []
    for chain in chains:
        if rings and len(chain) and np.array_equal(rings[-1][-1][-1], chain[0]):
            rings[-1].append(chain)
        elif len(chain) > 1:
            rings.append([chain])
    joined = [np.concatenate(ring) for ring in rings]
    return [ring for ring in joined if len(ring) > 2]
