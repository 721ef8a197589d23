"""Fixtures of homes on plans: from probabilities to rectangles, and drawn ones that the network finds."""

import cv2
import numpy as np
import pytest
from shapely import box

from pianta.floor import Floor, Furniture, Room
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.symbols import fixtures
from pianta.plan.symbols.fixtures import BED, HOB, N_CLASSES, NO_FIXTURE, TOILET, find_fixtures, place_fixtures

CELL = 0.05


def probabilities_of(*rectangles: tuple[int, tuple[slice, slice], float]) -> np.ndarray:
    """Probabilities of 100 × 80 cells: rectangles of a class with a probability, the rest without a fixture."""
    probabilities = np.zeros((N_CLASSES, 100, 80), np.float32)
    probabilities[NO_FIXTURE] = 1
    for number, window, probability in rectangles:
        probabilities[:, *window] = 0
        probabilities[number, *window] = probability
        probabilities[NO_FIXTURE, *window] = 1 - probability
    return probabilities


def list_fixtures(*rectangles: tuple[int, tuple[slice, slice], float]) -> list[Furniture]:
    return list(fixtures._list_fixtures(probabilities_of(*rectangles), CELL, 5.0))


def test_a_fixture_is_the_rectangle_of_its_cells():
    """Rows 10 to 50 of 100 cells of 0.05 m, y up: y 2.5 to 4.5; columns 20 to 48: x 1 to 2.4."""
    (bed,) = list_fixtures((BED, (slice(10, 50), slice(20, 48)), 0.9))
    assert bed.kind == "bed"
    assert bed.probability == pytest.approx(0.9)
    assert bed.polygon.symmetric_difference(box(1.0, 2.5, 2.4, 4.5)).area < 1e-4


@pytest.mark.parametrize(
    ("number", "window", "probability"),
    [
        (BED, (slice(10, 20), slice(20, 30)), 0.9),
        (TOILET, (slice(10, 50), slice(20, 48)), 0.9),
        (HOB, (slice(10, 22), slice(20, 32)), 0.6),
        (HOB, (slice(10, 22), slice(20, 32)), 0.4),
    ],
    ids=["a small bed", "a large toilet", "doubtful", "improbable"],
)
def test_what_has_the_wrong_size_or_is_doubtful_is_no_fixture(number, window, probability):
    assert not list_fixtures((number, window, probability))


def test_fixtures_belong_to_the_floor_in_whose_rooms_they_stand():
    floors = [Floor((Room(1, box(0, 0, 4, 3)),)), Floor((Room(1, box(10, 0, 14, 3)),))]
    bath, hob, lost = (
        Furniture(box(x, 1, x + 1, 1.5), 0.9, name) for x, name in ((1, "bath"), (11, "hob"), (6, "bed"))
    )
    first, second = place_fixtures(floors, [bath, hob, lost])
    assert (first.furniture, second.furniture) == ((bath,), (hob,))
    assert [floor.furniture for floor in place_fixtures(floors, [])] == [(), ()]


@pytest.mark.slow
def test_drawn_fixtures_are_found_and_furniture_is_not():
    """A room of 5 m × 4 m at 50 pixels per metre: a hob, a bed and a bath along its walls, a table in its middle."""
    colors = np.full((260, 310, 3), 255, np.uint8)
    cv2.rectangle(colors, (26, 26), (284, 234), (0, 0, 0), 8)
    hob, bed, bath = ((31, 60), (60, 90)), ((185, 30), (265, 132)), ((120, 192), (205, 229))
    for (left, top), (right, bottom) in (hob, bed, bath, ((130, 130), (165, 165))):
        cv2.rectangle(colors, (left, top), (right, bottom), (0, 0, 0), 1)
    for x in (38, 52):
        for y in (68, 82):
            cv2.circle(colors, (x, y), 5, (0, 0, 0), 1, cv2.LINE_AA)
    for x in (190, 228):
        cv2.rectangle(colors, (x, 34), (x + 32, 54), (0, 0, 0), 1)
    cv2.line(colors, (185, 66), (265, 66), (0, 0, 0), 1)
    cv2.ellipse(colors, (163, 210), (38, 14), 0, 0, 360, (0, 0, 0), 1, cv2.LINE_AA)
    pieces = find_fixtures(Sheet(colors), resolution=0.02)
    assert {piece.kind for piece in pieces} >= {"hob", "bed"}
    for piece in pieces:
        (left, top), (right, bottom) = {"hob": hob, "bed": bed}.get(piece.kind or "", bath)
        outline = box(left * 0.02, (260 - bottom) * 0.02, right * 0.02, (260 - top) * 0.02)
        assert outline.intersection(piece.polygon).area > 0.5 * outline.union(piece.polygon).area
