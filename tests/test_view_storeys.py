"""Buildings of several storeys on the page of `pianta view`: their order, and the stairs that lead to another one."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pianta.building import Building, Link, Storey
from pianta.errors import FloorError
from pianta.io.building_folders import save_building_file
from pianta.view.folders import find_folders
from tests.browser import open_browser, opened_tab
from tests.served_floors import FLOOR, serving, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the page")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from open_browser()


@pytest.fixture
def house(tmp_path) -> Path:
    """Two equal storeys; the folder of the upper one is the first by name, and stairs lead from its room 2 to 3."""
    storeys = (Storey(FLOOR, "ground", 0.0, title="Ground floor"), Storey(FLOOR, "attic", 3.1))
    for storey in storeys:
        write_folder(tmp_path / "house" / storey.name)
    link = Link("stairs", (("ground", 3), ("attic", 2)))
    save_building_file(Building(storeys, "house", (link,)), tmp_path / "house" / "building.json")
    return Path(tmp_path) / "house"


def test_storeys_are_in_the_order_of_the_building(house):
    assert [*find_folders([house])] == ["ground", "attic"]


def test_stairs_lead_to_the_room_of_the_other_storey(browser, house):
    with serving(house) as client, opened_tab(browser, client, "#map=1") as tab:
        tab.wait_for_floor()
        tab.click((6.2, 4))
        tab.wait_for_text("#selected", "Room 2")
        tab.page.click("#selected a:has-text('Ground floor, room 3')")
        tab.wait_for_text("#selected", "Room 3")
        tab.wait_for_text("#title", "ground")
        tab.wait_for_text("#selected", "attic, room 2")


def test_links_to_what_is_not_shown_are_left_out(house):
    with serving(house / "attic") as client:
        assert client.get("api/maps/0").json["links"] == []
    with serving(house) as client:
        assert client.get("api/maps/1").json["links"] == [
            {"kind": "stairs", "room": 2, "storey": "Ground floor", "map": 0, "to": 3}
        ]


def test_a_damaged_building_is_one_line(house):
    content = json.loads((house / "building.json").read_text(encoding="utf-8"))
    content["storeys"][0]["name"] = "../elsewhere"
    (house / "building.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(FloorError, match=r"storeys\[0\]\.name"):
        find_folders([house])
    with serving(house / "attic") as client:
        assert client.get("api/maps/0").json["links"] == []
