"""The page of `pianta view` without a mouse: every tool by the cross-hair, and what is around the map by Tab."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from shapely import box

from pianta.corrections.kinds import SplitRoom
from pianta.floor import Floor
from pianta.reading.saved_reading import SavedReading
from tests.browser import Tab, open_browser, opened_tab
from tests.served_floors import serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")

# Inside rooms 1 and 3 of FLOOR, and the middle of the door between them.
ROOM_1, ROOM_3 = (1.2, 3.0), (3.3, 0.5)
DOOR_1_3 = (1.5, 1.9)
# Pixels of an arrow key, and of one with Shift.
STEP, FINE_STEP = 12, 1


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


def press(tab: Tab, *keys: str) -> None:
    for key in keys:
        tab.page.keyboard.press(key)


def cross(tab: Tab) -> tuple[float, float]:
    """Where the cross-hair is in the window; at first in the middle of the map."""
    x, y = tab.page.evaluate(
        """() => {
            const {map} = pianta.floorMap, {lat, lng} = map.getCenter();
            return pianta.tools.cross ?? [lng, lat];
        }"""
    )
    return tab.pixel(x, y)


def go(tab: Tab, *point: float) -> None:
    """Move the cross-hair to a point of the map frame, by coarse and fine steps."""
    for axis, names in enumerate((("ArrowLeft", "ArrowRight"), ("ArrowUp", "ArrowDown"))):
        pixels = round(tab.pixel(*point)[axis] - cross(tab)[axis])
        key = names[pixels > 0]
        press(tab, *[key] * (abs(pixels) // STEP), *[f"Shift+{key}"] * (abs(pixels) % STEP // FINE_STEP))


def draw(tab: Tab, *points: tuple[float, float]) -> None:
    for point in points:
        go(tab, *point)
        press(tab, "Enter")


def save(tab: Tab, folder: Path) -> Floor:
    press(tab, "Control+s")
    tab.wait_for_text("#hint", "Saved.")
    return SavedReading.open(folder).floor


def count(tab: Tab, number: int) -> None:
    tab.wait_for_text("#corrections-count", f"({number})")


class TestCrossHair:
    def test_arrows_move_it_by_12_pixels_and_with_shift_by_one(self, tab):
        press(tab, "s")
        x, y = cross(tab)
        press(tab, "ArrowRight", "ArrowRight", "ArrowDown", "Shift+ArrowLeft", "Shift+ArrowUp", "Shift+ArrowUp")
        assert cross(tab) == pytest.approx((x + 2 * STEP - FINE_STEP, y + STEP - 2 * FINE_STEP), abs=0.01)
        assert tab.page.locator(".cross-hair").is_visible()

    def test_the_map_follows_it(self, tab):
        press(tab, "s")
        press(tab, *["ArrowLeft"] * 60)
        frame = tab.page.locator("#map").bounding_box()
        assert cross(tab)[0] > frame["x"]
        assert tab.page.evaluate("pianta.tools.cross")[0] < -3

    def test_facts_of_what_is_below_are_shown(self, tab):
        press(tab, "m")
        go(tab, *ROOM_1)
        assert tab.page.text_content("#tip").startswith("Room 1")
        go(tab, *DOOR_1_3)
        assert tab.page.text_content("#tip") == "Door between room 1 and room 3, 1.00 m"

    def test_points_snap_to_walls(self, tab, folder):
        press(tab, "s")
        draw(tab, (2.6, 2.06), (2.6, 4.94))
        tab.wait_for_ids(1, 2, 3, 4)
        save(tab, folder)
        (split,) = SavedReading.open(folder).corrections
        assert isinstance(split, SplitRoom)
        assert [y for _, y in split.line] == pytest.approx([2, 5], abs=1e-9)


class TestTools:
    def test_draw_a_room_in_free_space(self, tab, folder):
        press(tab, "x")
        draw(tab, ROOM_1)
        tab.wait_for_ids(2, 3)
        press(tab, "r")
        draw(tab, (1, 3), (3, 3), (3, 4.5), (1, 4.5))
        # Enter once more at the last corner closes the outline.
        press(tab, "Enter")
        tab.wait_for_ids(2, 3, 4)
        assert save(tab, folder)[4].polygon.symmetric_difference(box(1, 3, 3, 4.5)).area < 0.1

    def test_the_last_corner_is_taken_back(self, tab, folder):
        press(tab, "x")
        draw(tab, ROOM_1)
        tab.wait_for_ids(2, 3)
        press(tab, "r")
        draw(tab, (1, 3), (3, 3), (3, 4.5), (2.2, 3.8))
        press(tab, "Backspace")
        draw(tab, (1, 4.5))
        press(tab, "Enter")
        tab.wait_for_ids(2, 3, 4)
        assert save(tab, folder)[4].polygon.area == pytest.approx(3, abs=0.1)

    def test_outside_by_a_room_and_by_an_outline(self, tab, folder):
        press(tab, "o")
        draw(tab, ROOM_1)
        tab.wait_for_ids(2, 3)
        # From outside of all rooms around the right half of the corridor.
        draw(tab, (4.1, -0.25), (8.6, -0.25), (8.6, 1.85), (4.1, 1.85))
        press(tab, "Enter")
        count(tab, 2)
        assert save(tab, folder)[3].polygon.area == pytest.approx(4.1 * 1.8, abs=0.2)

    def test_merge(self, tab):
        press(tab, "m")
        draw(tab, ROOM_1, (5.2, 3.0))
        tab.wait_for_ids(1, 3)

    @pytest.mark.parametrize(("key", "door_kind"), [("d", "door"), ("p", "opening")])
    def test_draw_a_door_and_an_opening(self, tab, folder, key, door_kind):
        press(tab, key)
        draw(tab, (2.5, 1.9), (3.3, 1.9))
        count(tab, 1)
        doors = {(door.kind, round(door.line.centroid.x, 1)) for door in save(tab, folder).doors}
        assert (door_kind, 2.9) in doors

    def test_move_change_and_delete_a_door(self, tab, folder):
        press(tab, "g")
        draw(tab, DOOR_1_3, (2.5, 1.9), (3.3, 1.9))
        count(tab, 1)
        press(tab, "c")
        draw(tab, (2.9, 1.9))
        count(tab, 2)
        press(tab, "e")
        draw(tab, (6.5, 1.9))
        count(tab, 3)
        doors = sorted((door.kind, round(door.line.centroid.x, 1)) for door in save(tab, folder).doors)
        assert doors == [("door", 8.3), ("opening", 2.9)]

    def test_set_a_length(self, tab, folder):
        press(tab, "l")
        # The north wall of room 1, 4 m.
        draw(tab, (0, 5), (4, 5))
        tab.page.wait_for_selector("#dialog[open]")
        press(tab, "Control+a", "8", "Enter")
        count(tab, 1)
        assert save(tab, folder)[1].polygon.area == pytest.approx(48, abs=0.1)

    def test_a_refused_line_is_mended(self, tab):
        press(tab, "s")
        draw(tab, (1, 2), (1, 3.5))
        tab.wait_for_text("#alert", "does not divide room 1")
        # The cross-hair is at the end: pick it up, and set it at the north wall.
        press(tab, "Enter")
        draw(tab, (1, 5))
        tab.wait_for_ids(1, 2, 3, 4)

    def test_escape_leaves_the_line_then_the_tool(self, tab):
        press(tab, "d")
        draw(tab, (2.5, 1.9))
        press(tab, "Escape")
        assert not tab.page.evaluate("pianta.tools.busy")
        assert tab.page.evaluate("pianta.tools.name") == "door"
        press(tab, "Escape")
        assert tab.page.evaluate("pianta.tools.name") == "select"


class TestAroundTheMap:
    def test_tab_reaches_every_part(self, tab):
        # Something to undo and to save, and a room whose fields are shown.
        press(tab, "x")
        draw(tab, ROOM_1)
        tab.wait_for_ids(2, 3)
        press(tab, "Escape")
        tab.page.click("#rooms tbody tr")
        tab.page.evaluate("document.activeElement.blur()")
        reached = []
        for _ in range(60):
            press(tab, "Tab")
            reached.append(
                tab.page.evaluate(
                    "(({id, name, dataset}) => id || name || dataset.tool || dataset.room)(document.activeElement)"
                )
            )
        parts = ["undo", "save", "theme", "help", "select", "length", "map", "name", "label", "area", "find", "2"]
        positions = [reached.index(part) for part in parts]
        assert positions == sorted(positions)

    def test_focus_is_seen(self, tab):
        press(tab, "Tab", "Tab", "Tab")
        style = tab.page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert style == "solid"

    def test_a_door_is_changed_from_the_panel_of_its_room(self, tab):
        press(tab, "/")
        tab.page.keyboard.type("1")
        press(tab, "ArrowDown", "Enter")
        tab.page.focus("#selected dd button.link")
        press(tab, "Enter")
        tab.wait_for_text("#selected h2", "Door")
        tab.page.focus("#selected button:has-text('Make it an opening')")
        press(tab, "Enter")
        tab.wait_for_text("#selected h2", "Opening")
        count(tab, 1)

    def test_layers_switch_by_space(self, tab):
        tab.page.focus("#layers-part summary")
        press(tab, "Enter", "Tab", "Space")
        assert tab.page.is_checked("#layers [name=map]") is False
        assert tab.page.locator("img.background").count() == 0

    def test_the_whole_floor_by_0(self, tab):
        zoom = tab.page.evaluate("pianta.floorMap.map.getZoom()")
        tab.page.focus("#map")
        press(tab, "+")
        tab.wait_until("zoom => pianta.floorMap.map.getZoom() > zoom", zoom)
        tab.page.wait_for_timeout(400)
        press(tab, "0")
        tab.wait_until("zoom => pianta.floorMap.map.getZoom() === zoom", zoom)
