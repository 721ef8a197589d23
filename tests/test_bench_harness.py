"""The harness of all benches: records, tables, the report, the file, and the command."""

import json
import os
from collections.abc import Iterator
from functools import partial
from io import StringIO
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from pianta import __version__
from pianta.errors import PiantaError
from pianta_bench.harness.folds import MAX_FOLDS, list_folds
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Item, Results
from pianta_bench.harness.report import save_results, show_tables
from pianta_bench.harness.tables import Cell, FilledTable, Table
from tests.command_line import run_pianta


def show(*tables: FilledTable, results: Results | None = None) -> list[str]:
    console = Console(file=StringIO(), width=100)
    console.print(show_tables(tables, results or Results()))
    assert isinstance(console.file, StringIO)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


class TestResults:
    def test_figures_measured_before_a_failure_stay(self):
        def measure(item: str) -> Iterator[Figures]:
            yield {"cost": 2.0}
            if item == "bad":
                raise PiantaError("broken")
            yield {"score": 70.0}

        results = Results()
        for item in ("good", "bad"):
            results.measure("maps", item, partial(measure, item), failed={"score": 0.0, "cost": None}, method="m")
        common = {"part": "maps", "method": "m"}
        assert results.records == [
            {**common, "item": "good", "metric": "score", "value": 70.0},
            {**common, "item": "good", "metric": "cost", "value": 2.0},
            {**common, "item": "bad", "metric": "score", "value": 0.0},
            {**common, "item": "bad", "metric": "cost", "value": 2.0},
        ]
        assert results.items == [Item("maps", "good"), Item("maps", "bad", "broken")]
        assert results.failed

    def test_an_error_from_elsewhere_has_its_class_named(self):
        def measure() -> Iterator[Figures]:
            yield {"score": 1 / 0}

        results = Results()
        results.measure("maps", "a", measure)
        assert results.items[0].failure == "ZeroDivisionError: division by zero"

    def test_an_interrupted_measurement_ends(self):
        def measure() -> Iterator[Figures]:
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            Results().measure("maps", "a", measure)

    def test_a_key_of_several_names_fills_several_fields(self):
        results = Results()
        results.add("schools", "a", {("error", "R/C"): 1.0, ("error", "F/C/E/S"): None}, names=("metric", "labels"))
        assert results.select(labels="R/C") == [
            {"part": "schools", "item": "a", "metric": "error", "labels": "R/C", "value": 1.0}
        ]
        assert results.values(metric=["error"]) == [1.0]


class TestTable:
    RECORDS = (
        {"part": "schools", "item": "a", "metric": "nodes", "value": 1.0},
        {"part": "offices", "item": "c", "metric": "nodes", "value": 3.0},
        {"part": "schools", "item": "b", "metric": "nodes", "value": 4.0},
        {"part": "schools", "item": "b", "metric": "edges", "value": None},
    )

    def test_mean_and_deviation_of_each_group(self):
        table = Table(title="T", where={"metric": ["edges", "nodes"]}, labels={"nodes": "rooms"}).fill(self.RECORDS)
        assert table.columns == ("schools", "offices")
        assert [*table.rows] == ["edges", "rooms"]
        assert table.rows["rooms"] == {
            "schools": Cell(2.5, sqrt(4.5), count=2),
            "offices": Cell(3.0, None, count=1),
        }
        assert table.rows["edges"] == {"schools": Cell(None, None, count=0), "offices": Cell()}

    def test_order_of_labels_or_else_of_the_records(self):
        labels = {"edges": "doors", "nodes": "rooms"}
        assert [*Table(title="T", labels=labels).fill(self.RECORDS).rows] == ["doors", "rooms"]
        assert [*Table(title="T").fill(self.RECORDS).rows] == ["nodes", "edges"]

    def test_several_fields_name_a_row(self):
        table = Table(title="T", rows=("metric", "item"), where={"part": "schools"}, digits={"b": 3}).fill(self.RECORDS)
        assert [*table.rows] == ["nodes, a", "nodes, b", "edges, b"]
        assert table.rows["nodes, b"]["schools"] == Cell(4.0, count=1, digits=3)

    def test_rows_below_sum_up_the_columns(self):
        spec = Table(title="T", rows=("item",), columns=("metric",), summaries=("mean", "sd", "median"))
        table = spec.fill(self.RECORDS)
        assert {name: table.rows[name]["nodes"].mean for name in spec.summaries} == {
            "mean": pytest.approx(8 / 3),
            "sd": pytest.approx(sqrt(7 / 3)),
            "median": 3.0,
        }
        assert table.rows["mean"]["edges"].mean is None

    def test_published_figures_are_beside_the_measured_ones(self):
        where = {"metric": ["nodes", "diameter"], "part": ["schools"]}
        table = Table(title="{type}s", where=where, published="table_5_1.csv").fill(self.RECORDS, type="school")
        assert table.title == "schools"
        assert table.rows == {
            "nodes": {"schools": Cell(2.5, sqrt(4.5), 35.24, 18.33, 2)},
            "diameter": {"schools": Cell(None, None, 6.34, 2.3)},
        }

    def test_a_table_without_records(self):
        assert Table(title="T", summaries=("mean",)).fill([]) == FilledTable("T", (), {"mean": {}})


def test_a_printed_table() -> None:
    rows = {
        "accuracy": {"schools": Cell(91.25, 2.0, 90.0, 1.5), "offices": Cell(50.0)},
        "kappa": {"schools": Cell(0.5, digits=3), "offices": Cell()},
    }
    table = FilledTable("Table 0", ("schools", "offices"), rows, ("A note.",), unit="%")
    items = [Item("schools", "x", "no doors"), Item("schools", "y", warnings=("odd",)), Item("schools", "z")]
    assert show(table, results=Results(items=items)) == [
        "Table 0",
        "mean ± sd, %",
        "",
        "            schools    schools offices",
        "               here     thesis    here",
        "──────────────────────────────────────",
        "accuracy 91.2 ± 2.0 90.0 ± 1.5    50.0",
        "kappa         0.500          –       –",
        "",
        "A note.",
        "",
        "x failed (schools): no doors",
        "Warnings on 1 of 3 schools; --json lists them.",
    ]


def test_columns_that_do_not_fit_are_printed_below() -> None:
    columns = {f"column {number}": Cell(number + 0.25, 0.5, number, 0.5) for number in range(12)}
    lines = show(FilledTable("Wide", tuple(columns), {"of twelve": columns}))
    assert max(map(len, lines)) <= 100
    blocks = [line.split() for line in lines if line.startswith("of twelve")]
    assert len(blocks) == 3
    figures = [word for words in blocks for word in words[2:] if word not in ("±", "0.5")]
    expected = [(number + 0.25, number) for number in range(12)]
    assert figures == [text for mean, published in expected for text in (f"{mean:.1f}", str(published))]


def test_saved_results(tmp_path: Path) -> None:
    table = FilledTable("T", ("a",), {"r": {"a": Cell(1.0, None, 2.0, 0.5, 1)}}, ("n",), "%")
    results = Results({"seed": 1}, items=[Item("a", "x", warnings=("odd",)), Item("a", "y", "broken")])
    results.add("a", "x", {"r": 1.0})
    results.details["curves"] = [1, 2]
    save_results("test", [table], results, tmp_path / "new.json")
    cell = {"mean": 1.0, "sd": None, "published_mean": 2.0, "published_sd": 0.5, "count": 1, "digits": 1}
    assert json.loads((tmp_path / "new.json").read_text()) == {
        "pianta": __version__,
        "bench": "test",
        "options": {"seed": 1},
        "tables": [{"title": "T", "unit": "%", "cells": [{"row": "r", "column": "a", **cell}], "notes": ["n"]}],
        "items": [
            {"part": "a", "item": "x", "failure": None, "warnings": ["odd"]},
            {"part": "a", "item": "y", "failure": "broken", "warnings": []},
        ],
        "records": [{"part": "a", "item": "x", "metric": "r", "value": 1.0}],
        "published": {},
        "curves": [1, 2],
    }


def test_outputs_are_checked_before_anything_is_measured(tmp_path: Path) -> None:
    outcome = run_pianta("bench", "graphs", "--data", tmp_path / "none", "--json", tmp_path)
    assert outcome.code == 2
    assert "is a folder, give the name of a file" in outcome.err


def test_without_the_package_the_command_explains_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from importlib.metadata import EntryPoints

    monkeypatch.setattr("pianta.cli.entry_points", lambda **_: EntryPoints(()))
    outcome = run_pianta("bench", "graphs")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == "error: the verb bench is a package of its own, install it: pip install 'pianta[bench]'\n"


class TestFolds:
    def test_each_building_is_left_out_alone(self):
        folds = list_folds(["b", "a", "b", "c"])
        assert [(others.tolist(), held_out.tolist()) for others, held_out in folds] == [
            ([0, 2, 3], [1]),
            ([1, 3], [0, 2]),
            ([0, 1, 2], [3]),
        ]

    def test_of_many_buildings_neighbours_are_left_out_together(self):
        buildings = [f"{number:03}" for number in range(90)]
        folds = list_folds(buildings)
        assert len(folds) == MAX_FOLDS
        assert np.concatenate([held_out for _, held_out in folds]).tolist() == [*range(90)]
        assert {len(held_out) for _, held_out in folds} == {2, 3}
        assert all(len(others) + len(held_out) == 90 for others, held_out in folds)
        assert [held_out.tolist() for _, held_out in list_folds("abcde", most=2)] == [[0, 1, 2], [3, 4]]


class TestSteps:
    @pytest.mark.parametrize("jobs", [1, 2, None])
    def test_outcomes_come_in_the_order_of_the_steps(self, jobs):
        names: list[str] = []

        def track(items):
            for item in items:
                names.append(item)
                yield item

        steps = {name: partial(sqrt, number) for name, number in (("a", 4), ("b", 9), ("c", 1))}
        assert [*run_steps(steps, jobs=jobs, track=track)] == [2, 3, 1]
        assert names == ["a", "b", "c"]

    def test_an_error_of_pianta_keeps_its_class(self):
        with pytest.raises(PiantaError, match="broken"):
            [*run_steps({"a": partial(_fail, "broken"), "b": partial(str, 4)}, jobs=2, track=iter)]

    def test_a_step_whose_process_ends_is_named(self):
        with pytest.raises(PiantaError, match="step a: its process ended with code 3, 2 times"):
            [*run_steps({"a": partial(_end, 3), "b": partial(str, 4)}, jobs=2, track=iter)]

    def test_an_unforeseen_error_has_its_traceback_as_a_note(self):
        with pytest.raises(PiantaError, match="step a: an unforeseen fault, ZeroDivisionError") as caught:
            [*run_steps({"a": partial(divmod, 1, 0), "b": partial(str, 4)}, jobs=2, track=iter)]
        assert "Traceback" in caught.value.__notes__[0]

    def test_results_of_steps_are_joined(self):
        results, other = Results(), Results()
        results.add("maps", "a", {"score": 1.0})
        other.add("maps", "b", {"score": 2.0})
        other.items.append(Item("maps", "b"))
        results.extend(other)
        assert results.values(metric="score") == [1.0, 2.0]
        assert results.items == [Item("maps", "b")]


def _fail(reason: str) -> str:
    raise PiantaError(reason)


def _end(code: int) -> str:
    os._exit(code)
