"""Files of plans become sheets by their suffix, and what is no such file is refused in one line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from pianta.errors import PlanError
from pianta.io.images import PICTURE_SUFFIXES
from pianta.plan.sheets.drawn_sheet import LONGEST_PX, MARGIN_PX
from pianta.plan.sheets.open_sheet import SHEET_SUFFIXES, open_sheet
from tests.mutation import mutated, refused_in_one_line

# Four lines of 900 and 450 units: without units of length, the longer becomes half of LONGEST_PX
ROOM_SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="900" height="450">'
    '<path d="M0 0 H900 V450 H0 Z" stroke="black" fill="none"/></svg>'
)


def save_picture(path: Path, *, size: tuple[int, int] = (3, 2)) -> Path:
    Image.new("RGB", size, "white").save(path)
    return path


def save_drawn_pdf(path: Path) -> Path:
    """A page of 300 × 200 points with a text, and two rooms side by side in eight lines."""
    content = b"50 50 100 50 re S 150 50 100 50 re S BT /H 10 Tf 60 60 Td (Office) Tj ET"
    font = b"/Font << /H << /Type /Font /Subtype /Type1 /BaseFont /Helvetica >> >>"
    path.write_bytes(
        b"%PDF-1.4\n1 0 obj\n<< /Type /Catalog /Pages 2 0 R >>\nendobj\n"
        b"2 0 obj\n<< /Type /Pages /Kids [3 0 R] /Count 1 >>\nendobj\n"
        b"3 0 obj\n<< /Type /Page /Parent 2 0 R /MediaBox [0 0 300 200] /Contents 4 0 R "
        b"/Resources << " + font + b" >> >>\nendobj\n"
        b"4 0 obj\n<< /Length %d >>\nstream\n%b\nendstream\nendobj\n"
        % (len(content), content)
        + b"trailer\n<< /Root 1 0 R >>\n%%EOF\n"
    )
    return path


@pytest.mark.parametrize("suffix", PICTURE_SUFFIXES)
def test_pictures_of_every_kind_are_sheets_without_more(tmp_path, suffix):
    sheet = open_sheet(save_picture(tmp_path / f"a{suffix}"))
    assert sheet.colors.tolist() == [[[255] * 3] * 3] * 2
    assert (sheet.walls, sheet.texts, sheet.resolution, sheet.source) == (None, None, None, f"a{suffix}")
    assert sheet.doors.shape == (0, 2, 2)


def test_the_suffix_may_be_in_capitals_and_the_path_a_string(tmp_path):
    assert open_sheet(str(save_picture(tmp_path / "Plan.PNG"))).source == "Plan.PNG"


def test_what_is_transparent_is_paper(tmp_path):
    Image.new("RGBA", (1, 1), (0, 0, 0, 0)).save(tmp_path / "a.png")
    assert open_sheet(tmp_path / "a.png").colors.tolist() == [[[255, 255, 255]]]


def test_a_drawn_svg_is_drawn(tmp_path):
    pytest.importorskip("svgelements", reason="pianta[svg] is not installed")
    (tmp_path / "plan.svg").write_text(ROOM_SVG)
    sheet = open_sheet(tmp_path / "plan.svg")
    assert sheet.source == "plan.svg"
    rows, cols = np.nonzero(sheet.colors.max(axis=2) == 0)
    assert cols.min() == pytest.approx(MARGIN_PX, abs=1)
    assert np.ptp(cols) == pytest.approx(LONGEST_PX / 2 - MARGIN_PX, abs=2)
    assert np.ptp(rows) == pytest.approx(np.ptp(cols) / 2, abs=2)


def test_a_dxf_in_metres_has_a_resolution_and_walls(tmp_path):
    ezdxf = pytest.importorskip("ezdxf", reason="pianta[cad] is not installed")
    document = ezdxf.new()
    document.header["$INSUNITS"] = 6
    document.modelspace().add_lwpolyline([(0, 0), (9, 0), (9, 4.5), (0, 4.5)], close=True, dxfattribs={"layer": "WALL"})
    document.saveas(tmp_path / "plan.dxf")
    sheet = open_sheet(tmp_path / "plan.dxf")
    assert sheet.resolution == pytest.approx(0.9 / 32)
    assert sheet.colors.shape == (160 + 2 * MARGIN_PX, 320 + 2 * MARGIN_PX, 3)
    assert sheet.walls is not None
    assert (sheet.walls == (sheet.colors[..., 0] == 0)).all()


@pytest.mark.slow
def test_a_drawn_pdf_is_drawn_with_its_texts(tmp_path):
    pytest.importorskip("pypdfium2", reason="pianta[pdf] is not installed")
    sheet = open_sheet(save_drawn_pdf(tmp_path / "plan.pdf"))
    assert sheet.texts is not None
    assert [text.text for text in sheet.texts] == ["Office"]
    assert sheet.source == "plan.pdf"
    assert set(np.unique(sheet.colors)) == {0, 255}


@pytest.mark.slow
def test_a_scanned_pdf_is_its_picture_page_by_page(tmp_path):
    """Two scans of 60 × 30 pixels, white and black, at 72 dots an inch: rendered at 300."""
    pytest.importorskip("pypdfium2", reason="pianta[pdf] is not installed")
    Image.new("L", (60, 30), 255).save(
        tmp_path / "scan.pdf", save_all=True, append_images=[Image.new("L", (60, 30))], resolution=72
    )
    for page, grey in ((1, 255), (2, 0)):
        sheet = open_sheet(tmp_path / "scan.pdf", page=page)
        assert sheet.colors.shape == pytest.approx((125, 250, 3), abs=1)
        assert sheet.colors[60, 125].tolist() == [grey] * 3
        assert (sheet.walls, sheet.texts, sheet.resolution, sheet.source) == (None, None, None, "scan.pdf")
    with pytest.raises(PlanError, match="page="):
        open_sheet(tmp_path / "scan.pdf")
    with pytest.raises(PlanError, match="page"):
        open_sheet(tmp_path / "scan.pdf", page=3)


@pytest.mark.parametrize("suffix", [".png", ".svg", ".dxf"])
def test_only_pdfs_have_pages(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_text("x")
    with pytest.raises(PlanError, match=rf"a\{suffix}.*page="):
        open_sheet(tmp_path / f"a{suffix}", page=2)


def test_other_kinds_are_refused_with_those_that_are_known(tmp_path):
    (tmp_path / "a.dwg").write_text("x")
    with pytest.raises(PlanError, match=r"a\.dwg.*\.png") as refusal:
        open_sheet(tmp_path / "a.dwg")
    assert all(suffix in str(refusal.value) for suffix in (*SHEET_SUFFIXES, ".ifc"))


@pytest.mark.parametrize(
    ("content", "fault"),
    [(None, "exist"), (b"", "empty"), (b"hello", "PNG"), (b"P5 4 4 255\n1", "damaged")],
)
def test_what_cannot_be_read_is_a_plan_error(tmp_path, content, fault):
    if content is not None:
        (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(PlanError, match=rf"^[^\n]*a\.png' [^\n]*{fault}[^\n]*$"):
        open_sheet(tmp_path / "a.png")


def test_addresses_and_folders_are_refused(tmp_path):
    with pytest.raises(PlanError, match=r"\baddress\b"):
        open_sheet("https://example.org/a.png")
    with pytest.raises(PlanError, match=r"\bfolder\b"):
        open_sheet(tmp_path)


def test_pictures_beyond_the_limit_are_refused(tmp_path):
    path = save_picture(tmp_path / "a.png")
    assert open_sheet(path, max_cells=6).colors.shape == (2, 3, 3)
    with pytest.raises(PlanError, match=r"\b6\b.*\b5\b.*max_cells="):
        open_sheet(path, max_cells=5)


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
@settings(max_examples=40)
@given(data=st.data())
def test_only_our_errors_escape_from_mutated_pictures(tmp_path_factory, suffix, data):
    path = save_picture(tmp_path_factory.getbasetemp() / f"mutated{suffix}", size=(20, 10))
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    with refused_in_one_line():
        assert open_sheet(path, max_cells=10_000).colors.shape[2] == 3
