"""Texts on a sheet: found and read with rapidocr, and their letters taken out of the ink (thesis, section 3.3)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Floats, Mask
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.text.detection import find_boxes, release_memory, text_reader

LINE_PX = 48  # px of the height of a line that the recogniser takes


@dataclass(frozen=True, kw_only=True)
class TextParameters:
    """Thresholds of `read_texts` and `remove_texts`; heights are those of a line of text. Chosen by hand."""

    upright_ratio: float = 1.2  # height over width of a box from which on it is also read turned by a quarter
    turned_ratio: float = 2.5  # from which on it is read only turned: below, it may be an upright digit
    certain_confidence: float = 0.7  # flat boxes that are read with less are also read upside down
    turned_gain: float = 0.1  # confidence by which another turn must be better than the usual one
    min_confidence: float = 0.5  # of a text
    # Mirrored sheets: medians of confidences over the widest level texts. On plans of the data they were 0.97 to 1 the
    # right way round, and 0.37 to 0.72 the wrong way
    min_wide: float = 2.0  # width of such a text, heights
    n_wide: int = 12  # texts, at most
    least_wide: int = 4  # texts, at least
    doubtful_confidence: float = 0.8  # below which the mirrored sheet is tried
    mirrored_confidence: float = 0.9  # of the mirrored sheet, at least
    # Letters in the ink of a sheet
    box_margin: float = 0.2  # heights by which the box of a text is grown
    min_inside: float = 0.95  # share of the pixels of a letter in that box
    max_stroke: float = 1.8  # heights of a straight run of ink: longer ones are walls


PARAMETERS = TextParameters()

# What circles and boxes are read as, from two on
_READ_CIRCLES = re.compile(r"[0OoΩΩ口□日\s]{2,}")
_EAST_ASIAN = re.compile(r"[\u3000-\u9fff\uac00-\ud7af\uff00-\uffef]")
_ZERO_IN_WORD = re.compile(r"(?<=([^\W\d_]))(0+)(?=[^\W\d_])")

# Turns of a text: which corner of its box, counted clockwise from the upper left one, is the first one of the text
UPRIGHT, FROM_TOP, UPSIDE_DOWN, FROM_BELOW = range(4)


def text_reader_available() -> bool:
    """Whether rapidocr and what it runs on are installed; they are, with pianta[plan]."""
    return all(find_spec(name) is not None for name in ("rapidocr", "openvino"))


def read_texts(colors: Colors) -> tuple[PlacedText, ...]:
    """The texts of a sheet, from top to bottom, level or turned by a quarter or a half.

    colors: shape (H, W, 3), red, green, blue. Corners are in its pixels.
    The models are those in the wheel of rapidocr; nothing is downloaded. One thread is used.
    A sheet whose texts are read clearly better in a mirror is read there; its texts are `is_mirrored`.
    Raises ImportError without a text reader.
    """
    bgr = np.ascontiguousarray(colors[..., ::-1])
    boxes = find_boxes(bgr)
    release_memory()
    read = [_place_text(bgr, box) for box in boxes]
    if _reads_better_mirrored(bgr, boxes, read):
        bgr = np.ascontiguousarray(bgr[:, ::-1])
        mirrored = [_place_text(bgr, _mirrored_box(box, bgr.shape[1])) for box in boxes]
        read = [text and replace(text, corners=_mirrored_corners(text.corners, bgr.shape[1])) for text in mirrored]
    release_memory()
    placed = [text for text in read if text]
    return tuple(sorted(_without_symbols(placed), key=lambda text: tuple(text.middle)))


def _reads_better_mirrored(bgr: Colors, boxes: Sequence[Floats], read: Sequence[PlacedText | None]) -> bool:
    """Whether the widest level texts, which were read with little confidence, are read in a mirror with much."""
    p = PARAMETERS
    sizes = [(np.hypot(*(box[1] - box[0])), np.hypot(*(box[3] - box[0]))) for box in boxes]
    wide = [index for index, (width, height) in enumerate(sizes) if width >= p.min_wide * height]
    wide = sorted(wide, key=lambda index: (-sizes[index][0], index))[: p.n_wide]
    texts = [read[index] for index in wide]
    confidences = [text.confidence if text else 0.0 for text in texts]
    if len(wide) < p.least_wide or np.median(confidences) >= p.doubtful_confidence:
        return False
    mirror = np.ascontiguousarray(bgr[:, ::-1])
    in_mirror = [_read_box(mirror, _mirrored_box(boxes[index], mirror.shape[1]))[1] for index in wide]
    return bool(np.median(in_mirror) >= p.mirrored_confidence)


def _mirrored_box(box: Floats, width: int) -> Floats:
    """A box, x and y from the upper left corner on clockwise, on the sheet in a mirror."""
    return np.asarray((box * (-1, 1) + (width, 0))[[1, 0, 3, 2]])


def _mirrored_corners(corners: Floats, width: int) -> Floats:
    """Corners, row and col in the order of the text, on the sheet in a mirror."""
    return np.asarray(corners * (1, -1) + (0, width))


def _without_symbols(texts: Sequence[PlacedText]) -> list[PlacedText]:
    """Texts without chairs and tables that were read as O, or as characters of a script that the sheet is not in."""
    words = [text for text in texts if not _READ_CIRCLES.fullmatch(text.text)]
    east_asian = [bool(_EAST_ASIAN.search(text.text)) for text in words]
    is_asian_sheet = 2 * sum(east_asian) > len(words)
    return [text for text, is_asian in zip(words, east_asian, strict=True) if is_asian_sheet or not is_asian]


def _place_text(bgr: Colors, box: Floats) -> PlacedText | None:
    """The text in a box, in the turn that is read with most confidence."""
    p, (usual, *others) = PARAMETERS, _turns(box)
    turn, (text, confidence) = usual, _read_box(bgr, _turned(box, usual))
    if len(others) > 1 or usual != UPRIGHT or confidence < p.certain_confidence:
        for other in others:
            other_text, other_confidence = _read_box(bgr, _turned(box, other))
            if other_confidence > confidence + p.turned_gain * (turn == UPRIGHT):
                turn, text, confidence = other, other_text, other_confidence
    if confidence < p.min_confidence or not any(map(str.isalnum, text)):
        return None
    return PlacedText(text, _turned(box, turn)[:, ::-1], confidence)


def _turns(box: Floats) -> tuple[int, ...]:
    """The turns in which to read a box, the usual one first."""
    width, height = np.hypot(*(box[1] - box[0])), np.hypot(*(box[3] - box[0]))
    if height < PARAMETERS.upright_ratio * width:
        return UPRIGHT, UPSIDE_DOWN
    return (FROM_BELOW, FROM_TOP) if height > PARAMETERS.turned_ratio * width else (UPRIGHT, FROM_BELOW, FROM_TOP)


def _turned(box: Floats, turn: int) -> Floats:
    return np.roll(box, -turn, axis=0)


def _read_box(bgr: Colors, box: Floats) -> tuple[str, float]:
    """The text in a box whose first corner is the upper left one of the text, and its confidence."""
    width, height = np.hypot(*(box[1] - box[0])), np.hypot(*(box[3] - box[0]))
    scale = LINE_PX / max(height, 1)
    size = max(8, round(width * scale)), LINE_PX
    target = np.array([(0, 0), (size[0], 0), size, (0, size[1])], np.float32)
    matrix = cv2.getPerspectiveTransform(box.astype(np.float32), target)
    line = cv2.warpPerspective(bgr, matrix, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    result = text_reader()(line, use_det=False, use_cls=False, use_rec=True)
    return (_normalise(result.txts[0]), float(result.scores[0])) if result.txts else ("", 0.0)


def _normalise(text: str) -> str:
    """A text with single blanks, and an O for a zero between letters, which no name has."""
    spelt = _ZERO_IN_WORD.sub(lambda zeros: ("O" if zeros[1].isupper() else "o") * len(zeros[2]), text)
    return " ".join(spelt.split())


def erase_texts(sheet: Sheet, texts: Sequence[PlacedText]) -> Sheet:
    """The sheet without the letters of its texts: paper, or the colour of the room, where they stood."""
    letters = (sheet.ink & ~remove_texts(sheet.ink, texts)).astype(np.uint8)
    if not letters.any():
        return sheet
    # Their soft edges, too
    edged = cv2.dilate(letters, np.ones((3, 3), np.uint8))
    highest = min(max(text.height for text in texts), max(sheet.shape))
    side = max(3, round(highest / 2)) | 1
    # Light letters on dark paper are removed by the opposite operation
    is_light = sheet.paper is sheet.colors
    operation = cv2.MORPH_CLOSE if is_light else cv2.MORPH_OPEN
    background = cv2.morphologyEx(sheet.colors, operation, np.ones((side, side), np.uint8))
    return replace(sheet, colors=np.where(edged[:, :, None] > 0, background, sheet.colors))


def remove_texts(ink: Mask, texts: Sequence[PlacedText]) -> Mask:
    """The ink of a sheet without the letters of its texts, shape (H, W).

    A letter is a piece of ink in the box of a text, also after long straight runs of ink, which are walls that letters
    touch, are taken out. What goes on outside of the box stays: walls, arcs of doors.
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
    """The box of a text with a margin, as a mask of a window that starts at row and col low."""
    along, across = text.corners[1] - text.corners[0], text.corners[3] - text.corners[0]
    margin = 1 + PARAMETERS.box_margin * text.height
    outward = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    units = np.array([side / max(float(np.hypot(*side)), 1e-9) for side in (along, across)])
    corners = text.corners + margin * outward @ units - low
    box = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(box, np.rint(corners[:, ::-1]).astype(np.int32), 1)
    return box.astype(bool)


def _pieces_inside(ink: Mask, box: Mask) -> Mask:
    """The connected pieces of ink that lie in a box with almost all of their pixels."""
    count, pieces = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    sizes = np.bincount(pieces.ravel(), minlength=count)
    inside = np.bincount(pieces[box], minlength=count) >= PARAMETERS.min_inside * sizes
    inside[0] = False
    return np.asarray(inside[pieces])


def _long_runs(ink: Mask, height: float) -> Mask:
    """Ink in horizontal or vertical runs that are longer than any stroke of a letter."""
    length = int(np.ceil(PARAMETERS.max_stroke * min(height, max(ink.shape)))) + 1
    lines = np.ones((1, length), np.uint8), np.ones((length, 1), np.uint8)
    image = ink.astype(np.uint8)
    opened = [cv2.morphologyEx(image, cv2.MORPH_OPEN, run) for run in lines]
    return np.asarray(np.maximum(*opened).astype(bool))
