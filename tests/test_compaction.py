"""Free space that only corridors cross is taken out of drawn buildings."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from pianta.generation.drawing.blocks import NO_ROOM, measure_contacts, paint_cells
from pianta.generation.drawing.choices import sample_choices
from pianta.generation.drawing.compaction import compact, find_seam, remove_seam
from pianta.generation.drawing.losses import count_inner_corners, find_missing_doors
from pianta.generation.drawing.programme import make_programme
from pianta.generation.drawing.strips import TreeLayout
from tests.generated_types import join_wings, sized_model


def make_cells(drawing: str) -> np.ndarray:
    """The cells of a drawing, a row per line: digits are rooms, dots are free; with a free margin."""
    rows = [[NO_ROOM if each == "." else int(each) for each in line] for line in drawing.split()]
    return np.pad(np.array(rows, np.int32), 2, constant_values=NO_ROOM)


def show(cells: np.ndarray) -> str:
    """A drawing of the bounding box of all rooms."""
    rows, columns = np.nonzero(cells != NO_ROOM)
    box = cells[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    return "\n".join("".join("." if each == NO_ROOM else str(each) for each in line) for line in box)


# Corridor 0 leads to rooms 1 and 2, and has seven cells between them.
STRIP = """
1111.......2222
1111.......2222
000000000000000
"""
DOORS = nx.Graph([(0, 1), (0, 2)])
AREAS = {0: 15, 1: 8, 2: 8}


@pytest.mark.parametrize(
    ("area", "compacted"),
    [
        (15, "...11112222....\n...11112222....\n000000000000000"),
        (11, "..11112222.\n..11112222.\n00000000000"),
        (2, "11112222\n11112222\n.000000."),
    ],
)
def test_rooms_move_along_their_corridor_which_is_shortened_to_its_area_and_its_doors(area, compacted):
    """Two doors have three cells of wall each, so that the corridor has six cells at least."""
    cells = compact(make_cells(STRIP), DOORS, {**AREAS, 0: area})
    assert show(cells) == compacted
    assert (cells[:10] == NO_ROOM).all()
    assert (cells[:, -10:] == NO_ROOM).all()


def test_without_gaps_and_spare_area_there_is_no_seam():
    assert find_seam(make_cells("1111222\n1111222\n0000000"), DOORS, {0: 7, 1: 8, 2: 6}) is None


def test_parts_on_both_sides_of_a_corridor_move_along_its_walls():
    """The seam leaves the corridor where it is free above, and goes along its wall to where it is free below."""
    cells = make_cells("""
        1111..2222
        0000000000
        .33333333.
        .33333333.""")
    doors = nx.Graph([(0, 1), (0, 2), (0, 3)])
    assert show(compact(cells, doors, {0: 8, 1: 4, 2: 4, 3: 16})) == "11112222\n00000000\n33333333\n33333333"


def test_rooms_do_not_fall_into_parts():
    """Room 1 has an arm of eight cells, which is taken out except for its last column, and corridor 0 below it."""
    cells = make_cells("""
        111........111
        11111111111111
        111........111
        00000000000000""")
    compacted = compact(cells, nx.Graph([(0, 1)]), {0: 7, 1: 0})
    assert show(compacted) == "111.111\n1111111\n111.111\n0000000"


def test_parts_of_a_room_do_not_meet_where_that_gives_it_another_corner():
    cells = make_cells("""
        000000
        00...0
        00.000""")
    assert show(compact(cells, nx.Graph(), {0: 13})) == "000000\n00...0\n00.000"


def test_a_seam_has_a_column_in_each_row():
    cells = make_cells(STRIP)
    seam = find_seam(cells, DOORS, {**AREAS, 0: 10})
    assert seam is not None
    assert seam.shape == (7,)
    assert (cells != NO_ROOM).sum() - (remove_seam(cells, seam) != NO_ROOM).sum() == 1


def make_random_cells(rng: np.random.Generator) -> np.ndarray:
    """Rooms of up to three rectangles that may cover each other; of each room the largest part, in no order."""
    cells = np.full(rng.integers(4, 26, 2), NO_ROOM, np.int32)
    for room in np.repeat(np.arange(rng.integers(1, 8)), rng.integers(1, 4)):
        row, col = rng.integers(cells.shape)
        cells[row : row + rng.integers(1, 10), col : col + rng.integers(1, 16)] = room
    rooms = np.full(cells.shape, NO_ROOM, np.int32)
    for number, room in enumerate(np.unique(cells[cells != NO_ROOM])):
        parts, _ = label(cells == room)
        rooms[parts == 1 + np.argmax(np.bincount(parts.ravel())[1:])] = number
    return np.pad(rooms, 1, constant_values=NO_ROOM)


@pytest.mark.parametrize("seed", range(100))
def test_rooms_of_any_shape_keep_doors_and_stay_in_one_part(seed):
    rng = np.random.default_rng(seed)
    cells = make_random_cells(rng)
    counts = np.bincount(cells[cells != NO_ROOM])
    doors = nx.Graph([rooms for rooms in measure_contacts(cells) if rng.random() < 0.7])
    compacted = compact(cells, doors, dict(enumerate(counts * rng.uniform(0.2, 1.1, len(counts)))))
    assert all(label(compacted == room)[1] == 1 for room in range(len(counts)))
    assert {*find_missing_doors(compacted, doors)} <= {*find_missing_doors(cells, doors)}
    assert count_inner_corners(compacted) <= count_inner_corners(cells)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000), scale=st.floats(0.3, 1))
def test_rooms_keep_doors_shapes_and_areas(seed, scale):
    rng = np.random.default_rng(seed)
    graph = join_wings(("CCCCT", "CCG", "CCCC"), ((0, 1), (1, 2)), source="")
    graph = nx.convert_node_labels_to_integers(graph)
    programme = make_programme(graph, sized_model(), rng)
    choices = sample_choices(graph, 0, alleys=bool(seed % 2), rng=rng)
    tree = TreeLayout(graph, programme.areas, programme.corridors, choices, programme.aspects)
    cells = paint_cells(tree.draw(), 10)
    areas = {room: scale * area if room in programme.corridors else area for room, area in programme.areas.items()}
    compacted = compact(cells, graph, areas)
    before, after = (np.bincount(each[each != NO_ROOM]) for each in (cells, compacted))
    assert all(after[room] >= min(before[room], areas[room]) for room in graph)
    assert (after <= before).all()
    assert count_inner_corners(compacted) <= count_inner_corners(cells)
    assert {*find_missing_doors(compacted, graph)} <= {*find_missing_doors(cells, graph)}
