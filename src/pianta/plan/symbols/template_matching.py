"""Template matching: where a small image lies on a larger one, by the normalised correlation of their pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats

Image = NDArray[Any]

# Pixels of the smallest side of a template.
LEAST_SIDE = 4
# Windows whose squares about the mean sum up to less have nothing drawn in them.
LEAST_SPREAD = 1e-3
# Templates of so few pixels are filtered with faster than by Fourier transform.
MOST_FILTERED = 100


def respond(image: Image, template: Image) -> Image | None:
    """Scores of TM_CCOEFF_NORMED, -1 … 1; None where the template is too small or does not fit."""
    if not _fits(template, image):
        return None
    response = cv2.matchTemplate(image, template, cv2.TM_CCOEFF_NORMED)
    # Where nothing is drawn OpenCV divides by nearly nothing
    response[~(response <= 1.001)] = -1
    return response


class LargeImage:
    """A large image of greys on which many templates are looked for.

    How much its pixels spread within a window at each place, by which TM_CCOEFF_NORMED divides, is kept for one window,
    since templates of one size come one after another.
    """

    def __init__(self, image: Image) -> None:
        self.image = image
        self.kept: dict[tuple[int, ...], Image] = {}

    def respond(self, template: Image) -> Image | None:
        """As the function of that name."""
        apart = template - template.mean()
        norm = np.linalg.norm(apart)
        if not _fits(template, self.image) or norm == 0:
            return None
        rows, cols = np.subtract(self.image.shape, template.shape) + 1
        if template.size <= MOST_FILTERED:
            numerator = cv2.filter2D(self.image, cv2.CV_32F, apart, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
        else:
            numerator = cv2.matchTemplate(self.image, apart, cv2.TM_CCORR)
        return np.asarray(numerator[:rows, :cols] / (self._spread(template.shape)[:rows, :cols] * np.float32(norm)))

    def _spread(self, shape: tuple[int, ...]) -> Image:
        """Root of the sum of squares about the mean, of the window from each place on; of the image's shape."""
        if shape not in self.kept:
            size = shape[::-1]
            way: dict[str, Any] = {"anchor": (0, 0), "normalize": False, "borderType": cv2.BORDER_CONSTANT}
            total = cv2.boxFilter(self.image, cv2.CV_32F, size, **way)
            squares = cv2.sqrBoxFilter(self.image, cv2.CV_32F, size, **way)
            squares = squares - total * total / np.float32(shape[0] * shape[1])
            # Where nothing is drawn nothing is alike
            self.kept = {shape: np.sqrt(np.maximum(squares, LEAST_SPREAD))}
        return self.kept[shape]


def _fits(template: Image, image: Image) -> bool:
    sides = zip(template.shape[:2], image.shape[:2], strict=True)
    return all(LEAST_SIDE <= side <= whole for side, whole in sides)


def find_peaks(response: Image, *, least: float, most: int) -> Floats:
    """Row and col of the best places of a response, shape (N, 2), at most so many."""
    highest = cv2.dilate(response, np.ones((5, 5), np.uint8))
    places = np.flatnonzero((response >= least) & (response >= highest))
    best = places[np.argsort(-response.take(places), kind="stable")[:most]]
    return np.column_stack(np.divmod(best, response.shape[1])).astype(float)
