"""A floor against the true floor: rooms, doors and labels, by all measures of this folder that fit two floors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import shapely

from pianta.evaluation.coverage import Scores, overlap_areas, score_layout
from pianta.evaluation.doors import DetectionScores, score_connections, score_doors, score_edges
from pianta.evaluation.semantics import pair_backward, pair_forward, semantic_accuracy
from pianta.floor import Floor
from pianta.labels import FCES, RC, LabelSet

# Rooms match if their IoU is above this.
MATCH_IOU = 0.5
# A door is right if its middle is at least within this of a true one, or within half its width: half a usual door.
LEAST_REACH = 0.45  # metres


@dataclass(frozen=True)
class FloorScores:
    """How well a floor agrees with the true one; shares are 0 … 1.

    Attributes
    ----------
    coverage
        Coverage by area: `a_fc`, `a_bc`, `precision`, `recall` (thesis, section 3.2), `mean_iou` and `f1`.
    rooms
        Rooms that match a true one, one to one, with an IoU above 0.5: `true`, `detected`, `correct`, `precision`,
        `recall`, `f1`.
    doors
        Doors and openings by the places of their middles, within half a width, at least 0.45 m; without entrances if
        the truth has none.
    pairs
        Pairs of true rooms that doors join; a room stands for the true room that it overlaps most.
    edges
        Pairs of rooms that doors join, right if both match true rooms that a true door joins.
    matches
        The id of the true room by the id of the room, for rooms that match.
    labels_forward, labels_backward
        The share of the rooms, and of the true rooms, whose label is that of the room that overlaps them most (section
        5.3), among true rooms that have a label; None if none has.
    building_type
        Whether the most probable type of the building is the true one; None if the truth has none.
    """

    coverage: Scores
    rooms: DetectionScores
    doors: DetectionScores
    pairs: DetectionScores
    edges: DetectionScores
    matches: Mapping[int, int]
    labels_forward: float | None
    labels_backward: float | None
    building_type: bool | None

    def as_json(self) -> dict[str, Any]:
        """List the scores as values that JSON can hold.

        Returns
        -------
        dict
            The attributes; `matches` as pairs of ids.
        """
        detections = {name: getattr(self, name) for name in ("rooms", "doors", "pairs", "edges")}
        counts = {
            name: {**asdict(each), "precision": each.precision, "recall": each.recall, "f1": each.f1}
            for name, each in detections.items()
        }
        return {
            "coverage": asdict(self.coverage),
            **counts,
            "matches": [list(pair) for pair in sorted(self.matches.items())],
            "labels_forward": self.labels_forward,
            "labels_backward": self.labels_backward,
            "building_type": self.building_type,
        }


def score_floor(floor: Floor, truth: Floor) -> FloorScores:
    """Score the rooms, doors and labels of a floor against the true floor.

    Parameters
    ----------
    floor
        The floor.
    truth
        The true floor in the same frame, such as one that a person has corrected.

    Returns
    -------
    FloorScores
        The scores.

    References
    ----------
    M. Luperto, PhD thesis, sections 3.2 (rooms) and 5.3 (labels).

    Examples
    --------
    >>> import pianta
    >>> truth, _ = pianta.make_world("corridor")
    >>> scores = pianta.score_floor(truth.merge(2, 3), truth)
    >>> scores.rooms.correct, scores.rooms.detected, scores.rooms.true
    (17, 18, 19)
    >>> round(scores.coverage.a_bc, 3), round(scores.coverage.a_fc, 3)
    (1.0, 0.957)
    """
    shapes, true_shapes = ([room.polygon for room in each] for each in (floor, truth))
    matches = match_floors(floor, truth)
    return FloorScores(
        coverage=score_layout(shapes, true_shapes),
        rooms=DetectionScores(len(truth), len(floor), len(matches)),
        doors=score_doors(floor, truth, least_reach=LEAST_REACH),
        pairs=score_connections(floor, truth),
        edges=score_edges(floor, truth, matches),
        matches=matches,
        labels_forward=_score_labels(floor, truth, forward=True),
        labels_backward=_score_labels(floor, truth, forward=False),
        building_type=floor.building_types[:1] == truth.building_types[:1] if truth.building_types else None,
    )


def match_floors(floor: Floor, truth: Floor) -> dict[int, int]:
    """The id of the true room by the id of each room, for the most pairs with an IoU above 0.5, one to one."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    if not (floor.rooms and truth.rooms):
        return {}
    shapes, true_shapes = (np.array([room.polygon for room in each], dtype=object) for each in (floor, truth))
    overlaps = overlap_areas(shapes, true_shapes)
    iou = overlaps / (shapely.area(shapes)[:, None] + shapely.area(true_shapes) - overlaps)
    partners = maximum_bipartite_matching(csr_array(iou > MATCH_IOU), perm_type="column")
    pairs = zip(floor.rooms, partners.tolist(), strict=True)
    return {room.id: truth.rooms[partner].id for room, partner in pairs if partner >= 0}


def _find_label_set(truth: Floor) -> str:
    """The coarse label set to which all true labels belong, in which labels are compared then; else ""."""
    labels = {room.label for room in truth if room.label}
    coarse = {LabelSet.R_C: {*map(str, RC)}, LabelSet.F_C_E_S: {*map(str, FCES)}}
    return next((str(label_set) for label_set, names in coarse.items() if labels <= names), "")


def _score_labels(floor: Floor, truth: Floor, *, forward: bool) -> float | None:
    """The share of the labels that agree, among true labels; None without true labels."""
    label_set = _find_label_set(truth)
    sides = [
        ([room.polygon for room in each], [room.labels.get(label_set) or room.label or "" for room in each])
        for each in (floor, truth)
    ]
    pairs = (pair_forward if forward else pair_backward)(*sides[0], *sides[1])
    counted = [pair for pair in pairs if pair.true != ""]
    return semantic_accuracy(counted) if any(room.label for room in truth) else None
