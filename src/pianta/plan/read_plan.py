"""A plan in, its floors out: the preprocessing of section 3.3 of the thesis, and the layout method after it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from shapely import unary_union

from pianta.errors import OptionError, PlanError, PlanWarning
from pianta.floor import Floor, scale_floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, short_repr
from pianta.io.drawings._child import read_in_child
from pianta.io.drawings._drawing import LayerChoice, PlanDrawing
from pianta.io.drawings.sweethome3d import read_sweethome3d
from pianta.io.images import Source, path_of
from pianta.layout.reconstruct import DEFAULT_METHOD, check_method
from pianta.plan.doors.lines import PlanDoors, drop_narrow_doors, find_doors
from pianta.plan.drawn_rooms.floors import read_drawn_floors
from pianta.plan.drawn_rooms.layers import describe_layers, forget_walls
from pianta.plan.scale.refined_scale import refine_scale, scale_door_px
from pianta.plan.scale.room_evidence import home_probability
from pianta.plan.scale.sheet_scale import SheetScale, find_scale
from pianta.plan.scale.spaces import Space, measure_spaces
from pianta.plan.sheets.boxes import describe_left_out, erase_boxes, find_boxes
from pianta.plan.sheets.drawn_sheet import draw_sheet
from pianta.plan.sheets.flagged_rooms import flag_rooms
from pianta.plan.sheets.floors_on_sheet import reconstruct_sheet_floors
from pianta.plan.sheets.map_or_plan import looks_like_drawing
from pianta.plan.sheets.no_rooms import leave_out
from pianta.plan.sheets.open_rooms import join_open_rooms
from pianta.plan.sheets.open_sheet import open_sheet
from pianta.plan.sheets.parts import SheetParts, find_parts
from pianta.plan.sheets.sheet import DOOR_WIDTH, PlacedText, PlanScale, Sheet
from pianta.plan.symbols.detection import find_symbols, remove_symbols
from pianta.plan.symbols.fixtures import find_fixtures, place_fixtures
from pianta.plan.symbols.poses import PlacedSymbol
from pianta.plan.symbols.templates import builtin_templates, read_symbol_folder
from pianta.plan.text.legend import find_legend
from pianta.plan.text.recognition import erase_texts, read_texts, text_reader_available
from pianta.plan.text.room_names import name_rooms
from pianta.plan.text.room_numbers import correct_room_numbers, split_room_numbers
from pianta.plan.walls.dimension_strokes import erase_dimension_lines
from pianta.plan.walls.floor_map import draw_floor_map, use_named_walls
from pianta.plan.walls.grid_strokes import erase_grid
from pianta.plan.walls.segmentation import NETWORKS, ClassMap, has_walls, segment_sheet

# Formats of buildings with storeys, in metres; all others are sheets.
STOREY_READERS: Mapping[str, Callable[[str | Path], Any]] = MappingProxyType(
    {".ifc": partial(read_in_child, "ifc"), ".sh3d": read_sweethome3d}
)
DXF_SUFFIX = ".dxf"
SVG_SUFFIX = ".svg"
MANY_FLOORS = 4  # on a sheet, from which on they may be different plans, as on a board
MIN_HOME = 0.3  # probability of a home, from which on its fixtures are looked for. Chosen by hand
MIN_SHEET_LINES = 60  # of a DXF that are worth a network: simpler plans enclose their rooms, or show none
# The frame of a storey
CELL = 0.05  # m; larger for storeys that would have too many cells
MARGIN = 1.0  # m around the rooms
MAX_SIDE_CELLS = 8000  # cells of the longer side


@dataclass(frozen=True, eq=False)
class PlanFloor:
    """A floor of a plan.

    Attributes
    ----------
    floor
        Metres, y up; of a sheet with the origin in its lower left corner, of an IFC in the frame of the model.
    grid
        The frame of the sheet: its pixels as unknown cells.
    scale
        Metres per pixel, and where they come from.
    name
        Of the storey, empty if the plan does not name it.
    elevation
        Of the storey of an IFC, metres above the zero of the model; None for a sheet.
    """

    floor: Floor
    grid: GridMap
    scale: PlanScale
    name: str = ""
    elevation: float | None = None


@dataclass(frozen=True, eq=False)
class PlanReading:
    """What was read from a plan.

    Attributes
    ----------
    floors
        The floors of a sheet, the largest first; of an IFC, the lowest first.
    sheet
        The sheet as it was opened; None for an IFC.
    symbols
        The symbols on the sheet, the best match first.
    px_per_unit
        Pixels per unit of a vector drawing; 1 where pixels are the unit.
    notes
        A line each: what was taken from which layers of a DXF and what was skipped; what a sheet shows beside its
        building, such as a legend; whether a photo was straightened, and whether a picture may be no plan.
    """

    floors: tuple[PlanFloor, ...]
    sheet: Sheet | None
    symbols: tuple[PlacedSymbol, ...] = ()
    px_per_unit: float = 1.0
    notes: tuple[str, ...] = field(default=())


def read_plan(
    source: Source,
    *,
    resolution: float | None = None,
    page: int | None = None,
    symbols: str | Path | None = None,
    method: str = DEFAULT_METHOD,
    with_symbols: bool = True,
    with_text: bool = True,
    networks: Sequence[str] = NETWORKS,
    max_cells: int = MAX_CELLS,
    wall_layers: Sequence[str] = (),
    door_layers: Sequence[str] = (),
    room_layers: Sequence[str] = (),
) -> PlanReading:
    """Read the floors of a plan: rooms with their names, and doors.

    Parameters
    ----------
    source
        A picture, DXF, SVG, PDF, IFC or .sh3d.
    resolution
        Metres per pixel of a picture, per unit of a vector drawing; None to find it in the plan.
    page
        The page of a PDF, from 1.
    symbols
        Folder with PNGs of symbols besides our own; door*.png are doors.
    method
        The layout method that finds the rooms, one of `METHODS`.
    with_symbols
        Whether to find and remove symbols, and to close the gaps of doors.
    with_text
        Whether to read text.
    networks
        The networks that segment the sheet, of which the mean counts.
    max_cells
        Pixels that a picture may have.
    wall_layers, door_layers, room_layers
        The layers of a DXF on which walls, doors and the outlines of rooms are drawn, in any case, with * for any
        letters; empty to find them.

    Returns
    -------
    PlanReading
        The floors; each has its rooms in metres, its frame and its scale.

    Raises
    ------
    PlanError
        The file is no plan, or shows no rooms.
    OptionError
        The method is unknown, an IFC is given a page, a resolution or symbols, or another file than a DXF layers.

    Warns
    -----
    PlanWarning
        The text cannot be read or is mirrored, or a sheet shows several floors.

    References
    ----------
    M. Luperto, PhD thesis, section 3.3.

    Examples
    --------
    >>> import pianta
    >>> plan = pianta.read_plan("plan.png")  # doctest: +SKIP
    >>> [room.name for room in plan.floors[0].floor]  # doctest: +SKIP
    ['Kitchen', 'Bath', None]
    """
    check_method(method)
    path = path_of(source)
    layers = LayerChoice(tuple(wall_layers), tuple(door_layers), tuple(room_layers))
    if layers and Path(path).suffix.lower() != DXF_SUFFIX:
        raise OptionError(f"plan {short_repr(path)} is no DXF, leave out the layers of walls, doors and rooms")
    if Path(path).suffix.lower() in STOREY_READERS:
        _refuse_options(path, {"page=": page, "resolution=": resolution, "symbols=": symbols})
        return PlanReading(read_storeys(path), None)
    options = _SheetOptions(resolution, method, symbols, networks, with_symbols=with_symbols, with_text=with_text)
    if Path(path).suffix.lower() == DXF_SUFFIX and page is None:
        return _read_dxf(read_in_child("dxf", path, layers=layers), path, layers, options)
    if Path(path).suffix.lower() == SVG_SUFFIX and page is None:
        return _read_svg(read_in_child("svg", path), path, options)
    return _read_sheet(open_sheet(source, page=page, max_cells=max_cells), path, options)


@dataclass(frozen=True, eq=False)
class _SheetOptions:
    """The options of `read_plan` for sheets."""

    resolution: float | None
    method: str
    symbols: str | Path | None
    networks: Sequence[str]
    with_symbols: bool
    with_text: bool


def _read_dxf(drawing: PlanDrawing, path: str | Path, layers: LayerChoice, options: _SheetOptions) -> PlanReading:
    """The floors of a DXF: rooms that are drawn as outlines or enclosed by lines, else those of the drawn sheet."""
    drawn_floors = read_drawn_floors(
        drawing, resolution=options.resolution, room_layers=layers.rooms, chosen_walls=bool(layers.walls)
    )
    notes = describe_layers(drawing)
    if drawn_floors is not None:
        reading = _place_drawn_floors(*drawn_floors, path)
        return replace(reading, notes=(*reading.notes, *notes))
    if layers.rooms:
        raise PlanError(f"plan {short_repr(path)} has no closed outlines with a text inside on these layers of rooms")
    if len(drawing.lines) < MIN_SHEET_LINES:
        raise PlanError(f"plan {short_repr(path)} shows no rooms, its {len(drawing.lines)} lines enclose none")
    try:
        reading = _read_sheet(draw_sheet(drawing), path, options)
    except PlanError:
        # Named walls that close no rooms are not all walls
        without = None if layers.walls else forget_walls(drawing)
        if without is None:
            raise
        reading = _read_sheet(draw_sheet(without), path, options)
        notes = (f"{notes[0]}; they close no rooms, all lines were read", *notes[1:]) if notes else ()
    return replace(reading, notes=(*notes, *reading.notes))


def _read_svg(drawing: PlanDrawing, path: str | Path, options: _SheetOptions) -> PlanReading:
    """The floors of an SVG: rooms that it names, else those of the drawn sheet."""
    drawn_floors = read_drawn_floors(drawing, resolution=options.resolution) if drawing.outlines else None
    if drawn_floors is not None:
        return _place_drawn_floors(*drawn_floors, path)
    return _read_sheet(draw_sheet(drawing), path, options)


def _place_drawn_floors(floors: Sequence[Floor], unit: PlanScale, note: str, path: str | Path) -> PlanReading:
    """Floors in metres of the file's frame; unit: metres per drawing unit."""
    _check_floors(floors, path)
    grids = [_frame(floor) for floor in floors]
    placed = tuple(
        PlanFloor(flag_rooms(floor), grid, unit.scaled(grid.resolution / unit.resolution))
        for floor, grid in zip(floors, grids, strict=True)
    )
    return PlanReading(placed, None, px_per_unit=unit.resolution / grids[0].resolution, notes=(note,))


def _read_sheet(sheet: Sheet, path: str | Path, options: _SheetOptions) -> PlanReading:
    """The floors of a sheet of pixels."""
    templates = builtin_templates() + (read_symbol_folder(options.symbols) if options.symbols else ())
    if sheet.walls is None and not looks_like_drawing(sheet.colors):
        raise PlanError(f"plan {short_repr(path)} looks blank, like noise, like a photo or like text, give a drawing")
    # Text gives the names and the scale, and would be taken for symbols
    texts = _read_texts(sheet, path) if options.with_text else sheet.texts or ()
    textless = erase_texts(sheet, texts)
    # Dimension lines and grids are known before the network sees them
    plain = erase_grid(erase_dimension_lines(sheet, texts))
    measured = find_scale(plain, textless, texts, resolution=options.resolution, networks=options.networks)
    # So are legends and frames, which stand beside the building
    parts = find_parts(sheet.ink, door_px=measured.door_px)
    boxes = find_boxes(parts, texts, [swing.sweep().mean(axis=0) for swing in measured.swings])
    plain = erase_boxes(plain, parts, boxes)
    # Symbols are matched with templates and removed; the network sees the text, as in its training
    placed = find_symbols(textless, door_px=measured.drawn_door_px, templates=templates if options.with_symbols else ())
    plain = replace(plain, colors=remove_symbols(plain.colors, placed))
    # The rooms show the scale; where it is another one than the network took, the network sees the sheet again
    division = _divide_sheet(plain, measured, placed, options).leave_out(parts, texts)
    scale, spaces = _measure_division(division, measured, (sheet, textless), texts)
    door_px = scale_door_px(measured, scale, home_probability(spaces, texts), shape=sheet.shape)
    if door_px is not None:
        again = replace(measured, scale=replace(scale, resolution=DOOR_WIDTH / door_px), door_px=door_px)
        division = _divide_sheet(plain, again, placed, options).leave_out(parts, texts)
        scale, spaces = _measure_division(division, measured, (sheet, textless), texts)
    _check_floors(division.floors, path)
    # With metres it is known what is too small for a room, and which openings are no passages
    metres, home = scale.resolution, home_probability(spaces, texts)
    in_metres = [
        join_open_rooms(
            scale_floor(floor, metres, metres), sheet, division.class_map, resolution=metres, at_home=home > 0.5
        )
        for floor in division.floors
    ]
    if not scale.is_look:
        in_metres = [drop_narrow_doors(floor) for floor in in_metres]
    if options.with_symbols and home >= MIN_HOME:
        in_metres = place_fixtures(in_metres, find_fixtures(textless, resolution=metres))
    left_out = describe_left_out([*boxes.values(), *division.no_rooms])
    notes = (*sheet.notes, *_question_plan(division.floors, sheet), *left_out)
    return PlanReading(_name_rooms(in_metres, sheet, texts, scale), sheet, placed, sheet.px_per_unit, notes)


@dataclass(frozen=True, eq=False)
class _Division:
    """The floors of a sheet, in its pixels, y up, and what the network sees.

    height: of the sheet, pixels. no_rooms: what was left out, in words.
    """

    floors: Sequence[Floor]
    class_map: ClassMap
    height: int
    no_rooms: Sequence[str] = ()

    def leave_out(self, parts: SheetParts, texts: Sequence[PlacedText]) -> _Division:
        """The division without false rooms that are no part of the building."""
        floors, no_rooms = leave_out(self.floors, parts, texts, height=self.height)
        return replace(self, floors=floors, no_rooms=no_rooms)


def _divide_sheet(
    plain: Sheet, measured: SheetScale, placed: Sequence[PlacedSymbol], options: _SheetOptions
) -> _Division:
    """The floors of a sheet without what is no wall. placed: the symbols that were removed from it."""
    class_map = segment_sheet(plain.colors, door_px=measured.door_px, networks=options.networks)
    swings = measured.swings if options.with_symbols else ()
    drawn_doors = plain.doors if len(plain.doors) else plain.unnamed_doors
    doors = find_doors(class_map, swings, placed, drawn_doors) if options.with_symbols else PlanDoors()
    if plain.walls is not None:
        class_map = use_named_walls(class_map, plain.walls)
    if not has_walls(class_map):
        return _Division([], class_map, plain.shape[0])
    # The gaps of doors are closed, walls thinned to lines, and the layout method finds the rooms between them
    floor_map = draw_floor_map(
        class_map,
        doors.closed,
        sheet_shape=plain.shape,
        resolution=measured.scale.resolution,
        sweeps=[swing.sweep() for swing in swings],
    )
    floors = reconstruct_sheet_floors(floor_map, doors, method=options.method, source=plain.source)
    return _Division(floors, class_map, plain.shape[0])


def _measure_division(
    division: _Division, measured: SheetScale, sheets: tuple[Sheet, Sheet], texts: Sequence[PlacedText]
) -> tuple[PlanScale, list[Space]]:
    """The scale by all evidence, and the floors of the rooms. sheets: the whole one, and the one without its texts."""
    sheet, textless = sheets
    spaces = measure_spaces(division.floors, division.class_map, texts, height=division.height)
    return refine_scale(measured, sheet, textless, spaces, texts), spaces


def _refuse_options(path: str | Path, options: Mapping[str, object]) -> None:
    """Raise OptionError for options of drawings that a file with storeys in metres has no use for."""
    useless = " and ".join(name for name, value in options.items() if value is not None)
    if useless:
        noun = "an IFC" if Path(path).suffix.lower() == ".ifc" else "a home of Sweet Home 3D"
        raise OptionError(f"plan {short_repr(path)} is {noun} and no drawing, leave out {useless}")


def _read_texts(sheet: Sheet, path: str | Path) -> tuple[PlacedText, ...]:
    """The texts of a sheet, from its file or read from its pixels; none, with a warning, without a text reader."""
    if sheet.texts is not None:
        return sheet.texts
    if not text_reader_available():
        message = f"plan {short_repr(path)} is read without its text, install pianta[plan] to read names"
        warnings.warn(PlanWarning(message), stacklevel=3)
        return ()
    texts = read_texts(sheet.colors)
    if any(text.is_mirrored for text in texts):
        message = f"plan {short_repr(path)} is mirrored, names were read in a mirror and rooms are as drawn; flip it"
        warnings.warn(PlanWarning(message), stacklevel=3)
    return texts


def _check_floors(floors: Sequence[Floor], path: str | Path) -> None:
    """Raise PlanError if there is no floor, and warn if there are several."""
    if not floors:
        raise PlanError(f"plan {short_repr(path)} shows no rooms, give a plan with walls, or its resolution=")
    if len(floors) >= MANY_FLOORS:
        message = (
            f"plan {short_repr(path)} shows {len(floors)} floors or plans, each is read on its own and at one scale; "
            "crop it to one if they are different plans"
        )
        warnings.warn(PlanWarning(message), stacklevel=3)
    elif len(floors) > 1:
        message = f"plan {short_repr(path)} shows {len(floors)} floors, each is read on its own"
        warnings.warn(PlanWarning(message), stacklevel=3)


def _question_plan(floors: Sequence[Floor], sheet: Sheet) -> tuple[str, ...]:
    """A line about a picture with a single room that no drawn door leads into: frames of charts look so."""
    rooms = [room for floor in floors for room in floor.rooms]
    has_doors = any(door.kind == "door" for floor in floors for door in floor.doors)
    if len(rooms) != 1 or has_doors or sheet.walls is not None:
        return ()
    return ("plan: a single room without a door, this may be no plan; look at picture.png",)


def _name_rooms(
    floors: Sequence[Floor], sheet: Sheet, texts: Sequence[PlacedText], scale: PlanScale
) -> tuple[PlanFloor, ...]:
    """Floors with the names of their rooms."""
    grid, legend = GridMap(np.full(sheet.shape, UNKNOWN, np.int8), scale.resolution), find_legend(texts)
    named = [name_rooms(floor, texts, grid, legend) for floor in floors]
    if sheet.texts is None:
        # Texts that were read from pixels
        named = list(map(correct_room_numbers, named))
    return tuple(PlanFloor(flag_rooms(split_room_numbers(floor)), grid, scale) for floor in named)


def read_storeys(path: str | Path) -> tuple[PlanFloor, ...]:
    """Each storey of an IFC or .sh3d that has rooms, the lowest first.

    Warnings and errors as of read_ifc_plan and read_sweethome3d.
    """
    floors = []
    for storey in STOREY_READERS[Path(path).suffix.lower()](path):
        grid = _frame(storey.floor)
        scale = PlanScale(grid.resolution, "the units of the file", 1.0)
        floor = replace(storey.floor, title=storey.name, elevation=storey.elevation)
        floors.append(PlanFloor(floor, grid, scale, storey.name, storey.elevation))
    return tuple(floors)


def _frame(floor: Floor) -> GridMap:
    """Unknown cells around the rooms of a floor."""
    left, bottom, right, top = unary_union([room.polygon for room in floor.rooms]).bounds
    longest = max(right - left, top - bottom) + 2 * MARGIN
    cell = max(CELL, longest / MAX_SIDE_CELLS)
    shape = tuple(int(np.ceil((side + 2 * MARGIN) / cell)) for side in (top - bottom, right - left))
    return GridMap(np.full(shape, UNKNOWN, np.int8), cell, (left - MARGIN, bottom - MARGIN, 0.0))
