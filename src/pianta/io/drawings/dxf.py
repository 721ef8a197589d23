"""Plans as DXF, the exchange format of AutoCAD: lines and outlines by layer, doors and stamps of blocks, and units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Floats
from pianta.errors import PlanError
from pianta.io._files import one_line_reason, short_repr
from pianta.io.drawings._drawing import DrawnStamp, DrawnText, LayerChoice, PlanDrawing, Role
from pianta.io.drawings._layers import (
    DARK,
    MAX_ARCS,
    DrawnPieces,
    bezier_points,
    chains_of_steps,
    check_plan_file,
    damage_as_plan_error,
    is_poche,
    jambs_of_leaves,
    jambs_of_swings,
    jambs_of_symbol,
    plan_error,
    require_library,
    role_of_names,
    touching_pieces,
)
from pianta.io.drawings._stamps import read_stamp

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities import DXFGraphic, Insert
    from ezdxf.path import Path as DxfPath


# Limits against hostile files.
MAX_FILE_BYTES = 64 * 2**20
MAX_ENTITIES = 300_000
MAX_DEPTH = 16  # of blocks in blocks
MAX_FIT_POINTS = 1000  # of a spline that is computed
MAX_LETTERS = 5000  # of a text, with its codes
MAX_LISTED_COUNT = 10**15  # in messages: a count may have hundreds of digits
MAX_DOOR_CHAINS = 100  # of a block that may be a door
_LISTED_LAYERS = 10  # in messages

# $INSUNITS of the DXF reference: metres of the units in which buildings are drawn.
METRES = MappingProxyType(
    {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144, 14: 0.1, 15: 10.0, 21: 1200 / 3937}
)

_CURVES = frozenset({"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"})
_CLOSED = frozenset({"LWPOLYLINE", "POLYLINE", "CIRCLE", "ELLIPSE", "SPLINE"})
_FILLED = frozenset({"SOLID", "TRACE"})
_TEXTS = frozenset({"TEXT", "MTEXT"})
# What plans have besides, and no room follows from
_ANNOTATIONS = frozenset({"DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION", "LEADER", "MULTILEADER", "MLEADER"})
_IGNORED = frozenset({"HATCH", "ATTDEF", "ATTRIB", "POINT", "VIEWPORT", "TOLERANCE", "XLINE", "RAY"}) | _ANNOTATIONS
_CLOSING_GAP = 1e-6  # of the size of an outline, between its first and its last corner
# Metres of the leaf of a door, and of a door with two
_DOOR_WIDTHS = (0.6, 2.5)
_LETTER_WIDTH = 0.85  # of the height of capitals, on average
_LINE_SPACING = 1.6  # of the height of capitals
# Colour numbers of the DXF reference.
_BY_BLOCK = 0
_BY_LAYER = 256
DWG_REMEDY = (
    "convert it to DXF: in CAD by SAVEAS, without CAD by the ODA File Converter or `dwg2dxf` of LibreDWG, both free"
)
_HEADER_BYTES = 2**20  # in which the header's variables are looked for
_END_BYTES = 200  # in which EOF is looked for


def read_dxf_plan(path: str | Path, *, layers: LayerChoice | None = None) -> PlanDrawing:
    """Read the model space of a DXF, text or binary: lines, closed outlines, filled areas, doors, stamps and texts.

    layers: those on which walls, doors and rooms are drawn; None to know them by their names.

    Blocks are taken apart, however they are nested, scaled, turned and mirrored; curves become chains of lines; frozen
    and switched-off layers are left out, and so are dimensions, patterns of hatches, and all beyond two dimensions.
    Names of layers and blocks give roles. A block named as a door is one, from jamb to jamb by the quarter circle of
    its leaf, else by the longer side of its box; a block of another name is a door if it draws a leaf and its quarter
    circle, 0.6 to 2.5 m wide. Loose quarter circles on layers of doors are doors, too; those with a leaf on other
    layers are unnamed doors. Only filled areas that are dark or walls are kept. Metres per unit are those of $INSUNITS,
    None if unknown. What cannot be read, such as meshes and external references, is skipped and counted.

    Raises PlanError, in one line, if ezdxf (pianta[cad]) is missing, for a file that is no DXF, damaged, too large, or
    has an empty model space, and for a chosen layer that the file does not have.
    Source of the format: the DXF reference of Autodesk, through ezdxf.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    document = _open_document(file)
    with damage_as_plan_error(file, "DXF"):  # ezdxf checks entities when they are used
        units = document.header.get("$INSUNITS", 0)
        metres = METRES.get(units) if isinstance(units, int) else None
        reader = _Reader(document, DrawnPieces(file), layers or LayerChoice(), metres)
        reader.read_entities(document.modelspace(), parents=())
    reader.check_choice()
    if not (reader.pieces.lines or reader.pieces.fills or reader.pieces.outlines):
        raise plan_error(file, "has no lines in its model space, draw the plan there and not on a layout")
    return reader.pieces.drawing(reader.doors(), unnamed_doors=reader.unnamed_doors(), metres_per_unit=metres)


def _open_document(file: Path) -> Drawing:
    """The parsed file; one with small faults is repaired, and one without units has the unit 0."""
    require_library(file, "ezdxf", "a DXF", "cad")
    with file.open("rb") as stream:
        start = stream.read(_HEADER_BYTES)
        stream.seek(max(0, file.stat().st_size - _END_BYTES))
        end = stream.read()
    # ezdxf would read anything as an empty drawing.
    if start.startswith((b"AC10", b"AC2.", b"MC0.0")) or b"SECTION" not in start:
        is_dwg = start.startswith((b"AC10", b"AC2.", b"MC0.0"))
        raise plan_error(file, f"is a DWG, {DWG_REMEDY}" if is_dwg else "is no DXF, save it as DXF")
    if b"EOF" not in end:
        raise plan_error(file, "is cut off, its last line is not EOF; save it again")
    try:
        document = _parse_document(file)
    except Exception as exception:
        reason = one_line_reason(exception)
        raise plan_error(file, f"is no DXF or damaged, save it again as DXF: {reason}") from exception
    if b"$INSUNITS" not in start:
        document.header["$INSUNITS"] = 0  # ezdxf assumes metres
    return document


def _parse_document(file: Path) -> Drawing:
    """The parsed file, repaired if the first attempt fails; raises the exception of the second attempt."""
    import ezdxf
    from ezdxf import recover

    try:
        return ezdxf.readfile(file)
    except Exception:  # noqa: S110  # the second attempt reports the fault
        pass
    return recover.readfile(file)[0]


@dataclass(frozen=True, eq=False)
class _Block:
    """An inserted block: its name, the layer of its entities on layer 0, its color and its direction.

    symbol: chains of the door that it draws; None if it is no door. own: its own chains, without those of blocks in it.
    """

    name: str
    layer: str
    color: int
    axis: Floats
    symbol: list[Floats] | None
    own: list[Floats] = field(default_factory=list)


@dataclass
class _Reader:
    """Reads entities into pieces, and collects the lines of each door."""

    document: Drawing
    pieces: DrawnPieces
    choice: LayerChoice = field(default_factory=LayerChoice)
    metres: float | None = None
    symbols: list[_Block] = field(default_factory=list)
    shaped: list[Floats] = field(default_factory=list)
    drawn_layers: set[str] = field(default_factory=set)
    without_doors: set[str] = field(default_factory=set)
    arcs: list[Floats] = field(default_factory=list)
    loose: list[Floats] = field(default_factory=list)
    entities: int = 0

    def check_choice(self) -> None:
        """Raise PlanError for a chosen layer that the file does not have."""
        names = sorted(self.drawn_layers)
        for pattern in (*self.choice.walls, *self.choice.doors, *self.choice.rooms):
            if not any(matches_layer(name, (pattern,)) for name in names):
                listed = ", ".join(map(short_repr, names[:_LISTED_LAYERS]))
                more = " …" if len(names) > _LISTED_LAYERS else ""
                raise plan_error(self.pieces.file, f"has no layer {short_repr(pattern)}, it has {listed}{more}")

    def read_entities(self, entities: Iterable[DXFGraphic], *, parents: tuple[_Block, ...]) -> None:
        """Read entities inside blocks; parents: these blocks, from the outermost to the innermost."""
        for entity in entities:
            self._count(1)
            layer = _layer_of(entity, parents)
            self.drawn_layers.add(layer)
            if entity.dxf.get("invisible", 0) or self._is_frozen(layer):
                continue
            if entity.dxftype() == "INSERT":
                self._read_or_skip_block(entity, layer, parents)
            elif not self._is_off(layer):
                self._read_or_skip(entity, layer, parents)

    def _count(self, things: int) -> None:
        """Raise PlanError for more than MAX_ENTITIES entities and placed blocks."""
        self.entities += things
        if self.entities > MAX_ENTITIES:
            raise plan_error(self.pieces.file, f"draws more than {MAX_ENTITIES} things, give one floor")

    def _read_or_skip(self, entity: DXFGraphic, layer: str, parents: tuple[_Block, ...]) -> None:
        """Read an entity that is no block; one that ezdxf cannot convert is skipped and counted."""
        try:
            self._read_piece(entity, layer, self._role_of(layer, parents), parents)
        except PlanError:
            raise
        except Exception:
            self.pieces.skipped[entity.dxftype()] += 1

    def _read_or_skip_block(self, insert: Insert, layer: str, parents: tuple[_Block, ...]) -> None:
        """Read a block; one that ezdxf cannot place, such as beyond the range of numbers, is skipped and counted."""
        try:
            self._read_block(insert, layer, parents)
        except PlanError:
            raise
        except Exception:
            self.pieces.skipped["INSERT"] += 1

    def _role_of(self, layer: str, parents: tuple[_Block, ...]) -> Role:
        """The role of what is drawn on a layer in blocks: that of the chosen layers, else by names."""
        names = [layer, *(name for block in parents[::-1] for name in (block.name, block.layer))]
        chosen: tuple[tuple[Role, tuple[str, ...]], ...] = (("wall", self.choice.walls), ("door", self.choice.doors))
        for role, patterns in chosen:
            if patterns and any(matches_layer(name, patterns) for name in (layer, *(b.layer for b in parents))):
                return role
        role = role_of_names(names)
        return "other" if any(role == each and patterns for each, patterns in chosen) else role

    def _read_block(self, insert: Insert, layer: str, parents: tuple[_Block, ...]) -> None:
        """Read an inserted block and its texts; collect the lines of a door. PlanError if nested or repeated too much.

        layer: of the block. parents: the blocks around it, from the outermost to the innermost.
        """
        if len(parents) == MAX_DEPTH:
            raise plan_error(self.pieces.file, f"has blocks more than {MAX_DEPTH} deep, explode some")
        if insert.mcount > MAX_ENTITIES:
            times = insert.mcount if insert.mcount < MAX_LISTED_COUNT else f"{MAX_LISTED_COUNT} and more"
            raise plan_error(self.pieces.file, f"repeats a block {times} times, give one floor")
        # Blocks without content take time, too
        self._count(max(insert.mcount, 1) - 1)
        if not self._is_off(layer):
            self._read_attributes(insert)
        definition = insert.block()
        if definition is not None and definition.block is not None and definition.block.is_xref:
            self.pieces.skipped["external reference"] += 1
            return
        within_door = any(block.symbol is not None for block in parents)
        is_door = not within_door and self._is_door_block(insert.dxf.name, layer)
        for single in insert.multi_insert() if insert.mcount > 1 else (insert,):
            axis = np.array(single.matrix44().ux.vec2) if is_door else np.array([1.0, 0.0])
            length = np.hypot(*axis)
            axis = axis / length if np.isfinite(length) and length > 0 else np.array([1.0, 0.0])
            block = _Block(insert.dxf.name, layer, _color_of(insert, parents), axis, [] if is_door else None)
            self.read_entities(single.virtual_entities(), parents=(*parents, block))
            if block.symbol:
                self.symbols.append(block)
            elif not within_door and not is_door and block.name not in self.without_doors:
                doors = self._doors_of_shape(block.own)
                self.shaped += doors
                if not doors:
                    self.without_doors.add(block.name)

    def _is_door_block(self, name: str, layer: str) -> bool:
        """Whether a block is a door by its name or its layer."""
        if self.choice.doors:
            return matches_layer(layer, self.choice.doors)
        return role_of_names([name, layer]) == "door"

    def _doors_of_shape(self, chains: list[Floats]) -> list[Floats]:
        """The doors that a block draws whose name says nothing: leaves with arcs, as wide as doors are."""
        arcs = [chain for chain in chains if len(chain) > 2]
        if not arcs or len(chains) > MAX_DOOR_CHAINS or self.choice.doors:
            return []
        doors = jambs_of_leaves(arcs, np.concatenate([_lines_of_chain(chain) for chain in chains]))
        return [door for door in doors if self._is_as_wide_as_doors(door)]

    def _is_as_wide_as_doors(self, door: Floats) -> bool:
        least, most = _DOOR_WIDTHS
        return self.metres is None or least <= float(np.hypot(*(door[1] - door[0]))) * self.metres <= most

    def _read_attributes(self, insert: Insert) -> None:
        """Read the visible attributes of a block as texts, and all of them as the stamp of a room."""
        for attribute in insert.attribs:
            _shorten(attribute)
        visible = [attribute for attribute in insert.attribs if not attribute.is_invisible]
        for attribute in visible:
            self._read_text(attribute)
        hidden = [attribute for attribute in insert.attribs if attribute.is_invisible]
        texts = [(str(each.dxf.tag), _decode(str(each.plain_text()))) for each in (*visible, *hidden)]
        stamp = read_stamp(texts)
        if stamp and visible:
            x, y = np.mean([[text.x, text.y] for text in map(_locate_attribute, visible)], axis=0).tolist()
            number, name, area = (stamp.get(key, "") for key in ("number", "name", "area"))
            self.pieces.add_stamp(DrawnStamp(x, y, number, name, area))
        elif stamp:
            x, y, _ = insert.ocs().to_wcs(insert.dxf.insert)
            self.pieces.add_stamp(
                DrawnStamp(x, y, stamp.get("number", ""), stamp.get("name", ""), stamp.get("area", ""))
            )

    def _read_piece(self, entity: DXFGraphic, layer: str, role: Role, parents: tuple[_Block, ...]) -> None:
        """Add a curve, filled area or text to the pieces, and count others; parents: as for `read_entities`."""
        from ezdxf import path

        entity_type = entity.dxftype()
        if entity_type in _CURVES:
            width = float(entity.dxf.get("const_width", 0) or 0) if entity_type == "LWPOLYLINE" else 0.0
            through = _many_fit_points(entity)
            chains = list(_chains_of_path(path.make_path(entity))) if through is None else [through]
            for chain in chains:
                self._add_line(chain, layer, role, width, parents)
            if chains and entity_type in _CLOSED and role != "door":
                self._add_outline(np.concatenate(chains), layer, is_closed=bool(getattr(entity, "is_closed", False)))
        elif entity_type in _FILLED:
            self._add_area([_points_of_path(path.make_path(entity))], entity, role, parents)
        elif entity_type in {"HATCH", "MPOLYGON"}:
            rings = [_points_of_path(ring) for ring in path.from_hatch(entity)]
            self.pieces.add_outline(_shell_first([_open_ring(ring) for ring in rings]), layer)
            if role == "wall" or entity.dxf.get("solid_fill", 0):
                self._add_area(rings, entity, role, parents)
        elif entity_type in _TEXTS:
            self._read_text(entity)
        elif entity_type not in _IGNORED:
            self.pieces.skipped[entity_type] += 1

    def _add_outline(self, points: Floats, layer: str, *, is_closed: bool) -> None:
        """Add an outline whose last corner is its first one, or that is marked as closed."""
        if len(points) < 3 or (self.choice.rooms and not matches_layer(layer, self.choice.rooms)):
            return
        gap, size = np.hypot(*(points[-1] - points[0])), np.ptp(points, axis=0).max()
        if is_closed or gap <= _CLOSING_GAP * size:
            self.pieces.add_outline([_open_ring(points)], layer)

    def _add_line(self, chain: Floats, layer: str, role: Role, width: float, parents: tuple[_Block, ...]) -> None:
        """Add a chain, shape (N, 2), to the pieces; if it draws a door, also to its block or to the loose lines.

        width: of the line. parents: the blocks around it, from the outermost to the innermost.
        """
        if not self.pieces.add_chain(chain, role, width=width, layer=layer):
            return
        symbol = next((block.symbol for block in parents if block.symbol is not None), None)
        if symbol is not None:
            symbol.append(chain)
        elif role == "door":
            self.loose.append(chain)
        elif parents:
            if len(parents[-1].own) <= MAX_DOOR_CHAINS:
                parents[-1].own.append(chain)
        elif 2 < len(chain) <= MAX_DOOR_CHAINS:
            self.arcs.append(chain)

    def _add_area(self, rings: list[Floats], entity: DXFGraphic, role: Role, parents: tuple[_Block, ...]) -> None:
        if role == "wall" or (role == "other" and self._is_dark(entity, parents)):
            self.pieces.add_fill(rings, role, layer=_layer_of(entity, parents))

    def _read_text(self, entity: DXFGraphic) -> None:
        self.pieces.add_text(_locate_attribute(entity))

    def doors(self) -> list[Floats]:
        """The doors of blocks, then those of loose quarter circles, each shape (2, 2)."""
        walls = self.pieces.wall_ends()
        block_doors = (jambs_of_symbol(block.symbol or [], axis=block.axis, walls=walls) for block in self.symbols)
        loose_doors = (jambs_of_swings(group, walls=walls) for group in touching_pieces(self.loose))
        return [door for doors in (*block_doors, *loose_doors, self.shaped) for door in doors]

    def unnamed_doors(self) -> list[Floats]:
        """The doors of loose leaves with their arcs on layers that are not named as doors, each shape (2, 2)."""
        if not self.arcs or self.choice.doors:
            return []
        lines = np.concatenate([_lines_of_chain(chain) for chain in self.pieces.chains])
        return [door for door in jambs_of_leaves(self.arcs[:MAX_ARCS], lines) if self._is_as_wide_as_doors(door)]

    def _is_frozen(self, layer: str) -> bool:
        return layer in self.document.layers and self.document.layers.get(layer).is_frozen()

    def _is_off(self, layer: str) -> bool:
        return layer in self.document.layers and self.document.layers.get(layer).is_off()

    def _is_dark(self, entity: DXFGraphic, parents: tuple[_Block, ...]) -> bool:
        """Whether a filled area is dark on paper; color 7, white on a screen, is black on paper."""
        from ezdxf import colors

        if entity.rgb is not None:
            return is_poche(np.array(entity.rgb) / 255)
        color = _color_of(entity, parents)
        if color == _BY_LAYER:
            layer = _layer_of(entity, parents)
            color = abs(self.document.layers.get(layer).color) if layer in self.document.layers else 7
        # Colors of an index are pens, and a red pen usually prints black
        return color in {_BY_BLOCK, 7} or bool(colors.luminance(colors.aci2rgb(min(color, 255))) <= DARK)


def matches_layer(name: str, patterns: Iterable[str]) -> bool:
    """Whether the name of a layer is one of those that a user gives, in any case, with * for any letters."""
    return any(fnmatchcase(name.casefold(), pattern.strip().casefold()) for pattern in patterns)


def _lines_of_chain(chain: Floats) -> Floats:
    """The straight lines of a chain, shape (N, 2, 2)."""
    return np.stack([chain[:-1], chain[1:]], axis=1)


def _open_ring(points: Floats) -> Floats:
    """A ring without its first corner at the end, and without corners twice in a row, shape (N, 2)."""
    if len(points) < 2:
        return points
    points = points[np.append(True, np.diff(points, axis=0).any(axis=1))]
    gap, size = np.hypot(*(points[-1] - points[0])), np.ptp(points, axis=0).max()
    return points[:-1] if gap <= _CLOSING_GAP * size else points


def _shell_first(rings: list[Floats]) -> list[Floats]:
    """Rings of a hatch, each shape (N, 2), the one with the largest box first."""
    return sorted((ring for ring in rings if len(ring) >= 3), key=lambda ring: -float(np.prod(np.ptp(ring, axis=0))))


def _layer_of(entity: DXFGraphic, parents: tuple[_Block, ...]) -> str:
    """The layer of an entity; for layer 0 in a block, the layer of the block."""
    layer = str(entity.dxf.get("layer", "0"))
    return parents[-1].layer if layer == "0" and parents else layer


def _color_of(entity: DXFGraphic, parents: tuple[_Block, ...]) -> int:
    color = int(entity.dxf.get("color", _BY_LAYER))
    return parents[-1].color if color == _BY_BLOCK and parents else color


def _chains_of_path(path: DxfPath) -> Iterator[Floats]:
    for part in path.sub_paths():
        yield from chains_of_steps(np.array(part.start.vec2), _steps_of_path(part))


def _many_fit_points(entity: DXFGraphic) -> Floats | None:
    """The points, shape (N, 2), of a spline that is given by many points on it; None for all other entities.

    They are as good as the curve, for which ezdxf would solve equations of N × N numbers.
    """
    if entity.dxftype() != "SPLINE" or len(entity.control_points) or len(entity.fit_points) <= MAX_FIT_POINTS:
        return None
    points = np.array([(x, y) for x, y, _ in entity.fit_points], float)
    return np.vstack([points, points[:1]]) if entity.closed else points


def _steps_of_path(path: DxfPath) -> Iterator[Floats]:
    at = np.array(path.start.vec2)
    for command in path.commands():
        points = _points_of_command(at, command)
        at = points[-1]
        yield points


def _points_of_command(start: Floats, command: Any) -> Floats:  # noqa: ANN401  # a union of named tuples
    """The points, shape (N, 2), of a straight line or Bézier curve of a path, without the one where it starts."""
    from ezdxf.path import Command

    end = np.array(command.end.vec2)
    if command.type == Command.CURVE4_TO:
        return bezier_points(np.array([start, command.ctrl1.vec2, command.ctrl2.vec2, end]))[1:]
    if command.type == Command.CURVE3_TO:
        return bezier_points(np.array([start, command.ctrl.vec2, end]))[1:]
    return end[None]


def _points_of_path(path: DxfPath) -> Floats:
    """All points along a path, shape (N, 2)."""
    return np.concatenate([np.zeros((0, 2)), *_chains_of_path(path)])


def _decode(text: str) -> str:
    r"""A text on one line, with the signs that old files write as \U+00B2."""
    from ezdxf.lldxf.encoding import decode_dxf_unicode

    return " ".join(decode_dxf_unicode(text).split())


def _shorten(entity: DXFGraphic) -> None:
    """Cut the content of a text to MAX_LETTERS: ezdxf takes minutes for megabytes of it."""
    if entity.dxftype() == "MTEXT":
        entity.text = entity.text[:MAX_LETTERS]
    else:
        entity.dxf.text = str(entity.dxf.get("text", ""))[:MAX_LETTERS]


def _locate_attribute(attribute: DXFGraphic) -> DrawnText:
    _shorten(attribute)
    return _locate_mtext(attribute) if attribute.dxftype() == "MTEXT" else _locate_text(attribute)


def _locate_text(entity: DXFGraphic) -> DrawnText:
    """A TEXT or ATTRIB; its middle is computed from the usual width of letters, for ezdxf measures no fonts."""
    text = _decode(str(entity.plain_text()))
    align, start, end = entity.get_placement()
    frame = entity.ocs()
    height = float(entity.dxf.height)
    turn = np.radians(float(entity.dxf.get("rotation", 0)))
    angle = float(frame.to_wcs((np.cos(turn), np.sin(turn), 0)).angle)
    width = len(text) * _LETTER_WIDTH * height * float(entity.dxf.get("width", 1))
    name = align.name
    if name in {"ALIGNED", "FIT"}:
        start, across, up = (start + end) / 2, 0.0, 0.5
    else:
        across = {"L": 0.5, "R": -0.5}.get("L" if "LEFT" in name else "R" if "RIGHT" in name else "", 0.0)
        up = -0.5 if name.startswith("TOP") else 0.0 if "MIDDLE" in name else 0.5
    x, y, _ = frame.to_wcs(start)
    return _shift_text(text, (x, y), (across * width, up * height), height, angle)


def _locate_mtext(entity: DXFGraphic) -> DrawnText:
    """An MTEXT; its lines become one text, in the middle of all."""
    lines = [_decode(line) for line in entity.plain_text(split=True)]
    height = float(entity.dxf.char_height)
    width = max(map(len, lines), default=0) * _LETTER_WIDTH * height
    total = height + (len(lines) - 1) * _LINE_SPACING * height
    row, col = divmod(int(entity.dxf.get("attachment_point", 1)) - 1, 3)
    shift = ((0.5 - col / 2) * width, (row / 2 - 0.5) * total)
    x, y, _ = entity.dxf.insert
    return _shift_text(" ".join(filter(None, lines)), (x, y), shift, height, np.radians(float(entity.get_rotation())))


def _shift_text(
    text: str, point: tuple[float, float], shift: tuple[float, float], height: float, angle: float
) -> DrawnText:
    """A text whose middle is `shift` away from a point; shift: along and across its base line.

    angle: of the base line, radians. Lengths are in the unit of the drawing.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = point[0] + cos * shift[0] - sin * shift[1], point[1] + sin * shift[0] + cos * shift[1]
    return DrawnText(text, float(x), float(y), height, float(angle))
