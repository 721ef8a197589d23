"""Buildings of several storeys: made, saved, read from maps and plans, and joined by stairs and lifts."""

import json
from dataclasses import replace

import pytest
from shapely import LineString, box

import pianta
from pianta.errors import FloorError, OptionError
from pianta.io.building_folders import read_building_folder, save_building_file
from pianta.reading.storeys import find_links, parse_storeys, sort_storeys
from tests.command_line import run_pianta


def make_floor(*rooms: pianta.Room) -> pianta.Floor:
    return pianta.Floor(rooms, (pianta.Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),))


# Stairs 1 m east of a room, on both storeys; the upper ones are drawn 0.2 m further east.
GROUND = make_floor(pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4, 0, 6, 3), "STAIRS", name="Stair A"))
FIRST = make_floor(pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4.2, 0, 6.2, 3), "STAIRS", name="stair  a"))
LINK = pianta.Link("stairs", (("ground", 2), ("first", 2)))
HOUSE = pianta.Building((pianta.Storey(GROUND, "ground", 0.0), pianta.Storey(FIRST, "first", 3.1)), "house", (LINK,))


def unnamed(floor: pianta.Floor) -> pianta.Floor:
    return replace(floor, rooms=tuple(replace(room, name=None) for room in floor))


def test_the_graph_joins_storeys_by_stairs():
    graph = HOUSE.graph()
    assert sorted(graph.edges) == [
        (("first", 1), ("first", 2)),
        (("ground", 1), ("ground", 2)),
        (("ground", 2), ("first", 2)),
    ]
    assert graph.edges[("ground", 2), ("first", 2)] == {"kind": "stairs"}
    assert graph.nodes["first", 2]["storey"] == "first"


def test_all_faults_of_a_building_are_named():
    storeys = (pianta.Storey(GROUND, "ground"), pianta.Storey(FIRST, "ground"))
    with pytest.raises(FloorError, match=r"'ground' occurs more than once; links lead to rooms \[\('first', 2\)\]"):
        pianta.Building(storeys, links=(LINK,))
    with pytest.raises(FloorError, match="it has no storey"):
        pianta.Building(())


class TestLinks:
    def test_stairs_of_one_name_are_linked(self):
        assert [*find_links(HOUSE.storeys, one_frame=False)] == [LINK]

    def test_those_without_names_are_linked_by_position_in_one_frame(self):
        storeys = [replace(storey, floor=unnamed(storey.floor)) for storey in HOUSE]
        # 1.8 of 2 m overlap
        assert [*find_links(storeys, one_frame=True)] == [LINK]
        assert [*find_links(storeys, one_frame=False)] == []

    def test_two_of_one_name_are_not(self):
        second = pianta.Room(3, box(7, 0, 9, 3), "STAIRS", name="Stair A")
        upper = replace(HOUSE.storeys[1], floor=replace(FIRST, rooms=(*FIRST.rooms, second), last_id=3))
        assert [*find_links((HOUSE.storeys[0], upper), one_frame=True)] == []


def test_storeys_are_sorted_by_elevations_that_are_all_known():
    upper_first = HOUSE.storeys[::-1]
    assert [storey.name for storey in sort_storeys(upper_first)] == ["ground", "first"]
    unknown = (upper_first[0], replace(upper_first[1], elevation=None))
    assert [storey.name for storey in sort_storeys(unknown)] == ["first", "ground"]


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["a"], "1 storeys and 2 files"),
        (["a", "A:3"], "one name"),
        (["a", "b:high"], "no height"),
        (["a", "../b"], "no name for a folder"),
        (["a", ".."], "no name for a folder"),
        (["a", "\u202eb"], "can be printed"),
        (["a", "é" * 101], "of up to 200 bytes"),
        (["a", "b:nan"], "no height within"),
        (["a", "b:inf"], "no height within"),
        (["a", "b:1e300"], "no height within"),
    ],
)
def test_storeys_that_cannot_be_are_refused(texts, message):
    with pytest.raises(OptionError, match=message):
        parse_storeys(texts, 2)


class TestFiles:
    def test_a_building_is_read_as_it_was_saved(self, tmp_path):
        for storey in HOUSE:
            (tmp_path / storey.name).mkdir()
            storey.floor.save(tmp_path / storey.name / "floor.geojson")
        save_building_file(HOUSE, tmp_path / "building.json")
        building = read_building_folder(tmp_path)
        assert [(each.name, each.elevation, each.floor) for each in building] == [
            (each.name, each.elevation, each.floor) for each in HOUSE
        ]
        assert (building.name, building.links) == ("house", (LINK,))

    @pytest.mark.parametrize("name", ["../elsewhere", "/etc", "a/b", "..", "", "a\\b"])
    def test_storeys_are_never_elsewhere(self, tmp_path, name):
        content = {"format": "pianta building", "version": "1.0", "storeys": [{"name": name}]}
        (tmp_path / "building.json").write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(FloorError, match=r"storeys\.0\.name|storeys\[0\]"):
            read_building_folder(tmp_path)

    def test_a_folder_without_a_floor_is_refused(self, tmp_path):
        with pytest.raises(FloorError, match=r"has no floor\.geojson"):
            read_building_folder(tmp_path)


@pytest.mark.slow
def test_maps_are_read_as_storeys(tmp_path):
    for name, seed in (("low", 1), ("high", 2)):
        pianta.make_world("corridor", seed=seed)[1].save(tmp_path / f"{name}.yaml")
    out = tmp_path / "house"
    files = tmp_path / "high.yaml", tmp_path / "low.yaml"
    storeys = "--storey", "first:3.1", "--storey", "ground:0"
    code, printed, err = run_pianta("read", *files, "-o", out, *storeys, "--stairs", "ground:2 first:3", "--no-labels")
    assert (code, err) == (0, "")
    assert printed.splitlines()[-1] == f"2 storeys, 1 link by stairs and lifts, in {out}"
    building = read_building_folder(out)
    assert [(storey.name, storey.elevation) for storey in building] == [("ground", 0.0), ("first", 3.1)]
    assert building.links == (pianta.Link("stairs", (("ground", 2), ("first", 3))),)
    assert all(storey.grid is not None for storey in building)
    code, _, err = run_pianta("read", *files, "-o", out, *storeys, "--lift", "ground:2 first:300", "--no-labels")
    assert (code, "links lead to rooms [('first', 300)] that do not exist" in err) == (2, True)
    code, _, err = run_pianta("read", *files, "-o", out, "--lift", "ground:2 first:3")
    assert (code, "give --storey for each file" in err) == (2, True)
