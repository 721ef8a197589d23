"""Doubtful areas on the page of `pianta view`, in a real browser."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pianta.floor.area_trust import AreaTrust
from pianta.labels import ALL_SCHEMAS
from pianta.plan.sheets.sheet import PlanScale
from pianta.reading.reading import write_floor
from tests.browser import Tab, open_browser, opened_tab
from tests.served_floors import FLOOR, make_grid, serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")

ROUGH = PlanScale(0.1, "3 doors", 0.5, (0.09, 0.12), (0.08, 0.15))
LOOK = PlanScale(0.1, "the look of the drawing", 0.3, (0.08, 0.12), (0.05, 0.2), is_look=True)
# The middle of a room of FLOOR with 12 m².
ROOM_2 = (5.2, 3.0)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from open_browser()


@pytest.fixture
def tab(browser: Any, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Tab]:
    """The page of FLOOR with a scale."""
    folder = write_folder(tmp_path / "plan")
    write_floor(FLOOR, make_grid(), folder, ALL_SCHEMAS, scale=request.param)
    with serving(folder) as client, opened_tab(browser, client) as opened:
        yield opened.wait_for_floor()


def areas(tab: Tab) -> list[str]:
    texts: list[str] = tab.page.locator("#rooms tbody td:last-child").all_text_contents()
    return texts


@pytest.mark.parametrize("tab", [None], indirect=True)
def test_a_map_has_plain_areas(tab: Tab):
    assert areas(tab) == ["12.0 m²", "12.0 m²", "14.8 m²"]
    assert tab.page.is_hidden("#areas-note")
    assert tab.page.text_content(".leaflet-control-scale-line") == "1 m"


@pytest.mark.parametrize("tab", [ROUGH], indirect=True)
def test_rough_areas_have_a_mark(tab: Tab):
    assert areas(tab) == ["≈ 12 m²", "≈ 12 m²", "≈ 15 m²"]
    assert tab.page.text_content("#areas-note") == AreaTrust.ROUGH.note
    assert tab.page.text_content(".leaflet-control-scale-line") == "≈ 1 m"
    tab.page.mouse.move(*tab.pixel(*ROOM_2))
    assert "\n≈ 12 m², doors: 2" in tab.page.text_content("#tip")


@pytest.mark.parametrize("tab", [LOOK], indirect=True)
def test_unknown_areas_are_left_out_until_a_person_gives_one(tab: Tab):
    assert areas(tab) == ["?", "?", "?"]
    assert tab.page.text_content("#areas-note") == AreaTrust.UNKNOWN.note
    assert tab.page.is_hidden(".leaflet-control-scale-line")
    tab.click(ROOM_2)
    assert "m²" not in tab.page.text_content("#selected dl")
    # Lengths are doubled
    assert not tab.page.input_value("#selected [name=area]")
    tab.page.fill("#selected [name=area]", "48")
    tab.page.press("#selected [name=area]", "Enter")
    tab.wait_for_text("#rooms tbody", "48.0 m²")
    assert areas(tab) == ["48.0 m²", "48.0 m²", "59.0 m²"]
    assert tab.page.is_hidden("#areas-note")
    assert tab.page.is_visible(".leaflet-control-scale-line")
    tab.page.click("#undo")
    tab.wait_for_text("#areas-note", AreaTrust.UNKNOWN.note)
    assert areas(tab) == ["?", "?", "?"]


def test_the_gallery_marks_areas(browser: Any, tmp_path: Path):
    folders = [write_folder(tmp_path / name) for name in ("map", "rough", "look")]
    for folder, scale in zip(folders[1:], (ROUGH, LOOK), strict=True):
        write_floor(FLOOR, make_grid(), folder, ALL_SCHEMAS, scale=scale)
    with serving(*folders) as client, opened_tab(browser, client) as tab:
        tab.page.wait_for_selector(".card")
        texts = tab.page.locator(".card p").all_text_contents()
    assert texts == ["3 rooms, 38.8 m², office", "3 rooms, ≈ 39 m², office", "3 rooms, office"]
