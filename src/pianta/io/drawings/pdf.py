"""Plans as PDF: the lines and texts of a drawn page, or the picture of a scanned one."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Colors, Floats
from pianta.io._files import one_line_reason
from pianta.io.drawings._child import read_in_child
from pianta.io.drawings._clips import Clip, make_clip
from pianta.io.drawings._drawing import DrawnText, PlanDrawing
from pianta.io.drawings._layers import (
    MAX_LINES,
    PAPER,
    DrawnPieces,
    bezier_points,
    check_plan_file,
    damage_as_plan_error,
    is_poche,
    jambs_of_wedges,
    luminance,
    plan_error,
    require_library,
)

if TYPE_CHECKING:
    from pypdfium2 import PdfDocument, PdfObject, PdfPage, PdfTextPage

Box = tuple[float, float, float, float]

# Limits against hostile files. PDFium unpacks a page, its forms and streams before it can say how large they are, and
# ends the process if memory runs out; therefore a child process reads the page.
MAX_FILE_BYTES = 128 * 2**20
MAX_OBJECTS = 300_000
MAX_DEPTH = 15  # of forms in forms

INCH = 0.0254  # m
METRES_PER_POINT = INCH / 72
# Of the picture of a scanned page.
MAX_SIDE_PX = 4000
MAX_DPI = 300
# Chosen by hand:
MIN_LINES = 8  # of a drawing; a page with fewer is a picture
SCAN_SHARE = 0.5  # of the page that images cover on a scan,
MIN_LINES_OVER_SCAN = 1000  # which is a drawing only with at least this number of lines, as no text or frame has
_SAME_ANGLE = 0.01  # radians between boxes of letters on one line
_LINE_OVERLAP = 1 / 3  # share of the height that such boxes have in common

# Scales 1:n of plans; a bare 1:n with another n is no scale.
_SCALES = frozenset({20, 25, 50, 100, 125, 150, 200, 250, 300, 400, 500, 1000})
_NAMED_SCALE = re.compile(
    r"\b(?:scale|ma(?:ß|ss)stab|scala|[ée]chelle|ech|esc(?:ala)?|m)\b\.?\s*[:=]?\s*1\s*[:/]\s*(\d{1,4})\b",
    re.IGNORECASE,
)
_BARE_SCALE = re.compile(r"(?<![\d.,:/])1\s?:\s?(\d{2,4})(?![\d.,:/])")
# The paper on which a scale holds, as in 1:100 @ A1
_SCALED_PAPER = re.compile(r"1\s*[:/]\s*\d{2,4}\s*(?:@|at|on|auf|bei|sur|su|en)\s*(?:DIN\s*)?(A[0-4])\b", re.IGNORECASE)

# Sides of papers, inches
PAPERS = {"A4": (8.27, 11.69), "A3": (11.69, 16.54), "A2": (16.54, 23.39), "A1": (23.39, 33.11), "A0": (33.11, 46.81)}
PAPERS |= {"Letter": (8.5, 11.0), "Tabloid": (11.0, 17.0), "Arch D": (24.0, 36.0)}
PAPER_TOLERANCE = 0.02  # share by which sides may be off those of a paper


def read_pdf_plan(path: str | Path, *, page: int | None = None) -> PlanDrawing | Colors:
    """Read a page of a PDF: as drawing if it has enough lines, else as picture.

    page: its number from 1; may be left out if there is only one.

    A drawing is in points of the displayed page, y up. Its lines all have the role "other", because a PDF has no names,
    and its doors are those of leaves with their arcs;
    metres per unit come from a scale such as 1:100 in its texts, if they agree on one.
    A picture has shape (H, W, 3), red, green, blue, at most 300 dots an inch and MAX_SIDE_PX along its longer side.

    Raises PlanError, in one line, if pypdfium2 (pianta[pdf]) is missing, for a file that is no PDF, damaged, protected
    by a password or too large, for several pages without a choice, for a page that does not exist, and for one that
    takes more time or memory than its reader may (READERS of _child.py).
    """
    require_library(check_plan_file(path), "pypdfium2", "a PDF", "pdf")
    drawing: PlanDrawing | Colors = read_in_child("pdf", path, page=page)
    return drawing


def count_pdf_pages(path: str | Path) -> int:
    """The number of pages of a PDF; raises PlanError as read_pdf_plan."""
    require_library(check_plan_file(path), "pypdfium2", "a PDF", "pdf")
    return int(read_in_child("pages", path))


def count_pages(path: str | Path) -> int:
    """The number of pages, counted in this process; otherwise as count_pdf_pages."""
    with closing(_open_document(check_plan_file(path, max_bytes=MAX_FILE_BYTES))) as document:
        return len(document)


def read_document(path: str | Path, *, page: int | None = None) -> PlanDrawing | Colors:
    """Read a page in this process, which ends if the page needs all memory; otherwise as read_pdf_plan."""
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    # PDFium refuses parts of a hostile file when they are used.
    with closing(_open_document(file)) as document, damage_as_plan_error(file, "PDF", MemoryError):
        return _read_page(document[_choose_page(file, len(document), page) - 1], file)


def _open_document(file: Path) -> PdfDocument:
    """Open a PDF; PlanError if it is damaged, protected by a password, or no PDF."""
    import pypdfium2
    from pypdfium2 import raw

    try:
        return pypdfium2.PdfDocument(file)
    except pypdfium2.PdfiumError as error:
        if error.err_code == raw.FPDF_ERR_PASSWORD:
            raise plan_error(file, "is protected by a password, save it without one") from None
        raise plan_error(file, f"is no PDF or damaged, save it again as PDF: {one_line_reason(error)}") from error


def _choose_page(file: Path, count: int, page: int | None) -> int:
    """The number of the page, 1 for None; PlanError if it does not exist, or if one of several must be chosen."""
    if page is None and count > 1:
        raise plan_error(file, f"has {count} pages, choose one, page=1 … page={count}")
    if page is not None and not 1 <= page <= count:
        range_ = "1, its only page" if count == 1 else f"1 … {count}"
        raise plan_error(file, f"has no page {page}, give page={range_}")
    return page or 1


def _read_page(page: PdfPage, file: Path) -> PlanDrawing | Colors:
    """A page as drawing in points, or its rendered pixels if it has too few lines; a scan needs more lines."""
    reader = _Reader(DrawnPieces(file), _page_rotation(page))
    reader.read_objects(page)
    is_scan = reader.image_area > SCAN_SHARE * np.prod(page.get_size())
    if reader.pieces.lines < (MIN_LINES_OVER_SCAN if is_scan else MIN_LINES):
        return _render_page(page)
    reader.read_texts(page.get_textpage())
    texts, sides = [text.text for text in reader.pieces.texts], page.get_size()
    scale, first_side = find_written_scale(texts), find_scaled_paper(texts, sides)
    inches_per_point = first_side / max(sides) if first_side else 1 / 72
    return reader.pieces.drawing(
        (),
        unnamed_doors=jambs_of_wedges(reader.pieces.chains),
        metres_per_unit=scale and scale * INCH * inches_per_point,
        is_on_paper=True,
    )


def _render_page(page: PdfPage) -> Colors:
    scale = min(MAX_SIDE_PX / max(page.get_size()), MAX_DPI / 72)
    pixels = page.render(scale=scale, rev_byteorder=True).to_numpy()
    if pixels.ndim == 2 or pixels.shape[2] == 1:
        pixels = np.repeat(pixels.reshape(*pixels.shape[:2], 1), 3, axis=2)
    return np.array(pixels[:, :, :3], np.uint8)


def _page_rotation(page: PdfPage) -> Floats:
    """Matrix, shape (2, 2), from the page's own coordinates to those of the displayed page."""
    quarters = page.get_rotation() // 90 % 4
    return np.asarray(np.linalg.matrix_power(np.array([[0.0, 1.0], [-1.0, 0.0]]), quarters))


def find_written_scale(texts: list[str]) -> int | None:
    """The n of the scale 1:n if texts agree on one, else None; those with the word scale are preferred."""
    named = {int(digits) for text in texts for digits in _NAMED_SCALE.findall(text)} - {0}
    bare = {int(digits) for text in texts for digits in _BARE_SCALE.findall(text)} & _SCALES
    scales = named or bare
    return scales.pop() if len(scales) == 1 else None


def has_shape_of(paper: str, sides: tuple[float, float]) -> bool:
    """Whether two sides, in any unit, are as those of a paper."""
    short, long = sorted(sides)
    return short > 0 and abs(long / short * PAPERS[paper][0] / PAPERS[paper][1] - 1) <= PAPER_TOLERANCE


def find_scaled_paper(texts: Sequence[str], sides: tuple[float, float]) -> float | None:
    """Inches of the longer side of the paper on which a written scale holds, if texts agree on one of this shape.

    sides: of the page or picture, in any unit. A page that was printed smaller still states its first paper.
    """
    papers = {paper.upper() for text in texts for paper in _SCALED_PAPER.findall(text)}
    if len(papers) != 1:
        return None
    paper = papers.pop()
    return PAPERS[paper][1] if has_shape_of(paper, sides) else None


@dataclass
class _Reader:
    """Reads the objects of a page into pieces.

    rotation: as of _page_rotation. image_area: of the page, square points. form_matrices, form_clips: by id() of the
    form object. clips: those that were made, by the bytes of their corners and the form.
    """

    pieces: DrawnPieces
    rotation: Floats
    image_area: float = 0.0
    objects: int = 0
    form_matrices: dict[int, Floats] = field(default_factory=dict)
    form_clips: dict[int, Clip] = field(default_factory=dict)
    clips: dict[tuple[int, bytes], Clip] = field(default_factory=dict)

    def read_objects(self, page: PdfPage) -> None:
        """Read all paths, and the area that images cover."""
        from pypdfium2 import raw

        error = plan_error(self.pieces.file, f"draws more than {MAX_OBJECTS} things, give one floor")
        if raw.FPDFPage_CountObjects(page) > MAX_OBJECTS:
            raise error
        for item in page.get_objects(max_depth=MAX_DEPTH):
            self.objects += 1
            if self.objects > MAX_OBJECTS:
                raise error
            matrix = self._matrix_of(item)
            if item.type == raw.FPDF_PAGEOBJ_FORM:
                self.form_matrices[id(item)] = matrix
                self.form_clips[id(item)] = self._clip_of(item)
            elif item.type == raw.FPDF_PAGEOBJ_IMAGE:
                self.image_area += abs(np.linalg.det(matrix[:, :2]))
            elif item.type == raw.FPDF_PAGEOBJ_PATH:
                self._read_path(item, matrix)

    def _matrix_of(self, item: PdfObject) -> Floats:
        """Matrix, shape (2, 3), from the coordinates of an object to those of the page."""
        a, b, c, d, e, f = item.get_matrix().get()
        own = np.array([[a, c, e], [b, d, f]])
        outer = self.form_matrices.get(id(item.container)) if item.container else None
        return own if outer is None else np.asarray(outer @ np.vstack([own, [0, 0, 1]]))

    def _clip_of(self, item: PdfObject) -> Clip:
        """What the clip paths of an object and of the forms around it leave, in the displayed page."""
        form = id(item.container) if item.container else 0
        paths = list(_clip_paths(item))
        if not paths:
            return self.form_clips.get(form)
        key = form, b" ".join(ring.tobytes() for path in paths for ring in path)
        if key not in self.clips:
            matrix = self.form_matrices.get(form, np.eye(2, 3))
            placed = [[self._to_displayed(ring, matrix) for ring in path] for path in paths]
            self.clips[key] = make_clip(self.form_clips.get(form), placed)
        return self.clips[key]

    def _to_displayed(self, points: Floats, matrix: Floats) -> Floats:
        """Points, shape (N, 2), in the displayed page; matrix: as of _matrix_of."""
        return np.asarray((points @ matrix[:, :2].T + matrix[:, 2]) @ self.rotation.T)

    def _read_path(self, item: PdfObject, matrix: Floats) -> None:
        """Add the dark fills and visible strokes of a path to the pieces; PlanError if the page has too many lines.

        matrix: shape (2, 3), from the coordinates of the path to those of the page.
        """
        from pypdfium2 import raw

        fill, stroke = ctypes.c_int(), raw.FPDF_BOOL()
        raw.FPDFPath_GetDrawMode(item, fill, stroke)
        stroked = bool(stroke) and luminance(_color_of(item, raw.FPDFPageObj_GetStrokeColor)) < PAPER
        filled = bool(fill) and is_poche(_color_of(item, raw.FPDFPageObj_GetFillColor))
        if not stroked and not filled:
            return
        if self.pieces.lines + raw.FPDFPath_CountSegments(item) > MAX_LINES:
            raise plan_error(self.pieces.file, f"has more than {MAX_LINES} lines, give one floor")
        segments = (raw.FPDFPath_GetPathSegment(item, index) for index in range(raw.FPDFPath_CountSegments(item)))
        rings = [self._to_displayed(ring, matrix) for ring in _rings_of_segments(segments)]
        clip = self._clip_of(item)
        if filled:
            self.pieces.add_clipped_fill(rings, "other", clip)
            self.pieces.lines += sum(map(len, rings))
        if stroked:
            width = ctypes.c_float()
            raw.FPDFPageObj_GetStrokeWidth(item, width)
            scaled = width.value * abs(np.linalg.det(matrix[:, :2])) ** 0.5
            for ring in rings:
                self.pieces.add_clipped_chain(ring, "other", clip, width=scaled)

    def read_texts(self, page: PdfTextPage) -> None:
        """Read each run of letters on a line as one text."""
        rotation = np.arctan2(self.rotation[0, 1], self.rotation[0, 0])
        for box, direction in _runs_of_letters(page):
            left, bottom, right, top = box
            text = " ".join(page.get_text_bounded(*box).split())
            x, y = self.rotation @ ((left + right) / 2, (bottom + top) / 2)
            height = top - bottom if _is_horizontal(direction) else right - left
            angle = np.arctan2(np.sin(direction - rotation), np.cos(direction - rotation))
            self.pieces.add_text(DrawnText(text, float(x), float(y), height, float(angle)))


def _color_of(item: PdfObject, color_of: Callable[..., object]) -> Floats:
    """Red, green and blue, 0 … 1, of an object on white paper."""
    *channels, alpha = (ctypes.c_uint() for _ in range(4))
    color_of(item, *channels, alpha)
    return np.array([1 - (255 - channel.value) / 255 * alpha.value / 255 for channel in channels])


def _clip_paths(item: PdfObject) -> Iterator[list[Floats]]:
    """The rings of each clip path of an object, each shape (N, 2), in the page or the form that holds the object."""
    from pypdfium2 import raw

    clip = raw.FPDFPageObj_GetClipPath(item)
    for path in range(max(raw.FPDFClipPath_CountPaths(clip), 0) if clip else 0):
        count = max(raw.FPDFClipPath_CountPathSegments(clip, path), 0)
        segments = (raw.FPDFClipPath_GetPathSegment(clip, path, index) for index in range(count))
        yield list(_rings_of_segments(segments))


def _rings_of_segments(segments: Iterable[Any]) -> Iterator[Floats]:
    """The connected pieces of a path, each shape (N, 2), in its own coordinates; curves become chains."""
    from pypdfium2 import raw

    run: list[list[float]] = []
    controls: list[list[float]] = []
    x, y = ctypes.c_float(), ctypes.c_float()
    for segment in segments:
        raw.FPDFPathSegment_GetPoint(segment, x, y)
        segment_type = raw.FPDFPathSegment_GetType(segment)
        if segment_type == raw.FPDF_SEGMENT_MOVETO:
            if len(run) > 1:
                yield np.array(run)
            run = []
        if segment_type != raw.FPDF_SEGMENT_BEZIERTO:
            run.append([x.value, y.value])
        else:
            controls.append([x.value, y.value])
        if len(controls) == 3:
            run += bezier_points(np.array([run[-1], *controls]))[1:].tolist()
            controls = []
        if raw.FPDFPathSegment_GetClose(segment) and run:
            run.append(run[0])
    if len(run) > 1:
        yield np.array(run)


def _runs_of_letters(page: PdfTextPage) -> list[tuple[Box, float]]:
    """Boxes (left, bottom, right, top) of letters on a line and the angles of their base lines, in page coordinates.

    PDFium starts a new box with every change of font, even within a word; adjacent boxes are joined.
    """
    runs: list[tuple[Box, float]] = []
    for index in range(page.count_rects()):
        box = page.get_rect(index)
        angle = _angle_at(page, (box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
        if runs and abs(runs[-1][1] - angle) < _SAME_ANGLE and _follows(runs[-1][0], box, angle):
            left, bottom, right, top = runs.pop()[0]
            box = min(left, box[0]), min(bottom, box[1]), max(right, box[2]), max(top, box[3])
        runs.append((box, angle))
    return runs


def _follows(box: Box, following: Box, angle: float) -> bool:
    """Whether a box is on the line of another, at most a wide blank away."""
    along, across = (0, 1) if _is_horizontal(angle) else (1, 0)
    gap = max(following[along], box[along]) - min(following[along + 2], box[along + 2])
    shared = min(following[across + 2], box[across + 2]) - max(following[across], box[across])
    height = max(box[across + 2] - box[across], following[across + 2] - following[across])
    return gap < height and shared > height * _LINE_OVERLAP


def _is_horizontal(angle: float) -> bool:
    return abs(float(np.cos(angle))) >= abs(float(np.sin(angle)))


def _angle_at(page: PdfTextPage, x: float, y: float) -> float:
    """Angle of the letter at a point, radians counter-clockwise from x; 0 without a letter."""
    from pypdfium2 import raw

    index = page.get_index(x, y, 5, 5)
    clockwise = raw.FPDFText_GetCharAngle(page, index) if index is not None and index >= 0 else 0.0
    return -float(clockwise) if np.isfinite(clockwise) and clockwise >= 0 else 0.0
