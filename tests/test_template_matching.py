"""Templates are found where they lie, and blank paper matches nothing."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.plan.symbols.template_matching import LargeImage, correlate, find_peaks

CROSS = np.zeros((9, 7), np.float32)
CROSS[4, :] = CROSS[:, 3] = 1
LARGE = np.kron(CROSS, np.ones((2, 2), np.float32))


def draw(template: np.ndarray, *corners: tuple[int, int]) -> np.ndarray:
    """Black paper of 60 × 80 with a template at corners, row and col."""
    image = np.zeros((60, 80), np.float32)
    for row, col in corners:
        image[row : row + template.shape[0], col : col + template.shape[1]] = template
    return image


@pytest.mark.parametrize("template", [CROSS, LARGE])
def test_a_template_is_found_at_its_corners_and_nowhere_else(template):
    image = draw(template, (5, 8), (30, 50))
    response = LargeImage(image).correlate(template)
    assert response is not None
    assert response.shape == (60 - template.shape[0] + 1, 80 - template.shape[1] + 1)
    assert response[[5, 30], [8, 50]] == pytest.approx(1, abs=0.01)
    assert sorted(map(tuple, find_peaks(response, least=0.9, most=5).tolist())) == [(5, 8), (30, 50)]


def test_blank_paper_matches_nothing():
    image = draw(CROSS, (5, 8))
    response = LargeImage(image).correlate(CROSS)
    assert response is not None
    assert np.abs(response[30:, 30:]).max() < 0.01


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_on_drawn_paper_the_scores_are_those_of_opencv(seed):
    image = np.random.default_rng(seed).random((30, 40)).astype(np.float32)
    for template in (CROSS, LARGE):
        response = LargeImage(image).correlate(template)
        expected = cv2.matchTemplate(image, template, cv2.TM_CCOEFF_NORMED)
        assert response == pytest.approx(expected, abs=0.01)
        assert correlate(image, template) == pytest.approx(expected)


@pytest.mark.parametrize("shape", [(3, 9), (61, 9), (9, 81)])
def test_a_template_that_is_too_small_or_does_not_fit_is_not_matched(shape):
    image = draw(CROSS, (5, 8))
    template = np.eye(*shape, dtype=np.float32)
    assert correlate(image, template) is None
    assert LargeImage(image).correlate(template) is None


def test_a_blank_template_is_not_matched():
    assert LargeImage(draw(CROSS, (5, 8))).correlate(np.ones((9, 7), np.float32)) is None


def test_the_best_peaks_come_first_and_are_limited():
    response = np.zeros((20, 60), np.float32)
    response[10, [5, 25, 45]] = 0.7, 0.9, 0.8
    assert find_peaks(response, least=0.5, most=2).tolist() == [[10, 25], [10, 45]]
    assert find_peaks(response, least=0.75, most=5).tolist() == [[10, 25], [10, 45]]
