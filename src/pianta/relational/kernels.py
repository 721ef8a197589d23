"""How alike floors, or rooms with the floor around them, are as kLog sees them: NSPDK on graphs of facts.

Facts become a bipartite graph, numbers those of their bins, and NSPDK counts pairs of neighbourhoods in it (thesis,
section 6.1.2). A support vector machine learns from the Gram matrix.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, ClassVar, Self

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError, OptionError
from pianta.graphs.feature_counts import FeatureCounts
from pianta.graphs.neighborhood_pairs import NeighborhoodPairs
from pianta.relational.facts import FLOOR_SIGNATURES, Interpretation, Signature, Value, by_name, check_interpretation
from pianta.relational.graphicalization import Graphicalizer
from pianta.relational.interpretation import FLOOR_RELATIONS

if TYPE_CHECKING:
    from sklearn.svm import SVC


BINS, RADIUS, DISTANCE, COST = 8, 2, 4, 10.0
# What follows from the labels, so that it is hidden with them.
FROM_LABELS = "iscorr"
# V_n of section 5.2 by the names of the real files, and the doors between rooms.
ROOM_RELATIONS = tuple(
    relation
    for relation in FLOOR_RELATIONS
    if relation.signature.name not in ("buildingtype", "entrance", "partial", "sharedwall")
)


class RelationalKernel(ABC):
    """A kernel on interpretations: fit to known ones, compare others with them.

    target: the relation that is to be learnt, usual_target unless given; it is hidden from the kernel.
    signatures: what the interpretations must agree with. bins: into which the numbers of the known ones are cut.
    radius, distance: of NSPDK, in edges of the graph of facts; two rooms with a door between them are 2 apart.
    Raises OptionError for a target without a signature.
    """

    usual_target: ClassVar[str]
    hidden: ClassVar[tuple[str, ...]] = ()

    def __init__(
        self,
        *,
        target: str | None = None,
        signatures: Iterable[Signature] = FLOOR_SIGNATURES,
        bins: int = BINS,
        radius: int = RADIUS,
        distance: int = DISTANCE,
    ) -> None:
        self.target = target or self.usual_target
        self.signatures = by_name(signatures)
        self.bins = bins
        self.pairs = NeighborhoodPairs(radius=radius, distance=distance)
        self._check_target()

    def fit(self, known: Sequence[Interpretation], *, binned: Sequence[Interpretation] | None = None) -> Self:
        """Learn the bins, and keep the known interpretations.

        binned: the interpretations by whose numbers the bins are cut, the known ones unless given.
        Raises RelationError for facts that contradict the signatures.
        """
        hidden = {self.target, *(name for name in self.hidden if name in self.signatures)}
        graphicalizer = Graphicalizer(bins=self.bins, hidden=hidden, signatures=self.signatures.values())
        self.graphicalizer_ = graphicalizer.fit(known if binned is None else binned)
        self.pairs.fit_counts(self._count(known))
        return self

    def compare(self, others: Sequence[Interpretation] | None = None) -> Floats:
        """Normalised Gram matrix, a column for each that is known, a row for each other, or known where none are given.

        Raises ModelError before `fit`, RelationError for facts that contradict the signatures.
        """
        if not hasattr(self, "graphicalizer_"):
            raise ModelError("nothing is known to compare with, call fit first")
        return self.pairs.compare_counts(None if others is None else self._count(others))

    def check(self, interpretations: Iterable[Interpretation]) -> None:
        """Raise RelationError for facts that contradict the signatures."""
        for each in interpretations:
            check_interpretation(each, self.signatures.values())

    def _check_target(self) -> None:
        if self.target not in self.signatures:
            raise OptionError(f"target is {self.target!r}, give one of {', '.join(self.signatures)}")

    @abstractmethod
    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        """The features of what is compared."""

    def _draw(self, interpretations: Sequence[Interpretation]) -> list[nx.Graph]:
        return self.graphicalizer_.transform(interpretations)


class FloorKernel(RelationalKernel):
    """How alike whole floors are: all pairs of neighbourhoods in their graphs, a row for each floor."""

    usual_target = "buildingtype"

    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        return self.pairs.count_features(self._draw(interpretations))


class RoomKernel(RelationalKernel):
    """How alike rooms are, each on its floor: the pairs of neighbourhoods that a room's node is in.

    Rooms are the entities that the target is about, whatever they are called; a row for each, floor by floor.
    Raises OptionError for a target that is about no entity.
    """

    usual_target = "label"
    hidden = (FROM_LABELS,)

    def _check_target(self) -> None:
        super()._check_target()
        if not self._list_kinds():
            raise OptionError(f"target is {self.target!r}, which is about no entity, give a relation of rooms")

    def _list_kinds(self) -> list[str]:
        """Of the entities that the target is about."""
        return [argument.kind for argument in self.signatures[self.target].arguments if argument.is_entity]

    @property
    def room(self) -> Signature:
        """The signature of rooms."""
        return self.signatures[self._list_kinds()[0]]

    def list_rooms(self, interpretation: Interpretation) -> tuple[Value, ...]:
        """The identifiers of the rooms of a floor, in the order of the rows."""
        return interpretation.entities(self.room)

    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        graphs = self._draw(interpretations)
        return self.pairs.count_rooted_features(graphs, [self.list_rooms(each) for each in interpretations])


def fit_svm(gram: Floats, truth: Sequence[str], *, cost: float = COST) -> SVC:
    """A support vector machine on a Gram matrix, shape (n, n), and the label of each.

    Raises ModelError for fewer than two labels.
    """
    from sklearn.svm import SVC

    labels = sorted(set(truth))
    if len(labels) < 2:
        raise ModelError(f"nothing is to be told apart: all labels are {labels}, give two at least")
    return SVC(kernel="precomputed", C=cost, break_ties=True).fit(gram, list(truth))


def decide(machine: SVC, gram: Floats, labels: Sequence[str]) -> Floats:
    """Decision values for labels, shape (n, labels), of which the highest is the decision; gram: shape (n, known).

    A label that the machine has not learned has the lowest value of the row, less one.
    """
    # scikit-learn refuses to decide on nothing.
    if len(gram) == 0:
        return np.zeros((0, len(labels)))
    values = np.asarray(machine.decision_function(gram)).reshape(len(gram), -1)
    if values.shape[1] == 1:
        values = np.column_stack([-values, values])
    lowest = values.min(axis=1, keepdims=True, initial=0.0) - 1
    decided = np.repeat(lowest, len(labels), axis=1)
    for column, label in enumerate(machine.classes_):
        decided[:, list(labels).index(label)] = values[:, column]
    return decided
