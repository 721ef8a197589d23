"""The page of `pianta view` in a real browser."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest

from pianta.corrections.kinds import SplitRoom
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.floors import save_floor
from pianta.labels import ALL_SCHEMAS
from pianta.reading.reading import write_floor
from pianta.reading.saved_reading import SavedReading
from tests.browser import Tab, open_browser, opened_tab
from tests.command_line import run_pianta
from tests.served_floors import FLOOR, serving, write_folder, write_large_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")

HOSTILE = '<img src=x onerror="document.title=1"></script><script>alert(1)</script>'
# The middles of the rooms of FLOOR, away from their walls.
ROOM_1, ROOM_2, ROOM_3 = (1.2, 3.0), (5.2, 3.0), (3.3, 0.5)
DOOR_1_3 = (1.5, 1.9)
# Width and height of the picture of the map, and the share of its pixels that are occupied.
SHARE_OF_WALLS = """() => {
    const image = document.querySelector("img.background");
    const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, canvas.width, canvas.height);
    let dark = 0;
    for (let index = 0; index < data.length; index += 4) if (data[index] < 60) dark += 1;
    return [canvas.width, canvas.height, (4 * dark) / data.length];
}"""


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


def floor_of(folder: Path) -> Floor:
    return SavedReading.open(folder).floor


class TestLooking:
    def test_open(self, tab):
        assert tab.page.text_content("#title") == "building"
        assert tab.ids() == [1, 2, 3]
        tab.page.wait_for_selector("img.background.loaded")
        texts = tab.page.locator(".room-text").all_text_contents()
        assert sorted(texts) == ["1\nOFFICE", "2\nBar\nKITCHEN", "3\nCORRIDOR"]

    def test_hover_shows_the_facts_of_a_room_and_of_a_door(self, tab):
        tab.page.mouse.move(*tab.pixel(*ROOM_2))
        assert tab.page.text_content("#tip") == "Room 2 “Bar”\nKITCHEN\n12.0 m², doors: 2, next to 3"
        tab.page.mouse.move(*tab.pixel(*DOOR_1_3))
        assert tab.page.text_content("#tip") == "Door between room 1 and room 3, 1.00 m"

    def test_click_selects_on_the_map_and_in_the_list(self, tab):
        tab.click(ROOM_2)
        assert tab.page.text_content("#selected h2") == "Room 2"
        assert tab.page.input_value("#selected [name=name]") == "Bar"
        assert tab.page.get_attribute("#rooms [aria-selected=true]", "data-room") == "2"

    def test_the_background_is_below_its_rooms(self, tab):
        # The map is 9 m wide, from x = -0.3 m.
        tab.page.wait_for_selector("img.background.loaded")
        area = tab.page.locator("img.background").bounding_box()
        left, top = tab.pixel(-0.3, 5.7)
        right, bottom = tab.pixel(8.7, -0.3)
        assert [area["x"], area["y"]] == pytest.approx([left, top], abs=1)
        assert [area["width"], area["height"]] == pytest.approx([right - left, bottom - top], abs=1)

    def test_a_turned_map_is_turned_on_the_page(self, browser, tmp_path):
        folder = tmp_path / "turned"
        folder.mkdir()
        grid = GridMap(np.zeros((60, 90), np.int8), 0.1, (0.0, 0.0, np.pi / 6))
        grid.save(folder / "grid.npz")
        write_floor(FLOOR, grid, folder, ALL_SCHEMAS)
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.wait_for_floor().page.wait_for_selector("img.background.loaded")
            a, b = tab.page.evaluate(
                """() => {
                    const {a, b} = new DOMMatrix(getComputedStyle(document.querySelector("img.background")).transform);
                    return [a, b];
                }"""
            )
        # Upwards on the screen is negative.
        assert np.arctan2(b, a) == pytest.approx(-np.pi / 6, abs=0.01)

    def test_the_list_sorts_and_finds(self, tab):
        tab.page.click("#sort-area button")
        # The areas are 12, 12 and 14.76 m².
        assert tab.ids() == [1, 2, 3]
        tab.page.click("#sort-area button")
        assert tab.ids() == [3, 1, 2]
        tab.page.fill("#find", "bar")
        assert tab.ids() == [2]
        tab.page.fill("#find", "3")
        assert tab.ids() == [3]
        tab.page.fill("#find", "nothing like this")
        assert tab.ids() == []

    def test_layers_switch(self, tab):
        doors = tab.page.locator("path.door")
        assert doors.count() > 0
        tab.page.click("#layers-part summary")
        tab.page.uncheck("#layers [name=doors]")
        assert doors.count() == 0
        tab.page.check("#layers [name=doors]")
        assert doors.count() > 0

    def test_the_layer_of_rooms_switches(self, tab):
        def is_filled() -> bool:
            return bool(tab.color_of_room(*ROOM_1)[3])

        tab.wait_for_frame()
        assert is_filled()
        tab.page.click("#layers-part summary")
        tab.page.uncheck("#layers [name=rooms]")
        tab.wait_for_frame()
        assert not is_filled()
        tab.page.check("#layers [name=rooms]")
        tab.wait_for_frame()
        assert is_filled()

    def test_dark_and_light(self, browser, folder):
        with serving(folder) as client, opened_tab(browser, client, color_scheme="dark") as tab:
            tab.wait_for_floor()
            ground = "getComputedStyle(document.body).backgroundColor"
            dark = tab.page.evaluate(ground)
            tab.page.click("#theme")
            assert tab.page.evaluate(ground) != dark
            tab.page.reload()
            tab.wait_for_floor()
            assert tab.page.evaluate(ground) != dark

    def test_gallery(self, browser, folder, tmp_path):
        other = write_folder(tmp_path / "other", replace(FLOOR, rooms=FLOOR.rooms[:1], doors=()))
        with serving(folder, other) as client, opened_tab(browser, client) as tab:
            tab.page.wait_for_selector(".card svg")
            assert tab.page.locator(".card h2").all_text_contents() == ["building", "other"]
            tab.page.click(".card:has-text('other')")
            tab.wait_for_floor()
            assert tab.ids() == [1]
            tab.page.click("#to-gallery")
            tab.page.wait_for_selector(".card svg")

    def test_a_tap_on_a_tablet_selects(self, browser, folder):
        with serving(folder) as client, opened_tab(browser, client, has_touch=True) as tab:
            tab.page.set_viewport_size({"width": 768, "height": 1024})
            tab.wait_for_floor()
            tab.page.wait_for_timeout(300)
            tab.page.touchscreen.tap(*tab.pixel(*ROOM_1))
            tab.wait_for_text("#selected", "Room 1")
            assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


class TestEditing:
    def test_merge_by_two_clicks(self, tab, folder):
        tab.use("merge")
        tab.click(ROOM_1, ROOM_2)
        tab.wait_for_ids(1, 3)
        assert len(floor_of(folder)) == 3
        tab.save()
        assert [room.id for room in floor_of(folder)] == [1, 3]

    def test_split_by_a_line_that_snaps_to_the_walls(self, tab, folder):
        tab.use("split")
        # Some pixels inside the room, whose walls are at 2 m and 5 m.
        tab.click((2.6, 2.08), (2.6, 4.92))
        tab.wait_for_ids(1, 2, 3, 4)
        tab.save()
        (split,) = SavedReading.open(folder).corrections
        assert isinstance(split, SplitRoom)
        assert [y for _, y in split.line] == pytest.approx([2, 5], abs=1e-9)
        # 2.6 m and 1.4 m of 3 m; the larger part keeps the id.
        areas = {room.id: room.polygon.area for room in floor_of(folder)}
        assert [areas[1], areas[4]] == pytest.approx([7.8, 4.2], abs=0.1)

    def test_a_split_beyond_rooms_is_refused_with_a_reason(self, tab):
        tab.use("split")
        tab.click((0.5, 5.4), (2.5, 5.4))
        tab.wait_for_text("#alert", "The line crosses no room")
        tab.click((1, 3), (2, 3))
        tab.wait_for_text("#alert", "does not divide room 1")
        assert tab.ids() == [1, 2, 3]

    def test_draw_a_room(self, tab, folder):
        tab.use("remove")
        tab.click(ROOM_1)
        tab.wait_for_ids(2, 3)
        tab.use("draw")
        tab.click((1, 3), (3, 3), (3, 4.5), (1, 4.5), (1, 4.5))
        tab.wait_for_ids(2, 3, 4)
        tab.save()
        assert floor_of(folder)[4].polygon.area == pytest.approx(3, abs=0.05)

    def test_doors(self, tab, folder):
        tab.use("change")
        tab.click(DOOR_1_3)
        tab.wait_for_text("#corrections", "an opening")
        tab.use("erase")
        tab.click((6.5, 1.9))
        tab.wait_for_text("#corrections-count", "(2)")
        tab.use("door")
        tab.click((2.5, 1.9), (3.3, 1.9))
        tab.wait_for_text("#corrections-count", "(3)")
        tab.save()
        doors = sorted((door.kind, door.room_ids, round(door.line.centroid.x, 1)) for door in floor_of(folder).doors)
        assert doors == [("door", (1, 3), 2.9), ("door", (2,), 8.3), ("opening", (1, 3), 1.5)]

    def test_move_a_door_by_its_panel_and_the_map(self, tab, folder):
        tab.click(DOOR_1_3)
        tab.page.click("#selected button:has-text('Move')")
        tab.click((2.5, 1.9), (3.3, 1.9))
        tab.wait_for_text("#corrections-count", "(1)")
        tab.save()
        middles = sorted(round(door.line.centroid.x, 1) for door in floor_of(folder).doors)
        assert middles == [2.9, 6.5, 8.3]

    def test_a_room_that_is_outside_makes_its_doors_entrances(self, tab, folder):
        tab.use("outside")
        tab.click(ROOM_1)
        tab.wait_for_ids(2, 3)
        tab.save()
        assert sorted(door.room_ids for door in floor_of(folder).doors) == [(2,), (2, 3), (3,)]

    def test_rename_and_label(self, tab, folder):
        tab.click(ROOM_1)
        tab.page.fill("#selected [name=name]", "2502C")
        tab.page.press("#selected [name=name]", "Enter")
        tab.wait_for_text("#rooms", "2502C")
        tab.page.fill("#selected [name=label]", "kitchen")
        tab.page.press("#selected [name=label]", "Enter")
        tab.wait_for_text("#corrections-count", "(2)")
        tab.page.fill("#selected [name=label]", "kitchne")
        tab.page.press("#selected [name=label]", "Enter")
        tab.wait_for_text("#alert", "is in no schema")
        assert tab.page.locator("#label-names option[value=KITCHEN]").count() == 1
        tab.page.fill("#find", "2502C")
        assert tab.ids() == [1]
        tab.save()
        room = floor_of(folder)[1]
        assert (room.name, room.label) == ("2502C", "KITCHEN")

    def test_number(self, tab, folder):
        """A number is before the name on the map and in hover texts, in a column of its own, and found."""
        assert tab.page.is_hidden("#sort-number")
        tab.click(ROOM_2)
        tab.page.fill("#selected [name=number]", "204")
        tab.page.press("#selected [name=number]", "Enter")
        tab.wait_for_text("#rooms", "204")
        assert tab.page.is_visible("#sort-number")
        assert "2\n204 Bar\nKITCHEN" in tab.page.locator(".room-text").all_text_contents()
        tab.page.mouse.move(*tab.pixel(*ROOM_2))
        assert tab.page.text_content("#tip").startswith("Room 2 “204 Bar”\n")
        for wanted in ("204", "04 ba"):
            tab.page.fill("#find", wanted)
            assert tab.ids() == [2]
        tab.page.fill("#find", "")
        tab.page.click("#sort-number button")
        # Rooms without a number are first.
        assert tab.ids() == [1, 3, 2]
        tab.save()
        assert (floor_of(folder)[2].number, floor_of(folder)[2].name) == ("204", "Bar")
        tab.page.click("#undo")
        tab.wait_until("document.getElementById('sort-number').offsetParent === null")
        assert tab.page.input_value("#selected [name=number]") == ""

    def test_building_type(self, tab, folder):
        tab.page.click("#building-part summary")
        tab.page.fill("#building [name=type]", "school")
        tab.page.press("#building [name=type]", "Enter")
        tab.wait_for_text("#corrections-count", "(1)")
        tab.save()
        assert floor_of(folder).given_type == "school"

    def test_scale_by_a_length(self, tab, folder):
        tab.use("length")
        # The north wall of room 1 is 4 m long; clicks snap to its corners.
        tab.click((0.02, 4.98), (3.98, 4.98))
        tab.page.fill("#dialog input", "8")
        tab.page.press("#dialog input", "Enter")
        tab.wait_for_text("#corrections-count", "(1)")
        tab.save()
        assert floor_of(folder)[1].polygon.area == pytest.approx(48)
        tab.wait_until("document.querySelectorAll('img.background').length === 1")
        left, _ = tab.pixel(-0.6, 0)
        assert tab.page.locator("img.background").bounding_box()["x"] == pytest.approx(left, abs=1)

    def test_undo_and_redo_without_limit(self, tab, folder):
        tab.click(ROOM_1)
        for number in range(12):
            tab.page.fill("#selected [name=name]", f"Name {number}")
            tab.page.press("#selected [name=name]", "Enter")
            tab.wait_for_text("#rooms", f"Name {number}")
        tab.page.focus("#map")
        for _ in range(12):
            tab.page.keyboard.press("Control+z")
        tab.page.wait_for_selector("#undo:disabled")
        assert "Name" not in tab.page.text_content("#rooms tbody")
        assert tab.page.is_disabled("#save")
        for _ in range(11):
            tab.page.keyboard.press("Control+Shift+z")
        tab.wait_for_text("#rooms tbody", "Name 10")
        tab.save()
        assert floor_of(folder)[1].name == "Name 10"

    def test_a_correction_is_removed_from_the_list(self, tab):
        tab.use("remove")
        tab.click(ROOM_1)
        tab.wait_for_ids(2, 3)
        tab.page.click("#corrections-part summary")
        tab.page.click("#corrections button")
        tab.wait_for_ids(1, 2, 3)
        tab.page.click("#undo")
        tab.wait_for_ids(2, 3)


class TestFilesAndTabs:
    def test_a_later_reading_keeps_corrections(self, browser, tmp_path):
        run_pianta("world", "hall", "-o", tmp_path / "world")
        folder = tmp_path / "read"
        run_pianta("read", tmp_path / "world" / "map.yaml", "-o", folder)
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.wait_for_floor()
            tab.page.click("#rooms tbody tr")
            tab.page.fill("#selected [name=name]", "Mine")
            tab.page.press("#selected [name=name]", "Enter")
            tab.wait_for_text("#rooms", "Mine")
            tab.save()
            run_pianta("read", tmp_path / "world" / "map.yaml", "-o", folder, "--previous", folder)
            tab.page.reload()
            tab.wait_for_floor()
            assert "Mine" in tab.page.text_content("#rooms")
            assert tab.page.text_content("#corrections-count") == "(1)"

    def test_a_saved_edit_appears_in_another_tab_which_keeps_its_view(self, browser, folder):
        with serving(folder) as client, opened_tab(browser, client) as first, opened_tab(browser, client) as second:
            first.wait_for_floor()
            second.wait_for_floor()
            second.page.keyboard.press("Tab")
            second.page.focus("#map")
            second.page.keyboard.press("+")
            second.page.wait_for_timeout(500)
            view = second.page.evaluate("String(pianta.floorMap.map.getBounds().toBBoxString())")
            first.use("remove")
            first.click(ROOM_1)
            first.wait_for_ids(2, 3)
            first.save()
            second.wait_for_ids(2, 3)
            assert second.page.evaluate("String(pianta.floorMap.map.getBounds().toBBoxString())") == view

    def test_a_tab_with_unsaved_edits_has_a_choice(self, browser, folder):
        with serving(folder) as client, opened_tab(browser, client) as first, opened_tab(browser, client) as second:
            first.wait_for_floor().click(ROOM_1)
            first.page.fill("#selected [name=name]", "First")
            first.page.press("#selected [name=name]", "Enter")
            first.wait_for_text("#rooms", "First")
            second.wait_for_floor().use("remove")
            second.click(ROOM_2)
            second.wait_for_ids(1, 3)
            second.save()
            first.wait_for_text("#dialog", "have changed on disk")
            first.page.click("#dialog button.main")
            first.wait_for_ids(1, 3)
            first.save()
        floor = floor_of(folder)
        assert [(room.id, room.name) for room in floor] == [(1, "First"), (3, None)]

    def test_reload_in_the_middle_of_an_edit(self, tab, folder):
        tab.use("remove")
        tab.click(ROOM_1)
        tab.wait_for_ids(2, 3)
        tab.use("split")
        tab.click((5, 2.0))
        tab.page.reload()
        tab.wait_for_floor()
        tab.wait_for_ids(2, 3)
        assert len(floor_of(folder)) == 3
        assert tab.page.text_content("#summary") == "Not saved"
        tab.page.click("#undo")
        tab.wait_for_ids(1, 2, 3)
        tab.page.click("#redo")
        tab.wait_for_ids(2, 3)
        tab.save()
        assert len(floor_of(folder)) == 2

    def test_a_folder_that_goes_is_reported_and_edits_stay(self, tab, folder):
        tab.use("remove")
        tab.click(ROOM_1)
        tab.wait_for_ids(2, 3)
        moved = folder.rename(folder.with_name("moved"))
        tab.wait_for_text("#alert", "read the map again")
        assert tab.ids() == [2, 3]
        moved.rename(folder)
        tab.page.wait_for_selector("#alert", state="hidden")
        tab.save()

    def test_hostile_names_are_text(self, browser, folder, tmp_path):
        rooms = tuple(replace(room, name=HOSTILE) for room in FLOOR.rooms)
        save_floor(replace(FLOOR, rooms=rooms), folder / "floor.geojson")
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.wait_for_floor().click(ROOM_1)
            tab.page.mouse.move(*tab.pixel(*ROOM_2))
            assert HOSTILE in tab.page.text_content("#tip")
            assert HOSTILE in tab.page.text_content("#rooms")
            assert tab.page.input_value("#selected [name=name]") == HOSTILE
            assert tab.page.locator("img[src=x]").count() == 0
            assert tab.page.title() == "building, pianta"

    def test_the_report_needs_no_server_and_cannot_be_edited(self, browser, folder, tmp_path):
        rooms = tuple(replace(room, name=HOSTILE) for room in FLOOR.rooms)
        save_floor(replace(FLOOR, rooms=rooms), folder / "floor.geojson")
        run_pianta("view", folder, "--html", tmp_path / "report.html")
        context = browser.new_context()
        tab = Tab(context, (tmp_path / "report.html").as_uri()).wait_for_floor()
        tab.page.wait_for_selector("img.background.loaded")
        tab.click(ROOM_1)
        assert tab.page.text_content("#selected h2") == "Room 1"
        assert tab.page.is_hidden("#tools")
        assert tab.page.is_hidden("#save")
        assert tab.page.locator("#selected button[type=submit]").count() == 0
        assert {urlsplit(address).scheme for address in tab.addresses} <= {"file", "data"}
        assert tab.errors == []
        context.close()

    def test_no_request_to_another_host(self, tab):
        tab.use("merge")
        tab.click(ROOM_1, ROOM_2)
        tab.wait_for_ids(1, 3)
        hosts = {urlsplit(address).hostname for address in tab.addresses if not address.startswith("data:")}
        assert hosts == {"127.0.0.1"}


class TestKeyboard:
    def test_find_select_and_rename(self, tab):
        tab.page.keyboard.press("/")
        tab.page.keyboard.type("bar")
        tab.page.keyboard.press("ArrowDown")
        tab.page.keyboard.press("Enter")
        # The focus is at the name.
        tab.page.keyboard.press("Control+a")
        tab.page.keyboard.type("Cafe")
        tab.page.keyboard.press("Enter")
        tab.page.keyboard.press("Escape")
        tab.wait_for_text("#corrections-count", "(1)")
        tab.page.keyboard.press("Control+s")
        tab.wait_for_text("#hint", "Saved.")

    def test_arrow_keys_pan_and_plus_zooms(self, tab):
        tab.page.focus("#map")
        x, zoom = tab.page.evaluate("[pianta.floorMap.map.getCenter().lng, pianta.floorMap.map.getZoom()]")
        tab.page.keyboard.press("ArrowRight")
        tab.wait_until("x => pianta.floorMap.map.getCenter().lng > x", x)
        tab.page.keyboard.press("+")
        tab.wait_until("zoom => pianta.floorMap.map.getZoom() > zoom", zoom)

    def test_split_by_the_cross_hair(self, tab):
        tab.page.keyboard.press("s")
        start, end = tab.pixel(2.0, 2.0), tab.pixel(2.0, 5.0)
        left, top = tab.page.evaluate(
            "(() => {const box = document.getElementById('map').getBoundingClientRect();"
            "return [box.left + box.width / 2, box.top + box.height / 2]})()"
        )
        self.move(tab, start[0] - left, start[1] - top)
        tab.page.keyboard.press("Enter")
        self.move(tab, 0, end[1] - start[1])
        tab.page.keyboard.press("Enter")
        tab.wait_for_ids(1, 2, 3, 4)
        tab.page.keyboard.press("Control+z")
        tab.wait_for_ids(1, 2, 3)
        tab.page.keyboard.press("Control+y")
        tab.wait_for_ids(1, 2, 3, 4)

    def test_escape_leaves_the_line_and_then_the_tool(self, tab):
        tab.use("split")
        tab.click((1, 2))
        assert tab.page.locator("path.draft-point").count() == 1
        tab.page.keyboard.press("Escape")
        assert tab.page.locator("path.draft-point").count() == 0
        assert tab.page.get_attribute("#tools [data-tool=split]", "aria-pressed") == "true"
        tab.page.keyboard.press("Escape")
        assert tab.page.get_attribute("#tools [data-tool=select]", "aria-pressed") == "true"

    def move(self, tab: Tab, right: float, down: float) -> None:
        """Move the cross-hair by pixels, with steps of 12."""
        for distance, keys in ((right, ("ArrowRight", "ArrowLeft")), (down, ("ArrowDown", "ArrowUp"))):
            for _ in range(round(abs(distance) / 12)):
                tab.page.keyboard.press(keys[0] if distance > 0 else keys[1])


class TestLargeFloors:
    def test_600_rooms_on_a_map_of_4000_by_4000(self, browser, tmp_path):
        folder = write_large_folder(tmp_path / "large")
        floor = floor_of(folder)
        assert len(floor) == 600
        first, second = floor.doors[0].room_ids
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.wait_for_floor().page.wait_for_selector("img.background.loaded")
            assert tab.ids() == [*range(1, 601)]
            assert tab.page.evaluate("pianta.floorMap.groups.rooms.getLayers().length") == 600
            assert tab.page.evaluate(SHARE_OF_WALLS) == pytest.approx([4000, 4000, 0.03], abs=0.02)
            tab.page.fill("#find", "377")
            tab.page.press("#find", "Enter")
            tab.wait_for_text("#selected", "Room 377")
            tab.page.fill("#find", "")
            tab.use("merge")
            tab.page.keyboard.press("0")
            tab.click(*(floor[each].polygon.representative_point().coords[0] for each in (first, second)))
            tab.wait_for_ids(*(each for each in range(1, 601) if each != max(first, second)))
            tab.wait_for_text("#corrections-count", "(1)")


def test_scripts_of_the_page_are_modules_below_400_lines(original):
    static = Path(__file__).parents[1] / "src" / "pianta" / "view" / "static"
    own = [file for file in static.glob("*.js") if file.name != "leaflet.js"]
    assert own
    for file in own:
        text = file.read_text(encoding="utf-8")
        assert text.count("\n") < 400, file.name
        # Names are set by textContent.
        assert "innerHTML" not in text
        assert "insertAdjacentHTML" not in text
