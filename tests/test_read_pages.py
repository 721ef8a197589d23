"""The pages of a PDF are the storeys of one building; pages without a plan and overviews are left out."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import pianta
from pianta.errors import PlanError, PlanWarning
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.drawings.pdf import count_pdf_pages
from pianta.plan import read_pages
from pianta.plan.read_pages import read_plan_pages
from pianta.plan.read_plan import PlanFloor, PlanReading
from pianta.plan.sheets.sheet import PlacedText, PlanScale, Sheet
from pianta.plan.text.storey_titles import find_storey_title, parse_level
from tests.conftest import DATA
from tests.test_pdf_plan import ROOMS, pdf

pytest.importorskip("pypdfium2", reason="pianta[pdf] is not installed")


def text(content: str, height: float = 20) -> PlacedText:
    return PlacedText(content, np.array([[0, 0], [0, 100], [height, 100], [height, 0]], float))


def reading(*titles: str, floors: int = 1) -> PlanReading:
    grid = GridMap(np.zeros((2, 2), np.int8), 0.1)
    sheet = Sheet(np.zeros((2, 2, 3), np.uint8), texts=tuple(map(text, titles)))
    return PlanReading((PlanFloor(Floor(()), grid, PlanScale(0.1, "test", 1.0)),) * floors, sheet)


@pytest.fixture
def read(tmp_path, monkeypatch):
    """Reads a PDF whose pages are given, None for a page without a plan; returns the names of the floors."""

    def read_all(*pages: PlanReading | None) -> list[str]:
        path = tmp_path / "plan.pdf"
        path.write_bytes(pdf(*[ROOMS] * len(pages)))

        def read_page(source: Path, *, page: int) -> PlanReading:
            chosen = pages[page - 1]
            if chosen is None:
                raise PlanError(f"plan {str(source)!r} shows no rooms")
            return chosen

        monkeypatch.setattr(read_pages, "read_plan", read_page)
        return [floor.name for plan in read_plan_pages(path) for floor in plan.floors]

    return read_all


def test_titles_name_the_storeys_and_put_them_in_order(read):
    names = read(reading("2nd Floor"), reading("Kitchen", "Basement"), reading("Main Floor"))
    assert names == ["Basement", "Main Floor", "2nd Floor"]


def test_pages_name_them_unless_each_has_a_title_of_its_own(read):
    assert read(reading("2nd Floor"), reading()) == ["page 1", "page 2"]
    assert read(reading("1. OG"), reading("1. OG")) == ["page 1", "page 2"]


def test_pages_without_a_plan_and_overviews_are_left_out_with_a_warning(read):
    with pytest.warns(PlanWarning) as caught:
        names = read(reading(floors=2), reading("EG"), reading("OG 1"), None, None)
    assert names == ["EG", "OG 1"]
    messages = [str(warning.message).partition(": ")[2] for warning in caught]
    assert messages == [
        "pages 4, 5 show no plan, left out",
        "page 1 shows floors that other pages show one by one, left out",
    ]


def test_pages_with_more_floors_than_there_are_other_pages_stay(read):
    assert read(reading(floors=3), reading("EG")) == ["page 1 floor 1", "page 1 floor 2", "page 1 floor 3", "page 2"]


def test_pdfs_without_a_plan_and_with_too_many_pages_are_refused(read):
    with pytest.raises(PlanError, match=r"2 pages and none shows a plan; page 1: .*shows no rooms"):
        read(None, None)
    with pytest.raises(PlanError, match=r"31 pages, more than 30, choose one, page=1 … page=31"):
        read(*[None] * 31)


def test_the_pages_of_a_file_are_counted(tmp_path):
    path = tmp_path / "plan.pdf"
    path.write_bytes(pdf(ROOMS, ROOMS, ROOMS))
    assert count_pdf_pages(path) == 3
    path.write_bytes(b"%PDF-1.4 damaged")
    with pytest.raises(PlanError, match="damaged"):
        count_pdf_pages(path)


@pytest.mark.parametrize(
    ("title", "level"),
    [
        ("GROUND FLOOR PLAN", 0),
        ("2nd Floor", 2),
        ("Level 12", 12),
        ("Basement (Below Grade)", -1),
        ("Erdgeschoss", 0),
        ("2. OG", 2),
        ("3. Obergeschoss", 3),
        ("Piano terra", 0),
        ("primo piano", 1),
        ("Rez-de-chaussée", 0),
        ("2ème étage", 2),
        ("Planta baja", 0),
        ("Planta 3", 3),
        ("Floor area 1275 sq ft", None),
        ("Main Building: Above Grade Finished Area 2039.18 sq ft", None),
        ("Kitchen", None),
        ("egg", None),
        ("Level " + "x" * 60, None),
    ],
)
def test_levels_that_titles_name(title, level):
    assert parse_level(title) == level


def test_the_largest_title_counts_and_equal_ones_that_differ_do_not():
    assert find_storey_title([text("see 1st floor", 8), text("2nd Floor")]) == ("2nd Floor", 2)
    assert find_storey_title([text("1st floor"), text("2nd Floor")]) is None
    assert find_storey_title([text("Kitchen")]) is None


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "planfiles").exists(), reason=f"no planfiles in {DATA}")
def test_a_house_of_three_storeys(tmp_path):
    """Its first page shows all floors, the last one is text; another page of text is left out here."""
    import pypdfium2

    plans = pypdfium2.PdfDocument.new()
    plans.import_pages(pypdfium2.PdfDocument(DATA / "planfiles" / "pdf" / "asheville.pdf"), [0, 1, 2, 3, 5])
    plans.save(tmp_path / "asheville.pdf")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        house = pianta.read(tmp_path / "asheville.pdf", labels=False)
    assert sum(issubclass(warning.category, PlanWarning) for warning in caught) == 2
    assert [storey.title for storey in house.building.storeys] == ["Basement (Below Grade)", "Main Floor", "2nd Floor"]
    areas = [sum(room.polygon.area for room in floor) for floor in house.floors]
    # Written on the sheets, square feet; the basement is one room
    assert areas == pytest.approx([1566 * 0.3048**2, 1275.98 * 0.3048**2, 763.2 * 0.3048**2], rel=0.05)
    assert len(house.floors[1].doors) >= 10
    folders = house.save(tmp_path / "house")
    assert [folder.name for folder in folders] == ["Basement (Below Grade)", "Main Floor", "2nd Floor"]
