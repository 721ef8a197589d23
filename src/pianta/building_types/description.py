"""A floor as one object: numbers about its composition, and the graph of its rooms; both independent of scale.

Section 6.2.2 of the thesis gives kLog the labels, the geometry and the doors of all rooms of a floor. Here these become
features of the whole floor, and a graph whose local patterns NSPDK compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import LabelError
from pianta.floor import Floor
from pianta.labels import FCES, RC, LabelSet
from pianta.rooms.completion import LABELS, list_labels
from pianta.rooms.features import CONTEXT_FEATURES, RoomContext, describe_rooms

CONNECTING_LABELS = (str(RC.CORRIDOR), str(FCES.CONNECTION))
# Room features whose mean over all rooms of a floor is a feature of the floor; over its corridors.
ROOM_MEANS = ("facade", "facade_sides", "wall_neighbours", "door_span", "leaves", "betweenness", "size_to_commonest")
CORRIDOR_MEANS = ("elongation", "rectangularity", "neighbour_facade_mean")
SIZE_FEATURES = ("rooms", "largest_share", "concentration")
LABEL_FEATURES = ("share", "area_share", "size")
# Shares of the outline at the façade: above the first a room has windows to one side, above the second to more.
# Chosen by hand.
ONE_SIDE_SHARE = 0.02
SEVERAL_SIDES_SHARE = 0.3
# Added to shares of area before the logarithm, so that 0 has one.
MIN_SHARE = 1e-3
# Decimals of all numbers, so that a model stays the same when it is read from its (small) file.
DECIMALS = 5


@dataclass(frozen=True, eq=False)
class BuildingDescription:
    """What BuildingKernel compares of a floor: features of the whole floor, and the graph of its rooms.

    source: the file of the floor.
    features: those of `name_features` for the label set.
    labels: of the n rooms, in the label set, shape (n,).
    sizes: logarithm of the area over that of the median room, shape (n,).
    sides: number of sides with windows: 0, 1, or 2 for several, shape (n,).
    doors: pairs of rooms (indices, the smaller first) that a door or opening joins.
    """

    source: str
    features: Floats
    labels: tuple[str, ...]
    sizes: tuple[float, ...]
    sides: tuple[int, ...]
    doors: tuple[tuple[int, int], ...]

    def name_rooms(self, bounds: Floats) -> tuple[str, ...]:
        """The node label of each room in the graph: its label, size class and number of sides with windows.

        bounds: between size classes, ascending, in the unit of `sizes`.
        """
        classes = np.searchsorted(bounds, self.sizes).tolist()
        rooms = zip(self.labels, classes, self.sides, strict=True)
        return tuple(f"{label} size {size} sides {sides}" for label, size, sides in rooms)


def list_described_labels(label_set: LabelSet) -> tuple[str, ...]:
    """The labels that have features of their own; of R/C only one, as the other follows from it."""
    return LABELS[label_set][1:] if label_set is LabelSet.R_C else LABELS[label_set]


def name_features(label_set: LabelSet) -> tuple[str, ...]:
    """The names of the features of a description, in order.

    Numbers of rooms, shares and sizes are logarithms; a size compares the median room of a label with that of all.
    """
    return (
        *(f"mean {name}" for name in ROOM_MEANS),
        *(f"corridors' {name}" for name in CORRIDOR_MEANS),
        *SIZE_FEATURES,
        *(f"{label} {feature}" for label in list_described_labels(label_set) for feature in LABEL_FEATURES),
    )


def describe_building(floor: Floor, label_set: LabelSet) -> BuildingDescription:
    """Describe a floor by what BuildingKernel compares: features of the whole floor, and the graph of its rooms.

    label_set: R/C or F/C/E/S; every room has a label of it. The description does not depend on scale, rotation and
    translation of the floor; the order of rooms gives only the order of its entries.
    Raises LabelError for rooms without a label of the set, and for a floor without rooms.
    """
    labels = list_labels(floor.rooms, label_set)
    if not labels:
        raise LabelError("the floor has no rooms, so its building type cannot be predicted")
    context = describe_rooms(floor)
    columns = dict(zip(CONTEXT_FEATURES, context.features.T, strict=True))
    facade = columns["facade"]
    sides = (facade > ONE_SIDE_SHARE).astype(int) + (facade > SEVERAL_SIDES_SHARE)
    return BuildingDescription(
        source=floor.source,
        features=_measure_features(context, columns, np.array(labels), label_set),
        labels=tuple(labels),
        sizes=tuple(columns["size_to_median"].round(DECIMALS).tolist()),
        sides=tuple(sides.tolist()),
        doors=tuple((int(one), int(other)) for one, other in np.argwhere(np.triu(context.doors) > 0)),
    )


def _measure_features(
    context: RoomContext, columns: dict[str, Floats], labels: NDArray[np.str_], label_set: LabelSet
) -> Floats:
    """The features of `name_features`, in their order; columns: features of the rooms by name, each of shape (n,)."""
    shares = context.area / context.area.sum()
    corridors = np.isin(labels, CONNECTING_LABELS)
    features = [columns[name].mean() for name in ROOM_MEANS]
    # On a floor without corridors, all rooms count as corridors.
    features += [columns[name][corridors if corridors.any() else slice(None)].mean() for name in CORRIDOR_MEANS]
    features += [np.log(len(labels)), np.log(shares.max()), np.log((shares**2).sum())]
    for label in list_described_labels(label_set):
        is_label = labels == label
        size = np.median(context.area[is_label]) / np.median(context.area) if is_label.any() else 1.0
        features += [is_label.mean(), np.log(shares[is_label].sum() + MIN_SHARE), np.log(size)]
    return np.array(features).round(DECIMALS)
