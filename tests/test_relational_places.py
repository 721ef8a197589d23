"""Rooms and floors learnt from facts: tiny floors whose labels follow only from the neighbouring rooms."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from shapely import box

from pianta.errors import ModelError, OptionError, RelationError
from pianta.floor import Floor, Room
from pianta.relational.classifiers import RelationalRoomClassifier, RelationalTypeClassifier, to_interpretations
from pianta.relational.fact_files import read_interpretations, read_signatures, save_interpretations
from pianta.relational.facts import LISTING_SIGNATURES, Fact, Interpretation
from pianta.relational.kernels import FloorKernel, RoomKernel, decide, fit_svm


def describe_row(
    name: str, rooms: int, *, first: str = "r", labelled: bool = True, building_type: str = "school"
) -> Interpretation:
    """Rooms of one size in a row, each with a door to the next; the ends are stairs."""
    ids = [f"{first}{number}" for number in range(rooms)]
    facts = [Fact("buildingtype", (building_type,))] if building_type else []
    facts += [Fact("room", (room,)) for room in ids]
    facts += [Fact("area", (room, 20.0)) for room in ids]
    facts += [Fact("connected", pair) for pair in pairwise(ids)]
    if labelled:
        facts += [Fact("label", (room, "lstairs" if room in (ids[0], ids[-1]) else "lcorridor")) for room in ids]
    return Interpretation(name, tuple(facts))


def test_rooms_are_classified_by_their_neighbours():
    classifier = RelationalRoomClassifier().fit([describe_row("a", 4), describe_row("b", 6)])
    assert classifier.labels_ == {"label": ("lcorridor", "lstairs")}
    new = describe_row("c", 5, first="s", labelled=False)
    assert classifier.predict([new]) == {"label": [["lstairs", *["lcorridor"] * 3, "lstairs"]]}


def test_labels_are_hidden_from_the_kernel():
    classifier = RelationalRoomClassifier().fit([describe_row("a", 4), describe_row("b", 6)])
    new = describe_row("c", 5)
    wrong = replace(
        new, facts=(*new.without("label").facts, Fact("label", ("r0", "lcorridor")), Fact("iscorr", ("r0",)))
    )
    for one, other in zip(classifier.decide([new])["label"], classifier.decide([wrong])["label"], strict=True):
        np.testing.assert_array_equal(one, other)


def test_two_label_sets_share_a_matrix():
    floors = [describe_row("a", 4, labelled=False), describe_row("b", 6, labelled=False)]
    ends = [["E", *["M"] * 2, "E"], ["E", *["M"] * 4, "E"]]
    three = [["E", "N", "N", "E"], ["E", "N", "M", "M", "N", "E"]]
    classifier = RelationalRoomClassifier().fit(floors, {"ends": ends, "three": three})
    assert classifier.predict(floors) == {"ends": ends, "three": three}
    decided = classifier.decide(floors)
    assert [values.shape for values in decided["ends"]] == [(4, 2), (6, 2)]
    assert [values.shape for values in decided["three"]] == [(4, 3), (6, 3)]


def test_training_on_floors_equals_training_on_their_facts():
    def draw(width: float) -> Floor:
        rooms = [
            Room(1, box(0, 0, 20, 2), "CORRIDOR"),
            *(Room(n, box(0, 2, width, 2 + width), "OFFICE") for n in (2, 3)),
        ]
        return Floor(tuple(rooms), building_type={"office": 1.0}, source=f"{width}")

    floors = [draw(3), draw(3.5), draw(4)]
    classifier = RelationalRoomClassifier().fit(floors[:2])
    assert classifier.predict(floors[2:]) == {"label": [["lcorridor", "loffice", "loffice"]]}
    interpretations = to_interpretations(floors[:2])
    assert RelationalRoomClassifier().fit(interpretations).predict(floors[2:]) == classifier.predict(floors[2:])


def test_fact_files(tmp_path: Path):
    file = tmp_path / "facts.pl"
    save_interpretations(
        file,
        [
            describe_row("a", 4, building_type=""),
            describe_row("b", 6, building_type=""),
            describe_row("c", 5, building_type=""),
        ],
    )
    floors = read_interpretations(file)
    classifier = RelationalRoomClassifier(RoomKernel(signatures=read_signatures(file))).fit(floors[:2])
    assert classifier.predict(floors[2:])["label"] == [["lstairs", *["lcorridor"] * 3, "lstairs"]]


def test_a_fact_file_without_the_signature_of_an_entity(tmp_path: Path):
    """No fact can declare the entity: the missing signature is reported once."""
    file = tmp_path / "facts.pl"
    file.write_text("signature a(x::wing)::extensional.\ninterpretation(f,a(q)).\ninterpretation(f,a(r)).\n")
    with pytest.raises(RelationError) as raised:
        read_interpretations(file)
    assert re.search(r"facts\.pl': line 2: .*wing", str(raised.value))
    file.write_text(f"signature wing(id::self)::extensional.\ninterpretation(f,wing(q)).\n{file.read_text()}")
    with pytest.raises(RelationError, match="wing"):
        read_interpretations(file)


def test_entities_of_another_name():
    def describe(name: str, count: int) -> Interpretation:
        facts = describe_row(name, count, building_type="").facts
        return Interpretation(name, tuple(replace(f, relation="space") if f.relation == "room" else f for f in facts))

    classifier = RelationalRoomClassifier(RoomKernel(signatures=LISTING_SIGNATURES)).fit(
        [describe("a", 4), describe("b", 6)]
    )
    assert classifier.predict([describe("c", 3)])["label"] == [["lstairs", "lcorridor", "lstairs"]]


@pytest.mark.slow
def test_files_of_the_data(data):
    file = data / "klog" / "office_RC.pl"
    if not file.is_file():
        pytest.skip(f"no {file}")
    floors = read_interpretations(file)
    classifier = RelationalRoomClassifier(RoomKernel(signatures=read_signatures(file))).fit(floors[1:])
    truth = [str(fact.arguments[1]) for fact in floors[0].facts_of("label")]
    predicted_labels = dict(
        zip(classifier.kernel.list_rooms(floors[0]), classifier.predict(floors[:1])["label"][0], strict=True)
    )
    wrong = sum(predicted_labels[fact.arguments[0]] != fact.arguments[1] for fact in floors[0].facts_of("label"))
    assert wrong / len(truth) < 0.15
    assert set(predicted_labels.values()) == {"lroom", "lcorridor"}


def test_bins_may_come_from_elsewhere():
    """Rooms of 20 m² and 30 m² are in different bins only if the bins are fitted on floors of both sizes."""
    small, large = (
        Interpretation(name, (Fact("room", ("r",)), Fact("area", ("r", area)))) for name, area in (("a", 20), ("b", 30))
    )
    both = RoomKernel().fit([small, large])
    np.testing.assert_array_less(both.compare()[0, 1], 1)
    alone = RoomKernel().fit([small, large], binned=[replace(small, facts=(*small.facts[:1], Fact("area", ("r", 10))))])
    np.testing.assert_allclose(alone.compare(), 1)


def test_floors_are_classified_by_their_patterns():
    def star(name: str, rooms: int, building_type: str = "office") -> Interpretation:
        ids = [f"r{number}" for number in range(rooms)]
        facts = [Fact("buildingtype", (building_type,)), *(Fact("room", (room,)) for room in ids)]
        return Interpretation(name, (*facts, *(Fact("connected", (ids[0], room)) for room in ids[1:])))

    floors = [*(describe_row("", n, labelled=False) for n in (4, 5, 6)), *(star("", n) for n in (4, 5, 6))]
    buildings = RelationalTypeClassifier().fit(floors)
    assert buildings.types_ == ("office", "school")
    new = [star("", 7), describe_row("", 7, labelled=False)]
    assert buildings.predict(new) == ["office", "school"]
    # The type in the facts must not be used.
    assert buildings.predict([star("", 7, "school")]) == ["office"]
    assert RelationalTypeClassifier().fit(floors, ["x", "x", "x", "y", "y", "y"]).predict(new) == ["y", "x"]


def test_decisions_of_labels_not_learnt_are_the_lowest():
    gram = np.eye(2)
    machine = fit_svm(gram, ["a", "c"])
    decided = decide(machine, gram, ["a", "b", "c"])
    assert decided.argmax(axis=1).tolist() == [0, 2]
    assert decided.argmin(axis=1).tolist() == [1, 1]


def test_a_repeated_label_counts_once():
    row = describe_row("a", 4)
    twice = replace(row, facts=(*row.facts, *row.facts_of("label")))
    classifier = RelationalRoomClassifier().fit([twice])
    assert classifier.predict([row]) == RelationalRoomClassifier().fit([row]).predict([row])


def test_nothing_to_predict():
    classifier = RelationalRoomClassifier().fit([describe_row("a", 4), describe_row("b", 6)])
    empty = Interpretation("e", (Fact("buildingtype", ("school",)),))
    assert classifier.predict([]) == {"label": []}
    assert classifier.predict([empty]) == {"label": [[]]}
    assert [values.shape for values in classifier.decide([empty, describe_row("c", 3), empty])["label"]] == [
        (0, 2),
        (3, 2),
        (0, 2),
    ]
    buildings = RelationalTypeClassifier().fit([describe_row("a", 4), describe_row("b", 5, building_type="office")])
    assert buildings.predict([]) == []
    assert buildings.decide([]).shape == (0, 2)


@pytest.mark.parametrize("fact", [Fact("label", ("r1",)), Fact("room", ()), Fact("buildingtype", ())])
def test_facts_of_wrong_arity(fact):
    rows = [describe_row("a", 4), describe_row("b", 6, building_type="office")]
    wrong = replace(rows[0], facts=(*rows[0].facts, fact))
    for classifier in (RelationalRoomClassifier(), RelationalTypeClassifier()):
        with pytest.raises(RelationError, match="argument"):
            classifier.fit([wrong, rows[1]])
        with pytest.raises(RelationError, match="argument"):
            classifier.fit(rows).predict([wrong])


def test_bad_input():
    row = describe_row("a", 4)
    with pytest.raises(ModelError, match="r0"):
        RelationalRoomClassifier().fit([row.without("label")])
    with pytest.raises(ModelError, match="labels"):
        RelationalRoomClassifier().fit([row], {"x": [["a"]]})
    with pytest.raises(ModelError, match="labels"):
        RelationalRoomClassifier().fit([row], {"x": [["a"] * 4]})
    with pytest.raises(ModelError, match="fit"):
        RelationalRoomClassifier().predict([row])
    with pytest.raises(OptionError, match="colour"):
        RelationalRoomClassifier(RoomKernel(target="colour"))
    with pytest.raises(OptionError, match="entity"):
        RoomKernel(target="buildingtype")
    with pytest.raises(RelationError, match="signature"):
        RelationalRoomClassifier(RoomKernel(signatures=LISTING_SIGNATURES)).fit([row])
    with pytest.raises(ModelError, match="buildingtype"):
        RelationalTypeClassifier().fit([row.without("buildingtype")])
    with pytest.raises(ModelError, match="lstairs, lcorridor"):
        RelationalRoomClassifier().fit([replace(row, facts=(*row.facts, Fact("label", ("r0", "lcorridor"))))])
    with pytest.raises(ModelError, match="types"):
        RelationalTypeClassifier().fit([row, row], ["x"])
    with pytest.raises(ModelError, match="fit"):
        FloorKernel().compare([row])
