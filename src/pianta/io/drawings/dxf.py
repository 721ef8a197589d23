"""Plans as DXF, the exchange format of AutoCAD: lines by layer, blocks as doors, and units if the file has them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Floats
from pianta.io._files import one_line_reason
from pianta.io.drawings._drawing import DrawnText, PlanDrawing, Role
from pianta.io.drawings._layers import (
    DARK,
    DrawnPieces,
    bezier_points,
    chains_of_steps,
    check_plan_file,
    damage_as_plan_error,
    jambs_of_swings,
    jambs_of_symbol,
    plan_error,
    require_library,
    role_of_names,
    touching_pieces,
)

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities import DXFGraphic, Insert
    from ezdxf.path import Path as DxfPath


# Limits against hostile files.
MAX_FILE_BYTES = 64 * 2**20
MAX_ENTITIES = 300_000
MAX_DEPTH = 16  # of blocks in blocks

# $INSUNITS of the DXF reference: metres of the units in which buildings are drawn.
METRES = MappingProxyType(
    {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144, 14: 0.1, 15: 10.0, 21: 1200 / 3937}
)

_CURVES = frozenset({"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"})
_FILLED = frozenset({"SOLID", "TRACE"})
_LETTER_WIDTH = 0.85  # of the height of capitals, on average
_LINE_SPACING = 1.6  # of the height of capitals
# Colour numbers of the DXF reference.
_BY_BLOCK = 0
_BY_LAYER = 256
_HEADER_BYTES = 2**20  # in which the header's variables are looked for
_END_BYTES = 200  # in which EOF is looked for


def read_dxf_plan(path: str | Path) -> PlanDrawing:
    """Read the model space of a DXF, text or binary: lines, filled areas, doors and texts.

    Blocks are taken apart, however they are nested, scaled, turned and mirrored; curves become chains of lines; frozen
    and switched-off layers are left out, and so are dimensions, patterns of hatches, and all beyond two dimensions.
    Names of layers and blocks give roles. A block named as a door is one, from jamb to jamb by the quarter circle of
    its leaf, else by the longer side of its box; loose quarter circles on layers of doors are doors, too. Only filled
    areas that are dark or walls are kept. Metres per unit are those of $INSUNITS, None if unknown.

    Raises PlanError, in one line, if ezdxf (pianta[cad]) is missing, and for a file that is no DXF, damaged, too large,
    or has an empty model space.
    Source of the format: the DXF reference of Autodesk, through ezdxf.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    document = _open_document(file)
    reader = _Reader(document, DrawnPieces(file))
    with damage_as_plan_error(file, "DXF"):  # ezdxf checks entities when they are used
        reader.read_entities(document.modelspace(), parents=())
        units = document.header.get("$INSUNITS", 0)
    if not reader.pieces.lines and not reader.pieces.fills:
        raise plan_error(file, "has no lines in its model space, draw the plan there and not on a layout")
    return reader.pieces.drawing(reader.doors(), metres_per_unit=METRES.get(units) if isinstance(units, int) else None)


def _open_document(file: Path) -> Drawing:
    """The parsed file; one with small faults is repaired, and one without units has the unit 0."""
    require_library(file, "ezdxf", "a DXF", "cad")
    with file.open("rb") as stream:
        start = stream.read(_HEADER_BYTES)
        stream.seek(max(0, file.stat().st_size - _END_BYTES))
        end = stream.read()
    # ezdxf would read anything as an empty drawing.
    if start.startswith(b"AC10") or b"SECTION" not in start:
        what = "is a DWG" if start.startswith(b"AC10") else "is no DXF"
        raise plan_error(file, f"{what}, save it as DXF")
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

    symbol: chains of the door that it draws; None if it is no door.
    """

    name: str
    layer: str
    color: int
    axis: Floats
    symbol: list[Floats] | None


@dataclass
class _Reader:
    """Reads entities into pieces, and collects the lines of each door."""

    document: Drawing
    pieces: DrawnPieces
    symbols: list[_Block] = field(default_factory=list)
    loose: list[Floats] = field(default_factory=list)
    entities: int = 0

    def read_entities(self, entities: Iterable[DXFGraphic], *, parents: tuple[_Block, ...]) -> None:
        """Read entities inside blocks; parents: these blocks, from the outermost to the innermost."""
        for entity in entities:
            self.entities += 1
            if self.entities > MAX_ENTITIES:
                raise plan_error(self.pieces.file, f"draws more than {MAX_ENTITIES} things, give one floor")
            layer = _layer_of(entity, parents)
            if entity.dxf.get("invisible", 0) or self._is_frozen(layer):
                continue
            if entity.dxftype() == "INSERT":
                self._read_block(entity, layer, parents)
            elif not self._is_off(layer):
                names = [layer, *(name for block in parents[::-1] for name in (block.name, block.layer))]
                self._read_piece(entity, role_of_names(names), parents)

    def _read_block(self, insert: Insert, layer: str, parents: tuple[_Block, ...]) -> None:
        """Read an inserted block and its texts; collect the lines of a door. PlanError if nested or repeated too much.

        layer: of the block. parents: the blocks around it, from the outermost to the innermost.
        """
        if len(parents) == MAX_DEPTH:
            raise plan_error(self.pieces.file, f"has blocks more than {MAX_DEPTH} deep, explode some")
        if insert.mcount > MAX_ENTITIES:
            raise plan_error(self.pieces.file, f"repeats a block {insert.mcount} times, give one floor")
        if not self._is_off(layer):
            for attribute in insert.attribs:
                if not attribute.is_invisible:
                    self._read_text(attribute)
        within_door = any(block.symbol is not None for block in parents)
        is_door = not within_door and role_of_names([insert.dxf.name, layer]) == "door"
        for single in insert.multi_insert() if insert.mcount > 1 else (insert,):
            axis = np.array(single.matrix44().ux.vec2) if is_door else np.array([1.0, 0.0])
            length = np.hypot(*axis)
            axis = axis / length if np.isfinite(length) and length > 0 else np.array([1.0, 0.0])
            block = _Block(insert.dxf.name, layer, _color_of(insert, parents), axis, [] if is_door else None)
            self.read_entities(single.virtual_entities(), parents=(*parents, block))
            if block.symbol:
                self.symbols.append(block)

    def _read_piece(self, entity: DXFGraphic, role: Role, parents: tuple[_Block, ...]) -> None:
        """Add a curve, filled area or text to the pieces, and skip other entities; parents: as for `read_entities`."""
        from ezdxf import path

        entity_type = entity.dxftype()
        if entity_type in _CURVES:
            width = float(entity.dxf.get("const_width", 0) or 0) if entity_type == "LWPOLYLINE" else 0.0
            for chain in _chains_of_path(path.make_path(entity)):
                self._add_line(chain, role, width, parents)
        elif entity_type in _FILLED:
            self._add_area([_points_of_path(path.make_path(entity))], entity, role, parents)
        elif entity_type == "HATCH" and (role == "wall" or entity.dxf.get("solid_fill", 0)):
            rings = [_points_of_path(ring) for ring in path.from_hatch(entity)]
            self._add_area(rings, entity, role, parents)
        elif entity_type in {"TEXT", "MTEXT"}:
            self._read_text(entity)

    def _add_line(self, chain: Floats, role: Role, width: float, parents: tuple[_Block, ...]) -> None:
        """Add a chain, shape (N, 2), to the pieces; if it draws a door, also to its block or to the loose lines.

        width: of the line. parents: the blocks around it, from the outermost to the innermost.
        """
        if not self.pieces.add_chain(chain, role, width=width):
            return
        symbol = next((block.symbol for block in parents if block.symbol is not None), None)
        if symbol is not None:
            symbol.append(chain)
        elif role == "door":
            self.loose.append(chain)

    def _add_area(self, rings: list[Floats], entity: DXFGraphic, role: Role, parents: tuple[_Block, ...]) -> None:
        if role == "wall" or (role == "other" and self._is_dark(entity, parents)):
            self.pieces.add_fill(rings, role)

    def _read_text(self, entity: DXFGraphic) -> None:
        text = _locate_mtext(entity) if entity.dxftype() == "MTEXT" else _locate_text(entity)
        self.pieces.add_text(text)

    def doors(self) -> list[Floats]:
        """The doors of blocks, then those of loose quarter circles, each shape (2, 2)."""
        walls = self.pieces.wall_ends()
        block_doors = (jambs_of_symbol(block.symbol or [], axis=block.axis, walls=walls) for block in self.symbols)
        loose_doors = (jambs_of_swings(group, walls=walls) for group in touching_pieces(self.loose))
        return [door for doors in (*block_doors, *loose_doors) for door in doors]

    def _is_frozen(self, layer: str) -> bool:
        return layer in self.document.layers and self.document.layers.get(layer).is_frozen()

    def _is_off(self, layer: str) -> bool:
        return layer in self.document.layers and self.document.layers.get(layer).is_off()

    def _is_dark(self, entity: DXFGraphic, parents: tuple[_Block, ...]) -> bool:
        """Whether a filled area is dark on paper; color 7, white on a screen, is black on paper."""
        from ezdxf import colors

        if entity.rgb is not None:
            return bool(colors.luminance(entity.rgb) <= DARK)
        color = _color_of(entity, parents)
        if color == _BY_LAYER:
            layer = _layer_of(entity, parents)
            color = abs(self.document.layers.get(layer).color) if layer in self.document.layers else 7
        return color in {_BY_BLOCK, 7} or bool(colors.luminance(colors.aci2rgb(min(color, 255))) <= DARK)


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


def _locate_text(entity: DXFGraphic) -> DrawnText:
    """A TEXT or ATTRIB; its middle is computed from the usual width of letters, for ezdxf measures no fonts."""
    text = " ".join(str(entity.plain_text()).split())
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
    lines = [" ".join(line.split()) for line in entity.plain_text(split=True)]
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
