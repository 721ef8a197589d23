"""Where text is looked for on a sheet: on tiles that are not blank, each with what is around it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from pianta.plan.text import detection
from pianta.plan.text.detection import STEP, find_boxes

SMALL_TILES = replace(detection.PARAMETERS, tile_steps=14, near_steps=1, seen_steps=1)


class CountingDetector:
    """Stands for rapidocr's: what it answers is the grey of the sheet that it sees, and boxes are not looked for."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, int]] = []
        self.answer: NDArray[np.float32] = np.zeros((0, 0), np.float32)

    def _load_det_model(self) -> "CountingDetector":
        return self

    def get_preprocess(self):
        return lambda part: part

    def session(self, part):
        self.seen.append(part.shape[:2])
        return part[None, None, :, :, 0].astype(np.float32)

    def postprocess_op(self, text, _shape):
        self.answer = text[0, 0]
        return [], []


@pytest.fixture
def detector(monkeypatch):
    counting = CountingDetector()
    monkeypatch.setattr(detection, "text_reader", lambda: counting)
    monkeypatch.setattr(detection, "PARAMETERS", SMALL_TILES)
    return counting


def test_tiles_fit_together(detector):
    rng = np.random.default_rng(0)
    sheet = rng.integers(0, 256, (20 * STEP, 33 * STEP, 3), np.uint8)
    marks = np.ones(sheet.shape[:2], bool)
    detection._find_boxes_at(sheet, marks, 1.0)
    assert (detector.answer == sheet[..., 0]).all()
    # 2 × 3 tiles of 14 steps
    assert len(detector.seen) == 6
    assert max(max(shape) for shape in detector.seen) == 16 * STEP


def test_blank_parts_are_not_searched(detector):
    marks = np.zeros((14 * STEP, 14 * STEP), bool)
    marks[5 * STEP + 3, 2 * STEP] = True
    detection._find_boxes_at(np.full((*marks.shape, 3), 255, np.uint8), marks, 1.0)
    # The marked step, one around it in which boxes may end, and one more that the detector sees
    assert detector.seen == [(5 * STEP, 5 * STEP)]
    assert np.count_nonzero(detector.answer) == (3 * STEP) ** 2


def test_a_blank_sheet_needs_no_detector(detector):
    assert find_boxes(np.full((300, 400, 3), 255, np.uint8)) == []
    assert detector.seen == []


@pytest.mark.slow
def test_a_word_over_the_border_of_two_tiles_is_one_box(monkeypatch):
    pytest.importorskip("rapidocr")
    monkeypatch.setattr(detection, "PARAMETERS", SMALL_TILES)
    image = Image.new("RGB", (1500, 700), "white")
    # At 1500 × 700 pixels sheets are enlarged 1.69 times, so that tiles end at each 265th pixel
    corner = (200, 300)
    font = ImageFont.load_default(28)
    ImageDraw.Draw(image).text(corner, "CLASSROOM", fill="black", font=font)
    (box,) = find_boxes(np.asarray(image))
    left, top, right, bottom = ImageDraw.Draw(image).textbbox(corner, "CLASSROOM", font=font)
    assert left < 265 < right
    assert np.abs(box.min(axis=0) - (left, top)).max() < 12
    assert np.abs(box.max(axis=0) - (right, bottom)).max() < 12
