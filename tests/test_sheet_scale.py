"""What shows the scale of a sheet before its rooms are known: sources, their order, and their confidences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import PlanError
from pianta.plan.doors.swings import DoorWidth
from pianta.plan.scale import sheet_scale
from pianta.plan.scale.sheet_scale import (
    LOOK,
    PARAMETERS,
    find_door_scale,
    find_stated_scale,
    fit_door_px,
    is_reliable_width,
    measure_door_width,
)
from pianta.plan.sheets.sheet import PlacedText, PlanScale, Sheet
from pianta.plan.walls.segmentation import DOOR_CELLS, ClassMap
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan

PAGE = np.full((300, 400, 3), 255, np.uint8)


def sheet(resolution: float | None = None) -> Sheet:
    return Sheet(PAGE, resolution=resolution)


def placed(text: str, row: float, col: float, *, height: float = 10.0) -> PlacedText:
    """A text around its middle."""
    half = 0.3 * height * len(text)
    top, bottom, left, right = row - height / 2, row + height / 2, col - half, col + half
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)]))


@pytest.fixture(scope="module")
def barred():
    """A plan with a scale bar, at 30 pixels per metre."""
    return draw_plan(make_corridor_floor(seed=2, length=24, room_depth=4), scale_bar=True, px_per_metre=30)


def test_the_user_comes_before_the_file_and_the_file_before_the_bar(barred):
    vector_sheet = Sheet(barred.colors, resolution=0.05)
    user_scale = find_stated_scale(vector_sheet, barred.texts, resolution=0.02)
    assert user_scale == PlanScale(0.02, "the given resolution", 1.0)
    file_scale = find_stated_scale(vector_sheet, barred.texts)
    assert file_scale is not None
    assert (file_scale.resolution, file_scale.source) == (0.05, "the units of the file")
    bar_scale = find_stated_scale(Sheet(barred.colors), barred.texts)
    assert bar_scale is not None
    assert bar_scale.source == "the scale bar"
    assert bar_scale.resolution == pytest.approx(1 / 30, rel=0.03)
    assert 0 < bar_scale.confidence < file_scale.confidence < user_scale.confidence


def test_without_user_file_and_bar_no_scale_is_stated():
    assert find_stated_scale(sheet(), ()) is None
    assert find_stated_scale(sheet(), (placed("Office", 50, 50),)) is None


@pytest.mark.parametrize("resolution", [0.0, -0.05, float("nan"), float("inf")])
def test_a_resolution_that_is_no_positive_number_is_refused(resolution):
    with pytest.raises(PlanError, match=f"resolution.*{resolution}"):
        find_stated_scale(sheet(0.05), (), resolution=resolution)


@pytest.mark.parametrize("resolution", [1e-9, 0.004, 13.0, 1e9])
def test_an_impossible_resolution_is_refused_and_one_of_the_file_ignored(resolution):
    with pytest.raises(PlanError, match=f"resolution.*{resolution}.*400"):
        find_stated_scale(sheet(), (), resolution=resolution)
    assert find_stated_scale(sheet(resolution), ()) is None


@given(st.floats(PARAMETERS.min_sheet / 400, PARAMETERS.max_sheet / 400))
def test_any_possible_resolution_is_accepted(resolution):
    assert find_stated_scale(sheet(), (), resolution=resolution) == PlanScale(resolution, "the given resolution", 1.0)


def test_one_door_that_the_file_names_gives_the_width_of_doors():
    named = np.array([[(10.0, 20.0), (10.0, 50.0)]])
    assert measure_door_width([], named) == DoorWidth(30.0, 1, 1.0)
    assert measure_door_width([], named[:0]) is None


@pytest.mark.parametrize(("door_px", "side"), [(None, 100.0), (20.0, None)])
def test_with_equal_entropies_a_sheet_without_doors_has_the_usual_length(monkeypatch, door_px, side):
    def segment_evenly(part, *, door_px, networks):
        return ClassMap(np.full((4, 2, 2), 0.25, np.float32), 1.0)

    monkeypatch.setattr(sheet_scale, "segment_sheet", segment_evenly)
    size = fit_door_px(Sheet(PAGE), door_px=door_px, networks=["one"])
    assert size == pytest.approx(max(PAGE.shape) / side if side else door_px * 0.5)


def test_doors_are_90_centimetres_wide():
    scale = find_door_scale(DoorWidth(30.0, 7, 0.5), 24.0)
    assert scale.source == "7 doors of 0.9 m"
    assert [scale.resolution, scale.confidence] == pytest.approx([0.03, 0.3])
    by_look = find_door_scale(None, 45.0)
    assert by_look.source == LOOK
    assert by_look.resolution == pytest.approx(0.02)
    assert by_look.confidence < find_door_scale(DoorWidth(30.0, 7, 0.9), 24.0).confidence


def test_doors_that_disagree_with_the_network_do_not_count():
    assert find_door_scale(DoorWidth(30.0, 7, 0.5), 99.0) == find_door_scale(None, 99.0)


@pytest.mark.parametrize("factor", [PARAMETERS.door_factors[0], PARAMETERS.door_factors[-1]])
@pytest.mark.parametrize("rounding", [1 - 1e-9, 1 + 1e-9])
def test_the_extreme_sizes_that_are_tried_agree_with_the_doors(factor, rounding):
    scale = find_door_scale(DoorWidth(30.0, 7, 0.5), 30.0 * factor * rounding)
    assert scale.resolution == pytest.approx(0.03)


def uncertain_network(best: float, tried: list[float]):
    """A network whose entropy is least at the best size of doors; tried: collects the sizes."""

    def segment_sheet(colors, *, door_px, networks):
        tried.append(door_px)
        # The more even the shares, the higher the entropy.
        even = min(abs(np.log(door_px / best)) / 8, 0.24)
        shares = np.full((4, 2, 2), even, np.float32)
        shares[0] = 1 - 3 * even
        return ClassMap(shares, door_px / DOOR_CELLS)

    return segment_sheet


@pytest.mark.parametrize(("door_px", "best"), [(20.0, 12.5), (20.0, 20.0), (40.0, 20.0), (6.0, 6.0)])
def test_sizes_near_the_drawn_doors_are_tried(monkeypatch, door_px, best):
    tried: list[float] = []
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(best, tried))
    assert fit_door_px(Sheet(PAGE), door_px=door_px, networks=["one"]) == pytest.approx(best, rel=0.13)
    assert min(tried) <= door_px * 0.5
    assert max(tried) >= door_px
    assert len(tried) == len(set(tried))


def test_with_reliable_doors_few_sizes_are_tried(monkeypatch):
    """The network takes as long for each size as for a small sheet."""
    tried: list[float] = []
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(12.5, tried))
    assert fit_door_px(Sheet(PAGE), door_px=20.0, is_reliable=True, networks=["one"]) == pytest.approx(12.5, rel=0.13)
    few = len(tried)
    assert few <= 5
    fit_door_px(Sheet(PAGE), door_px=20.0, networks=["one"])
    beyond = [size for size in tried[few:] if not 20.0 * 0.5 <= size <= 20.0]
    assert len(tried[few:]) == few + len(beyond)


def test_drawn_doors_are_ignored_if_the_drawing_has_another_scale(monkeypatch):
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(4.0, []))
    assert fit_door_px(Sheet(PAGE), door_px=90.0, networks=["one"]) == pytest.approx(4.0, rel=0.15)


def test_sizes_much_larger_than_the_drawn_doors_are_not_tried(monkeypatch):
    """On 400 pixels doors of 16 are tried; with arcs of 4 those of 10 are, but not those of 16."""
    tried: list[float] = []
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(16.0, tried))
    fit_door_px(Sheet(PAGE), door_px=4.0, networks=["one"])
    assert 9 < max(tried) <= 3 * 4.0 * PARAMETERS.neighbour_factor


def test_on_an_impossibly_long_sheet_all_larger_sizes_are_tried(monkeypatch):
    """With arcs of 1.5 pixels 400 pixels are 267 doors long; doors of 10 are tried, as without drawn doors."""
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(10.0, []))
    assert fit_door_px(Sheet(PAGE), door_px=1.5, networks=["one"]) == pytest.approx(10.0, rel=0.13)
    assert fit_door_px(Sheet(PAGE), door_px=1.7, networks=["one"]) < 3 * 1.7 * PARAMETERS.neighbour_factor


@pytest.mark.parametrize(
    ("count", "longest", "expected"), [(8, 4000, True), (7, 4000, False), (8, 5100, False), (400, 5100, False)]
)
def test_many_doors_are_reliable_unless_the_sheet_is_impossibly_long(count, longest, expected):
    assert is_reliable_width(DoorWidth(20.0, count, 0.9), longest) == expected
    assert not is_reliable_width(None, longest)


@pytest.mark.parametrize("best", [3.0, 6.0, 8.0, 16.0])
def test_without_doors_all_sizes_of_buildings_are_tried(monkeypatch, best):
    """On 400 pixels, from 160 doors of 2.5 pixels to 25 doors of 16."""
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(best, []))
    assert fit_door_px(Sheet(PAGE), door_px=None, networks=["one"]) == pytest.approx(best, rel=0.15)


def test_the_first_network_is_tried_on_the_part_with_the_most_ink(monkeypatch):
    """Lines in the lower right of a sheet; a ninth of the sheet is tried."""
    colors = np.full((1500, 1500, 3), 255, np.uint8)
    colors[1300:1500:10, 1200:1500] = 0
    tried = []

    def segment_sheet(part, *, door_px, networks):
        tried.append((part, tuple(networks)))
        return ClassMap(np.full((4, 2, 2), 0.25, np.float32), 1.0)

    monkeypatch.setattr(sheet_scale, "segment_sheet", segment_sheet)
    fit_door_px(Sheet(colors), door_px=9.0, networks=["one", "two"])
    assert {networks for _, networks in tried} == {("one",)}
    assert all((part == 0).any() and part.shape[0] == part.shape[1] <= 1500 for part, _ in tried)


@pytest.mark.slow
@pytest.mark.parametrize("door_px", [None, 0.001, 2.0])
def test_the_sheet_never_has_more_cells_than_the_limit(monkeypatch, door_px):
    tried: list[float] = []
    monkeypatch.setattr(sheet_scale, "segment_sheet", uncertain_network(10.0, tried))
    size = fit_door_px(Sheet(np.zeros((3000, 8000, 3), np.uint8)), door_px=door_px, networks=["one"])
    assert 3000 * 8000 / (size / DOOR_CELLS) ** 2 <= PARAMETERS.max_cells * 1.001
    assert size == min(tried)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(1, 1), (1, 400), (2, 3)])
def test_the_smallest_sheets_have_a_size(shape):
    assert fit_door_px(Sheet(np.full((*shape, 3), 255, np.uint8)), door_px=None) > 0


def test_the_resolution_of_a_vector_drawing_is_metres_per_unit():
    """A sheet of 400 pixels with 8 pixels per unit is a drawing of 50 units."""
    vector_sheet = Sheet(PAGE, px_per_unit=8.0)
    assert find_stated_scale(vector_sheet, (), resolution=0.4) == PlanScale(0.05, "the given resolution", 1.0)
    with pytest.raises(PlanError, match=r"0\.01.*0\.5"):
        find_stated_scale(vector_sheet, (), resolution=0.01)
