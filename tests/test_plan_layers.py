"""Roles from names of layers in five languages, and jambs of doors from their pieces."""

import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pianta.errors import PlanError
from pianta.io.drawings import _layers as plan_layers
from pianta.io.drawings._drawing import ROLES, DrawnText
from pianta.io.drawings._layers import (
    DrawnPieces,
    bezier_points,
    chains_of_steps,
    check_plan_file,
    jambs_of_swings,
    jambs_of_symbol,
    role_of_names,
    touching_pieces,
)

Point = tuple[float, float]

NO_WALLS = KDTree(np.zeros((0, 2)))


def arc(hinge: Point, radius: float, start: float, end: float) -> NDArray[np.float64]:
    """Points of an arc of degrees, every 5."""
    angles = np.radians(np.linspace(start, end, round(abs(end - start) / 5) + 1))
    return np.asarray(hinge) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def line(*points: Point) -> NDArray[np.float64]:
    return np.array(points, float)


def ends(door: NDArray[np.float64]) -> list[Point]:
    """The ends of a door, sorted, to a hundredth."""
    return sorted((x, y) for x, y in (np.round(door, 2) + 0.0).tolist())


# An open leaf that points to the north, hinged at the origin; the door is to the east.
OPEN_LEAF = [line((0, 0), (0, 1)), arc((0, 0), 1, 0, 90)]


@pytest.mark.parametrize(
    ("names", "role"),
    [
        (["A-WALL-EXTR"], "wall"),
        (["Wall External"], "wall"),
        (["IfcWallStandardCase"], "wall"),
        (["INNERWALLS"], "wall"),
        (["muri_portanti"], "wall"),
        (["PARETI"], "wall"),
        (["Außenwände"], "wall"),
        (["TRENNWAND 2"], "wall"),
        (["cloisons"], "wall"),
        (["TABIQUES"], "wall"),
        (["A-DOOR"], "door"),
        (["door3"], "door"),
        (["SlidingDoor_900"], "door"),
        (["Porte"], "door"),
        (["TÜREN"], "door"),
        (["Doppeltür links"], "door"),
        (["SCHIEBETUEREN"], "door"),
        (["Strukturen"], "other"),
        (["Tu\u0308r_90"], "door"),
        (["puertas interiores"], "door"),
        (["A-GLAZ"], "window"),
        (["FENSTER"], "window"),
        (["Fenêtres"], "window"),
        (["finestre"], "window"),
        (["ventana"], "window"),
        (["0"], "other"),
        ([""], "other"),
        (["indoor"], "other"),
        (["Outdoor area"], "other"),
        (["Türkis"], "other"),
        (["Wandschrank"], "other"),
        (["wallpaper"], "other"),
        (["Supporta"], "other"),
        (["A-DOOR-IDEN"], "other"),
        (["Wall dimensions"], "other"),
        (["Text Türen"], "other"),
        (["Furniture"], "other"),
        ([], "other"),
        (["path12", "Door Swing", "Wall"], "door"),
        (["Wall", "Door"], "wall"),
        (["wall with door"], "door"),
    ],
)
def test_roles_of_names(names, role):
    assert role_of_names(names) == role


@given(st.lists(st.text()))
def test_any_names_have_a_role(names):
    assert role_of_names(names) in ROLES


def test_an_open_leaf_decides_which_end_is_the_jamb():
    (door,) = jambs_of_symbol(OPEN_LEAF, walls=NO_WALLS)
    assert ends(door) == [(0, 0), (1, 0)]


def test_an_open_leaf_may_have_a_thickness():
    leaf = line((0, 0), (0, 1), (0.05, 1), (0.05, 0), (0, 0))
    (door,) = jambs_of_symbol([leaf, OPEN_LEAF[1]], walls=NO_WALLS)
    assert ends(door) == [(0, 0), (1, 0)]


@pytest.mark.parametrize(("wall", "jamb"), [((1, 0), (1, 0)), ((0, 1), (0, 1))])
@pytest.mark.parametrize("leaves", [[], [line((0, 0), (1, 0)), line((0, 0), (0, 1))]])
def test_a_wall_gives_the_jamb_without_an_open_leaf(wall, jamb, leaves):
    (door,) = jambs_of_symbol([*leaves, OPEN_LEAF[1]], walls=KDTree(line(wall, (5, 5))))
    assert ends(door) == sorted([(0, 0), jamb])


@pytest.mark.parametrize(("axis", "jamb"), [((1, 0), (1, 0)), ((0, -1), (0, 1))])
def test_the_axis_of_a_symbol_gives_the_jamb_as_a_last_resort(axis, jamb):
    (door,) = jambs_of_symbol([OPEN_LEAF[1]], axis=np.array(axis, float), walls=NO_WALLS)
    assert ends(door) == sorted([(0, 0), jamb])


def test_two_swings_that_meet_are_a_double_door():
    other = [line((2, 0), (2, 1)), arc((2, 0), 1, 180, 90)]
    (door,) = jambs_of_symbol([*OPEN_LEAF, *other], walls=NO_WALLS)
    assert ends(door) == [(0, 0), (2, 0)]


def test_swings_to_both_sides_are_one_door():
    """Two leaves that swing both ways, and one leaf that swings both ways."""
    both = [arc((hinge, 0), 1, start, end) for hinge, start in ((0, 0), (2, 180)) for end in (start - 90, start + 90)]
    (double,) = jambs_of_symbol(both, axis=np.array([1.0, 0]), walls=NO_WALLS)
    assert ends(double) == [(0, 0), (2, 0)]
    (single,) = jambs_of_symbol(both[:2], axis=np.array([1.0, 0]), walls=NO_WALLS)
    assert ends(single) == [(0, 0), (1, 0)]


def test_neighbours_that_share_a_hinge_are_two_doors():
    other = [line((0, 0), (0, 1)), arc((0, 0), 1, 180, 90)]
    doors = jambs_of_symbol([*OPEN_LEAF, *other], walls=NO_WALLS)
    assert [ends(door) for door in doors] == [[(0, 0), (1, 0)], [(-1, 0), (0, 0)]]


def test_a_door_without_swing_is_the_longer_side_of_its_box():
    leaf = line((3, 2), (3, 4), (3.1, 4), (3.1, 2), (3, 2))
    (door,) = jambs_of_symbol([leaf], walls=NO_WALLS)
    assert ends(door) == [(3.05, 2), (3.05, 4)]
    (square,) = jambs_of_symbol([line((0, 0), (0, 1), (1, 1))], axis=np.array([1.0, 0]), walls=NO_WALLS)
    assert ends(square) == [(0, 0.5), (1, 0.5)]


@pytest.mark.parametrize(
    "piece",
    [
        arc((0, 0), 1, 0, 360),
        arc((0, 0), 1, 0, 45),
        arc((0, 0), 1, 0, 180),
        line((0, 0), (0, 1), (0.1, 1), (0.1, 0), (0, 0)),
        line((0, 0), (1, 0)),
        line(*[(0, 0)] * 6),
        line(*[(x, 0) for x in range(8)]),
    ],
)
def test_other_arcs_are_no_swings(piece):
    assert jambs_of_swings([piece], walls=NO_WALLS) == []


def test_no_pieces_and_a_point_are_no_door():
    assert jambs_of_symbol([], walls=NO_WALLS) == []
    assert jambs_of_symbol([line((1, 1), (1, 1))], walls=NO_WALLS) == []


@given(
    angle=st.floats(-180, 180),
    size=st.floats(1e-3, 1e4),
    x=st.floats(-1e6, 1e6),
    y=st.floats(-1e6, 1e6),
    mirrored=st.booleans(),
)
def test_a_door_does_not_depend_on_its_pose_and_scale(angle, size, x, y, mirrored):
    """Turned, mirrored, scaled and moved, within the precision of floats for a small door far away."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) * size
    turn[:, 0] *= -1 if mirrored else 1
    (door,) = jambs_of_symbol([piece @ turn.T + (x, y) for piece in OPEN_LEAF], walls=NO_WALLS)
    expected = line((0, 0), (1, 0)) @ turn.T + (x, y)
    assert np.abs(door - expected).max() < 1e-6 * size + 1e-7


def test_touching_pieces_are_groups_in_the_order_drawn():
    pieces = [line((0, 0), (1, 0)), line((5, 0), (6, 0)), line((1, 0), (1, 1)), line((1, 1), (2, 1))]
    groups = touching_pieces(pieces)
    assert [[piece.tolist() for piece in group] for group in groups] == [
        [pieces[index].tolist() for index in members] for members in ((0, 2, 3), (1,))
    ]
    assert touching_pieces([]) == []


def test_lines_and_curves_of_a_path_become_chains_of_their_own():
    curve = bezier_points(line((1, 0), (2, 0), (2, 1), (2, 2)))
    assert curve[[0, -1]].tolist() == [[1, 0], [2, 2]]
    chains = list(chains_of_steps(np.zeros(2), [line((1, 0)), curve[1:], line((3, 2)), line((3, 5))]))
    assert [len(chain) for chain in chains] == [2, len(curve), 3]
    assert [chain[0].tolist() for chain in chains] == [[0, 0], [1, 0], [2, 2]]
    assert chains[2].tolist() == [[2, 2], [3, 2], [3, 5]]


def test_an_area_with_a_hole_becomes_outlines_without():
    pieces = DrawnPieces(Path("a.dxf"))
    ring = shapely.box(0, 0, 10, 10).difference(shapely.box(2, 2, 8, 8))
    pieces.add_fill([np.array(shapely.get_coordinates(part)) for part in (ring.exterior, *ring.interiors)], "other")
    outlines = [shapely.Polygon(outline) for outline in pieces.fills]
    assert shapely.union_all(outlines).symmetric_difference(ring).area < 1e-9
    assert pieces.lines == 0


def test_a_filled_wall_names_walls_by_its_outline():
    pieces = DrawnPieces(Path("a.dxf"))
    pieces.add_fill([line((0, 0), (1, 0), (1, 1))], "wall")
    drawing = pieces.drawing([])
    assert drawing.roles.tolist() == [ROLES.index("wall")] * 3
    assert (len(drawing.fills), drawing.doors.shape) == (1, (0, 2, 2))


def test_pieces_become_a_drawing():
    pieces = DrawnPieces(Path("folder/a.dxf"))
    assert pieces.add_chain(line((0, 0), (1, 0), (1, 0), (1, 2)), "wall", width=0.2)
    assert pieces.add_chain(line((5, 5), (6, 6)), "other")
    assert not pieces.add_chain(line((1, 1), (1, 1)), "wall")
    assert not pieces.add_chain(line((1, np.nan), (1, 1)), "wall")
    assert not pieces.add_chain(line((1, 1e13), (1, 1)), "wall")
    pieces.add_text(DrawnText("Office", 1, 1, 0.2))
    pieces.add_text(DrawnText("  ", 1, 1, 0.2))
    pieces.add_text(DrawnText("nowhere", np.inf, 1, 0.2))
    drawing = pieces.drawing([line((0, 0), (0, 1))], metres_per_unit=0.001)
    assert drawing.lines.tolist() == [[[0, 0], [1, 0]], [[1, 0], [1, 2]], [[5, 5], [6, 6]]]
    assert (drawing.roles.tolist(), drawing.widths.tolist()) == ([0, 0, 3], [0.2, 0.2, 0])
    assert drawing.doors.tolist() == [[[0, 0], [0, 1]]]
    assert [text.text for text in drawing.texts] == ["Office"]
    assert (drawing.metres_per_unit, drawing.source) == (0.001, "a.dxf")
    assert pieces.wall_ends().data.tolist() == [[0, 0], [1, 0], [1, 2]]


def test_numbers_beyond_the_limits_are_refused(monkeypatch):
    monkeypatch.setattr(plan_layers, "MAX_LINES", 3)
    monkeypatch.setattr(plan_layers, "MAX_TEXTS", 1)
    pieces = DrawnPieces(Path("a.dxf"))
    pieces.add_chain(line((0, 0), (1, 0), (2, 0)), "other")
    with pytest.raises(PlanError, match="lines"):
        pieces.add_chain(line((0, 0), (1, 0), (2, 0)), "other")
    pieces.add_text(DrawnText("a", 0, 0, 1))
    with pytest.raises(PlanError, match="texts"):
        pieces.add_text(DrawnText("b", 0, 0, 1))


def test_missing_and_too_large_files_are_refused(tmp_path):
    path = tmp_path / "a.dxf"
    with pytest.raises(PlanError, match=re.escape(str(path))):
        check_plan_file(path, max_bytes=10)
    path.write_bytes(b"12345678901")
    with pytest.raises(PlanError, match="bytes"):
        check_plan_file(path, max_bytes=10)
    assert check_plan_file(path, max_bytes=11) == path
