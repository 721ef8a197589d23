"""Large maps in tiles: rooms of several tiles become one, and the result is nearly that of the whole map."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, box

import pianta
from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout import reconstruct as reconstruction
from pianta.layout.structure import tiles
from pianta.layout.structure.tiles import Tile, TileParameters, join_tiles, list_tiles, reconstruct_in_tiles


@pytest.fixture
def small_tiles(monkeypatch):
    """Cores of 100 cells of 0.1 m, 10 m wide, with 3 m around them."""
    monkeypatch.setattr(tiles, "PARAMETERS", TileParameters(core=100, overlap=3.0, max_whole=0))


def free_map(width: int, height: int = 60, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> GridMap:
    return GridMap(np.zeros((height, width), np.int8), 0.1, origin)


def reader(rooms: list[Room], doors: list[Door]):
    """A reader that sees what lies in a tile of rooms and doors of the whole map, cut at its edge."""

    def read(part: GridMap) -> Floor:
        x, y, _ = part.origin
        extent = box(x, y, x + part.shape[1] * part.resolution, y + part.shape[0] * part.resolution)
        inside = [Room(room.id, room.polygon.intersection(extent)) for room in rooms if room.polygon.intersects(extent)]
        inside = [room for room in inside if room.polygon.area > 0.01]
        if not inside:
            raise MapError("no room")
        ids = {room.id for room in inside}
        whole_doors = tuple(door for door in doors if set(door.room_ids) <= ids and door.line.within(extent))
        return Floor(tuple(inside), whole_doors)

    return read


@pytest.mark.usefixtures("small_tiles")
class TestTiles:
    def test_cores_cover_the_map_and_tiles_reach_beyond_them(self):
        """24 m are three cores of 8 m, with 3 m around each where the map goes on."""
        listed = list(list_tiles(free_map(240, origin=(5.0, -2.0, 0.0))))
        assert [tile.grid.shape[1] for tile in listed] == [110, 140, 110]
        cores = shapely.union_all([tile.core for tile in listed])
        assert cores.symmetric_difference(box(5, -2, 29, 4)).area < 1e-6
        assert listed[1].extent.bounds == pytest.approx((10, -2, 24, 4))
        assert [round(tile.edge.length, 3) for tile in listed] == [6, 12, 6]

    def test_turned_maps_have_turned_tiles(self):
        grid = free_map(250, origin=(1.0, 2.0, 0.5))
        for tile in list_tiles(grid):
            height, width = tile.grid.shape
            corners = np.column_stack(tile.grid.pixel_to_map([0, 0, height, height], [0, width, width, 0]))
            assert shapely.Polygon(corners).symmetric_difference(tile.extent).area < 1e-6

    def test_tiles_without_free_cells_are_left_out(self):
        cells = np.full((60, 250), -1, np.int8)
        cells[:, :40] = 0
        assert len(list(list_tiles(GridMap(cells, 0.1, (0.0, 0.0, 0.0))))) == 1

    def test_a_corridor_through_all_tiles_is_one_room_with_its_doors(self):
        corridor = Room(1, box(0.5, 0.5, 24.5, 2.5))
        rooms = [corridor, *(Room(2 + k, box(0.5 + 6 * k, 2.7, 6.3 + 6 * k, 5.5)) for k in range(4))]
        doors = [Door((1, 2 + k), LineString([(2 + 6 * k, 2.6), (3 + 6 * k, 2.6)]), 1.0) for k in range(4)] + [
            Door((1, None), LineString([(0.5, 1), (0.5, 2)]), 1.0)
        ]
        floor = reconstruct_in_tiles(free_map(250), reader(rooms, doors))
        assert len(floor) == 5
        assert sorted(round(room.polygon.area, 2) for room in floor) == [16.24] * 4 + [48.0]
        assert len(floor.doors) == 5
        (one,) = (room for room in floor if room.polygon.area > 40)
        assert all(one.id in door.room_ids for door in floor.doors)
        assert [door.rooms for door in floor.doors if door.is_entrance] == [(one.id, None)]

    def test_no_room_in_any_tile_is_an_error(self):
        with pytest.raises(MapError, match="shows no room"):
            reconstruct_in_tiles(free_map(250), reader([], []))

    def test_rooms_of_tiles_that_do_not_overlap_are_others(self):
        """They share an area and a side, which GEOS cannot intersect with the empty overlap of their tiles."""
        grid = free_map(50)
        both = [Tile(grid, extent, extent, LineString()) for extent in (box(0, 0, 2, 3), box(2.1, 0, 5, 4))]
        bracket = shapely.union_all([box(0, 0, 2, 1), box(0, 0, 1, 3)])
        other = shapely.union_all([box(0.5, 0.5, 1.5, 4), box(1.5, 1, 4.5, 4)])
        floor = join_tiles(grid, both, [Floor((Room(1, room),)) for room in (bracket, other)])
        assert sorted(round(room.polygon.area, 3) for room in floor) == [2.5, 12.5]

    @settings(max_examples=30)
    @given(cuts=st.lists(st.integers(2, 46), min_size=2, max_size=8, unique=True))
    def test_rooms_in_a_row_come_back_as_they_are(self, cuts):
        """Rooms of 1 to 22 m; those longer than the overlap are put together from the tiles."""
        ends = sorted(cuts)
        rooms = [
            Room(number, box(left / 2, 0.5, right / 2 - 0.2, 5.5))
            for number, (left, right) in enumerate(pairwise(ends), start=1)
        ]
        floor = reconstruct_in_tiles(free_map(250), reader(rooms, []))
        assert len(floor) == len(rooms)
        for room, true in zip(sorted(floor, key=lambda each: each.polygon.bounds), rooms, strict=True):
            assert room.polygon.symmetric_difference(true.polygon).area < 1e-6


@pytest.mark.slow
def test_a_building_in_tiles_is_nearly_the_whole_one(monkeypatch):
    """Two offices side by side, read whole, and in tiles of half their size."""
    one, other = (pianta.make_world("office", seed=seed, noise=0.2)[1].cells for seed in (1, 2))
    height = max(one.shape[0], other.shape[0])
    cells = np.full((height + 40, one.shape[1] + other.shape[1] + 60), -1, np.int8)
    cells[20 : 20 + one.shape[0], 20 : 20 + one.shape[1]] = one
    cells[20 : 20 + other.shape[0], 40 + one.shape[1] : 40 + one.shape[1] + other.shape[1]] = other
    grid = GridMap(cells, 0.05, (-3.0, 4.0, 0.0))
    untiled = pianta.reconstruct(grid, predict_partial=False)
    monkeypatch.setattr(tiles, "PARAMETERS", TileParameters(core=700, overlap=12.0, max_whole=0))
    tiled = pianta.reconstruct(grid, predict_partial=False)
    assert abs(len(tiled) - len(untiled)) <= 2
    areas = shapely.STRtree([room.polygon for room in tiled])
    alike = 0
    for room in untiled:
        near = [tiled.rooms[index].polygon for index in areas.query(room.polygon)]
        alike += any(room.polygon.intersection(each).area > 0.9 * room.polygon.union(each).area for each in near)
    assert alike >= 0.9 * len(untiled)
    assert abs(len(tiled.doors) - len(untiled.doors)) <= 3
    pairs = [(a.intersection(b).area) for a in areas.geometries for b in areas.geometries if a is not b]
    assert max(pairs) < 1e-6


def test_small_maps_are_read_whole(monkeypatch):
    monkeypatch.setattr(tiles, "reconstruct_in_tiles", partial(pytest.fail, "in tiles"))
    assert len(reconstruction.reconstruct(pianta.make_world("corridor")[1])) == 19
