"""Predictions, explorations, generated buildings and realism on the page of `pianta view`."""

import json
import math
import shutil
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from PIL import Image
from shapely import Point, box

from pianta.errors import OptionError
from pianta.view.export import save_report
from pianta.view.folders import find_folders
from pianta.view.room_positions import place_unknown, radius_of
from tests.browser import Tab, open_browser, opened_tab
from tests.result_folders import write_buildings, write_exploration, write_prediction, write_realism
from tests.served_floors import Client, serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")

HOSTILE = '<img src=x onerror="document.title=1"></script><script>alert(1)</script>'


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from open_browser()


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a floor and results of each kind."""
    top = tmp_path_factory.mktemp("results")
    write_folder(top / "a_floor")
    write_prediction(top / "b_predicted")
    write_exploration(top / "c_explored")
    write_buildings(top / "d_schools")
    write_realism(top / "e_realism", {"one.xml": 0.2, "two.xml": 0.9, "ten.xml": 0.5})
    return top


@pytest.fixture(scope="module")
def client(folders: Path) -> Iterator[Client]:
    with serving(folders) as opened:
        yield opened


FLOOR_NUMBER, PREDICTION, EXPLORATION, BUILDINGS, REALISM = range(5)


class TestFolders:
    def test_each_is_recognised_by_its_files(self, folders):
        names = {name: path.name for name, path in find_folders([folders]).items()}
        assert names == {
            "a_floor": "a_floor",
            "b_predicted": "prediction.json",
            "c_explored": "exploration.json",
            "d_schools": "building-001.json",
            "e_realism": "realism.json",
        }

    def test_a_folder_may_have_a_floor_and_a_prediction(self, tmp_path):
        folder = write_folder(tmp_path / "building")
        write_prediction(folder)
        assert find_folders([folder]) == {"building": folder, "building (prediction)": folder / "prediction.json"}
        # Links lead to the same folder.
        (tmp_path / "link").symlink_to(folder)
        assert len(find_folders([folder, tmp_path / "link", folder / "prediction.json"])) == 2

    def test_a_folder_without_results_is_refused(self, tmp_path):
        with pytest.raises(OptionError, match="has no floor"):
            find_folders([tmp_path])


class TestServer:
    def test_the_gallery_has_all(self, client):
        maps = client.get("api/maps").json["maps"]
        assert [entry.get("kind") for entry in maps] == [None, "prediction", "exploration", "generated", "realism"]
        assert maps[PREDICTION]["facts"] == [
            "prediction",
            "2 rooms known",
            "1 open end",
            "1–4 rooms expected",
            "office",
        ]
        assert maps[EXPLORATION]["facts"] == ["exploration", "2 steps", "100 % of 30 m²", "10 m", "done"]
        assert maps[BUILDINGS]["facts"] == ["generated", "3 buildings", "3 to 5 rooms", "school"]
        assert maps[REALISM]["facts"] == ["realism", "3 floors", "scores 0.20 to 0.90", "1 reference floors"]

    def test_a_prediction_has_its_ends_over_the_known_floor(self, client):
        state = client.get(f"api/maps/{PREDICTION}").json
        assert (state["kind"], state["writable"]) == ("prediction", False)
        assert [each["properties"]["room"] for each in state["floor"]["features"][:3]] == [1, 2, 3]
        (end,) = state["prediction"]["ends"]
        assert (end["room"], end["labels"]) == (2, {"KITCHEN": 0.6, "OFFICE": 0.3})
        # The middle of room 2, which is 4 m x 3 m from (4.2, 2): the circle may lie anywhere along its length.
        x, y = end["position"]
        assert y == pytest.approx(3.5, abs=0.1)
        assert 5.6 <= x <= 6.8
        assert {tuple(point) for point in end["outline"][0]} == {(4.2, 2), (4.2, 5), (8.2, 2), (8.2, 5)}

    def test_sampled_rooms_lie_off_the_known_floor(self, client):
        part = client.get(f"api/maps/{PREDICTION}/parts/0").json
        behind, further = part["nodes"]
        assert (behind["label"], behind["door"], further["label"]) == ("KITCHEN", "2", "STORAGE")
        assert further["radius"] == pytest.approx(math.sqrt(8 / math.pi))
        shape = box(0, 0, 8.2, 5)
        assert Point(further["position"]).distance(shape) >= further["radius"]
        # From the corridor to the room behind the door, and from there on.
        assert len(part["edges"]) == 2
        assert client.get(f"api/maps/{PREDICTION}/parts/1").json["nodes"][0]["label"] == "OFFICE"

    def test_a_step_has_the_map_and_the_floor_of_its_time(self, client):
        state = client.get(f"api/maps/{EXPLORATION}").json
        assert [step["distance"] for step in state["steps"]] == [5, 10]
        assert len([each for each in state["floor"]["features"] if each["properties"]["class"] == "room"]) == 3
        first = client.get(f"api/maps/{EXPLORATION}/parts/0").json
        assert [each["properties"]["room"] for each in first["floor"]["features"]] == [1]
        assert (first["tracks"], state["tracks"]) == ([[[1, 1, 0]]], [[[1, 1, 0], [2, 1, 0]]])
        # Rows of cells that are free: 10 at the first step, 20 at the second.
        for part, rows in ((first, 10), (state, 20)):
            with Image.open(BytesIO(client.get(part["background"]["url"]).body)) as picture:
                grey = np.array(picture)
            assert np.count_nonzero((grey == 255).all(axis=1)) == rows
        assert first["background"]["corners"] == state["background"]["corners"]

    def test_a_generated_building_is_a_layout_with_labels(self, client):
        state = client.get(f"api/maps/{BUILDINGS}").json
        assert [item["name"] for item in state["items"]] == ["building-001", "building-002", "building-003"]
        figures = {"rooms": 5, "corridors": 1, "doors": 4, "labels": 2, "area": None}
        assert state["items"][1]["figures"] == figures
        part = client.get(f"api/maps/{BUILDINGS}/parts/1").json
        assert [node["label"] for node in part["nodes"]] == ["CORRIDOR", *["CLASSROOM"] * 4]
        assert [node["corridor"] for node in part["nodes"]] == [True, *[False] * 4]
        assert sorted(map(sorted, part["edges"])) == [[0, 1], [0, 2], [0, 3], [0, 4]]
        assert len({tuple(node["position"]) for node in part["nodes"]}) == 5

    def test_realism_has_figures_and_reasons_for_each_floor(self, client):
        state = client.get(f"api/maps/{REALISM}").json
        assert list(state["columns"]) == ["score", "typicality", "likeness", "rooms"]
        assert state["items"][1]["figures"] == {"score": 0.9, "typicality": 0.9, "likeness": 0.5, "rooms": 2}
        assert state["items"][1]["texts"] == ["typicality 0.9", "most like a.xml", "the floor is small"]
        assert len(client.get(f"api/maps/{REALISM}/parts/1").json["floor"]["features"]) == 3

    @pytest.mark.parametrize("number", [PREDICTION, EXPLORATION, BUILDINGS, REALISM])
    def test_results_are_not_changed(self, client, folders, number):
        before = {file: file.read_bytes() for file in folders.rglob("*") if file.is_file()}
        corrections = [{"kind": "type", "building_type": "school"}]
        body = {"version": client.version(number), "corrections": corrections}
        for path, more in (("save", {}), ("apply", {}), ("edit", {"edit": corrections[0]})):
            answer = client.post(f"api/maps/{number}/{path}", {**body, **more})
            assert answer.status == 422
            assert "no corrections" in answer.error
        assert {file: file.read_bytes() for file in folders.rglob("*") if file.is_file()} == before

    @pytest.mark.parametrize(
        "path",
        ["1/parts/2", "1/parts/-1", "0/parts/0", "2/parts/9/background.png", "3/parts/0/background.png", "9/parts/0"],
    )
    def test_other_parts_do_not_exist(self, client, path):
        assert client.get(f"api/maps/{path}").status == 404

    def test_a_part_needs_the_token(self, client):
        assert client.ask("GET", "/other/api/maps/1/parts/0").status == 404

    def test_new_results_are_a_new_version(self, tmp_path):
        folder = write_exploration(tmp_path / "run", steps=(1,))
        with serving(folder) as client:
            version = client.version()
            assert len(client.get("api/maps/0").json["steps"]) == 1
            write_exploration(folder, steps=(1, 2, 3))
            assert client.version() != version
            assert len(client.get("api/maps/0").json["steps"]) == 3


class TestBadInput:
    @pytest.mark.parametrize("name", ["../secret", "/etc/passwd", "step-001/../../secret", "step-001\n"])
    def test_a_step_is_never_outside_its_folder(self, tmp_path, name):
        folder = write_exploration(tmp_path / "run")
        shutil.copy(folder / "step-001.geojson", tmp_path / "secret.geojson")
        shutil.copy(folder / "step-001.npz", tmp_path / "secret.npz")
        content = json.loads((folder / "exploration.json").read_text())
        content["steps"][0]["name"] = name
        (folder / "exploration.json").write_text(json.dumps(content))
        with serving(folder, write_folder(tmp_path / "building")) as client:
            entry = client.get("api/maps").json["maps"][0]
            assert "steps[0].name" in entry["error"]
            assert client.get("api/maps/0/parts/0").status == 422

    def test_damaged_results_are_an_entry_with_the_fault(self, tmp_path):
        write_prediction(tmp_path / "a", samples=0)
        write_exploration(tmp_path / "b", steps=())
        write_realism(tmp_path / "c", {})
        (write_buildings(tmp_path / "d") / "building-002.json").write_text("{}")
        (write_exploration(tmp_path / "e") / "exploration.json").write_text('{"format": "pianta exploration"')
        (write_prediction(tmp_path / "f") / "prediction.json").write_text(
            (tmp_path / "f" / "prediction.json").read_text().replace('"1.0"', '"2.0"')
        )
        with serving(tmp_path) as client:
            errors = [entry["error"] for entry in client.get("api/maps").json["maps"]]
        for error, fragment in zip(
            errors,
            ("samples", "--steps", "floors", "building-002.json", "exploration.json", "update pianta"),
            strict=True,
        ):
            assert fragment in error
            assert "\n" not in error

    def test_a_step_that_is_gone(self, tmp_path):
        folder = write_exploration(tmp_path / "run")
        with serving(folder) as client:
            (folder / "step-001.npz").unlink()
            answer = client.get("api/maps/0/parts/0")
            assert answer.status >= 400
            assert "step-001.npz" in answer.error


class TestPositions:
    def test_nothing_overlaps(self):
        graph = nx.random_labeled_tree(60, seed=1)
        nx.set_node_attributes(graph, {node: 4.0 + node for node in graph}, "area")
        shape = box(-5, -5, 5, 5)
        positions = place_unknown(graph, {0: (0.0, 0.0)}, shape)
        assert positions.keys() == set(graph)
        unknown = [node for node in graph if node != 0]
        for node in unknown:
            assert Point(positions[node]).distance(shape) >= radius_of(graph, node)
            for other in unknown:
                gap = math.dist(positions[node], positions[other]) - radius_of(graph, node) - radius_of(graph, other)
                assert node == other or gap > 0

    def test_a_room_goes_outwards(self):
        graph = nx.path_graph(2)
        # From the middle of the right side of a square around (0, 0): to the right.
        x, y = place_unknown(graph, {0: (5.0, 0.0)}, box(-5, -5, 5, 5))[1]
        assert x > 5
        assert y == pytest.approx(0)


def open_tab(browser: Any, client: Client, number: int) -> Any:
    return opened_tab(browser, client, f"#map={number}")


def texts_on_map(tab: Tab) -> list[str]:
    return [text for text in tab.page.locator(".mark-text").all_text_contents() if text]


class TestPage:
    def test_the_gallery_opens_each(self, browser, client):
        with opened_tab(browser, client) as tab:
            tab.wait_until("document.querySelectorAll('.card svg').length === 5")
            tab.page.click(".card:has-text('d_schools')")
            tab.page.wait_for_selector("#items tbody tr")
            tab.page.click("#to-gallery")
            tab.page.click(".card:has-text('c_explored')")
            tab.page.wait_for_selector("#timeline")
            tab.page.click("#to-gallery")
            tab.page.click(".card:has-text('a_floor')")
            tab.wait_for_floor()
            assert tab.page.locator("#timeline").count() == 0
            assert tab.page.is_visible("#history")

    def test_a_prediction_is_dashed_and_hatched_and_switches(self, browser, client):
        with open_tab(browser, client, PREDICTION) as tab:
            tab.page.wait_for_selector("path.sample-room")
            # The end, and two rooms of the sample.
            assert (tab.page.locator("path.end").count(), tab.page.locator("path.sample-room").count()) == (1, 2)
            for shape in ("path.end", "path.sample-room"):
                look = tab.page.locator(shape).first.evaluate(
                    "each => [getComputedStyle(each).strokeDasharray, each.getAttribute('fill')]"
                )
                assert look[0] != "none"
                assert look[1].startswith("url(#hatch-")
            assert "KITCHEN? 60 %" in texts_on_map(tab)
            tab.wait_for_text("#ends", "KITCHEN 60 %")
            tab.page.uncheck("#layers [name=ends]")
            assert tab.page.locator("path.end").count() == 0
            tab.page.uncheck("#layers [name=sample]")
            assert tab.page.locator("path.sample-room").count() == 0
            tab.page.check("#layers [name=ends]")
            assert tab.page.locator("path.end").count() == 1
            assert not tab.page.is_visible("#history")
            assert not tab.page.is_visible("#tools")

    def test_hover_has_the_probabilities(self, browser, client):
        with open_tab(browser, client, PREDICTION) as tab:
            tab.page.wait_for_selector("path.sample-room")
            tab.page.uncheck("#layers [name=sample]")
            tab.page.mouse.move(*tab.pixel(4.6, 2.4))
            tab.wait_for_text("#tip", "Predicted. Behind the door of 3 to 2:\nKITCHEN 60 %, OFFICE 30 %")
            # Room 1 is known.
            tab.page.mouse.move(*tab.pixel(0.5, 2.5))
            tab.wait_for_text("#tip", "Room 1")
            assert "Predicted" not in tab.page.text_content("#tip")

    def test_samples_step(self, browser, client):
        with open_tab(browser, client, PREDICTION) as tab:
            tab.wait_for_text("#timeline", "Sample 1 of 2")
            tab.page.focus("#timeline input")
            tab.page.keyboard.press("ArrowRight")
            tab.wait_for_text("#timeline", "Sample 2 of 2")
            tab.wait_until("pianta.results.nodes[0]?.label === 'OFFICE'")
            x, y = client.get(f"api/maps/{PREDICTION}/parts/1").json["nodes"][0]["position"]
            tab.page.mouse.move(*tab.pixel(x, y))
            tab.wait_for_text("#tip", "Predicted, sample 2: OFFICE")

    def test_a_prediction_without_outlines_is_graphs(self, browser, tmp_path):
        folder = write_prediction(tmp_path / "predicted", outlines=False)
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.page.wait_for_selector("#items tbody tr svg")
            # Rooms 1 and 3 are known, the others predicted.
            tab.page.wait_for_selector("path.graph-room")
            assert tab.page.locator("path.graph-room").count() == 4
            assert tab.page.locator("path.graph-room.sample-room").count() == 2

    def test_the_timeline_keeps_the_view(self, browser, client):
        with open_tab(browser, client, EXPLORATION) as tab:
            tab.wait_for_floor()
            tab.wait_for_text("#timeline", "Step 2 of 2: 2:00 min, 10.0 m driven, 100 % seen")
            tab.page.evaluate("pianta.floorMap.map.setView([2, 3], 6.5, {animate: false})")
            tab.page.evaluate("document.activeElement.blur()")
            tab.page.keyboard.press("ArrowLeft")
            tab.wait_for_ids(1)
            tab.wait_for_text("#timeline", "Step 1 of 2: 1:00 min, 5.0 m driven, 33 % seen")
            view = tab.page.evaluate("[pianta.floorMap.map.getZoom(), pianta.floorMap.map.getCenter().lat]")
            assert view == pytest.approx([6.5, 2], abs=0.02)
            tab.page.wait_for_selector("img.background.loaded")
            assert tab.page.locator("path.track-robot").count() == 1
            # The files are looked at each second, and are the same: the step stays.
            tab.page.wait_for_timeout(1500)
            assert tab.ids() == [1]

    def test_the_timeline_plays_and_pauses(self, browser, client):
        with open_tab(browser, client, EXPLORATION) as tab:
            tab.wait_for_floor()
            tab.page.click("#timeline button")
            assert tab.page.text_content("#timeline button") == "Pause"
            # From the end it starts again.
            tab.wait_for_ids(1)
            tab.wait_for_ids(1, 2, 3)
            tab.wait_for_text("#timeline button", "Play")
            tab.page.click("#timeline button")
            tab.wait_for_ids(1)
            tab.page.click("#timeline button")
            tab.page.wait_for_timeout(1200)
            assert tab.ids() == [1]

    def test_a_longer_run_is_shown_at_once(self, browser, tmp_path):
        folder = write_exploration(tmp_path / "run", steps=(1,))
        with serving(folder) as client, opened_tab(browser, client) as tab:
            tab.wait_for_text("#timeline", "Step 1 of 1")
            write_exploration(folder, steps=(1, 2, 3))
            tab.wait_for_text("#timeline", "Step 3 of 3")
            assert tab.page.locator("#timeline").count() == 1

    def test_buildings_sort_by_their_figures(self, browser, client):
        with open_tab(browser, client, BUILDINGS) as tab:
            tab.page.wait_for_selector("#items tbody tr")
            names = tab.page.locator("#items tbody td:nth-child(2)")
            assert names.all_text_contents() == ["building-001", "building-002", "building-003"]
            tab.page.click("#items th button[value=rooms]")
            # 3, 5 and 4 rooms, the largest first.
            assert names.all_text_contents() == ["building-002", "building-003", "building-001"]
            tab.page.click("#items th button[value=rooms]")
            assert names.all_text_contents() == ["building-001", "building-003", "building-002"]
            # No building has areas.
            assert tab.page.locator("#items th button[value=area]").count() == 0

    def test_a_building_is_drawn_with_its_labels(self, browser, client):
        with open_tab(browser, client, BUILDINGS) as tab:
            tab.page.focus("#items tbody tr")
            tab.page.keyboard.press("ArrowDown")
            tab.wait_for_text(".item h2", "building-002")
            tab.wait_until("document.querySelectorAll('path.graph-room').length === 5")
            tab.wait_until("document.querySelectorAll('path.graph-edge').length === 1")
            assert sorted(texts_on_map(tab)) == ["0\nCORRIDOR", *[f"{node}\nCLASSROOM" for node in range(1, 5)]]

    def test_realism_sorts_and_explains(self, browser, client):
        with open_tab(browser, client, REALISM) as tab:
            tab.page.click("#items th button[value=score]")
            tab.page.wait_for_selector("#items tbody tr")
            names = tab.page.locator("#items tbody td:nth-child(2)")
            assert names.all_text_contents() == ["two.xml", "ten.xml", "one.xml"]
            tab.page.click("#items tbody tr:has-text('ten.xml')")
            tab.wait_for_text("#item-texts", "typicality 0.5")
            tab.wait_for_text("#item-texts", "the floor is small")
            tab.wait_until("document.querySelectorAll('path.graph-room').length === 2")

    def test_names_are_text(self, browser, tmp_path):
        write_prediction(
            tmp_path / "a",
            building_type=HOSTILE,
            open_ends=[
                {"kind": "door", "room": HOSTILE, "near": HOSTILE, "labels": {HOSTILE: 0.5}, "leads_on": 0.5,
                 "rooms": {"mean": 1, "low": 1, "high": 1}, "area": None}
            ],
        )  # fmt: skip
        write_exploration(tmp_path / "b", world=HOSTILE, policy=HOSTILE, outcome=HOSTILE)
        write_buildings(tmp_path / "c", label=HOSTILE)
        write_realism(tmp_path / "d", {HOSTILE: 0.5})
        with serving(tmp_path) as client:
            with opened_tab(browser, client) as tab:
                tab.wait_until("document.querySelectorAll('.card svg').length === 4")
                assert tab.page.locator("main img[src=x]").count() == 0
            for number, selector in enumerate(("#ends", "#about-part", "#items", ".item h2")):
                with open_tab(browser, client, number) as tab:
                    tab.page.wait_for_selector(selector)
                    tab.page.wait_for_timeout(500)
                    assert tab.page.locator("img[src=x]").count() == 0
                    assert tab.page.title() != "1"

    def test_the_report_has_them_too(self, browser, folders, tmp_path):
        report = tmp_path / "report.html"
        save_report(find_folders([folders]), report)
        context = browser.new_context(viewport={"width": 1200, "height": 800})
        tab = Tab(context, f"file://{report}")
        tab.wait_until("document.querySelectorAll('.card svg').length === 5")
        tab.page.click(".card:has-text('c_explored')")
        tab.wait_for_ids(1, 2, 3)
        tab.page.keyboard.press("ArrowLeft")
        tab.wait_for_ids(1)
        tab.page.wait_for_selector("img.background.loaded")
        tab.page.click("#to-gallery")
        tab.page.click(".card:has-text('b_predicted')")
        tab.page.wait_for_selector("path.sample-room")
        tab.page.click("#to-gallery")
        tab.page.click(".card:has-text('d_schools')")
        tab.page.wait_for_selector("path.graph-room")
        assert tab.errors == []
        assert {address.split(":")[0] for address in tab.addresses} <= {"file", "data"}
        context.close()
