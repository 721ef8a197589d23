"""What a floor is like as one object: numbers about how it is made up, and the graph of its rooms; free of scale.

Section 6.2.2 of the thesis gives kLog the labels, the geometry and the doors of all rooms of a floor. Here these become
two views of it: features that tell of all rooms together, and a graph whose local patterns NSPDK compares.
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

CONNECTING = (str(RC.CORRIDOR), str(FCES.CONNECTION))
# Means of these features of rooms: over all rooms, and over the corridors of a floor.
OF_ROOMS = ("facade", "facade_sides", "wall_neighbours", "door_span", "leaves", "betweenness", "size_to_commonest")
OF_CORRIDORS = ("elongation", "rectangularity", "neighbour_facade_mean")
OF_SIZES = ("rooms", "largest_share", "concentration")
OF_LABELS = ("share", "area_share", "size")
# From these shares of its outline at the facade on, a room has windows to one side, or to more.
ONE_SIDE, MORE_SIDES = 0.02, 0.3
# Logarithms of shares begin here.
LEAST_SHARE = 1e-3
# Numbers are rounded, for a model to be the same when it comes back from its file, which is to be small.
DECIMALS = 5


@dataclass(frozen=True, eq=False)
class BuildingDescription:
    """A floor as one object.

    source: the file of the floor.
    features: what `name_features` lists for the label set.
    labels: of each room, in that set. sizes: area over that of the median room, logarithms. sides: 0 for a room that is
    not at the facade, 1, or 2 for one with windows to several sides. All have one entry for each of the n rooms.
    doors: pairs of rooms that a door or opening joins, by their places, the smaller one first.
    """

    source: str
    features: Floats
    labels: tuple[str, ...]
    sizes: tuple[float, ...]
    sides: tuple[int, ...]
    doors: tuple[tuple[int, int], ...]

    def name_rooms(self, bounds: Floats) -> tuple[str, ...]:
        """What tells rooms apart in patterns: label, size between bounds, and sides at the facade.

        bounds: of sizes, ascending.
        """
        classes = np.searchsorted(bounds, self.sizes).tolist()
        rooms = zip(self.labels, classes, self.sides, strict=True)
        return tuple(f"{label} size {size} sides {sides}" for label, size, sides in rooms)


def name_features(label_set: LabelSet) -> tuple[str, ...]:
    """The names of the features of a description, in order.

    Numbers of rooms, shares and sizes are logarithms; a size compares the medians of the rooms of a label and of all.
    """
    kinds = LABELS[label_set][1:] if label_set is LabelSet.R_C else LABELS[label_set]
    return (
        *(f"mean {name}" for name in OF_ROOMS),
        *(f"corridors' {name}" for name in OF_CORRIDORS),
        *OF_SIZES,
        *(f"{kind} {of}" for kind in kinds for of in OF_LABELS),
    )


def describe_building(floor: Floor, label_set: LabelSet) -> BuildingDescription:
    """Describe a floor whose rooms have labels in a label set, R/C or F/C/E/S.

    Nothing in it depends on scale, turn, shift or the order of rooms, but for the order of its own entries.
    Raises LabelError for rooms without such a label, and for a floor without rooms.
    """
    labels = list_labels(floor.rooms, label_set)
    if not labels:
        raise LabelError("the floor has no rooms, nothing can be said of the building")
    context = describe_rooms(floor)
    columns = dict(zip(CONTEXT_FEATURES, context.features.T, strict=True))
    windows = columns["facade"]
    pairs = np.argwhere(np.triu(context.doors) > 0)
    return BuildingDescription(
        source=floor.source,
        features=_measure(context, np.array(labels), label_set),
        labels=tuple(labels),
        sizes=tuple(columns["size_to_median"].round(DECIMALS).tolist()),
        sides=tuple(((windows > ONE_SIDE).astype(int) + (windows > MORE_SIDES)).tolist()),
        doors=tuple((int(one), int(other)) for one, other in pairs),
    )


def _measure(context: RoomContext, labels: NDArray[np.str_], label_set: LabelSet) -> Floats:
    columns = dict(zip(CONTEXT_FEATURES, context.features.T, strict=True))
    shares = context.area / context.area.sum()
    corridors = np.isin(labels, CONNECTING)
    measured = [*(columns[name].mean() for name in OF_ROOMS)]
    # A floor without corridors is as if all of its rooms were some.
    measured += [columns[name][corridors if corridors.any() else slice(None)].mean() for name in OF_CORRIDORS]
    measured += [np.log(len(labels)), np.log(shares.max()), np.log((shares**2).sum())]
    for kind in LABELS[label_set][1:] if label_set is LabelSet.R_C else LABELS[label_set]:
        of_kind = labels == kind
        size = np.median(context.area[of_kind]) / np.median(context.area) if of_kind.any() else 1.0
        measured += [of_kind.mean(), np.log(shares[of_kind].sum() + LEAST_SHARE), np.log(size)]
    return np.array(measured).round(DECIMALS)
