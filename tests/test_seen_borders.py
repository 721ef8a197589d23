"""Doors lead over floor that was seen."""

import numpy as np
import pytest

from pianta.layout.structure.reconstruct import drop_unseen_lines
from tests.drawn_maps import carve

LINE = np.array([[[2, 0], [2, 10]]], float)


@pytest.mark.parametrize(("columns", "count"), [(5, 0), (6, 1)])
def test_half_of_a_border_with_a_door_was_seen(columns, count):
    """Of the 17 positions from column 1 to 9, 8 round to a column below 5, and 9 or 10 to one below 6."""
    seen_cells = carve((5, 11), (0, 5, 0, columns))
    assert drop_unseen_lines(LINE, seen_cells).tolist() == LINE[:count].tolist()


def test_what_is_behind_the_jambs_counts_for_nothing():
    """The ends of a line are cells of the two jambs."""
    assert len(drop_unseen_lines(LINE, carve((5, 11), (0, 5, 1, 10)))) == 1


def test_no_border_at_all():
    assert drop_unseen_lines(LINE[:0], np.ones((5, 11), bool)).shape == (0, 2, 2)
