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

# Significant digits of numbers, so that a rotated floor has the same areas in spite of rounding.
DIGITS = 9

# A relation, and the index of an argument.
ArgumentKey = tuple[str, int]


class Graphicalizer:
    """Interpretations as graphs for a kernel such as `NeighborhoodPairs(edge_label="role")`.

    A node is a ground atom, one for all equal facts. The key of an entity is its identifier, that of a relation the
    relation and its arguments; an edge joins a relation to each of its entities.
    Node attribute `label`: the relation and its properties, `area(3)`, never an identifier. Edge attribute `role`: the
    index of the entity among the arguments, the same for interchangeable entities.

    bins: number of quantile bins of the numbers of the training set; a number is replaced by that of its bin.
    hidden: relations that are left out, such as the target of learning.
    share_values: whether a property is a node of its own that joins all facts of the relation with this value, as
        Fig. 6.1 joins spaces with the same label.
    signatures: those of the interpretations.

    edges_: by relation and index of the argument, the bounds between the bins.
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
        unknown = sorted(self.hidden - {name for name, each in self.signatures.items() if each.self_index is None})
        if unknown:
            raise OptionError(f"hidden has {', '.join(unknown)}, give relations of the signatures that are no entities")

    def fit(self, interpretations: Iterable[Interpretation]) -> Self:
        """Learn the quantile bins of every property that is a number.

        Bins between equal numbers are merged. Raises RelationError for facts that contradict the signatures.
        """
        numbers: dict[ArgumentKey, list[float]] = {}
        for interpretation in interpretations:
            for signature, arguments in self._list_atoms(interpretation):
                for index, (argument, value) in enumerate(zip(signature.arguments, arguments, strict=True)):
                    if argument.kind == PROPERTY and not isinstance(value, str):
                        numbers.setdefault((signature.name, index), []).append(round_number(value))
        inner = np.linspace(0, 1, self.bins + 1)[1:-1]
        self.edges_ = {key: np.unique(np.quantile(values, inner)) for key, values in numbers.items()}
        return self

    def transform(self, interpretations: Iterable[Interpretation]) -> list[nx.Graph]:
        """The graph of each interpretation, entities first, with its name as graph attribute `name`.

        A property without numbers in the training set has one bin. Raises ModelError before `fit`, RelationError for
        facts that contradict the signatures.
        """
        if not hasattr(self, "edges_"):
            raise ModelError("the Graphicalizer has no bins, call fit with the training set first")
        return [self._draw(interpretation) for interpretation in interpretations]

    def fit_transform(self, interpretations: Iterable[Interpretation]) -> list[nx.Graph]:
        """Learn the bins from interpretations and give their graphs."""
        interpretations = list(interpretations)
        return self.fit(interpretations).transform(interpretations)

    def _list_atoms(self, interpretation: Interpretation) -> Iterator[tuple[Signature, tuple[Value, ...]]]:
        """Signature and arguments of the facts that are not hidden, equal facts once."""
        check_interpretation(interpretation, self.signatures.values())
        atoms: set[Fact] = set()
        for fact in interpretation.facts:
            signature = self.signatures[fact.relation]
            atom = Fact(fact.relation, signature.standard_arguments(fact.arguments))
            if fact.relation not in self.hidden and atom not in atoms:
                atoms.add(atom)
                yield signature, atom.arguments

    def _draw(self, interpretation: Interpretation) -> nx.Graph:
        graph = nx.Graph(name=interpretation.name)
        entities_first = sorted(self._list_atoms(interpretation), key=lambda atom: atom[0].self_index is None)
        for signature, arguments in entities_first:
            self._draw_atom(graph, signature, arguments)
        return graph

    def _draw_atom(self, graph: nx.Graph, signature: Signature, arguments: tuple[Value, ...]) -> None:
        """Add the node of a fact, nodes of its values if these are shared, and edges to its entities, with roles."""
        own = signature.self_index
        node = (signature.name, *arguments) if own is None else arguments[own]
        indexed = list(enumerate(zip(signature.arguments, arguments, strict=True)))
        properties = [
            (index, argument, self._name_value(signature, index, value))
            for index, (argument, value) in indexed
            if argument.kind == PROPERTY
        ]
        names = [] if self.share_values else [name for *_, name in properties]
        graph.add_node(node, label=f"{signature.name}({','.join(names)})" if names else signature.name)
        if self.share_values:
            self._join_values(graph, node, signature, properties)
        roles: dict[Value, list[int]] = {}
        entities = [(index, value) for index, (argument, value) in indexed if argument.is_entity]
        for index, value in entities:
            roles.setdefault(value, []).append(entities[0][0] if signature.unordered else index)
        # A fact may name an entity twice, or itself; a simple graph has one edge for both, and no loops.
        for value, indices in roles.items():
            if value != node:
                graph.add_edge(node, value, role=indices[0] if len(indices) == 1 else tuple(indices))

    def _join_values(
        self, graph: nx.Graph, node: object, signature: Signature, properties: Sequence[tuple[int, Argument, str]]
    ) -> None:
        for index, argument, name in properties:
            value_node = ("value of", signature.name, index, name)
            graph.add_node(value_node, label=f"{signature.name}.{argument.name}={name}")
            graph.add_edge(node, value_node, role=index)

    def _name_value(self, signature: Signature, index: int, value: Value) -> str:
        """An atom as it is; for a number, the number of its bin."""
        if isinstance(value, str):
            return write_term(value)
        edges: NDArray[np.float64] = self.edges_.get((signature.name, index), np.zeros(0))
        return str(np.searchsorted(edges, round_number(value)))


def round_number(value: float) -> float:
    """A number rounded to DIGITS significant digits."""
    return float(f"{value:.{DIGITS}g}")
