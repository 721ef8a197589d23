"""What a floor is made of: rooms, doors, and the furniture in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from shapely import LineString, Polygon
from shapely.geometry.polygon import orient

from pianta.errors import FloorError

DOOR_WIDTH = 0.9  # metres, of a usual door; by definition the distance that scales the layout XMLs of the thesis
MAX_ROOM_NAME_LENGTH = 200  # characters
# Flags of rooms that are outside of the building, at the ground and above it
OUTSIDE_FLAG = "outside"
BALCONY_FLAG = "balcony"
# Flag of rooms that were not seen: a prediction has sampled them
PREDICTED_FLAG = "predicted"
MAX_GLOBAL_ID_LENGTH = 64  # characters; those of IFC have 22


@dataclass(frozen=True)
class Room:
    """A room: one connected polygon, possibly with holes.

    Parameters
    ----------
    id
        Positive, unique on its floor.
    polygon
        Metres in the map frame; the shell is stored counter-clockwise, holes clockwise.
    label
        The purpose of the room, its most specific label; None if unknown.
    labels
        Label set -> label, from the coarsest set to the finest; empty if unknown.
    label_probabilities
        Label set -> label -> probability, empty if unknown.
    partial
        Whether the room borders on unexplored space; the polygon is its explored part.
    predicted
        The predicted complete polygon of a partial room, metres in the map frame, stored like the polygon; None if
        unknown.
    confidence
        The expected IoU of the predicted polygon with the true one, 0 … 1; None if unknown.
    name
        The name of this room in the building, such as "204 French"; None if unknown.
    probability
        The probability that this is one true room, i.e. that a true room has an IoU of at least 0.6 with it; None if
        unknown.
    number
        What its owners call it on doors and in lists, such as "2.04", where a file has it apart from the name; None if
        unknown.
    global_id
        The identifier of the room in the file that it was read from, such as the GlobalId of an IFC; None without one.
    flag
        Why people may not count it as a room, such as "attic", "roof", "outside" or "predicted"; None for a usual room.

    Raises
    ------
    FloorError
        The id is not positive, a polygon is empty or invalid, a probability or the confidence is not in [0, 1], a room
        that is not partial is predicted, a confidence is given without a prediction, or the name, number or flag is
        not of 1 to 200 characters that can be printed, or the identifier not of 1 to 64.

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> room = pianta.Room(1, box(0, 0, 4, 3), "OFFICE", name="204")
    >>> room.label, room.polygon.area
    ('OFFICE', 12.0)
    """

    id: int
    polygon: Polygon
    label: str | None = None
    labels: Mapping[str, str] = field(default_factory=dict)
    label_probabilities: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    partial: bool = False
    predicted: Polygon | None = None
    confidence: float | None = None
    name: str | None = None
    probability: float | None = None
    number: str | None = None
    global_id: str | None = None
    flag: str | None = None

    def __post_init__(self) -> None:
        if self.id < 1:
            raise FloorError(f"room id is {self.id}, give a positive integer")
        _check_probability(self.probability, f"room {self.id}")
        if not isinstance(self.polygon, Polygon) or self.polygon.is_empty or not self.polygon.is_valid:
            raise FloorError(f"room {self.id} has no valid polygon, repair it with shapely.make_valid")
        object.__setattr__(self, "polygon", orient(self.polygon))
        self._check_prediction()
        for what, text in (("name", self.name), ("number", self.number), ("flag", self.flag)):
            check_text(text, f"room {self.id} has the {what}", MAX_ROOM_NAME_LENGTH)
        check_text(self.global_id, f"room {self.id} has the identifier", MAX_GLOBAL_ID_LENGTH)
        for label_set, probabilities in self.label_probabilities.items():
            if not isinstance(probabilities, Mapping):
                raise FloorError(f"room {self.id} has {probabilities!r} for {label_set!r}, give label -> probability")
            for label, probability in probabilities.items():
                if not 0 <= probability <= 1:
                    raise FloorError(f"room {self.id} is {label!r} with probability {probability}, give 0 to 1")
        object.__setattr__(self, "labels", dict(self.labels))
        object.__setattr__(self, "label_probabilities", copy_probabilities(self.label_probabilities))

    def _check_prediction(self) -> None:
        """Orient the predicted polygon; FloorError if it or the confidence is invalid, or the room is not partial."""
        if self.predicted is None and self.confidence is None:
            return
        if not self.partial:
            raise FloorError(f"room {self.id} is predicted and not partial, set partial or leave the prediction out")
        if not isinstance(self.predicted, Polygon) or self.predicted.is_empty or not self.predicted.is_valid:
            raise FloorError(f"room {self.id} has no valid predicted polygon, repair it with shapely.make_valid")
        if self.confidence is not None and not 0 <= self.confidence <= 1:
            raise FloorError(f"room {self.id} is predicted with confidence {self.confidence}, give 0 to 1")
        object.__setattr__(self, "predicted", orient(self.predicted))

    @property
    def title(self) -> str | None:
        """Its number and its name, as they stand on a plan; None if both are unknown."""
        return " ".join(dict.fromkeys(filter(None, (self.number, self.name)))) or None

    @property
    def label_probability(self) -> float | None:
        """The probability of its label, in the finest label set with one; None if unknown."""
        for label_set in [*reversed([*self.labels]), *reversed([*self.label_probabilities])]:
            probabilities = self.label_probabilities.get(label_set, {})
            if self.label is not None and self.label in probabilities:
                return probabilities[self.label]
        return None


@dataclass(frozen=True)
class Door:
    """A passage between two rooms, or from a room to what is no room: an entrance if that is outside.

    Parameters
    ----------
    rooms
        The ids of the two rooms, stored with the smaller one first; (3, None) is an entrance to room 3.
    line
        The passage from jamb to jamb, metres in the map frame.
    width
        Clear width, metres.
    kind
        "door", or "opening" if there is much less wall between the rooms than beside a door.
    probability
        The probability that there is a true door or opening; None if unknown.
    leads_out
        Whether a door of one room leads to the outside at the ground. False if it leads to a balcony, or to a part of
        the building that is no room; such a door is no entrance.
    global_id
        The identifier of the door in the file that it was read from, such as the GlobalId of an IFC; None without one.

    Raises
    ------
    FloorError
        The rooms are not two different ones or one and None, the width is negative, the probability is not in [0, 1],
        or the identifier is not of 1 to 64 characters that can be printed.

    Examples
    --------
    >>> import pianta
    >>> from shapely import LineString
    >>> door = pianta.Door((3, None), LineString([(0, 1), (0, 2)]), 1.0)
    >>> door.is_entrance, door.room_ids
    (True, (3,))
    """

    rooms: tuple[int, int | None]
    line: LineString
    width: float
    kind: Literal["door", "opening"] = "door"
    probability: float | None = None
    leads_out: bool = True
    global_id: str | None = None

    def __post_init__(self) -> None:
        ids = sorted(room_id for room_id in self.rooms if room_id is not None)
        if not ids:
            raise FloorError("a door leads from no room to no room, give one room or two")
        if len(ids) == 2 and ids[0] == ids[1]:
            raise FloorError(f"a door joins room {ids[0]} to itself, give two rooms")
        what = f"door between rooms {ids[0]} and {ids[1]}" if len(ids) == 2 else f"entrance to room {ids[0]}"
        if not self.width >= 0:
            raise FloorError(f"{what} has width {self.width}, give metres")
        _check_probability(self.probability, what)
        check_text(self.global_id, f"{what} has the identifier", MAX_GLOBAL_ID_LENGTH)
        object.__setattr__(self, "rooms", (ids[0], ids[1] if len(ids) == 2 else None))

    @property
    def room_ids(self) -> tuple[int, ...]:
        """The ids of the rooms that it leads to: two, or one."""
        first, second = self.rooms
        return (first,) if second is None else (first, second)

    @property
    def is_entrance(self) -> bool:
        """Whether it leads outside."""
        return self.rooms[1] is None and self.leads_out

    @property
    def joins_rooms(self) -> bool:
        """Whether it leads from a room to another one."""
        return self.rooms[1] is not None

    def renumber_rooms(self, new_ids: Mapping[int, int]) -> Door:
        """The same door between rooms that have new ids.

        Parameters
        ----------
        new_ids
            Old id -> new id, for each room of the door.

        Returns
        -------
        Door
            The door; its line, width and kind are the same.

        Raises
        ------
        KeyError
            A room of the door has no new id.
        """
        first, second = self.rooms
        return replace(self, rooms=(new_ids[first], None if second is None else new_ids[second]))


@dataclass(frozen=True)
class Furniture:
    """Something that stands in a room and is no wall: a piece of furniture, several that touch, a plant, a person.

    Parameters
    ----------
    polygon
        What the map shows of it, metres in the map frame; the shell is stored counter-clockwise, holes clockwise.
    probability
        The probability that it is furniture and no wall; None if unknown.
    kind
        What it is, such as "toilet", "bath", "sink", "hob" or "bed"; None if unknown.

    Raises
    ------
    FloorError
        The polygon is empty or invalid, the probability is not in [0, 1], or the kind is not of 1 to 200 characters
        that can be printed.

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> table = pianta.Furniture(box(1, 1, 2, 1.5), 0.9)
    >>> table.polygon.area
    0.5
    """

    polygon: Polygon
    probability: float | None = None
    kind: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.polygon, Polygon) or self.polygon.is_empty or not self.polygon.is_valid:
            raise FloorError("a piece of furniture has no valid polygon, repair it with shapely.make_valid")
        _check_probability(self.probability, "a piece of furniture")
        check_text(self.kind, "a piece of furniture has the kind", MAX_ROOM_NAME_LENGTH)
        object.__setattr__(self, "polygon", orient(self.polygon))


def check_text(text: str | None, what: str, longest: int) -> None:
    """Raise FloorError unless a text is None, or printable, not blank and not too long; what: subject and verb."""
    if text is None:
        return
    excerpt = f"{str(text)[:20]!r}"
    if not isinstance(text, str) or not text.strip() or len(text) > longest:
        raise FloorError(f"{what} {excerpt}, give 1 to {longest} characters or None")
    if not text.isprintable():
        raise FloorError(f"{what} {excerpt} with characters that cannot be printed, drop them")


def _check_probability(probability: float | None, what: str) -> None:
    """Raise FloorError for a probability that is not in [0, 1]; what: the noun of the message."""
    if probability is not None and not 0 <= probability <= 1:
        raise FloorError(f"{what} has probability {probability}, give 0 to 1")


def copy_probabilities(probabilities: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """A copy in types of Python, which JSON can hold."""
    return {
        label_set: {label: float(probability) for label, probability in by_label.items()}
        for label_set, by_label in probabilities.items()
    }
