"""Ways of a robot through furnished rooms, in small rooms with answers by hand."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt, label
from shapely import LineString, Polygon, box

from pianta.floor import Door, Floor, Room, cells_of_polygon
from pianta.worlds.dense_furniture import StandingPiece, furnish_densely
from pianta.worlds.floors import LABELLED_FLOOR_MAKERS, make_floor
from pianta.worlds.furnish import furnish, furnish_for_robot
from pianta.worlds.scan import simulate_map
from pianta.worlds.ways import keep_ways

# A room of 4 m × 3 m with a door in the middle of its lower side.
ROOM = Room(1, box(0, 0, 4, 3), label="OFFICE")
FLOOR = Floor((ROOM,), (Door((1, None), LineString([(1.55, -0.1), (2.45, -0.1)]), 0.9),))


def stand(*parts: Polygon) -> StandingPiece:
    return StandingPiece(1, "shelf", parts)


def keep(*pieces: StandingPiece, radius: float = 0.22) -> list[StandingPiece]:
    return keep_ways(FLOOR, pieces, radius=radius)


def test_a_piece_from_wall_to_wall_is_taken_out_and_one_in_a_corner_stays():
    across, corner = stand(box(0.1, 0.8, 3.9, 1.1)), stand(box(0.1, 2.5, 1.0, 2.9))
    assert keep(across, corner) == [corner]


def test_a_piece_that_a_robot_can_drive_round_stays():
    """It is before the door, and leaves 1.4 m on its right."""
    piece = stand(box(0.1, 0.9, 2.6, 1.2))
    assert keep(piece) == [piece]


def test_the_passage_must_be_as_wide_as_the_robot():
    """0.9 m are left on the right: enough for a robot of 0.6 m, and not for one of 1 m."""
    piece = stand(box(0.1, 0.9, 3.1, 1.2))
    assert keep(piece, radius=0.3) == [piece]
    assert keep(piece, radius=0.5) == []


def test_all_parts_of_a_piece_go_together():
    """A table on four legs, two of them before the door."""
    legs = [box(x, y, x + 0.1, y + 0.1) for x in (1.7, 2.1) for y in (0.35, 1.2)]
    assert keep(stand(*legs)) == []


def test_a_room_that_is_too_narrow_when_it_is_empty_stays_as_it_is():
    floor = Floor((Room(1, box(0, 0, 4, 0.5), label="CLOSET"),), FLOOR.doors)
    piece = stand(box(0.1, 0.1, 3.9, 0.4))
    assert keep_ways(floor, [piece], radius=0.3) == [piece]


def test_a_room_without_a_door_stays_as_it_is():
    piece = stand(box(0.1, 0.8, 3.9, 1.1))
    assert keep_ways(Floor((ROOM,)), [piece], radius=0.22) == [piece]


@given(st.sampled_from(sorted(LABELLED_FLOOR_MAKERS)), st.integers(0, 1000), st.sampled_from([0.5, 1.0, 2.0]))
@settings(max_examples=8, deadline=None)
def test_a_robot_that_gets_into_empty_rooms_gets_into_furnished_ones(name, seed, density):
    """Beyond the radius the cells of the map take up to a diagonal of 0.07 m."""
    empty = make_floor(name, seed=seed)
    furnished = furnish_for_robot(empty, furniture=density, radius=0.3, seed=seed)
    assert find_reached_rooms(furnished, 0.2) >= find_reached_rooms(empty, 0.36)


def find_reached_rooms(floor: Floor, radius: float) -> set[int]:
    """The rooms that a robot of a radius, metres, gets into from the room in which it has most space."""
    grid = simulate_map(floor, solid_walls=True)
    parts, _ = label(distance_transform_edt(grid.free) * grid.resolution > radius, np.ones((3, 3)))
    if not parts.any():
        return set()
    largest = np.bincount(parts[parts > 0]).argmax()
    reached = set()
    for room in floor:
        rows, cols, inside = cells_of_polygon(room.polygon, grid)
        if (parts[rows, cols][inside] == largest).any():
            reached.add(room.id)
    return reached


def test_furniture_for_a_robot_is_some_of_the_other():
    floor = make_floor("office", seed=4)
    dense, ways = (
        [shapely.to_wkb(piece.polygon) for piece in furnished.furniture]
        for furnished in (
            furnish(floor, furniture=1, dense_furniture=True, seed=4),
            furnish_for_robot(floor, furniture=1, radius=0.22, seed=4),
        )
    )
    assert 0.8 * len(dense) < len(ways) < len(dense)
    assert {*ways} < {*dense}


def test_a_furnished_floor_has_what_its_map_shows():
    floor = make_floor("home", seed=1)
    furnished = furnish(floor, furniture=1, dense_furniture=True, seed=1)
    expected = furnish_densely(floor, density=1, rng=np.random.default_rng(1).spawn(3)[0])
    assert len(furnished.furniture) == len(expected)
    for piece, polygon in zip(furnished.furniture, expected, strict=True):
        assert piece.polygon.symmetric_difference(polygon).area < 0.003
    assert {"bed", "toilet"} <= {piece.kind for piece in furnished.furniture}
    mapped = simulate_map(floor, furniture=1, dense_furniture=True, seed=1)
    assert (simulate_map(furnished, seed=1).free == mapped.free).mean() > 0.999


def test_plain_furniture_has_legs_as_wide_as_cells():
    floor = Floor((Room(1, box(0, 0, 20, 20)),))
    for resolution in (0.02, 0.1):
        sides = [piece.polygon.length / 4 for piece in furnish(floor, furniture=1, resolution=resolution).furniture]
        assert min(sides) == pytest.approx(max(0.05, resolution), abs=0.002)
