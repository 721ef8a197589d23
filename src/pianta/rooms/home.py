"""Homes, by the names of their rooms and the fixtures in them: that a floor is one, and what its rooms are for.

The thesis knows schools and offices, where a hall, a study and a store are other rooms than in a home. Therefore homes
have words of their own, home_names.json, in the format of name_dictionary.json. Fixtures are furniture of a known kind,
as `read_plan` finds it on drawings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import shapely

from pianta.floor import Floor, Room
from pianta.labels import FCES, HOME, RC, LabelSet
from pianta.rooms.name_dictionary import (
    P_OTHER_FUZZY_MATCH,
    RoomNameDictionary,
    match_phrase,
    normalize_name,
    parse_dictionary,
    read_default_room_name_dictionary,
    room_name_prior,
)

# Labels that hardly any other building has; the others support them.
HOME_LABELS = frozenset({"LIVING ROOM", "DINING ROOM", "BEDROOM", "CHILD ROOM", "GUEST ROOM"})
SUPPORTING_LABELS = frozenset({"KITCHEN", "BATHROOM", "TOILET", "BALCONY", "LAUNDRY", "GARAGE", "TERRACE", "WARDROBE"})
# Fixtures that rooms of other buildings hardly have: offices have toilets and sinks, too.
HOME_FIXTURES = frozenset({"bath", "hob", "bed"})
# What a room without a name is for, by the first of these sets that stands in it. Chosen by hand: the probabilities are
# for cooking in the living room, and for toilets that are counted as bathrooms.
FIXTURE_LABELS: tuple[tuple[frozenset[str], Mapping[str, float]], ...] = (
    (frozenset({"bath"}), {"BATHROOM": 0.95, "TOILET": 0.05}),
    (frozenset({"toilet"}), {"BATHROOM": 0.5, "TOILET": 0.5}),
    (frozenset({"hob"}), {"KITCHEN": 0.8, "LIVING ROOM": 0.2}),
    (frozenset({"bed"}), {"BEDROOM": 0.95, "LIVING ROOM": 0.05}),
)
MAX_HOME_ROOMS = 15  # of a floor whose fixtures speak for a home: on larger ones other furniture is taken for some
SMALL_TOILET = 2.5  # m²: a smaller room with a toilet has hardly a bath
OPEN_KITCHEN = 18.0  # m²: a larger room with a hob is also for living
# Chosen by hand:
P_NAME_ELSEWHERE = 0.3  # of another building to have a room with a name of a home, for each such room
SUPPORTING_WEIGHT = 0.5  # of a supporting room, in rooms of a home
MIN_PROBABILITY = 0.8  # of a home
MAX_OTHER_SHARE = 0.4  # of the named rooms that have names of schools and offices, and none of homes


@dataclass(frozen=True, eq=False)
class HomeEvidence:
    """What the names of a floor's rooms, and the fixtures in them, say if it is a home.

    labels: room id -> probabilities of the labels of HOME, for the rooms whose names have a word of a home, and for
    rooms without a name that have fixtures. certain: ids of those with names whose words are not merely similar, and
    most of the name. others: ids of rooms with words of other buildings alone. fixtures: kinds of HOME_FIXTURES.
    """

    labels: Mapping[int, Mapping[str, float]]
    certain: frozenset[int]
    others: frozenset[int]
    fixtures: frozenset[str] = frozenset()

    @cached_property
    def probability(self) -> float:
        """Probability that the floor is a home; 0 if too little speaks for it."""
        best = [max(self.labels[room], key=lambda name: self.labels[room][name]) for room in self.certain]
        own = sum(label in HOME_LABELS for label in best) + len(self.fixtures)
        supporting = sum(label in SUPPORTING_LABELS for label in best)
        probability = 1 - P_NAME_ELSEWHERE ** (own + SUPPORTING_WEIGHT * min(supporting, own))
        named = len(self.certain) + len(self.others)
        # An office building has lounges and kitchens, too
        offices = best.count("OFFICE")
        is_home = own > offices and len(self.others) <= MAX_OTHER_SHARE * named and probability >= MIN_PROBABILITY
        return probability if is_home else 0.0


def join_home_evidence(storeys: Sequence[HomeEvidence]) -> HomeEvidence:
    """What names and fixtures on all storeys of a building say together; rooms are numbered anew."""
    labels: dict[int, Mapping[str, float]] = {}
    certain: set[int] = set()
    others: set[int] = set()
    for storey in storeys:
        ids = sorted({*storey.labels, *storey.others})
        new_ids = {room: number for number, room in enumerate(ids, start=len(labels) + len(others) + 1)}
        labels |= {new_ids[room]: probabilities for room, probabilities in storey.labels.items()}
        certain |= {new_ids[room] for room in storey.certain}
        others |= {new_ids[room] for room in storey.others}
    fixtures = frozenset[str]().union(*(storey.fixtures for storey in storeys))
    return HomeEvidence(labels, frozenset(certain), frozenset(others), fixtures)


def find_home_evidence(floor: Floor, words: RoomNameDictionary | None = None) -> HomeEvidence:
    """What names and fixtures say about a home; words: the user's, which count before those of pianta."""
    home = read_home_dictionary()
    elsewhere = words or read_default_room_name_dictionary()
    labels, certain, others = _read_fixtures(floor), set(), set()
    for room in floor:
        match = match_phrase(room.name, home) if room.name else None
        if match is not None and (prior := room_name_prior(room.name or "", HOME, home)):
            labels[room.id] = prior
            if match.p_other < P_OTHER_FUZZY_MATCH and _is_most_of(match.phrase, room.name or ""):
                certain.add(room.id)
        elif room.name and match_phrase(room.name, elsewhere) is not None:
            others.add(room.id)
    kinds = HOME_FIXTURES & {piece.kind for piece in floor.furniture} if len(floor) <= MAX_HOME_ROOMS else set()
    return HomeEvidence(labels, frozenset(certain), frozenset(others), frozenset(filter(None, kinds)))


def _read_fixtures(floor: Floor) -> dict[int, Mapping[str, float]]:
    """The probabilities of the labels of rooms without a name that have fixtures."""
    pieces = [piece for piece in floor.furniture if piece.kind]
    middles = shapely.centroid(np.array([piece.polygon for piece in pieces], object))
    labels: dict[int, Mapping[str, float]] = {}
    for room in floor:
        if room.name or not pieces:
            continue
        kinds = {
            piece.kind for piece, is_in in zip(pieces, shapely.within(middles, room.polygon), strict=True) if is_in
        }
        likely = next((probabilities for some, probabilities in FIXTURE_LABELS if some <= kinds), None)
        if likely is not None and "TOILET" in likely and "bath" not in kinds and room.polygon.area < SMALL_TOILET:
            likely = {"TOILET": 0.9, "BATHROOM": 0.1}
        if likely is not None and "KITCHEN" in likely and room.polygon.area > OPEN_KITCHEN:
            likely = {"KITCHEN": 0.5, "LIVING ROOM": 0.5}
        if likely is not None:
            labels[room.id] = likely
    return labels


def _is_most_of(phrase: str, name: str) -> bool:
    """Whether a phrase is at least half of the words of a name: a primary sodium tank is no primary bedroom."""
    words = [word for word in normalize_name(name).split() if sum(map(str.isalpha, word)) > 1]
    return 2 * len(phrase.split()) >= len(words)


def label_home(floor: Floor, evidence: HomeEvidence) -> Floor:
    """The floor with labels of a home for the rooms whose names or fixtures give them; the others stay as they are.

    Rooms with a label that a person has given keep it.
    """
    from pianta.rooms.model import has_manual_label

    return replace(
        floor,
        rooms=tuple(
            _label_room(room, evidence.labels[room.id])
            if room.id in evidence.labels and not has_manual_label(room)
            else room
            for room in floor.rooms
        ),
    )


def _label_room(room: Room, probabilities: Mapping[str, float]) -> Room:
    """The room with its labels from the coarsest set down, by the probabilities of the labels of HOME."""
    label = max(probabilities, key=lambda name: probabilities[name])
    functions = dict.fromkeys(map(str, FCES), 0.0)
    for name, probability in probabilities.items():
        functions[str(HOME.by_name[name].function_in())] += probability
    corridor = functions[str(FCES.CONNECTION)]
    own = HOME.by_name[label]
    return replace(
        room,
        label=label,
        labels={
            str(LabelSet.R_C): str(own.room_or_corridor()),
            str(LabelSet.F_C_E_S): str(own.function_in()),
            HOME.building_type: label,
        },
        label_probabilities={
            str(LabelSet.R_C): {str(RC.ROOM): 1 - corridor, str(RC.CORRIDOR): corridor},
            str(LabelSet.F_C_E_S): functions,
            HOME.building_type: dict(probabilities),
        },
    )


@cache
def read_home_dictionary() -> RoomNameDictionary:
    """The words of the rooms of homes that come with pianta."""
    return parse_dictionary(Path(__file__).with_name("home_names.json").read_bytes())
