"""Floors of homes, offices, wards and depots, their dense furniture, and the leaves of their doors."""

from typing import Literal

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label
from shapely import LineString, box, unary_union

from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta.worlds import layouts
from pianta.worlds.dense_furniture import furnish_densely
from pianta.worlds.door_leaves import draw_door_leaves
from pianta.worlds.floors import LABELLED_FLOOR_MAKERS, make_floor
from pianta.worlds.glass import draw_glass_walls
from pianta.worlds.homes import make_home_floor
from pianta.worlds.layouts import Layout, LayoutError
from pianta.worlds.scan import simulate_map
from pianta.worlds.workplaces import make_office_floor

names = st.sampled_from(sorted(LABELLED_FLOOR_MAKERS))
seeds = st.integers(0, 10_000)


@given(names, seeds)
@settings(max_examples=40, deadline=None)
def test_every_room_is_reachable_and_walls_part_all_rooms(name, seed):
    floor = make_floor(name, seed=seed)
    assert floor.source == f"{name}-{seed}"
    assert nx.is_connected(floor.graph())
    polygons = [room.polygon for room in floor.rooms]
    near = shapely.STRtree(polygons).query(polygons, "dwithin", 0.07)
    assert (near[0] == near[1]).all()


@given(names, seeds)
@settings(max_examples=40, deadline=None)
def test_every_door_is_in_the_wall_of_its_rooms_and_of_no_other(name, seed):
    floor = make_floor(name, seed=seed)
    for door in floor.doors:
        assert door.line.length == pytest.approx(door.width, abs=0.002)
        for room in floor.rooms:
            assert (door.line.distance(room.polygon) < 0.18) == (room.id in door.rooms)


def test_two_rooms_have_the_areas_that_their_walls_leave(monkeypatch):
    monkeypatch.setattr(layouts, "THICK_SHARE", 0)
    layout = Layout(np.random.default_rng(0), inner_wall=0.1, outer_wall=0.3)
    first, second = layout.add(box(0, 0, 4, 3), "BEDROOM"), layout.add(box(4, 0, 6, 3), "BATHROOM")
    layout.join(second, [first], 0.8)
    floor = layout.build("two")
    assert [room.polygon.area for room in floor.rooms] == pytest.approx([3.8 * 2.7, 1.8 * 2.7])
    assert [(door.rooms, set(shapely.get_coordinates(door.line)[:, 0])) for door in floor.doors] == [((1, 2), {4})]
    assert floor.doors[0].line.length == pytest.approx(0.8, abs=0.006)


def test_a_room_that_no_door_leads_to_is_refused():
    layout = Layout(np.random.default_rng(0))
    layout.add(box(0, 0, 4, 3), "BEDROOM")
    layout.add(box(4, 0, 6, 3), "BATHROOM")
    with pytest.raises(LayoutError, match="reached"):
        layout.build("two")


def test_floors_depend_only_on_the_seed():
    for name in LABELLED_FLOOR_MAKERS:
        first, again, other = (make_floor(name, seed=seed) for seed in (1, 1, 2))
        assert first == again
        assert first != other


@pytest.mark.parametrize("area", [25, 60, 120, 180])
def test_homes_have_the_given_area_and_rooms_of_usual_sizes(area):
    for seed in range(3):
        floor = make_home_floor(seed=seed, area=area)
        # Walls and oblique corners take a part of it, bays and cut corners change it a little.
        assert sum(room.polygon.area for room in floor.rooms) == pytest.approx(0.87 * area, rel=0.3)
        labels = [room.label for room in floor.rooms]
        assert {"LIVING ROOM", "KITCHEN", "BATHROOM"} <= set(labels)
        for room in floor.rooms:
            assert room.polygon.area < {"TOILET": 3.5, "CLOSET": 4, "BATHROOM": 9}.get(room.label or "", 60)


def test_some_homes_have_wide_openings_and_l_shaped_rooms():
    homes = [make_home_floor(seed=seed) for seed in range(20)]
    openings = [door.width for floor in homes for door in floor.doors if door.kind == "opening"]
    assert len(openings) >= 3
    assert max(openings) > 1.5
    assert sum(len(room.polygon.exterior.coords) > 5 for floor in homes for room in floor.rooms) >= 20


def test_options_out_of_range_are_refused():
    with pytest.raises(OptionError, match="area is 5"):
        make_home_floor(area=5)
    with pytest.raises(OptionError, match="length is 500"):
        make_office_floor(length=500)


@given(names, seeds, st.sampled_from([0.5, 1.0, 2.0]))
@settings(max_examples=30, deadline=None)
def test_furniture_is_in_the_rooms_and_clear_of_doors(name, seed, density):
    floor = make_floor(name, seed=seed)
    obstacles = furnish_densely(floor, density=density, rng=np.random.default_rng(seed))
    assert obstacles == furnish_densely(floor, density=density, rng=np.random.default_rng(seed))
    rooms = unary_union([room.polygon for room in floor.rooms]).buffer(0.01)
    shapely.prepare(rooms)
    doors = unary_union([door.line.buffer(0.2, cap_style="flat") for door in floor.doors])
    assert all(rooms.contains(obstacle) for obstacle in obstacles)
    assert not any(doors.intersects(obstacle) for obstacle in obstacles)


def test_denser_furniture_covers_more_floor():
    floor = make_floor("office", seed=2)
    covered = [
        unary_union(furnish_densely(floor, density=density, rng=np.random.default_rng(0))).area
        for density in (0, 0.3, 1.0, 2.0)
    ]
    assert covered == sorted(covered)
    assert covered[0] == 0
    assert covered[3] > 1.5 * covered[1]


def test_furniture_of_a_turned_room_stands_along_its_walls():
    turned = shapely.affinity.rotate(box(0, 0, 5, 4), 30, origin=(0, 0))
    floor = Floor((Room(1, turned, label="CLOSET"),))
    obstacles = furnish_densely(floor, density=1, rng=np.random.default_rng(3))
    long = [np.diff(np.asarray(o.exterior.coords), axis=0) for o in obstacles if len(o.exterior.coords) == 5]
    sides = np.vstack([side[np.hypot(*side.T) > 0.8] for side in long])
    angles = np.degrees(np.arctan2(sides[:, 1], sides[:, 0])) % 90
    assert len(angles) > 2
    assert angles == pytest.approx(np.full(len(angles), 30), abs=0.01)


def test_a_narrow_corridor_can_be_furnished():
    # 2 · area / perimeter is 0.47 m, of which 0.35 is less than the smallest bin of 0.2 m.
    floor = Floor((Room(1, box(0, 0, 15, 0.5), label="CORRIDOR"),))
    for seed in range(10):
        obstacles = furnish_densely(floor, density=2, rng=np.random.default_rng(seed))
        assert all(floor[1].polygon.buffer(0.01).contains(obstacle) for obstacle in obstacles)


def two_rooms_with(line: LineString, door_kind: Literal["door", "opening"] = "door") -> Floor:
    rooms = (Room(1, box(0, 0, 4, 3)), Room(2, box(4.1, 0, 8, 3)))
    return Floor(rooms, (Door((1, 2), line, line.length, door_kind),))


def test_a_shut_door_is_closed_by_its_leaf():
    floor = two_rooms_with(LineString([(4.05, 1), (4.05, 1.9)]))
    leaves, shut = draw_door_leaves(floor, rng=np.random.default_rng(0), shut=1)
    assert shut == [0]
    assert leaves[0].area == pytest.approx(0.9 * 0.045)
    assert leaves[0].buffer(0.001).contains(floor.doors[0].line)


@pytest.mark.parametrize(("shares", "angles"), [((0, 1), (20, 60)), ((0, 0), (60, 110))])
def test_a_leaf_swings_from_a_jamb(shares, angles):
    line = LineString([(4.05, 1), (4.05, 1.9)])
    turns = []
    for seed in range(30):
        leaves, shut = draw_door_leaves(
            two_rooms_with(line), rng=np.random.default_rng(seed), shut=shares[0], half_open=shares[1]
        )
        assert shut == []
        for leaf in leaves:
            assert leaf.area == pytest.approx(0.9 * 0.045)
            hinge = min((shapely.Point(4.05, y) for y in (1, 1.9)), key=leaf.distance)
            corners = np.asarray(leaf.exterior.coords)[:4]
            far = corners[np.argsort(np.hypot(*(corners - hinge.coords[0]).T))[2:]].mean(axis=0)
            along = 1 if hinge.y == 1 else -1
            turns.append(np.degrees(np.arctan2(abs(far[0] - 4.05), along * (far[1] - hinge.y))))
    assert len(turns) > 15
    assert angles[0] <= min(turns)
    assert max(turns) <= angles[1]


def test_openings_have_no_leaf():
    floor = two_rooms_with(LineString([(4.05, 0.5), (4.05, 2.5)]), "opening")
    assert draw_door_leaves(floor, rng=np.random.default_rng(0), shut=1) == ([], [])


def test_leaves_change_the_map_only_near_doors():
    floor = make_floor("home", seed=4)
    plain = simulate_map(floor, furniture=1, noise=0.5, seed=1)
    with_leaves = simulate_map(floor, furniture=1, noise=0.5, door_leaves=True, seed=1)
    changed = plain.cells != with_leaves.cells
    doors = unary_union([door.line.buffer(1.3) for door in floor.doors])
    rows, cols = np.nonzero(changed)
    assert len(rows) > 10
    assert shapely.contains_xy(doors, *plain.pixel_to_map(rows + 0.5, cols + 0.5)).all()


def test_a_shut_door_parts_the_free_cells(monkeypatch):
    floor = two_rooms_with(LineString([(4.05, 1), (4.05, 1.9)]))
    monkeypatch.setattr(
        "pianta.worlds.scan.draw_door_leaves", lambda floor, rng: draw_door_leaves(floor, rng=rng, shut=1)
    )
    for resolution in (0.03, 0.05, 0.1):
        counts = [
            label(simulate_map(floor, resolution=resolution, door_leaves=leaves).free)[1] for leaves in (False, True)
        ]
        assert counts == [1, 2]


def test_a_leg_thinner_than_a_cell_is_on_the_map():
    floor = Floor((Room(1, box(0, 0, 6, 5), label="OFFICE"),))
    furnished = simulate_map(floor, furniture=1, dense_furniture=True, resolution=0.05, seed=2)
    obstacles = furnish_densely(floor, density=1, rng=np.random.default_rng(2).spawn(3)[0])
    assert len(obstacles) > 5
    for obstacle in obstacles:
        row, col = (int(value) for value in furnished.map_to_pixel(*obstacle.centroid.coords[0]))
        assert not furnished.free[row, col]


def test_all_sides_to_the_outside_are_glass_and_those_between_rooms_by_their_labels():
    rooms = (Room(1, box(0, 0, 4, 3), label="OFFICE"), Room(2, box(4.1, 0, 8, 3), label="BATHROOM"))
    glass = draw_glass_walls(Floor(rooms), rng=np.random.default_rng(0), share=1)
    # Three outer sides each, and the side of the office towards the bathroom, as deep as the wall.
    assert len(glass) == 7
    between = [pane for pane in glass if pane.intersects(LineString([(4.05, 0), (4.05, 3)]))]
    assert len(between) == 1
    assert between[0].bounds[0::2] == pytest.approx((4, 4.1))
