"""The benches of Algorithm 1 as printed: variants, differences of single maps, and three counts, by hand."""

from dataclasses import replace

import pytest
from shapely import box

from pianta.errors import DataError, OptionError
from pianta.floor import Floor, Room
from pianta.layout.parameters import CLUTTER, ThesisParameters
from pianta_bench.departures import measure as departures
from pianta_bench.departures.measure import DEPARTURE_SETS, list_variants, measure
from pianta_bench.departures.tables import tabulate
from pianta_bench.layout import measure as layout_measure
from pianta_bench.layout import timing
from pianta_bench.layout.as_printed import AS_PRINTED, choose_method
from pianta_bench.segmentation.measure import measure as measure_segmentation
from pianta_bench.segmentation.tables import tabulate as tabulate_segmentation
from tests.bench_results import show_lines
from tests.tiny_data import ONE_ROOM, OUTLINES, TRUE_FLOOR, write_building, write_colors, write_slam, write_survey


def write_layouts(data, *names: str) -> None:
    write_survey(data, *names)
    for name in names:
        (data / "survey" / f"{name}_layout_gt.xml").write_text(write_building(OUTLINES, 0.05))


@pytest.fixture
def find(monkeypatch):
    """Replaces reconstruct by a function that returns a floor, and keeps the parameters that it got."""
    calls: list[tuple[str, object]] = []

    def replace(floor: Floor) -> list[tuple[str, object]]:
        def reconstruct(*_: object, method: str, parameters: object) -> Floor:
            calls.append((method, parameters))
            return floor

        monkeypatch.setattr(timing, "_load_method", lambda _: None)
        monkeypatch.setattr(timing, "reconstruct", reconstruct)
        return calls

    return replace


def test_small_groups_are_a_departure_on_bare_maps_alone():
    bare, furnished = list_variants("survey"), list_variants("furniture")
    assert bare.keys() - furnished.keys() == {f"+ {CLUTTER}", f"− {CLUTTER}"}
    # All but the departure that changes no room
    assert bare[AS_PRINTED] == replace(ThesisParameters.as_printed(furnished=False), need_open_edge=True)
    assert (bare[AS_PRINTED].remove_clutter, furnished[AS_PRINTED].remove_clutter) == (False, True)
    assert bare["+ σ = 0.15"].sigma == 0.15
    assert not bare["+ σ = 0.15"].fill_gaps
    assert bare["− σ = 0.15"] == ThesisParameters(sigma=0.1)
    assert bare["ours"] == furnished["ours"] == ThesisParameters()


def test_changes_are_differences_of_single_maps(tmp_path, monkeypatch):
    """With three Hough passes the floor is right, else it is one room: IoU 100 against 50, F1 100 against 66.7."""
    write_slam(tmp_path, "a", "b")
    monkeypatch.setattr(
        departures,
        "reconstruct_layout",
        lambda *_, parameters, **__: TRUE_FLOOR if parameters.hough_passes == 3 else ONE_ROOM,
    )
    results = measure(tmp_path, sets=("schools",))
    assert not results.failed
    for variant, iou, change in (
        (AS_PRINTED, 50, []),
        ("+ three Hough passes", 100, [50, 50]),
        ("+ σ = 0.15", 50, [0, 0]),
        ("ours", 100, [50, 50]),
        ("− three Hough passes", 50, [-50, -50]),
        ("− σ = 0.15", 100, [0, 0]),
    ):
        assert results.values(variant=variant, metric="mean_iou") == pytest.approx([iou] * 2)
        assert results.values(variant=variant, metric="mean_iou_change") == pytest.approx(change)
    assert results.values(variant="ours", metric="f1_change") == pytest.approx([100 / 3] * 2)
    assert results.values(variant=AS_PRINTED, metric="rooms") == [50, 50]
    (table,) = tabulate(results)
    assert (table.rows[AS_PRINTED]["A_FC\nwalls"].published_mean, table.rows["ours"]["change\nIoU"].mean) == (87.6, 50)
    assert list(table.rows) == list(list_variants("schools"))


def test_data_without_these_sets_are_refused(tmp_path):
    with pytest.raises(OptionError, match="clutter"):
        measure(tmp_path, sets=("clutter",))
    write_colors(tmp_path / "clutter", "a")
    with pytest.raises(DataError, match=", ".join(DEPARTURE_SETS)):
        measure(tmp_path)


def test_the_survey_is_counted_in_three_ways(tmp_path, find):
    """One room from 1 to 7 m: 80 of 116 free cells; the drawn rooms are 4.1 and 2.1 m wide, it covers 4.1 and 1.9.

    The other 4 of 120 free cells are the rest, which lies in the smaller room.
    """
    write_layouts(tmp_path, "a")
    find(Floor((Room(1, box(1, 1, 7, 4)),)))
    results = measure_segmentation(tmp_path, methods=("thesis",), sets=("survey",))
    assert not results.failed
    figures = {record["metric"]: record["value"] for record in results.records}
    assert figures["precision_free"] == pytest.approx(100 * 80 / 116)
    assert figures["recall_free"] == pytest.approx(100 * (1 + 36 / 40) / 2)
    assert figures["precision_rest"] == pytest.approx(100 * (80 / 116 + 1) / 2)
    assert figures["precision_polygons"] == pytest.approx(100 * 4.1 / 6)
    assert figures["recall_polygons"] == pytest.approx(100 * (1 + 1.9 / 2.1) / 2)
    assert figures["mean_iou_polygons"] == pytest.approx(100 * (4.1 / 6 + 1.9 / 6.2) / 2)
    assert figures["precision_drawn_free"] == pytest.approx(100 * 80 / 116)
    assert figures["mean_iou_drawn_free"] == pytest.approx(100 * (80 / 116 + 36 / 120) / 2)


def test_the_rivals_show_which_count_is_that_of_the_thesis(tmp_path, find):
    """Precision 66.7, 66.7 and 66.1, recall 100, of which the thesis prints 88.5 and 98.1."""
    write_layouts(tmp_path, "a")
    find(ONE_ROOM)
    results = measure_segmentation(tmp_path, methods=("morphological",), sets=("survey",))
    line = "Mean distance of the other authors' rows from those of the thesis, in points:"
    text = " ".join(" ".join(show_lines(tabulate_segmentation(results), results)).split())
    # (21.83 + 1.9) / 2 = 11.9 and (22.4 + 1.9) / 2 = 12.1
    assert f"{line} free 11.9, rest 11.9, polygons 12.1." in text


def test_as_printed_is_a_method_beside_the_others(tmp_path, find):
    write_layouts(tmp_path, "a")
    calls = find(TRUE_FLOOR)
    results = measure_segmentation(tmp_path, methods=("thesis",), sets=("survey", "furniture"), as_printed=True)
    assert results.options["methods"] == ("thesis", AS_PRINTED)
    bare, furnished = (ThesisParameters.as_printed(furnished=each) for each in (False, True))
    assert calls == [("thesis", None), ("thesis", bare), ("thesis", None), ("thesis", furnished)]
    tables = {table.title: table for table in tabulate_segmentation(results)}
    rows = tables["Table 3.1b, accuracy of room segmentation by three counts, survey"].rows
    assert rows[AS_PRINTED]["free\nprec."].mean == 100
    without = measure_segmentation(tmp_path, methods=("thesis",), sets=("survey",))
    assert all(AS_PRINTED not in table.rows for table in tabulate_segmentation(without))


def test_layouts_are_measured_as_printed(tmp_path, find):
    write_slam(tmp_path, "a")
    calls = find(TRUE_FLOOR)
    results = layout_measure.measure(tmp_path, as_printed=True)
    assert calls == [("thesis", ThesisParameters.as_printed(furnished=False))]
    assert results.options["method"] == AS_PRINTED
    with pytest.raises(OptionError, match="method is structure"):
        layout_measure.measure(tmp_path, method="structure", as_printed=True)


def test_other_methods_keep_their_parameters():
    assert choose_method("voronoi", "survey") == ("voronoi", None)
