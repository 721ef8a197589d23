"""The pieces of the floor, and how strongly two pieces belong together, for evidence that is made by hand."""

from dataclasses import replace
from math import log

import numpy as np
import pytest

from pianta._types import Floats, Mask
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import CELL, Evidence
from pianta.layout.structure.pieces import (
    CAUTION,
    Pieces,
    compute_pair_weights,
    cut_into_pieces,
    find_border_probability,
)
from tests.drawn_evidence import make_classes, make_evidence, set_class
from tests.drawn_maps import carve


def weigh(pieces: list[list[int]], *, affinity: float) -> dict[tuple[int, int], object]:
    """The weight of each pair of pieces, and whether it touches, for pieces on the cells of the network."""
    labels = np.array(pieces, np.int32)
    pairs, weights, touching = compute_pair_weights(
        labels, make_evidence(make_classes(labels.shape), affinity=affinity)
    )
    return {
        (one, other): (weight, touches)
        for (one, other), weight, touches in zip(pairs.tolist(), weights.tolist(), touching.tolist(), strict=True)
    }


class TestWeights:
    def test_two_pieces_that_are_two_rooms(self):
        """In each row, cells 0 and 4, and 1 and 5, are 4 cells apart: 4 pairs; no cells are 10 apart."""
        weights = weigh([[1, 1, 1, 2, 2, 2], [1, 1, 1, 2, 2, 2]], affinity=0.05)
        assert weights == {(1, 2): (pytest.approx(4 * (log(0.05 / 0.95) - CAUTION) + 0.01), True)}

    def test_pairs_that_are_further_apart_count_too(self):
        """4 pairs are 4 cells apart (2 and 6 to 5 and 9), 2 are 10 apart (0 and 10, 1 and 11)."""
        weights = weigh([[1] * 6 + [2] * 6], affinity=0.9)
        assert weights == {(1, 2): (pytest.approx((4 + 2) * (log(9) - CAUTION) + 0.01, rel=1e-6), True)}

    def test_pairs_in_a_column_count_as_pairs_in_a_row(self):
        weights = weigh([[1], [1], [1], [2], [2], [2]], affinity=0.05)
        assert weights == {(1, 2): (pytest.approx(2 * (log(0.05 / 0.95) - CAUTION) + 0.01), True)}

    def test_pieces_that_do_not_touch_have_a_weight(self):
        """Cells 0 and 4, and 1 and 5; without a contact there is no weight for touching."""
        weights = weigh([[1, 1, 0, 0, 2, 2]], affinity=0.95)
        assert weights == {(1, 2): (pytest.approx(2 * (log(19) - CAUTION), rel=1e-6), False)}

    def test_pieces_that_only_touch(self):
        """No two cells are 4 apart, so nothing speaks against one room."""
        assert weigh([[2, 1]], affinity=0.05) == {(1, 2): (0.01, True)}

    def test_one_piece_and_none(self):
        assert weigh([[1, 1, 1, 1, 1, 1]], affinity=0.05) == weigh([[0, 0]], affinity=0.05) == {}

    @pytest.mark.parametrize(("affinity", "odds"), [(0.0, 0.02 / 0.98), (1.0, 0.98 / 0.02)])
    def test_no_pair_of_cells_is_certain(self, affinity, odds):
        weights = weigh([[1, 0, 0, 0, 2]], affinity=affinity)
        assert weights == {(1, 2): (pytest.approx(log(odds) - CAUTION, rel=1e-5), False)}

    def test_the_affinity_is_that_of_the_first_cell_of_a_pair(self):
        """Of the two pairs, that of column 0 is one room and that of column 1 is not."""
        evidence = make_evidence(make_classes((1, 6)), affinity=0.5)
        evidence.affinities[0, 0, :2] = [0.9, 0.2]
        _, weights, _ = compute_pair_weights(np.array([[1, 1, 0, 0, 2, 2]], np.int32), evidence)
        assert weights == pytest.approx([log(0.9 / 0.1) + log(0.2 / 0.8) - 2 * CAUTION], rel=1e-5)

    def test_pieces_have_smaller_cells_than_the_network(self):
        """The middles of the network's cells lie at the odd columns: columns 1 and 9 are 4 of its cells apart."""
        pieces = np.array([[0, 1, 0, 0, 0, 0, 0, 0, 0, 2]] * 2, np.int32)
        evidence = replace(
            make_evidence(make_classes((1, 5)), affinity=0.95), from_working=np.eye(2, 3) / 2, shape=pieces.shape
        )
        pairs, weights, touching = compute_pair_weights(pieces, evidence)
        assert (pairs.tolist(), touching.tolist()) == ([[1, 2]], [False])
        assert weights == pytest.approx([log(19) - CAUTION], rel=1e-6)


class TestBorderProbability:
    def test_walls_and_doors_are_borders(self):
        classes = make_classes((1, 3))
        set_class(classes, carve((1, 3), (0, 1, 1, 2)), wall=0.6, door=0.3, floor=0.1)
        border = find_border_probability(make_evidence(classes, affinity=1.0))
        assert border[0] == pytest.approx([0, 0.9, 0])

    @pytest.mark.parametrize("turned", [False, True])
    def test_a_border_is_in_the_middle_of_two_cells_in_two_rooms(self, turned):
        """Cell 3 and cell 7 are not in one room, so the border is at cell 5."""
        evidence = make_evidence(make_classes((12, 1) if turned else (1, 12)), affinity=1.0)
        evidence.affinities[int(turned)].flat[3] = 0.25
        assert find_border_probability(evidence).ravel() == pytest.approx([0] * 5 + [0.75] + [0] * 6)

    def test_cells_that_are_further_apart_have_no_middle(self):
        evidence = make_evidence(make_classes((12, 12)), affinity=1.0)
        evidence.affinities[2:] = 0.0
        assert not find_border_probability(evidence).any()


# A hall of 20 × 40 cells of 0.1 m; two rooms with a wall of 2 cells and a door of 9 cells between them.
HALL = carve((22, 42), (1, 21, 1, 41))
ROOMS = carve((22, 42), (1, 21, 1, 20), (1, 21, 22, 41), (6, 15, 20, 22))


def cut(space: Mask, evidence: Evidence) -> Pieces:
    return cut_into_pieces(space, evidence, StructureParameters(), resolution=CELL)


def list_ends(necks: Floats) -> list[list[list[float]]]:
    return [sorted(neck) for neck in necks.tolist()]


class TestPieces:
    def test_a_floor_without_a_border_is_one_piece(self):
        pieces = cut(HALL, make_evidence(make_classes(HALL.shape)))
        assert np.array_equal(pieces.labels, HALL.astype(int))
        assert pieces.necks.shape == (0, 2, 2)

    @pytest.mark.parametrize(("door", "count"), [(0.34, 1), (0.36, 2)])
    def test_a_border_that_the_network_sees_divides_a_hall(self, door, count):
        classes = make_classes(HALL.shape)
        set_class(classes, carve(HALL.shape, (0, 22, 20, 21)), door=door, floor=1 - door)
        labels = cut(HALL, make_evidence(classes, affinity=1.0)).labels
        assert labels.max() == count
        assert np.array_equal(labels > 0, HALL)
        assert len(np.unique(labels[1:21, 1:20])) == len(np.unique(labels[1:21, 21:41])) == 1
        assert (labels[5, 5] != labels[5, 35]) == (count == 2)

    def test_a_neck_divides_two_rooms_where_the_network_sees_no_border(self):
        """The neck goes from the last cell of the wall above the door to the first cell below it: rows 5 and 15."""
        pieces = cut(ROOMS, make_evidence(make_classes(ROOMS.shape)))
        assert pieces.labels.max() == 2
        assert np.array_equal(pieces.labels > 0, ROOMS)
        assert (pieces.labels[1:21, 1:20] == 1).all()
        assert (pieces.labels[1:21, 22:41] == 2).all()
        assert [[row for row, _ in ends] for ends in list_ends(pieces.necks)] == [[5, 15]]

    def test_a_border_that_is_everywhere_leaves_the_regions_between_the_necks(self):
        """No piece can grow from a cell that is no border."""
        classes = make_classes(ROOMS.shape)
        set_class(classes, np.ones(ROOMS.shape, bool), wall=1.0)
        labels = cut(ROOMS, make_evidence(classes)).labels
        assert labels.max() == 2
        assert np.array_equal(labels > 0, ROOMS)

    def test_the_clearance_is_that_of_the_floor(self):
        """The nearest cell that is no floor is 10 rows away from the middle of the hall."""
        clearance = cut(HALL, make_evidence(make_classes(HALL.shape))).clearance
        assert clearance[10, 20] == pytest.approx(10, abs=0.1)
        assert clearance[0, 0] == 0
