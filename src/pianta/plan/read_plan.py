"""A plan in, its floors out: the preprocessing of section 3.3 of the thesis, and its layout method after it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely import unary_union

from pianta._types import Colors
from pianta.errors import OptionError, PlanError, PlanWarning
from pianta.floor import DOOR_WIDTH, Floor, scale_floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, short_repr
from pianta.io.drawings.ifc import read_ifc_plan
from pianta.io.images import Source, path_of
from pianta.layout.reconstruct import DEFAULT_METHOD, check_method
from pianta.plan.doors.lines import PlanDoors, find_doors
from pianta.plan.doors.swings import Swing, find_swings
from pianta.plan.scale import (
    SURE_BY_DOORS,
    PlanScale,
    agree_on_doors,
    are_surely_doors,
    find_door_scale,
    find_stated_scale,
    fit_door_px,
    fits_doors,
    refine_by_sizes,
)
from pianta.plan.sheets.binarization import binarise, measure_contrast
from pianta.plan.sheets.floors_on_sheet import lay_out_floors
from pianta.plan.sheets.map_or_plan import looks_like_drawing
from pianta.plan.sheets.open_sheet import open_sheet
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.symbols.detection import find_symbols, remove_symbols
from pianta.plan.symbols.poses import PlacedSymbol
from pianta.plan.symbols.templates import own_templates, read_symbol_folder
from pianta.plan.text.legend import Legend, find_legend
from pianta.plan.text.recognition import erase_texts, read_texts, text_reader_available
from pianta.plan.text.room_names import name_rooms
from pianta.plan.walls.floor_map import draw_floor_map, trust_walls
from pianta.plan.walls.regions import NETWORKS, find_regions, has_walls

# Swings that are smaller than this share of a door are none.
SMALLEST_SWING = 0.5
NO_ROOMS = "plan {} shows no rooms, give a plan with walls, or its resolution="
NO_DRAWING = "plan {} looks blank, like noise, like a photo or like text, give a drawing"
IFC_SUFFIX = ".ifc"
# Metres of a cell of the frame, of the margin around the rooms, and cells at most along the longer side.
CELL, MARGIN, MOST_CELLS = 0.05, 1.0, 8000


@dataclass(frozen=True, eq=False)
class PlanFloor:
    """A floor that was found in a plan.

    Attributes
    ----------
    floor
        Metres, y up; of a sheet with the origin in its lower left corner, of an IFC in the frame of the model.
    grid
        The frame of the sheet, unknown cells of its pixels.
    scale
        Metres per pixel, and what tells them.
    name
        Of the storey, empty where the plan does not say.
    """

    floor: Floor
    grid: GridMap
    scale: PlanScale
    name: str = ""


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
        Those that were found on the sheet, the best first.
    """

    floors: tuple[PlanFloor, ...]
    sheet: Sheet | None
    symbols: tuple[PlacedSymbol, ...] = ()


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
) -> PlanReading:
    """Read the floors of a plan: rooms with their names, and doors.

    Parameters
    ----------
    source
        A picture, DXF, SVG, PDF or IFC.
    resolution
        Metres per pixel of a picture, per unit of a vector drawing; None to find it in the plan.
    page
        The page of a PDF, from 1.
    symbols
        Folder with PNGs of symbols besides our own; door*.png are doors.
    method
        How rooms are found in what remains, one of `METHODS`.
    with_symbols
        Whether symbols are found and removed, and the gaps of doors closed.
    with_text
        Whether text is read.
    networks
        Those that say what is wall.
    max_cells
        The most pixels that a picture may have.

    Returns
    -------
    PlanReading
        The floors; each has its rooms in metres, its frame and its scale.

    Raises
    ------
    PlanError
        The file is no plan, or shows no rooms; in one line.
    OptionError
        The method is unknown, or an IFC is given a page, a resolution or symbols.

    Warns
    -----
    PlanWarning
        The text cannot be read, or a sheet shows several floors.

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
    if Path(path).suffix.lower() == IFC_SUFFIX:
        return _read_ifc(path, {"page=": page, "resolution=": resolution, "symbols=": symbols})
    templates = own_templates() + (read_symbol_folder(symbols) if symbols else ())
    sheet = open_sheet(source, page=page, max_cells=max_cells)
    if sheet.walls is None and not looks_like_drawing(sheet.colors):
        raise PlanError(NO_DRAWING.format(short_repr(path)))
    # Text tells the names and the scale, and is no wall
    texts = _read_texts(sheet, path) if with_text else sheet.texts or ()
    view = _view_sheet(sheet, texts, resolution=resolution, networks=networks)
    # Symbols are matched with templates and removed, doors remembered; each spot is inside, wall, door or outside
    found = find_symbols(view.colors, door_px=view.drawn_px, templates=templates) if with_symbols else ()
    # The network has learned from sheets with their text, and erased text can take a line with it
    regions = find_regions(remove_symbols(sheet.colors, found), door_px=view.door_px, networks=networks)
    doors = find_doors(regions, view.swings, found, sheet.doors) if with_symbols else PlanDoors()
    regions = regions if sheet.walls is None else trust_walls(regions, sheet.walls)
    # The gaps of doors are closed, walls thinned to lines, and the layout method finds the rooms between them
    floors = []
    if has_walls(regions):
        floor_map = draw_floor_map(
            regions,
            doors.closed,
            sheet_shape=sheet.colors.shape[:2],
            resolution=view.scale.resolution,
            sweeps=[swing.sweep() for swing in view.swings] if with_symbols else (),
        )
        floors = lay_out_floors(floor_map, doors, method=method, source=sheet.source)
    _check_floors(floors, path)
    scale = view.scale if view.is_stated else refine_by_sizes(view.scale, floors, texts, sheet.colors.shape[0])
    legend = find_legend(texts)
    return PlanReading(tuple(_place_floor(floor, sheet, texts, legend, scale) for floor in floors), sheet, tuple(found))


def _read_ifc(path: str | Path, options: Mapping[str, object]) -> PlanReading:
    """The storeys of an IFC; options: those of drawings, which it has no use for."""
    useless = " and ".join(name for name, value in options.items() if value is not None)
    if useless:
        raise OptionError(f"plan {short_repr(path)} is an IFC and no drawing, leave out {useless}")
    return PlanReading(tuple(PlanFloor(*storey) for storey in read_storeys(path)), None)


@dataclass(frozen=True, eq=False)
class _View:
    """A sheet for its symbols, the doors with a swing on it, and its scale.

    colors: the sheet without its text. drawn_px, door_px: pixels of a door as it is drawn, and as the network takes it.
    """

    colors: Colors
    swings: tuple[Swing, ...]
    drawn_px: float
    door_px: float
    scale: PlanScale
    is_stated: bool


def _view_sheet(
    sheet: Sheet, texts: Sequence[PlacedText], *, resolution: float | None, networks: Sequence[str]
) -> _View:
    """The scale is stated, or that of doors, or the one at which the sheet looks like a plan.

    What is stated less surely than doors tell it counts where they are less sure still.
    """
    ink = binarise(sheet.colors)
    colors = erase_texts(sheet.colors, ink, texts)
    inked = ink if colors is sheet.colors else binarise(colors)
    swings = find_swings(np.maximum(measure_contrast(colors), inked))
    stated, drawn = find_stated_scale(sheet, texts, ink, given=resolution), agree_on_doors(swings, sheet.doors)
    sure = stated if stated and stated.confidence > SURE_BY_DOORS else None
    known_px = DOOR_WIDTH / sure.resolution if sure else drawn.px if drawn else None
    is_sure = sure is not None or len(sheet.doors) > 0 or are_surely_doors(drawn, max(ink.shape))
    door_px = fit_door_px(sheet.colors, door_px=known_px, is_sure=is_sure, networks=networks)
    if drawn is not None and sure is None and not fits_doors(door_px, drawn):
        # The curves that agreed are letters or furniture
        drawn, swings = None, tuple(swing for swing in swings if swing.radius >= SMALLEST_SWING * door_px)
    told = filter(None, (stated, find_door_scale(drawn, door_px)))
    scale = sure or max(told, key=lambda scale: scale.confidence)
    return _View(colors, swings, drawn.px if drawn else door_px, door_px, scale, sure is not None)


def _check_floors(floors: Sequence[Floor], path: str | Path) -> None:
    """Raise PlanError where there is no floor, and warn where there are several."""
    if not floors:
        raise PlanError(NO_ROOMS.format(short_repr(path)))
    if len(floors) > 1:
        told = f"plan {short_repr(path)} shows {len(floors)} floors, each is read on its own"
        warnings.warn(PlanWarning(told), stacklevel=3)


def _read_texts(sheet: Sheet, path: str | Path) -> tuple[PlacedText, ...]:
    """The texts of a sheet, read where its file does not say them; none, with a warning, where nothing can read."""
    if sheet.texts is not None:
        return sheet.texts
    if not text_reader_available():
        told = f"plan {short_repr(path)} is read without its text, install pianta[plan] to read names"
        warnings.warn(PlanWarning(told), stacklevel=3)
        return ()
    return read_texts(sheet.colors)


def _place_floor(
    floor: Floor, sheet: Sheet, texts: Sequence[PlacedText], legend: Legend, scale: PlanScale
) -> PlanFloor:
    """A floor, in pixels of the sheet with y up, in metres and with the names of its rooms."""
    placed = scale_floor(floor, scale.resolution, scale.resolution)
    grid = GridMap(np.full(sheet.colors.shape[:2], UNKNOWN, np.int8), scale.resolution)
    return PlanFloor(name_rooms(placed, texts, grid, legend), grid, scale)


def read_storeys(path: str | Path) -> list[tuple[Floor, GridMap, PlanScale, str]]:
    """Each storey with rooms, from the lowest to the highest: its floor, a frame of unknown cells, scale and name.

    Warnings and errors as of read_ifc_plan.
    """
    framed = [(storey, _frame(storey.floor)) for storey in read_ifc_plan(path)]
    return [(storey.floor, frame, _scale(frame), storey.name) for storey, frame in framed]


def _scale(frame: GridMap) -> PlanScale:
    return PlanScale(frame.resolution, "the units of the file", 1.0)


def _frame(floor: Floor) -> GridMap:
    left, bottom, right, top = unary_union([room.polygon for room in floor.rooms]).bounds
    longest = max(right - left, top - bottom) + 2 * MARGIN
    cell = max(CELL, longest / MOST_CELLS)
    shape = tuple(int(np.ceil((side + 2 * MARGIN) / cell)) for side in (top - bottom, right - left))
    return GridMap(np.full(shape, UNKNOWN, np.int8), cell, (left - MARGIN, bottom - MARGIN, 0.0))
