"""Files of plans, except IFC, as sheets; the suffix selects the reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from pianta._types import Colors
from pianta.errors import MapError, PlanError
from pianta.io._files import MAX_CELLS, check_input_file, short_repr
from pianta.io.drawings._child import read_in_child
from pianta.io.drawings._drawing import PlanDrawing
from pianta.io.drawings.pdf import MAX_DPI, MAX_SIDE_PX, read_pdf_plan
from pianta.io.images import PICTURE_SUFFIXES, Source, path_of, read_dots_per_inch, read_picture
from pianta.plan.sheets.drawn_sheet import draw_sheet
from pianta.plan.sheets.perspective import straighten
from pianta.plan.sheets.sheet import Sheet

DRAWING_READERS: Mapping[str, Callable[[Path], PlanDrawing]] = {
    ".dxf": partial(read_in_child, "dxf"),
    ".svg": partial(read_in_child, "svg"),
}
PDF_SUFFIX = ".pdf"
SHEET_SUFFIXES = (*PICTURE_SUFFIXES, *DRAWING_READERS, PDF_SUFFIX)


def open_sheet(path: Source, *, page: int | None = None, max_cells: int = MAX_CELLS) -> Sheet:
    """The sheet of a plan: a picture, or a DXF, SVG or PDF drawn as one.

    page: of a PDF, from 1; needed when it has several. max_cells: pixels that a picture may have.
    Photos from an angle are straightened, with a note.
    Raises PlanError, in one line, for other files, and for a page of another file format.
    """
    file = check_input_file(path_of(path), "plan", PlanError)
    suffix = file.suffix.lower()
    if suffix not in SHEET_SUFFIXES:
        raise PlanError(
            f"plan {short_repr(file)} has an unknown format, give one of {', '.join(SHEET_SUFFIXES)} or .ifc, .sh3d"
        )
    if page is not None and suffix != PDF_SUFFIX:
        raise PlanError(f"page is {page} and plan {short_repr(file)} is no PDF, leave out page=")
    if suffix in DRAWING_READERS:
        return draw_sheet(DRAWING_READERS[suffix](file))
    if suffix == PDF_SUFFIX:
        content = read_pdf_plan(file, page=page)
        if isinstance(content, PlanDrawing):
            return draw_sheet(content)
        # Larger pages are drawn more coarsely
        return _picture_sheet(content, MAX_DPI if max(content.shape) < MAX_SIDE_PX else None, file)
    try:
        colors = read_picture(path, max_cells=max_cells)
        return _picture_sheet(colors, read_dots_per_inch(path), file)
    except MapError as error:
        raise PlanError(str(error)) from error


def _picture_sheet(colors: Colors, px_per_inch: float | None, file: Path) -> Sheet:
    """A picture as a sheet; a photo from an angle is straightened."""
    straight = straighten(colors)
    if straight is None:
        return Sheet(colors, px_per_inch=px_per_inch, source=file.name)
    note = (
        f"photo: taken from an angle and straightened by {straight.by}; "
        "rooms.png and grid.npz fit the straightened sheet that picture.png shows"
    )
    return Sheet(straight.colors, source=file.name, notes=(note,))
