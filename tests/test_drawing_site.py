"""Buildings that are drawn inside an outline, and the outlines that files have."""

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box, to_geojson, unary_union
from shapely.affinity import rotate

import pianta
from pianta.errors import FloorError, ModelError, OptionError
from pianta.generation.drawing.blocks import CELL, NO_ROOM
from pianta.generation.drawing.programme import make_site_programme
from pianta.generation.drawing.site import (
    FILLED,
    FRAME_CELLS,
    LEAST_SCALE,
    OUTSIDE,
    SHRINKAGE,
    choose_rooms,
    list_scales,
    make_site,
)
from pianta.generation.type_model import TypeModel, learn_type, prepare_room_graph
from pianta.io.graphs import read_graph
from pianta.io.outlines import read_outline
from pianta.labels import SCHEMAS
from tests.command_line import run_pianta
from tests.generated_types import AREAS, OTHER_AREA, join_wings, make_schools, sized_model, small_model

SCHOOL = join_wings(("CCCCCC", "CCCCT"), ((0, 1),), source="")  # 13 rooms, 668 m² in the sized model
LEVEL = box(0, 0, 50, 30)
SHAPES = {
    "level": LEVEL,
    "turned": rotate(LEVEL, 30),
    "an L": Polygon([(0, 0), (60, 0), (60, 24), (24, 24), (24, 60), (0, 60)]),
    "a court": box(0, 0, 60, 50).difference(box(20, 20, 40, 30)),
}


@pytest.fixture(scope="module")
def model() -> TypeModel:
    return sized_model()


def fill(*shape: int) -> np.ndarray:
    """A room 0 of a shape with free cells around it."""
    return np.pad(np.zeros(shape, np.int32), 3, constant_values=NO_ROOM)


def test_areas_are_those_of_a_floor_that_fills_the_outline():
    """Half of the schools have rooms of 60 % of their areas, half of 140 %."""
    schools = make_schools()
    for number, school in enumerate(schools):
        for _, room in school.nodes(data=True):
            room["area"] = AREAS.get(room["label"], OTHER_AREA) * (0.6, 1.4)[number % 2]
    model = learn_type(schools, SCHEMAS["school"])
    graph = prepare_room_graph(SCHOOL, model.schema)
    totals = []
    for factor in (0.6, 1.0, 1.4):
        site = make_site(box(0, 0, 50, factor * 668 / FILLED / 50))
        draws = [make_site_programme(graph, model, np.random.default_rng(seed), site) for seed in range(3)]
        totals.append(np.mean([sum(draw.areas.values()) for draw in draws]) * CELL**2)
    small, middle, large = totals
    assert small < 0.9 * middle
    assert middle == pytest.approx(668, rel=0.1)
    assert large > 1.1 * middle


class TestSite:
    @pytest.mark.parametrize("angle", [0, 30, 90, -75])
    def test_cells_are_whole_inside(self, angle):
        """6 m by 10.2 m: 12 by 20 cells of 0.5 m."""
        site = make_site(rotate(box(3, 4, 9, 14.2), angle, origin=(0, 0)))
        assert site.area == 12 * 20
        assert sorted(np.argwhere(site.mask).max(axis=0) + 1 - FRAME_CELLS) == [12, 20]

    @pytest.mark.parametrize("angle", [0, 30, 90, -75])
    def test_the_frame_is_that_of_the_outline(self, angle):
        outline = rotate(box(3, 4, 9, 14), angle, origin=(1, 2))
        site = make_site(outline)
        rows, columns = site.mask.shape
        inner = box(*(FRAME_CELLS / 2,) * 2, (columns - FRAME_CELLS) / 2, (rows - FRAME_CELLS) / 2)
        (room,) = site.move(pianta.Floor((pianta.Room(1, inner),))).rooms
        assert room.polygon.symmetric_difference(outline).area == pytest.approx(0, abs=1e-6)

    def test_a_building_is_turned_to_fit(self):
        site = make_site(box(0, 0, 20, 5))
        position = site.find_position(fill(30, 8))
        assert (position.turns % 2, position.outside) == (1, 0)
        on_site = site.put(fill(30, 8))
        assert on_site is not None
        assert ((on_site == 0).sum(), (on_site == NO_ROOM).sum()) == (240, site.area - 240)
        assert (on_site[~site.mask] == OUTSIDE).all()

    def test_what_is_outside_is_cut_off(self):
        site = make_site(box(0, 0, 20, 5))
        assert site.find_position(fill(12, 40)).outside == 2 * 40
        on_site = site.put(fill(12, 40))
        assert on_site is not None
        assert (on_site == 0).sum() == 10 * 40

    def test_too_much_of_a_room_outside(self):
        assert make_site(box(0, 0, 20, 5)).put(fill(30, 40)) is None

    def test_a_room_is_not_cut_into_parts(self):
        """Two squares of 4 m with a passage of 1 m between their middles, where the outline has none."""
        cells = fill(8, 26)
        cells[3:6, 11:21] = cells[8:11, 11:21] = NO_ROOM
        outline = box(0, 0, 13, 4)
        assert make_site(outline).put(cells) is not None
        assert make_site(outline.difference(box(4, 1, 9, 4))).put(cells) is None

    def test_areas_become_smaller_to_fit(self):
        site = make_site(box(0, 0, 20, 10))  # 800 cells, of which 640 are filled
        assert list_scales(100, site)[0] == 1
        scales = list_scales(1000, site)
        assert scales[:2] == pytest.approx([0.64, 0.64 * SHRINKAGE])
        assert scales[-1] >= LEAST_SCALE
        with pytest.raises(OptionError, match=r"^outline has 200 m², and the rooms need 312 m²; give a larger outline"):
            list_scales(2000, site)

    @pytest.mark.parametrize("outline", [Polygon(), Polygon([(0, 0), (9, 9), (9, 0), (0, 9)])])
    def test_no_valid_polygon(self, outline):
        with pytest.raises(OptionError, match="no valid polygon"):
            make_site(outline)

    def test_a_large_one(self):
        with pytest.raises(OptionError, match="outline is 30000 m long"):
            make_site(box(0, 0, 30_000, 10))

    def test_rooms_of_buildings_that_fill_it(self, model):
        sizes = [len(floor.graph) for floor in model.floors]
        least, most = choose_rooms(box(0, 0, 40, 20), model)
        assert min(sizes) <= least <= most <= max(sizes)
        assert choose_rooms(box(0, 0, 900, 900), model) == (max(sizes), max(sizes))
        with pytest.raises(OptionError, match=r"^outline has 25 m², in which 0 rooms of the type fit"):
            choose_rooms(box(0, 0, 5, 5), model)
        with pytest.raises(ModelError, match="no areas"):
            choose_rooms(LEVEL, small_model())


@pytest.mark.parametrize("shape", SHAPES)
def test_rooms_are_inside(model, shape):
    outline = SHAPES[shape]
    plan = pianta.draw_plan(SCHOOL, model, outline=outline)
    assert len(plan.floor) == len(SCHOOL)
    rooms = unary_union([room.polygon for room in plan.floor])
    assert rooms.difference(outline.buffer(0.01)).area == pytest.approx(0, abs=1e-6)
    assert all(door.line.difference(outline.buffer(0.2)).length == 0 for door in plan.floor.doors)
    assert len(plan.floor.doors) == SCHOOL.number_of_edges() - len(plan.given_up)


def test_an_outline_that_is_too_small(model):
    with pytest.raises(OptionError, match=r"^outline has 100 m², and the rooms need \d+ m²; give a larger outline"):
        pianta.draw_plan(SCHOOL, model, outline=box(0, 0, 10, 10))


def test_an_outline_in_which_nothing_fits(model):
    """A passage that is as large as the building, and 2 m wide."""
    wing = join_wings(("CCCC",), (), source="")
    fault = r"^no layout of the 5 rooms that was tried fits into the outline; give a larger outline, fewer rooms"
    with pytest.raises(OptionError, match=fault):
        pianta.draw_plan(wing, model, outline=box(0, 0, 160, 2))


@pytest.mark.slow
@settings(deadline=None, max_examples=8)
@given(st.floats(15, 70), st.floats(15, 70), st.floats(0, 180), st.integers(0, 9))
def test_any_rectangle(width, height, angle, seed):
    """The building is inside, or the outline is refused."""
    outline = rotate(box(0, 0, width, height), angle)
    refused = None
    try:
        plan = pianta.draw_plan(make_schools()[0], sized_model(), seed=seed, outline=outline)
    except OptionError as error:
        refused = str(error)
    if refused is not None:
        assert "outline" in refused
        return
    rooms = unary_union([room.polygon for room in plan.floor])
    assert rooms.difference(outline.buffer(0.01)).area == pytest.approx(0, abs=1e-6)
    assert sum(room.polygon.area for room in plan.floor) == pytest.approx(rooms.area)


class TestReadOutline:
    def test_a_polygon(self, tmp_path):
        (tmp_path / "o.json").write_text(to_geojson(LEVEL))
        assert read_outline(tmp_path / "o.json").equals(LEVEL)

    def test_heights_of_some_corners_are_dropped(self, tmp_path):
        corners = [[0, 0, 1], [50, 0], [50, 30], [0, 30], [0, 0, 2]]
        (tmp_path / "o.json").write_text(json.dumps({"type": "Polygon", "coordinates": [corners]}))
        outline = read_outline(tmp_path / "o.json")
        assert outline.equals(LEVEL)
        assert make_site(outline).area == 100 * 60

    def test_a_feature(self, tmp_path):
        feature = {"type": "Feature", "properties": {}, "geometry": json.loads(to_geojson(SHAPES["a court"]))}
        (tmp_path / "o.json").write_text(json.dumps(feature))
        assert read_outline(tmp_path / "o.json").equals(SHAPES["a court"])

    def test_a_ring_that_is_not_closed(self, tmp_path):
        corners = [[0, 0], [50, 0], [50, 30], [0, 30]]
        (tmp_path / "o.json").write_text(json.dumps({"type": "Polygon", "coordinates": [corners]}))
        assert read_outline(tmp_path / "o.json").equals(LEVEL)

    def test_polygons_of_a_collection(self, tmp_path):
        """Features without a geometry are left out."""
        parts = {"type": "MultiPolygon", "coordinates": [json.loads(to_geojson(LEVEL))["coordinates"]]}
        collection = {"type": "GeometryCollection", "geometries": [parts, {"type": "Point", "coordinates": [0, 0]}]}
        features = [{"type": "Feature", "geometry": each} for each in (None, collection)]
        (tmp_path / "o.json").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        assert read_outline(tmp_path / "o.json").equals(LEVEL)

    def test_a_floor(self, tmp_path):
        """Two rooms with a wall of 0.2 m between them: the axes of outer walls are 0.15 m outside."""
        floor = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4.2, 0, 8, 3))))
        floor.save(tmp_path / "floor.geojson")
        expected = box(-0.15, -0.15, 8.15, 3.15)
        for path in (tmp_path, tmp_path / "floor.geojson"):
            assert read_outline(path).symmetric_difference(expected).area == pytest.approx(0, abs=1e-3)

    @pytest.mark.parametrize(
        ("content", "fault"),
        [
            ("polygon", "it is no GeoJSON"),
            ('{"type": "GeometryCollection", "geometries": [' * 100_000 + "]}" * 100_000, "it is no GeoJSON"),
            ('{"type": "Point", "coordinates": [1, 2]}', "it has no polygon"),
            ('{"type": "FeatureCollection", "features": []}', "it has no polygon"),
            ('{"type": "FeatureCollection", "features": 3}', "it has no polygon"),
            ('{"type": "Feature", "properties": {}, "geometry": null}', "it has no polygon"),
            ('{"type": "Polygon", "coordinates": []}', "it has no polygon"),
            ("[1, 2]", "it is no GeoJSON"),
            ("{}", "it is no GeoJSON"),
            ('{"type": "Polygon"}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[]]}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[[0, 0], [9, 0]]]}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9]]]}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], {}]]}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], "99"]]}', "rings of 3 or more corners"),
            ('{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 1e999]]]}', "give metres"),
            (f'{{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 1{"0" * 400}]]]}}', "rings of 3 or more"),
            (to_geojson(box(9.18, 45.4, 9.181, 45.401)), "give metres"),
            (to_geojson(box(0, 0, 1e9, 1)), "give metres"),
            (to_geojson(box(1e8, 0, 1e8 + 40, 30)), "from the origin"),
            (to_geojson(Polygon([(0, 0), (9, 9), (9, 0), (0, 9)])), "its sides cross"),
            (to_geojson(box(0, 0, 9, 9).union(box(50, 0, 59, 9))), "in 2 parts"),
        ],
    )
    def test_what_is_no_outline(self, tmp_path, content, fault):
        (tmp_path / "o.json").write_text(content)
        with pytest.raises(FloorError, match=fault) as refused:
            read_outline(tmp_path / "o.json")
        assert "o.json" in str(refused.value)

    def test_no_file(self, tmp_path):
        with pytest.raises(FloorError, match="does not exist"):
            read_outline(tmp_path / "nowhere.json")


def test_the_command(model, tmp_path):
    level = box(0, 0, 32, 24)
    model.save(tmp_path / "school.json")
    (tmp_path / "o.json").write_text(to_geojson(level))
    command = ("generate", tmp_path / "school.json", "-n", 2, "--outline", tmp_path / "o.json", "-o", tmp_path / "out")
    outcome = run_pianta(*command)
    assert outcome.code == 0, outcome.err
    assert all(line.startswith("warning: building") for line in outcome.err.splitlines())
    floors = [pianta.read_floor(tmp_path / "out" / f"building-00{number}.geojson") for number in (1, 2)]
    least, most = choose_rooms(level, model)
    for floor in floors:
        assert least <= len(floor) <= most
        assert all(level.buffer(0.01).contains(room.polygon) for room in floor)
    parts = run_pianta(*command[:-1], tmp_path / "parts", "--shard", "1/1", "-q")
    assert parts.code == 0, parts.err
    assert [pianta.read_floor(file).rooms for file in sorted((tmp_path / "parts").glob("*/building-*.geojson"))] == [
        floor.rooms for floor in floors
    ]


def test_buildings_that_are_too_large_are_left_out_by_name(model, tmp_path):
    model.save(tmp_path / "school.json")
    (tmp_path / "o.json").write_text(to_geojson(box(0, 0, 20, 19.5)))
    options = ("--rooms", "9-19", "--worlds", "--resolution", 0.2)
    command = ("generate", tmp_path / "school.json", "-n", 3, "--outline", tmp_path / "o.json", *options, "-o")
    outcome = run_pianta(*command, tmp_path / "out")
    assert outcome.code == 0, outcome.err
    faults = [line for line in outcome.err.splitlines() if "cannot be drawn" in line]
    left_out = [int(line.removeprefix("warning: building ").split()[0]) for line in faults]
    assert 0 < len(left_out) < 3
    for number in range(1, 4):
        files = {path.name for path in (tmp_path / "out").glob(f"building-00{number}*")}
        plan_files = {f"building-00{number}{suffix}" for suffix in (".geojson", ".png", "")}
        assert files - plan_files == {f"building-00{number}.json", f"building-00{number}.graphml"}
        assert files & plan_files == (set() if number in left_out else plan_files)
        graph = read_graph(tmp_path / "out" / f"building-00{number}.json").graph
        assert graph.get("drawn") is (False if number in left_out else None)

    parts = run_pianta(*command, tmp_path / "parts", "--shard", "1/1")
    assert parts.code == 0, parts.err
    written = sorted(path.name for path in (tmp_path / "parts" / "part-0001").glob("building-*"))
    assert written == sorted(f"building-000{path.name[9:]}" for path in (tmp_path / "out").glob("building-*"))
    again = run_pianta(*command, tmp_path / "parts", "--shard", "1/1")
    assert again.out.startswith("1 of 1 part generated, 1 of them before")
    (tmp_path / "parts" / "part-0001" / f"building-{min({1, 2, 3} - {*left_out}):06}.geojson").unlink()
    again = run_pianta(*command, tmp_path / "parts", "--shard", "1/1")
    assert "1 of 1 part generated" in again.out.splitlines()


def test_a_building_that_lacked_memory_is_not_left_out(model, tmp_path, monkeypatch):
    """Another run may have more."""
    from pianta.generation.drawing.draw import draw_plan

    plans: list[pianta.DrawnPlan] = []

    def fail_after_the_first(*arguments: Any, **options: Any) -> pianta.DrawnPlan:  # as of draw_plan
        if plans:
            raise MemoryError
        plans.append(draw_plan(*arguments, **options))
        return plans[0]

    monkeypatch.setattr("pianta.generation.drawing.draw.draw_plan", fail_after_the_first)
    (part,) = pianta.generate_batch(model, 2, out=tmp_path / "out", rooms=(9, 12), plans=True)
    assert part.fault is not None
    assert "building 2 cannot be drawn: it needs more memory" in part.fault
    assert not part.folder.exists()


def test_no_building_can_be_drawn(model, tmp_path):
    model.save(tmp_path / "school.json")
    (tmp_path / "o.json").write_text(to_geojson(box(0, 0, 10, 10)))
    command = ("generate", tmp_path / "school.json", "-n", 2, "--outline", tmp_path / "o.json", "--rooms", "9-19")
    outcome = run_pianta(*command, "-o", tmp_path / "out")
    assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
    assert "building 1 cannot be drawn: outline has 100 m²" in outcome.err
    assert not (tmp_path / "out").exists()


def test_an_unforeseen_fault_of_a_drawing_has_its_report(model, tmp_path, monkeypatch):
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division")

    monkeypatch.setattr("pianta.generation.drawing.draw.draw_plan", fail)
    (part,) = pianta.generate_batch(model, 2, out=tmp_path / "out", plans=True)
    assert (part.group, "ZeroDivisionError" in str(part.fault)) == ("unforeseen", True)
    assert "ZeroDivisionError" in (tmp_path / "out" / "faults" / "part-0001.txt").read_text(encoding="utf-8")
