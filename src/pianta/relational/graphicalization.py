"""Graphicalization: interpretations become bipartite graphs of entities and relations (thesis, section 6.1.2)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Self

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError, OptionError
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    PROPERTY,
    Argument,
    Fact,
    Interpretation,
    Signature,
    Value,
    by_name,
    check_interpretation,
    write_term,
)

# Numbers that agree in so many digits are the same: a turned floor has the areas of the floor but for rounding.
DIGITS = 9

Place = tuple[str, int]


class Graphicalizer:
    """Interpretations as graphs for a kernel such as `NeighborhoodPairs(edge_label="role")`.

    A node is a ground atom, one for all facts that say the same. The atom of an entity has its identifier for a key,
    that of a relation the relation and its arguments; an edge joins a relation to each entity that it names.
    Node attribute `label`: the relation and its properties, `area(3)`, never an identifier. Edge attribute `role`: the
    place of the entity among the arguments from 0, the same for entities that are interchangeable.

    bins: into how many parts of equal size the numbers of the training set are cut; a number becomes that of its bin.
    hidden: relations that are left out, such as the target of learning.
    share_values: a property is a node of its own that joins all facts of the relation that have it, as Fig. 6.1 joins
        spaces with the same label.
    signatures: what the interpretations must agree with.

    edges_: by relation and place of the argument, the bounds between the bins.
    Raises OptionError for no bins, and hidden relations that are unknown or entities.
    """

    def __init__(
        self,
        *,
        bins: int = 8,
        hidden: Iterable[str] = (),
        share_values: bool = False,
        signatures: Iterable[Signature] = FLOOR_SIGNATURES,
    ) -> None:
        self.bins = bins
        self.hidden = frozenset([hidden] if isinstance(hidden, str) else hidden)
        self.share_values = share_values
        self.signatures = by_name(signatures)
        if bins < 1:
            raise OptionError(f"bins is {bins}, give 1 or more")
        unknown = sorted(self.hidden - {name for name, of in self.signatures.items() if of.self_place is None})
        if unknown:
            raise OptionError(f"hidden has {', '.join(unknown)}, give relations of the signatures that are no entities")

    def fit(self, interpretations: Iterable[Interpretation]) -> Self:
        """Learn the bins of every property that is a number, so that each holds as many of the training set.

        Bins between equal numbers are one. Raises RelationError for facts that contradict the signatures.
        """
        numbers: dict[Place, list[float]] = {}
        for interpretation in interpretations:
            for signature, arguments in self._list_atoms(interpretation):
                for place, argument in enumerate(signature.arguments):
                    value = arguments[place]
                    if argument.kind == PROPERTY and not isinstance(value, str):
                        numbers.setdefault((signature.name, place), []).append(round_number(value))
        inner = np.linspace(0, 1, self.bins + 1)[1:-1]
        self.edges_ = {place: np.unique(np.quantile(values, inner)) for place, values in numbers.items()}
        return self

    def transform(self, interpretations: Iterable[Interpretation]) -> list[nx.Graph]:
        """The graph of each interpretation, entities first, with its name as graph attribute `name`.

        A property that was no number in the training set has one bin. Raises ModelError before `fit`, RelationError
        for facts that contradict the signatures.
        """
        if not hasattr(self, "edges_"):
            raise ModelError("the bins of the Graphicalizer are not known, call fit with the training set first")
        return [self._draw(interpretation) for interpretation in interpretations]

    def fit_transform(self, interpretations: Iterable[Interpretation]) -> list[nx.Graph]:
        """Learn the bins from interpretations and give their graphs."""
        interpretations = list(interpretations)
        return self.fit(interpretations).transform(interpretations)

    def _list_atoms(self, interpretation: Interpretation) -> Iterator[tuple[Signature, tuple[Value, ...]]]:
        """Signature and arguments of the facts that are not hidden, once where several say the same."""
        check_interpretation(interpretation, self.signatures.values())
        seen: set[Fact] = set()
        for fact in interpretation.facts:
            signature = self.signatures[fact.relation]
            atom = Fact(fact.relation, signature.standard_arguments(fact.arguments))
            if fact.relation not in self.hidden and atom not in seen:
                seen.add(atom)
                yield signature, atom.arguments

    def _draw(self, interpretation: Interpretation) -> nx.Graph:
        graph = nx.Graph(name=interpretation.name)
        entities_first = sorted(self._list_atoms(interpretation), key=lambda atom: atom[0].self_place is None)
        for signature, arguments in entities_first:
            self._draw_atom(graph, signature, arguments)
        return graph

    def _draw_atom(self, graph: nx.Graph, signature: Signature, arguments: tuple[Value, ...]) -> None:
        own = signature.self_place
        node = (signature.name, *arguments) if own is None else arguments[own]
        placed = list(enumerate(zip(signature.arguments, arguments, strict=True)))
        properties = [
            (place, of, self._name_value(signature, place, value))
            for place, (of, value) in placed
            if of.kind == PROPERTY
        ]
        shown = [] if self.share_values else [name for *_, name in properties]
        graph.add_node(node, label=f"{signature.name}({','.join(shown)})" if shown else signature.name)
        if self.share_values:
            self._join_values(graph, node, signature, properties)
        roles: dict[Value, list[int]] = {}
        entities = [(place, value) for place, (of, value) in placed if of.is_entity]
        for place, value in entities:
            roles.setdefault(value, []).append(entities[0][0] if signature.unordered else place)
        # A fact may name an entity twice, and an entity itself; an edge of a simple graph is there once.
        for value, places in roles.items():
            if value != node:
                graph.add_edge(node, value, role=places[0] if len(places) == 1 else tuple(places))

    def _join_values(
        self, graph: nx.Graph, node: object, signature: Signature, properties: Sequence[tuple[int, Argument, str]]
    ) -> None:
        for place, argument, name in properties:
            value_node = ("value of", signature.name, place, name)
            graph.add_node(value_node, label=f"{signature.name}.{argument.name}={name}")
            graph.add_edge(node, value_node, role=place)

    def _name_value(self, signature: Signature, place: int, value: Value) -> str:
        """An atom, or the number of the bin that a number is in: how many bounds it is above."""
        if isinstance(value, str):
            return write_term(value)
        edges: NDArray[np.float64] = self.edges_.get((signature.name, place), np.zeros(0))
        return str(np.searchsorted(edges, round_number(value)))


def round_number(value: float) -> float:
    """A number to nine significant digits."""
    return float(f"{value:.{DIGITS}g}")
