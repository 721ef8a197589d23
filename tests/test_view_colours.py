"""Colours of the page, as people without cones of one kind see them."""

from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.color import deltaE_ciede2000, rgb2lab

from pianta.labels import FCES_COLORS
from pianta.plot.styles import FUNCTION_COLORS, NEUTRAL_COLOR

# What linear red, green and blue become without cones of one kind; Machado, Oliveira and Fernandes 2009, severity 1.0.
SIGHTS = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
# What is below rooms in light and in dark: the free space of a map, and what is unknown.
GROUNDS = {"light": "#ffffff", "light, unknown": "#cdcdcd", "dark": "#000000", "dark, unknown": "#282828"}
# As in room_canvas.js.
OPACITY = 0.62
STATIC = Path(__file__).parents[1] / "src" / "pianta" / "view" / "static"


def channels_of(color: str) -> NDArray[np.float64]:
    return np.array([*bytes.fromhex(color[1:])]) / 255


def simulate(color: str, ground: str, sight: str) -> NDArray[np.float64]:
    """CIELAB of a colour over a ground, by the sight of a person."""
    mixed = OPACITY * channels_of(color) + (1 - OPACITY) * channels_of(ground)
    linear = np.where(mixed <= 0.04045, mixed / 12.92, ((mixed + 0.055) / 1.055) ** 2.4)
    changed = np.clip(np.asarray(SIGHTS[sight]) @ linear, 0, 1)
    encoded = np.where(changed <= 0.0031308, 12.92 * changed, 1.055 * changed ** (1 / 2.4) - 0.055)
    lab: NDArray[np.float64] = rgb2lab(encoded)
    return lab


def least_difference(colors: Iterable[str], ground: str, sight: str) -> float:
    """CIEDE2000 of the two colours that are most alike."""
    labs = [simulate(color, ground, sight) for color in colors]
    return min(float(deltaE_ciede2000(first, second)) for first, second in combinations(labs, 2))


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("ground", GROUNDS.values(), ids=GROUNDS)
def test_functions_differ_in_colour_for_everybody(ground, sight):
    # The least of all is 11.2: a functional room and one without a label, without red cones, in light.
    assert least_difference([*FUNCTION_COLORS.values(), NEUTRAL_COLOR], ground, sight) > 11


def test_the_simulation_finds_colours_that_are_alike():
    # The colours of the thesis have a teal and a grey that look alike without red cones.
    assert least_difference(FCES_COLORS.values(), "#ffffff", "protanopia") < 5
    assert least_difference(FCES_COLORS.values(), "#ffffff", "normal") > 11


def test_grey_has_no_colour_for_anybody():
    for sight in SIGHTS:
        assert simulate("#808080", "#808080", sight)[1:] == pytest.approx([0, 0], abs=0.1)


def test_the_opacity_is_that_of_the_page():
    assert f"const OPACITY = {OPACITY};" in (STATIC / "room_canvas.js").read_text()
