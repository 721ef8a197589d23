"""Where text is on a sheet: the detector of rapidocr, on those tiles of the sheet that are not blank."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np

from pianta._types import Colors, Floats, Indices, Mask
from pianta.plan.sheets.binarization import compare_to_paper, invert_if_dark

STEP = 32  # px: the detector takes multiples


@dataclass(frozen=True, kw_only=True)
class DetectionParameters:
    """Thresholds of `find_boxes`. Chosen by hand."""

    max_pixels: float = 4.5e6  # of the sheet on which texts are looked for, for time
    enlarged_pixels: float = 3e6  # to which small sheets are enlarged, as the detector misses letters below some 10 px
    max_enlargement: float = 3.0  # of small sheets
    coarse_factor: float = 2.0  # by which the sheet is smaller on which large letters are looked for
    min_contrast: float = 0.25  # of letters with the paper, half of that of ink: letters may be grey
    near_steps: int = 1  # STEPs around marks in which boxes may end
    seen_steps: int = 2  # STEPs around these that the detector sees, too
    tile_steps: int = 62  # STEPs of a tile without these: on smaller ones leaves of doors are taken for letters


PARAMETERS = DetectionParameters()


@cache
def text_reader() -> Any:  # noqa: ANN401 - rapidocr has no types
    """The text reader of rapidocr on one thread, loaded once; ImportError if it is not installed."""
    from openvino import Core
    from rapidocr import EngineType, RapidOCR

    options = {
        "Global.log_level": "critical",
        # Sizes are chosen here
        "Global.use_preprocess_img": False,
        "Global.use_vertical_padding": False,
        "Global.text_score": 0.0,
        "Det.limit_side_len": STEP,
        # A quarter of the time of onnxruntime
        **{f"{stage}.engine_type": EngineType.OPENVINO for stage in ("Det", "Cls", "Rec")},
    }
    reader = RapidOCR(params=options)
    # A processor with bfloat16 would compute with it, and read otherwise than others
    exact = {"INFERENCE_PRECISION_HINT": "f32", "INFERENCE_NUM_THREADS": 1}
    for stage in (reader._load_det_model(), reader._load_rec_model()):
        stage.session.session = Core().compile_model(stage.session.model, "CPU", exact).create_infer_request()
    return reader


def release_memory() -> None:
    """Give back what the reader keeps of the largest sheet that it has seen, up to 0.7 GB."""
    reader = text_reader()
    for stage in (reader._load_det_model(), reader._load_rec_model()):
        stage.session.session.get_compiled_model().release_memory()


def find_boxes(bgr: Colors) -> list[Floats]:
    """Boxes around texts, each of shape (4, 2), x and y from the upper left corner on clockwise.

    bgr: shape (H, W, 3). The detector runs at two sizes, because it misses letters that are too small, and those that
    are too large.
    """
    p, (height, width) = PARAMETERS, bgr.shape[:2]
    factor = np.sqrt(p.max_pixels / (height * width))
    if factor > 1:
        factor = max(1.0, min(p.max_enlargement, np.sqrt(p.enlarged_pixels / (height * width))))
    marks = compare_to_paper(invert_if_dark(bgr)).contrast > p.min_contrast
    boxes = _find_boxes_at(bgr, marks, factor)
    spans = [(box.min(axis=0), box.max(axis=0)) for box in boxes]

    def is_new(box: Floats) -> bool:
        low, high = box.min(axis=0), box.max(axis=0)
        return not any((low < last).all() and (first < high).all() for first, last in spans)

    return boxes + [box for box in _find_boxes_at(bgr, marks, factor / p.coarse_factor) if is_new(box)]


def _find_boxes_at(bgr: Colors, marks: Mask, factor: float) -> list[Floats]:
    """The boxes on a sheet that is enlarged by a factor, where it has marks, shape (H, W)."""
    height, width = bgr.shape[:2]
    cols, rows = (max(1, round(side * factor / STEP)) for side in (width, height))
    size = cols * STEP, rows * STEP
    scaled = cv2.resize(bgr, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC)
    shares = cv2.resize(marks.view(np.uint8) * np.float32(1), (cols, rows), interpolation=cv2.INTER_AREA)
    # rapidocr has no other way to its detector
    detector = text_reader()._load_det_model()
    text = np.zeros(size[::-1], np.float32)
    for core, part in _tile(shares > 0):
        answer = detector.session(detector.get_preprocess()(scaled[part]))[0, 0]
        text[core] = answer[tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(core, part, strict=True))]
    boxes, _ = detector.postprocess_op(text[None, None], (size[1], size[0]))
    return [np.asarray(box, float) * (width / size[0], height / size[1]) for box in boxes]


def _tile(marked: Mask) -> Iterator[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """The tiles around marked steps, shape (rows, cols): pixels of each, and with those that are seen around it."""
    p = PARAMETERS
    near = cv2.dilate(marked.view(np.uint8), np.ones((2 * p.near_steps + 1,) * 2, np.uint8)) > 0
    for row in range(0, marked.shape[0], p.tile_steps):
        for col in range(0, marked.shape[1], p.tile_steps):
            corner = np.array([row, col])
            steps = np.argwhere(near[row : row + p.tile_steps, col : col + p.tile_steps])
            if len(steps):
                low, high = corner + steps.min(axis=0), corner + steps.max(axis=0) + 1
                around = np.maximum(low - p.seen_steps, 0), np.minimum(high + p.seen_steps, marked.shape)
                yield _cut(low, high), _cut(*around)


def _cut(low: Indices, high: Indices) -> tuple[slice, slice]:
    (top, left), (bottom, right) = (low * STEP).tolist(), (high * STEP).tolist()
    return slice(top, bottom), slice(left, right)
