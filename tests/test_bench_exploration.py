"""`pianta bench exploration`: on tiny schools, and by hand-made runs whose ratios are known."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

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
from pianta_bench._exploration_cli import SET_NAMES
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings
from pianta_bench.exploration import buildings as exploration_buildings
from pianta_bench.exploration import measure as bench_module
from pianta_bench.exploration import policies as exploration_policies
from pianta_bench.exploration import runs as exploration_runs
from pianta_bench.exploration import scores as exploration_scores
from pianta_bench.exploration import tables
from pianta_bench.exploration.buildings import SETS, SYNTHETIC, make_buildings, read_buildings
from pianta_bench.exploration.figures import average_curves, draw_curves, draw_tracks
from pianta_bench.exploration.file import save_exploration
from pianta_bench.exploration.measure import ExplorationBench, measure_exploration
from pianta_bench.exploration.policies import CONTENDERS, NEAREST, Contender, check_policies
from pianta_bench.exploration.runs import CURVE, FOUND, BuildingRuns, Run, RunSettings, measure_search, name_share
from pianta_bench.exploration.scores import (
    average_metres,
    compare_policies,
    compare_sums,
    find_best,
    pair_searches,
    pair_share,
)
from pianta_bench.exploration.tables import tabulate_bars, tabulate_exploration
from pianta_bench.harness.table import Row
from tests.command_line import list_files, run_pianta
from tests.explored_worlds import two_rooms
from tests.tiny_data import write_schools

Made = TypeVar("Made")

SCHOOLS = "KKKW-KL", "KKS-KK", "LLW-KKK", "KKC-LK", "LLC-KKW", "KK-KWL"
POLICIES = (NEAREST, "gain", "ours")


@dataclass
class FakeGuess:
    """A stand-in for a policy that predicts: the nearest frontier; it remembers what it was made of."""

    sampler: FloorSampler | None
    find: str | None

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        if self.find == "CLOSET":
            msg = "no closets"
            raise ValueError(msg)
        return NearestFrontier().choose(inputs)


MADE: list[FakeGuess] = []


def make_guess(sampler: FloorSampler | None, find: str | None) -> FakeGuess:
    MADE.append(FakeGuess(sampler, find))
    return MADE[-1]


@pytest.fixture(autouse=True, scope="module")
def contenders() -> Iterator[None]:
    known = {NEAREST: CONTENDERS[NEAREST], "gain": CONTENDERS["gain"], "ours": Contender(make_guess, predicts=True)}
    with pytest.MonkeyPatch.context() as patch:
        for module in (exploration_policies, exploration_runs, exploration_scores, tables):
            patch.setattr(module, "CONTENDERS", MappingProxyType(known))
        patch.setattr(bench_module, "TIMED", {True: 10, False: 2})
        patch.setattr(exploration_buildings, "SYNTHETIC_SEEDS", range(1))
        yield


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six schools, and one that cannot be read."""
    data = tmp_path_factory.mktemp("data")
    write_schools(data, *SCHOOLS)
    (data / "buildings" / "school" / "strange.xml").write_text("<building/>")
    return data


@pytest.fixture(scope="module")
def measured(tiny) -> ExplorationBench:
    """The labels that are looked for are those that one other school has."""
    MADE.clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exploration_buildings, "LEAST_OTHERS", 1)
        # The names of tiny schools end with a number, as those of the floors of one building.
        patch.setattr("pianta_bench.exploration.buildings.read_annotated_buildings", make_apart)
        return measure_exploration(tiny, sets=["school"], starts=1, resolution=0.25)


def make_apart(data: Path, kind: str, make: Callable[[AnnotatedFloor], Made]) -> tuple[list[Made], tuple[Row, ...]]:
    """read_annotated_buildings with a building for each drawing."""
    return read_annotated_buildings(data, kind, lambda drawn: make(replace(drawn, building=drawn.item)))


def run_of(policy: str, metres: float | None, *, start: int = 0, label: str | None = None) -> Run:
    key = FOUND if label else name_share(0.9)
    curve = tuple(share * (metres or np.inf) for share in CURVE)
    return Run(start, policy, label, Row(f"{policy} {start}", {key: metres}), "done", curve)


def runs_of(name: str, *tasks: tuple[float | None, ...], label: str | None = None) -> BuildingRuns:
    """A building of which each task is a start, with the metres of nearest, gain and ours."""
    runs = [
        run_of(policy, metres, start=start, label=label)
        for start, task in enumerate(tasks)
        for policy, metres in zip(POLICIES, task, strict=True)
    ]
    return BuildingRuns("school", name, ((0.0, 0.0),) * len(tasks), tuple(runs))


RESULTS = [
    runs_of("one", (100, 80, 60), (200, 160, 140)),
    runs_of("two", (50, 60, 40), (50, None, 10)),
]


def test_buildings_count_alike_whatever_their_starts():
    """Ratios to nearest of 0.6 and 0.7 are 0.65 in one building; 0.8 in the other, whose second start is left out."""
    pairs = pair_share(RESULTS, POLICIES, 0.9)
    assert pairs.left_out == ("two start 2: gain",)
    assert pairs.count == 3
    assert average_metres(pairs, "ours") == [100, 40]
    found = compare_policies(pairs, "ours", NEAREST, seed=0)
    assert found is not None
    assert (found.mean, found.low, found.high, found.count) == pytest.approx((0.725, 0.65, 0.8, 2))
    sums = compare_sums(pairs, "ours", NEAREST, seed=0)
    assert sums is not None
    assert sums.mean == pytest.approx(140 / 200)


def test_the_best_is_classical_and_has_the_fewest_metres():
    """Nearest needs 150 and 50 m, gain 120 and 60, ours, which predicts, 100 and 40."""
    assert find_best(pair_share(RESULTS, POLICIES, 0.9), POLICIES) == "gain"
    assert find_best(pair_share([], POLICIES, 0.9), POLICIES) is None
    assert find_best(pair_share(RESULTS, POLICIES, 0.9), ["ours"]) is None


def test_searches_in_sight_of_the_start_have_no_ratio():
    results = [runs_of("one", (0, 0, 0), (40, 20, 10), label="GYM"), runs_of("two", (0, 5, 0), label="GYM")]
    pairs = pair_searches(results, POLICIES)
    assert pairs.count == 3
    found = compare_policies(pairs, "ours", NEAREST, seed=0)
    assert found is not None
    assert (found.mean, found.count) == (0.25, 1)
    assert pair_share(results, POLICIES, 0.9).count == 0


def test_curves_are_over_starts_that_all_reach():
    curves = average_curves(RESULTS, NEAREST, POLICIES)
    assert curves.shape == (2, len(CURVE))
    assert curves[:, 50].tolist() == [75, 25]
    assert average_curves([], NEAREST, POLICIES).shape == (0, len(CURVE))


@pytest.mark.slow
def test_the_room_is_found_where_it_is_recognised():
    world = build_world(two_rooms(), resolution=0.2)
    run = explore(world, NearestFrontier(), starts=[(3.5, 3.5)])
    looked = explore(world, NearestFrontier(), starts=[(3.5, 3.5)], find="stairs")
    assert 0 < measure_search(world, run, "STAIRS") == looked.distance[-1] < run.distance[-1]
    assert measure_search(world, run, "CLASSROOM") == 0
    assert measure_search(world, run, "GYM") == np.inf


@pytest.mark.slow
def test_every_building_is_explored_by_every_policy(measured):
    results = measured.results["school"]
    assert [result.name for result in results] == [f"school{number}" for number in range(6)]
    assert [row.item for row in measured.items["school"] if row.failure and "CLOSET" not in row.item] == ["strange"]
    for result in results:
        explorations = {run.policy: run for run in result.runs if run.label is None}
        assert [*explorations] == [*POLICIES]
        figures = {policy: run.row.figures for policy, run in explorations.items()}
        nearest = figures[NEAREST]
        assert nearest["share"] > 0.99
        ways = [nearest[name_share(share)] for share in (0.8, 0.9, 0.95, 0.99)]
        assert ways == sorted(ways)
        assert ways[-1] <= nearest["metres"]
        same = {key: figure for key, figure in nearest.items() if key != "seconds"}
        assert same == {key: figure for key, figure in figures["ours"].items() if key != "seconds"}


def test_what_predicts_gets_a_model_of_the_others_and_the_label(measured):
    """The model of each school is of five floors; a search of ours is a run, that of nearest part of an exploration."""
    samplers = {id(made.sampler): made.sampler for made in MADE}
    assert len(samplers) == 6
    sources = [{floor.source for floor in sampler.model.floors} for sampler in samplers.values() if sampler]
    names = {f"school{number}" for number in range(6)}
    assert [names - known for known in sources] == [{f"school{number}"} for number in range(6)]
    searches = [run for result in measured.results["school"] for run in result.runs if run.label]
    assert {made.find for made in MADE} - {None} == {run.label for run in searches}
    for result in measured.results["school"]:
        for label in {run.label for run in result.runs if run.label and run.label != "CLOSET"}:
            found = {run.policy: run.row.figures[FOUND] for run in result.runs if run.label == label}
            assert found[NEAREST] == found["ours"]


def test_runs_that_fail_are_named_and_left_out_for_all(measured):
    failed = [row for row in measured.items["school"] if row.failure and row.item != "strange"]
    assert [row.item for row in failed] == ["school3 start 1, ours, CLOSET", "school4 start 1, ours, CLOSET"]
    assert failed[0].failure == "ValueError: no closets"
    left_out = pair_searches(measured.results["school"], POLICIES).left_out
    assert left_out == ("school3 start 1, CLOSET: ours", "school4 start 1, CLOSET: ours")


def test_bars_are_against_the_best_and_nearest(measured):
    bars = {row.name: [cell.mean for cell in row.cells] for row in tabulate_bars(measured).rows}
    assert bars["ours, to 90 %, against nearest (6)"] == [100, 100, 100]
    assert [name for name in bars if name.startswith("ours, to a room")]


def test_synthetic_floors_have_no_model_and_nothing_to_look_for():
    of = make_buildings()
    assert [building.name for building in of.buildings] == ["corridor-0", "l-0", "ring-0", "hall-0"]
    assert all(not building.others and not building.labels for building in of.buildings)


@pytest.mark.slow
def test_figures_do_not_depend_on_the_processes(monkeypatch):
    """The processes know the policies of this package alone."""
    monkeypatch.setattr(exploration_buildings, "FLOOR_MAKERS", {"corridor": None, "ring": None})
    benches = [
        measure_exploration(sets=[SYNTHETIC], policies=["nearest"], starts=1, resolution=0.5, jobs=jobs)
        for jobs in (1, 2)
    ]
    found = [
        [
            {key: figure for key, figure in run.row.figures.items() if key != "seconds"}
            for result in bench.results[SYNTHETIC]
            for run in result.runs
        ]
        for bench in benches
    ]
    assert found[0] == found[1]
    assert len(found[0]) == 2


def test_a_world_without_a_place_to_stand_is_named():
    building = replace(make_buildings().buildings[0], floor=Floor(()))
    result = exploration_runs.run_building(building, RunSettings((NEAREST,)))
    assert result.failure == "the floor has no rooms, give one at least"
    assert result.runs == ()


def test_pictures(measured):
    (ax,) = draw_curves(measured).axes
    assert ax.get_title() == "school: mean of 6 buildings"
    assert [line.get_label() for line in ax.get_lines()] == [*POLICIES]
    figure = draw_tracks(measured, measured.results["school"][0])
    titles = [ax.get_title() for ax in figure.axes]
    assert [title.split(":")[0] for title in titles if title] == [*POLICIES]


def test_the_file_holds_every_run(measured, tmp_path):
    save_exploration(measured, tmp_path / "figures.json")
    content = json.loads((tmp_path / "figures.json").read_text())
    assert content["bench"] == "exploration"
    assert len(content["runs"]) == sum(len(result.runs) for result in measured.results["school"])
    assert len(content["tables"]) == len(tabulate_exploration(measured)) == 6
    assert content["left_out"]["school"]["searches"]
    assert {run["outcome"] for run in content["runs"] if run["label"] is None} == {"done"}


def test_a_few_floors_are_explored_without_a_model(tmp_path):
    write_schools(tmp_path, "KK-K", "KL-K")
    of = read_buildings(tmp_path, "school")
    assert [building.others for building in of.buildings] == [(), ()]
    with pytest.raises(DataError, match="school"):
        read_buildings(tmp_path / "none", "school")
    (tmp_path / "buildings" / "office").mkdir()
    (tmp_path / "buildings" / "office" / "strange.xml").write_text("<building/>")
    with pytest.raises(DataError, match="strange"):
        read_buildings(tmp_path, "office")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"sets": ["castle"]}, "castle"),
        ({"policies": ["random"]}, "random"),
        ({"policies": ["gain"]}, "nearest"),
        ({"resolution": 2.0}, "resolution"),
        ({"jobs": 0}, "starts.*jobs"),
    ],
)
def test_options_without_meaning(options, told):
    with pytest.raises(OptionError, match=told):
        measure_exploration(**{"sets": [SYNTHETIC], **options})


def test_the_help_names_the_sets():
    assert SET_NAMES == SETS


def test_policies_are_in_order_and_once():
    assert check_policies(["gain", "nearest", "gain"]) == ("nearest", "gain")
    assert check_policies([]) == POLICIES


@pytest.mark.slow
def test_command(tiny, tmp_path):
    file, pictures = tmp_path / "new" / "exploration.json", tmp_path / "pictures"
    arguments = "--data", tiny, "--set", "school", "--policy", NEAREST, "--no-searches", "--starts", 1
    outcome = run_pianta(
        "bench", "exploration", *arguments, "--resolution", 0.5, "--json", file, "--pictures", pictures
    )
    assert (outcome.code, outcome.err) == (1, "")
    assert "Way to a share of the area, school" in outcome.out
    assert "strange failed (school), not counted: " in outcome.out
    assert {*list_files(pictures)} == {"curves.png", "school_school0.png", "school_school2.png", "school_school5.png"}
    assert json.loads(file.read_text())["settings"]["searches"] is False


def test_a_json_file_that_is_a_folder(tmp_path):
    outcome = run_pianta("bench", "exploration", "--json", tmp_path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("error: JSON")
