"""Interpretations: the facts that hold on one floor, and the signatures that say what facts there are.

The entity/relationship data of kLog (thesis, section 6.1.2; Frasconi et al., 2014). An entity is an identifier; a fact
relates entities and properties, and what no fact says does not hold.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Integral, Real
from sys import float_info

from pianta.errors import RelationError

SELF, PROPERTY = "self", "property"
Value = str | int | float

MAX_FAULTS_TOLD = 10
MAX_TEXT_SHOWN = 100
_PLAIN_ATOM = re.compile(r"[a-z][A-Za-z0-9_]*")
_NO_TEXT = re.compile("[\ud800-\udfff]")
_ESCAPES = str.maketrans({"\\": r"\\", "'": r"\'", "\n": r"\n", "\t": r"\t", "\r": r"\r"})


@dataclass(frozen=True)
class Argument:
    """An argument of a signature.

    kind: "self", the identifier of the entity that the fact declares; "property", an atom or a number; or the name of
        the signature whose entity it names.
    Raises RelationError when the name or the kind is no atom of small letters.
    """

    name: str
    kind: str = PROPERTY

    def __post_init__(self) -> None:
        _check_names(f"argument {self.name!r}", self.name, self.kind)

    @property
    def is_entity(self) -> bool:
        """Whether it names an entity that another fact declares."""
        return self.kind not in (SELF, PROPERTY)


@dataclass(frozen=True)
class Signature:
    """What the facts of one relation are like; as text it is the declaration of Listing 6.1.

    intensional: the facts follow from others, they are not what was observed.
    unordered: the entities that a fact relates are interchangeable, connected(a, b) and connected(b, a) are one fact.
    Raises RelationError for names that are no atoms, no arguments or repeated ones, two that are "self", and unordered
    without two entities of one kind.
    """

    name: str
    arguments: tuple[Argument, ...]
    intensional: bool = field(default=False, kw_only=True)
    unordered: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "arguments", tuple(self.arguments))
        what = f"signature {self.name!r}"
        _check_names(what, self.name)
        names = [argument.name for argument in self.arguments]
        kinds = [argument.kind for argument in self.arguments]
        related = [kind for kind in kinds if kind not in (SELF, PROPERTY)]
        if not names or len(set(names)) < len(names):
            raise RelationError(f"{what} has the arguments {', '.join(names) or 'none'}, give one or more, each once")
        if kinds.count(SELF) > 1:
            raise RelationError(f"{what} has more than one argument of kind self, an entity has one identifier")
        if self.unordered and (len(related) < 2 or len(set(related)) > 1):
            raise RelationError(f"{what} is unordered, give it two or more arguments of one kind of entity")

    @cached_property
    def self_place(self) -> int | None:
        """The place of the identifier among the arguments; None when the facts declare no entity."""
        return next((place for place, argument in enumerate(self.arguments) if argument.kind == SELF), None)

    def standard_arguments(self, arguments: Sequence[Value]) -> tuple[Value, ...]:
        """The arguments of a fact, equal for all that say the same: the entities sorted when it is unordered."""
        if not self.unordered:
            return tuple(arguments)
        entities = iter(
            sorted((value for value, of in zip(arguments, self.arguments, strict=True) if of.is_entity), key=write_term)
        )
        return tuple(
            next(entities) if of.is_entity else value for value, of in zip(arguments, self.arguments, strict=True)
        )

    def __str__(self) -> str:
        return self.declare()

    def declare(self, *, role: str = "") -> str:
        """The declaration; role: given to all entities that are interchangeable, as kLog tells that they are."""
        level = "intensional" if self.intensional else "extensional"
        of_entities = f"@{role}" if role and self.unordered else ""
        arguments = [
            f"{argument.name}{of_entities * argument.is_entity}::{argument.kind}" for argument in self.arguments
        ]
        return f"signature {self.name}({', '.join(arguments)})::{level}."


@dataclass(frozen=True)
class Fact:
    """A ground atom; as text it is Prolog, `area(s001,100)`.

    arguments: atoms (str) and numbers; numbers of numpy become those of Python.
    Raises RelationError for anything else.
    """

    relation: str
    arguments: tuple[Value, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.relation, str) or _NO_TEXT.search(self.relation):
            raise RelationError(f"a fact is of the relation {self.relation!r}, give text")
        arguments = tuple(_standard_value(value, self.relation) for value in self.arguments)
        object.__setattr__(self, "arguments", arguments)

    def __str__(self) -> str:
        return f"{write_term(self.relation)}({','.join(map(write_term, self.arguments))})"


@dataclass(frozen=True)
class Interpretation:
    """The facts that hold on a floor, in the order in which they were told; one told twice is here twice."""

    name: str
    facts: tuple[Fact, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "facts", tuple(self.facts))
        if not isinstance(self.name, str) or _NO_TEXT.search(self.name):
            raise RelationError(f"an interpretation has the name {self.name!r}, give text")

    def facts_of(self, relation: str) -> tuple[Fact, ...]:
        """The facts of a relation, none when nobody told any."""
        return tuple(fact for fact in self.facts if fact.relation == relation)

    def entities(self, signature: Signature) -> tuple[Value, ...]:
        """The identifiers that the facts of a signature declare."""
        place = signature.self_place
        if place is None:
            return ()
        return tuple(fact.arguments[place] for fact in self.facts_of(signature.name))

    def without(self, *relations: str) -> Interpretation:
        """The interpretation without the facts of some relations, such as the target of learning."""
        return Interpretation(self.name, tuple(fact for fact in self.facts if fact.relation not in relations))


def write_term(value: Value) -> str:
    """A value as Prolog writes it: atoms in quotes where they need them, numbers as short as they can be exact."""
    if not isinstance(value, str):
        return repr(value)
    if _PLAIN_ATOM.fullmatch(value):
        return value
    escaped = value.translate(_ESCAPES)
    return "'" + "".join(c if c.isprintable() else f"\\x{ord(c):x}\\" for c in escaped) + "'"


def by_name(signatures: Iterable[Signature]) -> Mapping[str, Signature]:
    """Signatures by their names.

    Raises RelationError that lists the names that occur with more than one meaning.
    """
    found: dict[str, Signature] = {}
    repeated = {of.name for of in signatures if found.setdefault(of.name, of) != of}
    if repeated:
        raise RelationError(f"signatures {', '.join(sorted(repeated))} occur with two meanings, rename or drop one")
    return found


def find_faults(interpretation: Interpretation, signatures: Iterable[Signature]) -> list[str]:
    """What contradicts the signatures, in the order of the facts; empty when nothing does.

    Unknown relations and entities that no fact declares, each once; wrong numbers of arguments; entities declared
    twice; identifiers that are no atoms or whole numbers; numbers that are not finite.
    """
    return [fault for _, fault in locate_faults(interpretation, signatures)]


def check_interpretation(interpretation: Interpretation, signatures: Iterable[Signature]) -> None:
    """Raise RelationError, with the faults in one line, when an interpretation contradicts the signatures."""
    faults = find_faults(interpretation, signatures)
    if faults:
        told = "; ".join(faults[:MAX_FAULTS_TOLD])
        more = len(faults) - MAX_FAULTS_TOLD
        told += f"; and {more} more" if more > 0 else ""
        raise RelationError(f"interpretation {_shown(interpretation.name)}: {told}")


def locate_faults(
    interpretation: Interpretation, signatures: Iterable[Signature], *, known: Set[Value] = frozenset()
) -> Iterator[tuple[int, str]]:
    """The faults of find_faults, each with the place of its fact.

    known: entities to take for declared, whatever their kind.
    """
    named = by_name(signatures)
    declared = _declare_entities(interpretation, named)
    told: set[tuple[str, Value]] = set()
    for place, fact in enumerate(interpretation.facts):
        signature = named.get(fact.relation)
        if signature is None:
            if ("", fact.relation) not in told:
                yield place, f"{_shown(fact)} is of a relation without a signature, declare it or leave it out"
            told.add(("", fact.relation))
            continue
        if len(signature.arguments) != len(fact.arguments):
            number, expected = len(fact.arguments), ", ".join(argument.name for argument in signature.arguments)
            yield place, f"{_shown(fact)} has {number} argument{'s' * (number != 1)}, give {expected}"
            continue
        for value, argument in zip(fact.arguments, signature.arguments, strict=True):
            fault = _find_fault(value, argument, declared.get(value, (place, "")), place)
            if fault and argument.is_entity:
                fault = None if value in known or (argument.kind, value) in told else fault
                told.add((argument.kind, value))
            if fault:
                yield place, f"{_shown(fact)} {fault}"


def _find_fault(value: Value, argument: Argument, declared: tuple[int, str], place: int) -> str | None:
    """What is wrong with an argument of the fact at a place; declared: place and kind of the entity of this name."""
    if not isinstance(value, str) and not abs(value) <= float_info.max:
        return f"has no finite {argument.name}, give a number of the size of floats"
    if argument.kind == PROPERTY:
        return None
    if isinstance(value, float):
        return f"has the identifier {value}, give an atom or a whole number"
    first, kind = declared
    if argument.kind == SELF:
        return "declares an entity again, give each its own identifier" if first != place else None
    return (
        f"names no {argument.kind}, add the fact {_shown(Fact(argument.kind, (value,)))}"
        if kind != argument.kind
        else None
    )


def _declare_entities(interpretation: Interpretation, named: Mapping[str, Signature]) -> dict[Value, tuple[int, str]]:
    """Place and relation of the first fact that declares an identifier."""
    declared: dict[Value, tuple[int, str]] = {}
    for place, fact in enumerate(interpretation.facts):
        signature = named.get(fact.relation)
        if signature and signature.self_place is not None and len(fact.arguments) == len(signature.arguments):
            declared.setdefault(fact.arguments[signature.self_place], (place, fact.relation))
    return declared


def _standard_value(value: object, relation: str) -> Value:
    """The value as str, int or float of Python."""
    if isinstance(value, str) and not _NO_TEXT.search(value):
        return str(value)
    # Truth values are no numbers here, though Python says so of its own.
    if not isinstance(value, bool):
        if isinstance(value, Integral):
            return int(value)
        if isinstance(value, Real):
            return float(value)
    raise RelationError(f"a fact of {_shown(relation)} has the argument {_shown(repr(value))}, give text or a number")


def _check_names(what: str, *names: str) -> None:
    for name in names:
        if not isinstance(name, str) or not _PLAIN_ATOM.fullmatch(name):
            raise RelationError(f"{what} has the name {name!r}, give letters, digits and _, with a small letter first")


def _shown(value: object) -> str:
    """A fact or name as messages show it: on one line, not endless."""
    text = write_term(value) if isinstance(value, str | int | float) else str(value)
    return text if len(text) <= MAX_TEXT_SHOWN else f"{text[:MAX_TEXT_SHOWN]}…"


def _of(entity: str, name: str, *properties: str, entity_name: str, intensional: bool = False) -> Signature:
    arguments = (Argument(entity_name, entity), *map(Argument, properties))
    return Signature(name, arguments, intensional=intensional)


def _between(entity: str, name: str, initial: str, *, intensional: bool = False) -> Signature:
    arguments = (Argument(f"{initial}1", entity), Argument(f"{initial}2", entity))
    return Signature(name, arguments, intensional=intensional, unordered=True)


BUILDING_TYPE = Signature("buildingtype", (Argument("buildingtype"),))

# The measures of the real files, by their names there, "betwenness" too.
MEASURES = (
    "area",
    "perimeter",
    "aoverp",
    "adcs",
    "ff",
    "circularity",
    "normalcirc",
    "andcs",
    "betwenness",
    "closeness",
)

FLOOR_SIGNATURES: tuple[Signature, ...] = (
    Signature("room", (Argument("room_id", SELF),)),
    BUILDING_TYPE,
    *(_of("room", name, name, entity_name="room_id") for name in (*MEASURES, "doors")),
    _of("room", "entrance", entity_name="room_id"),
    _of("room", "partial", entity_name="room_id"),
    _between("room", "connected", "r"),
    _between("room", "sharedwall", "r"),
    _of("room", "label", "label", entity_name="room_id"),
    _of("room", "iscorr", entity_name="room_id", intensional=True),
    _between("room", "aligned", "r", intensional=True),
    _between("room", "symmetric", "r", intensional=True),
)

# Listing 6.1 prints iscorr(room_id::room), but has no entity of this name.
LISTING_SIGNATURES: tuple[Signature, ...] = (
    BUILDING_TYPE,
    Signature("space", (Argument("space_id", SELF),)),
    _between("space", "connected", "s"),
    *(_of("space", name, name, entity_name="space_id") for name in ("label", "area", "perimeter")),
    _of("space", "iscorr", entity_name="room_id", intensional=True),
)
