"""`pianta bench exploration`: on tiny schools, and by hand-made runs whose ratios are known."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest

from pianta.errors import DataError, OptionError
from pianta.exploration.classical_policies import NearestFrontier
from pianta.exploration.explore import explore
from pianta.exploration.frontiers import Frontier
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.world import build_world
from pianta.floor import Floor
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.exploration import DRAWN_SET, SYNTHETIC
from pianta_bench.exploration import buildings as exploration_buildings
from pianta_bench.exploration import measure as exploration_measure
from pianta_bench.exploration.buildings import draw_buildings, make_buildings, read_buildings
from pianta_bench.exploration.figures import average_curves, draw_curves, draw_tracks
from pianta_bench.exploration.measure import measure
from pianta_bench.exploration.policies import COMPARED_POLICIES, NEAREST, ComparedPolicy, choose_policies
from pianta_bench.exploration.runs import (
    CURVE,
    TO_ROOM,
    Run,
    RunSettings,
    measure_search,
    name_share,
    run_building,
)
from pianta_bench.exploration.scores import compare_policies, compare_sums, find_best, pair_runs
from pianta_bench.exploration.tables import tabulate, tabulate_predicting, tabulate_ranks
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.report import save_results
from tests.command_line import list_files, run_pianta
from tests.explored_worlds import two_rooms
from tests.tiny_data import read_as_buildings, write_schools

SCHOOLS = "KKKW-KL", "KKS-KK", "LLW-KKK", "KKC-LK", "LLC-KKW", "KK-KWL"
POLICIES = (NEAREST, "gain", "ours")
TO_90 = name_share(0.9)


@dataclass
class FakePredicting:
    """A stand-in for a policy that predicts: the nearest frontier; it remembers what it was made of."""

    sampler: FloorSampler | None
    find: str | None

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        if self.find == "CLOSET":
            msg = "no closets"
            raise ValueError(msg)
        return NearestFrontier().choose(inputs)


POLICIES_MADE: list[FakePredicting] = []


def make_fake(*, sampler: FloorSampler | None, find: str | None) -> FakePredicting:
    POLICIES_MADE.append(FakePredicting(sampler, find))
    return POLICIES_MADE[-1]


REGISTRY = {
    NEAREST: COMPARED_POLICIES[NEAREST],
    "gain": COMPARED_POLICIES["gain"],
    "ours": ComparedPolicy(make_fake, predicts=True),
}


@pytest.fixture(autouse=True, scope="module")
def few_scans_and_floors():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exploration_measure, "TIMED", {True: 10, False: 2})
        patch.setattr(exploration_buildings, "SYNTHETIC_SEEDS", range(1))
        yield


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six schools, and one that cannot be read."""
    data = tmp_path_factory.mktemp("data")
    write_schools(data, *SCHOOLS)
    (data / "buildings" / "school" / "unreadable.xml").write_text("<building/>")
    return data


@pytest.fixture(scope="module")
def measured(tiny) -> Results:
    """Robots search for labels that one other school has."""
    POLICIES_MADE.clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exploration_buildings, "MIN_OTHER_FLOORS", 1)
        # The names of tiny schools end with a number, as those of the floors of one building.
        patch.setattr("pianta_bench.exploration.buildings.read_annotated_buildings", read_as_buildings)
        return measure(tiny, sets=["school"], starts=1, resolution=0.25, registry=REGISTRY)


class TestDrawnSchools:
    def test_they_are_whole_and_policies_learn_from_the_real_ones(self, tiny, monkeypatch):
        monkeypatch.setattr(exploration_buildings, "DRAWN_SCHOOLS", 3)
        monkeypatch.setattr("pianta_bench.exploration.buildings.read_annotated_buildings", read_as_buildings)
        building_set = draw_buildings(tiny)
        assert len(building_set.buildings) == 3
        for building in building_set.buildings:
            assert (building.part, building.building_type, len(building.others)) == (DRAWN_SET, "school", len(SCHOOLS))
            assert nx.is_connected(building.floor.graph())
        assert building_set.notes[0].startswith("Generated and drawn with all doors; ")
        again = draw_buildings(tiny)
        assert [building.floor for building in again.buildings] == [
            building.floor for building in building_set.buildings
        ]

    def test_too_few_schools_are_an_error(self, tmp_path):
        write_schools(tmp_path, "KKKW-KL")
        with pytest.raises(DataError, match="1 schools are too few to learn a model from, give 3 or more"):
            draw_buildings(tmp_path)

    def test_ranks_are_those_of_mean_metres(self):
        """To 90 % gain is the first in real schools, nearest in drawn ones; other shares have no runs."""
        results = Results({"policies": ["nearest", "gain", "ours"], "sets": ["school", DRAWN_SET]})
        metres = {"school": ((30, 10, 20), (30, 20, 10)), DRAWN_SET: ((10, 20, 20),)}
        for part, buildings in metres.items():
            for number, values in enumerate(buildings):
                for policy, value in zip(results.options["policies"], values, strict=True):
                    results.add(
                        part, f"{number}", {TO_90: value}, building=f"{number}", start=1, policy=policy, label=None
                    )
        table = tabulate_ranks(results)
        ranks = {policy: [row[f"90 %\n{part}"].mean for part in metres] for policy, row in table.rows.items()}
        assert ranks == {"nearest": [3, 1], "gain": [1, 2], "ours": [1, 2]}
        assert [*table.notes] == ["90 %: Kendall's tau -1.00."]


def list_runs(results: Results, *, searches: bool) -> list[Run]:
    return [run for run in results.objects["runs"] if bool(run.label) is searches]


def figures_of(results: Results, run: Run) -> dict[str, Any]:
    return {record["metric"]: record["value"] for record in results.select(item=run.item)}


def records_of(building: str, *tasks: tuple[float | None, ...], label: str | None = None) -> list[Record]:
    """A building of which each task is a start, with the metres of nearest, gain and ours."""
    common = {"part": "school", "building": building, "label": label}
    return [
        {**common, "start": start, "policy": policy, "value": metres}
        for start, task in enumerate(tasks, start=1)
        for policy, metres in zip(POLICIES, task, strict=True)
    ]


RECORDS = [*records_of("one", (100, 80, 60), (200, 160, 140)), *records_of("two", (50, 60, 40), (50, None, 10))]
RUNS = [
    Run("school", record["building"], record["start"], (0.0, 0.0), record["policy"], outcome="done",
        curve=tuple(share * (record["value"] or np.inf) for share in CURVE))
    for record in RECORDS
]  # fmt: skip


def test_buildings_count_alike_whatever_their_starts():
    """Ratios to nearest of 0.6 and 0.7 are 0.65 in one building; 0.8 in the other, whose second start is left out."""
    pairs = pair_runs(RECORDS, POLICIES)
    assert pairs.left_out == ("two start 2: gain",)
    assert pairs.count == 3
    assert pairs.average("ours") == [100, 40]
    interval = compare_policies(pairs, "ours", NEAREST, seed=0)
    assert interval is not None
    assert (interval.mean, interval.low, interval.high, interval.count) == pytest.approx((0.725, 0.65, 0.8, 2))
    sums = compare_sums(pairs, "ours", NEAREST, seed=0)
    assert sums is not None
    assert sums.mean == pytest.approx(140 / 200)


def test_the_best_is_classical_and_has_the_fewest_metres():
    """Nearest needs 150 and 50 m, gain 120 and 60, ours, which predicts, 100 and 40."""
    classical = [NEAREST, "gain"]
    assert find_best(pair_runs(RECORDS, POLICIES), classical) == "gain"
    assert find_best(pair_runs([], POLICIES), classical) is None
    assert find_best(pair_runs(RECORDS, POLICIES), []) is None


def test_searches_in_sight_of_the_start_have_no_ratio():
    records = [*records_of("one", (0, 0, 0), (40, 20, 10), label="GYM"), *records_of("two", (0, 5, 0), label="GYM")]
    pairs = pair_runs(records, POLICIES)
    assert pairs.count == 3
    interval = compare_policies(pairs, "ours", NEAREST, seed=0)
    assert interval is not None
    assert (interval.mean, interval.count) == (0.25, 1)


def test_curves_are_over_starts_from_which_all_reach_the_end():
    curves = average_curves(RUNS, NEAREST, POLICIES)
    assert curves.shape == (2, len(CURVE))
    assert curves[:, 50].tolist() == [75, 25]
    assert average_curves([], NEAREST, POLICIES).shape == (0, len(CURVE))


@pytest.mark.slow
def test_the_room_is_found_where_it_is_recognised():
    world = build_world(two_rooms(), resolution=0.2)
    run = explore(world, NearestFrontier(), starts=[(3.5, 3.5)])
    search = explore(world, NearestFrontier(), starts=[(3.5, 3.5)], find="stairs")
    assert 0 < measure_search(world, run, "STAIRS") == search.distance[-1] < run.distance[-1]
    assert measure_search(world, run, "CLASSROOM") == 0
    assert measure_search(world, run, "GYM") == np.inf


@pytest.mark.slow
def test_every_building_is_explored_by_every_policy(measured):
    explorations = list_runs(measured, searches=False)
    names = [f"school{number}" for number in range(6)]
    assert [*dict.fromkeys(run.building for run in explorations)] == names
    assert [item.item for item in measured.items if item.failure and "CLOSET" not in item.item] == ["unreadable"]
    for name in names:
        runs = {run.policy: run for run in explorations if run.building == name}
        assert [*runs] == [*POLICIES]
        figures = {policy: figures_of(measured, run) for policy, run in runs.items()}
        nearest = figures[NEAREST]
        assert nearest["share"] > 0.99
        metres = [nearest[name_share(share)] for share in (0.8, 0.9, 0.95, 0.99)]
        assert metres == sorted(metres)
        assert metres[-1] <= nearest["metres"]
        same = {key: figure for key, figure in nearest.items() if key != "seconds"}
        assert same == {key: figure for key, figure in figures["ours"].items() if key != "seconds"}


def test_policies_that_predict_get_a_model_of_the_others_and_the_label(measured):
    """The model of each school is of five floors; a search of ours is a run, that of nearest part of an exploration."""
    samplers = {id(policy.sampler): policy.sampler for policy in POLICIES_MADE}
    assert len(samplers) == 6
    sources = [{floor.source for floor in sampler.model.floors} for sampler in samplers.values() if sampler]
    names = {f"school{number}" for number in range(6)}
    assert [names - others for others in sources] == [{f"school{number}"} for number in range(6)]
    searches = list_runs(measured, searches=True)
    assert {policy.find for policy in POLICIES_MADE} - {None} == {run.label for run in searches}
    for building, label in {(run.building, run.label) for run in searches if run.label != "CLOSET"}:
        records = measured.select(building=building, label=label, metric=TO_ROOM)
        metres = {record["policy"]: record["value"] for record in records}
        assert metres[NEAREST] == metres["ours"]


def test_runs_that_fail_are_named_and_left_out_for_all(measured):
    failed = [item for item in measured.items if item.failure and item.item != "unreadable"]
    assert [item.item for item in failed] == ["school3 start 1, ours, CLOSET", "school4 start 1, ours, CLOSET"]
    assert failed[0].failure == "ValueError: no closets"
    assert pair_runs(measured.select(metric=TO_90), POLICIES).count == 6
    left_out = pair_runs(measured.select(metric=TO_ROOM), POLICIES).left_out
    assert left_out == ("school3 start 1, CLOSET: ours", "school4 start 1, CLOSET: ours")


def test_policies_that_predict_against_the_best_and_nearest(measured):
    table = tabulate_predicting(measured)
    cells = table.rows["ours, to 90 %, against nearest (6)"]
    assert [cells[column].mean for column in table.columns] == [100] * 6
    assert [name for name in table.rows if name.startswith("ours, to a room")]


def test_synthetic_floors_have_no_model_and_nothing_to_look_for():
    floors = make_buildings()
    assert [building.name for building in floors.buildings] == ["corridor-0", "l-0", "ring-0", "hall-0"]
    assert all(not building.others and not building.labels for building in floors.buildings)


@pytest.mark.slow
def test_figures_do_not_depend_on_the_processes(monkeypatch):
    monkeypatch.setattr(exploration_buildings, "FLOOR_MAKERS", {"corridor": None, "ring": None})
    records = [
        [
            record
            for record in measure(sets=[SYNTHETIC], policies=["nearest"], starts=1, resolution=0.5, jobs=jobs).records
            if record["metric"] != "seconds"
        ]
        for jobs in (1, 2)
    ]
    assert records[0] == records[1]
    assert len({record["item"] for record in records[0]}) == 2


def test_a_world_without_free_space_is_named():
    building = replace(make_buildings().buildings[0], floor=Floor(()))
    results = run_building(building, RunSettings(choose_policies([NEAREST])))
    assert [(item.item, item.failure) for item in results.items] == [
        ("corridor-0", "the floor has no rooms, give one at least")
    ]
    assert results.records == results.objects["runs"] == []


def test_pictures(measured):
    (ax,) = draw_curves(measured).axes
    assert ax.get_title() == "school: mean of 6 buildings"
    assert [line.get_label() for line in ax.get_lines()] == [*POLICIES]
    figure = draw_tracks(measured.objects["buildings"][0], measured.objects["settings"])
    titles = [ax.get_title() for ax in figure.axes]
    assert [title.split(":")[0] for title in titles if title] == [*POLICIES]


def test_the_file_holds_every_run(measured, tmp_path):
    tables = tabulate(measured)
    save_results("exploration", tables, measured, tmp_path / "figures.json")
    content = json.loads((tmp_path / "figures.json").read_text())
    assert content["bench"] == "exploration"
    assert len(content["runs"]) == len(measured.objects["runs"]) == len(content["items"]) - 1
    assert len(content["tables"]) == len(tables) == 6
    assert content["left_out"]["school"]["searches"]
    assert {run["outcome"] for run in content["runs"] if run["label"] is None} == {"done"}


def test_a_few_floors_are_explored_without_a_model(tmp_path):
    write_schools(tmp_path, "KK-K", "KL-K")
    schools = read_buildings(tmp_path, "school")
    assert [building.others for building in schools.buildings] == [(), ()]
    with pytest.raises(DataError, match="school"):
        read_buildings(tmp_path / "none", "school")
    (tmp_path / "buildings" / "office").mkdir()
    (tmp_path / "buildings" / "office" / "unreadable.xml").write_text("<building/>")
    with pytest.raises(DataError, match="unreadable"):
        read_buildings(tmp_path, "office")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sets": ["castle"]}, "castle"),
        ({"policies": ["random"]}, "random"),
        ({"policies": ["gain"]}, "nearest"),
        ({"resolution": 2.0}, "resolution"),
        ({"jobs": 0}, "starts.*jobs"),
    ],
)
def test_options_without_meaning(options, message):
    with pytest.raises(OptionError, match=message):
        measure(**{"sets": [SYNTHETIC], **options})


def test_policies_are_in_order_and_once():
    assert [*choose_policies(["gain", "nearest", "gain"], REGISTRY)] == ["nearest", "gain"]
    assert choose_policies([], REGISTRY) == REGISTRY


@pytest.mark.slow
def test_command(tiny, tmp_path):
    file, pictures = tmp_path / "new" / "exploration.json", tmp_path / "pictures"
    arguments = "--data", tiny, "--set", "school", "--policy", NEAREST, "--no-searches", "--starts", 1
    outcome = run_pianta(
        "bench", "exploration", *arguments, "--resolution", 0.5, "--json", file, "--pictures", pictures
    )
    assert (outcome.code, outcome.err) == (1, "")
    assert "Distance to a share of the area, school" in outcome.out
    assert "unreadable failed (school): " in outcome.out
    assert {*list_files(pictures)} == {"curves.png", "school_school0.png", "school_school2.png", "school_school5.png"}
    assert json.loads(file.read_text())["options"]["searches"] is False


def test_a_json_file_that_is_a_folder(tmp_path):
    outcome = run_pianta("bench", "exploration", "--json", tmp_path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("error: JSON")
