"""`pianta bench patterns` on a small data folder."""

import json

import pytest

from pianta_bench.patterns.measure import BY_LABEL, STOREYS, STRANGERS, WAYS, measure
from pianta_bench.patterns.tables import tabulate
from tests.bench_results import show_lines
from tests.command_line import list_files, run_pianta
from tests.tiny_types import write_types


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """Two schools, each of a single floor, and one office of two storeys."""
    folder = tmp_path_factory.mktemp("data")
    write_types(folder, "school", "office")
    records = [{"path": f"buildings/office/office{number}.xml", "building": "both"} for number in range(2)]
    (folder / "manifest.json").write_text(json.dumps(records))
    return folder


def test_figures_by_floor_and_by_building(tiny):
    results = measure(tiny, shuffles=2, jobs=1)
    assert not results.failed
    assert {record["way"] for record in results.select(part="schools")} == {*WAYS}
    assert {record["item"] for record in results.select(part=STOREYS)} == {"office/both"}
    # There is no second building of several storeys to compare with.
    assert results.select(part=STRANGERS) == []
    for item in ("school0", "school1"):
        own = {r["metric"]: r["value"] for r in results.select(part="schools", item=item, way=BY_LABEL)}
        assert own["rooms"] == 14
        # Six classrooms and six closets in two rows: pairs of each save rooms; shares of 14 rooms.
        assert 0 < own["saved"] < own["repeated"] <= 1
        assert own["saved"] * 14 == pytest.approx(round(own["saved"] * 14))
        assert own["across"] == 0
    (across,) = results.values(part=STOREYS, metric="across")
    assert across > 0


@pytest.mark.slow
def test_the_command(tiny, tmp_path):
    outputs = "--json", tmp_path / "patterns.json", "--pictures", tmp_path / "pictures"
    code, out, err = run_pianta("bench", "patterns", "--data", tiny, "--shuffles", 1, "--jobs", 1, *outputs)
    assert (code, err) == (0, "")
    assert "Model floor plans of schools, 2 floors" in out
    assert "Model floor plans of several storeys" in out
    names = {f"{name}{number}.png" for name in ("school", "office") for number in range(2)}
    assert set(list_files(tmp_path / "pictures")) == names
    content = json.loads((tmp_path / "patterns.json").read_text())
    assert content["options"] == {"shuffles": 1, "seed": 0}


def test_a_floor_that_fails_is_listed(tiny, tmp_path):
    folder = tmp_path / "buildings"
    write_types(tmp_path, "school", "office")
    (folder / "school" / "school0.xml").write_text("<building")
    results = measure(tmp_path, shuffles=1, jobs=1)
    assert [item.item for item in results.items if item.failure] == ["school0"]
    lines = show_lines(tabulate(results), results)
    assert "Model floor plans of schools, 1 floors" in lines
