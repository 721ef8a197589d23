"""Template matching: where a small image lies on a larger one, by the normalised correlation of their pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats

Image = NDArray[Any]

MIN_TEMPLATE_SIDE = 4  # px: smaller templates match everywhere
MIN_SQUARES = 1e-3  # sum of squares about the mean, below which nothing is drawn in a window
MAX_FILTERED = 100  # px of a template up to which filtering is faster than the Fourier transform, as measured


def correlate(image: Image, template: Image) -> Image | None:
    """Scores of TM_CCOEFF_NORMED, -1 … 1; None if the template is too small or does not fit."""
    if not _fits(template, image):
        return None
    response = cv2.matchTemplate(image, template, cv2.TM_CCOEFF_NORMED)
    # Where nothing is drawn OpenCV divides by nearly zero
    response[~(response <= 1.001)] = -1
    return response


class LargeImage:
    """A large grey image on which many templates are matched.

    TM_CCOEFF_NORMED divides by the spread of the pixels in each window, which is cached for one size of windows, since
    templates of one size come one after another.
    """

    def __init__(self, image: Image) -> None:
        self.image = image
        self._spreads: dict[tuple[int, ...], Image] = {}

    def correlate(self, template: Image) -> Image | None:
        """As the function of that name."""
        deviations = template - template.mean()
        norm = np.linalg.norm(deviations)
        if not _fits(template, self.image) or norm == 0:
            return None
        rows, cols = np.subtract(self.image.shape, template.shape) + 1
        if template.size <= MAX_FILTERED:
            border = cv2.BORDER_CONSTANT
            numerator = cv2.filter2D(self.image, cv2.CV_32F, deviations, anchor=(0, 0), borderType=border)
        else:
            numerator = cv2.matchTemplate(self.image, deviations, cv2.TM_CCORR)
        return np.asarray(numerator[:rows, :cols] / (self._spread(template.shape)[:rows, :cols] * np.float32(norm)))

    def _spread(self, shape: tuple[int, ...]) -> Image:
        """Root of the sum of squares about the mean, of the window that starts at each pixel; of the image's shape."""
        if shape not in self._spreads:
            size = shape[::-1]
            options: dict[str, Any] = {"anchor": (0, 0), "normalize": False, "borderType": cv2.BORDER_CONSTANT}
            total = cv2.boxFilter(self.image, cv2.CV_32F, size, **options)
            squares = cv2.sqrBoxFilter(self.image, cv2.CV_32F, size, **options)
            squares = squares - total * total / np.float32(shape[0] * shape[1])
            # Blank paper matches nothing
            self._spreads = {shape: np.sqrt(np.maximum(squares, MIN_SQUARES))}
        return self._spreads[shape]


def _fits(template: Image, image: Image) -> bool:
    sides = zip(template.shape[:2], image.shape[:2], strict=True)
    return all(MIN_TEMPLATE_SIDE <= side <= image_side for side, image_side in sides)


def find_peaks(response: Image, *, least: float, most: int) -> Floats:
    """Row and col of the highest local maxima of a response, shape (N, 2), the best first.

    least: the score of a peak, at least. most: peaks, at most.
    """
    highest = cv2.dilate(response, np.ones((5, 5), np.uint8))
    peaks = np.flatnonzero((response >= least) & (response >= highest))
    best = peaks[np.argsort(-response.take(peaks), kind="stable")[:most]]
    return np.column_stack(np.divmod(best, response.shape[1])).astype(float)
