"""Constraints: what contradicts itself, what no building can have, and how far a building is from them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pianta.errors import LabelError, OptionError
from pianta.generation.constraints import MAX_ROOMS, Constraints
from tests.generated_types import SCHOOL

LABELS = ["CLASSROOM", "GYM"]


def test_labels_in_any_case():
    constraints = Constraints(at_least={" class  room": 2, "gym": 1}, at_most={"Gym": 3})
    assert constraints.at_least == {"CLASS ROOM": 2, "GYM": 1}
    assert constraints.at_most == {"GYM": 3}


@pytest.mark.parametrize("field", ["at_least", "at_most"])
def test_a_label_twice(field):
    with pytest.raises(LabelError, match="GYM"):
        replace(Constraints(), **dict[str, Any]({field: {"gym": 1, "GYM ": 2}}))


def test_whether_there_are_any():
    assert not Constraints()
    assert not Constraints(at_least={}, at_most={})
    assert Constraints(rooms=(1, 2))
    assert Constraints(at_least={"gym": 0})
    assert Constraints(at_most={"gym": 0})


@pytest.mark.parametrize(
    ("constraints", "message"),
    [
        ({"at_least": {"gym": -1}}, "-1"),
        ({"at_most": {"gym": 10**30}}, f"{10**30}"),
        ({"rooms": (0, 5)}, "range"),
        ({"rooms": (6, 5)}, "range"),
        ({"rooms": (1, 10**30)}, str(10**30)),
        (
            {"at_least": {"gym": 3}, "at_most": {"gym": 2}},
            "GYM",
        ),
        (
            {"rooms": (1, 5), "at_least": {"gym": 3, "classroom": 3}},
            "labels",
        ),
    ],
)
def test_constraints_that_contradict_themselves(constraints, message):
    with pytest.raises(OptionError, match=rf"^[^\n]*{message}[^\n]*$"):
        Constraints(**constraints)


def test_all_faults_are_in_one_line():
    with pytest.raises(OptionError) as caught:
        Constraints(rooms=(9, 3), at_least={"gym": -1, "classroom": 4}, at_most={"classroom": 1})
    assert str(caught.value).count(";") == 2
    assert "\n" not in str(caught.value)


def test_what_is_just_possible():
    assert Constraints(rooms=(5, 5), at_least={"gym": 2, "classroom": 3}, at_most={"gym": 2})
    assert Constraints(rooms=(1, MAX_ROOMS), at_most={"gym": MAX_ROOMS})


def test_misses_by_hand():
    constraints = Constraints(rooms=(4, 6), at_least={"gym": 1}, at_most={"classroom": 3})
    # 0 + 0: four rooms and a gym too few. 3 + 1: as wished. 5 + 0: no gym, two classrooms too many. 8 + 2: four rooms
    # and five classrooms too many.
    counts = np.array([[0, 0], [3, 1], [5, 0], [8, 2]])
    assert constraints.count_violations(counts, LABELS).tolist() == [5, 0, 3, 9]
    assert Constraints().count_violations(counts, LABELS).tolist() == [0, 0, 0, 0]


def check(constraints: Constraints, *, fewest: dict[str, int], most: dict[str, int]) -> None:
    """Check by the rooms of two labels, and of all."""
    fixed, possible = ([counts.get(label, 0) for label in SCHOOL.by_name] for counts in (fewest, most))
    constraints.check(np.array([*fixed, sum(fixed)]), np.array([*possible, sum(possible)]), SCHOOL)


def test_constraints_that_can_be_met():
    fixed, most = {"CLASSROOM": 2}, {"CLASSROOM": 10, "GYM": 1}
    check(Constraints(), fewest=fixed, most=most)
    constraints = Constraints(rooms=(11, 11), at_least={"classroom": 10, "gym": 1}, at_most={"gym": 1})
    check(constraints, fewest=fixed, most=most)
    check(Constraints(rooms=(1, 2), at_most={"classroom": 2, "gym": 0}), fewest=fixed, most=most)


@pytest.mark.parametrize(
    ("constraints", "message"),
    [
        (Constraints(at_least={"gym": 2}), "GYM"),
        (
            Constraints(at_most={"classroom": 1}),
            "CLASSROOM",
        ),
        (Constraints(rooms=(1, 1)), "rooms"),
        (Constraints(rooms=(12, 20)), "12"),
        (Constraints(at_least={"lab": 1}), "LAB"),
        (Constraints(at_most={"no such": 1}), "NO SUCH"),
    ],
)
def test_constraints_that_no_building_can_meet(constraints, message):
    with pytest.raises(OptionError, match=rf"^[^\n]*{message}[^\n]*$"):
        check(constraints, fewest={"CLASSROOM": 2}, most={"CLASSROOM": 10, "GYM": 1})


def test_all_impossible_constraints_are_reported():
    constraints = Constraints(rooms=(99, 99), at_least={"gym": 2, "lab": 1}, at_most={"classroom": 1})
    with pytest.raises(OptionError) as caught:
        check(constraints, fewest={"CLASSROOM": 2}, most={"CLASSROOM": 10, "GYM": 1})
    assert str(caught.value).count(";") == 3
