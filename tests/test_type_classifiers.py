import numpy as np
import pytest

from pianta_bench.harness.tables import read_published
from pianta_bench.types.classifiers import (
    ALGORITHMS,
    cross_validate,
    divide,
    measure_transfer,
    share_misled,
    share_rows,
)
from pianta_bench.types.room_sets import RoomSet
from pianta_bench.types.tables import derive_means


def make_rooms(scale: float = 1.0, *, rooms: int = 60, buildings: int = 6) -> RoomSet:
    """Small, medium and big rooms whose areas do not overlap, in buildings of equal size."""
    random = np.random.default_rng(1)
    sizes = np.arange(rooms) % 3
    areas = scale * (np.array([5, 20, 80])[sizes] + random.random(rooms))
    geometry = np.column_stack([areas, np.ones((rooms, 2))])
    building_names = np.array([f"b{building}" for building in np.arange(rooms) * buildings // rooms])
    return RoomSet("School", geometry, np.zeros((rooms, 5)), np.array([*"SMB"])[sizes], building_names, {})


def test_confusion_by_hand():
    # In the order of CHSMB, of the true C C C C S S M as C C S B S C M.
    table = np.array([[2, 0, 1, 0, 1], [0] * 5, [1, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0] * 5])
    shares = share_rows(table)
    assert shares[0].tolist() == [0.5, 0, 0.25, 0, 0.25]
    assert np.isnan(shares[1]).all()
    # Of 3 rooms that are not C one was called C; of 5 that are not S one was called S; of all 7 one was called B.
    assert share_misled(table) == pytest.approx([1 / 3, 0, 1 / 5, 0, 1 / 7])


def test_the_published_table_is_counted_so_but_for_one_label_a_set():
    shares = {
        (record["part"], record["label"]): float(record["mean"])
        for record in read_published("table_4_2.csv")
        if record["metric"] == "share"
    }
    cells = {
        (record["part"], record["label"], record["given"]): float(record["mean"])
        for record in read_published("table_4_3.csv")
    }
    odd = {}
    for name in ("House", "School", "Office", "H+S+O"):
        rows = np.array([[cells[name, label, predicted] for predicted in "CHSMB"] for label in "CHSMB"])
        assert rows.sum(axis=1) == pytest.approx([100] * 5, abs=0.3)
        rooms = np.array([shares[name, label] for label in "CHSMB"])
        counts = np.round(100 * rooms[:, None] * rows).astype(int)
        off = np.abs(100 * share_misled(counts) - [cells[name, "FN", predicted] for predicted in "CHSMB"])
        # Table 4.2 rounds the shares of labels and is of all folds: 1.6 points at most, or 17 and more.
        assert not ((off > 1.6) & (off < 17)).any()
        odd[name] = ["CHSMB"[label] for label in np.flatnonzero(off > 1.6)]
    assert odd == {"House": ["C"], "School": ["S"], "Office": ["C"], "H+S+O": ["S"]}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_algorithm_distinguishes_areas(algorithm):
    rooms = make_rooms()
    learnt = ALGORITHMS[algorithm](0).fit(rooms.geometry, rooms.labels)
    fresh = make_rooms(1.01)
    assert (learnt.predict(fresh.geometry) == fresh.labels).all()


@pytest.mark.slow
@pytest.mark.parametrize("divided", ["rooms", "buildings"])
def test_a_set_without_overlap_is_labelled_rightly(divided):
    measured = cross_validate(make_rooms(), representation="with neighbours", divided=divided, seed=0)
    assert {accuracy for folds in measured.accuracies.values() for accuracy in folds} == {1.0}
    assert {name: len(folds) for name, folds in measured.accuracies.items()} == dict.fromkeys(
        ALGORITHMS, 10 if divided == "rooms" else 6
    )
    assert measured.confusion[2:, 2:].tolist() == np.eye(3).tolist()
    assert np.isnan(measured.confusion[:2]).all()
    assert measured.misled.tolist() == [0] * 5


def test_folds_hold_every_room_once_and_no_building_is_on_both_sides():
    rooms = make_rooms()
    for divided in ("rooms", "buildings"):
        folds = divide(rooms, divided=divided, seed=4)
        assert sorted(np.concatenate([test for _, test in folds])) == list(range(60))
    for train, test in folds:
        assert not {*rooms.buildings[train]} & {*rooms.buildings[test]}


def test_the_seed_sets_the_folds():
    tests = [[rows.tolist() for _, rows in divide(make_rooms(), divided="rooms", seed=seed)] for seed in (1, 1, 2)]
    assert tests[0] == tests[1] != tests[2]


@pytest.mark.slow
def test_labels_rarer_than_folds_do_no_harm():
    rooms = make_rooms()
    rooms.labels[0] = "H"
    measured = cross_validate(rooms, representation="a, d, rt", divided="rooms", seed=0)
    # The one H is small, and whoever has not seen it calls it so; all others are labelled rightly.
    assert measured.confusion[1].tolist() == [0, 0, 1, 0, 0]
    assert measured.confusion[2:, 2:].tolist() == np.eye(3).tolist()


@pytest.mark.slow
def test_a_type_with_other_sizes_is_mistaken():
    # Areas four times as large: S looks like M and M like B.
    measured = measure_transfer(make_rooms(), make_rooms(4), representation="a, d, rt", seed=0)
    assert {name: len(runs) for name, runs in measured.items()} == dict.fromkeys(ALGORITHMS, 10)
    for runs in (measured["DT"], measured["K-NN"]):
        assert runs == pytest.approx([1 / 3] * 10)


def test_means_and_deviations_by_hand():
    records = [
        {"part": "School", "algorithm": name, "value": accuracy}
        for name, folds in (("DT", (0.5, 0.7)), ("RI", (0.8, 0.8)))
        for accuracy in folds
    ]
    means = {record["algorithm"]: record["value"] for record in derive_means(records, ("part",))}
    assert means == {
        "mean": pytest.approx(0.7),
        "sd of algorithms": pytest.approx(0.2 / 2**0.5),
        "sd of folds": pytest.approx(0.1 / 2**0.5),
    }
