"""The server of `pianta view`, as a browser speaks to it."""

import json
import os
import shutil
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from hashlib import sha256
from io import BytesIO
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from shapely import box

from pianta.errors import PiantaError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.io.floors import read_floor
from pianta.reading.saved_reading import SavedReading
from pianta.view import sessions
from pianta.view.guard import MAX_BODY, MAX_DRAINED
from pianta.view.server import STATIC
from tests.command_line import list_files, run_pianta
from tests.served_floors import FLOOR, TOKEN, Answer, Client, serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the server")

MERGE: dict[str, Any] = {"kind": "merge", "rooms": [1, 2]}


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("folders") / "building")


@pytest.fixture(scope="module")
def reader(original) -> Iterator[Client]:
    """A server whose folder no test changes."""
    with serving(original) as client:
        yield client


@pytest.fixture
def folder(original, tmp_path) -> Path:
    return Path(shutil.copytree(original, tmp_path / "building"))


@pytest.fixture
def client(folder) -> Iterator[Client]:
    with serving(folder) as client:
        yield client


def rooms_of(answer: Answer) -> dict[int, Any]:
    """Properties of the rooms of a state by id."""
    assert answer.status == 200, answer.body
    features = [each["properties"] for each in answer.json["floor"]["features"]]
    return {each["room"]: each for each in features if each["class"] == "room"}


def save(client: Client, corrections: list[Any], version: str | None = None) -> Answer:
    body = {"version": version or client.version(), "corrections": corrections}
    return client.post("api/maps/0/save", body)


class TestState:
    def test_the_gallery_lists_a_floor(self, reader):
        (entry,) = reader.get("api/maps").json["maps"]
        assert entry.pop("area") == pytest.approx(12 + 12 + 8.2 * 1.8)
        assert entry == {"map": 0, "name": "building", "rooms": 3, "corrections": 0, "type": "office"}

    def test_rooms_have_what_the_page_shows(self, reader):
        rooms = rooms_of(reader.get("api/maps/0"))
        assert [(rooms[n]["area"], rooms[n]["doors"], rooms[n]["neighbours"]) for n in (1, 2)] == [
            (pytest.approx(12), 1, [3]),
            (pytest.approx(12), 2, [3]),
        ]
        assert (rooms[3]["doors"], rooms[3]["neighbours"]) == (2, [1, 2])
        # The colour of OFFICE in the schema of offices.
        assert rooms[1]["colour"] == "#1bddf2"
        x, y = rooms[2]["centre"]
        assert 5.6 < x < 6.8
        assert y == pytest.approx(3.5, abs=0.1)

    def test_the_state_is_that_of_the_folder(self, reader, original):
        state = reader.get("api/maps/0").json
        written = json.loads((original / "floor.geojson").read_text(encoding="utf-8"))
        assert [each["geometry"] for each in state["floor"]["features"]] == [
            each["geometry"] for each in written["features"]
        ]
        assert (state["name"], state["version"]) == ("building", reader.version())
        assert (state["writable"], state["problem"], state["has_map"]) == (True, None, True)
        assert (state["building_type"], state["corrections"]) == ({"office": 0.9, "school": 0.1}, [])
        assert state["labels"][0]["schema"] == "office"
        assert {"label": "GYM", "schema": "school", "colour": "#a81e1e"} in state["labels"]

    def test_the_graph_goes_through_the_doors_between_rooms(self, reader):
        graph = reader.get("api/maps/0").json["graph"]
        assert [path[1] for path in graph] == [[1.5, 1.9], [6.5, 1.9]]

    def test_the_background_is_the_map(self, reader):
        background = reader.get("api/maps/0").json["background"]
        np.testing.assert_allclose(background["corners"], [[-0.3, 5.7], [8.7, 5.7], [-0.3, -0.3]])
        answer = reader.get(background["url"])
        assert answer.headers["content-type"] == "image/png"
        cells = np.asarray(Image.open(BytesIO(answer.body)))
        assert cells.shape == (60, 90)
        assert [set(row) for row in cells[:3].tolist()] == [{255}, {0}, {205}]

    def test_the_background_of_a_plan_is_its_sheet(self, folder):
        sheet = np.full((60, 90, 3), 250, np.uint8)
        sheet[5, 7] = 10, 20, 30
        Image.fromarray(sheet).save(folder / "paper.png")
        with serving(folder) as client:
            picture = Image.open(BytesIO(client.get("api/maps/0/background.png").body))
            np.testing.assert_array_equal(np.asarray(picture), sheet)

    def test_a_turned_map_has_turned_corners(self, folder):
        GridMap(np.zeros((10, 20), np.int8), 0.1, (1, 2, pi / 2)).save(folder / "grid.npz")
        with serving(folder) as client:
            corners = client.get("api/maps/0").json["background"]["corners"]
        # A quarter turn: to the right is north, and up is west.
        np.testing.assert_allclose(corners, [[0, 2], [0, 4], [1, 2]], atol=1e-12)

    def test_rooms_have_their_function_and_its_colour(self, tmp_path):
        labels = ("OFFICE", "CORRIDOR", "STAIRS", "KITCHEN", "ROOM", None)
        rooms = tuple(Room(number, box(4 * number, 0, 4 * number + 3, 3), label)
                      for number, label in enumerate(labels, start=1))  # fmt: skip
        with serving(write_folder(tmp_path / "labelled", Floor(rooms, last_id=6))) as client:
            read = rooms_of(client.get("api/maps/0")).values()
        # Schemas disagree on OFFICE; in that of offices it is functional.
        functions = ["FUNCTIONAL", "CONNECTION", "ENTRANCE", "SERVICE", "FUNCTIONAL", "UNKNOWN"]
        assert [room["function"] for room in read] == functions
        assert [room["colour"] for room in read] == [
            "#1bddf2", "#f28705", "#2f3ea8", "#8c8c8b", "#1bddf2", "#ffffff"]  # fmt: skip

    def test_rooms_without_labels_differ_from_their_neighbours_in_colour(self, tmp_path):
        rooms = tuple(Room(room.id, room.polygon) for room in FLOOR)
        with serving(write_folder(tmp_path / "plain", replace(FLOOR, rooms=rooms))) as client:
            colours = [room["colour"] for room in rooms_of(client.get("api/maps/0")).values()]
        assert len({*colours}) == 3

    def test_the_page_and_its_files(self, reader):
        page = reader.get("")
        assert page.status == 200
        assert page.headers["content-type"].startswith("text/html")
        assert reader.get("static/leaflet.js").body == (STATIC / "leaflet.js").read_bytes()

    def test_leaflet_is_as_it_was_published(self):
        lines = (STATIC / "README.md").read_text(encoding="utf-8").splitlines()
        sums = dict(line.replace("`", "").strip("| ").split(" | ") for line in lines if line.startswith("| `"))
        assert sums.keys() == {"leaflet.js", "leaflet.css", "LEAFLET_LICENSE"}
        assert {name: sha256((STATIC / name).read_bytes()).hexdigest() for name in sums} == sums


class TestEdits:
    def test_an_edit_is_answered_and_not_saved(self, client, folder):
        before = list_files(folder)
        answer = client.edit([], **MERGE)
        assert [*rooms_of(answer)] == [1, 3]
        assert rooms_of(answer)[1]["area"] == pytest.approx(8.2 * 3)
        (correction,) = answer.json["corrections"]
        assert (correction["kind"], correction["problem"]) == ("merge", None)
        assert correction["text"].startswith("merge the rooms at ")
        assert list_files(folder) == before

    def test_edits_follow_each_other_and_are_undone(self, client):
        merged = client.edit([], **MERGE).json["corrections"]
        named = client.edit(merged, kind="name", room=1, name="Café")
        assert rooms_of(named)[1]["name"] == "Café"
        body = {"version": client.version(), "corrections": merged}
        assert rooms_of(client.post("api/maps/0/apply", body))[1]["name"] == "Bar"
        undone = client.post("api/maps/0/apply", {**body, "corrections": []})
        assert [*rooms_of(undone)] == [1, 2, 3]
        assert undone.json["corrections"] == []

    def test_the_order_of_a_list_matters(self, client):
        """A name before the merge names room 1 alone, and a list that was never made by edits is applied too."""
        named = client.edit([], kind="name", room=1, name="A").json["corrections"]
        both = client.edit(named, **MERGE).json["corrections"]
        turned = client.post("api/maps/0/apply", {"version": client.version(), "corrections": [*reversed(both)]})
        assert [each["kind"] for each in turned.json["corrections"]] == ["merge", "name"]
        assert [*rooms_of(turned)] == [1, 3]

    @pytest.mark.parametrize(
        ("edit", "expected"),
        [
            ({"kind": "split", "room": 3, "line": [[4, -1], [4, 3]]}, "split"),
            ({"kind": "draw room", "outline": [[0, 6], [3, 6], [3, 8], [0, 8]]}, "draw room"),
            ({"kind": "delete room", "room": 1}, "delete room"),
            ({"kind": "outside", "room": 2}, "outside"),
            ({"kind": "outside", "outline": [[4.1, 1.9], [8.3, 1.9], [8.3, 5.1], [4.1, 5.1]]}, "outside"),
            ({"kind": "draw door", "line": [[4.1, 3], [4.1, 4]], "door": "opening"}, "draw door"),
            ({"kind": "move door", "position": [1.5, 1.9], "line": [[2, 1.9], [3, 1.9]]}, "move door"),
            ({"kind": "delete door", "position": [1.5, 1.9]}, "delete door"),
            ({"kind": "change door", "position": [1.5, 1.9], "door": "opening"}, "change door"),
            ({"kind": "label", "room": 1, "label": "KITCHEN"}, "label"),
            ({"kind": "label", "room": 1, "label": None}, "label"),
            ({"kind": "name", "room": 2, "name": None}, "name"),
            ({"kind": "number", "room": 2, "number": "204"}, "number"),
            ({"kind": "type", "building_type": "school"}, "type"),
            ({"kind": "length", "line": [[0, 2], [4, 2]], "length": 5.2}, "length"),
            ({"kind": "area", "room": 1, "area": 20.9}, "area"),
        ],
        ids=lambda value: value if isinstance(value, str) else "",
    )
    def test_every_kind(self, reader, edit, expected):
        answer = reader.edit([], **edit)
        assert answer.status == 200, answer.body
        (correction,) = answer.json["corrections"]
        assert (correction["kind"], correction["problem"]) == (expected, None)

    def test_a_correction_of_the_scale_moves_the_background(self, reader):
        answer = reader.edit([], kind="length", line=[[0, 2], [4, 2]], length=8)
        np.testing.assert_allclose(answer.json["background"]["corners"], [[-0.6, 11.4], [17.4, 11.4], [-0.6, -0.6]])
        assert rooms_of(answer)[1]["area"] == pytest.approx(48)

    @pytest.mark.parametrize(
        ("edit", "message"),
        [
            ({"kind": "split", "room": 3, "line": [[20, 0], [20, 5]]}, "the line does not divide room 3"),
            ({"kind": "merge", "rooms": [1, 99]}, "there is no room 99"),
            ({"kind": "merge", "rooms": [1]}, "cannot be merged"),
            ({"kind": "merge", "rooms": "12"}, "rooms"),
            ({"kind": "merge", "rooms": [True, 1]}, "rooms"),
            ({"kind": "delete room", "room": "1"}, "room"),
            ({"kind": "label", "room": 1, "label": "KITCHN"}, "KITCHEN"),
            ({"kind": "label", "room": 1, "label": "OFFICE"}, "the floor is so already"),
            ({"kind": "name", "room": 1, "name": "x" * 201}, "name"),
            ({"kind": "number", "room": 1, "number": "x" * 201}, "number"),
            ({"kind": "number", "room": 1, "number": 204}, "number"),
            ({"kind": "name", "room": 1, "name": "A", "more": 1}, "more"),
            ({"kind": "delete door", "position": [50, 50]}, "no door is within"),
            ({"kind": "area", "room": 1, "area": -4}, "area"),
            ({"kind": "length", "line": [[0, 0], [1e300, 0]], "length": 4}, "line"),
            ({"kind": "dance", "room": 1}, "kind"),
            ({"kind": "dance"}, "kind"),
            ({}, "kind"),
        ],
        ids=str,
    )
    def test_an_edit_that_does_not_fit_is_explained(self, reader, edit, message):
        answer = reader.edit([], **edit)
        assert answer.status == 422
        assert message in answer.error

    def test_a_damaged_list_is_refused_with_the_number(self, reader):
        merged = reader.edit([], **MERGE).json["corrections"]
        answer = reader.edit([*merged, {"kind": "merge", "positions": 3}], **MERGE)
        assert (answer.status, answer.error[:13]) == (422, "correction 2:")

    def test_corrections_that_do_not_fit_are_kept_with_their_problem(self, reader):
        lost = {"kind": "name", "position": [50.0, 50.0], "name": "A"}
        body = {"version": reader.version(), "corrections": [lost]}
        (correction,) = reader.post("api/maps/0/apply", body).json["corrections"]
        assert "there is no room at (50.00, 50.00)" in correction["problem"]


class TestSaving:
    def test_saved_corrections_are_those_of_the_command(self, client, folder):
        corrections = client.edit([], **MERGE).json["corrections"]
        version = client.version()
        state = save(client, corrections)
        assert [*rooms_of(state)] == [1, 3]
        assert state.json["version"] == client.version() != version
        assert [room.id for room in read_floor(folder / "floor.geojson")] == [1, 3]
        assert [room.id for room in read_floor(folder / "uncorrected.geojson")] == [1, 2, 3]
        assert "1. merge the rooms at" in run_pianta("correct", folder, "--list").out
        assert client.get("api/maps").json["maps"][0]["corrections"] == 1

    def test_another_server_reads_what_was_saved_and_takes_it_back(self, client, folder):
        corrections = client.edit([], **MERGE).json["corrections"]
        saved = save(client, corrections).json
        with serving(folder) as other:
            assert other.get("api/maps/0").json == saved
            assert [*rooms_of(save(other, []))] == [1, 2, 3]
        assert [room.id for room in read_floor(folder / "floor.geojson")] == [1, 2, 3]

    def test_files_that_have_changed_on_disk_are_not_replaced(self, client, folder):
        version = client.version()
        corrections = client.edit([], **MERGE).json["corrections"]
        assert run_pianta("correct", folder, "--name", "3", "Hall").code == 0
        files = list_files(folder)
        answer = save(client, corrections, version)
        assert answer.status == 409
        assert "have changed on disk" in answer.error
        assert list_files(folder) == files
        # Nothing of the page is lost: its list fits the new files too.
        newer = client.get("api/maps/0").json
        rooms = rooms_of(save(client, [*newer["corrections"], *corrections], newer["version"]))
        assert (rooms[3]["name"], [*rooms]) == ("Hall", [1, 3])

    def test_edits_of_the_version_before_go_on(self, client, folder):
        version = client.version()
        assert client.get("api/maps/0").status == 200
        assert run_pianta("correct", folder, "--name", "3", "Hall").code == 0
        body = {"version": version, "corrections": [], "edit": MERGE}
        rooms = rooms_of(client.post("api/maps/0/edit", body))
        assert (rooms[3]["name"], [*rooms]) == (None, [1, 3])

    def test_an_unknown_version_is_a_conflict(self, reader):
        answer = reader.post("api/maps/0/edit", {"version": "0" * 32, "corrections": [], "edit": MERGE})
        assert answer.status == 409

    def test_two_servers_that_save_at_once_do_not_lose_one_another(self, client, folder):
        with serving(folder) as other, ThreadPoolExecutor(2) as pool:
            version = client.version()
            lists = [
                each.edit([], kind="name", room=1, name=name).json["corrections"]
                for each, name in ((client, "A"), (other, "B"))
            ]
            answers = [*pool.map(lambda each, items: save(each, items, version), (client, other), lists)]
        assert sorted(answer.status for answer in answers) == [200, 409]
        name = "A" if answers[0].status == 200 else "B"
        assert read_floor(folder / "floor.geojson")[1].name == name

    def test_a_save_ends_when_the_browser_is_closed(self, client, folder):
        corrections = client.edit([], **MERGE).json["corrections"]
        body = json.dumps({"version": client.version(), "corrections": corrections}).encode()
        head = (
            f"POST /{TOKEN}/api/maps/0/save HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        with socket.create_connection(("127.0.0.1", client.port)) as browser:
            browser.sendall(head.encode() + body)
            time.sleep(0.05)
        until = time.monotonic() + 20
        while not (folder / "corrections.json").exists() and time.monotonic() < until:
            time.sleep(0.05)
        assert [*rooms_of(client.get("api/maps/0"))] == [1, 3]

    def test_half_a_request_changes_nothing(self, client, folder):
        files = list_files(folder)
        head = (
            f"POST /{TOKEN}/api/maps/0/save HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n"
            "Content-Type: application/json\r\nContent-Length: 500\r\n\r\n"
        )
        with socket.create_connection(("127.0.0.1", client.port)) as browser:
            browser.sendall(head.encode() + b'{"version": ')
        assert client.get("api/maps/0").status == 200
        assert list_files(folder) == files

    def test_a_folder_that_may_not_be_written_is_shown_and_not_saved(self, client, folder, monkeypatch):
        corrections = client.edit([], **MERGE).json["corrections"]
        files = list_files(folder)
        monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
        state = client.get("api/maps/0").json
        assert state["writable"] is False
        answer = save(client, corrections)
        assert answer.status == 423
        assert answer.error == state["problem"]
        assert "may not be written" in answer.error
        assert list_files(folder) == files

    def test_a_full_disk_loses_nothing(self, client, folder, monkeypatch):
        corrections = client.edit([], **MERGE).json["corrections"]
        files = list_files(folder)

        def fail(*_: object, **__: object) -> None:
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(GridMap, "save", fail)
            answer = save(client, corrections)
        assert answer.status == 423
        assert "No space left on device" in answer.error
        assert list_files(folder) == files
        assert [*rooms_of(save(client, corrections))] == [1, 3]

    def test_a_folder_of_an_older_pianta_is_shown_without_its_map(self, folder):
        (folder / "grid.npz").unlink()
        with serving(folder) as client:
            state = client.get("api/maps/0").json
            assert (state["has_map"], state["background"], state["writable"]) == (False, None, False)
            assert client.get("api/maps/0/background.png").status == 404
            edited = client.edit([], **MERGE)
            assert [*rooms_of(edited)] == [1, 3]
            answer = save(client, edited.json["corrections"])
        assert answer.status == 423
        assert "has no grid.npz, read the map again" in answer.error
        assert not (folder / "corrections.json").exists()


class TestFaults:
    def test_a_folder_that_is_gone(self, client, folder):
        corrections = client.edit([], **MERGE).json["corrections"]
        version = client.version()
        shutil.move(folder, folder.with_name("elsewhere"))
        for answer in (
            client.get("api/maps/0"),
            client.get("api/maps/0/version"),
            client.get("api/maps/0/background.png"),
            save(client, corrections, version),
        ):
            assert answer.status == 404
            assert "building" in answer.error
        (entry,) = client.get("api/maps").json["maps"]
        assert "building" in entry["error"]
        # The page keeps its list, and saves it when the folder is back.
        shutil.move(folder.with_name("elsewhere"), folder)
        assert [*rooms_of(save(client, corrections, version))] == [1, 3]

    @pytest.mark.parametrize("content", [b"", b"{", b'{"format": "pianta corrections", "version": "9.0"}'])
    def test_damaged_corrections(self, client, folder, content):
        corrections = client.edit([], **MERGE).json["corrections"]
        version = client.version()
        (folder / "corrections.json").write_bytes(content)
        files = list_files(folder)
        assert client.get("api/maps/0").status == 422
        assert "corrections.json" in client.get("api/maps/0").error
        assert "corrections.json" in client.get("api/maps").json["maps"][0]["error"]
        assert save(client, corrections, version).status == 409
        assert save(client, corrections).status in {409, 422}
        assert list_files(folder) == files

    def test_a_folder_that_is_always_being_written(self, client, monkeypatch):
        numbers = iter(range(1000))
        monkeypatch.setattr(sessions.Session, "version", lambda self: str(next(numbers)))
        answer = client.get("api/maps/0")
        assert (answer.status, "being written" in answer.error) == (409, True)

    @pytest.mark.parametrize(
        "body",
        [
            b"",
            b"{",
            b"[]",
            b"null",
            b'{"version": 3, "corrections": [], "edit": {}}',
            b'{"version": "a", "corrections": [3], "edit": {}}',
            b'{"version": "a", "corrections": [], "edit": {}, "more": 1}',
            b"\xff\xfe",
            b"[" * 100_000,
        ],
    )
    def test_a_damaged_body(self, reader, body):
        answer = reader.post("api/maps/0/edit", body)
        assert (answer.status, len(answer.error) < 500) == (400, True)

    def test_a_body_of_a_form_is_refused(self, reader):
        body = json.dumps({"version": reader.version(), "corrections": []}).encode()
        answer = reader.post("api/maps/0/save", body, **{"Content-Type": "text/plain"})
        assert answer.status == 400

    def test_a_long_name_in_a_damaged_body_is_not_repeated(self, reader):
        body = {"version": reader.version(), "corrections": [], "k" * 2**20: 1}
        answer = reader.post("api/maps/0/apply", body)
        assert (answer.status, len(answer.error) < 500) == (400, True)

    def test_a_scale_that_cannot_be(self, reader):
        for length in (1e-300, 1e15):
            answer = reader.edit([], kind="length", line=[[0, 2], [1, 2]], length=length)
            assert (answer.status, "multiplies all lengths" in answer.error) == (422, True)

    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes")
    @pytest.mark.parametrize("name", ["corrections.json", "grid.npz"])
    @pytest.mark.parametrize("is_pipe", [True, False], ids=["pipe", "device"])
    def test_a_file_that_does_not_end_is_refused(self, client, folder, name, is_pipe):
        (folder / name).unlink(missing_ok=True)
        if is_pipe:
            os.mkfifo(folder / name)
        else:
            (folder / name).symlink_to("/dev/zero")
        answer = client.get("api/maps/0")
        assert (answer.status, name in answer.error, "regular file" in answer.error) == (422, True, True)

    def test_numbers_that_json_has_not(self, reader):
        answer = reader.post(
            "api/maps/0/edit",
            f'{{"version": "{reader.version()}", "corrections": [], '
            '"edit": {"kind": "length", "line": [[0, 0], [NaN, 1]], "length": Infinity}}'.encode(),
        )
        assert answer.status == 422

    @pytest.mark.parametrize(
        "path",
        [
            "api/maps/1",
            "api/maps/-1",
            "api/maps/x",
            "api/maps/0/nothing",
            "nothing",
            "api/maps/99999999999999999999",
            "static/",
            "static/nothing.js",
        ],
    )
    def test_other_paths(self, reader, path):
        assert reader.get(path).status == 404
        assert reader.get(path).error

    def test_other_methods(self, reader):
        assert reader.ask("DELETE", f"/{TOKEN}/api/maps/0").status == 405
        assert reader.get("api/maps/0/save").status == 405

    def test_an_error_of_pianta_itself_is_one_line(self, reader, monkeypatch):
        def fail(self: object) -> None:
            raise PiantaError("something else")

        monkeypatch.setattr(sessions.Session, "describe", fail)
        answer = reader.get("api/maps/0")
        assert (answer.status, answer.error) == (500, "something else")


class TestGuard:
    @pytest.mark.parametrize(
        "path",
        [
            "/",
            "/api/maps",
            "/wrong/api/maps",
            f"/{TOKEN}x/",
            f"/{TOKEN[:-1]}/",
            "//",
            "/wrong/static/leaflet.js",
            f"/x/../{TOKEN}/",
            "/%C3%A9/",
        ],
    )
    def test_every_request_needs_the_token(self, reader, path):
        answer = reader.ask("GET", path)
        assert answer.status == 404
        assert "rooms" not in answer.body.decode()
        assert "address" in answer.error

    @pytest.mark.parametrize(
        "host",
        [
            "evil.example",
            "evil.example:80",
            "127.0.0.1.evil.example",
            "",
            "10.0.0.1",
            "127.0.0.1:80@evil.example",
            "127.0.0.1:evil",
            "127.0.0.1:",
        ],
    )
    def test_a_name_of_another_host(self, reader, host):
        assert reader.get("api/maps", Host=host).status == 403

    def test_the_names_of_this_host(self, reader):
        assert reader.get("api/maps", Host=f"localhost:{reader.port}").status == 200

    @pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1", ""])
    def test_another_page(self, client, folder, origin):
        body = {"version": client.version(), "corrections": []}
        files = list_files(folder)
        assert client.post("api/maps/0/save", body, Origin=origin).status == 403
        assert client.get("api/maps", Origin=origin).status == 403
        assert list_files(folder) == files

    def test_one_of_two_origins_is_another_page(self, reader):
        for one, other in (("127.0.0.1:%d", "evil"), ("evil", "127.0.0.1:%d")):
            lines = [f"GET /{TOKEN}/api/maps HTTP/1.1", "Host: 127.0.0.1:%d", f"Origin: http://{one}",
                     f"Origin: http://{other}", "Connection: close", "", ""]  # fmt: skip
            with socket.create_connection(("127.0.0.1", reader.port), timeout=20) as browser:
                browser.sendall("\r\n".join(lines).replace("%d", str(reader.port)).encode())
                assert browser.recv(100).startswith(b"HTTP/1.1 403 ")

    def test_the_page_itself(self, reader):
        assert reader.get("api/maps", Origin=f"http://127.0.0.1:{reader.port}").status == 200

    @pytest.mark.parametrize(
        "path",
        [
            "static/../server.py",
            "static/%2e%2e/server.py",
            "static/..%2fserver.py",
            "../../etc/passwd",
            "static//etc/passwd",
            "static/%2fetc%2fpasswd",
            "api/maps/0/../../../floor.geojson",
        ],
    )
    def test_no_file_outside_of_the_page(self, reader, path):
        assert reader.get(path).status == 404

    def test_no_file_behind_a_null(self, reader):
        assert reader.get("static/leaflet.js%00.png").status == 404

    def test_a_large_body_is_refused(self, reader):
        for size in (MAX_BODY + 1, 3 * MAX_BODY):
            answer = reader.post("api/maps/0/edit", b" " * size)
            assert (answer.status, str(MAX_BODY) in answer.error) == (413, True)
        assert reader.post("api/maps/0/edit", b" " * MAX_BODY).status == 400

    def test_a_large_body_without_a_length_is_refused(self, reader):
        parts = iter([b" " * 2**20] * 3)
        assert reader.post_parts("api/maps/0/edit", parts).status == 413

    def test_a_very_large_body_is_not_read_to_its_end(self, reader):
        try:
            answer = reader.post("api/maps/0/edit", b" " * (2 * MAX_DRAINED))
        except (BrokenPipeError, ConnectionResetError):
            return
        assert answer.status == 413

    def test_headers_keep_the_page_to_itself(self, reader):
        for answer in (reader.get(""), reader.get("api/maps/0"), reader.get("static/leaflet.js"), reader.get("none")):
            policy = answer.headers["content-security-policy"]
            assert "default-src 'none'" in policy
            assert "script-src 'self';" in policy
            assert "unsafe" not in policy
            assert (answer.headers["x-content-type-options"], answer.headers["referrer-policy"]) == (
                "nosniff",
                "no-referrer",
            )
            assert "access-control-allow-origin" not in answer.headers
        assert reader.get("api/maps/0").headers["cache-control"] == "no-store"

    def test_only_the_loopback_address_listens(self, reader):
        others = {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
        for address in others - {"127.0.0.1", "127.0.1.1"}:
            with pytest.raises(OSError, match="refused"):
                socket.create_connection((str(address), reader.port), timeout=5)


def test_live_the_version_follows_the_files(client, folder):
    version = client.version()
    assert client.version() == version
    assert run_pianta("correct", folder, "--name", "1", "A").code == 0
    assert client.version() != version
    assert rooms_of(client.get("api/maps/0"))[1]["name"] == "A"


@pytest.mark.parametrize(
    "name", ["<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "{{1}}", "&lt;"]
)
def test_names_are_data(client, name):
    answer = client.edit([], kind="name", room=1, name=name)
    assert rooms_of(answer)[1]["name"] == name
    assert answer.headers["content-type"] == "application/json"
    saved = save(client, answer.json["corrections"])
    assert rooms_of(saved)[1]["name"] == name


def test_a_reading_is_not_opened_for_each_edit(client, monkeypatch):
    assert client.get("api/maps/0").status == 200
    monkeypatch.setattr(SavedReading, "open", None)
    corrections: list[Any] = []
    for number in range(5):
        corrections = client.edit(corrections, kind="name", room=1, name=f"{number}").json["corrections"]
    monkeypatch.setattr(SavedReading, "keep", None)
    for length in range(5, -1, -1):
        body = {"version": client.version(), "corrections": corrections[:length]}
        assert client.post("api/maps/0/apply", body).status == 200
