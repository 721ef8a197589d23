"""Interpretations: the facts that hold on one floor, and the signatures of these facts.

The entity/relationship data of kLog (thesis, section 6.1.2; Frasconi et al., 2014). An entity is an identifier; a fact
relates entities and properties; without a fact, a relation does not hold (closed world).
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

# Faults in a message, and characters of a fact or name in it.
MAX_FAULTS = 10
MAX_TEXT_LENGTH = 100
_PLAIN_ATOM = re.compile(r"[a-z][A-Za-z0-9_]*")
_NO_TEXT = re.compile("[\ud800-\udfff]")
_ESCAPES = str.maketrans({"\\": r"\\", "'": r"\'", "\n": r"\n", "\t": r"\t", "\r": r"\r"})


@dataclass(frozen=True)
class Argument:
    """An argument of a signature.

    kind: "self", the identifier of the entity that the fact declares; "property", an atom or a number; or the name of
        the signature whose entity it names.
    Raises RelationError if the name or the kind is not an atom of lower-case letters.
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
    """The form of the facts of one relation; as text it is the declaration of Listing 6.1.

    intensional: whether the facts follow from others instead of being observed.
    unordered: whether the entities are interchangeable: connected(a, b) and connected(b, a) are one fact.
    Raises RelationError for names that are not atoms, no arguments or repeated ones, two of kind "self", and unordered
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
        argument_kinds = [argument.kind for argument in self.arguments]
        related = [argument.kind for argument in self.arguments if argument.kind not in (SELF, PROPERTY)]
        if not names or len(set(names)) < len(names):
            raise RelationError(f"{what} has the arguments {', '.join(names) or 'none'}, give one or more, each once")
        if argument_kinds.count(SELF) > 1:
            raise RelationError(f"{what} has more than one argument of kind self, an entity has one identifier")
        if self.unordered and (len(related) < 2 or len(set(related)) > 1):
            raise RelationError(f"{what} is unordered, give it two or more arguments of one kind of entity")

    @cached_property
    def self_index(self) -> int | None:
        """Index of the argument of kind "self", the identifier of the entity that a fact declares; None without one."""
        return next((index for index, argument in enumerate(self.arguments) if argument.kind == SELF), None)

    def standard_arguments(self, arguments: Sequence[Value]) -> tuple[Value, ...]:
        """The canonical arguments of a fact: entities are sorted if they are interchangeable."""
        if not self.unordered:
            return tuple(arguments)
        is_entity = [argument.is_entity for argument in self.arguments]
        entities = (value for value, entity in zip(arguments, is_entity, strict=True) if entity)
        ordered = iter(sorted(entities, key=write_term))
        return tuple(next(ordered) if entity else value for value, entity in zip(arguments, is_entity, strict=True))

    def __str__(self) -> str:
        return self.declare()

    def declare(self, *, role: str = "") -> str:
        """The declaration; role: of all interchangeable entities, by which kLog marks them."""
        level = "intensional" if self.intensional else "extensional"
        suffix = f"@{role}" if role and self.unordered else ""
        arguments = [f"{argument.name}{suffix * argument.is_entity}::{argument.kind}" for argument in self.arguments]
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
    """The facts that hold on a floor, in their original order, with repetitions."""

    name: str
    facts: tuple[Fact, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "facts", tuple(self.facts))
        if not isinstance(self.name, str) or _NO_TEXT.search(self.name):
            raise RelationError(f"an interpretation has the name {self.name!r}, give text")

    def facts_of(self, relation: str) -> tuple[Fact, ...]:
        """The facts of a relation."""
        return tuple(fact for fact in self.facts if fact.relation == relation)

    def entities(self, signature: Signature) -> tuple[Value, ...]:
        """The identifiers that the facts of a signature declare."""
        index = signature.self_index
        if index is None:
            return ()
        return tuple(fact.arguments[index] for fact in self.facts_of(signature.name))

    def without(self, *relations: str) -> Interpretation:
        """The interpretation without the facts of some relations, such as the target of learning."""
        return Interpretation(self.name, tuple(fact for fact in self.facts if fact.relation not in relations))


def write_term(value: Value) -> str:
    """A value in the syntax of Prolog: atoms in quotes if necessary, numbers exact and as short as possible."""
    if not isinstance(value, str):
        return repr(value)
    if _PLAIN_ATOM.fullmatch(value):
        return value
    escaped = value.translate(_ESCAPES)
    return "'" + "".join(c if c.isprintable() else f"\\x{ord(c):x}\\" for c in escaped) + "'"


def by_name(signatures: Iterable[Signature]) -> Mapping[str, Signature]:
    """Signatures by their names.

    Raises RelationError that lists the names of several different signatures.
    """
    named: dict[str, Signature] = {}
    repeated = {each.name for each in signatures if named.setdefault(each.name, each) != each}
    if repeated:
        raise RelationError(f"signatures {', '.join(sorted(repeated))} occur with two meanings, rename or drop one")
    return named


def find_faults(interpretation: Interpretation, signatures: Iterable[Signature]) -> list[str]:
    """Messages about the facts that contradict the signatures, in the order of the facts.

    They are about unknown relations and undeclared entities, each once; wrong numbers of arguments; entities declared
    twice; identifiers that are neither atoms nor integers; numbers that are not finite.
    """
    return [fault for _, fault in locate_faults(interpretation, signatures)]


def check_interpretation(interpretation: Interpretation, signatures: Iterable[Signature]) -> None:
    """Raise RelationError, with the faults in one line, if an interpretation contradicts the signatures."""
    faults = find_faults(interpretation, signatures)
    if faults:
        text = "; ".join(faults[:MAX_FAULTS])
        more = len(faults) - MAX_FAULTS
        text += f"; and {more} more" if more > 0 else ""
        raise RelationError(f"interpretation {_shorten(interpretation.name)}: {text}")


def locate_faults(
    interpretation: Interpretation, signatures: Iterable[Signature], *, assumed: Set[Value] = frozenset()
) -> Iterator[tuple[int, str]]:
    """The faults of find_faults, each with the index of its fact.

    assumed: entities that count as declared, as any kind.
    """
    named = by_name(signatures)
    declared = _declare_entities(interpretation, named)
    reported: set[tuple[str, Value]] = set()
    for index, fact in enumerate(interpretation.facts):
        signature = named.get(fact.relation)
        if signature is None:
            if ("", fact.relation) not in reported:
                yield index, f"{_shorten(fact)} is of a relation without a signature, declare it or leave it out"
            reported.add(("", fact.relation))
            continue
        if len(signature.arguments) != len(fact.arguments):
            number, expected = len(fact.arguments), ", ".join(argument.name for argument in signature.arguments)
            yield index, f"{_shorten(fact)} has {number} argument{'s' * (number != 1)}, give {expected}"
            continue
        for value, argument in zip(fact.arguments, signature.arguments, strict=True):
            fault = _find_fault(value, argument, declared.get(value, (index, "")), index)
            if fault and argument.is_entity:
                fault = None if value in assumed or (argument.kind, value) in reported else fault
                reported.add((argument.kind, value))
            if fault:
                yield index, f"{_shorten(fact)} {fault}"


def _find_fault(value: Value, argument: Argument, declared: tuple[int, str], index: int) -> str | None:
    """The fault of a value in fact `index`, None without one; argument: the declaration of the value's argument.

    declared: index of the first fact that declares the value as an entity, and the kind of the entity.
    """
    if not isinstance(value, str) and not abs(value) <= float_info.max:
        return f"has no finite {argument.name}, give a number of the size of floats"
    if argument.kind == PROPERTY:
        return None
    if isinstance(value, float):
        return f"has the identifier {value}, give an atom or a whole number"
    first, declared_kind = declared
    if argument.kind == SELF:
        return "declares an entity again, give each its own identifier" if first != index else None
    return (
        f"names no {argument.kind}, add the fact {_shorten(Fact(argument.kind, (value,)))}"
        if declared_kind != argument.kind
        else None
    )


def _declare_entities(interpretation: Interpretation, named: Mapping[str, Signature]) -> dict[Value, tuple[int, str]]:
    """Index and relation of the first fact that declares each identifier."""
    declared: dict[Value, tuple[int, str]] = {}
    for index, fact in enumerate(interpretation.facts):
        signature = named.get(fact.relation)
        if signature and signature.self_index is not None and len(fact.arguments) == len(signature.arguments):
            declared.setdefault(fact.arguments[signature.self_index], (index, fact.relation))
    return declared


def _standard_value(value: object, relation: str) -> Value:
    """The value as str, int or float of Python; raises RelationError for any other type."""
    if isinstance(value, str) and not _NO_TEXT.search(value):
        return str(value)
    # bool is a subclass of int, but not a number here.
    if not isinstance(value, bool):
        if isinstance(value, Integral):
            return int(value)
        if isinstance(value, Real):
            return float(value)
    raise RelationError(
        f"a fact of {_shorten(relation)} has the argument {_shorten(repr(value))}, give text or a number"
    )


def _check_names(what: str, *names: str) -> None:
    for name in names:
        if not isinstance(name, str) or not _PLAIN_ATOM.fullmatch(name):
            raise RelationError(f"{what} has the name {name!r}, give letters, digits and _, with a small letter first")


def _shorten(value: object) -> str:
    """A fact or name for a message: on one line, and not too long."""
    text = write_term(value) if isinstance(value, str | int | float) else str(value)
    return text if len(text) <= MAX_TEXT_LENGTH else f"{text[:MAX_TEXT_LENGTH]}…"


def _unary_signature(
    entity: str, name: str, *properties: str, entity_name: str, intensional: bool = False
) -> Signature:
    """The signature of a relation of one entity; entity: its kind. properties: names of the further arguments."""
    arguments = (Argument(entity_name, entity), *map(Argument, properties))
    return Signature(name, arguments, intensional=intensional)


def _binary_signature(entity: str, name: str, initial: str, *, intensional: bool = False) -> Signature:
    """The signature of a symmetric relation of two entities of a kind; their names are the initial with 1 and 2."""
    arguments = (Argument(f"{initial}1", entity), Argument(f"{initial}2", entity))
    return Signature(name, arguments, intensional=intensional, unordered=True)


BUILDING_TYPE = Signature("buildingtype", (Argument("buildingtype"),))

# Measures of rooms by their names in the authors' files, including the spelling "betwenness".
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
    *(_unary_signature("room", name, name, entity_name="room_id") for name in (*MEASURES, "doors")),
    _unary_signature("room", "entrance", entity_name="room_id"),
    _unary_signature("room", "partial", entity_name="room_id"),
    _binary_signature("room", "connected", "r"),
    _binary_signature("room", "sharedwall", "r"),
    _unary_signature("room", "label", "label", entity_name="room_id"),
    _unary_signature("room", "iscorr", entity_name="room_id", intensional=True),
    _binary_signature("room", "aligned", "r", intensional=True),
    _binary_signature("room", "symmetric", "r", intensional=True),
)

# Listing 6.1 prints iscorr(room_id::room), but declares no entity room.
LISTING_SIGNATURES: tuple[Signature, ...] = (
    BUILDING_TYPE,
    Signature("space", (Argument("space_id", SELF),)),
    _binary_signature("space", "connected", "s"),
    *(_unary_signature("space", name, name, entity_name="space_id") for name in ("label", "area", "perimeter")),
    _unary_signature("space", "iscorr", entity_name="room_id", intensional=True),
)
