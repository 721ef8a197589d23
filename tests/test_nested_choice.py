"""Thresholds that are chosen without the buildings on which they are scored."""

import sys
from collections.abc import Iterable
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("numba", reason="pianta[sim] is not installed")
sys.path += [str(Path(__file__).parents[1] / folder) for folder in ("training", "benchmarks")]
nested = import_module("score_nested_choice")

# Of two groups, and two maps of one building.
NAMES = [("survey", "office_a"), ("furniture", "office_a"), ("survey", "office_b")]


@pytest.fixture
def scorer(monkeypatch) -> Any:
    """IoU and F1 by the first two thresholds: best at 2 and 0, in office_b at 1 and 5; the third is idle."""
    candidates = {"a": (0.0, 1.0, 2.0), "b": (0.0, 5.0), "c": (7.0, 8.0)}
    monkeypatch.setattr(nested, "CANDIDATES", candidates)
    monkeypatch.setattr(nested, "START", (0.0, 0.0, 7.0))
    scorer = nested.Scorer(Path(), Path(), {}, {name: name[1] for name in NAMES}, {}, None)

    def fill(wanted: Iterable[tuple[Any, Any]]) -> None:
        for name, setting in wanted:
            best = (1, 5) if name[1] == "office_b" else (2, 0)
            score = 100 - sum(abs(value - other) for value, other in zip(setting, best, strict=False))
            scorer.scores[name, setting] = score, score

    monkeypatch.setattr(scorer, "fill", fill)
    return scorer


def test_each_group_has_the_thresholds_that_are_best_on_its_own_maps(scorer):
    groups = {"a alone": NAMES[:2], "b alone": NAMES[2:]}
    chosen, trace = nested.choose_settings(scorer, groups, rounds=3)
    # Of equally good candidates the first
    assert chosen == {"a alone": (2.0, 0.0, 7.0), "b alone": (1.0, 5.0, 7.0)}
    assert trace["b alone"][1] == [(1, 0, 7), (1, 5, 7)]
    # One threshold after the other, then all again with the others as chosen
    first, second = {(0, 0, 7), (1, 0, 7), (2, 0, 7), (1, 5, 7), (1, 5, 8)}, {(0, 5, 7), (2, 5, 7)}
    assert {setting for name, setting in scorer.scores if name[1] == "office_b"} == first | second


def test_a_mean_counts_buildings_not_maps(scorer):
    """98 on both maps of office_a, 94 on office_b."""
    setting = (0.0, 0.0, 7.0)
    scorer.fill((name, setting) for name in NAMES)
    assert scorer.mean(NAMES, setting) == pytest.approx((98 + 94) / 2)


def test_a_start_is_not_the_value_of_pianta():
    assert all(len(set(values)) == len(values) > 2 for values in nested.CANDIDATES.values())
    assert all(own != start for own, start in zip(nested.SHIPPED, nested.START, strict=True))
    assert all(own in values for own, values in zip(nested.SHIPPED, nested.CANDIDATES.values(), strict=True))


def test_groups_are_those_of_the_networks():
    assert [nested.fold_of(building) for building in ("officea", "freiburg79", "officeb")] == [0, 0, 1]


def test_the_bootstrap_draws_buildings(scorer):
    """Both maps of office_a have 1, office_b 4: means of two drawn buildings are 1 (both a), 2 (one of each) and 4."""
    values = np.array([[1.0], [1.0], [4.0]])
    low, high = nested.bootstrap_buildings([item for _, item in NAMES], values)
    assert (low[0], high[0]) == (1, 4)


def test_a_step_runs_once_for_settings_that_do_not_change_it(monkeypatch):
    runs = count(1)
    monkeypatch.setattr(nested.reconstruct, "find_floor_space", lambda *_: next(runs))
    values = [(size, width) for size in (1, 2) for width in (1, 2)]
    parameters = [nested.StructureParameters(clutter_size=size, room_width=width) for size, width in values]
    memory: dict[Any, Any] = {}
    with nested.Memory(NAMES[0], memory):
        assert [nested.reconstruct.find_floor_space(None, each) for each in parameters] == [1, 1, 2, 2]
    assert nested.reconstruct.find_floor_space(None, parameters[0]) == 3


def test_scores_are_read_as_they_were_written(tmp_path, scorer):
    scorer.file = tmp_path / "scores.json"
    scorer.fill([(NAMES[0], (0.0, 5.0, 7.0))])
    scorer._save()
    assert nested.read_scores(scorer.file) == scorer.scores
