"""Plans drawn by the tests are read as floors: rooms, doors between the right rooms, scale and names."""

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from shapely import LineString, Polygon, box
from shapely.affinity import translate

from pianta._types import Colors
from pianta.errors import OptionError, PlanError, PlanWarning
from pianta.floor import Door, Floor, Room
from pianta.plan import read_plan as plan_reading
from pianta.plan.doors.swings import Swing
from pianta.plan.read_plan import PlanFloor, PlanReading, read_plan
from pianta.plan.scale import sheet_scale
from pianta.plan.sheets.sheet import PlanScale, Sheet
from pianta.worlds.floors import build_floor
from pianta.worlds.plans.drawing import DrawnPlan, draw_plan

# Metres between the axes of walls: a passage with rooms on both sides, and a hall with rooms on one side.
FIVE = build_floor(
    box(0, 0, 12, 3),
    [box(0, 3, 4, 8), box(4, 3, 8, 8), box(8, 3, 12, 8), box(0, -5, 6, 0), box(6, -5, 12, 0)],
    side_doors=0,
)
THREE = build_floor(box(0, 0, 4, 12), [box(4, 0, 9, 4), box(4, 4, 9, 8), box(4, 8, 9, 12)], side_doors=0)


def save(colors: Colors, folder: Path, name: str = "plan.png") -> Path:
    cv2.imwrite(str(folder / name), np.ascontiguousarray(colors[..., ::-1]))
    return folder / name


def read(plan: DrawnPlan | Colors, folder: Path, *, with_text: bool = False, **options: Any) -> PlanReading:
    colors = plan.colors if isinstance(plan, DrawnPlan) else plan
    return read_plan(save(colors, folder), with_text=with_text, **options)


def overlap(one: Polygon, other: Polygon) -> float:
    return float(one.intersection(other).area / one.union(other).area)


def match_rooms(floor: Floor, truth: Floor, offset: tuple[float, float]) -> dict[int, int]:
    """The true room of each room by ids, both one to one; offset: of the truth, metres."""
    moved = {room.id: translate(room.polygon, *offset) for room in truth.rooms}
    matches = {
        room.id: max((overlap(room.polygon, polygon), true_id) for true_id, polygon in moved.items())[1]
        for room in floor.rooms
    }
    assert sorted(matches.values()) == sorted(moved)
    assert all(overlap(room.polygon, moved[matches[room.id]]) > 0.7 for room in floor.rooms)
    return matches


def offset_of(plan: DrawnPlan) -> tuple[float, float]:
    """From the frame of the truth to the lower left corner of the sheet."""
    x, y, _ = plan.grid.origin
    return -x, -y


def doors_between(floor: Floor, true_ids: dict[int, int]) -> list[tuple[int, ...]]:
    return sorted(tuple(sorted(true_ids[room] for room in door.room_ids)) for door in floor.doors)


def only_floor(reading: PlanReading) -> PlanFloor:
    (floor,) = reading.floors
    return floor


@pytest.mark.slow
@pytest.mark.parametrize("truth", [FIVE, THREE])
@pytest.mark.parametrize("style", ["thick", "double"])
def test_rooms_and_doors_of_a_drawn_plan_are_found(tmp_path, truth, style):
    plan = draw_plan(truth, px_per_metre=30, style=style)
    plan_floor = only_floor(read(plan, tmp_path, resolution=1 / 30))
    true_ids = match_rooms(plan_floor.floor, truth, offset_of(plan))
    assert doors_between(plan_floor.floor, true_ids) == sorted(door.room_ids for door in truth.doors)
    true_doors = {door.room_ids: translate(door.line, *offset_of(plan)) for door in truth.doors}
    for door in plan_floor.floor.doors:
        line = true_doors[tuple(sorted(true_ids[room] for room in door.room_ids))]
        assert door.line.centroid.distance(line.centroid) < 0.45
        assert door.width == pytest.approx(line.length, abs=0.3)


def test_a_given_resolution_is_the_scale(tmp_path):
    plan = draw_plan(THREE, px_per_metre=40)
    plan_floor = only_floor(read(plan, tmp_path, resolution=0.05))
    assert (plan_floor.scale.resolution, plan_floor.scale.source, plan_floor.scale.confidence) == (
        0.05,
        "the given resolution",
        1.0,
    )
    assert plan_floor.grid.resolution == 0.05
    assert plan_floor.grid.shape == plan.colors.shape[:2]
    assert list(plan_floor.grid.origin) == [0, 0, 0]
    left, bottom, right, top = np.array([room.polygon.bounds for room in plan_floor.floor.rooms]).T
    # Twice the true size
    assert right.max() - left.min() == pytest.approx(18, abs=1)
    assert top.max() - bottom.min() == pytest.approx(24, abs=1)


@pytest.mark.slow
@pytest.mark.parametrize("style", ["thick", "double"])
def test_doors_with_arcs_give_the_scale(tmp_path, style):
    plan_floor = only_floor(read(draw_plan(FIVE, px_per_metre=40, style=style), tmp_path))
    assert plan_floor.scale.resolution == pytest.approx(1 / 40, rel=0.15)
    assert re.search(r"\d doors", plan_floor.scale.source)
    assert 0 < plan_floor.scale.confidence < 1
    low, high = plan_floor.scale.interval or (0, 0)
    assert low < 1 / 40 < high
    assert sum(room.polygon.area > 10 for room in plan_floor.floor.rooms) == 6


@pytest.mark.slow
def test_a_certain_scale_bar_is_nearer_to_the_scale_than_doors(tmp_path, monkeypatch):
    stated = PlanScale(1 / 48, "the scale bar", 0.95)
    monkeypatch.setattr(sheet_scale, "find_stated_scale", lambda *_, **__: stated)
    scale = only_floor(read(draw_plan(FIVE, px_per_metre=40, style="thick"), tmp_path)).scale
    assert scale.source.startswith("the scale bar")
    assert scale.resolution == pytest.approx(1 / 48, rel=0.02)


@pytest.mark.slow
def test_rooms_are_read_without_symbols(tmp_path):
    plan = draw_plan(THREE, px_per_metre=40)
    plan_floor = only_floor(read(plan, tmp_path, resolution=0.025, with_symbols=False))
    assert len(plan_floor.floor.rooms) >= 1
    outlines = [translate(room.polygon, *offset_of(plan)) for room in THREE.rooms]
    covered = sum(room.polygon.intersection(outline).area for room in plan_floor.floor.rooms for outline in outlines)
    assert covered > 0.8 * sum(outline.area for outline in outlines)


@pytest.mark.slow
def test_reading_again_reads_the_same(tmp_path):
    plan = draw_plan(THREE, px_per_metre=30)
    one, other = (only_floor(read(plan, tmp_path, resolution=1 / 30)) for _ in range(2))
    assert one.floor == other.floor
    assert one.scale == other.scale


@pytest.mark.slow
def test_two_floors_on_a_sheet_are_read_with_a_warning(tmp_path):
    upper, lower = (draw_plan(floor, px_per_metre=25) for floor in (FIVE, THREE))
    height = max(upper.colors.shape[0], lower.colors.shape[0])
    parts = [
        np.pad(plan.colors, ((0, height - plan.colors.shape[0]), (100, 100), (0, 0)), constant_values=255)
        for plan in (upper, lower)
    ]
    path = save(np.hstack(parts), tmp_path)
    with pytest.warns(PlanWarning, match=r"\bfloors\b"):
        reading = read_plan(path, resolution=0.04, with_text=False)
    first, second = reading.floors
    assert [len(first.floor.rooms), len(second.floor.rooms)] == [6, 4]
    assert all(first.floor.rooms[0].polygon.disjoint(room.polygon) for room in second.floor.rooms)
    assert first.scale == second.scale


@pytest.mark.slow
def test_many_plans_on_a_sheet_give_a_warning(tmp_path):
    one = draw_plan(THREE, px_per_metre=25).colors
    padded = np.pad(one, ((60, 60), (60, 60), (0, 0)), constant_values=255)
    path = save(np.vstack([np.hstack([padded] * 2)] * 2), tmp_path)
    with pytest.warns(PlanWarning, match="shows 4 floors or plans.*crop it to one") as caught:
        read_plan(path, resolution=0.04, with_text=False)
    assert [len(str(each.message).splitlines()) for each in caught] == [1]


def test_a_single_room_without_a_door_may_be_no_plan():
    room = Room(1, box(0, 0, 4, 4))
    picture = Sheet(np.full((9, 9, 3), 255, np.uint8))
    (note,) = plan_reading._question_plan([Floor((room,))], picture)
    assert note.startswith("plan: a single room without a door")
    door = Door((1, None), LineString([(1, 0), (2, 0)]), 1.0)
    assert plan_reading._question_plan([Floor((room,), (door,))], picture) == ()
    assert plan_reading._question_plan([Floor((room, Room(2, box(4, 0, 8, 4))))], picture) == ()
    named = replace(picture, walls=np.zeros((9, 9), bool))
    assert plan_reading._question_plan([Floor((room,))], named) == ()


def wash(height: int = 300, width: int = 400) -> Colors:
    """Soft colours that change slowly, as in a photo of the sky."""
    rows, cols = np.mgrid[:height, :width]
    layers = 120 + 80 * np.sin(cols / 90) + 40 * np.cos(rows / 70), 130 + 60 * np.cos(cols / 120), 90 + rows / 3
    return np.stack(layers, axis=-1).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    "colors",
    [
        np.full((300, 400, 3), 255, np.uint8),
        np.zeros((200, 300, 3), np.uint8),
        np.full((1, 300, 3), 255, np.uint8),
        np.random.default_rng(0).normal(200, 12, (200, 300, 3)).clip(0, 255).astype(np.uint8),
        wash(),
    ],
    ids=["white", "black", "thin", "grain", "wash"],
)
def test_other_pictures_are_refused_in_one_line(tmp_path, colors):
    with pytest.raises(PlanError, match=r"^[^\n]*plan\.png[^\n]*blank[^\n]*$"):
        read(colors, tmp_path)


@pytest.mark.parametrize("resolution", [-1.0, 0.0, 1e-9, 1e6, float("nan")])
def test_a_resolution_of_no_building_is_refused(tmp_path, resolution):
    with pytest.raises(PlanError, match=r"^[^\n]*resolution[^\n]*$"):
        read(draw_plan(THREE, px_per_metre=10), tmp_path, resolution=resolution)


def test_an_unknown_method_and_a_page_of_a_picture_are_refused(tmp_path):
    path = save(np.full((60, 80, 3), 255, np.uint8), tmp_path)
    with pytest.raises(OptionError, match="magic"):
        read_plan(path, method="magic")
    with pytest.raises(PlanError, match="PDF"):
        read_plan(path, page=2)
    with pytest.raises(PlanError, match=r"nowhere\.png"):
        read_plan(tmp_path / "nowhere.png")


def draw_dxf(path: Path) -> None:
    """Two rooms of 4 m × 4 m with walls of 0.2 m, and a door of 0.9 m in the wall between them; millimetres."""
    ezdxf = pytest.importorskip("ezdxf", reason="pianta[cad] is not installed")
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    space, on_wall = document.modelspace(), {"layer": "A-WALL"}
    # Faces of the walls: outside, left room, right room; the door is a gap in the wall from 4000 to 4200.
    for left, bottom, right, top in ((-200, -200, 8400, 4200), (0, 0, 4000, 4000), (4200, 0, 8200, 4000)):
        corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
        space.add_lwpolyline(corners, close=True, dxfattribs=on_wall)
    block = document.blocks.new("Door")
    block.add_line((0, 0), (0, 900))
    block.add_arc((0, 0), 900, 0, 90)
    space.add_blockref("Door", (4100, 1000), dxfattribs={"rotation": 90, "layer": "A-DOOR"})
    space.add_text("Büro", height=300).set_placement((1200, 2000))
    space.add_text("Labor", height=300).set_placement((5500, 2000))
    document.saveas(path)


@pytest.mark.slow
def test_a_dxf_is_read_with_its_names_doors_and_units(tmp_path):
    draw_dxf(tmp_path / "plan.dxf")
    plan_floor = only_floor(read_plan(tmp_path / "plan.dxf"))
    assert plan_floor.scale.source == "the units of the file"
    rooms = {str(room.name): room for room in plan_floor.floor.rooms}
    assert sorted(rooms) == ["Büro", "Labor"]
    assert [room.polygon.area for room in rooms.values()] == pytest.approx([16.8, 16.8], abs=1.5)
    (door,) = plan_floor.floor.doors
    assert door.room_ids == tuple(sorted(room.id for room in rooms.values()))
    assert door.width == pytest.approx(0.9, abs=0.05)
    assert plan_floor.floor.source == "plan.dxf"


def test_without_a_text_reader_the_plan_is_read_with_a_warning(tmp_path, monkeypatch):
    monkeypatch.setattr(plan_reading, "text_reader_available", lambda: False)
    path = save(draw_plan(THREE, px_per_metre=30).colors, tmp_path)
    with pytest.warns(PlanWarning, match=r"pianta\[plan\]"):
        plan_floor = only_floor(read_plan(path, resolution=1 / 30))
    assert [room.name for room in plan_floor.floor.rooms] == [None] * 4


@pytest.mark.slow
@pytest.mark.parametrize("legend", [False, True])
def test_names_in_rooms_and_in_a_legend_are_read(tmp_path, legend):
    pytest.importorskip("rapidocr", reason="pianta[plan] is not installed")
    texts = {1: "Corridor", 2: "Main office", 3: "Library", 4: "Kitchen"}
    plan = draw_plan(THREE, texts=texts, legend=legend, px_per_metre=40)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plan_floor = only_floor(read(plan, tmp_path, with_text=True, resolution=0.025))
    true_ids = match_rooms(plan_floor.floor, THREE, offset_of(plan))
    assert {true_ids[room.id]: room.name for room in plan_floor.floor.rooms} == texts


@pytest.mark.slow
def test_a_mirrored_plan_gives_a_warning_and_its_rooms_stay_where_they_are_drawn(tmp_path):
    pytest.importorskip("rapidocr", reason="pianta[plan] is not installed")
    texts = {2: "Main office", 3: "Library", 4: "Kitchen", 5: "Laboratory", 6: "Storage"}
    plan = draw_plan(FIVE, texts=texts, px_per_metre=40)
    upright = only_floor(read(plan, tmp_path, with_text=True, resolution=0.025)).floor
    with pytest.warns(PlanWarning, match=r"plan\.png' is mirrored.*; flip it"):
        mirrored = only_floor(read(plan.colors[:, ::-1], tmp_path, with_text=True, resolution=0.025)).floor
    width = plan.colors.shape[1] * 0.025
    middles = {room.name: room.polygon.centroid for room in mirrored.rooms if room.name}
    assert sorted(middles) == sorted(texts.values())
    for room in upright.rooms:
        if room.name:
            middle = room.polygon.centroid
            assert (width - middles[room.name].x, middles[room.name].y) == pytest.approx((middle.x, middle.y), abs=0.3)


@pytest.mark.slow
def test_the_resolution_of_an_svg_is_metres_per_unit(tmp_path):
    """Two rooms of 4 m side by side, in centimetres, that name neither walls nor doors."""
    pytest.importorskip("svgelements")
    outlines = "M50 50 H850 V450 H50 Z M450 50 V200 M450 290 V450"
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="900" height="500"><path d="{outlines}" {{}}/></svg>'
    path = tmp_path / "rooms.svg"
    path.write_text(svg.format('stroke="black" stroke-width="12" fill="none"'), encoding="utf-8")
    plan_floor = only_floor(read_plan(path, resolution=0.01, with_text=False))
    assert sum(room.polygon.area for room in plan_floor.floor.rooms) == pytest.approx(32, rel=0.1)


@pytest.mark.parametrize(("network_px", "drawn_px", "radii"), [(9.0, 12.0, [12.0] * 9 + [70.0]), (90.0, 90.0, [70.0])])
def test_curves_that_disagree_with_the_network_are_dropped(monkeypatch, network_px, drawn_px, radii):
    """Nine quarter circles of 12 pixels and one of 70, on a sheet of 3200; the network fits doors of 9, or of 90."""
    hinges = [(np.array((40.0, 100 * number)), 12.0 if number < 9 else 70.0) for number in range(10)]
    swings = [
        Swing(hinge, hinge + np.array((0, side)), hinge - np.array((side, 0)), side, 1.0) for hinge, side in hinges
    ]
    calls = []

    def fit_door_px(_, *, door_px, is_reliable, networks):
        calls.append((door_px, is_reliable))
        return network_px

    monkeypatch.setattr(sheet_scale, "find_swings", lambda _: tuple(swings))
    monkeypatch.setattr(sheet_scale, "fit_door_px", fit_door_px)
    sheet = Sheet(np.full((200, 3200, 3), 255, np.uint8))
    measured = sheet_scale.find_scale(sheet, sheet, (), networks=())
    assert calls == [(12.0, False)]
    assert measured.drawn_door_px == pytest.approx(drawn_px)
    assert [swing.radius for swing in measured.swings] == radii
    assert ("doors" in measured.scale.source) == (network_px == 9.0)
