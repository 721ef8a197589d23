"""The ink of a sheet: what is drawn on the paper, whatever the light, the colours and the noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Mask

Greys = NDArray[np.uint8]
Contrast = NDArray[np.float32]

# A sheet whose middle grey is below this is dark paper, as blueprints are.
DARK_PAPER = 100
# The middle grey is that of so many pixels, spread over the sheet.
SAMPLED = 200_000
# The paper is looked for within this share of the longest side: walls are thinner, coloured areas wider.
REACH = 0.02
# Ink is darker than its paper by this many grey levels at least, and at most so many are asked; noise never is ink.
LEAST_CONTRAST, MOST_CONTRAST, NOISES = 14.0, 60.0, 5.0
# What is as dark as this in even light is ink, however wide.
BLACK = 90


def straighten_tones(colors: Colors) -> Colors:
    """The colours of a sheet as on white paper: dark paper with light lines is turned to its negative."""
    pixels = colors.reshape(-1, 3)
    # An odd step meets no pattern of the sheet
    middle = np.median(take_lightest(pixels[:: len(pixels) // SAMPLED | 1]))
    return np.asarray(255 - colors if middle < DARK_PAPER else colors, np.uint8)


def take_lightest(colors: Colors) -> Greys:
    """The lightest channel of each pixel, shape (H, W)."""
    # NumPy takes twenty times as long over the last axis
    return np.maximum(np.maximum(colors[..., 0], colors[..., 1]), colors[..., 2])


def take_darkest(colors: Colors) -> Greys:
    """The darkest channel of each pixel, shape (H, W)."""
    return np.minimum(np.minimum(colors[..., 0], colors[..., 1]), colors[..., 2])


def binarise(colors: Colors) -> Mask:
    """The ink of a sheet, shape (H, W): what is darker than the paper around it (thesis, section 3.3).

    colors: shape (H, W, 3). Ink is what has its full contrast, and what is black however wide it is.
    """
    paper = straighten_tones(colors)
    # A strong colour is dark in one channel, black in all
    lightest = take_lightest(paper)
    even = np.arange(256, dtype=np.float32) * (255.0 / max(int(lightest.max()), 1))
    black = cv2.LUT(lightest, (even < BLACK).astype(np.uint8)).view(np.bool_)
    levels, shares = _compare_to_paper(paper)
    return np.asarray(cv2.LUT(levels, (shares > 0.5).astype(np.uint8)).view(np.bool_) | black)


def measure_contrast(colors: Colors) -> Contrast:
    """How much darker each pixel is than the paper around it, 0 … 1, shape (H, W); 0.5 parts ink from paper.

    The paper, or the colour of a room, is the lightest within a small reach, so that uneven light and coloured rooms
    have no contrast. The unit is Otsu's threshold, above the noise of grain and JPEG.
    """
    return np.asarray(cv2.LUT(*_compare_to_paper(straighten_tones(colors))), np.float32)


def grade_contrast(paper: Colors) -> Greys:
    """The contrast of a sheet in straight tones, 0 … 255, shape (H, W)."""
    levels, shares = _compare_to_paper(paper)
    return np.asarray(cv2.LUT(levels, (shares * 255).astype(np.uint8)), np.uint8)


def _compare_to_paper(colors: Colors) -> tuple[Greys, Contrast]:
    """By how many grey levels each pixel is darker than the paper around it, and what contrast that is.

    Shapes (H, W), and (256,) for each number of levels. colors: in straight tones.
    """
    darkest = take_darkest(colors)
    side = max(3, round(REACH * max(darkest.shape))) | 1
    paper = cv2.morphologyEx(darkest, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    levels = np.asarray(cv2.subtract(paper, darkest), np.uint8)
    inked = levels[levels > LEAST_CONTRAST]
    otsu = cv2.threshold(inked.reshape(-1, 1), 0, 255, cv2.THRESH_OTSU)[0] if len(inked) else MOST_CONTRAST
    # Hair-thin grey lines may be most of the ink, so Otsu's threshold is taken by half
    least = max(min(otsu / 2, MOST_CONTRAST), LEAST_CONTRAST, NOISES * measure_noise(darkest))
    return levels, np.clip(np.arange(256, dtype=np.float32) / (2 * least), 0, 1)


def measure_noise(greys: Greys) -> float:
    """Standard deviation of the grain of an image, grey levels (Immerkær, Fast noise variance estimation, 1996).

    The median over the image stands for its mean, so that lines do not count as grain.
    """
    (height, width), framed = greys.shape, cv2.copyMakeBorder(greys, 1, 1, 1, 1, cv2.BORDER_REFLECT_101)
    laplacian = ((1, -2, 1), (-2, 4, -2), (1, -2, 1))
    response = sum(
        weight * framed[row : row + height : 4, col : col + width : 4].astype(np.int16)
        for row, weights in enumerate(laplacian)
        for col, weight in enumerate(weights)
    )
    return float(np.median(np.abs(response).astype(np.float32)) / 0.6745 / 6)
