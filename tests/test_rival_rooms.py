"""What holds for every rival method: whole rooms, no walls, the same rooms in every pose, and clear refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import label

from pianta.errors import MapError, OptionError
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.reconstruct import reconstruct
from pianta.layout.rivals.methods import SEGMENTATIONS, segment_rooms
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from tests.command_line import run_pianta
from tests.drawn_maps import carve, make_grid

# Two rooms of 6 × 6 m, more than one room of the morphological method holds, and 0.2 m of wall with a door of 0.9 m.
PAIR = carve((140, 264), (10, 130, 10, 130), (10, 130, 134, 254), (61, 79, 130, 134))
MAPS = {
    "furnished": simulate_map(make_corridor_floor(length=14, seed=3), furniture=0.6, seed=3),
    "noisy": simulate_map(make_corridor_floor(length=14, seed=4), noise=0.5, seed=4),
}
# The skeleton of the Voronoi diagram and the grid of scans depend on the pose of the map, and one door that is missed
# joins two rooms.
LEAST_AGREEMENT = {"morphological": 0.95, "distance": 0.9, "voronoi": 0.8, "features": 0.5}
every_method = pytest.mark.parametrize("method", SEGMENTATIONS)
every_map = pytest.mark.parametrize("grid", MAPS.values(), ids=MAPS.keys())


def agreement(first, second) -> float:
    """Share of labelled cells that lie in pairs of rooms with an intersection over union above one half."""
    counts = np.zeros((first.max() + 1, second.max() + 1), int)
    np.add.at(counts, (first.ravel(), second.ravel()), 1)
    union = counts.sum(axis=1, keepdims=True) + counts.sum(axis=0) - counts
    inner = counts[1:, 1:]
    share: float = inner[inner > union[1:, 1:] / 2].sum() / (counts.sum() - counts[0, 0])
    return share


def test_agreement_knows_equal_and_merged_rooms():
    rooms = np.array([[1, 1, 2, 2, 0]])
    assert agreement(rooms, np.array([[2, 2, 1, 1, 0]])) == 1
    assert agreement(rooms, np.array([[1, 1, 1, 1, 0]])) == 0
    assert agreement(rooms, np.array([[1, 1, 1, 2, 0]])) == 0.5


@every_method
def test_two_rooms_with_a_door_are_two(method):
    labels = segment_rooms(make_grid(PAIR), method=method)
    west, east = labels[10:130, 10:130], labels[10:130, 134:254]
    assert labels.max() == 2
    for room in (west, east):
        assert np.mean(room == np.bincount(room.ravel()).argmax()) > 0.95
    assert west[60, 60] != east[60, 60]


@every_method
def test_one_room_is_one(method):
    room = carve((100, 120), (10, 90, 10, 110))
    assert (segment_rooms(make_grid(room), method=method) == room).all()


@pytest.mark.slow
@every_method
@every_map
def test_rooms_are_whole_and_numbered_and_no_wall_is_one(grid, method):
    labels = segment_rooms(grid, method=method)
    assert labels.dtype == np.int32
    assert set(labels.ravel().tolist()) == set(range(labels.max() + 1))
    assert not labels[~grid.free].any()
    assert all(label(labels == room)[1] == 1 for room in range(1, labels.max() + 1))


@pytest.mark.slow
@every_method
@every_map
def test_the_same_map_gives_the_same_rooms(grid, method):
    assert (segment_rooms(grid, method=method) == segment_rooms(grid, method=method)).all()


@pytest.mark.slow
@pytest.mark.parametrize(("method", "least"), LEAST_AGREEMENT.items())
@every_map
def test_a_map_turned_by_90_degrees_has_the_same_rooms(grid, method, least):
    labels = segment_rooms(grid, method=method)
    turned = segment_rooms(GridMap(np.rot90(grid.cells), grid.resolution), method=method)
    assert agreement(labels, np.rot90(turned, -1)) > least


@pytest.mark.slow
@pytest.mark.parametrize(("method", "least"), LEAST_AGREEMENT.items())
@every_map
def test_cells_half_as_large_show_the_same_rooms(grid, method, least):
    fine = GridMap(grid.cells.repeat(2, axis=0).repeat(2, axis=1), grid.resolution / 2)
    labels = segment_rooms(grid, method=method)
    assert agreement(labels.repeat(2, axis=0).repeat(2, axis=1), segment_rooms(fine, method=method)) > least


@every_method
@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (np.full((60, 80), FREE), "free"),
        (np.full((60, 80), UNKNOWN), "free"),
        (np.full((60, 80), OCCUPIED), "free"),
        (np.array([[FREE]]), "free"),
        (np.where(carve((60, 80), (30, 31, 40, 41)), FREE, OCCUPIED), "room"),
    ],
)
def test_maps_without_a_room_are_refused(method, cells, message):
    with pytest.raises(MapError, match=message):
        segment_rooms(GridMap(cells, 0.05), method=method)


@every_method
def test_cells_too_coarse_for_doors_are_refused(method):
    with pytest.raises(MapError, match="2 m"):
        segment_rooms(make_grid(PAIR, resolution=2), method=method)


@pytest.mark.parametrize("method", ["morphological", "distance", "voronoi"])
def test_free_space_up_to_the_edge_of_the_map_is_a_room(method):
    labels = segment_rooms(make_grid(PAIR[10:130, 10:254]), method=method)
    assert labels[60, 10] != labels[60, 240]
    assert (labels > 0)[PAIR[10:130, 10:254]].all()


def test_an_unknown_method_is_refused():
    with pytest.raises(OptionError, match="magic"):
        segment_rooms(make_grid(PAIR), method="magic")


@pytest.mark.slow
@every_method
def test_the_floor_has_the_rooms_of_the_segmentation_and_their_door(method):
    floor = reconstruct(replace(make_grid(PAIR), source="pair"), method=method)
    assert len(floor.rooms) == 2
    (door,) = floor.doors
    assert door.width == pytest.approx(0.9, abs=0.06)
    assert floor.source == "pair"


@pytest.mark.slow
@every_method
def test_read_takes_the_method(method, tmp_path):
    assert run_pianta("world", "corridor", "-o", tmp_path).code == 0
    outcome = run_pianta("read", tmp_path / "map.yaml", "--method", method, "-o", tmp_path / "read")
    assert (outcome.code, outcome.err) == (0, "")
    assert "rooms" in outcome.out
    names = sorted(file.name for file in (tmp_path / "read").iterdir())
    assert names == ["floor.geojson", "graph.json", "grid.npz", "picture.png", "rooms.png"]
