"""The ink of a sheet: what is drawn on the paper, whatever the light, the colours and the noise."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Mask

Greys = NDArray[np.uint8]
Contrast = NDArray[np.float32]

# Pixels, spread over the sheet, whose median is taken for the grey level of the paper
N_SAMPLED_PIXELS = 200_000


@dataclass(frozen=True, kw_only=True)
class BinarizationParameters:
    """Thresholds between ink and paper; grey levels are of 8 bits. Chosen by hand, no fit is on record."""

    dark_paper: int = 100  # grey level: a sheet whose median is below is dark paper, as of a negative
    blueprint_lines: tuple[float, float] = (0.005, 0.3)  # share of the sheet that is lighter than blue paper
    line_lightness: int = 60  # grey levels by which lines of a blueprint are lighter
    paper_reach: float = 0.02  # share of the longer side: wider than walls, narrower than coloured areas
    min_contrast: float = 14.0  # grey levels between ink and paper, at least
    max_contrast: float = 60.0  # grey levels between ink and paper that are enough on every sheet
    noise_factor: float = 5.0  # ink differs from the paper by this many standard deviations of the noise
    black: int = 90  # grey level in even light: darker areas are ink, however wide


PARAMETERS = BinarizationParameters()


def invert_if_dark(colors: Colors) -> Colors:
    """The colours of a sheet as on white paper: dark paper with light lines becomes its negative, a blueprint grey."""
    pixels = colors.reshape(-1, 3)
    # An odd step meets no pattern of the sheet
    sample = pixels[:: len(pixels) // N_SAMPLED_PIXELS | 1]
    if np.median(max_channel(sample)) < PARAMETERS.dark_paper:
        return np.asarray(255 - colors, np.uint8)
    if _is_blueprint(sample):
        # The negative of blue is yellow, whose darkest channel has no contrast to lines
        negative = 255 - colors.mean(axis=2)
        return np.repeat(negative.astype(np.uint8)[..., None], 3, axis=2)
    return np.asarray(colors, np.uint8)


def _is_blueprint(pixels: Colors) -> bool:
    """Whether the paper is a strong, dark colour on which a few lines are lighter; pixels: shape (N, 3)."""
    p = PARAMETERS
    grey = pixels.mean(axis=1)
    middle = float(np.median(grey))
    least, most = p.blueprint_lines
    lighter = float((grey > middle + p.line_lightness).mean())
    return middle < p.dark_paper and least <= lighter <= most


def max_channel(colors: Colors) -> Greys:
    """The highest channel of each pixel, shape (H, W)."""
    # NumPy takes twenty times as long over the last axis
    return np.maximum(np.maximum(colors[..., 0], colors[..., 1]), colors[..., 2])


def min_channel(colors: Colors) -> Greys:
    """The lowest channel of each pixel, shape (H, W)."""
    return np.minimum(np.minimum(colors[..., 0], colors[..., 1]), colors[..., 2])


@dataclass(frozen=True, eq=False)
class PaperContrast:
    """How much darker each pixel of a sheet is than the paper around it.

    levels: grey levels, shape (H, W). shares: the contrast of each number of levels, shape (256,), 0 … 1.
    """

    levels: Greys
    shares: Contrast

    @property
    def contrast(self) -> Contrast:
        """Contrast of each pixel, shape (H, W), 0 … 1; above 0.5 is ink."""
        return np.asarray(cv2.LUT(self.levels, self.shares), np.float32)

    @property
    def contrast_uint8(self) -> Greys:
        """Contrast of each pixel, shape (H, W), 0 … 255."""
        return np.asarray(cv2.LUT(self.levels, (self.shares * 255).astype(np.uint8)), np.uint8)

    def ink(self, paper: Colors) -> Mask:
        """What has full contrast, and what is black however wide it is, shape (H, W); paper: the sheet, light."""
        # A strong colour is dark in one channel, black in all
        lightest = max_channel(paper)
        even = np.arange(256, dtype=np.float32) * (255.0 / max(int(lightest.max()), 1))
        black = cv2.LUT(lightest, (even < PARAMETERS.black).astype(np.uint8)).view(np.bool_)
        return np.asarray(cv2.LUT(self.levels, (self.shares > 0.5).astype(np.uint8)).view(np.bool_) | black)


def compare_to_paper(paper: Colors) -> PaperContrast:
    """The contrast of a sheet with light paper, shape (H, W, 3).

    The paper, or the colour of a room, is the lightest grey within a small reach, so that uneven light and coloured
    rooms have no contrast. The unit is Otsu's threshold, above the noise of grain and JPEG.
    """
    darkest = min_channel(paper)
    side = max(3, round(PARAMETERS.paper_reach * max(darkest.shape))) | 1
    around = cv2.morphologyEx(darkest, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    levels = np.asarray(cv2.subtract(around, darkest), np.uint8)
    inked = levels[levels > PARAMETERS.min_contrast]
    otsu = cv2.threshold(inked.reshape(-1, 1), 0, 255, cv2.THRESH_OTSU)[0] if len(inked) else PARAMETERS.max_contrast
    # Hair-thin grey lines may be most of the ink, so half of Otsu's threshold counts
    least = min(otsu / 2, PARAMETERS.max_contrast)
    least = max(least, PARAMETERS.min_contrast, PARAMETERS.noise_factor * measure_noise(darkest))
    return PaperContrast(levels, np.clip(np.arange(256, dtype=np.float32) / (2 * least), 0, 1))


def binarise(colors: Colors) -> Mask:
    """The ink of a picture, shape (H, W): what is darker than the paper around it (thesis, section 3.3).

    colors: shape (H, W, 3).
    """
    paper = invert_if_dark(colors)
    return compare_to_paper(paper).ink(paper)


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
    # 0.6745: median of the absolute value of a standard normal; 6: root of the sum of the squared weights
    return float(np.median(np.abs(response).astype(np.float32)) / 0.6745 / 6)
