"""What the readers of drawn buildings share: outlines made valid, labels, and everything found wrong, told at once."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import shown

MAX_ROOMS = 1000
MAX_CORNERS, MAX_REPAIRED_CORNERS = 2000, 300
MAX_PORTALS = 20_000
MAX_OVERLAP = 0.1  # of the smaller room, as the data's table of defects counts


@dataclass(frozen=True)
class DrawnRoom:
    """A room of a file; its outline is in metres, and empty where the file has none that encloses anything."""

    number: int
    label: str | None
    outline: Polygon

    def __str__(self) -> str:
        return name_of_room(self.number, self.label)


@dataclass
class Findings:
    """What is wrong with a file: faults forbid a floor, repairs were made, remarks are defects that stay.

    Repairs are keys, because each door is listed in both its rooms and its defects count once.
    """

    faults: list[str] = field(default_factory=list)
    repairs: dict[str, None] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def raise_faults(self, file: Path) -> None:
        """Raises BuildingError, with every fault in one message, when there is one."""
        if self.faults:
            raise BuildingError(f"cannot read the building {shown(file)}: {join_faults(self.faults)}")

    def tell(self, file: Path) -> None:
        """One BuildingWarning for all that was repaired or stays, at the caller of the reader."""
        told = [f"was repaired: {join_faults(list(self.repairs))}"] if self.repairs else []
        told += [f"has defects that stay: {join_faults(self.remarks)}"] if self.remarks else []
        if told:
            warnings.warn(f"building {shown(file)} {', and '.join(told)}", BuildingWarning, stacklevel=3)


def name_of_room(number: int, label: str | None) -> str:
    """How messages call a room."""
    return f"room {number} ({label})"


def normalize_label(text: str | None) -> str | None:
    """A label in capitals with single blanks, None for an empty one; whether anybody knows it is not asked."""
    return " ".join((text or "").split()).upper() or None


def check_room_count(count: int, place: str, findings: Findings) -> None:
    """Find a floor without rooms, and one of so many that comparing all of them would take forever."""
    if not 1 <= count <= MAX_ROOMS:
        findings.faults.append(f"it has {count} rooms ({place}), give a floor of 1 to {MAX_ROOMS}")


def check_portal_count(count: int, findings: Findings) -> None:
    """Find a floor of so many portals that placing them all would take forever."""
    if count > MAX_PORTALS:
        findings.faults.append(f"it has {count} portals, give at most {MAX_PORTALS}")


def refuse_repeated(names: Iterable[str | None], what: str, findings: Findings) -> None:
    """Find names, or other ids as `what` calls them, that more than one room has; rooms without are passed by."""
    repeated = [(name, count) for name, count in Counter(names).items() if name and count > 1]
    findings.faults += [f"{count} rooms have the {what} {shown(name)}" for name, count in repeated]


def polygon_of_corners(corners: NDArray[np.float64], name: str, findings: Findings) -> Polygon:
    """The outline through corners, shape (N, 2), as a valid polygon.

    Of one that meets itself the largest part stays. One that encloses nothing is a fault, and so is one of more
    than MAX_CORNERS, or MAX_REPAIRED_CORNERS when it meets itself, because it may do so as often as the square of that;
    they come out empty.
    """
    if len(corners) > MAX_CORNERS:
        findings.faults.append(f"{name} has an outline of {len(corners)} corners, give at most {MAX_CORNERS}")
        return Polygon()
    outline = Polygon(corners) if len(corners) >= 3 else Polygon()
    if outline.is_valid and outline.area > 0:
        return outline
    if len(corners) > MAX_REPAIRED_CORNERS:
        text = f"{name} has an outline of {len(corners)} corners that meets itself"
        findings.faults.append(f"{text}, too many to repair it, draw it without crossings")
        return Polygon()
    parts = shapely.get_parts(shapely.make_valid(outline, method="structure", keep_collapsed=False))
    areas = shapely.area(parts)
    if not areas.any():
        findings.faults.append(f"{name} has an outline without area, give at least 3 corners")
        return Polygon()
    share = areas.max() / areas.sum()
    findings.repairs[f"the outline of {name} meets itself, kept the largest part ({share:.1%})"] = None
    largest: Polygon = parts[areas.argmax()]
    return largest


def remark_on_rooms(rooms: Sequence[DrawnRoom], *, door: float, findings: Findings) -> None:
    """Find rooms that overlap, and those that hold no square as wide as a door.

    Which of two rooms is drawn wrong cannot be known, so they stay.
    door: width of a door, metres.
    """
    outlines = np.array([room.outline for room in rooms])
    areas = shapely.area(outlines)
    tiny = [f"{rooms[index]} has {areas[index]:.2g} m²" for index in np.flatnonzero(areas < door**2).tolist()]
    findings.remarks += [f"{text}, less than a square as wide as a door" for text in tiny]
    pairs = STRtree(outlines).query(outlines, predicate="intersects")
    pairs = pairs[:, pairs[0] < pairs[1]]
    shared = shapely.area(shapely.intersection(*outlines[pairs])) / areas[pairs].min(axis=0)
    for (first, second), share in zip(pairs.T.tolist(), shared.tolist(), strict=True):
        if share > MAX_OVERLAP:
            text = f"{rooms[first]} and {rooms[second]} overlap by {share:.0%} of the smaller one"
            findings.remarks.append(text)


def remark_on_doors(floor: Floor, findings: Findings) -> None:
    """Find rooms without a door, and groups of rooms that no door joins; a floor of areas without any door has none."""
    if not floor.doors:
        return
    labels = {room.id: room.label for room in floor.rooms}
    groups = list(nx.connected_components(floor.graph()))
    alone = sorted(chain.from_iterable(group for group in groups if len(group) == 1))
    if alone:
        rooms = ", ".join(name_of_room(room_id, labels[room_id]) for room_id in alone)
        findings.remarks.append(f"no door leads to {rooms}")
    joined = len(groups) - len(alone)
    if joined > 1:
        findings.remarks.append(f"its rooms form {joined} groups without a door from one to another")
