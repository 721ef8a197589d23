"""Template matching: where a small image lies on a larger one, by the normalised correlation of their pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta.plan.sheet import Floats

Image = NDArray[Any]

# Windows whose squares about the mean sum up to less have nothing drawn in them.
LEAST_SPREAD = 1e-3
# Templates of so few pixels are filtered with faster than by Fourier transform.
MOST_FILTERED = 100


def respond(image: Image, template: Image) -> Image | None:
    """Scores of TM_CCOEFF_NORMED, -1 … 1; None where the template is too small or does not fit."""
    if min(template.shape[:2]) < 4 or any(t > i for t, i in zip(template.shape[:2], image.shape[:2], strict=True)):
        return None
    response = cv2.matchTemplate(image, template, cv2.TM_CCOEFF_NORMED)
    # Where nothing is drawn OpenCV divides by nearly nothing
    response[~(response <= 1.001)] = -1
    return response


class Spread:
    """How much the pixels of an image spread within a window at each place: what TM_CCOEFF_NORMED divides by.

    One window is kept, since templates of one size come one after another.
    """

    def __init__(self, image: Image) -> None:
        self.image = image
        self.kept: dict[tuple[int, ...], Image] = {}

    def within(self, shape: tuple[int, ...]) -> Image:
        """Root of the sum of squares about the mean, of the window from each place on; of the image's shape."""
        if shape not in self.kept:
            size, way = shape[::-1], {"anchor": (0, 0), "normalize": False, "borderType": cv2.BORDER_CONSTANT}
            total = cv2.boxFilter(self.image, cv2.CV_32F, size, **way)
            squares = cv2.sqrBoxFilter(self.image, cv2.CV_32F, size, **way)
            squares -= total * total / np.float32(shape[0] * shape[1])
            # Where nothing is drawn nothing is alike
            self.kept = {shape: np.sqrt(np.maximum(squares, LEAST_SPREAD))}
        return self.kept[shape]


def respond_everywhere(image: Image, template: Image, spread: Spread) -> Image | None:
    """As respond, for many templates on one large image of greys."""
    height, width = template.shape
    if min(height, width) < 4 or height > image.shape[0] or width > image.shape[1]:
        return None
    apart = template - template.mean()
    if template.size <= MOST_FILTERED:
        numerator = cv2.filter2D(image, cv2.CV_32F, apart, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
        numerator = numerator[: image.shape[0] - height + 1, : image.shape[1] - width + 1]
    else:
        numerator = cv2.matchTemplate(image, apart, cv2.TM_CCORR)
    rows, cols = numerator.shape
    return np.asarray(numerator / (spread.within(template.shape)[:rows, :cols] * np.float32(np.linalg.norm(apart))))


def find_peaks(response: Image, *, least: float, most: int) -> Floats:
    """Row and col of the best places of a response, shape (N, 2), at most so many."""
    highest = cv2.dilate(response, np.ones((5, 5), np.uint8))
    places = np.flatnonzero((response >= least) & (response >= highest))
    best = places[np.argsort(-response.take(places), kind="stable")[:most]]
    return np.column_stack(np.divmod(best, response.shape[1])).astype(float)
