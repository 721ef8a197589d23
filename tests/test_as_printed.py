"""Algorithm 1 as the thesis prints it: each of our departures is a switch, and changes what it should."""

from dataclasses import asdict, replace

import numpy as np
import pytest
import shapely

import pianta
from pianta.errors import OptionError
from pianta.layout._working_grid import to_working_grid
from pianta.layout.parameters import CLUTTER, DEPARTURES, ThesisParameters
from pianta.layout.reconstruct import find_rooms
from pianta.layout.thesis.affinity import cluster_faces, compute_affinity_matrix, normalise_affinity
from pianta.layout.thesis.contour import compute_map_contour
from pianta.layout.thesis.faces import Faces
from pianta.layout.thesis.lines import chain_spatially, get_representative_lines
from pianta.layout.thesis.reconstruct import reconstruct_layout
from pianta.layout.thesis.segments import detect_segments
from tests.command_line import run_pianta
from tests.drawn_maps import carve, make_grid, make_working_grid

DEFAULT, PRINTED = ThesisParameters(), ThesisParameters.as_printed(furnished=False)
# Two rooms above a corridor, one cell of 5 cm, and a door from each to the corridor.
SUITE = carve((143, 200), (10, 90, 10, 90), (10, 90, 93, 190), (93, 133, 10, 190), (90, 93, 40, 58), (90, 93, 130, 150))


def switch(name: str) -> tuple[ThesisParameters, ThesisParameters]:
    """Ours, and ours with one departure undone."""
    return DEFAULT, replace(DEFAULT, **DEPARTURES[name])


def test_as_printed_undoes_every_departure():
    changed = {key: value for key, value in asdict(PRINTED).items() if value != asdict(DEFAULT)[key]}
    assert changed == {
        "sigma": 0.1,
        "hough_passes": 1,
        "hough_votes": 1.0,
        "segment_length": 0.35,
        "remove_clutter": False,
        "normal_pose": False,
        "chain_lines": True,
        "drop_weak_lines": False,
        "fill_gaps": False,
        "drop_small_rooms": False,
        "need_open_edge": False,
    }
    assert changed == {key: value for values in DEPARTURES.values() for key, value in values.items()}
    assert ThesisParameters.as_printed() == replace(PRINTED, remove_clutter=True)


@pytest.mark.parametrize(
    ("offsets", "chains"),
    [
        ([0, 0.5, 1.0, 1.5], [0, 0, 0, 0]),
        ([1.5, 0, 3.0, 0.8], [0, 0, 1, 0]),
        ([0, 0.9], [0, 1]),
        ([2.0], [0]),
    ],
)
def test_a_chain_of_near_segments_is_one_cluster_as_printed(offsets, chains):
    assert chain_spatially(np.array(offsets), 0.9).tolist() == chains


def test_lines_are_those_of_chains_as_printed():
    """Means 0.25 and 1.25 are 1 m apart, yet each segment is 0.5 m from the next; the median of all is 0.75."""
    segments = np.array([[0, y, 3, y] for y in (0, 0.5, 1.0, 1.5)])
    default, printed = (get_representative_lines(segments, each) for each in switch("clusters of lines by their means"))
    assert [line.offset for line in default] == pytest.approx([0.25, 1.25])
    assert [line.offset for line in printed] == pytest.approx([0.75])


def test_weak_lines_stay_as_printed():
    segments = np.array([[0, 1, 0.95, 1], [4, 1, 4.95, 1]])
    assert [len(get_representative_lines(segments, each)) for each in switch("weak lines dropped")] == [0, 1]


def test_door_gaps_are_no_wall_as_printed():
    segments = np.array([[0, 1, 3, 1], [4, 1, 6, 1]])
    covers = [get_representative_lines(segments, each)[0].covered.tolist() for each in switch("door gaps filled")]
    assert covers == [[[0, 6]], [[0, 3], [4, 6]]]


def test_an_edge_with_a_quarter_of_wall_divides_as_printed():
    """exp(-0.25 / 0.15) = 0.189 and 0.189 / 1.189 = 0.159 > 1 - 0.85; exp(-0.25 / 0.1) = 0.082, over 1.082 0.076."""
    ends = np.array([[1.0, 0.0]]), np.array([[1.0, 1.0]])
    first, second = np.array([0]), np.array([1])
    faces = Faces(np.array([shapely.box(0, 0, 1, 1), shapely.box(1, 0, 2, 1)]), first, second, *ends, np.array([0.25]))
    counts = []
    for each in switch("σ = 0.15"):
        affinity = normalise_affinity(compute_affinity_matrix(faces, sigma=each.sigma))
        counts.append(len(set(cluster_faces(affinity, epsilon=each.epsilon).tolist())))
    assert counts == [1, 2]


@pytest.mark.parametrize(("length_px", "is_segment"), [(14, [True, False]), (40, [True, True]), (4, [False, False])])
def test_a_wall_of_less_than_a_metre_is_no_segment_as_printed(length_px, is_segment):
    """20 votes of 0.05 m; ours are 10."""
    edges = np.zeros((60, 60), np.uint8)
    edges[30, 5 : 5 + length_px] = 255
    assert [len(detect_segments(edges, 0.05, each)) > 0 for each in switch("shorter segments")] == is_segment


def test_the_map_keeps_its_pose_as_printed():
    free = carve((60, 30), (5, 50, 5, 20))
    default, printed = (
        to_working_grid(make_grid(free), free, resolution=0.05, normal_pose=each.normal_pose)
        for each in switch("a normal pose")
    )
    # Cropped to 45 × 15 cells, with a margin of 4 on each side; ours is wider than high.
    assert (default.free.shape, printed.free.shape) == ((23, 53), (53, 23))
    room = shapely.box(0.2, 0.2, 0.95, 2.45)
    assert printed.to_map(room).bounds == pytest.approx(default.to_map(shapely.box(0.2, 0.2, 2.45, 0.95)).bounds)


def test_a_closet_is_inside_as_printed():
    """0.81 m², less than the 1 m² of a room."""
    free = carve((100, 140), (10, 90, 10, 90), (10, 28, 100, 118))
    default, printed = (compute_map_contour(make_working_grid(free), each) for each in switch("small clusters dropped"))
    assert (default.sum(), printed.sum()) == (80 * 80, free.sum())


def test_a_closet_is_a_room_as_printed():
    """A closet of 0.9 m² beside the suite, whose short walls give lines."""
    free = np.pad(SUITE, ((0, 0), (0, 60)))
    free[10:29, 220:239] = True
    counts = [
        len(pianta.reconstruct(make_grid(free), method="thesis", parameters=replace(each, drop_weak_lines=False)))
        for each in switch("small clusters dropped")
    ]
    assert counts == [3, 4]


def test_a_cupboard_in_a_room_draws_a_wall_as_printed():
    """1.3 m × 0.5 m, less than 1.5 m across; its two long sides are one line of 2.6 m."""
    free = SUITE & ~carve(SUITE.shape, (45, 55, 130, 156))
    default, printed = (
        pianta.reconstruct(make_grid(free), method="thesis", parameters=each) for each in switch(CLUTTER)
    )
    assert (len(default.walls), len(printed.walls)) == (6, 7)


def test_a_face_with_a_wall_beside_its_line_may_be_partial_as_printed():
    """Where the wall of a made world stands beside its line."""
    _, grid = pianta.make_world("office", seed=1, noise=0.5, furniture=0.3)
    default, printed = (
        [room.partial for room in find_rooms(grid, method="thesis", parameters=each)]
        for each in switch("partial faces need an open edge")
    )
    assert len(default) == len(printed)
    assert all(more or not less for less, more in zip(default, printed, strict=True))
    assert sum(printed) > sum(default)


def test_as_printed_is_an_option_of_reconstruct():
    grid = make_grid(SUITE)
    floor = pianta.reconstruct(grid, method="thesis", as_printed=True)
    assert floor == pianta.reconstruct(grid, method="thesis", parameters=ThesisParameters.as_printed())
    assert floor != pianta.reconstruct(grid, method="thesis")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "as_printed=True is for method thesis and method is structure, give method='thesis'"),
        ({"method": "voronoi"}, "method is voronoi"),
        ({"method": "thesis", "parameters": DEFAULT}, "as_printed=True and parameters= are given, leave either out"),
    ],
)
def test_as_printed_is_for_the_method_of_the_thesis_alone(tmp_path, options, message):
    make_grid(SUITE).save(tmp_path / "map.yaml")
    with pytest.raises(OptionError, match=message):
        pianta.reconstruct(make_grid(SUITE), as_printed=True, **options)
    with pytest.raises(OptionError, match=message):
        pianta.read(tmp_path / "map.yaml", as_printed=True, **options)


def test_the_command_names_its_own_flags(tmp_path):
    make_grid(SUITE).save(tmp_path / "map.yaml")
    code, _, err = run_pianta("read", tmp_path / "map.yaml", "-o", tmp_path / "out", "--as-printed")
    assert code == 2
    assert "--as-printed is for method thesis and method is structure, give --method thesis" in err
    assert not (tmp_path / "out").exists()


def test_rooms_do_not_depend_on_a_search_for_doors():
    grid = make_grid(SUITE)
    floor, rooms = (reconstruct_layout(grid, parameters=DEFAULT, with_doors=each) for each in (True, False))
    assert (floor.rooms, len(floor.doors), rooms.doors) == (rooms.rooms, 2, ())
