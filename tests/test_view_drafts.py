"""Lines on the page of `pianta view` that are half drawn, or refused: they stay until they fit or are given up."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser import Tab, open_browser, opened_tab
from tests.served_floors import serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")

DOOR_1_3 = (1.5, 1.9)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from open_browser()


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("folders") / "building")


@pytest.fixture
def folder(original, tmp_path) -> Path:
    return Path(shutil.copytree(original, tmp_path / "building"))


@pytest.fixture
def tab(browser, folder) -> Iterator[Tab]:
    with serving(folder) as client, opened_tab(browser, client) as opened:
        yield opened.wait_for_floor()


def points(tab: Tab) -> list[list[float]]:
    line: list[list[float]] = tab.page.evaluate("pianta.tools.points")
    return line


def reload(tab: Tab) -> None:
    tab.page.reload()
    tab.wait_for_floor()


def drag(tab: Tab, start: tuple[float, float], end: tuple[float, float]) -> None:
    tab.page.mouse.move(*tab.pixel(*start))
    tab.page.mouse.down()
    tab.page.mouse.move(*tab.pixel(*end), steps=5)
    tab.page.mouse.up()


class TestReload:
    def test_a_half_drawn_line_goes_on(self, tab):
        tab.use("split")
        tab.click((2.6, 2.05))
        before = points(tab)
        reload(tab)
        assert points(tab) == before
        assert tab.page.locator("path.draft-point").count() == 1
        tab.click((2.6, 4.95))
        tab.wait_for_ids(1, 2, 3, 4)
        # What is finished is not drawn again.
        reload(tab)
        assert points(tab) == []

    def test_the_corners_of_an_outline_go_on(self, tab):
        tab.use("outside")
        tab.click((4.1, -0.25), (8.6, -0.25), (8.6, 1.85))
        reload(tab)
        assert len(points(tab)) == 3
        tab.click((4.1, 1.85), (4.1, 1.85))
        tab.wait_for_text("#corrections-count", "(1)")

    def test_a_picked_door_goes_on(self, tab):
        tab.use("move")
        tab.click(DOOR_1_3, (2.5, 1.9))
        reload(tab)
        tab.click((3.3, 1.9))
        tab.wait_for_text("#corrections-count", "(1)")

    def test_a_refused_line_stays_with_its_reason(self, tab):
        tab.use("split")
        tab.click((1, 3), (2, 3))
        tab.wait_for_text("#alert", "does not divide room 1")
        reload(tab)
        tab.wait_for_text("#alert", "does not divide room 1")
        assert points(tab) == [[pytest.approx(1, abs=0.05), pytest.approx(3, abs=0.05)],
                               [pytest.approx(2, abs=0.05), pytest.approx(3, abs=0.05)]]  # fmt: skip

    def test_what_was_given_up_is_gone(self, tab):
        tab.use("split")
        tab.click((2.6, 2.05))
        tab.page.keyboard.press("Escape")
        reload(tab)
        assert points(tab) == []

    def test_maps_do_not_share_a_line(self, browser, folder, tmp_path):
        other = write_folder(tmp_path / "other")
        with serving(folder, other) as client, opened_tab(browser, client, "#map=0") as tab:
            tab.wait_for_floor().use("split")
            tab.click((2.6, 2.05))
            tab.page.click("#to-gallery")
            tab.page.click(".card:has-text('other')")
            tab.wait_until("document.title.startsWith('other')")
            assert points(tab) == []
            tab.page.click("#to-gallery")
            tab.page.click(".card:has-text('building')")
            tab.wait_until("pianta.tools.points.length === 1")


class TestRefused:
    @pytest.fixture(autouse=True)
    def _refuse(self, tab):
        tab.use("split")
        tab.click((2.6, 2.05), (2.6, 3.5))
        tab.wait_for_text("#alert", "does not divide room 1")

    def test_the_reason_stands_beside_the_line(self, tab):
        box = tab.page.locator("#alert").bounding_box()
        x, y = tab.pixel(2.6, 3.5)
        assert box["x"] < x < box["x"] + box["width"]
        assert 0 < box["y"] - y < 50 or 0 < y - box["y"] - box["height"] < 50

    def test_a_point_is_dragged(self, tab):
        center = tab.page.evaluate("pianta.floorMap.map.getCenter().lng")
        drag(tab, (2.6, 3.5), (2.6, 4.95))
        tab.wait_for_ids(1, 2, 3, 4)
        assert tab.page.is_hidden("#alert")
        # The line was dragged, not the map.
        assert tab.page.evaluate("pianta.floorMap.map.getCenter().lng") == pytest.approx(center)
        assert points(tab) == []

    def test_a_point_is_picked_and_set_again(self, tab):
        tab.click((2.6, 3.5))
        tab.wait_for_text("#hint", "Set the point")
        tab.click((2.6, 4.95))
        tab.wait_for_ids(1, 2, 3, 4)

    def test_a_point_that_is_moved_in_vain_is_refused_again(self, tab):
        drag(tab, (2.6, 3.5), (2.6, 4.0))
        tab.wait_until("pianta.tools.reason !== null && Math.abs(pianta.tools.points[1][1] - 4) < 0.1")
        assert "does not divide room 1" in tab.page.text_content("#alert")

    def test_the_last_point_is_taken_back(self, tab):
        tab.page.click("#take-back")
        assert len(points(tab)) == 1
        assert tab.page.is_hidden("#alert")
        tab.click((2.6, 4.95))
        tab.wait_for_ids(1, 2, 3, 4)

    def test_another_line_takes_its_place(self, tab):
        tab.click((0.8, 2.05), (0.8, 4.95))
        tab.wait_for_ids(1, 2, 3, 4)

    def test_it_is_given_up(self, tab):
        tab.page.click("#stop")
        assert points(tab) == []
        assert tab.page.is_hidden("#draft")


def test_a_finger_drags_a_point(browser, folder):
    with serving(folder) as client, opened_tab(browser, client, has_touch=True) as tab:
        tab.wait_for_floor().use("split")
        tab.click((2.6, 2.05), (2.6, 3.5))
        tab.wait_for_text("#alert", "does not divide room 1")
        touch = tab.page.context.new_cdp_session(tab.page)
        for event, point in (("Start", (2.6, 3.5)), ("Move", (2.6, 4.2)), ("Move", (2.6, 4.95)), ("End", None)):
            touches = [dict(zip("xy", tab.pixel(*point), strict=True))] if point else []
            touch.send("Input.dispatchTouchEvent", {"type": f"touch{event}", "touchPoints": touches})
        tab.wait_for_ids(1, 2, 3, 4)


def test_the_finish_button_closes_an_outline(tab):
    tab.use("outside")
    tab.click((4.1, -0.25), (8.6, -0.25))
    assert tab.page.is_disabled("#finish")
    tab.click((8.6, 1.85), (4.1, 1.85))
    tab.page.click("#finish")
    tab.wait_for_text("#corrections-count", "(1)")
