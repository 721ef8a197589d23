"""Evidence that is made by hand, for the tests of the method `structure`."""

import numpy as np

from pianta._types import Mask
from pianta.layout.structure.evidence import FLOOR, OFFSETS, Evidence, Probabilities


def make_classes(shape: tuple[int, int]) -> Probabilities:
    """Class probabilities, shape (5, h, w): floor everywhere."""
    classes = np.zeros((5, *shape), np.float32)
    classes[FLOOR] = 1.0
    return classes


def set_class(classes: Probabilities, cells: Mask, **probabilities: float) -> None:
    """Set the class probabilities of some cells, by the names of the classes in small letters; the others are 0."""
    names = ("outside", "floor", "wall", "door", "furniture")
    for number, name in enumerate(names):
        classes[number][cells] = probabilities.get(name, 0.0)


def make_evidence(classes: Probabilities, *, affinity: float = 0.95) -> Evidence:
    """Evidence with the same affinity everywhere, on a working grid with the cells of the network."""
    height, width = classes.shape[1:]
    affinities = np.full((len(OFFSETS), height, width), affinity, np.float32)
    return Evidence(classes, affinities, np.eye(2, 3), (height, width))
