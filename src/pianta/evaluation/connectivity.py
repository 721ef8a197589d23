"""Which rooms a floor joins by doors, against the true floor (thesis, section 3.1: the topological graph)."""

from __future__ import annotations

from dataclasses import dataclass

from pianta.evaluation.coverage import forward_coverage
from pianta.floor import Floor

Pairs = set[frozenset[int]]


@dataclass(frozen=True)
class Connections:
    """Counts of pairs of true rooms: joined by a true door, by a found one, by both."""

    true: int
    found: int
    right: int

    @property
    def recall(self) -> float:
        """Share of the truly joined pairs that a found door joins."""
        return self._share(self.true)

    @property
    def precision(self) -> float:
        """Share of the pairs that a found door joins that are truly joined."""
        return self._share(self.found)

    def _share(self, whole: int) -> float:
        """Where one side joins no rooms every share is 0; where neither does, 1."""
        return self.right / whole if whole else float(self.found == self.true)


def score_connections(found: Floor, truth: Floor) -> Connections:
    """Pairs of rooms that the doors of a floor join, against those of the true floor; both in one frame.

    A found room stands for the true room that overlaps it most. Several doors of one pair count once, and entrances,
    doors inside one true room, and doors to a room that overlaps no true one do not count.
    """
    indices = forward_coverage([room.polygon for room in found.rooms], [room.polygon for room in truth.rooms])
    true_room = {
        room.id: truth.rooms[index].id for room, index in zip(found.rooms, indices, strict=True) if index is not None
    }
    found_pairs = _list_pairs(found, true_room)
    true_pairs = _list_pairs(truth, {room.id: room.id for room in truth.rooms})
    return Connections(len(true_pairs), len(found_pairs), len(found_pairs & true_pairs))


def _list_pairs(floor: Floor, room_of: dict[int, int]) -> Pairs:
    """Pairs of the rooms that those beside the doors stand for."""
    pairs = (frozenset(room_of.get(room, 0) for room in door.room_ids) for door in floor.doors)
    return {pair for pair in pairs if len(pair) == 2 and 0 not in pair}
