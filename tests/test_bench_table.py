"""A bench's table: summaries, print and JSON."""

import json
from collections.abc import Iterator

import pytest

from pianta.errors import PiantaError
from pianta_bench.harness.table import (
    BenchTable,
    Column,
    Figures,
    Part,
    Printed,
    Row,
    Summary,
    measure_rows,
    save_bench_table,
)
from tests.tiny_data import show_lines

SCORE, COST = Column("score", "score", "%", failed=0.0), Column("cost", "cost", "s", digits=2)


def tabulate(*figures: float | None, failure: str | None = None) -> BenchTable:
    part = Part(
        "all",
        tuple(Row(f"map{n}", {"score": figure, "cost": 1.0}, failure) for n, figure in enumerate(figures)),
        "thesis",
    )
    compared = {"free cells": ("score",)}
    printed = (Printed("thesis, our method", {"all": ((90.1, 6.3),)}),)
    return BenchTable("b", "Table 0", ("thesis",), (SCORE, COST), (part,), ("score",), compared, printed, ("A note.",))


def test_figures_measured_before_a_failure_stay():
    def measure(item: str) -> Iterator[Figures]:
        yield {"cost": 2.0}
        if item == "bad":
            raise PiantaError("broken")
        yield {"score": 70.0}

    good, bad = measure_rows(["good", "bad"], measure, columns=(SCORE, COST))
    assert good == Row("good", {"score": 70.0, "cost": 2.0})
    assert bad == Row("bad", {"score": 0.0, "cost": 2.0}, "broken")


def test_an_interrupted_measurement_ends():
    def measure(_: str) -> Iterator[Figures]:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure_rows(["a"], measure, columns=(SCORE,))


@pytest.mark.parametrize(
    ("figures", "summary"),
    [
        ((), Summary(None, None, None)),
        ((None, None), Summary(None, None, None)),
        ((80.0,), Summary(80, None, 80)),
        ((80.0, None, 90.0), Summary(85, 50**0.5, 85)),
        ((1.0, 2.0, 6.0), Summary(3, 7**0.5, 2)),
    ],
)
def test_summary_is_of_the_maps_that_have_a_figure_with_n_minus_1(figures, summary):
    (part,) = tabulate(*figures).parts
    found = part.summarise("score")
    assert (found.mean, found.sd, found.median) == pytest.approx((summary.mean, summary.sd, summary.median))


def test_the_printed_rows_of_the_thesis_stand_below_ours():
    lines = show_lines(tabulate(80.0, 90.0))
    assert "Table 0, method thesis" in lines
    assert "pianta, thesis        2 85.0 ± 7.1" in lines
    assert "thesis, our method   20 90.1 ± 6.3" in lines
    assert lines[-2:] == ["The thesis' figures are over 20 maps; here are 2.", "A note."]


def test_what_was_not_measured_is_a_dash():
    lines = show_lines(tabulate(None))
    assert [line.split() for line in lines if line.startswith(("map0", "mean ", "sd"))] == [
        ["map0", "–", "1.00"],
        ["mean", "–", "1.00"],
        ["sd", "–", "–"],
        ["mean", "±", "sd,", "%", "maps", "score"],
    ]


def test_json_holds_every_figure(tmp_path):
    table = tabulate(80.0, None, 90.0, failure="broken")
    save_bench_table(table, tmp_path / "figures.json")
    content = json.loads((tmp_path / "figures.json").read_text())
    assert content["methods"] == ["thesis"]
    assert content["units"] == {"score": "%", "cost": "s"}
    (part,) = content["parts"]
    assert part["method"] == "thesis"
    assert part["rows"][1] == {"item": "map1", "failure": "broken", "warnings": [], "score": None, "cost": 1.0}
    assert part["summary"]["score"] == {"mean": 85.0, "sd": pytest.approx(50**0.5), "median": 85.0}
    assert content["printed"] == [
        {"name": "thesis, our method", "maps": 20, "part": "all", "score": {"mean": 90.1, "sd": 6.3}}
    ]


def test_json_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(PiantaError, match="write"):
        save_bench_table(tabulate(80.0), tmp_path / "none" / "figures.json")
    assert not list(tmp_path.iterdir())
