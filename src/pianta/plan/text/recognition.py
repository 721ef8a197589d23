"""Texts on a sheet: found and read with rapidocr, and their letters taken out of the ink (thesis, section 3.3)."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache
from importlib.util import find_spec
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Floats, Mask
from pianta.plan.sheets.binarization import straighten_tones
from pianta.plan.sheets.sheet import PlacedText

# Texts are looked for on a sheet of at most this many pixels, which is what time allows; small sheets are enlarged up
# to this many and this much, because the network does not see letters of less than some ten pixels.
MOST_PIXELS, ENLARGED_PIXELS, MOST_ENLARGED = 4.5e6, 3e6, 3.0
# Large letters are looked for on a sheet that is smaller by this factor.
COARSER = 2.0
# The network wants sides in steps of this many pixels.
STEP = 32
# A box this much higher than wide is read from below and from above, and up to that also upright: it may be a digit.
TALL, VERY_TALL = 1.2, 2.5
# Flat boxes read with less confidence are tried upside down.
DOUBTFUL = 0.7
# Readings with less confidence are none.
LEAST_CONFIDENCE = 0.5
# Letters lie in the box of their text grown by this share of its height, up to this share of their pixels.
GROWTH, INSIDE = 0.2, 0.95
# A straight run of ink longer than this many heights of a line is no part of a letter.
LONG_RUN = 1.8
# Another way to hold a box must be read with so much more confidence than the usual one.
CLEARER = 0.1

# What circles and boxes are read as, from two on.
_DRAWN = re.compile(r"[0OoΩΩ口□日\s]{2,}")
_EAST_ASIAN = re.compile(r"[\u3000-\u9fff\uac00-\ud7af\uff00-\uffef]")
_ZERO_IN_WORD = re.compile(r"(?<=([^\W\d_]))(0+)(?=[^\W\d_])")

# Ways to hold a box: which of its corners, counted clockwise from the upper left one, is the first one of the text.
UPRIGHT, FROM_TOP, UPSIDE_DOWN, FROM_BELOW = range(4)


def text_reader_available() -> bool:
    """Whether rapidocr and what it runs on are installed; they are, with pianta[plan]."""
    return all(find_spec(name) is not None for name in ("rapidocr", "onnxruntime"))


def read_texts(colors: Colors) -> tuple[PlacedText, ...]:
    """The texts of a sheet, from top to bottom, level or turned by a quarter or a half.

    colors: shape (H, W, 3), red, green, blue. Corners are in its pixels.
    Models lie in the wheel of rapidocr; nothing is loaded from elsewhere. It works on one thread.
    Raises ImportError where text_reader_available says no.
    """
    bgr = np.ascontiguousarray(colors[..., ::-1])
    placed = [text for box in _find_boxes(bgr) if (text := _place_text(bgr, box))]
    return tuple(sorted(_without_symbols(placed), key=lambda text: tuple(text.middle)))


def _without_symbols(texts: Sequence[PlacedText]) -> list[PlacedText]:
    """Texts without chairs and tables that were read as O or as signs of a script that the sheet is not in."""
    worded = [text for text in texts if not _DRAWN.fullmatch(text.text)]
    strange = [bool(_EAST_ASIAN.search(text.text)) for text in worded]
    in_it = 2 * sum(strange) > len(worded)
    return [text for text, odd in zip(worded, strange, strict=True) if in_it or not odd]


def _place_text(bgr: Colors, box: Floats) -> PlacedText | None:
    """What is written in a box, held the way in which it is read with most confidence."""
    usual, *others = _ways_to_hold(box)
    text, confidence = _read_box(bgr, _turned(box, usual))
    kept = usual
    for turn in others if len(others) > 1 or usual != UPRIGHT or confidence < DOUBTFUL else ():
        read, sure = _read_box(bgr, _turned(box, turn))
        if sure > confidence + CLEARER * (kept == UPRIGHT):
            text, confidence, kept = read, sure, turn
    if confidence < LEAST_CONFIDENCE or not any(map(str.isalnum, text)):
        return None
    return PlacedText(text, _turned(box, kept)[:, ::-1], confidence)


@cache
def _reader() -> Callable[..., Any]:
    from rapidocr import RapidOCR

    options = {
        "Global.log_level": "critical",
        # Sizes are chosen here.
        "Global.use_preprocess_img": False,
        "Global.use_vertical_padding": False,
        "Global.text_score": 0.0,
        "Det.limit_side_len": STEP,
        "EngineConfig.onnxruntime.intra_op_num_threads": 1,
        "EngineConfig.onnxruntime.inter_op_num_threads": 1,
    }
    reader: Callable[..., Any] = RapidOCR(params=options)
    return reader


def _find_boxes(bgr: Colors) -> list[Floats]:
    """Boxes around texts, each of shape (4, 2), x and y from the upper left corner on clockwise.

    The sheet is looked at twice, because the network loses letters that are too small, and those that are too large.
    """
    height, width = bgr.shape[:2]
    factor = np.sqrt(MOST_PIXELS / (height * width))
    if factor > 1:
        factor = max(1.0, min(MOST_ENLARGED, np.sqrt(ENLARGED_PIXELS / (height * width))))
    boxes = _find_boxes_at(bgr, factor)
    spans = [(box.min(axis=0), box.max(axis=0)) for box in boxes]

    def is_new(box: Floats) -> bool:
        low, high = box.min(axis=0), box.max(axis=0)
        return not any((low < last).all() and (first < high).all() for first, last in spans)

    return boxes + [box for box in _find_boxes_at(bgr, factor / COARSER) if is_new(box)]


def _find_boxes_at(bgr: Colors, factor: float) -> list[Floats]:
    """The boxes that are found on a sheet when it is enlarged by a factor."""
    height, width = bgr.shape[:2]
    size = [max(STEP, STEP * round(side * factor / STEP)) for side in (width, height)]
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    scaled = cv2.resize(bgr, size, interpolation=method)
    found = _reader()(scaled, use_det=True, use_cls=False, use_rec=False)
    if found.boxes is None:
        return []
    return [np.asarray(box, float) * (width / size[0], height / size[1]) for box in found.boxes]


def _ways_to_hold(box: Floats) -> tuple[int, ...]:
    """The ways to hold a box, the usual one first."""
    wide, high = np.hypot(*(box[1] - box[0])), np.hypot(*(box[3] - box[0]))
    if high < TALL * wide:
        return UPRIGHT, UPSIDE_DOWN
    return (FROM_BELOW, FROM_TOP) if high > VERY_TALL * wide else (UPRIGHT, FROM_BELOW, FROM_TOP)


def _turned(box: Floats, turn: int) -> Floats:
    return np.roll(box, -turn, axis=0)


def _read_box(bgr: Colors, box: Floats) -> tuple[str, float]:
    """What is written in a box whose first corner is the upper left one of the text, and how sure it is."""
    wide, high = np.hypot(*(box[1] - box[0])), np.hypot(*(box[3] - box[0]))
    # The network sees lines of 48 pixels.
    scale = 48 / max(high, 1)
    size = max(8, round(wide * scale)), 48
    target = np.array([(0, 0), (size[0], 0), size, (0, size[1])], np.float32)
    matrix = cv2.getPerspectiveTransform(box.astype(np.float32), target)
    line = cv2.warpPerspective(bgr, matrix, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    read = _reader()(line, use_det=False, use_cls=False, use_rec=True)
    if not read.txts:
        return "", 0.0
    return _tidied(read.txts[0]), float(read.scores[0])


def _tidied(text: str) -> str:
    """A reading with single blanks, and an O where a zero stands between letters, which it does in no name."""
    spelt = _ZERO_IN_WORD.sub(lambda zeros: ("O" if zeros[1].isupper() else "o") * len(zeros[2]), text)
    return " ".join(spelt.split())


def erase_texts(colors: Colors, ink: Mask, texts: Sequence[PlacedText]) -> Colors:
    """The sheet without the letters of its texts, shape (H, W, 3): paper, or the colour of the room, where they stood.

    ink: shape (H, W), of the same sheet.
    """
    letters = (ink & ~remove_texts(ink, texts)).astype(np.uint8)
    if not letters.any():
        return colors
    # Their soft edges, too
    edged = cv2.dilate(letters, np.ones((3, 3), np.uint8))
    highest = min(max(text.height for text in texts), max(ink.shape))
    side = max(3, round(highest / 2)) | 1
    # Light letters on dark paper are taken out by the opposite
    way = cv2.MORPH_CLOSE if straighten_tones(colors) is colors else cv2.MORPH_OPEN
    paper = cv2.morphologyEx(colors, way, np.ones((side, side), np.uint8))
    return np.where(edged[:, :, None] > 0, paper, colors)


def remove_texts(ink: Mask, texts: Sequence[PlacedText]) -> Mask:
    """The ink of a sheet without the letters of its texts, shape (H, W).

    A letter is a piece of ink that lies in the box of a text, or would if long straight runs of ink were not there,
    which are walls that letters touch. Whatever goes on outside of the box stays: walls, arcs of doors.
    """
    rest = np.array(ink, bool)
    for text in texts:
        corners = text.corners
        reach = int(np.ceil(2 * text.height)) + 2
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int) - reach, 0)
        high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + reach, ink.shape)
        if (high <= low).any():
            continue
        window = rest[low[0] : high[0], low[1] : high[1]]
        box = _grown_box(text, low, window.shape)
        window &= ~_pieces_inside(window, box)
        window &= ~_pieces_inside(window & ~_long_runs(window, text.height), box)
    return rest


def _grown_box(text: PlacedText, low: NDArray[np.int64], shape: tuple[int, ...]) -> Mask:
    """The box of a text grown by a share of its height, as pixels of a window that starts at low."""
    along, across = text.corners[1] - text.corners[0], text.corners[3] - text.corners[0]
    more = 1 + GROWTH * text.height
    outward = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    units = np.array([side / max(float(np.hypot(*side)), 1e-9) for side in (along, across)])
    corners = text.corners + more * outward @ units - low
    box = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(box, np.rint(corners[:, ::-1]).astype(np.int32), 1)
    return box.astype(bool)


def _pieces_inside(ink: Mask, box: Mask) -> Mask:
    """The connected pieces of ink that lie in a box with almost all of their pixels."""
    count, pieces = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    whole = np.bincount(pieces.ravel(), minlength=count)
    inside = np.bincount(pieces[box], minlength=count) >= INSIDE * whole
    inside[0] = False
    return np.asarray(inside[pieces])


def _long_runs(ink: Mask, height: float) -> Mask:
    """Ink in level or upright runs that are longer than any stroke of a letter."""
    length = int(np.ceil(LONG_RUN * min(height, max(ink.shape)))) + 1
    level, upright = np.ones((1, length), np.uint8), np.ones((length, 1), np.uint8)
    image = ink.astype(np.uint8)
    opened = [cv2.morphologyEx(image, cv2.MORPH_OPEN, run) for run in (level, upright)]
    return np.asarray(np.maximum(*opened).astype(bool))
