"""Buildings classified from fact files: which files are read, what is left out, and how settings are chosen."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pianta.errors import DataError
from pianta.labels import LabelConvention, LabelSet
from pianta.relational.fact_files import save_interpretations
from pianta.relational.facts import Fact, Interpretation
from pianta.relational.interpretation import LABEL, ROOM, label_atom
from pianta.relational.kernels import fit_svm
from pianta_bench.buildings import fact_files
from pianta_bench.buildings.fact_files import (
    CHOSEN,
    FILES,
    SETTINGS,
    FactFloor,
    FactScores,
    Setting,
    classify_facts,
    list_fact_steps,
    name_item,
    read_fact_floors,
)
from pianta_bench.buildings.floors import BuildingFloor, read_building_floors
from pianta_bench.buildings.models import KLOG, FloorScores
from pianta_bench.buildings.tables import fill_fact_files
from tests.tiny_types import write_types

TYPE = LabelSet.TYPE
# One bin hides the sizes of rooms, by which these few floors differ: only labels and doors count.
HIDDEN_SIZES = Setting(1, 10.0)


def label_facts(floor: BuildingFloor, label_set: LabelSet) -> Interpretation:
    """The facts of a floor, under a name as the thesis gives them, with labels of any set."""
    annotated = floor.annotated
    name = f"i{annotated.kind}{annotated.item}_updatedxml"
    if label_set is not TYPE:
        return replace(floor.labelled_facts[label_set], name=name)
    rooms = zip(floor.facts.entities(ROOM), annotated.floor.rooms, strict=True)
    labels = tuple(Fact(LABEL.name, (entity, label_atom(str(room.label)))) for entity, room in rooms)
    return Interpretation(name, floor.facts.facts + labels)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four schools, the first two of one building, and three offices, with their fact files."""
    data = tmp_path_factory.mktemp("facts")
    write_types(data, "school", buildings=4)
    write_types(data, "office", buildings=3)
    records = [{"path": f"buildings/school/school{number}.xml", "building": "plans"} for number in (0, 1)]
    (data / "manifest.json").write_text(json.dumps(records))
    (data / "klog").mkdir()
    floors, _ = read_building_floors(data, convention=LabelConvention.EXPERIMENTS)
    for label_set, ending in FILES.items():
        for building_type in ("school", "office"):
            facts = [label_facts(floor, label_set) for floor in floors if floor.annotated.kind == building_type]
            save_interpretations(data / "klog" / f"{building_type}_{ending}.pl", facts)
    return data


@pytest.fixture(scope="module")
def floors(tiny: Path) -> list[FactFloor]:
    return read_fact_floors(tiny)


def copy_facts(tiny: Path, data: Path) -> Path:
    folder = data / "klog"
    folder.mkdir()
    for file in (tiny / "klog").iterdir():
        (folder / file.name).write_text(file.read_text())
    return folder


def test_floors_have_the_buildings_of_the_manifest(floors):
    named = {floor.item: floor.building for floor in floors}
    assert named == {
        **{f"school{number}": "school/plans" for number in (0, 1)},
        **{
            f"{building_type}{number}": f"{building_type}/{building_type}{number}"
            for building_type, number in (("school", 2), ("school", 3))
        },
        **{f"office{number}": f"office/office{number}" for number in range(3)},
    }
    labels = {
        label_set: {str(fact.arguments[1]) for fact in facts.facts_of("label")}
        for label_set, facts in floors[0].facts.items()
    }
    assert labels[LabelSet.R_C] == {"lroom", "lcorridor"}
    assert labels[TYPE] == {"lclassroom", "lcloset", "lcorridor", "lhall"}


@pytest.mark.parametrize(
    ("name", "building_type", "item"),
    [
        ("ioffice130604FloorPlanwithFurniture_smallxml", "office", "130604floorplanwithfurnituresmall"),
        ("ischoolsouthmountainschool_1_updatedxml", "school", "southmountainschool1"),
    ],
)
def test_names_of_drawings(name, building_type, item):
    assert name_item(name, building_type) == item


@pytest.mark.slow
def test_a_building_is_classified_without_its_floors(floors):
    """Other labels and another type of one floor of a building do not change the scores of the other."""
    scores = classify_facts(floors, TYPE, SETTINGS[:1]).values
    other = replace(floors[1], kind="office", facts={**floors[1].facts, TYPE: floors[-1].facts[TYPE]})
    changed = classify_facts([floors[0], other, *floors[2:]], TYPE, SETTINGS[:1]).values
    np.testing.assert_allclose(changed[0], scores[0])
    assert not np.allclose(changed[2:], scores[2:]), "the other buildings are trained on it"


@pytest.mark.slow
def test_names_of_labels_reveal_the_type(floors):
    scores = classify_facts(floors, TYPE, [HIDDEN_SIZES])
    assert not FactScores(floors, {(KLOG, TYPE): scores}).wrong_floors(KLOG, TYPE).any()


@pytest.mark.slow
def test_the_chosen_setting_has_the_fewest_errors_in_training(floors, monkeypatch):
    chosen: list[float] = []
    fit = fit_svm

    def fit_badly(gram, truth, *, cost):
        chosen.append(cost)
        # With C = 2 all types are turned around.
        turned = {"school": "office", "office": "school"}
        return fit(gram, [turned[name] for name in truth] if cost == 2 else truth, cost=cost)

    monkeypatch.setattr(fact_files, "fit_svm", fit_badly)
    scores = classify_facts(floors, TYPE, (Setting(1, 2.0), HIDDEN_SIZES))
    assert not FactScores(floors, {(CHOSEN, TYPE): scores}).wrong_floors(CHOSEN, TYPE).any()
    # Of six buildings each is left out; of the other five each once with both settings; then the better one counts.
    assert len(chosen) == 6 * (5 * 2 + 1)
    assert chosen[10::11] == [10.0] * 6


def test_table_by_hand(floors):
    right = np.array([[0, 1.0]] * 4 + [[1.0, 0]] * 3)
    wrong = right.copy()
    # Types are in the order of their names: the first school and the last two offices are wrong.
    wrong[[0, 5, 6]] = wrong[[0, 5, 6], ::-1]
    types = {
        (model, label_set): FloorScores(wrong if model == KLOG else right)
        for model in (KLOG, CHOSEN)
        for label_set in FILES
    }
    scores = FactScores(floors, types)
    assert scores.wrong_floors(KLOG, TYPE).tolist() == [True, False, False, False, False, True, True]
    (table,) = fill_fact_files(scores)
    assert [cell.mean for cell in table.rows[KLOG].values()] == pytest.approx([300 / 7, 100 * (1 / 4 + 2 / 3) / 2] * 3)
    assert [cell.mean for cell in table.rows[CHOSEN].values()] == [0] * 6
    assert [cell.published_mean for cell in table.rows[KLOG].values()] == [8, None, 8, None, None, None]
    assert f"Wrong, {KLOG}, type: school0, office1, office2." in table.notes
    assert scores.as_json()[0]["building"] == "school/plans"


def test_without_fact_files_nothing_is_classified(tmp_path):
    assert read_fact_floors(tmp_path) == []
    assert [*list_fact_steps([])] == []


def test_fact_files_that_cannot_be_used(tiny, tmp_path):
    folder = copy_facts(tiny, tmp_path)
    text = (folder / "office_all.pl").read_text()
    (folder / "office_all.pl").unlink()
    with pytest.raises(DataError, match=r"office_all\.pl"):
        read_fact_floors(tmp_path)
    (folder / "office_all.pl").write_text(text.replace("office2", "office9"))
    with pytest.raises(DataError, match="different floors"):
        read_fact_floors(tmp_path)
    for ending in FILES.values():
        file = folder / f"office_{ending}.pl"
        lines = (tiny / "klog" / file.name).read_text().splitlines()
        file.write_text("\n".join(line for line in lines if "office2" not in line))
    with pytest.raises(DataError, match=r"offices.*2 buildings"):
        read_fact_floors(tmp_path)
