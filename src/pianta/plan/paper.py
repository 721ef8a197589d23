"""The ink of a sheet: what is drawn on the paper, whatever the light, the colours and the noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta.plan.sheet import Colors, Mask

Greys = NDArray[np.uint8]
Contrast = NDArray[np.float32]

# A sheet whose middle grey is below this is dark paper, as blueprints are.
DARK_PAPER = 100
# The paper is looked for within this share of the longest side: walls are thinner, coloured areas wider.
REACH = 0.02
# Ink is darker than its paper by this many grey levels at least, and at most so many are asked; noise never is ink.
LEAST_CONTRAST, MOST_CONTRAST, NOISES = 14.0, 60.0, 5.0
# What is as dark as this in even light is ink, however wide.
BLACK = 90


def straighten_tones(colors: Colors) -> Colors:
    """The colours of a sheet as on white paper: dark paper with light lines is turned to its negative."""
    return np.asarray(255 - colors if np.median(colors.max(axis=2)) < DARK_PAPER else colors, np.uint8)


def binarise(colors: Colors) -> Mask:
    """The ink of a sheet, shape (H, W): what is darker than the paper around it (thesis, section 3.3).

    colors: shape (H, W, 3). Ink is what has its full contrast, and what is black however wide it is.
    """
    # A strong colour is dark in one channel, black in all
    lightest = straighten_tones(colors).max(axis=2)
    even = lightest.astype(np.float32) * (255.0 / max(int(lightest.max()), 1))
    return np.asarray((measure_contrast(colors) > 0.5) | (even < BLACK))


def measure_contrast(colors: Colors) -> Contrast:
    """How much darker each pixel is than the paper around it, 0 … 1, shape (H, W); 0.5 parts ink from paper.

    The paper, or the colour of a room, is the lightest within a small reach, so that uneven light and coloured rooms
    have no contrast. The unit is Otsu's threshold, above the noise of grain and JPEG.
    """
    darkest = straighten_tones(colors).min(axis=2)
    side = max(3, round(REACH * max(darkest.shape))) | 1
    paper = cv2.morphologyEx(darkest, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    contrast = cv2.subtract(paper, darkest)
    inked = contrast[contrast > LEAST_CONTRAST]
    otsu = cv2.threshold(inked.reshape(-1, 1), 0, 255, cv2.THRESH_OTSU)[0] if len(inked) else MOST_CONTRAST
    # Hair-thin grey lines may be most of the ink, so Otsu's threshold is taken by half
    least = max(min(otsu / 2, MOST_CONTRAST), LEAST_CONTRAST, NOISES * measure_noise(darkest))
    return np.asarray(np.clip(contrast.astype(np.float32) / (2 * least), 0, 1))


def measure_noise(greys: Greys) -> float:
    """Standard deviation of the grain of an image, grey levels (Immerkær, Fast noise variance estimation, 1996).

    The median over the image stands for its mean, so that lines do not count as grain.
    """
    laplacian = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    response = np.abs(cv2.filter2D(greys, cv2.CV_32F, laplacian))
    return float(np.median(response[::4, ::4]) / 0.6745 / 6)
