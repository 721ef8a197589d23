"""Closed outlines with texts are the rooms of a DXF, with their corners; other outlines are not."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import Polygon, box

import pianta
from pianta.errors import OptionError, PlanError, PlanWarning
from pianta.plan.read_plan import PlanReading, read_plan
from tests.command_line import run_pianta

ezdxf = pytest.importorskip("ezdxf", reason="pianta[cad] is not installed")

# Number, name, and left, bottom, right, top in metres: two rows of rooms along a corridor, walls of 0.15 m between.
ROOMS = {
    ("0.01", "Office"): (0, 0, 4, 5),
    ("0.02", "Office"): (4.15, 0, 9, 5),
    ("0.03", "Meeting"): (9.15, 0, 15, 5),
    ("0.00", "Corridor"): (0, 5.15, 15, 7),
    ("0.04", "WC"): (0, 7.15, 3, 10),
    ("0.05", "Storage"): (3.15, 7.15, 15, 10),
}
METRES, MILLIMETRES = 6, 4
FACTORS = {0: 1000, 1: 1 / 0.0254, 2: 1 / 0.3048, 4: 1000, 5: 100, 6: 1}


def new_document(units: int = METRES) -> Any:
    document = ezdxf.new()
    document.header["$INSUNITS"] = units
    return document


def add_outlines(
    document: Any, *, layer: str = "A-AREA", factor: float = 1, shift: tuple[float, float] = (0, 0)
) -> None:
    for bounds in ROOMS.values():
        add_box(document.modelspace(), bounds, layer, factor=factor, shift=shift)


def add_box(space: Any, bounds: Any, layer: str, *, factor: float = 1, shift: tuple[float, float] = (0, 0)) -> None:
    corners = np.array(box(*bounds).exterior.coords)[:-1]
    space.add_lwpolyline((corners + shift) * factor, close=True, dxfattribs={"layer": layer})


def add_names(document: Any, *, factor: float = 1, shift: tuple[float, float] = (0, 0)) -> None:
    for (number, name), bounds in ROOMS.items():
        x, y = (np.array([bounds[0] + 0.5, (bounds[1] + bounds[3]) / 2]) + shift) * factor
        text = document.modelspace().add_text(f"{number} {name}", height=0.2 * factor, dxfattribs={"layer": "TEXT"})
        text.set_placement((x, y))


def read(document: Any, tmp_path: Path, **options: Any) -> PlanReading:
    document.saveas(tmp_path / "plan.dxf")
    return read_plan(tmp_path / "plan.dxf", **options)


def bounds_by_title(plan: PlanReading) -> dict[str | None, tuple[float, ...]]:
    """The bounds of each room that is a rectangle."""
    (placed,) = plan.floors
    assert all(shapely.get_num_coordinates(room.polygon) == 5 for room in placed.floor)
    return {title_of(room): tuple(np.round(room.polygon.bounds, 6).tolist()) for room in placed.floor}


def title_of(room: pianta.Room) -> str | None:
    return room.title


TRUE_BOUNDS = {f"{number} {name}": tuple(map(float, bounds)) for (number, name), bounds in ROOMS.items()}


@pytest.mark.parametrize("units", sorted(FACTORS))
@pytest.mark.parametrize("layer", ["A-AREA", "ACAD_Raumpolygon", "vani_utili", "Pièces", "0", "XK-77"])
def test_rooms_are_the_outlines_whatever_the_layer_and_the_unit(tmp_path, layer, units):
    """Without a unit, areas written in the rooms give it."""
    document = new_document(units)
    add_outlines(document, layer=layer, factor=FACTORS[units])
    add_names(document, factor=FACTORS[units])
    if not units:
        for bounds in ROOMS.values():
            area = f"{box(*bounds).area:.2f} m²"
            document.modelspace().add_text(area, height=150).set_placement(
                (bounds[0] * 1000 + 500, bounds[1] * 1000 + 300)
            )
    assert bounds_by_title(read(document, tmp_path)) == TRUE_BOUNDS


@pytest.mark.parametrize("width", [900, 90, 0.9, 35.4, 2.95])
def test_without_units_doors_give_the_unit(tmp_path, width):
    unit = {900: 1000, 90: 100, 0.9: 1, 35.4: 1 / 0.0254, 2.95: 1 / 0.3048}[width]
    document = new_document(0)
    add_outlines(document, factor=unit)
    add_names(document, factor=unit)
    block = document.blocks.new("X17")
    block.add_line((0, 0), (0, 1))
    block.add_arc((0, 0), 1, 0, 90)
    attributes = {"xscale": width, "yscale": width, "zscale": width}
    document.modelspace().add_blockref("X17", (1 * unit, 5.07 * unit), dxfattribs=attributes)
    plan = read(document, tmp_path)
    bounds = bounds_by_title(plan)
    assert bounds.keys() == TRUE_BOUNDS.keys()
    assert all(bounds[title] == pytest.approx(true_bounds, abs=1e-5) for title, true_bounds in TRUE_BOUNDS.items())
    (door,) = plan.floors[0].floor.doors
    joined = {title_of(plan.floors[0].floor[each]) for each in door.room_ids}
    assert (joined, door.kind) == ({"0.01 Office", "0.00 Corridor"}, "door")
    assert "door" in plan.floors[0].scale.source


def add_stamps(document: Any, *, nested: bool, **attributes: Any) -> None:
    """Stamps with attributes in Italian, in any placement; nested ones are blocks in blocks."""
    block = document.blocks.new("TIMBRO")
    for tag, line in (("NUMERO_VANO", 1.2), ("DENOMINAZIONE", -0.4), ("SUPERFICIE", -2)):
        block.add_attdef(tag, (0, line), dxfattribs={"height": 1})
    for number, ((room, name), bounds) in enumerate(ROOMS.items()):
        x, y = (bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2
        placement = {"xscale": 0.2, "yscale": 0.2, "layer": "TIMBRI", **attributes}
        space, insert = document.modelspace(), (x, y)
        if nested:
            space = document.blocks.new(f"WING{number}")
            document.modelspace().add_blockref(space.name, (x, y), dxfattribs={"rotation": 30})
            insert = (0, 0)
        reference = space.add_blockref("TIMBRO", insert, dxfattribs=placement)
        reference.add_auto_attribs(
            {"NUMERO_VANO": room, "DENOMINAZIONE": name, "SUPERFICIE": f"{box(*bounds).area:.2f}"}
        )


@pytest.mark.parametrize("nested", [False, True])
@pytest.mark.parametrize("attributes", [{}, {"rotation": 90}, {"xscale": -0.2}, {"xscale": 0.5, "yscale": 0.1}])
def test_stamps_name_rooms_in_any_placement(tmp_path, attributes, nested):
    document = new_document()
    add_outlines(document)
    add_stamps(document, nested=nested, **attributes)
    assert bounds_by_title(read(document, tmp_path)) == TRUE_BOUNDS


def test_a_text_with_formatting_is_read_as_it_looks(tmp_path):
    document = new_document()
    add_outlines(document)
    for (number, name), bounds in ROOMS.items():
        code = rf"{{\fArial|b1|i0;\H0.3;{number}}}\P{{\C1;{name}}}\P\H0.7x;{box(*bounds).area:.2f} m\U+00B2"
        attributes = {"insert": (bounds[0] + 0.2, bounds[3] - 0.2), "char_height": 0.2}
        document.modelspace().add_mtext(code, dxfattribs=attributes)
    assert bounds_by_title(read(document, tmp_path)) == TRUE_BOUNDS


@pytest.mark.parametrize("outline_type", ["polyline", "hatch", "hatch with polyline", "twice", "open with equal ends"])
def test_each_kind_of_outline_is_a_room_once(tmp_path, outline_type):
    document = new_document()
    space = document.modelspace()
    add_names(document)
    for bounds in ROOMS.values():
        corners = list(box(*bounds).exterior.coords)[:-1]
        if outline_type == "polyline":
            space.add_polyline2d(corners, close=True, dxfattribs={"layer": "R"})
        if outline_type.startswith("hatch"):
            hatch = space.add_hatch(dxfattribs={"layer": "R"})
            hatch.set_pattern_fill("ANSI31")
            hatch.paths.add_polyline_path(corners)
        if outline_type in {"hatch with polyline", "twice"}:
            space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "R2" if outline_type == "twice" else "R"})
        if outline_type == "twice":
            space.add_lwpolyline(corners[::-1], close=True, dxfattribs={"layer": "R"})
        if outline_type.startswith("open"):
            space.add_lwpolyline([*corners, corners[0]], dxfattribs={"layer": "R"})
    assert bounds_by_title(read(document, tmp_path)) == TRUE_BOUNDS


def test_round_rooms_have_the_area_of_their_curves(tmp_path):
    """A half circle by a bulge beside a rectangle, and a closed ellipse."""
    document = new_document()
    space = document.modelspace()
    space.add_lwpolyline(
        [(0, 0, 0), (4, 0, 1), (4, 4, 0), (0, 4, 0)], format="xyb", close=True, dxfattribs={"layer": "R"}
    )
    space.add_ellipse((-3.2, 2), (3, 0), 0.5, dxfattribs={"layer": "R"})
    for text, x in (("Hall", 1), ("Apse", -4)):
        space.add_text(text, height=0.3).set_placement((x, 2))
    (placed,) = read(document, tmp_path).floors
    areas = {room.title: room.polygon.area for room in placed.floor}
    assert areas == pytest.approx({"Hall": 16 + np.pi * 2**2 / 2, "Apse": np.pi * 3 * 1.5}, rel=2e-3)


def test_gross_areas_zones_and_furniture_are_no_rooms(tmp_path):
    document = new_document()
    space = document.modelspace()
    add_outlines(document, layer="NRF")
    add_names(document)
    add_box(space, (-0.3, -0.3, 15.3, 10.3), "NRF")
    space.add_text("BGF 165.4 m²", height=0.1).set_placement((0.2, 10.05))
    for number, bounds in enumerate([(-0.2, -0.2, 15.2, 5.1), (-0.2, 5.1, 15.2, 10.2)]):
        add_box(space, bounds, "ZONES")
        space.add_text(f"Zone {number}", height=0.1).set_placement((-0.18, bounds[1] + 0.05))
    for number in range(12):
        left, bottom = 0.4 + 1.2 * number, 1.0
        add_box(space, (left, bottom, left + 1.1, bottom + 0.7), "DESKS")
        space.add_text(f"D{number}", height=0.1).set_placement((left + 0.1, bottom + 0.2))
    assert bounds_by_title(read(document, tmp_path)) == TRUE_BOUNDS


def test_desks_with_numbers_alone_are_no_rooms(tmp_path):
    document = new_document()
    for number in range(12):
        add_box(document.modelspace(), (number * 1.6, 0, number * 1.6 + 1.6, 0.8), "A-FURN")
        document.modelspace().add_text(f"D{number}", height=0.1).set_placement((number * 1.6 + 0.2, 0.3))
    with pytest.raises(PlanError, match="shows no rooms"):
        read(document, tmp_path)


def test_a_corridor_around_rooms_has_a_hole_and_a_column_too(tmp_path):
    document = new_document()
    space = document.modelspace()
    add_box(space, (0, 0, 20, 20), "R")
    add_box(space, (2, 2, 18, 18), "R")
    add_box(space, (2.2, 2.2, 9.9, 17.8), "R")
    add_box(space, (10.1, 2.2, 17.8, 17.8), "R")
    add_box(space, (5, 5, 5.5, 5.5), "R")
    for text, x, y in (("1 Corridor", 0.2, 10), ("2 Lab", 4, 10), ("3 Lab", 12, 10)):
        space.add_text(text, height=0.2).set_placement((x, y))
    (placed,) = read(document, tmp_path).floors
    areas = {title_of(room): room.polygon.area for room in placed.floor}
    assert areas == pytest.approx({"1 Corridor": 400 - 256, "2 Lab": 7.7 * 15.6 - 0.25, "3 Lab": 7.7 * 15.6})


def test_floors_side_by_side_are_floors_of_their_own(tmp_path):
    document = new_document()
    for shift in ((0, 0), (20, 0)):
        add_outlines(document, shift=shift)
        add_names(document, shift=shift)
    with pytest.warns(PlanWarning, match="shows 2 floors"):
        plan = read(document, tmp_path)
    assert [len(placed.floor) for placed in plan.floors] == [len(ROOMS)] * 2


def test_rows_of_rooms_along_a_corridor_that_is_no_outline_are_one_floor(tmp_path):
    document = new_document()
    for (number, name), bounds in ROOMS.items():
        if name != "Corridor":
            add_box(document.modelspace(), bounds, "R")
            document.modelspace().add_text(f"{number} {name}", height=0.2).set_placement(
                (bounds[0] + 0.5, bounds[1] + 1)
            )
    (placed,) = read(document, tmp_path).floors
    assert len(placed.floor) == len(ROOMS) - 1


def test_a_border_without_a_wall_is_an_opening(tmp_path):
    """Two offices share a border that has no line of a wall, the others have; a gap of 1 m is an opening, too."""
    document = new_document()
    space = document.modelspace()
    for bounds, name in (((0, 0, 4, 5), "Kitchen"), ((4, 0, 9, 5), "Living"), ((0, 5.1, 9, 9), "Hall")):
        add_box(space, bounds, "R")
        space.add_text(name, height=0.2).set_placement((bounds[0] + 1, bounds[1] + 2))
    for start, end in ((0, 6), (7, 9)):
        space.add_line((start, 5), (end, 5), dxfattribs={"layer": "WAND"})
        space.add_line((start, 5.1), (end, 5.1), dxfattribs={"layer": "WAND"})
    (placed,) = read(document, tmp_path).floors
    names = {room.id: room.title for room in placed.floor}
    openings = {frozenset(names[each] for each in door.room_ids): door.width for door in placed.floor.doors}
    assert openings == pytest.approx({frozenset(["Kitchen", "Living"]): 5, frozenset(["Living", "Hall"]): 1}, abs=0.3)
    assert {door.kind for door in placed.floor.doors} == {"opening"}


def test_lines_around_names_are_rooms(tmp_path):
    """Walls of single lines that end at the face of another, in feet, in a file whose header says metres."""
    document = new_document()
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (40, 0), (40, 30), (0, 30), (0, 0)], dxfattribs={"layer": "W"})
    space.add_line((0.4, 15), (39.6, 15), dxfattribs={"layer": "W"})
    space.add_line((20, 15), (20, 29.6), dxfattribs={"layer": "W"})
    for text, x, y in (("BATH\\P20' x 15'", 10, 22), ("BEDROOM 2\\P20' x 15'", 30, 22), ("LIVING\\P40' x 15'", 20, 8)):
        space.add_mtext(text, dxfattribs={"insert": (x, y), "char_height": 1, "attachment_point": 5})
    (placed,) = read(document, tmp_path).floors
    areas = {room.title: room.polygon.area / 0.3048**2 for room in placed.floor}
    assert areas == pytest.approx({"BATH": 300, "BEDROOM 2": 300, "LIVING": 600})
    assert placed.scale.source == "the areas written in 3 rooms"


def test_notes_list_layers_and_skipped_entities(tmp_path):
    document = new_document()
    add_outlines(document)
    add_names(document)
    space = document.modelspace()
    space.add_line((0, -0.2), (15, -0.2), dxfattribs={"layer": "A-WALL"})
    space.add_3dface([(0, 0), (1, 0), (1, 1), (0, 1)])
    space.add_polyface()
    document.add_xref_def("other.dwg", "OTHER")
    space.add_blockref("OTHER", (0, 0))
    notes = read(document, tmp_path).notes
    assert notes[0] == "rooms: closed outlines of layer A-AREA 6, with the corners as drawn"
    assert notes[1] == "layers: walls A-WALL 1 line; other 24 lines"
    assert notes[2] == "skipped: 1 3DFACE, 1 POLYLINE, 1 external reference"


def test_chosen_layers_are_the_rooms_and_others_are_not(tmp_path):
    document = new_document()
    add_outlines(document, layer="FLAECHEN")
    add_names(document)
    add_box(document.modelspace(), (-0.3, -0.3, 15.3, 10.3), "BGF")
    (placed,) = read(document, tmp_path, room_layers=["bgf"]).floors
    assert [tuple(room.polygon.bounds) for room in placed.floor] == [(-0.3, -0.3, 15.3, 10.3)]
    with pytest.raises(PlanError, match=r"has no layer 'KELLER', it has 'BGF', 'FLAECHEN'"):
        read(document, tmp_path, room_layers=["KELLER"])


def test_layers_of_other_files_are_refused(tmp_path):
    (tmp_path / "plan.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    with pytest.raises(OptionError, match="no DXF"):
        read_plan(tmp_path / "plan.svg", wall_layers=["A-WALL"])


def test_a_floor_that_is_exported_comes_back_exactly(tmp_path):
    floor, _ = pianta.make_world("corridor")
    pianta.convert(floor, tmp_path / "floor.dxf", to="dxf")
    again = pianta.read(tmp_path / "floor.dxf", labels=False).floor
    assert len(again) == len(floor)
    for room in floor:
        same = max(again, key=lambda other: shapely.intersection(room.polygon, other.polygon).area)
        corners = shapely.get_num_coordinates(room.polygon)
        assert shapely.get_num_coordinates(same.polygon) == corners
        assert room.polygon.symmetric_difference(same.polygon).area < 1e-3 * room.polygon.length
    assert {door.rooms for door in again.doors} or not floor.doors


def test_the_command_prints_layers_and_takes_chosen_ones(tmp_path):
    document = new_document()
    add_outlines(document, layer="FLAECHEN")
    add_names(document)
    document.saveas(tmp_path / "plan.dxf")
    arguments = ["read", tmp_path / "plan.dxf", "-o", tmp_path / "out"]
    outcome = run_pianta(*arguments, "--room-layers", "FLAE*,XYZ")
    assert (outcome.code, "has no layer 'XYZ'" in outcome.err) == (2, True)
    assert not (tmp_path / "out").exists()
    outcome = run_pianta(*arguments, "--room-layers", "FLAE*", "--no-labels")
    assert (outcome.code, outcome.err) == (0, "")
    assert "rooms: closed outlines of layer FLAECHEN 6" in outcome.out
    assert "layers: other 24 lines" in outcome.out


def test_the_error_for_a_dwg_names_its_conversion(tmp_path):
    for name in ("plan.dxf", "plan.dwg"):
        (tmp_path / name).write_bytes(b"AC1032" + bytes(200))
        outcome = run_pianta("read", tmp_path / name, "-o", tmp_path / "out")
        assert (outcome.code, "is a DWG, convert it to DXF: in CAD by SAVEAS" in outcome.err) == (2, True)


@pytest.mark.parametrize("points", [400, 4000])
def test_outlines_that_cross_themselves_without_end_are_left_out(tmp_path, points):
    """All crossings of a random outline would fill the memory."""
    random = np.random.default_rng(1)
    document = new_document()
    add_outlines(document)
    add_names(document)
    document.modelspace().add_lwpolyline(random.uniform(0, 15, (points, 2)), close=True, dxfattribs={"layer": "A-AREA"})
    titles = {title_of(room) for room in read(document, tmp_path).floors[0].floor}
    assert len(titles & set(TRUE_BOUNDS)) >= len(TRUE_BOUNDS) - 1


def test_a_few_lines_that_enclose_nothing_are_refused_at_once(tmp_path, monkeypatch):
    """Without a network, which would look for walls at many scales."""
    monkeypatch.setattr("pianta.plan.read_plan.segment_sheet", lambda *_, **__: pytest.fail("the network ran"))
    document = new_document(0)
    for number in range(12):
        document.modelspace().add_line((number * 1e5, 0), (number * 1e5 + 9e4, 5e6))
    with pytest.raises(PlanError, match="its 12 lines enclose none"):
        read(document, tmp_path)


def test_polygon_areas_do_not_overlap(tmp_path):
    """A kiosk with its own outline stands in a hall."""
    document = new_document()
    space = document.modelspace()
    for bounds, name in (((0, 0, 10, 10), "Hall"), ((4, 4, 6, 6), "Kiosk"), ((10.2, 0, 15, 10), "Café")):
        add_box(space, bounds, "R")
        space.add_text(name, height=0.2).set_placement((bounds[0] + 0.5, bounds[1] + 0.5))
    (placed,) = read(document, tmp_path).floors
    areas = {room.title: room.polygon.area for room in placed.floor}
    assert areas == pytest.approx({"Hall": 96, "Kiosk": 4, "Café": 48})
    hall = next(room.polygon for room in placed.floor if room.name == "Hall")
    assert hall.equals(Polygon(box(0, 0, 10, 10).exterior, [box(4, 4, 6, 6).exterior]))
