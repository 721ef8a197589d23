"""PDF pages with lines are read as drawings, pages without lines as pictures."""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import PlanError
from pianta.io.drawings import _child
from pianta.io.drawings import pdf as pdf_plan
from pianta.io.drawings._drawing import ROLES, PlanDrawing
from pianta.io.drawings.pdf import METRES_PER_POINT, read_document, read_pdf_plan
from tests.mutation import mutated, refused_in_one_line

pytest.importorskip("pypdfium2", reason="pianta[pdf] is not installed")

Pair = tuple[float, float]

# Two rooms, 100 × 50 points each, side by side; stroked 2 points wide.
ROOMS = "2 w 50 50 100 50 re S 150 50 100 50 re S"
ROOM_LINES = [
    *([50, 50, 150, 50], [150, 50, 150, 100], [150, 100, 50, 100], [50, 100, 50, 50]),
    *([150, 50, 250, 50], [250, 50, 250, 100], [250, 100, 150, 100], [150, 100, 150, 50]),
]


def pdf(*pages: str, size: Pair = (300, 200), forms: Sequence[tuple[str, str]] = (), **entries: str) -> bytes:
    """A PDF with one content stream per page; entries of the page and a | may precede the stream.

    forms: streams and entries of Form XObjects F0, F1 … entries: of the trailer.
    """

    def stream(content: str, more: str = "") -> str:
        return f"<< /Length {len(content)} {more} >>\nstream\n{content}\nendstream"

    first = 3 + len(forms)
    kids = " ".join(f"{first + 2 * index} 0 R" for index in range(len(pages)))
    names = " ".join(f"/F{index} {3 + index} 0 R" for index in range(len(forms)))
    font = "/Font << /H << /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >> >>"
    resources = f"/Resources << {font} /XObject << {names} >> >>"
    form = f"/Type /XObject /Subtype /Form /BBox [0 0 999 999] {resources}"
    bodies = ["<< /Type /Catalog /Pages 2 0 R >>", f"<< /Type /Pages /Kids [{kids}] /Count {len(pages)} >>"]
    bodies += [stream(content, f"{form} {matrix}") for content, matrix in forms]
    for index, page in enumerate(pages):
        rotate, _, content = page.rpartition("|")
        box = f"/MediaBox [0 0 {size[0]} {size[1]}] {rotate}"
        bodies.append(f"<< /Type /Page /Parent 2 0 R {box} {resources} /Contents {first + 2 * index + 1} 0 R >>")
        bodies.append(stream(content))
    written, starts = b"%PDF-1.4\n", []
    for number, body in enumerate(bodies, start=1):
        starts.append(len(written))
        written += f"{number} 0 obj\n{body}\nendobj\n".encode("latin-1")
    table = "".join(f"{start:010d} 00000 n \n" for start in starts)
    trailer = "".join(f"/{name} {value} " for name, value in entries.items())
    end = f"xref\n0 {len(bodies) + 1}\n0000000000 65535 f \n{table}trailer\n"
    end += f"<< /Size {len(bodies) + 1} /Root 1 0 R {trailer}>>\nstartxref\n{len(written)}\n%%EOF\n"
    return written + end.encode()


def text(content: str, x: float, y: float, matrix: str = "1 0 0 1") -> str:
    return f" BT /H 10 Tf {matrix} {x} {y} Tm ({content}) Tj ET"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("pdf") / "plan.pdf"


def read(path: Path, *pages: str, page: int | None = None, **options: Any) -> Any:
    """A drawing or a picture; the test knows which."""
    path.write_bytes(pdf(*pages, **options))
    return read_document(path, page=page)


def lines_of(drawing: PlanDrawing) -> list[list[float]]:
    lines: list[list[float]] = (np.round(drawing.lines.reshape(-1, 4), 3) + 0.0).tolist()
    return lines


def test_lines_and_texts_of_a_drawn_page(path):
    drawing = read(path, ROOMS + text("Office", 80, 70) + text("Main hall", 180, 60, "0 1 -1 0"))
    assert isinstance(drawing, PlanDrawing)
    assert lines_of(drawing) == ROOM_LINES
    assert set(drawing.roles.tolist()) == {ROLES.index("other")}
    assert drawing.widths == pytest.approx([2] * 8)
    assert (drawing.metres_per_unit, drawing.source, len(drawing.doors)) == (None, "plan.pdf", 0)
    office, hall = drawing.texts
    assert (office.text, hall.text) == ("Office", "Main hall")
    # Helvetica's letters of 10 points: 0.278 to 0.833 em wide, capitals 0.72 em high.
    assert (office.x, office.y) == pytest.approx((94, 73.6), abs=2)
    assert office.angle == 0
    assert (hall.x, hall.y, hall.angle) == pytest.approx((176.4, 81, np.pi / 2), abs=2)
    assert office.height == pytest.approx(7.3, abs=1)
    assert hall.height == pytest.approx(7.3, abs=1)


def test_matrices_of_pages_and_forms_apply(path):
    """The room is drawn in a form within a form: doubled by the page, moved by each form."""
    forms = [("0 0 100 50 re S", "/Matrix [1 0 0 1 10 0]"), ("1 0 0 1 0 5 cm /F0 Do", "/Matrix [1 0 0 1 0 20]")]
    drawing = read(path, f"q 2 0 0 2 0 0 cm 1 w /F1 Do Q {ROOMS}", forms=forms)
    assert lines_of(drawing)[:4] == [[20, 50, 220, 50], [220, 50, 220, 150], [220, 150, 20, 150], [20, 150, 20, 50]]
    assert lines_of(drawing)[4:] == ROOM_LINES
    assert drawing.widths[:4] == pytest.approx([2] * 4)


@pytest.mark.parametrize(
    ("rotate", "corner", "angle"),
    [(90, (50, -150), -np.pi / 2), (180, (-150, -50), np.pi), (270, (-50, 150), np.pi / 2)],
)
def test_a_turned_page_is_read_upright(path, rotate, corner, angle):
    drawing = read(path, f"/Rotate {rotate}|{ROOMS}" + text("Office", 80, 70))
    assert lines_of(drawing)[0][2:] == list(corner)
    (office,) = drawing.texts
    assert np.exp(1j * office.angle) == pytest.approx(np.exp(1j * angle), abs=1e-3)


def test_curves_are_chains_and_dark_areas_are_filled(path):
    circle = "100 0 m 100 55.228 55.228 100 0 100 c S"
    areas = "0 g 10 10 5 5 re f 0.9 g 30 10 5 5 re f 1 G 0 0 m 99 99 l S 0 G"
    drawing = read(path, f"{circle} {areas} {ROOMS}")
    arc = drawing.lines[:16]
    assert np.hypot(arc[..., 0], arc[..., 1]) == pytest.approx(100, rel=1e-3)
    assert lines_of(drawing)[16:] == ROOM_LINES
    (outline,) = drawing.fills
    assert (outline.min(axis=0).tolist(), outline.max(axis=0).tolist()) == ([10, 10], [15, 15])


@pytest.mark.parametrize(
    ("expected", "scale"),
    [
        ("Scale 1:100", 100),
        ("Scala 1 : 75", 75),
        ("M 1:50", 50),
        ("1:200", 200),
        ("Ma\\337stab 1:275", 275),
        ("\\351chelle 1/120", 120),
        ("at 11:50", None),
        ("1:37", None),
        ("1:50 1:100", None),
        ("1:50 Scale 1:100", 100),
        ("2.1:50", None),
        ("ratio", None),
    ],
)
def test_the_scale_is_what_the_texts_agree_on(path, expected, scale):
    drawing = read(path, ROOMS + text(expected, 10, 10))
    assert drawing.metres_per_unit == (scale and pytest.approx(scale * METRES_PER_POINT))


def test_a_change_of_font_does_not_cut_a_word(path):
    """A page of 300 points at 1:100 is 10.58 m wide."""
    word = " BT /H 10 Tf 1 0 0 1 80 70 Tm (Of) Tj /H 10.5 Tf (fice) Tj ET"
    drawing = read(path, ROOMS + word + text("far", 200, 70) + text("Scale 1:100", 10, 10))
    assert [item.text for item in drawing.texts] == ["Office", "far", "Scale 1:100"]
    assert drawing.metres_per_unit * 300 == pytest.approx(10.58, abs=0.01)


def test_a_page_without_lines_is_a_picture(path):
    """Red in the lower left quarter; 72 points are 300 pixels."""
    picture = read(path, "1 0 0 rg 0 0 36 18 re f", size=(72, 36))
    assert isinstance(picture, np.ndarray)
    assert (picture.shape, picture.dtype) == ((150, 300, 3), np.uint8)
    assert (picture[140, 10].tolist(), picture[10, 10].tolist(), picture[140, 290].tolist()) == (
        [255, 0, 0],
        [255, 255, 255],
        [255, 255, 255],
    )


def test_the_picture_of_a_large_page_is_not_larger_than_the_limit(path):
    assert read(path, "", size=(14400, 100)).shape == (28, 4000, 3)


SCAN = "q 300 0 0 200 0 0 cm BI /W 1 /H 1 /CS /G /BPC 8 ID \x80 EI Q "


def test_a_scan_with_a_frame_is_a_picture(path):
    assert isinstance(read(path, SCAN + ROOMS), np.ndarray)
    assert isinstance(read(path, SCAN.replace("300 0 0 200", "30 0 0 20") + ROOMS), PlanDrawing)


def test_a_page_must_be_chosen(path):
    pages = [ROOMS.replace("2 w", f"{number} w") for number in range(1, 101)]
    with pytest.raises(PlanError, match=r"page=.*100"):
        read(path, *pages)
    for page in (1, 100):
        assert read(path, *pages, page=page).widths[0] == pytest.approx(page)
    for page in (0, -1, 101):
        with pytest.raises(PlanError, match=rf"page {page}.*page=.*100"):
            read_document(path, page=page)
    with pytest.raises(PlanError, match="page="):
        read(path, ROOMS, page=2)


def test_a_password_is_reported(path):
    keys = f"/Filter /Standard /V 1 /R 2 /P -4 /O <{'00' * 32}> /U <{'00' * 32}>"
    with pytest.raises(PlanError, match=r"\bpassword\b"):
        read(path, ROOMS, Encrypt=f"<< {keys} >>", ID=f"[<{'00' * 16}> <{'00' * 16}>]")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"\x89PNG\r\n\x1a\n0000", "PDF"),
        (pdf(ROOMS)[:200], "PDF"),
        (pdf(), "PDF"),
    ],
)
def test_files_without_a_plan_are_refused_in_one_line(path, content, message):
    path.write_bytes(content)
    with pytest.raises(PlanError, match=message) as caught:
        read_pdf_plan(path)
    assert "\n" not in str(caught.value)


def test_a_missing_library_is_named(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pypdfium2", None)
    path.write_bytes(pdf(ROOMS))
    with pytest.raises(PlanError, match=r"pianta\[pdf\]"):
        read_pdf_plan(path)


def test_numbers_beyond_the_limits_are_refused(path, monkeypatch):
    monkeypatch.setattr(pdf_plan, "MAX_OBJECTS", 1)
    with pytest.raises(PlanError, match=r"\b1\b"):
        read(path, ROOMS)
    monkeypatch.undo()
    monkeypatch.setattr(pdf_plan, "MAX_LINES", 2)
    with pytest.raises(PlanError, match="lines"):
        read(path, "0 0 m 1 1 l 2 2 l S")


@pytest.mark.slow
def test_a_process_of_its_own_reads_the_same(path):
    page_content = ROOMS + text("Office \\366 1:100", 80, 70) + " 0 g 10 10 5 5 re f 30 10 5 5 re f"
    path.write_bytes(pdf(page_content, ""))
    here, there = read_document(path, page=1), read_pdf_plan(path, page=1)
    assert isinstance(here, PlanDrawing)
    assert isinstance(there, PlanDrawing)
    for name in ("lines", "roles", "widths", "doors"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert [outline.tolist() for outline in there.fills] == [outline.tolist() for outline in here.fills]
    assert len(there.fills) == 2
    assert (there.texts, there.metres_per_unit, there.source) == (here.texts, here.metres_per_unit, here.source)
    assert there.metres_per_unit == pytest.approx(100 * METRES_PER_POINT)
    np.testing.assert_array_equal(read_pdf_plan(path, page=2), read_document(path, page=2))
    path.write_bytes(pdf(ROOMS))
    plain = read_pdf_plan(path)
    assert isinstance(plain, PlanDrawing)
    assert (plain.fills, plain.texts, plain.metres_per_unit) == ((), (), None)
    for page in (0, 2):
        with pytest.raises(PlanError, match=rf"^[^\n]*plan\.pdf[^\n]*page {page}[^\n]*page=[^\n]*$"):
            read_pdf_plan(path, page=page)


def unfolding(depth: int) -> bytes:
    """A page of nested forms, each showing the next one ten times: 10 ** depth rooms in all."""
    return pdf(f"/F{depth} Do {ROOMS}", forms=[(ROOMS, "")] + [(f"/F{level} Do " * 10, "") for level in range(depth)])


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no limits of processes")
@pytest.mark.parametrize(("seconds", "memory"), [(60, 600 * 2**20), (1, 8 * 2**30)])
def test_a_page_that_unfolds_without_end_is_refused(path, monkeypatch, seconds, memory):
    bounded = replace(_child.READERS["pdf"], seconds=seconds, memory=memory)
    monkeypatch.setattr(_child, "READERS", {"pdf": bounded})
    path.write_bytes(unfolding(9))
    # Without memory PDFium aborts
    expected = rf"more than ({seconds} s or )?{memory / 2**30:.2g} GiB"
    with pytest.raises(PlanError, match=expected) as caught:
        read_pdf_plan(path)
    assert "\n" not in str(caught.value)


def test_a_reader_that_does_not_return_is_stopped(path, monkeypatch):
    monkeypatch.setattr(_child, "CLOCK_FACTOR", 1e-6)
    path.write_bytes(pdf(ROOMS))
    with pytest.raises(PlanError, match="20 s"):
        read_pdf_plan(path)


@pytest.mark.slow
def test_nothing_in_the_working_folder_is_run(path, monkeypatch):
    for name in ("json", "sys", "numpy", "pianta"):
        path.with_name(f"{name}.py").write_text("raise SystemExit(9)\n", encoding="utf-8")
    monkeypatch.chdir(path.parent)
    path.write_bytes(pdf(ROOMS))
    assert isinstance(read_pdf_plan(path), PlanDrawing)


@pytest.mark.parametrize("python", ["", "/no/such/python", "/bin/true", "/bin/false"])
def test_a_reader_that_cannot_be_started_is_reported_and_not_called_too_large(path, monkeypatch, python):
    monkeypatch.setattr(sys, "executable", python)
    path.write_bytes(pdf(ROOMS))
    with pytest.raises(PlanError, match="process"):
        read_pdf_plan(path)


@pytest.mark.parametrize("size", [(1e9, 1e9), (1e9, 1e-3), (1e-4, 1e-4), (1e-3, 1e9)])
def test_no_page_is_so_large_or_small_that_its_picture_is_beyond_limits(path, size):
    with suppress(PlanError):
        picture = read(path, "", size=size)
        assert max(picture.shape) <= 4000


@pytest.mark.slow
@settings(max_examples=60)
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_one_line(path, data):
    path.write_bytes(data.draw(mutated(pdf(ROOMS + text("Office 1:100", 80, 70) + " 1 0 0 1 5 5 cm 9 9 8 8 re f"))))
    with refused_in_one_line():
        read_document(path)


@pytest.mark.parametrize("rotate", ["", "/Rotate 180|"])
def test_lines_and_fills_end_at_clip_paths(path, rotate):
    """The clip 0 … 100 × 0 … 200 applies until Q, and what is filled within an even number of its rings is hidden."""
    clip = "q 0 0 100 200 re W n 40 60 m 160 60 l S Q 40 70 m 160 70 l S "
    ring = "q 0 0 100 100 re 20 20 60 60 re W* n 0 0 100 10 re f 40 40 9 9 re f Q "
    drawing = read(path, rotate + clip + ring + " ".join(["10 180 m 20 180 l S"] * 8))
    sign = -1 if rotate else 1
    assert (sign * drawing.lines[:2]).tolist() == [[[40, 60], [100, 60]], [[40, 70], [160, 70]]]
    (fill,) = (sign * each for each in drawing.fills)
    assert (*fill.min(axis=0), *fill.max(axis=0)) == (0, 0, 100, 10)


def test_clips_of_forms_apply_to_what_they_hold(path):
    form = "0 0 100 100 re W n 10 10 m 150 10 l S", "/Matrix [1 0 0 1 20 0]"
    drawing = read(path, "q 0 0 80 200 re W n /F0 Do Q " + " ".join(["10 180 m 20 180 l S"] * 8), forms=[form])
    assert drawing.lines[0].tolist() == [[30, 10], [80, 10]]
    assert len(drawing.lines) == 9


@pytest.mark.parametrize(("color", "count"), [("0.6 0.6 0.6", 1), ("1 0 0", 0), ("0.66 0 0.9", 0)])
def test_fills_of_departments_are_no_poche(path, color, count):
    drawing = read(path, f"{color} rg 10 10 50 50 re f " + ROOMS)
    assert len(drawing.fills) == count


def arc(radius: float, degrees: float) -> str:
    """A Bézier arc about the origin, from the x axis on, and a leaf to its end."""
    angle = np.radians(degrees)
    reach = radius * 4 / 3 * np.tan(angle / 4)
    end = radius * np.array([np.cos(angle), np.sin(angle)])
    middle = end + reach * np.array([np.sin(angle), -np.cos(angle)])
    curve = f"{radius} 0 m {radius} {reach:.6f} {middle[0]:.6f} {middle[1]:.6f} {end[0]:.6f} {end[1]:.6f} c"
    return f"{curve} 0 0 l S"


@pytest.mark.parametrize("degrees", [30, 45, 90])
def test_leaves_with_their_arcs_are_doors(path, degrees):
    """Three doors of 30 points, from the hinge to the end of the arc without a leaf; chairs have smaller arcs."""
    doors = " ".join(f"q 1 0 0 1 {50 + 60 * k} 50 cm {arc(30, degrees)} Q" for k in range(3))
    chairs = " ".join(f"q 1 0 0 1 {50 + 20 * k} 150 cm {arc(6, 90)} Q" for k in range(4))
    drawing = read(path, f"{ROOMS} {doors} {chairs}")
    expected = [[[50 + 60 * k, 50], [80 + 60 * k, 50]] for k in range(3)]
    np.testing.assert_allclose(drawing.unnamed_doors, expected, atol=0.3)


def test_arcs_without_a_leaf_or_with_two_are_no_doors(path):
    without = arc(30, 90).replace("0 0 l S", "S")
    sector = arc(30, 90).replace("0 0 l S", "0 0 l 30 0 l S")
    drawing = read(path, f"{ROOMS} q 1 0 0 1 50 50 cm {without} Q q 1 0 0 1 150 50 cm {sector} Q")
    assert len(drawing.unnamed_doors) == 0
