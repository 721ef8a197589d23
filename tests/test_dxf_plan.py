"""DXFs are read as drawings: blocks resolved, roles by layer, doors from jamb to jamb, units of the file."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pianta.errors import PlanError
from pianta.io.drawings import dxf as dxf_plan
from pianta.io.drawings._drawing import ROLES, PlanDrawing, Role
from pianta.io.drawings.dxf import read_dxf_plan
from tests.mutation import mutated, refused_in_one_line

ezdxf = pytest.importorskip("ezdxf", reason="pianta[cad] is not installed")

ON_WALL, ON_DOOR = {"layer": "A-WALL"}, {"layer": "A-DOOR"}
# Entities without sections around them, as in files of small programs.
BARE = "0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n"
BARE_LINE = "0\nLINE\n8\nWALL\n10\n0\n20\n0\n11\n4\n21\n3\n"


def new_document(units: int = 4) -> Any:
    """An empty document, in millimetres by default, whose block Door is 900 wide, hinged at its base point."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = units
    block = document.blocks.new("Door")
    block.add_line((0, 0), (0, 900))
    block.add_arc((0, 0), 900, 0, 90)
    return document


def read(document: Any, tmp_path: Path, **save: str) -> PlanDrawing:
    document.saveas(tmp_path / "plan.dxf", **save)
    return read_dxf_plan(tmp_path / "plan.dxf")


def ends(door: NDArray[np.float64]) -> list[tuple[float, float]]:
    """The rounded ends of a door, sorted; arcs are chains, so their middle is only near the hinge."""
    return sorted((x, y) for x, y in (np.round(door) + 0.0).tolist())


def lines_of(drawing: PlanDrawing, role: Role = "other") -> list[list[list[float]]]:
    lines: list[list[list[float]]] = drawing.lines[drawing.roles == ROLES.index(role)].tolist()
    return lines


@pytest.mark.parametrize("fmt", ["asc", "bin"])
def test_two_rooms_with_a_door_and_their_names(tmp_path, fmt):
    document = new_document()
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (8000, 0), (8000, 4000), (0, 4000)], close=True, dxfattribs=ON_WALL)
    space.add_line((4000, 0), (4000, 1000), dxfattribs=ON_WALL)
    space.add_line((4000, 1900), (4000, 4000), dxfattribs=ON_WALL)
    space.add_blockref("Door", (4000, 1000), dxfattribs={"rotation": 90})
    space.add_text("Büro", height=200).set_placement((1000, 2000))
    drawing = read(document, tmp_path, fmt=fmt)
    outline = [[[0, 0], [8000, 0]], [[8000, 0], [8000, 4000]], [[8000, 4000], [0, 4000]], [[0, 4000], [0, 0]]]
    wall = [[[4000, 0], [4000, 1000]], [[4000, 1900], [4000, 4000]]]
    assert lines_of(drawing, "wall") == outline + wall
    assert [ends(door) for door in drawing.doors] == [[(4000, 1000), (4000, 1900)]]
    assert (drawing.metres_per_unit, drawing.source) == (0.001, "plan.dxf")
    (text,) = drawing.texts
    assert (text.text, text.height, text.angle) == ("Büro", 200, 0)
    assert (text.x, text.y) == pytest.approx((1000 + 4 * 0.85 * 200 / 2, 2100))


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ({}, [(1000, 0), (1900, 0)]),
        ({"rotation": 180}, [(100, 0), (1000, 0)]),
        ({"rotation": 270}, [(1000, -900), (1000, 0)]),
        ({"xscale": -1}, [(100, 0), (1000, 0)]),
        ({"xscale": 2, "yscale": 2}, [(1000, 0), (2800, 0)]),
        ({"xscale": -1, "rotation": 90}, [(1000, -900), (1000, 0)]),
    ],
)
@pytest.mark.parametrize("depth", [1, 3])
def test_a_block_of_a_door_is_one_door_in_any_placement(tmp_path, attributes, expected, depth):
    """Also within blocks of other names, which are moved and scaled back."""
    document = new_document()
    space = document.modelspace()
    for level in range(1, depth):
        block = document.blocks.new(f"Wing {level}")
        space.add_blockref(block.name, (-100, 0), dxfattribs={"xscale": 0.5, "yscale": 0.5, "zscale": 0.5})
        space = block
    factor = 2 ** (depth - 1)
    scaled = {name: value * factor for name, value in attributes.items() if name.endswith("scale")}
    scaled = {"xscale": factor, "yscale": factor, **scaled, **{k: v for k, v in attributes.items() if k == "rotation"}}
    shift = sum(100 * 2**level for level in range(1, depth))
    space.add_blockref("Door", (1000 * factor + shift, 0), dxfattribs=scaled)
    assert [ends(door) for door in read(document, tmp_path).doors] == [expected]


def test_a_block_without_a_swing_is_a_door_along_its_longer_side(tmp_path):
    document = new_document()
    block = document.blocks.new("puerta corredera")
    block.add_lwpolyline([(0, -50), (1200, -50), (1200, 50), (0, 50)], close=True)
    document.modelspace().add_blockref(block.name, (0, 0), dxfattribs={"rotation": 90})
    assert [ends(door) for door in read(document, tmp_path).doors] == [[(0, 0), (0, 1200)]]


def test_a_block_on_a_layer_of_doors_is_one_door_and_nested_blocks_are_its_parts(tmp_path):
    document = new_document()
    block = document.blocks.new("B17")
    block.add_blockref("Door", (0, 0))
    document.modelspace().add_blockref("B17", (0, 0), dxfattribs=ON_DOOR)
    assert [ends(door) for door in read(document, tmp_path).doors] == [[(0, 0), (900, 0)]]


def test_loose_quarter_circles_on_a_layer_of_doors_are_doors(tmp_path):
    """The leaf decides the jamb of the first door, the wall that of the second; a single line is no door."""
    document = new_document()
    space = document.modelspace()
    space.add_arc((0, 0), 800, 0, 90, dxfattribs=ON_DOOR)
    space.add_line((0, 0), (800, 0), dxfattribs=ON_DOOR)
    space.add_arc((5000, 0), 800, 90, 180, dxfattribs=ON_DOOR)
    space.add_line((4200, 0), (3000, 0), dxfattribs=ON_WALL)
    space.add_line((9000, 0), (9000, 800), dxfattribs=ON_DOOR)
    space.add_arc((20000, 0), 800, 0, 90)
    doors = [ends(door) for door in read(document, tmp_path).doors]
    assert doors == [[(0, 0), (0, 800)], [(4200, 0), (5000, 0)]]


def test_an_array_of_blocks_is_placed_in_rows_and_columns(tmp_path):
    document = new_document()
    grid = {"row_count": 2, "row_spacing": 5000, "column_count": 2, "column_spacing": 2000}
    document.modelspace().add_blockref("Door", (0, 0), dxfattribs=grid)
    hinges = {ends(door)[0] for door in read(document, tmp_path).doors}
    assert hinges == {(0, 0), (2000, 0), (0, 5000), (2000, 5000)}


def test_curves_become_chains_on_them(tmp_path):
    document = new_document()
    space = document.modelspace()
    space.add_circle((0, 0), 100, dxfattribs={"layer": "Wall circle"})
    space.add_ellipse((1000, 0), (100, 0), 0.5, dxfattribs={"layer": "Door ellipse"})
    space.add_spline([(5000, 0), (5100, 100), (5200, 0)], dxfattribs={"layer": "Window spline"})
    space.add_lwpolyline([(9000, 0, 1), (9200, 0, 0), (9200, -50, 0)], format="xyb")
    drawing = read(document, tmp_path)
    circle, ellipse = (np.array(lines_of(drawing, role)) for role in ("wall", "door"))
    assert np.hypot(circle[..., 0], circle[..., 1]) == pytest.approx(100, rel=1e-3)
    assert np.hypot(ellipse[..., 0] - 1000, ellipse[..., 1] * 2) == pytest.approx(100, rel=1e-3)
    spline = np.array(lines_of(drawing, "window"))
    assert np.hypot(*np.moveaxis(spline - (5100, 100), -1, 0)).min() < 5
    bulge = np.array(lines_of(drawing))
    assert np.hypot(bulge[:-1, :, 0] - 9100, bulge[:-1, :, 1]) == pytest.approx(100, rel=1e-3)
    assert bulge[:-1, :, 1].max() <= 1e-6, "a positive bulge lies to the right of its chord"
    assert bulge[-1] == pytest.approx(np.array([[9200, 0], [9200, -50]]))


def test_widths_of_polylines_are_kept(tmp_path):
    document = new_document()
    document.modelspace().add_lwpolyline([(0, 0), (10, 0)], dxfattribs={"const_width": 200, **ON_WALL})
    assert read(document, tmp_path).widths.tolist() == [200]


def test_dark_areas_and_walls_are_filled_and_others_are_not(tmp_path):
    document = new_document()
    space = document.modelspace()
    space.add_solid([(0, 0), (10, 0), (0, 10), (10, 10)])
    for color, layer, pattern in ((2, "0", ""), (2, "A-WALL", ""), (8, "0", ""), (7, "A-DOOR", ""), (7, "0", "ANSI31")):
        hatch = space.add_hatch(color=color, dxfattribs={"layer": layer})
        if pattern:
            hatch.set_pattern_fill(pattern)
        start = 100 * len(space)
        for x, y, width in ((start, 0, 90), (start + 30, 30, 30)):
            hatch.paths.add_polyline_path([(x, y), (x + width, y), (x + width, y + width), (x, y + width)])
    fills = shapely.union_all([shapely.Polygon(outline) for outline in read(document, tmp_path).fills])
    rings = [shapely.box(x, 0, x + 90, 90).difference(shapely.box(x + 30, 30, x + 60, 60)) for x in (300, 400)]
    assert fills.symmetric_difference(shapely.union_all([shapely.box(0, 0, 10, 10), *rings])).area < 1e-6


def test_frozen_and_switched_off_layers_are_left_out(tmp_path):
    """Entities on layer 0 of a block are on the layer of the block; freezing that layer hides the whole block."""
    document = new_document()
    document.layers.add("frozen").freeze()
    document.layers.add("off").off()
    block = document.blocks.new("part")
    block.add_line((0, 0), (1, 0))
    block.add_line((0, 0), (2, 0), dxfattribs={"layer": "own"})
    space = document.modelspace()
    for layer in ("frozen", "off"):
        space.add_line((0, 0), (9, 0), dxfattribs={"layer": layer})
        space.add_text("hidden", dxfattribs={"layer": layer})
        space.add_blockref("part", (0, 0), dxfattribs={"layer": layer})
    space.add_line((0, 0), (8, 0), dxfattribs={"invisible": 1})
    document.layout("Layout1").add_line((0, 0), (7, 0))
    drawing = read(document, tmp_path)
    assert drawing.lines.tolist() == [[[0, 0], [2, 0]]]
    assert drawing.texts == ()


def test_texts_are_placed_by_their_middle(tmp_path):
    from ezdxf.enums import TextEntityAlignment

    document = new_document()
    space = document.modelspace()
    space.add_line((0, 0), (1, 0))
    space.add_text("upright", height=100, rotation=90).set_placement((0, 0))
    space.add_text("middle", height=100).set_placement((500, 500), align=TextEntityAlignment.MIDDLE_CENTER)
    space.add_text("right", height=100).set_placement((500, 500), align=TextEntityAlignment.TOP_RIGHT)
    space.add_mtext("{\\fArial;Main}\\Poffice", {"char_height": 100, "insert": (0, 900), "attachment_point": 1})
    block = document.blocks.new("tag")
    block.add_attdef("NUMBER", (0, 0))
    space.add_blockref("tag", (0, 0)).add_attrib("NUMBER", "204", (700, 0)).dxf.height = 100
    placed = {text.text: (text.x, text.y, text.angle) for text in read(document, tmp_path).texts}
    assert placed == {
        "upright": pytest.approx((-50, 7 * 42.5, np.pi / 2)),
        "middle": pytest.approx((500, 500, 0)),
        "right": pytest.approx((500 - 5 * 42.5, 450, 0)),
        "Main office": pytest.approx((6 * 42.5, 900 - (100 + 160) / 2, 0)),
        "204": pytest.approx((700 + 3 * 42.5, 50, 0)),
    }


@pytest.mark.parametrize(
    ("units", "metres"), [(0, None), (1, 0.0254), (2, 0.3048), (4, 0.001), (5, 0.01), (6, 1.0), (14, 0.1), (17, None)]
)
def test_units_are_those_of_the_header(tmp_path, units, metres):
    document = new_document(units)
    document.modelspace().add_line((0, 0), (1, 0))
    assert read(document, tmp_path).metres_per_unit == metres


def test_a_file_without_header_is_read_and_has_no_units(tmp_path):
    path = tmp_path / "bare.dxf"
    path.write_text(BARE.format(BARE_LINE))
    drawing = read_dxf_plan(path)
    assert (drawing.lines.tolist(), drawing.roles.tolist()) == ([[[0, 0], [4, 3]]], [ROLES.index("wall")])
    assert drawing.metres_per_unit is None


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    path = tmp_path / "a.dxf"
    path.write_text(BARE)
    with pytest.raises(PlanError, match=r"pianta\[cad\]"):
        read_dxf_plan(path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"\x89PNG\r\n\x1a\n0000", "DXF"),
        (b"AC1032\x00\x00", "DWG"),
        (b"0\nSECTION\nHEADER\nno number\n0\nEOF", "DXF"),
        (BARE.format(BARE_LINE)[:-10].encode(), "EOF"),
        (BARE.format("").encode(), "layout"),
    ],
)
def test_files_without_a_plan_are_refused_in_one_line(tmp_path, content, message):
    path = tmp_path / "a.dxf"
    path.write_bytes(content)
    with pytest.raises(PlanError, match=message) as caught:
        read_dxf_plan(path)
    assert "\n" not in str(caught.value)


def bomb(levels: int, copies: int) -> Any:
    """Blocks of blocks, each placed many times."""
    document = ezdxf.new()
    document.blocks.new("B0").add_line((0, 0), (1, 1))
    for level in range(1, levels):
        block = document.blocks.new(f"B{level}")
        for _ in range(copies):
            block.add_blockref(f"B{level - 1}", (0, 0))
    document.modelspace().add_blockref(f"B{levels - 1}", (0, 0))
    return document


def test_blocks_that_multiply_without_end_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(dxf_plan, "MAX_ENTITIES", 500)
    with pytest.raises(PlanError, match="500"):
        read(bomb(10, 10), tmp_path)
    with pytest.raises(PlanError, match="16"):
        read(bomb(20, 1), tmp_path)
    grid = {"row_count": 30, "row_spacing": 1, "column_count": 30, "column_spacing": 1}
    document = new_document()
    document.modelspace().add_blockref("Door", (0, 0), dxfattribs=grid)
    with pytest.raises(PlanError, match="900"):
        read(document, tmp_path)


def test_a_block_within_itself_is_refused_or_left_out(tmp_path):
    document = bomb(1, 1)
    document.blocks.get("B0").add_blockref("B0", (0, 0))
    with pytest.raises(PlanError, match="deep"):
        read(document, tmp_path)


def test_blocks_without_content_are_counted(tmp_path, monkeypatch):
    """Arrays of arrays of nothing took minutes: 30 × 30 blocks with 30 × 30 blocks."""
    monkeypatch.setattr(dxf_plan, "MAX_ENTITIES", 1000)
    grid = {"row_count": 30, "row_spacing": 1, "column_count": 30, "column_spacing": 1}
    document = new_document()
    document.modelspace().add_line((0, 0), (1, 1))
    document.blocks.new("empty")
    document.blocks.new("array").add_blockref("empty", (0, 0), dxfattribs=grid)
    document.modelspace().add_blockref("array", (0, 0), dxfattribs=grid)
    with pytest.raises(PlanError, match="draws more than 1000 things"):
        read(document, tmp_path)


def test_a_spline_with_very_many_points_goes_straight_from_one_to_the_next(tmp_path, monkeypatch):
    """Its curve would take gigabytes."""
    monkeypatch.setattr(dxf_plan, "MAX_FIT_POINTS", 3)
    document = new_document()
    document.modelspace().add_spline([(0, 0), (10, 5), (20, 0), (30, 5)])
    lines = [[[0, 0], [10, 5]], [[10, 5], [20, 0]], [[20, 0], [30, 5]]]
    assert read(document, tmp_path).lines.tolist() == lines


def test_texts_of_megabytes_are_cut(tmp_path):
    document = new_document()
    space = document.modelspace()
    space.add_line((0, 0), (9, 0))
    space.add_text("A" * 2_000_000, height=1)
    space.add_mtext("B" * 2_000_000, {"char_height": 1})
    document.blocks.new("tag").add_attdef("NAME", (0, 0))
    space.add_blockref("tag", (0, 0)).add_attrib("NAME", "C" * 2_000_000)
    assert [text.text for text in read(document, tmp_path).texts] == ["A" * 5000, "B" * 5000, "C" * 5000]


def test_a_count_of_hundreds_of_digits_is_shortened(tmp_path):
    array = f"0\nINSERT\n8\n0\n2\nnowhere\n10\n0\n20\n0\n70\n{'9' * 400}\n71\n1000\n44\n1\n45\n1\n"
    path = tmp_path / "array.dxf"
    path.write_text(BARE.format(BARE_LINE + array))
    with pytest.raises(PlanError, match="repeats a block 1000000000000000 and more times") as caught:
        read_dxf_plan(path)
    assert len(str(caught.value)) < 300 + len(str(path))


def test_a_block_beyond_the_range_of_numbers_is_skipped_and_counted(tmp_path):
    document = new_document()
    space = document.modelspace()
    space.add_line((0, 0), (9, 0))
    space.add_blockref("Door", (1e300, 0), dxfattribs={"xscale": 1e300})
    drawing = read(document, tmp_path)
    assert drawing.lines.tolist() == [[[0, 0], [9, 0]]]
    assert drawing.skipped == {"INSERT": 1}


@settings(max_examples=60)
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path_factory, data):
    arc = "0\nARC\n8\nDOOR\n10\n0\n20\n0\n40\n1\n50\n0\n51\n90\n"
    text = "0\nTEXT\n8\n0\n10\n0\n20\n0\n40\n1\n1\nOffice\n"
    polyline = "0\nLWPOLYLINE\n8\nWALL\n90\n2\n70\n1\n10\n0\n20\n0\n42\n1\n10\n2\n20\n0\n"
    path = tmp_path_factory.getbasetemp() / "damaged.dxf"
    path.write_bytes(data.draw(mutated(BARE.format(BARE_LINE + arc + text + polyline).encode())))
    with refused_in_one_line():
        read_dxf_plan(path)
