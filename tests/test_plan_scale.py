"""The scale of a plan by all its evidence: what agrees counts, nonsense does not, and errors are described."""

from dataclasses import replace
from math import log, sqrt
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box

from pianta.floor import Floor, Room
from pianta.plan.doors.swings import DoorWidth
from pianta.plan.scale.dimension_lines import list_dimension_lines, measure_dimension_lines
from pianta.plan.scale.evidence import Measure, ScaleEvidence, combine_evidence
from pianta.plan.scale.known_rooms import find_known_rooms
from pianta.plan.scale.refined_scale import _by_written_scale, refine_scale, scale_door_px
from pianta.plan.scale.sheet_scale import LOOK, SheetScale
from pianta.plan.scale.spaces import PARAMETERS, measure_spaces
from pianta.plan.sheets.sheet import PlacedText, PlanScale, Sheet
from pianta.plan.walls.segmentation import INSIDE, WALL, ClassMap

LIMITS = {"low": 1e-3, "high": 10.0}


def placed(text: str, row: float, col: float, *, height: float = 8.0) -> PlacedText:
    """A level text around its middle."""
    half = 0.3 * height * len(text)
    top, bottom, left, right = row - height / 2, row + height / 2, col - half, col + half
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)]))


def evidence(
    text: str, *resolutions: float, sd: float = 0.05, outlier_rate: float = 0.2, **rest: float
) -> ScaleEvidence:
    measures = tuple(Measure((each,), sd) for each in resolutions)
    return ScaleEvidence(text, measures, rest.get("common", 0.0), outlier_rate, rest.get("kind", 0.0))


def test_one_certain_measure_is_the_scale_and_its_error():
    combined = combine_evidence([evidence("one", 0.02, sd=0.1, outlier_rate=0.0)], **LIMITS)
    assert combined.resolution == pytest.approx(0.02, rel=0.01)
    # 80 % of a normal distribution lie within 1.2816 standard deviations, 95 % within 1.96
    assert [abs(log(end / 0.02)) for end in combined.usual] == pytest.approx([0.128, 0.128], abs=0.01)
    assert [abs(log(end / 0.02)) for end in combined.wide] == pytest.approx([0.196, 0.196], abs=0.01)
    # 15 % are 1.3976 standard deviations
    assert combined.certainty == pytest.approx(0.838, abs=0.03)


def test_two_measures_meet_in_the_middle_and_are_surer():
    combined = combine_evidence([evidence("both", 0.019, 0.021, sd=0.1, outlier_rate=0.0)], **LIMITS)
    assert combined.resolution == pytest.approx(sqrt(0.019 * 0.021), rel=0.01)
    assert log(combined.usual[1] / combined.usual[0]) == pytest.approx(2 * 0.128 / sqrt(2), abs=0.015)


def test_a_common_error_does_not_shrink_with_more_measures():
    many = evidence("many", *[0.02] * 50, sd=0.05, outlier_rate=0.0, common=0.1)
    combined = combine_evidence([many], **LIMITS)
    assert log(combined.usual[1] / combined.resolution) == pytest.approx(0.128, abs=0.015)


def test_nonsense_does_not_move_the_scale_and_is_no_source():
    right, wrong = evidence("areas", 0.02, 0.0202, 0.0198, 0.3), evidence("doors", 0.09, kind=0.3)
    combined = combine_evidence([right, wrong], **LIMITS)
    assert combined.resolution == pytest.approx(0.02, rel=0.03)
    assert [each.text for each in combined.agreeing] == ["areas"]


def test_the_other_evidence_decides_between_two_units():
    ambiguous = ScaleEvidence("sizes", (Measure((0.02, 0.0656), 0.03),), 0.0, 0.1, 0.0)
    for hint, expected in ((0.018, 0.02), (0.08, 0.0656)):
        combined = combine_evidence([ambiguous, evidence("doors", hint, sd=0.2)], **LIMITS)
        assert combined.resolution == pytest.approx(expected, rel=0.03)


def test_without_evidence_every_scale_is_possible():
    combined = combine_evidence([], **LIMITS)
    assert combined.resolution == pytest.approx(0.1, rel=0.02)
    assert combined.wide == pytest.approx((10 ** (-3 + 4 * 0.025), 10 ** (-3 + 4 * 0.975)), rel=0.03)


@given(st.lists(st.floats(0.002, 5.0), min_size=1, max_size=8), st.floats(0.01, 0.6), st.floats(0.01, 0.9))
def test_the_intervals_hold_the_scale(resolutions, sd, outlier_rate):
    combined = combine_evidence([evidence("any", *resolutions, sd=sd, outlier_rate=outlier_rate)], **LIMITS)
    (low, high), (lowest, highest) = combined.usual, combined.wide
    assert 1e-3 <= lowest <= low <= combined.resolution <= high <= highest <= 10.0001
    assert 0 <= combined.certainty <= 1.0001


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("Bedroom 1", ["bedroom"]),
        ("SOVRUM 2", ["bedroom"]),
        ("Schlafzimmer", ["bedroom"]),
        ("Camera da letto", ["bedroom"]),
        ("Chambre à coucher", ["bedroom"]),
        ("Habitación", ["bedroom"]),
        ("DORMITÓRIO 1", ["bedroom"]),
        ("MH", ["bedroom"]),
        ("洋室", ["bedroom"]),
        ("Спальня", ["bedroom"]),
        ("リビング", ["living room"]),
        ("Living/ Dining", ["living room", "dining room"]),
        ("Küche", ["kitchen"]),
        ("Salle de réunion", ["meeting room"]),
        ("12. BÜRO", ["office"]),
        ("Klassenzimmer 3", ["classroom"]),
        ("Abroad", []),
        ("204", []),
        ("", []),
        ("bed " * 100, []),
    ],
)
def test_names_of_rooms_have_usual_areas(name, kinds):
    assert [room.kind for room in find_known_rooms(name)] == kinds


# Two rooms of 200 x 150 and 250 x 150 pixels inside their walls, on a sheet of 400 rows; cells of 2 pixels. The network
# draws the walls wider.
CELL = 2.0
INNER = ((20, 20, 220, 170), (240, 20, 490, 170))
SHAPE = (400, 520)


def two_rooms() -> tuple[list[Floor], ClassMap]:
    probabilities = np.zeros((4, int(SHAPE[0] / CELL), int(SHAPE[1] / CELL)), np.float32)
    probabilities[WALL] = 1
    excess = round(PARAMETERS.wall_excess * CELL)
    for left, low, right, high in INNER:
        sides = np.array([SHAPE[0] - high + excess, SHAPE[0] - low - excess, left + excess, right - excess])
        top, bottom, first, last = np.rint(sides / CELL).astype(int)
        probabilities[WALL, top:bottom, first:last] = 0
        probabilities[INSIDE, top:bottom, first:last] = 1
    # Rooms reach to the middle of the walls
    rooms = [Room(1, box(10, 10, 230, 180)), Room(2, box(230, 10, 500, 180))]
    return [Floor(tuple(rooms))], ClassMap(probabilities, CELL)


def test_the_floor_of_a_room_ends_at_the_faces_of_its_walls():
    texts = [placed("one", 300, 100), placed("outside", 50, 100)]
    spaces = measure_spaces(*two_rooms(), texts, height=SHAPE[0])
    assert [space.width for space in spaces] == pytest.approx([200, 250], abs=3)
    assert [space.height for space in spaces] == pytest.approx([150, 150], abs=3)
    assert [space.area for space in spaces] == pytest.approx([30000, 37500], rel=0.03)
    assert [[text.text for text in space.texts] for space in spaces] == [["one"], []]


def measured_scale(**measured: Any) -> SheetScale:
    """Doors of 40 pixels by the network alone."""
    first: dict[str, Any] = {
        "scale": PlanScale(0.0225, LOOK, 0.3),
        "is_stated": False,
        "bar": None,
        "swings": (),
        "door_width": None,
        "doors_agree": False,
        "door_px": 40.0,
        "drawn_door_px": 40.0,
    }
    return SheetScale(**(first | measured))


def refine(*texts: PlacedText, ink: np.ndarray | None = None, **measured: Any) -> PlanScale:
    """The scale of the sheet with the two rooms; doors of 40 pixels by the network alone."""
    colors = np.full((*SHAPE, 3), 255, np.uint8)
    if ink is not None:
        colors[ink] = 0
    sheet = Sheet(colors)
    floors, class_map = two_rooms()
    spaces = measure_spaces(floors, class_map, texts, height=SHAPE[0])
    return refine_scale(measured_scale(**measured), sheet, sheet, spaces, texts)


@pytest.mark.parametrize(
    "written",
    [
        ("12 m²", "15 m²"),
        ("129 sf", "161 sf"),
        ("4.00 x 3.00 m", "3,00 x 5,00"),
        ("13'1\" x 9'10\"", "16'5\" x 9'10\""),
        ("400 x 300", "500 x 300"),
        ("7.4帖", "9.3帖"),
    ],
)
def test_measures_written_in_rooms_give_the_scale(written):
    """At 0.02 m per pixel the rooms are 4 m x 3 m and 5 m x 3 m."""
    scale = refine(placed(written[0], 300, 120), placed(written[1], 300, 360))
    assert scale.resolution == pytest.approx(0.02, rel=0.05)
    assert "written in 2 rooms" in scale.source
    assert scale.confidence > 0.9
    assert not scale.is_rough
    low, high = scale.interval or (0, 0)
    assert low < 0.02 < high


def test_a_total_area_gives_the_scale_roughly():
    scale = refine(placed("Total area 29 m²", 30, 200))
    assert scale.resolution == pytest.approx(0.02, rel=0.1)
    assert scale.source == "the total area"


def test_names_give_the_scale_roughly():
    """Two bedrooms of 12.5 m² on 30000 and 37500 square pixels."""
    scale = refine(placed("Bedroom", 300, 120), placed("BEDROOM 2", 300, 360))
    assert scale.resolution == pytest.approx(sqrt(12.5 / 33541), rel=0.1)
    assert scale.source == "the names of 2 rooms"
    assert "; areas may be wrong by a factor of" in str(scale)
    assert not scale.is_look


def test_doors_give_the_scale():
    scale = refine(door_width=DoorWidth(40.0, 12, 0.85), doors_agree=True)
    assert scale.source == "12 doors"
    assert 0.78 / 40 * 0.95 < scale.resolution < 0.9 / 40 * 1.05


def test_the_look_alone_is_a_source_and_marks_the_areas():
    scale = refine()
    assert (scale.source, scale.is_look, scale.is_rough) == (LOOK, True, True)
    assert "areas may be wrong by a factor of" in str(scale)
    assert "give the resolution" in str(scale)


def test_what_is_stated_stays():
    stated = PlanScale(0.5, "the given resolution", 1.0)
    assert refine(placed("12 m²", 300, 120), scale=stated, is_stated=True) is stated


def test_dimension_lines_give_the_scale_although_rooms_are_cut():
    ink = np.zeros(SHAPE, bool)
    ink[350, 20:221] = True
    ink[340:361, 20] = ink[340:361, 220] = True
    scale = refine(placed("4000", 342, 120), placed("12 m²", 300, 120), ink=ink)
    assert "1 dimension line" in scale.source
    assert scale.resolution == pytest.approx(0.02, rel=0.03)


@pytest.mark.parametrize("is_level", [True, False])
def test_a_dimension_line_ends_at_its_ticks(is_level):
    """A line of 300 pixels, cut by slashes into pieces of 100 and 200."""
    ink = np.zeros((120, 400), np.uint8)
    cv2.line(ink, (50, 60), (350, 60), 1, 1)
    for col in (50, 150, 350):
        cv2.line(ink, (col - 6, 66), (col + 6, 54), 1, 1)
    text = placed("2000", 52, 250)
    if not is_level:
        ink = np.ascontiguousarray(ink.T)
        # From below upwards, as texts beside upright lines are read
        corners = text.corners[:, ::-1]
        text = PlacedText(text.text, np.array([corners[1], corners[0], corners[3], corners[2]])[[0, 1, 2, 3]])
    lines = measure_dimension_lines(list_dimension_lines([text], ink.astype(bool)))
    assert lines is not None
    assert any(each == pytest.approx(0.01, rel=0.03) for each in lines.measures[0].resolutions)


@pytest.mark.parametrize("slash", [False, True])
def test_a_dimension_line_ends_at_the_faces_of_walls(slash):
    """Walls of 16 pixels with faces at columns 100 and 300, between which 4000 mm are 200 pixels."""
    ink = np.zeros((120, 400), np.uint8)
    ink[20:100, 84:101] = ink[20:100, 300:317] = 1
    cv2.line(ink, (98, 60), (302, 60), 1, 1)
    for col in (100, 300) if slash else ():
        cv2.line(ink, (col - 3, 63), (col + 3, 57), 1, 1)
    evidence = measure_dimension_lines(list_dimension_lines([placed("4000", 52, 200)], ink.astype(bool)))
    assert evidence is not None
    (measure,) = evidence.measures
    assert min(measure.resolutions, key=lambda each: abs(each - 0.02)) == pytest.approx(0.02, rel=0.006)
    # 1.5 % and 1.5 of 200 pixels; 1 % and 1 of 200 pixels
    assert measure.log_sd == pytest.approx(0.0168, rel=0.05)
    assert evidence.common_sd == pytest.approx(0.0112, rel=0.05)


def test_numbers_of_rooms_are_no_dimensions():
    ink = np.zeros((200, 400), bool)
    ink[110, 50:350] = True
    numbers = [placed(str(number), 100, 60 + 60 * index) for index, number in enumerate((101, 102, 103, 104))]
    assert list_dimension_lines(numbers, ink) == []
    assert list_dimension_lines([placed("2000", 20, 200)], ink) == []


def test_a_scale_describes_its_value_interval_sources_and_outlier_rate():
    scale = PlanScale(0.03, "7 doors", 0.9, interval=(0.0285, 0.0316), wide_interval=(0.0275, 0.0327))
    assert str(scale) == "0.03 m per pixel, 0.0285 to 0.0316 (7 doors)"
    rough = PlanScale(0.03, "7 doors", 0.5, interval=(0.025, 0.036), wide_interval=(0.02, 0.045))
    assert str(rough).endswith("; areas may be wrong by a factor of 2.2, give the resolution")
    assert (scale.is_rough, rough.is_rough) == (False, True)
    stated = PlanScale(0.005, "the given resolution", 1.0)
    assert stated.describe(px_per_unit=4.0) == "0.02 m per drawing unit (the given resolution)"
    assert (stated.area_factor, stated.is_rough) == (1, False)
    assert stated.as_json()["sources"] == ["the given resolution"]


@pytest.mark.parametrize(
    ("text", "shape", "px_per_inch", "inches", "outlier_rate"),
    [
        ("1:100", (1654, 2339), 200.0, (11.69,), 0.2),  # a scan of A4
        ("1:100", (1000, 1300), 300.0, (1300 / 300,), 0.5),  # a part of a scan
        ("1:50 @ A1", (1654, 2339), 200.0, (33.11,), 0.2),  # A1, printed on A4
        ("1:100", (1654, 2339), 96.0, (11.69, 16.54, 23.39, 33.11, 46.81), 0.6),  # a picture with the shape of A4
        ("1:100", (595, 842), 144.0, (11.69, 16.54, 23.39, 33.11, 46.81), 0.6),  # smaller than any paper
    ],
)
def test_a_written_scale_holds_on_the_paper(text, shape, px_per_inch, inches, outlier_rate):
    sheet = Sheet(np.full((*shape, 3), 255, np.uint8), px_per_inch=px_per_inch)
    evidence = _by_written_scale(sheet, [placed(text, 30, 200)])
    assert evidence is not None
    ratio = 50 if "50" in text else 100
    expected = [ratio * 0.0254 * side / shape[1] for side in inches]
    assert evidence.measures[0].resolutions == pytest.approx(expected, rel=0.001)
    assert evidence.outlier_rate == outlier_rate


@pytest.mark.parametrize("px_per_inch", [None, 72.0, 95.9866, 120.0, 143.99, 192.0, 240.0])
def test_pixels_per_inch_of_screens_are_no_evidence(px_per_inch):
    sheet = Sheet(np.full((800, 1600, 3), 255, np.uint8), px_per_inch=px_per_inch)
    assert _by_written_scale(sheet, [placed("1:100", 30, 200)]) is None


@pytest.mark.parametrize(
    ("resolution", "at_home", "door_px"),
    [
        # Doors have 0.9 m / 0.01 m = 90 pixels, of which 40 % are 36: near the 40 that the network took
        (0.01, 1.0, None),
        # 0.4 · 0.9 m / 0.02 m
        (0.02, 1.0, 18.0),
        (0.02, 0.4, None),
    ],
)
def test_a_home_that_was_seen_at_another_scale_is_seen_again(resolution, at_home, door_px):
    scale = PlanScale(resolution, "areas written in 4 rooms", 0.9, wide_interval=(0.9 * resolution, 1.1 * resolution))
    assert scale_door_px(measured_scale(), scale, at_home, shape=SHAPE) == pytest.approx(door_px)


def test_a_doubtful_or_stated_scale_is_no_reason_to_see_a_home_again():
    scale = PlanScale(0.02, "areas written in 4 rooms", 0.9, wide_interval=(0.018, 0.022))
    assert scale_door_px(measured_scale(is_stated=True), scale, 1.0, shape=SHAPE) is None
    for doubtful in ({"is_look": True}, {"wide_interval": (0.01, 0.04)}):
        assert scale_door_px(measured_scale(), replace(scale, **doubtful), 1.0, shape=SHAPE) is None
