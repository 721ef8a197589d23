"""Worlds of generated buildings, as `pianta generate --worlds` and `pianta world TYPE --model` make them."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
import shapely
from defusedxml import ElementTree
from shapely import unary_union

import pianta
from pianta.errors import ModelError, OptionError
from pianta.generation.type_model import TypeModel, learn_type
from pianta.generation.type_model_file import save_type_model
from pianta.labels import SCHEMAS, SCHOOL
from pianta.worlds import room_furniture
from pianta.worlds.furnish import furnish
from pianta.worlds.room_space import RoomSpace
from tests.command_line import Outcome, list_files, run_pianta
from tests.generated_types import make_schools
from tests.test_ways import find_reached_rooms

FILES = {"map.yaml", "map.png", "truth.geojson", "world.sdf", "rooms.json"}


@pytest.fixture(scope="module")
def model() -> TypeModel:
    """The model of small schools with areas, with short chains."""
    schools = make_schools()
    for school in schools:
        nx.set_node_attributes(school, 30.0, "area")
    return replace(learn_type(schools, SCHOOL), sweeps=5, edge_moves=20, door_moves=5)


@pytest.fixture(scope="module")
def model_file(model: TypeModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "school.json"
    save_type_model(model, path)
    return path


def generate(model_file: Path, out: Path, *options: object) -> Outcome:
    return run_pianta("generate", model_file, "-n", 2, "--seed", 3, *options, "-o", out)


@pytest.fixture(scope="module")
def worlds(model_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of two schools with their worlds and scans."""
    out = tmp_path_factory.mktemp("worlds") / "out"
    outcome = generate(model_file, out, "--scan")
    assert outcome.code == 0, outcome.err
    where = outcome.out.splitlines()[-1]
    assert where.endswith("truth.geojson, world.sdf, rooms.json, scan-*/ with map.yaml, map.png")
    return out


def test_each_building_has_the_folders_of_its_world_and_scan(worlds):
    assert {path.name for path in (worlds / "building-002").iterdir()} == FILES
    assert {path.name for path in (worlds / "scan-002").iterdir()} == {"map.yaml", "map.png"}
    assert {path.name for path in worlds.iterdir() if path.is_file()} == {
        "sheet.png",
        "plans.png",
        *(f"building-00{number}.{suffix}" for number in (1, 2) for suffix in ("json", "graphml", "geojson", "png")),
    }


def test_the_truth_is_the_drawn_floor_with_furniture_in_its_rooms_and_not_at_doors(worlds):
    for name in ("building-001", "building-002"):
        plan = pianta.read_floor(worlds / f"{name}.geojson")
        truth = pianta.read_floor(worlds / name / "truth.geojson")
        assert replace(truth, furniture=()) == plan
        pieces = [piece.polygon for piece in truth.furniture]
        assert len(pieces) > 50
        rooms = unary_union([room.polygon for room in truth]).buffer(0.01)
        assert rooms.contains(shapely.MultiPolygon(pieces))
        assert (
            not unary_union([door.line.buffer(0.2, cap_style="flat") for door in truth.doors]).intersects(pieces).any()
        )


def test_furniture_is_of_the_rooms_labels(worlds):
    kinds: dict[str, set[str]] = {}
    for name in ("building-001", "building-002"):
        truth = pianta.read_floor(worlds / name / "truth.geojson")
        for room in truth:
            inside = [piece.kind for piece in truth.furniture if room.polygon.contains(piece.polygon) and piece.kind]
            kinds.setdefault(str(room.label), set()).update(inside)
    assert "desk" in kinds["CLASSROOM"]
    assert "desk" not in kinds["CORRIDOR"]
    assert kinds["BATHROOM"] & {"toilet", "sink"}


def test_the_map_has_walls_and_furniture_in_full_depth(worlds):
    truth = pianta.read_floor(worlds / "building-001" / "truth.geojson")
    grid = pianta.read_map(worlds / "building-001" / "map.yaml")
    rows, cols = np.indices(grid.shape) + 0.5
    points = shapely.points(*grid.pixel_to_map(rows, cols))
    furniture = unary_union([piece.polygon for piece in truth.furniture])
    rooms = unary_union([room.polygon for room in truth])
    shapely.prepare([furniture, rooms])
    within = shapely.contains(rooms.buffer(-0.05), points)
    assert grid.free[within & ~shapely.dwithin(furniture, points, 0.06)].all()
    # A point on an edge may be on either side
    assert grid.occupied[shapely.contains(furniture.buffer(-1e-6), points)].all()
    # A cell of 0.05 m shows also what is thinner than a cell
    for piece in truth.furniture:
        row, col = (int(value) for value in grid.map_to_pixel(*piece.polygon.centroid.coords[0]))
        assert not grid.free[row, col]


def test_a_robot_gets_into_all_rooms(worlds):
    truth = pianta.read_floor(worlds / "building-001" / "truth.geojson")
    assert find_reached_rooms(truth, 0.2) == {room.id for room in truth}


def test_the_world_of_gazebo_has_all_furniture_and_a_frame_in_each_room(worlds):
    truth = pianta.read_floor(worlds / "building-001" / "truth.geojson")
    root = ElementTree.parse(worlds / "building-001" / "world.sdf").getroot()
    assert root.tag == "sdf"
    assert root.find("world").get("name") == "building-001"
    boxes = [element for element in root.iter("collision") if element.get("name", "").startswith("furniture_")]
    assert len(boxes) == len(truth.furniture)
    assert all(len([float(value) for value in pose.text.split()]) == 6 for pose in root.iter("pose"))
    frames = {frame.get("name"): frame.findtext("pose").split() for frame in root.iter("frame")}
    assert frames.keys() == {f"room_{room.id}" for room in truth}
    for room in truth:
        x, y = map(float, frames[f"room_{room.id}"][:2])
        assert shapely.contains_xy(room.polygon, x, y)


@pytest.mark.slow
def test_the_scan_shows_the_same_furniture_with_noise(worlds, model_file, tmp_path):
    true, scan = (pianta.read_map(worlds / f"{name}-001" / "map.yaml") for name in ("building", "scan"))
    assert true.shape == scan.shape
    assert 0.9 < (true.free == scan.free).mean() < 0.999
    assert generate(model_file, tmp_path / "clean", "--scan", "--noise", 0).code == 0
    clean = pianta.read_map(tmp_path / "clean" / "scan-001" / "map.yaml")
    assert (clean.free == true.free).all()
    assert clean.occupied.sum() < true.occupied.sum()


@pytest.mark.slow
def test_the_scan_is_read_by_pianta_read(worlds, tmp_path):
    outcome = run_pianta("read", worlds / "scan-001", "-o", tmp_path / "read")
    assert outcome.code == 0, outcome.err
    read = pianta.read_floor(tmp_path / "read" / "map" / "floor.geojson")
    truth = pianta.read_floor(worlds / "building-001" / "truth.geojson")
    assert len(read) >= len(truth) - 3
    covered = unary_union([room.polygon for room in read]).intersection(unary_union([room.polygon for room in truth]))
    assert covered.area > 0.9 * sum(room.polygon.area for room in truth)


@pytest.mark.slow
def test_worlds_are_the_same_for_any_jobs(worlds, model_file, tmp_path):
    assert generate(model_file, tmp_path / "two", "--scan", "--jobs", 2).code == 0
    assert list_files(tmp_path / "two") == list_files(worlds)


@pytest.mark.slow
def test_worlds_of_parts_are_those_of_one_run(worlds, model_file, tmp_path):
    outcome = generate(model_file, tmp_path / "parts", "--scan", "--shard", "1/1", "--jobs", 2)
    assert outcome.code == 0, outcome.err
    part = tmp_path / "parts" / "part-0001"
    assert (part / "building-000002" / "map.png").read_bytes() == (worlds / "building-002" / "map.png").read_bytes()
    assert (part / "scan-000002" / "map.png").read_bytes() == (worlds / "scan-002" / "map.png").read_bytes()
    one, other = (
        pianta.read_floor(path / "truth.geojson") for path in (part / "building-000001", worlds / "building-001")
    )
    assert replace(one, source="") == replace(other, source="")


@pytest.mark.slow
def test_options_of_worlds_are_options_of_a_batch(model, tmp_path):
    def is_new(**options: Any) -> bool:
        (part,) = pianta.generate_batch(model, 1, out=tmp_path / "out", **options)
        assert part.fault is None
        return part.is_new

    world = tmp_path / "out" / "part-0001" / "building-000001"
    assert is_new(worlds=True, furniture=0.1)
    assert not is_new(worlds=True, furniture=0.1)
    before = (world / "map.png").read_bytes()
    assert is_new(worlds=True, furniture=0.5)
    assert (world / "map.png").read_bytes() != before
    assert is_new(scan=True, furniture=0.5)
    assert is_new(scan=True, furniture=0.5, noise=0.9)
    assert is_new(plans=True)
    assert not world.exists()
    assert not is_new(plans=True)


@pytest.mark.slow
def test_worlds_that_are_not_wanted_any_more_go_and_files_of_others_stay(worlds, model_file, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(worlds, out)
    (out / "building-001" / "notes.txt").write_text("mine")
    assert generate(model_file, out, "--worlds", "--furniture", 0).code == 0
    assert not list(out.glob("scan-*"))
    assert pianta.read_floor(out / "building-002" / "truth.geojson").furniture == ()
    assert generate(model_file, out).code == 0
    assert [path.name for path in out.glob("building-*/*")] == ["notes.txt"]
    assert not (out / "building-002").exists()


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (["--furniture", "1"], "--furniture is of worlds, give --worlds or --scan, too"),
        (["--plans", "--resolution", "0.1"], "--resolution is of worlds, give --worlds or --scan, too"),
        (["--worlds", "--noise", "0.1"], "--noise is of the maps of robots, give --scan, too"),
        (["--worlds", "--furniture", "11"], "furniture is 11.0, give 0 … 10"),
        (
            ["--scan", "--noise", "nan", "--resolution", "0"],
            "resolution is 0.0, give 0.005 … 0.5 metres per cell; noise",
        ),
    ],
)
def test_options_without_meaning_are_one_line_and_write_nothing(model_file, tmp_path, options, fault):
    code, out, err = generate(model_file, tmp_path / "out", *options)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert err.startswith("error: ")
    assert fault in err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_file_in_the_place_of_a_world_is_one_line(model_file, tmp_path):
    (tmp_path / "building-002").write_text("mine")
    code, out, err = generate(model_file, tmp_path, "--worlds")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "building-002" in err
    assert [path.name for path in tmp_path.iterdir()] == ["building-002"]


def test_a_world_of_a_type_is_the_first_building_of_the_seed(worlds, model, model_file, tmp_path):
    options = ("--seed", "3", "--furniture", "0.5", "--dense-furniture", "--noise", "0.2")
    outcome = run_pianta("world", "School", "--model", model_file, *options, "-o", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"map.yaml", "map.png", "truth.geojson"}
    truth = pianta.read_floor(tmp_path / "out" / "truth.geojson")
    plan = pianta.read_floor(worlds / "building-001.geojson")
    assert (truth.rooms, truth.doors) == (plan.rooms, plan.doors)
    assert truth.source == "school"
    assert len(truth.furniture) > 20
    floor, grid = pianta.make_world("school", model=model, seed=3, furniture=0.5, dense_furniture=True, noise=0.2)
    assert floor == truth
    assert (grid.cells == pianta.read_map(tmp_path / "out" / "map.yaml").cells).all()
    assert pianta.make_world("school", model=model, seed=4)[0] != plan


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["office"], "name is 'office', the model is of type 'school'; give that name, or leave out the model"),
        (["sample"], "name is 'sample', the model is of type 'school'"),
        ([""], "name is '', the model is of type 'school'"),
        (["school", "--noise", "2"], "noise is 2.0, give 0 … 1"),
    ],
)
def test_a_world_of_another_type_is_one_line_and_writes_nothing(model_file, tmp_path, arguments, fault):
    code, out, err = run_pianta("world", *arguments, "--model", model_file, "-o", tmp_path / "out")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert fault in err
    assert not (tmp_path / "out").exists()


def test_a_type_without_its_model_and_a_file_that_is_none_are_one_line(worlds, tmp_path):
    code, _, err = run_pianta("world", "school", "-o", tmp_path / "out")
    assert (code, len(err.splitlines())) == (2, 1)
    assert "name is 'school', give one of sample, " in err
    assert err.rstrip().endswith("or a building type with its model")
    code, _, err = run_pianta("world", "school", "--model", worlds / "building-001.json", "-o", tmp_path / "out")
    assert (code, len(err.splitlines())) == (2, 1)
    assert "building-001.json" in err
    assert not (tmp_path / "out").exists()


def test_a_model_without_areas_and_other_objects_are_refused(model):
    not_a_model: Any = "school.json"
    bare = learn_type(make_schools(), SCHOOL)
    with pytest.raises(ModelError, match="the model has no areas of rooms"):
        pianta.make_world("school", model=replace(bare, sweeps=5))
    with pytest.raises(OptionError, match="model= is a str, give a model of train_type or load_model"):
        pianta.make_world("school", model=not_a_model)
    with pytest.raises(OptionError, match="seed is -1"):
        pianta.make_world("school", model=model, seed=-1)


@pytest.mark.parametrize("building_type", ["school", "office"])
def test_every_label_of_a_type_has_a_recipe(monkeypatch, building_type):
    def refuse(space: RoomSpace) -> None:
        raise AssertionError

    monkeypatch.setattr(room_furniture, "_choose_recipe", refuse)
    rooms = tuple(
        pianta.Room(number, shapely.box(10 * number, 0, 10 * number + 6, 8), label.name)
        for number, label in enumerate(SCHEMAS[building_type].labels, start=1)
    )
    assert len(rooms) > 10
    assert len(furnish(pianta.Floor(rooms), furniture=1, dense_furniture=True).furniture) > 100
